//! The step size: how long the next step is, from the estimated error of the last.

use super::error::SolveError;
use crate::integrators::StepError;
use crate::scalar::Real;

/// What rounding makes of the difference of two results, in units of round-off: an error below this is none.
pub(super) const NOISE: i64 = 32;

/// The error of the next pair is aimed at this share of what it may be: room for a motion that changes from pair to pair. A refused
/// pair costs three steps.
pub(super) const AIM: f64 = 0.5;

/// The most that a step grows from one to the next: estimates from steps far too short are rounding.
const GROWTH: f64 = 4.0;

/// The least factor after an error too large.
const LEAST_AFTER_REFUSAL: f64 = 0.2;

/// The largest factor after an error too large.
const MOST_AFTER_REFUSAL: f64 = 0.8;

/// The factor after a step that could not be taken (a fold, a domain, no convergence). With ½ the two steps that are tried next
/// lie within the first of those before.
const RETREAT: f64 = 0.5;

/// A step grows by this factor or not at all, so that it stays the same while the motion does.
const WORTHWHILE: f64 = 1.15;

/// After a step whose fixed-point iterations do not contract, steps are at most this share of it, for a while.
const CONTRACTING: f64 = 0.7;

/// By what factor that limit grows with every step whose iterations contract well.
const RECOVERY: f64 = 1.05;

/// Newton's method pays where the steps that contract are this many times shorter than the motion asks for: one Jacobian in dimension n
/// costs some 5n evaluations of the residual, a step by fixed-point iterations 10 to 30.
const NEWTON_PAYS: f64 = 4.0;

/// A pair whose iterations do not contract is tried with steps that are shorter, this many times at most before Newton's method solves it.
const SHORTENINGS: usize = 8;

/// The number of pairs that pass before Newton's method is tried again where its long steps were refused; twice as many after each time.
const PATIENCE: usize = 8;

/// The rate of contraction above which steps do not grow. With a rate r = ch a step costs 1/(h ln(1/r)), least at r = 1/e. The step of
/// 2h has twice the rate of the others and gains fewer digits: together they cost least where its rate is near ½.
const SLOW: f64 = 0.5;

/// The angle ρh of the first pair of steps, where ρ is the rate at which μ and g change: about what the solvers of SO(3) take.
const FIRST_ANGLE: f64 = 1.25;

/// Steps refused one after the other, before a small share of the tolerance is spent on a single step: at a jump of a force the
/// error falls with h only as the share of h does. The estimate is then the difference itself.
pub(super) const JUMP: usize = 3;

/// That share: this number of jumps uses up the tolerance.
pub(super) const JUMPS: i64 = 256;

/// This number of steps of a run that cannot be shorter uses up the tolerance: at jumps where the momentum is so small that the impulse of the least step
/// is more than the share above.
const INDIVISIBLES: i64 = 8;

/// After a pair is refused for its error, steps grow to this share of the angle ρh that it had, and no further: where the error falls like
/// a high power of h, it says little of how far that goes.
const SHARE_AFTER_REFUSAL: f64 = 0.8;

/// By what factor that angle grows with every pair.
const CONFIDENCE: f64 = 1.01;

/// It is no less than this share of [`FIRST_ANGLE`]: shorter steps are those of a low order, of which the error says enough.
const LEAST_SHARE: f64 = 0.5;

/// A step shorter than this many units of round-off of the time is no step.
const LEAST: i64 = 64;

/// The pace of a run is looked at the first number of times in the steps that it may take, and no more often than after the second number of steps.
const LOOKS: usize = 32;
const LEAST_LOOK: usize = 1024;

/// A run is given up early where the steps that are left would lead to no more than this share of its end.
const HOPELESS: f64 = 0.5;

/// What a run took.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Statistics<T> {
    /// Steps taken. They come in pairs of equal size.
    pub steps: usize,
    /// Pairs tried in vain.
    pub rejected: usize,
    /// Fixed-point and Newton iterations of all steps, those of twice the size for the estimates of the error included.
    pub iterations: usize,
    /// The largest relative residual of the stage equations of a step taken.
    pub residual: T,
    /// The sum of the estimated local errors of the momentum, the velocity and the displacement, each relative to the size of its block of coordinates;
    /// and of what residuals and rounding make of them.
    pub error: T,
}

