//! `replay FILE`: a saved case under its law.

use super::table::entries;
use super::{Failure, laws as selection, print};
use euler_poincare::harness::{Fault, Verdict, verdict_on};
use euler_poincare::laws::{self, CaseLaw};
use euler_poincare::system::Replay;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

/// Options of `replay`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A file that `verify` saved
    file: PathBuf,
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let path = &arguments.file;
    let text = fs::read_to_string(path).map_err(|error| Failure::file(path, error))?;
    let replay = Replay::from_json(&text).map_err(|error| Failure::file(path, error))?;
    let law = laws::named(&replay.law)
        .ok_or_else(|| Failure::file(path, format!("law: is \"{}\"; allowed: {}", replay.law, selection::names())))?;
    let fault = replay.fault.as_deref().map(|name| fault(law, name)).transpose();
    let fault = fault.map_err(|reason| Failure::file(path, reason))?;
    let verdict = verdict_on(law, &replay.case, fault);
    print(&format!("{}\n{}\n", entries(0, rows(law, fault, &replay, &verdict)), indented(&replay.case.to_string())))?;
    Ok(match verdict {
        Verdict::Holds { .. } => ExitCode::SUCCESS,
        Verdict::Broken { .. } => ExitCode::from(1),
        Verdict::Inconclusive { .. } | Verdict::NotApplicable { .. } => ExitCode::from(3),
    })
}

fn fault(law: &CaseLaw, name: &str) -> Result<&'static Fault, String> {
    law.faults.iter().find(|fault| fault.name == name).ok_or_else(|| {
        let names: Vec<_> = law.faults.iter().map(|fault| fault.name).collect();
        let allowed = if names.is_empty() { "none".into() } else { names.join(", ") };
        format!("fault: is \"{name}\"; allowed for {}: {allowed}", law.name)
    })
}

fn rows(
    law: &CaseLaw,
    fault: Option<&Fault>,
    replay: &Replay,
    verdict: &Verdict,
) -> impl Iterator<Item = (&'static str, String)> {
    let mut rows = vec![("law", format!("{}: {}", law.name, law.statement)), ("source", law.source.to_owned())];
    rows.extend(fault.map(|fault| ("planted", format!("{}: {}", fault.name, fault.what))));
    rows.extend(self::verdict(verdict));
    rows.push(("case", format!("from case {} of seed {}", replay.index, replay.seed)));
    rows.into_iter()
}

/// What a verdict says, as named lines.
pub fn verdict(verdict: &Verdict) -> Vec<(&'static str, String)> {
    let numbers = |word: &str, defect: f64, bound: f64| {
        let ratio = verdict.ratio().unwrap_or(f64::INFINITY);
        ("verdict", format!("{word}: defect {defect:.3e}, bound {bound:.3e}, ratio {ratio:.2e}"))
    };
    match verdict {
        Verdict::Holds { defect, bound } => vec![numbers("holds", *defect, *bound)],
        Verdict::Broken { defect, bound, witness } => {
            vec![numbers("broken", *defect, *bound), ("witness", witness.clone())]
        }
        Verdict::Inconclusive { why } => vec![("verdict", format!("inconclusive: {why}"))],
        Verdict::NotApplicable { why } => vec![("verdict", format!("not applicable: {why}"))],
    }
}

/// `text` with every line two columns in.
pub fn indented(text: &str) -> String {
    text.lines().map(|line| format!("  {line}")).collect::<Vec<_>>().join("\n")
}
