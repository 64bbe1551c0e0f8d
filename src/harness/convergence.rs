//! The order of a method, read off its errors at a sequence of step sizes; or the reason why it cannot be.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/harness/convergence.md"))]
//!
//! Only the finest slopes above the noise decide. Levels within the noise are not used, but must be explained by
//! what was read off the others: a lower-order term that emerges there leaves no estimate.

use super::law::Verdict;
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// The error at one step size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Level {
    /// The step, > 0.
    pub h: f64,
    /// The size of the error, ≥ 0.
    pub error: f64,
    /// An estimate of how much of it may be round-off, of the method and of the reference, ≥ 0; may be short by a factor
    /// of [`NOISE_MARGIN`].
    pub noise: f64,
}

impl Level {
    /// Whether it carries a slope.
    fn is_clear(&self) -> bool {
        self.error > 0.0 && self.error >= CLEAR_OF_NOISE * self.noise
    }
}

/// The factor by which the noise of a level may be underestimated.
pub const NOISE_MARGIN: f64 = 4.0;

/// A level carries a slope when its error is at least this multiple of its noise; so noise, underestimated by
/// [`NOISE_MARGIN`], moves a slope (ratio 2, order p) by at most 4/200 (1 + 2^−p)/ln 2 ≤ 0.044.
pub const CLEAR_OF_NOISE: f64 = 200.0;

/// How far from an integer the interval of a slope may reach and still confirm it; beyond it, it refutes.
///
/// A quarter: half the way to the point that is as near to the next integer.
pub const TOLERANCE: f64 = 0.25;

/// Differences of slopes below this (plus what noise explains) count as none: a lower-order term that
/// hides below it makes up about a hundredth of the finest error.
const SETTLED: f64 = 0.01;

/// The slowest decay of the slopes' deviation that counts as convergence, as a power of the step. Deviations of an
/// expansion in powers of h decay with an integer power ≥ 1; a power below 1 may show before they do.
const SLOWEST: f64 = 1.0 / 3.0;

/// Why a slope says nothing about an order.
pub(crate) const WIDE: &str = "the interval of the slope is too wide to confirm or refute the order";

/// What a sequence of errors says about the order.
#[derive(Clone, Debug, PartialEq)]
pub enum Estimate {
    /// The slopes converge.
    Slope {
        /// The slope extrapolated to h = 0.
        value: f64,
        /// The least value that the extrapolations (none, and with each power of h that fits) and the noise allow.
        low: f64,
        /// The greatest.
        high: f64,
        /// The coarsest and the finest step that were used.
        window: (f64, f64),
    },
    /// There is no order to be read off.
    Inconclusive {
        /// The reason; without numbers of the line, so that reasons can be counted.
        why: String,
        /// The slopes, with the finest last, as far as there are any.
        slopes: Vec<f64>,
    },
}

impl Estimate {
    /// The slope at h = 0, where there is one.
    pub fn slope(&self) -> Option<f64> {
        match self {
            Self::Slope { value, .. } => Some(*value),
            Self::Inconclusive { .. } => None,
        }
    }

    /// The least and the greatest slope; any where there is none.
    pub(crate) fn interval(&self) -> (f64, f64) {
        match self {
            Self::Slope { low, high, .. } => (*low, *high),
            Self::Inconclusive { .. } => (f64::NEG_INFINITY, f64::INFINITY),
        }
    }

    /// The same with `by` less: errors of single steps show the order plus one.
    pub fn lowered(self, by: f64) -> Self {
        match self {
            Self::Slope { value, low, high, window } => {
                Self::Slope { value: value - by, low: low - by, high: high - by, window }
            }
            Self::Inconclusive { why, slopes } => {
                Self::Inconclusive { why, slopes: slopes.into_iter().map(|slope| slope - by).collect() }
            }
        }
    }

    /// The slope against an order: equal where the whole interval is within [`TOLERANCE`] of it, less or greater where all of it
    /// is farther away; `None` between, and where there is no slope.
    pub fn compare(&self, order: u32) -> Option<Ordering> {
        let ((low, high), order) = (self.interval(), f64::from(order));
        if low - order > TOLERANCE {
            return Some(Ordering::Greater);
        }
        if order - high > TOLERANCE {
            return Some(Ordering::Less);
        }
        ((high - order).max(order - low) <= TOLERANCE).then_some(Ordering::Equal)
    }

