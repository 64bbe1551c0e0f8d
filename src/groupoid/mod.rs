//! Groupoids and Lie groupoids: the abstraction, the instances, their Lie algebroids, and the Poisson groupoid.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/groupoid.md"))]

mod action;
mod algebroid;
mod atiyah;
pub mod calculus;
mod dense;
mod lie;
mod manifold;
mod poisson;
mod trivial;

pub use action::ActionGroupoid;
pub use algebroid::{LieAlgebroid, Lowered, Section, section_bracket};
pub use atiyah::AtiyahGroupoid;
pub use dense::DenseGroup;
pub use lie::{Field, LieGroupoid, Tangent, bracket_of_fields, commutator};
pub use manifold::{DenseSpace, Manifold};
pub use poisson::{lie_poisson_bivector, poisson_bivector};
pub use trivial::{Arrow, TrivialGroupoid};

use std::fmt::Debug;

/// A product was asked for where there is none: β(g₁) ≠ α(g₂).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "not composable: the target {target:?} of the first element is not the source {source_of_second:?} of the second"
)]
pub struct NotComposable<B: Debug> {
    /// β(g₁).
    pub target: B,
    /// α(g₂).
    pub source_of_second: B,
}

/// A groupoid with elements `Element` over a base with points `Base`.
///
/// ```
/// use euler_poincare::group::So3;
/// use euler_poincare::groupoid::{Arrow, Axiom, DenseGroup, DenseSpace, Groupoid, TrivialGroupoid};
/// use nalgebra::{DMatrix, DVector};
///
/// // B×G×B: arrows (x, U, y), here over G.
/// let so3 = DenseGroup::of(&So3::<f64>::new());
/// let one: DMatrix<f64> = so3.identity();
/// let u = DMatrix::from_row_slice(3, 3, &[0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
/// let gauge = TrivialGroupoid::<_, f64>::gauge(so3);
/// let arrow = Arrow { source: one.clone(), group: u.clone(), target: u.clone() };
/// assert_eq!((gauge.source(&arrow), gauge.target(&arrow)), (one, u));
///
/// // Pairs of points of the plane: (q, r)(r, s) = (q, s), and no other product.
/// let pairs = TrivialGroupoid::<_, f64>::pairs(DenseSpace { dimension: 2 });
/// let pair = |x: [f64; 2], y: [f64; 2]| {
///     let [source, target] = [x, y].map(|x| DVector::from_row_slice(&x));
///     Arrow { source, group: DMatrix::zeros(0, 0), target }
/// };
/// let (a, b, c) = (pair([0.0, 1.0], [2.0, 3.0]), pair([2.0, 3.0], [4.0, 5.0]), pair([4.0, 5.0], [6.0, 7.0]));
/// assert_eq!((pairs.compose(&a, &b), pairs.compose(&a, &c).is_err()), (Ok(pair([0.0, 1.0], [4.0, 5.0])), true));
///
/// // Every axiom can be measured, on any groupoid.
/// type Pair = Arrow<DVector<f64>, DMatrix<f64>>;
/// let distance = |g: &Pair, h: &Pair| (&g.source - &h.source).norm() + (&g.target - &h.target).norm();
/// for axiom in Axiom::ALL {
///     assert_eq!(axiom.defect(&pairs, [&a, &b, &c], distance), 0.0, "{}", axiom.statement());
/// }
/// ```
pub trait Groupoid {
    /// g, an arrow.
    type Element: Clone + Debug;
    /// x, a point of the base; equality is exact.
    type Base: Clone + Debug + PartialEq;

    /// α(g).
    fn source(&self, g: &Self::Element) -> Self::Base;

    /// β(g).
    fn target(&self, g: &Self::Element) -> Self::Base;

    /// ε(x).
    fn unit(&self, x: &Self::Base) -> Self::Element;

    /// ι(g) = g⁻¹, or `None` where g is not an element (a singular matrix).
    fn inverse(&self, g: &Self::Element) -> Option<Self::Element>;

    /// ν(g₁, g₂) = g₁g₂ for a pair that is composable; call [`Groupoid::compose`], which sees to that.
    fn product(&self, first: &Self::Element, second: &Self::Element) -> Self::Element;

