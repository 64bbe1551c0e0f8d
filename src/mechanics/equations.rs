//! The forced Euler–Poincaré equations in their Hamiltonian form, forced Lie–Poisson.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/mechanics/equations.md"))]

use super::configuration::Configuration;
use super::{Force, Lagrangian, LegendreError};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, pair};
use crate::scalar::{Dual, Real, Scalar};

/// A forced Euler–Poincaré system: an algebra, a reduced Lagrangian l and a force f.
#[derive(Clone, Debug, PartialEq)]
pub struct EulerPoincare<T: Real, const N: usize, L, F> {
    /// g.
    pub algebra: LieAlgebra<T, N>,
    /// l.
    pub lagrangian: L,
    /// f.
    pub force: F,
}

/// What the equations say at one state.
#[derive(Clone, Debug, PartialEq)]
pub struct Rates<S: Scalar, const N: usize> {
    /// η = (l')⁻¹(μ).
    pub velocity: Vector<S, N>,
    /// f, and ∂_gL where there is one.
    pub force: Covector<S, N>,
    /// μ̇ = ad*_η μ + ∂_gL + f.
    pub momentum: Covector<S, N>,
}

impl<T: Real, const N: usize, L: Lagrangian<T, N>, F: Force<T, N>> EulerPoincare<T, N, L, F> {
    /// The system with these parts.
    pub fn new(algebra: LieAlgebra<T, N>, lagrangian: L, force: F) -> Self {
        Self { algebra, lagrangian, force }
    }

    /// μ̇ = ad*_η μ + f(t, η) with η = (l')⁻¹(μ), found from `guess`; at g = e where anything depends on g.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform.
    pub fn rates<S: Scalar<Base = T>>(
        &self,
        t: S,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Rates<S, N>, LegendreError> {
        self.rates_at(t, Configuration::identity(), mu, guess)
    }

    /// [`rates`](Self::rates) where nothing depends on the configuration, in the loop over the stages of a step.
    #[inline]
    pub(crate) fn reduced_rates<S: Scalar<Base = T>>(
        &self,
        t: S,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Rates<S, N>, LegendreError> {
        let velocity = self.lagrangian.velocity(mu, guess)?;
        let force = self.force.force(t, &velocity);
        let momentum = self.algebra.coad(&velocity, mu) + force;
        Ok(Rates { velocity, force, momentum })
    }

    /// μ̇ = ad*_η μ + ∂_gL(t, g, η) + f(t, g, η) with ∂L/∂η(t, g, η) = μ, found from `guess`.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform.
    pub fn rates_at<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Rates<S, N>, LegendreError> {
        let velocity = self.lagrangian.velocity_at(t, g, mu, guess)?;
        let mut force = self.force.force_at(t, g, &velocity);
        if self.lagrangian.uses_configuration() {
            force += self.lagrangian.configuration_gradient(t, g, &velocity);
        }
        let momentum = self.algebra.coad(&velocity, mu) + force;
        Ok(Rates { velocity, force, momentum })
    }

    /// Whether anything depends on the configuration.
    pub fn uses_configuration(&self) -> bool {
        self.force.uses_configuration() || self.lagrangian.uses_configuration()
    }

    /// How much the forces at (t, g, η) change where the entries of g do.
    pub(crate) fn sensitivity<const D: usize>(&self, t: T, g: &Matrix<T, D>, eta: &Vector<T, N>) -> T {
        if self.uses_configuration() { sensitivity(&self.lagrangian, &self.force, t, g, eta) } else { T::zero() }
    }

    /// The energy as a function of the momentum, h(μ) = ⟨μ, η⟩ − l(η) with l'(η) = μ.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform.
    pub fn hamiltonian<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<S, LegendreError> {
        let velocity = self.lagrangian.velocity(mu, guess)?;
        Ok(pair(mu, &velocity) - self.lagrangian.value(&velocity))
    }

    /// dE/dt = ⟨f(t, η), η⟩, the power of the force.
    pub fn power<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> S {
        pair(&self.force.force(t, eta), eta)
    }
}

/// How much the forces at (t, g, η) change where the entries of g do: Σ |∂F/∂g_rc| |g_rc|, of f and of ∂_gL apart, since they cancel at
/// equilibria. Rounding of g makes u times as much of them (Higham 2002, §1.6, entry by entry). By dual numbers.
#[cold]
pub(crate) fn sensitivity<T: Real, const N: usize, const D: usize>(
    lagrangian: &impl Lagrangian<T, N>,
    force: &impl Force<T, N>,
    time: T,
    attitude: &Matrix<T, D>,
    eta: &Vector<T, N>,
) -> T {
    let (time, eta) = (Dual::constant(time), eta.map(Dual::constant));
    let size = |covector: Covector<Dual<T>, N>| covector.iter().fold(T::zero(), |m, v| m.max(v.eps.abs()));
    let mut sum = T::zero();
    for place in 0..D * D {
        let mut g = attitude.map(Dual::constant);
        g[place].eps = g[place].re;
        let here = Configuration::of(&g);
        sum += size(force.force_at(time, here, &eta));
        if lagrangian.uses_configuration() {
            sum += size(lagrangian.configuration_gradient(time, here, &eta));
        }
    }
    if sum.all_finite() { sum } else { T::zero() }
}
