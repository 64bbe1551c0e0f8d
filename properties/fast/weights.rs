//! Bodies with a weight, in a field, and under forces of one's own that depend on the attitude.

use super::{after, distance, own, reach, rigid, submerged, tableau};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::group::{MatrixGroup, So3};
use euler_poincare::integrators::lanes::{Drag, Gravity, LaneForce, Term, Terms, VariationalInLanes};
use euler_poincare::integrators::se3::CayleySe3;
use euler_poincare::integrators::so3::{EnsembleSo3, Member, QuaternionSo3, QuaternionState};
use euler_poincare::integrators::{OneStep, State, Variational};
use euler_poincare::mechanics::configuration::{Potential, WithPotential};
use euler_poincare::mechanics::force::LinearDrag;
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::{CayleySo3, ExponentialSo3, Retraction};
use euler_poincare::scalar::Scalar;

const DRAG: [f64; 3] = [0.1, 0.3, 0.2];

/// The weight 1.3 times the centre of mass (0.3, −0.2, 0.5).
const LEVER: [f64; 3] = [0.39, -0.26, 0.65];

/// A moment of the body, and a field of space.
const MAGNET: ([f64; 3], [f64; 3]) = ([0.25, 0.5, -0.125], [0.5, -0.25, 1.0]);

fn drag() -> Term {
    let [a, b, c] = DRAG;
    Term::LinearDrag(Drag::Full([[a, 0.0, 0.0], [0.0, b, 0.0], [0.0, 0.0, c]]))
}

/// The heavy top of the specification.
fn top() -> (Quadratic<f64, 3>, Terms, State<f64, 3, 3>) {
    let attitude = ExponentialSo3::<f64>::new().tau(&Vector::<f64, 3>::new(0.4, -0.3, 0.2)).unwrap();
    let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.5, 0.3, 0.9), attitude };
    (rigid().0, Terms(vec![drag(), Term::Gravity(1.0, LEVER)]), start)
}

/// ⟨c, Γ⟩ − ⟨R m, B⟩ + w ⟨e₃, x⟩.
struct Height {
    lever: [f64; 3],
    moment: [f64; 3],
    weight: f64,
}

impl<const D: usize> Potential<f64, D> for Height {
    fn value<S: Scalar<Base = f64>>(&self, _: S, g: &Matrix<S, D>) -> S {
        let mut sum = if D > 3 { g[(2, D - 1)] * S::exact(self.weight) } else { S::zero() };
        for c in 0..3 {
            sum += g[(2, c)] * S::exact(self.lever[c]);
            for r in 0..3 {
                sum -= g[(r, c)] * S::exact(self.moment[c] * MAGNET.1[r]);
            }
        }
        sum
    }
}

/// The general engine on the heavy top.
fn general(name: &str) -> impl OneStep<f64, 3, 3> {
    let height = Height { lever: LEVER, moment: [0.0; 3], weight: 0.0 };
    let drag = LinearDrag::new(Matrix::<f64, 3>::from_diagonal(&DRAG.into())).unwrap();
    Variational::new(WithPotential::new(rigid().0, height, So3::new()), drag, CayleySo3::new(), tableau(name))
}

/// A weight 1.3 at (0.3, −0.2, 0.5), and a magnet.
fn heavy_vessel() -> (Quadratic<f64, 6>, Terms<6>, State<f64, 6, 4>) {
    let (vessel, mut afloat) = submerged();
    afloat.attitude = CayleySe3::new().tau(&Vector::<f64, 6>::from([0.5, -0.3, 0.2, 1.0, 2.0, -0.5])).unwrap();
    let drag = Term::LinearDrag(Drag::Diagonal([0.125; 6]));
    let loads = [Term::Gravity(1.3, [0.3, -0.2, 0.5]), Term::UniformField(MAGNET.0, MAGNET.1)];
    (vessel, Terms(vec![drag, loads[0], loads[1]]), afloat)
}

fn general_vessel(name: &str) -> impl OneStep<f64, 6, 4> {
    let (vessel, _, _) = heavy_vessel();
    let group = MatrixGroup::<f64, 6, 4>::from_entry(&Entry::Se3).unwrap();
    let height = Height { lever: [1.3 * 0.3, 1.3 * -0.2, 1.3 * 0.5], moment: MAGNET.0, weight: 1.3 };
    let drag = LinearDrag::new(Matrix::<f64, 6>::from_diagonal_element(0.125)).unwrap();
    Variational::new(WithPotential::new(vessel, height, group), drag, CayleySe3::new(), tableau(name))
}

