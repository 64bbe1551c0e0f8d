//! Many bodies at once: a lane a body, eight to a group.

use super::force::{OnBody, PackedForce};
use super::kernel::Columns;
use super::retraction::{LaneRetraction, dot};
use super::step::{FastRetraction, UnfitTableau};
use super::{LANES, Row, Vec3};
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
    /// μ, and the columns of g: component a of μ, entry (r, a) of g at [1 + r][a].
    value: [[Row; 3]; 4],
    /// What rounding has cut off.
    cut: [[Row; 3]; 4],
    /// δ + μ is not kept: this is δ.
    delta: [Row; 3],
    work: Vec<Stage>,
    /// (P_i, Ξ_i) and δ of the steps before, a ring: of how many, and where the newest is.
    history: Vec<[Vec3<Row>; 2]>,
    deltas: [[Row; 3]; HISTORY],
    known: usize,
    newest: usize,
    step: f64,
}

/// One stage of eight bodies.
#[derive(Clone, Copy, Debug, Default)]
struct Stage {
    p: Vec3<Row>,
    x: Vec3<Row>,
    rate: Vec3<Row>,
    gradient: Vec3<Row>,
}

/// Many bodies on SO(3), each with its own inertia, force and state, with one tableau and one step size.
///
/// A lane of the registers holds a body, so that eight advance at the price of one; with the feature `harness` the groups
/// of eight are spread over the threads of rayon's pool. Which bodies share a group depends on their order alone, so the
/// results are the same bits at any number of threads. The step is that of [`Variational`], to round-off: its stages
/// start from the last six steps, sweeps run until every lane has the residual wanted, and a step whose sweeps do not
/// contract in some lane is taken by [`Variational`] for each body of the group.
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
        let run =
            |group: &mut Group<F>| -> Result<(), EnsembleError> {
                for step in 0..steps {
                    group.advance::<R>(columns, registers, settings, h).or_else(|()| {
                        let forces = &forces[group.first..group.first + group.filled];
                        group.one_by_one(forces, retraction, tableau, settings, h).map_err(|(lane, source)| {
                            EnsembleError { member: group.first + lane, step, time: group.time.0[lane], source }
                        })
                    })?;
                }
                Ok(())
            };
        #[cfg(feature = "harness")]
        let outcomes: Vec<Result<(), EnsembleError>> = {
            use rayon::prelude::*;
            groups.par_iter_mut().map(run).collect()
        };
        #[cfg(not(feature = "harness"))]
        let outcomes: Vec<Result<(), EnsembleError>> = groups.iter_mut().map(run).collect();
        outcomes.into_iter().collect()
    }
}

impl<F: PackedForce> Group<F> {
    fn new(first: usize, members: &[Member<F::One>], stages: usize) -> Self {
        let member = |lane: usize| &members[lane.min(members.len() - 1)];
        let row = |f: &dyn Fn(&Member<F::One>) -> f64| Row(std::array::from_fn(|lane| f(member(lane))));
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
            value,
            cut: [[Row::default(); 3]; 4],
            delta: [Row::default(); 3],
            work: vec![Stage::default(); stages],
            history: vec![[[Row::default(); 3]; 2]; stages * HISTORY],
            deltas: [[Row::default(); 3]; HISTORY],
            known: 0,
            newest: 0,
            step: 0.0,
        }
    }

    fn state(&self, lane: usize) -> State<f64, 3, 3> {
        State {
            time: self.time.0[lane],
            momentum: crate::algebra::Covector::<f64, 3>::from_fn(|_, a| self.value[0][a].0[lane]),
            attitude: crate::algebra::Matrix::<f64, 3>::from_fn(|r, a| self.value[1 + r][a].0[lane]),
        }
    }

    fn advance<R: FastRetraction>(
        &mut self,
        columns: &Columns,
        registers: Registers,
        settings: Settings<f64>,
        h: f64,
    ) -> Result<(), ()> {
        if self.step != h {
            (self.step, self.known) = (h, 0);
        }
        registers.run(GroupStep::<F, R::Lanes> { group: self, columns, settings, retraction: PhantomData })
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
        self.cut = [[Row::default(); 3]; 4];
        Ok(())
    }
}

/// One step of a group.
struct GroupStep<'a, F, R> {
    group: &'a mut Group<F>,
    columns: &'a Columns,
    settings: Settings<f64>,
    retraction: PhantomData<R>,
}

#[inline(always)]
fn load<I: Isa>(isa: I, rows: &Vec3<Row>) -> Vec3<Eight<I>> {
    std::array::from_fn(|a| Eight::load(isa, &rows[a].0))
}

