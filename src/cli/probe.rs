//! `probe`: the laws of methods on a stepper that is another program.

mod failure;
mod lines;
mod page;
mod text;

use super::failure::shell;
use super::interrupt::Interrupt;
use super::progress::Bar;
use super::tableau::Named;
use super::{Failure, Format, complain, output, print, verdict_code};
use euler_poincare::algebra::Entry;
use euler_poincare::external::{
    Conclusion, Drawn, Examined, External, LawReport, Limits, Probe, Program, Record, Shrinking, examine,
};
use euler_poincare::file::{self, Output};
use euler_poincare::harness::Cost;
use euler_poincare::laws::method::{Claims, LAWS, MethodLaw, named};
use euler_poincare::system::case::{Method, Tau};
use euler_poincare::system::{Cases, SystemFile, cases};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

const EXIT_CODES: &str = "\
Exit codes:
  0    nothing is broken, and every claim was confirmed on at least one case
  1    a law is broken, or the program failed
  2    bad usage or a bad file
  3    no verdict: a claim was confirmed on no case, or without claims no law held on any
  130  interrupted; what was learnt so far is printed

The protocol and the claims are explained in properties/steppers/PROTOCOL.md.";

/// Options of `probe`.
#[derive(clap::Args)]
#[command(after_help = EXIT_CODES)]
pub struct Arguments {
    /// The system of this file (as for `integrate`, without [method] if you like) instead of random ones
    #[arg(long, value_name = "FILE")]
    #[arg(conflicts_with_all = ["random", "cases", "seed", "algebras", "standard_basis", "force_free", "shrink", "replay"])]
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
    /// Claim: on systems without force it conserves these to round-off
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    conserves: Vec<Conserved>,
    /// Claim: a step is that of this project's variational scheme with this tableau, at any size: a name as of `euler-poincare order`,
    /// or a tableau file
    #[arg(long, value_name = "TABLEAU")]
    variational: Option<String>,
    /// The retraction of --variational [default: exp]
    #[arg(long, value_name = "NAME", value_enum, requires = "variational")]
    retraction: Option<Tau>,
    /// Claim: the impulses at the stages that its answers tell change the spatial momentum, as the forced discrete Noether theorem says
    #[arg(long)]
    stages: bool,
    /// Claim: a step back undoes a step, to round-off
    #[arg(long)]
    reversible: bool,
    /// Claim: a step solves its equations this well, relative to the state [default: to round-off]
    #[arg(long, value_name = "TOL", default_value_t = 0.0, value_parser = number(0.0, 0.1), hide_default_value = true)]
    tolerance: f64,
    /// The longest that an answer may take [default: 10]
    #[arg(long, value_name = "SECONDS", value_parser = number(0.001, DAY))]
    timeout: Option<f64>,
    /// The longest that the program may take to start: so much more for its first answer [default: 60]
    #[arg(long, value_name = "SECONDS", value_parser = number(0.0, DAY), allow_negative_numbers = true)]
    startup: Option<f64>,
    /// Look for a simpler case for so long, for the first broken case of each law; 0: do not [default: 60 checks, 30 seconds at
    /// most]
    #[arg(long, value_name = "SECONDS", value_parser = number(0.0, DAY), allow_negative_numbers = true)]
    shrink: Option<f64>,
    /// Run a saved case again, with its own command unless another is given
    #[arg(long, value_name = "FILE")]
    #[arg(conflicts_with_all = ["random", "cases", "seed", "algebras", "standard_basis", "force_free", "laws", "order", "conserves", "variational", "stages", "reversible", "tolerance", "shrink"])]
    replay: Option<PathBuf>,
    /// With --replay: only print the request on which a law was broken or the program failed, as one line for the program's standard input
    #[arg(long, requires = "replay")]
    request: bool,
    /// Also write DIR/report.html: laws, claims, orders, what broke a law, how to repeat it
    #[arg(long, value_name = "DIR", conflicts_with = "replay")]
    report: Option<PathBuf>,
    /// Tables, or JSON: one object per law and line, and one for the whole
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
    /// Also orders, claims, why cases were not judged; of a broken law the system, the errors and the exchange
    #[arg(short, long, conflicts_with = "replay")]
    verbose: bool,
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
    /// The spatial momentum Ad*_{g⁻¹} μ
    Momentum,
    /// The Lie–Poisson bracket: the momenta of a step are a Poisson map
    Poisson,
}

