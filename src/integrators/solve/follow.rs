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
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::State;
/// use euler_poincare::integrators::solve::{Moment, Progress, Solve};
/// use euler_poincare::mechanics::{force::LinearDrag, lagrangian::Quadratic};
/// use euler_poincare::retraction::CayleySo3;
/// use std::ops::ControlFlow;
///
/// let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
/// let drag = LinearDrag::new(Matrix::<f64, 3>::identity())?;
/// let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.4, 0.0, 0.0), attitude: Matrix::<f64, 3>::identity() };
/// let mut work = Vec::new();
/// let solve = Solve::new(body, drag, CayleySo3::new()).tolerance(1e-10).save_at([0.5, 1.0]);
/// let mut solve = solve.follow(|progress: &Progress<'_, f64, 3, 3>| {
///     if progress.moment == Moment::Saved {
///         work.push(progress.work);
///         assert_eq!(progress.explicit, 0.0, "nothing depends on the time");
///     }
///     ControlFlow::Continue(())
/// });
/// solve.run(&start, 1.0)?;
/// drop(solve);
/// // η = 0.8 e^{−2t} about a principal axis: the energy (1/4) η² goes into the drag.
/// let lost = |t: f64| 0.16 * ((-4.0 * t).exp() - 1.0);
/// assert!((work[0] - lost(0.5)).abs() < 1e-10 && (work[1] - lost(1.0)).abs() < 1e-10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
