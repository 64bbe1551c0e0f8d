//! Laws, verdicts, campaigns and order estimates: generic over the case, without any Lie theory.
//!
//! A [`Law`] is a statement about cases of a type `C`, with a strategy that draws them, a check that answers with a
//! [`Verdict`] (numbers, never a bare yes or no), and planted faults that the check demonstrably catches. A
//! [`Campaign`] runs laws on random cases, in one piece or in shards, and a [`store`] keeps each verdict as it comes as a
//! [`Record`]; [`convergence`] reads the order of a method off its errors, [`lower`] how much of them is of lower order than
//! claimed; [`evidence`] is what a
//! check measured beyond what its verdict says.

mod campaign;
pub mod convergence;
mod draw;
pub mod evidence;
mod guard;
mod law;
pub mod lower;
mod parallel;
mod plan;
mod record;
mod shrink;
pub mod store;
mod summary;

pub use campaign::{Campaign, Halt, Progress, Recorded, Sink, catch_fault, catch_smallest, first_caught};
pub use draw::{Drawn, Tree, case_seed, draw};
pub(crate) use draw::{hash, split_mix};
pub(crate) use guard::guarded;
pub use guard::verdict_on;
pub use law::{About, Cost, Fault, Law, Verdict};
#[doc(hidden)]
pub use parallel::parallel;
pub use plan::{Done, NoShard, Shard};
pub use record::Record;
pub(crate) use record::pairs;
pub(crate) use shrink::descend;
pub use shrink::{Failure, Shrunk, shrink, shrink_from};
pub use summary::{CampaignReport, Count, Ending, Line, Summary, Worst};

pub use proptest::strategy::BoxedStrategy;
