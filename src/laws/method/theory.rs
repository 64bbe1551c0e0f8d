//! What the theory says about one system, without the types of its dimensions: start, solution, energy, Casimirs.

use super::form::StateForm;
use crate::algebra::{Covector, Matrix, Vector, basis_vector, pair};
use crate::group::LieGroup;
use crate::integrators::{OneStep, StagePoint, State, StepError};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::{Real, Scalar, convert, larger, max_abs};
use crate::study::reference;
use crate::system::System;

/// A state whatever its dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct Point<T> {
    /// t.
    pub time: T,
    /// μ, n numbers.
    pub momentum: Vec<T>,
    /// g, m×m numbers by rows; none where there is no group. Of a method whose state is a point ([`StateForm::Point`]) the m
    /// numbers of that.
    pub attitude: Vec<T>,
}

impl<T: Real> Point<T> {
    /// A typed state, with the leading m×m block of its attitude (the rest of a padded matrix is that of the identity);
    /// m = 0: without an attitude.
    pub fn of<const N: usize, const D: usize>(state: &State<T, N, D>, size: usize) -> Self {
        Self::leading(state, N, size)
    }

    /// The same with the leading n components of the momentum.
    pub(crate) fn leading<const N: usize, const D: usize>(state: &State<T, N, D>, n: usize, size: usize) -> Self {
        let size = size.min(D);
        let attitude = (0..size * size).map(|k| state.attitude[(k / size, k % size)]).collect();
        Self { time: state.time, momentum: state.momentum.iter().take(n).copied().collect(), attitude }
    }

    /// The typed state; a missing or smaller attitude is filled up with that of the identity.
    pub fn state<const N: usize, const D: usize>(&self) -> State<T, N, D> {
        let size = matrix_size(&self.attitude);
        let attitude = Matrix::<T, D>::from_fn(|r, c| match (r < size && c < size, r == c) {
            (true, _) => self.attitude[r * size + c],
            (false, true) => T::one(),
            (false, false) => T::zero(),
        });
        let momentum = Covector::from_fn(|_, a| self.momentum.get(a).copied().unwrap_or_else(T::zero));
        State { time: self.time, momentum, attitude }
    }

    /// k g for g, by rows.
    pub(crate) fn translated(&self, k: &[T]) -> Self {
        let (m, g) = (matrix_size(k), &self.attitude);
        let entry = |e: usize| (0..m).fold(T::zero(), |sum, j| sum + k[e / m * m + j] * g[j * m + e % m]);
        Self { attitude: (0..m * m).map(entry).collect(), ..self.clone() }
    }

    /// Whether every number is finite.
    pub fn is_finite(&self) -> bool {
        self.time.all_finite() && self.momentum.iter().chain(&self.attitude).all(|x| x.all_finite())
    }

    /// The same in another scalar, to all digits that both have.
    pub fn convert<W: Real>(&self) -> Point<W> {
        let list = |list: &[T]| list.iter().map(|x| convert(*x)).collect();
        Point { time: convert(self.time), momentum: list(&self.momentum), attitude: list(&self.attitude) }
    }
}

/// m of a list of m×m numbers.
pub(super) fn matrix_size<T>(list: &[T]) -> usize {
    list.len().isqrt()
}

/// Where the force acts within a step, whatever the dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct Stage<T> {
    /// b_j.
    pub weight: T,
    /// t_j.
    pub time: T,
    /// g_j, m×m numbers by rows.
    pub attitude: Vec<T>,
    /// η_j, n numbers.
    pub velocity: Vec<T>,
}

/// A one-step method on a system that it knows, whatever the dimensions.
pub trait Stepper<T: Real> {
    /// The state after a step of size h from `point`.
    ///
    /// # Errors
    /// See [`StepError`]; [`StepError::Unsupported`] where the method has nothing to say, [`StepError::NoAnswer`] where
    /// what it said is no state.
    fn step(&mut self, point: &Point<T>, h: T) -> Result<Point<T>, StepError>;

    /// The stages of the last step, which was one of size h from `start`: see [`OneStep::stages`].
    fn stages(&self, _start: &Point<T>, _h: T) -> Option<Vec<Stage<T>>> {
        None
    }
}

