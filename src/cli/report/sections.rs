//! The sections below the verdicts.

use super::again::{Curve, Failing, Failures, Order, Shown};
use super::files::Found;
use super::page::{scrolling, section};
use super::tally::{Count, Coverage, Tally};
use super::{chart, numbers::*};
use euler_poincare::harness::convergence::{Estimate, Kind};
use euler_poincare::harness::evidence::Evidence;
use euler_poincare::harness::{Fault, Verdict};
use euler_poincare::laws;
use euler_poincare::system::{Case, FAMILIES};
use maud::{Markup, html};
use std::collections::{BTreeMap, BTreeSet};

/// Cases without a verdict, and what the generators threw away.
pub fn undecided(found: &Found) -> Markup {
    let body = html! {
        (reasons(found, "Inconclusive", "The case admits the law, and the check could not decide.", "cases", |tally| &tally.inconclusive))
        (reasons(found, "Not applicable", "The law says nothing about the case.", "cases", |tally| &tally.not_applicable))
        (reasons(
            found,
            "Rejected by the generators",
            "Values thrown away before a case was drawn; they are not cases. The share is that of the rejected values among all that were drawn.",
            "values",
            |tally| &tally.rejections,
        ))
    };
    section("undecided", "Undecided and rejected", body)
}

fn reasons(found: &Found, title: &str, what: &str, unit: &str, of: fn(&Tally) -> &BTreeMap<String, usize>) -> Markup {
    let laws: Vec<_> = found.laws().filter(|(_, tally)| !of(tally).is_empty()).collect();
    let total: usize = laws.iter().map(|(_, tally)| of(tally).values().sum::<usize>()).sum();
    // What was rejected is not among the cases.
    let whole = |tally: &Tally| tally.cases + if unit == "cases" { 0 } else { tally.rejections.values().sum() };
    let all: usize = found.tallies.iter().map(whole).sum();
    let table = html! {
        table {
            thead { tr { th scope="col" { "law" } th.number scope="col" { (unit) } th.number scope="col" { "share" } th scope="col" { "reason" } } }
            tbody {
                @for (planned, tally) in &laws {
                    @for (k, (reason, count)) in by_number(of(tally)).into_iter().enumerate() {
                        tr {
                            @if k == 0 { th scope="rowgroup" rowspan=(of(tally).len()) { (planned.name) } }
                            td.number { (integer(count)) }
                            td.number { (percent(count, whole(tally))) " %" }
                            td.text { (reason) }
                        }
                    }
                }
            }
        }
    };
    html! {
        h3 { (title) ": " (integer(total)) " " (unit) ", " (percent(total, all)) " %" }
        p.muted { (what) }
        @if laws.is_empty() { p { "None." } } @else { (scrolling(title, table)) }
    }
}

/// The largest first.
fn by_number(counts: &BTreeMap<String, usize>) -> Vec<(&str, usize)> {
    let mut list: Vec<_> = counts.iter().map(|(reason, count)| (reason.as_str(), *count)).collect();
    list.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    list
}

/// The labels of each category: those that there should be, then those that there are besides.
fn families(found: &Found) -> Vec<(String, Vec<String>)> {
    let mut families: Vec<(String, Vec<String>)> = FAMILIES
        .iter()
        .map(|(category, labels)| ((*category).to_owned(), labels.iter().map(|label| (*label).to_owned()).collect()))
        .collect();
    let seen: BTreeSet<(&str, &str)> = found
        .tallies
        .iter()
        .flat_map(|tally| &tally.coverage)
        .flat_map(|(category, labels)| labels.keys().map(move |label| (category.as_str(), label.as_str())))
        .collect();
    for (category, label) in seen {
        match families.iter_mut().find(|(name, _)| name == category) {
            Some((_, labels)) if labels.iter().any(|known| known == label) => {}
            Some((_, labels)) => labels.push(label.to_owned()),
            None => families.push((category.to_owned(), vec![label.to_owned()])),
        }
    }
    families
}

