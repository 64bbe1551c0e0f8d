//! Doubled Lagrangians on g×G×g and the one that generates a forced system.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/mechanics/doubled.md"))]

use super::{Force, Lagrangian, LegendreError};
use crate::algebra::{Covector, Matrix, Vector, basis_vector, elimination, pair};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::dual::along;
use crate::scalar::{Dual, Real, Scalar, finite};

/// The partial derivatives of a function of (η, U, ψ), each a covector of g.
#[derive(Clone, Debug, PartialEq)]
pub struct Partials<S: Scalar, const N: usize> {
    /// ∂l/∂η.
    pub eta: Covector<S, N>,
    /// L*_U ∂l/∂U: ξ ↦ d/dε l(η, U exp(εξ), ψ).
    pub left: Covector<S, N>,
    /// R*_U ∂l/∂U: ξ ↦ d/dε l(η, exp(εξ) U, ψ).
    pub right: Covector<S, N>,
    /// ∂l/∂ψ.
    pub psi: Covector<S, N>,
}

/// Why a modified Legendre transform could not be inverted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum VelocityError {
    /// The second derivatives are singular, or Newton's method did not converge.
    #[error(transparent)]
    Legendre(#[from] LegendreError),
    /// U is outside the domain of the Lagrangian.
    #[error(transparent)]
    Domain(#[from] RetractionError),
}

/// A Lagrangian on g×G×g, perhaps depending on time; G is represented by D×D matrices.
pub trait DoubledLagrangian<T: Real, const N: usize, const D: usize> {
    /// **l**(t; η, U, ψ).
    ///
    /// # Errors
    /// U outside the domain.
    fn value<S: Scalar<Base = T>>(
        &self,
        t: S,
        eta: &Vector<S, N>,
        u: &Matrix<S, D>,
        psi: &Vector<S, N>,
    ) -> Result<S, RetractionError>;

    /// Whether it stands for a system that depends on the configuration g, which **l** has not: then it is not the double of that system,
    /// and the doubled scheme refuses it.
    fn uses_configuration(&self) -> bool {
        false
    }

    /// ξ̂, the matrix of an element of g.
    ///
    /// # Errors
    /// There are no matrices (an algebra without a group).
    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError>;

    /// The velocities (η, ψ) with λ = −∂l/∂η and μ = ∂l/∂ψ on the units U = e.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform.
    fn unit_velocities(
        &self,
        lambda: &Covector<T, N>,
        mu: &Covector<T, N>,
    ) -> Result<(Vector<T, N>, Vector<T, N>), LegendreError>;

    /// The velocities (η, ψ) with λ = −∂l/∂η(η, U, ψ) and μ = ∂l/∂ψ(η, U, ψ): the inverse of the modified Legendre
    /// transform, by Newton's method from the velocities on the units.
    ///
    /// # Errors
    /// No convergence, singular second derivatives, U outside the domain.
    fn velocities(
        &self,
        t: T,
        lambda: &Covector<T, N>,
        u: &Matrix<T, D>,
        mu: &Covector<T, N>,
    ) -> Result<(Vector<T, N>, Vector<T, N>), VelocityError> {
        newton_velocities(self, t, lambda, u, mu)
    }

    /// The second derivatives in the velocities, N×N blocks by columns: of (∂l/∂η, ∂l/∂ψ) along η, then along ψ; by dual
    /// numbers unless overridden.
    ///
    /// # Errors
    /// As for [`DoubledLagrangian::value`].
    fn velocity_hessian(
        &self,
        t: T,
        eta: &Vector<T, N>,
        u: &Matrix<T, D>,
        psi: &Vector<T, N>,
    ) -> Result<Both<Both<Matrix<T, N>>>, RetractionError> {
        velocity_hessian_by_duals(self, t, eta, u, psi)
    }

    /// All partial derivatives; by dual numbers unless overridden.
    ///
    /// # Errors
    /// As for [`DoubledLagrangian::value`].
    fn partials<S: Scalar<Base = T>>(
        &self,
        t: S,
        eta: &Vector<S, N>,
        u: &Matrix<S, D>,
        psi: &Vector<S, N>,
    ) -> Result<Partials<S, N>, RetractionError> {
        partials_by_duals(self, t, eta, u, psi)
    }
}

impl<T: Real, L: DoubledLagrangian<T, N, D>, const N: usize, const D: usize> DoubledLagrangian<T, N, D> for &L {
    fn value<S: Scalar<Base = T>>(
        &self,
        t: S,
        eta: &Vector<S, N>,
        u: &Matrix<S, D>,
        psi: &Vector<S, N>,
    ) -> Result<S, RetractionError> {
        (**self).value(t, eta, u, psi)
    }

    fn uses_configuration(&self) -> bool {
        (**self).uses_configuration()
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        (**self).hat(xi)
    }

    fn unit_velocities(
        &self,
        lambda: &Covector<T, N>,
        mu: &Covector<T, N>,
    ) -> Result<(Vector<T, N>, Vector<T, N>), LegendreError> {
        (**self).unit_velocities(lambda, mu)
    }

    fn velocities(
        &self,
        t: T,
        lambda: &Covector<T, N>,
        u: &Matrix<T, D>,
        mu: &Covector<T, N>,
    ) -> Result<(Vector<T, N>, Vector<T, N>), VelocityError> {
        (**self).velocities(t, lambda, u, mu)
    }

    fn velocity_hessian(
        &self,
        t: T,
        eta: &Vector<T, N>,
        u: &Matrix<T, D>,
        psi: &Vector<T, N>,
    ) -> Result<Both<Both<Matrix<T, N>>>, RetractionError> {
        (**self).velocity_hessian(t, eta, u, psi)
    }

    fn partials<S: Scalar<Base = T>>(
        &self,
        t: S,
        eta: &Vector<S, N>,
        u: &Matrix<S, D>,
        psi: &Vector<S, N>,
    ) -> Result<Partials<S, N>, RetractionError> {
        (**self).partials(t, eta, u, psi)
    }
}

/// The partial derivatives by dual numbers: U is moved to U(1 + ε ê_a) and to (1 + ε ê_a)U, which are exact as ε² = 0.
///
/// # Errors
/// Those of the value and of `hat`.
pub fn partials_by_duals<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    doubled: &(impl DoubledLagrangian<T, N, D> + ?Sized),
    t: S,
    eta: &Vector<S, N>,
    u: &Matrix<S, D>,
    psi: &Vector<S, N>,
) -> Result<Partials<S, N>, RetractionError> {
    let zero = Covector::<S, N>::zeros();
    let mut partials = Partials { eta: zero, left: zero, right: zero, psi: zero };
    let time = Dual::constant(t);
    let (eta0, psi0, u0) = (eta.map(Dual::constant), psi.map(Dual::constant), u.map(Dual::constant));
    for a in 0..N {
        let e = basis_vector::<S, N>(a);
        let hat = doubled.hat(&e)?;
        let along = |direction: Matrix<S, D>| u.zip_map(&direction, |re, eps| Dual { re, eps });
        let moved = |x: &Vector<S, N>| x.zip_map(&e, |re, eps| Dual { re, eps });
        partials.eta[a] = doubled.value(time, &moved(eta), &u0, &psi0)?.eps;
        partials.left[a] = doubled.value(time, &eta0, &along(u * hat), &psi0)?.eps;
        partials.right[a] = doubled.value(time, &eta0, &along(hat * u), &psi0)?.eps;
        partials.psi[a] = doubled.value(time, &eta0, &u0, &moved(psi))?.eps;
    }
    Ok(partials)
}