impl<T: Real> Statistics<T> {
    pub(super) fn none() -> Self {
        Self { steps: 0, rejected: 0, iterations: 0, residual: T::zero(), error: T::zero() }
    }
}

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
    /// The size up to which fixed-point iterations contract well, as far as is known.
    contracting: T,
    /// The size of the steps that the motion asks for.
    natural: T,
    /// Pairs to go before Newton's method is tried again, and how many after the next time.
    wait: usize,
    patience: usize,
    refused: usize,
    /// Pairs whose iterations did not contract, one after the other.
    shortened: usize,
    /// Up to this share of `natural` steps grow, after one was refused.
    share: Option<f64>,
    /// The step cannot be shorter, and may use up a share of the tolerance by itself.
    indivisible: bool,
    /// How many such steps there were.
    indivisibles: i64,
    /// The steps tried and how far the run was when its pace was looked at, and how far it came before that from the time before.
    looked: (usize, T),
    pace: T,
}

/// How the stage equations of a pair were solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Effort {
    /// By fixed-point iterations that contract well.
    Little,
    /// By fixed-point iterations that contract slowly.
    More,
    /// By Newton's method.
    Newton,
}

impl Effort {
    /// That of fixed-point iterations in each of which the residual falls by this factor.
    pub fn of_rate(rate: f64) -> Self {
        if rate > SLOW { Self::More } else { Self::Little }
    }
}

/// A pair of steps that was computed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Attempt<T> {
    /// The estimated error of both steps.
    pub error: T,
    /// What the residuals do not explain of the error.
    pub unexplained: T,
    /// The larger relative residual of the two.
    pub residual: T,
    /// What residuals and rounding make of the error.
    pub noise: T,
    pub effort: Effort,
    /// Rounding makes more of the forces than the error may be: there is no estimate.
    pub rounded: bool,
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
    /// Whether the error is taken to fall like a power of h: not where many steps have been refused.
    pub smooth: bool,
    /// Whether Newton's method solves what fixed-point iterations do not.
    pub newton: bool,
    last: bool,
}

impl<T: Real> Control<T> {
    /// A run from `start` to `end`; the first steps have the size `first`.
    pub fn new(start: T, end: T, tolerance: T, order: usize, first: T, longest: Option<T>) -> Self {
        let span = (end - start).abs();
        let longest = longest.unwrap_or(span);
        let mut control = Self {
            start,
            end,
            span,
            tolerance,
            order: order as i32,
            done: T::zero(),
            next: first,
            longest,
            contracting: T::exact(f64::INFINITY),
            natural: first,
            wait: 0,
            patience: PATIENCE,
            refused: 0,
            shortened: 0,
            share: None,
            indivisible: false,
            indivisibles: 0,
            looked: (0, T::zero()),
            pace: T::zero(),
        };
        if span > T::zero() {
            control.next = first.min(longest).max(control.least());
        }
        control
    }

    /// The size of the first steps where motion has the rate ρ.
    pub fn first(span: T, rate: T) -> T {
        let pair = T::exact(FIRST_ANGLE) / rate;
        (if pair.all_finite() { pair.min(span) } else { span }) * T::half()
    }

    pub fn ended(&self) -> bool {
        self.done >= self.span
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
        let smooth = self.refused < JUMP;
        let newton = self.stiff() || self.shortened >= SHORTENINGS;
        let jump = match (smooth, self.indivisible) {
            (true, _) => T::zero(),
            (false, false) => self.tolerance / T::int(JUMPS),
            (false, true) => self.tolerance / T::int(INDIVISIBLES),
        };
        let allowed = share.max(jump).max(T::int(NOISE) * T::unit_roundoff());
        Plan { step, times: [self.start + self.signed(self.done) + step, end], allowed, smooth, newton, last }
    }

