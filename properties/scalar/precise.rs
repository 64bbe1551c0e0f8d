//! Double-double and quad-double numbers: what is promised of both, against exact sums of `f64` and mpmath.

use super::references::{DOUBLE_DOUBLE, QUAD_DOUBLE, constants};
use euler_poincare::scalar::{Dd, Dual, Number, NumberError, Qd, Real, Scalar};
use multidouble::exact::Dy;
use multidouble::qd::QD;
use nalgebra::{RealField, SMatrix};
use num_traits::Signed;

/// A sum of `f64` parts.
trait Sum: Real {
    /// The exponent of the last bit of 1.
    const LAST: i32;
    /// Decimal digits printed.
    const DIGITS: usize;
    /// In units of 2^LAST, the errors of a sum, difference, product and quotient relative to the result.
    const ERRORS: [f64; 4];
    fn from_parts(parts: [f64; 4]) -> Self;
    /// In units of round-off, the error of a function.
    const FUNCTION: f64;
    /// The parts added again.
    fn respelled(self) -> Self;
    fn value(self) -> Dy;
}

impl Sum for Dd {
    const LAST: i32 = -106;
    const DIGITS: usize = 32;
    // 3 and 5 are theorems; the quotient's three partial quotients stay below 8 as well.
    const ERRORS: [f64; 4] = [3.0, 3.0, 5.0, 8.0];
    const FUNCTION: f64 = 0.625;
    fn from_parts(parts: [f64; 4]) -> Self {
        Self::new(parts[0], parts[1])
    }
    fn respelled(self) -> Self {
        Self::new(self.hi(), self.lo())
    }
    fn value(self) -> Dy {
        Dy::sum(&[self.hi(), self.lo()])
    }
}

impl Sum for Qd {
    const LAST: i32 = -212;
    const DIGITS: usize = 64;
    // Measured, as `Qd::unit_roundoff` says.
    const ERRORS: [f64; 4] = [1.25, 1.25, 0.5, 0.5];
    const FUNCTION: f64 = 0.125;
    fn from_parts(parts: [f64; 4]) -> Self {
        Self::new(parts)
    }
    fn respelled(self) -> Self {
        Self::new(self.parts())
    }
    fn value(self) -> Dy {
        Dy::sum(&self.parts())
    }
}

on_scalars! { [Dd, Qd]
    constants_have_all_their_digits: constants_agree;
    operations_keep_their_round_off: operations;
    operations_keep_it_near_the_ends_of_the_range: ends;
    what_is_not_finite_is_seen: not_finite;
    angles_have_the_conventions_of_f64: angles;
    decimals_in_and_out: decimals;
    numbers_keep_their_digits: numbers;
    rounding_signs_and_powers: rounding;
    functions_satisfy_their_identities: identities;
    equations_are_solved_to_the_last_digits: equations;
    order_is_that_of_the_values: ordering;
}

/// |x - exact| / |exact| in units of round-off.
fn units<T: Sum>(x: T, exact: &Dy) -> f64 {
    let defect = x.value().sub(exact);
    if defect.is_zero() { 0.0 } else { defect.ratio(exact) / T::unit_roundoff().to_f64() }
}

/// A decimal to 2^-212.
fn decimal(text: &str) -> Dy {
    QD::parse(text).unwrap().exact()
}

fn function<T: Real>(name: &str, x: T, second: T) -> T {
    match name {
        "sqrt" => x.sqrt(),
        "cbrt" => x.cbrt(),
        "exp" => x.exp(),
        "exp_m1" => x.exp_m1(),
        "ln" => x.ln(),
        "ln_1p" => x.ln_1p(),
        "sin" => x.sin(),
        "cos" => x.cos(),
        "tan" => x.tan(),
        "atan" => x.atan(),
        "asin" => x.asin(),
        "acos" => x.acos(),
        "sinh" => x.sinh(),
        "cosh" => x.cosh(),
        "tanh" => x.tanh(),
        "asinh" => x.asinh(),
        "acosh" => x.acosh(),
        "atanh" => x.atanh(),
        "atan2" => x.atan2(second),
        other => panic!("{other}"),
    }
}

