//! Hamiltonians on Γ = g*×G×g*, their equations of motion, and the modified Legendre transforms that lead there and back.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/mechanics/hamiltonian.md"))]

use super::LegendreError;
use super::doubled::{DoubledLagrangian, VelocityError};
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
    fn value<S: Scalar<Base = T>>(
        &self,
        t: S,
        lambda: &Covector<S, N>,
        u: &Matrix<S, D>,
        mu: &Covector<S, N>,
    ) -> Result<S, VelocityError>;

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
        t: S,
        lambda: &Covector<S, N>,
        u: &Matrix<S, D>,
        mu: &Covector<S, N>,
    ) -> Result<MomentumPartials<S, N>, VelocityError> {
        momentum_partials_by_duals(self, t, lambda, u, mu)
    }
}

/// The partial derivatives by dual numbers: U is moved to U(1 + ε ê_a) and to (1 + ε ê_a)U, which are exact as ε² = 0.
///
/// # Errors
/// Those of the value and of `hat`.
pub fn momentum_partials_by_duals<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    hamiltonian: &(impl DoubledHamiltonian<T, N, D> + ?Sized),
    t: S,
    lambda: &Covector<S, N>,
    u: &Matrix<S, D>,
    mu: &Covector<S, N>,
) -> Result<MomentumPartials<S, N>, VelocityError> {
    let (time, lambda0, mu0) = (Dual::constant(t), lambda.map(Dual::constant), mu.map(Dual::constant));
    let u0 = u.map(Dual::constant);
    let (vector, covector) = (Vector::<S, N>::zeros(), Covector::<S, N>::zeros());
    let mut partials = MomentumPartials { lambda: vector, left: covector, right: covector, mu: vector };
    for a in 0..N {
        let e = basis_vector::<S, N>(a);
        let hat = hamiltonian.hat(&e)?;
        let along = |direction: Matrix<S, D>| u.zip_map(&direction, |re, eps| Dual { re, eps });
        let moved = |p: &Covector<S, N>| p.zip_map(&e.transpose(), |re, eps| Dual { re, eps });
        partials.lambda[a] = hamiltonian.value(time, &moved(lambda), &u0, &mu0)?.eps;
        partials.left[a] = hamiltonian.value(time, &lambda0, &along(u * hat), &mu0)?.eps;
        partials.right[a] = hamiltonian.value(time, &lambda0, &along(hat * u), &mu0)?.eps;
        partials.mu[a] = hamiltonian.value(time, &lambda0, &u0, &moved(mu))?.eps;
    }
    Ok(partials)
}

/// The time derivatives of (λ, U, μ) along a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct HamiltonRates<S: Scalar, const N: usize, const D: usize> {
    /// λ̇.
    pub lambda: Covector<S, N>,
    /// U̇.
    pub u: Matrix<S, D>,
    /// μ̇.
    pub mu: Covector<S, N>,
}

/// λ̇ = −ad*_{∂h/∂λ} λ − R*_U ∂h/∂U, μ̇ = ad*_{∂h/∂μ} μ − L*_U ∂h/∂U, U̇ = U ∂h/∂μ + ∂h/∂λ U (as matrices): the
/// Hamiltonian vector field of the bracket of Γ (Martín de Diego and Sato Martín de Almagro 2019, §4.3).
///
/// # Errors
/// A point outside the domain of the Hamiltonian; no group.
pub fn hamilton_rates<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    hamiltonian: &impl DoubledHamiltonian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    t: S,
    lambda: &Covector<S, N>,
    u: &Matrix<S, D>,
    mu: &Covector<S, N>,
) -> Result<HamiltonRates<S, N, D>, VelocityError> {
    let partials = hamiltonian.partials(t, lambda, u, mu)?;
    Ok(HamiltonRates {
        lambda: -algebra.coad(&partials.lambda, lambda) - partials.right,
        u: u * hamiltonian.hat(&partials.mu)? + hamiltonian.hat(&partials.lambda)? * u,
        mu: algebra.coad(&partials.mu, mu) - partials.left,
    })
}

/// The modified Legendre transform of **l**: λ = −∂l/∂η, μ = ∂l/∂ψ, U unchanged. Its inverse is
/// [`DoubledLagrangian::velocities`].
///
/// # Errors
/// U outside the domain of the Lagrangian.
pub fn modified_legendre<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    t: S,
    eta: &Vector<S, N>,
    u: &Matrix<S, D>,
    psi: &Vector<S, N>,
) -> Result<(Covector<S, N>, Covector<S, N>), RetractionError> {
    let partials = doubled.partials(t, eta, u, psi)?;
    Ok((-partials.eta, partials.psi))
}

