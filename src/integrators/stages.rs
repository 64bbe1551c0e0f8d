//! Stage arrays: s vectors of N components, stage index contiguous.

use crate::scalar::Real;
use nalgebra::{DMatrix, RowSVector, SVector};

/// The number of stages of `f64` that are computed at once, in registers; what lies past the last is zero. Other scalars are computed one by one.
const LANES: usize = 4;

/// How many at once.
#[inline(always)]
const fn width<T>() -> usize {
    if size_of::<T>() <= size_of::<f64>() { LANES } else { 1 }
}

/// The places that s stages take: whole sets of lanes, but one for one.
fn places<T>(stages: usize) -> usize {
    if stages == 1 { 1 } else { stages.next_multiple_of(width::<T>()) }
}

/// Whether this number of places is computed in lanes.
#[inline(always)]
fn wide<T>(places: usize) -> bool {
    width::<T>() == LANES && places != 1
}

/// A chunk as an array.
#[inline(always)]
fn lanes<const W: usize, S>(values: &[S]) -> &[S; W] {
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
        let filled = |values: &mut Vec<T>| values.resize(places::<T>(values.len()), T::zero());
        let (mut columns, mut ones) = (Vec::new(), vec![T::one(); matrix.nrows()]);
        for column in matrix.column_iter() {
            columns.extend(column.iter().copied());
            filled(&mut columns);
        }
        filled(&mut ones);
        Self { columns, ones }
    }

    /// w_ij.
    #[inline]
    pub(super) fn get(&self, i: usize, j: usize) -> T {
        self.columns[j * self.ones.len() + i]
    }
}

/// s vectors (or covectors) of N components each, component by component, so that the stages of one component are
/// adjacent and a combination Σ_j a_ij x_j runs along them.
#[derive(Clone, Debug)]
pub(super) struct Stages<T: Real, const N: usize> {
    stages: usize,
    places: usize,
    values: Vec<T>,
}

impl<T: Real, const N: usize> Stages<T, N> {
    pub(super) fn zeros(stages: usize) -> Self {
        let places = places::<T>(stages);
        Self { stages, places, values: vec![T::zero(); N * places] }
    }

    /// Component a of stage i.
    #[inline]
    pub(super) fn get(&self, i: usize, a: usize) -> T {
        self.values[a * self.places + i]
    }

    #[inline]
    pub(super) fn set(&mut self, i: usize, a: usize, value: T) {
        self.values[a * self.places + i] = value;
    }

    #[inline]
    pub(super) fn vector(&self, i: usize) -> SVector<T, N> {
        SVector::from_fn(|a, _| self.get(i, a))
    }

    #[inline]
    pub(super) fn covector(&self, i: usize) -> RowSVector<T, N> {
        RowSVector::from_fn(|_, a| self.get(i, a))
    }

    #[inline]
    pub(super) fn set_vector(&mut self, i: usize, value: &SVector<T, N>) {
        for a in 0..N {
            self.set(i, a, value[a]);
        }
    }

    #[inline]
    pub(super) fn set_covector(&mut self, i: usize, value: &RowSVector<T, N>) {
        for a in 0..N {
            self.set(i, a, value[a]);
        }
    }

    /// self_i ← Σ_j `weights`_ij `x`_j.
    #[inline]
    pub(super) fn combine(&mut self, weights: &Weights<T>, x: &Self) {
        if wide::<T>(self.places) { self.combined::<LANES>(weights, x) } else { self.combined::<1>(weights, x) }
    }

    #[inline(always)]
    fn combined<const W: usize>(&mut self, weights: &Weights<T>, x: &Self) {
        for first in (0..self.places / W).map(|k| k * W) {
            let sums = self.sums::<W>(weights, x, first);
            for a in 0..N {
                self.values[a * self.places + first..][..W].copy_from_slice(&sums[a]);
            }
        }
    }

    /// Σ_j `weights`_ij `x`_j of the stages i from `first` on, component by component.
    #[inline(always)]
    fn sums<const W: usize>(&self, weights: &Weights<T>, x: &Self, first: usize) -> [[T; W]; N] {
        let mut sums = [[T::zero(); W]; N];
        for j in 0..self.stages {
            let weights = lanes::<W, T>(&weights.columns[j * self.places + first..][..W]);
            for a in 0..N {
                let value = x.values[a * self.places + j];
                for lane in 0..W {
                    sums[a][lane] += weights[lane] * value;
                }
            }
        }
        sums
    }

