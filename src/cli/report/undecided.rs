//! Cases without a verdict, and what the generators threw away.

use super::elements::{self, Column::*, header, scrolling};
use super::files::Found;
use super::numbers::*;
use super::tally::Tally;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// The section.
pub fn section(found: &Found) -> Markup {
    let body = html! {
        (reasons(found, &INCONCLUSIVE))
        (reasons(found, &NOT_APPLICABLE))
        (reasons(found, &REJECTED))
    };
    elements::section("undecided", "Undecided and rejected", body)
}

/// Reasons that are counted.
struct Reasons {
    title: &'static str,
    what: &'static str,
    unit: &'static str,
    of: fn(&Tally) -> &BTreeMap<String, usize>,
    /// What a share is a share of.
    whole: fn(&Tally) -> usize,
}

const INCONCLUSIVE: Reasons = Reasons {
    title: "Inconclusive",
    what: "The case admits the law, and the check could not decide.",
    unit: "cases",
    of: |tally| &tally.found.inconclusive,
    whole: |tally| tally.found.cases,
};

const NOT_APPLICABLE: Reasons = Reasons {
    title: "Not applicable",
    what: "The law says nothing about the case.",
    unit: "cases",
    of: |tally| &tally.found.not_applicable,
    whole: |tally| tally.found.cases,
};

const REJECTED: Reasons = Reasons {
    title: "Rejected by the generators",
    what: "Values thrown away before a case was drawn; they are not cases. The share is that among all values that were drawn.",
    unit: "values",
    of: |tally| &tally.found.rejections,
    whole: |tally| tally.found.cases + tally.found.rejections.values().sum::<usize>(),
};

fn reasons(found: &Found, reasons: &Reasons) -> Markup {
    let Reasons { title, what, unit, of, whole } = *reasons;
    let laws: Vec<_> = found.laws().filter(|(_, tally)| !of(tally).is_empty()).collect();
    let total: usize = laws.iter().map(|(_, tally)| of(tally).values().sum::<usize>()).sum();
    let all: usize = found.tallies.iter().map(whole).sum();
    let table = html! {
        table {
            (header(&[Text("law"), Number(unit), Number("share"), Text("reason")]))
            tbody {
                @for (planned, tally) in &laws {
                    @for (k, (reason, count)) in by_number(of(tally)).into_iter().enumerate() {
                        tr {
                            @if k == 0 { th scope="rowgroup" rowspan=(of(tally).len()) { (elements::law_link(&planned.name)) } }
                            td.number { (integer(count)) }
                            td.number { (share(count, whole(tally))) }
                            td.text { (reason) }
                        }
                    }
                }
            }
        }
    };
    html! {
        h3 { (title) ": " (integer(total)) " " (unit) ", " (share(total, all)) }
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
