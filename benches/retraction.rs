//! What the retractions cost: τ(x), the tangents at x, and the adjoint of the second tangent.

use criterion::{Criterion, criterion_group, criterion_main};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Vector};
use euler_poincare::group::MatrixGroup;
use euler_poincare::retraction::{Cayley, CayleySo3, Exponential, ExponentialSo3, Retraction, TangentPoint};
use euler_poincare::scalar::{Dd, Real};
use std::hint::black_box;

fn measure<T: Real, const N: usize, const D: usize>(
    criterion: &mut Criterion,
    algebra: &str,
    retraction: &impl Retraction<T, N, D>,
) {
    let x = Vector::<T, N>::from_fn(|a, _| T::ratio(1 + a as i64, 10));
    let y = Vector::<T, N>::from_fn(|a, _| T::ratio(3 - a as i64, 7));
    let m = Covector::<T, N>::from_fn(|_, a| T::ratio(2 + a as i64, 5));
    let point = retraction.at(&x).expect("x is in the domain");
    let p = m * point.d();
    let mut group = criterion.benchmark_group(format!("retraction/{algebra} {}, {}", retraction.name(), T::NAME));
    group.bench_function("tau", |bencher| bencher.iter(|| retraction.tau(black_box(&x))));
    group.bench_function("tangents at a point", |bencher| bencher.iter(|| retraction.at(black_box(&x))));
    group.bench_function("adjoint of the second tangent", |bencher| {
        bencher.iter(|| point.pull_dd(black_box(&p), black_box(&m), black_box(&y)));
    });
    group.finish();
}

fn retractions(criterion: &mut Criterion) {
    measure::<f64, 3, 3>(criterion, "so3", &CayleySo3::new());
    measure::<f64, 3, 3>(criterion, "so3", &ExponentialSo3::new());
    let se3 = MatrixGroup::<f64, 6, 4>::from_entry(&Entry::Se3).expect("se(3) has dimension 6");
    measure(criterion, "se3", &Cayley::new(se3.clone()).expect("se(3) admits the Cayley map"));
    measure(criterion, "se3", &Exponential::of_group(se3));
    let se3 = MatrixGroup::<Dd, 6, 4>::from_entry(&Entry::Se3).expect("se(3) has dimension 6");
    measure(criterion, "se3", &Exponential::of_group(se3));
}

criterion_group!(benches, retractions);
criterion_main!(benches);