#[test]
fn double_double_functions_have_all_their_digits() {
    for &(name, x, second, exact) in DOUBLE_DOUBLE {
        let value = function(name, Dd::new(x.0, x.1), Dd::new(second.0, second.1));
        let error = units(value, &decimal(exact));
        // Compositions: at most some four roundings of 5 units of 2^-106.
        assert!(error <= 2.0, "{name}{x:?} = {value}, {error} units from {exact}");
    }
}

#[test]
fn quad_double_functions_have_all_their_digits() {
    for &(name, x, second, exact) in QUAD_DOUBLE {
        let second = if second.is_empty() { "0" } else { second };
        let (x, second) = (Qd::parse_decimal(x).unwrap(), Qd::parse_decimal(second).unwrap());
        let value = function(name, x, second);
        let error = units(value, &decimal(exact));
        // Compositions: four roundings of a unit of 2^-212, and that of the reference.
        assert!(error <= 5.0 / 8.0, "{name}({x}, {second}) = {value}, {error} units from {exact}");
        // Rounded first or last: the argument's rounding is magnified by the function's condition, which is small here.
        let short = function(name, x.to_dd(), second.to_dd());
        let condition = match name {
            "exp" | "sinh" | "cosh" => 1.0 + x.to_f64().abs(),
            // Next to their zeros, and where they have a steep end.
            "sin" | "cos" | "tan" | "ln" | "acos" | "acosh" | "atanh" | "ln_1p" => f64::INFINITY,
            _ => 4.0,
        };
        let apart = ((Qd::from(short) - value) / value).to_f64().abs() / Dd::unit_roundoff().to_f64();
        assert!(apart <= 2.0 + condition, "{name}({x}): {short}, {value}");
    }
}

fn constants_agree<T: Sum>() {
    for (constant, exact) in constants::<T>() {
        let error = units(constant(), &decimal(exact));
        assert!(error <= 2.0, "{exact}: {error} units");
    }
}

/// A reproducible sequence in [0, 1).
fn uniform(state: &mut u64) -> f64 {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    (*state >> 11) as f64 / 2f64.powi(53)
}

/// Both signs, sizes between 2^-scale and 2^scale, parts that fill up, leave gaps or are missing.
fn random<T: Sum>(state: &mut u64, scale: f64) -> T {
    let mut size = 2f64.powi(((2.0 * uniform(state) - 1.0) * scale) as i32);
    let gap = if uniform(state) < 0.5 { 0.0 } else { 60.0 };
    T::from_parts([0, 1, 2, 3].map(|i| {
        let part = size * (1.0 + uniform(state)) * if uniform(state) < 0.5 { -1.0 } else { 1.0 };
        size *= 2f64.powi(-54 - (gap * uniform(state)) as i32);
        if i > 0 && gap > 0.0 && uniform(state) < 0.2 { 0.0 } else { part }
    }))
}

