//! A place in a text.

use std::fmt::Display;

/// As much of a line is shown.
const LONGEST: usize = 120;

/// A place in a text, and the line that is there.
///
/// ```
/// use euler_poincare::file::Excerpt;
///
/// let place = Excerpt::of("a = 1\nb = x\n", 10);
/// assert_eq!((place.line, place.column, place.text.as_str()), (2, 5, "b = x"));
/// assert_eq!(place.says("no number"), "line 2, column 5: no number\n2 | b = x\n        ^");
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
    /// The text of that line.
    pub text: String,
}

impl Excerpt {
    /// The place of the byte `at` of `text`; the end, where `at` lies beyond it.
    pub fn of(text: &str, at: usize) -> Self {
        let mut at = at.min(text.len());
        while !text.is_char_boundary(at) {
            at -= 1;
        }
        let start = text[..at].rfind('\n').map_or(0, |newline| newline + 1);
        let line = text[..start].matches('\n').count() + 1;
        let excerpt = text[start..].lines().next().unwrap_or("").chars().take(LONGEST).collect();
        Self { line, column: text[start..at].chars().count() + 1, text: excerpt }
    }

    /// A message about the place, with the line and a mark below it.
    pub fn says(&self, message: impl Display) -> String {
        let Self { line, column, text } = self;
        let said = format!("line {line}, column {column}: {message}");
        if text.trim().is_empty() {
            return said;
        }
        let number = line.to_string();
        let indent = " ".repeat(number.len() + column + 2);
        format!("{said}\n{number} | {text}\n{indent}^")
    }
}