fn count(coverage: &Coverage, category: &str, label: &str) -> Count {
    coverage.get(category).and_then(|labels| labels.get(label)).copied().unwrap_or_default()
}

/// Which families of cases were judged, in total and by each law.
pub fn coverage(found: &Found) -> Markup {
    let families = families(found);
    let total = |category: &str, label: &str| {
        found.tallies.iter().map(|tally| count(&tally.coverage, category, label)).fold(Count::default(), |mut sum, count| {
            sum += count;
            sum
        })
    };
    let judged: usize = found.tallies.iter().map(Tally::judged).sum();
    let absent: Vec<String> = families
        .iter()
        .flat_map(|(category, labels)| labels.iter().map(move |label| (category, label)))
        .filter(|(category, label)| total(category, label).judged == 0)
        .map(|(category, label)| format!("{category} {label}"))
        .collect();
    let body = html! {
        p {
            "Cases that were judged, by what they are examples of. A case with several forces counts for each. "
            @if absent.is_empty() { "Every family has a judged case." }
        }
        @if !absent.is_empty() {
            p.flag { (integer(absent.len())) @if absent.len() == 1 { " family" } @else { " families" } " without a judged case: " (absent.join(", ")) "." }
        }
        div.families {
            @for (category, labels) in &families {
                @let counts: Vec<(&String, Count)> = labels.iter().map(|label| (label, total(category, label))).collect();
                @let most = counts.iter().map(|(_, count)| count.judged).max().unwrap_or(0);
                div.family {
                    h3 { (category) }
                    table {
                        thead.hidden { tr { th scope="col" { "label" } th scope="col" { "judged" } th scope="col" { "share" } } }
                        tbody {
                            @for (label, count) in counts {
                                tr.(if count.judged == 0 { "absent" } else { "" }) title=(format!("{} drawn, {} judged", integer(count.drawn), integer(count.judged))) {
                                    th scope="row" { (label) }
                                    td.gauge {
                                        span style=(format!("width:{:.1}%", 100.0 * count.judged as f64 / most.max(1) as f64)) {}
                                    }
                                    td.number { @if count.judged == 0 { "none" } @else { (integer(count.judged)) } }
                                    td.number { (percent(count.judged, judged)) " %" }
                                }
                            }
                        }
                    }
                }
            }
        }
        h3 { "By law" }
        p.muted { "A dash: no judged case. Laws do not ask for every family: orders for instance need a group and a force." }
        @for (category, labels) in &families {
            details {
                summary { (category) }
                (scrolling(category, by_law(found, category, labels)))
            }
        }
    };
    section("coverage", "Coverage of families", body)
}

fn by_law(found: &Found, category: &str, labels: &[String]) -> Markup {
    html! {
        table.compact {
            thead { tr { th scope="col" { "law" } @for label in labels { th.number scope="col" { (label) } } } }
            tbody {
                @for (planned, tally) in found.laws() {
                    tr {
                        th scope="row" { (planned.name) }
                        @for label in labels {
                            @let judged = count(&tally.coverage, category, label).judged;
                            @if judged == 0 { td.number.none { "–" } } @else { td.number { (integer(judged)) } }
                        }
                    }
                }
            }
        }
    }
}

/// Error against step of some cases of the order laws.
pub fn orders(orders: &[Order]) -> Markup {
    let body = html! {
        @if orders.is_empty() {
            p { "No law of orders has a judged case here, or no plots were asked for." }
        } @else {
            p {
                "Errors against the step, in 32 digits, of cases drawn again from the seed and measured by this program. "
                "The dashed lines have the slopes that were predicted."
            }
            (legend())
            @for order in orders {
                h3 { (order.law.name) }
                p.muted { (order.law.statement) " (" (order.law.source) ")" }
                div.plots { @for case in &order.cases { (figure(order.law.name, case)) } }
            }
        }
    };
    section("orders", "Orders", body)
}

