//! `probe`: the laws of methods on a stepper that is another program.

use super::failure::system;
use super::progress::Bar;
use super::summary::some;
use super::table::{Column, Table, data, entries, paragraph};
use super::{Failure, Format, print, schema};
use euler_poincare::algebra::Entry;
use euler_poincare::foreign::{Broken, Drawn, Foreign, LawReport, Limits, Probe, Record, Report};
use euler_poincare::harness::{Cost, Verdict};
use euler_poincare::laws::method::{Claims, LAWS, MethodLaw, check_case, named};
use euler_poincare::laws::replay::verdict_rows;
use euler_poincare::system::{Case, Cases, cases};
use serde_json::json;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

/// A broken case is shrunk with so many checks.
const SHRINK_CHECKS: usize = 60;

/// Options of `probe`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The system of this file (as for `integrate`) instead of random ones
    #[arg(long, value_name = "FILE", conflicts_with_all = ["random", "replay"])]
    system: Option<PathBuf>,
    /// Random systems (the default)
    #[arg(long)]
    random: bool,
    /// Random systems for each law
    #[arg(long, value_name = "N", default_value_t = 20, allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    cases: u32,
    /// Seed of the random systems
    #[arg(long, value_name = "S", default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    /// Only these algebras, by name, separated by commas: so3, se3, so3+r1, …
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    algebras: Vec<String>,
    /// Random systems in the standard basis of their algebra only
    #[arg(long)]
    standard_basis: bool,
    /// Random systems without force only
    #[arg(long)]
    force_free: bool,
    /// Only these laws: names or parts of names, separated by commas
    #[arg(long, value_name = "PATTERN")]
    laws: Option<String>,
    /// Claim: the method is of this order, neither more nor less
    #[arg(long, value_name = "P", value_parser = clap::value_parser!(u32).range(1..=20), allow_negative_numbers = true)]
    order: Option<u32>,
    /// Claim: without force it keeps these to round-off
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    conserves: Vec<Conserved>,
    /// Claim: a step back undoes a step, to round-off
    #[arg(long)]
    reversible: bool,
    /// Claim: a step solves its equations this well, relative to the state [default: to round-off]
    #[arg(long, value_name = "TOL", default_value_t = 0.0, value_parser = tolerance)]
    tolerance: f64,
    /// The longest that an answer may take
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    timeout: Option<f64>,
    /// Run a saved case again, with its own command unless another is given
    #[arg(long, value_name = "FILE", conflicts_with_all = ["random", "algebras", "standard_basis", "force_free", "laws", "order", "conserves", "reversible"])]
    replay: Option<PathBuf>,
    /// A table, or one JSON object per law and line
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// The stepper and its arguments
    #[arg(last = true, value_name = "COMMAND")]
    command: Vec<String>,
}

/// What a method may claim to keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Conserved {
    /// Every Casimir
    Casimirs,
    /// The energy
    Energy,
}

fn tolerance(text: &str) -> Result<f64, String> {
    number(text, 0.0, 0.1)
}

fn seconds(text: &str) -> Result<f64, String> {
    number(text, 0.001, 86400.0)
}

