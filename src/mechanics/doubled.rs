//! Doubled Lagrangians on g×G×g and the one that generates a forced system.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/mechanics/doubled.md"))]

use super::legendre::largest;
use super::{Force, Lagrangian, LegendreError};
use crate::algebra::{Covector, Matrix, Vector, basis_vector, elimination, pair};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::dual::{along, moving};
use crate::scalar::{Dual, Real, Scalar, finite};

/// A time and a point of g×G×g, or the rates at which they change; G is represented by D×D matrices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityPoint<S: Scalar, const N: usize, const D: usize> {
    /// t.
    pub time: S,
    /// η.
    pub eta: Vector<S, N>,
    /// U.
    pub u: Matrix<S, D>,
    /// ψ.
    pub psi: Vector<S, N>,
}

/// A time and a point of g*×G×g*, or the rates at which they change.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MomentumPoint<S: Scalar, const N: usize, const D: usize> {
    /// t.
    pub time: S,
    /// λ.
    pub lambda: Covector<S, N>,
    /// U.
    pub u: Matrix<S, D>,
    /// μ.
    pub mu: Covector<S, N>,
}

macro_rules! point {
    ($point:ident, $first:ident, $second:ident) => {
        impl<S: Scalar, const N: usize, const D: usize> $point<S, N, D> {
            /// Every number by `f`.
            pub fn map<O: Scalar>(&self, f: impl Fn(S) -> O) -> $point<O, N, D> {
                let ($first, $second) = (self.$first.map(&f), self.$second.map(&f));
                $point { time: f(self.time), $first, u: self.u.map(&f), $second }
            }

            /// The point on dual numbers, moving at these rates.
            pub fn moving(&self, rates: &Self) -> $point<Dual<S>, N, D> {
                let ($first, $second) = (moving(&self.$first, &rates.$first), moving(&self.$second, &rates.$second));
                $point { time: Dual { re: self.time, eps: rates.time }, $first, u: moving(&self.u, &rates.u), $second }
            }
        }
    };
}
point!(VelocityPoint, eta, psi);
point!(MomentumPoint, lambda, mu);

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

/// The first and the second copy's components.
pub type Both<V> = (V, V);

/// A Lagrangian on g×G×g, perhaps depending on time; G is represented by D×D matrices.
pub trait DoubledLagrangian<T: Real, const N: usize, const D: usize> {
    /// **l**(t; η, U, ψ).
    ///
    /// # Errors
    /// U outside the domain.
    fn value<S: Scalar<Base = T>>(&self, at: &VelocityPoint<S, N, D>) -> Result<S, RetractionError>;

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

    /// The velocities (η, ψ) with λ = −∂l/∂η and μ = ∂l/∂ψ on the units U = e, where Newton's method for [`velocities`](Self::velocities)
    /// starts; or other velocities to start from, 0 unless overridden.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform.
    fn unit_velocities(
        &self,
        lambda: &Covector<T, N>,
        mu: &Covector<T, N>,
    ) -> Result<Both<Vector<T, N>>, LegendreError> {
        let _ = (lambda, mu);
        Ok((Vector::zeros(), Vector::zeros()))
    }

    /// The velocities (η, ψ) with λ = −∂l/∂η(η, U, ψ) and μ = ∂l/∂ψ(η, U, ψ): the inverse of the modified Legendre
    /// transform, by Newton's method from the velocities on the units.
    ///
    /// # Errors
    /// No convergence, singular second derivatives, U outside the domain.
    fn velocities(&self, at: &MomentumPoint<T, N, D>) -> Result<Both<Vector<T, N>>, VelocityError> {
        let MomentumPoint { time, lambda, u, mu } = *at;
        let largest = |v: &Both<Vector<T, N>>| largest(v.0.iter().chain(&v.1));
        let unit = T::unit_roundoff();
        let (eta, psi) = self.unit_velocities(&lambda, &mu)?;
        let mut point = VelocityPoint { time, eta, u, psi };
        let momenta = largest(&(lambda.transpose(), mu.transpose()));
        let (mut size, mut close) = (T::zero(), false);
        for _ in 0..MAX_ITERATIONS {
            let partials = self.partials(&point)?;
            let residual = ((-partials.eta - lambda).transpose(), (partials.psi - mu).transpose());
            size = largest(&residual);
            if close || size <= T::int(4 * N as i64) * unit * momenta {
                return Ok((point.eta, point.psi));
            }
            let [[a, b], [c, d]] = inverse_velocity_hessian(self, &point)?;
            let step = (a * residual.0 + b * residual.1, c * residual.0 + d * residual.1);
            // A step below √u leaves an error of the order of round-off.
            close = largest(&step) <= unit.sqrt() * largest(&(point.eta, point.psi));
            point.eta -= step.0;
            point.psi -= step.1;
            if !finite(point.eta.as_slice()) || !finite(point.psi.as_slice()) {
                break;
            }
        }
        Err(LegendreError::NotConverged { residual: size.to_f64(), iterations: MAX_ITERATIONS }.into())
    }

