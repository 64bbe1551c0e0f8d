//! Forces.

use super::{broken, clean, missed, names, switched_off};
use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Matrix, Vector};
use euler_poincare::laws::user::force::UserForce;
use euler_poincare::laws::user::part;
use euler_poincare::mechanics::Force;
use euler_poincare::mechanics::force::{
    AnyForce, Constant, DoubleBracket, LinearDrag, Metriplectic, Periodic, QuadraticDrag, Zero,
};
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Quadratic};
use euler_poincare::scalar::{Dd, Real, Scalar};
use std::collections::BTreeSet;
use std::sync::Mutex;

fn inertia<T: Real>() -> Quadratic<T, 3> {
    Quadratic::diagonal([T::half(), T::int(2), T::one()]).unwrap()
}

/// A force of the library as described systems have it.
fn described(double: impl Into<AnyForce<f64, 3>>, quad: impl Into<AnyForce<Dd, 3>>) -> UserForce<3> {
    UserForce::at_both(double.into(), quad.into())
}

/// That it keeps the Casimirs of the body.
fn keeping(force: UserForce<3>) -> UserForce<3> {
    force.keeps_both(
        (AnyLagrangian::from(inertia::<f64>()), Entry::So3.casimirs().unwrap()),
        (AnyLagrangian::from(inertia::<Dd>()), Entry::So3.casimirs().unwrap()),
    )
}

fn so3<T: Real>() -> LieAlgebra<T, 3> {
    LieAlgebra::from_catalogue(&Entry::So3).unwrap()
}

fn stiffness<T: Real>() -> Matrix<T, 3> {
    Matrix::from_fn(|r, c| if r == c { T::one() } else { T::ratio(1, 4) })
}

fn double_bracket<T: Real>() -> DoubleBracket<T, 3> {
    DoubleBracket::new(so3(), inertia(), T::half()).unwrap()
}

fn metriplectic<T: Real>() -> Metriplectic<T, 3> {
    Metriplectic::new(so3(), inertia(), T::half()).unwrap()
}

fn periodic<T: Real>() -> Periodic<T, 3> {
    Periodic::new(Covector::<T, 3>::new(T::one(), T::half(), T::zero()), T::int(2), T::half()).unwrap()
}

#[test]
fn the_laws_hold_on_the_forces_of_the_library() {
    let both = keeping(described(double_bracket(), double_bracket()).dissipates());
    let report = clean("double bracket", both, 100);
    assert_eq!(switched_off(&report), ["force-workless"]);
    let report = clean("metriplectic", described(metriplectic(), metriplectic()).workless(), 100);
    assert_eq!(switched_off(&report), ["force-dissipates", "force-keeps-casimirs"]);
    let drag = described(LinearDrag::new(stiffness()).unwrap(), LinearDrag::new(stiffness()).unwrap()).dissipates();
    clean("linear drag", drag, 100);
    let drag = (QuadraticDrag::new(stiffness()).unwrap(), QuadraticDrag::new(stiffness()).unwrap());
    clean("quadratic drag", described(drag.0, drag.1).dissipates(), 100);
    let load = || Covector::<f64, 3>::new(1.0, 0.5, -0.25);
    let constant = (Constant::new(load()).unwrap(), Constant::new(load().map(Dd::exact)).unwrap());
    clean("constant", described(constant.0, constant.1), 100);
    clean("periodic", described(periodic(), periodic()), 100);
    let zero = described(Zero, Zero).dissipates().workless();
    assert_eq!(switched_off(&clean("zero", zero, 50)), ["force-keeps-casimirs"]);
}

#[test]
fn every_fault_is_seen() {
    let both = keeping(described(double_bracket(), double_bracket()).dissipates());
    assert_eq!(missed(both, 30), BTreeSet::from([("force-workless", "force-load")]));
    let workless = described(metriplectic(), metriplectic()).workless();
    assert!(!missed(workless, 30).contains(&("force-workless", "force-load")));
}

/// Drag on a wing, with mistakes: f = −(|η|² + 1)η + sin(t) e^1.
#[derive(Clone, Copy)]
struct Wing(&'static str);

impl<T: Real> Force<T, 3> for Wing {
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, 3>) -> Covector<S, 3> {
        let mut drag = eta.dot(eta) + S::one();
        match self.0 {
            "lost" => drag = S::lift(drag.base()),
            "nan" => drag += (eta.dot(eta).sqrt() - S::one()).sqrt() * S::zero(),
            "sign" => drag = -drag,
            _ => {}
        }
        let mut f = -eta.transpose() * drag;
        f[0] += t.sin();
        if self.0 == "free" { f * S::zero() } else { f }
    }

    fn is_zero(&self) -> bool {
        self.0 == "says-zero" || self.0 == "free"
    }
}

#[test]
fn mistakes_by_hand_are_named() {
    let own = |mistake| move || UserForce::at_both(Wing(mistake), Wing(mistake));
    clean("wing", own("nothing")(), 100);
    clean("wing in f64", UserForce::in_double(Wing("nothing")), 100);
    clean("free", own("free")().dissipates().workless(), 100);
    let found = |mistake| names(&broken(own(mistake), 60));
    assert_eq!(found("lost"), ["force-derivatives"]);
    assert_eq!(found("says-zero"), ["force-zero"]);
    assert!(found("nan").starts_with(&["force-finite"]));
    assert!(names(&broken(|| own("nothing")().dissipates(), 60)).contains(&"force-dissipates"), "sin(t) does work");
    assert!(names(&broken(|| own("sign")().dissipates(), 60)).contains(&"force-dissipates"));
    assert_eq!(names(&broken(|| UserForce::in_double(Wing("lost")), 60)), ["force-derivatives"]);
}

/// A force with a state behind a lock.
struct Noise(Mutex<u64>);

impl Force<f64, 1> for Noise {
    fn force<S: Scalar<Base = f64>>(&self, _: S, eta: &Vector<S, 1>) -> Covector<S, 1> {
        let mut state = self.0.lock().unwrap();
        *state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        Covector::<S, 1>::new(-eta[0] + S::exact((*state >> 40) as f64 * 2f64.powi(-24)))
    }
}

#[test]
fn state_is_named() {
    let report = part::run(UserForce::in_double(Noise(Mutex::new(1))), 1, 30);
    let law = report.laws.iter().find(|law| law.law == "force-deterministic").unwrap();
    assert_eq!(law.broken.len(), 30);
}
