//! An Atiyah (gauge) groupoid (P×P)/K ⇉ P/K of a principal bundle that is not trivial: the frames over the sphere.

use super::Groupoid;
use super::algebroid::LieAlgebroid;
use super::calculus::join;
use super::lie::LieGroupoid;
use crate::algebra::{Matrix, Vector};
use crate::group::so3;
use crate::scalar::Scalar;
use nalgebra::DVector;
use std::marker::PhantomData;

/// (P×P)/K ⇉ P/K for P = SO(3), the frames R over the unit sphere: π(R) = R e_3, and K the rotations about e_3.
///
/// Elements are classes \[p, q\] = \[p·k, q·k\], given by a pair; α\[p, q\] = π(p), β\[p, q\] = π(q),
/// \[p, q\]\[p', q'\] = \[p, q'·k\] with p'·k = q, ε(x) = \[p, p\] with π(p) = x, ι\[p, q\] = \[q, p\]. The coordinates of a class are those of
/// its ends and, between them, R R'ᵀ, the same for all pairs of the class.
///
/// Its Lie algebroid is TP/K: sections are the invariant vector fields on P with their bracket, and ρ = Tπ. The frame is
/// F_i(R) = ê_i R.
#[derive(Clone, Copy, Debug, Default)]
pub struct AtiyahGroupoid<S>(PhantomData<fn() -> S>);

fn square<S: Scalar>(z: &DVector<S>) -> Matrix<S, 3> {
    Matrix::from_column_slice(z.as_slice())
}

fn vector<S: Scalar>(a: &DVector<S>) -> Vector<S, 3> {
    Vector::from_fn(|i, _| a[i])
}

fn cross<S: Scalar>(a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
    DVector::from_column_slice(vector(a).cross(&vector(b)).as_slice())
}

impl<S: Scalar> AtiyahGroupoid<S> {
    /// The groupoid.
    pub fn new() -> Self {
        Self(PhantomData)
    }

    /// A frame over x: a local section, smooth near each x where it is not switched.
    ///
    /// That of Duff et al., *Building an orthonormal basis, revisited*, 2017: switched where x_3 changes its sign.
    pub fn lift(x: &Vector<S, 3>) -> Matrix<S, 3> {
        let (one, zero) = (S::one(), S::zero());
        let sign = if x[2] < zero { -one } else { one };
        let a = -one / (sign + x[2]);
        let b = x[0] * x[1] * a;
        let first = Vector::<S, 3>::new(one + sign * x[0] * x[0] * a, sign * b, -sign * x[0]);
        let second = Vector::<S, 3>::new(b, sign + x[1] * x[1] * a, -x[1]);
        Matrix::from_columns(&[first, second, *x])
    }

    /// The k with p·k = q, for p and q over one point: the rotation about e_3 nearest to pᵀq, so that π(p·k) = π(p) exactly.
    pub fn divide(p: &Matrix<S, 3>, q: &Matrix<S, 3>) -> Matrix<S, 3> {
        let turn = p.transpose() * q;
        let (c, s) = (turn[(0, 0)] + turn[(1, 1)], turn[(1, 0)] - turn[(0, 1)]);
        let length = (c * c + s * s).sqrt();
        let (c, s, zero) = (c / length, s / length, S::zero());
        Matrix::<S, 3>::new(c, -s, zero, s, c, zero, zero, zero, S::one())
    }
}

impl<S: Scalar> Groupoid for AtiyahGroupoid<S> {
    type Element = (Matrix<S, 3>, Matrix<S, 3>);
    type Base = Vector<S, 3>;

    fn source(&self, g: &Self::Element) -> Vector<S, 3> {
        g.0.column(2).into_owned()
    }

    fn target(&self, g: &Self::Element) -> Vector<S, 3> {
        g.1.column(2).into_owned()
    }

    fn unit(&self, x: &Vector<S, 3>) -> Self::Element {
        let p = Self::lift(x);
        (p, p)
    }

    fn inverse(&self, g: &Self::Element) -> Option<Self::Element> {
        Some((g.1, g.0))
    }

    fn product(&self, first: &Self::Element, second: &Self::Element) -> Self::Element {
        (first.0, second.1 * Self::divide(&second.0, &first.1))
    }
}

impl<S: Scalar> LieAlgebroid<S> for AtiyahGroupoid<S> {
    fn rank(&self) -> usize {
        3
    }

    fn anchor(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        cross(a, x)
    }

    fn structure(&self, _: &DVector<S>, a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
        -cross(a, b)
    }
}

impl<S: Scalar> LieGroupoid<S> for AtiyahGroupoid<S> {
    fn coordinates(&self, g: &Self::Element) -> DVector<S> {
        let between = DVector::from_column_slice((g.0 * g.1.transpose()).as_slice());
        join(&[&self.base_coordinates(&self.source(g)), &between, &self.base_coordinates(&self.target(g))])
    }

    fn element(&self, z: &DVector<S>) -> Self::Element {
        let part = |from, length| z.rows(from, length).into_owned();
        let p = Self::lift(&vector(&part(0, 3)));
        let mut q = square(&part(3, 9)).transpose() * p;
        // Equal already, but for rounding.
        q.set_column(2, &vector(&part(12, 3)));
        (p, q)
    }

    fn base_coordinates(&self, x: &Vector<S, 3>) -> DVector<S> {
        DVector::from_column_slice(x.as_slice())
    }

    fn base_point(&self, z: &DVector<S>) -> Vector<S, 3> {
        vector(z)
    }

    /// The rotations span the tangent spaces of the sphere.
    fn base_dimension(&self) -> usize {
        3
    }

    fn near_point(&self, x: &Vector<S, 3>, v: &DVector<S>) -> Vector<S, 3> {
        x + vector(&cross(v, &self.base_coordinates(x)))
    }

    fn near_unit(&self, x: &Vector<S, 3>, a: &DVector<S>) -> Self::Element {
        let p = Self::lift(x);
        (p, p + so3::hat(&vector(a)) * p)
    }

    fn fibre(&self, _: &Vector<S, 3>, tangent: &DVector<S>) -> Option<DVector<S>> {
        let a = -so3::vee(&square(&tangent.rows(3, 9).into_owned()));
        Some(DVector::from_column_slice(a.as_slice()))
    }
}
