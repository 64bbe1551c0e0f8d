//! The failing cases, with what is needed to see them again.

use super::again::Failures;
use super::elements::{self, Column::*, Section, header, scrolling};
use super::files::Found;
use super::formula::typeset;
use super::numbers::*;
use super::tally::Tally;
use euler_poincare::harness::Verdict;
use euler_poincare::harness::evidence::Evidence;
use euler_poincare::laws::replay::Replayed;
use maud::{Markup, html};

/// The section.
pub fn section(found: &Found, failures: &Failures<'_>) -> Section {
    let broken: usize = found.tallies.iter().map(Tally::broken).sum();
    let none = failures.shown.is_empty() && failures.refused.is_empty() && failures.rest.is_empty();
    let body = html! {
        @if broken == 0 && none {
            p { "None." }
        }
        @for (file, replayed) in &failures.shown { (failing_case(file, replayed)) }
        @if !failures.rest.is_empty() {
            p {
                (counted(failures.rest.len(), "more file")) " of failing cases, not run again for this page: "
                (failures.rest.iter().take(20).copied().collect::<Vec<_>>().join(", "))
                @if failures.rest.len() > 20 { ", …" }
            }
        }
        @for (file, why) in &failures.refused {
            p.flag { code { (file) } " cannot be replayed: " (why) }
        }
        @if broken > 0 {
            h3 { "As they were drawn" }
            p.muted { "The first broken cases of each law, before shrinking." }
            (scrolling("Broken cases", drawn(found)))
        }
    };
    ("failures", "Failing cases", body)
}

fn drawn(found: &Found) -> Markup {
    let more = |tally: &Tally| tally.broken() - tally.first_broken.len();
    html! {
        table {
            (header(&[Text("law"), Number("case"), Number("defect"), Number("bound"), Text("witness")]))
            tbody {
                @for (planned, tally) in found.laws().filter(|(_, tally)| tally.broken() > 0) {
                    @for (index, verdict) in &tally.first_broken {
                        @if let Verdict::Broken { defect, bound, witness } = verdict { tr {
                            th scope="row" { (elements::law_link(&planned.name)) }
                            td.number { (index) }
                            td.number { (scientific(*defect)) }
                            td.number { (scientific(*bound)) }
                            td.text { (witness) }
                        } }
                    }
                    @if more(tally) > 0 {
                        tr { th scope="row" { (elements::law_link(&planned.name)) } td colspan="4" { "… and " (integer(more(tally))) " more" } }
                    }
                }
            }
        }
    }
}

fn failing_case(file: &str, failing: &Replayed) -> Markup {
    let (law, replay) = (failing.law, &failing.replay);
    let defects: Vec<&Evidence> =
        failing.evidence.iter().filter(|evidence| matches!(evidence, Evidence::Defect { .. })).collect();
    html! {
        details.failure {
            summary {
                b { (law.about.name) } ", case " (replay.index) " of seed " (replay.seed)
                @if let Some(fault) = failing.fault { ", planted " (fault.name) }
                ": " (elements::verdict(&failing.verdict))
            }
            dl.facts {
                div { dt { "law" } dd { (typeset(law.about.statement)) } }
                div { dt { "source" } dd { (typeset(law.about.source)) } }
                div { dt { "oracle" } dd { (typeset(law.about.oracle)) } }
                @if let Some(fault) = failing.fault { div { dt { "planted" } dd { (typeset(fault.what)) } } }
                @if let Verdict::Broken { witness, .. } = &failing.verdict { div { dt { "witness" } dd { (witness) } } }
            }
            @if !failing.verdict.is_broken() {
                p.flag { "This program does not find it broken: the case was saved by another one, or the mistake is mended." }
            }
            @if !defects.is_empty() { (scrolling("Defects at each precision", html! {
                table {
                    (header(&[Text("digits"), Number("defect"), Number("bound"), Number("ratio"), Text("where")]))
                    tbody { @for evidence in &defects { (defect_row(evidence)) } }
                }
            })) }
            h4 { "The case, shrunk" }
            pre { (replay.case) }
            h4 { "Run it again, in the campaign's directory" }
            pre { "euler-poincare replay " (file) }
        }
    }
}

fn defect_row(evidence: &Evidence) -> Markup {
    let Evidence::Defect { digits, defect, bound, witness, .. } = evidence else { return html! {} };
    html! {
        tr {
            th scope="row" { (digits) }
            td.number { (scientific(*defect)) }
            td.number { (scientific(*bound)) }
            td.number.alarm[defect > bound] { (scientific(defect / bound)) }
            td.text { (witness) }
        }
    }
}
