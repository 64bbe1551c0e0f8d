//! What a campaign found: for each law, for each claim, and all in all.

use super::counterexample::{Examined, Slopes};
use super::supports::Supports;
use crate::harness::convergence::Estimate;
use crate::harness::{self, Summary};
use crate::laws::method::{Claims, LAWS, MethodLaw, Outcome};
use crate::study::{Findings, Line};
use crate::system::Case;
use serde::Serialize;

/// Why a case says nothing.
const FAILED: &str = "the program failed";

/// What was found about one law.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct LawReport {
    /// The law.
    pub law: &'static MethodLaw,
    /// The claim that it judges, where it is made.
    pub claim: Option<String>,
    /// What the cases showed on which the program did not fail.
    pub found: Summary<Case>,
    /// The indices of the cases on which the program failed: they say nothing about the law.
    pub failed: Vec<usize>,
    /// The orders of whatever decided: the slopes measured, less what local errors have in excess.
    pub slopes: QuantityOrders,
    /// The orders of each quantity whose errors were measured.
    pub orders: Vec<QuantityOrders>,
    /// The first cases whose errors were measured, with these errors.
    pub measured: Vec<Examined>,
    /// The first broken case, shrunk.
    pub failure: Option<Examined>,
    /// The first case on which the program failed.
    pub program_failure: Option<Examined>,
}

/// How many cases of a law are kept with their errors.
const MEASURED: usize = 3;

/// The orders that one quantity showed, one for each case where its order could be read.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct QuantityOrders {
    /// `momentum`, `attitude`, `energy`, …
    pub quantity: String,
    /// The orders, in the sequence of the cases.
    pub values: Vec<f64>,
}

impl QuantityOrders {
    fn sorted(&self) -> Vec<f64> {
        let mut values = self.values.clone();
        values.sort_by(f64::total_cmp);
        values
    }

    /// The least.
    pub fn least(&self) -> Option<f64> {
        self.sorted().first().copied()
    }

    /// The one in the middle.
    pub fn median(&self) -> Option<f64> {
        self.sorted().get(self.values.len() / 2).copied()
    }
}

impl LawReport {
    /// The cases that are shown: the first broken one, and the first on which the program failed.
    pub fn shown(&self) -> impl Iterator<Item = &Examined> {
        self.failure.iter().chain(&self.program_failure)
    }

    /// Cases asked: those on which the program failed, too.
    pub fn cases(&self) -> usize {
        self.found.cases + self.failed.len()
    }

    /// The numbers, with these cases.
    pub fn line(&self) -> harness::Line {
        harness::Line { cases: self.cases(), ..self.found.line() }
    }

    pub(super) fn new(law: &'static MethodLaw, claims: &Claims) -> Self {
        Self {
            law,
            claim: law.claim(claims),
            found: Summary::new(law.about.name),
            failed: Vec::new(),
            slopes: QuantityOrders { quantity: "what decided".into(), values: Vec::new() },
            orders: Vec::new(),
            measured: Vec::new(),
            failure: None,
            program_failure: None,
        }
    }

    /// The most frequent reason why cases did not decide, and on how many of them.
    fn undecided(&self) -> Option<(String, usize)> {
        let mut reasons = self.found.inconclusive.clone();
        for (why, count) in &self.found.not_applicable {
            *reasons.entry(why.clone()).or_default() += count;
        }
        if !self.failed.is_empty() {
            *reasons.entry(FAILED.to_owned()).or_default() += self.failed.len();
        }
        reasons.into_iter().max_by_key(|(_, count)| *count)
    }

    /// The orders of each quantity of a case.
    fn record_orders(&mut self, findings: &Findings) {
        for (name, line) in findings.quantities().iter().zip(findings.lines()) {
            let Line::Read(Estimate::Slope { value, .. }) = line else { continue };
            match self.orders.iter_mut().find(|orders| orders.quantity == *name) {
                Some(orders) => orders.values.push(value),
                None => self.orders.push(QuantityOrders { quantity: name.clone(), values: vec![value] }),
            }
        }
    }

