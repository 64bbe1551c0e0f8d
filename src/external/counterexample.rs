//! A case on which a law is broken, with what a person needs to see why: the errors level by level, and one answer beside the
//! solution.

use super::program::Exchange;
use super::stepper::External;
use crate::harness::Verdict;
use crate::harness::convergence::{Estimate, LevelKind};
use crate::laws::Source;
use crate::laws::method::{Claims, MethodLaw, Outcome, Point, Scheme, StateForm, Stepper, difference, theory_of};
use crate::scalar::{Dd, Scalar};
use crate::study::{Findings, Line, Reading};
use crate::system::Case;
use crate::system::case::Method;
use serde::{Deserialize, Serialize};

/// A case that was judged, with what a person needs to see why: most often a broken one.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Examined {
    /// Its index, before it was shrunk.
    pub index: usize,
    /// The simplest case found that is broken by itself.
    pub case: Case,
    /// Whether it comes from a variation of the case with this index: the same algebra, with another inertia, force and motion.
    pub varied: bool,
    /// The verdict on it.
    pub verdict: Verdict,
    /// How many checks were spent on shrinking; `None` where it was not tried.
    pub checks: Option<usize>,
    /// Whether the program failed: it hung, died, flooded, or answered with something else than a state.
    pub failed: bool,
    /// The errors from which the order was read, of each part of the state; the deciding one first.
    pub slopes: Vec<Slopes>,
    /// The request that did it, where the program failed; else one step that is off the solution.
    pub exchange: Option<Compared>,
}

/// μ and g.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Values {
    /// n numbers.
    pub mu: Vec<f64>,
    /// m² numbers by rows; none where there is no group.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub g: Vec<f64>,
    /// The m numbers of a point, where the state has one instead of g.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub x: Vec<f64>,
}

impl Values {
    /// Of a state.
    fn of(form: &StateForm, mu: Vec<f64>, beside: Vec<f64>) -> Self {
        match form {
            StateForm::Point(_) => Self { mu, g: Vec::new(), x: beside },
            _ => Self { mu, g: beside, x: Vec::new() },
        }
    }
}

/// A request and its answer, with the solution beside it, or the step of the scheme that is claimed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Compared {
    /// What was asked for.
    pub what: String,
    /// The line that was written.
    pub request: String,
    /// The line that was read; empty where none came.
    pub answer: String,
    /// The solution at the end of this step, from the state in the request.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solution: Option<Values>,
    /// Whether that is not the solution but the step of the variational scheme that is claimed.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub of_scheme: bool,
    /// The answer less the solution.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub difference: Option<Values>,
}

/// The errors of one quantity at a sequence of steps, and the order that they show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Slopes {
    /// What it is the error of.
    pub quantity: String,
    /// The order, extrapolated to h = 0.
    pub order: Option<f64>,
    /// Its interval.
    pub interval: Option<[f64; 2]>,
    /// Why there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// One for each step size, the largest first.
    pub levels: Vec<SlopeLevel>,
}

/// One step size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct SlopeLevel {
    /// How many steps were taken.
    pub steps: usize,
    /// Their size.
    pub h: f64,
    /// The error after them.
    pub error: f64,
    /// How much of it may be rounding, or error of the solution.
    pub noise: f64,
    /// The order between the level before and this one.
    pub order: Option<f64>,
    /// What it is to the order; too coarse, too, where there is no order.
    pub mark: LevelKind,
}

impl Slopes {
    /// Those of some findings; first the quantity `decided`, or the part of the state that decides about `order`.
    pub fn of(findings: &Findings, decided: Option<usize>, order: u32) -> Vec<Self> {
        let first = decided.or_else(|| findings.deciding(order).map(|(quantity, _)| quantity));
        let rest = (0..findings.quantities().len()).filter(|quantity| Some(*quantity) != first);
        first.into_iter().chain(rest).map(|quantity| Self::quantity(findings, quantity, f64::is_finite)).collect()
    }

    /// Those of some findings, in the sequence of the quantities.
    pub fn in_sequence(findings: &Findings) -> Vec<Self> {
        (0..findings.quantities().len()).map(|quantity| Self::quantity(findings, quantity, f64::is_finite)).collect()
    }

