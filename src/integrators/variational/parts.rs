//! What the equations of a step ask of l, f and τ, behind objects: what is built on these is compiled once for each T, N and D, and not again
//! for each Lagrangian, force and retraction. Fixed-point iterations, which most steps are, know the types.

use super::{Coefficients, HARMLESS_GROWTH, Problem, Scheme, Work, domain, largest, relative};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, times};
use crate::integrators::StepError;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Dual, Real, Scalar, larger};

/// What is done with the tangents of τ at a point.
type With<'a, S, const N: usize> = &'a mut dyn FnMut(&dyn TangentPoint<S, N>);

/// l, f and τ over one scalar.
pub(super) trait Parts<S: Scalar, const N: usize, const D: usize> {
    /// τ(x).
    fn tau(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError>;

    /// g τ(x).
    #[inline(always)]
    fn attitude(&self, g: &Matrix<S::Base, D>, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        Ok(times(&g.map(S::lift), &self.tau(x)?))
    }

    /// Hands on the tangents at x.
    fn at(&self, x: &Vector<S, N>, then: With<'_, S, N>) -> Result<(), RetractionError>;

    /// ∂L/∂η, l'(η) where nothing depends on the configuration.
    fn momentum(&self, time: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N>;

    /// ∂_gL + f, and where they depend on the configuration the size of both: they cancel at equilibria.
    fn total_force(&self, time: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> (Covector<S, N>, S::Base);
}

/// l, f and τ over T and its dual numbers.
pub(super) trait Mechanism<T: Real, const N: usize, const D: usize>:
    Parts<T, N, D> + Parts<Dual<T>, N, D>
{
    fn algebra(&self) -> &LieAlgebra<T, N>;

    /// Why the force is not finite.
    fn undefined(
        &self,
        stage: Option<usize>,
        step: T,
        time: T,
        g: Configuration<'_, T>,
        eta: &Vector<T, N>,
    ) -> StepError;
}

impl<T, S, const N: usize, const D: usize, L, F, R> Parts<S, N, D> for Scheme<T, N, D, L, F, R>
where
    T: Real,
    S: Scalar<Base = T>,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    #[inline(always)]
    fn tau(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        self.retraction.tau(x)
    }

    fn at(&self, x: &Vector<S, N>, then: With<'_, S, N>) -> Result<(), RetractionError> {
        then(&self.retraction.at(x)?);
        Ok(())
    }

    fn momentum(&self, time: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        match self.moves {
            true => self.lagrangian.gradient_at(time, g, eta),
            false => self.lagrangian.gradient(eta),
        }
    }

    #[inline(always)]
    fn total_force(&self, time: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> (Covector<S, N>, T) {
        if !self.moves {
            return (self.force.force(time, eta), T::zero());
        }
        let force = self.force.force_at(time, g, eta);
        if !self.lagrangian.uses_configuration() {
            return (force, largest(&force));
        }
        let gradient = self.lagrangian.configuration_gradient(time, g, eta);
        (force + gradient, largest(&force) + largest(&gradient))
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Mechanism<T, N, D> for Scheme<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    fn algebra(&self) -> &LieAlgebra<T, N> {
        self.retraction.algebra()
    }

    #[cold]
    fn undefined(
        &self,
        stage: Option<usize>,
        step: T,
        time: T,
        g: Configuration<'_, T>,
        eta: &Vector<T, N>,
    ) -> StepError {
        let why = self.force.undefined(time, g, eta).or_else(|| self.lagrangian.undefined(time, g, eta));
        StepError::Undefined { step: step.to_f64(), stage, why }
    }
}

/// The equations of a step.
#[derive(Clone, Copy)]
pub(super) struct Mechanics<'a, T: Real, const N: usize, const D: usize> {
    pub coefficients: &'a Coefficients<T>,
    pub moves: bool,
    pub forced: bool,
    pub parts: &'a dyn Mechanism<T, N, D>,
}

impl<T, const N: usize, const D: usize, L, F, R> Scheme<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    pub fn mechanics(&self) -> Mechanics<'_, T, N, D> {
        Mechanics { coefficients: &self.coefficients, moves: self.moves, forced: self.forced, parts: self }
    }
}

impl<'a, T: Real, const N: usize, const D: usize> Mechanics<'a, T, N, D> {
    /// What `then` makes of the tangents at x; an error is one of stage i.
    pub fn with<S: Scalar<Base = T>, O>(
        &self,
        (i, step): (Option<usize>, T),
        x: &Vector<S, N>,
        mut then: impl FnMut(&dyn TangentPoint<S, N>) -> O,
    ) -> Result<O, StepError>
    where
        dyn Mechanism<T, N, D> + 'a: Parts<S, N, D>,
    {
        let mut made = None;
        self.parts.at(x, &mut |point| made = Some(then(point))).map_err(|e| domain(step, i, e))?;
        made.ok_or(StepError::NotFinite { what: "the tangents of the retraction" })
    }

    /// g τ(x) where anything depends on it.
    pub fn placed<S: Scalar<Base = T>>(
        &self,
        problem: &Problem<T, N, D>,
        x: &Vector<S, N>,
    ) -> Result<Matrix<S, D>, RetractionError>
    where
        dyn Mechanism<T, N, D> + 'a: Parts<S, N, D>,
    {
        if self.moves { self.parts.attitude(&problem.attitude, x) } else { Ok(Matrix::identity()) }
    }

    /// The same as a Lagrangian and a force see it.
    pub fn configuration<'g, S: Scalar<Base = T>>(&self, attitude: &'g Matrix<S, D>) -> Configuration<'g, S> {
        if self.moves { Configuration::of(attitude) } else { Configuration::identity() }
    }

    /// The largest term of the stage equations relative to the momentum, the forces and the momentum of a rotor, where it is large: |P_i|,
    /// |m dτ(−ξ)| and transported forces grow like e^{|ad_ξ|}, and cancel.
    pub fn growth(&self, problem: &Problem<T, N, D>, work: &Work<T, N>, d_neg: &Matrix<T, N>) -> T {
        let tableau = &self.coefficients.tableau;
        let share = |j: usize| (tableau.b()[j] * problem.step).abs();
        let mut terms = largest(&work.after_impulse).max(largest(&(work.after_impulse * d_neg)));
        for j in 0..tableau.stages() {
            let impulse = largest(&work.impulses.covector(j)) * share(j);
            terms = larger(terms, larger(largest(&work.momenta.covector(j)), impulse));
        }
        let momentum = largest(&problem.momentum);
        if terms <= momentum * T::int(HARMLESS_GROWTH) {
            return T::zero();
        }
        let here = Configuration::of(&problem.attitude);
        let mut scale = momentum + largest(&self.parts.momentum(problem.time, here, &Vector::zeros()));
        for j in 0..tableau.stages() {
            // Without a group nothing depends on the attitude.
            let at = self.parts.attitude(&problem.attitude, &work.displacements.vector(j));
            let at = at.unwrap_or(problem.attitude);
            let time = problem.time + tableau.c()[j] * problem.step;
            let force = self.parts.total_force(time, Configuration::of(&at), &work.velocities.vector(j));
            scale += largest(&force.0) * share(j);
        }
        relative(terms, scale)
    }
}
