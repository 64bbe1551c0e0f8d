//! `man`: the manual pages of the command and its sub-commands.

use super::{CommandLine, Failure, print};
use clap::CommandFactory;
use clap_mangen::Man;
use std::fs;
use std::path::PathBuf;
use std::process::ExitCode;

/// Options of `man`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Write a page for the command and one for each sub-command into this directory, in the place of the first to standard
    /// output
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let command = CommandLine::command();
    if let Some(directory) = &arguments.out {
        fs::create_dir_all(directory)
            .and_then(|()| clap_mangen::generate_to(command, directory))
            .map_err(|error| Failure::file(directory, error))?;
    } else {
        let mut page = Vec::new();
        // Writing to a Vec cannot fail.
        let _ = Man::new(command).render(&mut page);
        print(&String::from_utf8_lossy(&page))?;
    }
    Ok(ExitCode::SUCCESS)
}
