//! A step that was taken: what the states between its ends are made from.

use super::measure::Measure;
use super::through::{Rates, Through};
use crate::algebra::{Covector, Vector};
use crate::integrators::variational::{Exchange, Variational};
use crate::integrators::{State, StepError};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::{Real, finite};

/// What is known at one state.
#[derive(Clone, Debug)]
pub(super) struct Point<T: Real, const N: usize, const D: usize> {
    pub state: State<T, N, D>,
    /// η.
    pub velocity: Vector<T, N>,
    /// ∂_gL + f.
    pub force: Covector<T, N>,
    /// |∂_gL| + |f|, of each coordinate: they cancel at equilibria.
    pub load: Covector<T, N>,
}

impl<T: Real, const N: usize, const D: usize> Point<T, N, D> {
    /// Nothing is known yet.
    pub fn new(state: &State<T, N, D>) -> Self {
        let zero = Covector::zeros();
        Self { state: state.clone(), velocity: Vector::zeros(), force: zero, load: zero }
    }
}

/// The stages of a step.
#[derive(Clone, Debug)]
pub(super) struct Stages<T: Real, const N: usize> {
    /// The size of the step, with sign.
    pub step: T,
    /// ξ.
    pub increment: Vector<T, N>,
    /// Ξ_i.
    pub displacements: Vec<Vector<T, N>>,
    /// η_i.
    pub velocities: Vec<Vector<T, N>>,
    /// (ξ̇, ṁ) at the stages.
    pub rates: Vec<Rates<T, N>>,
    /// η at both ends.
    pub ends: [Vector<T, N>; 2],
}

impl<T: Real, const N: usize> Stages<T, N> {
    pub fn new(stages: usize) -> Self {
        let zero = Vector::zeros();
        Self {
            step: T::zero(),
            increment: zero,
            displacements: vec![zero; stages],
            velocities: vec![zero; stages],
            rates: vec![(zero, Covector::zeros()); stages],
            ends: [zero; 2],
        }
    }
}

/// A step, with the equations that it solves.
pub(super) struct Passed<'p, T: Real, const N: usize, const D: usize, L, F, R> {
    pub method: &'p Variational<T, N, D, L, F, R>,
    pub start: &'p Point<T, N, D>,
    pub end: &'p Point<T, N, D>,
    pub stages: &'p Stages<T, N>,
    /// Through these stages and the ends.
    pub through: &'p Through<T>,
    /// What errors are relative to.
    pub measure: &'p Measure<T, N>,
}

impl<T, const N: usize, const D: usize, L, F, R> Variational<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// Evaluates the equations at a point.
    pub(super) fn look(&self, point: &mut Point<T, N, D>, guess: &Vector<T, N>, step: T) -> Result<(), StepError> {
        let velocity = self.velocity_at(&point.state, guess, step)?;
        let (force, load) = self.force_at(&point.state, &velocity, step)?;
        (point.velocity, point.force, point.load) = (velocity, force, load);
        Ok(())
    }

    /// The energy taken up in a unit of time at a state, whose velocity is next to `guess`.
    pub(super) fn power(
        &self,
        state: &State<T, N, D>,
        guess: &Vector<T, N>,
        step: T,
    ) -> Result<Exchange<T>, StepError> {
        let velocity = self.velocity_at(state, guess, step)?;
        Ok(Exchange::rates(self.lagrangian(), self.force(), state, &velocity))
    }

    /// ∂L/∂η at (t, g, η).
    pub(super) fn momentum_at(&self, state: &State<T, N, D>, velocity: &Vector<T, N>) -> Covector<T, N> {
        self.lagrangian().gradient_at(state.time, Configuration::of(&state.attitude), velocity)
    }

    /// The η with ∂L/∂η(t, g, η) = μ.
    pub(super) fn velocity_at(
        &self,
        state: &State<T, N, D>,
        guess: &Vector<T, N>,
        step: T,
    ) -> Result<Vector<T, N>, StepError> {
        let here = Configuration::of(&state.attitude);
        let found = self.lagrangian().velocity_at(state.time, here, &state.momentum, guess);
        found.map_err(|source| StepError::Legendre { step: step.to_f64(), source })
    }

    /// Whether there is a force, f or that of a potential.
    pub(super) fn forced(&self) -> bool {
        !self.force().is_zero() || self.lagrangian().uses_configuration()
    }

    /// ∂_gL + f at (t, g, η), and |∂_gL| + |f| of each coordinate.
    pub(super) fn force_at(
        &self,
        state: &State<T, N, D>,
        velocity: &Vector<T, N>,
        step: T,
    ) -> Result<(Covector<T, N>, Covector<T, N>), StepError> {
        let (lagrangian, force, here) = (self.lagrangian(), self.force(), Configuration::of(&state.attitude));
        if !self.forced() {
            return Ok((Covector::zeros(), Covector::zeros()));
        }
        let mut total = force.force_at(state.time, here, velocity);
        let mut load = total.map(|v| v.abs());
        if lagrangian.uses_configuration() {
            let gradient = lagrangian.configuration_gradient(state.time, here, velocity);
            load += gradient.map(|v| v.abs());
            total += gradient;
        }
        if finite(total.as_slice()) {
            return Ok((total, load));
        }
        let why =
            force.undefined(state.time, here, velocity).or_else(|| lagrangian.undefined(state.time, here, velocity));
        let stage = Some(self.tableau().stages() - 1);
        Err(StepError::Undefined { step: step.to_f64(), stage, why })
    }
}
