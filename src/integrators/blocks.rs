//! Coordinates that are measured alike.
//!
//! A block is what every change of units multiplies by one factor, in one direct factor of the algebra: units k_a may be chosen freely up to
//! k_a + k_b = k_c wherever C^c_ab ≠ 0. On se(3) the rotations have none, k = 0: they are angles; the translations have one of their own.
//! Coordinates without any bracket are one block.

use crate::algebra::{Covector, LieAlgebra, Vector};
use crate::scalar::{Real, larger};

/// Units of two coordinates of a generic choice that differ by less are the same; constants below this share of the largest are rounding.
const SAME: f64 = 1e-9;

/// The generic choice of units: multiples of the golden ratio, modulo 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Coordinates of one unit.
#[derive(Clone, Debug)]
pub(in crate::integrators) struct Blocks<const N: usize> {
    /// Of each coordinate, the first of its block.
    first: [usize; N],
    /// Whether it is an angle: without a unit.
    pub angle: [bool; N],
    /// A number for each direct factor of the algebra.
    pub factor: [usize; N],
}

impl<const N: usize> Blocks<N> {
    pub fn of<T: Real>(algebra: &LieAlgebra<T, N>) -> Self {
        let size = |a: usize, b: usize, c: usize| algebra.constant(a, b, c).to_f64().abs();
        let places = || (0..N).flat_map(|a| (a + 1..N).flat_map(move |b| (0..N).map(move |c| [a, b, c])));
        let least = places().fold(0.0, |most: f64, [a, b, c]| most.max(size(a, b, c))) * SAME;
        let brackets: Vec<[usize; 3]> = places().filter(|&[a, b, c]| size(a, b, c) > least).collect();
        let (unit, factor) = (units::<N>(&brackets), factors::<N>(&brackets));
        let free = |a: usize| !brackets.iter().any(|bracket| bracket.contains(&a));
        let same = |a: usize, b: usize| match (free(a), free(b)) {
            (false, false) => factor[a] == factor[b] && (unit[a] - unit[b]).abs() < SAME,
            (one, other) => one && other,
        };
        Self {
            first: std::array::from_fn(|a| (0..a).find(|&b| same(a, b)).unwrap_or(a)),
            angle: std::array::from_fn(|a| !free(a) && unit[a].abs() < SAME),
            factor,
        }
    }

    /// The first coordinate of each block.
    pub fn each(&self) -> impl Iterator<Item = usize> + '_ {
        (0..N).filter(|&a| self.first[a] == a)
    }

    /// Gives each coordinate of a block, of which this is the first, a value.
    pub fn fill<T: Real>(&self, values: &mut Covector<T, N>, first: usize, value: T) {
        (0..N).filter(|&a| self.first[a] == first).for_each(|a| values[a] = value);
    }

    /// The part of a velocity that is angles.
    pub fn turning<T: Real>(&self, velocity: &Vector<T, N>) -> Vector<T, N> {
        Vector::from_fn(|a, _| if self.angle[a] { velocity[a] } else { T::zero() })
    }

    /// The largest |value| of the block of each coordinate.
    pub fn sizes<T: Real>(&self, values: &[T]) -> [T; N] {
        let mut sizes = [T::zero(); N];
        for a in 0..N {
            sizes[self.first[a]] = larger(sizes[self.first[a]], values[a].abs());
        }
        std::array::from_fn(|a| sizes[self.first[a]])
    }
}

/// A generic choice of units that all brackets allow: orthogonal to all k_a + k_b − k_c.
fn units<const N: usize>(brackets: &[[usize; 3]]) -> [f64; N] {
    let dot = |x: &[f64; N], y: &[f64; N]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let mut rows: Vec<[f64; N]> = Vec::new();
    let without = |mut x: [f64; N], rows: &[[f64; N]]| {
        // Twice, for rounding.
        for row in rows.iter().chain(rows) {
            let along = dot(&x, row);
            x.iter_mut().zip(row).for_each(|(x, row)| *x -= along * row);
        }
        x
    };
    for &[a, b, c] in brackets {
        let mut row = [0.0; N];
        row[a] += 1.0;
        row[b] += 1.0;
        row[c] -= 1.0;
        let row = without(row, &rows);
        let length = dot(&row, &row).sqrt();
        if length > SAME {
            rows.push(row.map(|value| value / length));
        }
    }
    without(std::array::from_fn(|a| ((a + 1) as f64 * GOLDEN).fract()), &rows)
}

/// A number for each direct factor: coordinates that a chain of brackets connects have the same.
fn factors<const N: usize>(brackets: &[[usize; 3]]) -> [usize; N] {
    let mut factor = std::array::from_fn(|a| a);
    for bracket in brackets {
        let least = bracket.iter().map(|&a| factor[a]).min().unwrap_or(0);
        let joined = bracket.map(|a| factor[a]);
        factor.iter_mut().filter(|factor| joined.contains(factor)).for_each(|factor| *factor = least);
    }
    factor
}
