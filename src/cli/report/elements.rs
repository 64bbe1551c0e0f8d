//! What pages are made of: sections, tables, links, verdicts.

use super::formula::typeset;
use super::numbers::*;
use super::script;
use euler_poincare::harness::{About, Verdict};
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// What came out, in a sentence, and its class: `held`, `broken` or `empty`.
pub struct Outcome {
    /// The class.
    pub class: &'static str,
    /// The sentence.
    pub text: String,
}

/// A section: its id, its heading, and what is in it.
pub type Section = (&'static str, &'static str, Markup);

/// A page.
pub struct Document<'a> {
    /// Its title.
    pub title: &'a str,
    /// What came out.
    pub outcome: Outcome,
    /// What stands below that.
    pub head: Markup,
    /// What follows.
    pub sections: &'a [Section],
    /// Whether it has the script that filters and orders laws.
    pub script: bool,
}

impl Document<'_> {
    /// As text, with its style: a browser loads nothing else.
    pub fn text(&self) -> String {
        let Self { title, outcome, head, sections, script } = self;
        let page = html! {
            (DOCTYPE)
            html lang="en" {
                head {
                    meta charset="utf-8";
                    meta name="viewport" content="width=device-width, initial-scale=1";
                    meta name="color-scheme" content="light dark";
                    meta http-equiv="Content-Security-Policy" content=(script::policy(*script));
                    title { (title) " · euler-poincare" }
                    style { (PreEscaped(include_str!("style.css"))) }
                }
                body {
                    header {
                        h1 { (title) }
                        p.outcome.(outcome.class) { (outcome.text) }
                        (head)
                        nav aria-label="Sections" {
                            @for (id, title, _) in *sections { a href=(format!("#{id}")) { (title) } }
                        }
                    }
                    main {
                        @for (id, title, body) in *sections {
                            section id=(id) aria-labelledby=(format!("{id}-title")) {
                                h2 id=(format!("{id}-title")) { (title) }
                                (body)
                            }
                        }
                    }
                    footer { p { "Made by euler-poincare " (env!("CARGO_PKG_VERSION")) "." } }
                    @if *script { script { (PreEscaped(script::TEXT)) } }
                }
            }
        };
        page.into_string()
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

/// A law's name with what it says.
pub fn described(name: &str, law: Option<&About>) -> Markup {
    html! {
        span.law { (law_link(name)) }
        @if let Some(about) = law {
            span.statement { (typeset(about.statement)) }
            span.source { (typeset(about.source)) }
            details {
                summary { "oracle and bound" }
                p { b { "Oracle: " } (typeset(about.oracle)) }
                p { b { "Bound: " } (typeset(about.bound)) }
            }
        } @else {
            span.source { "not known to this program" }
        }
    }
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
