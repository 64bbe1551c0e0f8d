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

use super::theory::{names, no_value};
use super::{Point, Quantity, Setup, Solved, View, difference};
use crate::harness::Verdict;
use crate::harness::convergence::{Estimate, TOLERANCE};
use crate::harness::lower::{Share, Signed, share};
use crate::integrators::StepError;
use crate::scalar::{Dd, Real, Scalar, convert, larger, max_abs};
use crate::study::{Comparison, Findings, Line, Reading, Row};
use nalgebra::RealField;
use std::cmp::Ordering;

/// Why a level is left out.
pub(super) const DIVERGES: &str = "the method diverges with this step";

/// Steps of a level: on, or forth and back.
pub(super) const STEPS: usize = 2;

/// The largest step times the pace of the motion.
pub(super) const REACH: f64 = 1.0;

/// The largest relative error of a level, of those above a quarter of the largest step: beyond it no series tells anything.
const COARSE: f64 = 1e-2;

/// The first step is at most 2 to the power of this times that of the system.
const DOUBLINGS: i32 = 6;

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
pub(super) struct Gap {
    /// Its components.
    pub error: Vec<f64>,
    /// The size of what was compared.
    pub size: f64,
    /// What rounding and the reference may do.
    pub noise: f64,
    /// What the reference may be off.
    pub reference_error: f64,
}

impl Gap {
    /// Whether it is too large for a series to tell anything, or no number.
    fn is_coarse(&self) -> bool {
        let error = max_abs(&self.error);
        error != 0.0 && (error / self.size).partial_cmp(&COARSE).is_none_or(Ordering::is_gt)
    }

    fn reading(&self) -> Reading {
        Reading { error: max_abs(&self.error), noise: self.noise, reference_error: self.reference_error }
    }
}

/// What is measured at a level.
#[derive(Clone, Copy)]
pub(super) enum What<'q> {
    /// The state against the solution.
    State,
    /// Some quantities against those at the solution: |V(μ_n) − V(μ(t_n))|.
    Values(&'q [Quantity]),
    /// Φ_{−h}∘Φ_h − 1.
    Return,
}

/// The errors of a method, studied for a claim of this order.
pub(super) struct Study<'q>(pub What<'q>, pub u32);