fn operations<T: Sum>() {
    let state = &mut 0x9e37_79b9_7f4a_7c15;
    let mut worst = [0.0f64; 4];
    let mut cancelling = 0;
    for i in 0..40_000 {
        let (a, mut b): (T, T) = (random(state, 20.0), random(state, if i % 2 == 0 { 20.0 } else { 200.0 }));
        if i % 4 > 1 {
            // Next to -a or to a, the other way round each time: a sum and a difference that lose up to all digits.
            let apart = b * T::exact(2f64.powi((uniform(state) * f64::from(T::LAST)) as i32));
            b = if i % 4 == 2 { apart - a } else { a * (T::one() + apart) };
        }
        if a.to_f64() == 0.0 || b.to_f64() == 0.0 {
            continue;
        }
        let (x, y) = (a.value(), b.value());
        let exact = [x.add(&y), x.sub(&y), x.mul(&y)];
        for (j, value) in [a + b, a - b, a * b].into_iter().enumerate() {
            let lost = j < 2 && exact[j].ratio(&x) < 1e-10;
            cancelling += usize::from(lost);
            worst[j] = worst[j].max(units(value, &exact[j]));
        }
        // q b against a, whose relative difference is that of q and a/b.
        let defect = (a / b).value().mul(&y).sub(&x);
        worst[3] = worst[3].max(defect.ratio(&x) / T::unit_roundoff().to_f64());
    }
    let last = worst.map(|w| w * T::unit_roundoff().to_f64() * 2f64.powi(-T::LAST));
    assert!(last.iter().zip(T::ERRORS).all(|(&w, bound)| w <= bound), "{} {last:?}", T::NAME);
    // The bounds are not idle, and digits did cancel.
    assert!(last.iter().zip(T::ERRORS).all(|(&w, bound)| w > bound / 8.0), "{} {last:?}", T::NAME);
    assert!(cancelling > 5_000, "{cancelling}");
    assert_eq!(T::unit_roundoff().to_f64(), 8.0 * 2f64.powi(T::LAST));
}

fn ends<T: Sum>() {
    let state = &mut 0x1405_7b7e_f767_814f;
    let power = |n: i32| T::exact(2f64.powi(n));
    for (m, n) in [(-790, 0), (-400, -390), (-200, -590), (200, -790), (990, 0), (500, 490), (990, -790)] {
        for _ in 0..500 {
            let (a, b): (T, T) = (random(state, 3.0), random(state, 3.0));
            let (x, y) = (a * power(m), b * power(n));
            let sizes = [units(x * y, &x.value().mul(&y.value())), units(x + x * b, &x.value().add(&(x * b).value()))];
            assert!(sizes.iter().all(|&e| e <= 1.0), "{sizes:?}");
            let defect = (x * y / y).value().mul(&y.value()).sub(&(x * y).value());
            assert!(defect.ratio(&(x * y).value()) <= T::unit_roundoff().to_f64());
            let root = Signed::abs(&x).sqrt().value();
            let defect = root.mul(&root).sub(&x.value().abs());
            assert!(defect.ratio(&x.value()) <= 2.0 * T::unit_roundoff().to_f64());
        }
    }
}

#[test]
fn sums_keep_the_digits_that_cancellation_leaves() {
    // x - y = 2^-53 - 2^-212: all parts but one cancel, and some only in the part below.
    let [u, tiny] = [2f64.powi(-53), 2f64.powi(-212)];
    let x = Qd::new([1.0, u, u * u, 0.0]);
    let y = Qd::new([1.0, 0.0, u * u, tiny]);
    assert_eq!((x - y).parts(), [u, -tiny, 0.0, 0.0]);
    assert_eq!((x - x).parts(), [0.0; 4]);
}

