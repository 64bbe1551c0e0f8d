//! The fast steps on SO(3) and SE(3): the same steps as the general ones, in every kind of registers; the solvers that
//! choose their steps; ensembles; and how rounding grows.

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::group::{MatrixGroup, So3};
use euler_poincare::integrators::lanes::{Lanes, Registers};
use euler_poincare::integrators::se3::{self, AdaptiveSe3, CayleySe3, Drag, VariationalSe3};
use euler_poincare::integrators::so3::{
    AdaptiveSo3, Damping, EnsembleSo3, FastRetraction, Free, LaneForce, LaneForceError, Member, Relaxation, Row,
    SolveError, Term, Terms, VariationalSo3,
};
use euler_poincare::integrators::{OneStep, Report, Solver, State, StepError, Variational};
use euler_poincare::laws::method::Claims;
use euler_poincare::laws::own::{Outcome, Settings};
use euler_poincare::mechanics::force::{
    AnyForce, Constant, DoubleBracket, LinearDrag, Metriplectic, Periodic, QuadraticDrag,
};
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Quadratic};
use euler_poincare::mechanics::models::landau_lifshitz_gilbert;
use euler_poincare::mechanics::{Force, Lagrangian};
use euler_poincare::retraction::{Cayley, CayleySo3, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Dd, Real, Scalar};
use euler_poincare::suite;
use euler_poincare::system::System;
use euler_poincare::tableau::{Description, Tableau};
use proptest::prelude::*;
use std::any::Any;
use std::sync::atomic::{AtomicUsize, Ordering};

const U: f64 = f64::EPSILON / 2.0;

fn tableau(name: &str) -> Tableau<f64> {
    name.parse::<Description>().unwrap().build().unwrap()
}

/// A body, a force of the catalogue on it, and where it is.
#[derive(Clone, Debug)]
struct Body {
    lagrangian: Quadratic<f64, 3>,
    force: AnyForce<f64, 3>,
    state: State<f64, 3, 3>,
}

impl Body {
    fn terms(&self) -> Terms {
        Terms::new(&self.force, &self.lagrangian).unwrap()
    }

    /// |Ω|.
    fn speed(&self) -> f64 {
        (self.lagrangian.inverse() * self.state.momentum.transpose()).norm()
    }
}

/// A rotation from a unit quaternion.
fn rotation(q: [f64; 4]) -> Matrix<f64, 3> {
    nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[0], q[1], q[2], q[3]))
        .to_rotation_matrix()
        .into_inner()
}

prop_compose! {
    fn bodies()(
        moments in prop::array::uniform3(0.25f64..4.0),
        turn in prop::array::uniform4(-1.0f64..1.0).prop_filter("a direction", |q| q.iter().map(|v| v * v).sum::<f64>() > 0.01),
        aligned in any::<bool>(),
        momentum in prop::array::uniform3(-2.0f64..2.0).prop_filter("a momentum", |m| m.iter().map(|v| v * v).sum::<f64>() > 0.01),
        attitude in prop::array::uniform4(-1.0f64..1.0).prop_filter("a direction", |q| q.iter().map(|v| v * v).sum::<f64>() > 0.01),
        kinds in prop::collection::vec(0usize..6, 0..3),
        strength in 0.0f64..1.0,
        torque in prop::array::uniform3(-0.5f64..0.5),
        time in -3.0f64..3.0,
    ) -> Body {
        let frame = if aligned { Matrix::identity() } else { rotation(turn) };
        let lagrangian = Quadratic::new(frame * Matrix::from_diagonal(&moments.into()) * frame.transpose()).unwrap();
        let drag = frame * Matrix::<f64, 3>::from_diagonal(&(torque.map(f64::abs)).into()) * frame.transpose();
        let covector = Covector::<f64, 3>::from(torque);
        let algebra = euler_poincare::group::LieGroup::algebra(&So3::<f64>::new()).clone();
        let force = AnyForce::Sum(kinds.iter().map(|kind| match kind {
            0 => DoubleBracket::new(algebra.clone(), lagrangian.clone(), strength).unwrap().into(),
            1 => Metriplectic::new(algebra.clone(), lagrangian.clone(), strength).unwrap().into(),
            2 => LinearDrag::new(drag).unwrap().into(),
            3 => QuadraticDrag::new(drag).unwrap().into(),
            4 => Constant::new(covector).unwrap().into(),
            _ => Periodic::new(covector, 1.0 + strength, strength).unwrap().into(),
        }).collect());
        let state = State { time, momentum: Covector::<f64, 3>::from(momentum), attitude: rotation(attitude) };
        Body { lagrangian, force, state }
    }
}

const TABLEAUX: [&str; 22] = [
    "gauss-1",
    "gauss-2",
    "gauss-3",
    "gauss-4",
    "gauss-5",
    "gauss-6",
    "gauss-7",
    "gauss-8",
    "lobatto-iiia-2",
    "lobatto-iiia-3",
    "lobatto-iiia-5",
    "lobatto-iiib-2",
    "lobatto-iiib-4",
    "lobatto-iiib-5",
    "lobatto-iiic-2",
    "lobatto-iiic-4",
    "radau-ia-2",
    "radau-ia-3",
    "radau-iia-2",
    "radau-iia-4",
    "rk4",
    "lobatto-iiia-4",
];

/// Where two engines that solve to these residuals may differ: both are within |J⁻¹| r of the root, and the sums that
/// make the new state round in other orders. |J⁻¹| ≤ 16 wherever sweeps contract at 0.8 or faster and |dτ⁻¹| ≤ 2.
fn allowance(reports: [&Report<f64>; 2], size: f64) -> f64 {
    let residual: f64 = reports.iter().map(|report| report.residual).sum();
    (16.0 * residual + 256.0 * U) * (1.0 + size)
}