/// A typed one-step method without its types.
#[derive(Clone, Debug)]
pub struct Untyped<M, const N: usize, const D: usize>(pub M);

impl<T: Real, M: OneStep<T, N, D>, const N: usize, const D: usize> Stepper<T> for Untyped<M, N, D> {
    fn step(&mut self, point: &Point<T>, h: T) -> Result<Point<T>, StepError> {
        let mut state = point.state::<N, D>();
        self.0.step(&mut state, h)?;
        Ok(Point::leading(&state, point.momentum.len(), matrix_size(&point.attitude)))
    }

    fn stages(&self, start: &Point<T>, h: T) -> Option<Vec<Stage<T>>> {
        let (n, size, g) = (start.momentum.len(), matrix_size(&start.attitude), start.state::<N, D>().attitude);
        let stage = |StagePoint { weight, node, turn, velocity }: StagePoint<T, N, D>| {
            let (time, attitude) = (start.time + node * h, g * turn);
            let at = Point::leading(&State { time, momentum: Covector::<T, N>::zeros(), attitude }, n, size);
            Stage { weight, time, attitude: at.attitude, velocity: velocity.iter().take(n).copied().collect() }
        };
        Some(self.0.stages()?.into_iter().map(stage).collect())
    }
}

/// A function of the state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// E; dE/dt = ⟨f, η⟩ where L does not depend on time.
    Energy,
    /// The k-th Casimir C; dC/dt = ⟨f + ∂_gL, C'(μ)⟩.
    Casimir(usize),
    /// The spatial momentum J = Ad*_{g⁻¹} μ, by components; dJ/dt = Ad*_{g⁻¹} (f + ∂_gL). It needs a group.
    Momentum,
}

pub(super) fn no_value(h: f64) -> StepError {
    StepError::Refused { step: h, why: "what is to be kept has no value".into() }
}

/// The names of what is measured.
pub(super) fn names(quantities: &[Quantity]) -> Vec<String> {
    let name = |quantity: &Quantity| match quantity {
        Quantity::Energy => "energy".to_owned(),
        Quantity::Casimir(k) => format!("Casimir {}", k + 1),
        Quantity::Momentum => "spatial momentum".to_owned(),
    };
    quantities.iter().map(name).collect()
}

/// A component of a [`Quantity`] at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Value<T> {
    /// Its value.
    pub value: T,
    /// The size of the terms that cancel in the value.
    pub size: T,
    /// |μ|_max Σ_a |V'_a(μ)|: how far the value moves, relative to a change of each μ_a by so much of the largest. Of J, whose terms
    /// depend on g, the size.
    pub reach: T,
}

/// The stages of the Gauss method that solutions come from: order 16.
const STAGES: usize = 8;

/// A point of the solution, and how much its momentum and its attitude may be off, rounding apart.
pub type Solved<T> = (Point<T>, (T, T));

/// One system, whatever its dimensions.
pub trait Theory<T: Real> {
    /// Where it starts.
    fn start(&self) -> Point<T>;

    /// h.
    fn step(&self) -> T;

    /// Whether there is neither a force nor a potential.
    fn is_free(&self) -> bool;

    /// Whether the energy is constant: there is no force, and L does not depend on time, as far as a few looks tell.
    fn keeps_energy(&self) -> bool;

    /// Whether nothing depends on time, as far as a few looks tell.
    fn is_autonomous(&self) -> bool;

    /// The names of the parts of the state.
    fn parts(&self) -> Vec<String>;

    /// The components of a quantity; `None` where it has no value.
    fn value(&self, quantity: Quantity, point: &Point<T>) -> Option<Vec<Value<T>>>;

    /// The solution from a state after each of these times, by a classical Gauss method, whose stages are found to a relative tolerance
    /// (0: to round-off). The attitude stays as it is where it is not wanted.
    ///
    /// # Errors
    /// Those of [`reference::within`].
    fn solve(&self, start: &Point<T>, times: &[T], tolerance: f64, attitude: bool)
    -> Result<Vec<Solved<T>>, StepError>;

