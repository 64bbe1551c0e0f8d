//! Defects that fall at the order of the method: errors, drifts, Φ_{−h}∘Φ_h − 1.

use super::kept::{self, Kept};
use super::levels::{Gap, Ladder, Measure, STEPS, Standing, descend, standing};
use super::theory::{names, no_value};
use super::{Claims, Look, Other, Outcome, Point, Precision, Quantity, Setup, View, difference, without};
use crate::harness::Verdict;
use crate::harness::evidence;
use crate::integrators::StepError;
use crate::scalar::{Dd, Real, convert};
use crate::study::least::{self, Answer};
use crate::study::{Comparison, Findings};
use nalgebra::{ComplexField, RealField};
use std::cmp::Ordering;

/// x − y, exact in 32 digits, in the scalar of the method.
fn minus<T: Real>(x: T, y: Dd) -> T {
    convert(convert::<T, Dd>(x) - y)
}

/// A list of numbers against what they must be.
fn gap<T: Real>(mine: &[T], theirs: &[T], from: &[T], error: Vec<T>, noise: T, reference_error: T) -> Gap<T> {
    let size = difference(mine, theirs).1.max(difference(theirs, from).1).max(T::exact(f64::MIN_POSITIVE));
    Gap { error, size, noise: size * noise, reference_error }
}

/// How many parts a state has: without a group, no attitude.
fn parts<T>(point: &Point<T>) -> usize {
    if point.attitude.is_empty() { 1 } else { 2 }
}

/// Notes the errors as evidence.
fn tell(setup: &Setup<'_>, findings: &Findings, order: u32, what: &str) {
    let digits = if setup.quad.is_some() { 32 } else { 16 };
    evidence::note_all(|| findings.evidence(order, digits, what));
}

fn outcome(findings: &Findings, verdict: Verdict) -> Outcome {
    // A line of refusals alone: the reason is theirs.
    let refusal = findings.rows().last().and_then(|row| row.readings.as_ref().err());
    if let (Verdict::Inconclusive { .. }, Some(error)) = (&verdict, refusal) {
        return without(error).into();
    }
    let slope = findings.limiting().ok().map(|(_, estimate)| estimate);
    Outcome { slope, findings: Some(findings.clone()), ..verdict.into() }
}

/// The same of what the levels say.
fn stands(findings: &Findings, standing: Standing) -> Outcome {
    let deciding = standing.deciding();
    Outcome { deciding, ..outcome(findings, standing.verdict()) }
}

/// Whether a claim that the order is at least so much is confirmed, or in 32 digits decided.
fn told<T: Precision>(view: &View<'_, '_, T>, ladder: &Ladder, order: u32) -> bool {
    let confirms = |found| matches!(found, Comparison::Above { .. } | Comparison::As { .. } | Comparison::Exact);
    confirms(ladder.findings.compare(order)) || is_decided(view, ladder, order)
}

/// Whether a claim that the order is at least so much is decided by halved steps alone: in 32 digits, where there are many.
fn is_decided<T: Precision>(view: &View<'_, '_, T>, ladder: &Ladder, order: u32) -> bool {
    view.setup.quad.is_some() && !matches!(ladder.at_least(order), Standing::Open(_))
}

/// At the order or above it holds.
fn at_least(setup: &Setup<'_>, order: u32, what: &str, study: impl Fn(usize) -> Result<Ladder, StepError>) -> Outcome {
    let ladder = match study(0) {
        Ok(ladder) => ladder,
        Err(error) => return without(&error).into(),
    };
    tell(setup, &ladder.findings, order, what);
    stands(&ladder.findings, standing(&ladder, order, study))
}

/// Errors of `STEPS` steps against the solution, for a claim of this order.
struct Errors(u32);

impl<T: Precision> Measure<T> for View<'_, '_, T> {
    fn names(&self) -> Vec<String> {
        self.theory().parts()
    }

    fn needs(&self) -> (bool, bool) {
        (true, parts(&self.start()) > 1)
    }

