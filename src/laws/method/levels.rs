//! At which steps a method is asked, and what the errors there say about a claim.
//!
//! Where the levels begin is the theory's choice, not the method's: at the largest step h with h pace ≤ [`REACH`] at both
//! ends of a level ([`Theory::pace`](super::Theory::pace)), at most 2⁶ times the step of the system. A larger step is never
//! asked for. At a step larger than that of the system a method may refuse or diverge, and the level is left out.
//!
//! Slopes confirm a claim, but do not refute it. A method is below the order that it claims only if [`lower::share`] says
//! so: of errors with their signs, on two interlaced sequences of halved steps (in 32 digits, where there are levels enough,
//! on one), and from a second start as well.
//!
//! What is left: a right method is refused if the series of its errors does not settle within the levels at either start,
//! and in a way that grows against its own leading terms as the steps shrink. A wrong method is not refuted where the errors
//! of lower order are below the noise, or where there are fewer than six levels above it: that is inconclusive.
//!
//! [`lower::share`]: crate::harness::lower::share

use super::{Point, Precision, View, displaced};
use crate::harness::Verdict;
use crate::harness::convergence::{Estimate, TOLERANCE};
use crate::harness::lower::{Share, Signed, share};
use crate::integrators::StepError;
use crate::scalar::{Dd, Real, max_abs};
use crate::study::{Comparison, Findings, Line, Reading, Row};
use std::cmp::Ordering;

/// Why a level is left out.
pub(super) const DIVERGES: &str = "the method diverges with this step";

/// Steps of a level.
pub(super) const STEPS: usize = 2;

/// The largest step times the pace of the motion.
pub(super) const REACH: f64 = 1.0;

/// The largest relative error of a level, of those above a quarter of the largest step: beyond it no series tells anything.
const COARSE: f64 = 1e-2;

/// The first step is at most 2 to the power of this times that of the system.
const DOUBLINGS: i32 = 6;

/// The stages of the reference: order 16.
pub(super) const STAGES: usize = 8;

/// How often the first step is halved, where the reference does not converge.
const HALVINGS: usize = 8;

/// From how many other starts a claim is asked about that the first refutes.
const STARTS: usize = 3;

/// How often the step is halved.
fn halvings<T: Real>() -> i32 {
    if T::unit_roundoff() < T::exact(1e-20) { 20 } else { 16 }
}

/// Whether an error decides about the whole case, not about one level.
pub(super) fn is_final(error: &StepError) -> bool {
    matches!(error, StepError::Unsupported { .. } | StepError::NoAnswer { .. })
}

/// The difference of a quantity from what it must be.
pub(super) struct Gap<T> {
    /// Its components.
    pub error: Vec<T>,
    /// The size of what was compared.
    pub size: T,
    /// What rounding may do.
    pub noise: T,
    /// What the reference may be off.
    pub reference_error: T,
}

impl<T: Real> Gap<T> {
    fn relative(&self) -> f64 {
        let error = max_abs(&self.error);
        if error == T::zero() { 0.0 } else { (error / self.size).to_f64() }
    }

    /// Whether it is too large for a series to tell anything, or no number.
    fn is_coarse(&self) -> bool {
        self.relative().partial_cmp(&COARSE).is_none_or(Ordering::is_gt)
    }

    fn reading(&self) -> Reading {
        let reference_error = self.reference_error.to_f64();
        Reading { error: max_abs(&self.error).to_f64(), noise: self.noise.to_f64() + reference_error, reference_error }
    }

    fn signed(&self, h: f64) -> Signed {
        let noise = self.noise.to_f64() + self.reference_error.to_f64();
        Signed { h, error: self.error.iter().map(|x| x.to_f64()).collect(), noise }
    }
}

/// What is measured at a level.
pub(super) trait Measure<T: Real> {
    /// The names of the quantities.
    fn names(&self) -> Vec<String>;

    /// Whether the solution is needed, and its attitude.
    fn needs(&self) -> (bool, bool);

    /// The gaps after [`STEPS`] steps of size h, where the solution (if it is needed) is at `exact`, off by so much.
    ///
    /// # Errors
    /// Those of a step.
    fn gaps(&self, h: T, exact: Option<&(Point<Dd>, (Dd, Dd))>) -> Result<Vec<Gap<T>>, StepError>;
}

/// The errors of a method at a ladder of steps.
pub(super) struct Ladder {
    /// Of all levels.
    pub findings: Findings,
    /// Of halved steps alone, where there are others too.
    halves: Option<Findings>,
    signed: Vec<Vec<Signed>>,
    judged: usize,
}

/// What a ladder says about a claim that the order is at least so much.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Standing {
    /// It is confirmed.
    Holds(f64),
    /// It is refuted, by this quantity.
    Below { witness: String, share: f64, quantity: usize },
    /// Neither.
    Open(String),
}

