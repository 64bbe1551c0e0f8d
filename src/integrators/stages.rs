//! Stage arrays: s vectors of N components, stage index contiguous.

use crate::scalar::{Real, Scalar};
use nalgebra::{DMatrix, RowSVector, SVector};

/// So many stages are computed at once, in registers; what lies past the last is zero.
const LANES: usize = 4;

/// The places that s stages take: whole sets of lanes.
fn places(stages: usize) -> usize {
    stages.next_multiple_of(LANES)
}

/// Four of them.
#[inline(always)]
fn lanes<S>(values: &[S]) -> &[S; LANES] {
    values.try_into().expect("a chunk has as many elements")
}

/// The larger of two numbers; in one instruction for several.
#[inline(always)]
fn larger<T: Real>(a: T, b: T) -> T {
    if b > a { b } else { a }
}

/// The weights w_ij of sums Σ_j w_ij x_j over stages: a matrix by columns, each filled up with zeros.
#[derive(Clone, Debug)]
pub(super) struct Weights<T> {
    columns: Vec<T>,
    /// 1 for each stage, 0 past the last.
    ones: Vec<T>,
}

impl<T: Real> Weights<T> {
    pub(super) fn of(matrix: &DMatrix<T>) -> Self {
        let filled = |values: &mut Vec<T>| values.resize(places(values.len()), T::zero());
        let (mut columns, mut ones) = (Vec::new(), vec![T::one(); matrix.nrows()]);
        for column in matrix.column_iter() {
            columns.extend(column.iter().copied());
            filled(&mut columns);
        }
        filled(&mut ones);
        Self { columns, ones }
    }
}

/// s vectors (or covectors) of N components each, component by component, so that the stages of one component are
/// adjacent and a combination Σ_j a_ij x_j runs along them.
#[derive(Clone, Debug)]
pub(super) struct Stages<S: Scalar, const N: usize> {
    stages: usize,
    places: usize,
    values: Vec<S>,
}

impl<S: Scalar, const N: usize> Stages<S, N> {
    pub(super) fn zeros(stages: usize) -> Self {
        let places = places(stages);
        Self { stages, places, values: vec![S::zero(); N * places] }
    }

    /// Component a of stage i.
    #[inline]
    pub(super) fn get(&self, i: usize, a: usize) -> S {
        self.values[a * self.places + i]
    }

    #[inline]
    pub(super) fn set(&mut self, i: usize, a: usize, value: S) {
        self.values[a * self.places + i] = value;
    }

    #[inline]
    pub(super) fn vector(&self, i: usize) -> SVector<S, N> {
        SVector::from_fn(|a, _| self.get(i, a))
    }

    #[inline]
    pub(super) fn covector(&self, i: usize) -> RowSVector<S, N> {
        RowSVector::from_fn(|_, a| self.get(i, a))
    }

    #[inline]
    pub(super) fn set_vector(&mut self, i: usize, value: &SVector<S, N>) {
        for a in 0..N {
            self.set(i, a, value[a]);
        }
    }

    #[inline]
    pub(super) fn set_covector(&mut self, i: usize, value: &RowSVector<S, N>) {
        for a in 0..N {
            self.set(i, a, value[a]);
        }
    }

    /// self_i ← Σ_j `weights`_ij `x`_j.
    #[inline]
    pub(super) fn combine<T: Real>(&mut self, weights: &Weights<T>, x: &Self)
    where
        S: Scalar<Base = T>,
    {
        for first in (0..self.places / LANES).map(|k| k * LANES) {
            let sums = self.sums(weights, x, first);
            for a in 0..N {
                self.values[a * self.places + first..][..LANES].copy_from_slice(&sums[a]);
            }
        }
    }

    /// Σ_j `weights`_ij `x`_j of the stages i from `first` on, component by component.
    #[inline(always)]
    fn sums<T: Real>(&self, weights: &Weights<T>, x: &Self, first: usize) -> [[S; LANES]; N]
    where
        S: Scalar<Base = T>,
    {
        let mut sums = [[S::zero(); LANES]; N];
        for j in 0..self.stages {
            let weights = lanes(&weights.columns[j * self.places + first..][..LANES]);
            for a in 0..N {
                let value = x.values[a * self.places + j];
                for lane in 0..LANES {
                    sums[a][lane] += S::lift(weights[lane]) * value;
                }
            }
        }
        sums
    }

    /// Σ_j `weights`_j self_j.
    #[inline]
    pub(super) fn sum<T: Real>(&self, weights: &[T]) -> SVector<S, N>
    where
        S: Scalar<Base = T>,
    {
        SVector::from_fn(|a, _| {
            let values = &self.values[a * self.places..a * self.places + self.stages];
            weights.iter().zip(values).fold(S::zero(), |sum, (&w, &value)| sum + S::lift(w) * value)
        })
    }
}

impl<T: Real, const N: usize> Stages<T, N> {
    /// All zero.
    pub(super) fn clear(&mut self) {
        self.values.fill(T::zero());
    }

    /// self_i ← `factor` Σ_j `weights`_ij `x`_j + `base`.
    #[inline]
    pub(super) fn advance(&mut self, weights: &Weights<T>, x: &Self, factor: T, base: &RowSVector<T, N>) {
        for first in (0..self.places / LANES).map(|k| k * LANES) {
            let sums = self.sums(weights, x, first);
            let ones = lanes(&weights.ones[first..][..LANES]);
            for a in 0..N {
                let values = &mut self.values[a * self.places + first..][..LANES];
                for lane in 0..LANES {
                    values[lane] = sums[a][lane] * factor + base[a] * ones[lane];
                }
            }
        }
    }

    /// self_i ← self_i + x_i.
    #[inline]
    pub(super) fn add(&mut self, x: &Self) {
        for (value, &x) in self.values.iter_mut().zip(&x.values) {
            *value += x;
        }
    }

    /// self_i ← self_i − x_i.
    #[inline]
    pub(super) fn subtract(&mut self, x: &Self) {
        for (value, &x) in self.values.iter_mut().zip(&x.values) {
            *value -= x;
        }
    }

    /// self_i ← x_i − y_i.
    #[inline]
    pub(super) fn difference(&mut self, x: &Self, y: &Self) {
        for ((value, &x), &y) in self.values.iter_mut().zip(&x.values).zip(&y.values) {
            *value = x - y;
        }
    }

    /// The largest |self − x| and the largest |self|, of all components; NaN if there is one.
    #[inline]
    pub(super) fn change(&self, x: &Self) -> (T, T) {
        let (mut change, mut size) = ([T::zero(); LANES], [T::zero(); LANES]);
        let mut sum = [T::zero(); LANES];
        for (these, those) in self.values.chunks_exact(LANES).zip(x.values.chunks_exact(LANES)) {
            let (these, those) = (lanes(these), lanes(those));
            for lane in 0..LANES {
                let difference = these[lane] - those[lane];
                sum[lane] += difference;
                change[lane] = larger(change[lane], difference.abs());
                size[lane] = larger(size[lane], these[lane].abs());
            }
        }
        let largest = |[a, b, c, d]: [T; LANES]| larger(larger(a, b), larger(c, d));
        // A comparison with NaN is false: a sum has it.
        let finite = sum.iter().all(|v| v.all_finite());
        (if finite { largest(change) } else { sum.iter().fold(T::zero(), |s, &v| s + v) }, largest(size))
    }
}
