//! Quad-double numbers: about 64 digits, as an unevaluated sum of four `f64`.
//!
//! Products and quotients are those of `multidouble`; sums and the elementary functions are our own. A value whose size
//! is between 2⁻⁸⁰⁰ and 2¹⁰⁰⁰ (1e-240 and 1e300) has all its digits; below, the last parts run out of exponents.
//!
//! Accuracy of the functions relative to the value, in units of 2⁻²¹² (an eighth of u): 0.2 for √, the cube root and hypot;
//! 0.4 for exp, ln and the circular functions and their inverses; 1 for exp_m1, ln_1p and the hyperbolic functions and their
//! inverses. These are the worst against mpmath of 3000 arguments and more each, over that range, next to 0, to 1 and to
//! multiples of π/2.

use super::dd::{Dd, exponent, times_power_of_two};
use super::field::{Elementary, conventional_angle, quarter_turns, real_field};
use super::{Real, Scalar, decimal, fused};
use multidouble::dd::{quick_two_sum, two_sum};
use multidouble::exact::Dy;
use multidouble::qd::QD;
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};
use std::sync::LazyLock;

/// x₀ + x₁ + x₂ + x₃ with |xᵢ₊₁| ≤ ¾ ulp(xᵢ).
///
/// An operation that overflows, divides by zero or meets an infinity gives NaN or an infinity, which [`Scalar::all_finite`] sees.
#[derive(Clone, Copy, Debug, Default)]
pub struct Qd(QD);

impl Qd {
    /// The sum of the four, rounded to a quad-double.
    pub fn new(parts: [f64; 4]) -> Self {
        parts.into_iter().rev().fold(Self::exact(0.0), |sum, part| sum + Self::exact(part))
    }

    /// The number `x`, exactly.
    #[inline]
    pub const fn exact(x: f64) -> Self {
        Self::of([x, 0.0, 0.0, 0.0])
    }

    /// The four parts, the largest first; the leading part is the nearest `f64` or next to it.
    #[inline]
    pub const fn parts(self) -> [f64; 4] {
        self.0.x
    }

    /// The nearest double-double, or one next to it.
    pub fn to_dd(self) -> Dd {
        let [a, b, c, d] = self.parts();
        Dd::new(a, b + (c + d))
    }

    /// A sum of four parts that overlap by a bit at most.
    const fn of(parts: [f64; 4]) -> Self {
        Self(QD { x: parts })
    }

    /// The leading part.
    #[inline]
    fn leading(self) -> f64 {
        self.0.x[0]
    }

    /// x × 2^n, exactly (barring overflow and underflow).
    fn times_power_of_two(self, n: i32) -> Self {
        let leading = times_power_of_two(self.leading(), n);
        if leading.is_finite() {
            Self::of(self.parts().map(|x| times_power_of_two(x, n)))
        } else {
            Self::exact(leading)
        }
    }

    /// Whether no part is NaN or infinite.
    #[inline]
    fn finite_parts(self) -> bool {
        self.parts().iter().all(|x| x.is_finite())
    }

    /// x − n c for finite x and a constant c of many parts, without error before the result is rounded.
    fn reduced(self, n: f64, constant: &[f64]) -> Self {
        Self::of(Dy::sum(&self.parts()).sub(&Dy::from_f64(n).mul(&Dy::sum(constant))).greedy4())
    }
}

impl From<Dd> for Qd {
    /// Exact.
    #[inline]
    fn from(x: Dd) -> Self {
        Self::of([x.hi(), x.lo(), 0.0, 0.0])
    }
}

impl PartialEq for Qd {
    #[inline]
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Qd {
    /// By the sign of the difference: the same number can be spelled in two ways where a part is half a unit of the
    /// part before it.
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        let (a, b) = (self.leading(), other.leading());
        // Far enough apart that the other parts cannot matter, or not finite.
        if (a - b).abs() > 4.0 * f64::EPSILON * a.abs() || !(a - b).is_finite() {
            return a.partial_cmp(&b);
        }
        (*self - *other).leading().partial_cmp(&0.0)
    }
}

// Calls, not inlined, as for `Dd`.
impl Add for Qd {
    type Output = Self;
    #[inline(never)]
    fn add(self, other: Self) -> Self {
        if other.leading() == 0.0 {
            return self;
        }
        if self.leading() == 0.0 {
            return other;
        }
        Self::of(sum(self.parts(), other.parts()))
    }
}

