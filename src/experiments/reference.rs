//! M(T), E(T) and C(T) to 30 digits, computed here and compared with stored digits.

use super::{ExperimentError, Problem};
use crate::algebra::Covector;
use crate::group::so3::So3;
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::models::Model;
use crate::mechanics::{Force, Lagrangian, LegendreError};
use crate::scalar::{Dd, Real, Scalar, max_abs};
use crate::study::reference::after;

/// Stages of the Gauss method: order 24.
const STAGES: usize = 12;
/// Steps in [0, T] of the coarse solution; the fine one takes twice as many.
const STEPS: usize = 16;
/// The largest difference of a component, of numbers below 1.
const BOUND: f64 = 1e-30;

/// The solution of a problem at T.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Reference {
    /// Which problem.
    pub problem: Problem,
    /// The problem, with its system.
    pub model: Model<Dd>,
    /// M(T).
    pub momentum: Covector<Dd, 3>,
    /// E(T) = ½⟨M, Ω⟩.
    pub energy: Dd,
    /// C(T) = |M|².
    pub casimir: Dd,
}

impl Reference {
    /// Solves M' = M × Ω + f with Gauss's method of order 24 on M itself, in 32 digits, at two resolutions.
    ///
    /// The solution shares neither the scheme nor a retraction with the integrators that are measured against it.
    ///
    /// # Errors
    /// [`ExperimentError::Reference`] when the two resolutions, or the result and the stored 40 digits, differ by more
    /// than 10⁻³⁰.
    pub fn compute(problem: Problem) -> Result<Self, ExperimentError> {
        let model = problem.model::<Dd>();
        let start = problem.state::<Dd>();
        let exact = after(&model.system, None::<&So3<Dd>>, &start, model.horizon, STEPS, STAGES)?;
        let momentum = exact.state.momentum;
        agree(problem, exact.reference_error.0, "from the solution with twice the step")?;
        let stored = model.reference_momentum().unwrap_or_else(|| Covector::from([Dd::exact(f64::NAN); 3]));
        agree(problem, max_abs(&(momentum - stored)), "from the stored digits")?;
        let (energy, casimir) = (energy(&model.system, &momentum)?, casimir(&momentum));
        Ok(Self { problem, model, momentum, energy, casimir })
    }
}

fn agree(problem: Problem, difference: Dd, against: &'static str) -> Result<(), ExperimentError> {
    let defect = difference.to_f64();
    // The comparison that a NaN fails.
    if defect <= BOUND {
        return Ok(());
    }
    Err(ExperimentError::Reference { problem: problem.name(), defect, against, bound: BOUND })
}

/// E = ⟨M, Ω⟩ − l(Ω) with Ω = (l')⁻¹(M).
///
/// # Errors
/// Those of the inverse Legendre transform.
pub fn energy<T: Real, L: Lagrangian<T, 3>, F: Force<T, 3>>(
    system: &EulerPoincare<T, 3, L, F>,
    momentum: &Covector<T, 3>,
) -> Result<T, LegendreError> {
    system.hamiltonian(momentum, &crate::algebra::Vector::<T, 3>::zeros())
}

/// C = |M|².
pub fn casimir<T: Real>(momentum: &Covector<T, 3>) -> T {
    momentum.iter().fold(T::zero(), |sum, &m| sum + m * m)
}
