//! What is asked of any discrete Lagrangian on G×G×G: of the extremal actions of described systems, of random polynomials and of a
//! user's own.

use super::super::differences::{compared, reach, slope};
use super::super::precision::Measured;
use super::super::question::{Answer, singular};
use super::{DOUBLED, KEEPS_U, NO_U, Planted, U_RIGHT, U_SIGN, V_RIGHT, VALUE, compare, inverse};
use crate::algebra::{Covector, Matrix, Vector, pair};
use crate::discrete::legendre::flow;
use crate::discrete::{DiscreteLagrangian, Slopes, Triple};
use crate::group::LieGroup;
use crate::harness::{About, Cost};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::{Real, max_abs};

/// What [`slopes`] judges.
pub(in crate::laws) const SLOPES: About = About {
    name: "discrete-slopes",
    statement: "L* of D₁, D₂ and D₃l_d are the derivatives of the value along g τ(s ξ), and L* = Ad* R*",
    source: "Martín de Diego and Sato Martín de Almagro 2019, §5, before (5.2), and §5.2",
    oracle: "differences of the value, extrapolated to fourth order; Ad by conjugation of matrices",
    bound: "2⁸ times the estimated error of the differences with 2⁶ N u; in each precision by itself",
    needs: "",
    cost: Cost::Moderate,
    faults: &[VALUE, V_RIGHT, U_RIGHT, U_SIGN, DOUBLED],
};

/// What [`antisymmetry`] judges.
pub(in crate::laws) const ANTISYMMETRY: About = About {
    name: "discrete-antisymmetry",
    statement: "l_d satisfies l_d ∘ ι̌_d = −l_d off the units, ι̌_d(V, U, W) = (W, U⁻¹, V)",
    source: "Martín de Diego and Sato Martín de Almagro 2019, §5.1, after Prop 5.2, and Thm 5.4",
    oracle: "the same function at the inverse triple",
    bound: "two precisions; floor 2⁶ N u of the slopes, by which rounding of V, U and W is multiplied",
    needs: "the claim `antisymmetric`: l_d comes from a forced system",
    cost: Cost::Moderate,
    faults: &[KEEPS_U, VALUE],
};

/// What [`units`] judges.
pub(in crate::laws) const UNITS: About = About {
    name: "discrete-units",
    statement: "F_{l_d} takes units (V, e, V) to units, if l_d ∘ ι̌_d = −l_d to first order on them",
    source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 5.3: it depends on the derivatives on the units alone",
    oracle: "the units themselves",
    bound: "two precisions; floor 2⁸ N D u of the group elements",
    needs: "the claim `antisymmetric` or `keeps_units`",
    cost: Cost::Expensive,
    faults: &[NO_U, U_SIGN, DOUBLED],
};

impl<L> Planted<'_, L> {
    /// The value, if it is finite.
    pub fn number<T: Real, const N: usize, const D: usize>(&self, x: &Triple<T, D>) -> Result<T, Measured>
    where
        L: DiscreteLagrangian<T, N, D>,
    {
        let value = DiscreteLagrangian::<T, N, D>::value(self, x)?;
        match value.all_finite() {
            true => Ok(value),
            false => Err(Measured::Broken(format!("l_d = {}", value.to_f64()))),
        }
    }

    /// The slopes, if they are finite.
    pub fn rows<T: Real, const N: usize, const D: usize>(&self, x: &Triple<T, D>) -> Result<Slopes<T, N>, Measured>
    where
        L: DiscreteLagrangian<T, N, D>,
    {
        let slopes = self.slopes(x)?;
        match largest(&slopes).all_finite() {
            true => Ok(slopes),
            false => Err(Measured::Broken("a slope is not finite".into())),
        }
    }
}

/// The largest slope.
pub(in crate::laws) fn largest<T: Real, const N: usize>(slopes: &Slopes<T, N>) -> T {
    slopes.all().into_iter().fold(T::zero(), |size, row| size.max(row.amax()))
}

