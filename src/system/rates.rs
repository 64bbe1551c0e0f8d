//! How fast a case moves, relative to its step.

use super::case::{Case, Tau};
use super::dispatch::{System, Visitor};
use crate::algebra::{LieAlgebra, Vector};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;

/// The largest unrest of generated cases: well below where stage equations fold (about 1) and τ leaves its domain.
pub(super) const MOST: f64 = 0.5;

/// h (‖ad_η‖ + h ‖ad_η̇‖ + ‖∂η̇/∂η‖) at the initial state, with row-sum norms: the larger of 1/h's competitors.
///
/// `None` when the case cannot be built.
pub(super) fn unrest(case: &Case) -> Option<f64> {
    let cayley = case.method.retraction == Tau::Cayley;
    case.dispatch::<f64, _>(Unrest { cayley }).ok()?
}

struct Unrest {
    cayley: bool,
}

fn norm<const N: usize>(matrix: &crate::algebra::Matrix<f64, N>) -> f64 {
    (0..N).map(|row| (0..N).map(|c| matrix[(row, c)].abs()).sum()).fold(0.0, f64::max)
}

impl Visitor<f64> for Unrest {
    type Output = Option<f64>;

    fn visit<const N: usize, const D: usize, R: Retraction<f64, N, D>>(
        self,
        system: System<f64, N, D, R>,
    ) -> Option<f64> {
        let algebra: &LieAlgebra<f64, N> = &system.algebra;
        let h = system.step.abs();
        let eta = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros()).ok()?;
        let inverse = system.lagrangian.hessian(&eta).try_inverse()?;
        let rate = |eta: &Vector<f64, N>| {
            let mu = system.lagrangian.gradient(eta);
            let rate = algebra.coad(eta, &mu) + system.force.force(system.state.time, eta);
            inverse * rate.transpose()
        };
        let mut slope = crate::algebra::Matrix::<f64, N>::zeros();
        for a in 0..N {
            let mut moved = Vector::zeros();
            moved[a] = 1.0 / 1024.0;
            slope.set_column(a, &((rate(&(eta + moved)) - rate(&(eta - moved))) * 512.0));
        }
        let rotation = norm(&algebra.ad(&eta)) + h * norm(&algebra.ad(&rate(&eta)));
        // The Cayley map works on matrices: 1 − x/2 must stay away from singular.
        let matrix = match (self.cayley, &system.group) {
            (true, Some(group)) => {
                use crate::group::LieGroup;
                group.hat::<f64>(&eta).amax() * 0.5
            }
            _ => 0.0,
        };
        let unrest = h * (rotation.max(matrix) + norm(&slope));
        unrest.is_finite().then_some(unrest)
    }
}
