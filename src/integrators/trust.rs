//! When the fixed-point iteration on the stages is trusted, and when it is given up: the same for the engine in any scalar and for
//! the kernels in lanes, which compare no more than rates.
//!
//! Near the root that continues from h = 0 the iteration contracts, at a rate that grows with h. Where that root meets another in a
//! fold, an eigenvalue of the iteration is 1. What it finds at a rate close to 1 may be a root beyond a fold: then the branch is
//! followed from h = 0. The rate at a root says nothing of the way to it: where the map contracts all along, each residual is
//! a share of the one before, from the first on, and there is one root there (Banach).

use crate::scalar::Real;

/// A rate of contraction, the factor by which a residual falls in one iteration, as a fraction.
type Rate = (i64, i64);

/// The slowest rate, on the average since the first iteration, at which a root is trusted: well below 1, the rate at a fold, and
/// fast enough for rounding in `f64` to be reached in 70 iterations.
const TRUSTED: Rate = (3, 5);

/// A root is near where the iteration starts, if the first residual is at most this.
const NEAR_START: Rate = (1, 16);

/// A root is far from where the iteration starts, if the first change is larger than this share of it: the iteration may have passed others. Behind a fold, at h = 40, it was
/// five times the root, and residuals fell to a tenth and less in two iterations.
const FAR: Rate = (1, 2);

/// And if the terms of the equations, which residuals are relative to, are more than this multiple of what they were at the start: by terms that
/// grow residuals fall, however far the root. At h = 150, 300 and 8000 they were 12, 48 and 254 times as large behind a fold at h = 48.6 (case 90128
/// of seed 998022 of the law `branch`).
const GROWN: Rate = (4, 1);

/// From rest the first change is nearly all of the root: a root that is far by [`FAR`] is taken where it is no more than this multiple of it.
const FROM_REST: Rate = (2, 1);

/// And where the average rate is no slower than this.
const FAST_FROM_REST: f64 = 1.0 / 16.0;

/// The largest share of the residual before the last at which a root is trusted that is not near: a change of the momenta is one of the
/// displacements an iteration later, so that residuals may fall in pairs. Behind the fold of case 22233 of seed 998011 of the law `branch`, roots
/// were found after shares of 0.48 (h = 10) and 2.1 (h = 6).
const STEADY: Rate = (1, 4);

/// A root that took no more iterations than this is trusted: it was near, and an average over so few says little.
const QUICK: i32 = 4;

/// The slowest rate, on the average since the first iteration, at which the iteration goes on: with slower ones the residual is
/// still 2·10⁻¹⁰ of the first after 100 iterations, the most that are made by default. Above [`TRUSTED`], since the first
/// iterations can be slower than the later ones.
const CONTINUED: Rate = (4, 5);

/// From this number of iterations on the average is compared with [`CONTINUED`]: before, the residual may rise for a while.
const PATIENT: i32 = 8;

/// After this number of iterations without a smaller residual, what is left of it is taken for rounding, if it is small: one may be chance.
const IDLE: i32 = 2;

/// A relative change beyond this is divergence: iterates that have a use are within a few times the size of the root.
#[cfg(feature = "lanes")]
const DIVERGED: f64 = 1e3;

/// What the residuals of an iteration say.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Trend {
    /// They fall: it goes on.
    Falls,
    /// They are as small as wanted, or what is left of them is rounding: it is at a root.
    Settled,
    /// There is no root, or one that is reached too slowly.
    Hopeless,
}

/// Where an iteration that settled has led, and how.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival<T> {
    /// Evaluations of the equations since the first residual.
    pub evaluations: usize,
    /// What residuals are relative to, at the start and at the root.
    pub sizes: [T; 2],
    /// Whether the caller compares the step with others, of other sizes: then the rate alone decides.
    pub compared: bool,
}

/// The relative residuals of an iteration, as they came.
#[derive(Clone, Copy)]
pub(super) struct Course<T> {
    first: T,
    least: T,
    /// The latest.
    pub last: T,
    count: i32,
    /// How many iterations ago the least was.
    idle: i32,
}

impl<T: Real> Course<T> {
    /// None yet.
    #[inline(always)]
    pub fn new() -> Self {
        Self { first: T::zero(), least: T::zero(), last: T::zero(), count: 0, idle: 0 }
    }