/// [`SLOPES`] at (V, U, W), along V τ(s ξ), U τ(s ξ'), W τ(s ξ'') for the three directions, with s up to 2⁻¹¹ `scale` in `f64`.
pub(in crate::laws) fn slopes<T: Real, const N: usize, const D: usize>(
    l_d: &Planted<'_, impl DiscreteLagrangian<T, N, D>>,
    group: &impl LieGroup<T, N, D>,
    tau: impl Fn(&Vector<T, N>) -> Result<Matrix<T, D>, RetractionError>,
    x: &Triple<T, D>,
    along: &[Vector<T, N>; 3],
    scale: T,
) -> Answer {
    l_d.number::<T, N, D>(x)?;
    let rows = l_d.rows(x)?;
    let size = largest(&rows);
    let floor = 64.0 * N as f64;
    let sides = |what: &str, left: &Covector<T, N>, right: &Covector<T, N>, g: &Matrix<T, D>| {
        let ad = group.adjoint(g).ok_or_else(singular)?;
        let allowed = T::exact(floor) * T::unit_roundoff() * size * ad.amax().max(T::one());
        let differ = || format!("L* and Ad* R* differ at {what}");
        Ok::<_, Measured>(Measured::within(max_abs(&(left - right * ad)), allowed, differ))
    };
    let measured = sides("V", &rows.v_left, &rows.v_right, &x.v)?
        .and(sides("U", &rows.u_left, &rows.u_right, &x.u)?)
        .and(sides("W", &rows.w_left, &rows.w_right, &x.w)?);
    let length = along.iter().fold(T::zero(), |length, along| length.max(along.amax()));
    if length == T::zero() {
        return Ok(measured);
    }
    let moved = |s: T| {
        let [v, u, w] = [&along[0], &along[1], &along[2]].map(|along| tau(&(along * s)));
        Ok::<_, Measured>(Triple { v: x.v * v?, u: x.u * u?, w: x.w * w? })
    };
    let far = size.max(largest(&l_d.rows(&moved(reach(scale))?)?));
    let mut stopped = None;
    let value = |s: T| {
        let value = moved(s).and_then(|moved| l_d.number::<T, N, D>(&moved));
        value.map_err(|why| stopped = Some(why)).ok()
    };
    let differences = slope(value, scale, far * length);
    let Some(differences) = differences else {
        return Err(stopped.unwrap_or(Measured::NotApplicable("a point is outside the domain".into())));
    };
    let found = pair(&rows.v_left, &along[0]) + pair(&rows.u_left, &along[1]) + pair(&rows.w_left, &along[2]);
    // At rest the slopes vanish, and what is left is rounding of those at displaced points.
    let (size, beyond) = (size * length, (far - size) * length);
    Ok(measured.and(compared(found, &differences, size, beyond, floor, "the slope along a direction")))
}

/// [`ANTISYMMETRY`] at (V, U, W).
pub(in crate::laws) fn antisymmetry<T: Real, const N: usize, const D: usize>(
    l_d: &Planted<'_, impl DiscreteLagrangian<T, N, D>>,
    x: &Triple<T, D>,
) -> Answer {
    let back = inverse(x, l_d.fault)?;
    let (here, there) = (l_d.number::<T, N, D>(x)?, l_d.number::<T, N, D>(&back)?);
    // Rounding moves an entry by u times the largest.
    let entries = [&x.v, &x.u, &x.w, &back.u].into_iter().fold(T::one(), |size, g| size.max(g.amax()));
    let size = here.abs() + largest(&l_d.rows(x)?) * entries;
    Ok(Measured::defect((here + there).abs(), size, 64.0 * N as f64, || {
        format!("l_d(V, U, W) = {:e}, l_d(W, U⁻¹, V) = {:e}", here.to_f64(), there.to_f64())
    }))
}

/// [`UNITS`] at (V, e, V).
pub(in crate::laws) fn units<T: Real, const N: usize, const D: usize>(
    l_d: &Planted<'_, impl DiscreteLagrangian<T, N, D>>,
    retraction: &impl Retraction<T, N, D>,
    v: Matrix<T, D>,
) -> Answer {
    let end = flow(l_d, l_d, retraction, &Triple::unit(v))?;
    Ok(compare(&end, &Triple::unit(end.v), T::one(), 256.0 * (N * D) as f64))
}
