//! Laws of one groupoid: the axioms on any [`Groupoid`] that a user writes, and fields and brackets where it is a
//! [`LieGroupoid`].
//!
//! A case holds numbers; the user's type makes a chain of three composable elements from them.
//!
//! ```
//! use euler_poincare::groupoid::PairGroupoid;
//! use euler_poincare::laws::own::groupoid::{Chains, OwnGroupoid};
//! use euler_poincare::laws::own::part;
//!
//! impl Chains for Points {
//!     type Real = f64;
//!     fn numbers(&self) -> usize {
//!         4
//!     }
//!     fn chain(&self, x: &[f64]) -> Option<[(f64, f64); 3]> {
//!         Some([(x[0], x[1]), (x[1], x[2]), (x[2], x[3])])
//!     }
//!     fn distance(&self, g: &(f64, f64), h: &(f64, f64)) -> f64 {
//!         (g.0 - h.0).abs().max((g.1 - h.1).abs())
//!     }
//! }
//! # use euler_poincare::groupoid::Groupoid;
//! # struct Points;
//! # impl Groupoid for Points {
//! #     type Element = (f64, f64);
//! #     type Base = f64;
//! #     fn source(&self, g: &(f64, f64)) -> f64 { g.0 }
//! #     fn target(&self, g: &(f64, f64)) -> f64 { g.1 }
//! #     fn unit(&self, x: &f64) -> (f64, f64) { (*x, *x) }
//! #     fn inverse(&self, g: &(f64, f64)) -> Option<(f64, f64)> { Some((g.1, g.0)) }
//! #     fn product(&self, g: &(f64, f64), h: &(f64, f64)) -> (f64, f64) { (g.0, h.1) }
//! # }
//! let report = part::run(OwnGroupoid::in_double(Points), 1, 4);
//! assert!(report.laws.iter().all(|law| law.broken.is_empty()));
//! ```

use super::super::algebroid::{self, LEFT_AT_SOURCE, NO_DERIVATIVES, Question, RIGHT_SIGN};
use super::super::instances::{
    ANCHOR_SIGN, ENDS_KEPT, INVERSE_KEEPS_U, Instance, Kind, PRODUCT_KEEPS_END, Planted as Spoilt, SECOND_INVERTED,
    STRUCTURE_SIGN, Second,
};
use super::super::precision::Measured;
use super::super::probe::Probe;
use super::group::misfit;
use super::lagrangian::list;
use super::part::{About, Missing, Pair, Precisions, Subject};
use super::values::{Points, Values};
use crate::groupoid::calculus::{constant, derivatives, infinitesimal, values};
use crate::groupoid::{
    Axiom, DenseGroup, Groupoid, LieAlgebroid, LieGroupoid, NotComposable, Singleton, TrivialGroupoid, at_unit,
    push_source,
};
use crate::harness::{Cost, Fault, Verdict};
use crate::scalar::{Dd, Dual, Real, Scalar};
use nalgebra::DVector;
use proptest::strategy::{BoxedStrategy, Strategy};

/// A groupoid with a way to make chains of elements, and a distance.
pub trait Chains: Groupoid {
    /// The scalar of its coordinates.
    type Real: Real;

    /// How many numbers a chain is made from.
    fn numbers(&self) -> usize;

    /// Three elements with β(g₁) = α(g₂) and β(g₂) = α(g₃) from as many numbers as [`Chains::numbers`] says, 0 and equal ones
    /// among them; `None` where these numbers give none.
    fn chain(&self, numbers: &[Self::Real]) -> Option<[Self::Element; 3]>;

    /// How far two elements with the same ends are apart: the largest difference of their coordinates.
    fn distance(&self, g: &Self::Element, h: &Self::Element) -> Self::Real;

    /// What rounding is amplified by in products and inverses of a chain: the product of |g| and |g⁻¹|; 1 by default.
    fn size(&self, chain: &[Self::Element; 3]) -> Self::Real {
        let _ = chain;
        Self::Real::int(1)
    }
}

