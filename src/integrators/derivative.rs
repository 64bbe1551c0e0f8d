//! Derivatives of steps and runs of [`Variational`]: forward (tangent) and reverse (adjoint).
//!
//! The state is (g, μ); a variation of it is (ζ, δμ) ∈ g × g*, left-trivialised: δg = g ζ̂. The stages solve r(H; g, μ, t, h, p) = 0, so by
//! the implicit function theorem, with J = ∂r/∂H and the partial derivatives from dual numbers,
//!
//! > δH = −J⁻¹ (∂r/∂(g, μ, t, h, p) · δ),  ω = dτ_ξ δξ,  ζ' = Ad_{τ(ξ)}⁻¹ ζ + ω,  δμ' = δm Ad_{τ(ξ)} + ad*_ω μ'.
//!
//! The adjoint is the transpose of this. For both the matrix of a step is found by rows, by 2N solves with Jᵀ. Nothing is
//! differenced: the error is that of the stages, a few u times the condition number of J. Parameters p enter r and m linearly
//! through ∂L/∂η and the forces: [`Parameters`].
//!
//! | | costs | memory |
//! |---|---|---|
//! | [`Linearised::step`] | a step, s (2N + 1) stages in dual numbers (s N more where something depends on g), 4/3 (sN)³ operations, 2N solves, 2N (2N + 2 + K) sN products | J and its factors, 2(sN)² numbers, and 2N + 2 + K columns of sN + 4N |
//! | [`Derivative::tangent`], [`adjoint`](Derivative::adjoint) | 2N (2N + 2 + K) products | – |
//! | [`Linearised::sensitivity`], n steps | n linearised steps, 4N² (2N + 2 + K) n products | 2N (2N + 2 + K) |
//! | [`Linearised::gradient`], n steps | 2n steps, n linearisations, 2N (2N + 2 + K) n products | 2√n states and the H_i of √n steps |
//!
//! Sources: Hairer, Lubich and Wanner 2006, §VI.4 and §VI.9 (derivatives of a step); Griewank and Walther 2008, ch. 12 (checkpoints).

pub use super::parameters::Parameters;

use super::stages::Stages;
use super::trajectory::TrajectoryError;
use super::variational::partials::Partials;
use super::{OneStep, Report, State, StepError, Variational};
use crate::algebra::{Covector, Vector};
use crate::mechanics::{Force, Lagrangian};
use crate::newton::Factors;
use crate::retraction::Retraction;
use crate::scalar::{Real, finite};
use nalgebra::DMatrix;

/// A variation of a state, left-trivialised.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Variation<T: Real, const N: usize> {
    /// ζ, where δg = g ζ̂.
    pub attitude: Vector<T, N>,
    /// δμ.
    pub momentum: Covector<T, N>,
}

impl<T: Real, const N: usize> Variation<T, N> {
    /// 0.
    pub fn zero() -> Self {
        Self { attitude: Vector::zeros(), momentum: Covector::zeros() }
    }

    fn add(&mut self, other: &Self, factor: T) {
        self.attitude += other.attitude * factor;
        self.momentum += other.momentum * factor;
    }
}

/// The derivative of a function of the state: it pairs with a [`Variation`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gradient<T: Real, const N: usize> {
    /// The derivative along ζ, a covector.
    pub attitude: Covector<T, N>,
    /// The derivative along δμ, a vector.
    pub momentum: Vector<T, N>,
}

impl<T: Real, const N: usize> Gradient<T, N> {
    /// 0.
    pub fn zero() -> Self {
        Self { attitude: Covector::zeros(), momentum: Vector::zeros() }
    }

    /// The derivative along a variation.
    pub fn along(&self, variation: &Variation<T, N>) -> T {
        crate::algebra::pair(&self.attitude, &variation.attitude)
            + crate::algebra::pair(&variation.momentum, &self.momentum)
    }
}

/// The derivative of a function of the end, or of all states, by everything that a step or a run starts from.
#[derive(Clone, Debug, PartialEq)]
pub struct InputGradient<T: Real, const N: usize> {
    /// By (g, μ) at the start.
    pub state: Gradient<T, N>,
    /// By t at the start.
    pub time: T,
    /// By h, the number of steps fixed.
    pub step: T,
    /// By p_1 … p_K.
    pub parameters: Vec<T>,
}

/// The derivative of the end of a step or a run by everything that it starts from: a matrix with the rows (ζ', δμ') and the columns
/// (ζ, δμ, t, h, p_1 … p_K), that of h with the number of steps fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivative<T: Real, const N: usize>(DMatrix<T>);

