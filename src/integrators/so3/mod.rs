//! The forced variational step on SO(3), fast: eight stages, or eight bodies, in the lanes of a register.
//!
//! [`VariationalSo3`] takes the same step as [`super::Variational`] with [`crate::retraction::CayleySo3`] or
//! [`crate::retraction::ExponentialSo3`], to round-off, with all stages of a tableau of up to eight in one register per
//! component. An iteration costs nearly the same for eight stages as for four, so a high order is nearly free.
//!

//!
//! If this does not contract, [`super::Variational`] takes the step: Newton's method and the continuation in h.
//!
//! [`QuaternionSo3`] is the same step with a unit quaternion for g. The sums g ← g + g(τ(ξ) − 1) and μ ← μ + Δμ are compensated
//! (Kahan 1965), so that rounding grows like √n with n steps.

mod adaptive;
mod ensemble;
mod quaternion;
#[doc(hidden)]
pub mod retraction;

pub use adaptive::AdaptiveSo3;
pub use ensemble::{EnsembleSo3, Member};
pub use quaternion::{HalfAngle, QuaternionSo3, QuaternionState};
pub use retraction::LaneRotation;

use super::lanes::VariationalInLanes;

/// The forced variational step on SO(3) with all stages in the lanes of a register.
pub type VariationalSo3<F, R> = VariationalInLanes<F, R, 3, 3>;
