//! The engine in lanes: steps of [`VariationalInLanes`], of which each knows its own error.

use super::Method;
use super::Solve;
use super::control::{Control, JUMP, JUMPS, Statistics};
use super::dense::{Maker, Piece};
use super::engine::{Engine, Task};
use super::error::SolveError;
use super::measure::Measure;
use super::passed::{Passed, Point, Stages};
use super::through::Through;
use crate::algebra::{LieAlgebra, Vector, apply, pull};
use crate::integrators::blocks::Blocks;
use crate::integrators::lanes::kernel::{Limits, Packed, Refused, Strict, Taken, compensated};
use crate::integrators::lanes::vectors::{length, velocity};
use crate::integrators::lanes::{
    FastRetraction, LANES, LaneForce, LaneGroup, One, Registers, VariationalInLanes, each,
};
use crate::integrators::variational::Exchange;
use crate::integrators::{State, StepError};
use crate::mechanics::lagrangian::Quadratic;
use crate::retraction::{RetractionError, TangentPoint as _};
use crate::scalar::Scalar;
use crate::tableau::{Family, Tableau, TableauError};

/// δ, times this, stands for the local error in momentum and attitude: on random bodies and forces the ratio of the error
/// to δ has a median between 1 and 4 for Gauss 4 to 8 with either retraction, and lies below 21 in nine cases of ten. The
/// errors of the steps are added up as if they all pointed the same way.
const SAFETY: f64 = 8.0;

/// What rounding makes of δ, in units of round-off: δ is a difference of sums of the size of μ.
const NOISE: f64 = 32.0;

/// How many times a term is rounded on its way through τ and back, in the same units.
const PASSES: f64 = 4.0;

/// How far below what is allowed the error of the next step is aimed at, as a power of two: with half of it more steps are
/// refused, with more steps are shorter, and random runs take as long.
const MARGIN: f64 = 1.0;

/// After this number of steps what rounding has made of gᵀg is taken back: a step of several radians makes it some 5·10⁻¹⁷.
const STRAIGHT: usize = 16;

/// |gᵀg − 1| that is more than rounding, and so the caller's.
const CROOKED: f64 = 1e-12;

/// The angle of the first step that is tried, where the tolerance for a radian is 1: with order p and the tolerance ε for a
/// radian it is REACH ε^{1/(p+1)}. On random bodies and forces smaller and larger ones cost more time.
const REACH: f64 = 7.0;

/// The largest such angle.
const LARGEST_FIRST_ANGLE: f64 = 3.0;

/// A run over no more than this angle is tried as one step.
const ORDINARY: f64 = 1.5;

/// How much longer than the last a step may be.
const GROWTH: f64 = 1.2;

/// |μ̇| relative to |μ||η| below which the motion counts as nearly steady.
const STEADY: f64 = 1e-5;

/// Only to tolerances below this are steps taken that know steady motions.
const STEADY_TOLERANCE: f64 = 1e-6;

/// The largest angle of a step of a motion that is nearly steady: short of the singularity of dτ; there is room for the motion to turn faster.
const LARGEST_ANGLE: f64 = 5.75;

/// After a step with too large an error the next one is shorter by a factor between these; after one whose iterations do not contract, by the third.
const LEAST_SHRINK: f64 = 0.2;
const MOST_SHRINK: f64 = 0.8;
const RETREAT: f64 = 0.6;

/// Steps refused one after the other until a run ends.
const MOST_FAILURES: usize = 60;

/// By how much what rounding makes of the forces must exceed all that residuals were relative to, for a step to be tried again with it.
const DECIDES: f64 = 4.0;

/// A body, a force and a retraction, and in which registers.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Parts<F, R, const N: usize> {
    lagrangian: Quadratic<f64, N>,
    force: F,
    retraction: R,
    registers: Registers,
}

/// Steps in lanes of a body, a force and a retraction; what [`Solve::in_lanes`] takes.
pub struct InLanes<F, R: FastRetraction<N, D>, const N: usize, const D: usize> {
    method: VariationalInLanes<F, R, N, D>,
    /// For motions that are nearly steady.
    steady: Option<VariationalInLanes<F, R::Steady, N, D>>,
    sizes: Sizes<N>,
    run: Run,
    packed: Packed<N, D>,
    /// The ends of the last step.
    ends: [State<f64, N, D>; 2],
    between: Option<Box<Between<N, D>>>,
}

