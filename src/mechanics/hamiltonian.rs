//! Hamiltonians on Γ = g*×G×g*, their equations of motion, and the modified Legendre transforms that lead there and back.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/mechanics/hamiltonian.md"))]

use super::LegendreError;
use super::doubled::{
    Both, DoubledLagrangian, MomentumPoint, VelocityError, VelocityPoint, inverse_velocity_hessian, singular,
};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, basis_vector, pair};
use crate::newton::{Equations, Failure, Newton, NewtonSettings};
use crate::retraction::RetractionError;
use crate::scalar::{Dual, Real, Scalar};
use nalgebra::DMatrix;

/// The partial derivatives of a function of (λ, U, μ).
#[derive(Clone, Debug, PartialEq)]
pub struct MomentumPartials<S: Scalar, const N: usize> {
    /// ∂h/∂λ, in g.
    pub lambda: Vector<S, N>,
    /// L*_U ∂h/∂U: ξ ↦ d/dε h(λ, U exp(εξ), μ).
    pub left: Covector<S, N>,
    /// R*_U ∂h/∂U: ξ ↦ d/dε h(λ, exp(εξ) U, μ).
    pub right: Covector<S, N>,
    /// ∂h/∂μ, in g.
    pub mu: Vector<S, N>,
}

/// A Hamiltonian on g*×G×g*, perhaps depending on time; G is represented by D×D matrices.
pub trait DoubledHamiltonian<T: Real, const N: usize, const D: usize> {
    /// **h**(t; λ, U, μ).
    ///
    /// # Errors
    /// A point outside the domain.
    fn value<S: Scalar<Base = T>>(&self, at: &MomentumPoint<S, N, D>) -> Result<S, VelocityError>;

    /// ξ̂, the matrix of an element of g.
    ///
    /// # Errors
    /// There are no matrices (an algebra without a group).
    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError>;

    /// All partial derivatives; by dual numbers unless overridden.
    ///
    /// # Errors
    /// As for [`DoubledHamiltonian::value`].
    fn partials<S: Scalar<Base = T>>(
        &self,
        at: &MomentumPoint<S, N, D>,
    ) -> Result<MomentumPartials<S, N>, VelocityError> {
        momentum_partials_by_duals(self, at)
    }
}

/// The partial derivatives by dual numbers: U is moved to U(1 + ε ê_a) and to (1 + ε ê_a)U, which are exact as ε² = 0.
///
/// # Errors
/// Those of the value and of `hat`.
pub fn momentum_partials_by_duals<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    hamiltonian: &(impl DoubledHamiltonian<T, N, D> + ?Sized),
    at: &MomentumPoint<S, N, D>,
) -> Result<MomentumPartials<S, N>, VelocityError> {
    let (vector, covector) = (Vector::<S, N>::zeros(), Covector::<S, N>::zeros());
    let mut partials = MomentumPartials { lambda: vector, left: covector, right: covector, mu: vector };
    let still = at.map(|_| S::zero());
    for a in 0..N {
        let e = basis_vector::<S, N>(a);
        let hat = hamiltonian.hat(&e)?;
        let slope = |rates: MomentumPoint<S, N, D>| hamiltonian.value(&at.moving(&rates)).map(|v| v.eps);
        partials.lambda[a] = slope(MomentumPoint { lambda: e.transpose(), ..still })?;
        partials.left[a] = slope(MomentumPoint { u: at.u * hat, ..still })?;
        partials.right[a] = slope(MomentumPoint { u: hat * at.u, ..still })?;
        partials.mu[a] = slope(MomentumPoint { mu: e.transpose(), ..still })?;
    }
    Ok(partials)
}

/// The rates of (t; λ, U, μ) along a solution: λ̇ = −ad*_{∂h/∂λ} λ − R*_U ∂h/∂U, μ̇ = ad*_{∂h/∂μ} μ − L*_U ∂h/∂U, U̇ = U ∂h/∂μ + ∂h/∂λ U (as matrices): the
/// Hamiltonian vector field of the bracket of Γ (Martín de Diego and Sato Martín de Almagro 2019, §4.3).
///
/// # Errors
/// A point outside the domain of the Hamiltonian; no group.
pub fn hamilton_rates<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    hamiltonian: &impl DoubledHamiltonian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    at: &MomentumPoint<S, N, D>,
) -> Result<MomentumPoint<S, N, D>, VelocityError> {
    let partials = hamiltonian.partials(at)?;
    Ok(MomentumPoint {
        time: S::one(),
        lambda: -algebra.coad(&partials.lambda, &at.lambda) - partials.right,
        u: at.u * hamiltonian.hat(&partials.mu)? + hamiltonian.hat(&partials.lambda)? * at.u,
        mu: algebra.coad(&partials.mu, &at.mu) - partials.left,
    })
}

