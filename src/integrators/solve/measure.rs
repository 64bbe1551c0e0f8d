//! What errors are relative to.
//!
//! A product of groups, or the rotations and translations of a rigid body, have momenta in different units, and momenta of one unit may differ in
//! size by orders of magnitude. So each block of coordinates is measured by its own size. A block is
//! what every change of units multiplies by one factor, in one direct factor of the algebra: units k_a may be chosen freely up to k_a + k_b = k_c
//! wherever C^c_ab ≠ 0. On se(3) the rotations have none, k = 0: they are angles; the translations have one of their own. Coordinates without any
//! bracket are one block.
//!
//! A small error of the momentum may be a large one of the velocity, about an axis with little inertia: velocities are measured, too.

use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, apply, elimination};
use crate::integrators::variational::{Factors, relative};
use crate::retraction::Retraction;
use crate::scalar::{Real, larger};

/// Units of two coordinates of a generic choice that differ by less are the same; constants below this share of the largest are rounding.
const SAME: f64 = 1e-9;

/// The generic choice of units: multiples of the golden ratio, modulo 1.
const GOLDEN: f64 = 0.618_033_988_749_894_9;

/// Generators are differences of τ over so much of either sign: the quotient is their derivative to 10⁻¹⁰ and better.
const APART: f64 = 1.0 / 1_048_576.0;

/// Generators that are dependent up to this share count as such.
const DEPENDENT: f64 = 1e-12;

/// Coordinates of one unit.
#[derive(Clone, Debug)]
pub(super) struct Blocks<const N: usize> {
    /// Of each coordinate, the first of its block.
    first: [usize; N],
    /// Whether it is an angle: without a unit.
    angle: [bool; N],
    /// A number for each direct factor of the algebra.
    factor: [usize; N],
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

/// Coordinates of group elements near the identity.
#[derive(Clone, Debug)]
pub(super) struct Chart<T: Real, const N: usize, const D: usize> {
    rows: Vec<Matrix<T, D>>,
}

impl<T: Real, const N: usize, const D: usize> Chart<T, N, D> {
    /// By the generators of τ; none where there is no group.
    pub fn of<R: Retraction<T, N, D>>(retraction: &R) -> Option<Self> {
        let (apart, mut generators, mut lengths) = (T::exact(APART), Vec::with_capacity(N), [T::one(); N]);
        for (a, length) in lengths.iter_mut().enumerate() {
            let at = |x: T| retraction.tau(&Vector::from_fn(|b, _| if a == b { x } else { T::zero() }));
            let (Ok(forward), Ok(back)) = (at(apart), at(-apart)) else { return None };
            let generator: Matrix<T, D> = (forward - back) / (apart + apart);
            let size = generator.amax();
            *length = if size > T::zero() { size } else { T::one() };
            generators.push(generator / *length);
        }
        let gram = Matrix::<T, N>::from_fn(|a, b| {
            generators[a].dot(&generators[b]) + if a == b { T::exact(DEPENDENT) } else { T::zero() }
        });
        let inverse = elimination::inverse(&gram)?;
        let row = |a: usize| {
            let sum = generators.iter().enumerate().fold(Matrix::zeros(), |sum, (b, x)| sum + x * inverse[(a, b)]);
            sum / lengths[a]
        };
        Some(Self { rows: (0..N).map(row).collect() })
    }

    /// x, to first order, where g = τ(x).
    pub fn coordinates(&self, g: &Matrix<T, D>) -> Vector<T, N> {
        let moved = g - Matrix::<T, D>::identity();
        Vector::from_fn(|a, _| self.rows[a].dot(&moved))
    }

    /// The most that rounding makes of them, in units of round-off, where this is the product of the |entries| that make g.
    pub fn rounding(&self, product: &Matrix<T, D>) -> Vector<T, N> {
        Vector::from_fn(|a, _| self.rows[a].iter().zip(product).fold(T::zero(), |sum, (v, p)| sum + v.abs() * *p))
    }
}

/// An error: |δμ|, |δη| and |δx|, x the displacement.
#[derive(Clone, Debug)]
pub(super) struct Difference<T: Real, const N: usize> {
    pub momentum: Covector<T, N>,
    pub velocity: Vector<T, N>,
    pub displacement: Vector<T, N>,
}

impl<T: Real, const N: usize> Difference<T, N> {
    /// Each coordinate times its factor.
    pub fn times(self, factor: &[T; N]) -> Self {
        Self {
            momentum: Covector::from_fn(|_, a| self.momentum[a] * factor[a]),
            velocity: Vector::from_fn(|a, _| self.velocity[a] * factor[a]),
            displacement: Vector::from_fn(|a, _| self.displacement[a] * factor[a]),
        }
    }
}

/// What moves as easily in the units of [`Measure::turning`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ease {
    OfBlocks,
    OfCoordinates,
}

/// What errors are relative to, and what an error of the momentum makes of the velocity.
#[derive(Clone, Debug)]
pub(super) struct Measure<T: Real, const N: usize> {
    pub blocks: Blocks<N>,
    /// For each coordinate, the size of its block.
    pub momentum: [T; N],
    pub velocity: [T; N],
    pub displacement: [T; N],
    /// |∂η/∂μ|.
    pub mobility: Matrix<T, N>,
    /// The largest momentum at hand: what residuals are relative to.
    pub size: T,
}

