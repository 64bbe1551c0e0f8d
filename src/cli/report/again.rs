//! Cases run again, to gather what a row does not hold: the errors behind an order, a defect at two precisions.

use super::super::progress::Bar;
use super::chart::Curve;
use super::files::{Found, Saved};
use super::tally::Tally;
use euler_poincare::harness::convergence::{Estimate, TOLERANCE};
use euler_poincare::harness::evidence::{Evidence, gather};
use euler_poincare::harness::{Fault, Law, Verdict, draw, parallel, verdict_on};
use euler_poincare::laws::replay::{ReplayError, Replayed};
use euler_poincare::laws::{self, CaseLaw};
use euler_poincare::system::Case;

/// Failing cases that are run again; the others are named.
const FAILURES: usize = 40;

/// An order law, with some of its cases.
pub struct Order {
    /// The law.
    pub law: &'static CaseLaw,
    /// Its cases, that of the largest ratio first.
    pub cases: Vec<Shown>,
}

/// A case of an order law.
pub struct Shown {
    /// Its index.
    pub index: usize,
    /// Why it was chosen.
    pub chosen: &'static str,
    /// The case; or why there is none.
    pub case: Result<Case, String>,
    /// What the law says of it now.
    pub verdict: Verdict,
    /// Whether that is what the campaign has.
    pub agrees: bool,
    /// The errors.
    pub curves: Vec<Curve>,
}

/// Failing cases on file.
pub struct Failures<'a> {
    /// Run again, with their files.
    pub shown: Vec<(&'a str, Replayed)>,
    /// Files that cannot be: name and reason.
    pub refused: Vec<(&'a str, String)>,
    /// Files of failing cases that were not run again.
    pub rest: Vec<&'a str>,
}

/// Runs what is needed: `plots` cases of each order law, and the failing cases on file.
pub fn run(found: &Found, plots: usize) -> (Vec<Order>, Failures<'_>) {
    let wanted: Vec<(&'static CaseLaw, Vec<Choice>)> =
        order_laws(found).map(|(law, tally)| (law, chosen(tally, plots))).collect();
    let (mut known, mut refused) = (Vec::new(), Vec::new());
    for Saved { file, replay } in &found.failures {
        match replay {
            Ok(replay) => known.push((file.as_str(), replay)),
            Err(why) => refused.push((file.as_str(), why.clone())),
        }
    }
    let rest = known.split_off(known.len().min(FAILURES)).into_iter().map(|(file, _)| file).collect();
    let plots = wanted.iter().map(|(_, choices)| choices.len()).sum();
    let bar = Bar::new(&[(PLOTS, Some(plots), 50), (FAILING, Some(known.len()), 1)], None, None);
    let fault = |law: &CaseLaw| law.fault(found.manifest.plant.as_deref()?);
    let choices: Vec<_> =
        wanted.iter().flat_map(|(law, choices)| choices.iter().map(|choice| (*law, choice))).collect();
    let measured = parallel(choices.len(), |k| {
        let (law, choice) = choices[k];
        let shown = show(law, fault(law), found.manifest.seed, choice);
        bar.advance(PLOTS);
        shown
    });
    let mut measured = measured.into_iter();
    let orders =
        wanted.iter().map(|(law, choices)| Order { law, cases: measured.by_ref().take(choices.len()).collect() });
    let orders = orders.filter(|order| order.cases.iter().any(|case| !case.curves.is_empty())).collect();
    let again = parallel(known.len(), |k| {
        let (file, replay) = known[k];
        let replayed = Replayed::of(replay.clone(), None);
        bar.advance(FAILING);
        let why = |error| match error {
            ReplayError::Law { found, .. } => format!("this program has no law {found:?}"),
            error => error.to_string(),
        };
        replayed.map(|replayed| (file, replayed)).map_err(|error| (file, why(error)))
    });
    let mut shown = Vec::new();
    for replayed in again {
        match replayed {
            Ok(replayed) => shown.push(replayed),
            Err(why) => refused.push(why),
        }
    }
    bar.clear();
    (orders, Failures { shown, refused, rest })
}

const PLOTS: &str = "order plots";
const FAILING: &str = "failing cases";

/// The laws whose bound is that of orders.
fn order_laws(found: &Found) -> impl Iterator<Item = (&'static CaseLaw, &Tally)> {
    let judged = found.laws().filter(|(_, tally)| tally.found.worst.is_some_and(|worst| worst.bound == TOLERANCE));
    judged.filter_map(|(planned, tally)| Some((laws::named(&planned.name)?, tally)))
}

/// A case to be shown, and what the campaign has of it: (defect, bound), where it was judged.
#[derive(Clone, Copy)]
struct Choice {
    index: usize,
    why: &'static str,
    recorded: Option<(f64, f64)>,
    judged: bool,
}

/// The case of largest ratio, the first that was not decided, and the first ones that held.
fn chosen(tally: &Tally, most: usize) -> Vec<Choice> {
    let worst = tally.found.worst.map(|worst| Choice {
        index: worst.index,
        why: "largest ratio",
        recorded: Some((worst.defect, worst.bound)),
        judged: true,
    });
    let undecided =
        tally.first_undecided.map(|index| Choice { index, why: "first undecided", recorded: None, judged: false });
    let held = tally.first_held.keys().filter(|index| worst.is_none_or(|worst| worst.index != **index));
    let held = held.map(|&index| Choice { index, why: "one of the first", recorded: None, judged: true });
    worst.into_iter().chain(undecided).chain(held).take(most).collect()
}

fn show(law: &'static CaseLaw, fault: Option<&'static Fault>, seed: u64, choice: &Choice) -> Shown {
    let drawn = draw(&law.cases(), seed, law.about.name, choice.index);
    let (case, verdict, evidence) = match drawn.case {
        Ok((case, _)) => {
            let (verdict, evidence) = gather(|| verdict_on(law, &case, fault));
            (Ok(case), verdict, evidence)
        }
        Err(why) => (Err(why.clone()), Verdict::inconclusive(why), Vec::new()),
    };
    let agrees = verdict.measured().is_some() == choice.judged
        && choice.recorded.is_none_or(|recorded| verdict.measured() == Some(recorded));
    let curves = evidence.into_iter().filter_map(curve).collect();
    Shown { index: choice.index, chosen: choice.why, case, verdict, agrees, curves }
}

fn curve(evidence: Evidence) -> Option<Curve> {
    let Evidence::Levels { quantity, levels, kinds, estimate, expected, .. } = evidence else { return None };
    let found = match estimate {
        Estimate::Slope { value, low, high, .. } => Ok((value, [low, high])),
        Estimate::Inconclusive { why, .. } => Err(why),
    };
    let levels = levels.iter().zip(kinds).map(|(level, kind)| (level.h, level.error, kind)).collect();
    Some(Curve { quantity, levels, found, expected, excess: 0 })
}