fn legend() -> Markup {
    let kinds = [
        (Kind::Asymptotic, "on the line: asymptotic"),
        (Kind::PreAsymptotic, "too coarse: pre-asymptotic"),
        (Kind::Noise, "not clear of round-off: noise"),
    ];
    html! {
        ul.legend {
            @for (kind, text) in kinds {
                li { svg.key.series-0 viewBox="0 0 14 14" aria-hidden="true" { (chart::mark(7.0, 7.0, kind, 0)) } (text) }
            }
        }
    }
}

fn figure(law: &str, shown: &Shown) -> Markup {
    let title = format!("{law}, case {}", shown.index);
    html! {
        figure {
            figcaption {
                b { "Case " (shown.index) } ", " (shown.chosen) ": " (plain(&shown.verdict))
                @if !shown.agrees { span.flag { "The campaign has another verdict." } }
            }
            @if shown.curves.is_empty() {
                p.muted { "The check measured no errors." }
            } @else {
                (chart::order(&format!("{title}: error against step"), &shown.curves))
                ul.curves {
                    @for (k, curve) in shown.curves.iter().enumerate() {
                        li {
                            svg.key class=(chart::series(k)) viewBox="0 0 14 14" aria-hidden="true" { (chart::mark(7.0, 7.0, Kind::Asymptotic, k)) }
                            (slope(curve))
                        }
                    }
                }
            }
            @match &shown.case {
                Ok(case) => details { summary { "the case" } pre { (case) } },
                Err(why) => p.flag { (why) },
            }
        }
    }
}

fn slope(curve: &Curve) -> Markup {
    let noughts = curve.levels.iter().filter(|(level, _)| level.error.is_nan() || level.error <= 0.0).count();
    html! {
        (curve.quantity) ": "
        @match &curve.estimate {
            Estimate::Slope { value, low, high, .. } => {
                "slope " b { (format!("{value:.3}")) } (format!(" in [{low:.3}, {high:.3}]"))
            }
            Estimate::Inconclusive { why, .. } => { "no slope: " (why) }
        }
        @if let Some(expected) = curve.expected { ", predicted " b { (expected) } }
        @if noughts > 0 { "; " (counted(noughts, "level")) " without an error cannot be drawn" }
    }
}

fn plain(verdict: &Verdict) -> Markup {
    let numbers = |defect: f64, bound: f64| {
        format!("defect {}, bound {}, ratio {}", scientific(defect), scientific(bound), scientific(verdict.ratio().unwrap_or(f64::NAN)))
    };
    match verdict {
        Verdict::Holds { defect, bound } => html! { "holds, " (numbers(*defect, *bound)) },
        Verdict::Broken { defect, bound, .. } => html! { span.alarm { "broken" } ", " (numbers(*defect, *bound)) },
        Verdict::Inconclusive { why } => html! { "inconclusive: " (why) },
        Verdict::NotApplicable { why } => html! { "not applicable: " (why) },
    }
}