fn distance<const N: usize, const D: usize>(x: &State<f64, N, D>, y: &State<f64, N, D>) -> f64 {
    (x.momentum - y.momentum).amax().max((x.attitude - y.attitude).amax()).max((x.time - y.time).abs())
}

/// A few steps by both, compared one by one; how many were compared.
fn agree<R: FastRetraction>(
    body: &Body,
    name: &str,
    retraction: R,
    h: f64,
    registers: Registers,
) -> Result<usize, TestCaseError> {
    let mut fast = VariationalSo3::new(body.lagrangian.clone(), body.terms(), retraction.clone(), tableau(name))
        .unwrap()
        .in_registers(registers);
    let mut general = Variational::new(body.lagrangian.clone(), body.force.clone(), retraction, tableau(name));
    agree_on(&mut fast, &mut general, body.state.clone(), h)
}

/// The same for two methods.
fn agree_on<const N: usize, const D: usize>(
    fast: &mut impl OneStep<f64, N, D>,
    general: &mut impl OneStep<f64, N, D>,
    mut state: State<f64, N, D>,
    h: f64,
) -> Result<usize, TestCaseError> {
    let mut compared = 0;
    for _ in 0..4 {
        let mut other = state.clone();
        match (fast.step(&mut state, h), general.step(&mut other, h)) {
            (Ok(a), Ok(b)) => {
                let positions = if D == 4 { other.attitude.amax() } else { 0.0 };
                let bound = allowance([&a, &b], other.momentum.amax().max(positions));
                prop_assert!(distance(&state, &other) <= bound, "{} > {bound}: {a:?} {b:?}", distance(&state, &other));
                prop_assert!(a.residual <= (1 << 14) as f64 * U);
                compared += 1;
            }
            (Err(a), Err(b)) => {
                prop_assert_eq!(std::mem::discriminant(&a), std::mem::discriminant(&b), "{} {}", a, b);
                break;
            }
            // Where the branch is nearly folded, one may stop short of the other.
            (Ok(report), Err(_)) | (Err(_), Ok(report)) => {
                prop_assert!(report.solver != Solver::Sweeps || report.iterations > 20, "{report:?}");
                break;
            }
        }
    }
    Ok(compared)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 192, ..ProptestConfig::default() })]

    #[test]
    fn the_fast_step_is_the_general_step(
        body in bodies(), name in prop::sample::select(&TABLEAUX[..]), angle in 0.001f64..1.5, exponential in any::<bool>(), back in any::<bool>(),
    ) {
        let h = angle / body.speed() * if back { -1.0 } else { 1.0 };
        for registers in Registers::all() {
            if exponential {
                agree(&body, name, ExponentialSo3::new(), h, registers)?;
            } else {
                agree(&body, name, CayleySo3::new(), h, registers)?;
            }
        }
    }

    #[test]
    fn the_solver_keeps_its_tolerance(body in bodies(), span in 0.5f64..6.0, digits in 3i32..13, back in any::<bool>()) {
        let span = span / body.speed() * if back { -1.0 } else { 1.0 };
        let tolerance = 10f64.powi(-digits);
        let mut solver = AdaptiveSo3::new(body.lagrangian.clone(), body.terms());
        let mut state = body.state.clone();
        let solved = match solver.solve(&mut state, span, tolerance) {
            Ok(solved) => solved,
            // Backward, drag drives the motion, and quadratic drag to infinity in finite time.
            Err(error) => {
                let growth = state.momentum.amax() / body.state.momentum.amax();
                prop_assert!(back && growth > 100.0, "{error} after a growth of {growth}");
                return Ok(());
            }
        };
        // Fixed short steps of a high order, by the general engine.
        let mut general = Variational::new(body.lagrangian.clone(), body.force.clone(), ExponentialSo3::new(), tableau("gauss-6"));
        let mut reference = body.state.clone();
        let steps = 64;
        for _ in 0..steps {
            general.step(&mut reference, span / f64::from(steps)).map_err(|e| TestCaseError::reject(e.to_string()))?;
        }
        // A bound on how much errors grow: forces of the generator have |∂f| ≤ 4 a unit of |Ω|.
        let error = (state.momentum - reference.momentum).amax() / body.state.momentum.amax().max(reference.momentum.amax());
        let error = error.max((state.attitude - reference.attitude).amax());
        let growth = (reference.momentum.amax() / body.state.momentum.amax()).max(1.0).powi(2);
        prop_assert!(error <= growth * (16.0 * tolerance + 2e-12), "{error:e} at {tolerance:e}: {solved:?}");
        // The reference adds up 64 steps.
        prop_assert!((state.time - reference.time).abs() <= 64.0 * U * (4.0 + span.abs()));
        let defect = (state.attitude.transpose() * state.attitude - Matrix::identity()).amax();
        prop_assert!(defect <= 1e-14, "{defect:e}");
    }
}

#[test]
fn most_steps_are_taken_by_sweeps() {
    let model = landau_lifshitz_gilbert::<f64>();
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    for name in TABLEAUX {
        let body = Body {
            lagrangian: lagrangian.clone(),
            force: model.system.force.clone(),
            state: State { time: 0.0, momentum: model.momentum, attitude: Matrix::identity() },
        };
        for registers in Registers::all() {
            assert_eq!(agree(&body, name, CayleySo3::new(), 0.125, registers).unwrap(), 4, "{name}");
            assert_eq!(agree(&body, name, ExponentialSo3::new(), 0.125, registers).unwrap(), 4, "{name}");
        }
    }
}

