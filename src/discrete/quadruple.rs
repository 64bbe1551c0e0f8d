//! Discrete mechanics on G⁴, before reduction.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/discrete/quadruple.md"))]

use super::smooth::{SmoothLagrangian, moved};
use super::{DiscreteError, Triple, chord};
use crate::algebra::{Covector, Matrix, elimination};
use crate::group::LieGroup;
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::{Dual, Real, Scalar};

/// (g₀, g₁, g̃₀, g̃₁) in G⁴.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quadruple<S: Scalar, const D: usize> {
    /// (g₀, g₁).
    pub first: [Matrix<S, D>; 2],
    /// (g̃₀, g̃₁).
    pub second: [Matrix<S, D>; 2],
}

impl<S: Scalar, const D: usize> Quadruple<S, D> {
    /// π(g₀, g₁, g̃₀, g̃₁) = (g₀⁻¹g₁, g₀⁻¹g̃₀, g̃₀⁻¹g̃₁); `None` when g₀ or g̃₀ is singular.
    pub fn project(&self) -> Option<Triple<S, D>> {
        let back = elimination::inverse(&self.first[0])?;
        let w = elimination::inverse(&self.second[0])? * self.second[1];
        Some(Triple { v: back * self.first[1], u: back * self.second[0], w })
    }

    /// ι_d(g₀, g₁, g̃₀, g̃₁) = (g̃₀, g̃₁, g₀, g₁).
    pub fn exchange(&self) -> Self {
        Self { first: self.second, second: self.first }
    }
}

/// L_d(g₀, g₁, g̃₀, g̃₁) for L_d = l_d ∘ π, in any scalar.
///
/// # Errors
/// A point outside the domain of l_d; g₀ or g̃₀ singular.
pub fn lifted<T: Real, S: Scalar<Base = T>, const D: usize>(
    l_d: &impl SmoothLagrangian<T, D>,
    x: &Quadruple<S, D>,
) -> Result<S, RetractionError> {
    let why = "g₀ or g̃₀ is singular";
    l_d.value(&x.project().ok_or(RetractionError::NoPreimage { retraction: "the projection of G⁴", why })?)
}

/// The left-trivialised derivatives of L_d by g₀, g₁, g̃₀, g̃₁, by dual numbers at g(1 + ε ê_a).
///
/// # Errors
/// Those of [`lifted`].
pub fn slopes<T: Real, const N: usize, const D: usize>(
    l_d: &impl SmoothLagrangian<T, D>,
    group: &impl LieGroup<T, N, D>,
    x: &Quadruple<T, D>,
) -> Result<[Covector<T, N>; 4], DiscreteError> {
    let still =
        Quadruple { first: x.first.map(|g| g.map(Dual::constant)), second: x.second.map(|g| g.map(Dual::constant)) };
    let mut slopes = [Covector::zeros(); 4];
    for (k, slope) in slopes.iter_mut().enumerate() {
        for a in 0..N {
            let mut along = still;
            let (copy, here) =
                if k < 2 { (&mut along.first, &x.first[k]) } else { (&mut along.second, &x.second[k - 2]) };
            copy[k % 2] = moved(group, here, a).0;
            slope[a] = lifted(l_d, &along).map_err(DiscreteError::domain("(g₀, g₁, g̃₀, g̃₁)"))?.eps;
        }
    }
    Ok(slopes)
}

/// The discrete flow on G⁴: (g₀, g₁, g̃₀, g̃₁) ↦ (g₁, g₂, g̃₁, g̃₂) with ∂L_d(k−1)/∂g₁ + ∂L_d(k)/∂g₁ = 0 and the same for g̃₁,
/// found from g₂ = g₁g₀⁻¹g₁, g̃₂ = g̃₁g̃₀⁻¹g̃₁.
///
/// L_d = l_d ∘ π, with `previous` the l_d of step k−1 and `next` that of step k.
///
/// # Errors
/// No convergence; a singular Jacobian; leaving a domain; a singular matrix.
pub fn flow<T: Real, const N: usize, const D: usize>(
    previous: &impl SmoothLagrangian<T, D>,
    next: &impl SmoothLagrangian<T, D>,
    group: &impl LieGroup<T, N, D>,
    retraction: &impl Retraction<T, N, D>,
    x: &Quadruple<T, D>,
) -> Result<Quadruple<T, D>, DiscreteError> {
    let [_, ended, _, partner_ended] = slopes(previous, group, x)?;
    let guess = |[before, here]: &[Matrix<T, D>; 2]| {
        let back = elimination::inverse(before).ok_or(DiscreteError::NotInvertible { what: "g₀ or g̃₀" })?;
        Ok::<_, DiscreteError>(here * back * here)
    };
    let starts = [guess(&x.first)?, guess(&x.second)?];
    let place = |&[ahead, partner]: &[Matrix<T, D>; 2]| Quadruple {
        first: [x.first[1], ahead],
        second: [x.second[1], partner],
    };
    let found = chord::elements("the discrete Euler–Lagrange equations on G⁴", retraction, starts, |ahead| {
        let [begun, _, partner_begun, _] = slopes(next, group, &place(ahead))?;
        let size = [ended, partner_ended, begun, partner_begun].iter().fold(T::zero(), |m, v| m.max(v.amax()));
        Ok(([ended + begun, partner_ended + partner_begun], size))
    })?;
    Ok(place(&found))
}
