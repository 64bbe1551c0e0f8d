//! SO(3) in closed form: rotation matrices, e_1, e_2, e_3 the rotations about the axes, [x, y] = x × y.

use super::LieGroup;
use super::known::basis;
use crate::algebra::catalogue::named;
use crate::algebra::{LieAlgebra, Matrix, Vector};
use crate::scalar::{Real, Scalar};

/// SO(3), with g = so(3) in the basis in which the bracket is the cross product.
#[derive(Clone, Debug, PartialEq)]
pub struct So3<T: Real> {
    algebra: LieAlgebra<T, 3>,
}

impl<T: Real> So3<T> {
    /// SO(3).
    pub fn new() -> Self {
        // ε_abc.
        let sign = |a: usize, b: usize, c: usize| match (3 + b - a) % 3 {
            1 if c == (a + 2) % 3 => 1,
            2 if c == (a + 1) % 3 => -1,
            _ => 0,
        };
        Self { algebra: LieAlgebra::unchecked(|a, b, c| T::int(sign(a, b, c))) }
    }
}

impl<T: Real> Default for So3<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real> LieGroup<T, 3, 3> for So3<T> {
    const BASIS: Option<[[[i8; 3]; 3]; 3]> = Some(basis(named::So3.matrices));

    fn algebra(&self) -> &LieAlgebra<T, 3> {
        &self.algebra
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, 3>) -> Matrix<S, 3> {
        hat(xi)
    }

    fn vee<S: Scalar<Base = T>>(&self, matrix: &Matrix<S, 3>) -> Vector<S, 3> {
        vee(matrix)
    }

    /// gᵀ, for any g: it is the inverse as far as g is orthogonal. Never `None`.
    fn inverse<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Option<Matrix<S, 3>> {
        Some(g.transpose())
    }

    /// Ad_g = g. Never `None`.
    fn adjoint<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Option<Matrix<S, 3>> {
        Some(*g)
    }
}

/// x̂, with x̂ y = x × y.
pub fn hat<S: Scalar>(x: &Vector<S, 3>) -> Matrix<S, 3> {
    let zero = S::zero();
    Matrix::<S, 3>::new(zero, -x[2], x[1], x[2], zero, -x[0], -x[1], x[0], zero)
}

/// The x with x̂ = ½(M − Mᵀ).
pub fn vee<S: Scalar>(m: &Matrix<S, 3>) -> Vector<S, 3> {
    let half = S::half();
    Vector::<S, 3>::new((m[(2, 1)] - m[(1, 2)]) * half, (m[(0, 2)] - m[(2, 0)]) * half, (m[(1, 0)] - m[(0, 1)]) * half)
}

/// The rotation angle of gᵀh in [0, π], the geodesic distance of two rotations (Huynh 2009, Φ₆); absolute error a few u.
///
/// From sine and cosine, |(gᵀh)^∨| and (tr gᵀh − 1)/2: arc cosine alone loses half the digits near 0 and π, arc sine near π. NaN if g
/// or h is.
pub fn angle<T: Real>(g: &Matrix<T, 3>, h: &Matrix<T, 3>) -> T {
    let turn = g.transpose() * h;
    vee(&turn).norm().atan2((turn.trace() - T::one()) * T::half())
}
