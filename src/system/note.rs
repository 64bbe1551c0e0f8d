//! What a case may be, and what is perhaps not meant.

use super::case::{Case, Orientation, Structure};
use crate::algebra::Matrix;
use crate::algebra::catalogue::Entry;
use crate::group::{departure, nearest_rotations};
use crate::scalar::Number;
use std::fmt;

/// The largest matrices of a group that are compiled in.
const LARGEST: usize = 12;

/// What is rounding: of a sum of two moments, and of |gᵀg − 1|.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Something that a case may be, and that is perhaps not meant.
///
/// ```
/// use euler_poincare::system::note::Note;
/// use euler_poincare::system::{SystemFile, file::example};
///
/// let text = example().replace("inertia = [\"1/2\", 2, 1]", "inertia = [1, 2, 3.5]");
/// let notes = SystemFile::parse(&text)?.case.notes();
/// assert!(matches!(notes[..], [Note::Triangle { moments: [1.0, 2.0, 3.5] }]));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Note {
    /// Principal moments of inertia of a rotation that no body has, as the largest exceeds the sum of the others.
    Triangle {
        /// The moments, the largest last.
        moments: [f64; 3],
    },
    /// A matrix that the nearest rotation replaces.
    Corrected {
        /// By how much it violated gᵀg = 1.
        departure: f64,
        /// The largest difference of an entry.
        moved: f64,
    },
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Triangle { moments: [a, b, c] } => write!(
                f,
                "lagrangian.inertia: no rigid body has the principal moments {}, {} and {}: the largest is at most the sum of the others",
                Number::from(short(*a)),
                Number::from(short(*b)),
                Number::from(short(*c))
            ),
            Self::Corrected { departure, moved } => write!(
                f,
                "state.matrix: replaced by the nearest rotation; entries change by {moved:.1e} at most, gᵀg = 1 was violated by {departure:.1e}"
            ),
        }
    }
}

/// Six digits.
fn short(x: f64) -> f64 {
    format!("{x:.5e}").parse().unwrap_or(x)
}

impl Case {
    /// What the case may be, and what is perhaps not meant: see [`Note`].
    pub fn notes(&self) -> Vec<Note> {
        self.triangles().into_iter().chain(self.corrected()).collect()
    }

    /// Of each rotation of the algebra in its standard basis.
    fn triangles(&self) -> Vec<Note> {
        let Structure::Named(entry) = &self.algebra.structure else { return Vec::new() };
        let lagrangian = &self.lagrangian;
        if self.algebra.basis.is_some() || lagrangian.indefinite || lagrangian.formula.is_some() {
            return Vec::new();
        }
        let one = std::slice::from_ref(entry);
        let factors = if let Entry::Product(factors) = entry { factors } else { one };
        let (mut first, mut notes) = (0, Vec::new());
        for factor in factors {
            if matches!(factor, Entry::So3 | Entry::Se3) {
                let moment = |r: usize, c: usize| lagrangian.inertia.entry(first + r, first + c).eval().unwrap_or(0.0);
                let mut moments: [f64; 3] = Matrix::<f64, 3>::from_fn(moment).symmetric_eigenvalues().into();
                moments.sort_by(f64::total_cmp);
                let [a, b, c] = moments;
                if c - (a + b) > ROUNDING * c {
                    notes.push(Note::Triangle { moments });
                }
            }
            first += factor.dimension();
        }
        notes
    }

    fn corrected(&self) -> Option<Note> {
        let (Structure::Named(entry), Some(Orientation::Matrix(rows))) =
            (&self.algebra.structure, &self.start.orientation)
        else {
            return None;
        };
        let given = Matrix::<f64, LARGEST>::from_fn(|r, c| {
            rows.get(r).and_then(|row| row.get(c)?.eval().ok()).unwrap_or(f64::from(u8::from(r == c)))
        });
        let departure = departure(entry, &|r, c| given[(r, c)]);
        let mut attitude = given;
        nearest_rotations(entry, &mut attitude);
        let moved = (attitude - given).amax();
        (moved > ROUNDING).then_some(Note::Corrected { departure, moved })
    }
}
