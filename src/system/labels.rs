//! What a case is an example of: the labels by which coverage is counted.

use super::case::{Algebra, Case, Force as Term, Inertia, Lagrangian as Energy, Motion, Structure};
use super::dispatch::{System, Visitor};
use super::rates::Rates;
use crate::algebra::catalogue::Entry;
use crate::algebra::known;
use crate::integrators::{OneStep, Solver};
use crate::scalar::Number;
use crate::tableau::{Description, Family};
use std::collections::BTreeSet;

/// Whether all brackets vanish, from the description alone.
pub(super) fn abelian(algebra: &Algebra) -> bool {
    fn entry_is(entry: &Entry) -> bool {
        match entry {
            Entry::Abelian(_) => true,
            Entry::Product(factors) => factors.iter().all(entry_is),
            _ => false,
        }
    }
    match &algebra.structure {
        Structure::Named(entry) => entry_is(entry),
        Structure::Matrices { algebra, .. } => algebra.is_abelian(),
        Structure::Given { abelian, .. } => *abelian,
        Structure::Constants { constants, .. } => constants.iter().all(|k| k.value == Number::default()),
    }
}

/// The name of the algebra in counts: ℝⁿ, products and algebras by constants are one kind each.
fn kind(algebra: &Algebra) -> String {
    match &algebra.structure {
        Structure::Named(Entry::Abelian(_)) => "rn".into(),
        Structure::Named(Entry::Product(_)) => "product".into(),
        Structure::Named(entry) => entry.to_string(),
        Structure::Matrices { family: Some(family), .. } => family.to_string(),
        Structure::Matrices { family: None, algebra } if known::name_of(algebra).is_some() => "known".into(),
        Structure::Matrices { family: None, .. } => "matrices".into(),
        Structure::Constants { .. } => "constants".into(),
        Structure::Given { .. } => "given".into(),
    }
}

/// Which iteration solves the step of the case.
struct Solved;

impl Visitor<f64> for Solved {
    type Output = &'static str;

    fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> Self::Output {
        let (mut state, mut method) = (system.state.clone(), system.scheme());
        match method.step(&mut state, system.step).map(|report| report.solver) {
            Ok(Solver::Newton) => "newton",
            Ok(Solver::Continuation) => "continuation",
            Ok(_) => "fixed-point",
            Err(_) => "refused",
        }
    }
}

/// Label names and values; `force` occurs once for each kind of term, or once as `none`, `potential` once for each kind.
pub fn labels(case: &Case) -> Vec<(&'static str, String)> {
    let mut labels = vec![("algebra", kind(&case.algebra)), ("dimension", case.dimension().to_string())];
    let invariants = case.algebra.structure.invariants();
    if let Some(invariants) = &invariants {
        labels.push(("class", invariants.class().to_string()));
        labels.push(("unimodular", if invariants.unimodular { "yes" } else { "no" }.into()));
    }
    let listed = !invariants.is_some_and(|invariants| invariants.is_unlisted());
    labels.push(("catalogue", if listed { "listed" } else { "unlisted" }.into()));
    labels.push(("basis", if case.algebra.basis.is_some() { "changed" } else { "standard" }.into()));
    labels.push(("inertia", inertia(&case.lagrangian).into()));
    labels.push(("lagrangian", lagrangian(&case.lagrangian).into()));
    let forces: BTreeSet<&str> = case.forces.iter().map(|force| force.kind()).collect();
    if forces.is_empty() {
        labels.push(("force", "none".into()));
    }
    labels.extend(forces.into_iter().map(|kind| ("force", kind.to_string())));
    let potentials: BTreeSet<&str> = case.potentials.iter().map(|potential| potential.kind()).collect();
    labels.extend(potentials.into_iter().map(|kind| ("potential", kind.to_string())));
    let rates = Rates::of(case);
    labels.push(("angle", angle(case, rates.as_ref()).into()));
    let composed = !case.method.argument.is_empty();
    labels.push(("retraction", if composed { "composed" } else { case.method.retraction.name() }.into()));
    labels.push(("start", start(case).into()));
    labels.push(("step", step(case, rates.as_ref()).into()));
    if let Ok(solver) = case.dispatch::<f64, _>(Solved) {
        labels.push(("solver", solver.into()));
    }
    labels.push(("tableau", tableau_kind(&case.method.tableau).into()));
    labels
}

