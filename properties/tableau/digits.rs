//! Typed decimals: one rule for every tableau and any number of places.

use super::{entries, number, rounded};
use euler_poincare::scalar::{Dd, Number, Scalar};
use euler_poincare::tableau::stability::Stability;
use euler_poincare::tableau::{Analysis, Description, Entries, Family, analyse};

fn analysed(entries: &Entries) -> Analysis {
    analyse(&Description::Entries(entries.clone()), 6).unwrap()
}

/// The families of the grid, and tableaux with thirds.
fn grid() -> Vec<Description> {
    use Family::{Gauss, LobattoIIIA, LobattoIIIB, LobattoIIIC, RadauIA, RadauIIA};
    let families = [Gauss, LobattoIIIA, LobattoIIIB, LobattoIIIC, RadauIA, RadauIIA].into_iter();
    let members = families.flat_map(|family| (family.least_stages()..=5).map(move |s| Description::Family(family, s)));
    members.chain(["rk4", "kutta38", "ralston3", "sdirk2"].map(|name| name.parse().unwrap())).collect()
}

/// The pairs of an entry typed and an entry of the completion.
fn pairs<'e>(typed: &'e Entries, found: &'e Entries) -> impl Iterator<Item = (&'e Number, &'e Number)> {
    typed.a.iter().flatten().chain(&typed.b).zip(found.a.iter().flatten().chain(&found.b))
}

#[test]
fn the_order_to_the_digits_given_is_that_of_the_exact_tableau() {
    for description in grid() {
        let named = analyse(&description, 6).unwrap().exactly;
        let (classical, variational) = (named.classical.order, named.variational.order);
        for places in [6, 8, 10, 12, 16] {
            let name = format!("{description} to {places} places");
            let entries = rounded(&description, places);
            let analysis = analysed(&entries);
            let found = analysis.findings();
            assert_eq!((found.classical.order, found.variational.order), (classical, variational), "{name}");
            assert!(found.variational.is_exact(), "{name}: {}", found.variational);
            assert_eq!(analysis.has_order(variational), Some(true), "{name}");
            assert_eq!(analysis.has_order(variational.saturating_sub(1)), Some(false), "{name}");
            assert_ne!(analysis.has_order(variational + 1), Some(true), "{name}");
            assert_eq!(analysis.has_order(2 * entries.b.len() + 1), Some(false), "{name}");
            assert!(analysis.exactly.variational.order <= variational, "{name}");
            let Some(completion) = &analysis.completion else {
                assert!(analysis.first_rounded.is_none(), "{name}");
                continue;
            };
            assert_eq!(completion.order, variational, "{name}");
            let [uniform, own] = [true, false].map(|uniform| entries.allowances(uniform));
            for (at, (given, found)) in pairs(&entries, &completion.entries).enumerate() {
                let distance = (given.eval::<Dd>().unwrap() - found.eval::<Dd>().unwrap()).to_f64().abs();
                let allowance = uniform[at].max(own[at]);
                assert!(distance <= allowance * (1.0 + 2e-6), "{name}: {given} became {found}");
                assert!(distance <= completion.moved * (1.0 + 1e-9), "{name}");
            }
        }
    }
}

/// Gauss's methods are the only ones of order 2s, so these digits have one answer.
#[test]
fn gauss_is_found_from_its_first_digits() {
    for stages in 1..=5 {
        for places in [4, 8, 16] {
            let exact = Family::Gauss.tableau::<Dd>(stages).unwrap();
            let analysis = analysed(&rounded(&Description::Family(Family::Gauss, stages), places));
            // Those of one stage, 0.5 and 1, are exact.
            assert_eq!(analysis.completion.is_none(), stages == 1, "{stages} stages, {places} places");
            let Some(completion) = &analysis.completion else { continue };
            let found = completion.entries.build::<Dd>().unwrap();
            let distance = (found.a() - exact.a()).amax().to_f64();
            assert!(distance < 1e-29, "{stages} stages, {places} places: {distance:e}");
            assert!(analysis.symplectic && analysis.symmetry.holds(), "{stages} stages, {places} places");
        }
    }
}

