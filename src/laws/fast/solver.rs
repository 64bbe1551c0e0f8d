//! The solvers that choose order and steps for a tolerance.

use super::condition::conditions;
use super::engine::{BodyParts, Group, TERM_MISSING, cayley, group, make_faulty, mix, start, unsupported};
use super::step::{ABOUT, hopeless, settled, step_of, verdict};
use crate::group::departure;
use crate::harness::{About, Cost, Fault, Verdict};
use crate::integrators::lanes::FastRetraction;
use crate::integrators::se3::CayleySe3;
use crate::integrators::solve::{Solve, SolveError, Statistics};
use crate::integrators::{State, StepError};
use crate::laws::CaseLaw;
use crate::laws::method::library::{FAVOURED, SEES_ATTITUDE};
use crate::laws::method::{Point, StateForm, theory_of};
use crate::laws::probe::{Probe, stream};
use crate::retraction::CayleySo3;
use crate::scalar::{Dd, Scalar};
use crate::system::Case;
use crate::system::case::Structure;
use crate::tableau::{Description, Family};

/// The most steps of the case's size that a run takes the time of.
const LONGEST: i32 = 32;

/// How often its steps, at first of the case's size, are halved less one; to what part of the tolerance two of them agree.
const REFINED: i64 = 6;
const AGREED: f64 = 1.0 / 64.0;

/// How much the errors of the steps, as they are estimated, may be off: what the solvers are calibrated to.
const ESTIMATE: f64 = 16.0;

/// By how much a solve may take |gᵀg − 1| above that of its start: sums are compensated.
const OFF_GROUP: f64 = 1e-14;

pub(super) static LAWS: &[CaseLaw] = &[CaseLaw {
    about: About {
        name: "fast-solver",
        statement: "a solver told a tolerance is within it of the solution, forward and backward, and as near to the group as its start to 1e-14",
        source: "the definition of a tolerance; Hairer, Nørsett and Wanner 1993, II.4",
        oracle: "a classical Gauss method of order 16 on the vector field of (μ, g), in 32 digits, with two step sizes that agree",
        bound: "(16 tolerance + 64 u a step)(1 + κ): local errors are estimated to a factor of 16; κ: how much the general engine \
            amplifies small torques, measured",
        cost: Cost::Moderate,
        faults: &[TERM_MISSING, FAVOURED, SEES_ATTITUDE],
        ..ABOUT
    },
    cases: |cases| {
        // The solvers have their own tableaux.
        cases.fast().with_tableaux(proptest::strategy::Just(Description::Family(Family::Gauss, 2)))
    },
    check: |case, fault| settled(tolerance(case, fault)),
}];

/// Where a run ends, and what it took.
type Run = Result<(Point<f64>, Statistics<f64>), SolveError>;

/// Where the solver ends, with all terms of the force or [without the last one](TERM_MISSING); `Err`: there is none for the case.
fn solve(case: &Case, span: f64, tolerance: f64, missing: Option<&Fault>) -> Result<Run, StepError> {
    match group(case)? {
        Group::So3 => on(CayleySo3::new(), BodyParts::<3, 3>::of(case, missing)?, case, span, tolerance),
        Group::Se3 => on(CayleySe3::new(), BodyParts::of(case, missing)?, case, span, tolerance),
        Group::Matrices => on(cayley(case)?, BodyParts::of(case, missing)?, case, span, tolerance),
    }
}

/// The same on a group with some retraction.
fn on<R: FastRetraction<N, D>, const N: usize, const D: usize>(
    retraction: R,
    BodyParts { lagrangian, terms, state, .. }: BodyParts<N, D>,
    case: &Case,
    span: f64,
    tolerance: f64,
) -> Result<Run, StepError> {
    let solution = Solve::in_lanes(lagrangian, terms, retraction).tolerance(tolerance).run(&state, state.time + span);
    let end = |state: &State<f64, N, D>| Point::leading(state, case.dimension(), case.matrix_size());
    Ok(solution.map(|solution| (end(&solution.state), solution.statistics)).map_err(|failure| failure.error))
}