    fn gaps(&self, h: T, exact: Option<&(Point<Dd>, (Dd, Dd))>) -> Result<Vec<Gap<T>>, StepError> {
        let start = self.start();
        let end = (0..STEPS).try_fold(start.clone(), |point, _| self.step(&point, h))?;
        let Some((exact, reference_error)) = exact else { return Ok(Vec::new()) };
        let noise = self.noise(STEPS);
        let of = |mine: &[T], theirs: &[Dd], from: &[T], reference_error: Dd| {
            let error = mine.iter().zip(theirs).map(|(x, y)| minus(*x, *y)).collect();
            let theirs: Vec<T> = theirs.iter().map(|x| convert(*x)).collect();
            gap(mine, &theirs, from, error, noise, convert(reference_error))
        };
        let momentum = of(&end.momentum, &exact.momentum, &start.momentum, reference_error.0);
        let attitude = of(&end.attitude, &exact.attitude, &start.attitude, reference_error.1);
        Ok([momentum, attitude].into_iter().take(parts(&start)).collect())
    }
}

impl Look for Errors {
    type Output = Result<Ladder, StepError>;

    fn look<T: Precision>(&self, view: &View<'_, '_, T>) -> Self::Output {
        let as_claimed = |found| matches!(found, Comparison::As { .. } | Comparison::Exact);
        let below = |ladder: &Ladder| matches!(ladder.at_least(self.0), Standing::Below { .. });
        let quad = view.setup.quad.is_some();
        descend(view, view, |ladder| as_claimed(ladder.findings.compare(self.0)) || (quad && below(ladder)))
    }
}

/// The order, as claimed or at least 1.
pub(super) fn order(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    let study = |setup: &Setup<'_>, order: u32, from: usize| setup.sharp(&Errors(order), claims.tolerance, from);
    let what = ", after two steps";
    let Some(order) = claims.order else { return at_least(setup, 1, what, |from| study(setup, 1, from)) };
    let ladder = match study(setup, order, 0) {
        Ok(ladder) => ladder,
        Err(error) => return without(&error).into(),
    };
    tell(setup, &ladder.findings, order, what);
    let first = ladder.findings.compare(order);
    if let Comparison::As { .. } = first {
        return outcome(&ladder.findings, first.verdict());
    }
    match standing(&ladder, order, |from| study(setup, order, from)) {
        Standing::Holds(_) => {}
        below_or_open => return stands(&ladder.findings, below_or_open),
    }
    let exact = matches!(first, Comparison::Exact);
    let above = ladder.is_above(order);
    if !above && !exact {
        let why = "the levels do not settle whether the order is higher than claimed";
        return outcome(&ladder.findings, Verdict::inconclusive(why));
    }
    let others = least::of_others(|k| {
        let other = match (setup.others)(Other::Variation(k)) {
            Ok(Some((other, _))) => other,
            Err(error @ StepError::NoAnswer { .. }) => return Err(without(&error)),
            Ok(None) | Err(_) => return Ok(None),
        };
        let found = match study(&other, order, 0) {
            Ok(found) => found,
            Err(error @ StepError::NoAnswer { .. }) => return Err(without(&error)),
            Err(_) => return Ok(None),
        };
        let (shown, verdict) = match found.findings.compare(order) {
            decided @ Comparison::As { .. } => (Some(Ordering::Equal), decided.verdict()),
            _ if found.is_above(order) => (Some(Ordering::Greater), Verdict::inconclusive("")),
            _ => match standing(&found, order, |from| study(&other, order, from)) {
                below @ Standing::Below { .. } => {
                    return Ok(Some((Some(Ordering::Less), stands(&found.findings, below))));
                }
                _ => (None, Verdict::inconclusive("")),
            },
        };
        Ok(Some((shown, outcome(&found.findings, verdict))))
    });
    let verdict = match others {
        Ok(Answer::Decided(k, found)) => {
            // What shows the order says nothing against the system that was asked about.
            let decided_by = found.verdict.is_broken().then_some(Other::Variation(k));
            return Outcome { decided_by, ..found };
        }
        Ok(Answer::More) if above => first.verdict(),
        Ok(_) if exact => Verdict::inconclusive("every error is rounding, on this system and on others"),
        Ok(_) => Verdict::inconclusive(least::UNCONFIRMED),
        Err(no_answer) => no_answer,
    };
    outcome(&ladder.findings, verdict)
}

/// |V(μ_n) − V(μ(t_n))| of some quantities, for a claim of this order.
struct Balance<'q>(&'q [Quantity], u32);

struct Balancing<'v, 's, 'a, 'q, T> {
    view: &'v View<'s, 'a, T>,
    quantities: &'q [Quantity],
}

