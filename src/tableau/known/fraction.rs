//! Fractions of 64-bit integers whose arithmetic never wraps, and linear equations over them.
//!
//! A result that does not fit, and a division by zero, is [`Fraction::NONE`], which spreads like a NaN: a construction is
//! carried to its end and looked at there.

use crate::scalar::Number;
use num_integer::Integer;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// p/q in lowest terms with q > 0, or [`Fraction::NONE`] (q = 0).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Fraction {
    p: i64,
    q: i64,
}

impl Fraction {
    /// No number.
    pub const NONE: Fraction = Fraction { p: 0, q: 0 };
    /// 0.
    pub const ZERO: Fraction = Fraction { p: 0, q: 1 };
    /// 1.
    pub const ONE: Fraction = Fraction { p: 1, q: 1 };

    /// p/q; [`Fraction::NONE`] if q = 0.
    pub fn new(p: i64, q: i64) -> Self {
        Self::reduced(p.into(), q.into())
    }

    fn reduced(p: i128, q: i128) -> Self {
        if q == 0 {
            return Self::NONE;
        }
        let g = p.unsigned_abs().gcd(&q.unsigned_abs()) as i128 * q.signum();
        match (i64::try_from(p / g), i64::try_from(q / g)) {
            (Ok(p), Ok(q)) => Self { p, q },
            _ => Self::NONE,
        }
    }

    /// Whether this is a number.
    pub fn is_some(self) -> bool {
        self.q != 0
    }

    /// Whether this is 0.
    pub fn is_zero(self) -> bool {
        self.p == 0 && self.q != 0
    }

    /// q.
    pub fn denominator(self) -> i64 {
        self.q
    }

    /// p.
    pub fn numerator(self) -> i64 {
        self.p
    }

    /// The value, a NaN for [`Fraction::NONE`].
    pub fn value(self) -> f64 {
        self.p as f64 / self.q as f64
    }

    /// |p/q|, a NaN for [`Fraction::NONE`].
    pub fn size(self) -> f64 {
        self.value().abs()
    }

    /// As it stands in a description.
    pub fn number(self) -> Number {
        Number::ratio(self.p, self.q)
    }
}

impl Add for Fraction {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (p, q, r, s) = (i128::from(self.p), i128::from(self.q), i128::from(other.p), i128::from(other.q));
        // |p s|, |r q| ≤ 2¹²⁶: no overflow.
        Self::reduced(p * s + r * q, q * s)
    }
}

impl Neg for Fraction {
    type Output = Self;

    fn neg(self) -> Self {
        self.p.checked_neg().map_or(Self::NONE, |p| Self { p, ..self })
    }
}

impl Sub for Fraction {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Fraction {
    type Output = Self;

    fn mul(self, other: Self) -> Self {
        Self::reduced(i128::from(self.p) * i128::from(other.p), i128::from(self.q) * i128::from(other.q))
    }
}

impl Div for Fraction {
    type Output = Self;

    fn div(self, other: Self) -> Self {
        if !other.is_some() {
            return Self::NONE;
        }
        Self::reduced(i128::from(self.p) * i128::from(other.q), i128::from(self.q) * i128::from(other.p))
    }
}

/// Σ of the terms.
pub fn sum(terms: impl IntoIterator<Item = Fraction>) -> Fraction {
    terms.into_iter().fold(Fraction::ZERO, |sum, x| sum + x)
}

/// Σ_j x_j y_j.
pub fn dot(x: &[Fraction], y: &[Fraction]) -> Fraction {
    let products = x.iter().zip(y).filter(|(x, y)| !x.is_zero() && !y.is_zero()).map(|(&x, &y)| x * y);
    sum(products)
}

/// x^n.
pub fn power(x: Fraction, n: usize) -> Fraction {
    (0..n).fold(Fraction::ONE, |product, _| product * x)
}

/// Linear equations Σ_j row_j x_j = right.
#[derive(Clone, Debug, Default)]
pub struct Equations {
    rows: Vec<(Vec<Fraction>, Fraction)>,
}

impl Equations {
    /// Σ_j row_j x_j = right as well.
    pub fn add(&mut self, row: Vec<Fraction>, right: Fraction) {
        self.rows.push((row, right));
    }

    /// The solution that differs from `guess` in as few unknowns as the rank asks for, the first of `order` that can be
    /// solved for; `None` if there is no solution or a number on the way does not fit.
    pub fn solve(mut self, guess: &[Fraction], order: &[usize]) -> Option<Vec<Fraction>> {
        let mut x = guess.to_vec();
        for (row, right) in &mut self.rows {
            *right = *right - dot(row, guess);
        }
        // Gauss–Jordan in the columns by their order; rows up to `done` have a pivot.
        let (mut done, mut pivots) = (0, Vec::new());
        for &column in order {
            let Some(found) = (done..self.rows.len()).find(|&i| !self.rows[i].0[column].is_zero()) else { continue };
            self.rows.swap(done, found);
            let (head, right) = self.rows[done].clone();
            for (i, (row, value)) in self.rows.iter_mut().enumerate() {
                if i == done || row[column].is_zero() {
                    continue;
                }
                let factor = row[column] / head[column];
                for (x, &y) in row.iter_mut().zip(&head).filter(|(_, y)| !y.is_zero()) {
                    *x = *x - factor * y;
                }
                *value = *value - factor * right;
            }
            pivots.push(column);
            done += 1;
        }
        if self.rows[done..].iter().any(|(_, right)| !right.is_zero()) {
            return None;
        }
        for (&column, (row, right)) in pivots.iter().zip(&self.rows) {
            x[column] = x[column] + *right / row[column];
        }
        x.iter().all(|x| x.is_some()).then_some(x)
    }
}
