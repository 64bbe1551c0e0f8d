//! What derivatives by parameters ask of a Lagrangian and a force.

use crate::algebra::{Covector, Vector};
use crate::mechanics::configuration::Configuration;
use crate::scalar::Real;

/// Parameters p_1 … p_K of the Lagrangian and the force, by their partial derivatives. `()` has none.
///
/// They are those of the [`Variational`](super::Variational) method at its present parameters; [`Dual`](crate::scalar::Dual) numbers
/// give them where the formula is long. What is NaN or infinite is refused.
#[diagnostic::on_unimplemented(
    message = "`{Self}` does not say how the system depends on its parameters",
    note = "implement `Parameters<T, {N}>`, or pass `()` for none"
)]
pub trait Parameters<T: Real, const N: usize> {
    /// K.
    fn count(&self) -> usize;

    /// ∂(f + ∂_gL)/∂p_k at (t, g, η), k from 0; g is the identity where there is no group.
    fn force(&self, k: usize, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Covector<T, N>;

    /// ∂(∂L/∂η)/∂p_k at (t, g, η): 0 unless the Lagrangian says otherwise.
    fn momentum(&self, _k: usize, _t: T, _g: Configuration<'_, T>, _eta: &Vector<T, N>) -> Covector<T, N> {
        Covector::zeros()
    }
}

impl<T: Real, const N: usize> Parameters<T, N> for () {
    fn count(&self) -> usize {
        0
    }

    fn force(&self, _k: usize, _t: T, _g: Configuration<'_, T>, _eta: &Vector<T, N>) -> Covector<T, N> {
        Covector::zeros()
    }
}
