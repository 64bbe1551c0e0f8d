//! Faults, planted in what several files of laws judge.
//!
//! What a fault is stands in its text. One of size ε makes the subject's value right + ε (wrong − right). A retraction is
//! faulty before the case's system is built ([`PlantedRetraction`]), so that every law sees it; the variational step by
//! [`PlantedStep`].

pub mod doubled;
pub mod groupoid;
pub mod retraction;
pub mod step;
pub mod tableau;

pub use retraction::PlantedRetraction;
pub use step::PlantedStep;

use crate::scalar::Scalar;
use nalgebra::SMatrix;

/// right + ε (wrong − right), the value of a subject with a fault of size ε planted in it; exactly `wrong` at ε = 1 and
/// exactly `right` at ε = 0.
pub fn blend<S: Scalar, const R: usize, const C: usize>(
    right: SMatrix<S, R, C>,
    wrong: SMatrix<S, R, C>,
    size: f64,
) -> SMatrix<S, R, C> {
    right.zip_map(&wrong, |right, wrong| blend_scalar(right, wrong, size))
}

/// The same for one number.
pub fn blend_scalar<S: Scalar>(right: S, wrong: S, size: f64) -> S {
    match size {
        0.0 => right,
        1.0 => wrong,
        _ => right + (wrong - right) * S::exact(size),
    }
}
