//! What a law is, and what it may answer.

use proptest::strategy::BoxedStrategy;
use serde::{Deserialize, Serialize};
use std::fmt;

/// The answer of a law on one case.
#[derive(Clone, Debug, PartialEq)]
pub enum Verdict {
    /// defect ≤ bound.
    Holds {
        /// What was measured, ≥ 0.
        defect: f64,
        /// What rounding (or the theory) allows.
        bound: f64,
    },
    /// defect > bound, or the defect is not a number.
    Broken {
        /// What was measured; infinite where nothing could be measured (a panic, a missing value).
        defect: f64,
        /// What rounding (or the theory) allows.
        bound: f64,
        /// Where it broke: values a person can read.
        witness: String,
    },
    /// The case admits the law, and the check could not decide.
    Inconclusive {
        /// The reason, without numbers of the case: reasons are counted.
        why: String,
    },
    /// The law says nothing about this case.
    NotApplicable {
        /// The reason, without numbers of the case: reasons are counted.
        why: String,
    },
}

impl Verdict {
    /// `Holds` when |defect| ≤ bound, else `Broken`.
    ///
    /// A NaN or infinite defect is broken. A zero bound asks for a defect of exactly zero. A bound that is NaN, infinite
    /// or negative cannot judge a finite defect: inconclusive.
    pub fn judge(defect: f64, bound: f64, witness: impl FnOnce() -> String) -> Self {
        let defect = defect.abs();
        if !defect.is_finite() {
            Self::Broken { defect, bound, witness: witness() }
        } else if !(bound.is_finite() && bound >= 0.0) {
            Self::Inconclusive { why: "the bound is not a finite number ≥ 0".into() }
        } else if defect <= bound {
            Self::Holds { defect, bound }
        } else {
            Self::Broken { defect, bound, witness: witness() }
        }
    }

    /// `Broken` where there is nothing to measure: a value is missing, a panic, an answer of the wrong kind.
    pub fn broken(witness: impl Into<String>) -> Self {
        Self::Broken { defect: f64::INFINITY, bound: 0.0, witness: witness.into() }
    }

    /// `Inconclusive`.
    pub fn inconclusive(why: impl Into<String>) -> Self {
        Self::Inconclusive { why: why.into() }
    }

    /// `NotApplicable`.
    pub fn not_applicable(why: impl Into<String>) -> Self {
        Self::NotApplicable { why: why.into() }
    }

    /// `holds`, `broken`, `inconclusive` or `not applicable`.
    pub fn word(&self) -> &'static str {
        match self {
            Self::Holds { .. } => "holds",
            Self::Broken { .. } => "broken",
            Self::Inconclusive { .. } => "inconclusive",
            Self::NotApplicable { .. } => "not applicable",
        }
    }

    /// Whether the law is broken on this case.
    pub fn is_broken(&self) -> bool {
        matches!(self, Self::Broken { .. })
    }

    /// Whether the law holds on this case.
    pub fn holds(&self) -> bool {
        matches!(self, Self::Holds { .. })
    }

    /// (defect, bound), where the case was judged.
    pub fn measured(&self) -> Option<(f64, f64)> {
        match *self {
            Self::Holds { defect, bound } | Self::Broken { defect, bound, .. } => Some((defect, bound)),
            _ => None,
        }
    }

    /// What explains it: the witness of a broken case, or why there is no verdict.
    pub fn why(&self) -> Option<&str> {
        match self {
            Self::Holds { .. } => None,
            Self::Broken { witness: why, .. } | Self::Inconclusive { why } | Self::NotApplicable { why } => Some(why),
        }
    }

    /// defect/bound, never NaN: 0/0 is 0, and ∞ stands for a NaN defect or bound.
    pub fn ratio(&self) -> Option<f64> {
        let (defect, bound) = self.measured()?;
        let ratio = if defect == 0.0 { 0.0 } else { defect / bound };
        Some(if ratio.is_nan() || bound.is_nan() { f64::INFINITY } else { ratio })
    }

    /// This verdict and another on the same case: the graver of the two, in the order broken, inconclusive, holds,
    /// not applicable; of two of a kind the larger ratio, else the first.
    pub fn and(self, other: Self) -> Self {
        let weight = |v: &Self| match v {
            Self::Broken { .. } => 3,
            Self::Inconclusive { .. } => 2,
            Self::Holds { .. } => 1,
            Self::NotApplicable { .. } => 0,
        };
        let (mine, theirs) = (weight(&self), weight(&other));
        if theirs > mine || (theirs == mine && other.ratio() > self.ratio()) { other } else { self }
    }
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Holds { defect, bound } => write!(f, "holds: defect {defect:.3e}, bound {bound:.3e}"),
            Self::Broken { defect, bound, witness } => {
                write!(f, "broken: defect {defect:.3e}, bound {bound:.3e}: {witness}")
            }
            Self::Inconclusive { why } => write!(f, "inconclusive: {why}"),
            Self::NotApplicable { why } => write!(f, "not applicable: {why}"),
        }
    }
}

