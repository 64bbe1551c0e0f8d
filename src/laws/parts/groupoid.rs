//! The groupoid g*×G×g* of a described system, as a part: the group elements of its chains are those of the case.

use super::super::instances::Material;
use super::super::probe::{Probe, stream};
use super::super::user::groupoid::{self, GroupoidLaws, LieChains, LieGroupoidLaws};
use super::super::user::part::{Answer, Answers, Asked, Kind, Part};
use super::Described;
use crate::groupoid::{DenseSpace, TrivialGroupoid};
use crate::scalar::{Dd, Real, Scalar};
use crate::system::Case;
use crate::system::dispatch::Main;
use nalgebra::DVector;

/// g*×G×g*, with three elements of G.
struct Poisson<T: Real>(Material<T>);

impl<T: Real> Answers<T, GroupoidLaws> for Poisson<T> {
    fn length(&self) -> usize {
        self.numbers()
    }

    fn answer(&self, asked: &Asked<'_, GroupoidLaws>) -> Answer {
        groupoid::judge_coordinates(self, asked)
    }
}

impl<T: Real> LieChains<T> for Poisson<T> {
    type At<'a, S: Scalar<Base = T> + 'a>
        = TrivialGroupoid<DenseSpace, S>
    where
        Self: 'a;

    fn at<'a, S: Scalar<Base = T> + 'a>(&'a self) -> Self::At<'a, S> {
        TrivialGroupoid::poisson(self.0.group.clone())
    }

    /// Four points of g*: the ends of a chain.
    fn numbers(&self) -> usize {
        4 * self.0.group.dimension()
    }

    fn chain(&self, numbers: &[T]) -> Option<[DVector<T>; 3]> {
        let n = self.0.group.dimension();
        let end = |k: usize| &numbers[k * n..(k + 1) * n];
        let arrow = |k: usize| [end(k), self.0.elements[k].as_slice(), end(k + 1)].concat();
        Some(std::array::from_fn(|k| DVector::from_vec(arrow(k))))
    }

    /// What the group elements amplify rounding by.
    fn size(&self, _: &[DVector<T>; 3]) -> T {
        self.0.elements[..3].iter().fold(T::one(), |size, u| size * self.0.size_of(u))
    }
}

/// That of a system; `None` where it has no group, or a group element is outside the domain of its retraction.
fn part<K: Kind>(case: &Case, double: &Main<f64>, quad: &Main<Dd>) -> Option<Part<K>>
where
    Poisson<f64>: Answers<f64, K>,
    Poisson<Dd>: Answers<Dd, K>,
{
    let probe = || Probe::new(case, stream::GROUPOID_OF_SYSTEM);
    let (double, quad) = (Material::of(double, &mut probe()).ok()?, Material::of(quad, &mut probe()).ok()?);
    Some(Part::at_both(Poisson(double), Poisson(quad)))
}

impl Described for GroupoidLaws {
    fn part(case: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>> {
        part(case, &double, &quad)
    }
}

impl Described for LieGroupoidLaws {
    /// Fields and brackets: `algebroid`.
    const ELSEWHERE: usize = 5;

    fn part(case: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>> {
        part(case, &double, &quad)
    }
}
