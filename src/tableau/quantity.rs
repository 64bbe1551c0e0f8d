//! What the coefficients of a tableau can be in an analysis: balls over a scalar, or exact rationals.

use super::order::Verdict;
use super::trees::Tree;
use super::{Entries, Tableau};
use crate::scalar::Real;
use std::fmt::Debug;

/// A number that conditions on a tableau are evaluated in, and that knows when it may be zero.
pub trait Quantity: Clone + Debug {
    /// p/q.
    fn fraction(p: i64, q: i64) -> Self;

    /// self + other.
    fn plus(&self, other: &Self) -> Self;

    /// self − other.
    fn minus(&self, other: &Self) -> Self;

    /// self × other.
    fn times(&self, other: &Self) -> Self;

    /// self / other.
    fn over(&self, other: &Self) -> Self;

    /// Whether the value is zero, as far as this many rounded operations on rounded coefficients can tell.
    fn vanishes(&self, operations: usize) -> bool;

    /// Whether this, as Σ b Φ of a tree over as many stages, is 1/γ.
    #[doc(hidden)]
    fn verdict(&self, tree: &Tree, stages: usize) -> Verdict;

    /// This, as Σ b Φ of a tree, and Σ b Φ − 1/γ, where they are fractions.
    #[doc(hidden)]
    fn fractions(&self, _tree: &Tree) -> Option<[String; 2]> {
        None
    }

    /// The nearest `f64`.
    fn to_f64(&self) -> f64;

    /// The value as text: a fraction where that is exact and short, else a decimal.
    fn show(&self) -> String;
}

/// A value with two bounds: |value| summed over magnitudes, of which round-off is a modest multiple times u, and how far
/// the value may be off because coefficients were given to a few digits only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball<T> {
    /// The centre.
    pub value: T,
    /// The same expression with all magnitudes added, at least |value|.
    pub size: f64,
    /// A bound on the change of the value when every coefficient moves within its uncertainty.
    pub radius: f64,
}

impl<T: Real> Ball<T> {
    /// A value known to round-off.
    pub fn new(value: T, size: f64) -> Self {
        Self { value, size, radius: 0.0 }
    }

    /// What the value may be off by: `operations` u size, and the radius; `None` if it is not finite.
    pub fn tolerance(&self, operations: usize) -> Option<f64> {
        let bound = operations as f64 * T::unit_roundoff().to_f64() * self.size + self.radius;
        (bound.is_finite() && self.value.all_finite()).then_some(bound)
    }
}

impl<T: Real> Quantity for Ball<T> {
    fn fraction(p: i64, q: i64) -> Self {
        let value = T::ratio(p, q);
        Self::new(value, value.abs().to_f64())
    }

    fn plus(&self, other: &Self) -> Self {
        Self { value: self.value + other.value, size: self.size + other.size, radius: self.radius + other.radius }
    }

    fn minus(&self, other: &Self) -> Self {
        Self { value: self.value - other.value, size: self.size + other.size, radius: self.radius + other.radius }
    }

    fn times(&self, other: &Self) -> Self {
        let (x, y) = (self.value.abs().to_f64(), other.value.abs().to_f64());
        Self {
            value: self.value * other.value,
            size: self.size * other.size,
            radius: x * other.radius + self.radius * (y + other.radius),
        }
    }

    fn over(&self, other: &Self) -> Self {
        let value = self.value / other.value;
        let (size, divisor) = (value.abs().to_f64(), other.value.abs().to_f64());
        // |x'/y' − x/y| ≤ (r_x + |x/y| r_y)/(|y| − r_y); a divisor that may be zero leaves everything open.
        let rest = divisor - other.radius;
        let radius = if rest > 0.0 { (self.radius + size * other.radius) / rest } else { f64::INFINITY };
        Self { value, size, radius }
    }

    fn vanishes(&self, operations: usize) -> bool {
        self.tolerance(operations).is_some_and(|bound| self.value.abs().to_f64() <= bound)
    }

    /// Within 8 n (s + 2) u Σ|b||Φ| and the radius.
    fn verdict(&self, tree: &Tree, stages: usize) -> Verdict {
        let defect = (self.value - T::ratio(1, tree.density() as i64)).to_f64();
        // A weight that is not a number (overflow) fulfils no condition.
        let tolerance = self.tolerance(8 * tree.order() * (stages + 2));
        let holds = tolerance.is_some_and(|bound| defect.abs() <= bound);
        Verdict { holds, weight: self.value.to_f64(), defect, tolerance: tolerance.unwrap_or(f64::INFINITY) }
    }

