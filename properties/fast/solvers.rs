//! The solvers that choose order and steps for a tolerance.

use super::{after, damping, distance, on, own, reach, relaxation, rigid, submerged, tableau, unforced};
use euler_poincare::algebra::{Covector, Entry, Matrix, Vector};
use euler_poincare::group::MatrixGroup;
use euler_poincare::integrators::lanes::{ByLane, Drag, FastRetraction, LaneForce, Term, Terms, VariationalInLanes};
use euler_poincare::integrators::se3::CayleySe3;
use euler_poincare::integrators::solve::{Event, InLanes, Progress, SolveError};
use euler_poincare::integrators::{Solve, State};
use euler_poincare::mechanics::Force;
use euler_poincare::mechanics::force::LinearDrag;
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::retraction::{Cayley, CayleySo3, ExponentialSo3, Retraction};
use euler_poincare::scalar::Scalar;
use std::ops::ControlFlow;

/// What makes no sense; no time; forth and back; rest.
fn judges_its_input<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize>(
    solver: impl Fn() -> Solve<'static, f64, N, D, InLanes<F, R, N, D>>,
    start: &State<f64, N, D>,
) {
    for (span, tolerance) in
        [(f64::NAN, 1e-8), (f64::INFINITY, 1e-8), (1.0, 0.0), (1.0, f64::NAN), (1.0, 2.0), (1.0, -1.0)]
    {
        let mut state = start.clone();
        let refused = on(&mut solver().tolerance(tolerance), &mut state, span);
        assert!(matches!(refused, Err(SolveError::BadInput { .. })));
        assert_eq!(&state, start);
    }
    let (mut state, mut solver) = (start.clone(), solver());
    assert_eq!(on(&mut solver, &mut state, 0.0).unwrap().steps, 0);
    on(&mut solver, &mut state, 1.0).unwrap();
    on(&mut solver, &mut state, -1.0).unwrap();
    assert!(distance(&state, start) < 1e-7);
    let rest = State { momentum: Covector::zeros(), ..start.clone() };
    let mut state = rest.clone();
    assert_eq!(on(&mut solver, &mut state, 5.0).unwrap().steps, 1);
    assert_eq!((state.momentum, state.attitude, state.time), (rest.momentum, rest.attitude, 5.0));
}

#[test]
fn bad_input_is_refused() {
    let (body, start) = rigid();
    judges_its_input(|| Solve::in_lanes(body.clone(), damping(1.0), CayleySo3::new()), &start);
    let (vessel, afloat) = submerged();
    judges_its_input(|| Solve::in_lanes(vessel.clone(), own(0.125, 0.0), CayleySe3::new()), &afloat);
}

/// A load that switches on faster than any step resolves cannot be integrated to the tolerance: an error, no wrong answer.
#[test]
fn what_cannot_be_kept_is_an_error() {
    fn is_too_much<const N: usize, const D: usize>(state: &State<f64, N, D>, start: &State<f64, N, D>, e: SolveError) {
        assert!(matches!(e, SolveError::Stuck { .. } | SolveError::Tolerance { .. }), "{e}");
        assert_eq!(state, start);
    }
    let ((body, start), (vessel, afloat)) = (rigid(), submerged());
    let (torque, load) =
        (Terms(vec![Term::Constant([f64::MAX, 0.0, 0.0])]), Terms(vec![Term::Constant([f64::MAX; 6])]));
    let (mut spun, mut swum) = (start.clone(), afloat.clone());
    let error = reach(body, torque, CayleySo3::new(), &mut spun, 1.0, 1e-8).unwrap_err();
    is_too_much(&spun, &start, error);
    let error = reach(vessel, load, CayleySe3::new(), &mut swum, 1.0, 1e-8).unwrap_err();
    is_too_much(&swum, &afloat, error);
}

/// Backward in time a quadratic drag drives the motion, to infinity in a finite time: Ω(t) = Ω(0)/(1 + Ω(0) t √D³/I).
#[test]
fn a_motion_that_runs_away_is_followed_until_it_cannot_be() {
    let body = Quadratic::diagonal([3.0, 0.25, 0.25]).unwrap();
    let drag = Terms(vec![Term::QuadraticDrag(Drag::Full([[0.0; 3], [0.0; 3], [0.0, 0.0, 0.25]]))]);
    let start = State::at_identity(Covector::<f64, 3>::new(0.0, 0.0, 0.25));
    let mut state = start.clone();
    let error = reach(body, drag, CayleySo3::new(), &mut state, -4.0, 1e-3).unwrap_err();
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
    reach(ball, force, CayleySo3::new(), &mut state, 2.0, 1e-9).unwrap();
    let error = state.momentum[2] - 1.0 - (1.0 - 2f64.cos());
    assert!(error.abs() < 1e-8, "{error:e}");
}

