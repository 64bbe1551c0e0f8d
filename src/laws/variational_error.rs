//! The variational error theorem, measured: the order of l_d is the order of both flows.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/laws/variational_error.md"))]

use super::CaseLaw;
use super::order::PAIRS;
use super::planted::retraction::{Plant, SECOND_MISSING, SECOND_OF_INVERSE, SECOND_SIGN, SECOND_SWAPPED};
use super::planted::step::{FIRST_STAGE, INVERSE_SECOND, NO_FORCE, NO_SECOND, NOT_TRANSPORTED};
use super::probe::{Probe, stream};
use super::question::law;
use super::step::subject;
use crate::algebra::{Covector, Vector};
use crate::discrete::StageLagrangian;
use crate::discrete::exact::{ExactSolution, Start};
use crate::group::MatrixGroup;
use crate::harness::evidence;
use crate::harness::{Cost, Fault, Verdict};
use crate::integrators::doubled::{Doubled, DoubledState};
use crate::integrators::{OneStep, State, StepError};
use crate::laws::unbuilt;
use crate::mechanics::Lagrangian;
use crate::mechanics::doubled::Forced;
use crate::mechanics::hamiltonian::modified_legendre;
use crate::retraction::Retraction;
use crate::scalar::{Dd, Scalar, larger, max_abs};
use crate::study::least::{self, Answer};
use crate::study::{Findings, Reading, Row, problem, reference};
use crate::system::{Case, Cases, System};
use crate::tableau::random::{TableauKind, of_kind};
use crate::tableau::{Description, Family, variational_order};
use nalgebra::{ComplexField, RealField};
use proptest::strategy::{BoxedStrategy, Strategy, Union};
use std::cmp::Ordering;

/// The laws of this file.
pub const fn laws() -> &'static [CaseLaw] {
    &[law!(Law {
        name: "variational-error",
        statement: "l_d − l_d^e = O(h^{r+1}) along solutions; then the doubled and the restricted flow are of order r",
        source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 5.4",
        oracle: "solutions of the reduced Euler–Lagrange equations and of forced Lie–Poisson by collocation of order 16, \
             with their action; the order r computed from the bicoloured trees",
        bound: "a quarter: half the way to the point that is as near to the next integer; for each of the three numbers",
        needs: "a group; a smooth force; an algebra that is not abelian",
        cost: Cost::Expensive,
        faults: &[
            SECOND_MISSING,
            SECOND_SIGN,
            SECOND_SWAPPED,
            SECOND_OF_INVERSE,
            NO_SECOND,
            INVERSE_SECOND,
            NO_FORCE,
            NOT_TRANSPORTED,
            FIRST_STAGE,
        ],
        cases: generator,
        check: |case, fault| check(case, fault).unwrap_or_else(|verdict| verdict),
    })]
}

/// The families that the theorem is measured on, and random tableaux.
fn generator(cases: Cases) -> Cases {
    let families = [&PAIRS[..], &[(Family::RadauIIA, 2)]].concat();
    let tableaux = tableaux(&families, &RANDOM);
    cases.main_dimensions().forced_nonabelian().smooth().with_group().with_tableaux(tableaux)
}

/// Two of three of these families, the others random of these kinds.
pub(super) fn tableaux(families: &[(Family, usize)], random: &[TableauKind]) -> Union<BoxedStrategy<Description>> {
    let families: Vec<_> = families.iter().map(|&(family, stages)| Description::Family(family, stages)).collect();
    Union::new_weighted(vec![
        (2, proptest::sample::select(families).boxed()),
        (1, proptest::sample::select(random.to_vec()).prop_flat_map(of_kind).boxed()),
    ])
}

/// Random tableaux of orders 1 to 3, symplectic or not.
const RANDOM: [TableauKind; 4] =
    [TableauKind::Collocation, TableauKind::OrderTwo, TableauKind::Full, TableauKind::DiagonallyImplicit];

/// Levels, each with half the step of the one before.
const LEVELS: usize = 6;

/// Relative errors of the doubled step at the coarsest level that the step is changed for, where that of the case shows
/// no order.
const TARGETS: [f64; 3] = [1e-8, 1e-11, 1e-14];

/// How far off the units the doubled motion starts: x in U₀ = τ(x), and ψ₀ − η₀ relative to η₀.
const OFF: (f64, f64) = (1.0 / 16.0, 0.125);

