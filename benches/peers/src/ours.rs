//! This crate: the contender that the others are here for.

use crate::contender::{Answer, Contender, Kind};
use crate::problem::{LARGEST, Problem, State, System};
use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::integrators;
use euler_poincare::integrators::se3::{AdaptiveSe3, CayleySe3, Drag, Term, Terms};
use euler_poincare::integrators::so3::{AdaptiveSo3, ByLane, Damping, Relaxation};
use euler_poincare::integrators::solve::Solve;
use euler_poincare::mechanics::{Force, lagrangian::Quadratic};
use euler_poincare::retraction::{CayleySo3, Retraction};
use euler_poincare::scalar::{Real, Scalar};

/// How the force is given, and what takes the steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The kernels in lanes, with forces that they know.
    Listed,
    /// The kernels in lanes, with forces as a user writes them.
    Own,
    /// `Solve`, which takes any group and force.
    General,
}

/// From the start of a problem to its end, to a tolerance.
type Run = Box<dyn FnMut(&Problem, f64) -> Result<Answer, String>>;

/// The solvers of this crate that choose their steps.
pub struct EulerPoincare {
    way: Way,
    /// What does not depend on the initial value, and for which system.
    ready: Option<(System, Run)>,
}

impl EulerPoincare {
    /// The solvers, taken in this way.
    pub fn new(way: Way) -> Self {
        Self { way, ready: None }
    }
}

/// M × (M × Ω), M = (½ Ω_1, 2 Ω_2, Ω_3).
#[derive(Clone)]
struct OwnDamping;

/// (Ω × M) × Ω/10.
#[derive(Clone)]
struct OwnRelaxation;

/// −(1 + |η|)/8 η.
#[derive(Clone)]
struct OwnDrag;

fn momentum<S: Scalar>(omega: &Vector<S, 3>) -> Vector<S, 3> {
    Vector::<S, 3>::new(omega[0] * S::half(), omega[1] * S::int(2), omega[2])
}

impl<T: Real> Force<T, 3> for OwnDamping {
    fn force<S: Scalar<Base = T>>(&self, _: S, omega: &Vector<S, 3>) -> Covector<S, 3> {
        let m = momentum(omega);
        m.cross(&m.cross(omega)).transpose()
    }
}

impl<T: Real> Force<T, 3> for OwnRelaxation {
    fn force<S: Scalar<Base = T>>(&self, _: S, omega: &Vector<S, 3>) -> Covector<S, 3> {
        (omega.cross(&momentum(omega)).cross(omega) * S::ratio(1, 10)).transpose()
    }
}

impl<T: Real> Force<T, 6> for OwnDrag {
    fn force<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, 6>) -> Covector<S, 6> {
        let speed = eta.iter().fold(S::zero(), |sum, &v| sum + v * v).sqrt();
        eta.transpose() * (-(S::one() + speed) / S::int(8))
    }
}

/// A solver of the kernels as a run.
macro_rules! in_lanes {
    ($solver:expr) => {{
        let mut solver = $solver;
        Box::new(move |problem: &Problem, tolerance| {
            run(problem, |state| solver.solve(state, problem.end, tolerance).map(|solved| solved.steps).map_err(text))
        })
    }};
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// `Solve` as a run.
fn general<F, R, const N: usize, const D: usize>(body: Quadratic<f64, N>, force: F, retraction: R) -> Run
where
    F: Force<f64, N> + Clone + 'static,
    R: Retraction<f64, N, D> + Clone + 'static,
{
    // A solver for each tolerance, with what it has allocated.
    let mut ready: Vec<(f64, Run)> = Vec::new();
    Box::new(move |problem, tolerance| {
        let known = ready.iter().position(|(of, _)| *of == tolerance).unwrap_or_else(|| {
            let mut solve = Solve::new(body.clone(), force.clone(), retraction.clone()).tolerance(tolerance);
            let one = move |problem: &Problem, _: f64| {
                run(problem, |state| {
                    let solution = solve.run(state, problem.end).map_err(text)?;
                    *state = solution.state;
                    Ok(solution.statistics.steps)
                })
            };
            ready.push((tolerance, Box::new(one)));
            ready.len() - 1
        });
        ready[known].1(problem, tolerance)
    })
}

impl Way {
    fn prepare(self, system: System) -> Result<Run, String> {
        let body = || Quadratic::diagonal([0.5, 2.0, 1.0]).map_err(text);
        let fluid = || Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).map_err(text);
        Ok(match (self, system) {
            (Self::Listed, System::LandauLifshitzGilbert) => in_lanes!(AdaptiveSo3::new(body()?, Damping(1.0))),
            (Self::Listed, System::Relaxed) => in_lanes!(AdaptiveSo3::new(body()?, Relaxation(0.1))),
            (Self::Listed, System::Fluid) => {
                let (linear, quadratic) = (Drag::Diagonal([0.125; 6]), Drag::Diagonal([0.25; 6]));
                let force = Terms(vec![Term::LinearDrag(linear), Term::QuadraticDrag(quadratic)]);
                in_lanes!(AdaptiveSe3::new(fluid()?, force))
            }
            (Self::Own, System::LandauLifshitzGilbert) => {
                in_lanes!(AdaptiveSo3::new(body()?, ByLane::new(OwnDamping).map_err(text)?))
            }
            (Self::Own, System::Relaxed) => {
                in_lanes!(AdaptiveSo3::new(body()?, ByLane::new(OwnRelaxation).map_err(text)?))
            }
            (Self::Own, System::Fluid) => in_lanes!(AdaptiveSe3::new(fluid()?, ByLane::new(OwnDrag).map_err(text)?)),
            (Self::General, System::LandauLifshitzGilbert) => general(body()?, OwnDamping, CayleySo3::new()),
            (Self::General, System::Relaxed) => general(body()?, OwnRelaxation, CayleySo3::new()),
            (Self::General, System::Fluid) => general(fluid()?, OwnDrag, CayleySe3::new()),
        })
    }
}

/// A run from the numbers at 0 to those at the end.
fn run<const N: usize, const D: usize>(
    problem: &Problem,
    solve: impl FnOnce(&mut integrators::State<f64, N, D>) -> Result<usize, String>,
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
    let steps = solve(&mut state)?;
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
    Ok(Answer { state: answer, steps })
}

impl Contender for EulerPoincare {
    fn name(&self) -> &str {
        match self.way {
            Way::Listed => "euler-poincare",
            Way::Own => "euler-poincare, own force",
            Way::General => "euler-poincare, Solve",
        }
    }

    fn kind(&self) -> Kind {
        Kind::Ours
    }

    fn solve(&mut self, problem: &Problem, tolerance: f64) -> Result<Answer, String> {
        if !matches!(self.ready, Some((known, _)) if known == problem.system) {
            self.ready = Some((problem.system, self.way.prepare(problem.system)?));
        }
        self.ready.as_mut().map_or_else(|| Err(String::new()), |(_, run)| run(problem, tolerance))
    }
}
