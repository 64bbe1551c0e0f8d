//! The conditions for extremal stages, put together from the derivatives of **l** at each stage.
//!
//! Whatever the group: everything here is in components, with n = N unknowns a block.

use super::chord::Residual;
use crate::scalar::Real;
use crate::tableau::Tableau;
use nalgebra::{DMatrix, DVector};

/// The residual of the conditions from the local gradients (a row for each stage), and the size of their terms.
pub(super) fn residual<T: Real>(
    tableau: &Tableau<T>,
    h: T,
    gradient: &DMatrix<T>,
    x: &DVector<T>,
    mean: &[T],
    weight: T,
) -> Residual<T> {
    let (s, n) = (tableau.stages(), mean.len() / 2);
    let (a, b) = (tableau.a(), tableau.b());
    let mut residual = DVector::zeros(x.len());
    let mut size = T::zero();
    for copy in 0..2 {
        for component in 0..n {
            let (place, rate) = ((2 * copy) * n + component, (2 * copy + 1) * n + component);
            let multiplier = x[(2 * s + copy) * n + component];
            for k in 0..s {
                let mut sum = gradient[(k, rate)] - multiplier;
                size = size.max(gradient[(k, rate)].abs()).max(multiplier.abs());
                for i in 0..s {
                    let term = gradient[(i, place)] * (h * b[i] * a[(i, k)] / b[k]);
                    size = size.max(term.abs());
                    sum += term;
                }
                residual[(copy * s + k) * n + component] = sum;
            }
            let mut constraint = -mean[copy * n + component];
            size = size.max((constraint * weight).abs());
            for k in 0..s {
                let term = x[(copy * s + k) * n + component] * b[k];
                size = size.max((term * weight).abs());
                constraint += term;
            }
            residual[(2 * s + copy) * n + component] = constraint * weight;
        }
    }
    (residual, size)
}

/// The Jacobian of the conditions from the Hessians of the stages by (Ξ, H, X, Ψ).
pub(super) fn jacobian<T: Real>(tableau: &Tableau<T>, h: T, hessians: &[DMatrix<T>], weight: T) -> DMatrix<T> {
    let (s, n) = (tableau.stages(), hessians[0].nrows() / 4);
    let (a, b) = (tableau.a(), tableau.b());
    let mut jacobian = DMatrix::zeros(2 * (s + 1) * n, 2 * (s + 1) * n);
    // (slot, factor) of what stage i contributes to, or takes from, the unknown of stage k: H_k is H_i and moves Ξ_i.
    let slots = |copy: usize, same: bool, factor: T| {
        [(2 * copy, factor), (2 * copy + 1, if same { T::one() } else { T::zero() })]
    };
    for (i, hessian) in hessians.iter().enumerate() {
        for (p, q) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            for k in 0..s {
                for m in 0..s {
                    for (row, outer) in slots(p, i == k, h * b[i] * a[(i, k)] / b[k]) {
                        for (column, inner) in slots(q, i == m, h * a[(i, m)]) {
                            let factor = outer * inner;
                            if factor == T::zero() {
                                continue;
                            }
                            let mut target = jacobian.view_mut(((p * s + k) * n, (q * s + m) * n), (n, n));
                            target += hessian.view((row * n, column * n), (n, n)) * factor;
                        }
                    }
                }
            }
        }
    }
    for copy in 0..2 {
        for k in 0..s {
            for component in 0..n {
                let (unknown, multiplier) = ((copy * s + k) * n + component, (2 * s + copy) * n + component);
                jacobian[(unknown, multiplier)] = -T::one();
                jacobian[(multiplier, unknown)] = b[k] * weight;
            }
        }
    }
    jacobian
}
