//! `verify`: the laws on random systems.

use super::laws::select;
use super::progress::Bar;
use super::{Failure, Format, failure, faults, print, report};
use euler_poincare::harness::{BoxedStrategy, Campaign, Cost, Fault, Law, Report, Summary, Verdict};
use euler_poincare::laws::CaseLaw;
use euler_poincare::laws::replay::{REGRESSIONS, save};
use euler_poincare::system::{Case, Replay, labels};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// Where saved cases belong, where it is there: next to the other snapshots.
const SNAPSHOTS: &str = "snapshots";

/// Of each broken law one case is shrunk, with so many checks. A number, not a time: the same case on every machine.
const SHRINK_CHECKS: usize = 200;

/// Options of `verify`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Cases per cheap law; an expensive law gets max(20, N/50), a heavy one max(8, N/100)
    #[arg(long, value_name = "N", default_value_t = 200, allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    cases: u32,
    /// Seed of the campaign: the same seed gives the same result at any number of threads
    #[arg(long, value_name = "S", default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    /// Only these laws: names, globs (`*`, `?`) or parts of names, separated by commas
    #[arg(long, value_name = "PATTERN")]
    laws: Option<String>,
    /// A table, or one JSON object per law and line
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Threads [default: one per core]
    #[arg(long, value_name = "J", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Instead of the campaign: plant each fault of the selected laws; each must be caught within 100 cases
    #[arg(long)]
    faults: bool,
    /// With --faults: also find the smallest size of each fault, a power of ten, that is still caught
    #[arg(long, requires = "faults")]
    sizes: bool,
    /// Plant the fault FAULT in the selected laws that know it, to see them broken
    #[arg(long, value_name = "FAULT", conflicts_with = "faults")]
    plant: Option<String>,
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let laws = select(arguments.laws.as_deref())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.jobs.map_or(0, usize::from)).build();
    let pool = pool.map_err(|error| Failure::Computation(format!("cannot start the threads: {error}")))?;
    if arguments.faults {
        return pool.install(|| faults::run(&laws, arguments.seed, arguments.sizes, arguments.format));
    }
    let subjects = subjects(laws, arguments.plant.as_deref())?;
    let regressions = || failure::regressions(arguments.format, |law| subjects.iter().any(|s| s.law.name == law));
    let kept = pool.install(regressions)?;
    let start = Instant::now();
    let report = pool.install(|| campaign(&subjects, arguments.seed, arguments.cases as usize));
    let time = start.elapsed().as_secs_f64();
    // Saved before anything is printed, so that a closed pipe loses nothing.
    let broken = saved(&subjects, &report);
    match arguments.format {
        Format::Text => {
            let campaign = report::Campaign { report: &report, threads: pool.current_num_threads(), seconds: time };
            print(&format!("{campaign}{}", broken.concat()))?;
        }
        Format::Json => {
            print(&json(&report)?)?;
            eprint!("{}", broken.concat());
        }
    }
    Ok(if report.holds() && kept { ExitCode::SUCCESS } else { ExitCode::from(1) })
}

/// A law with a fault planted in its subject, or with none.
pub struct Subject {
    pub law: &'static CaseLaw,
    pub fault: Option<&'static Fault>,
}

impl Law<Case> for Subject {
    fn name(&self) -> &'static str {
        self.law.name
    }

    fn statement(&self) -> &'static str {
        self.law.statement
    }

    fn source(&self) -> &'static str {
        self.law.source
    }

    fn oracle(&self) -> &'static str {
        self.law.oracle
    }

    fn bound_note(&self) -> &'static str {
        self.law.bound
    }

    fn cost(&self) -> Cost {
        self.law.cost
    }

    fn faults(&self) -> &'static [Fault] {
        self.law.faults
    }

    fn cases(&self) -> BoxedStrategy<Case> {
        self.law.cases()
    }

    fn check(&self, case: &Case, fault: Option<&Fault>) -> Verdict {
        self.law.check(case, fault.or(self.fault))
    }
}

/// The laws, or those that know the fault called `plant`, with it.
fn subjects(laws: Vec<&'static CaseLaw>, plant: Option<&str>) -> Result<Vec<Subject>, Failure> {
    let Some(name) = plant else { return Ok(laws.into_iter().map(|law| Subject { law, fault: None }).collect()) };
    let known: BTreeSet<_> = laws.iter().flat_map(|law| law.faults.iter().map(|fault| fault.name)).collect();
    let fault = |law: &CaseLaw| law.faults.iter().find(|fault| fault.name == name);
    let subjects: Vec<Subject> =
        laws.into_iter().filter_map(|law| Some(Subject { law, fault: Some(fault(law)?) })).collect();
    if subjects.is_empty() {
        let known = known.into_iter().collect::<Vec<_>>().join(", ");
        return Err(Failure::Usage(format!("no selected law knows the fault \"{name}\"; the faults are: {known}")));
    }
    Ok(subjects)
}

/// How many cheap checks an expensive one is worth to the progress bar.
pub fn weight(cost: Cost) -> u64 {
    match cost {
        Cost::Cheap => 1,
        Cost::Moderate => 20,
        Cost::Expensive => 50,
        Cost::Heavy => 1000,
    }
}

fn campaign(subjects: &[Subject], seed: u64, cases: usize) -> Report<Case> {
    let groups: Vec<_> = subjects.iter().map(|s| (s.law.name, s.law.cost.cases(cases), weight(s.law.cost))).collect();
    let bar = Bar::new(&groups);
    let laws: Vec<&dyn Law<Case>> = subjects.iter().map(|subject| subject as _).collect();
    Campaign::new(seed, cases).labels(&labels).progress(&bar).shrinking(1, SHRINK_CHECKS).run(&laws)
}

fn json(report: &Report<Case>) -> Result<String, Failure> {
    let lines: Result<Vec<_>, _> = report.laws.iter().map(|law| serde_json::to_string(&law.line())).collect();
    let lines = lines.map_err(|error| Failure::Computation(error.to_string()))?;
    Ok(lines.join("\n") + "\n")
}

/// Saves the shrunk cases; a text for each broken law that tells what and where.
fn saved(subjects: &[Subject], report: &Report<Case>) -> Vec<String> {
    let broken = subjects.iter().zip(&report.laws).filter(|(_, summary)| !summary.broken.is_empty());
    broken.map(|(subject, summary)| broken_text(subject, summary)).collect()
}

fn broken_text(subject: &Subject, summary: &Summary<Case>) -> String {
    let saved = summary.failures.iter().map(|failure| {
        let replay = Replay {
            law: subject.law.name.into(),
            seed: failure.seed,
            index: failure.index as u64,
            fault: subject.fault.map(|fault| fault.name.into()),
            case: failure.case.clone(),
        };
        let saved = write(&replay);
        failure::campaign(&replay, failure.checks, saved.as_deref().map_err(String::as_str))
    });
    format!("\n{}{}", report::broken(subject, summary), saved.collect::<String>())
}

/// Writes the record; the path, or why not.
fn write(replay: &Replay) -> Result<PathBuf, String> {
    // A failure that was planted is no regression.
    let regressions = replay.fault.is_none() && Path::new(SNAPSHOTS).is_dir();
    let directory = Path::new(if regressions { REGRESSIONS } else { "" });
    save(directory, replay).map_err(|error| format!("{}: {error}", directory.display()))
}
