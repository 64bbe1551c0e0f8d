//! Defects that fall at the order of the method: errors, drifts, Φ_{−h}∘Φ_h − 1.

use super::{Claims, Look, Other, Outcome, Point, Precision, Quantity, Setup, VARIATIONS, View, difference, without};
use crate::harness::Verdict;
use crate::harness::convergence::{Estimate, TOLERANCE};
use crate::harness::evidence;
use crate::integrators::StepError;
use crate::laws::integrators::refused;
use crate::laws::precision::Measured;
use crate::scalar::Real;
use crate::study::{Comparison, Findings, Line, Reading, Row};

/// Steps of a level of the order.
const STEPS: usize = 2;

/// Steps of a level of a balance: the panels of a Newton–Cotes formula.
const PANELS: usize = 8;

/// The closed Newton–Cotes formula with nine points, in units of 4/14175; exact for polynomials up to degree 9 (Abramowitz and
/// Stegun 1964, 25.4.18).
const WEIGHTS: [i64; PANELS + 1] = [989, 5888, -928, 10496, -4540, 10496, -928, 5888, 989];

/// The highest order at which a balance by this formula is judged.
const HIGHEST: u32 = 9;

/// The first step is doubled up to so often, while the relative error stays below [`COARSE`].
const DOUBLINGS: usize = 6;
const COARSE: f64 = 1e-3;

/// The widest interval of a slope that refutes an order, in 16 digits.
const SHARP: f64 = 0.25;

/// The stages of the reference: order 16.
const STAGES: usize = 8;

/// How often the first step is halved, where the reference does not converge.
const HALVINGS: usize = 8;

/// Whether an error decides about the whole case, not about one level.
fn is_final(error: &StepError) -> bool {
    matches!(error, StepError::Unsupported { .. } | StepError::NoAnswer { .. })
}

/// How often the step is halved.
fn levels<T: Real>() -> i32 {
    if T::unit_roundoff() < T::exact(1e-20) { 20 } else { 16 }
}

/// The step sizes h, h/2, h/4, …, and then those between them, 3h/4, 3h/8, ….
fn sizes<T: Real>(h: T) -> Vec<T> {
    let half = |k: i32| h * T::exact(2f64.powi(-k));
    (0..levels::<T>()).map(half).chain((0..levels::<T>()).map(|k| half(k) * T::ratio(3, 4))).collect()
}

/// Level after level until two in a row show nothing but noise; the sizes in between as well, where the others are too few to tell
/// a slope.
fn descend<T: Real>(
    names: Vec<String>,
    sizes: &[T],
    steps: usize,
    mut level: impl FnMut(usize, T) -> Result<Vec<Reading>, StepError>,
) -> Result<Findings, StepError> {
    let judged = names.len();
    let mut findings = Findings::new(names, judged).local();
    let (halves, between) = sizes.split_at(sizes.len() / 2);
    for (first, part) in [(0, halves), (halves.len(), between)] {
        let told = |findings: &Findings| (0..judged).all(|quantity| is_told(&findings.line(quantity)));
        if first > 0 && told(&findings) {
            break;
        }
        let mut quiet = 0;
        for (k, h) in part.iter().enumerate() {
            let readings = level(first + k, *h);
            if let Err(error) = &readings
                && is_final(error)
            {
                return Err(error.clone());
            }
            let row = Row { steps, h: h.to_f64(), readings };
            quiet = if findings.is_noise(&row) { quiet + 1 } else { 0 };
            findings.push(row);
            if k >= 3 && quiet >= 2 {
                break;
            }
        }
    }
    Ok(findings.sorted())
}

/// Whether a line has a slope, or nothing but rounding.
fn is_told(line: &Line) -> bool {
    matches!(line, Line::Exact | Line::Read(Estimate::Slope { .. }))
}

/// The largest h 2^k at which the relative defect is small still and nothing is refused.
fn coarse<T: Real>(h: T, mut defect: impl FnMut(T) -> Result<f64, StepError>) -> Result<T, StepError> {
    let mut first = h;
    for _ in 0..DOUBLINGS {
        match defect(first * T::int(2)) {
            Ok(defect) if defect < COARSE => first *= T::int(2),
            Err(error) if is_final(&error) => return Err(error),
            _ => break,
        }
    }
    Ok(first)
}

