//! Formulas: values, derivatives, and what is said of those that are wrong.

use euler_poincare::expression::{Expression, LONGEST, Names, Shape};
use euler_poincare::scalar::{Dd, Dual, Number, Real, Scalar};
use proptest::prelude::*;

/// t, x (3 components), m (a 2×2 matrix), a parameter, a constant vector and definitions.
fn names() -> Names {
    let mut names = Names::new();
    names.scalar("t").unwrap().vector("x", 3).unwrap().matrix("m", 2, 2).unwrap();
    names.parameter("k", Number::ratio(1, 3)).unwrap();
    names.parameters("r", vec![Number::from(2), Number::ratio(1, 2)]).unwrap();
    let definitions =
        "speed = norm(x); twice = 2*other; other = t + 1; loop = t*pool; pool = loop; bad = t + + nothing";
    for (name, formula) in definitions.split("; ").map(|definition| definition.split_once(" = ").unwrap()) {
        names.definition(name, formula).unwrap();
    }
    names
}

/// t = 1/2, x = (1, −2, 3), m = [[2, 3], [5, 7]].
fn inputs<T: Real>() -> Vec<T> {
    [0.5, 1.0, -2.0, 3.0, 2.0, 3.0, 5.0, 7.0].map(T::exact).to_vec()
}

fn value<T: Real>(text: &str) -> Vec<T> {
    let expression = Expression::parse(text, &names()).unwrap_or_else(|error| panic!("{text}: {error}"));
    let mut out = vec![T::zero(); expression.outputs()];
    expression.compile::<T>().unwrap().eval(&inputs::<T>(), &mut out);
    out
}

/// Formulas, and their values.
const VALUES: &str = include_str!("expression/values.txt");

#[test]
fn formulas_have_the_values_of_their_grammar() {
    let values = |text: &str| text.split(' ').map(|value| value.parse().unwrap()).collect::<Vec<f64>>();
    assert_eq!(VALUES.lines().count(), 38);
    let cases = VALUES.lines().map(|case| case.split_once(" → ").unwrap());
    for (text, wanted) in cases.chain([("\n t\n + 1", "1.5")]).map(|(text, wanted)| (text, values(wanted))) {
        let found = value::<f64>(text);
        assert_eq!(found.len(), wanted.len(), "{text}");
        found.iter().zip(&wanted).for_each(|(a, b)| assert!((a - b).abs() < 1e-14, "{text}: {a} for {b}"));
    }
}

#[test]
fn constants_have_all_digits_of_the_scalar() {
    let third = value::<Dd>("k")[0] * Dd::int(3) - Dd::int(1);
    assert!(third.to_f64().abs() < 1e-31);
    let tenth = value::<Dd>("0.1 + 0.61298730661989954773839539357")[0];
    let exact: Dd = Number::parse("0.71298730661989954773839539357").unwrap().eval().unwrap();
    assert!((tenth - exact).to_f64().abs() < 1e-31);
    // What is 1 or 0 in f64 alone is kept.
    let near = value::<Dd>("1.00000000000000000001*t + 1e-25")[0] - Dd::half();
    assert!((near.to_f64() - 0.5e-20 - 1e-25).abs() < 1e-30, "{near}");
    assert_eq!(value::<f64>("(-1)^65 + 2^100/2^100 + x_2^3"), [-8.0]);
    for (text, wanted) in
        [("sin(t)^2 + cos(t)^2", 1), ("exp(log(x_3))", 3), ("tanh(t)*cosh(t)/sinh(t)", 1), ("tan(atan(x_2))", -2)]
    {
        assert!((value::<Dd>(text)[0] - Dd::int(wanted)).to_f64().abs() < 1e-30, "{text}");
    }
}

#[test]
fn what_is_used_and_what_it_is_can_be_asked() {
    let parse = |text: &str| Expression::parse(text, &names()).unwrap();
    assert_eq!(parse("m*r").shape(), Shape::Vector(2));
    assert_eq!(parse("m").shape(), Shape::Matrix(2, 2));
    assert!(parse("twice").uses(0) && !parse("twice").uses(1));
    let smooth = |text: &str| parse(text).compile::<f64>().unwrap().is_smooth();
    assert!(smooth("x_1^3") && !smooth("speed") && smooth("sqrt(2)*t"));
    // A part that occurs twice is one.
    assert_eq!(parse("t + x_1"), parse("t + x_1"));
    assert!(parse("t + x_1") != parse("t + x_2"));
}

/// Every kind of mistake, with what is said of it.
const WRONG: &str = include_str!("expression/wrong.txt");

#[test]
fn what_is_wrong_with_a_formula_is_said_with_its_place() {
    let said: Vec<String> = ["", "  "]
        .into_iter()
        .chain(WRONG.lines())
        .map(|text| match Expression::parse(text, &names()) {
            Ok(_) => panic!("`{text}` was read"),
            Err(error) => format!("{text:?}\n{error}\n"),
        })
        .collect();
    crate::trajectories::pin("formulas-refused", &said.join("\n"));
}