/// The scheme that is claimed; what cannot be built is bad usage.
fn scheme(arguments: &Arguments) -> Result<Option<Method>, Failure> {
    let Some(name) = &arguments.variational else { return Ok(None) };
    let tableau = Named::read(name)?.description;
    tableau.build::<f64>().map_err(|error| Failure::Usage(format!("--variational: {error}")))?;
    let retraction = arguments.retraction.unwrap_or(Tau::Exponential);
    Ok(Some(Method { tableau, retraction, argument: Vec::new() }))
}

/// In seconds.
const DAY: f64 = 86400.0;

/// Reads a number between these.
fn number(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    let allowed = move || format!("allowed: a number from {least} to {most}");
    move |text| text.parse().ok().filter(|x| (least..=most).contains(x)).ok_or_else(allowed)
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    if let Some(path) = &arguments.replay {
        if arguments.request {
            return request(path);
        }
        let limits = (arguments.timeout, arguments.startup);
        return replay(path, &read(path)?, &arguments.command, limits, arguments.format);
    }
    let interrupt = Interrupt::catch()?;
    let claims = Claims {
        order: arguments.order,
        casimirs: arguments.conserves.contains(&Conserved::Casimirs),
        energy: arguments.conserves.contains(&Conserved::Energy),
        momentum: arguments.conserves.contains(&Conserved::Momentum),
        poisson: arguments.conserves.contains(&Conserved::Poisson),
        stages: arguments.stages,
        variational: scheme(&arguments)?,
        reversible: arguments.reversible,
        tolerance: arguments.tolerance,
    };
    let laws = select(arguments.laws.as_deref(), &claims)?;
    let text = arguments.system.as_deref().map(read).transpose()?;
    let systems = match (&arguments.system, &text) {
        (Some(path), Some(text)) => {
            let case = SystemFile::parse_for_stepper(text).map_err(|error| Failure::file(path, error))?;
            Drawn::This(Box::new(case))
        }
        _ => {
            Drawn::Random { of: Box::new(systems(&arguments)?), cases: arguments.cases as usize, seed: arguments.seed }
        }
    };
    let timeout = arguments.timeout.unwrap_or(Limits::default().timeout.as_secs_f64());
    // Before anything is asked: a run that takes a while is not to end here.
    let page = arguments.report.as_deref().map(place).transpose()?;
    let external = start(&arguments.command, (timeout, arguments.startup), &interrupt)?;
    let probe = Probe {
        external: &external,
        laws: &laws,
        systems,
        claims: claims.clone(),
        shrinking: shrinking(arguments.shrink),
    };
    let each = probe.checks() / laws.len().max(1);
    let groups: Vec<_> = laws
        .iter()
        .map(|law| (law.about.name, Some(each), if law.about.cost == Cost::Cheap { 1 } else { 10 }))
        .collect();
    let report = probe.run(&Bar::new(&groups, None, Some(interrupt)));
    let save = |law: &LawReport, broken: &Examined| {
        let record = Record {
            law: law.law.about.name.into(),
            command: arguments.command.clone(),
            timeout,
            claims: claims.clone(),
            seed: arguments.seed,
            index: broken.index as u64,
            case: broken.case.clone(),
            exchange: broken.exchange.clone(),
            slopes: broken.slopes.clone(),
        };
        write(&record)
    };
    // Saved before anything is printed, so that a closed pipe loses nothing.
    let kept: Vec<Vec<Kept>> =
        report.laws.iter().map(|law| law.shown().map(|broken| save(law, broken)).collect()).collect();
    let path = page.as_ref().map(|(path, _)| path.clone());
    let written = page.map_or(Ok(()), |(path, file)| {
        let system = text.as_deref();
        let probed = page::Probed { arguments: &arguments, report: &report, kept: &kept, system, timeout };
        output::write(file, &path, probed.page())
    });
    match arguments.format {
        Format::Text => print(&text::text(&report, &kept, path.as_deref(), arguments.verbose))?,
        Format::Json => print(&lines::json(&report, &kept, path.as_deref()))?,
    }
    written.map(|()| exit_code(report.conclusion()))
}

