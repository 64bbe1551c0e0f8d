//! Two steps of h, and the error that they make: one step of 2h from the same start.

use super::control::{AIM, Attempt, Effort, NOISE, Plan, Statistics};
use super::measure::{Chart, Difference, Ease, Measure};
use super::passed::{Passed, Point, Stages};
use super::smooth::{Ends, Jump};
use super::through::Through;
use crate::algebra::{Covector, Matrix, Vector, pull};
use crate::integrators::variational::{Exchange, Uncontracted, Variational};
use crate::integrators::{Report, Solver, State, StepError};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, TangentPoint};
use crate::scalar::{Real, larger};
use crate::tableau::Tableau;
use crate::tableau::assumptions::Assumptions;
use crate::tableau::bounds::Bounds;
use crate::tableau::order::variational_order;
use crate::tableau::quantity::Coefficients;

/// The stage equations are solved to this share of the error that a pair may make: its results, and their difference, know no more.
const SOLVED: i64 = 16;

/// Those of the step of 2h to this share of a difference that stands for this error, and never more loosely than the second: that is
/// larger by 2^p − 1.
const SOLVED_COARSE: i64 = 64;
const LOOSEST: f64 = 1e-3;

/// The estimate is taken times this: that the error falls like h^(p+1) from 2h to h is true of short steps only. The error of runs on
/// SO(3), SE(2), SE(3) and of a heavy top is then between a hundredth and a half of the tolerance, from 10⁻⁴ to 10⁻¹².
const SAFETY: i64 = 2;

/// What the stages miss falls by up to this many powers of 2 less than in the limit, in motions that change from one step to the next: in all
/// but ten of 1,300 pairs on SO(3), SE(2), SL(2), SE(3) and SO(4). Where it falls by less, a feature of the motion is shorter than the steps, or a pair
/// longer than the motion allows, and the difference falls by less than its order says.
const ROOM: f64 = 2.0;

/// Where they miss more than this share of the velocity, there is no such room: that is no limit yet. Of a light body on SL(2) (inertia 1/64) that
/// turned round within a step they missed a twentieth, and a difference of 150 tolerances counted as one. No pair of the five groups from 10⁻³ to
/// 10⁻¹² misses so much and needs the room.
const COARSE: f64 = 1.0 / 64.0;

/// Nothing is a jump that is missed by the first share of the powers of 2 less with h than with 2h, and by the second number of them at least: interpolation through the
/// stages makes up to 5 times a jump of it.
const SMOOTH: f64 = 0.75;
const STEEP: f64 = 2.5;

/// The share of the momentum by which it is changed to see how the velocity follows.
const PROBE: f64 = 1.0 / 1024.0;

/// The number of times until the end of a run at which forces are looked at, where a step would have to be shorter than the time shows.
const AHEAD: i64 = 64;

/// A residual makes a difference of no more than this multiple of itself.
const EXPLAINED: i64 = 4;

/// Orders up to this are looked up in trees where the simplifying assumptions decide nothing: that takes microseconds.
const TREES: usize = 6;

/// A step up to this multiple of the last one starts from what is extrapolated from that.
const FARTHEST: f64 = 1.5;

/// The order of the scheme with a tableau, no more than what is proven from the coefficients, and that of its stages and of the velocities there.
///
/// Source: [`Bounds`], and [`variational_order`] for low orders.
fn orders<T: Real>(tableau: &Tableau<T>) -> (usize, [usize; 2]) {
    let coefficients = Coefficients::of(tableau);
    let assumptions = Assumptions::of(&coefficients);
    let [_, proven] = Bounds::of(&coefficients, &assumptions, 2 * tableau.stages());
    let order = match proven.least == proven.most || proven.least >= TREES {
        true => proven.least,
        false => variational_order(tableau, TREES).order.max(proven.least),
    };
    let order = order.max(1);
    (order, [assumptions.c.holds.clamp(1, order), assumptions.c.holds.min(assumptions.d.holds)])
}

