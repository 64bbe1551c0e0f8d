//! What residuals are relative to: near an equilibrium, and where an iteration runs away.
//!
//! At an equilibrium the terms of a single force cancel, as those of −c × Γ where Γ is along c. What is left of a motion that dies out there
//! is at last less than what rounding of g makes of the force, of which neither μ nor the force tells. To first order that is u times the
//! [`sensitivity`]. A step that does not contract is
//! tried again with residuals relative to it; the steps after it begin so.

use super::{HARMLESS_GROWTH, NotContracted, Problem, Settings, Variational, largest};
use crate::algebra::{Matrix, Vector};
use crate::integrators::{Report, State};
use crate::mechanics::equations::sensitivity;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::Real;

/// What residuals are relative to where an iteration starts. Where it runs away the terms of the equations grow with it, so that a residual
/// relative to them says nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct FirstScale<T>(Option<T>);

impl<T: Real> FirstScale<T> {
    pub fn unknown() -> Self {
        Self(None)
    }

    /// Whether an iteration whose terms have this size has left the size that they had first.
    pub fn is_left(&mut self, scale: T) -> bool {
        let first = *self.0.get_or_insert(scale);
        scale > first * T::int(HARMLESS_GROWTH)
    }
}

impl<T: Real, const N: usize, const D: usize> Problem<T, N, D> {
    /// Whether residuals are relative to what rounding makes of the forces, not to the momentum.
    pub(super) fn rounds(&self) -> bool {
        self.rounding * self.step.abs() > largest(&self.momentum)
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Variational<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// Fixed-point iterations; where they do not contract with residuals relative to the momentum and the forces, again with residuals relative
    /// to what rounding makes of the forces, where that is more.
    pub(super) fn iterate_stages(
        &mut self,
        problem: &mut Problem<T, N, D>,
        eta: &Vector<T, N>,
    ) -> Result<Report<T>, NotContracted> {
        let known = std::mem::take(&mut self.rounded) && self.scheme.moves;
        if known {
            problem.rounding = self.rounding(problem, eta);
        }
        self.start(problem, eta);
        self.last = None;
        let solved = self.fixed_point(problem);
        let Err(NotContracted(spent)) = solved else { return solved };
        if known || !self.scheme.moves {
            return Err(NotContracted(spent));
        }
        problem.rounding = self.rounding(problem, eta);
        if !problem.rounds() {
            return Err(NotContracted(spent));
        }
        self.start(problem, eta);
        match self.fixed_point(problem) {
            Ok(report) => Ok(Report { iterations: report.iterations + spent, ..report }),
            Err(NotContracted(more)) => Err(NotContracted(spent + more)),
        }
    }

    /// [`Problem::rounding`]: the default tolerance times it is what rounding of g makes of the forces.
    fn rounding(&self, problem: &Problem<T, N, D>, eta: &Vector<T, N>) -> T {
        // Of a tolerance below the default, too: all of the forces would be rounding.
        let default = Settings::<T>::default().tolerance;
        let share = default / default.max(self.settings.tolerance);
        self.sensitivity_at(problem.time, &problem.attitude, eta) * share
    }

    /// Whether anything in the last step could depend on the configuration.
    pub(in crate::integrators) fn moves(&self) -> bool {
        self.scheme.moves
    }

    /// How much the forces at (t, g, η) change where the entries of g do: Σ |∂F/∂g_rc| |g_rc|, of which rounding makes u times as much.
    pub(in crate::integrators) fn sensitivity(&self, state: &State<T, N, D>, velocity: &Vector<T, N>) -> T {
        self.sensitivity_at(state.time, &state.attitude, velocity)
    }

    fn sensitivity_at(&self, time: T, attitude: &Matrix<T, D>, velocity: &Vector<T, N>) -> T {
        sensitivity(&self.scheme.lagrangian, &self.scheme.force, time, attitude, velocity)
    }

    /// The same, where it decided when the last step was solved.
    #[cfg(feature = "lanes")]
    pub(in crate::integrators) fn rounded(&self, state: &State<T, N, D>) -> Option<T> {
        let velocity = self.work.velocities.vector(0);
        self.rounded.then(|| self.sensitivity(state, &velocity))
    }
}
