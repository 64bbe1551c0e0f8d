//! The simplest case on which a law still breaks.

use super::draw::draw;
use super::guard::{guarded, verdict_on};
use super::law::{Fault, Law, Verdict};
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