#[allow(clippy::eq_op, reason = "0/0 and infinity − infinity are what is tested")]
fn not_finite<T: Sum>() {
    let d = T::exact;
    let (zero, one, huge) = (d(0.0), d(1.0), d(f64::MAX));
    let (infinity, nan) = (d(f64::INFINITY), d(f64::NAN));
    let sums = [huge * huge, huge + huge, infinity - infinity, infinity + one, nan + one, one - nan];
    let products = [one / zero, zero / zero, infinity * one, one / infinity, nan, nan * zero];
    let rest = [(one / zero).cos(), nan.atan2(one), one.atan2(nan), nan.floor(), infinity.floor(), nan.powi(3)];
    let [inf, none] = [f64::INFINITY, f64::NAN];
    let of_functions: [(&str, &[f64]); 13] = [
        ("sqrt", &[-1.0, -1e300, -1e-300, none, inf]),
        ("ln", &[-1.0, 0.0, none]),
        ("ln_1p", &[-1.0, -2.0]),
        ("exp", &[1000.0, 709.9, none, inf]),
        ("exp_m1", &[1000.0, none]),
        ("sin", &[inf, none]),
        ("cos", &[1e300]),
        ("asin", &[1.5]),
        ("acosh", &[0.5]),
        ("atanh", &[1.0]),
        ("cbrt", &[none]),
        ("sinh", &[none]),
        ("tan", &[none]),
    ];
    let values = of_functions.iter().flat_map(|(name, list)| list.iter().map(|x| function(name, d(*x), zero)));
    let bad = sums.into_iter().chain(products).chain(rest).chain(values);
    for (i, x) in bad.enumerate() {
        assert!(!x.all_finite(), "{i}: {x:?}");
        assert!(!Dual { re: one, eps: x }.all_finite());
    }
    assert_eq!(d(1000.0).exp().to_f64(), f64::INFINITY);
    assert_eq!(d(-1000.0).exp(), zero);
    assert_eq!(d(-1000.0).exp_m1(), -one);
    assert_eq!(zero.ln().to_f64(), f64::NEG_INFINITY);
    assert!(nan.partial_cmp(&one).is_none() && nan.partial_cmp(&nan).is_none() && zero == -zero);
    assert!(infinity > huge && -infinity < huge && huge > one && infinity == d(f64::INFINITY));
}

fn angles<T: Sum>() {
    let (zeros, ones, far) = ([0.0, -0.0], [1.0, -1.0], [f64::INFINITY, f64::NEG_INFINITY]);
    let pairs = [
        (zeros, ones),
        (zeros, zeros),
        (ones, zeros),
        (far, [1.0, 1.0]),
        (ones, far),
        (far, [far[1]; 2]),
        ([3.0, -3.0], [4.0, -4.0]),
    ];
    let pairs = pairs.into_iter().flat_map(|(ys, xs)| ys.into_iter().flat_map(move |y| xs.map(|x| (y, x))));
    for (y, x) in pairs {
        let (ours, theirs) = (T::exact(y).atan2(T::exact(x)).to_f64(), f64::atan2(y, x));
        assert_eq!(ours.to_bits(), theirs.to_bits(), "({y}, {x}): {ours} {theirs}");
    }
}

fn decimals<T: Sum>() {
    let long = format!("0.{}", &"1234567890".repeat(7)[..T::DIGITS]);
    let long_scientific = format!("1.{}e-1", &long[3..]);
    let power = format!("1e{}", T::DIGITS + 8);
    let power_cents = format!("1{}.00", "0".repeat(T::DIGITS + 8));
    for (text, printed, scientific, cents) in [
        ("0.1", "0.1", "1e-1", "0.10"),
        ("-2.5", "-2.5", "-2.5e0", "-2.50"),
        ("1234567.125", "1234567.125", "1.234567125e6", "1234567.12"),
        ("9.9999", "9.9999", "9.9999e0", "10.00"),
        (&power, &power, &power, &power_cents),
        ("3e-9", "3e-9", "3e-9", "0.00"),
        (long.trim_end_matches('0'), long.trim_end_matches('0'), long_scientific.replace("0e", "e").as_str(), "0.12"),
    ] {
        let x = T::parse_decimal(text).unwrap();
        assert_eq!(format!("{x}"), printed);
        assert_eq!(format!("{x:e}"), scientific);
        assert_eq!(format!("{x:.2}"), cents);
        assert!(units(x, &decimal(text)) <= 0.125);
    }
    let pi = T::pi();
    assert_eq!(format!("{pi:>8.3}|{pi:.4e}|{pi:.0}"), "   3.142|3.1416e0|3");
    assert_eq!(format!("{} {} {}", T::exact(0.0), T::exact(f64::NAN), T::exact(f64::INFINITY)), "0 NaN inf");
    for bad in ["", "x", "nan", "inf", "1e400", "-1e999999999999", "1..2", "1e", "0x1", "--1"] {
        assert_eq!(T::parse_decimal(bad), None, "{bad}");
        assert_eq!(f64::parse_decimal(bad), None, "{bad}");
    }
    assert_eq!(T::parse_decimal("1e-999999999999"), Some(T::exact(0.0)));
    assert_eq!(T::int(i64::MAX) - T::int(i64::MAX - 1), T::exact(1.0));
    assert_eq!(T::int(i64::MIN), T::exact(-(2f64.powi(63))));
    // What is printed is read back to half a unit of the last digit; with all digits, exactly.
    let state = &mut 0x2545_f491_4f6c_dd1d;
    let last = 10f64.powi(1 - T::DIGITS as i32) / T::unit_roundoff().to_f64();
    for _ in 0..300 {
        let x: T = random(state, 300.0);
        let read = |text: String| T::parse_decimal(&text).unwrap();
        assert!(units(read(format!("{x:e}")), &x.value()) <= 0.5 * last + 0.125, "{x}");
        assert!(units(read(format!("{x}")), &x.value()) <= 0.5 * last + 0.125, "{x}");
        // The last part ends above 2^-800: all digits.
        assert_eq!(read(format!("{x:.800e}")), x);
    }
}