#[inline(always)]
fn store<I: Isa>(values: Vec3<Eight<I>>, rows: &mut Vec3<Row>) {
    for a in 0..3 {
        values[a].store(&mut rows[a].0);
    }
}

impl<F: PackedForce, R: LaneRetraction> GroupStep<'_, F, R> {
    #[inline(always)]
    fn velocity<I: Isa>(&self, isa: I, m: Vec3<Eight<I>>) -> Vec3<Eight<I>> {
        std::array::from_fn(|r| dot(load(isa, &self.group.inverse[r]), m))
    }

    /// The first (P_i, Ξ_i) and δ.
    #[inline(always)]
    fn start<I: Isa>(&mut self, isa: I, mu: Vec3<Eight<I>>) {
        let group = &mut *self.group;
        let stages = self.columns.stages;
        if group.known == HISTORY {
            let slots: [usize; HISTORY] = std::array::from_fn(|j| (group.newest + HISTORY - j) % HISTORY);
            for i in 0..stages {
                for a in 0..3 {
                    let (mut p, mut x) = (Eight::splat(isa, 0.0), Eight::splat(isa, 0.0));
                    for (j, &slot) in slots.iter().enumerate() {
                        let weight = Eight::splat(isa, EXTRAPOLATION[j]);
                        let [old_p, old_x] = &group.history[slot * stages + i];
                        p = weight.mul_add(Eight::load(isa, &old_p[a].0), p);
                        x = weight.mul_add(Eight::load(isa, &old_x[a].0), x);
                    }
                    p.store(&mut group.work[i].p[a].0);
                    x.store(&mut group.work[i].x[a].0);
                }
            }
            for a in 0..3 {
                let mut delta = Eight::splat(isa, 0.0);
                for (j, &slot) in slots.iter().enumerate() {
                    let old = Eight::load(isa, &group.deltas[slot][a].0);
                    delta = Eight::splat(isa, EXTRAPOLATION[j]).mul_add(old, delta);
                }
                delta.store(&mut group.delta[a].0);
            }
        } else {
            let eta = self.velocity(isa, mu);
            let group = &mut *self.group;
            for i in 0..stages {
                let hc = Eight::splat(isa, self.columns.c.0[i] * group.step);
                store(mu, &mut group.work[i].p);
                store(eta.map(|v| hc * v), &mut group.work[i].x);
            }
            group.delta = [Row::default(); 3];
        }
    }
}