fn reading<T: Real>(error: T, size: T, noise: T, doubt: T) -> Reading {
    Reading { error: error.to_f64(), noise: (noise * size + doubt).to_f64(), doubt: doubt.to_f64() }
}

/// Tells the errors to whoever gathers them.
fn tell(setup: &Setup<'_>, findings: &Findings, order: u32, what: &str) {
    let digits = if setup.quad.is_some() { 32 } else { 16 };
    evidence::note_all(|| findings.evidence(order, digits, what));
}

/// At the order or above it holds.
fn at_least(setup: &Setup<'_>, findings: &Findings, order: u32) -> Outcome {
    let verdict = match findings.compare(order) {
        Comparison::Above { .. } | Comparison::Exact => Verdict::Holds { defect: 0.0, bound: TOLERANCE },
        other => other.verdict(),
    };
    outcome(setup, findings, verdict)
}

fn outcome(setup: &Setup<'_>, findings: &Findings, verdict: Verdict) -> Outcome {
    // A line of refusals alone: the reason is theirs.
    let refusal = findings.rows().last().and_then(|row| row.readings.as_ref().err());
    if let (Verdict::Inconclusive { .. }, Some(error)) = (&verdict, refusal) {
        return without(error).into();
    }
    let slope = findings.limiting().ok().map(|(_, estimate)| estimate);
    // Above the rounding errors of 16 digits there may be no step so small that the slope has settled.
    if let (Verdict::Broken { .. }, None, Some(Estimate::Slope { low, high, .. })) = (&verdict, &setup.quad, &slope)
        && high - low > SHARP
    {
        return Verdict::inconclusive("16 digits do not tell the slope sharply enough to refute the order").into();
    }
    Outcome { slope, findings: Some(findings.clone()), ..verdict.into() }
}

/// Errors of so many steps against the solution.
struct Errors;

impl Look for Errors {
    type Output = Result<Findings, StepError>;

    fn look<T: Precision>(&self, view: &View<'_, '_, T>) -> Self::Output {
        let start = view.theory().start();
        let parts = if start.attitude.is_empty() { 1 } else { 2 };
        let names = ["momentum", "attitude"].into_iter().take(parts).map(str::to_owned).collect();
        let run = |h: T| (0..STEPS).try_fold(start.clone(), |point, _| view.step(&point, h));
        let compare = |end: &Point<T>, (exact, doubt): &super::Solved<T>| {
            let noise = view.noise(STEPS);
            let of = |mine: &[T], theirs: &[T], from: &[T], doubt: T| {
                let (error, _) = difference(mine, theirs);
                reading(error, difference(theirs, from).1, noise, doubt)
            };
            let momentum = of(&end.momentum, &exact.momentum, &start.momentum, doubt.0);
            let attitude = of(&end.attitude, &exact.attitude, &start.attitude, doubt.1);
            [momentum, attitude].into_iter().take(parts).collect::<Vec<_>>()
        };
        let steps = T::int(STEPS as i64);
        let relative = |end: &Point<T>, exact: &Point<T>| {
            let of = |mine: &[T], theirs: &[T]| match difference(mine, theirs) {
                (defect, _) if defect == T::zero() => 0.0,
                (defect, size) => (defect / size).to_f64(),
            };
            of(&end.momentum, &exact.momentum).max(of(&end.attitude, &exact.attitude))
        };
        let first = coarse(view.theory().step(), |h| {
            let solved = view.solution(&[h * steps], STAGES)?;
            Ok(relative(&run(h)?, &solved[0].0))
        })?;
        // The coarsest times may be too long for the reference's iteration: then from half the step.
        let (mut sizes, mut failed) = (sizes(first), 0);
        let solved = loop {
            let times: Vec<T> = sizes.iter().map(|h| *h * steps).collect();
            match view.solution(&times, STAGES) {
                Ok(solved) => break solved,
                Err(error) if failed >= HALVINGS => return Err(error),
                Err(_) => failed += 1,
            }
            sizes.iter_mut().for_each(|h| *h *= T::half());
        };
        descend(names, &sizes, STEPS, |k, h| Ok(compare(&run(h)?, &solved[k])))
    }
}

