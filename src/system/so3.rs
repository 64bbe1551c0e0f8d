//! The two closed forms on so(3) behind one type, chosen at run time; and these beside the general retractions of dimension 3.

use super::case::Tau;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::group::MatrixGroup;
use crate::retraction::{AnyRetraction, CayleySo3, ExponentialSo3, Retraction, RetractionError, TangentPoint};
use crate::scalar::{Real, Scalar};

/// Cayley or exp on so(3) in its standard basis.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub enum So3Retraction<T: Real> {
    /// The Cayley map.
    Cayley(CayleySo3<T>),
    /// The exponential.
    Exponential(ExponentialSo3<T>),
}

impl<T: Real> So3Retraction<T> {
    /// The closed form of `tau`.
    pub fn new(tau: Tau) -> Self {
        match tau {
            Tau::Cayley => Self::Cayley(CayleySo3::new()),
            Tau::Exponential => Self::Exponential(ExponentialSo3::new()),
        }
    }
}

macro_rules! either {
    ($ty:ident, $value:expr, $inner:ident => $result:expr) => {
        match $value {
            $ty::Cayley($inner) => $result,
            $ty::Exponential($inner) => $result,
        }
    };
}

impl<T: Real> Retraction<T, 3, 3> for So3Retraction<T> {
    type Point<S: Scalar<Base = T>> = So3Point<T, S>;

    fn name(&self) -> &'static str {
        either!(Self, self, r => r.name())
    }

    fn algebra(&self) -> &LieAlgebra<T, 3> {
        either!(Self, self, r => r.algebra())
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<Matrix<S, 3>, RetractionError> {
        either!(Self, self, r => r.tau(x))
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Result<Vector<S, 3>, RetractionError> {
        either!(Self, self, r => r.tau_inv(g))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<So3Point<T, S>, RetractionError> {
        Ok(match self {
            Self::Cayley(r) => So3Point::Cayley(r.at(x)?),
            Self::Exponential(r) => So3Point::Exponential(r.at(x)?),
        })
    }
}

/// The tangents of [`So3Retraction`] at a point.
#[derive(Clone)]
#[doc(hidden)]
pub enum So3Point<T: Real, S: Scalar<Base = T>> {
    /// Of the Cayley map.
    Cayley(<CayleySo3<T> as Retraction<T, 3, 3>>::Point<S>),
    /// Of the exponential.
    Exponential(<ExponentialSo3<T> as Retraction<T, 3, 3>>::Point<S>),
}

impl<T: Real, S: Scalar<Base = T>> TangentPoint<S, 3> for So3Point<T, S> {
    fn d(&self) -> &Matrix<S, 3> {
        either!(Self, self, p => p.d())
    }

    fn d_inv(&self) -> &Matrix<S, 3> {
        either!(Self, self, p => p.d_inv())
    }

    fn d_neg(&self) -> Matrix<S, 3> {
        either!(Self, self, p => p.d_neg())
    }

    fn ad(&self) -> Matrix<S, 3> {
        either!(Self, self, p => p.ad())
    }

    fn ad_inv(&self) -> Matrix<S, 3> {
        either!(Self, self, p => p.ad_inv())
    }

    fn dd(&self, y: &Vector<S, 3>) -> Matrix<S, 3> {
        either!(Self, self, p => p.dd(y))
    }

    fn pull_dd(&self, p: &Covector<S, 3>, m: &Covector<S, 3>, y: &Vector<S, 3>) -> Covector<S, 3> {
        either!(Self, self, point => point.pull_dd(p, m, y))
    }
}

/// A retraction of dimension 3: a closed form of so(3), where the algebra is that in its standard basis, or a general one.
///
/// Matrices have size 4. Those of SO(3) fill the leading block.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub enum Retraction3<T: Real> {
    /// Of so(3) in its standard basis.
    Closed(So3Retraction<T>),
    /// Of any algebra.
    General(AnyRetraction<T, 3, 4, MatrixGroup<T, 3, 4>>),
}

macro_rules! each {
    ($ty:ident, $value:expr, $inner:ident => $result:expr) => {
        match $value {
            $ty::Closed($inner) => $result,
            $ty::General($inner) => $result,
        }
    };
}

impl<T: Real> Retraction<T, 3, 4> for Retraction3<T> {
    type Point<S: Scalar<Base = T>> = Point3<T, S>;

    fn name(&self) -> &'static str {
        each!(Self, self, r => r.name())
    }

    fn algebra(&self) -> &LieAlgebra<T, 3> {
        each!(Self, self, r => r.algebra())
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<Matrix<S, 4>, RetractionError> {
        match self {
            Self::Closed(r) => {
                let mut g = Matrix::<S, 4>::identity();
                g.fixed_view_mut::<3, 3>(0, 0).copy_from(&r.tau(x)?);
                Ok(g)
            }
            Self::General(r) => r.tau(x),
        }
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, 4>) -> Result<Vector<S, 3>, RetractionError> {
        match self {
            Self::Closed(r) => r.tau_inv(&g.fixed_view::<3, 3>(0, 0).into_owned()),
            Self::General(r) => r.tau_inv(g),
        }
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<Point3<T, S>, RetractionError> {
        Ok(match self {
            Self::Closed(r) => Point3::Closed(r.at(x)?),
            Self::General(r) => Point3::General(r.at(x)?),
        })
    }
}

/// The tangents of [`Retraction3`] at a point.
#[derive(Clone)]
#[doc(hidden)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate at every stage")]
pub enum Point3<T: Real, S: Scalar<Base = T>> {
    /// Of a closed form.
    Closed(So3Point<T, S>),
    /// Of a general retraction.
    General(<AnyRetraction<T, 3, 4, MatrixGroup<T, 3, 4>> as Retraction<T, 3, 4>>::Point<S>),
}

impl<T: Real, S: Scalar<Base = T>> TangentPoint<S, 3> for Point3<T, S> {
    fn d(&self) -> &Matrix<S, 3> {
        each!(Self, self, p => p.d())
    }

    fn d_inv(&self) -> &Matrix<S, 3> {
        each!(Self, self, p => p.d_inv())
    }

    fn d_neg(&self) -> Matrix<S, 3> {
        each!(Self, self, p => p.d_neg())
    }

    fn ad(&self) -> Matrix<S, 3> {
        each!(Self, self, p => p.ad())
    }

    fn ad_inv(&self) -> Matrix<S, 3> {
        each!(Self, self, p => p.ad_inv())
    }

    fn dd(&self, y: &Vector<S, 3>) -> Matrix<S, 3> {
        each!(Self, self, p => p.dd(y))
    }

    fn pull_dd(&self, p: &Covector<S, 3>, m: &Covector<S, 3>, y: &Vector<S, 3>) -> Covector<S, 3> {
        each!(Self, self, point => point.pull_dd(p, m, y))
    }
}
