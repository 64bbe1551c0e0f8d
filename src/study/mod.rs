//! Convergence studies: what errors a one-step method makes at a sequence of step sizes, and what order they show.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/study.md"))]
//!
//! ```
//! use euler_poincare::algebra::{Covector, LieAlgebra, Matrix, catalogue::Entry};
//! use euler_poincare::group::So3;
//! use euler_poincare::integrators::{MuntheKaas, State};
//! use euler_poincare::mechanics::{equations::EulerPoincare, force::LinearDrag, lagrangian::Quadratic};
//! use euler_poincare::retraction::ExponentialSo3;
//! use euler_poincare::scalar::{Dd, Scalar};
//! use euler_poincare::study::{Comparison, StepLevel, Study, reference};
//! use euler_poincare::tableau::Classic;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let ratio = |p, q| Dd::ratio(p, q);
//! let drag = LinearDrag::new(Matrix::<Dd, 3>::from_diagonal_element(ratio(1, 10)))?;
//! let inertia = Quadratic::diagonal([ratio(1, 2), ratio(2, 1), ratio(1, 1)])?;
//! let body = EulerPoincare::new(LieAlgebra::from_catalogue(&Entry::So3)?, inertia, drag);
//! let momentum = Covector::<Dd, 3>::new(ratio(2, 5), ratio(1, 10), ratio(7, 10));
//! let start = State { time: ratio(0, 1), momentum, attitude: Matrix::<Dd, 3>::identity() };
//!
//! let levels = StepLevel::shrinking(ratio(1, 8), 2, 16);
//! let times: Vec<Dd> = levels.iter().map(StepLevel::duration).collect();
//! let targets = reference::at(&body, Some(&So3::new()), &start, &times, 6)?;
//! let study = Study::new(start).with_attitude();
//! let method = || MuntheKaas::new(body.clone(), ExponentialSo3::new(), Classic::Rk4.tableau().unwrap());
//! let findings = study.descend(method, &levels, &targets).local();
//! assert!(matches!(findings.compare(4), Comparison::As { .. }));
//! # Ok(())
//! # }
//! ```

mod findings;
pub mod guard;
pub mod least;
pub mod problem;
pub mod reference;

pub use findings::{Comparison, Findings, Line};
pub use reference::Target;

use crate::harness::convergence::CLEAR_OF_NOISE;
use crate::integrators::{OneStep, State, StepError};
use crate::scalar::{Real, max_abs};
use std::convert::Infallible;

/// One level of a study: `steps` steps of one size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepLevel<T> {
    /// The number of steps.
    pub steps: usize,
    /// Their size.
    pub h: T,
}

impl<T: Real> StepLevel<T> {
    /// Each of these numbers of steps over the same horizon.
    pub fn over(horizon: T, counts: impl IntoIterator<Item = usize>) -> Vec<Self> {
        counts.into_iter().map(|steps| Self { steps, h: horizon / T::int(steps as i64) }).collect()
    }

    /// `steps` steps of size h, h/2, h/4, …: `levels` levels.
    pub fn shrinking(h: T, steps: usize, levels: usize) -> Vec<Self> {
        let mut h = h;
        let mut next = || {
            let level = Self { steps, h };
            h *= T::half();
            level
        };
        (0..levels).map(|_| next()).collect()
    }

    /// The time that the level covers.
    pub fn duration(&self) -> T {
        self.h * T::int(self.steps as i64)
    }
}

/// The error of one quantity at one level.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Reading {
    /// The largest component of the difference.
    pub error: f64,
    /// How much of it may be rounding, or error of the target.
    pub noise: f64,
    /// How much of the noise is error of the target.
    pub reference_error: f64,
}

impl Reading {
    /// An error of which `rounding` and the error of the target are noise.
    pub fn new<T: Real>(error: T, rounding: T, reference_error: T) -> Self {
        Self {
            error: error.to_f64(),
            noise: (rounding + reference_error).to_f64(),
            reference_error: reference_error.to_f64(),
        }
    }

    /// Whether it is far enough above the noise to carry a slope, or not a number, from which none can be read.
    pub fn is_clear(&self) -> bool {
        self.error > CLEAR_OF_NOISE * self.noise || self.error.is_nan() || self.noise.is_nan()
    }
}

