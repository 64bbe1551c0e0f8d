//! A-stability, decided on the stability function R(z) = 1 + z bᵀ(1 − z a)⁻¹ 𝟙 = P(z)/Q(z) in exact polynomial arithmetic.
//!
//! P(z) = det(1 − z (a − 𝟙 bᵀ)) and Q(z) = det(1 − z a), divided by their greatest common divisor. The method is A-stable,
//! |R(z)| ≤ 1 for Re z ≤ 0, if and only if no zero of Q has a negative real part (Routh's array of Q(−z)) and
//! E(y) = |Q(iy)|² − |P(iy)|² ≥ 0 for all real y (Sturm's theorem, in y²); by the maximum principle.
//!
//! Source: Hairer and Wanner, *Solving Ordinary Differential Equations II*, sections IV.3 and IV.5.

use super::Tableau;
use super::quantity::{Ball, Coefficients, Quantity, digits};
use super::structure::Shape;
use crate::scalar::{Dd, Scalar};
use dashu_int::ops::BitTest;
use dashu_ratio::RBig;
use nalgebra::ComplexField;
use std::fmt;

/// Tableaux with more stages are not decided.
pub const MOST_STAGES: usize = 10;

/// Tableaux with s times as many bits in a denominator are not decided.
pub const MOST_BITS: usize = 4096;

/// Whether the method is A-stable.
#[derive(Clone, Debug, PartialEq)]
pub enum Stability {
    /// |R(z)| ≤ 1 for all Re z ≤ 0.
    AStable,
    /// Not so, with a reason.
    Not(String),
    /// Not decided, with the reason.
    Undecided(String),
}

impl fmt::Display for Stability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Stability::AStable => f.write_str("A-stable"),
            Stability::Not(why) => write!(f, "not A-stable: {why}"),
            Stability::Undecided(why) => write!(f, "A-stability not decided: {why}"),
        }
    }
}

impl Stability {
    /// Of a tableau of rationals.
    pub fn of_rational(coefficients: &Coefficients<RBig>) -> Self {
        let s = coefficients.stages();
        if s > MOST_STAGES {
            return too_many(s);
        }
        let bits = coefficients.a.iter().flatten().chain(&coefficients.b).map(|x| x.denominator().bit_len()).max();
        if s * bits.unwrap_or(0) > MOST_BITS {
            return Stability::Undecided("the fractions are too long".into());
        }
        let [p, q] = fraction_of(coefficients);
        decide(&p, &q)
    }

    /// Of a tableau in 32 digits, to their precision.
    ///
    /// If every coefficient of P and of Q is recognised as a fraction (R of a family is a Padé approximation of e^z), the
    /// answer is that for these fractions: one is recognised if it differs from the coefficient by round-off only, and
    /// chance would have a part of at most 10⁻⁹ in that. Otherwise a (diagonally) triangular a is decided if the
    /// coefficients of E have one sign, those within round-off of 0 taken as 0; all else is left open.
    pub fn of(tableau: &Tableau<Dd>) -> Self {
        let s = tableau.stages();
        if s > MOST_STAGES {
            return too_many(s);
        }
        let coefficients = Coefficients::of(tableau);
        let [p, q] = fraction_of(&coefficients);
        let recognised =
            |polynomial: &[Ball<Dd>]| polynomial.iter().map(|x| recognise(x, s)).collect::<Option<Vec<_>>>();
        match (recognised(&p), recognised(&q)) {
            (Some(p), Some(q)) => decide(&p, &q),
            _ => triangular(&coefficients, &p, &q),
        }
    }
}