/// ⟨(λ, U, μ), (η, U, ψ)⟩_× = ⟨μ, ψ⟩ − ⟨λ, η⟩, the pairing in which the modified Legendre transform is the fibre
/// derivative (Martín de Diego and Sato Martín de Almagro 2019, §4.3).
pub fn modified_pairing<S: Scalar, const N: usize>(
    (lambda, mu): (&Covector<S, N>, &Covector<S, N>),
    (eta, psi): (&Vector<S, N>, &Vector<S, N>),
) -> S {
    pair(mu, psi) - pair(lambda, eta)
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

    /// (η, ψ) with λ = −∂l/∂η and μ = ∂l/∂ψ, derivative parts included.
    ///
    /// The value by [`DoubledLagrangian::velocities`]; then, for k nested duals, k corrections with the inverse second
    /// derivatives at that value: each makes the error one order smaller in the derivative parts.
    ///
    /// # Errors
    /// Those of the inverse Legendre transform.
    pub fn velocities<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        t: S,
        lambda: &Covector<S, N>,
        u: &Matrix<S, D>,
        mu: &Covector<S, N>,
    ) -> Result<(Vector<S, N>, Vector<S, N>), VelocityError>
    where
        L: DoubledLagrangian<T, N, D>,
    {
        let (base_t, base_u) = (t.base(), u.map(|v| v.base()));
        let base = |p: &Covector<S, N>| p.map(|v| v.base());
        let (eta0, psi0) = self.doubled.velocities(base_t, &base(lambda), &base_u, &base(mu))?;
        let (mut eta, mut psi) = (eta0.map(S::lift), psi0.map(S::lift));
        let order = (size_of::<S>() / size_of::<T>()).ilog2();
        if order == 0 {
            return Ok((eta, psi));
        }
        let inverse = super::doubled::inverse_velocity_hessian(&self.doubled, base_t, &eta0, &base_u, &psi0)?;
        for _ in 0..order {
            let (first, second) = modified_legendre(&self.doubled, t, &eta, u, &psi)?;
            let (r, s) = ((first - lambda).transpose(), (second - mu).transpose());
            let [[a, b], [c, d]] = inverse.each_ref().map(|row| row.each_ref().map(|block| block.map(S::lift)));
            eta -= a * r + b * s;
            psi -= c * r + d * s;
        }
        Ok((eta, psi))
    }
}

impl<T: Real, L: DoubledLagrangian<T, N, D>, const N: usize, const D: usize> DoubledHamiltonian<T, N, D>
    for LegendreHamiltonian<L>
{
    fn value<S: Scalar<Base = T>>(
        &self,
        t: S,
        lambda: &Covector<S, N>,
        u: &Matrix<S, D>,
        mu: &Covector<S, N>,
    ) -> Result<S, VelocityError> {
        let (eta, psi) = self.velocities(t, lambda, u, mu)?;
        Ok(modified_pairing((lambda, mu), (&eta, &psi)) - self.doubled.value(t, &eta, u, &psi)?)
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        self.doubled.hat(xi)
    }

    /// ∂h̃/∂λ = −η, ∂h̃/∂U = −∂l/∂U, ∂h̃/∂μ = ψ at the velocities: the terms in which these vary cancel.
    fn partials<S: Scalar<Base = T>>(
        &self,
        t: S,
        lambda: &Covector<S, N>,
        u: &Matrix<S, D>,
        mu: &Covector<S, N>,
    ) -> Result<MomentumPartials<S, N>, VelocityError> {
        let (eta, psi) = self.velocities(t, lambda, u, mu)?;
        let partials = self.doubled.partials(t, &eta, u, &psi)?;
        Ok(MomentumPartials { lambda: -eta, left: -partials.left, right: -partials.right, mu: psi })
    }
}

/// Fh×(λ, U, μ) = (−∂h/∂λ, U, ∂h/∂μ): the velocities (η, ψ) of a Hamiltonian.
///
/// # Errors
/// A point outside the domain of the Hamiltonian.
pub fn hamiltonian_legendre<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    hamiltonian: &impl DoubledHamiltonian<T, N, D>,
    t: S,
    lambda: &Covector<S, N>,
    u: &Matrix<S, D>,
    mu: &Covector<S, N>,
) -> Result<(Vector<S, N>, Vector<S, N>), VelocityError> {
    let partials = hamiltonian.partials(t, lambda, u, mu)?;
    Ok((-partials.lambda, partials.mu))
}

