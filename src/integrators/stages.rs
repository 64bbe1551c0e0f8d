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
        let (s, weights) = (self.stages, matrix.as_slice());
        for a in 0..N {
            let (sums, values) = (&mut self.values[a * s..(a + 1) * s], &x.values[a * s..(a + 1) * s]);
            sums.fill(S::zero());
            for (j, value) in values.iter().enumerate() {
                for (sum, weight) in sums.iter_mut().zip(&weights[j * s..(j + 1) * s]) {
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
        let s = self.stages;
        SVector::from_fn(|a, _| {
            let values = &self.values[a * s..(a + 1) * s];
            weights.iter().zip(values).fold(S::zero(), |sum, (weight, value)| sum + S::lift(*weight) * *value)
        })
    }
}