/// What is measured.
const QUANTITIES: [&str; 3] = ["the discrete Lagrangian", "the doubled flow", "the restricted flow"];

/// What each of the quantities shows against the order, and the verdict on it.
type Judged = [(Option<Ordering>, Verdict); 3];

/// As predicted or below decides. Above, the case may be special: then others are asked ([`least`]).
fn check(case: &Case, fault: Option<&Fault>) -> Result<Verdict, Verdict> {
    let mut judged = measure(case, fault)?;
    let mut others: Vec<Judged> = Vec::new();
    for (quantity, (shown, verdict)) in judged.iter_mut().enumerate() {
        if *shown != Some(Ordering::Greater) {
            continue;
        }
        let answer = least::of_others(|k| {
            let asked = k.unsigned_abs() as usize;
            if others.len() < asked {
                let other = problem::other(case, k).map_err(|e| Verdict::broken(e.to_string()))?;
                others.push(measure(&other, fault)?);
            }
            Ok(Some(others[asked - 1][quantity].clone()))
        })?;
        match answer {
            Answer::Decided(_, decided) => *verdict = decided,
            Answer::More => {}
            Answer::Open => *verdict = Verdict::inconclusive(least::UNCONFIRMED),
        }
    }
    Ok(together(&judged))
}

fn together([(_, value), (_, doubled), (_, restricted)]: &Judged) -> Verdict {
    value.clone().and(doubled.clone()).and(restricted.clone())
}

fn measure(case: &Case, fault: Option<&Fault>) -> Result<Judged, Verdict> {
    let system = case.main::<Dd>(&Plant(fault)).map_err(|e| unbuilt(&e))?;
    let order = variational_order(&system.tableau, 8).order as u32;
    let mut probe = Probe::new(case, stream::VARIATIONAL_ERROR);
    let (x, shift) = (probe.vector(), probe.vector());
    Ok(judge(system.step, order, |h| errors(&system, (&x, &shift), h, fault)))
}

/// What the errors show at the case's step, or at one where an order shows.
fn judge(step: Dd, order: u32, mut errors: impl FnMut(Dd) -> Result<Findings, String>) -> Judged {
    let nothing = |why: &str| QUANTITIES.map(|_| (None, Verdict::inconclusive(why)));
    let mut judged = nothing("no step was tried");
    let mut coarsest = None::<f64>;
    let mut measured = None;
    for attempt in 0..=TARGETS.len() {
        let h = match (attempt, coarsest) {
            (0, _) => step,
            (_, None) => step * Dd::exact(0.25f64.powi(attempt as i32)),
            (_, Some(error)) => {
                let stretch: f64 = (TARGETS[attempt - 1] / error).powf(1.0 / f64::from(order + 1));
                step * Dd::exact(2f64.powf(stretch.log2().clamp(-10.0, 2.0).round()))
            }
        };
        judged = match errors(h) {
            Err(why) => nothing(&why),
            Ok(errors) => {
                if attempt == 0 {
                    coarsest = errors.levels(1).first().map(|level| level.error).filter(|e| *e > 1e-27);
                }
                let judged = std::array::from_fn(|quantity| one(&errors, quantity, order));
                measured = Some(errors);
                judged
            }
        };
        if !matches!(together(&judged), Verdict::Inconclusive { .. }) {
            break;
        }
    }
    evidence::note_all(|| {
        let tell = |errors: Findings| (0..3).map(move |k| errors.evidence_of(k, order, 32, ", after one step"));
        measured.into_iter().flat_map(tell)
    });
    judged
}

/// What one of the errors shows against the order of the method, and the verdict on that.
pub(super) fn one(errors: &Findings, quantity: usize, order: u32) -> (Option<Ordering>, Verdict) {
    let (found, verdict) = errors.judge(quantity, order);
    let verdict = match errors.is_exact(quantity) {
        true => Verdict::not_applicable(format!("{} is exact on this motion", errors.quantities()[quantity])),
        false => verdict,
    };
    (found.compare(order), verdict)
}

/// Local errors of these quantities, without levels yet.
pub(super) fn local<const Q: usize>(quantities: [&str; Q]) -> Findings {
    Findings::new(quantities.map(str::to_owned).to_vec(), Q).local()
}

/// The level of one step of size h, with errors of values of these sizes.
pub(super) fn level<const Q: usize>(h: Dd, errors: [(Dd, Dd); Q]) -> Row {
    // Some thousand operations.
    let unit = Dd::unit_roundoff() * Dd::int(4096);
    let reading = |(error, size): (Dd, Dd)| Reading::new(error, unit * size, Dd::exact(0.0));
    Row { steps: 1, h: h.to_f64(), readings: Ok(errors.map(reading).to_vec()) }
}