    /// g₁g₂.
    ///
    /// # Errors
    /// β(g₁) ≠ α(g₂), or one of them is NaN.
    fn compose(
        &self,
        first: &Self::Element,
        second: &Self::Element,
    ) -> Result<Self::Element, NotComposable<Self::Base>> {
        let (target, source_of_second) = (self.target(first), self.source(second));
        if target == source_of_second {
            Ok(self.product(first, second))
        } else {
            Err(NotComposable { target, source_of_second })
        }
    }
}

/// The axioms of a groupoid, for a chain of three elements with β(g₁) = α(g₂) and β(g₂) = α(g₃).
///
/// Source: Martín de Diego and Sato Martín de Almagro 2019, Definition 4.1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Axiom {
    /// α(g₁g₂) = α(g₁) and β(g₁g₂) = β(g₂).
    ProductEnds,
    /// g₁(g₂g₃) = (g₁g₂)g₃.
    Associativity,
    /// α(ε(x)) = x = β(ε(x)), with x = α(g₁).
    UnitEnds,
    /// ε(α(g₁)) g₁ = g₁.
    LeftUnit,
    /// g₁ ε(β(g₁)) = g₁.
    RightUnit,
    /// α(g₁⁻¹) = β(g₁) and β(g₁⁻¹) = α(g₁).
    InverseEnds,
    /// g₁⁻¹ g₁ = ε(β(g₁)).
    LeftInverse,
    /// g₁ g₁⁻¹ = ε(α(g₁)).
    RightInverse,
}

impl Axiom {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::ProductEnds,
        Self::Associativity,
        Self::UnitEnds,
        Self::LeftUnit,
        Self::RightUnit,
        Self::InverseEnds,
        Self::LeftInverse,
        Self::RightInverse,
    ];

    /// The formula.
    pub const fn statement(self) -> &'static str {
        match self {
            Self::ProductEnds => "α(g₁g₂) = α(g₁) and β(g₁g₂) = β(g₂)",
            Self::Associativity => "g₁(g₂g₃) = (g₁g₂)g₃",
            Self::UnitEnds => "α(ε(x)) = x = β(ε(x))",
            Self::LeftUnit => "ε(α(g))g = g",
            Self::RightUnit => "gε(β(g)) = g",
            Self::InverseEnds => "α(g⁻¹) = β(g) and β(g⁻¹) = α(g)",
            Self::LeftInverse => "g⁻¹g = ε(β(g))",
            Self::RightInverse => "gg⁻¹ = ε(α(g))",
        }
    }

    /// The distance between the two sides; infinite where points of the base differ, or a side does not exist.
    pub fn defect<G: Groupoid + ?Sized>(
        self,
        groupoid: &G,
        chain: [&G::Element; 3],
        distance: impl Fn(&G::Element, &G::Element) -> f64,
    ) -> f64 {
        self.sides(groupoid, chain, distance).unwrap_or(f64::INFINITY)
    }

    fn sides<G: Groupoid + ?Sized>(
        self,
        q: &G,
        [g1, g2, g3]: [&G::Element; 3],
        distance: impl Fn(&G::Element, &G::Element) -> f64,
    ) -> Option<f64> {
        let (source, target) = (q.source(g1), q.target(g1));
        let product = |a: &G::Element, b: &G::Element| q.compose(a, b).ok();
        let same = |ends: bool| ends.then_some(0.0);
        match self {
            Self::ProductEnds => {
                let g = product(g1, g2)?;
                same(q.source(&g) == source && q.target(&g) == q.target(g2))
            }
            Self::Associativity => Some(distance(&product(g1, &product(g2, g3)?)?, &product(&product(g1, g2)?, g3)?)),
            Self::UnitEnds => {
                let unit = q.unit(&source);
                same(q.source(&unit) == source && q.target(&unit) == source)
            }
            Self::LeftUnit => Some(distance(&product(&q.unit(&source), g1)?, g1)),
            Self::RightUnit => Some(distance(&product(g1, &q.unit(&target))?, g1)),
            Self::InverseEnds => {
                let inverse = q.inverse(g1)?;
                same(q.source(&inverse) == target && q.target(&inverse) == source)
            }
            Self::LeftInverse => Some(distance(&product(&q.inverse(g1)?, g1)?, &q.unit(&target))),
            Self::RightInverse => Some(distance(&product(g1, &q.inverse(g1)?)?, &q.unit(&source))),
        }
    }
}
