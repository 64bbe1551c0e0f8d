//! The step size: how long the next step is, from the estimated error of the last.

use super::error::SolveError;
use super::solution::Statistics;
use crate::integrators::StepError;
use crate::scalar::Real;

/// What rounding makes of the difference of two results, in units of round-off: an error below this is none.
const NOISE: i64 = 32;

/// The error of the next step is aimed at this share of what it may be. With ½ a twentieth of the steps of random systems is
/// refused; with ¾ a fifth, and a refused pair costs three steps.
const AIM: f64 = 0.5;

/// The most that a step grows from one to the next: estimates from steps far too short are rounding.
const GROWTH: f64 = 4.0;

/// The least factor after an error too large.
const SHRINK: f64 = 0.2;

/// The factor after a step that could not be taken (a fold, a domain, no convergence). With ½ the two steps that are tried next
/// lie within the first of those before.
const RETREAT: f64 = 0.5;

/// A step grows by this factor or not at all: steps of equal size start from the stages of the last one.
const WORTHWHILE: f64 = 1.15;

/// The angle ρh of the first pair of steps, where ρ is the rate at which μ and g change: about what the solvers of SO(3) take.
const FIRST_ANGLE: f64 = 1.25;

/// Steps refused one after the other, before a small share of the tolerance is spent on a single step: at a jump of a force the
/// error falls with h only as the share of h does.
const JUMP: usize = 6;

/// That share: so many jumps use up the tolerance.
const JUMPS: i64 = 256;

/// A step shorter than so many units of round-off of the time is no step.
const LEAST: i64 = 64;

/// The times of a run, and the size of its steps; without any Lie theory, so that it is compiled once for a scalar.
#[derive(Clone, Debug)]
pub(super) struct Control<T> {
    start: T,
    end: T,
    /// |end − start|.
    span: T,
    tolerance: T,
    /// p: the difference of one step of 2h and two of h is 2^p − 1 times the error of the latter.
    order: i32,
    /// How far the run is, from 0 to the span.
    done: T,
    /// The size of the next steps, without sign.
    next: T,
    longest: T,
    refused: usize,
}

/// Two steps of equal size that are to be tried.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan<T> {
    /// h, with sign.
    pub step: T,
    /// The time after the first step, and after the second.
    pub times: [T; 2],
    /// The error that both together may make.
    pub allowed: T,
    last: bool,
}

impl<T: Real> Control<T> {
    /// A run from `start` to `end`; the first steps have the size `first`.
    pub fn new(start: T, end: T, tolerance: T, order: usize, first: T, longest: Option<T>) -> Self {
        let span = (end - start).abs();
        let longest = longest.unwrap_or(span);
        let order = order as i32;
        Self { start, end, span, tolerance, order, done: T::zero(), next: first.min(longest), longest, refused: 0 }
    }

    /// The size of the first steps where motion has the rate ρ.
    pub fn first(span: T, rate: T) -> T {
        let pair = T::exact(FIRST_ANGLE) / rate;
        (if pair.all_finite() { pair.min(span) } else { span }) * T::half()
    }

    pub fn ended(&self) -> bool {
        self.done >= self.span
    }

    /// |end − start|.
    pub fn span(&self) -> T {
        self.span
    }

    fn signed(&self, x: T) -> T {
        if self.end < self.start { -x } else { x }
    }

    /// The size of the steps that would come next, with sign.
    pub fn next(&self) -> T {
        self.signed(self.next)
    }

    /// The next pair of steps: the last ones end at the end, the last but these are no longer than half of what is left.
    pub fn plan(&self) -> Plan<T> {
        let (two, left) = (T::int(2), self.span - self.done);
        let last = self.next * two >= left;
        let step = if last { left * T::half() } else { self.next.min(left * T::half() * T::half()) };
        let end = if last { self.end } else { self.start + self.signed(self.done + step * two) };
        let step = self.signed(step);
        let share = self.tolerance * (step * two).abs() / self.span;
        let jump = if self.refused >= JUMP { self.tolerance / T::int(JUMPS) } else { T::zero() };
        let allowed = share.max(jump).max(T::int(NOISE) * T::unit_roundoff());
        Plan { step, times: [self.start + self.signed(self.done) + step, end], allowed, last }
    }

    /// The factor for steps whose error may be `allowed` and was `error`.
    fn factor(&self, allowed: T, error: T) -> f64 {
        let room = AIM * (allowed / error).to_f64();
        // The share of the tolerance grows as h: one power less than the error.
        if room.is_nan() { SHRINK } else { room.powf(1.0 / f64::from(self.order)).clamp(SHRINK, GROWTH) }
    }

    /// The pair was taken.
    pub fn accept(&mut self, plan: &Plan<T>, error: T) {
        let step = plan.step.abs();
        self.done = if plan.last { self.span } else { self.done + step * T::int(2) };
        let factor = self.factor(plan.allowed, error);
        // No growth at once after a refusal; the steps at the end of the run may be short for no other reason than that.
        let factor = if self.refused > 0 { factor.min(1.0) } else { factor };
        self.refused = 0;
        if plan.last && factor >= 1.0 && step < self.next {
            return;
        }
        if !(1.0..WORTHWHILE).contains(&factor) {
            self.next = (step * T::exact(factor)).min(self.longest);
        } else {
            self.next = step;
        }
    }

    /// The pair was refused, with this error or for this reason: the next is shorter.
    pub fn refuse(&mut self, plan: &Plan<T>, outcome: Result<T, StepError>) -> Result<(), SolveError> {
        let (step, time) = (plan.step.abs(), self.start + self.signed(self.done));
        let factor = match &outcome {
            Ok(error) => self.factor(plan.allowed, *error).min(RETREAT.max(0.8)),
            Err(_) => RETREAT,
        };
        self.refused += 1;
        self.next = step * T::exact(factor);
        let least = T::int(LEAST) * T::unit_roundoff() * time.abs().max(self.span);
        let hopeless = matches!(
            outcome,
            Err(StepError::NotFinite { .. } | StepError::Unsupported { .. } | StepError::Undefined { stage: None, .. })
        );
        if self.next > least && !hopeless {
            return Ok(());
        }
        let (time, step) = (time.to_f64(), plan.step.to_f64());
        Err(match outcome {
            Ok(error) => SolveError::Tolerance { time, step, error: error.to_f64(), wanted: plan.allowed.to_f64() },
            Err(source) => SolveError::Stuck { time, step, source },
        })
    }

    /// Whether another pair may be tried.
    pub fn within(&self, statistics: &Statistics<T>, most: usize) -> Result<(), SolveError> {
        let steps = statistics.steps + 2 * statistics.rejected;
        if steps < most {
            return Ok(());
        }
        let time = (self.start + self.signed(self.done)).to_f64();
        Err(SolveError::TooManySteps { time, step: self.next().to_f64(), steps })
    }
}