/// What part of a difference that falls with this order is the error.
fn share_of<T: Real>(order: f64) -> T {
    let falls = if order.fract() == 0.0 { T::int(2).powi(order as i32) } else { T::exact(order.exp2()) } - T::one();
    // No error is larger than the difference.
    (T::int(SAFETY) / falls).min(T::one())
}

/// Where the first guess of the next step comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Guess {
    /// A constant velocity.
    Cold,
    /// The step before.
    After,
    /// The first of two steps that were refused.
    Within,
}

/// The method, twice: for steps of h and of 2h, each with its own stages.
pub(super) struct Pair<T: Real, const N: usize, const D: usize, L, F, R> {
    fine: Variational<T, N, D, L, F, R>,
    coarse: Variational<T, N, D, L, F, R>,
    /// The order of the method.
    pub order: usize,
    /// The q of C(q): what is left of the order where a force is stiff.
    stage_order: usize,
    /// That of the velocities at the stages, which come from the momenta: of C(q) and of D(q), which is C(q) of the conjugate tableau.
    stage_order_of_velocities: usize,
    pub through: Through<T>,
    row: Vec<T>,
    c: Vec<T>,
    /// For each stage of the step of 2h: which of the two steps it lies in, and its row there.
    inside: Vec<(usize, Vec<T>)>,
    /// What the stages predict of the force at the ends of a step.
    ends: Option<Ends<T>>,
    guess: Guess,
    before: Stages<T, N>,
    /// Of all points so far.
    measure: Measure<T, N>,
    /// Of these and of the pair at hand.
    pub here: Measure<T, N>,
    chart: Option<Chart<T, N, D>>,
    /// The largest force that is known to come.
    ahead: T,
    pub halves: [Stages<T, N>; 2],
    /// The start, the middle and the end.
    pub points: [Point<T, N, D>; 3],
}

