//! Stage arrays: s vectors of N components, stage index contiguous.

use crate::scalar::{Real, Scalar};
use nalgebra::{Const, DMatrix, Dyn, OMatrix, RowSVector, SVector};

/// s vectors (or covectors) of N components each: an s×N matrix, column-major, so that the stages of one component are
/// adjacent and a combination Σ_j a_ij x_j runs along them.
#[derive(Clone, Debug)]
pub(super) struct Stages<S: Scalar, const N: usize>(OMatrix<S, Dyn, Const<N>>);

impl<S: Scalar, const N: usize> Stages<S, N> {
    pub(super) fn zeros(stages: usize) -> Self {
        Self(OMatrix::<S, Dyn, Const<N>>::zeros(stages))
    }

    /// Component a of stage i.
    #[inline]
    pub(super) fn get(&self, i: usize, a: usize) -> S {
        self.0[(i, a)]
    }

    #[inline]
    pub(super) fn set(&mut self, i: usize, a: usize, value: S) {
        self.0[(i, a)] = value;
    }

    #[inline]
    pub(super) fn vector(&self, i: usize) -> SVector<S, N> {
        SVector::from_fn(|a, _| self.0[(i, a)])
    }

    #[inline]
    pub(super) fn covector(&self, i: usize) -> RowSVector<S, N> {
        RowSVector::from_fn(|_, a| self.0[(i, a)])
    }

    #[inline]
    pub(super) fn set_vector(&mut self, i: usize, value: &SVector<S, N>) {
        for a in 0..N {
            self.0[(i, a)] = value[a];
        }
    }

    #[inline]
    pub(super) fn set_covector(&mut self, i: usize, value: &RowSVector<S, N>) {
        for a in 0..N {
            self.0[(i, a)] = value[a];
        }
    }

    /// self_i ← Σ_j `matrix`_ij `x`_j.
    #[inline]
    pub(super) fn combine<T: Real>(&mut self, matrix: &DMatrix<T>, x: &Self)
    where
        S: Scalar<Base = T>,
    {
        let s = x.0.nrows();
        for a in 0..N {
            for i in 0..s {
                self.0[(i, a)] = S::zero();
            }
            for j in 0..s {
                let value = x.0[(j, a)];
                for i in 0..s {
                    self.0[(i, a)] += S::lift(matrix[(i, j)]) * value;
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
        SVector::from_fn(|a, _| {
            let mut sum = S::zero();
            for (j, &w) in weights.iter().enumerate() {
                sum += S::lift(w) * self.0[(j, a)];
            }
            sum
        })
    }
}
