//! What stands in a row.

use euler_poincare::scalar::Real;
use euler_poincare::system::Case;
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
    /// The columns of a case.
    pub fn new(case: &Case) -> Self {
        Self { dimension: case.dimension(), casimirs: case.casimir_count(), attitude: case.matrix_size() }
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

    /// The names of a trajectory's columns.
    pub fn header(&self) -> Vec<String> {
        [self.of_state(&["energy", "work", "balance"]), ["residual", "iterations"].map(String::from).to_vec()].concat()
    }

    /// The names of the columns of a table of events.
    pub fn events(&self) -> Vec<String> {
        [["event", "direction"].map(String::from).to_vec(), self.of_state(&["energy", "work", "balance"])].concat()
    }

    /// Of a row: what is of the state in it, with these energies.
    fn of_state(&self, energies: &[&str]) -> Vec<String> {
        let energies = energies.iter().map(|name| (*name).to_owned()).collect();
        let (eta, casimirs) = (self.velocities(), self.casimir_names());
        [vec!["t".into()], self.momenta(), eta, energies, casimirs, self.attitude_names()].concat()
    }

    /// The names of the columns of the final states of an ensemble.
    pub fn states(&self) -> Vec<String> {
        let ends = ["residual", "iterations", "status"].map(String::from).to_vec();
        [vec!["member".into()], self.of_state(&["energy"]), ends].concat()
    }

    /// The names of the columns of an ensemble's statistics.
    pub fn statistics(&self) -> Vec<String> {
        let mut names = ["elapsed", "members"].map(String::from).to_vec();
        for name in [self.momenta(), vec!["energy".into()], self.casimir_names()].concat() {
            names.extend(["mean", "std", "min", "max"].map(|of| format!("{name}_{of}")));
        }
        if self.attitude > 0 {
            names.push("g_departure_max".into());
        }
        names
    }

    /// `mu_1` … `mu_n`.
    pub fn momenta(&self) -> Vec<String> {
        (1..=self.dimension).map(|a| format!("mu_{a}")).collect()
    }

    /// `g_11` … by rows.
    pub fn attitude_names(&self) -> Vec<String> {
        let gap = if self.attitude > 9 { "_" } else { "" };
        let entries = 0..self.attitude * self.attitude;
        entries.map(|k| format!("g_{}{gap}{}", k / self.attitude + 1, k % self.attitude + 1)).collect()
    }

    /// Numbered columns that follow from the state.
    pub fn derived(&self) -> Vec<String> {
        [self.velocities(), self.casimir_names()].concat()
    }

    fn velocities(&self) -> Vec<String> {
        (1..=self.dimension).map(|a| format!("eta_{a}")).collect()
    }

    fn casimir_names(&self) -> Vec<String> {
        (1..=self.casimirs).map(|k| format!("casimir_{k}")).collect()
    }
}

/// A number with all its digits: it reads back as the same one.
pub fn print<T: Real>(line: &mut String, value: T) {
    let size = value.to_f64().abs();
    let positional = size == 0.0 || (1e-4..1e16).contains(&size);
    // Writing to a string cannot fail.
    let _ = if positional { write!(line, "{value}") } else { write!(line, "{value:e}") };
}
