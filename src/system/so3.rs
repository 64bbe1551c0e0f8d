//! The two closed forms on so(3) behind one type, chosen at run time; and these beside the general retractions of dimension 3.

use super::case::Tau;
use crate::algebra::brackets::Brackets;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::group::MatrixGroup;
use crate::retraction::any::{by_arm, tangents_by_arm};
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

impl<T: Real> Retraction<T, 3, 3> for So3Retraction<T> {
    type Point<S: Scalar<Base = T>> = So3Point<T, S>;

    fn name(&self) -> &'static str {
        by_arm!(self, Cayley | Exponential, r => r.name())
    }

    fn algebra(&self) -> &LieAlgebra<T, 3> {
        by_arm!(self, Cayley | Exponential, r => r.algebra())
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<Matrix<S, 3>, RetractionError> {
        by_arm!(self, Cayley | Exponential, r => r.tau(x))
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Result<Vector<S, 3>, RetractionError> {
        by_arm!(self, Cayley | Exponential, r => r.tau_inv(g))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<So3Point<T, S>, RetractionError> {
        Ok(match self {
            Self::Cayley(r) => So3Point::Cayley(r.at(x)?),
            Self::Exponential(r) => So3Point::Exponential(r.at(x)?),
        })
    }

    fn rough_pays_from(&self) -> usize {
        by_arm!(self, Cayley | Exponential, r => r.rough_pays_from())
    }

    fn rough_rates<const W: usize>(&self, brackets: &Brackets<T>, x: &[[T; W]; 3], eta: &[[T; W]; 3]) -> [[T; W]; 3] {
        by_arm!(self, Cayley | Exponential, r => r.rough_rates(brackets, x, eta))
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

tangents_by_arm!([T: Real, S: Scalar<Base = T>] So3Point<T, S>, 3, Cayley | Exponential);

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

impl<T: Real> Retraction<T, 3, 4> for Retraction3<T> {
    type Point<S: Scalar<Base = T>> = Point3<T, S>;

    fn name(&self) -> &'static str {
        by_arm!(self, Closed | General, r => r.name())
    }

    fn algebra(&self) -> &LieAlgebra<T, 3> {
        by_arm!(self, Closed | General, r => r.algebra())
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

    fn rough_pays_from(&self) -> usize {
        by_arm!(self, Closed | General, r => r.rough_pays_from())
    }

    fn rough_rates<const W: usize>(&self, brackets: &Brackets<T>, x: &[[T; W]; 3], eta: &[[T; W]; 3]) -> [[T; W]; 3] {
        by_arm!(self, Closed | General, r => r.rough_rates(brackets, x, eta))
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

tangents_by_arm!([T: Real, S: Scalar<Base = T>] Point3<T, S>, 3, Closed | General);
