//! The engine in lanes: the forced variational step on a matrix group, with all stages of a tableau in the lanes of a register.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/integrators/lanes.md"))]

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

pub mod force;
mod group;
pub(in crate::integrators) mod kernel;
mod matrices;
mod registers;
pub(in crate::integrators) mod step;
mod terms;
pub(in crate::integrators) mod vectors;

pub use force::{ByLane, Damping, EnsembleForce, Free, Gravity, LaneAttitude, LaneForce, Pose, Relaxation};
pub use group::{FastRetraction, LaneGroup};
pub use matrices::MatricesInLanes;
pub(in crate::integrators) use registers::One;
pub use registers::{Eight, Formula, Isa, Kernel, Lanes, Pair, Plain, Registers};
pub use step::{UnfitTableau, VariationalInLanes};
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
