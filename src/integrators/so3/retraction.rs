//! The two retractions of SO(3) on eight displacements at once.

use crate::integrators::lanes::vectors::{add_cross, add_scaled, cross, dot, horner, length, less_scaled, scale};
use crate::integrators::lanes::{FastRetraction, LaneGroup, Lanes, Vec3, each};
use crate::retraction::{CayleySo3, ExponentialSo3};

/// What an ensemble of bodies on SO(3) needs besides: its attitudes are quaternions (see
/// [`HalfAngle`](super::HalfAngle)). For both maps Ad_{τ(x)} − 1 = ad_x ∘ dτ_x, so that f Ad_{τ(x)}⁻¹ = f + x × (f dτ_x), with
/// covectors as columns.
#[doc(hidden)]
pub trait LaneRotation: LaneGroup + Copy {
    /// The map.
    const MAP: Self;

    /// Up to which [`size`](Self::size) a step is an ordinary one: in the domain, and |q|² of no quaternion
    /// grows by more than 16 times.
    const ORDINARY: f64;

    /// A measure of x that is at hand.
    fn size<V: Lanes>(&self, at: &Self::At<V>, x: Vec3<V>) -> V;

    /// f dτ_x − f, without the difference.
    fn pull_less<V: Lanes>(&self, at: &Self::At<V>, x: Vec3<V>, f: Vec3<V>) -> Vec3<V>;

    /// sum + f Ad_{τ(x)}⁻¹ − f, with `less` = f dτ_x − f at hand: sum + u x × (f + less).
    fn add_turned<V: Lanes>(&self, x: Vec3<V>, f: Vec3<V>, less: Vec3<V>, sum: Vec3<V>) -> Vec3<V>;

    /// sum + q ⊗ (τ(−x) − 1) up to a factor, which is that of q + q ⊗ (τ(−x) − 1): w, x, y, z.
    fn rotated<V: Lanes>(&self, at: &Self::At<V>, x: Vec3<V>, q: [V; 4], sum: [V; 4]) -> [V; 4];
}

/// sum − q ⊗ (0, y).
#[inline(always)]
pub(super) fn less_product<V: Lanes>(sum: [V; 4], q: [V; 4], y: Vec3<V>) -> [V; 4] {
    let [w, a, b, c] = q;
    [
        c.mul_add(y[2], b.mul_add(y[1], a.mul_add(y[0], sum[0]))),
        w.neg_mul_add(y[0], c.mul_add(y[1], b.neg_mul_add(y[2], sum[1]))),
        w.neg_mul_add(y[1], a.mul_add(y[2], c.neg_mul_add(y[0], sum[2]))),
        w.neg_mul_add(y[2], b.mul_add(y[0], a.neg_mul_add(y[1], sum[3]))),
    ]
}

/// The series of Magnus to t⁴, which [`LaneGroup::displacement`] starts from.
#[inline(always)]
fn magnus<V: Lanes>(t: V, first: Vec3<V>, middle: Vec3<V>, last: Vec3<V>) -> Vec3<V> {
    let (four, sixth, twelfth) = (t.constant(4.0), t * t.constant(1.0 / 6.0), t * t.constant(1.0 / 12.0));
    let sum = each!(3, k => sixth * four.mul_add(middle[k], first[k] + last[k]));
    add_scaled(sum, twelfth, cross(sum, each!(3, k => last[k] - first[k])))
}

/// What so(3) has with either map. The rows of g are turned as covectors are.
macro_rules! in_vectors {
    () => {
        #[inline(always)]
        fn add_coad<V: Lanes>(&self, sum: Vec3<V>, m: Vec3<V>, eta: Vec3<V>) -> Vec3<V> {
            add_cross(sum, m, eta)
        }

        #[inline(always)]
        fn coad<V: Lanes>(&self, m: Vec3<V>, eta: Vec3<V>) -> Vec3<V> {
            cross(m, eta)
        }

        #[inline(always)]
        fn moved_back<V: Lanes>(&self, at: &Self::At<V>, x: Vec3<V>, row: Vec3<V>) -> Vec3<V> {
            self.turned(at, x, row)
        }

        #[inline]
        fn turning(&self, eta: [f64; 3]) -> f64 {
            length(eta)
        }

        fn rotation(&self) -> usize {
            3
        }
    };
}