fn number(text: &str, least: f64, most: f64) -> Result<f64, String> {
    let allowed = || format!("allowed: a number from {least} to {most}");
    text.parse().ok().filter(|x| (least..=most).contains(x)).ok_or_else(allowed)
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    if let Some(path) = &arguments.replay {
        return replay(path, &arguments.command, arguments.timeout);
    }
    let laws = select(arguments.laws.as_deref())?;
    let claims = Claims {
        order: arguments.order,
        casimirs: arguments.conserves.contains(&Conserved::Casimirs),
        energy: arguments.conserves.contains(&Conserved::Energy),
        reversible: arguments.reversible,
        tolerance: arguments.tolerance,
    };
    let systems = match &arguments.system {
        Some(path) => Drawn::This(Box::new(case(path)?)),
        None => {
            Drawn::Random { of: Box::new(systems(&arguments)?), cases: arguments.cases as usize, seed: arguments.seed }
        }
    };
    let timeout = arguments.timeout.unwrap_or(Limits::default().timeout.as_secs_f64());
    let foreign = start(&arguments.command, timeout)?;
    let probe = Probe { foreign: &foreign, laws: &laws, systems, claims, shrink_checks: SHRINK_CHECKS };
    let each = probe.checks() / laws.len().max(1);
    let groups: Vec<_> =
        laws.iter().map(|law| (law.name, each, if law.cost == Cost::Cheap { 1 } else { 10 })).collect();
    let bar = Bar::new(&groups);
    let report = probe.run(|law, _| bar.advance(law));
    bar.clear();
    let save = |law: &LawReport, broken: &Broken| {
        let record = Record {
            law: law.law.name.into(),
            command: arguments.command.clone(),
            timeout,
            claims,
            seed: arguments.seed,
            index: broken.index as u64,
            case: broken.case.clone(),
            exchanges: broken.exchanges.clone(),
        };
        write(&record)
    };
    let saved: Vec<_> = report.laws.iter().map(|law| law.failure.as_ref().map(|broken| save(law, broken))).collect();
    match arguments.format {
        Format::Text => print(&text(&report, &saved, &claims))?,
        Format::Json => print(&json(&report, &saved))?,
    }
    Ok(match (report.is_broken(), report.holds_anywhere() && !report.given_up) {
        (true, _) => ExitCode::from(1),
        (false, true) => ExitCode::SUCCESS,
        (false, false) => ExitCode::from(3),
    })
}

/// The program, started: a command that cannot be is bad usage.
fn start(command: &[String], timeout: f64) -> Result<Foreign, Failure> {
    if command.is_empty() {
        return Err(Failure::Usage(
            "no stepper: allowed: its command after `--`, as in `-- python3 stepper.py`".into(),
        ));
    }
    let limits = Limits { timeout: Duration::from_secs_f64(timeout), ..Limits::default() };
    let foreign = Foreign::new(command, limits);
    foreign.start().map_err(|why| Failure::Usage(why.to_string()))?;
    Ok(foreign)
}

fn select(patterns: Option<&str>) -> Result<Vec<&'static MethodLaw>, Failure> {
    let Some(patterns) = patterns else { return Ok(LAWS.iter().collect()) };
    let mut selected: Vec<&'static MethodLaw> = Vec::new();
    for pattern in patterns.split(',').map(|pattern| pattern.trim().trim_matches('*')) {
        let hits = LAWS.iter().filter(|law| !pattern.is_empty() && law.name.contains(pattern));
        let before = selected.len();
        selected.extend(hits);
        if selected.len() == before {
            let names: Vec<_> = LAWS.iter().map(|law| law.name).collect();
            let names = names.join(", ");
            return Err(Failure::Usage(format!("no law matches \"{pattern}\"; the laws of methods are: {names}")));
        }
    }
    Ok(LAWS.iter().filter(|law| selected.contains(law)).collect())
}

fn case(path: &Path) -> Result<Case, Failure> {
    let text = fs::read_to_string(path).map_err(|error| Failure::file(path, error))?;
    let file = euler_poincare::system::SystemFile::parse(&text).map_err(|error| Failure::file(path, error))?;
    Ok(file.case)
}

fn systems(arguments: &Arguments) -> Result<Cases, Failure> {
    let mut of = cases();
    if !arguments.algebras.is_empty() {
        let entry = |name: &String| name.parse::<Entry>().map_err(|error| Failure::Usage(error.to_string()));
        let entries = arguments.algebras.iter().map(entry).collect::<Result<Vec<_>, _>>()?;
        of = of.algebras(&entries);
    }
    if arguments.standard_basis {
        of = of.changed_basis(false);
    }
    if arguments.force_free {
        of = of.force_free();
    }
    Ok(of)
}

/// Writes the record; the path, or why not.
fn write(record: &Record) -> Result<PathBuf, String> {
    let text = record.to_json().map_err(|error| error.to_string())?;
    let path = PathBuf::from(format!("probe-{}-seed{}-case{}.json", record.law, record.seed, record.index));
    fs::write(&path, text + "\n").map_err(|error| format!("{}: {error}", path.display()))?;
    Ok(path)
}

type Saved = Option<Result<PathBuf, String>>;

const COLUMNS: [Column; 10] = [
    Column::name("law"),
    Column::number("cases"),
    Column::number("held"),
    Column::number("broken"),
    Column::number("incon-\nclusive"),
    Column::number("not\nappl.").rank(2),
    Column::number("worst\ndefect").rank(1),
    Column::number("its\nbound").rank(1),
    Column::number("least\norder"),
    Column::number("median\norder").rank(3),
];

