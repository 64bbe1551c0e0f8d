//! Properties of `euler_poincare::tableau::analyse`.

use super::{described, draw, entries, members, number, rounded, written};
use euler_poincare::scalar::{Dd, Number};
use euler_poincare::tableau::assumptions::AssumptionKind;
use euler_poincare::tableau::quantity::{Ball, Quantity};
use euler_poincare::tableau::random;
use euler_poincare::tableau::stability::Stability;
use euler_poincare::tableau::structure::{Shape, Symmetry};
use euler_poincare::tableau::{Analysis, Classic, Description, Family, Tableau, analyse};
use euler_poincare::tableau::{classical_order, variational_order};
use nalgebra::{Complex, DMatrix};
use proptest::prelude::*;
use std::collections::HashMap;
use std::time::Instant;

fn named(name: &str, max: usize) -> Analysis {
    analyse(&name.parse().unwrap(), max).unwrap()
}

fn typed(text: &str, max: usize) -> Analysis {
    analyse(&described(text), max).unwrap()
}

fn orders(analysis: &Analysis) -> (usize, usize) {
    (analysis.exactly.classical.order, analysis.exactly.variational.order)
}

fn digit_orders(analysis: &Analysis) -> Option<(usize, usize)> {
    analysis.to_digits.as_ref().map(|found| (found.classical.order, found.variational.order))
}

// Names.

#[test]
fn families_have_the_order_of_their_quadrature_formula_for_the_pair_too() {
    for family in Family::ALL {
        let largest = if family == Family::Gauss { 6 } else { 5 };
        // Trees end at order 12 and 13; B(2s), C(s), D(s) prove order 2s of Gauss's methods, and the like of the others.
        for s in (family.least_stages()..=largest).chain([7, 8, 12, 25]) {
            let analysis = named(&format!("{}-{s}", family.name()), if s > largest { 4 } else { 12 });
            let declared = family.declared(s);
            assert_eq!(orders(&analysis), (declared, declared), "{}-{s}", family.name());
            let found = &analysis.exactly;
            assert!(
                s <= largest || found.classical.is_exact() && found.variational.is_exact(),
                "{}-{s}",
                family.name()
            );
            assert!(s > largest || found.assumptions.b.holds == declared, "{}-{s}", family.name());
            let rational = match family {
                Family::Gauss => 1,
                Family::RadauIA | Family::RadauIIA => 2,
                _ => 3,
            };
            assert_eq!(analysis.exact, s <= rational, "{}-{s}", family.name());
        }
    }
}

#[test]
fn gauss_7_is_of_order_14_for_the_pair_too() {
    let analysis = named("gauss-7", 9);
    let orders = analysis.findings();
    assert_eq!([&orders.classical, &orders.variational].map(ToString::to_string), ["14", "14"]);
    assert_eq!([13, 14, 15].map(|order| analysis.has_order(order)), [Some(false), Some(true), Some(false)]);
    let text = analysis.notes().join("\n");
    assert!(!text.contains("although"), "{text}");
    assert!(orders.hints().iter().any(|hint| hint.starts_with("B(15) fails")), "{:?}", orders.hints());
}

#[test]
fn classical_tableaux_have_the_order_they_declare() {
    let variational = |classic: Classic| match classic {
        Classic::Ralston3 | Classic::Alexander3 => 2,
        _ => classic.declared(),
    };
    for classic in Classic::ALL {
        let analysis = named(classic.name(), 8);
        assert_eq!(orders(&analysis), (classic.declared(), variational(classic)), "{}", classic.name());
        assert_eq!(analysis.notes().is_empty(), classic.declared() == variational(classic) && analysis.exact);
        assert_eq!(analysis.declared, None);
        assert_eq!(analysis.stages, analysis.description.parse::<Description>().unwrap().stages());
    }
}

