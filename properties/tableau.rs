//! Properties of `euler_poincare::tableau`.

mod analysis;
mod digits;
mod files;
mod known;
mod trees;

use euler_poincare::scalar::{Dd, Number, Real, Scalar};
use euler_poincare::tableau::random::{self, TableauKind};
use euler_poincare::tableau::trees::{Branch, Catalogue, Tree};
use euler_poincare::tableau::{
    Classic, Description, Entries, Family, Tableau, TableauError, classical_order, order, variational_order,
};
use nalgebra::ComplexField;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;
use std::collections::{HashMap, HashSet};

/// Every family with the numbers of stages that the exhaustive tests run over.
fn members(largest: usize) -> impl Iterator<Item = (Family, usize)> {
    Family::ALL.into_iter().flat_map(move |family| (family.least_stages()..=largest).map(move |s| (family, s)))
}

/// The rows of a table: texts, with \n for a new line, and what is said of them. There are `count`.
fn rows(table: &'static str, count: usize) -> impl Iterator<Item = (String, &'static str)> {
    assert_eq!(table.lines().count(), count);
    table.lines().map(|row| row.split_once(" → ").unwrap()).map(|(text, said)| (text.replace("\\n", "\n"), said))
}

fn number(text: &str) -> Number {
    Number::parse(text).unwrap()
}

/// The rows of a, the row b, and the nodes where they are given: `0, 0; 1, 0 | 1/2, 1/2 | 0, 1`.
fn entries(text: &str) -> Entries {
    fn row(text: &str) -> Vec<Number> {
        text.split(',').map(str::trim).filter(|x| !x.is_empty()).map(number).collect()
    }
    let mut parts = text.split('|');
    let a = parts.next().unwrap().split(';').map(row).collect();
    Entries { a, b: row(parts.next().unwrap()), c: parts.next().map(row) }
}

fn described(text: &str) -> Description {
    Description::Entries(entries(text))
}

/// The entries of a tableau, each as it is written.
fn written<T: Real>(t: &Tableau<T>, write: impl Fn(T) -> Number) -> Entries {
    let a = (0..t.stages()).map(|i| t.a().row(i).iter().map(|&x| write(x)).collect()).collect();
    Entries { a, b: t.b().iter().map(|&x| write(x)).collect(), c: None }
}

/// Every entry of a tableau as a decimal to a number of places.
fn rounded(description: &Description, places: usize) -> Entries {
    written(&description.build::<Dd>().unwrap(), |x| number(&format!("{x:.places$}")))
}

// Families: the equations that define them (Hairer and Wanner, section IV.5), not those they are computed from.

/// The nodes, from the tableau alone: row sums where C(1) holds, else by D(1): Σ_i b_i a_ij = b_j (1 − c_j).
fn nodes<T: Real>(tableau: &Tableau<T>) -> Vec<T> {
    let (a, b, s) = (tableau.a(), tableau.b(), tableau.stages());
    (0..s).map(|j| T::one() - (0..s).fold(T::zero(), |sum, i| sum + b[i] * a[(i, j)]) / b[j]).collect()
}

/// (name, largest defect) of B(p), C(q) and D(r), each k ≤ its limit.
fn simplifying_assumptions<T: Real>(t: &Tableau<T>, c: &[T], limits: [usize; 3]) -> [f64; 3] {
    let (a, b, s) = (t.a(), t.b(), t.stages());
    let power = |j: usize, k: usize| (0..k).fold(T::one(), |x, _| x * c[j]);
    let sum = |term: &dyn Fn(usize) -> T| (0..s).fold(T::zero(), |sum, j| sum + term(j));
    let over = |x: T, k: usize| x / T::int(k as i64);
    let [mut worst_b, mut worst_c, mut worst_d] = [0.0f64; 3];
    for k in 1..=limits[0] {
        worst_b = worst_b.max((sum(&|j| b[j] * power(j, k - 1)) - over(T::one(), k)).abs().to_f64());
    }
    for k in 1..=limits[1] {
        for i in 0..s {
            let defect = sum(&|j| a[(i, j)] * power(j, k - 1)) - over(power(i, k), k);
            worst_c = worst_c.max(defect.abs().to_f64());
        }
    }
    for k in 1..=limits[2] {
        for j in 0..s {
            let defect = sum(&|i| b[i] * power(i, k - 1) * a[(i, j)]) - over(b[j] * (T::one() - power(j, k)), k);
            worst_d = worst_d.max(defect.abs().to_f64());
        }
    }
    [worst_b, worst_c, worst_d]
}

