//! The tableau that an option names.

use super::Failure;
use euler_poincare::tableau::{Description, TableauFile};
use std::path::Path;

/// A tableau by its name, or from a file.
pub struct Named {
    /// What it is.
    pub description: Description,
    /// The file, if it is from one.
    pub file: Option<TableauFile>,
}

impl Named {
    /// The tableau of a name, or of the file at a path: what is no name and has neither a separator nor a dot in it has to exist.
    pub fn read(argument: &str) -> Result<Self, Failure> {
        let unknown = match argument.parse() {
            Ok(description) => return Ok(Self { description, file: None }),
            Err(error) => error,
        };
        let path = Path::new(argument);
        if !path.exists() && !argument.contains(['/', '\\', '.']) {
            return Err(Failure::Usage(format!("{unknown}")));
        }
        let file = TableauFile::open(path).map_err(|error| Failure::file(path, error))?;
        Ok(Self { description: file.description(), file: Some(file) })
    }
}
