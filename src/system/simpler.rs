//! Simpler cases than a given one, of those that a strategy draws: how a saved case is shrunk without the tree that drew it.

use super::case::Case;
use super::random::Cases;
use super::shrink::{candidates, sound};
use crate::tableau::Description;
use proptest::strategy::{BoxedStrategy, Strategy, ValueTree};
use proptest::test_runner::{Config, Reason, RngAlgorithm, TestRng, TestRunner};
use std::cell::RefCell;

/// What a strategy is asked instead of for a random case.
enum Question {
    /// For the knobs that it is made of; here they are.
    Knobs(Option<Box<Cases>>),
    /// For what it makes of this case.
    Case(Box<Case>),
}

thread_local! {
    static ASKED: RefCell<Option<Question>> = const { RefCell::new(None) };
}

/// The answer of `knobs` where somebody asks; `None` where nobody does.
pub(super) fn answer(knobs: &Cases) -> Option<Result<Case, Reason>> {
    ASKED.with_borrow_mut(|question| match question {
        None => None,
        Some(Question::Knobs(found)) => {
            *found = Some(Box::new(knobs.clone()));
            Some(Err("asked for the knobs".into()))
        }
        Some(Question::Case(case)) => Some(Ok((**case).clone())),
    })
}

/// What `strategy` makes of a question.
fn ask(strategy: &BoxedStrategy<Case>, question: Question) -> (Option<Question>, Option<Case>) {
    /// Takes the question back, also after a panic.
    struct Scope;
    impl Drop for Scope {
        fn drop(&mut self) {
            ASKED.set(None);
        }
    }
    let _scope = Scope;
    ASKED.set(Some(question));
    let mut runner = fixed_runner();
    let tree = strategy.new_tree(&mut runner);
    (ASKED.take(), tree.ok().map(|tree| tree.current()))
}

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

    /// Cases that are simpler than `case` and that the knobs admit, the boldest first: a pure function of both, whoever drew the
    /// case. Each can be built, its inertia is positive definite and its step is small enough for its motion.
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
        let knobs = self.clone();
        exchanged
            .chain(candidates(case, finest))
            .filter(move |case| knobs.admits(case) && sound(case, |case| knobs.rates(case)))
    }
}

/// Tells `visit` the cases simpler than `case` that `strategy` could have drawn, the boldest first, until it answers `true`.
///
/// The strategy is [`Cases`], as it is or boxed, filtered or mapped: of a mapped strategy the images are told. Nothing is told
/// of a strategy that is made of something else.
pub fn simpler(strategy: &BoxedStrategy<Case>, case: &Case, visit: &mut dyn FnMut(Case) -> bool) {
    let (Some(Question::Knobs(Some(knobs))), _) = ask(strategy, Question::Knobs(None)) else { return };
    for candidate in knobs.simpler(case) {
        if let (_, Some(image)) = ask(strategy, Question::Case(Box::new(candidate)))
            && image != *case
            && visit(image)
        {
            return;
        }
    }
}

/// Whether `strategy` could have drawn `case`, its tableau apart.
pub fn admits(strategy: &BoxedStrategy<Case>, case: &Case) -> bool {
    match ask(strategy, Question::Knobs(None)) {
        (Some(Question::Knobs(Some(knobs))), _) => {
            knobs.admits(case) && ask(strategy, Question::Case(Box::new(case.clone()))).1.as_ref() == Some(case)
        }
        _ => false,
    }
}