impl Study<'_> {
    /// The ladder of a method in the sharper of its precisions, from the start of the system (0) or from another.
    ///
    /// # Errors
    /// That the method does not apply or does not answer; those of the reference.
    pub(super) fn ladder(&self, setup: &Setup<'_>, tolerance: f64, from: usize) -> Result<Ladder, StepError> {
        match View::quad(setup, from) {
            Some(view) => self.descend(&view),
            None => self.descend(&View::double(setup, tolerance, from)),
        }
    }

    /// What the method's ladders say: that from the start of the system; where it refutes the order, those from other starts as
    /// well, and only what one of them repeats is refuted.
    ///
    /// A defect may be small or large at one start by chance, such as a term of the series that vanishes near it. A method of too
    /// low an order is so from nearly every start.
    pub(super) fn at_least(&self, setup: &Setup<'_>, tolerance: f64, first: &Ladder) -> (Verdict, Option<usize>) {
        let refuted = first.at_least(self.1);
        if !refuted.0.is_broken() {
            return refuted;
        }
        let mut against = 0;
        for start in 1..=STARTS {
            match self.ladder(setup, tolerance, start).map(|ladder| ladder.at_least(self.1).0) {
                Ok(Verdict::Broken { .. }) => return refuted,
                Ok(Verdict::Holds { .. }) => against += 1,
                _ => {}
            }
            if against > 1 {
                break;
            }
        }
        (Verdict::inconclusive("the errors fall too slowly from this start, and from no other"), None)
    }

    /// Level after level, until two in a row show nothing but noise; the sizes in between as well, unless that is enough.
    ///
    /// # Errors
    /// That the method does not apply or does not answer; those of the reference.
    fn descend<T: Real>(&self, view: &View<'_, '_, T>) -> Result<Ladder, StepError> {
        let no_pace = || StepError::Refused { step: view.theory.step().to_f64(), why: "the motion has no pace".into() };
        let (what, mut first, mut failed) = (self.0, largest(view).ok_or_else(no_pace)?, 0);
        let count = halvings::<T>();
        // The coarsest times may be too long for the reference's iteration.
        let (halves, solved) = loop {
            let halves = sizes(first, count, T::one());
            match what.ends(view, &halves) {
                Ok(solved) => break (halves, solved),
                Err(error) if failed >= HALVINGS => return Err(error),
                Err(_) => failed += 1,
            }
            first *= T::half();
        };
        // Where a level ends the motion may have become faster.
        let calm = |h: &T, end: &Point<Dd>| h.to_f64() * view.setup.theory.pace(&end.convert()) <= REACH;
        let skipped = halves.iter().zip(&solved).take_while(|(h, (end, _))| !calm(h, end)).count();
        let names = what.names(view);
        let mut signed = vec![Vec::new(); names.len()];
        let measured = |sizes: &[T], solved: &[Solved<Dd>], signed: &mut [Vec<Signed>]| {
            let findings = Findings::new(names.clone(), names.len()).local();
            findings.descend(rows(view, what, sizes.iter().zip(solved), signed))
        };
        let halves = measured(&halves[skipped..], &solved[skipped..], &mut signed)?;
        let ladder = Ladder { findings: halves.clone(), halves: None, signed: signed.clone() };
        if self.is_told(&ladder, view.setup.quad.is_some()) {
            return Ok(ladder);
        }
        let between = sizes(first, count, T::ratio(3, 4));
        let solved = what.ends(view, &between[skipped..])?;
        let mut findings = measured(&between[skipped..], &solved, &mut signed)?;
        halves.rows().iter().for_each(|row| findings.push(row.clone()));
        Ok(Ladder { findings: findings.sorted(), halves: Some(halves), signed })
    }

    /// Whether halved steps alone tell enough: that the claim is confirmed, or, in 32 digits, where there are many, decided.
    fn is_told(&self, ladder: &Ladder, quad: bool) -> bool {
        let Self(what, order) = self;
        // Of the state the order is wanted, neither more nor less.
        let at_least = !matches!(what, What::State);
        match ladder.findings.compare(*order) {
            Comparison::As { .. } | Comparison::Exact => true,
            Comparison::Above { .. } if at_least => true,
            _ if !quad => false,
            _ => match ladder.at_least(*order).0 {
                Verdict::Holds { .. } => at_least,
                verdict => verdict.is_broken(),
            },
        }
    }
}

/// How many parts a state has: without a group, no attitude.
fn parts<T>(point: &Point<T>) -> usize {
    if point.attitude.is_empty() { 1 } else { 2 }
}

