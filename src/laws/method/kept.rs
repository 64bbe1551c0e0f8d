//! What is claimed to be kept without force, from the largest steps that the motion allows down.
//!
//! A method that keeps a quantity keeps it at any step: what is left is rounding, which does not grow with h. So the drift over
//! [`STEPS`] steps is measured at [`LEVELS`] sizes, from h pace = 1 ([`Theory::pace`](super::Theory::pace)) down by halves, and
//! at the step of the system. The bound counts operations. A step makes μ' = μ Ad by sums of n products, and Ad by an
//! exponential, an inverse or series of n×n matrices: sixteen sums of n terms in all, each off by n u of its terms. Structure
//! constants and basis come rounded, which moves ad_η by u |C||η|. So a step may move the quantity by
//!
//! ```text
//! 16 n (1 + h |C||η|) u        or        16 times the tolerance that is claimed
//! ```
//!
//! of the size of its terms, whichever is more. A drift above it is
//!
//! * refuted where it falls with the step like h^1.5 or faster, over two levels or more that are above the bound: the error of an
//!   order falls like h² at least, that of an iteration that stops early like h where its contraction does;
//! * refuted where it is [`AGREEMENT`] times the bound, however it behaves;
//! * else undecided: a loss of digits, or an iteration that stops earlier than it is said to.
//!
//! That the momenta of a step are a Poisson map is judged likewise, after one step of each size: D Π(μ) Dᵀ = Π(μ') with
//! Π_ab = C^c_ab μ_c and D the derivative of μ' by μ, by central differences of fourth order over changes of ε = u^{1/5} of the
//! largest component. Their weights add up to 3/2, so that rounding of a step is multiplied by 3/(2ε) in D, and D stands there
//! twice. Terms of fifth order are 4ε⁴ = 4u/ε at the sizes of steps that are looked at, less than that. So the bound is that of
//! a step times 3/ε, and defects are given in units of u/ε.
//!
//! That a step is that of a variational scheme is judged likewise, after one step of each size: μ' and g' against those of the scheme
//! in 32 digits. What rounding does there goes through the stage equations: [`variational`](super::variational). Where only the largest
//! of the steps differs, nothing is said: the equations of a large step may have more than one root.
//!
//! A method with 32 digits besides is judged by how the drift scales with the unit of round-off, at fewer sizes.

use super::levels::{self, REACH, is_final};
use super::theory::{names, no_value};
use super::variational::Scheme;
use super::{Judged, LOOSE, LOST_DIGITS, Outcome, Point, Quantity, Setup, Value, View, without};
use crate::harness::Verdict;
use crate::harness::evidence::{self, Evidence};
use crate::integrators::StepError;
use crate::laws::precision::{AGREEMENT, Measured, compare};
use crate::scalar::{Dd, Real, Scalar, convert, larger, max_abs};
use crate::study::{Findings, Reading, Row};

/// Steps over which a drift is measured, at most.
const STEPS: usize = 8;

/// Sizes of steps, by halves.
const LEVELS: i32 = 8;

/// The same where there are 32 digits.
const LEVELS_IN_QUAD: i32 = 2;

/// How many sums of n terms a step takes.
const SUMS: f64 = 16.0;

/// The slope from which on a drift falls with the step as the error of an order does.
const FALLS: f64 = 1.5;

/// The drift of a quantity over some steps, relative to its terms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drift {
    /// Which of the quantities.
    quantity: usize,
    h: f64,
    steps: usize,
    defect: f64,
    allowed: f64,
    size: f64,
    /// What defect and allowed are in units of: u, of the bracket u/ε.
    units: f64,
}

impl Drift {
    fn ratio(&self) -> f64 {
        self.defect / self.allowed
    }
}

/// A NaN is not small.
fn or_infinite(defect: f64) -> f64 {
    if defect.is_nan() { f64::INFINITY } else { defect }
}

/// What is to be kept.
#[derive(Clone, Copy)]
pub(super) enum Kept<'q> {
    /// The values of some quantities.
    Values(&'q [Quantity]),
    /// The Lie–Poisson bracket.
    Bracket,
    /// Equality with a scheme, of these parts of the state.
    Scheme(&'q Scheme, &'q [String]),
}