/// Newton steps for the velocities; the coupling is a small perturbation near the units.
const MAX_ITERATIONS: usize = 40;

/// The first and the second copy's components.
pub type Both<V> = (V, V);

fn newton_velocities<T: Real, const N: usize, const D: usize>(
    doubled: &(impl DoubledLagrangian<T, N, D> + ?Sized),
    t: T,
    lambda: &Covector<T, N>,
    u: &Matrix<T, D>,
    mu: &Covector<T, N>,
) -> Result<Both<Vector<T, N>>, VelocityError> {
    let largest = |v: &Both<Vector<T, N>>| larger(larger(T::zero(), v.0.as_slice()), v.1.as_slice());
    let unit = T::unit_roundoff();
    let (mut eta, mut psi) = doubled.unit_velocities(lambda, mu)?;
    let momenta = largest(&(lambda.transpose(), mu.transpose()));
    let (mut size, mut close) = (T::zero(), false);
    for _ in 0..MAX_ITERATIONS {
        let partials = doubled.partials(t, &eta, u, &psi)?;
        let residual = ((-partials.eta - lambda).transpose(), (partials.psi - mu).transpose());
        size = largest(&residual);
        if close || size <= T::int(4 * N as i64) * unit * momenta {
            return Ok((eta, psi));
        }
        let [[a, b], [c, d]] = inverse_velocity_hessian(doubled, t, &eta, u, &psi)?;
        let step = (a * residual.0 + b * residual.1, c * residual.0 + d * residual.1);
        // A step below √u leaves an error of the order of round-off.
        close = largest(&step) <= unit.sqrt() * largest(&(eta, psi));
        eta -= step.0;
        psi -= step.1;
        if !finite(eta.as_slice()) || !finite(psi.as_slice()) {
            break;
        }
    }
    Err(LegendreError::NotConverged { residual: size.to_f64(), iterations: MAX_ITERATIONS }.into())
}