/// After how many cases each planted fault was caught.
pub fn faults(found: &Found) -> Markup {
    let body = match &found.faults {
        None => html! {
            p { "Not tried here. " code { "euler-poincare verify --faults --out DIR" } " plants each fault that the laws know, and writes after how many cases each was caught." }
        },
        Some(faults) => {
            let missed: Vec<_> = faults.iter().filter(|fault| fault.caught_after.is_none()).collect();
            let tried: BTreeSet<(&str, &str)> = faults.iter().map(|row| (row.law.as_str(), row.fault.as_str())).collect();
            let known = found.manifest.laws.iter().filter_map(|law| laws::named(&law.name));
            let untried: Vec<String> = known
                .flat_map(|law| law.faults.iter().map(move |fault| (law.name, fault.name)))
                .filter(|row| !tried.contains(row))
                .map(|(law, fault)| format!("{fault} in {law}"))
                .collect();
            let sizes = faults.iter().any(|fault| fault.smallest_size.is_some());
            let most = faults.iter().filter_map(|fault| fault.caught_after).max().unwrap_or(0);
            html! {
                p {
                    (counted(faults.len(), "planted fault")) ": "
                    @if missed.is_empty() { "each was caught, the last after " (cases(most)) "." }
                    @else { strong.alarm { (integer(missed.len())) " missed" } "." }
                }
                @if !untried.is_empty() {
                    p.flag { "Known to the laws of this campaign and not tried: " (untried.join(", ")) "." }
                }
                @if !faults.is_empty() { (scrolling("Planted faults", html! {
                    table {
                        thead { tr {
                            th scope="col" { "law" } th scope="col" { "fault" } th.number scope="col" { "caught after" }
                            @if sizes { th.number scope="col" { "smallest size" } }
                            th scope="col" { "what is wrong" } th scope="col" { "visible on" }
                        } }
                        tbody {
                            @for row in faults {
                                @let known = laws::named(&row.law).and_then(|law| law.faults.iter().find(|fault| fault.name == row.fault));
                                tr.(if row.caught_after.is_none() { "broken" } else { "" }) {
                                    th scope="row" { (row.law) }
                                    td { (row.fault) }
                                    td.number { @match row.caught_after { Some(after) => (integer(after)), None => span.alarm { "missed" } } }
                                    @if sizes { td.number { (row.smallest_size.map(|size| format!("{size:.0e}")).unwrap_or_default()) } }
                                    td.text { (known.map_or("", |fault: &Fault| fault.what)) }
                                    td.text { (known.map_or("", |fault: &Fault| fault.visible_on)) }
                                }
                            }
                        }
                    }
                })) }
            }
        }
    };
    section("faults", "Planted faults", body)
}

/// The failing cases, with what is needed to see them again.
pub fn failures(found: &Found, failures: &Failures<'_>) -> Markup {
    let broken: usize = found.tallies.iter().map(|tally| tally.broken).sum();
    let none = failures.shown.is_empty() && failures.refused.is_empty() && failures.rest.is_empty();
    let body = html! {
        @if broken == 0 && none {
            p { "None." }
        }
        @for failing in &failures.shown { (failing_case(failing)) }
        @if !failures.rest.is_empty() {
            p { (counted(failures.rest.len(), "more file")) " of failing cases, not run again for this page: " (failures.rest.iter().take(20).copied().collect::<Vec<_>>().join(", ")) @if failures.rest.len() > 20 { ", …" } }
        }
        @for (file, why) in &failures.refused {
            p.flag { code { (file) } " cannot be replayed: " (why) }
        }
        @if broken > 0 {
            h3 { "As they were drawn" }
            p.muted { "The first broken cases of each law, before shrinking." }
            (scrolling("Broken cases", html! {
                table {
                    thead { tr {
                        th scope="col" { "law" } th.number scope="col" { "case" } th.number scope="col" { "defect" }
                        th.number scope="col" { "bound" } th scope="col" { "witness" }
                    } }
                    tbody {
                        @for (planned, tally) in found.laws().filter(|(_, tally)| tally.broken > 0) {
                            @for (index, (judged, witness)) in &tally.broken_cases {
                                tr {
                                    th scope="row" { (planned.name) }
                                    td.number { (index) }
                                    td.number { (scientific(judged.defect)) }
                                    td.number { (scientific(judged.bound)) }
                                    td.text { (witness) }
                                }
                            }
                            @if tally.broken > tally.broken_cases.len() {
                                tr { th scope="row" { (planned.name) } td colspan="4" { "… and " (integer(tally.broken - tally.broken_cases.len())) " more" } }
                            }
                        }
                    }
                }
            }))
        }
    };
    section("failures", "Failing cases", body)
}

