//! Casimir functions of degree one and two.

use super::elimination::regular_inverse;
use super::{AlgebraError, Covector, Matrix, Vector};
use crate::scalar::{Real, Scalar};

/// A function C on g* with dC(μ)(ad*_ξ μ) = 0 for all ξ and μ, linear or quadratic in μ.
///
/// Linear Casimirs are the elements of the centre of g, quadratic ones the invariant symmetric tensors in g ⊗ g.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Casimir<T: Real, const N: usize> {
    /// C(μ) = μ z.
    Linear(Vector<T, N>),
    /// C(μ) = μ Q μᵀ, Q symmetric.
    Quadratic(Matrix<T, N>),
}

impl<T: Real, const N: usize> Casimir<T, N> {
    /// C(μ).
    pub fn value<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> S {
        let mut sum = S::zero();
        match self {
            Self::Linear(z) => {
                for a in 0..N {
                    sum += mu[a] * S::lift(z[a]);
                }
            }
            Self::Quadratic(q) => {
                for a in 0..N {
                    for b in 0..N {
                        sum += mu[a] * S::lift(q[(a, b)]) * mu[b];
                    }
                }
            }
        }
        sum
    }

    /// dC(μ), a vector of g: z, or 2 Q μᵀ.
    pub fn gradient<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> Vector<S, N> {
        match self {
            Self::Linear(z) => z.map(S::lift),
            Self::Quadratic(q) => q.map(|v| S::lift(v + v)) * mu.transpose(),
        }
    }

    /// The same function in the basis e'_a = e_b B^b_a, where μ' = μ B: z' = B⁻¹ z, Q' = B⁻¹ Q B⁻ᵀ.
    ///
    /// # Errors
    /// A singular or non-finite B.
    pub fn in_basis(&self, basis: &Matrix<T, N>) -> Result<Self, AlgebraError> {
        let inverse = regular_inverse(basis)?;
        Ok(match self {
            Self::Linear(z) => Self::Linear(inverse * z),
            Self::Quadratic(q) => {
                let moved = inverse * q * inverse.transpose();
                Self::Quadratic((moved + moved.transpose()) * T::half())
            }
        })
    }
}
