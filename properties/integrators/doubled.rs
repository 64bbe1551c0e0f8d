//! The doubled scheme, on the units and off them; trajectories; the adaptive comparator.

use crate::mechanics::{Sequence, U, close, size};
use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Matrix, Vector};
use euler_poincare::group::So3;
use euler_poincare::integrators::trajectory::integrate;
use euler_poincare::integrators::{
    Classical, Doubled, DoubledState, MuntheKaas, OneStep, State, StepError, Variational,
};
use euler_poincare::mechanics::Lagrangian;
use euler_poincare::mechanics::doubled::{DoubledLagrangian, Forced};
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, Metriplectic, Periodic};
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Quadratic, Quartic};
use euler_poincare::mechanics::models::{Model, landau_lifshitz_gilbert, relaxed_rigid_body};
use euler_poincare::retraction::{CayleySo3, ExponentialSo3, Retraction, TangentPoint};
use euler_poincare::scalar::{Dual, Scalar};
use euler_poincare::tableau::Tableau;
use euler_poincare::tableau::families::{Classic, Family};

fn of(family: Family, stages: usize) -> Tableau<f64> {
    family.tableau(stages).unwrap()
}

type PaperLagrangian = Forced<AnyLagrangian<f64, 3>, AnyForce<f64, 3>, CayleySo3<f64>>;
type Paper = Doubled<f64, PaperLagrangian, CayleySo3<f64>, 3, 3>;

fn paper(model: &Model<f64>, tableau: Tableau<f64>) -> Paper {
    let forced = Forced::new(model.system.lagrangian.clone(), model.system.force.clone(), CayleySo3::new());
    Doubled::new(tableau, CayleySo3::new(), forced)
}

/// One step of 1/8, computed in 150-bit arithmetic.
#[test]
fn on_the_units_one_step_of_the_papers_systems_is_the_reference() {
    let (llg, relaxed) = (landau_lifshitz_gilbert(), relaxed_rigid_body());
    let rows = [
        (&llg, Family::Gauss, 1, [0.3325523603683159, 0.0312710753139576, 0.7165415190785951]),
        (&llg, Family::Gauss, 2, [0.3325020802648156, 0.0313526763021243, 0.7165607981817258]),
        (&llg, Family::LobattoIIIA, 3, [0.3325020242605735, 0.0313527332683193, 0.7165608236605989]),
        (&llg, Family::LobattoIIIB, 3, [0.3325021449851981, 0.0313526299631130, 0.7165607678834958]),
        (&relaxed, Family::Gauss, 2, [0.3520359408350419, 0.0313280374056840, 0.7082730193270272]),
    ];
    for (model, family, stages, expected) in rows {
        let mut state = DoubledState::unit(0.0, model.momentum);
        paper(model, of(family, stages)).step(&mut state, 0.125).unwrap();
        close(size(&(state.mu - Covector::from(expected))), 1e-15);
        close(size(&(state.lambda - state.mu)), 16.0 * U);
        close(size(&(state.relative - Matrix::<f64, 3>::identity())), 16.0 * U);
    }
}

// On SO(3) with Cayley's map. On random groups, retractions and systems, in 32 digits too, the laws `doubled-restriction`,
// `doubled-momentum-map` and `doubled-step-generated` say more.

/// A random forced system, with forces of every kind of dependence.
fn system(random: &mut Sequence) -> (AnyLagrangian<f64, 3>, AnyForce<f64, 3>) {
    let b = random.matrix::<3>();
    let inertia = b.transpose() * b + Matrix::identity();
    let body: AnyLagrangian<f64, 3> = if random.next() > 0.0 {
        Quadratic::new(inertia).unwrap().into()
    } else {
        Quartic::new(inertia, 0.5).unwrap().into()
    };
    let force = AnyForce::Sum(vec![
        LinearDrag::new(random.matrix() * 0.5).unwrap().into(),
        Metriplectic::new(LieAlgebra::from_catalogue(&Entry::So3).unwrap(), body.clone(), 0.3).unwrap().into(),
        Periodic::new(random.covector(), 1.5, 0.5).unwrap().into(),
    ]);
    (body, force)
}

/// A random tableau with s stages and weights away from 0.
fn tableau(random: &mut Sequence, stages: usize) -> Tableau<f64> {
    let weights: Vec<f64> = (0..stages).map(|_| 1.0 + 0.5 * random.next()).collect();
    let sum: f64 = weights.iter().sum();
    let b: Vec<f64> = weights.iter().map(|w| w / sum).collect();
    let a: Vec<Vec<f64>> = (0..stages).map(|_| (0..stages).map(|_| 0.5 * random.next()).collect()).collect();
    Tableau::new(&a, &b).unwrap()
}

fn tableaux(random: &mut Sequence) -> Vec<Tableau<f64>> {
    let mut all = vec![of(Family::Gauss, 2), of(Family::RadauIA, 2), of(Family::LobattoIIIC, 3)];
    all.push(Classic::Rk4.tableau().unwrap());
    all.extend([1, 2, 3].map(|s| tableau(random, s)));
    all
}