impl<T: Real, const N: usize> Derivative<T, N> {
    fn identity(parameters: usize) -> Self {
        Self(DMatrix::identity(2 * N, 2 * N + 2 + parameters))
    }

    /// The matrix, 2N×(2N + 2 + K).
    pub fn matrix(&self) -> &DMatrix<T> {
        &self.0
    }

    /// Along p_1 … p_K.
    pub fn by_parameters(&self) -> impl Iterator<Item = Variation<T, N>> + '_ {
        (2 * N + 2..self.0.ncols()).map(|c| self.column(c))
    }

    fn column(&self, c: usize) -> Variation<T, N> {
        let column = self.0.column(c);
        Variation { attitude: Vector::from_fn(|a, _| column[a]), momentum: Covector::from_fn(|_, a| column[N + a]) }
    }

    fn parameters(&self) -> usize {
        self.0.ncols() - 2 * N - 2
    }

    /// (ζ', δμ') of a variation of the start, of t, of h and of the parameters.
    ///
    /// # Errors
    /// [`StepError::Parameters`] where their number is not K; [`StepError::NotFinite`].
    pub fn tangent(
        &self,
        state: &Variation<T, N>,
        time: T,
        step: T,
        parameters: &[T],
    ) -> Result<Variation<T, N>, StepError> {
        let needed = self.parameters();
        if parameters.len() != needed {
            return Err(StepError::Parameters { found: parameters.len(), needed });
        }
        let mut end = self.along(state);
        for (k, &value) in [time, step].iter().chain(parameters).enumerate() {
            end.add(&self.column(2 * N + k), value);
        }
        let finite = finite(end.attitude.as_slice()) && finite(end.momentum.as_slice());
        if finite { Ok(end) } else { Err(StepError::NotFinite { what: "the variation" }) }
    }

    /// Along a variation of the state at the start.
    fn along(&self, state: &Variation<T, N>) -> Variation<T, N> {
        let mut end = Variation::zero();
        for a in 0..N {
            end.add(&self.column(a), state.attitude[a]);
            end.add(&self.column(N + a), state.momentum[a]);
        }
        end
    }

    /// The gradient by the start, t, h and the parameters of a function of the end that has this gradient: the transpose of
    /// [`tangent`](Self::tangent).
    ///
    /// # Errors
    /// [`StepError::NotFinite`].
    pub fn adjoint(&self, end: &Gradient<T, N>) -> Result<InputGradient<T, N>, StepError> {
        let mut all = InputGradient::of(*end, self.parameters());
        self.backward(0, &mut all);
        all.checked()
    }

    /// Goes on by step number `index` of a run (from 0), which starts at t + index h.
    fn advance(&mut self, step: &Self, index: usize) {
        for c in 0..self.0.ncols() {
            let mut end = step.along(&self.column(c));
            if c >= 2 * N {
                end.add(&step.column(c), T::one());
            }
            if c == 2 * N + 1 {
                end.add(&step.column(2 * N), T::int(index as i64));
            }
            let entries = end.attitude.iter().chain(end.momentum.iter());
            self.0.column_mut(c).iter_mut().zip(entries).for_each(|(entry, value)| *entry = *value);
        }
    }

    /// `all.state` is the gradient at the end of step number `index` of a run, and becomes that at its start; the others are added to.
    fn backward(&self, index: usize, all: &mut InputGradient<T, N>) {
        let Gradient { attitude, momentum } = all.state;
        let input = |c: usize| {
            let column = self.0.column(c);
            (0..N).fold(T::zero(), |sum, a| sum + column[a] * attitude[a] + column[N + a] * momentum[a])
        };
        all.state =
            Gradient { attitude: Covector::from_fn(|_, a| input(a)), momentum: Vector::from_fn(|a, _| input(N + a)) };
        let time = input(2 * N);
        all.time += time;
        all.step += input(2 * N + 1) + time * T::int(index as i64);
        for (k, value) in all.parameters.iter_mut().enumerate() {
            *value += input(2 * N + 2 + k);
        }
    }

    fn all_finite(&self) -> bool {
        finite(self.0.as_slice())
    }
}

/// What the derivative of a step is made of.
#[derive(Clone, Debug)]
struct Work<T: Real, const N: usize> {
    partials: Partials<T, N>,
    factors: Factors<T>,
    derivative: Derivative<T, N>,
    /// J⁻ᵀ ∂(ζ', δμ')/∂H, sN×2N: how the end changes with H where r is not 0.
    by_residual: DMatrix<T>,
    condition: T,
}

