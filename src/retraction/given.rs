//! A retraction of a type that is not known here, beside spectators.
//!
//! [`GivenRetraction`] lets the laws, which are compiled in this crate for a few dimensions, judge a retraction that a user has
//! written: of its type nothing is left but a pointer.

use super::{Retraction, RetractionError, TangentPoint};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::group::matrix::Beside;
use crate::scalar::erased::{beside_one, in_scalar, matrix, numbers, scalar};
use crate::scalar::{Real, Scalar};
use std::fmt;
use std::marker::PhantomData;
use std::sync::Arc;

/// A retraction on lists of numbers, of scalars with as many dual numbers as `nesting` says; matrices by columns.
#[doc(hidden)]
pub trait UntypedRetraction<T: Real>: Send + Sync {
    /// [`Retraction::name`].
    fn name(&self) -> &'static str;

    /// [`Retraction::tau`].
    ///
    /// # Errors
    /// Those of `tau`.
    fn tau(&self, nesting: u32, x: &[T]) -> Result<Vec<T>, RetractionError>;

    /// [`Retraction::tau_inv`].
    ///
    /// # Errors
    /// Those of `tau_inv`.
    fn tau_inv(&self, nesting: u32, g: &[T]) -> Result<Vec<T>, RetractionError>;

    /// [`Retraction::at`].
    ///
    /// # Errors
    /// Those of `at`.
    fn at(&self, nesting: u32, x: &[T]) -> Result<Arc<dyn UntypedPoint<T>>, RetractionError>;
}

/// A [`TangentPoint`] on lists of numbers.
#[doc(hidden)]
pub trait UntypedPoint<T: Real> {
    /// The matrix that a name of [`Tangent`] stands for.
    fn matrix(&self, which: Tangent) -> Vec<T>;

    /// [`TangentPoint::dd`].
    fn dd(&self, y: &[T]) -> Vec<T>;

    /// [`TangentPoint::pull_dd`].
    fn pull_dd(&self, p: &[T], m: &[T], y: &[T]) -> Vec<T>;
}

/// The matrices at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Tangent {
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

/// A retraction of dimension N without its type.
pub(crate) struct Untyped<R, const N: usize, const D: usize>(pub R);

impl<R, const N: usize, const D: usize> Untyped<R, N, D> {
    fn tau_in<S: Scalar>(&self, x: &[S::Base]) -> Result<Vec<S::Base>, RetractionError>
    where
        R: Retraction<S::Base, N, D>,
    {
        Ok(numbers(self.0.tau::<S>(&matrix(x))?.as_slice()))
    }

    fn tau_inv_in<S: Scalar>(&self, g: &[S::Base]) -> Result<Vec<S::Base>, RetractionError>
    where
        R: Retraction<S::Base, N, D>,
    {
        Ok(numbers(self.0.tau_inv::<S>(&matrix(g))?.as_slice()))
    }

    fn at_in<S: Scalar>(&self, x: &[S::Base]) -> Result<Arc<dyn UntypedPoint<S::Base>>, RetractionError>
    where
        R: Retraction<S::Base, N, D> + 'static,
    {
        let point = self.0.at::<S>(&matrix(x))?;
        Ok(Arc::new(PointIn { point, scalar: PhantomData::<S> }))
    }
}

impl<T: Real, R, const N: usize, const D: usize> UntypedRetraction<T> for Untyped<R, N, D>
where
    R: Retraction<T, N, D> + Send + Sync + 'static,
{
    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn tau(&self, nesting: u32, x: &[T]) -> Result<Vec<T>, RetractionError> {
        in_scalar!(0..=1, nesting, T, self, tau_in(x))
    }

    fn tau_inv(&self, nesting: u32, g: &[T]) -> Result<Vec<T>, RetractionError> {
        in_scalar!(0..=2, nesting, T, self, tau_inv_in(g))
    }

    fn at(&self, nesting: u32, x: &[T]) -> Result<Arc<dyn UntypedPoint<T>>, RetractionError> {
        in_scalar!(0..=1, nesting, T, self, at_in(x))
    }
}

struct PointIn<P, S, const N: usize> {
    point: P,
    scalar: PhantomData<S>,
}

