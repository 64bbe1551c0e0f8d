use euler_poincare::integrators::so3::*;
use euler_poincare::integrators::*;
use euler_poincare::mechanics::models::*;
use euler_poincare::mechanics::lagrangian::*;
use euler_poincare::retraction::*;
use std::hint::black_box;
fn go<F: LaneForce>(name: &str, f: F, model: &Model<f64>, span: f64, n: usize, reps: usize) {
    let l = Quadratic::diagonal([0.5, 2.0, 1.0]).unwrap();
    let mut m = AdaptiveSo3::new(l, f);
    let x0 = State { time: 0.0, momentum: model.momentum, attitude: euler_poincare::algebra::Matrix::identity() };
    let mut want = x0.clone();
    for _ in 0..(span as usize * 2) { m.solve(&mut want, 0.5, 1e-14).unwrap(); }
    if span > 100.0 { let mut x = x0.clone(); let mut k = 0; m.solve_with(&mut x, span, 1e-10, |s, h| { k += 1; if k % 50 == 1 { let om = [2.0*s.momentum[0], 0.5*s.momentum[1], s.momentum[2]]; let c = s.momentum.transpose().cross(&euler_poincare::algebra::Vector::<f64,3>::new(om[0],om[1],om[2])); println!("t {:.1} h {h:.2} |MxO| {:.1e}", s.time, c.norm()); } }).unwrap(); }
    for tol in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        let mut best = f64::MAX;
        let mut x = x0.clone(); let mut s = Solved::default();
        for _ in 0..reps {
            let t = std::time::Instant::now();
            for _ in 0..n { x = black_box(x0.clone()); s = match m.solve(&mut x, black_box(span), black_box(tol)) { Ok(s) => s, Err(e) => { println!("{name} {tol:e}: {e}"); return } }; }
            best = best.min(t.elapsed().as_secs_f64() / n as f64);
        }
        let err = (x.momentum - want.momentum).amax().max((x.attitude - want.attitude).amax());
        println!("{name} T={span} tol {tol:e}: {:.0} ns err {err:.1e} {s:?}", best * 1e9);
    }
}
fn main() {
    let (llg, rel) = (landau_lifshitz_gilbert::<f64>(), relaxed_rigid_body::<f64>());
    go("llg cay", Damping(1.0), &llg, 1.0, 1000, 50);
    go("rel cay", Relaxation(0.1), &rel, 1.0, 1000, 50);
    go("llg cay", Damping(1.0), &llg, 10.0, 100, 50);
    go("rel cay", Relaxation(0.1), &rel, 10.0, 100, 50);
    go("rel cay", Relaxation(0.1), &rel, 1000.0, 1, 50);
}
