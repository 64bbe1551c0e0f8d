//! One step in lanes: the predictor, the fixed-point iterations, the end of the step.

use super::force::{LaneAttitude, LaneForce, Moved, PackedPose};
use super::group::LaneGroup;
use super::{Eight, Isa, Kernel, LANES, Lanes, One, Row};
use crate::integrators::State;
use crate::integrators::trust::Course;
use crate::integrators::variational::ROUNDOFF_LEFT;
use crate::tableau::{Tableau, legendre};
use nalgebra::DMatrix;

/// The coefficients of a tableau, a column a row of eight; what lies past the last stage is zero.
#[derive(Clone, Debug)]
pub(in crate::integrators) struct Columns {
    pub stages: usize,
    /// The columns of a_ij.
    pub a: [Row; LANES],
    /// The columns of â_ij.
    pub conjugate: [Row; LANES],
    /// Whether they are the same.
    pub symplectic: bool,
    pub b: Row,
    pub c: Row,
    /// The columns of (2k + 1) b_j P_k(2 c_j − 1): with a Gauss tableau, what gives the coefficients of the Legendre
    /// polynomials of stage values.
    pub legendre: [Row; LANES],
    /// The columns of ℓ_j(0), ℓ_j(1) with Lagrange's polynomials on the nodes: what gives values at both ends of the
    /// step. Zero where nodes coincide.
    pub ends: [Row; LANES],
    /// The columns of the weights that carry stage values to the next step of the same size.
    pub extrapolation: Option<[Row; LANES]>,
}

/// A number for each stage.
pub(in crate::integrators) fn row(stages: usize, of: impl Fn(usize) -> f64) -> Row {
    Row(std::array::from_fn(|j| if j < stages { of(j) } else { 0.0 }))
}

/// A row for each stage.
pub(in crate::integrators) fn table(stages: usize, of: impl Fn(usize, usize) -> f64) -> [Row; LANES] {
    std::array::from_fn(|i| if i < stages { row(stages, |j| of(i, j)) } else { Row::ZERO })
}

/// ℓ_j(x) on these nodes; 0 where some coincide.
fn lagrange(nodes: &[f64], j: usize, x: f64) -> f64 {
    if (1..nodes.len()).any(|j| (0..j).any(|k| nodes[j] == nodes[k])) {
        return 0.0;
    }
    let others = (0..nodes.len()).filter(|&k| k != j);
    others.map(|k| (x - nodes[k]) / (nodes[j] - nodes[k])).product()
}

impl Columns {
    pub fn new(tableau: &Tableau<f64>, extrapolation: Option<&DMatrix<f64>>) -> Self {
        let (stages, conjugate) = (tableau.stages(), tableau.conjugate());
        let (b, c) = (tableau.b().as_slice(), tableau.c().as_slice());
        let close = |x: f64, y: f64| (x - y).abs() <= 4.0 * f64::EPSILON;
        let symplectic = tableau.a().iter().zip(conjugate.a().iter()).all(|(x, y)| close(*x, *y));
        let columns = |matrix: &DMatrix<f64>| table(stages, |j, i| matrix[(i, j)]);
        let degree = |j: usize, k: usize| (2 * k + 1) as f64 * b[j] * legendre(k, &(2.0 * c[j] - 1.0))[k];
        let ends = |j: usize| if j < stages { row(2, |end| lagrange(c, j, end as f64)) } else { Row::ZERO };
        Self {
            stages,
            conjugate: columns(if symplectic { tableau.a() } else { conjugate.a() }),
            a: columns(tableau.a()),
            symplectic,
            b: row(stages, |j| b[j]),
            c: row(stages, |j| c[j]),
            legendre: table(stages, degree),
            ends: std::array::from_fn(ends),
            extrapolation: extrapolation.map(columns),
        }
    }

    /// The pairs of stages.
    #[inline(always)]
    fn pairs(&self) -> usize {
        self.stages.div_ceil(2).min(LANES / 2)
    }
}

/// (g, μ) as the kernel holds it: the columns of g, with row r in lane r; and what rounding has cut off the sums that made them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::integrators) struct Packed<const N: usize, const D: usize> {
    pub momentum: [f64; N],
    pub momentum_cut: [f64; N],
    pub columns: [Row; D],
    pub columns_cut: [Row; D],
}

impl<const N: usize, const D: usize> Default for Packed<N, D> {
    #[inline(always)]
    fn default() -> Self {
        let nothing = [Row::ZERO; D];
        Self { momentum: [0.0; N], momentum_cut: [0.0; N], columns: nothing, columns_cut: nothing }
    }
}

impl<const N: usize, const D: usize> Packed<N, D> {
    /// That of a state: nothing is cut off.
    #[inline]
    pub fn of(state: &State<f64, N, D>) -> Self {
        let mut packed = Self { momentum: std::array::from_fn(|a| state.momentum[a]), ..Self::default() };
        for c in 0..D {
            for r in 0..D {
                packed.columns[c].0[r] = state.attitude[(r, c)];
            }
        }
        packed
    }

