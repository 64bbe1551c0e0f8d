//! Properties of `euler_poincare::discrete`: what the laws do not ask of random systems. They judge the slopes of actions, of smooth Lagrangians
//! (`discrete-euler-lagrange`) and of sampled ones (`discrete-lie-poisson`).

use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::discrete::exact::{ExactError, ExactSolution, Start};
use euler_poincare::discrete::legendre::{euler_lagrange, flow, flow_from, legendre_minus_inverse};
use euler_poincare::discrete::{
    DiscreteError, DiscreteLagrangian, Smooth, SmoothLagrangian, StageLagrangian, Triple, group, legendre_minus,
};
use euler_poincare::group::So3;
use euler_poincare::mechanics::Force;
use euler_poincare::mechanics::doubled::Forced;
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, Periodic};
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Quadratic};
use euler_poincare::mechanics::models::landau_lifshitz_gilbert;
use euler_poincare::retraction::{CayleySo3, ExponentialSo3, Retraction, RetractionError};
use euler_poincare::scalar::{Dd, Number, Real, Scalar};
use euler_poincare::tableau::{Description, Tableau};
use nalgebra::ComplexField;
use std::sync::atomic::{AtomicUsize, Ordering};

type Llg<T> = Forced<AnyLagrangian<T, 3>, AnyForce<T, 3>, CayleySo3<T>>;

fn tableau<T: Real>(name: &str) -> Tableau<T> {
    let description: Description = name.parse().expect("the name of a tableau");
    description.build().expect("a tableau")
}

/// Landau–Lifshitz–Gilbert damping with the Cayley map.
fn damped<T: Real>() -> Llg<T> {
    let model = landau_lifshitz_gilbert::<T>();
    Forced::new(model.system.lagrangian, model.system.force, CayleySo3::new())
}

fn damped_action(name: &str, h: f64) -> StageLagrangian<f64, Llg<f64>, CayleySo3<f64>, 3, 3> {
    StageLagrangian::new(damped(), CayleySo3::new(), tableau(name), h)
}

fn rotation(x: [f64; 3]) -> Matrix<f64, 3> {
    CayleySo3::new().tau(&Vector::from(x)).expect("in the domain")
}

/// A step off the units.
fn off_units() -> Triple<f64, 3> {
    Triple { v: rotation([0.05, 0.01, 0.09]), u: rotation([0.03, -0.02, 0.01]), w: rotation([0.07, 0.02, 0.08]) }
}

#[test]
fn the_stages_meet_their_constraints_and_a_guess_saves_iterations() {
    let l_d = damped_action("gauss-3", 0.125);
    let (v, w) = (Vector::<f64, 3>::new(0.05, 0.01, 0.09), Vector::<f64, 3>::new(0.07, 0.02, 0.08));
    let u = rotation([0.03, -0.02, 0.01]);
    let extremal = l_d.extremise(&v, &u, &w, None).expect("an extremum");
    let b = tableau::<f64>("gauss-3");
    let sum = |rates: &[Vector<f64, 3>]| {
        rates.iter().zip(b.b().iter()).fold(Vector::<f64, 3>::zeros(), |sum, (rate, b)| sum + rate * *b) * 0.125
    };
    assert!((sum(&extremal.first) - v).amax() < 1e-16 && (sum(&extremal.second) - w).amax() < 1e-16);
    assert!(extremal.residual < 1e-14);
    let nearby = v + Vector::<f64, 3>::repeat(1e-6);
    let (cold, warm) = (l_d.extremise(&nearby, &u, &w, None), l_d.extremise(&nearby, &u, &w, Some(&extremal)));
    let (cold, warm) = (cold.expect("an extremum"), warm.expect("an extremum"));
    assert!(warm.iterations < cold.iterations, "{} and {}", warm.iterations, cold.iterations);
    assert!((cold.theta - warm.theta).amax() < 1e-13 && (cold.phi - warm.phi).amax() < 1e-13);
    // From the stages alone: the multipliers are those of the first of them.
    let tau = CayleySo3::new();
    let x = Triple { v: tau.tau(&v).expect("everywhere"), u, w: tau.tau(&w).expect("everywhere") };
    let near = l_d.near(&x, &extremal.first, &extremal.second).expect("an extremum");
    assert!(near.iterations < cold.iterations && (near.theta - extremal.theta).amax() < 1e-13, "{near:?}");
    // Of another number they are no guess.
    let far = l_d.near(&x, &extremal.first[1..], &extremal.second).expect("an extremum");
    assert!((far.theta - extremal.theta).amax() < 1e-13);
    // A guess from another tableau is not one.
    let other = damped_action("gauss-2", 0.125).extremise(&v, &u, &w, Some(&extremal)).expect("an extremum");
    assert_eq!(other.first.len(), 2);
}

