//! This crate: the contender that the others are here for.

use crate::contender::{Answer, Contender, Kind};
use crate::problem::{LARGEST, Problem, State, System};
use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::group::{LieGroup, Se2, Sl2, So3, So4};
use euler_poincare::integrators;
use euler_poincare::integrators::lanes::{
    ByLane, Damping, Drag, FastRetraction, Gravity as Weight, LaneAttitude, LaneForce, Lanes, Relaxation, Term, Terms,
};
use euler_poincare::integrators::se3::CayleySe3;
use euler_poincare::integrators::solve::{Engine, Solve};
use euler_poincare::mechanics::configuration::{OfPotential, Potential, WithPotential};
use euler_poincare::mechanics::force::Zero;
use euler_poincare::mechanics::{Force, Lagrangian, lagrangian::Quadratic};
use euler_poincare::retraction::{Cayley, CayleySo3, Retraction};
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

/// The potential (13/10) ⟨Γ, r⟩ of a weight at r = (3/10, 0, 1/2).
#[derive(Clone)]
pub struct Gravity;

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

impl<T: Real, const N: usize> Force<T, N> for OwnDrag {
    fn force<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, N>) -> Covector<S, N> {
        let speed = eta.iter().fold(S::zero(), |sum, &v| sum + v * v).sqrt();
        eta.transpose() * (-(S::one() + speed) / S::int(8))
    }
}

impl<T: Real> Potential<T, 3> for Gravity {
    fn value<S: Scalar<Base = T>>(&self, _: S, g: &Matrix<S, 3>) -> S {
        (g[(2, 0)] * S::ratio(3, 10) + g[(2, 2)] * S::half()) * S::ratio(13, 10)
    }
}

fn text(error: impl std::fmt::Display) -> String {
    error.to_string()
}

