//! A tolerance in, an answer out: order and steps are chosen on the way.

use super::force::LaneForce;
use super::kernel::{Limits, Packed, Refused, Strict, compensated};
use super::{FastRetraction, LaneGroup as _, One, VariationalInLanes};
use crate::algebra::LieAlgebra;
use crate::integrators::State;
use crate::integrators::blocks::Blocks;
use crate::integrators::solve::SolveError;
use crate::mechanics::lagrangian::Quadratic;
use crate::scalar::Scalar;
use crate::tableau::{Family, Tableau};

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

/// The least angle |Ω|h of a step that is tried.
const LEAST_ANGLE: f64 = 1.0 / 4096.0;

/// The angle of the first step that is tried, where the tolerance for a radian is 1: with order p and the tolerance ε for a
/// radian it is REACH ε^{1/(p+1)}. On random bodies and forces smaller and larger ones cost more time.
const REACH: f64 = 7.0;

/// The largest such angle.
const LARGEST_FIRST_ANGLE: f64 = 3.0;

/// How much longer than the last a step may be.
const GROWTH: f64 = 1.35;

/// What a run took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Solved {
    /// Steps taken.
    pub steps: usize,
    /// Steps tried in vain.
    pub rejected: usize,
    /// Fixed-point iterations of all of them.
    pub iterations: usize,
    /// The largest residual of the stage equations, relative to |μ|.
    pub residual: f64,
    /// The sum of the estimates of the local errors, relative to |μ| or |η|, of the block where it is largest.
    pub error: f64,
}

/// The steps that a run may try unless it is told otherwise.
pub(in crate::integrators) const MOST_STEPS: usize = 1_000_000;

/// The forced variational step on a matrix group in lanes, with order and step size chosen for a tolerance.
///
/// The tolerance is for the whole run: each step of size h may contribute the part h/T of it, relative to |μ| and to |η|. Coordinates of one unit in
/// one factor of a product, as the rotations and the translations of a rigid body, are a block, and each block is measured by its own sizes: the
/// largest so far. The error of the momentum is judged by what it makes of the velocity, too, which about an axis with little inertia is much. The
/// attitude is off by as many tolerances as it has turned by radians, or so. Rounding sets a limit.
///
/// The local error is estimated from δ, the difference between the variational scheme and the chart scheme of the same order, which the
/// step computes anyway; from the Legendre coefficients of μ̇ at the stages, since δ vanishes along straight motions; and from what their
/// polynomial misses at the ends of the step, which shows kinks of a force, such as that of a quadratic drag at rest. Order: Gauss with
/// eight stages for tolerances below 10⁻⁶, six below 10⁻⁴, four above.
///
/// A run is not reversible: the steps differ on the way back. For that, take fixed steps with [`VariationalInLanes`]. At a jump of a
/// force it ends in an error, or passes it unseen where it is small: run up to a known jump and on from there, or take
/// [`Solve`](crate::integrators::solve::Solve), which finds jumps.
#[derive(Clone, Debug)]
pub struct AdaptiveInLanes<F, R: FastRetraction<N, D>, const N: usize, const D: usize> {
    /// Gauss with 4, 6 and 8 stages.
    methods: [VariationalInLanes<F, R, N, D>; 3],
    sizes: Sizes<N>,
    most: usize,
}

impl<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize> AdaptiveInLanes<F, R, N, D> {
    /// The solver of a body, a force and a retraction.
    pub fn new(lagrangian: Quadratic<f64, N>, force: F, retraction: R) -> Self {
        let sizes = Sizes::of(retraction.algebra());
        let methods = [4, 6, 8].map(|stages| gauss(&lagrangian, &force, retraction.clone(), stages));
        Self { methods, sizes, most: MOST_STEPS }
    }

    /// The same with another limit to the steps that a run may try than a million.
    pub fn with_max_steps(mut self, steps: usize) -> Self {
        self.most = steps;
        self
    }

    /// Replaces `state` by the state a time `duration` later (of either sign), to a relative error of about `tolerance`.
    ///
    /// # Errors
    /// See [`SolveError`].
    pub fn solve(&mut self, state: &mut State<f64, N, D>, duration: f64, tolerance: f64) -> Result<Solved, SolveError> {
        self.solve_with(state, duration, tolerance, |_, _| ())
    }

