//! Many bodies at once: a lane a body, eight to a group.

use super::HalfAngle;
use super::retraction::LaneRotation;
use crate::algebra::{Covector, Matrix};
use crate::integrators::ensemble::for_all;
use crate::integrators::lanes::force::{Moved, OnBody, Pose};
use crate::integrators::lanes::kernel::{NEGLIGIBLE, ROUNDING, Stage, load, row, stage, store, table};
use crate::integrators::lanes::vectors::{add_scaled, dot, scale};
use crate::integrators::lanes::{
    Eight, EnsembleForce, Isa, Kernel, LANES, LaneForce, LaneGroup, Lanes, One, Pair, Registers, Row, UnfitTableau,
    Vec3, each,
};
use crate::integrators::trust::Course;
use crate::integrators::variational::Settings;
use crate::integrators::{EnsembleError, OneStep, State, StepError, Variational};
use crate::mechanics::lagrangian::Quadratic;
use crate::tableau::Tableau;
use std::marker::PhantomData;

/// The most steps back from which the stages of the next are extrapolated: a polynomial of degree one less.
const HISTORY: usize = 8;

/// (−1)^j (r over j + 1), j = 0 … r − 1: what carries a polynomial of degree r − 1 one step on.
const EXTRAPOLATION: [[f64; HISTORY]; HISTORY + 1] = extrapolation();

/// For how many steps an iteration is taken to gain at least a quarter of what was measured.
const TRUST: usize = 63;

/// The most that an iteration is trusted to gain.
const MOST_GAIN: f64 = 64.0;

/// A degree of extrapolation is given up for a while where the change is this many times smaller than it must be, or is what
/// rounding makes of it: a multiple of the sum of the weights' sizes, 2^r − 1 for r steps. At times that is
/// looked at.
const SPARE: f64 = 32.0;
const NOISE: f64 = 2.0 * f64::EPSILON;
const LOOK: usize = 8;

/// A degree that was given up and is needed again is kept for the first number of steps, and twice as many each time, up to the second.
const PATIENCE: [usize; 2] = [64, 4096];

/// After how many steps numbers are brought back to an ordinary size.
const HOUSEKEEPING: usize = 64;

const fn extrapolation() -> [[f64; HISTORY]; HISTORY + 1] {
    let mut weights = [[0.0; HISTORY]; HISTORY + 1];
    let mut r = 1;
    while r <= HISTORY {
        let (mut j, mut binomial) = (0, 1.0);
        while j < r {
            binomial = -binomial * (r - j) as f64 / (j + 1) as f64;
            weights[r][j] = -binomial;
            j += 1;
        }
        r += 1;
    }
    weights
}

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

/// Eight bodies, with their forces packed.
#[derive(Clone, Debug)]
struct Group<F> {
    first: usize,
    /// The bodies that are there; the lanes past them repeat the last.
    filled: usize,
    lagrangians: Vec<Quadratic<f64, 3>>,
    force: F,
    /// The inverse inertia, in the unit of the retraction.
    inverse: [[Row; 3]; 3],
    /// t where the group started, by lanes, and what has passed since: a sum, and what rounding has cut off it.
    start: Row,
    elapsed: [f64; 2],
    /// μ, and what rounding has cut off it.
    momentum: [Row; 3],
    momentum_rest: [Row; 3],
    /// The attitude is g₀ R(q): g₀ by rows; q = w, x, y, z of any length; and what rounding has cut off q.
    attitude: [[Row; 3]; 3],
    turn: [Row; 4],
    turn_rest: [Row; 4],
    /// Steps since sizes were seen to.
    since: usize,
    diagonal: bool,
    /// The iterates of the steps before, a ring for each pair of stages: of how many steps, and where those of the last step
    /// are.
    iterates: Vec<[Iterate; HISTORY]>,
    known: usize,
    newest: usize,
    step: f64,
    /// From how many steps the next is extrapolated, and for how many steps that number stays at least.
    reach: usize,
    patience: usize,
    /// For how many steps it will stay when it has to rise again: doubled each time, and never halved.
    caution: usize,
    /// How many times smaller an iteration makes an error, a quarter of what it was when it was measured; and for how many
    /// steps that is taken to be so.
    gain: f64,
    trusted: usize,
    /// Where rounding of g has decided when a step was solved, how much the force changes as g does, and what η that is; else 0.
    sensitivity: [Row; 2],
}

/// Two stages of eight bodies. Stages go in pairs, one operation on both: neither waits for the other. An odd one has a
/// companion without weights.
#[derive(Clone, Copy, Debug, Default)]
struct Iterate {
    /// P_i − μ: rounding errors of P_i itself would be magnified by what extrapolates it.
    d: Vec3<[Row; 2]>,
    /// Ξ_i, in the unit of the retraction.
    x: Vec3<[Row; 2]>,
}

/// The most pairs.
const PAIRS: usize = LANES / 2;

