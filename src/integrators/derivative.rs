//! Derivatives of steps and runs of [`Variational`]: forward (tangent) and reverse (adjoint).
//!
//! The state is (g, μ); a variation of it is (ζ, δμ) ∈ g × g*, left-trivialised: δg = g ζ̂. The stages solve r(H; g, μ, t, h, p) = 0, so by
//! the implicit function theorem, with J = ∂r/∂H and the partial derivatives from dual numbers,
//!
//! > δH = −J⁻¹ (∂r/∂(g, μ, t, h, p) · δ),  ω = dτ_ξ δξ,  ζ' = Ad_{τ(ξ)}⁻¹ ζ + ω,  δμ' = δm Ad_{τ(ξ)} + ad*_ω μ'.
//!
//! The adjoint is the transpose of this. For both the matrix of a step is found by rows, by 2N solves with Jᵀ. Nothing is differenced: the error is that of the stages, a few u
//! times the condition number of J. Parameters p enter r and m linearly through ∂L/∂η and the forces: [`Parameters`].
//!
//! | | costs | memory |
//! |---|---|---|
//! | [`Linearised::step`] | a step, s (2N + 1) stages in dual numbers (s N more where something depends on g), 4/3 (sN)³ operations, 2N solves | J and its factors, 2(sN)² numbers, and 2N + 2 + K columns |
//! | [`StepDerivative::tangent`], [`adjoint`](StepDerivative::adjoint) | 2N (2N + 2 + K) products | – |
//! | [`Linearised::sensitivity`], n steps | n linearised steps | 2N (2N + 2 + K) |
//! | [`Linearised::gradient`], n steps | 2n steps and n linearisations | 2√n states and the H_i of √n steps |
//!
//! Sources: Hairer, Lubich and Wanner 2006, §VI.4 and §VI.9 (derivatives of a step); Griewank and Walther 2008, ch. 12 (checkpoints).

pub use super::parameters::Parameters;

