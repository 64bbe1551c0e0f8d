//! Laws of one discrete Lagrangian on G×G×G: any [`DiscreteLagrangian`] that a user writes, with its group and a retraction.
//!
//! A value that runs on dual numbers gets its slopes from [`Smooth`](crate::discrete::Smooth); then it is a discrete
//! Lagrangian like any other.

use super::super::differences::{compared, reach, slope};
use super::super::discrete::{
    ANTISYMMETRY, CONSTANT, DOUBLED, Planted, SLOPES, STALE, UNITS, V_RIGHT, VALUE, antisymmetry, largest, slopes,
    units,
};
use super::super::method::exponential;
use super::super::precision::Measured;
use super::part::{Answer, Answers, Asked, Kind, Part, off, part_laws};
use super::values::ValuesError;
use crate::algebra::{Matrix, Vector};
use crate::discrete::legendre::flow;
use crate::discrete::{DiscreteError, DiscreteLagrangian, Triple};
use crate::group::LieGroup;
use crate::harness::{About, Cost};
use crate::retraction::Retraction;
use crate::scalar::Real;
use std::marker::PhantomData;

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

const DIFFERENCES: &str = "2⁸ times the estimated error of the differences with 2⁸ N D u; in each precision by itself";

part_laws! {
    /// The laws of this file.
    LAWS FIELDS __own_discrete;
    every {
        discrete_memory "v u w before" About {
            name: "",
            statement: "the slopes do not depend on what was evaluated before",
            source: "the contract of `slopes_from`",
            oracle: "the slopes without a memory",
            bound: "two precisions; floor 2⁸ N D u of the slopes",
            needs: "",
            faults: &[STALE],
            cost: Cost::Cheap,
        };
        discrete_regular "v" About {
            name: "",
            statement: "the discrete Euler–Lagrange equations have a regular Jacobian at (V, e, V)",
            source: "Martín de Diego and Sato Martín de Almagro 2019, §5",
            oracle: "the pivots in Newton's method for the flow: one that vanishes; nearly singular ones are inconclusive",
            bound: "none: regular or not",
            needs: "",
            faults: &[CONSTANT],
            cost: Cost::Expensive,
        };
        discrete_equations "v along partner" About {
            name: "",
            statement: "along the flow the action of two steps is stationary: d/ds of l_d(V₁e^{sξ}, U₁, W₁e^{sσ}) + \
                        l_d(e^{−sξ}V₂, e^{−sξ}U₂e^{sσ}, e^{−sσ}W₂) is 0 at s = 0",
            source: "Martín de Diego and Sato Martín de Almagro 2019, Prop 5.1 and (5.2)",
            oracle: "differences of the value; the flow is found from the slopes",
            bound: DIFFERENCES,
            needs: "",
            faults: &[V_RIGHT, DOUBLED, VALUE],
            cost: Cost::Expensive,
        };
        discrete_slopes "v u w along_v along_u along_w" SLOPES;
        discrete_antisymmetry "v u w" ANTISYMMETRY;
        discrete_units "v" UNITS;
    }
}

/// A user's discrete Lagrangian, with claims. V, U and W are exp of vectors whose components are at most the largest number of a case.
#[doc(hidden)]
pub type UserDiscrete<const N: usize, const D: usize> = Part<DiscreteLaws<N, D>>;

/// The laws on discrete Lagrangians.
#[derive(Default)]
#[doc(hidden)]
pub struct DiscreteLaws<const N: usize, const D: usize> {
    antisymmetric: bool,
    units: bool,
}

impl<const N: usize, const D: usize> UserDiscrete<N, D> {
    /// Claims l_d(W, U⁻¹, V) = −l_d(V, U, W), and with it that the flow keeps the units.
    pub fn antisymmetric(mut self) -> Self {
        self.kind.antisymmetric = true;
        self
    }

    /// Claims that the flow keeps the units, for an l_d that is antisymmetric to first order on them alone.
    pub fn keeps_units(mut self) -> Self {
        self.kind.units = true;
        self
    }
}

impl<const N: usize, const D: usize> Kind for DiscreteLaws<N, D> {
    const LAWS: &'static [About] = LAWS;
    const FIELDS: &'static [(&'static str, &'static str)] = FIELDS;
    const DIMENSION: usize = N;
    const LARGEST: f64 = 0.25;
    const APART: &'static [&'static str] = &["discrete-slopes", "discrete-equations"];

    fn missing(&self, law: &str) -> Option<&'static str> {
        match law {
            "discrete-antisymmetry" if !self.antisymmetric => Some("it is not said to be antisymmetric"),
            "discrete-units" if !(self.antisymmetric || self.units) => Some("it is not said to keep the units"),
            _ => None,
        }
    }
}

impl<T: Real, L, G, R, const N: usize, const D: usize> Answers<T, DiscreteLaws<N, D>> for OnGroup<L, G, R>
where
    L: DiscreteLagrangian<T, N, D> + Send + Sync + 'static,
    G: LieGroup<T, N, D> + Send + Sync + 'static,
    R: Retraction<T, N, D> + Send + Sync + 'static,
{
    fn answer(&self, asked: &Asked<'_, DiscreteLaws<N, D>>) -> Answer {
        let l_d = Planted { l_d: &self.lagrangian, fault: asked.fault };
        let judge = Judge { l_d, on: self, asked, floor: 256.0 * (N * D) as f64, scalar: PhantomData::<T> };
        match asked.law.name {
            "discrete-slopes" => judge.slopes(),
            "discrete-memory" => judge.memory(),
            "discrete-antisymmetry" => antisymmetry(&judge.l_d, &judge.triple()?),
            "discrete-units" => units(&judge.l_d, &self.retraction, judge.element("v")?),
            "discrete-regular" => judge.regular(),
            "discrete-equations" => judge.equations(),
            _ => asked.unknown("discrete Lagrangians"),
        }
    }
}

