//! What `probe --format json` prints: one object per law and line, and one for the whole.

use super::super::schema::object;
use super::Kept;
use super::text::asked;
use euler_poincare::external::{Examined, LawReport, ProbeReport, QuantityOrders, Record};
use euler_poincare::harness::Verdict;
use euler_poincare::laws::method::MethodLaw;
use serde_json::{Value, json};
use std::path::Path;

/// The campaign.
pub fn json(report: &ProbeReport, kept: &[Vec<Kept>], page: Option<&Path>) -> String {
    let laws = report.laws.iter().zip(kept).map(|(law, kept)| one(law, kept));
    laws.chain([summary(report, page)]).map(|line| format!("{line}\n")).collect()
}

fn one(law: &LawReport, kept: &[Kept]) -> Value {
    let mut line = json!({
        "law": law.law.about.name,
        "cases": law.cases(),
        "held": law.found.held,
        "broken": law.found.broken.len(),
        "failed": law.failed.len(),
        "inconclusive": law.found.inconclusive,
        "not_applicable": law.found.not_applicable,
        "claim": law.claim,
        "confirmed": law.claim.as_ref().map(|_| law.found.held),
        "max_defect": law.found.line().max_defect,
        "bound": law.found.line().bound,
        "least_order": law.slopes.least(),
        "median_order": law.slopes.median(),
        "orders": law.orders.iter().map(orders).collect::<Vec<_>>(),
    });
    for (broken, kept) in law.shown().zip(kept) {
        let mut failure = failure(broken);
        failure["index"] = json!(broken.index);
        failure["saved"] = json!(kept.not_saved.is_none().then_some(&kept.file));
        failure["not_saved"] = json!(kept.not_saved);
        line[if broken.failed { "program_failure" } else { "failure" }] = failure;
    }
    object("probe/1", line)
}

/// The orders that one quantity showed.
fn orders(orders: &QuantityOrders) -> Value {
    json!({
        "quantity": orders.quantity,
        "median": orders.median(),
        "least": orders.least(),
        "cases": orders.values.len(),
    })
}

/// What is known of a broken case.
fn failure(broken: &Examined) -> Value {
    json!({
        "witness": broken.witness(),
        "failed": broken.failed,
        "varied": broken.varied,
        "checks": broken.checks,
        "case": broken.case,
        "slopes": broken.slopes,
        "exchange": broken.exchange,
    })
}

fn summary(report: &ProbeReport, page: Option<&Path>) -> Value {
    let summary = json!({
        "conclusion": report.conclusion(),
        "laws": report.laws.len(),
        "cases": asked(report),
        "laws_broken": report.laws.iter().filter(|law| !law.found.broken.is_empty()).count(),
        "laws_failed": report.laws.iter().filter(|law| !law.failed.is_empty()).count(),
        "cases_failed": report.laws.iter().map(|law| law.failed.len()).sum::<usize>(),
        "claims": report.claims(),
        "failures": report.failures,
        "supports": report.supports,
        "report": page.map(|page| page.display().to_string()),
    });
    object("probe-summary/1", summary)
}

/// A record, judged again.
pub fn replayed(law: &MethodLaw, record: &Record, verdict: &Verdict, broken: Option<&Examined>) -> String {
    let (defect, bound) = verdict.measured().unzip();
    let line = json!({
        "law": law.about.name,
        "claim": law.claim(&record.claims),
        "command": record.command,
        "seed": record.seed,
        "index": record.index,
        "verdict": verdict.word(),
        "why": verdict.why().filter(|_| !verdict.is_broken()),
        "defect": defect,
        "bound": bound,
        "failure": broken.map(failure),
    });
    format!("{}\n", object("probe-replay/1", line))
}
