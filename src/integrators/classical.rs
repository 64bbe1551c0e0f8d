//! A classical Runge–Kutta method on the vector field of (μ, g), blind to the group: the comparator, and the reference.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/integrators/classical.md"))]

use super::picard::{Change, iterate};
use super::{OneStep, Report, State, StepError};
use crate::algebra::{Covector, Matrix, Vector, basis_vector};
use crate::group::LieGroup;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::{Force, Lagrangian};
use crate::scalar::Real;
use crate::tableau::Tableau;

/// How many columns of g the group's algebra moves: those up to the last in which an element of a basis has an entry.
fn moving<T: Real, G: LieGroup<T, N, D>, const N: usize, const D: usize>(group: &G) -> usize {
    let element = |a: usize| group.hat(&basis_vector::<T, N>(a));
    let last =
        |hat: Matrix<T, D>| (0..D).rfind(|k| (0..D).any(|j| hat[(*k, j)] != T::zero() || hat[(j, *k)] != T::zero()));
    (0..N).filter_map(|a| last(element(a))).max().map_or(0, |last| last + 1)
}

/// A Runge–Kutta method on (μ, g) as a vector in g* × ℝ^{D×D}; without a group the attitude is left alone.
#[derive(Clone, Debug)]
pub struct Classical<T: Real, const N: usize, const D: usize, L, F, G> {
    system: EulerPoincare<T, N, L, F>,
    group: Option<G>,
    tableau: Tableau<T>,
    explicit: bool,
    tolerance: T,
    /// The columns of g that move: those before the padding of the group's matrices.
    columns: usize,
    slopes: Vec<Covector<T, N>>,
    rates: Vec<Matrix<T, D>>,
    velocities: Vec<Vector<T, N>>,
}

impl<T, const N: usize, const D: usize, L, F, G> Classical<T, N, D, L, F, G>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    G: LieGroup<T, N, D>,
{
    /// The method of a tableau on a system; `group` supplies ξ ↦ ξ̂ for the attitude.
    pub fn new(system: EulerPoincare<T, N, L, F>, group: Option<G>, tableau: Tableau<T>) -> Self {
        let s = tableau.stages();
        let explicit = (0..s).all(|i| (i..s).all(|j| tableau.a()[(i, j)] == T::zero()));
        Self {
            system,
            explicit,
            tolerance: T::zero(),
            columns: group.as_ref().map_or(0, moving),
            group,
            tableau,
            slopes: vec![Covector::zeros(); s],
            rates: vec![Matrix::zeros(); s],
            velocities: vec![Vector::zeros(); s],
        }
    }

    /// The same, with the stages found to a relative `tolerance` instead of to round-off.
    pub fn to(mut self, tolerance: T) -> Self {
        self.tolerance = tolerance;
        self
    }

    /// Evaluates every stage with the slopes at hand.
    fn pass(&mut self, state: &State<T, N, D>, h: T) -> Result<Change<T>, StepError> {
        let [mut change, mut momentum, mut size] = [T::zero(); 3];
        let columns = self.columns;
        let moves = |r: &usize| (0..columns).any(|c| state.attitude[(*r, c)] != T::zero());
        let rows = (0..D).rfind(moves).map_or(0, |last| last + 1);
        for i in 0..self.tableau.stages() {
            let mut here = state.momentum;
            for (j, slope) in self.slopes.iter().enumerate() {
                here += slope * (h * self.tableau.a()[(i, j)]);
            }
            let time = state.time + self.tableau.c()[i] * h;
            let mut attitude = state.attitude;
            if self.group.is_some() {
                for (j, rate) in self.rates.iter().enumerate() {
                    let weight = h * self.tableau.a()[(i, j)];
                    for c in 0..columns {
                        for r in 0..rows {
                            attitude[(r, c)] += rate[(r, c)] * weight;
                        }
                    }
                }
            } else if self.system.uses_configuration() {
                let why = "the system depends on the configuration, and no group was given".into();
                return Err(StepError::Unsupported { why });
            }
            let rates = self
                .system
                .rates_at(time, Configuration::of(&attitude), &here, &self.velocities[i])
                .map_err(|source| StepError::Legendre { step: h.to_f64(), source })?;
            for (new, old) in rates.momentum.iter().zip(&self.slopes[i]) {
                momentum = momentum.max((*new - *old).abs());
                size = size.max(new.abs());
            }
            if let Some(group) = &self.group {
                let hat = group.hat(&rates.velocity);
                for c in 0..columns {
                    for r in 0..rows {
                        let entry = |sum: T, j: usize| sum + attitude[(r, j)] * hat[(j, c)];
                        let new = (1..columns).fold(attitude[(r, 0)] * hat[(0, c)], entry);
                        change = change.max((new - self.rates[i][(r, c)]).abs());
                        size = size.max(new.abs());
                        self.rates[i][(r, c)] = new;
                    }
                }
            }
            self.slopes[i] = rates.momentum;
            self.velocities[i] = rates.velocity;
        }
        let change = change.max(momentum);
        Ok(Change { relative: if change == T::zero() { change } else { change / size }, momentum })
    }
}

impl<T, const N: usize, const D: usize, L, F, G> OneStep<T, N, D> for Classical<T, N, D, L, F, G>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    G: LieGroup<T, N, D>,
{
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        state.check_finite(h)?;
        self.slopes.fill(Covector::zeros());
        self.rates.fill(Matrix::zeros());
        let (explicit, tolerance) = (self.explicit, self.tolerance);
        let sensitivity = |method: &Self| method.system.sensitivity(state.time, &state.attitude, &method.velocities[0]);
        let (solver, iterations, residual) =
            iterate(self, explicit, h, tolerance, |method| method.pass(state, h), sensitivity)?;
        let mut next = state.clone();
        for (j, (slope, rate)) in self.slopes.iter().zip(&self.rates).enumerate() {
            let weight = h * self.tableau.b()[j];
            next.momentum += slope * weight;
            next.attitude += rate * weight;
        }
        next.time += h;
        next.check_finite(h)?;
        *state = next;
        Ok(Report { solver, iterations, residual })
    }
}
