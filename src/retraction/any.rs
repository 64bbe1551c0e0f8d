//! Either of the two general retractions, chosen at run time.

use super::{Cayley, CayleyPoint, Exponential, ExponentialPoint, Retraction, RetractionError, TangentPoint};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::group::{LieGroup, MatrixGroup};
use crate::scalar::{Real, Scalar};

/// [`Exponential`] or [`Cayley`].
#[derive(Clone, Debug)]
#[non_exhaustive]
pub enum AnyRetraction<T: Real, const N: usize, const D: usize, G = MatrixGroup<T, N, D>> {
    /// τ = exp.
    Exponential(Exponential<T, N, D, G>),
    /// τ = cay.
    Cayley(Cayley<T, N, D, G>),
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
}

macro_rules! either {
    ($kind:ident, $value:expr, $inner:ident => $body:expr) => {
        match $value {
            $kind::Exponential($inner) => $body,
            $kind::Cayley($inner) => $body,
        }
    };
}

impl<T: Real, const N: usize, const D: usize, G: LieGroup<T, N, D>> Retraction<T, N, D> for AnyRetraction<T, N, D, G> {
    type Point<S: Scalar<Base = T>> = AnyPoint<T, S, N>;

    fn name(&self) -> &'static str {
        either!(Self, self, r => r.name())
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        either!(Self, self, r => r.algebra())
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        either!(Self, self, r => r.tau(x))
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        either!(Self, self, r => r.tau_inv(g))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<AnyPoint<T, S, N>, RetractionError> {
        Ok(match self {
            Self::Exponential(r) => AnyPoint::Exponential(r.at(x)?),
            Self::Cayley(r) => AnyPoint::Cayley(r.at(x)?),
        })
    }
}

impl<T: Real, S: Scalar<Base = T>, const N: usize> TangentPoint<S, N> for AnyPoint<T, S, N> {
    fn d(&self) -> &Matrix<S, N> {
        either!(Self, self, p => p.d())
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        either!(Self, self, p => p.d_inv())
    }

    fn d_neg(&self) -> Matrix<S, N> {
        either!(Self, self, p => p.d_neg())
    }

    fn ad(&self) -> Matrix<S, N> {
        either!(Self, self, p => p.ad())
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        either!(Self, self, p => p.ad_inv())
    }

    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        either!(Self, self, p => p.dd(y))
    }

    fn pull_dd(&self, p: &Covector<S, N>, m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        either!(Self, self, point => point.pull_dd(p, m, y))
    }
}
