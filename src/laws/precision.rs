//! Rounding or error? The same case at two precisions.
//!
//! An identity is evaluated in `f64` (u = 2⁻⁵³) and in double-double (u ≈ 2⁻¹⁰⁴). Its defects, in units of u, are the
//! amplification of rounding by the case, a64 and a32; a case that is badly conditioned amplifies both alike. The
//! identity holds when each is at most [`AGREEMENT`] times the other, or below `floor`, what the operation count alone
//! allows. A defect that does not shrink with u is an error: if it is ε in both scalars then a32 / a64 = 2⁵¹. An error in
//! one scalar only (a series cut too early, a switch at the wrong place) shows as well.

use super::planted::retraction::Plant;
use super::source::Source;
use crate::harness::evidence::{self, Evidence, Wanted};
use crate::harness::{Fault, Verdict, guarded};
use crate::scalar::{Dd, Real};
use crate::system::{CaseError, Visitor};

/// How far the amplification of rounding may differ between the two precisions: both are samples of one distribution,
/// whose spread over the operation orders of a case has been about 30.
pub const AGREEMENT: f64 = 256.0;

/// What one evaluation of an identity gave.
#[derive(Clone, Debug, PartialEq)]
pub enum Measured {
    /// A defect.
    Defect {
        /// |lhs − rhs| relative to the size of the terms, in units of u.
        amplification: f64,
        /// What the count of operations allows, in units of u.
        floor: f64,
        /// The worst place.
        witness: String,
    },
    /// The identity says nothing about this case.
    NotApplicable(String),
    /// The case admits the identity, but it could not be evaluated.
    Inconclusive(String),
    /// An error where there must be none.
    Broken(String),
}

impl Measured {
    /// A defect |lhs − rhs| of terms of a size, at a place; a NaN counts as infinite.
    pub fn defect<T: Real>(defect: T, size: T, floor: f64, witness: impl FnOnce() -> String) -> Self {
        Self::Defect { amplification: amplification(defect, size), floor, witness: witness() }
    }

    /// A defect relative to what is allowed, which is not in units of round-off: judged alone, it may be [`AGREEMENT`] times that.
    pub fn within<T: Real>(defect: T, allowed: T, witness: impl FnOnce() -> String) -> Self {
        Self::defect(defect, allowed / T::unit_roundoff(), 1.0, witness)
    }

    /// No defect, of something that is exact or wrong.
    pub fn exact() -> Self {
        Self::Defect { amplification: 0.0, floor: 1.0, witness: String::new() }
    }

    /// The graver of two measurements on the same case; of two without a defect, the one with the larger floor, which is the bound for
    /// the other precision.
    pub fn and(self, other: Self) -> Self {
        let weight = |m: &Self| match m {
            Self::NotApplicable(_) => (0, 0.0, 0.0),
            Self::Defect { amplification, floor, .. } if *amplification == 0.0 => (1, 0.0, *floor),
            Self::Defect { amplification, floor, .. } => (1, amplification / floor, 0.0),
            Self::Inconclusive(_) => (2, 0.0, 0.0),
            Self::Broken(_) => (3, 0.0, 0.0),
        };
        if weight(&other) > weight(&self) { other } else { self }
    }
}

/// |lhs − rhs| relative to the size of the terms, in units of u.
#[inline(never)]
fn amplification<T: Real>(defect: T, size: T) -> f64 {
    let amplification = if defect == T::zero() { 0.0 } else { (defect / size / T::unit_roundoff()).to_f64() };
    if amplification.is_nan() { f64::INFINITY } else { amplification }
}

/// The verdict from the two evaluations of `visitor` on `case`, with the fault planted in its retraction if it is one of
/// [`retraction::ALL`](super::planted::retraction::ALL).
pub fn settle<S: Source, V>(case: &S, fault: Option<&Fault>, visitor: V) -> Verdict
where
    V: Visitor<f64, Output = Measured> + Visitor<Dd, Output = Measured> + Clone,
{
    let double = case.visit::<f64, _>(&Plant(fault), visitor.clone());
    both(double, || case.visit::<Dd, _>(&Plant(fault), visitor))
}

