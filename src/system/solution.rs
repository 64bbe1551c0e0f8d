//! The run of a file: one system from its initial state on, whatever its dimension; with a tolerance also events.

use super::dispatch::{System, Visitor};
use super::error::{CaseError, Place};
use super::event::{Direction, EventFormula};
use super::file::{Horizon, SystemFile};
use super::numbers::number;
use super::tolerance::{Adaptive, Times, length, share};
use super::trajectory::{End, Ended, Observer, Rows, by_steps};
use crate::expression::Expression;
use crate::integrators::State;
use crate::integrators::solve::{Event, Moment, Progress, Solve, SolveError, SolveFailure};
use crate::integrators::variational::Exchange;
use crate::mechanics::formula::{FormulaValue, Quantities};
use crate::scalar::{Number, Real};
use std::cell::RefCell;
use std::ops::ControlFlow;

/// The least tolerance in 16 digits and in 32. Rounding makes 32 units of round-off of an error that a pair of steps may have:
/// 3.6e-15 and 4e-31. In 32 digits the tableaux of 16 stages set the limit.
const LEAST: [f64; 2] = [1e-14, 1e-26];

/// The most times at which rows are asked for.
const MOST_TIMES: i64 = 10_000_000;

/// Times within this many units of round-off of the end count as the end: decimals are rounded.
const NEAR: i64 = 16;

/// How far, how exactly, and at which times there is a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan<T> {
    /// The tolerance of the run.
    pub tolerance: T,
    /// The time at the end.
    pub end: T,
    /// The largest size of a step.
    pub max_step: Option<T>,
    /// Times at which there are rows, in the order of the run; none where there are rows after steps.
    pub times: Vec<T>,
}

impl SystemFile {
    /// The run with a tolerance in `T`; none where the file has a step.
    ///
    /// # Errors
    /// A tolerance that rounding in `T` does not allow; times that are not in order, or outside the run; numbers without a value.
    pub fn solve_plan<T: Real>(&self) -> Result<Option<Plan<T>>, CaseError> {
        let (Some(adaptive), Horizon::Duration(duration)) = (&self.adaptive, &self.horizon) else { return Ok(None) };
        let (run, output) = (Place::root().key("run"), Place::root().key("output"));
        let range = |place: Place, found: &Number, allowed: String| place.range(found, allowed);
        let [double, quad] = LEAST;
        let (least, more) = match T::NAME == f64::NAME {
            true => {
                let more = format!("with scalar = \"dd\" at least {quad:e}");
                (double, format!("{double:e} in 16 digits, as rounding does not allow less; {more}"))
            }
            false => (quad, format!("{quad:e} in 32 digits")),
        };
        let place = run.key("tolerance");
        if share(&adaptive.tolerance, &place)? < least {
            return Err(range(place, &adaptive.tolerance, format!("at least {more}")));
        }
        let length: T = length(duration)?;
        let start: T = number(&self.case.start.time, &Place::root().key("state").key("time"))?;
        let max_step = adaptive.max_step.as_ref().map(|step| {
            let place = run.key("max_step");
            let value: T = number(step, &place)?;
            if value > T::zero() { Ok(value) } else { Err(range(place, step, "a number above 0".into())) }
        });
        let span = Span { start, end: start + length };
        if span.end == start {
            return Err(range(run.key("horizon"), duration, format!("a duration that is seen at t = {start}")));
        }
        let times = match &adaptive.times {
            Times::Steps => Vec::new(),
            Times::At(times) => span.at(times, &output.key("save_at"))?,
            Times::Every(every) => span.every(every, &output.key("save_every"))?,
        };
        Ok(Some(Plan {
            tolerance: number(&adaptive.tolerance, &place)?,
            end: span.end,
            max_step: max_step.transpose()?,
            times,
        }))
    }
}

/// From when to when.
struct Span<T> {
    start: T,
    end: T,
}

