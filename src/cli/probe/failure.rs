//! A broken law of a stepper, in full: law, verdict, system, errors, one exchange.

use super::super::failure::parts;
use super::super::levels::{self, rounded};
use super::super::summary::{count, first};
use super::super::table::{data, entries, paragraph};
use super::Kept;
use euler_poincare::external::{Compared, Examined, LawReport, Record, Slopes, Values};
use euler_poincare::harness::Verdict;
use euler_poincare::laws::method::MethodLaw;
use euler_poincare::laws::replay::{indented, verdict_rows};
use euler_poincare::system::Case;
use std::fmt::Write;

/// A case on which a law is broken, or the program failed.
pub fn text(law: &LawReport, broken: &Examined, kept: &Kept) -> String {
    let about = &law.law.about;
    let (what, cases) =
        if broken.failed { ("THE PROGRAM FAILED under", &law.failed) } else { ("BROKEN", &law.found.broken) };
    let heading = format!("{what} {}: {} of {} cases ({})", about.name, cases.len(), law.cases(), first(cases));
    let rows = match broken.failed {
        true => vec![("why", broken.witness().to_owned())],
        false => {
            let said = [("statement", about.statement.to_owned()), ("source", about.source.to_owned())];
            said.into_iter().chain(verdict_rows(&broken.verdict)).collect()
        }
    };
    let text = format!("\n{}\n{}\n", paragraph(&heading), entries(2, rows));
    text + &counterexample(broken, &format!("case {}", broken.index)) + &saved(kept)
}

/// The file of a case, or why there is none.
fn saved(kept: &Kept) -> String {
    let file = &kept.file;
    match &kept.not_saved {
        None => format!(
            "\n  saved in\n    {file}\n  run it again with\n    euler-poincare probe --replay {file}\n  the request alone, for the program's standard \
             input\n    euler-poincare probe --replay {file} --request\n"
        ),
        Some(reason) => format!("\n{}\n", paragraph(&format!("  not saved: {reason}"))),
    }
}

/// A record, judged again.
pub fn replayed(law: &MethodLaw, record: &Record, verdict: &Verdict, broken: Option<&Examined>) -> String {
    let mut rows = vec![
        ("law", format!("{}: {}", law.about.name, law.about.statement)),
        ("source", law.about.source.to_owned()),
        ("command", record.command.join(" ")),
    ];
    rows.extend(law.claim(&record.claims).map(|claim| ("claim", claim)));
    rows.extend(verdict_rows(verdict));
    let from = format!("case {} of seed {}", record.index, record.seed);
    match broken {
        Some(broken) => format!("{}\n{}", entries(0, rows), counterexample(broken, &from)),
        None => format!("{}\n\n  {from}\n{}\n", entries(0, rows), listed(&record.case)),
    }
}

/// Where a case comes from.
pub fn origin(broken: &Examined, name: &str) -> String {
    let mut how = vec![name.to_owned()];
    if broken.varied {
        how.push("varied: the same algebra with another inertia, force and motion".into());
    }
    if broken.failed {
        how.push("the stepper failed on it".into());
    } else if let Some(checks) = broken.checks {
        how.push(format!("shrunk by {}", count(checks, "check")));
    }
    how.join(", ")
}

/// The system, the errors and the exchange.
fn counterexample(broken: &Examined, name: &str) -> String {
    let how = paragraph(&format!("  {}", origin(broken, name)));
    let mut text = format!("\n{how}\n{}\n", listed(&broken.case));
    if let Some(slopes) = broken.slopes.first() {
        text += &format!("\n{}\n", indented(&errors(slopes)));
    }
    if let Some(exchange) = &broken.exchange {
        text += &compared(exchange);
    }
    text
}

/// A request, its answer and the solution, or what is in its place.
fn compared(exchange: &Compared) -> String {
    let Compared { what, request, answer, solution, of_scheme, difference, .. } = exchange;
    let name = if *of_scheme { "scheme" } else { "solution" };
    let answer = if answer.is_empty() { "(none)" } else { answer };
    let mut text = format!("\n  {what}: request\n{}\n  answer\n{}\n", data(&abridged(request)), data(answer));
    if let Some(solution) = solution {
        let _ = write!(text, "  {name} at the end of this step\n{}\n", data(&values(solution, |x| format!("{x:?}"))));
    }
    if let Some(difference) = difference {
        let _ = write!(text, "  answer less {name}\n{}\n", data(&values(difference, |x| format!("{x:.1e}"))));
    }
    text
}

/// Lists of a request with more numbers than this are not printed in the text.
const LONG: usize = 12;

/// A request without its long lists, which a person does not read.
fn abridged(request: &str) -> String {
    let Ok(serde_json::Value::Object(object)) = serde_json::from_str(request) else { return request.into() };
    let entry = |(key, value): (&String, &serde_json::Value)| match value {
        serde_json::Value::Array(list) if list.len() > LONG => format!("\"{key}\": ({} numbers)", list.len()),
        value => format!("\"{key}\": {value}"),
    };
    object.iter().map(entry).collect::<Vec<_>>().join(", ")
}

/// As an answer is written.
pub fn values(values: &Values, number: impl Fn(f64) -> String) -> String {
    let list = |list: &[f64]| format!("[{}]", list.iter().map(|x| number(*x)).collect::<Vec<_>>().join(","));
    let keys = [("mu", &values.mu), ("g", &values.g), ("x", &values.x)];
    let keys = keys.iter().filter(|(_, list)| !list.is_empty()).map(|(key, of)| format!("\"{key}\":{}", list(of)));
    format!("{{{}}}", keys.collect::<Vec<_>>().join(","))
}

/// The errors of the part of the state that decides, level by level.
fn errors(slopes: &Slopes) -> String {
    let found = match (slopes.order, slopes.interval, &slopes.why) {
        (Some(order), Some([low, high]), _) => {
            let [order, low, high] = [order, low, high].map(|order| rounded(order, 3));
            format!("order {order} in [{low}, {high}]")
        }
        (_, _, Some(why)) => format!("no order: {why}"),
        _ => "no order".into(),
    };
    let found = paragraph(&format!("{found}\nslope: of log error against log h, less 1"));
    let rows: Vec<_> = slopes.levels.iter().map(|level| (level.steps, level.h)).collect();
    format!("errors ({})\n{}\n{found}", slopes.quantity, levels::table(&rows, std::slice::from_ref(slopes)))
}

/// A case without its method, which is the stepper's, four columns in.
fn listed(case: &Case) -> String {
    entries(4, system(case))
}

/// A case without its method: what it has, and its value.
pub fn system(case: &Case) -> Vec<(String, String)> {
    let attitude = format!("attitude {}(", case.method.retraction.name());
    let without = parts(case).into_iter().filter(|(name, _)| name != "method");
    without.map(|(name, what)| (name, what.replace("attitude tau(", &attitude))).collect()
}
