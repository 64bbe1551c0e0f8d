//! A failing case on file: which law, which campaign, which planted fault, and the case itself.

use super::case::Case;
use super::error::{CaseError, CaseProblem, Place};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

/// What is judged again: one JSON object. A case of `verify` has the shape of a system file, and `replay` runs it; a case of a suite
/// on a user's types names its module, whose tests run it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Replay<C = Case> {
    /// The module of the suite ([`laws!`](crate::laws!)) on whose types the case was judged; `None` for the catalogue.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub module: Option<String>,
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
    pub case: C,
}

impl<C: Serialize> Replay<C> {
    /// The record as indented JSON.
    ///
    /// # Errors
    /// The serialiser's, as text.
    pub fn to_json(&self) -> Result<String, CaseError> {
        serde_json::to_string_pretty(self).map_err(|error| Place::root().error(CaseProblem::Part(error.to_string())))
    }
}

impl<C: DeserializeOwned> Replay<C> {
    /// The record in a JSON text; the case is not looked at.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        serde_json::from_str(text).map_err(|error| error.to_string())
    }
}

impl Replay {
    /// The module that a record names, whatever its case.
    pub(crate) fn module_of(text: &str) -> Option<String> {
        Replay::<serde_json::Value>::parse(text).ok()?.module
    }

    /// The record in a JSON text; the case is built once to check it.
    ///
    /// # Errors
    /// Malformed JSON (with line and column), unknown keys, or a case that cannot be built.
    pub fn from_json(text: &str) -> Result<Self, CaseError> {
        let replay = Self::parse(text).map_err(|error| Place::root().error(CaseProblem::Part(error)))?;
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
        serde_json::to_string(self).map_err(|error| Place::root().error(CaseProblem::Part(error.to_string())))
    }
}
