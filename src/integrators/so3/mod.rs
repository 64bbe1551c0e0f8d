//! On SO(3): unit quaternions and ensembles in lanes.
//!
//! The step is that of [`super::lanes`], with [`crate::retraction::CayleySo3`] or [`crate::retraction::ExponentialSo3`] in closed form.
//! [`QuaternionSo3`] has a unit quaternion for g, [`EnsembleSo3`] a body in each lane.

mod ensemble;
mod quaternion;
#[doc(hidden)]
pub mod retraction;

pub use ensemble::{EnsembleSo3, Member};
pub use quaternion::{HalfAngle, QuaternionSo3, QuaternionState};
pub use retraction::LaneRotation;
