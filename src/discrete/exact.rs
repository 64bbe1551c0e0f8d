//! The exact discrete Lagrangian, the action along a solution of the continuous equations.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/discrete/exact.md"))]

use crate::algebra::{LieAlgebra, Matrix, Vector};
use crate::mechanics::doubled::{DoubledLagrangian, VelocityError, VelocityPoint};
use crate::mechanics::euler_lagrange::rates;
use crate::retraction::{Retraction, TangentPoint};
use crate::scalar::Real;
use crate::tableau::{Family, Tableau, TableauError};

/// The most fixed-point iterations on the collocation equations.
const MAX_ITERATIONS: usize = 200;

/// Why a solution could not be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExactError {
    /// The equations could not be evaluated.
    #[error("the Euler–Lagrange equations at t = {time:e}: {source}")]
    Equations {
        /// The time of the point.
        time: f64,
        /// What failed.
        source: VelocityError,
    },
    /// The collocation equations did not contract to round-off.
    #[error(
        "the collocation equations over {step:e} did not converge: change {change:e} after {iterations} fixed-point iterations"
    )]
    NotConverged {
        /// The step.
        step: f64,
        /// The last change, relative to the solution.
        change: f64,
        /// Fixed-point iterations done.
        iterations: usize,
    },
    /// There are no collocation nodes for this number of stages.
    #[error(transparent)]
    Tableau(#[from] TableauError),
}

/// The error of an evaluation at a time.
pub(crate) fn at_time<T: Real, E: Into<VelocityError>>(time: T) -> impl Fn(E) -> ExactError {
    move |source| ExactError::Equations { time: time.to_f64(), source: source.into() }
}

/// A point of a solution, with what has been gathered since it started.
#[derive(Clone, Debug, PartialEq)]
pub struct Reached<T: Real, const N: usize, const D: usize> {
    /// (t; η, U, ψ) with U = g⁻¹g̃ = V⁻¹U₀W.
    pub point: VelocityPoint<T, N, D>,
    /// X = τ⁻¹(V).
    pub x: Vector<T, N>,
    /// Y = τ⁻¹(W).
    pub y: Vector<T, N>,
    /// V = g(t₀)⁻¹ g(t).
    pub v: Matrix<T, D>,
    /// W = g̃(t₀)⁻¹ g̃(t).
    pub w: Matrix<T, D>,
    /// ∫ **l** dt since t₀.
    pub action: T,
}

/// Where a solution starts.
pub type Start<T, const N: usize, const D: usize> = VelocityPoint<T, N, D>;

/// Follows solutions of a doubled Lagrangian by Gauss collocation of order 2s, iterated to round-off.
#[derive(Clone, Debug)]
pub struct ExactSolution<T: Real, const N: usize, const D: usize, L, R> {
    doubled: L,
    retraction: R,
    gauss: Tableau<T>,
    algebra: LieAlgebra<T, N>,
}

impl<T, const N: usize, const D: usize, L, R> ExactSolution<T, N, D, L, R>
where
    T: Real,
    L: DoubledLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    /// Solutions of `doubled`, by collocation with `stages` nodes a step; τ is the chart for V and W.
    ///
    /// # Errors
    /// No Gauss tableau with that many stages.
    pub fn new(doubled: L, retraction: R, stages: usize) -> Result<Self, ExactError> {
        let algebra = retraction.algebra().clone();
        Ok(Self { doubled, retraction, gauss: Family::Gauss.tableau(stages)?, algebra })
    }

    /// The points of the solution at the times t₀ + h for each of `times`, one step between neighbours.
    ///
    /// # Errors
    /// The equations cannot be evaluated on the way, V or W leaves the domain of the chart, or a step is too long for
    /// the iteration to contract.
    pub fn at(&self, start: &Start<T, N, D>, times: &[T]) -> Result<Vec<Reached<T, N, D>>, ExactError> {
        let velocities = start.eta.iter().chain(&start.psi).copied();
        let mut state: Vec<T> = velocities.chain(std::iter::repeat_n(T::zero(), 2 * N + 1)).collect();
        let mut passed = T::zero();
        let mut reached = Vec::with_capacity(times.len());
        let mut last = None;
        for &time in times {
            let rate = &mut |t: T, state: &[T]| self.rate(start, t, state);
            let h = time - passed;
            let slopes = collocate(&self.gauss, start.time + passed, h, &mut state, last.as_ref(), rate)?;
            last = Some((h, slopes));
            passed = time;
            reached.push(self.point(start, start.time + time, &state)?.0);
        }
        Ok(reached)
    }

    /// The point with the coordinates (η, ψ, X, Y, action), and dτ⁻¹ at X and Y.
    fn point(
        &self,
        start: &Start<T, N, D>,
        t: T,
        state: &[T],
    ) -> Result<(Reached<T, N, D>, [Matrix<T, N>; 2]), ExactError> {
        let part = |k: usize| Vector::<T, N>::from_column_slice(&state[k * N..(k + 1) * N]);
        let (eta, psi, x, y) = (part(0), part(1), part(2), part(3));
        let tau = |x: &Vector<T, N>| self.retraction.tau(x).map_err(at_time(t));
        let tangent = |x: &Vector<T, N>| self.retraction.at(x).map(|point| *point.d_inv()).map_err(at_time(t));
        let u = tau(&-x)? * start.u * tau(&y)?;
        let point = VelocityPoint { time: t, eta, u, psi };
        let reached = Reached { point, x, y, v: tau(&x)?, w: tau(&y)?, action: state[4 * N] };
        Ok((reached, [tangent(&x)?, tangent(&y)?]))
    }

    fn rate(&self, start: &Start<T, N, D>, t: T, state: &[T]) -> Result<Vec<T>, ExactError> {
        let (at, [d_inv_x, d_inv_y]) = self.point(start, t, state)?;
        let rate = rates(&self.doubled, &self.algebra, &at.point).map_err(at_time(t))?;
        let action = self.doubled.value(&at.point).map_err(at_time(t))?;
        let parts = [rate.eta, rate.psi, d_inv_x * at.point.eta, d_inv_y * at.point.psi];
        Ok(parts.iter().flatten().copied().chain([action]).collect())
    }
}