fn both(double: Result<Measured, CaseError>, quad: impl FnOnce() -> Result<Measured, CaseError>) -> Verdict {
    match evidence::wanted() {
        Wanted::Only(16) => return only(double),
        Wanted::Only(32) => return only_in(32, quad()),
        _ => {}
    }
    match (double, quad()) {
        (Ok(double), Ok(quad)) => compare(double, quad),
        (Err(e), _) | (_, Err(e)) => Verdict::broken(format!("a generated case cannot be built: {e}")),
    }
}

/// The verdict from an identity evaluated in `f64` and in 32 digits.
pub(super) fn compare(double: Measured, quad: Measured) -> Verdict {
    use Measured::{Broken, Defect, Inconclusive, NotApplicable};
    match (double, quad) {
        (Broken(why), _) => Verdict::broken(format!("f64: {why}")),
        (_, Broken(why)) => Verdict::broken(format!("dd: {why}")),
        (NotApplicable(why), _) | (_, NotApplicable(why)) => Verdict::not_applicable(why),
        (Inconclusive(why), _) | (_, Inconclusive(why)) => Verdict::inconclusive(why),
        (Defect { amplification: a64, floor, witness: w64 }, Defect { amplification: a32, floor: _, witness: w32 }) => {
            evidence::note_all(|| {
                [(16, a64, a32, w64.clone()), (32, a32, a64, w32.clone())]
                    .map(|(digits, mine, other, witness)| noted(digits, mine, floor.max(AGREEMENT * other), witness))
            });
            let judge = |mine: f64, other: f64, scalar: &str, witness: String| {
                Verdict::judge(mine, floor.max(AGREEMENT * other), || {
                    format!("{scalar}: {mine:.3e} units of round-off (the other scalar: {other:.3e}); {witness}")
                })
            };
            judge(a64, a32, "f64", w64).and(judge(a32, a64, "dd", w32))
        }
    }
}

/// The same for the dimensions of [`Source::visit_main`], which is half as much to compile.
pub fn settle_main<S: Source, V>(case: &S, fault: Option<&Fault>, visitor: V) -> Verdict
where
    V: Visitor<f64, Output = Measured> + Visitor<Dd, Output = Measured> + Clone,
{
    let double = case.visit_main::<f64, _>(&Plant(fault), visitor.clone());
    both(double, || case.visit_main::<Dd, _>(&Plant(fault), visitor))
}

/// The same, with the 32 digits left out when s N, the number of unknowns of a step, is above `most`: there a step in
/// 32 digits costs too much for a law that runs on every case, and the floor alone is the bound.
pub fn settle_small<S: Source, V>(case: &S, fault: Option<&Fault>, visitor: V, most: usize) -> Verdict
where
    V: Visitor<f64, Output = Measured> + Visitor<Dd, Output = Measured> + Clone,
{
    match case.case().unknowns() {
        Ok(unknowns) if unknowns <= most => settle(case, fault, visitor),
        Ok(_) => small(
            || case.visit::<f64, _>(&Plant(fault), visitor.clone()),
            || case.visit::<Dd, _>(&Plant(fault), visitor.clone()),
        ),
        Err(e) => Verdict::broken(format!("a generated case cannot be built: {e}")),
    }
}

/// [`settle_small`] for the dimensions of [`Source::visit_main`].
pub fn settle_main_small<S: Source, V>(case: &S, fault: Option<&Fault>, visitor: V, most: usize) -> Verdict
where
    V: Visitor<f64, Output = Measured> + Visitor<Dd, Output = Measured> + Clone,
{
    match case.case().unknowns() {
        Ok(unknowns) if unknowns <= most => settle_main(case, fault, visitor),
        Ok(_) => small(
            || case.visit_main::<f64, _>(&Plant(fault), visitor.clone()),
            || case.visit_main::<Dd, _>(&Plant(fault), visitor.clone()),
        ),
        Err(e) => Verdict::broken(format!("a generated case cannot be built: {e}")),
    }
}

