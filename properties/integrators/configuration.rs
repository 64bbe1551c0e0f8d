//! Potentials and forces that depend on the configuration: other methods, refusals, rest, and the energy errors of the heavy top of the specification.
//! The laws of `laws::configuration` judge random systems; `systems/precise.rs` has reference values of the heavy top.

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, LieAlgebra, Matrix, Vector};
use euler_poincare::group::So3;
use euler_poincare::group::so3::hat;
use euler_poincare::integrators::advected::{
    Advected, AdvectedLagrangian, AdvectedState, Representation, RepresentationError,
};
use euler_poincare::integrators::doubled::DoubledState;
use euler_poincare::integrators::{Classical, Doubled, MuntheKaas, OneStep, State, StepError, Variational};
use euler_poincare::mechanics::configuration::{
    AtPoint, Configuration, ForceOnGroup, InSpace, LagrangianOn, LagrangianOnGroup, OnGroup, Potential, WithPotential,
};
use euler_poincare::mechanics::doubled::Forced;
use euler_poincare::mechanics::equations::EulerPoincare;
use euler_poincare::mechanics::force::{BlackBox, Constant, LinearDrag};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::{Force, Lagrangian};
use euler_poincare::retraction::{CayleySo3, Exponential, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Real, Scalar};
use euler_poincare::tableau::{Classic, Family, Tableau};

/// V = m g₀ ⟨e₃, g r⟩ with r = (3, −2, 5)/10 and m g₀ = 13/10.
#[derive(Clone, Copy)]
struct Weight;

impl<T: Real> Potential<T, 3> for Weight {
    fn value<S: Scalar<Base = T>>(&self, _: S, g: &Matrix<S, 3>) -> S {
        let height = g[(2, 0)] * S::int(3) - g[(2, 1)] * S::int(2) + g[(2, 2)] * S::int(5);
        height * S::ratio(13, 100)
    }
}

fn body<T: Real>() -> Quadratic<T, 3> {
    Quadratic::diagonal([T::half(), T::int(2), T::one()]).unwrap()
}

fn drag<T: Real>() -> LinearDrag<T, 3> {
    let tenths = Vector::<T, 3>::new(T::ratio(1, 10), T::ratio(3, 10), T::ratio(2, 10));
    LinearDrag::new(Matrix::<T, 3>::from_diagonal(&tenths)).unwrap()
}

fn top<T: Real>() -> WithPotential<Quadratic<T, 3>, Weight, So3<T>, 3> {
    WithPotential::new(body(), Weight, So3::new())
}

/// Its start: g₀ = exp(0.4, −0.3, 0.2), μ₀ = (0.5, 0.3, 0.9).
fn start<T: Real>() -> State<T, 3, 3> {
    let x = Vector::<T, 3>::new(T::ratio(4, 10), T::ratio(-3, 10), T::ratio(2, 10));
    let momentum = Covector::<T, 3>::new(T::ratio(5, 10), T::ratio(3, 10), T::ratio(9, 10));
    State { time: T::zero(), momentum, attitude: ExponentialSo3::new().tau(&x).unwrap() }
}

fn gauss<T: Real>(stages: usize) -> Tableau<T> {
    Family::Gauss.tableau(stages).unwrap()
}

fn rk4() -> Tableau<f64> {
    Classic::Rk4.tableau().unwrap()
}

fn so3() -> LieAlgebra<f64, 3> {
    LieAlgebra::from_catalogue(&Entry::So3).unwrap()
}

fn run<T: Real>(method: &mut impl OneStep<T, 3, 3>, h: T, steps: usize) -> State<T, 3, 3> {
    let mut state = start();
    for _ in 0..steps {
        method.step(&mut state, h).unwrap();
    }
    state
}

fn gap<T: Real>(a: &State<T, 3, 3>, b: &State<T, 3, 3>) -> (f64, f64) {
    ((a.momentum - b.momentum).amax().to_f64(), (a.attitude - b.attitude).amax().to_f64())
}

#[test]
fn implicit_comparators_come_to_rest() {
    let system = || EulerPoincare::new(so3(), top(), drag());
    let mut munthe_kaas = MuntheKaas::new(system(), CayleySo3::new(), gauss(2));
    let mut classical = Classical::new(system(), Some(So3::new()), gauss(2));
    let rest = [run(&mut munthe_kaas, 0.125, 9600), run(&mut classical, 0.125, 9600)];
    for state in rest {
        assert!(state.momentum.amax() < 1e-14, "{}", state.momentum);
    }
}

/// Forces on the group, of one type: a step is compiled for each.
#[derive(Clone, Copy, PartialEq)]
enum On {
    /// The drag of [`drag`], a spatial torque with cos t, and a term in the body that mixes g and η.
    Mixed,
    /// None.
    Nothing,
    /// Proportional-derivative control of the attitude, against the weight: at rest their torques cancel.
    Controller,
}