    /// The second derivatives in the velocities, N×N blocks by columns: of (∂l/∂η, ∂l/∂ψ) along η, then along ψ; by dual
    /// numbers unless overridden.
    ///
    /// # Errors
    /// As for [`DoubledLagrangian::value`].
    fn velocity_hessian(&self, at: &VelocityPoint<T, N, D>) -> Result<Both<Both<Matrix<T, N>>>, RetractionError> {
        velocity_hessian_by_duals(self, at)
    }

    /// All partial derivatives; by dual numbers unless overridden.
    ///
    /// # Errors
    /// As for [`DoubledLagrangian::value`].
    fn partials<S: Scalar<Base = T>>(&self, at: &VelocityPoint<S, N, D>) -> Result<Partials<S, N>, RetractionError> {
        partials_by_duals(self, at)
    }
}

/// The partial derivatives by dual numbers: U is moved to U(1 + ε ê_a) and to (1 + ε ê_a)U, which are exact as ε² = 0.
///
/// # Errors
/// Those of the value and of `hat`.
pub fn partials_by_duals<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    doubled: &(impl DoubledLagrangian<T, N, D> + ?Sized),
    at: &VelocityPoint<S, N, D>,
) -> Result<Partials<S, N>, RetractionError> {
    let zero = Covector::<S, N>::zeros();
    let mut partials = Partials { eta: zero, left: zero, right: zero, psi: zero };
    let still = at.map(|_| S::zero());
    for a in 0..N {
        let e = basis_vector::<S, N>(a);
        let hat = doubled.hat(&e)?;
        let slope = |rates: VelocityPoint<S, N, D>| doubled.value(&at.moving(&rates)).map(|v| v.eps);
        partials.eta[a] = slope(VelocityPoint { eta: e, ..still })?;
        partials.left[a] = slope(VelocityPoint { u: at.u * hat, ..still })?;
        partials.right[a] = slope(VelocityPoint { u: hat * at.u, ..still })?;
        partials.psi[a] = slope(VelocityPoint { psi: e, ..still })?;
    }
    Ok(partials)
}

/// Newton steps for the velocities; the coupling is a small perturbation near the units.
const MAX_ITERATIONS: usize = 40;

/// [`DoubledLagrangian::velocity_hessian`] from the partial derivatives on dual numbers.
///
/// # Errors
/// Those of the partial derivatives.
pub fn velocity_hessian_by_duals<T: Real, const N: usize, const D: usize>(
    doubled: &(impl DoubledLagrangian<T, N, D> + ?Sized),
    at: &VelocityPoint<T, N, D>,
) -> Result<Both<Both<Matrix<T, N>>>, RetractionError> {
    let columns = |which: bool| -> Result<Both<Matrix<T, N>>, RetractionError> {
        let (mut first, mut second) = (Matrix::<T, N>::zeros(), Matrix::<T, N>::zeros());
        for a in 0..N {
            let mut moving = at.map(Dual::constant);
            let velocity = if which { &mut moving.eta } else { &mut moving.psi };
            velocity[a].eps = T::one();
            let moved = doubled.partials(&moving)?;
            first.set_column(a, &moved.eta.map(|v| v.eps).transpose());
            second.set_column(a, &moved.psi.map(|v| v.eps).transpose());
        }
        Ok((first, second))
    };
    Ok((columns(true)?, columns(false)?))
}

/// The error that says that the Lagrangian is singular at these two velocities.
#[cold]
pub(super) fn singular<T: Scalar, const N: usize, const D: usize>(at: &VelocityPoint<T, N, D>) -> LegendreError {
    LegendreError::Singular { velocity: at.eta.iter().chain(&at.psi).map(|v| v.to_f64()).collect(), rank: None }
}

