//! `integrate`: a system described in a file, from its initial state to its horizon, as CSV and as a figure.

mod balance;
mod columns;
mod ensemble;
mod plot;
mod rows;
mod run;
mod states;

use super::interrupt::Interrupt;
use super::output::{self, create, svg};
use super::summary::count;
use super::table::paragraph;
use super::tableau::Named;
use super::{Failure, complain, print};
use clap::builder::PossibleValuesParser;
use columns::Columns;
use ensemble::Task;
use euler_poincare::file::{self, Output, text};
use euler_poincare::scalar::Dd;
use euler_poincare::system::file::{Horizon, MAX_BYTES, MAX_STEPS, example, examples};
use euler_poincare::system::tolerance::Times;
use euler_poincare::system::trajectory::{End, Ended};
use euler_poincare::system::{Compiled, Reading, ScalarName, SystemFile};
use rows::Rows;
use run::{Events, Recorder, cost};
use std::io;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const COLUMNS: &str = "\
Columns: t; mu_1 ... momentum; eta_1 ... velocity; energy; work, the integral of <f, eta> by the method's own quadrature; \
balance = energy - initial energy - work + the integral of dL/dt at fixed g and eta; casimir_1 ... (those known for the algebra); \
g_11 ... the attitude by rows (none where the algebra has no group); residual (largest) and iterations (sum) of the steps since the last row.

With `tolerance` instead of `step` in the file: rows after each step, after every N-th, or at the times of `save_at` or \
`save_every`, which are exact; the report lists the events of [[event]], --events writes them as a table: event, direction, then the \
columns above without the last two.

Exit codes: 0 success, also where the report says that rounding in many steps made the errors larger than the tolerance; 1 a step failed \
(a fold, a stage outside the retraction's domain): the rows up to the last state that was reached are kept; the same for a tolerance that no \
step keeps and an event without a value; 2 bad usage, a bad file (with its line, and what is allowed there), or output that cannot be written; 130 \
interrupted (Ctrl-C or SIGTERM): the rows so far are kept, as whole lines.

A file is written under its name with .part behind it, which takes the place of what was there when the run ends: two runs cannot write \
one file, and a run that is killed, or that fills the disk, leaves what was there, and the rows so far in the .part.

With --ensemble: STATES.csv has a header and one row a member, with the columns mu_1 ... (all); t; g_11 ... (all or none); \
inertia_1 ... (where the system's inertia is diagonal) and force_1_alpha, force_2_coefficient, ... (the coefficients of force \
terms that are one number: alpha, beta, coefficient, frequency, phase). A value without a column is that of the system file. \
Other columns that `integrate` writes are ignored, so that the result of one run is the start of another. Numbers are written as \
in the system file: 0.25, 1/3, sqrt(2). The whole file is checked before the run.

Final states, a row a member in the order of input: member; t; mu_1 ...; eta_1 ...; energy; casimir_1 ...; g_11 ...; residual \
(largest) and iterations (sum) of all steps, empty for members that are integrated side by side in vector registers (so3 with a \
quadratic Lagrangian, f64, at most 8 stages, forces and potentials with a form in lanes; see --general); status: ok, or why the member stopped. A member \
that fails keeps its last state, the others go on, and the exit code is 1.

--statistics writes a row a time (every N steps, the first and the last): elapsed, since the start of each member; members, those \
that have not failed; _mean, _std (divided by the number of members), _min and _max of mu_1 ..., energy, casimir_1 ...; \
g_departure_max, by how much an attitude violates the equations of its group (rotations: |g'g - 1|). The result is the same, byte \
for byte, for any number of jobs.";

/// Options of `integrate`. What is given here replaces what the file says.
#[derive(clap::Args)]
#[command(after_help = COLUMNS)]
pub struct Arguments {
    /// The system file; `-` for standard input
    #[arg(value_name = "SYSTEM.toml", required_unless_present = "example")]
    system: Option<PathBuf>,
    /// Print a system file: that of a known system, or, without a name, one with comments on every key
    #[arg(long, exclusive = true, value_name = "NAME", num_args = 0..=1, value_parser = PossibleValuesParser::new(names()))]
    example: Option<Option<String>>,
    /// Where the CSV goes; `-` for standard output
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
    /// A figure of momenta, velocities, energy, Casimirs and attitude over time
    #[arg(long, value_name = "FILE.svg", value_parser = figure)]
    plot: Option<PathBuf>,
    /// A table of the events, with the columns of a row
    #[arg(long, value_name = "FILE.csv", value_parser = beside, conflicts_with = "ensemble")]
    events: Option<PathBuf>,
    /// The arithmetic: f64 (16 digits) or dd (32 digits)
    #[arg(long, value_parser = PossibleValuesParser::new(["f64", "dd"]))]
    scalar: Option<String>,
    /// The tableau, in place of that of the system file: a name (gauss-2, rk4, ...) or a tableau file, as `order` takes it
    #[arg(long, value_name = "NAME|FILE")]
    tableau: Option<String>,
    /// How many steps, in place of the horizon (of a file with `step`)
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_STEPS))]
    steps: Option<u64>,
    /// A row every N steps
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=MAX_STEPS))]
    every: Option<u64>,
    /// Many initial states: one row a member, see below
    #[arg(long, value_name = "STATES.csv", conflicts_with = "plot")]
    ensemble: Option<PathBuf>,
    /// Mean, spread and range over the members at every output time, in place of their final states
    #[arg(long, requires = "ensemble")]
    statistics: bool,
    /// Do not integrate members side by side in vector registers: slower, but residual and iterations are reported (f64 only)
    #[arg(long, requires = "ensemble")]
    general: bool,
    /// How many threads; default: one per core
    #[arg(long, value_name = "N", requires = "ensemble", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
}

