//! What the variational schemes are compared with: general-purpose integrators on the vector field.

use super::{OneStep, Report, Solver, State, StepError};
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::LieGroup;
use crate::mechanics::equations::{EulerPoincare, attitude_rate};
use crate::mechanics::{Force, Lagrangian, LegendreError};
use crate::scalar::Real;

/// The classical explicit Runge–Kutta method of order 4 on (μ, g), g by the matrix equation ġ = g η̂.
///
/// Nothing keeps g in the group: it drifts off at the order of the method.
pub struct RungeKutta4<T: Real, L, F, G, const N: usize> {
    system: EulerPoincare<T, N, L, F>,
    group: Option<G>,
    guess: Vector<T, N>,
}

impl<T: Real, L, F, G, const N: usize> RungeKutta4<T, L, F, G, N> {
    /// The method on `system`; without a group the attitude is left alone.
    pub fn new(system: EulerPoincare<T, N, L, F>, group: Option<G>) -> Self {
        Self { system, group, guess: Vector::zeros() }
    }
}

/// (μ̇, ġ).
type Slope<T, const N: usize, const D: usize> = (Covector<T, N>, Matrix<T, D>);

impl<T, L, F, G, const N: usize> RungeKutta4<T, L, F, G, N>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
{
    fn slope<const D: usize>(
        &mut self,
        t: T,
        mu: &Covector<T, N>,
        attitude: &Matrix<T, D>,
    ) -> Result<Slope<T, N, D>, LegendreError>
    where
        G: LieGroup<T, N, D>,
    {
        let rates = self.system.rates(t, mu, &self.guess)?;
        self.guess = rates.velocity;
        let turn = match &self.group {
            Some(group) => attitude_rate(group, attitude, &rates.velocity),
            None => Matrix::zeros(),
        };
        Ok((rates.momentum, turn))
    }
}

impl<T, L, F, G, const N: usize, const D: usize> OneStep<T, N, D> for RungeKutta4<T, L, F, G, N>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    G: LieGroup<T, N, D>,
{
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        check(state, h)?;
        let legendre = |source| StepError::Legendre { step: h.to_f64(), source };
        let (t, mu, g) = (state.time, state.momentum, state.attitude);
        let half = h * T::half();
        let (p1, g1) = self.slope(t, &mu, &g).map_err(legendre)?;
        let (p2, g2) = self.slope(t + half, &(mu + p1 * half), &(g + g1 * half)).map_err(legendre)?;
        let (p3, g3) = self.slope(t + half, &(mu + p2 * half), &(g + g2 * half)).map_err(legendre)?;
        let (p4, g4) = self.slope(t + h, &(mu + p3 * h), &(g + g3 * h)).map_err(legendre)?;
        let (two, sixth) = (T::int(2), h / T::int(6));
        let momentum = mu + (p1 + (p2 + p3) * two + p4) * sixth;
        if !momentum.iter().all(|v| v.all_finite()) {
            return Err(StepError::NotFinite { what: "the force" });
        }
        state.time = t + h;
        state.momentum = momentum;
        state.attitude = g + (g1 + (g2 + g3) * two + g4) * sixth;
        Ok(Report { solver: Solver::Explicit, iterations: 0, residual: T::zero() })
    }
}

fn check<T: Real, const N: usize, const D: usize>(state: &State<T, N, D>, h: T) -> Result<(), StepError> {
    let inputs = [
        ("h", h.all_finite()),
        ("the time", state.time.all_finite()),
        ("the momentum", state.momentum.iter().all(|v| v.all_finite())),
        ("the attitude", state.attitude.iter().all(|v| v.all_finite())),
    ];
    match inputs.into_iter().find(|(_, finite)| !finite) {
        Some((what, _)) => Err(StepError::NotFinite { what }),
        None => Ok(()),
    }
}

#[cfg(feature = "cli")]
pub use adaptive::{AdaptiveError, dormand_prince};

#[cfg(feature = "cli")]
mod adaptive {
    use super::{Covector, EulerPoincare, Force, Lagrangian, LegendreError, Vector};
    use ivp::prelude::{FirstOrderSystem, Ivp, Method};
    use std::cell::RefCell;

    /// Steps after which the adaptive integrator gives up.
    const MAX_STEPS: usize = 1_000_000;

    /// Why the adaptive integration stopped early.
    #[derive(Clone, Debug, PartialEq, thiserror::Error)]
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
}
