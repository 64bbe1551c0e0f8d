//! Newton's iteration at one parameter, on a workspace.

use super::lu::{Determinant, factor, solve_factored};
use super::{Equations, Failure, NewtonSettings, Outcome};
use crate::scalar::{Real, max_abs};
use nalgebra::DMatrix;

/// Corrections that shrink by this factor need no new Jacobian: one of the stages costs some five residuals for each dimension, which are
/// worth some ten digits or more.
const FAST: f64 = 1.0 / 16.0;

/// The workspace of the iteration.
#[derive(Clone, Debug)]
pub(super) struct Iteration<T: Real> {
    /// The Jacobian, or its factors.
    pub matrix: DMatrix<T>,
    pivots: Vec<usize>,
    /// The last Jacobian, before it was factored.
    pub whole: DMatrix<T>,
    pub residual: Vec<T>,
    /// The last correction, or whatever else was solved for.
    pub trial: Vec<T>,
}

/// What one corrected point looks like.
pub(super) struct Corrected<T> {
    pub outcome: Outcome<T>,
    pub determinant: Determinant<T>,
    /// Jacobians that were needed: the fewer, the faster the iteration contracted.
    pub jacobians: usize,
}

impl<T: Real> Iteration<T> {
    pub fn new(dimension: usize) -> Self {
        Self {
            matrix: DMatrix::zeros(dimension, dimension),
            pivots: vec![0; dimension],
            whole: DMatrix::zeros(dimension, dimension),
            residual: vec![T::zero(); dimension],
            trial: vec![T::zero(); dimension],
        }
    }

    /// The Jacobian at x, factored and whole; `None` where it is singular.
    pub fn factor_at<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        x: &[T],
    ) -> Result<Option<Determinant<T>>, E> {
        equations.jacobian(x, &mut self.matrix)?;
        self.whole.copy_from(&self.matrix);
        Ok(self.factor())
    }

    /// Newton's iteration at the present parameter; every correction must be at most half the one before.
    ///
    /// A Jacobian costs as much as many residuals: the factors are kept while each correction is at most [`FAST`] times the one
    /// before, where det J does not change its sign on the way. The error of what is found is then not squared by the last correction,
    /// so one more is made after the tolerance is met.
    pub fn correct<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        x: &mut [T],
        settings: &NewtonSettings<T>,
    ) -> Result<Corrected<T>, Failure<T, E>> {
        let mut determinant = None;
        let mut last_correction = None;
        let mut best = T::zero();
        let (mut frozen, mut met, mut jacobians) = (false, false, 0);
        for iterations in 0..=settings.max_iterations {
            let size = equations.residual(x, &mut self.residual).map_err(Failure::Equations)?;
            let residual = max_abs(&self.residual);
            // 0/0 is a residual of zero: a system at rest without forces.
            let relative = if residual == T::zero() { T::zero() } else { residual / size };
            let outcome = Outcome { iterations, residual: relative, shortened: false };
            if !relative.all_finite() {
                return Err(Failure::NotConverged(outcome));
            }
            let stagnates = iterations > 1 && relative * T::exact(2.0) >= best;
            let within = relative <= settings.tolerance;
            let solved = (within && (met || !frozen)) || (stagnates && relative <= settings.floor);
            met = within;
            best = if iterations == 0 { relative } else { best.min(relative) };
            if let (true, Some(determinant)) = (solved, determinant) {
                return Ok(Corrected { outcome, determinant, jacobians });
            }
            if iterations == settings.max_iterations {
                return Err(Failure::NotConverged(outcome));
            }
            let shrunk = |correction: T, share: T| last_correction.is_none_or(|last: T| correction <= last * share);
            let mut correction = T::zero();
            // In the second half of the iterations that are allowed each has to count.
            frozen = determinant.is_some() && (met || 2 * iterations < settings.max_iterations) && {
                correction = self.correction();
                met || shrunk(correction, T::exact(FAST))
            };
            if !frozen {
                let Some(factored) = self.factor_at(equations, x).map_err(Failure::Equations)? else {
                    return Err(Failure::NotConverged(outcome));
                };
                determinant = Some(factored);
                jacobians += 1;
                correction = self.correction();
            }
            // Corrections at the level of rounding need not contract any more.
            let grows = !shrunk(correction, T::half()) || !correction.all_finite();
            if grows && relative > settings.floor {
                return Err(Failure::NotConverged(outcome));
            }
            last_correction = Some(correction);
            for (v, d) in x.iter_mut().zip(&self.trial) {
                *v -= *d;
            }
        }
        Err(Failure::NotConverged(Outcome { iterations: settings.max_iterations, residual: best, shortened: false }))
    }

    /// LU factors of the matrix, in place.
    pub fn factor(&mut self) -> Option<Determinant<T>> {
        factor(&mut self.matrix, &mut self.pivots)
    }

    /// `trial` ← J⁻¹ `residual`; its largest component.
    pub fn correction(&mut self) -> T {
        self.trial.copy_from_slice(&self.residual);
        self.back_substitute();
        max_abs(&self.trial)
    }

    /// `trial` ← J⁻¹ `trial`.
    pub fn back_substitute(&mut self) {
        solve_factored(&self.matrix, &self.pivots, &mut self.trial);
    }
}