/// A path that is not `-`: two results cannot share the standard output.
fn beside(path: &str) -> Result<PathBuf, &'static str> {
    if path == "-" { Err("a file is needed: standard output is for the rows, `--out -`") } else { Ok(path.into()) }
}

/// The path of a figure.
fn figure(path: &str) -> Result<PathBuf, &'static str> {
    beside(path).and_then(|_| svg(path))
}

/// The names of the examples.
fn names() -> impl Iterator<Item = &'static str> {
    examples().iter().map(|(name, _)| *name)
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let Some(path) = arguments.system.as_deref() else {
        let wanted = arguments.example.flatten();
        let known = examples().iter().find(|(name, _)| Some(*name) == wanted.as_deref());
        return print(known.map_or_else(example, |(_, text)| text)).map(|()| ExitCode::SUCCESS);
    };
    let scalar = arguments.scalar.as_deref().map(|name| match name {
        "dd" => ScalarName::Dd,
        _ => ScalarName::F64,
    });
    let tableau = arguments.tableau.as_deref().map(Named::read).transpose()?;
    let from = tableau.as_ref().and_then(|named| named.file.as_ref()).and(arguments.tableau.as_deref()).map(Path::new);
    let reading =
        Reading { scalar, tableau: tableau.as_ref().map(|named| named.description.clone()), ..Reading::beside(path) };
    let text = read(path)?;
    let named = reading.tableau_file(&text);
    let inputs = [Some(path), from, named.as_deref()];
    let mut file = SystemFile::parse_with(&text, &reading).map_err(|refused| Failure::file(name(path), refused))?;
    fits(&file, &arguments)?;
    if let Some(steps) = arguments.steps {
        file.horizon = Horizon::Steps(steps);
    }
    if let Some(every) = arguments.every {
        file.output.every = every;
    }
    if let Some(states) = &arguments.ensemble {
        return many(&file, (path, &inputs), states, &arguments);
    }
    let csv = arguments.out.or(file.output.csv.as_ref().map(PathBuf::from)).filter(|out| !is_standard(out));
    let svg = arguments.plot.or(file.output.svg.as_ref().map(PathBuf::from));
    let events = arguments.events.or(file.output.events.as_ref().map(PathBuf::from));
    distinct(&inputs, &[csv.as_deref(), svg.as_deref(), events.as_deref()])?;
    let paths = Paths { system: name(path), csv: csv.as_deref(), svg: svg.as_deref(), events: events.as_deref() };
    let code = match file.scalar {
        ScalarName::F64 => integrate::<f64>(&file, &paths),
        ScalarName::Dd => integrate::<Dd>(&file, &paths),
    }?;
    file.case.notes().iter().for_each(|note| complain(&format!("note: {note}")));
    Ok(code)
}