    /// One more.
    #[inline(always)]
    pub fn note(&mut self, residual: T) {
        if self.count == 0 {
            (self.first, self.least, self.idle) = (residual, residual, 0);
        } else if residual < self.least {
            (self.least, self.idle) = (residual, 0);
        } else {
            self.idle += 1;
        }
        (self.last, self.count) = (residual, self.count + 1);
    }

    /// How many there were.
    #[inline]
    pub fn count(&self) -> usize {
        self.count.unsigned_abs() as usize
    }

    /// The residual falls no more: what is left may be rounding.
    #[inline(always)]
    pub fn stagnates(&self) -> bool {
        self.idle >= IDLE
    }

    /// What they say, where a residual is wanted, or accepted where it falls no more.
    pub fn trend(&self, wanted: T, accepted: T) -> Trend {
        if self.last <= wanted || (self.stagnates() && self.last <= accepted) {
            Trend::Settled
        } else if self.is_hopeless() {
            Trend::Hopeless
        } else {
            Trend::Falls
        }
    }

    /// Whether the root is that from h = 0: it was reached fast enough, and it is not far; or it is far because the iteration `started_at_rest`.
    pub fn is_trusted(&self, arrival: &Arrival<T>, started_at_rest: impl FnOnce() -> bool) -> bool {
        let Arrival { evaluations, sizes, compared } = *arrival;
        if compared {
            return !self.is_slow();
        }
        let evaluations = i32::try_from(evaluations).unwrap_or(i32::MAX);
        !self.is_slow_for(evaluations) && (!self.is_far(sizes) || (self.is_fast(sizes) && started_at_rest()))
    }

    /// The factor by which the residual fell, on the average since the first iteration; 0 after one.
    #[inline]
    pub fn rate(&self) -> f64 {
        let fallen = (self.last / self.first).to_f64();
        if self.count < 2 { 0.0 } else { fallen.powf(1.0 / f64::from(self.count - 1)) }
    }

    /// The root may lie beyond a fold: let Newton's method say.
    #[inline(always)]
    pub fn is_slow(&self) -> bool {
        self.is_slow_for(self.count - 1)
    }

    /// So it may after `evaluations` of the equations since the first residual, where an iteration takes several.
    #[inline(always)]
    fn is_slow_for(&self, evaluations: i32) -> bool {
        let Self { first, last, count, .. } = *self;
        count > QUICK && last < first && last > self.contracted(TRUSTED, evaluations)
    }

    /// The latest residual is a larger share of the one before the last than where the iteration contracts all the way from its start.
    #[inline]
    pub fn is_uneven(&self, earlier: &Self) -> bool {
        let above = |value: T, of: T, (n, d): Rate| value > of * T::ratio(n, d);
        above(self.first, T::one(), NEAR_START) && earlier.count > 0 && above(self.last, earlier.last, STEADY)
    }

    /// There is no root, or one that is reached too slowly.
    #[inline(always)]
    pub fn is_hopeless(&self) -> bool {
        self.count >= PATIENT && self.least > self.contracted(CONTINUED, self.count)
    }

    /// The root is farther from the start than it may be to be trusted, where residuals are relative to these sizes, at the start and at the root.
    #[inline]
    fn is_far(&self, sizes: [T; 2]) -> bool {
        let [start, root] = sizes;
        self.first * start > root * T::ratio(FAR.0, FAR.1) || root > start * T::ratio(GROWN.0, GROWN.1)
    }

    /// The first change is not much more than the root, and the iteration contracted fast from there.
    fn is_fast(&self, sizes: [T; 2]) -> bool {
        let [start, root] = sizes;
        self.first * start <= root * T::ratio(FROM_REST.0, FROM_REST.1) && self.rate() <= FAST_FROM_REST
    }

    /// The first residual after `iterations` at a rate.
    #[inline(always)]
    fn contracted(&self, (n, d): Rate, iterations: i32) -> T {
        self.first * T::ratio(n, d).powi(iterations)
    }
}

#[cfg(feature = "lanes")]
impl Course<f64> {
    /// It is [hopeless](Course::is_hopeless), or the latest change diverges or is not a number.
    #[inline(always)]
    pub fn is_lost(&self, change: f64) -> bool {
        change.is_nan() || change > DIVERGED || self.is_hopeless()
    }
}