/// [`DoubledLagrangian::velocity_hessian`] from the partial derivatives on dual numbers.
///
/// # Errors
/// Those of the partial derivatives.
pub fn velocity_hessian_by_duals<T: Real, const N: usize, const D: usize>(
    doubled: &(impl DoubledLagrangian<T, N, D> + ?Sized),
    t: T,
    eta: &Vector<T, N>,
    u: &Matrix<T, D>,
    psi: &Vector<T, N>,
) -> Result<Both<Both<Matrix<T, N>>>, RetractionError> {
    let columns = |which: bool| -> Result<Both<Matrix<T, N>>, RetractionError> {
        let (mut first, mut second) = (Matrix::<T, N>::zeros(), Matrix::<T, N>::zeros());
        for a in 0..N {
            let (mut left, mut right) = (eta.map(Dual::constant), psi.map(Dual::constant));
            if which {
                left[a].eps = T::one()
            } else {
                right[a].eps = T::one()
            }
            let moved = doubled.partials(Dual::constant(t), &left, &u.map(Dual::constant), &right)?;
            first.set_column(a, &moved.eta.map(|v| v.eps).transpose());
            second.set_column(a, &moved.psi.map(|v| v.eps).transpose());
        }
        Ok((first, second))
    };
    Ok((columns(true)?, columns(false)?))
}

/// The largest of m and the absolute values.
fn larger<T: Real>(m: T, values: &[T]) -> T {
    values.iter().fold(m, |m, x| m.max(x.abs()))
}

/// The error that says that the Lagrangian is singular at these two velocities.
#[cold]
pub(super) fn singular<T: Scalar>(eta: &[T], psi: &[T]) -> LegendreError {
    LegendreError::Singular { velocity: eta.iter().chain(psi).map(|v| v.to_f64()).collect(), rank: None }
}

