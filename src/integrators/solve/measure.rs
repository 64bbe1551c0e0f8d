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
use crate::integrators::blocks::Blocks;
use crate::integrators::variational::{Factors, relative};
use crate::retraction::Retraction;
use crate::scalar::{Real, larger};

/// Generators are differences of τ over so much of either sign: the quotient is their derivative to 10⁻¹⁰ and better.
const APART: f64 = 1.0 / 1_048_576.0;

/// Generators that are dependent up to this share count as such.
const DEPENDENT: f64 = 1e-12;

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