/// An interval of orders; what is rounded to 0 has no sign.
fn interval(low: f64, high: f64) -> String {
    let [low, high] = [low, high].map(|x| format!("{x:.3}").replace("-0.000", "0.000"));
    format!("[{low}, {high}]")
}

/// h/(2^k) and 3h/(4 2^k).
fn sizes<T: Real>(first: T, count: i32, part: T) -> Vec<T> {
    (0..count).map(|k| first * part * T::exact(2f64.powi(-k))).collect()
}

/// The largest step to begin with, by the theory at the start; `None` where it has no pace.
pub(super) fn largest<T: Precision>(view: &View<'_, '_, T>) -> Option<T> {
    let pace = view.pace(&view.start().convert());
    let mut first = view.theory().step().abs() * T::exact(2f64.powi(DOUBLINGS));
    let mut halved = 0;
    // A pace that is no number is none to begin with.
    while (first.to_f64() * pace).partial_cmp(&REACH).is_none_or(Ordering::is_gt) {
        first *= T::half();
        halved += 1;
        if halved > 60 {
            return None;
        }
    }
    Some(first)
}

type Exact = (Point<Dd>, (Dd, Dd));

fn solutions<T: Precision>(
    view: &View<'_, '_, T>,
    sizes: &[T],
    (needed, attitude): (bool, bool),
) -> Result<Vec<Option<Exact>>, StepError> {
    if !needed {
        return Ok(vec![None; sizes.len()]);
    }
    let times: Vec<T> = sizes.iter().map(|h| *h * T::int(STEPS as i64)).collect();
    Ok(view.solution(&view.start(), &times, attitude)?.into_iter().map(Some).collect())
}

/// Level after level, until two in a row show nothing but noise; the sizes in between as well, unless `enough`.
///
/// # Errors
/// That the method does not apply or does not answer; those of the reference.
pub(super) fn descend<T: Precision>(
    view: &View<'_, '_, T>,
    measure: &impl Measure<T>,
    enough: impl Fn(&Ladder) -> bool,
) -> Result<Ladder, StepError> {
    let no_pace = || StepError::Refused { step: view.theory().step().to_f64(), why: "the motion has no pace".into() };
    let (mut first, mut failed) = (largest(view).ok_or_else(no_pace)?, 0);
    let count = halvings::<T>();
    // The coarsest times may be too long for the reference's iteration.
    let (halves, solved) = loop {
        let halves = sizes(first, count, T::one());
        match solutions(view, &halves, measure.needs()) {
            Ok(solved) => break (halves, solved),
            Err(error) if failed >= HALVINGS => return Err(error),
            Err(_) => failed += 1,
        }
        first *= T::half();
    };
    // Where a level ends the motion may have become faster.
    let calm = |h: &T, exact: &Option<Exact>| match exact {
        Some((point, _)) => h.to_f64() * view.pace(&point.convert()) <= REACH,
        None => true,
    };
    let skipped = halves.iter().zip(&solved).take_while(|(h, exact)| !calm(h, exact)).count();
    let names = measure.names();
    let judged = names.len();
    let mut ladder = Ladder {
        findings: Findings::new(names, judged).local(),
        halves: None,
        signed: vec![Vec::new(); judged],
        judged,
    };
    ladder.part(measure, &halves[skipped..], &solved[skipped..])?;
    if enough(&ladder) {
        return Ok(ladder);
    }
    ladder.halves = Some(ladder.findings.clone());
    let between = sizes(first, count, T::ratio(3, 4));
    let solved = solutions(view, &between[skipped..], measure.needs())?;
    ladder.part(measure, &between[skipped..], &solved)?;
    ladder.findings = ladder.findings.sorted();
    Ok(ladder)
}

impl Ladder {
    fn part<T: Real>(
        &mut self,
        measure: &impl Measure<T>,
        sizes: &[T],
        solved: &[Option<Exact>],
    ) -> Result<(), StepError> {
        let (mut quiet, mut told) = (0, 0);
        for (k, (h, exact)) in sizes.iter().zip(solved).enumerate() {
            let gaps = measure.gaps(*h, exact.as_ref());
            let readings = match gaps {
                Err(error) if is_final(&error) => return Err(error),
                Err(error) => Err(error),
                Ok(gaps) => {
                    // `k` < 2: above a quarter of the first.
                    if told == 0 && k < 2 && gaps.iter().any(Gap::is_coarse) {
                        continue;
                    }
                    let signed = self.signed.iter_mut().zip(&gaps);
                    signed.for_each(|(list, gap)| list.push(gap.signed(h.to_f64())));
                    Ok(gaps.iter().map(Gap::reading).collect())
                }
            };
            if readings.is_err() {
                // What is coarser than a refused level does not count.
                self.signed.iter_mut().for_each(|list| list.retain(|level| level.h < h.to_f64()));
            }
            told += 1;
            let row = Row { steps: STEPS, h: h.to_f64(), readings };
            quiet = if self.findings.is_noise(&row) { quiet + 1 } else { 0 };
            self.findings.push(row);
            if told > 3 && quiet >= 2 {
                break;
            }
        }
        Ok(())
    }