impl Stability {
    /// The answer for a tableau of rounded decimals, from that for exactly these digits: a "no" that rests on the digits
    /// that are not there becomes undecided.
    pub(super) fn within_digits(self, coefficients: &Coefficients<Ball<Dd>>) -> Self {
        let Stability::Not(why) = self else { return self };
        let [p, q] = fraction_of(coefficients);
        let (excess, s) = (excess(&p, &q), coefficients.stages());
        let clear = (-16..=16).any(|k| {
            // E(y) at y² = 2^k, by Horner's rule.
            let square = Ball::new(Dd::exact(2f64.powi(k)), 2f64.powi(k));
            let value = excess.iter().rev().fold(Ball::fraction(0, 1), |sum, x| sum.times(&square).plus(x));
            value.value.to_f64() < 0.0 && !value.vanishes(4 * operations(s))
        });
        if clear {
            return Stability::Not(why);
        }
        Stability::Undecided(format!(
            "it is not A-stable with exactly these digits ({why}), but may be within rounding"
        ))
    }
}

fn too_many(stages: usize) -> Stability {
    Stability::Undecided(format!("{stages} stages are more than {MOST_STAGES}"))
}

/// P and Q.
fn fraction_of<Q: Quantity>(coefficients: &Coefficients<Q>) -> [Vec<Q>; 2] {
    let (a, b, s) = (&coefficients.a, &coefficients.b, coefficients.stages());
    [reversed_characteristic(s, |i, j| a[i][j].minus(&b[j])), reversed_characteristic(s, |i, j| a[i][j].clone())]
}

/// The coefficients of det(1 − z M), by increasing powers of z (Faddeev and LeVerrier).
fn reversed_characteristic<Q: Quantity>(s: usize, entry: impl Fn(usize, usize) -> Q) -> Vec<Q> {
    let zero = Q::fraction(0, 1);
    let matrix: Vec<Vec<Q>> = (0..s).map(|i| (0..s).map(|j| entry(i, j)).collect()).collect();
    let mut polynomial = vec![Q::fraction(1, 1)];
    let mut power: Vec<Vec<Q>> = vec![vec![zero.clone(); s]; s];
    for k in 1..=s {
        // M_k = M (M_{k−1} + p_{k−1}), p_k = −tr M_k/k.
        (0..s).for_each(|i| power[i][i] = power[i][i].plus(&polynomial[k - 1]));
        let product =
            |i: usize, j: usize| (0..s).fold(zero.clone(), |sum, l| sum.plus(&matrix[i][l].times(&power[l][j])));
        power = (0..s).map(|i| (0..s).map(|j| product(i, j)).collect()).collect();
        let trace = (0..s).fold(zero.clone(), |sum, i| sum.plus(&power[i][i]));
        polynomial.push(trace.times(&Q::fraction(-1, k as i64)));
    }
    polynomial
}

/// |f(iy)|² as a polynomial in y².
fn squared<Q: Quantity>(f: &[Q]) -> Vec<Q> {
    let mut square = vec![Q::fraction(0, 1); f.len()];
    // f(iy) f(−iy): only terms of even degree are left, i^k (−i)^l = (−1)^{(k − l)/2}.
    for (k, x) in f.iter().enumerate() {
        for (l, y) in f.iter().enumerate().filter(|(l, _)| (k + l) % 2 == 0) {
            let (at, term) = ((k + l) / 2, x.times(y));
            square[at] = if k.abs_diff(l) % 4 == 0 { square[at].plus(&term) } else { square[at].minus(&term) };
        }
    }
    square
}

/// |Q(iy)|² − |P(iy)|² as a polynomial in y².
fn excess<Q: Quantity>(p: &[Q], q: &[Q]) -> Vec<Q> {
    let [p, q] = [squared(p), squared(q)];
    let at = |f: &[Q], k: usize| f.get(k).cloned().unwrap_or_else(|| Q::fraction(0, 1));
    (0..p.len().max(q.len())).map(|k| at(&q, k).minus(&at(&p, k))).collect()
}

/// The most convergents of a continued fraction: their denominators grow at least as Fibonacci's numbers, of which the fortieth
/// is 10⁸.
const MAX_CONVERGENTS: usize = 40;

