//! `integrate`: a system described in a file, from its initial state to its horizon, as CSV and as a figure.

mod columns;
mod ensemble;
mod plot;
mod run;
mod states;

use super::interrupt::Interrupt;
use super::table::paragraph;
use super::{Failure, complain, print};
use clap::builder::PossibleValuesParser;
use columns::Columns;
use ensemble::Task;
use euler_poincare::scalar::Dd;
use euler_poincare::system::file::{Horizon, MAX_BYTES, MAX_STEPS, example, examples};
use euler_poincare::system::trajectory::{Ended, Plan};
use euler_poincare::system::{Compiled, ScalarName, SystemFile};
use run::{Recorder, summary};
use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const COLUMNS: &str = "\
Columns: t; mu_1 ... momentum; eta_1 ... velocity; energy; work, the integral of <f, eta> by the method's own quadrature; \
balance = energy - initial energy - work; casimir_1 ... (those known for the algebra); g_11 ... the attitude by rows (none where \
the algebra has no group); residual (largest) and iterations (sum) of the steps since the last row.

Exit codes: 0 success; 1 a step failed (a fold, a stage outside the retraction's domain): the rows up to the last state that was \
reached are kept; 2 bad usage, a bad file (with its line, and what is allowed there), or output that cannot be written; 130 \
interrupted (Ctrl-C or SIGTERM): the rows so far are kept, as whole lines.

With --ensemble: STATES.csv has a header and one row a member, with the columns mu_1 ... (all); t; g_11 ... (all or none); \
inertia_1 ... (where the system's inertia is diagonal) and force_1_alpha, force_2_coefficient, ... (the coefficients of force \
terms that are one number: alpha, beta, coefficient, frequency, phase). A value without a column is that of the system file. \
Other columns that `integrate` writes are ignored, so that the result of one run is the start of another. Numbers are written as \
in the system file: 0.25, 1/3, sqrt(2). The whole file is checked before the run.

Final states, a row a member in the order of input: member; t; mu_1 ...; eta_1 ...; energy; casimir_1 ...; g_11 ...; residual \
(largest) and iterations (sum) of all steps, empty for members that are integrated side by side in vector registers (so3 with a \
quadratic Lagrangian, f64, at most 8 stages, no periodic force; see --general); status: ok, or why the member stopped. A member \
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
    /// A figure of momenta, energy, Casimirs and attitude over time
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// The arithmetic: f64 (16 digits) or dd (32 digits)
    #[arg(long, value_parser = PossibleValuesParser::new(["f64", "dd"]))]
    scalar: Option<String>,
    /// How many steps, in place of the horizon
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
    let mut file = SystemFile::parse(&read(path)?).map_err(|refused| Failure::file(name(path), refused))?;
    if let Some(steps) = arguments.steps {
        file.horizon = Horizon::Steps(steps);
    }
    if let Some(every) = arguments.every {
        file.output.every = every;
    }
    match arguments.scalar.as_deref() {
        Some("dd") => file.scalar = ScalarName::Dd,
        Some(_) => file.scalar = ScalarName::F64,
        None => {}
    }
    if let Some(states) = &arguments.ensemble {
        return many(&file, path, states, &arguments);
    }
    let csv = arguments.out.or(file.output.csv.as_ref().map(PathBuf::from)).filter(|out| out != Path::new("-"));
    let svg = arguments.plot.or(file.output.svg.as_ref().map(PathBuf::from));
    distinct(&[Some(path), csv.as_deref(), svg.as_deref()])?;
    match file.scalar {
        ScalarName::F64 => integrate::<f64>(&file, path, csv.as_deref(), svg.as_deref()),
        ScalarName::Dd => integrate::<Dd>(&file, path, csv.as_deref(), svg.as_deref()),
    }
}

/// An ensemble. The names of output files in the system file are those of a trajectory, and not used.
fn many(file: &SystemFile, path: &Path, states: &Path, arguments: &Arguments) -> Result<ExitCode, Failure> {
    if arguments.every.is_some() && !arguments.statistics {
        return Err(Failure::Usage("--every with --ensemble is for --statistics: final states have no times".into()));
    }
    if arguments.general && file.scalar == ScalarName::Dd {
        return Err(Failure::Usage(
            "--general has no effect in 32 digits: there every member is on the general engine".into(),
        ));
    }
    let out = arguments.out.as_deref().filter(|out| *out != Path::new("-"));
    distinct(&[Some(path), Some(states), out])?;
    let Arguments { statistics, general, jobs, .. } = *arguments;
    let task = Task { file, system: path, states, out, statistics, general, jobs };
    match file.scalar {
        ScalarName::F64 => task.run::<f64>(),
        ScalarName::Dd => task.run::<Dd>(),
    }
}

/// The path for messages.
fn name(path: &Path) -> &Path {
    if path == Path::new("-") { Path::new("standard input") } else { path }
}

/// The text of the file, or of standard input; not more of it than any system file has.
fn read(path: &Path) -> Result<String, Failure> {
    let mut text = String::new();
    let limit = MAX_BYTES as u64 + 1;
    let result = if path == Path::new("-") {
        io::stdin().lock().take(limit).read_to_string(&mut text)
    } else {
        File::open(path).and_then(|file| file.take(limit).read_to_string(&mut text))
    };
    result.map(|_| text).map_err(|error| Failure::file(name(path), error))
}

/// Refuses to write over what is read, and two outputs to one file.
fn distinct(paths: &[Option<&Path>]) -> Result<(), Failure> {
    let paths: Vec<(&Path, PathBuf)> = paths
        .iter()
        .flatten()
        .map(|path| (*path, path.canonicalize().unwrap_or_else(|_| path.to_path_buf())))
        .collect();
    for (i, (path, place)) in paths.iter().enumerate() {
        if paths[..i].iter().any(|(_, other)| other == place) {
            return Err(Failure::Usage(format!("{} is used twice: two different files are needed", path.display())));
        }
    }
    Ok(())
}

fn integrate<T: Compiled>(
    file: &SystemFile,
    path: &Path,
    csv: Option<&Path>,
    svg: Option<&Path>,
) -> Result<ExitCode, Failure> {
    let plan = Plan::<T>::of(file).map_err(|refused| Failure::file(path, refused))?;
    // A path that cannot be written is known before the run, not after it.
    let out: Box<dyn Write> = match csv {
        Some(csv) => Box::new(File::create(csv).map_err(|error| Failure::file(csv, error))?),
        None => Box::new(io::stdout().lock()),
    };
    if let Some(svg) = svg {
        File::create(svg).map_err(|error| Failure::file(svg, error))?;
    }
    let shown = io::stderr().is_terminal() && (csv.is_some() || !io::stdout().is_terminal());
    let out = BufWriter::with_capacity(1 << 16, out);
    let mut recorder = Recorder::new(out, svg.is_some(), shown, Interrupt::catch()?);
    recorder.header(&Columns::new(&file.case));
    let ended = file.case.trajectory(plan, &mut recorder).map_err(|refused| Failure::file(path, refused))?;
    let (rows, interrupted) = (recorder.rows(), recorder.interrupted());
    let trace = recorder.finish().or_else(|error| match (csv, error.kind()) {
        (Some(csv), _) => Err(Failure::file(csv, error)),
        (None, io::ErrorKind::BrokenPipe) => Ok(None),
        (None, _) => Err(Failure::Output(error)),
    })?;
    if let (Some(svg), Some(trace)) = (svg, &trace) {
        plot::draw(trace, &file.case, path, svg).map_err(|reason| Failure::file(svg, reason))?;
    }
    let place = csv.map_or("on standard output".into(), |csv| format!("in {}", csv.display()));
    let kept = if rows == 1 { "row".into() } else { format!("{rows} rows") };
    if let (Some((done, total)), Ended::Whole { .. }) = (interrupted, &ended) {
        complain(&format!("INTERRUPTED after {done} of {total} steps; kept {place}: the {kept} up to there"));
        return Ok(Interrupt::exit_code());
    }
    match ended {
        Ended::Failed { reason } => {
            Err(Failure::Computation(format!("{reason}\nkept {place}: the {kept} up to there")))
        }
        Ended::Whole { totals } => {
            if let Some(csv) = csv {
                print(&format!("{}\n", paragraph(&format!("{}: {rows} rows; {}", csv.display(), summary(&totals)))))?;
            }
            Ok(ExitCode::SUCCESS)
        }
    }
}
