//! The pair groupoid Q×Q ⇉ Q, of a set and of a manifold.

use super::Groupoid;
use super::algebroid::LieAlgebroid;
use super::calculus::join;
use super::lie::LieGroupoid;
use super::manifold::Manifold;
use crate::scalar::Scalar;
use nalgebra::DVector;
use std::fmt::Debug;
use std::marker::PhantomData;

/// Q×Q ⇉ Q: α(q, r) = q, β(q, r) = r, ε(q) = (q, q), ι(q, r) = (r, q), (q, r)(r, s) = (q, s).
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

/// The pair groupoid of a manifold, with Lie algebroid TQ: the anchor is the identity, the bracket that of vector fields.
#[derive(Clone, Copy, Debug)]
pub struct ManifoldPair<M, S> {
    base: M,
    marker: PhantomData<fn() -> S>,
}

impl<M, S> ManifoldPair<M, S> {
    /// Q×Q for the manifold Q.
    pub fn new(base: M) -> Self {
        Self { base, marker: PhantomData }
    }
}

impl<S: Scalar, M: Manifold<S>> Groupoid for ManifoldPair<M, S> {
    type Element = (M::Point, M::Point);
    type Base = M::Point;

    fn source(&self, g: &Self::Element) -> M::Point {
        PairGroupoid::new().source(g)
    }

    fn target(&self, g: &Self::Element) -> M::Point {
        PairGroupoid::new().target(g)
    }

    fn unit(&self, x: &M::Point) -> Self::Element {
        PairGroupoid::new().unit(x)
    }

    fn inverse(&self, g: &Self::Element) -> Option<Self::Element> {
        PairGroupoid::new().inverse(g)
    }

    fn product(&self, first: &Self::Element, second: &Self::Element) -> Self::Element {
        PairGroupoid::new().product(first, second)
    }
}

impl<S: Scalar, M: Manifold<S>> LieAlgebroid<S> for ManifoldPair<M, S> {
    fn rank(&self) -> usize {
        self.base.dimension()
    }

    fn anchor(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        self.base.frame(x, a)
    }

    fn structure(&self, _: &DVector<S>, a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
        self.base.structure(a, b)
    }
}

impl<S: Scalar, M: Manifold<S>> LieGroupoid<S> for ManifoldPair<M, S> {
    fn coordinates(&self, g: &Self::Element) -> DVector<S> {
        join(&[&self.base.coordinates(&g.0), &self.base.coordinates(&g.1)])
    }

    fn element(&self, z: &DVector<S>) -> Self::Element {
        let half = z.len() / 2;
        let point = |from| self.base.point(&z.rows(from, half).into_owned());
        (point(0), point(half))
    }

    fn base_coordinates(&self, x: &M::Point) -> DVector<S> {
        self.base.coordinates(x)
    }

    fn base_point(&self, z: &DVector<S>) -> M::Point {
        self.base.point(z)
    }

    fn base_dimension(&self) -> usize {
        self.base.dimension()
    }

    fn near_point(&self, x: &M::Point, v: &DVector<S>) -> M::Point {
        self.base.near(x, v)
    }

    fn near_unit(&self, x: &M::Point, a: &DVector<S>) -> Self::Element {
        (x.clone(), self.base.near(x, a))
    }

    fn fibre(&self, x: &M::Point, tangent: &DVector<S>) -> Option<DVector<S>> {
        let half = tangent.len() / 2;
        self.base.velocity(&self.base.coordinates(x), &tangent.rows(half, half).into_owned())
    }
}