/// What states within a step are made with.
struct Between<const N: usize, const D: usize> {
    maker: Maker<f64, N>,
    through: Through<f64>,
    measure: Measure<f64, N>,
    points: [Point<f64, N, D>; 2],
    stages: Stages<f64, N>,
}

impl<const N: usize, const D: usize> Between<N, D> {
    fn new<F: LaneForce<N, D>, R: FastRetraction<N, D>>(
        method: &VariationalInLanes<F, R, N, D>,
        start: &State<f64, N, D>,
    ) -> Result<Self, TableauError> {
        let through = Through::new(method.tableau().c().as_slice());
        Ok(Self {
            maker: Maker::new(&through, method.stages())?,
            through,
            measure: Measure::new(method.general().retraction().algebra()),
            points: [Point::new(start), Point::new(start)],
            stages: Stages::new(method.stages()),
        })
    }
}

/// Where a run is.
struct Run {
    sign: f64,
    span: f64,
    /// The tolerance a unit of time.
    per_time: f64,
    done: f64,
    /// The size of the next step without sign; infinite where none is known.
    next: f64,
    /// The last step, with sign.
    step: f64,
    /// Steps refused one after the other, and those for their error alone.
    failures: usize,
    too_far: usize,
    /// How much the forces change as g does, where rounding of g decides; else 0.
    sensitivity: f64,
    /// The number of steps after which to look at gᵀg.
    straight: usize,
    residual: f64,
    /// Nothing moved in the last step.
    rested: bool,
}

impl Run {
    fn new(task: &Task<f64>) -> Self {
        let (span, longest) = ((task.end - task.start).abs(), task.max_step.unwrap_or(f64::INFINITY));
        let least = Control::least_of(task.start, span);
        Self {
            sign: if task.end < task.start { -1.0 } else { 1.0 },
            span,
            per_time: task.tolerance / span,
            done: 0.0,
            next: task.first_step.map_or(f64::INFINITY, |step| step.max(least)).min(longest),
            step: 0.0,
            failures: 0,
            too_far: 0,
            sensitivity: 0.0,
            straight: STRAIGHT,
            residual: 0.0,
            rested: false,
        }
    }

    fn time(&self, task: &Task<f64>) -> f64 {
        if self.done >= self.span { task.end } else { task.start + self.sign * self.done }
    }

    /// The size of the first step of a method of this order, where the motion has this rate.
    fn first(&self, rate: f64, order: usize) -> f64 {
        if rate * self.span <= ORDINARY {
            return self.span;
        }
        let angle = REACH * (self.per_time / rate).powf(1.0 / (order + 1) as f64);
        let first = angle.min(LARGEST_FIRST_ANGLE) / rate;
        if first.is_finite() { first } else { self.span }
    }

    /// The times of the stages of a step to the end, and the end.
    fn times(&self, task: &Task<f64>, tableau: &Tableau<f64>) -> impl Iterator<Item = f64> {
        let (time, left) = (self.time(task), self.sign * (self.span - self.done));
        tableau.c().iter().map(move |c| left.mul_add(*c, time)).chain([task.end])
    }
}

/// What is known of the motion at the start of a step.
struct Here<const N: usize> {
    momentum: [f64; N],
    eta: [f64; N],
    /// μ̇.
    slope: [f64; N],
    /// |μ|, |μ̇|.
    size: f64,
    pushed: f64,
    /// The angle by which g turns in a unit of time; and by which the motion changes.
    turns: f64,
    rate: f64,
}

impl<const N: usize> Here<N> {
    fn of<F: LaneForce<N, D>, R: FastRetraction<N, D>, const D: usize>(
        method: &VariationalInLanes<F, R, N, D>,
        packed: &Packed<N, D>,
        time: f64,
    ) -> Self {
        let momentum = packed.momentum;
        let eta = velocity(&method.inverse, momentum);
        let slope = method.slope(time, packed, [momentum, eta]);
        let (size, pushed, turns) = (length(momentum), length(slope), method.group.turning(eta));
        // From rest a body turns by half its angular acceleration times t².
        let changes = if size > 0.0 { pushed / size } else { length(velocity(&method.inverse, slope)).sqrt() };
        Self { momentum, eta, slope, size, pushed, turns, rate: turns + changes }
    }
}