    /// Whether the state is this one.
    #[inline]
    pub fn is(&self, state: &State<f64, N, D>) -> bool {
        let there = |c: usize| (0..D).all(|r| self.columns[c].0[r] == state.attitude[(r, c)]);
        (0..N).all(|a| self.momentum[a] == state.momentum[a]) && (0..D).all(there)
    }

    /// Leaves momentum and attitude in `state`.
    #[inline]
    pub fn unpack(&self, state: &mut State<f64, N, D>) {
        for a in 0..N {
            state.momentum[a] = self.momentum[a];
        }
        for c in 0..D {
            for r in 0..D {
                state.attitude[(r, c)] = self.columns[c].0[r];
            }
        }
    }
}

/// What the error of the quadrature is multiplied with before it is compared to δ, which is smaller than the error.
const TAIL: f64 = 1.0 / 32.0;

/// What quadrature leaves of a kink, of what the polynomial of the stages misses at the ends of the step.
const KINK: f64 = 1.0 / 16.0;

/// 0 and 1, for values at the two ends of a step.
const END_LANE: Row = Row([0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);

/// 1 in these two lanes.
const BOTH_ENDS: Row = Row([1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]);

/// A component of μ that is so small beside |μ| is 0: it has decayed, and would come to numbers below 2⁻¹⁰²², with which
/// arithmetic is slow.
pub(in crate::integrators) const NEGLIGIBLE: f64 = 1e-100;

/// Relative changes in the third iteration of the predictor beyond which one more pays than the stages ask for, and another.
/// For Gauss with eight stages and |Ω|h ≈ 1.5 its point is some 10⁻⁸ from that of the fixed-point iterations on (P, Ξ), of
/// which each costs half as much again and makes the change ten to twenty times smaller, too.
const FAR: [f64; 2] = [2e-5, 1e-4];

/// As many stages as the fixed-point iterations of the predictor are counted for where there are fewer and δ must be small:
/// with fixed-point iterations on (P, Ξ) instead random runs to 10⁻⁴ took half as long again.
const FEWEST: usize = 6;

/// [`ROUNDOFF_LEFT`] in the unit of round-off of `f64`.
pub(in crate::integrators) const ROUNDING: f64 = ROUNDOFF_LEFT as f64 * (f64::EPSILON / 2.0);

/// How far to iterate.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrators) struct Limits<const N: usize> {
    /// The relative residual wanted.
    pub tolerance: f64,
    /// The relative residual accepted where it falls no more.
    pub floor: f64,
    /// What residuals and δ are relative to besides μ and the impulse of the force: 0, or where it is known to be needed what rounding of g
    /// makes of the force in the step, over that of the residual wanted.
    pub rounding: f64,
    /// The relative change at which the predictor has done what it can.
    pub switch: f64,
    pub max_fixed_point_iterations: usize,
    /// What a solver that chooses its step asks for besides.
    pub strict: Option<Strict<N>>,
}

/// What is accepted of δ. With it a step is given up where δ needs more than two renewals.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrators) struct Strict<const N: usize> {
    /// The largest δ, relative to |μ|, and of what it makes of η, relative to |η|.
    pub most: f64,
    /// What rounding makes of δ, relative to |μ|: no velocity need be closer than what that makes of it.
    pub noise: f64,
    /// Of each coordinate, by what factor momenta and velocities of its block are smaller than the largest; `None` where there is one block.
    pub ratios: Option<[[f64; N]; 2]>,
}

/// Why no step was taken.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrators) enum Refused {
    /// The fixed-point iterations, by their number, do not lead to a root that can be trusted.
    NotContracted(usize),
    /// The root was found, by so many iterations, but δ is larger than [`Limits::strict`] allows.
    Delta(f64, usize),
}

/// What a step leaves.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrators) struct Memory<const N: usize> {
    /// The stage momenta M_i, from which the next one starts.
    pub momenta: [Row; N],
    /// Ξ_i, in the unit of the retraction.
    pub displacements: [Row; N],
    /// ξ = h Σ b_i dτ⁻¹ Ω_i: the step was g ← g τ(ξ).
    pub increment: [f64; N],
}

impl<const N: usize> Limits<N> {
    /// [`Limits::rounding`] of a step where the forces change by `sensitivity` as g does.
    #[inline]
    pub fn rounding(step: f64, sensitivity: f64, tolerance: f64) -> f64 {
        step.abs() * sensitivity * (ROUNDING / tolerance)
    }
}

impl<const N: usize> Default for Memory<N> {
    #[inline(always)]
    fn default() -> Self {
        Self { momenta: [Row::ZERO; N], displacements: [Row::ZERO; N], increment: [0.0; N] }
    }
}

/// What a step gave.
#[derive(Clone, Copy, Debug)]
pub(in crate::integrators) struct Taken {
    pub residual: f64,
    /// Fixed-point iterations of the predictor, and on (P, Ξ).
    pub predictor: usize,
    pub iterations: usize,
    /// The relative change of the first iteration on (P, Ξ): how far off the predictor was.
    pub jump: f64,
    /// |δ| relative to |μ|: of the size of the local error.
    pub delta: f64,
    /// The same with what is excused by rounding: what a report tells.
    pub whole: f64,
}

