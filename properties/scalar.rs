//! Properties of `euler_poincare::scalar`.

mod precise;

use euler_poincare::algebra::{Covector, Entry, Matrix, Vector};
use euler_poincare::group::{LieGroup, MatrixGroup};
use euler_poincare::scalar::{Dd, Dual, Number, NumberError, Real, Scalar, dual};
use nalgebra::{ComplexField, Matrix2, RealField, Vector1, Vector2};
use num_traits::Signed;

/// Texts, the same as they are printed, and their values.
const NUMBERS: &str = include_str!("scalar/numbers.txt");

#[test]
fn numbers_parse_print_and_evaluate() {
    assert_eq!(NUMBERS.lines().count(), 26);
    for listed in NUMBERS.lines().chain([" 12  → 12 → 12"]) {
        let mut parts = listed.split(" → ");
        let [text, canonical, value] = [(); 3].map(|()| parts.next().unwrap());
        let value = value.parse().unwrap();
        let number = Number::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(number.to_string(), canonical);
        assert_eq!(Number::parse(canonical).unwrap(), number, "{text}");
        assert_eq!(number.eval::<f64>(), Ok(value), "{text}");
    }
}

/// Texts with a mark where the error is.
const NONSENSE: [&str; 2] = [
    "¦;   ¦;¦+1;1 ¦2;1+¦;1+¦*2;(1¦;1¦);(¦);.¦;1.2¦.3;1e¦;1e+¦;1e¦10000;1e¦99999999999999999999;0¦x10;2¦pi;¦pie",
    "¦tau;¦nan;¦inf;sqrt ¦2;sqrt¦;sqrt(¦);2¦^3;1¦,5;¦π;1¦\u{a0}+ 2;1/3¦\0",
];

#[test]
fn nonsense_is_refused_where_it_starts() {
    for marked in NONSENSE.iter().flat_map(|line| line.split(';')) {
        let (text, offset) = (marked.replace('¦', ""), marked.find('¦').unwrap());
        match Number::parse(&text) {
            Err(NumberError::Syntax { text: source, at, .. }) => assert_eq!((source, at), (text, offset)),
            other => panic!("{text:?}: {other:?}"),
        }
    }
    let long = "1+".repeat(500) + "1";
    assert_eq!(Number::parse(&long), Err(NumberError::TooLong { length: 1001 }));
    assert!(matches!(Number::parse(&("1e9+".repeat(249) + "1")), Err(NumberError::TooLong { .. })));
    assert!(Number::parse(&("1+".repeat(200) + "1")).is_ok());
    for open in ["(", "-", "sqrt("] {
        assert!(matches!(Number::parse(&(open.repeat(51) + "1")), Err(NumberError::TooDeep { .. })), "{open}");
    }
    assert!(Number::parse(&("(".repeat(50) + "1" + &")".repeat(50))).is_ok());
}

#[test]
fn numbers_without_a_value_say_why() {
    let error = |text: &str| Number::parse(text).unwrap().eval::<f64>().unwrap_err();
    assert_eq!(error("1/(2 - 2)"), NumberError::DivisionByZero { divisor: "2 - 2".into() });
    assert_eq!(error("0/0"), NumberError::DivisionByZero { divisor: "0".into() });
    assert_eq!(error("1 + sqrt(1 - 3)"), NumberError::NegativeRoot { argument: "1 - 3".into(), value: -2.0 });
    for text in ["1e309", "1e-400", "1e9999", "1e-9999", "1e300*1e300", "1e-300/1e300", "1e-200*1e-200"] {
        let text: String = text.into();
        assert_eq!(error(&text), NumberError::OutOfRange { text, scalar: "f64" });
    }
    assert!(matches!(Number::from(f64::NAN).eval::<f64>(), Err(NumberError::DivisionByZero { .. })));
    assert_eq!(Number::from(f64::NEG_INFINITY).to_string(), "-1/0");
}