impl<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize>
    Solve<'_, f64, N, D, InLanes<F, R, N, D>>
{
    /// The solver of a body and a force with all stages of a step in the lanes of a register: the same as of [`Solve::new`] in a tenth of the time or
    /// less. A force and a potential of one's own go in by [`ByLane`](crate::integrators::lanes::ByLane).
    ///
    /// Order: Gauss with eight stages for tolerances below 10⁻⁶, six below 10⁻⁴, four above. The local error is estimated without a second step, from δ, the
    /// difference between the variational scheme and the chart scheme of the same order, which a step computes anyway; from the Legendre
    /// coefficients of μ̇ at the stages, since δ vanishes along straight motions; and from what their polynomial misses at the ends of the
    /// step, which shows kinks and jumps of a force. It is relative to |μ| and to |η|, of each block; the attitude is off by as many tolerances as it has
    /// turned by radians, or so. A jump at one of 299 times, of 10⁻⁴ to 1 of the torques, added at most a quarter of the tolerance to the error of a top with
    /// damping, from 10⁻⁴ to 10⁻¹⁰; it costs 70 to 220 steps.
    ///
    /// Where nothing is asked for within the steps, a body on SO(3) whose rotation is nearly steady takes steps of several radians, with the
    /// exponential map, which integrates a steady rotation exactly; one that stays steady to the end is one step. That a motion stays steady, or a body at
    /// rest, is known from the force now, at eight times and at the end: where a force acts for a short time, [`max_step`](Self::max_step) is for it.
    ///
    /// ```
    /// use euler_poincare::algebra::Covector;
    /// use euler_poincare::integrators::lanes::Damping;
    /// use euler_poincare::integrators::{Solve, State};
    /// use euler_poincare::mechanics::lagrangian::Quadratic;
    /// use euler_poincare::retraction::CayleySo3;
    ///
    /// let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
    /// let start = State::at_identity(Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2.0_f64.sqrt());
    /// let mut solve = Solve::in_lanes(body, Damping(1.0), CayleySo3::new()).tolerance(1e-12);
    /// let solution = solve.run(&start, 1.0)?;
    /// assert!((solution.state.momentum[0] - 0.2414593544179369).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn in_lanes(lagrangian: Quadratic<f64, N>, force: F, retraction: R) -> Self {
        Self::with(Parts { lagrangian, force, retraction, registers: Registers::detect() })
    }

    /// The same in registers of another kind: for tests that compare them.
    pub fn in_registers(mut self, registers: Registers) -> Self {
        (self.parts.registers, self.ready) = (registers, None);
        self
    }
}