/// p, q, r of B(p), C(q), D(r).
fn limits(family: Family, s: usize) -> [usize; 3] {
    match family {
        Family::Gauss => [2 * s, s, s],
        Family::LobattoIIIA => [2 * s - 2, s, s - 2],
        Family::LobattoIIIB => [2 * s - 2, s - 2, s],
        Family::LobattoIIIC | Family::LobattoIIID => [2 * s - 2, s - 1, s - 1],
        Family::LobattoIIIE => [2 * s - 2, s - 2, s - 2],
        Family::RadauIA => [2 * s - 1, s - 1, s],
        Family::RadauIIA => [2 * s - 1, s, s - 1],
        _ => panic!("{family:?} has no limits here"),
    }
}

fn simplifying_assumptions_hold<T: Real>() {
    let u = T::unit_roundoff().to_f64();
    for (family, s) in members(16) {
        let t = family.tableau::<T>(s).unwrap();
        let limits = limits(family, s);
        // D(1) gives the nodes, save where only C(1) holds (IIIA-2) and D(1) fails: there the row sums.
        let c: Vec<T> = if limits[2] >= 1 { nodes(&t) } else { t.c().iter().copied().collect() };
        // The terms of a sum have magnitudes that add up to at most 2; each is rounded, and so are the s additions and the
        // coefficients (4 u).
        let bound = (2.0 * s as f64 + 8.0) * u;
        let worst = simplifying_assumptions(&t, &c, limits);
        assert!(worst.iter().all(|&w| w <= bound), "{}-{s}: {worst:?} > {bound:e}", family.name());
        // One more is violated, so the check can fail; s ≤ 6 keeps the true defect above round-off.
        if s <= 6 {
            let more = simplifying_assumptions(&t, &c, limits.map(|k| k + 1));
            assert!(more[0] > 1e-9, "{}-{s} satisfies B({})", family.name(), limits[0] + 1);
        }
    }
}

in_both! {
    families_satisfy_their_simplifying_assumptions: simplifying_assumptions_hold;
    twelve_stages_are_accurate: reference_entries;
}

/// b_2, a_37, a_73, a_11,2 for s = 12, from the defining linear systems in 80-digit arithmetic.
const TWELVE: &str = include_str!("tableau/twelve.txt");

fn reference_entries<T: Real>() {
    assert_eq!(TWELVE.lines().count(), 6);
    for (name, expected) in TWELVE.lines().map(|line| line.split_once(' ').unwrap()) {
        let t = name.parse::<Description>().unwrap().build::<T>().unwrap();
        let found = [t.b()[1], t.a()[(2, 6)], t.a()[(6, 2)], t.a()[(10, 1)]];
        for (x, text) in found.into_iter().zip(expected.split(' ')) {
            let defect = (x - T::parse_decimal(text).unwrap()).abs() / T::unit_roundoff();
            assert!(defect.to_f64() <= 4.0, "{}, {name}: {text} is off by {defect} u", T::NAME);
        }
    }
}

