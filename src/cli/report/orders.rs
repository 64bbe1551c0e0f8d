//! Error against step of some cases of the laws of orders.

use super::again::{Order, Shown};
use super::chart;
use super::elements::{self, Section};
use super::formula::typeset;
use euler_poincare::harness::convergence::LevelKind;
use maud::{Markup, html};

/// The section.
pub fn section(orders: &[Order]) -> Section {
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
                h3 { (elements::law_link(order.law.about.name)) }
                p.muted { (typeset(order.law.about.statement)) " (" (typeset(order.law.about.source)) ")" }
                div.plots { @for case in &order.cases { (figure(order.law.about.name, case)) } }
            }
        }
    };
    ("orders", "Orders", body)
}

/// What the marks mean.
pub fn legend() -> Markup {
    let kinds = [
        (LevelKind::Asymptotic, "on the line: asymptotic"),
        (LevelKind::PreAsymptotic, "too coarse: pre-asymptotic"),
        (LevelKind::Noise, "not clear of round-off: noise"),
    ];
    html! {
        ul.legend {
            @for (kind, text) in kinds {
                li { (chart::key(kind, 0)) (text) }
            }
        }
    }
}

fn figure(law: &str, shown: &Shown) -> Markup {
    let title = format!("{law}, case {}", shown.index);
    html! {
        figure {
            figcaption {
                b { "Case " (shown.index) } ", " (shown.chosen) ": " (elements::verdict(&shown.verdict))
                @if !shown.agrees { span.flag { "The campaign has another verdict." } }
            }
            @if shown.curves.is_empty() {
                p.muted { "The check measured no errors." }
            } @else {
                (chart::order(&title, &shown.curves, ["slope", "predicted"]))
            }
            @match &shown.case {
                Ok(case) => details { summary { "the case" } pre { (case) } },
                Err(why) => p.flag { (why) },
            }
        }
    }
}