#[test]
fn what_is_symmetric_symplectic_and_a_stable_is_as_known() {
    let families = members(6).map(|(family, s)| (format!("{}-{s}", family.name()), Some(family)));
    for (name, family) in families.chain(Classic::ALL.map(|classic| (classic.name().to_string(), None))) {
        let analysis = named(&name, 2);
        use Family::*;
        let symmetric = matches!(family, Some(Gauss | LobattoIIIA | LobattoIIIB | LobattoIIID | LobattoIIIE));
        let symplectic = matches!(family, Some(Gauss | LobattoIIID | LobattoIIIE));
        let explicit = ["euler", "heun2", "ralston3", "rk4", "kutta38"].contains(&name.as_str());
        assert_eq!(analysis.symmetry.holds(), symmetric, "{name}");
        assert_eq!(analysis.symplectic, symplectic, "{name}");
        assert_eq!(analysis.stability == Stability::AStable, !explicit, "{name}: {}", analysis.stability);
        assert_eq!(matches!(analysis.stability, Stability::Not(_)), explicit, "{name}: {}", analysis.stability);
        assert_eq!(analysis.shape == Shape::Explicit, explicit, "{name}");
        let single = ["sdirk2", "sdirk3", "alexander2", "alexander3", "gauss-1", "radau-ia-1", "radau-iia-1"];
        let single = single.contains(&name.as_str()) || name == "lobatto-iiie-2";
        assert_eq!(analysis.shape == Shape::SinglyDiagonallyImplicit, single, "{name}: {}", analysis.shape);
    }
}

#[test]
fn symmetry_is_found_whatever_the_order_of_the_stages() {
    let gauss = Family::Gauss.tableau::<Dd>(5).unwrap();
    let shuffle = [3, 0, 4, 1, 2];
    let a: Vec<Vec<Dd>> = shuffle.iter().map(|&i| shuffle.iter().map(|&j| gauss.a()[(i, j)]).collect()).collect();
    let b: Vec<Dd> = shuffle.iter().map(|&i| gauss.b()[i]).collect();
    let shuffled = Tableau::new(&a, &b).unwrap();
    let found = Symmetry::of(&euler_poincare::tableau::quantity::Coefficients::of(&shuffled));
    // Stage i of Gauss goes to 4 − i.
    let expected = shuffle.map(|i| shuffle.iter().position(|&j| j == 4 - i).unwrap());
    assert_eq!(found, Symmetry::Symmetric(expected.to_vec()));
}

#[test]
fn rational_members_are_those_in_floating_point() {
    let families = members(4).map(|(family, s)| Description::Family(family, s));
    let mut rational = 0;
    for description in families.chain(Classic::ALL.map(Description::Classic)) {
        let Some(exact) = description.rational().unwrap() else { continue };
        rational += 1;
        let t = description.build::<f64>().unwrap();
        for (i, row) in exact.a.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                assert!((x.to_f64_fast() - t.a()[(i, j)]).abs() <= 4.0 * f64::EPSILON, "{description}");
            }
            assert!((exact.b[i].to_f64_fast() - t.b()[i]).abs() <= 4.0 * f64::EPSILON, "{description}");
        }
    }
    // Gauss 1, five families of Lobatto with 2 and 3, two of Radau with 1 and 2, and the five explicit tableaux.
    assert_eq!(rational, 1 + 10 + 4 + 5);
}

// Sharp limits of A-stability.

/// |R(z)| by solving (1 − z a) k = 𝟙; `None` near a pole.
fn growth(t: &Tableau<f64>, z: Complex<f64>) -> Option<f64> {
    let s = t.stages();
    let one = |i, j| Complex::from(if i == j { 1.0 } else { 0.0 });
    let matrix = DMatrix::from_fn(s, s, |i, j| one(i, j) - z * t.a()[(i, j)]);
    let k = matrix.lu().solve(&DMatrix::from_element(s, 1, Complex::from(1.0)))?;
    let sum: Complex<f64> = (0..s).map(|i| k[(i, 0)] * t.b()[i]).sum();
    Some((Complex::from(1.0) + z * sum).norm()).filter(|r| r.is_finite())
}

