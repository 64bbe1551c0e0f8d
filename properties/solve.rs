//! Properties of `integrators::solve`: the tolerance, jumps, stiff and singular motions, dense output, events, structure, and input that makes no sense.

use euler_poincare::algebra::{Covector, Entry, Matrix, Vector};
use euler_poincare::group::MatrixGroup;
use euler_poincare::integrators::solve::{DenseError, End, Event, Moment, Pairs, Solution, Solve, SolveError};
use euler_poincare::integrators::{OneStep, State, StepError, Variational};
use euler_poincare::mechanics::Force;
use euler_poincare::mechanics::configuration::Configuration;
use euler_poincare::mechanics::force::LinearDrag;
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::models::landau_lifshitz_gilbert;
use euler_poincare::retraction::{Exponential, Retraction};
use euler_poincare::scalar::{Dd, Real, Scalar};
use euler_poincare::tableau::{Classic, Family};
use std::cell::Cell;
use std::f64::consts::PI;
use std::ops::ControlFlow;
use std::sync::Arc;

thread_local! {
    static EVALUATIONS: Cell<usize> = const { Cell::new(0) };
}

/// The forces of the tests, in one type so that the solver is compiled once for a scalar.
#[derive(Clone, Copy)]
enum Torque {
    None,
    /// M × (M × Ω) with M = diag(1/2, 2, 1) Ω.
    Damping,
    /// −diag(d, 1/10, 3/10) η + (1/10, 1/5, 3/10).
    Drag(f64),
    /// The torque −(13/10) r × gᵀe₃ of a weight at r = (3/10, 0, 1/2).
    Weight,
    /// A jump from 1 to −1 at this time.
    Jump(f64),
    /// As `Damping`, and from this time on (1, −1, 1) times this size.
    Kicked(f64, f64),
    /// √(1 − t): not a number beyond 1.
    Root,
    /// η²: a momentum of 1 is infinite after a time of 1.
    Square,
}

impl<T: Real> Force<T, 3> for Torque {
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, 3>) -> Covector<S, 3> {
        EVALUATIONS.with(|n| n.set(n.get() + 1));
        let all = |value: S| Covector::from([value; 3]);
        match self {
            Self::Damping | Self::Kicked(..) => {
                let m = Vector::<S, 3>::new(eta[0] * S::half(), eta[1] * S::int(2), eta[2]);
                let kick = match self {
                    Self::Kicked(time, size) if t.base() >= T::exact(*time) => S::exact(*size),
                    _ => S::zero(),
                };
                m.cross(&m.cross(eta)).transpose() + Covector::from([kick, -kick, kick])
            }
            Self::Drag(d) => Covector::from([
                S::ratio(1, 10) - S::exact(*d) * eta[0],
                S::ratio(1, 5) - eta[1] * S::ratio(1, 10),
                S::ratio(3, 10) * (S::one() - eta[2]),
            ]),
            Self::Jump(time) => all(if t.base() < T::exact(*time) { S::one() } else { -S::one() }),
            Self::Root => all((S::one() - t).sqrt()),
            Self::Square => eta.map(|v| v * v).transpose(),
            Self::None | Self::Weight => Covector::zeros(),
        }
    }

    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, 3>) -> Covector<S, 3> {
        let Self::Weight = self else { return self.force(t, eta) };
        let up = Vector::<S, 3>::new(g.entry(2, 0), g.entry(2, 1), g.entry(2, 2));
        let at = Vector::<S, 3>::new(S::ratio(3, 10), S::zero(), S::half());
        at.cross(&up).transpose() * -S::ratio(13, 10)
    }

    fn uses_configuration(&self) -> bool {
        matches!(self, Self::Weight)
    }

    fn is_zero(&self) -> bool {
        matches!(self, Self::None)
    }
}

type Three<T> = Exponential<T, 3, 3>;

fn group(entry: Entry) -> Three<f64> {
    Exponential::of_group(MatrixGroup::from_entry(&entry).unwrap())
}