use super::stages::Stages;
use super::trajectory::TrajectoryError;
use super::variational::partials::Partials;
use super::{OneStep, Report, State, StepError, Variational};
use crate::algebra::{Covector, Vector, basis_vector};
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

    fn all_finite(&self) -> bool {
        finite(self.attitude.as_slice()) && finite(self.momentum.as_slice())
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

    /// By component c of (ζ, δμ).
    fn unit(c: usize) -> Self {
        match c.checked_sub(N) {
            None => Self { attitude: basis_vector::<T, N>(c).transpose(), ..Self::zero() },
            Some(c) => Self { momentum: basis_vector(c), ..Self::zero() },
        }
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

/// The derivative of the end of a step or a run by everything that it starts from: columns, each a [`Variation`] of the end.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivative<T: Real, const N: usize> {
    /// Along ζ = e_a at the start.
    pub by_attitude: [Variation<T, N>; N],
    /// Along δμ = the a-th covector of the dual basis at the start.
    pub by_momentum: [Variation<T, N>; N],
    /// By t at the start.
    pub by_time: Variation<T, N>,
    /// By h, the number of steps fixed.
    pub by_step: Variation<T, N>,
    /// By p_1 … p_K.
    pub by_parameters: Vec<Variation<T, N>>,
}

impl<T: Real, const N: usize> Derivative<T, N> {
    fn identity(parameters: usize) -> Self {
        let zero = Variation::zero();
        Self {
            by_attitude: std::array::from_fn(|a| Variation { attitude: basis_vector(a), ..zero }),
            by_momentum: std::array::from_fn(|a| Variation { momentum: basis_vector::<T, N>(a).transpose(), ..zero }),
            by_time: zero,
            by_step: zero,
            by_parameters: vec![zero; parameters],
        }
    }

    /// ∂(ζ', δμ')/∂(ζ, δμ), 2N×2N.
    pub fn state_matrix(&self) -> DMatrix<T> {
        let column = |c: usize| if c < N { &self.by_attitude[c] } else { &self.by_momentum[c - N] };
        DMatrix::from_fn(2 * N, 2 * N, |r, c| if r < N { column(c).attitude[r] } else { column(c).momentum[r - N] })
    }

    /// Carries the columns over step number `index` of a run (from 0).
    fn advance(&mut self, step: &StepDerivative<T, N>, index: usize) {
        let (zero, one) = (T::zero(), T::one());
        for column in self.by_attitude.iter_mut().chain(&mut self.by_momentum) {
            *column = step.forward(column, zero, zero, |_| zero);
        }
        self.by_time = step.forward(&self.by_time, one, zero, |_| zero);
        // The step starts at t + index h.
        self.by_step = step.forward(&self.by_step, T::int(index as i64), one, |_| zero);
        for (k, column) in self.by_parameters.iter_mut().enumerate() {
            *column = step.forward(column, zero, zero, |l| if l == k { one } else { zero });
        }
    }

    fn all_finite(&self) -> bool {
        let columns = self.by_attitude.iter().chain(&self.by_momentum).chain(&self.by_parameters);
        columns.chain([&self.by_time, &self.by_step]).all(Variation::all_finite)
    }
}

/// The derivative of one step, ready to be applied.
#[derive(Clone, Debug)]
pub struct StepDerivative<T: Real, const N: usize> {
    partials: Partials<T, N>,
    factors: Factors<T>,
    /// ∂(ζ', δμ')/∂(ζ, δμ, t, h, p), 2N×(2N + 2 + K).
    matrix: DMatrix<T>,
    /// J⁻ᵀ ∂(ζ', δμ')/∂H, sN×2N: how the end changes with H where r is not 0.
    by_residual: DMatrix<T>,
    condition: T,
}

impl<T: Real, const N: usize> StepDerivative<T, N> {
    fn new(stages: usize, parameters: usize) -> Self {
        Self {
            partials: Partials::new(stages, parameters),
            factors: Factors::new(stages * N),
            matrix: DMatrix::zeros(2 * N, 2 * N + 2 + parameters),
            by_residual: DMatrix::zeros(stages * N, 2 * N),
            condition: T::zero(),
        }
    }

    /// From the partial derivatives: row by row, so that parameters cost no solves.
    fn complete(&mut self) {
        let Self { partials, factors, matrix, by_residual, condition } = self;
        *condition = factors.factor(&partials.stages);
        for (r, mut column) in by_residual.column_iter_mut().enumerate() {
            let stages = column.as_mut_slice();
            let unit = Gradient::unit(r);
            let increment = (unit.attitude + (partials.turned * unit.momentum).transpose()) * partials.tangent;
            let impulse = partials.adjoint * unit.momentum;
            let end = |by: &DMatrix<T>, c: usize| {
                (0..N).fold(T::zero(), |sum, a| sum + by[(a, c)] * increment[a] + by[(N + a, c)] * impulse[a])
            };
            for (c, value) in stages.iter_mut().enumerate() {
                *value = end(&partials.end_by_stages, c);
            }
            factors.solve_transposed(stages);
            let start = unit.attitude * partials.adjoint_inv;
            for c in 0..matrix.ncols() {
                let through =
                    stages.iter().zip(&partials.inputs.column(c)).fold(T::zero(), |sum, (&x, &y)| sum + x * y);
                let own = if c < N { start[c] } else { T::zero() };
                matrix[(r, c)] = own + end(&partials.end_by_inputs, c) - through;
            }
        }
    }

    /// Skeel's condition number of J = ∂r/∂H, of J with its columns scaled to size 1: it grows without bound towards a fold.
    pub fn condition(&self) -> T {
        self.condition
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
        let needed = self.partials.parameters();
        if parameters.len() != needed {
            return Err(StepError::Parameters { found: parameters.len(), needed });
        }
        let end = self.forward(state, time, step, |k| parameters[k]);
        if end.all_finite() { Ok(end) } else { Err(StepError::NotFinite { what: "the variation" }) }
    }

    /// The gradient by the start, t, h and the parameters of a function of the end that has this gradient: the transpose of
    /// [`tangent`](Self::tangent).
    ///
    /// # Errors
    /// [`StepError::NotFinite`].
    pub fn adjoint(&self, end: &Gradient<T, N>) -> Result<InputGradient<T, N>, StepError> {
        let mut all = InputGradient::of(*end, self.partials.parameters());
        self.backward(0, &mut all);
        all.checked()
    }

    /// All columns.
    ///
    /// # Errors
    /// [`StepError::NotFinite`].
    pub fn matrices(&self) -> Result<Derivative<T, N>, StepError> {
        let mut all = Derivative::identity(self.partials.parameters());
        all.advance(self, 0);
        if all.all_finite() { Ok(all) } else { Err(NOT_FINITE) }
    }

    /// How far the end may move where r_k is not 0 but up to `left(Σ_l |J_kl H_l|)`: Σ_k |∂(ζ', δμ')/∂H J⁻¹ e_k| `left`(…), component by
    /// component. `rates` are the H_i, one after the other.
    #[cfg(feature = "harness")]
    pub(crate) fn moved(&self, rates: &[T], left: impl Fn(T) -> T) -> Variation<T, N> {
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

    fn forward(&self, state: &Variation<T, N>, time: T, step: T, parameter: impl Fn(usize) -> T) -> Variation<T, N> {
        let mut end = Variation::zero();
        for (c, column) in self.matrix.column_iter().enumerate() {
            let value = match c {
                c if c < N => state.attitude[c],
                c if c < 2 * N => state.momentum[c - N],
                c if c == 2 * N => time,
                c if c == 2 * N + 1 => step,
                c => parameter(c - 2 * N - 2),
            };
            for a in 0..N {
                end.attitude[a] += column[a] * value;
                end.momentum[a] += column[N + a] * value;
            }
        }
        end
    }

    /// `all.state` is the gradient at the end of step number `index` of a run, and becomes that at its start; the others are added to.
    fn backward(&self, index: usize, all: &mut InputGradient<T, N>) {
        let Gradient { attitude, momentum } = all.state;
        let input = |c: usize| {
            let column = self.matrix.column(c);
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
/// use euler_poincare::integrators::derivative::{
///     Derivative, Gradient, InputGradient, Linearised, Parameters, StepDerivative, Variation,
/// };
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
/// let step: &mut StepDerivative<f64, 3> = method.step(&mut state, 0.1)?.1;
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
/// let forward = whole.by_parameters[0].momentum.dot(&state.momentum);
/// assert!((gradient.parameters[0] - forward).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Linearised<T: Real, const N: usize, const D: usize, L, F, R, P> {
    method: Variational<T, N, D, L, F, R>,
    parameters: P,
    derivative: StepDerivative<T, N>,
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
        let derivative = StepDerivative::new(method.tableau().stages(), parameters.count());
        Self { method, parameters, derivative }
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
    pub fn step(
        &mut self,
        state: &mut State<T, N, D>,
        h: T,
    ) -> Result<(Report<T>, &mut StepDerivative<T, N>), StepError> {
        let start = state.clone();
        let report = self.method.step(state, h)?;
        if let Err(error) = self.linearise(&start, h, None) {
            *state = start;
            return Err(error);
        }
        Ok((report, &mut self.derivative))
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
        let mut moved = self.derivative.moved(&rates, |terms| terms + size);
        for (moved, column) in moved.momentum.iter_mut().zip(self.derivative.partials.adjoint.column_iter()) {
            *moved += column.iter().fold(T::zero(), |sum, x| sum + x.abs()) * size;
        }
        Ok(moved)
    }

    fn linearise(&mut self, start: &State<T, N, D>, h: T, rates: Option<&Stages<T, N>>) -> Result<(), StepError> {
        let Self { method, parameters, derivative } = self;
        if derivative.partials.parameters() != parameters.count() {
            *derivative = StepDerivative::new(method.tableau().stages(), parameters.count());
        }
        let partials = &mut derivative.partials;
        method.partials(start, h, rates, parameters, partials)?;
        if !partials.all_finite() {
            return Err(NOT_FINITE);
        }
        derivative.complete();
        // The stages are known to the condition number times u, and J⁻¹ changes by as much again.
        let limit = T::one() / T::unit_roundoff().sqrt();
        if derivative.condition < limit {
            return Ok(());
        }
        Err(StepError::SingularJacobian { step: h.to_f64(), condition: derivative.condition.to_f64() })
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
    /// and stages, and applies their adjoints in reverse: 2n steps, n linearisations, and memory for about 2√n states, whatever the
    /// number of parameters.
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
        let mut states = Vec::with_capacity(every + 1);
        let mut rates = vec![self.method.room_for_rates(); every];
        let mut all = InputGradient::of(Gradient::zero(), self.parameters.count());
        for (segment, checkpoint) in checkpoints.iter().enumerate().rev() {
            let first = segment * every;
            let end = steps.min(first + every);
            state.clone_from(checkpoint);
            states.clear();
            for index in first..end {
                states.push(state.clone());
                self.again(&mut state, start.time, h, index, every)?;
                self.method.save_rates(&mut rates[index - first]);
            }
            if end == steps {
                all.state = terms(steps, &state);
            }
            for index in (first..end).rev() {
                let before = &states[index - first];
                let failed = |source| TrajectoryError { index, time: before.time.to_f64(), source };
                self.linearise(before, h, Some(&rates[index - first])).map_err(failed)?;
                self.derivative.backward(index, &mut all);
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
