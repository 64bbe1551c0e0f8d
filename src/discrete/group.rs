//! Discrete Lagrangians on G itself: discrete Euler–Poincaré and Lie–Poisson equations, without force.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/discrete/group.md"))]

use super::DiscreteError;
use super::chord;
use super::smooth::moved;
use crate::algebra::{Covector, Matrix};
use crate::group::LieGroup;
use crate::mechanics::Lagrangian;
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::{Real, Scalar};

/// l_d: G → ℝ, W = g_k⁻¹g_{k+1}, in any scalar.
///
/// ```
/// use euler_poincare::algebra::{Covector, Vector};
/// use euler_poincare::discrete::group::{GroupLagrangian, Sampled, euler_poincare, flow, legendre};
/// use euler_poincare::group::So3;
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::{CayleySo3, Retraction};
///
/// // l_d(W) = h l(τ⁻¹(W)/h), for a free body.
/// let tau = CayleySo3::<f64>::new();
/// let l_d = Sampled { lagrangian: Quadratic::diagonal([1.0, 2.0, 3.0])?, retraction: tau.clone(), step: 0.1 };
/// let group = So3::<f64>::new();
/// let w = tau.tau(&Vector::<f64, 3>::new(0.02, 0.01, 0.03))?;
/// let action: f64 = l_d.value(&w)?;
/// assert!(action > 0.0);
///
/// // The discrete Euler–Poincaré equations carry W to the next one, and keep |μ|.
/// let next = flow(&l_d, &group, &tau, &w)?;
/// assert!(euler_poincare(&l_d, &group, &w, &next)?.amax() < 1e-12);
/// let momentum = |w| legendre(&l_d, &group, w).map(|(before, _): (Covector<f64, 3>, _)| before.norm());
/// assert!((momentum(&w)? - momentum(&next)?).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait GroupLagrangian<T: Real, const D: usize> {
    /// l_d(W).
    ///
    /// # Errors
    /// W outside the domain.
    fn value<S: Scalar<Base = T>>(&self, w: &Matrix<S, D>) -> Result<S, RetractionError>;
}

/// l_d(W) = h l(τ⁻¹(W)/h).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampled<T: Real, L, R, const N: usize> {
    /// l.
    pub lagrangian: L,
    /// τ.
    pub retraction: R,
    /// h.
    pub step: T,
}

impl<T, L, R, const N: usize, const D: usize> GroupLagrangian<T, D> for Sampled<T, L, R, N>
where
    T: Real,
    L: Lagrangian<T, N>,
    R: Retraction<T, N, D>,
{
    fn value<S: Scalar<Base = T>>(&self, w: &Matrix<S, D>) -> Result<S, RetractionError> {
        let h = S::lift(self.step);
        Ok(self.lagrangian.value(&(self.retraction.tau_inv(w)? / h)) * h)
    }
}

/// F⁺l_d(W) = L*_W l_d' and F⁻l_d(W) = R*_W l_d', in this order, by dual numbers.
///
/// # Errors
/// W outside the domain.
pub fn legendre<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    l_d: &impl GroupLagrangian<T, D>,
    group: &impl LieGroup<T, N, D>,
    w: &Matrix<S, D>,
) -> Result<(Covector<S, N>, Covector<S, N>), DiscreteError> {
    let (mut plus, mut minus) = (Covector::zeros(), Covector::zeros());
    for a in 0..N {
        let (left, right) = moved(group, w, a);
        plus[a] = l_d.value(&left).map_err(DiscreteError::domain("W"))?.eps;
        minus[a] = l_d.value(&right).map_err(DiscreteError::domain("W"))?.eps;
    }
    Ok((plus, minus))
}

/// L*_{W₁}l_d'(W₁) − R*_{W₂}l_d'(W₂), which vanishes on solutions of the discrete Euler–Poincaré equations (2.10).
///
/// # Errors
/// W₁ or W₂ outside the domain.
pub fn euler_poincare<T: Real, const N: usize, const D: usize>(
    l_d: &impl GroupLagrangian<T, D>,
    group: &impl LieGroup<T, N, D>,
    first: &Matrix<T, D>,
    second: &Matrix<T, D>,
) -> Result<Covector<T, N>, DiscreteError> {
    Ok(legendre(l_d, group, first)?.0 - legendre(l_d, group, second)?.1)
}

/// (F⁻)⁻¹(μ): the W with R*_W l_d' = μ, found from `start`.
///
/// Newton's method for x in W = W₀ τ(x), from 0.
///
/// # Errors
/// No convergence; a singular Jacobian, where l_d is not regular; leaving a domain.
pub fn displacement<T: Real, const N: usize, const D: usize>(
    l_d: &impl GroupLagrangian<T, D>,
    group: &impl LieGroup<T, N, D>,
    retraction: &impl Retraction<T, N, D>,
    mu: &Covector<T, N>,
    start: &Matrix<T, D>,
) -> Result<Matrix<T, D>, DiscreteError> {
    let [w] = chord::elements("the discrete Euler–Poincaré equations", retraction, [*start], |[w]| {
        let (_, minus) = legendre(l_d, group, w)?;
        Ok(([minus - mu], minus.amax().max(mu.amax())))
    })?;
    Ok(w)
}

/// The discrete flow W₁ ↦ W₂ of (2.10), found from W₁.
///
/// # Errors
/// Those of [`displacement`].
pub fn flow<T: Real, const N: usize, const D: usize>(
    l_d: &impl GroupLagrangian<T, D>,
    group: &impl LieGroup<T, N, D>,
    retraction: &impl Retraction<T, N, D>,
    w: &Matrix<T, D>,
) -> Result<Matrix<T, D>, DiscreteError> {
    displacement(l_d, group, retraction, &legendre(l_d, group, w)?.0, w)
}

/// The discrete Lie–Poisson map μ₁ ↦ μ₂ = Ad*_{W₁} μ₁ with F⁻l_d(W₁) = μ₁, W₁ found from `start`; and W₁.
///
/// # Errors
/// Those of [`displacement`]; W₁ singular.
pub fn lie_poisson<T: Real, const N: usize, const D: usize>(
    l_d: &impl GroupLagrangian<T, D>,
    group: &impl LieGroup<T, N, D>,
    retraction: &impl Retraction<T, N, D>,
    mu: &Covector<T, N>,
    start: &Matrix<T, D>,
) -> Result<(Covector<T, N>, Matrix<T, D>), DiscreteError> {
    let w = displacement(l_d, group, retraction, mu, start)?;
    let next = group.coadjoint(&w, mu).ok_or(DiscreteError::NotInvertible { what: "W" })?;
    Ok((next, w))
}
