//! The groupoid g*×G×g* of a described system, as a part: the group elements of its chains are those of the case.

use super::super::instances::Material;
use super::super::probe::{Probe, stream};
use super::super::user::groupoid::{self, GroupoidLaws, LieChains, LieGroupoidLaws};
use super::super::user::part::{Answer, Answers, Asked, Part};
use super::super::user::values::Points;
use super::Described;
use crate::groupoid::{Arrow, DenseSpace, LieGroupoid, TrivialGroupoid};
use crate::harness::About;
use crate::scalar::{Dd, Real, Scalar, max_abs};
use crate::system::dispatch::{Main, System};
use crate::system::{Case, Cases};
use nalgebra::{DMatrix, DVector};

/// g*×G×g*, with three elements of G.
struct Poisson<T: Real>(Material<T>);

type Element<T> = Arrow<DVector<T>, DMatrix<T>>;

/// The groupoid over S.
type Over<S> = TrivialGroupoid<DenseSpace, S>;

impl<T: Real> Poisson<T> {
    /// That of a system; `None` where it has no group, or a group element is outside the domain of its retraction.
    fn of<const N: usize, const D: usize>(case: &Case, system: &System<T, N, D>) -> Option<Self> {
        Material::draw(system.group.as_ref()?, &system.retraction, &mut Probe::new(case, stream::GROUPOID_OF_SYSTEM))
            .ok()
            .map(Self)
    }

    fn over<S: Scalar<Base = T>>(&self) -> Over<S> {
        TrivialGroupoid::poisson(self.0.group.clone())
    }

    /// Four points of g*: the ends of a chain.
    fn ends(&self) -> usize {
        4 * self.0.group.dimension()
    }

    fn arrows(&self, numbers: &[T]) -> [Element<T>; 3] {
        let n = self.0.group.dimension();
        let end = |k: usize| DVector::from_column_slice(&numbers[k * n..(k + 1) * n]);
        std::array::from_fn(|k| Arrow { source: end(k), group: self.0.elements[k].clone(), target: end(k + 1) })
    }

    /// What the group elements amplify rounding by.
    fn amplification(&self) -> T {
        self.0.elements[..3].iter().fold(T::one(), |size, u| size * self.0.size_of(u))
    }
}

impl<T: Real> Answers<T, GroupoidLaws> for Poisson<T> {
    fn points(&self, _: &str, points: Points) -> Points {
        points.vectors(&["chain"], self.ends())
    }

    fn answer(&self, asked: &Asked<'_, GroupoidLaws>) -> Answer {
        let numbers = asked.case.list("chain", self.ends())?;
        let ends = |a: &DVector<T>, b: &DVector<T>| max_abs(&(a - b));
        let distance = |g: &Element<T>, h: &Element<T>| {
            ends(&g.source, &h.source).max(max_abs(&(&g.group - &h.group))).max(ends(&g.target, &h.target))
        };
        let chain = (&self.arrows(&numbers), numbers.len());
        groupoid::judge(&self.over::<T>(), chain, distance, self.amplification(), asked)
    }
}

impl<T: Real> LieChains<T> for Poisson<T> {
    type At<'a, S: Scalar<Base = T> + 'a>
        = Over<S>
    where
        Self: 'a;

    fn at<'a, S: Scalar<Base = T> + 'a>(&'a self) -> Over<S> {
        self.over()
    }

    fn numbers(&self) -> usize {
        self.ends()
    }

    fn chain(&self, numbers: &[T]) -> Option<[DVector<T>; 3]> {
        Some(self.arrows(numbers).map(|g| self.over::<T>().coordinates(&g)))
    }

    fn size(&self, _: &[DVector<T>; 3]) -> T {
        self.amplification()
    }
}

fn with_group(cases: Cases) -> Cases {
    cases.main_dimensions().with_group()
}

impl Described for GroupoidLaws {
    fn part(case: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>> {
        Some(Part::at_both(Poisson::of(case, &double)?, Poisson::of(case, &quad)?))
    }

    fn cases(_: &About, cases: Cases) -> Cases {
        with_group(cases)
    }
}

impl Described for LieGroupoidLaws {
    /// Fields and brackets: `algebroid`.
    const ELSEWHERE: usize = 5;

    fn part(case: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>> {
        Some(Part::at_both(Poisson::of(case, &double)?, Poisson::of(case, &quad)?))
    }

    fn cases(_: &About, cases: Cases) -> Cases {
        with_group(cases)
    }
}
