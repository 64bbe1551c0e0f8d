//! Which families of cases were judged.

use super::elements::Section;
use super::files::Found;
use super::numbers::*;
use euler_poincare::harness::{Count, Summary};
use euler_poincare::system::shares::SHARES;
use maud::{Markup, html};

/// The labels of each category: those that there should be, then those that there are besides.
fn families(all: &Summary<()>) -> Vec<(String, Vec<String>)> {
    let mut families: Vec<(String, Vec<String>)> = Vec::new();
    let declared = SHARES.iter().map(|share| (share.category, share.label));
    let seen = all.coverage.keys().map(|(category, label)| (category.as_str(), label.as_str()));
    for (category, label) in declared.chain(seen) {
        match families.iter_mut().find(|(name, _)| name == category) {
            Some((_, labels)) if labels.iter().any(|known| known == label) => {}
            Some((_, labels)) => labels.push(label.to_owned()),
            None => families.push((category.to_owned(), vec![label.to_owned()])),
        }
    }
    families
}

/// The section.
pub fn section(found: &Found) -> Section {
    let mut all = Summary::new("all");
    found.tallies.iter().for_each(|tally| all.append(tally.found.clone()));
    let (families, judged) = (families(&all), all.held + all.broken.len());
    let absent: Vec<String> = families
        .iter()
        .flat_map(|(category, labels)| labels.iter().map(move |label| (category, label)))
        .filter(|(category, label)| all.labelled(category, label).judged == 0)
        .map(|(category, label)| format!("{category} {label}"))
        .collect();
    let body = html! {
        p {
            "Cases that were judged, by what they are examples of. A case with several forces counts for each. "
            @if absent.is_empty() { "Every family has a judged case." }
        }
        @if !absent.is_empty() {
            p.flag {
                (integer(absent.len())) @if absent.len() == 1 { " family" } @else { " families" } " without a judged case: "
                (absent.join(", ")) "."
            }
        }
        div.families {
            @for (category, labels) in &families {
                @let counts: Vec<(&String, Count)> = labels.iter().map(|label| (label, all.labelled(category, label))).collect();
                div.family { h3 { (category) } (gauges(&counts, judged)) }
            }
        }
    };
    ("coverage", "Coverage of families", body)
}

/// How many cases carry each label, as bars.
fn gauges(counts: &[(&String, Count)], judged: usize) -> Markup {
    let most = counts.iter().map(|(_, count)| count.judged).max().unwrap_or(0);
    let told = |count: &Count| format!("{} drawn, {} judged", integer(count.all), integer(count.judged));
    html! {
        table {
            thead.hidden { tr { th scope="col" { "label" } th {} th scope="col" { "judged" } th scope="col" { "share" } } }
            tbody {
                @for (label, count) in counts {
                    tr.absent[count.judged == 0] title=(told(count)) {
                        th scope="row" { (label) }
                        td.gauge { span style=(format!("width:{:.1}%", 100.0 * count.judged as f64 / most.max(1) as f64)) {} }
                        td.number { @if count.judged == 0 { "none" } @else { (integer(count.judged)) } }
                        td.number { (share(count.judged, judged)) }
                    }
                }
            }
        }
    }
}
