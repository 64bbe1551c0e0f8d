//! Laws of discrete mechanics: on G×G×G, on G⁴ and on G.
//!
//! | file | judges |
//! |---|---|
//! | [`action`] | the extremal action of a tableau, against its values and against the doubled integrator |
//! | [`equations`] | the equations and flows of any l_d, here of random polynomials |
//! | [`group`] | discrete Euler–Poincaré and Lie–Poisson on G |
//! | [`exact`], [`perturbed`] | the exact l_d^e, and l_d^e with a perturbation of known order |
//! | `judge` | slopes, antisymmetry and units of any l_d: of actions, of polynomials, of a user's |

pub mod action;
pub mod equations;
pub mod exact;
pub mod group;
mod judge;
pub mod perturbed;

pub(super) use judge::{ANTISYMMETRY, SLOPES, UNITS, antisymmetry, largest, slopes, units};

use super::planted::{blend, blend_scalar};
use super::precision::Measured;
use crate::algebra::{Covector, Matrix};
use crate::discrete::{DiscreteError, DiscreteLagrangian, Slopes, Triple};
use crate::harness::Fault;
use crate::scalar::{Real, max_abs};

pub(super) const VALUE: Fault = Fault::new("discrete-value", "the sum of the entries of V added to l_d", "every group");
pub(super) const V_RIGHT: Fault = Fault::new("discrete-v-right", "L*_V D₁l_d for R*_V D₁l_d", "non-abelian groups");
pub(super) const U_RIGHT: Fault =
    Fault::new("discrete-u-right", "L*_U D₂l_d for R*_U D₂l_d", "forced systems on non-abelian groups, off the units");
pub(super) const NO_U: Fault = Fault::new("legendre-no-u", "F⁻ without R*_U D₂l_d", "forced systems");
pub(super) const U_SIGN: Fault = Fault::new("legendre-u-sign", "F⁻ with + L*_U D₂l_d", "forced systems");
pub(super) const DOUBLED: Fault =
    Fault::new("discrete-w-doubled", "D₃l_d doubled", "every group; flows of forced systems");
const CONJUGATE: Fault = Fault::new(
    "discrete-conjugate",
    "the extremal action of the conjugate tableau",
    "tableaux that are not symplectic; forced or non-abelian systems",
);
pub(super) const CONSTANT: Fault =
    Fault::new("discrete-constant", "every slope replaced by 1 in every component", "every group");
pub(super) const STALE: Fault =
    Fault::new("discrete-memory-stale", "the slopes of the evaluation before are given again", "every group");
pub(super) const KEEPS_U: Fault =
    Fault::new("discrete-inverse-keeps-u", "ι̌_d(V, U, W) = (W, U, V)", "every group, U ≠ U⁻¹");

/// A discrete Lagrangian with a fault planted in its value or its slopes.
///
/// U enters F⁻ alone, so a wrong slope by U is a wrong Legendre transform: one without R*_U D₂l_d, or with the other sign
/// of L*_U D₂l_d.
pub(super) struct Planted<'a, L> {
    pub l_d: L,
    pub fault: Option<&'a Fault>,
}

/// What an evaluation leaves behind, with the slopes for [`STALE`].
pub(super) struct Kept<M, T: Real, const N: usize> {
    memory: M,
    slopes: Option<Slopes<T, N>>,
}

impl<M, T: Real, const N: usize> Kept<M, T, N> {
    /// What `memory` leaves behind alone.
    pub fn new(memory: M) -> Self {
        Self { memory, slopes: None }
    }
}

impl<M: Default, T: Real, const N: usize> Default for Kept<M, T, N> {
    fn default() -> Self {
        Self::new(M::default())
    }
}

impl<T: Real, L, const N: usize, const D: usize> DiscreteLagrangian<T, N, D> for Planted<'_, L>
where
    L: DiscreteLagrangian<T, N, D>,
{
    type Memory = Kept<L::Memory, T, N>;

    fn value(&self, x: &Triple<T, D>) -> Result<T, DiscreteError> {
        let right = self.l_d.value(x)?;
        Ok(blend_scalar(right, right + x.v.sum(), VALUE.size_in(self.fault)))
    }

    fn slopes_from(&self, x: &Triple<T, D>, memory: &mut Self::Memory) -> Result<Slopes<T, N>, DiscreteError> {
        let right = self.l_d.slopes_from(x, &mut memory.memory)?;
        let before = memory.slopes.replace(right).unwrap_or(right);
        let no_u = blend(right.u_right, right.u_right * T::zero(), NO_U.size_in(self.fault));
        let constant = |p: Covector<T, N>| blend(p, Covector::repeat(T::one()), CONSTANT.size_in(self.fault));
        let third = |p: Covector<T, N>, stale: Covector<T, N>| {
            constant(blend(blend(p, p * T::int(2), DOUBLED.size_in(self.fault)), stale, STALE.size_in(self.fault)))
        };
        Ok(Slopes {
            v_left: constant(right.v_left),
            v_right: constant(blend(right.v_right, right.v_left, V_RIGHT.size_in(self.fault))),
            u_left: constant(blend(right.u_left, -right.u_left, U_SIGN.size_in(self.fault))),
            u_right: constant(blend(no_u, right.u_left, U_RIGHT.size_in(self.fault))),
            w_left: third(right.w_left, before.w_left),
            w_right: third(right.w_right, before.w_right),
        })
    }
}

/// ι̌_d, or what the fault makes of it.
pub(super) fn inverse<T: Real, const D: usize>(
    x: &Triple<T, D>,
    fault: Option<&Fault>,
) -> Result<Triple<T, D>, Measured> {
    let right = x.inverse().ok_or(Measured::Broken("U is a singular matrix".into()))?;
    Ok(Triple { u: blend(right.u, x.u, KEEPS_U.size_in(fault)), ..right })
}

impl From<DiscreteError> for Measured {
    fn from(error: DiscreteError) -> Self {
        match error {
            DiscreteError::Domain { source, .. } => source.into(),
            DiscreteError::NotConverged { .. } => Self::Inconclusive("the discrete equations did not converge".into()),
            DiscreteError::Singular { .. } => Self::Inconclusive("the discrete Lagrangian is not regular".into()),
            DiscreteError::NotInvertible { .. } | DiscreteError::NotFinite { .. } => Self::Broken(error.to_string()),
        }
    }
}

/// The distance of two triples relative to the sizes of their entries.
fn compare<T: Real, const D: usize>(mine: &Triple<T, D>, expected: &Triple<T, D>, size: T, floor: f64) -> Measured {
    let near = |what: &'static str, a: &Matrix<T, D>, b: &Matrix<T, D>| {
        Measured::defect(max_abs(&(a - b)), size * b.amax().max(T::one()), floor, || format!("{what} differs"))
    };
    near("V", &mine.v, &expected.v).and(near("U", &mine.u, &expected.u)).and(near("W", &mine.w, &expected.w))
}
