//! What may be named in a formula.

use super::Shape;
use super::error::{ExpressionError, Spot};
use super::graph::Unary;
use crate::scalar::Number;
use std::collections::BTreeMap;

/// A function: its name, how many arguments it takes, and what they are.
pub(super) struct Function {
    pub name: &'static str,
    pub arguments: usize,
    pub takes: &'static str,
    /// The operation that it is, on a number.
    pub unary: Option<Unary>,
}

const fn function(name: &'static str, arguments: usize, takes: &'static str) -> Function {
    Function { name, arguments, takes, unary: None }
}

const fn of_number(name: &'static str, unary: Unary) -> Function {
    Function { unary: Some(unary), ..function(name, 1, "a number") }
}

/// The functions, by name.
pub(super) static FUNCTIONS: [Function; 22] = [
    of_number("abs", Unary::Abs),
    of_number("acos", Unary::Acos),
    of_number("asin", Unary::Asin),
    of_number("atan", Unary::Atan),
    function("atan2", 2, "two numbers"),
    function("column", 2, "a matrix and an index"),
    of_number("cos", Unary::Cos),
    of_number("cosh", Unary::Cosh),
    function("cross", 2, "two vectors of 3 components"),
    function("dot", 2, "two vectors of one length"),
    of_number("exp", Unary::Exp),
    of_number("log", Unary::Log),
    function("norm", 1, "a vector"),
    function("row", 2, "a matrix and an index"),
    of_number("sin", Unary::Sin),
    of_number("sinh", Unary::Sinh),
    of_number("sqrt", Unary::Sqrt),
    of_number("tan", Unary::Tan),
    of_number("tanh", Unary::Tanh),
    function("trace", 1, "a square matrix"),
    function("transpose", 1, "a matrix"),
    function("vee", 1, "a 3×3 matrix"),
];

/// What a name means.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    /// Quantities, by their places; those of a matrix by rows.
    Places(Shape, Vec<usize>),
    /// Parameters.
    Numbers(Shape, Vec<Number>),
    /// The text of a formula.
    Definition(String),
}

/// The quantities, parameters and definitions that formulas may name.
///
/// Quantities take places in one list of numbers, in the order in which they are declared. A vector `eta` also declares its components
/// `eta_1`, `eta_2`, …; a matrix `g` its entries `g_11`, `g_12`, … (from ten rows or columns on `g_1_10`).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    meanings: BTreeMap<String, Meaning>,
    places: usize,
}

impl Names {
    /// No names.
    pub fn new() -> Self {
        Self::default()
    }

    /// How many places the quantities take.
    pub fn places(&self) -> usize {
        self.places
    }