impl<P: TangentPoint<S, N>, S: Scalar, const N: usize> UntypedPoint<S::Base> for PointIn<P, S, N> {
    fn matrix(&self, which: Tangent) -> Vec<S::Base> {
        let made = match which {
            Tangent::Forward => return numbers(self.point.d().as_slice()),
            Tangent::Inverse => return numbers(self.point.d_inv().as_slice()),
            Tangent::Negative => self.point.d_neg(),
            Tangent::Adjoint => self.point.ad(),
            Tangent::AdjointInverse => self.point.ad_inv(),
        };
        numbers(made.as_slice())
    }

    fn dd(&self, y: &[S::Base]) -> Vec<S::Base> {
        numbers(self.point.dd(&matrix(y)).as_slice())
    }

    fn pull_dd(&self, p: &[S::Base], m: &[S::Base], y: &[S::Base]) -> Vec<S::Base> {
        numbers(self.point.pull_dd(&matrix(p), &matrix(m), &matrix(y)).as_slice())
    }
}

/// A retraction whose type is not known, on G × ℝᴺ⁻ⁿ: beside it stand spectators, on which it is x ↦ 1 + x̂.
#[derive(Clone)]
#[doc(hidden)]
pub struct GivenRetraction<T: Real, const N: usize, const D: usize> {
    given: Arc<dyn UntypedRetraction<T>>,
    algebra: LieAlgebra<T, N>,
    beside: Beside,
}

impl<T: Real, const N: usize, const D: usize> GivenRetraction<T, N, D> {
    /// A retraction of dimension N, with no spectators.
    pub fn whole(retraction: impl Retraction<T, N, D> + Send + Sync + 'static) -> Self {
        let (algebra, beside) = (retraction.algebra().clone(), Beside::alone(N, D));
        Self::new(Arc::new(Untyped::<_, N, D>(retraction)), algebra, beside)
    }

    /// The retraction beside spectators; `algebra` is that of G × ℝᴺ⁻ⁿ.
    pub(crate) fn new(given: Arc<dyn UntypedRetraction<T>>, algebra: LieAlgebra<T, N>, beside: Beside) -> Self {
        Self { given, algebra, beside }
    }
}

impl<T: Real, const N: usize, const D: usize> fmt::Debug for GivenRetraction<T, N, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "GivenRetraction({})", self.given.name())
    }
}

impl<T: Real, const N: usize, const D: usize> Retraction<T, N, D> for GivenRetraction<T, N, D> {
    type Point<S: Scalar<Base = T>> = GivenPoint<S, N>;

    fn name(&self) -> &'static str {
        self.given.name()
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.algebra
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        const { assert!(S::NESTING <= 1) }
        let Beside { dimension: n, size, .. } = self.beside;
        let block = self.given.tau(S::NESTING, &numbers(&x.as_slice()[..n]))?;
        let mut g = beside_one::<S, D>(&block, size, S::one());
        (n..N).for_each(|a| g[self.beside.entry(a - n)] = x[a]);
        Ok(g)
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        const { assert!(S::NESTING <= 2) }
        let Beside { dimension: n, size, .. } = self.beside;
        let block: Vec<S> = (0..size * size).map(|k| g[(k % size, k / size)]).collect();
        let x = self.given.tau_inv(S::NESTING, &numbers(&block))?;
        Ok(Vector::from_fn(|a, _| if a < n { scalar(&x, a) } else { g[self.beside.entry(a - n)] }))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<GivenPoint<S, N>, RetractionError> {
        const { assert!(S::NESTING <= 1) }
        let n = self.beside.dimension;
        let given = self.given.at(S::NESTING, &numbers(&x.as_slice()[..n]))?;
        let [d, d_inv] =
            [Tangent::Forward, Tangent::Inverse].map(|which| beside_one(&given.matrix(which), n, S::one()));
        Ok(GivenPoint { given, dimension: n, d, d_inv })
    }
}

/// The tangents of [`GivenRetraction`] at a point.
#[derive(Clone)]
#[doc(hidden)]
pub struct GivenPoint<S: Scalar, const N: usize> {
    given: Arc<dyn UntypedPoint<S::Base>>,
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

    fn leading(&self, x: &[S]) -> Vec<S::Base> {
        numbers(&x[..self.dimension])
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
        beside_one(&self.given.dd(&self.leading(y.as_slice())), self.dimension, S::zero())
    }

    fn pull_dd(&self, p: &Covector<S, N>, m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        let [p, m, y] = [p.as_slice(), m.as_slice(), y.as_slice()].map(|x| self.leading(x));
        matrix(&self.given.pull_dd(&p, &m, &y))
    }
}
