//! The page of `probe --report DIR`: what was found about a stepper, to be attached to an issue of its package.

use super::super::failure::shell;
use super::super::levels::rounded;
use super::super::report::chart::{self, Curve};
use super::super::report::elements::{self, Column::*, Document, Outcome, Section, header, law_link, scrolling};
use super::super::report::formula::typeset;
use super::super::report::numbers::*;
use super::super::report::verdicts::{self, alarming, cell};
use super::super::report::{orders, undecided};
use super::super::table::seconds;
use super::super::version::VERSION;
use super::failure::{origin, system, values};
use super::text::{ORDERS, names};
use super::{Arguments, Kept, again};
use euler_poincare::external::{ClaimReport, Compared, Conclusion, Examined, LawReport, ProbeReport, Slopes};
use euler_poincare::harness::Line;
use euler_poincare::harness::convergence::LevelKind;
use euler_poincare::system::Case;
use maud::{Markup, html};

/// A run of `probe`.
pub struct Probed<'a> {
    /// What was asked.
    pub arguments: &'a Arguments,
    /// What was found.
    pub report: &'a ProbeReport,
    /// One for each law.
    pub kept: &'a [Vec<Kept>],
    /// The text of the system file, where there is one.
    pub system: Option<&'a str>,
    /// The time limit for an answer, in seconds.
    pub timeout: f64,
}