/// J⁻¹ by blocks, J the Jacobian of (−∂l/∂η, ∂l/∂ψ) in (η, ψ).
pub(super) fn inverse_velocity_hessian<T: Real, const N: usize, const D: usize>(
    doubled: &(impl DoubledLagrangian<T, N, D> + ?Sized),
    at: &VelocityPoint<T, N, D>,
) -> Result<[[Matrix<T, N>; 2]; 2], VelocityError> {
    let ((a, c), (b, d)) = doubled.velocity_hessian(at)?;
    let singular = || singular(at);
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
        at: &VelocityPoint<S, N, D>,
    ) -> Result<S, RetractionError>
    where
        F: Force<T, N>,
        R: Retraction<T, N, D>,
    {
        Ok(-S::half() * pair(&self.forces(at), &self.retraction.tau_inv(&at.u)?))
    }

    /// The same k_f as it was defined, ½ (⟨f(t, ψ), τ⁻¹(U⁻¹)⟩ − ⟨f(t, η), τ⁻¹(U)⟩).
    ///
    /// # Errors
    /// U singular, U or U⁻¹ outside the domain of τ⁻¹.
    pub fn coupling_as_defined<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        at: &VelocityPoint<S, N, D>,
    ) -> Result<S, RetractionError>
    where
        F: Force<T, N>,
        R: Retraction<T, N, D>,
    {
        let singular = || RetractionError::NoPreimage { retraction: self.retraction.name(), why: "U is singular" };
        let inverse = elimination::quick_inverse(&at.u).ok_or_else(singular)?;
        let there = pair(&self.force.force(at.time, &at.psi), &self.retraction.tau_inv(&inverse)?);
        let here = pair(&self.force.force(at.time, &at.eta), &self.retraction.tau_inv(&at.u)?);
        Ok(S::half() * (there - here))
    }

    /// f(t, η) + f(t, ψ).
    pub(super) fn forces<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        at: &VelocityPoint<S, N, D>,
    ) -> Covector<S, N>
    where
        F: Force<T, N>,
    {
        self.force.force(at.time, &at.eta) + self.force.force(at.time, &at.psi)
    }
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
    fn value<S: Scalar<Base = T>>(&self, at: &VelocityPoint<S, N, D>) -> Result<S, RetractionError> {
        Ok(self.lagrangian.value(&at.psi) - self.lagrangian.value(&at.eta) - self.coupling(at)?)
    }

    fn uses_configuration(&self) -> bool {
        self.force.uses_configuration() || self.lagrangian.uses_configuration()
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        // d/dε τ(εξ) at ε = 0.
        let along = xi.map(|eps| Dual { re: S::zero(), eps });
        Ok(self.retraction.tau(&along)?.map(|v| v.eps))
    }

    fn unit_velocities(
        &self,
        lambda: &Covector<T, N>,
        mu: &Covector<T, N>,
    ) -> Result<Both<Vector<T, N>>, LegendreError> {
        let eta = self.lagrangian.velocity(lambda, &Vector::zeros())?;
        let psi = self.lagrangian.velocity(mu, &eta)?;
        Ok((eta, psi))
    }

    /// The two velocities do not mix: ∂²l/∂η² = −l''(η) + ½ ⟨f''(η)(·,·), x⟩, ∂²l/∂ψ² = l''(ψ) + ½ ⟨f''(ψ)(·,·), x⟩.
    fn velocity_hessian(&self, at: &VelocityPoint<T, N, D>) -> Result<Both<Both<Matrix<T, N>>>, RetractionError> {
        let lifted = self.retraction.tau_inv(&at.u)?.map(Dual::constant);
        let second = |eta: &Vector<T, N>| {
            // It is symmetric.
            let mut second = Matrix::<T, N>::zeros();
            for a in 0..N {
                let moved = along(eta, a);
                for b in 0..=a {
                    let slope = force_slope(&self.force, Dual::constant(at.time), &moved, b, &lifted).eps * T::half();
                    (second[(a, b)], second[(b, a)]) = (slope, slope);
                }
            }
            second
        };
        let first = second(&at.eta) - self.lagrangian.hessian(&at.eta);
        let last = second(&at.psi) + self.lagrangian.hessian(&at.psi);
        Ok(((first, Matrix::zeros()), (Matrix::zeros(), last)))
    }

    /// In closed form, with x = τ⁻¹(U) and F = f(t, η) + f(t, ψ): L*_U ∂l/∂U = ½ F dτ_x⁻¹, R*_U = Ad*_{U⁻¹} L*_U,
    /// ∂l/∂η = −l'(η) + ½ ⟨f'(η)·, x⟩, ∂l/∂ψ = l'(ψ) + ½ ⟨f'(ψ)·, x⟩.
    fn partials<S: Scalar<Base = T>>(&self, at: &VelocityPoint<S, N, D>) -> Result<Partials<S, N>, RetractionError> {
        let x = self.retraction.tau_inv(&at.u)?;
        let point = self.retraction.at(&x)?;
        let left = self.forces(at) * point.d_inv() * S::half();
        let right = left * point.ad_inv();
        let slope = |eta: &Vector<S, N>| force_derivative(&self.force, at.time, eta, &x) * S::half();
        let eta = slope(&at.eta) - self.lagrangian.gradient(&at.eta);
        let psi = slope(&at.psi) + self.lagrangian.gradient(&at.psi);
        Ok(Partials { eta, left, right, psi })
    }
}