    /// The factor for steps whose error may be `allowed` and was `error`.
    fn factor(&self, allowed: T, error: T) -> f64 {
        let room = AIM * (allowed / error).to_f64();
        // The share of the tolerance grows as h: one power less than the error.
        if room.is_nan() {
            LEAST_AFTER_REFUSAL
        } else {
            room.powf(1.0 / f64::from(self.order)).max(LEAST_AFTER_REFUSAL)
        }
    }

    /// Whether steps that are much longer than fixed-point iterations allow are worth their price.
    fn stiff(&self) -> bool {
        self.wait == 0 && self.contracting * T::exact(NEWTON_PAYS) < self.natural
    }

    /// What a pair of steps of this size says of the size up to which fixed-point iterations contract.
    fn note(&mut self, step: T, effort: Effort) {
        match effort {
            Effort::Little => self.contracting = self.contracting.max(step) * T::exact(RECOVERY),
            Effort::More => self.contracting = self.contracting.min(step),
            Effort::Newton => self.contracting = self.contracting.min(step * T::exact(CONTRACTING)),
        }
    }

    /// `factor` times `step`, or the size up to which the iterations contract.
    fn limited(&self, step: T, factor: f64) -> T {
        let wanted = step * T::exact(factor.min(GROWTH));
        (if self.stiff() { wanted } else { wanted.min(self.contracting) }).min(self.longest)
    }

    /// The pair was taken; from here the motion has the rate ρ.
    pub fn accept(&mut self, plan: &Plan<T>, pair: &Attempt<T>, rate: T) {
        let (step, effort) = (plan.step.abs(), pair.effort);
        self.natural = Self::first(self.span, rate);
        self.wait = self.wait.saturating_sub(1);
        self.done = if plan.last { self.span } else { self.done + step * T::int(2) };
        self.note(step, effort);
        let factor = self.factor(plan.allowed, self.expected(plan, pair));
        // No growth at once after a refusal.
        let factor = if self.refused > 0 { factor.min(1.0) } else { factor };
        (self.refused, self.shortened, self.indivisible) = (0, 0, false);
        let wanted = self.limited(step, factor);
        let wanted = match self.share {
            Some(share) => wanted.min(step.max(self.natural * T::exact(share))),
            None => wanted,
        };
        self.share = self.share.map(|share| share * CONFIDENCE);
        let wanted = if pair.rounded { wanted.min(self.natural.max(step)) } else { wanted };
        // The steps at the end of the run may be short for no other reason than that.
        if plan.last && wanted >= step && step < self.next {
            return;
        }
        let same = step <= wanted && wanted < step * T::exact(WORTHWHILE);
        self.next = if same { step } else { wanted.max(self.least()) };
    }

    /// Whether a pair may be kept.
    pub fn admits(&self, plan: &Plan<T>, pair: &Attempt<T>) -> bool {
        pair.unexplained <= plan.allowed
    }

    /// The error to compute the next step from. Where residuals explain what is above the aim, steps stay as they are; but not with
    /// Newton's method, whose residuals are rounding, of stiff forces.
    fn expected(&self, plan: &Plan<T>, pair: &Attempt<T>) -> T {
        match pair.effort {
            Effort::Newton => pair.unexplained,
            _ => pair.unexplained.max(pair.error.min(plan.allowed * T::exact(AIM))),
        }
    }

    /// Newton's method did not pay.
    fn wait_longer(&mut self) {
        (self.wait, self.patience) = (self.patience, self.patience.saturating_mul(2));
    }

    /// The iterations of the pair do not contract: shorter steps cost less than a Jacobian.
    pub fn shorten(&mut self, plan: &Plan<T>) {
        let step = plan.step.abs();
        self.note(step, Effort::Newton);
        self.shortened += 1;
        self.next = (step * T::exact(CONTRACTING)).max(self.least());
    }

    /// No step is shorter.
    fn least(&self) -> T {
        Self::least_of(self.start + self.signed(self.done), self.span)
    }

    /// The least step at a time of a run over a span.
    pub fn least_of(time: T, span: T) -> T {
        T::int(LEAST) * T::unit_roundoff() * time.abs().max(span)
    }