    /// How fast a motion turns at a state, in 1/time: the largest of ‖J²‖^½ with J the derivative of μ̇ = ad*_η μ + F by
    /// μ, F = f + ∂_gL, ‖ad_η²‖^½, ‖η̂²‖^½, ‖ad_η̇‖^½, ‖∂η/∂μ ∂_gF‖^½, (|d²F/dt²|/|F|)^½ along g exp(tη), and 4|η̇|/|η| where the force is
    /// not smooth at rest (row-sum norms). Infinite where it has no value.
    ///
    /// A Taylor series of the motion, or of a step of a method, has terms of the size (h pace)^k: so h pace ≤ 1 keeps to
    /// where the series tells something.
    fn pace(&self, point: &Point<T>) -> f64;

    /// The row-sum norm of |C^c_ab| |η^a|: what changes of the structure constants by one part of themselves do to ad_η.
    fn turn(&self, point: &Point<T>) -> f64;

    /// Π_ab = C^c_ab μ_c by rows.
    fn brackets(&self, point: &Point<T>) -> Vec<T>;

    /// An element k of the group that is not the identity; `None` where there is no group.
    fn element(&self) -> Option<Vec<T>>;

    /// One whose left translation leaves forces and potentials alone; `None` where none is known.
    fn symmetry(&self) -> Option<Vec<T>>;

    /// f + ∂_gL at a stage.
    fn force(&self, stage: &Stage<T>) -> Vec<T>;
}

/// Why there is no point beside μ.
pub(super) const NO_INVERSE: StepError = StepError::NotFinite { what: "the inverse of the attitude" };

/// A system as the theory sees it, for a method with some state.
#[derive(Clone, Debug)]
pub struct SystemParts<T: Real, const N: usize, const D: usize> {
    /// With the size 0 where the state has nothing beside μ.
    pub(super) system: System<T, N, D>,
    /// An element of the group, to translate with.
    element: Option<Matrix<T, D>>,
    /// What the method has as its state.
    pub(super) form: StateForm,
}

impl<T: Real, const N: usize, const D: usize> SystemParts<T, N, D> {
    /// Of a system, for a method with this state.
    pub fn of(mut system: System<T, N, D>, form: StateForm) -> Self {
        let element = system.group.as_ref().and_then(|_| system.retraction.tau(&coordinates::<T, N>()).ok());
        // Points are not translated: x = g⁻¹ x₀ with another x₀.
        let element = element.filter(|_| form == StateForm::Attitude);
        if system.group.is_none() || form == StateForm::Momentum {
            system.size = 0;
        }
        Self { system, element, form }
    }
}

/// Small fixed coordinates without symmetry.
pub fn coordinates<T: Real, const N: usize>() -> Vector<T, N> {
    Vector::from_fn(|a, _| T::ratio(((7 * a + 3) % 11) as i64 - 5, 16))
}

/// The row-sum norm.
fn norm<T: Real, const M: usize>(matrix: &Matrix<T, M>) -> f64 {
    let sum = |row: usize| (0..M).map(|c| matrix[(row, c)].to_f64().abs()).sum::<f64>();
    (0..M).map(sum).fold(0.0, |m: f64, x| if x.is_nan() { f64::NAN } else { m.max(x) })
}

impl<T: Real, const N: usize, const D: usize> SystemParts<T, N, D> {
    /// Whether anything depends on the configuration.
    fn is_placed(&self) -> bool {
        self.system.force.uses_configuration() || self.system.lagrangian.uses_configuration()
    }

    /// f + ∂_gL.
    fn load(&self, time: T, g: &Matrix<T, D>, eta: &Vector<T, N>) -> Covector<T, N> {
        let g = Configuration::of(g);
        let force = self.system.force.force_at(time, g, eta);
        if !self.system.lagrangian.uses_configuration() {
            return force;
        }
        force + self.system.lagrangian.configuration_gradient(time, g, eta)
    }

    /// η with ∂L/∂η = μ.
    fn velocity(&self, time: T, g: &Matrix<T, D>, mu: &Covector<T, N>) -> Option<Vector<T, N>> {
        self.system.lagrangian.velocity_at(time, Configuration::of(g), mu, &Vector::zeros()).ok()
    }

