//! |M − M(T)| as found by an independent implementation in 150-bit arithmetic, rounded to three digits.

use super::{Method, Problem};
use crate::tableau::families::Family;

/// A column of the table: a problem, a method, and its errors at h = 2^−k for the levels k that are known.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Column {
    /// The problem.
    pub problem: Problem,
    /// The method.
    pub method: Method,
    /// The first k of `errors`: 0, or 1 where no root exists at h = 1.
    pub coarsest: u32,
    /// |M − M(T)| at h = 2^−k, k = `coarsest`, `coarsest` + 1, …
    pub errors: &'static [f64],
}

const fn column(problem: Problem, family: Family, stages: usize, coarsest: u32, errors: &'static [f64]) -> Column {
    Column { problem, method: Method::new(family, stages), coarsest, errors }
}

/// Lobatto on the Landau–Lifshitz–Gilbert system, Gauss on the relaxed body.
#[rustfmt::skip]
pub const TABLE: [Column; 8] = [
    column(Problem::Llg, Family::LobattoIIIA, 2, 1, &[2.59e-2, 4.88e-3, 1.12e-3, 2.73e-4, 6.75e-5, 1.68e-5]),
    column(Problem::Llg, Family::LobattoIIIB, 2, 0, &[9.55e-2, 3.95e-3, 1.64e-3, 4.70e-4, 1.24e-4, 3.16e-5, 7.98e-6]),
    column(Problem::Llg, Family::LobattoIIIA, 3, 0, &[1.75e-3, 1.34e-4, 9.04e-6, 5.83e-7, 3.70e-8, 2.33e-9, 1.46e-10]),
    column(Problem::Llg, Family::LobattoIIIB, 3, 0, &[4.14e-4, 4.32e-5, 3.15e-6, 2.08e-7, 1.33e-8, 8.38e-10, 5.26e-11]),
    column(Problem::Relaxed, Family::Gauss, 1, 0, &[2.52e-2, 9.34e-3, 2.59e-3, 6.64e-4, 1.67e-4, 4.18e-5, 1.05e-5]),
    column(Problem::Relaxed, Family::Gauss, 2, 0, &[1.70e-3, 7.14e-5, 4.03e-6, 2.46e-7, 1.52e-8, 9.52e-10, 5.94e-11]),
    column(Problem::Relaxed, Family::Gauss, 3, 0, &[1.62e-5, 2.38e-7, 3.65e-9, 5.67e-11, 8.83e-13, 1.38e-14, 2.15e-16]),
    column(Problem::Relaxed, Family::Gauss, 4, 0, &[6.06e-8, 9.58e-11, 2.44e-13, 8.01e-16, 2.95e-18, 1.13e-20]),
];

impl Column {
    /// The error at h = 2^−level, where it is known.
    pub fn error(&self, level: u32) -> Option<f64> {
        self.errors.get(level.checked_sub(self.coarsest)? as usize).copied()
    }
}

/// `value` to three significant digits, as the table shows it: `9.55e-2`.
pub fn shown(value: f64) -> String {
    format!("{value:.2e}")
}