impl Probed<'_> {
    /// The page as text.
    pub fn page(&self) -> String {
        let title = format!("Probe of {}", shell(&self.arguments.command));
        let laws = self.report.laws.iter().map(|law| (law.law.about.name, &law.found, law.cases()));
        let sections = [
            self.verdicts(),
            self.claims(),
            self.orders(),
            undecided::section("Undecided", &laws.collect::<Vec<_>>(), SILENT, false),
            self.failures(),
            self.again(),
        ];
        let (outcome, head) = (self.outcome(), self.head());
        Document { title: &title, outcome, head, sections: &sections, script: false }.text()
    }

    fn outcome(&self) -> Outcome {
        let laws = &self.report.laws;
        let asked = format!("{} on {}", counted(laws.len(), "law"), cases(laws.iter().map(|law| law.cases()).sum()));
        let broken = names(self.report, |law| !law.found.broken.is_empty());
        let failed = names(self.report, |law| !law.failed.is_empty());
        let broken = match broken.as_slice() {
            [] => "Nothing is broken".to_owned(),
            [law] => format!("One law is broken, {law}"),
            broken => format!("{} laws are broken: {}", broken.len(), broken.join(", ")),
        };
        let (class, text) = match self.report.conclusion() {
            Conclusion::Interrupted => ("empty", format!("Interrupted. {broken} so far")),
            Conclusion::Broken => ("broken", broken),
            Conclusion::Failed => ("broken", format!("The program failed under {}. {broken}", failed.join(", "))),
            Conclusion::GivenUp => ("empty", "No verdict: the program failed too often".into()),
            Conclusion::Unconfirmed => ("empty", format!("No verdict: {broken}, but not every claim was confirmed")),
            Conclusion::Undecided => ("empty", "No verdict: no law held on any case".into()),
            Conclusion::Confirmed => ("held", format!("{broken}, and every claim is confirmed")),
            Conclusion::Unbroken => ("held", broken),
        };
        Outcome { class, text: format!("{text} ({asked}).") }
    }

    fn head(&self) -> Markup {
        let laws = &self.report.laws;
        let failed: usize = laws.iter().map(|law| law.failed.len()).sum();
        let found = Line::total(laws.iter().map(LawReport::line));
        html! {
            (verdicts::figures(&found, html! {
                div.bad[failed > 0] { dt { "program failed" } dd { (integer(failed)) } }
            }))
            dl.facts {
                div { dt { "program" } dd { code { (shell(&self.arguments.command)) } } }
                @if self.system.is_some() {
                    div { dt { "system" } dd { "one, " a href="#again" { "below" } } }
                } @else {
                    div { dt { "seed" } dd { (self.arguments.seed) } }
                    div { dt { "systems for each law" } dd { (self.arguments.cases) ", random" } }
                }
                @if self.report.claims.tolerance > 0.0 {
                    div { dt { "tolerance claimed" } dd { (scientific(self.report.claims.tolerance)) } }
                }
                div { dt { "time limit for an answer" } dd { (seconds(self.timeout)) } }
                @if let Some(supports) = &self.report.supports { div { dt { "supports" } dd { code { (serde_json::to_string(supports).unwrap_or_default()) } } } }
                div { dt { "judged by" } dd { "euler-poincare " (VERSION) } }
            }
            p { (typeset(ASKED)) }
        }
    }

    fn verdicts(&self) -> Section {
        let laws: Vec<_> = self.report.laws.iter().map(row).collect();
        let table = html! {
            p.muted {
                "Defects of identities are in units of rounding, u = 1.1e-16; those of orders are distances of slopes of log error \
                 against log step. A law is broken where the ratio of defect and bound is above 1."
            }
            (verdicts::table(&["program failed", "least order", "median order"].map(|head| (head, None)), &laws))
        };
        ("verdicts", "Laws", table)
    }

    fn claims(&self) -> Section {
        let claims = self.report.claims();
        let table = html! {
            table {
                (header(&[Text("claim"), Text("verdict"), Text("law"), Number("confirmed on"), Number("refuted on"), Number("of"),
                    Text("most frequent reason of the others")]))
                tbody { @for claim in &claims { (claim_row(claim)) } }
            }
        };
        let body = html! {
            @if claims.is_empty() {
                p {
                    "Nothing was claimed: each law asked for order 1 or more. The measured orders are "
                    a href="#orders" { "below" } "."
                }
            } @else {
                (scrolling("Claims", table))
            }
        };
        ("claims", "Claims", body)
    }

    fn orders(&self) -> Section {
        let law = self.report.laws.iter().find(|law| law.law.about.name == ORDERS);
        let Some(law) = law.filter(|law| !law.measured.is_empty()) else {
            return ("orders", "Orders", html! { p { "No errors were measured." } });
        };
        let claimed = self.report.claims.order;
        let table = html! {
            table {
                (header(&[Text("part of the state"), Number("median order"), Number("least order"), Number("systems")]))
                tbody {
                    @for orders in &law.orders {
                        tr {
                            th scope="row" { (orders.quantity) }
                            td.number { (order(orders.median())) }
                            td.number { (order(orders.least())) }
                            td.number { (orders.values.len()) }
                        }
                    }
                }
            }
        };
        let body = html! {
            p {
                "The order of a part of the state is the slope of its error after two steps, less one. "
                @match claimed {
                    Some(order) => { "Order " b { (order) } " is claimed: the slope of the dashed lines, less one." }
                    None => { "No order is claimed." }
                }
            }
            @if !law.orders.is_empty() { (scrolling("Orders", table)) }
            h3 { "Errors against the step" }
            (orders::legend())
            div.plots { @for case in &law.measured { (measured(case, claimed)) } }
        };
        ("orders", "Orders", body)
    }

    fn failures(&self) -> Section {
        let body = html! {
            @if self.kept.iter().all(Vec::is_empty) { p { "None." } }
            @for (law, kept) in self.report.laws.iter().zip(self.kept) {
                @for (broken, kept) in law.shown().zip(kept) { (self.failure(law, broken, kept)) }
            }
        };
        ("failures", "Broken laws", body)
    }

    /// A broken law, or one under which the program failed.
    fn failure(&self, law: &LawReport, broken: &Examined, kept: &Kept) -> Markup {
        let about = &law.law.about;
        // What is conserved has no slope that is claimed.
        let claimed = self.report.claims.order.filter(|_| about.name == ORDERS);
        let (count, of) =
            if broken.failed { (law.failed.len(), "the program failed") } else { (law.found.broken.len(), "broken") };
        html! {
            details.failure open {
                summary {
                    b { (about.name) } ": "
                    span.alarm { (of) }
                    " on " (count) " of " (cases(law.cases()))
                }
                dl.facts {
                    div { dt { "law" } dd { (typeset(about.statement)) } }
                    div { dt { "source" } dd { (typeset(about.source)) } }
                    @if let Some(claim) = &law.claim { div { dt { "claim" } dd { (claim) } } }
                    @if !broken.failed { div { dt { "verdict" } dd { (elements::verdict(&broken.verdict)) } } }
                    div { dt { @if broken.failed { "why" } @else { "witness" } } dd { (broken.witness()) } }
                }
                @if !broken.slopes.is_empty() {
                    div.plots { figure { (errors(about.name, &broken.slopes, claimed)) } }
                }
                @if let Some(exchange) = &broken.exchange { (exchanged(exchange)) }
                h4 { (origin(broken, &format!("The system: case {}", broken.index))) }
                (facts(&broken.case))
                (record(kept))
            }
        }
    }

    fn again(&self) -> Section {
        let body = html! {
            p { "The whole run, with the program in the place where it was:" }
            pre.line { (again()) }
            @if let Some(system) = self.system {
                p { "The system file:" }
                pre { (system) }
            }
            p {
                "The systems follow from the seed: the same command with the same version asks the same questions. The program reads a \
                 request in JSON on a line of standard input, and writes its answer on a line of standard output; a request of "
                a href="#failures" { "a broken law" } " can be given to it by hand, without this command."
            }
        };
        ("again", "Run it again", body)
    }
}

/// Where a law is not applicable.
const SILENT: &str = "The law says nothing about the case, or the program does not support it.";

/// What is asked.
const ASKED: &str = "\
The program was asked for single steps of mechanical systems on Lie groups: d/dt l'(η) = ad*_η l'(η) + f(t, η), ġ = g η, with the \
momentum μ = l'(η) in the body frame and the attitude g. The laws say how its errors shrink with the step, what it conserves, and how \
it treats symmetries.";

fn order(value: Option<f64>) -> String {
    value.map_or("–".into(), |order| rounded(order, 2))
}

