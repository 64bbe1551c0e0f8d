//! The solvers that choose order and steps for a tolerance.

use super::{after, damping, distance, own, relaxation, rigid, submerged, tableau, unforced};
use euler_poincare::algebra::{Covector, Entry, Matrix, Vector};
use euler_poincare::group::MatrixGroup;
use euler_poincare::integrators::State;
use euler_poincare::integrators::lanes::{AdaptiveInLanes, Drag, Solved, Term, Terms, VariationalInLanes};
use euler_poincare::integrators::se3::CayleySe3;
use euler_poincare::integrators::so3::AdaptiveSo3;
use euler_poincare::integrators::solve::SolveError;
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::{Cayley, ExponentialSo3, Retraction};

/// A solver on one body.
type Solve<'s, const N: usize, const D: usize> =
    &'s mut dyn FnMut(&mut State<f64, N, D>, f64, f64) -> Result<Solved, SolveError>;

/// What makes no sense; no time; forth and back; rest.
fn judges_its_input<const N: usize, const D: usize>(solve: Solve<N, D>, start: &State<f64, N, D>) {
    for (span, tolerance) in
        [(f64::NAN, 1e-8), (f64::INFINITY, 1e-8), (1.0, 0.0), (1.0, f64::NAN), (1.0, 2.0), (1.0, -1.0)]
    {
        let mut state = start.clone();
        assert!(matches!(solve(&mut state, span, tolerance), Err(SolveError::BadInput { .. })));
        assert_eq!(&state, start);
    }
    let mut state = start.clone();
    assert_eq!(solve(&mut state, 0.0, 1e-8).unwrap().steps, 0);
    solve(&mut state, 1.0, 1e-8).unwrap();
    solve(&mut state, -1.0, 1e-8).unwrap();
    assert!(distance(&state, start) < 1e-7);
    let rest = State { momentum: Covector::zeros(), ..start.clone() };
    let mut state = rest.clone();
    assert_eq!(solve(&mut state, 5.0, 1e-8).unwrap().steps, 1);
    assert_eq!((state.momentum, state.attitude, state.time), (rest.momentum, rest.attitude, 5.0));
}

#[test]
fn bad_input_is_refused() {
    let (body, start) = rigid();
    let mut solver = AdaptiveSo3::new(body, damping(1.0));
    judges_its_input(&mut |state, span, tolerance| solver.solve(state, span, tolerance), &start);
    let (vessel, afloat) = submerged();
    let mut solver = AdaptiveInLanes::new(vessel, own(0.125, 0.0), CayleySe3::new());
    judges_its_input(&mut |state, span, tolerance| solver.solve(state, span, tolerance), &afloat);
}

/// A load that switches on faster than any step resolves cannot be integrated to the tolerance: an error, no wrong answer.
fn is_too_much<const N: usize, const D: usize>(solve: Solve<N, D>, start: &State<f64, N, D>) {
    let mut state = start.clone();
    let error = solve(&mut state, 1.0, 1e-8).unwrap_err();
    assert!(matches!(error, SolveError::Stuck { .. } | SolveError::Tolerance { .. }), "{error}");
    assert_eq!(&state, start);
}

#[test]
fn what_cannot_be_kept_is_an_error() {
    let (body, start) = rigid();
    let mut solver = AdaptiveSo3::new(body, Terms(vec![Term::Constant([f64::MAX, 0.0, 0.0])]));
    is_too_much(&mut |state, span, tolerance| solver.solve(state, span, tolerance), &start);
    let (vessel, afloat) = submerged();
    let mut solver = AdaptiveInLanes::new(vessel, Terms(vec![Term::Constant([f64::MAX; 6])]), CayleySe3::new());
    is_too_much(&mut |state, span, tolerance| solver.solve(state, span, tolerance), &afloat);
}

/// Backward in time a quadratic drag drives the motion, to infinity in a finite time: Ω(t) = Ω(0)/(1 + Ω(0) t √D³/I).
#[test]
fn a_motion_that_runs_away_is_followed_until_it_cannot_be() {
    let body = Quadratic::diagonal([3.0, 0.25, 0.25]).unwrap();
    let drag = Terms(vec![Term::QuadraticDrag(Drag::Full([[0.0; 3], [0.0; 3], [0.0, 0.0, 0.25]]))]);
    let start = State::at_identity(Covector::<f64, 3>::new(0.0, 0.0, 0.25));
    let mut state = start.clone();
    let error = AdaptiveSo3::new(body, drag).solve(&mut state, -4.0, 1e-3).unwrap_err();
    assert!(matches!(error, SolveError::Stuck { .. } | SolveError::Tolerance { .. }), "{error}");
    // It is all over at t = −2.
    assert!(state.momentum[2] > 100.0 * start.momentum[2] && state.time < -1.9, "{state:?}");
}