    /// Whether the slopes of one quantity confirm an order, of the halved steps or of all.
    fn confirmed(&self, quantity: usize, order: u32) -> bool {
        let confirms = |findings: &Findings| match findings.line(quantity) {
            Line::Read(Estimate::Slope { low, .. }) => low >= f64::from(order) - TOLERANCE,
            _ => false,
        };
        confirms(&self.findings) || self.halves.as_ref().is_some_and(confirms)
    }

    fn quantity(&self, quantity: usize, order: u32) -> Standing {
        let line = self.findings.line(quantity);
        if line == Line::Exact {
            return Standing::Holds(0.0);
        }
        match (share(&self.signed[quantity], order + 1), self.confirmed(quantity, order)) {
            (Some(Share::Small(share)), _) => Standing::Holds(share),
            (Some(Share::Large(share)), false) => {
                let name = &self.findings.quantities()[quantity];
                let found = match &line {
                    Line::Read(Estimate::Slope { low, high, .. }) => format!("order in {}, ", interval(*low, *high)),
                    _ => String::new(),
                };
                let errors = match (100.0 * share).round() {
                    ..100.0 => format!("at least {:.0} % of the finest errors are", 100.0 * share),
                    _ => "the finest errors are".into(),
                };
                let falls = match &line {
                    Line::Read(Estimate::Slope { high, .. }) if *high < 0.5 => {
                        "order 0: after a fixed time they do not fall with the step"
                    }
                    _ => "lower order",
                };
                let witness = format!("{name}: {found}expected {order}; {errors} of {falls}");
                Standing::Below { witness, share, quantity }
            }
            (_, true) => Standing::Holds(0.0),
            _ => match line {
                Line::Read(Estimate::Inconclusive { why, .. }) => {
                    Standing::Open(format!("{}: {why}", self.findings.quantities()[quantity]))
                }
                _ => Standing::Open("the levels do not settle whether the errors are of lower order".into()),
            },
        }
    }

    /// Whether the order is at least so much, as far as these levels tell.
    pub(super) fn at_least(&self, order: u32) -> Standing {
        let mut all = Standing::Holds(0.0);
        for quantity in 0..self.judged {
            all = match (all, self.quantity(quantity, order)) {
                (below @ Standing::Below { .. }, _) | (_, below @ Standing::Below { .. }) => below,
                (open @ Standing::Open(_), _) | (_, open @ Standing::Open(_)) => open,
                (Standing::Holds(x), Standing::Holds(y)) => Standing::Holds(x.max(y)),
            };
        }
        all
    }

    /// Whether the errors fall faster than the order says, for certain.
    pub(super) fn is_above(&self, order: u32) -> bool {
        matches!(self.findings.compare(order), Comparison::Above { .. })
            && matches!(self.at_least(order + 1), Standing::Holds(_))
    }
}

/// What the method's ladders say: that from the start of the system; where it refutes the order, those from other starts as
/// well, and only what one of them repeats is refuted.
///
/// A defect may be small or large at one start by chance, such as a term of the series that vanishes near it. A method of too
/// low an order is so from nearly every start.
pub(super) fn standing(ladder: &Ladder, order: u32, again: impl Fn(usize) -> Result<Ladder, StepError>) -> Standing {
    let first = ladder.at_least(order);
    if !matches!(first, Standing::Below { .. }) {
        return first;
    }
    let mut against = 0;
    for start in 1..=STARTS {
        match again(start).map(|ladder| ladder.at_least(order)) {
            Ok(Standing::Below { .. }) => return first,
            Ok(Standing::Holds(_)) => against += 1,
            _ => {}
        }
        if against > 1 {
            break;
        }
    }
    Standing::Open("the errors fall too slowly from this start, and from no other".into())
}

impl Standing {
    /// The quantity that refutes.
    pub(super) fn deciding(&self) -> Option<usize> {
        match self {
            Self::Below { quantity, .. } => Some(*quantity),
            _ => None,
        }
    }

    pub(super) fn verdict(self) -> Verdict {
        match self {
            Self::Holds(share) => Verdict::Holds { defect: share.min(TOLERANCE), bound: TOLERANCE },
            Self::Below { witness, share, .. } => Verdict::Broken { defect: share, bound: TOLERANCE, witness },
            Self::Open(why) => Verdict::inconclusive(why),
        }
    }
}

impl<T: Precision> View<'_, '_, T> {
    /// Where the levels start: where the system does, or at another state near it.
    pub(super) fn start(&self) -> Point<T> {
        displaced(self.theory().start(), self.from)
    }
}
