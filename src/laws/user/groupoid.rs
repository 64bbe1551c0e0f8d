//! Laws of one groupoid: the axioms on any [`Groupoid`] that a user writes, and fields and brackets where it is a
//! [`LieGroupoid`].
//!
//! A case holds numbers; the user's type makes a chain of three composable elements from them.
//!
//! ```
//! use euler_poincare::laws::user::groupoid::{Chains, UserGroupoid};
//! use euler_poincare::laws::user::part;
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
//! let report = part::run(UserGroupoid::in_double(Points), 1, 4);
//! assert!(report.laws.iter().all(|law| law.broken.is_empty()));
//! ```

use super::super::algebroid;
use super::super::groupoid::{self as axioms, COMPOSABLE, Chain, REFUSAL, axiom};
use super::super::instances::{GroupoidKind, Instance, Second};
use super::super::planted::groupoid::Planted as PlantedLie;
use super::super::precision::Measured;
use super::super::probe::{Probe, stream};
use super::lagrangian::list;
use super::part::{Answer, Answers, Asked, Kind, Part, part_laws};
use crate::groupoid::calculus::{constant, derivatives, infinitesimal, values};
use crate::groupoid::{Axiom, Groupoid, LieAlgebroid, LieGroupoid, NotComposable, Tangent};
use crate::harness::{About, Fault};
use crate::scalar::{Dual, Real, Scalar, max_abs};
use nalgebra::DVector;

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

const EVERY: &str = "every groupoid";
const MORE: &str = "groupoids over more than a point";

const ENDS_SWAPPED: Fault = Fault::new("ends-swapped", "source and target exchanged", MORE);
const UNIT_FIRST: Fault = Fault::new("unit-first", "ε(x) = g₁, whatever x", EVERY);
const INVERSE_ITSELF: Fault = Fault::new("inverse-itself", "g⁻¹ = g", EVERY);
const PRODUCT_INVERTED: Fault = Fault::new("product-inverted", "gh replaced by (gh)⁻¹", EVERY);
const PRODUCT_FIRST: Fault = Fault::new("product-first", "gh replaced by g", EVERY);
const PRODUCT_SECOND: Fault = Fault::new("product-second", "gh replaced by h", EVERY);
const NEVER_REFUSES: Fault = Fault::new("never-refuses", "`compose` of elements that do not meet", MORE);

part_laws! {
    /// The laws of any groupoid: of each of [`Axiom::ALL`], and of `compose`.
    LAWS FIELDS __own_groupoid;
    every {
        groupoid_chain "chain" axiom("", COMPOSABLE, &[ENDS_SWAPPED]);
        groupoid_product_ends "chain" axiom("", Axiom::ProductEnds.statement(), &[PRODUCT_INVERTED, PRODUCT_FIRST, PRODUCT_SECOND]);
        groupoid_associativity "chain" axiom("", Axiom::Associativity.statement(), &[PRODUCT_INVERTED]);
        groupoid_unit_ends "chain" axiom("", Axiom::UnitEnds.statement(), &[UNIT_FIRST]);
        groupoid_left_unit "chain" axiom("", Axiom::LeftUnit.statement(), &[UNIT_FIRST, PRODUCT_INVERTED, PRODUCT_FIRST]);
        groupoid_right_unit "chain" axiom("", Axiom::RightUnit.statement(), &[UNIT_FIRST, PRODUCT_INVERTED, PRODUCT_SECOND]);
        groupoid_inverse_ends "chain" axiom("", Axiom::InverseEnds.statement(), &[INVERSE_ITSELF]);
        groupoid_left_inverse "chain" axiom("", Axiom::LeftInverse.statement(), &[INVERSE_ITSELF, UNIT_FIRST, PRODUCT_FIRST]);
        groupoid_right_inverse "chain" axiom("", Axiom::RightInverse.statement(), &[INVERSE_ITSELF, UNIT_FIRST, PRODUCT_SECOND]);
        groupoid_refusal "chain" axiom("", REFUSAL, &[NEVER_REFUSES]);
    }
}

/// A user's groupoid. The largest number of a case is that for the chains.
#[doc(hidden)]
pub type UserGroupoid = Part<GroupoidLaws>;

/// The laws on groupoids.
#[derive(Default)]
#[doc(hidden)]
pub struct GroupoidLaws;

impl Kind for GroupoidLaws {
    const LAWS: &'static [About] = LAWS;
    const FIELDS: &'static [(&'static str, &'static str)] = FIELDS;
    const LARGEST: f64 = 4.0;
}

