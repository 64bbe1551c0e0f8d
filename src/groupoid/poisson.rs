//! The brackets of the Poisson groupoid Γ = g*×G×g* and of its base g*, as matrices.

use super::Arrow;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, pair};
use crate::group::LieGroup;
use crate::scalar::{Real, Scalar};
use nalgebra::DMatrix;

/// The differential of a function A on Γ in left-trivialised coordinates: A(λ + δλ, U(1 + δû), μ + δμ) =
/// A + ⟨δλ, A_λ⟩ + ⟨L*_U A_U, δu⟩ + ⟨δμ, A_μ⟩ + ….
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Differential<S: Scalar, const N: usize> {
    /// A_λ, in g.
    pub lambda: Vector<S, N>,
    /// L*_U A_U, in g*.
    pub group: Covector<S, N>,
    /// A_μ, in g.
    pub mu: Vector<S, N>,
}

/// A bivector Π on Γ at a point, in the coordinates (λ, u, μ) of [`Differential`]: {A, B} = Σ_ij dA_i Π_ij dB_j.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bivector<S: Scalar, const N: usize> {
    /// The N×N blocks, rows and columns in the order λ, u, μ.
    pub blocks: [[Matrix<S, N>; 3]; 3],
}

impl<S: Scalar, const N: usize> Bivector<S, N> {
    /// {A, B} = dA Π dBᵀ.
    pub fn bracket(&self, a: &Differential<S, N>, b: &Differential<S, N>) -> S {
        let (a, b) = ([a.lambda, a.group.transpose(), a.mu], [b.lambda, b.group.transpose(), b.mu]);
        let mut sum = S::zero();
        for i in 0..3 {
            for j in 0..3 {
                sum += pair(&a[i].transpose(), &(self.blocks[i][j] * b[j]));
            }
        }
        sum
    }

    /// The 3N×3N matrix.
    pub fn dense(&self) -> DMatrix<S> {
        DMatrix::from_fn(3 * N, 3 * N, |i, j| self.blocks[i / N][j / N][(i % N, j % N)])
    }
}

/// The Poisson bivector of Γ = g*×G×g* at (λ, U, μ), or `None` when U is singular:
///
/// {A, B} = ⟨λ, [A_λ, B_λ]⟩ − ⟨μ, [A_μ, B_μ]⟩ + ⟨L*_U A_U, B_μ + Ad_{U⁻¹} B_λ⟩ − ⟨L*_U B_U, A_μ + Ad_{U⁻¹} A_λ⟩.
///
/// Here α is Poisson and β anti-Poisson onto g* with +⟨μ, [·, ·]⟩, the opposite of [`lie_poisson_bivector`].
/// Source: Martín de Diego and Sato Martín de Almagro 2019, (4.5).
pub fn poisson_bivector<S, G, const N: usize, const D: usize>(
    group: &G,
    point: &Arrow<Covector<S, N>, Matrix<S, D>>,
) -> Option<Bivector<S, N>>
where
    S: Scalar,
    G: LieGroup<S::Base, N, D>,
{
    let adjoint = group.adjoint(&group.inverse(&point.group)?)?;
    let (zero, one) = (Matrix::zeros(), Matrix::identity());
    let on_lambda = -lie_poisson_bivector(group.algebra(), &point.source);
    let on_mu = lie_poisson_bivector(group.algebra(), &point.target);
    let blocks = [[on_lambda, -adjoint.transpose(), zero], [adjoint, zero, one], [zero, -one, on_mu]];
    Some(Bivector { blocks })
}

/// The Lie–Poisson bivector of g* at μ: Π_ab = {μ_a, μ_b} = −C^d_ab μ_d, so that {F, K}(μ) = −⟨μ, [F', K']⟩.
pub fn lie_poisson_bivector<T: Real, S: Scalar<Base = T>, const N: usize>(
    algebra: &LieAlgebra<T, N>,
    mu: &Covector<S, N>,
) -> Matrix<S, N> {
    let mut bivector = Matrix::zeros();
    for a in 0..N {
        for b in 0..N {
            for d in 0..N {
                bivector[(a, b)] -= S::lift(algebra.constant(a, b, d)) * mu[d];
            }
        }
    }
    bivector
}
