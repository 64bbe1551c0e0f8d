//! Laws, verdicts, campaigns and order estimates: generic over the case, without any Lie theory.
//!
//! A [`Law`] is a statement about cases of a type `C`, with a strategy that draws them, a check that answers with a
//! [`Verdict`] (numbers, never a bare yes or no), and planted faults that the check demonstrably catches. A
//! [`Campaign`] runs laws on random cases; [`convergence`] reads the order of a method off its errors; [`evidence`] is what a
//! check measured beyond what its verdict says.

mod campaign;
pub mod convergence;
mod draw;
pub mod evidence;
mod guard;
pub mod ladder;
mod law;
mod shrink;
mod summary;

pub use campaign::{Campaign, Progress, catch_fault, catch_smallest};
pub use draw::{Drawn, Tree, case_seed, draw};
pub(crate) use guard::guarded;
pub use guard::verdict_on;
pub use law::{Cost, Fault, Law, Verdict};
pub use shrink::{Failure, Shrunk, shrink, shrink_from};
pub use summary::{Count, Line, Report, Summary, Worst};

pub use proptest::strategy::BoxedStrategy;