impl<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize> Engine<f64, N, D>
    for InLanes<F, R, N, D>
{
    type Parts = Parts<F, R, N>;
    type Retraction = R;

    fn new(
        parts: &Parts<F, R, N>,
        _: &Method<f64>,
        tolerance: f64,
        start: &State<f64, N, D>,
    ) -> Result<Self, TableauError> {
        let Parts { retraction, .. } = parts;
        let steady = match retraction.steady() {
            Some(retraction) => Some(gauss(parts, retraction, LANES)?),
            None => None,
        };
        let (at, step) = (start.time, None);
        let nothing =
            Task { start: at, end: at, tolerance, first_step: step, max_step: step, most_steps: 0, within: false };
        Ok(Self {
            method: gauss(parts, retraction.clone(), stages_for(tolerance))?,
            steady,
            sizes: Sizes::of(retraction.algebra()),
            run: Run::new(&nothing),
            packed: Packed::of(start),
            ends: [start.clone(), start.clone()],
            between: None,
        })
    }

    fn begin(&mut self, start: &State<f64, N, D>, task: &Task<f64>) -> Result<(), SolveError> {
        self.run = Run::new(task);
        self.packed = Packed::of(start);
        self.ends[1].clone_from(start);
        self.sizes.largest = [[0.0; N]; 2];
        if let Some(between) = &mut self.between {
            between.measure.reset();
        } else if task.within {
            self.between = Some(Box::new(Between::new(&self.method, start)?));
        }
        Ok(())
    }

    fn ended(&self) -> bool {
        self.run.done >= self.run.span
    }

    fn advance(&mut self, task: &Task<f64>, statistics: &mut Statistics<f64>) -> Result<usize, SolveError> {
        if statistics.steps == self.run.straight {
            self.run.straight += STRAIGHT;
            straighten(&mut self.packed, self.method.group.rotation());
        }
        let here = Here::of(&self.method, &self.packed, self.run.time(task));
        let nearly = self.nearly_steady(&here, task);
        if self.passes(&here, nearly, task) {
            self.reach(task);
            return Ok(1);
        }
        let Self { method, steady, sizes, run, packed, .. } = self;
        let (time, left) = (run.time(task), run.span - run.done);
        if run.next == f64::INFINITY {
            run.next = run.first(here.rate, 2 * method.stages());
        }
        if let Some(longest) = task.max_step {
            run.next = run.next.min(longest);
        }
        let steady = steady.as_mut().filter(|_| nearly);
        if steady.is_some() {
            run.next = run.next.min(LARGEST_ANGLE / here.turns);
        }
        let tried = statistics.steps + statistics.rejected;
        if tried >= task.most_steps {
            return Err(SolveError::TooManySteps { time, step: run.sign * run.next, steps: tried });
        }
        let last = run.next >= left;
        // Two equal steps rather than a long and a very short one.
        let step = if last { left } else { run.next.min(0.5 * left) };
        // After some refusals: a jump of a force.
        let jump = if run.too_far >= JUMP { task.tolerance / JUMPS as f64 } else { 0.0 };
        // Below this, δ is rounding.
        let allowed = (run.per_time * step).max(jump).max(NOISE * SAFETY * f64::unit_roundoff());
        let ratios = sizes.ratios([here.momentum, here.eta], &method.inverse, step, allowed, here.slope);
        // What a nearly steady rotation must not lose is that it becomes ever more steady.
        let tolerance = if steady.is_some() { 0.0 } else { run.per_time * step }.max(16.0 * f64::unit_roundoff());
        let limits = Limits {
            tolerance,
            floor: tolerance.max(1024.0 * f64::unit_roundoff()),
            rounding: Limits::<N>::rounding(step, run.sensitivity, tolerance),
            switch: tolerance,
            max_fixed_point_iterations: 30,
            strict: Some(Strict { most: allowed / SAFETY, noise: NOISE * f64::unit_roundoff(), ratios }),
        };
        run.step = run.sign * step;
        let taken = match steady {
            Some(steady) => steady.take(Some(packed), time, run.step, false, limits),
            None => method.take(Some(packed), time, run.step, false, limits),
        };
        let taken = match taken {
            Ok(taken) => taken,
            Err(refused) => {
                statistics.rejected += 1;
                return self.refuse(refused, allowed, &limits, task, statistics);
            }
        };
        run.done = if last { run.span } else { run.done + step };
        (run.failures, run.too_far, run.rested, run.residual) = (0, 0, false, taken.residual);
        statistics.error += SAFETY * taken.whole;
        statistics.iterations += taken.predictor + taken.iterations;
        if !last {
            run.next = step * factor(&taken, allowed, method.stages());
        }
        self.reach(task);
        Ok(1)
    }

    fn ends(&self, _: usize) -> [&State<f64, N, D>; 2] {
        self.ends.each_ref()
    }

    fn residual(&self) -> f64 {
        self.run.residual
    }

    fn piece(&mut self, _: usize, tolerance: f64, piece: &mut Piece<f64, N, D>) -> Result<(), StepError> {
        let Self { method, run, ends, between: Some(between), .. } = self else {
            return Err(StepError::Unsupported { why: "nothing was asked for within steps".into() });
        };
        let (general, Between { maker, through, measure, points, stages }) = (method.general(), &mut **between);
        stages.step = run.step;
        stages.increment = if run.rested { Vector::zeros() } else { method.increment() };
        for i in 0..stages.velocities.len() {
            (stages.displacements[i], stages.velocities[i]) =
                if run.rested { (Vector::zeros(), Vector::zeros()) } else { method.stage(i) };
        }
        for (k, (point, end)) in points.iter_mut().zip(ends.iter()).enumerate() {
            point.state.clone_from(end);
            let guess = stages.velocities[0];
            general.look(point, &guess, run.step)?;
            stages.ends[k] = point.velocity;
        }
        let domain = |source| StepError::Domain { step: run.step, stage: None, source };
        for i in 0..stages.rates.len() {
            let (x, eta) = (stages.displacements[i], stages.velocities[i]);
            let point = general.retraction().at(&x).map_err(domain)?;
            let attitude = match general.retraction().tau(&x) {
                Ok(moved) => ends[0].attitude * moved,
                Err(RetractionError::NoGroup { .. }) => ends[0].attitude,
                Err(source) => return Err(domain(source)),
            };
            let time = ends[0].time + general.tableau().c()[i] * run.step;
            let there = State { time, momentum: ends[0].momentum, attitude };
            let (force, _) = general.force_at(&there, &eta, run.step)?;
            stages.rates[i] = (apply(point.d_inv(), &eta), point.pull_ad_inv(&force, &pull(&force, point.d())));
        }
        for Point { state, velocity, load, .. } in points.iter() {
            let momentum = state.momentum.map(|v| v.abs()) + load * run.step.abs();
            measure.grow(&momentum, velocity, &stages.increment);
        }
        let [start, end] = &*points;
        maker.make(&Passed { method: general, start, end, stages, through, measure }, tolerance, piece)
    }

    fn exchange(&mut self, _: usize) -> Exchange<f64> {
        let Self { method, run, ends, .. } = self;
        if method.force.vanishes() || run.rested {
            return Exchange::zero();
        }
        let stages = (0..method.stages()).map(|i| method.stage(i)).map(|(x, eta)| (eta, x));
        method.general().exchange(&ends[0], run.step, stages)
    }

    fn power(&self, _: usize, state: &State<f64, N, D>) -> Result<Exchange<f64>, StepError> {
        self.method.general().power(state, &Vector::zeros(), self.run.step)
    }

    fn retraction(&self) -> &R {
        self.method.general().retraction()
    }

    fn tableau(&self) -> &Tableau<f64> {
        self.method.tableau()
    }

    fn kept(&mut self) {}

    fn next_step(&self) -> f64 {
        let Run { sign, next, step, .. } = self.run;
        if next.is_finite() { sign * next } else { step }
    }
}

