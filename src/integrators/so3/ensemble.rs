//! Many bodies at once: a lane a body, eight to a group.

use super::force::{OnBody, PackedForce};
use super::kernel::{Columns, NOTHING, compensated};
use super::retraction::{LaneRetraction, dot};
use super::step::{FastRetraction, UnfitTableau};
use super::{LANES, Row, Vec3};
use crate::algebra::Matrix;
use crate::integrators::lanes::{Eight, Isa, Kernel, Lanes, Registers};
use crate::integrators::variational::Settings;
use crate::integrators::{OneStep, State, StepError, Variational};
use crate::mechanics::lagrangian::Quadratic;
use crate::tableau::Tableau;
use std::marker::PhantomData;

/// The steps back from which the stages of the next are extrapolated: a polynomial of degree one less.
const HISTORY: usize = 6;

/// (−1)^{j+1} (6 over j), j = 1 … 6: what carries a polynomial of degree 5 one step on.
const EXTRAPOLATION: [f64; HISTORY] = [6.0, -15.0, 20.0, -15.0, 6.0, -1.0];

/// For how many steps the contraction of the sweeps is taken to be at most four times what was measured.
const TRUST: usize = 15;

/// After how many steps g gᵀ is restored.
const STRAIGHTEN: usize = 64;

/// The entries of a symmetric matrix.
const PAIRS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];

/// How many groups advance together.
const BLOCK: usize = 2;

/// One body of an ensemble.
#[derive(Clone, Debug)]
pub struct Member<F> {
    /// Its inertia.
    pub lagrangian: Quadratic<f64, 3>,
    /// The force on it.
    pub force: F,
    /// Where it starts. Every body has its own time.
    pub state: State<f64, 3, 3>,
}

/// Why an ensemble stopped. The bodies of other groups may have gone further.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("body {member}, step {step} (from t = {time}): {source}")]
pub struct EnsembleError {
    /// Which body, from 0.
    pub member: usize,
    /// Which step of this run, from 0.
    pub step: usize,
    /// When.
    pub time: f64,
    /// What happened.
    pub source: StepError,
}

/// Eight bodies.
#[derive(Clone, Debug)]
struct Group<F> {
    first: usize,
    /// The bodies that are there; the lanes past them repeat the last.
    filled: usize,
    lagrangians: Vec<Quadratic<f64, 3>>,
    force: F,
    inverse: [[Row; 3]; 3],
    time: Row,
    time_cut: Row,
    /// μ, and the columns of g: component a of μ, entry (r, a) of g at [1 + r][a].
    value: [[Row; 3]; 4],
    /// What rounding has cut off.
    cut: [[Row; 3]; 4],
    /// g gᵀ as it was, entries (0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2); ½ where that is nearly 1, otherwise 0; the
    /// steps since it was restored.
    product: [Row; 6],
    restored: Row,
    since: usize,
    diagonal: bool,
    work: Vec<Stage>,
    /// The iterates and their like of the steps before, a ring: of how many steps, and where those of this step are.
    iterates: Vec<Iterate>,
    known: usize,
    this: usize,
    step: f64,
    /// What a sweep leaves of an error, four times as much as it was when it was measured; and for how many steps that is
    /// taken to be so.
    contraction: f64,
    trusted: usize,
}

/// One stage of eight bodies.
#[derive(Clone, Copy, Debug, Default)]
struct Iterate {
    /// P_i − μ: rounding errors of P_i itself would be magnified by what extrapolates it.
    d: Vec3<Row>,
    /// Ξ_i.
    x: Vec3<Row>,
}

/// What a sweep makes of it.
#[derive(Clone, Copy, Debug, Default)]
struct Stage {
    rate: Vec3<Row>,
    gradient: Vec3<Row>,
}

/// Many bodies on SO(3), each with its own inertia, force and state, with one tableau and one step size.
///
/// A lane of the registers holds a body, so that eight advance at the price of one; with the feature `harness` the groups
/// of eight are spread over the threads of rayon's pool. Which bodies share a group depends on their order alone, so the
/// results are the same bits at any number of threads. The step is that of [`Variational`], to round-off: its stages
/// start from the last six steps, and sweeps run until the residual that the last of them leaves is as wanted in every lane.
/// That residual is estimated: it is the change that the sweep made, which is measured, times the contraction of the sweeps,
/// which is taken as four times what it was when two sweeps in one step showed it, at most fifteen steps ago. A step whose
/// sweeps do not contract in some lane is taken by [`Variational`] for each body of the group. Every 64 steps g gᵀ is
/// restored to what it was at the start, where that was within 10⁻³ of 1.
#[derive(Clone, Debug)]
pub struct EnsembleSo3<F: PackedForce, R> {
    columns: Columns,
    tableau: Tableau<f64>,
    retraction: R,
    settings: Settings<f64>,
    registers: Registers,
    forces: Vec<F::One>,
    groups: Vec<Group<F>>,
}