impl<T: Real, const N: usize> Measure<T, N> {
    /// Nothing has moved yet.
    pub fn new(algebra: &LieAlgebra<T, N>) -> Self {
        let blocks = Blocks::of(algebra);
        let [momentum, velocity] = [[T::zero(); N]; 2];
        let displacement = Self::at_least(&blocks);
        Self { blocks, momentum, velocity, displacement, mobility: Matrix::zeros(), size: T::zero() }
    }

    /// Begins again.
    pub fn reset(&mut self) {
        (self.momentum, self.velocity) = ([T::zero(); N], [T::zero(); N]);
        (self.displacement, self.size) = (Self::at_least(&self.blocks), T::zero());
    }

    /// Angles are relative to a radian.
    fn at_least(blocks: &Blocks<N>) -> [T; N] {
        std::array::from_fn(|a| if blocks.angle[a] { T::one() } else { T::zero() })
    }

    /// Sizes grow to these.
    pub fn grow(&mut self, momentum: &Covector<T, N>, velocity: &Vector<T, N>, displacement: &Vector<T, N>) {
        let of = |sizes: &mut [T; N], values: &[T]| {
            let new = self.blocks.sizes(values);
            sizes.iter_mut().zip(new).for_each(|(size, new)| *size = larger(*size, new));
        };
        of(&mut self.momentum, momentum.as_slice());
        of(&mut self.velocity, velocity.as_slice());
        of(&mut self.displacement, displacement.as_slice());
    }

    /// The largest entry of ad_η, in units in which all blocks, or all coordinates, are moved as easily by a momentum of theirs: of a body that flies
    /// at a speed v, v over its radius of gyration. That is how fast the stages follow each other in iterations.
    pub fn turning(&self, ad: &Matrix<T, N>, ease: Ease) -> T {
        let each: [T; N] = std::array::from_fn(|a| self.mobility[(a, a)].abs());
        let eased = if ease == Ease::OfBlocks { self.blocks.sizes(&each) } else { each };
        let entry = |c: usize, b: usize| match eased[b] == eased[c] {
            true => ad[(c, b)].abs(),
            false if eased[c] > T::zero() => ad[(c, b)].abs() * (eased[b] / eased[c]).sqrt(),
            false => T::zero(),
        };
        (0..N * N).fold(T::zero(), |most, k| larger(most, entry(k / N, k % N)))
    }

    /// |∂η/∂μ| |δμ|.
    pub fn moved(&self, momentum: &Covector<T, N>) -> Vector<T, N> {
        apply(&self.mobility, &momentum.transpose())
    }

    /// An error of the momentum, and what it makes of the velocity.
    pub fn of_momentum(&self, momentum: Covector<T, N>) -> Difference<T, N> {
        Difference { velocity: self.moved(&momentum), momentum, displacement: Vector::zeros() }
    }

    /// The relative size of an error, without what `explained` of the momentum makes of it and without this much of each coordinate.
    pub fn relative(&self, error: &Difference<T, N>, explained: &Covector<T, N>, noise: [T; N]) -> T {
        let (moved, mut most) = (self.moved(explained), T::zero());
        let left = |value: T, explained: T| if value <= explained { T::zero() } else { value - explained };
        for a in 0..N {
            let momentum = relative(left(error.momentum[a], explained[a]), self.momentum[a]);
            let velocity = relative(left(error.velocity[a], moved[a]), self.velocity[a]);
            let displacement = relative(error.displacement[a], self.displacement[a]);
            most = larger(most, left(larger(momentum, larger(velocity, displacement)), noise[a]));
        }
        most
    }

    /// The relative size of a displacement.
    pub fn displaced(&self, x: &Vector<T, N>) -> T {
        (0..N).fold(T::zero(), |most, a| larger(most, relative(x[a].abs(), self.displacement[a])))
    }

    /// The relative size of a momentum.
    pub fn shifted(&self, m: &Covector<T, N>) -> T {
        (0..N).fold(T::zero(), |most, a| larger(most, relative(m[a].abs(), self.momentum[a])))
    }

    /// How many times residuals count, which are relative to the largest coordinate, so that they are relative to their own block and to what they make
    /// of the velocities. Not of blocks of which there are no more than `noise` units of rounding.
    pub fn factors(&self, noise: i64) -> Factors<T, N> {
        let rounding = T::int(noise) * T::unit_roundoff();
        let of = |size: T, made: T, own: T| if made * size * rounding < own { made * size / own } else { T::one() };
        let far = self.displacement.iter().fold(T::zero(), |most, &size| larger(most, size));
        let momentum = |a: usize| {
            let moves = (0..N).map(|c| of(self.size, self.mobility[(c, a)], self.velocity[c]));
            moves.fold(of(self.size, T::one(), self.momentum[a]), larger)
        };
        let momenta: [T; N] = std::array::from_fn(|a| momentum(a).max(T::one()));
        // The terms of one direct factor are not in the stages of another.
        let beside = |a: usize| (0..N).filter(move |&b| self.blocks.factor[b] == self.blocks.factor[a]);
        let least = |a: usize| beside(a).fold(momenta[a], |least, b| least.min(momenta[b]));
        let spread = (0..N).fold(T::one(), |most, a| larger(most, momenta[a] / least(a)));
        Factors {
            momenta,
            spread,
            displacements: std::array::from_fn(|a| of(far, T::one(), self.displacement[a]).max(T::one())),
        }
    }
}
