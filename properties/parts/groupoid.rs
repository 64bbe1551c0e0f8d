//! Groupoids of a user's own. On the groupoids of random systems the campaign judges the same laws, and their faults.

use super::{broken, clean, missed, names};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::group::MatrixGroup;
use euler_poincare::groupoid::{DenseGroup, Groupoid, Manifold, TrivialGroupoid};
use euler_poincare::laws::user::groupoid::{Chains, LieChains, UserGroupoid, UserLieGroupoid};
use euler_poincare::scalar::{Dd, Real, Scalar};
use nalgebra::{DMatrix, DVector};
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

/// SE(2), three numbers to an element.
fn se2<T: Real>() -> DenseGroup<T> {
    DenseGroup::of(&MatrixGroup::<T, 3, 3>::from_entry(&Entry::Se2).unwrap())
}

/// A Lie groupoid on G×G with a derivative lost: `frame` is evaluated on values; or whose first coordinate is not a number.
struct Lost<T: Real>(DenseGroup<T>, T);

struct Constant<'a, T: Real>(&'a DenseGroup<T>, T);

impl<T: Real, S: Scalar<Base = T>> Manifold<S> for Constant<'_, T> {
    type Point = DMatrix<S>;

    fn dimension(&self) -> usize {
        Manifold::<S>::dimension(self.0)
    }

    fn size(&self) -> usize {
        Manifold::<S>::size(self.0)
    }

    fn coordinates(&self, x: &DMatrix<S>) -> DVector<S> {
        let mut coordinates = self.0.coordinates(x);
        coordinates[0] += S::lift(self.1);
        coordinates
    }

    fn point(&self, z: &DVector<S>) -> DMatrix<S> {
        self.0.point(z)
    }

    fn frame(&self, x: &DVector<S>, v: &DVector<S>) -> DVector<S> {
        self.0.frame(&x.map(|x| S::lift(x.base())), v)
    }

    fn velocity(&self, x: &DVector<S>, tangent: &DVector<S>) -> Option<DVector<S>> {
        self.0.velocity(x, tangent)
    }

    fn structure(&self, v: &DVector<S>, w: &DVector<S>) -> DVector<S> {
        Manifold::<S>::structure(self.0, v, w)
    }
}

impl<T: Real> LieChains<T> for Lost<T> {
    type At<'a, S: Scalar<Base = T> + 'a>
        = TrivialGroupoid<Constant<'a, T>, S>
    where
        Self: 'a;

    fn at<'a, S: Scalar<Base = T> + 'a>(&'a self) -> Self::At<'a, S> {
        TrivialGroupoid::pairs(Constant(&self.0, self.1))
    }

    fn numbers(&self) -> usize {
        12
    }

    fn chain(&self, numbers: &[T]) -> Option<[DVector<T>; 3]> {
        // Cayley's map.
        let element = |k: usize| {
            let half = self.0.hat(&DVector::from_column_slice(&numbers[3 * k..3 * k + 3])) * T::half();
            let one = DMatrix::identity(3, 3);
            Some((&one + &half) * (one - half).try_inverse()?)
        };
        let e = [element(0)?, element(1)?, element(2)?, element(3)?];
        let pair = |k: usize| e[k].iter().chain(&e[k + 1]).copied().collect();
        Some([0, 1, 2].map(|k| DVector::from_vec(pair(k))))
    }
}

#[test]
fn a_lost_derivative_is_named() {
    let found = names(&broken(|| UserLieGroupoid::in_double(Lost(se2::<f64>(), 0.0)).within(1.0), 20));
    assert!(found.contains(&"algebroid-bracket"), "{found:?}");
    assert!(!found.contains(&"lie-groupoid-axioms"));
}

/// A NaN is no small defect, wherever it stands.
#[test]
fn a_coordinate_that_is_no_number_is_seen() {
    let found = names(&broken(|| UserLieGroupoid::in_double(Lost(se2::<f64>(), f64::NAN)).within(1.0), 20));
    assert!(found.contains(&"lie-groupoid-coordinates") && found.contains(&"lie-groupoid-axioms"), "{found:?}");
}
