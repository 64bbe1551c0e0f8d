//! One system from its initial state on with a tolerance, whatever its dimension: rows of plain numbers, and events.

use super::dispatch::{System, Visitor};
use super::error::CaseError;
use super::file::SystemFile;
use super::tolerance::{Direction, EventFormula};
use super::trajectory::{Observer, Rows};
use crate::expression::Expression;
use crate::integrators::State;
use crate::integrators::solve::{Event, Moment, Progress, Solve, SolveError, SolveFailure};
use crate::integrators::variational::Exchange;
use crate::mechanics::formula::{FormulaValue, Quantities};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::Real;
use std::cell::{Cell, RefCell};
use std::ops::ControlFlow;

pub use crate::integrators::solve::{End, Statistics};

/// How far, how exactly, and when there is a row.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan<T> {
    /// The tolerance of the run.
    pub tolerance: T,
    /// The time at the end.
    pub end: T,
    /// The largest size of a step.
    pub max_step: Option<T>,
    /// The steps that may be tried.
    pub max_steps: Option<u64>,
    /// A row after every so many steps.
    pub every: Option<u64>,
    /// Times at which there are rows, in the order of the run.
    pub times: Vec<T>,
    /// Whether the start and the end have rows in any case.
    pub ends: bool,
}

/// How a run with a tolerance ended.
#[derive(Clone, Debug, PartialEq)]
pub struct Solved<T> {
    /// Why.
    pub end: End,
    /// Why, if it is an error. There is a row of the last state reached, but where the velocity of a state was not found.
    pub reason: Option<String>,
    /// When.
    pub time: T,
    /// What it took; nothing is known where the start is refused.
    pub statistics: Option<Statistics<T>>,
}

/// The run, for a system of any dimension.
struct Run<'a, T> {
    plan: Plan<T>,
    events: &'a [EventFormula],
    expressions: &'a [Expression],
    quantities: Quantities,
    observer: &'a mut dyn Observer<T>,
}

/// The run of a file with a tolerance.
pub(super) fn solved<T: Real>(
    file: &SystemFile,
    observer: &mut dyn Observer<T>,
) -> Result<Option<Solved<T>>, CaseError> {
    let (Some(adaptive), Some(plan)) = (&file.adaptive, file.solve_plan()?) else { return Ok(None) };
    let (expressions, quantities) = (adaptive.expressions(&file.case)?, Quantities::of(&file.case));
    let run = Run { plan, events: &adaptive.events, expressions: &expressions, quantities, observer };
    file.case.dispatch(run).map(Some)
}

impl<T: Real> Visitor<T> for Run<'_, T> {
    type Output = Solved<T>;

    fn visit<const N: usize, const D: usize, R: Retraction<T, N, D>, L: Lagrangian<T, N>, F: Force<T, N>>(
        self,
        system: System<T, N, D, R, L, F>,
    ) -> Solved<T> {
        let Self { plan, events, expressions, quantities, observer } = self;
        let System { dimension, lagrangian, force, retraction, tableau, state: start, casimirs, .. } = system;
        let failed = |time, reason| Solved { end: End::Failed, reason: Some(reason), time, statistics: None };
        let taken = Cell::new(Exchange::zero());
        let mut rows = Rows::new((&lagrangian, &casimirs), dimension, quantities.size, &taken);
        // The energy of the start is that of the balance, whether it has a row or not.
        let begins = plan.ends && plan.times.is_empty();
        let shown = if begins { rows.show(&start, observer) } else { rows.look(&start) };
        if let Err(reason) = shown {
            return failed(start.time, reason);
        }
        let undefined = RefCell::new(None);
        // By references, as in `trajectory`: the engine is compiled once for both.
        let mut solve = Solve::of(&lagrangian, &force, &retraction).tolerance(plan.tolerance).tableau(tableau);
        for (event, expression) in events.iter().zip(expressions) {
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
        if let Some(most) = plan.max_steps {
            solve = solve.max_steps(most as usize);
        }
        if let Some(every) = plan.every {
            solve = solve.every(every as usize);
        }
        let (from, span) = (start.time, plan.end - start.time);
        let (mut counted, mut last, mut refused) = (0, begins.then_some(start.time), None);
        let mut solve = solve.save_at(plan.times).follow(|progress: &Progress<'_, T, N, D>| {
            let Progress { moment, state, work, explicit, statistics, .. } = *progress;
            taken.set(Exchange { work, explicit });
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
                    return observer.reached(statistics.steps as u64, ((state.time - from) / span).to_f64());
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
        if refused.is_none() && (plan.ends || solution.end != End::Time) && last != Some(solution.state.time) {
            reason = reason.or(rows.show(&solution.state, observer).err());
        }
        let reason = refused.or(reason);
        let end = if reason.is_some() { End::Failed } else { solution.end };
        Solved { end, reason, time: solution.state.time, statistics: Some(solution.statistics) }
    }
}