/// The order, as claimed or at least 1.
pub(super) fn order(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    let study = |setup: &Setup<'_>| setup.sharp(Errors, claims.tolerance);
    let findings = match study(setup) {
        Ok(findings) => findings,
        Err(error) => return without(&error).into(),
    };
    tell(setup, &findings, claims.least_order(), ", after two steps");
    let Some(order) = claims.order else { return at_least(setup, &findings, 1) };
    let first = findings.compare(order);
    if !matches!(first, Comparison::Above { .. } | Comparison::Exact) {
        return outcome(setup, &findings, first.verdict());
    }
    // The order of a method is the least that it shows on any system: others are asked.
    let mut above = 0;
    for k in 1..=VARIATIONS + 1 {
        let other = match (setup.others)(Other::Variation(k)) {
            Ok(Some((other, _))) => study(&other),
            Ok(None) => continue,
            Err(error) => Err(error),
        };
        match other {
            Ok(other) => match other.compare(order) {
                Comparison::Above { .. } => above += 1,
                Comparison::Exact | Comparison::Unknown { .. } => {}
                decided => {
                    let decided_by = Some(Other::Variation(k));
                    return Outcome { decided_by, ..outcome(setup, &other, decided.verdict()) };
                }
            },
            Err(error @ StepError::NoAnswer { .. }) => return without(&error).into(),
            Err(_) => {}
        }
    }
    let verdict = match first {
        Comparison::Exact => Verdict::inconclusive("every error is rounding, on this system and on others"),
        above_order if above > 0 => above_order.verdict(),
        _ => Verdict::inconclusive("errors fall faster than claimed, and no other system confirms it"),
    };
    outcome(setup, &findings, verdict)
}

/// |V(μ_8) − V(μ_0) − ∫ rate dt| of some quantities.
struct Balance<'q>(&'q [Quantity]);

/// The defect, and the size of the terms.
type Defects<T> = Vec<(T, T)>;

impl Balance<'_> {
    fn defects<T: Precision>(&self, view: &View<'_, '_, T>, h: T) -> Result<Defects<T>, StepError> {
        let mut point = view.theory().start();
        let mut points = vec![point.clone()];
        for _ in 0..PANELS {
            point = view.step(&point, h)?;
            points.push(point.clone());
        }
        let defect = |quantity: &Quantity| {
            let no_value = || StepError::Refused { step: h.to_f64(), why: "the energy has no value".into() };
            let values: Option<Vec<_>> = points.iter().map(|p| view.theory().value(*quantity, p)).collect();
            let values = values.ok_or_else(no_value)?;
            let unit = h * T::ratio(4, 14175);
            let (mut change, mut size) = (T::zero(), T::zero());
            for (value, weight) in values.iter().zip(WEIGHTS) {
                change += value.rate * unit * T::int(weight);
                size = size.max(value.size);
            }
            size = size.max(change.abs());
            Ok((values[PANELS].value - values[0].value - change, size.max(T::exact(f64::MIN_POSITIVE))))
        };
        self.0.iter().map(defect).collect()
    }
}

impl Look for Balance<'_> {
    type Output = Result<Findings, StepError>;

    fn look<T: Precision>(&self, view: &View<'_, '_, T>) -> Self::Output {
        let names = self.0.iter().map(|quantity| match quantity {
            Quantity::Energy => "energy".to_owned(),
            Quantity::Casimir(k) => format!("Casimir {}", k + 1),
        });
        let relative = |defects: Defects<T>| defects.iter().map(|(d, s)| (d.abs() / *s).to_f64()).fold(0.0, f64::max);
        let first = coarse(view.theory().step(), |h| Ok(relative(self.defects(view, h)?)))?;
        let noise = view.noise(PANELS);
        descend(names.collect(), &sizes(first), PANELS, |_, h| {
            let defects = self.defects(view, h)?;
            Ok(defects.iter().map(|(d, size)| reading(d.abs(), *size, noise, T::zero())).collect())
        })
    }
}

