//! Runs with a tolerance instead of a step, as files describe them: when there are rows, and which events are located.

use super::case::Case;
use super::document::{Document, MAX_STEPS};
use super::error::{CaseError, Place};
use super::numbers::{count, number};
use super::scope::Scope;
use crate::expression::Expression;
use crate::integrators::solve::gauss_stages;
use crate::scalar::{Number, Real};
use crate::tableau::{Description, Family};

pub use super::event::{Direction, EventFormula};

/// What stands in a file instead of a step.
#[derive(Clone, Debug, PartialEq)]
pub struct Adaptive {
    /// The relative error that all steps of the run may add.
    pub tolerance: Number,
    /// The largest size of a step, if there is one.
    pub max_step: Option<Number>,
    /// How many steps may be tried, where it is not the default of the solver.
    pub max_steps: Option<u64>,
    /// When there are rows.
    pub times: Times,
    /// What is located.
    pub events: Vec<EventFormula>,
}

/// When a run with a tolerance has rows. One that ends before its horizon has a row of its last state, too.
#[derive(Clone, Debug, PartialEq)]
pub enum Times {
    /// At the start, after every k-th step (k is `every` of the output) and at the end.
    Steps,
    /// At these times, and at no others.
    At(Vec<Number>),
    /// At the start, at times that are so far from each other, and at the end.
    Every(Number),
}

impl Adaptive {
    /// Takes the run with a tolerance out of a document, if there is one, and puts the step and the tableau in that a case has.
    pub(super) fn take(document: &mut Document) -> Result<Option<Self>, CaseError> {
        let run = Place::root().key("run");
        let Some(tolerance) = document.run.tolerance.take() else { return Ok(None) };
        let excess = |place: Place, allowed: &str| Err(place.excess(allowed));
        if document.run.step.is_some() {
            return excess(run.key("tolerance"), "either `step` or `tolerance`, not both");
        }
        if document.run.steps.is_some() {
            return excess(run.key("steps"), "with `tolerance` the length of the run is `horizon`");
        }
        let digits = share(&tolerance, &run.key("tolerance"))?;
        let Some(horizon) = &document.run.horizon else {
            return Err(run.missing("the length of the run", "`horizon` (a duration)"));
        };
        length::<f64>(horizon)?;
        document.run.step = Some(horizon.clone());
        let method = &mut document.method;
        if method.tableau.is_none() && method.a.is_none() && method.b.is_none() && method.c.is_none() {
            method.tableau = Some(Description::Family(Family::Gauss, gauss_stages(digits)).to_string());
        }
        let output = document.output.get_or_insert_default();
        let place = Place::root().key("output");
        let times = match (output.save_at.take(), output.save_every.take()) {
            (None, None) => Times::Steps,
            (Some(_), Some(_)) => return excess(place.key("save_every"), "either `save_at` or `save_every`, not both"),
            (Some(_), _) | (_, Some(_)) if output.every.is_some() => {
                return excess(place.key("every"), "rows at times, or after every n-th step, not both");
            }
            (Some(times), None) => Times::At(times),
            (None, Some(every)) => Times::Every(every),
        };
        Ok(Some(Self {
            tolerance,
            max_step: document.run.max_step.take(),
            max_steps: document
                .run
                .max_steps
                .take()
                .map(|most| count(most, MAX_STEPS, &run.key("max_steps")))
                .transpose()?,
            times,
            events: std::mem::take(&mut document.event),
        }))
    }

    /// Puts it back into a document.
    pub(super) fn put<F>(self, document: &mut Document<F>) {
        (document.run.step, document.run.tolerance) = (None, Some(self.tolerance));
        document.run.max_step = self.max_step;
        document.run.max_steps = self.max_steps.map(|most| most as i64);
        document.event = self.events;
        let output = document.output.get_or_insert_default();
        match self.times {
            Times::Steps => return,
            Times::At(times) => output.save_at = Some(times),
            Times::Every(every) => output.save_every = Some(every),
        }
        output.every = None;
    }

    /// The events as expressions.
    pub(super) fn expressions(&self, case: &Case) -> Result<Vec<Expression>, CaseError> {
        if self.events.is_empty() {
            return Ok(Vec::new());
        }
        let scope = Scope::with_names(case)?;
        let place = Place::root().key("event");
        let read = |(k, event): (usize, &EventFormula)| scope.number(&event.formula, &place.index(k).key("formula"));
        self.events.iter().enumerate().map(read).collect()
    }
}

/// A tolerance in `f64`.
pub(super) fn share(tolerance: &Number, place: &Place) -> Result<f64, CaseError> {
    let value = number::<f64>(tolerance, place)?;
    if value > 0.0 && value < 1.0 {
        return Ok(value);
    }
    Err(place.range(tolerance, "a number between 0 and 1, such as 1e-10"))
}

/// The duration of a run.
pub(super) fn length<T: Real>(duration: &Number) -> Result<T, CaseError> {
    let place = Place::root().key("run").key("horizon");
    let length = number(duration, &place)?;
    if length != T::zero() {
        return Ok(length);
    }
    Err(place.range(duration, "a duration of either sign, not 0"))
}