/// What is asked.
const MEANING: &str = "\
The stepper is asked for steps of random systems. The laws measure how its errors shrink with the step, what it conserves, and \
how it treats symmetries. A law is broken where a defect exceeds its bound: rounding, in units of u = 1.1e-16, or a difference of \
slopes of log error against log step.";

fn text(report: &Report, saved: &[Saved], claims: &Claims) -> String {
    let mut table = Table::new(&COLUMNS);
    for law in &report.laws {
        table.row(row(law));
    }
    let verdict = paragraph(&verdict(report));
    let mut text = format!("{verdict}\n\n{}\n\n{}\n", paragraph(MEANING), table.text());
    for (title, of) in [
        ("Inconclusive", (|law| &law.inconclusive) as fn(&LawReport) -> &std::collections::BTreeMap<String, usize>),
        ("Not applicable", |law| &law.not_applicable),
    ] {
        let rows: Vec<_> = report
            .laws
            .iter()
            .flat_map(|law| of(law).iter().map(|(why, count)| (law.law.name, format!("{count} × {why}"))))
            .collect();
        if !rows.is_empty() {
            let _ = write!(text, "\n{title}\n{}\n", entries(2, rows));
        }
    }
    for (law, saved) in report.laws.iter().zip(saved) {
        if let (Some(broken), Some(saved)) = (&law.failure, saved) {
            text += &failure(law, broken, saved);
        }
    }
    if report.given_up {
        let _ = write!(text, "\nThe stepper failed {} times and was not started again.\n", report.failures);
    }
    if claims.order.is_none() && !report.is_broken() && report.holds_anywhere() {
        let claim =
            "No order was claimed: each law asked for order 1 or more. If you know the order, claim it with --order P.";
        let _ = write!(text, "\n{}\n", paragraph(claim));
    }
    let _ = write!(text, "\n{verdict}\n");
    text
}

/// The first and the last line.
fn verdict(report: &Report) -> String {
    let broken: Vec<_> = report.laws.iter().filter(|law| !law.broken.is_empty()).map(|law| law.law.name).collect();
    let outcome = match broken.is_empty() {
        false => format!("BROKEN ({})", some(&broken)),
        true if report.holds_anywhere() => "NOTHING BROKEN".into(),
        true => "NO VERDICT".into(),
    };
    format!("{outcome}: {} on {} cases", count(report.laws.len()), asked(report))
}

fn count(laws: usize) -> String {
    if laws == 1 { "1 law".into() } else { format!("{laws} laws") }
}

fn asked(report: &Report) -> usize {
    report.laws.iter().map(|law| law.cases).sum()
}

/// The least of the slopes and the one in the middle.
fn slopes(law: &LawReport) -> Option<(f64, f64)> {
    let mut slopes = law.slopes.clone();
    slopes.sort_by(f64::total_cmp);
    Some((*slopes.first()?, slopes[slopes.len() / 2]))
}

fn row(law: &LawReport) -> Vec<String> {
    let number = |number: Option<f64>| number.map(|x| format!("{x:.1e}")).unwrap_or_default();
    let order = |order: Option<f64>| order.map(|x| format!("{x:.2}")).unwrap_or_default();
    vec![
        law.law.name.to_owned(),
        law.cases.to_string(),
        law.held.to_string(),
        law.broken.len().to_string(),
        law.inconclusive.values().sum::<usize>().to_string(),
        law.not_applicable.values().sum::<usize>().to_string(),
        number(law.worst.map(|worst| worst.0)),
        number(law.worst.map(|worst| worst.1)),
        order(slopes(law).map(|slopes| slopes.0)),
        order(slopes(law).map(|slopes| slopes.1)),
    ]
}

