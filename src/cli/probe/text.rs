//! What `probe` prints for people.

use super::super::levels::rounded;
use super::super::summary::{count, reasons, some};
use super::super::table::{Column, Table, data, entries, paragraph};
use super::{Kept, failure};
use euler_poincare::external::{ClaimReport, Conclusion, LawReport, ProbeReport, QuantityOrders};
use euler_poincare::harness::Line;
use euler_poincare::laws::method::{LOOSE, LOST_DIGITS};
use std::fmt::Write;
use std::path::Path;

const COLUMNS: [Column; 11] = [
    Column::name("law"),
    Column::number("cases"),
    Column::number("held"),
    Column::number("broken"),
    Column::number("program\nfailed"),
    Column::number("incon-\nclusive"),
    Column::number("not\nappl.").rank(2),
    Column::number("worst\ndefect").rank(3),
    Column::number("its\nbound").rank(4),
    Column::number("least\norder"),
    Column::number("median\norder").rank(1),
];

/// What is asked.
const MEANING: &str = "\
The stepper is asked for steps of random systems. The laws measure how its errors shrink with the step, what it conserves, and \
how it treats symmetries. A law is broken where a defect exceeds its bound: rounding, in units of u = 1.1e-16, or a difference of \
slopes of log error against log step.";

/// The verdict and the table; of a run that failed the rest only if it is asked for.
pub(super) fn text(report: &ProbeReport, kept: &[Vec<Kept>], page: Option<&Path>, verbose: bool) -> String {
    let failed = report.laws.iter().any(|law| !law.found.broken.is_empty() || !law.failed.is_empty());
    if failed && !verbose { brief(report, kept, page) } else { whole(report, kept, page) }
}

/// The largest number of saved cases named of a failed run: more do not fit a screen.
const CASES_NAMED: usize = 2;

/// What is printed of a run that failed: the verdict, the laws that failed, the first reason, how to run the cases again.
fn brief(report: &ProbeReport, kept: &[Vec<Kept>], page: Option<&Path>) -> String {
    let (failed, others): (Vec<&LawReport>, Vec<&LawReport>) =
        report.laws.iter().partition(|law| !law.found.broken.is_empty() || !law.failed.is_empty());
    // Without the defects and the least orders: what is left fits 80 columns.
    let mut table = Table::new(&[&COLUMNS[..7], &COLUMNS[10..]].concat());
    let brief = |mut cells: Vec<String>| {
        cells.drain(7..10);
        cells
    };
    for law in failed {
        table.row(brief(row(law.law.about.name.into(), &[law])));
    }
    if !others.is_empty() {
        table.row(brief(row(count(others.len(), "other law"), &others)));
    }
    let mut text = format!("{}\n\n{}\n", paragraph(&verdict(report)), table.text());
    if let Some(why) = first_reason(report) {
        let _ = write!(text, "\n{}\n", paragraph(&why));
    }
    let cases: Vec<&Kept> = kept.iter().flatten().collect();
    for Kept { file, not_saved, .. } in cases.iter().take(CASES_NAMED) {
        let line = match not_saved {
            None => format!("  euler-poincare probe --replay {file}"),
            Some(reason) => paragraph(&format!("  not saved: {reason}")),
        };
        let _ = writeln!(text, "{line}");
    }
    text += &hints(report, page);
    let more = cases.len().saturating_sub(CASES_NAMED);
    let more = if more > 0 { format!(" and {}", count(more, "more case")) } else { String::new() };
    let _ = writeln!(text, "{}", paragraph(&format!("-v prints systems, errors, exchanges, claims{more}.")));
    text
}

/// Why the first law is broken, or how the program failed under it.
fn first_reason(report: &ProbeReport) -> Option<String> {
    let broken = report.laws.iter().find_map(|law| Some((law, law.failure.as_ref()?)));
    let (law, found) =
        broken.or_else(|| report.laws.iter().find_map(|law| Some((law, law.program_failure.as_ref()?))))?;
    Some(format!("{}: {}", law.law.about.name, found.witness()))
}

