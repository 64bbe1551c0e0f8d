//! Tableau files: `a`, `b`, and optionally `c`, `order` and `name`, in TOML or JSON.

pub(crate) mod spot;

use super::analysis::{Analysis, analyse};
use super::description::significant;
use super::families::MAX_STAGES;
use super::{Description, Entries, TableauError};
use crate::file::{self, Excerpt};
use crate::scalar::Number;
use spot::Spot;
use std::path::Path;

/// The longest file that is read, in bytes.
pub const LONGEST: usize = 64 * 1024;

/// The largest order that a file may declare.
pub const LARGEST_ORDER: i64 = 200;

/// What may stand for an entry.
const ALLOWED: &str = "allowed are finite numbers and texts such as \"1/3\", \"0.2113\" or \"1/2 - sqrt(3)/6\"";

/// A tableau as a file.
///
/// ```
/// use euler_poincare::tableau::TableauFile;
/// let file = TableauFile::parse("name = \"Heun\"\norder = 2\na = [[0, 0], [1, 0]]\nb = [\"1/2\", 0.5]")?;
/// assert_eq!((file.name.as_deref(), file.order, file.description().stages()), (Some("Heun"), Some(2), 2));
/// let error = TableauFile::parse("a = [[0, \"x\"], [1, 0]]\nb = [0.5, 0.5]").unwrap_err();
/// assert!(error.to_string().starts_with("line 1, column 10: entry a_12: `x` is not a number"));
/// # Ok::<(), euler_poincare::tableau::FileError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct TableauFile {
    /// What the writer calls it.
    pub name: Option<String>,
    /// The order that the writer claims for the variational integrator with this tableau. As a Runge–Kutta method the tableau can have a
    /// higher one.
    pub order: Option<usize>,
    /// a, b and c.
    pub entries: Entries,
}

/// Why a tableau file was refused: with the place, its line and a mark below it, where it is the text that is wrong.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FileError {
    /// There is no file at the path, or it is no text.
    #[error("{why}")]
    Unreadable {
        /// What the operating system says.
        why: String,
    },
    /// The text is longer than [`LONGEST`].
    #[error("a tableau file of {bytes} bytes is too long (at most {LONGEST})")]
    TooLong {
        /// Its length.
        bytes: usize,
    },
    /// The text is no TOML or JSON, or has other keys than a tableau.
    #[error("{}", .place.says(.message))]
    Syntax {
        /// Where.
        place: Excerpt,
        /// What is wrong.
        message: String,
    },
    /// A number that is not in quotes has more digits than an `f64` keeps.
    #[error("{}", .place.says(too_precise(*.digits)))]
    Digits {
        /// Where.
        place: Excerpt,
        /// How many significant digits it has.
        digits: usize,
    },
    /// The order that is declared is none.
    #[error("{}", .place.says(no_order(.found)))]
    Order {
        /// Where.
        place: Excerpt,
        /// What stands there.
        found: String,
    },
    /// The entries are no tableau.
    #[error("{}", .place.says(.error))]
    Tableau {
        /// Where.
        place: Excerpt,
        /// What is wrong with them.
        error: TableauError,
    },
}

fn too_precise(digits: usize) -> String {
    format!("a number with {digits} digits loses some of them (more than {MOST_DIGITS}): put it in quotes")
}

fn no_order(found: &str) -> String {
    format!("order: {found}; allowed is a whole number from 1 to {LARGEST_ORDER}")
}

impl TableauFile {
    /// Reads a file: JSON if it begins with `{`, else TOML.
    ///
    /// # Errors
    /// [`FileError`], with the place in the text and the name of the entry that is wrong; the tableau is built in `f64`, and in
    /// rationals where all entries are, so that the errors of [`Entries::build`] are among them.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        if text.len() > LONGEST {
            return Err(FileError::TooLong { bytes: text.len() });
        }
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let raw = if text.trim_start().starts_with('{') { from_json(text)? } else { from_toml(text)? };
        check_digits(text)?;
        let order = raw.order.map(|cell| order(text, cell)).transpose()?;
        let refused = |(spot, error): (Spot, TableauError)| FileError::Tableau { place: spot.place(text), error };
        let entries = Entries {
            b: list(raw.b, &Spot::of("b")).map_err(refused)?,
            a: matrix(raw.a, &Spot::of("a")).map_err(refused)?,
            c: raw.c.map(|c| list(c, &Spot::of("c"))).transpose().map_err(refused)?,
        };
        // In rationals too, where all entries are: what an f64 cannot see is no tableau either.
        let built = entries.build::<f64>().map(drop).and_then(|()| entries.rational().map(drop));
        built.map_err(|error| refused((Spot::blamed(&error, &entries), error)))?;
        Ok(Self { name: raw.name, order, entries })
    }

    /// Reads the file at a path.
    ///
    /// # Errors
    /// Those of [`TableauFile::parse`]; a file that cannot be read.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let text = file::read(path, LONGEST).map_err(|error| FileError::Unreadable { why: error.to_string() })?;
        Self::parse(&text)
    }

    /// The tableau.
    pub fn description(&self) -> Description {
        Description::Entries(self.entries.clone())
    }

    /// [`analyse`], with the declared order and the name of the file.
    ///
    /// # Errors
    /// Those of [`analyse`].
    pub fn analyse(&self, max: usize) -> Result<Analysis, TableauError> {
        let mut analysis = analyse(&self.description(), max)?;
        analysis.declared = self.order;
        if let Some(name) = &self.name {
            analysis.description.clone_from(name);
        }
        Ok(analysis)
    }
}