    /// η and μ̇ at a time, an attitude and a momentum.
    fn rates(&self, time: T, g: &Matrix<T, D>, mu: &Covector<T, N>) -> Option<(Vector<T, N>, Covector<T, N>)> {
        let eta = self.velocity(time, g, mu)?;
        Some((eta, self.system.algebra.coad(&eta, mu) + self.load(time, g, &eta)))
    }

    /// g exp(x), but for terms of third order; g where nothing depends on it.
    fn moved(&self, g: &Matrix<T, D>, x: &Vector<T, N>) -> Matrix<T, D> {
        match self.system.group.as_ref().filter(|_| self.is_placed()) {
            None => *g,
            Some(group) => {
                let hat: Matrix<T, D> = group.hat(x);
                g + g * hat + g * hat * hat * T::half()
            }
        }
    }

    /// The rates of [`Theory::pace`] but that of the attitude.
    fn paces(&self, point: &Point<T>) -> Option<(Vector<T, N>, f64)> {
        let State { momentum: mu, attitude: g, .. } = point.state::<N, D>();
        let (eta, rate) = self.rates(point.time, &g, &mu)?;
        let scale = mu.amax();
        let part = T::exact(2f64.powi(-10));
        let small = part * if scale > T::zero() { scale } else { T::one() };
        let (mut slope, mut mobility) = (Matrix::<T, N>::zeros(), Matrix::<T, N>::zeros());
        for a in 0..N {
            let mut moved = mu;
            moved[a] += small;
            let after = self.rates(point.time, &g, &moved)?;
            moved[a] -= small * T::int(2);
            let before = self.rates(point.time, &g, &moved)?;
            slope.set_row(a, &((after.1 - before.1) / (small * T::int(2))));
            mobility.set_row(a, &((after.0 - before.0).transpose() / (small * T::int(2))));
        }
        // η̇ by the difference along μ̇ over a short time.
        let moment = part * self.system.step.abs();
        let (later, _) = self.rates(point.time + moment, &self.moved(&g, &(eta * moment)), &(mu + rate * moment))?;
        let turning = (later - eta) / moment;
        let ad = self.system.algebra.ad(&eta);
        let mut pace = norm(&(slope * slope)).sqrt();
        pace = pace.max(norm(&(ad * ad)).sqrt()).max(norm(&self.system.algebra.ad(&turning)).sqrt());
        if self.is_placed() {
            // ∂η/∂μ ∂_g(f + ∂_gL): the squares of the frequencies of small oscillations.
            let mut pull = Matrix::<T, N>::zeros();
            for a in 0..N {
                let along = basis_vector::<T, N>(a) * part;
                let (there, back) = (self.moved(&g, &along), self.moved(&g, &-along));
                let change = self.load(point.time, &there, &eta) - self.load(point.time, &back, &eta);
                pull.set_row(a, &(change / (part * T::int(2))));
            }
            pace = pace.max(norm(&(mobility * pull)).sqrt());
        }
        let at = |k: i64| {
            let time = self.system.step * T::ratio(k, 16);
            self.load(point.time + time, &self.moved(&g, &(eta * time)), &eta)
        };
        let (force, bend) = (max_abs(&at(0)).to_f64(), at(1) + at(-1) - at(0) * T::int(2));
        if force > 0.0 {
            pace = pace.max((max_abs(&bend).to_f64() / force).sqrt() * 16.0 / self.system.step.to_f64().abs());
        }
        if !self.system.force.is_smooth() {
            let speed = max_abs(&eta).to_f64();
            pace = pace.max(4.0 * max_abs(&turning).to_f64() / speed.max(f64::MIN_POSITIVE));
        }
        Some((eta, pace))
    }

    /// The k-th of a few velocities and attitudes, each turned on by `turn` of [`coordinates`].
    fn look(&self, k: usize, turn: T) -> (Matrix<T, D>, Vector<T, N>) {
        let (start, eta) = (self.system.state.attitude, |a, _| T::ratio(((5 * a + 3 * k) % 7) as i64 - 3, 4));
        // Where a force vanishes at one attitude it need not at another.
        let group = self.system.group.as_ref().filter(|_| self.is_placed());
        let turn = group.map(|group| exponential(&group.hat(&(coordinates::<T, N>() * (turn * T::int(k as i64))))));
        (turn.map_or(start, |turn| start * turn), Vector::from_fn(eta))
    }