/// The gaps of the components of the spatial momentum as one.
fn joined<T: Real>(gaps: Vec<Gap<T>>) -> Vec<Gap<T>> {
    let join = |mut all: Gap<T>, gap: Gap<T>| {
        all.error.extend(gap.error);
        let Gap { size, noise, reference_error, .. } = gap;
        let (size, noise) = (all.size.max(size), all.noise.max(noise));
        Gap { size, noise, reference_error: all.reference_error.max(reference_error), ..all }
    };
    gaps.into_iter().reduce(join).into_iter().collect()
}

impl<T: Precision> Measure<T> for Balancing<'_, '_, '_, '_, T> {
    fn names(&self) -> Vec<String> {
        names(self.quantities)
    }

    fn needs(&self) -> (bool, bool) {
        (true, self.quantities.iter().any(|quantity| matches!(quantity, Quantity::Momentum(_))))
    }

    fn gaps(&self, h: T, exact: Option<&(Point<Dd>, (Dd, Dd))>) -> Result<Vec<Gap<T>>, StepError> {
        let start = self.view.start();
        let end = (0..STEPS).try_fold(start.clone(), |point, _| self.view.step(&point, h))?;
        let Some((exact, (reference_error, of_attitude))) = exact else { return Ok(Vec::new()) };
        let known = self.view.setup.known()?;
        let (mine, noise) = (end.convert::<Dd>(), self.view.noise(STEPS));
        let largest = exact.momentum.iter().fold(Dd::exact(0.0), |m, x| m.max(x.abs()));
        let gap = |quantity: &Quantity| {
            let value = |point: &Point<Dd>| known.value(*quantity, point).ok_or_else(|| no_value(h.to_f64()));
            let (found, wanted) = (value(&mine)?, value(exact)?);
            let reach = found.reach.max(wanted.reach).max(found.size).max(wanted.size);
            let reference_error =
                if largest > Dd::exact(0.0) { wanted.reach * *reference_error / largest } else { *reference_error };
            let reference_error = match quantity {
                // g stands in it twice.
                Quantity::Momentum(_) => reference_error + wanted.reach * *of_attitude * Dd::exact(2.0),
                _ => reference_error,
            };
            let size: T = convert(found.size.max(wanted.size).max(Dd::exact(f64::MIN_POSITIVE)));
            let error = vec![convert(found.value - wanted.value)];
            // What the reference does not know is noise: a balance that is better than that is exact as far as can be told.
            let (reference_error, two): (T, T) = (convert(reference_error), T::int(2));
            Ok(Gap { error, size, noise: noise * convert(reach) + two * reference_error, reference_error })
        };
        let gaps: Vec<Gap<T>> = self.quantities.iter().map(gap).collect::<Result<_, _>>()?;
        Ok(if self.needs().1 { joined(gaps) } else { gaps })
    }
}

impl Look for Balance<'_> {
    type Output = Result<Ladder, StepError>;

    fn look<T: Precision>(&self, view: &View<'_, '_, T>) -> Self::Output {
        descend(view, &Balancing { view, quantities: self.0 }, |ladder| told(view, ladder, self.1))
    }
}

/// A balance that closes at the order of the method; `Err`: what there is to say where there is no such quantity.
fn balance(setup: &Setup<'_>, claims: &Claims, quantities: Result<Vec<Quantity>, Verdict>) -> Outcome {
    let quantities = match &quantities {
        Ok(quantities) => quantities,
        Err(verdict) => return verdict.clone().into(),
    };
    let order = claims.least_order();
    at_least(setup, order, ", balance over two steps", |from| {
        setup.sharp(&Balance(quantities, order), claims.tolerance, from)
    })
}

/// Quantities that are kept, if that is claimed and they are constant along the motion: no drift but rounding.
fn conserved(
    setup: &Setup<'_>,
    tolerance: f64,
    (claimed, constant): (bool, bool),
    quantities: Result<Vec<Quantity>, Verdict>,
) -> Outcome {
    match quantities {
        _ if !claimed => Verdict::not_applicable("it is not claimed").into(),
        _ if !constant => Verdict::not_applicable(FORCED).into(),
        Ok(quantities) => kept::judge(setup, Kept::Values(&quantities), tolerance),
        Err(verdict) => verdict.into(),
    }
}

/// Why a case says nothing about a claim of what is conserved.
const FORCED: &str = "the system has a force: this claim is about systems without force";