impl<T: Real> ForceOnGroup<T, 3, 3> for On {
    fn force<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, 3>, eta: &Vector<S, 3>) -> Covector<S, 3> {
        if *self == On::Nothing {
            return Covector::zeros();
        }
        if *self == On::Controller {
            let error = Vector::<S, 3>::new(g[(2, 1)] - g[(1, 2)], g[(0, 2)] - g[(2, 0)], g[(1, 0)] - g[(0, 1)]);
            return -(error * S::int(2) + eta * S::int(3)).transpose();
        }
        let drag = drag::<T>().force(t, eta);
        let torque = Vector::<S, 3>::new(t.cos() * S::ratio(1, 5), S::zero(), S::ratio(-1, 10));
        let mixed = Vector::<S, 3>::new(g[(2, 1)] * eta[2], -g[(2, 0)] * eta[0], g[(0, 0)] * eta[1]) * S::ratio(1, 4);
        drag + (g.transpose() * torque + mixed).transpose()
    }
}

#[test]
fn other_methods_converge_to_the_same_run() {
    let exact =
        run(&mut Variational::new(top::<f64>(), OnGroup(On::Mixed), ExponentialSo3::new(), gauss(4)), 0.0625, 16);
    let system = || EulerPoincare::new(so3(), top(), OnGroup(On::Mixed));
    let mut rkmk = MuntheKaas::new(system(), ExponentialSo3::new(), rk4());
    let mut matrices = Classical::new(system(), Some(So3::new()), rk4());
    let (one, other) =
        (gap(&run(&mut rkmk, 1.0 / 256.0, 256), &exact), gap(&run(&mut matrices, 1.0 / 256.0, 256), &exact));
    assert!(one.0.max(one.1).max(other.0).max(other.1) < 1e-9, "{one:?} {other:?}");
    // Without the group there is nothing to evaluate the forces at.
    let mut without = Classical::<f64, 3, 3, _, _, So3<f64>>::new(system(), None, rk4());
    assert!(matches!(without.step(&mut start(), 0.1), Err(StepError::Unsupported { .. })));
    let mut blind =
        Variational::new(top::<f64>(), drag(), Exponential::<f64, 3, 3, So3<f64>>::of_algebra(so3()), gauss(2));
    assert!(matches!(blind.step(&mut start(), 0.1), Err(StepError::Domain { .. })));
}

/// The largest energy errors in the first and in the last quarter of 2000 steps of a fifth.
fn energy_errors(method: &mut impl OneStep<f64, 3, 3>, mut watch: impl FnMut(&State<f64, 3, 3>)) -> [f64; 2] {
    let energy = |state: &State<f64, 3, 3>| {
        let eta = body().velocity(&state.momentum, &Vector::zeros()).unwrap();
        top::<f64>().energy_at(0.0, Configuration::of(&state.attitude), &eta)
    };
    let (mut state, mut worst) = (start::<f64>(), [0.0_f64; 4]);
    let full = energy(&state);
    for step in 0..2000 {
        method.step(&mut state, 0.2).unwrap();
        watch(&state);
        let quarter = &mut worst[step / 500];
        *quarter = quarter.max((energy(&state) - full).abs());
    }
    [worst[0], worst[3]]
}

#[test]
fn a_heavy_top_keeps_its_vertical_momentum_and_its_energy_does_not_drift() {
    let mut method = Variational::new(top::<f64>(), OnGroup(On::Nothing), ExponentialSo3::new(), gauss(2));
    let vertical = |state: &State<f64, 3, 3>| (state.attitude * state.momentum.transpose())[2];
    let before = vertical(&start());
    let [first, last] = energy_errors(&mut method, |state| assert!((vertical(state) - before).abs() < 2e-14));
    // The motion is chaotic: of 60 starts that differ by rounding alone, the last is 0.14 to 1.16 of the first, which is the same for all.
    assert!((first - 6.3e-5).abs() < 1e-6 && last < 1.5 * first, "{first:e} {last:e}");
    // A method of the same order that is not variational drifts: of 9 such starts, by 3.0 to 4.1 times its first error.
    let system = EulerPoincare::new(so3(), top(), OnGroup(On::Nothing));
    let [first, last] = energy_errors(&mut MuntheKaas::new(system, ExponentialSo3::new(), rk4()), |_| ());
    assert!((first - 6.72e-3).abs() < 1e-4 && last > 2.0 * first, "{first:e} {last:e}");
}

#[test]
fn the_doubled_scheme_refuses_what_depends_on_the_configuration() {
    fn refuses(lagrangian: impl Lagrangian<f64, 3>, force: impl Force<f64, 3>) -> bool {
        let forced = Forced::new(lagrangian, force, CayleySo3::new());
        let mut method = Doubled::new(gauss(1), CayleySo3::new(), forced);
        let found = method.step(&mut DoubledState::unit(0.0, start::<f64>().momentum), 0.1);
        matches!(found, Err(StepError::Unsupported { .. }))
    }
    assert!(!refuses(body(), drag()));
    assert!(refuses(body(), OnGroup(On::Mixed)) && refuses(top(), drag()));
}

