//! A failing case on file: which law, which campaign, which planted fault, and the case itself.

use super::case::Case;
use super::document::Document;
use super::error::{CaseError, Place, Problem};
use serde::{Deserialize, Serialize};

/// What `replay` runs again: one JSON object, with the case in the shape of a system file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Replay {
    /// Name of the law.
    pub law: String,
    /// Seed of the campaign.
    pub seed: u64,
    /// Index of the case in it, before shrinking.
    pub index: u64,
    /// Name of the planted fault, if the failure was wanted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<String>,
    /// The case, shrunk.
    pub case: Case,
}

impl Replay {
    /// The record as indented JSON.
    ///
    /// # Errors
    /// The serialiser's, as text.
    pub fn to_json(&self) -> Result<String, CaseError> {
        serde_json::to_string_pretty(self).map_err(|error| Place::root().error(Problem::Part(error.to_string())))
    }

    /// The record in a JSON text; the case is built once to check it.
    ///
    /// # Errors
    /// Malformed JSON (with line and column), unknown keys, or a case that cannot be built.
    pub fn from_json(text: &str) -> Result<Self, CaseError> {
        let replay: Self =
            serde_json::from_str(text).map_err(|error| Place::root().error(Problem::Part(error.to_string())))?;
        replay.case.check()?;
        Ok(replay)
    }
}

impl Case {
    /// The case as one line of JSON.
    ///
    /// # Errors
    /// The serialiser's, as text.
    pub fn to_json(&self) -> Result<String, CaseError> {
        serde_json::to_string(&Document::from(self.clone()))
            .map_err(|error| Place::root().error(Problem::Part(error.to_string())))
    }
}