/// The Cayley map.
#[derive(Clone, Copy, Debug)]
pub struct Cayley;

/// tan(θ/2)/θ in powers of θ².
pub(in crate::integrators) const TANGENT: [f64; 4] = [0.5, 1.0 / 24.0, 1.0 / 240.0, 17.0 / 40320.0];

/// q = 1 + |y|², y = x/2, and 1/q.
#[derive(Clone, Copy, Debug)]
pub struct Denominator<V> {
    q: V,
    per_q: V,
}

impl LaneGroup for Cayley {
    const HALVED: bool = true;

    type At<V: Lanes> = Denominator<V>;

    in_vectors!();

    #[inline(always)]
    fn at<V: Lanes>(&self, y: Vec3<V>, _: bool) -> Denominator<V> {
        let q = y[2].mul_add(y[2], y[1].mul_add(y[1], y[0].mul_add(y[0], y[0].constant(1.0))));
        Denominator { q, per_q: q.reciprocal() }
    }

    /// p + p × y + (y·p) y.
    #[inline(always)]
    fn unpull<V: Lanes>(&self, _: &Denominator<V>, y: Vec3<V>, p: Vec3<V>) -> Vec3<V> {
        add_scaled(add_cross(p, p, y), dot(y, p), y)
    }

    /// η + y × η + (y·η) y.
    #[inline(always)]
    fn rate<V: Lanes>(&self, _: &Denominator<V>, y: Vec3<V>, eta: Vec3<V>) -> Vec3<V> {
        add_scaled(add_cross(eta, y, eta), dot(y, eta), y)
    }

    /// (f + y × f)/(1 + |y|²).
    #[inline(always)]
    fn pull<V: Lanes>(&self, at: &Denominator<V>, y: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        scale(at.per_q, add_cross(f, y, f))
    }

    /// 2 y × (f + y × f)/(1 + |y|²).
    #[inline(always)]
    fn turned<V: Lanes>(&self, at: &Denominator<V>, y: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        scale(at.per_q + at.per_q, cross(y, add_cross(f, y, f)))
    }

    /// f + 2 y × (f + y × f)/(1 + |y|²).
    #[inline(always)]
    fn carried<V: Lanes>(&self, at: &Denominator<V>, y: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        add_cross(f, y, scale(at.per_q + at.per_q, add_cross(f, y, f)))
    }

    /// v + 2 (v + v × y) × y/(1 + |y|²).
    #[inline(always)]
    fn moved<V: Lanes>(&self, at: &Denominator<V>, y: Vec3<V>, v: Vec3<V>) -> Vec3<V> {
        add_cross(v, scale(at.per_q + at.per_q, add_cross(v, v, y)), y)
    }

    /// (m × z − 2 (p·z) y)/(1 + |y|²), z half the rate.
    #[inline(always)]
    fn pull_dd<V: Lanes>(
        &self,
        at: &Denominator<V>,
        y: Vec3<V>,
        p: Vec3<V>,
        m: Vec3<V>,
        _eta: Vec3<V>,
        z: Vec3<V>,
    ) -> Vec3<V> {
        let along = dot(p, z);
        scale(at.per_q, less_scaled(cross(m, z), along + along, y))
    }

    /// (f + y × f + m × z − (m·η) y)/(1 + |y|²), z half the rate.
    #[inline(always)]
    fn gradient<V: Lanes>(
        &self,
        at: &Denominator<V>,
        y: Vec3<V>,
        _p: Vec3<V>,
        m: Vec3<V>,
        eta: Vec3<V>,
        z: Vec3<V>,
        f: Vec3<V>,
    ) -> Vec3<V> {
        let u = add_cross(f, y, f);
        scale(at.per_q, less_scaled(add_cross(u, m, z), dot(m, eta), y))
    }

    /// tan(θ/2)/θ σ, θ = |σ|, to θ⁶.
    #[inline(always)]
    fn displacement<V: Lanes>(&self, t: V, first: Vec3<V>, middle: Vec3<V>, last: Vec3<V>) -> Vec3<V> {
        let sigma = magnus(t, first, middle, last);
        scale(horner(&TANGENT, dot(sigma, sigma)), sigma)
    }

    #[inline(always)]
    fn distance<V: Lanes>(&self, _: &Denominator<V>, y: Vec3<V>) -> V {
        y[0].constant(4.0) * dot(y, y)
    }

