//! Renders the mathematics of the documentation.
//!
//! `src/guide/source/**/*.md` is Markdown with LaTeX between `$…$` and `$$…$$`. For each file this program writes the file of the
//! same name under `src/guide/`, with MathML in the place of the LaTeX. Browsers show MathML without a script or a network.
//! The library includes the written files with `#![doc = include_str!(…)]`.
//!
//! ```text
//! cargo run --locked --manifest-path properties/guide/Cargo.toml             writes the files
//! cargo run --locked --manifest-path properties/guide/Cargo.toml -- --check  compares only; exit code 1 if one is out of date
//! ```

mod formula;
mod page;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

fn main() -> ExitCode {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../src/guide");
    let check = match std::env::args().skip(1).collect::<Vec<_>>().as_slice() {
        [] => false,
        [option] if option == "--check" => true,
        _ => {
            eprintln!("usage: guide [--check]");
            return ExitCode::from(2);
        }
    };
    match run(&guide, check) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}

/// Renders each source. Returns whether every file was up to date, or was written.
fn run(guide: &Path, check: bool) -> Result<bool, Box<dyn Error>> {
    let source = guide.join("source");
    let mut ok = true;
    for path in markdown(&source)? {
        let name = path.strip_prefix(&source)?;
        let text = std::fs::read_to_string(&path)?;
        let rendered = page::render(&text).map_err(|error| format!("source/{}: {error}", name.display()))?;
        let target = guide.join(name);
        if std::fs::read_to_string(&target).is_ok_and(|old| old == rendered) {
            continue;
        }
        if check {
            eprintln!("src/guide/{} is out of date", name.display());
            ok = false;
        } else {
            std::fs::create_dir_all(target.parent().expect("a file has a folder"))?;
            std::fs::write(&target, rendered)?;
            println!("wrote src/guide/{}", name.display());
        }
    }
    if !ok {
        eprintln!("run: cargo run --locked --manifest-path properties/guide/Cargo.toml");
    }
    Ok(ok)
}

/// The Markdown files under a folder, sorted.
fn markdown(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            files.extend(markdown(&path)?);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}
