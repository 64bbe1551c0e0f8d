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
    /// A closed form of SO(3), beside spectators.
    #[cfg(feature = "harness")]
    #[doc(hidden)]
    So3(super::closed::So3Retraction<T, N, D>),
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
    /// Of a closed form of SO(3).
    #[cfg(feature = "harness")]
    #[doc(hidden)]
    So3(super::closed::So3Point<S, N>),
    /// Of a type that is not known here.
    #[cfg(feature = "harness")]
    #[doc(hidden)]
    Given(super::given::GivenPoint<S, N>),
}

/// The same expression for whichever arm a value is.
macro_rules! by_arm {
    ($value:expr, $inner:ident => $body:expr) => {
        match $value {
            Self::Exponential($inner) => $body,
            Self::Cayley($inner) => $body,
            Self::Composed($inner) => $body,
            #[cfg(feature = "harness")]
            Self::So3($inner) => $body,
            #[cfg(feature = "harness")]
            Self::Given($inner) => $body,
        }
    };
}

impl<T: Real, const N: usize, const D: usize, G: LieGroup<T, N, D>> Retraction<T, N, D> for AnyRetraction<T, N, D, G> {
    type Point<S: Scalar<Base = T>> = AnyPoint<T, S, N>;

    fn name(&self) -> &'static str {
        by_arm!(self, r => r.name())
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        by_arm!(self, r => r.algebra())
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        by_arm!(self, r => r.tau(x))
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        by_arm!(self, r => r.tau_inv(g))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<AnyPoint<T, S, N>, RetractionError> {
        Ok(match self {
            Self::Exponential(r) => AnyPoint::Exponential(r.at(x)?),
            Self::Cayley(r) => AnyPoint::Cayley(r.at(x)?),
            Self::Composed(r) => AnyPoint::Composed(Box::new(r.at(x)?)),
            #[cfg(feature = "harness")]
            Self::So3(r) => AnyPoint::So3(r.at(x)?),
            #[cfg(feature = "harness")]
            Self::Given(r) => AnyPoint::Given(r.at(x)?),
        })
    }

    fn rough_pays_from(&self) -> usize {
        by_arm!(self, r => r.rough_pays_from())
    }

    fn rough_rates<const W: usize>(&self, brackets: &Brackets<T>, x: &[[T; W]; N], eta: &[[T; W]; N]) -> [[T; W]; N] {
        by_arm!(self, r => r.rough_rates(brackets, x, eta))
    }
}

impl<T: Real, S: Scalar<Base = T>, const N: usize> TangentPoint<S, N> for AnyPoint<T, S, N> {
    fn d(&self) -> &Matrix<S, N> {
        by_arm!(self, p => p.d())
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        by_arm!(self, p => p.d_inv())
    }

    fn d_neg(&self) -> Matrix<S, N> {
        by_arm!(self, p => p.d_neg())
    }

    fn ad(&self) -> Matrix<S, N> {
        by_arm!(self, p => p.ad())
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        by_arm!(self, p => p.ad_inv())
    }

    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        by_arm!(self, p => p.dd(y))
    }

    fn pull_dd(&self, p: &Covector<S, N>, m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        by_arm!(self, point => point.pull_dd(p, m, y))
    }
}
