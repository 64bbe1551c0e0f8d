//! The two retractions of SO(3) on eight displacements at once.

use super::Vec3;
use crate::integrators::lanes::Lanes;

#[inline(always)]
pub(in crate::integrators) fn dot<V: Lanes>(x: Vec3<V>, y: Vec3<V>) -> V {
    x[2].mul_add(y[2], x[1].mul_add(y[1], x[0] * y[0]))
}

#[inline(always)]
pub(in crate::integrators) fn cross<V: Lanes>(x: Vec3<V>, y: Vec3<V>) -> Vec3<V> {
    [x[2].neg_mul_add(y[1], x[1] * y[2]), x[0].neg_mul_add(y[2], x[2] * y[0]), x[1].neg_mul_add(y[0], x[0] * y[1])]
}

/// x + α y.
#[inline(always)]
pub(in crate::integrators) fn add_scaled<V: Lanes>(x: Vec3<V>, alpha: V, y: Vec3<V>) -> Vec3<V> {
    [alpha.mul_add(y[0], x[0]), alpha.mul_add(y[1], x[1]), alpha.mul_add(y[2], x[2])]
}

#[inline(always)]
pub(in crate::integrators) fn scale<V: Lanes>(alpha: V, x: Vec3<V>) -> Vec3<V> {
    [alpha * x[0], alpha * x[1], alpha * x[2]]
}

/// τ and its tangents on a group of dimension N, as operations on vectors in lanes; covectors are columns here.
pub trait LaneRetraction<const N: usize = 3>: Copy + Send + Sync + 'static {
    /// What the operations at x share.
    type At<V: Lanes>: Copy;

    /// The coefficients at x.
    fn at<V: Lanes>(x: [V; N]) -> Self::At<V>;
    /// p dτ_x⁻¹.
    fn unpull<V: Lanes>(at: Self::At<V>, x: [V; N], p: [V; N]) -> [V; N];
    /// dτ_x⁻¹ η.
    fn rate<V: Lanes>(at: Self::At<V>, x: [V; N], eta: [V; N]) -> [V; N];
    /// f dτ_x.
    fn pull<V: Lanes>(at: Self::At<V>, x: [V; N], f: [V; N]) -> [V; N];
    /// f dτ_x − f, where it can be without the difference.
    #[inline(always)]
    fn pull_less<V: Lanes>(at: Self::At<V>, x: [V; N], f: [V; N]) -> [V; N] {
        let pulled = Self::pull(at, x, f);
        each!(N, k => pulled[k] - f[k])
    }
    /// f Ad_{τ(x)}⁻¹ − f; on SO(3) the rotation τ(x) applied to f, less f.
    fn turned<V: Lanes>(at: Self::At<V>, x: [V; N], f: [V; N]) -> [V; N];
    /// [`turned`](Self::turned), where `pulled` = f dτ_x is known: for both maps on SO(3) Ad_{τ(x)} − 1 = ad_x ∘ dτ_x.
    #[inline(always)]
    fn turned_from<V: Lanes>(at: Self::At<V>, x: [V; N], f: [V; N], _pulled: [V; N]) -> [V; N] {
        Self::turned(at, x, f)
    }
    /// p ddτ_x(y, ·), with m = p dτ_x⁻¹.
    fn pull_dd<V: Lanes>(at: Self::At<V>, x: [V; N], p: [V; N], m: [V; N], y: [V; N]) -> [V; N];
    /// ad*_η m.
    fn coad<V: Lanes>(m: [V; N], eta: [V; N]) -> [V; N];
    /// What τ(ξ), ξ = −`back`, adds to a state of one body: row a of `values` holds component a of μ in lane 3, and g in
    /// the other lanes. The same row of `kicks` holds the component of m − μ in lane 3, and zeros.
    fn increments<V: Lanes>(at_back: Self::At<V>, back: [V; N], values: [V; N], kicks: [V; N]) -> [V; N];
    /// The square of the angle of x.
    fn square<V: Lanes>(x: [V; N]) -> V;
    /// Whether the formulas hold to round-off up to this square.
    fn in_domain(largest_square: f64) -> bool;
}

/// The Cayley map.
#[derive(Clone, Copy, Debug)]
pub struct Cayley;

impl LaneRetraction for Cayley {
    /// 2/q, q = 4 + |x|².
    type At<V: Lanes> = V;

    #[inline(always)]
    fn at<V: Lanes>(x: Vec3<V>) -> V {
        let q = x[2].mul_add(x[2], x[1].mul_add(x[1], x[0].mul_add(x[0], x[0].constant(4.0))));
        q.constant(2.0) * q.reciprocal()
    }