#[test]
fn numbers_from_machine_numbers() {
    // Four zeros after the point, and no more.
    for (x, text) in [(0.1, "0.1"), (-0.375, "-0.375"), (5e-324, "5e-324"), (1.5e-5, "0.000015"), (1.5e-6, "1.5e-6")] {
        assert_eq!(Number::from(x).to_string(), text);
    }
    assert_eq!(Number::from(i64::MIN).to_string(), "-9.223372036854775808e18");
    assert_eq!(Number::from(i64::MIN).eval::<f64>(), Ok(-9223372036854775808.0));
    assert_eq!(Number::ratio(-1, 3), Number::parse("-1/3").unwrap());
    assert_eq!(Number::ratio(1, -3), Number::parse("1/-3").unwrap());
    assert_eq!(Number::ratio(7, 1), Number::from(7));
    assert_eq!(Number::degree(), Number::parse("deg").unwrap());
    for x in [0.0, 0.1, 1.0 / 3.0, f64::MAX, f64::MIN_POSITIVE, 5e-324, 2f64.powi(60), -2.5e-7] {
        assert_eq!(Number::from(x).eval::<f64>(), Ok(x));
        assert_eq!(Number::parse(&Number::from(x).to_string()), Ok(Number::from(x)));
    }
}

/// The unit multiplies the product before it, in every scalar to its last digits.
#[test]
fn degrees_are_a_unit_and_a_number() {
    fn check<T: Real>() {
        for (text, degrees) in
            [("30 deg", "30"), ("1/2 deg", "1/2"), ("-2*15deg", "-30"), ("60 deg/2", "30"), ("(1 + 29)*deg", "30")]
        {
            let value: T = Number::parse(text).unwrap().eval().unwrap();
            let right: T = Number::parse(&format!("{degrees}*pi/180")).unwrap().eval().unwrap();
            assert!((value - right).abs() <= T::int(4) * T::unit_roundoff() * right.abs(), "{text}: {value} {right}");
        }
    }
    check::<f64>();
    check::<Dd>();
    assert_eq!(Number::parse("10 + 20 deg").unwrap().to_string(), "10 + 20*deg");
    for bad in ["30 degree", "30 degs", "deg 30", "30 deg 2", "3 0deg"] {
        assert!(Number::parse(bad).is_err(), "{bad}");
    }
}

