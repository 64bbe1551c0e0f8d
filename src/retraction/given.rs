//! A retraction of a type that is not known here, beside spectators.
//!
//! [`GivenRetraction`] lets the laws, which are compiled in this crate for a few dimensions, judge a retraction that a user has
//! written: of its type nothing is left but pointers.

use super::{Retraction, RetractionError, TangentPoint};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::group::matrix::Beside;
use crate::scalar::erased::{beside_one, level};
use crate::scalar::{Dual, Real, Scalar};
use std::fmt;
use std::sync::Arc;

/// A retraction over S, on lists; matrices by columns.
trait RetractionOver<S: Scalar>: Send + Sync {
    fn tau(&self, x: &[S]) -> Result<Vec<S>, RetractionError>;
    fn at(&self, x: &[S]) -> Result<Arc<dyn PointOver<S>>, RetractionError>;
}

/// Its inverse.
trait InverseOver<S: Scalar>: Send + Sync {
    fn tau_inv(&self, g: &[S]) -> Result<Vec<S>, RetractionError>;
}

/// A [`TangentPoint`] on lists.
trait PointOver<S: Scalar> {
    fn matrix(&self, which: Tangent) -> Vec<S>;
    fn dd(&self, y: &[S]) -> Vec<S>;
    fn pull_dd(&self, p: &[S], m: &[S], y: &[S]) -> Vec<S>;
}

/// The matrices at a point.
#[derive(Clone, Copy)]
enum Tangent {
    /// dτ_x.
    Forward,
    /// dτ_x⁻¹.
    Inverse,
    /// dτ_{−x}.
    Negative,
    /// Ad_{τ(x)}.
    Adjoint,
    /// Ad_{τ(x)}⁻¹.
    AdjointInverse,
}

/// A retraction of dimension N in D×D matrices, or a point of one, with its type.
struct Typed<R, const N: usize, const D: usize>(R);

fn vector<S: Scalar, const N: usize>(x: &[S]) -> Vector<S, N> {
    Vector::from_column_slice(x)
}

impl<S: Scalar, R, const N: usize, const D: usize> RetractionOver<S> for Typed<R, N, D>
where
    R: Retraction<S::Base, N, D> + Send + Sync + 'static,
{
    fn tau(&self, x: &[S]) -> Result<Vec<S>, RetractionError> {
        Ok(self.0.tau(&vector(x))?.as_slice().to_vec())
    }

    fn at(&self, x: &[S]) -> Result<Arc<dyn PointOver<S>>, RetractionError> {
        Ok(Arc::new(Typed::<_, N, D>(self.0.at(&vector(x))?)))
    }
}

impl<S: Scalar, R, const N: usize, const D: usize> InverseOver<S> for Typed<R, N, D>
where
    R: Retraction<S::Base, N, D> + Send + Sync,
{
    fn tau_inv(&self, g: &[S]) -> Result<Vec<S>, RetractionError> {
        Ok(self.0.tau_inv(&Matrix::from_column_slice(g))?.as_slice().to_vec())
    }
}

impl<S: Scalar, P: TangentPoint<S, N>, const N: usize, const D: usize> PointOver<S> for Typed<P, N, D> {
    fn matrix(&self, which: Tangent) -> Vec<S> {
        let made = match which {
            Tangent::Forward => *self.0.d(),
            Tangent::Inverse => *self.0.d_inv(),
            Tangent::Negative => self.0.d_neg(),
            Tangent::Adjoint => self.0.ad(),
            Tangent::AdjointInverse => self.0.ad_inv(),
        };
        made.as_slice().to_vec()
    }

    fn dd(&self, y: &[S]) -> Vec<S> {
        self.0.dd(&vector(y)).as_slice().to_vec()
    }

    fn pull_dd(&self, p: &[S], m: &[S], y: &[S]) -> Vec<S> {
        let [p, m] = [p, m].map(Covector::from_row_slice);
        self.0.pull_dd(&p, &m, &vector(y)).as_slice().to_vec()
    }
}

/// A retraction without its type and its dimension.
#[derive(Clone)]
#[allow(clippy::type_complexity, reason = "one pointer for each scalar")]
#[doc(hidden)]
pub struct UntypedRetraction<T: Real> {
    name: &'static str,
    levels: (Arc<dyn RetractionOver<T>>, Arc<dyn RetractionOver<Dual<T>>>),
    inverses: (Arc<dyn InverseOver<T>>, Arc<dyn InverseOver<Dual<T>>>, Arc<dyn InverseOver<Dual<Dual<T>>>>),
}

impl<T: Real> UntypedRetraction<T> {
    pub(crate) fn new<const N: usize, const D: usize>(
        retraction: impl Retraction<T, N, D> + Send + Sync + 'static,
    ) -> Self {
        let (name, r) = (retraction.name(), Arc::new(Typed::<_, N, D>(retraction)));
        Self { name, levels: (r.clone(), r.clone()), inverses: (r.clone(), r.clone(), r) }
    }