/// The local errors of steps of size h and smaller.
fn errors<const N: usize, const D: usize>(
    system: &System<Dd, N, D>,
    (x, shift): (&Vector<Dd, N>, &Vector<Dd, N>),
    h: Dd,
    fault: Option<&Fault>,
) -> Result<Findings, String> {
    let tell = |what: &str| format!("{what} could not be computed");
    let steps: Vec<Dd> = (0..LEVELS).rev().map(|k| h / Dd::int(1 << k)).collect();
    let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
    let doubled = Forced::new(l, f, r);
    let eta = l.velocity(&system.state.momentum, &Vector::zeros()).map_err(|_| tell("the velocity"))?;
    let psi = eta + shift * (eta.amax().max(Dd::exact(0.25)) * Dd::exact(OFF.1));
    let u = r.tau(&(x * Dd::exact(OFF.0))).map_err(|_| tell("U₀"))?;
    let start = Start { time: system.state.time, eta, u, psi };
    let exact = ExactSolution::new(doubled, r, 8).map_err(|_| tell("the solution off the units"))?;
    let points = exact.at(&start, &steps).map_err(|_| tell("the solution off the units"))?;
    let begin = modified_legendre(&doubled, &start).map_err(|_| tell("the Legendre transform"))?;
    let restricted = momenta(system, &system.state, &steps).map_err(|_| tell("the solution on the units"))?;
    let mut errors = local(QUANTITIES);
    let mut flow = Doubled::<Dd, _, _, N, D>::new(system.tableau.clone(), r, doubled);
    for (k, step) in steps.iter().enumerate().rev() {
        let point = &points[k];
        let l_d = StageLagrangian::new(doubled, r, system.tableau.clone(), *step).at_time(start.time);
        let stages = l_d.extremise(&point.x, &u, &point.y, None).map_err(|_| tell("l_d"))?;
        let value = l_d.action(&u, &stages).map_err(|_| tell("l_d"))?;
        let terms = step.abs() * (l.value(&point.point.eta).abs() + l.value(&point.point.psi).abs());
        let of_value = ((value - point.action).abs(), terms);

        let (lambda, mu) = (begin.lambda, begin.mu);
        let mut state = DoubledState { time: start.time, lambda, relative: u, mu, attitudes: None };
        flow.step(&mut state, *step).map_err(|_| tell("the doubled step"))?;
        if k == 0 {
            // Far from the units λ and μ may be those of several velocities: of the shortest step the stages say whose.
            let (first, second) = flow.stages();
            let off = |rates: &[Vector<Dd, N>], rate: Vector<Dd, N>| {
                rates.iter().fold(Dd::exact(0.0), |far, one| larger(far, max_abs(&(one - rate))))
            };
            if off(first, eta).max(off(second, psi)) > eta.amax().max(psi.amax()) * Dd::exact(0.25) {
                return Err("the doubled step starts with other velocities of the same momenta".into());
            }
        }
        let end = modified_legendre(&doubled, &point.point).map_err(|_| tell("the Legendre transform"))?;
        let off = larger(max_abs(&(state.lambda - end.lambda)), max_abs(&(state.mu - end.mu)));
        let off = larger(off, max_abs(&(state.relative - point.point.u)) * end.mu.amax());
        let of_doubled = (off, end.lambda.amax() + end.mu.amax());

        let mut state = system.state.clone();
        let mut method = subject(system, fault);
        method.step(&mut state, *step).map_err(|_| tell("the restricted step"))?;
        let of_restricted = (max_abs(&(state.momentum - restricted[k])), restricted[k].amax());
        errors.push(level(*step, [of_value, of_doubled, of_restricted]));
    }
    Ok(errors)
}

/// μ of forced Lie–Poisson at each of the times after a start.
pub(super) fn momenta<const N: usize, const D: usize>(
    system: &System<Dd, N, D>,
    start: &State<Dd, N, D>,
    times: &[Dd],
) -> Result<Vec<Covector<Dd, N>>, StepError> {
    let targets = reference::at(&system.equations(), None::<&MatrixGroup<Dd, N, D>>, start, times, 8)?;
    Ok(targets.iter().map(|target| target.state.momentum).collect())
}