/// One step, to be run in the registers at hand.
pub(in crate::integrators) struct Step<'a, F, R, const N: usize, const D: usize> {
    pub columns: &'a Columns,
    pub group: &'a R,
    pub force: &'a F,
    /// The inverse inertia, symmetric.
    pub inverse: &'a [[f64; N]; N],
    pub diagonal: bool,
    /// The size of its largest entry.
    pub mobility: f64,
    pub time: f64,
    pub step: f64,
    /// Replaced on success.
    pub state: &'a mut Packed<N, D>,
    /// The stages of the step before, replaced on success by those of this one.
    pub memory: &'a mut Memory<N>,
    /// Whether to start from those.
    pub warm: bool,
    pub limits: Limits<N>,
}

/// Stage momenta M, displacements Ξ, and what they are measured by.
struct Predicted<I: Isa, const N: usize> {
    m: [Eight<I>; N],
    x: [Eight<I>; N],
    /// |μ|, or from rest what the force makes of it.
    size: f64,
    /// |h η|.
    extent: f64,
    iterations: usize,
}

/// A root of the stage equations.
struct Root<I: Isa, const N: usize, A> {
    /// M_i, Ξ_i, η_i, f_i.
    m: [Eight<I>; N],
    x: [Eight<I>; N],
    eta: [Eight<I>; N],
    force: [Eight<I>; N],
    /// What P_i has besides the stages.
    base: [Eight<I>; N],
    /// −ξ, and the coefficients there.
    back: [Eight<I>; N],
    at_back: A,
    /// The impulse of the force, ξ, |μ|.
    kick: [f64; N],
    increment: [f64; N],
    size: f64,
    /// |h η|.
    extent: f64,
}

/// Both ends of the step: M and Ξ, and the coefficients there.
struct Ends<I: Isa, const N: usize, A> {
    m: [Eight<I>; N],
    x: [Eight<I>; N],
    at: A,
}

/// Reads eight numbers of each component.
#[inline(always)]
pub(in crate::integrators) fn load<I: Isa, const K: usize>(isa: I, rows: &[Row; K]) -> [Eight<I>; K] {
    each!(K, a => Eight::load(isa, &rows[a].0))
}

/// Writes them.
#[inline(always)]
pub(in crate::integrators) fn store<I: Isa, const K: usize>(values: [Eight<I>; K], rows: &mut [Row; K]) {
    for a in 0..K {
        values[a].store(&mut rows[a].0);
    }
}

/// Eight numbers of each component in memory, for [`product`].
#[inline(always)]
fn written<I: Isa, const N: usize>(x: [Eight<I>; N]) -> [Row; N] {
    let mut rows = [Row::ZERO; N];
    store(x, &mut rows);
    rows
}

/// Σ_j columns_j x_j + base, for stages in lanes. Over pairs of stages in a loop, so that a kernel is compiled once for all tableaux.
#[inline(always)]
fn product<I: Isa, const N: usize>(
    isa: I,
    pairs: usize,
    columns: &[Row; LANES],
    x: &[Row; N],
    base: [Eight<I>; N],
) -> [Eight<I>; N] {
    // Through memory: a load that broadcasts costs less than the shuffles that the compiler would choose.
    let x = std::hint::black_box(x);
    if N > 3 && pairs == 1 {
        // Without loops, which would take 2 to 3 % more instructions.
        let (first, second) = (Eight::load(isa, &columns[0].0), Eight::load(isa, &columns[1].0));
        return each!(N, a => Eight::splat(isa, x[a].0[0]).mul_add(first, base[a]) + Eight::splat(isa, x[a].0[1]) * second);
    }
    let (mut sum, zero) = (base, Eight::splat(isa, 0.0));
    // Three components at once: their sums fit in the registers.
    for part in 0..N.div_ceil(3) {
        let k = 3 * part;
        let (first, second) = (Eight::load(isa, &columns[0].0), Eight::load(isa, &columns[1].0));
        // Two chains of additions a component: the latency of one would be twice as long.
        let mut even = [zero; 3];
        let mut odd = [zero; 3];
        for a in 0..(N - k).min(3) {
            even[a] = Eight::splat(isa, x[k + a].0[0]).mul_add(first, base[k + a]);
            odd[a] = Eight::splat(isa, x[k + a].0[1]) * second;
        }
        for j in 1..pairs {
            let (first, second) = (Eight::load(isa, &columns[2 * j].0), Eight::load(isa, &columns[2 * j + 1].0));
            for a in 0..(N - k).min(3) {
                even[a] = Eight::splat(isa, x[k + a].0[2 * j]).mul_add(first, even[a]);
                odd[a] = Eight::splat(isa, x[k + a].0[2 * j + 1]).mul_add(second, odd[a]);
            }
        }
        for a in 0..(N - k).min(3) {
            sum[k + a] = even[a] + odd[a];
        }
    }
    sum
}

