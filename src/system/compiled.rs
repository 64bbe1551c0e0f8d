//! What is compiled in this crate, once, and not again in every crate that uses it.

use super::ensemble::{Batch, Ensemble, MemberError, Origin};
use super::error::CaseError;
use super::file::SystemFile;
use super::solution::run;
use super::trajectory::{Ended, Observer};
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
    fn trajectory(file: &SystemFile, observer: &mut dyn Observer<Self>) -> Result<Ended<Self>, CaseError>;
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
                file: &SystemFile,
                observer: &mut dyn Observer<Self>,
            ) -> Result<Ended<Self>, CaseError> {
                run(file, observer)
            }
        }
    )*};
}

compiled!(f64, Dd);

impl Ensemble {
    /// Builds the members and hands them to `drive`.
    ///
    /// # Errors
    /// The first member that is refused.
    pub fn run<T: Compiled>(
        &self,
        origins: &[Origin<T>],
        drive: &mut dyn FnMut(&mut dyn Batch<T>),
    ) -> Result<(), MemberError> {
        T::ensemble(self, origins, drive)
    }
}

impl SystemFile {
    /// The run of the file, with steps or with a tolerance.
    ///
    /// # Errors
    /// A part of the case or of the run that cannot be built. A run that fails is no error of this kind, but [`End::Failed`].
    ///
    /// [`End::Failed`]: super::trajectory::End::Failed
    pub fn run<T: Compiled>(&self, observer: &mut dyn Observer<T>) -> Result<Ended<T>, CaseError> {
        T::trajectory(self, observer)
    }
}
