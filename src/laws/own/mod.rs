//! Laws on a user's own types.

pub mod algebra;
mod differences;
pub mod discrete;
pub mod force;
pub mod group;
pub mod groupoid;
pub mod lagrangian;
pub mod map;
pub mod part;
pub mod system;
pub mod values;

pub use map::{FromMap, Map};
pub use system::{Own, Parts, Types};