/// The columns times a factor.
#[inline(always)]
fn scaled<I: Isa>(isa: I, columns: &[Row; LANES], factor: Eight<I>) -> [Row; LANES] {
    let mut scaled = [Row::ZERO; LANES];
    for j in 0..LANES {
        (Eight::load(isa, &columns[j].0) * factor).store(&mut scaled[j].0);
    }
    scaled
}

/// Σ_i weights_i x_i. A function and no closure: only what is sure to be inlined is compiled for these registers.
#[inline(always)]
fn sums<I: Isa, const N: usize>(weights: Eight<I>, x: [Eight<I>; N]) -> [f64; N] {
    let mut sums = [0.0; N];
    for a in 0..N {
        sums[a] = (weights * x[a]).sum();
    }
    sums
}

#[inline(always)]
fn largest_change<I: Isa, const N: usize>(x: [Eight<I>; N], y: [Eight<I>; N]) -> Eight<I> {
    let mut largest = (x[0] - y[0]).max_abs(x[N - 1] - y[N - 1]);
    for a in 1..N.max(1) - 1 {
        largest = largest.max_abs(x[a] - y[a]);
    }
    largest
}

#[inline(always)]
fn largest<const N: usize>(x: [f64; N]) -> f64 {
    let mut largest = x[0].abs();
    for a in 1..N {
        // A NaN shows elsewhere.
        if x[a].abs() > largest {
            largest = x[a].abs();
        }
    }
    largest
}

/// dτ⁻¹ η in the unit of the retraction, G = P ddτ(dτ⁻¹ η, ·) + f dτ, and f.
#[derive(Clone, Copy)]
pub(in crate::integrators) struct Stage<V, const N: usize> {
    pub rate: [V; N],
    pub gradient: [V; N],
    pub force: [V; N],
}

/// What a stage makes of (t, g τ(Ξ), P, M), M = P dτ⁻¹, and of η and η in the unit of the retraction: of stages in lanes, and of bodies.
#[inline(always)]
pub(in crate::integrators) fn stage<V, F, G, R, const N: usize, const D: usize>(
    force: &F,
    forced: bool,
    time: V,
    place: Moved<'_, G, R, V, N, D>,
    [p, m]: [[V; N]; 2],
    [eta, in_unit]: [[V; N]; 2],
) -> Stage<V, N>
where
    V: Lanes,
    F: LaneForce<N, D>,
    G: LaneAttitude<V, N, D>,
    R: LaneGroup<N, D>,
{
    let (group, zero) = (place.group, [time.constant(0.0); N]);
    let force = if forced { force.add_to(time, place, m, eta, zero) } else { zero };
    let [rate, gradient] = group.stage(place.at, place.x, [p, m], [eta, in_unit], forced.then_some(force));
    Stage { rate, gradient, force }
}

/// sum + f of eight stages.
struct ForceAt<'a, I: Isa, F, G, const N: usize, const D: usize> {
    force: &'a F,
    time: Eight<I>,
    place: G,
    m: [Eight<I>; N],
    eta: [Eight<I>; N],
    sum: [Eight<I>; N],
}

impl<I, F, G, const N: usize, const D: usize> Kernel for ForceAt<'_, I, F, G, N, D>
where
    I: Isa,
    F: LaneForce<N, D>,
    G: LaneAttitude<Eight<I>, N, D>,
{
    type Output = [Eight<I>; N];

    #[inline(always)]
    fn run<J: Isa>(self, _: J) -> [Eight<I>; N] {
        self.force.add_to(self.time, self.place, self.m, self.eta, self.sum)
    }
}

/// value + (increment − cut), and what that sum cuts off.
#[inline(always)]
pub(in crate::integrators) fn compensated<V: Lanes>(value: V, increment: V, cut: V) -> (V, V) {
    let y = increment - cut;
    let sum = value + y;
    (sum, (sum - value) - y)
}