/// A number of two stages.
type Two<I> = Pair<Eight<I>>;

/// P_i − μ, or Ξ_i, of P pairs of stages.
type Values<I, const P: usize> = [Vec3<Two<I>>; P];

/// What an iteration makes of stages: Ω_i and dτ⁻¹ Ω_i in the unit of the retraction, G_i, what the force adds to μ, the
/// size of Ξ_i.
#[derive(Clone, Copy)]
struct Iterated<V> {
    velocity: Vec3<V>,
    rate: Vec3<V>,
    gradient: Vec3<V>,
    kick: Vec3<V>,
    size: V,
}

/// The coefficients of a tableau times the step: h b, h c, h a_ij and h (â_ij − b_j) at [i][j].
#[derive(Clone, Copy, Debug)]
struct Scaled {
    pairs: usize,
    h: f64,
    /// |h|.
    size: f64,
    b: Row,
    c: Row,
    a: [Row; LANES],
    conjugate_less_b: [Row; LANES],
}

impl Scaled {
    fn new(tableau: &Tableau<f64>, h: f64) -> Self {
        let (stages, conjugate) = (tableau.stages(), tableau.conjugate());
        Self {
            pairs: stages.div_ceil(2),
            h,
            size: h.abs(),
            b: row(stages, |j| h * tableau.b()[j]),
            c: row(stages, |j| h * tableau.c()[j]),
            a: table(stages, |i, j| h * tableau.a()[(i, j)]),
            conjugate_less_b: table(stages, |i, j| h * (conjugate.a()[(i, j)] - tableau.b()[j])),
        }
    }
}

/// Many bodies on SO(3), each with its own inertia, force and state, with one tableau and one step size.
///
/// A lane of the registers holds a body, so that eight advance at the price of one; with the feature `rayon` the groups of
/// eight are spread over the threads of rayon's pool. Which bodies share a group depends on their order alone, so the
/// results are the same bits at any number of threads. The step is that of [`Variational`], to round-off: its stages start
/// from the last eight steps, or fewer where these do, and a fixed-point iteration runs until the residual that is left is
/// as wanted in every lane. That residual is estimated: it is the last change, which is measured, times the contraction,
/// which is taken as four times what it was when two iterations in one step showed it, at most 63 steps ago. A step whose
/// iteration does not contract in some lane is taken by [`Variational`] for each body of the group.
///
/// The attitude is g = g₀ R(q), with g₀ the attitude of the start and a quaternion q of any length: g gᵀ stays what it was to
/// round-off over any number of steps.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::State;
/// use euler_poincare::integrators::EnsembleError;
/// use euler_poincare::integrators::lanes::{Damping, LaneForceError, Term, Terms};
/// use euler_poincare::integrators::so3::{EnsembleSo3, Member};
/// use euler_poincare::mechanics::force::{AnyForce, LinearDrag};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::{CayleySo3, Retraction};
/// use euler_poincare::tableau::Family;
///
/// let body = Quadratic::diagonal([1.0, 2.0, 3.0])?;
/// // A force of the catalogue, in lanes.
/// let drag = AnyForce::LinearDrag(LinearDrag::new(Matrix::<f64, 3>::identity())?);
/// let force: Result<Terms, LaneForceError> = Terms::new(&drag, &body, CayleySo3::new().algebra());
/// assert!(matches!(force?.0[..], [Term::LinearDrag(_)]));
///
/// // Ten bodies with forces of their own, eight to a register.
/// let member = |k: usize| Member {
///     lagrangian: body.clone(),
///     force: Terms(vec![Term::Constant([0.0, 0.0, k as f64 / 10.0])]),
///     state: State { time: 0.0, momentum: Covector::zeros(), attitude: Matrix::identity() },
/// };
/// let members: Vec<_> = (0..10).map(member).collect();
/// let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), Family::Gauss.tableau(2)?)?;
/// let moved: Result<(), EnsembleError> = ensemble.advance(0.1, 10);
/// moved?;
/// // A constant torque about an axis: μ = t f.
/// for (k, state) in ensemble.states().enumerate() {
///     assert!((state.momentum - Covector::<f64, 3>::new(0.0, 0.0, k as f64 / 10.0)).amax() < 1e-13);
/// }
///
/// // On from there with another kind of force.
/// let damped = |state| Member { lagrangian: body.clone(), force: Damping(0.1), state };
/// let members: Vec<_> = ensemble.states().map(damped).collect();
/// let ensemble = EnsembleSo3::new(&members, CayleySo3::new(), Family::Gauss.tableau(2)?)?;
/// assert_eq!(ensemble.len(), 10);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct EnsembleSo3<F: EnsembleForce, R> {
    tableau: Tableau<f64>,
    retraction: R,
    settings: Settings<f64>,
    registers: Registers,
    forces: Vec<F>,
    groups: Vec<Group<F::Packed>>,
}

