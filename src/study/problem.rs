//! Test problems that hide nothing, and variations of a given one.

use crate::scalar::Number;
use crate::system::SystemFile;
use crate::system::case::{Case, Drag, Force, Inertia, Lagrangian, Motion};
use crate::system::file::FileError;

/// A rigid body without symmetry: so(3), an inertia with products of inertia, linear drag with a full matrix, a double
/// bracket, and a torque that varies in time; T = 1. The Cayley map, `gauss-2`, h = 1/8.
///
/// # Errors
/// None that the text of this crate causes.
pub fn generic() -> Result<SystemFile, FileError> {
    SystemFile::parse(include_str!("generic.toml"))
}

/// The text of [`generic`].
pub fn generic_text() -> &'static str {
    include_str!("generic.toml")
}

/// The k-th system that is asked about the method of a case where that does not show its order: the k-th of its [variations](varied), up
/// to [`VARIATIONS`], then [`generic`].
///
/// # Errors
/// None that the text of this crate causes.
pub fn other(case: &Case, k: i64) -> Result<Case, FileError> {
    if k <= VARIATIONS {
        return Ok(varied(case, k));
    }
    generic().map(|file| Case { method: case.method.clone(), ..file.case })
}

/// How many variations of a case are asked, where it shows a higher order than its method is said to have; after them a body
/// without symmetry, [`generic`].
pub const VARIATIONS: i64 = 3;

/// The k-th variation (k = 1, 2, …) of a case: the same algebra, retraction, tableau and step, with another motion, a full
/// inertia without quartic term, and other forces, none with a symmetry. Where a case shows a higher order than its tableau has because an elementary
/// differential happens to vanish on it, its variations do not.
pub fn varied(case: &Case, k: i64) -> Case {
    let n = case.dimension();
    let number = |a: usize, b: i64| Number::ratio((7 * a as i64 + 5 * b + 3 * k) % 13 - 6, 16);
    let vector = |b: i64| (0..n).map(|a| number(a, b)).collect::<Vec<_>>();
    let inertia = (0..n).map(|a| {
        let entry = |b: usize| match a == b {
            // The diagonal dominates: off it, sums stay below 7/16.
            true => Number::ratio(8 + 2 * ((3 * a as i64 + k) % 5), 8),
            false => Number::ratio((a.max(b) as i64 * 5 + a.min(b) as i64 * 3 + k) % 7 - 3, 8 * (n as i64 - 1).max(1)),
        };
        (0..n).map(entry).collect()
    });
    let drag = (0..n).map(|a| (0..n).map(|b| number(a + 2 * b, (a * b) as i64 + 1)).collect()).collect();
    let mut varied = case.clone();
    varied.lagrangian = Lagrangian::new(Inertia::Full(inertia.collect()));
    varied.forces = vec![
        Force::LinearDrag(Drag::Matrix(drag)),
        Force::Periodic { value: vector(2), frequency: Number::ratio(5, 4), phase: Number::ratio(1, 3) },
        Force::DoubleBracket { alpha: Number::ratio(3, 8) },
    ];
    varied.start.motion = Motion::Velocity(vector(4));
    varied
}