/// How far an attitude is from the group.
fn off_group(case: &Case, attitude: &[f64]) -> f64 {
    let m = attitude.len().isqrt();
    match &case.algebra.structure {
        Structure::Named(entry) => departure(entry, &|r, c| attitude[r * m + c]),
        _ => 0.0,
    }
}

fn tolerance(case: &Case, fault: Option<&Fault>) -> Result<Verdict, StepError> {
    let (start, mut probe) = (start(case)?, Probe::new(case, stream::FAST));
    let tolerance = 10f64.powi(-probe.integer(3, 12));
    let steps = probe.integer(1, LONGEST);
    let back = probe.integer(0, 3) == 0;
    let h = if back { -step_of(case)? } else { step_of(case)? };
    let span = h * f64::from(steps);
    let Ok(conditions) = conditions(case, &start, h, steps as usize) else {
        return Ok(Verdict::inconclusive("the motion runs away: the general engine does not follow it"));
    };
    if let Some(verdict) = hopeless(&conditions) {
        return Ok(verdict);
    }
    let Some(condition) = conditions.last() else { return Ok(Verdict::inconclusive("no time")) };
    let Some(expected) = reference(case, h, steps, tolerance)? else {
        return Ok(Verdict::inconclusive("the reference solution was not reached"));
    };
    let start_off = off_group(case, &start.attitude);
    let refused = |error| Verdict::broken(format!("a tolerance of {tolerance:e} over {span}: {error}"));
    let (mut end, solved) = match solve(case, span, tolerance, None)? {
        Ok(found) => found,
        Err(error) => return Ok(refused(error)),
    };
    if let Some(fault) = fault {
        if fault.name == TERM_MISSING.name {
            match solve(case, span, tolerance, Some(fault))? {
                Ok((wrong, _)) => mix(&mut end.momentum, &wrong.momentum, fault.size),
                Err(error) => return Ok(refused(error)),
            }
        }
        make_faulty(&mut end, &start, span, fault);
    }
    let left = ESTIMATE * tolerance / f64::unit_roundoff();
    let close = verdict(condition.within(solved.steps.max(1), left, &end, &expected), || {
        format!("after {span}, at a tolerance of {tolerance:e}: {solved:?}")
    });
    let off = off_group(case, &end.attitude);
    Ok(close.and(Verdict::judge(off, OFF_GROUP + start_off, || {
        format!("{off:e} off the group after {span}, {start_off:e} at the start: {solved:?}")
    })))
}

/// Where the solution is after `steps` steps of size h: with shorter and shorter steps, as two in a row agree to a part of the
/// tolerance. A force that is not smooth, or nearly not, needs them.
fn reference(case: &Case, h: f64, steps: i32, tolerance: f64) -> Result<Option<Point<f64>>, StepError> {
    let theory = theory_of::<Dd>(case, &StateForm::default()).map_err(unsupported)?;
    let mut last: Option<Point<Dd>> = None;
    for halved in 0..REFINED {
        let count = i64::from(steps) << halved;
        let step = Dd::exact(h) / Dd::int(1 << halved);
        let times: Vec<Dd> = (1..=count).map(|k| step * Dd::int(k)).collect();
        let Ok(solved) = theory.solve(&theory.start(), &times, 0.0, true) else { continue };
        let Some((end, _)) = solved.into_iter().last() else { return Ok(None) };
        let near = |x: &[Dd], y: &[Dd]| {
            let size = y.iter().fold(0.0, |size: f64, v| size.max(v.to_f64().abs()));
            x.iter().zip(y).all(|(x, y)| (*x - *y).to_f64().abs() <= AGREED * tolerance * size)
        };
        let agrees = |last: &Point<Dd>| near(&last.momentum, &end.momentum) && near(&last.attitude, &end.attitude);
        if last.as_ref().is_some_and(agrees) {
            return Ok(Some(end.convert()));
        }
        last = Some(end);
    }
    Ok(None)
}