impl Groupoid for Missing {
    type Element = ();
    type Base = ();

    fn source(&self, (): &()) {
        match *self {}
    }

    fn target(&self, (): &()) {
        match *self {}
    }

    fn unit(&self, (): &()) {
        match *self {}
    }

    fn inverse(&self, (): &()) -> Option<()> {
        match *self {}
    }

    fn product(&self, (): &(), (): &()) {
        match *self {}
    }
}

impl Chains for Missing {
    type Real = Dd;

    fn numbers(&self) -> usize {
        match *self {}
    }

    fn chain(&self, _: &[Dd]) -> Option<[(); 3]> {
        match *self {}
    }

    fn distance(&self, (): &(), (): &()) -> Dd {
        match *self {}
    }
}

const SOURCE: &str = "Martín de Diego and Sato Martín de Almagro 2019, Def 4.1";
const ORACLE: &str = "two different products of elements of a chain";
const BOUND: &str = "two precisions; floor 2⁶ n u times the declared size, n the count of numbers; ends exact";
const EVERY: &str = "every groupoid";
const MORE: &str = "groupoids over more than a point";

/// Fault: source and target exchanged.
pub const ENDS_SWAPPED: Fault = Fault::new("ends-swapped", "source and target exchanged", MORE);
/// Fault: ε(x) = g₁, whatever x.
pub const UNIT_FIRST: Fault = Fault::new("unit-first", "ε(x) = g₁, whatever x", EVERY);
/// Fault: g⁻¹ = g.
pub const INVERSE_ITSELF: Fault = Fault::new("inverse-itself", "g⁻¹ = g", EVERY);
/// Fault: gh replaced by (gh)⁻¹.
pub const PRODUCT_INVERTED: Fault = Fault::new("product-inverted", "gh replaced by (gh)⁻¹", EVERY);
/// Fault: gh replaced by g.
pub const PRODUCT_FIRST: Fault = Fault::new("product-first", "gh replaced by g", EVERY);
/// Fault: gh replaced by h.
pub const PRODUCT_SECOND: Fault = Fault::new("product-second", "gh replaced by h", EVERY);
/// Fault: `compose` of elements that do not meet.
pub const NEVER_REFUSES: Fault = Fault::new("never-refuses", "`compose` of elements that do not meet", MORE);

macro_rules! axiom {
    ($name:literal, $statement:literal, $faults:expr) => {
        About {
            name: $name,
            statement: $statement,
            source: SOURCE,
            oracle: ORACLE,
            bound: BOUND,
            needs: "",
            faults: $faults,
            cost: Cost::Cheap,
        }
    };
}

/// The laws of any groupoid.
pub static LAWS: &[About] = &[
    axiom!(
        "own-groupoid-chain",
        "β(g₁) = α(g₂) and β(g₂) = α(g₃) for the chains of the user, compared exactly",
        &[ENDS_SWAPPED]
    ),
    axiom!(
        "own-groupoid-product-ends",
        "α(g₁g₂) = α(g₁) and β(g₁g₂) = β(g₂)",
        &[PRODUCT_INVERTED, PRODUCT_FIRST, PRODUCT_SECOND]
    ),
    axiom!("own-groupoid-associativity", "g₁(g₂g₃) = (g₁g₂)g₃", &[PRODUCT_INVERTED]),
    axiom!("own-groupoid-unit-ends", "α(ε(x)) = x = β(ε(x))", &[UNIT_FIRST]),
    axiom!("own-groupoid-left-unit", "ε(α(g))g = g", &[UNIT_FIRST, PRODUCT_INVERTED, PRODUCT_FIRST]),
    axiom!("own-groupoid-right-unit", "gε(β(g)) = g", &[UNIT_FIRST, PRODUCT_INVERTED, PRODUCT_SECOND]),
    axiom!("own-groupoid-inverse-ends", "α(g⁻¹) = β(g) and β(g⁻¹) = α(g)", &[INVERSE_ITSELF]),
    axiom!("own-groupoid-left-inverse", "g⁻¹g = ε(β(g))", &[INVERSE_ITSELF, UNIT_FIRST, PRODUCT_FIRST]),
    axiom!("own-groupoid-right-inverse", "gg⁻¹ = ε(α(g))", &[INVERSE_ITSELF, UNIT_FIRST, PRODUCT_SECOND]),
    axiom!(
        "own-groupoid-refusal",
        "`compose` refuses g and h with β(g) ≠ α(h), and says which points differ",
        &[NEVER_REFUSES]
    ),
];

