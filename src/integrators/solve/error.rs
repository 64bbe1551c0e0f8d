//! Why a run with a tolerance ends before its time.

use crate::integrators::StepError;
use crate::retraction::RetractionError;
use crate::tableau::TableauError;

/// What makes steps longer.
fn advice(stages: Option<usize>) -> String {
    match stages {
        Some(stages) => {
            format!("What helps is a method of higher order: without a tableau it is Gauss's with {stages} stages")
        }
        None => "What helps is a larger tolerance, a shorter run, or more steps (max_steps)".into(),
    }
}

/// Why a run ended before its time. The state is that of the last step that was taken.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SolveError {
    /// The end, the tolerance, the first or the largest step, or the number of steps between saved states makes no sense.
    #[error("{what} is {value:?}: it must be {needed}")]
    BadInput {
        /// Which.
        what: &'static str,
        /// What it is.
        value: f64,
        /// What it must be.
        needed: &'static str,
    },
    /// The initial state makes no sense, or the equations have no value there.
    #[error("no run from t = {time}: {source}")]
    Start {
        /// Where.
        time: f64,
        /// What is wrong.
        source: StepError,
    },
    /// No step could be taken, however short.
    #[error("no step of {step:e} or longer from t = {time}: {source}")]
    Stuck {
        /// Where.
        time: f64,
        /// The least step that was tried.
        step: f64,
        /// What Newton's method and the continuation in h said of it.
        source: StepError,
    },
    /// The error cannot be kept below the tolerance with steps of a length worth taking.
    #[error(
        "the tolerance cannot be kept at t = {time}: a step of {step:e} has an estimated relative error of {error:e}, \
             wanted {wanted:e}"
    )]
    Tolerance {
        /// Where.
        time: f64,
        /// The least step that was tried.
        step: f64,
        /// Its error, as estimated.
        error: f64,
        /// The error wanted of it.
        wanted: f64,
    },
    /// More steps than allowed: a motion that turns ever faster, or a run much longer than a step can be.
    #[error("{steps} steps, as many as allowed, lead to t = {time} only; the next is {step:e} long")]
    TooManySteps {
        /// Where.
        time: f64,
        /// The step that would have been next.
        step: f64,
        /// How many were tried.
        steps: usize,
    },
    /// The steps allowed would not lead to the end, as far as can be told from those taken: a motion that turns fast.
    #[error(
        "{steps} steps lead to t = {time} only: the run needs about {needed:.1e} of them, and {allowed} are allowed. \
         The motion turns fastest about axis {axis}, at the rate η_{axis} = {rate:e}: by {:.1e} in a step. {}",
        (.rate * .step).abs(), advice(*.stages)
    )]
    TooSlow {
        /// Where.
        time: f64,
        /// The step that would have been next.
        step: f64,
        /// How many were tried.
        steps: usize,
        /// About how many the run needs.
        needed: f64,
        /// How many are allowed.
        allowed: usize,
        /// The coordinate of the velocity that is largest, from 1.
        axis: usize,
        /// Its value.
        rate: f64,
        /// The stages of Gauss's method with which steps would be longer, where the tableau has a lower order.
        stages: Option<usize>,
    },
    /// A time in the list of times to save that no run can reach, or not in this order.
    #[error("time {index} of those to save, t = {time}: {why}")]
    SaveTime {
        /// Its place in the list, from 0.
        index: usize,
        /// The time.
        time: f64,
        /// What is wrong with it.
        why: &'static str,
    },
    /// An event function that is not finite.
    #[error("event {index} has the value {value:?} at t = {time}")]
    EventValue {
        /// Which event, from 0 in the order in which they were added.
        index: usize,
        /// Where.
        time: f64,
        /// The value.
        value: f64,
    },
    /// The family has no tableau with this number of stages, or a tableau has no method.
    #[error("the tableau is refused: {0}")]
    Tableau(#[from] TableauError),
}

/// Why a solution has no state at a time.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DenseError {
    /// The run kept no states between the steps.
    #[error("the run kept nothing between its steps: ask for `dense()`")]
    NotKept,
    /// A time outside the interval of the run, or NaN.
    #[error("t = {time} is outside the run from t = {start} to t = {end}")]
    Outside {
        /// The time asked for.
        time: f64,
        /// Where the run began.
        start: f64,
        /// Where it ended.
        end: f64,
    },
    /// The displacement inside a step is outside the domain of the retraction.
    #[error("no state at t = {time}: {source}")]
    Domain {
        /// The time asked for.
        time: f64,
        /// What the retraction said.
        source: RetractionError,
    },
}
