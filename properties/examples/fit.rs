//! A fit: moments of inertia and drag of a body from noisy samples of its momentum, by Levenberg and Marquardt's method with the
//! derivatives of the run.
//!
//! `cargo run --release --example fit`

use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::integrators::derivative::{Derivative, Linearised, Parameters};
use euler_poincare::integrators::{State, Variational};
use euler_poincare::mechanics::configuration::Configuration;
use euler_poincare::mechanics::{force::LinearDrag, lagrangian::Quadratic};
use euler_poincare::retraction::CayleySo3;
use euler_poincare::tableau::Family;
use rmpfit::{MPConfig, MPError, MPFitter, MPPar, MPResult, MPSide};
use std::error::Error;

/// I₁, I₂ and the coefficients d₁, d₂, d₃ of the drag. I₃ = 1: from μ alone, I⁻¹ is seen up to a multiple of the identity.
const PARAMETERS: usize = 5;
const MOMENTS: usize = 2;

/// A sample after each step.
const SAMPLES: usize = 120;
const STEP: f64 = 0.1;

/// When the fit ends: relative changes of the residuals and of the parameters.
const TOLERANCE: f64 = 1e-15;

/// How force f = −d η and momentum I η depend on the parameters.
struct Body;

impl Parameters<f64, 3> for Body {
    fn count(&self) -> usize {
        PARAMETERS
    }

    fn force(&self, k: usize, _: f64, _: Configuration<'_, f64>, eta: &Vector<f64, 3>) -> Covector<f64, 3> {
        Covector::from_fn(|_, a| if k == MOMENTS + a { -eta[a] } else { 0.0 })
    }

    fn momentum(&self, k: usize, _: f64, _: Configuration<'_, f64>, eta: &Vector<f64, 3>) -> Covector<f64, 3> {
        Covector::from_fn(|_, a| if k == a && a < MOMENTS { eta[a] } else { 0.0 })
    }
}

/// The momenta after each step, one below the other; and their derivatives by each parameter.
fn run(values: &[f64], momenta: &mut [f64], slopes: &mut [Option<Vec<f64>>]) -> Result<(), Box<dyn Error>> {
    let body = Quadratic::diagonal([values[0], values[1], 1.0])?;
    let drag = LinearDrag::new(Matrix::from_diagonal(&Vector::<f64, 3>::new(values[2], values[3], values[4])))?;
    let method = Variational::new(body, drag, CayleySo3::new(), Family::Gauss.tableau(2)?);
    let mut state = State::at_identity(Covector::<f64, 3>::new(0.6, 1.1, 0.8));
    // Called after each step, n from 1.
    let keep = |n: usize, state: &State<f64, 3, 3>, derivative: &Derivative<f64, 3>| {
        let rows = 3 * (n - 1)..3 * n;
        momenta[rows.clone()].copy_from_slice(state.momentum.as_slice());
        for (slopes, along) in slopes.iter_mut().zip(derivative.by_parameters()) {
            if let Some(slopes) = slopes {
                slopes[rows.clone()].copy_from_slice(along.momentum.as_slice());
            }
        }
    };
    Linearised::new(method, Body).sensitivity(&mut state, STEP, SAMPLES, keep)?;
    Ok(())
}

/// The problem: samples, parameters whose derivatives come from the run, and when it ends.
struct Fit {
    samples: Vec<f64>,
    parameters: [MPPar; PARAMETERS],
    config: MPConfig,
}

impl MPFitter for Fit {
    fn eval(&mut self, values: &[f64], residuals: &mut [f64]) -> MPResult<()> {
        self.jacobian(values, residuals, &mut [])
    }

    fn jacobian(&mut self, values: &[f64], residuals: &mut [f64], slopes: &mut [Option<Vec<f64>>]) -> MPResult<()> {
        run(values, residuals, slopes).map_err(|_| MPError::Eval)?;
        residuals.iter_mut().zip(&self.samples).for_each(|(residual, sample)| *residual -= sample);
        Ok(())
    }

    fn number_of_points(&self) -> usize {
        self.samples.len()
    }

    fn config(&self) -> &MPConfig {
        &self.config
    }

    fn parameters(&self) -> &[MPPar] {
        &self.parameters
    }
}

/// Numbers that look random, uniform between −1 and 1 (a linear congruence modulo 2⁶⁴).
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let truth = [0.5, 1.75, 0.05, 0.1, 0.02];
    let mut exact = vec![0.0; 3 * SAMPLES];
    run(&truth, &mut exact, &mut [])?;
    let config = MPConfig { ftol: TOLERANCE, xtol: TOLERANCE, gtol: TOLERANCE, ..MPConfig::new() };
    for (size, within) in [(0.0, 1e-12), (0.01, 0.01)] {
        let mut noise = noise(24);
        let samples = exact.iter().map(|m| m + size * noise()).collect();
        let parameters = std::array::from_fn(|_| MPPar { side: MPSide::User, ..MPPar::new() });
        let mut fit = Fit { samples, parameters, config: config.clone() };
        let mut found = [0.6, 1.5, 0.0, 0.0, 0.0];
        let status = fit.mpfit(&mut found).map_err(|error| error.to_string())?;
        println!("noise {size}, after {} iterations:", status.n_iter);
        // The errors that the residuals let expect: those of samples of deviation 1 times their root mean square.
        let deviation = (status.best_norm / (status.n_func - PARAMETERS) as f64).sqrt();
        for (k, name) in ["I_1", "I_2", "d_1", "d_2", "d_3"].iter().enumerate() {
            println!("    {name} = {:.5} ± {:.5}", found[k], status.xerror[k] * deviation);
            let error = (found[k] - truth[k]).abs();
            assert!(error <= within, "{name} is off by {error:e}");
        }
    }
    Ok(())
}

#[test]
fn it_runs() {
    main().unwrap();
}
