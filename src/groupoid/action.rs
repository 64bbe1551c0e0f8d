//! The action groupoid g*⋊G of the coadjoint action.

use super::algebroid::LieAlgebroid;
use super::lie::LieGroupoid;
use super::manifold::{DenseSpace, Manifold};
use super::{Arrow, DenseGroup, Groupoid, TrivialGroupoid};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

/// g*⋊G ⇉ g*: the arrows (μ, g, Ad*_g μ) of g*×G×g*, for the right action of G on g*. Its Lie algebroid is g*×g with
/// ρ(u)(μ) = ad*_u μ and ⟦u, u'⟧ = \[u, u'\] + ρ(u)(u') − ρ(u')(u).
#[derive(Clone, Debug)]
pub struct ActionGroupoid<S: Scalar> {
    group: DenseGroup<S::Base>,
    arrows: TrivialGroupoid<DenseSpace, S>,
}

type Element<S> = Arrow<DVector<S>, DMatrix<S>>;

impl<S: Scalar> ActionGroupoid<S> {
    /// g*⋊G.
    pub fn new(group: DenseGroup<S::Base>) -> Self {
        Self { arrows: TrivialGroupoid::poisson(group.clone()), group }
    }

    /// (μ, g, Ad*_g μ), or `None` when g is singular.
    pub fn arrow(&self, mu: &DVector<S>, g: &DMatrix<S>) -> Option<Element<S>> {
        Some(Arrow { source: mu.clone(), group: g.clone(), target: self.group.coadjoint(g, mu)? })
    }
}

impl<S: Scalar> Groupoid for ActionGroupoid<S> {
    type Element = Element<S>;
    type Base = DVector<S>;

    fn source(&self, g: &Self::Element) -> DVector<S> {
        self.arrows.source(g)
    }

    fn target(&self, g: &Self::Element) -> DVector<S> {
        self.arrows.target(g)
    }

    fn unit(&self, x: &DVector<S>) -> Self::Element {
        self.arrows.unit(x)
    }

    fn inverse(&self, g: &Self::Element) -> Option<Self::Element> {
        self.arrows.inverse(g)
    }

    fn product(&self, first: &Self::Element, second: &Self::Element) -> Self::Element {
        self.arrows.product(first, second)
    }
}

impl<S: Scalar> LieAlgebroid<S> for ActionGroupoid<S> {
    fn rank(&self) -> usize {
        self.group.dimension()
    }

    fn anchor(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        let n = x.len();
        DVector::from_fn(n, |b, _| {
            let e = DVector::from_fn(n, |c, _| if b == c { S::one() } else { S::zero() });
            x.dot(&self.group.structure(a, &e))
        })
    }

    fn structure(&self, _: &DVector<S>, a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
        self.group.structure(a, b)
    }
}

impl<S: Scalar> LieGroupoid<S> for ActionGroupoid<S> {
    fn coordinates(&self, g: &Self::Element) -> DVector<S> {
        self.arrows.coordinates(g)
    }

    fn element(&self, z: &DVector<S>) -> Self::Element {
        self.arrows.element(z)
    }

    fn base_coordinates(&self, x: &DVector<S>) -> DVector<S> {
        x.clone()
    }

    fn base_point(&self, z: &DVector<S>) -> DVector<S> {
        z.clone()
    }

    fn base_dimension(&self) -> usize {
        self.group.dimension()
    }

    fn near_point(&self, x: &DVector<S>, v: &DVector<S>) -> DVector<S> {
        x + v
    }

    /// By the action itself; its generator serves where 1 + â is singular, which it is not for small a.
    fn near_unit(&self, x: &DVector<S>, a: &DVector<S>) -> Self::Element {
        let g = self.group.near(&self.group.identity(), a);
        let target = self.group.coadjoint(&g, x).unwrap_or_else(|| x + self.anchor(x, a));
        Arrow { source: x.clone(), group: g, target }
    }

    fn fibre(&self, x: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        let both = self.arrows.fibre(x, tangent)?;
        Some(both.rows(0, self.group.dimension()).into_owned())
    }
}