impl<T: Real, const N: usize> Work<T, N> {
    fn new(stages: usize, parameters: usize) -> Self {
        Self {
            partials: Partials::new(stages, parameters),
            factors: Factors::new(stages * N),
            derivative: Derivative::identity(parameters),
            by_residual: DMatrix::zeros(stages * N, 2 * N),
            condition: T::zero(),
        }
    }

    /// From the partial derivatives: row by row, so that parameters cost no solves.
    fn complete(&mut self) {
        let Self { partials, factors, derivative: Derivative(matrix), by_residual, condition } = self;
        *condition = factors.factor(&partials.stages);
        for (r, mut column) in by_residual.column_iter_mut().enumerate() {
            let stages = column.as_mut_slice();
            stages.iter_mut().enumerate().for_each(|(c, value)| *value = partials.end_by_stages[(r, c)]);
            factors.solve_transposed(stages);
            for c in 0..matrix.ncols() {
                let through =
                    stages.iter().zip(&partials.inputs.column(c)).fold(T::zero(), |sum, (&x, &y)| sum + x * y);
                matrix[(r, c)] = partials.end_by_inputs[(r, c)] - through;
            }
        }
    }

    /// How far the end may move where r_k is not 0 but up to `left(Σ_l |J_kl H_l|)`: Σ_k |∂(ζ', δμ')/∂H J⁻¹ e_k| `left`(…), component by
    /// component. `rates` are the H_i, one after the other.
    #[cfg(feature = "harness")]
    fn moved(&self, rates: &[T], left: impl Fn(T) -> T) -> Variation<T, N> {
        let mut all = Variation::zero();
        for (k, row) in self.partials.stages.row_iter().enumerate() {
            let left = left(row.iter().zip(rates).fold(T::zero(), |sum, (&j, &rate)| sum + (j * rate).abs()));
            for a in 0..N {
                all.attitude[a] += self.by_residual[(k, a)].abs() * left;
                all.momentum[a] += self.by_residual[(k, N + a)].abs() * left;
            }
        }
        all
    }
}

const NOT_FINITE: StepError = StepError::NotFinite { what: "the derivative of the step" };

impl<T: Real, const N: usize> InputGradient<T, N> {
    /// By the state alone.
    pub(crate) fn of(state: Gradient<T, N>, parameters: usize) -> Self {
        Self { state, time: T::zero(), step: T::zero(), parameters: vec![T::zero(); parameters] }
    }

    fn checked(self) -> Result<Self, StepError> {
        let state = finite(self.state.attitude.as_slice()) && finite(self.state.momentum.as_slice());
        let rest = finite(&[self.time, self.step]) && finite(&self.parameters);
        if state && rest { Ok(self) } else { Err(NOT_FINITE) }
    }
}

/// A [`Variational`] method with the derivatives of its steps, and the workspace for them.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix, Vector};
/// use euler_poincare::integrators::derivative::{Derivative, Gradient, InputGradient, Linearised, Parameters, Variation};
/// use euler_poincare::integrators::{State, Variational};
/// use euler_poincare::mechanics::configuration::Configuration;
/// use euler_poincare::mechanics::{force::LinearDrag, lagrangian::Quadratic};
/// use euler_poincare::retraction::CayleySo3;
/// use euler_poincare::tableau::Family;
///
/// /// The coefficient p of the drag f = −p η.
/// struct Coefficient;
///
/// impl Parameters<f64, 3> for Coefficient {
///     fn count(&self) -> usize {
///         1
///     }
///
///     fn force(&self, _: usize, _: f64, _: Configuration<'_, f64>, eta: &Vector<f64, 3>) -> Covector<f64, 3> {
///         -eta.transpose()
///     }
/// }
///
/// let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
/// let run = |p: f64| {
///     let drag = LinearDrag::new(Matrix::<f64, 3>::from_diagonal_element(p)).expect("finite");
///     let gauss = Family::Gauss.tableau::<f64>(2).expect("a tableau");
///     Linearised::new(Variational::new(body.clone(), drag, CayleySo3::new(), gauss), Coefficient)
/// };
/// let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(0.4, 0.1, 0.7), attitude: Matrix::<f64, 3>::identity() };
///
/// // One step: a tangent, and the transpose.
/// let (mut method, mut state) = (run(0.1), start.clone());
/// let step: &Derivative<f64, 3> = method.step(&mut state, 0.1)?.1;
/// let turned = Variation { attitude: Vector::<f64, 3>::new(1.0, 0.0, 0.0), momentum: Covector::zeros() };
/// let end = step.tangent(&turned, 0.0, 0.0, &[0.0])?;
/// let third = Gradient { attitude: Covector::<f64, 3>::new(0.0, 0.0, 1.0), momentum: Vector::zeros() };
/// assert!((step.adjoint(&third)?.state.along(&turned) - third.along(&end)).abs() < 1e-15);
///
/// // Fifty steps, forward: how the end depends on everything.
/// let mut state = start.clone();
/// let whole: Derivative<f64, 3> = method.sensitivity(&mut state, 0.1, 50, |_, _, _| {})?;
///
/// // Reverse: the gradient of |μ|²/2 at the end.
/// let of_end = |n, state: &State<f64, 3, 3>| match n {
///     50 => Gradient { momentum: state.momentum.transpose(), ..Gradient::zero() },
///     _ => Gradient::zero(),
/// };
/// let gradient: InputGradient<f64, 3> = method.gradient(&start, 0.1, 50, of_end)?;
/// let forward: f64 = whole.by_parameters().map(|along| along.momentum.dot(&state.momentum)).sum();
/// assert!((gradient.parameters[0] - forward).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Linearised<T: Real, const N: usize, const D: usize, L, F, R, P> {
    method: Variational<T, N, D, L, F, R>,
    parameters: P,
    work: Work<T, N>,
}

