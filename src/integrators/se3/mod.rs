//! The forced variational step on SE(3), fast: eight stages in the lanes of a register.
//!
//! [`VariationalSe3`] takes the same step as [`super::Variational`] with the Cayley map of
//! [`crate::algebra::catalogue::Entry::Se3`] (rotations first, then translations), to round-off, for a quadratic
//! Lagrangian and a [`LaneForce`]. The iteration, the fallback on Newton's method and the compensated sums are those
//! of [`super::so3`]; [`AdaptiveSe3`] chooses order and steps for a tolerance.
//!
//! Sources: Martín de Diego and Sato Martín de Almagro 2019, §5.2; Bou-Rabee and Marsden 2009 (the Cayley map on SE(3)).

mod adaptive;
#[doc(hidden)]
pub mod retraction;

pub use super::so3::step::UnfitTableau;
pub use super::so3::{ByLane, Drag, Free, LaneAttitude, LaneForce, LaneForceError, SolveError, Solved, Term, Terms};
pub use adaptive::AdaptiveSe3;
pub use retraction::CayleySe3;

use super::so3::step::VariationalInLanes;

/// Six components, each in lanes: of ω, then of v.
#[doc(hidden)]
pub type Vec6<V> = [V; 6];

/// The forced variational step on SE(3) with all stages in the lanes of a register.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::se3::{CayleySe3, Drag, Term, Terms, VariationalSe3};
/// use euler_poincare::integrators::{OneStep, State};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::tableau::Family;
///
/// let body = Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25])?;
/// let drag = Terms(vec![Term::LinearDrag(Drag::Diagonal([0.125; 6]))]);
/// let mut method = VariationalSe3::new(body, drag, CayleySe3::new(), Family::Gauss.tableau(3)?)?;
/// let momentum = Covector::from([0.5, -0.25, 1.0, 1.0, 0.5, -0.5]);
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::identity() };
/// method.step(&mut state, 0.125)?;
/// assert!(state.momentum.norm() < momentum.norm());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub type VariationalSe3<F> = VariationalInLanes<F, CayleySe3, 6, 4>;
