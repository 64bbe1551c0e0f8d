//! Orders beyond the trees, from B, C and D.

use euler_poincare::scalar::Dd;
use euler_poincare::tableau::random;
use euler_poincare::tableau::{Description, Family, analyse};
use proptest::prelude::*;

/// Trees end at order 12 and 13; B(2s), C(s), D(s) prove order 2s of Gauss's methods, and the like of the others.
#[test]
fn families_have_their_orders_at_any_number_of_stages() {
    for family in Family::ALL {
        for s in [7, 8, 12, 25] {
            let description = Description::Family(family, s);
            let found = analyse::<Dd>(&description, 4).unwrap().exactly;
            let order = family.declared(s);
            assert_eq!((found.classical.order, found.variational.order), (order, order), "{description}");
            assert!(found.classical.is_exact() && found.variational.is_exact(), "{description}");
        }
    }
}

#[test]
fn gauss_7_is_of_order_14_for_the_pair_too() {
    let analysis = analyse::<Dd>(&"gauss-7".parse().unwrap(), 9).unwrap();
    let orders = analysis.findings();
    assert_eq!([&orders.classical, &orders.variational].map(ToString::to_string), ["14", "14"]);
    assert_eq!([13, 14, 15].map(|order| analysis.has_order(order)), [Some(false), Some(true), Some(false)]);
    let text = analysis.notes().join("\n");
    assert!(!text.contains("although"), "{text}");
    assert!(orders.hints().iter().any(|hint| hint.starts_with("B(15) fails")), "{:?}", orders.hints());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

    /// Trees up to order 7 and no trees agree: exactly with positive weights, else as bounds.
    #[test]
    fn without_trees_the_orders_are_those_of_the_trees(description in random::any()) {
        let without = analyse::<Dd>(&description, 0).unwrap();
        let trees = analyse::<Dd>(&description, 7).unwrap();
        let (less, more) = (&without.exactly, &trees.exactly);
        for (bound, order) in [(&less.classical, &more.classical), (&less.variational, &more.variational)] {
            prop_assert!(bound.order <= order.order && order.order <= bound.most.unwrap(), "{}: {}", description, bound);
        }
        if without.positive_weights {
            prop_assert!(less.variational.is_exact());
            prop_assert_eq!(less.variational.order, more.variational.order, "{}", description);
        }
    }
}
