//! Small dense inverses and norms in any scalar, without allocation.

use crate::algebra::Matrix;
use crate::scalar::Scalar;

/// The inverse by Gauss–Jordan elimination with partial pivoting, or `None` if the matrix is singular to working
/// precision: 64 N u κ ≥ 1, with κ the condition number that row and column scaling cannot reduce (Bauer 1963).
pub(super) fn invert<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> Option<Matrix<S, N>> {
    let mut left = *matrix;
    let mut right = Matrix::<S, N>::identity();
    for k in 0..N {
        let mut pivot = k;
        for i in k + 1..N {
            if left[(i, k)].abs() > left[(pivot, k)].abs() {
                pivot = i;
            }
        }
        left.swap_rows(k, pivot);
        right.swap_rows(k, pivot);
        let scale = S::one() / left[(k, k)];
        if !scale.all_finite() {
            return None;
        }
        for j in 0..N {
            left[(k, j)] *= scale;
            right[(k, j)] *= scale;
        }
        for i in 0..N {
            let factor = left[(i, k)];
            if i == k {
                continue;
            }
            for j in 0..N {
                let (l, r) = (left[(k, j)], right[(k, j)]);
                left[(i, j)] -= factor * l;
                right[(i, j)] -= factor * r;
            }
        }
    }
    let limit = 1.0 / (64.0 * N as f64 * S::unit_roundoff().to_f64());
    (norm(matrix) * norm(&right) < limit || bauer(matrix, &right) < limit).then_some(right)
}

/// The largest absolute column sum; NaN if any entry is.
pub(super) fn norm<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> f64 {
    let mut largest = 0.0f64;
    for j in 0..N {
        let mut sum = 0.0;
        for i in 0..N {
            sum += matrix[(i, j)].to_f64().abs();
        }
        if sum > largest || sum.is_nan() {
            largest = sum;
        }
    }
    largest
}

/// An upper estimate of the spectral radius of |A⁻¹||A|: the smallest condition number over diagonal scalings.
fn bauer<S: Scalar, const N: usize>(matrix: &Matrix<S, N>, inverse: &Matrix<S, N>) -> f64 {
    let mut power = inverse.map(|v| v.to_f64().abs()) * matrix.map(|v| v.to_f64().abs());
    for _ in 0..3 {
        power = power * power;
    }
    let estimate = norm(&power).powf(0.125);
    if estimate.is_finite() { estimate } else { f64::INFINITY }
}

/// The norm after the best diagonal similarity by powers of two (Osborne 1960; Parlett and Reinsch 1969).
///
/// Series and doublings commute exactly with such a similarity, so this is the norm that decides how far to scale
/// down: a large translation beside a small rotation must not cost digits.
pub(super) fn balanced_norm<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> f64 {
    let mut work = matrix.map(|v| v.to_f64().abs());
    for _ in 0..64 {
        let mut changed = false;
        for i in 0..N {
            let (mut row, mut column) = (0.0, 0.0);
            for j in 0..N {
                if j != i {
                    row += work[(i, j)];
                    column += work[(j, i)];
                }
            }
            let scale = if row > 2.0 * column {
                0.5
            } else if column > 2.0 * row {
                2.0
            } else {
                continue;
            };
            // Without a partner (row or column zero) the entries can be made as small as is useful.
            if row + column < 1e-3 * work[(i, i)].max(1.0) {
                continue;
            }
            let gain = row + column - scale * row - column / scale;
            if gain <= 0.05 * (row + column) {
                continue;
            }
            changed = true;
            for j in 0..N {
                if j != i {
                    work[(i, j)] *= scale;
                    work[(j, i)] /= scale;
                }
            }
        }
        if !changed {
            break;
        }
    }
    norm(&work)
}