/// The growth on the imaginary axis that is said, and what it is there.
fn said(why: &str, t: &Tableau<f64>) -> Option<(f64, f64)> {
    let (r, y) = why.strip_prefix("|R(iy)| = ")?.split_once(" at y = ")?;
    Some((r.parse().unwrap(), growth(t, Complex::new(0.0, y.parse().unwrap())).unwrap()))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, ..ProptestConfig::default() })]

    #[test]
    fn a_stable_methods_do_not_grow_in_the_left_half_plane(description in random::any()) {
        let t = description.build::<f64>().unwrap();
        let analysis = analyse(&description, 1).unwrap();
        let mut largest = 0.0f64;
        // Where Q has a zero that P cancels, often at a z that is a ratio of small numbers, 0/0 is all rounding.
        for radius in (-12..=12).map(|k| 2f64.powf(f64::from(k) / 2.0 + 0.17)) {
            for angle in (0..=8).map(|k| std::f64::consts::PI * (0.5 + f64::from(k) / 16.0)) {
                largest = largest.max(growth(&t, Complex::from_polar(radius, angle)).unwrap_or(0.0));
            }
        }
        match &analysis.stability {
            Stability::AStable => prop_assert!(largest <= 1.0 + 1e-8, "{}: {}", description, largest),
            Stability::Not(why) => {
                // The grid need not see it; what is named on the imaginary axis is true.
                if let Some((r, found)) = said(why, &t) {
                    prop_assert!(r > 1.0 && (found - r).abs() <= 0.05 * r, "{}: {} and {}", why, found, r);
                }
            }
            Stability::Undecided(why) => prop_assert!(false, "{}: {}", description, why),
        }
    }

    #[test]
    fn the_theta_method_is_a_stable_from_one_half(p in -20i64..40, q in 1i64..20) {
        let theta = Description::entries(vec![vec![Number::ratio(p, q)]], vec![Number::from(1)]);
        let analysis = analyse(&theta, 1).unwrap();
        prop_assert_eq!(analysis.stability == Stability::AStable, 2 * p >= q, "{}", analysis.stability);
        prop_assert_eq!(matches!(analysis.stability, Stability::Not(_)), 2 * p < q);
    }

    #[test]
    fn two_stiffly_accurate_stages_are_a_stable_between_the_zeros_of_a_quadratic(p in 1i64..40, q in 1i64..40) {
        // R = (1 + (1 − 2γ) z)/(1 − γz)², so |Q|² − |P|² = (−2γ² + 4γ − 1) y² + γ⁴ y⁴.
        let gamma = Number::ratio(p, q);
        let rest = number(&format!("1 - {p}/{q}"));
        let (a, b) = (vec![vec![gamma.clone(), Number::from(0)], vec![rest.clone(), gamma.clone()]], vec![rest, gamma]);
        prop_assume!(p != q);
        let analysis = analyse(&Description::entries(a, b), 1).unwrap();
        let expected = -2 * p * p + 4 * p * q - q * q >= 0;
        prop_assert_eq!(analysis.stability == Stability::AStable, expected, "{}", analysis.stability);
    }
}

// Exact and floating arithmetic, and conditions by hand.

