//! The cases: sizes, directions and relations in their proportions; shrinking; printing.

use super::SEED;
use euler_poincare::harness::{About, Cost, Fault, Law, Verdict, draw, shrink};
use euler_poincare::laws::user::values::{Points, Values, ValuesTree};
use euler_poincare::scalar::{Dd, Number};
use proptest::strategy::{BoxedStrategy, Strategy, ValueTree};
use std::collections::BTreeMap;

/// What kind of case it is: the size and the direction of each vector, and how the second is related to the first.
fn labels(x: &[f64], y: &[f64]) -> [(&'static str, &'static str); 5] {
    let sizes = [x, y].map(|values| ("size", size(values)));
    let directions = [x, y].map(|values| ("direction", direction(values)));
    [sizes[0], sizes[1], directions[0], directions[1], ("pair", relation(x, y))]
}

fn size(values: &[f64]) -> &'static str {
    let largest = values.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    let norm = values.iter().map(|x| x * x).sum::<f64>().sqrt();
    let quarters = norm / std::f64::consts::FRAC_PI_2;
    let near = quarters.round() >= 1.0 && (quarters - quarters.round()).abs() <= 1.0 / 128.0;
    match largest {
        0.0 => "zero",
        _ if near && values.iter().any(|x| (x * 2f64.powi(40)).fract() != 0.0) => "near a quarter turn",
        x if x < 2f64.powi(-8) => "tiny",
        x if x < 0.5 => "small",
        x if x <= 1.0 => "about one",
        _ => "large",
    }
}

fn direction(values: &[f64]) -> &'static str {
    match values.iter().filter(|x| **x != 0.0).count() {
        0 => "zero",
        1 => "axis",
        n if n < values.len() => "sparse",
        _ => "full",
    }
}

fn relation(before: &[f64], values: &[f64]) -> &'static str {
    let largest = |list: &[f64]| list.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    if largest(before) == 0.0 || largest(values) == 0.0 {
        return "one is zero";
    }
    let apart = |sign: f64| {
        let difference: Vec<f64> = before.iter().zip(values).map(|(x, y)| x - sign * y).collect();
        largest(&difference)
    };
    match (apart(1.0), apart(-1.0)) {
        (0.0, _) => "equal",
        (_, 0.0) => "opposite",
        (x, _) if x < largest(before) * 2f64.powi(-12) => "nearly equal",
        _ => "free",
    }
}

/// The shares, in percent, of each label over many cases of two vectors.
fn shares(length: usize, cases: usize) -> BTreeMap<(&'static str, &'static str), f64> {
    let strategy = Points::new().vectors(&["x", "y"], length).boxed();
    let mut shares = BTreeMap::new();
    for index in 0..cases {
        let (case, _) = draw(&strategy, SEED, "shares", index).case.unwrap();
        let [x, y] = ["x", "y"].map(|name| case.list::<f64>(name, length).unwrap());
        for (category, label) in labels(&x, &y) {
            // A case has two vectors and one pair.
            let part = if category == "pair" { 100.0 } else { 50.0 };
            *shares.entry((category, label)).or_default() += part / cases as f64;
        }
    }
    shares
}

#[test]
fn the_proportions_are_as_documented() {
    for length in [2, 3, 6] {
        let shares = shares(length, 4000);
        let near = |category: &'static str, label: &'static str, percent: f64| {
            let share = shares.get(&(category, label)).copied().unwrap_or(0.0);
            // Five standard deviations of 4000 pairs, and one for what depends on the length.
            let tolerance = 5.0 * (percent * (100.0 - percent) / 4000.0).sqrt() + 1.0;
            assert!((share - percent).abs() <= tolerance, "{length}: {category} {label}: {share} %, not {percent} %");
        };
        near("size", "zero", 8.0);
        near("size", "near a quarter turn", 9.2);
        near("size", "large", 7.5);
        near("size", "tiny", 15.5);
        near("direction", "zero", 8.0);
        near("pair", "equal", 4.6);
        near("pair", "opposite", 4.6);
        near("pair", "nearly equal", 3.8);
        assert!(shares[&("size", "about one")] > 25.0 && shares[&("size", "small")] > 12.0);
        assert!(shares[&("direction", "axis")] > 12.0 && shares[&("direction", "full")] > 40.0);
    }
}

