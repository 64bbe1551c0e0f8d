//! A matrix group whose sizes are known at run time.

use super::manifold::Manifold;
use crate::algebra::{Matrix, basis_vector};
use crate::group::LieGroup;
use crate::scalar::{Real, Scalar};
use nalgebra::linalg::LU;
use nalgebra::{DMatrix, DVector};

/// A group of D×D matrices with an algebra of dimension N, both known at run time; a copy of a [`LieGroup`].
///
/// One compiled function runs on groups of every size. As a manifold its fields are left-invariant, E_i(g) = g ê_i, so that
/// c is the bracket of the algebra.
#[derive(Clone, Debug, PartialEq)]
pub struct DenseGroup<T: Real> {
    size: usize,
    /// ê_a.
    basis: Vec<DMatrix<T>>,
    /// `dual[a]` pairs with the entries of a matrix to give coordinate a.
    dual: Vec<DMatrix<T>>,
    /// The matrices of ad_{e_a}.
    ad: Vec<DMatrix<T>>,
}

impl<T: Real> DenseGroup<T> {
    /// The copy of a group, by its `hat`, its `vee` and its structure constants.
    pub fn of<G: LieGroup<T, N, D>, const N: usize, const D: usize>(group: &G) -> Self {
        let hat = |a| group.hat(&basis_vector::<T, N>(a));
        let basis = (0..N).map(|a| DMatrix::from_column_slice(D, D, hat(a).as_slice()));
        let mut dual = vec![DMatrix::zeros(D, D); N];
        for entry in 0..D * D {
            let mut unit = Matrix::<T, D>::zeros();
            unit[entry] = T::one();
            dual.iter_mut().zip(&group.vee(&unit)).for_each(|(dual, coordinate)| dual[entry] = *coordinate);
        }
        let ad = (0..N).map(|a| DMatrix::from_fn(N, N, |c, b| group.algebra().constant(a, b, c)));
        Self { size: D, basis: basis.collect(), dual, ad: ad.collect() }
    }

    /// {e}, of 0×0 matrices.
    pub fn trivial() -> Self {
        Self { size: 0, basis: Vec::new(), dual: Vec::new(), ad: Vec::new() }
    }

    /// N.
    pub fn dimension(&self) -> usize {
        self.basis.len()
    }

    /// C^c_ab.
    pub fn constant(&self, a: usize, b: usize, c: usize) -> T {
        self.ad[a][(c, b)]
    }

    /// D.
    pub fn matrix_size(&self) -> usize {
        self.size
    }

    /// The coordinates of a matrix of the algebra.
    pub fn vee<S: Scalar<Base = T>>(&self, matrix: &DMatrix<S>) -> DVector<S> {
        DVector::from_fn(self.dual.len(), |a, _| {
            let entries = matrix.iter().zip(self.dual[a].iter());
            entries.fold(S::zero(), |sum, (entry, f)| sum + *entry * S::lift(*f))
        })
    }

    /// ξ̂.
    pub fn hat<S: Scalar<Base = T>>(&self, xi: &DVector<S>) -> DMatrix<S> {
        let mut sum = DMatrix::zeros(self.size, self.size);
        for (matrix, x) in self.basis.iter().zip(xi.iter()) {
            for (entry, m) in sum.iter_mut().zip(matrix.iter()) {
                *entry += *x * S::lift(*m);
            }
        }
        sum
    }

    /// e.
    pub fn identity<S: Scalar<Base = T>>(&self) -> DMatrix<S> {
        DMatrix::identity(self.size, self.size)
    }

    /// g⁻¹ by elimination with partial pivoting; `None` when a pivot vanishes or the result is not finite.
    pub fn inverse<S: Scalar<Base = T>>(&self, g: &DMatrix<S>) -> Option<DMatrix<S>> {
        LU::new(g.clone()).try_inverse().filter(|inverse| inverse.iter().all(|v| v.all_finite()))
    }

    /// The matrix of Ad_g, or `None` when g is singular.
    pub fn adjoint<S: Scalar<Base = T>>(&self, g: &DMatrix<S>) -> Option<DMatrix<S>> {
        let inverse = self.inverse(g)?;
        let n = self.basis.len();
        let mut ad = DMatrix::zeros(n, n);
        for a in 0..n {
            let conjugate = g * self.basis[a].map(S::lift) * &inverse;
            ad.set_column(a, &self.vee(&conjugate));
        }
        Some(ad)
    }

    /// Ad*_g μ = μ Ad_g, or `None` when g is singular.
    pub fn coadjoint<S: Scalar<Base = T>>(&self, g: &DMatrix<S>, mu: &DVector<S>) -> Option<DVector<S>> {
        Some(self.adjoint(g)?.tr_mul(mu))
    }

    fn square<S: Scalar>(&self, z: &DVector<S>) -> DMatrix<S> {
        DMatrix::from_column_slice(self.size, self.size, z.as_slice())
    }
}

fn flat<S: Scalar>(matrix: &DMatrix<S>) -> DVector<S> {
    DVector::from_column_slice(matrix.as_slice())
}

impl<T: Real, S: Scalar<Base = T>> Manifold<S> for DenseGroup<T> {
    type Point = DMatrix<S>;

    fn dimension(&self) -> usize {
        self.basis.len()
    }

    fn size(&self) -> usize {
        self.size * self.size
    }

    fn coordinates(&self, x: &DMatrix<S>) -> DVector<S> {
        flat(x)
    }

    fn point(&self, z: &DVector<S>) -> DMatrix<S> {
        self.square(z)
    }

    fn frame(&self, x: &DVector<S>, v: &DVector<S>) -> DVector<S> {
        flat(&(self.square(x) * self.hat(v)))
    }

    fn velocity(&self, x: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        Some(self.vee(&(self.inverse(&self.square(x))? * self.square(tangent))))
    }

    fn structure(&self, v: &DVector<S>, w: &DVector<S>) -> DVector<S> {
        let n = self.ad.len();
        DVector::from_fn(n, |c, _| {
            let mut sum = S::zero();
            for a in 0..n {
                for b in 0..n {
                    sum += v[a] * w[b] * S::lift(self.ad[a][(c, b)]);
                }
            }
            sum
        })
    }
}
