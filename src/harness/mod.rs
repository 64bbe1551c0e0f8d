//! Laws, verdicts, campaigns and order estimates: generic over the case, without any Lie theory.
//!
//! A [`Law`] is a statement about cases of a type `C`, with a strategy that draws them, a check that answers with a
//! [`Verdict`] (numbers, never a bare yes or no), and planted faults that the check demonstrably catches.

mod law;

pub use law::{Cost, Fault, Law, Verdict};

pub use proptest::strategy::BoxedStrategy;
