//! `laws`: what is checked; and the patterns that select laws.

use super::table::{entries, paragraph};
use super::{Failure, Format, print, schema};
use euler_poincare::expression::{like, nearest};
use euler_poincare::harness::{Cost, Fault, Law, draw, parallel};
use euler_poincare::laws::{self, CaseLaw};
use euler_poincare::system::labels;
use serde_json::json;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::process::ExitCode;

/// Options of `laws`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Only these laws: names, globs (`*`, `?`) or parts of names, separated by commas
    #[arg(long, value_name = "PATTERN")]
    laws: Option<String>,
    /// Also the algebras, bases and retractions that a law is checked on, from cases that are drawn for it (seconds)
    #[arg(long)]
    coverage: bool,
    /// Text, or one JSON object per law and line
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let laws = select(arguments.laws.as_deref())?;
    let covered: Vec<Option<Covered>> = match arguments.coverage {
        true => parallel(laws.len(), |k| Some(covered(laws[k]))),
        false => laws.iter().map(|_| None).collect(),
    };
    let mut text = String::new();
    for (law, covered) in laws.into_iter().zip(covered) {
        // Writing to a String cannot fail.
        let _ = match arguments.format {
            Format::Text => {
                writeln!(text, "{} ({})\n{}\n", law.about.name, cost(law.about.cost), describe(law, covered.as_ref()))
            }
            Format::Json => writeln!(text, "{}", object(law, covered)),
        };
    }
    if arguments.format == Format::Text {
        text = format!("{}\n\n{text}", paragraph(MEANING));
    }
    print(text.strip_suffix("\n\n").map(|text| format!("{text}\n")).as_deref().unwrap_or(&text))?;
    Ok(ExitCode::SUCCESS)
}

/// What the words of the list mean.
const MEANING: &str = "\
A law is a statement that must hold for every system. The bounds are in units of u, the unit round-off of the arithmetic (1.1e-16 in \
16 digits), for identities, and differences of slopes for orders of convergence. N = dim g, D the size of the group's matrices, s \
the number of stages. \"Two precisions\": the identity is evaluated in 16 and in 32 digits; it holds where each defect, in its own \
u, is at most 256 times the other one (of four in 32 digits where one does not explain it), or below the floor; in 16 digits it is at \
most 16 times the floor and what changes of the inputs by one unit explain. The cost decides how many cases a law gets (`verify --help`).";

/// Cases that are drawn to see what a law is run on; an algebra with a share of 4 % is missed once in 10⁷ times.
const DRAWS: usize = 400;

/// The names that a law's cases have, in a sample that is the same each time.
struct Covered {
    algebras: BTreeSet<String>,
    bases: BTreeSet<String>,
    retractions: BTreeSet<String>,
}

fn covered(law: &CaseLaw) -> Covered {
    let strategy = law.cases();
    let cases = (0..DRAWS).filter_map(|index| draw(&strategy, 0, law.about.name, index).case.ok());
    let seen: Vec<(&str, String)> = cases.flat_map(|(case, _)| labels(&case)).collect();
    let of = |category: &str| {
        seen.iter().filter(|(name, _)| *name == category).map(|(_, label)| label.clone()).collect::<BTreeSet<_>>()
    };
    Covered { algebras: of("algebra"), bases: of("basis"), retractions: of("retraction") }
}

fn list(names: &BTreeSet<String>) -> String {
    names.iter().map(String::as_str).collect::<Vec<_>>().join(", ")
}

fn cost(cost: Cost) -> &'static str {
    match cost {
        Cost::Cheap => "cheap",
        Cost::Moderate => "moderate",
        Cost::Expensive => "expensive",
        Cost::Heavy => "heavy",
    }
}

