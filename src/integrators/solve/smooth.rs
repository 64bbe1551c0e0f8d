//! Whether the force is smooth over a pair of steps: how well the stages of a step predict it at both ends, where it is known.
//!
//! The estimate of the error takes the force to be smooth. Where it jumps between the stages of a step, the difference is about as large as
//! the error, not 2ᵖ − 1 times; where it jumps between the outermost stages and the start, the middle or the end of a pair, there is no
//! difference at all. Of a smooth force, interpolation through s stages misses about f⁽ˢ⁾hˢ at each of the four ends of the two steps. Of a jump J
//! it misses about J, in one of the steps alone.

use super::pair::{Half, apart_from};
use crate::algebra::Covector;
use crate::scalar::Real;

/// Stages that miss the force by so many times as much in one step of a pair as in the other have passed a jump. No pair of the runs on SO(3),
/// SE(2), SL(2), SE(3) and SO(4), from 10⁻³ to 10⁻¹², has such a step; with 4 none has, either. With 16, three times as many jumps of 10⁻⁴ of the force
/// go unseen at 10⁻⁸.
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
        (!kept.is_empty() && size < T::exact(LARGEST_WEIGHTS)).then_some(Self { weights, gap })
    }

    /// The force there, as the stages predict it, seen from the start of the step.
    pub fn predicted<const N: usize>(&self, half: &Half<T, N>) -> Covector<T, N> {
        self.weights.iter().zip(&half.rates).fold(Covector::zeros(), |sum, (&w, (_, force))| sum + force * w)
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
