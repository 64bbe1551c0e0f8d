//! Laws on a user's own types.
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
pub mod part;
pub mod values;
