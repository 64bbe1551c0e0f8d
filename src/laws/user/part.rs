//! A part that a user brings, at two precisions or in `f64` alone, and the laws on it.

use super::super::precision::{self, Measured};
use super::values::Values;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::harness::{About, Campaign, CampaignReport, Fault, Law, Verdict};
use crate::scalar::{Dd, Real};
use proptest::strategy::BoxedStrategy;
use std::fmt;
use std::sync::Arc;

/// The scalars in which a part is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Precisions {
    /// `f64` and 32 digits: the amplification of rounding in one bounds that in the other.
    Both,
    /// `f64` alone: the count of operations is the bound.
    Double,
}

impl fmt::Display for Precisions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Both => "f64 and 32 digits",
            Self::Double => "f64 alone, because the part was given in f64 alone",
        })
    }
}

/// A part under test: a user's group, algebra, Lagrangian, force, groupoid or discrete Lagrangian.
pub trait Subject: Send + Sync + 'static {
    /// Every law on parts of this kind.
    const LAWS: &'static [About];

    /// The scalars in which it is judged.
    fn precisions(&self) -> Precisions;

    /// Why a law is switched off: what the part does not supply.
    fn missing(&self, law: &About) -> Option<&'static str> {
        let _ = law;
        None
    }

    /// The strategy that draws cases for a law.
    fn cases(&self, law: &About) -> BoxedStrategy<Values>;

    /// The verdict of a law on one case, with a fault planted in the part if there is one.
    fn check(&self, law: &About, case: &Values, fault: Option<&Fault>) -> Verdict;
}

/// A law on one part: a [`Law`] of [`Values`], so that campaigns run it and failures shrink.
///
/// A law that is switched off ([`Subject::missing`]) is not applicable to any case.
pub struct PartLaw<S> {
    /// What it says.
    pub about: &'static About,
    /// The part.
    pub subject: Arc<S>,
}

/// Every law on a part, those that are switched off among them.
pub fn laws<S: Subject>(subject: S) -> Vec<PartLaw<S>> {
    let subject = Arc::new(subject);
    S::LAWS.iter().map(|about| PartLaw { about, subject: Arc::clone(&subject) }).collect()
}

/// The law called `name` on a part; `None` if there is no such law on parts of its kind.
pub fn law<S: Subject>(subject: S, name: &str) -> Option<PartLaw<S>> {
    let about = S::LAWS.iter().find(|about| about.name == name)?;
    Some(PartLaw { about, subject: Arc::new(subject) })
}

/// A campaign of every law on a part: `cases` cases for each cheap law (see [`Cost::cases`](crate::harness::Cost::cases)).
pub fn run<S: Subject>(subject: S, seed: u64, cases: usize) -> CampaignReport<Values> {
    let laws = laws(subject);
    let laws: Vec<&dyn Law<Values>> = laws.iter().map(|law| law as &dyn Law<Values>).collect();
    Campaign::new(seed, cases).labels(&Values::labels).run(&laws)
}

impl<S: Subject> Law<Values> for PartLaw<S> {
    fn about(&self) -> &About {
        self.about
    }

    fn cases(&self) -> BoxedStrategy<Values> {
        self.subject.cases(self.about)
    }

    fn check(&self, case: &Values, fault: Option<&Fault>) -> Verdict {
        match self.subject.missing(self.about) {
            Some(why) => Verdict::not_applicable(why),
            None => self.subject.check(self.about, case, fault),
        }
    }
}

/// The same part in `f64` and, if it is generic in the scalar, in 32 digits.
#[derive(Clone, Debug)]
pub(super) struct Pair<A, B> {
    pub double: A,
    pub quad: Option<B>,
}

impl<A, B> Pair<A, B> {
    pub fn precisions(&self) -> Precisions {
        if self.quad.is_some() { Precisions::Both } else { Precisions::Double }
    }

    /// The verdict from one measurement, or from two.
    pub fn settle(
        &self,
        case: &Values,
        double: impl FnOnce(&A) -> Result<Measured, Measured>,
        quad: impl Fn(&B, &Values) -> Result<Measured, Measured>,
    ) -> Verdict {
        let first = double(&self.double).unwrap_or_else(|refused| refused);
        let Some(part) = &self.quad else { return precision::alone(16, first) };
        let second = |case: &Values| quad(part, case).unwrap_or_else(|refused| refused);
        precision::compare_near(first, second(case), |sample| second(&case.moved(sample)))
    }

    /// The graver of the verdicts in each scalar: for measurements that are not in units of round-off.
    pub fn each(
        &self,
        double: impl FnOnce(&A) -> Result<Measured, Measured>,
        quad: impl FnOnce(&B) -> Result<Measured, Measured>,
    ) -> Verdict {
        let first = precision::alone(16, double(&self.double).unwrap_or_else(|refused| refused));
        match &self.quad {
            Some(part) => first.and(precision::alone(32, quad(part).unwrap_or_else(|refused| refused))),
            None => first,
        }
    }
}

/// Stands for the part in 32 digits where there is none. It has no values.
#[derive(Clone, Copy, Debug)]
pub enum Missing {}

impl<const N: usize, const D: usize> crate::group::LieGroup<Dd, N, D> for Missing {
    fn algebra(&self) -> &LieAlgebra<Dd, N> {
        match *self {}
    }

    fn hat<S: crate::scalar::Scalar<Base = Dd>>(&self, _: &Vector<S, N>) -> Matrix<S, D> {
        match *self {}
    }

    fn vee<S: crate::scalar::Scalar<Base = Dd>>(&self, _: &Matrix<S, D>) -> Vector<S, N> {
        match *self {}
    }

    fn inverse<S: crate::scalar::Scalar<Base = Dd>>(&self, _: &Matrix<S, D>) -> Option<Matrix<S, D>> {
        match *self {}
    }
}

impl<const N: usize> crate::mechanics::Lagrangian<Dd, N> for Missing {
    fn value<S: crate::scalar::Scalar<Base = Dd>>(&self, _: &Vector<S, N>) -> S {
        match *self {}
    }
}

impl<const N: usize> crate::mechanics::Force<Dd, N> for Missing {
    fn force<S: crate::scalar::Scalar<Base = Dd>>(&self, _: S, _: &Vector<S, N>) -> Covector<S, N> {
        match *self {}
    }
}

/// lhs − rhs of vectors or matrices of one shape.
pub(super) fn off<T: Real, R: nalgebra::Dim, C: nalgebra::Dim, A, B>(
    a: &nalgebra::Matrix<T, R, C, A>,
    b: &nalgebra::Matrix<T, R, C, B>,
) -> T
where
    A: nalgebra::RawStorage<T, R, C>,
    B: nalgebra::RawStorage<T, R, C>,
{
    let mut size = T::zero();
    for (x, y) in a.iter().zip(b.iter()) {
        let distance = (*x - *y).abs();
        if !distance.all_finite() {
            return T::exact(f64::INFINITY);
        }
        size = size.max(distance);
    }
    size
}
