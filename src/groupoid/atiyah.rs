//! The Atiyah (gauge) groupoid (P×P)/K ⇉ P/K of a principal bundle.

use super::Groupoid;
use super::algebroid::LieAlgebroid;
use super::calculus::join;
use super::lie::LieGroupoid;
use super::manifold::{Group, Manifold, Sphere, cross};
use crate::algebra::{Matrix, Vector};
use crate::group::so3;
use crate::scalar::Scalar;
use nalgebra::DVector;
use std::fmt::Debug;
use std::marker::PhantomData;

/// A principal bundle P → P/K with K acting from the right, and vector fields F_1, …, F_r on P that K leaves invariant,
/// span the tangent spaces, and close under the bracket with constant coefficients.
pub trait PrincipalBundle<S: Scalar> {
    /// p, a point of P.
    type Total: Clone + Debug;
    /// k, an element of K.
    type Structure: Clone + Debug;
    /// P/K.
    type Base: Manifold<S>;

    /// P/K.
    fn base(&self) -> &Self::Base;

    /// π(p), exactly the same for p and for p·k.
    fn project(&self, p: &Self::Total) -> <Self::Base as Manifold<S>>::Point;

    /// A point over x: a local section, smooth near each x where it is not switched.
    fn lift(&self, x: &<Self::Base as Manifold<S>>::Point) -> Self::Total;

    /// p·k.
    fn act(&self, p: &Self::Total, k: &Self::Structure) -> Self::Total;

    /// The k with p·k = q, for p and q over one point.
    fn divide(&self, p: &Self::Total, q: &Self::Total) -> Self::Structure;

    /// Numbers that are the same for (p, q) and for (p·k, q·k), and tell the classes of pairs with equal ends apart.
    fn invariant(&self, p: &Self::Total, q: &Self::Total) -> DVector<S>;

    /// A pair over (x, y) with these numbers.
    fn representative(
        &self,
        x: &<Self::Base as Manifold<S>>::Point,
        invariant: &DVector<S>,
        y: &<Self::Base as Manifold<S>>::Point,
    ) -> (Self::Total, Self::Total);

    /// r, the number of the invariant fields.
    fn rank(&self) -> usize;

    /// p displaced by a^i F_i(p), to first order.
    fn moved(&self, p: &Self::Total, a: &DVector<S>) -> Self::Total;

    /// Tπ(a^i F_i), a vector at x in the coordinates of the base.
    fn projected(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S>;

    /// The coefficients of \[a^i F_i, b^i F_i\] for constant a and b.
    fn structure(&self, a: &DVector<S>, b: &DVector<S>) -> DVector<S>;

    /// An a with which (p, p) moved to (p, p + a^i F_i(p)) changes its invariant by `invariant` and its end by `end`;
    /// `None` where x is not a point of the base.
    fn fibre(&self, x: &DVector<S>, invariant: &DVector<S>, end: &DVector<S>) -> Option<DVector<S>>;
}

/// (P×P)/K ⇉ P/K: elements are classes \[p, q\] = \[p·k, q·k\], given by a pair; α\[p, q\] = π(p), β\[p, q\] = π(q),
/// \[p, q\]\[p', q'\] = \[p, q'·k\] with p'·k = q, ε(x) = \[p, p\] with π(p) = x, ι\[p, q\] = \[q, p\].
///
/// Its Lie algebroid is TP/K: sections are the invariant vector fields on P with their bracket, and ρ = Tπ.
#[derive(Clone, Copy, Debug)]
pub struct AtiyahGroupoid<P, S> {
    bundle: P,
    marker: PhantomData<fn() -> S>,
}

impl<S: Scalar, P: PrincipalBundle<S>> AtiyahGroupoid<P, S> {
    /// The groupoid of a bundle.
    pub fn new(bundle: P) -> Self {
        Self { bundle, marker: PhantomData }
    }

