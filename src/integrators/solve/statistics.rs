//! What a run with a tolerance takes.

use crate::scalar::Real;

/// What a run took.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Statistics<T> {
    /// Steps taken. They come in pairs of equal size.
    pub steps: usize,
    /// Pairs tried in vain.
    pub rejected: usize,
    /// Fixed-point and Newton iterations of all steps, those of twice the size for the estimates of the error included.
    pub iterations: usize,
    /// The largest relative residual of the stage equations of a step taken.
    pub residual: T,
    /// The sum of the estimated local errors of the momentum, the velocity and the displacement, each relative to the size of its block of coordinates;
    /// and of what residuals and rounding make of them.
    pub error: T,
}

impl<T: Real> Statistics<T> {
    pub(super) fn none() -> Self {
        Self { steps: 0, rejected: 0, iterations: 0, residual: T::zero(), error: T::zero() }
    }
}
