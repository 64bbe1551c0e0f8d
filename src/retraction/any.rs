//! Either of the two general retractions, or one of them after an odd map, chosen at run time.

use super::{
    Cayley, CayleyPoint, Composed, ComposedPoint, Exponential, ExponentialPoint, Retraction, RetractionError,
    TangentPoint,
};
use crate::algebra::brackets::Brackets;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::group::{LieGroup, MatrixGroup};
use crate::scalar::{Real, Scalar};

/// [`Exponential`] or [`Cayley`], or one of them after an odd map ([`Composed`]).
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum AnyRetraction<T: Real, const N: usize, const D: usize, G = MatrixGroup<T, N, D>> {
    /// τ = exp.
    Exponential(Exponential<T, N, D, G>),
    /// τ = cay.
    Cayley(Cayley<T, N, D, G>),
    /// One of these after an odd map.
    Composed(Box<Composed<Self, T>>),
    /// Of a type that is not known here.
    #[cfg(feature = "harness")]
    #[doc(hidden)]
    Given(super::given::GivenRetraction<T, N, D>),
}

/// The tangents of [`AnyRetraction`] at x.
#[derive(Clone, Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate at every stage")]
#[non_exhaustive]
pub enum AnyPoint<T: Real, S: Scalar<Base = T>, const N: usize> {
    /// Of exp.
    Exponential(ExponentialPoint<T, S, N>),
    /// Of cay.
    Cayley(CayleyPoint<T, S, N>),
    /// Of a retraction after an odd map; allocated at every stage.
    Composed(Box<ComposedPoint<Self, S, N>>),
    /// Of a type that is not known here.
    #[cfg(feature = "harness")]
    #[doc(hidden)]
    Given(super::given::GivenPoint<S, N>),
}

/// The same expression for whichever arm a value is; those in brackets are there with the feature `harness` alone.
macro_rules! by_arm {
    ($value:expr, $($arm:ident)|+ $([$harness:ident])?, $inner:ident => $body:expr) => {
        match $value {
            $(Self::$arm($inner) => $body,)+
            $(#[cfg(feature = "harness")]
            Self::$harness($inner) => $body,)?
        }
    };
}

/// The tangents of an enum of points are those of the arm that it is.
macro_rules! tangents_by_arm {
    ([$($generics:tt)*] $point:ty, $n:tt, $($arms:tt)+) => {
        impl<$($generics)*> TangentPoint<S, $n> for $point {
            fn d(&self) -> &Matrix<S, $n> {
                by_arm!(self, $($arms)+, p => p.d())
            }

            fn d_inv(&self) -> &Matrix<S, $n> {
                by_arm!(self, $($arms)+, p => p.d_inv())
            }

            fn d_neg(&self) -> Matrix<S, $n> {
                by_arm!(self, $($arms)+, p => p.d_neg())
            }

            fn ad(&self) -> Matrix<S, $n> {
                by_arm!(self, $($arms)+, p => p.ad())
            }

            fn ad_inv(&self) -> Matrix<S, $n> {
                by_arm!(self, $($arms)+, p => p.ad_inv())
            }

            fn dd(&self, y: &Vector<S, $n>) -> Matrix<S, $n> {
                by_arm!(self, $($arms)+, p => p.dd(y))
            }

            fn pull_dd(&self, p: &Covector<S, $n>, m: &Covector<S, $n>, y: &Vector<S, $n>) -> Covector<S, $n> {
                by_arm!(self, $($arms)+, point => point.pull_dd(p, m, y))
            }
        }
    };
}

#[cfg(feature = "harness")]
pub(crate) use {by_arm, tangents_by_arm};

impl<T: Real, const N: usize, const D: usize, G: LieGroup<T, N, D>> Retraction<T, N, D> for AnyRetraction<T, N, D, G> {
    type Point<S: Scalar<Base = T>> = AnyPoint<T, S, N>;

    fn name(&self) -> &'static str {
        by_arm!(self, Exponential | Cayley | Composed [Given], r => r.name())
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        by_arm!(self, Exponential | Cayley | Composed [Given], r => r.algebra())
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        by_arm!(self, Exponential | Cayley | Composed [Given], r => r.tau(x))
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        by_arm!(self, Exponential | Cayley | Composed [Given], r => r.tau_inv(g))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<AnyPoint<T, S, N>, RetractionError> {
        Ok(match self {
            Self::Exponential(r) => AnyPoint::Exponential(r.at(x)?),
            Self::Cayley(r) => AnyPoint::Cayley(r.at(x)?),
            Self::Composed(r) => AnyPoint::Composed(Box::new(r.at(x)?)),
            #[cfg(feature = "harness")]
            Self::Given(r) => AnyPoint::Given(r.at(x)?),
        })
    }

    fn rough_pays_from(&self) -> usize {
        by_arm!(self, Exponential | Cayley | Composed [Given], r => r.rough_pays_from())
    }

    fn rough_rates<const W: usize>(&self, brackets: &Brackets<T>, x: &[[T; W]; N], eta: &[[T; W]; N]) -> [[T; W]; N] {
        by_arm!(self, Exponential | Cayley | Composed [Given], r => r.rough_rates(brackets, x, eta))
    }
}

tangents_by_arm!([T: Real, S: Scalar<Base = T>, const N: usize] AnyPoint<T, S, N>, N, Exponential | Cayley | Composed [Given]);