/// J⁻¹ by blocks, J the Jacobian of (−∂l/∂η, ∂l/∂ψ) in (η, ψ).
pub(super) fn inverse_velocity_hessian<T: Real, const N: usize, const D: usize>(
    doubled: &(impl DoubledLagrangian<T, N, D> + ?Sized),
    t: T,
    eta: &Vector<T, N>,
    u: &Matrix<T, D>,
    psi: &Vector<T, N>,
) -> Result<[[Matrix<T, N>; 2]; 2], VelocityError> {
    let ((a, c), (b, d)) = doubled.velocity_hessian(t, eta, u, psi)?;
    let singular = || singular(eta.as_slice(), psi.as_slice());
    let inverse = elimination::inverse(&-a).ok_or_else(singular)?;
    let (lower, upper) = (c * inverse, -(inverse * b));
    let schur = elimination::inverse(&(d - c * upper)).ok_or_else(singular)?;
    Ok([[inverse + upper * schur * lower, -(upper * schur)], [-(schur * lower), schur]])
}

/// l_f(η, U, ψ) = l(ψ) − l(η) − k_f(η, U, ψ), k_f = −½ ⟨f(t, η) + f(t, ψ), τ⁻¹(U)⟩.
///
/// Antisymmetric under (η, U, ψ) ↦ (ψ, U⁻¹, η). Domain: U in that of τ⁻¹.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Forced<L, F, R> {
    /// l.
    pub lagrangian: L,
    /// f.
    pub force: F,
    /// τ.
    pub retraction: R,
}

impl<L, F, R> Forced<L, F, R> {
    /// The doubled Lagrangian of the system with Lagrangian l and force f, with the retraction τ in its coupling.
    pub fn new(lagrangian: L, force: F, retraction: R) -> Self {
        Self { lagrangian, force, retraction }
    }

    /// k_f(η, U, ψ) = −½ ⟨f(t, η) + f(t, ψ), τ⁻¹(U)⟩.
    ///
    /// # Errors
    /// U outside the domain of τ⁻¹.
    pub fn coupling<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        t: S,
        eta: &Vector<S, N>,
        u: &Matrix<S, D>,
        psi: &Vector<S, N>,
    ) -> Result<S, RetractionError>
    where
        F: Force<T, N>,
        R: Retraction<T, N, D>,
    {
        let total = self.force.force(t, eta) + self.force.force(t, psi);
        Ok(-S::half() * pair(&total, &self.retraction.tau_inv(u)?))
    }

    /// The same k_f as it was defined, ½ (⟨f(t, ψ), τ⁻¹(U⁻¹)⟩ − ⟨f(t, η), τ⁻¹(U)⟩).
    ///
    /// # Errors
    /// U singular, U or U⁻¹ outside the domain of τ⁻¹.
    pub fn coupling_as_defined<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        t: S,
        eta: &Vector<S, N>,
        u: &Matrix<S, D>,
        psi: &Vector<S, N>,
    ) -> Result<S, RetractionError>
    where
        F: Force<T, N>,
        R: Retraction<T, N, D>,
    {
        let singular = || RetractionError::NoPreimage { retraction: self.retraction.name(), why: "U is singular" };
        let inverse = elimination::quick_inverse(u).ok_or_else(singular)?;
        let there = pair(&self.force.force(t, psi), &self.retraction.tau_inv(&inverse)?);
        let here = pair(&self.force.force(t, eta), &self.retraction.tau_inv(u)?);
        Ok(S::half() * (there - here))
    }
}

/// ξ̂ = d/dε τ(εξ) at ε = 0.
pub(super) fn hat<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    retraction: &impl Retraction<T, N, D>,
    xi: &Vector<S, N>,
) -> Result<Matrix<S, D>, RetractionError> {
    let along = xi.map(|eps| Dual { re: S::zero(), eps });
    Ok(retraction.tau(&along)?.map(|v| v.eps))
}

/// The covector v ↦ ⟨∂f/∂η(t, η) v, x⟩.
pub(super) fn force_derivative<T: Real, S: Scalar<Base = T>, const N: usize>(
    force: &impl Force<T, N>,
    t: S,
    eta: &Vector<S, N>,
    x: &Vector<S, N>,
) -> Covector<S, N> {
    Covector::from_fn(|_, a| force_slope(force, t, eta, a, x))
}