/// Σ over all indices of the product that a formula such as `Σ b_i c_i^2 a_ij ĉ_j` spells.
fn evaluate(formula: &str, t: &Tableau<f64>) -> f64 {
    let hat = t.conjugate();
    let s = t.stages();
    let factors: Vec<(char, Vec<char>, i32)> = formula
        .trim_start_matches("Σ ")
        .split(' ')
        .map(|factor| {
            let (factor, power) = factor.split_once('^').unwrap_or((factor, "1"));
            let (name, indices) = factor.split_once('_').unwrap();
            (name.chars().next().unwrap(), indices.chars().collect(), power.parse().unwrap())
        })
        .collect();
    let mut letters: Vec<char> = factors.iter().flat_map(|factor| factor.1.clone()).collect();
    letters.sort();
    letters.dedup();
    let mut sum = 0.0;
    for code in 0..s.pow(letters.len() as u32) {
        let at: HashMap<char, usize> =
            letters.iter().enumerate().map(|(k, &letter)| (letter, code / s.pow(k as u32) % s)).collect();
        let value = |(name, indices, power): &(char, Vec<char>, i32)| {
            let index: Vec<usize> = indices.iter().map(|letter| at[letter]).collect();
            let x = match name {
                'b' => t.b()[index[0]],
                'c' => t.c()[index[0]],
                'ĉ' => hat.c()[index[0]],
                'a' => t.a()[(index[0], index[1])],
                'â' => hat.a()[(index[0], index[1])],
                _ => panic!("{formula}"),
            };
            x.powi(*power)
        };
        sum += factors.iter().map(value).product::<f64>();
    }
    sum
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn exact_orders_are_those_in_floating_point(description in random::any()) {
        let analysis = analyse(&description, 8).unwrap();
        let t = description.build::<f64>().unwrap();
        let (classical, variational) = orders(&analysis);
        prop_assert_eq!((classical.min(8), variational.min(8)), (classical_order(&t, 8).order, variational_order(&t, 8).order));
        if let Some(rational) = description.rational().unwrap() {
            prop_assert!(analysis.exact);
            prop_assert_eq!(rational.conditions(1).unwrap().order(8), analysis.exactly.classical.clone());
            prop_assert_eq!(rational.conditions(2).unwrap().order(8), analysis.exactly.variational.clone());
        }
        prop_assert!(analysis.to_digits.is_none() && analysis.normalised.is_none());
    }

    #[test]
    fn what_fails_is_what_the_formula_says(description in random::any()) {
        let t = description.build::<f64>().unwrap();
        let analysis = analyse(&description, 5).unwrap();
        let found = &analysis.exactly;
        for (order, failing) in [
            (&found.classical, &found.failing_classical),
            (&found.variational, &found.failing_variational),
        ] {
            prop_assert_eq!(order.broken.is_some(), failing.is_some());
            let Some(failing) = failing else { continue };
            prop_assert_eq!(failing.order, order.order + 1);
            prop_assert_eq!(failing.count, failing.conditions.len());
            prop_assert!(0 < failing.count && failing.count <= failing.total);
            let broken = order.broken.as_ref().unwrap();
            prop_assert!(failing.conditions.iter().any(|condition| condition.tree == broken.tree));
            for condition in &failing.conditions {
                let value = evaluate(&condition.formula, &t);
                prop_assert!((value - condition.weight).abs() <= 1e-12 * value.abs().max(1.0), "{}", condition);
                let defect = condition.weight - 1.0 / condition.density as f64;
                prop_assert!((defect - condition.defect).abs() <= 1e-12 * defect.abs().max(1.0), "{}", condition);
                prop_assert_eq!(condition.exact.is_some(), analysis.exact);
            }
            prop_assert!(failing.conditions.windows(2).all(|pair| pair[0].defect.abs() >= pair[1].defect.abs()));
        }
    }

    /// Trees up to order 9 and B, C, D with one condition for each even order agree: exactly with positive weights, else as bounds.
    #[test]
    fn without_trees_the_orders_are_those_of_the_trees(description in random::any()) {
        let without = analyse(&description, 0).unwrap();
        let trees = analyse(&description, 9).unwrap();
        let (less, more) = (&without.exactly, &trees.exactly);
        for (bound, order) in [(&less.classical, &more.classical), (&less.variational, &more.variational)] {
            prop_assert!(bound.order <= order.order && order.order <= bound.most.unwrap(), "{}: {}", description, bound);
        }
        if without.positive_weights {
            prop_assert!(less.variational.is_exact());
            prop_assert_eq!(less.variational.order, more.variational.order, "{}", description);
        }
    }

    #[test]
    fn the_extra_conditions_of_order_three_and_four_are_listed_when_they_fail(description in random::any()) {
        let t = description.build::<f64>().unwrap();
        let analysis = analyse(&description, 4).unwrap();
        let Some(failing) = &analysis.exactly.failing_variational else { return Ok(()) };
        let (third, fourth) = super::extra_conditions(&t);
        let extras: Vec<(&str, f64)> = match failing.order {
            3 => vec![("Σ b_i ĉ_i^2", third[0])],
            4 => vec![
                ("Σ b_i c_i ĉ_i^2", fourth[0]),
                ("Σ b_i ĉ_i^3", fourth[1]),
                ("Σ b_i c_i a_ij ĉ_j", fourth[2]),
                ("Σ b_i ĉ_i a_ij ĉ_j", fourth[3]),
            ],
            _ => vec![],
        };
        // By hand they are given lower and classical conditions: with those fulfilled the two say the same.
        let classical = analysis.exactly.classical.order >= failing.order;
        for (formula, defect) in extras.into_iter().filter(|_| classical) {
            let listed = failing.conditions.iter().any(|condition| condition.formula == formula);
            // Σd³/b² and Σ b ĉ³ differ in sign and by the other conditions: three of one are those of order 3.
            prop_assert_eq!(listed, defect.abs() > 1e-11, "{}: {}", description, formula);
        }
    }

    #[test]
    fn twelve_digits_have_the_order_to_the_digits_given(description in random::any()) {
        let original = analyse(&description, 6).unwrap();
        let typed = Description::Entries(rounded(&description, 12));
        let analysis = analyse(&typed, 6).unwrap();
        let found = analysis.findings();
        prop_assert_eq!((found.classical.order, found.variational.order), orders(&original), "{}", typed);
        prop_assert!(orders(&analysis) <= orders(&original));
    }
}