impl<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize> InLanes<F, R, N, D> {
    /// Whether the motion is nearly steady, and there are steps that know it.
    fn nearly_steady(&self, here: &Here<N>, task: &Task<f64>) -> bool {
        let free = !task.within && task.tolerance < STEADY_TOLERANCE && !self.method.force.uses_attitude();
        free && self.steady.is_some() && here.size > 0.0 && here.pushed <= STEADY * here.size * here.turns
    }

    /// Whether the rest of the run is no more than a steady motion, or rest; then it is done.
    fn passes(&mut self, here: &Here<N>, nearly: bool, task: &Task<f64>) -> bool {
        let resting = here.size == 0.0 && here.pushed == 0.0;
        let left = self.run.span - self.run.done;
        if !(resting || nearly) || task.max_step.is_some_and(|longest| longest < left) {
            return false;
        }
        let Self { method, steady, run, packed, .. } = self;
        // A force may depend on time: what it is at the stages of a step to the end, and there.
        let slopes = run.times(task, method.tableau()).map(|t| method.slope(t, packed, [here.momentum, here.eta]));
        let pushed = slopes.map(length).fold(here.pushed, |worst, push| if push <= worst { worst } else { push });
        // μ may turn by |μ̇| t, and the attitude with it by |μ̇| t²/2 times |η|/|μ|; a body at rest stays there.
        let steadily = pushed * left * (1.0 + 0.5 * here.turns * left) <= 0.25 * task.tolerance * here.size;
        if !(if resting { pushed == 0.0 } else { steadily }) {
            return false;
        }
        if let (false, Some(steady)) = (resting, steady) {
            turn(packed, &steady.group, here.eta.map(|v| run.sign * left * v));
        }
        (run.done, run.step, run.rested, run.residual) = (run.span, run.sign * left, true, 0.0);
        true
    }