impl<F: EnsembleForce, R: HalfAngle> EnsembleSo3<F, R> {
    /// An ensemble.
    ///
    /// # Errors
    /// A tableau of more than eight stages.
    pub fn new(members: &[Member<F>], retraction: R, tableau: Tableau<f64>) -> Result<Self, UnfitTableau> {
        let stages = tableau.stages();
        if stages > LANES {
            return Err(UnfitTableau { stages });
        }
        let unit = <R::Lanes as LaneGroup>::UNIT;
        let group = |(k, chunk)| Group::new(k * LANES, chunk, stages, unit);
        let groups = members.chunks(LANES).enumerate().map(group).collect();
        let forces = members.iter().map(|member| member.force.clone()).collect();
        let settings = Settings::default();
        Ok(Self { tableau, retraction, settings, registers: Registers::detect(), forces, groups })
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
        R: Sync,
    {
        let Self { tableau, retraction, settings, registers, forces, groups } = self;
        let (tableau, retraction, settings, forces) = (&*tableau, &*retraction, *settings, &*forces);
        let registers = *registers;
        let scaled = &Scaled::new(tableau, h);
        let run = |(_, group): (usize, &mut Group<F::Packed>)| -> Result<(), EnsembleError> {
            if group.step != h {
                (group.step, group.known) = (h, 0);
            }
            let mut step = 0;
            while step < steps {
                let left = steps - step;
                step += registers.run(Steps::<F::Packed, R::Lanes> {
                    group,
                    scaled,
                    settings,
                    left,
                    retraction: PhantomData,
                });
                if step < steps {
                    let forces = &forces[group.first..group.first + group.filled];
                    group.one_by_one(forces, retraction, tableau, settings, h).map_err(|(lane, source)| {
                        EnsembleError { member: group.first + lane, step, time: group.time(lane), source }
                    })?;
                    step += 1;
                }
            }
            Ok(())
        };
        for_all(groups, run)
    }
}

impl<F: LaneForce> Group<F> {
    fn new<One>(first: usize, members: &[Member<One>], stages: usize, unit: f64) -> Self
    where
        One: EnsembleForce<Packed = F>,
    {
        let member = |lane: usize| &members[lane.min(members.len() - 1)];
        let row = |f: &dyn Fn(&Member<One>) -> f64| Row(std::array::from_fn(|lane| f(member(lane))));
        let mut group = Self {
            first,
            filled: members.len(),
            lagrangians: members.iter().map(|m| m.lagrangian.clone()).collect(),
            force: One::pack(std::array::from_fn(|lane| &member(lane).force)),
            inverse: std::array::from_fn(|r| std::array::from_fn(|c| row(&|m| m.lagrangian.inverse()[(r, c)] / unit))),
            start: Row::default(),
            elapsed: [0.0; 2],
            momentum: [Row::default(); 3],
            momentum_rest: [Row::default(); 3],
            attitude: [[Row::default(); 3]; 3],
            turn: [Row::default(); 4],
            turn_rest: [Row::default(); 4],
            since: 0,
            diagonal: members
                .iter()
                .all(|m| (0..3).all(|r| (0..3).all(|c| r == c || m.lagrangian.inverse()[(r, c)] == 0.0))),
            iterates: vec![[Iterate::default(); HISTORY]; stages.div_ceil(2)],
            known: 0,
            newest: 0,
            step: 0.0,
            reach: HISTORY,
            patience: 0,
            caution: PATIENCE[0],
            gain: 1.0,
            trusted: 0,
            sensitivity: [Row::default(); 2],
        };
        group.place(&std::array::from_fn(|lane| &member(lane).state));
        group
    }

    /// The bodies are there, and nothing is known of the steps before.
    fn place(&mut self, states: &[&State<f64, 3, 3>; LANES]) {
        let row = |f: &dyn Fn(&State<f64, 3, 3>) -> f64| Row(states.map(f));
        (self.start, self.elapsed) = (row(&|state| state.time), [0.0; 2]);
        self.momentum = std::array::from_fn(|a| row(&|state| state.momentum[a]));
        self.attitude = std::array::from_fn(|r| std::array::from_fn(|c| row(&|state| state.attitude[(r, c)])));
        (self.momentum_rest, self.turn_rest) = Default::default();
        self.turn = std::array::from_fn(|k| Row([if k == 0 { 1.0 } else { 0.0 }; LANES]));
        self.known = 0;
    }

    fn time(&self, lane: usize) -> f64 {
        self.start.0[lane] + self.elapsed[0]
    }

    fn state(&self, lane: usize) -> State<f64, 3, 3> {
        let start = self.attitude.map(|row| row.map(|entry| One(entry.0[lane])));
        let rows = turned(start, self.turn.map(|entry| One(entry.0[lane])));
        State {
            time: self.time(lane),
            momentum: Covector::<f64, 3>::from_fn(|_, a| self.momentum[a].0[lane]),
            attitude: Matrix::<f64, 3>::from_fn(|r, c| rows[r][c].0),
        }
    }

