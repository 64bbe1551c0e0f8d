//! The simplest case on which a law still breaks.

use super::draw::draw;
use super::guard::{guarded, verdict_on};
use super::law::{Fault, Law, Verdict};
use std::collections::HashSet;
use std::fmt::Debug;

/// A case on which a law is broken, shrunk.
#[derive(Clone, Debug, PartialEq)]
pub struct Failure<C> {
    /// The campaign's seed. With the law's name and `index` it gives the case before shrinking.
    pub seed: u64,
    /// The index of the case in the campaign.
    pub index: usize,
    /// The simplest case found that is still broken.
    pub case: C,
    /// The verdict on it.
    pub verdict: Verdict,
    /// How many checks were spent on shrinking.
    pub checks: usize,
}

/// Case `index`, shrunk with at most `max_checks` further checks; `None` where the law is not broken on it.
///
/// Only values on which the law is still broken replace the best one, so the verdict always belongs to the case.
pub fn shrink<C: Debug>(
    law: &dyn Law<C>,
    fault: Option<&Fault>,
    seed: u64,
    index: usize,
    max_checks: usize,
) -> Option<Failure<C>> {
    shrink_while(law, fault, seed, index, max_checks, &|| true)
}

/// As [`shrink`], no further than `go_on` lets it.
pub(super) fn shrink_while<C: Debug>(
    law: &dyn Law<C>,
    fault: Option<&Fault>,
    seed: u64,
    index: usize,
    max_checks: usize,
    go_on: &dyn Fn() -> bool,
) -> Option<Failure<C>> {
    let (case, mut tree) = draw(&law.cases(), seed, law.name(), index).case.ok()?;
    let verdict = verdict_on(law, &case, fault);
    if !verdict.is_broken() {
        return None;
    }
    let mut best = Failure { seed, index, case, verdict, checks: 0 };
    // A strategy with filters may panic while it moves; what was found until then stands.
    let mut moved = max_checks > 0 && guarded(|| tree.simplify()).unwrap_or(false);
    while moved && best.checks < max_checks && go_on() {
        let Ok(case) = guarded(|| tree.current()) else { break };
        let verdict = verdict_on(law, &case, fault);
        best.checks += 1;
        let broken = verdict.is_broken();
        if broken {
            (best.case, best.verdict) = (case, verdict);
        }
        moved = guarded(|| if broken { tree.simplify() } else { tree.complicate() }).unwrap_or(false);
    }
    Some(best)
}

/// A case that was given, shrunk.
#[derive(Clone, Debug, PartialEq)]
pub struct Shrunk<C, V = Verdict> {
    /// The simplest case found that is still broken; the given one where there is none.
    pub case: C,
    /// The verdict on it.
    pub verdict: V,
    /// How many times a simpler case was found.
    pub steps: usize,
    /// How many checks were spent.
    pub checks: usize,
}

/// `case`, shrunk with at most `max_checks` further checks; `None` where the law is not broken on it.
///
/// It need not have been drawn: simpler cases are those of [`Law::simpler`], so what is found is a function of the law, the fault
/// and the case.
pub fn shrink_from<C: Clone + Debug>(
    law: &dyn Law<C>,
    fault: Option<&Fault>,
    case: &C,
    max_checks: usize,
) -> Option<Shrunk<C>> {
    let broken = |case: &C| Some(verdict_on(law, case, fault)).filter(Verdict::is_broken);
    let verdict = broken(case)?;
    let simpler = |case: &C, visit: &mut dyn FnMut(C) -> bool| law.simpler(case, visit);
    let (known, spent) = (|case: &C| format!("{case:?}"), |checks| checks >= max_checks);
    Some(descend(case.clone(), verdict, simpler, known, spent, broken))
}

/// From a case to the first of its simpler ones that is `broken`, and so on, until none is or enough checks are `spent`.
///
/// `simpler` tells its visitor simpler cases until that answers true; of those with one text in `known` the first is checked.
pub(crate) fn descend<C, V>(
    case: C,
    verdict: V,
    simpler: impl Fn(&C, &mut dyn FnMut(C) -> bool),
    known: impl Fn(&C) -> String,
    spent: impl Fn(usize) -> bool,
    mut broken: impl FnMut(&C) -> Option<V>,
) -> Shrunk<C, V> {
    let mut seen = HashSet::from([known(&case)]);
    let mut best = Shrunk { case, verdict, steps: 0, checks: 0 };
    loop {
        let (mut checks, mut next) = (best.checks, None);
        let mut visit = |candidate: C| {
            if spent(checks) {
                return true;
            }
            if !seen.insert(known(&candidate)) {
                return false;
            }
            checks += 1;
            let Some(found) = broken(&candidate) else { return false };
            next = Some((candidate, found));
            true
        };
        // A strategy may panic where it is asked; what was found until then stands.
        let asked = guarded(|| simpler(&best.case, &mut visit));
        best.checks = checks;
        match (asked, next) {
            (Ok(()), Some((case, found))) => {
                (best.case, best.verdict) = (case, found);
                best.steps += 1;
            }
            _ => return best,
        }
    }
}
