//! Where the systems come from that laws judge: the catalogue, or a user's own types.

use crate::scalar::Real;
use crate::system::{Case, CaseError, Visitor, Wrap};
use std::fmt::Debug;

/// A description of a system, and the way from it to types.
///
/// A [`Case`] is one, by [`Case::dispatch`]; [`user::GivenSystem`](super::user::GivenSystem) is one, where the description
/// fills in what the user's types leave open. The `Debug` text determines the numbers that a law draws beyond the case
/// (`Probe` of `src/laws/probe.rs`).
pub trait Source: Clone + Debug + Send + Sync + 'static {
    /// The description: tableau, state, step, and all else that is not fixed by types.
    fn case(&self) -> &Case;

    /// The same source with another description.
    fn with_case(&self, case: Case) -> Self;

    /// Builds the system over `T`, with its retraction wrapped, and hands it to `visitor`.
    ///
    /// # Errors
    /// A [`CaseError`] that says which part cannot be built.
    fn visit<T: Real, V: Visitor<T>>(&self, wrap: &impl Wrap, visitor: V) -> Result<V::Output, CaseError>;
}

impl Source for Case {
    fn case(&self) -> &Case {
        self
    }

    fn with_case(&self, case: Case) -> Self {
        case
    }

    fn visit<T: Real, V: Visitor<T>>(&self, wrap: &impl Wrap, visitor: V) -> Result<V::Output, CaseError> {
        self.dispatch_with(wrap, visitor)
    }
}
