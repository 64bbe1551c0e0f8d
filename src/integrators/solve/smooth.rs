//! Whether the motion is smooth over a pair of steps: how well the stages of a step predict the velocity and the force at its ends, where they
//! are known.
//!
//! The estimate of the error takes the difference of two steps of h and one of 2h to be 2ᵖ − 1 times the error of the former. Then
//! interpolation through s stages misses about f⁽ˢ⁾hˢ of a function f at the ends of a step, 2ˢ times less with h than with 2h, and at all four ends of the
//! two steps about the same. Where it falls by less, the difference does, too.
//!
//! Where a force jumps between the outermost stages and the start, the middle or the end of a pair, there is no difference at all. Of a jump J about J is
//! missed, in one of the two steps alone, and as much of it with 2h.

use super::through::apart_from;
use crate::scalar::Real;
use nalgebra::SMatrix;

/// Stages that miss the force by this factor more in one step of a pair as in the other may have passed a jump: of a smooth motion, too, where the
/// force falls fast. With 16, three times as many jumps of 10⁻⁴ of the force go unseen at 10⁻⁸.
const OUTLIER: i64 = 8;

/// Weights that are larger in sum predict nothing but rounding.
const LARGEST_WEIGHTS: f64 = 1e3;

/// An end of a step.
#[derive(Clone, Debug)]
pub(super) struct End<T> {
    /// The weights of the stages for the value there.
    weights: Vec<T>,
    /// How far it is from the next of these stages, in steps.
    gap: T,
    /// How many they are.
    stages: usize,
}

impl<T: Real> End<T> {
    /// The end at x = 0 or 1 of steps with these nodes; none where they predict nothing.
    fn new(c: &[T], x: T) -> Option<Self> {
        let mut kept: Vec<usize> = Vec::new();
        for i in 0..c.len() {
            if apart_from(c[i], x) && kept.iter().all(|&k| apart_from(c[i], c[k])) {
                kept.push(i);
            }
        }
        let (mut weights, mut size) = (vec![T::zero(); c.len()], T::zero());
        for &j in &kept {
            let others = kept.iter().filter(|&&k| k != j);
            weights[j] = others.fold(T::one(), |w, &k| w * (x - c[k]) / (c[j] - c[k]));
            size += weights[j].abs();
        }
        let gap = kept.iter().fold(T::one(), |gap, &k| gap.min((c[k] - x).abs()));
        (!kept.is_empty() && size < T::exact(LARGEST_WEIGHTS)).then_some(Self { weights, gap, stages: kept.len() })
    }

    /// The velocity there, or the force seen from the start of the step, as the stages predict it.
    pub fn value<const R: usize, const C: usize>(
        &self,
        stages: &mut dyn Iterator<Item = SMatrix<T, R, C>>,
    ) -> SMatrix<T, R, C> {
        self.weights.iter().zip(stages).fold(SMatrix::zeros(), |sum, (&w, value)| sum + value * w)
    }
}

/// A jump of the force.
#[derive(Clone, Copy, Debug)]
pub(super) struct Jump<T> {
    /// In which step of the pair.
    pub step: usize,
    /// Which of its ends is missed by more.
    pub end: usize,
    /// By how much.
    pub size: T,
    /// The share of the step that may pass until a stage knows of it.
    pub share: T,
}

/// Both ends of steps with these nodes.
#[derive(Clone, Debug)]
pub(super) struct Ends<T> {
    pub at: [End<T>; 2],
    /// The largest distance between stages that follow each other, in steps.
    within: T,
}

impl<T: Real> Ends<T> {
    pub fn new(c: &[T]) -> Option<Self> {
        let at = [End::new(c, T::zero())?, End::new(c, T::one())?];
        let mut nodes = c.to_vec();
        nodes.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
        let within = nodes.windows(2).fold(T::zero(), |most, pair| most.max(pair[1] - pair[0]));
        Some(Self { at, within })
    }

    /// By how many powers of 2 less is missed of the velocity of a smooth motion in a step of half the size, with stages of this order.
    pub fn powers(&self, stage_order: usize) -> f64 {
        self.at.iter().fold(stage_order + 1, |least, end| least.min(end.stages)) as f64
    }

    /// The jump, if there is one, of what is missed at the start and the end of both steps.
    pub fn outlier(&self, misses: [[T; 2]; 2]) -> Option<Jump<T>> {
        let [first, second] = misses.map(|[start, end]| start.max(end));
        let (k, size, other) = if first > second { (0, first, second) } else { (1, second, first) };
        if size <= other * T::int(OUTLIER) {
            return None;
        }
        let end = usize::from(misses[k][1] > misses[k][0]);
        let alone = misses[k][1 - end] <= other * T::int(OUTLIER);
        Some(Jump { step: k, end, size, share: if alone { self.at[end].gap } else { self.within } })
    }
}
