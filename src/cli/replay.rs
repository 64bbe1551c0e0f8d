//! `replay`.

use super::Failure;
use std::process::ExitCode;

/// Options of `replay`.
#[derive(clap::Args)]
pub struct Arguments {}

pub fn run(_arguments: Arguments) -> Result<ExitCode, Failure> {
    Err(Failure::Usage("not implemented".into()))
}
