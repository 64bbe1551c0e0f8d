//! Renders the mathematics of the documentation.
//!
//! `src/guide/source/**/*.md` is Markdown with LaTeX between `$…$` and `$$…$$`. For each file this program writes the file of the
//! same name under `src/guide/rendered/`, with MathML instead of the LaTeX. Browsers show MathML without a script or a network.
//! The library includes the written files where they are there, and the sources where they are not.
//!
//! ```text
//! cargo run --locked --manifest-path properties/guide/Cargo.toml
//! ```

mod formula;
mod page;

use std::error::Error;
use std::path::{Path, PathBuf};

/// Renders each source.
fn main() -> Result<(), Box<dyn Error>> {
    let guide = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../src/guide");
    let (source, rendered) = (guide.join("source"), guide.join("rendered"));
    for path in markdown(&source)? {
        let name = path.strip_prefix(&source)?;
        let text = std::fs::read_to_string(&path)?;
        let page = page::render(&text).map_err(|error| format!("source/{}: {error}", name.display()))?;
        let target = rendered.join(name);
        if !std::fs::read_to_string(&target).is_ok_and(|old| old == page) {
            std::fs::create_dir_all(target.parent().ok_or("a file has a folder")?)?;
            std::fs::write(&target, page)?;
        }
    }
    Ok(())
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
