//! Casimir functions of degree one to three.

use super::elimination::regular_inverse;
use super::{AlgebraError, Covector, Matrix, Vector};
use crate::scalar::{Real, Scalar};

/// A function C on g* with dC(μ)(ad*_ξ μ) = 0 for all ξ and μ, homogeneous of degree one to three in μ.
///
/// Linear Casimirs are the elements of the centre of g, the others invariant symmetric tensors in g ⊗ g and g ⊗ g ⊗ g.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum Casimir<T: Real, const N: usize> {
    /// C(μ) = μ z.
    Linear(Vector<T, N>),
    /// C(μ) = μ Q μᵀ, Q symmetric.
    Quadratic(Matrix<T, N>),
    /// C(μ) = Σ_a μ_a μ Q_a μᵀ, with (Q_a)_bc symmetric in a, b and c.
    Cubic(Box<[Matrix<T, N>; N]>),
}

/// μ Q μᵀ.
fn form<T: Real, S: Scalar<Base = T>, const N: usize>(q: &Matrix<T, N>, mu: &Covector<S, N>) -> S {
    let mut sum = S::zero();
    for a in 0..N {
        for b in 0..N {
            sum += mu[a] * S::lift(q[(a, b)]) * mu[b];
        }
    }
    sum
}

impl<T: Real, const N: usize> Casimir<T, N> {
    /// Σ c μ_i μ_j …, over monomials of one degree from one to three, each the indices of its factors, with their coefficients.
    pub(super) fn of(terms: impl IntoIterator<Item = (Vec<usize>, T)>) -> Self {
        let (mut z, mut q, mut cubic) = (Vector::zeros(), Matrix::zeros(), [Matrix::zeros(); N]);
        let mut degree = 0;
        for (monomial, value) in terms {
            degree = monomial.len();
            match monomial[..] {
                [a] => z[a] = value,
                [a, b] => {
                    q[(a, b)] += value * T::half();
                    q[(b, a)] += value * T::half();
                }
                [a, b, c] => {
                    let sixth = value / T::int(6);
                    for [i, j, k] in [[a, b, c], [a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]] {
                        cubic[i][(j, k)] += sixth;
                    }
                }
                _ => {}
            }
        }
        match degree {
            1 => Self::Linear(z),
            2 => Self::Quadratic(q),
            _ => Self::Cubic(Box::new(cubic)),
        }
    }

    /// C(μ).
    pub fn value<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> S {
        let mut sum = S::zero();
        match self {
            Self::Linear(z) => {
                for a in 0..N {
                    sum += mu[a] * S::lift(z[a]);
                }
            }
            Self::Quadratic(q) => sum = form(q, mu),
            Self::Cubic(q) => {
                for a in 0..N {
                    sum += mu[a] * form(&q[a], mu);
                }
            }
        }
        sum
    }

    /// dC(μ), a vector of g: z, 2 Q μᵀ, or 3 μ Q_a μᵀ.
    pub fn gradient<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> Vector<S, N> {
        match self {
            Self::Linear(z) => z.map(S::lift),
            Self::Quadratic(q) => q.map(|v| S::lift(v + v)) * mu.transpose(),
            Self::Cubic(q) => Vector::from_fn(|a, _| form(&q[a], mu) * S::int(3)),
        }
    }

    /// The sizes of the terms of dC(μ): its sums with absolute values, which do not cancel.
    #[cfg(feature = "harness")]
    pub(crate) fn gradient_terms(&self, mu: &Covector<T, N>) -> Vector<T, N> {
        match self {
            Self::Linear(z) => z.abs(),
            Self::Quadratic(q) => Self::Quadratic(q.abs()).gradient(&mu.abs()),
            Self::Cubic(q) => {
                let absolute = std::array::from_fn(|a| q[a].abs());
                Self::Cubic(Box::new(absolute)).gradient(&mu.abs())
            }
        }
    }

    /// C''(μ)(ν, ν).
    pub fn second<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>, nu: &Covector<S, N>) -> S {
        match self {
            Self::Linear(_) => S::zero(),
            Self::Quadratic(q) => form(q, nu) * S::int(2),
            Self::Cubic(q) => (0..N).fold(S::zero(), |sum, a| sum + mu[a] * form(&q[a], nu)) * S::int(6),
        }
    }

    /// The same function in the basis e'_a = e_b B^b_a, where μ' = μ B: z' = B⁻¹ z, Q' = B⁻¹ Q B⁻ᵀ, and likewise with three
    /// indices.
    ///
    /// # Errors
    /// A singular or non-finite B.
    pub fn in_basis(&self, basis: &Matrix<T, N>) -> Result<Self, AlgebraError> {
        let inverse = regular_inverse(basis)?;
        let moved = |q: &Matrix<T, N>| {
            let moved = inverse * q * inverse.transpose();
            (moved + moved.transpose()) * T::half()
        };
        Ok(match self {
            Self::Linear(z) => Self::Linear(inverse * z),
            Self::Quadratic(q) => Self::Quadratic(moved(q)),
            Self::Cubic(q) => Self::Cubic(Box::new(std::array::from_fn(|a| {
                (0..N).fold(Matrix::zeros(), |sum, b| sum + moved(&q[b]) * inverse[(a, b)])
            }))),
        })
    }

    /// The largest coefficient times |μ| to the degree: the size of the terms of C(μ).
    #[cfg(feature = "harness")]
    pub(crate) fn size(&self, mu: T) -> T {
        match self {
            Self::Linear(z) => z.amax() * mu,
            Self::Quadratic(q) => q.amax() * mu * mu,
            Self::Cubic(q) => q.iter().fold(T::zero(), |most, q| most.max(q.amax())) * mu * mu * mu,
        }
    }
}
