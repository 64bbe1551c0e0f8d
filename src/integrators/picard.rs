//! Picard iteration of the stages of a Runge–Kutta method: for the comparators, which need no Newton method.

use super::{Solver, StepError};
use crate::scalar::Real;

/// The most sweeps of a step: at a contraction of ½ they reach 10⁻³⁰.
const SWEEPS: usize = 200;

/// How the stages were found: the solver, the sweeps, the last relative change of a slope.
pub(super) type Solved<T> = (Solver, usize, T);

/// Repeats `pass`, which evaluates every stage with the slopes at hand and returns their largest relative change, until
/// no more than `tolerance` changes (0: than rounding); one pass where the tableau is explicit.
///
/// # Errors
/// Those of `pass`; no convergence in [`SWEEPS`] sweeps.
pub(super) fn sweep<T: Real>(
    explicit: bool,
    h: T,
    tolerance: T,
    mut pass: impl FnMut() -> Result<T, StepError>,
) -> Result<Solved<T>, StepError> {
    if explicit {
        return pass().map(|_| (Solver::Explicit, 0, T::zero()));
    }
    let tolerance = tolerance.max(T::int(4) * T::unit_roundoff());
    let (mut residual, mut best) = (T::zero(), T::one());
    for sweeps in 1..=SWEEPS {
        residual = pass()?;
        // Rounding: no more progress, and far below anything that converges slowly.
        let idle = residual >= best && residual < T::exact(2f64.powi(12)) * T::unit_roundoff();
        best = best.min(residual);
        // Rounding can keep the sweeps moving by a few units for ever.
        let moving = sweeps == SWEEPS && residual < T::exact(64.0) * T::unit_roundoff();
        if residual <= tolerance || (sweeps > 2 && idle) || moving {
            return Ok((Solver::Sweeps, sweeps, residual));
        }
    }
    Err(StepError::NotConverged {
        step: h.to_f64(),
        residual: residual.to_f64(),
        tolerance: tolerance.to_f64(),
        iterations: SWEEPS,
    })
}
