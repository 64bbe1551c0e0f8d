//! What a run with a tolerance answers, and what it tells on the way.

use super::control::Statistics;
use super::dense::Piece;
use super::error::{DenseError, SolveError};
use crate::integrators::State;
use crate::retraction::Retraction;
use crate::scalar::Real;
use std::error::Error;
use std::fmt;
use std::ops::ControlFlow;

/// What has happened.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// A state that was asked for: at a time to save, or after every k-th step.
    Saved,
    /// An event: which, from 0 in the order in which they were added, and whether the function rises in the direction of the run.
    Event {
        /// Which.
        index: usize,
        /// Whether it rises.
        rising: bool,
    },
    /// A step was taken. The states to save and the events in it come before.
    Step,
}

/// How far a run is.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Progress<'s, T: Real, const N: usize, const D: usize> {
    /// What has happened.
    pub moment: Moment,
    /// The state there.
    pub state: &'s State<T, N, D>,
    /// The work of the force since the start, ∫⟨f, η⟩ dt, by the quadrature of the tableau.
    pub work: T,
    /// −∫∂L/∂t dt since the start, by the same quadrature: with the work it is what the energy ⟨∂L/∂η, η⟩ − L has taken up.
    pub explicit: T,
    /// The largest relative residual of the stage equations of the pair of steps.
    pub residual: T,
    /// What the run took, all of the pair of steps included.
    pub statistics: &'s Statistics<T>,
}

/// Called at each of these moments.
pub(super) type Follower<'a, T, const N: usize, const D: usize> =
    dyn FnMut(&Progress<'_, T, N, D>) -> ControlFlow<()> + 'a;

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum End {
    /// The end of the interval is reached.
    Time,
    /// A terminal event: its number, from 0 in the order in which the events were added.
    Event(usize),
    /// The observer or the follower broke off.
    Stopped,
    /// An error, see [`SolveFailure`](super::SolveFailure).
    Failed,
}

/// An event, and the state at it.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Located<T: Real, const N: usize, const D: usize> {
    /// Which event, from 0 in the order in which they were added.
    pub event: usize,
    /// Whether the function rises there, in the direction of the run.
    pub rising: bool,
    /// The state there, no earlier than the root: a run that goes on from it does not find the same event again.
    pub state: State<T, N, D>,
}

/// What a run with a tolerance answers: see [`Solve`](super::Solve).
#[derive(Debug)]
#[non_exhaustive]
pub struct Solution<T: Real, const N: usize, const D: usize, R> {
    /// The last state.
    pub state: State<T, N, D>,
    /// Why the run ended.
    pub end: End,
    /// What it took.
    pub statistics: Statistics<T>,
    /// The states at the times to save and after every k-th step, in the order of the run.
    pub saved: Vec<State<T, N, D>>,
    /// The events, in the order of the run.
    pub events: Vec<Located<T, N, D>>,
    /// The size of the steps that would have come next, with sign: give it to [`Solve::first_step`](super::Solve::first_step) to go
    /// on. 0 after a run of no length.
    pub next_step: T,
    /// Where the run began.
    pub start: T,
    pub(super) dense: Option<Dense<T, N, D, R>>,
}

/// The states between the steps.
#[derive(Debug)]
pub(super) struct Dense<T: Real, const N: usize, const D: usize, R> {
    pub retraction: R,
    pub pieces: Vec<Piece<T, N, D>>,
}

impl<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>> Solution<T, N, D, R> {
    /// The state at any time of the run, to its tolerance.
    ///
    /// g(t) is in the group to round-off. Without a force the Casimirs of μ(t) are those of the start to round-off.
    ///
    /// # Errors
    /// [`DenseError`]: the run was without [`dense`](super::Solve::dense), or the time is outside the interval.
    pub fn at(&self, time: T) -> Result<State<T, N, D>, DenseError> {
        let dense = self.dense.as_ref().ok_or(DenseError::NotKept)?;
        let (start, end) = (self.start, self.state.time);
        let forward = end >= start;
        let inside = if forward { start <= time && time <= end } else { end <= time && time <= start };
        if !inside {
            return Err(DenseError::Outside { time: time.to_f64(), start: start.to_f64(), end: end.to_f64() });
        }
        if time == end {
            return Ok(self.state.clone());
        }
        let begun =
            dense.pieces.partition_point(|piece| if forward { piece.time() <= time } else { piece.time() >= time });
        let piece = dense.pieces.get(begun.saturating_sub(1)).ok_or(DenseError::NotKept)?;
        piece.at(&dense.retraction, time).map_err(|source| DenseError::Domain { time: time.to_f64(), source })
    }
}

/// A run that ended before its time: why, and what it had reached.
pub struct SolveFailure<T: Real, const N: usize, const D: usize, R> {
    /// Why the run ended.
    pub error: SolveError,
    /// The last state, the statistics and everything that was saved until then.
    pub reached: Box<Solution<T, N, D, R>>,
}

impl<T: Real, const N: usize, const D: usize, R> fmt::Debug for SolveFailure<T, N, D, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("SolveFailure").field("error", &self.error).field("state", &self.reached.state).finish()
    }
}

impl<T: Real, const N: usize, const D: usize, R> fmt::Display for SolveFailure<T, N, D, R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.error, f)
    }
}

impl<T: Real, const N: usize, const D: usize, R> Error for SolveFailure<T, N, D, R> {
    fn source(&self) -> Option<&(dyn Error + 'static)> {
        self.error.source()
    }
}