    /// The step by [`Variational`], body by body.
    #[cold]
    fn one_by_one<One: EnsembleForce<Packed = F>, R: HalfAngle>(
        &mut self,
        forces: &[One],
        retraction: &R,
        tableau: &Tableau<f64>,
        settings: Settings<f64>,
        h: f64,
    ) -> Result<(), (usize, StepError)> {
        self.known = 0;
        let mut next = Vec::with_capacity(self.filled);
        for lane in 0..self.filled {
            let lagrangian = self.lagrangians[lane].clone();
            let force =
                OnBody { force: forces[lane].clone(), group: retraction.in_lanes(), lagrangian: lagrangian.clone() };
            let mut method =
                Variational::with_settings(lagrangian, force, retraction.clone(), tableau.clone(), settings);
            let mut state = self.state(lane);
            method.step(&mut state, h).map_err(|source| (lane, source))?;
            if let Some(sensitivity) = method.rounded(&state) {
                let mobility = self.inverse.iter().flatten().fold(0.0, |most: f64, row| most.max(row.0[lane].abs()));
                for lane in lane..if lane + 1 == self.filled { LANES } else { lane + 1 } {
                    (self.sensitivity[0].0[lane], self.sensitivity[1].0[lane]) = (sensitivity, mobility * sensitivity);
                }
            }
            next.push(state);
        }
        self.place(&std::array::from_fn(|lane| &next[lane.min(self.filled - 1)]));
        Ok(())
    }

    /// What decays is 0 beside |μ| before it is so small that arithmetic with it is slow; and quaternions are multiplied by
    /// a power of two, which changes no digit.
    #[cold]
    fn see_to_sizes(&mut self) {
        self.since = 0;
        for lane in 0..LANES {
            let size = (0..3).map(|a| self.momentum[a].0[lane].abs()).fold(0.0, f64::max);
            for a in 0..3 {
                if self.momentum[a].0[lane].abs() < NEGLIGIBLE * size {
                    (self.momentum[a].0[lane], self.momentum_rest[a].0[lane]) = (0.0, 0.0);
                }
            }
            let square: f64 = self.turn.iter().map(|row| row.0[lane] * row.0[lane]).sum();
            // |q|² is between 2^(2k) and 2^(2k + 2).
            let k = (((square.to_bits() >> 52) & 0x7ff) as i64 - 1023) >> 1;
            let factor = f64::from_bits(((1023 - k) as u64) << 52);
            for row in self.turn.iter_mut().chain(&mut self.turn_rest) {
                row.0[lane] *= factor;
            }
        }
    }
}

/// Steps of a group until there are none left, or fixed-point iterations do not solve one: how many were taken.
struct Steps<'a, F, R> {
    group: &'a mut Group<F>,
    scaled: &'a Scaled,
    settings: Settings<f64>,
    left: usize,
    retraction: PhantomData<R>,
}

impl<F: LaneForce, R: LaneRotation> Kernel for Steps<'_, F, R> {
    type Output = usize;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> usize {
        let Self { group, scaled, settings, left, retraction: _ } = self;
        // Something on the stack that must lie at a multiple of 64, so that what the compiler puts there for want of registers
        // does so, too: across two lines of the cache a number takes long to be written and read again, and steps took up to
        // half as long again.
        let mut anchor = Row::ZERO;
        std::hint::black_box(&mut anchor);
        for taken in 0..left {
            let solved = match scaled.pairs {
                1 if !I::RARE => group.step::<I, R, 1>(isa, scaled, settings),
                _ => group.step::<I, R, PAIRS>(isa, scaled, settings),
            };
            if !solved {
                return taken;
            }
        }
        left
    }
}

/// value + increment, and what rounding cuts off that, to be part of the next increment.
#[inline(always)]
fn sum<I: Isa, const K: usize>(value: [Eight<I>; K], increment: [Eight<I>; K]) -> ([Eight<I>; K], [Eight<I>; K]) {
    let sum = each!(K, k => value[k] + increment[k]);
    (sum, each!(K, k => increment[k] - (sum[k] - value[k])))
}

/// The rows of g₀ R(q), from those of g₀ and q = w, x, y, z of any length.
#[inline(always)]
fn turned<V: Lanes>(start: [Vec3<V>; 3], [w, x, y, z]: [V; 4]) -> [Vec3<V>; 3] {
    let (one, two) = (w.constant(1.0), w.constant(2.0));
    let per_half = two / z.mul_add(z, y.mul_add(y, x.mul_add(x, w * w)));
    let (a, b, c) = (per_half * x, per_half * y, per_half * z);
    let turn = [
        [b.neg_mul_add(y, c.neg_mul_add(z, one)), c.neg_mul_add(w, a * y), b.mul_add(w, c * x)],
        [c.mul_add(w, a * y), a.neg_mul_add(x, c.neg_mul_add(z, one)), a.neg_mul_add(w, b * z)],
        [b.neg_mul_add(w, c * x), a.mul_add(w, b * z), a.neg_mul_add(x, b.neg_mul_add(y, one))],
    ];
    each!(3, r => {
        let [x, y, z] = start[r];
        add_scaled(add_scaled(scale(x, turn[0]), y, turn[1]), z, turn[2])
    })
}

