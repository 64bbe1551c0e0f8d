//! Laws of one discrete Lagrangian on G×G×G: any [`DiscreteLagrangian`] that a user writes, with its group and a retraction.
//!
//! A value that runs on dual numbers gets its slopes from [`Smooth`](crate::discrete::Smooth); then it is a discrete
//! Lagrangian like any other.

use super::super::discrete::{
    ANTISYMMETRIC, ANTISYMMETRIC_FAULTS, ANTISYMMETRIC_ORACLE, ANTISYMMETRIC_SOURCE, CONSTANT, DOUBLED, KEEPS_UNITS,
    Planted, STALE, U_SIGN, UNITS_BOUND, UNITS_FAULTS, UNITS_ORACLE, UNITS_SOURCE, V_RIGHT, VALUE, antisymmetry,
    inverse, refused, units,
};
use super::super::precision::Measured;
use super::differences::{compared, slope};
use super::group::{exponential, misfit};
use super::part::{About, Missing, Pair, Precisions, Subject, off};
use super::values::{Points, Values};
use crate::algebra::{Matrix, Vector, pair};
use crate::discrete::legendre::flow;
use crate::discrete::{DiscreteError, DiscreteLagrangian, Slopes, Triple};
use crate::group::{LieGroup, MatrixGroup};
use crate::harness::{Cost, Fault, Verdict};
use crate::retraction::{Exponential, Retraction};
use crate::scalar::{Dd, Real};
use proptest::strategy::{BoxedStrategy, Strategy};

/// A discrete Lagrangian with the group on which it lives and a retraction, by which flows are found.
///
/// ```
/// use euler_poincare::discrete::StageLagrangian;
/// use euler_poincare::group::So3;
/// use euler_poincare::laws::user::discrete::OnGroup;
/// use euler_poincare::laws::user::{Outcome, SuiteSettings};
/// use euler_poincare::mechanics::{doubled::Forced, force::Zero, lagrangian::Quadratic};
/// use euler_poincare::retraction::CayleySo3;
/// use euler_poincare::scalar::{Real, Scalar};
/// use euler_poincare::suite;
/// use euler_poincare::tableau::Family;
///
/// type Free<T> = Forced<Quadratic<T, 3>, Zero, CayleySo3<T>>;
/// type Midpoint<T> = StageLagrangian<T, Free<T>, CayleySo3<T>, 3, 3>;
///
/// /// The discrete Lagrangian of the midpoint rule for a free body.
/// fn midpoint<T: Real>() -> OnGroup<Midpoint<T>, So3<T>, CayleySo3<T>> {
///     let body = Quadratic::diagonal([T::one(), T::int(2), T::int(3)]).expect("regular");
///     let gauss = Family::Gauss.tableau(1).expect("one stage");
///     let free = Forced::new(body, Zero, CayleySo3::new());
///     OnGroup {
///         lagrangian: StageLagrangian::new(free, CayleySo3::new(), gauss, T::ratio(1, 8)),
///         group: So3::new(),
///         retraction: CayleySo3::new(),
///     }
/// }
///
/// suite! {
///     mod rule<T, 3, 3> { discrete: midpoint::<T>() }
/// }
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let outcome = rule::suite().run("discrete-memory", &SuiteSettings { cases: 2, ..SuiteSettings::new() });
/// assert!(matches!(outcome, Outcome::Held { .. }), "{outcome:?}");
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct OnGroup<L, G, R> {
    /// l_d.
    pub lagrangian: L,
    /// G.
    pub group: G,
    /// τ.
    pub retraction: R,
}

/// What [`OnGroup`] is, and [`Missing`] in its place.
#[doc(hidden)]
pub trait Discrete<T: Real, const N: usize, const D: usize> {
    /// l_d.
    type Lagrangian: DiscreteLagrangian<T, N, D>;
    /// G.
    type Group: LieGroup<T, N, D>;
    /// τ.
    type Retraction: Retraction<T, N, D>;

    /// l_d, G and τ.
    fn parts(&self) -> (&Self::Lagrangian, &Self::Group, &Self::Retraction);
}

