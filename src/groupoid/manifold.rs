//! What the groupoids of this module have as their bases: manifolds with a frame.
//!
//! Points have coordinates in an ambient ℝᵐ (a matrix has its entries, column by column); everything is over a scalar S,
//! so that the structure maps can be differentiated on dual numbers.

use crate::scalar::Scalar;
use nalgebra::DVector;
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

/// A vector space, such as g*; of dimension 0, a point.
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