/// 1000 units of time of the relaxed body: attitude, free Casimir and energy.
#[test]
fn a_long_run_stays_on_the_group() {
    let (lagrangian, start) = rigid();
    let off = |state: &State<f64, 3, 3>| (state.attitude.transpose() * state.attitude - Matrix::identity()).amax();
    let mut worst: f64 = 0.0;
    let mut solve =
        Solve::in_lanes(lagrangian.clone(), relaxation(0.1), CayleySo3::new()).tolerance(1e-10).observe(|state| {
            worst = worst.max(off(state));
            ControlFlow::Continue(())
        });
    let solution = solve.run(&start, 1000.0).unwrap();
    assert!(solution.statistics.steps < 500, "{:?}", solution.statistics);
    drop(solve);
    let mut casimir: f64 = 0.0;
    let mut solve = Solve::in_lanes(lagrangian, unforced(), CayleySo3::new()).tolerance(1e-10).observe(|state| {
        worst = worst.max(off(state));
        casimir = casimir.max((state.momentum.norm_squared() - start.momentum.norm_squared()).abs());
        ControlFlow::Continue(())
    });
    solve.run(&start, 1000.0).unwrap();
    drop(solve);
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
        let solved = reach(spinning.clone(), unforced(), CayleySo3::new(), &mut turned, 100.0, 1e-10).unwrap();
        let mut posed = afloat.clone();
        posed.attitude.fixed_view_mut::<3, 3>(0, 0).copy_from(&crooked(size));
        let swum = reach(swimming.clone(), load.clone(), CayleySe3::new(), &mut posed, 50.0, 1e-10).unwrap();
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
    let solved = reach(body, terms, CayleySe3::new(), &mut state, 10.0, 1e-10).unwrap();
    assert!(distance(&state, &reference) < 1e-10, "{:e}", distance(&state, &reference));
    assert!(solved.steps <= 16, "{solved:?}");
}

/// A constant force, from rest.
#[test]
fn what_is_at_rest_is_set_in_motion() {
    let (body, start) = submerged();
    let load = Terms(vec![Term::Constant([0.0, 0.0, 0.0, 3.0, 0.0, 0.0])]);
    let mut state = State { momentum: Covector::zeros(), ..start };
    reach(body, load, CayleySe3::new(), &mut state, 2.0, 1e-10).unwrap();
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
            let terms = Terms(terms.clone());
            let solved = reach(body.clone(), terms, CayleySe3::new(), &mut state, span, tolerance).unwrap();
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
        let mut state = start.clone();
        let solved = reach(body.clone(), terms, CayleySo3::new(), &mut state, span, tolerance).unwrap();
        let turn = (angle(&state) - turned).rem_euclid(std::f64::consts::TAU);
        let error = (state.momentum[2] - end).abs().max(turn.min(std::f64::consts::TAU - turn));
        assert!(error <= 16.0 * tolerance, "{error:e} at {tolerance:e}: {solved:?}");
    }
}

