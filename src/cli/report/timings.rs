//! Where the time went.

use super::elements::{self, Column::*, gauge, header, scrolling};
use super::files::Found;
use super::numbers::*;
use crate::cli::rates;
use maud::{Markup, html};

/// The section.
pub fn section(found: &Found) -> Markup {
    let Some(times) = &found.times else {
        return elements::section("timings", "Timings", html! { p { "There is no " code { "timings.jsonl" } "." } });
    };
    let mut rows: Vec<_> = times.iter().collect();
    rows.sort_by(|a, b| b.1.total.total_cmp(&a.1.total));
    let total: f64 = rows.iter().map(|(_, time)| time.total).sum();
    let checks: usize = rows.iter().map(|(_, time)| time.checks).sum();
    let body = html! {
        p {
            "The only numbers of this page that depend on the machine and on the day; no verdict does. "
            (duration(total)) " in " (counted(checks, "check")) ", summed over the threads."
        }
        @if !rows.is_empty() { (scrolling("Timings", html! {
            table.timings {
                (header(&[Text("law"), Text("share"), Number("total"), Number("checks"), Number("mean"), Number("a second"), Number("longest")]))
                tbody {
                    @for (law, time) in rows {
                        tr {
                            th scope="row" { (elements::law_link(law)) }
                            td.gauge { (gauge(time.total, total)) }
                            td.number { (duration(time.total)) }
                            td.number { (integer(time.checks)) }
                            td.number { (duration(time.total / time.checks.max(1) as f64)) }
                            td.number { @if time.total > 0.0 { (rates::text(time.checks as f64 / time.total)) } }
                            td.number { (duration(time.longest)) }
                        }
                    }
                }
            }
        })) }
    };
    elements::section("timings", "Timings", body)
}
