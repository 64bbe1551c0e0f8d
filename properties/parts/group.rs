//! Groups of a user's own, and SO(3) in closed form. On the matrix groups of random systems the campaign judges the same laws.

use super::{broken, clean, missed, names, switched_off};
use euler_poincare::algebra::{LieAlgebra, Matrix, Vector};
use euler_poincare::group::{LieGroup, So3};
use euler_poincare::laws::user::group::UserGroup;
use euler_poincare::scalar::{Dd, Real, Scalar};
use std::collections::BTreeSet;

#[test]
fn the_laws_hold_on_rotations_in_closed_form() {
    let both = || UserGroup::at_both(So3::<f64>::new(), So3::<Dd>::new());
    assert!(switched_off(&clean("So3", both(), 200)).is_empty());
    clean("So3 in f64", UserGroup::in_double(So3::<f64>::new()), 200);
    // The transpose is the inverse, of Ad as well.
    let unseen = [
        ("group-adjoint-automorphism", "adjoint-transposed"),
        ("group-derivatives", "inverse-transposed"),
        ("group-inverse", "inverse-transposed"),
    ];
    assert_eq!(missed(both(), 30), BTreeSet::from(unseen));
}

/// A hand-written SE(2), with mistakes: x = (angle, two translations), [e_1, e_2] = e_3, [e_1, e_3] = −e_2.
struct Plane<T: Real> {
    algebra: LieAlgebra<T, 3>,
    wrong: &'static str,
}

impl<T: Real> Plane<T> {
    fn new(wrong: &'static str) -> Self {
        let sign = if wrong == "sign of a constant" { -1 } else { 1 };
        let algebra = LieAlgebra::new(|a, b, c| match (a, b, c) {
            (0, 1, 2) => T::int(sign),
            (1, 0, 2) => T::int(-sign),
            (0, 2, 1) => T::int(-sign),
            (2, 0, 1) => T::int(sign),
            _ => T::zero(),
        });
        Self { algebra: algebra.unwrap(), wrong }
    }
}

impl<T: Real> LieGroup<T, 3, 3> for Plane<T> {
    fn algebra(&self) -> &LieAlgebra<T, 3> {
        &self.algebra
    }

    fn hat<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Matrix<S, 3> {
        let zero = S::zero();
        let turn = if self.wrong == "seven digits" { x[0] * S::exact(0.9999999) } else { x[0] };
        // A translation in the other place.
        let (one, two) = if self.wrong == "index of hat" { (2, 1) } else { (1, 2) };
        Matrix::<S, 3>::new(zero, -turn, x[one], turn, zero, x[two], zero, zero, zero)
    }

    fn vee<S: Scalar<Base = T>>(&self, m: &Matrix<S, 3>) -> Vector<S, 3> {
        Vector::<S, 3>::new((m[(1, 0)] - m[(0, 1)]) * S::half(), m[(0, 2)], m[(1, 2)])
    }

    fn inverse<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Option<Matrix<S, 3>> {
        // As for rotations.
        if self.wrong == "transpose" {
            return Some(g.transpose());
        }
        if self.wrong == "nan" && g[(0, 0)].base() < -T::ratio(1, 2) {
            return Some(g * S::exact(f64::NAN));
        }
        let (r, p) = (g.fixed_view::<2, 2>(0, 0).transpose(), g.fixed_view::<2, 1>(0, 2));
        let back = -(r * p);
        let (zero, one) = (S::zero(), S::one());
        Some(Matrix::<S, 3>::new(r[(0, 0)], r[(0, 1)], back[0], r[(1, 0)], r[(1, 1)], back[1], zero, zero, one))
    }

    fn adjoint<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Option<Matrix<S, 3>> {
        let (zero, one) = (S::zero(), S::one());
        let (x, y) = if self.wrong == "Ad without the translation" { (zero, zero) } else { (g[(0, 2)], g[(1, 2)]) };
        let ad = Matrix::<S, 3>::new(one, zero, zero, y, g[(0, 0)], g[(0, 1)], -x, g[(1, 0)], g[(1, 1)]);
        Some(if self.wrong == "Ad by rows" { ad.transpose() } else { ad })
    }
}

#[test]
fn mistakes_by_hand_are_named() {
    let plane = |wrong| move || UserGroup::at_both(Plane::<f64>::new(wrong), Plane::<Dd>::new(wrong));
    clean("SE(2) by hand", plane("nothing")(), 200);
    let found = |wrong| names(&broken(plane(wrong), 60));
    // In f64 alone as well.
    let seen = |wrong| !broken(|| UserGroup::in_double(Plane::<f64>::new(wrong)), 60).is_empty();
    let ad = ["group-adjoint", "group-adjoint-product", "group-adjoint-automorphism", "group-adjoint-exponential"];
    for (wrong, first) in [
        ("index of hat", &["group-vee-hat", "group-bracket"][..]),
        ("Ad by rows", &ad),
        ("sign of a constant", &["group-bracket"]),
        ("seven digits", &["group-vee-hat"]),
    ] {
        assert!(found(wrong).starts_with(first) && seen(wrong), "{wrong}: {:?}", found(wrong));
    }
    assert_eq!(found("transpose"), ["group-inverse", "group-derivatives"]);
    assert!(seen("transpose"));
    let rotates = found("Ad without the translation");
    assert!(rotates.contains(&"group-adjoint"), "{rotates:?}");
    assert!(!rotates.contains(&"group-adjoint-product"), "a homomorphism all the same");
    // Four cases in a hundred turn by more than a third.
    assert_eq!(names(&broken(plane("nan"), 300)), ["group-inverse", "group-derivatives"]);
    // The counterexamples can be followed by hand.
    for (law, case) in broken(plane("index of hat"), 60) {
        let text = case.to_string();
        assert!(!text.contains('/') && !text.contains("pi"), "{law}: {text}");
    }
}

/// A case of another part is refused in words, not by a panic.
#[test]
fn a_case_that_does_not_fit_is_broken() {
    use euler_poincare::harness::verdict_on;
    use euler_poincare::laws::user::{part, values::Values};
    let law = part::law(UserGroup::in_double(So3::<f64>::new()), "group-vee-hat").unwrap();
    for (text, why) in
        [("{}", "no vector `x`"), (r#"{"x":[1,2]}"#, "has 2 numbers, expected 3"), (r#"{"x":[1,2,"1/0"]}"#, "zero")]
    {
        let case: Values = serde_json::from_str(text).unwrap();
        let verdict = verdict_on(&law, &case, None);
        assert!(verdict.is_broken() && verdict.to_string().contains(why), "{verdict}");
    }
    assert!(serde_json::from_str::<Values>(r#"{"x":[1],"x":[2]}"#).is_err());
    assert!(part::law(UserGroup::in_double(So3::<f64>::new()), "group-nothing").is_none());
}