    /// Holds when the slope [compares](Self::compare) as equal to `order`, broken when it is less or greater, else inconclusive.
    /// The defect is the distance of the end that decides.
    pub fn judge(&self, order: u32) -> Verdict {
        let wanted = f64::from(order);
        match (self, self.compare(order)) {
            (Self::Inconclusive { why, .. }, _) => Verdict::inconclusive(why.clone()),
            (_, None) => Verdict::inconclusive(WIDE),
            (Self::Slope { low, high, .. }, Some(Ordering::Equal)) => {
                Verdict::Holds { defect: (high - wanted).max(wanted - low), bound: TOLERANCE }
            }
            (Self::Slope { value, low, high, window }, Some(_)) => Verdict::Broken {
                defect: (low - wanted).max(wanted - high),
                bound: TOLERANCE,
                witness: format!(
                    "slope {value:.3} in [{low:.3}, {high:.3}], predicted {order}, steps {:.3e} to {:.3e}",
                    window.0, window.1
                ),
            },
        }
    }
}

/// What a level is to an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum LevelKind {
    /// Coarser than where the slope is that of the estimate.
    #[serde(rename = "coarse")]
    PreAsymptotic,
    /// On the line.
    #[serde(rename = "counts")]
    Asymptotic,
    /// Not clear of the noise.
    #[serde(rename = "noise")]
    Noise,
}

/// What each of the levels (any sequence) is, in their sequence: noise where the error is not clear of it; asymptotic from the
/// finest level of the window back to where a local slope leaves the estimate by more than [`TOLERANCE`]; all pre-asymptotic where
/// there is no estimate.
pub fn kinds(levels: &[Level], estimate: &Estimate) -> Vec<LevelKind> {
    let mut sequence: Vec<usize> = (0..levels.len()).collect();
    sequence.sort_by(|&a, &b| levels[a].h.total_cmp(&levels[b].h));
    let mut kinds = vec![LevelKind::Noise; levels.len()];
    let Some(slope) = estimate.slope() else {
        let clear = levels.iter().zip(&mut kinds).filter(|(level, _)| level.is_clear());
        clear.for_each(|(_, kind)| *kind = LevelKind::PreAsymptotic);
        return kinds;
    };
    // From the finest to the coarsest.
    let (mut on_line, mut finer) = (true, None::<&Level>);
    for k in sequence {
        let level = &levels[k];
        if !level.is_clear() {
            continue;
        }
        if let Some(finer) = finer {
            on_line &= (Slope::between(level, finer).value - slope).abs() <= TOLERANCE;
        }
        kinds[k] = if on_line { LevelKind::Asymptotic } else { LevelKind::PreAsymptotic };
        finer = Some(level);
    }
    kinds
}

/// The slope between two neighbouring levels.
#[derive(Clone, Copy)]
struct Slope {
    /// p_k.
    value: f64,
    /// How far noise may move it.
    noise: f64,
    /// H_k.
    at: f64,
}

impl Slope {
    fn between(coarse: &Level, fine: &Level) -> Self {
        let ratio = (coarse.h / fine.h).ln();
        let noise = NOISE_MARGIN * (coarse.noise / coarse.error + fine.noise / fine.error);
        Self { value: (coarse.error / fine.error).ln() / ratio, noise: noise / ratio, at: (coarse.h - fine.h) / ratio }
    }
}