/// What is saved is read as the same number, however far apart its parts are; what is not finite is refused.
#[cfg(feature = "harness")]
fn saved<T: Sum + serde::Serialize + serde::de::DeserializeOwned>() {
    let save = |x: T| serde_json::to_string(&x);
    let state = &mut 0x2545_f491_4f6c_dd1d;
    let power = |n: i32| T::exact(2f64.powi(n));
    let mut numbers = vec![T::exact(0.0), T::exact(-0.1), T::exact(f64::MAX), T::exact(5e-324), -T::pi()];
    numbers.extend([power(0) + power(-900), power(1000) - power(-1000), power(-1000) + power(-1074)]);
    numbers.extend((0..300).map(|_| random::<T>(state, 300.0)));
    for x in numbers {
        let text = save(x).unwrap();
        assert_eq!(serde_json::from_str::<T>(&text).unwrap(), x, "{text}");
    }
    assert_eq!(save(T::ratio(-1, 4)).unwrap(), "\"-0.25\"");
    assert!(save(T::ratio(1, 3)).unwrap().len() <= T::DIGITS + 9, "{:?}", save(T::ratio(1, 3)));
    assert!([f64::NAN, f64::INFINITY].iter().all(|bad| save(T::exact(*bad)).is_err()));
    for bad in ["0.1", "1", "null", "\"\"", "\"1/3\"", "\"1e400\"", "\"NaN\""] {
        let error = serde_json::from_str::<T>(bad).unwrap_err().to_string();
        assert!(error.contains("a decimal number as a text"), "{bad}: {error}");
    }
}

#[cfg(feature = "harness")]
#[test]
fn numbers_are_saved_and_read() {
    saved::<Dd>();
    saved::<Qd>();
}

fn numbers<T: Sum>() {
    let eval = |text: &str| Number::parse(text).unwrap().eval::<T>().unwrap();
    let near = |text: &str, exact: &str| units(eval(text), &decimal(exact));
    assert_eq!(Number::from(0.1).eval::<T>().unwrap(), T::ratio(1, 10));
    assert_eq!(Number::from(0.375).eval::<T>().unwrap(), T::exact(0.375));
    assert!(near("1/3", &format!("0.{}", "3".repeat(75))) < 0.5);
    // mpmath.nstr(mpf(1)/2 - sqrt(mpf(3))/6, 72); the difference magnifies the round-off of 1/2 by 2.4.
    let gauss = "0.211324865405187117745425609749021272176199124364936561990698836758011164";
    assert!(near("1/2 - sqrt(3)/6", gauss) < 2.0);
    assert!(units(eval("2*pi"), &QD::TWO_PI.exact()) < 0.5);
    assert_eq!(
        Number::parse("1e309").unwrap().eval::<T>(),
        Err(NumberError::OutOfRange { text: "1e309".into(), scalar: T::NAME })
    );
    assert!(matches!(Number::parse("1e200*1e200").unwrap().eval::<T>(), Err(NumberError::OutOfRange { .. })));
    assert!(matches!(Number::parse("sqrt(-1)").unwrap().eval::<T>(), Err(NumberError::NegativeRoot { .. })));
    assert!(matches!(Number::parse("1/0").unwrap().eval::<T>(), Err(NumberError::DivisionByZero { .. })));
}

