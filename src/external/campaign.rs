//! The laws of methods on a program: case after case, the first broken one of each law shrunk.

use super::counterexample::Examined;
use super::report::{LawReport, ProbeReport};
use super::stepper::External;
use crate::harness::{Progress, Shrunk, Verdict, descend, draw};
use crate::laws::Source as _;
use crate::laws::method::{Claims, MethodLaw, MethodSource, Outcome, check_case, theory_of};
use crate::system::{Case, Cases};
use proptest::strategy::Strategy;
use std::time::{Duration, Instant};

/// Which systems.
#[non_exhaustive]
pub enum Drawn {
    /// One.
    This(Box<Case>),
    /// Random ones of these, `cases` for each law, from a seed.
    Random {
        /// What they may be.
        of: Box<Cases>,
        /// How many for each law.
        cases: usize,
        /// The seed.
        seed: u64,
    },
}

/// How much is spent on shrinking a broken case: what is used up first ends it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shrinking {
    /// Checks.
    pub checks: usize,
    /// Time.
    pub time: Duration,
}

impl Shrinking {
    /// Not at all.
    pub const OFF: Self = Self { checks: 0, time: Duration::ZERO };
}

/// 60 checks or 30 seconds.
impl Default for Shrinking {
    fn default() -> Self {
        Self { checks: 60, time: Duration::from_secs(30) }
    }
}

/// A campaign on a program.
pub struct Probe<'a> {
    /// The program.
    pub external: &'a External,
    /// Which laws.
    pub laws: &'a [&'static MethodLaw],
    /// On which systems.
    pub systems: Drawn,
    /// What is claimed of the method.
    pub claims: Claims,
    /// How far the first broken case of each law is shrunk; one that was not drawn is not shrunk.
    pub shrinking: Shrinking,
}

/// A shrunk case is to be refuted as clearly as the case that was found: with this ratio of defect to bound, or a quarter of the ratio
/// found. A defect near its bound says little about what is wrong.
const CLEAR: f64 = 1000.0;

/// A law on a case.
struct Judged {
    outcome: Outcome,
    /// Whether the program failed.
    failed: bool,
}

impl Judged {
    /// Defect over bound.
    fn ratio(&self) -> f64 {
        self.outcome.verdict.ratio().unwrap_or(0.0)
    }

    /// Whether the case is broken by itself, and not one of its variations.
    fn broken_by_itself(&self) -> bool {
        self.outcome.verdict.is_broken() && self.outcome.decided_by.is_none() && !self.failed
    }
}

fn judge(external: &External, law: &MethodLaw, case: &Case, claims: &Claims) -> Judged {
    external.program().forget();
    let outcome = check_case(law, external, case, claims);
    Judged { outcome, failed: external.program().failure().is_some() }
}

/// The same once more, where the program told with its first answer what it supports.
fn judge_once_told(external: &External, law: &MethodLaw, case: &Case, claims: &Claims) -> Judged {
    let known = external.supports().is_some();
    let judged = judge(external, law, case, claims);
    if known || external.supports().is_none() { judged } else { judge(external, law, case, claims) }
}

/// A law on one case of a program: the verdict, and what explains it where the law is broken.
pub fn examine(
    external: &External,
    law: &'static MethodLaw,
    case: &Case,
    claims: &Claims,
) -> (Outcome, Option<Examined>) {
    let judged = judge_once_told(external, law, case, claims);
    if external.is_interrupted() {
        return (judged.outcome, None);
    }
    explained(external, law, claims, (0, case.clone()), judged, |_, found| found)
}

/// What was judged, and what explains it where the program failed or the law is broken: on the case that `shrink` finds.
fn explained(
    external: &External,
    law: &'static MethodLaw,
    claims: &Claims,
    (index, case): (usize, Case),
    judged: Judged,
    shrink: impl FnOnce(&mut Examined, Judged) -> Judged,
) -> (Outcome, Option<Examined>) {
    if judged.failed {
        let failed = Examined::program(index, case, external);
        return (failed.verdict.clone().into(), Some(failed));
    }
    if !judged.outcome.verdict.is_broken() {
        return (judged.outcome, None);
    }
    let mut broken = Examined::new(index, case, judged.outcome.verdict.clone());
    let found = deciding(external, law, claims, &mut broken, judged);
    let found = shrink(&mut broken, found);
    broken.explain(external, law, claims, &found.outcome);
    (found.outcome, Some(broken))
}

/// Replaces the case by the variation that decided, where that is broken by itself.
fn deciding(external: &External, law: &MethodLaw, claims: &Claims, broken: &mut Examined, found: Judged) -> Judged {
    let other = found.outcome.decided_by.and_then(|k| broken.case.other(k));
    let other = other.and_then(|other| external.adapted(other));
    let Some(other) = other else { return found };
    let judged = judge(external, law, &other, claims);
    if !judged.broken_by_itself() {
        return found;
    }
    (broken.case, broken.varied) = (other, true);
    broken.verdict = judged.outcome.verdict.clone();
    judged
}

