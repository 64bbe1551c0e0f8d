//! What one step costs: every method on so(3), Runge–Kutta 4 by hand beside them, and a body in a fluid on se(3).

use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::group::{LieGroup, MatrixGroup};
use euler_poincare::integrators::so3::{AdaptiveSo3, Damping, EnsembleSo3, Member, VariationalSo3};
use euler_poincare::integrators::{OneStep, State, Variational};
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, QuadraticDrag};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::models::{Model, landau_lifshitz_gilbert, relaxed_rigid_body};
use euler_poincare::retraction::{Cayley, CayleySo3, Exponential, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Dd, Real, Scalar};
use euler_poincare::tableau::{Description, Tableau};
use std::hint::black_box;

type Group<'a> = BenchmarkGroup<'a, WallTime>;

/// Steps after which a run starts again from the initial state: the motion stays the same kind of motion.
const RUN: usize = 64;

/// A step in a run, started from the stages of the step before.
fn warm<T: Real, const N: usize, const D: usize>(
    group: &mut Group<'_>,
    name: &str,
    method: &mut impl OneStep<T, N, D>,
    start: &State<T, N, D>,
    h: T,
) {
    let (mut state, mut taken) = (start.clone(), 0);
    group.bench_function(name, |bencher| {
        bencher.iter(|| {
            if taken == RUN {
                (state, taken) = (start.clone(), 0);
            }
            taken += 1;
            method.step(black_box(&mut state), black_box(h)).expect("the step succeeds")
        });
    });
}

/// A first step: nothing is known of the stages.
fn cold<T: Real, const N: usize, const D: usize>(
    group: &mut Group<'_>,
    name: &str,
    method: &(impl OneStep<T, N, D> + Clone),
    start: &State<T, N, D>,
    h: T,
) {
    group.bench_function(name, |bencher| {
        bencher.iter_batched_ref(
            || (method.clone(), start.clone()),
            |(method, state)| method.step(black_box(state), black_box(h)).expect("the step succeeds"),
            BatchSize::SmallInput,
        );
    });
}

fn tableau<T: Real>(name: &str) -> Tableau<T> {
    let description: Description = name.parse().expect("the name of a tableau");
    description.build().expect("a tableau")
}

/// (M, R) of a rigid body with Landau–Lifshitz–Gilbert damping, M' = M×Ω + M×(M×Ω), R' = R Ω̂: plain arrays.
mod by_hand {
    use std::array::from_fn;

    pub type Body = ([f64; 3], [[f64; 3]; 3]);