/// Numbers 2k and 2k + 1 of a list.
#[inline(always)]
fn splat<I: Isa>(isa: I, list: &Row, k: usize) -> Two<I> {
    Pair(Eight::splat(isa, list.0[2 * k]), Eight::splat(isa, list.0[2 * k + 1]))
}

/// The two columns of rows 2i, 2i + 1 and columns 2j, 2j + 1.
#[inline(always)]
fn entries<I: Isa>(isa: I, table: &[Row; LANES], i: usize, j: usize) -> [Two<I>; 2] {
    each!(2, k => {
        let (upper, lower) = (table[2 * i].0[2 * j + k], table[2 * i + 1].0[2 * j + k]);
        Pair(Eight::splat(isa, upper), Eight::splat(isa, lower))
    })
}

#[inline(always)]
fn rows<I: Isa>(isa: I, rows: &Vec3<[Row; 2]>) -> Vec3<Two<I>> {
    each!(3, a => Pair(Eight::load(isa, &rows[a][0].0), Eight::load(isa, &rows[a][1].0)))
}

#[inline(always)]
fn write<I: Isa>(values: Vec3<Two<I>>, rows: &mut Vec3<[Row; 2]>) {
    for a in 0..3 {
        store([values[a].0, values[a].1], &mut rows[a]);
    }
}

/// What the polynomial of degree `reach` − 1 through `old`, by age from 0, is one step on.
#[inline(always)]
fn extrapolated<'a, I: Isa>(isa: I, reach: usize, old: impl Fn(usize) -> &'a Vec3<[Row; 2]>) -> Vec3<Two<I>> {
    // The oldest first: nothing waits for the newest but one multiplication. The weight of the oldest is 1 or −1.
    let weights = &EXTRAPOLATION[reach];
    let mut sum = rows(isa, old(reach - 1));
    for age in (0..reach - 1).rev() {
        let (weight, x) = (Eight::splat(isa, weights[age]), rows(isa, old(age)));
        sum = if age + 2 == reach && reach.is_multiple_of(2) {
            each!(3, a => Pair(weight.mul_sub(x[a].0, sum[a].0), weight.mul_sub(x[a].1, sum[a].1)))
        } else {
            add_scaled(sum, Pair(weight, weight), x)
        };
    }
    sum
}

/// sum + h Σ_i w_i x_i.
#[inline(always)]
fn weighted<I: Isa>(weights: Two<I>, x: Vec3<Two<I>>, sum: Vec3<Eight<I>>) -> Vec3<Eight<I>> {
    each!(3, a => weights.1.mul_add(x[a].1, weights.0.mul_add(x[a].0, sum[a])))
}

/// sum − h Σ_i w_i x_i.
#[inline(always)]
fn less_weighted<I: Isa>(weights: Two<I>, x: Vec3<Two<I>>, sum: Vec3<Eight<I>>) -> Vec3<Eight<I>> {
    each!(3, a => weights.1.neg_mul_add(x[a].1, weights.0.neg_mul_add(x[a].0, sum[a])))
}

/// sum + h Σ_j w_ij x_j for two i and two j, w by columns.
#[inline(always)]
fn combined<I: Isa>(weights: [Two<I>; 2], x: Vec3<Two<I>>, sum: Vec3<Two<I>>) -> Vec3<Two<I>> {
    each!(3, a => {
        let first = weights[0].mul_add(Pair(x[a].0, x[a].0), sum[a]);
        weights[1].mul_add(Pair(x[a].1, x[a].1), first)
    })
}

#[inline(always)]
fn both<V: Copy>(v: Vec3<V>) -> Vec3<Pair<V>> {
    each!(3, a => Pair(v[a], v[a]))
}

/// Whether each change is at most a multiple of its scale, in every lane.
#[inline(always)]
fn within<I: Isa>(isa: I, changes: [(Eight<I>, Eight<I>); 2], most: f64) -> bool {
    let [(shift, scale), (turn, extent)] = changes;
    let most = Eight::splat(isa, most);
    shift.all_le(most * scale) && turn.all_le(most * extent)
}

/// The largest component, lane by lane.
#[inline(always)]
fn bound<I: Isa>(v: Vec3<Eight<I>>) -> Eight<I> {
    v[0].max_abs(v[1]).max_abs(v[2])
}

