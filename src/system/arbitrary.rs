//! The same random cases for proptest, quickcheck and rand. A random part is that of a random case: `cases().prop_map(|case| case.algebra)`.
//!
//! One generator stands behind all: [`Cases`]. quickcheck and rand give it a seed, so that a case has the same distribution in all
//! three, and shrinks to the same.

use super::case::{Algebra, Case, Dictionary, Lagrangian, Method, Motion, Start, Structure, Tau};
use super::random::{Cases, cases};
use crate::algebra::catalogue::Entry;
use crate::scalar::Number;
use crate::tableau::{Description, Family};
use proptest::strategy::{Strategy, ValueTree};
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

    fn shrink(&self) -> Box<dyn Iterator<Item = Self>> {
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
    Case {
        algebra: Algebra { structure: Structure::Named(Entry::Abelian(n)), basis: None },
        lagrangian: Lagrangian::unit(n),
        potentials: Vec::new(),
        forces: Vec::new(),
        names: Dictionary::default(),
        method: Method {
            tableau: Description::Family(Family::Gauss, 1),
            retraction: Tau::Exponential,
            argument: Vec::new(),
        },
        start: Start::moving(Motion::Momentum(vec![Number::from(0); n])),
        step: Number::ratio(1, 64),
    }
}
