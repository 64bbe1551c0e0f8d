//! A tableau on trial: its order measured on a case, over a horizon and down to round-off, in 16 or 32 digits.

use super::method::Point;
use super::planted::retraction::Plant;
use crate::algebra::Vector;
use crate::harness::Verdict;
use crate::harness::convergence::{Estimate, TOLERANCE};
use crate::integrators::{OneStep, State, StepError};
use crate::mechanics::Lagrangian;
use crate::scalar::{Dd, Real, Scalar, convert};
use crate::study::guard::{Warning, warnings};
use crate::study::least::{self, Answer};
use crate::study::problem::{self, VARIATIONS};
use crate::study::reference::{self, Target};
use crate::study::{Comparison, Findings, StepLevel, Study};
use crate::system::{Case, CaseError, System, Visitor};
use std::convert::Infallible;

/// The arithmetic of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Digits {
    /// `f64`; the reference in 32 digits, and of higher order.
    Sixteen,
    /// Double-double; the reference likewise, of higher order and with more steps.
    ThirtyTwo,
}

impl Digits {
    /// 16 or 32.
    pub fn number(self) -> u32 {
        match self {
            Self::Sixteen => 16,
            Self::ThirtyTwo => 32,
        }
    }

    /// The most steps that all levels of a study over a horizon take together.
    fn budget(self) -> usize {
        match self {
            Self::Sixteen => 1 << 16,
            Self::ThirtyTwo => 1 << 11,
        }
    }

    /// The most levels on the way down to round-off.
    fn levels(self) -> usize {
        match self {
            Self::Sixteen => 16,
            Self::ThirtyTwo => 28,
        }
    }
}

/// Steps of each of the levels that shrink.
const STEPS: usize = 2;

/// An interval of the slope narrower than this, at eight levels or more, needs no finer level.
const NARROW: f64 = 0.05;

/// What a trial found.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Trial {
    /// Errors after the same time, with more and more steps.
    pub horizon: Findings,
    /// Errors after two steps that shrink to where rounding is all that is left; slopes are lowered to the order.
    pub descent: Findings,
    /// What makes the case a poor test.
    pub warnings: Vec<Warning>,
}

/// Why there was no trial.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TrialError {
    /// The case cannot be built.
    #[error("{0}")]
    Case(CaseError),
    /// The reference solution was not reached: the motion is too fast for the horizon.
    #[error("the reference solution over the horizon was not reached: {0}")]
    Reference(StepError),
}

impl Trial {
    /// The trial of a case's tableau and retraction on its system, over `horizon`.
    ///
    /// `order` is what is expected: it decides how accurate a reference is needed, and nothing else.
    ///
    /// # Errors
    /// See [`TrialError`].
    pub fn of(case: &Case, digits: Digits, horizon: f64, order: u32) -> Result<Self, TrialError> {
        // Without a fault: but then the step is the same type as in the laws, and is compiled once.
        case.dispatch_with::<Dd, _>(&Plant(None), &Plan::new(case, digits, horizon, order)).map_err(TrialError::Case)?
    }

    /// How an order compares with both studies: below in one of them is below; else as in one of them is as; above where the
    /// steps that shrink show it (a horizon may be too coarse for a small term) and the horizon does not contradict. The
    /// order of a method is the least that it shows.
    pub fn compare(&self, order: u32) -> Comparison {
        match (self.horizon.compare(order), self.descent.compare(order)) {
            (below @ Comparison::Below { .. }, _) | (_, below @ Comparison::Below { .. }) => below,
            (at @ Comparison::As { .. }, _) | (_, at @ Comparison::As { .. }) => at,
            (_, above @ Comparison::Above { .. }) => above,
            (Comparison::Unknown { why: over }, Comparison::Unknown { why: down }) if over != down => {
                Comparison::Unknown { why: format!("over the horizon, {over}; with shrinking steps, {down}") }
            }
            // Of few digits all may be rounding, where more of them, or a longer run, show an error.
            (Comparison::Unknown { why }, _) | (_, Comparison::Unknown { why }) => Comparison::Unknown { why },
            (over, _) => over,
        }
    }

