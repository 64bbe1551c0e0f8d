//! What a law asks of a case, and the way from there to a verdict.
//!
//! Most laws are identities of one system, at a point that the case determines. Such a law is a header with a bound, cases and a
//! [`Question`] ([`law`]). [`ask`] builds the system of a case in `f64` and, as the bound says ([`Precisions`]), in 32 digits; the
//! question measures a defect on each ([`Measured`]), and [`precision`](super::precision) makes one verdict of them. A question
//! that is judged in one scalar, by a bound of its own, is a [`Trial`] ([`tried`]).

use super::planted::retraction::{Plant, ROUNDED};
pub use super::precision::Measured;
use super::precision::{DRAWN, Evaluations, SHARE, USUAL, alone, in_quad, moved, only_in};
pub use super::probe::stream;
use super::probe::{Probe, unit_of};
use super::sizes::turning;
pub use super::user::part::Answer;
use super::{Source, unbuilt};
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::MatrixGroup;
use crate::harness::{Fault, Verdict};
use crate::integrators::StepError;
use crate::mechanics::doubled::{VelocityError, VelocityPoint};
use crate::mechanics::{Lagrangian as _, LegendreError};
use crate::retraction::{AnyRetraction, Retraction as _, RetractionError};
use crate::scalar::{Dd, Real};
use crate::system::dispatch::Main;
use crate::system::{Case, CaseError, System, Visitor};
use std::fmt::Debug;

/// In which precisions a law is judged.
#[derive(Clone, Copy)]
pub enum Precisions {
    /// In both.
    Both,
    /// In 32 digits only where the number of unknowns s N of a step is at most this, in one of ten other cases, and where the defect in `f64`
    /// asks for it.
    Small(usize),
    /// Likewise, and each by itself: measurements that are not in units of round-off.
    Apart(usize),
}

impl Precisions {
    /// Whether a case is judged in 32 digits whatever its defect in `f64` is.
    fn in_quad<S: Source>(self, source: &S) -> Result<bool, CaseError> {
        match self {
            Self::Both => Ok(true),
            Self::Small(most) | Self::Apart(most) => in_quad(source, most),
        }
    }
}

/// The [`Precisions`] of a bound, and the text of the bound, which says them: s N of the one is that of the other. The floor stands in the text
/// and in what the question measures ([`Measured::defect`]).
macro_rules! precisions {
    (check both($($text:expr),+)) => {
        $crate::laws::question::Precisions::Both
    };
    (check small($most:literal, $($text:expr),+)) => {
        $crate::laws::question::Precisions::Small($most)
    };
    (check apart($most:literal, $($text:expr),+)) => {
        $crate::laws::question::Precisions::Apart($most)
    };
    (text both($bound:expr)) => {
        concat!("two precisions; ", $bound)
    };
    (text small($most:literal, $bound:expr)) => {
        concat!(
            "two precisions (s N > ",
            $most,
            ": f64 alone below 8 u or a 2⁹th of the floor, but for one case in ten); ",
            $bound
        )
    };
    (text small($most:literal, $before:expr, $after:expr)) => {
        concat!($before, $most, $after)
    };
    (text apart($most:literal, $rounding:expr)) => {
        concat!(
            "the estimated error of the differences with ",
            $rounding,
            "; where it is above, in one case of ten, and where s N ≤ ",
            $most,
            ": 2⁸ times that, in each precision by itself"
        )
    };
}
pub(in crate::laws) use precisions;

/// The numbers in the text of `small`.
const _: () = assert!(USUAL == 8.0 && SHARE == 512.0 && DRAWN == 10);