    /// The same with the levels whose error is infinite or NaN, which are no numbers in JSON.
    pub fn with_infinite(findings: &Findings) -> Vec<Self> {
        (0..findings.quantities().len()).map(|quantity| Self::quantity(findings, quantity, |_| true)).collect()
    }

    /// Those of a quantity, of the levels whose error and noise are `admitted`.
    fn quantity(findings: &Findings, quantity: usize, admitted: fn(f64) -> bool) -> Self {
        let (order, interval, why) = match findings.line(quantity) {
            Line::Exact => (None, None, Some("every error is rounding".to_owned())),
            Line::Read(Estimate::Slope { value, low, high, .. }) => (Some(value), Some([low, high]), None),
            Line::Read(Estimate::Inconclusive { why, .. }) => (None, None, Some(why)),
        };
        let mut levels: Vec<SlopeLevel> = Vec::new();
        for (row, kind) in findings.rows().iter().zip(findings.kinds(quantity)) {
            let reading = row.readings.as_ref().ok().and_then(|list| list.get(quantity));
            // A function of the state may have no value.
            let admitted = |reading: &&Reading| admitted(reading.error) && admitted(reading.noise);
            let Some(reading) = reading.filter(admitted) else { continue };
            let slope = levels
                .last()
                .filter(|last| last.error > 0.0 && reading.error > 0.0)
                .map(|last| (last.error / reading.error).ln() / (last.h.abs() / row.h.abs()).ln() - findings.excess());
            let mark = kind.unwrap_or(LevelKind::PreAsymptotic);
            levels.push(SlopeLevel {
                steps: row.steps,
                h: row.h,
                error: reading.error,
                noise: reading.noise,
                order: slope,
                mark,
            });
        }
        Self { quantity: findings.quantities()[quantity].clone(), order, interval, why, levels }
    }
}

/// A step to be asked for.
struct Question {
    what: &'static str,
    case: Case,
    from: Point<f64>,
    h: f64,
}

/// How many of the step sizes of a study are tried.
const SIZES: usize = 4;

/// The steps of the method that the solution comes from.
const STEPS: i64 = 8;

/// The step of a broken case that is farthest from the solution, of those that the law asks for.
pub(super) fn compared(
    external: &External,
    law: &MethodLaw,
    case: &Case,
    claims: &Claims,
    findings: Option<&Findings>,
) -> Option<Compared> {
    let mut worst: Option<(f64, Compared)> = None;
    let scheme = claims.variational.as_ref().filter(|_| law.about.name == "method-variational");
    let mut ask = |question: &Question| {
        let (answer, compared, distance) = asked(external, question, scheme)?;
        if worst.as_ref().is_none_or(|(most, _)| distance > *most) {
            worst = Some((distance, compared));
        }
        Some(answer)
    };
    for question in questions(law, case, findings, &external.state())? {
        let answer = ask(&question);
        if let (Some(from), "method-reversibility") = (answer, law.about.name) {
            ask(&Question { what: "the step back from there", from, h: -question.h, ..question });
        }
    }
    worst.map(|(_, compared)| compared)
}

/// The steps that a law asks for first, and those in which a case is not to matter.
fn questions(law: &MethodLaw, case: &Case, findings: Option<&Findings>, form: &StateForm) -> Option<Vec<Question>> {
    let theory = theory_of::<Dd>(case, form).ok()?;
    let (start, h) = (theory.start().convert::<f64>(), theory.step().to_f64());
    let question = |what, from: &Point<f64>, h| Question { what, case: case.clone(), from: from.clone(), h };
    let translated =
        |start: &Point<f64>, k: Vec<Dd>| start.translated(&k.iter().map(|x| x.to_f64()).collect::<Vec<_>>());
    let element = theory.element();
    let (what, start) = match element.clone().filter(|_| law.about.name == "method-variational") {
        Some(k) => ("a step after a left translation of g", translated(&start, k)),
        None => ("a step from the start", start),
    };
    let mut list = vec![question(what, &start, h)];
    match law.about.name {
        "method-equivariance" => {
            if let Some(k) = element {
                list.push(question("a step after a left translation of g", &translated(&start, k), h));
            }
            if theory.is_autonomous() {
                list.push(question(
                    "a step from a later time",
                    &Point { time: start.time + 0.625, ..start.clone() },
                    h,
                ));
            }
        }
        "method-presentation" => {
            let (other, _) = Source::presented(case)?;
            let from = theory_of::<Dd>(&other, form).ok()?.start().convert::<f64>();
            list.push(Question { what: "a step in another basis", case: other, from, h });
        }
        _ => {
            let rows = findings.map_or(&[][..], |findings| findings.rows());
            let sizes = rows.iter().filter(|row| row.readings.is_ok()).map(|row| row.h).take(SIZES);
            list.extend(sizes.filter(|size| *size != h).map(|size| question(what, &start, size)));
        }
    }
    Some(list)
}