/// A user's groupoid, at both precisions or in `f64` alone.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct OwnGroupoid<A, B> {
    parts: Pair<A, B>,
    largest: f64,
}

impl<A: Chains<Real = f64>> OwnGroupoid<A, Missing> {
    /// The groupoid in `f64` alone.
    pub fn in_double(groupoid: A) -> Self {
        Self { parts: Pair { double: groupoid, quad: None }, largest: 4.0 }
    }
}

impl<A: Chains<Real = f64>, B: Chains<Real = Dd>> OwnGroupoid<A, B> {
    /// The same groupoid in `f64` and in 32 digits.
    pub fn at_both(double: A, quad: B) -> Self {
        Self { parts: Pair { double, quad: Some(quad) }, largest: 4.0 }
    }

    /// Only numbers of at most `largest` (default 4) for the chains.
    pub fn within(self, largest: f64) -> Self {
        Self { largest, ..self }
    }
}

impl<A, B> Subject for OwnGroupoid<A, B>
where
    A: Chains<Real = f64> + Send + Sync + 'static,
    B: Chains<Real = Dd> + Send + Sync + 'static,
{
    const LAWS: &'static [About] = LAWS;

    fn precisions(&self) -> Precisions {
        self.parts.precisions()
    }

    fn cases(&self, _: &About) -> BoxedStrategy<Values> {
        Points::new().within(self.largest).vectors(&["chain"], self.parts.double.numbers()).boxed()
    }

    fn check(&self, law: &About, case: &Values, fault: Option<&Fault>) -> Verdict {
        self.parts.settle(|q| judge(q, law.name, case, fault), |q| judge(q, law.name, case, fault))
    }
}

/// A groupoid with a fault planted in it: wrong altogether, whatever the size of the fault.
struct Planted<'a, Q: Groupoid> {
    groupoid: &'a Q,
    first: &'a Q::Element,
    fault: Option<&'a Fault>,
}

impl<Q: Groupoid> Planted<'_, Q> {
    fn has(&self, fault: &Fault) -> bool {
        Fault::size_of(self.fault, fault.name) > 0.0
    }
}

impl<Q: Groupoid> Groupoid for Planted<'_, Q> {
    type Element = Q::Element;
    type Base = Q::Base;

    fn source(&self, g: &Q::Element) -> Q::Base {
        if self.has(&ENDS_SWAPPED) { self.groupoid.target(g) } else { self.groupoid.source(g) }
    }

    fn target(&self, g: &Q::Element) -> Q::Base {
        if self.has(&ENDS_SWAPPED) { self.groupoid.source(g) } else { self.groupoid.target(g) }
    }

    fn unit(&self, x: &Q::Base) -> Q::Element {
        if self.has(&UNIT_FIRST) { self.first.clone() } else { self.groupoid.unit(x) }
    }

    fn inverse(&self, g: &Q::Element) -> Option<Q::Element> {
        if self.has(&INVERSE_ITSELF) { Some(g.clone()) } else { self.groupoid.inverse(g) }
    }

    fn product(&self, first: &Q::Element, second: &Q::Element) -> Q::Element {
        match () {
            () if self.has(&PRODUCT_FIRST) => first.clone(),
            () if self.has(&PRODUCT_SECOND) => second.clone(),
            () => self.groupoid.product(first, second),
        }
    }

    fn compose(&self, first: &Q::Element, second: &Q::Element) -> Result<Q::Element, NotComposable<Q::Base>> {
        if self.has(&NEVER_REFUSES) {
            return Ok(self.groupoid.product(first, second));
        }
        if self.has(&PRODUCT_FIRST) || self.has(&PRODUCT_SECOND) {
            self.groupoid.compose(first, second)?;
            return Ok(self.product(first, second));
        }
        let right = self.groupoid.compose(first, second)?;
        match self.has(&PRODUCT_INVERTED) {
            true => Ok(self.groupoid.inverse(&right).unwrap_or(right)),
            false => Ok(right),
        }
    }
}