/// A law: its header, its cases, and what it asks of them (`asks`, a [`Question`]) or how it judges them (`check`). What `on` makes of a
/// case is what is asked about, where it is given; without a `cost` it is cheap.
///
/// The bound of a question is `both("floor …")`, `small(9, "floor …")` for [`Precisions::Small`], where `small(9, "before", "after")` has
/// the number in a text of its own, or `apart(9, "rounding")` for [`Precisions::Apart`].
macro_rules! law {
    (Law {
        name: $name:expr,
        statement: $statement:expr,
        source: $source:expr,
        oracle: $oracle:expr,
        bound: $how:ident $bound:tt,
        needs: $needs:expr,
        $(cost: $cost:expr,)?
        faults: $faults:expr,
        cases: $cases:expr,
        $(on: $on:expr,)?
        asks: $question:expr $(,)?
    }) => {
        $crate::laws::question::law!(Law {
            name: $name,
            statement: $statement,
            source: $source,
            oracle: $oracle,
            bound: $crate::laws::question::precisions!(text $how $bound),
            needs: $needs,
            $(cost: $cost,)?
            faults: $faults,
            cases: $cases,
            check: $crate::laws::question::law!(@asks $how $bound, $question $(, $on)?),
        })
    };
    (Law {
        $(needs: $needs:expr,)?
        bound: $how:ident $bound:tt,
        cases: $cases:expr,
        $(on: $on:expr,)?
        asks: $question:expr,
        ..$about:expr
    }) => {
        $crate::laws::CaseLaw {
            about: $crate::harness::About {
                bound: $crate::laws::question::precisions!(text $how $bound),
                $(needs: $needs,)?
                ..$about
            },
            cases: $cases,
            check: $crate::laws::question::law!(@asks $how $bound, $question $(, $on)?),
        }
    };
    (Law {
        name: $name:expr,
        statement: $statement:expr,
        source: $source:expr,
        oracle: $oracle:expr,
        bound: $bound:expr,
        needs: $needs:expr,
        $(cost: $cost:expr,)?
        faults: $faults:expr,
        cases: $cases:expr,
        check: $check:expr $(,)?
    }) => {
        $crate::laws::CaseLaw {
            about: $crate::harness::About {
                name: $name,
                statement: $statement,
                source: $source,
                oracle: $oracle,
                bound: $bound,
                needs: $needs,
                cost: $crate::laws::question::law!(@cost $($cost)?),
                faults: $faults,
            },
            cases: $cases,
            check: $check,
        }
    };
    (@cost) => { $crate::harness::Cost::Cheap };
    (@cost $cost:expr) => { $cost };
    (@asks $how:ident $bound:tt, $question:expr $(, $on:expr)?) => {
        |case, fault| {
            $(let case = &$on(case);)?
            $crate::laws::question::ask(case, fault, $question, $crate::laws::question::precisions!(check $how $bound))
        }
    };
}
pub(in crate::laws) use law;

/// The verdict on a question about a case, with a fault planted or none: in its retraction if it is one of
/// [`retraction::ALL`](super::planted::retraction::ALL), else in what the question plants it in.
pub fn ask<S: Source>(source: &S, fault: Option<&Fault>, question: impl Question, precisions: Precisions) -> Verdict {
    let asked = Asked { case: source, fault, question };
    let quad = |sample: Option<u32>, planted: Option<&Fault>| {
        let nearby = sample.map(|sample| source.with_case(moved(source.case(), sample)));
        nearby.as_ref().unwrap_or(source).visit::<Dd, _>(&Plant(planted), asked)
    };
    let evaluations = Evaluations {
        double: &|| source.visit::<f64, _>(&Plant(fault), asked),
        quad: &|| quad(None, fault),
        nearby: &|sample| quad(Some(sample), fault),
        // Without the fault in the retraction: its condition is not that of the problem.
        rounded: &|sample| quad(Some(sample), Some(&ROUNDED.with_size(f64::from(sample + 1)))),
    };
    match precisions.in_quad(source) {
        Ok(chosen) => evaluations.judged(chosen, matches!(precisions, Precisions::Apart(_))),
        Err(e) => unbuilt(&e),
    }
}

/// The same in 32 digits alone.
pub fn ask_in_quad<S: Source>(source: &S, fault: Option<&Fault>, question: impl Question) -> Verdict {
    only_in(32, source.visit::<Dd, _>(&Plant(fault), Asked { case: source, fault, question }))
}

/// What a law asks of a problem, in either precision.
pub trait Question: Copy {
    /// The stream of the case; `None` where nothing is drawn.
    const STREAM: Option<u64> = None;

    /// [`Visitor::LARGE`]: whether it is asked of systems above dimension 6. Where it is not, the law's cases are `main_dimensions()`.
    const LARGE: bool = false;

    /// [`Visitor::KNOWS_CONFIGURATION`].
    const KNOWS_CONFIGURATION: bool = false;

