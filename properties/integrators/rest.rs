//! A body at rest, with a force that starts at 0 or switches on: nothing at the start says what is small.

use euler_poincare::algebra::{Covector, Vector};
use euler_poincare::integrators::lanes::{ByLane, Term, Terms, VariationalInLanes};
use euler_poincare::integrators::so3::{EnsembleSo3, Member};
use euler_poincare::integrators::{Doubled, DoubledState, OneStep, Solve, Solver, State, Variational};
use euler_poincare::mechanics::Force;
use euler_poincare::mechanics::doubled::Forced;
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::{CayleySo3, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Dd, Real, Scalar};
use euler_poincare::tableau::{Description, Tableau};

/// A torque about the first axis.
#[derive(Clone, Copy, Debug)]
enum Torque {
    /// t/10.
    Ramp,
    /// sin t.
    Sine,
    /// 1/10 from this time on.
    Switched(f64),
    /// The ramp, and the drag −η.
    Damped,
}

impl Torque {
    /// Its integral from 0, where it is known.
    fn momentum(self, t: f64) -> f64 {
        match self {
            Self::Ramp | Self::Damped => t * t / 20.0,
            Self::Sine => 1.0 - t.cos(),
            Self::Switched(from) => (t - from) / 10.0,
        }
    }
}

impl<T: Real> Force<T, 3> for Torque {
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, 3>) -> Covector<S, 3> {
        let along = match self {
            Self::Ramp | Self::Damped => t / S::int(10),
            Self::Sine => t.sin(),
            Self::Switched(from) if t.base() < T::exact(*from) => S::zero(),
            Self::Switched(_) => S::ratio(1, 10),
        };
        let drag = if matches!(self, Self::Damped) { eta.transpose() } else { Covector::zeros() };
        Covector::from([along, S::zero(), S::zero()]) - drag
    }
}

fn body<T: Real>() -> Quadratic<T, 3> {
    Quadratic::diagonal([2, 3, 4].map(T::int)).unwrap()
}

fn rest<T: Real>() -> State<T, 3, 3> {
    State::at_identity(Covector::zeros())
}

const TABLEAUX: &str = "gauss-1 gauss-2 gauss-3 gauss-4 heun2 rk4 sdirk2 radau-ia-2 radau-iia-2 radau-iia-3 lobatto-iiia-2 \
    lobatto-iiia-3 lobatto-iiib-3 lobatto-iiic-3";

fn tableau<T: Real>(name: &str) -> Tableau<T> {
    name.parse::<Description>().unwrap().build().unwrap()
}

/// The state after a number of steps of h, each of them taken.
fn run<T: Real>(method: &mut impl OneStep<T, 3, 3>, h: T, steps: usize, name: &str) -> State<T, 3, 3> {
    let mut state = rest();
    for k in 0..steps {
        method.step(&mut state, h).unwrap_or_else(|error| panic!("{name}, step {k}: {error}"));
    }
    state
}

/// μ₁ = t²/20 and an angle of t³/120, exact for order 3, where every step about one axis is a quadrature.
fn is_ramped<T: Real>(state: &State<T, 3, 3>, angle: bool, rounding: f64, name: &str) {
    let (mu, g) = (state.momentum.map(|v| v.to_f64()), state.attitude.map(|v| v.to_f64()));
    assert!((mu[0] - 0.45).abs() < rounding && mu[1] == 0.0 && mu[2] == 0.0, "{name}: {mu}");
    let turned = g[(2, 1)].atan2(g[(1, 1)]);
    assert!(!angle || (turned - 0.225).abs() < rounding, "{name}: turned by {turned}");
    assert!(g[(0, 0)] == 1.0 && g[(0, 1)] == 0.0 && g[(2, 0)] == 0.0, "{name}: {g}");
}

fn in_all_tableaux<T: Real, R: Retraction<T, 3, 3> + Clone>(retraction: &R, exact: bool, rounding: f64) {
    for name in TABLEAUX.split(' ') {
        let of_order_three = !["gauss-1", "heun2", "sdirk2", "lobatto-iiia-2"].contains(&name);
        let mut method = Variational::new(body(), Torque::Ramp, retraction.clone(), tableau(name));
        let state = run(&mut method, T::ratio(1, 10), 30, name);
        is_ramped(&state, exact && of_order_three, rounding, name);
    }
}

#[test]
fn a_torque_that_starts_at_zero_turns_a_body_at_rest() {
    in_all_tableaux(&ExponentialSo3::<f64>::new(), true, 1e-14);
    in_all_tableaux(&CayleySo3::<f64>::new(), false, 1e-14);
    in_all_tableaux(&ExponentialSo3::<Dd>::new(), true, 1e-15);
}