impl<Q: Chains + Send + Sync + 'static> Answers<Q::Real, GroupoidLaws> for Q {
    fn length(&self) -> usize {
        self.numbers()
    }

    fn answer(&self, asked: &Asked<'_, GroupoidLaws>) -> Answer {
        let numbers = asked.case.list::<Q::Real>("chain", self.numbers())?;
        let elements = self.chain(&numbers).ok_or_else(no_chain)?;
        let (size, distance) = (self.size(&elements), |g: &_, h: &_| self.distance(g, h));
        judge(self, (&elements, numbers.len()), distance, size, asked)
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
        Fault::planted(self.fault, fault.name)
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
        self.groupoid.product(first, second)
    }

    fn compose(&self, first: &Q::Element, second: &Q::Element) -> Result<Q::Element, NotComposable<Q::Base>> {
        if self.has(&NEVER_REFUSES) {
            return Ok(self.product(first, second));
        }
        let right = self.groupoid.compose(first, second)?;
        Ok(match () {
            () if self.has(&PRODUCT_FIRST) => first.clone(),
            () if self.has(&PRODUCT_SECOND) => second.clone(),
            () if self.has(&PRODUCT_INVERTED) => self.groupoid.inverse(&right).unwrap_or(right),
            () => right,
        })
    }
}

fn no_chain() -> Measured {
    Measured::NotApplicable("these numbers give no chain".into())
}

/// A law on three elements made of a number of numbers, by their distances and by what rounding is amplified by.
pub(in crate::laws) fn judge<T: Real, Q: Groupoid>(
    groupoid: &Q,
    (elements, numbers): (&[Q::Element; 3], usize),
    distance: impl Fn(&Q::Element, &Q::Element) -> T,
    size: T,
    asked: &Asked<'_, GroupoidLaws>,
) -> Answer {
    let unit = size * T::unit_roundoff();
    let distance = |g: &Q::Element, h: &Q::Element| match distance(g, h) {
        distance if distance == T::zero() => 0.0,
        distance => (distance / unit).to_f64(),
    };
    let q = Planted { groupoid, first: &elements[0], fault: asked.fault };
    let chain = Chain { groupoid: &q, elements, distance, numbers, of: String::new() };
    let axiom = Axiom::ALL.into_iter().find(|axiom| axiom.statement() == asked.law.statement);
    match (axiom, asked.law.statement) {
        (Some(axiom), _) => Ok(chain.axiom(axiom)),
        (None, COMPOSABLE) => Ok(chain.composable()),
        (None, REFUSAL) => Ok(chain.refusal(elements.iter().flat_map(|g| elements.iter().map(move |h| (g, h))))),
        _ => asked.unknown("groupoids"),
    }
}

/// The same of a Lie groupoid, in its coordinates.
pub(in crate::laws) fn judge_coordinates<T: Real, Q: LieChains<T>>(
    groupoid: &Q,
    asked: &Asked<'_, GroupoidLaws>,
) -> Answer {
    let numbers = asked.case.list("chain", groupoid.numbers())?;
    let chain = groupoid.chain(&numbers).ok_or_else(no_chain)?;
    let (flat, distance) = (PlantedLie::new(groupoid.at::<T>(), None), |g: &_, h: &_| max_abs(&(g - h)));
    judge(&flat, (&chain, numbers.len()), distance, groupoid.size(&chain), asked)
}

/// A Lie groupoid over every scalar, with chains in coordinates.
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

/// α and β of the coordinates that the interface promises.
const COORDINATES_SHIFTED: Fault =
    Fault::new("coordinates-shifted", "`coordinates` with 1 added to each", "every Lie groupoid");
/// Not the inverse of the frame.
const FIBRE_SIGN: Fault = Fault::new("fibre-sign", "`fibre` with the other sign", "fibres other than 0");

part_laws! {
    /// The laws of a Lie groupoid.
    LIE_LAWS LIE_FIELDS __own_lie_groupoid;
    every {
        lie_groupoid_axioms "chain" axiom("", "the axioms of a groupoid, in coordinates", axioms::FAULTS);
        lie_groupoid_coordinates "chain" About {
            statement: "coordinates(element(z)) = z, the same of base points; α(g) has the first coordinates of g, β(g) the last",
            source: "Martín de Diego and Sato Martín de Almagro 2019, §4.1",
            oracle: "the coordinates that the element was made from",
            faults: &[COORDINATES_SHIFTED],
            ..algebroid::LAW
        };
        lie_groupoid_fibre "chain" About {
            statement: "`near_unit(x, ε a)` is tangent to the α-fibre at ε(x), and `fibre` gives a back",
            source: "Martín de Diego and Sato Martín de Almagro 2019, Def 4.5",
            oracle: "Tα by duals; the fibre coordinates that the vector was made from",
            faults: &[FIBRE_SIGN],
            ..algebroid::LAW
        };
        invariant_fields "chain" algebroid::FIELDS;
        algebroid_bracket "chain" algebroid::BRACKET;
        algebroid_anchor "chain" algebroid::ANCHOR;
        algebroid_right_fields "chain" algebroid::RIGHT;
        inversion_invariant_field "chain" algebroid::INVERSION;
    }
}