    /// The same; `observe` is called after each step with the step's size.
    ///
    /// # Errors
    /// See [`SolveError`].
    pub fn solve_with(
        &mut self,
        state: &mut State<f64, N, D>,
        duration: f64,
        tolerance: f64,
        mut observe: impl FnMut(&State<f64, N, D>, f64),
    ) -> Result<Solved, SolveError> {
        let mut pace = Pace { first: LARGEST_FIRST_ANGLE, growth: GROWTH, steady: None };
        let Self { methods, sizes, most } = self;
        sizes.largest = [[0.0; N]; 2];
        drive(
            methods,
            *most,
            state,
            [duration, tolerance],
            &mut observe,
            |method, run, place, [momentum, eta], observe| {
                let size = length(momentum);
                let turning = length(method.slope(run.time(), &place.packed, [momentum, eta]));
                let rate = method.group.turning(eta) + if size > 0.0 { turning / size } else { 0.0 };
                if run.fresh() {
                    let order = 2 * method.tableau().stages();
                    let angle = REACH * (run.per_time() / rate).powf(1.0 / (order + 1) as f64);
                    pace.first = angle.min(LARGEST_FIRST_ANGLE);
                }
                let (time, packed, now) = (run.time(), place.packed, [momentum, eta]);
                let ratios = |method: &VariationalInLanes<F, R, N, D>, step, allowed| {
                    sizes.ratios(now, &method.inverse, step, allowed, || method.slope(time, &packed, now))
                };
                advance(method, run, place, || rate, pace, ratios, observe)
            },
        )
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
        slope: impl Fn() -> [f64; N],
    ) -> Option<[[f64; N]; 2]> {
        self.blocks.each().nth(1)?;
        let mut found = [self.blocks.sizes(&momentum), self.blocks.sizes(&eta)];
        if found.as_flattened().contains(&0.0) {
            let gained = slope().map(|v| step * v);
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

/// Where a run is in time; the state is the caller's.
pub(in crate::integrators) struct Run {
    start: f64,
    pub sign: f64,
    pub span: f64,
    /// The tolerance a unit of time.
    per_time: f64,
    pub done: f64,
    /// The step to try next; infinite at the start.
    pub next: f64,
    failures: usize,
    /// How much the forces change as g does, where a step was refused; else 0.
    sensitivity: f64,
    solved: Solved,
    /// The steps that it may try.
    most: usize,
}

/// The state of a run, as the kernel has it and as its owner sees it.
pub(in crate::integrators) struct Place<'a, const N: usize, const D: usize> {
    pub packed: Packed<N, D>,
    pub state: &'a mut State<f64, N, D>,
    /// The number of steps after which the attitude is straightened next.
    straight: usize,
}

impl<'a, const N: usize, const D: usize> Place<'a, N, D> {
    /// The place of a run that begins.
    #[inline]
    fn new(state: &'a mut State<f64, N, D>) -> Self {
        Self { packed: Packed::of(state), state, straight: STRAIGHT }
    }

    /// Takes back now and then what rounding has made of gᵀg.
    #[inline]
    fn keep_straight(&mut self, run: &Run, rotation: usize) {
        if run.solved.steps == self.straight {
            self.straight += STRAIGHT;
            straighten(&mut self.packed, rotation);
        }
    }

    /// The state that the kernel has reached.
    #[inline]
    pub fn reach(&mut self, time: f64) -> &State<f64, N, D> {
        self.packed.unpack(self.state);
        self.state.time = time;
        self.state
    }
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

/// Gauss with some stages, on a body and a force.
pub(in crate::integrators) fn gauss<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize>(
    lagrangian: &Quadratic<f64, N>,
    force: &F,
    retraction: R,
    stages: usize,
) -> VariationalInLanes<F, R, N, D> {
    let tableau = Family::Gauss.tableau(stages).expect("Gauss has any number of stages");
    VariationalInLanes::new(lagrangian.clone(), force.clone(), retraction, tableau).expect("at most eight stages")
}

/// A run with the method, of those with 4, 6 and 8 stages, that the tolerance asks for. `step` takes a step from the momentum and the
/// velocity given, or tries one in vain.
#[inline]
pub(in crate::integrators) fn drive<F, R, O, const N: usize, const D: usize>(
    methods: &mut [VariationalInLanes<F, R, N, D>; 3],
    most: usize,
    state: &mut State<f64, N, D>,
    [duration, tolerance]: [f64; 2],
    observe: &mut O,
    mut step: impl FnMut(
        &mut VariationalInLanes<F, R, N, D>,
        &mut Run,
        &mut Place<'_, N, D>,
        [[f64; N]; 2],
        &mut O,
    ) -> Result<(), SolveError>,
) -> Result<Solved, SolveError>
where
    F: LaneForce<N, D>,
    R: FastRetraction<N, D>,
    O: FnMut(&State<f64, N, D>, f64),
{
    let Some(mut run) = Run::start(state, duration, tolerance, most)? else {
        return Ok(Solved::default());
    };
    let mut place = Place::new(state);
    let method = match tolerance {
        t if t < 1e-6 => &mut methods[2],
        t if t < 1e-4 => &mut methods[1],
        _ => &mut methods[0],
    };
    while run.done < run.span {
        place.keep_straight(&run, method.group.rotation());
        let momentum = place.packed.momentum;
        let eta = velocity(&method.inverse, momentum);
        if momentum == [0.0; N] {
            let still = |t| method.slope(t, &place.packed, [momentum, eta]) == [0.0; N];
            if still(run.time()) && run.times(method.tableau()).all(still) {
                // At rest, and nothing that moves it, now or at the stages of a step to the end.
                run.check(place.state)?;
                let left = run.span - run.done;
                run.rest();
                place.state.time = run.time();
                observe(place.state, run.sign * left);
                break;
            }
        }
        step(method, &mut run, &mut place, [momentum, eta], observe)?;
    }
    Ok(run.solved)
}

impl Run {
    /// A run over `duration` from `state`; none if it is over already.
    #[inline]
    fn start<const N: usize, const D: usize>(
        state: &State<f64, N, D>,
        duration: f64,
        tolerance: f64,
        most: usize,
    ) -> Result<Option<Self>, SolveError> {
        if !duration.is_finite() {
            return Err(SolveError::BadInput { what: "the duration", value: duration, needed: "finite" });
        }
        if !(tolerance > 0.0 && tolerance < 1.0) {
            return Err(SolveError::BadInput { what: "the tolerance", value: tolerance, needed: "between 0 and 1" });
        }
        if duration == 0.0 {
            return Ok(None);
        }
        let span = duration.abs();
        let run = Self {
            start: state.time,
            sign: duration.signum(),
            span,
            per_time: tolerance / span,
            done: 0.0,
            next: f64::INFINITY,
            failures: 0,
            sensitivity: 0.0,
            solved: Solved::default(),
            most,
        };
        if !state.time.is_finite() {
            run.check(state)?;
        }
        Ok(Some(run))
    }

    /// Whether the state that the run starts from is finite: before it is left as it is or turned, and when the first step
    /// fails. The kernel refuses any other.
    #[cold]
    pub fn check<const N: usize, const D: usize>(&self, state: &State<f64, N, D>) -> Result<(), SolveError> {
        let duration = self.sign * self.span;
        state.check_finite(duration).map_err(|source| SolveError::Stuck { time: state.time, step: duration, source })
    }

    /// Whether no step was tried yet.
    pub fn fresh(&self) -> bool {
        self.next == f64::INFINITY
    }

    /// The times of the stages of a step to the end.
    pub fn times(&self, tableau: &Tableau<f64>) -> impl Iterator<Item = f64> {
        let (time, left) = (self.time(), self.sign * (self.span - self.done));
        tableau.c().iter().map(move |c| left.mul_add(*c, time))
    }

    /// The tolerance a unit of time.
    pub fn per_time(&self) -> f64 {
        self.per_time
    }

    /// The rest of the time passes without a step of the method.
    pub fn rest(&mut self) {
        self.done = self.span;
        self.solved.steps += 1;
    }

    #[inline]
    pub fn time(&self) -> f64 {
        self.start + self.sign * self.done
    }
}

/// How a solver goes about its steps.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrators) struct Pace {
    /// The angle of the first step that is tried.
    pub first: f64,
    /// How much longer than the last a step may be.
    pub growth: f64,
    /// The largest angle of a step of a motion that is nearly steady, whose residual falls as far as rounding allows.
    pub steady: Option<f64>,
}

/// By how much what rounding makes of the forces must exceed all that residuals were relative to, for a step to be tried again with it.
const DECIDES: f64 = 4.0;

/// A step that is not the last: two equal ones rather than a long and a very short one. No part of the caller, so that the
/// processor need not wait for it where the step is the last.
#[inline(never)]
fn shorter(next: f64, left: f64) -> f64 {
    next.min(0.5 * left)
}

/// One step, or one that was tried in vain; `rate` is the angle per time.
#[inline]
pub(in crate::integrators) fn advance<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize>(
    method: &mut VariationalInLanes<F, R, N, D>,
    run: &mut Run,
    place: &mut Place<'_, N, D>,
    rate: impl Fn() -> f64,
    pace: Pace,
    ratios: impl FnOnce(&VariationalInLanes<F, R, N, D>, f64, f64) -> Option<[[f64; N]; 2]>,
    observe: &mut impl FnMut(&State<f64, N, D>, f64),
) -> Result<(), SolveError> {
    let stages = method.stages();
    let order = 2 * stages as i32;
    if run.fresh() {
        let first = pace.first / rate();
        run.next = if first.is_finite() { first } else { run.span };
    }
    if let Some(angle) = pace.steady {
        // Short of the singularity of dτ; there is room for the motion to turn faster.
        run.next = run.next.min(angle / rate());
    }
    let tried = run.solved.steps + run.solved.rejected;
    if tried >= run.most {
        return Err(SolveError::TooManySteps { time: run.time(), step: run.sign * run.next, steps: tried });
    }
    let left = run.span - run.done;
    let last = run.next >= left;
    let step = if last { left } else { shorter(run.next, left) };
    // Below this, δ is rounding.
    let allowed = (run.per_time * step).max(NOISE * SAFETY * f64::unit_roundoff());
    let ratios = ratios(method, step, allowed);
    // What a nearly steady rotation must not lose is that it becomes ever more steady.
    let tolerance = if pace.steady.is_some() { 0.0 } else { run.per_time * step }.max(16.0 * f64::unit_roundoff());
    let limits = Limits {
        tolerance,
        floor: tolerance.max(1024.0 * f64::unit_roundoff()),
        rounding: Limits::<N>::rounding(step, run.sensitivity, tolerance),
        switch: tolerance,
        max_fixed_point_iterations: 30,
        strict: Some(Strict { most: allowed / SAFETY, noise: NOISE * f64::unit_roundoff(), ratios }),
    };
    match method.take(Some(&mut place.packed), run.time(), run.sign * step, false, limits) {
        Ok(taken) => {
            run.done = if last { run.span } else { run.done + step };
            run.failures = 0;
            let iterations = taken.predictor + taken.iterations;
            let solved = &mut run.solved;
            solved.steps += 1;
            solved.iterations += iterations;
            if taken.residual > solved.residual {
                solved.residual = taken.residual;
            }
            solved.error += SAFETY * taken.whole;
            observe(place.reach(run.time()), run.sign * step);
            if !last {
                // As long as the error allows, and as long as fixed-point iterations contract well.
                let room = logarithm(allowed) - logarithm(SAFETY * taken.delta.max(f64::MIN_POSITIVE)) - MARGIN;
                let wanted = match iterations {
                    n if n < stages + 10 => pace.growth,
                    n if n <= stages + 11 => 1.0,
                    _ => 0.8,
                };
                run.next = step * growth(room.clamp(-f64::from(order), f64::from(order)), order).min(wanted);
            }
            Ok(())
        }
        outcome => {
            if tried == 0 {
                run.check(place.state)?;
            }
            run.solved.rejected += 1;
            run.failures += 1;
            run.sensitivity = method.sensitivity_at(place.state);
            if Limits::<N>::rounding(step, run.sensitivity, tolerance)
                > limits.rounding.max(place.state.momentum.amax()) * DECIDES
            {
                // Near an equilibrium: the same again.
                return Ok(());
            }
            let error = match outcome {
                Err(Refused::Delta(delta)) => Some(SAFETY * delta),
                _ => None,
            };
            let shrink = error.map_or(0.6, |e| growth(logarithm(allowed) - logarithm(e) - 2.0, order).clamp(0.2, 0.8));
            run.next = step * shrink;
            let least = (LEAST_ANGLE / rate()).min(run.span * 1e-6);
            if run.next > least && run.failures <= 60 {
                return Ok(());
            }
            let time = run.time();
            Err(match error {
                Some(error) => SolveError::Tolerance { time, step, error, wanted: allowed },
                None => SolveError::Stuck { time, step, source: method.diagnose(place.state, run.sign * step) },
            })
        }
    }
}

#[inline]
pub(in crate::integrators) fn velocity<const N: usize>(inverse: &[[f64; N]; N], m: [f64; N]) -> [f64; N] {
    each!(N, r => (1..N).fold(inverse[r][0] * m[0], |sum, c| sum + inverse[r][c] * m[c]))
}

#[inline]
pub(in crate::integrators) fn length<const N: usize>(x: [f64; N]) -> f64 {
    x.iter().fold(0.0, |sum, v| sum + v * v).sqrt()
}