fn rounding<T: Sum>() {
    // Some bits above the last, and the last bit of a half.
    let d = |x: f64| T::exact(x);
    let (tiny, last) = (d(2f64.powi(T::LAST + 6)), d(2f64.powi(T::LAST - 1)));
    for (x, floor, ceil, round, trunc) in [
        (d(2.0), 2.0, 2.0, 2.0, 2.0),
        (d(2.0) - tiny, 1.0, 2.0, 2.0, 1.0),
        (d(2.0) + tiny, 2.0, 3.0, 2.0, 2.0),
        (d(-2.0) + tiny, -2.0, -1.0, -2.0, -1.0),
        (d(-2.0) - tiny, -3.0, -2.0, -2.0, -2.0),
        (d(0.5), 0.0, 1.0, 1.0, 0.0),
        (d(-0.5), -1.0, 0.0, -1.0, 0.0),
        (d(0.5) - last, 0.0, 1.0, 0.0, 0.0),
        (d(2.5) - tiny, 2.0, 3.0, 2.0, 2.0),
        (d(-2.5) - tiny, -3.0, -2.0, -3.0, -2.0),
    ] {
        let values = [x.floor(), x.ceil(), x.round(), x.trunc()];
        assert_eq!(values, [floor, ceil, round, trunc].map(d), "{x}");
        assert_eq!(x.fract(), x - d(trunc));
    }
    assert_eq!((d(2f64.powi(60)) + d(0.75)).floor(), d(2f64.powi(60)));
    assert_eq!(d(7.5) % d(2.0), d(1.5));
    assert_eq!(d(-7.5) % d(2.0), d(-1.5));
    assert_eq!((d(-3.0).signum(), (-tiny).signum(), tiny.signum()), (d(-1.0), d(-1.0), d(1.0)));
    assert!(tiny.is_positive() && (-tiny).is_negative() && !d(0.0).is_positive() && d(0.0).is_zero());
    assert_eq!(Signed::abs(&-tiny), tiny);
    assert_eq!(d(3.0).copysign(-tiny), d(-3.0));
    let nan = d(f64::NAN);
    assert_eq!((RealField::max(nan, d(1.0)), RealField::max(d(1.0), nan)), (d(1.0), d(1.0)));
    assert_eq!((RealField::min(nan, d(1.0)), RealField::min(d(1.0), nan)), (d(1.0), d(1.0)));
    assert_eq!(RealField::max(d(1.0), d(1.0) + tiny), d(1.0) + tiny);
    assert_eq!(RealField::clamp(d(3.0), d(1.0), d(2.0)), d(2.0));
    assert_eq!(d(2.0).powi(-3), d(0.125));
    assert_eq!((d(-3.0).powi(3), d(-3.0).powi(0), d(0.0).powi(0)), (d(-27.0), d(1.0), d(1.0)));
    assert_eq!(d(3.0).hypot(d(-4.0)), d(5.0));
    let (a, b) = (QD::from_f64(3e290), QD::from_f64(4e290));
    let radius = b.accurate_mul(QD::ONE.ieee_add(a.accurate_div(b).sqr()).sqrt());
    assert!(units(d(3e290).hypot(d(4e290)), &radius.exact()) < 2.0);
    assert_eq!((d(-1.0).try_sqrt(), d(4.0).try_sqrt()), (None, Some(d(2.0))));
}