    /// The largest difference of the coordinates of two classes: 0 for two pairs of one class, to round-off.
    pub fn distance(&self, g: &(P::Total, P::Total), h: &(P::Total, P::Total)) -> S {
        (self.coordinates(g) - self.coordinates(h)).amax()
    }
}

type Point<P, S> = <<P as PrincipalBundle<S>>::Base as Manifold<S>>::Point;

impl<S: Scalar, P: PrincipalBundle<S>> Groupoid for AtiyahGroupoid<P, S> {
    type Element = (P::Total, P::Total);
    type Base = Point<P, S>;

    fn source(&self, g: &Self::Element) -> Self::Base {
        self.bundle.project(&g.0)
    }

    fn target(&self, g: &Self::Element) -> Self::Base {
        self.bundle.project(&g.1)
    }

    fn unit(&self, x: &Self::Base) -> Self::Element {
        let p = self.bundle.lift(x);
        (p.clone(), p)
    }

    fn inverse(&self, g: &Self::Element) -> Option<Self::Element> {
        Some((g.1.clone(), g.0.clone()))
    }

    fn product(&self, first: &Self::Element, second: &Self::Element) -> Self::Element {
        let k = self.bundle.divide(&second.0, &first.1);
        (first.0.clone(), self.bundle.act(&second.1, &k))
    }
}

impl<S: Scalar, P: PrincipalBundle<S>> LieAlgebroid<S> for AtiyahGroupoid<P, S> {
    fn rank(&self) -> usize {
        self.bundle.rank()
    }

    fn anchor(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        self.bundle.projected(x, a)
    }

    fn structure(&self, _: &DVector<S>, a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
        self.bundle.structure(a, b)
    }
}

impl<S: Scalar, P: PrincipalBundle<S>> LieGroupoid<S> for AtiyahGroupoid<P, S> {
    fn coordinates(&self, g: &Self::Element) -> DVector<S> {
        let end = |p| self.bundle.base().coordinates(&self.bundle.project(p));
        join(&[&end(&g.0), &self.bundle.invariant(&g.0, &g.1), &end(&g.1)])
    }

    fn element(&self, z: &DVector<S>) -> Self::Element {
        let base = self.bundle.base();
        let end = base.size();
        let part = |from, length| z.rows(from, length).into_owned();
        let (x, y) = (base.point(&part(0, end)), base.point(&part(z.len() - end, end)));
        self.bundle.representative(&x, &part(end, z.len() - 2 * end), &y)
    }

    fn base_coordinates(&self, x: &Self::Base) -> DVector<S> {
        self.bundle.base().coordinates(x)
    }

    fn base_point(&self, z: &DVector<S>) -> Self::Base {
        self.bundle.base().point(z)
    }

    fn base_dimension(&self) -> usize {
        self.bundle.base().dimension()
    }

    fn near_point(&self, x: &Self::Base, v: &DVector<S>) -> Self::Base {
        self.bundle.base().near(x, v)
    }

    fn near_unit(&self, x: &Self::Base, a: &DVector<S>) -> Self::Element {
        let p = self.bundle.lift(x);
        let q = self.bundle.moved(&p, a);
        (p, q)
    }

    fn fibre(&self, x: &Self::Base, tangent: &DVector<S>) -> Option<DVector<S>> {
        let x = self.bundle.base().coordinates(x);
        let middle = tangent.len() - 2 * x.len();
        let part = |from, length| tangent.rows(from, length).into_owned();
        self.bundle.fibre(&x, &part(x.len(), middle), &part(x.len() + middle, x.len()))
    }
}

/// SO(3) → SO(3)/SO(2), the frames R over the unit sphere: π(R) = R e_3, K the rotations about e_3, and F_i(R) = ê_i R.
///
/// The invariant of (R, R') is R R'ᵀ.
#[derive(Clone, Copy, Debug, Default)]
pub struct SphereFrames;

fn square<S: Scalar>(z: &DVector<S>) -> Matrix<S, 3> {
    Matrix::from_column_slice(z.as_slice())
}

fn vector<S: Scalar>(a: &DVector<S>) -> Vector<S, 3> {
    Vector::from_fn(|i, _| a[i])
}

impl<S: Scalar> PrincipalBundle<S> for SphereFrames {
    type Total = Matrix<S, 3>;
    type Structure = Matrix<S, 3>;
    type Base = Sphere;

