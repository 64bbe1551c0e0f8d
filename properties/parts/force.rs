//! Forces of a user's own, and what is claimed of them. On those of random systems the campaign judges the same laws, and their faults.

use super::{broken, clean, names, switched_off};
use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Vector};
use euler_poincare::laws::user::force::UserForce;
use euler_poincare::laws::user::part;
use euler_poincare::mechanics::Force;
use euler_poincare::mechanics::force::{AnyForce, DoubleBracket, Zero};
use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Quadratic};
use euler_poincare::scalar::{Dd, Real, Scalar};
use std::sync::atomic::{AtomicU32, Ordering};

fn inertia<T: Real>() -> Quadratic<T, 3> {
    Quadratic::diagonal([T::half(), T::int(2), T::one()]).unwrap()
}

/// A force of the library as described systems have it.
fn described(double: impl Into<AnyForce<f64, 3>>, quad: impl Into<AnyForce<Dd, 3>>) -> UserForce<3> {
    UserForce::at_both(double.into(), quad.into())
}

fn double_bracket<T: Real>() -> DoubleBracket<T, 3> {
    DoubleBracket::new(LieAlgebra::from_catalogue(&Entry::So3).unwrap(), inertia(), T::half()).unwrap()
}

#[test]
fn claims_switch_laws_on() {
    let both = described(double_bracket(), double_bracket()).dissipates().keeps_both(
        (AnyLagrangian::from(inertia::<f64>()), Entry::So3.casimirs().unwrap()),
        (AnyLagrangian::from(inertia::<Dd>()), Entry::So3.casimirs().unwrap()),
    );
    assert_eq!(switched_off(&clean("double bracket", both, 100)), ["force-workless"]);
    let zero = described(Zero, Zero).dissipates().workless();
    assert_eq!(switched_off(&clean("zero", zero, 50)), ["force-keeps-casimirs"]);
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

/// A force that counts how often it was asked.
struct Counting(AtomicU32);

impl Force<f64, 1> for Counting {
    fn force<S: Scalar<Base = f64>>(&self, _: S, eta: &Vector<S, 1>) -> Covector<S, 1> {
        Covector::<S, 1>::new(-eta[0] + S::exact(f64::from(self.0.fetch_add(1, Ordering::Relaxed))))
    }
}

#[test]
fn state_is_named() {
    let report = part::run(UserForce::in_double(Counting(AtomicU32::new(1))), 1, 30);
    let law = report.laws.iter().find(|law| law.law == "force-deterministic").unwrap();
    assert_eq!(law.broken.len(), 30);
}