/// Everything.
fn whole(report: &ProbeReport, kept: &[Vec<Kept>], page: Option<&Path>) -> String {
    let mut table = Table::new(&COLUMNS);
    for law in &report.laws {
        table.row(row(law.law.about.name.into(), &[law]));
    }
    let verdict = paragraph(&verdict(report));
    let mut text = format!("{verdict}\n\n{}\n\n{}\n", paragraph(MEANING), table.text());
    if let Some(supports) = &report.supports {
        let said = serde_json::to_string(supports).unwrap_or_default();
        let _ = write!(text, "\nCases are drawn of what the stepper says that it supports\n{}\n", data(&said));
    }
    let orders: Vec<_> = report.laws.iter().filter(|law| law.law.about.name == ORDERS).flat_map(orders).collect();
    if !orders.is_empty() {
        let _ = write!(text, "\nOrders\n{}\n", entries(2, orders));
    }
    let laws = || report.laws.iter().map(|law| (law.law.about.name, &law.found));
    let blocks = [
        reasons("Inconclusive", SHARED, laws().map(|(law, found)| (law, &found.inconclusive))),
        reasons("Not applicable", SHARED, laws().map(|(law, found)| (law, &found.not_applicable))),
    ];
    text.extend(blocks.iter().flatten().map(|block| format!("\n{block}")));
    for (law, kept) in report.laws.iter().zip(kept) {
        text.extend(law.shown().zip(kept).map(|(broken, kept)| failure::text(law, broken, kept)));
    }
    let claims = report.claims();
    if !claims.is_empty() {
        let rows = claims.iter().map(|claim| (claim.claim.clone(), confirmed(claim)));
        let _ = write!(text, "\nClaims\n{}\n", entries(2, rows));
    }
    text += &hints(report, None);
    if claims.is_empty() && report.conclusion() == Conclusion::Unbroken {
        let claim = "No order was claimed: each law asked for order 1 or more. If you know the order, claim it with --order P: a part of the state \
             with a lower order is a defect then.";
        let _ = write!(text, "\n{}\n", paragraph(claim));
    }
    if let Some(page) = page {
        let _ = write!(text, "\nThe page is {}\n", page.display());
    }
    let _ = write!(text, "\n{verdict}\n");
    text
}

/// What there is to do about a program that fails, or that supports little; and where the page is.
fn hints(report: &ProbeReport, page: Option<&Path>) -> String {
    let mut text = String::new();
    let failed = report.laws.iter().map(|law| law.failed.len()).sum::<usize>();
    if failed > 0 {
        let failed = count(failed, "case");
        let _ = write!(text, "\nThe program failed on {failed}, about which the laws say nothing.\n");
    }
    if report.given_up {
        let _ = write!(text, "\nThe stepper failed {} times and was not started again.\n", report.failures);
    }
    let little = 2 * unsupported(report) > asked(report);
    if report.supports.is_none() && (failed > 0 || little) {
        let _ = write!(text, "\n{}\n", paragraph(NOT_TOLD));
    }
    if let Some(page) = page {
        let _ = write!(text, "\nThe page is {}\n", page.display());
    }
    text
}

/// On how many cases the stepper said that it does not support the system.
fn unsupported(report: &ProbeReport) -> usize {
    let of = |law: &LawReport| {
        let told = law.found.not_applicable.iter().filter(|(why, _)| why.starts_with(UNSUPPORTED));
        told.map(|(_, count)| count).sum::<usize>()
    };
    report.laws.iter().map(of).sum()
}

/// Reasons of this many laws are told once.
const SHARED: usize = 3;

/// How a reason begins where the stepper does not support the system.
const UNSUPPORTED: &str = "unsupported: ";

/// What to do about a program that fails on systems that it was not written for, or that supports few of them.
const NOT_TOLD: &str = "\
The stepper was asked about systems of every kind, because it did not say what it supports. If it is for some of them only, let it answer \
the first request with {\"supports\": {…}}, as PROTOCOL.md explains, or the others with {\"unsupported\": \"why\"}.";

/// The law whose orders are those of the parts of the state.
pub(super) const ORDERS: &str = "method-order";

/// The orders of each quantity.
fn orders(law: &LawReport) -> Vec<(String, String)> {
    let one = |orders: &QuantityOrders| {
        let (least, median) = (orders.least()?, orders.median()?);
        let cases = count(orders.values.len(), "case");
        let [median, least] = [median, least].map(|order| rounded(order, 2));
        Some((orders.quantity.clone(), format!("median {median}, least {least}, of {cases}")))
    };
    law.orders.iter().filter_map(one).collect()
}

/// What became of a claim.
fn confirmed(claim: &ClaimReport) -> String {
    let why = match &claim.why {
        Some(why) if claim.why_cases > 0 => format!(" ({} × {why})", claim.why_cases),
        Some(why) => format!(" ({why})"),
        None => String::new(),
    };
    let ClaimReport { law, cases, confirmed, broken, .. } = claim;
    match (broken, confirmed) {
        (0, 0) => format!("NOT CONFIRMED: by {law} on 0 of {cases} cases{why}"),
        (0, _) if confirmed == cases => format!("confirmed: by {law} on {confirmed} of {cases} cases"),
        (0, _) => format!("confirmed: by {law} on {confirmed} of {cases} cases; undecided on the others{why}"),
        _ => format!("REFUTED: {law} is broken on {broken} of {cases} cases, and confirmed on {confirmed}"),
    }
}

