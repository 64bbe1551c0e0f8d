//! A broken case on file.

use super::counterexample::{Compared, Slopes};
use crate::laws::method::Claims;
use crate::system::{Case, CaseError, CaseProblem, Place};
use serde::{Deserialize, Serialize};

/// A broken case on file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// Name of the law.
    pub law: String,
    /// The program and its arguments.
    pub command: Vec<String>,
    /// Its time limit for an answer, in seconds.
    pub timeout: f64,
    /// What was claimed of it.
    #[serde(default)]
    pub claims: Claims,
    /// Seed of the campaign.
    #[serde(default)]
    pub seed: u64,
    /// Index of the case in it, before it was shrunk.
    #[serde(default)]
    pub index: u64,
    /// The case, shrunk.
    pub case: Case,
    /// A request, its answer and the solution, for the reader.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exchange: Option<Compared>,
    /// The errors from which the order was read, for the reader.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub slopes: Vec<Slopes>,
}

impl Record {
    /// The record as indented JSON.
    ///
    /// # Errors
    /// The serialiser's, as text.
    pub fn to_json(&self) -> Result<String, CaseError> {
        serde_json::to_string_pretty(self).map_err(|error| Place::root().error(CaseProblem::Part(error.to_string())))
    }

    /// The record in a JSON text; the case is built once to check it.
    ///
    /// # Errors
    /// Malformed JSON (with line and column), unknown keys, or a case that cannot be built.
    pub fn from_json(text: &str) -> Result<Self, CaseError> {
        let part = |error: String| Place::root().error(CaseProblem::Part(error));
        let record: Self = serde_json::from_str(text).map_err(|error| part(error.to_string()))?;
        if !(record.timeout > 0.0 && record.timeout <= 86400.0) || record.command.is_empty() {
            return Err(part("a record has a command, and a time limit from 0 to 86400 s".into()));
        }
        record.case.check()?;
        Ok(record)
    }

    /// Whether a JSON text looks like such a record, and not like one of [`crate::system::Replay`]: it has a command.
    pub fn is_one(text: &str) -> bool {
        let value: Option<serde_json::Value> = serde_json::from_str(text).ok();
        value.is_some_and(|value| value.get("command").is_some() && value.get("law").is_some())
    }
}