fn so3() -> Three<f64> {
    group(Entry::So3)
}

/// (ℝ₊)³ as diagonal matrices: abelian, so that the momentum is a pure quadrature.
fn abelian() -> Three<f64> {
    let basis = |k: usize| Matrix::<f64, 3>::from_fn(|r, c| f64::from(u8::from(r == k && c == k)));
    Exponential::of_group(MatrixGroup::new([0, 1, 2].map(basis)).unwrap())
}

fn body<T: Real>() -> Quadratic<T, 3> {
    Quadratic::diagonal([T::half(), T::int(2), T::one()]).unwrap()
}

/// A solver of a body with a force.
type Shared<'a> = Solve<'a, f64, 3, 3, Pairs<f64, 3, 3, Arc<Quadratic<f64, 3>>, Arc<Torque>, Arc<Three<f64>>>>;

/// A symmetric body: μ₁ + iμ₂ turns at the rate 1/2 where μ₃ = 1.
fn turning<'a>() -> Shared<'a> {
    Solve::new(Quadratic::diagonal([1.0, 1.0, 2.0]).unwrap(), Torque::None, so3())
}

fn first(state: &State<f64, 3, 3>) -> f64 {
    state.momentum[0]
}

fn state<const N: usize, const D: usize>(momentum: [f64; N]) -> State<f64, N, D> {
    State::at_identity(Covector::<f64, N>::from_fn(|_, k| momentum[k]))
}

fn spun() -> State<f64, 3, 3> {
    state([0.4, 0.1, 0.7])
}

/// How far one state is from another, relative to its size.
fn distance<const N: usize, const D: usize>(x: &State<f64, N, D>, y: &State<f64, N, D>, size: f64) -> f64 {
    let attitude = (x.attitude - y.attitude).amax() / y.attitude.amax();
    ((x.momentum - y.momentum).amax() / size).max(attitude)
}

/// The tolerance, at the end and at times between the steps, against steps of a twelfth order method that are short.
fn check<const N: usize, const D: usize, F: Force<f64, N>, R: Retraction<f64, N, D>>(
    name: &str,
    (lagrangian, force, retraction): (&Quadratic<f64, N>, &F, &R),
    start: &State<f64, N, D>,
    span: f64,
) {
    const STEPS: usize = 60;
    let gauss = Family::Gauss.tableau(6).unwrap();
    let mut method = Variational::new(lagrangian, force, retraction, gauss);
    let mut grid = vec![start.clone()];
    for k in 0..STEPS {
        let mut next = grid[k].clone();
        method.step(&mut next, span / STEPS as f64).unwrap();
        grid.push(next);
    }
    let size = grid.iter().fold(0.0, |size: f64, state| size.max(state.momentum.amax()));
    for tolerance in [1e-5, 1e-8, 1e-11] {
        let mut solve = Solve::of(lagrangian, force, retraction).tolerance(tolerance).dense();
        let solution = solve.run(start, span).unwrap();
        let error = distance(&solution.state, &grid[STEPS], size);
        assert!(error < tolerance, "{name} at {tolerance:e}: {error:e}");
        assert!(solution.statistics.error < tolerance, "{name}: {:?}", solution.statistics);
        for k in 0..40 {
            let time = span * (0.618_033_988_75 * f64::from(k)).fract();
            let near = (time / span * STEPS as f64) as usize;
            let mut wanted = grid[near].clone();
            method.step(&mut wanted, time - near as f64 * (span / STEPS as f64)).unwrap();
            let error = distance(&solution.at(time).unwrap(), &wanted, size);
            assert!(error < 3.0 * tolerance, "{name} at {tolerance:e}, t = {time}: {error:e}");
        }
    }
}

