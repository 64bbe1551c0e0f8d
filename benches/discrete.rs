//! What a discrete Lagrangian costs: one evaluation with its derivatives, and the doubled step that it generates.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, criterion_group, criterion_main};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::discrete::{DiscreteLagrangian, StageLagrangian, Triple, legendre_minus};
use euler_poincare::group::MatrixGroup;
use euler_poincare::integrators::{Doubled, DoubledState};
use euler_poincare::mechanics::doubled::{DoubledLagrangian, Forced};
use euler_poincare::mechanics::force::{AnyForce, LinearDrag, QuadraticDrag};
use euler_poincare::mechanics::lagrangian::Quadratic;
use euler_poincare::mechanics::models::landau_lifshitz_gilbert;
use euler_poincare::retraction::{CayleySo3, Exponential, Retraction};
use euler_poincare::scalar::Real;
use euler_poincare::tableau::{Description, Tableau};
use std::hint::black_box;

type Group<'a> = BenchmarkGroup<'a, WallTime>;

fn gauss_2<T: Real>() -> Tableau<T> {
    let description: Description = "gauss-2".parse().expect("the name of a tableau");
    description.build().expect("a tableau")
}

/// The slopes of l_d at a step off the units, and the doubled step that starts with the momenta F⁻ of them; h = 1/8.
fn judge<T: Real, L, R, const N: usize, const D: usize>(group: &mut Group<'_>, name: &str, lagrangian: L, tau: R)
where
    L: DoubledLagrangian<T, N, D> + Clone,
    R: Retraction<T, N, D> + Clone,
{
    let h = T::ratio(1, 8);
    let l_d = StageLagrangian::new(lagrangian.clone(), tau.clone(), gauss_2(), h);
    let vector = |p: i64| Vector::<T, N>::from_fn(|a, _| T::ratio(p - a as i64, 64));
    let element = |p| tau.tau(&vector(p)).expect("in the domain");
    let x = Triple { v: element(5), u: element(2), w: element(6) };
    group.bench_function(format!("slopes of l_d, {name}"), |bencher| {
        bencher.iter(|| l_d.slopes(black_box(&x)).expect("slopes"));
    });
    let start = legendre_minus(&l_d, &x).expect("momenta");
    let (lambda, mu): (Covector<T, N>, _) = (start.lambda, start.mu);
    let start = DoubledState { time: T::zero(), lambda, relative: start.u, mu, attitudes: None };
    let mut doubled = Doubled::new(gauss_2(), tau.clone(), lagrangian);
    group.bench_function(format!("doubled step, {name}"), |bencher| {
        bencher.iter(|| {
            let mut state = black_box(&start).clone();
            doubled.step(&mut state, h).expect("a step")
        });
    });
}

/// Landau–Lifshitz–Gilbert damping with the Cayley map.
fn so3<T: Real>(group: &mut Group<'_>) {
    let model = landau_lifshitz_gilbert::<T>();
    let tau = CayleySo3::new();
    let lagrangian = Forced::new(model.system.lagrangian, model.system.force, tau.clone());
    judge(group, &format!("so(3) gauss-2 cayley, {}", T::NAME), lagrangian, tau);
}

/// A rigid body with linear and quadratic drag, with the exponential.
fn se3<T: Real>(group: &mut Group<'_>) {
    let se3 = MatrixGroup::<T, 6, 4>::from_entry(&Entry::Se3).expect("se(3) has dimension 6");
    let inertia = [(1, 2), (2, 1), (1, 1), (3, 1), (3, 2), (5, 4)].map(|(p, q)| T::ratio(p, q));
    let drag = |p, q| Matrix::from_diagonal_element(T::ratio(p, q));
    let force: AnyForce<T, 6> = AnyForce::Sum(vec![
        LinearDrag::new(drag(1, 8)).expect("finite").into(),
        QuadraticDrag::new(drag(1, 4)).expect("positive").into(),
    ]);
    let tau = Exponential::of_group(se3);
    let lagrangian = Forced::new(Quadratic::diagonal(inertia).expect("a regular inertia"), force, tau.clone());
    judge(group, &format!("se(3) gauss-2 exp, {}", T::NAME), lagrangian, tau);
}

/// "discrete".
fn discrete(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("discrete");
    so3::<f64>(&mut group);
    se3::<f64>(&mut group);
    group.finish();
}

criterion_group!(benches, discrete);
criterion_main!(benches);