/// A torque that vanishes at the start of a steady rotation; from rest, see `integrators/rest.rs`.
#[test]
fn what_is_steady_now_need_not_stay_so() {
    let ball = Quadratic::diagonal([1.0; 3]).unwrap();
    // M' = sin t about the axis of M.
    let force = Terms(vec![Term::Periodic([0.0, 0.0, 1.0], 1.0, -std::f64::consts::FRAC_PI_2)]);
    let mut state = State::at_identity(Covector::<f64, 3>::new(0.0, 0.0, 1.0));
    AdaptiveSo3::new(ball, force).solve(&mut state, 2.0, 1e-9).unwrap();
    let error = state.momentum[2] - 1.0 - (1.0 - 2f64.cos());
    assert!(error.abs() < 1e-8, "{error:e}");
}

/// 1000 units of time of the relaxed body: attitude, free Casimir and energy.
#[test]
fn a_long_run_stays_on_the_group() {
    let (lagrangian, start) = rigid();
    let mut worst: f64 = 0.0;
    let mut see = |state: &State<f64, 3, 3>| {
        worst = worst.max((state.attitude.transpose() * state.attitude - Matrix::identity()).amax());
    };
    let mut solver = AdaptiveSo3::new(lagrangian.clone(), relaxation(0.1));
    let mut state = start.clone();
    let solved = solver.solve_with(&mut state, 1000.0, 1e-10, |state, _| see(state)).unwrap();
    assert!(solved.steps < 500, "{solved:?}");
    let mut solver = AdaptiveSo3::new(lagrangian, unforced());
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

/// What rounding makes of gᵀg is taken back; what is not rounding is the caller's, and stays.
#[test]
fn a_crooked_attitude_stays_crooked() {
    let excess = |rotation: &Matrix<f64, 3>| (rotation.transpose() * rotation - Matrix::identity()).norm();
    let crooked = |size: f64| {
        Matrix::<f64, 3>::identity() + Matrix::<f64, 3>::new(0.0, size, 0.0, 0.0, size, 0.0, 0.0, 0.0, -size)
    };
    let (spinning, start) = rigid();
    let (swimming, afloat) = submerged();
    let load = Terms(vec![Term::Constant([0.0, 0.0, 1.0, 0.0, 0.0, 0.0])]);
    for size in [1e-6, 1e-13] {
        let mut turned = State { attitude: crooked(size), ..start.clone() };
        let before = excess(&turned.attitude);
        let solved = AdaptiveSo3::new(spinning.clone(), unforced()).solve(&mut turned, 100.0, 1e-10).unwrap();
        let mut posed = afloat.clone();
        posed.attitude.fixed_view_mut::<3, 3>(0, 0).copy_from(&crooked(size));
        let swum = AdaptiveInLanes::new(swimming.clone(), load.clone(), CayleySe3::new())
            .solve(&mut posed, 50.0, 1e-10)
            .unwrap();
        assert!(solved.steps > 32 && swum.steps > 32, "{solved:?} {swum:?}");
        for after in [excess(&turned.attitude), excess(&posed.attitude.fixed_view::<3, 3>(0, 0).into_owned())] {
            let kept = if size > 1e-12 { before } else { 0.0 };
            assert!((after - kept).abs() < 1e-14, "{size:e}: {before:e}, {after:e}");
        }
    }
}

/// π(10), p(10) of the body in a fluid, to ten digits in a few steps.
#[test]
fn a_body_in_a_fluid_is_solved_in_a_few_steps() {
    let (body, start) = submerged();
    let drags = [Term::LinearDrag(Drag::Diagonal([0.125; 6])), Term::QuadraticDrag(Drag::Diagonal([0.25; 6]))];
    let terms = Terms(drags.to_vec());
    let fine = VariationalInLanes::new(body.clone(), terms.clone(), CayleySe3::new(), tableau("gauss-8")).unwrap();
    let reference = after(fine, &start, 0.05, 200);
    let mut state = start;
    let solved = AdaptiveInLanes::new(body, terms, CayleySe3::new()).solve(&mut state, 10.0, 1e-10).unwrap();
    assert!(distance(&state, &reference) < 1e-10, "{:e}", distance(&state, &reference));
    assert!(solved.steps <= 16, "{solved:?}");
}

/// A constant force, from rest.
#[test]
fn what_is_at_rest_is_set_in_motion() {
    let (body, start) = submerged();
    let load = Terms(vec![Term::Constant([0.0, 0.0, 0.0, 3.0, 0.0, 0.0])]);
    let mut state = State { momentum: Covector::zeros(), ..start };
    AdaptiveInLanes::new(body, load, CayleySe3::new()).solve(&mut state, 2.0, 1e-10).unwrap();
    assert!((state.momentum[3] - 6.0).abs() < 1e-9 && (state.attitude[(0, 3)] - 2.0).abs() < 1e-9, "{state:?}");
}

/// Quadratic drag along one axis, in which δ vanishes: a load, how long, and the momentum and the way at the end.
fn slowed() -> [(f64, f64, f64, f64); 2] {
    let quarter = std::f64::consts::FRAC_PI_4;
    [
        // p' = −p|p|: p = 1/(1 + t), x = ln(1 + t).
        (0.0, 20.0, 1.0 / 21.0, 21f64.ln()),
        // p' = −p|p| − 1: through rest, where |p| has a kink; p = tan(π/4 − t) until then, p = −tanh(t − π/4) from then on.
        (-1.0, 2.0, -(2.0 - quarter).tanh(), -quarter.cos().ln() - (2.0 - quarter).cosh().ln()),
    ]
}

/// What keeps the error along straight motions is how stage values decay.
#[test]
fn straight_motions_keep_the_tolerance_too() {
    let body = Quadratic::diagonal([1.0; 6]).unwrap();
    let surge = |v: f64| [0.0, 0.0, 0.0, v, 0.0, 0.0];
    let start = State::at_identity(Covector::from(surge(1.0)));
    for (load, span, p, x) in slowed() {
        let drag = Term::QuadraticDrag(Drag::Diagonal([1.0; 6]));
        let terms = if load == 0.0 { vec![drag] } else { vec![drag, Term::Constant(surge(load))] };
        for tolerance in [1e-4, 1e-7, 1e-10] {
            let mut state = start.clone();
            let mut solver = AdaptiveInLanes::new(body.clone(), Terms(terms.clone()), CayleySe3::new());
            let solved = solver.solve(&mut state, span, tolerance).unwrap();
            let error = (state.momentum[3] - p).abs().max((state.attitude[(0, 3)] - x).abs());
            assert!(error <= 16.0 * tolerance, "{load}: {error:e} at {tolerance:e}: {solved:?}");
        }
    }
}

const ONE: Drag<3> = Drag::Full([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);

/// Spin about a principal axis: δ vanishes along it, unless the force does, too.
#[test]
fn spin_about_an_axis_keeps_the_tolerance_too() {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let start = State::at_identity(Covector::<f64, 3>::new(0.0, 0.0, 1.0));
    let angle = |state: &State<f64, 3, 3>| state.attitude[(1, 0)].atan2(state.attitude[(0, 0)]);
    for (digits, (load, span, end, turned)) in (6..25).flat_map(|digits| slowed().map(|run| (digits, run))) {
        let tolerance = 10f64.powf(-0.5 * f64::from(digits));
        let terms = Terms(vec![Term::QuadraticDrag(ONE), Term::Constant([0.0, 0.0, load])]);
        let mut solver = AdaptiveSo3::new(body.clone(), terms);
        let mut state = start.clone();
        let solved = solver.solve(&mut state, span, tolerance).unwrap();
        let turn = (angle(&state) - turned).rem_euclid(std::f64::consts::TAU);
        let error = (state.momentum[2] - end).abs().max(turn.min(std::f64::consts::TAU - turn));
        assert!(error <= 16.0 * tolerance, "{error:e} at {tolerance:e}: {solved:?}");
    }
}

/// Backward, linear drag drives a body to ever faster rotation: there is no end of steps.
#[test]
fn a_run_without_end_is_refused() {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let mut solver = AdaptiveSo3::new(body, Terms(vec![Term::LinearDrag(ONE)])).with_max_steps(1000);
    let start = State::at_identity(Covector::<f64, 3>::new(0.5, 0.25, 1.0));
    let mut state = start.clone();
    let error = solver.solve(&mut state, -200.0, 1e-8).unwrap_err();
    assert!(matches!(error, SolveError::TooManySteps { steps: 1000, .. }), "{error}");
    assert!(state.time < -1.0 && state.momentum.norm() > start.momentum.norm(), "the state is that of the last step");
}

/// What an error of the momentum makes of the velocity counts: R(t) = exp(t L) exp(t ω₁ (1 − I₁) e₁) with I₂ = I₃ = 1. The report says how much,
/// also where rounding alone is more than the tolerance.
#[test]
fn the_error_about_a_light_axis_is_seen() {
    for light in [1e-2, 1e-4, 1e-8] {
        let (spin, body) = (3.0, Quadratic::diagonal([light, 1.0, 1.0]).unwrap());
        let start = State::at_identity(Covector::<f64, 3>::new(light * spin, 1.0, 0.5));
        let turn = |x: Vector<f64, 3>| ExponentialSo3::<f64>::new().tau(&x).unwrap();
        let exact =
            turn(start.momentum.transpose() * 10.0) * turn(Vector::<f64, 3>::x() * (spin * (1.0 - light) * 10.0));
        let [mut one, mut other] = [start.clone(), start.clone()];
        let general = Cayley::new(MatrixGroup::from_entry(&Entry::So3).unwrap()).unwrap();
        let ends = [
            (AdaptiveSo3::new(body.clone(), unforced()).solve(&mut one, 10.0, 1e-8).unwrap(), one),
            (AdaptiveInLanes::new(body, unforced(), general).solve(&mut other, 10.0, 1e-8).unwrap(), other),
        ];
        for (solved, end) in ends {
            let error = (end.attitude - exact).amax();
            // Off by as many tolerances as it has turned by radians.
            let turned = 10.0 * Vector::<f64, 3>::new(spin, 1.0, 0.5).norm();
            assert!(error <= turned * solved.error, "{light:e}: {error:e}, {solved:?}");
            assert!(error < 1e-7 || light < 1e-6, "{light:e}: {error:e}");
        }
    }
}