/// Restricted and doubled step from the same unit, with both attitudes.
#[test]
fn on_the_units_it_is_the_restricted_scheme() {
    let (mut random, retraction) = (Sequence(1), CayleySo3::new());
    for tableau in tableaux(&mut random) {
        let (body, force) = system(&mut random);
        let g = retraction.tau(&random.vector()).unwrap();
        let mut single = State { time: 0.3, momentum: random.covector(), attitude: g };
        let mut double = DoubledState::unit(0.3, single.momentum);
        double.attitudes = Some((g, g));
        let forced = Forced::new(body.clone(), force.clone(), retraction.clone());
        let mut doubled = Doubled::new(tableau.clone(), retraction.clone(), forced);
        let mut restricted = Variational::new(body, force, retraction.clone(), tableau);
        for _ in 0..5 {
            restricted.step(&mut single, 0.05).unwrap();
            doubled.step(&mut double, 0.05).unwrap();
        }
        // Five steps, each to a few units of its 2sN equations.
        let rounding = 5.0 * 64.0 * U * (1.0 + size(&single.momentum)) * (1.0 + size(&g));
        close(size(&(double.mu - single.momentum)), rounding);
        close(size(&(double.lambda - single.momentum)), rounding);
        close(size(&(double.relative - Matrix::<f64, 3>::identity())), rounding);
        let (here, there) = double.attitudes.unwrap();
        close(size(&(here - single.attitude)), rounding);
        close(size(&(there - single.attitude)), rounding);
    }
}

/// (λ, U, μ) off the units and in the image of the modified Legendre transform. That transform is regular only while
/// ½ f''(η) τ⁻¹(U) is small beside l'' ≥ 1, hence the sizes.
fn off_units(doubled: &PaperLagrangian, random: &mut Sequence) -> DoubledState<f64, 3, 3> {
    let relative = doubled.retraction.tau(&(random.vector() * 0.1)).unwrap();
    let partials = doubled.partials(0.0, &(random.vector() * 0.5), &relative, &(random.vector() * 0.5)).unwrap();
    DoubledState { time: 0.0, lambda: -partials.eta, relative, mu: partials.psi, attitudes: None }
}

/// The discrete action h Σ b_i l(dτ_{Ξ_i}H_i, τ(−Ξ_i) U τ(X_i), dτ_{X_i}Ψ_i) of given stages.
fn action(
    lagrangian: &PaperLagrangian,
    tableau: &Tableau<f64>,
    h: f64,
    first: &[Vector<Dual<f64>, 3>],
    u: &Matrix<Dual<f64>, 3>,
    second: &[Vector<Dual<f64>, 3>],
) -> Dual<f64> {
    let retraction = &lagrangian.retraction;
    let mut sum = Dual::constant(0.0);
    for i in 0..tableau.stages() {
        let stage = |unknown: &[Vector<Dual<f64>, 3>]| {
            let mut total = Vector::<Dual<f64>, 3>::zeros();
            for (j, v) in unknown.iter().enumerate() {
                total += v * Dual::constant(h * tableau.a()[(i, j)]);
            }
            total
        };
        let (left, right) = (stage(first), stage(second));
        let eta = retraction.at(&left).unwrap().d() * first[i];
        let psi = retraction.at(&right).unwrap().d() * second[i];
        let between = retraction.tau(&-left).unwrap() * u * retraction.tau(&right).unwrap();
        let time = Dual::constant(h * tableau.c()[i]);
        sum += lagrangian.value(time, &eta, &between, &psi).unwrap() * Dual::constant(h * tableau.b()[i]);
    }
    sum
}