    fn to_f64(&self) -> f64 {
        self.value.to_f64()
    }

    fn show(&self) -> String {
        decimal(self.value.to_f64())
    }
}

/// Six significant digits, without zeros at the end.
pub(super) fn decimal(x: f64) -> String {
    digits(x, 6)
}

/// `count` significant digits (at most 17), without zeros at the end.
pub(super) fn digits(x: f64, count: i32) -> String {
    if x == 0.0 {
        return "0".into();
    }
    let count = count.clamp(2, 17);
    if !(1e-4..1e6).contains(&x.abs()) {
        return format!("{x:.0$e}", (count - 1).min(3) as usize);
    }
    let places = (count - 1 - x.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.places$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// A tableau with its conjugate and its row sums, in any [`Quantity`].
#[derive(Clone, Debug, PartialEq)]
pub struct Coefficients<Q> {
    /// a_ij, by rows.
    pub a: Vec<Vec<Q>>,
    /// â_ij = b_j − b_j a_ji/b_i.
    pub hat: Vec<Vec<Q>>,
    /// b_j.
    pub b: Vec<Q>,
    /// c_i = Σ_j a_ij.
    pub c: Vec<Q>,
}

impl<Q: Quantity> Coefficients<Q> {
    /// The number of stages.
    pub fn stages(&self) -> usize {
        self.b.len()
    }

    pub(super) fn new(a: Vec<Vec<Q>>, hat: Vec<Vec<Q>>, b: Vec<Q>) -> Self {
        let zero = Q::fraction(0, 1);
        let c = a.iter().map(|row| row.iter().fold(zero.clone(), |sum, x| sum.plus(x))).collect();
        Self { a, hat, b, c }
    }
}

impl<T: Real> Coefficients<Ball<T>> {
    /// The coefficients of a tableau, each taken to be right to round-off of |a_ij| + |b_j|.
    pub fn of(tableau: &Tableau<T>) -> Self {
        Self::with_radii(tableau, |_, _| 0.0, |_| 0.0)
    }

    /// The tableau that was built from these entries, each coefficient off by at most its [allowance](Entries::allowances), whichever is
    /// larger (and b_j by what dividing by Σb moved it).
    pub fn to_digits(tableau: &Tableau<T>, entries: &Entries) -> Self {
        let moved = |j: usize| entries.b[j].eval::<T>().map_or(0.0, |x| (x - tableau.b()[j]).abs().to_f64());
        let [uniform, own] = [true, false].map(|uniform| entries.allowances(uniform));
        let (s, allowance) = (tableau.stages(), |at: usize| uniform[at].max(own[at]));
        Self::with_radii(tableau, |i, j| allowance(i * s + j), |j| allowance(s * s + j) + moved(j))
    }

    fn with_radii(t: &Tableau<T>, of_a: impl Fn(usize, usize) -> f64, of_b: impl Fn(usize) -> f64) -> Self {
        let s = t.stages();
        let square = |entry: &dyn Fn(usize, usize) -> Ball<T>| -> Vec<Vec<Ball<T>>> {
            (0..s).map(|i| (0..s).map(|j| entry(i, j)).collect()).collect()
        };
        let size = |x: T| x.abs().to_f64();
        let b: Vec<_> = (0..s).map(|j| Ball { value: t.b()[j], size: size(t.b()[j]), radius: of_b(j) }).collect();
        // â_ij = b_j − b_j a_ji/b_i: an error u b_i of a_ji becomes one of u b_j, so b_j measures it in both matrices.
        let a = square(&|i, j| {
            let value = t.a()[(i, j)];
            Ball { value, size: size(value) + b[j].size, radius: of_a(i, j) }
        });
        let conjugate = t.conjugate();
        let hat = square(&|i, j| {
            let ball = b[j].times(&Ball::fraction(1, 1).minus(&a[j][i].over(&b[i])));
            let value = conjugate.a()[(i, j)];
            Ball { value, size: size(value) + b[j].size, radius: ball.radius }
        });
        Self::new(a, hat, b)
    }
}
