//! Newton's method on the stage equations: their root is followed from h = 0.

use super::jacobian::Jacobian;
use super::parts::Mechanics;
use super::work::{Factors, Problem, Work};
use super::{HARMLESS_GROWTH, Settings, Variational};
use crate::algebra::{LieAlgebra, Vector};
use crate::integrators::{Report, Solver, StepError};
use crate::mechanics::{Force, Lagrangian};
use crate::newton::{self, Equations};
use crate::retraction::Retraction;
use crate::scalar::{Real, larger};
use crate::tableau::Tableau;
use nalgebra::DMatrix;

/// Displacements between two points of a continuation differ by no more than this, in ‖ad‖: dτ changes at distances of 1, and a fold next to where it
/// is singular is narrower. At 1.8 one was stepped over where a stage passed |Ξ| = 6π (case 31328 of seed 998021 of the law `branch`).
const LARGEST_TURN: (i64, i64) = (1, 4);

/// r(H) = 0 with the fraction of the step as parameter.
struct StageEquations<'a, T: Real, const N: usize, const D: usize> {
    mechanics: Mechanics<'a, T, N, D>,
    problem: Problem<T, N, D>,
    work: &'a mut Work<T, N>,
    jacobian: &'a mut Jacobian<T, N>,
    full: T,
    /// The most that residuals are relative to.
    most: T,
}

impl<T: Real, const N: usize, const D: usize> StageEquations<'_, T, N, D> {
    fn set_rates(&mut self, x: &[T]) {
        for i in 0..self.mechanics.coefficients.tableau.stages() {
            self.work.rates.set_vector(i, &Vector::from_fn(|a, _| x[i * N + a]));
        }
    }
}

impl<T: Real, const N: usize, const D: usize> Equations<T> for StageEquations<'_, T, N, D> {
    type Error = StepError;

    fn dimension(&self) -> usize {
        self.mechanics.coefficients.tableau.stages() * N
    }

    fn set_fraction(&mut self, fraction: T) {
        self.problem.step = fraction * self.full;
    }

    fn residual(&mut self, x: &[T], out: &mut [T]) -> Result<T, StepError> {
        self.set_rates(x);
        let size = self.mechanics.residual(&self.problem, self.work)?;
        for (k, value) in out.iter_mut().enumerate() {
            *value = self.work.residuals.get(k / N, k % N);
        }
        Ok(if size > self.most { self.most } else { size })
    }

    fn jacobian(&mut self, x: &[T], out: &mut DMatrix<T>) -> Result<(), StepError> {
        self.set_rates(x);
        let Self { mechanics, problem, work, jacobian, .. } = self;
        mechanics.jacobian(problem, &work.rates, jacobian, (out, None), &mut |_, _, _| Ok(())).map(|_| ())
    }

    /// The largest ‖ad‖ of a change of Ξ_i or ξ, in the unit [`LARGEST_TURN`].
    fn distance(&self, from: (T, &[T]), to: (T, &[T])) -> Option<T> {
        let moved = |j: usize, a: usize| (to.0 * to.1[j * N + a] - from.0 * from.1[j * N + a]) * self.full;
        Some(turn::<T, N>(&self.mechanics.coefficients.tableau, self.mechanics.parts.algebra(), moved))
    }
}

/// The largest ‖ad‖ of Σ_j a_ij x_j and Σ_j b_j x_j, in the unit [`LARGEST_TURN`]; component a of x_j is `rate`(j, a).
pub(crate) fn turn<T: Real, const N: usize>(
    tableau: &Tableau<T>,
    algebra: &LieAlgebra<T, N>,
    rate: impl Fn(usize, usize) -> T,
) -> T {
    let s = tableau.stages();
    let weight = |i: usize, j: usize| if i < s { tableau.a()[(i, j)] } else { tableau.b()[j] };
    let turned = |i: usize| {
        let x = Vector::from_fn(|a, _| (0..s).fold(T::zero(), |sum, j| sum + rate(j, a) * weight(i, j)));
        let rows = algebra.ad(&x);
        rows.row_iter().map(|row| row.iter().fold(T::zero(), |sum, v| sum + v.abs())).fold(T::zero(), larger)
    };
    (0..=s).map(turned).fold(T::zero(), larger) / T::ratio(LARGEST_TURN.0, LARGEST_TURN.1)
}

impl<T, const N: usize, const D: usize, L, F, R> Variational<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// Newton's method on r(H) along h: at the full step at once it may find a root that does not continue from h = 0.
    pub(super) fn newton(
        &mut self,
        problem: &Problem<T, N, D>,
        eta: &Vector<T, N>,
        spent: usize,
    ) -> Result<Report<T>, StepError> {
        let (step, factor) = (problem.step.to_f64(), self.work.factors.as_ref().map_or(T::one(), Factors::most));
        for (i, v) in self.unknowns.iter_mut().enumerate() {
            *v = eta[i % N];
        }
        let settings = newton::NewtonSettings {
            tolerance: (self.settings.tolerance / factor).max(Settings::<T>::default().tolerance),
            floor: self.settings.floor,
            max_iterations: self.settings.max_iterations,
        };
        let mechanics = self.scheme.mechanics();
        let mut equations = StageEquations {
            mechanics,
            problem: *problem,
            work: &mut self.work,
            jacobian: &mut self.jacobian,
            full: problem.step,
            most: T::exact(f64::MAX),
        };
        equations.set_rates(&self.unknowns);
        // Where a stage is outside the domain there, the continuation says what that means.
        if let Ok(first) = mechanics.residual(problem, equations.work)
            && first > T::zero()
        {
            equations.most = first * T::int(HARMLESS_GROWTH);
        }
        let outcome = self.newton.follow(&mut equations, &mut self.unknowns, &settings);
        let refused = |failure| StepError::of_newton(failure, step, &settings, spent, |error| error);
        let outcome = outcome.map_err(refused)?;
        // Leave the stages of the root in the workspace.
        equations.set_fraction(T::one());
        equations.set_rates(&self.unknowns);
        mechanics.residual(problem, &mut self.work)?;
        let solver = if outcome.shortened { Solver::Continuation } else { Solver::Newton };
        Ok(Report { solver, iterations: outcome.iterations + spent, residual: outcome.residual * factor })
    }
}