#[test]
fn f64_is_dd_rounded() {
    let families = members(32).map(|(family, s)| (Description::Family(family, s), 4.0));
    // Written out, they may have some more roundings.
    for (description, allowed) in families.chain(Classic::ALL.map(|classic| (Description::Classic(classic), 16.0))) {
        let (x, y) = (description.build::<f64>().unwrap(), description.build::<Dd>().unwrap());
        for (&x, &y) in x.a().iter().zip(y.a().iter()).chain(x.b().iter().zip(y.b().iter())) {
            let defect = ((Dd::exact(x) - y).abs() / Dd::exact(f64::unit_roundoff())).to_f64();
            assert!(defect <= allowed, "{description}: {x} is off by {defect} u");
        }
    }
}

#[test]
fn conjugates_are_as_known() {
    for s in 2..=16 {
        let build = |family: Family| family.tableau::<f64>(s).unwrap();
        for (x, y) in [
            (Family::LobattoIIIA, Family::LobattoIIIB),
            (Family::LobattoIIIB, Family::LobattoIIIA),
            (Family::Gauss, Family::Gauss),
        ] {
            let t = build(x);
            let defect = (t.conjugate().a() - build(y).a()).amax();
            // b_j a_ji/b_i magnifies the rounding of a_ji by b_j/b_i.
            let ratio = t.b().max() / t.b().min();
            assert!(defect <= 8.0 * f64::EPSILON * ratio, "{} {s}: {defect:e}", x.name());
        }
        // The conjugate of Radau IIA is another method: D(s) where IIA has C(s), with its nodes.
        let defect = (build(Family::RadauIIA).conjugate().a() - build(Family::RadauIIA).a()).amax();
        assert!(defect > 1e-3);
    }
}

#[test]
fn every_allowed_number_of_stages_is_built_and_no_other() {
    let largest = euler_poincare::tableau::families::MAX_STAGES;
    for (family, s) in members(largest) {
        let t = family.tableau::<f64>(s).unwrap();
        assert!(t.b().iter().all(|&b| b > 0.0) && t.stages() == s, "{}-{s}", family.name());
    }
    for family in Family::ALL {
        for s in [0, family.least_stages() - 1, largest + 1, 1_000_000, usize::MAX] {
            let error = family.tableau::<f64>(s).unwrap_err();
            assert!(matches!(&error, TableauError::Unknown { .. }), "{error}");
            assert!(error.to_string().contains(&format!("{}-{s}", family.name())), "{error}");
        }
    }
}

#[test]
fn trees_are_distinct() {
    let catalogue = Catalogue::up_to(2, 7);
    let mut seen = HashSet::new();
    for tree in catalogue.trees() {
        assert!(seen.insert(catalogue.show(tree)), "{} twice", catalogue.show(tree));
        assert!(tree.branches().windows(2).all(|pair| pair[0] >= pair[1]));
    }
}

/// The tree hung at each of its vertices, as sorted nested brackets: first at its root, at which `above` hangs as well. Colour 0 points away
/// from the root, colour 1 towards it.
fn hung(catalogue: &Catalogue, tree: &Tree, above: Option<String>) -> Vec<String> {
    let below = |branch: &Branch| &catalogue.trees()[branch.tree];
    let joined = |mut parts: Vec<String>| {
        parts.sort();
        format!("({})", parts.concat())
    };
    let down = |branch: &Branch| format!("{}{}", [">", "<"][branch.colour], hung(catalogue, below(branch), None)[0]);
    let parts: Vec<String> = tree.branches().iter().map(down).chain(above).collect();
    let mut found = vec![joined(parts.clone())];
    for (k, branch) in tree.branches().iter().enumerate() {
        let mut others = parts.clone();
        others.remove(k);
        let up = format!("{}{}", ["<", ">"][branch.colour], joined(others));
        found.extend(hung(catalogue, below(branch), Some(up)));
    }
    found
}

/// The same text for the same oriented tree, whatever its root.
fn without_root(catalogue: &Catalogue, tree: &Tree) -> String {
    hung(catalogue, tree, None).into_iter().min().unwrap()
}