/// Springs as a potential: ½|x|² − tr R.
struct Held;

impl Potential<f64, 4> for Held {
    fn value<S: Scalar<Base = f64>>(&self, _: S, g: &Matrix<S, 4>) -> S {
        (0..3).fold(S::zero(), |sum, r| sum + g[(r, 3)] * g[(r, 3)] * S::half() - g[(r, r)])
    }
}

#[test]
fn a_force_of_ones_own_sees_the_rotation_and_the_position() {
    let (vessel, _, start) = heavy_vessel();
    let group = MatrixGroup::<f64, 6, 4>::from_entry(&Entry::Se3).unwrap();
    let none = LinearDrag::new(Matrix::<f64, 6>::zeros()).unwrap();
    let held = WithPotential::new(vessel.clone(), Held, group);
    let expected = after(Variational::new(held, none, CayleySe3::new(), tableau("gauss-2")), &start, 0.1, 40);
    let method = VariationalInLanes::new(vessel, own(0.0, 1.0), CayleySe3::new(), tableau("gauss-2")).unwrap();
    let off = distance(&after(method, &start, 0.1, 40), &expected);
    assert!(off < 1e-13, "{off:e}");
}

#[test]
fn without_drag_the_vertical_momentum_is_kept() {
    let (body, _, mut state) = top();
    let weight = Terms(vec![Term::Gravity(1.0, LEVER)]);
    let mut method = VariationalInLanes::new(body, weight, ExponentialSo3::new(), tableau("gauss-2")).unwrap();
    let vertical = |state: &State<f64, 3, 3>| (state.attitude * state.momentum.transpose())[2];
    let spun = vertical(&state);
    for _ in 0..2000 {
        method.step(&mut state, 0.2).unwrap();
        assert!((vertical(&state) - spun).abs() < 1e-13);
    }
}

#[test]
fn solvers_are_within_their_tolerance_of_the_solution() {
    let (body, force, start) = top();
    let (vessel, loads, afloat) = heavy_vessel();
    for span in [1.0, 6.0, -3.0] {
        let steps = (f64::abs(span) * 16.0) as usize;
        let expected = after(general("gauss-8"), &start, span / steps as f64, steps);
        let expected_afloat = after(general_vessel("gauss-8"), &afloat, span / steps as f64, steps);
        for tolerance in [1e-5, 1e-8, 1e-12] {
            let mut state = start.clone();
            let solved = reach(body.clone(), force.clone(), CayleySo3::new(), &mut state, span, tolerance).unwrap();
            let off = (state.momentum - expected.momentum).amax().max((state.attitude - expected.attitude).amax());
            assert!(off < 4.0 * tolerance, "{span}, {tolerance:e}: {off:e}, {solved:?}");
            let mut state = afloat.clone();
            let solved = reach(vessel.clone(), loads.clone(), CayleySe3::new(), &mut state, span, tolerance).unwrap();
            let size = expected_afloat.momentum.amax().max(expected_afloat.attitude.amax());
            let off = (state.momentum - expected_afloat.momentum).amax();
            let off = off.max((state.attitude - expected_afloat.attitude).amax()) / size;
            assert!(off < 16.0 * tolerance, "se(3), {span}, {tolerance:e}: {off:e}, {solved:?}");
        }
    }
}