fn judge<Q: Chains>(groupoid: &Q, law: &str, case: &Values, fault: Option<&Fault>) -> Result<Measured, Measured> {
    let numbers = case.list::<Q::Real>("chain", groupoid.numbers()).map_err(misfit)?;
    let chain = groupoid.chain(&numbers);
    let chain = chain.ok_or(Measured::NotApplicable("these numbers give no chain".into()))?;
    let q = Planted { groupoid, first: &chain[0], fault };
    let [g, h, k] = chain.each_ref();
    let axiom = match law {
        "own-groupoid-chain" => return Ok(composable(&q, &chain)),
        "own-groupoid-refusal" => return Ok(refusal(&q, &chain)),
        "own-groupoid-product-ends" => Axiom::ProductEnds,
        "own-groupoid-associativity" => Axiom::Associativity,
        "own-groupoid-unit-ends" => Axiom::UnitEnds,
        "own-groupoid-left-unit" => Axiom::LeftUnit,
        "own-groupoid-right-unit" => Axiom::RightUnit,
        "own-groupoid-inverse-ends" => Axiom::InverseEnds,
        "own-groupoid-left-inverse" => Axiom::LeftInverse,
        "own-groupoid-right-inverse" => Axiom::RightInverse,
        other => return Err(Measured::Broken(format!("there is no law `{other}` of groupoids"))),
    };
    let size = groupoid.size(&chain);
    let unit = size * Q::Real::unit_roundoff();
    let defect = axiom.defect(&q, [g, h, k], |g, h| {
        let distance = groupoid.distance(g, h);
        match distance == Q::Real::int(0) {
            true => 0.0,
            false => (distance / unit).to_f64(),
        }
    });
    let defect = if defect.is_nan() { f64::INFINITY } else { defect };
    let floor = 64.0 * numbers.len().max(1) as f64;
    let infinite = if defect.is_finite() { "" } else { " (ends differ, or a product or an inverse does not exist)" };
    let witness = format!("{}{infinite}; g₁ = {g:?}, g₂ = {h:?}, g₃ = {k:?}", axiom.statement());
    Ok(Measured::Defect { amplification: defect, floor, witness })
}

fn fine() -> Measured {
    Measured::Defect { amplification: 0.0, floor: 1.0, witness: String::new() }
}

fn composable<Q: Groupoid>(q: &Q, chain: &[Q::Element; 3]) -> Measured {
    for pair in chain.windows(2) {
        let (target, source) = (q.target(&pair[0]), q.source(&pair[1]));
        if target != source {
            return Measured::Broken(format!("β({:?}) = {target:?}, but α({:?}) = {source:?}", pair[0], pair[1]));
        }
    }
    fine()
}

/// Every pair of the chain that does not meet is refused, with both points.
fn refusal<Q: Groupoid>(q: &Q, chain: &[Q::Element; 3]) -> Measured {
    let mut met = true;
    for first in chain {
        for second in chain {
            let (target, source) = (q.target(first), q.source(second));
            if target == source {
                continue;
            }
            met = false;
            match q.compose(first, second) {
                Err(refused) if refused.target == target && refused.source_of_second == source => {}
                Err(refused) => return Measured::Broken(format!("refused with other points: {refused}")),
                Ok(_) => {
                    return Measured::Broken(format!("composed, though β(g) = {target:?} and α(h) = {source:?}"));
                }
            }
        }
    }
    if met { Measured::NotApplicable("every pair of the chain is composable".into()) } else { fine() }
}

