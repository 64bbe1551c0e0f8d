//! What a run tells who follows it.

use super::statistics::Statistics;
use crate::integrators::State;
use crate::scalar::Real;
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
