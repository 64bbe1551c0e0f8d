//! Double-double numbers: what is promised of them, against exact sums of `f64` and mpmath.

use euler_poincare::scalar::{Dd, Dual, Number, NumberError, Real, Scalar};
use multidouble::exact::Dy;
use multidouble::qd::QD;
use nalgebra::{ComplexField, RealField, SMatrix};
use num_traits::{One, Signed, Zero};

/// The exponent of the last bit of 1.
const LAST: i32 = -106;

/// Decimal digits printed.
const DIGITS: usize = 32;

/// In units of 2^LAST, the errors of a sum, difference, product and quotient relative to the result. 3 and 5 are theorems; the
/// quotient's three partial quotients stay below 8 as well.
const ERRORS: [f64; 4] = [3.0, 3.0, 5.0, 8.0];

/// In units of round-off, the error of a function.
const FUNCTION: f64 = 0.625;

/// The value, exactly.
fn exactly(x: Dd) -> Dy {
    Dy::sum(&[x.hi(), x.lo()])
}

/// |x - exact| / |exact| in units of round-off.
fn units(x: Dd, exact: &Dy) -> f64 {
    let defect = exactly(x).sub(exact);
    if defect.is_zero() { 0.0 } else { defect.ratio(exact) / Dd::unit_roundoff().to_f64() }
}

/// A decimal to 2^-212.
fn decimal(text: &str) -> Dy {
    QD::parse(text).unwrap().exact()
}

/// The function, or the constant, of a name.
fn called(name: &str, x: Dd, second: Dd) -> Dd {
    macro_rules! named {
        ($($f:ident)*; $($constant:ident)*) => {
            match name {
                $(stringify!($f) => x.$f(),)*
                $(stringify!($constant) => Dd::$constant(),)*
                "atan2" => x.atan2(second),
                other => panic!("{other}"),
            }
        };
    }
    named!(sqrt cbrt exp exp_m1 ln ln_1p sin cos tan atan asin acos sinh cosh tanh asinh acosh atanh;
        pi ln_2 e ln_10 log10_e log2_e frac_1_pi frac_2_sqrt_pi frac_pi_3 frac_pi_6 frac_pi_8 two_pi frac_2_pi frac_pi_2 frac_pi_4)
}

/// (function, argument, second argument of atan2, 40 digits): the arguments are the nearest double-doubles to points
/// such as n/3 x 10^k and n pi/2, and the values `mpmath.nstr(f(mpf(hi) + mpf(lo)), 40)` with mp.prec = 2500.
const FUNCTIONS: &str = include_str!("double_double.txt");

/// Constants and `mpmath.nstr(.., 70)` of them.
const CONSTANTS: &str = include_str!("constants.txt");