#[test]
fn a_domain_is_kept_and_everything_is_drawn_in_it() {
    let strategy = Points::new().vectors(&["x", "y"], 3).number("t").within(0.25).boxed();
    for index in 0..1000 {
        let (case, _) = draw(&strategy, SEED, "within", index).case.unwrap();
        for name in ["x", "y"] {
            assert!(case.list::<f64>(name, 3).unwrap().iter().all(|x| x.abs() <= 0.25), "{case}");
        }
        assert!(case.number::<f64>("t").unwrap().abs() <= 2.0);
    }
}

#[test]
fn values_are_the_same_in_both_precisions_and_saved() {
    let strategy = Points::new().vectors(&["x", "y"], 3).number("t").boxed();
    for index in 0..500 {
        let (case, _) = draw(&strategy, SEED, "saved", index).case.unwrap();
        let text = serde_json::to_string(&case).unwrap();
        assert_eq!(serde_json::from_str::<Values>(&text).unwrap(), case);
        assert_eq!(toml::from_str::<Values>(&toml::to_string(&case).unwrap()).unwrap(), case);
        for name in ["x", "y"] {
            let (double, quad) = (case.list::<f64>(name, 3).unwrap(), case.list::<Dd>(name, 3).unwrap());
            for (double, quad) in double.into_iter().zip(quad) {
                use euler_poincare::scalar::Scalar;
                let off = (quad - Dd::exact(double)).to_f64().abs();
                assert!(off <= double.abs() * 1e-15, "{case}");
            }
        }
    }
}

/// Broken where |x|² > 1, or where x and y are parallel and not zero.
struct Toy(bool);

impl Law<Values> for Toy {
    fn about(&self) -> &About {
        &About {
            name: "toy",
            statement: "as written",
            source: "none",
            oracle: "none",
            bound: "none",
            needs: "",
            cost: Cost::Cheap,
            faults: &[],
        }
    }
    fn cases(&self) -> BoxedStrategy<Values> {
        Points::new().vectors(&["x", "y"], 3).boxed()
    }
    fn check(&self, case: &Values, _: Option<&Fault>) -> Verdict {
        let (x, y) = (case.vector::<f64, 3>("x").unwrap(), case.vector::<f64, 3>("y").unwrap());
        let parallel = x.cross(&y).norm() == 0.0 && x.dot(&y) != 0.0;
        let broken = if self.0 { parallel } else { x.norm_squared() > 1.0 };
        Verdict::judge(f64::from(u8::from(broken)), 0.5, || "as it should be".into())
    }
}

#[test]
fn shrinking_ends_at_cases_of_few_digits() {
    for parallel in [false, true] {
        let law = Toy(parallel);
        let mut seen = 0;
        for index in 0..400 {
            let Some(failure) = shrink(&law, None, SEED, index, 2000) else { continue };
            seen += 1;
            assert!(failure.checks < 2000);
            let text = failure.case.to_string();
            let [x, y] = ["x", "y"].map(|name| failure.case.vector::<f64, 3>(name).unwrap());
            let simple = if parallel {
                ["[1, 0, 0]", "[0, 1, 0]", "[0, 0, 1]"].iter().any(|axis| text == format!("x = {axis}\ny = {axis}"))
            } else {
                y.norm() == 0.0 && x.iter().all(|x| x.fract() == 0.0 && (0.0..=2.0).contains(x))
            };
            assert!(simple, "{text}");
        }
        assert!(seen > 10, "{seen}");
    }
}

#[test]
fn every_case_shrinks_to_zeros_in_the_end() {
    let strategy = Points::new().vectors(&["x", "y"], 3).number("t").boxed();
    for index in 0..300 {
        let (case, _) = draw(&strategy, SEED, "zeros", index).case.unwrap();
        let mut tree = ValuesTree::new(case, 1.0);
        let mut steps = 0;
        while tree.simplify() {
            steps += 1;
            assert!(steps < 1000);
        }
        let zero = tree.current().entries().all(|(_, list)| list.iter().all(|x| *x == Number::default()));
        assert!(zero, "{}", tree.current());
    }
}
