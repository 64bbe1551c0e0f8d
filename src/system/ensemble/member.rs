//! A member of an ensemble on its way.

use super::Origin;
use crate::algebra::Covector;
use crate::integrators::{Report, State};
use crate::scalar::Real;

/// The progress of a member.
#[derive(Clone, Debug)]
pub struct Member<T: Real, const N: usize, const D: usize> {
    pub state: State<T, N, D>,
    /// Where the steps of the present size began: the time is this and a multiple of the step, so that it does not
    /// gather round-off.
    anchor: T,
    step: T,
    count: u64,
    pub steps: u64,
    pub residual: T,
    pub iterations: u64,
    pub failure: Option<String>,
}

impl<T: Real, const N: usize, const D: usize> Member<T, N, D> {
    pub fn new(system: &State<T, N, D>, origin: &Origin<T>, size: usize) -> Self {
        let mut state = system.clone();
        state.time = origin.time.unwrap_or(state.time);
        state.momentum = Covector::from_fn(|_, a| origin.momentum.get(a).copied().unwrap_or_else(T::zero));
        if let Some(attitude) = &origin.attitude {
            for (k, value) in attitude.iter().enumerate() {
                state.attitude[(k / size, k % size)] = *value;
            }
        }
        let (anchor, zero) = (state.time, T::zero());
        Self { state, anchor, step: zero, count: 0, steps: 0, residual: zero, iterations: 0, failure: None }
    }

    /// From now on the steps have this size.
    pub fn start(&mut self, h: T) {
        if self.step != h {
            (self.anchor, self.step, self.count) = (self.state.time, h, 0);
        }
    }

    /// `steps` more steps have been taken.
    pub fn took(&mut self, steps: u64) {
        self.steps += steps;
        self.count += steps;
        self.state.time = self.anchor + T::int(self.count as i64) * self.step;
    }

    pub fn reported(&mut self, report: &Report<T>) {
        self.residual = self.residual.max(report.residual);
        self.iterations += report.iterations as u64;
    }

    /// The next step failed.
    pub fn fail(&mut self, why: impl std::fmt::Display) {
        self.failure = Some(format!("step {}, from t = {}: {why}", self.steps + 1, self.state.time));
    }
}