#[test]
fn the_tolerance_is_kept() {
    check("weight", (&body(), &Torque::Weight, &so3()), &spun(), 3.0);
    let inertia = Quadratic::diagonal([1.0, 2.0, 3.0, 2.0, 2.0, 2.5]).unwrap();
    let drag = LinearDrag::new(Matrix::<f64, 6>::from_diagonal_element(0.1)).unwrap();
    let se3: Exponential<f64, 6, 4> = Exponential::of_group(MatrixGroup::from_entry(&Entry::Se3).unwrap());
    check("se3", (&inertia, &drag, &se3), &state([0.5, 0.4, -1.0, 2.0, 0.0, 0.6]), 2.0);
}

#[test]
fn the_end_is_known_for_landau_lifshitz_gilbert() {
    let model = landau_lifshitz_gilbert::<f64>();
    let start = State::at_identity(model.momentum);
    for (tolerance, family) in [
        (1e-4, Family::Gauss),
        (1e-12, Family::Gauss),
        (1e-7, Family::LobattoIIIA),
        (1e-7, Family::LobattoIIIB),
        (1e-7, Family::RadauIIA),
    ] {
        let mut solve = Solve::new(body(), Torque::Damping, so3()).tolerance(tolerance).family(family);
        let solution = solve.run(&start, 1.0).unwrap();
        let error = (solution.state.momentum - model.reference_momentum().unwrap()).amax();
        assert!(error < tolerance, "{family:?} at {tolerance:e}: {error:e}");
    }
    // Ralston's method has order 3 as a Runge–Kutta method and 2 here.
    for classic in [Classic::Rk4, Classic::Ralston3] {
        let tableau = classic.tableau().unwrap();
        let mut solve = Solve::new(body(), Torque::Damping, so3()).tolerance(1e-5).tableau(tableau);
        let error = (solve.run(&start, 1.0).unwrap().state.momentum - model.reference_momentum().unwrap()).amax();
        assert!(error < 1e-5 && error > 1e-9, "{classic:?}: {error:e}");
    }
}

#[test]
fn thirty_two_digits() {
    let model = landau_lifshitz_gilbert::<Dd>();
    let start = State::at_identity(model.momentum);
    let so3: Three<Dd> = Exponential::of_group(MatrixGroup::from_entry(&Entry::So3).unwrap());
    let mut solve = Solve::new(body(), Torque::Damping, so3).tolerance(Dd::exact(1e-26)).dense();
    let solution = solve.run(&start, model.horizon).unwrap();
    let error = (solution.state.momentum - model.reference_momentum().unwrap()).amax().to_f64();
    assert!(error < 1e-26 && solution.statistics.steps < 20, "{error:e} {:?}", solution.statistics);
    // |M|² is kept by this force.
    let between = solution.at(Dd::ratio(1, 3)).unwrap().momentum.norm_squared() - Dd::ratio(5, 8);
    assert!(between.to_f64().abs() < 1e-26, "{between:e}");
}

#[test]
fn without_a_force_casimirs_and_the_group_are_kept_at_every_time() {
    let mut solve = Solve::new(body(), Torque::None, so3()).tolerance(1e-4).dense();
    let solution = solve.run(&spun(), 20.0).unwrap();
    let casimir = spun().momentum.norm();
    for k in 0..=50 {
        let state = solution.at(0.4 * f64::from(k)).unwrap();
        assert!((state.momentum.norm() - casimir).abs() < 1e-14);
        assert!((state.attitude.transpose() * state.attitude - Matrix::<f64, 3>::identity()).amax() < 1e-13);
    }
}

#[test]
fn stiff_drag_takes_long_steps() {
    for stiff in [1e2, 1e4] {
        let run = |tolerance: f64| {
            let mut solve = Solve::new(body(), Torque::Drag(stiff), so3()).tolerance(tolerance).dense();
            solve.run(&spun(), 2.0).unwrap()
        };
        let (loose, tight) = (run(1e-6), run(1e-9));
        assert!(loose.statistics.steps < 400, "{stiff}: {:?}", loose.statistics);
        let error = distance(&loose.state, &tight.state, 1.0);
        assert!(error < 2e-6, "{stiff}: {error:e}");
        for k in 1..20 {
            let time = 0.1 * f64::from(k);
            let error = distance(&loose.at(time).unwrap(), &tight.at(time).unwrap(), 1.0);
            assert!(error < 3e-6, "{stiff} at {time}: {error:e}");
        }
    }
}