/// The Jacobian of Fh× at fixed U, 2N×2N: rows (−∂h/∂λ, ∂h/∂μ), columns (λ, μ). For **h** = h_f it is
/// diag(h'', h'') on the units (Martín de Diego and Sato Martín de Almagro 2019, Proposition 4.12).
///
/// # Errors
/// A point outside the domain of the Hamiltonian.
pub fn hamiltonian_legendre_jacobian<T: Real, const N: usize, const D: usize>(
    hamiltonian: &impl DoubledHamiltonian<T, N, D>,
    t: T,
    lambda: &Covector<T, N>,
    u: &Matrix<T, D>,
    mu: &Covector<T, N>,
) -> Result<DMatrix<T>, VelocityError> {
    let (time, u) = (Dual::constant(t), u.map(Dual::constant));
    let mut jacobian = DMatrix::zeros(2 * N, 2 * N);
    for column in 0..2 * N {
        let (mut first, mut second) = (lambda.map(Dual::constant), mu.map(Dual::constant));
        if column < N {
            first[column].eps = T::one();
        } else {
            second[column - N].eps = T::one();
        }
        let (eta, psi) = hamiltonian_legendre(hamiltonian, time, &first, &u, &second)?;
        for (row, v) in eta.iter().chain(&psi).enumerate() {
            jacobian[(row, column)] = v.eps;
        }
    }
    Ok(jacobian)
}

/// (λ, μ) with Fh×(λ, U, μ) = (η, U, ψ), by Newton's method from `guess`: near the units Fh× is a local
/// diffeomorphism (Martín de Diego and Sato Martín de Almagro 2019, Proposition 4.12).
///
/// # Errors
/// No convergence, a singular Jacobian, or one of another sign than at the guess; a point outside the domain.
pub fn hamiltonian_momenta<T: Real, const N: usize, const D: usize>(
    hamiltonian: &impl DoubledHamiltonian<T, N, D>,
    t: T,
    eta: &Vector<T, N>,
    u: &Matrix<T, D>,
    psi: &Vector<T, N>,
    guess: (&Covector<T, N>, &Covector<T, N>),
) -> Result<(Covector<T, N>, Covector<T, N>), VelocityError> {
    let origin: Vec<T> = guess.0.iter().chain(guess.1).copied().collect();
    let mut momenta = origin.clone();
    let unit = T::unit_roundoff();
    let settings = NewtonSettings { tolerance: unit * T::int(16), floor: unit * T::int(1 << 14), max_iterations: 40 };
    let residual = |x: &[T], out: &mut [T]| {
        let (found, other) = hamiltonian_legendre(hamiltonian, t, &first(x), u, &second(x))?;
        let wanted = eta.iter().chain(psi);
        let mut size = T::zero();
        for (k, (found, wanted)) in found.iter().chain(&other).zip(wanted).enumerate() {
            out[k] = *found - *wanted;
            size = size.max(found.abs()).max(wanted.abs());
        }
        Ok(size)
    };
    let jacobian = |x: &[T]| hamiltonian_legendre_jacobian(hamiltonian, t, &first(x), u, &second(x));
    let mut equations = Callbacks { dimension: 2 * N, residual: &residual, jacobian: &jacobian };
    match Newton::new(2 * N).solve(&mut equations, &origin, &mut momenta, &settings) {
        Ok(_) => Ok((first(&momenta), second(&momenta))),
        Err(Failure::Equations(error)) => Err(error),
        Err(Failure::NotConverged(outcome)) => {
            let (residual, iterations) = (outcome.residual.to_f64(), outcome.iterations);
            Err(LegendreError::NotConverged { residual, iterations }.into())
        }
        Err(Failure::Fold { .. } | Failure::TooLong { .. }) => {
            let velocity = eta.iter().chain(psi).map(|v| v.to_f64()).collect();
            Err(LegendreError::Singular { velocity, rank: None }.into())
        }
    }
}

fn first<T: Real, const N: usize>(x: &[T]) -> Covector<T, N> {
    Covector::from_fn(|_, a| x[a])
}

fn second<T: Real, const N: usize>(x: &[T]) -> Covector<T, N> {
    Covector::from_fn(|_, a| x[N + a])
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
