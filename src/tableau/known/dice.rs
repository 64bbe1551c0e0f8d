//! The choices of a construction.

use super::fraction::Fraction;
use proptest::prelude::Rng;
use proptest::test_runner::TestRng;

/// Makes the choices of a construction; choice 0 is the simplest.
pub struct Dice<'a> {
    rng: &'a mut TestRng,
    /// Whether to stay with the first third of every list.
    narrow: bool,
    /// Whether negative weights will not do.
    positive: bool,
}

impl<'a> Dice<'a> {
    /// Random choices, with positive weights if so asked.
    pub fn random(rng: &'a mut TestRng, positive: bool) -> Self {
        Self { rng, narrow: false, positive }
    }

    /// Random choices of simple things.
    pub fn narrow(rng: &'a mut TestRng, positive: bool) -> Self {
        Self { rng, narrow: true, positive }
    }

    /// Whether these weights will do as far as their signs go.
    pub fn accepts(&self, b: &[Fraction]) -> bool {
        !self.positive || b.iter().all(|b| b.numerator() > 0)
    }

    /// 0, …, n − 1.
    pub fn below(&mut self, n: usize) -> usize {
        (self.rng.next_u64() % n.max(1) as u64) as usize
    }

    /// An item.
    pub fn pick(&mut self, items: &[(i64, i64)]) -> Fraction {
        let count = if self.narrow { items.len().div_ceil(3) } else { items.len() };
        let (p, q) = items[self.below(count)];
        Fraction::new(p, q)
    }

    /// n items.
    pub fn picks(&mut self, n: usize, items: &[(i64, i64)]) -> Vec<Fraction> {
        (0..n).map(|_| self.pick(items)).collect()
    }

    /// 0 more often than 1, 1 than 2, …, up to `most`; always 0 if narrow.
    pub fn few(&mut self, most: usize) -> usize {
        let most = if self.narrow { 0 } else { most };
        let weights = (most + 1) * (most + 2) / 2;
        let mut rest = self.below(weights);
        for value in 0..=most {
            if rest < most + 1 - value {
                return value;
            }
            rest -= most + 1 - value;
        }
        0
    }

    /// A permutation of 0, …, n − 1; the identity if every choice is 0.
    pub fn permutation(&mut self, n: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..n).collect();
        for i in 0..n.saturating_sub(1) {
            let j = i + self.below(n - i);
            order.swap(i, j);
        }
        order
    }
}
