//! Lagrangians of a user's own. On those of random systems the campaign judges the same laws, and their faults.

use super::{broken, clean, names, switched_off};
use euler_poincare::algebra::{Covector, Vector};
use euler_poincare::laws::user::lagrangian::UserLagrangian;
use euler_poincare::mechanics::{Lagrangian, LegendreError};
use euler_poincare::scalar::{Real, Scalar};

/// l = 2 − 2√(1 − |η|²/4) + w·η: a particle in special relativity (c = 2) with a linear term, and mistakes.
#[derive(Clone, Copy, Debug)]
struct Relativistic(&'static str);

impl<T: Real> Lagrangian<T, 3> for Relativistic {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, 3>) -> S {
        let two = S::int(2);
        let mut root = (S::one() - eta.dot(eta) * S::exact(0.25)).sqrt();
        if self.0 == "digits" {
            root = root * S::exact(1.0 + 1e-9) - S::exact(1e-9);
        }
        if self.0 == "lost" {
            root = S::lift(root.base());
        }
        two - two * root + eta[0] * S::exact(0.5)
    }

    fn gradient<S: Scalar<Base = T>>(&self, eta: &Vector<S, 3>) -> Covector<S, 3> {
        let root = (S::one() - eta.dot(eta) * S::exact(0.25)).sqrt();
        let factor = if self.0 == "factor" { S::one() } else { S::half() };
        let mut row = eta.transpose() * (factor / root);
        row[0] += S::exact(0.5);
        row
    }

    fn energy<S: Scalar<Base = T>>(&self, eta: &Vector<S, 3>) -> S {
        let root = (S::one() - eta.dot(eta) * S::exact(0.25)).sqrt();
        let energy = S::int(2) / root - S::int(2);
        if self.0 == "energy" { energy + eta[0] * S::exact(0.5) } else { energy }
    }
}

#[test]
fn mistakes_by_hand_are_named() {
    let own = |mistake| move || UserLagrangian::at_both(Relativistic(mistake), Relativistic(mistake)).within(1.0);
    clean("relativistic", own("nothing")(), 100);
    clean("relativistic in f64", UserLagrangian::in_double(Relativistic("nothing")).within(1.0), 100);
    let found = |mistake| names(&broken(own(mistake), 60));
    let factor = found("factor");
    assert!(factor.starts_with(&["lagrangian-gradient", "lagrangian-hessian"]), "{factor:?}");
    assert_eq!(found("energy"), ["lagrangian-energy"]);
    assert_eq!(found("digits"), ["lagrangian-gradient", "lagrangian-hessian", "lagrangian-energy"]);
    assert!(found("lost").starts_with(&["lagrangian-value", "lagrangian-gradient"]), "{:?}", found("lost"));
    // In f64 alone the ninth digit shows as well.
    let alone = broken(|| UserLagrangian::in_double(Relativistic("digits")).within(1.0), 60);
    assert!(names(&alone).contains(&"lagrangian-gradient"));
}

/// Homogeneous of degree 1: the Hessian is singular along η.
#[derive(Clone, Copy)]
struct Length;

impl<T: Real> Lagrangian<T, 2> for Length {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, 2>) -> S {
        (S::exact(0.25) + eta[0] * eta[0]).sqrt() + eta[1]
    }
}

#[test]
fn regularity_is_reported_or_switched_off() {
    let found = names(&broken(|| UserLagrangian::at_both(Length, Length), 60));
    assert_eq!(found, ["lagrangian-regular"]);
    let report = clean("not regular", UserLagrangian::at_both(Length, Length).not_regular(), 60);
    assert_eq!(switched_off(&report), ["lagrangian-regular", "lagrangian-velocity"]);
}

/// An inverse Legendre transform of one's own: the signs and derivatives of it are looked at.
struct Body(bool);

impl<T: Real> Lagrangian<T, 2> for Body {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, 2>) -> S {
        eta.dot(eta) * S::half() + eta[0] * eta[1] * S::exact(0.5)
    }

    fn velocity<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, 2>,
        _: &Vector<S, 2>,
    ) -> Result<Vector<S, 2>, LegendreError> {
        let sign = if self.0 { S::one() } else { -S::one() };
        let (a, b, d) = (S::one(), S::half(), S::exact(0.75));
        Ok(Vector::<S, 2>::new((a * mu[0] + sign * b * mu[1]) / d, (sign * b * mu[0] + a * mu[1]) / d))
    }
}

#[test]
fn a_wrong_inverse_is_named() {
    clean("body", UserLagrangian::at_both(Body(false), Body(false)), 60);
    let found = broken(|| UserLagrangian::at_both(Body(true), Body(true)), 60);
    assert_eq!(names(&found), ["lagrangian-velocity"]);
    assert!(!found[0].1.to_string().contains('/'), "{}", found[0].1);
}
