//! Norms of small matrices, and the inverse with its condition judged.

use crate::algebra::Matrix;
use crate::algebra::elimination::inverse;
use crate::scalar::Scalar;

/// A sum of matrices to be inverted, with the sizes of what was added: they tell cancellation from bad scaling.
#[derive(Clone, Debug)]
pub(super) struct Sum<S: Scalar, const N: usize> {
    value: Matrix<S, N>,
    sizes: Matrix<f64, N>,
}

impl<S: Scalar, const N: usize> Sum<S, N> {
    /// A sum of one term.
    pub fn of(term: Matrix<S, N>) -> Self {
        Self { value: term, sizes: sizes(&term) }
    }

    /// The sum with one more term.
    pub fn plus(self, term: &Matrix<S, N>) -> Self {
        Self { value: self.value + term, sizes: self.sizes + sizes(term) }
    }

    /// The value.
    pub fn value(&self) -> &Matrix<S, N> {
        &self.value
    }

    /// The inverse, or `None` if the sum is singular to working precision.
    ///
    /// With E the sum of the terms' absolute values and A the sum, that is when 64 N u `noise` ρ(|A⁻¹| E) ≥ 1: an
    /// estimate that scaling rows and columns (E with them) does not change. `noise` is what the terms are off by, in u.
    pub fn invert(&self, noise: f64) -> Option<Matrix<S, N>> {
        let inverse = inverse(&self.value)?;
        let limit = 1.0 / (64.0 * N as f64 * S::unit_roundoff().to_f64() * noise);
        let plain = norm(&self.sizes) * norm(&inverse);
        (plain < limit || spectral_radius(sizes(&inverse) * self.sizes) < limit).then_some(inverse)
    }
}

/// |A|, entry by entry.
fn sizes<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> Matrix<f64, N> {
    matrix.map(|v| v.to_f64().abs())
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

/// An upper estimate of the spectral radius of a nonnegative matrix, ‖A⁸‖^⅛; infinite when that overflows.
fn spectral_radius<const N: usize>(mut power: Matrix<f64, N>) -> f64 {
    for _ in 0..3 {
        power = power * power;
    }
    let estimate = norm(&power).powf(0.125);
    if estimate.is_finite() { estimate } else { f64::INFINITY }
}

/// The most rounds of balancing. A round moves each scale by 2 at most: units that differ by more than 2⁶⁴ stay so, and cost
/// more squarings.
const MAX_ROUNDS: usize = 64;

/// The norm after the best diagonal similarity by powers of two (Osborne 1960; Parlett and Reinsch 1969).
///
/// Series and doublings commute exactly with such a similarity, so this is the norm that decides how far to scale
/// down: a large translation beside a small rotation must not cost digits.
pub(super) fn balanced_norm<S: Scalar, const N: usize>(matrix: &Matrix<S, N>) -> f64 {
    norm(&balanced(matrix.map(|v| v.to_f64())))
}

/// After that similarity.
fn balanced<const N: usize>(mut work: Matrix<f64, N>) -> Matrix<f64, N> {
    for _ in 0..MAX_ROUNDS {
        let mut changed = false;
        for i in 0..N {
            let (mut row, mut column) = (0.0, 0.0);
            for j in 0..N {
                if j != i {
                    row += work[(i, j)].abs();
                    column += work[(j, i)].abs();
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
            if row + column < 1e-3 * work[(i, i)].abs().max(1.0) {
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
    work
}

/// What a coefficient may be off by, relative to its size, where the sign of a polynomial is asked for: rounding is less.
const SURE: f64 = 1.0 / (1_u64 << 40) as f64;

/// The most halvings of an interval in the search for a zero.
const HALVINGS: usize = 40;

/// Whether no real eigenvalue of a matrix is 1 or more in absolute value; `false` where rounding leaves it open.
///
/// That is det(1 − t A²) > 0 for 0 ≤ t ≤ 1. Two conditions are enough, and cheaper: ‖A‖ < 1, and ‖A + Aᵀ‖ < 2 (a real eigenvalue is
/// a value of the quadratic form), both after the best diagonal similarity. Else the coefficients are found by Leverrier's method, and their
/// signs decide in Bernstein's basis on smaller and smaller intervals (Lane and Riesenfeld 1981).
pub(crate) fn real_eigenvalues_below_one<const D: usize>(matrix: &Matrix<f64, D>) -> bool {
    let matrix = balanced(*matrix);
    if norm(&matrix) < 1.0 || norm(&(matrix + matrix.transpose())) < 2.0 {
        return true;
    }
    let square = matrix * matrix;
    // Bernstein's coefficients on [0, 1] of 1 + Σ c_k t^k, lowered by the rounding of c_k: Σ_k binom(j, k)/binom(D, k) c_k.
    let mut polynomial = [[0.0; D]; 2];
    let bernstein = &mut polynomial.as_flattened_mut()[..=D];
    bernstein.fill(1.0);
    let mut power = Matrix::<f64, D>::identity();
    for k in 1..=D {
        power = square * power;
        let c = -power.trace() / k as f64;
        for i in 0..D {
            power[(i, i)] += c;
        }
        let lowered = c - SURE * c.abs();
        for (j, b) in bernstein.iter_mut().enumerate().skip(k) {
            *b += lowered * (0..k).fold(1.0, |share, i| share * (j - i) as f64 / (D - i) as f64);
        }
    }
    positive(polynomial, HALVINGS)
}

/// Whether a polynomial of degree D is positive on an interval, by its coefficients in Bernstein's basis, the first D + 1 of these.
fn positive<const D: usize>(mut polynomial: [[f64; D]; 2], halvings: usize) -> bool {
    let right = &mut polynomial.as_flattened_mut()[..=D];
    if right.iter().all(|b| *b > 0.0) {
        return true;
    }
    let above = |b: Option<&f64>| b.is_some_and(|b| *b > 0.0);
    if halvings == 0 || !above(right.first()) || !above(right.last()) {
        return false;
    }
    // De Casteljau's scheme at the middle: its first column is the left half, what is left of the row the right one.
    let mut halves = [[0.0; D]; 2];
    for (k, b) in halves.as_flattened_mut()[..=D].iter_mut().enumerate() {
        *b = right[0];
        for j in 0..D - k {
            right[j] = (right[j] + right[j + 1]) / 2.0;
        }
    }
    positive(halves, halvings - 1) && positive(polynomial, halvings - 1)
}