    /// Σ_j `weights`_j self_j.
    #[inline]
    pub(super) fn sum(&self, weights: &[T]) -> SVector<T, N> {
        SVector::from_fn(|a, _| {
            let values = &self.values[a * self.places..a * self.places + self.stages];
            weights.iter().zip(values).fold(T::zero(), |sum, (&w, &value)| sum + w * value)
        })
    }

    /// All zero.
    pub(super) fn clear(&mut self) {
        self.values.fill(T::zero());
    }

    /// self_i ← `factor` Σ_j `weights`_ij `x`_j, + `base` where there is one.
    #[inline]
    pub(super) fn advance(&mut self, weights: &Weights<T>, x: &Self, factor: T, base: Option<&RowSVector<T, N>>) {
        if wide::<T>(self.places) {
            self.advanced::<LANES>(weights, x, factor, base);
        } else {
            self.advanced::<1>(weights, x, factor, base);
        }
    }

    #[inline(always)]
    fn advanced<const W: usize>(&mut self, weights: &Weights<T>, x: &Self, factor: T, base: Option<&RowSVector<T, N>>) {
        for first in (0..self.places / W).map(|k| k * W) {
            let sums = self.sums::<W>(weights, x, first);
            let ones = lanes::<W, T>(&weights.ones[first..][..W]);
            for a in 0..N {
                let values = &mut self.values[a * self.places + first..][..W];
                for lane in 0..W {
                    values[lane] = sums[a][lane] * factor;
                }
                if let Some(base) = base {
                    for lane in 0..W {
                        values[lane] += if W == 1 { base[a] } else { base[a] * ones[lane] };
                    }
                }
            }
        }
    }

    /// self ← f(x, y), of as many stages at once as are adjacent: `wide` of several, `single` of one.
    #[inline]
    pub(super) fn map_lanes(
        &mut self,
        [x, y]: [&Self; 2],
        wide: impl Fn([&[[T; LANES]; N]; 2]) -> [[T; LANES]; N],
        single: impl Fn([&[[T; 1]; N]; 2]) -> [[T; 1]; N],
    ) {
        if self::wide::<T>(self.places) {
            self.mapped(x, y, wide);
        } else {
            self.mapped(x, y, single);
        }
    }

    #[inline(always)]
    fn mapped<const W: usize>(&mut self, x: &Self, y: &Self, f: impl Fn([&[[T; W]; N]; 2]) -> [[T; W]; N]) {
        for first in (0..self.places / W).map(|k| k * W) {
            let at = |v: &Self| -> [[T; W]; N] {
                std::array::from_fn(|a| *lanes::<W, T>(&v.values[a * v.places + first..][..W]))
            };
            let values = f([&at(x), &at(y)]);
            for a in 0..N {
                self.values[a * self.places + first..][..W].copy_from_slice(&values[a]);
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

    /// The largest |self − x|, that of each component times its factor if there are factors, and the largest |self|, of all components; NaN if
    /// there is one.
    #[inline]
    pub(super) fn change(&self, x: &Self, factors: Option<&[T; N]>) -> (T, T) {
        match factors {
            None => self.counted(x, |_, change| change),
            Some(factors) => self.counted(x, |a, change| change * factors[a]),
        }
    }

    #[inline(always)]
    fn counted(&self, x: &Self, count: impl Fn(usize, T) -> T) -> (T, T) {
        if wide::<T>(self.places) { self.changed::<LANES>(x, count) } else { self.changed::<1>(x, count) }
    }

    #[inline(always)]
    fn changed<const W: usize>(&self, x: &Self, count: impl Fn(usize, T) -> T) -> (T, T) {
        let (mut change, mut size) = ([T::zero(); W], [T::zero(); W]);
        let mut sum = [T::zero(); W];
        for (k, (these, those)) in self.values.chunks_exact(W).zip(x.values.chunks_exact(W)).enumerate() {
            let (these, those) = (lanes::<W, T>(these), lanes::<W, T>(those));
            for lane in 0..W {
                let difference = these[lane] - those[lane];
                sum[lane] += difference;
                change[lane] = larger(change[lane], count(k * W / self.places, difference.abs()));
                size[lane] = larger(size[lane], these[lane].abs());
            }
        }
        let largest = |values: [T; W]| values.into_iter().fold(T::zero(), larger);
        // A comparison with NaN is false: a sum has it.
        let finite = sum.iter().all(|v| v.all_finite());
        (if finite { largest(change) } else { sum.iter().fold(T::zero(), |s, &v| s + v) }, largest(size))
    }
}
