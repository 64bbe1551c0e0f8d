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

    /// How many values.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean; 0 of none.
    pub fn mean(&self) -> T {
        self.mean
    }

    /// √(Σ (x − mean)² / count); 0 of none.
    pub fn deviation(&self) -> T {
        (self.squares / T::int(self.count.max(1) as i64)).sqrt()
    }

    /// The smallest; 0 of none.
    pub fn min(&self) -> T {
        self.min
    }

    /// The largest; 0 of none.
    pub fn max(&self) -> T {
        self.max
    }
}

/// Of all quantities of the members of an ensemble at a time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Statistics<T> {
    /// Members that are counted.
    pub members: u64,
    /// Of μ_1 … μ_n.
    pub momentum: Vec<Moments<T>>,
    /// Of the energy.
    pub energy: Moments<T>,
    /// Of the Casimirs that are known.
    pub casimirs: Vec<Moments<T>>,
    /// The largest [`crate::group::departure()`] of an attitude: |gᵀg − 1| for rotations. 0 without a group.
    pub departure: T,
}

impl<T: Real> Statistics<T> {
    /// Of no members.
    pub fn none(dimension: usize, casimirs: usize) -> Self {
        Self {
            members: 0,
            momentum: vec![Moments::default(); dimension],
            energy: Moments::default(),
            casimirs: vec![Moments::default(); casimirs],
            departure: T::zero(),
        }
    }

    /// Of these members and those, of the same system.
    pub fn merge(&mut self, other: &Self) {
        self.members += other.members;
        self.momentum.iter_mut().zip(&other.momentum).for_each(|(x, y)| x.merge(y));
        self.energy.merge(&other.energy);
        self.casimirs.iter_mut().zip(&other.casimirs).for_each(|(x, y)| x.merge(y));
        self.departure = self.departure.max(other.departure);
    }
}