/// Next to the start, the middle and the end of a pair no stage knows of a jump.
#[test]
fn a_jump_of_the_force_is_passed() {
    let abelian = abelian();
    for tolerance in [1e-5, 1e-7, 1e-9] {
        for k in 0..48 {
            let time = (f64::from(k) + 0.01) / 48.0;
            let solution = Solve::new(body(), Torque::Jump(time), &abelian)
                .tolerance(tolerance)
                .run(&state([0.0; 3]), 1.0)
                .unwrap();
            let error = (solution.state.momentum[0] - (2.0 * time - 1.0)).abs();
            assert!(error < tolerance, "{time} {tolerance}: {error}");
            assert!(solution.statistics.steps + 2 * solution.statistics.rejected < 600, "{:?}", solution.statistics);
        }
    }
}

/// Jumps of a force that moves, by every kind of nodes, forward and backward; and two runs, up to a jump and on from it, take no more
/// steps than without one.
#[test]
fn jumps_of_a_motion_are_passed() {
    let gauss = |tolerance: f64, torque| Solve::new(body(), torque, so3()).tolerance(tolerance);
    let never = Torque::Kicked(f64::INFINITY, 1.0);
    for (k, size) in [1.0, -0.5, 0.03125].into_iter().cycle().take(24).enumerate() {
        let time = 0.05 + 0.08 * k as f64;
        let (torque, always) = (Torque::Kicked(time, size), Torque::Kicked(-9.0, size));
        let (first, second, from, to) = if k % 2 == 0 { (never, always, 0.0, 2.0) } else { (always, never, 2.0, 0.0) };
        let start = State { time: from, ..spun() };
        let until = gauss(1e-11, first).run(&start, time).unwrap().state;
        let wanted = gauss(1e-11, second).run(&until, to).unwrap().state;
        let tableaux = [Family::Gauss.tableau(4), Family::RadauIIA.tableau(4), Family::LobattoIIIA.tableau(5)];
        for (tableau, tolerance) in tableaux.into_iter().zip([1e-6, 1e-7, 1e-8]) {
            let solution = gauss(tolerance, torque).tableau(tableau.unwrap()).run(&start, to).unwrap();
            let error = distance(&solution.state, &wanted, wanted.momentum.amax());
            assert!(error < tolerance, "{size} at {time}, {tolerance}: {error}");
        }
        let (mut split, mut smooth) = (gauss(1e-8, torque), gauss(1e-8, first));
        let parts = [split.run(&start, time).unwrap(), smooth.run(&start, time).unwrap()];
        let [split, smooth] = parts.map(|solution| solution.statistics.steps + 2 * solution.statistics.rejected);
        assert!(split <= smooth + 2, "{size} until {time}: {split} steps, {smooth} without the jump");
    }
}

/// A motion that ends in finite time: the error says where, at the least step.
#[test]
fn a_motion_that_runs_away_is_an_error() {
    let abelian = abelian();
    let start = state([1.0; 3]);
    for (stages, tolerance) in [(2, 1e-5), (4, 1e-8)] {
        let tableau = Family::Gauss.tableau(stages).unwrap();
        let failure = Solve::new(Quadratic::diagonal([1.0; 3]).unwrap(), Torque::Square, &abelian)
            .tolerance(tolerance)
            .tableau(tableau)
            .run(&start, 2.0)
            .unwrap_err();
        let (SolveError::Tolerance { time, step, .. } | SolveError::Stuck { time, step, .. }) = failure.error else {
            panic!("{failure}")
        };
        // μ' = μ² from 1: 1/(1 − t).
        assert!((time - 1.0).abs() < 1e-3 && step > 1e-15, "{failure}");
    }
}

