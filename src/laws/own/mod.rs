//! Laws on a user's own types.
//!
//! [`laws!`](crate::laws!) makes a `#[test]` of each law, [`suite!`](crate::suite!) a [`Suite`] to run in one's own way.
//!
//! | file | holds |
//! |---|---|
//! | [`group`], [`algebra`], [`lagrangian`], [`force`], [`groupoid`], [`discrete`] | the laws of one part |
//! | [`part`], [`values`] | what these have in common: parts at two precisions, and their cases |
//! | [`system`] | the laws of whole systems and of one-step methods on one's own types |
//! | [`map`] | a retraction from τ alone |
//! | [`suite`] | running: cases, shrinking, saving, replaying, printing |

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
