//! The algebras that have names: their bases and brackets, as text.

use super::case::{Algebra, Case};
use super::document::from_name;
use super::error::{CaseError, Place};
use super::{System, Visitor, arbitrary};
use crate::algebra::{Matrix, basis_vector, known};
use crate::group::LieGroup;
use crate::scalar::Number;
use std::fmt::Write;

/// The names of algebras of files, without products: `so3`, …; `r3` stands for all of ℝⁿ.
pub fn named_algebras() -> impl Iterator<Item = &'static str> {
    ["r3", "so3", "se2", "se3", "sl2", "aff1", "heisenberg", "so4"].into_iter().chain(known::NAMES)
}

/// An algebra with a name, or a product, as text: its dimension, its basis as matrices, its brackets.
///
/// # Errors
/// An unknown name.
pub fn algebra_text(name: &str) -> Result<String, CaseError> {
    let structure = from_name(name, &Place::root().key("algebra").key("name"))?;
    let algebra = Algebra { structure, basis: None };
    let plain = arbitrary::plain(algebra.dimension());
    let case = Case { algebra, ..plain };
    case.dispatch::<f64, _>(Describe { name, size: case.matrix_size() })
}

struct Describe<'a> {
    name: &'a str,
    size: usize,
}

/// `2 x - y/2` from coefficients and names; `0` where all vanish.
fn combination(terms: impl Iterator<Item = (f64, String)>) -> String {
    let mut text = String::new();
    for (k, name) in terms.filter(|(k, _)| *k != 0.0) {
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

impl Visitor<f64> for Describe<'_> {
    type Output = String;

    fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> String {
        let (n, size) = (system.dimension, self.size);
        let mut text = format!("{}: dimension {n}, {size}×{size} matrices\n", self.name);
        let unit = |r: usize, c: usize| if size < 10 { format!("E_{r}{c}") } else { format!("E_{r},{c}") };
        for a in 0..n {
            let group = system.group.as_ref();
            let matrix: Matrix<f64, D> = group.map_or(Matrix::zeros(), |group| group.hat(&basis_vector(a)));
            let entries = (0..size * size).map(|k| (matrix[(k / size, k % size)], unit(k / size + 1, k % size + 1)));
            // Writing to a String cannot fail.
            let _ = writeln!(text, "  e_{} = {}", a + 1, combination(entries));
        }
        let mut brackets = 0;
        for a in 0..n {
            for b in a + 1..n {
                let terms = (0..n).map(|c| (system.algebra.constant(a, b, c), format!("e_{}", c + 1)));
                let value = combination(terms);
                if value != "0" {
                    brackets += 1;
                    let _ = writeln!(text, "  [e_{}, e_{}] = {value}", a + 1, b + 1);
                }
            }
        }
        if brackets == 0 {
            text += "  all brackets vanish\n";
        }
        text
    }
}