/// A user's Lie groupoid. The largest number of a case is that for the chains.
#[doc(hidden)]
pub type UserLieGroupoid = Part<LieGroupoidLaws>;

/// The laws on Lie groupoids.
#[derive(Default)]
#[doc(hidden)]
pub struct LieGroupoidLaws;

impl Kind for LieGroupoidLaws {
    const LAWS: &'static [About] = LIE_LAWS;
    const FIELDS: &'static [(&'static str, &'static str)] = LIE_FIELDS;
    const LARGEST: f64 = 2.0;
}

impl<T: Real, Q: LieChains<T> + 'static> Answers<T, LieGroupoidLaws> for Q {
    fn length(&self) -> usize {
        self.numbers()
    }

    fn answer(&self, asked: &Asked<'_, LieGroupoidLaws>) -> Answer {
        let fault = asked.fault;
        let chain = self.chain(&asked.case.list("chain", self.numbers())?).ok_or_else(no_chain)?;
        let probe = |number: u64| Probe::new(asked.case, number);
        match asked.law.name {
            "lie-groupoid-coordinates" => Ok(coordinates(&self.at::<T>(), &chain, fault)),
            "lie-groupoid-fibre" => fibre(&self.at::<Dual<T>>(), &chain, fault, &mut probe(stream::LIE_FIBRE)),
            "lie-groupoid-axioms" => {
                let instance = instance(self, self.at::<T>(), chain, fault);
                Ok(axioms::axioms(&instance, fault, &mut probe(stream::LIE_GROUPOID)))
            }
            law => {
                let instance = instance(self, self.at::<Second<T>>(), chain, fault);
                Ok(algebroid::judge(&instance, law, fault, &mut probe(stream::LIE_GROUPOID)))
            }
        }
    }
}

/// The groupoid over S with its chain, in coordinates, and a fault planted in it.
fn instance<'a, T: Real, S: Scalar<Base = T> + 'a, Q: LieChains<T>>(
    groupoid: &Q,
    over: impl LieGroupoid<S> + 'a,
    chain: [DVector<T>; 3],
    fault: Option<&'a Fault>,
) -> Instance<'a, S> {
    let largest = chain.iter().fold(T::one(), |size, g| size.max(g.amax()));
    let scale = groupoid.size(&chain) * largest;
    Instance { kind: GroupoidKind::User, groupoid: Box::new(PlantedLie::new(over, fault)), chain, scale, excess: None }
}

fn apart<T: Real>(a: &DVector<T>, b: &DVector<T>, size: T, floor: f64, what: &str) -> Measured {
    Measured::defect(max_abs(&(a - b)), size, floor, || format!("{what}: {} and {}", list(a.iter()), list(b.iter())))
}

fn coordinates<T: Real, Q: LieGroupoid<T>>(q: &Q, chain: &[DVector<T>; 3], fault: Option<&Fault>) -> Measured {
    let shift = T::exact(COORDINATES_SHIFTED.size_in(fault));
    let mut measured = Measured::exact();
    for z in chain {
        let g = q.element(z);
        let back = q.coordinates(&g).add_scalar(shift);
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
        let size = z.amax().max(T::one());
        let near = |a: &_, b: &_, what| apart(a, b, size, floor, what);
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
) -> Answer {
    let rank = LieAlgebroid::rank(q);
    let a = DVector::<T>::from_fn(rank, |_, _| probe.unit());
    let g = q.element(&constant(&chain[0]));
    let x = values(&q.base_coordinates(&q.source(&g)));
    let point = q.base_point(&constant(&x));
    let unit = values(&q.coordinates(&q.unit(&point)));
    let tangent = q.at_unit(&x, &a);
    let near = q.near_unit(&point, &infinitesimal(&a));
    let place = values(&q.coordinates(&near));
    let found = q.fibre(&point, &constant(&tangent));
    let found = found.ok_or_else(|| Measured::Broken("`fibre` gives None at a point of the base".into()))?;
    let sign = T::one() - T::exact(2.0 * FIBRE_SIGN.size_in(fault));
    let found = values(&found) * sign;
    if found.len() != rank {
        return Ok(Measured::Broken(format!("`fibre` gives {} coordinates, the rank is {rank}", found.len())));
    }
    let floor = 64.0 * unit.len().max(1) as f64;
    let largest = unit.iter().chain(tangent.iter()).fold(T::one(), |size, v| size.max(v.abs()));
    let defect = |a: &_, b: &_, what| apart(a, b, largest, floor, what);
    let down = q.push_source(&unit, &tangent);
    let still = derivatives(&q.base_coordinates(&q.source(&near)));
    Ok(defect(&place, &unit, "near_unit(x, ε a) is not at ε(x)")
        .and(defect(&down, &DVector::zeros(down.len()), "Tα of the frame ≠ 0"))
        .and(defect(&still, &DVector::zeros(still.len()), "the source of near_unit(x, ε a) moves"))
        .and(defect(&found, &a, "`fibre` of the frame")))
}