/// The Casimirs that are known.
fn known_casimirs(setup: &Setup<'_>) -> Result<Vec<Quantity>, Verdict> {
    let known: Vec<Quantity> = (0..setup.double.theory.casimirs()).map(Quantity::Casimir).collect();
    if known.is_empty() { Err(Verdict::not_applicable("no Casimir of the algebra is known")) } else { Ok(known) }
}

/// The components of the spatial momentum.
fn components(setup: &Setup<'_>) -> Result<Vec<Quantity>, Verdict> {
    let start = setup.double.theory.start();
    if setup.double.theory.has_attitude() {
        return Ok((0..start.momentum.len()).map(Quantity::Momentum).collect());
    }
    let why = if start.attitude.is_empty() { "there is no group" } else { "the state has no attitude" };
    Err(Verdict::not_applicable(why))
}

/// C(μ_n) − C(μ_0) − ∫⟨f + ∂_gL, C'⟩dt.
pub(super) fn casimirs(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    balance(setup, claims, known_casimirs(setup))
}

/// C(μ_n) = C(μ_0).
pub(super) fn conserves_casimirs(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    let judged = (claims.casimirs, setup.double.theory.is_free());
    conserved(setup, claims.tolerance, judged, known_casimirs(setup))
}

/// E(μ_n) − E(μ_0) − ∫⟨f, η⟩dt.
pub(super) fn energy(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    balance(setup, claims, Ok(vec![Quantity::Energy]))
}

/// E_n = E_0.
pub(super) fn conserves_energy(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    let judged = (claims.energy, setup.double.theory.keeps_energy());
    conserved(setup, claims.tolerance, judged, Ok(vec![Quantity::Energy]))
}

/// J_n − J_0 − ∫Ad*_{g⁻¹} (f + ∂_gL) dt.
pub(super) fn momentum(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    balance(setup, claims, components(setup))
}

/// J_n = J_0.
pub(super) fn conserves_momentum(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    conserved(setup, claims.tolerance, (claims.momentum, setup.double.theory.is_free()), components(setup))
}

/// D Π(μ) Dᵀ = Π(μ').
pub(super) fn poisson(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    if !claims.poisson {
        return Verdict::not_applicable("it is not claimed").into();
    }
    if !setup.double.theory.is_free() {
        return Verdict::not_applicable(FORCED).into();
    }
    kept::judge(setup, Kept::Bracket, claims.tolerance)
}

/// Equality with the variational scheme.
pub(super) fn variational(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    let Some(method) = &claims.variational else { return Verdict::not_applicable("it is not claimed").into() };
    match (setup.scheme)(method) {
        Ok(scheme) => kept::judge(setup, Kept::Scheme(&scheme, &setup.double.theory.parts()), claims.tolerance),
        Err(error) => without(&error).into(),
    }
}

/// Φ_{−h}∘Φ_h − 1, for a claim of this order.
struct ForthAndBack(u32);

struct Returning<'v, 's, 'a, T>(&'v View<'s, 'a, T>);

impl<T: Precision> Measure<T> for Returning<'_, '_, '_, T> {
    fn names(&self) -> Vec<String> {
        self.0.theory().parts()
    }

    fn needs(&self) -> (bool, bool) {
        (false, false)
    }

    fn gaps(&self, h: T, _: Option<&(Point<Dd>, (Dd, Dd))>) -> Result<Vec<Gap<T>>, StepError> {
        let start = self.0.start();
        let back = self.0.step(&self.0.step(&start, h)?, -h)?;
        let noise = self.0.noise(STEPS);
        let of = |mine: &[T], theirs: &[T]| {
            let error = mine.iter().zip(theirs).map(|(x, y)| *x - *y).collect();
            gap(mine, theirs, theirs, error, noise, T::zero())
        };
        let (momentum, attitude) = (of(&back.momentum, &start.momentum), of(&back.attitude, &start.attitude));
        Ok([momentum, attitude].into_iter().take(parts(&start)).collect())
    }
}

impl Look for ForthAndBack {
    type Output = Result<Ladder, StepError>;

    fn look<T: Precision>(&self, view: &View<'_, '_, T>) -> Self::Output {
        descend(view, &Returning(view), |ladder| told(view, ladder, self.0))
    }
}

/// Φ_{−h}∘Φ_h = 1 + O(h^{p+1}).
pub(super) fn reversibility(setup: &Setup<'_>, claims: &Claims) -> Outcome {
    let order = claims.least_order();
    at_least(setup, order, ", after a step forth and back", |from| {
        setup.sharp(&ForthAndBack(order), claims.tolerance, from)
    })
}