impl Sub for Qd {
    type Output = Self;
    #[inline(never)]
    fn sub(self, other: Self) -> Self {
        if other.leading() == 0.0 {
            return self;
        }
        Self::of(sum(self.parts(), other.parts().map(|x| -x)))
    }
}

impl Neg for Qd {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Mul for Qd {
    type Output = Self;
    #[inline(never)]
    fn mul(self, other: Self) -> Self {
        let one = |x: Self| x.parts() == [1.0, 0.0, 0.0, 0.0];
        if one(self) {
            return other;
        }
        if one(other) {
            return self;
        }
        if self.leading() == 0.0 || other.leading() == 0.0 {
            return Self::exact(self.leading() * other.leading());
        }
        Self(fused::apply(self.0, other.0, QD::accurate_mul))
    }
}

impl Div for Qd {
    type Output = Self;
    #[inline(never)]
    fn div(self, other: Self) -> Self {
        Self(fused::apply(self.0, other.0, QD::accurate_div))
    }
}

/// Σ aᵢ + Σ bᵢ: the eight parts sorted by size, added without error from the smallest, and the four largest parts of
/// that sum.
///
/// M. Joldes, O. Marty, J.-M. Muller, V. Popescu, *Arithmetic algorithms for extended precision using floating-point
/// expansions*, IEEE Trans. Comput. 65(4), 2016, algorithms 4 and 6. Not `multidouble`'s `ieee_add`: where leading parts
/// cancel it can lose more than half of the digits that are left.
#[inline]
fn sum(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    // Falling then rising: sorted by Batcher's merge.
    let mut terms = [a[0], a[1], a[2], a[3], b[3], b[2], b[1], b[0]];
    for distance in [4, 2, 1] {
        for i in (0..8).filter(|i| i & distance == 0) {
            let (x, y) = (terms[i], terms[i + distance]);
            let swap = x.abs() < y.abs();
            (terms[i], terms[i + distance]) = if swap { (y, x) } else { (x, y) };
        }
    }
    for i in (0..7).rev() {
        (terms[i], terms[i + 1]) = two_sum(terms[i], terms[i + 1]);
    }
    let mut parts = [0.0; 4];
    let mut count = 0;
    let mut rest = terms[0];
    for term in &terms[1..] {
        let (part, error) = quick_two_sum(rest, *term);
        rest = part;
        if error != 0.0 {
            parts[count] = part;
            count += 1;
            if count == 4 {
                return parts;
            }
            rest = error;
        }
    }
    parts[count] = rest;
    parts
}

impl fmt::Display for Qd {
    /// 64 digits, trailing zeros dropped; with a precision, that many digits after the point.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        decimal::display(self.0, 64, f)
    }
}

impl fmt::LowerExp for Qd {
    /// 64 digits, trailing zeros dropped; with a precision, that many digits after the point.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        decimal::lower_exp(self.0, 64, f)
    }
}

impl Elementary for Qd {
    #[inline]
    fn exact(x: f64) -> Self {
        Self::exact(x)
    }

    #[inline]
    fn nearest(self) -> f64 {
        self.0.to_f64()
    }

    /// y + d − d²/(2y) with d = (x − y²)/(2y), from the [`Dd`] root y; near the ends of the range on x 4ⁿ.
    #[inline(never)]
    fn square_root(self) -> Self {
        let x = self.leading();
        if x == 0.0 || x == f64::INFINITY {
            return Self::exact(x);
        }
        if x.abs() < SMALL || x.abs() > LARGE {
            let n = if x.abs() < SMALL { 200 } else { -200 };
            return self.times_power_of_two(2 * n).square_root().times_power_of_two(-n);
        }
        let root = Self::from(self.to_dd().square_root());
        let twice = root + root;
        let step = (self - root * root) / twice;
        let curvature = -(step.leading() / twice.leading()) * step.leading();
        root + (step + Self::exact(curvature))
    }

    /// eˣ = 2ⁿ eʳ with |r| ≤ ln 2/2.
    #[inline(never)]
    fn exponential(self) -> Self {
        let x = self.leading();
        if !self.finite_parts() && x.abs() != f64::INFINITY {
            return Self::exact(f64::NAN);
        }
        // Beyond these e^x is infinite, or 0, in f64 too.
        if x > 710.0 {
            return Self::exact(f64::INFINITY);
        }
        if x < -746.0 {
            return Self::exact(0.0);
        }
        let n = (x / std::f64::consts::LN_2).round();
        let rest = if n == 0.0 { self } else { self.reduced(n, &LN_2) };
        (Self::exact(1.0) + rest * exponential_series(rest)).times_power_of_two(n as i32)
    }

