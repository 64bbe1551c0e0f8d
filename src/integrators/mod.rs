//! One-step methods on (g, μ), and the trajectories made of them.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/integrators.md"))]

pub mod advected;
mod blocks;
pub mod classical;
pub mod comparators;
pub mod derivative;
pub mod doubled;
pub mod ensemble;
#[cfg(feature = "lanes")]
pub mod lanes;
pub mod munthe_kaas;
mod parameters;
mod picard;
#[cfg(feature = "lanes")]
pub mod se3;
#[cfg(feature = "lanes")]
pub mod so3;
pub mod solve;
mod stages;
mod state;
pub mod trajectory;
mod trust;
pub mod variational;

pub use advected::{Advected, AdvectedState};
pub use classical::Classical;
pub use doubled::{Doubled, DoubledState};
pub use ensemble::{Ensemble, EnsembleError};
#[cfg(feature = "lanes")]
pub use lanes::VariationalInLanes;
pub use munthe_kaas::MuntheKaas;
#[cfg(feature = "lanes")]
pub use so3::{EnsembleSo3, QuaternionSo3};
pub use solve::Solve;
pub use state::State;
pub use variational::Variational;

use crate::algebra::{Matrix, Vector};
use crate::mechanics::LegendreError;
use crate::newton::{Failure, NewtonSettings};
use crate::retraction::RetractionError;
use crate::scalar::Real;

/// Which iteration solved the stage equations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Solver {
    /// Explicit: nothing to solve.
    Explicit,
    /// Fixed-point iteration on the stage momenta and displacements.
    FixedPoint,
    /// Newton's method with the Jacobian from dual numbers; for [`Variational`] along h in few pieces.
    Newton,
    /// Newton's method along a continuation in h from 0, in pieces that had to be shortened.
    Continuation,
}

/// What one step cost, and how well its equations hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Report<T> {
    /// Which iteration produced the stages.
    pub solver: Solver,
    /// Fixed-point and Newton iterations spent, of all solvers tried. Those of the equations of motion between two evaluations of the
    /// scheme count, too; they cost a fraction of one.
    pub iterations: usize,
    /// The largest component of the true residual r_i, relative to the momentum and the forces; and of what the displacements miss, likewise.
    pub residual: T,
}

/// A stage (counted from 1), or what else is said of a step.
fn place(stage: &Option<usize>, other: &str) -> String {
    stage.map_or(other.into(), |stage| format!("stage {}", stage + 1))
}

fn because(why: &Option<String>) -> String {
    why.as_ref().map_or(String::new(), |why| format!(": {why}"))
}

/// A number to seven digits.
fn rounded(x: f64) -> String {
    let rounded: f64 = format!("{x:.6e}").parse().unwrap_or(x);
    let plain = x == 0.0 || (1e-4..1e7).contains(&x.abs());
    if plain { rounded.to_string() } else { format!("{rounded:e}") }
}

