//! `replay FILE`: a saved case under its law.

use super::failure::text;
use super::summary::count;
use super::table::paragraph;
use super::{Failure, Format, print, probe, verdict_code};
use euler_poincare::external::Record;
use euler_poincare::file::{self, Output};
use euler_poincare::laws::replay::Replayed;
use euler_poincare::system::Replay;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// The most checks in the search for a smaller case. A number, not a time: the same case on every machine.
const SHRINK_CHECKS: usize = 2000;

/// Options of `replay`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A file that `verify` or `probe` saved
    file: PathBuf,
    /// Look for a simpler case on which the law is still broken, and save it next to FILE
    #[arg(long)]
    shrink: bool,
    /// Judge by the evaluation in 16 or in 32 digits alone [default: by those that the law is judged by]
    #[arg(long, value_name = "16|32", value_parser = ["16", "32"])]
    digits: Option<String>,
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let path = &arguments.file;
    let digits = arguments.digits.as_deref().map(|digits| if digits == "16" { 16 } else { 32 });
    let json = file::read(path, file::LONGEST).map_err(|error| Failure::file(path, error))?;
    if Record::is_one(&json) {
        if arguments.shrink || arguments.digits.is_some() {
            let why = "`probe` saved this file; --shrink and --digits are for files that `verify` saved";
            return Err(Failure::file(path, why));
        }
        return probe::replay(path, &json, &[], (None, None), Format::Text);
    }
    let replayed = Replayed::from_json(&json, digits).map_err(|error| Failure::file(path, error))?;
    let verdict = replayed.verdict.clone();
    if !arguments.shrink {
        print(&text(&replayed, Some(path)))?;
    } else if let Some((smaller, found)) = replayed.shrunk(digits, SHRINK_CHECKS) {
        if found.steps == 0 {
            let none = format!("none of {} simpler cases breaks the law\n", found.checks);
            print(&format!("{}\n{none}", text(&replayed, Some(path))))?;
        } else {
            // Saved before it is printed, so that a closed pipe loses nothing.
            let saved = save(path, &smaller.replay)?;
            let steps = format!(
                "simpler in {}, found with {}; saved in",
                count(found.steps, "step"),
                count(found.checks, "check")
            );
            let steps = paragraph(&format!("{steps} {}", saved.display()));
            print(&format!("{}\n{steps}\n", text(&smaller, Some(&saved))))?;
        }
    } else {
        print(&format!("{}\nthe law is not broken on this case: nothing to shrink\n", text(&replayed, Some(path))))?;
    }
    Ok(verdict_code(&verdict))
}

/// The largest number of smaller cases saved per file.
const MOST_SMALLER: usize = 1000;

/// Writes the record next to `path`, under a name that is not taken.
fn save(path: &Path, replay: &Replay) -> Result<PathBuf, Failure> {
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default();
    let json = replay.to_json().map_err(|error| Failure::System(error.to_string()))? + "\n";
    let mut k = 1;
    loop {
        let name = if k == 1 { format!("{stem}-smaller.json") } else { format!("{stem}-smaller-{k}.json") };
        let saved = path.with_file_name(name);
        let failed = |error| Failure::file(&saved, error);
        // Never over a file that is there, or that another run writes.
        match Output::create(&saved) {
            Ok(mut file) if !saved.exists() => {
                file.write_all(json.as_bytes()).and_then(|()| file.commit()).map_err(failed)?;
                return Ok(saved);
            }
            Err(error) if error.kind() != ErrorKind::ResourceBusy => return Err(failed(error)),
            Ok(_) | Err(_) if k < MOST_SMALLER => k += 1,
            Ok(_) | Err(_) => return Err(Failure::file(&saved, "exists already, and so do all others of this name")),
        }
    }
}