#[test]
fn large_and_deep_formulas_are_refused() {
    let refused = |text: &str| Expression::parse(text, &names()).unwrap_err().to_string();
    assert!(refused(&"(".repeat(100_000)).contains("too long"));
    assert!(refused(&"(".repeat(LONGEST)).contains("nested more than"));
    assert!(refused(&"-".repeat(LONGEST)).contains("nested more than"));
    assert!(refused(&"[".repeat(LONGEST)).contains("nested more than"));
    assert!(refused(&"sin(".repeat(LONGEST / 4)).contains("nested more than"));
    assert!(refused(&format!("t{}", "^2".repeat(LONGEST / 3))).contains("nested more than"));
    let many: Vec<String> = (0..1500).map(|k| format!("t*{k}")).collect();
    assert!(refused(&many.join("+")).contains("more than 4096 operations"));
    // Squares of squares are shared: 2⁶⁰ t would not fit otherwise.
    let mut doubled = names();
    doubled.definition("y0", "t").unwrap();
    for k in 0..60 {
        doubled.definition(&format!("y{}", k + 1), &format!("y{k} + y{k}")).unwrap();
    }
    let mut out = [0.0];
    Expression::parse("y60", &doubled).unwrap().compile::<f64>().unwrap().eval(&[1.0], &mut out);
    assert_eq!(out[0], 2f64.powi(60));
}

#[test]
fn names_have_one_meaning() {
    let mut names = names();
    let mut refused = |name: &str| names.definition(name, "1").unwrap_err().to_string();
    assert!(refused("x_2").contains("has a meaning already"));
    assert!(refused("sin").contains("is a function"));
    assert!(refused("pi").contains("is a function or a constant"));
    assert!(refused("2x").contains("no name"));
    assert!(refused("").contains("no name"));
    assert!(refused("näme").contains("no name"));
    assert!(names.matrix("empty", 0, 2).is_err() && names.matrix_of("ragged", vec![vec![0], vec![]]).is_err());
}

#[test]
fn an_operation_without_a_value_is_found() {
    let why = |text: &str| {
        let program = Expression::parse(text, &names()).unwrap().compile::<f64>().unwrap();
        program.undefined(&inputs::<f64>()).map(|why| why.to_string())
    };
    assert_eq!(why("t + x_1"), None);
    assert_eq!(why("1 + x_1/(2*t - 1)").unwrap(), "column 8: division by zero\n    1 + x_1/(2*t - 1)\n           ^");
    assert!(why("log(x_2)").unwrap().starts_with("column 1: the logarithm of -2, which is not positive"));
    assert!(why("exp(1000*x_3)").unwrap().starts_with("column 1: the value is too large"));
    assert!(why("acos(x_3)").unwrap().starts_with("column 1: an angle whose sine or cosine is 3, beyond 1"));
}

/// Formulas with values in moderate ranges, as text.
fn formula() -> impl Strategy<Value = String> {
    let leaf = prop::sample::select(vec!["t", "x_1", "x_2", "m_12", "k", "1/4", "3/4", "5/4"]).prop_map(str::to_owned);
    // Of two formulas A and B.
    let made = include_str!("expression/made.txt").lines().collect::<Vec<_>>();
    assert_eq!(made.len(), 11);
    leaf.prop_recursive(5, 40, 3, move |inner| {
        let parts = (prop::sample::select(made.clone()), inner.clone(), inner);
        parts.prop_map(|(made, a, b)| made.replace('A', &a).replace('B', &b))
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn gradients_are_those_of_dual_numbers(text in formula(), x in prop::array::uniform8(-2.0..2.0)) {
        let expression = Expression::parse(&text, &names()).unwrap();
        let (program, precise) = (expression.compile::<f64>().unwrap(), expression.compile::<Dd>().unwrap());
        let (mut value, mut gradient) = ([0.0], [0.0; 8]);
        program.eval(&x, &mut value);
        program.gradient(&x, &mut gradient);
        let mut exact = [Dd::int(0); 8];
        precise.gradient(&x.map(Dd::exact), &mut exact);
        for (k, slope) in gradient.iter().enumerate() {
            let moved: [Dual<Dd>; 8] = std::array::from_fn(|j| {
                let at = Dd::exact(x[j]);
                if j == k { Dual::variable(at) } else { Dual::constant(at) }
            });
            let mut dual = [Dual::constant(Dd::int(0))];
            precise.eval(&moved, &mut dual);
            prop_assert!((dual[0].eps - exact[k]).to_f64().abs() < 1e-26, "{text}: {} for {}", exact[k], dual[0].eps);
            prop_assert!((slope - exact[k].to_f64()).abs() < 1e-10 && (value[0] - dual[0].re.to_f64()).abs() < 1e-11);
        }
    }

    #[test]
    fn no_text_panics(text in "(sin|x_1|x|m|t|\\(|\\)|\\[|\\]|,|[-+*/^. 0-9]|row|norm|[a-zA-Zπ≤\\PC]){0,40}") {
        if let Err(error) = Expression::parse(&text, &names()) {
            prop_assert!(!error.to_string().is_empty() && error.position() <= text.len().max(LONGEST));
        }
    }
}
