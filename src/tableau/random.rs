//! Strategies that generate tableaux as plain values with small exact entries, valid by construction.
//!
//! Every tableau has Σb = 1 exactly, |b_j| ≥ 1/6, |a_ij| and |b_j| at most 5/2 (mostly 1), so that the implicit equations of a
//! moderate step can be solved; entries are fractions of small integers, the same in every scalar.

use super::{Classic, Description, Family};
use crate::scalar::Number;
use proptest::prelude::*;
use proptest::sample::select;
use proptest::strategy::Union;

/// What to generate.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum TableauKind {
    /// A member of a family (few stages more often than many) or a classical tableau.
    Named,
    /// Collocation at 1 to 3 distinct rational nodes: classical order at least the number of stages.
    Collocation,
    /// Full a with Σbc = ½: classical order at least 2.
    OrderTwo,
    /// Full a, weights of both signs: order 1.
    Full,
    /// Strictly lower triangular a.
    Explicit,
    /// Lower triangular a.
    DiagonallyImplicit,
}

impl TableauKind {
    /// All kinds.
    pub const ALL: [TableauKind; 6] = [
        TableauKind::Named,
        TableauKind::Collocation,
        TableauKind::OrderTwo,
        TableauKind::Full,
        TableauKind::Explicit,
        TableauKind::DiagonallyImplicit,
    ];
}

/// Any tableau: named ones four times as often as each other kind. Shrinks to `gauss-1`.
pub fn any() -> BoxedStrategy<Description> {
    Union::new_weighted(
        TableauKind::ALL.map(|kind| (if kind == TableauKind::Named { 4 } else { 1 }, of_kind(kind))).to_vec(),
    )
    .boxed()
}

/// Any tableau of one kind, with up to 5 stages if it is named, 4 if it is triangular, else 3.
pub fn of_kind(kind: TableauKind) -> BoxedStrategy<Description> {
    match kind {
        TableauKind::Named => named(),
        TableauKind::Collocation => select(collocations()).boxed(),
        TableauKind::OrderTwo => raw(2..=3).prop_map(|raw| raw.order_two()).boxed(),
        TableauKind::Full => raw(1..=3).prop_map(|raw| raw.keep(|_, _| true)).boxed(),
        TableauKind::Explicit => raw(1..=4).prop_map(|raw| raw.keep(|i, j| j < i)).boxed(),
        TableauKind::DiagonallyImplicit => raw(1..=4).prop_map(|raw| raw.keep(|i, j| j <= i)).boxed(),
    }
}

/// Families, with weights 8, 4, 2, 1 as the number of stages grows, and the classical tableaux.
fn named() -> BoxedStrategy<Description> {
    let mut choices = Vec::new();
    for (rank, weight) in [8, 4, 2, 1].into_iter().enumerate() {
        for family in Family::DRAWN {
            // Gauss is the reference method: twice as often, and with one more number of stages.
            let (stages, weight) =
                (family.least_stages() + rank, if family == Family::Gauss { 2 * weight } else { weight });
            choices.push((weight, Just(Description::Family(family, stages)).boxed()));
        }
    }
    choices.push((1, Just(Description::Family(Family::Gauss, 5)).boxed()));
    choices.extend(Classic::DRAWN.map(|classic| (4, Just(Description::Classic(classic)).boxed())));
    Union::new_weighted(choices).boxed()
}

/// p/q with q > 0, in lowest terms; the entries stay so small that 64 bits never overflow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Fraction {
    p: i64,
    q: i64,
}

impl Fraction {
    const ZERO: Fraction = Fraction { p: 0, q: 1 };
    const ONE: Fraction = Fraction { p: 1, q: 1 };

    fn new(p: i64, q: i64) -> Self {
        let (mut g, mut r) = (p.abs(), q.abs());
        while r != 0 {
            (g, r) = (r, g % r);
        }
        let g = g.max(1) * q.signum();
        Self { p: p / g, q: q / g }
    }

    fn plus(self, other: Self) -> Self {
        Self::new(self.p * other.q + other.p * self.q, self.q * other.q)
    }

    fn minus(self, other: Self) -> Self {
        self.plus(Self { p: -other.p, ..other })
    }

    fn times(self, other: Self) -> Self {
        Self::new(self.p * other.p, self.q * other.q)
    }

    fn over(self, other: Self) -> Self {
        Self::new(self.p * other.q, self.q * other.p)
    }

    fn size(self) -> f64 {
        (self.p as f64 / self.q as f64).abs()
    }

    fn number(self) -> Number {
        Number::ratio(self.p, self.q)
    }
}

fn describe(a: &[Vec<Fraction>], b: &[Fraction]) -> Description {
    let numbers = |row: &[Fraction]| row.iter().map(|x| x.number()).collect::<Vec<_>>();
    Description::entries(a.iter().map(|row| numbers(row)).collect(), numbers(b))
}

/// A full a and weights that sum to 1.
#[derive(Clone, Debug)]
struct Raw {
    a: Vec<Vec<Fraction>>,
    b: Vec<Fraction>,
}