/// What l has beside ½⟨Iη, η⟩: `quadratic` (nothing), `quartic` (¼ κ ⟨Iη, η⟩²), `metric` (a quartic term in a metric of its own),
/// `gyrostat` (⟨b, η⟩), `gyrostat-quartic`.
fn lagrangian(lagrangian: &Energy) -> &'static str {
    match (&lagrangian.gyrostat, &lagrangian.quartic, &lagrangian.metric) {
        (None, None, _) => "quadratic",
        (None, Some(_), None) => "quartic",
        (None, Some(_), Some(_)) => "metric",
        (Some(_), None, _) => "gyrostat",
        (Some(_), Some(_), _) => "gyrostat-quartic",
    }
}

/// `indefinite` (it may be), `unit`, `thin` (one moment at most a sixteenth of the largest), `nearly-unit` (equal to a hundredth),
/// `diagonal`, `full`.
fn inertia(lagrangian: &Energy) -> &'static str {
    if lagrangian.indefinite {
        return "indefinite";
    }
    let Inertia::Diagonal(list) = &lagrangian.inertia else { return "full" };
    let moments = list.iter().map(|x| x.eval::<f64>().unwrap_or(f64::NAN).abs());
    let (least, most) = moments.fold((f64::INFINITY, 0.0_f64), |(a, b), x| (a.min(x), b.max(x)));
    if list.iter().all(|x| *x == Number::from(1)) {
        "unit"
    } else if 16.0 * least <= most {
        "thin"
    } else if list.len() > 1 && most - least <= 0.01 * most {
        "nearly-unit"
    } else {
        "diagonal"
    }
}

/// `rest`; `turning` (a constant force takes the momentum through 0 within the step); `moving`.
fn start(case: &Case) -> &'static str {
    let values = |list: &[Number]| list.iter().map(|v| v.eval().unwrap_or(f64::NAN)).collect::<Vec<f64>>();
    let (Motion::Velocity(motion) | Motion::Momentum(motion)) = &case.start.motion;
    if motion.iter().all(|v| *v == Number::default()) {
        return "rest";
    }
    let half = case.step.eval().unwrap_or(f64::NAN) / 2.0;
    match (&case.start.motion, case.forces.as_slice()) {
        (Motion::Momentum(momentum), [Term::Constant { value }])
            if values(momentum).iter().zip(values(value)).all(|(m, f)| m + f * half == 0.0) =>
        {
            "turning"
        }
        _ => "moving",
    }
}

/// `negative`; `large` (more than what is small for the motion); `usual`.
fn step(case: &Case, rates: Option<&Rates>) -> &'static str {
    match case.step.eval::<f64>() {
        Ok(h) if h < 0.0 => "negative",
        Ok(h) if rates.is_some_and(|rates| rates.step_stiffness(h) > super::rates::MOST) => "large",
        _ => "usual",
    }
}

/// How far the attitude turns: `none` (g = e), `tiny` (below 2⁻⁸), `moderate`, `near-pi` (π by an eighth at most: τ⁻¹ is
/// nearly singular).
fn angle(case: &Case, rates: Option<&Rates>) -> &'static str {
    if case.start.attitude.is_none() {
        return "none";
    }
    let angle = rates.map_or(0.0, |rates| rates.angle(case.method.retraction));
    let tiny = |x: &Number| x.eval::<f64>().is_ok_and(|x| x.abs() < 1.0 / 256.0);
    if case.start.attitude.iter().flatten().all(tiny) {
        "tiny"
    } else if (angle - std::f64::consts::PI).abs() <= std::f64::consts::PI / 8.0 {
        "near-pi"
    } else {
        "moderate"
    }
}

/// `gauss`, `lobatto`, `radau` or `classic` for named tableaux, the shape of the others by their entries.
fn tableau_kind(tableau: &Description) -> &'static str {
    match tableau {
        Description::Family(Family::Gauss, _) => "gauss",
        Description::Family(Family::RadauIA | Family::RadauIIA, _) => "radau",
        Description::Family(_, _) => "lobatto",
        Description::Classic(_) => "classic",
        Description::Entries(_) => tableau.kind(),
    }
}