/// ½ ηᵀ I η − V by its value alone.
struct ByValue;

impl<T: Real> LagrangianOnGroup<T, 3, 3> for ByValue {
    fn value<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, 3>, eta: &Vector<S, 3>) -> S {
        body::<T>().value(eta) - Weight.value(t, g)
    }
}

/// The torque of [`On::Mixed`] that is given in space, alone.
struct Torque;

impl<T: Real> ForceOnGroup<T, 3, 3> for Torque {
    fn force<S: Scalar<Base = T>>(&self, t: S, _: &Matrix<S, 3>, _: &Vector<S, 3>) -> Covector<S, 3> {
        Covector::<S, 3>::new(t.cos() * S::ratio(1, 5), S::zero(), S::ratio(-1, 10))
    }
}

/// The top with Γ = gᵀ e₃ as a parameter.
struct Reduced;

impl<T: Real> AdvectedLagrangian<T, 3, 3> for Reduced {
    fn value<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, 3>, gamma: &Vector<S, 3>) -> S {
        let height = gamma[0] * S::int(3) - gamma[1] * S::int(2) + gamma[2] * S::int(5);
        body::<T>().value(eta) - height * S::ratio(13, 100)
    }
}

/// The law `configuration-advected` compares its steps with those of (μ, g).
#[test]
fn a_reduced_step_that_cannot_be_taken_is_refused() {
    let axes = [Vector::<f64, 3>::x(), Vector::<f64, 3>::y(), Vector::<f64, 3>::z()];
    let vectors = |scale: f64| Representation::new(so3(), axes.map(|axis| hat(&axis) * scale));
    let at = |parameter| AdvectedState { time: 0.0, momentum: start::<f64>().momentum, parameter };
    let mut reduced = Advected::new(Reduced, drag(), vectors(1.0).unwrap(), gauss(2));
    reduced.step(&mut at(Vector::<f64, 3>::z()), 0.1).unwrap();
    let refused = reduced.step(&mut at(Vector::from_element(f64::NAN)), 0.1);
    assert!(matches!(refused, Err(StepError::NotFinite { .. })));
    let mut led = Advected::new(Reduced, OnGroup(On::Mixed), vectors(1.0).unwrap(), gauss(2));
    assert!(matches!(led.step(&mut at(Vector::<f64, 3>::z()), 0.1), Err(StepError::Unsupported { .. })));
    assert!(matches!(vectors(2.0), Err(RepresentationError::NotAHomomorphism { a: 1, b: 2, .. })));
}

#[test]
fn one_system_written_in_several_ways_moves_in_one_way() {
    fn go(l: impl Lagrangian<f64, 3>, f: impl Force<f64, 3>) -> State<f64, 3, 3> {
        run(&mut Variational::new(l, f, ExponentialSo3::new(), gauss(2)), 0.25, 8)
    }
    let one = go(top(), InSpace::new(Torque, So3::new()));
    // A Lagrangian by its value, a force on the group, and closures.
    let closure = BlackBox::on_group(|t: f64, g: &Matrix<f64, 3>, _: &Vector<f64, 3>| {
        (g.transpose() * Vector::<f64, 3>::new(t.cos() / 5.0, 0.0, -0.1)).transpose()
    });
    let weight = BlackBox::on_group(|_: f64, g: &Matrix<f64, 3>, _: &Vector<f64, 3>| {
        let up = g.transpose() * Vector::<f64, 3>::z();
        (Vector::<f64, 3>::new(0.3, -0.2, 0.5).cross(&up) * -1.3).transpose()
    });
    let load = Constant::new(Covector::<f64, 3>::new(0.0, 0.0, -1.3)).unwrap();
    let load = AtPoint::in_space(load, Vector::<f64, 3>::new(0.3, -0.2, 0.5), &So3::new());
    let others = [
        go(LagrangianOn::new(ByValue, So3::new()), closure),
        go(body(), (&closure, weight)),
        go(body(), (&closure, load)),
    ];
    for other in others {
        let (momentum, attitude) = gap(&one, &other);
        assert!(momentum < 1e-14 && attitude < 1e-14, "{momentum:e} {attitude:e}");
    }
    // Newton's method, which needs derivatives of closures, takes a step that fixed-point iterations cannot.
    let stiff = BlackBox::new(|_: f64, eta: &Vector<f64, 3>| -40.0 * eta.transpose());
    let mut method = Variational::new(body(), stiff, ExponentialSo3::new(), gauss(2));
    let report = method.step(&mut start(), 0.5).unwrap();
    assert_ne!(report.solver, euler_poincare::integrators::Solver::FixedPoint);
}

#[test]
fn a_body_comes_to_rest_where_forces_cancel() {
    let mut method = Variational::new(top::<f64>(), OnGroup(On::Controller), ExponentialSo3::new(), gauss(2));
    let state = run(&mut method, 0.05, 4000);
    assert!(state.momentum.amax() < 1e-15, "{}", state.momentum);
}
