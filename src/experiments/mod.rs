//! The numerical experiments of Martín de Diego and Sato Martín de Almagro 2019, §5.3.
//!
//! Two systems ([`Problem`]), the methods that they are integrated with ([`Method`], [`Integrator`]), and what is
//! measured: errors at T = 1 against a reference of 30 digits ([`errors`], [`mod@reference`]), and the evolution of
//! energy and Casimir ([`evolution`]). Every method uses the Cayley map.

pub mod errors;
pub mod evolution;
pub mod expected;
pub mod reference;

pub use errors::Errors;
pub use evolution::Integrator;
pub use reference::Reference;

use crate::integrators::trajectory::TrajectoryError;
use crate::integrators::{State, StepError, Variational};
use crate::mechanics::LegendreError;
use crate::mechanics::force::AnyForce;
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::mechanics::models::{self, Model};
use crate::retraction::CayleySo3;
use crate::scalar::Real;
use crate::tableau::TableauError;
use crate::tableau::families::Family;
use std::fmt;

/// Which of the two systems.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Problem {
    /// Landau–Lifschitz–Gilbert (§5.3.1).
    Llg,
    /// The relaxed rigid body (§5.3.2).
    Relaxed,
}

impl Problem {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Llg, Self::Relaxed];

    /// `llg`, `relaxed`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Llg => "llg",
            Self::Relaxed => "relaxed",
        }
    }

    /// The system with its parameters, initial state and horizon, exact in `T`.
    pub fn model<T: Real>(self) -> Model<T> {
        match self {
            Self::Llg => models::landau_lifshitz_gilbert(),
            Self::Relaxed => models::relaxed_rigid_body(),
        }
    }

    /// What is said of a run that failed.
    fn failed<T: Real>(self, method: impl fmt::Display, h: T) -> impl FnOnce(TrajectoryError) -> ExperimentError {
        let (problem, method, step) = (self.name(), method.to_string(), h.to_f64());
        move |source| ExperimentError::Run { problem, method, scalar: T::NAME, step, source: source.into() }
    }

    /// (e, M(0)) at t = 0.
    pub fn state<T: Real>(self) -> State<T, 3, 3> {
        let momentum = self.model::<T>().momentum;
        State { time: T::zero(), momentum, attitude: crate::algebra::Matrix::<T, 3>::identity() }
    }
}

/// The variational integrator of a family of tableaux, with the Cayley map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub struct Method {
    /// The family of the tableau.
    pub family: Family,
    /// s.
    pub stages: usize,
}

/// The integrator type of these experiments.
pub type Variation<T> = Variational<T, 3, 3, AnyLagrangian<T, 3>, AnyForce<T, 3>, CayleySo3<T>>;

impl Method {
    /// The methods whose errors are tabulated: both Lobatto pairs with 2 and 3 stages, Gauss with 1 to 4.
    pub const TABULATED: [Self; 8] = [
        Self::new(Family::LobattoIIIA, 2),
        Self::new(Family::LobattoIIIB, 2),
        Self::new(Family::LobattoIIIA, 3),
        Self::new(Family::LobattoIIIB, 3),
        Self::new(Family::Gauss, 1),
        Self::new(Family::Gauss, 2),
        Self::new(Family::Gauss, 3),
        Self::new(Family::Gauss, 4),
    ];

    /// The method of a family with s stages.
    pub const fn new(family: Family, stages: usize) -> Self {
        Self { family, stages }
    }

    /// Its integrator on a problem.
    ///
    /// # Errors
    /// A number of stages that the family does not have.
    pub fn on<T: Real>(self, problem: Problem) -> Result<Variation<T>, TableauError> {
        let system = problem.model::<T>().system;
        let tableau = self.family.tableau(self.stages)?;
        Ok(Variational::new(system.lagrangian, system.force, CayleySo3::new(), tableau))
    }
}

impl fmt::Display for Method {
    /// `gauss-2`, `lobatto-iiia-3`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&format!("{}-{}", self.family.name(), self.stages))
    }
}

/// Why an experiment could not be carried out.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ExperimentError {
    /// A step failed for another reason than a fold, which is a result.
    #[error("{problem}, {method}, {scalar}, h = {step}: {source}")]
    Run {
        /// The problem.
        problem: &'static str,
        /// The method.
        method: String,
        /// The scalar.
        scalar: &'static str,
        /// h.
        step: f64,
        /// Which step failed, and why.
        source: Box<TrajectoryError>,
    },
    /// The reference computed here is not what it has to be.
    #[error("the reference of {problem} is off by {defect:e} {against}, more than {bound:e}")]
    Reference {
        /// The problem.
        problem: &'static str,
        /// The largest difference of a component.
        defect: f64,
        /// What it was compared with.
        against: &'static str,
        /// The largest difference allowed.
        bound: f64,
    },
    /// A step of the reference failed.
    #[error(transparent)]
    Step(#[from] StepError),
    /// A tableau was refused.
    #[error(transparent)]
    Tableau(#[from] TableauError),
    /// The inverse Legendre transform failed.
    #[error(transparent)]
    Legendre(#[from] LegendreError),
    /// The adaptive integrator stopped.
    #[error(transparent)]
    Adaptive(#[from] crate::integrators::comparators::AdaptiveError),
}
