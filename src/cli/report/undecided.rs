//! Cases without a verdict, and what the generators threw away.

use super::elements::{self, Column::*, Section, header, scrolling};
use super::numbers::*;
use euler_poincare::harness::Summary;
use maud::{Markup, html};
use std::collections::BTreeMap;

/// The section of some laws, with the number of the cases of each; `silent` says where a law is not applicable. With what was `rejected` if that
/// is known.
pub fn section<C>(title: &'static str, laws: &[(&str, &Summary<C>, usize)], silent: &str, rejected: bool) -> Section {
    let inconclusive: Vec<_> = laws.iter().map(|(law, found, cases)| (*law, &found.inconclusive, *cases)).collect();
    let not_applicable: Vec<_> = laws.iter().map(|(law, found, cases)| (*law, &found.not_applicable, *cases)).collect();
    let drawn = |found: &Summary<C>| found.cases + found.rejections.values().sum::<usize>();
    let rejections: Vec<_> = laws.iter().map(|(law, found, _)| (*law, &found.rejections, drawn(found))).collect();
    let body = html! {
        (reasons("Inconclusive", "The law applies to the case, and the check could not decide.", "cases", &inconclusive))
        (reasons("Not applicable", silent, "cases", &not_applicable))
        @if rejected { (reasons("Rejected by the generators", REJECTED, "values", &rejections)) }
    };
    ("undecided", title, body)
}

const REJECTED: &str = "Values thrown away before a case was drawn; they are not cases. The share is that among all values that were drawn.";

/// A law, its reasons with their numbers, and what a share is a share of.
type Reasons<'a> = (&'a str, &'a BTreeMap<String, usize>, usize);

/// Reasons that are counted.
fn reasons(title: &str, what: &str, unit: &str, laws: &[Reasons<'_>]) -> Markup {
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
