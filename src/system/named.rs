//! The algebras that have names: their bases and brackets, as text.

use super::arbitrary::plain;
use super::case::{Algebra, Case, Structure};
use super::document::from_name;
use super::error::{CaseError, Place};
use crate::algebra::families::named;
use crate::algebra::rational::RationalAlgebra;
use crate::algebra::{Entry, known};
use crate::scalar::Number;
use dashu_ratio::RBig;
use std::collections::BTreeMap;

/// The names of algebras of files, without products: `so3`, …; `r3` stands for all of ℝⁿ.
pub fn named_algebras() -> impl Iterator<Item = &'static str> {
    ["r3"].into_iter().chain(Entry::names()).chain(known::names())
}

/// An algebra with a name, or a product, as text: its dimension, its basis as matrices, its brackets.
///
/// # Errors
/// An unknown name.
pub fn algebra_text(name: &str) -> Result<String, CaseError> {
    let structure = from_name(name, &Place::root().key("algebra").key("name"))?;
    let algebra = Algebra { structure, basis: None };
    let n = algebra.dimension();
    let case = Case { algebra, ..plain(n) };
    case.check()?;
    let (size, basis) = match &case.algebra.structure {
        Structure::Named(entry) => (entry.matrix_size(), named(entry)),
        Structure::Matrices { algebra, .. } => (algebra.matrix_size(), algebra.rational()),
        Structure::Constants { .. } | Structure::Given { .. } => (0, Vec::new()),
    };
    let mut text = format!("{name}: dimension {}, {size}×{size} matrices\n", basis.len());
    let unit = |r: usize, c: usize| if size < 10 { format!("E_{r}{c}") } else { format!("E_{r},{c}") };
    for (a, matrix) in basis.iter().enumerate() {
        let entries = matrix.entries.iter().map(|(k, x)| (x, unit(k / size + 1, k % size + 1)));
        text += &format!("  e_{} = {}\n", a + 1, combination(entries));
    }
    let mut brackets = BTreeMap::<_, Vec<_>>::new();
    let algebra = case.algebra.structure.rational();
    for ([a, b, c], x) in algebra.iter().flat_map(RationalAlgebra::constants) {
        brackets.entry([a + 1, b + 1]).or_default().push((x, format!("e_{}", c + 1)));
    }
    if brackets.is_empty() {
        text += "  all brackets vanish\n";
    }
    for ([a, b], terms) in brackets {
        text += &format!("  [e_{a}, e_{b}] = {}\n", combination(terms.into_iter()));
    }
    Ok(text)
}

/// `2 x - y/2` from coefficients and names; `0` where all vanish.
fn combination<'a>(terms: impl Iterator<Item = (&'a RBig, String)>) -> String {
    let mut text = String::new();
    for (k, name) in terms {
        let k = k.to_f64().value();
        let sign = match (text.is_empty(), k < 0.0) {
            (true, false) => "",
            (true, true) => "-",
            (false, false) => " + ",
            (false, true) => " - ",
        };
        let size = k.abs();
        let factor = if size == 1.0 { String::new() } else { format!("{} ", Number::from(size)) };
        text += &format!("{sign}{factor}{name}");
    }
    if text.is_empty() { "0".into() } else { text }
}