    /// The slope that decides about an order: the study (`horizon`, `descent`), the part of the state, the estimate.
    pub fn slope(&self, order: u32) -> Option<(&'static str, usize, Estimate)> {
        let decided = self.compare(order);
        let mut studies = [("horizon", &self.horizon), ("descent", &self.descent)];
        // The one that the comparison follows first.
        studies.sort_by_key(|(_, findings)| findings.compare(order) != decided);
        studies.into_iter().find_map(|(name, findings)| {
            let (quantity, estimate) = findings.deciding(order)?;
            Some((name, quantity, estimate))
        })
    }

    /// No levels: the reference was not reached.
    fn none() -> Self {
        let none = || Findings::new(vec!["momentum".into()], 1);
        Self { horizon: none(), descent: none().local(), warnings: Vec::new() }
    }
}

/// What is said where the reference fails.
const NO_REFERENCE: &str = "the reference solution was not reached";

/// A trial, with its verdict on an order.
#[derive(Clone, Debug, PartialEq)]
pub struct Judged {
    /// The trial; without levels if the reference was not reached.
    pub trial: Trial,
    /// `Holds` where the order is as predicted, `Broken` where it is another, else inconclusive with the reason.
    pub verdict: Verdict,
    /// What else was tried, where the case alone did not decide.
    pub explanation: Option<String>,
}

impl Judged {
    /// Whether `order`, or (`at_least`) a higher one, is what the case shows.
    ///
    /// As predicted or below decides; but in 16 digits below stands only if 32 digits do not show the order: rounding of the
    /// data (a large time, an ill-conditioned inertia) can make a plateau that the estimate of the noise does not know.
    /// Above, the case may hide an error, or the order be higher: then variations of the case ([`varied`](problem::varied)) and a body
    /// without symmetry ([`generic`](problem::generic)) are asked ([`least`]). Where one of them shows the order, it is that of the method,
    /// and the case is special.
    ///
    /// # Errors
    /// A case that cannot be built. (A reference that is not reached makes the verdict inconclusive.)
    pub fn of(case: &Case, digits: Digits, horizon: f64, order: u32, at_least: bool) -> Result<Self, CaseError> {
        let trial = match Trial::of(case, digits, horizon, order) {
            Ok(trial) => trial,
            Err(TrialError::Case(error)) => return Err(error),
            Err(error @ TrialError::Reference(_)) => {
                let verdict = Verdict::inconclusive(NO_REFERENCE);
                return Ok(Self { trial: Trial::none(), verdict, explanation: Some(error.to_string()) });
            }
        };
        let first = trial.compare(order);
        let plain = |verdict| Ok(Self { trial: trial.clone(), verdict, explanation: None });
        match first {
            Comparison::Above { .. } if at_least => plain(Verdict::Holds { defect: 0.0, bound: TOLERANCE }),
            Comparison::Above { .. } => Ok(Self::above(case, trial, digits, horizon, order, first)),
            Comparison::Below { .. } if digits == Digits::Sixteen => {
                let more = Trial::of(case, Digits::ThirtyTwo, horizon, order).map(|more| more.compare(order));
                let Ok(Comparison::As { slope, .. }) = more else { return plain(first.verdict()) };
                let verdict = Verdict::inconclusive("the errors in 16 digits are rounding, more than was allowed for");
                let explanation = Some(format!("32 digits show the order: the slope is {slope:.3}"));
                Ok(Self { trial, verdict, explanation })
            }
            decided => plain(decided.verdict()),
        }
    }