/// The request of a record.
fn request(path: &Path) -> Result<ExitCode, Failure> {
    let record = Record::from_json(&read(path)?).map_err(|error| Failure::file(path, error))?;
    let Some(exchange) = record.exchange else {
        return Err(Failure::file(path, "the record has no request: the law was not broken by a single step"));
    };
    print(&format!("{}\n", exchange.request))?;
    Ok(ExitCode::SUCCESS)
}

/// Where the page goes: its directory is there now, and no other run writes it.
fn place(directory: &Path) -> Result<(PathBuf, Output), Failure> {
    fs::create_dir_all(directory).map_err(|error| Failure::file(directory, error))?;
    let path = directory.join("report.html");
    let file = output::create(&path)?;
    Ok((path, file))
}

/// The command line of this process, without the page.
fn again() -> String {
    let mut words = vec!["euler-poincare".to_owned()];
    let mut given = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    while let Some(word) = given.next() {
        if word == "--" {
            words.push(word);
            words.extend(given);
            break;
        }
        if word == "--report" {
            given.next();
        } else if !word.starts_with("--report=") {
            words.push(word);
        }
    }
    shell(&words)
}

fn exit_code(conclusion: Conclusion) -> ExitCode {
    match conclusion {
        Conclusion::Interrupted => Interrupt::exit_code(),
        Conclusion::Broken | Conclusion::Failed => ExitCode::from(1),
        Conclusion::GivenUp | Conclusion::Unconfirmed | Conclusion::Undecided => ExitCode::from(3),
        Conclusion::Confirmed | Conclusion::Unbroken => ExitCode::SUCCESS,
    }
}

/// The limit by number of checks is for who says nothing; a time limit alone is kept where one is given.
fn shrinking(seconds: Option<f64>) -> Shrinking {
    match seconds {
        None => Shrinking::default(),
        Some(0.0) => Shrinking::OFF,
        Some(seconds) => Shrinking { checks: usize::MAX, time: Duration::from_secs_f64(seconds) },
    }
}

/// The text of a file.
fn read(path: &Path) -> Result<String, Failure> {
    if path.is_dir() {
        return Err(Failure::file(path, "is a directory; allowed: a file"));
    }
    file::read(path, file::LONGEST).map_err(|error| Failure::file(path, error))
}

/// The program, started: a command that cannot be is bad usage.
fn start(
    command: &[String],
    (timeout, startup): (f64, Option<f64>),
    interrupt: &Interrupt,
) -> Result<External, Failure> {
    if command.is_empty() {
        return Err(Failure::Usage(
            "no stepper; allowed: its command after `--`, as in `-- python3 stepper.py`".into(),
        ));
    }
    let usual = Limits::default();
    let startup = startup.map_or(usual.startup, Duration::from_secs_f64);
    let limits = Limits { timeout: Duration::from_secs_f64(timeout), startup, ..usual };
    let external = External::from(Program::new(command, limits).interrupted_by(interrupt.flag()));
    external.start().map_err(|why| Failure::Usage(why.to_string()))?;
    Ok(external)
}