    /// A step was refused: a shorter one next, or the run ends.
    fn refuse(
        &mut self,
        refused: Refused,
        allowed: f64,
        limits: &Limits<N>,
        task: &Task<f64>,
        statistics: &mut Statistics<f64>,
    ) -> Result<usize, SolveError> {
        let Self { method, run, ends: [_, state], .. } = self;
        let (time, step) = (run.time(task), run.step.abs());
        let (error, spent) = match refused {
            Refused::Delta(delta, spent) => (Some(SAFETY * delta), spent),
            Refused::NotContracted(spent) => (None, spent),
        };
        statistics.iterations += spent;
        run.failures += 1;
        run.sensitivity = method.sensitivity_at(state);
        let rounding = Limits::<N>::rounding(step, run.sensitivity, limits.tolerance);
        if rounding > limits.rounding.max(state.momentum.amax()) * DECIDES {
            // Near an equilibrium: the same again.
            return Ok(0);
        }
        run.too_far += usize::from(error.is_some());
        let order = 2 * method.stages() as i32;
        let shrink = |e| growth(logarithm(allowed) - logarithm(e) - 2.0, order).clamp(LEAST_SHRINK, MOST_SHRINK);
        run.next = step * error.map_or(RETREAT, shrink);
        if run.next > Control::least_of(time, run.span) && run.failures <= MOST_FAILURES {
            return Ok(0);
        }
        Err(match error {
            Some(error) => SolveError::Tolerance { time, step: run.step, error, wanted: allowed },
            None => SolveError::Stuck { time, step: run.step, source: method.diagnose(state, run.step) },
        })
    }

    /// The step is done: the ends of it.
    fn reach(&mut self, task: &Task<f64>) {
        let [start, end] = &mut self.ends;
        start.clone_from(end);
        self.packed.unpack(end);
        end.time = self.run.time(task);
    }
}

/// The stages of Gauss for a tolerance.
fn stages_for(tolerance: f64) -> usize {
    match tolerance {
        t if t < 1e-6 => LANES,
        t if t < 1e-4 => 6,
        _ => 4,
    }
}

/// Gauss with some stages.
fn gauss<F: LaneForce<N, D>, R, Q: FastRetraction<N, D>, const N: usize, const D: usize>(
    Parts { lagrangian, force, registers, .. }: &Parts<F, R, N>,
    retraction: Q,
    stages: usize,
) -> Result<VariationalInLanes<F, Q, N, D>, TableauError> {
    let tableau = Family::Gauss.tableau(stages)?;
    let method = VariationalInLanes::new(lagrangian.clone(), force.clone(), retraction, tableau);
    Ok(method.expect("no more stages than lanes").in_registers(*registers))
}

/// The factor for the step after one that was taken: as long as the error allows, and as long as fixed-point iterations contract well.
fn factor(taken: &Taken, allowed: f64, stages: usize) -> f64 {
    let (iterations, order) = (taken.predictor + taken.iterations, 2 * stages as i32);
    let room = logarithm(allowed) - logarithm(SAFETY * taken.delta.max(f64::MIN_POSITIVE)) - MARGIN;
    let wanted = match iterations {
        n if n < stages + 10 => GROWTH,
        n if n <= stages + 11 => 1.0,
        _ => 0.8,
    };
    growth(room.clamp(-f64::from(order), f64::from(order)), order).min(wanted)
}

/// g ← g τ(x).
#[cold]
fn turn<G: LaneGroup<N, D>, const N: usize, const D: usize>(packed: &mut Packed<N, D>, group: &G, x: [f64; N]) {
    let back = group.wound(x).map(|v| One(-v / G::UNIT));
    let at = group.at(back, true);
    for r in 0..D {
        let row: [One<f64>; D] = each!(D, c => One(packed.columns[c].0[r]));
        let turned = group.moved_back(&at, back, row);
        for c in 0..D {
            packed.columns[c].0[r] += turned[c].0;
        }
    }
}

/// The sizes of the blocks of coordinates so far.
#[derive(Clone, Debug)]
struct Sizes<const N: usize> {
    blocks: Blocks<N>,
    /// |C^c_ab| and a, b, c, where there is more than one block.
    brackets: Vec<([usize; 3], f64)>,
    /// Of momenta, and of velocities.
    largest: [[f64; N]; 2],
}