impl<F: PackedForce, R: FastRetraction> EnsembleSo3<F, R> {
    /// An ensemble.
    ///
    /// # Errors
    /// A tableau of more than eight stages.
    pub fn new(members: &[Member<F::One>], retraction: R, tableau: Tableau<f64>) -> Result<Self, UnfitTableau> {
        let stages = tableau.stages();
        if stages > LANES {
            return Err(UnfitTableau { stages });
        }
        let groups = members.chunks(LANES).enumerate().map(|(k, chunk)| Group::new(k * LANES, chunk, stages)).collect();
        let forces = members.iter().map(|member| member.force.clone()).collect();
        let columns = Columns::new(&tableau, None);
        let settings = Settings::default();
        Ok(Self { columns, tableau, retraction, settings, registers: Registers::detect(), forces, groups })
    }

    /// The same with settings of one's own: the residual wanted, and when Newton's method takes over.
    pub fn with_settings(mut self, settings: Settings<f64>) -> Self {
        self.settings = settings;
        self
    }

    /// The same in registers of another kind: for tests that compare them.
    pub fn in_registers(mut self, registers: Registers) -> Self {
        self.registers = registers;
        self
    }

    /// The number of bodies.
    pub fn len(&self) -> usize {
        self.forces.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.forces.is_empty()
    }

    /// The state of body `member`.
    pub fn state(&self, member: usize) -> Option<State<f64, 3, 3>> {
        let group = self.groups.get(member / LANES)?;
        (member % LANES < group.filled).then(|| group.state(member % LANES))
    }

    /// Where the bodies are, in their order.
    pub fn states(&self) -> impl Iterator<Item = State<f64, 3, 3>> + '_ {
        self.groups.iter().flat_map(|group| (0..group.filled).map(|lane| group.state(lane)))
    }

    /// `steps` steps of size `h` for every body.
    ///
    /// # Errors
    /// The first body (in their order) that could not take a step; see [`StepError`].
    pub fn advance(&mut self, h: f64, steps: usize) -> Result<(), EnsembleError>
    where
        F::One: Sync,
        R: Sync,
    {
        let Self { columns, tableau, retraction, settings, registers, forces, groups } = self;
        let (columns, tableau, retraction, settings, forces) =
            (&*columns, &*tableau, &*retraction, *settings, &*forces);
        let registers = *registers;
        // Steps outside, groups inside: what the processor does at one time are steps of several groups.
        let run = |block: &mut [Group<F>]| -> Result<(), EnsembleError> {
            let mut outcomes: [Result<(), EnsembleError>; BLOCK] = [const { Ok(()) }; BLOCK];
            let mut ended = [false; BLOCK];
            for step in 0..steps {
                for group in block.iter_mut().filter(|group| group.step != h) {
                    (group.step, group.known) = (h, 0);
                }
                let kernel = BlockStep::<F, R::Lanes> { block, ended, columns, settings, retraction: PhantomData };
                let refused = registers.run(kernel);
                for k in (0..block.len()).filter(|&k| refused[k]) {
                    let group = &mut block[k];
                    let forces = &forces[group.first..group.first + group.filled];
                    let taken = group.one_by_one(forces, retraction, tableau, settings, h);
                    ended[k] = taken.is_err();
                    outcomes[k] = taken.map_err(|(lane, source)| EnsembleError {
                        member: group.first + lane,
                        step,
                        time: group.time.0[lane],
                        source,
                    });
                }
            }
            outcomes.into_iter().collect()
        };
        #[cfg(feature = "harness")]
        let outcomes: Vec<Result<(), EnsembleError>> = {
            use rayon::prelude::*;
            groups.par_chunks_mut(BLOCK).map(run).collect()
        };
        #[cfg(not(feature = "harness"))]
        let outcomes: Vec<Result<(), EnsembleError>> = groups.chunks_mut(BLOCK).map(run).collect();
        outcomes.into_iter().collect()
    }
}

