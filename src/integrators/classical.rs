//! A classical Runge–Kutta method on the vector field of (μ, g), blind to the group: the comparator, and the reference.
//!
#![doc = include_str!("../guide/modules/integrators/classical.md")]

use super::picard::iterate;
use super::variational::extrapolation_by;
use super::{OneStep, Report, State, StepError};
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::LieGroup;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::{Force, Lagrangian};
use crate::scalar::Real;
use crate::tableau::Tableau;

/// A Runge–Kutta method on (μ, g) as a vector in g* × ℝ^{D×D}; without a group the attitude is left alone.
#[derive(Clone, Debug)]
pub struct Classical<T: Real, const N: usize, const D: usize, L, F, G> {
    system: EulerPoincare<T, N, L, F>,
    group: Option<G>,
    tableau: Tableau<T>,
    explicit: bool,
    tolerance: T,
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
            group,
            explicit,
            tolerance: T::zero(),
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

    /// Evaluates every stage with the slopes at hand; returns the largest relative change of a slope.
    fn pass(&mut self, state: &State<T, N, D>, h: T) -> Result<T, StepError> {
        let (mut change, mut size) = (T::zero(), T::zero());
        for i in 0..self.tableau.stages() {
            let mut momentum = state.momentum;
            for (j, slope) in self.slopes.iter().enumerate() {
                momentum += slope * (h * self.tableau.a()[(i, j)]);
            }
            let time = state.time + self.tableau.c()[i] * h;
            let mut attitude = state.attitude;
            if self.group.is_some() {
                for (j, rate) in self.rates.iter().enumerate() {
                    attitude += rate * (h * self.tableau.a()[(i, j)]);
                }
            } else if self.system.uses_configuration() {
                let why = "the system depends on the configuration, and no group was given".into();
                return Err(StepError::Unsupported { why });
            }
            let rates = self
                .system
                .rates_at(time, Configuration::of(&attitude), &momentum, &self.velocities[i])
                .map_err(|source| StepError::Legendre { step: h.to_f64(), source })?;
            for (new, old) in rates.momentum.iter().zip(&self.slopes[i]) {
                change = change.max((*new - *old).abs());
                size = size.max(new.abs());
            }
            if let Some(group) = &self.group {
                let rate = attitude * group.hat(&rates.velocity);
                for (new, old) in rate.iter().zip(&self.rates[i]) {
                    change = change.max((*new - *old).abs());
                    size = size.max(new.abs());
                }
                self.rates[i] = rate;
            }
            self.slopes[i] = rates.momentum;
            self.velocities[i] = rates.velocity;
        }
        Ok(if change == T::zero() { change } else { change / size })
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
        self.take(state, h)
    }
}

impl<T, const N: usize, const D: usize, L, F, G> Classical<T, N, D, L, F, G>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    G: LieGroup<T, N, D>,
{
    /// A step from where the last one ended, `ratio` times as long: its stages are looked for near those of the polynomial through
    /// the last ones.
    pub(crate) fn follow(&mut self, state: &mut State<T, N, D>, h: T, ratio: T) -> Result<Report<T>, StepError> {
        let Some(weights) = extrapolation_by(self.tableau.c().as_slice(), ratio) else { return self.step(state, h) };
        state.check_finite(h)?;
        let (slopes, rates) = (self.slopes.clone(), self.rates.clone());
        for (i, (slope, rate)) in self.slopes.iter_mut().zip(&mut self.rates).enumerate() {
            (*slope, *rate) = (Covector::zeros(), Matrix::zeros());
            for (j, (before, turned)) in slopes.iter().zip(&rates).enumerate() {
                *slope += before * weights[(i, j)];
                if self.group.is_some() {
                    *rate += turned * weights[(i, j)];
                }
            }
        }
        self.take(state, h)
    }

    /// A step with the guesses at hand.
    fn take(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        let (solver, iterations, residual) = iterate(self.explicit, h, self.tolerance, || self.pass(state, h))?;
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
