//! Laws on a user's own types. Those of algebras, groups, Lagrangians and forces `verify` runs too, on the parts of its random
//! systems.
//!
//! [`laws!`](crate::laws!) makes a `#[test]` of each law, [`suite!`](crate::suite!) a [`Suite`] to run in one's own way.
//!
//! | file | holds, beside the parts below |
//! |---|---|
//! | `macros` | `laws!` and `suite!`, where a user's types enter |
//! | `system` | a user's types, as the macros make them; cases with these types for their parts |
//! | `part` | one part of a system, its laws (rows of `part_laws!`: test, numbers of a case, statement) and its cases |
//! | [`values`] | the cases of a part: named vectors of exact numbers |
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
//! (`in_double`); what it lacks switches laws off. Cases are [`values::Values`].

pub mod algebra;
pub mod discrete;
pub mod force;
pub mod group;
pub mod groupoid;
pub mod lagrangian;
mod macros;
pub mod map;
#[doc(hidden)]
pub mod part;
pub mod suite;
#[doc(hidden)]
pub mod system;
pub mod values;

pub use map::{FromMap, Map};
#[doc(hidden)]
pub use suite::Site;
pub use suite::{Broken, Outcome, Suite, SuiteSettings};
#[doc(hidden)]
pub use system::{GivenSystem, Own};