/// A Lie groupoid over every scalar, with chains in coordinates.
///
/// ```
/// use euler_poincare::groupoid::{ManifoldPair, Space};
/// use euler_poincare::laws::own::groupoid::LieChains;
/// use euler_poincare::laws::own::{Outcome, Settings};
/// use euler_poincare::scalar::{Real, Scalar};
/// use euler_poincare::suite;
/// use nalgebra::DVector;
///
/// /// Pairs of points of the line.
/// struct Line;
///
/// impl<T: Real> LieChains<T> for Line {
///     type At<'a, S: Scalar<Base = T> + 'a> = ManifoldPair<Space<1>, S>;
///
///     fn at<'a, S: Scalar<Base = T> + 'a>(&'a self) -> Self::At<'a, S> {
///         ManifoldPair::new(Space)
///     }
///
///     fn numbers(&self) -> usize {
///         4
///     }
///
///     fn chain(&self, x: &[T]) -> Option<[DVector<T>; 3]> {
///         let pair = |k: usize| DVector::from_vec(vec![x[k], x[k + 1]]);
///         Some([pair(0), pair(1), pair(2)])
///     }
/// }
///
/// suite! {
///     mod line<T> { lie_groupoid: Line }
/// }
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let outcome = line::suite().run("lie-groupoid-axioms", &Settings { cases: 4, ..Settings::new() });
/// assert!(matches!(outcome, Outcome::Held { cases: 4, .. }), "{outcome:?}");
/// # Ok(())
/// # }
/// ```
pub trait LieChains<T: Real>: Send + Sync {
    /// The groupoid over S.
    type At<'a, S: Scalar<Base = T> + 'a>: LieGroupoid<S> + 'a
    where
        Self: 'a;

