//! Double-double numbers: about 32 digits, as an unevaluated sum of two `f64`.
//!
//! The four operations are those of `multidouble`; the elementary functions are our own. A value whose size is
//! between 2⁻⁹⁰⁰ and 2¹⁰⁰⁰ (1e-270 and 1e300) has all its digits; below, the second part runs out of exponents.

use super::field::real_field;
use super::{Real, Scalar, decimal, fused};
use multidouble::dd::{DD, quick_two_sum, two_prod};
use multidouble::qd::QD;
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// hi + lo with |lo| ≤ ulp(hi)/2.
///
/// An operation that overflows, divides by zero or meets an infinity gives NaN or an infinity, which [`Scalar::all_finite`] sees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Dd(DD);

impl Dd {
    /// hi + lo, rounded to a double-double.
    pub fn new(hi: f64, lo: f64) -> Self {
        let (hi, lo) = multidouble::dd::two_sum(hi, lo);
        Self(DD { hi, lo })
    }

    /// The number `x`, exactly.
    #[inline]
    pub const fn exact(x: f64) -> Self {
        Self::parts((x, 0.0))
    }

    /// The leading part: the nearest `f64`.
    pub fn hi(self) -> f64 {
        self.0.hi
    }

    /// What the leading part leaves.
    pub fn lo(self) -> f64 {
        self.0.lo
    }

    /// A sum of two parts that do not overlap.
    const fn parts((hi, lo): (f64, f64)) -> Self {
        Self(DD { hi, lo })
    }

    /// The sum of two numbers of which one is 0.
    #[inline]
    fn beside_zero(self, other: Self) -> Self {
        Self::parts((self.hi() + other.hi(), self.lo() + other.lo()))
    }

    /// x × 2^n, exactly (barring overflow and underflow).
    fn times_power_of_two(self, n: i32) -> Self {
        let hi = times_power_of_two(self.hi(), n);
        Self::parts((hi, if hi.is_finite() { times_power_of_two(self.lo(), n) } else { 0.0 }))
    }

    /// f × 2^n with 1 ≤ |f| < 2; for finite x ≠ 0, and lossless for 0.
    fn fraction_exponent(self) -> (Self, i32) {
        let n = exponent(self.hi());
        (self.times_power_of_two(-n), n)
    }

    /// Whether neither part is NaN or infinite.
    #[inline]
    fn finite_parts(self) -> bool {
        self.hi().is_finite() && self.lo().is_finite()
    }
}

impl PartialOrd for Dd {
    #[inline]
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.hi().partial_cmp(&other.hi()) {
            Some(Ordering::Equal) => self.lo().partial_cmp(&other.lo()),
            order => order,
        }
    }
}

// Calls, not inlined: laws instantiate their formulas for many sizes, and 20 operations in each place of an addition make
// the compiler's work several times longer; a call costs less than the operation. Zeros and ones are frequent (padded matrices,
// structure constants, derivatives of constants, the factors α and β of matrix products), and cost a comparison.
impl Add for Dd {
    type Output = Self;
    #[inline(never)]
    fn add(self, other: Self) -> Self {
        if self.hi() == 0.0 || other.hi() == 0.0 {
            return self.beside_zero(other);
        }
        Self(self.0 + other.0)
    }
}

impl Sub for Dd {
    type Output = Self;
    #[inline(never)]
    fn sub(self, other: Self) -> Self {
        if self.hi() == 0.0 || other.hi() == 0.0 {
            return self.beside_zero(-other);
        }
        Self(self.0 - other.0)
    }
}

impl Neg for Dd {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl Mul for Dd {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        // Of three products for each term of a product of matrices two are those with α and β: no call for them.
        if self.is_constant_one() { other } else { product(self, other) }
    }
}

#[inline(never)]
fn product(x: Dd, y: Dd) -> Dd {
    if x.hi() == 0.0 || y.hi() == 0.0 {
        // 0, or NaN where the other factor is not finite.
        return Dd::exact(x.hi() * y.hi());
    }
    if y.is_constant_one() {
        return x;
    }
    Dd(fused::apply(x.0, y.0, |a, b| a * b))
}

impl Div for Dd {
    type Output = Self;
    #[inline(never)]
    fn div(self, other: Self) -> Self {
        Self(fused::apply(self.0, other.0, |a, b| a / b))
    }
}

impl fmt::Display for Dd {
    /// 32 digits, trailing zeros dropped; with a precision, that many digits after the point.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        decimal::display(QD::from_dd(self.0), f)
    }
}

impl fmt::LowerExp for Dd {
    /// 32 digits, trailing zeros dropped; with a precision, that many digits after the point.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        decimal::lower_exp(QD::from_dd(self.0), f)
    }
}