/// Refuses options without effect on this file.
fn fits(file: &SystemFile, arguments: &Arguments) -> Result<(), Failure> {
    let usage = |message: &str| Err(Failure::Usage(message.into()));
    match &file.adaptive {
        None if arguments.events.is_some() => usage("--events is for files with `tolerance` instead of `step`"),
        None => Ok(()),
        Some(_) if arguments.ensemble.is_some() => {
            usage("--ensemble is for fixed steps: the file needs `step` instead of `tolerance`")
        }
        Some(_) if arguments.steps.is_some() => {
            usage("--steps is for fixed steps: with `tolerance` the length of the run is `horizon`")
        }
        Some(adaptive) if arguments.every.is_some() && adaptive.times != Times::Steps => {
            usage("--every has no effect beside `save_at` or `save_every`")
        }
        Some(adaptive) if arguments.events.is_some() && adaptive.events.is_empty() => {
            usage("--events has no effect: the file has no [[event]]")
        }
        Some(_) => Ok(()),
    }
}

/// An ensemble. The names of output files in the system file are those of a trajectory, and not used.
fn many(
    file: &SystemFile,
    (path, inputs): (&Path, &[Option<&Path>]),
    states: &Path,
    arguments: &Arguments,
) -> Result<ExitCode, Failure> {
    if arguments.every.is_some() && !arguments.statistics {
        return Err(Failure::Usage("--every with --ensemble is for --statistics: final states have no times".into()));
    }
    if arguments.general && file.scalar == ScalarName::Dd {
        return Err(Failure::Usage(
            "--general has no effect in 32 digits: there every member is on the general engine".into(),
        ));
    }
    let out = arguments.out.as_deref().filter(|out| !is_standard(out));
    distinct(inputs, &[Some(states), out])?;
    let task = Task { file, system: path, states, out, arguments };
    match file.scalar {
        ScalarName::F64 => task.run::<f64>(),
        _ => task.run::<Dd>(),
    }
}

/// Whether the path is that of the standard output: then nothing else is printed there.
fn is_standard(path: &Path) -> bool {
    [Path::new("-"), Path::new("/dev/stdout")].contains(&path)
}

/// The path for messages.
fn name(path: &Path) -> &Path {
    if path == Path::new("-") { Path::new("standard input") } else { path }
}

/// The text of the file, or of standard input; not more of it than any system file has.
fn read(path: &Path) -> Result<String, Failure> {
    let text = if path == Path::new("-") { text(io::stdin().lock(), MAX_BYTES) } else { file::read(path, MAX_BYTES) };
    text.map_err(|error| Failure::file(name(path), error))
}

/// Refuses to write over what is read, and two outputs to one file.
fn distinct(inputs: &[Option<&Path>], others: &[Option<&Path>]) -> Result<(), Failure> {
    // Of a file that is not there yet, its directory.
    let place = |path: &Path| {
        let beside = || Some(path.parent()?.join(".").canonicalize().ok()?.join(path.file_name()?));
        path.canonicalize().ok().or_else(beside).unwrap_or_else(|| path.to_path_buf())
    };
    let mut taken: Vec<PathBuf> = inputs.iter().flatten().map(|path| place(path)).collect();
    for path in others.iter().flatten() {
        let place = place(path);
        let part = Output::part(&place);
        if [Some(&place), part.as_ref()].into_iter().flatten().any(|place| taken.contains(place)) {
            return Err(Failure::Usage(format!("{} is used twice: two different files are needed", path.display())));
        }
        taken.extend([Some(place), part].into_iter().flatten());
    }
    Ok(())
}

/// Where the files of a run are.
struct Paths<'a> {
    system: &'a Path,
    csv: Option<&'a Path>,
    svg: Option<&'a Path>,
    events: Option<&'a Path>,
}

