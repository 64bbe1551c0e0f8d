//! Where a motion goes: states at given times, accurate to round-off.
//!
//! By a classical Gauss collocation method on the vector field of (μ, g), of order 2s with s stages. It knows neither
//! retractions nor the variational equations.

use crate::group::LieGroup;
use crate::integrators::{Classical, OneStep, State, StepError};
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::{Force, Lagrangian};
use crate::scalar::{Real, max_abs};
use crate::tableau::{Family, Tableau};

/// A state, and how much its momentum and its attitude may be off.
#[derive(Clone, Debug, PartialEq)]
pub struct Target<T: Real, const N: usize, const D: usize> {
    /// The state.
    pub state: State<T, N, D>,
    /// Bounds on the errors of μ and g, largest components; rounding not included.
    pub reference_error: (T, T),
}

pub(crate) fn gauss<T: Real>(stages: usize) -> Result<Tableau<T>, StepError> {
    Family::Gauss.tableau(stages).map_err(|_| StepError::NotFinite { what: "the reference tableau" })
}

/// The state after a time, by `steps` equal steps.
fn run<T: Real, const N: usize, const D: usize>(
    method: &mut impl OneStep<T, N, D>,
    start: &State<T, N, D>,
    duration: T,
    steps: usize,
) -> Result<State<T, N, D>, StepError> {
    let mut state = start.clone();
    let h = duration / T::int(steps as i64);
    for _ in 0..steps {
        method.step(&mut state, h)?;
    }
    Ok(state)
}

fn difference<T: Real, const N: usize, const D: usize>(a: &State<T, N, D>, b: &State<T, N, D>) -> (T, T) {
    (max_abs(&(a.momentum - b.momentum)), max_abs(&(a.attitude - b.attitude)))
}

/// The states after each of these times, in the same sequence, with `stages` stages (at least 4: the error of the reference
/// relies on it); the attitude is left alone without a group.
///
/// The times are passed in increasing order (of size), one step from each to the next, so that times in a ratio of two cost
/// one step each. The error of the reference is the difference to two steps in place of the last, and falls at least as the
/// power s of the time before it, half the order.
///
/// # Errors
/// Those of a step: the Picard iteration does not converge where the last step is large.
pub fn at<T: Real, const N: usize, const D: usize>(
    system: &EulerPoincare<T, N, impl Lagrangian<T, N> + Clone, impl Force<T, N> + Clone>,
    group: Option<&(impl LieGroup<T, N, D> + Clone)>,
    start: &State<T, N, D>,
    times: &[T],
    stages: usize,
) -> Result<Vec<Target<T, N, D>>, StepError> {
    within(system, group, start, times, stages, T::zero())
}

/// The same, with the stages of each step found to a relative `tolerance` (0: to round-off), which costs less.
///
/// # Errors
/// Those of [`at`].
pub fn within<T: Real, const N: usize, const D: usize>(
    system: &EulerPoincare<T, N, impl Lagrangian<T, N> + Clone, impl Force<T, N> + Clone>,
    group: Option<&(impl LieGroup<T, N, D> + Clone)>,
    start: &State<T, N, D>,
    times: &[T],
    stages: usize,
    tolerance: T,
) -> Result<Vec<Target<T, N, D>>, StepError> {
    let mut method = Classical::new(system.clone(), group.cloned(), gauss(stages.max(4))?).to(tolerance);
    // The shortest first.
    let mut sequence: Vec<usize> = (0..times.len()).collect();
    sequence.sort_by(|a, b| times[*a].abs().to_f64().total_cmp(&times[*b].abs().to_f64()));
    let none = (T::zero(), T::zero());
    let mut targets = vec![Target { state: start.clone(), reference_error: none }; times.len()];
    let power = stages.max(4) as i32;
    let (mut state, mut passed, mut reference_error) = (start.clone(), T::zero(), none);
    for (rank, &k) in sequence.iter().enumerate() {
        let duration = times[k] - passed;
        let next = if duration == T::zero() { state.clone() } else { run(&mut method, &state, duration, 1)? };
        if rank + 1 == sequence.len() && duration != T::zero() {
            reference_error = difference(&next, &run(&mut method, &state, duration, 2)?);
        }
        (state, passed) = (next, times[k]);
        targets[k].state = state.clone();
    }
    for (target, time) in targets.iter_mut().zip(times) {
        let share = (*time / passed).abs().powi(power);
        target.reference_error = (reference_error.0 * share, reference_error.1 * share);
    }
    Ok(targets)
}

/// The state after a time, the same for all levels of a study over a horizon: by `steps` and by 2 `steps` steps with `stages`
/// stages.
///
/// # Errors
/// Those of a step.
pub fn after<T: Real, const N: usize, const D: usize>(
    system: &EulerPoincare<T, N, impl Lagrangian<T, N> + Clone, impl Force<T, N> + Clone>,
    group: Option<&(impl LieGroup<T, N, D> + Clone)>,
    start: &State<T, N, D>,
    horizon: T,
    steps: usize,
    stages: usize,
) -> Result<Target<T, N, D>, StepError> {
    let mut method = Classical::new(system.clone(), group.cloned(), gauss(stages)?);
    let rough = run(&mut method, start, horizon, steps.max(1))?;
    let state = run(&mut method, start, horizon, 2 * steps.max(1))?;
    let reference_error = difference(&rough, &state);
    Ok(Target { state, reference_error })
}
