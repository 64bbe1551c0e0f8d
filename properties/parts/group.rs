//! Groups.

use super::{broken, clean, missed, names, switched_off};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{LieAlgebra, Matrix, Vector};
use euler_poincare::group::{LieGroup, MatrixGroup, So3};
use euler_poincare::laws::user::group::UserGroup;
use euler_poincare::laws::user::part::Precisions;
use euler_poincare::scalar::{Dd, Real, Scalar};
use std::collections::BTreeSet;

fn entry<T: Real, const N: usize, const D: usize>(name: &str) -> MatrixGroup<T, N, D> {
    MatrixGroup::from_entry(&name.parse::<Entry>().unwrap()).unwrap()
}

/// The same group in a basis that is not orthogonal: a lower triangle of quarters.
fn skewed<T: Real, const N: usize, const D: usize>(name: &str) -> MatrixGroup<T, N, D> {
    let basis = Matrix::<T, N>::from_fn(|r, c| match r.cmp(&c) {
        std::cmp::Ordering::Less => T::zero(),
        std::cmp::Ordering::Equal => T::one(),
        std::cmp::Ordering::Greater => T::ratio(1 + ((r + 2 * c) % 3) as i64, 4),
    });
    entry(name).in_basis(&basis).unwrap()
}

fn both<const N: usize, const D: usize>(name: &str) -> UserGroup<N, D> {
    UserGroup::at_both(entry::<f64, N, D>(name), entry::<Dd, N, D>(name))
}

fn both_skewed<const N: usize, const D: usize>(name: &str) -> UserGroup<N, D> {
    UserGroup::at_both(skewed::<f64, N, D>(name), skewed::<Dd, N, D>(name))
}

// N = 3, D = 4 and N = 6, D = 8 are compiled in the library, for the laws of these names on described systems.

#[test]
fn the_laws_hold_on_the_groups_of_the_catalogue() {
    let so3 = UserGroup::at_both(So3::<f64>::new(), So3::<Dd>::new());
    assert_eq!(so3.precisions(), Precisions::Both);
    let report = clean("So3", so3, 200);
    assert!(switched_off(&report).is_empty());
    for name in ["se2", "heisenberg", "sl2", "aff1+r1"] {
        clean(name, both::<3, 4>(name), 40);
        clean(name, both_skewed::<3, 4>(name), 40);
    }
    for name in ["se3", "so4"] {
        clean(name, both::<6, 8>(name), 20);
        clean(name, both_skewed::<6, 8>(name), 20);
    }
}

#[test]
fn in_double_alone_too() {
    let so3 = UserGroup::in_double(So3::<f64>::new());
    assert!(so3.precisions().to_string().starts_with("f64 alone"));
    clean("So3 in f64", so3, 200);
}

#[test]
fn every_fault_is_seen() {
    let none = BTreeSet::new();
    assert_eq!(missed(both::<3, 4>("sl2"), 30), none);
    assert_eq!(missed(both_skewed::<6, 8>("se3"), 30), none);
    // On SO(3) the transpose is the inverse, of Ad as well.
    let so3 = UserGroup::at_both(So3::<f64>::new(), So3::<Dd>::new());
    assert_eq!(
        missed(so3, 30),
        BTreeSet::from([
            ("group-adjoint-automorphism", "adjoint-transposed"),
            ("group-derivatives", "inverse-transposed"),
            ("group-inverse", "inverse-transposed"),
        ])
    );
}

/// What can be wrong in a hand-written SE(2): x = (angle, two translations), [e_1, e_2] = e_3, [e_1, e_3] = −e_2.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Wrong {
    Nothing,
    /// A translation in the other place.
    HatIndex,
    /// gᵀ, as for rotations.
    Transpose,
    /// Ad by rows.
    AdTransposed,
    /// Ad without the translation.
    AdRotates,
    /// [e_1, e_2] = −e_3.
    ConstantSign,
    /// NaN for half a turn.
    Nan,
    /// A constant of seven digits.
    SevenDigits,
}

struct Plane<T: Real> {
    algebra: LieAlgebra<T, 3>,
    wrong: Wrong,
}