    fn declare(&mut self, name: &str, meaning: Meaning) -> Result<&mut Self, ExpressionError> {
        let refused = |message: String| Err(refused(name, message));
        let letters = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_alphabetic()) || !name.chars().all(letters) {
            return refused("is no name; allowed: a letter, then letters, digits and `_`".into());
        }
        if name == "pi" || name == "deg" || FUNCTIONS.iter().any(|function| function.name == name) {
            return refused(format!(
                "`{name}` is a function or a constant of every formula, and cannot be another thing"
            ));
        }
        if self.meanings.contains_key(name) {
            return refused(format!("`{name}` has a meaning already, and cannot have another"));
        }
        self.meanings.insert(name.into(), meaning);
        Ok(self)
    }

    /// A quantity.
    ///
    /// # Errors
    /// What is no name, or has a meaning: so for all methods here.
    pub fn scalar(&mut self, name: &str) -> Result<&mut Self, ExpressionError> {
        self.places += 1;
        self.declare(name, Meaning::Places(Shape::Scalar, vec![self.places - 1]))
    }

    /// A vector of n quantities, and its components.
    ///
    /// # Errors
    /// Those of [`Names::scalar`].
    pub fn vector(&mut self, name: &str, n: usize) -> Result<&mut Self, ExpressionError> {
        self.places += n;
        self.vector_of(name, (self.places - n..self.places).collect())
    }

    /// A vector of quantities that have places, and its components.
    ///
    /// # Errors
    /// Those of [`Names::scalar`].
    pub fn vector_of(&mut self, name: &str, places: Vec<usize>) -> Result<&mut Self, ExpressionError> {
        for (k, place) in places.iter().enumerate() {
            self.declare(&format!("{name}_{}", k + 1), Meaning::Places(Shape::Scalar, vec![*place]))?;
        }
        self.declare(name, Meaning::Places(Shape::Vector(places.len()), places))
    }

    /// A `rows` × `columns` matrix of quantities, whose places go row by row, and its entries.
    ///
    /// # Errors
    /// Those of [`Names::scalar`].
    pub fn matrix(&mut self, name: &str, rows: usize, columns: usize) -> Result<&mut Self, ExpressionError> {
        let first = self.places;
        self.places += rows * columns;
        let row = |r: usize| (0..columns).map(|c| first + r * columns + c).collect();
        self.matrix_of(name, (0..rows).map(row).collect())
    }

    /// A matrix of quantities that have places, by rows.
    ///
    /// # Errors
    /// Those of [`Names::scalar`].
    pub fn matrix_of(&mut self, name: &str, rows: Vec<Vec<usize>>) -> Result<&mut Self, ExpressionError> {
        let columns = rows.first().map_or(0, Vec::len);
        if columns == 0 || rows.iter().any(|row| row.len() != columns) {
            return Err(refused(name, "a matrix has rows of equal length, at least one".into()));
        }
        let small = rows.len() < 10 && rows.iter().all(|row| row.len() < 10);
        for (r, row) in rows.iter().enumerate() {
            for (c, place) in row.iter().enumerate() {
                let (r, c) = (r + 1, c + 1);
                let entry = if small { format!("{name}_{r}{c}") } else { format!("{name}_{r}_{c}") };
                self.declare(&entry, Meaning::Places(Shape::Scalar, vec![*place]))?;
            }
        }
        self.declare(name, Meaning::Places(Shape::Matrix(rows.len(), columns), rows.concat()))
    }

    /// A number with a name.
    ///
    /// # Errors
    /// Those of [`Names::scalar`].
    pub fn parameter(&mut self, name: &str, value: Number) -> Result<&mut Self, ExpressionError> {
        self.declare(name, Meaning::Numbers(Shape::Scalar, vec![value]))
    }

    /// A list of numbers with a name: a constant vector, and its components.
    ///
    /// # Errors
    /// Those of [`Names::scalar`].
    pub fn parameters(&mut self, name: &str, values: Vec<Number>) -> Result<&mut Self, ExpressionError> {
        for (k, value) in values.iter().enumerate() {
            self.parameter(&format!("{name}_{}", k + 1), value.clone())?;
        }
        self.declare(name, Meaning::Numbers(Shape::Vector(values.len()), values))
    }

    /// A formula with a name. It is read where it is used, so that the order of definitions does not matter.
    ///
    /// # Errors
    /// Those of [`Names::scalar`].
    pub fn definition(&mut self, name: &str, text: &str) -> Result<&mut Self, ExpressionError> {
        self.declare(name, Meaning::Definition(text.into()))
    }

    pub(super) fn get(&self, name: &str) -> Option<&Meaning> {
        self.meanings.get(name)
    }

    /// The name, or function, that is most like `name`, if one is.
    pub(super) fn like(&self, name: &str) -> Option<&str> {
        like(name, self.meanings.keys().map(String::as_str).chain(FUNCTIONS.iter().map(|function| function.name)))
    }

    /// The names of quantities, parameters and definitions, without components.
    pub(super) fn list(&self) -> String {
        let component = |name: &str| {
            let stem = name.rfind('_').map(|at| &name[..at]);
            match stem.and_then(|stem| self.meanings.get(stem)) {
                Some(Meaning::Places(shape, _) | Meaning::Numbers(shape, _)) => *shape != Shape::Scalar,
                _ => false,
            }
        };
        let names: Vec<String> =
            self.meanings.keys().filter(|name| !component(name)).map(|name| format!("`{name}`")).collect();
        names.join(", ")
    }
}

/// What is wrong with a name.
fn refused(name: &str, message: String) -> ExpressionError {
    ExpressionError { spot: Spot { text: name.into(), definition: None, at: 0 }, message }
}

/// The one of `all` that is most like `name`, if one is.
pub fn like<'a>(name: &str, all: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let all = all.into_iter().map(|known| (distance(name, known), known));
    let near = all.filter(|(distance, known)| *distance <= 1 + known.len() / 5 && 2 * *distance <= name.len());
    near.min().map(|(_, known)| known)
}

/// Those of `all` that are nearest to `name`, at most `most`: first the ones that have it as a part.
///
/// ```
/// let kinds = ["formula", "linear-drag", "quadratic-drag", "torque"];
/// assert_eq!(euler_poincare::expression::nearest("drag", kinds, 2), ["linear-drag", "quadratic-drag"]);
/// ```
pub fn nearest<'a>(name: &str, all: impl IntoIterator<Item = &'a str>, most: usize) -> Vec<&'a str> {
    let far = |known: &str| (!(known.contains(name) || name.contains(known)), distance(name, known));
    let mut all: Vec<_> = all.into_iter().map(|known| (far(known), known)).collect();
    all.sort_unstable();
    all.truncate(most);
    all.into_iter().map(|(_, known)| known).collect()
}

/// How many letters have to be changed, added or left out (Levenshtein).
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(40).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().take(40).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let changed = diagonal + usize::from(!x.eq_ignore_ascii_case(y));
            diagonal = row[j + 1];
            row[j + 1] = changed.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
