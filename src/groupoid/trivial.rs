//! The trivial groupoid B×G×B ⇉ B: of it are the pairs of a manifold (G = {e}), a Lie group (B a point), G×G×G (B = G) and
//! g*×G×g* (B = g*).

use super::algebroid::LieAlgebroid;
use super::calculus::join;
use super::lie::LieGroupoid;
use super::manifold::{DenseSpace, Manifold};
use super::{DenseGroup, Groupoid};
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};

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
///
/// Its Lie algebroid is B×g ⊕ TB: sections (u, v) with u(x) in g and v a vector field, ρ(u, v) = v and
/// ⟦(u, v), (u', v')⟧ = (\[u, u'\] + v(u') − v'(u), \[v, v'\]).
#[derive(Clone, Debug)]
pub struct TrivialGroupoid<B, S: Scalar> {
    base: B,
    group: DenseGroup<S::Base>,
}

impl<B, S: Scalar> TrivialGroupoid<B, S> {
    /// B×G×B.
    pub fn over(base: B, group: DenseGroup<S::Base>) -> Self {
        Self { base, group }
    }

    /// Q×Q for the manifold Q, with Lie algebroid TQ: the anchor is the identity, the bracket that of vector fields.
    pub fn pairs(base: B) -> Self {
        Self::over(base, DenseGroup::trivial())
    }
}

impl<S: Scalar> TrivialGroupoid<DenseSpace, S> {
    /// G over a point.
    pub fn point(group: DenseGroup<S::Base>) -> Self {
        Self::over(DenseSpace { dimension: 0 }, group)
    }

    /// Γ = g*×G×g* ⇉ g*, elements (λ, U, μ); its bracket is [`poisson_bivector`](super::poisson_bivector).
    ///
    /// The published ι (Martín de Diego and Sato Martín de Almagro 2019, (4.4)) lacks the inverse on U.
    pub fn poisson(group: DenseGroup<S::Base>) -> Self {
        Self::over(DenseSpace { dimension: group.dimension() }, group)
    }
}

impl<S: Scalar> TrivialGroupoid<DenseGroup<S::Base>, S> {
    /// G×G×G ⇉ G, elements (V, U, W): the quotient of the pair groupoid of G×G by the diagonal action of G.
    pub fn gauge(group: DenseGroup<S::Base>) -> Self {
        Self::over(group.clone(), group)
    }
}

impl<S: Scalar, B: Manifold<S>> Groupoid for TrivialGroupoid<B, S> {
    type Element = Arrow<B::Point, DMatrix<S>>;
    type Base = B::Point;

    fn source(&self, g: &Self::Element) -> B::Point {
        g.source.clone()
    }

    fn target(&self, g: &Self::Element) -> B::Point {
        g.target.clone()
    }

    fn unit(&self, x: &B::Point) -> Self::Element {
        Arrow { source: x.clone(), group: self.group.identity(), target: x.clone() }
    }

    fn inverse(&self, g: &Self::Element) -> Option<Self::Element> {
        Some(Arrow { source: g.target.clone(), group: self.group.inverse(&g.group)?, target: g.source.clone() })
    }

    fn product(&self, first: &Self::Element, second: &Self::Element) -> Self::Element {
        Arrow { source: first.source.clone(), group: &first.group * &second.group, target: second.target.clone() }
    }
}

/// The first n numbers and the others.
fn split<S: Scalar>(a: &DVector<S>, n: usize) -> (DVector<S>, DVector<S>) {
    (a.rows(0, n).into_owned(), a.rows(n, a.len() - n).into_owned())
}

impl<S: Scalar, B: Manifold<S>> LieAlgebroid<S> for TrivialGroupoid<B, S> {
    fn rank(&self) -> usize {
        self.group.dimension() + self.base.dimension()
    }

    fn anchor(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        self.base.frame(x, &split(a, self.group.dimension()).1)
    }

    fn structure(&self, _: &DVector<S>, a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
        let n = self.group.dimension();
        let ((u, v), (u1, v1)) = (split(a, n), split(b, n));
        join(&[&self.group.structure(&u, &u1), &self.base.structure(&v, &v1)])
    }
}

impl<S: Scalar, B: Manifold<S>> LieGroupoid<S> for TrivialGroupoid<B, S> {
    fn coordinates(&self, g: &Self::Element) -> DVector<S> {
        let ends = (self.base.coordinates(&g.source), self.base.coordinates(&g.target));
        join(&[&ends.0, &self.group.coordinates(&g.group), &ends.1])
    }

    fn element(&self, z: &DVector<S>) -> Self::Element {
        let (middle, end) = (Manifold::<S>::size(&self.group), self.base.size());
        let part = |from, length| z.rows(from, length).into_owned();
        Arrow {
            source: self.base.point(&part(0, end)),
            group: self.group.point(&part(end, middle)),
            target: self.base.point(&part(end + middle, end)),
        }
    }

    fn base_coordinates(&self, x: &B::Point) -> DVector<S> {
        self.base.coordinates(x)
    }

    fn base_point(&self, z: &DVector<S>) -> B::Point {
        self.base.point(z)
    }

    fn base_dimension(&self) -> usize {
        self.base.dimension()
    }

    fn near_point(&self, x: &B::Point, v: &DVector<S>) -> B::Point {
        self.base.near(x, v)
    }

    fn near_unit(&self, x: &B::Point, a: &DVector<S>) -> Self::Element {
        let (u, v) = split(a, self.group.dimension());
        Arrow { source: x.clone(), group: self.group.near(&self.group.identity(), &u), target: self.base.near(x, &v) }
    }

    fn fibre(&self, x: &B::Point, tangent: &DVector<S>) -> Option<DVector<S>> {
        let (unit, end) = (self.group.coordinates(&self.group.identity()), self.base.coordinates(x));
        let moved = tangent.rows(end.len(), unit.len()).into_owned();
        let u = self.group.velocity(&unit, &moved)?;
        let v = self.base.velocity(&end, &tangent.rows(end.len() + unit.len(), end.len()).into_owned())?;
        Some(join(&[&u, &v]))
    }
}
