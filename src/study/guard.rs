//! A guard on the test problem: what would let a wrong method pass.
//!
//! Published order tests passed wrong methods because their problems were commuting, linear or isotropic, had no force, or stood
//! still. The checks are numerical, at a few fixed velocities.

use crate::algebra::{Covector, Vector};
use crate::integrators::State;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::{Force, Lagrangian};
use crate::scalar::{Real, max_abs};
use std::fmt;

/// Why a system is a poor test of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Warning {
    /// \[g, g\] = 0: momentum and attitude are not coupled, and every dτ is 1.
    Commuting,
    /// f = 0 at every velocity tried.
    NoForce,
    /// f depends on time alone, or is constant: where it is evaluated does not matter to its velocity.
    ForceIgnoresVelocity,
    /// μ ↦ ad*_η μ + f is affine: only the trees without branches are tested.
    LinearField,
    /// ad*_η l'(η) = 0 for every η: free motions are steady, as with an isotropic inertia on so(3).
    Isotropic,
    /// η̇ = 0 at the start and after a while: a steady motion, on which many methods are exact.
    ConstantVelocity,
    /// The errors fall faster than the order says, on this system: an elementary differential vanishes on it.
    SuperConvergence,
}

impl Warning {
    /// A short name: `commuting`, `no-force`, ….
    pub fn name(self) -> &'static str {
        match self {
            Self::Commuting => "commuting",
            Self::NoForce => "no-force",
            Self::ForceIgnoresVelocity => "force-ignores-velocity",
            Self::LinearField => "linear-field",
            Self::Isotropic => "isotropic",
            Self::ConstantVelocity => "constant-velocity",
            Self::SuperConvergence => "super-convergence",
        }
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Commuting => "the algebra is abelian: nothing couples the momentum to the attitude",
            Self::NoForce => {
                "there is no force: some tableaux do better on free motions, and faults of the force are not seen"
            }
            Self::ForceIgnoresVelocity => {
                "the force does not depend on the velocity: a force at the wrong stage is not seen"
            }
            Self::LinearField => {
                "the vector field of the momentum is affine: conditions of trees with branches are not tested"
            }
            Self::Isotropic => "the free motion is steady whatever the velocity (isotropic inertia)",
            Self::ConstantVelocity => "the velocity is constant along the motion: many methods are exact on it",
            Self::SuperConvergence => {
                "errors fall faster here than the order says: an elementary differential vanishes"
            }
        })
    }
}

/// The k-th of a few fixed velocities without symmetry, of the size of `scale`.
fn velocity<T: Real, const N: usize>(k: usize, scale: T) -> Vector<T, N> {
    Vector::from_fn(|a, _| T::ratio(((7 * a + 5 * k + 3) % 13) as i64 - 6, 8) * scale)
}

/// What is wrong with a system as a test problem over some duration, as far as a look at its vector field tells; sorted.
///
/// Differences count as none below 2⁻²⁰ of the size of the terms, far above rounding, far below what a chosen coefficient does.
pub fn warnings<T: Real, const N: usize, const D: usize>(
    system: &EulerPoincare<T, N, impl Lagrangian<T, N>, impl Force<T, N>>,
    start: &State<T, N, D>,
    duration: T,
) -> Vec<Warning> {
    let mut found = Vec::new();
    let small = |x: T, size: T| x <= size * T::exact(1.0 / 1_048_576.0);
    let n = |k: usize| T::int(k as i64);
    let abelian = system.algebra.is_abelian();
    if abelian {
        found.push(Warning::Commuting);
    }
    let g = Configuration::of(&start.attitude);
    let speed = match system.lagrangian.velocity_at(start.time, g, &start.momentum, &Vector::zeros()) {
        Ok(eta) => eta.amax().max(T::exact(0.25)),
        Err(_) => T::one(),
    };
    let velocities: Vec<Vector<T, N>> = (0..5).map(|k| velocity(k, speed)).collect();
    let momenta: Vec<Covector<T, N>> =
        velocities.iter().map(|eta| system.lagrangian.gradient_at(start.time, g, eta)).collect();
    let force = |time: T, eta: &Vector<T, N>| {
        system.force.force_at(time, g, eta) + system.lagrangian.configuration_gradient(time, g, eta)
    };
    let forces: Vec<Covector<T, N>> = velocities.iter().map(|eta| force(start.time, eta)).collect();
    let size = momenta.iter().fold(T::zero(), |m, mu| m.max(mu.amax())).max(T::unit_roundoff());
    let later = |k: usize| force(start.time + duration * T::ratio(3, 8) * n(k), &velocities[k]);
    let span = duration.abs();
    if (0..5).all(|k| small(span * forces[k].amax().max(later(k).amax()), size)) {
        found.push(Warning::NoForce);
    } else if (1..5).all(|k| small(max_abs(&(forces[k] - forces[0])), forces[k].amax().max(forces[0].amax()))) {
        found.push(Warning::ForceIgnoresVelocity);
    }
    let free = |k: usize| system.algebra.coad(&velocities[k], &momenta[k]);
    if !abelian && (0..5).all(|k| small(free(k).amax(), size * velocities[k].amax())) {
        found.push(Warning::Isotropic);
    }
    let rate = |mu: &Covector<T, N>, guess: &Vector<T, N>| {
        system.rates_at(start.time, g, mu, guess).map(|rates| rates.momentum)
    };
    // Affine: X((μ₁ + μ₂)/2) is the mean of X(μ₁) and X(μ₂).
    let affine = |j: usize, k: usize| {
        let mean = (momenta[j] + momenta[k]) * T::half();
        let guess = (velocities[j] + velocities[k]) * T::half();
        match (rate(&momenta[j], &velocities[j]), rate(&momenta[k], &velocities[k]), rate(&mean, &guess)) {
            (Ok(x), Ok(y), Ok(middle)) => small(max_abs(&(middle - (x + y) * T::half())), x.amax().max(y.amax())),
            _ => false,
        }
    };
    if (1..5).all(|k| affine(0, k) && affine(k, 5 - k)) {
        found.push(Warning::LinearField);
    }
    let steady = |time: T| match system.rates_at(time, g, &start.momentum, &Vector::zeros()) {
        Ok(rates) => small(span * rates.momentum.amax(), start.momentum.amax().max(T::unit_roundoff())),
        Err(_) => false,
    };
    if (0..3).all(|k| steady(start.time + duration * T::ratio(3, 8) * n(k))) {
        found.push(Warning::ConstantVelocity);
    }
    found.sort();
    found
}