#[test]
fn oriented_trees_are_the_rooted_ones_without_their_roots() {
    let catalogue = Catalogue::up_to(2, 7);
    for n in 1..=7 {
        let all: HashSet<String> = catalogue.of_order(n).iter().map(|tree| without_root(&catalogue, tree)).collect();
        let representatives: Vec<Tree> = catalogue.oriented(n).collect();
        let classes: HashSet<String> = representatives.iter().map(|tree| without_root(&catalogue, tree)).collect();
        assert_eq!((representatives.len(), &classes), (all.len(), &all), "order {n}");
        // Each is a tree of the catalogue, density and all.
        let rooted: HashSet<&Tree> = catalogue.of_order(n).iter().collect();
        assert!(representatives.iter().all(|tree| rooted.contains(tree)), "order {n}");
    }
}

// Orders.

#[test]
fn orders_are_bounded_by_the_trees_that_are_looked_at() {
    // 17 digits of Gauss-2 are not Gauss-2.
    let rounded = Family::Gauss.tableau::<f64>(2).unwrap();
    let a: Vec<Vec<Dd>> = (0..2).map(|i| rounded.a().row(i).iter().map(|&x| Dd::exact(x)).collect()).collect();
    let t = Tableau::new(&a, &[Dd::exact(0.5), Dd::exact(0.5)]).unwrap();
    assert!(classical_order(&t, 4).order < 4);
    let euler = entries("0 | 1").build::<f64>().unwrap();
    assert_eq!((classical_order(&euler, 4).order, variational_order(&euler, 4).order), (1, 1));
    let gauss = Family::Gauss.tableau::<f64>(3).unwrap();
    assert_eq!(variational_order(&gauss, 5).to_string(), "at least 5");
    assert_eq!(variational_order(&gauss, 7).to_string(), "6");
}

#[test]
fn a_coefficient_wrong_in_the_ninth_digit_lowers_the_order() {
    let mut a: Vec<Vec<f64>> =
        (0..3).map(|i| Family::Gauss.tableau(3).unwrap().a().row(i).iter().copied().collect()).collect();
    let b: Vec<f64> = Family::Gauss.tableau(3).unwrap().b().iter().copied().collect();
    a[0][2] += 1e-9;
    a[2][0] -= 1e-9;
    let t = Tableau::new(&a, &b).unwrap();
    assert_eq!((classical_order(&t, 6).order, variational_order(&t, 6).order), (2, 2));
}

/// The conditions written out by hand, d = aᵀb: beyond the classical ones, p = 3 has one and p = 4 has four.
fn extra_conditions(t: &Tableau<f64>) -> ([f64; 1], [f64; 4]) {
    let (a, b, c, s) = (t.a(), t.b(), t.c(), t.stages());
    let d: Vec<f64> = (0..s).map(|j| (0..s).map(|i| b[i] * a[(i, j)]).sum()).collect();
    let sum = |f: &dyn Fn(usize) -> f64| (0..s).map(f).sum::<f64>();
    let double = |f: &dyn Fn(usize, usize) -> f64| (0..s).map(|i| (0..s).map(|j| f(i, j)).sum::<f64>()).sum::<f64>();
    (
        [sum(&|i| d[i] * d[i] / b[i]) - 1.0 / 3.0],
        [
            sum(&|i| c[i] * d[i] * d[i] / b[i]) - 1.0 / 12.0,
            sum(&|i| d[i] * d[i] * d[i] / (b[i] * b[i])) - 1.0 / 4.0,
            double(&|i, j| b[i] * c[i] * a[(i, j)] * d[j] / b[j]) - 5.0 / 24.0,
            double(&|i, j| d[i] * a[(i, j)] * d[j] / b[j]) - 1.0 / 8.0,
        ],
    )
}

