//! After how many cases each planted fault was caught.

use super::super::faults::Caught;
use super::elements::{self, Column::*, Section, header, scrolling};
use super::files::Found;
use super::formula::typeset;
use super::numbers::*;
use euler_poincare::harness::Law;
use euler_poincare::laws;
use maud::{Markup, html};
use std::collections::BTreeSet;

/// A longer list of faults is folded.
const SHORT: usize = 6;

/// The section.
pub fn section(found: &Found) -> Section {
    let body = match &found.faults {
        None => html! {
            p {
                "Not tried here. " code { "euler-poincare verify --faults --out DIR" }
                " plants each fault that the laws know, and writes after how many cases each was caught."
            }
        },
        Some(faults) => html! {
            (outcome(faults))
            (untried(found, faults))
            @if !faults.is_empty() { (scrolling("Planted faults", table(faults))) }
        },
    };
    ("faults", "Planted faults", body)
}

fn outcome(faults: &[Caught]) -> Markup {
    let missed = faults.iter().filter(|fault| fault.caught_after.is_none()).count();
    let most = faults.iter().filter_map(|fault| fault.caught_after).max().unwrap_or(0);
    html! {
        p {
            (counted(faults.len(), "planted fault")) ": "
            @if missed == 0 { "each was caught, the last after " (cases(most)) "." }
            @else { strong.alarm { (integer(missed)) " missed" } "." }
        }
    }
}

/// The faults that were left out.
fn untried(found: &Found, faults: &[Caught]) -> Markup {
    let tried: BTreeSet<(&str, &str)> = faults.iter().map(|row| (row.law.as_str(), row.fault.as_str())).collect();
    let known = found.manifest.laws.iter().filter_map(|law| laws::named(&law.name));
    let untried: Vec<(&str, Vec<&str>)> = known
        .map(|law| {
            let names = law.about.faults.iter().map(|fault| fault.name);
            (law.about.name, names.filter(|fault| !tried.contains(&(law.about.name, *fault))).collect())
        })
        .filter(|(_, faults): &(_, Vec<_>)| !faults.is_empty())
        .collect();
    let number: usize = untried.iter().map(|(_, faults)| faults.len()).sum();
    html! {
        @if number > 0 {
            details.flag open[number <= SHORT] {
                summary { "Known to the laws of this campaign and not tried: " (counted(number, "fault")) }
                ul { @for (law, faults) in &untried { li { (elements::law_link(law)) ": " (faults.join(", ")) } } }
            }
        }
    }
}

fn table(faults: &[Caught]) -> Markup {
    let sizes = faults.iter().any(|fault| fault.smallest_size.is_some());
    let known = |row: &Caught| laws::named(&row.law)?.fault(&row.fault);
    let mut columns = vec![Text("law"), Text("fault"), Number("caught after"), Number("smallest size")];
    columns.truncate(if sizes { 4 } else { 3 });
    columns.extend([Text("what is wrong"), Text("visible on")]);
    html! {
        table {
            (header(&columns))
            tbody {
                @for row in faults {
                    tr.broken[row.caught_after.is_none()] {
                        th scope="row" { (elements::law_link(&row.law)) }
                        td { (row.fault) }
                        td.number { @match row.caught_after { Some(n) => (integer(n)), None => span.alarm { "missed" } } }
                        @if sizes { td.number { @if let Some(size) = row.smallest_size { (format!("{size:.0e}")) } } }
                        td.text { (typeset(known(row).map_or("", |fault| fault.what))) }
                        td.text { (typeset(known(row).map_or("", |fault| fault.visible_on))) }
                    }
                }
            }
        }
    }
}