impl<T: Real> Span<T> {
    /// The time, or the end if it is next to it.
    fn snapped(&self, time: T) -> T {
        let size = self.start.abs().max(self.end.abs());
        if (time - self.end).abs() <= T::int(NEAR) * T::unit_roundoff() * size { self.end } else { time }
    }

    /// Times in the order of the run, within it.
    fn at(&self, times: &[Number], place: &Place) -> Result<Vec<T>, CaseError> {
        let mut found: Vec<T> = Vec::with_capacity(times.len());
        let forward = self.end > self.start;
        let later = |a: T, b: T| if forward { a > b } else { a < b };
        for (k, number) in times.iter().enumerate() {
            let place = place.index(k);
            let time = self.snapped(super::numbers::number(number, &place)?);
            let refused = |allowed: String| Err(place.range(number, allowed));
            if later(self.start, time) || later(time, self.end) {
                return refused(format!("times of the run, from {} to {}", self.start, self.end));
            }
            if found.last().is_some_and(|before| !later(time, *before)) {
                let order = if forward { "later" } else { "earlier" };
                return refused(format!("times each {order} than the one before"));
            }
            found.push(time);
        }
        if found.is_empty() {
            return Err(place.missing("a time", "a list of at least one"));
        }
        Ok(found)
    }

    /// Equidistant times from the start, and the end.
    fn every(&self, every: &Number, place: &Place) -> Result<Vec<T>, CaseError> {
        let refused = |allowed| Err(place.range(every, allowed));
        let distance: T = number(every, place)?;
        if distance <= T::zero() {
            return refused("a number above 0".into());
        }
        let length = self.end - self.start;
        let count = (length.abs() / distance).floor();
        if !count.all_finite() || count > T::int(MOST_TIMES) {
            return refused(format!(
                "at most {MOST_TIMES} times: a distance of {:e} or more",
                length.abs().to_f64() / MOST_TIMES as f64
            ));
        }
        let signed = if length < T::zero() { -distance } else { distance };
        let times = (0..=count.to_f64() as i64).map(|k| self.start + signed * T::int(k));
        let mut times: Vec<T> = times.collect();
        match times.last_mut() {
            Some(last) if self.snapped(*last) == self.end => *last = self.end,
            _ => times.push(self.end),
        }
        if times.windows(2).any(|pair| pair[0] == pair[1]) {
            return refused(format!("times that are told apart at {}", self.end));
        }
        Ok(times)
    }
}

/// The run of a file, for a system of any dimension.
struct Run<'a, T> {
    file: &'a SystemFile,
    quantities: Quantities,
    observer: &'a mut dyn Observer<T>,
    how: How<'a, T>,
}

enum How<'a, T> {
    Steps((u64, Option<T>)),
    Tolerance(&'a Adaptive, Plan<T>, Vec<Expression>),
}

/// The run of a file.
pub(super) fn run<T: Real>(file: &SystemFile, observer: &mut dyn Observer<T>) -> Result<Ended<T>, CaseError> {
    let how = match (&file.adaptive, file.solve_plan()?) {
        (Some(adaptive), Some(plan)) => How::Tolerance(adaptive, plan, adaptive.expressions(&file.case)?),
        _ => How::Steps(file.plan()?),
    };
    file.case.run(Run { file, quantities: Quantities::of(&file.case), observer, how })
}

