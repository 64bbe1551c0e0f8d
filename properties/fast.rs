//! The fast steps on SO(3) and SE(3), the solvers that choose their steps, ensembles: known answers, limits, refusals. What holds
//! on random systems is in `laws::fast`.

mod ensembles;
mod solvers;
mod steps;
mod weights;

use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::integrators::State;
use euler_poincare::integrators::so3::{ByLane, Term, Terms};
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

/// The rigid body of the specification.
fn rigid() -> (Quadratic<f64, 3>, State<f64, 3, 3>) {
    let momentum = Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2f64.sqrt();
    let start = State { time: 0.0, momentum, attitude: Matrix::identity() };
    (Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap(), start)
}

/// The body in a fluid of the benchmarks.
fn submerged() -> (Quadratic<f64, 6>, State<f64, 6, 4>) {
    let momentum = Covector::<f64, 6>::from([0.5, -0.25, 1.0, 1.0, 0.5, -0.5]);
    let start = State { time: 0.0, momentum, attitude: Matrix::identity() };
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

/// A force of the general engine on the body in a fluid: its kernels are compiled here, once for all tests.
fn own() -> ByLane<LinearDrag<f64, 6>, 6> {
    ByLane::new(LinearDrag::new(Matrix::from_diagonal_element(0.125)).unwrap()).unwrap()
}
