//! How far a matrix is from a group of the catalogue.

use crate::algebra::catalogue::{Entry, Equations, Kind, placed};
#[cfg(feature = "harness")]
use crate::algebra::{Matrix, elimination};
use crate::scalar::Real;

/// The largest violation of the equations of the group of `entry`, in its standard representation, by the matrix g(r, c).
///
/// SO(n): |gᵀg − 1|; SE(n): that of the rotation and the last row; ℝⁿ, aff(1), Heisenberg: the entries that are fixed;
/// SL(2): |det g − 1|; products: blocks of these and zeros. Infinite for a NaN, and in another component (det g < 0).
pub fn departure<T: Real>(entry: &Entry, g: &dyn Fn(usize, usize) -> T) -> T {
    let size = entry.matrix_size();
    if (0..size * size).any(|k| !g(k / size, k % size).all_finite()) {
        return T::exact(f64::INFINITY);
    }
    match entry.kind() {
        Kind::Abelian(n) => fixed(size, g, |_, c| c < n).max((g(n, n) - T::one()).abs()),
        Kind::Named(named) => match named.group {
            Equations::Rotations => orthogonal(size, g),
            Equations::Motions => orthogonal(size - 1, g).max(last_row(size, g)),
            Equations::Special => (determinant(size, g) - T::one()).abs(),
            Equations::Affine if determinant(size, g) <= T::zero() => T::exact(f64::INFINITY),
            Equations::Affine => last_row(size, g),
            Equations::Unitriangular => fixed(size, g, |r, c| r >= c),
        },
        Kind::Product(factors) => {
            let mut most = T::zero();
            for (_, corner, factor) in placed(factors) {
                let end = corner + factor.matrix_size();
                most = most.max(departure(factor, &|r, c| g(corner + r, corner + c)));
                for r in corner..end {
                    let outside = (0..corner).chain(end..size).map(|c| g(r, c).abs());
                    most = outside.fold(most, |most, v| most.max(v));
                }
            }
            most
        }
    }
}

/// Replaces each block of g that is a rotation, or that of a motion, by the nearest rotation; g is near to the group of `entry`.
#[cfg(feature = "harness")]
pub(crate) fn nearest_rotations<T: Real, const D: usize>(entry: &Entry, g: &mut Matrix<T, D>) {
    fn blocks(entry: &Entry, corner: usize, found: &mut Vec<(usize, usize)>) {
        match entry.kind() {
            Kind::Product(factors) => {
                placed(factors).for_each(|(_, inner, factor)| blocks(factor, corner + inner, found));
            }
            _ => found.push((corner, entry.rotation())),
        }
    }
    let mut found = Vec::new();
    blocks(entry, 0, &mut found);
    for (corner, n) in found {
        let inside = |r: usize, c: usize| r < n && c < n;
        let start = |r, c| if inside(r, c) { g[(corner + r, corner + c)] } else { T::int(i64::from(r == c)) };
        let mut turn = Matrix::<T, 4>::from_fn(start);
        // Newton's iteration for the polar factor (Higham 1986) squares the departure.
        for _ in 0..SQUARINGS {
            let Some(inverse) = elimination::inverse(&turn) else { break };
            turn = (turn + inverse.transpose()) * T::half();
        }
        for r in 0..n {
            (0..n).for_each(|c| g[(corner + r, corner + c)] = turn[(r, c)]);
        }
    }
}

/// From 0.01 to far less than the round-off of 32 digits.
#[cfg(feature = "harness")]
const SQUARINGS: usize = 8;

/// |gᵀg − 1| of the first n rows and columns; infinite where they reflect.
fn orthogonal<T: Real>(n: usize, g: &dyn Fn(usize, usize) -> T) -> T {
    if determinant(n, g) <= T::zero() {
        return T::exact(f64::INFINITY);
    }
    let mut most = T::zero();
    for a in 0..n {
        for b in 0..=a {
            let start = if a == b { -T::one() } else { T::zero() };
            most = most.max((0..n).fold(start, |sum, r| sum + g(r, a) * g(r, b)).abs());
        }
    }
    most
}

/// The determinant of the first n rows and columns, n ≤ 4, by its last row.
fn determinant<T: Real>(n: usize, g: &dyn Fn(usize, usize) -> T) -> T {
    if n == 0 {
        return T::one();
    }
    (0..n).fold(T::zero(), |sum, c| {
        let minor = determinant(n - 1, &|r, k| g(r, if k < c { k } else { k + 1 }));
        let term = g(n - 1, c) * minor;
        if (n - 1 + c).is_multiple_of(2) { sum + term } else { sum - term }
    })
}

/// The last of n rows against (0 … 0 1).
fn last_row<T: Real>(n: usize, g: &dyn Fn(usize, usize) -> T) -> T {
    fixed(n, g, |r, _| r + 1 == n)
}

/// Entries of the n×n matrix that have to be those of the identity.
fn fixed<T: Real>(n: usize, g: &dyn Fn(usize, usize) -> T, which: impl Fn(usize, usize) -> bool) -> T {
    let mut most = T::zero();
    for r in 0..n {
        for c in (0..n).filter(|&c| which(r, c)) {
            let one = if r == c { T::one() } else { T::zero() };
            most = most.max((g(r, c) - one).abs());
        }
    }
    most
}