    /// What the law measures.
    ///
    /// # Errors
    /// What it means that nothing can be measured.
    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer;
}

/// A question about a case; a [`Trial`] in another type.
#[derive(Clone, Copy)]
struct Asked<'a, Q> {
    case: &'a dyn Debug,
    fault: Option<&'a Fault>,
    question: Q,
}

impl<'a, Q> Asked<'a, Q> {
    /// The problem of a system, with numbers from one of the streams of the case or without.
    fn problem<T: Real, const N: usize, const D: usize>(
        &self,
        system: &'a System<T, N, D>,
        stream: Option<u64>,
    ) -> Problem<'a, T, N, D> {
        let probe = stream.map_or_else(Probe::none, |stream| Probe::new(self.case, stream));
        Problem { system, case: self.case, probe, fault: self.fault }
    }
}

impl<T: Real, Q: Question> Visitor<T> for Asked<'_, Q> {
    type Output = Measured;

    const LARGE: bool = Q::LARGE;

    const KNOWS_CONFIGURATION: bool = Q::KNOWS_CONFIGURATION;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Measured {
        self.question.measure(self.problem(&system, Q::STREAM)).unwrap_or_else(|refused| refused)
    }
}

/// A case as a problem: its system, further numbers that the case determines, and what is planted.
pub struct Problem<'a, T: Real, const N: usize, const D: usize> {
    /// The system.
    pub system: &'a System<T, N, D>,
    /// The case, of which the draws are made.
    pub case: &'a dyn Debug,
    /// The numbers; of a law without a stream there are none.
    pub probe: Probe,
    /// What is planted.
    pub fault: Option<&'a Fault>,
}

impl<'a, T: Real, const N: usize, const D: usize> Problem<'a, T, N, D> {
    /// The numbers of another stream of the case.
    pub fn draws(&self, stream: u64) -> Probe {
        Probe::new(self.case, stream)
    }

    /// A point off the units: η of the state, ψ that differs from it by shares `apart` of its size, U = τ(x) with |x| up to `far`.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform and of τ.
    pub fn off_the_units(&mut self, apart: f64, far: f64) -> Result<VelocityPoint<T, N, D>, VelocityError> {
        let (system, probe) = (self.system, &mut self.probe);
        let eta = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros())?;
        let psi = eta + probe.vector::<T, N>() * (unit_of(&eta) * T::exact(apart));
        let u = system.retraction.tau(&(probe.vector::<T, N>() * T::exact(far)))?;
        Ok(VelocityPoint { time: system.state.time, eta, u, psi })
    }

    /// The group.
    ///
    /// # Errors
    /// There is none.
    pub fn group(&self) -> Result<&'a MatrixGroup<T, N, D>, Measured> {
        self.system.group.as_ref().ok_or_else(no_group)
    }

    /// [`turning`] on the algebra.
    pub fn turning(&self, xi: &Vector<T, N>, mu: &Covector<T, N>) -> T {
        turning(&self.system.algebra, xi, mu)
    }

    /// Units of round-off per dimension.
    pub fn floor(&self, units: f64) -> f64 {
        units * self.system.dimension as f64
    }
}

/// A group element that has no inverse.
pub fn singular() -> Measured {
    Measured::Broken("a group element is a singular matrix".into())
}

fn no_group() -> Measured {
    Measured::NotApplicable("the algebra has no group".into())
}

/// A question that is judged in one scalar, by a bound of its own.
pub trait Trial<T: Real>: Copy {
    /// The stream of the case; `None` where nothing is drawn.
    const STREAM: Option<u64> = None;

    /// [`Visitor::LARGE`].
    const LARGE: bool = false;

    /// [`Visitor::KNOWS_CONFIGURATION`].
    const KNOWS_CONFIGURATION: bool = false;

    /// The verdict.
    ///
    /// # Errors
    /// What it means that there is none.
    fn judge<const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Result<Verdict, Measured>;
}

/// A [`Trial`] of a case.
struct Tried<'a, Q>(Asked<'a, Q>);

impl<T: Real, Q: Trial<T>> Visitor<T> for Tried<'_, Q> {
    type Output = Verdict;

    const LARGE: bool = Q::LARGE;

    const KNOWS_CONFIGURATION: bool = Q::KNOWS_CONFIGURATION;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Verdict {
        let Self(asked) = self;
        asked.question.judge(asked.problem(&system, Q::STREAM)).unwrap_or_else(unmeasured::<T>)
    }
}

