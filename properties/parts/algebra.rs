//! Algebras.

use super::{broken, clean, missed, names, switched_off};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{Casimir, LieAlgebra, Matrix, Vector};
use euler_poincare::laws::user::algebra::{Constants, UserAlgebra};
use euler_poincare::laws::user::system::WithCasimirs;
use euler_poincare::scalar::{Dd, Real};
use std::collections::BTreeSet;

fn constants<T: Real>(name: &str) -> Constants<T, 3> {
    let entry: Entry = name.parse().unwrap();
    Constants::new(|a, b, c| entry.constant(a, b, c)).casimirs(entry.casimirs().unwrap())
}

fn both(name: &str) -> UserAlgebra<3> {
    UserAlgebra::at_both(constants::<f64>(name), constants::<Dd>(name))
}

/// Validated constants in a basis that is not orthogonal, with the Casimirs in it: as a described system has them.
fn validated<T: Real, const N: usize>(name: &str) -> WithCasimirs<T, N> {
    let skew = Matrix::<T, N>::from_fn(|r, c| if r == c { T::one() } else { T::ratio((r + 2 * c) as i64 % 3, 8) });
    let entry: Entry = name.parse().unwrap();
    let casimirs = entry.casimirs::<T, N>().unwrap();
    let casimirs = casimirs.iter().map(|casimir| casimir.in_basis(&skew).unwrap()).collect();
    WithCasimirs { algebra: LieAlgebra::from_catalogue(&entry).unwrap().in_basis(&skew).unwrap(), casimirs }
}

#[test]
fn the_laws_hold_on_the_algebras_of_the_catalogue() {
    for name in ["so3", "se2", "heisenberg", "sl2", "r3"] {
        let report = clean(name, both(name), 150);
        assert!(switched_off(&report).is_empty(), "{name}: {:?}", switched_off(&report));
        clean(name, UserAlgebra::at_both(validated::<f64, 3>(name), validated::<Dd, 3>(name)), 100);
    }
    for name in ["se3", "so4", "so3+heisenberg"] {
        clean(name, UserAlgebra::at_both(validated::<f64, 6>(name), validated::<Dd, 6>(name)), 60);
    }
    let without = || UserAlgebra::in_double(constants::<f64>("so3").casimirs(Vec::new()));
    assert_eq!(switched_off(&clean("so3 in f64", without(), 150)), ["algebra-casimirs"]);
}

#[test]
fn every_fault_is_seen() {
    assert_eq!(missed(both("so3"), 40), BTreeSet::from([]));
    assert_eq!(missed(both("sl2"), 40), BTreeSet::from([]));
    let se3 = UserAlgebra::at_both(validated::<f64, 6>("se3"), validated::<Dd, 6>("se3"));
    assert_eq!(missed(se3, 40), BTreeSet::from([]));
}

/// so(3) with mistakes in the table of constants.
fn wrong<T: Real>(kind: &str) -> Constants<T, 3> {
    let sign = |a: usize, b: usize, c: usize| (b as i64 - a as i64) * (c as i64 - b as i64) * (c as i64 - a as i64) / 2;
    let table = Constants::new(|a, b, c| match (kind, (a, b, c)) {
        // [e_3, e_1] = e_1.
        ("index", (2, 0, 1) | (0, 2, 1)) => T::zero(),
        ("index", (2, 0, 0)) => T::one(),
        ("index", (0, 2, 0)) => -T::one(),
        // [e_2, e_1] forgotten.
        ("half", (1, 0, 2)) => T::zero(),
        _ => T::int(sign(a, b, c)),
    });
    let casimir = if kind == "casimir" { [1, 1, 2] } else { [1, 1, 1] };
    table.casimirs(vec![Casimir::Quadratic(Matrix::from_diagonal(&Vector::<T, 3>::from_fn(|a, _| T::int(casimir[a]))))])
}

#[test]
fn mistakes_by_hand_are_named() {
    let found = |kind| {
        let found = broken(|| UserAlgebra::at_both(wrong::<f64>(kind), wrong::<Dd>(kind)), 60);
        found.iter().for_each(|(law, case)| assert!(!case.to_string().contains('/'), "{law}: {case}"));
        names(&found)
    };
    assert!(found("nothing").is_empty());
    assert_eq!(found("index"), ["algebra-jacobi", "algebra-ad", "algebra-casimirs"]);
    assert_eq!(found("half"), ["algebra-antisymmetric", "algebra-jacobi", "algebra-ad", "algebra-casimirs"]);
    assert_eq!(found("casimir"), ["algebra-casimirs"]);
}
