//! `integrate`: a system described in a file, from its initial state to its horizon, as CSV and as a figure.

mod columns;
mod plot;
mod run;

use super::{Failure, printed};
use clap::builder::PossibleValuesParser;
use euler_poincare::scalar::{Dd, Real};
use euler_poincare::system::ScalarName;
use euler_poincare::system::SystemFile;
use euler_poincare::system::file::{Horizon, MAX_BYTES, MAX_STEPS, example};
use run::{Ended, Recorder, Run};
use std::fs::File;
use std::io::{self, BufWriter, IsTerminal, Read, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const COLUMNS: &str = "\
Columns: t; mu_1 ... momentum; eta_1 ... velocity; energy; work, the integral of <f, eta> by the method's own quadrature;
balance = energy - initial energy - work; casimir_1 ... (those known for the algebra); g_11 ... the attitude by rows
(none where the algebra has no group); residual (largest) and iterations (sum) of the steps since the last row.

A step that fails (a fold, a stage outside the retraction's domain) ends the run with exit code 1; the rows up to the last
state that was reached are written. A file that is refused: exit code 2, with the line and what is allowed there.";

/// Options of `integrate`. What is given here replaces what the file says.
#[derive(clap::Args)]
#[command(after_help = COLUMNS)]
pub struct Arguments {
    /// The system file; `-` for standard input
    #[arg(value_name = "SYSTEM.toml", required_unless_present = "example")]
    system: Option<PathBuf>,
    /// Print a complete system file, with comments on every key
    #[arg(long, exclusive = true)]
    example: bool,
    /// Where the CSV goes; `-` for standard output
    #[arg(long, value_name = "FILE.csv")]
    out: Option<PathBuf>,
    /// A figure of momenta, energy and Casimirs over time
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
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let Some(path) = arguments.system.as_deref() else {
        return printed(io::stdout().write_all(example().as_bytes())).map(|()| ExitCode::SUCCESS);
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
    let csv = arguments.out.or(file.output.csv.as_ref().map(PathBuf::from)).filter(|out| out != Path::new("-"));
    let svg = arguments.plot.or(file.output.svg.as_ref().map(PathBuf::from));
    distinct(&[Some(path), csv.as_deref(), svg.as_deref()])?;
    match file.scalar {
        ScalarName::F64 => integrate::<f64>(&file, path, csv.as_deref(), svg.as_deref()),
        ScalarName::Dd => integrate::<Dd>(&file, path, csv.as_deref(), svg.as_deref()),
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

fn integrate<T: Real>(
    file: &SystemFile,
    path: &Path,
    csv: Option<&Path>,
    svg: Option<&Path>,
) -> Result<ExitCode, Failure> {
    let plan = file.plan::<T>().map_err(|refused| Failure::file(path, refused))?;
    // A path that cannot be written is known before the run, not after it.
    let out: Box<dyn Write> = match csv {
        Some(csv) => Box::new(File::create(csv).map_err(|error| Failure::file(csv, error))?),
        None => Box::new(io::stdout().lock()),
    };
    if let Some(svg) = svg {
        File::create(svg).map_err(|error| Failure::file(svg, error))?;
    }
    let shown = io::stderr().is_terminal() && (csv.is_some() || !io::stdout().is_terminal());
    let mut recorder = Recorder::new(BufWriter::with_capacity(1 << 16, out), svg.is_some(), shown);
    let run = Run::new(file, plan, &mut recorder);
    let ended = file.case.dispatch::<T, _>(run).map_err(|refused| Failure::file(path, refused))?;
    let rows = recorder.rows();
    let trace = recorder.finish().or_else(|error| match (csv, error.kind()) {
        (Some(csv), _) => Err(Failure::file(csv, error)),
        (None, io::ErrorKind::BrokenPipe) => Ok(None),
        (None, _) => Err(Failure::Output(error)),
    })?;
    if let (Some(svg), Some(trace)) = (svg, &trace) {
        plot::draw(trace, svg).map_err(|reason| Failure::file(svg, reason))?;
    }
    match ended {
        Ended::Failed(reason) => {
            let place = csv.map_or("on standard output".into(), |csv| format!("in {}", csv.display()));
            let rows = if rows == 1 { "row".into() } else { format!("{rows} rows") };
            Err(Failure::Computation(format!("{reason}\nkept {place}: the {rows} up to there")))
        }
        Ended::Whole(summary) => {
            if let Some(csv) = csv {
                printed(writeln!(io::stdout(), "{}: {rows} rows; {summary}", csv.display()))?;
            }
            Ok(ExitCode::SUCCESS)
        }
    }
}
