use euler_poincare::integrators::so3::*;
use euler_poincare::integrators::variational::Settings;
use euler_poincare::integrators::*;
use euler_poincare::mechanics::models::*;
use euler_poincare::mechanics::lagrangian::*;
use euler_poincare::retraction::*;
use euler_poincare::tableau::*;
use std::hint::black_box;
fn tableau(name: &str) -> Tableau<f64> { let d: Description = name.parse().unwrap(); d.build().unwrap() }
fn agree<F: LaneForce, R: FastRetraction>(name: &str, tab: &str, l: &Quadratic<f64,3>, force: F, r: R, model: &Model<f64>) {
    let mut fast = VariationalSo3::new(l.clone(), force, r.clone(), tableau(tab)).unwrap();
    let mut slow = Variational::new(model.system.lagrangian.clone(), model.system.force.clone(), r, tableau(tab));
    for h in [1.0, 0.5, 0.125] {
        let mut x = State { time: 0.0, momentum: model.momentum, attitude: euler_poincare::algebra::Matrix::identity() };
        let mut y = x.clone();
        let mut worst = 0.0f64; let mut its = (0, 0); let mut res = 0.0f64; let mut solver = None;
        for _ in 0..(4.0 / h) as usize {
            match (fast.step(&mut x, h), slow.step(&mut y, h)) {
                (Ok(a), Ok(b)) => { its.0 += a.iterations; its.1 += b.iterations; res = res.max(a.residual); solver = Some(a.solver); }
                other => { println!("{name} {tab} {h}: {other:?}"); break; }
            }
            worst = worst.max((x.momentum - y.momentum).amax()).max((x.attitude - y.attitude).amax());
        }
        let n = 4.0 / h;
        println!("{name} {tab} h={h}: differ {worst:.1e} its {:.1} vs {:.1} residual {res:.1e} {solver:?}", its.0 as f64 / n, its.1 as f64 / n);
    }
}
fn time<F: LaneForce, R: FastRetraction>(name: &str, tab: &str, l: &Quadratic<f64,3>, force: F, r: R, model: &Model<f64>, h: f64, tol: f64, want: [f64; 3]) {
    let set = Settings { tolerance: tol, ..Settings::default() };
    let mut fast = VariationalSo3::with_settings(l.clone(), force, r, tableau(tab), set).unwrap();
    let x0 = State { time: 0.0, momentum: model.momentum, attitude: euler_poincare::algebra::Matrix::identity() };
    let n = (1.0 / h) as usize;
    let mut once = || { let mut x = black_box(x0.clone()); let mut r = None; for _ in 0..n { r = Some(fast.step(&mut x, h).unwrap()); } (x, r.unwrap()) };
    let (x, r) = once();
    let mut min = f64::MAX;
    for _ in 0..400 {
        let t0 = std::time::Instant::now();
        for _ in 0..100 { black_box(once()); }
        min = min.min(t0.elapsed().as_secs_f64() * 1e7);
    }
    let err = (0..3).map(|a| (x.momentum[a] - want[a]).abs()).fold(0., f64::max);
    println!("{name} {tab} h={h} tol={tol:e}: {min:.0} ns, its {} residual {:.1e} err {err:.1e}", r.iterations, r.residual);
}
fn main() {
    let l = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let (llg, rel) = (landau_lifshitz_gilbert::<f64>(), relaxed_rigid_body::<f64>());
    for tab in ["gauss-1", "gauss-2", "gauss-4", "gauss-6", "gauss-8", "lobatto-iiia-3", "lobatto-iiib-3", "radau-iia-3"] {
        agree("llg cay", tab, &l, Damping(1.0), CayleySo3::new(), &llg);
        agree("rel cay", tab, &l, Relaxation(0.1), CayleySo3::new(), &rel);
        agree("llg exp", tab, &l, Damping(1.0), ExponentialSo3::new(), &llg);
    }
    let a = [0.2414593544179368885463, 0.2537142183692990580699, 0.7087499386676014196337];
    let b = [0.3792307480209543639345, 0.2570004497899354372658, 0.6552430571284844754182];
    for (tab, tol) in [("gauss-5", 1e-8), ("gauss-6", 1e-8), ("gauss-8", 1e-8), ("gauss-6", 1e-10), ("gauss-7", 1e-10), ("gauss-8", 1e-10),  ("gauss-7", 1e-12),("gauss-8", 1e-12), ("gauss-8", 1e-14)] {
        time("llg", tab, &l, Damping(1.0), CayleySo3::new(), &llg, 1.0, tol, a);
        time("rel", tab, &l, Relaxation(0.1), CayleySo3::new(), &rel, 1.0, tol, b);
    }
    time("llg exp", "gauss-8", &l, Damping(1.0), ExponentialSo3::new(), &llg, 1.0, 1e-12, a);
    time("llg", "gauss-2", &l, Damping(1.0), CayleySo3::new(), &llg, 1.0/64.0, 1e-15, a);
}
