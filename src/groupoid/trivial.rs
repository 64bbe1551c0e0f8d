//! The trivial groupoid B×G×B ⇉ B: of it are a Lie group (B a point), G×G×G (B = G) and g*×G×g* (B = g*).

use super::Groupoid;
use crate::algebra::{Covector, Matrix};
use crate::group::LieGroup;
use crate::scalar::Scalar;
use std::fmt::Debug;
use std::marker::PhantomData;

/// (x, U, y), an arrow from x to y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Arrow<B, U> {
    /// x = α: V in G×G×G, λ in g*×G×g*.
    pub source: B,
    /// U, in G.
    pub group: U,
    /// y = β: W in G×G×G, μ in g*×G×g*.
    pub target: B,
}

/// B×G×B ⇉ B: α(x, U, y) = x, β(x, U, y) = y, ε(x) = (x, e, x), ι(x, U, y) = (y, U⁻¹, x), (x, U, y)(y, V, z) = (x, UV, z).
#[derive(Debug)]
pub struct TrivialGroupoid<'a, G, B, S, const N: usize, const D: usize> {
    group: &'a G,
    marker: PhantomData<fn() -> (B, S)>,
}

/// A Lie group over a point.
pub type PointGroupoid<'a, G, S, const N: usize, const D: usize> = TrivialGroupoid<'a, G, (), S, N, D>;

/// G×G×G ⇉ G, elements (V, U, W): the quotient of the pair groupoid of G×G by the diagonal action of G.
pub type GaugeGroupoid<'a, G, S, const N: usize, const D: usize> = TrivialGroupoid<'a, G, Matrix<S, D>, S, N, D>;

/// Γ = g*×G×g* ⇉ g*, elements (λ, U, μ); its bracket is [`poisson_bivector`](super::poisson_bivector).
///
/// The published ι (Martín de Diego and Sato Martín de Almagro 2019, (4.4)) lacks the inverse on U.
pub type PoissonGroupoid<'a, G, S, const N: usize, const D: usize> = TrivialGroupoid<'a, G, Covector<S, N>, S, N, D>;

impl<'a, G, B, S, const N: usize, const D: usize> TrivialGroupoid<'a, G, B, S, N, D> {
    /// B×G×B for the group G.
    pub fn new(group: &'a G) -> Self {
        Self { group, marker: PhantomData }
    }
}

impl<G, B, S, const N: usize, const D: usize> Groupoid for TrivialGroupoid<'_, G, B, S, N, D>
where
    S: Scalar,
    G: LieGroup<S::Base, N, D>,
    B: Clone + Debug + PartialEq,
{
    type Element = Arrow<B, Matrix<S, D>>;
    type Base = B;

    fn source(&self, g: &Self::Element) -> B {
        g.source.clone()
    }

    fn target(&self, g: &Self::Element) -> B {
        g.target.clone()
    }

    fn unit(&self, x: &B) -> Self::Element {
        Arrow { source: x.clone(), group: self.group.identity(), target: x.clone() }
    }

    fn inverse(&self, g: &Self::Element) -> Option<Self::Element> {
        Some(Arrow { source: g.target.clone(), group: self.group.inverse(&g.group)?, target: g.source.clone() })
    }

    fn product(&self, first: &Self::Element, second: &Self::Element) -> Self::Element {
        let group = self.group.compose(&first.group, &second.group);
        Arrow { source: first.source.clone(), group, target: second.target.clone() }
    }
}
