//! Picard iteration of the stages of a Runge–Kutta method: for the comparators, which need no Newton method.

use super::{Solver, StepError};
use crate::scalar::Real;

/// The most fixed-point iterations of a step: at a contraction of ½ they reach 10⁻³⁰.
const MAX_ITERATIONS: usize = 200;

/// How the stages were found: the solver, the fixed-point iterations, the last relative change of a slope.
pub(super) type Solved<T> = (Solver, usize, T);

/// This number of iterations in a row that come no nearer than the best before are rounding.
const STALLED: usize = 2;

/// How much is rounding where no iteration comes nearer, in units of round-off.
const NOISE: f64 = 4096.0;

/// The largest changes of a pass.
pub(super) struct Change<T> {
    /// Of slopes, relative to the largest of them.
    pub relative: T,
    /// Of slopes of the momentum.
    pub momentum: T,
}

/// Repeats `pass`, which evaluates every stage with the slopes at hand, until no more than `tolerance` changes (0: than rounding); one
/// pass where the tableau is explicit. `sensitivity` says how much slopes of the momentum change where the entries of g do: near an equilibrium
/// they are no more than what rounding makes of that.
///
/// # Errors
/// Those of `pass`; no convergence in [`MAX_ITERATIONS`] fixed-point iterations.
pub(super) fn iterate<T: Real, M>(
    method: &mut M,
    explicit: bool,
    h: T,
    tolerance: T,
    pass: impl Fn(&mut M) -> Result<Change<T>, StepError>,
    sensitivity: impl Fn(&M) -> T,
) -> Result<Solved<T>, StepError> {
    if explicit {
        return pass(method).map(|_| (Solver::Explicit, 0, T::zero()));
    }
    let tolerance = tolerance.max(T::int(4) * T::unit_roundoff());
    let (mut residual, mut best, mut stalled) = (T::zero(), T::one(), 0);
    let noise = T::exact(NOISE) * T::unit_roundoff();
    let mut rounding = None;
    for iterations in 1..=MAX_ITERATIONS {
        let change = pass(method)?;
        residual = change.relative;
        // Rounding: no more progress, and far below anything that converges slowly. Once is not enough: a contraction that turns need not
        // come nearer in every iteration.
        stalled = if residual >= best { stalled + 1 } else { 0 };
        let idle = stalled >= STALLED
            && (residual < noise || change.momentum < *rounding.get_or_insert_with(|| sensitivity(method) * noise));
        best = best.min(residual);
        // Rounding can keep the fixed-point iterations moving by a few units for ever.
        let moving = iterations == MAX_ITERATIONS && residual < T::exact(64.0) * T::unit_roundoff();
        if residual <= tolerance || (iterations > 2 && idle) || moving {
            return Ok((Solver::FixedPoint, iterations, residual));
        }
    }
    Err(StepError::NotConverged {
        step: h.to_f64(),
        residual: residual.to_f64(),
        tolerance: tolerance.to_f64(),
        iterations: MAX_ITERATIONS,
    })
}