#[test]
fn a_pendulum_that_turns_back_keeps_its_energy_and_one_at_rest_stays() {
    let (body, _, start) = top();
    let arm = Terms(vec![Term::Gravity(1.0, [0.0, 0.0, -1.0])]);
    let attitude = ExponentialSo3::<f64>::new().tau(&Vector::<f64, 3>::new(2.0, 0.0, 0.0)).unwrap();
    let rest = State { momentum: Covector::zeros(), attitude, ..start };
    let energy = |state: &State<f64, 3, 3>| state.momentum[0] * state.momentum[0] - state.attitude[(2, 2)];
    for tolerance in [1e-5, 1e-9, 1e-12] {
        let mut state = rest.clone();
        let solved = reach(body.clone(), arm.clone(), CayleySo3::new(), &mut state, 30.0, tolerance).unwrap();
        let off = (energy(&state) - energy(&rest)).abs();
        assert!(off < 4.0 * tolerance && solved.steps < 200, "{tolerance:e}: {off:e}, {solved:?}");
    }
    // From rest with fixed steps, alone and with others: fixed-point iterations take every step.
    let method = VariationalInLanes::new(body.clone(), arm.clone(), CayleySo3::new(), tableau("gauss-2")).unwrap();
    let swung = after(method, &rest, 0.01, 1000);
    let members = vec![Member { lagrangian: body.clone(), force: arm.clone(), state: rest.clone() }; 3];
    let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), tableau("gauss-2")).unwrap();
    ensemble.advance(0.01, 1000).unwrap();
    assert!((energy(&swung) - energy(&rest)).abs() < 1e-8 && distance(&ensemble.state(1).unwrap(), &swung) < 1e-12);
    // Hanging; and without any force, whatever the tolerance.
    let hanging = State { attitude: Matrix::identity(), ..rest };
    for (force, tolerance) in [(arm.clone(), 1e-5), (arm, 1e-9), (Terms(vec![]), 1e-5)] {
        let mut state = hanging.clone();
        assert_eq!(reach(body.clone(), force, CayleySo3::new(), &mut state, 10.0, tolerance).unwrap().steps, 1);
        assert_eq!((state.momentum, state.attitude, state.time), (hanging.momentum, hanging.attitude, 10.0));
    }
}

#[test]
fn a_heavy_top_with_drag_comes_to_rest() {
    // Where it hangs rounding of g makes more of the torque than is left of the momentum.
    let (body, force, start) = top();
    let hangs = |state: &State<f64, 3, 3>| {
        let along = (0..3).fold(0.0, |sum, k| sum + LEVER[k] * state.attitude[(2, k)]);
        let length = LEVER.iter().fold(0.0f64, |sum, v| sum + v * v).sqrt();
        assert!(state.momentum.amax() < 1e-14 && along / length + 1.0 < 1e-14, "{state:?}");
    };
    let method = || VariationalInLanes::new(body.clone(), force.clone(), CayleySo3::new(), tableau("gauss-2")).unwrap();
    hangs(&after(method(), &start, 0.125, 6000));
    let (mut quaternion, mut state) = (QuaternionSo3::of(method()), QuaternionState::from(start.clone()));
    for _ in 0..6000 {
        quaternion.step(&mut state, 0.125).unwrap();
    }
    hangs(&state.into());
    let member = |state| Member { lagrangian: body.clone(), force: force.clone(), state };
    let members: Vec<_> = (0..3).map(|_| member(start.clone())).collect();
    let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), tableau("gauss-2")).unwrap();
    ensemble.advance(0.125, 6000).unwrap();
    hangs(&ensemble.state(1).unwrap());
    for tolerance in [1e-6, 1e-10] {
        let mut state = start.clone();
        let solved = reach(body.clone(), force.clone(), CayleySo3::new(), &mut state, 2000.0, tolerance).unwrap();
        assert!(state.momentum.amax() < 1e-12 && solved.steps < 20_000, "{tolerance:e}: {state:?}, {solved:?}");
    }
}

#[test]
fn without_an_attitude_a_force_is_that_at_the_identity() {
    let lever = Gravity([0.5, -0.25, 1.0]);
    let terms = Terms(vec![Term::Gravity(1.0, lever.0)]);
    // −c × e₃, on the numbers of a body at the identity.
    let state = State::at_identity(Covector::<f64, 3>::zeros());
    let gauss = |force| VariationalInLanes::new(rigid().0, force, CayleySo3::new(), tableau("gauss-1")).unwrap();
    let gained = after(gauss(terms.clone()), &state, 1e-6, 1).momentum / 1e-6;
    assert!((gained - Covector::<f64, 3>::new(0.25, 0.5, 0.0)).amax() < 1e-5, "{gained}");
    assert!(LaneForce::<3, 3>::uses_attitude(&terms));
    assert!(LaneForce::<3, 3>::uses_attitude(&(Terms::<3, f64>(vec![]), lever)));
    assert!(!LaneForce::<3, 3>::uses_attitude(&Terms(vec![drag()])));
}