impl<T, L, G, R, const N: usize, const D: usize> Discrete<T, N, D> for OnGroup<L, G, R>
where
    T: Real,
    L: DiscreteLagrangian<T, N, D>,
    G: LieGroup<T, N, D>,
    R: Retraction<T, N, D>,
{
    type Lagrangian = L;
    type Group = G;
    type Retraction = R;

    fn parts(&self) -> (&L, &G, &R) {
        (&self.lagrangian, &self.group, &self.retraction)
    }
}

impl<const N: usize, const D: usize> DiscreteLagrangian<Dd, N, D> for Missing {
    type Memory = ();

    fn value(&self, _: &Triple<Dd, D>) -> Result<Dd, DiscreteError> {
        match *self {}
    }

    fn slopes_from(&self, _: &Triple<Dd, D>, (): &mut ()) -> Result<Slopes<Dd, N>, DiscreteError> {
        match *self {}
    }
}

impl<const N: usize, const D: usize> Discrete<Dd, N, D> for Missing {
    type Lagrangian = Self;
    type Group = Self;
    type Retraction = Exponential<Dd, N, D, MatrixGroup<Dd, N, D>>;

    fn parts(&self) -> (&Self, &Self, &Self::Retraction) {
        match *self {}
    }
}

const DIFFERENCES: &str = "2⁸ times the estimated error of the differences, and 2⁶ N D u; in each precision by itself";

/// The laws of this file.
pub static LAWS: &[About] = &[
    About {
        name: "discrete-derivatives",
        statement: "L* and R* of D₁, D₂ and D₃l_d are the derivatives of the value along g exp(s ξ̂) and exp(s ξ̂) g",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §5",
        oracle: "differences of the value, extrapolated to fourth order",
        bound: DIFFERENCES,
        needs: "",
        faults: &[VALUE, V_RIGHT, U_SIGN, DOUBLED],
        cost: Cost::Cheap,
    },
    About {
        name: "discrete-memory",
        statement: "the slopes do not depend on what was evaluated before",
        source: "the contract of `slopes_from`",
        oracle: "the slopes without a memory",
        bound: "two precisions; floor 2⁸ N D u of the slopes",
        needs: "",
        faults: &[STALE],
        cost: Cost::Cheap,
    },
    About {
        name: "discrete-regular",
        statement: "the discrete Euler–Lagrange equations have a regular Jacobian at (V, e, V)",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §5",
        oracle: "the pivots in Newton's method for the flow: one that vanishes; nearly singular ones are inconclusive",
        bound: "none: regular or not",
        needs: "",
        faults: &[CONSTANT],
        cost: Cost::Expensive,
    },
    About {
        name: "discrete-equations",
        statement: "along the flow the action of two steps is stationary: d/ds of l_d(V₁e^{sξ}, U₁, W₁e^{sσ}) + \
                    l_d(e^{−sξ}V₂, e^{−sξ}U₂e^{sσ}, e^{−sσ}W₂) is 0 at s = 0",
        source: "Martín de Diego and Sato Martín de Almagro 2019, Prop 5.1 and (5.2)",
        oracle: "differences of the value; the flow is found from the slopes",
        bound: DIFFERENCES,
        needs: "",
        faults: &[V_RIGHT, DOUBLED, VALUE],
        cost: Cost::Expensive,
    },
    About {
        name: "discrete-antisymmetry",
        statement: ANTISYMMETRIC,
        source: ANTISYMMETRIC_SOURCE,
        oracle: ANTISYMMETRIC_ORACLE,
        bound: "two precisions; floor 2⁸ N D u of the value and of slopes times displacements",
        needs: "the claim `antisymmetric`: l_d comes from a forced system",
        faults: ANTISYMMETRIC_FAULTS,
        cost: Cost::Cheap,
    },
    About {
        name: "discrete-units",
        statement: KEEPS_UNITS,
        source: UNITS_SOURCE,
        oracle: UNITS_ORACLE,
        bound: UNITS_BOUND,
        needs: "the claim `antisymmetric` or `keeps_units`",
        faults: UNITS_FAULTS,
        cost: Cost::Expensive,
    },
];