/// Where l_d changes, as of a load that depends on time: here the step does.
#[test]
fn the_flow_goes_from_one_lagrangian_to_another() {
    let (tau, x) = (CayleySo3::new(), off_units());
    let (a, b) = (damped_action("gauss-2", 0.125), damped_action("gauss-2", 0.1));
    let (same, other) = (flow(&a, &a, &tau, &x).expect("a step"), flow(&a, &b, &tau, &x).expect("a step"));
    assert!((other.v - same.v).amax() > 1e-3);
    let (lambda, mu) = euler_lagrange((&a, &x), (&b, &other)).expect("slopes");
    assert!(lambda.amax() < 1e-12 && mu.amax() < 1e-12 && other.u == same.u);
    let near = flow_from(&a, &b, &tau, &x, &mut None).expect("a step");
    assert!((near.v - other.v).amax() < 1e-12 && (near.w - other.w).amax() < 1e-12 && near.u == other.u);
}

/// l_d(V, U, W) = Σ W_ij: F⁻ cannot be inverted where it does not depend on V.
struct Flat;

impl SmoothLagrangian<f64, 3> for Flat {
    fn value<S: Scalar<Base = f64>>(&self, x: &Triple<S, 3>) -> Result<S, RetractionError> {
        Ok(x.w.iter().fold(S::zero(), |sum, v| sum + *v))
    }
}

#[test]
fn what_cannot_be_evaluated_is_an_error() {
    let (tau, so3) = (CayleySo3::new(), So3::new());
    let l_d = damped_action("gauss-2", 0.125);
    let x = off_units();
    let half_turn = Matrix::<f64, 3>::from_diagonal(&Vector::<f64, 3>::new(1.0, -1.0, -1.0));
    assert!(matches!(l_d.slopes(&Triple { v: half_turn, ..x }), Err(DiscreteError::Domain { what: "V", .. })));
    assert!(matches!(l_d.value(&Triple { u: half_turn, ..x }), Err(DiscreteError::Domain { .. })));
    let nan = x.u * f64::NAN;
    assert!(matches!(l_d.value(&Triple { u: nan, ..x }), Err(DiscreteError::NotFinite { what: "U" })));
    assert!(l_d.value(&Triple { w: nan, ..x }).is_err());
    assert!(matches!(damped_action("gauss-2", 0.0).value(&x), Err(DiscreteError::NotFinite { .. })));
    assert!(matches!(damped_action("gauss-2", f64::NAN).value(&x), Err(DiscreteError::NotFinite { .. })));
    // A step far too long for its stages: an error, or at least a number.
    let far = Triple { v: rotation([40.0, -9.0, 3.0]), ..x };
    assert!(damped_action("lobatto-iiia-3", 30.0).value(&far).map_or(true, f64::is_finite));
    let singular = Triple { v: Matrix::<f64, 3>::zeros(), ..x };
    assert_eq!(singular.next_u(), None);
    let flat = Smooth::new(Flat, &so3);
    let momenta = legendre_minus(&l_d, &x).expect("F⁻");
    let refused = legendre_minus_inverse(&flat, &tau, &momenta, &x, &mut ());
    assert!(matches!(refused, Err(DiscreteError::Singular { .. } | DiscreteError::NotConverged { .. })), "{refused:?}");
}

