//! What the groupoids of this module are made of: manifolds with a frame, and Lie groups among them.
//!
//! Points have coordinates in an ambient ℝᵐ (a matrix has its entries, column by column); everything is over a scalar S,
//! so that the structure maps can be differentiated on dual numbers.

use crate::algebra::{Covector, Matrix, Vector};
use crate::group::LieGroup;
use crate::scalar::Scalar;
use nalgebra::{DMatrix, DVector};
use std::fmt::Debug;

/// A manifold in ℝᵐ with vector fields E_1, …, E_k that span its tangent spaces and close under the bracket:
/// \[E_i, E_j\] = c^l_ij E_l with constant c.
pub trait Manifold<S: Scalar> {
    /// x; equality is exact.
    type Point: Clone + Debug + PartialEq;

    /// k, the number of the fields.
    fn dimension(&self) -> usize;

    /// m, the number of the coordinates.
    fn size(&self) -> usize;

    /// The coordinates of x.
    fn coordinates(&self, x: &Self::Point) -> DVector<S>;

    /// The point with these coordinates.
    fn point(&self, z: &DVector<S>) -> Self::Point;

    /// v^i E_i(x), a vector in ℝᵐ.
    fn frame(&self, x: &DVector<S>, v: &DVector<S>) -> DVector<S>;

    /// A v with v^i E_i(x) = `tangent`; `None` where the coordinates are not of a point.
    fn velocity(&self, x: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>>;

    /// c(v, w): the bracket of v^i E_i and w^i E_i for constant v and w.
    fn structure(&self, v: &DVector<S>, w: &DVector<S>) -> DVector<S>;

    /// x + v^i E_i(x): a point to first order in v.
    fn near(&self, x: &Self::Point, v: &DVector<S>) -> Self::Point {
        let z = self.coordinates(x);
        self.point(&(&z + self.frame(&z, v)))
    }
}

/// A group of matrices whose fields E_i are left-invariant: E_i(g) = g ê_i, so that c is the bracket of the algebra.
pub trait Group<S: Scalar>: Manifold<S> {
    /// e.
    fn identity(&self) -> Self::Point;

    /// g h.
    fn compose(&self, g: &Self::Point, h: &Self::Point) -> Self::Point;

    /// g⁻¹, or `None` when the matrix is singular.
    fn inverse(&self, g: &Self::Point) -> Option<Self::Point>;

    /// The matrix of Ad_g, or `None` when g is singular.
    fn adjoint(&self, g: &Self::Point) -> Option<DMatrix<S>>;

    /// g as a matrix.
    fn matrix(&self, g: &Self::Point) -> DMatrix<S>;

    /// ξ̂.
    fn hat(&self, xi: &DVector<S>) -> DMatrix<S>;
}

/// A single point.
#[derive(Clone, Copy, Debug, Default)]
pub struct Singleton;

impl<S: Scalar> Manifold<S> for Singleton {
    type Point = ();

    fn dimension(&self) -> usize {
        0
    }

    fn size(&self) -> usize {
        0
    }

    fn coordinates(&self, _: &()) -> DVector<S> {
        DVector::zeros(0)
    }

    fn point(&self, _: &DVector<S>) {}

    fn frame(&self, _: &DVector<S>, _: &DVector<S>) -> DVector<S> {
        DVector::zeros(0)
    }

    fn velocity(&self, _: &DVector<S>, _: &DVector<S>) -> Option<DVector<S>> {
        Some(DVector::zeros(0))
    }

    fn structure(&self, _: &DVector<S>, _: &DVector<S>) -> DVector<S> {
        DVector::zeros(0)
    }
}

/// A vector space of rows of N numbers, such as g*.
#[derive(Clone, Copy, Debug, Default)]
pub struct Space<const N: usize>;

impl<S: Scalar, const N: usize> Manifold<S> for Space<N> {
    type Point = Covector<S, N>;

    fn dimension(&self) -> usize {
        N
    }

    fn size(&self) -> usize {
        N
    }

    fn coordinates(&self, x: &Covector<S, N>) -> DVector<S> {
        DVector::from_fn(N, |i, _| x[i])
    }

    fn point(&self, z: &DVector<S>) -> Covector<S, N> {
        Covector::from_fn(|_, i| z[i])
    }

    fn frame(&self, _: &DVector<S>, v: &DVector<S>) -> DVector<S> {
        v.clone()
    }

    fn velocity(&self, _: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        Some(tangent.clone())
    }

    fn structure(&self, _: &DVector<S>, _: &DVector<S>) -> DVector<S> {
        DVector::zeros(N)
    }
}

/// A vector space whose dimension is known at run time.
#[derive(Clone, Copy, Debug)]
pub struct DenseSpace {
    /// Its dimension.
    pub dimension: usize,
}

impl<S: Scalar> Manifold<S> for DenseSpace {
    type Point = DVector<S>;

    fn dimension(&self) -> usize {
        self.dimension
    }

    fn size(&self) -> usize {
        self.dimension
    }

    fn coordinates(&self, x: &DVector<S>) -> DVector<S> {
        x.clone()
    }