impl<F: PackedForce, R: LaneRetraction> Kernel for GroupStep<'_, F, R> {
    type Output = Result<(), ()>;

    #[inline(always)]
    fn run<I: Isa>(mut self, isa: I) -> Result<(), ()> {
        let stages = self.columns.stages;
        let step = self.group.step;
        let h = Eight::splat(isa, step);
        let time = Eight::load(isa, &self.group.time.0);
        let mu = load(isa, &self.group.value[0]);
        let zero = [Eight::splat(isa, 0.0); 3];
        let forced = !self.group.force.vanishes();
        // The residual is judged in every lane against its own |μ| and |hΩ|.
        let (eta, tiny) = (self.velocity(isa, mu), Eight::splat(isa, f64::MIN_POSITIVE));
        let bound = |v: Vec3<Eight<I>>| v[0].abs().max(v[1].abs()).max(v[2].abs());
        let one = Eight::splat(isa, 1.0);
        let per_size = one / bound(mu).max(tiny);
        let per_extent = one / (h.abs() * bound(eta)).max(tiny);
        self.start(isa, mu);

        let (mut best, mut idle, mut first) = (f64::INFINITY, 0, 0.0);
        for sweep in 1..=self.settings.max_sweeps as i32 {
            let (mut increment, mut total, mut kick) = (zero, zero, zero);
            for i in 0..stages {
                let (p, x) = (load(isa, &self.group.work[i].p), load(isa, &self.group.work[i].x));
                let at = R::at(x);
                let m = R::unpull(at, x, p);
                let eta = self.velocity(isa, m);
                let rate = R::rate(at, x, eta);
                let mut gradient = R::pull_dd(at, x, p, m, rate);
                let hb = Eight::splat(isa, self.columns.b.0[i] * step);
                if forced {
                    let t = Eight::splat(isa, self.columns.c.0[i]).mul_add(h, time);
                    let force = self.group.force.add_to(t, m, eta, zero);
                    let pulled = R::pull(at, x, force);
                    gradient = std::array::from_fn(|a| gradient[a] + pulled[a]);
                    let turned = R::turned(at, x, force);
                    kick = std::array::from_fn(|a| hb.mul_add(force[a] + turned[a], kick[a]));
                }
                increment = std::array::from_fn(|a| hb.mul_add(rate[a], increment[a]));
                total = std::array::from_fn(|a| hb.mul_add(gradient[a], total[a]));
                store(rate, &mut self.group.work[i].rate);
                store(gradient, &mut self.group.work[i].gradient);
            }
            let back = increment.map(|v| -v);
            let at_back = R::at(back);
            let kicked: Vec3<Eight<I>> = std::array::from_fn(|a| mu[a] + kick[a]);
            let end = R::pull(at_back, back, kicked);
            let base: Vec3<Eight<I>> = std::array::from_fn(|a| end[a] - total[a]);
            let (mut shift, mut turn) = (zero[0], zero[0]);
            for i in 0..stages {
                let (mut p, mut x) = (base, zero);
                for j in 0..stages {
                    let stage = &self.group.work[j];
                    let a = Eight::splat(isa, self.columns.a[j].0[i] * step);
                    let conjugate = Eight::splat(isa, self.columns.conjugate[j].0[i] * step);
                    let (gradient, rate) = (load(isa, &stage.gradient), load(isa, &stage.rate));
                    p = std::array::from_fn(|k| conjugate.mul_add(gradient[k], p[k]));
                    x = std::array::from_fn(|k| a.mul_add(rate[k], x[k]));
                }
                let stage = &self.group.work[i];
                let (old_p, old_x) = (load(isa, &stage.p), load(isa, &stage.x));
                shift = shift.max(bound(std::array::from_fn(|k| p[k] - old_p[k])));
                turn = turn.max(bound(std::array::from_fn(|k| x[k] - old_x[k])));
                store(p, &mut self.group.work[i].p);
                store(x, &mut self.group.work[i].x);
            }
            let change = (shift * per_size).max(turn * per_extent).largest();
            if sweep == 1 {
                first = change;
            }
            idle = if change < best { 0 } else { idle + 1 };
            best = best.min(change);
            if change <= self.settings.tolerance || (idle >= 2 && change <= self.settings.floor) {
                let slow = sweep > 4 && change < first && change > first * 0.6_f64.powi(sweep - 1);
                let mut square = dot(back, back);
                for i in 0..stages {
                    let x = load(isa, &self.group.work[i].x);
                    square = square.max(dot(x, x));
                }
                if slow || !R::in_domain(square.largest()) {
                    return Err(());
                }
                return self.finish(isa, base, back, at_back, kick, mu);
            }
            if change.is_nan() || change > 1e3 || (sweep >= 8 && best > first * 0.8_f64.powi(sweep)) {
                return Err(());
            }
        }
        Err(())
    }
}

impl<F: PackedForce, R: LaneRetraction> GroupStep<'_, F, R> {
    #[inline(always)]
    fn finish<I: Isa>(
        self,
        isa: I,
        base: Vec3<Eight<I>>,
        back: Vec3<Eight<I>>,
        at_back: R::At<Eight<I>>,
        kick: Vec3<Eight<I>>,
        mu: Vec3<Eight<I>>,
    ) -> Result<(), ()> {
        let group = self.group;
        let zero = [Eight::splat(isa, 0.0); 3];
        let mut finite = Eight::splat(isa, 0.0);
        for v in 0..4 {
            let old = load(isa, &group.value[v]);
            let kick = if v == 0 { kick } else { zero };
            let turned = R::turned(at_back, back, std::array::from_fn(|a| old[a] + kick[a]));
            let cut = load(isa, &group.cut[v]);
            let (mut value, mut rest) = (zero, zero);
            for a in 0..3 {
                let y = (turned[a] + kick[a]) - cut[a];
                value[a] = old[a] + y;
                rest[a] = (value[a] - old[a]) - y;
                finite = value[a].mul_add(zero[0], finite);
            }
            if v == 0 && finite.sum() != 0.0 {
                return Err(());
            }
            store(value, &mut group.value[v]);
            store(rest, &mut group.cut[v]);
        }
        (Eight::load(isa, &group.time.0) + Eight::splat(isa, group.step)).store(&mut group.time.0);
        // The iterates of the last sweep, one better than those that were judged, are what the next steps start from.
        group.newest = (group.newest + 1) % HISTORY;
        group.known = (group.known + 1).min(HISTORY);
        let stages = self.columns.stages;
        for i in 0..stages {
            group.history[group.newest * stages + i] = [group.work[i].p, group.work[i].x];
        }
        store(std::array::from_fn(|a| base[a] - mu[a]), &mut group.deltas[group.newest]);
        Ok(())
    }
}
