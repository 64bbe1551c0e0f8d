//! The simplifying assumptions B(p), C(q) and D(r) of Butcher 1964, with the first equation that fails.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/tableau/assumptions.md"))]
//!
//! Source: Hairer, Nørsett and Wanner, *Solving Ordinary Differential Equations I*, section II.7.

use super::quantity::{Coefficients, Quantity, decimal};
use std::fmt;

/// One of the three.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum AssumptionKind {
    /// The quadrature formula (b, c) has order p.
    B,
    /// The stages have order q.
    C,
    /// The adjoint of C.
    D,
}

/// How far an assumption holds.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Assumption {
    /// Which.
    pub kind: AssumptionKind,
    /// The largest k up to which it holds, checked to 2s + 1.
    pub holds: usize,
    /// The first equation that fails; `None` if none does up to k = 2s + 1.
    pub fails: Option<Failure>,
}

/// An equation of an assumption that does not hold.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Failure {
    /// Which assumption.
    pub kind: AssumptionKind,
    /// The k of the equation.
    pub k: usize,
    /// The row i of C or the column j of D, from 1.
    pub index: Option<usize>,
    /// The left side, a fraction where that is exact and short.
    pub left: String,
    /// The right side.
    pub right: String,
    /// Left minus right.
    pub defect: f64,
}

/// All three.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Assumptions {
    /// B(p).
    pub b: Assumption,
    /// C(q).
    pub c: Assumption,
    /// D(r).
    pub d: Assumption,
}

impl Assumptions {
    /// The largest p, q and r for which the coefficients fulfil B(p), C(q) and D(r), each up to 2s + 1.
    pub fn of<Q: Quantity>(coefficients: &Coefficients<Q>) -> Self {
        let checker = Checker::new(coefficients, 2 * coefficients.stages() + 1);
        Self {
            b: checker.check(AssumptionKind::B),
            c: checker.check(AssumptionKind::C),
            d: checker.check(AssumptionKind::D),
        }
    }
}

/// Σ_ij b_i c_i^k a_ij c_j^k − 1/(2 (k + 1)²), the one condition of order 2k + 2 that B(2k + 2), C(k) and D(k) leave open.
pub(super) fn middle<Q: Quantity>(coefficients: &Coefficients<Q>, k: usize) -> Q {
    let Coefficients { a, b, .. } = coefficients;
    let checker = Checker::new(coefficients, k);
    let (power, s) = (&checker.powers[k], b.len());
    let row = |i: usize| (0..s).fold(Q::fraction(0, 1), |sum, j| sum.plus(&a[i][j].times(&power[j])));
    let sum = (0..s).fold(Q::fraction(0, 1), |sum, i| sum.plus(&b[i].times(&power[i]).times(&row(i))));
    sum.minus(&Q::fraction(1, 2 * ((k + 1) * (k + 1)) as i64))
}

struct Checker<'t, Q> {
    coefficients: &'t Coefficients<Q>,
    /// c_i^k, at k and i.
    powers: Vec<Vec<Q>>,
}

impl<'t, Q: Quantity> Checker<'t, Q> {
    /// With the powers of c up to `highest`.
    fn new(coefficients: &'t Coefficients<Q>, highest: usize) -> Self {
        let s = coefficients.stages();
        let mut powers = vec![vec![Q::fraction(1, 1); s]];
        for k in 1..=highest {
            powers.push((0..s).map(|i| powers[k - 1][i].times(&coefficients.c[i])).collect());
        }
        Self { coefficients, powers }
    }

    fn check(&self, kind: AssumptionKind) -> Assumption {
        let s = self.coefficients.stages();
        for k in 1..=2 * s + 1 {
            let indices = if kind == AssumptionKind::B { 1 } else { s };
            if let Some(failure) = (0..indices).find_map(|index| self.failure(kind, k, index)) {
                return Assumption { kind, holds: k - 1, fails: Some(failure) };
            }
        }
        Assumption { kind, holds: 2 * s + 1, fails: None }
    }

    fn failure(&self, kind: AssumptionKind, k: usize, index: usize) -> Option<Failure> {
        let (left, right) = self.sides(kind, k, index);
        let defect = left.minus(&right);
        let s = self.coefficients.stages();
        (!defect.vanishes(8 * (k + 1) * (s + 2))).then(|| Failure {
            kind,
            k,
            index: (kind != AssumptionKind::B).then_some(index + 1),
            left: left.show(),
            right: right.show(),
            defect: defect.to_f64(),
        })
    }

    fn sides(&self, kind: AssumptionKind, k: usize, index: usize) -> (Q, Q) {
        let Coefficients { a, b, .. } = self.coefficients;
        let sum = |term: &dyn Fn(usize) -> Q| (0..b.len()).fold(Q::fraction(0, 1), |sum, i| sum.plus(&term(i)));
        let (one, over_k) = (Q::fraction(1, 1), Q::fraction(1, k as i64));
        let (before, power) = (&self.powers[k - 1], &self.powers[k]);
        match kind {
            AssumptionKind::B => (sum(&|i| b[i].times(&before[i])), over_k),
            AssumptionKind::C => (sum(&|j| a[index][j].times(&before[j])), power[index].times(&over_k)),
            AssumptionKind::D => {
                let left = sum(&|i| b[i].times(&before[i]).times(&a[i][index]));
                (left, b[index].times(&one.minus(&power[index])).times(&over_k))
            }
        }
    }
}

impl fmt::Display for Assumption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}({})", self.kind, self.holds)
    }
}

impl fmt::Display for Failure {
    /// `D(1) fails at j = 2: Σ_i b_i a_i2 = 1/3, b_2 (1 − c_2) = 1/4 (off by 8.333e-2)`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Failure { kind, k, left, right, .. } = self;
        let at = self.index.unwrap_or(1);
        let power = |index: &str, k: usize| match k {
            0 => String::new(),
            1 => format!(" c_{index}"),
            _ => format!(" c_{index}^{k}"),
        };
        let over = if *k == 1 { String::new() } else { format!("/{k}") };
        let entry = |i: &str, j: &str| if at > 9 { format!("a_{i},{j}") } else { format!("a_{i}{j}") };
        let (before, label) = (k - 1, at.to_string());
        match kind {
            AssumptionKind::B => write!(f, "B({k}) fails: Σ_i b_i{} = {left}, not {right}", power("i", before))?,
            AssumptionKind::C => {
                let (entry, right_side) = (entry(&label, "j"), power(&label, *k));
                write!(f, "C({k}) fails at i = {at}: Σ_j {entry}{} = {left}, ", power("j", before))?;
                write!(f, "{}{over} = {right}", right_side.trim_start())?;
            }
            AssumptionKind::D => {
                let entry = entry("i", &label);
                write!(f, "D({k}) fails at j = {at}: Σ_i b_i{} {entry} = {left}, ", power("i", before))?;
                write!(f, "b_{at} (1 −{}){over} = {right}", power(&label, *k))?;
            }
        }
        write!(f, " (off by {})", decimal(self.defect))
    }
}
