//! Mean, spread and range of what the members have.

use crate::scalar::Real;

/// Of one quantity. Numbers are added one by one or a part at a time; the sequence decides the rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments<T> {
    count: u64,
    mean: T,
    /// Σ (x − mean)².
    squares: T,
    min: T,
    max: T,
}

impl<T: Real> Default for Moments<T> {
    fn default() -> Self {
        let zero = T::zero();
        Self { count: 0, mean: zero, squares: zero, min: zero, max: zero }
    }
}

impl<T: Real> Moments<T> {
    /// One more value (Welford 1962).
    pub fn add(&mut self, value: T) {
        self.merge(&Self { count: 1, mean: value, squares: T::zero(), min: value, max: value });
    }

    /// All values of another part (Chan, Golub and LeVeque 1979).
    pub fn merge(&mut self, other: &Self) {
        if self.count == 0 || other.count == 0 {
            *self = if self.count == 0 { *other } else { *self };
            return;
        }
        let (a, b) = (T::int(self.count as i64), T::int(other.count as i64));
        let gap = other.mean - self.mean;
        self.mean += gap * (b / (a + b));
        self.squares += other.squares + gap * gap * (a * b / (a + b));
        self.min = self.min.min(other.min);
        self.max = self.max.max(other.max);
        self.count += other.count;
    }

    /// The mean, √(Σ (x − mean)² / count), the smallest and the largest; `None` of no values.
    pub fn summary(&self) -> Option<[T; 4]> {
        let deviation = (self.squares / T::int(self.count.max(1) as i64)).sqrt();
        (self.count > 0).then_some([self.mean, deviation, self.min, self.max])
    }
}

/// Of all quantities of the members of an ensemble at a time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Statistics<T> {
    /// Members that are counted.
    pub members: u64,
    /// Of μ_1 … μ_n, the energy, and the Casimirs that are known.
    pub moments: Vec<Moments<T>>,
    /// The largest [`crate::group::departure()`] of an attitude: |gᵀg − 1| for rotations. 0 without a group.
    pub departure: T,
}

impl<T: Real> Statistics<T> {
    /// Of no members, for a number of quantities.
    pub fn none(quantities: usize) -> Self {
        Self { members: 0, moments: vec![Moments::default(); quantities], departure: T::zero() }
    }

    /// Of these members and those, of the same system.
    pub fn merge(&mut self, other: &Self) {
        self.members += other.members;
        self.moments.iter_mut().zip(&other.moments).for_each(|(x, y)| x.merge(y));
        self.departure = self.departure.max(other.departure);
    }
}
