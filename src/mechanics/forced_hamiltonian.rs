//! The Hamiltonian on g*×G×g* that generates a forced Lie–Poisson system.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/mechanics/forced_hamiltonian.md"))]

use super::doubled::{DoubledLagrangian, Forced, MomentumPoint, VelocityError, VelocityPoint, force_derivative};
use super::hamiltonian::{DoubledHamiltonian, MomentumPartials};
use super::{Force, Lagrangian, LegendreError};
use crate::algebra::{Covector, Matrix, Vector, elimination, pair};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Real, Scalar};

/// h_f(λ, U, μ) = h(μ) − h(λ) + k_f̃(λ, U, μ), k_f̃ = −½ ⟨f̃(t, λ) + f̃(t, μ), τ⁻¹(U)⟩, f̃(t, μ) = f(t, (l')⁻¹(μ)),
/// with h the Legendre transform of l.
///
/// On the units (μ, e, μ) its vector field is two copies of forced Lie–Poisson; it is antisymmetric under
/// (λ, U, μ) ↦ (μ, U⁻¹, λ) (Martín de Diego and Sato Martín de Almagro 2019, Theorem 4.11). Domain: U in that of τ⁻¹.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForcedHamiltonian<L, F, R> {
    /// l, f and τ.
    pub system: Forced<L, F, R>,
}

impl<L, F, R> ForcedHamiltonian<L, F, R> {
    /// The doubled Hamiltonian of the system with Lagrangian l and force f, with the retraction τ in its coupling.
    pub fn new(lagrangian: L, force: F, retraction: R) -> Self {
        Self { system: Forced::new(lagrangian, force, retraction) }
    }

    /// The point with η = (l')⁻¹(λ) and ψ = (l')⁻¹(μ): k_f̃(λ, U, μ) is the [coupling](Forced::coupling) there.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform.
    pub fn velocities<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        at: &MomentumPoint<S, N, D>,
    ) -> Result<VelocityPoint<S, N, D>, LegendreError>
    where
        L: Lagrangian<T, N>,
    {
        let velocity = |p: &Covector<S, N>| self.system.lagrangian.velocity(p, &Vector::zeros());
        Ok(VelocityPoint { time: at.time, eta: velocity(&at.lambda)?, u: at.u, psi: velocity(&at.mu)? })
    }
}

impl<T, L, F, R, const N: usize, const D: usize> DoubledHamiltonian<T, N, D> for ForcedHamiltonian<L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    fn value<S: Scalar<Base = T>>(&self, at: &MomentumPoint<S, N, D>) -> Result<S, VelocityError> {
        let point = self.velocities(at)?;
        let energy = |p: &Covector<S, N>, eta: &Vector<S, N>| pair(p, eta) - self.system.lagrangian.value(eta);
        Ok(energy(&at.mu, &point.psi) - energy(&at.lambda, &point.eta) + self.system.coupling(&point)?)
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        self.system.hat(xi)
    }

    /// In closed form, with x = τ⁻¹(U), η = (l')⁻¹(λ), ψ = (l')⁻¹(μ): ∂h/∂λ = −η − ½ l''(η)⁻¹ ⟨f'(η)·, x⟩ᵀ,
    /// ∂h/∂μ = ψ − ½ l''(ψ)⁻¹ ⟨f'(ψ)·, x⟩ᵀ, L*_U ∂h/∂U = −½ (f̃(λ) + f̃(μ)) dτ_x⁻¹, R*_U = Ad*_{U⁻¹} L*_U.
    fn partials<S: Scalar<Base = T>>(
        &self,
        at: &MomentumPoint<S, N, D>,
    ) -> Result<MomentumPartials<S, N>, VelocityError> {
        let velocities = self.velocities(at)?;
        let x = self.system.retraction.tau_inv(&at.u)?;
        let point = self.system.retraction.at(&x)?;
        let left = self.system.forces(&velocities) * point.d_inv() * -S::half();
        let right = left * point.ad_inv();
        let slope = |eta: &Vector<S, N>| -> Result<Vector<S, N>, LegendreError> {
            let hessian = self.system.lagrangian.hessian(eta);
            let inverse = elimination::inverse(&hessian).ok_or_else(|| LegendreError::singular(eta, &hessian))?;
            let derivative = force_derivative(&self.system.force, at.time, eta, &x);
            Ok(inverse * derivative.transpose() * -S::half())
        };
        let (lambda, mu) = (slope(&velocities.eta)? - velocities.eta, slope(&velocities.psi)? + velocities.psi);
        Ok(MomentumPartials { lambda, left, right, mu })
    }
}
