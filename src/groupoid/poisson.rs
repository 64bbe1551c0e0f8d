//! The brackets of the Poisson groupoid Γ = g*×G×g* and of its base g*, as matrices.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/groupoid/poisson.md"))]

use super::Arrow;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, pair};
use crate::group::LieGroup;
use crate::scalar::{Dual, Real, Scalar};
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

/// A point (λ, U, μ) of Γ.
pub type Phase<S, const N: usize, const D: usize> = Arrow<Covector<S, N>, Matrix<S, D>>;

/// A function on Γ; where U is concerned, it need not be defined off the group.
pub trait PhaseFunction<T: Real, const N: usize, const D: usize> {
    /// A(λ, U, μ).
    fn value<S: Scalar<Base = T>>(&self, point: &Phase<S, N, D>) -> S;
}

/// dA at (λ, U, μ), by duals: U is moved to U(1 + ε ê_a).
pub fn differential<T, S, G, const N: usize, const D: usize>(
    group: &G,
    function: &impl PhaseFunction<T, N, D>,
    point: &Phase<S, N, D>,
) -> Differential<S, N>
where
    T: Real,
    S: Scalar<Base = T>,
    G: LieGroup<T, N, D>,
{
    let zero = Vector::<S, N>::zeros();
    let mut d = Differential { lambda: zero, group: zero.transpose(), mu: zero };
    let still = || Arrow {
        source: point.source.map(Dual::constant),
        group: point.group.map(Dual::constant),
        target: point.target.map(Dual::constant),
    };
    for a in 0..N {
        let e = crate::algebra::basis_vector::<S, N>(a);
        let row = e.transpose();
        let moved = |x: &Covector<S, N>| x.zip_map(&row, |re, eps| Dual { re, eps });
        d.lambda[a] = function.value(&Arrow { source: moved(&point.source), ..still() }).eps;
        d.mu[a] = function.value(&Arrow { target: moved(&point.target), ..still() }).eps;
        let turned = point.group.zip_map(&(point.group * group.hat(&e)), |re, eps| Dual { re, eps });
        d.group[a] = function.value(&Arrow { group: turned, ..still() }).eps;
    }
    d
}

/// {A, B} at (λ, U, μ), with the differentials by duals; `None` when U is singular.
pub fn bracket<T, S, G, const N: usize, const D: usize>(
    group: &G,
    a: &impl PhaseFunction<T, N, D>,
    b: &impl PhaseFunction<T, N, D>,
    point: &Phase<S, N, D>,
) -> Option<S>
where
    T: Real,
    S: Scalar<Base = T>,
    G: LieGroup<T, N, D>,
{
    Some(poisson_bivector(group, point)?.bracket(&differential(group, a, point), &differential(group, b, point)))
}

/// The brackets of the generators λ_a, U_ij, μ_a, the entries of U column by column, from their definition:
///
/// {Ξ₁, Ξ'₁} = ⟨λ, \[ξ, ξ'\]⟩, {Ξ₂, Ξ'₂} = −⟨μ, \[ξ, ξ'\]⟩, {Ξ₁, F} = −ξ→F, {Ξ₂, F} = −ξ←F, all others zero,
///
/// with ξ→ = ξ̂U and ξ← = Uξ̂, and the bracket of the algebra the commutator of matrices. No inverse of U is taken.
///
/// Source: Martín de Diego and Sato Martín de Almagro 2019, (4.5).
pub fn generator_brackets<S, G, const N: usize, const D: usize>(group: &G, point: &Phase<S, N, D>) -> DMatrix<S>
where
    S: Scalar,
    G: LieGroup<S::Base, N, D>,
{
    let middle = D * D;
    let mut brackets = DMatrix::zeros(2 * N + middle, 2 * N + middle);
    let hats: Vec<Matrix<S, D>> = (0..N).map(|a| group.hat(&crate::algebra::basis_vector(a))).collect();
    for a in 0..N {
        for b in 0..N {
            let commutator = group.vee(&(hats[a] * hats[b] - hats[b] * hats[a]));
            brackets[(a, b)] = pair(&point.source, &commutator);
            brackets[(N + middle + a, N + middle + b)] = -pair(&point.target, &commutator);
        }
        let (right, left) = (hats[a] * point.group, point.group * hats[a]);
        for k in 0..middle {
            for (row, field) in [(a, &right), (N + middle + a, &left)] {
                brackets[(row, N + k)] = -field[k];
                brackets[(N + k, row)] = field[k];
            }
        }
    }
    brackets
}
