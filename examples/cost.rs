use euler_poincare::integrators::so3::*;
use euler_poincare::integrators::variational::Settings;
use euler_poincare::integrators::*;
use euler_poincare::mechanics::models::*;
use euler_poincare::mechanics::lagrangian::*;
use euler_poincare::retraction::*;
use euler_poincare::tableau::*;
fn tableau(s: usize) -> Tableau<f64> { let d: Description = format!("gauss-{s}").parse().unwrap(); d.build().unwrap() }
fn go<F: LaneForce, R: FastRetraction>(name: &str, f: F, r: R, model: &Model<f64>, tol: f64) {
    let l = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    for s in [4, 6, 8] { for h in [0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5, 3.0] {
        let mut m = VariationalSo3::with_settings(l.clone(), f.clone(), r.clone(), tableau(s), Settings { tolerance: tol, ..Settings::default() }).unwrap();
        let mut best = f64::MAX; let mut its = 0; let mut newton = 0; let mut dmax = 0f64;
        for _ in 0..30 {
            let mut x = State { time: 0.0, momentum: model.momentum, attitude: euler_poincare::algebra::Matrix::identity() };
            let t = std::time::Instant::now(); its = 0; newton = 0; dmax = 0.0;
            for _ in 0..(30.0 / h) as usize { match m.step(&mut x, h) { Ok(r) => { its += r.iterations; dmax = dmax.max(m.delta()); if r.solver != Solver::Sweeps || m.delta() == 0.0 { newton += 1 } }, Err(_) => { newton += 1000; break } } }
            best = best.min(t.elapsed().as_secs_f64());
        }
        println!("{name} s={s} h={h}: {:.0} ns a unit of time, {:.1} its a step, newton {newton} dmax {dmax:.1e}", best * 1e9 / 30.0, its as f64 / (30.0 / h).floor());
    } }
}
fn main() {
    let (llg, rel) = (landau_lifshitz_gilbert::<f64>(), relaxed_rigid_body::<f64>());
    for tol in [1e-10, 1e-13] {
    println!("tol {tol:e}");
    go("rel cay", Relaxation(0.1), CayleySo3::new(), &rel, tol);
    go("rel exp", Relaxation(0.1), ExponentialSo3::new(), &rel, tol);
    go("llg cay", Damping(1.0), CayleySo3::new(), &llg, tol);
    }
}
