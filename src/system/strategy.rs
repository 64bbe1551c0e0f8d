//! [`Cases`] as a proptest strategy: how a case is drawn and shrunk.

use super::case::Case;
use super::generate::{self, Draw};
use super::random::Cases;
use super::shrink;
use crate::tableau::Description;
use proptest::strategy::{NewTree, Strategy, ValueTree};
use proptest::test_runner::TestRunner;

/// How many draws are tried before the knobs are declared to exclude everything.
const ATTEMPTS: usize = 1000;

impl Strategy for Cases {
    type Tree = CaseTree;
    type Value = Case;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let tableau = self.tableaux.new_tree(runner)?;
        for _ in 0..ATTEMPTS {
            let drawn = generate::case(&mut Draw(runner.rng()), self, tableau.current());
            if let Some(case) = drawn.filter(|case| self.admits(case)) {
                return Ok(CaseTree {
                    knobs: self.clone(),
                    best: case.clone(),
                    current: case,
                    tableau,
                    tableau_done: false,
                    candidates: Vec::new().into_iter(),
                });
            }
        }
        Err("the knobs exclude every case".into())
    }
}

/// A case and the way to simpler ones: first its tableau, by the tree of its strategy; then everything else, by
/// candidates that depend on the case alone.
#[doc(hidden)]
pub struct CaseTree {
    knobs: Cases,
    best: Case,
    current: Case,
    tableau: Box<dyn ValueTree<Value = Description>>,
    tableau_done: bool,
    candidates: std::vec::IntoIter<Case>,
}

impl CaseTree {
    /// The best case with the tableau of the tree, if that has moved; else everything but the tableau is next.
    fn with_tableau(&mut self, moved: bool) -> bool {
        if !moved {
            self.tableau_done = true;
            self.candidates = shrink::candidates(&self.best, 1 << self.knobs.exponents.1).into_iter();
            return self.next();
        }
        self.current = self.best.clone();
        self.current.method.tableau = self.tableau.current();
        true
    }

    /// The next candidate, or back to the best case.
    fn next(&mut self) -> bool {
        let found = self.candidates.find(|candidate| self.knobs.allows(candidate));
        let is_simpler = found.is_some();
        self.current = found.unwrap_or_else(|| self.best.clone());
        is_simpler
    }
}

impl ValueTree for CaseTree {
    type Value = Case;

    fn current(&self) -> Case {
        self.knobs.image.of(self.current.clone())
    }

    fn simplify(&mut self) -> bool {
        self.best = self.current.clone();
        let moved = !self.tableau_done && self.tableau.simplify();
        self.with_tableau(moved)
    }

    fn complicate(&mut self) -> bool {
        if self.tableau_done {
            return self.next();
        }
        let moved = self.tableau.complicate();
        self.with_tableau(moved)
    }
}