impl<T, const N: usize, const D: usize, L, F, R, P> Linearised<T, N, D, L, F, R, P>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
    P: Parameters<T, N>,
{
    /// The method, with parameters or `()`.
    pub fn new(method: Variational<T, N, D, L, F, R>, parameters: P) -> Self {
        let work = Work::new(method.tableau().stages(), parameters.count());
        Self { method, parameters, work }
    }

    /// The method.
    pub fn method(&self) -> &Variational<T, N, D, L, F, R> {
        &self.method
    }

    /// The method, to be changed between steps.
    pub fn method_mut(&mut self) -> &mut Variational<T, N, D, L, F, R> {
        &mut self.method
    }

    /// The parameters, to be changed between steps.
    pub fn parameters_mut(&mut self) -> &mut P {
        &mut self.parameters
    }

    /// Takes a step, as [`OneStep::step`] of the method does, and returns its report and its derivative. Nothing is allocated while
    /// the number of parameters stays as it is.
    ///
    /// # Errors
    /// Those of the step; [`StepError::SingularJacobian`] where the condition number of J exceeds 1/√u, so that the derivative would
    /// have no digits; a derivative that is not finite. `state` is then unchanged.
    pub fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<(Report<T>, &Derivative<T, N>), StepError> {
        let start = state.clone();
        let report = self.method.step(state, h)?;
        if let Err(error) = self.linearise(&start, h, None) {
            *state = start;
            return Err(error);
        }
        Ok((report, &self.work.derivative))
    }

    /// Skeel's condition number of J = ∂r/∂H of the last step, of J with its columns scaled to size 1: it grows without bound towards a fold.
    pub fn condition(&self) -> T {
        self.work.condition
    }

    /// Takes a step, and returns how far its end moves, at most and to first order, where each stage equation r_k = 0 holds up to its terms:
    /// the largest of them, and Σ_l |∂r_k/∂H_l H_l|; and m up to the largest. A part of that, such as a few u or a tolerance, is what
    /// solving the equations leaves.
    ///
    /// # Errors
    /// Those of [`Linearised::step`].
    #[cfg(feature = "harness")]
    pub(crate) fn moved(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Variation<T, N>, StepError> {
        let start = state.clone();
        self.step(state, h)?;
        let rates: Vec<T> = self.method.stage_rates().flat_map(|(rate, _)| rate.data.0[0]).collect();
        let size = self.method.terms(&start, h)?;
        let mut moved = self.work.moved(&rates, |terms| terms + size);
        for (moved, column) in moved.momentum.iter_mut().zip(self.work.partials.adjoint.column_iter()) {
            *moved += column.iter().fold(T::zero(), |sum, x| sum + x.abs()) * size;
        }
        Ok(moved)
    }

    fn linearise(&mut self, start: &State<T, N, D>, h: T, rates: Option<&Stages<T, N>>) -> Result<(), StepError> {
        let Self { method, parameters, work } = self;
        if work.partials.parameters() != parameters.count() {
            *work = Work::new(method.tableau().stages(), parameters.count());
        }
        method.partials(start, h, rates, parameters, &mut work.partials)?;
        if !work.partials.all_finite() {
            return Err(NOT_FINITE);
        }
        work.complete();
        // The stages are known to the condition number times u, and J⁻¹ changes by as much again.
        let limit = T::one() / T::unit_roundoff().sqrt();
        if work.condition >= limit || work.condition.to_f64().is_nan() {
            return Err(StepError::SingularJacobian { step: h.to_f64(), condition: work.condition.to_f64() });
        }
        if work.derivative.all_finite() { Ok(()) } else { Err(NOT_FINITE) }
    }

    /// Takes `steps` steps of size `h` and carries the derivative by the start, t, h and the parameters along; after each, `observe`
    /// sees the index of the step (from 1), the state and the derivative up to there. Step k starts at t₀ + k h.
    ///
    /// # Errors
    /// The first failing step, with its index and time; `state` is then the last one that was reached.
    pub fn sensitivity(
        &mut self,
        state: &mut State<T, N, D>,
        h: T,
        steps: usize,
        mut observe: impl FnMut(usize, &State<T, N, D>, &Derivative<T, N>),
    ) -> Result<Derivative<T, N>, TrajectoryError> {
        let start = state.time;
        let mut derivative = Derivative::identity(self.parameters.count());
        for index in 0..steps {
            let before = state.clone();
            let taken = self.step(state, h).map(|(_, step)| derivative.advance(step, index));
            let taken = taken.and_then(|()| if derivative.all_finite() { Ok(()) } else { Err(NOT_FINITE) });
            if let Err(source) = taken {
                *state = before;
                return Err(TrajectoryError { index, time: state.time.to_f64(), source });
            }
            state.time = start + T::int(index as i64 + 1) * h;
            observe(index + 1, state, &derivative);
        }
        Ok(derivative)
    }

    /// The gradient of φ = Σ_n φ_n(g_n, μ_n) over a run of `steps` steps of size `h`, by the start, t, h and the parameters. `terms` is
    /// asked for the gradient of φ_n at state n, once for each n from `steps` down to 0.
    ///
    /// A forward pass keeps every √n-th state. The backward pass takes the steps from one to the next again, keeps their states
    /// and stages, and applies their adjoints in reverse: 2n steps, n linearisations, and memory for about 2√n states, as many for any
    /// number of parameters. A parameter is a column of each linearisation.
    ///
    /// # Errors
    /// The first failing step, with its index and time.
    pub fn gradient(
        &mut self,
        start: &State<T, N, D>,
        h: T,
        steps: usize,
        mut terms: impl FnMut(usize, &State<T, N, D>) -> Gradient<T, N>,
    ) -> Result<InputGradient<T, N>, TrajectoryError> {
        let every = steps.isqrt().max(1);
        let mut checkpoints = vec![start.clone()];
        let mut state = start.clone();
        let last = steps.saturating_sub(1) / every;
        for index in 0..last * every {
            self.again(&mut state, start.time, h, index, every)?;
            if (index + 1).is_multiple_of(every) {
                checkpoints.push(state.clone());
            }
        }
        let (mut states, mut rates) = (Vec::with_capacity(every), Vec::with_capacity(every));
        let mut all = InputGradient::of(Gradient::zero(), self.parameters.count());
        for (segment, checkpoint) in checkpoints.iter().enumerate().rev() {
            let first = segment * every;
            let end = steps.min(first + every);
            state.clone_from(checkpoint);
            states.clear();
            rates.clear();
            for index in first..end {
                states.push(state.clone());
                self.again(&mut state, start.time, h, index, every)?;
                rates.push(self.method.rates().clone());
            }
            if end == steps {
                all.state = terms(steps, &state);
            }
            for index in (first..end).rev() {
                let before = &states[index - first];
                let failed = |source| TrajectoryError { index, time: before.time.to_f64(), source };
                self.linearise(before, h, Some(&rates[index - first])).map_err(failed)?;
                self.work.derivative.backward(index, &mut all);
                let own = terms(index, before);
                all.state.attitude += own.attitude;
                all.state.momentum += own.momentum;
                if !finite(all.state.attitude.as_slice()) || !finite(all.state.momentum.as_slice()) {
                    return Err(failed(NOT_FINITE));
                }
            }
        }
        all.checked().map_err(|source| TrajectoryError { index: 0, time: start.time.to_f64(), source })
    }

    /// Step number `index` of a run, which is the same in both passes: at checkpoints it does not look back.
    fn again(
        &mut self,
        state: &mut State<T, N, D>,
        start: T,
        h: T,
        index: usize,
        every: usize,
    ) -> Result<(), TrajectoryError> {
        if index.is_multiple_of(every) {
            self.method.forget();
        }
        let time = state.time.to_f64();
        self.method.step(state, h).map_err(|source| TrajectoryError { index, time, source })?;
        state.time = start + T::int(index as i64 + 1) * h;
        Ok(())
    }
}
