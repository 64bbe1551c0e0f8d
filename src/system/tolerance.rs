//! Runs with a tolerance in the place of a step, as files describe them: when there are rows, and which events are located.

use super::case::Case;
use super::document::Document;
use super::error::{CaseError, Place, Problem};
use super::file::{Horizon, MAX_STEPS, SystemFile, count};
use super::numbers::number;
use super::scope::Scope;
use super::solution::Plan;
use crate::expression::Expression;
use crate::integrators::solve::gauss_stages;
use crate::scalar::{Number, Real};
use crate::tableau::{Description, Family};
use serde::{Deserialize, Serialize};

/// The least tolerance in 16 digits and in 32. Rounding makes 32 units of round-off of an error that a pair of steps may have:
/// 3.6e-15 and 4e-31. In 32 digits the tableaux of 16 stages set the limit.
const LEAST: [f64; 2] = [1e-14, 1e-26];

/// The most times at which rows are asked for.
const MOST_TIMES: i64 = 10_000_000;

/// Times within so many units of round-off of the end count as the end: decimals are rounded.
const NEAR: i64 = 16;

/// What stands in a file in the place of a step.
///
/// ```
/// use euler_poincare::system::SystemFile;
/// use euler_poincare::system::file::example;
/// use euler_poincare::system::tolerance::{Adaptive, Direction, EventFormula, Times};
///
/// let step = "step = \"1/8\"";
/// let text = example().replacen(step, "tolerance = 1e-10", 1).replacen("every = 1", "save_every = \"1/4\"", 1);
/// let text = format!("{text}\n[[event]]\nformula = \"mu_1\"\ndirection = \"falling\"\n");
/// let adaptive: Adaptive = SystemFile::parse(&text)?.adaptive.expect("a tolerance");
/// assert!(matches!(adaptive.times, Times::Every(_)));
/// let event: &EventFormula = &adaptive.events[0];
/// assert_eq!((event.name(), event.direction, event.terminal), ("mu_1", Some(Direction::Falling), false));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Adaptive {
    /// The relative error that the whole run may make.
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

/// An event: where a formula in the quantities of a system passes zero.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EventFormula {
    /// What it is called; by default its formula.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// The formula, with one value.
    pub formula: String,
    /// In which direction it counts; `None`: in both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub direction: Option<Direction>,
    /// Whether the run ends at the first of them.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub terminal: bool,
}

/// How a function passes zero, in the direction of the run.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// From below.
    Rising,
    /// From above.
    Falling,
}

impl EventFormula {
    /// The name, or the formula.
    pub fn name(&self) -> &str {
        self.name.as_deref().unwrap_or(&self.formula)
    }
}

