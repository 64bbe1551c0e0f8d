//! Rounding or error? The same case at two precisions.
//!
//! An identity is evaluated in `f64` (u = 2⁻⁵³) and in double-double (u ≈ 2⁻¹⁰⁴). Its defects, in units of u, are the
//! amplification of rounding by the case, a64 and a32; a case that is badly conditioned amplifies both alike. The
//! identity holds when each is below its floor, what the operation count alone allows, or at most [`AGREEMENT`] times
//! the other, both in units of their floors. The other one in 32 digits is a sample of what rounding does there: where that in `f64` is above
//! the bound, the largest of [`SAMPLES`] more, at inputs nearby, stands for it if it is larger. A defect that does not shrink with u is an
//! error: if it is ε in both scalars then a32 / a64 = 2⁵¹. An error in one scalar only (a series cut too early, a switch at the wrong place) shows as well.
//!
//! An unstable algorithm amplifies both alike too, on cases that are well conditioned. So a defect in `f64` above the floor has a
//! ceiling besides: [`CEILING`] (1 + κ) times the floor, where κ is what changes of the inputs by one unit of round-off of `f64` make
//! of the defect, in 32 digits: of the numbers of the case, and of what its retraction is given and gives
//! ([`ROUNDED`](super::planted::retraction::ROUNDED)).

use super::probe::{Probe, stream};
use super::source::Source;
use crate::harness::evidence::{self, Evidence};
use crate::harness::{Verdict, guarded};
use crate::laws::unbuilt;
use crate::scalar::{Dd, Number, Real, Scalar};
use crate::system::CaseError;
use crate::system::case::{Case, Inertia, Motion};
use std::fmt::Debug;

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

    /// The defect in units of u, if there is one.
    pub(super) fn amplification(&self) -> Option<f64> {
        match self {
            Self::Defect { amplification, .. } => Some(*amplification),
            _ => None,
        }
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

/// What an evaluation gave, or why there was none.
pub(super) type Evaluated = Result<Measured, CaseError>;

/// How often the inputs are changed: each change is a sample of what rounding may do.
pub(super) const SAMPLES: u32 = 3;

/// How far a defect in `f64` may exceed what the floor and changes of the inputs explain: rounding of the operations between them adds
/// to that of the inputs, and few samples do not show the worst. The worst of correct code was 2.3, of the case that is kept for
/// `free-coadjoint-orbit`.
pub const CEILING: f64 = 16.0;

/// An identity on a case, to be evaluated.
pub(super) struct Evaluations<'a> {
    /// In `f64`.
    pub double: &'a dyn Fn() -> Evaluated,
    /// In 32 digits.
    pub quad: &'a dyn Fn() -> Evaluated,
    /// In 32 digits on a case nearby, what is planted and all, by the number of the sample.
    pub nearby: &'a dyn Fn(u32) -> Evaluated,
    /// The same with what the retraction is given and gives changed too.
    pub rounded: &'a dyn Fn(u32) -> Evaluated,
}

/// Changes a number by a unit of round-off of `f64`, up or down; 0 stays.
pub(super) fn nudge(number: &mut Number, probe: &mut Probe) {
    let up = probe.next() & 1 == 0;
    if let Ok(value) = number.eval::<f64>()
        && value != 0.0
    {
        *number = Number::from(if up { value.next_up() } else { value.next_down() });
    }
}

/// The case with its numbers changed by at most a unit of round-off of `f64`: μ or η, h, the inertia and the basis. Those of l and f keep
/// what makes them special (a metric that is the inertia, a coefficient that is 1).
pub(super) fn moved(case: &Case, sample: u32) -> Case {
    let mut probe = Probe::new(&sample, stream::ROUNDING);
    let mut move_one = |number: &mut Number| nudge(number, &mut probe);
    let mut case = case.clone();
    match &mut case.start.motion {
        Motion::Velocity(list) | Motion::Momentum(list) => list.iter_mut().for_each(&mut move_one),
    }
    move_one(&mut case.step);
    match &mut case.lagrangian.inertia {
        Inertia::Diagonal(list) => list.iter_mut().for_each(&mut move_one),
        // It stays symmetric.
        Inertia::Full(rows) => {
            for a in 0..rows.len() {
                if let Some(number) = rows.get_mut(a).and_then(|row| row.get_mut(a)) {
                    move_one(number);
                }
            }
        }
    }
    case.algebra.basis.iter_mut().flatten().flatten().for_each(move_one);
    case
}

impl Evaluations<'_> {
    /// The verdict: in `f64` alone where 32 digits are not chosen and the defect does not ask for them; else by both, or (`apart`) the
    /// graver of those in each precision by itself, for measurements that are not in units of round-off.
    pub fn judged(&self, chosen: bool, apart: bool) -> Verdict {
        let double = (self.double)();
        match (chosen || is_above(&double), apart) {
            (false, _) => by_itself(self, double),
            (true, false) => beside(self, double),
            (true, true) => only_in(16, double).and(only_in(32, (self.quad)())),
        }
    }
}

