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
pub mod suite;
pub mod system;
mod tests;
pub mod values;

pub use map::{FromMap, Map};
pub use suite::{Broken, Outcome, Settings, Site, Suite};
pub use system::{Own, Parts, Types};
