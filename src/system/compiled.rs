//! What is compiled in this crate, once, and not again in every crate that uses it.

use super::case::Case;
use super::ensemble::{Batch, Ensemble, MemberError, Origin};
use super::error::CaseError;
use super::trajectory::{Ended, Observer, Plan, Run};
use crate::scalar::{Dd, Real};

mod sealed {
    pub trait Sealed {}
}

/// A scalar in which whole systems run: `f64` and [`Dd`].
///
/// What works on systems of every dimension is large when it is compiled. As functions that are generic over nothing, the
/// two here are in this library's object code; generic ones would be compiled again by the programs that call them.
pub trait Compiled: Real + sealed::Sealed {
    #[doc(hidden)]
    fn ensemble(
        ensemble: &Ensemble,
        origins: &[Origin<Self>],
        drive: &mut dyn FnMut(&mut dyn Batch<Self>),
    ) -> Result<(), MemberError>;

    #[doc(hidden)]
    fn trajectory(case: &Case, plan: Plan<Self>, observer: &mut dyn Observer<Self>) -> Result<Ended<Self>, CaseError>;
}

macro_rules! compiled {
    ($($scalar:ty),*) => {$(
        impl sealed::Sealed for $scalar {}

        impl Compiled for $scalar {
            fn ensemble(
                ensemble: &Ensemble,
                origins: &[Origin<Self>],
                drive: &mut dyn FnMut(&mut dyn Batch<Self>),
            ) -> Result<(), MemberError> {
                ensemble.run_in(origins, drive)
            }

            fn trajectory(
                case: &Case,
                plan: Plan<Self>,
                observer: &mut dyn Observer<Self>,
            ) -> Result<Ended<Self>, CaseError> {
                case.dispatch(Run { plan, observer, matrix_size: case.matrix_size() })
            }
        }
    )*};
}

compiled!(f64, Dd);
