use euler_poincare::algebra::*;
use euler_poincare::integrators::so3::*;
use euler_poincare::integrators::*;
use euler_poincare::mechanics::lagrangian::*;
use euler_poincare::retraction::*;
use euler_poincare::tableau::*;
fn main() {
    let mut seed = 12345u64;
    let mut rnd = || { seed ^= seed << 13; seed ^= seed >> 7; seed ^= seed << 17; (seed >> 11) as f64 / (1u64 << 53) as f64 };
    let members: Vec<Member<Damping>> = (0..1000).map(|_| Member {
        lagrangian: Quadratic::diagonal([0.5 + 1.5 * rnd(), 0.5 + 1.5 * rnd(), 1.0]).unwrap(), force: Damping(rnd()),
        state: State { time: 0.0, momentum: Covector::<f64, 3>::new(rnd() - 0.5, rnd() - 0.5, rnd() - 0.5), attitude: Matrix::identity() } }).collect();
    for (tab, h) in [("gauss-2", 0.01), ("gauss-2", 1.0 / 32.0), ("gauss-2", 0.1), ("gauss-1", 0.01), ("gauss-4", 0.1)] {
        let d: Description = tab.parse().unwrap();
        let mut e = EnsembleSo3::<Damping<Row>, _>::new(&members, CayleySo3::new(), d.build().unwrap()).unwrap();
        e.advance(h, 10).unwrap();
        let t = std::time::Instant::now();
        e.advance(h, 1000).unwrap();
        let s = t.elapsed().as_secs_f64();
        let mut worst = 0.0f64;
        for k in [0, 7, 500, 999] {
            let m = &members[k];
            let mut f = VariationalSo3::new(m.lagrangian.clone(), m.force, CayleySo3::new(), d.build().unwrap()).unwrap();
            let mut x = m.state.clone();
            for _ in 0..1010 { f.step(&mut x, h).unwrap(); }
            let y = e.state(k).unwrap();
            worst = worst.max((x.momentum - y.momentum).amax()).max((x.attitude - y.attitude).amax());
        }
        println!("{tab} h={h}: {:.2e} trajectory-steps a second, differ {worst:.1e}", 1e6 / s);
    }
}