    fn over<S: Scalar<Base = T>>(&self) -> &Arc<dyn RetractionOver<S>> {
        const { assert!(S::NESTING <= 1) }
        let (number, dual) = &self.levels;
        level(&[number, dual])
    }

    fn inverse<S: Scalar<Base = T>>(&self) -> &Arc<dyn InverseOver<S>> {
        const { assert!(S::NESTING <= 2) }
        let (number, dual, second) = &self.inverses;
        level(&[number, dual, second])
    }
}

/// A retraction whose type is not known, on G × ℝᴺ⁻ⁿ: beside it stand spectators, on which it is x ↦ 1 + x̂.
#[derive(Clone)]
#[doc(hidden)]
pub struct GivenRetraction<T: Real, const N: usize, const D: usize> {
    given: UntypedRetraction<T>,
    algebra: LieAlgebra<T, N>,
    beside: Beside,
}

impl<T: Real, const N: usize, const D: usize> GivenRetraction<T, N, D> {
    /// A retraction of dimension N, with no spectators.
    pub fn whole(retraction: impl Retraction<T, N, D> + Send + Sync + 'static) -> Self {
        let (algebra, beside) = (retraction.algebra().clone(), Beside::alone(N, D));
        Self::new(UntypedRetraction::new::<N, D>(retraction), algebra, beside)
    }

    /// The retraction beside spectators; `algebra` is that of G × ℝᴺ⁻ⁿ.
    pub(crate) fn new(given: UntypedRetraction<T>, algebra: LieAlgebra<T, N>, beside: Beside) -> Self {
        Self { given, algebra, beside }
    }
}

impl<T: Real, const N: usize, const D: usize> fmt::Debug for GivenRetraction<T, N, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "GivenRetraction({})", self.given.name)
    }
}

impl<T: Real, const N: usize, const D: usize> Retraction<T, N, D> for GivenRetraction<T, N, D> {
    type Point<S: Scalar<Base = T>> = GivenPoint<S, N>;

    fn name(&self) -> &'static str {
        self.given.name
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.algebra
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        let Beside { dimension: n, size, .. } = self.beside;
        let mut g = beside_one::<S, D>(&self.given.over().tau(&x.as_slice()[..n])?, size, S::one());
        (n..N).for_each(|a| g[self.beside.entry(a - n)] = x[a]);
        Ok(g)
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let Beside { dimension: n, size, .. } = self.beside;
        let block: Vec<S> = (0..size * size).map(|k| g[(k % size, k / size)]).collect();
        let x = self.given.inverse().tau_inv(&block)?;
        Ok(Vector::from_fn(|a, _| if a < n { x[a] } else { g[self.beside.entry(a - n)] }))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<GivenPoint<S, N>, RetractionError> {
        let n = self.beside.dimension;
        let given = self.given.over().at(&x.as_slice()[..n])?;
        let [d, d_inv] =
            [Tangent::Forward, Tangent::Inverse].map(|which| beside_one(&given.matrix(which), n, S::one()));
        Ok(GivenPoint { given, dimension: n, d, d_inv })
    }
}

/// The tangents of [`GivenRetraction`] at a point.
#[derive(Clone)]
#[doc(hidden)]
pub struct GivenPoint<S: Scalar, const N: usize> {
    given: Arc<dyn PointOver<S>>,
    dimension: usize,
    d: Matrix<S, N>,
    d_inv: Matrix<S, N>,
}

impl<S: Scalar, const N: usize> fmt::Debug for GivenPoint<S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GivenPoint").field("d", &self.d).finish_non_exhaustive()
    }
}

impl<S: Scalar, const N: usize> GivenPoint<S, N> {
    fn matrix(&self, which: Tangent) -> Matrix<S, N> {
        beside_one(&self.given.matrix(which), self.dimension, S::one())
    }
}

impl<S: Scalar, const N: usize> TangentPoint<S, N> for GivenPoint<S, N> {
    fn d(&self) -> &Matrix<S, N> {
        &self.d
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        &self.d_inv
    }

    fn d_neg(&self) -> Matrix<S, N> {
        self.matrix(Tangent::Negative)
    }

    fn ad(&self) -> Matrix<S, N> {
        self.matrix(Tangent::Adjoint)
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        self.matrix(Tangent::AdjointInverse)
    }

    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        beside_one(&self.given.dd(&y.as_slice()[..self.dimension]), self.dimension, S::zero())
    }

    fn pull_dd(&self, p: &Covector<S, N>, m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        let [p, m, y] = [p.as_slice(), m.as_slice(), y.as_slice()].map(|x| &x[..self.dimension]);
        let pulled = self.given.pull_dd(p, m, y);
        Covector::from_fn(|_, a| pulled.get(a).copied().unwrap_or_else(S::zero))
    }
}