/// In small steps and large ones, from smooth torques, sudden ones and those that rates depend on.
#[test]
fn so_do_torques_of_other_kinds() {
    for name in TABLEAUX.split(' ') {
        for torque in [Torque::Ramp, Torque::Sine, Torque::Switched(0.04), Torque::Damped] {
            for (h, steps) in [(1e-6, 10), (1e-3, 10), (0.03, 10), (0.1, 10), (0.5, 2), (-0.1, 3)] {
                let mut method = Variational::new(body(), torque, ExponentialSo3::new(), tableau(name));
                let state = run(&mut method, h, steps, &format!("{name}, {torque:?}, h = {h}"));
                // Within what the order and the drag make of it; a jump within a step counts by the weights of its stages.
                let (right, found) = (torque.momentum(state.time), state.momentum[0]);
                let off = match torque {
                    _ if h < 0.0 => continue,
                    Torque::Ramp => 1e-12 * right.abs(),
                    Torque::Sine => 0.05 * right,
                    Torque::Damped => 0.5 * state.time * right,
                    Torque::Switched(_) => 0.1 * h,
                };
                assert!((found - right.max(0.0)).abs() <= off, "{name}, {torque:?}, h = {h}: {found} for {right}");
            }
        }
    }
}

/// Small as the first step is, fixed-point iterations take it.
#[test]
fn no_newton_is_needed() {
    for name in TABLEAUX.split(' ') {
        let mut method = Variational::new(body(), Torque::Ramp, ExponentialSo3::new(), tableau(name));
        let report = method.step(&mut rest(), 0.1).unwrap();
        assert_eq!(report.solver, Solver::FixedPoint, "{name}");
    }
}

#[test]
fn the_doubled_scheme_does_the_same() {
    for name in TABLEAUX.split(' ') {
        let forced = Forced::new(body(), Torque::Ramp, CayleySo3::new());
        let mut doubled = Doubled::new(tableau(name), CayleySo3::new(), forced);
        let mut double = DoubledState::<f64, 3, 3>::unit(0.0, Covector::zeros());
        let mut single = Variational::new(body(), Torque::Ramp, CayleySo3::new(), tableau(name));
        let mut state = rest();
        for _ in 0..10 {
            doubled.step(&mut double, 0.1).unwrap_or_else(|error| panic!("{name}: {error}"));
            single.step(&mut state, 0.1).unwrap();
            assert!((double.mu - state.momentum).amax() < 1e-15, "{name}: {} {}", double.mu, state.momentum);
        }
    }
}

#[test]
fn kernels_in_lanes_do_the_same() {
    let torque = ByLane(Torque::Ramp);
    let names = TABLEAUX.split(' ').filter(|name| tableau::<f64>(name).stages() <= 8);
    for name in names {
        let mut fast = VariationalInLanes::new(body(), torque, ExponentialSo3::new(), tableau(name)).unwrap();
        is_ramped(&run(&mut fast, 0.1, 30, name), false, 1e-14, name);
    }
}

#[test]
fn ensembles_do_the_same() {
    // sin t.
    let force = Terms(vec![Term::Periodic([1.0, 0.0, 0.0], 1.0, -std::f64::consts::FRAC_PI_2)]);
    for name in TABLEAUX.split(' ') {
        let members: Vec<_> =
            (0..9).map(|_| Member { lagrangian: body(), force: force.clone(), state: rest() }).collect();
        let mut ensemble = EnsembleSo3::new(&members, ExponentialSo3::new(), tableau(name)).unwrap();
        ensemble.advance(0.1, 30).unwrap_or_else(|error| panic!("{name}: {error}"));
        for state in ensemble.states() {
            let off = state.momentum[0] - Torque::Sine.momentum(3.0);
            assert!(off.abs() < 5e-3, "{name}: {}", state.momentum);
        }
    }
}

#[test]
fn solvers_with_a_tolerance_do_the_same() {
    for torque in [Torque::Ramp, Torque::Sine] {
        let right = torque.momentum(3.0);
        let mut solver = Solve::new(body(), torque, ExponentialSo3::new()).tolerance(1e-9);
        let found = solver.run(&rest(), 3.0).unwrap().state.momentum[0];
        assert!((found - right).abs() < 1e-8, "{torque:?}: {found}");
        let mut solver = Solve::in_lanes(body(), ByLane(torque), CayleySo3::new()).tolerance(1e-9);
        let found = solver.run(&rest(), 3.0).unwrap().state.momentum[0];
        assert!((found - right).abs() < 1e-8, "{torque:?}: {found}");
    }
}