#[test]
fn extra_conditions_are_met_in_the_tests() {
    let mut seen = HashMap::new();
    for description in draw(&random::any(), 400) {
        let analysis = analyse(&description, 5).unwrap();
        let (classical, variational) = orders(&analysis);
        *seen.entry((classical > variational, variational)).or_insert(0) += 1;
    }
    // Orders 2 below the classical one, and order 3: where the extra conditions of p = 3 and p = 4 decide.
    assert!(seen[&(true, 2)] >= 5 && seen[&(false, 3)] >= 5, "{seen:?}");
}

/// Of order 3 Σ b_i c_i² = 1/3 holds, and Σ b_i a_ij c_j is 33/200, not 1/6.
#[test]
fn the_row_sums_of_rk4_alone_give_order_two() {
    let moved = typed("0, 0, 0, 0; 1/2, 0, 0, 0; 1/100, 49/100, 0, 0; 0, 0, 1, 0 | 1/6, 1/3, 1/3, 1/6", 6);
    assert_eq!(orders(&moved), (2, 2));
}

// Digits.

#[test]
fn three_digits_are_enough_to_see_order_four() {
    let rk4 = |b: &str| typed(&format!("0, 0, 0, 0; 0.5, 0, 0, 0; 0, 0.5, 0, 0; 0, 0, 1, 0 | {b}"), 8);
    let analysis = rk4("0.167, 0.333, 0.333, 0.167");
    // With symmetric weights Σ b_i c_i = 1/2 holds exactly; Σ b_i c_i² does not.
    assert_eq!((orders(&analysis), digit_orders(&analysis)), ((2, 2), Some((4, 4))));
    assert_eq!((analysis.normalised, analysis.first_rounded.as_deref()), (None, Some("b_1")));
    let irrational = rk4("1/6, sqrt(3)/6*sqrt(3)*2/3, 0.333, 0.167");
    assert!(!irrational.exact);
    assert_eq!((orders(&irrational).1, digit_orders(&irrational)), (1, Some((4, 4))));
    // Only what is rounded moves: half a unit of the third place, and not more.
    let completion = irrational.completion.unwrap();
    assert!((completion.moved - 1.0 / 3000.0).abs() < 1e-6, "{completion:?}");
    assert_eq!(completion.entries.b[0], number("1/6"));
}

#[test]
fn a_coefficient_off_by_a_millionth_is_seen_beyond_its_digits() {
    // Six places are given, and the sixth is wrong by a unit: half a unit is allowed for.
    let rk4 = |x: &str| typed(&format!("0, 0, 0, 0; {x}, 0, 0, 0; 0, 1/2, 0, 0; 0, 0, 1, 0 | 1/6, 1/3, 1/3, 1/6"), 6);
    assert_eq!(orders(&rk4("1/2")), (4, 4));
    let wrong = rk4("0.500001");
    assert_eq!((orders(&wrong), digit_orders(&wrong)), ((1, 1), Some((1, 1))));
    let text = wrong.exactly.failing_classical.unwrap().conditions[0].to_string();
    assert_eq!(text, "Σ b_i c_i = 1/2, is 1500001/3000000 (off by 1/3000000 = 3.33e-7)");
}