impl Raw {
    /// a with the entries kept that `kept` says, the others 0.
    fn keep(mut self, kept: impl Fn(usize, usize) -> bool) -> Description {
        for (i, row) in self.a.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                if !kept(i, j) {
                    *x = Fraction::ZERO;
                }
            }
        }
        describe(&self.a, &self.b)
    }

    /// a halved, then shifted by the one constant ε that makes Σbc = ½: the shift adds s ε to every c_i, and Σb = 1.
    fn order_two(mut self) -> Description {
        self.a.iter_mut().flatten().for_each(|x| *x = x.times(Fraction::new(1, 2)));
        let mut moment = Fraction::ZERO;
        for (row, &b) in self.a.iter().zip(&self.b) {
            moment = moment.plus(b.times(row.iter().fold(Fraction::ZERO, |c, &x| c.plus(x))));
        }
        let shift = Fraction::new(1, 2).minus(moment).over(Fraction::new(self.b.len() as i64, 1));
        self.a.iter_mut().flatten().for_each(|x| *x = x.plus(shift));
        describe(&self.a, &self.b)
    }
}

/// a in quarters from −1 to 1; b in halves to sixths from −1 to 5/2, all but the last drawn, none 0.
fn raw(stages: std::ops::RangeInclusive<usize>) -> impl Strategy<Value = Raw> {
    (stages, 2i64..=6).prop_flat_map(|(s, q)| {
        let a = prop::collection::vec(prop::collection::vec(-4i64..=4, s), s);
        // The drawn weights lie so that the last, 1 minus their sum, is from −1 to 2 (5/2 for s = 4 and halves).
        let others = (s as i64 - 1).max(1);
        let (low, high) = ((q / others).max(1), (2 * q / others).clamp(1, q));
        let b = prop::collection::vec((1..=high, 1..=low, prop::bool::weighted(0.3)), s - 1);
        (a, b).prop_map(move |(a, b)| Raw {
            a: a.iter().map(|row| row.iter().map(|&x| Fraction::new(x, 4)).collect()).collect(),
            b: close(b.iter().map(|&(up, down, negative)| if negative { -down } else { up }).collect(), q),
        })
    })
}

/// The weights n_i/q and the one that closes the sum to 1; were it 0, the first is moved on by 1/q.
fn close(mut n: Vec<i64>, q: i64) -> Vec<Fraction> {
    if let (0, Some(first)) = (q - n.iter().sum::<i64>(), n.first().copied()) {
        n[0] = if first == -1 { -2 } else { first + 1 };
    }
    n.push(q - n.iter().sum::<i64>());
    n.into_iter().map(|n| Fraction::new(n, q)).collect()
}

/// Collocation at every set of at most 3 nodes in {0, 1/q, …, 1}, q ≤ 6, whose |b_j| are from 1/6 to 2 and whose |a_ij| are at
/// most 2, the simplest first.
fn collocations() -> Vec<Description> {
    let mut sets: Vec<Vec<Fraction>> = Vec::new();
    for q in 2..=6 {
        let node = |p: i64| Fraction::new(p, q);
        for x in 0..=q {
            sets.push(vec![node(x)]);
            for y in x + 1..=q {
                sets.push(vec![node(x), node(y)]);
                sets.extend((y + 1..=q).map(|z| vec![node(x), node(y), node(z)]));
            }
        }
    }
    let cost = |c: &Vec<Fraction>| (c.len(), c.iter().map(|x| x.q).max(), *c != [Fraction::new(1, 2)]);
    sets.sort_by_key(cost);
    let mut seen: Vec<Vec<Fraction>> = Vec::new();
    for set in sets {
        if !seen.contains(&set) {
            seen.push(set);
        }
    }
    seen.iter().filter_map(|c| collocation(c)).collect()
}

fn collocation(c: &[Fraction]) -> Option<Description> {
    let rows: Vec<Vec<Fraction>> = c.iter().map(|&to| (0..c.len()).map(|j| integral(c, j, to)).collect()).collect();
    let b: Vec<Fraction> = (0..c.len()).map(|j| integral(c, j, Fraction::ONE)).collect();
    let good =
        b.iter().all(|x| (1.0 / 6.0..=2.0).contains(&x.size())) && rows.iter().flatten().all(|x| x.size() <= 2.0);
    good.then(|| describe(&rows, &b))
}

/// ∫₀^to ℓ_j over the nodes c: the Lagrange polynomial multiplied out, then integrated term by term.
fn integral(c: &[Fraction], j: usize, to: Fraction) -> Fraction {
    let mut polynomial = vec![Fraction::ONE];
    for (k, &node) in c.iter().enumerate() {
        if k != j {
            let scale = c[j].minus(node);
            let mut next = vec![Fraction::ZERO; polynomial.len() + 1];
            for (power, &x) in polynomial.iter().enumerate() {
                next[power] = next[power].minus(x.times(node).over(scale));
                next[power + 1] = next[power + 1].plus(x.over(scale));
            }
            polynomial = next;
        }
    }
    let (mut sum, mut power) = (Fraction::ZERO, to);
    for (k, &x) in polynomial.iter().enumerate() {
        sum = sum.plus(x.times(power).over(Fraction::new(k as i64 + 1, 1)));
        power = power.times(to);
    }
    sum
}
