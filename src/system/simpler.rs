//! Simpler cases than a given one, of those that a strategy draws: how a saved case is shrunk without the tree that drew it.

use super::case::Case;
use super::random::Cases;
use super::rates::{MOST, Rates};
use super::shrink::candidates;
use crate::tableau::Description;
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// The same draws each time; a filter may refuse a few.
fn fixed_runner() -> TestRunner {
    let config = Config { max_local_rejects: 4, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]))
}

/// Draws that are looked at to see which tableaux a strategy has.
const DRAWS: usize = 256;

/// How simple a tableau is: fewer stages, a name, a shorter text.
fn size(tableau: &Description) -> (usize, bool, usize, String) {
    let text = tableau.to_string();
    (tableau.stages(), matches!(tableau, Description::Entries(_)), text.len(), text)
}

impl Cases {
    /// Simpler tableaux than `tableau` that are drawn often enough to be seen, the simplest first.
    pub(super) fn simpler_tableaux(&self, tableau: &Description) -> Vec<Description> {
        let mut runner = fixed_runner();
        let mut found = Vec::new();
        for draw in 0..DRAWS {
            let Ok(mut tree) = self.tableaux.new_tree(&mut runner) else { break };
            found.push(tree.current());
            // The simplest of all is where every tree ends.
            if draw < 4 {
                while tree.simplify() {}
                found.push(tree.current());
            }
        }
        let own = size(tableau);
        let mut found: Vec<_> = found.into_iter().map(|tableau| (size(&tableau), tableau)).collect();
        found.retain(|(size, _)| *size < own);
        found.sort_by(|(one, _), (two, _)| one.cmp(two));
        found.dedup_by(|(one, _), (two, _)| one == two);
        found.into_iter().map(|(_, tableau)| tableau).take(24).collect()
    }

    /// Whether the knobs admit a candidate, it can be built, and its step is small enough.
    pub(super) fn allows(&self, case: &Case) -> bool {
        let Ok(step) = case.step.eval::<f64>() else { return false };
        let calm = |rates: Rates| rates.in_domain() && rates.step_stiffness(step.abs()) <= MOST;
        self.admits(case) && step != 0.0 && self.rates(case).is_some_and(calm)
    }

    /// Cases that are simpler than `case` and that could have been drawn, the boldest first: a pure function of both, however `case` was
    /// drawn. Each can be built, and its step is small enough for its motion.
    pub fn simpler(&self, case: &Case) -> impl Iterator<Item = Case> + use<> {
        let tableaux = self.simpler_tableaux(&case.method.tableau);
        let exchanged = tableaux.into_iter().map({
            let case = case.clone();
            move |tableau| {
                let mut case = case.clone();
                case.method.tableau = tableau;
                case
            }
        });
        let finest = 1 << self.exponents.1;
        let (knobs, image, own) = (self.clone(), self.image.clone(), case.clone());
        exchanged
            .chain(candidates(case, finest))
            .filter(move |case| knobs.allows(case))
            .map(move |case| image.of(case))
            .filter(move |case| *case != own)
    }
}