impl<F: LaneForce<N, D>, R: LaneGroup<N, D>, const N: usize, const D: usize> Step<'_, F, R, N, D> {
    /// Ω, and Ω in the unit of the retraction.
    #[inline(always)]
    fn velocities<V: Lanes>(&self, m: [V; N]) -> ([V; N], [V; N]) {
        let eta = self.velocity(m);
        (eta, if R::HALVED { each!(N, k => m[0].constant(0.5) * eta[k]) } else { eta })
    }

    #[inline(always)]
    fn velocity<V: Lanes>(&self, m: [V; N]) -> [V; N] {
        let mut eta: [V; N] = each!(N, r => m[0].constant(self.inverse[r][r]) * m[r]);
        if !self.diagonal {
            for r in 0..N {
                for c in (0..N).rev() {
                    if c != r {
                        eta[r] = m[0].constant(self.inverse[r][c]).mul_add(m[c], eta[r]);
                    }
                }
            }
        }
        eta
    }

    /// sum + f. A force is most of a kernel's code: on rare processors it is compiled once for all places that evaluate it.
    #[inline(always)]
    fn force_at<I: Isa>(
        &self,
        isa: I,
        time: Eight<I>,
        place: impl LaneAttitude<Eight<I>, N, D>,
        [m, eta, sum]: [[Eight<I>; N]; 3],
    ) -> [Eight<I>; N] {
        let there = ForceAt::<I, F, _, N, D> { force: self.force, time, place, m, eta, sum };
        if I::RARE { isa.apart(there) } else { there.run(isa) }
    }

    /// g τ(x).
    #[inline(always)]
    fn moved<'b, V: Lanes>(
        &'b self,
        like: V,
        at: &'b R::At<V>,
        x: [V; N],
    ) -> Moved<'b, PackedPose<'b, V, R, D>, R, V, N, D> {
        Moved { from: self.here(like), group: self.group, at, x }
    }

    /// g.
    #[inline(always)]
    fn here<V: Lanes>(&self, like: V) -> PackedPose<'_, V, R, D> {
        PackedPose { columns: &self.state.columns, group: self.group, like }
    }

    /// The predictor: plain collocation on (M, Ξ). `None`: nothing to be relative to, or no number. In one piece: in two, the
    /// first for a start without a step before it, steps take 1 to 2 % more instructions.
    #[inline(always)]
    fn predict<I: Isa>(
        &self,
        isa: I,
        a: &[Row; LANES],
        time: Eight<I>,
        hc: Eight<I>,
        mu: [Eight<I>; N],
    ) -> Option<Predicted<I, N>> {
        let (coefficients, pairs) = (self.columns, self.columns.pairs());
        let h = Eight::splat(isa, self.step);
        let zero = [Eight::splat(isa, 0.0); N];
        let momentum = self.state.momentum;
        let mut size = largest(momentum);
        let speeds: [f64; N] = each!(N, r => {
            let mut speed = self.inverse[r][r] * momentum[r];
            if !self.diagonal {
                for c in 0..N {
                    if c != r {
                        speed += self.inverse[r][c] * momentum[c];
                    }
                }
            }
            speed
        });
        let eta: [Eight<I>; N] = each!(N, k => Eight::splat(isa, speeds[k]));
        let mut extent = largest(speeds) * self.step.abs();
        let here = self.here(h);
        let turned = self.force.uses_attitude();
        if turned {
            // As in the general engine: where a body turns back, μ is small beside what the force makes of it.
            let gained = self.force_at(isa, time, here, [mu, eta, zero]);
            let gained = each!(N, k => h.abs() * gained[k]);
            let rounding = self.limits.rounding;
            size = largest_change(gained, zero).max(Eight::splat(isa, size.max(rounding))).largest();
            extent = (h.abs() * largest_change(self.velocity(gained), zero)).max(Eight::splat(isa, extent)).largest();
            if rounding > 0.0 {
                let mobility = self.mobility;
                extent = extent.max(self.step.abs() * mobility * rounding);
            }
        }

        let mut predictor = 1;
        let (mut m, mut x) = match (self.warm && size > 0.0, &coefficients.extrapolation) {
            (true, Some(weights)) => {
                let m = product(isa, pairs, weights, &self.memory.momenta, zero);
                (m, product(isa, pairs, a, &written(self.velocities(m).1), zero))
            }
            _ => {
                let slope = self.force_at(isa, time, here, [mu, eta, self.group.coad(mu, eta)]);
                if size == 0.0 {
                    // From rest: what the force makes of it.
                    let gained = each!(N, k => h * slope[k]);
                    size = largest_change(gained, zero).largest();
                    extent = (h.abs() * largest_change(self.velocity(gained), zero)).largest();
                }
                // The classical method of order four (Kutta 1901; Hairer, Nørsett and Wanner 1993, II.1) on M, and on Ξ where
                // the force asks for g, with a step h c_i in each lane, and Magnus's series on its rates: what three
                // fixed-point iterations would give, without their products.
                let half = hc * Eight::splat(isa, 0.5);
                let start = Eight::splat(isa, self.time);
                let (mut slopes, mut last_slope) = (slope, slope);
                let mut rates = [eta; 4];
                let (mut at, mut x) = (self.group.at(zero, turned), zero);
                let mut rate = self.velocities(mu).1;
                for part in 0..3 {
                    let length = if part == 2 { hc } else { half };
                    let weight = Eight::splat(isa, if part == 2 { 1.0 } else { 2.0 });
                    let m = each!(N, k => length.mul_add(last_slope[k], mu[k]));
                    let eta = self.velocity(m);
                    if turned {
                        x = each!(N, k => length * rate[k]);
                        at = self.group.at(x, true);
                        rate = self.group.rate(&at, x, self.velocities(m).1);
                    }
                    let place = self.moved(h, &at, x);
                    last_slope = self.force_at(isa, start + length, place, [m, eta, self.group.coad(m, eta)]);
                    slopes = each!(N, k => weight.mul_add(last_slope[k], slopes[k]));
                    rates[part + 1] = eta;
                }
                let middle = each!(N, k => (rates[1][k] + rates[2][k]) * Eight::splat(isa, 0.5));
                let sixth = hc * Eight::splat(isa, 1.0 / 6.0);
                predictor = 4;
                (
                    each!(N, k => sixth.mul_add(slopes[k], mu[k])),
                    self.group.displacement(hc, rates[0], middle, rates[3]),
                )
            }
        };
        if !(size > 0.0 && extent > 0.0) {
            return None;
        }
        let (per_size, per_extent) = (Eight::splat(isa, 1.0 / size), Eight::splat(isa, R::UNIT / extent));
        let strict = self.limits.strict.is_some();
        let mut most = if strict { coefficients.stages.max(FEWEST) } else { coefficients.stages };
        // The iteration after which to look how far it moved; that costs a tenth of an iteration.
        let mut look = if predictor == 1 { 2 } else { predictor + 3 };
        while predictor <= most {
            predictor += 1;
            let (eta, eta_unit) = self.velocities(m);
            let at = self.group.at(x, turned);
            let slope = self.force_at(isa, time, self.moved(h, &at, x), [m, eta, self.group.coad(m, eta)]);
            let rate = self.group.rate(&at, x, eta_unit);
            let (slope, rate) = (written(slope), written(rate));
            let (next_m, next_x) = (product(isa, pairs, a, &slope, mu), product(isa, pairs, a, &rate, zero));
            let (last_m, last_x) = (m, x);
            (m, x) = (next_m, next_x);
            if predictor == look {
                look += 2;
                let change =
                    (largest_change(m, last_m) * per_size).max(largest_change(x, last_x) * per_extent).largest();
                if change <= self.limits.switch {
                    break;
                }
                if strict {
                    // How many more is known early, so that the processor need not wait for the last of them.
                    look = 0;
                    most += usize::from(change > FAR[0]) + usize::from(change > FAR[1]);
                }
            }
        }
        Some(Predicted { m, x, size, extent, iterations: predictor })
    }

    /// The end of the step from the root of the stage equations, and δ as it is judged and as it is reported.
    #[inline(always)]
    fn finish<I: Isa>(
        self,
        isa: I,
        h: Eight<I>,
        mu: [Eight<I>; N],
        root: Root<I, N, R::At<Eight<I>>>,
        spent: usize,
    ) -> Result<[f64; 2], Refused> {
        let Root { m, x: displacements, eta, force, base, back, at_back, kick, increment, size, extent } = root;
        let zero = [Eight::splat(isa, 0.0); N];
        let after: [Eight<I>; N] = each!(N, k => Eight::splat(isa, self.state.momentum[k] + kick[k]));
        let turned = self.group.turned(&at_back, back, after);
        let nothing = NEGLIGIBLE * size;
        let mut momentum = [(0.0, 0.0); N];
        // A sum of products with 0 is 0, unless one of the numbers is not finite.
        let mut finite = 0.0;
        for k in 0..N {
            let increment = One(turned[k].first() + kick[k]);
            let (sum, cut) = compensated(One(self.state.momentum[k]), increment, One(self.state.momentum_cut[k]));
            momentum[k] = ((sum.0 + nothing) - nothing, cut.0);
            finite += momentum[k].0 * 0.0;
        }
        let columns = load(isa, &self.state.columns);
        let moved = self.group.moved_back(&at_back, back, columns);
        let mut attitude = [(zero[0], zero[0]); D];
        let mut finite = Eight::splat(isa, finite);
        for c in 0..D {
            attitude[c] = compensated(columns[c], moved[c], Eight::load(isa, &self.state.columns_cut[c].0));
            finite = attitude[c].0.mul_add(zero[0], finite);
        }
        if finite.sum() != 0.0 {
            return Err(Refused::NotContracted(spent));
        }
        let change = each!(N, k => base[k] - mu[k]);
        let mut delta = largest_change(change, zero).largest() / size;
        let mut whole = delta;
        if let Some(Strict { most, noise, .. }) = self.limits.strict {
            let mobility = self.mobility;
            let rounding = self.step.abs() * mobility * size * (noise / most);
            let sizes = [size, if rounding > extent { rounding } else { extent }];
            delta = self.weight(isa, change, sizes).largest();
            if !self.force.vanishes_when_steady() {
                // μ at the start, at the end.
                let end: [Eight<I>; N] = each!(N, k => {
                    Eight::load(isa, &END_LANE.0).mul_add(Eight::splat(isa, momentum[k].0) - mu[k], mu[k])
                });
                let slope = self.group.add_coad(force, m, eta);
                // Ξ at the start, at the end.
                let turned = self.force.uses_attitude();
                let x: [Eight<I>; N] = each!(N, k => Eight::load(isa, &END_LANE.0).neg_mul_add(back[k], zero[k]));
                let at = if turned { self.group.at(x, true) } else { at_back };
                delta = delta.max(self.tail(isa, slope, Ends { m: end, x, at }, h, sizes));
            }
            if delta > most {
                return Err(Refused::Delta(delta, spent));
            }
            whole = delta;
            if rounding > extent {
                whole = whole.max(self.weight(isa, change, [size, extent]).largest());
            }
        }
        self.memory.increment = each!(N, k => R::UNIT * increment[k]);
        for k in 0..N {
            (self.state.momentum[k], self.state.momentum_cut[k]) = momentum[k];
            m[k].store(&mut self.memory.momenta[k].0);
            displacements[k].store(&mut self.memory.displacements[k].0);
        }
        for c in 0..D {
            attitude[c].0.store(&mut self.state.columns[c].0);
            attitude[c].1.store(&mut self.state.columns_cut[c].0);
        }
        Ok([delta, whole])
    }

    /// A change of the momentum relative to |μ|, or what it makes of η relative to |η|, of each block, whichever is larger: about an axis with little
    /// inertia a small error of the momentum is a large one of the velocity.
    #[inline(always)]
    fn weight<I: Isa>(&self, isa: I, change: [Eight<I>; N], [size, extent]: [f64; 2]) -> Eight<I> {
        let (mut of_momentum, mut of_velocity) = (change, self.velocity(change));
        if let Some(Strict { ratios: Some([momentum, velocity]), .. }) = self.limits.strict {
            for k in 0..N {
                of_momentum[k] = Eight::splat(isa, momentum[k]) * of_momentum[k];
                of_velocity[k] = Eight::splat(isa, velocity[k]) * of_velocity[k];
            }
        }
        let zero = [Eight::splat(isa, 0.0); N];
        let momentum = largest_change(of_momentum, zero) * Eight::splat(isa, 1.0 / size);
        momentum.max(largest_change(of_velocity, zero) * Eight::splat(isa, self.step.abs() / extent))
    }

    /// The change of the stages, relative to |μ| and |h η|, of each block where a solver asks for it.
    #[inline(always)]
    fn moved_by<I: Isa>(&self, isa: I, p: [[Eight<I>; N]; 2], x: [[Eight<I>; N]; 2], per: [Eight<I>; 2]) -> f64 {
        if let Some(Strict { ratios: Some([momentum, velocity]), .. }) = self.limits.strict {
            let zero = [Eight::splat(isa, 0.0); N];
            let p = each!(N, k => Eight::splat(isa, momentum[k]) * (p[0][k] - p[1][k]));
            let x = each!(N, k => Eight::splat(isa, velocity[k]) * (x[0][k] - x[1][k]));
            return (largest_change(p, zero) * per[0]).max(largest_change(x, zero) * per[1]).largest();
        }
        (largest_change(p[0], p[1]) * per[0]).max(largest_change(x[0], x[1]) * per[1]).largest()
    }

    /// What the quadrature leaves of h Σ b_j f_j, weighted as δ is, f = M' at the stages.
    ///
    /// With C_k the size of the coefficients of the Legendre polynomials of h f of degree k and ρ² = C_{s−1}/C_{s−3}, smooth
    /// values have C_{2s} ≈ C_{s−1} ρ^{s+1} (geometric decay, as that of Chebyshev's polynomials: Trefethen 2013, Thm 8.1). A
    /// kink inside the step can hide between the stages, so that the C_k fall as if there were none; then the polynomial
    /// misses f at the ends of the step by d > C_s ≈ C_{s−1} ρ, and what the quadrature leaves is some part of d: on 4000
    /// kinked, nearly kinked and smooth scalar problems one error of a hundred was more than 17 times the larger of
    /// C_{s−1} ρ^{s+1}/32 and d/16 (d/C_s)⁸.
    #[inline(always)]
    fn tail<I: Isa>(
        &self,
        isa: I,
        slope: [Eight<I>; N],
        ends: Ends<I, N, R::At<Eight<I>>>,
        h: Eight<I>,
        sizes: [f64; 2],
    ) -> f64 {
        let zero = [Eight::splat(isa, 0.0); N];
        let pairs = self.columns.pairs();
        let slope = written(slope);
        let coefficients = product(isa, pairs, &scaled(isa, &self.columns.legendre, h), &slope, zero);
        let mut found = Row::ZERO;
        self.weight(isa, coefficients, sizes).store(&mut found.0);
        let of = |back: usize| self.columns.stages.checked_sub(back).map_or(0.0, |k| found.0[k]);
        let (last, before) = (of(1).max(of(2)), of(3).max(of(4)));

        let time = Eight::load(isa, &END_LANE.0).mul_add(h, Eight::splat(isa, self.time));
        let Ends { m, x, at } = ends;
        let eta = self.velocity(m);
        let there = self.force_at(isa, time, self.moved(h, &at, x), [m, eta, self.group.coad(m, eta)]);
        let found = product(isa, pairs, &self.columns.ends, &slope, zero);
        let missed = each!(N, k => h * Eight::load(isa, &BOTH_ENDS.0) * (found[k] - there[k]));
        let missed = self.weight(isa, missed, sizes).largest();

        if last >= before {
            return (TAIL * last).max(KINK * missed);
        }
        let square = last / before;
        let ratio = square.sqrt();
        let smooth = TAIL * last * square.powi(self.columns.stages as i32 / 2) * ratio;
        let surprise = (missed / (last * ratio)).min(1.0);
        smooth.max(KINK * missed * surprise.powi(8))
    }
}