impl<const N: usize> Sizes<N> {
    fn of(algebra: &LieAlgebra<f64, N>) -> Self {
        let blocks = Blocks::of(algebra);
        let triples = (0..N * N * N).map(|k| [k / (N * N), k / N % N, k % N]);
        let constant = |[a, b, c]: [usize; 3]| ([a, b, c], algebra.constant(a, b, c).abs());
        let several = blocks.each().count() > 1;
        let brackets = triples.map(constant).filter(|(_, size)| several && *size > 0.0).collect();
        Self { blocks, brackets, largest: [[0.0; N]; 2] }
    }

    /// By what factors the momenta and the velocities of each block are smaller than the largest; `None` where there is one block. A block at
    /// rest has the size that a step gives it. None counts for less than what rounding makes of its terms,
    /// which go through τ and back, relative to what is `allowed`.
    fn ratios(
        &mut self,
        [momentum, eta]: [[f64; N]; 2],
        inverse: &[[f64; N]; N],
        step: f64,
        allowed: f64,
        slope: [f64; N],
    ) -> Option<[[f64; N]; 2]> {
        self.blocks.each().nth(1)?;
        let mut found = [self.blocks.sizes(&momentum), self.blocks.sizes(&eta)];
        if found.as_flattened().contains(&0.0) {
            let gained = slope.map(|v| step * v);
            let sizes = [self.blocks.sizes(&gained), self.blocks.sizes(&velocity(inverse, gained))];
            found = grown(found, sizes);
        }
        self.largest = grown(self.largest, found);
        let mut terms = [0.0; N];
        for &([a, b, c], size) in &self.brackets {
            terms[b] += step * size * (eta[a] * momentum[c]).abs();
        }
        let rounding =
            self.blocks.sizes(&terms).map(|v| v * (PASSES * NOISE * SAFETY * f64::unit_roundoff() / allowed));
        let moved = velocity(&inverse.map(|row| row.map(f64::abs)), rounding);
        let sizes = grown(self.largest, [rounding, self.blocks.sizes(&moved)]);
        Some(sizes.map(|sizes| {
            let most = sizes.iter().fold(0.0, |most: f64, v| most.max(*v));
            sizes.map(|size| if size > 0.0 { most / size } else { 1.0 })
        }))
    }
}

/// The larger of each pair.
fn grown<const N: usize>(sizes: [[f64; N]; 2], others: [[f64; N]; 2]) -> [[f64; N]; 2] {
    each!(2, k => each!(N, a => if sizes[k][a] < others[k][a] { others[k][a] } else { sizes[k][a] }))
}

/// R ← R (3 − RᵀR)/2 of the leading block that is orthogonal: one step of the iteration of Newton and Schulz for the polar factor (Higham
/// 2008, section 8.3).
#[cold]
fn straighten<const N: usize, const D: usize>(packed: &mut Packed<N, D>, rotation: usize) {
    let (columns, block) = (packed.columns, rotation.min(D));
    let product = |k: usize, l: usize| (0..block).fold(0.0, |sum, r| columns[k].0[r].mul_add(columns[l].0[r], sum));
    let mut excess = [[0.0_f64; D]; D];
    for k in 0..block {
        for l in 0..block {
            excess[k][l] = product(k, l) - if k == l { 1.0 } else { 0.0 };
        }
    }
    if excess.iter().flatten().all(|v| v.abs() <= CROOKED) {
        for k in 0..block {
            for r in 0..block {
                let less = 0.5 * (0..block).fold(0.0, |sum, l| columns[l].0[r].mul_add(excess[l][k], sum));
                let (value, cut) = (&mut packed.columns[k].0[r], &mut packed.columns_cut[k].0[r]);
                let (sum, rest) = compensated(One(*value), One(-less), One(*cut));
                (*value, *cut) = (sum.0, rest.0);
            }
        }
    }
}

/// The (p + 1)st root of 2^`exponent`, p = `order`: by what factor a step may change where its error of order h^(p+1) may by
/// that power of two.
fn growth(exponent: f64, order: i32) -> f64 {
    f64::exp2(exponent / f64::from(order + 1))
}

/// The binary logarithm of a positive number to 0.09: the exponent, and the mantissa less 1.
fn logarithm(x: f64) -> f64 {
    (x.to_bits() as i64 - 1.0_f64.to_bits() as i64) as f64 / (1_u64 << 52) as f64
}