/// One step of the specification's problems, and its errors at T = 1 (150-bit runs).
#[test]
fn the_reference_steps_are_reproduced() {
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let momentum = Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2f64.sqrt();
    let start = State { time: 0.0, momentum, attitude: Matrix::identity() };
    let steps = [
        ("gauss-1", [0.3325523603683159, 0.0312710753139576, 0.7165415190785951]),
        ("gauss-2", [0.3325020802648156, 0.0313526763021243, 0.7165607981817258]),
        ("lobatto-iiia-3", [0.3325020242605735, 0.0313527332683193, 0.7165608236605989]),
        ("lobatto-iiib-3", [0.3325021449851981, 0.031352629963113, 0.7165607678834958]),
    ];
    for (name, expected) in steps {
        let mut method =
            VariationalSo3::new(lagrangian.clone(), Damping(1.0), CayleySo3::new(), tableau(name)).unwrap();
        let mut state = start.clone();
        method.step(&mut state, 0.125).unwrap();
        assert!((state.momentum - Covector::<f64, 3>::from(expected)).amax() < 4e-16, "{name} {}", state.momentum);
    }
    let exact = Covector::<f64, 3>::new(0.3792307480209544, 0.2570004497899354, 0.6552430571284845);
    for (name, steps, error) in
        [("gauss-2", 8, 2.46e-7), ("gauss-3", 4, 3.65e-9), ("gauss-4", 2, 9.58e-11), ("gauss-1", 64, 1.05e-5)]
    {
        let mut method =
            VariationalSo3::new(lagrangian.clone(), Relaxation(0.1), CayleySo3::new(), tableau(name)).unwrap();
        let mut state = start.clone();
        for _ in 0..steps {
            method.step(&mut state, 1.0 / f64::from(steps)).unwrap();
        }
        let found = (state.momentum - exact).norm();
        assert!((found / error - 1.0).abs() < 0.01, "{name}: {found:e}");
    }
}

#[test]
fn a_fold_is_refused_by_the_fast_step_too() {
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let momentum = Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2f64.sqrt();
    let start = State { time: 0.0, momentum, attitude: Matrix::identity() };
    for (name, fold) in [("lobatto-iiia-2", 0.797), ("radau-ia-1", 0.49), ("lobatto-iiic-2", 0.76)] {
        let mut method =
            VariationalSo3::new(lagrangian.clone(), Damping(1.0), CayleySo3::new(), tableau(name)).unwrap();
        let mut state = start.clone();
        let error = method.step(&mut state, fold + 0.1).unwrap_err();
        let StepError::Fold { fold: found, .. } = error else { panic!("{name}: {error}") };
        assert!((found - fold).abs() < 0.01, "{name}: {found}");
        assert_eq!(state, start);
    }
}

#[test]
fn bad_input_is_refused() {
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.5, 0.0, 1.0), attitude: Matrix::identity() };
    let mut method =
        VariationalSo3::new(lagrangian.clone(), Damping(1.0), CayleySo3::new(), tableau("gauss-3")).unwrap();
    for h in [f64::NAN, f64::INFINITY] {
        let mut state = start.clone();
        assert!(matches!(method.step(&mut state, h), Err(StepError::NotFinite { .. })));
        assert_eq!(state, start);
    }
    let mut state = State { momentum: Covector::<f64, 3>::new(f64::NAN, 0.0, 0.0), ..start.clone() };
    assert!(matches!(method.step(&mut state, 0.1), Err(StepError::NotFinite { .. })));
    // At rest, and a step of no size.
    let mut state = State { momentum: Covector::zeros(), ..start.clone() };
    method.step(&mut state, 0.1).unwrap();
    assert_eq!(state.momentum, Covector::<f64, 3>::zeros());
    let mut state = start.clone();
    method.step(&mut state, 0.0).unwrap();
    assert!(distance(&state, &start) <= 4.0 * U);

    let nine = VariationalSo3::new(lagrangian.clone(), Damping(1.0), CayleySo3::new(), tableau("gauss-9"));
    assert_eq!(nine.unwrap_err().stages, 9);
    let other = Quadratic::diagonal([1.0, 2.0, 3.0]).unwrap();
    let algebra = euler_poincare::group::LieGroup::algebra(&So3::<f64>::new()).clone();
    let force: AnyForce<f64, 3> = DoubleBracket::new(algebra.clone(), other.clone(), 1.0).unwrap().into();
    assert!(matches!(Terms::new(&force, &lagrangian), Err(LaneForceError::OtherLagrangian { .. })));
    let basis = Matrix::<f64, 3>::new(1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0);
    let force = Metriplectic::new(algebra.in_basis(&basis).unwrap(), lagrangian.clone(), 1.0).unwrap().into();
    assert!(matches!(Terms::new(&force, &lagrangian), Err(LaneForceError::OtherAlgebra { .. })));

    let mut solver = AdaptiveSo3::new(lagrangian, Damping(1.0));
    for (span, tolerance) in
        [(f64::NAN, 1e-8), (f64::INFINITY, 1e-8), (1.0, 0.0), (1.0, f64::NAN), (1.0, 2.0), (1.0, -1.0)]
    {
        let mut state = start.clone();
        assert!(matches!(solver.solve(&mut state, span, tolerance), Err(SolveError::BadInput { .. })));
        assert_eq!(state, start);
    }
    let mut state = start.clone();
    assert_eq!(solver.solve(&mut state, 0.0, 1e-8).unwrap().steps, 0);
    let mut state = State { momentum: Covector::zeros(), ..start.clone() };
    let rest = solver.solve(&mut state, 5.0, 1e-8).unwrap();
    assert_eq!((state.momentum, state.attitude, rest.steps), (Covector::<f64, 3>::zeros(), Matrix::identity(), 1));
}

/// A torque that switches on faster than any step resolves cannot be integrated to the tolerance: an error, no wrong answer.
#[test]
fn what_cannot_be_kept_is_an_error() {
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.5, 0.0, 1.0), attitude: Matrix::identity() };
    let force = Terms(vec![Term::Constant([f64::MAX, 0.0, 0.0])]);
    let mut solver = AdaptiveSo3::new(lagrangian, force);
    let mut state = start.clone();
    let error = solver.solve(&mut state, 1.0, 1e-8).unwrap_err();
    assert!(matches!(error, SolveError::Stuck { .. } | SolveError::Tolerance { .. }), "{error}");
    assert_eq!(state, start);
}

