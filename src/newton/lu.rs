//! LU factors with partial pivoting, and what they tell of a matrix.

use crate::scalar::{Real, max_abs};
use nalgebra::DMatrix;

/// The determinant of a factored matrix: sign and natural logarithm of the absolute value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Determinant<T> {
    pub negative: bool,
    pub log: T,
}

/// LU factors, in place, with partial pivoting; `None` when the matrix is singular.
pub(super) fn factor<T: Real>(m: &mut DMatrix<T>, pivots: &mut [usize]) -> Option<Determinant<T>> {
    let n = pivots.len();
    let mut determinant = Determinant { negative: false, log: T::zero() };
    for k in 0..n {
        let mut p = k;
        for i in k + 1..n {
            if m[(i, k)].abs() > m[(p, k)].abs() {
                p = i;
            }
        }
        pivots[k] = p;
        if p != k {
            m.swap_rows(p, k);
            determinant.negative = !determinant.negative;
        }
        let pivot = m[(k, k)];
        if pivot == T::zero() || !pivot.all_finite() {
            return None;
        }
        determinant.negative ^= pivot < T::zero();
        determinant.log += pivot.abs().ln();
        for i in k + 1..n {
            m[(i, k)] /= pivot;
        }
        for j in k + 1..n {
            let factor = m[(k, j)];
            for i in k + 1..n {
                let lower = m[(i, k)];
                m[(i, j)] -= lower * factor;
            }
        }
    }
    Some(determinant)
}

/// Whether a symmetric matrix is positive definite: by Cholesky's method, in its lower triangle.
pub(super) fn is_definite<T: Real>(m: &mut DMatrix<T>) -> bool {
    let n = m.nrows();
    for k in 0..n {
        let pivot = m[(k, k)];
        // NaN is not positive.
        if !pivot.all_finite() || pivot <= T::zero() {
            return false;
        }
        for j in k + 1..n {
            let factor = m[(j, k)] / pivot;
            for i in j..n {
                let lower = m[(i, k)];
                m[(i, j)] -= lower * factor;
            }
        }
    }
    true
}

/// x ← J⁻¹ x by the factors of J.
pub(super) fn solve_factored<T: Real>(m: &DMatrix<T>, pivots: &[usize], x: &mut [T]) {
    let n = pivots.len();
    for k in 0..n {
        x.swap(k, pivots[k]);
    }
    for k in 0..n {
        let value = x[k];
        for i in k + 1..n {
            x[i] -= m[(i, k)] * value;
        }
    }
    for k in (0..n).rev() {
        x[k] /= m[(k, k)];
        let value = x[k];
        for i in 0..k {
            x[i] -= m[(i, k)] * value;
        }
    }
}

/// LU factors of a matrix, to solve with its transpose.
#[derive(Clone, Debug)]
pub(crate) struct Factors<T: Real> {
    matrix: DMatrix<T>,
    pivots: Vec<usize>,
    /// For the condition number: sizes of the columns of J, a column of J⁻¹, sums over its rows.
    sizes: Vec<T>,
    column: Vec<T>,
    sums: Vec<T>,
}

impl<T: Real> Factors<T> {
    /// Room for an n×n matrix.
    pub(crate) fn new(n: usize) -> Self {
        let zeros = vec![T::zero(); n];
        Self {
            matrix: DMatrix::zeros(n, n),
            pivots: vec![0; n],
            sizes: zeros.clone(),
            column: zeros.clone(),
            sums: zeros,
        }
    }

    /// Factors J and returns Skeel's condition number ‖|J⁻¹| |J|‖_∞, of J with its columns scaled to size 1; infinite where J is
    /// singular.
    pub(crate) fn factor(&mut self, matrix: &DMatrix<T>) -> T {
        let n = self.pivots.len();
        self.matrix.copy_from(matrix);
        if factor(&mut self.matrix, &mut self.pivots).is_none() {
            return T::exact(f64::INFINITY);
        }
        for (size, column) in self.sizes.iter_mut().zip(matrix.column_iter()) {
            *size = max_abs(column.as_slice());
        }
        self.sums.fill(T::zero());
        for r in 0..n {
            self.column.fill(T::zero());
            self.column[r] = T::one();
            solve_factored(&self.matrix, &self.pivots, &mut self.column);
            let weight = (0..n).fold(T::zero(), |sum, c| sum + matrix[(r, c)].abs() / self.sizes[c]);
            for k in 0..n {
                self.sums[k] += self.column[k].abs() * self.sizes[k] * weight;
            }
        }
        max_abs(&self.sums)
    }

    /// x ← J⁻ᵀ x.
    pub(crate) fn solve_transposed(&self, x: &mut [T]) {
        let (m, n) = (&self.matrix, self.pivots.len());
        for k in 0..n {
            let known = (0..k).fold(x[k], |rest, i| rest - m[(i, k)] * x[i]);
            x[k] = known / m[(k, k)];
        }
        for k in (0..n).rev() {
            x[k] = (k + 1..n).fold(x[k], |rest, i| rest - m[(i, k)] * x[i]);
        }
        for k in (0..n).rev() {
            x.swap(k, self.pivots[k]);
        }
    }
}