/// The largest component of new − old, lane by lane.
#[inline(always)]
fn change<I: Isa>(new: Vec3<Two<I>>, old: Vec3<Two<I>>) -> Eight<I> {
    let change = each!(3, a => new[a] - old[a]);
    bound(each!(3, a => change[a].0)).max_abs(bound(each!(3, a => change[a].1)))
}

impl<F: LaneForce> Group<F> {
    /// Ω in the unit of the retraction.
    #[inline(always)]
    fn velocity<V: Lanes>(&self, m: Vec3<V>) -> Vec3<V> {
        if self.diagonal {
            return each!(3, r => m[0].read(&self.inverse[r][r].0) * m[r]);
        }
        each!(3, r => dot(each!(3, c => m[0].read(&self.inverse[r][c].0)), m))
    }

    /// The first P_i − μ and Ξ_i.
    #[inline(always)]
    fn predict<I: Isa, const P: usize>(
        &mut self,
        isa: I,
        scaled: &Scaled,
        pairs: usize,
    ) -> (Values<I, P>, Values<I, P>) {
        let zero = both([Eight::splat(isa, 0.0); 3]);
        if self.known == 0 {
            self.trusted = 0;
            let eta = both(self.velocity(load(isa, &self.momentum)));
            return (
                [zero; P],
                each!(P, i => {
                    let hc = splat(isa, &scaled.c, i);
                    each!(3, k => hc * eta[k])
                }),
            );
        }
        // One pair of stages and many steps is what most runs consist of. A number that is known here unrolls the loops.
        match self.reach.min(self.known) {
            8 if P == 1 => self.extrapolate(isa, 8, pairs),
            7 if P == 1 => self.extrapolate(isa, 7, pairs),
            6 if P == 1 => self.extrapolate(isa, 6, pairs),
            reach => self.extrapolate(isa, reach, pairs),
        }
    }

    /// P_i − μ and Ξ_i of the next step, from polynomials through those of the last `reach`.
    #[inline(always)]
    fn extrapolate<I: Isa, const P: usize>(&self, isa: I, reach: usize, pairs: usize) -> (Values<I, P>, Values<I, P>) {
        let zero = both([Eight::splat(isa, 0.0); 3]);
        // By age, from 0.
        let old = |age: usize, i: usize| &self.iterates[i][(self.newest + HISTORY - age) % HISTORY];
        (
            each!(P, i => if i < pairs { extrapolated(isa, reach, |age| &old(age, i).d) } else { zero }),
            each!(P, i => if i < pairs { extrapolated(isa, reach, |age| &old(age, i).x) } else { zero }),
        )
    }

    /// Where the bodies are.
    #[inline(always)]
    fn pose<I: Isa>(&self, isa: I) -> [Vec3<Eight<I>>; 3] {
        turned(each!(3, r => load(isa, &self.attitude[r])), load(isa, &self.turn))
    }

    /// What an iteration makes of stages.
    #[inline(always)]
    fn iterated<V: Lanes, R: LaneRotation>(
        &self,
        t: V,
        from: Pose<'_, V, R, 3>,
        mu: Vec3<V>,
        d: Vec3<V>,
        x: Vec3<V>,
        forced: bool,
    ) -> Iterated<V> {
        let p = each!(3, a => mu[a] + d[a]);
        let at = R::MAP.at(x, true);
        let m = R::MAP.unpull(&at, x, p);
        let velocity = self.velocity(m);
        // A sum, which some processors have units of its own for.
        let eta = if R::HALVED { each!(3, a => velocity[a] + velocity[a]) } else { velocity };
        let Stage { rate, gradient, force } = stage(
            &self.force,
            forced,
            t,
            Moved::<_, R, V, 3, 3> { from, group: from.group, at: &at, x },
            [p, m],
            [eta, velocity],
        );
        let kick = if forced { R::MAP.carried(&at, x, force) } else { force };
        Iterated { velocity, rate, gradient, kick, size: R::MAP.size(&at, x) }
    }

    /// The state at the end of a step, with `end` = what dτ adds to μ + kick; `false` where it is not finite.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "values in registers; all are inlined")]
    fn advance<I: Isa, R: LaneRotation>(
        &mut self,
        isa: I,
        scaled: &Scaled,
        mu: Vec3<Eight<I>>,
        kick: Vec3<Eight<I>>,
        end: Vec3<Eight<I>>,
        back: Vec3<Eight<I>>,
        at_back: R::At<Eight<I>>,
    ) -> bool {
        let rest = load(isa, &self.momentum_rest);
        let (momentum, rest) =
            sum(mu, R::MAP.add_turned(back, each!(3, a => mu[a] + kick[a]), end, each!(3, a => kick[a] + rest[a])));
        let finite = Eight::splat(isa, f64::MAX);
        if !((momentum[0] + momentum[1]) + momentum[2]).abs().all_le(finite) {
            return false;
        }
        store(momentum, &mut self.momentum);
        store(rest, &mut self.momentum_rest);
        let q = load(isa, &self.turn);
        let (q, rest) = sum(q, R::MAP.rotated(&at_back, back, q, load(isa, &self.turn_rest)));
        store(q, &mut self.turn);
        store(rest, &mut self.turn_rest);
        let increment = scaled.h + self.elapsed[1];
        let elapsed = self.elapsed[0] + increment;
        self.elapsed = [elapsed, increment - (elapsed - self.elapsed[0])];
        true
    }

