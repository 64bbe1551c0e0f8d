//! The doubled scheme, on the units and off them; trajectories; the adaptive comparator.

use crate::mechanics::{Sequence, U, close};
use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Matrix, Vector};
use euler_poincare::group::So3;
use euler_poincare::integrators::trajectory::integrate;
use euler_poincare::integrators::{
    Classical, Doubled, DoubledState, MuntheKaas, OneStep, Report, Solver, State, StepError, Variational,
};
use euler_poincare::mechanics::Lagrangian;
use euler_poincare::mechanics::doubled::{DoubledLagrangian, Forced, VelocityPoint};
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, Metriplectic, Periodic};
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Quartic};
use euler_poincare::mechanics::models::{Model, landau_lifshitz_gilbert, relaxed_rigid_body};
use euler_poincare::retraction::{CayleySo3, ExponentialSo3, Retraction};
use euler_poincare::scalar::Scalar;
use euler_poincare::tableau::Tableau;
use euler_poincare::tableau::families::Family;

fn of(family: Family, stages: usize) -> Tableau<f64> {
    family.tableau(stages).unwrap()
}

type PaperLagrangian = Forced<AnyLagrangian<f64, 3>, AnyForce<f64, 3>, CayleySo3<f64>>;
type Paper = Doubled<f64, PaperLagrangian, CayleySo3<f64>, 3, 3>;

fn paper(model: &Model<f64>, tableau: Tableau<f64>) -> Paper {
    let forced = Forced::new(model.system.lagrangian.clone(), model.system.force.clone(), CayleySo3::new());
    Doubled::new(tableau, CayleySo3::new(), forced)
}

// On SO(3) with Cayley's map. On random groups, retractions and systems, in 32 digits too, the laws `doubled-restriction`,
// `doubled-momentum-map` and `doubled-step-generated` say more.

#[test]
fn a_refused_doubled_step_leaves_the_state() {
    let model = landau_lifshitz_gilbert();
    let mut doubled = paper(&model, of(Family::Gauss, 2));
    let good = DoubledState::unit(0.0, model.momentum);
    let mut state = good.clone();
    assert_eq!(doubled.step(&mut state, f64::NAN), Err(StepError::NotFinite { what: "h" }));
    assert_eq!(state, good);
    state.mu[1] = f64::INFINITY;
    assert_eq!(doubled.step(&mut state, 0.1), Err(StepError::NotFinite { what: "the momentum" }));
    // A half turn has no preimage under Cayley's map.
    let mut state = good.clone();
    state.relative = Matrix::from_diagonal(&Vector::from([1.0, -1.0, -1.0]));
    assert!(matches!(doubled.step(&mut state, 0.1), Err(StepError::Domain { .. })));
    // Past the fold near h = 0.797.
    let mut state = good.clone();
    let refused = paper(&model, of(Family::LobattoIIIA, 2)).step(&mut state, 1.0);
    assert!(
        matches!(refused, Err(StepError::Fold { .. } | StepError::TooLong { .. } | StepError::NotConverged { .. })),
        "{refused:?}"
    );
    assert_eq!(state, good);
}