/// The order of the pair by its definition: all bicoloured rooted trees, none left out.
fn brute_force_order(t: &Tableau<f64>, max: usize) -> usize {
    let mut conditions = order::Conditions::new(t, 2);
    for n in 1..=max {
        conditions.prepare(n);
        let holds = conditions.catalogue().of_order(n).iter().all(|tree| conditions.verdict(tree).holds);
        if !holds {
            return n - 1;
        }
    }
    max
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 256, ..ProptestConfig::default() })]

    #[test]
    fn oriented_trees_decide_as_all_rooted_trees_do(description in random::any()) {
        let t = description.build::<f64>().unwrap();
        let variational = variational_order(&t, 6).order;
        prop_assert_eq!(variational, brute_force_order(&t, 6));
        prop_assert!(variational <= classical_order(&t, 6).order);
    }

    #[test]
    fn order_of_the_pair_is_the_classical_order_and_the_conditions_by_hand(description in random::any()) {
        let t = description.build::<f64>().unwrap();
        let (third, fourth) = extra_conditions(&t);
        // 1/b² ≤ 400 magnifies round-off.
        let holds = |defects: &[f64]| defects.iter().all(|d| d.abs() < 1e-11);
        let extra = if !holds(&third) { 2 } else if !holds(&fourth) { 3 } else { 4 };
        prop_assert_eq!(variational_order(&t, 4).order, classical_order(&t, 4).order.min(extra));
    }

    #[test]
    fn the_conjugate_has_the_same_order_and_returns(description in random::any()) {
        let t = description.build::<f64>().unwrap();
        let hat = t.conjugate();
        prop_assert_eq!(variational_order(&hat, 5).order, variational_order(&t, 5).order);
        let scale = t.a().amax().max(hat.a().amax()) * t.b().amax() / t.b().iter().fold(1.0, |m: f64, b| m.min(b.abs()));
        prop_assert!((hat.conjugate().a() - t.a()).amax() <= 4.0 * f64::EPSILON * scale.max(1.0));
        // The symplectic relation b_i â_ij + b_j a_ji = b_i b_j.
        for i in 0..t.stages() {
            for j in 0..t.stages() {
                let defect = t.b()[i] * hat.a()[(i, j)] + t.b()[j] * t.a()[(j, i)] - t.b()[i] * t.b()[j];
                prop_assert!(defect.abs() <= 4.0 * f64::EPSILON * scale.max(1.0));
            }
        }
    }

    #[test]
    fn descriptions_survive_a_round_trip(description in random::any()) {
        let json = serde_json::to_string(&description).unwrap();
        prop_assert_eq!(&serde_json::from_str::<Description>(&json).unwrap(), &description, "{}", json);
        let table = HashMap::from([("tableau", &description)]);
        let text = toml::to_string(&table).unwrap();
        let back: HashMap<String, Description> = toml::from_str(&text).unwrap();
        prop_assert_eq!(&back["tableau"], &description, "{}", text);
        if !matches!(description, Description::Entries(_)) {
            prop_assert_eq!(&description.to_string().parse::<Description>().unwrap(), &description);
        }
    }
}

// Random tableaux.

fn draw<T: std::fmt::Debug>(strategy: &BoxedStrategy<T>, count: usize) -> Vec<T> {
    let mut runner = TestRunner::deterministic();
    (0..count).map(|_| strategy.new_tree(&mut runner).unwrap().current()).collect()
}