    fn base(&self) -> &Sphere {
        &Sphere
    }

    fn project(&self, p: &Matrix<S, 3>) -> Vector<S, 3> {
        p.column(2).into_owned()
    }

    /// The frame of Duff et al., *Building an orthonormal basis, revisited*, 2017: switched where x_3 changes its sign.
    fn lift(&self, x: &Vector<S, 3>) -> Matrix<S, 3> {
        let (one, zero) = (S::one(), S::zero());
        let sign = if x[2] < zero { -one } else { one };
        let a = -one / (sign + x[2]);
        let b = x[0] * x[1] * a;
        let first = Vector::<S, 3>::new(one + sign * x[0] * x[0] * a, sign * b, -sign * x[0]);
        let second = Vector::<S, 3>::new(b, sign + x[1] * x[1] * a, -x[1]);
        Matrix::from_columns(&[first, second, *x])
    }

    fn act(&self, p: &Matrix<S, 3>, k: &Matrix<S, 3>) -> Matrix<S, 3> {
        p * k
    }

    /// The rotation about e_3 nearest to pᵀq, so that π(p·k) = π(p) exactly.
    fn divide(&self, p: &Matrix<S, 3>, q: &Matrix<S, 3>) -> Matrix<S, 3> {
        let turn = p.transpose() * q;
        let (c, s) = (turn[(0, 0)] + turn[(1, 1)], turn[(1, 0)] - turn[(0, 1)]);
        let length = (c * c + s * s).sqrt();
        let (c, s, zero) = (c / length, s / length, S::zero());
        Matrix::<S, 3>::new(c, -s, zero, s, c, zero, zero, zero, S::one())
    }

    fn invariant(&self, p: &Matrix<S, 3>, q: &Matrix<S, 3>) -> DVector<S> {
        DVector::from_column_slice((p * q.transpose()).as_slice())
    }

    fn representative(
        &self,
        x: &Vector<S, 3>,
        invariant: &DVector<S>,
        y: &Vector<S, 3>,
    ) -> (Matrix<S, 3>, Matrix<S, 3>) {
        let p: Matrix<S, 3> = self.lift(x);
        let mut q = square(invariant).transpose() * p;
        // Equal already, but for rounding.
        q.set_column(2, y);
        (p, q)
    }

    fn rank(&self) -> usize {
        3
    }

    fn moved(&self, p: &Matrix<S, 3>, a: &DVector<S>) -> Matrix<S, 3> {
        p + so3::hat(&vector(a)) * p
    }

    fn projected(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        cross(a, x)
    }

    fn structure(&self, a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
        -cross(a, b)
    }

    fn fibre(&self, _: &DVector<S>, invariant: &DVector<S>, _: &DVector<S>) -> Option<DVector<S>> {
        let a = -so3::vee(&square(invariant));
        Some(DVector::from_column_slice(a.as_slice()))
    }
}

/// A point of B×K, with the inverse of its element of K.
#[derive(Clone, Debug, PartialEq)]
pub struct Fibred<B, U> {
    /// x.
    pub base: B,
    /// u.
    pub element: U,
    /// u⁻¹.
    pub inverse: U,
}

/// The product bundle B×K → B: (x, u)·k = (x, uk), with the fields E_i of B and (x, u) ↦ ê_a u.
///
/// Its Atiyah groupoid is that of the trivial groupoid B×K×B, \[(x, u), (y, w)\] ↦ (x, u w⁻¹, y). The invariant of a
/// pair is u w⁻¹ with its inverse.
#[derive(Clone, Copy, Debug)]
pub struct ProductBundle<B, G> {
    base: B,
    group: G,
}

impl<B, G> ProductBundle<B, G> {
    /// B×K.
    pub fn new(base: B, group: G) -> Self {
        Self { base, group }
    }

