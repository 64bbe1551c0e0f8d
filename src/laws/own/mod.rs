//! Laws on a user's own types.

pub mod map;
pub mod system;

pub use map::{FromMap, Map};
pub use system::{Own, Parts, Types};