/// A name, f, and f' by hand.
type Derivatives<T> = (&'static str, fn(Dual<Dual<T>>) -> Dual<Dual<T>>, fn(Dual<T>) -> Dual<T>);

fn hand_derivatives<T: Real>() -> Vec<Derivatives<T>> {
    macro_rules! table {
        ($($name:literal: $f:expr, $first:expr;)*) => { vec![$(($name, $f, $first)),*] };
    }
    table! {
        "square": |x| x * x, |x| x + x;
        "quotient": |x| Dual::int(1) / (x - Dual::int(2)), |x| -(x - Dual::int(2)).powi(-2);
        "sqrt": |x| x.sqrt(), |x| Dual::half() / x.sqrt();
        "cbrt": |x| x.cbrt(), |x| Dual::ratio(1, 3) * x.cbrt() / x;
        "exp": |x| x.exp(), |x| x.exp();
        "exp_m1": |x| x.exp_m1(), |x| x.exp();
        "ln": |x| x.ln(), |x| Dual::int(1) / x;
        "ln_1p": |x| x.ln_1p(), |x| Dual::int(1) / (Dual::int(1) + x);
        "sin": |x| x.sin(), |x| x.cos();
        "cos": |x| x.cos(), |x| -x.sin();
        "tan": |x| x.tan(), |x| x.cos().powi(-2);
        "atan": |x| x.atan(), |x| Dual::int(1) / (Dual::int(1) + x * x);
        "asin": |x| x.asin(), |x| Dual::int(1) / (Dual::int(1) - x * x).sqrt();
        "acos": |x| x.acos(), |x| -Dual::int(1) / (Dual::int(1) - x * x).sqrt();
        "sinh": |x| x.sinh(), |x| x.cosh();
        "cosh": |x| x.cosh(), |x| x.sinh();
        "tanh": |x| x.tanh(), |x| x.cosh().powi(-2);
        "asinh": |x| x.asinh(), |x| Dual::int(1) / (Dual::int(1) + x * x).sqrt();
        "acosh": |x| (x + Dual::int(2)).acosh(), |x| Dual::int(1) / ((x + Dual::int(2)).powi(2) - Dual::int(1)).sqrt();
        "atanh": |x| x.atanh(), |x| Dual::int(1) / (Dual::int(1) - x * x);
        "powi": |x| x.powi(-3), |x| -Dual::int(3) * x.powi(-4);
        "powf": |x| x.powf(Dual::ratio(5, 2)), |x| Dual::ratio(5, 2) * x * x.sqrt();
        "hypot": |x| x.hypot(Dual::int(2)), |x| x / (x * x + Dual::int(4)).sqrt();
        "remainder": |x| (x * x) % Dual::ratio(1, 100), |x| x + x;
    }
}

/// The second derivative is that of f', which has been compared by then as a function of numbers.
fn duals_agree_with_hand<T: Real>() {
    // Each side is some twenty roundings, magnified by at most 1/(1 - x^2)^2 and the like: below 16 here.
    let tolerance = T::int(20 * 16) * T::unit_roundoff();
    for x in [T::ratio(1, 3), T::ratio(7, 10)] {
        let variable = Dual { re: Dual::variable(x), eps: Dual::constant(T::one()) };
        for (name, f, first) in hand_derivatives::<T>() {
            let (y, slope) = (f(variable), first(Dual::variable(x)));
            for (ours, hand) in [(y.re.eps, slope.re), (y.eps.re, slope.re), (y.eps.eps, slope.eps)] {
                let error = Signed::abs(&(ours - hand));
                assert!(error <= tolerance * (T::one() + Signed::abs(&hand)), "{} {name}({x}): {ours} {hand}", T::NAME);
            }
        }
    }
}

#[test]
fn dual_derivatives_at_the_edges() {
    type D = Dual<f64>;
    // Odd functions with slope 1 at 0, whichever zero it is.
    for zero in [0.0, -0.0] {
        let odd: [fn(D) -> D; 9] = [D::sin, D::tan, D::asin, D::atan, D::sinh, D::tanh, D::asinh, D::atanh, D::exp_m1];
        for (i, f) in odd.into_iter().enumerate() {
            let y = f(Dual::variable(zero));
            assert_eq!((y.re, y.eps), (0.0, 1.0), "{i}");
        }
        assert_eq!(Dual::variable(zero).cosh().eps, 0.0);
    }
    // A derivative that does not exist is not finite.
    assert!(!Dual::variable(0.0).sqrt().all_finite());
    assert!(!Dual::variable(0.0).atan2(Dual::constant(0.0)).all_finite());
    assert!(!(Dual::int(1) / Dual::<f64>::int(0)).all_finite());
    // atan2: the gradient is (x, -y)/r², in all quadrants and at any size.
    for size in [1.0, 1e-170, 1e170] {
        for (y, x) in [(3.0, 4.0), (3.0, -4.0), (-3.0, 4.0), (-3.0, -4.0)] {
            let along_y = Dual::variable(y * size).atan2(Dual::constant(x * size));
            let along_x = Dual::constant(y * size).atan2(Dual::variable(x * size));
            assert!((along_y.eps * size - x / 25.0).abs() < 1e-15 && (along_x.eps * size + y / 25.0).abs() < 1e-15);
            assert_eq!(along_y.re, f64::atan2(y, x));
        }
    }
    // Comparison is that of the values; rounding has derivative 0, the absolute value the sign.
    assert!(Dual { re: 1.0, eps: 5.0 } == Dual { re: 1.0, eps: -5.0 } && Dual::variable(1.0) < Dual::variable(2.0));
    assert_eq!((Dual::variable(1.5).floor().eps, Signed::abs(&Dual::variable(-1.5)).eps), (0.0, -1.0));
    assert_eq!(Dual::variable(Dd::exact(2.0)).to_string(), "2 + 1 ε");
}

#[test]
fn derivatives_along_directions_run_on_them() {
    // f(x, y) = (x² y, sin x), along (1, 2): (2xy + 2x², cos x).
    let f = |v: &Vector2<Dual<Dd>>| Ok::<_, ()>(Vector2::new(v.x * v.x * v.y, v.x.sin()));
    let (x, y) = (Dd::ratio(1, 3), Dd::ratio(5, 7));
    let slope = dual::derivative(f, &Vector2::new(x, y), &Vector2::new(Dd::int(1), Dd::int(2))).unwrap();
    let hand = Vector2::new(Dd::int(2) * x * y + Dd::int(2) * x * x, x.cos());
    assert!((slope - hand).amax() <= Dd::int(8) * Dd::unit_roundoff());
    let refused = dual::derivative(
        |_: &Vector1<Dual<f64>>| Err::<Vector1<Dual<f64>>, _>("no"),
        &Vector1::new(1.0),
        &Vector1::new(1.0),
    );
    assert_eq!(refused, Err("no"));
}

#[test]
fn linear_algebra_runs_on_them() {
    // The inverse of A(t) has derivative -A⁻¹ A' A⁻¹.
    let a = Matrix2::new(2, 1, -1, 3).map(|n: i64| Dual { re: Dd::int(n), eps: Dd::ratio(n, 3) * Dd::int(n) });
    let inverse = a.lu().try_inverse().unwrap();
    let (values, slopes) = (inverse.map(|x| x.re), a.map(|x| x.eps));
    let defect = inverse.map(|x| x.eps) + values * slopes * values;
    assert!(defect.amax() <= Dd::int(16) * Dd::unit_roundoff());
    assert!((values * a.map(|x| x.re) - Matrix2::identity()).amax() <= Dd::int(16) * Dd::unit_roundoff());
}

#[cfg(feature = "harness")]
mod with_harness {
    use super::*;
    use proptest::prelude::*;

    #[derive(serde::Serialize, serde::Deserialize, PartialEq, Debug)]
    struct Row {
        x: Number,
    }

    #[test]
    fn numbers_are_written_as_numbers_where_nothing_is_lost() {
        let plain = "3 → 3; -3 → -3; 0 → 0; -0 → -0.0; 0.1 → 0.1; 1e300 → 1e+300; ";
        let quoted = r#"1e400 → "1e400"; --3 → "--3"; 0.10000000000000000000000000001 → "0.10000000000000000000000000001"; 1/3 → "1/3""#;
        for (text, json) in [plain, quoted].concat().split("; ").map(|row| row.split_once(" → ").unwrap()) {
            let row = Row { x: Number::parse(text).unwrap() };
            let written = serde_json::to_string(&row).unwrap();
            assert_eq!(written, format!("{{\"x\":{json}}}"));
            assert_eq!(serde_json::from_str::<Row>(&written).unwrap(), row);
            let written = toml::to_string(&row).unwrap();
            assert_eq!(toml::from_str::<Row>(&written).unwrap(), row, "{written}");
        }
        assert_eq!(toml::from_str::<Row>("x = 1e3").unwrap().x, Number::from(1000));
        assert_eq!(
            serde_json::from_str::<Number>("18446744073709551615").unwrap().to_string(),
            "1.8446744073709551615e19"
        );
        for bad in ["x = nan", "x = -inf", "x = true", "x = \"1//2\"", "x = [1]", "x = \"\""] {
            assert!(toml::from_str::<Row>(bad).is_err(), "{bad}");
        }
    }

    /// Texts of the grammar, by construction.
    fn expression() -> impl Strategy<Value = String> {
        let leaf = prop_oneof!["[0-9]{1,4}", "[0-9]{0,3}\\.[0-9]{1,4}", "[0-9]{1,3}e-?[0-9]{1,2}", "pi|deg"];
        leaf.prop_recursive(4, 16, 2, |inner| {
            prop_oneof![
                (inner.clone(), "[-+*/]", inner.clone()).prop_map(|(a, o, b)| format!("{a} {o}{b}")),
                (inner.clone(), "[-+*/]", inner.clone()).prop_map(|(a, o, b)| format!("({a}){o} ({b})")),
                inner.clone().prop_map(|a| format!("-({a})")),
                inner.clone().prop_map(|a| format!("{a} deg")),
                inner.prop_map(|a| format!("sqrt({a})")),
            ]
        })
    }

    proptest! {
        #[test]
        fn any_number_prints_what_parses_back(text in expression()) {
            let number = Number::parse(&text).unwrap();
            prop_assert_eq!(Number::parse(&number.to_string()).unwrap(), number.clone());
            let json = serde_json::to_string(&number).unwrap();
            prop_assert_eq!(serde_json::from_str::<Number>(&json).unwrap(), number);
        }

        #[test]
        fn any_text_is_parsed_or_refused(text in "[-+*/() .0-9episqrtdgπ]{0,40}") {
            if let Ok(number) = Number::parse(&text) {
                prop_assert_eq!(Number::parse(&number.to_string()).unwrap(), number.clone());
                let _ = number.eval::<f64>();
            }
        }

        #[test]
        fn any_finite_double_survives(x in prop::num::f64::ANY.prop_filter("finite", |x| x.is_finite())) {
            let number = Number::from(x);
            prop_assert_eq!(number.eval::<f64>().unwrap().to_bits(), x.to_bits());
            prop_assert_eq!(Number::parse(&number.to_string()).unwrap(), number);
        }
    }
}

/// ln 2ⁿ = n ln 2 down to the smallest number there is.
fn powers_of_two<T: Real>() {
    for n in [-1074, -1060, -1023, -1022, -1, 1, 1023] {
        // The power alone would underflow on the way.
        let x = T::exact(2f64.powi(n / 2) * 2f64.powi(n - n / 2));
        let expected = T::ln_2() * T::int(n.into());
        assert!((x.ln() - expected).abs() <= (T::int(8) * T::unit_roundoff() * expected).abs(), "{} 2^{n}", T::NAME);
    }
}

/// `is_finite` is what nalgebra asks, in its own decompositions.
fn not_finite<T: Real>() {
    for x in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        assert!(!ComplexField::is_finite(&T::exact(x)), "{} {x}", T::NAME);
        assert!(!ComplexField::is_finite(&Dual { re: T::one(), eps: T::exact(x) }), "dual {} {x}", T::NAME);
    }
    assert!(ComplexField::is_finite(&T::exact(f64::MAX)), "{}", T::NAME);
}

