//! Where the systems come from that laws judge: the catalogue, or a user's own types.

use crate::scalar::Real;
use crate::study::problem;
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

    /// The same system in another basis of its algebra, with the change of basis by rows; `None` where it has one basis only.
    fn presented(&self) -> Option<(Self, Vec<Vec<f64>>)> {
        None
    }

    /// The k-th other system that the same method is asked on ([`problem::other`]); `None` where there is none.
    fn other(&self, k: i64) -> Option<Self> {
        (1..=problem::VARIATIONS).contains(&k).then(|| self.with_case(problem::varied(self.case(), k)))
    }
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

    fn presented(&self) -> Option<(Self, Vec<Vec<f64>>)> {
        (!self.names_basis()).then(|| Case::presented(self))
    }

    fn other(&self, k: i64) -> Option<Self> {
        problem::other(self, k).ok()
    }
}