    /// The case shows more than the order: what others show ([`least`]).
    fn above(case: &Case, mut trial: Trial, digits: Digits, horizon: f64, order: u32, first: Comparison) -> Self {
        let named = |k: i64| match k {
            least::GENERIC => "a rigid body without symmetry".to_owned(),
            _ => format!("variation {k} of the system"),
        };
        // A variation can be too fast for the horizon; the next one may not be.
        let others = least::of_others(|k| {
            let Ok(other) = problem::other(case, k) else { return Ok(None) };
            let horizon = if k == least::GENERIC { 1.0 } else { horizon };
            let found = Trial::of(&other, digits, horizon, order).map(|found| found.compare(order));
            let found = found.unwrap_or_else(|error| Comparison::Unknown { why: error.to_string() });
            Ok::<_, Infallible>(Some((found.ordering(), found)))
        });
        let Ok(others) = others;
        let (verdict, explanation) = match others {
            Answer::Decided(k, decided @ Comparison::As { slope, .. }) => {
                trial.warnings.push(Warning::SuperConvergence);
                let name = named(k);
                let why = format!(
                    "the system hides the order: errors fall faster on it; {name} shows it: its slope is {slope:.3}"
                );
                (decided.verdict(), why)
            }
            Answer::Decided(k, below) => (below.verdict(), format!("{} shows less than the order", named(k))),
            Answer::More => {
                let why = format!("of {VARIATIONS} variations and a body without symmetry none shows the order");
                (first.verdict(), why)
            }
            Answer::Open => {
                let why = "the order seems higher than predicted: no other system shows it, and too few show more";
                (Verdict::inconclusive(least::UNCONFIRMED), why.to_owned())
            }
        };
        Self { trial, verdict, explanation: Some(explanation) }
    }
}

/// The two studies of a case.
struct Plan<'a> {
    case: &'a Case,
    digits: Digits,
    horizon: f64,
    /// The most steps over the horizon.
    budget: usize,
    /// The levels of steps that shrink.
    levels: Vec<StepLevel<f64>>,
    order: u32,
}

impl<'a> Plan<'a> {
    fn new(case: &'a Case, digits: Digits, horizon: f64, order: u32) -> Self {
        let step = case.step.eval::<f64>().unwrap_or(0.125).abs().min(horizon.abs() / STEPS as f64);
        // A power of two, so that every step is exact in every arithmetic.
        let first = 2f64.powf(step.log2().floor()).copysign(horizon);
        // Large systems have larger steps: a step is s N unknowns.
        let unknowns = case.unknowns().unwrap_or(1);
        let budget = (digits.budget() / unknowns.div_ceil(18)).max(64);
        Self { case, digits, horizon, budget, levels: StepLevel::shrinking(first, STEPS, digits.levels()), order }
    }
}

/// Steps to the horizon are doubled up to here.
const MOST_REFERENCE_STEPS: usize = 1 << 10;

impl Visitor<Dd> for &Plan<'_> {
    type Output = Result<Trial, TrialError>;

    fn visit<const N: usize, const D: usize>(self, system: System<Dd, N, D>) -> Self::Output {
        let targets = self.targets(&system).map_err(TrialError::Reference)?;
        let (horizon, descent) = match self.digits {
            Digits::Sixteen => {
                let system = self.case.system::<f64, N, D>(&Plant(None)).map_err(TrialError::Case)?;
                self.studies(&system, &targets)
            }
            Digits::ThirtyTwo => self.studies(&system, &targets),
        };
        let warnings = warnings(&system.equations(), &system.state, Dd::exact(self.horizon));
        Ok(Trial { horizon, descent, warnings })
    }
}

/// The solution at the horizon, and at the ends of the levels that shrink but for the coarsest, where the reference does not converge.
type Targets<const N: usize, const D: usize> = (Target<Dd, N, D>, Vec<Target<Dd, N, D>>);