/// The simplest fraction that the value is to round-off, if that is no coincidence.
fn recognise(x: &Ball<Dd>, stages: usize) -> Option<RBig> {
    let noise = x.tolerance(operations(stages))?;
    let (mut rest, mut before, mut last) = (x.value, (0i64, 1i64), (1i64, 0i64));
    for _ in 0..MAX_CONVERGENTS {
        let floor = rest.floor();
        let whole = floor.to_f64();
        if whole.abs() > 1e15 {
            return None;
        }
        let next = |last: i64, before: i64| last.checked_mul(whole as i64)?.checked_add(before);
        let convergent = (next(last.0, before.0)?, next(last.1, before.1)?);
        let chance = (convergent.1 as f64).powi(2) * noise;
        if convergent.1.unsigned_abs() > 1 << 53 || chance > 1e-9 {
            return None;
        }
        if (x.value - Dd::int(convergent.0) / Dd::int(convergent.1)).abs().to_f64() <= noise {
            return Some(RBig::fraction(convergent.0, convergent.1));
        }
        (before, last) = (last, convergent);
        rest = Dd::exact(1.0) / (rest - floor);
        if !rest.all_finite() {
            return None;
        }
    }
    None
}

/// How many rounded operations are behind a coefficient, with the size of its terms as measure.
fn operations(stages: usize) -> usize {
    16 * (stages + 1) * (stages + 1)
}

/// Where the poles are 1/a_ii and the signs of the coefficients of E are clear.
fn triangular(coefficients: &Coefficients<Ball<Dd>>, p: &[Ball<Dd>], q: &[Ball<Dd>]) -> Stability {
    let open =
        |why: &str| Stability::Undecided(format!("the stability function has irrational coefficients, and {why}"));
    let s = coefficients.stages();
    if Shape::of(coefficients) == Shape::FullyImplicit {
        return open("a is not triangular");
    }
    if (0..s).any(|i| coefficients.a[i][i].value.to_f64() < 0.0) {
        return open("an a_ii is negative");
    }
    let excess = excess(p, q);
    let clear: Vec<f64> = excess.iter().filter(|x| !x.vanishes(4 * operations(s))).map(Ball::to_f64).collect();
    match (clear.first(), clear.last()) {
        (Some(&first), Some(&last)) if first < 0.0 || last < 0.0 => Stability::Not(witness(&floats(p), &floats(q))),
        _ if clear.iter().all(|&x| x > 0.0) => Stability::AStable,
        _ => open("the coefficients of |Q(iy)|² − |P(iy)|² have both signs"),
    }
}

fn floats<Q: Quantity>(polynomial: &[Q]) -> Vec<f64> {
    polynomial.iter().map(Q::to_f64).collect()
}

/// Where on the imaginary axis |R| first exceeds 1 clearly, on a coarse grid; in words.
fn witness(p: &[f64], q: &[f64]) -> String {
    let size = |f: &[f64], y: f64| {
        let part = |first: usize| (first..f.len()).step_by(2).rev().fold(0.0, |sum, k| f[k] - sum * y * y);
        part(0).hypot(y * part(1))
    };
    let mut grid = (-20..=30).map(|k| 10f64.powf(f64::from(k) / 10.0)).map(|y| (y, size(p, y) / size(q, y)));
    match grid.find(|(_, r)| *r > 1.0 + 1e-6) {
        Some((y, r)) => format!("|R(iy)| = {} at y = {}", digits(r, 9), digits(y, 3)),
        None => "|R(iy)| > 1 for some real y".into(),
    }
}

/// Exactly, from P and Q.
fn decide(p: &[RBig], q: &[RBig]) -> Stability {
    let (p, q) = (trimmed(p.to_vec()), trimmed(q.to_vec()));
    let common = greatest_common_divisor(p.clone(), q.clone());
    let (p, q) = (divided(p, &common).0, divided(q, &common).0);
    if !zeros_are_right(&q) {
        return Stability::Not("the stability function has a pole z with Re z ≤ 0".into());
    }
    if is_nowhere_negative(&trimmed(excess(&p, &q))) {
        Stability::AStable
    } else {
        Stability::Not(witness(&floats(&p), &floats(&q)))
    }
}

// Polynomials over the rationals, by increasing powers, without zeros at the end; the zero polynomial is empty.