    /// An element k that is not the identity and that leaves forces and momenta alone: those at k g are those at g, at a few states.
    fn known_symmetry(&self) -> Option<Matrix<T, D>> {
        let group = self.system.group.as_ref()?;
        let keeps = |k: &Matrix<T, D>| {
            (0..3).all(|number| {
                let (g, eta) = self.look(number, T::half());
                let time = self.system.state.time + T::ratio(number as i64, 4);
                let values = |g: &Matrix<T, D>| {
                    (self.load(time, g, &eta), self.system.lagrangian.gradient_at(time, Configuration::of(g), &eta))
                };
                let ((force, momentum), (other, as_much)) = (values(&g), values(&(k * g)));
                let size = force.amax().max(momentum.amax()).max(T::one()) * k.amax().max(T::one()) * g.amax();
                larger(max_abs(&(force - other)), max_abs(&(momentum - as_much)))
                    <= size * T::unit_roundoff() * T::int(1024)
            })
        };
        let candidate = |a: usize| {
            let along = basis_vector::<T, N>(a) * T::half();
            Some(exponential(&group.hat(&along))).filter(keeps)
        };
        (0..self.system.dimension).find_map(candidate)
    }

    /// The numbers of an element of the group.
    fn leading(&self, attitude: Matrix<T, D>) -> Option<Vec<T>> {
        let state = State { attitude, ..self.system.state.clone() };
        (self.system.size > 0).then(|| Point::leading(&state, self.system.dimension, self.system.size).attitude)
    }
}

/// exp(A) by the Taylor series of A/2ˢ, |A/2ˢ| ≤ ½ in the norm of row sums, squared s times: 24 terms are right to 2⁻¹⁰⁴.
pub(in crate::laws) fn exponential<S: Scalar, const D: usize>(matrix: &Matrix<S, D>) -> Matrix<S, D> {
    let rows = (0..D).map(|r| matrix.row(r).iter().fold(0.0, |sum, v| sum + v.to_f64().abs()));
    let norm = rows.fold(0.0, f64::max);
    let squarings = if norm > 0.5 && norm.is_finite() { (2.0 * norm).log2().ceil() as i32 } else { 0 };
    let small = matrix * S::exact(2f64.powi(-squarings));
    let one = Matrix::<S, D>::identity();
    let mut sum = one;
    for k in (1..=24).rev() {
        sum = one + small * sum * S::ratio(1, k);
    }
    (0..squarings).fold(sum, |power, _| power * power)
}

impl<T: Real, const N: usize, const D: usize> SystemParts<T, N, D> {
    /// (Ad*_{g⁻¹} μ)_a = μ (g⁻¹ ê_a g)^∨, a = 1 … n.
    fn spatial(&self, mu: &Covector<T, N>, point: &Point<T>) -> Option<Vec<Value<T>>> {
        let known = self.system.size > 0 && self.form == StateForm::Attitude;
        let group = self.system.group.as_ref().filter(|_| known)?;
        let g = point.state::<N, D>().attitude;
        let inverse = group.inverse(&g)?;
        let ones = Matrix::<T, D>::from_fn(|r, c| if r.max(c) < self.system.size { T::one() } else { T::zero() });
        let component = |a: usize| {
            let hat: Matrix<T, D> = group.hat(&basis_vector::<T, N>(a));
            let column = group.vee(&(inverse * hat * g));
            // The terms that cancel: those of the products, and of the sums over the entries that make coordinates.
            let terms = inverse.abs() * hat.abs() * g.abs();
            // What changes of g and g⁻¹ by their largest entries make: rounding leaves that much, times u, of an entry that is 0.
            let changed = inverse.abs() * hat.abs() * ones * g.amax() + ones * hat.abs() * g.abs() * inverse.amax();
            let (mut size, mut reach) = (T::zero(), T::zero());
            for r in 0..D {
                for c in 0..D {
                    if terms[(r, c)] == T::zero() && changed[(r, c)] == T::zero() {
                        continue;
                    }
                    let mut entry = Matrix::<T, D>::zeros();
                    entry[(r, c)] = T::one();
                    let of = group.vee(&entry);
                    let of = mu.iter().zip(of.iter()).fold(T::zero(), |sum, (m, x)| sum + (*m * *x).abs());
                    size += terms[(r, c)] * of;
                    reach += changed[(r, c)] * of;
                }
            }
            Value { value: pair(mu, &column), size, reach: reach.max(size) }
        };
        Some((0..self.system.dimension).map(component).collect())
    }