/// The stages of a step off the units extremise the action, and its derivatives are the momenta at both ends:
/// dS = −λ' dτ_ξ δξ + μ' dτ_χ δχ for every variation of the stages, λ = λ' Ad_{τ(ξ)}⁻¹ − R*_U dS, and likewise for μ.
#[test]
fn off_the_units_a_step_extremises_the_action() {
    let (mut random, retraction) = (Sequence(21), CayleySo3::new());
    let h = 0.1;
    for tableau in tableaux(&mut random) {
        let (body, force) = system(&mut random);
        let forced = Forced::new(body, force, retraction.clone());
        let mut state = off_units(&forced, &mut random);
        let (lambda, u, mu) = (state.lambda, state.relative, state.mu);
        let mut doubled = Doubled::new(tableau.clone(), retraction.clone(), forced.clone());
        doubled.step(&mut state, h).unwrap();
        let (first, second) = doubled.stages();
        let total = |v: &[Vector<f64, 3>]| v.iter().zip(tableau.b().iter()).map(|(v, b)| v * (h * b)).sum();
        let (xi, chi): (Vector<f64, 3>, Vector<f64, 3>) = (total(first), total(second));
        let (left, right) = (retraction.at::<f64>(&xi).unwrap(), retraction.at::<f64>(&chi).unwrap());
        let constant = |v: &[Vector<f64, 3>]| v.iter().map(|v| v.map(Dual::constant)).collect::<Vec<_>>();
        let (first, second, still) = (constant(first), constant(second), u.map(Dual::constant));
        let scale = 768.0 * U * (1.0 + size(&mu) + size(&state.mu) + size(&lambda) + size(&state.lambda));
        for a in 0..3 {
            for i in 0..tableau.stages() {
                let weight = h * tableau.b()[i];
                let mut moved = first.clone();
                moved[i][a].eps = 1.0;
                let slope = action(&forced, &tableau, h, &moved, &still, &second).eps / weight;
                close((slope + (state.lambda * left.d())[a]).abs(), scale * 4.0);
                let mut moved = second.clone();
                moved[i][a].eps = 1.0;
                let slope = action(&forced, &tableau, h, &first, &still, &moved).eps / weight;
                close((slope - (state.mu * right.d())[a]).abs(), scale * 4.0);
            }
            let mut e = Vector::<f64, 3>::zeros();
            e[a] = 1.0;
            let hat = forced.hat(&e).unwrap();
            let along = |direction: Matrix<f64, 3>| u.zip_map(&direction, |re, eps| Dual { re, eps });
            let slope = |u| action(&forced, &tableau, h, &first, &u, &second).eps;
            let start = (state.lambda * left.ad_inv())[a] - slope(along(hat * u));
            close((start - lambda[a]).abs(), scale);
            let start = (state.mu * right.ad_inv())[a] - slope(along(u * hat));
            close((start - mu[a]).abs(), scale);
        }
        let end = retraction.tau(&-xi).unwrap() * u * retraction.tau(&chi).unwrap();
        close(size(&(end - state.relative)), 64.0 * U * size(&u));
    }
}

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

/// At h = 0 it is put together from second derivatives of the Lagrangian, else by dual numbers.
#[test]
fn the_jacobian_at_step_zero_is_the_limit_of_small_steps() {
    let (mut random, retraction) = (Sequence(11), CayleySo3::new());
    let (body, force) = system(&mut random);
    let forced = Forced::new(body, force, retraction.clone());
    let state = off_units(&forced, &mut random);
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
    let start = State { time: 0.0, momentum: model.momentum, attitude: Matrix::identity() };
    assert_eq!(scheme.stage_jacobian(&start, 0.1, &rates).unwrap_err(), wrong);
    // h → 0: blockdiag(l'', l'').
    let jacobian = scheme.stage_jacobian(&start, 0.0, &rates[..2]).unwrap();
    for (k, entry) in jacobian.diagonal().iter().enumerate() {
        assert_eq!(*entry, [0.5, 2.0, 1.0][k % 3]);
    }
}

struct Refusing(usize);

impl OneStep<f64, 3, 3> for Refusing {
    fn step(
        &mut self,
        state: &mut State<f64, 3, 3>,
        h: f64,
    ) -> Result<euler_poincare::integrators::Report<f64>, StepError> {
        if self.0 == 0 {
            return Err(StepError::NotFinite { what: "the force" });
        }
        self.0 -= 1;
        state.time += h;
        Ok(euler_poincare::integrators::Report {
            solver: euler_poincare::integrators::Solver::Explicit,
            iterations: self.0,
            residual: 0.5 / (1.0 + self.0 as f64),
        })
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

#[test]
fn kuttas_method_reaches_the_reference() {
    let model = relaxed_rigid_body::<f64>();
    let tableau = Classic::Rk4.tableau().unwrap();
    let error = |steps: usize| {
        let mut method = Classical::new(model.system.clone(), Some(So3::new()), tableau.clone());
        let mut state = State { time: 0.0, momentum: model.momentum, attitude: Matrix::identity() };
        integrate(&mut method, &mut state, 1.0 / steps as f64, steps, |_, _, _| ()).unwrap();
        (state.momentum - model.reference_momentum().unwrap()).norm()
    };
    let ratio = error(32) / error(64);
    assert!((14.5..18.5).contains(&ratio), "{ratio}");
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
        let start = State { time: 0.0, momentum: model.momentum, attitude: Matrix::identity() };
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
    let _ = model.system.lagrangian.energy(&model.velocity());
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
    let line = euler_poincare::algebra::LieAlgebra::<f64, 1>::from_catalogue(&Entry::Abelian(1)).unwrap();
    let system = EulerPoincare::new(line, Bounded, Constant::new(Covector::from([1.0])).unwrap());
    let failed = dormand_prince(&system, &Covector::from([0.0]), &[0.0, 2.0], 1e-6);
    assert!(matches!(failed, Err(AdaptiveError::Legendre { time, .. }) if time >= 0.99), "{failed:?}");
}