    /// (x, u), or `None` when u is singular.
    pub fn point<S: Scalar>(
        &self,
        x: &<B as Manifold<S>>::Point,
        u: &<G as Manifold<S>>::Point,
    ) -> Option<Fibred<<B as Manifold<S>>::Point, <G as Manifold<S>>::Point>>
    where
        B: Manifold<S>,
        G: Group<S>,
    {
        Some(Fibred { base: x.clone(), element: u.clone(), inverse: self.group.inverse(u)? })
    }
}

/// An element of K with its inverse.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn<U> {
    /// k.
    pub element: U,
    /// k⁻¹.
    pub inverse: U,
}

impl<S: Scalar, B: Manifold<S>, G: Group<S>> PrincipalBundle<S> for ProductBundle<B, G> {
    type Total = Fibred<B::Point, G::Point>;
    type Structure = Turn<G::Point>;
    type Base = B;

    fn base(&self) -> &B {
        &self.base
    }

    fn project(&self, p: &Self::Total) -> B::Point {
        p.base.clone()
    }

    fn lift(&self, x: &B::Point) -> Self::Total {
        Fibred { base: x.clone(), element: self.group.identity(), inverse: self.group.identity() }
    }

    fn act(&self, p: &Self::Total, k: &Self::Structure) -> Self::Total {
        Fibred {
            base: p.base.clone(),
            element: self.group.compose(&p.element, &k.element),
            inverse: self.group.compose(&k.inverse, &p.inverse),
        }
    }

    fn divide(&self, p: &Self::Total, q: &Self::Total) -> Self::Structure {
        Turn {
            element: self.group.compose(&p.inverse, &q.element),
            inverse: self.group.compose(&q.inverse, &p.element),
        }
    }

    fn invariant(&self, p: &Self::Total, q: &Self::Total) -> DVector<S> {
        let turn = |u, w| self.group.coordinates(&self.group.compose(u, w));
        join(&[&turn(&p.element, &q.inverse), &turn(&q.element, &p.inverse)])
    }

    fn representative(&self, x: &B::Point, invariant: &DVector<S>, y: &B::Point) -> (Self::Total, Self::Total) {
        let half = invariant.len() / 2;
        let point = |from| self.group.point(&invariant.rows(from, half).into_owned());
        (Fibred { base: x.clone(), element: point(0), inverse: point(half) }, self.lift(y))
    }

    fn rank(&self) -> usize {
        self.group.dimension() + self.base.dimension()
    }

    fn moved(&self, p: &Self::Total, a: &DVector<S>) -> Self::Total {
        let n = self.group.dimension();
        let (u, v) = (a.rows(0, n).into_owned(), a.rows(n, a.len() - n).into_owned());
        let near = |u: &DVector<S>| self.group.near(&self.group.identity(), u);
        Fibred {
            base: self.base.near(&p.base, &v),
            element: self.group.compose(&near(&u), &p.element),
            inverse: self.group.compose(&p.inverse, &near(&-u)),
        }
    }

    fn projected(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        let n = self.group.dimension();
        self.base.frame(x, &a.rows(n, a.len() - n).into_owned())
    }

    fn structure(&self, a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
        let (n, r) = (self.group.dimension(), a.len());
        let part = |a: &DVector<S>, from, to: usize| a.rows(from, to - from).into_owned();
        let vertical = -self.group.structure(&part(a, 0, n), &part(b, 0, n));
        join(&[&vertical, &self.base.structure(&part(a, n, r), &part(b, n, r))])
    }

    fn fibre(&self, x: &DVector<S>, invariant: &DVector<S>, end: &DVector<S>) -> Option<DVector<S>> {
        let unit = self.group.coordinates(&self.group.identity());
        let u = -self.group.velocity(&unit, &invariant.rows(0, unit.len()).into_owned())?;
        Some(join(&[&u, &self.base.velocity(x, end)?]))
    }
}