impl<F: LaneForce<N, D>, R: LaneGroup<N, D>, const N: usize, const D: usize> Kernel for Step<'_, F, R, N, D> {
    type Output = Result<Taken, Refused>;

    #[inline(always)]
    fn run<I: Isa>(self, isa: I) -> Result<Taken, Refused> {
        let (coefficients, pairs) = (self.columns, self.columns.pairs());
        let h = Eight::splat(isa, self.step);
        let zero = [Eight::splat(isa, 0.0); N];
        let a = scaled(isa, &coefficients.a, h);
        let hb = Eight::load(isa, &coefficients.b.0) * h;
        let hc = Eight::load(isa, &coefficients.c.0) * h;
        let time = Eight::splat(isa, self.time) + hc;
        let momentum = self.state.momentum;
        let mu: [Eight<I>; N] = each!(N, k => Eight::splat(isa, momentum[k]));
        let Some(Predicted { mut m, mut x, size, extent, iterations: predictor }) = self.predict(isa, &a, time, hc, mu)
        else {
            return Err(Refused::NotContracted(0));
        };
        let (per_size, per_extent) = (Eight::splat(isa, 1.0 / size), Eight::splat(isa, R::UNIT / extent));

        // Fixed-point iterations on (P, Ξ).
        let other;
        let conjugate = if coefficients.symplectic {
            &a
        } else {
            other = scaled(isa, &coefficients.conjugate, h);
            &other
        };
        let mut eager = coefficients.stages <= 4;
        let forced = !self.force.vanishes();
        let mut at = self.group.at(x, true);
        let mut p = self.group.pull(&at, x, m);
        let mut base = mu;
        // The last change with δ frozen; how often δ was renewed; the true residuals.
        let (mut jump, mut frozen, mut renewed, mut course) = (0.0, f64::INFINITY, 0, Course::new());
        for iteration in 1..=self.limits.max_fixed_point_iterations {
            let (eta, eta_unit) = self.velocities(m);
            let Stage { rate, gradient, force } =
                stage(self.force, forced, time, self.moved(time, &at, x), [p, m], [eta, eta_unit]);
            let (gradients, rates) = (written(gradient), written(rate));
            let mut next_p = product(isa, pairs, conjugate, &gradients, base);
            let next_x = product(isa, pairs, &a, &rates, zero);
            let mut change = self.moved_by(isa, [next_p, p], [next_x, x], [per_size, per_extent]);
            let settled = change <= self.limits.tolerance || (change >= frozen && change <= self.limits.floor);
            frozen = change;
            if eager || settled {
                // δ, and with it the true residual.
                let mut kick = [0.0; N];
                if forced {
                    kick = sums(hb, self.group.carried(&at, x, force));
                }
                let increment = sums(hb, load(isa, &rates));
                let total = sums(hb, load(isa, &gradients));
                let back: [Eight<I>; N] = each!(N, k => Eight::splat(isa, -increment[k]));
                let at_back = self.group.at(back, true);
                let after_impulse: [f64; N] = each!(N, k => momentum[k] + kick[k]);
                let end = self.group.pull(&at_back, back, each!(N, k => Eight::splat(isa, after_impulse[k])));
                let next_base: [Eight<I>; N] = each!(N, k => end[k] - Eight::splat(isa, total[k]));
                next_p = each!(N, k => next_p[k] + (next_base[k] - base[k]));
                base = next_base;
                frozen = f64::INFINITY;
                renewed += 1;
                change = self.moved_by(isa, [next_p, p], [next_x, x], [per_size, per_extent]);
                if iteration == 1 {
                    jump = change;
                }
                course.note(change);
                if change <= self.limits.tolerance || (eager && course.stagnates() && change <= self.limits.floor) {
                    let farthest = self.group.distance(&at, x).max(self.group.distance(&at_back, back));
                    let inside = self.group.in_domain(farthest.largest());
                    if (eager && course.is_slow()) || !inside {
                        return Err(Refused::NotContracted(predictor + iteration));
                    }
                    let spent = predictor + iteration;
                    let root = Root { m, x, eta, force, base, back, at_back, kick, increment, size, extent };
                    let [delta, whole] = self.finish(isa, h, mu, root, spent)?;
                    return Ok(Taken { residual: change, predictor, iterations: iteration, jump, delta, whole });
                }
                if renewed == 2 && !eager {
                    if self.limits.strict.is_some() {
                        return Err(Refused::NotContracted(predictor + iteration));
                    }
                    // Two renewals were not enough: δ is not small.
                    (eager, course) = (true, Course::new());
                }
            } else if iteration == 1 {
                jump = change;
            }
            // Hopeless: no root, or one that Newton's method must judge.
            if course.is_lost(change) {
                return Err(Refused::NotContracted(predictor + iteration));
            }
            (p, x) = (next_p, next_x);
            at = self.group.at(x, forced);
            m = self.group.unpull(&at, x, p);
        }
        Err(Refused::NotContracted(predictor + self.limits.max_fixed_point_iterations))
    }
}