/// The order of the errors, given in any sequence.
///
/// Inconclusive where a number is not finite or a step or an error is out of its range, where steps repeat (nearer than
/// 5 %), where fewer than four levels are clear of the noise, where slopes do not converge, and where levels within the
/// noise show more error than the estimate and the noise explain.
pub fn estimate(levels: &[Level]) -> Estimate {
    let inconclusive = |why: &str, slopes| Estimate::Inconclusive { why: why.into(), slopes };
    let finite = |l: &Level| {
        let valid = l.h > 0.0 && l.error >= 0.0 && l.noise >= 0.0;
        valid && l.h.is_finite() && l.error.is_finite() && l.noise.is_finite()
    };
    if !levels.iter().all(finite) {
        return inconclusive("a step, an error or a noise is not a number in its range", Vec::new());
    }
    let mut levels = levels.to_vec();
    levels.sort_by(|a, b| b.h.total_cmp(&a.h));
    if levels.windows(2).any(|pair| pair[0].h < 1.05 * pair[1].h) {
        return inconclusive("two steps are nearly the same", Vec::new());
    }
    // Coarse levels may be noise too, where the reference is worst there.
    let first = levels.iter().position(Level::is_clear).unwrap_or(levels.len());
    let levels = &levels[first..];
    let count = levels.iter().take_while(|level| level.is_clear()).count();
    let (line, rest) = levels.split_at(count);
    let slopes: Vec<_> = line.windows(2).map(|pair| Slope::between(&pair[0], &pair[1])).collect();
    let values = || slopes.iter().map(|slope| slope.value).collect();
    let [earlier @ .., first, second, last] = slopes.as_slice() else {
        return inconclusive("fewer than four levels are clear of the noise", values());
    };
    let window = (line[count - 4].h, line[count - 1].h);
    let Some(estimate) = extrapolate(earlier.last(), [*first, *second, *last], window) else {
        return inconclusive("the slopes have not settled", values());
    };
    if !explains(&estimate, &line[count - 1], rest) {
        return inconclusive("a level within the noise has more error than the slope and the noise explain", values());
    }
    estimate
}

/// The limit of three slopes at H = 0, or `None` where their differences do not die out.
fn extrapolate(earlier: Option<&Slope>, slopes: [Slope; 3], window: (f64, f64)) -> Option<Estimate> {
    let [first, second, last] = slopes;
    let (before, after) = (second.value - first.value, last.value - second.value);
    let noise = last.noise + second.noise;
    let settled = after.abs() <= SETTLED + noise;
    // Powers of H do not alternate, and do not grow before they shrink.
    let grew = |earlier: &Slope| before.abs() > SETTLED + noise + 2.0 * (first.value - earlier.value).abs();
    if (!settled && after * before < 0.0) || earlier.is_some_and(grew) {
        return None;
    }
    // How the difference shrinks from one pair of slopes to the next when deviations go as H^m, and what is left to come
    // after the last slope, in units of its difference.
    let shrink = |m: f64| (second.at.powf(m) - last.at.powf(m)) / (first.at.powf(m) - second.at.powf(m));
    let left = |m: f64| last.at.powf(m) / (second.at.powf(m) - last.at.powf(m));
    let ratio = (after / before).abs();
    let power = if ratio >= shrink(SLOWEST) {
        if !settled {
            return None;
        }
        1.0
    } else {
        decay(shrink, ratio)
    };
    // A difference much below what the one before it promised is chance, a turning point or a change of sign.
    let promised = before.abs() * shrink(2.0);
    let size = if settled && ratio >= 1.0 { after.abs() } else { after.abs().max(promised) };
    let mut ends = vec![last.value];
    for m in [1.0, power] {
        ends.push(last.value + left(m) * after);
    }
    if size > after.abs() {
        ends.extend([last.value - left(1.0) * size, last.value + left(1.0) * size]);
    }
    let spread = last.noise + left(1.0) * noise;
    let low = ends.iter().copied().fold(f64::INFINITY, f64::min) - spread;
    let high = ends.iter().copied().fold(f64::NEG_INFINITY, f64::max) + spread;
    let value = last.value + left(power.max(1.0)) * after;
    Some(Estimate::Slope { value, low, high, window })
}

/// Bisections of an interval of exponents: what is left, 8/2⁴⁰, is below any uncertainty of a slope.
const BISECTIONS: usize = 40;

/// The m in [`SLOWEST`, 8] with shrink(m) = ratio, by bisection (shrink decreases); the end where there is none.
fn decay(shrink: impl Fn(f64) -> f64, ratio: f64) -> f64 {
    let (mut slow, mut fast) = (SLOWEST, 8.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (slow + fast);
        if shrink(middle) > ratio {
            slow = middle;
        } else {
            fast = middle;
        }
    }
    0.5 * (slow + fast)
}

/// Whether each of `rest` has no more error than the estimate, continued from `last` at its lowest slope, and noise allow.
fn explains(estimate: &Estimate, last: &Level, rest: &[Level]) -> bool {
    let Estimate::Slope { low, .. } = *estimate else { return false };
    rest.iter().all(|level| {
        let predicted = last.error * (level.h / last.h).powf(low.max(0.0));
        level.error <= 1.25 * predicted + NOISE_MARGIN * level.noise.max(last.noise)
    })
}