/// Why a step was refused. The state is left as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StepError {
    /// The stage equations have no root that continues from h = 0: the branch turns back in h before the step, where det J goes through 0.
    #[error(
        "fold: the solution that continues from h = 0 ends near h = {}, before the step h = {step}; take a smaller step, or give a tolerance",
        rounded(*fold)
    )]
    Fold {
        /// The step asked for.
        step: f64,
        /// The h of largest size on the branch, with the sign of the step.
        fold: f64,
        /// det J at the point next to the fold that was found, relative to det J at h = 0: it is 0 at the fold.
        determinant: f64,
    },
    /// The solution that continues from h = 0 turns too often or too fast before h: it was not followed to its end.
    #[error(
        "the step h = {step} is too long: the solution that continues from h = 0 was followed to h = {}; take a smaller step, or give a tolerance",
        rounded(*reached)
    )]
    TooLong {
        /// The step asked for.
        step: f64,
        /// How far it was followed.
        reached: f64,
    },
    /// The solution that continues from h = 0 was followed to where rounding of the stage equations is larger than what is accepted.
    #[error(
        "rounding: the solution that continues from h = 0 was followed to h = {}, before the step h = {step}; from there on the relative residual stays \
         at {residual:.1e}, and {floor:.1e} is accepted; take a smaller step, or give a tolerance",
        rounded(*reached)
    )]
    Rounding {
        /// The step asked for.
        step: f64,
        /// How far it was followed.
        reached: f64,
        /// The relative residual that is left.
        residual: f64,
        /// The largest that is accepted.
        floor: f64,
    },
    /// The iteration did not reach the tolerance.
    #[error(
        "no convergence at h = {step}: residual {residual:e} (relative) after {iterations} iterations, wanted {tolerance:e}"
    )]
    NotConverged {
        /// The step asked for.
        step: f64,
        /// The best relative residual reached.
        residual: f64,
        /// The relative residual wanted.
        tolerance: f64,
        /// Iterations spent.
        iterations: usize,
    },
    /// A stage or the increment left the domain of the retraction.
    #[error("{} left the domain of the retraction at h = {step}: {source}", place(.stage, "the increment of the step"))]
    Domain {
        /// The step asked for.
        step: f64,
        /// The stage (from 0; the message counts from 1), or none for the increment ξ.
        stage: Option<usize>,
        /// What the retraction said.
        source: RetractionError,
    },
    /// Terms of the stage equations that cancel: what is left of them has no digits.
    #[error(
        "ill-conditioned at h = {step}: the terms of the stage equations are {growth:.1e} times the momentum and the impulses, so that rounding \
         decides the result"
    )]
    IllConditioned {
        /// The step asked for.
        step: f64,
        /// The largest term relative to the momentum and the impulses.
        growth: f64,
    },
    /// The force, or the derivative of the Lagrangian by the configuration, has no finite value at a stage.
    #[error("the force at {} has no finite value or derivative at h = {step}{}", place(.stage, "the start of the step"), because(.why))]
    Undefined {
        /// The step asked for.
        step: f64,
        /// The stage (from 0; the message counts from 1), or none for the start of the step.
        stage: Option<usize>,
        /// What of a formula has no value, and where.
        why: Option<String>,
    },
    /// The inverse Legendre transform failed.
    #[error("the inverse Legendre transform failed in a step of h = {step}: {source}")]
    Legendre {
        /// The step asked for.
        step: f64,
        /// What the Lagrangian said.
        source: LegendreError,
    },
    /// A list of stage values of another length than the tableau.
    #[error("{found} stage values, where the tableau has {needed} stages")]
    Stages {
        /// How many there are.
        found: usize,
        /// How many there must be.
        needed: usize,
    },
    /// The stages are close to a fold, where they have no derivative.
    #[error(
        "the derivative of a step of h = {step} has no digits: the Jacobian of its stage equations has the condition number {condition:e}"
    )]
    SingularJacobian {
        /// The step asked for.
        step: f64,
        /// Skeel's condition number of the Jacobian with its columns scaled; infinite where no pivot is left.
        condition: f64,
    },
    /// A variation of another number of parameters.
    #[error("{found} parameters are varied, where there are {needed}")]
    Parameters {
        /// How many there are.
        found: usize,
        /// How many there must be.
        needed: usize,
    },
    /// A NaN or an infinity in the input.
    #[error("{what} is not finite")]
    NotFinite {
        /// `"h"`, `"the momentum"`, `"the attitude"`, `"the time"`, `"the advected parameter"`, `"the derivative of the step"`, ….
        what: &'static str,
    },
    /// An attitude that is not in the group.
    #[error("the attitude is not in the group: its equations are violated by {departure:e}")]
    OffGroup {
        /// By how much; for a quaternion ||q|² − 1|.
        departure: f64,
    },
    /// The method does not apply to the system or the state.
    #[error("unsupported: {why}")]
    Unsupported {
        /// Why, or what a method outside this crate says.
        why: String,
    },
    /// A method outside this crate says that it could not take the step.
    #[error("the method refused a step of h = {step}: {why}")]
    Refused {
        /// The step asked for.
        step: f64,
        /// Its reason.
        why: String,
    },
    /// What a method outside this crate answered is no state: it hung, died, or answered with something else.
    #[error("{why}")]
    NoAnswer {
        /// What it did.
        why: String,
    },
}

impl StepError {
    /// What a failure of Newton's method says of a step of size `step`, after `spent` iterations before it;
    /// `equations` says what it means that these could not be evaluated.
    pub(crate) fn of_newton<T: Real, E>(
        failure: Failure<T, E>,
        step: f64,
        settings: &NewtonSettings<T>,
        spent: usize,
        equations: impl FnOnce(E) -> Self,
    ) -> Self {
        match failure {
            Failure::Fold { fraction, determinant } => {
                Self::Fold { step, fold: fraction.to_f64() * step, determinant: determinant.to_f64() }
            }
            Failure::TooLong { fraction } => Self::TooLong { step, reached: fraction.to_f64() * step },
            Failure::Rounding { fraction, residual } => Self::Rounding {
                step,
                reached: fraction.to_f64() * step,
                residual: residual.to_f64(),
                floor: settings.floor.to_f64(),
            },
            Failure::NotConverged(outcome) => Self::NotConverged {
                step,
                residual: outcome.residual.to_f64(),
                tolerance: settings.tolerance.to_f64(),
                iterations: outcome.iterations + spent,
            },
            Failure::Equations(error) => equations(error),
        }
    }
}

