//! The table of verdicts, of a campaign and of a probe: a law a row.

use super::elements::{anchor, described};
use super::numbers::*;
use euler_poincare::harness::{About, Line};
use maud::{Markup, html};

/// A law of the table.
pub struct Row<'a> {
    /// Its name.
    pub name: &'a str,
    /// What it says, if this program knows it.
    pub about: Option<&'a About>,
    /// Its counts.
    pub line: Line,
    /// Cases that there should be and are not.
    pub missing: usize,
    /// The cells of the columns beside those that each table has.
    pub more: Vec<Markup>,
}

/// A column: its name, and the key of the order by it.
type Head = (&'static str, Option<&'static str>);

/// The columns of each table.
const HEADS: [Head; 7] = [
    ("cases", Some("cases")),
    ("held", Some("held")),
    ("broken", Some("broken")),
    ("inconclusive", Some("inconclusive")),
    ("not applicable", Some("inapplicable")),
    ("worst defect", None),
    ("its bound", None),
];

/// The table, with more columns.
pub fn table(more: &[Head], rows: &[Row<'_>]) -> Markup {
    html! {
        table.verdicts role="table" {
            caption.hidden { "Verdicts of the laws" }
            thead role="rowgroup" {
                tr role="row" {
                    th role="columnheader" scope="col" data-key="name" { "law, statement, source" }
                    @for (head, key) in HEADS.iter().chain(more) {
                        th.number role="columnheader" scope="col" data-key=[key.as_ref()] { (head) }
                    }
                }
            }
            tbody role="rowgroup" { @for (place, law) in rows.iter().enumerate() { (row(place, law)) } }
        }
    }
}

/// What some laws add up to, as figures, with more of them.
pub fn figures(line: &Line, more: Markup) -> Markup {
    let partial = |number: usize| html! { (integer(number)) small { (share(number, line.cases)) } };
    html! {
        dl.figures {
            div { dt { "cases" } dd { (integer(line.cases)) } }
            div { dt { "held" } dd { (integer(line.held)) } }
            div.bad[line.broken > 0] { dt { "broken" } dd { (integer(line.broken)) } }
            div { dt { "inconclusive" } dd { (partial(line.inconclusive)) } }
            div { dt { "not applicable" } dd { (partial(line.not_applicable)) } }
            (more)
        }
    }
}

/// A number, with the name that it has where there is no head.
pub fn cell(label: &str, value: Markup) -> Markup {
    html! { td.number role="cell" data-label=(label) { span { (value) } } }
}

/// A count that should be 0.
pub fn alarming(label: &str, count: usize) -> Markup {
    cell(label, html! { span.(if count > 0 { "alarm" } else { "muted" }) { (integer(count)) } })
}

/// What a law can be ordered by is in its data.
fn row(place: usize, law: &Row<'_>) -> Markup {
    let Row { name, about, line, missing, more } = law;
    let part = |number: usize| format!("{:.6}", number as f64 / line.cases.max(1) as f64);
    // A browser reads Infinity, and -1 stands for none.
    let ratio = line.ratio.unwrap_or(-1.0);
    let ratio = if ratio.is_finite() { format!("{ratio:e}") } else { "Infinity".to_owned() };
    let partial = |number: usize| {
        html! { (integer(number)) @if number > 0 && number < line.cases { small { (share(number, line.cases)) } } }
    };
    let number = |value: Option<f64>| html! { (value.map_or("–".into(), scientific)) };
    html! {
        tr.broken[line.broken > 0] role="row" id=(anchor(name)) data-place=(place) data-name=(name) data-cases=(line.cases)
            data-held=(line.held) data-broken=(line.broken) data-ratio=(ratio)
            data-inconclusive=(part(line.inconclusive)) data-inapplicable=(part(line.not_applicable)) {
            th role="rowheader" scope="row" { (described(name, *about)) }
            (cell("cases", html! {
                (integer(line.cases))
                @if *missing > 0 { small.warn { (integer(*missing)) " missing" } }
            }))
            (cell("held", html! { (integer(line.held)) }))
            (alarming("broken", line.broken))
            (cell("inconclusive", partial(line.inconclusive)))
            (cell("not applicable", partial(line.not_applicable)))
            (cell("worst defect", number(line.max_defect)))
            (cell("its bound", number(line.bound)))
            @for cell in more { (cell) }
        }
    }
}
