#![doc = include_str!("index.md")]
//!
//! The text is in `src/guide/source/`; the files here are written by `properties/guide`, which renders the mathematics.

#[doc = include_str!("getting_started.md")]
pub mod getting_started {}

#[doc = include_str!("integrating.md")]
pub mod integrating {}

#[doc = include_str!("orders.md")]
pub mod orders {}

#[doc = include_str!("your_own_code.md")]
pub mod your_own_code {}

#[doc = include_str!("probing.md")]
pub mod probing {}

#[doc = include_str!("released.md")]
pub mod released {}

#[doc = include_str!("random_systems.md")]
pub mod random_systems {}

#[doc = include_str!("campaigns.md")]
pub mod campaigns {}

#[doc = include_str!("broken_laws.md")]
pub mod broken_laws {}

#[doc = include_str!("theory.md")]
pub mod theory {}

#[doc = include_str!("power.md")]
pub mod power {}

#[doc = include_str!("benchmarks.md")]
pub mod benchmarks {}

#[doc = include_str!("json.md")]
pub mod json {}

#[doc = include_str!("contributing.md")]
pub mod contributing {}