/// A torque that vanishes at the start of a steady rotation, and at rest.
#[test]
fn what_is_steady_now_need_not_stay_so() {
    let ball = Quadratic::diagonal([1.0; 3]).unwrap();
    // M' = sin t about the axis of M.
    let force = Terms(vec![Term::Periodic([0.0, 0.0, 1.0], 1.0, -std::f64::consts::FRAC_PI_2)]);
    for start in [0.0, 1.0] {
        let mut solver = AdaptiveSo3::new(ball.clone(), force.clone());
        let momentum = Covector::<f64, 3>::new(0.0, 0.0, start);
        let mut state = State { time: 0.0, momentum, attitude: Matrix::identity() };
        solver.solve(&mut state, 2.0, 1e-9).unwrap();
        let error = state.momentum[2] - start - (1.0 - 2f64.cos());
        assert!(error.abs() < 1e-8, "{start} {error:e}");
    }
}

/// 1000 units of time of the relaxed body: attitude, free Casimir and energy.
#[test]
fn a_long_run_stays_on_the_group() {
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let momentum = Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2f64.sqrt();
    let start = State { time: 0.0, momentum, attitude: Matrix::identity() };
    let mut worst: f64 = 0.0;
    let mut see = |state: &State<f64, 3, 3>| {
        worst = worst.max((state.attitude.transpose() * state.attitude - Matrix::identity()).amax());
    };
    let mut solver = AdaptiveSo3::new(lagrangian.clone(), Relaxation(0.1));
    let mut state = start.clone();
    let solved = solver.solve_with(&mut state, 1000.0, 1e-10, |state, _| see(state)).unwrap();
    assert!(solved.steps < 500, "{solved:?}");
    let mut solver = AdaptiveSo3::new(lagrangian, Free);
    let mut state = start.clone();
    let mut casimir: f64 = 0.0;
    solver
        .solve_with(&mut state, 1000.0, 1e-10, |state, _| {
            see(state);
            casimir = casimir.max((state.momentum.norm_squared() - start.momentum.norm_squared()).abs());
        })
        .unwrap();
    assert!(worst <= 1e-14 && casimir <= 1e-14, "{worst:e} {casimir:e}");
}

fn member(k: usize) -> Member<Terms> {
    let x = |n: usize| ((k * 7 + n * 13 + k * k * n) % 101) as f64 / 101.0;
    let terms = match k % 4 {
        0 => vec![],
        1 => vec![Term::Damping(x(1))],
        2 => vec![Term::Constant([0.1, -0.2, x(2)]), Term::Relaxation(0.5 * x(3)), Term::Damping(0.2)],
        _ => vec![
            Term::LinearDrag([[0.2, 0.0, 0.0], [0.0, 0.1, 0.05], [0.0, 0.05, x(4)]]),
            Term::Periodic([x(5), 0.0, 0.1], 2.0, 0.3),
        ],
    };
    Member {
        lagrangian: Quadratic::diagonal([0.5 + x(1), 0.75 + x(2), 1.0]).unwrap(),
        force: Terms(terms),
        state: State {
            time: x(6),
            momentum: Covector::<f64, 3>::new(x(7) - 0.5, 0.25 + x(8), x(9) - 0.5),
            attitude: rotation([1.0, x(1), x(2), x(3)]),
        },
    }
}

#[test]
fn an_ensemble_is_its_bodies() {
    for (name, size) in [("gauss-2", 21), ("gauss-4", 8), ("lobatto-iiia-3", 3), ("radau-iia-2", 1)] {
        let members: Vec<_> = (0..size).map(member).collect();
        for registers in Registers::all() {
            let mut ensemble = EnsembleSo3::<Terms<Row>, _>::new(&members, CayleySo3::new(), tableau(name))
                .unwrap()
                .in_registers(registers);
            assert_eq!(ensemble.len(), size);
            ensemble.advance(1.0 / 32.0, 40).unwrap();
            for (k, (member, found)) in members.iter().zip(ensemble.states()).enumerate() {
                let force = member.force.clone();
                let mut method =
                    VariationalSo3::new(member.lagrangian.clone(), force, CayleySo3::new(), tableau(name)).unwrap();
                let mut state = member.state.clone();
                for _ in 0..40 {
                    method.step(&mut state, 1.0 / 32.0).unwrap();
                }
                assert!(distance(&state, &found) < 1e-14, "{name} {k}: {:e}", distance(&state, &found));
                assert_eq!(ensemble.state(k), Some(found));
            }
            assert_eq!(ensemble.state(size), None);
        }
    }
}

#[test]
fn an_ensemble_gives_the_same_bits_on_any_number_of_threads() {
    let members: Vec<_> = (0..100).map(member).collect();
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mut ensemble =
            EnsembleSo3::<Terms<Row>, _>::new(&members, ExponentialSo3::new(), tableau("gauss-3")).unwrap();
        pool.install(|| ensemble.advance(0.05, 50)).unwrap();
        ensemble.states().collect::<Vec<_>>()
    };
    let one = run(1);
    assert_eq!(one, run(2));
    assert_eq!(one, run(7));
}

