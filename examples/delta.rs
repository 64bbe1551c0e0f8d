use euler_poincare::integrators::so3::*;
use euler_poincare::integrators::*;
use euler_poincare::mechanics::lagrangian::*;
use euler_poincare::algebra::*;
use euler_poincare::retraction::*;
use euler_poincare::tableau::*;
fn tableau(s: usize) -> Tableau<f64> { let d: Description = format!("gauss-{s}").parse().unwrap(); d.build().unwrap() }
fn go<R: FastRetraction>(name: &str, r: R) {
    let mut seed = 12345u64;
    let mut rnd = || { seed ^= seed << 13; seed ^= seed >> 7; seed ^= seed << 17; (seed >> 11) as f64 / (1u64 << 53) as f64 };
    for s in 3..=8 {
        let mut ratios = vec![];
        for _ in 0..4000 {
            let inertia = [0.5 + 1.5 * rnd(), 0.5 + 1.5 * rnd(), 1.0];
            let l = Quadratic::diagonal(inertia).unwrap();
            let mu = Covector::<f64, 3>::new(rnd() - 0.5, rnd() - 0.5, rnd() - 0.5);
            let force = Terms(vec![Term::Damping(if rnd() < 0.5 { 0.0 } else { rnd() * 2.0 }), Term::LinearDrag(if rnd() < 0.5 { [[0.0;3];3] } else { [[rnd()*0.5, 0.1, 0.0],[0.0, rnd()*0.5, 0.0],[0.0,0.0,rnd()]] })]);
            let om = l.inverse() * mu.transpose();
            let h = (0.3 + 2.0 * rnd()) / om.norm();
            let mut m = VariationalSo3::new(l.clone(), force.clone(), r.clone(), tableau(s)).unwrap();
            let mut f = VariationalSo3::new(l.clone(), force.clone(), r.clone(), tableau(8)).unwrap();
            let mut x = State { time: 0.0, momentum: mu, attitude: Matrix::identity() };
            let mut y = x.clone();
            let Ok(rep) = m.step(&mut x, h) else { continue };
            if rep.solver != Solver::Sweeps { continue }
            for _ in 0..16 { f.step(&mut y, h / 16.0).unwrap(); }
            let e = ((x.momentum - y.momentum).amax() / mu.amax()).max((x.attitude - y.attitude).amax());
            if e > 3e-14 { ratios.push((e / m.delta().max(1e-17), e, h * om.norm(), (x.momentum - y.momentum).amax() / mu.amax())); }
        }
        ratios.sort_by(|a, b| a.0.total_cmp(&b.0));
        let n = ratios.len();
        if n < 10 { println!("{name} {s}: {n}"); continue }
        println!("{name} s={s} n={n}: ratio err/delta quantiles 1% {:.2e} 10% {:.2e} 50% {:.2e} 90% {:.2e} 99% {:.2e} max {:.2e} {:?}", ratios[n/100].0, ratios[n/10].0, ratios[n/2].0, ratios[n*9/10].0, ratios[n*99/100].0, ratios[n-1].0, ratios[n-1]);
    }
}
fn main() { go("cay", CayleySo3::new()); go("exp", ExponentialSo3::new()); }
