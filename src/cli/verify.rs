//! `verify`: the laws on random systems.

use super::interrupt::Interrupt;
use super::laws::{exact, near, select};
use super::progress::{Bar, weight};
use super::{Failure, Format, complain, failure, faults, print, program, schema, summary};
use euler_poincare::file::spelled;
use euler_poincare::harness::store::{Manifest, Store, StoreError};
use euler_poincare::harness::{Campaign, CampaignReport, Done, Ending, Halt, Law, Recorded, Shard, Summary};
use euler_poincare::laws::replay::{REGRESSIONS, file_name, records, save_as};
use euler_poincare::laws::{CaseLaw, PlantedLaw};
use euler_poincare::system::{Case, Replay, labels};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};
use std::{fs, io};

/// Where saved cases belong, where it is there: next to the other snapshots.
const SNAPSHOTS: &str = "snapshots";

/// The most checks for shrinking one case of each broken law. A number, not a time: the same case on every machine.
const SHRINK_CHECKS: usize = 200;

/// Options of `verify`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Cases per cheap law; a moderate law gets max(32, N/4), an expensive one max(20, N/50), a heavy one max(8, N/100)
    /// [default: 100, or as many as fit into --minutes]
    #[arg(long, value_name = "N", allow_negative_numbers = true, conflicts_with = "faults")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    cases: Option<u32>,
    /// Begin no further case after M minutes
    #[arg(long, value_name = "M", allow_negative_numbers = true, conflicts_with = "faults", value_parser = minutes)]
    minutes: Option<Duration>,
    /// Seed of the campaign: the same seed gives the same result at any number of threads
    #[arg(long, value_name = "S", default_value_t = 1, allow_negative_numbers = true)]
    seed: u64,
    /// Only these laws: names, globs (`*`, `?`) or parts of names, separated by commas
    #[arg(long, value_name = "PATTERN")]
    laws: Option<String>,
    /// A table, or one JSON object per law and line
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Also what the columns mean, coverage, why cases were not judged; of a broken law the case
    #[arg(short, long, conflicts_with = "faults")]
    verbose: bool,
    /// Threads [default: one per core]
    #[arg(long, value_name = "J", allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Only part i of n, from 0: of each law the cases whose index is i modulo n
    #[arg(long, value_name = "I/N", allow_hyphen_values = true, conflicts_with = "faults")]
    shard: Option<Shard>,
    /// Keep every verdict in this directory, as it comes; with --faults: what was caught
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Go on with the campaign in --out, which must be the same; begin it where there is none
    #[arg(long, requires = "out", conflicts_with = "faults")]
    resume: bool,
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

/// Cases per cheap law where nothing is said.
const CASES: usize = 100;

fn minutes(text: &str) -> Result<Duration, String> {
    let minutes = text.parse::<f64>().ok().filter(|minutes| *minutes > 0.0);
    let duration = minutes.and_then(|minutes| Duration::try_from_secs_f64(60.0 * minutes).ok());
    duration.filter(|duration| !duration.is_zero()).ok_or_else(|| "a number of minutes, above 0".into())
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let laws = select(arguments.laws.as_deref())?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(arguments.jobs.map_or(0, usize::from)).build();
    let pool = pool.map_err(|error| Failure::System(format!("cannot start the threads: {error}")))?;
    let interrupt = Interrupt::catch()?;
    if arguments.faults {
        let Arguments { seed, sizes, format, out, .. } = arguments;
        let table = faults::Table { seed, sizes, format, out: out.as_deref() };
        return pool.install(|| table.run(&laws, &interrupt));
    }
    let subjects = subjects(laws, arguments.plant.as_deref())?;
    let kept = pool.install(|| failure::regressions(|law| subjects.iter().any(|s| s.law.about.name == law)))?;
    let cases = match (arguments.cases, arguments.minutes) {
        (None, None) => Some(CASES),
        (cases, _) => cases.map(|cases| cases as usize),
    };
    let plan = Plan { subjects: &subjects, cases, limit: arguments.minutes, interrupt, arguments: &arguments };
    let store = arguments.out.as_deref().map(|out| plan.store(out)).transpose()?;
    let start = Instant::now();
    let report = pool.install(|| plan.run(store.as_ref()))?;
    let seconds = start.elapsed().as_secs_f64();
    // Saved before anything is printed, so that a closed pipe loses nothing.
    let place = match (&store, report.ending) {
        (None, _) => Place::Here,
        (Some(_), Ending::Interrupted) => Place::Nowhere("the run was interrupted; --resume shrinks it"),
        (Some(store), _) => Place::Store(store.failures()),
    };
    // Next to JSON, which has no room for it, everything is told.
    let verbose = arguments.verbose || arguments.format == Format::Json;
    let broken = saved(&subjects, &report, &place, verbose)?;
    let campaign = summary::Campaign {
        report: &report,
        threads: pool.current_num_threads(),
        seconds,
        kept: &kept,
        asked: &exact(arguments.laws.as_deref()),
        end: &plan.end(&report, store.as_ref()),
        broken: &broken.concat(),
        verbose,
    };
    match arguments.format {
        Format::Text => print(&campaign.to_string())?,
        Format::Json => {
            print(&json(&report)?)?;
            let passed = if kept.failing == 0 { "" } else { &kept.told };
            eprint!("{}", spelled(&format!("{passed}{}{}", campaign.end, campaign.broken)));
            if campaign.is_undecided() {
                complain(&campaign.verdict());
            }
        }
    }
    Ok(campaign.exit_code())
}

