//! Drawing a case: a pure function of the campaign's seed, the law's name and the index.

use super::guard::guarded;
use proptest::strategy::{BoxedStrategy, Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::collections::BTreeMap;
use std::fmt::Debug;

/// How many values a strategy may reject before the case is given up.
const REJECTIONS: u32 = 10_000;

/// The seed of one case, the same on every machine, in every version and at any number of threads.
///
/// FNV-1a (64 bits) over the seed (8 bytes, little-endian), the bytes of the name, 0xff (which no UTF-8 text contains),
/// and the index (8 bytes, little-endian); then four outputs of SplitMix64 started there, little-endian.
/// Sources: Fowler, Noll and Vo (FNV-1a); Steele, Lea and Flood 2014 (SplitMix64).
pub fn case_seed(seed: u64, law: &str, index: usize) -> [u8; 32] {
    let name = law.bytes().chain([0xff]);
    let mut state = hash(seed.to_le_bytes().into_iter().chain(name).chain((index as u64).to_le_bytes()));
    let mut bytes = [0; 32];
    for chunk in bytes.chunks_exact_mut(8) {
        chunk.copy_from_slice(&split_mix(&mut state).to_le_bytes());
    }
    bytes
}

/// FNV-1a of 64 bits.
pub(crate) fn hash(bytes: impl Iterator<Item = u8>) -> u64 {
    let start = 0xcbf2_9ce4_8422_2325_u64;
    bytes.fold(start, |state, byte| (state ^ u64::from(byte)).wrapping_mul(0x0000_0100_0000_01b3))
}

/// The next output of SplitMix64.
pub(crate) fn split_mix(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = *state;
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// A value with the tree that shrinks it.
pub type Tree<C> = Box<dyn ValueTree<Value = C>>;

/// A case with its shrinking tree, and what the strategy rejected on the way.
pub struct Drawn<C> {
    /// The case and its tree; the reason where the strategy could not produce one.
    pub case: Result<(C, Tree<C>), String>,
    /// How many values the strategy rejected, by reason.
    pub rejections: BTreeMap<String, usize>,
}

/// Case `index` of the law called `law`, from its strategy.
pub fn draw<C: Debug>(strategy: &BoxedStrategy<C>, seed: u64, law: &str, index: usize) -> Drawn<C> {
    // Nothing here may depend on the environment, from which proptest's default configuration is read.
    let config = Config {
        max_local_rejects: REJECTIONS,
        max_flat_map_regens: 1_000_000,
        failure_persistence: None,
        ..Config::default()
    };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &case_seed(seed, law, index));
    let mut runner = TestRunner::new_with_rng(config, rng);
    let case = match guarded(|| strategy.new_tree(&mut runner).map(|tree| (tree.current(), tree))) {
        Ok(Ok(case)) => Ok(case),
        Ok(Err(reason)) => Err(format!("the strategy gave no case: {reason}")),
        Err(panic) => Err(format!("the strategy panicked: {panic}")),
    };
    Drawn { case, rejections: rejections(&runner) }
}

/// The rejections that a runner has counted. It gives them out in its `Display` only, a line `N times at REASON` each.
fn rejections(runner: &TestRunner) -> BTreeMap<String, usize> {
    let text = runner.to_string();
    let lines = text.lines().skip_while(|line| !line.trim().starts_with("local rejects:")).skip(1);
    let lines = lines.take_while(|line| !line.trim().starts_with("global rejects:"));
    let mut counts = BTreeMap::new();
    for (count, reason) in lines.filter_map(|line| line.trim().split_once(" times at ")) {
        if let Ok(count) = count.parse::<usize>() {
            *counts.entry(reason.to_owned()).or_default() += count;
        }
    }
    counts
}