/// A user's discrete Lagrangian, at both precisions or in `f64` alone, with claims.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct UserDiscrete<A, B, const N: usize, const D: usize> {
    parts: Pair<A, B>,
    largest: f64,
    antisymmetric: bool,
    units: bool,
}

impl<A: Discrete<f64, N, D>, const N: usize, const D: usize> UserDiscrete<A, Missing, N, D> {
    /// The discrete Lagrangian in `f64` alone.
    pub fn in_double(part: A) -> Self {
        Self { parts: Pair { double: part, quad: None }, largest: 0.25, antisymmetric: false, units: false }
    }
}

impl<A, B, const N: usize, const D: usize> UserDiscrete<A, B, N, D>
where
    A: Discrete<f64, N, D>,
    B: Discrete<Dd, N, D>,
{
    /// The same discrete Lagrangian in `f64` and in 32 digits.
    pub fn at_both(double: A, quad: B) -> Self {
        Self::of(double, Some(quad))
    }

    /// It in `f64`, and in 32 digits where it is given.
    pub(in crate::laws) fn of(double: A, quad: Option<B>) -> Self {
        Self { parts: Pair { double, quad }, largest: 0.25, antisymmetric: false, units: false }
    }

    /// Only V, U and W that are exp of vectors with components of at most `largest` (default ¼).
    pub fn within(self, largest: f64) -> Self {
        Self { largest, ..self }
    }

    /// Claims l_d(W, U⁻¹, V) = −l_d(V, U, W), and with it that the flow keeps the units.
    pub fn antisymmetric(self) -> Self {
        Self { antisymmetric: true, ..self }
    }

    /// Claims that the flow keeps the units, for an l_d that is antisymmetric to first order on them alone.
    pub fn keeps_units(self) -> Self {
        Self { units: true, ..self }
    }
}

impl<A, B, const N: usize, const D: usize> Subject for UserDiscrete<A, B, N, D>
where
    A: Discrete<f64, N, D> + Send + Sync + 'static,
    B: Discrete<Dd, N, D> + Send + Sync + 'static,
{
    const LAWS: &'static [About] = LAWS;

    fn precisions(&self) -> Precisions {
        self.parts.precisions()
    }

    fn missing(&self, law: &About) -> Option<&'static str> {
        match law.name {
            "discrete-antisymmetry" if !self.antisymmetric => Some("it is not said to be antisymmetric"),
            "discrete-units" if !(self.antisymmetric || self.units) => Some("it is not said to keep the units"),
            _ => None,
        }
    }

    fn cases(&self, law: &About) -> BoxedStrategy<Values> {
        let points = Points::new().within(self.largest);
        match law.name {
            "discrete-derivatives" => points.vectors(&["v", "u", "w"], N).vectors(&["along"], N),
            "discrete-memory" => points.vectors(&["v", "u", "w", "before"], N),
            "discrete-antisymmetry" => points.vectors(&["v", "u", "w"], N),
            "discrete-equations" => points.vectors(&["v", "along", "partner"], N),
            _ => points.vectors(&["v"], N),
        }
        .boxed()
    }

    fn check(&self, law: &About, case: &Values, fault: Option<&Fault>) -> Verdict {
        let double = |part: &A| judge::<f64, A, N, D>(part, law.name, case, fault);
        let quad = |part: &B| judge::<Dd, B, N, D>(part, law.name, case, fault);
        match law.name {
            "discrete-derivatives" | "discrete-equations" => self.parts.each(double, quad),
            _ => self.parts.settle(double, quad),
        }
    }
}

type Answer = Result<Measured, Measured>;

/// A unit and where the flow takes it.
struct Step<T: Real, const D: usize> {
    start: Triple<T, D>,
    end: Result<Triple<T, D>, DiscreteError>,
}