impl<F: PackedForce> Group<F> {
    fn new(first: usize, members: &[Member<F::One>], stages: usize) -> Self {
        let member = |lane: usize| &members[lane.min(members.len() - 1)];
        let row = |f: &dyn Fn(&Member<F::One>) -> f64| Row(std::array::from_fn(|lane| f(member(lane))));
        let product = |m: &Member<F::One>| m.state.attitude * m.state.attitude.transpose();
        let mut value = [[Row::default(); 3]; 4];
        for a in 0..3 {
            value[0][a] = row(&|m| m.state.momentum[a]);
            for r in 0..3 {
                value[1 + r][a] = row(&|m| m.state.attitude[(r, a)]);
            }
        }
        Self {
            first,
            filled: members.len(),
            lagrangians: members.iter().map(|m| m.lagrangian.clone()).collect(),
            force: F::pack(std::array::from_fn(|lane| &member(lane).force)),
            inverse: std::array::from_fn(|r| std::array::from_fn(|c| row(&|m| m.lagrangian.inverse()[(r, c)]))),
            time: row(&|m| m.state.time),
            time_cut: Row::default(),
            value,
            cut: [[Row::default(); 3]; 4],
            product: PAIRS.map(|(i, j)| row(&|m| product(m)[(i, j)])),
            restored: row(&|m| if (product(m) - Matrix::identity()).amax() < 1e-3 { 0.5 } else { 0.0 }),
            since: 0,
            diagonal: members
                .iter()
                .all(|m| (0..3).all(|r| (0..3).all(|c| r == c || m.lagrangian.inverse()[(r, c)] == 0.0))),
            work: vec![Stage::default(); stages],
            iterates: vec![Iterate::default(); stages * HISTORY],
            known: 0,
            this: 0,
            step: 0.0,
            contraction: 1.0,
            trusted: 0,
        }
    }

    fn state(&self, lane: usize) -> State<f64, 3, 3> {
        State {
            time: self.time.0[lane],
            momentum: crate::algebra::Covector::<f64, 3>::from_fn(|_, a| self.value[0][a].0[lane]),
            attitude: crate::algebra::Matrix::<f64, 3>::from_fn(|r, a| self.value[1 + r][a].0[lane]),
        }
    }

    /// The step by [`Variational`], body by body.
    #[cold]
    fn one_by_one<R: FastRetraction>(
        &mut self,
        forces: &[F::One],
        retraction: &R,
        tableau: &Tableau<f64>,
        settings: Settings<f64>,
        h: f64,
    ) -> Result<(), (usize, StepError)> {
        self.known = 0;
        let mut next = Vec::with_capacity(self.filled);
        for lane in 0..self.filled {
            let lagrangian = self.lagrangians[lane].clone();
            let force = OnBody { force: forces[lane].clone(), lagrangian: lagrangian.clone() };
            let mut method =
                Variational::with_settings(lagrangian, force, retraction.clone(), tableau.clone(), settings);
            let mut state = self.state(lane);
            method.step(&mut state, h).map_err(|source| (lane, source))?;
            next.push(state);
        }
        for lane in 0..LANES {
            let state = &next[lane.min(self.filled - 1)];
            self.time.0[lane] = state.time;
            for a in 0..3 {
                self.value[0][a].0[lane] = state.momentum[a];
                for r in 0..3 {
                    self.value[1 + r][a].0[lane] = state.attitude[(r, a)];
                }
            }
        }
        (self.time_cut, self.cut) = (Row::default(), [[Row::default(); 3]; 4]);
        Ok(())
    }
}

/// One step of the groups of a block, those that have not ended; which of them sweeps do not solve.
struct BlockStep<'a, F, R> {
    block: &'a mut [Group<F>],
    ended: [bool; BLOCK],
    columns: &'a Columns,
    settings: Settings<f64>,
    retraction: PhantomData<R>,
}

/// Where a group is in its step.
#[derive(Clone, Copy)]
struct Progress<I: Isa> {
    mu: Vec3<Eight<I>>,
    /// The residual is judged in every lane against its own |μ| and |hΩ|.
    per_size: Eight<I>,
    per_extent: Eight<I>,
    /// The first change, the least, the last; how many sweeps ago the least was.
    first: f64,
    best: f64,
    last: f64,
    idle: usize,
    going: bool,
}