impl Plan<'_> {
    fn targets<const N: usize, const D: usize>(&self, system: &System<Dd, N, D>) -> Result<Targets<N, D>, StepError> {
        let body = system.equations();
        let (group, start, duration) = (system.group.as_ref(), &system.state, Dd::exact(self.horizon));
        let stages = 6 + self.order as usize;
        let mut steps = 2;
        let horizon = loop {
            let target = reference::after(&body, group, start, duration, steps, stages);
            let sure = |target: &Target<Dd, N, D>| {
                let wanted = Dd::unit_roundoff() * Dd::exact(1024.0);
                target.reference_error.0 <= wanted * target.state.momentum.amax()
                    && target.reference_error.1 <= wanted * target.state.attitude.amax()
            };
            match target {
                Ok(target) if sure(&target) || steps >= 64 => break target,
                Err(error) if steps >= MOST_REFERENCE_STEPS => return Err(error),
                _ => steps *= 2,
            }
        };
        let times: Vec<Dd> = self.levels.iter().map(|level| Dd::exact(level.duration())).collect();
        // The coarsest may be too large for the reference's iteration, if not for the method's.
        let mut skipped = 0;
        let levels = loop {
            match reference::at(&body, group, start, &times[skipped..], 6 + self.order as usize / 2) {
                Ok(targets) => break targets,
                Err(error) if skipped + 8 >= times.len() => return Err(error),
                Err(_) => skipped += 1,
            }
        };
        Ok((horizon, levels))
    }

    /// Both studies in `T`.
    fn studies<T: Real, const N: usize, const D: usize>(
        &self,
        system: &System<T, N, D>,
        (end, ends): &Targets<N, D>,
    ) -> (Findings, Findings) {
        let (l, method) = (&system.lagrangian, || system.scheme());
        let mut study = Study::new(system.state.clone());
        if system.group.is_some() {
            study = study.with_attitude();
        }
        let energy = |state: &State<T, N, D>| {
            let velocity = l.velocity(&state.momentum, &Vector::zeros()).ok()?;
            Some(l.energy(&velocity))
        };
        study = study.with_function("energy", energy);
        for (k, casimir) in system.casimirs.iter().enumerate() {
            let name = if system.casimirs.len() == 1 { "Casimir".into() } else { format!("Casimir {}", k + 1) };
            study = study.with_function(&name, |state| Some(casimir.value(&state.momentum)));
        }
        let target = |Target { state, reference_error: (momentum, attitude) }: &Target<Dd, N, D>| Target {
            state: Point::of(state, D).convert().state(),
            reference_error: (convert(*momentum), convert(*attitude)),
        };
        let horizon = over_horizon(&study, method, T::exact(self.horizon), &target(end), self.budget);
        let levels = &self.levels[self.levels.len() - ends.len()..];
        let levels: Vec<_> = levels.iter().map(|level| StepLevel { steps: STEPS, h: T::exact(level.h) }).collect();
        let targets: Vec<_> = ends.iter().map(target).collect();
        (horizon, study.descend(method, &levels, &targets).local())
    }
}

/// 1, 2, 4, … steps over the horizon until the slope is known well or rounding is all that is left; then, if that was too
/// coarse to tell, 3, 6, 12, … steps as well. Levels are sorted by their step, the largest first.
fn over_horizon<T: Real, const N: usize, const D: usize, M: OneStep<T, N, D>>(
    study: &Study<'_, T, N, D>,
    mut method: impl FnMut() -> M,
    horizon: T,
    target: &Target<T, N, D>,
    budget: usize,
) -> Findings {
    let mut findings = study.findings();
    let known = |findings: &Findings| match findings.limiting() {
        Ok((_, Estimate::Slope { low, high, .. })) => high - low < NARROW,
        _ => false,
    };
    let mut spent = 0;
    for first in [1, 3] {
        if first == 3 && known(&findings) {
            break;
        }
        let mut quiet = 0;
        let mut steps = first;
        while spent + steps <= budget && quiet < 2 {
            for level in StepLevel::over(horizon, [steps]) {
                let row = study.measure(&mut method(), &level, target);
                quiet = if findings.is_noise(&row) { quiet + 1 } else { 0 };
                findings.push(row);
            }
            (spent, steps) = (spent + steps, 2 * steps);
            if findings.rows().len() >= 8 && known(&findings) {
                break;
            }
        }
    }
    findings.sorted()
}