impl<T: Real> Plane<T> {
    fn new(wrong: Wrong) -> Self {
        let sign = if wrong == Wrong::ConstantSign { -1 } else { 1 };
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
        let turn = if self.wrong == Wrong::SevenDigits { x[0] * S::exact(0.9999999) } else { x[0] };
        let (one, two) = if self.wrong == Wrong::HatIndex { (2, 1) } else { (1, 2) };
        Matrix::<S, 3>::new(zero, -turn, x[one], turn, zero, x[two], zero, zero, zero)
    }

    fn vee<S: Scalar<Base = T>>(&self, m: &Matrix<S, 3>) -> Vector<S, 3> {
        Vector::<S, 3>::new((m[(1, 0)] - m[(0, 1)]) * S::half(), m[(0, 2)], m[(1, 2)])
    }

    fn inverse<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Option<Matrix<S, 3>> {
        if self.wrong == Wrong::Transpose {
            return Some(g.transpose());
        }
        if self.wrong == Wrong::Nan && g[(0, 0)].base() < -T::ratio(1, 2) {
            return Some(g * S::exact(f64::NAN));
        }
        let (r, p) = (g.fixed_view::<2, 2>(0, 0).transpose(), g.fixed_view::<2, 1>(0, 2));
        let back = -(r * p);
        let (zero, one) = (S::zero(), S::one());
        Some(Matrix::<S, 3>::new(r[(0, 0)], r[(0, 1)], back[0], r[(1, 0)], r[(1, 1)], back[1], zero, zero, one))
    }

    fn adjoint<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Option<Matrix<S, 3>> {
        let (zero, one) = (S::zero(), S::one());
        let (x, y) = if self.wrong == Wrong::AdRotates { (zero, zero) } else { (g[(0, 2)], g[(1, 2)]) };
        let ad = Matrix::<S, 3>::new(one, zero, zero, y, g[(0, 0)], g[(0, 1)], -x, g[(1, 0)], g[(1, 1)]);
        Some(if self.wrong == Wrong::AdTransposed { ad.transpose() } else { ad })
    }
}

#[test]
fn mistakes_by_hand_are_named() {
    let plane = |wrong| move || UserGroup::at_both(Plane::<f64>::new(wrong), Plane::<Dd>::new(wrong));
    clean("SE(2) by hand", plane(Wrong::Nothing)(), 200);
    let found = |wrong| names(&broken(plane(wrong), 60));
    assert!(found(Wrong::HatIndex).starts_with(&["group-vee-hat", "group-bracket"]), "{:?}", found(Wrong::HatIndex));
    assert_eq!(found(Wrong::Transpose), ["group-inverse", "group-derivatives"]);
    let ad = ["group-adjoint", "group-adjoint-product", "group-adjoint-automorphism", "group-adjoint-exponential"];
    assert!(found(Wrong::AdTransposed).starts_with(&ad), "{:?}", found(Wrong::AdTransposed));
    assert!(found(Wrong::AdRotates).contains(&"group-adjoint"), "{:?}", found(Wrong::AdRotates));
    assert!(!found(Wrong::AdRotates).contains(&"group-adjoint-product"), "a homomorphism all the same");
    assert!(found(Wrong::ConstantSign).starts_with(&["group-bracket"]), "{:?}", found(Wrong::ConstantSign));
    // Four cases in a hundred turn by more than a third.
    assert_eq!(names(&broken(plane(Wrong::Nan), 300)), ["group-inverse", "group-derivatives"]);
    assert!(found(Wrong::SevenDigits).starts_with(&["group-vee-hat"]), "{:?}", found(Wrong::SevenDigits));
    // The counterexamples can be followed by hand.
    for (law, case) in broken(plane(Wrong::HatIndex), 60) {
        let text = case.to_string();
        assert!(!text.contains('/') && !text.contains("pi"), "{law}: {text}");
    }
}

/// The mistakes are seen in f64 alone as well.
#[test]
fn mistakes_are_named_in_double_alone() {
    for wrong in [Wrong::HatIndex, Wrong::Transpose, Wrong::AdTransposed, Wrong::ConstantSign, Wrong::SevenDigits] {
        assert!(!broken(|| UserGroup::in_double(Plane::<f64>::new(wrong)), 60).is_empty(), "{wrong:?}");
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