    fn point(&self, z: &DVector<S>) -> DVector<S> {
        z.clone()
    }

    fn frame(&self, _: &DVector<S>, v: &DVector<S>) -> DVector<S> {
        v.clone()
    }

    fn velocity(&self, _: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        Some(tangent.clone())
    }

    fn structure(&self, _: &DVector<S>, _: &DVector<S>) -> DVector<S> {
        DVector::zeros(self.dimension)
    }
}

/// The unit sphere in ℝ³ with the fields of the rotations: E_i(x) = e_i × x, \[E_i, E_j\] = −ε_ijk E_k.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sphere;

pub(super) fn cross<S: Scalar>(a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
    DVector::from_fn(3, |i, _| {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        a[j] * b[k] - a[k] * b[j]
    })
}

impl<S: Scalar> Manifold<S> for Sphere {
    type Point = Vector<S, 3>;

    fn dimension(&self) -> usize {
        3
    }

    fn size(&self) -> usize {
        3
    }

    fn coordinates(&self, x: &Vector<S, 3>) -> DVector<S> {
        DVector::from_fn(3, |i, _| x[i])
    }

    fn point(&self, z: &DVector<S>) -> Vector<S, 3> {
        Vector::from_fn(|i, _| z[i])
    }

    fn frame(&self, x: &DVector<S>, v: &DVector<S>) -> DVector<S> {
        cross(v, x)
    }

    /// The v perpendicular to x.
    fn velocity(&self, x: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        Some(cross(x, tangent))
    }

    fn structure(&self, v: &DVector<S>, w: &DVector<S>) -> DVector<S> {
        -cross(v, w)
    }
}

/// A [`LieGroup`] as a manifold.
#[derive(Debug)]
pub struct GroupManifold<'a, G, const N: usize, const D: usize>(pub &'a G);

impl<G, const N: usize, const D: usize> Clone for GroupManifold<'_, G, N, D> {
    fn clone(&self) -> Self {
        *self
    }
}

impl<G, const N: usize, const D: usize> Copy for GroupManifold<'_, G, N, D> {}

fn square<S: Scalar, const D: usize>(z: &DVector<S>) -> Matrix<S, D> {
    Matrix::from_fn(|r, c| z[c * D + r])
}

fn flat<S: Scalar, const D: usize>(matrix: &Matrix<S, D>) -> DVector<S> {
    DVector::from_fn(D * D, |k, _| matrix[k])
}

fn fixed<S: Scalar, const N: usize>(v: &DVector<S>) -> Vector<S, N> {
    Vector::from_fn(|a, _| v[a])
}

impl<S, G, const N: usize, const D: usize> Manifold<S> for GroupManifold<'_, G, N, D>
where
    S: Scalar,
    G: LieGroup<S::Base, N, D>,
{
    type Point = Matrix<S, D>;

    fn dimension(&self) -> usize {
        N
    }

    fn size(&self) -> usize {
        D * D
    }

    fn coordinates(&self, x: &Matrix<S, D>) -> DVector<S> {
        flat(x)
    }

    fn point(&self, z: &DVector<S>) -> Matrix<S, D> {
        square(z)
    }

    fn frame(&self, x: &DVector<S>, v: &DVector<S>) -> DVector<S> {
        flat(&(square::<S, D>(x) * self.0.hat(&fixed(v))))
    }

    fn velocity(&self, x: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        let inverse = self.0.inverse(&square::<S, D>(x))?;
        let xi = self.0.vee(&(inverse * square::<S, D>(tangent)));
        Some(DVector::from_fn(N, |a, _| xi[a]))
    }

    fn structure(&self, v: &DVector<S>, w: &DVector<S>) -> DVector<S> {
        let bracket = self.0.algebra().bracket(&fixed(v), &fixed(w));
        DVector::from_fn(N, |a, _| bracket[a])
    }
}

impl<S, G, const N: usize, const D: usize> Group<S> for GroupManifold<'_, G, N, D>
where
    S: Scalar,
    G: LieGroup<S::Base, N, D>,
{
    fn identity(&self) -> Matrix<S, D> {
        self.0.identity()
    }

    fn compose(&self, g: &Matrix<S, D>, h: &Matrix<S, D>) -> Matrix<S, D> {
        self.0.compose(g, h)
    }

    fn inverse(&self, g: &Matrix<S, D>) -> Option<Matrix<S, D>> {
        self.0.inverse(g)
    }

    fn adjoint(&self, g: &Matrix<S, D>) -> Option<DMatrix<S>> {
        let adjoint = self.0.adjoint(g)?;
        Some(DMatrix::from_fn(N, N, |r, c| adjoint[(r, c)]))
    }

    fn matrix(&self, g: &Matrix<S, D>) -> DMatrix<S> {
        DMatrix::from_fn(D, D, |r, c| g[(r, c)])
    }

    fn hat(&self, xi: &DVector<S>) -> DMatrix<S> {
        let hat = self.0.hat(&fixed(xi));
        DMatrix::from_fn(D, D, |r, c| hat[(r, c)])
    }
}