impl What<'_> {
    /// The names of the quantities.
    fn names<T: Real>(&self, view: &View<'_, '_, T>) -> Vec<String> {
        match self {
            Self::Values(quantities) => names(quantities),
            Self::State | Self::Return => view.theory.parts(),
        }
    }

    /// Where a level of each of these sizes is to end: at the solution, or where it starts.
    ///
    /// # Errors
    /// Those of the reference.
    fn ends<T: Real>(&self, view: &View<'_, '_, T>, sizes: &[T]) -> Result<Vec<Solved<Dd>>, StepError> {
        let start = view.start();
        let attitude = match self {
            Self::Return => return Ok(vec![(start.convert(), (Dd::exact(0.0), Dd::exact(0.0))); sizes.len()]),
            Self::State => parts(&start) > 1,
            Self::Values(quantities) => quantities.contains(&Quantity::Momentum),
        };
        let times: Vec<Dd> = sizes.iter().map(|h| convert(*h * T::int(STEPS as i64))).collect();
        // Far below what a method of 16 digits can be wrong by and still be called exact.
        let tolerance = if view.setup.quad.is_some() { 0.0 } else { 2f64.powi(-68) };
        view.setup.known.solve(&start.convert(), &times, tolerance, attitude)
    }

    /// The gaps after [`STEPS`] steps of size h, which are to end at `exact`, off by so much.
    ///
    /// # Errors
    /// Those of a step.
    fn gaps<T: Real>(
        &self,
        view: &View<'_, '_, T>,
        h: T,
        (exact, reference_error): &Solved<Dd>,
    ) -> Result<Vec<Gap>, StepError> {
        let (start, noise) = (view.start(), view.noise(STEPS));
        let second = if matches!(self, Self::Return) { -h } else { h };
        let end = view.step(&view.step(&start, h)?, second)?;
        if let Self::Values(quantities) = self {
            let mine = end.convert::<Dd>();
            let of = |quantity: &Quantity| balance(view, *quantity, h, (&mine, exact), *reference_error);
            return quantities.iter().map(of).collect();
        }
        let of = |mine: &[T], theirs: &[Dd], from: &[T], reference_error: Dd| {
            let error = mine.iter().zip(theirs).map(|(x, y)| (convert::<T, Dd>(*x) - *y).to_f64()).collect();
            let theirs: Vec<T> = theirs.iter().map(|x| convert(*x)).collect();
            let size = difference(mine, &theirs).1.max(difference(&theirs, from).1).max(T::exact(f64::MIN_POSITIVE));
            let reference_error = reference_error.to_f64();
            Gap { error, size: size.to_f64(), noise: (size * noise).to_f64() + reference_error, reference_error }
        };
        let momentum = of(&end.momentum, &exact.momentum, &start.momentum, reference_error.0);
        let attitude = of(&end.attitude, &exact.attitude, &start.attitude, reference_error.1);
        Ok([momentum, attitude].into_iter().take(parts(&start)).collect())
    }
}

/// A quantity at the end of the steps against that at the solution, which is off by `reference_error`.
fn balance<T: Real>(
    view: &View<'_, '_, T>,
    quantity: Quantity,
    h: T,
    (mine, exact): (&Point<Dd>, &Point<Dd>),
    (of_momentum, of_attitude): (Dd, Dd),
) -> Result<Gap, StepError> {
    let largest = max_abs(&exact.momentum);
    let value = |point| view.setup.known.value(quantity, point).ok_or_else(|| no_value(h.to_f64()));
    let mut gap = Gap { error: Vec::new(), size: f64::MIN_POSITIVE, noise: 0.0, reference_error: 0.0 };
    for (found, wanted) in value(mine)?.iter().zip(&value(exact)?) {
        let reach = found.reach.max(wanted.reach).max(found.size).max(wanted.size);
        let off = if largest > Dd::exact(0.0) { wanted.reach * of_momentum / largest } else { of_momentum };
        let off = match quantity {
            // g stands in it twice.
            Quantity::Momentum => off + wanted.reach * of_attitude * Dd::exact(2.0),
            _ => off,
        };
        gap.error.push((found.value - wanted.value).to_f64());
        gap.size = larger(gap.size, found.size.max(wanted.size).to_f64());
        // What the reference does not know is noise: a balance that is better than that is exact as far as can be told.
        let off = off.to_f64();
        gap.noise = larger(gap.noise, (view.noise(STEPS) * convert(reach)).to_f64() + 2.0 * off);
        gap.reference_error = larger(gap.reference_error, off);
    }
    gap.noise += gap.reference_error;
    Ok(gap)
}

