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
mod pair;
mod poisson;
mod trivial;

pub use action::{Action, ActionGroupoid, Coadjoint, Linear};
pub use algebroid::{LieAlgebroid, Lowered, Section, section_bracket};
pub use atiyah::{AtiyahGroupoid, Fibred, PrincipalBundle, ProductBundle, SphereFrames, Turn};
pub use dense::DenseGroup;
pub use lie::{
    Field, LieGroupoid, at_unit, bracket_of_fields, commutator, left_field, left_translation, push_inverse, push_left,
    push_product, push_right, push_source, push_target, push_unit, right_field, right_translation,
};
pub use manifold::{DenseSpace, Group, GroupManifold, Manifold, Singleton, Space, Sphere};
pub use pair::{ManifoldPair, PairGroupoid};
pub use poisson::{
    Bivector, Differential, Phase, PhaseFunction, bracket, differential, generator_brackets, lie_poisson_bivector,
    poisson_bivector,
};
pub use trivial::{Arrow, GaugeGroupoid, PointGroupoid, PoissonGroupoid, TrivialGroupoid};

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
/// use euler_poincare::algebra::{Covector, Matrix, Vector};
/// use euler_poincare::group::So3;
/// use euler_poincare::groupoid::{
///     Arrow, Axiom, GaugeGroupoid, Group, GroupManifold, Groupoid, ManifoldPair, Manifold, NotComposable, PairGroupoid,
///     PointGroupoid, PoissonGroupoid, Singleton, Space, Sphere, TrivialGroupoid,
/// };
/// use euler_poincare::retraction::{CayleySo3, Retraction};
///
/// // Pairs (q, r): (q, r)(r, s) = (q, s), and no other product.
/// let pairs = PairGroupoid::<i32>::new();
/// assert_eq!(pairs.compose(&(1, 2), &(2, 3)), Ok((1, 3)));
/// let refused: Result<_, NotComposable<i32>> = pairs.compose(&(1, 2), &(3, 4));
/// assert_eq!(refused.unwrap_err().target, 2);
///
/// // B×G×B: arrows (x, U, y), over a point, over G, and over g*.
/// let so3 = So3::<f64>::new();
/// let turn = |x: f64| CayleySo3::<f64>::new().tau(&Vector::<f64, 3>::new(x, 0.25, 0.5));
/// let (one, u) = (Matrix::<f64, 3>::identity(), turn(0.5)?);
/// let point: PointGroupoid<'_, So3<f64>, f64, 3, 3> = PointGroupoid::new(&so3);
/// assert_eq!(point.unit(&()).group, one);
/// let gauge: GaugeGroupoid<'_, So3<f64>, f64, 3, 3> = GaugeGroupoid::new(&so3);
/// let arrow = Arrow { source: one, group: u, target: u };
/// assert_eq!((gauge.source(&arrow), gauge.target(&arrow)), (one, u));
/// let poisson: PoissonGroupoid<'_, So3<f64>, f64, 3, 3> = PoissonGroupoid::new(&so3);
/// let mu = Covector::<f64, 3>::new(1.0, 2.0, 3.0);
/// assert_eq!(poisson.target(&poisson.unit(&mu)), mu);
/// // The same with any base and any group: trivial groupoids.
/// let over_space = TrivialGroupoid::<_, _, f64>::over(Space::<3>, GroupManifold::<_, 3, 3>(&so3));
/// assert_eq!(over_space.unit(&mu), poisson.unit(&mu));
/// let over_point = TrivialGroupoid::<_, _, f64>::over(Singleton, GroupManifold::<_, 3, 3>(&so3));
/// assert_eq!(over_point.unit(&()), point.unit(&()));
///
/// /// The number of fields that span the tangent spaces, and the dimension of the group.
/// fn dimensions<M: Manifold<f64>, H: Group<f64>>(base: &M, group: &H) -> (usize, usize) {
///     (base.dimension(), group.adjoint(&group.identity()).map_or(0, |ad| ad.nrows()))
/// }
/// assert_eq!(dimensions(&Sphere, &GroupManifold::<_, 3, 3>(&so3)), (3, 3));
///
/// // Every axiom can be measured, on any groupoid: here on pairs of points of the sphere.
/// type Pair = (Vector<f64, 3>, Vector<f64, 3>);
/// let distance = |g: &Pair, h: &Pair| (g.0 - h.0).norm() + (g.1 - h.1).norm();
/// let (a, b, c) = (Vector::<f64, 3>::x(), Vector::<f64, 3>::y(), Vector::<f64, 3>::z());
/// let sphere = ManifoldPair::<_, f64>::new(Sphere);
/// for axiom in Axiom::ALL {
///     assert_eq!(axiom.defect(&sphere, [&(a, b), &(b, c), &(c, a)], distance), 0.0, "{}", axiom.statement());
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
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