#[inline(always)]
fn load<I: Isa>(isa: I, rows: &Vec3<Row>) -> Vec3<Eight<I>> {
    each!(3, a => Eight::load(isa, &rows[a].0))
}

#[inline(always)]
fn store<I: Isa>(values: Vec3<Eight<I>>, rows: &mut Vec3<Row>) {
    for a in 0..3 {
        values[a].store(&mut rows[a].0);
    }
}

/// The compensated sum of `value` and an increment, and what rounding cuts off it.
#[inline(always)]
fn add<I: Isa>(
    isa: I,
    value: &Vec3<Row>,
    cut: &Vec3<Row>,
    increment: Vec3<Eight<I>>,
) -> (Vec3<Eight<I>>, Vec3<Eight<I>>) {
    let sums = each!(3, a => compensated(Eight::load(isa, &value[a].0), increment[a], Eight::load(isa, &cut[a].0)));
    (each!(3, a => sums[a].0), each!(3, a => sums[a].1))
}

/// The largest component, lane by lane.
#[inline(always)]
fn bound<I: Isa>(v: Vec3<Eight<I>>) -> Eight<I> {
    v[0].abs().max(v[1].abs()).max(v[2].abs())
}

impl<F: PackedForce, R: LaneRetraction> Kernel for BlockStep<'_, F, R> {
    type Output = [bool; BLOCK];

    /// A sweep of each group in turn: while one waits for its divisions the next is on its way.
    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> [bool; BLOCK] {
        let Self { block, ended, columns, settings, retraction: _ } = self;
        let mut refused = [false; BLOCK];
        let zero = Eight::splat(isa, 0.0);
        let idle = Progress {
            mu: [zero; 3],
            per_size: zero,
            per_extent: zero,
            first: 0.0,
            best: f64::INFINITY,
            last: 0.0,
            idle: 0,
            going: false,
        };
        let mut progress = [idle; BLOCK];
        for k in 0..block.len() {
            if !ended[k] {
                progress[k] = block[k].start(isa, columns, idle);
            }
        }
        for sweep in 1..=settings.max_sweeps as i32 {
            let mut going = false;
            for k in 0..block.len() {
                if progress[k].going {
                    refused[k] = !block[k].sweep::<I, R>(isa, columns, settings, &mut progress[k], sweep);
                    going |= progress[k].going;
                }
            }
            if !going {
                return refused;
            }
        }
        for k in 0..block.len() {
            refused[k] |= progress[k].going;
        }
        refused
    }
}

impl<F: PackedForce> Group<F> {
    #[inline(always)]
    fn velocity<I: Isa>(&self, isa: I, m: Vec3<Eight<I>>) -> Vec3<Eight<I>> {
        if self.diagonal {
            return each!(3, r => Eight::load(isa, &self.inverse[r][r].0) * m[r]);
        }
        each!(3, r => dot(load(isa, &self.inverse[r]), m))
    }

    /// The first (P_i − μ, Ξ_i).
    #[inline(always)]
    fn start<I: Isa>(&mut self, isa: I, columns: &Columns, idle: Progress<I>) -> Progress<I> {
        let stages = columns.stages;
        let zero = Eight::splat(isa, 0.0);
        let mu = load(isa, &self.value[0]);
        let eta = self.velocity(isa, mu);
        // Over the oldest, once it has been read.
        self.this = (self.this + 1) % HISTORY;
        let this = self.this * stages;
        if self.known == HISTORY {
            let slots: [usize; HISTORY] = each!(HISTORY, j => (self.this + HISTORY - 1 - j) % HISTORY * stages);
            let weights: [Eight<I>; HISTORY] = each!(HISTORY, j => Eight::splat(isa, EXTRAPOLATION[j]));
            for i in 0..stages {
                for a in 0..3 {
                    let (mut d, mut x) = (zero, zero);
                    for j in 0..HISTORY {
                        let old = &self.iterates[slots[j] + i];
                        d = weights[j].mul_add(Eight::load(isa, &old.d[a].0), d);
                        x = weights[j].mul_add(Eight::load(isa, &old.x[a].0), x);
                    }
                    d.store(&mut self.iterates[this + i].d[a].0);
                    x.store(&mut self.iterates[this + i].x[a].0);
                }
            }
        } else {
            self.trusted = 0;
            for i in 0..stages {
                let hc = Eight::splat(isa, columns.c.0[i] * self.step);
                store([zero; 3], &mut self.iterates[this + i].d);
                store(each!(3, k => hc * eta[k]), &mut self.iterates[this + i].x);
            }
        }
        let tiny = Eight::splat(isa, f64::MIN_POSITIVE);
        let h = Eight::splat(isa, self.step.abs());
        Progress {
            mu,
            per_size: bound(mu).max(tiny).reciprocal(),
            per_extent: (h * bound(eta)).max(tiny).reciprocal(),
            going: true,
            ..idle
        }
    }