impl Adaptive {
    /// Takes the run with a tolerance out of a document, if there is one, and puts the step and the tableau in that a case has.
    pub(super) fn take(document: &mut Document) -> Result<Option<Self>, CaseError> {
        let run = Place::root().key("run");
        let Some(tolerance) = document.run.tolerance.take() else { return Ok(None) };
        let excess = |place: Place, allowed: &str| Err(place.error(Problem::Excess { allowed: allowed.into() }));
        if document.run.step.is_some() {
            return excess(run.key("tolerance"), "either `step` or `tolerance`, not both");
        }
        if document.run.steps.is_some() {
            return excess(run.key("steps"), "with `tolerance` the length of the run is `horizon`");
        }
        let digits = share(&tolerance, &run.key("tolerance"))?;
        let Some(horizon) = &document.run.horizon else {
            let (what, allowed) = ("the length of the run".into(), "`horizon` (a duration)".into());
            return Err(run.error(Problem::Missing { what, allowed }));
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
                return excess(place.key("every"), "rows at times, or after every so many steps, not both");
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
    pub(super) fn put(self, document: &mut Document) {
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

/// A tolerance where a step is needed.
pub(super) fn no_steps() -> CaseError {
    let why = "fixed steps are needed here: give `step` in the place of `tolerance`".into();
    Place::root().key("run").key("tolerance").error(Problem::NotApplicable { what: "a tolerance", why })
}

/// What says how long steps are.
const STEP: &str = "`step` (a number that is not 0, such as \"1/8\"); for `integrate` also `tolerance` (such as 1e-10)";

/// The step of a document for fixed steps; what runs with a tolerance have is refused.
pub(super) fn fixed_step(document: &Document) -> Result<Number, CaseError> {
    let (run, output) = (Place::root().key("run"), Place::root().key("output"));
    let without = |place: Place, what| {
        let why = "it is for runs with `tolerance` in the place of `step`".into();
        Err(place.error(Problem::NotApplicable { what, why }))
    };
    if document.run.tolerance.is_some() {
        return Err(no_steps());
    }
    let Some(step) = &document.run.step else {
        return Err(run.error(Problem::Missing { what: "the step".into(), allowed: STEP.into() }));
    };
    if document.run.max_step.is_some() {
        return without(run.key("max_step"), "a largest step");
    }
    if document.run.max_steps.is_some() {
        return without(run.key("max_steps"), "a largest number of steps");
    }
    if !document.event.is_empty() {
        return without(Place::root().key("event").index(0), "an event");
    }
    match &document.output {
        Some(table) if table.save_at.is_some() => without(output.key("save_at"), "`save_at`"),
        Some(table) if table.save_every.is_some() => without(output.key("save_every"), "`save_every`"),
        Some(table) if table.events.is_some() => without(output.key("events"), "a table of events"),
        _ => Ok(step.clone()),
    }
}

/// A tolerance in `f64`.
fn share(tolerance: &Number, place: &Place) -> Result<f64, CaseError> {
    let value = number::<f64>(tolerance, place)?;
    if value > 0.0 && value < 1.0 {
        return Ok(value);
    }
    let (found, allowed) = (tolerance.to_string(), "a number between 0 and 1, such as 1e-10".into());
    Err(place.error(Problem::Range { found, allowed }))
}

/// The duration of a run.
fn length<T: Real>(duration: &Number) -> Result<T, CaseError> {
    let place = Place::root().key("run").key("horizon");
    let length = number(duration, &place)?;
    if length != T::zero() {
        return Ok(length);
    }
    let (found, allowed) = (duration.to_string(), "a duration of either sign, not 0".into());
    Err(place.error(Problem::Range { found, allowed }))
}

impl SystemFile {
    /// The run with a tolerance in `T`; none where the file has a step.
    ///
    /// # Errors
    /// A tolerance that rounding in `T` does not allow; times that are not in order, or outside the run; numbers without a value.
    pub fn solve_plan<T: Real>(&self) -> Result<Option<Plan<T>>, CaseError> {
        let (Some(adaptive), Horizon::Duration(duration)) = (&self.adaptive, &self.horizon) else { return Ok(None) };
        let (run, output) = (Place::root().key("run"), Place::root().key("output"));
        let range = |place: Place, found: &Number, allowed: String| {
            place.error(Problem::Range { found: found.to_string(), allowed })
        };
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
        let times = match &adaptive.times {
            Times::Steps => Vec::new(),
            Times::At(times) => span.at(times, &output.key("save_at"))?,
            Times::Every(every) => span.every(every, &output.key("save_every"))?,
        };
        Ok(Some(Plan {
            tolerance: number(&adaptive.tolerance, &place)?,
            end: span.end,
            max_step: max_step.transpose()?,
            max_steps: adaptive.max_steps,
            every: (adaptive.times == Times::Steps).then_some(self.output.every),
            times,
            ends: !matches!(adaptive.times, Times::At(_)),
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
            let refused = |allowed: String| Err(place.error(Problem::Range { found: number.to_string(), allowed }));
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
            let (what, allowed) = ("a time".into(), "a list of at least one".into());
            return Err(place.error(Problem::Missing { what, allowed }));
        }
        Ok(found)
    }

    /// Equidistant times from the start, and the end.
    fn every(&self, every: &Number, place: &Place) -> Result<Vec<T>, CaseError> {
        let refused = |allowed| Err(place.error(Problem::Range { found: every.to_string(), allowed }));
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
        let times = (0..=count.to_f64() as i64).map(|k| self.snapped(self.start + signed * T::int(k)));
        let mut times: Vec<T> = times.collect();
        if times.last() != Some(&self.end) {
            times.push(self.end);
        }
        Ok(times)
    }
}