/// A one-step method: the core trait; trajectories, order studies and laws are derived from it.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::group::So3;
/// use euler_poincare::integrators::trajectory::{Totals, TrajectoryError, integrate};
/// use euler_poincare::integrators::variational::Settings;
/// use euler_poincare::integrators::{Classical, OneStep, Report, Solver, StagePoint, State, StepError, Variational};
/// use euler_poincare::mechanics::equations::EulerPoincare;
/// use euler_poincare::mechanics::{force::Zero, lagrangian::Quadratic};
/// use euler_poincare::retraction::{CayleySo3, Retraction};
/// use euler_poincare::tableau::{Classic, Family};
///
/// /// Two half steps of another method: a method of one's own needs `step` alone.
/// struct Halved<M>(M);
///
/// impl<M: OneStep<f64, 3, 3>> OneStep<f64, 3, 3> for Halved<M> {
///     fn step(&mut self, state: &mut State<f64, 3, 3>, h: f64) -> Result<Report<f64>, StepError> {
///         let mut half = state.clone();
///         let first = self.0.step(&mut half, 0.5 * h)?;
///         let second = self.0.step(&mut half, 0.5 * h)?;
///         *state = half; // on an error the state stays as it was
///         Ok(Report { iterations: first.iterations + second.iterations, ..second })
///     }
/// }
///
/// let body = Quadratic::diagonal([1.0, 2.0, 3.0])?;
/// let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.4, 0.1, 0.7), attitude: Matrix::identity() };
///
/// // Trajectories take any method; here one that solves its equations to 1e-10 only.
/// let settings = Settings { tolerance: 1e-10, ..Settings::default() };
/// let gauss = Family::Gauss.tableau(2)?;
/// let variational = Variational::with_settings(body.clone(), Zero, CayleySo3::new(), gauss.clone(), settings);
/// let (mut method, mut state) = (Halved(variational), start.clone());
/// let totals: Totals<f64> = integrate(&mut method, &mut state, 0.1, 10, |_, _, _| {})?;
/// assert!(totals.steps == 10 && totals.residual < 1e-9);
/// assert!((state.momentum.norm() - start.momentum.norm()).abs() < 1e-9, "without force |μ| is kept");
///
/// // A Runge–Kutta method on (μ, g) for comparison: it leaves the group.
/// let equations = EulerPoincare::new(CayleySo3::<f64>::new().algebra().clone(), body.clone(), Zero);
/// let mut classical = Classical::new(equations, Some(So3::new()), Classic::Rk4.tableau()?);
/// let report = classical.step(&mut start.clone(), 0.1)?;
/// assert_eq!(report.solver, Solver::Explicit);
///
/// // A variational method tells the stages of its last step: where the force acts, and with which weight.
/// let mut variational = Variational::new(body, Zero, CayleySo3::new(), gauss);
/// variational.step(&mut start.clone(), 0.1)?;
/// let stages: Vec<StagePoint<f64, 3, 3>> = variational.stages().expect("a step was taken");
/// assert!((stages.iter().map(|stage| stage.weight).sum::<f64>() - 1.0).abs() < 1e-15);
///
/// // A step that is too long has no solution, and says so.
/// let refused: Result<_, TrajectoryError> = integrate(&mut variational, &mut start.clone(), 100.0, 3, |_, _, _| {});
/// assert!(matches!(refused.unwrap_err().source, StepError::Fold { .. } | StepError::TooLong { .. } | StepError::NotConverged { .. } | StepError::Domain { .. }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait OneStep<T: Real, const N: usize, const D: usize> {
    /// Replaces `state` by the state after a step of size `h` (of either sign); on an error `state` is unchanged.
    ///
    /// # Errors
    /// See [`StepError`]: folds, non-convergence, leaving the retraction's domain, non-finite input.
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError>;

    /// The stages of the last step of a method whose spatial momentum changes by the impulses there, as the forced discrete Noether
    /// theorem says: Ad*_{g'⁻¹} μ' − Ad*_{g⁻¹} μ = h Σ_j b_j Ad*_{g_j⁻¹} (f + ∂_gL)(t_j, g_j, η_j). `None` for other methods, and before
    /// the first step. The law `method-noether` asks for them.
    fn stages(&self) -> Option<Vec<StagePoint<T, N, D>>> {
        None
    }
}

/// Where the force acts within a step from (t, g) of size h.
#[derive(Clone, Debug, PartialEq)]
pub struct StagePoint<T: Real, const N: usize, const D: usize> {
    /// b_j.
    pub weight: T,
    /// c_j: t_j = t + c_j h.
    pub node: T,
    /// g⁻¹ g_j, D×D; of the variational method τ(Ξ_j).
    pub turn: Matrix<T, D>,
    /// η_j.
    pub velocity: Vector<T, N>,
}
