//! Numbers that a law needs beyond those of its case: a stream that the case determines.
//!
//! Group elements, directions and variations are drawn from a splitmix64 stream seeded with an FNV-1a hash of the
//! printed case, so a case that is replayed meets the same ones. All are dyadic with few bits: exact in every scalar.

use crate::algebra::{Covector, Vector};
use crate::harness::{hash, split_mix};
use crate::scalar::{Real, Scalar};
use nalgebra::SMatrix;
use std::fmt::Debug;

/// The stream of a case.
#[derive(Clone, Debug)]
pub struct Probe(Option<u64>);

impl Probe {
    /// The stream of `case`; `salt` tells the uses within a law apart.
    pub fn new(case: &dyn Debug, salt: u64) -> Self {
        Self(Some(hash(format!("{case:?}").bytes()) ^ salt.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// No stream: a draw from it panics, as the law that makes it has not said which stream it means.
    pub fn none() -> Self {
        Self(None)
    }

    /// Sixty-four random bits.
    pub fn next(&mut self) -> u64 {
        split_mix(self.0.as_mut().expect("a law that draws numbers has a stream"))
    }

    /// An integer in low ..= high.
    pub fn integer(&mut self, low: i32, high: i32) -> i32 {
        low + (self.next() % (high - low + 1) as u64) as i32
    }

    /// k/64 with |k| ≤ 64, never 0.
    pub fn unit<S: Scalar>(&mut self) -> S {
        let k = i64::from(self.integer(1, 64));
        S::int(if self.next() & 1 == 0 { k } else { -k }) * S::exact(1.0 / 64.0)
    }

    /// A vector with such components.
    pub fn vector<S: Scalar, const N: usize>(&mut self) -> Vector<S, N> {
        Vector::from_fn(|_, _| self.unit())
    }

    /// A vector with components up to `size` of 53 random digits: those of few digits hide rounding, as cos θ = 1 − θ²/2 is exact for them
    /// where θ is small. They are numbers of `f64`, so that they are the same in every scalar.
    pub fn dense<S: Scalar, const N: usize>(&mut self, size: f64) -> Vector<S, N> {
        Vector::from_fn(|_, _| {
            let unit = self.unit::<f64>();
            S::exact(size * unit * (1.0 - (self.next() >> 11) as f64 * 2f64.powi(-54)))
        })
    }

    /// A covector with components k/64.
    pub fn covector<S: Scalar, const N: usize>(&mut self) -> Covector<S, N> {
        Covector::from_fn(|_, _| self.unit())
    }

    /// 2^k with k in low ..= high.
    pub fn power_of_two<S: Scalar>(&mut self, low: i32, high: i32) -> S {
        S::exact(2f64.powi(self.integer(low, high)))
    }
}

/// The size of a velocity or a momentum, of which distances from it are shares; 1 at rest.
pub fn unit_of<T: Real, const R: usize, const C: usize>(point: &SMatrix<T, R, C>) -> T {
    let size = point.amax();
    if size == T::zero() { T::one() } else { size }
}

/// What the streams of a case are for. Laws that share a number see the same bits, and use them for different things. The numbers
/// stay: with another one, saved records would meet other values.
pub mod stream {
    /// The stretch of a step, the tolerance and length of a solve on SO(3) and SE(3).
    pub const FAST: u64 = 0;
    /// A weight or a field on a body.
    pub const FAST_WEIGHT: u64 = 99;
    /// Points of the algebra and directions.
    pub const RETRACTION: u64 = 1;
    /// Arrows of the groupoids.
    pub const GROUPOID: u64 = 2;
    /// Velocities and x in U = τ(x).
    pub const MECHANICS: u64 = 3;
    /// Points of g×G×g and variations.
    pub const EULER_LAGRANGE: u64 = 11;
    /// Points of g*×G×g* and functions.
    pub const POISSON: u64 = 11;
    /// Points of the other Poisson groupoids over g* and functions.
    pub const OTHER_POISSON: u64 = 83;
    /// A second Lagrangian and where a motion starts.
    pub const EULER_LAGRANGE_MOTION: u64 = 12;
    /// A point off the units.
    pub const LEGENDRE: u64 = 13;
    /// λ and x in U = τ(x).
    pub const HAMILTONIAN: u64 = 14;
    /// Functions of the momentum.
    pub const LIE_POISSON: u64 = 15;
    /// λ and U.
    pub const TWO_HAMILTONIANS: u64 = 16;
    /// Where two motions start.
    pub const TWO_HAMILTONIANS_MOTION: u64 = 17;
    /// Directions along the orbit.
    pub const ORBITS: u64 = 18;
    /// Where a motion off the units starts.
    pub const VARIATIONAL_ERROR: u64 = 40;
    /// (V, U, W) near the motion of the system.
    pub const POINT_OFF_UNITS: u64 = 51;
    /// Rates of the stages of the doubled scheme.
    pub const DOUBLED_STAGES: u64 = 51;
    /// Directions of differences of l_d.
    pub const SLOPES: u64 = 52;
    /// A doubled state and a direction of the momentum map.
    pub const DOUBLED_STATE: u64 = 52;
    /// (λ, U, μ) where doubled steps start.
    pub const MOMENTA_OFF_UNITS: u64 = 53;
    /// Six elements near e.
    pub const ELEMENTS: u64 = 54;
    /// A polynomial as the discrete Lagrangian.
    pub const DISCRETE_POLYNOMIAL: u64 = 55;
    /// Variations of the middle elements.
    pub const VARIATION: u64 = 56;
    /// Two elements of G, a variation, a polynomial.
    pub const VARIATION_ON_GROUP: u64 = 57;
    /// An element of G and a polynomial.
    pub const POISSON_ON_GROUP: u64 = 58;
    /// Where an exact solution starts.
    pub const EXACT_SOLUTION: u64 = 61;
    /// A perturbation of the exact discrete Lagrangian, and its order.
    pub const PERTURBATION: u64 = 62;
    /// An arrow of one fibre.
    pub const LIE_FIBRE: u64 = 71;
    /// Fields and functions on a Lie groupoid of a user.
    pub const LIE_GROUPOID: u64 = 72;
    /// Digits of a displacement beyond those of f64.
    pub const BEYOND_DOUBLE: u64 = 97;
    /// A potential and a force that depend on the configuration.
    pub const CONFIGURATION: u64 = 73;
    /// The values of laws on parts.
    pub const PARTS: u64 = 81;
    /// Where values are compared with those in 32 digits.
    pub const ACCURACY: u64 = 91;
    /// Whether a case is judged in 32 digits.
    pub const DIGITS: u64 = 92;
    /// Changes of the numbers of a case by a unit of round-off.
    pub const ROUNDING: u64 = 93;
    /// The tolerance and the times of a run.
    pub const SOLVE: u64 = 96;
    /// The stretch of a step beyond which no branch may be jumped.
    pub const BRANCH: u64 = 95;
    /// The direction of a derivative, and a functional.
    pub const DERIVATIVE: u64 = 98;
    /// Where τ⁻¹ is taken at large angles.
    pub const LARGE_ANGLE: u64 = 94;
    /// The material of the groupoids of a system.
    pub const GROUPOID_OF_SYSTEM: u64 = 82;
}
