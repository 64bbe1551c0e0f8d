//! What stands in a row.

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::scalar::Real;
use euler_poincare::system::Case;
use euler_poincare::system::case::Structure;
use std::fmt::Write;

/// How many columns there are of each kind.
#[derive(Clone, Debug)]
pub struct Columns {
    /// n = dim g.
    pub dimension: usize,
    /// Casimirs that are known.
    pub casimirs: usize,
    /// Size of the matrices of the group (without padding); 0 without a group.
    pub attitude: usize,
}

impl Columns {
    /// The columns of a case with so many Casimirs.
    pub fn new(case: &Case, casimirs: usize) -> Self {
        let attitude = match &case.algebra.structure {
            Structure::Named(entry) => Entry::matrix_size(entry),
            Structure::Constants { .. } | Structure::Given { .. } => 0,
        };
        Self { dimension: case.dimension(), casimirs, attitude }
    }

    /// Where the momentum starts.
    pub const MOMENTUM: usize = 1;

    /// Where the energy is.
    pub fn energy(&self) -> usize {
        1 + 2 * self.dimension
    }

    /// Where the Casimirs start: after the energy, the work and the balance.
    pub fn casimir(&self) -> usize {
        self.energy() + 3
    }

    /// The names.
    pub fn header(&self) -> String {
        let mut line = String::from("t");
        let mut add = |name: String| {
            line.push(',');
            line.push_str(&name);
        };
        (1..=self.dimension).for_each(|a| add(format!("mu_{a}")));
        (1..=self.dimension).for_each(|a| add(format!("eta_{a}")));
        ["energy", "work", "balance"].into_iter().for_each(|name| add(name.into()));
        (1..=self.casimirs).for_each(|k| add(format!("casimir_{k}")));
        let gap = if self.attitude > 9 { "_" } else { "" };
        for row in 1..=self.attitude {
            (1..=self.attitude).for_each(|column| add(format!("g_{row}{gap}{column}")));
        }
        add("residual".into());
        add("iterations".into());
        line
    }
}

/// A number with all its digits: it reads back as the same one.
pub fn print<T: Real>(line: &mut String, value: T) {
    let size = value.to_f64().abs();
    let positional = size == 0.0 || (1e-4..1e16).contains(&size);
    // Writing to a string cannot fail.
    let _ = if positional { write!(line, "{value}") } else { write!(line, "{value:e}") };
}
