//! The same random cases for proptest, quickcheck and rand, and random parts of them.
//!
//! One generator stands behind all: [`Cases`]. quickcheck and rand give it a seed, so that a case has the same distribution in all
//! three, and shrinks to the same.

use super::case::{Algebra, Case, Dictionary, Inertia, Lagrangian, Method, Motion, Start, Structure, Tau};
use super::random::{Cases, cases};
use super::shrink;
use crate::algebra::catalogue::Entry;
use crate::scalar::Number;
use crate::tableau::{Description, Family};
use proptest::strategy::{BoxedStrategy, Strategy, ValueTree};
use proptest::test_runner::{Config, Reason, RngAlgorithm, TestRng, TestRunner};
use quickcheck::Gen;
use rand::Rng;
use rand::distr::{Distribution, StandardUniform};

/// What `strategy` draws from this seed.
fn seeded<S: Strategy>(strategy: &S, seed: &[u8; 32]) -> Result<S::Value, Reason> {
    // Nothing here may depend on the environment, from which proptest's default configuration is read.
    let config = Config { failure_persistence: None, ..Config::default() };
    let mut runner = TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, seed));
    Ok(strategy.new_tree(&mut runner)?.current())
}

/// The seed that a generator of random bits gives.
fn seed<R: Rng + ?Sized>(rng: &mut R) -> [u8; 32] {
    let mut seed = [0; 32];
    rng.fill_bytes(&mut seed);
    seed
}

/// The seed that quickcheck's generator gives. A tenth of its integers are special ones (0, the greatest, …): two of them for
/// each eight bytes, one multiplied by an odd constant, so that hardly any seed comes twice.
fn quick_seed(g: &mut Gen) -> [u8; 32] {
    let mut seed = [0; 32];
    for chunk in seed.chunks_exact_mut(8) {
        let (one, two) = (<u64 as quickcheck::Arbitrary>::arbitrary(g), <u64 as quickcheck::Arbitrary>::arbitrary(g));
        chunk.copy_from_slice(&(one ^ two.wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(32)).to_le_bytes());
    }
    seed
}

/// What shrinks in quickcheck: a list, the boldest first.
type Shrunk<T> = Box<dyn Iterator<Item = T>>;

impl Cases {
    /// A case from random bits.
    ///
    /// # Errors
    /// Where no case with what the knobs ask for was found.
    pub fn try_sample<R: Rng + ?Sized>(&self, rng: &mut R) -> Result<Case, Reason> {
        seeded(self, &seed(rng))
    }
}

/// The cases of the strategy, with the same distribution.
///
/// # Panics
/// Where the knobs contradict each other, so that there is no case; [`Cases::try_sample`] says so instead.
impl Distribution<Case> for Cases {
    fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> Case {
        match self.try_sample(rng) {
            Ok(case) => case,
            Err(reason) => panic!("no case to sample: {reason}"),
        }
    }
}

impl Distribution<Case> for StandardUniform {
    fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> Case {
        cases().sample(rng)
    }
}

/// Any case of [`cases`]; shrinks to simpler ones.
impl quickcheck::Arbitrary for Case {
    fn arbitrary(g: &mut Gen) -> Self {
        seeded(&cases(), &quick_seed(g)).unwrap_or_else(|_| plain(1))
    }

    fn shrink(&self) -> Shrunk<Self> {
        Box::new(cases().simpler(self))
    }
}

/// Any case of [`cases`], or of those that the parameter draws.
impl proptest::arbitrary::Arbitrary for Case {
    type Parameters = Cases;
    type Strategy = Cases;

    fn arbitrary_with(cases: Cases) -> Cases {
        cases
    }
}

/// A case of which nothing but the dimension is chosen: ℝⁿ at rest.
pub(super) fn plain(n: usize) -> Case {
    let ones = |value: i64| vec![Number::from(value); n];
    Case {
        algebra: Algebra { structure: Structure::Named(Entry::Abelian(n)), basis: None },
        lagrangian: Lagrangian::new(Inertia::Diagonal(ones(1))),
        potentials: Vec::new(),
        forces: Vec::new(),
        names: Dictionary::default(),
        method: Method {
            tableau: Description::Family(Family::Gauss, 1),
            retraction: Tau::Exponential,
            argument: Vec::new(),
        },
        start: Start::moving(Motion::Momentum(ones(0))),
        step: Number::ratio(1, 64),
    }
}

/// The parts of cases, in proptest, quickcheck and rand: the part, how it is taken, and what is simpler.
macro_rules! parts {
    ($($part:ty: $take:expr, $simpler:expr;)*) => {$(
        /// The part of any case of [`cases`], or of those that the parameter draws.
        impl proptest::arbitrary::Arbitrary for $part {
            type Parameters = Cases;
            type Strategy = BoxedStrategy<Self>;

            fn arbitrary_with(cases: Cases) -> Self::Strategy {
                cases.prop_map($take).boxed()
            }
        }

        impl Distribution<$part> for StandardUniform {
            fn sample<R: Rng + ?Sized>(&self, rng: &mut R) -> $part {
                let take: fn(Case) -> $part = $take;
                take(cases().sample(rng))
            }
        }

        /// The part of any case of [`cases`].
        impl quickcheck::Arbitrary for $part {
            fn arbitrary(g: &mut Gen) -> Self {
                let take: fn(Case) -> $part = $take;
                take(<Case as quickcheck::Arbitrary>::arbitrary(g))
            }

            fn shrink(&self) -> Shrunk<Self> {
                let simpler: fn(&$part) -> Vec<$part> = $simpler;
                Box::new(simpler(self).into_iter())
            }
        }
    )*};
}

parts! {
    Algebra: |case| case.algebra, |algebra| {
        let case = Case { algebra: algebra.clone(), ..plain(algebra.dimension()) };
        simpler(&case, |case| case.algebra)
    };
    Lagrangian: |case| case.lagrangian, |lagrangian| {
        let case = Case { lagrangian: lagrangian.clone(), ..plain(lagrangian.dimension()) };
        let fits = simpler(&case, |case| case.lagrangian);
        fits.into_iter().filter(|simpler| simpler.dimension() == lagrangian.dimension()).collect()
    };
    Description: |case| case.method.tableau, |tableau| cases().simpler_tableaux(tableau);
}

/// What the simpler cases have in place of one part.
fn simpler<T: PartialEq>(case: &Case, take: fn(Case) -> T) -> Vec<T> {
    let own = take(case.clone());
    let mut found: Vec<T> = Vec::new();
    for part in
        shrink::candidates(case, 64).into_iter().filter(|case| shrink::sound(case, super::rates::Rates::of)).map(take)
    {
        if part != own && !found.contains(&part) {
            found.push(part);
        }
    }
    found
}
