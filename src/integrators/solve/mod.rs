//! A tolerance in, a solution out: any algebra, group, retraction, force, Lagrangian, scalar and tableau.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/integrators/solve.md"))]

mod control;
mod dense;
mod engine;
mod error;
mod events;
#[cfg(feature = "lanes")]
mod lanes;
mod measure;
mod pair;
mod pairs;
mod passed;
mod smooth;
mod solution;
mod through;

pub use control::Statistics;
#[doc(hidden)]
pub use engine::Engine;
pub use error::{DenseError, SolveError};
pub use events::Event;
#[cfg(feature = "lanes")]
pub use lanes::InLanes;
pub use pairs::Pairs;
pub use solution::{End, Located, Moment, Progress, Solution, SolveFailure};

use super::variational::Exchange;
use super::{State, StepError};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::{Real, larger};
use crate::tableau::{Family, Tableau, TableauError};
use control::Control;
use dense::Piece;
use engine::Task;
use solution::{Dense, Follower};
use std::ops::ControlFlow;
use std::sync::Arc;

/// The tolerance unless another is given.
const TOLERANCE: f64 = 1e-8;

/// The steps that a run may try unless it is told otherwise.
const MOST_STEPS: usize = 1_000_000;

/// Stages of Gauss: for each decimal digit of the tolerance, and besides. The iterations times stages of runs on SO(3),
/// SE(2), SL(2), SO(4) and of a heavy top over times 1, 2 and 10 are then within a fifth of the least for any number of stages at
/// tolerances from 10⁻⁶ to 10⁻¹², and half as much again to twice the least with two stages less.
const STAGES_PER_DIGIT: f64 = 0.5;
const STAGES_BESIDES: usize = 2;

/// The fewest and the most stages of Gauss that are chosen.
const FEWEST_STAGES: usize = 3;
const MOST_STAGES: usize = 16;

/// Where a function is 0 at the start of a step, its sign next to that is the one at this share of the step: far enough for rounding not to
/// decide.
const ASIDE: f64 = 1.0 / 1024.0;

/// An event is located to the tolerance times the step, divided by this.
const LOCATED: i64 = 4;

/// And no closer than to this many units of round-off of the time.
const LOCATED_ROUNDING: i64 = 4;

/// Which tableau: of a family, with the order that the tolerance asks for, or one that is given.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub enum Method<T: Real> {
    /// Of this family.
    Family(Family),
    /// This one.
    Tableau(Tableau<T>),
}

/// Called after each step.
type Observer<'a, T, const N: usize, const D: usize> = dyn FnMut(&State<T, N, D>) -> ControlFlow<()> + 'a;

/// The stages of Gauss for a tolerance.
pub(crate) fn gauss_stages(tolerance: f64) -> usize {
    let digits = -tolerance.max(f64::MIN_POSITIVE).log10();
    ((digits * STAGES_PER_DIGIT).round() as usize + STAGES_BESIDES).clamp(FEWEST_STAGES, MOST_STAGES)
}