impl<T, const N: usize, const D: usize, L, F, R> Pair<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    pub fn new(parts: (&L, &F, &R), tableau: &Tableau<T>, state: &State<T, N, D>) -> Self
    where
        L: Clone,
        F: Clone,
        R: Clone,
    {
        let engine = || {
            let mut engine = Variational::new(parts.0.clone(), parts.1.clone(), parts.2.clone(), tableau.clone());
            engine.leave_to_comparison();
            engine
        };
        let through = Through::new(tableau.c().as_slice());
        let inside = tableau.c().iter().map(|&c| {
            let (x, mut row) = (c * T::int(2), vec![T::zero(); through.len()]);
            let half = usize::from(x > T::one());
            through.row(x - T::int(half as i64), &mut row);
            (half, row)
        });
        let half = Stages::new(tableau.stages());
        let point = Point::new(state);
        let (order, [stage_order, stage_order_of_velocities]) = orders(tableau);
        Self {
            order,
            stage_order,
            stage_order_of_velocities,
            inside: inside.collect(),
            ends: Ends::new(tableau.c().as_slice()),
            row: vec![T::zero(); through.len()],
            c: tableau.c().iter().copied().collect(),
            through,
            guess: Guess::Cold,
            before: half.clone(),
            here: Measure::new(parts.2.algebra()),
            measure: Measure::new(parts.2.algebra()),
            chart: Chart::of(parts.2),
            ahead: T::zero(),
            halves: [half.clone(), half],
            points: [point.clone(), point.clone(), point],
            fine: engine(),
            coarse: engine(),
        }
    }

    pub fn retraction(&self) -> &R {
        self.fine.retraction()
    }

    pub fn tableau(&self) -> &Tableau<T> {
        self.fine.tableau()
    }

    /// Step k.
    pub fn passed(&self, k: usize) -> Passed<'_, T, N, D, L, F, R> {
        Passed {
            method: &self.fine,
            start: &self.points[k],
            end: &self.points[k + 1],
            stages: &self.halves[k],
            through: &self.through,
            measure: &self.here,
        }
    }

    /// The energy taken up in a unit of time, at a state in step k.
    pub fn power(&self, state: &State<T, N, D>, k: usize) -> Result<Exchange<T>, StepError> {
        self.fine.power(state, &self.points[k].velocity, self.halves[k].step)
    }

    /// The energy taken up in step k, by the quadrature of the tableau.
    pub fn exchange(&self, k: usize) -> Exchange<T> {
        let Stages { step, displacements, velocities, .. } = &self.halves[k];
        let stages = velocities.iter().copied().zip(displacements.iter().copied());
        self.fine.exchange(&self.points[k].state, *step, stages)
    }

    /// Begins a run at a state.
    pub fn begin(&mut self, state: &State<T, N, D>) -> Result<(), StepError> {
        state.check_finite(T::zero())?;
        self.points[0].state = state.clone();
        (self.guess, self.ahead) = (Guess::Cold, T::zero());
        self.fine.look(&mut self.points[0], &Vector::zeros(), T::zero())?;
        self.measure.reset();
        self.reach();
        Ok(())
    }

    /// The first point is reached: what errors are relative to from there.
    fn reach(&mut self) {
        let Point { state, velocity, .. } = &self.points[0];
        let rest = self.at_rest(state).map(|v| v.abs());
        let size = state.momentum.amax() + rest.amax();
        self.measure.grow(&(state.momentum.map(|v| v.abs()) + rest), velocity, &Vector::zeros());
        self.measure.size = size;
        let apart = if size > T::zero() { size * T::exact(PROBE) } else { T::one() };
        let mut mobility = Matrix::<T, N>::zeros();
        for a in 0..N {
            let mut moved = state.clone();
            moved.momentum[a] += apart;
            let apart = moved.momentum[a] - state.momentum[a];
            // Where there is no velocity so near, nothing is known.
            if let Ok(there) = self.fine.velocity_at(&moved, velocity, T::zero()) {
                mobility.set_column(a, &((there - velocity) / apart).map(|v| v.abs()));
            }
        }
        self.measure.mobility = mobility;
    }

    /// The largest force at the momentum and the attitude of the first point at times until the end: rounding of what makes it counts from here on.
    /// Whether it is more than was known.
    pub fn look_ahead(&mut self, end: T) -> bool {
        let Point { state, velocity, .. } = &self.points[0];
        let mut most = self.ahead;
        for k in 1..=AHEAD {
            let time = state.time + (end - state.time) * T::ratio(k, AHEAD);
            if let Ok((_, load)) = self.fine.force_at(&State { time, ..state.clone() }, velocity, T::zero()) {
                most = most.max(load.amax());
            }
        }
        most > std::mem::replace(&mut self.ahead, most)
    }

    /// The rate at which μ, or g, changes at a point, relative to its size.
    pub fn rate(&self, k: usize, ease: Ease) -> T {
        let Point { state, velocity, force, .. } = &self.points[k];
        let (algebra, blocks) = (self.fine.retraction().algebra(), &self.measure.blocks);
        let sizes = blocks.sizes((state.momentum.map(|v| v.abs()) + self.at_rest(state).map(|v| v.abs())).as_slice());
        let changes = blocks.sizes((algebra.coad(velocity, &state.momentum) + force).as_slice());
        let rounding = self.measure.size * T::int(NOISE) * T::unit_roundoff();
        let turning = self.measure.turning(&algebra.ad(velocity), ease);
        let moving = blocks.each().filter(|&a| sizes[a] > rounding);
        moving.fold(turning, |most, a| most.max(changes[a] / sizes[a]))
    }

    /// ∂L/∂η at η = 0: the momentum of a rotor.
    fn at_rest(&self, state: &State<T, N, D>) -> Covector<T, N> {
        self.fine.momentum_at(state, &Vector::zeros())
    }

    /// The coordinate of the velocity that turns fastest at the first point, and its value.
    pub fn fastest(&self) -> (usize, T) {
        let turning = self.measure.blocks.turning(&self.points[0].velocity);
        (0..N).fold((0, T::zero()), |most, a| if turning[a].abs() > most.1.abs() { (a, turning[a]) } else { most })
    }

    /// Takes the two steps of a plan and the one of 2h, and returns the estimated error of the two. The points and halves hold them.
    pub fn attempt(&mut self, plan: &Plan<T>, statistics: &mut Statistics<T>) -> Result<Attempt<T>, Uncontracted> {
        let factors = self.measure.factors(NOISE);
        self.fine.set_factors(factors);
        self.coarse.set_factors(factors);
        let tolerance = plan.allowed / T::int(SOLVED);
        self.fine.set_tolerance(tolerance);
        // Where the difference counts as it is, nothing else may explain it.
        let falls = if plan.smooth { T::int(2).powi(self.order as i32) - T::one() } else { T::one() };
        let loosely = plan.allowed * falls / T::int(SOLVED_COARSE);
        self.coarse.set_tolerance(loosely.min(T::exact(LOOSEST)).max(tolerance));
        let guess = std::mem::replace(&mut self.guess, Guess::Cold);
        let (mut residual, mut noise, mut effort) = (T::zero(), T::zero(), Effort::Little);
        let mut note = |report: Report<T>, rate: f64| {
            statistics.iterations += report.iterations;
            effort = effort.max(match report.solver {
                Solver::FixedPoint => Effort::of_rate(rate),
                _ => Effort::Newton,
            });
            noise += if effort == Effort::Newton { report.residual.min(plan.allowed) } else { report.residual };
        };
        for k in 0..2 {
            self.predict(k, guess, plan.step);
            let report = self.take(k, plan)?;
            note(report, self.fine.contraction());
            residual = residual.max(report.residual);
            if k == 0 {
                self.guess = Guess::Within;
            }
        }
        let mut doubled = self.points[0].state.clone();
        let (inside, through, halves) = (&self.inside, &self.through, &self.halves);
        let two = plan.step * T::int(2);
        self.coarse.predict(two, &doubled.momentum, |i| {
            let (half, row) = &inside[i];
            let Stages { ends, velocities, .. } = &halves[*half];
            through.value(row, [&ends[0], &ends[1]], velocities)
        });
        let report = self.coarse.attempt(&mut doubled, two, plan.newton)?;
        note(report, self.coarse.contraction());
        self.here = self.measured(two);
        let measure = &self.here;
        let share = match (plan.smooth, effort) {
            (false, _) => [T::one(); N],
            (true, Effort::Newton) => [share_of(self.stage_order as f64); N],
            (true, _) => self.resolved(plan, measure).map(|resolved| share_of(self.order as f64 * resolved)),
        };
        let difference = self.difference(&doubled, two)?.times(&share);
        let unseen = measure.of_momentum(self.unseen(plan, measure)?);
        // What the residuals explain does not fall with h.
        let judge = |noise: T, rounding: &Covector<T, N>| {
            let missed = measure.relative(&difference, rounding, share.map(|share| share * noise * T::int(EXPLAINED)));
            larger(missed, measure.relative(&unseen, rounding, [T::zero(); N]))
        };
        let mut rounding = Covector::zeros();
        let (mut error, mut unexplained, mut rounded) = (judge(T::zero(), &rounding), judge(noise, &rounding), false);
        if error > plan.allowed * T::exact(AIM) {
            rounding = self.rounding(two)?;
            (error, unexplained) = (judge(T::zero(), &rounding), judge(noise, &rounding));
            rounded = measure.shifted(&rounding) > plan.allowed;
        }
        let noise = residual.max(T::unit_roundoff() * factors.spread);
        Ok(Attempt { error, unexplained, residual, noise, effort, rounded })
    }

    /// What errors of the pair at hand are relative to.
    fn measured(&self, two: T) -> Measure<T, N> {
        let mut measure = self.measure.clone();
        let rest = self.at_rest(&self.points[0].state).map(|v| v.abs());
        let (mut load, mut size) = (Covector::<T, N>::zeros(), T::zero());
        for point in &self.points {
            let momentum = point.state.momentum.map(|v| v.abs()) + rest;
            size = larger(size, momentum.amax());
            measure.grow(&momentum, &point.velocity, &Vector::zeros());
            load = load.zip_map(&point.load, larger);
        }
        let impulse = load * two.abs();
        let [first, second] = &self.halves;
        let displacement = first.increment.map(|v| v.abs()) + second.increment.map(|v| v.abs());
        measure.grow(&impulse, &measure.moved(&(impulse + rest)), &displacement);
        measure.size = larger(size, impulse.amax());
        measure
    }

    /// What rounding makes of the momentum over a pair: of the sum that turns it, and of the forces where g is rounded. Near an equilibrium that is
    /// more than what is left of the momentum, at steps of any size.
    fn rounding(&self, two: T) -> Result<Covector<T, N>, StepError> {
        let Point { state, velocity, load, .. } = &self.points[0];
        let domain = |source| StepError::Domain { step: two.to_f64(), stage: None, source };
        let turned = self.retraction().at(self.coarse.increment()).map_err(domain)?.ad().map(|v| v.abs());
        let forces = if self.fine.moves() { self.fine.sensitivity(state, velocity) } else { T::zero() };
        let all = state.momentum.map(|v| v.abs()) + load * two.abs();
        let forces = Covector::from_element((forces + self.ahead) * two.abs());
        Ok((pull(&all, &turned) + forces) * (T::int(NOISE) * T::unit_roundoff()))
    }

    /// The share of the order with which the difference can be taken to fall: by how many powers of 2 the stages of h miss the velocities at the
    /// ends of a step by less than those of 2h do, of those of a smooth motion; of each block.
    fn resolved(&self, plan: &Plan<T>, measure: &Measure<T, N>) -> [f64; N] {
        let Some(ends) = &self.ends else { return [1.0; N] };
        let blocks = &measure.blocks;
        let miss = |end: usize, point: usize, stages: &mut dyn Iterator<Item = Vector<T, N>>| {
            (self.points[point].velocity - ends.at[end].value(stages)).map(|v| v.abs())
        };
        let fine = |k: usize, end: usize| miss(end, k + end, &mut self.halves[k].velocities.iter().copied());
        let coarse = |end: usize| miss(end, 2 * end, &mut self.coarse.stage_velocities());
        let both = |one: Vector<T, N>, other: Vector<T, N>| one.zip_map(&other, larger);
        let fine = blocks.sizes(both(both(fine(0, 0), fine(0, 1)), both(fine(1, 0), fine(1, 1))).as_slice());
        let coarse = blocks.sizes(both(coarse(0), coarse(1)).as_slice());
        let speed = self.points.iter().fold(Vector::zeros(), |most, point| both(most, point.velocity.map(|v| v.abs())));
        let speed = blocks.sizes(speed.as_slice());
        let rounding = measure.size * T::int(NOISE) * T::unit_roundoff();
        let rounding = measure.moved(&Covector::from_element(rounding));
        let most = ends.powers(self.stage_order_of_velocities);
        std::array::from_fn(|a| {
            // Less is what is left in the stages.
            if fine[a] <= measure.velocity[a] * plan.allowed + rounding[a] {
                return 1.0;
            }
            let room = if fine[a] <= speed[a] * T::exact(COARSE) { ROOM } else { 0.0 };
            (((coarse[a] / fine[a]).to_f64().log2() + room) / most).clamp(0.0, 1.0)
        })
    }

    /// The momentum that a jump of the force may have made unseen, of each block.
    fn unseen(&self, plan: &Plan<T>, measure: &Measure<T, N>) -> Result<Covector<T, N>, StepError> {
        let mut all = Covector::zeros();
        let Some(ends) = self.ends.as_ref().filter(|_| self.fine.forced()) else { return Ok(all) };
        let sizes = |miss: Covector<T, N>| measure.blocks.sizes(miss.as_slice());
        let at = |k: usize, end: usize| self.miss(ends, plan, (k, end), T::zero()).map(sizes);
        let misses = [[at(0, 0)?, at(0, 1)?], [at(1, 0)?, at(1, 1)?]];
        let mut coarse = None;
        for a in measure.blocks.each() {
            let missed = misses.map(|step| step.map(|sizes| sizes[a]));
            let Some(Jump { step, end, size, share }) = ends.outlier(missed) else { continue };
            let coarse = match coarse {
                Some(coarse) => coarse,
                None => *coarse.insert(sizes(self.miss_coarse(ends, plan)?)),
            };
            let smooth = (ends.powers(self.stage_order_of_velocities) * SMOOTH).max(STEEP);
            if (coarse[a] / size).to_f64().log2() >= smooth {
                continue;
            }
            let passed = plan.step.abs() * share;
            let mut unseen = Covector::zeros();
            measure.blocks.fill(&mut unseen, a, size * passed);
            let error = measure.of_momentum(unseen);
            let error = measure.relative(&error, &Covector::zeros(), [T::zero(); N]);
            if error > plan.allowed {
                // A jump so close to the end does no harm: where a run ends at the time of a jump, or begins there.
                let inside = sizes(self.miss(ends, plan, (step, end), passed * plan.allowed / error)?);
                if inside[a] * T::int(2) < size {
                    unseen *= plan.allowed * T::half() / error;
                }
            }
            all += unseen;
        }
        Ok(all)
    }

    /// How far the force at the ends of a pair is from what the stages of the step of 2h predict.
    fn miss_coarse(&self, ends: &Ends<T>, plan: &Plan<T>) -> Result<Covector<T, N>, StepError> {
        let domain = |source| StepError::Domain { step: plan.step.to_f64(), stage: None, source };
        let last = self.points[2].force * self.retraction().at(self.coarse.increment()).map_err(domain)?.ad_inv();
        let miss = |end: usize, force: Covector<T, N>| {
            let mut stages = self.coarse.stage_rates().map(|(_, force)| force);
            (force - ends.at[end].value(&mut stages)).map(|v| v.abs())
        };
        Ok(miss(0, self.points[0].force).zip_map(&miss(1, last), larger))
    }

    /// How far the force at an end of step k, or so much later or earlier in it, is from what the stages predict.
    fn miss(
        &self,
        ends: &Ends<T>,
        plan: &Plan<T>,
        (k, end): (usize, usize),
        inward: T,
    ) -> Result<Covector<T, N>, StepError> {
        let half = &self.halves[k];
        let Point { state, velocity, force, .. } = &self.points[k + end];
        let mut force = *force;
        if inward > T::zero() {
            let forward = (plan.step > T::zero()) == (end == 0);
            let time = if forward { state.time + inward } else { state.time - inward };
            (force, _) = self.fine.force_at(&State { time, ..state.clone() }, velocity, plan.step)?;
        }
        if end == 1 {
            let domain = |source| StepError::Domain { step: plan.step.to_f64(), stage: None, source };
            force *= self.retraction().at(&half.increment).map_err(domain)?.ad_inv();
        }
        Ok(force - ends.at[end].value(&mut half.rates.iter().map(|&(_, force)| force)))
    }

    /// The pair is kept: the next one starts at its end.
    pub fn accept(&mut self) {
        let rest = self.at_rest(&self.points[0].state).map(|v| v.abs());
        let momentum = self.points[1].state.momentum.map(|v| v.abs()) + rest;
        let displacement = self.halves.iter().fold(Vector::zeros(), |sum, half| sum + half.increment.map(|v| v.abs()));
        self.measure.grow(&momentum, &self.points[1].velocity, &displacement);
        let [first, _, end] = &mut self.points;
        std::mem::swap(first, end);
        std::mem::swap(&mut self.before, &mut self.halves[1]);
        self.guess = Guess::After;
        self.reach();
    }

    /// The stage velocities of step k: of the first from the step before or from a longer one, of the second from the first.
    fn predict(&mut self, k: usize, guess: Guess, step: T) {
        let (half, offset) = match (k, guess) {
            (1, _) => (&self.halves[0], T::one()),
            (_, Guess::Cold) => return,
            (_, Guess::After) => (&self.before, T::one()),
            (_, Guess::Within) => (&self.halves[0], T::zero()),
        };
        let (ratio, row, through, c) = (step / half.step, &mut self.row, &self.through, &self.c);
        let near = ratio > T::zero() && ratio < T::exact(FARTHEST);
        if near && through.row(offset + ratio, row) {
            self.fine.predict(step, &self.points[k].state.momentum, |i| {
                through.row(offset + ratio * c[i], row);
                through.value(row, [&half.ends[0], &half.ends[1]], &half.velocities)
            });
        }
    }

    /// Step k of h.
    fn take(&mut self, k: usize, plan: &Plan<T>) -> Result<Report<T>, Uncontracted> {
        let (before, after) = self.points.split_at_mut(k + 1);
        let (start, end) = (&before[k], &mut after[0]);
        end.state.clone_from(&start.state);
        let report = self.fine.attempt(&mut end.state, plan.step, plan.newton)?;
        end.state.time = plan.times[k];
        let half = &mut self.halves[k];
        (half.step, half.increment, half.ends[0]) = (plan.step, *self.fine.increment(), start.velocity);
        half.displacements.iter_mut().zip(self.fine.stage_displacements()).for_each(|(to, from)| *to = from);
        half.velocities.iter_mut().zip(self.fine.stage_velocities()).for_each(|(to, from)| *to = from);
        half.rates.iter_mut().zip(self.fine.stage_rates()).for_each(|(to, from)| *to = from);
        let guess = half.velocities[half.velocities.len() - 1];
        self.fine.look(&mut self.points[k + 1], &guess, plan.step)?;
        self.halves[k].ends[1] = self.points[k + 1].velocity;
        Ok(report)
    }

    /// How far the result of one step of 2h is from that of two: the momenta, the velocities, and τ(−ξ) τ(ξ₁) τ(ξ₂), as a displacement.
    fn difference(&self, doubled: &State<T, N, D>, two: T) -> Result<Difference<T, N>, StepError> {
        let end = &self.points[2];
        let momentum = (end.state.momentum - doubled.momentum).map(|v| v.abs());
        let velocity = (end.velocity - self.fine.velocity_at(doubled, &end.velocity, two)?).map(|v| v.abs());
        let mut displacement = Vector::zeros();
        if let Some(chart) = &self.chart {
            let tau = |x: &Vector<T, N>| {
                let domain = |source| StepError::Domain { step: two.to_f64(), stage: None, source };
                self.fine.retraction().tau::<T>(x).map_err(domain)
            };
            let [first, second] = &self.halves;
            let (back, forward) = (tau(&-self.coarse.increment())?, tau(&first.increment)? * tau(&second.increment)?);
            let rounding = chart.rounding(&(back.map(|v| v.abs()) * forward.map(|v| v.abs())));
            let rounding = rounding * (T::int(NOISE) * T::unit_roundoff());
            let missed = chart.coordinates(&(back * forward)).map(|v| v.abs());
            displacement =
                missed.zip_map(&rounding, |x, rounding| if x <= rounding { T::zero() } else { x - rounding });
        }
        Ok(Difference { momentum, velocity, displacement })
    }
}