    /// One sweep, and the end of the step where it was the last. `false`: sweeps do not solve this step.
    #[inline(always)]
    fn sweep<I: Isa, R: LaneRetraction>(
        &mut self,
        isa: I,
        columns: &Columns,
        settings: Settings<f64>,
        progress: &mut Progress<I>,
        sweep: i32,
    ) -> bool {
        let stages = columns.stages;
        let this = self.this * stages;
        let (step, mu) = (self.step, progress.mu);
        let (h, time) = (Eight::splat(isa, step), Eight::load(isa, &self.time.0));
        let zero = [Eight::splat(isa, 0.0); 3];
        let forced = !self.force.vanishes();
        let (mut increment, mut total, mut kick) = (zero, zero, zero);
        for i in 0..stages {
            let (d, x) = (load(isa, &self.iterates[this + i].d), load(isa, &self.iterates[this + i].x));
            let p = each!(3, a => mu[a] + d[a]);
            let at = R::at(x);
            let m = R::unpull(at, x, p);
            let eta = self.velocity(isa, m);
            let rate = R::rate(at, x, eta);
            let mut gradient = R::pull_dd(at, x, p, m, rate);
            let hb = Eight::splat(isa, columns.b.0[i] * step);
            if forced {
                let t = Eight::splat(isa, columns.c.0[i]).mul_add(h, time);
                let force = self.force.add_to(t, m, eta, zero);
                let pulled = R::pull(at, x, force);
                gradient = each!(3, a => gradient[a] + pulled[a]);
                let turned = R::turned_from(at, x, force, pulled);
                kick = each!(3, a => hb.mul_add(force[a] + turned[a], kick[a]));
            }
            increment = each!(3, a => hb.mul_add(rate[a], increment[a]));
            total = each!(3, a => hb.mul_add(gradient[a], total[a]));
            store(rate, &mut self.work[i].rate);
            store(gradient, &mut self.work[i].gradient);
        }
        let back = each!(3, k => -increment[k]);
        let at_back = R::at(back);
        let kicked: Vec3<Eight<I>> = each!(3, a => mu[a] + kick[a]);
        let end = R::pull_less(at_back, back, kicked);
        // δ.
        let base: Vec3<Eight<I>> = each!(3, a => end[a] + (kick[a] - total[a]));
        let (mut shift, mut turn) = (zero[0], zero[0]);
        for i in 0..stages {
            let (mut d, mut x) = (base, zero);
            for j in 0..stages {
                let stage = &self.work[j];
                let a = Eight::splat(isa, columns.a[j].0[i] * step);
                let conjugate = Eight::splat(isa, columns.conjugate[j].0[i] * step);
                let (gradient, rate) = (load(isa, &stage.gradient), load(isa, &stage.rate));
                d = each!(3, k => conjugate.mul_add(gradient[k], d[k]));
                x = each!(3, k => a.mul_add(rate[k], x[k]));
            }
            let old = &self.iterates[this + i];
            let (old_d, old_x) = (load(isa, &old.d), load(isa, &old.x));
            shift = shift.max(bound(each!(3, k => d[k] - old_d[k])));
            turn = turn.max(bound(each!(3, k => x[k] - old_x[k])));
            store(d, &mut self.iterates[this + i].d);
            store(x, &mut self.iterates[this + i].x);
        }
        let change = (shift * progress.per_size).max(turn * progress.per_extent).largest();
        if sweep == 1 {
            progress.first = change;
        }
        progress.idle = if change < progress.best { 0 } else { progress.idle + 1 };
        progress.best = progress.best.min(change);
        // The residual of the new iterate: what a sweep leaves of a change, as it was in this step or a few steps ago.
        let left = if sweep > 1 {
            self.contraction = (4.0 * change / progress.last).min(1.0);
            self.trusted = TRUST;
            change * self.contraction
        } else if self.trusted > 0 {
            self.trusted -= 1;
            change * self.contraction
        } else {
            change
        };
        progress.last = change;
        let first = progress.first;
        if left <= settings.tolerance || (progress.idle >= 2 && change <= settings.floor) {
            progress.going = false;
            let slow = sweep > 4 && change < first && change > first * 0.6_f64.powi(sweep - 1);
            let mut square = dot(back, back);
            for i in 0..stages {
                let x = load(isa, &self.iterates[this + i].x);
                square = square.max(dot(x, x));
            }
            return !slow
                && R::in_domain(square.largest())
                && self.finish::<I, R>(isa, back, at_back, kick, kicked, end);
        }
        let hopeless = change.is_nan() || change > 1e3 || (sweep >= 8 && progress.best > first * 0.8_f64.powi(sweep));
        progress.going = !hopeless;
        !hopeless
    }