/// The solver of a Lagrangian, a force and a retraction, with a tolerance: a builder, from [`Solve::new`] or `Solve::in_lanes`, whose [`run`](Solve::run) gives a [`Solution`].
///
/// **Tolerance.** It is for the whole run from t₀ to t₁: a step of size h may make the error h/|t₁ − t₀| times the tolerance. A motion that is
/// not stable amplifies the errors of its steps. Errors are those of the momentum, of the
/// velocity and of the displacement g₀⁻¹g₁, and each block of coordinates has its own scale: the factors of a product, and in each of them what a
/// change of units multiplies by one factor, as the rotations and the translations of a rigid body. A change of units changes no step. The scale of a momentum is the
/// largest component that the block has had so far, that of a rotor, or the impulse of the forces over the step; that of a velocity what corresponds to it;
/// that of a displacement one radian for angles, else the largest of a pair of steps. Rounding sets a limit: no step is asked for less than
/// 32 units of round-off, of what the momentum is the sum of, nor, near an equilibrium, where forces cancel, for less than changes of the entries of g by as much
/// make of the forces; at rest, where a run would end otherwise, for less than as much of the forces to come. A step
/// over a jump of the force may make 1/256 of the tolerance, however short it is: some hundred jumps use up the tolerance, and
/// [`Statistics::error`] tells.
///
/// **Error**, with [`Solve::new`]. Two steps of h are compared with one of 2h; the two are the result, and the difference divided by 2ᵖ − 1 estimates their
/// error (Hairer, Nørsett and Wanner 1993, II.4), doubled for safety. p is proven from the coefficients of the tableau, and taken for less where
/// halving the step does not make what s stages miss of the velocities at its ends some 2ˢ times less: there the motion has features shorter than
/// the steps. Every step is one of [`Variational`](super::Variational), so that Casimirs are kept to round-off where there is no force.
///
/// **Jumps**, with [`Solve::new`]. The estimate is that of a smooth force. A jump shows where the stages of one step predict the force at its ends eight times worse
/// than those of the other, and those of 2h hardly worse. Steps then become shorter until the jump does no harm: 120 to 190 steps instead of
/// 10. Two jumps between the same two stages go unseen ([`max_step`](Solve::max_step) is for these), and at times a jump of the
/// derivative, or one that is small beside what stages miss of the rest of the force. Up to a known jump and on from it are two runs. A jump at one
/// of 299 times, added to a top with damping:
///
/// | jump, beside the torques | tolerance | errors beyond it | the worst, in tolerances |
/// |---|---|---|---|
/// | as large | 10⁻⁴ to 10⁻¹⁰ | 0 | below 1 |
/// | 10⁻² | 10⁻⁴ | 86 | 19 |
/// | 10⁻⁴ | 10⁻⁸ | 50 | 1,200 |
///
/// **Time.** With the Cayley map and a quadratic Lagrangian `Solve::in_lanes` (feature `lanes`) does the same in a tenth of the time or less; it has its own
/// estimate of the error, from one step, and Gauss with 4, 6 or 8 stages.
///
/// **Method.** Gauss with one stage for two digits of the tolerance and two besides, from 3 to 16 stages; or [`family`](Solve::family),
/// [`tableau`](Solve::tableau).
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix, Vector};
/// use euler_poincare::integrators::State;
/// use euler_poincare::integrators::solve::{DenseError, End, Solution, Solve, Statistics};
/// use euler_poincare::mechanics::{Force, lagrangian::Quadratic};
/// use euler_poincare::retraction::CayleySo3;
/// use euler_poincare::scalar::{Real, Scalar};
///
/// /// A force of one's own: M × (M × Ω).
/// struct Damping;
///
/// impl<T: Real> Force<T, 3> for Damping {
///     fn force<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, 3>) -> Covector<S, 3> {
///         let m = Vector::<S, 3>::new(eta[0] * S::half(), eta[1] * S::int(2), eta[2]);
///         m.cross(&m.cross(eta)).transpose()
///     }
/// }
///
/// let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
/// let momentum = Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2.0_f64.sqrt();
/// let start = State { time: 0.0, momentum, attitude: Matrix::<f64, 3>::identity() };
///
/// let mut solve = Solve::new(body, Damping, CayleySo3::new()).tolerance(1e-10).save_at([0.25, 0.75]).dense();
/// let solution: Solution<_, 3, 3, _> = solve.run(&start, 1.0)?;
/// assert!((solution.state.momentum[0] - 0.2414593544179369).abs() < 1e-10);
/// assert_eq!((solution.end, solution.saved.len()), (End::Time, 2));
/// let statistics: Statistics<f64> = solution.statistics;
/// assert!(statistics.error < 1e-10 && statistics.steps > 0);
///
/// // The state at any time, on the group to round-off.
/// let between = solution.at(0.3)?;
/// assert!((between.attitude.transpose() * between.attitude - Matrix::<f64, 3>::identity()).amax() < 1e-14);
/// assert!(matches!(solution.at(2.0), Err(DenseError::Outside { .. })));
///
/// // On from there, with the step that was reached, and back.
/// let mut solve = solve.save_at([]).first_step(solution.next_step);
/// let later = solve.run(&solution.state, 2.0)?;
/// let back = solve.run(&later.state, 0.0)?;
/// assert!((back.state.momentum - start.momentum).amax() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Solve<'a, T: Real, const N: usize, const D: usize, E: Engine<T, N, D>> {
    parts: E::Parts,
    tolerance: T,
    method: Method<T>,
    most_steps: usize,
    first_step: Option<T>,
    max_step: Option<T>,
    save_at: Vec<T>,
    every: Option<usize>,
    dense: bool,
    events: Vec<Event<'a, T, N, D>>,
    observer: Option<Box<Observer<'a, T, N, D>>>,
    follower: Option<Box<Follower<'a, T, N, D>>>,
    /// What the last run has allocated, for the next one.
    ready: Option<Box<Ready<T, N, D, E>>>,
}