/// The names of some laws.
pub(super) fn names(report: &ProbeReport, wanted: impl Fn(&LawReport) -> bool) -> Vec<&'static str> {
    report.laws.iter().filter(|law| wanted(law)).map(|law| law.law.about.name).collect()
}

/// The first and the last line.
fn verdict(report: &ProbeReport) -> String {
    let broken = names(report, |law| !law.found.broken.is_empty());
    let broken = if broken.is_empty() { "NOTHING BROKEN".into() } else { format!("BROKEN ({})", some(&broken)) };
    let outcome = match report.conclusion() {
        Conclusion::Interrupted => format!("INTERRUPTED, {broken} so far"),
        Conclusion::Broken | Conclusion::Unbroken => broken,
        Conclusion::Failed => "THE PROGRAM FAILED, no law broken".into(),
        Conclusion::GivenUp => "NO VERDICT, the stepper failed too often".into(),
        Conclusion::Unconfirmed => "NO VERDICT, nothing broken, but not every claim was confirmed".into(),
        Conclusion::Undecided if unsupported(report) == asked(report) => {
            "NO VERDICT, the stepper supports none of the systems".into()
        }
        Conclusion::Undecided => "NO VERDICT, no law held on any case".into(),
        Conclusion::Confirmed => format!("{broken}, every claim confirmed"),
    };
    let mut line = format!("{outcome}: {} on {}", count(report.laws.len(), "law"), count(asked(report), "case"));
    line += &words(report);
    if matches!(report.conclusion(), Conclusion::Unbroken | Conclusion::Confirmed) {
        let silent = names(report, |law| law.found.held + law.found.broken.len() == 0);
        if !silent.is_empty() {
            line += &format!("; {} held on none ({})", count(silent.len(), "law"), some(&silent));
        }
        let held = report.laws.iter().map(|law| law.found.held).sum::<usize>();
        if 2 * held < asked(report) {
            line += &format!("; only {held} cases could be judged");
        }
        if let (None, Some(lower)) = (report.claims().first(), lower(report)) {
            line += &format!("; but {lower}");
        }
    }
    line
}

/// What the reasons say about the method as a whole: its solver is loose, or it loses digits.
fn words(report: &ProbeReport) -> String {
    let loose = names(report, |law| law.failure.as_ref().is_some_and(|failure| failure.witness().contains(LOOSE)));
    let lost = |law: &LawReport| -> usize {
        law.found.inconclusive.iter().filter(|(why, _)| why.contains(LOST_DIGITS)).map(|(_, count)| count).sum()
    };
    let losing = names(report, |law| lost(law) > 0);
    let mut words = String::new();
    if !loose.is_empty() {
        let _ = write!(words, "; {LOOSE} ({})", some(&loose));
    }
    if !losing.is_empty() {
        let cases = count(report.laws.iter().map(lost).sum::<usize>(), "case");
        let _ = write!(words, "; {LOST_DIGITS} on {cases} ({})", some(&losing));
    }
    words
}

/// Where the parts of the state have different orders: which, by the medians of their cases.
fn lower(report: &ProbeReport) -> Option<String> {
    let law = report.laws.iter().find(|law| law.law.about.name == ORDERS)?;
    let medians = law.orders.iter().filter_map(|orders| Some((&orders.quantity, orders.median()?)));
    let (least, most) =
        (medians.clone().min_by(|a, b| a.1.total_cmp(&b.1))?, medians.max_by(|a, b| a.1.total_cmp(&b.1))?);
    let (low, high) = (rounded(least.1, 2), rounded(most.1, 2));
    (most.1 - least.1 > APART).then(|| format!("the {} has order {low} where the {} has {high}", least.0, most.0))
}

/// Orders of the parts of a state that differ by more than this are not the same.
const APART: f64 = 0.5;

pub(super) fn asked(report: &ProbeReport) -> usize {
    report.laws.iter().map(|law| law.cases()).sum()
}

/// The sums of some laws; defect, bound and orders where there is one law.
fn row(name: String, laws: &[&LawReport]) -> Vec<String> {
    let failed: usize = laws.iter().map(|law| law.failed.len()).sum();
    let (line, orders) = match laws {
        [law] => (law.line(), Some(&law.slopes)),
        _ => (Line::total(laws.iter().map(|law| law.line())), None),
    };
    let number = |number: Option<f64>| number.map(|x| format!("{x:.1e}")).unwrap_or_default();
    let order = |order: Option<f64>| order.map(|order| rounded(order, 2)).unwrap_or_default();
    vec![
        name,
        line.cases.to_string(),
        line.held.to_string(),
        line.broken.to_string(),
        failed.to_string(),
        line.inconclusive.to_string(),
        line.not_applicable.to_string(),
        number(line.max_defect),
        number(line.bound),
        order(orders.and_then(QuantityOrders::least)),
        order(orders.and_then(QuantityOrders::median)),
    ]
}
