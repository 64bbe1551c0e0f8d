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
        if let Some(answer) = super::simpler::answer(self) {
            return answer.map(|case| CaseTree::fixed(self.clone(), case));
        }
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
    /// A case as it is: its tableau does not move.
    fn fixed(knobs: Cases, case: Case) -> Self {
        let tableau: Box<dyn ValueTree<Value = Description>> = Box::new(Still(case.method.tableau.clone()));
        let best = case.clone();
        Self { knobs, best, current: case, tableau, tableau_done: true, candidates: Vec::new().into_iter() }
    }

    fn with_tableau(&self) -> Case {
        let mut case = self.best.clone();
        case.method.tableau = self.tableau.current();
        case
    }

    /// The next candidate, or back to the best case.
    fn next(&mut self) -> bool {
        for candidate in self.candidates.by_ref() {
            if self.knobs.admits(&candidate) && shrink::sound(&candidate, |case| self.knobs.rates(case)) {
                self.current = candidate;
                return true;
            }
        }
        self.current = self.best.clone();
        false
    }

    fn restart(&mut self) -> bool {
        self.tableau_done = true;
        self.candidates = shrink::candidates(&self.best, 1 << self.knobs.exponents.1).into_iter();
        self.next()
    }
}

impl ValueTree for CaseTree {
    type Value = Case;

    fn current(&self) -> Case {
        self.current.clone()
    }

    fn simplify(&mut self) -> bool {
        self.best = self.current.clone();
        if !self.tableau_done && self.tableau.simplify() {
            self.current = self.with_tableau();
            return true;
        }
        self.restart()
    }

    fn complicate(&mut self) -> bool {
        if self.tableau_done {
            return self.next();
        }
        if self.tableau.complicate() {
            self.current = self.with_tableau();
            return true;
        }
        self.restart()
    }
}

/// A tableau that does not shrink.
struct Still(Description);

impl ValueTree for Still {
    type Value = Description;

    fn current(&self) -> Description {
        self.0.clone()
    }

    fn simplify(&mut self) -> bool {
        false
    }

    fn complicate(&mut self) -> bool {
        false
    }
}