/// ⟨∂f/∂η^a(t, η), x⟩.
fn force_slope<T: Real, S: Scalar<Base = T>, const N: usize>(
    force: &impl Force<T, N>,
    t: S,
    eta: &Vector<S, N>,
    a: usize,
    x: &Vector<S, N>,
) -> S {
    pair(&force.force(Dual::constant(t), &along(eta, a)).map(|v| v.eps), x)
}

impl<T, L, F, R, const N: usize, const D: usize> DoubledLagrangian<T, N, D> for Forced<L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    fn value<S: Scalar<Base = T>>(
        &self,
        t: S,
        eta: &Vector<S, N>,
        u: &Matrix<S, D>,
        psi: &Vector<S, N>,
    ) -> Result<S, RetractionError> {
        Ok(self.lagrangian.value(psi) - self.lagrangian.value(eta) - self.coupling(t, eta, u, psi)?)
    }

    fn uses_configuration(&self) -> bool {
        self.force.uses_configuration() || self.lagrangian.uses_configuration()
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        hat(&self.retraction, xi)
    }

    fn unit_velocities(
        &self,
        lambda: &Covector<T, N>,
        mu: &Covector<T, N>,
    ) -> Result<(Vector<T, N>, Vector<T, N>), LegendreError> {
        let eta = self.lagrangian.velocity(lambda, &Vector::zeros())?;
        let psi = self.lagrangian.velocity(mu, &eta)?;
        Ok((eta, psi))
    }

    /// The two velocities do not mix: ∂²l/∂η² = −l''(η) + ½ ⟨f''(η)(·,·), x⟩, ∂²l/∂ψ² = l''(ψ) + ½ ⟨f''(ψ)(·,·), x⟩.
    fn velocity_hessian(
        &self,
        t: T,
        eta: &Vector<T, N>,
        u: &Matrix<T, D>,
        psi: &Vector<T, N>,
    ) -> Result<Both<Both<Matrix<T, N>>>, RetractionError> {
        let x = self.retraction.tau_inv(u)?;
        let lifted = x.map(Dual::constant);
        let second = |eta: &Vector<T, N>| {
            // It is symmetric.
            let mut second = Matrix::<T, N>::zeros();
            for a in 0..N {
                let moved = along(eta, a);
                for b in 0..=a {
                    let slope = force_slope(&self.force, Dual::constant(t), &moved, b, &lifted).eps * T::half();
                    (second[(a, b)], second[(b, a)]) = (slope, slope);
                }
            }
            second
        };
        let (first, last) = (second(eta) - self.lagrangian.hessian(eta), second(psi) + self.lagrangian.hessian(psi));
        Ok(((first, Matrix::zeros()), (Matrix::zeros(), last)))
    }

    /// In closed form, with x = τ⁻¹(U) and F = f(t, η) + f(t, ψ): L*_U ∂l/∂U = ½ F dτ_x⁻¹, R*_U = Ad*_{U⁻¹} L*_U,
    /// ∂l/∂η = −l'(η) + ½ ⟨f'(η)·, x⟩, ∂l/∂ψ = l'(ψ) + ½ ⟨f'(ψ)·, x⟩.
    fn partials<S: Scalar<Base = T>>(
        &self,
        t: S,
        eta: &Vector<S, N>,
        u: &Matrix<S, D>,
        psi: &Vector<S, N>,
    ) -> Result<Partials<S, N>, RetractionError> {
        let x = self.retraction.tau_inv(u)?;
        let point = self.retraction.at(&x)?;
        let total = self.force.force(t, eta) + self.force.force(t, psi);
        let left = total * point.d_inv() * S::half();
        let right = left * point.ad_inv();
        let eta = force_derivative(&self.force, t, eta, &x) * S::half() - self.lagrangian.gradient(eta);
        let psi = force_derivative(&self.force, t, psi, &x) * S::half() + self.lagrangian.gradient(psi);
        Ok(Partials { eta, left, right, psi })
    }
}