#[test]
fn an_ensemble_takes_steps_that_sweeps_do_not_solve_and_names_the_body_that_fails() {
    let momentum = Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2f64.sqrt();
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let member = |scale: f64| Member {
        lagrangian: lagrangian.clone(),
        force: Damping(scale),
        state: State { time: 0.0, momentum: momentum * scale, attitude: Matrix::identity() },
    };
    // The branch of Lobatto IIIA-2 folds at h = 0.797 for the body 9, at larger steps for the others.
    let members: Vec<_> = (0..12).map(|k| member(if k == 9 { 1.0 } else { 0.25 })).collect();
    let mut ensemble =
        EnsembleSo3::<Damping<Row>, _>::new(&members, CayleySo3::new(), tableau("lobatto-iiia-2")).unwrap();
    let error = ensemble.advance(0.9, 3).unwrap_err();
    assert_eq!((error.member, error.step), (9, 0), "{error}");
    assert!(matches!(error.source, StepError::Fold { .. }), "{error}");
    // Newton's method steps in: large steps of Gauss-1.
    let mut ensemble = EnsembleSo3::<Damping<Row>, _>::new(&members, CayleySo3::new(), tableau("gauss-1")).unwrap();
    ensemble.advance(1.5, 2).unwrap();
    for (member, found) in members.iter().zip(ensemble.states()) {
        let mut method =
            VariationalSo3::new(member.lagrangian.clone(), member.force, CayleySo3::new(), tableau("gauss-1")).unwrap();
        let mut state = member.state.clone();
        method.step(&mut state, 1.5).unwrap();
        method.step(&mut state, 1.5).unwrap();
        assert!(distance(&state, &found) < 1e-13);
    }
}

/// The rounding errors of free bodies over many steps: |μ|² and g μ are kept by the method, so all change is rounding. With
/// compensated sums it grows like √n.
#[test]
fn rounding_grows_like_the_square_root_of_the_steps() {
    let members: Vec<_> =
        (0..32).map(|k| Member { force: Free, lagrangian: member(k).lagrangian, state: member(k).state }).collect();
    let mut ensemble = EnsembleSo3::<Free, _>::new(&members, CayleySo3::new(), tableau("gauss-2")).unwrap();
    let spatial = |state: &State<f64, 3, 3>| state.attitude * state.momentum.transpose();
    let mut rms = Vec::new();
    let mut taken = 0;
    for steps in [1000, 4000, 16000, 64000] {
        ensemble.advance(0.1, steps - taken).unwrap();
        taken = steps;
        let squares = members.iter().zip(ensemble.states()).map(|(member, state)| {
            ((spatial(&state) - spatial(&member.state)) / member.state.momentum.norm()).norm_squared()
        });
        rms.push((squares.sum::<f64>() / 32.0).sqrt());
    }
    let exponent = (rms[3] / rms[0]).ln() / 64f64.ln();
    assert!(exponent < 0.75, "{exponent} {rms:?}");
    assert!(rms[3] < 1e-13, "{rms:?}");
}

/// [`VariationalSo3`] on `f64`, the general engine on other scalars and other Lagrangians: the laws of methods judge both.
struct Either<'s, T: Real, R, L, F> {
    fast: Option<VariationalSo3<Terms, CayleySo3<f64>>>,
    general: Variational<T, 3, 3, &'s L, &'s F, &'s R>,
}

impl<'s, T: Real, R, L, F> Either<'s, T, R, L, F>
where
    R: Retraction<T, 3, 3>,
    L: Lagrangian<T, 3> + 'static,
    F: Force<T, 3> + 'static,
{
    fn new(system: &'s System<T, 3, 3, R, L, F>) -> Self {
        let lagrangian = (&system.lagrangian as &dyn Any).downcast_ref::<AnyLagrangian<f64, 3>>();
        let force = (&system.force as &dyn Any).downcast_ref::<AnyForce<f64, 3>>();
        let fast = match (lagrangian, force) {
            (Some(AnyLagrangian::Quadratic(lagrangian)), Some(force)) => {
                let terms = Terms::new(force, lagrangian).expect("a force on this body");
                let method = VariationalSo3::new(lagrangian.clone(), terms, CayleySo3::new(), tableau("gauss-3"));
                Some(method.expect("three stages"))
            }
            _ => None,
        };
        let tableau = "gauss-3".parse::<Description>().unwrap().build().unwrap();
        Self { fast, general: Variational::new(&system.lagrangian, &system.force, &system.retraction, tableau) }
    }
}

/// Steps that the fast path took in the laws below.
static FAST: AtomicUsize = AtomicUsize::new(0);

impl<T: Real, R, L, F> OneStep<T, 3, 3> for Either<'_, T, R, L, F>
where
    R: Retraction<T, 3, 3>,
    L: Lagrangian<T, 3>,
    F: Force<T, 3>,
{
    fn step(&mut self, state: &mut State<T, 3, 3>, h: T) -> Result<Report<T>, StepError> {
        if let Some(fast) = &mut self.fast
            && let Some(state) = (state as &mut dyn Any).downcast_mut::<State<f64, 3, 3>>()
        {
            FAST.fetch_add(1, Ordering::Relaxed);
            let report = fast.step(state, h.to_f64())?;
            let Report { solver, iterations, residual } = report;
            return Ok(Report { solver, iterations, residual: T::exact(residual) });
        }
        self.general.step(state, h)
    }
}

suite! {
    mod step<T, 3, 3> {
        group: So3::<T>::new(),
        retraction: CayleySo3::<T>::new(),
        method: |system| Either::new(system),
        claims: Claims { order: Some(6), casimirs: true, ..Claims::default() },
    }
}

/// The laws of methods, with the fast step as the method wherever the case has a quadratic Lagrangian.
#[test]
fn the_laws_of_methods_hold_on_the_fast_step() {
    let suite = step::suite();
    let names: Vec<_> = suite.names().into_iter().filter(|name| name.starts_with("method-")).collect();
    assert!(names.len() >= 5, "{names:?}");
    for name in names {
        let before = FAST.load(Ordering::Relaxed);
        match suite.run(name, &Settings::new()) {
            Outcome::Held { .. } => {}
            // |μ|² on SO(3) is judged by `a_long_run_stays_on_the_group`.
            Outcome::Off { .. } if name == "method-casimirs" => continue,
            other => panic!("{name}: {other:?}"),
        }
        // What falls with the step is judged in 32 digits alone.
        let asked = FAST.load(Ordering::Relaxed) - before;
        let slope = ["method-order", "method-energy", "method-reversibility"].contains(&name);
        assert!(slope || asked > 100, "{name}: the fast step was asked {asked} times");
    }
}

