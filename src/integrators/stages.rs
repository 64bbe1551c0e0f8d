//! Stage arrays: s vectors of N components, stage index contiguous.

use crate::scalar::{Real, Scalar};
use nalgebra::{DMatrix, RowSVector, SVector};

/// s vectors (or covectors) of N components each. The stages of one component are adjacent, so that a combination
/// Σ_j a_ij x_j runs along them.
#[derive(Clone, Debug)]
pub(super) struct Stages<S, const N: usize> {
    stages: usize,
    /// Component a of stage i at a s + i.
    values: Vec<S>,
}

impl<S: Scalar, const N: usize> Stages<S, N> {
    pub(super) fn zeros(stages: usize) -> Self {
        Self { stages, values: vec![S::zero(); stages * N] }
    }

    /// Component a of stage i.
    #[inline]
    pub(super) fn get(&self, i: usize, a: usize) -> S {
        self.values[a * self.stages + i]
    }

    #[inline]
    pub(super) fn set(&mut self, i: usize, a: usize, value: S) {
        self.values[a * self.stages + i] = value;
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

    /// self_i ← Σ_j `matrix`_ij `x`_j.
    #[inline]
    pub(super) fn combine<T: Real>(&mut self, matrix: &DMatrix<T>, x: &Self)
    where
        S: Scalar<Base = T>,
    {
        let s = self.stages;
        for (sums, values) in self.values.chunks_exact_mut(s).zip(x.values.chunks_exact(s)) {
            sums.fill(S::zero());
            for (column, value) in matrix.as_slice().chunks_exact(s).zip(values) {
                for (sum, weight) in sums.iter_mut().zip(column) {
                    *sum += S::lift(*weight) * *value;
                }
            }
        }
    }

    /// Σ_j `weights`_j self_j.
    #[inline]
    pub(super) fn sum<T: Real>(&self, weights: &[T]) -> SVector<S, N>
    where
        S: Scalar<Base = T>,
    {
        let mut total = SVector::<S, N>::zeros();
        for (sum, values) in total.iter_mut().zip(self.values.chunks_exact(self.stages)) {
            for (weight, value) in weights.iter().zip(values) {
                *sum += S::lift(*weight) * *value;
            }
        }
        total
    }
}