/// f in y' = f(t, y).
pub(crate) type Rate<'a, T> = dyn FnMut(T, &[T]) -> Result<Vec<T>, ExactError> + 'a;

/// A step and its slopes, stage by stage.
pub(crate) type Slopes<T> = (T, Vec<Vec<T>>);

/// A step is predicted from the last one up to this ratio of their sizes: the polynomial of degree s − 1 is then worth more than the
/// slope at the start.
const FARTHEST: f64 = 4.0;

/// The slopes of a step of size h, from the polynomial through those of the last one.
fn predicted<T: Real>(gauss: &Tableau<T>, h: T, (last, slopes): &Slopes<T>) -> Vec<Vec<T>> {
    let (s, c) = (gauss.stages(), gauss.c());
    let at = |i: usize| {
        let x = T::one() + c[i] * (h / *last);
        let weight =
            |j: usize| (0..s).filter(|k| *k != j).fold(T::one(), |product, k| product * (x - c[k]) / (c[j] - c[k]));
        let weights: Vec<T> = (0..s).map(weight).collect();
        (0..slopes[0].len()).map(|m| (0..s).fold(T::zero(), |sum, j| sum + weights[j] * slopes[j][m])).collect()
    };
    (0..s).map(at).collect()
}

/// One step of y' = f(t, y) by collocation, the stages iterated until the change is rounding; its slopes.
pub(crate) fn collocate<T: Real>(
    gauss: &Tableau<T>,
    start: T,
    h: T,
    y: &mut [T],
    last: Option<&Slopes<T>>,
    rate: &mut Rate<'_, T>,
) -> Result<Vec<Vec<T>>, ExactError> {
    let (s, a, b, c) = (gauss.stages(), gauss.a(), gauss.b(), gauss.c());
    let mut slopes = match last.filter(|(last, _)| (h / *last).abs() <= T::exact(FARTHEST)) {
        Some(last) => predicted(gauss, h, last),
        None => vec![rate(start, y)?; s],
    };
    let size = y.iter().fold(T::one(), |size, v| size.max(v.abs()));
    let mut stage = y.to_vec();
    let (mut change, mut best, mut iterations) = (T::zero(), None::<T>, 0);
    while iterations < MAX_ITERATIONS {
        iterations += 1;
        change = T::zero();
        // Each slope is used by the stages after it in the same iteration.
        for i in 0..s {
            for (m, value) in stage.iter_mut().enumerate() {
                *value = y[m] + h * (0..s).fold(T::zero(), |t, j| t + a[(i, j)] * slopes[j][m]);
            }
            let slope = rate(start + c[i] * h, &stage)?;
            // A maximum does not see a NaN.
            if !slope.iter().all(|v| v.all_finite()) {
                return Err(ExactError::NotConverged { step: h.to_f64(), change: f64::NAN, iterations });
            }
            for (new, old) in slope.iter().zip(&slopes[i]) {
                change = change.max(((*new - *old) * h).abs());
            }
            slopes[i] = slope;
        }
        let rounding = change <= size * T::unit_roundoff() * T::int(4);
        // Near round-off the change stops shrinking; above it, it has to shrink.
        let stagnant = best.is_some_and(|best| change >= best) && change <= size * T::unit_roundoff() * T::int(1 << 12);
        if rounding || stagnant {
            for (m, value) in y.iter_mut().enumerate() {
                *value += h * (0..s).fold(T::zero(), |t, j| t + b[j] * slopes[j][m]);
            }
            return Ok(slopes);
        }
        if !change.all_finite() {
            break;
        }
        best = Some(best.map_or(change, |best| best.min(change)));
    }
    let change = (change / size).to_f64();
    Err(ExactError::NotConverged { step: h.to_f64(), change, iterations })
}
