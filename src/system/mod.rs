//! The case: one plain value that describes algebra, inertia, force, tableau, retraction, state and step.
//!
//! The same value is generated ([`random`]), shrunk, printed, saved ([`replay`]) and read from a file ([`mod@file`]); it
//! becomes typed in one place ([`dispatch`]).

mod algebras;
mod arbitrary;
pub mod case;
mod compiled;
pub mod dispatch;
mod document;
pub mod ensemble;
pub mod error;
mod event;
pub mod file;
mod fixed;
pub(crate) mod force;
mod generate;
pub(crate) mod given;
mod labels;
mod named;
pub mod note;
mod numbers;
pub(crate) mod parameters;
mod potential;
mod presentation;
pub mod random;
pub(crate) mod rates;
mod reading;
pub mod replay;
pub(crate) mod restriction;
pub(crate) mod scope;
pub mod shares;
mod shrink;
mod simpler;
pub mod solution;
mod strategy;
pub mod tolerance;
pub mod trajectory;

pub use case::{Case, Force as ForceTerm, Motion};
pub use compiled::Compiled;
#[doc(hidden)]
pub use dispatch::Wrap;
pub use dispatch::{System, Visitor};
pub use document::ScalarName;
pub use error::{CaseError, CaseProblem, Place};
pub use file::{FileError, SystemFile};
pub(crate) use generate::Draw;
pub use named::{algebra_text, named_algebras};
pub use random::{Cases, cases, labels};
pub use reading::Reading;
pub use replay::Replay;
