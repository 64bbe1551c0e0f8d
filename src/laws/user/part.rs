//! A part that a user brings, at two precisions or in `f64` alone, and the laws on it.

use super::super::precision::{self, Measured};
use super::values::{Points, Values, ValuesError};
use crate::harness::{About, Campaign, CampaignReport, Fault, Law, Verdict};
use crate::scalar::{Dd, Real, larger};
use proptest::strategy::{BoxedStrategy, Strategy};
use std::sync::Arc;

/// The laws on one kind of parts (groups, algebras, Lagrangians, forces, groupoids or discrete Lagrangians), with what is claimed of a
/// part.
pub trait Kind: Default + Send + Sync + 'static {
    /// Every law.
    const LAWS: &'static [About];

    /// The name of the test of each of them, and what a case holds: the names of vectors, and of numbers with a # behind.
    const FIELDS: &'static [(&'static str, &'static str)];

    /// The number of numbers in a vector of a case, if the part itself does not say otherwise.
    const DIMENSION: usize = 0;

    /// The largest number of a case, if [`Part::within`] does not say otherwise.
    const LARGEST: f64;

    /// The laws whose measurements are not in units of round-off: each precision is judged by itself.
    const APART: &'static [&'static str] = &[];

    /// Why a law is switched off: what is not claimed.
    fn missing(&self, law: &str) -> Option<&'static str> {
        let _ = law;
        None
    }
}

/// The laws on a kind of parts, a row each: the name of its test, what a case holds ([`Kind::FIELDS`]), what it says. `$tests` makes the
/// tests of a section.
macro_rules! part_laws {
    (
        $(#[$doc:meta])*
        $laws:ident $fields:ident $tests:ident;
        $($section:ident { $($name:ident $names:literal $about:expr;)* })*
    ) => {
        $(#[$doc])*
        pub static $laws: &[About] = &[$($(About {
            name: {
                const NAME: &[u8] = &super::part::dashed::<{ stringify!($name).len() }>(stringify!($name));
                match std::str::from_utf8(NAME) {
                    Ok(name) => name,
                    Err(_) => stringify!($name),
                }
            },
            ..$about
        },)*)*];

        const $fields: &[(&str, &str)] = &[$($((stringify!($name), $names),)*)*];

        #[doc(hidden)]
        #[macro_export]
        macro_rules! $tests {
            $(($attributes:tt $section) => { $crate::__own_tests! { $attributes $($name)* } };)*
            // Nothing is claimed of parts of most kinds.
            ($attributes:tt claimed) => {};
        }
    };
}
pub(super) use part_laws;

/// The name of a law from that of its test.
pub(super) const fn dashed<const LENGTH: usize>(test: &str) -> [u8; LENGTH] {
    let (mut name, mut k) = ([0; LENGTH], 0);
    while k < LENGTH {
        let byte = test.as_bytes()[k];
        name[k] = if byte == b'_' { b'-' } else { byte };
        k += 1;
    }
    name
}

/// What a part is asked: a law, on a case, with a fault planted in the part or none.
pub struct Asked<'a, K> {
    pub(in crate::laws) kind: &'a K,
    pub(in crate::laws) law: &'a About,
    pub(in crate::laws) case: &'a Values,
    pub(in crate::laws) fault: Option<&'a Fault>,
    /// The largest number that a case may have.
    pub(in crate::laws) largest: f64,
}

/// What was measured, or why nothing could be.
pub type Answer = Result<Measured, Measured>;

/// A case that does not fit: the part has changed since the case was saved.
impl From<ValuesError> for Measured {
    fn from(error: ValuesError) -> Self {
        Self::Broken(format!("the case does not fit the part: {error}"))
    }
}

impl<K> Asked<'_, K> {
    /// The answer to a law that is none of those on parts of this kind.
    pub(in crate::laws) fn unknown(&self, parts: &str) -> Answer {
        Err(Measured::Broken(format!("there is no law `{}` of {parts}", self.law.name)))
    }
}

/// A part over the scalar T, as the laws of K see it.
pub trait Answers<T: Real, K: Kind>: Send + Sync + 'static {
    /// The number of numbers in a vector of a case.
    fn length(&self) -> usize {
        K::DIMENSION
    }

    /// The answer to a law.
    fn answer(&self, asked: &Asked<'_, K>) -> Answer;
}

/// A part under test, in `f64` and, if it is generic in the scalar, in 32 digits.
pub struct Part<K: Kind> {
    pub(super) kind: K,
    largest: f64,
    double: Box<dyn Answers<f64, K>>,
    quad: Option<Box<dyn Answers<Dd, K>>>,
}