#[test]
fn the_exact_solution_on_the_units_is_the_reference_of_the_damped_body() {
    let exact = ExactSolution::new(damped::<Dd>(), CayleySo3::new(), 10).unwrap();
    let half = Dd::ratio(1, 2);
    let omega = Vector::<Dd, 3>::new(half.sqrt(), Dd::int(0), half.sqrt());
    let start = Start { time: Dd::int(0), eta: omega, u: Matrix::identity(), psi: omega };
    let times: Vec<Dd> = (1..=8).map(|k| Dd::ratio(k, 8)).collect();
    let last = exact.at(&start, &times).unwrap().pop().unwrap();
    // M(1) to 22 digits, from 150-bit runs.
    let reference = ["0.2414593544179368885463", "0.2537142183692990580699", "0.7087499386676014196337"];
    let momentum = Quadratic::<Dd, 3>::diagonal([half, Dd::int(2), Dd::int(1)]).unwrap().inertia() * last.point.eta;
    for (found, expected) in momentum.iter().zip(reference) {
        let expected: Dd = expected.parse::<Number>().unwrap().eval().unwrap();
        assert!((*found - expected).abs().to_f64() < 1e-21, "{found:?}");
    }
    assert!((last.point.u - Matrix::identity()).amax().to_f64() < 1e-30);
    assert!(last.action.abs().to_f64() < 1e-30);
}

/// In one step or in four, with a load that varies in time and from a start away from t = 0.
#[test]
fn the_exact_solution_is_the_same_in_fewer_steps() {
    let body: AnyLagrangian<f64, 3> = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap().into();
    let load: AnyForce<f64, 3> = Periodic::new(Covector::from([0.3, -0.2, 0.4]), 2.0, 0.3).unwrap().into();
    let exact = ExactSolution::new(Forced::new(body, load, CayleySo3::new()), CayleySo3::new(), 10).unwrap();
    let (eta, psi) = (Vector::from([0.7, -0.3, 0.5]), Vector::from([0.2, 0.6, -0.4]));
    let start = Start { time: 0.75, eta, u: rotation([0.1, 0.0, 0.0]), psi };
    let once = exact.at(&start, &[0.5]).unwrap().pop().unwrap();
    let four = exact.at(&start, &[0.125, 0.25, 0.375, 0.5]).unwrap().pop().unwrap();
    let ends = (once.point, four.point);
    let off = (ends.0.eta - ends.1.eta).amax().max((ends.0.psi - ends.1.psi).amax());
    assert!(off < 1e-14, "{once:?} {four:?}");
    assert!((once.v - four.v).amax() < 1e-14 && (once.w - four.w).amax() < 1e-14, "{once:?} {four:?}");
    assert!((once.action - four.action).abs() < 1e-14, "{once:?} {four:?}");
}

#[test]
fn an_exact_solution_that_cannot_be_followed_is_an_error() {
    let exact = ExactSolution::new(damped::<f64>(), CayleySo3::new(), 4).unwrap();
    let (eta, psi) = (Vector::from([0.7, -0.3, 0.5]), Vector::from([0.2, 0.6, -0.4]));
    let start = Start { time: 0.0, eta, u: rotation([0.1, 0.0, 0.0]), psi };
    let far = exact.at(&start, &[1e6]);
    assert!(matches!(far, Err(ExactError::NotConverged { .. } | ExactError::Equations { .. })), "{far:?}");
    let nowhere = exact.at(&Start { eta: Vector::from([f64::NAN, 0.0, 0.0]), ..start }, &[0.1]);
    assert!(nowhere.is_err(), "{nowhere:?}");
    let none = ExactSolution::<f64, 3, 3, _, _>::new(damped::<f64>(), CayleySo3::new(), 0);
    assert!(matches!(none, Err(ExactError::Tableau(_))), "{none:?}");
}

/// A torque of size 1 that is another one each time.
struct Restless(AtomicUsize);