/// The modified Legendre transform of **l**: λ = −∂l/∂η, μ = ∂l/∂ψ, t and U unchanged. Its inverse is
/// [`DoubledLagrangian::velocities`].
///
/// # Errors
/// U outside the domain of the Lagrangian.
pub fn modified_legendre<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    at: &VelocityPoint<S, N, D>,
) -> Result<MomentumPoint<S, N, D>, RetractionError> {
    let partials = doubled.partials(at)?;
    Ok(MomentumPoint { time: at.time, lambda: -partials.eta, u: at.u, mu: partials.psi })
}

/// ⟨(λ, U, μ), (η, U, ψ)⟩_× = ⟨μ, ψ⟩ − ⟨λ, η⟩, the pairing in which the modified Legendre transform is the fibre
/// derivative (Martín de Diego and Sato Martín de Almagro 2019, §4.3).
pub fn modified_pairing<S: Scalar, const N: usize, const D: usize>(
    momenta: &MomentumPoint<S, N, D>,
    velocities: &VelocityPoint<S, N, D>,
) -> S {
    pair(&momenta.mu, &velocities.psi) - pair(&momenta.lambda, &velocities.eta)
}

/// h̃ = E_l∘(FL×)⁻¹, the Hamiltonian that the modified Legendre transform of a regular **l** defines:
/// h̃(λ, U, μ) = ⟨μ, ψ⟩ − ⟨λ, η⟩ − l(η, U, ψ) at the velocities of (λ, U, μ).
///
/// Domain: that of the inverse transform, a neighbourhood of the units for l_f. The solutions of its equations are those
/// of the Euler–Lagrange equations of **l**.
#[derive(Clone, Debug, PartialEq)]
pub struct LegendreHamiltonian<L> {
    /// **l**.
    pub doubled: L,
}

impl<L> LegendreHamiltonian<L> {
    /// The Hamiltonian of a doubled Lagrangian.
    pub fn new(doubled: L) -> Self {
        Self { doubled }
    }

    /// The point with λ = −∂l/∂η and μ = ∂l/∂ψ, derivative parts included.
    ///
    /// The value by [`DoubledLagrangian::velocities`]; then, for k nested duals, k corrections with the inverse second
    /// derivatives at that value: each makes the error one order smaller in the derivative parts.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform.
    pub fn velocities<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        at: &MomentumPoint<S, N, D>,
    ) -> Result<VelocityPoint<S, N, D>, VelocityError>
    where
        L: DoubledLagrangian<T, N, D>,
    {
        let base = at.map(|v| v.base());
        let (eta, psi) = self.doubled.velocities(&base)?;
        let value = VelocityPoint { time: base.time, eta, u: base.u, psi };
        let mut point = VelocityPoint { time: at.time, eta: eta.map(S::lift), u: at.u, psi: psi.map(S::lift) };
        let order = (size_of::<S>() / size_of::<T>()).ilog2();
        if order == 0 {
            return Ok(point);
        }
        let inverse = inverse_velocity_hessian(&self.doubled, &value)?;
        for _ in 0..order {
            let momenta = modified_legendre(&self.doubled, &point)?;
            let (r, s) = ((momenta.lambda - at.lambda).transpose(), (momenta.mu - at.mu).transpose());
            let [[a, b], [c, d]] = inverse.each_ref().map(|row| row.each_ref().map(|block| block.map(S::lift)));
            point.eta -= a * r + b * s;
            point.psi -= c * r + d * s;
        }
        Ok(point)
    }
}

impl<T: Real, L: DoubledLagrangian<T, N, D>, const N: usize, const D: usize> DoubledHamiltonian<T, N, D>
    for LegendreHamiltonian<L>
{
    fn value<S: Scalar<Base = T>>(&self, at: &MomentumPoint<S, N, D>) -> Result<S, VelocityError> {
        let point = self.velocities(at)?;
        Ok(modified_pairing(at, &point) - self.doubled.value(&point)?)
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        self.doubled.hat(xi)
    }

    /// ∂h̃/∂λ = −η, ∂h̃/∂U = −∂l/∂U, ∂h̃/∂μ = ψ at the velocities: the terms in which these vary cancel.
    fn partials<S: Scalar<Base = T>>(
        &self,
        at: &MomentumPoint<S, N, D>,
    ) -> Result<MomentumPartials<S, N>, VelocityError> {
        let point = self.velocities(at)?;
        let partials = self.doubled.partials(&point)?;
        Ok(MomentumPartials { lambda: -point.eta, left: -partials.left, right: -partials.right, mu: point.psi })
    }
}

/// Fh×(λ, U, μ) = (−∂h/∂λ, U, ∂h/∂μ): the velocities (η, ψ) of a Hamiltonian.
///
/// # Errors
/// A point outside the domain of the Hamiltonian.
pub fn hamiltonian_legendre<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    hamiltonian: &impl DoubledHamiltonian<T, N, D>,
    at: &MomentumPoint<S, N, D>,
) -> Result<VelocityPoint<S, N, D>, VelocityError> {
    let partials = hamiltonian.partials(at)?;
    Ok(VelocityPoint { time: at.time, eta: -partials.lambda, u: at.u, psi: partials.mu })
}

