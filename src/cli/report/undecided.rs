//! Cases without a verdict, and what the generators threw away.

use super::elements::{self, Column::*, header, scrolling};
use super::files::Found;
use super::numbers::*;
use euler_poincare::harness::Summary;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// The section.
pub fn section(found: &Found) -> Markup {
    type Counts = fn(&Summary<()>) -> &BTreeMap<String, usize>;
    let laws = |of: Counts, whole: fn(&Summary<()>) -> usize| -> Vec<Reasons<'_>> {
        found.laws().map(|(law, tally)| (law.name.as_str(), of(&tally.found), whole(&tally.found))).collect()
    };
    let inconclusive = laws(|law| &law.inconclusive, |law| law.cases);
    let not_applicable = laws(|law| &law.not_applicable, |law| law.cases);
    let rejected = laws(|law| &law.rejections, |law| law.cases + law.rejections.values().sum::<usize>());
    let body = html! {
        (reasons("Inconclusive", "The case admits the law, and the check could not decide.", "cases", &inconclusive))
        (reasons("Not applicable", "The law says nothing about the case.", "cases", &not_applicable))
        (reasons("Rejected by the generators", REJECTED, "values", &rejected))
    };
    elements::section("undecided", "Undecided and rejected", body)
}

const REJECTED: &str = "Values thrown away before a case was drawn; they are not cases. The share is that among all values that were drawn.";

/// A law, its reasons with their numbers, and what a share is a share of.
pub type Reasons<'a> = (&'a str, &'a BTreeMap<String, usize>, usize);

/// Reasons that are counted.
pub fn reasons(title: &str, what: &str, unit: &str, laws: &[Reasons<'_>]) -> Markup {
    let total: usize = laws.iter().flat_map(|(_, reasons, _)| reasons.values()).sum();
    let all: usize = laws.iter().map(|(.., whole)| whole).sum();
    let table = html! {
        table {
            (header(&[Text("law"), Number(unit), Number("share"), Text("reason")]))
            tbody {
                @for (law, reasons, whole) in laws {
                    @for (k, (reason, count)) in by_number(reasons).into_iter().enumerate() {
                        tr {
                            @if k == 0 { th scope="rowgroup" rowspan=(reasons.len()) { (elements::law_link(law)) } }
                            td.number { (integer(count)) }
                            td.number { (share(count, *whole)) }
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
        @if total == 0 { p { "None." } } @else { (scrolling(title, table)) }
    }
}

/// The largest first.
fn by_number(counts: &BTreeMap<String, usize>) -> Vec<(&str, usize)> {
    let mut list: Vec<_> = counts.iter().map(|(reason, count)| (reason.as_str(), *count)).collect();
    list.sort_by_key(|(_, count)| std::cmp::Reverse(*count));
    list
}
