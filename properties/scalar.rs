//! Properties of `euler_poincare::scalar`.

use euler_poincare::scalar::{Number, NumberError};

/// (text, canonical text, value).
const NUMBERS: &[(&str, &str, f64)] = &[
    ("0", "0", 0.0),
    ("000", "0", 0.0),
    (" 12 ", "12", 12.0),
    ("1200", "1200", 1200.0),
    (".5", "0.5", 0.5),
    ("5.", "5", 5.0),
    ("0.10", "0.1", 0.1),
    ("1e-3", "0.001", 1e-3),
    ("12.5E+2", "1250", 1250.0),
    ("1e300", "1e300", 1e300),
    ("123e-300", "1.23e-298", 123e-300),
    ("9007199254740993", "9007199254740993", 9007199254740992.0),
    ("-1/3", "-1/3", -1.0 / 3.0),
    ("-(1/3)", "-(1/3)", -1.0 / 3.0),
    ("1 - 2 - 3", "1 - 2 - 3", -4.0),
    ("1 - (2 - 3)", "1 - (2 - 3)", 2.0),
    ("(1 - 2) - 3", "1 - 2 - 3", -4.0),
    ("12/6/2", "12/6/2", 1.0),
    ("12/(6/2)", "12/(6/2)", 4.0),
    ("2*(3 + 4)*5", "2*(3 + 4)*5", 70.0),
    ("2 - -3", "2 - -3", 5.0),
    ("--3", "--3", 3.0),
    ("-(2 + 3)*4", "-(2 + 3)*4", -20.0),
    ("2*-3", "2*-3", -6.0),
    ("sqrt ( 16 ) / 2", "sqrt(16)/2", 2.0),
    ("1/2-sqrt(3)/6", "1/2 - sqrt(3)/6", 0.21132486540518713),
    ("2*pi", "2*pi", std::f64::consts::TAU),
];

#[test]
fn numbers_parse_print_and_evaluate() {
    for &(text, canonical, value) in NUMBERS {
        let number = Number::parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
        assert_eq!(number.to_string(), canonical);
        assert_eq!(Number::parse(canonical).unwrap(), number, "{text}");
        assert_eq!(number.eval::<f64>(), Ok(value), "{text}");
    }
}

/// (text, byte offset of the error).
const NONSENSE: &[(&str, usize)] = &[
    ("", 0),
    ("   ", 3),
    ("+1", 0),
    ("1 2", 2),
    ("1+", 2),
    ("1+*2", 2),
    ("(1", 2),
    ("1)", 1),
    ("()", 1),
    (".", 1),
    ("1.2.3", 3),
    ("1e", 2),
    ("1e+", 3),
    ("1e10000", 2),
    ("1e99999999999999999999", 2),
    ("0x10", 1),
    ("2pi", 1),
    ("pie", 0),
    ("tau", 0),
    ("nan", 0),
    ("inf", 0),
    ("sqrt 2", 5),
    ("sqrt", 4),
    ("sqrt()", 5),
    ("2^3", 1),
    ("1,5", 1),
    ("π", 0),
    ("1\u{a0}+ 2", 1),
    ("1/3\0", 3),
];

#[test]
fn nonsense_is_refused_where_it_starts() {
    for &(text, offset) in NONSENSE {
        match Number::parse(text) {
            Err(NumberError::Syntax { text: source, at, .. }) => {
                assert_eq!((source.as_str(), at), (text, offset));
            }
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
    assert_eq!(Number::from(0.1).to_string(), "0.1");
    assert_eq!(Number::from(-0.375).to_string(), "-0.375");
    assert_eq!(Number::from(5e-324).to_string(), "5e-324");
    assert_eq!(Number::from(i64::MIN).to_string(), "-9.223372036854775808e18");
    assert_eq!(Number::from(i64::MIN).eval::<f64>(), Ok(-9223372036854775808.0));
    assert_eq!(Number::ratio(-1, 3), Number::parse("-1/3").unwrap());
    assert_eq!(Number::ratio(1, -3), Number::parse("1/-3").unwrap());
    assert_eq!(Number::ratio(7, 1), Number::from(7));
    assert_eq!(Number::root(2), Number::parse("sqrt(2)").unwrap());
    assert_eq!(Number::pi(), Number::parse("pi").unwrap());
    for x in [0.0, 0.1, 1.0 / 3.0, f64::MAX, f64::MIN_POSITIVE, 5e-324, 2f64.powi(60), -2.5e-7] {
        assert_eq!(Number::from(x).eval::<f64>(), Ok(x));
        assert_eq!(Number::parse(&Number::from(x).to_string()), Ok(Number::from(x)));
    }
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
        for (text, json) in [
            ("3", "3"),
            ("-3", "-3"),
            ("0", "0"),
            ("-0", "-0.0"),
            ("0.1", "0.1"),
            ("1e300", "1e+300"),
            ("1e400", "\"1e400\""),
            ("--3", "\"--3\""),
            ("0.10000000000000000000000000001", "\"0.10000000000000000000000000001\""),
            ("1/3", "\"1/3\""),
        ] {
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
        let leaf =
            prop_oneof!["[0-9]{1,4}", "[0-9]{0,3}\\.[0-9]{1,4}", "[0-9]{1,3}e-?[0-9]{1,2}", Just("pi".to_string()),];
        leaf.prop_recursive(4, 16, 2, |inner| {
            prop_oneof![
                (inner.clone(), "[-+*/]", inner.clone()).prop_map(|(a, o, b)| format!("{a} {o}{b}")),
                (inner.clone(), "[-+*/]", inner.clone()).prop_map(|(a, o, b)| format!("({a}){o} ({b})")),
                inner.clone().prop_map(|a| format!("-({a})")),
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
        fn any_text_is_parsed_or_refused(text in "[-+*/() .0-9episqrtπ]{0,40}") {
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