impl<T: Real> Visitor<T> for Run<'_, T> {
    type Output = Ended<T>;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Ended<T> {
        let Self { file, quantities, observer, how } = self;
        let (Adaptive { times, events, max_steps, .. }, plan, expressions) = match how {
            How::Steps(steps) => return by_steps(system, steps, file.output.every, quantities.size, observer),
            How::Tolerance(adaptive, plan, expressions) => (adaptive, plan, expressions),
        };
        let System { dimension, lagrangian, force, retraction, tableau, state: start, casimirs, .. } = system;
        let failed = |time, reason| Ended::at(time, End::Failed, Some(reason));
        let mut rows = Rows::new((&lagrangian, &casimirs), dimension, quantities.size);
        // The energy of the start is that of the balance, whether it has a row or not.
        let (begins, ends) = (*times == Times::Steps, !matches!(times, Times::At(_)));
        let shown = if begins { rows.show(&start, observer) } else { rows.look(&start) };
        if let Err(reason) = shown {
            return failed(start.time, reason);
        }
        let undefined = RefCell::new(None);
        // By references, as in `trajectory`: the engine is compiled once for both.
        let mut solve = Solve::of(&lagrangian, &force, &retraction).tolerance(plan.tolerance).tableau(tableau);
        for (event, expression) in events.iter().zip(&expressions) {
            let program = match expression.compile() {
                Ok(program) => program,
                Err(error) => return failed(start.time, format!("event {:?}: {error}", event.name())),
            };
            let (mut function, undefined, lagrangian) =
                (FormulaValue::new(program, quantities), &undefined, &lagrangian);
            let mut located = Event::new(move |state: &State<T, N, D>| {
                let value = function.value(lagrangian, state.time, &state.attitude, &state.momentum);
                value.unwrap_or_else(|reason| {
                    *undefined.borrow_mut() = Some(reason);
                    T::exact(f64::NAN)
                })
            });
            located = match event.direction {
                None => located,
                Some(Direction::Rising) => located.rising(),
                Some(Direction::Falling) => located.falling(),
            };
            solve = solve.event(if event.terminal { located.terminal() } else { located });
        }
        if let Some(step) = plan.max_step {
            solve = solve.max_step(step);
        }
        if let Some(most) = max_steps {
            solve = solve.max_steps(*most as usize);
        }
        if begins {
            solve = solve.every(file.output.every as usize);
        }
        let (from, span) = (start.time, plan.end - start.time);
        let (mut counted, mut last, mut refused) = (0, begins.then_some(start.time), None);
        let mut solve = solve.save_at(plan.times).follow(|progress: &Progress<'_, T, N, D>| {
            let Progress { moment, state, work, explicit, statistics, .. } = *progress;
            rows.taken = Exchange { work, explicit };
            rows.count(progress.residual, statistics.iterations - counted);
            counted = statistics.iterations;
            let outcome = match moment {
                Moment::Saved => {
                    last = Some(state.time);
                    rows.show(state, observer)
                }
                Moment::Event { index, rising } => {
                    rows.look(state).map(|()| observer.event(index, rising, &rows.row()))
                }
                Moment::Step => {
                    return observer.step(statistics.steps as u64, ((state.time - from) / span).to_f64());
                }
            };
            match outcome {
                Ok(()) => ControlFlow::Continue(()),
                Err(reason) => {
                    refused = Some(reason);
                    ControlFlow::Break(())
                }
            }
        });
        let outcome = solve.run(&start, plan.end);
        drop(solve);
        let (solution, mut reason) = match outcome {
            Ok(solution) => (solution, None),
            Err(SolveFailure { error, reached }) => {
                let undefined = undefined.take();
                let said = match error {
                    SolveError::EventValue { index, time, .. } => {
                        let why = undefined.unwrap_or_else(|| "it is not finite".into());
                        let name = events.get(index).map_or("", EventFormula::name);
                        format!("the event {name:?} has no value at t = {time}: {why}")
                    }
                    error => error.to_string(),
                };
                (*reached, Some(said))
            }
        };
        let refused = refused.take();
        if refused.is_none() && (ends || solution.end != End::Time) && last != Some(solution.state.time) {
            reason = reason.or(rows.show(&solution.state, observer).err());
        }
        let reason = refused.or(reason);
        let ended = Ended::at(solution.state.time, solution.end, reason);
        Ended { statistics: Some(solution.statistics), ..ended }
    }
}