#[test]
fn the_digits_of_the_general_engine_are_those_of_the_fast_one() {
    // Gauss-3 in 32 digits against the fast step: the 16 digits agree.
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.5, 0.25, 1.0), attitude: Matrix::identity() };
    let mut fast = VariationalSo3::new(body, Damping(1.0), CayleySo3::new(), tableau("gauss-3")).unwrap();
    let mut state = start.clone();
    fast.step(&mut state, 0.25).unwrap();
    let algebra = euler_poincare::group::LieGroup::algebra(&So3::<Dd>::new()).clone();
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0].map(Dd::exact)).unwrap();
    let force = DoubleBracket::new(algebra, lagrangian.clone(), Dd::exact(1.0)).unwrap();
    let exact = "gauss-3".parse::<Description>().unwrap().build::<Dd>().unwrap();
    let mut general = Variational::new(lagrangian, force, CayleySo3::new(), exact);
    let mut other =
        State { time: Dd::exact(0.0), momentum: start.momentum.map(Dd::exact), attitude: Matrix::identity() };
    general.step(&mut other, Dd::exact(0.25)).unwrap();
    assert!((state.momentum - other.momentum.map(|v| v.to_f64())).amax() <= 4.0 * U);
    assert!((state.attitude - other.attitude.map(|v| v.to_f64())).amax() <= 4.0 * U);
}

/// A body in SE(3), a force of the catalogue on it, and where it is.
#[derive(Clone, Debug)]
struct Submerged {
    lagrangian: Quadratic<f64, 6>,
    force: AnyForce<f64, 6>,
    state: State<f64, 6, 4>,
}

impl Submerged {
    fn terms(&self) -> se3::Terms {
        se3::Terms::new(&self.force).unwrap()
    }

    /// |η|.
    fn speed(&self) -> f64 {
        (self.lagrangian.inverse() * self.state.momentum.transpose()).norm()
    }
}

fn six() -> impl Strategy<Value = [f64; 6]> {
    prop::array::uniform6(-1.0f64..1.0).prop_filter("not zero", |v| v.iter().map(|x| x * x).sum::<f64>() > 0.04)
}

prop_compose! {
    fn submerged()(
        moments in prop::array::uniform6(0.5f64..2.0),
        mixed in six(),
        aligned in any::<bool>(),
        momentum in six(),
        attitude in prop::array::uniform4(-1.0f64..1.0).prop_filter("a direction", |q| q.iter().map(|v| v * v).sum::<f64>() > 0.01),
        position in prop::array::uniform3(-2.0f64..2.0),
        kinds in prop::collection::vec(0usize..4, 0..3),
        load in six(),
        time in -3.0f64..3.0,
    ) -> Submerged {
        let mixed = euler_poincare::algebra::Vector::<f64, 6>::from(mixed);
        let full = |diagonal: [f64; 6]| {
            let matrix = Matrix::<f64, 6>::from_diagonal(&diagonal.into());
            if aligned { matrix } else { matrix + mixed * mixed.transpose() * 0.25 }
        };
        let lagrangian = Quadratic::new(full(moments)).unwrap();
        let drag = full(load.map(|v| 0.25 * v.abs()));
        let covector = Covector::<f64, 6>::from(load) * 0.5;
        let force = AnyForce::Sum(kinds.iter().map(|kind| match kind {
            0 => LinearDrag::new(drag).unwrap().into(),
            1 => QuadraticDrag::new(drag).unwrap().into(),
            2 => Constant::new(covector).unwrap().into(),
            _ => Periodic::new(covector, 1.0 + load[0], load[1]).unwrap().into(),
        }).collect());
        let mut pose = Matrix::<f64, 4>::identity();
        pose.fixed_view_mut::<3, 3>(0, 0).copy_from(&rotation(attitude));
        pose.fixed_view_mut::<3, 1>(0, 3).copy_from(&nalgebra::Vector3::from(position));
        Submerged { lagrangian, force, state: State { time, momentum: Covector::from(momentum), attitude: pose } }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

    #[test]
    fn the_fast_step_on_se3_is_the_general_step(
        body in submerged(), name in prop::sample::select(&TABLEAUX[..]), angle in 0.001f64..1.0, back in any::<bool>(),
    ) {
        let h = angle / body.speed() * if back { -1.0 } else { 1.0 };
        for registers in Registers::all() {
            let mut fast = VariationalSe3::new(body.lagrangian.clone(), body.terms(), CayleySe3::new(), tableau(name))
                .unwrap()
                .in_registers(registers);
            let group = MatrixGroup::<f64, 6, 4>::from_entry(&Entry::Se3).unwrap();
            let cayley = Cayley::new(group).unwrap();
            let mut general = Variational::new(body.lagrangian.clone(), body.force.clone(), cayley, tableau(name));
            agree_on(&mut fast, &mut general, body.state.clone(), h)?;
        }
    }

    #[test]
    fn the_solver_on_se3_keeps_its_tolerance(body in submerged(), span in 0.5f64..6.0, digits in 3i32..13, back in any::<bool>()) {
        let span = span / body.speed() * if back { -1.0 } else { 1.0 };
        let tolerance = 10f64.powi(-digits);
        let mut solver = AdaptiveSe3::new(body.lagrangian.clone(), body.terms());
        let mut state = body.state.clone();
        let solved = match solver.solve(&mut state, span, tolerance) {
            Ok(solved) => solved,
            // Backward, drag drives the motion, and quadratic drag to infinity in finite time.
            Err(error) => {
                let growth = state.momentum.amax() / body.state.momentum.amax();
                prop_assert!(back && growth > 100.0, "{error} after a growth of {growth}");
                return Ok(());
            }
        };
        // Fixed short steps of a high order, judged against the general engine above.
        let mut fine = VariationalSe3::new(body.lagrangian.clone(), body.terms(), CayleySe3::new(), tableau("gauss-8")).unwrap();
        let mut reference = body.state.clone();
        let steps = 256;
        for _ in 0..steps {
            fine.step(&mut reference, span / f64::from(steps)).map_err(|e| TestCaseError::reject(e.to_string()))?;
        }
        let size = body.state.momentum.amax().max(reference.momentum.amax());
        let error = (state.momentum - reference.momentum).amax() / size;
        let error = error.max((state.attitude - reference.attitude).amax() / (1.0 + reference.attitude.amax()));
        let growth = (reference.momentum.amax() / body.state.momentum.amax()).max(1.0).powi(2);
        prop_assert!(error <= growth * (16.0 * tolerance + 4e-12), "{error:e} at {tolerance:e}: {solved:?}");
        // The reference adds up 256 steps.
        prop_assert!((state.time - reference.time).abs() <= 256.0 * U * (4.0 + span.abs()));
        let turn = state.attitude.fixed_view::<3, 3>(0, 0);
        let defect = (turn.transpose() * turn - Matrix::<f64, 3>::identity()).amax();
        prop_assert!(defect <= 1e-14, "{defect:e}");
        let last = state.attitude.row(3).into_owned();
        prop_assert_eq!(last, Matrix::<f64, 4>::identity().row(3).into_owned());
    }
}

/// The body in a fluid of the benchmarks, by sweeps throughout, and to ten digits in a few steps.
#[test]
fn a_body_in_a_fluid_is_solved_by_sweeps() {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).unwrap();
    let drag = |d: f64| Matrix::<f64, 6>::from_diagonal_element(d);
    let force: AnyForce<f64, 6> = AnyForce::Sum(vec![
        LinearDrag::new(drag(0.125)).unwrap().into(),
        QuadraticDrag::new(drag(0.25)).unwrap().into(),
    ]);
    let terms = se3::Terms::new(&force).unwrap();
    assert_eq!(terms.0[0], se3::Term::LinearDrag(Drag::Diagonal([0.125; 6])));
    let momentum = Covector::<f64, 6>::from([0.5, -0.25, 1.0, 1.0, 0.5, -0.5]);
    let start = State { time: 0.0, momentum, attitude: Matrix::identity() };
    for name in TABLEAUX {
        let mut fast = VariationalSe3::new(body.clone(), terms.clone(), CayleySe3::new(), tableau(name)).unwrap();
        let mut state = start.clone();
        for _ in 0..10 {
            assert_eq!(fast.step(&mut state, 0.1).unwrap().solver, Solver::Sweeps, "{name}");
        }
    }
    // π(10), p(10), from the reference solution of the benchmarks.
    let mut fine = VariationalSe3::new(body.clone(), terms.clone(), CayleySe3::new(), tableau("gauss-8")).unwrap();
    let mut reference = start.clone();
    for _ in 0..200 {
        fine.step(&mut reference, 0.05).unwrap();
    }
    let mut solver = AdaptiveSe3::new(body, terms);
    let mut state = start;
    let solved = solver.solve(&mut state, 10.0, 1e-10).unwrap();
    assert!(distance(&state, &reference) < 1e-10, "{:e}", distance(&state, &reference));
    assert!(solved.steps <= 16, "{solved:?}");
}

