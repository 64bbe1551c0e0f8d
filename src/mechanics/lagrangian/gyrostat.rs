//! A term that is linear in the velocity, beside any Lagrangian.

use crate::algebra::{Covector, Matrix, Vector, pair};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Lagrangian, LegendreError, at_the_identity, body, passed_on};
use crate::scalar::{Real, Scalar};

/// l(η) = l₀(η) + ⟨b, η⟩: a body with a rotor of constant momentum b.
///
/// l' = l₀' + b and l'' = l₀''. The inverse of l' is μ ↦ (l₀')⁻¹(μ − b), and the energy is that of l₀. At rest the momentum is b. l is
/// not even. Source: Kelvin; Krishnaprasad and Marsden 1987 (rigid bodies with rotors).
#[derive(Clone, Debug, PartialEq)]
pub struct Gyrostat<L, T: Real, const N: usize> {
    body: L,
    rotor: Covector<T, N>,
}

impl<L, T: Real, const N: usize> Gyrostat<L, T, N> {
    /// l₀ and b.
    ///
    /// # Errors
    /// [`LegendreError::BadTerm`]: a component of b is not finite.
    pub fn new(body: L, rotor: Covector<T, N>) -> Result<Self, LegendreError> {
        match rotor.iter().position(|v| !v.all_finite()) {
            Some(a) => {
                Err(LegendreError::BadTerm { what: "gyrostat term", why: format!("entry {} is not finite", a + 1) })
            }
            None => Ok(Self { body, rotor }),
        }
    }

    /// l₀.
    pub fn body(&self) -> &L {
        &self.body
    }

    /// b.
    pub fn rotor(&self) -> &Covector<T, N> {
        &self.rotor
    }
}

impl<L: Lagrangian<T, N>, T: Real, const N: usize> Lagrangian<T, N> for Gyrostat<L, T, N> {
    at_the_identity!(lagrangian);
    passed_on!(body: hessian, uses_configuration, energy_at, undefined, configuration_gradient);

    fn value_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        self.body.value_at(t, g, eta) + pair(&self.rotor.map(S::lift), eta)
    }

    fn gradient_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        self.body.gradient_at(t, g, eta) + self.rotor.map(S::lift)
    }

    fn velocity_at<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        self.body.velocity_at(t, g, &(mu - self.rotor.map(S::lift)), guess)
    }
}