impl Force<f64, 3> for Restless {
    fn force<S: Scalar<Base = f64>>(&self, _: S, _: &Vector<S, 3>) -> Covector<S, 3> {
        let k = self.0.fetch_add(1, Ordering::Relaxed);
        Covector::from_fn(|_, a| S::int(((k * 7919 + a * 104_729) % 101) as i64 - 50) / S::int(50))
    }
}

/// The change that is reported is relative: of 10³ in size, velocities that jump by the step move by its 10⁻³.
#[test]
fn what_does_not_settle_is_told_relative_to_its_size() {
    let sphere = Quadratic::<f64, 3>::diagonal([1.0; 3]).unwrap();
    let restless = Forced::new(sphere, Restless(AtomicUsize::new(0)), CayleySo3::new());
    let exact = ExactSolution::new(restless, CayleySo3::new(), 2).unwrap();
    let fast = Vector::from([1e3, 0.0, 0.0]);
    let start = Start { time: 0.0, eta: fast, u: Matrix::identity(), psi: fast };
    let step = 2f64.powi(-10);
    match exact.at(&start, &[step]) {
        Err(ExactError::NotConverged { step: found, change, iterations }) => {
            assert_eq!((found, iterations), (step, 200));
            // η̇ = f, at most 1 in size: η changes by at most 2h, and less than 10⁻³ of that is no coincidence any more.
            assert!((1e-9..=4e-3 * step).contains(&change), "{change:e}");
        }
        other => panic!("{other:?}"),
    }
}

/// Whatever the start: the action of a heavy body is rounded by more than its velocities, which keeps the stages moving, and
/// they count as found.
#[test]
fn the_exact_solution_settles_from_every_start() {
    let body: AnyLagrangian<f64, 3> = Quadratic::diagonal([500.0, 2000.0, 1000.0]).unwrap().into();
    let drag: AnyForce<f64, 3> = LinearDrag::new(Matrix::<f64, 3>::identity() * 250.0).unwrap().into();
    let exact = ExactSolution::new(Forced::new(body, drag, CayleySo3::new()), CayleySo3::new(), 6).unwrap();
    for k in 0..60 {
        let part = |phase: f64| (f64::from(k) * phase).sin();
        let start = Start {
            time: 0.0,
            eta: Vector::from([part(0.9), part(1.7), part(2.3)]),
            u: rotation([0.1 * part(3.1), 0.1 * part(3.7), 0.1 * part(4.3)]),
            psi: Vector::from([part(1.1), part(1.3), part(2.9)]),
        };
        for (speed, step) in [(1.0, 0.5), (2.0, 0.25), (4.0, 0.125)] {
            let start = Start { eta: start.eta * speed, psi: start.psi * speed, ..start };
            let found = exact.at(&start, &[step]);
            assert!(found.is_ok(), "{k}, {speed}: {found:?}");
        }
    }
}

/// A displacement of any size is found to the rounding of a group element, which has size 1. One rounding u of it changes the momentum by
/// |I| u/h, with |I| = 2; 256 of them are allowed.
#[test]
fn a_step_of_any_size_is_solved_to_rounding() {
    let (so3, tau) = (So3::new(), ExponentialSo3::new());
    let inertia = Quadratic::<f64, 3>::diagonal([0.5, 2.0, 1.0]).unwrap();
    for k in 0..24 {
        let h = 2f64.powi(-k);
        let l_d = group::Sampled::<f64, _, _, 3> { lagrangian: &inertia, retraction: tau.clone(), step: h };
        for j in 0..8 {
            let part = |phase: f64| (f64::from(j + 1) * phase).sin();
            let w = tau.tau(&(Vector::<f64, 3>::new(part(0.9), part(1.7), part(2.3)) * (0.3 * h))).unwrap();
            let next = group::flow(&l_d, &so3, &tau, &w).unwrap_or_else(|e| panic!("h = {h:e}, start {j}: {e}"));
            let off = group::euler_poincare(&l_d, &so3, &w, &next).unwrap().amax();
            assert!(off <= 256.0 * f64::EPSILON / h, "h = {h:e}, start {j}: {off:e}");
        }
    }
}
