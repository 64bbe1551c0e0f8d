//! The step that is being taken, and the workspace of its stages.

use crate::algebra::{Covector, Matrix, Vector};
use crate::integrators::State;
use crate::integrators::stages::Stages;
use crate::scalar::Real;

/// The step that is being taken.
#[derive(Clone, Copy, Debug)]
pub(super) struct Problem<T: Real, const N: usize, const D: usize> {
    pub(super) time: T,
    pub(super) step: T,
    pub(super) momentum: Covector<T, N>,
    pub(super) attitude: Matrix<T, D>,
    /// A force that residuals are relative to besides those that act, see [`rounding`]; 0 where it is not needed.
    pub(super) rounding: T,
}

impl<T: Real, const N: usize, const D: usize> Problem<T, N, D> {
    pub(super) fn new(state: &State<T, N, D>, step: T) -> Self {
        let rounding = T::zero();
        Self { time: state.time, step, momentum: state.momentum, attitude: state.attitude, rounding }
    }
}

/// The quantities of the s stages and of the step.
#[derive(Clone, Debug)]
pub(super) struct Work<T: Real, const N: usize> {
    /// H_i.
    pub(super) rates: Stages<T, N>,
    /// Ξ_i.
    pub(super) displacements: Stages<T, N>,
    /// η_i.
    pub(super) velocities: Stages<T, N>,
    /// P_i.
    pub(super) momenta: Stages<T, N>,
    /// G_i.
    pub(super) gradients: Stages<T, N>,
    /// f_i Ad_{τ(Ξ_i)}⁻¹.
    pub(super) impulses: Stages<T, N>,
    /// The residual r_i.
    pub(super) residuals: Stages<T, N>,
    /// The next P_i.
    pub(super) next_momenta: Stages<T, N>,
    /// The next Ξ_i, or the extrapolated η_i.
    pub(super) next_displacements: Stages<T, N>,
    /// m.
    pub(super) after_impulse: Covector<T, N>,
    /// ξ.
    pub(super) increment: Vector<T, N>,
    /// What changes count, where not once.
    pub(super) factors: Option<Factors<T, N>>,
}

/// How many times a change of each coordinate counts, where all are relative to the largest.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrators) struct Factors<T, const N: usize> {
    pub momenta: [T; N],
    pub displacements: [T; N],
    /// How many times more than another a momentum counts, at most, of which it may have the rounding.
    pub spread: T,
}

impl<T: Real, const N: usize> Factors<T, N> {
    /// The largest of a momentum.
    pub fn most(&self) -> T {
        self.momenta.iter().fold(T::one(), |most, &factor| most.max(factor))
    }
}

impl<T: Real, const N: usize> Work<T, N> {
    pub(super) fn new(stages: usize) -> Self {
        let zeros = Stages::zeros(stages);
        Self {
            rates: zeros.clone(),
            displacements: zeros.clone(),
            velocities: zeros.clone(),
            momenta: zeros.clone(),
            gradients: zeros.clone(),
            impulses: zeros.clone(),
            residuals: zeros.clone(),
            next_momenta: zeros.clone(),
            next_displacements: zeros,
            after_impulse: Covector::zeros(),
            increment: Vector::zeros(),
            factors: None,
        }
    }
}