#[derive(serde::Deserialize)]
#[serde(deny_unknown_fields)]
struct Raw {
    a: Cell,
    b: Cell,
    c: Option<Cell>,
    order: Option<Cell>,
    name: Option<String>,
}

fn from_json(text: &str) -> Result<Raw, FileError> {
    serde_json::from_str(text).map_err(|error| {
        let place = format!(" at line {} column {}", error.line(), error.column());
        let message = error.to_string().replace(&place, "");
        let line = text.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum::<usize>();
        FileError::Syntax { place: Excerpt::of(text, line + error.column().saturating_sub(1)), message }
    })
}

fn from_toml(text: &str) -> Result<Raw, FileError> {
    toml::from_str(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        FileError::Syntax { place: Excerpt::of(text, at), message: error.message().replace('\n', ", ") }
    })
}

/// Refuses numbers outside quotes (and TOML comments) that have more than 17 significant digits.
fn check_digits(text: &str) -> Result<(), FileError> {
    let mut start = 0;
    for content in text.split_inclusive('\n') {
        let (mut quote, mut escaped, mut token) = (None, false, String::new());
        for (at, c) in content.char_indices().chain([(content.len(), ' ')]) {
            match quote {
                Some(_) if escaped => escaped = false,
                Some('"') if c == '\\' => escaped = true,
                Some(end) if c == end => quote = None,
                Some(_) => {}
                None if c.is_ascii_alphanumeric() || matches!(c, '.' | '_') => token.push(c),
                None => {
                    let digits = significant_digits(&token);
                    if digits > MOST_DIGITS {
                        return Err(FileError::Digits { place: Excerpt::of(text, start + at - token.len()), digits });
                    }
                    token.clear();
                    match c {
                        '#' => break,
                        '"' | '\'' => quote = Some(c),
                        _ => {}
                    }
                }
            }
        }
        start += content.len();
    }
    Ok(())
}

/// As many significant digits of a number that is not in quotes are kept: those of an `f64`.
pub(crate) const MOST_DIGITS: usize = 17;

/// Of a decimal, without its exponent; 0 for what is no number.
pub(crate) fn significant_digits(token: &str) -> usize {
    if token.starts_with(|c: char| c.is_ascii_digit()) { significant(token) } else { 0 }
}

/// Anything that a file may hold, so that what does not belong there can be named.
#[derive(serde::Deserialize)]
#[serde(untagged)]
enum Cell {
    Truth(bool),
    Integer(i64),
    /// What is too large for an `i64`.
    Large(u64),
    Real(f64),
    Text(String),
    List(Vec<Cell>),
    Table {},
    Null,
}

impl Cell {
    fn show(&self) -> String {
        match self {
            Cell::Truth(x) => format!("`{x}`"),
            Cell::Integer(n) => format!("the number {}", Number::from(*n)),
            Cell::Large(n) => format!("the text `{n}`"),
            Cell::Real(x) => format!("the number {x}"),
            Cell::Text(text) => format!("the text `{}`", text.chars().take(40).collect::<String>()),
            Cell::List(_) => "a list".into(),
            Cell::Table {} => "a table or a date".into(),
            Cell::Null => "`null`".into(),
        }
    }
}

/// What is wrong, and where.
type Wrong = (Spot, TableauError);

fn bad(spot: &Spot, why: String) -> Wrong {
    (spot.clone(), TableauError::BadEntry { entry: spot.name(), why })
}

fn number(cell: Cell, spot: &Spot) -> Result<Number, Wrong> {
    match cell {
        Cell::Integer(n) => Ok(Number::from(n)),
        Cell::Large(n) => number(Cell::Text(n.to_string()), spot),
        Cell::Real(x) if x.is_finite() => Ok(Number::from(x)),
        Cell::Text(text) => Number::parse(&text).map_err(|why| bad(spot, format!("{why}; {ALLOWED}"))),
        other => Err(bad(spot, format!("{} is no number; {ALLOWED}", other.show()))),
    }
}

fn list(cell: Cell, spot: &Spot) -> Result<Vec<Number>, Wrong> {
    let Cell::List(cells) = cell else {
        return Err(bad(spot, format!("must be a list of numbers, and is {}", cell.show())));
    };
    if cells.len() > MAX_STAGES {
        return Err(bad(spot, format!("has {} entries; allowed are at most {MAX_STAGES} stages", cells.len())));
    }
    cells.into_iter().enumerate().map(|(j, cell)| number(cell, &spot.entry(j))).collect()
}

fn matrix(cell: Cell, spot: &Spot) -> Result<Vec<Vec<Number>>, Wrong> {
    let Cell::List(rows) = cell else {
        return Err(bad(spot, format!("must be a list of rows, and is {}", cell.show())));
    };
    if rows.len() > MAX_STAGES {
        return Err(bad(spot, format!("has {} rows; allowed are at most {MAX_STAGES} stages", rows.len())));
    }
    rows.into_iter().enumerate().map(|(i, row)| list(row, &spot.entry(i))).collect()
}

fn order(text: &str, cell: Cell) -> Result<usize, FileError> {
    let found = cell.show();
    let whole = match cell {
        Cell::Integer(n) => Some(n as f64),
        _ => None,
    };
    match whole {
        Some(n) if (1.0..=LARGEST_ORDER as f64).contains(&n) => Ok(n as usize),
        _ => Err(FileError::Order { place: Spot::of("order").place(text), found }),
    }
}
