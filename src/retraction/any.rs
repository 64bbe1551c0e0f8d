//! Either of the two general retractions, or one of them after an odd map, chosen at run time.

// All retractions, of which the table has the names.
use super::*;
use crate::group::{LieGroup, MatrixGroup};

macro_rules! arms {
    ($($(#[$doc:meta])* $name:ident($retraction:ident, $point:ident) $known:tt)*) => {
        /// [`Exponential`] or [`Cayley`], or one of them after an odd map ([`Composed`]).
        #[derive(Clone, Debug)]
        #[non_exhaustive]
        pub enum AnyRetraction<T: Real, const N: usize, const D: usize, G = MatrixGroup<T, N, D>> {
            $($(#[$doc])* $name($retraction<T, N, D, G>),)*
            /// One of these after an odd map.
            Composed(Box<Composed<Self, T>>),
            /// A closed form of SO(3), or one of a type that is not known here, beside spectators.
            #[cfg(feature = "harness")]
            #[doc(hidden)]
            Beside(super::beside::BesideRetraction<T, N, D>),
        }

        /// The tangents of [`AnyRetraction`] at x.
        #[derive(Clone, Debug)]
        #[allow(clippy::large_enum_variant, reason = "a box would allocate at every stage")]
        #[non_exhaustive]
        pub enum AnyPoint<T: Real, S: Scalar<Base = T>, const N: usize> {
            $($(#[$doc])* $name($point<T, S, N>),)*
            /// Of a retraction after an odd map; allocated at every stage.
            Composed(Box<ComposedPoint<Self, S, N>>),
            /// Of a closed form of SO(3), or of a type that is not known here.
            #[cfg(feature = "harness")]
            #[doc(hidden)]
            Beside(super::beside::BesidePoint<S, N>),
        }

        /// The same expression for whichever arm a value is; or the arm of a point.
        macro_rules! by_arm {
            ($value:expr, $inner:ident => $body:expr) => {
                match $value {
                    $(Self::$name($inner) => $body,)*
                    Self::Composed($inner) => $body,
                    #[cfg(feature = "harness")]
                    Self::Beside($inner) => $body,
                }
            };
            ($value:expr, $inner:ident => point $body:expr) => {
                match $value {
                    $(Self::$name($inner) => AnyPoint::$name($body),)*
                    Self::Composed($inner) => AnyPoint::Composed(Box::new($body)),
                    #[cfg(feature = "harness")]
                    Self::Beside($inner) => AnyPoint::Beside($body),
                }
            };
        }
    };
}

retractions!(arms);

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
        Ok(by_arm!(self, r => point r.at(x)?))
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