#[test]
fn functions_and_constants_have_all_their_digits() {
    assert_eq!((FUNCTIONS.lines().count(), CONSTANTS.lines().count()), (91, 15));
    for line in FUNCTIONS.lines().chain(CONSTANTS.lines()) {
        let words: Vec<&str> = line.split(' ').collect();
        let parts: Vec<f64> = words[1..words.len() - 1].iter().map(|part| part.parse().unwrap()).collect();
        let [x, second] = [0, 2].map(|k| parts.get(k..k + 2).map_or(Dd::exact(0.0), |part| Dd::new(part[0], part[1])));
        let (value, exact) = (called(words[0], x, second), words[words.len() - 1]);
        let error = units(value, &decimal(exact));
        // Compositions: at most some four roundings of 5 units of 2^-106.
        assert!(error <= 2.0, "{line}: {value} is {error} units off");
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
fn random(state: &mut u64, scale: f64) -> Dd {
    let mut size = 2f64.powi(((2.0 * uniform(state) - 1.0) * scale) as i32);
    let gap = if uniform(state) < 0.5 { 0.0 } else { 60.0 };
    // Four parts are drawn, and two are used.
    let [hi, lo, ..] = [0, 1, 2, 3].map(|i| {
        let part = size * (1.0 + uniform(state)) * if uniform(state) < 0.5 { -1.0 } else { 1.0 };
        size *= 2f64.powi(-54 - (gap * uniform(state)) as i32);
        if i > 0 && gap > 0.0 && uniform(state) < 0.2 { 0.0 } else { part }
    });
    Dd::new(hi, lo)
}

#[test]
fn operations_keep_their_round_off() {
    let state = &mut 0x9e37_79b9_7f4a_7c15;
    let mut worst = [0.0f64; 4];
    let mut cancelling = 0;
    for i in 0..40_000 {
        let (a, mut b): (Dd, Dd) = (random(state, 20.0), random(state, if i % 2 == 0 { 20.0 } else { 200.0 }));
        if i % 4 > 1 {
            // Next to -a or to a, the other way round each time: a sum and a difference that lose up to all digits.
            let apart = b * Dd::exact(2f64.powi((uniform(state) * f64::from(LAST)) as i32));
            b = if i % 4 == 2 { apart - a } else { a * (Dd::one() + apart) };
        }
        if a.to_f64() == 0.0 || b.to_f64() == 0.0 {
            continue;
        }
        let (x, y) = (exactly(a), exactly(b));
        let exact = [x.add(&y), x.sub(&y), x.mul(&y)];
        for (j, value) in [a + b, a - b, a * b].into_iter().enumerate() {
            let lost = j < 2 && exact[j].ratio(&x) < 1e-10;
            cancelling += usize::from(lost);
            worst[j] = worst[j].max(units(value, &exact[j]));
        }
        // q b against a, whose relative difference is that of q and a/b.
        let defect = exactly(a / b).mul(&y).sub(&x);
        worst[3] = worst[3].max(defect.ratio(&x) / Dd::unit_roundoff().to_f64());
    }
    let last = worst.map(|w| w * Dd::unit_roundoff().to_f64() * 2f64.powi(-LAST));
    assert!(last.iter().zip(ERRORS).all(|(&w, bound)| w <= bound), "{} {last:?}", Dd::NAME);
    // The bounds are not idle, and digits did cancel.
    assert!(last.iter().zip(ERRORS).all(|(&w, bound)| w > bound / 8.0), "{} {last:?}", Dd::NAME);
    assert!(cancelling > 5_000, "{cancelling}");
    assert_eq!(Dd::unit_roundoff().to_f64(), 8.0 * 2f64.powi(LAST));
}

#[test]
fn operations_keep_it_near_the_ends_of_the_range() {
    let state = &mut 0x1405_7b7e_f767_814f;
    let power = |n: i32| Dd::exact(2f64.powi(n));
    for (m, n) in [(-790, 0), (-400, -390), (-200, -590), (200, -790), (990, 0), (500, 490), (990, -790)] {
        for _ in 0..500 {
            let (a, b): (Dd, Dd) = (random(state, 3.0), random(state, 3.0));
            let (x, y) = (a * power(m), b * power(n));
            let sizes =
                [units(x * y, &exactly(x).mul(&exactly(y))), units(x + x * b, &exactly(x).add(&exactly(x * b)))];
            assert!(sizes.iter().all(|&e| e <= 1.0), "{sizes:?}");
            let defect = exactly(x * y / y).mul(&exactly(y)).sub(&exactly(x * y));
            assert!(defect.ratio(&exactly(x * y)) <= Dd::unit_roundoff().to_f64());
            let root = exactly(Signed::abs(&x).sqrt());
            let defect = root.mul(&root).sub(&exactly(x).abs());
            assert!(defect.ratio(&exactly(x)) <= 2.0 * Dd::unit_roundoff().to_f64());
        }
    }
}

#[test]
#[allow(clippy::eq_op, reason = "0/0 and infinity − infinity are what is tested")]
fn what_is_not_finite_is_seen() {
    let d = Dd::exact;
    let (zero, one, huge) = (d(0.0), d(1.0), d(f64::MAX));
    let (infinity, nan) = (d(f64::INFINITY), d(f64::NAN));
    let sums = [huge * huge, huge + huge, infinity - infinity, infinity + one, nan + one, one - nan];
    let products = [one / zero, zero / zero, infinity * one, one / infinity, nan, nan * zero];
    let rest = [(one / zero).cos(), nan.atan2(one), one.atan2(nan), nan.floor(), infinity.floor(), nan.powi(3)];
    let of_functions = "sqrt -1, sqrt -1e300, sqrt -1e-300, sqrt nan, sqrt inf, ln -1, ln 0, ln nan, ln_1p -1, ln_1p -2, exp 1000, \
                        exp 709.9, exp nan, exp inf, exp_m1 1000, exp_m1 nan, sin inf, sin nan, cos 1e300, asin 1.5, acosh 0.5, \
                        atanh 1, cbrt nan, sinh nan, tan nan";
    let values = of_functions.split(", ").map(|call| {
        let (name, x) = call.split_once(' ').unwrap();
        called(name, d(x.parse().unwrap()), zero)
    });
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

#[test]
fn angles_have_the_conventions_of_f64() {
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
        let (ours, theirs) = (Dd::exact(y).atan2(Dd::exact(x)).to_f64(), f64::atan2(y, x));
        assert_eq!(ours.to_bits(), theirs.to_bits(), "({y}, {x}): {ours} {theirs}");
    }
}

#[test]
fn decimals_in_and_out() {
    // A text, and how it is printed plainly, with an exponent and with two places.
    let table = include_str!("printed.txt");
    assert_eq!(table.lines().count(), 7);
    for row in table.lines() {
        let [text, printed, scientific, cents] = row.split(' ').collect::<Vec<_>>()[..] else { panic!("{row}") };
        let x = Dd::parse_decimal(text).unwrap();
        assert_eq!(format!("{x}"), printed);
        assert_eq!(format!("{x:e}"), scientific);
        assert_eq!(format!("{x:.2}"), cents);
        assert!(units(x, &decimal(text)) <= 0.125);
    }
    let pi = Dd::pi();
    assert_eq!(format!("{pi:>8.3}|{pi:.4e}|{pi:.0}"), "   3.142|3.1416e0|3");
    assert_eq!(format!("{} {} {}", Dd::exact(0.0), Dd::exact(f64::NAN), Dd::exact(f64::INFINITY)), "0 NaN inf");
    for bad in ["", "x", "nan", "inf", "1e400", "-1e999999999999", "1..2", "1e", "0x1", "--1"] {
        assert_eq!(Dd::parse_decimal(bad), None, "{bad}");
        assert_eq!(f64::parse_decimal(bad), None, "{bad}");
    }
    assert_eq!(Dd::parse_decimal("1e-999999999999"), Some(Dd::exact(0.0)));
    assert_eq!(Dd::int(i64::MAX) - Dd::int(i64::MAX - 1), Dd::exact(1.0));
    assert_eq!(Dd::int(i64::MIN), Dd::exact(-(2f64.powi(63))));
    // What is printed is read back to half a unit of the last digit; with all digits, exactly.
    let state = &mut 0x2545_f491_4f6c_dd1d;
    let last = 10f64.powi(1 - DIGITS as i32) / Dd::unit_roundoff().to_f64();
    for _ in 0..300 {
        let x: Dd = random(state, 300.0);
        let read = |text: String| Dd::parse_decimal(&text).unwrap();
        assert!(units(read(format!("{x:e}")), &exactly(x)) <= 0.5 * last + 0.125, "{x}");
        assert!(units(read(format!("{x}")), &exactly(x)) <= 0.5 * last + 0.125, "{x}");
        // The last part ends above 2^-800: all digits.
        assert_eq!(read(format!("{x:.800e}")), x);
    }
}

/// What is saved is read as the same number, however far apart its parts are; what is not finite is refused.
#[cfg(feature = "harness")]
#[test]
fn numbers_are_saved_and_read() {
    let save = |x: Dd| serde_json::to_string(&x);
    let state = &mut 0x2545_f491_4f6c_dd1d;
    let power = |n: i32| Dd::exact(2f64.powi(n));
    let mut numbers = vec![Dd::exact(0.0), Dd::exact(-0.1), Dd::exact(f64::MAX), Dd::exact(5e-324), -Dd::pi()];
    numbers.extend([power(0) + power(-900), power(1000) - power(-1000), power(-1000) + power(-1074)]);
    numbers.extend((0..300).map(|_| random(state, 300.0)));
    for x in numbers {
        let text = save(x).unwrap();
        assert_eq!(serde_json::from_str::<Dd>(&text).unwrap(), x, "{text}");
    }
    assert_eq!(save(Dd::ratio(-1, 4)).unwrap(), "\"-0.25\"");
    assert!(save(Dd::ratio(1, 3)).unwrap().len() <= DIGITS + 9, "{:?}", save(Dd::ratio(1, 3)));
    assert!([f64::NAN, f64::INFINITY].iter().all(|bad| save(Dd::exact(*bad)).is_err()));
    for bad in ["0.1", "1", "null", "\"\"", "\"1/3\"", "\"1e400\"", "\"NaN\""] {
        let error = serde_json::from_str::<Dd>(bad).unwrap_err().to_string();
        assert!(error.contains("a decimal number as a text"), "{bad}: {error}");
    }
}

#[test]
fn numbers_keep_their_digits() {
    let eval = |text: &str| Number::parse(text).unwrap().eval::<Dd>().unwrap();
    let near = |text: &str, exact: &str| units(eval(text), &decimal(exact));
    assert_eq!(Number::from(0.1).eval::<Dd>().unwrap(), Dd::ratio(1, 10));
    assert_eq!(Number::from(0.375).eval::<Dd>().unwrap(), Dd::exact(0.375));
    assert!(near("1/3", &format!("0.{}", "3".repeat(75))) < 0.5);
    // mpmath.nstr(mpf(1)/2 - sqrt(mpf(3))/6, 72); the difference magnifies the round-off of 1/2 by 2.4.
    let gauss = "0.211324865405187117745425609749021272176199124364936561990698836758011164";
    assert!(near("1/2 - sqrt(3)/6", gauss) < 2.0);
    assert!(units(eval("2*pi"), &QD::TWO_PI.exact()) < 0.5);
    assert_eq!(
        Number::parse("1e309").unwrap().eval::<Dd>(),
        Err(NumberError::OutOfRange { text: "1e309".into(), scalar: Dd::NAME })
    );
    assert!(matches!(Number::parse("1e200*1e200").unwrap().eval::<Dd>(), Err(NumberError::OutOfRange { .. })));
    assert!(matches!(Number::parse("sqrt(-1)").unwrap().eval::<Dd>(), Err(NumberError::NegativeRoot { .. })));
    assert!(matches!(Number::parse("1/0").unwrap().eval::<Dd>(), Err(NumberError::DivisionByZero { .. })));
}

#[test]
fn rounding_signs_and_powers() {
    // Some bits above the last, and the last bit of a half.
    let d = |x: f64| Dd::exact(x);
    let (tiny, last) = (d(2f64.powi(LAST + 6)), d(2f64.powi(LAST - 1)));
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
#[test]
fn functions_satisfy_their_identities() {
    let state = &mut 0x853c_49e6_748f_ea9b;
    let close = |what: &str, x: Dd, a: Dd, b: Dd, bound: f64| {
        let error = units(a, &exactly(b)) / FUNCTION;
        assert!(error <= bound, "{} {what} at {x}: {a}, {b}, {error} units", Dd::NAME);
    };
    let one = Dd::one();
    for _ in 0..100 {
        let (x, y): (Dd, Dd) = (random(state, 3.0), random(state, 3.0));
        let a = Signed::abs(&x);
        // The error of a logarithm is magnified by its size.
        let large: Dd = Signed::abs(&random(state, 300.0));
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
        let product = (a * large).ln();
        close("product", x, product, a.ln() + large.ln(), 8.0 * (1.0 + 20.0 / product.to_f64().abs()));
        // An angle and its coordinates: the same direction.
        let angle = y.atan2(x);
        let radius = x.hypot(y);
        close("sine", x, one + (angle.sin() - y / radius), one, 8.0);
        close("cosine", x, one + (angle.cos() - x / radius), one, 8.0);
        let small: Dd = random(state, 300.0) * Dd::exact(2f64.powi(-310));
        let series = small - small.powi(3) / Dd::int(6);
        close("small sine", small, small.sin(), series, 2.0 + 1e300 * small.to_f64().powi(4));
        close("small arctangent", small, small.tan().atan(), small, 4.0);
        close("small power", small, small.exp_m1().ln_1p(), small, 4.0);
    }
    // Full turns, seen through what a rounded pi leaves: sin(n pi) = -+n (pi - the exact one).
    for n in [1, 2, 3, 1000, 12345, 1 << 40] {
        let once = Dd::pi().sin();
        // n times a power of two is exact; other products are rounded to some bits below pi's error.
        if (n as u64).is_power_of_two() {
            close("turns", Dd::int(n), (Dd::pi() * Dd::int(n)).sin(), Dd::int(if n == 1 { 1 } else { -n }) * once, 4.0);
        }
        let error = (Dd::pi() * Dd::int(n)).sin().to_f64().abs();
        assert!(error <= 8.0 * n as f64 * Dd::unit_roundoff().to_f64(), "{n} {error}");
    }
}

/// Solving with matrices of exact integers.
#[test]
fn equations_are_solved_to_the_last_digits() {
    // Symmetric, positive definite, of condition about 10.
    let a = SMatrix::<Dd, 6, 6>::from_fn(|i, j| {
        if i == j { Dd::int(12 + i as i64) } else { Dd::int((i + j) as i64) / Dd::int(2) }
    });
    let identity = SMatrix::<Dd, 6, 6>::identity();
    let tolerance = Dd::int(100) * Dd::unit_roundoff();
    let inverse = a.try_inverse().unwrap();
    assert!((a * inverse - identity).amax() <= tolerance);
    let lu = a.lu();
    assert!((a * lu.solve(&identity).unwrap() - identity).amax() <= tolerance);
    let factor = a.cholesky().unwrap();
    assert!((factor.l() * factor.l().transpose() - a).amax() <= Dd::int(20) * tolerance);
    assert!((factor.inverse() - inverse).amax() <= tolerance);
    let qr = a.qr();
    assert!((qr.q() * qr.r() - a).amax() <= Dd::int(20) * tolerance);
    // 1/(i + j + 1), whose determinant is 1/2160^2/1470/... = 1/186313420339200000 for six rows.
    let hilbert = SMatrix::<Dd, 6, 6>::from_fn(|i, j| Dd::ratio(1, (i + j + 1) as i64));
    let determinant = hilbert.determinant() * Dd::int(186_313_420_339_200_000);
    assert!(Signed::abs(&(determinant - Dd::one())) <= Dd::exact(1e9) * Dd::unit_roundoff());
}

#[test]
fn order_is_that_of_the_values() {
    let state = &mut 0xda3e_39cb_94b9_5bdb;
    for i in 0..4000 {
        // Products of parts with few bits often have parts that meet: the same number has two spellings.
        let mut few = || {
            let [hi, lo] = [0, 54].map(|n| {
                let part = (1.0 + 0.25 * (4.0 * uniform(state)).floor())
                    * (1.0 + f64::EPSILON * (3.0 * uniform(state)).floor());
                2f64.powi(-n) * if uniform(state) < 0.5 { -part } else { part }
            });
            Dd::new(hi, lo)
        };
        let a: Dd = few() * few();
        let b: Dd = match i % 3 {
            0 => random(state, 2.0),
            1 => a * (Dd::one() + random(state, 2.0) * Dd::exact(2f64.powi((uniform(state) * f64::from(LAST)) as i32))),
            _ => Dd::new(a.hi(), a.lo()),
        };
        let difference = exactly(a).sub(&exactly(b));
        let order = match (difference.is_zero(), difference.neg) {
            (true, _) => std::cmp::Ordering::Equal,
            (_, true) => std::cmp::Ordering::Less,
            _ => std::cmp::Ordering::Greater,
        };
        assert_eq!(a.partial_cmp(&b), Some(order), "{a:?} {b:?}");
        assert_eq!(a == b, order.is_eq());
    }
}
