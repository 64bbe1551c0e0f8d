//! Groupoids of a user's own. On the groupoids of random systems the campaign judges the same laws, and their faults.

use super::{broken, clean, missed, names};
use euler_poincare::groupoid::{Groupoid, Manifold, TrivialGroupoid};
use euler_poincare::laws::user::groupoid::{Chains, LieChains, UserGroupoid, UserLieGroupoid};
use euler_poincare::scalar::{Dd, Real, Scalar};
use nalgebra::DVector;
use std::collections::BTreeSet;
use std::marker::PhantomData;

/// Pairs of numbers, with mistakes.
#[derive(Clone, Copy, Debug)]
pub struct Intervals<T>(pub &'static str, pub PhantomData<T>);

type Interval<T> = (T, T, T);

/// (x, length, y): the length adds up.
impl<T: Real> Groupoid for Intervals<T> {
    type Element = Interval<T>;
    type Base = T;

    fn source(&self, g: &Interval<T>) -> T {
        if self.0 == "swapped" { g.2 } else { g.0 }
    }

    fn target(&self, g: &Interval<T>) -> T {
        if self.0 == "swapped" { g.0 } else { g.2 }
    }

    fn unit(&self, x: &T) -> Interval<T> {
        (*x, if self.0 == "unit" { T::one() } else { T::zero() }, *x)
    }

    fn inverse(&self, g: &Interval<T>) -> Option<Interval<T>> {
        match self.0 {
            "inverse" => Some((g.2, g.1, g.0)),
            "ends" => Some((g.0, -g.1, g.2)),
            "none" if g.1 > T::one() => None,
            _ => Some((g.2, -g.1, g.0)),
        }
    }

    fn product(&self, g: &Interval<T>, h: &Interval<T>) -> Interval<T> {
        match self.0 {
            "product" => (g.0, g.1 + h.1 + g.1 * h.1 * h.1, h.2),
            "digits" => (g.0, g.1 + h.1 * T::exact(1.0 + 1e-9), h.2),
            _ => (g.0, g.1 + h.1, h.2),
        }
    }
}

impl<T: Real> Chains for Intervals<T> {
    type Real = T;

    fn numbers(&self) -> usize {
        7
    }

    fn chain(&self, x: &[T]) -> Option<[Interval<T>; 3]> {
        Some([(x[0], x[4], x[1]), (x[1], x[5], x[2]), (x[2], x[6], x[3])])
    }

    fn distance(&self, g: &Interval<T>, h: &Interval<T>) -> T {
        if self.0 == "blind" { T::zero() } else { (g.1 - h.1).abs() }
    }

    fn size(&self, chain: &[Interval<T>; 3]) -> T {
        chain.iter().fold(T::zero(), |sum, g| sum + g.1.abs())
    }
}

#[test]
fn mistakes_by_hand_are_named() {
    let own = |mistake| {
        move || UserGroupoid::at_both(Intervals::<f64>(mistake, PhantomData), Intervals::<Dd>(mistake, PhantomData))
    };
    clean("intervals", own("nothing")(), 200);
    assert_eq!(missed(own("nothing")(), 40), BTreeSet::new());
    let found = |mistake| names(&broken(own(mistake), 100));
    assert!(found("swapped").starts_with(&["groupoid-chain", "groupoid-product-ends"]), "{:?}", found("swapped"));
    assert_eq!(found("inverse"), ["groupoid-left-inverse", "groupoid-right-inverse"]);
    assert!(found("ends").starts_with(&["groupoid-inverse-ends"]));
    assert!(found("none").starts_with(&["groupoid-inverse-ends", "groupoid-left-inverse"]));
    assert!(found("unit").starts_with(&["groupoid-left-unit", "groupoid-right-unit"]));
    assert!(found("product").contains(&"groupoid-associativity"), "{:?}", found("product"));
    assert!(found("digits").contains(&"groupoid-associativity"), "{:?}", found("digits"));
    let alone = broken(|| UserGroupoid::in_double(Intervals::<f64>("digits", PhantomData)), 100);
    assert!(names(&alone).contains(&"groupoid-left-inverse") || names(&alone).contains(&"groupoid-associativity"));
}

#[test]
fn a_distance_that_is_always_0_sees_ends_alone() {
    let own = |mistake| UserGroupoid::in_double(Intervals::<f64>(mistake, PhantomData));
    clean("intervals in double precision", own("nothing"), 200);
    let blind = missed(own("blind"), 40);
    assert!(blind.iter().all(|(_, fault)| *fault != "ends-swapped" && *fault != "never-refuses"), "{blind:?}");
}

/// Pairs of points of the plane with the fields ∂_x + y ∂_y and ∂_y.
#[derive(Clone, Copy)]
pub struct Plane<T> {
    /// A mistake: `frame` is evaluated on values.
    pub lost: bool,
    /// Another: it is added to each x.
    pub added: T,
}

impl<T: Real, S: Scalar<Base = T>> Manifold<S> for Plane<T> {
    type Point = DVector<S>;

    fn dimension(&self) -> usize {
        2
    }

    fn size(&self) -> usize {
        2
    }

    fn coordinates(&self, x: &DVector<S>) -> DVector<S> {
        DVector::from_vec(vec![x[0] + S::lift(self.added), x[1]])
    }

    fn point(&self, z: &DVector<S>) -> DVector<S> {
        z.clone()
    }

    fn frame(&self, x: &DVector<S>, v: &DVector<S>) -> DVector<S> {
        let y = if self.lost { S::lift(x[1].base()) } else { x[1] };
        DVector::from_vec(vec![v[0], v[0] * y + v[1]])
    }

    fn velocity(&self, x: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        Some(DVector::from_vec(vec![tangent[0], tangent[1] - tangent[0] * x[1]]))
    }

    fn structure(&self, v: &DVector<S>, w: &DVector<S>) -> DVector<S> {
        DVector::from_vec(vec![S::zero(), v[1] * w[0] - v[0] * w[1]])
    }
}

impl<T: Real> LieChains<T> for Plane<T> {
    type At<'a, S: Scalar<Base = T> + 'a> = TrivialGroupoid<Self, S>;

    fn at<'a, S: Scalar<Base = T> + 'a>(&'a self) -> Self::At<'a, S> {
        TrivialGroupoid::pairs(*self)
    }

    fn numbers(&self) -> usize {
        8
    }

    fn chain(&self, x: &[T]) -> Option<[DVector<T>; 3]> {
        Some([0, 2, 4].map(|from| DVector::from_column_slice(&x[from..from + 4])))
    }
}

#[test]
fn a_lost_derivative_is_named() {
    let found = names(&broken(|| UserLieGroupoid::in_double(Plane { lost: true, added: 0.0 }).within(1.0), 20));
    assert!(found.contains(&"algebroid-bracket"), "{found:?}");
    assert!(!found.contains(&"lie-groupoid-axioms"));
}

/// A NaN is no small defect, wherever it stands.
#[test]
fn a_coordinate_that_is_no_number_is_seen() {
    let found = names(&broken(|| UserLieGroupoid::in_double(Plane { lost: true, added: f64::NAN }).within(1.0), 20));
    assert!(found.contains(&"lie-groupoid-coordinates") && found.contains(&"lie-groupoid-axioms"), "{found:?}");
}
