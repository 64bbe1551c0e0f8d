//! Random tableaux of known order: every one that is drawn has exactly the orders it claims, by exact rational arithmetic.

use super::draw;
use dashu_int::UBig;
use dashu_ratio::RBig;
use euler_poincare::tableau::assumptions::Assumptions;
use euler_poincare::tableau::known::{
    self, Class, KnownOrder, LARGEST_COLLOCATION_DENOMINATOR, LARGEST_DENOMINATOR, LEAST_COLLOCATION_WEIGHT,
    LEAST_WEIGHT, MAX_COLLOCATION, Means, Orders, Shape, VISIBLE, VISIBLE_RELATIVE,
};
use euler_poincare::tableau::quantity::Coefficients;
use euler_poincare::tableau::random::{self, TableauKind};
use euler_poincare::tableau::structure::is_symplectic;
use euler_poincare::tableau::{Description, classical_order, variational_order};
use proptest::strategy::{BoxedStrategy, Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use std::collections::HashMap;
use std::fmt::Write;

/// All strategies of a single kind, with their names.
fn all() -> Vec<(String, BoxedStrategy<KnownOrder>)> {
    let classes = known::classes().into_iter().map(|class| (class.to_string(), known::of_class(class)));
    let order = |p| Some((format!("collocation of order {p}"), known::collocation_of_order(p)?));
    classes.chain((1..=MAX_COLLOCATION).filter_map(order)).collect()
}

/// The largest order all of whose conditions hold, exactly, and whether the next fails as visibly as promised.
fn order(t: &Coefficients<RBig>, colours: usize) -> (usize, bool) {
    let mut conditions = t.conditions(colours).unwrap();
    for n in 1.. {
        conditions.prepare(n);
        let (mut holds, mut visible) = (true, false);
        for tree in conditions.catalogue().of_order(n) {
            let verdict = conditions.verdict(tree);
            holds &= verdict.holds;
            let promised = if n <= 5 { VISIBLE } else { VISIBLE_RELATIVE / tree.density() as f64 };
            visible |= verdict.defect.abs() >= promised * 0.999;
        }
        if !holds {
            return (n - 1, visible);
        }
    }
    unreachable!()
}

/// The coefficients, exactly; the largest of their denominators is as promised.
fn coefficients(description: &Description, largest: u64) -> Coefficients<RBig> {
    let exact = description.rational().unwrap().unwrap();
    let found = exact.a.iter().flatten().chain(&exact.b).map(RBig::denominator).max();
    assert!(found.unwrap() <= &UBig::from(largest), "{description}");
    exact
}

#[test]
fn the_orders_are_exactly_as_claimed() {
    for (name, strategy) in all() {
        for known in draw(&strategy, 100) {
            let KnownOrder { description, orders, .. } = &known;
            let t = description.build::<f64>().unwrap();
            assert_eq!(classical_order(&t, orders.classical + 1).order, orders.classical, "{name}: {description}");
            assert_eq!(
                variational_order(&t, orders.variational + 1).order,
                orders.variational,
                "{name}: {description}"
            );
            let Description::Entries(_) = description else { continue };
            let exact = description.rational().unwrap().unwrap();
            assert_eq!(order(&exact, 1), (orders.classical, true), "{name}: {description}");
            assert_eq!(order(&exact, 2), (orders.variational, true), "{name}: {description}");
        }
    }
}

#[test]
fn a_class_is_what_it_says() {
    for class in known::classes() {
        let (mut negative, mut stages) = (0, HashMap::new());
        for KnownOrder { description, orders, .. } in draw(&known::of_class(class), 100) {
            assert_eq!(orders, class.orders);
            assert_eq!(description.kind(), class.shape.name(), "{class}: {description}");
            let t = description.build::<f64>().unwrap();
            let least = t.b().iter().fold(f64::MAX, |least, b| least.min(b.abs()));
            assert!(
                least > LEAST_WEIGHT - 1e-9 && t.b().amax() <= 2.0 && t.a().amax() <= 2.0,
                "{class}: {description}"
            );
            assert!(t.conjugate().a().amax() < 4.0 + 1e-6, "{class}: {description}");
            let exact = coefficients(&description, LARGEST_DENOMINATOR as u64);
            let (d1, symplectic) = (Assumptions::of(&exact).d.holds >= 1, is_symplectic(&exact));
            match class.means {
                Means::D1 => assert!(d1, "{class}: {description}"),
                Means::NotD1 | Means::Pair => assert!(!d1 && !symplectic, "{class}: {description}"),
                Means::Symplectic => assert!(symplectic, "{class}: {description}"),
                Means::Free => {}
            }
            negative += usize::from(t.b().min() < 0.0);
            *stages.entry(t.stages()).or_insert(0) += 1;
        }
        let always = class.means == Means::Pair
            || (class.means == Means::Symplectic
                && class.shape == Shape::DiagonallyImplicit
                && class.orders.classical == 3);
        let allowed = if always { 100..=100 } else { 2..=60 };
        assert!(allowed.contains(&negative), "{class}: {negative} of 100 with a negative weight");
        assert!(stages.len() >= 2, "{class}: {stages:?}");
    }
}

#[test]
fn collocation_is_collocation() {
    for p in 1..=MAX_COLLOCATION {
        let mut variational = HashMap::new();
        for KnownOrder { description, orders, .. } in draw(&known::collocation_of_order(p).unwrap(), 100) {
            assert_eq!(orders.classical, p);
            *variational.entry(orders.variational).or_insert(0) += 1;
            let Description::Entries(_) = &description else { continue };
            let exact = coefficients(&description, LARGEST_COLLOCATION_DENOMINATOR as u64);
            let (assumptions, s) = (Assumptions::of(&exact), exact.stages());
            assert!(assumptions.b.holds >= s && assumptions.c.holds >= s, "{description}");
            assert!(
                exact.b.iter().all(|b| b.to_f64().value().abs() > LEAST_COLLOCATION_WEIGHT - 1e-9),
                "{description}"
            );
        }
        let expected: &[usize] = [&[1][..], &[2], &[2, 3], &[2, 4], &[2, 4, 5], &[2, 4, 6]][p - 1];
        assert!(expected.iter().all(|v| variational[v] >= 5) && variational.len() == expected.len(), "{variational:?}");
    }
    assert!(known::collocation_of_order(0).is_none() && known::collocation_of_order(MAX_COLLOCATION + 1).is_none());
}

#[test]
fn every_order_and_shape_turns_up() {
    let mut counts: HashMap<(Orders, &str), usize> = HashMap::new();
    let (mut negative, mut symplectic, count) = (0, 0, 3000);
    for KnownOrder { description, orders, .. } in draw(&known::any_of_known_order(), count) {
        let t = description.build::<f64>().unwrap();
        negative += usize::from(t.b().min() < 0.0);
        symplectic += usize::from((t.a() - t.conjugate().a()).amax() < 1e-12);
        let kind = description.kind();
        let full = Shape::ALL.into_iter().all(|shape| shape.name() != kind);
        *counts.entry((orders, if full { Shape::Full.name() } else { kind })).or_default() += 1;
    }
    // One class in thirty has 100 of 3000; 60 is four standard deviations below.
    for Class { orders, shape, .. } in known::classes() {
        assert!(counts[&(orders, shape.name())] >= 60, "{orders} {}: {counts:?}", shape.name());
    }
    let third = count / 3..2 * count / 3;
    assert!(third.contains(&negative), "{negative} of {count} with a negative weight");
    assert!((count / 10..count / 3).contains(&symplectic), "{symplectic} of {count} symplectic");
}

/// A case that was written down is drawn again by every later version: the draws are those of the snapshot, and how many
/// choices they take.
#[test]
fn a_seed_draws_what_it_drew() {
    let mut text = String::new();
    for kind in TableauKind::ALL {
        let (strategy, mut runner) = (random::of_kind(kind), TestRunner::deterministic());
        for _ in 0..4 {
            writeln!(text, "{kind:?}: {}", strategy.new_tree(&mut runner).unwrap().current()).unwrap();
        }
    }
    for (name, strategy) in all() {
        for known in draw(&strategy, 3) {
            writeln!(text, "{name}: {}", known.description).unwrap();
        }
    }
    crate::trajectories::pin("tableaux", &text);
}

/// Of each order, the members of the families that have it, and no others.
#[test]
fn collocation_of_an_order_has_the_members_of_the_families() {
    for p in 1..=MAX_COLLOCATION {
        let mut found: Vec<String> = draw(&known::collocation_of_order(p).unwrap(), 200)
            .into_iter()
            .filter(|known| !matches!(known.description, Description::Entries(_)))
            .map(|known| known.description.to_string())
            .collect();
        found.sort();
        found.dedup();
        let expected = match p % 2 {
            0 => vec![format!("gauss-{}", p / 2), format!("lobatto-iiia-{}", p / 2 + 1)],
            _ => vec![format!("radau-iia-{}", p.div_ceil(2))],
        };
        assert_eq!(found, expected, "order {p}");
    }
}

/// What each class shrinks to is in the snapshot.
#[test]
fn shrinking_reaches_the_simplest_of_the_class() {
    let mut text = String::new();
    for class in known::classes() {
        let strategy = known::of_class(class);
        let mut runner = TestRunner::deterministic();
        let mut found = Vec::new();
        for _ in 0..20 {
            let mut tree = strategy.new_tree(&mut runner).unwrap();
            while tree.simplify() {}
            found.push(tree.current().description.to_string());
        }
        found.dedup();
        assert_eq!(found.len(), 1, "{class}: {found:?}");
        writeln!(text, "{class}: {}", found[0]).unwrap();
    }
    crate::trajectories::pin("tableaux-simplest", &text);
}

#[test]
fn the_mixture_shrinks_to_the_explicit_euler_tableau() {
    let (strategy, mut runner) = (known::any_of_known_order(), TestRunner::deterministic());
    for _ in 0..30 {
        let mut tree = strategy.new_tree(&mut runner).unwrap();
        while tree.simplify() {}
        assert_eq!(tree.current().description.to_string(), "a = [[0]], b = [1]");
    }
}

/// Whatever fails, all that is tried is of the class, simpler than what failed before, and what is left fails.
#[test]
fn shrinking_stays_in_the_class() {
    let failing: [fn(&Description) -> bool; 3] = [
        |d| d.build::<f64>().is_ok_and(|t| t.b().min() < 0.0),
        |d| d.build::<f64>().is_ok_and(|t| t.a().amax() > 0.7),
        |d| d.build::<f64>().is_ok_and(|t| t.b()[0] < 0.4 && t.b()[0] > 0.0),
    ];
    for (name, strategy) in all() {
        let mut runner = TestRunner::deterministic();
        for fails in failing {
            let mut tree = strategy.new_tree(&mut runner).unwrap();
            let first = tree.current();
            if !fails(&first.description) {
                continue;
            }
            let (mut best, mut steps) = (first.description.clone(), 0);
            let mut go_on = tree.simplify();
            while go_on {
                let KnownOrder { description, orders, .. } = tree.current();
                let t = description.build::<f64>().unwrap();
                assert_eq!(classical_order(&t, 7).order, orders.classical, "{name}: {description}");
                assert_eq!(variational_order(&t, 7).order, orders.variational, "{name}: {description}");
                assert_eq!(orders.classical, first.orders.classical, "{name}: {description}");
                if !name.starts_with("collocation") {
                    assert_eq!((orders, description.kind()), (first.orders, first.description.kind()), "{name}");
                }
                let broken = fails(&description);
                if broken {
                    best = description;
                }
                go_on = if broken { tree.simplify() } else { tree.complicate() };
                steps += 1;
                assert!(steps < 5000, "{name}: no end");
            }
            assert!(fails(&tree.current().description), "{name}: {}", tree.current().description);
            assert_eq!(tree.current().description, best, "{name}");
        }
    }
}
