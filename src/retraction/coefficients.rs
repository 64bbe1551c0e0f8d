//! The cancellation-prone coefficients of the exponential on SO(3), as functions of t = θ².
//!
//! Closed forms lose digits as t → 0 and are not differentiable there when written with θ = √t; power series lose
//! digits at large t. The switch is at t = 9, where neither does: there the closed forms amplify rounding at most
//! threefold, and the alternating series at most twofold. The number of terms comes from the unit round-off, so the
//! same line serves every scalar.

use crate::scalar::{Real, Scalar};

/// Below this t the power series are used.
const SWITCH: i64 = 9;
/// Below this ρ = 1/16 arctan(√ρ)/√ρ is summed. The closed form is accurate for every ρ > 0: the series is there
/// because √ρ has no derivative at 0.
const ARC_SWITCH: f64 = 0.0625;

/// The series of A, B, A', B' and of the arctangent, with as many terms as the precision of `T` needs.
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients<T: Real> {
    /// The coefficients of t^k in A, A', B, B'.
    series: Vec<[T; 4]>,
    /// The coefficients of ρ^k in arctan(√ρ)/√ρ.
    arc: Vec<T>,
}

/// The coefficients at one t = θ² (Martín de Diego and Sato Martín de Almagro 2019, §5.3; Iserles et al. 2000, app. B).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Values<S> {
    /// sin θ/θ; the error is a few units of round-off absolutely, not relatively.
    pub sinc: S,
    /// A = (1 − cos θ)/t.
    pub a: S,
    /// A' = dA/dt = (sin θ/θ − 2A)/(2t).
    pub a_slope: S,
    /// B = (θ − sin θ)/θ³.
    pub b: S,
    /// B' = dB/dt = (A − 3B)/(2t).
    pub b_slope: S,
    /// G = (1 − (θ/2) cot(θ/2))/t = −A'/A, or `None` where sin(θ/2) is zero to working precision (θ = 2πk, k ≠ 0).
    pub g: Option<S>,
}

impl<T: Real> Coefficients<T> {
    /// The series, cut where the remainder falls under a quarter of the unit round-off.
    pub fn new() -> Self {
        let unit = T::unit_roundoff() / T::int(4);
        let switch = T::int(SWITCH);
        let mut series = Vec::new();
        // 1/(2k+2)! and 1/(2k+3)! with the sign of (−1)^k; `power` is 9^k.
        let (mut a, mut b, mut power, mut spare) = (T::half(), T::ratio(1, 6), T::one(), 2);
        for k in 0.. {
            let n = 2 * k + 2;
            let (next_a, next_b) = (-a / T::int((n + 1) * (n + 2)), -b / T::int((n + 2) * (n + 3)));
            let order = T::int(k + 1);
            series.push([a, order * next_a, b, order * next_b]);
            // Each derivative taken by dual numbers costs a factor k: two spare terms pay for it.
            if order * a.abs() * power < unit {
                if spare == 0 {
                    break;
                }
                spare -= 1;
            }
            (a, b, power) = (next_a, next_b, power * switch);
        }
        let (mut arc, mut power, mut spare) = (Vec::new(), T::one(), 2);
        for k in 0.. {
            arc.push(T::ratio(if k % 2 == 0 { 1 } else { -1 }, 2 * k + 1));
            if power < unit {
                if spare == 0 {
                    break;
                }
                spare -= 1;
            }
            power *= T::exact(ARC_SWITCH);
        }
        Self { series, arc }
    }

    /// The coefficients at t ≥ 0, to a few units of round-off times max(1, θ) (the condition of sin θ).
    ///
    /// Smooth on dual numbers for every t, 0 included.
    pub fn at<S: Scalar<Base = T>>(&self, t: S) -> Values<S> {
        if t.base() < T::int(SWITCH) { self.sum(t) } else { Self::closed(t) }
    }

    fn sum<S: Scalar<Base = T>>(&self, t: S) -> Values<S> {
        let [mut a, mut a_slope, mut b, mut b_slope] = [S::zero(); 4];
        for term in self.series.iter().rev() {
            a = a * t + S::lift(term[0]);
            a_slope = a_slope * t + S::lift(term[1]);
            b = b * t + S::lift(term[2]);
            b_slope = b_slope * t + S::lift(term[3]);
        }
        Values { sinc: S::one() - t * b, a, a_slope, b, b_slope, g: Some(-a_slope / a) }
    }

    fn closed<S: Scalar<Base = T>>(t: S) -> Values<S> {
        let (one, two, three) = (S::one(), S::int(2), S::int(3));
        let angle = t.sqrt();
        let (sin, cos) = (angle * S::half()).sin_cos();
        let sinc = two * sin * cos / angle;
        let a = two * sin * sin / t;
        let b = (one - sinc) / t;
        let slope = cos - two * sin / angle;
        let singular = sin.base().abs() <= T::int(8) * T::unit_roundoff() * angle.base();
        Values {
            sinc,
            a,
            a_slope: sin * slope / (angle * t),
            b,
            b_slope: (a - three * b) / (two * t),
            g: if singular { None } else { Some(-slope / (two * sin * angle)) },
        }
    }

    /// arctan(√s/w)/√s for w > 0 and s ≥ 0, smooth on dual numbers at s = 0 and at w → 0 too.
    ///
    /// For a unit quaternion (w, v) and s = |v|², twice this times v is the rotation vector.
    pub fn half_angle<S: Scalar<Base = T>>(&self, w: S, s: S) -> S {
        let rho = s / (w * w);
        if rho.base() < T::exact(ARC_SWITCH) {
            return self.arc.iter().rev().fold(S::zero(), |sum, term| sum * rho + S::lift(*term)) / w;
        }
        let root = s.sqrt();
        root.atan2(w) / root
    }
}

impl<T: Real> Default for Coefficients<T> {
    fn default() -> Self {
        Self::new()
    }
}
