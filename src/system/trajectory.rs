//! One system from its initial state on, whatever its dimension: rows of plain numbers, for who writes or draws them.

use super::case::Case;
use super::dispatch::System;
use crate::algebra::{Casimir, Vector};
use crate::integrators::variational::Exchange;
use crate::integrators::{OneStep, State, Variational};
use crate::mechanics::Lagrangian;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::scalar::Real;
use std::ops::ControlFlow;

pub use crate::integrators::solve::{End, Statistics};
pub use crate::integrators::trajectory::Totals;

/// A row.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a, T> {
    /// t; μ, n numbers; η, n; the energy ⟨∂L/∂η, η⟩ − L; the work of the force, ∫⟨f, η⟩ dt by the method's own quadrature; the
    /// energy without the initial energy, the work and −∫∂L/∂t dt by the same quadrature; the Casimirs that are known; g by rows,
    /// m×m numbers, where there is a group.
    pub values: &'a [T],
    /// The largest relative residual of the steps since the last row.
    pub residual: T,
    /// The iterations of these steps.
    pub iterations: usize,
}

/// Who sees a trajectory.
pub trait Observer<T> {
    /// A row.
    fn row(&mut self, row: &Row<'_, T>);

    /// A step was taken, after its rows: `steps` steps are done, and this share of the run. Whether to go on.
    fn step(&mut self, steps: u64, share: f64) -> ControlFlow<()> {
        let _ = (steps, share);
        ControlFlow::Continue(())
    }

    /// An event of a run with a tolerance: which, from 0, whether its formula rises in the direction of the run, and the row of the
    /// state there.
    fn event(&mut self, index: usize, rising: bool, row: &Row<'_, T>) {
        let _ = (index, rising, row);
    }
}

/// How a run ended.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Ended<T> {
    /// Why.
    pub end: End,
    /// Why, if it is an error. There is a row of the last state reached, but where the velocity of a state was not found.
    pub reason: Option<String>,
    /// When.
    pub time: T,
    /// What the steps of a run with fixed steps took.
    pub totals: Option<Totals<T>>,
    /// What a run with a tolerance took. Nothing is known where the start is refused.
    pub statistics: Option<Statistics<T>>,
}

impl<T> Ended<T> {
    /// At that time, by an error if there is one.
    pub(super) fn at(time: T, end: End, reason: Option<String>) -> Self {
        let end = if reason.is_some() { End::Failed } else { end };
        Self { end, reason, time, totals: None, statistics: None }
    }
}

impl Case {
    /// The size of the matrices of the group, without padding; 0 without a group.
    pub fn matrix_size(&self) -> usize {
        self.algebra.structure.matrix_size()
    }

    /// How many Casimirs are known.
    pub fn casimir_count(&self) -> usize {
        self.algebra.structure.casimir_count()
    }
}

/// t; μ; η; these energies; the Casimirs; g by rows: of n coordinates, and matrices of a size.
pub(super) fn values<T: Real, const N: usize, const D: usize>(
    state: &State<T, N, D>,
    velocity: &Vector<T, N>,
    energies: &[T],
    casimirs: &[Casimir<T, N>],
    (n, size): (usize, usize),
) -> Vec<T> {
    let mut values = vec![state.time];
    values.extend(state.momentum.iter().take(n).chain(velocity.iter().take(n)).chain(energies));
    values.extend(casimirs.iter().map(|casimir| casimir.value(&state.momentum)));
    values.extend((0..size * size).map(|k| state.attitude[(k / size, k % size)]));
    values
}

/// What a row is computed from.
pub(super) struct Rows<'a, T: Real, const N: usize> {
    pub lagrangian: &'a AnyLagrangian<T, N>,
    pub casimirs: &'a [Casimir<T, N>],
    pub dimension: usize,
    pub matrix_size: usize,
    /// The energy taken up since the start.
    pub taken: Exchange<T>,
    /// The energy of the first row.
    energy: Option<T>,
    /// The velocity of the last row, where the next is looked for.
    velocity: Vector<T, N>,
    values: Vec<T>,
    /// Of the steps since the last row.
    residual: T,
    iterations: usize,
}