/// The same to round-off, at the step of the case.
#[derive(Clone, Copy)]
struct Kept<'q>(&'q [Quantity]);

impl Look for Kept<'_> {
    type Output = Measured;

    fn look<T: Precision>(&self, view: &View<'_, '_, T>) -> Measured {
        let n = view.theory().start().momentum.len();
        let defects = match Balance(self.0).defects(view, view.theory().step()) {
            Ok(defects) => defects,
            Err(error) => return refused(&error),
        };
        let floor = view.floor((32 * n * n * PANELS) as f64);
        let judged = defects.iter().zip(self.0).map(|((defect, size), quantity)| {
            Measured::defect(defect.abs(), *size, floor, || {
                let (defect, size) = (defect.to_f64(), size.to_f64());
                format!("{quantity:?} changed by {defect:.3e} in {PANELS} steps, its terms are of size {size:.3e}")
            })
        });
        judged.reduce(Measured::and).unwrap_or(Measured::NotApplicable("nothing to keep".into()))
    }
}

fn balance(setup: &Setup<'_>, claims: &Claims, quantities: &[Quantity], kept: bool) -> Outcome {
    if kept && setup.double.theory.is_free() {
        return setup.settle(Kept(quantities), claims.tolerance).into();
    }
    let order = claims.least_order();
    if order > HIGHEST {
        return Verdict::inconclusive("the quadrature of the work is of order 9").into();
    }
    match setup.sharp(Balance(quantities), claims.tolerance) {
        Ok(findings) => {
            tell(setup, &findings, order, ", balance over eight steps");
            at_least(setup, &findings, order)
        }
        Err(error) => without(&error).into(),
    }
}

/// C(μ_n) − C(μ_0) − ∫⟨f, C'⟩dt.
pub(super) fn casimirs(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    let known: Vec<Quantity> = (0..setup.double.theory.casimirs()).map(Quantity::Casimir).collect();
    if known.is_empty() {
        return Verdict::not_applicable("no Casimir of the algebra is known").into();
    }
    balance(setup, claims, &known, claims.casimirs)
}

/// E(μ_n) − E(μ_0) − ∫⟨f, η⟩dt.
pub(super) fn energy(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    balance(setup, claims, &[Quantity::Energy], claims.energy)
}

/// Φ_{−h}∘Φ_h − 1.
struct ForthAndBack;

impl ForthAndBack {
    fn defects<T: Precision>(&self, view: &View<'_, '_, T>, h: T) -> Result<Defects<T>, StepError> {
        let start = view.theory().start();
        let back = view.step(&view.step(&start, h)?, -h)?;
        let momentum = difference(&back.momentum, &start.momentum);
        let attitude = difference(&back.attitude, &start.attitude);
        let parts = if start.attitude.is_empty() { 1 } else { 2 };
        Ok([momentum, attitude].into_iter().take(parts).collect())
    }
}

impl Look for ForthAndBack {
    type Output = Result<Findings, StepError>;

    fn look<T: Precision>(&self, view: &View<'_, '_, T>) -> Self::Output {
        let relative = |defects: Defects<T>| {
            let one = |(d, s): &(T, T)| if *d == T::zero() { 0.0 } else { (*d / *s).to_f64() };
            defects.iter().map(one).fold(0.0, f64::max)
        };
        let first = coarse(view.theory().step(), |h| Ok(relative(self.defects(view, h)?)))?;
        let parts = if view.theory().start().attitude.is_empty() { 1 } else { 2 };
        let names = ["momentum", "attitude"].into_iter().take(parts).map(str::to_owned).collect();
        let noise = view.noise(2);
        descend(names, &sizes(first), 1, |_, h| {
            let defects = self.defects(view, h)?;
            Ok(defects.iter().map(|(d, size)| reading(*d, *size, noise, T::zero())).collect())
        })
    }
}

/// Φ_{−h}∘Φ_h = 1 + O(h^{p+1}).
pub(super) fn reversibility(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    match setup.sharp(ForthAndBack, claims.tolerance) {
        Ok(findings) => {
            tell(setup, &findings, claims.least_order(), ", after a step forth and back");
            at_least(setup, &findings, claims.least_order())
        }
        Err(error) => without(&error).into(),
    }
}
