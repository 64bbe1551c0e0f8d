//! Events, as files describe them.

use serde::{Deserialize, Serialize};

/// An event: where a formula in the quantities of a system passes zero.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventFormula {
    /// What it is called; by default its formula.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The formula, with one value.
    pub formula: String,
    /// In which direction it counts; `None`: in both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
    /// Whether the run ends at the first of them.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub terminal: bool,
}

/// How a function passes zero, in the direction of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// From below.
    Rising,
    /// From above.
    Falling,
}

impl EventFormula {
    /// The name, or the formula.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.formula)
    }
}
