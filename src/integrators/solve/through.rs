//! Interpolation through the ends and the stages of a step.

use crate::algebra::{Covector, Vector};
use crate::integrators::variational::LEAST_NODE_DISTANCE;
use crate::scalar::Real;

/// Weights that are larger in sum give no guess: it would be rounding.
const LARGEST_WEIGHTS: f64 = 1e6;

/// Whether two nodes count as two.
pub(super) fn apart_from<T: Real>(one: T, other: T) -> bool {
    (one - other).abs() > T::exact(LEAST_NODE_DISTANCE)
}

/// (ξ̇, ṁ), seen from the start of a step.
pub(super) type Rates<T, const N: usize> = (Vector<T, N>, Covector<T, N>);

/// Lagrange interpolation through the start, the stages and the end of a step.
#[derive(Clone, Debug)]
pub(super) struct Through<T> {
    /// The stages that are nodes: those apart from each other and from the ends.
    kept: Vec<usize>,
    /// 0, the c of these stages, 1.
    nodes: Vec<T>,
    /// Barycentric weights.
    weights: Vec<T>,
}

impl<T: Real> Through<T> {
    pub fn new(c: &[T]) -> Self {
        let (mut kept, mut nodes) = (Vec::new(), vec![T::zero()]);
        for (i, &node) in c.iter().enumerate() {
            let apart = |other: &T| apart_from(node, *other);
            if nodes.iter().all(apart) && apart(&T::one()) {
                kept.push(i);
                nodes.push(node);
            }
        }
        nodes.push(T::one());
        let weight = |j: usize| (0..nodes.len()).filter(|&k| k != j).fold(T::one(), |w, k| w / (nodes[j] - nodes[k]));
        Self { weights: (0..nodes.len()).map(weight).collect(), kept, nodes }
    }

    /// The weights of the values at 0, the kept stages and 1 for the value at x; `false` if they are too large to be of use.
    pub fn row(&self, x: T, row: &mut [T]) -> bool {
        let n = self.nodes.len();
        if let Some(node) = self.nodes.iter().position(|&node| (node - x).abs() < T::unit_roundoff()) {
            row[..n].fill(T::zero());
            row[node] = T::one();
            return true;
        }
        let mut sum = T::zero();
        for k in 0..n {
            row[k] = self.weights[k] / (x - self.nodes[k]);
            sum += row[k];
        }
        let mut size = T::zero();
        for value in &mut row[..n] {
            *value /= sum;
            size += value.abs();
        }
        size < T::exact(LARGEST_WEIGHTS)
    }

    /// The value at the place of a row, from those at the ends and at the stages.
    pub fn value<const N: usize>(&self, row: &[T], ends: [&Vector<T, N>; 2], stages: &[Vector<T, N>]) -> Vector<T, N> {
        let last = self.nodes.len() - 1;
        let inner = self.kept.iter().zip(&row[1..last]);
        inner.fold(ends[0] * row[0] + ends[1] * row[last], |sum, (&i, &w)| sum + stages[i] * w)
    }

    /// The same of pairs of values.
    pub fn both<const N: usize>(&self, row: &[T], ends: [&Rates<T, N>; 2], stages: &[Rates<T, N>]) -> Rates<T, N> {
        let last = self.nodes.len() - 1;
        let inner = self.kept.iter().zip(&row[1..last]).map(|(&i, &w)| (&stages[i], w));
        let ends = [(ends[0], row[0]), (ends[1], row[last])];
        let zero = (Vector::zeros(), Covector::zeros());
        ends.into_iter().chain(inner).fold(zero, |sum, (rates, w)| (sum.0 + rates.0 * w, sum.1 + rates.1 * w))
    }

    /// How many numbers a row has.
    pub fn len(&self) -> usize {
        self.nodes.len()
    }
}