    pub(super) fn record(&mut self, index: usize, case: Option<&Case>, outcome: &Outcome) {
        self.found.judged(index, &outcome.verdict);
        if let Some(findings) = &outcome.findings {
            self.record_orders(findings);
            if let (Some(case), true) = (case, self.measured.len() < MEASURED) {
                let examined = Examined::new(index, case.clone(), outcome.verdict.clone());
                self.measured.push(Examined { slopes: Slopes::in_sequence(findings), ..examined });
            }
        }
        self.slopes.values.extend(outcome.slope.as_ref().and_then(Estimate::slope));
    }
}

/// What became of a claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ClaimReport {
    /// The claim: `order 4`, `conserves casimirs`, `conserves energy`, `conserves momentum`, `conserves poisson`,
    /// `reversible`.
    pub claim: String,
    /// The law that judges it.
    pub law: &'static str,
    /// Cases asked.
    pub cases: usize,
    /// Cases that confirm it.
    pub confirmed: usize,
    /// Cases that refute it.
    pub broken: usize,
    /// Why cases did not decide, most often.
    pub why: Option<String>,
    /// On how many of them for this reason.
    pub why_cases: usize,
}

/// A campaign in a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Conclusion {
    /// It was interrupted.
    Interrupted,
    /// A law is broken.
    Broken,
    /// No law is broken, and the program failed on a case.
    Failed,
    /// The program failed too often, and was not started again.
    GivenUp,
    /// Nothing is broken, and a claim was confirmed on no case.
    Unconfirmed,
    /// Nothing was claimed, and no law holds on any case.
    Undecided,
    /// Nothing is broken, and each claim was confirmed on a case at least.
    Confirmed,
    /// Nothing was claimed, and nothing is broken.
    Unbroken,
}

/// What was found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ProbeReport {
    /// What was claimed.
    pub claims: Claims,
    /// What the program says that it supports, where it says so.
    pub supports: Option<Supports>,
    /// One for each law.
    pub laws: Vec<LawReport>,
    /// How often the program failed.
    pub failures: usize,
    /// Whether it was given up before the end.
    pub given_up: bool,
    /// Whether the campaign was interrupted.
    pub interrupted: bool,
}

impl ProbeReport {
    /// What became of each claim. A claim of which no law was asked about is among them.
    pub fn claims(&self) -> Vec<ClaimReport> {
        let claim = |law: &'static MethodLaw| {
            let claim = law.claim(&self.claims)?;
            let report = self.laws.iter().find(|report| report.law == law);
            let absent = || (format!("{} is not among the selected laws", law.about.name), 0);
            let (why, why_cases) = report.map_or_else(|| Some(absent()), LawReport::undecided).unzip();
            Some(ClaimReport {
                claim,
                law: law.about.name,
                cases: report.map_or(0, LawReport::cases),
                confirmed: report.map_or(0, |report| report.found.held),
                broken: report.map_or(0, |report| report.found.broken.len()),
                why,
                why_cases: why_cases.unwrap_or(0),
            })
        };
        LAWS.iter().filter_map(claim).collect()
    }

    /// The campaign in a word: the first that applies, in the sequence of [`Conclusion`].
    pub fn conclusion(&self) -> Conclusion {
        let claims = self.claims();
        if self.interrupted {
            Conclusion::Interrupted
        } else if self.laws.iter().any(|law| !law.found.broken.is_empty()) {
            Conclusion::Broken
        } else if self.laws.iter().any(|law| !law.failed.is_empty()) {
            Conclusion::Failed
        } else if self.given_up {
            Conclusion::GivenUp
        } else if claims.iter().any(|claim| claim.confirmed == 0) {
            Conclusion::Unconfirmed
        } else if !claims.is_empty() {
            Conclusion::Confirmed
        } else if self.laws.iter().any(|law| law.found.held > 0) {
            Conclusion::Unbroken
        } else {
            Conclusion::Undecided
        }
    }
}