/// What a level gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The number of steps.
    pub steps: usize,
    /// Their size.
    pub h: f64,
    /// A reading of each quantity (NaN where a function has no value), or why the run stopped.
    pub readings: Result<Vec<Reading>, StepError>,
}

/// A function of the state; `None` where it has no value.
type Function<'a, T, const N: usize, const D: usize> = Box<dyn Fn(&State<T, N, D>) -> Option<T> + 'a>;

/// A start, and what is compared at the end of each run.
pub struct Study<'a, T: Real, const N: usize, const D: usize> {
    start: State<T, N, D>,
    attitude: bool,
    functions: Vec<(String, Function<'a, T, N, D>)>,
}

impl<'a, T: Real, const N: usize, const D: usize> Study<'a, T, N, D> {
    /// From a state; the momentum is compared.
    pub fn new(start: State<T, N, D>) -> Self {
        Self { start, attitude: false, functions: Vec::new() }
    }

    /// The attitude is compared too.
    pub fn with_attitude(mut self) -> Self {
        self.attitude = true;
        self
    }

    /// A function of the state is compared too, such as the energy. It is shown; orders are judged by the state alone, because
    /// a function of it may do better.
    pub fn with_function(mut self, name: &str, function: impl Fn(&State<T, N, D>) -> Option<T> + 'a) -> Self {
        self.functions.push((name.to_owned(), Box::new(function)));
        self
    }

    /// The errors of a run.
    pub fn measure(&self, method: &mut dyn OneStep<T, N, D>, level: &StepLevel<T>, target: &Target<T, N, D>) -> Row {
        let (steps, h) = (level.steps, level.h.to_f64());
        let mut state = self.start.clone();
        let run = (0..steps).try_for_each(|_| {
            method.step(&mut state, level.h)?;
            // A maximum does not see a NaN.
            state.check_finite(level.h)
        });
        Row { steps, h, readings: run.map(|()| self.compare(&state, target, steps)) }
    }

    /// Rounding: some 64 operations a step on the way of each number, relative to the size of the state.
    fn compare(&self, end: &State<T, N, D>, target: &Target<T, N, D>, steps: usize) -> Vec<Reading> {
        let unit = T::unit_roundoff() * T::int(64 * steps as i64);
        let reading = |error: T, size: T, reference_error: T| Reading::new(error, unit * size, reference_error);
        let exact = &target.state;
        let mut readings = vec![reading(
            max_abs(&(end.momentum - exact.momentum)),
            exact.momentum.amax().max(self.start.momentum.amax()),
            target.reference_error.0,
        )];
        if self.attitude {
            let size = exact.attitude.amax().max(self.start.attitude.amax());
            readings.push(reading(max_abs(&(end.attitude - exact.attitude)), size, target.reference_error.1));
        }
        // How much a function moves with the momentum is not known: the relative error of the reference momentum stands for it.
        let relative = target.reference_error.0 / exact.momentum.amax().max(T::unit_roundoff());
        for (_, function) in &self.functions {
            let (Some(mine), Some(theirs)) = (function(end), function(exact)) else {
                readings.push(Reading { error: f64::NAN, noise: f64::NAN, reference_error: f64::NAN });
                continue;
            };
            let size = theirs.abs().max(function(&self.start).map_or(T::zero(), |x| x.abs()));
            readings.push(reading((mine - theirs).abs(), size, size * relative));
        }
        readings
    }

    /// No levels yet, of what is compared: `momentum`, `attitude`, and the functions. The order is judged by the first two.
    pub fn findings(&self) -> Findings {
        let judged = 1 + usize::from(self.attitude);
        let state = ["momentum", "attitude"].into_iter().take(judged).map(str::to_owned);
        Findings::new(state.chain(self.functions.iter().map(|(name, _)| name.clone())).collect(), judged)
    }

    /// Level after level, each with a fresh method, until two in a row show nothing but noise or the levels end.
    ///
    /// `targets[k]` belongs to `levels[k]`.
    pub fn descend<M: OneStep<T, N, D>>(
        &self,
        mut method: impl FnMut() -> M,
        levels: &[StepLevel<T>],
        targets: &[Target<T, N, D>],
    ) -> Findings {
        let rows = levels.iter().zip(targets).map(|(level, target)| Ok(self.measure(&mut method(), level, target)));
        let Ok(findings) = self.findings().descend::<Infallible>(rows);
        findings
    }
}