impl Probe<'_> {
    /// How many checks there will be, shrinking apart.
    pub fn checks(&self) -> usize {
        self.laws.len() * self.cases()
    }

    fn cases(&self) -> usize {
        match &self.systems {
            Drawn::This(_) => 1,
            Drawn::Random { cases, .. } => *cases,
        }
    }

    /// Runs it.
    ///
    /// It ends early where the program is interrupted or given up; the case under way is then dropped.
    pub fn run(&self, progress: &dyn Progress) -> ProbeReport {
        let mut laws = Vec::new();
        for law in self.laws {
            let mut report = LawReport::new(law, &self.claims);
            let mut drawn = self.drawn(law);
            let mut index = 0;
            while index < self.cases() && !self.external.has_ended() {
                let known = self.external.supports().is_some();
                self.case(&mut report, drawn.as_ref(), index, progress);
                if !known && self.external.supports().is_some() && drawn.is_some() {
                    // Cases are drawn of what it supports from now on.
                    drawn = self.drawn(law);
                    continue;
                }
                index += 1;
            }
            laws.push(report);
        }
        progress.finish();
        let program = self.external.program();
        ProbeReport {
            claims: self.claims.clone(),
            supports: self.external.supports().cloned(),
            laws,
            failures: program.failures(),
            given_up: program.is_given_up(),
            interrupted: program.is_interrupted(),
        }
    }

    /// The cases of a law, of what the program supports.
    fn drawn(&self, law: &MethodLaw) -> Option<Cases> {
        let Drawn::Random { of, .. } = &self.systems else { return None };
        let of = match self.external.supports() {
            Some(supports) => Box::new(supports.cases((**of).clone())),
            None => of.clone(),
        };
        Some(law.cases(*of))
    }

    fn judge(&self, law: &MethodLaw, case: &Case) -> Judged {
        judge(self.external, law, case, &self.claims)
    }

    fn case(&self, report: &mut LawReport, cases: Option<&Cases>, index: usize, progress: &dyn Progress) {
        let law = report.law;
        let case = match (&self.systems, cases) {
            (Drawn::Random { seed, .. }, Some(cases)) => {
                match draw(&cases.clone().boxed(), *seed, law.about.name, index).case {
                    Ok((case, _)) => case,
                    Err(_) => return report.record(index, None, &Verdict::inconclusive(NO_CASE).into()),
                }
            }
            (Drawn::This(case), _) => (**case).clone(),
            (Drawn::Random { .. }, None) => return,
        };
        let known = self.external.supports().is_some();
        let judged = match self.systems {
            Drawn::This(_) => judge_once_told(self.external, law, &case, &self.claims),
            Drawn::Random { .. } => self.judge(law, &case),
        };
        let to_be_drawn_again = cases.is_some() && !known && self.external.supports().is_some();
        if self.external.is_interrupted() || to_be_drawn_again {
            return;
        }
        let first = if judged.failed {
            report.failed.push(index);
            &mut report.program_failure
        } else {
            report.record(index, Some(&case), &judged.outcome);
            &mut report.failure
        };
        progress.case(law.about.name, &judged.outcome.verdict);
        if first.is_none() {
            let shrink = |broken: &mut Examined, found| match cases {
                Some(cases) => self.shrink(law, cases, broken, found),
                None => found,
            };
            *first = explained(self.external, law, &self.claims, (index, case), judged, shrink).1;
        }
    }

    /// Simpler cases that are broken by themselves, until there is none or enough was spent; what was found on the last.
    fn shrink(&self, law: &MethodLaw, cases: &Cases, best: &mut Examined, found: Judged) -> Judged {
        if self.shrinking.checks == 0 || !found.broken_by_itself() {
            return found;
        }
        let deadline = Instant::now() + self.shrinking.time;
        let clear = (found.ratio() / 4.0).min(CLEAR);
        let simpler = |case: &Case, visit: &mut dyn FnMut(Case) -> bool| {
            let _ = cases.simpler(case).any(visit);
        };
        // What differs in the method alone is the same to a program.
        let known = |case: &Case| posed(self.external, case).unwrap_or_default();
        let spent = |checks| checks >= self.shrinking.checks || Instant::now() >= deadline || self.external.has_ended();
        let broken = |case: &Case| {
            let judged = self.judge(law, case);
            let broken = judged.broken_by_itself() && judged.ratio() >= clear && !self.external.is_interrupted();
            broken.then_some(judged)
        };
        let Shrunk { case, verdict: found, checks, .. } =
            descend(best.case.clone(), found, simpler, known, spent, broken);
        (best.case, best.verdict, best.checks) = (case, found.outcome.verdict.clone(), Some(checks));
        found
    }
}

/// Why there is no case.
const NO_CASE: &str = "no system fits: the options exclude every system that this law asks about";

/// What a case is to a program: the request for its step.
fn posed(external: &External, case: &Case) -> Option<String> {
    let described = external.described(case).ok()?;
    let theory = theory_of::<f64>(case, &external.state()).ok()?;
    Some(described.request(&theory.start(), theory.step()))
}