fn select(patterns: Option<&str>, claims: &Claims) -> Result<Vec<&'static MethodLaw>, Failure> {
    let asked = |law: &&MethodLaw| !law.needs_claim() || law.claim(claims).is_some();
    let Some(patterns) = patterns else { return Ok(LAWS.iter().filter(asked).collect()) };
    let mut selected: Vec<&'static MethodLaw> = Vec::new();
    for pattern in patterns.split(',').map(|pattern| pattern.trim().trim_matches('*')) {
        let hits: Vec<_> = LAWS.iter().filter(|law| !pattern.is_empty() && law.about.name.contains(pattern)).collect();
        // Of several those whose claim is not made say nothing; one that is asked for alone says so.
        let some_asked = hits.iter().any(asked);
        selected.extend(hits.iter().copied().filter(|law| !some_asked || asked(law)));
        if hits.is_empty() {
            let names: Vec<_> = LAWS.iter().map(|law| law.about.name).collect();
            let names = names.join(", ");
            return Err(Failure::Usage(format!("no law matches \"{pattern}\"; the laws of methods are: {names}")));
        }
    }
    Ok(LAWS.iter().filter(|law| selected.contains(law)).collect())
}

fn systems(arguments: &Arguments) -> Result<Cases, Failure> {
    // What version 1 of the protocol can say.
    let mut of = cases().kinetic();
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

/// The most records of one name kept for different programs: beyond it the first is written over.
const MOST_PROGRAMS: usize = 1000;

/// The name of the file of a record: that of one of the same program, or one that is free.
fn name_of(record: &Record) -> String {
    let name = format!("probe-{}-seed{}-case{}", record.law, record.seed, record.index);
    let of_another = |file: &String| {
        let text = file::read(Path::new(file), file::LONGEST);
        text.is_ok_and(|text| Record::from_json(&text).is_ok_and(|other| other.command != record.command))
    };
    let numbered = (2..MOST_PROGRAMS).map(|k| format!("{name}-{k}.json"));
    let mut names = std::iter::once(format!("{name}.json")).chain(numbered);
    names.find(|file| !of_another(file)).unwrap_or_else(|| format!("{name}.json"))
}

/// Writes the record.
fn write(record: &Record) -> Kept {
    let file = name_of(record);
    let text = match record.to_json() {
        Ok(text) => text + "\n",
        Err(error) => return Kept { file, not_saved: Some(error.to_string()), text: String::new() },
    };
    let not_saved = file::write(Path::new(&file), &text).err().map(|error| format!("{file}: {error}"));
    Kept { file, not_saved, text }
}

/// A case on file.
struct Kept {
    /// The name of the file.
    file: String,
    /// Why it could not be written.
    not_saved: Option<String>,
    /// What is in it.
    text: String,
}

/// Judges the case of a record's text by the record's law and claims; with another command unless it is empty, and with other limits
/// (for an answer, to start) where they are given.
pub fn replay(
    path: &Path,
    text: &str,
    command: &[String],
    (timeout, startup): (Option<f64>, Option<f64>),
    format: Format,
) -> Result<ExitCode, Failure> {
    if !Record::is_one(text) && euler_poincare::system::Replay::from_json(text).is_ok() {
        let again = format!("`verify` saved it; run it again with `euler-poincare replay {}`", path.display());
        return Err(Failure::file(path, again));
    }
    let mut record = Record::from_json(text).map_err(|error| Failure::file(path, error))?;
    let law = named(&record.law).ok_or_else(|| {
        let names: Vec<_> = LAWS.iter().map(|law| law.about.name).collect();
        Failure::file(path, format!("law: is \"{}\"; allowed: {}", record.law, names.join(", ")))
    })?;
    if !command.is_empty() {
        record.command = command.to_vec();
    }
    let interrupt = Interrupt::catch()?;
    let external = start(&record.command, (timeout.unwrap_or(record.timeout), startup), &interrupt)?;
    let (outcome, broken) = examine(&external, law, &record.case, &record.claims);
    if interrupt.is_set() {
        complain("interrupted before there was a verdict");
        return Ok(Interrupt::exit_code());
    }
    print(&match format {
        Format::Text => failure::replayed(law, &record, &outcome.verdict, broken.as_ref()),
        Format::Json => lines::replayed(law, &record, &outcome.verdict, broken.as_ref()),
    })?;
    Ok(verdict_code(&outcome.verdict))
}