#[test]
fn random_tableaux_are_what_their_kind_says() {
    for kind in TableauKind::ALL {
        let mut negative = 0;
        let mut stages = HashMap::new();
        for description in draw(&random::of_kind(kind), 500) {
            let t = description.build::<f64>().unwrap_or_else(|error| panic!("{description}: {error}"));
            let p = classical_order(&t, 3).order;
            *stages.entry(t.stages()).or_insert(0) += 1;
            negative += usize::from(t.b().min() < 0.0);
            assert!((p >= 1) && (kind != TableauKind::OrderTwo || p >= 2), "{description}: order {p}");
            if kind == TableauKind::Collocation {
                assert!(classical_order(&t, 3).order >= t.stages(), "{description}");
            }
            if kind != TableauKind::Named {
                let least = t.b().iter().fold(f64::MAX, |m, b| m.min(b.abs()));
                assert!(least > 0.166 && t.b().amax() <= 2.5 && t.a().amax() <= 2.5, "{description}");
                let (allowed, name): (&[&str], _) = match kind {
                    TableauKind::Explicit => (&["explicit"], description.kind()),
                    TableauKind::DiagonallyImplicit => (&["explicit", "diagonally-implicit"], description.kind()),
                    _ => (&["explicit", "diagonally-implicit", "fully-implicit"], description.kind()),
                };
                assert!(allowed.contains(&name), "{description}: {name}");
            }
        }
        assert!(stages.len() >= 2 && stages.values().all(|&n| n >= 10), "{kind:?}: {stages:?}");
        if matches!(
            kind,
            TableauKind::Full | TableauKind::Explicit | TableauKind::DiagonallyImplicit | TableauKind::OrderTwo
        ) {
            assert!((100..400).contains(&negative), "{kind:?}: {negative} of 500 with a negative weight");
        }
    }
}

#[test]
fn every_kind_turns_up() {
    let drawn = draw(&random::any(), 2000);
    let mut counts: HashMap<&str, usize> = HashMap::new();
    drawn.iter().for_each(|description| *counts.entry(description.kind()).or_default() += 1);
    let families = Family::DRAWN.iter().map(|f| f.name()).chain(Classic::DRAWN.iter().map(|c| c.name()));
    // The rarest are expected 28 times: 8 is four standard deviations below.
    for name in families {
        assert!(counts.get(name).copied().unwrap_or(0) >= 8, "{name}: {counts:?}");
    }
    for name in ["explicit", "diagonally-implicit", "fully-implicit"] {
        assert!(counts.get(name).copied().unwrap_or(0) >= 100, "{name}: {counts:?}");
    }
}

#[test]
fn random_tableaux_shrink_to_the_simplest() {
    let mut runner = TestRunner::deterministic();
    for _ in 0..50 {
        let mut tree = random::any().new_tree(&mut runner).unwrap();
        while tree.simplify() {}
        assert_eq!(tree.current(), Description::Family(Family::Gauss, 1));
    }
    // What fails for more than one stage only shrinks to two stages.
    for _ in 0..50 {
        let mut tree = random::any().new_tree(&mut runner).unwrap();
        if tree.current().stages() < 2 {
            continue;
        }
        while if tree.current().stages() >= 2 { tree.simplify() } else { tree.complicate() } {}
        assert_eq!(tree.current().stages(), 2);
    }
}

// Input.

#[test]
fn names_parse_and_print() {
    let families = members(12).map(|(family, s)| (format!("{}-{s}", family.name()), Description::Family(family, s)));
    let classics = Classic::ALL.map(|classic| (classic.name().to_string(), Description::Classic(classic)));
    for (name, expected) in families.chain(classics) {
        let description: Description = name.parse().unwrap();
        assert_eq!((&description, description.to_string()), (&expected, name));
        assert_eq!(description.build::<f64>().unwrap().stages(), description.stages());
    }
}

#[test]
fn bad_names_are_refused_with_what_is_allowed() {
    for (names, expected) in rows(include_str!("tableau/wrong/names.txt"), 8) {
        for name in names.split(';') {
            let error = name.parse::<Description>().unwrap_err().to_string();
            assert!(error.contains(expected), "{name}: {error}");
            assert!(serde_json::from_str::<Description>(&format!("\"{name}\"")).is_err());
        }
    }
}

