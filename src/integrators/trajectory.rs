//! Trajectories: n steps of any one-step method, with an observer.

use super::{OneStep, Report, State, StepError};
use crate::scalar::Real;

/// What a trajectory cost in all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Totals<T> {
    /// Steps taken.
    pub steps: usize,
    /// Iterations of all steps.
    pub iterations: usize,
    /// The most iterations that one step took.
    pub most_iterations: usize,
    /// The largest relative residual of a step.
    pub residual: T,
}

impl<T: Real> Totals<T> {
    pub(crate) fn none() -> Self {
        Self { steps: 0, iterations: 0, most_iterations: 0, residual: T::zero() }
    }

    pub(crate) fn add(&mut self, report: &Report<T>) {
        self.steps += 1;
        self.iterations += report.iterations;
        self.most_iterations = self.most_iterations.max(report.iterations);
        self.residual = self.residual.max(report.residual);
    }
}

/// A step that failed, and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("step {index} (from t = {time}) failed: {source}")]
#[non_exhaustive]
pub struct TrajectoryError {
    /// How many steps had succeeded: the index, from 0, of the one that failed.
    pub index: usize,
    /// The time from which it started.
    pub time: f64,
    /// Why it failed.
    pub source: StepError,
}

/// Takes `steps` steps of size `h`; after each, `observe` sees the index of the step (from 1), the state and the report.
///
/// The k-th step ends at time t₀ + k h, computed afresh, so that the time does not gather round-off. On an error
/// `state` is the last one that was reached.
///
/// # Errors
/// The first failing step, with its index and time.
pub fn integrate<T: Real, const N: usize, const D: usize>(
    method: &mut impl OneStep<T, N, D>,
    state: &mut State<T, N, D>,
    h: T,
    steps: usize,
    mut observe: impl FnMut(usize, &State<T, N, D>, &Report<T>),
) -> Result<Totals<T>, TrajectoryError> {
    let start = state.time;
    let mut totals = Totals::none();
    for index in 0..steps {
        let report =
            method.step(state, h).map_err(|source| TrajectoryError { index, time: state.time.to_f64(), source })?;
        state.time = start + T::int(index as i64 + 1) * h;
        totals.add(&report);
        observe(index + 1, state, &report);
    }
    Ok(totals)
}
