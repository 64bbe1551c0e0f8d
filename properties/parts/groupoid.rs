//! Groupoids.

use super::{broken, clean, missed, names};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::group::MatrixGroup;
use euler_poincare::groupoid::{
    ActionGroupoid, AtiyahGroupoid, Coadjoint, DenseGroup, DenseSpace, Group, Groupoid, LieGroupoid, Manifold,
    ManifoldPair, PairGroupoid, SphereFrames, TrivialGroupoid,
};
use euler_poincare::laws::user::groupoid::{Chains, LieChains, UserGroupoid, UserLieGroupoid};
use euler_poincare::retraction::{CayleySo3, Retraction};
use euler_poincare::scalar::{Dd, Real, Scalar};
use nalgebra::{DMatrix, DVector, SVector};
use std::collections::BTreeSet;
use std::marker::PhantomData;

/// SE(2), three numbers to an element: 1 + x̂/2 over 1 − x̂/2, by its series is enough of a group element for a groupoid.
fn se2<T: Real>() -> DenseGroup<T> {
    DenseGroup::of(&MatrixGroup::<T, 3, 3>::from_entry(&Entry::Se2).unwrap())
}

/// A unipotent or rotated element: Cayley's map.
fn element<T: Real>(group: &DenseGroup<T>, x: &[T]) -> Option<DMatrix<T>> {
    let half = Group::<T>::hat(group, &DVector::from_column_slice(x)) * T::half();
    let one = DMatrix::identity(3, 3);
    Some((&one + &half) * (one - half).try_inverse()?)
}

fn flat<T: Real>(m: &DMatrix<T>) -> DVector<T> {
    DVector::from_column_slice(m.as_slice())
}

fn joined<T: Real>(parts: &[&DVector<T>]) -> DVector<T> {
    DVector::from_iterator(parts.iter().map(|p| p.len()).sum(), parts.iter().flat_map(|p| p.iter().copied()))
}

/// |U| |U⁻¹| of each element, at most about 2⁵ for x of at most 1.
fn size<T: Real>() -> T {
    T::int(1 << 10)
}

/// Groupoids of SE(2): G×G×G, G×G and g*⋊G. On g*×G×g* of random groups the laws of these names are in `verify`.
struct Over<T: Real> {
    group: DenseGroup<T>,
}

impl<T: Real> Over<T> {
    fn new() -> Self {
        Self { group: se2() }
    }

    fn elements(&self, numbers: &[T], count: usize) -> Option<Vec<DMatrix<T>>> {
        (0..count).map(|k| element(&self.group, &numbers[3 * k..3 * k + 3])).collect()
    }
}

