//! Algebras of a user's own. On random systems the campaign judges the same laws, and their faults.

use super::{broken, clean, names, switched_off};
use euler_poincare::algebra::{Casimir, Matrix, Vector};
use euler_poincare::laws::user::algebra::{Constants, UserAlgebra};
use euler_poincare::scalar::{Dd, Real};

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
    let without = UserAlgebra::in_double(wrong::<f64>("nothing").casimirs(Vec::new()));
    assert_eq!(switched_off(&clean("so3 in f64", without, 150)), ["algebra-casimirs"]);
    assert_eq!(found("index"), ["algebra-jacobi", "algebra-ad", "algebra-casimirs"]);
    assert_eq!(found("half"), ["algebra-antisymmetric", "algebra-jacobi", "algebra-ad", "algebra-casimirs"]);
    assert_eq!(found("casimir"), ["algebra-casimirs"]);
}
