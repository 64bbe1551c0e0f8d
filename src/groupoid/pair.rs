//! The pair groupoid Q×Q ⇉ Q of a set.

use super::Groupoid;
use std::fmt::Debug;
use std::marker::PhantomData;

/// Q×Q ⇉ Q: α(q, r) = q, β(q, r) = r, ε(q) = (q, q), ι(q, r) = (r, q), (q, r)(r, s) = (q, s).
///
/// That of a manifold, as a Lie groupoid, is [`TrivialGroupoid::pairs`](super::TrivialGroupoid::pairs).
#[derive(Clone, Copy, Debug, Default)]
pub struct PairGroupoid<Q>(PhantomData<fn() -> Q>);

impl<Q> PairGroupoid<Q> {
    /// The pair groupoid of Q.
    pub fn new() -> Self {
        Self(PhantomData)
    }
}

impl<Q: Clone + Debug + PartialEq> Groupoid for PairGroupoid<Q> {
    type Element = (Q, Q);
    type Base = Q;

    fn source(&self, g: &(Q, Q)) -> Q {
        g.0.clone()
    }

    fn target(&self, g: &(Q, Q)) -> Q {
        g.1.clone()
    }

    fn unit(&self, x: &Q) -> (Q, Q) {
        (x.clone(), x.clone())
    }

    fn inverse(&self, g: &(Q, Q)) -> Option<(Q, Q)> {
        Some((g.1.clone(), g.0.clone()))
    }

    fn product(&self, first: &(Q, Q), second: &(Q, Q)) -> (Q, Q) {
        (first.0.clone(), second.1.clone())
    }
}