/// The verdict from an evaluation in `f64` and from those in 32 digits.
fn beside(evaluations: &Evaluations<'_>, double: Evaluated) -> Verdict {
    match (double, (evaluations.quad)()) {
        (Ok(double), Ok(quad)) => {
            let nearby = |sample| (evaluations.nearby)(sample).ok()?.amplification();
            compare_below(double, quad, &nearby, &|| amplified(evaluations))
        }
        (Err(e), _) | (_, Err(e)) => unbuilt(&e),
    }
}

/// What changes of the inputs make of the defect, in units of u of `f64`; `None` where no evaluation gave a defect.
fn amplified(evaluations: &Evaluations<'_>) -> Option<f64> {
    let units = Dd::unit_roundoff().to_f64() / f64::unit_roundoff();
    let sample = |sample: u32| match (evaluations.rounded)(sample) {
        Ok(Measured::Defect { amplification, .. }) => Some(amplification * units),
        _ => None,
    };
    (0..SAMPLES).filter_map(sample).reduce(f64::max)
}

/// The verdict from an identity evaluated in `f64` and in 32 digits.
pub(super) fn compare(double: Measured, quad: Measured) -> Verdict {
    compare_below(double, quad, &|_| None, &|| None)
}

/// The same with more samples in 32 digits, at inputs nearby.
pub(super) fn compare_near(double: Measured, quad: Measured, nearby: impl Fn(u32) -> Measured) -> Verdict {
    compare_below(double, quad, &|sample| nearby(sample).amplification(), &|| None)
}

/// The same with a ceiling for the defect in `f64` from `amplified`, what changes of the inputs make of it; it is asked for above the
/// floor alone.
fn compare_below(
    double: Measured,
    quad: Measured,
    nearby: &dyn Fn(u32) -> Option<f64>,
    amplified: &dyn Fn() -> Option<f64>,
) -> Verdict {
    use Measured::{Broken, Defect, Inconclusive, NotApplicable};
    match (double, quad) {
        (Broken(why), _) => Verdict::broken(format!("f64: {why}")),
        (_, Broken(why)) => Verdict::broken(format!("dd: {why}")),
        (NotApplicable(why), _) | (_, NotApplicable(why)) => Verdict::not_applicable(why),
        (Inconclusive(why), _) | (_, Inconclusive(why)) => Verdict::inconclusive(why),
        (
            Defect { amplification: a64, floor, witness: w64 },
            Defect { amplification: a32, floor: floor32, witness: w32 },
        ) => {
            // Where the two count different operations, as differences over different intervals do, so do their defects.
            let counted = [floor, floor32].iter().all(|f| *f > 0.0 && f.is_finite());
            let more = if counted { floor32 / floor } else { 1.0 };
            let (mut b64, b32) = (floor.max(AGREEMENT * a32 / more), floor32.max(AGREEMENT * a64 * more));
            // One sample in 32 digits may be a lucky one: others stand for it, of the same identity at inputs nearby. One that is larger by
            // more than samples differ is no rounding: the identity does not hold there.
            if a64 > b64 {
                let likely = |nearby: &f64| *nearby <= AGREEMENT * a32;
                let most = (0..SAMPLES).filter_map(nearby).filter(likely).fold(a32, f64::max);
                b64 = floor.max(AGREEMENT * most / more);
            }
            let mut excused = false;
            if a64 > floor
                && a64 <= b64
                && let Some(amplified) = amplified()
            {
                let ceiling = CEILING * (floor + amplified);
                excused = a64 > ceiling;
                b64 = b64.min(ceiling);
            }
            evidence::note_all(|| {
                [(16, a64, b64, floor, w64.clone()), (32, a32, b32, floor32, w32.clone())].map(
                    |(digits, defect, bound, floor, witness)| {
                        noted(digits, defect, [bound, AGREEMENT * floor], witness)
                    },
                )
            });
            let double = Verdict::judge(a64, b64, || {
                let why = if excused { UNSTABLE } else { ONE_SCALAR };
                format!("f64: {a64:.3e} units of round-off (the other scalar: {a32:.3e}): {why}; {w64}")
            });
            let quad = Verdict::judge(a32, b32, || {
                format!("dd: {a32:.3e} units of round-off (the other scalar: {a64:.3e}){}; {w32}", error(a32))
            });
            double.and(quad)
        }
    }
}

/// Why a defect in `f64` is above what changes of the inputs explain.
const UNSTABLE: &str = "digits are lost that the problem does not lose, in both scalars: an unstable algorithm, or a series that is \
                        switched to a closed form at the wrong place";

