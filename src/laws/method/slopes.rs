//! Defects that fall at the order of the method: errors, drifts, Φ_{−h}∘Φ_h − 1.

use super::kept::{self, Kept};
use super::levels::{Ladder, Study, What};
use super::{Claims, Judged, Outcome, Quantity, Setup, without};
use crate::harness::Verdict;
use crate::harness::evidence;
use crate::integrators::StepError;
use crate::study::least::{self, Answer};
use crate::study::{Comparison, Findings};
use std::cmp::Ordering;

/// Notes the errors as evidence.
fn tell(setup: &Setup<'_>, findings: &Findings, order: u32, what: &str) {
    let digits = if setup.quad.is_some() { 32 } else { 16 };
    evidence::note_all(|| findings.evidence(order, digits, what));
}

fn outcome(findings: &Findings, verdict: Verdict) -> Outcome {
    // A line of refusals alone: the reason is theirs.
    let refusal = findings.rows().last().and_then(|row| row.readings.as_ref().err());
    if let (Verdict::Inconclusive { .. }, Some(error)) = (&verdict, refusal) {
        return without(error.clone()).into();
    }
    let slope = findings.limiting().ok().map(|(_, estimate)| estimate);
    Outcome { slope, findings: Some(findings.clone()), ..verdict.into() }
}

/// Whether the order is at least that of a study, by its ladder.
fn stands(setup: &Setup<'_>, claims: &Claims, study: &Study<'_>, first: &Ladder) -> Outcome {
    let (verdict, deciding) = study.at_least(setup, claims.tolerance, first);
    Outcome { deciding, ..outcome(&first.findings, verdict) }
}

/// At the order or above it holds.
fn at_least(setup: &Setup<'_>, claims: &Claims, study: &Study<'_>, what: &str) -> Judged {
    let ladder = study.ladder(setup, claims.tolerance, 0).map_err(without)?;
    tell(setup, &ladder.findings, study.1, what);
    Ok(stands(setup, claims, study, &ladder))
}

/// The order, as claimed or at least 1.
pub(super) fn order(setup: &Setup<'_>, claims: &Claims) -> Judged {
    let what = ", after two steps";
    match claims.order {
        None => at_least(setup, claims, &Study(What::State, 1), what),
        Some(order) => exactly(setup, claims, order, what),
    }
}

/// At the order it holds.
fn exactly(setup: &Setup<'_>, claims: &Claims, order: u32, what: &str) -> Judged {
    let study = Study(What::State, order);
    let found = study.ladder(setup, claims.tolerance, 0).map_err(without)?;
    tell(setup, &found.findings, order, what);
    let first = found.findings.compare(order);
    if let Comparison::As { .. } = first {
        return Ok(outcome(&found.findings, first.verdict()));
    }
    let stood = stands(setup, claims, &study, &found);
    if !stood.verdict.holds() {
        return Ok(stood);
    }
    let exact = matches!(first, Comparison::Exact);
    let above = found.is_above(order);
    if !above && !exact {
        let why = "the levels do not settle whether the order is higher than claimed";
        return Ok(outcome(&found.findings, Verdict::inconclusive(why)));
    }
    let others = least::of_others(|k| {
        let other = (setup.other)(k)
            .and_then(|other| other.map(|other| Ok((study.ladder(&other, claims.tolerance, 0)?, other))).transpose());
        let (found, other) = match other {
            Ok(Some(found)) => found,
            Err(error @ StepError::NoAnswer { .. }) => return Err(error),
            Ok(None) | Err(_) => return Ok(None),
        };
        let compared = found.findings.compare(order);
        Ok(Some(if let Comparison::As { .. } = compared {
            (Some(Ordering::Equal), outcome(&found.findings, compared.verdict()))
        } else if found.is_above(order) {
            (Some(Ordering::Greater), Verdict::inconclusive("").into())
        } else {
            let stood = stands(&other, claims, &study, &found);
            (stood.deciding.map(|_| Ordering::Less), stood)
        }))
    });
    let verdict = match others {
        Ok(Answer::Decided(k, found)) => {
            // What shows the order says nothing against the system that was asked about.
            let decided_by = found.verdict.is_broken().then_some(k);
            return Ok(Outcome { decided_by, ..found });
        }
        Ok(Answer::More) if above => first.verdict(),
        Ok(_) if exact => Verdict::inconclusive("every error is rounding, on this system and on others"),
        Ok(_) => Verdict::inconclusive(least::UNCONFIRMED),
        Err(no_answer) => without(no_answer),
    };
    Ok(outcome(&found.findings, verdict))
}

/// A balance that closes at the order of the method.
pub(super) fn balance(setup: &Setup<'_>, claims: &Claims, quantities: &[Quantity]) -> Judged {
    at_least(setup, claims, &Study(What::Values(quantities), claims.least_order()), ", balance over two steps")
}

/// A claim of what is conserved says nothing about systems where it is not `constant` along the motion.
pub(super) fn unforced(constant: bool) -> Result<(), Verdict> {
    let forced = || Verdict::not_applicable("the system has a force: this claim is about systems without force");
    constant.then_some(()).ok_or_else(forced)
}

/// The Casimirs that are known.
pub(super) fn known_casimirs(setup: &Setup<'_>) -> Result<Vec<Quantity>, Verdict> {
    let (theory, start) = (&setup.theory, setup.theory.start());
    let known = (0..).map(Quantity::Casimir).take_while(|casimir| theory.value(*casimir, &start).is_some());
    let known: Vec<Quantity> = known.collect();
    if known.is_empty() { Err(Verdict::not_applicable("no Casimir of the algebra is known")) } else { Ok(known) }
}

/// The spatial momentum.
pub(super) fn momentum(setup: &Setup<'_>) -> Result<&'static [Quantity], Verdict> {
    let start = setup.theory.start();
    let why = if start.attitude.is_empty() { "there is no group" } else { "the state has no attitude" };
    let known = setup.theory.value(Quantity::Momentum, &start);
    known.map(|_| &[Quantity::Momentum][..]).ok_or_else(|| Verdict::not_applicable(why))
}

/// D Π(μ) Dᵀ = Π(μ').
pub(super) fn poisson(setup: &Setup<'_>, claims: &Claims) -> Judged {
    unforced(setup.theory.is_free())?;
    kept::judge(setup, Kept::Bracket, claims.tolerance)
}

/// Equality with the variational scheme.
pub(super) fn variational(setup: &Setup<'_>, claims: &Claims) -> Judged {
    let method = claims.variational.as_ref().ok_or_else(|| Verdict::not_applicable("it is not claimed"))?;
    let scheme = (setup.scheme)(method).map_err(without)?;
    kept::judge(setup, Kept::Scheme(&scheme, &setup.theory.parts()), claims.tolerance)
}

/// Φ_{−h}∘Φ_h = 1 + O(h^{p+1}).
pub(super) fn reversibility(setup: &Setup<'_>, claims: &Claims) -> Judged {
    at_least(setup, claims, &Study(What::Return, claims.least_order()), ", after a step forth and back")
}