fn trimmed(mut f: Vec<RBig>) -> Vec<RBig> {
    while f.pop_if(|x| x.is_zero()).is_some() {}
    f
}

/// Quotient and remainder; the divisor is not zero.
fn divided(mut f: Vec<RBig>, by: &[RBig]) -> (Vec<RBig>, Vec<RBig>) {
    let Some(lead) = by.last() else { return (Vec::new(), f) };
    let mut quotient = vec![RBig::ZERO; (f.len() + 1).saturating_sub(by.len())];
    while f.len() >= by.len() {
        let shift = f.len() - by.len();
        let factor = f[f.len() - 1].clone() / lead;
        by.iter().enumerate().for_each(|(k, x)| f[shift + k] -= x * &factor);
        quotient[shift] = factor;
        f = trimmed(f);
    }
    (quotient, f)
}

/// With leading coefficient 1.
fn greatest_common_divisor(mut f: Vec<RBig>, mut g: Vec<RBig>) -> Vec<RBig> {
    while !g.is_empty() {
        let rest = divided(f, &g).1;
        (f, g) = (g, rest);
    }
    if let Some(lead) = f.last().cloned() {
        f.iter_mut().for_each(|x| *x /= &lead);
    }
    f
}

fn derivative(f: &[RBig]) -> Vec<RBig> {
    f.iter().enumerate().skip(1).map(|(k, x)| x * RBig::from(k)).collect()
}

/// Whether all zeros of q have positive real parts: Routh's array of q(−z).
fn zeros_are_right(q: &[RBig]) -> bool {
    let mirrored = |k: usize| if k.is_multiple_of(2) { q[k].clone() } else { -q[k].clone() };
    let row = |first: usize| (first..q.len()).step_by(2).map(|k| mirrored(q.len() - 1 - k)).collect::<Vec<_>>();
    let (mut above, mut row) = (row(0), row(1));
    let Some(lead) = above.first().cloned() else { return false };
    for _ in 1..q.len() {
        let Some(first) = row.first().cloned() else { return false };
        if first.is_zero() || (first > RBig::ZERO) != (lead > RBig::ZERO) {
            return false;
        }
        let factor = &above[0] / &first;
        let below = |k: usize| &above[k] - &factor * row.get(k).unwrap_or(&RBig::ZERO);
        let next = (1..above.len()).map(below).collect();
        (above, row) = (row, next);
    }
    true
}

/// Whether f(w) ≥ 0 for all w ≥ 0: positive just right of 0, and no zero of odd multiplicity beyond.
fn is_nowhere_negative(f: &[RBig]) -> bool {
    let Some(first) = f.iter().position(|x| !x.is_zero()) else { return true };
    // A zero of multiplicity m is one of f, of the divisor that f and f' have in common, and so on, m times: with alternating signs odd m
    // count.
    let (mut f, mut counts) = (f[first..].to_vec(), [0; 2]);
    let positive = f[0] > RBig::ZERO;
    for level in 0.. {
        if f.len() < 2 {
            break;
        }
        counts[level % 2] += zeros_beyond(&f);
        let slope = derivative(&f);
        f = greatest_common_divisor(f, slope);
    }
    positive && counts[0] == counts[1]
}

/// The number of different zeros in (0, ∞) of a polynomial that is not 0 at 0 (Sturm 1829).
fn zeros_beyond(f: &[RBig]) -> usize {
    let mut chain = vec![f.to_vec(), derivative(f)];
    while let [.., f, g] = &chain[..]
        && !g.is_empty()
    {
        let rest = divided(f.clone(), g).1.into_iter().map(|x| -x).collect();
        chain.push(rest);
    }
    let changes = |at: &dyn Fn(&Vec<RBig>) -> Option<RBig>| {
        let signs: Vec<bool> = chain.iter().filter_map(at).filter(|x| !x.is_zero()).map(|x| x > RBig::ZERO).collect();
        signs.windows(2).filter(|pair| pair[0] != pair[1]).count()
    };
    changes(&|f| f.first().cloned()).saturating_sub(changes(&|f| f.last().cloned()))
}