macro_rules! over_se2 {
    ($name:ident, $at:ty, $make:expr, $numbers:literal, $chain:expr) => {
        struct $name<T: Real>(Over<T>);

        impl<T: Real> LieChains<T> for $name<T> {
            type At<'a, S: Scalar<Base = T> + 'a>
                = $at
            where
                Self: 'a;

            fn at<'a, S: Scalar<Base = T> + 'a>(&'a self) -> Self::At<'a, S> {
                let make: fn(&DenseGroup<T>) -> $at = $make;
                make(&self.0.group)
            }

            fn numbers(&self) -> usize {
                $numbers
            }

            fn chain(&self, numbers: &[T]) -> Option<[DVector<T>; 3]> {
                let chain: fn(&Over<T>, &[T]) -> Option<[DVector<T>; 3]> = $chain;
                chain(&self.0, numbers)
            }

            fn size(&self, _: &[DVector<T>; 3]) -> T {
                size()
            }
        }
    };
}

over_se2!(
    Gauge,
    TrivialGroupoid<DenseGroup<T>, DenseGroup<T>, S>,
    |group| TrivialGroupoid::over(group.clone(), group.clone()),
    21,
    |over, x| {
        let e: Vec<_> = over.elements(x, 7)?.iter().map(flat).collect();
        Some([0, 1, 2].map(|k| joined(&[&e[k], &e[k + 4], &e[k + 1]])))
    }
);
over_se2!(Pairs, ManifoldPair<DenseGroup<T>, S>, |group| ManifoldPair::new(group.clone()), 12, |over, x| {
    let e: Vec<_> = over.elements(x, 4)?.iter().map(flat).collect();
    Some([0, 1, 2].map(|k| joined(&[&e[k], &e[k + 1]])))
});
over_se2!(
    Coadjoints,
    ActionGroupoid<Coadjoint<DenseGroup<T>>, S>,
    |group| ActionGroupoid::new(Coadjoint::new(group.clone(), 3)),
    12,
    |over, x| acted(ActionGroupoid::<_, T>::new(Coadjoint::new(over.group.clone(), 3)), over, x)
);

fn acted<T: Real, A>(q: ActionGroupoid<A, T>, over: &Over<T>, x: &[T]) -> Option<[DVector<T>; 3]>
where
    A: euler_poincare::groupoid::Action<T, Group = DenseGroup<T>, Space = DenseSpace>,
{
    let u = over.elements(x, 3)?;
    let one = q.arrow(&DVector::from_column_slice(&x[9..12]), &u[0])?;
    let two = q.arrow(&one.target, &u[1])?;
    let three = q.arrow(&two.target, &u[2])?;
    Some([&one, &two, &three].map(|g| q.coordinates(g)))
}

/// (SO(3)×SO(3))/SO(2) over the sphere.
struct Frames<T>(PhantomData<T>);

impl<T: Real> LieChains<T> for Frames<T> {
    type At<'a, S: Scalar<Base = T> + 'a>
        = AtiyahGroupoid<SphereFrames, S>
    where
        Self: 'a;

    fn at<'a, S: Scalar<Base = T> + 'a>(&'a self) -> Self::At<'a, S> {
        AtiyahGroupoid::new(SphereFrames)
    }

    fn numbers(&self) -> usize {
        12
    }

    fn chain(&self, numbers: &[T]) -> Option<[DVector<T>; 3]> {
        let turn = |k: usize| CayleySo3::<T>::new().tau(&SVector::from_column_slice(&numbers[3 * k..3 * k + 3])).ok();
        let (q, p) = (AtiyahGroupoid::<_, T>::new(SphereFrames), [turn(0)?, turn(1)?, turn(2)?, turn(3)?]);
        Some([0, 1, 2].map(|k| q.coordinates(&(p[k], p[k + 1]))))
    }
}

macro_rules! both {
    ($name:ident) => {
        UserLieGroupoid::at_both($name(Over::<f64>::new()), $name(Over::<Dd>::new())).within(1.0)
    };
}

#[test]
fn the_laws_hold_on_the_lie_groupoids_of_the_library() {
    clean("G×G×G", both!(Gauge), 40);
    clean("G×G", both!(Pairs), 40);
    clean("g*⋊G", both!(Coadjoints), 40);
    clean("sphere", UserLieGroupoid::at_both(Frames::<f64>(PhantomData), Frames::<Dd>(PhantomData)).within(1.0), 40);
}

#[test]
fn every_fault_in_a_lie_groupoid_is_seen() {
    assert_eq!(missed(both!(Gauge), 20), BTreeSet::new());
}

/// Pairs of numbers, with mistakes.
#[derive(Clone, Copy, Debug)]
struct Intervals<T>(&'static str, PhantomData<T>);

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
        (g.1 - h.1).abs()
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

/// The pair groupoid of the plane over the plain numbers, behind a type of one's own.
struct Plane;

impl Groupoid for Plane {
    type Element = ([f64; 2], [f64; 2]);
    type Base = [f64; 2];

    fn source(&self, g: &Self::Element) -> [f64; 2] {
        PairGroupoid::new().source(g)
    }

    fn target(&self, g: &Self::Element) -> [f64; 2] {
        PairGroupoid::new().target(g)
    }

    fn unit(&self, x: &[f64; 2]) -> Self::Element {
        PairGroupoid::new().unit(x)
    }

    fn inverse(&self, g: &Self::Element) -> Option<Self::Element> {
        PairGroupoid::new().inverse(g)
    }

    fn product(&self, g: &Self::Element, h: &Self::Element) -> Self::Element {
        PairGroupoid::new().product(g, h)
    }
}

impl Chains for Plane {
    type Real = f64;

    fn numbers(&self) -> usize {
        8
    }

    fn chain(&self, x: &[f64]) -> Option<[Self::Element; 3]> {
        Some([0, 2, 4].map(|k| ([x[k], x[k + 1]], [x[k + 2], x[k + 3]])))
    }

    fn distance(&self, _: &Self::Element, _: &Self::Element) -> f64 {
        0.0
    }
}

#[test]
fn the_laws_hold_on_the_pair_groupoid() {
    clean("pairs", UserGroupoid::in_double(Plane), 200);
    let blind = missed(UserGroupoid::in_double(Plane), 40);
    // A distance that is always 0 sees ends alone.
    assert!(blind.iter().all(|(_, fault)| *fault != "ends-swapped" && *fault != "never-refuses"), "{blind:?}");
}

/// A Lie groupoid on G×G with a derivative lost: `frame` is evaluated on values; or whose first coordinate is not a number.
struct Lost<T: Real>(Over<T>, T);

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
        = ManifoldPair<Constant<'a, T>, S>
    where
        Self: 'a;

    fn at<'a, S: Scalar<Base = T> + 'a>(&'a self) -> Self::At<'a, S> {
        ManifoldPair::new(Constant(&self.0.group, self.1))
    }

    fn numbers(&self) -> usize {
        12
    }

    fn chain(&self, numbers: &[T]) -> Option<[DVector<T>; 3]> {
        Pairs(Over { group: self.0.group.clone() }).chain(numbers)
    }
}

#[test]
fn a_lost_derivative_is_named() {
    let found = names(&broken(|| UserLieGroupoid::in_double(Lost(Over::<f64>::new(), 0.0)).within(1.0), 20));
    assert!(found.contains(&"algebroid-bracket"), "{found:?}");
    assert!(!found.contains(&"lie-groupoid-axioms"));
}

/// A NaN is no small defect, wherever it stands.
#[test]
fn a_coordinate_that_is_no_number_is_seen() {
    let found = names(&broken(|| UserLieGroupoid::in_double(Lost(Over::<f64>::new(), f64::NAN)).within(1.0), 20));
    assert!(found.contains(&"lie-groupoid-coordinates") && found.contains(&"lie-groupoid-axioms"), "{found:?}");
}