#[test]
fn backward_is_forward() {
    let mut solve = Solve::new(body(), Torque::Damping, so3()).tolerance(1e-10).save_at([3.0, 0.5, -1.0]).dense();
    let begin = State { time: 4.0, ..spun() };
    let back = solve.run(&begin, -1.0).unwrap();
    let times: Vec<f64> = back.saved.iter().map(|state| state.time).collect();
    assert_eq!((times, back.state.time), (vec![3.0, 0.5, -1.0], -1.0));
    assert!(back.next_step < 0.0 && distance(&back.at(0.5).unwrap(), &back.saved[1], 1.0) < 1e-15);
    let again = solve.save_at([]).run(&back.state, 4.0).unwrap();
    // Damping makes the way back grow.
    assert!(distance(&again.state, &begin, 1.0) < 1e-8);
}

/// μ₁ = cos(t/2) and μ₂ = ± sin(t/2).
#[test]
fn events_are_located_to_the_tolerance() {
    let start = state([1.0, 0.0, 1.0]);
    for tolerance in [1e-5, 1e-9] {
        let mut solve = turning()
            .tolerance(tolerance)
            .event(Event::new(first))
            .event(Event::new(|state: &State<f64, 3, 3>| state.momentum[1]))
            .event(Event::new(first).rising())
            .event(Event::new(|state: &State<f64, 3, 3>| state.momentum[1] * state.momentum[1] + 1.0));
        let solution = solve.run(&start, 20.0).unwrap();
        let found: Vec<_> = solution.events.iter().map(|located| (located.event, located.state.time)).collect();
        // Zeros of the cosine at π, 3π, 5π; of the sine at 2π, 4π, 6π, but not at the start; rising at 3π.
        let wanted = [(0, 1.0), (1, 2.0), (0, 3.0), (2, 3.0), (1, 4.0), (0, 5.0), (1, 6.0)];
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        for (k, (event, multiple)) in wanted.into_iter().enumerate() {
            let pair = [2, 3].contains(&k);
            assert!(found[k].0 == event || pair, "{found:?}");
            assert!((found[k].1 - multiple * PI).abs() < 20.0 * tolerance, "{found:?}");
        }
        assert!(!solution.events[0].rising);
    }
}

#[test]
fn events_end_a_run_that_can_go_on_from_there() {
    let mut solve = turning()
        .tolerance(1e-9)
        .save_at([1.0, 3.0, 4.0])
        .event(Event::new(first).terminal())
        .event(Event::new(|state: &State<f64, 3, 3>| state.time - 3.1));
    let first = solve.run(&state([1.0, 0.0, 1.0]), 10.0).unwrap();
    assert_eq!((first.end, first.saved.len(), first.events.len()), (End::Event(0), 2, 2));
    assert!((first.events[0].state.time - 3.1).abs() < 1e-8 && first.events[0].event == 1);
    assert_eq!(first.state, first.events[1].state);
    let second = solve.save_at([]).first_step(first.next_step).run(&first.state, 20.0).unwrap();
    assert!((second.state.time - 3.0 * PI).abs() < 1e-7, "{}", second.state.time);
}

/// However long the run is, and wherever the zero lies in its step.
#[test]
fn an_event_is_located_to_the_tolerance_times_the_step() {
    for (tolerance, end) in [(1e-4, 1e5), (1e-6, 50.0), (1e-12, 50.0)] {
        for k in 1..24 {
            // μ₁ = cos(t/2 + φ).
            let phase = 0.06 * f64::from(k);
            let start = state([phase.cos(), phase.sin(), 1.0]);
            let event = Event::new(first).terminal();
            let solution = turning().tolerance(tolerance).event(event).run(&start, end);
            let (found, zero) = (solution.unwrap().state.time, PI - 2.0 * phase);
            assert!((found - zero).abs() < 8.0 * tolerance, "{tolerance} {phase}: {found} for {zero}");
        }
    }
}