    fn in_domain(&self, distance: f64) -> bool {
        distance < 1e16
    }
}

impl LaneRotation for Cayley {
    const MAP: Self = Self;
    const ORDINARY: f64 = 16.0;

    /// (y × f − |y|² f)/(1 + |y|²).
    #[inline(always)]
    fn pull_less<V: Lanes>(&self, at: &Denominator<V>, y: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        scale(at.per_q, less_scaled(cross(y, f), dot(y, y), f))
    }

    /// 1 + |y|².
    #[inline(always)]
    fn size<V: Lanes>(&self, at: &Denominator<V>, _: Vec3<V>) -> V {
        at.q
    }

    /// y × f is in [`pull_less`](LaneRotation::pull_less), too.
    #[inline(always)]
    fn add_turned<V: Lanes>(&self, y: Vec3<V>, f: Vec3<V>, less: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
        add_scaled(sum, y[0].constant(2.0), add_cross(cross(y, f), y, less))
    }

    /// τ(−x) is (1, −y) up to a factor.
    #[inline(always)]
    fn rotated<V: Lanes>(&self, _: &Denominator<V>, y: Vec3<V>, q: [V; 4], sum: [V; 4]) -> [V; 4] {
        less_product(sum, q, y)
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
    /// sin(θ/2)/(θ/2).
    half_sinc: V,
    /// (1 − cos(θ/2))/(θ/2)².
    half_a: V,
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

impl LaneGroup for Exponential {
    const HALVED: bool = false;

    type At<V: Lanes> = Coefficients<V>;

    in_vectors!();

    /// Series at θ/4, then A(4u) = A(1 − uA/2), B(4u) = (B + A(1 − uB))/4 twice, and the derivatives of these: no
    /// difference of nearly equal numbers.
    #[inline(always)]
    fn at<V: Lanes>(&self, x: Vec3<V>, _: bool) -> Coefficients<V> {
        let (one, half, quarter) = (x[0].constant(1.0), x[0].constant(0.5), x[0].constant(0.25));
        let t = dot(x, x);
        let mut u = t * x[0].constant(0.0625);
        let (mut a, mut b) = (horner(&A, u), horner(&B, u));
        let (mut a_slope, mut b_slope) = (horner(&A_SLOPE, u), horner(&B_SLOPE, u));
        let (mut half_sinc, mut half_a) = (one, a);
        for _ in 0..2 {
            // The last time round, those of θ/2.
            let sinc = u.neg_mul_add(b, one);
            (half_sinc, half_a) = (sinc, a);
            let b_slope_sum = a_slope.mul_add(sinc, b_slope) - a * u.mul_add(b_slope, b);
            let b_sum = a.mul_add(sinc, b);
            a_slope = quarter * (half * a).neg_mul_add(a, a_slope * u.neg_mul_add(a, one));
            a = (half * u * a).neg_mul_add(a, a);
            b = quarter * b_sum;
            b_slope = (quarter * quarter) * b_slope_sum;
            u = x[0].constant(4.0) * u;
        }
        Coefficients { sinc: t.neg_mul_add(b, one), half_sinc, half_a, a, b, a_slope, b_slope, g: -a_slope / a }
    }

    #[inline(always)]
    fn unpull<V: Lanes>(&self, at: &Coefficients<V>, x: Vec3<V>, p: Vec3<V>) -> Vec3<V> {
        let once = cross(x, p);
        add_scaled(add_scaled(p, x[0].constant(-0.5), once), at.g, cross(x, once))
    }

    #[inline(always)]
    fn rate<V: Lanes>(&self, at: &Coefficients<V>, x: Vec3<V>, eta: Vec3<V>) -> Vec3<V> {
        let once = cross(x, eta);
        add_scaled(add_scaled(eta, x[0].constant(0.5), once), at.g, cross(x, once))
    }

    #[inline(always)]
    fn pull<V: Lanes>(&self, at: &Coefficients<V>, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        let once = cross(x, f);
        add_scaled(add_scaled(f, at.a, once), at.b, cross(x, once))
    }

    #[inline(always)]
    fn turned<V: Lanes>(&self, at: &Coefficients<V>, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        let once = cross(x, f);
        add_scaled(scale(at.sinc, once), at.a, cross(x, once))
    }

    #[inline(always)]
    fn carried<V: Lanes>(&self, at: &Coefficients<V>, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        add_cross(f, x, self.pull(at, x, f))
    }

    /// v + (v − A x × v + B x × (x × v)) × x.
    #[inline(always)]
    fn moved<V: Lanes>(&self, at: &Coefficients<V>, x: Vec3<V>, v: Vec3<V>) -> Vec3<V> {
        let once = cross(x, v);
        add_cross(v, add_scaled(less_scaled(v, at.a, once), at.b, cross(x, once)), x)
    }

    /// m ∂_x(dτ_x y) = (m·u) x + m × z + B(x·y) m, u = −2A' x×y + 2B' x×(x×y) − B y, z = A y − B x×y.
    #[inline(always)]
    fn pull_dd<V: Lanes>(
        &self,
        at: &Coefficients<V>,
        x: Vec3<V>,
        _p: Vec3<V>,
        m: Vec3<V>,
        _eta: Vec3<V>,
        y: Vec3<V>,
    ) -> Vec3<V> {
        let two = x[0].constant(2.0);
        let once = cross(x, y);
        let twice = cross(x, once);
        let u = less_scaled(less_scaled(scale(two * at.b_slope, twice), two * at.a_slope, once), at.b, y);
        let z = less_scaled(scale(at.a, y), at.b, once);
        add_scaled(add_scaled(cross(m, z), dot(m, u), x), at.b * dot(x, y), m)
    }

    #[inline(always)]
    fn displacement<V: Lanes>(&self, t: V, first: Vec3<V>, middle: Vec3<V>, last: Vec3<V>) -> Vec3<V> {
        magnus(t, first, middle, last)
    }

    #[inline(always)]
    fn distance<V: Lanes>(&self, _: &Coefficients<V>, x: Vec3<V>) -> V {
        dot(x, x)
    }

    fn in_domain(&self, distance: f64) -> bool {
        distance <= LARGEST_SQUARE
    }

    /// exp has the period 2π along an axis.
    fn wound(&self, x: Vec3<f64>) -> Vec3<f64> {
        let angle = length(x);
        let rest = (angle / std::f64::consts::TAU).round().mul_add(-std::f64::consts::TAU, angle);
        let factor = if angle == 0.0 { 0.0 } else { rest / angle };
        x.map(|v| factor * v)
    }
}

impl LaneRotation for Exponential {
    const MAP: Self = Self;
    const ORDINARY: f64 = LARGEST_SQUARE;

    #[inline(always)]
    fn pull_less<V: Lanes>(&self, at: &Coefficients<V>, x: Vec3<V>, f: Vec3<V>) -> Vec3<V> {
        let once = cross(x, f);
        add_scaled(scale(at.a, once), at.b, cross(x, once))
    }

    #[inline(always)]
    fn size<V: Lanes>(&self, _: &Coefficients<V>, x: Vec3<V>) -> V {
        dot(x, x)
    }

    #[inline(always)]
    fn add_turned<V: Lanes>(&self, x: Vec3<V>, f: Vec3<V>, less: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
        add_cross(sum, x, each!(3, k => f[k] + less[k]))
    }

    /// τ(−x) is (cos θ/2, −x sin(θ/2)/θ).
    #[inline(always)]
    fn rotated<V: Lanes>(&self, at: &Coefficients<V>, x: Vec3<V>, q: [V; 4], sum: [V; 4]) -> [V; 4] {
        let half = x[0].constant(0.5);
        let (less, length) = (x[0].constant(-0.25) * dot(x, x) * at.half_a, half * at.half_sinc);
        less_product(each!(4, k => q[k].mul_add(less, sum[k])), q, scale(length, x))
    }
}

impl FastRetraction for CayleySo3<f64> {
    type Lanes = Cayley;
    type Steady = ExponentialSo3<f64>;

    fn in_lanes(&self) -> Cayley {
        Cayley
    }

    fn steady(&self) -> Option<ExponentialSo3<f64>> {
        Some(ExponentialSo3::new())
    }
}

impl FastRetraction for ExponentialSo3<f64> {
    type Lanes = Exponential;
    type Steady = Self;

    fn in_lanes(&self) -> Exponential {
        Exponential
    }
}
