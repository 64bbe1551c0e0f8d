//! What pages are made of: sections, tables, links, verdicts.

use super::numbers::*;
use euler_poincare::harness::Verdict;
use maud::{Markup, html};

/// A section with its heading.
pub fn section(id: &str, title: &str, body: Markup) -> Markup {
    html! {
        section id=(id) aria-labelledby=(format!("{id}-title")) {
            h2 id=(format!("{id}-title")) { (title) }
            (body)
        }
    }
}

/// A table that scrolls in a frame of its own, which the keyboard reaches.
pub fn scrolling(label: &str, table: Markup) -> Markup {
    html! { div.scroll role="region" tabindex="0" aria-label=(label) { (table) } }
}

/// A column of a table.
pub enum Column<'a> {
    /// Of words.
    Text(&'a str),
    /// Of numbers.
    Number(&'a str),
}

/// The head of a table.
pub fn header(columns: &[Column<'_>]) -> Markup {
    html! {
        thead {
            tr {
                @for column in columns {
                    @match column {
                        Column::Text(name) => th scope="col" { (name) },
                        Column::Number(name) => th.number scope="col" { (name) },
                    }
                }
            }
        }
    }
}

/// A bar as long as `part` of `whole`.
pub fn gauge(part: f64, whole: f64) -> Markup {
    html! { span style=(format!("width:{:.1}%", 100.0 * part / whole.max(f64::MIN_POSITIVE))) {} }
}

/// A verdict in a line.
pub fn verdict(verdict: &Verdict) -> Markup {
    let numbers = |defect: f64, bound: f64| {
        let ratio = verdict.ratio().unwrap_or(f64::NAN);
        format!("defect {}, bound {}, ratio {}", scientific(defect), scientific(bound), scientific(ratio))
    };
    match verdict {
        Verdict::Holds { defect, bound } => html! { "holds, " (numbers(*defect, *bound)) },
        Verdict::Broken { defect, bound, .. } => html! { span.alarm { "broken" } ", " (numbers(*defect, *bound)) },
        Verdict::Inconclusive { why } => html! { "inconclusive: " (why) },
        Verdict::NotApplicable { why } => html! { "not applicable: " (why) },
    }
}

/// The name by which a link finds a law.
pub fn anchor(name: &str) -> String {
    format!("law-{name}")
}

/// The name of a law, which leads to it. A name that is not in kebab case cannot be in an address as it is.
pub fn law_link(name: &str) -> Markup {
    let kebab = name.bytes().all(|b| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'-');
    html! { @if kebab { a.law-link href=(format!("#{}", anchor(name))) { (name) } } @else { (name) } }
}
