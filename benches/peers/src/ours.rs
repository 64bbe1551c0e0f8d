//! This crate: the contender that the others are here for.

use crate::contender::{Answer, Contender, Kind};
use crate::problem::{LARGEST, Problem, State, System};
use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::integrators;
use euler_poincare::integrators::se3::{AdaptiveSe3, Drag, Term, Terms};
use euler_poincare::integrators::so3::{AdaptiveSo3, Damping, LaneForce, Relaxation, SolveError, Solved};
use euler_poincare::mechanics::lagrangian::Quadratic;

/// The solvers that choose their steps, on SO(3) and on SE(3).
#[derive(Default)]
pub struct EulerPoincare {
    /// What does not depend on the initial value, and for which system.
    ready: Option<(System, Method)>,
}

enum Method {
    Damped(Box<AdaptiveSo3<Damping>>),
    Relaxed(Box<AdaptiveSo3<Relaxation>>),
    Fluid(Box<AdaptiveSe3<Terms>>),
}

impl EulerPoincare {
    fn method(&mut self, system: System) -> Result<&mut Method, String> {
        if !matches!(self.ready, Some((known, _)) if known == system) {
            self.ready = Some((system, Method::new(system)?));
        }
        self.ready.as_mut().map(|(_, method)| method).ok_or_else(String::new)
    }
}

impl Method {
    fn new(system: System) -> Result<Self, String> {
        let body = || Quadratic::diagonal([0.5, 2.0, 1.0]).map_err(|e| e.to_string());
        Ok(match system {
            System::LandauLifshitzGilbert => Self::Damped(Box::new(AdaptiveSo3::new(body()?, Damping(1.0)))),
            System::Relaxed => Self::Relaxed(Box::new(AdaptiveSo3::new(body()?, Relaxation(0.1)))),
            System::Fluid => {
                let inertia = Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).map_err(|e| e.to_string())?;
                let (linear, quadratic) = (Drag::Diagonal([0.125; 6]), Drag::Diagonal([0.25; 6]));
                let force = Terms(vec![Term::LinearDrag(linear), Term::QuadraticDrag(quadratic)]);
                Self::Fluid(Box::new(AdaptiveSe3::new(inertia, force)))
            }
        })
    }
}

/// A run from the numbers at 0 to those at the end.
fn run<const N: usize, const D: usize>(
    problem: &Problem,
    solve: impl FnOnce(&mut integrators::State<f64, N, D>) -> Result<Solved, SolveError>,
) -> Result<Answer, String> {
    let momentum = Covector::<f64, N>::from_column_slice(&problem.start[..N]);
    let mut state = integrators::State { time: 0.0, momentum, attitude: Matrix::identity() };
    for i in 0..3 {
        for j in 0..3 {
            state.attitude[(i, j)] = problem.start[N + 3 * i + j];
        }
        if D == 4 {
            state.attitude[(i, 3)] = problem.start[N + 9 + i];
        }
    }
    let solved = solve(&mut state).map_err(|e| e.to_string())?;
    let mut answer: State = [0.0; LARGEST];
    answer[..N].copy_from_slice(state.momentum.as_slice());
    for i in 0..3 {
        for j in 0..3 {
            answer[N + 3 * i + j] = state.attitude[(i, j)];
        }
        if D == 4 {
            answer[N + 9 + i] = state.attitude[(i, 3)];
        }
    }
    Ok(Answer { state: answer, steps: solved.steps })
}

/// The same on SO(3), whatever the force.
fn body<F: LaneForce>(solver: &mut AdaptiveSo3<F>, problem: &Problem, tolerance: f64) -> Result<Answer, String> {
    run::<3, 3>(problem, |state| solver.solve(state, problem.end, tolerance))
}

impl Contender for EulerPoincare {
    fn name(&self) -> &str {
        "euler-poincare"
    }

    fn kind(&self) -> Kind {
        Kind::Ours
    }

    fn solve(&mut self, problem: &Problem, tolerance: f64) -> Result<Answer, String> {
        match self.method(problem.system)? {
            Method::Damped(solver) => body(solver, problem, tolerance),
            Method::Relaxed(solver) => body(solver, problem, tolerance),
            Method::Fluid(solver) => run::<6, 4>(problem, |state| solver.solve(state, problem.end, tolerance)),
        }
    }
}