/// The verdict of a [`Trial`] on a case.
pub fn tried<T: Real, S: Source>(source: &S, fault: Option<&Fault>, question: impl Trial<T>) -> Verdict {
    let asked = Asked { case: source, fault, question };
    source.visit::<T, _>(&Plant(fault), Tried(asked)).unwrap_or_else(|e| unbuilt(&e))
}

/// The verdict on the system of a case in the main dimensions, in one scalar.
pub fn on_main<T: Real>(
    case: &Case,
    fault: Option<&Fault>,
    judge: impl FnOnce(&Main<T>) -> Result<Verdict, Measured>,
) -> Verdict {
    match case.main::<T>(&Plant(fault)) {
        Ok(system) => judge(&system).unwrap_or_else(unmeasured::<T>),
        Err(e) => unbuilt(&e),
    }
}

/// The verdict where there is no measurement in T.
fn unmeasured<T: Real>(why: Measured) -> Verdict {
    alone(if T::unit_roundoff() > T::exact(1e-20) { 16 } else { 32 }, why)
}

/// What an error means for a law near the units: a group element off the domain says nothing, a Legendre transform that
/// cannot be inverted is a failure.
impl From<VelocityError> for Measured {
    fn from(error: VelocityError) -> Self {
        match error {
            VelocityError::Legendre(error) => Self::Broken(error.to_string()),
            VelocityError::Domain(RetractionError::NoGroup { .. }) => no_group(),
            VelocityError::Domain(_) => {
                Self::NotApplicable("a group element is outside the domain of the retraction".into())
            }
        }
    }
}

impl From<LegendreError> for Measured {
    fn from(error: LegendreError) -> Self {
        VelocityError::from(error).into()
    }
}

impl From<RetractionError> for Measured {
    fn from(error: RetractionError) -> Self {
        VelocityError::from(error).into()
    }
}

/// What a refused step means for a law.
impl From<StepError> for Measured {
    fn from(error: StepError) -> Self {
        match error {
            StepError::Domain { .. } => Self::NotApplicable("the step leaves the domain of the retraction".into()),
            StepError::Fold { .. } => Self::Inconclusive("the step is beyond a fold".into()),
            StepError::TooLong { .. } => Self::Inconclusive("the step is longer than it is followed".into()),
            StepError::Rounding { .. } => {
                Self::Inconclusive("rounding of the stage equations is larger than what is accepted".into())
            }
            StepError::NotConverged { .. } => Self::Inconclusive("the stage equations did not converge".into()),
            StepError::Legendre { .. } => Self::Inconclusive("the Legendre transform could not be inverted".into()),
            StepError::Unsupported { why } => Self::NotApplicable(format!("unsupported: {why}")),
            StepError::Refused { why, .. } => Self::Inconclusive(format!("the method refused a step: {why}")),
            StepError::IllConditioned { .. } => Self::Inconclusive("rounding decides the step".into()),
            StepError::Undefined { .. } => Self::Inconclusive("the force has no value at a stage".into()),
            StepError::SingularJacobian { .. } => Self::Inconclusive("the step is close to a fold".into()),
            StepError::NotFinite { .. }
            | StepError::Stages { .. }
            | StepError::Parameters { .. }
            | StepError::OffGroup { .. }
            | StepError::NoAnswer { .. } => Self::Broken(error.to_string()),
        }
    }
}

/// U = τ(x) with x made smaller until `change`, which is about proportional to x, is 1 at most.
///
/// # Errors
/// Those of `change` and of τ.
pub fn near_enough<T: Real, const N: usize, const D: usize>(
    tau: &AnyRetraction<T, N, D>,
    (mut u, mut x): (Matrix<T, D>, Vector<T, N>),
    change: impl Fn(&Matrix<T, D>) -> Result<T, VelocityError>,
) -> Result<Matrix<T, D>, VelocityError> {
    loop {
        let change = change(&u)?;
        if change <= T::one() || x.amax() < T::unit_roundoff() {
            return Ok(u);
        }
        x *= T::half() / change;
        u = tau.tau(&x)?;
    }
}