impl<'a, T: Real, const N: usize> Rows<'a, T, N> {
    pub fn new(
        (lagrangian, casimirs): (&'a AnyLagrangian<T, N>, &'a [Casimir<T, N>]),
        dimension: usize,
        matrix_size: usize,
    ) -> Self {
        let (taken, energy, velocity, values) = (Exchange::zero(), None, Vector::zeros(), Vec::new());
        let (residual, iterations) = (T::zero(), 0);
        Self { lagrangian, casimirs, dimension, matrix_size, taken, energy, velocity, values, residual, iterations }
    }

    pub fn count(&mut self, residual: T, iterations: usize) {
        self.residual = self.residual.max(residual);
        self.iterations += iterations;
    }

    /// The row of a state.
    pub fn show<const D: usize>(
        &mut self,
        state: &State<T, N, D>,
        observer: &mut dyn Observer<T>,
    ) -> Result<(), String> {
        self.look(state)?;
        observer.row(&self.row());
        (self.residual, self.iterations) = (T::zero(), 0);
        Ok(())
    }

    /// What was computed last.
    pub fn row(&self) -> Row<'_, T> {
        Row { values: &self.values, residual: self.residual, iterations: self.iterations }
    }

    /// Computes the row of a state; the first one has the initial energy.
    pub fn look<const D: usize>(&mut self, state: &State<T, N, D>) -> Result<(), String> {
        self.velocity = self
            .lagrangian
            .velocity_at(state.time, Configuration::of(&state.attitude), &state.momentum, &self.velocity)
            .map_err(|error| format!("at t = {}: {error}", state.time))?;
        let energy = self.lagrangian.energy_at(state.time, Configuration::of(&state.attitude), &self.velocity);
        let (first, taken) = (*self.energy.get_or_insert(energy), self.taken);
        let energies = [energy, taken.work, energy - first - (taken.work + taken.explicit)];
        self.values = values(state, &self.velocity, &energies, self.casimirs, (self.dimension, self.matrix_size));
        Ok(())
    }
}

/// The run with fixed steps, and a shorter last one, if there is one: a row of the initial state, after every `every`-th step, and at the end.
pub(super) fn by_steps<T: Real, const N: usize, const D: usize>(
    system: System<T, N, D>,
    (steps, last): (u64, Option<T>),
    every: u64,
    matrix_size: usize,
    observer: &mut dyn Observer<T>,
) -> Ended<T> {
    let System { dimension, lagrangian, force, retraction, tableau, mut state, step, casimirs, .. } = system;
    // By references, as everywhere: the same types are compiled once.
    let mut method = Variational::new(&lagrangian, &force, &retraction, tableau);
    let mut rows = Rows::new((&lagrangian, &casimirs), dimension, matrix_size);
    let total = steps.saturating_add(u64::from(last.is_some()));
    let (begin, mut totals, mut shown) = (state.time, Totals::none(), true);
    let mut reason = rows.show(&state, observer).err();
    let mut end = End::Time;
    for done in 1..=total {
        if reason.is_some() || end != End::Time {
            break;
        }
        let (before, h) = (state.clone(), last.filter(|_| done > steps).unwrap_or(step));
        let report = match method.step(&mut state, h) {
            Ok(report) => report,
            Err(source) => {
                reason = Some(format!("step {done} of {total}, from t = {}: {source}", state.time.to_f64()));
                end = End::Failed;
                break;
            }
        };
        let stages = method.stage_velocities().zip(method.stage_displacements());
        rows.taken = rows.taken.plus(method.exchange(&before, h, stages));
        // Afresh, so that the time does not gather round-off.
        state.time = if done > steps { before.time + h } else { begin + T::int(done as i64) * h };
        totals.add(&report);
        rows.count(report.residual, report.iterations);
        shown = done.is_multiple_of(every) || done == total;
        if shown {
            reason = rows.show(&state, observer).err();
        }
        if observer.step(done, done as f64 / total as f64).is_break() {
            end = End::Stopped;
        }
    }
    // The state that was reached is a row, whatever `every` says.
    if !shown {
        let _ = rows.show(&state, observer);
    }
    Ended { totals: Some(totals), ..Ended::at(state.time, end, reason) }
}