impl Kept<'_> {
    /// The drifts of all quantities at a size of steps, then those at the next.
    fn drifts<T: Real>(&self, view: &View<'_, '_, T>) -> Result<Vec<Drift>, StepError> {
        let mut sizes = Vec::new();
        let usual = view.theory.step();
        if let Some(first) = levels::largest(view) {
            let count = if view.setup.quad.is_some() { LEVELS_IN_QUAD } else { LEVELS };
            sizes.extend((0..count).map(|k| first * T::exact(2f64.powi(-k))));
            if usual.abs() <= first && !sizes.contains(&usual) {
                sizes.push(usual);
            }
        } else {
            sizes.push(usual);
        }
        let (mut found, mut error) = (Vec::new(), None);
        for h in sizes {
            let level = match self {
                Self::Values(quantities) => walk(quantities, view, h),
                Self::Bracket => bracket(view, h),
                Self::Scheme(scheme, _) => equality(scheme, view, h),
            };
            match level {
                Ok(level) => found.extend(level),
                Err(why) if is_final(&why) => return Err(why),
                // A step that is too large for the method says nothing.
                Err(why) => error = Some(why),
            }
        }
        match error {
            Some(error) if found.is_empty() => Err(error),
            _ => Ok(found),
        }
    }

    fn names(&self) -> Vec<String> {
        match self {
            Self::Values(quantities) => names(quantities),
            Self::Bracket => vec!["Poisson bracket".into()],
            Self::Scheme(_, parts) => parts.to_vec(),
        }
    }

    /// What is measured, and what one that falls with the step is.
    fn words(&self) -> [&'static str; 2] {
        match self {
            Self::Scheme(..) => ["difference from the scheme", "another method"],
            _ => ["drift", "an error of an order, no conservation"],
        }
    }
}

/// What rounding, or the claimed tolerance, may do in a step, in units of u; `sums` multiplies the displacements in it.
fn allowed<T: Real>(view: &View<'_, '_, T>, at: &Point<T>, h: T, sums: f64) -> f64 {
    let at = at.convert::<f64>();
    let turned = 1.0 + sums * h.to_f64().abs() * view.setup.theory.turn(&at);
    (SUMS * at.momentum.len() as f64 * turned).max(16.0 * view.tolerance / T::unit_roundoff().to_f64())
}

/// D Π(μ) Dᵀ − Π(μ') after a step.
fn bracket<T: Real>(view: &View<'_, '_, T>, h: T) -> Result<Vec<Drift>, StepError> {
    let start = view.theory.start();
    let n = start.momentum.len();
    let end = view.step(&start, h)?;
    // A power of two near u^{1/5}.
    let relative = T::exact(2f64.powi((T::unit_roundoff().to_f64().log2() / 5.0).round() as i32));
    let scale = max_abs(&start.momentum);
    let epsilon = relative * if scale > T::zero() { scale } else { T::one() };
    // The rows of D: those of ∂μ'/∂μ_a.
    let mut rows = Vec::with_capacity(n);
    for a in 0..n {
        let moved = |k: i64| {
            let mut point = start.clone();
            point.momentum[a] += epsilon * T::int(k);
            view.step(&point, h)
        };
        let (one, minus_one, two, minus_two) = (moved(1)?, moved(-1)?, moved(2)?, moved(-2)?);
        let slope = |b: usize| {
            let (near, far) = (one.momentum[b] - minus_one.momentum[b], two.momentum[b] - minus_two.momentum[b]);
            (near * T::int(8) - far) / (epsilon * T::int(12))
        };
        rows.push((0..n).map(slope).collect::<Vec<T>>());
    }
    let (before, after) = (view.theory.brackets(&start), view.theory.brackets(&end));
    let (mut defect, mut size) = (T::zero(), T::exact(f64::MIN_POSITIVE));
    for b in 0..n {
        for c in 0..n {
            let (mut sum, mut terms) = (T::zero(), T::zero());
            for a in 0..n {
                for d in 0..n {
                    let term = rows[a][b] * before[a * n + d] * rows[d][c];
                    sum += term;
                    terms += term.abs();
                }
            }
            let off = (sum - after[b * n + c]).abs();
            defect = larger(defect, off);
            size = size.max(terms).max(after[b * n + c].abs());
        }
    }
    let units = T::unit_roundoff().to_f64() / relative.to_f64();
    let (defect, allowed) = (or_infinite((defect / size).to_f64() / units), 3.0 * allowed(view, &start, h, 1.0));
    Ok(vec![Drift { quantity: 0, h: h.to_f64(), steps: 1, defect, allowed, size: size.to_f64(), units }])
}

/// The largest share of its terms that is taken to first order.
const SMALL: f64 = 1.0 / 128.0;

