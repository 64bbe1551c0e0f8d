//! Lie groups through faithful matrix representations.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/group.md"))]

use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, basis_vector};
use crate::scalar::{Real, Scalar};

mod departure;
mod known;
pub(crate) mod matrix;
pub mod so3;

pub use departure::departure;
#[cfg(feature = "harness")]
pub(crate) use departure::nearest_rotations;
pub use known::{Aff1, Heisenberg, Se2, Se3, Sl2, So4};
pub use matrix::MatrixGroup;
pub use so3::So3;

/// A Lie group of dimension N, represented faithfully by D×D matrices.
///
/// Required are the algebra and the two linear maps between coordinates and matrices; everything else has a default
/// that holds for every matrix group, to be overridden where a closed form is better.
///
/// ```
/// use euler_poincare::algebra::{Covector, Entry, Matrix, Vector};
/// use euler_poincare::group::{LieGroup, MatrixGroup, So3};
///
/// let rotations = So3::<f64>::new();
/// let quarter = Matrix::<f64, 3>::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
/// // Ad_g turns e_1 into e_2.
/// assert_eq!(rotations.adjoint(&quarter), Some(quarter));
/// assert_eq!(quarter * Vector::<f64, 3>::x(), Vector::<f64, 3>::y());
///
/// // Any group of matrices, from a basis of its algebra: here se(2), with 3×3 matrices.
/// let motions = MatrixGroup::<f64, 3, 3>::from_entry(&Entry::Se2)?;
/// let g = motions.identity::<f64>() + motions.hat(&Vector::<f64, 3>::new(0.0, 2.0, 3.0));
/// let inverse = motions.inverse(&g).expect("a regular matrix");
/// assert_eq!(motions.compose(&g, &inverse), motions.identity());
/// // The momentum in another frame: Ad*_g μ = μ Ad_g.
/// let mu = Covector::<f64, 3>::new(0.0, 1.0, 0.0);
/// assert!(motions.coadjoint(&g, &mu).is_some_and(|moved| moved.iter().all(|x| x.is_finite())));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait LieGroup<T: Real, const N: usize, const D: usize> {
    /// The matrices ê_a, of a group that is known when a program is compiled: steps in lanes then leave out what is 0.
    const BASIS: Option<[[[i8; D]; D]; N]> = None;

    /// The algebra, in the basis that `hat` uses.
    fn algebra(&self) -> &LieAlgebra<T, N>;

    /// ξ̂ = ξ^a ê_a.
    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Matrix<S, D>;

    /// The coordinates of a matrix of the algebra (of its projection, if it is slightly off).
    fn vee<S: Scalar<Base = T>>(&self, matrix: &Matrix<S, D>) -> Vector<S, N>;

    /// e.
    fn identity<S: Scalar<Base = T>>(&self) -> Matrix<S, D> {
        Matrix::<S, D>::identity()
    }

    /// g h.
    fn compose<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>, h: &Matrix<S, D>) -> Matrix<S, D> {
        g * h
    }

    /// g⁻¹, or `None` when the matrix is singular.
    fn inverse<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Option<Matrix<S, D>>;

    /// The matrix of Ad_g: Ad_g ξ = (g ξ̂ g⁻¹)^∨; `None` when g is singular.
    fn adjoint<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Option<Matrix<S, N>> {
        let inverse = self.inverse(g)?;
        let mut ad = Matrix::<S, N>::zeros();
        for a in 0..N {
            ad.set_column(a, &self.vee(&(g * self.hat(&basis_vector(a)) * inverse)));
        }
        Some(ad)
    }

    /// Ad*_g μ = μ Ad_g.
    fn coadjoint<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>, mu: &Covector<S, N>) -> Option<Covector<S, N>> {
        Some(mu * self.adjoint(g)?)
    }

    /// The largest entry of |g − h|, derivative parts ignored; infinite when an entry is not finite.
    fn distance<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>, h: &Matrix<S, D>) -> T {
        let mut size = T::zero();
        for (x, y) in g.iter().zip(h.iter()) {
            let entry = (x.base() - y.base()).abs();
            if !entry.all_finite() {
                return T::exact(f64::INFINITY);
            }
            size = size.max(entry);
        }
        size
    }
}