    /// The new state. `false`: it is not finite, and the old one stays.
    #[inline(always)]
    fn finish<I: Isa, R: LaneRetraction>(
        &mut self,
        isa: I,
        back: Vec3<Eight<I>>,
        at_back: R::At<Eight<I>>,
        kick: Vec3<Eight<I>>,
        kicked: Vec3<Eight<I>>,
        end: Vec3<Eight<I>>,
    ) -> bool {
        let zero = Eight::splat(isa, 0.0);
        // `end` is what dτ adds to μ + kick.
        let turned = R::turned_from(at_back, back, kicked, each!(3, a => kicked[a] + end[a]));
        let (value, cut) = add(isa, &self.value[0], &self.cut[0], each!(3, a => turned[a] + kick[a]));
        // A sum of products with 0 is 0, unless one of the numbers is not finite.
        if (value[0] * zero + value[1] * zero + value[2] * zero).sum() != 0.0 {
            return false;
        }
        // What has decayed to nothing beside |μ| is 0, before it is so small that arithmetic with it is slow.
        let size = Eight::splat(isa, NOTHING) * bound(value);
        let value = each!(3, a => (value[a] + size) - size);
        store(value, &mut self.value[0]);
        store(cut, &mut self.cut[0]);
        for v in 1..4 {
            let turned = R::turned(at_back, back, load(isa, &self.value[v]));
            let (value, cut) = add(isa, &self.value[v], &self.cut[v], turned);
            store(value, &mut self.value[v]);
            store(cut, &mut self.cut[v]);
        }
        let (time, step) = (Eight::load(isa, &self.time.0), Eight::splat(isa, self.step));
        let (time, time_cut) = compensated(time, step, Eight::load(isa, &self.time_cut.0));
        time.store(&mut self.time.0);
        time_cut.store(&mut self.time_cut.0);
        self.since += 1;
        if self.since == STRAIGHTEN {
            self.since = 0;
            self.straighten(isa);
        }
        // The iterates of the last sweep, one better than those that were judged, are what the next steps start from.
        self.known = (self.known + 1).min(HISTORY);
        true
    }

    /// g gᵀ is what it was, by a step of Newton's iteration for the polar factor (Higham 1986, §3): V ← V − ½ (V Vᵀ − g gᵀ) V,
    /// V = `value` − `cut`. Along a steady rotation every step has the same rounding errors, which would add up.
    #[inline(always)]
    fn straighten<I: Isa>(&mut self, isa: I) {
        let zero = Eight::splat(isa, 0.0);
        let mut rows = [[zero; 3]; 3];
        for r in 0..3 {
            let (value, cut) = (load(isa, &self.value[1 + r]), load(isa, &self.cut[1 + r]));
            rows[r] = each!(3, a => value[a] - cut[a]);
        }
        let half = Eight::load(isa, &self.restored.0);
        let mut error = [[zero; 3]; 3];
        for k in 0..6 {
            let (i, j) = PAIRS[k];
            error[i][j] = half * (dot(rows[i], rows[j]) - Eight::load(isa, &self.product[k].0));
            error[j][i] = error[i][j];
        }
        for i in 0..3 {
            let mut cut = load(isa, &self.cut[1 + i]);
            for j in 0..3 {
                cut = each!(3, a => error[i][j].mul_add(rows[j][a], cut[a]));
            }
            store(cut, &mut self.cut[1 + i]);
        }
    }
}