/// The errors of a method at a ladder of steps.
pub(super) struct Ladder {
    /// Of all levels.
    pub findings: Findings,
    /// Of halved steps alone, where there are others too.
    halves: Option<Findings>,
    /// The errors with their signs, of each quantity.
    signed: Vec<Vec<Signed>>,
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
pub(super) fn largest<T: Real>(view: &View<'_, '_, T>) -> Option<T> {
    let pace = view.setup.theory.pace(&view.start().convert());
    let mut first = view.theory.step().abs() * T::exact(2f64.powi(DOUBLINGS));
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

/// What is measured at these sizes, and the errors with their signs.
fn rows<'s, T: Real>(
    view: &View<'_, '_, T>,
    what: What<'_>,
    levels: impl Iterator<Item = (&'s T, &'s Solved<Dd>)>,
    signed: &mut [Vec<Signed>],
) -> impl Iterator<Item = Result<Row, StepError>> {
    let mut told = false;
    levels.enumerate().filter_map(move |(k, (h, exact))| {
        let readings = match what.gaps(view, *h, exact) {
            Err(error) if is_final(&error) => return Some(Err(error)),
            Err(error) => {
                // What is coarser than a refused level does not count.
                signed.iter_mut().for_each(|list| list.retain(|level| level.h < h.to_f64()));
                Err(error)
            }
            // `k` < 2: above a quarter of the first.
            Ok(gaps) if !told && k < 2 && gaps.iter().any(Gap::is_coarse) => return None,
            Ok(gaps) => {
                let readings = gaps.iter().map(Gap::reading).collect();
                let signed_gap = |Gap { error, noise, .. }| Signed { h: h.to_f64(), error, noise };
                signed.iter_mut().zip(gaps).for_each(|(list, gap)| list.push(signed_gap(gap)));
                Ok(readings)
            }
        };
        told = true;
        Some(Ok(Row { steps: STEPS, h: h.to_f64(), readings }))
    })
}

impl Ladder {
    /// Whether the slopes of one quantity confirm an order, of the halved steps or of all.
    fn confirmed(&self, quantity: usize, order: u32) -> bool {
        let confirms = |findings: &Findings| match findings.line(quantity) {
            Line::Read(Estimate::Slope { low, .. }) => low >= f64::from(order) - TOLERANCE,
            _ => false,
        };
        confirms(&self.findings) || self.halves.as_ref().is_some_and(confirms)
    }

    /// Whether the order of one quantity is at least so much.
    fn quantity(&self, quantity: usize, order: u32) -> Verdict {
        let (name, line) = (&self.findings.quantities()[quantity], self.findings.line(quantity));
        let holds = |share: f64| Verdict::Holds { defect: share.min(TOLERANCE), bound: TOLERANCE };
        if line == Line::Exact {
            return holds(0.0);
        }
        match (share(&self.signed[quantity], order + 1), self.confirmed(quantity, order)) {
            (Some(Share::Small(share)), _) => holds(share),
            (Some(Share::Large(share)), false) => {
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
                Verdict::Broken { defect: share, bound: TOLERANCE, witness }
            }
            (_, true) => holds(0.0),
            _ => Verdict::inconclusive(match line {
                Line::Read(Estimate::Inconclusive { why, .. }) => format!("{name}: {why}"),
                _ => "the levels do not settle whether the errors are of lower order".into(),
            }),
        }
    }

    /// Whether the order is at least so much, as far as these levels tell; the quantity that refutes it.
    pub(super) fn at_least(&self, order: u32) -> (Verdict, Option<usize>) {
        let mut all = Verdict::Holds { defect: 0.0, bound: TOLERANCE };
        for quantity in 0..self.signed.len() {
            let verdict = self.quantity(quantity, order);
            if verdict.is_broken() {
                return (verdict, Some(quantity));
            }
            all = all.and(verdict);
        }
        (all, None)
    }

    /// Whether the errors fall faster than the order says, for certain.
    pub(super) fn is_above(&self, order: u32) -> bool {
        matches!(self.findings.compare(order), Comparison::Above { .. }) && self.at_least(order + 1).0.holds()
    }
}
