//! The forced variational step on SO(3), fast: eight stages, or eight bodies, in the lanes of a register.
//!
//! [`VariationalSo3`] takes the same step as [`super::Variational`] with [`crate::retraction::CayleySo3`] or
//! [`crate::retraction::ExponentialSo3`], to round-off, with all stages of a tableau of up to eight in one register per
//! component. An iteration costs nearly the same for eight stages as for four, so a high order is nearly free.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/integrators/so3.md"))]
//!
//! If this does not contract, [`super::Variational`] takes the step: Newton's method and the continuation in h.
//!
//! [`QuaternionSo3`] is the same step with a unit quaternion for g. The sums g ← g + g(τ(ξ) − 1) and μ ← μ + Δμ are compensated
//! (Kahan 1965), so that rounding grows like √n with n steps.

/// The array of EXPR for k = 0 … N − 1, by a loop: only what is sure to be inlined is compiled for the registers of a
/// kernel, and a closure is not.
macro_rules! each {
    ($n:expr, $k:ident => $e:expr) => {{
        let mut values = [{
            let $k = 0;
            $e
        }; $n];
        for $k in 1..$n {
            values[$k] = $e;
        }
        values
    }};
}
pub(in crate::integrators) use each;

pub(super) mod adaptive;
mod ensemble;
pub mod force;
mod kernel;
mod quaternion;
#[doc(hidden)]
pub mod retraction;
pub(super) mod step;
mod terms;

pub use super::ensemble::EnsembleError;
pub use crate::integrators::solve::SolveError;
pub use adaptive::{AdaptiveSo3, Solved};
pub use ensemble::{EnsembleSo3, Member};
pub use force::{ByLane, Damping, EnsembleForce, Free, Gravity, LaneAttitude, LaneForce, Pose, Relaxation};
pub use quaternion::{HalfAngle, QuaternionSo3, QuaternionState};
pub use retraction::{LaneRetraction, LaneRotation};
#[cfg(feature = "harness")]
pub(crate) use step::VariationalInLanes;
pub use step::{FastRetraction, UnfitTableau, VariationalSo3};
pub use terms::{Drag, LaneForceError, Term, Terms};

/// Three components, each in lanes.
#[doc(hidden)]
pub type Vec3<V> = [V; 3];

/// Eight numbers, aligned for the widest registers.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub struct Row(pub [f64; 8]);

impl Row {
    /// Eight zeros. In kernels, which call no function that another unit of code generation may hold, as `default` is one.
    pub const ZERO: Self = Self([0.0; 8]);
}

/// The most stages that fit.
pub const LANES: usize = 8;
