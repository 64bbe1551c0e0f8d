//! Trajectories of M on [0, T] by a battery of integrators, for the evolution of energy and Casimir.

use super::{ExperimentError, Method, Problem};
use crate::algebra::Covector;
use crate::group::so3::So3;
use crate::integrators::{Classical, OneStep, trajectory};
use crate::tableau::families::Classic;
use std::fmt;

/// An integrator of the battery.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Integrator {
    /// A variational integrator.
    Variational(Method),
    /// The classical Runge–Kutta method of order 4 on M' = M × Ω + f.
    RungeKutta4,
    /// The adaptive pair 5(4) of Dormand and Prince on the same equation.
    DormandPrince {
        /// The relative and absolute tolerance of a step.
        tolerance: f64,
    },
}

impl fmt::Display for Integrator {
    /// `gauss-2`, `rk4`, `dormand-prince`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Variational(method) => method.fmt(f),
            Self::RungeKutta4 => f.pad(Classic::Rk4.name()),
            Self::DormandPrince { .. } => f.pad("dormand-prince"),
        }
    }
}

/// (t, M(t)) at t = 0, h, 2h, …, n h, with h = T/n.
///
/// The adaptive integrator takes its own steps, and is sampled at these times.
///
/// # Errors
/// A step that fails.
pub fn evolve(
    problem: Problem,
    integrator: Integrator,
    steps: usize,
) -> Result<Vec<(f64, Covector<f64, 3>)>, ExperimentError> {
    match integrator {
        Integrator::Variational(method) => run(problem, integrator, &mut method.on::<f64>(problem)?, steps),
        Integrator::RungeKutta4 => {
            let system = problem.model::<f64>().system;
            let mut rk4 = Classical::<f64, 3, 3, _, _, So3<f64>>::new(system, None, Classic::Rk4.tableau()?);
            run(problem, integrator, &mut rk4, steps)
        }
        Integrator::DormandPrince { tolerance } => {
            let model = problem.model::<f64>();
            let times: Vec<f64> = (0..=steps).map(|k| model.horizon * k as f64 / steps as f64).collect();
            Ok(crate::integrators::comparators::dormand_prince(&model.system, &model.momentum, &times, tolerance)?)
        }
    }
}

fn run(
    problem: Problem,
    integrator: Integrator,
    method: &mut impl OneStep<f64, 3, 3>,
    steps: usize,
) -> Result<Vec<(f64, Covector<f64, 3>)>, ExperimentError> {
    let mut state = problem.state();
    let h = problem.model::<f64>().horizon / steps as f64;
    let mut samples = vec![(0.0, state.momentum)];
    trajectory::integrate(method, &mut state, h, steps, |_, state, _| samples.push((state.time, state.momentum)))
        .map_err(problem.failed(integrator, h))?;
    Ok(samples)
}