struct Judge<'a, T: Real, S: Discrete<T, N, D>, const N: usize, const D: usize> {
    l_d: Planted<'a, &'a S::Lagrangian>,
    fault: Option<&'a Fault>,
    group: &'a S::Group,
    retraction: &'a S::Retraction,
    case: &'a Values,
    floor: f64,
}

fn judge<T: Real, S: Discrete<T, N, D>, const N: usize, const D: usize>(
    part: &S,
    law: &str,
    case: &Values,
    fault: Option<&Fault>,
) -> Answer {
    let (l_d, group, retraction) = part.parts();
    let l_d = Planted { l_d, fault };
    let judge = Judge::<T, S, N, D> { l_d, fault, group, retraction, case, floor: 256.0 * (N * D) as f64 };
    match law {
        "discrete-derivatives" => judge.slopes(),
        "discrete-memory" => judge.memory(),
        "discrete-antisymmetry" => judge.antisymmetric(),
        "discrete-units" => judge.units(),
        "discrete-regular" => judge.regular(),
        "discrete-equations" => judge.equations(),
        other => Err(Measured::Broken(format!("there is no law `{other}` of discrete Lagrangians"))),
    }
}

/// The largest slope.
fn largest<T: Real, const N: usize>(slopes: &Slopes<T, N>) -> T {
    let all = [slopes.v_left, slopes.v_right, slopes.u_left, slopes.u_right, slopes.w_left, slopes.w_right];
    all.iter().fold(T::zero(), |size, row| size.max(row.amax()))
}