/// A law of the table.
fn row(law: &LawReport) -> verdicts::Row<'_> {
    let number = |label, value: Option<f64>| cell(label, html! { (order(value)) });
    let more = vec![
        alarming("program failed", law.failed.len()),
        number("least order", law.slopes.least()),
        number("median order", law.slopes.median()),
    ];
    let about = &law.law.about;
    verdicts::Row { name: about.name, about: Some(about), line: law.line(), missing: 0, more }
}

fn claim_row(claim: &ClaimReport) -> Markup {
    let verdict = match (claim.broken, claim.confirmed) {
        (0, 0) => html! { span.flag { "not confirmed" } },
        (0, _) => html! { b { "confirmed" } },
        _ => html! { span.alarm { "refuted" } },
    };
    html! {
        tr {
            th scope="row" { (claim.claim) }
            td { (verdict) }
            td { @if claim.cases > 0 { (law_link(claim.law)) } @else { (claim.law) } }
            td.number { (claim.confirmed) }
            td.number { (claim.broken) }
            td.number { (claim.cases) }
            td.text {
                @if let Some(why) = &claim.why {
                    @if claim.why_cases > 0 { (claim.why_cases) " × " }
                    (why)
                }
            }
        }
    }
}

/// The curve of some errors; the errors of two steps fall by one power more than the order.
fn curve(slopes: &Slopes, claimed: Option<u32>) -> Curve {
    let why = || slopes.why.clone().unwrap_or_default();
    Curve {
        quantity: slopes.quantity.clone(),
        levels: slopes.levels.iter().map(|level| (level.h.abs(), level.error, level.mark)).collect(),
        found: slopes.order.zip(slopes.interval).ok_or_else(why),
        expected: claimed,
        excess: 1,
    }
}

/// The errors of all quantities as a figure, with their orders and their levels.
fn errors(label: &str, slopes: &[Slopes], claimed: Option<u32>) -> Markup {
    let curves: Vec<Curve> = slopes.iter().map(|slopes| curve(slopes, claimed)).collect();
    html! {
        (chart::order(label, &curves, ["order", "claimed"]))
        details {
            summary { "the levels" }
            @for slopes in slopes { (scrolling(&format!("Levels: {}", slopes.quantity), levels(slopes))) }
        }
    }
}

fn levels(slopes: &Slopes) -> Markup {
    let what = |mark: LevelKind| match mark {
        LevelKind::Asymptotic => "",
        LevelKind::PreAsymptotic => "too coarse",
        LevelKind::Noise => "not clear of rounding",
    };
    html! {
        table.compact {
            caption { "Errors of the " (slopes.quantity) }
            (header(&[Number("steps"), Number("h"), Number("error"), Number("order"), Text("")]))
            tbody {
                @for level in &slopes.levels {
                    tr {
                        td.number { (level.steps) }
                        td.number { (format!("{:.3e}", level.h)) }
                        td.number { (format!("{:.2e}", level.error)) }
                        td.number { (level.order.map_or(String::new(), |order| format!("{order:.3}"))) }
                        td.muted { (what(level.mark)) }
                    }
                }
            }
        }
    }
}

fn measured(case: &Examined, claimed: Option<u32>) -> Markup {
    html! {
        figure {
            figcaption { b { "System " (case.index) } ": " (elements::verdict(&case.verdict)) }
            (errors(&format!("system {}", case.index), &case.slopes, claimed))
            details { summary { "the system" } (facts(&case.case)) }
        }
    }
}

/// A system, without a method: that is the program's.
fn facts(case: &Case) -> Markup {
    html! { dl.facts { @for (name, value) in system(case) { div { dt { (name) } dd { code { (value) } } } } } }
}

/// A line of JSON that may be broken after its commas; copied, it is one line.
fn breakable(line: &str) -> Markup {
    html! { @for part in line.split_inclusive(',') { (part) wbr; } }
}

fn exchanged(exchange: &Compared) -> Markup {
    let name = if exchange.of_scheme { "step of the scheme" } else { "solution" };
    html! {
        h4 { "One request: " (exchange.what) }
        pre.line { (breakable(&exchange.request)) }
        h4 { "Its answer" }
        pre.line { @if exchange.answer.is_empty() { "(none)" } @else { (breakable(&exchange.answer)) } }
        @if let Some(solution) = &exchange.solution {
            h4 { "The " (name) " at the end of this step" }
            pre.line { (breakable(&values(solution, |x| format!("{x:?}")))) }
        }
        @if let Some(difference) = &exchange.difference {
            h4 { "The answer less the " (name) }
            pre.line { (breakable(&values(difference, |x| format!("{x:.1e}")))) }
        }
    }
}

fn record(kept: &Kept) -> Markup {
    html! {
        h4 { "Run this case again" }
        pre.line { "euler-poincare probe --replay " (kept.file) }
        @if let Some(why) = &kept.not_saved { p.flag { "It was not saved: " (why) } }
        details {
            summary { "the file " code { (kept.file) } }
            pre { (kept.text) }
        }
    }
}
