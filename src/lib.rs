//! Forced variational integrators on Lie groups, and the harness that verifies them.

pub mod algebra;
#[cfg(feature = "harness")]
pub mod experiments;
pub mod group;
pub mod groupoid;
#[cfg(feature = "harness")]
pub mod harness;
pub mod integrators;
#[cfg(feature = "harness")]
pub mod laws;
pub mod mechanics;
pub mod newton;
pub mod retraction;
pub mod scalar;
#[cfg(feature = "harness")]
pub mod system;
pub mod tableau;