/// The graver of the verdicts in each precision by itself, for measurements that are not in units of round-off; in 32 digits as in
/// [`settle_main_small`].
pub fn each_main_small<S: Source, V>(case: &S, fault: Option<&Fault>, visitor: V, most: usize) -> Verdict
where
    V: Visitor<f64, Output = Measured> + Visitor<Dd, Output = Measured> + Clone,
{
    let double = || case.visit_main::<f64, _>(&Plant(fault), visitor.clone());
    let quad = || case.visit_main::<Dd, _>(&Plant(fault), visitor.clone());
    match (case.case().unknowns(), evidence::wanted()) {
        (Err(e), _) => Verdict::broken(format!("a generated case cannot be built: {e}")),
        (Ok(_), Wanted::Only(32)) => only_in(32, quad()),
        (Ok(unknowns), wanted) if unknowns <= most && wanted != Wanted::Only(16) => {
            only(double()).and(only_in(32, quad()))
        }
        (Ok(_), _) => small(double, quad),
    }
}

/// The verdict from `double` alone; the 32 digits are evaluated when they are asked for, and judge when they alone are.
fn small(
    double: impl FnOnce() -> Result<Measured, CaseError>,
    quad: impl FnOnce() -> Result<Measured, CaseError>,
) -> Verdict {
    if evidence::wanted() == Wanted::Only(32) {
        return only_in(32, quad());
    }
    let double = double();
    let beside = match &double {
        Ok(Measured::Defect { amplification, .. }) => Some(*amplification),
        _ => None,
    };
    let verdict = only(double);
    // Beside the verdict: not even a panic may change it.
    if evidence::wanted() == Wanted::AllDigits
        && let (Some(a64), Ok(Ok(Measured::Defect { amplification, floor, witness }))) = (beside, guarded(quad))
    {
        evidence::note(|| noted(32, amplification, floor.max(AGREEMENT * a64), witness));
    }
    verdict
}

fn only(double: Result<Measured, CaseError>) -> Verdict {
    only_in(16, double)
}

fn only_in(digits: u32, measured: Result<Measured, CaseError>) -> Verdict {
    match measured {
        Ok(measured) => alone(digits, measured),
        Err(e) => Verdict::broken(format!("a generated case cannot be built: {e}")),
    }
}

/// The verdict from one precision: without another to compare with, the floor has the margin.
pub(super) fn alone(digits: u32, measured: Measured) -> Verdict {
    match measured {
        Measured::Broken(why) => Verdict::broken(why),
        Measured::NotApplicable(why) => Verdict::not_applicable(why),
        Measured::Inconclusive(why) => Verdict::inconclusive(why),
        Measured::Defect { amplification, floor, witness } => {
            evidence::note(|| noted(digits, amplification, AGREEMENT * floor, witness.clone()));
            let scalar = if digits == 16 { "f64" } else { "dd" };
            Verdict::judge(amplification, AGREEMENT * floor, || {
                format!("{scalar}: {amplification:.3e} units of round-off; {witness}")
            })
        }
    }
}

fn noted(digits: u32, defect: f64, bound: f64, witness: String) -> Evidence {
    Evidence::Defect { digits, defect, bound, witness }
}

/// The evidence of a defect and a bound that are relative, not in units of round-off, in the scalar of so many digits.
pub(super) fn of_relative<T: Real>(digits: u32, defect: f64, bound: f64, witness: String) -> Evidence {
    let unit = T::unit_roundoff().to_f64();
    noted(digits, defect / unit, bound / unit, witness)
}
