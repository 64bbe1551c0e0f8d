//! The solver with a tolerance: its results are within the tolerance, at its end and between its steps.

use super::question::{Measured, Problem, Trial, law, stream, tried};
use super::{CaseLaw, Source};
use crate::algebra::{Matrix, Vector};
use crate::harness::{Cost, Fault, Verdict};
use crate::integrators::solve::{Solution, Solve, SolveError};
use crate::integrators::{Classical, OneStep, State, StepError};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::{larger, max_abs};
use crate::study::reference::gauss;
use crate::system::System;

/// A solver that aims at a larger error.
const LOOSE: Fault = Fault::new("loose-run", "the tolerance of the run times 2¹²", "every system that moves");
/// No dense output.
const LINEAR: Fault =
    Fault::new("linear-between", "states between steps by linear interpolation of μ and g", "every system that moves");

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[law!(Law {
            name: "solve-dense",
            statement: "with a tolerance of 10⁻⁴ to 10⁻⁹ the states of a run over four to 32 steps, at its end and at random times, are within \
                            three times the tolerance of the solution",
            source: "Hairer, Nørsett and Wanner 1993, II.4 and II.6",
            oracle: "a classical Gauss method of order 16 on the vector field of (μ, g), with steps that are halved until the states agree to a \
                         sixteenth of the tolerance",
            bound: "3 (1 + κ) times the tolerance, κ the relative change of the solution by a relative change of μ",
            needs: "a group",
            cost: Cost::Moderate,
            faults: &[LOOSE, LINEAR],
            cases: |cases| cases.with_group(),
            check: |case, fault| tried::<f64, S>(case, fault, Dense),
        })]
    }
}

/// The least length of the run, in steps of the case, and how often at most it is doubled: the longer the run, the more the tolerance
/// decides.
const LEAST_STEPS: usize = 4;
const DOUBLED: i32 = 3;

/// Steps of the reference in one of the case, at first and at most: twice as many until the states agree.
const REFERENCE_STEPS: [usize; 2] = [2, 128];

/// The share of the tolerance to which they agree.
const SETTLED: f64 = 1.0 / 16.0;

/// The relative change of μ by which κ is measured.
const CHANGE: f64 = 1.0 / 1_048_576.0;

/// How often the tolerance an error may be.
const ALLOWED: f64 = 3.0;

/// A run against the solution.
#[derive(Clone, Copy)]
struct Dense;

impl Trial<f64> for Dense {
    const STREAM: Option<u64> = Some(stream::SOLVE);

    const LARGE: bool = true;

    const KNOWS_CONFIGURATION: bool = true;

    fn judge<const N: usize, const D: usize>(self, problem: Problem<'_, f64, N, D>) -> Result<Verdict, Measured> {
        let Problem { system, mut probe, fault, .. } = problem;
        let tolerance = 10f64.powi(probe.integer(-9, -4));
        let steps = LEAST_STEPS << probe.integer(0, DOUBLED);
        let span = system.step * steps as f64;
        // Increasing, one in each part of the run, and the end.
        let part = |k: usize, within: f64| (k as f64 + within * 0.96) / LEAST_STEPS as f64;
        let mut times: Vec<f64> = (0..LEAST_STEPS).map(|k| part(k, probe.unit::<f64>().abs())).collect();
        times.push(1.0);
        let times: Vec<f64> = times.into_iter().map(|share| system.state.time + share * span).collect();
        // The error is that of the displacement.
        let start = State { attitude: Matrix::identity(), ..system.state.clone() };
        let moved = State { momentum: start.momentum * (1.0 + CHANGE), ..start.clone() };
        let none = |_| Measured::NotApplicable("the reference leaves its domain or does not converge".into());
        let unsettled = || Measured::Inconclusive("the reference does not settle with shorter steps".into());
        let settled = settled(system, &start, &times, tolerance * SETTLED).map_err(none)?;
        let Settled { states: right, finer } = settled.ok_or_else(unsettled)?;
        let changed = reference(system, &moved, &times, finer).map_err(none)?;
        let aim = tolerance * (1.0 + 4095.0 * LOOSE.size_in(fault));
        let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
        let mut solve = Solve::of(l, f, r).tolerance(aim).save_at(times.clone()).dense();
        let solution = solve.run(&start, start.time + span);
        let solution = solution
            .map_err(|failure| Measured::Inconclusive(format!("the run ended early: {}", reason(&failure.error))))?;
        let linear = LINEAR.size_in(fault);
        let largest =
            |list: &[State<f64, N, D>]| list.iter().fold(start.momentum.amax(), |m, s| m.max(s.momentum.amax()));
        // |f + ∂_gL|.
        let load = |s: &State<f64, N, D>| {
            let g = Configuration::of(&s.attitude);
            let Ok(eta) = l.velocity_at(s.time, g, &s.momentum, &Vector::zeros()) else { return 0.0 };
            (f.force_at(s.time, g, &eta) + l.configuration_gradient(s.time, g, &eta)).amax()
        };
        let push = right.iter().map(load).fold(0.0, f64::max);
        let pair = 2.0 * span.abs() / solution.statistics.steps.max(1) as f64;
        let scale = largest(&right).max(l.gradient(&Vector::zeros()).amax()).max(push * pair);
        let off = |a: &State<f64, N, D>, b: &State<f64, N, D>| {
            let momentum = max_abs(&(a.momentum - b.momentum));
            let momentum = if momentum == 0.0 { 0.0 } else { momentum / scale };
            larger(momentum, max_abs(&(a.attitude - b.attitude)) / b.attitude.amax())
        };
        let (mut defect, mut bound, mut witness) = (0.0, 0.0, String::new());
        for (k, (right, changed)) in right.iter().zip(&changed).enumerate() {
            let bound_here = ALLOWED * (1.0 + off(changed, right) / CHANGE);
            let found = match at(&solution, &start, times[k], span, linear) {
                Some(state) if off(&state, &solution.saved[k]) <= tolerance || linear > 0.0 => state,
                Some(_) => return Ok(Verdict::broken("the saved state is not that of the dense output")),
                None => return Ok(Verdict::broken("no state at a time of the run")),
            };
            let ratio = off(&found, right) / tolerance;
            if k == 0 || ratio / bound_here > defect / bound || !ratio.is_finite() {
                (defect, bound) = (ratio, bound_here);
                witness = format!("at t = {:e} the error is {ratio:e} times the tolerance {tolerance:e}", times[k]);
            }
        }
        Ok(Verdict::judge(defect, bound, || witness))
    }
}