/// At h = 0 it is put together from second derivatives of the Lagrangian, else by dual numbers: with forces of every kind of dependence, off
/// the units. The modified Legendre transform is regular only while ½ f''(η) τ⁻¹(U) is small beside l'' ≥ 1, hence the sizes.
#[test]
fn the_jacobian_at_step_zero_is_the_limit_of_small_steps() {
    let (mut random, retraction) = (Sequence(11), CayleySo3::new());
    let b = random.matrix::<3>();
    let body: AnyLagrangian<f64, 3> = Quartic::new(b.transpose() * b + Matrix::identity(), 0.5).unwrap().into();
    let force = AnyForce::Sum(vec![
        LinearDrag::new(random.matrix() * 0.5).unwrap().into(),
        Metriplectic::new(LieAlgebra::from_catalogue(&Entry::So3).unwrap(), body.clone(), 0.3).unwrap().into(),
        Periodic::new(random.covector(), 1.5, 0.5).unwrap().into(),
    ]);
    let forced = Forced::new(body, force, retraction.clone());
    let u = retraction.tau(&(random.vector() * 0.1)).unwrap();
    let at = VelocityPoint { time: 0.0, eta: random.vector() * 0.5, u, psi: random.vector() * 0.5 };
    let partials = forced.partials(&at).unwrap();
    let state = DoubledState { time: 0.0, lambda: -partials.eta, relative: u, mu: partials.psi, attitudes: None };
    let mut doubled = Doubled::new(of(Family::LobattoIIIA, 2), retraction, forced);
    let (first, second) = ([random.vector(), random.vector()], [random.vector(), random.vector()]);
    let mut jacobian = |h: f64| doubled.stage_jacobian(&state, h, &first, &second).unwrap();
    let (zero, small) = (jacobian(0.0), jacobian(0.5f64.powi(30)));
    close((&zero - &small).amax(), 0.5f64.powi(24));
    assert!(zero.amax() > 0.5 && zero != small);
}

#[test]
fn a_jacobian_at_another_number_of_stages_is_refused() {
    let model = landau_lifshitz_gilbert();
    let rates = vec![Vector::from([1.0, 0.0, 1.0]); 3];
    let wrong = StepError::Stages { found: 3, needed: 2 };
    let unit = DoubledState::unit(0.0, model.momentum);
    let mut doubled = paper(&model, of(Family::Gauss, 2));
    assert_eq!(doubled.stage_jacobian(&unit, 0.1, &rates, &rates[..2]).unwrap_err(), wrong);
    assert_eq!(doubled.stage_jacobian(&unit, 0.1, &rates[..2], &rates[..2]).unwrap().nrows(), 12);
    let (l, f) = (&model.system.lagrangian, &model.system.force);
    let mut scheme = Variational::<f64, 3, 3, _, _, _>::new(l, f, CayleySo3::new(), of(Family::Gauss, 2));
    let start = State::at_identity(model.momentum);
    assert_eq!(scheme.stage_jacobian(&start, 0.1, &rates).unwrap_err(), wrong);
    // h → 0: blockdiag(l'', l'').
    let jacobian = scheme.stage_jacobian(&start, 0.0, &rates[..2]).unwrap();
    for (k, entry) in jacobian.diagonal().iter().enumerate() {
        assert_eq!(*entry, [0.5, 2.0, 1.0][k % 3]);
    }
}

struct Refusing(usize);

impl OneStep<f64, 3, 3> for Refusing {
    fn step(&mut self, state: &mut State<f64, 3, 3>, h: f64) -> Result<Report<f64>, StepError> {
        if self.0 == 0 {
            return Err(StepError::NotFinite { what: "the force" });
        }
        self.0 -= 1;
        state.time += h;
        let residual = 0.5 / (1.0 + self.0 as f64);
        Ok(Report { solver: Solver::Explicit, iterations: self.0, residual })
    }
}

#[test]
fn a_trajectory_counts_and_says_where_it_stopped() {
    let start = State { time: 1.0, momentum: Covector::zeros(), attitude: Matrix::identity() };
    let mut state = start.clone();
    let mut seen = Vec::new();
    let totals = integrate(&mut Refusing(4), &mut state, 0.1, 4, |k, state, _| seen.push((k, state.time))).unwrap();
    assert_eq!((totals.steps, totals.iterations, totals.most_iterations, totals.residual), (4, 6, 3, 0.5));
    assert_eq!(seen, (1..=4).map(|k| (k, 1.0 + 0.1 * k as f64)).collect::<Vec<_>>());
    let mut state = start.clone();
    let stopped = integrate(&mut Refusing(2), &mut state, 0.5, 4, |_, _, _| ()).unwrap_err();
    assert_eq!((stopped.index, stopped.time), (2, 2.0));
    assert_eq!(stopped.source, StepError::NotFinite { what: "the force" });
}

