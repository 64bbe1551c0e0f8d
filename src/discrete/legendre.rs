//! The two Legendre transforms of l_d, the discrete Euler–Lagrange equations and their flow.

use super::{DiscreteError, DiscreteLagrangian, Slopes, Triple, chord};
use crate::algebra::{Covector, Matrix};
use crate::retraction::Retraction;
use crate::scalar::Real;

/// (λ, U, μ) in g*×G×g*.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Momenta<T: Real, const N: usize, const D: usize> {
    /// λ, of the first copy.
    pub lambda: Covector<T, N>,
    /// U = g⁻¹g̃.
    pub u: Matrix<T, D>,
    /// μ, of the second copy.
    pub mu: Covector<T, N>,
}

impl<T: Real, const N: usize, const D: usize> Momenta<T, N, D> {
    /// F⁺ from the slopes at (V, U, W).
    ///
    /// # Errors
    /// V singular.
    pub fn plus(slopes: &Slopes<T, N>, x: &Triple<T, D>) -> Result<Self, DiscreteError> {
        let u = x.next_u().ok_or(DiscreteError::NotInvertible { what: "V" })?;
        Ok(Self { lambda: -slopes.v_left, u, mu: slopes.w_left })
    }

    /// F⁻ from the slopes at (V, U, W).
    pub fn minus(slopes: &Slopes<T, N>, x: &Triple<T, D>) -> Self {
        Self { lambda: -slopes.v_right - slopes.u_right, u: x.u, mu: slopes.w_right - slopes.u_left }
    }
}

/// F⁺(V, U, W) = (−L*_V D₁l_d, V⁻¹UW, L*_W D₃l_d): the momenta at the end of the step.
///
/// Source: Martín de Diego and Sato Martín de Almagro 2019, §5.
///
/// # Errors
/// Those of the slopes; V singular.
pub fn legendre_plus<T: Real, const N: usize, const D: usize>(
    l_d: &impl DiscreteLagrangian<T, N, D>,
    x: &Triple<T, D>,
) -> Result<Momenta<T, N, D>, DiscreteError> {
    Momenta::plus(&l_d.slopes(x)?, x)
}

/// F⁻(V, U, W) = (−R*_V D₁l_d − R*_U D₂l_d, U, R*_W D₃l_d − L*_U D₂l_d): the momenta at the start of the step.
///
/// Source: Martín de Diego and Sato Martín de Almagro 2019, §5.
///
/// # Errors
/// Those of the slopes.
pub fn legendre_minus<T: Real, const N: usize, const D: usize>(
    l_d: &impl DiscreteLagrangian<T, N, D>,
    x: &Triple<T, D>,
) -> Result<Momenta<T, N, D>, DiscreteError> {
    Ok(Momenta::minus(&l_d.slopes(x)?, x))
}

/// The discrete Euler–Lagrange equations at two successive steps: the covectors that vanish on a solution,
///
/// (L*_V D₁(k−1) − R*_V D₁(k) − R*_U D₂(k), L*_W D₃(k−1) − R*_W D₃(k) + L*_U D₂(k)).
///
/// The Lagrangians of the two steps may differ (they do where **l** depends on time). The third equation is
/// U_k = V_{k−1}⁻¹U_{k−1}W_{k−1}; see [`Triple::next_u`].
///
/// Source: Martín de Diego and Sato Martín de Almagro 2019, (5.2).
///
/// # Errors
/// Those of the slopes; V_{k−1} singular.
pub fn euler_lagrange<T: Real, const N: usize, const D: usize>(
    (previous, x): (&impl DiscreteLagrangian<T, N, D>, &Triple<T, D>),
    (next, y): (&impl DiscreteLagrangian<T, N, D>, &Triple<T, D>),
) -> Result<(Covector<T, N>, Covector<T, N>), DiscreteError> {
    let (end, start) = (legendre_plus(previous, x)?, legendre_minus(next, y)?);
    Ok((start.lambda - end.lambda, end.mu - start.mu))
}

/// (F⁻)⁻¹(λ, U, μ): the step (V, U, W) that starts with these momenta, found from (V₀, W₀) of `start`, helped by an evaluation nearby.
///
/// Newton's method for (x, y) in V = V₀ τ(x), W = W₀ τ(y), from 0; the Jacobian by differences of slopes.
///
/// # Errors
/// No convergence; a singular Jacobian, where l_d is not regular; those of the slopes and of τ.
pub fn legendre_minus_inverse<T: Real, L: DiscreteLagrangian<T, N, D>, const N: usize, const D: usize>(
    l_d: &L,
    retraction: &impl Retraction<T, N, D>,
    momenta: &Momenta<T, N, D>,
    start: &Triple<T, D>,
    memory: &mut L::Memory,
) -> Result<Triple<T, D>, DiscreteError> {
    let (u, starts) = (momenta.u, [start.v, start.w]);
    let [v, w] = chord::elements("the discrete Euler–Lagrange equations", retraction, starts, |&[v, w]| {
        let point = Triple { v, u, w };
        let slopes = l_d.slopes_from(&point, memory)?;
        let found = Momenta::minus(&slopes, &point);
        let terms = [slopes.v_right, slopes.u_right, slopes.w_right, slopes.u_left, momenta.lambda, momenta.mu];
        let size = terms.iter().fold(T::zero(), |size, term| size.max(term.amax()));
        Ok(([found.lambda - momenta.lambda, found.mu - momenta.mu], size))
    })?;
    Ok(Triple { v, u, w })
}

/// F_{l_d}: (V_{k−1}, U_{k−1}, W_{k−1}) ↦ (V_k, U_k, W_k) with F⁻(k) = F⁺(k−1), found from (V_{k−1}, W_{k−1}).
///
/// `previous` is l_d of step k−1 and `next` that of step k, the same where **l** does not depend on time.
///
/// Source: Martín de Diego and Sato Martín de Almagro 2019, §5.
///
/// # Errors
/// Those of [`legendre_minus_inverse`]; V_{k−1} singular.
pub fn flow<T: Real, const N: usize, const D: usize>(
    previous: &impl DiscreteLagrangian<T, N, D>,
    next: &impl DiscreteLagrangian<T, N, D>,
    retraction: &impl Retraction<T, N, D>,
    x: &Triple<T, D>,
) -> Result<Triple<T, D>, DiscreteError> {
    legendre_minus_inverse(next, retraction, &legendre_plus(previous, x)?, x, &mut Default::default())
}

/// [`flow`], helped by an evaluation nearby: where l_d is one of several extremal values, `memory` says which
/// ([`StageLagrangian::near`](super::StageLagrangian::near)).
///
/// # Errors
/// Those of [`flow`].
pub fn flow_from<T: Real, L: DiscreteLagrangian<T, N, D>, const N: usize, const D: usize>(
    previous: &L,
    next: &L,
    retraction: &impl Retraction<T, N, D>,
    x: &Triple<T, D>,
    memory: &mut L::Memory,
) -> Result<Triple<T, D>, DiscreteError> {
    let end = Momenta::plus(&previous.slopes_from(x, memory)?, x)?;
    legendre_minus_inverse(next, retraction, &end, x, memory)
}
