//! Many trajectories of any one-step method, on all cores with the feature `rayon`.

use super::trajectory::{TrajectoryError, integrate};
use super::{OneStep, State, StepError};
use crate::scalar::Real;

/// Why an ensemble stopped. Other members may have gone further.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("body {member}, step {step} (from t = {time}): {source}")]
#[non_exhaustive]
pub struct EnsembleError {
    /// Which body, from 0.
    pub member: usize,
    /// Which step of this run, from 0.
    pub step: usize,
    /// When.
    pub time: f64,
    /// What happened.
    pub source: StepError,
}

/// Runs all members, on all cores with the feature `rayon`; the error is that of the first in their order.
pub(super) fn for_all<M: Send>(
    members: &mut [M],
    run: impl Fn((usize, &mut M)) -> Result<(), EnsembleError> + Send + Sync,
) -> Result<(), EnsembleError> {
    #[cfg(feature = "rayon")]
    let outcomes: Vec<Result<(), EnsembleError>> = {
        use rayon::prelude::*;
        members.par_iter_mut().enumerate().map(run).collect()
    };
    #[cfg(not(feature = "rayon"))]
    let outcomes: Vec<Result<(), EnsembleError>> = members.iter_mut().enumerate().map(run).collect();
    outcomes.into_iter().collect()
}

/// Members that are each moved by a method of their own: of any group, force and tableau, and with other parameters from one to the next.
///
/// A member starts from the stages of its last step, so a method belongs to one member. Results do not depend on the number of threads. On
/// SO(3), [`EnsembleSo3`](super::so3::EnsembleSo3) (feature `lanes`) moves eight members in the registers at once and is many times faster.
///
/// ```
/// use euler_poincare::algebra::{Covector, Entry, Matrix};
/// use euler_poincare::group::MatrixGroup;
/// use euler_poincare::integrators::ensemble::Ensemble;
/// use euler_poincare::integrators::{State, Variational};
/// use euler_poincare::mechanics::force::{ForceError, LinearDrag};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::Cayley;
/// use euler_poincare::tableau::Family;
///
/// // Bodies in a fluid, each with a drag of its own.
/// let body = Quadratic::<f64, 6>::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25])?;
/// let motions = Cayley::new(MatrixGroup::<f64, 6, 4>::from_entry(&Entry::Se3)?)?;
/// let start = State::at_identity(Covector::<f64, 6>::new(0.5, -0.25, 1.0, 1.0, 0.5, -0.5));
/// let tableau = Family::Gauss.tableau::<f64>(2)?;
/// let member = |k: i32| {
///     let drag = LinearDrag::new(Matrix::<f64, 6>::identity() * (f64::from(k) / 8.0))?;
///     Ok((Variational::new(body.clone(), drag, motions.clone(), tableau.clone()), start.clone()))
/// };
/// let mut ensemble = Ensemble::new((0..8).map(member).collect::<Result<Vec<_>, ForceError>>()?);
/// ensemble.advance(0.05, 20)?;
/// let speeds: Vec<f64> = ensemble.states().map(|state| state.momentum.norm()).collect();
/// assert!(speeds.windows(2).all(|pair| pair[1] < pair[0]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ensemble<T: Real, const N: usize, const D: usize, M> {
    members: Vec<(M, State<T, N, D>)>,
}

impl<T: Real, const N: usize, const D: usize, M> Ensemble<T, N, D, M> {
    /// Methods, and the states from which they start. Every member has a time of its own.
    pub fn new(members: impl IntoIterator<Item = (M, State<T, N, D>)>) -> Self {
        Self { members: members.into_iter().collect() }
    }

    /// The number of members.
    pub fn len(&self) -> usize {
        self.members.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.members.is_empty()
    }

    /// Where a member is.
    pub fn state(&self, member: usize) -> Option<&State<T, N, D>> {
        self.members.get(member).map(|(_, state)| state)
    }

    /// Where the members are, in their order.
    pub fn states(&self) -> impl Iterator<Item = &State<T, N, D>> {
        self.members.iter().map(|(_, state)| state)
    }

    /// Methods and states, in their order: to change a force or a state between runs.
    pub fn members_mut(&mut self) -> impl Iterator<Item = &mut (M, State<T, N, D>)> {
        self.members.iter_mut()
    }

    /// `steps` steps of size `h` for every member.
    ///
    /// # Errors
    /// The first member (in their order) that could not take a step; see [`StepError`]. Its state is the last that it reached.
    pub fn advance(&mut self, h: T, steps: usize) -> Result<(), EnsembleError>
    where
        M: OneStep<T, N, D> + Send,
    {
        let run = |(member, (method, state)): (usize, &mut (M, State<T, N, D>))| {
            let refused = |TrajectoryError { index: step, time, source }| EnsembleError { member, step, time, source };
            integrate(method, state, h, steps, |_, _, _| {}).map(drop).map_err(refused)
        };
        for_all(&mut self.members, run)
    }
}