/// Nothing is rounded more, or less, for being differentiated.
fn round_off_of_duals<T: Real>() {
    assert_eq!(Dual::<T>::unit_roundoff(), T::unit_roundoff(), "{}", T::NAME);
    assert_eq!(Dual::<Dual<T>>::unit_roundoff(), T::unit_roundoff(), "{}", T::NAME);
    // A step has no slope.
    let floor = ComplexField::floor(Dual::variable(T::ratio(-5, 2)));
    assert_eq!((floor.re, floor.eps), (-T::int(3), T::zero()), "{}", T::NAME);
}

in_both! {
    dual_numbers_carry_first_and_second_derivatives: duals_agree_with_hand;
    powers_of_two_have_their_logarithm_to_the_ends_of_the_range: powers_of_two;
    nalgebra_is_told_what_is_not_finite: not_finite;
    a_dual_number_has_the_round_off_of_its_parts: round_off_of_duals;
}

/// A product with 1 is the other factor only where 1 is a constant: as a variable it has a derivative, of each level.
#[test]
fn a_variable_of_value_one_has_its_derivatives_in_products() {
    let third = Dd::exact(1.0) / Dd::exact(3.0);
    let x = Dual::variable(Dd::exact(1.0));
    assert_eq!((x * Dual::constant(third)).eps, third);
    assert_eq!((Dual::constant(third) * x).eps, third);
    assert_eq!((x * x).eps, Dd::exact(2.0));
    let inner = Dual::constant(x);
    assert_eq!((inner * Dual::constant(Dual::constant(third))).re.eps, third);
    let outer = Dual::variable(Dual::constant(Dd::exact(1.0)));
    assert_eq!((outer * Dual::constant(Dual::constant(third))).eps.re, third);
    assert_eq!((Dual::constant(Dd::exact(1.0)) * Dual::variable(third)).eps, Dd::exact(1.0));
}

