//! When the fixed-point iteration on the stages is trusted, and when it is given up: the same for the engine in any scalar and for
//! the kernels in lanes.
//!
//! Near the root that continues from h = 0 the iteration contracts, at a rate that grows with h. Where that root meets another in a
//! fold, an eigenvalue of the iteration is 1. What it finds at a rate close to 1 may be a root beyond a fold, which Newton's method
//! tells by the sign of det J.

use crate::scalar::Real;

/// A rate of contraction: the factor by which a residual falls in one iteration.
#[derive(Clone, Copy)]
pub(super) struct Rate(i64, i64);

impl Rate {
    /// Its value in `T`.
    pub fn value<T: Real>(self) -> T {
        T::ratio(self.0, self.1)
    }

    /// The value in `f64`, rounded correctly.
    #[cfg(feature = "lanes")]
    pub const fn double(self) -> f64 {
        self.0 as f64 / self.1 as f64
    }
}

/// The slowest rate, on the average since the first iteration, at which a root is trusted: well below 1, the rate at a fold, and
/// fast enough for rounding in `f64` to be reached in 70 iterations.
pub(super) const TRUSTED: Rate = Rate(3, 5);

/// A root that took no more iterations than this is trusted: it was near, and an average over so few says little.
pub(super) const QUICK: i32 = 4;

/// The slowest rate, on the average since the first iteration, at which the iteration goes on: with slower ones the residual is
/// still 2·10⁻¹⁰ of the first after 100 iterations, the most that are made by default. Above [`TRUSTED`], since the first
/// iterations can be slower than the later ones.
pub(super) const CONTINUED: Rate = Rate(4, 5);

/// From so many iterations on the average is compared with [`CONTINUED`]: before, the residual may rise for a while.
pub(super) const PATIENT: i32 = 8;

/// After so many iterations without a smaller residual, what is left of it is taken for rounding, if it is small: one may be chance.
pub(super) const IDLE: i32 = 2;

/// A relative change beyond this is divergence: iterates that have a use are within a few times the size of the root.
#[cfg(feature = "lanes")]
pub(super) const DIVERGED: f64 = 1e3;
