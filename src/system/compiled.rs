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

impl Case {
    /// The trajectory of the case.
    ///
    /// ```
    /// use euler_poincare::system::trajectory::{Ended, Observer, Plan, Row};
    /// use euler_poincare::system::{SystemFile, file};
    /// use std::ops::ControlFlow;
    ///
    /// struct Energies(Vec<f64>);
    /// impl Observer<f64> for Energies {
    ///     fn row(&mut self, row: &Row<'_, f64>) {
    ///         self.0.push(row.values[1 + 3 + 3]); // t, three momenta, three velocities, energy
    ///     }
    ///     fn step(&mut self, _: u64, _: u64) -> ControlFlow<()> {
    ///         ControlFlow::Continue(())
    ///     }
    /// }
    ///
    /// let case = SystemFile::parse(file::example())?.case; // a damped rigid body
    /// let mut energies = Energies(Vec::new());
    /// let ended = case.trajectory(Plan { steps: 100, last: None, every: 10 }, &mut energies)?;
    /// assert!(matches!(ended, Ended::Whole { .. }) && energies.0.len() == 11);
    /// assert!(energies.0.is_sorted_by(|earlier, later| earlier > later));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A part of the case that cannot be built. A step that fails is no error of this kind, but [`Ended::Failed`].
    pub fn trajectory<T: Compiled>(
        &self,
        plan: Plan<T>,
        observer: &mut dyn Observer<T>,
    ) -> Result<Ended<T>, CaseError> {
        T::trajectory(self, plan, observer)
    }
}