    #[inline(never)]
    fn exponential_minus_one(self) -> Self {
        let x = self.leading();
        if x.abs() < 0.35 {
            if x == 0.0 { self } else { self * exponential_series(self) }
        } else {
            let value = self.exponential();
            if value.leading() == f64::INFINITY { value } else { value - Self::exact(1.0) }
        }
    }

    /// ln(2ⁿ m) = n ln 2 + ln m with √½ ≤ m ≤ √2.
    #[inline(never)]
    fn logarithm(self) -> Self {
        let x = self.leading();
        if x == 0.0 {
            return Self::exact(f64::NEG_INFINITY);
        }
        if !(x > 0.0 && x.is_finite()) {
            return Self::exact(if x > 0.0 { x } else { f64::NAN });
        }
        let mut n = exponent(x);
        if times_power_of_two(x, -n) > std::f64::consts::SQRT_2 {
            n += 1;
        }
        let fraction = logarithm_near_one(self.times_power_of_two(-n) - Self::exact(1.0));
        if n == 0 { fraction } else { Self::log_two() * Self::exact(f64::from(n)) + fraction }
    }

    #[inline(never)]
    fn logarithm_one_plus(self) -> Self {
        let x = self.leading();
        if x > -0.29 && x < 0.41 {
            if x == 0.0 { self } else { logarithm_near_one(self) }
        } else if x == f64::INFINITY {
            self
        } else {
            (self + Self::exact(1.0)).logarithm()
        }
    }

    /// x = n π/2 + r with |r| ≤ π/4, where r has all its digits as long as |x| < 2⁵² or so; beyond, NaN.
    #[inline(never)]
    fn sine_cosine(self) -> (Self, Self) {
        let x = self.leading();
        if x == 0.0 {
            return (self, Self::exact(1.0));
        }
        let n = (x / std::f64::consts::FRAC_PI_2).round();
        if !self.finite_parts() || n.abs() >= 4503599627370496.0 {
            return (Self::exact(f64::NAN), Self::exact(f64::NAN));
        }
        let rest = if n == 0.0 { self } else { self.reduced(n, &HALF_PI) };
        let square = -(rest * rest);
        let sin = rest * series(square, INVERSE_FACTORIAL[1..].iter().step_by(2), 15);
        let cos = series(square, INVERSE_FACTORIAL[..49].iter().step_by(2), 15);
        quarter_turns(n, sin, cos)
    }

    /// θ = θ₀ + artan((y cos θ₀ − x sin θ₀)/(x cos θ₀ + y sin θ₀)) from the [`Dd`] angle θ₀.
    #[inline(never)]
    fn arc_tangent(self, other: Self) -> Self {
        let (y, x) = (self, other);
        if y.leading() == 0.0 || x.leading() == 0.0 || !(y.finite_parts() && x.finite_parts()) {
            return conventional_angle(y.leading().atan2(x.leading()));
        }
        // The larger of the two becomes about 1.
        let n = exponent(if x.leading().abs() > y.leading().abs() { x.leading() } else { y.leading() });
        let (y, x) = (y.times_power_of_two(-n), x.times_power_of_two(-n));
        if x.leading() > 0.0 && y.leading().abs() < x.leading() * 2f64.powi(-120) {
            return y / x;
        }
        let start = Self::from(y.to_dd().arc_tangent(x.to_dd()));
        let (sin, cos) = start.sine_cosine();
        start + (y * cos - x * sin) / (x * cos + y * sin)
    }

    fn round_down(self) -> Self {
        // Every part before the first with a fraction is whole, and every part after it is below one unit.
        let mut whole = [0.0; 4];
        for (whole, part) in whole.iter_mut().zip(self.parts()) {
            *whole = part.floor();
            if *whole != part {
                break;
            }
        }
        Self::new(whole)
    }

    #[inline]
    fn circle() -> Self {
        Self::of([2.0 * HALF_PI[0], 2.0 * HALF_PI[1], 2.0 * HALF_PI[2], 2.0 * HALF_PI[3]])
    }

    #[inline]
    fn log_two() -> Self {
        Self::of([LN_2[0], LN_2[1], LN_2[2], LN_2[3]])
    }