#[test]
fn bad_entries_are_refused_by_name() {
    // More are in tableau/files.rs.
    for (text, expected) in rows(include_str!("tableau/wrong/entries.txt"), 8) {
        let error = entries(&text).build::<f64>().unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    let wide: Vec<Vec<Number>> =
        (0..12).map(|i| (0..12).map(|j| number(if (i, j) == (2, 10) { "1/0" } else { "0" })).collect()).collect();
    let error = Description::entries(wide, vec![number("1/12"); 12]).build::<f64>().unwrap_err();
    assert!(error.to_string().contains("a_3,11"), "{error}");
    let bad = |x: f64| Tableau::new(&[vec![0.5, x], vec![0.0, 0.5]], &[0.5, 0.5]).unwrap_err().to_string();
    assert!(bad(f64::NAN).contains("a_12") && bad(f64::INFINITY).contains("a_12"));
    assert!(Tableau::new(&[vec![0.5]], &[f64::NAN]).unwrap_err().to_string().contains("b_1"));
}

#[test]
fn decimals_are_taken_to_the_digits_given() {
    // Half a unit each of the tenth place: enough for 1/3, 1/3, 1/3, and not for a wrong last digit but one.
    let build = |b: &str| entries(&format!("0, 0, 0; 0, 0, 0; 0, 0, 0 | {b}")).build::<f64>();
    let t = build("0.3333333333, 0.3333333333, 0.3333333333").unwrap();
    assert!((t.b()[1] - 1.0 / 3.0).abs() <= f64::EPSILON);
    // Exact entries get no allowance: only the one rounded entry does. Three places are enough, if they are no dyadic rational; two are exact.
    let taken = "1/3, 1/3, 0.3333333333; 0.333, 0.333, 0.333; 0.25, 0.5, 0.25; 2.5e-1, 50e-2, -(-0.25)";
    let refused = "0.3333333333, 0.3333333333, 0.3333333323; 1/3, 1/3, 0.3333333331; 0.33, 0.33, 0.33; 0.125, 0.375, 0.501; \
                   0.125, 0.375, 0.499";
    for (rows, expected) in [(taken, true), (refused, false)] {
        rows.split("; ").for_each(|b| assert_eq!(build(b).is_ok(), expected, "{b}"));
    }
}

#[test]
fn given_nodes_must_be_the_row_sums() {
    let build = |c: &str| {
        let text = format!("1/4, 1/4 - sqrt(3)/6; 1/4 + sqrt(3)/6, 1/4 | 1/2, 1/2 | {c}");
        entries(&text).build::<f64>().map_err(|error| error.to_string())
    };
    assert!(build("1/2 - sqrt(3)/6, 1/2 + sqrt(3)/6").is_ok());
    assert!(build("0.2113248654, 0.7886751346").is_ok());
    assert!(build("0.2113248653, 0.7886751346").unwrap_err().contains("c_1"));
    assert!(build("1/2 - sqrt(3)/6, 0.8").unwrap_err().contains("c_2"));
    assert!(build("0.5").unwrap_err().contains("entry c:"));
}

/// c may be off by what the entries of a and c itself are rounded by, all together.
#[test]
fn nodes_of_rounded_rows_have_the_allowance_of_each_entry() {
    for (row, taken, refused) in
        [("0.333, 0", "1/3 0.3334 0.3326", "0.3336 0.3324"), ("0.333, 0.333", "0.6669", "0.6671")]
    {
        for (nodes, expected) in [(taken, true), (refused, false)] {
            for c in nodes.split(' ') {
                let built = entries(&format!("{row}; 0, 0 | 1/2, 1/2 | {c}, 0")).build::<f64>();
                assert_eq!(built.is_ok(), expected, "{row}: {c}");
            }
        }
    }
}

#[test]
fn files_are_read_strictly() {
    let read =
        |text: &str| toml::from_str::<HashMap<String, Description>>(text).map(|mut table| table.remove("t").unwrap());
    let table = read("[t]\na = [[0, 0], [1, 0.0]]\nb = [\"1/2\", 0.5]\nc = [0, 1]").unwrap();
    assert_eq!(table.build::<f64>().unwrap(), Classic::Heun2.tableau().unwrap());
    assert_eq!(read("t = \"gauss-3\"").unwrap(), Description::Family(Family::Gauss, 3));
    for (text, expected) in rows(include_str!("tableau/wrong/descriptions.txt"), 7) {
        let error = read(&text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
}
