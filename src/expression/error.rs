//! What is wrong with a formula, and where.

use std::fmt;

/// A place in the text of a formula or of a definition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Spot {
    /// The text.
    pub text: String,
    /// The definition whose text it is, if it is one.
    pub definition: Option<String>,
    /// The byte.
    pub at: usize,
}

/// As many characters of a line are printed: with what stands before them they fit in 80 columns.
const WIDTH: usize = 70;

impl Spot {
    /// Line and column, from 1, and the text of the line.
    fn line(&self) -> (usize, usize, &str) {
        let mut at = self.at.min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        let start = self.text[..at].rfind('\n').map_or(0, |newline| newline + 1);
        let line = self.text[start..].lines().next().unwrap_or("");
        (self.text[..start].matches('\n').count() + 1, self.text[start..at].chars().count() + 1, line)
    }

    fn print(&self, f: &mut fmt::Formatter<'_>, what: &dyn fmt::Display) -> fmt::Result {
        let (line, column, text) = self.line();
        if let Some(name) = &self.definition {
            write!(f, "in the definition of `{name}`, ")?;
        }
        if line > 1 {
            write!(f, "line {line}, ")?;
        }
        write!(f, "column {column}: {what}")?;
        if text.trim().is_empty() {
            return Ok(());
        }
        // A long line is cut so that the place is in the middle of what is shown.
        let first = if text.chars().count() > WIDTH { (column - 1).saturating_sub(WIDTH / 2) } else { 0 };
        let shown: String =
            text.chars().skip(first).take(WIDTH).map(|c| if c.is_control() { ' ' } else { c }).collect();
        write!(f, "\n    {shown}\n    {}^", " ".repeat(column - 1 - first))
    }
}

/// Why a formula was refused, with what is allowed, or why it has no value; and where in the formula.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExpressionError {
    pub(super) spot: Spot,
    pub(super) message: String,
}

impl ExpressionError {
    /// What is wrong, without the place.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// The text that it is in, of the formula or the definition; none where that is too long to be shown.
    pub fn text(&self) -> Option<&str> {
        Some(self.spot.text.as_str()).filter(|text| !text.is_empty())
    }

    /// The byte of the text at which it is.
    pub fn position(&self) -> usize {
        self.spot.at
    }

    /// The definition in whose text it is; none: in the formula itself.
    pub fn definition(&self) -> Option<&str> {
        self.spot.definition.as_deref()
    }
}

impl fmt::Display for ExpressionError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.spot.print(f, &self.message)
    }
}

impl std::error::Error for ExpressionError {}
