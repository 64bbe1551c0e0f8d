//! This crate: the contender that the others are here for.

use crate::contender::{Answer, Contender, Kind};
use crate::problem::{LARGEST, Problem, State, System};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::group::MatrixGroup;
use euler_poincare::integrators::so3::{AdaptiveSo3, Damping, LaneForce, Relaxation};
use euler_poincare::integrators::variational::Settings;
use euler_poincare::integrators::{self, OneStep, Variational, trajectory};
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, QuadraticDrag};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::Cayley;
use euler_poincare::tableau::Family;

/// Stages of the Gauss method.
const STAGES: usize = 8;

type OnSe3 = Variational<f64, 6, 4, Quadratic<f64, 6>, AnyForce<f64, 6>, Cayley<f64, 6, 4>>;

/// On SO(3) the solver that chooses its steps; on SE(3) Gauss's method of order 16 with a step that depends on the
/// tolerance alone.
#[derive(Default)]
pub struct EulerPoincare {
    /// What does not depend on the initial value, and for which system and tolerance.
    ready: Option<(System, f64, Method)>,
}

enum Method {
    Damped(Box<AdaptiveSo3<Damping>>),
    Relaxed(Box<AdaptiveSo3<Relaxation>>),
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
        let body = || Quadratic::diagonal([0.5, 2.0, 1.0]).map_err(|e| e.to_string());
        Ok(match system {
            System::LandauLifshitzGilbert => Self::Damped(Box::new(AdaptiveSo3::new(body()?, Damping(1.0)))),
            System::Relaxed => Self::Relaxed(Box::new(AdaptiveSo3::new(body()?, Relaxation(0.1)))),
            System::Fluid => {
                let gauss = Family::Gauss.tableau::<f64>(STAGES).map_err(|e| e.to_string())?;
                let settings = Settings { tolerance: (0.01 * tolerance).max(1e-15), ..Settings::default() };
                let se3 = MatrixGroup::<f64, 6, 4>::from_entry(&Entry::Se3).map_err(|e| e.to_string())?;
                let inertia = Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).map_err(|e| e.to_string())?;
                let linear = LinearDrag::new(Matrix::from_diagonal_element(0.125)).map_err(|e| e.to_string())?;
                let quadratic = QuadraticDrag::new(Matrix::from_diagonal_element(0.25)).map_err(|e| e.to_string())?;
                let force = AnyForce::Sum(vec![linear.into(), quadratic.into()]);
                let cayley = Cayley::new(se3).map_err(|e| e.to_string())?;
                Self::Se3(Box::new(Variational::with_settings(inertia, force, cayley, gauss, settings)))
            }
        })
    }
}

/// Equal steps that divide the interval, of the size that the order suggests for the tolerance.
fn steps(problem: &Problem, tolerance: f64) -> usize {
    // Beyond the second number sweeps do not contract, and Newton's method takes over.
    let longest = (2.8 * tolerance.powf(1.0 / (2 * STAGES) as f64)).min(0.5);
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

/// The same by the solver.
fn adapt<F: LaneForce>(solver: &mut AdaptiveSo3<F>, problem: &Problem, tolerance: f64) -> Result<Answer, String> {
    let momentum = Covector::<f64, 3>::from_column_slice(&problem.start[..3]);
    let attitude = Matrix::<f64, 3>::from_row_slice(&problem.start[3..12]);
    let mut state = integrators::State { time: 0.0, momentum, attitude };
    let solved = solver.solve(&mut state, problem.end, tolerance).map_err(|e| e.to_string())?;
    let mut answer = [0.0; LARGEST];
    for a in 0..3 {
        answer[a] = state.momentum[a];
        for b in 0..3 {
            answer[3 + 3 * a + b] = state.attitude[(a, b)];
        }
    }
    Ok(Answer { state: answer, steps: solved.steps })
}

impl Contender for EulerPoincare {
    fn name(&self) -> &str {
        "euler-poincare"
    }

    fn kind(&self) -> Kind {
        Kind::Ours
    }

    fn solve(&mut self, problem: &Problem, tolerance: f64) -> Result<Answer, String> {
        match self.method(problem.system, tolerance)? {
            Method::Damped(solver) => adapt(solver, problem, tolerance),
            Method::Relaxed(solver) => adapt(solver, problem, tolerance),
            Method::Se3(method) => run(
                method.as_mut(),
                problem,
                steps(problem, tolerance),
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
