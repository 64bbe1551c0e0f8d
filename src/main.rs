//! The command line: arguments → library calls, nothing else.

mod cli;

use clap::Parser;
use std::process::ExitCode;

fn main() -> ExitCode {
    cli::CommandLine::parse().run()
}