/// Without numbers of the case: reasons are counted.
fn reason(error: &SolveError) -> &'static str {
    match error {
        SolveError::Tolerance { .. } => "the tolerance cannot be kept",
        SolveError::Stuck { .. } | SolveError::Start { .. } => "a step cannot be taken",
        SolveError::TooManySteps { .. } | SolveError::TooSlow { .. } => "too many steps",
        _ => "its input makes no sense",
    }
}

/// The state at a time, by a share of it linear between states an eighth of the run apart.
fn at<const N: usize, const D: usize, R: Retraction<f64, N, D>>(
    solution: &Solution<f64, N, D, R>,
    start: &State<f64, N, D>,
    time: f64,
    span: f64,
    linear: f64,
) -> Option<State<f64, N, D>> {
    let state = solution.at(time).ok()?;
    if linear == 0.0 {
        return Some(state);
    }
    let share = ((time - start.time) / span * 8.0).clamp(0.0, 8.0);
    let (before, after) = (share.floor(), share.floor().min(7.0) + 1.0);
    let ends = [before, after].map(|share| solution.at(start.time + share / 8.0 * span));
    let [Ok(before_state), Ok(after_state)] = ends else { return None };
    let weight = share - before;
    let momentum = before_state.momentum * (1.0 - weight) + after_state.momentum * weight;
    let attitude = before_state.attitude * (1.0 - weight) + after_state.attitude * weight;
    let momentum = state.momentum + (momentum - state.momentum) * linear;
    let attitude = state.attitude + (attitude - state.attitude) * linear;
    Some(State { time, momentum, attitude })
}

/// States of the solution, and how many steps in one of the case they took.
struct Settled<const N: usize, const D: usize> {
    states: Vec<State<f64, N, D>>,
    finer: usize,
}

/// The states at increasing times to this accuracy; `None` where they need too many steps.
fn settled<const N: usize, const D: usize>(
    system: &System<f64, N, D>,
    start: &State<f64, N, D>,
    times: &[f64],
    accuracy: f64,
) -> Result<Option<Settled<N, D>>, StepError> {
    let [mut finer, most] = REFERENCE_STEPS;
    let mut before = reference(system, start, times, finer)?;
    while finer < most {
        finer *= 2;
        let after = reference(system, start, times, finer)?;
        let size = after.iter().fold(start.momentum.amax(), |size, state| size.max(state.momentum.amax()));
        let agree = before.iter().zip(&after).all(|(a, b)| {
            let momentum = max_abs(&(a.momentum - b.momentum)) <= accuracy * size;
            momentum && max_abs(&(a.attitude - b.attitude)) <= accuracy * b.attitude.amax()
        });
        if agree {
            return Ok(Some(Settled { states: after, finer }));
        }
        before = after;
    }
    Ok(None)
}

/// The states at increasing times, with `finer` steps in one of the case.
fn reference<const N: usize, const D: usize>(
    system: &System<f64, N, D>,
    start: &State<f64, N, D>,
    times: &[f64],
    finer: usize,
) -> Result<Vec<State<f64, N, D>>, StepError> {
    let mut method = Classical::new(system.equations(), system.group.clone(), gauss(8)?);
    let mut state = start.clone();
    let advance = |time: &f64| {
        let passed = time - state.time;
        // Halved where less than a step passes, too: one step is not found to agree with itself.
        let steps = (passed / system.step).abs().ceil().max(1.0) * finer as f64;
        for _ in 0..steps as usize {
            method.step(&mut state, passed / steps)?;
        }
        state.time = *time;
        Ok(state.clone())
    };
    times.iter().map(advance).collect()
}