    /// (g, μ) where a motion starts; g = 1 where a point stands beside μ, so that it is the motion of every point.
    pub(super) fn state(&self, point: &Point<T>) -> State<T, N, D> {
        match self.form {
            StateForm::Point(_) => Point { attitude: Vec::new(), ..point.clone() }.state(),
            _ => point.state(),
        }
    }

    /// Where the motion from a point is with this state, and how far what stands beside μ may be off for each unit that g is.
    pub(super) fn reached(&self, state: &State<T, N, D>, from: &Point<T>) -> Result<(Point<T>, T), StepError> {
        let point = Point::leading(state, self.system.dimension, self.system.size);
        if !matches!(self.form, StateForm::Point(_)) {
            return Ok((point, T::one()));
        }
        let (attitude, stretch) = self.point(&state.attitude, &from.attitude).ok_or(NO_INVERSE)?;
        Ok((Point { attitude, ..point }, stretch))
    }

    /// g⁻¹ x, as many numbers as the group's matrices have rows, and how far it may be off for each unit that g is.
    fn point(&self, g: &Matrix<T, D>, x: &[T]) -> Option<(Vec<T>, T)> {
        let inverse = self.system.group.as_ref()?.inverse(g)?;
        let entry = |c: usize| x.get(c).copied().unwrap_or_else(T::zero);
        let row = |r: usize| (0..D).fold(T::zero(), |sum, c| sum + inverse[(r, c)] * entry(c));
        let size = x.iter().fold(T::zero(), |sum, x| sum + x.abs()) * T::int(self.system.size as i64);
        Some(((0..self.system.size).map(row).collect(), inverse.amax() * inverse.amax() * size))
    }
}

impl<T: Real, const N: usize, const D: usize> Theory<T> for SystemParts<T, N, D> {
    fn start(&self) -> Point<T> {
        let start = Point::leading(&self.system.state, self.system.dimension, self.system.size);
        let StateForm::Point(x) = &self.form else { return start };
        let x: Vec<T> = x.iter().map(|x| T::exact(*x)).collect();
        let attitude = self.point(&self.system.state.attitude, &x).map_or_else(Vec::new, |(x, _)| x);
        Point { attitude, ..start }
    }

    fn parts(&self) -> Vec<String> {
        let beside = if matches!(self.form, StateForm::Point(_)) { "point" } else { "attitude" };
        ["momentum", beside].into_iter().take(if self.system.size > 0 { 2 } else { 1 }).map(str::to_owned).collect()
    }

    fn step(&self) -> T {
        self.system.step
    }

    fn is_free(&self) -> bool {
        self.system.force.is_zero() && !self.system.lagrangian.uses_configuration()
    }

    fn keeps_energy(&self) -> bool {
        self.system.force.is_zero() && (!self.system.lagrangian.uses_configuration() || self.is_autonomous())
    }

    fn is_autonomous(&self) -> bool {
        let at = |time: T, k: usize| {
            let (g, eta) = self.look(k, T::one());
            let here = Configuration::of(&g);
            // L itself, too: a potential of the time alone changes the energy, and no force.
            let momentum = self.system.lagrangian.gradient_at(time, here, &eta);
            (self.load(time, &g, &eta), momentum, self.system.lagrangian.value_at(time, here, &eta))
        };
        let time = |k: usize| self.system.state.time + T::ratio(5 + 4 * k as i64, 8);
        (0..3).all(|k| (0..3).all(|j| at(self.system.state.time, j) == at(time(k), j)))
    }