/// A step against that of a scheme, from an attitude that is not the identity: there the sides of g are not told apart.
fn equality<T: Real>(scheme: &Scheme, view: &View<'_, '_, T>, h: T) -> Result<Vec<Drift>, StepError> {
    let start = view.theory.start();
    let start = match view.theory.element() {
        Some(k) => start.translated(&k),
        None => start,
    };
    let refuse = |why: &str| StepError::Refused { step: h.to_f64(), why: why.into() };
    let own = |_| refuse("the variational scheme itself has no such step");
    let exact = (scheme.exact)(&start.convert(), convert(h)).map_err(own)?;
    let spread = (scheme.spread)(&start.convert(), h.to_f64()).map_err(own)?;
    let mine = view.step(&start, h)?;
    let share = [&start, &exact.convert()].map(|at| allowed(view, at, h, scheme.sums));
    let (share, units) = (share[0].max(share[1]), T::unit_roundoff().to_f64());
    let drift = |quantity: usize, mine: &[T], exact: &[Dd], start: &[T], spread: f64| {
        let off: Vec<Dd> = mine.iter().zip(exact).map(|(x, y)| convert::<T, Dd>(*x) - *y).collect();
        let size = max_abs(exact).to_f64().max(max_abs(start).to_f64()).max(f64::MIN_POSITIVE);
        let defect = or_infinite(max_abs(&off).to_f64() / size / units);
        Drift { quantity, h: h.to_f64(), steps: 1, defect, allowed: share * spread / size, size, units }
    };
    let momentum = drift(0, &mine.momentum, &exact.momentum, &start.momentum, spread.momentum);
    let mut drifts = vec![momentum];
    if !start.attitude.is_empty() {
        drifts.push(drift(1, &mine.attitude, &exact.attitude, &start.attitude, spread.beside));
    }
    // A NaN is not small either.
    if drifts.iter().any(|drift| (drift.allowed * units).partial_cmp(&SMALL).is_none_or(|order| order.is_gt())) {
        return Err(refuse("the stage equations are nearly singular"));
    }
    Ok(drifts)
}

/// Steps of one size, as long as the motion is not too fast for them.
fn walk<T: Real>(quantities: &[Quantity], view: &View<'_, '_, T>, h: T) -> Result<Vec<Drift>, StepError> {
    let (start, size) = (view.theory.start(), h.to_f64().abs());
    let units = T::unit_roundoff().to_f64();
    let (mut point, mut steps, mut all) = (start.clone(), 0, 0.0);
    let none = |quantity| Drift { quantity, h: h.to_f64(), steps: 0, defect: 0.0, allowed: 1.0, size: 0.0, units };
    let mut drifts: Vec<Drift> = (0..quantities.len()).map(none).collect();
    while steps < STEPS {
        let at = point.convert::<f64>();
        if steps > 0
            && (size * view.setup.theory.pace(&at)).partial_cmp(&(2.0 * REACH)).is_none_or(|order| order.is_gt())
        {
            break;
        }
        let next = match view.step(&point, h) {
            Err(error) if steps == 0 || is_final(&error) => return Err(error),
            Err(_) => break,
            Ok(next) => next,
        };
        steps += 1;
        all += allowed(view, &point, h, 1.0);
        for (worst, quantity) in drifts.iter_mut().zip(quantities) {
            for (defect, size) in moved(view, *quantity, &start, &next).ok_or_else(|| no_value(h.to_f64()))? {
                let drift = Drift { defect: defect / units, allowed: all, size, ..*worst };
                // At first, 0/0.
                let [ratio, known] = [drift.ratio(), worst.ratio()];
                if ratio.is_nan() || known.is_nan() || ratio > known {
                    *worst = drift;
                }
            }
        }
        point = next;
    }
    drifts.iter_mut().for_each(|drift| drift.steps = steps);
    Ok(drifts)
}

/// |V(after) − V(before)| of each component relative to its terms, and their size.
///
/// In exact numbers, and in those of the scalar, which a program is told: the smaller.
fn moved<T: Real>(
    view: &View<'_, '_, T>,
    quantity: Quantity,
    before: &Point<T>,
    after: &Point<T>,
) -> Option<Vec<(f64, f64)>> {
    fn relative<W: Real>((before, after): (Value<W>, Value<W>)) -> (f64, f64) {
        let size = before.size.max(after.size).max(before.reach).max(after.reach).max(W::exact(f64::MIN_POSITIVE));
        let defect = (after.value - before.value).abs();
        let defect = if defect == W::zero() { 0.0 } else { (defect / size).to_f64() };
        (or_infinite(defect), size.to_f64())
    }
    let (theory, known) = (view.theory, &view.setup.known);
    let mine = theory.value(quantity, before)?.into_iter().zip(theory.value(quantity, after)?).map(relative);
    let (before, after) = (before.convert::<Dd>(), after.convert::<Dd>());
    let exact = known.value(quantity, &before)?.into_iter().zip(known.value(quantity, &after)?).map(relative);
    Some(mine.zip(exact).map(|(mine, exact)| if exact.0 < mine.0 { exact } else { mine }).collect())
}

