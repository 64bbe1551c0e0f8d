//! The order of a method is the least that it shows on any system.
//!
//! An elementary differential may vanish on a system, and errors then fall faster than the order says. So a system that shows less
//! than a claimed order refutes it, and one that shows the order confirms it; where a system shows more, or nothing but rounding, others are
//! asked before anything is said.

use super::problem::VARIATIONS;
use std::cmp::Ordering;

/// How many other systems must show more than a claimed order, beside the first, before it counts as too low.
const CONFIRMED: usize = 2;

/// The number of the body without symmetry ([`generic`](super::problem::generic)), which is asked after the variations of the
/// system ([`varied`](super::problem::varied)), 1 to [`VARIATIONS`].
pub const GENERIC: i64 = VARIATIONS + 1;

/// Why nothing is said of a claim for which [`Answer::Open`] is all there is.
pub(crate) const UNCONFIRMED: &str = "errors fall faster than the order, and too few other systems confirm it";

/// What other systems say about an order that the first did not show.
#[derive(Clone, Debug, PartialEq)]
pub enum Answer<T> {
    /// This one shows the order, or less: that is the verdict on the method.
    Decided(i64, T),
    /// None shows the order, and enough show more: the claim is too low.
    More,
    /// None shows the order, and too few show more.
    Open,
}

/// Asks other systems, by their numbers 1 to [`GENERIC`], about an order that the first does not show.
///
/// `ask` gives what a system shows against the order (for certain; else `None`) and what is known of it; `None` where there is no such
/// system, or it cannot be asked. The first that shows the order or less decides. [`Answer::More`] takes two others that show more, the body without symmetry among them
/// where it can be asked.
///
/// # Errors
/// The first that `ask` gives.
pub fn of_others<T, E>(mut ask: impl FnMut(i64) -> Result<Option<(Option<Ordering>, T)>, E>) -> Result<Answer<T>, E> {
    let (mut more, mut generic) = (0, true);
    for k in 1..=GENERIC {
        match ask(k)? {
            Some((Some(Ordering::Equal | Ordering::Less), found)) => return Ok(Answer::Decided(k, found)),
            Some((Some(Ordering::Greater), _)) => more += 1,
            Some((None, _)) => generic = k < GENERIC,
            None => {}
        }
    }
    Ok(if more >= CONFIRMED && generic { Answer::More } else { Answer::Open })
}