/// Exactly, eight digits of Gauss-3 are of order 1: Σ b_i c_i is not 1/2.
#[test]
fn exactly_the_digits_of_gauss_3_are_of_order_one() {
    for places in [6, 8, 10] {
        let analysis = analysed(&rounded(&"gauss-3".parse().unwrap(), places));
        let exactly = &analysis.exactly;
        assert_eq!((exactly.classical.order, exactly.variational.order), (1, 1), "{places}");
        assert!(exactly.classical.is_exact() && analysis.exact, "{places}");
        let notes = analysis.notes().join("\n");
        for part in [
            "a_11 is a rounded decimal",
            "A tableau of variational order 6 rounds to these digits",
            "order of exactly these digits is 1: Σ b_i c_i = 1/2, is ",
        ] {
            assert!(notes.contains(part), "{part}: {notes}");
        }
    }
    // With |R| = 1 on the imaginary axis, the ninth digit decides: that is no answer about the method.
    let analysis = analysed(&rounded(&"gauss-3".parse().unwrap(), 8));
    assert!(matches!(analysis.stability, Stability::Undecided(_)), "{}", analysis.stability);
    let explicit = analysed(&rounded(&"ralston3".parse().unwrap(), 8));
    assert!(matches!(explicit.stability, Stability::Not(_)), "{}", explicit.stability);
}

/// A digit that is wrong by more than half a unit is no rounding, whatever the number of places.
#[test]
fn a_wrong_last_digit_is_seen() {
    for (name, order) in [("gauss-2", 4), ("gauss-3", 6), ("radau-iia-3", 5), ("lobatto-iiia-3", 4)] {
        for places in [6, 10, 14] {
            let mut entries = rounded(&name.parse().unwrap(), places);
            let off = format!("{} + 2e-{places}", entries.a[1][0]);
            let value = number(&off).eval::<Dd>().unwrap();
            entries.a[1][0] = number(&format!("{value:.places$}"));
            let analysis = analysed(&entries);
            let found = analysis.findings().variational.order;
            assert!(found < order, "{name} to {places} places: {found}");
        }
    }
}

/// An `f64` that was computed is seldom right to the last bit.
#[test]
fn doubles_are_allowed_four_units_in_the_last_place() {
    for name in ["gauss-2", "gauss-3", "gauss-5", "radau-iia-3", "lobatto-iiia-4", "sdirk2"] {
        let description: Description = name.parse().unwrap();
        let order = analyse(&description, 6).unwrap().exactly.variational.order;
        let t = description.build::<Dd>().unwrap();
        for ulps in [0, 1, 3] {
            let moved = |at: usize, x: f64| {
                Number::from(f64::from_bits(x.to_bits() + if at.is_multiple_of(2) { ulps } else { 0 }))
            };
            let s = t.stages();
            let exact = |x: f64| x == 0.0 || x.fract() == 0.0;
            let entry = |at: usize, x: f64| if exact(x) { Number::from(x) } else { moved(at, x) };
            let a = (0..s).map(|i| (0..s).map(|j| entry(i + j, t.a()[(i, j)].to_f64())).collect()).collect();
            let b = t.b().iter().map(|&x| Number::from(x.to_f64())).collect();
            let analysis = analysed(&Entries { a, b, c: None });
            assert_eq!(analysis.findings().variational.order, order, "{name}, {ulps} units off");
        }
    }
}

/// Digits whose exact orders are the same need no search, and are not moved.
#[test]
fn digits_that_do_not_matter_stay() {
    // Any c_2 does for order 1, and none near is of order 2.
    let analysis = analysed(&entries("0, 0; 0.333, 0 | 0.5, 0.5"));
    assert!(!analysis.rounding_matters());
    let completion = analysis.completion.as_ref().unwrap();
    assert_eq!((completion.moved, analysis.findings().variational.order), (0.0, analysis.exactly.variational.order));
    assert!(analysis.notes()[0].contains("The orders of exactly these digits are the same"), "{:?}", analysis.notes());
}

/// Where there are too many entries to look for, orders that the digits do not exclude are neither confirmed nor refuted.
#[test]
fn what_is_not_searched_is_left_open() {
    let analysis = analysed(&rounded(&"gauss-13".parse().unwrap(), 20));
    assert!(analysis.completion.is_none());
    assert_eq!(analysis.has_order(26), None);
    assert_eq!(analysis.has_order(27), Some(false));
    let notes = analysis.notes().join("\n");
    assert!(notes.contains("was found; order 26 is not excluded"), "{notes}");
    assert!(!analysis.findings().variational.is_exact());
}
