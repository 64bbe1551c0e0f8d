#![doc = include_str!(concat!(env!("GUIDE"), "/index.md"))]
//!
//! The text is in `src/guide/source/`. `properties/guide` writes the pages with rendered mathematics into `src/guide/rendered/`, which are
//! taken where they are there.

#[doc = include_str!(concat!(env!("GUIDE"), "/getting_started.md"))]
pub mod getting_started {}

#[doc = include_str!(concat!(env!("GUIDE"), "/integrating.md"))]
pub mod integrating {}

#[doc = include_str!(concat!(env!("GUIDE"), "/orders.md"))]
pub mod orders {}

#[doc = include_str!(concat!(env!("GUIDE"), "/your_own_code.md"))]
pub mod your_own_code {}

#[doc = include_str!(concat!(env!("GUIDE"), "/probing.md"))]
pub mod probing {}

#[doc = include_str!(concat!(env!("GUIDE"), "/released.md"))]
pub mod released {}

#[doc = include_str!(concat!(env!("GUIDE"), "/random_systems.md"))]
pub mod random_systems {}

#[doc = include_str!(concat!(env!("GUIDE"), "/campaigns.md"))]
pub mod campaigns {}

#[doc = include_str!(concat!(env!("GUIDE"), "/broken_laws.md"))]
pub mod broken_laws {}

#[doc = include_str!(concat!(env!("GUIDE"), "/theory.md"))]
pub mod theory {}

#[doc = include_str!(concat!(env!("GUIDE"), "/power.md"))]
pub mod power {}

#[doc = include_str!(concat!(env!("GUIDE"), "/benchmarks.md"))]
pub mod benchmarks {}

#[doc = include_str!(concat!(env!("GUIDE"), "/json.md"))]
pub mod json {}

#[doc = include_str!(concat!(env!("GUIDE"), "/contributing.md"))]
pub mod contributing {}
