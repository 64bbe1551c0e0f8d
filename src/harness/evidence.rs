//! What a check measured, told on request: a [`Verdict`](super::Verdict) keeps the numbers that decided, the evidence
//! all of them.
//!
//! A check [`note`]s its numbers while it runs; [`gather`] collects those of one call, on its own thread. Outside [`gather`], a
//! note is neither made nor kept. The verdict is the same with and without.

use super::convergence::{Estimate, Level, LevelKind, kinds};
use std::cell::RefCell;

/// Something that was measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Evidence {
    /// The defect of an identity in one arithmetic.
    Defect {
        /// Decimal digits of the arithmetic: 16, 32 or 64.
        digits: u32,
        /// |lhs − rhs| relative to the size of its terms, in units of round-off; infinite for NaN.
        defect: f64,
        /// What it may be, in the same units.
        bound: f64,
        /// What it may be where nothing is known of other arithmetics.
        alone: f64,
        /// The worst place.
        witness: String,
    },
    /// The errors of one quantity at a sequence of steps.
    Levels {
        /// Decimal digits of the arithmetic.
        digits: u32,
        /// What it is the error of.
        quantity: String,
        /// The errors, as they were measured.
        levels: Vec<Level>,
        /// What each level is to the estimate.
        kinds: Vec<LevelKind>,
        /// The slope of these errors.
        estimate: Estimate,
        /// The slope that was predicted for these errors: the order, or the order plus one where they are those of a fixed
        /// number of steps.
        expected: Option<u32>,
    },
}

impl Evidence {
    /// The errors of `quantity`, with what each level is to `estimate`.
    pub fn levels(
        digits: u32,
        quantity: impl Into<String>,
        levels: Vec<Level>,
        estimate: Estimate,
        expected: Option<u32>,
    ) -> Self {
        Self::Levels { digits, quantity: quantity.into(), kinds: kinds(&levels, &estimate), levels, estimate, expected }
    }

    /// The digits of the arithmetic in which it was measured.
    pub fn digits(&self) -> u32 {
        match self {
            Self::Defect { digits, .. } | Self::Levels { digits, .. } => *digits,
        }
    }
}

thread_local! {
    /// The notes of the innermost `gather` of this thread.
    static NOTES: RefCell<Option<Vec<Evidence>>> = const { RefCell::new(None) };
}

/// Puts back, also after a panic, the notes that were there before.
struct Scope(Option<Vec<Evidence>>);

impl Drop for Scope {
    fn drop(&mut self) {
        NOTES.set(self.0.take());
    }
}

/// The value of `check`, and what was noted while it ran, in that sequence.
pub fn gather<R>(check: impl FnOnce() -> R) -> (R, Vec<Evidence>) {
    let _scope = Scope(NOTES.replace(Some(Vec::new())));
    let value = check();
    (value, NOTES.take().unwrap_or_default())
}

/// Whether [`gather`] runs here: then a law may measure, and note, also what it does not judge by.
pub fn is_gathered() -> bool {
    NOTES.with_borrow(Option::is_some)
}

/// Keeps what `evidence` says if [`gather`] runs; else it is not called.
pub fn note(evidence: impl FnOnce() -> Evidence) {
    note_all(|| [evidence()]);
}

/// [`note`], for several.
pub fn note_all<I: IntoIterator<Item = Evidence>>(evidence: impl FnOnce() -> I) {
    if is_gathered() {
        // Made before the notes are borrowed: it may note as well.
        let made: Vec<Evidence> = evidence().into_iter().collect();
        NOTES.with_borrow_mut(|notes| {
            if let Some(notes) = notes {
                notes.extend(made);
            }
        });
    }
}
