//! The fast steps on SO(3) and SE(3), the solvers that choose their steps, ensembles: known answers, limits, refusals. What holds
//! on random systems is in `laws::fast`.

mod ensembles;
mod solvers;
mod steps;
mod weights;

use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::integrators::lanes::Lanes;
use euler_poincare::integrators::lanes::{ByLane, FastRetraction, LaneAttitude, LaneForce, Term, Terms};
use euler_poincare::integrators::solve::{InLanes, SolveError, Statistics};
use euler_poincare::integrators::{OneStep, Solve, State};
use euler_poincare::mechanics::force::LinearDrag;
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::tableau::{Description, Tableau};

const U: f64 = f64::EPSILON / 2.0;

fn tableau(name: &str) -> Tableau<f64> {
    name.parse::<Description>().unwrap().build().unwrap()
}

fn distance<const N: usize, const D: usize>(x: &State<f64, N, D>, y: &State<f64, N, D>) -> f64 {
    (x.momentum - y.momentum).amax().max((x.attitude - y.attitude).amax()).max((x.time - y.time).abs())
}

/// The state after a number of steps.
fn after<const N: usize, const D: usize>(
    mut method: impl OneStep<f64, N, D>,
    start: &State<f64, N, D>,
    h: f64,
    steps: usize,
) -> State<f64, N, D> {
    let mut state = start.clone();
    for _ in 0..steps {
        method.step(&mut state, h).unwrap();
    }
    state
}

/// Replaces `state` by the state a time later, or by the last one that was reached.
fn reach<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize>(
    body: Quadratic<f64, N>,
    force: F,
    retraction: R,
    state: &mut State<f64, N, D>,
    span: f64,
    tolerance: f64,
) -> Result<Statistics<f64>, SolveError> {
    on(&mut Solve::in_lanes(body, force, retraction).tolerance(tolerance), state, span)
}

/// The same with a solver at hand.
fn on<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize>(
    solve: &mut Solve<'_, f64, N, D, InLanes<F, R, N, D>>,
    state: &mut State<f64, N, D>,
    span: f64,
) -> Result<Statistics<f64>, SolveError> {
    let solution = solve.run(state, state.time + span);
    let (solution, error) = match solution {
        Ok(solution) => (solution, None),
        Err(failure) => (*failure.reached, Some(failure.error)),
    };
    *state = solution.state;
    error.map_or(Ok(solution.statistics), Err)
}

/// The rigid body of the specification.
fn rigid() -> (Quadratic<f64, 3>, State<f64, 3, 3>) {
    let start = State::at_identity(Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2f64.sqrt());
    (Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap(), start)
}

/// The body in a fluid of the benchmarks.
fn submerged() -> (Quadratic<f64, 6>, State<f64, 6, 4>) {
    let start = State::at_identity(Covector::<f64, 6>::from([0.5, -0.25, 1.0, 1.0, 0.5, -0.5]));
    (Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).unwrap(), start)
}

// The forces as terms: for these the kernels are compiled in the library, for other types here.

/// α M × (M × Ω).
fn damping(alpha: f64) -> Terms {
    Terms(vec![Term::Damping(alpha)])
}

/// β (Ω × M) × Ω.
fn relaxation(beta: f64) -> Terms {
    Terms(vec![Term::Relaxation(beta)])
}

/// None.
fn unforced() -> Terms {
    Terms(Vec::new())
}

/// A spring that holds the position, and one that holds the axes: −x in the axes of the body, −(R − Rᵀ)^∨, times a stiffness.
#[derive(Clone)]
struct Springs(f64);

impl LaneForce<6, 4> for Springs {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V, 6, 4>>(&self, _t: V, g: G, _m: [V; 6], _eta: [V; 6], sum: [V; 6]) -> [V; 6] {
        let (x, y, z) = (g.row(0), g.row(1), g.row(2));
        let k = sum[0].constant(self.0);
        let pull = g.in_body(g.position());
        [
            sum[0] - (z[1] - y[2]) * k,
            sum[1] - (x[2] - z[0]) * k,
            sum[2] - (y[0] - x[1]) * k,
            sum[3] - pull[0] * k,
            sum[4] - pull[1] * k,
            sum[5] - pull[2] * k,
        ]
    }
}

/// Forces of one's own on the body in a fluid: a drag of the general engine, and springs. One type, whose kernels are compiled here once for
/// all tests.
fn own(drag: f64, stiffness: f64) -> (ByLane<LinearDrag<f64, 6>>, Springs) {
    let drag = LinearDrag::new(Matrix::from_diagonal_element(drag)).unwrap();
    (ByLane(drag), Springs(stiffness))
}
