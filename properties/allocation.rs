//! A step allocates nothing: counted by the allocator itself, in a test target of its own.

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::group::{LieGroup, MatrixGroup, So3};
use euler_poincare::integrators::derivative::{Gradient, Linearised, Variation};
use euler_poincare::integrators::lanes::{Drag, Term, Terms, VariationalInLanes};
use euler_poincare::integrators::se3::CayleySe3;
use euler_poincare::integrators::so3::{EnsembleSo3, Member, QuaternionSo3, QuaternionState};
use euler_poincare::integrators::solve::{Event, Solve};
use euler_poincare::integrators::variational::Settings;
use euler_poincare::integrators::{Classical, Doubled, DoubledState, MuntheKaas, OneStep, Solver, State, Variational};
use euler_poincare::mechanics::doubled::Forced;
use euler_poincare::mechanics::equations::EulerPoincare;
use euler_poincare::mechanics::force::{AnyForce, DoubleBracket, LinearDrag, QuadraticDrag};
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Quadratic, Quartic};
use euler_poincare::mechanics::models::landau_lifshitz_gilbert;
use euler_poincare::retraction::{AnyRetraction, Cayley, CayleySo3, Exponential, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Dd, Real};
use euler_poincare::tableau::{Classic, Family, Tableau};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

/// Steps that are counted, after the first.
const STEPS: usize = 8;

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, counting per thread.
struct Counting;

// SAFETY: every call is passed on to the system's allocator unchanged; the counter is a plain thread-local cell.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.with(|n| n.set(n.get() + 1));
        // SAFETY: the caller's contract is the system allocator's.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's contract is the system allocator's.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

fn allocations(f: impl FnOnce()) -> usize {
    let before = ALLOCATIONS.with(Cell::get);
    f();
    ALLOCATIONS.with(Cell::get) - before
}

/// After a first time it allocates nothing. What fails says of what.
#[track_caller]
fn allocates_once(what: &str, mut take: impl FnMut()) {
    take();
    assert_eq!(allocations(|| (0..STEPS).for_each(|_| take())), 0, "{what}");
}

#[test]
fn a_step_with_its_derivative_allocates_nothing() {
    let drag = LinearDrag::new(Matrix::<f64, 3>::from_diagonal_element(0.1)).unwrap();
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let mut method = Linearised::new(Variational::new(body, drag, CayleySo3::new(), gauss(2)), ());
    let momentum = Covector::<f64, 3>::new(0.4, 0.1, 0.7);
    let mut state = State::at_identity(momentum);
    let mut variation = Variation { momentum, ..Variation::zero() };
    allocates_once("a linearised step", || {
        let (_, step) = method.step(&mut state, 0.1).unwrap();
        variation = step.tangent(&variation, 0.0, 0.0, &[]).unwrap();
        step.adjoint(&Gradient { momentum: momentum.transpose(), ..Gradient::zero() }).unwrap();
    });
}

#[test]
fn the_counter_counts() {
    assert!(allocations(|| drop(std::hint::black_box(vec![1u8; 100]))) > 0);
}

/// Steps after a first one, each from a copy of `start` if `again`, else one after the other, allocate nothing; the solvers are as wanted.
#[track_caller]
fn allocates_nothing<T: Real, const N: usize, const D: usize>(
    method: &mut impl OneStep<T, N, D>,
    start: &State<T, N, D>,
    h: T,
    again: bool,
    wanted: fn(Solver) -> bool,
) {
    let mut state = start.clone();
    allocates_once(T::NAME, || {
        if again {
            state = start.clone();
        }
        let solver = method.step(&mut state, h).expect("every step succeeds").solver;
        assert!(wanted(solver), "{solver:?} {}", T::NAME);
    });
}

const FIXED_POINT: fn(Solver) -> bool = |solver| solver == Solver::FixedPoint;
const NEWTON: fn(Solver) -> bool = |solver| solver == Solver::Newton;
const ANY: fn(Solver) -> bool = |_| true;