fn failure(law: &LawReport, broken: &Broken, saved: &Result<PathBuf, String>) -> String {
    let mut indices: Vec<String> = law.broken.iter().take(10).map(ToString::to_string).collect();
    if law.broken.len() > 10 {
        indices.push("…".into());
    }
    let (count, cases) = (law.broken.len(), law.cases);
    let mut text = format!("\nBROKEN {}: {count} of {cases} cases ({})\n", law.law.name, indices.join(", "));
    let mut rows = vec![("statement", law.law.statement.to_owned()), ("source", law.law.source.to_owned())];
    rows.extend(verdict_rows(&broken.verdict));
    let how = match (broken.failed, broken.checks) {
        (true, _) => "the stepper failed on it; not shrunk".to_owned(),
        (false, 0) => "as it is".to_owned(),
        (false, checks) => format!("shrunk by {checks} checks"),
    };
    let _ = write!(text, "{}\n\n  case {}, {how}\n", entries(2, rows), broken.index);
    let _ = writeln!(text, "{}", system(4, &broken.case));
    for exchange in &broken.exchanges {
        let (request, answer) = (data(&exchange.request), data(&exchange.answer));
        let _ = write!(text, "\n  request\n{request}\n  answer\n{answer}\n");
    }
    if let Some((mu, g)) = &broken.solution {
        let solution = if g.is_empty() { json!({ "mu": mu }) } else { json!({ "mu": mu, "g": g }) };
        let _ = write!(text, "  the solution of the equations there\n{}\n", data(&solution.to_string()));
    }
    let _ = match saved {
        Ok(path) => {
            let path = path.display();
            writeln!(text, "\n  saved in {path}; run it again with\n    euler-poincare probe --replay {path}")
        }
        Err(reason) => writeln!(text, "\n  not saved: {reason}"),
    };
    text
}

fn json(report: &Report, saved: &[Saved]) -> String {
    let mut text = String::new();
    for (law, saved) in report.laws.iter().zip(saved) {
        let mut line = json!({
            "law": law.law.name,
            "cases": law.cases,
            "held": law.held,
            "broken": law.broken.len(),
            "inconclusive": law.inconclusive,
            "not_applicable": law.not_applicable,
            "max_defect": law.worst.map(|worst| worst.0),
            "bound": law.worst.map(|worst| worst.1),
            "least_order": slopes(law).map(|slopes| slopes.0),
            "median_order": slopes(law).map(|slopes| slopes.1),
        });
        if let (Some(broken), Some(object)) = (&law.failure, line.as_object_mut()) {
            let witness = match &broken.verdict {
                Verdict::Broken { witness, .. } => witness.clone(),
                other => other.to_string(),
            };
            let saved = saved.as_ref().and_then(|saved| saved.as_ref().ok()).map(|path| path.display().to_string());
            object.insert(
                "failure".into(),
                json!({
                    "index": broken.index,
                    "witness": witness,
                    "failed": broken.failed,
                    "exchanges": broken.exchanges,
                    "saved": saved,
                }),
            );
        }
        let _ = writeln!(text, "{}", schema::object("probe/1", line));
    }
    text
}

/// A saved case again, with the command of the record or another.
pub fn replay(path: &Path, command: &[String], timeout: Option<f64>) -> Result<ExitCode, Failure> {
    let text = fs::read_to_string(path).map_err(|error| Failure::file(path, error))?;
    let record = Record::from_json(&text).map_err(|error| Failure::file(path, error))?;
    let law = named(&record.law).ok_or_else(|| {
        let names: Vec<_> = LAWS.iter().map(|law| law.name).collect();
        Failure::file(path, format!("law: is \"{}\"; allowed: {}", record.law, names.join(", ")))
    })?;
    let command = if command.is_empty() { &record.command } else { command };
    let foreign = start(command, timeout.unwrap_or(record.timeout))?;
    let outcome = check_case(law, &foreign, &record.case, &record.claims);
    let mut rows = vec![
        ("law", format!("{}: {}", law.name, law.statement)),
        ("source", law.source.to_owned()),
        ("command", command.join(" ")),
    ];
    rows.extend(verdict_rows(&outcome.verdict));
    rows.push(("case", format!("from case {} of seed {}", record.index, record.seed)));
    print(&format!("{}\n{}\n", entries(0, rows), system(2, &record.case)))?;
    Ok(match outcome.verdict {
        Verdict::Holds { .. } => ExitCode::SUCCESS,
        Verdict::Broken { .. } => ExitCode::from(1),
        Verdict::Inconclusive { .. } | Verdict::NotApplicable { .. } => ExitCode::from(3),
    })
}