/// Identities between functions that share little, at random points.
fn identities<T: Sum>() {
    let state = &mut 0x853c_49e6_748f_ea9b;
    let close = |what: &str, x: T, a: T, b: T, bound: f64| {
        let error = units(a, &b.value()) / T::FUNCTION;
        assert!(error <= bound, "{} {what} at {x}: {a}, {b}, {error} units", T::NAME);
    };
    let one = T::one();
    for _ in 0..100 {
        let (x, y): (T, T) = (random(state, 3.0), random(state, 3.0));
        let a = Signed::abs(&x);
        // The error of a logarithm is magnified by its size.
        let large: T = Signed::abs(&random(state, 300.0));
        close("exp ln", large, large.ln().exp(), large, 2.0 + 2.0 * large.to_f64().ln().abs());
        close("ln exp", x, (one + a).exp().ln(), one + a, 4.0);
        close("ln_1p exp_m1", x, x.exp_m1().ln_1p(), x, 4.0 * (1.0 + (-x).to_f64().max(0.0).exp()));
        close("square", large, large.sqrt() * large.sqrt(), large, 4.0);
        close("cube", large, large.cbrt().powi(3), large, 8.0);
        let (sin, cos) = x.sin_cos();
        close("pythagoras", x, sin * sin + cos * cos, one, 4.0);
        close("hyperbola", x, (x.cosh() - x.sinh()) * (x.cosh() + x.sinh()), one, 4.0 * (2.0 * a.to_f64()).exp());
        // The addition theorems, absolutely: the sum of the products may cancel, and x + y has an error of its own.
        let sum = sin * y.cos() + cos * y.sin();
        let size = 1.0 + (x + y).to_f64().abs();
        close("addition", x, one + ((x + y).sin() - sum), one, 4.0 * size);
        close("powers", x, (x + y).exp(), x.exp() * y.exp(), 4.0 * size);
        close(
            "product",
            x,
            (a * large).ln(),
            a.ln() + large.ln(),
            8.0 * (1.0 + 20.0 / (a * large).to_f64().ln().abs()),
        );
        // An angle and its coordinates: the same direction.
        let angle = y.atan2(x);
        let radius = x.hypot(y);
        close("sine", x, one + (angle.sin() - y / radius), one, 8.0);
        close("cosine", x, one + (angle.cos() - x / radius), one, 8.0);
        let small: T = random::<T>(state, 300.0) * T::exact(2f64.powi(-310));
        close(
            "small sine",
            small,
            small.sin(),
            small - small.powi(3) / T::int(6),
            2.0 + 1e300 * small.to_f64().powi(4),
        );
        close("small arctangent", small, small.tan().atan(), small, 4.0);
        close("small power", small, small.exp_m1().ln_1p(), small, 4.0);
    }
    // Full turns, seen through what a rounded pi leaves: sin(n pi) = -+n (pi - the exact one).
    for n in [1, 2, 3, 1000, 12345, 1 << 40] {
        let once = T::pi().sin();
        // n times a power of two is exact; other products are rounded to some bits below pi's error.
        if (n as u64).is_power_of_two() {
            close("turns", T::int(n), (T::pi() * T::int(n)).sin(), T::int(if n == 1 { 1 } else { -n }) * once, 4.0);
        }
        let error = (T::pi() * T::int(n)).sin().to_f64().abs();
        assert!(error <= 8.0 * n as f64 * T::unit_roundoff().to_f64(), "{n} {error}");
    }
}