/// Backward, linear drag drives a body to ever faster rotation: there is no end of steps.
#[test]
fn a_run_without_end_is_refused() {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let mut solver = Solve::in_lanes(body, Terms(vec![Term::LinearDrag(ONE)]), CayleySo3::new()).max_steps(1000);
    let start = State::at_identity(Covector::<f64, 3>::new(0.5, 0.25, 1.0));
    let mut state = start.clone();
    let error = on(&mut solver, &mut state, -200.0).unwrap_err();
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
            (reach(body.clone(), unforced(), CayleySo3::new(), &mut one, 10.0, 1e-8).unwrap(), one),
            (reach(body, unforced(), general, &mut other, 10.0, 1e-8).unwrap(), other),
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

/// Saved states, dense output, events and the work of the force are those of steps taken one stage after the other; backward, too.
fn agrees_within<F, G, R, const N: usize, const D: usize>(
    (body, force, listed, retraction): (Quadratic<f64, N>, F, G, R),
    start: &State<f64, N, D>,
    end: f64,
) where
    F: Force<f64, N>,
    G: LaneForce<N, D>,
    R: FastRetraction<N, D>,
{
    let times: Vec<f64> = (1..40).map(|k| end * f64::from(k) / 40.0).collect();
    let crosses = |state: &State<f64, N, D>| state.momentum[1] - 0.125;
    let right = Solve::new(body.clone(), force, retraction.clone()).tolerance(1e-12);
    let mut right = right.save_at(times.clone()).event(Event::new(crosses));
    let expected = right.run(start, end).unwrap();
    for tolerance in [1e-5, 1e-8, 1e-11] {
        let lanes = Solve::in_lanes(body.clone(), listed.clone(), retraction.clone()).tolerance(tolerance);
        let mut lanes = lanes.save_at(times.clone()).dense().event(Event::new(crosses));
        let found = lanes.run(start, end).unwrap();
        let off = |a: &State<f64, N, D>, b: &State<f64, N, D>| distance(a, b) / (4.0 * tolerance);
        assert!(found.saved.len() == times.len() && !expected.events.is_empty(), "{:?}", expected.events);
        for (k, (a, b)) in found.saved.iter().zip(&expected.saved).enumerate() {
            assert!(off(a, b) < 1.0, "{tolerance:e}, {}: {}, {:?}", times[k], off(a, b), found.statistics);
            assert_eq!(&found.at(times[k]).unwrap(), a);
        }
        assert_eq!(found.events.len(), expected.events.len());
        for (a, b) in found.events.iter().zip(&expected.events) {
            assert!(off(&a.state, &b.state) < 16.0 && a.rising == b.rising, "{tolerance:e}: {a:?}, {b:?}");
        }
        // On from an event, with the step that was reached.
        let first = &found.events[0].state;
        let mut again = Solve::in_lanes(body.clone(), listed.clone(), retraction.clone()).tolerance(tolerance);
        again = again.first_step(found.next_step).max_step(end.abs() / 16.0);
        let later = again.run(first, end).unwrap();
        assert!(off(&later.state, &expected.state) < 4.0 && later.statistics.steps >= 12, "{:?}", later.statistics);
    }
    // What the energy has taken up.
    let energy = |state: &State<f64, N, D>| {
        let m: Vec<f64> = state.momentum.iter().copied().collect();
        let eta = body.inverse() * Vector::<f64, N>::from_column_slice(&m);
        0.5 * state.momentum.iter().zip(eta.iter()).map(|(m, v)| m * v).sum::<f64>()
    };
    let mut worst = 0.0;
    let follow = |progress: &Progress<'_, f64, N, D>| {
        worst = f64::max(worst, (energy(progress.state) - energy(start) - progress.work).abs());
        ControlFlow::Continue(())
    };
    let lanes = Solve::in_lanes(body.clone(), listed, retraction).tolerance(1e-10).save_at(times);
    lanes.follow(follow).run(start, end).unwrap();
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
fn all_that_lies_within_steps_is_there() {
    let (vessel, afloat) = submerged();
    let drag = LinearDrag::new(Matrix::from_diagonal_element(0.125)).unwrap();
    let listed = Terms(vec![Term::LinearDrag(Drag::Diagonal([0.125; 6]))]);
    agrees_within((vessel, drag, listed, CayleySe3::new()), &afloat, 6.0);
    let (body, start) = rigid();
    let drag = LinearDrag::<f64, 3>::new(Matrix::from_diagonal_element(0.125)).unwrap();
    let plane: Cayley<f64, 3, 3, _> = Cayley::new(MatrixGroup::from_entry(&Entry::Se2).unwrap()).unwrap();
    let listed = || Terms(vec![Term::LinearDrag(Drag::Diagonal([0.125; 3]))]);
    let moved = State { momentum: Covector::<f64, 3>::new(0.5, 0.5, -0.25), ..start.clone() };
    agrees_within((body.clone(), drag.clone(), listed(), plane), &moved, -5.0);
    agrees_within((body, drag, listed(), CayleySo3::new()), &start, 12.0);
}

/// A motion that is nearly steady is followed within its steps, too.
#[test]
fn a_steady_rotation_is_there_at_any_time() {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let start = State::at_identity(Covector::<f64, 3>::new(0.0, 0.0, 2.0));
    let mut solve = Solve::in_lanes(body, damping(1.0), CayleySo3::new()).tolerance(1e-10);
    assert_eq!(solve.run(&start, 100.0).unwrap().statistics.steps, 1);
    let solution = solve.dense().run(&start, 100.0).unwrap();
    for time in [0.3, 7.0, 55.5, 99.0] {
        let turned = ExponentialSo3::<f64>::new().tau(&Vector::<f64, 3>::new(0.0, 0.0, 2.0 * time)).unwrap();
        assert!((solution.at(time).unwrap().attitude - turned).amax() < 1e-8, "{time}");
    }
}

/// A jump is found wherever it is, and the tolerance kept.
#[test]
fn a_jump_of_a_force_is_passed() {
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let start = State::at_identity(Covector::<f64, 3>::new(0.0, 0.0, 1.0));
    for (k, size) in (1..40).flat_map(|k| [1.0, 1e-2, 1e-4].map(|size| (k, size))) {
        let time = 0.05 * f64::from(k) + 0.0137;
        for tolerance in [1e-4, 1e-7, 1e-10] {
            let kick = ByLane(Kick(time, size));
            let mut solve = Solve::in_lanes(body.clone(), kick, CayleySo3::new()).tolerance(tolerance);
            let solution = solve.run(&start, 2.0).unwrap();
            let error = (solution.state.momentum[2] - 1.0 - size * (2.0 - time).max(0.0)).abs();
            assert!(error <= tolerance, "{size} at {time}, {tolerance:e}: {error:e}, {:?}", solution.statistics);
        }
    }
}

/// From a time on, a torque of this size about the third axis.
#[derive(Clone)]
struct Kick(f64, f64);

impl Force<f64, 3> for Kick {
    fn force<S: Scalar<Base = f64>>(&self, t: S, _: &Vector<S, 3>) -> Covector<S, 3> {
        let on = if t.base() >= self.0 { S::exact(self.1) } else { S::zero() };
        Covector::<S, 3>::new(S::zero(), S::zero(), on)
    }
}