/// Where a function changes its sign through infinity it has no zero.
#[test]
fn a_pole_is_no_event() {
    for retreat in 0..8 {
        let shift = 0.11 * f64::from(retreat);
        let mut solve = turning()
            .event(Event::new(move |state: &State<f64, 3, 3>| 1.0 / (state.time - 1.0 - shift)).terminal())
            .event(Event::new(|state: &State<f64, 3, 3>| 1e6 * (state.time - 2.5)));
        let solution = solve.run(&state([1.0, 0.0, 1.0]), 4.0).unwrap();
        assert!(solution.end == End::Time && solution.events.len() == 1, "{:?}", solution.events);
    }
}

/// A zero at the start does not count, and the next one does, in the same step, too.
#[test]
fn a_zero_at_the_start_hides_no_other() {
    let along = |zero: f64| move |state: &State<f64, 3, 3>| state.time * (zero - state.time);
    for zero in [0.05, 0.3, -0.05, -0.3] {
        let mut solve = turning()
            .event(Event::new(along(zero)))
            .event(Event::new(along(zero)).rising())
            .event(Event::new(|state: &State<f64, 3, 3>| state.time))
            .event(Event::new(|state: &State<f64, 3, 3>| state.time.powi(3)))
            .event(Event::new(|_: &State<f64, 3, 3>| 0.0));
        let solution = solve.run(&state([1.0, 0.0, 1.0]), 4.0 * zero.signum()).unwrap();
        let found: Vec<_> = solution.events.iter().map(|located| (located.event, located.rising)).collect();
        // In both directions the function is above 0 until there.
        assert_eq!(found, [(0, false)]);
        assert!((solution.events[0].state.time - zero).abs() < 1e-8);
    }
}

/// A run that ends within a step does not ask for values beyond.
#[test]
fn a_terminal_event_comes_before_a_function_without_a_value() {
    let mut solve = turning()
        .event(Event::new(|state: &State<f64, 3, 3>| (3.0 - state.time).sqrt()))
        .event(Event::new(|state: &State<f64, 3, 3>| state.time - 2.999).terminal());
    let solution = solve.run(&state([1.0, 0.0, 1.0]), 4.0).unwrap();
    assert!(solution.end == End::Event(1) && (solution.state.time - 2.999).abs() < 1e-8);
}

#[test]
fn any_number_of_stages_has_states_between_its_steps() {
    for stages in [1, 31, 32, 33, 64] {
        let gauss = Family::Gauss.tableau(stages).unwrap();
        let mut solve = turning().tolerance(1e-6).tableau(gauss).dense();
        let solution = solve.run(&state([1.0, 0.0, 1.0]), 1.0).unwrap();
        assert!((solution.at(0.3).unwrap().momentum[0] - 0.15f64.cos()).abs() < 1e-6, "{stages}");
    }
}

/// What has passed zero where a run ends is told: a run that goes on from there does not see it.
#[test]
fn events_at_the_place_of_a_terminal_one_are_told() {
    let later = |state: &State<f64, 3, 3>| state.momentum[0] + 1e-3;
    let mut solve = turning()
        .event(Event::new(first).terminal())
        .event(Event::new(first))
        .event(Event::new(first).rising())
        .event(Event::new(later));
    let solution = solve.run(&state([1.0, 0.0, 1.0]), 10.0).unwrap();
    let found: Vec<usize> = solution.events.iter().map(|located| located.event).collect();
    assert_eq!((solution.end, found), (End::Event(0), vec![0, 1]));
    assert!(solution.events.iter().all(|located| located.state == solution.state));
}

#[test]
fn a_first_step_of_no_length_is_the_least_one() {
    let start = State { time: 1.0, ..spun() };
    let wanted = Solve::new(body(), Torque::Damping, so3()).run(&start, 2.0).unwrap().state;
    for step in [0.0, 1e-17, -1e-300] {
        let mut solve = Solve::new(body(), Torque::Damping, so3()).first_step(step).save_at([1.0, 1.5, 2.0]).dense();
        let solution = solve.run(&start, 2.0).unwrap();
        assert!(solution.saved.len() == 3 && distance(&solution.state, &wanted, 1.0) < 1e-8, "{step}");
    }
    // A run that the time hardly shows, and one of no length, after which another goes on.
    let end = 1.0 + f64::EPSILON;
    let mut solve = Solve::new(body(), Torque::Damping, so3()).save_at([end]).dense();
    assert_eq!(solve.run(&start, end).unwrap().saved.len(), 1);
    let nothing = solve.save_at([]).run(&start, 1.0).unwrap();
    let solution = Solve::new(body(), Torque::Damping, so3()).first_step(nothing.next_step).run(&start, 2.0).unwrap();
    assert_eq!((nothing.state, solution.state), (start, wanted));
}