/// Along straight motions δ vanishes: what keeps the error there is how stage values decay.
#[test]
fn straight_motions_keep_the_tolerance_too() {
    let body = Quadratic::diagonal([1.0; 6]).unwrap();
    let surge = |v: f64| [0.0, 0.0, 0.0, v, 0.0, 0.0];
    let start = State { time: 0.0, momentum: Covector::from(surge(1.0)), attitude: Matrix::<f64, 4>::identity() };
    // p' = −p|p|: p = 1/(1 + t), x = ln(1 + t).
    let drag = se3::Terms(vec![se3::Term::QuadraticDrag(Drag::Diagonal([1.0; 6]))]);
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let mut solver = AdaptiveSe3::new(body.clone(), drag.clone());
        let mut state = start.clone();
        let solved = solver.solve(&mut state, 20.0, tolerance).unwrap();
        let error = (state.momentum[3] - 1.0 / 21.0).abs().max((state.attitude[(0, 3)] - 21f64.ln()).abs());
        assert!(error <= 16.0 * tolerance, "{error:e} at {tolerance:e}: {solved:?}");
    }
}

#[test]
fn a_drag_through_rest_keeps_the_tolerance() {
    let body = Quadratic::diagonal([1.0; 6]).unwrap();
    let surge = |v: f64| [0.0, 0.0, 0.0, v, 0.0, 0.0];
    let start = State { time: 0.0, momentum: Covector::from(surge(1.0)), attitude: Matrix::<f64, 4>::identity() };
    // p' = −p|p| − 1: through rest, where |p| has a kink; p = tan(π/4 − t) until then, p = −tanh(t − π/4) from then on.
    let drag = se3::Term::QuadraticDrag(Drag::Diagonal([1.0; 6]));
    let load = se3::Terms(vec![drag, se3::Term::Constant(surge(-1.0))]);
    let quarter = std::f64::consts::FRAC_PI_4;
    let (p, x) = (-(2.0 - quarter).tanh(), -quarter.cos().ln() - (2.0 - quarter).cosh().ln());
    for tolerance in [1e-4, 1e-7, 1e-10] {
        let mut solver = AdaptiveSe3::new(body.clone(), load.clone());
        let mut state = start.clone();
        let solved = solver.solve(&mut state, 2.0, tolerance).unwrap();
        let error = (state.momentum[3] - p).abs().max((state.attitude[(0, 3)] - x).abs());
        assert!(error <= 16.0 * tolerance, "{error:e} at {tolerance:e}: {solved:?}");
    }
}

