//! Files that the sub-commands write: taken before the work, in their place when they are whole.

use super::Failure;
use super::plot::Figure;
use euler_poincare::file::{self, Output};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The path of a figure.
pub fn svg(path: &str) -> Result<PathBuf, &'static str> {
    let fits = file::ends_in(Path::new(path), "svg");
    if fits { Ok(path.into()) } else { Err("figures are SVG: the name of the file ends in .svg") }
}

/// The file at a path, for this process alone.
pub fn create(path: &Path) -> Result<Output, Failure> {
    Output::create(path).map_err(|error| Failure::file(path, error))
}

/// Writes all of it.
pub fn write(mut output: Output, path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), Failure> {
    output.write_all(bytes.as_ref()).and_then(|()| output.commit()).map_err(|error| Failure::file(path, error))
}

/// Writes the figure.
pub fn draw(output: Output, path: &Path, figure: &Figure) -> Result<(), Failure> {
    let svg = figure.svg().map_err(|reason| Failure::file(path, reason))?;
    // Titles are names that the user chose, and control characters have no place in XML.
    write(output, path, file::spelled(&svg))
}