/// What `real_field!` takes.
impl Dd {
    /// One Newton step on the `f64` root, with the residual exact; near the ends of the range on x 4ⁿ.
    #[inline(never)]
    fn square_root(self) -> Self {
        let x = self.hi();
        if x == 0.0 || x == f64::INFINITY {
            return Self::exact(x);
        }
        if x.abs() < SMALL || x.abs() > LARGE {
            let n = if x.abs() < SMALL { 200 } else { -200 };
            return self.times_power_of_two(2 * n).square_root().times_power_of_two(-n);
        }
        let root = x.sqrt();
        let (square, error) = two_prod(root, root);
        let residual = ((x - square) - error) + self.lo();
        Self::parts(quick_two_sum(root, residual / (2.0 * root)))
    }

    /// eˣ = 2ⁿ eʳ with |r| ≤ ln 2/2.
    #[inline(never)]
    fn exponential(self) -> Self {
        let x = self.hi();
        if x.is_nan() {
            return self;
        }
        // Beyond these e^x is infinite, or 0, in f64 too.
        if x > 710.0 {
            return Self::exact(f64::INFINITY);
        }
        if x < -746.0 {
            return Self::exact(0.0);
        }
        let n = (x / std::f64::consts::LN_2).round();
        // The head cancels exactly; the tail needs no more than its leading digits.
        let rest = self - Self::exact(n * LN_2_HEAD) - Self(LN_2_TAIL.mul_f(n));
        (Self::exact(1.0) + rest * exponential_series(rest)).times_power_of_two(n as i32)
    }

    #[inline(never)]
    fn exponential_minus_one(self) -> Self {
        if self.hi().abs() < 0.34 {
            if self.hi() == 0.0 { self } else { self * exponential_series(self) }
        } else {
            let value = self.exponential();
            if value.hi() == f64::INFINITY { value } else { value - Self::exact(1.0) }
        }
    }

    /// ln(2ⁿ m) = n ln 2 + 2 artanh((m − 1)/(m + 1)) with √½ ≤ m ≤ √2.
    #[inline(never)]
    fn logarithm(self) -> Self {
        let x = self.hi();
        if x == 0.0 {
            return Self::exact(f64::NEG_INFINITY);
        }
        if !(x > 0.0 && x.is_finite()) {
            return Self::exact(if x > 0.0 { x } else { f64::NAN });
        }
        let (mut m, mut n) = self.fraction_exponent();
        if m.hi() > std::f64::consts::SQRT_2 {
            (m, n) = (m.times_power_of_two(-1), n + 1);
        }
        let fraction = logarithm_series(m - Self::exact(1.0));
        if n == 0 { fraction } else { ln_2_times(f64::from(n)) + fraction }
    }

    #[inline(never)]
    fn logarithm_one_plus(self) -> Self {
        let x = self.hi();
        if x > -0.29 && x < 0.41 {
            if x == 0.0 { self } else { logarithm_series(self) }
        } else if x == f64::INFINITY {
            self
        } else {
            (self + Self::exact(1.0)).logarithm()
        }
    }

    /// x = n π/2 + r with |r| ≤ π/4, where r has all its digits as long as |x| < 2⁵² or so; beyond, NaN.
    #[inline(never)]
    fn sine_cosine(self) -> (Self, Self) {
        let x = self.hi();
        if x == 0.0 {
            return (self, Self::exact(1.0));
        }
        let n = (x / std::f64::consts::FRAC_PI_2).round();
        if n.is_nan() || n.abs() >= 4503599627370496.0 {
            return (Self::exact(f64::NAN), Self::exact(f64::NAN));
        }
        let rest = if n == 0.0 {
            self
        } else {
            let half_turns = QD::PI.mul_pwr2(0.5).mul_f(-n);
            Self(QD::from_dd(self.0).ieee_add(half_turns).to_dd())
        };
        let square = -(rest * rest);
        let sin = rest * series(square, INVERSE_FACTORIAL[1..].iter().step_by(2), 9);
        let cos = series(square, INVERSE_FACTORIAL.iter().step_by(2), 10);
        quarter_turns(n, sin, cos)
    }

