//! Newton's inversion of l', for any Lagrangian.

use super::{Lagrangian, LegendreError};
use crate::algebra::{Covector, Matrix, Vector, elimination};
use crate::scalar::{Real, Scalar, finite};

/// Newton steps on the value; the damped iteration converges in far fewer wherever l is convex.
pub(super) const MAX_ITERATIONS: usize = 60;
/// Halvings of one Newton step before the iteration gives up.
const MAX_HALVINGS: usize = 40;

/// max_i |v_i|.
pub(super) fn largest<'a, T: Real>(entries: impl IntoIterator<Item = &'a T>) -> T {
    entries.into_iter().fold(T::zero(), |size, v| size.max(v.abs()))
}

/// (l')⁻¹(μ) of a Lagrangian that does not depend on the configuration.
pub(super) fn invert<T: Real, S: Scalar<Base = T>, const N: usize>(
    lagrangian: &(impl Lagrangian<T, N> + ?Sized),
    mu: &Covector<S, N>,
    guess: &Vector<S, N>,
) -> Result<Vector<S, N>, LegendreError> {
    newton_velocity(
        (&|eta| lagrangian.gradient(eta), &|eta| lagrangian.hessian(eta)),
        (&|eta| lagrangian.gradient(eta), &|eta| lagrangian.hessian(eta)),
        mu,
        guess,
    )
}

/// l' and l'', in one scalar.
type Derivatives<'a, S, const N: usize> =
    (&'a dyn Fn(&Vector<S, N>) -> Covector<S, N>, &'a dyn Fn(&Vector<S, N>) -> Matrix<S, N>);

/// (l')⁻¹(μ) by damped Newton iteration from `guess`: η ← η − l''(η)⁻¹ (l'(η) − μ).
///
/// It converges on the values, stops at their round-off, and then repeats the undamped step in S: each such step
/// doubles the order to which derivative parts are right.
pub(super) fn newton_velocity<T: Real, S: Scalar<Base = T>, const N: usize>(
    values: Derivatives<'_, T, N>,
    (gradient, hessian): Derivatives<'_, S, N>,
    mu: &Covector<S, N>,
    guess: &Vector<S, N>,
) -> Result<Vector<S, N>, LegendreError> {
    let (target, start) = (mu.map(|v| v.base()), guess.map(|v| v.base()));
    let value = newton_value(values, &target, start).or_else(|failed| {
        // l may have no second derivatives at rest, or singular ones, as |η|³ and the square of |η| as a root: then from a velocity along μ.
        let at_rest = start.amax() == T::zero();
        let along = if at_rest { newton_value(values, &target, target.transpose()) } else { Err(failed.clone()) };
        along.map_err(|_| failed)
    })?;
    let mut eta = value.map(S::lift);
    // The error lies in an ideal that a step squares, and whose power after `order` vanishes.
    let order = S::NESTING;
    let mut right = 0;
    while right < order {
        let residual = (gradient(&eta) - mu).transpose();
        let hessian = hessian(&eta);
        eta -= elimination::inverse(&hessian).ok_or_else(|| LegendreError::singular(&eta, &hessian))? * residual;
        right = 2 * right + 1;
    }
    Ok(eta)
}

impl LegendreError {
    /// l'' is singular at η.
    #[cold]
    pub(crate) fn singular<S: Scalar, const N: usize>(eta: &Vector<S, N>, hessian: &Matrix<S, N>) -> Self {
        let velocity = eta.as_slice().iter().map(|v| v.to_f64()).collect();
        Self::Singular { velocity, rank: elimination::numerical_rank(&hessian.map(|v| v.base())) }
    }

    /// The same of the first n coordinates, where the others are those of spectators.
    pub(super) fn of_leading(mut self, n: usize) -> Self {
        if let Self::Singular { velocity, rank } = &mut self {
            *rank = rank.and_then(|rank| rank.checked_sub(velocity.len().checked_sub(n)?));
            velocity.truncate(n);
        }
        self
    }
}

/// η, where l'' is regular there to working precision: elsewhere l'(η) = μ does not determine η, even if η is a root.
fn regular<T: Real, const N: usize>(eta: Vector<T, N>, hessian: &Matrix<T, N>) -> Result<Vector<T, N>, LegendreError> {
    match elimination::regular_inverse(hessian) {
        Ok(_) => Ok(eta),
        Err(_) => Err(LegendreError::singular(&eta, hessian)),
    }
}

fn newton_value<T: Real, const N: usize>(
    (gradient, hessian): Derivatives<'_, T, N>,
    mu: &Covector<T, N>,
    mut eta: Vector<T, N>,
) -> Result<Vector<T, N>, LegendreError> {
    let unit = T::unit_roundoff();
    let close = unit.sqrt();
    let mut residual = (gradient(&eta) - mu).transpose();
    let mut size = residual_size(&residual);
    for iteration in 0..MAX_ITERATIONS {
        let failed = || LegendreError::NotConverged { residual: size.to_f64(), iterations: iteration };
        if !size.all_finite() {
            return Err(failed());
        }
        let hessian = hessian(&eta);
        if size == T::zero() {
            return regular(eta, &hessian);
        }
        let step = elimination::inverse(&hessian).ok_or_else(|| LegendreError::singular(&eta, &hessian))? * residual;
        // Quadratic convergence: once a step is below √u |η|, what it leaves is at the level of round-off.
        let last = largest(&step) <= close * largest(&eta);
        let round_off =
            T::int(4 * N as i64) * unit * (largest(mu) + T::int(N as i64) * largest(&hessian) * largest(&eta));
        let (next, next_residual) = match damped(gradient, mu, &eta, &step, size) {
            Some(accepted) => accepted,
            None if size <= round_off => return regular(eta, &hessian),
            None => return Err(failed()),
        };
        (eta, residual) = (next, next_residual);
        size = residual_size(&residual);
        if last {
            return regular(eta, &hessian);
        }
    }
    Err(LegendreError::NotConverged { residual: size.to_f64(), iterations: MAX_ITERATIONS })
}

/// max |r_a|, or NaN if any component is not finite.
fn residual_size<T: Real, const N: usize>(residual: &Vector<T, N>) -> T {
    if finite(residual.as_slice()) { largest(residual) } else { T::exact(f64::NAN) }
}

/// The longest of the steps 1, ½, ¼, … that lowers the residual, with the residual there.
fn damped<T: Real, const N: usize>(
    gradient: &dyn Fn(&Vector<T, N>) -> Covector<T, N>,
    mu: &Covector<T, N>,
    eta: &Vector<T, N>,
    step: &Vector<T, N>,
    size: T,
) -> Option<(Vector<T, N>, Vector<T, N>)> {
    let mut fraction = T::one();
    for _ in 0..MAX_HALVINGS {
        let next = eta - step * fraction;
        let residual = (gradient(&next) - mu).transpose();
        if residual_size(&residual) < size {
            return Some((next, residual));
        }
        fraction *= T::half();
    }
    None
}
