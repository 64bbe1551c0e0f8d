//! Gaussian elimination on small square matrices, over any scalar and without allocation.
//!
//! Not nalgebra's `try_inverse`: up to 4×4 that divides cofactors by the determinant, which loses the square of the
//! condition number, and it calls a matrix singular only when the determinant vanishes exactly.

use super::{AlgebraError, Matrix};
use crate::scalar::loops::{self, heavy};
use crate::scalar::{Real, Scalar, finite};
use nalgebra::DMatrix;

/// A⁻¹ by Gauss–Jordan elimination with complete pivoting (Golub and Van Loan, *Matrix Computations*, §3.4); N×N.
///
/// Rows and columns are first scaled by powers of two, so that graded matrices (diag(e⁻⁴⁰, 1)) are no harder than
/// others. Relative error: a few N u times the condition number of the scaled matrix.
///
/// `None` when a pivot vanishes, or when A or A⁻¹ is not finite. Nearly singular matrices are inverted: see
/// [`regular_inverse`].
pub fn inverse<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> Option<Matrix<S, N>> {
    if is_dominated(matrix) {
        let inverse = dominated_inverse(matrix);
        return finite(inverse.as_slice()).then_some(inverse);
    }
    let (rows, columns) = equilibration(matrix)?;
    let mut work = Matrix::<S, N>::from_fn(|r, c| matrix[(r, c)] * (rows[r] * columns[c]));
    let mut column_of = [0; N]; // the unknown that row k solves for
    let mut row_of: [usize; N] = std::array::from_fn(|r| r); // the row of A that row k was
    let mut done = [false; N];
    for k in 0..N {
        let (row, column) = largest(&work, k, &done)?;
        work.swap_rows(k, row);
        row_of.swap(k, row);
        column_of[k] = column;
        done[column] = true;
        eliminate(&mut work, k, column);
    }
    let mut result = Matrix::<S, N>::zeros();
    for k in 0..N {
        for j in 0..N {
            let scale = columns[column_of[k]] * rows[row_of[j]];
            result[(column_of[k], row_of[j])] = work[(k, column_of[j])] * scale;
        }
    }
    finite(result.as_slice()).then_some(result)
}

/// Whether in each column |a_cc| − Σ_{r≠c} |a_rc| > ¼ and Σ_r |a_rc| < 4. Elimination then needs neither pivots nor scaling: entries grow no
/// more than twofold (Higham 2002, §9.5), and ‖A‖₁ ‖A⁻¹‖₁ < 16 (Varah 1975).
pub(crate) fn is_dominated<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> bool {
    (0..N).all(|c| {
        let sum = (0..N).fold(0.0, |sum, r| sum + matrix[(r, c)].to_f64().abs());
        // A comparison with NaN is false.
        2.0 * matrix[(c, c)].to_f64().abs() - sum > 0.25 && sum < 4.0
    })
}

/// A⁻¹ of such a matrix.
pub(crate) fn dominated_inverse<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> Matrix<S, N> {
    let mut work = *matrix;
    for k in 0..N {
        eliminate(&mut work, k, k);
    }
    work
}

/// A step of Gauss–Jordan elimination in place, with the pivot in row k: a column that becomes one of the identity is replaced by that
/// of the inverse, where the identity was.
#[inline(always)]
fn eliminate<S: Scalar, const N: usize>(work: &mut Matrix<S, N>, k: usize, column: usize) {
    let pivot = S::one() / work[(k, column)];
    let mut factors: [S; N] = std::array::from_fn(|r| work[(r, column)]);
    for r in 0..N {
        work[(r, column)] = if r == k { S::one() } else { S::zero() };
    }
    factors[k] = S::zero();
    for c in 0..N {
        let value = work[(k, c)] * pivot;
        if const { heavy::<S>() } {
            loops::add_multiple(&mut work.as_mut_slice()[c * N..(c + 1) * N], &factors, -value);
        } else {
            for r in 0..N {
                work[(r, c)] -= factors[r] * value;
            }
        }
        work[(k, c)] = value;
    }
}

/// nalgebra's `try_inverse`, compiled once for a scalar: it brings the closed form for 4×4, unrolled, to every size.
pub(crate) fn quick_inverse<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> Option<Matrix<S, N>> {
    let inverse = dense_inverse(DMatrix::from_column_slice(N, N, matrix.as_slice()))?;
    Some(Matrix::from_column_slice(inverse.as_slice()))
}

#[inline(never)]
fn dense_inverse<S: Scalar>(matrix: DMatrix<S>) -> Option<DMatrix<S>> {
    matrix.try_inverse()
}