    /// θ = θ₀ + artan((y cos θ₀ − x sin θ₀)/(x cos θ₀ + y sin θ₀)) from the `f64` angle θ₀.
    #[inline(never)]
    fn arc_tangent(self, other: Self) -> Self {
        let (y, x) = (self, other);
        let start = y.hi().atan2(x.hi());
        if y.hi() == 0.0 || x.hi() == 0.0 || !(y.finite_parts() && x.finite_parts()) {
            return conventional_angle(start);
        }
        // The larger of the two becomes about 1.
        let larger = if x.hi().abs() > y.hi().abs() { x } else { y };
        let (_, n) = larger.fraction_exponent();
        let (y, x) = (y.times_power_of_two(-n), x.times_power_of_two(-n));
        if x.hi() > 0.0 && y.hi().abs() < x.hi() * 2f64.powi(-60) {
            return y / x;
        }
        let (sin, cos) = Self::exact(start).sine_cosine();
        Self::exact(start) + (y * cos - x * sin) / (x * cos + y * sin)
    }

    fn round_down(self) -> Self {
        let whole = self.hi().floor();
        let part = if whole == self.hi() { self.lo().floor() } else { 0.0 };
        Self::parts(quick_two_sum(whole, part))
    }

    #[inline]
    fn circle() -> Self {
        Self::parts((std::f64::consts::PI, PI_LOW))
    }

    #[inline]
    fn log_two() -> Self {
        Self::parts((std::f64::consts::LN_2, LN_2_LOW))
    }
}

real_field!([] Dd);

impl Scalar for Dd {
    super::without_duals!();

    /// 2⁻¹⁰³: bounds the relative error of +, −, × (3 and 5 units of 2⁻¹⁰⁶: Joldes, Muller and Popescu 2017) and /.
    fn unit_roundoff() -> Self {
        Self::exact(2f64.powi(-103))
    }

    #[inline]
    fn exact(x: f64) -> Self {
        Self::exact(x)
    }

    #[inline]
    fn int(n: i64) -> Self {
        let hi = n as f64;
        Self::parts((hi, (i128::from(n) - hi as i128) as f64))
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self.0.to_f64()
    }

    #[inline]
    fn vanishes(self) -> bool {
        self.hi() == 0.0
    }

    #[inline]
    fn is_constant_one(self) -> bool {
        self.hi() == 1.0 && self.lo() == 0.0
    }

    #[inline]
    fn all_finite(self) -> bool {
        self.finite_parts()
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self(self.0 + other.0)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(self.0 - other.0)
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self(self.0 * other.0)
    }

    #[inline(always)]
    fn scaled(self, factor: Self) -> Self {
        self.times(factor)
    }
}

impl Real for Dd {
    const NAME: &'static str = "dd";

    /// Correctly rounded to two parts (2⁻¹⁰⁶ relative).
    fn parse_decimal(text: &str) -> Option<Self> {
        decimal::parse(text).map(|x| Self(x.to_dd())).filter(|x| x.finite_parts())
    }
}

/// x × 2^n, exactly (barring overflow and underflow).
fn times_power_of_two(x: f64, n: i32) -> f64 {
    // In two steps: the power alone can be out of range where the result is not.
    x * 2f64.powi(n / 2) * 2f64.powi(n - n / 2)
}

/// n with 2ⁿ ≤ |x| < 2ⁿ⁺¹, for finite x ≠ 0.
fn exponent(x: f64) -> i32 {
    let biased = |x: f64| ((x.to_bits() >> 52) & 0x7ff) as i32;
    if biased(x) == 0 { biased(x * 2f64.powi(64)) - 64 - 1023 } else { biased(x) - 1023 }
}

/// The angle on or between the axes that the `f64` angle `start` stands for, a multiple of π/4 (or NaN); +0 and −0 as
/// they are.
fn conventional_angle(start: f64) -> Dd {
    let eighths = (start / std::f64::consts::FRAC_PI_4).round();
    if start == 0.0 { Dd::exact(start) } else { Dd::circle() * Dd::exact(0.25 * eighths) }
}

/// (sin x, cos x) from those of x − n π/2, for an integer n.
#[inline]
fn quarter_turns(n: f64, sin: Dd, cos: Dd) -> (Dd, Dd) {
    match n.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// Σ cⱼ zʲ by Horner's rule: the first `precise` terms in double-double, and those after, which have to be below 2⁻⁵⁴
/// relative to the sum, in `f64`.
fn series<'a>(
    z: Dd,
    coefficients: impl DoubleEndedIterator<Item = &'a (f64, f64)> + ExactSizeIterator,
    precise: usize,
) -> Dd {
    let count = coefficients.len();
    let mut terms = coefficients.rev();
    let mut tail = 0.0;
    for (hi, _) in terms.by_ref().take(count.saturating_sub(precise)) {
        tail = tail * z.hi() + hi;
    }
    terms.fold(Dd::exact(tail), |sum, &c| sum * z + Dd::parts(c))
}

/// (eˣ − 1)/x for |x| ≤ ln 2/2.
fn exponential_series(x: Dd) -> Dd {
    series(x, INVERSE_FACTORIAL[1..24].iter(), 13)
}

