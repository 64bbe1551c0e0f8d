//! Laws of groupoids: the axioms of Definition 4.1 on any groupoid, here on every instance of a case, and translations.

use super::instances::{GroupoidKind, Instance, groupoid_law, judged, rotations};
use super::planted::groupoid::{
    ACTION_INVERTED, ENDS_KEPT, Flat, INVERSE_KEEPS_U, PRODUCT_KEEPS_END, SECOND_INVERTED, UNCHECKED, UNMATCHED,
    blend_vector,
};
use super::probe::{Probe, stream};
use super::question::{Answer, Measured, Precisions, Problem, Question, ask};
use super::{CaseLaw, Source};
use crate::algebra::Matrix;
use crate::groupoid::{AtiyahGroupoid, Axiom, Groupoid, LieGroupoid};
use crate::harness::{About, Cost, Fault};
use crate::scalar::{Real, max_abs};
use nalgebra::DVector;

const SOURCE: &str = "Martín de Diego and Sato Martín de Almagro 2019, Def 4.1";
const SOURCE_43: &str = "Martín de Diego and Sato Martín de Almagro 2019, Def 4.1 and (4.4)";
const ORACLE: &str = "the axioms, each comparing two different products of three random composable elements; pairs that \
                      are not composable, one of them by one unit of round-off, have to be refused";
const BOUND: &str = "two precisions; floor 2⁵ √m u times the sizes of the elements, of m numbers; ends exact";
/// [`Chain::composable`].
pub(super) const COMPOSABLE: &str = "β(g₁) = α(g₂) and β(g₂) = α(g₃), compared exactly";
/// [`Chain::refusal`].
pub(super) const REFUSAL: &str = "`compose` refuses g and h with β(g) ≠ α(h), and says which points differ";
/// What can be planted in a groupoid over more than a point.
pub(super) const FAULTS: &[Fault] = &[INVERSE_KEEPS_U, SECOND_INVERTED, ENDS_KEPT, PRODUCT_KEEPS_END, UNCHECKED];

/// A law of groupoids that are Lie groupoids or not.
pub(super) const fn axiom(name: &'static str, statement: &'static str, faults: &'static [Fault]) -> About {
    let (source, oracle, bound) = (SOURCE, ORACLE, BOUND);
    About { name, statement, source, oracle, bound, needs: "", faults, cost: Cost::Cheap }
}

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            groupoid_law!(
                axiom(
                    "groupoid-pair",
                    "the groupoid axioms on Q×Q, Q = G: (q,r)(r,s) = (q,s), ι(q,r) = (r,q)",
                    &[ENDS_KEPT, PRODUCT_KEEPS_END, UNCHECKED]
                ),
                Which::Axioms(GroupoidKind::Pair)
            ),
            groupoid_law!(
                axiom(
                    "groupoid-point",
                    "the groupoid axioms on a Lie group over a point",
                    &[INVERSE_KEEPS_U, SECOND_INVERTED]
                ),
                Which::Axioms(GroupoidKind::Point)
            ),
            groupoid_law!(
                axiom(
                    "groupoid-gauge",
                    "the groupoid axioms on G×G×G: (V,U,W)(W,U',X) = (V,UU',X), ι(V,U,W) = (W,U⁻¹,V)",
                    FAULTS
                ),
                Which::Axioms(GroupoidKind::Gauge)
            ),
            groupoid_law!(
                About {
                    source: SOURCE_43,
                    ..axiom(
                        "groupoid-poisson",
                        "the groupoid axioms on g*×G×g*: (λ,U,μ)(μ,V,κ) = (λ,UV,κ), ι(λ,U,μ) = (μ,U⁻¹,λ)",
                        FAULTS
                    )
                },
                Which::Axioms(GroupoidKind::Poisson)
            ),
            groupoid_law!(
                axiom(
                    "groupoid-atiyah",
                    "the groupoid axioms on (P×P)/K, for SO(3) over the sphere: [p,q][p',q'] = [p,q'k], p'k = q, \
         whatever the pairs that represent the classes",
                    &[INVERSE_KEEPS_U, SECOND_INVERTED, ENDS_KEPT, PRODUCT_KEEPS_END, UNCHECKED, UNMATCHED]
                ),
                Which::Axioms(GroupoidKind::Sphere)
            ),
            groupoid_law!(
                axiom(
                    "groupoid-action",
                    "the groupoid axioms on Q⋊G, for the coadjoint action: (x,g,y)(y,h,z) = (x,gh,z), and z = x·(gh)",
                    &[INVERSE_KEEPS_U, SECOND_INVERTED, ENDS_KEPT, PRODUCT_KEEPS_END, UNCHECKED, ACTION_INVERTED]
                ),
                Which::Axioms(GroupoidKind::Coadjoint)
            ),
            groupoid_law!(
                About {
                    name: "groupoid-translations",
                    statement: "L_g and R_g are inverse to L_{g⁻¹} and R_{g⁻¹}, take α-fibres to α-fibres and β-fibres to β-fibres, \
                                and L_g L_h = L_{gh}, R_h R_g = R_{gh}",
                    source: "Martín de Diego and Sato Martín de Almagro 2019, Def 4.2",
                    oracle: "the element translated there and back, on two groupoids of the case",
                    faults: &[INVERSE_KEEPS_U, SECOND_INVERTED, ENDS_KEPT, PRODUCT_KEEPS_END, UNMATCHED],
                    ..axiom("", "", &[])
                },
                Which::Translations
            ),
        ]
    }
}