impl<K: Kind> Part<K> {
    /// The part in `f64` alone.
    pub fn in_double(double: impl Answers<f64, K>) -> Self {
        Self::of(Box::new(double), None)
    }

    /// The same part in `f64` and in 32 digits.
    pub fn at_both(double: impl Answers<f64, K>, quad: impl Answers<Dd, K>) -> Self {
        Self::of(Box::new(double), Some(Box::new(quad)))
    }

    pub(super) fn of(double: Box<dyn Answers<f64, K>>, quad: Option<Box<dyn Answers<Dd, K>>>) -> Self {
        Self { kind: K::default(), largest: K::LARGEST, double, quad }
    }

    /// Only numbers of at most `largest` in the cases: the domain of the part.
    pub fn within(self, largest: f64) -> Self {
        Self { largest, ..self }
    }

    /// The strategy that draws cases for a law.
    pub(in crate::laws) fn cases(&self, law: &About) -> BoxedStrategy<Values> {
        let of_law = K::FIELDS.iter().find(|(test, _)| test.replace('_', "-") == law.name);
        let (_, fields) = of_law.unwrap_or_else(|| panic!("`{}` is no law on such a part", law.name));
        let points =
            fields.split(' ').fold(Points::new().within(self.largest), |points, field| match field.strip_suffix('#') {
                Some(number) => points.number(number),
                None => points.vectors(&[field], self.double.length()),
            });
        points.boxed()
    }

    /// The verdict of a law on one case, with a fault planted in the part if there is one.
    pub(in crate::laws) fn check(&self, law: &About, case: &Values, fault: Option<&Fault>) -> Verdict {
        if let Some(why) = self.kind.missing(law.name) {
            return Verdict::not_applicable(why);
        }
        let asked = Asked { kind: &self.kind, law, case, fault, largest: self.largest };
        let measured = |answer: Answer| answer.unwrap_or_else(|refused| refused);
        let first = measured(self.double.answer(&asked));
        let Some(quad) = &self.quad else { return precision::alone(16, first) };
        let second = |case: &Values| measured(quad.answer(&Asked { case, ..asked }));
        if K::APART.contains(&law.name) {
            return precision::alone(16, first).and(precision::alone(32, second(case)));
        }
        precision::compare_near(first, second(case), |sample| second(&case.moved(sample)))
    }
}

/// A law on one part: a [`Law`] of [`Values`], so that campaigns run it and failures shrink.
///
/// A law that is switched off ([`Kind::missing`]) is not applicable to any case.
pub struct PartLaw<K: Kind> {
    /// What it says.
    pub about: &'static About,
    /// The part.
    pub part: Arc<Part<K>>,
}

/// Every law on a part, those that are switched off among them.
pub fn laws<K: Kind>(part: Part<K>) -> Vec<PartLaw<K>> {
    let part = Arc::new(part);
    K::LAWS.iter().map(|about| PartLaw { about, part: Arc::clone(&part) }).collect()
}

/// The law called `name` on a part; `None` if there is no such law on parts of its kind.
pub fn law<K: Kind>(part: Part<K>, name: &str) -> Option<PartLaw<K>> {
    laws(part).into_iter().find(|law| law.about.name == name)
}

/// A campaign of every law on a part: `cases` cases for each cheap law (see [`Cost::cases`](crate::harness::Cost::cases)).
pub fn run<K: Kind>(part: Part<K>, seed: u64, cases: usize) -> CampaignReport<Values> {
    let laws = laws(part);
    let laws: Vec<&dyn Law<Values>> = laws.iter().map(|law| law as &dyn Law<Values>).collect();
    Campaign::new(seed, cases).run(&laws)
}

impl<K: Kind> Law<Values> for PartLaw<K> {
    fn about(&self) -> &About {
        self.about
    }

    fn cases(&self) -> BoxedStrategy<Values> {
        self.part.cases(self.about)
    }

    fn check(&self, case: &Values, fault: Option<&Fault>) -> Verdict {
        self.part.check(self.about, case, fault)
    }
}

/// The largest component of lhs − rhs of vectors or matrices of one shape; not finite where one is not.
pub(super) fn off<'a, T: Real>(a: impl IntoIterator<Item = &'a T>, b: impl IntoIterator<Item = &'a T>) -> T {
    a.into_iter().zip(b).fold(T::zero(), |most, (x, y)| larger(most, (*x - *y).abs()))
}