impl<T: Real, S: Discrete<T, N, D>, const N: usize, const D: usize> Judge<'_, T, S, N, D> {
    fn vector(&self, name: &str) -> Result<Vector<T, N>, Measured> {
        self.case.vector(name).map_err(misfit)
    }

    /// exp(x̂).
    fn exp(&self, x: &Vector<T, N>) -> Matrix<T, D> {
        exponential(&self.group.hat(x))
    }

    fn triple(&self) -> Result<Triple<T, D>, Measured> {
        let element = |name: &str| Ok::<_, Measured>(self.exp(&self.vector(name)?));
        Ok(Triple { v: element("v")?, u: element("u")?, w: element("w")? })
    }

    /// The value of the part itself: with the faults of the value, and with none of the slopes.
    fn value(&self, x: &Triple<T, D>) -> Result<T, Measured> {
        let value = DiscreteLagrangian::<T, N, D>::value(&self.l_d, x).map_err(refused)?;
        match value.all_finite() {
            true => Ok(value),
            false => Err(Measured::Broken(format!("l_d = {}", value.to_f64()))),
        }
    }

    fn slopes_at(&self, x: &Triple<T, D>) -> Result<Slopes<T, N>, Measured> {
        let slopes = self.l_d.slopes(x).map_err(refused)?;
        match largest(&slopes).all_finite() {
            true => Ok(slopes),
            false => Err(Measured::Broken("a slope is not finite".into())),
        }
    }

    fn slopes(&self) -> Answer {
        let (x, along) = (self.triple()?, self.vector("along")?);
        let length = along.amax();
        self.value(&x)?;
        let slopes = self.slopes_at(&x)?;
        if length == T::zero() {
            return Ok(Measured::exact());
        }
        // A step of at most 1/16.
        let scale = T::exact(0.0625) / length;
        let size = largest(&slopes) * length;
        let mut measured = Measured::exact();
        let names = ["L*D₁", "R*D₁", "L*D₂", "R*D₂", "L*D₃", "R*D₃"];
        let rows = [slopes.v_left, slopes.v_right, slopes.u_left, slopes.u_right, slopes.w_left, slopes.w_right];
        for (k, (name, row)) in names.iter().zip(rows).enumerate() {
            let value = |s: T| {
                let turn = self.exp(&(along * s));
                let side = |g: &Matrix<T, D>| if k % 2 == 0 { g * turn } else { turn * g };
                let moved = match k / 2 {
                    0 => Triple { v: side(&x.v), ..x },
                    1 => Triple { u: side(&x.u), ..x },
                    _ => Triple { w: side(&x.w), ..x },
                };
                self.value(&moved).ok()
            };
            let slope =
                slope(value, scale, size).ok_or(Measured::NotApplicable("a point is outside the domain".into()))?;
            measured = measured.and(compared(pair(&row, &along), &slope, size, self.floor, name));
        }
        Ok(measured)
    }

    fn memory(&self) -> Answer {
        let x = self.triple()?;
        let turn = self.exp(&self.vector("before")?);
        let before = Triple { v: x.v * turn, u: x.u, w: x.w * turn };
        let fresh = self.slopes_at(&x)?;
        let mut memory = <Planted<'_, &S::Lagrangian> as DiscreteLagrangian<T, N, D>>::Memory::default();
        self.l_d.slopes_from(&before, &mut memory).map_err(refused)?;
        let again = self.l_d.slopes_from(&x, &mut memory).map_err(refused)?;
        let size = largest(&fresh).max(largest(&again));
        let pairs = [
            ("L*D₁", fresh.v_left, again.v_left),
            ("R*D₁", fresh.v_right, again.v_right),
            ("L*D₂", fresh.u_left, again.u_left),
            ("R*D₂", fresh.u_right, again.u_right),
            ("L*D₃", fresh.w_left, again.w_left),
            ("R*D₃", fresh.w_right, again.w_right),
        ];
        let measured = pairs.iter().map(|(name, a, b)| {
            Measured::defect(off(a, b), size, self.floor, || format!("{name} differs with a memory"))
        });
        Ok(measured.fold(Measured::exact(), Measured::and))
    }

    fn antisymmetric(&self) -> Answer {
        let x = self.triple()?;
        let values = [self.value(&x)?, self.value(&inverse(&x, self.fault)?)?];
        let slopes = self.slopes_at(&x)?;
        let (v, u, w) = (self.vector("v")?, self.vector("u")?, self.vector("w")?);
        let size = values[0].abs() + largest(&slopes) * (v.amax() + u.amax() + w.amax());
        Ok(antisymmetry(values, size, self.floor))
    }

    /// (V, e, V) and where the flow takes it.
    fn step(&self) -> Result<Step<T, D>, Measured> {
        let start = Triple::unit(self.exp(&self.vector("v")?));
        self.slopes_at(&start)?;
        Ok(Step { start, end: flow(&self.l_d, &self.l_d, self.retraction, &start) })
    }

    fn units(&self) -> Answer {
        let next = self.step()?.end.map_err(refused)?;
        Ok(units::<T, N, D>(&next))
    }

    fn regular(&self) -> Answer {
        match self.step()?.end {
            Err(error @ DiscreteError::Singular { .. }) => Ok(Measured::Broken(error.to_string())),
            Err(error) => Err(refused(error)),
            Ok(_) => Ok(Measured::exact()),
        }
    }

    fn equations(&self) -> Answer {
        let Step { start: x, end } = self.step()?;
        let y = end.map_err(refused)?;
        let (first, second) = (self.vector("along")?, self.vector("partner")?);
        let length = first.amax().max(second.amax());
        if length == T::zero() {
            return Ok(Measured::exact());
        }
        let action = |s: T| {
            let turns = [&first, &second].map(|x| (self.exp(&(x * s)), self.exp(&(x * -s))));
            let [(p, p_back), (q, q_back)] = &turns;
            let one = Triple { v: x.v * p, u: x.u, w: x.w * q };
            let two = Triple { v: p_back * y.v, u: p_back * y.u * q, w: q_back * y.w };
            Some(self.value(&one).ok()? + self.value(&two).ok()?)
        };
        // The equations are solved to rounding: slopes that cancel.
        let size = (largest(&self.slopes_at(&x)?) + largest(&self.slopes_at(&y)?)) * length;
        let slope = slope(action, T::exact(0.0625) / length, size);
        let slope = slope.ok_or(Measured::NotApplicable("a point is outside the domain".into()))?;
        Ok(compared(T::zero(), &slope, size, self.floor, "the variation of the action of two steps"))
    }
}
