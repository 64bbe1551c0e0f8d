//! The brackets of the Poisson groupoid Γ = g*×G×g* and of its base g*, as matrices.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/groupoid/poisson.md"))]

use super::{Arrow, DenseGroup};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// The Poisson bivector Π of Γ = g*×G×g* at (λ, U, μ), or `None` when U is singular: {A, B} = Σ_ij dA_i Π_ij dB_j, with
///
/// {A, B} = ⟨λ, [A_λ, B_λ]⟩ − ⟨μ, [A_μ, B_μ]⟩ + ⟨L*_U A_U, B_μ + Ad_{U⁻¹} B_λ⟩ − ⟨L*_U B_U, A_μ + Ad_{U⁻¹} A_λ⟩.
///
/// Rows and columns are those of the left-trivialised differential dA = (A_λ, L*_U A_U, A_μ): A(λ + δλ, U(1 + δû), μ + δμ) =
/// A + ⟨δλ, A_λ⟩ + ⟨L*_U A_U, δu⟩ + ⟨δμ, A_μ⟩ + …. Here α is Poisson and β anti-Poisson onto g* with +⟨μ, [·, ·]⟩, the opposite
/// of [`lie_poisson_bivector`]. Source: Martín de Diego and Sato Martín de Almagro 2019, (4.5).
///
/// ```
/// use euler_poincare::group::So3;
/// use euler_poincare::groupoid::{Arrow, DenseGroup, lie_poisson_bivector, poisson_bivector};
/// use nalgebra::{DMatrix, DVector};
///
/// let so3 = DenseGroup::of(&So3::<f64>::new());
/// let (lambda, mu) = (DVector::from_vec(vec![1.0, 2.0, 3.0]), DVector::from_vec(vec![4.0, 5.0, 6.0]));
/// let on_mu: DMatrix<f64> = lie_poisson_bivector(&so3, &mu);
/// let at = Arrow { source: lambda, group: DMatrix::identity(3, 3), target: mu };
/// let pi = poisson_bivector(&so3, &at).expect("U is regular");
/// assert_eq!(pi[(0, 1)], 3.0);
/// assert_eq!(pi.view((6, 6), (3, 3)), on_mu);
/// ```
pub fn poisson_bivector<S: Scalar>(
    group: &DenseGroup<S::Base>,
    at: &Arrow<DVector<S>, DMatrix<S>>,
) -> Option<DMatrix<S>> {
    let n = group.dimension();
    let adjoint = group.adjoint(&group.inverse(&at.group)?)?;
    let one = DMatrix::identity(n, n);
    let blocks = [
        (0, 0, -lie_poisson_bivector(group, &at.source)),
        (0, 1, -adjoint.transpose()),
        (1, 0, adjoint),
        (1, 2, one.clone()),
        (2, 1, -one),
        (2, 2, lie_poisson_bivector(group, &at.target)),
    ];
    let mut bivector = DMatrix::zeros(3 * n, 3 * n);
    for (row, column, block) in blocks {
        bivector.view_mut((row * n, column * n), (n, n)).copy_from(&block);
    }
    Some(bivector)
}

/// The Lie–Poisson bivector of g* at μ: Π_ab = {μ_a, μ_b} = −C^d_ab μ_d, so that {F, K}(μ) = −⟨μ, [F', K']⟩.
pub fn lie_poisson_bivector<S: Scalar>(group: &DenseGroup<S::Base>, mu: &DVector<S>) -> DMatrix<S> {
    let n = group.dimension();
    DMatrix::from_fn(n, n, |a, b| (0..n).fold(S::zero(), |sum, d| sum - S::lift(group.constant(a, b, d)) * mu[d]))
}