/// What is to be run, and when it ends.
struct Plan<'a> {
    subjects: &'a [PlantedLaw],
    cases: Option<usize>,
    limit: Option<Duration>,
    interrupt: Interrupt,
    arguments: &'a Arguments,
}

impl Plan<'_> {
    fn shard(&self) -> Shard {
        self.arguments.shard.unwrap_or(Shard::WHOLE)
    }

    fn laws(&self) -> Vec<&dyn Law<Case>> {
        self.subjects.iter().map(|subject| subject as _).collect()
    }

    /// The campaign's directory, new or taken up again.
    fn store(&self, out: &Path) -> Result<Store, Failure> {
        let Arguments { seed, plant, shard, resume, .. } = self.arguments;
        let manifest = Manifest {
            plant: plant.clone(),
            shard: shard.map(|shard| [shard.index(), shard.count()]),
            ..program::manifest(*seed, self.cases, &self.laws())?
        };
        if *resume {
            return Ok(Store::resume(out, manifest)?);
        }
        Store::create(out, manifest).map_err(|error| match error {
            StoreError::Occupied { .. } => Failure::Usage(format!("{error}; --resume goes on with it")),
            error => error.into(),
        })
    }

    fn run(&self, store: Option<&Store>) -> Result<CampaignReport<Case>, Failure> {
        let (laws, seed) = (self.laws(), self.arguments.seed);
        let recorded = match store {
            Some(store) => store.recorded(&laws)?,
            None => Recorded::none(&laws, self.shard()),
        };
        let writer = store.map(Store::writer).transpose()?;
        let report = {
            let bar = self.bar(&recorded);
            let start = Instant::now();
            let halt = || match self.limit {
                _ if self.interrupt.is_set() => Halt::All,
                Some(limit) if start.elapsed() >= limit => Halt::Cases,
                _ => Halt::No,
            };
            let campaign = match self.cases {
                Some(cases) => Campaign::new(seed, cases).halt(&halt),
                None => Campaign::until(seed, &halt),
            };
            let campaign = campaign.labels(&labels).progress(&bar).shrinking(1, SHRINK_CHECKS).shard(self.shard());
            match &writer {
                Some(writer) => campaign.sink(writer).resume(&laws, recorded),
                None => campaign.resume(&laws, recorded),
            }
        };
        if let Some(writer) = writer {
            writer.finish()?;
        }
        if let Some(store) = store
            && report.ending != Ending::Interrupted
        {
            store.sort()?;
        }
        Ok(report)
    }

    fn bar(&self, recorded: &Recorded<Case>) -> Bar {
        let group = |(subject, done): (&PlantedLaw, &Done)| {
            let cost = subject.law.about.cost;
            let left = self.cases.map(|cases| self.shard().size(cost.cases(cases)).saturating_sub(done.len()));
            (subject.law.about.name, left, weight(cost))
        };
        let groups: Vec<_> = self.subjects.iter().zip(&recorded.done).map(group).collect();
        Bar::new(&groups, self.limit, Some(self.interrupt.clone()))
    }

    /// How the run ended, where that is not plain, and where its records are.
    fn end(&self, report: &CampaignReport<Case>, store: Option<&Store>) -> String {
        let planned =
            |cases| self.subjects.iter().map(|s| self.shard().size(s.law.about.cost.cases(cases))).sum::<usize>();
        let checked: usize = report.laws.iter().map(|law| law.cases).sum();
        let of = self.cases.map(|cases| format!(" of {}", planned(cases))).unwrap_or_default();
        let ended = match (report.ending, self.limit) {
            (Ending::Interrupted, _) => format!("INTERRUPTED after {checked}{of} cases"),
            (Ending::Stopped, Some(limit)) if self.cases.is_some() => {
                // As it was typed: what 60 times and a sixtieth round is not shown.
                let minutes = (limit.as_secs_f64() / 60.0 * 1e6).round() / 1e6;
                format!("stopped by --minutes {minutes} after {checked}{of} cases")
            }
            _ => String::new(),
        };
        let go_on = if ended.is_empty() || store.is_none() { "" } else { "; --resume goes on" };
        let ended = if ended.is_empty() { ended } else { format!("{ended}{go_on}\n") };
        match store {
            Some(store) if self.arguments.format == Format::Text => {
                format!("{ended}results in {}\n", store.path().display())
            }
            _ => ended,
        }
    }
}

