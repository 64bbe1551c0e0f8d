//! Derivatives by differences, with an estimate of their error: what derivatives by dual numbers are compared with.

use super::precision::Measured;
use crate::scalar::Real;

/// The derivative at 0 of a function of a step, with what truncation and rounding may have done to it.
pub(super) struct Slope<T> {
    pub value: T,
    pub error: T,
    /// The part of the error that is rounding.
    rounding: T,
}

/// The largest step of [`slope`], h ≈ u^{1/5} `scale`.
pub(super) fn reach<T: Real>(scale: T) -> T {
    scale * T::exact(2f64.powi((T::unit_roundoff().to_f64().log2() / 5.0).round() as i32))
}

/// F'(0) by central differences at h, h/2 and h/4, extrapolated twice to fourth order, for h = [`reach`] `(scale)`.
///
/// The error is the distance of the two extrapolated values, and the rounding 16 u (|F| + s)/h, with s = `typical` `scale` for
/// what cancels in F; `typical` is a size of the derivative at all steps up to h, not at 0 alone: rounding of what F is evaluated at is
/// multiplied by it. `None` where F is not defined.
pub(super) fn slope<T: Real>(mut f: impl FnMut(T) -> Option<T>, scale: T, typical: T) -> Option<Slope<T>> {
    let h = reach(scale);
    let mut size = typical * scale;
    let mut central = |h: T| {
        let (above, below) = (f(h)?, f(-h)?);
        size = size.max(above.abs()).max(below.abs());
        Some((above - below) / (h + h))
    };
    let (one, two, four) = (central(h)?, central(h * T::half())?, central(h * T::exact(0.25))?);
    let extrapolated = |coarse: T, fine: T| (fine * T::int(4) - coarse) / T::int(3);
    let (coarse, fine) = (extrapolated(one, two), extrapolated(two, four));
    let rounding = T::int(16) * T::unit_roundoff() * size / h;
    Some(Slope { value: fine, error: (coarse - fine).abs() + rounding, rounding })
}

/// A derivative against its differences, in units of their error and of `floor` u of the size; not in units of round-off.
///
/// Inconclusive where the differences do not converge: the error is above 1/64 of the derivative and of `size`. Where the function is a
/// sum of `terms` so large, which may cancel, rounding is relative to them, and an error that is rounding is none of the differences.
pub(super) fn compared<T: Real>(found: T, slope: &Slope<T>, size: T, terms: T, floor: f64, witness: &str) -> Measured {
    if !found.all_finite() {
        return Measured::Broken(format!("{witness}: the derivative by duals is not finite"));
    }
    let largest = size.max(slope.value.abs()).max(found.abs());
    let rounded = terms > T::zero() && slope.error <= slope.rounding * T::int(2);
    let converged = slope.error == T::zero() || slope.error * T::int(64) <= largest || rounded;
    if !converged {
        return Measured::Inconclusive("differences do not converge here".into());
    }
    let allowed = slope.error + T::exact(floor) * T::unit_roundoff() * (largest + terms);
    Measured::within((found - slope.value).abs(), allowed, || {
        format!("{witness}: by duals {:e}, by differences {:e}", found.to_f64(), slope.value.to_f64())
    })
}
