//! What a system file is read with, beside its text.

use super::document::{MethodTable, ScalarName};
use super::error::{CaseError, CaseProblem, Place};
use crate::tableau::{Description, TableauFile};
use std::path::{Path, PathBuf};
use toml::de::DeTable;

/// How a system file is read: what replaces parts of it, and where the files are that it names.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// The scalar.
    pub scalar: Option<ScalarName>,
    /// The tableau.
    pub tableau: Option<Description>,
    /// Where the files are that the text names; `None`: it may name none.
    pub directory: Option<PathBuf>,
}

impl Reading {
    /// The file at a path, as it is: the files that it names are in its directory.
    pub fn beside(path: &Path) -> Self {
        Self { directory: Some(path.parent().unwrap_or(Path::new("")).to_owned()), ..Self::default() }
    }

    /// The tableau file that the text of a system file names, whether it is read or not: no output goes there.
    pub fn tableau_file(&self, text: &str) -> Option<PathBuf> {
        let table = DeTable::parse(text).ok()?;
        let name = table.get_ref().get("method")?.get_ref().as_table()?.get("tableau-file")?.get_ref().as_str()?;
        Some(self.directory.as_ref()?.join(name))
    }

    /// Puts the tableau instead of that of the file, or of the file that it names.
    pub(super) fn complete(&self, method: &mut MethodTable) -> Result<(), CaseError> {
        if let Some(tableau) = &self.tableau {
            method.put(tableau.clone());
            return Ok(());
        }
        let (Some(name), Some(directory)) = (&method.tableau_file, &self.directory) else { return Ok(()) };
        let place = Place::root().key("method").key("tableau-file");
        if method.tableau.is_some() || method.a.is_some() || method.b.is_some() || method.c.is_some() {
            return Err(place.excess("either `tableau`, or `tableau-file`, or `a` and `b`, one of these alone"));
        }
        let file = TableauFile::open(&directory.join(name))
            .map_err(|error| place.error(CaseProblem::Part(format!("{name}: {error}"))))?;
        method.put(file.description());
        Ok(())
    }
}
