//! `man`: the manual pages of the command and its sub-commands.

use super::{CommandLine, Failure, print};
use clap::CommandFactory;
use clap_mangen::Man;
use euler_poincare::file;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Options of `man`.
#[derive(clap::Args)]
pub struct Arguments {
    /// Write a page for the command and one for each sub-command into this directory, instead of the first to standard
    /// output
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let command = CommandLine::command();
    if let Some(directory) = &arguments.out {
        fs::create_dir_all(directory).map_err(|error| Failure::file(directory, error))?;
        let mut command = command.disable_help_subcommand(true);
        command.build();
        for command in std::iter::once(&command).chain(command.get_subcommands()) {
            let (page, path) = page(command.clone(), directory);
            file::write(&path, page).map_err(|error| Failure::file(&path, error))?;
        }
    } else {
        print(&String::from_utf8_lossy(&page(command, Path::new("")).0))?;
    }
    Ok(ExitCode::SUCCESS)
}

/// The page of a command, and its file in a directory.
fn page(command: clap::Command, directory: &Path) -> (Vec<u8>, PathBuf) {
    let man = Man::new(command);
    let mut page = Vec::new();
    // Writing to a Vec cannot fail.
    let _ = man.render(&mut page);
    (page, directory.join(man.get_filename()))
}
