//! Faults of the coupling k_f, of l_f and of its derivatives.

use super::{blend, blend_scalar};
use crate::algebra::{Covector, Matrix, Vector, pair};
use crate::harness::Fault;
use crate::mechanics::doubled::{Both, DoubledLagrangian, Forced, Partials, VelocityPoint, velocity_hessian_by_duals};
use crate::mechanics::force::AnyForce;
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::mechanics::{Force, Lagrangian, LegendreError};
use crate::retraction::{AnyRetraction, Retraction, RetractionError};
use crate::scalar::{Real, Scalar};
use crate::system::System;

pub const FIRST_COPY_ONLY: Fault = Fault::new("first-copy-only", "k_f = −⟨f(η), τ⁻¹(U)⟩", "velocity-dependent forces");
pub const COUPLING_SUM: Fault = Fault::new(
    "sum",
    "k_f = ½(⟨f(ψ), τ⁻¹(U⁻¹)⟩ + ⟨f(η), τ⁻¹(U)⟩), the sign of the second term flipped",
    "forced systems",
);
pub const TIME_SHIFT: Fault =
    Fault::new("time-shift", "k_f with f(t + ¼, ψ) instead of f(t, ψ)", "time-dependent forces");
pub const PLUS: Fault = Fault::new("plus", "l(ψ) + l(η) − k_f", "every system");
pub const LEFT_FOR_RIGHT: Fault =
    Fault::new("left-for-right", "R*_U ∂l_f/∂U replaced by L*_U ∂l_f/∂U", "forced systems on non-abelian groups");
pub const NO_FORCE_DERIVATIVE: Fault =
    Fault::new("no-force-derivative", "∂l_f/∂η without the derivative of f", "velocity-dependent forces");
pub const HALF_FORCE: Fault = Fault::new("half-force", "∂l_f/∂U halved", "forced systems");

/// l_f, with a fault or without.
#[derive(Clone, Copy)]
pub struct PlantedForced<'a, T: Real, const N: usize, const D: usize> {
    /// l_f.
    pub doubled: Forced<&'a AnyLagrangian<T, N>, &'a AnyForce<T, N>, &'a AnyRetraction<T, N, D>>,
    /// What is planted.
    pub fault: Option<&'a Fault>,
}

impl<'a, T: Real, const N: usize, const D: usize> PlantedForced<'a, T, N, D> {
    /// That of a system.
    pub fn of(system: &'a System<T, N, D>, fault: Option<&'a Fault>) -> Self {
        Self { doubled: Forced::new(&system.lagrangian, &system.force, &system.retraction), fault }
    }

    /// k_f.
    pub fn coupling<S: Scalar<Base = T>>(&self, at: &VelocityPoint<S, N, D>) -> Result<S, RetractionError> {
        let right = self.doubled.coupling(at)?;
        if self.fault.is_none() {
            return Ok(right);
        }
        let x = self.doubled.retraction.tau_inv(&at.u)?;
        let force = |t: S, eta: &Vector<S, N>| pair(&self.doubled.force.force(t, eta), &x);
        let (here, there) = (force(at.time, &at.eta), force(at.time, &at.psi));
        let late = force(at.time + S::exact(0.25), &at.psi);
        let value = blend_scalar(right, -here, FIRST_COPY_ONLY.size_in(self.fault));
        let value = blend_scalar(value, (here - there) * S::half(), COUPLING_SUM.size_in(self.fault));
        Ok(blend_scalar(value, -(here + late) * S::half(), TIME_SHIFT.size_in(self.fault)))
    }
}

impl<T: Real, const N: usize, const D: usize> DoubledLagrangian<T, N, D> for PlantedForced<'_, T, N, D> {
    fn value<S: Scalar<Base = T>>(&self, at: &VelocityPoint<S, N, D>) -> Result<S, RetractionError> {
        if self.fault.is_none() {
            return self.doubled.value(at);
        }
        let first = self.doubled.lagrangian.value(&at.eta);
        let first = blend_scalar(-first, first, PLUS.size_in(self.fault));
        Ok(self.doubled.lagrangian.value(&at.psi) + first - self.coupling(at)?)
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        self.doubled.hat(xi)
    }

    fn unit_velocities(
        &self,
        lambda: &Covector<T, N>,
        mu: &Covector<T, N>,
    ) -> Result<Both<Vector<T, N>>, LegendreError> {
        DoubledLagrangian::<T, N, D>::unit_velocities(&self.doubled, lambda, mu)
    }

    /// In closed form; with a fault in the partial derivatives, from them.
    fn velocity_hessian(&self, at: &VelocityPoint<T, N, D>) -> Result<Both<Both<Matrix<T, N>>>, RetractionError> {
        match self.fault {
            None => self.doubled.velocity_hessian(at),
            Some(_) => velocity_hessian_by_duals(self, at),
        }
    }

    fn partials<S: Scalar<Base = T>>(&self, at: &VelocityPoint<S, N, D>) -> Result<Partials<S, N>, RetractionError> {
        let mut partials = self.doubled.partials(at)?;
        if self.fault.is_none() {
            return Ok(partials);
        }
        let half = HALF_FORCE.size_in(self.fault);
        let incomplete = -self.doubled.lagrangian.gradient(&at.eta);
        partials.right = blend(partials.right, partials.left, LEFT_FOR_RIGHT.size_in(self.fault));
        partials.eta = blend(partials.eta, incomplete, NO_FORCE_DERIVATIVE.size_in(self.fault));
        partials.left = blend(partials.left, partials.left * S::half(), half);
        partials.right = blend(partials.right, partials.right * S::half(), half);
        Ok(partials)
    }
}