type Body<T> = EulerPoincare<T, 3, AnyLagrangian<T, 3>, AnyForce<T, 3>>;

fn body<T: Real>() -> (Body<T>, State<T, 3, 3>) {
    let model = landau_lifshitz_gilbert::<T>();
    (model.system, State::at_identity(model.momentum))
}

fn gauss<T: Real>(stages: usize) -> Tableau<T> {
    Family::Gauss.tableau(stages).unwrap()
}

/// Longer runs with a tolerance allocate as often as short ones: once for the engine, and not by steps, events or refused pairs.
#[test]
fn steps_with_a_tolerance_allocate_nothing() {
    let (system, state) = body::<f64>();
    let event = Event::new(|state: &State<f64, 3, 3>| state.momentum[0] + 1e3);
    let mut solve = Solve::new(&system.lagrangian, &system.force, CayleySo3::new()).tolerance(1e-8).event(event);
    let mut run = |end: f64| {
        let mut steps = 0;
        let allocated = allocations(|| steps = solve.run(&state, end).expect("a solution").statistics.steps);
        (allocated, steps)
    };
    run(1.0);
    let (short, long) = (run(1.0), run(20.0));
    assert!(long.1 > 4 * short.1 && long.0 == short.0, "{short:?} {long:?}");
}

fn so3_fixed_point<T: Real>(retraction: impl Retraction<T, 3, 3>) {
    let (system, state) = body::<T>();
    for family in [Family::Gauss, Family::LobattoIIIA, Family::LobattoIIIB, Family::RadauIIA] {
        for stages in 2..=3 {
            let tableau = family.tableau::<T>(stages).unwrap();
            let mut method = Variational::new(&system.lagrangian, &system.force, &retraction, tableau);
            allocates_nothing(&mut method, &state, T::ratio(1, 16), false, FIXED_POINT);
        }
    }
}

#[test]
fn fixed_point_iterations_on_so3_allocate_nothing() {
    so3_fixed_point::<f64>(CayleySo3::new());
    so3_fixed_point::<f64>(ExponentialSo3::new());
    so3_fixed_point::<Dd>(CayleySo3::new());
    so3_fixed_point::<Dd>(ExponentialSo3::new());
}

#[test]
fn munthe_kaas_and_the_classical_method_allocate_nothing() {
    let (system, state) = body::<f64>();
    let explicit: fn(Solver) -> bool = |solver| solver == Solver::Explicit;
    for (tableau, wanted) in [(Classic::Rk4.tableau(), explicit), (Family::Gauss.tableau(2), FIXED_POINT)] {
        let mut method = MuntheKaas::new(system.clone(), ExponentialSo3::new(), tableau.unwrap());
        allocates_nothing(&mut method, &state, 0.0625, false, wanted);
    }
    for tableau in [Family::Gauss.tableau(3), Classic::Rk4.tableau()] {
        let mut method = Classical::new(system.clone(), Some(So3::new()), tableau.unwrap());
        allocates_nothing(&mut method, &state, 0.0625, false, ANY);
    }
}

/// Just before the fold of the first step fixed-point iterations do not contract.
fn near_the_fold<T: Real>(retraction: impl Retraction<T, 3, 3>, max_iterations: usize) {
    let (system, state) = body::<T>();
    let tableau = Family::LobattoIIIA.tableau::<T>(2).unwrap();
    let settings = Settings { max_iterations, ..Settings::default() };
    let mut method = Variational::with_settings(&system.lagrangian, &system.force, &retraction, tableau, settings);
    allocates_nothing(&mut method, &state, T::ratio(79, 100), true, |solver| solver == Solver::Continuation);
}

#[test]
fn newton_and_continuation_allocate_nothing() {
    near_the_fold::<f64>(CayleySo3::new(), 12);
    near_the_fold::<f64>(CayleySo3::new(), 6);
    near_the_fold::<Dd>(CayleySo3::new(), 12);
}