fn describe(law: &CaseLaw, covered: Option<&Covered>) -> String {
    let mut rows = vec![
        ("statement", law.about.statement.to_owned()),
        ("source", law.about.source.to_owned()),
        ("oracle", law.about.oracle.to_owned()),
        ("bound", law.about.bound.to_owned()),
    ];
    if !law.about.needs.is_empty() {
        rows.push(("needs", law.about.needs.to_owned()));
    }
    if let Some(covered) = covered {
        rows.push(("algebras", format!("{}; bases: {}", list(&covered.algebras), list(&covered.bases))));
        rows.push(("retraction", list(&covered.retractions)));
    }
    let fault = |fault: &Fault| format!("{}: {}; visible on {}", fault.name, fault.what, fault.visible_on);
    rows.extend(law.about.faults.iter().map(|f| ("fault", fault(f))));
    entries(2, rows)
}

fn object(law: &CaseLaw, covered: Option<Covered>) -> serde_json::Value {
    let mut object = json!(law.about);
    if let (Some(covered), Some(object)) = (covered, object.as_object_mut()) {
        object.insert("algebras".into(), json!(covered.algebras));
        object.insert("bases".into(), json!(covered.bases));
        object.insert("retractions".into(), json!(covered.retractions));
    }
    schema::object("laws/1", object)
}

/// The laws that the comma-separated patterns name in full.
pub fn exact(patterns: Option<&str>) -> Vec<&'static str> {
    let named = |pattern: &str| laws::named(pattern.trim()).map(|law| law.about.name);
    patterns.unwrap_or_default().split(',').filter_map(named).collect()
}

/// The largest number of names shown as near to an unknown one.
const NEAREST: usize = 3;

/// The names that are most like an unknown one, for messages.
pub fn near<'a>(name: &str, all: impl IntoIterator<Item = &'a str>) -> String {
    nearest(name, all, NEAREST).join(", ")
}

/// The laws that any of the comma-separated patterns selects, in the order of [`laws::all`]; all without a pattern.
///
/// A pattern is a name, else a glob (with `*` or `?`), else a part of names. One that selects nothing is bad usage.
pub fn select(patterns: Option<&str>) -> Result<Vec<&'static CaseLaw>, Failure> {
    let all = laws::all();
    let Some(patterns) = patterns else { return Ok(all) };
    let mut selected = vec![false; all.len()];
    for pattern in patterns.split(',').map(str::trim) {
        let exact = laws::named(pattern).is_some();
        let matches = |name: &str| match pattern {
            "" => false,
            _ if exact => name == pattern,
            _ if pattern.contains(['*', '?']) => glob(pattern.as_bytes(), name.as_bytes()),
            _ => name.contains(pattern),
        };
        let hits: Vec<usize> = (0..all.len()).filter(|i| matches(all[*i].about.name)).collect();
        if hits.is_empty() {
            let names = || all.iter().map(|law| law.about.name);
            let near = match like(pattern, names()) {
                Some(law) => format!("did you mean \"{law}\"?"),
                None => format!("near to it: {};", near(pattern, names())),
            };
            return Err(Failure::Usage(format!(
                "no law matches \"{pattern}\"; {near} `euler-poincare laws` lists all"
            )));
        }
        hits.into_iter().for_each(|i| selected[i] = true);
    }
    Ok(all.into_iter().zip(selected).filter_map(|(law, selected)| selected.then_some(law)).collect())
}

/// Whether all of `text` matches: `*` is any run of bytes, `?` any one byte.
fn glob(pattern: &[u8], text: &[u8]) -> bool {
    // Which beginnings of the text are matched by the pattern so far, by their lengths.
    let mut matched = vec![false; text.len() + 1];
    matched[0] = true;
    for &sign in pattern {
        let fits = |length: usize| match sign {
            b'*' => matched[..=length].contains(&true),
            _ => length > 0 && matched[length - 1] && (sign == b'?' || sign == text[length - 1]),
        };
        matched = (0..=text.len()).map(fits).collect();
    }
    matched[text.len()]
}