/// What is judged.
#[derive(Clone, Copy)]
enum Which {
    /// Definition 4.1, on one groupoid.
    Axioms(GroupoidKind),
    /// Definition 4.2, on two that are drawn.
    Translations,
}

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::GROUPOID);

    const LARGE: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let fault = problem.fault;
        let kind = match self {
            Self::Axioms(kind) => Some(kind),
            Self::Translations => None,
        };
        judged(problem, kind, |material, kind, probe| {
            let instance = material.instance::<T>(kind, fault, probe)?;
            Some(match self {
                Self::Axioms(_) => axioms(&instance, fault, probe),
                Self::Translations => translations(&instance),
            })
        })
    }
}

/// Three composable elements of a groupoid, to judge its axioms on.
pub(super) struct Chain<'a, Q: Groupoid + ?Sized, M> {
    pub groupoid: &'a Q,
    pub elements: &'a [Q::Element; 3],
    /// The distance of two elements with the same ends, in units of u times their size.
    pub distance: M,
    /// How many numbers an element is made of.
    pub numbers: usize,
    /// Which groupoid, for the witness.
    pub of: String,
}

impl<Q: Groupoid + ?Sized, M: Fn(&Q::Element, &Q::Element) -> f64> Chain<'_, Q, M> {
    /// 2⁵ √m: m numbers are a matrix of √m rows.
    fn floor(&self) -> f64 {
        32.0 * (self.numbers.max(4) as f64).sqrt()
    }

    /// g = h; the ends exactly.
    fn equal(&self, g: &Q::Element, h: &Q::Element) -> f64 {
        let q = self.groupoid;
        let ends = q.source(g) == q.source(h) && q.target(g) == q.target(h);
        if ends { (self.distance)(g, h) } else { f64::INFINITY }
    }

    fn measured(&self, defect: f64, what: &str) -> Measured {
        let (amplification, floor) = (if defect.is_nan() { f64::INFINITY } else { defect }, self.floor());
        let mut witness = format!("{}{what}", self.of);
        if amplification > floor {
            let missing = " (ends differ, or a product or an inverse does not exist)";
            let [g, h, k] = self.elements;
            let why = if amplification.is_finite() { "" } else { missing };
            witness = format!("{witness}{why}; g₁ = {g:?}, g₂ = {h:?}, g₃ = {k:?}");
        }
        Measured::Defect { amplification, floor, witness }
    }

    /// One of Definition 4.1.
    pub fn axiom(&self, axiom: Axiom) -> Measured {
        let defect = axiom.defect(self.groupoid, self.elements.each_ref(), |g, h| self.equal(g, h));
        self.measured(defect, axiom.statement())
    }

    /// [`COMPOSABLE`].
    pub fn composable(&self) -> Measured {
        for pair in self.elements.windows(2) {
            let [g, h] = pair else { continue };
            let (target, source) = (self.groupoid.target(g), self.groupoid.source(h));
            if target != source {
                let of = &self.of;
                return Measured::Broken(format!("{of}β({g:?}) = {target:?}, but α({h:?}) = {source:?}"));
            }
        }
        Measured::exact()
    }

    /// [`REFUSAL`], of those of the pairs that do not meet.
    pub fn refusal<'b>(&self, pairs: impl IntoIterator<Item = (&'b Q::Element, &'b Q::Element)>) -> Measured
    where
        Q::Element: 'b,
    {
        let (q, of) = (self.groupoid, &self.of);
        let mut measured = Measured::NotApplicable("every pair of the chain is composable".into());
        for (first, second) in pairs {
            let (target, source) = (q.target(first), q.source(second));
            if target == source {
                continue;
            }
            measured = match q.compose(first, second) {
                Err(refused) if refused.target == target && refused.source_of_second == source => Measured::exact(),
                Err(refused) => return Measured::Broken(format!("{of}refused with other points: {refused}")),
                Ok(_) => {
                    return Measured::Broken(format!("{of}composed, though β(g) = {target:?} and α(h) = {source:?}"));
                }
            };
        }
        measured
    }
}

/// The chain of an instance.
fn chain<'a, T: Real>(
    instance: &'a Instance<'_, T>,
) -> Chain<'a, Flat<'a, T>, impl Fn(&DVector<T>, &DVector<T>) -> f64> {
    let unit = instance.scale * T::unit_roundoff();
    let distance = move |g: &DVector<T>, h: &DVector<T>| {
        if g.len() == h.len() { (max_abs(&(g - h)) / unit).to_f64() } else { f64::INFINITY }
    };
    let numbers = instance.chain[0].len();
    Chain {
        groupoid: instance.groupoid.as_ref(),
        elements: &instance.chain,
        distance,
        numbers,
        of: format!("{:?}: ", instance.kind),
    }
}

