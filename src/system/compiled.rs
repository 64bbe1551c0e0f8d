//! What is compiled in this crate, once, and not again in every crate that uses it.

use super::case::Case;
use super::ensemble::{Batch, Ensemble, MemberError, Origin};
use super::error::CaseError;
use super::file::{SystemFile, not_in_64_digits};
use super::solution::{Solved, solved};
use super::trajectory::{Ended, Observer, Plan, Run};
use crate::scalar::{Dd, Qd, Real};

mod sealed {
    pub trait Sealed {}
}

/// A scalar in which whole systems run: `f64`, [`Dd`] and [`Qd`].
///
/// In [`Qd`] there are trajectories with fixed steps, of systems of dimension 1 to 6. A tolerance, ensembles and larger systems are
/// errors there: the machine code would be larger than what it is used for.
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

    #[doc(hidden)]
    fn solution(file: &SystemFile, observer: &mut dyn Observer<Self>) -> Result<Option<Solved<Self>>, CaseError>;
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

            fn solution(
                file: &SystemFile,
                observer: &mut dyn Observer<Self>,
            ) -> Result<Option<Solved<Self>>, CaseError> {
                solved(file, observer)
            }
        }
    )*};
}

compiled!(f64, Dd);

impl sealed::Sealed for Qd {}

impl Compiled for Qd {
    fn ensemble(_: &Ensemble, _: &[Origin<Self>], _: &mut dyn FnMut(&mut dyn Batch<Self>)) -> Result<(), MemberError> {
        Err(MemberError { member: 0, source: not_in_64_digits("an ensemble").into() })
    }

    /// The step is the one that the laws compile.
    fn trajectory(case: &Case, plan: Plan<Self>, observer: &mut dyn Observer<Self>) -> Result<Ended<Self>, CaseError> {
        case.dispatch_main(Run { plan, observer, matrix_size: case.matrix_size() })
    }

    fn solution(file: &SystemFile, _: &mut dyn Observer<Self>) -> Result<Option<Solved<Self>>, CaseError> {
        if file.adaptive.is_some() { Err(not_in_64_digits("a tolerance")) } else { Ok(None) }
    }
}

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

impl SystemFile {
    /// The run of a file with a tolerance; none where it has a step.
    ///
    /// ```
    /// use euler_poincare::system::SystemFile;
    /// use euler_poincare::system::file::example;
    /// use euler_poincare::system::solution::{End, Plan, Solved, Statistics};
    /// use euler_poincare::system::trajectory::{Observer, Row};
    /// use std::ops::ControlFlow;
    ///
    /// struct Times(Vec<f64>);
    /// impl Observer<f64> for Times {
    ///     fn row(&mut self, row: &Row<'_, f64>) {
    ///         self.0.push(row.values[0]);
    ///     }
    ///     fn step(&mut self, _: u64, _: u64) -> ControlFlow<()> {
    ///         ControlFlow::Continue(())
    ///     }
    /// }
    ///
    /// let text = example().replacen("step = \"1/8\"", "tolerance = 1e-10", 1);
    /// let file = SystemFile::parse(&text.replacen("every = 1", "save_at = [0.25, 1]", 1))?;
    /// let plan: Plan<f64> = file.solve_plan()?.expect("a tolerance");
    /// let mut times = Times(Vec::new());
    /// let solved: Solved<f64> = file.solve(&mut times)?.expect("a tolerance");
    /// let statistics: Statistics<f64> = solved.statistics.expect("a start");
    /// assert_eq!((solved.end, times.0, plan.end), (End::Time, vec![0.25, 1.0], 1.0));
    /// assert!(statistics.error < 1e-10);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// A part of the case or of the run that cannot be built. A run that fails is no error of this kind, but [`End::Failed`].
    ///
    /// [`End::Failed`]: super::solution::End::Failed
    pub fn solve<T: Compiled>(&self, observer: &mut dyn Observer<T>) -> Result<Option<Solved<T>>, CaseError> {
        T::solution(self, observer)
    }
}