    fn cross(x: [f64; 3], y: [f64; 3]) -> [f64; 3] {
        [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
    }

    fn rates((m, r): &Body, relaxed: bool) -> Body {
        let omega = [2.0 * m[0], 0.5 * m[1], m[2]];
        let turn = cross(*m, omega);
        let force = if relaxed { cross(turn, omega).map(|v| -0.1 * v) } else { cross(*m, turn) };
        (from_fn(|a| turn[a] + force[a]), from_fn(|row| cross(r[row], omega)))
    }

    fn moved((m, r): &Body, (dm, dr): &Body, h: f64) -> Body {
        (from_fn(|a| m[a] + h * dm[a]), from_fn(|row| from_fn(|c| r[row][c] + h * dr[row][c])))
    }

    /// A step of the classical Runge–Kutta method of order 4.
    pub fn rk4(body: &Body, h: f64, relaxed: bool) -> Body {
        let k1 = rates(body, relaxed);
        let k2 = rates(&moved(body, &k1, 0.5 * h), relaxed);
        let k3 = rates(&moved(body, &k2, 0.5 * h), relaxed);
        let k4 = rates(&moved(body, &k3, h), relaxed);
        let mean = |a: f64, b: f64, c: f64, d: f64| (a + 2.0 * (b + c) + d) / 6.0;
        let slope = (
            from_fn(|a| mean(k1.0[a], k2.0[a], k3.0[a], k4.0[a])),
            from_fn(|row| from_fn(|c| mean(k1.1[row][c], k2.1[row][c], k3.1[row][c], k4.1[row][c]))),
        );
        moved(body, &slope, h)
    }
}

fn rk4_by_hand(group: &mut Group<'_>, model: &Model<f64>, relaxed: bool) {
    let m = [model.momentum[0], model.momentum[1], model.momentum[2]];
    let start = (m, [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let (mut body, mut taken) = (start, 0);
    group.bench_function("rk4 by hand", |bencher| {
        bencher.iter(|| {
            if taken == RUN {
                (body, taken) = (start, 0);
            }
            taken += 1;
            body = by_hand::rk4(black_box(&body), black_box(0.1), relaxed);
        });
    });
}

fn initial<T: Real>(model: &Model<T>) -> State<T, 3, 3> {
    State { time: T::zero(), momentum: model.momentum, attitude: Matrix::identity() }
}

fn on_so3<T: Real, R>(model: &Model<T>, name: &str, retraction: R) -> impl OneStep<T, 3, 3> + Clone
where
    R: Retraction<T, 3, 3> + Clone,
{
    let system = &model.system;
    Variational::new(system.lagrangian.clone(), system.force.clone(), retraction, tableau(name))
}

/// "step/so3": Landau–Lifshitz–Gilbert damping, h = 1/10, with attitude.
fn so3(criterion: &mut Criterion) {
    let model = landau_lifshitz_gilbert::<f64>();
    let (start, h) = (initial(&model), 0.1);
    let mut group = criterion.benchmark_group("step/so3");
    rk4_by_hand(&mut group, &model, false);
    for name in
        ["gauss-1", "gauss-2", "gauss-3", "lobatto-iiia-2", "lobatto-iiia-3", "lobatto-iiib-2", "lobatto-iiib-3"]
    {
        let mut method = on_so3(&model, name, CayleySo3::new());
        warm(&mut group, &format!("{name} cayley"), &mut method, &start, h);
    }
    for name in ["gauss-2", "gauss-3"] {
        let mut method = on_so3(&model, name, ExponentialSo3::new());
        warm(&mut group, &format!("{name} exp"), &mut method, &start, h);
        cold(&mut group, &format!("{name} cayley, first step"), &on_so3(&model, name, CayleySo3::new()), &start, h);
    }
    let model = landau_lifshitz_gilbert::<Dd>();
    let mut method = on_so3(&model, "gauss-2", CayleySo3::new());
    warm(&mut group, "gauss-2 cayley, 32 digits", &mut method, &initial(&model), Scalar::ratio(1, 10));
    group.finish();
}

/// "step/so3 relaxed": the relaxed rigid body, h = 1/10, with attitude.
fn so3_relaxed(criterion: &mut Criterion) {
    let model = relaxed_rigid_body::<f64>();
    let mut group = criterion.benchmark_group("step/so3 relaxed");
    rk4_by_hand(&mut group, &model, true);
    for name in ["gauss-2", "gauss-3"] {
        let mut method = on_so3(&model, name, CayleySo3::new());
        warm(&mut group, &format!("{name} cayley"), &mut method, &initial(&model), 0.1);
    }
    group.finish();
}

fn in_a_fluid<T: Real>(group: &mut Group<'_>) {
    let se3 = MatrixGroup::<T, 6, 4>::from_entry(&Entry::Se3).expect("se(3) has dimension 6");
    let inertia = [(1, 2), (2, 1), (1, 1), (3, 1), (3, 2), (5, 4)].map(|(p, q)| T::ratio(p, q));
    let lagrangian = Quadratic::diagonal(inertia).expect("a regular inertia");
    let drag = |p, q| Matrix::from_diagonal_element(T::ratio(p, q));
    let force: AnyForce<T, 6> = AnyForce::Sum(vec![
        LinearDrag::new(drag(1, 8)).expect("finite").into(),
        QuadraticDrag::new(drag(1, 4)).expect("positive").into(),
    ]);
    let momentum = Covector::from([(1, 2), (-1, 4), (1, 1), (1, 1), (1, 2), (-1, 2)].map(|(p, q)| T::ratio(p, q)));
    let start = State { time: T::zero(), momentum, attitude: se3.identity() };
    let h = T::ratio(1, 10);
    let mut exponential = Variational::new(&lagrangian, &force, Exponential::of_group(se3.clone()), tableau("gauss-2"));
    warm(group, &format!("gauss-2 exp, {}", T::NAME), &mut exponential, &start, h);
    let cayley = Cayley::new(se3).expect("se(3) admits the Cayley map");
    let mut cayley = Variational::new(&lagrangian, &force, cayley, tableau("gauss-2"));
    warm(group, &format!("gauss-2 cayley, {}", T::NAME), &mut cayley, &start, h);
}

/// "step/se3": a rigid body with linear and quadratic drag, h = 1/10, with attitude.
fn se3(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("step/se3");
    in_a_fluid::<f64>(&mut group);
    in_a_fluid::<Dd>(&mut group);
    group.finish();
}

/// "step/so3 in lanes": the same step, all stages in one register.
fn so3_in_lanes(criterion: &mut Criterion) {
    let model = landau_lifshitz_gilbert::<f64>();
    let mut group = criterion.benchmark_group("step/so3 in lanes");
    for name in ["gauss-2", "gauss-4", "gauss-8", "lobatto-iiib-3"] {
        let body = Quadratic::diagonal([0.5, 2.0, 1.0]).expect("a regular inertia");
        let method = VariationalSo3::new(body.clone(), Damping(1.0), CayleySo3::new(), tableau(name));
        warm(&mut group, &format!("{name} cayley"), &mut method.expect("it fits"), &initial(&model), 0.1);
        let method = VariationalSo3::new(body, Damping(1.0), ExponentialSo3::new(), tableau(name));
        warm(&mut group, &format!("{name} exp"), &mut method.expect("it fits"), &initial(&model), 0.1);
    }
    group.finish();
}

/// "solve/so3": from a tolerance to an answer, with attitude.
fn solve(criterion: &mut Criterion) {
    let start = initial(&landau_lifshitz_gilbert::<f64>());
    let mut group = criterion.benchmark_group("solve/so3");
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).expect("a regular inertia");
    let mut solver = AdaptiveSo3::new(body, Damping(1.0));
    for (span, tolerance) in [(1.0, 1e-8), (1.0, 1e-10), (1.0, 1e-12), (10.0, 1e-12)] {
        group.bench_function(format!("T = {span}, {tolerance:e}"), |bencher| {
            bencher.iter(|| {
                let mut state = start.clone();
                solver.solve(black_box(&mut state), black_box(span), black_box(tolerance)).expect("the run succeeds")
            });
        });
    }
    group.finish();
}

/// "ensemble/so3": 1000 bodies, 100 steps of a hundredth, all cores.
fn ensemble(criterion: &mut Criterion) {
    let start = initial(&landau_lifshitz_gilbert::<f64>());
    let member = |k: u32| Member {
        lagrangian: Quadratic::diagonal([0.5 + f64::from(k) / 1000.0, 2.0, 1.0]).expect("a regular inertia"),
        force: Damping(f64::from(k) / 1000.0),
        state: start.clone(),
    };
    let members: Vec<_> = (0..1000).map(member).collect();
    let mut group = criterion.benchmark_group("ensemble/so3");
    group.throughput(Throughput::Elements(1000 * 100));
    group.sample_size(10);
    let ensemble = EnsembleSo3::new(&members, CayleySo3::new(), tableau("gauss-2"));
    let ensemble = ensemble.expect("it fits");
    group.bench_function("gauss-2 cayley", |bencher| {
        bencher.iter_batched_ref(
            || ensemble.clone(),
            |ensemble| ensemble.advance(0.01, 100).expect("the steps succeed"),
            BatchSize::LargeInput,
        );
    });
    group.finish();
}

criterion_group!(benches, so3, so3_relaxed, so3_in_lanes, solve, ensemble, se3);
criterion_main!(benches);
