//! The energy that a system takes up.

use super::{Coefficients, Scheme, State, Variational};
use crate::algebra::{Vector, pair};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::{Dual, Real};

/// What the energy E = ⟨∂L/∂η, η⟩ − L takes up, in a time or in the unit of it: dE/dt = ⟨f, η⟩ − ∂L/∂t.
#[derive(Clone, Copy, Debug, PartialEq)]
#[doc(hidden)]
pub struct Exchange<T> {
    /// ∫⟨f, η⟩ dt, or ⟨f, η⟩.
    pub work: T,
    /// −∫∂L/∂t dt, or −∂L/∂t.
    pub explicit: T,
}

impl<T: Real> Exchange<T> {
    pub(crate) fn zero() -> Self {
        Self { work: T::zero(), explicit: T::zero() }
    }

    /// The rates at a velocity η, and at the time and the attitude of a state.
    pub(crate) fn rates<const N: usize, const D: usize>(
        lagrangian: &impl Lagrangian<T, N>,
        force: &impl Force<T, N>,
        state: &State<T, N, D>,
        eta: &Vector<T, N>,
    ) -> Self {
        let work = pair(&force.force_at(state.time, Configuration::of(&state.attitude), eta), eta);
        if !lagrangian.uses_configuration() {
            return Self { work, explicit: T::zero() };
        }
        let (g, eta) = (state.attitude.map(Dual::constant), eta.map(Dual::constant));
        let slope = lagrangian.value_at(Dual::variable(state.time), Configuration::of(&g), &eta).eps;
        Self { work, explicit: -slope }
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self { work: self.work + other.work, explicit: self.explicit + other.explicit }
    }

    pub(crate) fn times(self, factor: T) -> Self {
        Self { work: self.work * factor, explicit: self.explicit * factor }
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Variational<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// h Σ b_i of the rates at t + c_i h, g τ(Ξ_i) and η_i: what a step of size h from a state takes up, of the stages (η_i, Ξ_i).
    pub(crate) fn exchange(
        &self,
        state: &State<T, N, D>,
        h: T,
        stages: impl Iterator<Item = (Vector<T, N>, Vector<T, N>)>,
    ) -> Exchange<T> {
        let Scheme { coefficients: Coefficients { tableau, .. }, lagrangian, force, retraction, .. } = &self.scheme;
        let moves = force.uses_configuration() || lagrangian.uses_configuration();
        let (mut there, mut sum) = (state.clone(), Exchange::zero());
        for (i, (eta, x)) in stages.enumerate() {
            let turned = if moves { retraction.tau(&x).ok() } else { None };
            there.attitude = turned.map_or(state.attitude, |turned| state.attitude * turned);
            there.time = state.time + tableau.c()[i] * h;
            sum = sum.plus(Exchange::rates(lagrangian, force, &there, &eta).times(tableau.b()[i]));
        }
        sum.times(h)
    }
}
