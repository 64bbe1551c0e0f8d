//! Vectors of dual numbers.

use crate::scalar::{Dual, Scalar};
use nalgebra::DVector;

/// z, as constants.
pub fn constant<S: Scalar>(z: &DVector<S>) -> DVector<Dual<S>> {
    z.map(Dual::constant)
}

/// z + ε v.
pub fn along<S: Scalar>(z: &DVector<S>, v: &DVector<S>) -> DVector<Dual<S>> {
    z.zip_map(v, |re, eps| Dual { re, eps })
}

/// ε v.
pub fn infinitesimal<S: Scalar>(v: &DVector<S>) -> DVector<Dual<S>> {
    v.map(|eps| Dual { re: S::zero(), eps })
}

/// The values.
pub fn values<S: Scalar>(z: &DVector<Dual<S>>) -> DVector<S> {
    z.map(|v| v.re)
}

/// The derivatives.
pub fn derivatives<S: Scalar>(z: &DVector<Dual<S>>) -> DVector<S> {
    z.map(|v| v.eps)
}

/// The vectors one below the other.
pub(super) fn join<S: Scalar>(parts: &[&DVector<S>]) -> DVector<S> {
    DVector::from_vec(parts.iter().flat_map(|part| part.iter().copied()).collect())
}