/// The laws, or those that know the fault called `plant`, with it.
fn subjects(laws: Vec<&'static CaseLaw>, plant: Option<&str>) -> Result<Vec<PlantedLaw>, Failure> {
    let Some(name) = plant else {
        return Ok(laws.into_iter().map(|law| PlantedLaw { law, fault: None, digits: None }).collect());
    };
    let known: BTreeSet<_> = laws.iter().flat_map(|law| law.about.faults.iter().map(|fault| fault.name)).collect();
    let subjects: Vec<PlantedLaw> = laws
        .into_iter()
        .filter_map(|law| Some(PlantedLaw { law, fault: Some(law.fault(name)?), digits: None }))
        .collect();
    if subjects.is_empty() {
        let near = near(name, known);
        return Err(Failure::Usage(format!(
            "no selected law knows the fault \"{name}\"; near to it: {near}; `euler-poincare laws` lists the faults of each law"
        )));
    }
    Ok(subjects)
}

fn json(report: &CampaignReport<Case>) -> Result<String, Failure> {
    let object =
        |law: &Summary<Case>| Ok(format!("{}\n", schema::object("verify/1", serde_json::to_value(law.line())?)));
    let lines: Result<String, serde_json::Error> = report.laws.iter().map(object).collect();
    lines.map_err(|error| Failure::System(error.to_string()))
}

/// Where shrunk cases go.
enum Place {
    /// Next to the snapshots, or into the working directory.
    Here,
    /// The failures of a campaign's directory.
    Store(PathBuf),
    /// Nowhere, and why.
    Nowhere(&'static str),
}

/// Saves the shrunk cases; a text for each broken law that tells what and where.
fn saved(
    subjects: &[PlantedLaw],
    report: &CampaignReport<Case>,
    place: &Place,
    verbose: bool,
) -> Result<Vec<String>, Failure> {
    if let Place::Store(directory) = place {
        remove_failures(subjects, directory).map_err(|error| Failure::file(directory, error))?;
    }
    let broken = subjects.iter().zip(&report.laws).filter(|(_, summary)| !summary.broken.is_empty());
    Ok(broken.map(|(subject, summary)| broken_text(subject, summary, place, verbose)).collect())
}

/// Removes what an earlier part of the campaign has saved: cases of lower index may be broken by now.
fn remove_failures(subjects: &[PlantedLaw], directory: &Path) -> io::Result<()> {
    for path in records(directory)? {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        let ours = |s: &PlantedLaw| name.strip_prefix(s.law.about.name).is_some_and(|rest| rest.starts_with("-seed"));
        if subjects.iter().any(ours) {
            fs::remove_file(&path)?;
        }
    }
    Ok(())
}

fn broken_text(subject: &PlantedLaw, summary: &Summary<Case>, place: &Place, verbose: bool) -> String {
    let saved = summary.failures.iter().map(|failure| {
        let replay = Replay {
            module: None,
            law: subject.law.about.name.into(),
            seed: failure.seed,
            index: failure.index as u64,
            fault: subject.fault.map(|fault| fault.name.into()),
            case: failure.case.clone(),
        };
        let saved = write(&replay, place);
        let saved = saved.as_deref().map_err(String::as_str);
        if verbose { failure::campaign(&replay, failure.checks, saved) } else { failure::brief(&replay, saved) }
    });
    let heading = summary::broken(subject, summary, verbose);
    let text = heading + &saved.collect::<String>();
    if verbose { format!("\n{text}") } else { text + "\n" }
}

/// Writes the record; the path, or why not.
fn write(replay: &Replay, place: &Place) -> Result<PathBuf, String> {
    // A failure that was planted is no regression.
    let regressions = replay.fault.is_none() && Path::new(SNAPSHOTS).is_dir();
    let (directory, name) = match place {
        Place::Nowhere(why) => return Err((*why).into()),
        // The whole campaign has one fault planted, or none: the name need not say so.
        Place::Store(directory) => {
            (directory.as_path(), format!("{}-seed{}-case{}.json", replay.law, replay.seed, replay.index))
        }
        Place::Here => (Path::new(if regressions { REGRESSIONS } else { "" }), file_name(replay)),
    };
    save_as(directory, &name, replay).map_err(|error| format!("{}: {error}", directory.join(name).display()))
}