#[test]
fn a_state_is_saved_once() {
    let solution = Solve::new(body(), Torque::Damping, so3()).save_at([0.0, 1.0]).every(1).run(&spun(), 1.0).unwrap();
    assert!(solution.saved.windows(2).all(|pair| pair[0].time < pair[1].time), "{:?}", solution.saved);
    assert_eq!(solution.saved.len(), 1 + solution.statistics.steps);
}

/// Saved states and events come in the order of time, and none after the first at which the run is broken off.
#[test]
fn the_follower_ends_a_run_at_once() {
    let times: Vec<f64> = (1..=100).map(|k| 0.04 * f64::from(k)).collect();
    for (most, end) in [(3, End::Stopped), (usize::MAX, End::Event(0))] {
        let mut seen = Vec::new();
        let solve = turning()
            .save_at(times.clone())
            .event(Event::new(first).terminal())
            .event(Event::new(|state: &State<f64, 3, 3>| state.time - 0.05))
            .follow(|progress| {
                if progress.moment != Moment::Step {
                    seen.push((progress.moment, progress.state.clone()));
                }
                if seen.len() < most { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
            });
        let solution = solve.dense().run(&state([1.0, 0.0, 1.0]), 10.0).unwrap();
        assert_eq!(solution.end, end);
        assert!(seen.windows(2).all(|pair| pair[0].1.time <= pair[1].1.time));
        let (_, last) = seen.last().unwrap();
        assert_eq!(*last, solution.state);
        assert!(seen.len() == most || seen.len() == 80, "{}", seen.len());
        assert!(solution.at(0.5 * last.time).is_ok() && solution.at(last.time).is_ok());
    }
}

#[test]
fn an_event_function_that_is_not_finite_is_an_error_with_what_was_reached() {
    let function = |state: &State<f64, 3, 3>| (2.0 - state.time).sqrt();
    let mut solve = Solve::new(body(), Torque::None, so3()).every(1).dense().event(Event::new(function));
    let failure = solve.run(&spun(), 10.0).unwrap_err();
    assert!(matches!(failure.error, SolveError::EventValue { index: 0, value, .. } if value.is_nan()));
    let reached = failure.reached;
    assert!(reached.end == End::Failed && reached.state.time > 0.0 && reached.state.time <= 2.0);
    assert!(reached.at(0.5 * reached.state.time).is_ok() && reached.saved.last() == Some(&reached.state));
}

#[test]
fn the_observer_ends_a_run() {
    let mut seen = 0;
    let mut solve = Solve::new(body(), Torque::Damping, so3()).every(2).observe(|state| {
        seen += 1;
        if state.time > 5.0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let solution = solve.run(&spun(), 50.0).unwrap();
    drop(solve);
    assert!(solution.end == End::Stopped && solution.state.time > 5.0 && solution.state.time < 10.0);
    assert_eq!((seen, solution.saved.len()), (solution.statistics.steps, solution.statistics.steps / 2));
}

/// The evaluations of the force by a run, and its steps.
fn evaluations(solve: &mut Shared, span: f64) -> (usize, usize) {
    let before = EVALUATIONS.with(Cell::get);
    let steps = solve.run(&spun(), span).unwrap().statistics.steps;
    (EVALUATIONS.with(Cell::get) - before, steps)
}

#[test]
fn saving_costs_few_evaluations() {
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10] {
        let solve = || Solve::new(body(), Torque::Damping, so3()).tolerance(tolerance);
        let (without, steps) = evaluations(&mut solve(), 6.0);
        let times: Vec<f64> = (1..=steps).map(|k| 6.0 * (k as f64 - 0.3) / steps as f64).collect();
        let (with, again) = evaluations(&mut solve().save_at(times), 6.0);
        assert_eq!(steps, again);
        assert!(with * 5 <= without * 6, "{tolerance:e}: {with} and {without} evaluations in {steps} steps");
    }
}

#[test]
fn input_that_makes_no_sense_is_an_error() {
    let solve = || Solve::new(body(), Torque::Damping, so3());
    let error = |mut solve: Shared, end: f64| {
        let failure = solve.run(&spun(), end).unwrap_err();
        assert_eq!((&failure.reached.state, failure.reached.statistics.steps), (&spun(), 0));
        assert!(!failure.to_string().is_empty());
        failure.error
    };
    for tolerance in [f64::NAN, 0.0, -1e-3, 1.0, f64::INFINITY] {
        assert!(matches!(error(solve().tolerance(tolerance), 1.0), SolveError::BadInput { what: "the tolerance", .. }));
    }
    for bad in [f64::NAN, f64::INFINITY] {
        assert!(matches!(error(solve(), bad), SolveError::BadInput { what: "the end time", .. }));
        assert!(matches!(error(solve().first_step(bad), 1.0), SolveError::BadInput { .. }));
    }
    for step in [-1.0, 0.0, 1e-30] {
        assert!(matches!(error(solve().max_step(step), 1.0), SolveError::BadInput { what: "the largest step", .. }));
    }
    assert!(matches!(error(solve().every(0), 1.0), SolveError::BadInput { .. }));
    for (times, wanted) in
        [(vec![0.5, 0.2], 1), (vec![0.5, 0.5], 1), (vec![1.5], 0), (vec![-0.5], 0), (vec![0.1, f64::NAN], 1)]
    {
        let found = error(solve().save_at(times), 1.0);
        assert!(matches!(found, SolveError::SaveTime { index, .. } if index == wanted), "{found}");
    }
    for most in [0, 1] {
        assert!(matches!(error(solve().max_steps(most), 1.0), SolveError::TooManySteps { steps: 0, .. }));
    }
    let broken = State { momentum: Covector::<f64, 3>::new(f64::NAN, 0.0, 0.0), ..spun() };
    let failure = solve().run(&broken, 1.0).unwrap_err();
    assert!(matches!(failure.error, SolveError::Start { source: StepError::NotFinite { what: "the momentum" }, .. }));
}

#[test]
fn runs_without_a_duration_or_a_solution_end_in_order() {
    let mut solve = Solve::new(body(), Torque::Damping, so3()).save_at([0.0]).dense();
    let solution: Solution<_, 3, 3, _> = solve.run(&spun(), 0.0).unwrap();
    assert_eq!((solution.end, solution.statistics.steps, &solution.saved[..]), (End::Time, 0, &[spun()][..]));
    assert_eq!(solution.at(0.0).unwrap(), spun());
    assert!(matches!(solution.at(1.0), Err(DenseError::Outside { .. })));
    assert!(matches!(solution.at(f64::NAN), Err(DenseError::Outside { .. })));
    let plain = Solve::new(body(), Torque::Damping, so3()).run(&spun(), 1.0).unwrap();
    assert!(matches!(plain.at(0.5), Err(DenseError::NotKept)));
    // A rest is one pair of steps.
    let rest = Solve::new(body(), Torque::None, so3()).run(&state([0.0; 3]), 1e9).unwrap();
    assert_eq!((rest.statistics.steps, rest.state.momentum), (2, Covector::zeros()));
    // Beyond t = 1 there is no force.
    let failure = Solve::new(body(), Torque::Root, so3()).tolerance(1e-6).run(&spun(), 2.0).unwrap_err();
    assert!(failure.reached.state.time > 0.9 && failure.reached.state.time <= 1.0, "{}", failure.reached.state.time);
}