struct Judge<'a, T, L, G, R, const N: usize, const D: usize> {
    l_d: Planted<'a, &'a L>,
    on: &'a OnGroup<L, G, R>,
    asked: &'a Asked<'a, DiscreteLaws<N, D>>,
    floor: f64,
    scalar: PhantomData<T>,
}

impl<T: Real, L, G, R, const N: usize, const D: usize> Judge<'_, T, L, G, R, N, D>
where
    L: DiscreteLagrangian<T, N, D>,
    G: LieGroup<T, N, D>,
    R: Retraction<T, N, D>,
{
    fn vector(&self, name: &str) -> Result<Vector<T, N>, ValuesError> {
        self.asked.case.vector(name)
    }

    /// exp(x̂).
    fn exp(&self, x: &Vector<T, N>) -> Matrix<T, D> {
        exponential(&self.on.group.hat(x))
    }

    /// exp of the vector of that name.
    fn element(&self, name: &str) -> Result<Matrix<T, D>, Measured> {
        Ok(self.exp(&self.vector(name)?))
    }

    fn triple(&self) -> Result<Triple<T, D>, Measured> {
        Ok(Triple { v: self.element("v")?, u: self.element("u")?, w: self.element("w")? })
    }

    fn slopes(&self) -> Answer {
        let along = [self.vector("along_v")?, self.vector("along_u")?, self.vector("along_w")?];
        // Differences over at most 1/16.
        let length = along.iter().fold(T::exact(0.0625), |length, along| length.max(along.amax()));
        slopes(&self.l_d, &self.on.group, |x| Ok(self.exp(x)), &self.triple()?, &along, T::exact(0.0625) / length)
    }

    fn memory(&self) -> Answer {
        let x = self.triple()?;
        let turn = self.exp(&self.vector("before")?);
        let before = Triple { v: x.v * turn, u: x.u, w: x.w * turn };
        let fresh = self.l_d.rows(&x)?;
        let mut memory = <Planted<'_, &L> as DiscreteLagrangian<T, N, D>>::Memory::default();
        self.l_d.slopes_from(&before, &mut memory)?;
        let again = self.l_d.slopes_from(&x, &mut memory)?;
        let size = largest(&fresh).max(largest(&again));
        let names = ["L*D₁", "R*D₁", "L*D₂", "R*D₂", "L*D₃", "R*D₃"];
        let measured = names.iter().zip(fresh.all()).zip(again.all()).map(|((name, a), b)| {
            Measured::defect(off(a, b), size, self.floor, || format!("{name} differs with a memory"))
        });
        Ok(measured.fold(Measured::exact(), Measured::and))
    }

    /// (V, e, V).
    fn start(&self) -> Result<Triple<T, D>, Measured> {
        let start = Triple::unit(self.element("v")?);
        self.l_d.rows(&start)?;
        Ok(start)
    }

    /// Where the flow takes it.
    fn after(&self, start: &Triple<T, D>) -> Result<Triple<T, D>, DiscreteError> {
        flow(&self.l_d, &self.l_d, &self.on.retraction, start)
    }

    fn regular(&self) -> Answer {
        match self.after(&self.start()?) {
            Err(error @ DiscreteError::Singular { .. }) => Ok(Measured::Broken(error.to_string())),
            Err(error) => Err(error.into()),
            Ok(_) => Ok(Measured::exact()),
        }
    }

    fn equations(&self) -> Answer {
        let x = self.start()?;
        let y = self.after(&x)?;
        let (first, second) = (self.vector("along")?, self.vector("partner")?);
        let length = first.amax().max(second.amax());
        if length == T::zero() {
            return Ok(Measured::exact());
        }
        let moved = |s: T| {
            let turns = [&first, &second].map(|x| (self.exp(&(x * s)), self.exp(&(x * -s))));
            let [(p, p_back), (q, q_back)] = &turns;
            let one = Triple { v: x.v * p, u: x.u, w: x.w * q };
            let two = Triple { v: p_back * y.v, u: p_back * y.u * q, w: q_back * y.w };
            [one, two]
        };
        let action = |s: T| {
            let [one, two] = moved(s);
            Some(self.l_d.number::<T, N, D>(&one).ok()? + self.l_d.number::<T, N, D>(&two).ok()?)
        };
        // The equations are solved to rounding: slopes that cancel.
        let size = (largest(&self.l_d.rows(&x)?) + largest(&self.l_d.rows(&y)?)) * length;
        let scale = T::exact(0.0625) / length;
        let [one, two] = moved(reach(scale));
        let far = (largest(&self.l_d.rows(&one)?) + largest(&self.l_d.rows(&two)?)) * length;
        // At rest the slopes vanish, and what is left is rounding of those at displaced points.
        let beyond = (far - size).max(T::zero());
        let slope = slope(action, scale, size + beyond);
        let slope = slope.ok_or(Measured::NotApplicable("a point is outside the domain".into()))?;
        Ok(compared(T::zero(), &slope, size, beyond, self.floor, "the variation of the action of two steps"))
    }
}