/// The Jacobian of Fh× at fixed U, 2N×2N: rows (−∂h/∂λ, ∂h/∂μ), columns (λ, μ). For **h** = h_f it is
/// diag(h'', h'') on the units (Martín de Diego and Sato Martín de Almagro 2019, Proposition 4.12).
///
/// # Errors
/// A point outside the domain of the Hamiltonian.
pub fn hamiltonian_legendre_jacobian<T: Real, const N: usize, const D: usize>(
    hamiltonian: &impl DoubledHamiltonian<T, N, D>,
    at: &MomentumPoint<T, N, D>,
) -> Result<DMatrix<T>, VelocityError> {
    let mut jacobian = DMatrix::zeros(2 * N, 2 * N);
    for column in 0..2 * N {
        let mut moving = at.map(Dual::constant);
        let momentum = if column < N { &mut moving.lambda } else { &mut moving.mu };
        momentum[column % N].eps = T::one();
        let moved = hamiltonian_legendre(hamiltonian, &moving)?;
        for (row, v) in moved.eta.iter().chain(&moved.psi).enumerate() {
            jacobian[(row, column)] = v.eps;
        }
    }
    Ok(jacobian)
}

/// (λ, U, μ) with Fh×(λ, U, μ) = (η, U, ψ), by Newton's method from the momenta of `guess`: near the units Fh× is a local
/// diffeomorphism (Martín de Diego and Sato Martín de Almagro 2019, Proposition 4.12).
///
/// # Errors
/// No convergence, a singular Jacobian, or one of another sign than at the guess; a point outside the domain.
pub fn hamiltonian_momenta<T: Real, const N: usize, const D: usize>(
    hamiltonian: &impl DoubledHamiltonian<T, N, D>,
    velocities: &VelocityPoint<T, N, D>,
    guess: Both<&Covector<T, N>>,
) -> Result<MomentumPoint<T, N, D>, VelocityError> {
    let origin: Vec<T> = guess.0.iter().chain(guess.1).copied().collect();
    let mut momenta = origin.clone();
    let unit = T::unit_roundoff();
    let settings = NewtonSettings { tolerance: unit * T::int(16), floor: unit * T::int(1 << 14), max_iterations: 40 };
    let point = |x: &[T]| MomentumPoint {
        time: velocities.time,
        lambda: Covector::from_fn(|_, a| x[a]),
        u: velocities.u,
        mu: Covector::from_fn(|_, a| x[N + a]),
    };
    let residual = |x: &[T], out: &mut [T]| {
        let found = hamiltonian_legendre(hamiltonian, &point(x))?;
        let wanted = velocities.eta.iter().chain(&velocities.psi);
        let mut size = T::zero();
        for (k, (found, wanted)) in found.eta.iter().chain(&found.psi).zip(wanted).enumerate() {
            out[k] = *found - *wanted;
            size = size.max(found.abs()).max(wanted.abs());
        }
        Ok(size)
    };
    let jacobian = |x: &[T]| hamiltonian_legendre_jacobian(hamiltonian, &point(x));
    let mut equations = Callbacks { dimension: 2 * N, residual: &residual, jacobian: &jacobian };
    match Newton::new(2 * N).solve(&mut equations, &origin, &mut momenta, &settings) {
        Ok(_) => Ok(point(&momenta)),
        Err(Failure::Equations(error)) => Err(error),
        Err(Failure::NotConverged(outcome)) => {
            let (residual, iterations) = (outcome.residual.to_f64(), outcome.iterations);
            Err(LegendreError::NotConverged { residual, iterations }.into())
        }
        Err(Failure::Fold { .. } | Failure::TooLong { .. } | Failure::Rounding { .. }) => {
            Err(singular(velocities).into())
        }
    }
}

type Residual<'a, T> = &'a dyn Fn(&[T], &mut [T]) -> Result<T, VelocityError>;
type Jacobian<'a, T> = &'a dyn Fn(&[T]) -> Result<DMatrix<T>, VelocityError>;

/// Equations without a parameter, from closures: so that Newton's method is compiled for the scalar alone.
struct Callbacks<'a, T> {
    dimension: usize,
    residual: Residual<'a, T>,
    jacobian: Jacobian<'a, T>,
}

impl<T: Real> Equations<T> for Callbacks<'_, T> {
    type Error = VelocityError;

    fn dimension(&self) -> usize {
        self.dimension
    }

    fn set_fraction(&mut self, _fraction: T) {}

    fn residual(&mut self, x: &[T], out: &mut [T]) -> Result<T, VelocityError> {
        (self.residual)(x, out)
    }

    fn jacobian(&mut self, x: &[T], out: &mut DMatrix<T>) -> Result<(), VelocityError> {
        out.copy_from(&(self.jacobian)(x)?);
        Ok(())
    }
}