/// Definition 4.1 on one groupoid.
pub(super) fn axioms<T: Real>(instance: &Instance<'_, T>, fault: Option<&Fault>, probe: &mut Probe) -> Measured {
    let chain = chain(instance);
    let [g, h, k] = &instance.chain;
    // One unit of round-off off.
    let mut nudged = h.clone();
    let ulp = T::one() + T::unit_roundoff() * T::int(2);
    nudged.rows_mut(0, instance.groupoid.source(h).len()).apply(|v| *v *= ulp);
    let mut measured = Axiom::ALL
        .into_iter()
        .map(|axiom| chain.axiom(axiom))
        .fold(chain.composable().and(chain.refusal([(g, &nudged), (g, k)])), Measured::and);
    if let Some(excess) = &instance.excess {
        measured = measured.and(membership(instance, [g, h, k], excess, chain.floor()));
    }
    if instance.kind == GroupoidKind::Sphere {
        measured = measured.and(representatives::<T>(fault, probe));
    }
    measured
}

/// y = x·g, and so for products and inverses.
fn membership<T: Real>(
    instance: &Instance<'_, T>,
    [g, h, k]: [&DVector<T>; 3],
    excess: &dyn Fn(&DVector<T>) -> Option<DVector<T>>,
    floor: f64,
) -> Measured {
    let q = instance.groupoid.as_ref();
    let product = q.product(&q.product(g, h), k);
    let mut measured = Measured::NotApplicable("no element".into());
    for (element, name) in [(Some(g.clone()), "g"), (Some(product), "ghk"), (q.inverse(g), "g⁻¹")] {
        let Some(excess) = element.and_then(|element| excess(&element)) else {
            return Measured::Broken(format!("{name} is singular"));
        };
        let defect = excess.amax();
        // The action takes g or Ad_g once more.
        let size = instance.scale * instance.scale;
        measured =
            measured.and(Measured::defect(defect, size, floor, || format!("{:?}: y − x·g of {name}", instance.kind)));
    }
    measured
}

/// The class of a product does not depend on the pairs that represent the factors.
fn representatives<T: Real>(fault: Option<&Fault>, probe: &mut Probe) -> Measured {
    let [p, q, r, a, b, c] = match rotations(probe) {
        Ok(six) => six,
        Err(error) => return Measured::Broken(error.to_string()),
    };
    let atiyah = AtiyahGroupoid::<T>::new();
    let turn = |k: &Matrix<T, 3>| AtiyahGroupoid::divide(&Matrix::identity(), k);
    let class = |(p, q): &(Matrix<T, 3>, Matrix<T, 3>), k: &Matrix<T, 3>| (p * k, q * k);
    let (first, second) = ((p, q), (q * turn(&a), r));
    let size = UNMATCHED.size_in(fault);
    let product = |g: &(Matrix<T, 3>, Matrix<T, 3>), h: &(Matrix<T, 3>, Matrix<T, 3>)| {
        let right = atiyah.coordinates(&atiyah.compose(g, h).ok()?);
        Some(blend_vector(&right, &atiyah.coordinates(&(g.0, h.1)), size))
    };
    let one = product(&first, &second);
    let other = product(&class(&first, &turn(&b)), &class(&second, &turn(&c)));
    match (one, other) {
        (Some(one), Some(other)) => {
            Measured::defect(max_abs(&(one - other)), T::one(), 128.0, || "other representatives of the classes".into())
        }
        _ => Measured::Broken("other representatives of composable classes were refused".into()),
    }
}

fn translations<T: Real>(instance: &Instance<'_, T>) -> Measured {
    let [g, h, k] = instance.chain.each_ref();
    let q = instance.groupoid.as_ref();
    let left = |g: &DVector<T>, h: &DVector<T>| q.compose(g, h).ok();
    let right = |g: &DVector<T>, h: &DVector<T>| q.compose(h, g).ok();
    let compared = || {
        let (inverse, inverse_h) = (q.inverse(g)?, q.inverse(h)?);
        let (gh, hk) = (left(g, h)?, right(k, h)?);
        if q.source(&gh) != q.source(g) || q.target(&hk) != q.target(k) {
            return None;
        }
        Some([
            ("L_{g⁻¹} L_g h = h", left(&inverse, &gh)?, h.clone()),
            ("R_{h⁻¹} R_h g = g", right(&inverse_h, &right(h, g)?)?, g.clone()),
            ("L_g L_h k = L_{gh} k", left(g, &left(h, k)?)?, left(&gh, k)?),
            ("R_k R_h g = R_{hk} g", right(k, &right(h, g)?)?, right(&hk, g)?),
        ])
    };
    let Some(pairs) = compared() else {
        return Measured::Broken(format!("{:?}: a translation leaves its fibre", instance.kind));
    };
    let chain = chain(instance);
    pairs
        .into_iter()
        .map(|(what, one, other)| chain.measured(chain.equal(&one, &other), what))
        .fold(Measured::NotApplicable(String::new()), Measured::and)
}
