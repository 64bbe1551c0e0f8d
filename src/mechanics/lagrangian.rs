//! Reduced Lagrangians: the quadratic one of a rigid body and its relatives, and Newton's inversion of l' for the rest.

use super::{Lagrangian, LegendreError};
use crate::algebra::{Covector, Vector};
use crate::scalar::{Real, Scalar};

/// Newton's iteration for l'(η) = μ, from `guess`.
pub(super) fn newton_velocity<T: Real, S: Scalar<Base = T>, const N: usize>(
    _lagrangian: &(impl Lagrangian<T, N> + ?Sized),
    _mu: &Covector<S, N>,
    _guess: &Vector<S, N>,
) -> Result<Vector<S, N>, LegendreError> {
    unimplemented!()
}