/// Spin about a principal axis: δ vanishes along it, unless the force does, too.
#[test]
fn spin_about_an_axis_keeps_the_tolerance_too() {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.0, 0.0, 1.0), attitude: Matrix::identity() };
    let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let angle = |state: &State<f64, 3, 3>| state.attitude[(1, 0)].atan2(state.attitude[(0, 0)]);
    for digits in 6..25 {
        let tolerance = 10f64.powf(-0.5 * f64::from(digits));
        // As in the two tests above: slowing down, and through rest.
        let quarter = std::f64::consts::FRAC_PI_4;
        for (load, span, end, turned) in [
            (0.0, 20.0, 1.0 / 21.0, 21f64.ln()),
            (-1.0, 2.0, -(2.0 - quarter).tanh(), -quarter.cos().ln() - (2.0 - quarter).cosh().ln()),
        ] {
            let terms = Terms(vec![Term::QuadraticDrag(one), Term::Constant([0.0, 0.0, load])]);
            let mut solver = AdaptiveSo3::new(body.clone(), terms);
            let mut state = start.clone();
            let solved = solver.solve(&mut state, span, tolerance).unwrap();
            let turn = (angle(&state) - turned).rem_euclid(std::f64::consts::TAU);
            let error = (state.momentum[2] - end).abs().max(turn.min(std::f64::consts::TAU - turn));
            assert!(error <= 16.0 * tolerance, "{error:e} at {tolerance:e}: {solved:?}");
        }
    }
}

/// Backward, linear drag drives a body to ever faster rotation: there is no end of steps.
#[test]
fn a_run_without_end_is_refused() {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut solver = AdaptiveSo3::new(body, Terms(vec![Term::LinearDrag(one)])).with_max_steps(1000);
    let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.5, 0.25, 1.0), attitude: Matrix::identity() };
    let mut state = start.clone();
    let error = solver.solve(&mut state, -200.0, 1e-8).unwrap_err();
    assert!(matches!(error, SolveError::TooManySteps { steps: 1000, .. }), "{error}");
    assert!(state.time < -1.0 && state.momentum.norm() > start.momentum.norm(), "the state is that of the last step");
}

/// A force of one's own.
#[derive(Clone)]
struct Spring;

impl LaneForce<6> for Spring {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, t: V, _m: [V; 6], eta: [V; 6], mut sum: [V; 6]) -> [V; 6] {
        sum[2] = sum[2] + t.constant(-0.5) * eta[3];
        sum
    }
}

#[test]
fn bad_input_is_refused_on_se3() {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).unwrap();
    let momentum = Covector::<f64, 6>::from([0.5, -0.25, 1.0, 1.0, 0.5, -0.5]);
    let start = State { time: 0.0, momentum, attitude: Matrix::<f64, 4>::identity() };
    let mut method = VariationalSe3::new(body.clone(), Spring, CayleySe3::new(), tableau("gauss-3")).unwrap();
    for h in [f64::NAN, f64::INFINITY] {
        let mut state = start.clone();
        assert!(matches!(method.step(&mut state, h), Err(StepError::NotFinite { .. })));
        assert_eq!(state, start);
    }
    let mut state = start.clone();
    state.attitude[(1, 3)] = f64::NAN;
    assert!(matches!(method.step(&mut state, 0.1), Err(StepError::NotFinite { .. })));
    let mut state = start.clone();
    method.step(&mut state, 0.0).unwrap();
    assert!(distance(&state, &start) <= 4.0 * U);
    let nine = VariationalSe3::new(body.clone(), Free, CayleySe3::new(), tableau("gauss-9"));
    assert_eq!(nine.unwrap_err().stages, 9);
    let cayley = CayleySe3::new();
    let algebra = cayley.algebra().clone();
    let bracket: AnyForce<f64, 6> = DoubleBracket::new(algebra, body.clone(), 1.0).unwrap().into();
    assert_eq!(se3::Terms::new(&bracket).unwrap_err().force, "double bracket");

    let mut solver = AdaptiveSe3::new(body.clone(), Spring);
    for (span, tolerance) in
        [(f64::NAN, 1e-8), (f64::INFINITY, 1e-8), (1.0, 0.0), (1.0, f64::NAN), (1.0, 2.0), (1.0, -1.0)]
    {
        let mut state = start.clone();
        assert!(matches!(solver.solve(&mut state, span, tolerance), Err(SolveError::BadInput { .. })));
        assert_eq!(state, start);
    }
    let mut state = start.clone();
    assert_eq!(solver.solve(&mut state, 0.0, 1e-8).unwrap().steps, 0);
    solver.solve(&mut state, 1.0, 1e-8).unwrap();
    solver.solve(&mut state, -1.0, 1e-8).unwrap();
    assert!(distance(&state, &start) < 1e-7);
    // At rest, and from rest.
    let rest = State { momentum: Covector::zeros(), ..start.clone() };
    let mut state = rest.clone();
    assert_eq!(solver.solve(&mut state, 5.0, 1e-8).unwrap().steps, 1);
    assert_eq!((state.momentum, state.attitude, state.time), (rest.momentum, rest.attitude, 5.0));
    let load = se3::Terms(vec![se3::Term::Constant([0.0, 0.0, 0.0, 3.0, 0.0, 0.0])]);
    let mut solver = AdaptiveSe3::new(body.clone(), load);
    let mut state = rest.clone();
    solver.solve(&mut state, 2.0, 1e-10).unwrap();
    assert!((state.momentum[3] - 6.0).abs() < 1e-9 && (state.attitude[(0, 3)] - 2.0).abs() < 1e-9, "{state:?}");
    // What no step can keep.
    let mut solver = AdaptiveSe3::new(body, se3::Terms(vec![se3::Term::Constant([f64::MAX; 6])]));
    let mut state = start.clone();
    let error = solver.solve(&mut state, 1.0, 1e-8).unwrap_err();
    assert!(matches!(error, SolveError::Stuck { .. } | SolveError::Tolerance { .. }), "{error}");
    assert_eq!(state, start);
}