    /// Whether the first iteration of a step is enough, by what one made of a change a few steps ago; the degree of the
    /// extrapolation follows.
    #[inline(always)]
    fn settled_at_once<I: Isa>(&mut self, isa: I, changes: [(Eight<I>, Eight<I>); 2], tolerance: f64) -> bool {
        // The residual of the new iterate: what an iteration leaves of a change, as it was a few steps ago.
        let most = if self.trusted > 0 { tolerance * self.gain } else { tolerance };
        let settled = within(isa, changes, most);
        if settled && self.patience > 0 {
            self.patience -= 1;
        } else if settled && self.reach > 1 {
            self.patience = LOOK;
            if within(isa, changes, (most / SPARE).max(NOISE * (1_u32 << self.reach) as f64)) {
                self.reach -= 1;
            }
        } else if !settled && self.trusted > 0 && self.reach < HISTORY {
            (self.reach, self.patience) = (self.reach + 1, self.caution);
            self.caution = (2 * self.caution).min(PATIENCE[1]);
        }
        self.trusted = self.trusted.saturating_sub(1);
        settled
    }

    /// The iterates of the last iteration, one better than those that were judged, are what the next steps start from.
    #[inline(always)]
    fn keep<I: Isa, const P: usize>(&mut self, d: &[Vec3<Two<I>>; P], x: &[Vec3<Two<I>>; P], pairs: usize) {
        self.newest = (self.newest + 1) % HISTORY;
        self.known = (self.known + 1).min(HISTORY);
        for i in 0..P {
            if i < pairs {
                let place = &mut self.iterates[i][self.newest];
                write(d[i], &mut place.d);
                write(x[i], &mut place.x);
            }
        }
    }

    /// The next d and Ξ of the stages: what the first have in common, gradients and rates.
    #[inline(always)]
    fn next_stages<I: Isa, const P: usize>(
        isa: I,
        scaled: &Scaled,
        pairs: usize,
        base: Vec3<Eight<I>>,
        values: &[Iterated<Two<I>>; P],
    ) -> [[Vec3<Two<I>>; 2]; P] {
        let zero = [Eight::splat(isa, 0.0); 3];
        each!(P, i => {
            if i < pairs {
                let (mut next_d, mut next_x) = (both(base), both(zero));
                for j in 0..P {
                    if j < pairs {
                        let a = entries(isa, &scaled.a, i, j);
                        let conjugate = entries(isa, &scaled.conjugate_less_b, i, j);
                        next_d = combined(conjugate, values[j].gradient, next_d);
                        next_x = combined(a, values[j].rate, next_x);
                    }
                }
                [next_d, next_x]
            } else {
                [both(zero); 2]
            }
        })
    }

    /// What residuals are relative to, in every lane: |μ| and |hΩ|, and where forces depend on g what they make of them.
    #[inline(always)]
    fn scales<I: Isa>(
        &self,
        isa: I,
        scaled: &Scaled,
        tolerance: f64,
        [mu, kick]: [Vec3<Eight<I>>; 2],
        velocity: Vec3<Eight<I>>,
    ) -> [Eight<I>; 2] {
        let mut scale = bound(mu);
        let mut extent = Eight::splat(isa, scaled.size) * bound(velocity);
        if self.force.uses_attitude() {
            // Where a body turns back, μ is small beside what the force makes of it.
            scale = scale.max(bound(kick));
            extent = extent.max(Eight::splat(isa, scaled.size) * bound(self.velocity(kick)));
            // Near an equilibrium it is small, too, beside what rounding of g makes of it.
            let share = Eight::splat(isa, scaled.size * (ROUNDING / tolerance));
            let [sensitivity, moved] = load(isa, &self.sensitivity);
            scale = (share * sensitivity).max(scale);
            extent = (share * Eight::splat(isa, scaled.size) * moved).max(extent);
        }
        [scale, extent]
    }

