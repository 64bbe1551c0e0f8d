//! Numbers of a case: lists as text, vectors and matrices in a scalar; dyadic numbers.

use super::error::{CaseError, CaseProblem, Place};
use crate::algebra::{Matrix, Vector};
use crate::scalar::{Number, Real};

/// `[1, 1/2]`.
pub(super) fn list(items: &[Number]) -> String {
    let items: Vec<String> = items.iter().map(ToString::to_string).collect();
    format!("[{}]", items.join(", "))
}

/// `[[1, 0], [0, 1]]`.
pub(super) fn rows(items: &[Vec<Number>]) -> String {
    let items: Vec<String> = items.iter().map(|row| list(row)).collect();
    format!("[{}]", items.join(", "))
}

/// k − 1 for k in 1, …, n.
pub(super) fn below(k: usize, n: usize) -> Option<usize> {
    k.checked_sub(1).filter(|k| *k < n)
}

/// The same for an index of a component.
pub(super) fn index(k: usize, n: usize, place: Place) -> Result<usize, CaseError> {
    below(k, n).ok_or_else(|| place.range(format!("the index {k}"), format!("1 to {n}, the dimension")))
}

/// The value of `number` in `T`.
pub(super) fn number<T: Real>(number: &Number, place: &Place) -> Result<T, CaseError> {
    let value: T = number.eval().map_err(|e| place.error(CaseProblem::Number(e)))?;
    if value.all_finite() { Ok(value) } else { Err(place.error(CaseProblem::NotFinite { text: number.to_string() })) }
}

/// The vector with these n components, and 0 for spectators.
pub(super) fn vector<T: Real, const N: usize>(
    list: &[Number],
    n: usize,
    place: &Place,
) -> Result<Vector<T, N>, CaseError> {
    vector_of(list, n, DIMENSION, place)
}

/// The same of another length, and why that is.
pub(super) fn vector_of<T: Real, const N: usize>(
    list: &[Number],
    n: usize,
    why: &'static str,
    place: &Place,
) -> Result<Vector<T, N>, CaseError> {
    let values = values(list, n, why, place)?;
    Ok(Vector::from_fn(|a, _| values.get(a).copied().unwrap_or_else(T::zero)))
}

/// The values of n numbers.
fn values<T: Real>(list: &[Number], n: usize, why: &'static str, place: &Place) -> Result<Vec<T>, CaseError> {
    length(list.len(), n, why, place)?;
    list.iter().enumerate().map(|(a, entry)| number(entry, &place.index(a))).collect()
}

/// The matrix with these n rows, and `spectators` on the diagonal for spectators.
pub(super) fn square<T: Real, const N: usize>(
    rows: &[Vec<Number>],
    n: usize,
    spectators: T,
    place: &Place,
) -> Result<Matrix<T, N>, CaseError> {
    square_of(rows, (n, DIMENSION), spectators, place)
}

/// The same of another size, and why that is.
pub(super) fn square_of<T: Real, const N: usize>(
    rows: &[Vec<Number>],
    (n, why): (usize, &'static str),
    spectators: T,
    place: &Place,
) -> Result<Matrix<T, N>, CaseError> {
    length(rows.len(), n, why, place)?;
    let row = |(a, row): (usize, &Vec<Number>)| values(row, n, why, &place.index(a));
    let rows = rows.iter().enumerate().map(row).collect::<Result<Vec<Vec<T>>, _>>()?;
    Ok(Matrix::from_fn(|r, c| match rows.get(r).and_then(|row| row.get(c)) {
        Some(value) => *value,
        None if r == c => spectators,
        None => T::zero(),
    }))
}

/// Why most lists are as long as they are.
const DIMENSION: &str = "the dimension of the algebra";

/// Refuses another length, and says why.
pub(super) fn length(found: usize, wanted: usize, why: &'static str, place: &Place) -> Result<(), CaseError> {
    if found == wanted { Ok(()) } else { Err(place.error(CaseProblem::Length { found, wanted, why })) }
}

/// Refuses entries that differ from their mirror image by more than rounding, and says which.
pub(super) fn symmetric<T: Real, const N: usize>(
    m: &Matrix<T, N>,
    rows: &[Vec<Number>],
    place: &Place,
) -> Result<(), CaseError> {
    symmetric_of(m.as_slice(), N, rows, place)
}

/// The same of the entries of an n×n matrix by columns.
fn symmetric_of<T: Real>(m: &[T], n: usize, rows: &[Vec<Number>], place: &Place) -> Result<(), CaseError> {
    let size = m.iter().fold(T::zero(), |size, v| size.max(v.abs()));
    let bound = T::int(64 * n as i64) * T::unit_roundoff() * size;
    for r in 0..rows.len() {
        for c in 0..r {
            if (m[c * n + r] - m[r * n + c]).abs() > bound {
                return Err(place.index(r).index(c).error(CaseProblem::NotSymmetric {
                    row: r + 1,
                    column: c + 1,
                    entry: rows[r][c].to_string(),
                    mirrored: rows[c][r].to_string(),
                }));
            }
        }
    }
    Ok(())
}

/// p/q in lowest terms, q a power of two.
pub(super) fn dyadic(mut p: i64, mut q: i64) -> Number {
    while q > 1 && p % 2 == 0 {
        (p, q) = (p / 2, q / 2);
    }
    Number::ratio(p, q)
}

/// The dyadic number that `x` is, if its denominator is at most 2²⁰ (and x is moderate).
pub(super) fn from_dyadic(x: f64) -> Option<Number> {
    let (mut p, mut q) = (x, 1_i64);
    while p.fract() != 0.0 && q < 1 << 20 {
        (p, q) = (p * 2.0, q * 2);
    }
    (p.fract() == 0.0 && p.abs() < 1e15).then(|| dyadic(p as i64, q))
}

/// A count from 1 to `most`.
pub(super) fn count(value: i64, most: u64, place: &Place) -> Result<u64, CaseError> {
    match u64::try_from(value) {
        Ok(count) if (1..=most).contains(&count) => Ok(count),
        _ => Err(place.range(value, format!("an integer from 1 to {most}"))),
    }
}
