//! Properties of `euler_poincare::integrators`: the restricted step against reference values, and where it must refuse.

#[path = "integrators/doubled.rs"]
mod doubled;

use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::integrators::{OneStep, Report, Solver, State, StepError, Variational};
use euler_poincare::mechanics::{Force, Lagrangian};
use euler_poincare::retraction::so3::CayleySo3;
use euler_poincare::scalar::{Real, Scalar};
use euler_poincare::tableau::Tableau;

/// l = ½ Ω·IΩ with I = diag(1/2, 2, 1), by its value alone.
struct Body;

impl<T: Real> Lagrangian<T, 3> for Body {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, 3>) -> S {
        (eta[0] * eta[0] * S::half() + eta[1] * eta[1] * S::int(2) + eta[2] * eta[2]) * S::half()
    }

    fn velocity<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, 3>,
        _: &Vector<S, 3>,
    ) -> Result<Vector<S, 3>, euler_poincare::mechanics::LegendreError> {
        Ok(Vector::<S, 3>::new(mu[0] * S::int(2), mu[1] * S::half(), mu[2]))
    }
}

/// Landau–Lifschitz–Gilbert, M×(M×Ω), or the relaxed body, (Ω×M)×Ω / 10.
enum Torque {
    Llg,
    Relaxed,
}

impl<T: Real> Force<T, 3> for Torque {
    fn force<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, 3>) -> Covector<S, 3> {
        let m = Vector::<S, 3>::new(eta[0] * S::half(), eta[1] * S::int(2), eta[2]);
        match self {
            Torque::Llg => m.cross(&m.cross(eta)).transpose(),
            Torque::Relaxed => eta.cross(&m).cross(eta).transpose() / S::int(10),
        }
    }
}

fn gauss1() -> Tableau<f64> {
    Tableau::new(&[vec![0.5]], &[1.0]).unwrap()
}

fn gauss2() -> Tableau<f64> {
    let r = 3f64.sqrt() / 6.0;
    Tableau::new(&[vec![0.25, 0.25 - r], vec![0.25 + r, 0.25]], &[0.5, 0.5]).unwrap()
}

fn lobatto(kind: char, stages: usize) -> Tableau<f64> {
    let a = match (kind, stages) {
        ('a', 2) => vec![vec![0.0, 0.0], vec![0.5, 0.5]],
        ('b', 2) => vec![vec![0.5, 0.0], vec![0.5, 0.0]],
        ('a', _) => vec![vec![0.0; 3], vec![5.0 / 24.0, 1.0 / 3.0, -1.0 / 24.0], vec![1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0]],
        _ => {
            let (w, x) = (1.0 / 6.0, 1.0 / 3.0);
            vec![vec![w, -w, 0.0], vec![w, x, 0.0], vec![w, 5.0 / 6.0, 0.0]]
        }
    };
    let b = if stages == 2 { vec![0.5, 0.5] } else { vec![1.0 / 6.0, 2.0 / 3.0, 1.0 / 6.0] };
    Tableau::new(&a, &b).unwrap()
}

fn initial() -> State<f64, 3, 3> {
    let w = 0.5f64.sqrt();
    State { time: 0.0, momentum: Covector::<f64, 3>::new(0.5 * w, 0.0, w), attitude: Matrix::identity() }
}

fn first_step(tableau: Tableau<f64>, torque: Torque, h: f64) -> Result<(State<f64, 3, 3>, Report<f64>), StepError> {
    let mut method = Variational::new(Body, torque, CayleySo3::new(), tableau);
    let mut state = initial();
    let report = method.step(&mut state, h)?;
    Ok((state, report))
}

#[test]
fn one_step_reference_values() {
    let rows: [(_, _, [f64; 3]); 5] = [
        (gauss1(), Torque::Llg, [0.3325523603683159, 0.0312710753139576, 0.7165415190785951]),
        (gauss2(), Torque::Llg, [0.3325020802648156, 0.0313526763021243, 0.7165607981817258]),
        (lobatto('a', 3), Torque::Llg, [0.3325020242605735, 0.0313527332683193, 0.7165608236605989]),
        (lobatto('b', 3), Torque::Llg, [0.3325021449851981, 0.0313526299631130, 0.7165607678834958]),
        (gauss2(), Torque::Relaxed, [0.3520359408350419, 0.0313280374056840, 0.7082730193270272]),
    ];
    for (tableau, torque, expected) in rows {
        let (state, report) = first_step(tableau, torque, 0.125).unwrap();
        println!("{report:?}");
        for a in 0..3 {
            assert!((state.momentum[a] - expected[a]).abs() < 1e-13, "{:?} {expected:?}", state.momentum);
        }
    }
}

#[test]
fn folds_are_found() {
    for (name, tableau, h) in [
        ("a2", lobatto('a', 2), 0.79),
        ("a2", lobatto('a', 2), 0.796),
        ("a2", lobatto('a', 2), 0.80),
        ("a2", lobatto('a', 2), 1.0),
        ("b2", lobatto('b', 2), 1.0),
        ("b2", lobatto('b', 2), 1.01),
        ("a3", lobatto('a', 3), 1.94),
        ("a3", lobatto('a', 3), 1.96),
        ("b3", lobatto('b', 3), 2.06),
        ("b3", lobatto('b', 3), 2.09),
        ("g1", gauss1(), 1.71),
        ("g1", gauss1(), 1.73),
        ("g2", gauss2(), 2.04),
        ("g2", gauss2(), 2.06),
        ("g2", gauss2(), 3.0),
        ("g2", gauss2(), -1.0),
    ] {
        println!("{name} {h} {:?}", first_step(tableau, Torque::Llg, h).map(|x| (x.0.momentum, x.1)));
    }
    let _ = Solver::Newton;
}
