//! This crate: the contender that the others are here for.

use crate::contender::{Answer, Contender, Kind};
use crate::problem::{LARGEST, Problem, State, System};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::group::MatrixGroup;
use euler_poincare::integrators::variational::Settings;
use euler_poincare::integrators::{self, OneStep, Variational, trajectory};
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, QuadraticDrag};
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Quadratic};
use euler_poincare::mechanics::models::{landau_lifshitz_gilbert, relaxed_rigid_body};
use euler_poincare::retraction::{Cayley, CayleySo3};
use euler_poincare::tableau::Family;

/// Stages of the Gauss method.
const STAGES: usize = 8;

type OnSo3 = Variational<f64, 3, 3, AnyLagrangian<f64, 3>, AnyForce<f64, 3>, CayleySo3<f64>>;
type OnSe3 = Variational<f64, 6, 4, Quadratic<f64, 6>, AnyForce<f64, 6>, Cayley<f64, 6, 4>>;

/// The variational integrator on Gauss's method of order 16, with a step that depends on the tolerance alone.
#[derive(Default)]
pub struct EulerPoincare {
    /// What does not depend on the initial value, and for which system and tolerance.
    ready: Option<(System, f64, Method)>,
}

enum Method {
    So3(Box<OnSo3>),
    Se3(Box<OnSe3>),
}

impl EulerPoincare {
    fn method(&mut self, system: System, tolerance: f64) -> Result<&mut Method, String> {
        if !matches!(self.ready, Some((known, at, _)) if known == system && at == tolerance) {
            self.ready = Some((system, tolerance, Method::new(system, tolerance)?));
        }
        self.ready.as_mut().map(|(_, _, method)| method).ok_or_else(String::new)
    }
}

impl Method {
    fn new(system: System, tolerance: f64) -> Result<Self, String> {
        let gauss = Family::Gauss.tableau::<f64>(STAGES).map_err(|e| e.to_string())?;
        let settings = Settings { tolerance: (0.01 * tolerance).max(1e-15), ..Settings::default() };
        let model = match system {
            System::LandauLifshitzGilbert => landau_lifshitz_gilbert::<f64>(),
            System::Relaxed => relaxed_rigid_body::<f64>(),
            System::Fluid => {
                let se3 = MatrixGroup::<f64, 6, 4>::from_entry(&Entry::Se3).map_err(|e| e.to_string())?;
                let inertia = Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).map_err(|e| e.to_string())?;
                let linear = LinearDrag::new(Matrix::from_diagonal_element(0.125)).map_err(|e| e.to_string())?;
                let quadratic = QuadraticDrag::new(Matrix::from_diagonal_element(0.25)).map_err(|e| e.to_string())?;
                let force = AnyForce::Sum(vec![linear.into(), quadratic.into()]);
                let cayley = Cayley::new(se3).map_err(|e| e.to_string())?;
                let method = Variational::with_settings(inertia, force, cayley, gauss, settings);
                return Ok(Self::Se3(Box::new(method)));
            }
        };
        let (lagrangian, force) = (model.system.lagrangian, model.system.force);
        let method = Variational::with_settings(lagrangian, force, CayleySo3::new(), gauss, settings);
        Ok(Self::So3(Box::new(method)))
    }
}

/// Equal steps that divide the interval, of the size that the order suggests for the tolerance.
fn steps(problem: &Problem, tolerance: f64) -> usize {
    // Beyond the second number sweeps do not contract, and Newton's method takes over.
    let (scale, most) = if problem.system == System::Fluid { (2.8, 0.5) } else { (5.6, 1.0) };
    let longest = (scale * tolerance.powf(1.0 / (2 * STAGES) as f64)).min(most);
    (problem.end / longest).ceil().max(1.0) as usize
}

/// μ and g from the numbers, the steps, and back.
fn run<const N: usize, const D: usize>(
    method: &mut impl OneStep<f64, N, D>,
    problem: &Problem,
    steps: usize,
    unpack: impl Fn(&State) -> Matrix<f64, D>,
    pack: impl Fn(&Matrix<f64, D>, &mut State),
) -> Result<Answer, String> {
    let momentum = Covector::<f64, N>::from_column_slice(&problem.start[..N]);
    let mut state = integrators::State { time: 0.0, momentum, attitude: unpack(&problem.start) };
    let h = problem.end / steps as f64;
    trajectory::integrate(method, &mut state, h, steps, |_, _, _| {}).map_err(|e| e.to_string())?;
    let mut answer = [0.0; LARGEST];
    answer[..N].copy_from_slice(state.momentum.as_slice());
    pack(&state.attitude, &mut answer);
    Ok(Answer { state: answer, steps })
}

impl Contender for EulerPoincare {
    fn name(&self) -> &str {
        "euler-poincare"
    }

    fn kind(&self) -> Kind {
        Kind::Ours
    }

    fn solve(&mut self, problem: &Problem, tolerance: f64) -> Result<Answer, String> {
        let steps = steps(problem, tolerance);
        match self.method(problem.system, tolerance)? {
            Method::So3(method) => run(
                method.as_mut(),
                problem,
                steps,
                |y| Matrix::from_row_slice(&y[3..12]),
                |g, y| y[3..12].copy_from_slice(g.transpose().as_slice()),
            ),
            Method::Se3(method) => run(
                method.as_mut(),
                problem,
                steps,
                |y| {
                    Matrix::from_fn(|i, j| match (i, j) {
                        (3, j) => f64::from(j == 3),
                        (i, 3) => y[15 + i],
                        (i, j) => y[6 + 3 * i + j],
                    })
                },
                |g, y| {
                    for i in 0..3 {
                        y[15 + i] = g[(i, 3)];
                        for j in 0..3 {
                            y[6 + 3 * i + j] = g[(i, j)];
                        }
                    }
                },
            ),
        }
    }
}
