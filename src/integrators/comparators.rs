//! What the variational schemes are compared with, beside [`super::Classical`]: an adaptive general-purpose solver.

use crate::algebra::{Covector, Vector};
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::{Force, Lagrangian, LegendreError};
use ivp::prelude::{FirstOrderSystem, Ivp, Method};
use std::cell::RefCell;

/// Steps after which the adaptive integrator gives up.
const MAX_STEPS: usize = 1_000_000;

/// Why the adaptive integration stopped early.
///
/// ```
/// use euler_poincare::integrators::comparators::{AdaptiveError, dormand_prince};
/// use euler_poincare::mechanics::models::relaxed_rigid_body;
///
/// let model = relaxed_rigid_body::<f64>();
/// let rows = dormand_prince(&model.system, &model.momentum, &[0.5, 1.0], 1e-8)?;
/// assert_eq!(rows.len(), 2);
/// let refused = dormand_prince(&model.system, &model.momentum, &[1.0, 0.5], 1e-8);
/// assert!(matches!(refused, Err(AdaptiveError::BadInput { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AdaptiveError {
    /// A NaN or an infinity, or times that are not strictly increasing, or a tolerance that is not positive.
    #[error("{what}")]
    BadInput {
        /// What is wrong.
        what: &'static str,
    },
    /// The inverse Legendre transform failed.
    #[error("the inverse Legendre transform failed at t = {time}: {source}")]
    Legendre {
        /// The time at which it failed first.
        time: f64,
        /// What the Lagrangian said.
        source: LegendreError,
    },
    /// The solver refused or stopped before the last time.
    #[error("Dormand-Prince 5(4) stopped at t = {time}: {why}")]
    Stopped {
        /// The last time reached.
        time: f64,
        /// The solver's reason.
        why: String,
    },
}

struct VectorField<'a, L, F, const N: usize> {
    system: &'a EulerPoincare<f64, N, L, F>,
    guess: RefCell<Vector<f64, N>>,
    failure: RefCell<Option<AdaptiveError>>,
}

impl<L: Lagrangian<f64, N>, F: Force<f64, N>, const N: usize> FirstOrderSystem for VectorField<'_, L, F, N> {
    fn derivative(&self, t: f64, y: &[f64], dydt: &mut [f64]) {
        let mu = Covector::<f64, N>::from_column_slice(y);
        let rates = self.system.rates(t, &mu, &self.guess.borrow());
        match rates {
            Ok(rates) if rates.momentum.iter().all(|v| v.is_finite()) => {
                *self.guess.borrow_mut() = rates.velocity;
                dydt.copy_from_slice(rates.momentum.as_slice());
            }
            refused => {
                // The solver has no way to stop here: it goes on with no motion, and the failure is reported.
                dydt.fill(0.0);
                self.failure.borrow_mut().get_or_insert(match refused {
                    Err(source) => AdaptiveError::Legendre { time: t, source },
                    Ok(_) => AdaptiveError::Stopped { time: t, why: "the vector field is not finite".into() },
                });
            }
        }
    }
}

/// Momenta (t, μ(t)) at `times` by Dormand and Prince's adaptive pair 5(4) on the forced Lie–Poisson equation.
///
/// `times[0]` is the initial time; `tolerance` is used as relative and as absolute tolerance per step. Values
/// between steps come from the pair's interpolant of order 4 (Dormand and Prince 1980; Hairer, Nørsett and Wanner
/// 1993, II.6).
///
/// # Errors
/// Bad input, a failing Legendre transform, a solver that stops early.
pub fn dormand_prince<L: Lagrangian<f64, N>, F: Force<f64, N>, const N: usize>(
    system: &EulerPoincare<f64, N, L, F>,
    initial: &Covector<f64, N>,
    times: &[f64],
    tolerance: f64,
) -> Result<Vec<(f64, Covector<f64, N>)>, AdaptiveError> {
    let bad = |what| Err(AdaptiveError::BadInput { what });
    let [start, .., end] = *times else {
        return bad("at least two times are needed");
    };
    if !times.iter().all(|t| t.is_finite()) || !times.windows(2).all(|w| w[0] < w[1]) {
        return bad("the times must be finite and strictly increasing");
    }
    if !initial.iter().all(|v| v.is_finite()) {
        return bad("the momentum is not finite");
    }
    if !(tolerance.is_finite() && tolerance > 0.0) {
        return bad("the tolerance must be positive and finite");
    }
    let field = VectorField { system, guess: RefCell::new(Vector::zeros()), failure: RefCell::new(None) };
    let solved = Ivp::first_order(&field, start, end, initial.as_slice())
        .method(Method::DOPRI5)
        .rtol(tolerance)
        .atol(tolerance)
        .max_steps(MAX_STEPS)
        .t_eval(times.to_vec())
        .solve();
    if let Some(failure) = field.failure.take() {
        return Err(failure);
    }
    let solution = solved.map_err(|e| AdaptiveError::Stopped { time: start, why: e.to_string() })?;
    let reached = solution.t.last().copied().unwrap_or(start);
    if !solution.status.is_success() || solution.t.len() != times.len() {
        return Err(AdaptiveError::Stopped { time: reached, why: format!("{:?}", solution.status) });
    }
    let sample = |(t, y): (&f64, &Vec<f64>)| (*t, Covector::from_column_slice(y));
    Ok(solution.t.iter().zip(&solution.y).map(sample).collect())
}