/// A fault that a check can plant in the subject under test, to show that the law is able to fail.
///
/// It has a size ε in (0, 1]: the subject's value is right + ε (wrong − right), so that 1 is the fault as it is
/// described, and the smallest ε that a law still sees says how sharp the law is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Fault {
    /// A short name. Laws that know a fault of the same name plant the same fault.
    pub name: &'static str,
    /// What is wrong with the subject when it is planted.
    pub what: &'static str,
    /// On which cases it can be seen: algebras, forces, tableaux, ….
    pub visible_on: &'static str,
    /// ε, in (0, 1].
    #[serde(skip)]
    pub size: f64,
}

impl Fault {
    /// A fault of size 1.
    pub const fn new(name: &'static str, what: &'static str, visible_on: &'static str) -> Self {
        Self { name, what, visible_on, size: 1.0 }
    }

    /// The same fault, of another size.
    pub const fn with_size(self, size: f64) -> Self {
        Self { size, ..self }
    }

    /// The size of the fault called `name`, if it is the one that is planted; else 0.
    pub fn size_of(fault: Option<&Fault>, name: &str) -> f64 {
        fault.filter(|fault| fault.name == name).map_or(0.0, |fault| fault.size)
    }

    /// Its size, if it is the one that is planted; else 0.
    pub fn size_in(&self, planted: Option<&Fault>) -> f64 {
        Self::size_of(planted, self.name)
    }

    /// Whether the fault called `name` is the one that is planted.
    pub fn planted(fault: Option<&Fault>, name: &str) -> bool {
        fault.is_some_and(|fault| fault.name == name)
    }
}

/// How many cases of a campaign a law gets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Cost {
    /// Every one of the N cases.
    Cheap,
    /// max(32, N/4) cases: some ten milliseconds each, or more.
    Moderate,
    /// max(20, N/50) cases.
    Expensive,
    /// max(8, N/100) cases.
    Heavy,
}

impl Cost {
    /// The number of cases of a law of this cost, in a campaign of `cases` per cheap law.
    pub fn cases(self, cases: usize) -> usize {
        match self {
            Self::Cheap => cases,
            Self::Moderate => (cases / 4).max(32),
            Self::Expensive => (cases / 50).max(20),
            Self::Heavy => (cases / 100).max(8),
        }
    }
}

/// What a law says, whatever the subject: the same words where it is listed, on every supplier's subjects, and in records.
///
/// Laws of one statement on subjects of several suppliers have one such value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct About {
    /// A short unique name, in kebab case.
    #[serde(rename = "law")]
    pub name: &'static str,
    /// The formula.
    pub statement: &'static str,
    /// The theorem, definition or equation that it comes from: author, year, number.
    pub source: &'static str,
    /// What the subject is compared with, and why that is independent.
    pub oracle: &'static str,
    /// How the bound is derived.
    pub bound: &'static str,
    /// What a subject has to have; empty if nothing.
    pub needs: &'static str,
    /// The class that decides the number of cases.
    pub cost: Cost,
    /// What can be planted in the subject.
    pub faults: &'static [Fault],
}

/// A statement about cases of type `C` that can be checked on each.
///
/// A check is a function of the case and the fault alone: no clocks, no randomness, no state.
pub trait Law<C>: Send + Sync {
    /// What it says.
    fn about(&self) -> &About;

    /// Its short unique name.
    fn name(&self) -> &'static str {
        self.about().name
    }

    /// The faults that `check` knows how to plant.
    fn faults(&self) -> &'static [Fault] {
        self.about().faults
    }

    /// The strategy that draws cases, valid by construction.
    fn cases(&self) -> BoxedStrategy<C>;

    /// The verdict on one case. With `fault`, the same check with that fault planted in the subject.
    fn check(&self, case: &C, fault: Option<&Fault>) -> Verdict;

    /// Tells `visit` cases that are simpler than `case` and that [`Law::cases`] could have drawn, the boldest first, until it
    /// answers `true`: how a case is shrunk that was not drawn but read. None are known unless a law says otherwise.
    fn simpler(&self, _case: &C, _visit: &mut dyn FnMut(C) -> bool) {}

    /// The fault called `name`.
    fn fault(&self, name: &str) -> Option<&'static Fault> {
        self.faults().iter().find(|fault| fault.name == name)
    }
}