/// What takes the steps, and what is between them.
struct Ready<T: Real, const N: usize, const D: usize, E> {
    engine: E,
    piece: Piece<T, N, D>,
}

/// A run on its way.
struct Run<T: Real, const N: usize, const D: usize, R> {
    solution: Solution<T, N, D, R>,
    task: Task<T>,
    /// Whether the time grows.
    forward: bool,
    /// The times to save that are still to come begin here.
    next_save: usize,
    /// The time of the state that was saved last.
    saved: Option<T>,
    /// The values of the event functions at the last state.
    values: Vec<T>,
    /// Events of the step at hand, and the values of their functions before it.
    found: Vec<Located<T, N, D>>,
    before: Vec<T>,
    /// An event function without a value at the end of the step at hand.
    undefined: Option<SolveError>,
    /// The energy taken up until the last step, where a caller follows.
    taken: Exchange<T>,
    /// The relative residual of the pair at hand.
    residual: T,
}

impl<T: Real, const N: usize, const D: usize, R> Run<T, N, D, R> {
    /// Whether one time comes before another.
    fn earlier(&self, a: T, b: T) -> bool {
        if self.forward { a < b } else { a > b }
    }

    /// The run ends within a step, at this state.
    fn end_within(&mut self, piece: &Piece<T, N, D>, state: State<T, N, D>, end: End) -> Option<End> {
        if let Some(dense) = &mut self.solution.dense {
            dense.pieces.push(piece.clone());
        }
        self.solution.state = state;
        Some(end)
    }
}

/// The result of a run.
type Outcome<T, const N: usize, const D: usize, R> = Result<Solution<T, N, D, R>, SolveFailure<T, N, D, R>>;

