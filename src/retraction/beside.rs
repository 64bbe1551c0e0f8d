//! A retraction beside spectators: a closed form of SO(3), or one of a type that is not known here.
//!
//! [`UntypedRetraction`] lets the laws, which are compiled in this crate for a few dimensions, judge a retraction that a user has
//! written: of its type nothing is left but pointers.

use super::named::Tau;
use super::so3::{CayleySo3, CayleySo3Point, ExponentialSo3, ExponentialSo3Point};
use super::{Retraction, RetractionError, TangentPoint, add_lanes};
use crate::algebra::brackets::Brackets;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::group::matrix::Beside;
use crate::group::{LieGroup, So3};
use crate::scalar::erased::{beside_one, level};
use crate::scalar::{Dual, Real, Scalar};
use std::fmt;
use std::sync::Arc;

/// What takes a list, a matrix by columns.
type Put<'a, S> = &'a mut dyn FnMut(&[S]);

/// A retraction over S, on lists.
trait RetractionOver<S: Scalar>: Send + Sync {
    fn tau(&self, x: &[S], put: Put<'_, S>) -> Result<(), RetractionError>;
    fn at(&self, x: &[S]) -> Result<Arc<dyn PointOver<S>>, RetractionError>;
}

/// Its inverse.
trait InverseOver<S: Scalar>: Send + Sync {
    fn tau_inv(&self, g: &[S], put: Put<'_, S>) -> Result<(), RetractionError>;
}

/// A [`TangentPoint`] on lists.
trait PointOver<S: Scalar> {
    fn matrix(&self, which: Tangent, put: Put<'_, S>);
    fn dd(&self, y: &[S], put: Put<'_, S>);
    fn pull_dd(&self, p: &[S], m: &[S], y: &[S], put: Put<'_, S>);
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
#[derive(Clone)]
#[doc(hidden)]
pub struct Typed<R, const N: usize, const D: usize>(pub(crate) R);

fn vector<S: Scalar, const N: usize>(x: &[S]) -> Vector<S, N> {
    Vector::from_column_slice(x)
}

impl<S: Scalar, R, const N: usize, const D: usize> RetractionOver<S> for Typed<R, N, D>
where
    R: Retraction<S::Base, N, D> + Send + Sync + 'static,
{
    fn tau(&self, x: &[S], put: Put<'_, S>) -> Result<(), RetractionError> {
        put(self.0.tau(&vector(x))?.as_slice());
        Ok(())
    }

    fn at(&self, x: &[S]) -> Result<Arc<dyn PointOver<S>>, RetractionError> {
        Ok(Arc::new(Typed::<_, N, D>(self.0.at(&vector(x))?)))
    }
}

impl<S: Scalar, R, const N: usize, const D: usize> InverseOver<S> for Typed<R, N, D>
where
    R: Retraction<S::Base, N, D> + Send + Sync,
{
    fn tau_inv(&self, g: &[S], put: Put<'_, S>) -> Result<(), RetractionError> {
        put(self.0.tau_inv(&Matrix::from_column_slice(g))?.as_slice());
        Ok(())
    }
}

impl<S: Scalar, P: TangentPoint<S, N>, const N: usize, const D: usize> PointOver<S> for Typed<P, N, D> {
    fn matrix(&self, which: Tangent, put: Put<'_, S>) {
        match which {
            Tangent::Forward => put(self.0.d().as_slice()),
            Tangent::Inverse => put(self.0.d_inv().as_slice()),
            Tangent::Negative => put(self.0.d_neg().as_slice()),
            Tangent::Adjoint => put(self.0.ad().as_slice()),
            Tangent::AdjointInverse => put(self.0.ad_inv().as_slice()),
        }
    }

    fn dd(&self, y: &[S], put: Put<'_, S>) {
        put(self.0.dd(&vector(y)).as_slice());
    }

    fn pull_dd(&self, p: &[S], m: &[S], y: &[S], put: Put<'_, S>) {
        let [p, m] = [p, m].map(Covector::from_row_slice);
        put(self.0.pull_dd(&p, &m, &vector(y)).as_slice());
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
}

impl<T: Real, S: Scalar<Base = T>> RetractionOver<S> for UntypedRetraction<T> {
    fn tau(&self, x: &[S], put: Put<'_, S>) -> Result<(), RetractionError> {
        self.over().tau(x, put)
    }

    fn at(&self, x: &[S]) -> Result<Arc<dyn PointOver<S>>, RetractionError> {
        self.over().at(x)
    }
}

impl<T: Real, S: Scalar<Base = T>> InverseOver<S> for UntypedRetraction<T> {
    fn tau_inv(&self, g: &[S], put: Put<'_, S>) -> Result<(), RetractionError> {
        const { assert!(S::NESTING <= 2) }
        let (number, dual, second) = &self.inverses;
        level::<Arc<dyn InverseOver<S>>>(&[number, dual, second]).tau_inv(g, put)
    }
}

/// What stands beside spectators.
#[derive(Clone)]
#[doc(hidden)]
pub enum Core<T: Real> {
    /// The Cayley map on SO(3).
    Cayley(Typed<CayleySo3<T>, 3, 3>),
    /// The exponential on SO(3).
    Exponential(Typed<ExponentialSo3<T>, 3, 3>),
    /// Of a type that is not known here.
    Given(UntypedRetraction<T>),
}

#[derive(Clone)]
enum CorePoint<S: Scalar> {
    Cayley(Typed<CayleySo3Point<S>, 3, 3>),
    Exponential(Typed<ExponentialSo3Point<S>, 3, 3>),
    Given(Arc<dyn PointOver<S>>),
}

/// The same expression for whichever it is.
macro_rules! in_core {
    ($value:expr, $of:ident, $inner:ident => $body:expr) => {
        match $value {
            $of::Cayley($inner) => $body,
            $of::Exponential($inner) => $body,
            $of::Given($inner) => $body,
        }
    };
}

/// A retraction on G × ℝᴺ⁻ⁿ: beside that of G stand spectators, on which it is x ↦ 1 + x̂.
#[derive(Clone)]
#[doc(hidden)]
pub struct BesideRetraction<T: Real, const N: usize, const D: usize> {
    core: Core<T>,
    algebra: LieAlgebra<T, N>,
    beside: Beside,
}

impl<T: Real> BesideRetraction<T, 3, 3> {
    /// The closed form on SO(3) itself, where the retraction has one.
    pub fn so3(tau: Tau) -> Option<Self> {
        Some(Self { core: tau.closed()?, algebra: So3::new().algebra().clone(), beside: Beside::alone(3, 3) })
    }
}

impl<T: Real, const N: usize, const D: usize> BesideRetraction<T, N, D> {
    /// A retraction of dimension N, with no spectators.
    pub fn whole(retraction: impl Retraction<T, N, D> + Send + Sync + 'static) -> Self {
        let (algebra, beside) = (retraction.algebra().clone(), Beside::alone(N, D));
        Self { core: Core::Given(UntypedRetraction::new::<N, D>(retraction)), algebra, beside }
    }

    /// The retraction beside spectators; `algebra` is that of G × ℝᴺ⁻ⁿ. `None` where D is too small.
    pub(crate) fn new(core: Core<T>, algebra: LieAlgebra<T, N>, beside: Beside) -> Option<Self> {
        (beside.rows() <= D).then_some(Self { core, algebra, beside })
    }

    /// What stands beside spectators.
    pub(crate) fn core(&self) -> &Core<T> {
        &self.core
    }
}

impl<T: Real, const N: usize, const D: usize> fmt::Debug for BesideRetraction<T, N, D> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "BesideRetraction({})", self.name())
    }
}

impl<T: Real, const N: usize, const D: usize> Retraction<T, N, D> for BesideRetraction<T, N, D> {
    type Point<S: Scalar<Base = T>> = BesidePoint<S, N>;

    fn name(&self) -> &'static str {
        match &self.core {
            Core::Cayley(r) => r.0.name(),
            Core::Exponential(r) => r.0.name(),
            Core::Given(r) => r.name,
        }
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.algebra
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        let (Beside { dimension: n, size, .. }, mut g) = (self.beside, Matrix::<S, D>::zeros());
        let put = &mut |block: &[S]| g = beside_one(block, size, S::one());
        in_core!(&self.core, Core, r => r.tau(&x.as_slice()[..n], put))?;
        (n..N).for_each(|a| g[self.beside.entry(a - n)] = x[a]);
        Ok(g)
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let (Beside { dimension: n, size, .. }, mut block) = (self.beside, Matrix::<S, D>::zeros());
        let block = &mut block.as_mut_slice()[..size * size];
        block.iter_mut().enumerate().for_each(|(k, entry)| *entry = g[(k % size, k / size)]);
        let mut x = Vector::<S, N>::from_fn(|a, _| if a < n { S::zero() } else { g[self.beside.entry(a - n)] });
        let put = &mut |leading: &[S]| x.as_mut_slice()[..n].copy_from_slice(leading);
        in_core!(&self.core, Core, r => r.tau_inv(block, put))?;
        Ok(x)
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<BesidePoint<S, N>, RetractionError> {
        let (n, zeros) = (self.beside.dimension, Matrix::zeros());
        let x = &x.as_slice()[..n];
        let core = match &self.core {
            Core::Cayley(r) => CorePoint::Cayley(Typed(r.0.at(&vector(x))?)),
            Core::Exponential(r) => CorePoint::Exponential(Typed(r.0.at(&vector(x))?)),
            Core::Given(r) => CorePoint::Given(r.at(x)?),
        };
        let mut point = BesidePoint { core, dimension: n, d: zeros, d_inv: zeros };
        (point.d, point.d_inv) = (point.matrix(Tangent::Forward), point.matrix(Tangent::Inverse));
        Ok(point)
    }

    fn rough_pays_from(&self) -> usize {
        match &self.core {
            Core::Cayley(r) => r.0.rough_pays_from(),
            Core::Exponential(r) => r.0.rough_pays_from(),
            Core::Given(_) => 1,
        }
    }

    fn rough_rates<const W: usize>(&self, brackets: &Brackets<T>, x: &[[T; W]; N], eta: &[[T; W]; N]) -> [[T; W]; N] {
        let (mut rates, [first, speed]) = (*eta, [x, eta].map(|v| std::array::from_fn(|a| v[a.min(N - 1)])));
        let turned: [[T; W]; 3] = match &self.core {
            Core::Cayley(r) => r.0.rough_rates(brackets, &first, &speed),
            Core::Exponential(r) => r.0.rough_rates(brackets, &first, &speed),
            Core::Given(_) => {
                add_lanes(&mut rates, &brackets.brackets(x, eta), T::half());
                return rates;
            }
        };
        rates[..3].copy_from_slice(&turned);
        rates
    }
}

/// The tangents of [`BesideRetraction`] at a point.
#[derive(Clone)]
#[doc(hidden)]
pub struct BesidePoint<S: Scalar, const N: usize> {
    core: CorePoint<S>,
    dimension: usize,
    d: Matrix<S, N>,
    d_inv: Matrix<S, N>,
}

impl<S: Scalar, const N: usize> fmt::Debug for BesidePoint<S, N> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("BesidePoint").field("d", &self.d).finish_non_exhaustive()
    }
}

impl<S: Scalar, const N: usize> BesidePoint<S, N> {
    fn matrix(&self, which: Tangent) -> Matrix<S, N> {
        let mut matrix = Matrix::zeros();
        let put = &mut |block: &[S]| matrix = beside_one(block, self.dimension, S::one());
        in_core!(&self.core, CorePoint, p => p.matrix(which, put));
        matrix
    }
}

impl<S: Scalar, const N: usize> TangentPoint<S, N> for BesidePoint<S, N> {
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
        let mut matrix = Matrix::zeros();
        let put = &mut |block: &[S]| matrix = beside_one(block, self.dimension, S::zero());
        in_core!(&self.core, CorePoint, p => p.dd(&y.as_slice()[..self.dimension], put));
        matrix
    }

    fn pull_dd(&self, p: &Covector<S, N>, m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        let (n, mut row) = (self.dimension, Covector::<S, N>::zeros());
        let [p, m, y] = [p.as_slice(), m.as_slice(), y.as_slice()].map(|x| &x[..n]);
        let put = &mut |pulled: &[S]| row.as_mut_slice()[..n].copy_from_slice(pulled);
        in_core!(&self.core, CorePoint, point => point.pull_dd(p, m, y, put));
        row
    }
}
