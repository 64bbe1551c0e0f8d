//! The sub-commands, one file each, and what they share: failures and exit codes.

mod algebras;
pub mod completions;
mod failure;
mod faults;
mod figures;
pub mod integrate;
mod interrupt;
pub mod laws;
mod levels;
pub mod man;
pub mod merge;
pub mod order;
mod output;
pub mod paper;
mod plot;
pub mod probe;
mod program;
mod progress;
pub mod replay;
pub mod report;
mod schema;
mod summary;
mod table;
mod tableau;
pub mod verify;
mod version;

use clap::{Parser, Subcommand, ValueEnum};
use euler_poincare::file::spelled;
use euler_poincare::harness::Verdict;
use euler_poincare::harness::store::StoreError;
use std::fmt::Display;
use std::io::{self, IsTerminal, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Forced variational integrators on Lie groups, and the harness that verifies them.
///
/// Without a sub-command: three things to try.
#[derive(Parser)]
#[command(version = version::VERSION, after_help = EXIT_CODES, term_width = table::prose_width())]
pub struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
}

/// What is printed without a sub-command: a screen of 24 lines.
const FIRST: &str = "\
Forced variational integrators on Lie groups, and a harness that verifies them.

Three things to try:

  1. Integrate a heavy top: a table of its motion, and a picture of it.
       euler-poincare integrate --example heavy-top > top.toml
       euler-poincare integrate top.toml --out top.csv --plot top.svg

  2. Check some laws of the theory on random systems, in a second or two.
       euler-poincare verify --laws 'retraction-*'

  3. Compute and measure the order of a Runge-Kutta method in this scheme.
       euler-poincare order --tableau ralston3

Also: `verify` alone checks every law, in a minute or two. `probe` judges a
stepper of your own, in any language.

  euler-poincare --help             all commands, and the exit codes
  euler-poincare COMMAND --help     the options of a command
";

const EXIT_CODES: &str = "\
Exit codes:
  0    success: nothing is broken, the order is confirmed
  1    a law is broken, an order is refuted, a step of an integration failed
  2    bad usage, a bad file, or output that cannot be written
  3    no verdict: nothing was judged, or what was judged could not be decided
  130  interrupted (Ctrl-C or SIGTERM); what there is so far is kept or printed";

#[derive(Subcommand)]
enum Command {
    /// Integrate a system described in a file
    Integrate(integrate::Arguments),
    /// Check the laws on random systems
    Verify(verify::Arguments),
    /// The orders of a tableau: declared, computed from its coefficients, measured
    Order(order::Arguments),
    /// Check the laws of methods on a stepper that is another program
    Probe(probe::Arguments),
    /// Put the shards of a campaign together
    Merge(merge::Arguments),
    /// Run a saved case again
    Replay(replay::Arguments),
    /// Make a page for a browser out of a campaign
    Report(report::Arguments),
    /// List the laws: statement, source, oracle, planted faults
    Laws(laws::Arguments),
    /// Reproduce the tables and figures of the paper
    Paper(paper::Arguments),
    /// List the algebras that system files may name, with their bases
    Algebras(algebras::Arguments),
    /// Print the completions for a shell
    Completions(completions::Arguments),
    /// Print the manual page, in roff
    Man(man::Arguments),
}

impl CommandLine {
    /// Runs the sub-command; failures go to stderr.
    pub fn run(self) -> ExitCode {
        let Some(command) = self.command else { return ended(print(FIRST).map(|()| ExitCode::SUCCESS)) };
        ended(match command {
            Command::Verify(arguments) => verify::run(arguments),
            Command::Merge(arguments) => merge::run(arguments),
            Command::Replay(arguments) => replay::run(arguments),
            Command::Report(arguments) => report::run(arguments),
            Command::Laws(arguments) => laws::run(arguments),
            Command::Probe(arguments) => probe::run(arguments),
            Command::Order(arguments) => order::run(arguments),
            Command::Paper(arguments) => paper::run(arguments),
            Command::Integrate(arguments) => integrate::run(arguments),
            Command::Algebras(arguments) => algebras::run(arguments),
            Command::Completions(arguments) => completions::run(arguments),
            Command::Man(arguments) => man::run(arguments),
        })
    }
}

/// The exit code of a result; a failure is told on stderr.
fn ended(result: Result<ExitCode, Failure>) -> ExitCode {
    result.unwrap_or_else(|failure| {
        complain(&format!("error: {failure}"));
        failure.exit_code()
    })
}

/// Why a sub-command could not do what it was asked.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// Arguments that mean nothing; the text says what is allowed.
    #[error("{0}")]
    Usage(String),
    /// A file that cannot be read, understood or written.
    #[error("{}: {reason}", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// A campaign's directory that cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A computation that came to no result.
    #[error("{0}")]
    Computation(String),
    /// What the operating system refused: threads, signals.
    #[error("{0}")]
    System(String),
    /// Standard output failed (a closed pipe is no failure, see [`printed`]).
    #[error("cannot write to standard output: {0}")]
    Output(io::Error),
}

impl Failure {
    /// The file `path` is at fault.
    pub fn file(path: &Path, reason: impl Display) -> Self {
        Self::File { path: path.to_owned(), reason: reason.to_string() }
    }

    fn exit_code(&self) -> ExitCode {
        match self {
            Self::Usage(_) | Self::File { .. } | Self::Store(_) | Self::System(_) | Self::Output(_) => {
                ExitCode::from(2)
            }
            Self::Computation(_) => ExitCode::from(1),
        }
    }
}

/// The exit code of a command that asks for one verdict.
pub fn verdict_code(verdict: &Verdict) -> ExitCode {
    match verdict {
        Verdict::Holds { .. } => ExitCode::SUCCESS,
        Verdict::Broken { .. } => ExitCode::from(1),
        Verdict::Inconclusive { .. } | Verdict::NotApplicable { .. } => ExitCode::from(3),
    }
}

/// How results are printed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// Tables, as wide as the terminal (100 columns where the output is no terminal).
    Text,
    /// One JSON object per line.
    Json,
}

/// Runs the command of this process's arguments. Help that cannot be written is an error, as any other output.
pub fn main() -> ExitCode {
    match CommandLine::try_parse() {
        Ok(line) => line.run(),
        Err(answer) => match printed(answer.print()) {
            Ok(()) => ExitCode::from(u8::try_from(answer.exit_code()).unwrap_or(2)),
            Err(failure) => {
                eprintln!("error: {failure}");
                failure.exit_code()
            }
        },
    }
}

/// Writes a message to standard error; on a terminal it is wrapped, but for the lines of a file that it shows.
pub fn complain(message: &str) {
    let message = &spelled(message);
    if !io::stderr().is_terminal() {
        eprintln!("{message}");
        return;
    }
    // The line of a file that is shown, and the mark below it, belong together.
    let shown = |line: &str| {
        let numbered = line.split_once(" | ").is_some_and(|(number, _)| number.parse::<usize>().is_ok());
        numbered || line.trim_start() == "^"
    };
    for line in message.lines() {
        if shown(line) { eprintln!("{line}") } else { eprintln!("{}", table::paragraph(line)) }
    }
}

/// Writes `text` to standard output. What files and programs say is in it: it has no power over a terminal.
pub fn print(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    printed(out.write_all(spelled(text).as_bytes()).and_then(|()| out.flush()))
}

/// The outcome of writing to standard output. Who closes the pipe has seen enough: that is no failure.
pub fn printed(result: io::Result<()>) -> Result<(), Failure> {
    match result {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => Err(Failure::Output(error)),
        _ => Ok(()),
    }
}
