use euler_poincare::integrators::so3::*;
use euler_poincare::integrators::variational::Settings;
use euler_poincare::integrators::*;
use euler_poincare::mechanics::models::*;
use euler_poincare::mechanics::lagrangian::*;
use euler_poincare::retraction::*;
use euler_poincare::tableau::*;
use std::hint::black_box;
fn main() {
    let l = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let model = landau_lifshitz_gilbert::<f64>();
    let d: Description = "gauss-8".parse().unwrap();
    let set = Settings { tolerance: 1e-8, ..Settings::default() };
    let mut fast = VariationalSo3::with_settings(l.clone(), Damping(1.0), CayleySo3::new(), d.build().unwrap(), set).unwrap();
    let x0 = State { time: 0.0, momentum: model.momentum, attitude: euler_poincare::algebra::Matrix::identity() };
    let t = std::time::Instant::now();
    for _ in 0..5_000_000 { let mut x = black_box(x0.clone()); fast.step(&mut x, black_box(1.0)).unwrap(); black_box(&x); }
    println!("{:.0} ns", t.elapsed().as_secs_f64() * 1e9 / 5e6);
}