    /// The groupoid over S: numbers, duals, duals of duals.
    fn at<'a, S: Scalar<Base = T> + 'a>(&'a self) -> Self::At<'a, S>;

    /// How many numbers a chain is made from.
    fn numbers(&self) -> usize;

    /// The coordinates of three elements with β(g₁) = α(g₂) and β(g₂) = α(g₃); `None` where these numbers give none.
    fn chain(&self, numbers: &[T]) -> Option<[DVector<T>; 3]>;

    /// What rounding is amplified by in products and inverses of a chain, beyond the largest coordinate; 1 by default.
    fn size(&self, chain: &[DVector<T>; 3]) -> T {
        let _ = chain;
        T::one()
    }
}

const SMOOTH: &str = "two precisions; floor 2⁶ m u relative to the terms, m the number of coordinates of an element";
const FIELDS: &str = "random quadratic sections, the invariant fields and their derivatives on dual numbers";

macro_rules! smooth {
    ($name:literal, $statement:literal, $source:literal, $oracle:expr, $faults:expr) => {
        About {
            name: $name,
            statement: $statement,
            source: concat!("Martín de Diego and Sato Martín de Almagro 2019, ", $source),
            oracle: $oracle,
            bound: SMOOTH,
            needs: "",
            faults: $faults,
            cost: Cost::Cheap,
        }
    };
}

/// α and β of the coordinates that the interface promises.
const COORDINATES_SHIFTED: Fault =
    Fault::new("coordinates-shifted", "`coordinates` with 1 added to each", "every Lie groupoid");
/// Not the inverse of the frame.
const FIBRE_SIGN: Fault = Fault::new("fibre-sign", "`fibre` with the other sign", "fibres other than 0");

/// The laws of a Lie groupoid.
pub static LIE_LAWS: &[About] = &[
    smooth!(
        "lie-groupoid-axioms",
        "the axioms of a groupoid, in coordinates",
        "Def 4.1",
        ORACLE,
        &[INVERSE_KEEPS_U, SECOND_INVERTED, ENDS_KEPT, PRODUCT_KEEPS_END]
    ),
    smooth!(
        "lie-groupoid-coordinates",
        "coordinates(element(z)) = z, the same of base points; α(g) has the first coordinates of g, β(g) the last",
        "§4.1",
        "the coordinates that the element was made from",
        &[COORDINATES_SHIFTED]
    ),
    smooth!(
        "lie-groupoid-fibre",
        "near_unit(x, ε a) is tangent to the α-fibre at ε(x), and `fibre` gives a back",
        "Def 4.5",
        "Tα by duals; the fibre coordinates that the vector was made from",
        &[FIBRE_SIGN]
    ),
    smooth!(
        "lie-groupoid-fields",
        "Tα X← = 0, Tβ X→ = 0, X←(gh) = T L_g X←(h), X→(gh) = T R_h X→(g), [X←, Y→] = 0",
        "Def 4.3, (4.1) and (4.3)",
        FIELDS,
        &[LEFT_AT_SOURCE, SECOND_INVERTED, PRODUCT_KEEPS_END]
    ),
    smooth!(
        "lie-groupoid-bracket",
        "[X←, Y←] = ⟦X, Y⟧←, ⟦X, Y⟧ in closed form; ⟦X, Y⟧ = −⟦Y, X⟧; Jacobi",
        "Defs 4.4 and 4.5, (4.2)",
        "the commutator of the invariant fields by duals, against `structure` and `anchor`",
        &[STRUCTURE_SIGN, ANCHOR_SIGN, NO_DERIVATIVES, LEFT_AT_SOURCE]
    ),
    smooth!(
        "lie-groupoid-anchor",
        "ρ = Tβ on the fibres of AG, ρ⟦X, Y⟧ = [ρX, ρY], ⟦X, fY⟧ = f⟦X, Y⟧ + ρ(X)(f) Y",
        "Defs 4.4 and 4.5, (4.2)",
        "Tβ and the commutator of vector fields on the base by duals",
        &[ANCHOR_SIGN, STRUCTURE_SIGN, NO_DERIVATIVES]
    ),
    smooth!(
        "lie-groupoid-right-fields",
        "⟦X, Y⟧→ = −[X→, Y→]",
        "§4.1, after (4.3)",
        "the commutator of the right-invariant fields by duals, against the bracket in closed form",
        &[RIGHT_SIGN, STRUCTURE_SIGN, ANCHOR_SIGN, NO_DERIVATIVES]
    ),
    smooth!(
        "lie-groupoid-inversion",
        "Z = W + ι_*W has Tι Z(g) = Z(g⁻¹) and is tangent to the units there, for random W; so is X← − X→",
        "Prop 4.6",
        "Z against Tε Tα Z, by duals of ι, α and ε",
        &[INVERSE_KEEPS_U, ENDS_KEPT, RIGHT_SIGN]
    ),
];

/// A groupoid, for the signatures of [`Missing`] alone.
type Never<S> = TrivialGroupoid<Singleton, DenseGroup<Dd>, S>;

impl LieChains<Dd> for Missing {
    type At<'a, S: Scalar<Base = Dd> + 'a> = Never<S>;

    fn at<'a, S: Scalar<Base = Dd> + 'a>(&'a self) -> Self::At<'a, S> {
        match *self {}
    }

    fn numbers(&self) -> usize {
        match *self {}
    }

    fn chain(&self, _: &[Dd]) -> Option<[DVector<Dd>; 3]> {
        match *self {}
    }
}

/// A user's Lie groupoid, at both precisions or over `f64` alone.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct OwnLieGroupoid<A, B> {
    parts: Pair<A, B>,
    largest: f64,
}

impl<A: LieChains<f64>> OwnLieGroupoid<A, Missing> {
    /// The groupoid over `f64` alone.
    pub fn in_double(groupoid: A) -> Self {
        Self { parts: Pair { double: groupoid, quad: None }, largest: 2.0 }
    }
}

impl<A: LieChains<f64>, B: LieChains<Dd>> OwnLieGroupoid<A, B> {
    /// The same groupoid over `f64` and over 32 digits.
    pub fn at_both(double: A, quad: B) -> Self {
        Self { parts: Pair { double, quad: Some(quad) }, largest: 2.0 }
    }