/// A⁻¹ where it has at least one correct digit.
///
/// # Errors
/// [`AlgebraError::NotFinite`] for a NaN or an infinity; [`AlgebraError::SingularBasis`] when no pivot is left, or
/// when N u ‖|A⁻¹| |A|‖_∞ ≥ 1 (Skeel's condition number, of A with its columns scaled to size 1).
pub fn regular_inverse<T: Real, const N: usize>(matrix: &Matrix<T, N>) -> Result<Matrix<T, N>, AlgebraError> {
    if !finite(matrix.as_slice()) {
        return Err(AlgebraError::NotFinite { what: "the basis change".into() });
    }
    let singular = |condition: f64| AlgebraError::SingularBasis { condition };
    let inverse = inverse(matrix).ok_or(singular(f64::INFINITY))?;
    let (_, columns) = equilibration(matrix).ok_or(singular(f64::INFINITY))?;
    let scaled = Matrix::<T, N>::from_fn(|r, c| (matrix[(r, c)] * columns[c]).abs());
    let undone = Matrix::<T, N>::from_fn(|r, c| (inverse[(r, c)] / columns[r]).abs());
    let product = undone * scaled;
    let condition = (0..N).fold(T::zero(), |m, r| m.max(product.row(r).sum()));
    if condition * T::int(N as i64) * T::unit_roundoff() < T::one() {
        Ok(inverse)
    } else {
        Err(singular(condition.to_f64()))
    }
}

/// The rank of A to working precision: that of A with rows and columns scaled to size 1, with pivots above 64 N u. `None` where an entry
/// is not finite.
pub(crate) fn numerical_rank<T: Real, const N: usize>(matrix: &Matrix<T, N>) -> Option<usize> {
    if !finite(matrix.as_slice()) {
        return None;
    }
    // A row or a column of zeros stays one.
    let scale = |sizes: [T; N]| sizes.map(|size| T::exact(power_of_two(size.to_f64()).unwrap_or(1.0)));
    let columns = scale(std::array::from_fn(|c| matrix.column(c).amax()));
    let scaled = Matrix::<T, N>::from_fn(|r, c| matrix[(r, c)] * columns[c]);
    let rows = scale(std::array::from_fn(|r| scaled.row(r).amax()));
    let scaled = Matrix::<T, N>::from_fn(|r, c| scaled[(r, c)] * rows[r]);
    Some(rank(&scaled, T::int(64 * N as i64) * T::unit_roundoff()))
}

/// The rank of A: the number of pivots above `threshold` (an absolute size) in elimination with complete pivoting.
pub fn rank<T: Real, const N: usize>(matrix: &Matrix<T, N>, threshold: T) -> usize {
    let mut left = *matrix;
    let mut done = [false; N];
    for k in 0..N {
        let Some((row, column)) = largest(&left, k, &done) else { return k };
        if left[(row, column)].abs() <= threshold {
            return k;
        }
        left.swap_rows(k, row);
        done[column] = true;
        for r in k + 1..N {
            let factor = left[(r, column)] / left[(k, column)];
            for c in 0..N {
                let l = left[(k, c)];
                left[(r, c)] -= factor * l;
            }
        }
    }
    N
}

/// The position of the largest entry in the rows from `first` on and the columns not `done`; `None` if it is zero.
fn largest<S: Scalar, const N: usize>(matrix: &Matrix<S, N>, first: usize, done: &[bool; N]) -> Option<(usize, usize)> {
    let (mut at, mut size) = (None, S::zero());
    for c in (0..N).filter(|c| !done[*c]) {
        for r in first..N {
            let entry = matrix[(r, c)].abs();
            if entry > size {
                (at, size) = (Some((r, c)), entry);
            }
        }
    }
    at
}

/// Powers of two that bring the rows, then the columns, to size about 1; `None` for a zero or non-finite one.
fn equilibration<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> Option<([S; N], [S; N])> {
    let (mut rows, mut columns) = ([S::one(); N], [S::one(); N]);
    // Columns first: in a basis change they are the new basis vectors, whose lengths are arbitrary.
    for c in 0..N {
        let size = (0..N).fold(0.0, |m: f64, r| larger(m, matrix[(r, c)]));
        columns[c] = S::exact(power_of_two(size)?);
    }
    for r in 0..N {
        let size = (0..N).fold(0.0, |m: f64, c| larger(m, matrix[(r, c)] * columns[c]));
        rows[r] = S::exact(power_of_two(size)?);
    }
    Some((rows, columns))
}

fn larger<S: Scalar>(size: f64, entry: S) -> f64 {
    let entry = if entry.all_finite() { entry.to_f64().abs() } else { f64::INFINITY };
    size.max(entry)
}

/// The place of the exponent among the bits of an `f64`, and what is added to it.
const EXPONENT: u32 = f64::MANTISSA_DIGITS - 1;
const BIAS: i64 = 1023;

/// 2^−k with 2^k ≤ size < 2^(k+1), kept inside ±500 so that products of two of them are exact.
pub(crate) fn power_of_two(size: f64) -> Option<f64> {
    // The exponent stands in the upper bits, of subnormal numbers as the least.
    let exponent = |x: f64| (x.to_bits() >> EXPONENT) as i64 - BIAS;
    let power = |k: i64| f64::from_bits(((BIAS + k) as u64) << EXPONENT);
    (size > 0.0 && size.is_finite()).then(|| power(-exponent(size).clamp(-500, 500)))
}
