//! Two steps of h, and the error that they make: one step of 2h from the same start.

use super::control::{AIM, Attempt, Effort, NOISE, Plan};
use super::smooth::{Ends, Jump};
use super::statistics::Statistics;
use super::through::{Rates, Through};
use crate::algebra::{Covector, Vector};
use crate::integrators::variational::{Exchange, Uncontracted, Variational, relative};
use crate::integrators::{OneStep, Report, Solver, State, StepError};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Real, finite, larger, max_abs};
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

/// What the stages miss falls by up to so many powers of 2 less than in the limit, in motions that change from one step to the next: in all
/// but ten of 1,300 pairs on SO(3), SE(2), SL(2), SE(3) and SO(4). Where it falls by less, a feature of the motion is shorter than the steps, or a pair
/// longer than the motion allows, and the difference falls by less than its order says.
const ROOM: f64 = 2.0;

/// Where they miss more than this share of the velocity, there is no such room: that is no limit yet. Of a light body on SL(2) (inertia 1/64) that
/// turned round within a step they missed a twentieth, and a difference of 150 tolerances counted as one. No pair of the five groups from 10⁻³ to
/// 10⁻¹² misses so much and needs the room.
const COARSE: f64 = 1.0 / 64.0;

/// Nothing is a jump that is missed by so large a share of the powers of 2 less with h than with 2h, and by so many at least: interpolation through the
/// stages makes up to 5 times a jump of it.
const SMOOTH: f64 = 0.75;
const STEEP: f64 = 2.5;

/// A residual makes a difference of no more than so many times itself.
const EXPLAINED: i64 = 4;

/// Orders up to this are looked up in trees where the simplifying assumptions decide nothing: that takes microseconds.
const TREES: usize = 6;

/// A step up to so many times the last one starts from what is extrapolated from that.
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

/// A step, by Newton's method only where that is allowed.
fn solved<T, const N: usize, const D: usize, L, F, R>(
    method: &mut Variational<T, N, D, L, F, R>,
    state: &mut State<T, N, D>,
    step: T,
    newton: bool,
) -> Result<Report<T>, Uncontracted>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    if newton { Ok(method.step(state, step)?) } else { method.contract(state, step) }
}

/// What is known at one state.
#[derive(Clone, Debug)]
pub(super) struct Point<T: Real, const N: usize, const D: usize> {
    pub state: State<T, N, D>,
    /// η.
    pub velocity: Vector<T, N>,
    /// ∂_gL + f.
    pub force: Covector<T, N>,
    /// |∂_gL| + |f|: they cancel at equilibria.
    load: T,
}

/// The stages of a step of h.
#[derive(Clone, Debug)]
pub(super) struct Half<T: Real, const N: usize> {
    pub step: T,
    /// ξ.
    pub increment: Vector<T, N>,
    /// Ξ_i.
    pub displacements: Vec<Vector<T, N>>,
    /// η_i.
    pub velocities: Vec<Vector<T, N>>,
    /// (ξ̇, ṁ) at the stages.
    pub rates: Vec<Rates<T, N>>,
    /// η at both ends.
    pub ends: [Vector<T, N>; 2],
}