    #[inline(always)]
    fn unpull<V: Lanes>(_: V, x: Vec3<V>, p: Vec3<V>) -> Vec3<V> {
        let half = x[0].constant(0.5);
        let y = scale(half, x);
        add_scaled(add_scaled(p, half.constant(-1.0), cross(y, p)), dot(y, p), y)
    }

    #[inline(always)]
    fn rate<V: Lanes>(_: V, x: Vec3<V>, eta: Vec3<V>) -> Vec3<V> {
        let y = scale(x[0].constant(0.5), x);
        add_scaled(add_scaled(eta, x[0].constant(1.0), cross(y, eta)), dot(y, eta), y)
    }

    #[inline(always)]
    fn pull<V: Lanes>(at: V, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        scale(at, add_scaled(cross(x, f), at.constant(2.0), f))
    }

    #[inline(always)]
    fn pull_less<V: Lanes>(at: V, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        scale(at, add_scaled(cross(x, f), at.constant(-0.5) * dot(x, x), f))
    }

    #[inline(always)]
    fn turned<V: Lanes>(at: V, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        let once = cross(x, f);
        scale(at, add_scaled(cross(x, once), at.constant(2.0), once))
    }

    #[inline(always)]
    fn turned_from<V: Lanes>(_: V, x: Vec3<V>, _: Vec3<V>, pulled: Vec3<V>) -> Vec3<V> {
        cross(x, pulled)
    }

    #[inline(always)]
    fn pull_dd<V: Lanes>(at: V, x: Vec3<V>, p: Vec3<V>, m: Vec3<V>, y: Vec3<V>) -> Vec3<V> {
        scale(at, add_scaled(cross(m, y), -dot(p, y), x))
    }

    #[inline(always)]
    fn coad<V: Lanes>(m: Vec3<V>, eta: Vec3<V>) -> Vec3<V> {
        cross(m, eta)
    }

    /// The rows of g, in lanes 0, 1, 2, are turned as m is.
    #[inline(always)]
    fn increments<V: Lanes>(at_back: Self::At<V>, back: Vec3<V>, values: Vec3<V>, kicks: Vec3<V>) -> Vec3<V> {
        let turned = Self::turned(at_back, back, each!(3, k => values[k] + kicks[k]));
        each!(3, k => turned[k] + kicks[k])
    }

    #[inline(always)]
    fn square<V: Lanes>(x: Vec3<V>) -> V {
        dot(x, x)
    }

    fn in_domain(largest_square: f64) -> bool {
        largest_square < 1e16
    }
}

/// The exponential.
#[derive(Clone, Copy, Debug)]
pub struct Exponential;

/// (1 − cos θ)/θ² and what follows from it, as functions of t = θ².
#[derive(Clone, Copy, Debug)]
pub struct Coefficients<V> {
    /// sin θ/θ.
    sinc: V,
    /// A = (1 − cos θ)/t.
    a: V,
    /// B = (θ − sin θ)/θ³.
    b: V,
    /// A'(t).
    a_slope: V,
    /// B'(t).
    b_slope: V,
    /// G = (1 − (θ/2) cot(θ/2))/t = −A'/A.
    g: V,
}

/// The largest t at which [`Coefficients`] hold to round-off: the angle 6, short of the singularity of dτ at 2π.
pub(super) const LARGEST_SQUARE: f64 = 36.0;

/// The number of terms of the series at t/16 ≤ 9/4: the first one left out is below 2⁻⁵⁶ of the sum.
const TERMS: usize = 11;

/// n!, exact up to 22! (22!/2¹⁹ < 2⁵³).
const fn factorial(n: usize) -> f64 {
    let (mut product, mut k) = (1.0, 2);
    while k <= n {
        product *= k as f64;
        k += 1;
    }
    product
}

/// (−1)^k/(2k + `shift`)!: A for shift 2, B for shift 3.
const fn series(shift: usize) -> [f64; TERMS] {
    let (mut terms, mut k) = ([0.0; TERMS], 0);
    while k < TERMS {
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        terms[k] = sign / factorial(2 * k + shift);
        k += 1;
    }
    terms
}

/// The coefficients of the derivative of a series, but for the last.
const fn slopes(terms: [f64; TERMS]) -> [f64; TERMS - 1] {
    let (mut slopes, mut k) = ([0.0; TERMS - 1], 0);
    while k + 1 < TERMS {
        slopes[k] = (k + 1) as f64 * terms[k + 1];
        k += 1;
    }
    slopes
}

const A: [f64; TERMS] = series(2);
const B: [f64; TERMS] = series(3);
const A_SLOPE: [f64; TERMS - 1] = slopes(A);
const B_SLOPE: [f64; TERMS - 1] = slopes(B);

#[inline(always)]
fn horner<V: Lanes, const K: usize>(terms: &[f64; K], u: V) -> V {
    let mut sum = u.constant(terms[K - 1]);
    for k in (0..K - 1).rev() {
        sum = sum.mul_add(u, u.constant(terms[k]));
    }
    sum
}