/// The solution after a step from a state, and what its momentum and what stands beside it may be off.
fn solved(case: &Case, form: &StateForm, from: &Point<f64>, h: f64) -> Option<(Point<f64>, [f64; 2])> {
    let theory = theory_of::<Dd>(case, form).ok()?;
    let times: Vec<Dd> = (1..=STEPS).map(|k| Dd::exact(h) * Dd::ratio(k, STEPS)).collect();
    let (solution, reference_error) = theory.solve(&from.convert(), &times, 0.0, true).ok()?.pop()?;
    Some((solution.convert(), [reference_error.0.to_f64(), reference_error.1.to_f64()]))
}

/// The answer, the exchange with the solution (or the step of a scheme) beside it, and by how much they differ, relative.
///
/// Without an answer, or a solution that is accurate enough to show the difference: `None`.
fn asked(external: &External, question: &Question, scheme: Option<&Method>) -> Option<(Point<f64>, Compared, f64)> {
    let Question { what, case, from, h } = question;
    let mut stepper = external.on(case).ok()?;
    external.program().forget();
    let answer = stepper.step(from, *h).ok()?;
    let Exchange { request, answer: line } = external.program().last().cloned()?;
    let form = external.state();
    let (solution, reference_error) = match scheme {
        Some(method) => {
            let scheme = Scheme::of(case, method, &form).ok()?;
            ((scheme.exact)(&from.convert(), Dd::exact(*h)).ok()?.convert::<f64>(), [0.0; 2])
        }
        None => solved(case, &form, from, *h)?,
    };
    let parts = [
        (&answer.momentum, &solution.momentum, reference_error[0]),
        (&answer.attitude, &solution.attitude, reference_error[1]),
    ];
    let distance = parts.map(|(mine, exact, reference_error)| {
        let (off, size) = difference(mine, exact);
        let size = size.max(f64::MIN_POSITIVE);
        (off - 16.0 * reference_error.min(size)) / size
    });
    let compared = Compared {
        what: format!("{what}, h = {h}"),
        request,
        answer: line,
        difference: Some(Values::of(
            &form,
            less(&answer.momentum, &solution.momentum),
            less(&answer.attitude, &solution.attitude),
        )),
        solution: Some(Values::of(&form, solution.momentum, solution.attitude)),
        of_scheme: scheme.is_some(),
    };
    Some((answer, compared, distance[0].max(distance[1])))
}

fn less(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

impl Examined {
    /// What is wrong with it.
    pub fn witness(&self) -> &str {
        self.verdict.why().unwrap_or_default()
    }

    /// A case as it was judged.
    pub(super) fn new(index: usize, case: Case, verdict: Verdict) -> Self {
        Self { index, case, varied: false, verdict, checks: None, failed: false, slopes: Vec::new(), exchange: None }
    }

    /// What a person needs to debug it: the errors and one step with the solution beside it, or the request that did it.
    pub(super) fn explain(&mut self, external: &External, law: &MethodLaw, claims: &Claims, outcome: &Outcome) {
        let findings = outcome.findings.as_ref();
        self.slopes =
            findings.map_or_else(Vec::new, |findings| Slopes::of(findings, outcome.deciding, claims.least_order()));
        self.exchange = compared(external, law, &self.case, claims, findings);
    }

    /// The case on which the program failed, with the request that did it.
    pub(super) fn program(index: usize, case: Case, external: &External) -> Self {
        let (exchange, why) = external.program().failure().cloned().unzip();
        let verdict = Verdict::broken(why.unwrap_or_else(|| "the stepper failed".into()));
        let exchange = exchange.map(|Exchange { request, answer }| Compared {
            what: "what the stepper failed on".into(),
            request,
            answer,
            solution: None,
            of_scheme: false,
            difference: None,
        });
        Self { failed: true, exchange, ..Self::new(index, case, verdict) }
    }
}