#[test]
fn rounded_weights_are_divided_by_their_sum_and_that_is_said() {
    let analysis = typed("0, 0, 0; 0, 0, 0; 0, 0, 0 | 0.333, 0.333, 0.333", 4);
    assert_eq!(analysis.normalised, Some(-0.001));
    assert!(analysis.notes()[0].contains("sum to 1 − 0.001;"), "{:?}", analysis.notes());
    assert_eq!(orders(&analysis), (1, 1));
    // Seventeen digits of an f64 are allowed half a unit of an f64.
    let third = 1.0 / 3.0;
    let b = vec![Number::from(third); 3];
    let typed = Description::entries(vec![vec![Number::from(0); 3]; 3], b);
    assert!(typed.build::<Dd>().is_ok() && typed.rational().unwrap().is_some());
}

#[test]
fn numbers_are_rational_exactly_when_written_so() {
    let show = |text: &str| number(text).rational().map(|x| x.to_string());
    let cases = [("1/3 + 1/6", "1/2"), ("0.1", "1/10"), ("-1.25e-3", "-1/800"), ("sqrt(9/16)", "3/4"), ("0", "0")];
    for (text, expected) in cases {
        assert_eq!(show(text).as_deref(), Some(expected), "{text}");
    }
    for text in ["sqrt(2)", "sqrt(2)*sqrt(2)", "sqrt(-4)", "pi - pi", "1/(1/2 - 0.5)", "1e2600"] {
        assert_eq!(show(text), None, "{text}");
    }
    let exact = ["0.5", "0.4", "0.33", "0.125", "0.0625", "12", "1/3"].map(|text| (text, "0"));
    let other = [("0.167", "1/2000"), ("-0.3333", "1/20000"), ("0.1667e-1", "1/200000"), ("0.16666667", "1/200000000")];
    for (text, expected) in exact.into_iter().chain(other) {
        assert_eq!(number(text).exact_uncertainty().to_string(), expected, "{text}");
        let float: f64 = number(text).uncertainty();
        let exact = number(text).exact_uncertainty().to_f64_fast();
        assert!((float - exact).abs() <= 1e-12 * exact, "{text}");
    }
    // Sixteen and seventeen digits: half a unit of an f64.
    assert_eq!(number("0.3333333333333333").uncertainty::<f64>(), 0.5e-16);
    assert!(number("0.8888888888888888").uncertainty::<f64>() > 0.9e-16);
}

// Notes.

#[test]
fn ralstons_method_is_explained() {
    let notes = named("ralston3", 6).notes();
    assert_eq!(notes.len(), 1);
    for part in [
        "The variational order is 2 although the classical order is 3",
        "D(1) fails at j = 1: Σ_i b_i a_i1 = 1/6, b_1 (1 − c_1) = 2/9",
        "with positive weights D(1) is necessary for variational order 3",
    ] {
        assert!(notes[0].contains(part), "{part}: {notes:?}");
    }
}

/// C(k) and D(k) with 2k + 1 the next odd order: what Gauss and Radau lack is B, one of Lobatto's A and B lacks what the other has.
#[test]
fn what_is_missing_for_the_next_odd_order_is_listed_and_no_more() {
    let missing = |name: &str| -> Vec<(AssumptionKind, usize)> {
        named(name, 8).exactly.missing().iter().map(|failure| (failure.kind, failure.k)).collect()
    };
    for name in ["gauss-1", "gauss-2", "gauss-3", "radau-ia-2", "radau-iia-1", "radau-iia-2", "lobatto-iiic-3"] {
        assert_eq!(missing(name), [], "{name}");
    }
    assert_eq!(missing("lobatto-iiia-3"), [(AssumptionKind::D, 2)]);
    assert_eq!(missing("lobatto-iiib-3"), [(AssumptionKind::C, 2)]);
    for name in ["ralston3", "alexander3"] {
        assert_eq!(missing(name), [(AssumptionKind::D, 1)], "{name}");
    }
}