/// The numbers of all scalars, one after the other.
fn numbers<'a, S: Scalar + 'a>(scalars: impl IntoIterator<Item = &'a S>) -> Vec<S::Base> {
    let mut numbers = Vec::new();
    scalars.into_iter().for_each(|x| x.write(&mut numbers));
    numbers
}

/// Sums by the operators, in the order of the loops, on SE(3) in a basis in which half of the constants vanish.
fn loops<T: Real, S: Scalar<Base = T>>(what: &str, number: impl Fn(i64) -> S) {
    let mixed = Matrix::<T, 6>::from_fn(|a, b| T::ratio(i64::from(a == b) + i64::from(a + 1 == b), 3 + b as i64));
    let group = MatrixGroup::<T, 6, 4>::from_entry(&Entry::Se3).unwrap().in_basis(&mixed).unwrap();
    let algebra = group.algebra();
    let x = Vector::<S, 6>::from_fn(|a, _| if a == 4 { S::zero() } else { number(a as i64) });
    let y = Vector::<S, 6>::from_fn(|a, _| if a == 1 { S::one() } else { number(7 - 2 * a as i64) });
    let mu = Covector::<S, 6>::from_fn(|_, a| number(3 * a as i64 - 5));

    let summed = |terms: &mut dyn Iterator<Item = S>| terms.fold(S::zero(), |sum, term| sum + term);
    let ad = Matrix::<S, 6>::from_fn(|c, b| summed(&mut (0..6).map(|a| x[a] * S::lift(algebra.constant(a, b, c)))));
    assert_eq!(numbers(&algebra.ad(&x)), numbers(&ad), "{what}: ad");
    let bracket = Vector::<S, 6>::from_fn(|c, _| summed(&mut (0..6).map(|b| ad[(c, b)] * y[b])));
    assert_eq!(numbers(&algebra.bracket(&x, &y)), numbers(&bracket), "{what}: the bracket");
    let coad = Covector::<S, 6>::from_fn(|_, b| summed(&mut (0..6).map(|c| mu[c] * ad[(c, b)])));
    assert_eq!(numbers(&algebra.coad(&x, &mu)), numbers(&coad), "{what}: ad*");
    let hat = Matrix::<S, 4>::from_fn(|r, c| summed(&mut (0..6).map(|a| x[a] * S::lift(group.basis()[a][(r, c)]))));
    assert_eq!(numbers(&group.hat(&x)), numbers(&hat), "{what}: hat");

    // A factor of 0 does not hide what is not finite.
    let mut far = x;
    far[0] = S::one() / S::zero();
    assert!(algebra.ad(&far).iter().all(|v| !v.all_finite()), "{what}: ad of an infinite vector");
    let still = Vector::<S, 6>::zeros();
    assert!(algebra.bracket(&far, &still).iter().all(|v| !v.all_finite()), "{what}: its bracket");
}

#[test]
fn sums_in_loops_have_the_bits_of_the_operators_and_show_what_is_not_finite() {
    loops::<f64, f64>("f64", |k| (k as f64).sin());
    loops::<Dd, Dd>("dd", |k| Dd::int(k).sin());
    let dual = |k: i64| Dual { re: Dd::int(k).sin(), eps: if k % 2 == 0 { Dd::ratio(k, 7) } else { Dd::exact(0.0) } };
    loops::<Dd, Dual<Dd>>("duals over dd", dual);
    loops::<Dd, Dual<Dual<Dd>>>("their duals", |k| Dual { re: dual(k), eps: dual(k + 1) });
}
