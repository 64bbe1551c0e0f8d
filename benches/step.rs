//! What one step costs: every method on so(3), Runge–Kutta 4 by hand beside them, and a body in a fluid on se(3).

#[allow(dead_code, reason = "the others are for `peers`")]
#[path = "peers/src/fields.rs"]
mod fields;

use criterion::measurement::WallTime;
use criterion::{BatchSize, BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix};
use euler_poincare::group::{LieGroup, MatrixGroup};
use euler_poincare::integrators::lanes::{Damping, VariationalInLanes};
use euler_poincare::integrators::so3::{EnsembleSo3, Member};
use euler_poincare::integrators::{OneStep, Solve, State, Variational};
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, QuadraticDrag};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::models::{Model, landau_lifshitz_gilbert, relaxed_rigid_body};
use euler_poincare::retraction::{Cayley, CayleySo3, Exponential, ExponentialSo3, Retraction};
use euler_poincare::scalar::{Dd, Real, Scalar};
use euler_poincare::tableau::{Description, Tableau};
use fields::{Field, LandauLifshitzGilbert, Relaxed};
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

/// A step of the classical Runge–Kutta method of order 4.
fn rk4<F: Field<K>, const K: usize>(field: F, y: &[f64; K], h: f64) -> [f64; K] {
    let rates = |y: &[f64; K]| {
        let mut rate = [0.0; K];
        field.rates(y, &mut rate);
        rate
    };
    let moved = |rate: &[f64; K], h: f64| -> [f64; K] { std::array::from_fn(|i| y[i] + h * rate[i]) };
    let k1 = rates(y);
    let k2 = rates(&moved(&k1, 0.5 * h));
    let k3 = rates(&moved(&k2, 0.5 * h));
    let k4 = rates(&moved(&k3, h));
    std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}

fn rk4_by_hand(group: &mut Group<'_>, model: &Model<f64>, field: impl Field<12>) {
    let [a, b, c] = [0, 1, 2].map(|k| model.momentum[k]);
    let start = [a, b, c, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let (mut body, mut taken) = (start, 0);
    group.bench_function("rk4 by hand", |bencher| {
        bencher.iter(|| {
            if taken == RUN {
                (body, taken) = (start, 0);
            }
            taken += 1;
            body = rk4(field, black_box(&body), black_box(0.1));
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
    rk4_by_hand(&mut group, &model, LandauLifshitzGilbert);
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
    rk4_by_hand(&mut group, &model, Relaxed);
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
        let method = VariationalInLanes::new(body.clone(), Damping(1.0), CayleySo3::new(), tableau(name));
        warm(&mut group, &format!("{name} cayley"), &mut method.expect("it fits"), &initial(&model), 0.1);
        let method = VariationalInLanes::new(body, Damping(1.0), ExponentialSo3::new(), tableau(name));
        warm(&mut group, &format!("{name} exp"), &mut method.expect("it fits"), &initial(&model), 0.1);
    }
    group.finish();
}

/// "solve/so3": from a tolerance to an answer, with attitude.
fn solve(criterion: &mut Criterion) {
    let start = initial(&landau_lifshitz_gilbert::<f64>());
    let mut group = criterion.benchmark_group("solve/so3");
    let body = Quadratic::diagonal([0.5, 2.0, 1.0]).expect("a regular inertia");
    for (span, tolerance) in [(1.0, 1e-8), (1.0, 1e-10), (1.0, 1e-12), (10.0, 1e-12)] {
        let mut solve = Solve::in_lanes(body.clone(), Damping(1.0), CayleySo3::new()).tolerance(tolerance);
        group.bench_function(format!("T = {span}, {tolerance:e}"), |bencher| {
            bencher.iter(|| solve.run(black_box(&start), black_box(span)).expect("the run succeeds"));
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