/// Collocation at a fifth-order set of nodes: B(6), C(5), and D(1) only.
fn boole() -> Description {
    described(
        "0, 0, 0, 0, 0; 251/2880, 323/1440, -11/120, 53/1440, -19/2880; 29/360, 31/90, 1/15, 1/90, -1/360; \
         27/320, 51/160, 9/40, 21/160, -3/320; 7/90, 16/45, 2/15, 16/45, 7/90 | 7/90, 16/45, 2/15, 16/45, 7/90",
    )
}

#[test]
fn order_six_with_d1_alone_is_order_four_for_the_pair() {
    let analysis = analyse(&boole(), 8).unwrap();
    let assumptions = &analysis.exactly.assumptions;
    let found = [&assumptions.b, &assumptions.c, &assumptions.d].map(ToString::to_string);
    assert_eq!((orders(&analysis), found), ((6, 4), ["B(6)", "C(5)", "D(1)"].map(String::from)));
    let failing = analysis.exactly.failing_variational.as_ref().unwrap();
    let texts: Vec<String> = failing.conditions.iter().map(ToString::to_string).collect();
    assert_eq!((failing.count, failing.total), (3, 27));
    assert_eq!(texts[2], "Σ b_i â_ij ĉ_j â_ik ĉ_k = 1/20, is 89/1680 (off by 1/336 = 2.98e-3)");
    let notes = analysis.notes();
    assert!(notes[0].contains("D(2) fails at j = ") && notes[0].contains("for variational order 5"), "{notes:?}");
}

#[test]
fn a_negative_weight_can_give_order_three_without_d1() {
    // a = 2 c dᵀ with d = b (1 − c) + e, where Σe = Σec = Σe²/b = 0: what D(1) lacks does not show in any condition.
    let text = "0, 0, 0, 0; 1/2, -1, 1/4, 1/2; 2/3, -4/3, 1/3, 2/3; 1, -2, 1/2, 1 | 3/4, -2, 3/4, 3/2";
    let analysis = typed(text, 6);
    assert_eq!((orders(&analysis), analysis.exactly.assumptions.d.holds), ((3, 3), 0));
    assert!(analysis.exact && !analysis.positive_weights);
}

// Cost.

#[test]
fn order_eight_of_four_stages_is_decided_at_once() {
    let start = Instant::now();
    assert_eq!(orders(&named("gauss-4", 9)), (8, 8));
    let gauss = start.elapsed();
    // Every condition up to order 8 of a tableau of fractions, though the first ones fail.
    let entry = |i: i64, j: i64| Number::ratio(7 * i - 3 * j + 1, 11 + i * j);
    let a = (0..4).map(|i| (0..4).map(|j| entry(i, j)).collect()).collect();
    let b = vec![Number::ratio(1, 7), Number::ratio(2, 9), Number::ratio(3, 11), number("1 - 1/7 - 2/9 - 3/11")];
    let start = Instant::now();
    let rational = Description::entries(a, b).rational().unwrap().unwrap();
    let mut conditions = rational.conditions(2).unwrap();
    let total: usize = (1..=8).map(|n| conditions.visit(n, |c, tree| Some(c.verdict(tree))).count()).sum();
    let fractions = start.elapsed();
    assert_eq!(total, 1 + 1 + 3 + 8 + 27 + 91 + 350 + 1376);
    assert!(gauss.as_millis() < 500 && fractions.as_millis() < 500, "{gauss:?}, {fractions:?}");
}

#[test]
fn thirty_digits_are_analysed_at_once() {
    let start = Instant::now();
    for (name, order) in [("gauss-4", 8), ("radau-iia-4", 7), ("lobatto-iiie-4", 6)] {
        let t = name.parse::<Description>().unwrap().build::<Dd>().unwrap();
        let typed = Description::Entries(written(&t, |x| number(&format!("{x:.30e}"))));
        let analysis = analyse(&typed, 9).unwrap();
        assert_eq!((digit_orders(&analysis), orders(&analysis)), (Some((order, order)), (1, 1)), "{name}");
    }
    assert!(start.elapsed().as_secs() < 2, "{:?}", start.elapsed());
}