/// Why a defect is in `f64` alone.
const ONE_SCALAR: &str = "digits are lost in f64 alone: a series or a tolerance that is not of this precision";

/// What a defect in 32 digits is that is not rounding.
fn error(a32: f64) -> String {
    let size = a32 * Dd::unit_roundoff().to_f64();
    match size < f64::unit_roundoff() {
        // No more than rounding of f64.
        true => format!(
            ": digits are lost in 32 digits alone, from {size:.0e} on: a series or a tolerance for f64, not for this precision"
        ),
        false => format!(
            ": an error of {size:.0e} that more digits do not make smaller: a wrong formula, or equations that are solved to a tolerance \
             which is not of this precision"
        ),
    }
}

/// One in `DRAWN` cases is judged in 32 digits, whatever it costs.
pub(super) const DRAWN: i32 = 10;

/// In which cases a law is judged in 32 digits, where a step in them costs too much for a law that runs on every case: those whose
/// number of unknowns s N is at most `most`, and one in [`DRAWN`] of the others, drawn by the case itself.
pub(super) fn in_quad<S: Source>(source: &S, most: usize) -> Result<bool, CaseError> {
    let case: &dyn Debug = source;
    let drawn = Probe::new(case, stream::DIGITS).integer(1, DRAWN) == 1;
    Ok(source.case().unknowns()? <= most || drawn)
}

/// What a defect in `f64` may be where it is judged by itself: [`USUAL`], or a share of the floor, since floors count the worst of each
/// operation. Above it 32 digits have to tell whether the case or the code loses so much.
fn tight(floor: f64) -> f64 {
    floor.min(USUAL.max(floor / SHARE))
}

/// The units of round-off that correct code has shown at its worst, on most laws.
pub(super) const USUAL: f64 = 8.0;

/// How many times what correct code may show the floor is.
pub(super) const SHARE: f64 = 512.0;

fn is_above(double: &Evaluated) -> bool {
    matches!(double, Ok(Measured::Defect { amplification, floor, .. }) if *amplification > tight(*floor))
}

/// The verdict from `double` alone, which is below [`tight`]. The evaluation in 32 digits is noted, too, where evidence is gathered:
/// not even a panic may change the verdict.
fn by_itself(evaluations: &Evaluations<'_>, double: Evaluated) -> Verdict {
    if let Ok(Measured::Defect { amplification: a64, .. }) = &double
        && evidence::is_gathered()
        && let Ok(Ok(Measured::Defect { amplification, floor, witness })) = guarded(|| (evaluations.quad)())
    {
        evidence::note(|| noted(32, amplification, [floor.max(AGREEMENT * a64), AGREEMENT * floor], witness));
    }
    match double {
        Ok(Measured::Defect { amplification, floor, witness }) => {
            alone_within(16, amplification, [tight(floor), AGREEMENT * floor], witness)
        }
        double => only_in(16, double),
    }
}

/// The verdict from an evaluation in one precision.
pub(super) fn only_in(digits: u32, measured: Evaluated) -> Verdict {
    match measured {
        Ok(measured) => alone(digits, measured),
        Err(e) => unbuilt(&e),
    }
}

/// The verdict from one precision: without another to compare with, the floor has the margin.
pub(super) fn alone(digits: u32, measured: Measured) -> Verdict {
    match measured {
        Measured::Broken(why) => Verdict::broken(why),
        Measured::NotApplicable(why) => Verdict::not_applicable(why),
        Measured::Inconclusive(why) => Verdict::inconclusive(why),
        Measured::Defect { amplification, floor, witness } => {
            alone_within(digits, amplification, [AGREEMENT * floor; 2], witness)
        }
    }
}

/// The verdict on a defect by the first bound; the second is that of one precision alone.
fn alone_within(digits: u32, defect: f64, bounds: [f64; 2], witness: String) -> Verdict {
    evidence::note(|| noted(digits, defect, bounds, witness.clone()));
    let scalar = if digits == 16 { "f64" } else { "dd" };
    Verdict::judge(defect, bounds[0], || format!("{scalar}: {defect:.3e} units of round-off; {witness}"))
}

fn noted(digits: u32, defect: f64, [bound, alone]: [f64; 2], witness: String) -> Evidence {
    Evidence::Defect { digits, defect, bound, alone, witness }
}

/// The evidence of a relative defect and bound, not in units of round-off, in the scalar of `digits` digits.
pub(super) fn of_relative<T: Real>(digits: u32, defect: f64, bound: f64, witness: String) -> Evidence {
    let unit = T::unit_roundoff().to_f64();
    noted(digits, defect / unit, [bound / unit; 2], witness)
}