/// The stages of the comparators are found by fixed-point iteration: a step too long for that is refused, and every step
/// that is not has stages that repeat themselves to rounding.
#[test]
fn the_comparators_return_only_what_converged() {
    let mut refused = [0, 0];
    for model in [landau_lifshitz_gilbert::<f64>(), relaxed_rigid_body::<f64>()] {
        let gauss = || of(Family::Gauss, 2);
        let mut munthe_kaas = MuntheKaas::new(model.system.clone(), ExponentialSo3::new(), gauss());
        let mut classical = Classical::new(model.system.clone(), Some(So3::new()), gauss());
        let start = State::at_identity(model.momentum);
        for h in (1..=40).map(|k| 0.25 * f64::from(k)) {
            let (mut one, mut two) = (start.clone(), start.clone());
            for (k, found) in [munthe_kaas.step(&mut one, h), classical.step(&mut two, h)].into_iter().enumerate() {
                match found {
                    Ok(report) => assert!(report.residual < 4096.0 * U, "h = {h}: {report:?}"),
                    Err(_) => refused[k] += 1,
                }
            }
        }
    }
    assert!(refused.iter().all(|&count| (8..=72).contains(&count)), "{refused:?} of 80");
}

#[test]
fn the_adaptive_pair_reaches_the_reference() {
    use euler_poincare::integrators::comparators::{AdaptiveError, dormand_prince};
    for model in [landau_lifshitz_gilbert::<f64>(), relaxed_rigid_body::<f64>()] {
        let times: Vec<f64> = (0..=8).map(|k| k as f64 / 8.0).collect();
        let error = |tolerance| {
            let samples = dormand_prince(&model.system, &model.momentum, &times, tolerance).unwrap();
            assert_eq!(samples.iter().map(|s| s.0).collect::<Vec<_>>(), times);
            assert_eq!(samples[0].1, model.momentum);
            (samples[8].1 - model.reference_momentum().unwrap()).norm()
        };
        // Local errors are held to the tolerance; over a unit of time they gather to a small multiple.
        close(error(1e-6), 1e-4);
        close(error(1e-11), 1e-9);
    }
    let model = landau_lifshitz_gilbert::<f64>();
    let bad = |times: &[f64], tolerance| {
        matches!(dormand_prince(&model.system, &model.momentum, times, tolerance), Err(AdaptiveError::BadInput { .. }))
    };
    assert!(bad(&[0.0], 1e-6) && bad(&[0.0, f64::NAN], 1e-6) && bad(&[0.0, 0.0], 1e-6));
    assert!(bad(&[0.0, 1.0], 0.0) && bad(&[0.0, 1.0], f64::NAN));
}

/// The inverse Legendre transform of a bounded gradient fails on the way, and that is what is reported.
#[test]
fn the_adaptive_pair_reports_a_failing_legendre_transform() {
    use euler_poincare::integrators::comparators::{AdaptiveError, dormand_prince};
    use euler_poincare::mechanics::equations::EulerPoincare;
    use euler_poincare::mechanics::force::Constant;

    struct Bounded;
    impl Lagrangian<f64, 1> for Bounded {
        fn value<S: Scalar<Base = f64>>(&self, eta: &Vector<S, 1>) -> S {
            (S::one() + eta[0] * eta[0]).sqrt()
        }
    }
    let line = LieAlgebra::<f64, 1>::from_catalogue(&Entry::Abelian(1)).unwrap();
    let system = EulerPoincare::new(line, Bounded, Constant::new(Covector::from([1.0])).unwrap());
    let failed = dormand_prince(&system, &Covector::from([0.0]), &[0.0, 2.0], 1e-6);
    assert!(matches!(failed, Err(AdaptiveError::Legendre { time, .. }) if time >= 0.99), "{failed:?}");
}