impl<T: Real, const N: usize> Half<T, N> {
    fn new(stages: usize) -> Self {
        let zero = Vector::zeros();
        Self {
            step: T::zero(),
            increment: zero,
            displacements: vec![zero; stages],
            velocities: vec![zero; stages],
            rates: vec![(zero, Covector::zeros()); stages],
            ends: [zero; 2],
        }
    }
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
    order: usize,
    /// The q of C(q): what is left of the order where a force is stiff.
    stage_order: usize,
    /// That of the velocities at the stages, which come from the momenta: of C(q) and of D(q), which is C(q) of the conjugate tableau.
    stage_order_of_velocities: usize,
    through: Through<T>,
    row: Vec<T>,
    c: Vec<T>,
    /// For each stage of the step of 2h: which of the two steps it lies in, and its row there.
    inside: Vec<(usize, Vec<T>)>,
    /// What the stages predict of the force at the ends of a step.
    ends: Option<Ends<T>>,
    guess: Guess,
    before: Half<T, N>,
    pub halves: [Half<T, N>; 2],
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
        let half = Half::new(tableau.stages());
        let zero = Vector::zeros();
        let point = Point { state: state.clone(), velocity: zero, force: Covector::zeros(), load: T::zero() };
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
            halves: [half.clone(), half],
            points: [point.clone(), point.clone(), point],
            fine: engine(),
            coarse: engine(),
        }
    }

    /// The order of the method.
    pub fn order(&self) -> usize {
        self.order
    }

    pub fn through(&self) -> &Through<T> {
        &self.through
    }

    pub fn retraction(&self) -> &R {
        self.fine.retraction()
    }

    pub fn force(&self) -> &F {
        self.fine.force()
    }

    pub fn tableau(&self) -> &Tableau<T> {
        self.fine.tableau()
    }

    /// The energy taken up in step k, by the quadrature of the tableau.
    pub fn exchange(&self, k: usize) -> Exchange<T> {
        let Half { step, displacements, velocities, .. } = &self.halves[k];
        let stages = velocities.iter().copied().zip(displacements.iter().copied());
        self.fine.exchange(&self.points[k].state, *step, stages)
    }

    /// The energy taken up in a unit of time, at a state in step k.
    pub fn power(&self, state: &State<T, N, D>, k: usize) -> Result<Exchange<T>, StepError> {
        let velocity = self.velocity_at(state, &self.points[k].velocity, self.halves[k].step)?;
        Ok(Exchange::rates(self.fine.lagrangian(), self.force(), state, &velocity))
    }

    /// ∂L/∂η at (t, g, η).
    pub fn momentum_at(&self, state: &State<T, N, D>, velocity: &Vector<T, N>) -> Covector<T, N> {
        self.fine.lagrangian().gradient_at(state.time, Configuration::of(&state.attitude), velocity)
    }

    /// The η with ∂L/∂η(t, g, η) = μ.
    pub fn velocity_at(
        &self,
        state: &State<T, N, D>,
        guess: &Vector<T, N>,
        step: T,
    ) -> Result<Vector<T, N>, StepError> {
        let here = Configuration::of(&state.attitude);
        let found = self.fine.lagrangian().velocity_at(state.time, here, &state.momentum, guess);
        found.map_err(|source| StepError::Legendre { step: step.to_f64(), source })
    }

    /// Whether anything depends on the attitude.
    pub fn moves(&self) -> bool {
        self.fine.moves()
    }

    /// Whether there is anything in the place of f.
    pub fn forced(&self) -> bool {
        !self.fine.force().is_zero() || self.fine.lagrangian().uses_configuration()
    }

    /// ∂_gL + f at (t, g, η), and |∂_gL| + |f|.
    pub fn force_at(
        &self,
        state: &State<T, N, D>,
        velocity: &Vector<T, N>,
        step: T,
    ) -> Result<(Covector<T, N>, T), StepError> {
        let (lagrangian, force, here) = (self.fine.lagrangian(), self.fine.force(), Configuration::of(&state.attitude));
        if !self.forced() {
            return Ok((Covector::zeros(), T::zero()));
        }
        let mut total = force.force_at(state.time, here, velocity);
        let mut load = total.amax();
        if lagrangian.uses_configuration() {
            let gradient = lagrangian.configuration_gradient(state.time, here, velocity);
            load += gradient.amax();
            total += gradient;
        }
        if finite(total.as_slice()) {
            return Ok((total, load));
        }
        let why =
            force.undefined(state.time, here, velocity).or_else(|| lagrangian.undefined(state.time, here, velocity));
        let stage = Some(self.fine.tableau().stages() - 1);
        Err(StepError::Undefined { step: step.to_f64(), stage, why })
    }

    /// Begins a run at a state.
    pub fn begin(&mut self, state: &State<T, N, D>) -> Result<(), StepError> {
        state.check_finite(T::zero())?;
        self.points[0].state = state.clone();
        self.guess = Guess::Cold;
        self.look(0, &Vector::zeros(), T::zero())
    }

    /// Evaluates the equations at a point.
    fn look(&mut self, k: usize, guess: &Vector<T, N>, step: T) -> Result<(), StepError> {
        let state = &self.points[k].state;
        let velocity = self.velocity_at(state, guess, step)?;
        let (force, load) = self.force_at(state, &velocity, step)?;
        let point = &mut self.points[k];
        (point.velocity, point.force, point.load) = (velocity, force, load);
        Ok(())
    }

    /// The rate at which μ, or g, changes at a point, relative to its size.
    pub fn rate(&self, k: usize) -> T {
        let Point { state, velocity, force, .. } = &self.points[k];
        let size = state.momentum.amax() + self.at_rest(state).amax();
        let algebra = self.fine.retraction().algebra();
        let turning = algebra.ad(velocity).amax();
        let change = (algebra.coad(velocity, &state.momentum) + force).amax();
        if size > T::zero() { turning.max(change / size) } else { turning }
    }

    /// ∂L/∂η at η = 0: the momentum of a rotor.
    fn at_rest(&self, state: &State<T, N, D>) -> Covector<T, N> {
        self.momentum_at(state, &Vector::zeros())
    }

    /// Takes the two steps of a plan and the one of 2h, and returns the estimated error of the two. The points and halves hold them.
    pub fn attempt(&mut self, plan: &Plan<T>, statistics: &mut Statistics<T>) -> Result<Attempt<T>, Uncontracted> {
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
            match k {
                0 => self.guess_first(guess, plan.step),
                _ => self.guess_second(plan.step),
            }
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
            let Half { ends, velocities, .. } = &halves[*half];
            through.value(row, [&ends[0], &ends[1]], velocities)
        });
        let report = solved(&mut self.coarse, &mut doubled, two, plan.newton)?;
        note(report, self.coarse.contraction());
        let (difference, scale) = self.difference(&doubled, two)?;
        // What the residuals explain does not fall with h.
        let rest = (difference - noise * T::int(EXPLAINED)).max(T::zero());
        let share = match (plan.smooth, effort) {
            (false, _) => T::one(),
            (true, Effort::Newton) => share_of(self.stage_order as f64),
            (true, _) => share_of(self.order as f64 * self.resolved(plan)),
        };
        let (mut error, mut unexplained, mut rounded) = (difference * share, rest * share, false);
        let unseen = self.unseen(plan, scale)?;
        if unseen > unexplained {
            (error, unexplained) = (error.max(unseen), unseen);
        }
        if error > plan.allowed * T::exact(AIM) && self.fine.moves() {
            // Near an equilibrium rounding of g makes more of the forces than is left of the momentum, at steps of any size.
            let Point { state, velocity, .. } = &self.points[0];
            let rounding = self.fine.sensitivity(state, velocity) * two.abs() * T::int(NOISE) * T::unit_roundoff();
            let rounding = relative(rounding, scale);
            let less = |error: T| (error - rounding).max(T::zero());
            (error, unexplained, rounded) = (less(error), less(unexplained), rounding > plan.allowed);
        }
        Ok(Attempt { error, unexplained, residual, effort, rounded })
    }

    /// The share of the order with which the difference can be taken to fall: by how many powers of 2 the stages of h miss the velocities at the
    /// ends of a step by less than those of 2h do, of those of a smooth motion.
    fn resolved(&self, plan: &Plan<T>) -> f64 {
        let Some(ends) = &self.ends else { return 1.0 };
        let miss = |end: usize, point: usize, stages: &mut dyn Iterator<Item = Vector<T, N>>| {
            (self.points[point].velocity - ends.at[end].value(stages)).amax()
        };
        let fine = |k: usize, end: usize| miss(end, k + end, &mut self.halves[k].velocities.iter().copied());
        let coarse = |end: usize| miss(end, 2 * end, &mut self.coarse.stage_velocities());
        let fine = fine(0, 0).max(fine(0, 1)).max(fine(1, 0)).max(fine(1, 1));
        let coarse = coarse(0).max(coarse(1));
        let speed = self.points.iter().fold(T::zero(), |most, point| most.max(point.velocity.amax()));
        // Less is what is left in the stages.
        if fine <= speed * plan.allowed {
            return 1.0;
        }
        let room = if fine <= speed * T::exact(COARSE) { ROOM } else { 0.0 };
        let powers = (coarse / fine).to_f64().log2() + room;
        (powers / ends.powers(self.stage_order_of_velocities)).clamp(0.0, 1.0)
    }

    /// The relative momentum that a jump of the force may have made unseen.
    fn unseen(&self, plan: &Plan<T>, scale: T) -> Result<T, StepError> {
        let Some(ends) = self.ends.as_ref().filter(|_| self.forced()) else { return Ok(T::zero()) };
        let at = |k: usize, end: usize| self.miss(ends, plan, (k, end), T::zero());
        let misses = [[at(0, 0)?, at(0, 1)?], [at(1, 0)?, at(1, 1)?]];
        let Some(Jump { step, end, size, share }) = ends.outlier(misses) else { return Ok(T::zero()) };
        let domain = |source| StepError::Domain { step: plan.step.to_f64(), stage: None, source };
        let last = self.points[2].force * self.retraction().at(self.coarse.increment()).map_err(domain)?.ad_inv();
        let coarse = |end: usize, force: Covector<T, N>| {
            let mut stages = self.coarse.stage_rates().map(|(_, force)| force);
            (force - ends.at[end].value(&mut stages)).amax()
        };
        let coarse = coarse(0, self.points[0].force).max(coarse(1, last));
        if (coarse / size).to_f64().log2() >= (ends.powers(self.stage_order_of_velocities) * SMOOTH).max(STEEP) {
            return Ok(T::zero());
        }
        let passed = plan.step.abs() * share;
        let unseen = relative(size * passed, scale);
        if unseen <= plan.allowed {
            return Ok(unseen);
        }
        // A jump so close to the end does no harm: where a run ends at the time of a jump, or begins there.
        let inside = self.miss(ends, plan, (step, end), passed * plan.allowed / unseen)?;
        Ok(if inside * T::int(2) < size { plan.allowed } else { unseen })
    }

    /// How far the force at an end of step k, or so much later or earlier in it, is from what the stages predict.
    fn miss(&self, ends: &Ends<T>, plan: &Plan<T>, (k, end): (usize, usize), inward: T) -> Result<T, StepError> {
        let half = &self.halves[k];
        let Point { state, velocity, force, .. } = &self.points[k + end];
        let mut force = *force;
        if inward > T::zero() {
            let forward = (plan.step > T::zero()) == (end == 0);
            let time = if forward { state.time + inward } else { state.time - inward };
            (force, _) = self.force_at(&State { time, ..state.clone() }, velocity, plan.step)?;
        }
        if end == 1 {
            let domain = |source| StepError::Domain { step: plan.step.to_f64(), stage: None, source };
            force *= self.retraction().at(&half.increment).map_err(domain)?.ad_inv();
        }
        Ok((force - ends.at[end].value(&mut half.rates.iter().map(|&(_, force)| force))).amax())
    }

    /// The pair is kept: the next one starts at its end.
    pub fn accept(&mut self) {
        let [first, _, end] = &mut self.points;
        std::mem::swap(first, end);
        std::mem::swap(&mut self.before, &mut self.halves[1]);
        self.guess = Guess::After;
    }

    /// The stage velocities of the first step, from the step before or from a longer one.
    fn guess_first(&mut self, guess: Guess, step: T) {
        let (half, offset) = match guess {
            Guess::Cold => return,
            Guess::After => (&self.before, T::one()),
            Guess::Within => (&self.halves[0], T::zero()),
        };
        let (ratio, row, through) = (step / half.step, &mut self.row, &self.through);
        let near = ratio > T::zero() && ratio < T::exact(FARTHEST);
        let c = &self.c;
        if near && through.row(offset + ratio, row) {
            self.fine.predict(step, &self.points[0].state.momentum, |i| {
                through.row(offset + ratio * c[i], row);
                through.value(row, [&half.ends[0], &half.ends[1]], &half.velocities)
            });
        }
    }

    /// The stage velocities of the second step, from the first.
    fn guess_second(&mut self, step: T) {
        let (half, row, through) = (&self.halves[0], &mut self.row, &self.through);
        let c = &self.c;
        if through.row(T::int(2), row) {
            self.fine.predict(step, &self.points[1].state.momentum, |i| {
                through.row(T::one() + c[i], row);
                through.value(row, [&half.ends[0], &half.ends[1]], &half.velocities)
            });
        }
    }

    /// Step k of h.
    fn take(&mut self, k: usize, plan: &Plan<T>) -> Result<Report<T>, Uncontracted> {
        let (before, after) = self.points.split_at_mut(k + 1);
        let (start, end) = (&before[k], &mut after[0]);
        end.state.clone_from(&start.state);
        let report = solved(&mut self.fine, &mut end.state, plan.step, plan.newton)?;
        end.state.time = plan.times[k];
        let half = &mut self.halves[k];
        (half.step, half.increment, half.ends[0]) = (plan.step, *self.fine.increment(), start.velocity);
        for (to, from) in half.displacements.iter_mut().zip(self.fine.stage_displacements()) {
            *to = from;
        }
        for (to, from) in half.velocities.iter_mut().zip(self.fine.stage_velocities()) {
            *to = from;
        }
        for (to, from) in half.rates.iter_mut().zip(self.fine.stage_rates()) {
            *to = from;
        }
        let guess = half.velocities[half.velocities.len() - 1];
        self.look(k + 1, &guess, plan.step)?;
        self.halves[k].ends[1] = self.points[k + 1].velocity;
        Ok(report)
    }

    /// How far the result of one step of 2h is from that of two: of the momentum relative to it and to the impulse of the forces, of
    /// the displacement τ(ξ) relative to its largest entry. Beside it what momenta are relative to.
    fn difference(&self, doubled: &State<T, N, D>, two: T) -> Result<(T, T), StepError> {
        let [start, middle, end] = &self.points;
        let largest = |f: &dyn Fn(&Point<T, N, D>) -> T| f(start).max(f(middle)).max(f(end));
        let size = largest(&|point| point.state.momentum.amax()) + self.at_rest(&start.state).amax();
        let scale = size.max(largest(&|point| point.load) * two.abs());
        let momentum = relative(max_abs(&(end.state.momentum - doubled.momentum)), scale);
        let tau = |x| self.fine.retraction().tau::<T>(x);
        let displaced = |x| match tau(x) {
            Err(RetractionError::NoGroup { .. }) => Ok(None),
            Err(source) => Err(StepError::Domain { step: two.to_f64(), stage: None, source }),
            Ok(g) => Ok(Some(g)),
        };
        let [first, second] = &self.halves;
        let steps = (displaced(&first.increment)?, displaced(&second.increment)?, displaced(self.coarse.increment())?);
        let (Some(first), Some(second), Some(coarse)) = steps else {
            return Ok((momentum, scale));
        };
        let fine = first * second;
        let attitude = relative(max_abs(&(fine - coarse)), fine.amax());
        Ok((larger(attitude, momentum), scale))
    }
}