#[test]
fn the_fast_paths_of_so3_allocate_nothing() {
    let (system, start) = body::<f64>();
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let force = Terms::new(&system.force, &lagrangian, CayleySo3::new().algebra()).unwrap();
    let heavy = Terms([force.0.clone(), vec![Term::Gravity(1.0, [0.25, 0.0, 0.5])]].concat());
    for (stages, force) in (1..=8).flat_map(|stages| [(stages, &force), (stages, &heavy)]) {
        let (body, tableau) = (&lagrangian, gauss(stages));
        let mut one = VariationalInLanes::new(body.clone(), force.clone(), CayleySo3::new(), tableau.clone()).unwrap();
        let mut other = VariationalInLanes::new(body.clone(), force.clone(), ExponentialSo3::new(), tableau).unwrap();
        allocates_nothing(&mut one, &start, 0.0625, false, ANY);
        allocates_nothing(&mut other, &start, 0.0625, false, ANY);
    }
    // Newton's method behind it.
    let tableau = Family::LobattoIIIA.tableau(2).unwrap();
    let mut method = VariationalInLanes::new(lagrangian.clone(), force.clone(), CayleySo3::new(), tableau).unwrap();
    allocates_nothing(&mut method, &start, 0.79, true, |solver| solver != Solver::FixedPoint);
    // The quaternion form, by fixed-point iterations and by Newton's method.
    let mut quaternions = QuaternionSo3::of(method);
    allocates_once("quaternions", || {
        let mut state = QuaternionState::from(start.clone());
        [0.79, 0.0625, 0.79, 0.0625].iter().for_each(|h| _ = quaternions.step(&mut state, *h).unwrap());
    });
    // A solver that chooses its steps, and an ensemble on this thread.
    for force in [&force, &heavy] {
        let mut solve = Solve::in_lanes(lagrangian.clone(), force.clone(), CayleySo3::new()).tolerance(1e-10);
        solve.run(&start, 1.0).unwrap();
        assert_eq!(allocations(|| _ = solve.run(&start, 20.0).unwrap()), 0);
    }
    let mut members = vec![Member { lagrangian, force, state: start }; 8];
    members[3].force = heavy;
    let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), gauss(2)).unwrap();
    let pool = |steps| {
        let ensemble = &mut ensemble;
        allocations(move || ensemble.advance(0.0625, steps).unwrap())
    };
    // What a call allocates does not depend on the number of steps.
    let calls = [8, 80, 800].map(pool);
    assert!(calls[1] == calls[2], "{calls:?}");
}

type Group<T> = MatrixGroup<T, 6, 4>;

fn vessel<T: Real>() -> (Group<T>, AnyLagrangian<T, 6>, AnyForce<T, 6>, State<T, 6, 4>) {
    let group = Group::<T>::from_entry(&Entry::Se3).unwrap();
    let inertia = [(1, 2), (2, 1), (1, 1), (3, 1), (3, 2), (5, 4)].map(|(p, q)| T::ratio(p, q));
    let lagrangian = AnyLagrangian::from(Quadratic::diagonal(inertia).unwrap());
    let terms = vec![
        LinearDrag::new(Matrix::from_diagonal_element(T::ratio(1, 8))).unwrap().into(),
        QuadraticDrag::new(Matrix::from_diagonal_element(T::ratio(1, 4))).unwrap().into(),
        DoubleBracket::new(group.algebra().clone(), lagrangian.clone(), T::ratio(1, 4)).unwrap().into(),
    ];
    let momentum = Covector::from([(1, 2), (-1, 4), (1, 1), (1, 1), (1, 2), (-1, 2)].map(|(p, q)| T::ratio(p, q)));
    (group, lagrangian, AnyForce::Sum(terms), State::at_identity(momentum))
}

