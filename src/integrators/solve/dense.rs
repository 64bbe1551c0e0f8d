//! The states between the ends of a step.
//!
//! In the chart at the start (g₀, μ₀) of a step, with displacement ξ and momentum m seen from there,
//!
//! g(t) = g₀ τ(ξ), μ(t) = m Ad_{τ(ξ)}, ξ̇ = dτ_ξ⁻¹ η, ṁ = (∂_gL + f) Ad_{τ(ξ)}⁻¹, ∂L/∂η(t, g, η) = μ.
//!
//! g(t) is in the group whatever ξ is, and without a force m = μ₀: the Casimirs are kept. ξ and m are polynomials whose derivatives fit
//! the equations at Lobatto nodes, found by Picard iteration from those of the step at its stages, and then moved linearly in t so that
//! they end where the step does. Where the iteration does not contract, since a force is stiff, ξ and m interpolate the stages.

use super::passed::{Passed, Stages};
use super::through::{Rates, Through};
use crate::algebra::{Covector, Matrix, Vector, apply, pull};
use crate::integrators::{State, StepError};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Real, finite};
use crate::tableau::{Family, TableauError};
use nalgebra::DMatrix;

/// Nodes of a piece for s stages. With s + 3 the error between the steps of the systems of the tests is below the tolerance down to
/// 10⁻¹⁰ (3 to 5 times that at 10⁻¹²), but not of a pure quadrature, whose steps are long: there 2s + 2 are enough. More are taken where fewer leave
/// a tail.
const NODES: [fn(usize) -> usize; 4] = [|s| s + 3, |s| s + 4, |s| s + 5, |s| (2 * s + 2).max(s + 5)];

/// No more than these: the Lobatto nodes that there are.
const MOST_NODES: usize = 64;

/// The last two Legendre coefficients of a piece may stand for this share of the tolerance.
const TAIL: f64 = 0.25;

/// One node more makes them some ten times smaller: this many decades of room are left before there are fewer nodes.
const RESERVE: f64 = 3.0;

/// The iterations end where what is left is below this share of the tolerance.
const SETTLED: i64 = 8;

/// The iterations are given up where the change does not fall by this factor in two of them: one alone may be slow by chance, where
/// the momenta follow the displacements.
const CONTRACTS: f64 = 0.5;

/// After the first change this share of it is taken to be left, or more: what was before is no iteration, but a guess. Or this multiple of the
/// share that was left in another step.
const FIRST: f64 = 0.25;
const CAUTION: i64 = 2;

/// The most iterations.
const MOST: usize = 30;

/// Whether a piece has the Legendre coefficients of (ξ̇, ṁ), or of (ξ, m).
#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    Rates,
    Values,
}

/// The states of one step.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Piece<T: Real, const N: usize, const D: usize> {
    time: T,
    step: T,
    attitude: Matrix<T, D>,
    momentum: Covector<T, N>,
    form: Form,
    /// The coefficients of P_k(2θ − 1), θ = (t − time)/step.
    coefficients: Vec<Rates<T, N>>,
}

impl<T: Real, const N: usize, const D: usize> Piece<T, N, D> {
    pub(super) fn new() -> Self {
        Self {
            time: T::zero(),
            step: T::one(),
            attitude: Matrix::identity(),
            momentum: Covector::zeros(),
            form: Form::Rates,
            coefficients: Vec::new(),
        }
    }

    /// Where it begins.
    pub(super) fn time(&self) -> T {
        self.time
    }

    /// The state at a time.
    pub(super) fn at<R: Retraction<T, N, D>>(
        &self,
        retraction: &R,
        time: T,
    ) -> Result<State<T, N, D>, RetractionError> {
        let theta = (time - self.time) / self.step;
        let (mut x, mut m) = (Vector::zeros(), Covector::zeros());
        // P_{k−1}, P_k at 2θ − 1, and ∫₀^θ P_k = (P_{k+1} − P_{k−1})/(2(2k + 1)).
        let (mut before, mut here, z) = (T::one(), T::one(), theta + theta - T::one());
        for (k, (rate, change)) in self.coefficients.iter().enumerate() {
            let n = T::int(k as i64);
            let next = ((n + n + T::one()) * z * here - n * before) / (n + T::one());
            let weight = match (self.form, k) {
                (Form::Values, _) => here,
                (Form::Rates, 0) => theta * self.step,
                (Form::Rates, _) => (next - before) / (T::int(2) * (n + n + T::one())) * self.step,
            };
            x += rate * weight;
            m += change * weight;
            (before, here) = (here, next);
        }
        if !finite(m.as_slice()) {
            return Err(RetractionError::NotFinite { retraction: "the momentum between two steps" });
        }
        let momentum = seen_from(&retraction.at(&x)?, &(self.momentum + m));
        let attitude = match retraction.tau(&x) {
            Ok(increment) => self.attitude * increment,
            Err(RetractionError::NoGroup { .. }) => self.attitude,
            Err(source) => return Err(source),
        };
        Ok(State { time, momentum, attitude })
    }
}