    fn value(&self, quantity: Quantity, point: &Point<T>) -> Option<Vec<Value<T>>> {
        let State { momentum: mu, attitude: g, .. } = point.state::<N, D>();
        // The size of its terms, and what it is moved by with its differential.
        let of = |value: T, size: T, differential: &[T]| {
            let reach = mu.amax() * differential.iter().fold(T::zero(), |sum, x| sum + x.abs());
            vec![Value { value, size, reach }]
        };
        Some(match quantity {
            Quantity::Energy => {
                let eta = self.velocity(point.time, &g, &mu)?;
                let size = mu.iter().zip(eta.iter()).fold(T::zero(), |sum, (m, e)| sum + (*m * *e).abs());
                // E as a function of μ has the differential η.
                of(self.system.lagrangian.energy_at(point.time, Configuration::of(&g), &eta), size, eta.as_slice())
            }
            Quantity::Casimir(k) => {
                let casimir = self.system.casimirs.get(k)?;
                of(casimir.value(&mu), casimir.size(mu.amax()), casimir.gradient(&mu).as_slice())
            }
            Quantity::Momentum => self.spatial(&mu, point)?,
        })
    }

    fn force(&self, stage: &Stage<T>) -> Vec<T> {
        let at = Point { time: stage.time, momentum: Vec::new(), attitude: stage.attitude.clone() }.state::<N, D>();
        let eta = Vector::<T, N>::from_fn(|a, _| stage.velocity.get(a).copied().unwrap_or_else(T::zero));
        let force = self.load(at.time, &at.attitude, &eta);
        force.iter().take(self.system.dimension).copied().collect()
    }

    fn solve(
        &self,
        start: &Point<T>,
        times: &[T],
        tolerance: f64,
        attitude: bool,
    ) -> Result<Vec<Solved<T>>, StepError> {
        let body = self.system.equations();
        let group = self.system.group.as_ref().filter(|_| attitude || self.is_placed());
        let targets = reference::within(&body, group, &self.state(start), times, STAGES, T::exact(tolerance))?;
        let solved = |target: &reference::Target<T, N, D>| {
            let ((point, stretch), error) = (self.reached(&target.state, start)?, target.reference_error);
            Ok((point, (error.0, error.1 * stretch)))
        };
        targets.iter().map(solved).collect()
    }

    fn pace(&self, point: &Point<T>) -> f64 {
        let Some((eta, pace)) = self.paces(point) else { return f64::INFINITY };
        let pace = match &self.system.group {
            Some(group) if self.system.size > 0 => {
                let hat: Matrix<T, D> = group.hat(&eta);
                pace.max(norm(&(hat * hat)).sqrt())
            }
            _ => pace,
        };
        if pace.is_finite() { pace } else { f64::INFINITY }
    }

    fn turn(&self, point: &Point<T>) -> f64 {
        let State { momentum, attitude, .. } = point.state::<N, D>();
        let Some(eta) = self.velocity(point.time, &attitude, &momentum) else { return f64::INFINITY };
        let term = |b: usize, c: usize, a: usize| (eta[a] * self.system.algebra.constant(a, b, c)).to_f64().abs();
        let row = |c: usize| (0..N).map(|b| (0..N).map(|a| term(b, c, a)).sum::<f64>()).sum::<f64>();
        (0..N).map(row).fold(0.0, |most: f64, x| if x.is_nan() { f64::INFINITY } else { most.max(x) })
    }

    fn brackets(&self, point: &Point<T>) -> Vec<T> {
        let (mu, n) = (point.state::<N, D>().momentum, self.system.dimension);
        let entry =
            |a: usize, b: usize| (0..n).fold(T::zero(), |sum, c| sum + self.system.algebra.constant(a, b, c) * mu[c]);
        (0..n * n).map(|k| entry(k / n, k % n)).collect()
    }

    fn element(&self) -> Option<Vec<T>> {
        self.element.and_then(|element| self.leading(element))
    }

    fn symmetry(&self) -> Option<Vec<T>> {
        let element = if self.is_placed() { self.element.and_then(|_| self.known_symmetry()) } else { self.element };
        element.and_then(|element| self.leading(element))
    }
}
