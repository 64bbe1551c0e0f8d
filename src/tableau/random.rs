//! Strategies that generate tableaux as plain values with small exact entries, valid by construction.
//!
//! Every tableau has Σb = 1 exactly, |b_j| ≥ 1/6, |a_ij| and |b_j| at most 5/2 (mostly 1), so that the implicit equations of a
//! moderate step can be solved; entries are fractions of small integers, the same in every scalar.

use super::known::construct::{Raw, at_nodes};
use super::known::fraction::{Fraction, dot, sum};
use super::{Classic, Description, Family};
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
        TableauKind::OrderTwo => raw(2..=3).prop_map(order_two).boxed(),
        TableauKind::Full => raw(1..=3).prop_map(|raw| keep(raw, |_, _| true)).boxed(),
        TableauKind::Explicit => raw(1..=4).prop_map(|raw| keep(raw, |i, j| j < i)).boxed(),
        TableauKind::DiagonallyImplicit => raw(1..=4).prop_map(|raw| keep(raw, |i, j| j <= i)).boxed(),
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

/// The tableau with the entries of a kept that `kept` says, the others 0.
fn keep(mut raw: Raw, kept: impl Fn(usize, usize) -> bool) -> Description {
    for (i, row) in raw.a.iter_mut().enumerate() {
        for (j, x) in row.iter_mut().enumerate() {
            if !kept(i, j) {
                *x = Fraction::ZERO;
            }
        }
    }
    raw.description()
}

/// a halved, then shifted by the one constant ε that makes Σbc = ½: the shift adds s ε to every c_i, and Σb = 1.
fn order_two(mut raw: Raw) -> Description {
    let half = Fraction::new(1, 2);
    raw.a.iter_mut().flatten().for_each(|x| *x = *x * half);
    let c: Vec<Fraction> = raw.a.iter().map(|row| sum(row.iter().copied())).collect();
    let shift = (half - dot(&raw.b, &c)) / Fraction::new(raw.b.len() as i64, 1);
    raw.a.iter_mut().flatten().for_each(|x| *x = *x + shift);
    raw.description()
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
    let cost = |c: &Vec<Fraction>| (c.len(), c.iter().map(|x| x.denominator()).max(), *c != [Fraction::new(1, 2)]);
    sets.sort_by_key(cost);
    let mut seen: Vec<Vec<Fraction>> = Vec::new();
    for set in sets {
        if !seen.contains(&set) {
            seen.push(set);
        }
    }
    let good = |raw: &Raw| {
        let moderate = |x: &Fraction| (1.0 / 6.0..=2.0).contains(&x.size());
        raw.b.iter().all(moderate) && raw.a.iter().flatten().all(|x| x.size() <= 2.0)
    };
    seen.iter().filter_map(|c| at_nodes(c)).filter(good).map(|raw| raw.description()).collect()
}