/// What the pieces of all steps with a tableau are made with.
pub(super) struct Maker<T: Real, const N: usize> {
    /// With few nodes and with more.
    levels: Vec<Level<T, N>>,
    /// Which of them the next piece is tried with.
    level: usize,
    /// The factor by which the second change fell when there was one last. Later ones say nothing of it: where the momenta do not depend on the
    /// displacements they are 0.
    rate: Option<T>,
}

impl<T: Real, const N: usize> Maker<T, N> {
    /// For the steps with a tableau of `stages` stages.
    pub fn new(through: &Through<T>, stages: usize) -> Result<Self, TableauError> {
        let levels = NODES.map(|nodes| Level::new(through, nodes(stages).min(MOST_NODES)));
        Ok(Self { levels: levels.into_iter().collect::<Result<_, _>>()?, level: 0, rate: None })
    }

    /// The states of a step, into `piece`.
    pub fn make<const D: usize, L, F, R>(
        &mut self,
        passed: &Passed<'_, T, N, D, L, F, R>,
        tolerance: T,
        piece: &mut Piece<T, N, D>,
    ) -> Result<(), StepError>
    where
        L: Lagrangian<T, N>,
        F: Force<T, N>,
        R: Retraction<T, N, D>,
    {
        let allowed = tolerance * T::exact(TAIL);
        loop {
            let level = &mut self.levels[self.level];
            let tail = Making { passed, level, piece }.make(tolerance, &mut self.rate)?;
            let (nodes, decades) = (level.nodes.len() as f64, (allowed / tail).to_f64().log10());
            let wanted = nodes - decades.min((decades - RESERVE).max(0.0)).floor();
            let found = self.levels.iter().position(|level| level.nodes.len() as f64 >= wanted);
            let before = std::mem::replace(&mut self.level, found.unwrap_or(self.levels.len() - 1));
            if self.level <= before {
                return Ok(());
            }
        }
    }
}

/// The nodes of a piece, and what is known at them.
struct Level<T: Real, const N: usize> {
    /// In [0, 1], both ends among them.
    nodes: Vec<T>,
    /// ∫₀^{c_i} of the j-th Lagrange polynomial.
    integrals: DMatrix<T>,
    /// From values at the nodes to Legendre coefficients.
    legendre: DMatrix<T>,
    /// From the start, the stages and the end to the nodes, by rows.
    guesses: Vec<Vec<T>>,
    /// (ξ, m − μ₀) at the nodes.
    values: Vec<Rates<T, N>>,
    /// η at the nodes.
    velocities: Vec<Vector<T, N>>,
    rates: Vec<Rates<T, N>>,
}

impl<T: Real, const N: usize> Level<T, N> {
    fn new(through: &Through<T>, n: usize) -> Result<Self, TableauError> {
        // Collocation at the Lobatto nodes: a_ij are the integrals.
        let lobatto = Family::LobattoIIIA.tableau::<T>(n)?;
        let (nodes, weights) = (lobatto.c().as_slice().to_vec(), lobatto.b());
        let mut legendre = DMatrix::zeros(n, n);
        for (j, &node) in nodes.iter().enumerate() {
            for (k, here) in crate::tableau::legendre(n - 1, &(node + node - T::one())).into_iter().enumerate() {
                let order = T::int(k as i64);
                // Lobatto quadrature is exact for P_k² up to k = n − 2; for n − 1 it gives 1/(n − 1).
                let norm = if k + 1 == n { order } else { order + order + T::one() };
                legendre[(k, j)] = norm * weights[j] * here;
            }
        }
        let guess = |&node: &T| {
            let mut row = vec![T::zero(); through.len()];
            through.row(node, &mut row);
            row
        };
        Ok(Self {
            guesses: nodes.iter().map(guess).collect(),
            integrals: lobatto.a().clone(),
            legendre,
            nodes,
            values: vec![(Vector::zeros(), Covector::zeros()); n],
            velocities: vec![Vector::zeros(); n],
            rates: vec![(Vector::zeros(), Covector::zeros()); n],
        })
    }

