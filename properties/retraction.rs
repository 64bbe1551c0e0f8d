//! Properties of `euler_poincare::retraction`.

use euler_poincare::algebra::{Covector, Vector};
use euler_poincare::retraction::{CayleySo3, ExponentialSo3, Retraction, TangentPoint};
use euler_poincare::scalar::dual::derivative;

#[test]
fn smoke() {
    println!("cay");
    smoke_of(&CayleySo3::<f64>::new(), 1.0);
    for scale in [0.0, 1e-9, 0.1, 1.0, 2.0, 3.0, 20.0] {
        println!("exp {scale}");
        smoke_of(&ExponentialSo3::<f64>::new(), scale);
    }
}

fn smoke_of(r: &impl Retraction<f64, 3, 3>, scale: f64) {
    let x = Vector::<f64, 3>::new(0.3, -1.2, 0.7) * scale;
    let y = Vector::<f64, 3>::new(1.3, 0.2, -0.4);
    let z = Vector::<f64, 3>::new(-0.5, 0.9, 0.8);
    let p = r.at(&x).unwrap();
    let dtau = derivative(|x| r.tau(x), &x, &y).unwrap();
    let g = r.tau(&x).unwrap();
    let w = p.d() * y;
    println!("{}", (dtau - g * w.cross_matrix()).amax());
    println!("{}", (p.d() * p.d_inv() - nalgebra::Matrix3::identity()).amax());
    let dd = derivative(|x| r.at(x).map(|p| p.d() * y.map(euler_poincare::scalar::Dual::constant)), &x, &z).unwrap();
    println!("{}", (dd - p.d() * p.dd(&y) * z).amax());
    let m = Covector::<f64, 3>::new(0.1, 0.5, 2.0);
    let c = m * p.d();
    println!("{}", (p.pull_dd(&c, &m, &y) - c * p.dd(&y)).amax());
    println!("{}", (p.ad() - p.d_neg() * p.d_inv()).amax());
    println!("{}", (r.tau_inv(&g).unwrap() - x).amax());
}
