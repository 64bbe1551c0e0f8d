//! The balance of energy over the rows of a run: what a residual does not show.

use super::columns::{Columns, print};
use euler_poincare::scalar::Real;

/// A balance that is off by more than this share of the kinetic energy and of the work is told with a warning: then not one digit of the
/// energy is right, however well the equations of each step are solved.
const LOOSE: f64 = 0.1;

/// The share of the energy that rounding may move: at rest there is no kinetic energy and no work.
const ROUNDING: f64 = 1e-9;

/// What the rows say of the energy.
#[derive(Clone)]
pub struct Balance {
    columns: Columns,
    /// The energy of the first row.
    first: Option<f64>,
    /// Energy and work of the last one.
    energy: f64,
    work: f64,
    /// The largest energy that neither the start nor work nor time explains.
    off: f64,
    /// The largest kinetic energy, as ½ Σ |μ_a η_a|, or work, or energy that rounding moves.
    size: f64,
}

impl Balance {
    pub fn new(columns: Columns) -> Self {
        Self { columns, first: None, energy: 0.0, work: 0.0, off: 0.0, size: 0.0 }
    }

    pub fn add<T: Real>(&mut self, row: &[T]) {
        let n = self.columns.dimension;
        let at = |k: usize| row.get(k).map_or(0.0, |value| value.to_f64());
        let (first, energy) = (Columns::MOMENTUM, self.columns.energy());
        (self.energy, self.work) = (at(energy), at(energy + 1));
        self.first.get_or_insert(self.energy);
        self.off = self.off.max(at(energy + 2).abs());
        let kinetic = (first..first + n).fold(0.0, |sum, a| sum + 0.5 * (at(a) * at(a + n)).abs());
        self.size = self.size.max(kinetic).max(self.work.abs()).max(ROUNDING * self.energy.abs());
    }

    /// Part of a line.
    pub fn text(&self) -> String {
        // Six digits.
        let number = |x: f64| {
            let mut text = String::new();
            print(&mut text, format!("{x:.5e}").parse().unwrap_or(x));
            text
        };
        let (first, last, work) = (number(self.first.unwrap_or(0.0)), number(self.energy), number(self.work));
        format!("energy {first} to {last} with work {work}, balance off by {:.1e} at most", self.off)
    }

    /// A run not to be trusted.
    pub fn warning(&self) -> Option<String> {
        (self.off > LOOSE * self.size).then(|| {
            format!(
                "warning: the energy is off by {:.1e}, where kinetic energy and work are {:.1e} at most: the steps are too large for this \
                 motion. A small residual only says that the equations of each step are solved. Take a smaller `step`, or `tolerance` \
                 in its place",
                self.off, self.size
            )
        })
    }
}