    #[inline]
    fn finite(self) -> bool {
        self.finite_parts()
    }
}

real_field!([] Qd);

impl Scalar for Qd {
    super::without_duals!();

    /// 2⁻²⁰⁹ = 8 × 2⁻²¹². No theorem covers × and /; against exact arithmetic the worst relative errors of 4 million pairs
    /// each were 1.13 units of 2⁻²¹² for + and −, 0.49 for × and 0.50 for /. Among the pairs were sums that cancel to any
    /// depth, parts that are powers of two, missing or far apart, and results of other operations.
    fn unit_roundoff() -> Self {
        Self::exact(2f64.powi(-209))
    }

    #[inline]
    fn exact(x: f64) -> Self {
        Self::exact(x)
    }

    #[inline]
    fn int(n: i64) -> Self {
        Self::from(Dd::int(n))
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self.nearest()
    }

    #[inline]
    fn vanishes(self) -> bool {
        self.leading() == 0.0
    }

    #[inline]
    fn all_finite(self) -> bool {
        self.finite_parts()
    }
}

impl Real for Qd {
    const NAME: &'static str = "qd";

    /// Correctly rounded to four parts (2⁻²¹² relative).
    fn parse_decimal(text: &str) -> Option<Self> {
        decimal::parse(text).map(Self).filter(|x| x.finite_parts())
    }
}

/// Σ cⱼ zʲ by Horner's rule: the first `precise` terms in quad-double, and those after, which have to be below 2⁻¹¹⁰
/// relative to the sum, in double-double.
fn series<'a>(z: Qd, coefficients: impl DoubleEndedIterator<Item = &'a Qd> + ExactSizeIterator, precise: usize) -> Qd {
    let count = coefficients.len();
    let mut terms = coefficients.rev();
    let short = z.to_dd();
    let mut tail = Dd::exact(0.0);
    for c in terms.by_ref().take(count.saturating_sub(precise)) {
        tail = tail * short + c.to_dd();
    }
    terms.fold(Qd::from(tail), |sum, &c| sum * z + c)
}

/// (eˣ − 1)/x for |x| ≤ 0.35.
fn exponential_series(x: Qd) -> Qd {
    series(x, INVERSE_FACTORIAL[1..42].iter(), 24)
}

/// ln(1 + x) for √½ ≤ 1 + x ≤ √2: y + ln(1 + d) with d = (x − (eʸ − 1))/eʸ, from the [`Dd`] logarithm y.
fn logarithm_near_one(x: Qd) -> Qd {
    let start = Qd::from(x.to_dd().logarithm_one_plus());
    let power = start.exponential_minus_one();
    let step = (x - power) / (Qd::exact(1.0) + power);
    start + (step - Qd::exact(0.5 * step.leading() * step.leading()))
}

/// Below and above these, arguments are scaled before a residual is formed: 2⁻⁶⁰⁰ and 2⁸⁰⁰.
const SMALL: f64 = f64::from_bits((1023 - 600) << 52);
const LARGE: f64 = f64::from_bits((1023 + 800) << 52);

/// 1/n!.
static INVERSE_FACTORIAL: LazyLock<[Qd; 50]> = LazyLock::new(|| {
    let mut factorial = Qd::exact(1.0);
    std::array::from_fn(|n| {
        factorial *= Qd::exact(n.max(1) as f64);
        Qd::exact(1.0) / factorial
    })
});

/// π/2 to 2⁻⁵⁴⁰: each part the nearest `f64` to what those before it leave (mpmath with 3000 bits). The last six are the
/// guard digits of arguments next to multiples of π/2.
#[allow(clippy::approx_constant)]
const HALF_PI: [f64; 10] = [
    1.5707963267948966,
    6.123233995736766e-17,
    -1.4973849048591698e-33,
    5.562271104316826e-50,
    2.836115989820158e-66,
    8.724931080676243e-84,
    3.01468636612477e-100,
    9.55061773439995e-117,
    1.5219890826721466e-133,
    -2.3571500154735144e-150,
];

/// ln 2 to 2⁻²⁷⁰, likewise.
#[allow(clippy::approx_constant)]
const LN_2: [f64; 5] = [
    0.6931471805599453,
    2.3190468138462996e-17,
    5.707708438416212e-34,
    -3.5824322106018114e-50,
    -1.352169675798863e-66,
];