impl LaneRetraction for Exponential {
    type At<V: Lanes> = Coefficients<V>;

    /// Series at θ/4, then A(4u) = A(1 − uA/2), B(4u) = (B + A(1 − uB))/4 twice, and the derivatives of these: no
    /// difference of nearly equal numbers.
    #[inline(always)]
    fn at<V: Lanes>(x: Vec3<V>) -> Coefficients<V> {
        let (one, half, quarter) = (x[0].constant(1.0), x[0].constant(0.5), x[0].constant(0.25));
        let t = dot(x, x);
        let mut u = t * x[0].constant(0.0625);
        let (mut a, mut b) = (horner(&A, u), horner(&B, u));
        let (mut a_slope, mut b_slope) = (horner(&A_SLOPE, u), horner(&B_SLOPE, u));
        for _ in 0..2 {
            let sinc = u.neg_mul_add(b, one);
            let b_slope_sum = a_slope.mul_add(sinc, b_slope) - a * u.mul_add(b_slope, b);
            let b_sum = a.mul_add(sinc, b);
            a_slope = quarter * (half * a).neg_mul_add(a, a_slope * u.neg_mul_add(a, one));
            a = (half * u * a).neg_mul_add(a, a);
            b = quarter * b_sum;
            b_slope = (quarter * quarter) * b_slope_sum;
            u = x[0].constant(4.0) * u;
        }
        Coefficients { sinc: t.neg_mul_add(b, one), a, b, a_slope, b_slope, g: -a_slope / a }
    }

    #[inline(always)]
    fn unpull<V: Lanes>(at: Coefficients<V>, x: Vec3<V>, p: Vec3<V>) -> Vec3<V> {
        let once = cross(x, p);
        add_scaled(add_scaled(p, x[0].constant(-0.5), once), at.g, cross(x, once))
    }

    #[inline(always)]
    fn rate<V: Lanes>(at: Coefficients<V>, x: Vec3<V>, eta: Vec3<V>) -> Vec3<V> {
        let once = cross(x, eta);
        add_scaled(add_scaled(eta, x[0].constant(0.5), once), at.g, cross(x, once))
    }

    #[inline(always)]
    fn pull<V: Lanes>(at: Coefficients<V>, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        let once = cross(x, f);
        add_scaled(add_scaled(f, at.a, once), at.b, cross(x, once))
    }

    #[inline(always)]
    fn pull_less<V: Lanes>(at: Coefficients<V>, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        let once = cross(x, f);
        add_scaled(scale(at.a, once), at.b, cross(x, once))
    }

    #[inline(always)]
    fn turned<V: Lanes>(at: Coefficients<V>, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        let once = cross(x, f);
        add_scaled(scale(at.sinc, once), at.a, cross(x, once))
    }

    #[inline(always)]
    fn turned_from<V: Lanes>(_: Coefficients<V>, x: Vec3<V>, _: Vec3<V>, pulled: Vec3<V>) -> Vec3<V> {
        cross(x, pulled)
    }

    /// m ∂_x(dτ_x y) = (m·u) x + m × z + B(x·y) m, u = −2A' x×y + 2B' x×(x×y) − B y, z = A y − B x×y.
    #[inline(always)]
    fn pull_dd<V: Lanes>(at: Coefficients<V>, x: Vec3<V>, _p: Vec3<V>, m: Vec3<V>, y: Vec3<V>) -> Vec3<V> {
        let two = x[0].constant(2.0);
        let once = cross(x, y);
        let twice = cross(x, once);
        let u = add_scaled(add_scaled(scale(two * at.b_slope, twice), -(two * at.a_slope), once), -at.b, y);
        let z = add_scaled(scale(at.a, y), -at.b, once);
        add_scaled(add_scaled(cross(m, z), dot(m, u), x), at.b * dot(x, y), m)
    }

    #[inline(always)]
    fn coad<V: Lanes>(m: Vec3<V>, eta: Vec3<V>) -> Vec3<V> {
        cross(m, eta)
    }

    /// The rows of g, in lanes 0, 1, 2, are turned as m is.
    #[inline(always)]
    fn increments<V: Lanes>(at_back: Self::At<V>, back: Vec3<V>, values: Vec3<V>, kicks: Vec3<V>) -> Vec3<V> {
        let turned = Self::turned(at_back, back, each!(3, k => values[k] + kicks[k]));
        each!(3, k => turned[k] + kicks[k])
    }

    #[inline(always)]
    fn square<V: Lanes>(x: Vec3<V>) -> V {
        dot(x, x)
    }

    fn in_domain(largest_square: f64) -> bool {
        largest_square <= LARGEST_SQUARE
    }
}