/// `Solve` as a run, whose attitudes `write` turns into the numbers of a problem.
fn ready<E: Engine<f64, N, D> + 'static, const N: usize, const D: usize>(
    write: impl Fn(&Matrix<f64, D>, &mut [f64]) + Copy + 'static,
    solver: impl Fn() -> Solve<'static, f64, N, D, E> + 'static,
) -> Run
where
    E::Parts: 'static,
{
    // A solver for each tolerance, with what it has allocated.
    let mut ready: Vec<(f64, Run)> = Vec::new();
    Box::new(move |problem, tolerance| {
        let known = ready.iter().position(|(of, _)| *of == tolerance).unwrap_or_else(|| {
            let mut solve = solver().tolerance(tolerance);
            let one = move |problem: &Problem, _: f64| {
                run(problem, write, |state| {
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

/// Of any Lagrangian, force and retraction.
fn general<L, F, R, const N: usize, const D: usize>(
    (body, force, retraction): (L, F, R),
    write: impl Fn(&Matrix<f64, D>, &mut [f64]) + Copy + 'static,
) -> Run
where
    L: Lagrangian<f64, N> + Clone + 'static,
    F: Force<f64, N> + Clone + 'static,
    R: Retraction<f64, N, D> + Clone + 'static,
{
    ready(write, move || Solve::new(body.clone(), force.clone(), retraction.clone()))
}

/// Of a body, in lanes.
fn in_lanes<F: LaneForce<N, D> + 'static, R: FastRetraction<N, D> + 'static, const N: usize, const D: usize>(
    (body, force, retraction): (Quadratic<f64, N>, F, R),
    write: impl Fn(&Matrix<f64, D>, &mut [f64]) + Copy + 'static,
) -> Run {
    ready(write, move || Solve::in_lanes(body.clone(), force.clone(), retraction.clone()))
}

/// The Cayley map of a group.
fn cayley<G: LieGroup<f64, N, D>, const N: usize, const D: usize>(group: G) -> Result<Cayley<f64, N, D, G>, String> {
    Cayley::new(group).map_err(text)
}

fn body() -> Result<Quadratic<f64, 3>, String> {
    Quadratic::diagonal([0.5, 2.0, 1.0]).map_err(text)
}

/// A body of six dimensions.
fn large() -> Result<Quadratic<f64, 6>, String> {
    Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).map_err(text)
}

fn special() -> Result<Quadratic<f64, 3>, String> {
    Quadratic::diagonal([1.0, 2.0, 1.5]).map_err(text)
}

/// −(1 + |η|)/8 η, in lanes.
#[derive(Clone)]
struct DragInLanes;

impl<const N: usize, const D: usize> LaneForce<N, D> for DragInLanes {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V, N, D>>(&self, t: V, _: G, _: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        let mut square = t.constant(0.0);
        for v in eta {
            square = v.mul_add(v, square);
        }
        let factor = (t.constant(1.0) + square.sqrt()) * t.constant(-0.125);
        let mut out = sum;
        for a in 0..N {
            out[a] = factor.mul_add(eta[a], sum[a]);
        }
        out
    }

    fn uses_attitude(&self) -> bool {
        false
    }
}

impl Way {
    fn prepare(self, system: System) -> Result<Run, String> {
        let so3 = CayleySo3::new;
        Ok(match (self, system) {
            (Self::General, _) => return Self::in_general(system),
            (Self::Listed, System::LandauLifshitzGilbert) => in_lanes((body()?, Damping(1.0), so3()), frame),
            (Self::Listed, System::Relaxed) => in_lanes((body()?, Relaxation(0.1), so3()), frame),
            (Self::Listed, System::Fluid) => {
                let (linear, quadratic) = (Drag::Diagonal([0.125; 6]), Drag::Diagonal([0.25; 6]));
                let force = Terms(vec![Term::LinearDrag(linear), Term::QuadraticDrag(quadratic)]);
                in_lanes((large()?, force, CayleySe3::new()), frame)
            }
            (Self::Listed, System::HeavyTop) => in_lanes((body()?, Weight([1.3 * 0.3, 0.0, 1.3 * 0.5]), so3()), frame),
            (Self::Listed, System::Plane) => in_lanes((body()?, DragInLanes, cayley(Se2::new())?), plane),
            (Self::Listed, System::Special) => in_lanes((special()?, DragInLanes, cayley(Sl2::new())?), rows),
            (Self::Listed, System::FourSpace) => in_lanes((large()?, DragInLanes, cayley(So4::new())?), rows),
            (Self::Own, System::LandauLifshitzGilbert) => in_lanes((body()?, ByLane(OwnDamping), so3()), frame),
            (Self::Own, System::Relaxed) => in_lanes((body()?, ByLane(OwnRelaxation), so3()), frame),
            (Self::Own, System::Fluid) => in_lanes((large()?, ByLane(OwnDrag), CayleySe3::new()), frame),
            (Self::Own, System::Plane) => in_lanes((body()?, ByLane(OwnDrag), cayley(Se2::new())?), plane),
            (Self::Own, System::Special) => in_lanes((special()?, ByLane(OwnDrag), cayley(Sl2::new())?), rows),
            (Self::Own, System::FourSpace) => in_lanes((large()?, ByLane(OwnDrag), cayley(So4::new())?), rows),
            (Self::Own, System::HeavyTop) => {
                in_lanes((body()?, ByLane(OfPotential::new(Gravity, So3::new())), so3()), frame)
            }
        })
    }

    fn in_general(system: System) -> Result<Run, String> {
        Ok(match system {
            System::LandauLifshitzGilbert => general((body()?, OwnDamping, CayleySo3::new()), frame),
            System::Relaxed => general((body()?, OwnRelaxation, CayleySo3::new()), frame),
            System::HeavyTop => {
                let top = WithPotential::new(body()?, Gravity, So3::new());
                general((top, Zero, CayleySo3::new()), frame)
            }
            System::Plane => general((body()?, OwnDrag, cayley(Se2::new())?), plane),
            System::Special => general((special()?, OwnDrag, cayley(Sl2::new())?), rows),
            System::Fluid => general((large()?, OwnDrag, CayleySe3::new()), frame),
            System::FourSpace => general((large()?, OwnDrag, cayley(So4::new())?), rows),
        })
    }
}

/// The rotation row by row; then the position, if there is one.
#[inline(always)]
fn frame<const D: usize>(g: &Matrix<f64, D>, numbers: &mut [f64]) {
    for i in 0..3 {
        for j in 0..3 {
            numbers[3 * i + j] = g[(i, j)];
        }
        if D == 4 {
            numbers[9 + i] = g[(i, 3)];
        }
    }
}

/// The cosine and the sine of the angle, and the position.
#[inline(always)]
fn plane(g: &Matrix<f64, 3>, numbers: &mut [f64]) {
    numbers[..4].copy_from_slice(&[g[(0, 0)], g[(1, 0)], g[(0, 2)], g[(1, 2)]]);
}

/// All entries, row by row.
#[inline(always)]
fn rows<const D: usize>(g: &Matrix<f64, D>, numbers: &mut [f64]) {
    for i in 0..D {
        for j in 0..D {
            numbers[D * i + j] = g[(i, j)];
        }
    }
}

/// A run from the momentum at 0, and the identity, to the numbers at the end.
fn run<const N: usize, const D: usize>(
    problem: &Problem,
    write: impl Fn(&Matrix<f64, D>, &mut [f64]),
    solve: impl FnOnce(&mut integrators::State<f64, N, D>) -> Result<usize, String>,
) -> Result<Answer, String> {
    let momentum = Covector::<f64, N>::from_column_slice(&problem.start[..N]);
    let mut state = integrators::State { time: 0.0, momentum, attitude: Matrix::identity() };
    let steps = solve(&mut state)?;
    let mut answer: State = [0.0; LARGEST];
    answer[..N].copy_from_slice(state.momentum.as_slice());
    write(&state.attitude, &mut answer[N..]);
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

    fn takes(&self, _: &Problem) -> bool {
        true
    }

    fn solve(&mut self, problem: &Problem, tolerance: f64) -> Result<Answer, String> {
        if !matches!(self.ready, Some((known, _)) if known == problem.system) {
            self.ready = Some((problem.system, self.way.prepare(problem.system)?));
        }
        self.ready.as_mut().map_or_else(|| Err(String::new()), |(_, run)| run(problem, tolerance))
    }
}
