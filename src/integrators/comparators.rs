//! What the variational schemes are compared with, beside [`super::Classical`]: an adaptive general-purpose solver.

use crate::algebra::{Covector, Vector};
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::{Force, Lagrangian, LegendreError};

/// Steps after which the adaptive integrator gives up.
const MAX_STEPS: usize = 1_000_000;

/// Why the adaptive integration stopped early.
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

/// The pair 5(4) of Dormand and Prince 1980 (Hairer, Nørsett and Wanner 1993, II.5, Table 5.2): a_ij, by rows. The last stage is
/// at the end of the step, with the weights of order 5, and the first of the next step.
const A: [&[f64]; 6] = [
    &[1.0 / 5.0],
    &[3.0 / 40.0, 9.0 / 40.0],
    &[44.0 / 45.0, -56.0 / 15.0, 32.0 / 9.0],
    &[19372.0 / 6561.0, -25360.0 / 2187.0, 64448.0 / 6561.0, -212.0 / 729.0],
    &[9017.0 / 3168.0, -355.0 / 33.0, 46732.0 / 5247.0, 49.0 / 176.0, -5103.0 / 18656.0],
    &[35.0 / 384.0, 0.0, 500.0 / 1113.0, 125.0 / 192.0, -2187.0 / 6784.0, 11.0 / 84.0],
];

/// c of the stages after the first.
const C: [f64; 6] = [1.0 / 5.0, 3.0 / 10.0, 4.0 / 5.0, 8.0 / 9.0, 1.0, 1.0];

/// The weights of order 5 less those of order 4.
const ERROR: [f64; 7] =
    [71.0 / 57600.0, 0.0, -71.0 / 16695.0, 71.0 / 1920.0, -17253.0 / 339200.0, 22.0 / 525.0, -1.0 / 40.0];

/// The last term of the interpolant (Hairer, Nørsett and Wanner 1993, II.6).
const BETWEEN: [f64; 7] = [
    -12715105075.0 / 11282082432.0,
    0.0,
    87487479700.0 / 32700410799.0,
    -10690763975.0 / 1880347072.0,
    701980252875.0 / 199316789632.0,
    -1453857185.0 / 822651844.0,
    69997945.0 / 29380423.0,
];

/// dμ/dt at the seven stages.
type Slopes<const N: usize> = [Covector<f64, N>; 7];

/// The vector field, with the last velocity as the next guess.
struct VectorField<'a, L, F, const N: usize> {
    system: &'a EulerPoincare<f64, N, L, F>,
    guess: Vector<f64, N>,
}

impl<L: Lagrangian<f64, N>, F: Force<f64, N>, const N: usize> VectorField<'_, L, F, N> {
    fn at(&mut self, time: f64, mu: &Covector<f64, N>) -> Result<Covector<f64, N>, AdaptiveError> {
        let rates = self.system.rates(time, mu, &self.guess);
        let rates = rates.map_err(|source| AdaptiveError::Legendre { time, source })?;
        if !rates.momentum.iter().all(|v| v.is_finite()) {
            return Err(AdaptiveError::Stopped { time, why: "the vector field is not finite".into() });
        }
        self.guess = rates.velocity;
        Ok(rates.momentum)
    }

    /// The slopes of a step from `mu`, whose own is the first, and the state after it.
    fn step(
        &mut self,
        (time, mu, first): (f64, &Covector<f64, N>, Covector<f64, N>),
        h: f64,
    ) -> Result<(Slopes<N>, Covector<f64, N>), AdaptiveError> {
        let (mut slopes, mut end) = ([Covector::zeros(); 7], *mu);
        slopes[0] = first;
        for (k, row) in A.iter().enumerate() {
            end = *mu;
            for (a, slope) in row.iter().zip(&slopes) {
                end += slope * (h * a);
            }
            slopes[k + 1] = self.at(time + C[k] * h, &end)?;
        }
        Ok((slopes, end))
    }
}

fn weighted<const N: usize>(weights: &[f64; 7], slopes: &Slopes<N>) -> Covector<f64, N> {
    weights.iter().zip(slopes).fold(Covector::zeros(), |sum, (w, slope)| sum + slope * *w)
}

/// Root mean square of x, relative to `tolerance` (1 + size of the state).
fn scaled<const N: usize>(x: &Covector<f64, N>, states: [&Covector<f64, N>; 2], tolerance: f64) -> f64 {
    let scale = |a: usize| tolerance * (1.0 + states[0][a].abs().max(states[1][a].abs()));
    ((0..N).map(|a| (x[a] / scale(a)).powi(2)).sum::<f64>() / N.max(1) as f64).sqrt()
}

/// μ at the part θ of a step of size h: the interpolant of order 4 of the pair.
fn between<const N: usize>(
    theta: f64,
    h: f64,
    [start, end]: [&Covector<f64, N>; 2],
    slopes: &Slopes<N>,
) -> Covector<f64, N> {
    let (left, change) = (1.0 - theta, end - start);
    let bend = slopes[0] * h - change;
    let inner = change - slopes[6] * h - bend + weighted(&BETWEEN, slopes) * (left * h);
    start + (change + (bend + inner * theta) * left) * theta
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
    let mut field = VectorField { system, guess: Vector::zeros() };
    let (mut time, mut mu) = (start, *initial);
    let mut slope = field.at(time, &mu)?;
    let mut samples = vec![(start, mu)];
    // A step that changes the state by a hundredth, by its slope.
    let rate = scaled(&slope, [&mu, &mu], 1.0);
    let mut h = if rate > 0.0 { (0.01 / rate).min(end - start) } else { end - start };
    for _ in 0..MAX_STEPS {
        let last = time + h >= end;
        let size = if last { end - time } else { h };
        if time + size <= time {
            return Err(AdaptiveError::Stopped { time, why: "the step is too small".into() });
        }
        let (slopes, next) = field.step((time, &mu, slope), size)?;
        let error = scaled(&(weighted(&ERROR, &slopes) * size), [&mu, &next], tolerance);
        // The local error is of order 5 in h; safety 0.9, changes of the step between a fifth and tenfold.
        let factor = if error > 0.0 { (0.9 * error.powf(-0.2)).clamp(0.2, 10.0) } else { 10.0 };
        h = size * factor;
        if error > 1.0 || !error.is_finite() {
            continue;
        }
        let after = if last { end } else { time + size };
        while let Some(&wanted) = times.get(samples.len()).filter(|wanted| **wanted <= after) {
            let value =
                if wanted == after { next } else { between((wanted - time) / size, size, [&mu, &next], &slopes) };
            samples.push((wanted, value));
        }
        if last {
            return Ok(samples);
        }
        (time, mu, slope) = (after, next, slopes[6]);
    }
    Err(AdaptiveError::Stopped { time, why: format!("{MAX_STEPS} steps were not enough") })
}