    /// One step; with P pairs of stages, or any number of them where P is the largest. `false`: fixed-point iterations do
    /// not solve it.
    #[inline(always)]
    fn step<I: Isa, R: LaneRotation, const P: usize>(
        &mut self,
        isa: I,
        scaled: &Scaled,
        settings: Settings<f64>,
    ) -> bool {
        let pairs = if P == PAIRS { scaled.pairs } else { P };
        let zero = [Eight::splat(isa, 0.0); 3];
        let tiny = Eight::splat(isa, f64::MIN_POSITIVE);
        let forced = !self.force.vanishes();
        let turned = self.force.uses_attitude();
        let identity = each!(3, r => each!(3, c => Eight::splat(isa, if r == c { 1.0 } else { 0.0 })));
        let rows = if turned { self.pose(isa) } else { identity };
        let from = Pose { rows: each!(3, r => both(rows[r])), group: &R::MAP };
        let mu = load(isa, &self.momentum);
        let (mut d, mut x) = self.predict::<I, P>(isa, scaled, pairs);
        let mut course = Course::<f64>::new();
        for iteration in 1..=settings.max_fixed_point_iterations {
            let t = Eight::load(isa, &self.start.0) + Eight::splat(isa, self.elapsed[0]);
            let nothing = both(zero);
            let nothing =
                Iterated { velocity: nothing, rate: nothing, gradient: nothing, kick: nothing, size: nothing[0] };
            let times = Pair(t, t);
            let values = if I::RARE {
                let mut values = [nothing; P];
                for k in 0..pairs.min(P) {
                    let t = times + splat(isa, &scaled.c, k);
                    values[k] = self.iterated::<Two<I>, R>(t, from, both(mu), d[k], x[k], forced);
                }
                values
            } else {
                // By `each!`, which has no loop where there is one pair: what is in arrays can stay in registers then.
                each!(P, k => {
                    if k < pairs {
                        let t = times + splat(isa, &scaled.c, k);
                        self.iterated::<Two<I>, R>(t, from, both(mu), d[k], x[k], forced)
                    } else {
                        nothing
                    }
                })
            };
            let (mut back, mut kick, mut size) = (zero, zero, values[0].size.0.max(values[0].size.1));
            for k in 0..P {
                let (hb, value) = (splat(isa, &scaled.b, k), &values[k]);
                back = less_weighted(hb, value.rate, back);
                if forced {
                    kick = weighted(hb, value.kick, kick);
                }
                if k > 0 {
                    size = size.max(value.size.0).max(value.size.1);
                }
            }
            let at_back = R::MAP.at(back, true);
            size = size.max(R::MAP.size(&at_back, back));
            let after_impulse = each!(3, a => mu[a] + kick[a]);
            let end = R::MAP.pull_less(&at_back, back, after_impulse);
            // What P_i − μ have in common; δ is this less Σ b_j G_j.
            let base = each!(3, a => end[a] + kick[a]);
            let next = Self::next_stages::<I, P>(isa, scaled, pairs, base, &values);
            let (mut shift, mut turn) = (change(next[0][0], d[0]), change(next[0][1], x[0]));
            for i in 1..P {
                if i < pairs {
                    (shift, turn) = (shift.max(change(next[i][0], d[i])), turn.max(change(next[i][1], x[i])));
                }
            }
            (d, x) = (each!(P, i => next[i][0]), each!(P, i => next[i][1]));
            // The residual is judged in every lane against its own |μ| and |hΩ|.
            let [scale, extent] =
                self.scales(isa, scaled, settings.tolerance, [mu, kick], each!(3, a => values[0].velocity[a].0));
            let changes = [(shift, scale), (turn, extent)];
            let mut settled = false;
            if iteration == 1 {
                settled = self.settled_at_once(isa, changes, settings.tolerance);
            }
            if !settled {
                let change = (shift / scale.max(tiny)).max(turn / extent.max(tiny)).largest();
                if iteration > 1 {
                    self.gain = (0.25 * course.last / change).clamp(1.0, MOST_GAIN);
                    self.trusted = TRUST;
                    settled = change <= settings.tolerance * self.gain;
                }
                course.note(change);
                settled |= course.stagnates() && change <= settings.floor;
                if (settled && course.is_slow()) || (!settled && course.is_lost(change)) {
                    return false;
                }
                if !settled {
                    continue;
                }
            }
            let ordinary = size.all_le(Eight::splat(isa, R::ORDINARY));
            if !ordinary && !in_domain::<I, R, P>(&x, back, at_back) {
                return false;
            }
            // `end` is what dτ adds to μ + kick.
            if !self.advance::<I, R>(isa, scaled, mu, kick, end, back, at_back) {
                return false;
            }
            self.keep(&d, &x, pairs);
            self.since += 1;
            if !ordinary || self.since == HOUSEKEEPING {
                self.see_to_sizes();
            }
            return true;
        }
        false
    }
}

/// Whether the displacements of the stages and of the step are in the domain of the retraction.
#[inline(always)]
fn in_domain<I: Isa, R: LaneRotation, const P: usize>(
    x: &[Vec3<Two<I>>; P],
    back: Vec3<Eight<I>>,
    at_back: R::At<Eight<I>>,
) -> bool {
    let mut square = R::MAP.distance(&at_back, back);
    for x in x {
        let squares = R::MAP.distance(&R::MAP.at(*x, true), *x);
        square = square.max(squares.0).max(squares.1);
    }
    R::MAP.in_domain(square.largest())
}
