//! Laws on a user's own types.

pub mod group;
pub mod part;
pub mod values;