#[test]
fn the_fast_paths_of_se3_allocate_nothing() {
    let (.., start) = vessel::<f64>();
    let lagrangian = Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25]).unwrap();
    let [linear, quadratic] = [0.125, 0.25].map(|d| Drag::Diagonal([d; 6]));
    let force = Terms(vec![Term::LinearDrag(linear), Term::QuadraticDrag(quadratic)]);
    for stages in 1..=8 {
        let (lagrangian, force) = (lagrangian.clone(), force.clone());
        let mut method = VariationalInLanes::new(lagrangian, force, CayleySe3::new(), gauss(stages)).unwrap();
        allocates_nothing(&mut method, &start, 0.0625, false, FIXED_POINT);
    }
    // Newton's method behind it.
    let settings = Settings { max_fixed_point_iterations: 1, ..Settings::default() };
    let (body, load) = (lagrangian.clone(), force.clone());
    let mut method = VariationalInLanes::with_settings(body, load, CayleySe3::new(), gauss(2), settings).unwrap();
    allocates_nothing(&mut method, &start, 0.0625, false, NEWTON);
    // A solver that chooses its steps.
    let mut solve = Solve::in_lanes(lagrangian, force, CayleySe3::new()).tolerance(1e-10);
    solve.run(&start, 1.0).unwrap();
    assert_eq!(allocations(|| _ = solve.run(&start, 20.0).unwrap()), 0);
}

fn general_algebra<T: Real>(settings: Settings<T>, wanted: fn(Solver) -> bool) {
    let (group, lagrangian, force, state) = vessel::<T>();
    let cayley = AnyRetraction::Cayley(Cayley::new(group.clone()).unwrap());
    for retraction in [cayley, AnyRetraction::Exponential(Exponential::of_group(group))] {
        let mut method = Variational::with_settings(&lagrangian, &force, &retraction, gauss(2), settings);
        allocates_nothing(&mut method, &state, T::ratio(1, 16), false, wanted);
    }
}

#[test]
fn a_general_algebra_allocates_nothing() {
    general_algebra::<f64>(Settings::default(), FIXED_POINT);
    general_algebra::<Dd>(Settings::default(), FIXED_POINT);
    general_algebra::<f64>(Settings { max_fixed_point_iterations: 1, ..Settings::default() }, NEWTON);
}

#[test]
fn a_lagrangian_without_closed_form_allocates_nothing() {
    let (system, state) = body::<f64>();
    let lagrangian = Quartic::new(Matrix::from_diagonal(&Vector::from([0.5, 2.0, 1.0])), 0.25).unwrap();
    let mut method = Variational::new(&lagrangian, &system.force, CayleySo3::new(), gauss(2));
    allocates_nothing(&mut method, &state, 1.0 / 16.0, false, ANY);
}

#[test]
fn the_doubled_scheme_allocates_nothing() {
    fn check<T: Real, const N: usize, const D: usize>(
        retraction: impl Retraction<T, N, D>,
        lagrangian: &AnyLagrangian<T, N>,
        force: &AnyForce<T, N>,
        start: &State<T, N, D>,
    ) {
        let forced = Forced::new(lagrangian, force, &retraction);
        let mut method = Doubled::new(gauss(2), &retraction, forced);
        let mut state = DoubledState::unit(start.time, start.momentum);
        state.attitudes = Some((Matrix::identity(), Matrix::identity()));
        allocates_once(&format!("{} {}", retraction.name(), T::NAME), || {
            method.step(&mut state, T::ratio(1, 16)).expect("every step succeeds");
        });
    }
    let (system, state) = body::<f64>();
    check(CayleySo3::new(), &system.lagrangian, &system.force, &state);
    check(ExponentialSo3::new(), &system.lagrangian, &system.force, &state);
    let (group, lagrangian, force, state) = vessel::<f64>();
    check(Exponential::of_group(group.clone()), &lagrangian, &force, &state);
    check(Cayley::new(group).unwrap(), &lagrangian, &force, &state);
}