#[test]
fn what_cannot_be_decided_is_not_claimed() {
    // Irrational and full: R has irrational coefficients.
    let odd = typed("pi/10, -sqrt(2)/10; 1/2, pi/7 | 1/2, 1/2", 2);
    assert!(matches!(odd.stability, Stability::Undecided(_)));
    assert!(matches!(named("gauss-11", 2).stability, Stability::Undecided(_)));
}

/// The polynomial of the quadratic above with irrational coefficients: below its smaller zero 1 − 1/√2 the low frequencies grow,
/// though |R| < 1 at the high ones.
#[test]
fn an_irrational_method_that_grows_at_low_frequencies_is_not_a_stable() {
    let of = |gamma: &str| {
        let text = format!("{gamma}, 0; 1 - {gamma}, {gamma} | 1 - {gamma}, {gamma}");
        (typed(&text, 1).stability, entries(&text).build::<f64>().unwrap())
    };
    let (stability, t) = of("sqrt(2)/8");
    let Stability::Not(why) = &stability else { panic!("{stability}") };
    let (r, found) = said(why, &t).unwrap();
    assert!(r > 1.0 && (found - r).abs() <= 1e-6, "{why}: {found}");
    assert!(growth(&t, Complex::new(0.0, 1e3)).unwrap() < 1.0);
    assert_eq!(of("sqrt(2)/4").0, Stability::AStable);
    // The other way round: |Q|² − |P|² = 2.81 y² − 0.74 y⁴.
    let fast = "sqrt(2)/2, 0; 12/5, sqrt(2)/2 | 1/2, 1/2";
    let t = entries(fast).build::<f64>().unwrap();
    let at = |y: f64| growth(&t, Complex::new(0.0, y)).unwrap();
    assert!(at(1.0) < 1.0 && at(3.0) > 1.0, "{} {}", at(1.0), at(3.0));
    assert!(matches!(typed(fast, 1).stability, Stability::Not(_)));
}

/// What is not finite, or may be off by anything, is known to no tolerance and does not vanish.
#[test]
fn a_ball_that_is_not_finite_has_no_tolerance() {
    let ball = |value: f64, size, radius| Ball { value, size, radius };
    assert_eq!(ball(1.0, 1.0, 0.5).tolerance(0), Some(0.5));
    assert!(ball(0.5, 1.0, 0.5).vanishes(0));
    for open in [
        ball(0.0, 1.0, f64::INFINITY),
        ball(0.0, f64::INFINITY, 0.0),
        ball(f64::NAN, 1.0, 0.0),
        ball(f64::INFINITY, 1.0, 0.0),
    ] {
        assert_eq!(open.tolerance(1), None, "{open:?}");
        assert!(!open.vanishes(1), "{open:?}");
    }
}

/// |1 + iy| = √(1 + y²) at the first point of the grid, and the polynomial of order 4 at √10: 1/6 − 2√10/3 i.
#[test]
fn where_an_explicit_method_grows_is_said() {
    let euler = typed("0 | 1", 1).stability;
    assert_eq!(euler.to_string(), "not A-stable: |R(iy)| = 1.00005 at y = 0.01");
    let size = (1f64 / 36.0 + 40.0 / 9.0).sqrt();
    for name in ["rk4", "kutta38"] {
        assert_eq!(named(name, 1).stability.to_string(), format!("not A-stable: |R(iy)| = {size:.8} at y = 3.16"));
    }
}

/// The same method typed with three digits: it grows where half a unit of the third digit cannot matter.
#[test]
fn growth_beyond_the_digits_given_is_no_question_of_rounding() {
    let digits = |gamma: &str, rest: &str| {
        let analysis = typed(&format!("{gamma}, 0; {rest}, {gamma} | {rest}, {gamma}"), 1);
        assert!(analysis.to_digits.is_some());
        analysis.stability
    };
    assert!(matches!(digits("0.177", "0.823"), Stability::Not(_)), "{}", digits("0.177", "0.823"));
    // 1 − 1/√2 = 0.29289…: 0.293 is above, and what is below is within half a unit.
    assert_eq!(digits("0.293", "0.707"), Stability::AStable);
    assert!(matches!(digits("0.29289", "0.70711"), Stability::Undecided(_)), "{}", digits("0.29289", "0.70711"));
}