    /// (ξ, m − μ₀) at node i, from the rates at all nodes.
    fn integral(&self, i: usize, step: T) -> Rates<T, N> {
        let mut sum = (Vector::zeros(), Covector::zeros());
        for (j, rate) in self.rates.iter().enumerate() {
            let weight = self.integrals[(i, j)] * step;
            sum.0 += rate.0 * weight;
            sum.1 += rate.1 * weight;
        }
        sum
    }
}

/// The states of a step on their way into a piece.
struct Making<'m, T: Real, const N: usize, const D: usize, L, F, R> {
    passed: &'m Passed<'m, T, N, D, L, F, R>,
    level: &'m mut Level<T, N>,
    piece: &'m mut Piece<T, N, D>,
}

impl<T, const N: usize, const D: usize, L, F, R> Making<'_, T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// Makes it; returns what the polynomials may miss.
    fn make(&mut self, tolerance: T, rate: &mut Option<T>) -> Result<T, StepError> {
        let passed = self.passed;
        let start = &passed.start.state;
        let time = passed.end.state.time - start.time;
        self.piece.time = start.time;
        // A step that is less than what the time shows.
        self.piece.step = if time == T::zero() { passed.stages.step } else { time };
        (self.piece.attitude, self.piece.momentum) = (start.attitude, start.momentum);
        let settled = (tolerance / T::int(SETTLED)).max(T::int(16) * T::unit_roundoff());
        let end = self.ends()?;
        let contracts = self.iterate(settled, rate)?;
        if !contracts {
            self.interpolate()?;
        }
        let Self { level, piece, .. } = self;
        let last = level.nodes.len() - 1;
        let zero = (Vector::zeros(), Covector::zeros());
        let (form, source, miss) = if contracts {
            let (x, m) = level.integral(last, piece.step);
            (Form::Rates, &level.rates, ((end.0 - x) / piece.step, (end.1 - m) / piece.step))
        } else {
            (Form::Values, &level.values, zero)
        };
        piece.form = form;
        piece.coefficients.clear();
        piece.coefficients.reserve(MOST_NODES.min(2 * level.nodes.len()));
        for k in 0..level.nodes.len() {
            let mut sum = if k == 0 { miss } else { zero };
            for (j, value) in source.iter().enumerate() {
                let weight = level.legendre[(k, j)];
                sum.0 += value.0 * weight;
                sum.1 += value.1 * weight;
            }
            piece.coefficients.push(sum);
        }
        let measure = passed.measure;
        let of = |(x, m): &Rates<T, N>| measure.displaced(x) + measure.shifted(m);
        let missed = piece.coefficients[last - 1..].iter().fold(T::zero(), |sum, coefficient| sum + of(coefficient));
        // ∫ P_k is at most 1/(2k + 1).
        Ok(if contracts { missed * piece.step.abs() / T::int(2 * last as i64) } else { missed })
    }

    /// The values and the rates at both ends, which the step knows; returns the values at the second.
    fn ends(&mut self) -> Result<Rates<T, N>, StepError> {
        let Self { passed, level, piece } = self;
        let Passed { start, end, stages, method, .. } = passed;
        let (x, last) = (stages.increment, level.nodes.len() - 1);
        let point = method.retraction().at(&x).map_err(|source| domain(piece.step, source))?;
        let back = point.ad_inv();
        level.values[0] = (Vector::zeros(), Covector::zeros());
        level.rates[0] = (start.velocity, start.force);
        level.values[last] = (x, end.state.momentum * back - piece.momentum);
        level.rates[last] = (point.d_inv() * end.velocity, end.force * back);
        Ok(level.values[last])
    }

    /// Picard iteration on the values at the inner nodes; whether it settled.
    fn iterate(&mut self, settled: T, rate: &mut Option<T>) -> Result<bool, StepError> {
        let (passed, step, last) = (self.passed, self.piece.step, self.level.nodes.len() - 1);
        let Stages { ends, displacements, velocities, rates, .. } = passed.stages;
        let level = &mut *self.level;
        let (zero, end, turns) = (Vector::zeros(), level.values[last].0, [level.rates[0], level.rates[last]]);
        for i in 1..last {
            let row = &level.guesses[i];
            level.values[i].0 = passed.through.value(row, [&zero, &end], displacements);
            level.velocities[i] = passed.through.value(row, [&ends[0], &ends[1]], velocities);
            level.rates[i] = passed.through.both(row, [&turns[0], &turns[1]], rates);
        }
        let measure = passed.measure;
        // The last change, and the one before it.
        let [mut before, mut earlier] = [T::exact(f64::INFINITY); 2];
        for iteration in 0..MOST {
            for i in 1..last {
                if iteration > 0 && self.evaluate(i).is_err() {
                    return Ok(false);
                }
            }
            let mut change = T::zero();
            for i in 1..last {
                let new = self.level.integral(i, step);
                let value = &mut self.level.values[i];
                change = change.max(measure.displaced(&(new.0 - value.0)));
                if iteration > 0 {
                    change = change.max(measure.shifted(&(new.1 - value.1)));
                }
                *value = new;
            }
            // The first change is that of a guess.
            if !change.all_finite() || (iteration > 2 && change > earlier * T::exact(CONTRACTS)) {
                return Ok(change <= settled);
            }
            if iteration > 0 {
                // What is left after a change is smaller by the rate at which the changes fall.
                let falls = match (iteration, *rate) {
                    (1, Some(rate)) if rate.all_finite() => (rate * T::int(CAUTION)).min(T::exact(FIRST)),
                    (1, _) => (change / before).max(T::exact(FIRST)),
                    (2, _) => *rate.insert(change / before),
                    _ => change / before,
                };
                if change * falls.min(T::one()) <= settled {
                    return Ok(true);
                }
            }
            (before, earlier) = (change, before);
        }
        Ok(false)
    }

    /// The velocity and the rates at node i from the values there.
    fn evaluate(&mut self, i: usize) -> Result<(), StepError> {
        let (method, step, (x, m)) = (self.passed.method, self.piece.step, self.level.values[i]);
        let point = method.retraction().at(&x).map_err(|source| domain(step, source))?;
        let mut state = self.state(i, &x)?;
        state.momentum = seen_from(&point, &(self.piece.momentum + m));
        let velocity = method.velocity_at(&state, &self.level.velocities[i], step)?;
        let impulse = match method.forced() {
            true => {
                let (force, _) = method.force_at(&state, &velocity, step)?;
                point.pull_ad_inv(&force, &pull(&force, point.d()))
            }
            false => Covector::zeros(),
        };
        self.level.velocities[i] = velocity;
        self.level.rates[i] = (apply(point.d_inv(), &velocity), impulse);
        Ok(())
    }

    /// The values at the inner nodes from the stages alone: where the iteration does not contract. There the error of a step is
    /// estimated with the order of the stages, too.
    fn interpolate(&mut self) -> Result<(), StepError> {
        let (passed, last) = (self.passed, self.level.nodes.len() - 1);
        let (Stages { ends, displacements, velocities, .. }, zero) = (passed.stages, Vector::zeros());
        let end = self.level.values[last].0;
        for i in 1..last {
            let row = &self.level.guesses[i];
            let x = passed.through.value(row, [&zero, &end], displacements);
            let velocity = passed.through.value(row, [&ends[0], &ends[1]], velocities);
            let point = passed.method.retraction().at(&x).map_err(|source| domain(self.piece.step, source))?;
            let momentum = passed.method.momentum_at(&self.state(i, &x)?, &velocity);
            self.level.values[i] = (x, momentum * point.ad_inv() - self.piece.momentum);
        }
        Ok(())
    }

    /// The time and the attitude at node i, where the displacement is x; the momentum is left as it is at the start, and so is an attitude that
    /// nothing depends on.
    fn state(&self, i: usize, x: &Vector<T, N>) -> Result<State<T, N, D>, StepError> {
        let (method, piece) = (self.passed.method, &*self.piece);
        let attitude = match method.moves().then(|| method.retraction().tau(x)) {
            Some(Ok(increment)) => piece.attitude * increment,
            None | Some(Err(RetractionError::NoGroup { .. })) => piece.attitude,
            Some(Err(source)) => return Err(domain(piece.step, source)),
        };
        Ok(State { time: piece.time + self.level.nodes[i] * piece.step, momentum: piece.momentum, attitude })
    }
}

/// m Ad_{τ(ξ)} = m dτ_{−ξ} dτ_ξ⁻¹.
fn seen_from<T: Real, const N: usize>(point: &impl TangentPoint<T, N>, m: &Covector<T, N>) -> Covector<T, N> {
    pull(&pull(m, &point.d_neg()), point.d_inv())
}

fn domain<T: Real>(step: T, source: RetractionError) -> StepError {
    StepError::Domain { step: step.to_f64(), stage: None, source }
}