/// ln(1 + x) = 2 artanh(x/(2 + x)) for √½ ≤ 1 + x ≤ √2.
fn logarithm_series(x: Dd) -> Dd {
    let t = x / (Dd::exact(2.0) + x);
    (t + t) * series(t * t, INVERSE_ODD.iter(), 11)
}

/// n ln 2 for an integer |n| ≤ 2¹².
fn ln_2_times(n: f64) -> Dd {
    Dd::exact(n * LN_2_HEAD) + Dd(LN_2_TAIL.mul_f(n))
}

/// Below and above these, arguments are scaled before a residual is formed: 2⁻⁸⁰⁰ and 2⁸⁰⁰.
const SMALL: f64 = f64::from_bits((1023 - 800) << 52);
const LARGE: f64 = f64::from_bits((1023 + 800) << 52);

/// ln 2 = LN_2_HEAD + LN_2_TAIL; the head has 40 bits, so that its products with exponents are exact.
const LN_2_HEAD: f64 = 0.6931471805592082;
const LN_2_TAIL: DD = DD { hi: 7.371002565167799e-13, lo: 1.94704509238075e-31 };

/// What the `f64` π and ln 2 leave.
const PI_LOW: f64 = 1.2246467991473532e-16;
const LN_2_LOW: f64 = 2.3190468138462996e-17;

/// 1/n! as hi + lo.
const INVERSE_FACTORIAL: [(f64, f64); 29] = [
    (1.0, 0.0),
    (1.0, 0.0),
    (0.5, 0.0),
    (0.16666666666666666, 9.25185853854297e-18),
    (0.041666666666666664, 2.3129646346357427e-18),
    (0.008333333333333333, 1.1564823173178714e-19),
    (0.001388888888888889, -5.300543954373577e-20),
    (0.0001984126984126984, 1.7209558293420705e-22),
    (2.48015873015873e-05, 2.1511947866775882e-23),
    (2.7557319223985893e-06, -1.858393274046472e-22),
    (2.755731922398589e-07, 2.3767714622250297e-23),
    (2.505210838544172e-08, -1.448814070935912e-24),
    (2.08767569878681e-09, -1.20734505911326e-25),
    (1.6059043836821613e-10, 1.2585294588752098e-26),
    (1.1470745597729725e-11, 2.0655512752830745e-28),
    (7.647163731819816e-13, 7.03872877733453e-30),
    (4.779477332387385e-14, 4.399205485834081e-31),
    (2.8114572543455206e-15, 1.6508842730861433e-31),
    (1.5619206968586225e-16, 1.1910679660273754e-32),
    (8.22063524662433e-18, 2.2141894119604265e-34),
    (4.110317623312165e-19, 1.4412973378659527e-36),
    (1.9572941063391263e-20, -1.3643503830087908e-36),
    (8.896791392450574e-22, -7.911402614872376e-38),
    (3.868170170630684e-23, -8.843177655482344e-40),
    (1.6117375710961184e-24, -3.6846573564509766e-41),
    (6.446950284384474e-26, -1.9330404233703465e-42),
    (2.4795962632247976e-27, -1.2953730964765229e-43),
    (9.183689863795546e-29, 1.4303150396787322e-45),
    (3.279889237069838e-30, 1.5117542744029879e-46),
];

/// 1/(2j + 1) as hi + lo.
const INVERSE_ODD: [(f64, f64); 22] = [
    (1.0, 0.0),
    (0.3333333333333333, 1.850371707708594e-17),
    (0.2, -1.1102230246251566e-17),
    (0.14285714285714285, 7.93016446160826e-18),
    (0.1111111111111111, 6.1679056923619804e-18),
    (0.09090909090909091, -2.523234146875356e-18),
    (0.07692307692307693, -4.270088556250602e-18),
    (0.06666666666666667, 9.251858538542971e-19),
    (0.058823529411764705, 8.163404592832033e-19),
    (0.05263157894736842, 2.921639538487254e-18),
    (0.047619047619047616, 2.64338815386942e-18),
    (0.043478260869565216, 1.206764157201257e-18),
    (0.04, -8.326672684688674e-19),
    (0.037037037037037035, 2.05596856412066e-18),
    (0.034482758620689655, 4.785444071660157e-19),
    (0.03225806451612903, 8.953411488912552e-19),
    (0.030303030303030304, -8.410780489584519e-19),
    (0.02857142857142857, 8.921435019309293e-19),
    (0.02702702702702703, -1.50030138462859e-18),
    (0.02564102564102564, 8.896017825522087e-19),
    (0.024390243902439025, -8.46206573647223e-19),
    (0.023255813953488372, 3.2273925134452225e-19),
];