fn failing_case(failing: &Failing<'_>) -> Markup {
    let (law, replay) = (failing.law, failing.replay);
    let defects: Vec<&Evidence> =
        failing.evidence.iter().filter(|evidence| matches!(evidence, Evidence::Defect { .. })).collect();
    html! {
        details.failure {
            summary {
                b { (law.name) } ", case " (replay.index) " of seed " (replay.seed)
                @if let Some(fault) = failing.fault { ", planted " (fault.name) }
                ": " (plain(&failing.verdict))
            }
            dl.facts {
                div { dt { "law" } dd { (law.statement) } }
                div { dt { "source" } dd { (law.source) } }
                div { dt { "oracle" } dd { (law.oracle) } }
                @if let Some(fault) = failing.fault { div { dt { "planted" } dd { (fault.what) } } }
                @if let Verdict::Broken { witness, .. } = &failing.verdict { div { dt { "witness" } dd { (witness) } } }
            }
            @if !failing.verdict.is_broken() {
                p.flag { "This program does not find it broken: the case was saved by another one, or the mistake is mended." }
            }
            @if !defects.is_empty() { (scrolling("Defects at each precision", html! {
                table {
                    thead { tr {
                        th scope="col" { "digits" } th.number scope="col" { "defect" } th.number scope="col" { "bound" }
                        th.number scope="col" { "ratio" } th scope="col" { "where" }
                    } }
                    tbody { @for evidence in &defects { (defect_row(evidence)) } }
                }
            })) }
            h4 { "The case, shrunk" }
            pre { (replay.case) }
            h4 { "Run it again, in the campaign's directory" }
            pre { "euler-poincare replay " (failing.file) }
            @if let Some(snippet) = snippet(&replay.case) {
                h4 { "As a program" }
                pre { (snippet) }
            }
        }
    }
}

fn snippet(_: &Case) -> Option<String> {
    None
}

fn defect_row(evidence: &Evidence) -> Markup {
    let Evidence::Defect { digits, defect, bound, witness } = evidence else { return html! {} };
    html! {
        tr {
            th scope="row" { (digits) }
            td.number { (scientific(*defect)) }
            td.number { (scientific(*bound)) }
            td.number.(if defect > bound { "alarm" } else { "" }) { (scientific(defect / bound)) }
            td.text { (witness) }
        }
    }
}

/// Where the time went.
pub fn timings(found: &Found) -> Markup {
    let Some(times) = &found.times else {
        return section("timings", "Timings", html! { p { "There is no " code { "timings.jsonl" } "." } });
    };
    let mut rows: Vec<_> = times.iter().collect();
    rows.sort_by(|a, b| b.1.total.total_cmp(&a.1.total));
    let total: f64 = rows.iter().map(|(_, time)| time.total).sum();
    let checks: usize = rows.iter().map(|(_, time)| time.checks).sum();
    let body = html! {
        p {
            "The only numbers of this page that depend on the machine and on the day; no verdict does. "
            (duration(total)) " in " (counted(checks, "check")) ", summed over the threads."
        }
        @if !rows.is_empty() { (scrolling("Timings", html! {
            table.timings {
                thead { tr {
                    th scope="col" { "law" } th scope="col" { "share" } th.number scope="col" { "total" }
                    th.number scope="col" { "checks" } th.number scope="col" { "mean" } th.number scope="col" { "longest" }
                } }
                tbody {
                    @for (law, time) in rows {
                        tr {
                            th scope="row" { (law) }
                            td.gauge { span style=(format!("width:{:.1}%", 100.0 * time.total / total.max(f64::MIN_POSITIVE))) {} }
                            td.number { (duration(time.total)) }
                            td.number { (integer(time.checks)) }
                            td.number { (duration(time.total / time.checks.max(1) as f64)) }
                            td.number { (duration(time.longest)) }
                        }
                    }
                }
            }
        })) }
    };
    section("timings", "Timings", body)
}
