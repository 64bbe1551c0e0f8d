//! Laws on a user's own types.
//!
//! [`laws!`](crate::laws!) makes a `#[test]` of each law, [`suite!`](crate::suite!) a [`Suite`] to run in one's own way.
//!
//! | file | holds, beside the parts below |
//! |---|---|
//! | [`part`], [`values`] | what these have in common: parts at two precisions, and their cases |
//! | [`system`] | the laws of whole systems and of one-step methods on one's own types |
//! | [`map`] | a retraction from τ alone |
//! | [`suite`] | running: cases, shrinking, saving, replaying, printing |
//!
//! | part | trait | laws |
//! |---|---|---|
//! | an algebra | [`algebra::Bracket`] | [`algebra`] |
//! | a group | [`LieGroup`](crate::group::LieGroup) | [`group`] |
//! | a Lagrangian | [`Lagrangian`](crate::mechanics::Lagrangian) | [`lagrangian`] |
//! | a force | [`Force`](crate::mechanics::Force) | [`force`] |
//! | a groupoid | [`groupoid::Chains`], [`groupoid::LieChains`] | [`groupoid`] |
//! | a discrete Lagrangian | [`DiscreteLagrangian`](crate::discrete::DiscreteLagrangian) | [`discrete`] |
//!
//! A part is given in `f64` and in 32 digits (`at_both`), where it is generic in the scalar, or in `f64` alone
//! (`in_double`); what it lacks switches laws off ([`part::Subject::missing`]). Cases are [`values::Values`].

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