    /// Only numbers of at most `largest` (default 2) for the chains.
    pub fn within(self, largest: f64) -> Self {
        Self { largest, ..self }
    }
}

impl<A, B> Subject for OwnLieGroupoid<A, B>
where
    A: LieChains<f64> + 'static,
    B: LieChains<Dd> + 'static,
{
    const LAWS: &'static [About] = LIE_LAWS;

    fn precisions(&self) -> Precisions {
        self.parts.precisions()
    }

    fn cases(&self, _: &About) -> BoxedStrategy<Values> {
        Points::new().within(self.largest).vectors(&["chain"], self.parts.double.numbers()).boxed()
    }

    fn check(&self, law: &About, case: &Values, fault: Option<&Fault>) -> Verdict {
        self.parts.settle(|q| smooth::<f64, A>(q, law.name, case, fault), |q| smooth::<Dd, B>(q, law.name, case, fault))
    }
}

fn smooth<T: Real, Q: LieChains<T>>(
    groupoid: &Q,
    law: &str,
    case: &Values,
    fault: Option<&Fault>,
) -> Result<Measured, Measured> {
    let numbers = case.list::<T>("chain", groupoid.numbers()).map_err(misfit)?;
    let chain = groupoid.chain(&numbers);
    let chain = chain.ok_or(Measured::NotApplicable("these numbers give no chain".into()))?;
    let question = match law {
        "lie-groupoid-axioms" => return Ok(axioms(groupoid, &chain, fault)),
        "lie-groupoid-coordinates" => return Ok(coordinates(&groupoid.at::<T>(), &chain, fault)),
        "lie-groupoid-fibre" => {
            return fibre(&groupoid.at::<Dual<T>>(), &chain, fault, &mut Probe::new(case, 71));
        }
        "lie-groupoid-fields" => Question::Fields,
        "lie-groupoid-bracket" => Question::Bracket,
        "lie-groupoid-anchor" => Question::Anchor,
        "lie-groupoid-right-fields" => Question::Right,
        "lie-groupoid-inversion" => Question::Inversion,
        other => return Err(Measured::Broken(format!("there is no law `{other}` of Lie groupoids"))),
    };
    let largest = chain.iter().fold(T::one(), |size, g| size.max(g.amax()));
    let scale = groupoid.size(&chain) * largest;
    let spoilt = Spoilt::new(groupoid.at::<Second<T>>(), fault);
    let instance = Instance { kind: Kind::Own, groupoid: spoilt, chain, scale, excess: None };
    Ok(algebroid::judge(&instance, question, fault, &mut Probe::new(case, 72)))
}

fn axioms<T: Real, Q: LieChains<T>>(groupoid: &Q, chain: &[DVector<T>; 3], fault: Option<&Fault>) -> Measured {
    let largest = chain.iter().fold(T::one(), |size, g| size.max(g.amax()));
    let unit = groupoid.size(chain) * largest * T::unit_roundoff();
    let q = Spoilt::new(groupoid.at::<T>(), fault);
    let measured = Axiom::ALL.into_iter().map(|axiom| {
        let defect = axiom.defect(&q, chain.each_ref(), |g, h| {
            let ends = q.source(g) == q.source(h) && q.target(g) == q.target(h);
            if ends && g.len() == h.len() { ((g - h).amax() / unit).to_f64() } else { f64::INFINITY }
        });
        let amplification = if defect.is_nan() { f64::INFINITY } else { defect };
        let floor = 64.0 * chain[0].len().max(1) as f64;
        Measured::Defect { amplification, floor, witness: axiom.statement().into() }
    });
    measured.fold(composable(&q, chain), Measured::and)
}

fn coordinates<T: Real, Q: LieGroupoid<T>>(q: &Q, chain: &[DVector<T>; 3], fault: Option<&Fault>) -> Measured {
    let size = T::exact(Fault::size_of(fault, COORDINATES_SHIFTED.name));
    let mut measured = fine();
    for z in chain {
        let g = q.element(z);
        let back = q.coordinates(&g).add_scalar(size);
        let (source, target) = (q.base_coordinates(&q.source(&g)), q.base_coordinates(&q.target(&g)));
        let ends = source.len();
        if back.len() != z.len() || target.len() != ends || ends > z.len() {
            return Measured::Broken(format!(
                "{} coordinates, {} after `element`; {ends} of α(g), {} of β(g)",
                z.len(),
                back.len(),
                target.len()
            ));
        }
        let again = q.base_coordinates(&q.base_point(&source));
        let floor = 64.0 * z.len().max(1) as f64;
        let near = |a: &DVector<T>, b: &DVector<T>, what: &'static str| {
            let (off, size) =
                if a.is_empty() { (T::zero(), T::one()) } else { ((a - b).amax(), z.amax().max(T::one())) };
            Measured::defect(off, size, floor, || format!("{what}: {} and {}", list(a.iter()), list(b.iter())))
        };
        let (first, last) = (z.rows(0, ends).into_owned(), z.rows(z.len() - ends, ends).into_owned());
        measured = measured
            .and(near(&back, z, "coordinates(element(z)) ≠ z"))
            .and(near(&again, &source, "base_coordinates(base_point(x)) ≠ x"))
            .and(near(&source, &first, "α(g) has not the first coordinates of g"))
            .and(near(&target, &last, "β(g) has not the last coordinates of g"));
    }
    measured
}