impl Paths<'_> {
    /// A recorder, and the file of the figure: a path that cannot be written is known before the run, not after it.
    fn recorder(&self, file: &SystemFile, total: Option<u64>) -> Result<(Recorder, Option<Output>), Failure> {
        let (out, shown) = Rows::create(self.csv)?;
        let figure = self.svg.map(create).transpose()?;
        let table = self.events.map(create).transpose()?;
        let columns = Columns::new(&file.case);
        let mut recorder = Recorder::new(out, (&columns, self.svg.is_some()), (total, shown), Interrupt::catch()?);
        if let Some(adaptive) = &file.adaptive {
            let names = adaptive.events.iter().map(|event| event.name().to_owned()).collect();
            recorder.events = Events::new(names, table, &columns);
        }
        Ok((recorder, figure))
    }
}

fn integrate<T: Compiled>(file: &SystemFile, paths: &Paths<'_>) -> Result<ExitCode, Failure> {
    let refused = |refused| Failure::file(paths.system, refused);
    // What cannot run is refused before there are files; a run with a tolerance is as it was read.
    let plan = file.adaptive.is_none().then(|| file.plan::<T>()).transpose().map_err(refused)?;
    let total = plan.map(|(steps, last)| steps + u64::from(last.is_some()));
    let (mut recorder, figure) = paths.recorder(file, total)?;
    let ended = file.run::<T>(&mut recorder).map_err(refused)?;
    report(file, paths, (recorder, figure), ended)
}

/// Ends the output of a run, and tells of it: on standard output; on standard error where the rows are on the former, of a run with a tolerance.
fn report<T: Compiled>(
    file: &SystemFile,
    paths: &Paths<'_>,
    (mut recorder, figure): (Recorder, Option<Output>),
    ended: Ended<T>,
) -> Result<ExitCode, Failure> {
    let (rows, interrupted, balance) = (recorder.rows, recorder.stopped.take(), recorder.balance.clone());
    let events = std::mem::take(&mut recorder.events);
    let trace = recorder.finish(paths.csv)?;
    let table = events.text();
    if let Some(path) = paths.events {
        events.finish(path)?;
    }
    if let (Some(path), Some(figure), Some(trace)) = (paths.svg, figure, &trace) {
        output::draw(figure, path, &plot::figure(trace, file, paths.system))?;
    }
    let (on, place) = match paths.csv {
        Some(csv) => ("in", csv.display().to_string()),
        None => ("on", "standard output".into()),
    };
    let up_to = if rows == 1 { "row".into() } else { format!("{rows} rows") };
    let kept = format!("kept {on} {place}: the {up_to} up to there");
    let tell = |text: &str| match paths.csv {
        _ if text.is_empty() => Ok(()),
        Some(_) => print(text),
        None => {
            complain(text.trim_end());
            Ok(())
        }
    };
    if let Some(reason) = ended.reason {
        tell(&table)?;
        return Err(Failure::Computation(format!("{reason}\n{kept}")));
    }
    if let Some(steps) = interrupted {
        tell(&table)?;
        let when = file.adaptive.as_ref().map_or(String::new(), |_| format!(", at t = {}", ended.time));
        complain(&format!("INTERRUPTED after {steps}{when}; {kept}"));
        return Ok(Interrupt::exit_code());
    }
    if file.adaptive.is_some() && ended.end == End::Stopped {
        return Ok(ExitCode::SUCCESS);
    }
    if paths.csv.is_some() || file.adaptive.is_some() {
        let cost = cost(&ended, file.adaptive.as_ref());
        let text = paragraph(&format!("{place}: {}; {cost}; {}", count(rows, "row"), balance.text()));
        // What is perhaps not meant is told on standard error, too.
        let notes = if paths.csv.is_some() { file.case.notes() } else { Vec::new() };
        let notes: String = notes.iter().map(|note| format!("{}\n", paragraph(&format!("note: {note}")))).collect();
        tell(&format!("{table}{text}\n{notes}"))?;
    }
    balance.warning().iter().for_each(|warning| complain(warning));
    Ok(ExitCode::SUCCESS)
}