impl<T, const N: usize, const D: usize, L, F, R> Solve<'_, T, N, D, Pairs<T, N, D, Arc<L>, Arc<F>, Arc<R>>>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// The solver for l, f and τ, one stage after the other, with the tolerance 10⁻⁸.
    pub fn new(lagrangian: L, force: F, retraction: R) -> Self {
        Self::of(Arc::new(lagrangian), Arc::new(force), Arc::new(retraction))
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Solve<'_, T, N, D, Pairs<T, N, D, L, F, R>>
where
    T: Real,
    L: Lagrangian<T, N> + Clone,
    F: Force<T, N> + Clone,
    R: Retraction<T, N, D> + Clone,
{
    /// The same for parts that are copied: references, or small values. Each of them is needed three times.
    pub fn of(lagrangian: L, force: F, retraction: R) -> Self {
        Self::with((lagrangian, force, retraction))
    }

    /// Another family than Gauss; the number of stages follows from the tolerance.
    pub fn family(mut self, family: Family) -> Self {
        (self.method, self.ready) = (Method::Family(family), None);
        self
    }

    /// A tableau of one's own: only the step size follows from the tolerance.
    pub fn tableau(mut self, tableau: Tableau<T>) -> Self {
        (self.method, self.ready) = (Method::Tableau(tableau), None);
        self
    }
}

impl<'a, T: Real, const N: usize, const D: usize, E: Engine<T, N, D>> Solve<'a, T, N, D, E> {
    /// The solver of these parts, with the tolerance 10⁻⁸.
    fn with(parts: E::Parts) -> Self {
        Self {
            parts,
            tolerance: T::exact(TOLERANCE),
            method: Method::Family(Family::Gauss),
            most_steps: MOST_STEPS,
            first_step: None,
            max_step: None,
            save_at: Vec::new(),
            every: None,
            dense: false,
            events: Vec::new(),
            observer: None,
            follower: None,
            ready: None,
        }
    }

    /// The relative error that all steps of a run may add, between 0 and 1.
    pub fn tolerance(mut self, tolerance: T) -> Self {
        (self.tolerance, self.ready) = (tolerance, None);
        self
    }

    /// The steps that a run may try, a million by default; a pair that was refused counts as two.
    pub fn max_steps(mut self, steps: usize) -> Self {
        self.most_steps = steps;
        self
    }

    /// The size of the first steps, of either sign; by default, and where it is 0, it follows from the rates at the start.
    pub fn first_step(mut self, step: T) -> Self {
        self.first_step = Some(step);
        self
    }

    /// The largest size of a step, for forces that act for a short time and for events that are close to each other.
    pub fn max_step(mut self, step: T) -> Self {
        self.max_step = Some(step);
        self
    }

    /// The times at which to save states, each later than the one before in the direction of the run.
    pub fn save_at(mut self, times: impl IntoIterator<Item = T>) -> Self {
        self.save_at = times.into_iter().collect();
        self
    }

    /// Saves the state after every k-th step, where it is not saved already.
    pub fn every(mut self, k: usize) -> Self {
        self.every = Some(k);
        self
    }

    /// Keeps what is needed for [`Solution::at`].
    pub fn dense(mut self) -> Self {
        self.dense = true;
        self
    }

    /// Locates one event more.
    pub fn event(mut self, event: Event<'a, T, N, D>) -> Self {
        self.events.push(event);
        self
    }

    /// Calls `observe` with the state after each step; the run ends where it breaks off.
    pub fn observe(mut self, observe: impl FnMut(&State<T, N, D>) -> ControlFlow<()> + 'a) -> Self {
        self.observer = Some(Box::new(observe));
        self
    }

    /// Hands every state to save, every event and every step to `follow`, instead of keeping the states and the events: the memory
    /// of a run does not grow. They come in the order of the run. The run ends at the first of them at which `follow` breaks off.
    pub fn follow(mut self, follow: impl FnMut(&Progress<'_, T, N, D>) -> ControlFlow<()> + 'a) -> Self {
        self.follower = Some(Box::new(follow));
        self
    }

    /// The solution from a state to the time `end`, before it or after it.
    ///
    /// The memory of a run is kept for the next; a step allocates nothing but what is saved.
    ///
    /// # Errors
    /// [`SolveFailure`] with a [`SolveError`] and what was reached: input that makes no sense, a step that cannot be taken however short,
    /// a tolerance that cannot be kept, too many steps, an event function that is not finite.
    pub fn run(&mut self, start: &State<T, N, D>, end: T) -> Outcome<T, N, D, E::Retraction> {
        let mut solution = Solution {
            state: start.clone(),
            end: End::Failed,
            statistics: Statistics::none(),
            saved: Vec::new(),
            events: Vec::new(),
            next_step: T::zero(),
            start: start.time,
            dense: None,
        };
        let fail = |error, solution| SolveFailure { error, reached: Box::new(solution) };
        if let Err(error) = self.check(start, end) {
            return Err(fail(error, solution));
        }
        let task = self.task(start.time, end);
        // Taken out, so that the events and the observer can be borrowed beside it.
        let mut ready = match self.ready.take().map_or_else(|| self.ready(start), Ok) {
            Ok(ready) => ready,
            Err(error) => return Err(fail(error.into(), solution)),
        };
        if let Err(error) = ready.engine.begin(start, &task) {
            return Err(fail(error, solution));
        }
        if self.dense {
            solution.dense = Some(Dense { retraction: ready.engine.retraction().clone(), pieces: Vec::new() });
        }
        if self.follower.is_none() {
            solution.saved.reserve(self.save_at.len());
        }
        let mut run = Run {
            forward: end >= start.time,
            solution,
            task,
            next_save: 0,
            saved: None,
            values: Vec::new(),
            found: Vec::new(),
            before: Vec::new(),
            undefined: None,
            taken: Exchange::zero(),
            residual: T::zero(),
        };
        let result = self.advance(&mut ready, &mut run);
        run.solution.next_step = ready.engine.next_step();
        self.ready = Some(ready);
        match result {
            Ok(end) => {
                run.solution.end = end;
                Ok(run.solution)
            }
            Err(error) => Err(fail(error, run.solution)),
        }
    }

    /// What is asked for, of the engine.
    fn task(&self, start: T, end: T) -> Task<T> {
        let within = self.dense || !self.save_at.is_empty() || !self.events.is_empty() || self.follower.is_some();
        Task {
            start,
            end,
            tolerance: self.tolerance,
            first_step: self.first_step.map(|step| step.abs()).filter(|step| *step > T::zero()),
            max_step: self.max_step,
            most_steps: self.most_steps,
            within,
        }
    }

    /// Refuses input that makes no sense.
    fn check(&self, start: &State<T, N, D>, end: T) -> Result<(), SolveError> {
        let bad = |what, value: T, needed| Err(SolveError::BadInput { what, value: value.to_f64(), needed });
        if !(self.tolerance > T::zero() && self.tolerance < T::one()) {
            return bad("the tolerance", self.tolerance, "between 0 and 1");
        }
        if !end.all_finite() {
            return bad("the end time", end, "finite");
        }
        if let Some(step) = self.first_step.filter(|step| !step.all_finite()) {
            return bad("the first step", step, "finite");
        }
        if let Some(step) = self.max_step.filter(|step| !step.all_finite() || *step <= T::zero()) {
            return bad("the largest step", step, "finite and above 0");
        }
        let least = Control::least_of(start.time, (end - start.time).abs());
        if let Some(step) = self.max_step.filter(|step| *step < least && end != start.time) {
            return bad("the largest step", step, "64 units of round-off of the time and of the duration, or more");
        }
        if self.every == Some(0) {
            return bad("the number of steps between saved states", T::zero(), "at least 1");
        }
        start.check_finite(end).map_err(|source| SolveError::Start { time: start.time.to_f64(), source })?;
        let forward = end >= start.time;
        let from = |time: T| if forward { time - start.time } else { start.time - time };
        let (mut before, span) = (None, from(end));
        for (index, &time) in self.save_at.iter().enumerate() {
            let at = from(time);
            let why = if !at.all_finite() {
                "it is not finite"
            } else if at < T::zero() || at > span {
                "it is outside the run"
            } else if before.is_some_and(|before| at <= before) {
                "it is not later, in the direction of the run, than the one before"
            } else {
                before = Some(at);
                continue;
            };
            return Err(SolveError::SaveTime { index, time: time.to_f64(), why });
        }
        Ok(())
    }

    fn ready(&self, start: &State<T, N, D>) -> Result<Box<Ready<T, N, D, E>>, TableauError> {
        let engine = E::new(&self.parts, &self.method, self.tolerance, start)?;
        Ok(Box::new(Ready { engine, piece: Piece::new() }))
    }

    /// All steps.
    fn advance(
        &mut self,
        ready: &mut Ready<T, N, D, E>,
        run: &mut Run<T, N, D, E::Retraction>,
    ) -> Result<End, SolveError> {
        for (index, event) in self.events.iter_mut().enumerate() {
            run.values.push(event.value(index, &run.solution.state)?);
        }
        if self.save_at.first() == Some(&run.solution.state.time) {
            run.next_save = 1;
            let state = run.solution.state.clone();
            if self.pass_on(run, Moment::Saved, &state, run.taken).is_break() {
                return Ok(End::Stopped);
            }
        }
        while !ready.engine.ended() {
            let steps = ready.engine.advance(&run.task, &mut run.solution.statistics)?;
            if steps == 0 {
                continue;
            }
            run.residual = ready.engine.residual();
            let statistics = &mut run.solution.statistics;
            statistics.residual = larger(statistics.residual, run.residual);
            for k in 0..steps {
                run.solution.statistics.steps += 1;
                if let Some(end) = self.keep(ready, run, k)? {
                    return Ok(end);
                }
            }
            ready.engine.kept();
        }
        Ok(End::Time)
    }

    /// Saves what is asked for of step k of those taken last, and looks for events in it; where the run ends in it, why.
    fn keep(
        &mut self,
        ready: &mut Ready<T, N, D, E>,
        run: &mut Run<T, N, D, E::Retraction>,
        k: usize,
    ) -> Result<Option<End>, SolveError> {
        let Ready { engine, piece } = ready;
        let [start, stop] = engine.ends(k).map(|state| state.time);
        let crossed = self.watch(engine.ends(k)[1], run);
        let between = self.save_at.get(run.next_save).is_some_and(|&time| run.earlier(time, stop));
        if self.dense || crossed || between {
            let step = stop - start;
            let stuck = |source| SolveError::Stuck { time: start.to_f64(), step: step.to_f64(), source };
            engine.piece(k, self.tolerance, piece).map_err(stuck)?;
        }
        let followed = self.follower.is_some();
        let whole = if followed { engine.exchange(k) } else { Exchange::zero() };
        let (engine, piece) = (&*engine, &*piece);
        let after = engine.ends(k)[1];
        let step = Step { k, start, after, piece, retraction: engine.retraction() };
        if crossed {
            self.locate(&step, run)?;
        }
        let terminal = self.terminal(run)?;
        // A run that ends before the end of the step does not get there.
        if let (None, Some(error)) = (terminal, run.undefined.take()) {
            return Err(error);
        }
        let last = terminal.map_or(stop, |place| run.found[place].state.time);
        let mut place = 0;
        loop {
            let save = self.save_at.get(run.next_save).copied().filter(|&time| !run.earlier(last, time));
            let event = run.found.get(place);
            let (moment, state) = match (save, event) {
                (Some(time), _) if event.is_none_or(|event| !run.earlier(event.state.time, time)) => {
                    run.next_save += 1;
                    (Moment::Saved, step.at(time)?)
                }
                (_, Some(event)) => {
                    place += 1;
                    (Moment::Event { index: event.event, rising: event.rising }, event.state.clone())
                }
                _ => break,
            };
            let taken = self.taken(engine, &step, run, whole, state.time)?;
            if self.pass_on(run, moment, &state, taken).is_break() {
                return Ok(run.end_within(piece, state, End::Stopped));
            }
        }
        if let Some(place) = terminal {
            let Located { event, state, .. } = run.found[place].clone();
            return Ok(run.end_within(piece, state, End::Event(event)));
        }
        if let Some(dense) = &mut run.solution.dense {
            dense.pieces.push(piece.clone());
        }
        run.solution.state.clone_from(after);
        run.taken = self.taken(engine, &step, run, whole, stop)?;
        let every = self.every.is_some_and(|every| run.solution.statistics.steps.is_multiple_of(every));
        let followed = self.follower.is_some() || self.observer.is_some();
        for (moment, due) in [(Moment::Saved, every && run.saved != Some(stop)), (Moment::Step, followed)] {
            if due && self.pass_on(run, moment, after, run.taken).is_break() {
                return Ok(Some(End::Stopped));
            }
        }
        Ok(None)
    }

    /// The place of the first terminal event among those found. Of the later ones only those are left whose functions have passed zero at its
    /// state: a run that goes on from there does not find them.
    fn terminal(&mut self, run: &mut Run<T, N, D, E::Retraction>) -> Result<Option<usize>, SolveError> {
        let Some(place) = run.found.iter().position(|located| self.events[located.event].terminal) else {
            return Ok(None);
        };
        let state = run.found[place].state.clone();
        let mut kept = place + 1;
        for later in place + 1..run.found.len() {
            let Located { event, rising, .. } = run.found[later];
            let value = self.events[event].value(event, &state)?;
            let passed = if rising { value >= T::zero() } else { value <= T::zero() };
            if passed {
                run.found[kept] = Located { event, rising, state: state.clone() };
                kept += 1;
            }
        }
        run.found.truncate(kept);
        Ok(Some(place))
    }

    /// The energy taken up until a time of a step, where a caller follows: `whole` in all of it.
    fn taken(
        &self,
        engine: &E,
        step: &Step<'_, T, N, D, E::Retraction>,
        run: &Run<T, N, D, E::Retraction>,
        whole: Exchange<T>,
        time: T,
    ) -> Result<Exchange<T>, SolveError> {
        if self.follower.is_none() || whole == Exchange::zero() {
            return Ok(run.taken);
        }
        if time == step.after.time {
            return Ok(run.taken.plus(whole));
        }
        let (tableau, length) = (engine.tableau(), time - step.start);
        let mut power = Exchange::zero();
        for (&b, &c) in tableau.b().iter().zip(tableau.c()) {
            let state = step.at(step.start + c * length)?;
            let rates = engine.power(step.k, &state).map_err(|source| step.stuck(state.time, source))?;
            power = power.plus(rates.times(b));
        }
        Ok(run.taken.plus(power.times(length)))
    }

    /// Hands on what has happened, or keeps it.
    fn pass_on(
        &mut self,
        run: &mut Run<T, N, D, E::Retraction>,
        moment: Moment,
        state: &State<T, N, D>,
        Exchange { work, explicit }: Exchange<T>,
    ) -> ControlFlow<()> {
        if moment == Moment::Saved {
            run.saved = Some(state.time);
        }
        if let Some(follow) = &mut self.follower {
            let (residual, statistics) = (run.residual, &run.solution.statistics);
            follow(&Progress { moment, state, work, explicit, residual, statistics })?;
        }
        let kept = self.follower.is_none();
        match (moment, &mut self.observer) {
            (Moment::Step, Some(observe)) => return observe(state),
            (Moment::Saved, _) if kept => run.solution.saved.push(state.clone()),
            (Moment::Event { index: event, rising }, _) if kept => {
                run.solution.events.push(Located { event, rising, state: state.clone() });
            }
            _ => {}
        }
        ControlFlow::Continue(())
    }

    /// Evaluates the event functions after a step; whether one of them may have passed zero.
    fn watch(&mut self, after: &State<T, N, D>, run: &mut Run<T, N, D, E::Retraction>) -> bool {
        run.found.clear();
        run.before.clear();
        for (index, event) in self.events.iter_mut().enumerate() {
            let value = match event.value(index, after) {
                Ok(value) => value,
                Err(error) => {
                    run.undefined.get_or_insert(error);
                    continue;
                }
            };
            let before = std::mem::replace(&mut run.values[index], value);
            // From 0 it depends on the sign inside the step.
            let leaves = (before == T::zero() && value != T::zero()).then_some(value > T::zero());
            if let Some(rising) = event.passes(before, value).or(leaves) {
                run.found.push(Located { event: index, rising, state: after.clone() });
                run.before.push(before);
            }
        }
        !run.found.is_empty()
    }

    /// The times and states of the events found, in the order of the run.
    fn locate(
        &mut self,
        step: &Step<'_, T, N, D, E::Retraction>,
        run: &mut Run<T, N, D, E::Retraction>,
    ) -> Result<(), SolveError> {
        let (start, length) = (step.start, step.after.time - step.start);
        let width = self.tolerance / T::int(LOCATED);
        let rounding = T::int(LOCATED_ROUNDING) * T::unit_roundoff() * (T::one() + (start / length).abs());
        let time = |theta: T| if theta == T::one() { step.after.time } else { start + theta * length };
        let mut kept = 0;
        for place in 0..run.found.len() {
            let index = run.found[place].event;
            let (event, mut ends) = (&mut self.events[index], [run.before[place], run.values[index]]);
            if ends[0] == T::zero() {
                ends[0] = event.value(index, &step.at(time(T::exact(ASIDE)))?)?;
                // Not where it only leaves 0.
                if event.passes(ends[0], ends[1]).is_none() {
                    continue;
                }
            }
            let zero = events::bracket(ends, width.max(rounding), |x| event.value(index, &step.at(time(x))?));
            let zero = match zero {
                Err(SolveError::EventValue { value, .. }) if value.is_infinite() => None,
                zero => zero?,
            };
            if let Some(theta) = zero {
                run.found[kept] = Located { state: step.at(time(theta))?, ..run.found[place].clone() };
                kept += 1;
            }
        }
        run.found.truncate(kept);
        run.found.sort_by(|a, b| {
            let order = a.state.time.partial_cmp(&b.state.time).unwrap_or(std::cmp::Ordering::Equal);
            if length > T::zero() { order } else { order.reverse() }
        });
        Ok(())
    }
}

/// The states of a step.
struct Step<'s, T: Real, const N: usize, const D: usize, R> {
    /// Which of the pair.
    k: usize,
    start: T,
    after: &'s State<T, N, D>,
    piece: &'s Piece<T, N, D>,
    retraction: &'s R,
}

impl<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>> Step<'_, T, N, D, R> {
    fn at(&self, time: T) -> Result<State<T, N, D>, SolveError> {
        if time == self.after.time {
            return Ok(self.after.clone());
        }
        self.piece.at(self.retraction, time).map_err(|source| {
            let step = (self.after.time - self.start).to_f64();
            self.stuck(time, StepError::Domain { step, stage: None, source })
        })
    }

    /// There is no state at a time in the step.
    fn stuck(&self, time: T, source: StepError) -> SolveError {
        SolveError::Stuck { time: time.to_f64(), step: (self.after.time - self.start).to_f64(), source }
    }
}