/// Solving with matrices of exact integers.
fn equations<T: Sum>() {
    // Symmetric, positive definite, of condition about 10.
    let a =
        SMatrix::<T, 6, 6>::from_fn(
            |i, j| if i == j { T::int(12 + i as i64) } else { T::int((i + j) as i64) / T::int(2) },
        );
    let identity = SMatrix::<T, 6, 6>::identity();
    let tolerance = T::int(100) * T::unit_roundoff();
    let inverse = a.try_inverse().unwrap();
    assert!((a * inverse - identity).amax() <= tolerance);
    let lu = a.lu();
    assert!((a * lu.solve(&identity).unwrap() - identity).amax() <= tolerance);
    let factor = a.cholesky().unwrap();
    assert!((factor.l() * factor.l().transpose() - a).amax() <= T::int(20) * tolerance);
    assert!((factor.inverse() - inverse).amax() <= tolerance);
    let qr = a.qr();
    assert!((qr.q() * qr.r() - a).amax() <= T::int(20) * tolerance);
    // 1/(i + j + 1), whose determinant is 1/2160^2/1470/... = 1/186313420339200000 for six rows.
    let hilbert = SMatrix::<T, 6, 6>::from_fn(|i, j| T::ratio(1, (i + j + 1) as i64));
    let determinant = hilbert.determinant() * T::int(186_313_420_339_200_000);
    assert!(Signed::abs(&(determinant - T::one())) <= T::exact(1e9) * T::unit_roundoff());
}

fn ordering<T: Sum>() {
    let state = &mut 0xda3e_39cb_94b9_5bdb;
    for i in 0..4000 {
        // Products of parts with few bits often have parts that meet: the same number has two spellings.
        let mut few = || {
            T::from_parts([0, 54, 108, 162].map(|n| {
                let part = (1.0 + 0.25 * (4.0 * uniform(state)).floor())
                    * (1.0 + f64::EPSILON * (3.0 * uniform(state)).floor());
                2f64.powi(-n) * if uniform(state) < 0.5 { -part } else { part }
            }))
        };
        let a: T = few() * few();
        let b: T = match i % 3 {
            0 => random(state, 2.0),
            1 => {
                a * (T::one()
                    + random::<T>(state, 2.0) * T::exact(2f64.powi((uniform(state) * f64::from(T::LAST)) as i32)))
            }
            _ => a.respelled(),
        };
        let difference = a.value().sub(&b.value());
        let order = match (difference.is_zero(), difference.neg) {
            (true, _) => std::cmp::Ordering::Equal,
            (_, true) => std::cmp::Ordering::Less,
            _ => std::cmp::Ordering::Greater,
        };
        assert_eq!(a.partial_cmp(&b), Some(order), "{a:?} {b:?}");
        assert_eq!(a == b, order.is_eq());
    }
}

#[test]
fn conversions_lose_nothing_that_fits() {
    let state = &mut 0x6c07_8965_d1b5_4a32;
    for _ in 0..1000 {
        let short: Dd = random(state, 300.0);
        assert_eq!(Qd::from(short).parts(), [short.hi(), short.lo(), 0.0, 0.0]);
        assert_eq!(Qd::from(short).to_dd(), short);
        let long: Qd = random(state, 300.0);
        assert!(long.to_dd().value().sub(&long.value()).ratio(&long.value()) <= 2f64.powi(-105));
        assert_eq!(Qd::new(long.parts()), long);
        let [a, b, c, d] = long.parts();
        assert_eq!(Qd::new([d, b, a, c]), long);
        assert_eq!(Qd::exact(a).parts(), [a, 0.0, 0.0, 0.0]);
        assert_eq!(long.to_f64(), long.value().to_f64());
    }
    assert_eq!(Qd::new([1.0, -1.0, 1e-300, 0.0]), Qd::exact(1e-300));
    // Two spellings of one number.
    let half = f64::EPSILON / 2.0;
    assert_eq!(Qd::new([1.0, half, 1e-20, 0.0]), Qd::new([1.0 + f64::EPSILON, -half, 1e-20, 0.0]));
    assert!(!Qd::new([f64::NAN, 0.0, 0.0, 1.0]).all_finite() && !Qd::new([1.0, 0.0, 0.0, f64::INFINITY]).all_finite());
}