/// Whether it is kept.
pub(super) fn judge(setup: &Setup<'_>, look: Kept<'_>, tolerance: f64) -> Judged {
    let names = look.names();
    let double = look.drifts(&View::double(setup, tolerance, 0));
    if let Some(view) = View::quad(setup, 0) {
        return Ok(compare(measured(&look, double), measured(&look, look.drifts(&view))).into());
    }
    let drifts = double.map_err(without)?;
    let verdicts = (0..names.len()).map(|quantity| alone(&look, quantity, &drifts));
    let verdict = verdicts.reduce(Verdict::and).ok_or_else(|| Verdict::not_applicable("nothing to keep"))?;
    let findings = verdict.is_broken().then(|| findings(names, &drifts));
    Ok(Outcome { findings, ..verdict.into() })
}

/// The worst of all.
fn measured(look: &Kept<'_>, drifts: Result<Vec<Drift>, StepError>) -> Measured {
    let one = |drift: &Drift| Measured::Defect {
        amplification: drift.defect,
        floor: drift.allowed,
        witness: witness(look, drift),
    };
    match drifts {
        Ok(drifts) => {
            let worst = drifts.iter().map(one).reduce(Measured::and);
            worst.unwrap_or(Measured::NotApplicable("nothing to keep".into()))
        }
        Err(error) => error.into(),
    }
}

fn witness(look: &Kept<'_>, drift: &Drift) -> String {
    let Drift { h, steps, size, .. } = drift;
    let (name, what, relative) = (&look.names()[drift.quantity], look.words()[0], drift.defect * drift.units);
    let count = if *steps == 1 { "a step".into() } else { format!("{steps} steps") };
    format!("{name}: a {what} of {relative:.3e} in {count} of {h}, relative to terms of size {size:.3e}")
}

/// One quantity by itself.
fn alone(look: &Kept<'_>, quantity: usize, drifts: &[Drift]) -> Verdict {
    let (name, [what, order]) = (&look.names()[quantity], look.words());
    let drifts: Vec<&Drift> = drifts.iter().filter(|drift| drift.quantity == quantity).collect();
    let Some(worst) = drifts.iter().max_by(|a, b| a.ratio().total_cmp(&b.ratio())) else {
        return Verdict::inconclusive("no step was taken");
    };
    let (defect, bound) = (worst.defect, worst.allowed);
    evidence::note(|| Evidence::Defect { digits: 16, defect, bound, alone: bound, witness: witness(look, worst) });
    if worst.ratio() <= 1.0 {
        return Verdict::Holds { defect, bound };
    }
    if matches!(look, Kept::Scheme(..)) && is_largest_alone(&drifts) {
        let why = "the largest step alone differs: its equations may have another root";
        return Verdict::inconclusive(format!("{name}: {why}"));
    }
    let broken = |why: String| Verdict::Broken { defect, bound, witness: format!("{}; {why}", witness(look, worst)) };
    match slope(&drifts) {
        Some(slope) if slope >= FALLS => broken(format!("it falls with the step like h^{slope:.1}: {order}")),
        _ if worst.ratio() > AGREEMENT => broken(format!(
            "{LOOSE}, or another error that does not fall with the step, far above rounding; --tolerance says how well a step solves \
             its equations"
        )),
        _ => Verdict::inconclusive(format!(
            "{name}: {LOST_DIGITS}: the {what} is above rounding, and no error of an order; if the solver stops early, say so with --tolerance"
        )),
    }
}

/// Whether there are several sizes of steps, and the drift is above its bound at the largest alone.
fn is_largest_alone(drifts: &[&Drift]) -> bool {
    let most = drifts.iter().fold(0.0, |most: f64, drift| most.max(drift.h.abs()));
    let within = |drift: &&Drift| drift.h.abs() == most || drift.defect <= drift.allowed;
    drifts.iter().any(|drift| drift.h.abs() < most) && drifts.iter().all(within)
}

/// The slope of the drift between the largest and the smallest step at which it is above its bound; `None` of fewer than two.
fn slope(drifts: &[&Drift]) -> Option<f64> {
    let clear = drifts.iter().filter(|drift| drift.defect > drift.allowed && drift.defect.is_finite());
    let largest = clear.clone().max_by(|a, b| a.h.abs().total_cmp(&b.h.abs()))?;
    let smallest = clear.min_by(|a, b| a.h.abs().total_cmp(&b.h.abs()))?;
    let steps = (largest.h / smallest.h).abs();
    (steps > 1.0).then(|| (largest.defect / smallest.defect).ln() / steps.ln())
}

/// The drifts at all levels, with what they may be as their noise.
fn findings(names: Vec<String>, drifts: &[Drift]) -> Findings {
    let judged = names.len();
    let mut findings = Findings::new(names, judged).local();
    for level in drifts.chunk_by(|a, b| a.h == b.h) {
        let reading = |drift: &Drift| Reading {
            error: drift.defect * drift.size * drift.units,
            noise: drift.allowed * drift.size * drift.units,
            reference_error: 0.0,
        };
        let readings = Ok(level.iter().map(reading).collect());
        findings.push(Row { steps: level[0].steps, h: level[0].h, readings });
    }
    findings.sorted()
}
