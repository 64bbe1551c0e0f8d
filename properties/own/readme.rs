//! The laws on a force of one's own, as the README shows them.

use euler_poincare::algebra::{Covector, Vector};
use euler_poincare::laws;
use euler_poincare::mechanics::Force;
use euler_poincare::scalar::{Real, Scalar};

/// Drag with the cube of the speed: f = −|η|² η.
#[derive(Clone, Copy)]
struct CubicDrag;

impl<T: Real> Force<T, 3> for CubicDrag {
    fn force<S: Scalar<Base = T>>(&self, _time: S, eta: &Vector<S, 3>) -> Covector<S, 3> {
        -eta.transpose() * eta.dot(eta)
    }
}

laws! {
    mod cubic_drag<T, 3> { force: CubicDrag, claims: [dissipates] }
}