fn fibre<T: Real, Q: LieGroupoid<Dual<T>>>(
    q: &Q,
    chain: &[DVector<T>; 3],
    fault: Option<&Fault>,
    probe: &mut Probe,
) -> Result<Measured, Measured> {
    let rank = LieAlgebroid::rank(q);
    let a = DVector::<T>::from_fn(rank, |_, _| probe.unit());
    let g = q.element(&constant(&chain[0]));
    let x = values(&q.base_coordinates(&q.source(&g)));
    let point = q.base_point(&constant(&x));
    let unit = values(&q.coordinates(&q.unit(&point)));
    let tangent = at_unit(q, &x, &a);
    let near = q.near_unit(&point, &infinitesimal(&a));
    let place = values(&q.coordinates(&near));
    let found = q.fibre(&point, &constant(&tangent));
    let found = found.ok_or_else(|| Measured::Broken("`fibre` gives None at a point of the base".into()))?;
    let sign = T::one() - T::exact(2.0 * Fault::size_of(fault, FIBRE_SIGN.name));
    let found = values(&found) * sign;
    if found.len() != rank {
        return Ok(Measured::Broken(format!("`fibre` gives {} coordinates, the rank is {rank}", found.len())));
    }
    let floor = 64.0 * unit.len().max(1) as f64;
    let largest = unit
        .iter()
        .fold(T::one(), |size, v| size.max(v.abs()))
        .max(tangent.iter().fold(T::one(), |s, v| s.max(v.abs())));
    let defect = |a: &DVector<T>, b: &DVector<T>, what: &'static str| {
        let off = if a.is_empty() { T::zero() } else { (a - b).amax() };
        Measured::defect(off, largest, floor, || format!("{what}: {} and {}", list(a.iter()), list(b.iter())))
    };
    let down = push_source(q, &unit, &tangent);
    let still = derivatives(&q.base_coordinates(&q.source(&near)));
    Ok(defect(&place, &unit, "near_unit(x, ε a) is not at ε(x)")
        .and(defect(&down, &DVector::zeros(down.len()), "Tα of the frame ≠ 0"))
        .and(defect(&still, &DVector::zeros(still.len()), "the source of near_unit(x, ε a) moves"))
        .and(defect(&found, &a, "`fibre` of the frame")))
}