    /// The pair was refused, with this error or for this reason: the next is shorter.
    pub fn refuse(&mut self, plan: &Plan<T>, outcome: Result<Attempt<T>, StepError>) -> Result<(), SolveError> {
        let (step, time) = (plan.step.abs(), self.start + self.signed(self.done));
        let stiffly = self.stiff();
        self.next = match &outcome {
            Ok(pair) => {
                if self.refused == 0 && pair.effort != Effort::Newton {
                    let share = ((step / self.natural).to_f64() * SHARE_AFTER_REFUSAL).max(LEAST_SHARE);
                    self.share = Some(self.share.map_or(share, |before| before.min(share)));
                }
                self.note(step, pair.effort);
                let factor = self.factor(plan.allowed, pair.unexplained).min(MOST_AFTER_REFUSAL);
                if stiffly && pair.effort == Effort::Newton && factor < RETREAT {
                    self.wait_longer();
                }
                self.limited(step, factor)
            }
            Err(_) => {
                self.note(step, Effort::Newton);
                if stiffly {
                    self.wait_longer();
                }
                step * T::exact(RETREAT)
            }
        };
        self.refused += 1;
        let least = self.least();
        let hopeless = matches!(
            outcome,
            Err(StepError::NotFinite { .. } | StepError::Unsupported { .. } | StepError::Undefined { stage: None, .. })
        );
        if self.next > least && !hopeless {
            return Ok(());
        }
        if outcome.is_ok() && !self.indivisible && self.indivisibles < INDIVISIBLES {
            (self.indivisible, self.refused, self.next) = (true, self.refused.max(JUMP), step.max(least));
            self.indivisibles += 1;
            return Ok(());
        }
        let (time, step) = (time.to_f64(), plan.step.to_f64());
        Err(match outcome {
            Ok(pair) => {
                let (error, wanted) = (pair.unexplained.to_f64(), plan.allowed.to_f64());
                SolveError::Tolerance { time, step, error, wanted }
            }
            Err(source) => SolveError::Stuck { time, step, source },
        })
    }

    /// Begins again with a step of this size, where more is known of what errors are relative to.
    pub fn again(&mut self, step: T) {
        (self.refused, self.shortened, self.indivisible, self.indivisibles) = (0, 0, false, 0);
        self.next = step.abs().max(self.least());
    }

    /// About how many steps the run needs, where the steps that it may take do not lead to its end: as many as since the last look lead as far, and
    /// farther by the factor by which they lead farther than those before.
    pub fn lags(&mut self, statistics: &Statistics<T>, most: usize) -> Option<f64> {
        let (steps, look) = (statistics.steps + 2 * statistics.rejected, (most / LOOKS).max(LEAST_LOOK));
        let (before, done) = self.looked;
        if steps - before < look {
            return None;
        }
        let (passed, left) = (self.done - done, (self.span - self.done).to_f64());
        let pace = std::mem::replace(&mut self.pace, passed);
        self.looked = (steps, self.done);
        let (passed, faster) = (passed.to_f64(), (passed / pace).to_f64());
        if before == 0 || faster.is_nan() {
            return None;
        }
        let looks = most.saturating_sub(steps) as f64 / (steps - before) as f64;
        let reached = match (faster - 1.0).abs() < 1.0 / LOOKS as f64 {
            true => passed * looks,
            false => passed * faster * (faster.powf(looks) - 1.0) / (faster - 1.0),
        };
        (reached < left * HOPELESS).then(|| steps as f64 + left / passed * (steps - before) as f64)
    }

    /// Whether another pair may be tried.
    pub fn within(&self, statistics: &Statistics<T>, most: usize) -> Result<(), SolveError> {
        let steps = statistics.steps + 2 * statistics.rejected;
        // They come in pairs.
        if steps.saturating_add(2) <= most {
            return Ok(());
        }
        let time = (self.start + self.signed(self.done)).to_f64();
        Err(SolveError::TooManySteps { time, step: self.next().to_f64(), steps })
    }
}
