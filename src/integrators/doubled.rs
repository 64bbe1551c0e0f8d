//! The doubled variational scheme on g*×G×g*, on the units and off them.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/integrators/doubled.md"))]

use super::state::all_finite;
use super::variational::turn;
use super::{Report, Solver, StepError};
use crate::algebra::{Covector, Matrix, Vector};
use crate::mechanics::doubled::{DoubledLagrangian, MomentumPoint, VelocityError, VelocityPoint};
use crate::newton::{Equations, Newton, NewtonSettings, Outcome, is_at_hand};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Dual, Real, Scalar, finite, larger};
use crate::tableau::Tableau;
use nalgebra::DMatrix;

/// Newton steps per solve; quadratic convergence needs five or six.
const MAX_ITERATIONS: usize = 40;

/// A state of the doubled system.
#[derive(Clone, Debug, PartialEq)]
pub struct DoubledState<T: Real, const N: usize, const D: usize> {
    /// t.
    pub time: T,
    /// λ = −∂l/∂η ∈ g*.
    pub lambda: Covector<T, N>,
    /// U = g⁻¹g̃.
    pub relative: Matrix<T, D>,
    /// μ = ∂l/∂ψ ∈ g*.
    pub mu: Covector<T, N>,
    /// (g, g̃), carried along if given.
    pub attitudes: Option<(Matrix<T, D>, Matrix<T, D>)>,
}

impl<T: Real, const N: usize, const D: usize> DoubledState<T, N, D> {
    /// The unit (μ, e, μ) at time t, without attitudes.
    pub fn unit(time: T, mu: Covector<T, N>) -> Self {
        Self { time, lambda: mu, relative: Matrix::identity(), mu, attitudes: None }
    }

    fn check_finite(&self, h: T) -> Result<(), StepError> {
        let mut attitudes =
            std::iter::once(&self.relative).chain(self.attitudes.iter().flat_map(|(g, partner)| [g, partner]));
        all_finite([
            ("h", h.all_finite()),
            ("the time", self.time.all_finite()),
            ("the momentum", self.lambda.iter().chain(self.mu.iter()).all(|v| v.all_finite())),
            ("the attitude", attitudes.all(|matrix| finite(matrix.as_slice()))),
        ])
    }
}

/// One copy's stage values in a scalar S: unknown velocities, momenta and forces.
struct Copy<S: Scalar, const N: usize> {
    /// H_i (or Ψ_i).
    unknown: Vec<Vector<S, N>>,
    /// Π_i (or P_i).
    momentum: Vec<Covector<S, N>>,
    /// Π_i ddτ(Ξ_i; H_i) + N_i.
    slope: Vec<Covector<S, N>>,
    /// m = λ + h Σ b_j (trivialised ∂l/∂U) Ad_{τ(Ξ_j)}⁻¹.
    carried: Covector<S, N>,
    /// ξ = h Σ b_j H_j.
    increment: Vector<S, N>,
}

impl<S: Scalar, const N: usize> Copy<S, N> {
    fn new(stages: usize) -> Self {
        Self {
            unknown: vec![Vector::zeros(); stages],
            momentum: vec![Covector::zeros(); stages],
            slope: vec![Covector::zeros(); stages],
            carried: Covector::zeros(),
            increment: Vector::zeros(),
        }
    }

    /// h Σ_j w_j H_j.
    fn combine<T: Real>(&self, h: S, weight: impl Fn(usize) -> T) -> Vector<S, N>
    where
        S: Scalar<Base = T>,
    {
        let mut sum = Vector::zeros();
        for (j, unknown) in self.unknown.iter().enumerate() {
            sum += unknown * S::lift(weight(j));
        }
        sum * h
    }
}

/// Both copies' stage values, and the residual: first copy's stages, then the second's.
struct Stages<S: Scalar, const N: usize> {
    first: Copy<S, N>,
    second: Copy<S, N>,
    residual: Vec<S>,
}

impl<S: Scalar, const N: usize> Stages<S, N> {
    fn new(stages: usize) -> Self {
        Self { first: Copy::new(stages), second: Copy::new(stages), residual: vec![S::zero(); 2 * stages * N] }
    }

    /// Unknowns from their list: the first copy's stages, then the second's.
    fn set_unknowns<T: Real>(&mut self, x: &[T], embed: impl Fn(T, usize) -> S) {
        let stages = self.first.unknown.iter_mut().chain(&mut self.second.unknown);
        for (k, value) in stages.flat_map(|v| v.iter_mut()).enumerate() {
            *value = embed(x[k], k);
        }
    }
}

/// The stage that left the domain of a retraction (none: the increment), and why.
type OutOfDomain = (Option<usize>, RetractionError);

fn left<T: Real>(h: T, (stage, source): OutOfDomain) -> StepError {
    StepError::Domain { step: h.to_f64(), stage, source }
}

/// The stage equations of one step, as [`Newton`] sees them.
struct StageEquations<T, L, R, const N: usize, const D: usize>
where
    T: Real,
{
    lagrangian: L,
    retraction: R,
    tableau: Tableau<T>,
    /// Where the step starts.
    start: DoubledState<T, N, D>,
    /// The step wanted, and the one of the moment (a fraction of it).
    wanted: T,
    h: T,
    values: Stages<T, N>,
    /// Unknowns and a residual, for differences.
    work: [Vec<T>; 2],
}

impl<T, L, R, const N: usize, const D: usize> Equations<T> for StageEquations<T, L, R, N, D>
where
    T: Real,
    L: DoubledLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    type Error = OutOfDomain;

    fn dimension(&self) -> usize {
        2 * self.tableau.stages() * N
    }

    fn set_fraction(&mut self, fraction: T) {
        self.h = self.wanted * fraction;
    }

    fn residual(&mut self, x: &[T], out: &mut [T]) -> Result<T, OutOfDomain> {
        self.evaluate(x)?;
        out.copy_from_slice(&self.values.residual);
        let momenta = self.values.first.momentum.iter().chain(&self.values.second.momentum);
        let entries = momenta.chain([&self.start.lambda, &self.start.mu]).flat_map(|p| p.iter());
        Ok(entries.fold(T::zero(), |scale, v| scale.max(v.abs())))
    }

    /// A column for each unknown, by forward differences: it decides how fast Newton's method is, not where it ends, and dual numbers
    /// cost several times as much. At h = 0 the second derivatives of **l**, stage by stage.
    fn jacobian(&mut self, x: &[T], out: &mut DMatrix<T>) -> Result<(), OutOfDomain> {
        if self.h == T::zero() {
            return self.jacobian_at_zero(x, out);
        }
        let Self { lagrangian, retraction, tableau, start, h, values, work: [moved, here], .. } = self;
        let evaluate = |x: &[T], values: &mut Stages<T, N>| {
            values.set_unknowns(x, |v, _| v);
            residual(&*lagrangian, &*retraction, tableau, start, *h, values)
        };
        evaluate(x, values)?;
        here.copy_from_slice(&values.residual);
        moved.copy_from_slice(x);
        let size = x.iter().fold(T::zero(), |size, v| size.max(v.abs()));
        let step = T::unit_roundoff().sqrt() * if size > T::zero() { size } else { T::one() };
        for column in 0..x.len() {
            moved[column] = x[column] + step;
            evaluate(moved, values)?;
            moved[column] = x[column];
            for (row, (there, here)) in values.residual.iter().zip(here.iter()).enumerate() {
                out[(row, column)] = (*there - *here) / step;
            }
        }
        Ok(())
    }

    /// The larger of the two copies' distances, as of the scheme on the units.
    fn distance(&self, from: (T, &[T]), to: (T, &[T])) -> Option<T> {
        let half = self.dimension() / 2;
        let turned = |first: usize| {
            let moved = |j: usize, a: usize| {
                let k = first + j * N + a;
                (to.0 * to.1[k] - from.0 * from.1[k]) * self.wanted
            };
            turn::<T, N>(&self.tableau, self.retraction.algebra(), moved)
        };
        Some(larger(turned(0), turned(half)))
    }
}

/// The doubled scheme with a tableau, a retraction and a doubled Lagrangian.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::doubled::{Doubled, DoubledState};
/// use euler_poincare::mechanics::{doubled::Forced, force::LinearDrag, lagrangian::Quadratic};
/// use euler_poincare::retraction::CayleySo3;
/// use euler_poincare::tableau::Family;
///
/// let drag = LinearDrag::new(Matrix::<f64, 3>::from_diagonal_element(0.1))?;
/// let system = Forced::new(Quadratic::diagonal([1.0, 2.0, 3.0])?, drag, CayleySo3::new());
/// let mut method = Doubled::new(Family::Gauss.tableau(2)?, CayleySo3::new(), system);
/// let mut state = DoubledState::<f64, 3, 3>::unit(0.0, Covector::<f64, 3>::new(0.4, 0.1, 0.7));
/// method.step(&mut state, 0.1)?;
/// // What starts on the units stays there: both copies move alike.
/// assert!((state.relative - Matrix::<f64, 3>::identity()).amax() < 1e-13);
/// assert!((state.lambda - state.mu).amax() < 1e-13 || (state.lambda + state.mu).amax() < 1e-13);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Doubled<T, L, R, const N: usize, const D: usize>
where
    T: Real,
{
    equations: StageEquations<T, L, R, N, D>,
    newton: Newton<T>,
    origin: Vec<T>,
    unknowns: Vec<T>,
}

impl<T, L, R, const N: usize, const D: usize> Doubled<T, L, R, N, D>
where
    T: Real,
    L: DoubledLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    /// The integrator, with its workspace: no step allocates.
    pub fn new(tableau: Tableau<T>, retraction: R, lagrangian: L) -> Self {
        let s = tableau.stages();
        let n = 2 * s * N;
        let equations = StageEquations {
            lagrangian,
            retraction,
            tableau,
            start: DoubledState::unit(T::zero(), Covector::zeros()),
            wanted: T::zero(),
            h: T::zero(),
            values: Stages::new(s),
            work: [vec![T::zero(); n], vec![T::zero(); n]],
        };
        Self { equations, newton: Newton::new(n), origin: vec![T::zero(); n], unknowns: vec![T::zero(); n] }
    }

    /// Replaces `state` by the state after a step of size `h`; on an error `state` is unchanged.
    ///
    /// 2sN unknowns; Newton's method from H = η, Ψ = ψ, and where that does not contract, along a continuation in h.
    ///
    /// # Errors
    /// A fold, no convergence, leaving a domain, the Legendre transform, non-finite input.
    pub fn step(&mut self, state: &mut DoubledState<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        state.check_finite(h)?;
        if self.equations.lagrangian.uses_configuration() {
            let why = "the doubled scheme is not for systems that depend on the configuration".into();
            return Err(StepError::Unsupported { why });
        }
        let step = h.to_f64();
        let start = MomentumPoint { time: state.time, lambda: state.lambda, u: state.relative, mu: state.mu };
        let velocities = self.equations.lagrangian.velocities(&start);
        let (eta, psi) = velocities.map_err(|refused| match refused {
            VelocityError::Legendre(source) => StepError::Legendre { step, source },
            VelocityError::Domain(source) => StepError::Domain { step, stage: None, source },
        })?;
        self.equations.start.clone_from(state);
        self.equations.wanted = h;
        let half = self.origin.len() / 2;
        for (k, value) in self.origin.iter_mut().enumerate() {
            *value = if k < half { eta[k % N] } else { psi[k % N] };
        }
        let report = self.solve()?;
        // The stages of the last residual are those of the root.
        *state = self.equations.end().map_err(|source| left(h, source))?;
        Ok(report)
    }

    /// The Jacobian of the stage equations of a step of size `h` from `state` in (H_1, …, H_s, Ψ_1, …, Ψ_s), 2sN×2sN.
    ///
    /// On a unit (μ, e, μ) with H = Ψ it is [[A, B], [B, A]]: A + B is the Jacobian of the restricted scheme, A − B that of
    /// what leaves the units.
    ///
    /// # Errors
    /// Leaving a domain; other numbers of stages than the tableau's.
    pub fn stage_jacobian(
        &mut self,
        state: &DoubledState<T, N, D>,
        h: T,
        first: &[Vector<T, N>],
        second: &[Vector<T, N>],
    ) -> Result<DMatrix<T>, StepError> {
        let s = self.equations.tableau.stages();
        if first.len() != s || second.len() != s {
            let found = if first.len() == s { second.len() } else { first.len() };
            return Err(StepError::Stages { found, needed: s });
        }
        self.equations.start.clone_from(state);
        self.equations.h = h;
        let unknowns: Vec<T> = first.iter().chain(second).flat_map(|v| v.iter().copied()).collect();
        let mut jacobian = DMatrix::zeros(unknowns.len(), unknowns.len());
        self.equations.exact_jacobian(&unknowns, &mut jacobian).map_err(|source| left(h, source))?;
        Ok(jacobian)
    }

    /// (H_i, Ψ_i) of the last step that succeeded.
    pub fn stages(&self) -> (&[Vector<T, N>], &[Vector<T, N>]) {
        (&self.equations.values.first.unknown, &self.equations.values.second.unknown)
    }

    fn solve(&mut self) -> Result<Report<T>, StepError> {
        let size = T::int(self.unknowns.len() as i64) * T::unit_roundoff();
        let settings = NewtonSettings { tolerance: size, floor: size * T::int(256), max_iterations: MAX_ITERATIONS };
        self.unknowns.copy_from_slice(&self.origin);
        let found = self.newton.solve_joined(&mut self.equations, &self.origin, &mut self.unknowns, &settings);
        let h = self.equations.wanted;
        let out = |source| left(h, source);
        let (Outcome { iterations, residual, .. }, followed) =
            found.map_err(|failure| StepError::of_newton(failure, h.to_f64(), &settings, 0, out))?;
        if followed || !is_at_hand(&self.origin, &self.unknowns) {
            // Other steps were looked at: the stages are those of the last one.
            self.equations.set_fraction(T::one());
            self.equations.evaluate(&self.unknowns).map_err(out)?;
        }
        let solver = if followed { Solver::Continuation } else { Solver::Newton };
        Ok(Report { solver, iterations, residual })
    }
}

impl<T, L, R, const N: usize, const D: usize> StageEquations<T, L, R, N, D>
where
    T: Real,
    L: DoubledLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    /// The stages at these unknowns, and the residual.
    fn evaluate(&mut self, x: &[T]) -> Result<(), OutOfDomain> {
        self.values.set_unknowns(x, |v, _| v);
        residual(&self.lagrangian, &self.retraction, &self.tableau, &self.start, self.h, &mut self.values)
    }

    /// The Jacobian to round-off: a column for each unknown, by dual numbers.
    fn exact_jacobian(&self, x: &[T], out: &mut DMatrix<T>) -> Result<(), OutOfDomain> {
        if self.h == T::zero() {
            return self.jacobian_at_zero(x, out);
        }
        let mut duals = Stages::new(self.tableau.stages());
        for column in 0..x.len() {
            let seed = |v, k| if k == column { Dual::variable(v) } else { Dual::constant(v) };
            duals.set_unknowns(x, seed);
            residual(&self.lagrangian, &self.retraction, &self.tableau, &self.start, self.h, &mut duals)?;
            for (row, value) in duals.residual.iter().enumerate() {
                out[(row, column)] = value.eps;
            }
        }
        Ok(())
    }

    /// At h = 0 a stage knows nothing of the others: its equations are λ = −∂l/∂η(H, U, Ψ) and μ = ∂l/∂ψ(H, U, Ψ).
    fn jacobian_at_zero(&self, x: &[T], out: &mut DMatrix<T>) -> Result<(), OutOfDomain> {
        let s = self.tableau.stages();
        out.fill(T::zero());
        for i in 0..s {
            let (first, second) = (i * N, (s + i) * N);
            let part = |k: usize| Vector::<T, N>::from_column_slice(&x[k..k + N]);
            let (eta, psi) = (part(first), part(second));
            let hessian = self.lagrangian.velocity_hessian(&VelocityPoint {
                time: self.start.time,
                eta,
                u: self.start.relative,
                psi,
            });
            let ((a, c), (b, d)) = hessian.map_err(|source| (Some(i), source))?;
            out.fixed_view_mut::<N, N>(first, first).copy_from(&-a);
            out.fixed_view_mut::<N, N>(first, second).copy_from(&-b);
            out.fixed_view_mut::<N, N>(second, first).copy_from(&c);
            out.fixed_view_mut::<N, N>(second, second).copy_from(&d);
        }
        Ok(())
    }

    /// λ' = Ad*_{τ(ξ)} m_λ, μ' = Ad*_{τ(χ)} m_μ, U' = τ(−ξ) U τ(χ), g' = g τ(ξ), g̃' = g̃ τ(χ).
    fn end(&self) -> Result<DoubledState<T, N, D>, OutOfDomain> {
        let increment = |source| (None, source);
        let (first, second) = (&self.values.first, &self.values.second);
        let left = self.retraction.tau(&first.increment).map_err(increment)?;
        let right = self.retraction.tau(&second.increment).map_err(increment)?;
        let back = self.retraction.tau(&-first.increment).map_err(increment)?;
        Ok(DoubledState {
            time: self.start.time + self.wanted,
            lambda: first.carried * self.retraction.at(&first.increment).map_err(increment)?.ad(),
            relative: back * self.start.relative * right,
            mu: second.carried * self.retraction.at(&second.increment).map_err(increment)?.ad(),
            attitudes: self.start.attitudes.map(|(g, partner)| (g * left, partner * right)),
        })
    }
}

/// The stage equations at the unknowns in `stages`:
///
/// Π_i + h Σ_j (b_j a_ji / b_i) G_j − m_λ dτ_{−ξ} = 0 and P_i + h Σ_j (b_j a_ji / b_i) F_j − m_μ dτ_{−χ} = 0.
fn residual<T, S, L, R, const N: usize, const D: usize>(
    lagrangian: &L,
    retraction: &R,
    tableau: &Tableau<T>,
    state: &DoubledState<T, N, D>,
    h: T,
    stages: &mut Stages<S, N>,
) -> Result<(), OutOfDomain>
where
    T: Real,
    S: Scalar<Base = T>,
    L: DoubledLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    let (a, b, c) = (tableau.a(), tableau.b(), tableau.c());
    let s = tableau.stages();
    let relative = state.relative.map(S::lift);
    let step = S::lift(h);
    let Stages { first, second, residual } = stages;
    first.carried = state.lambda.map(S::lift);
    second.carried = state.mu.map(S::lift);
    for i in 0..s {
        let stage = |source| (Some(i), source);
        let (left, right) = (first.combine(step, |j| a[(i, j)]), second.combine(step, |j| a[(i, j)]));
        let (here, there) = (retraction.at(&left).map_err(stage)?, retraction.at(&right).map_err(stage)?);
        let eta = here.d() * first.unknown[i];
        let psi = there.d() * second.unknown[i];
        let back = retraction.tau(&-left).map_err(stage)?;
        let u = back * relative * retraction.tau(&right).map_err(stage)?;
        let time = S::lift(state.time + c[i] * h);
        let partials = lagrangian.partials(&VelocityPoint { time, eta, u, psi }).map_err(stage)?;
        first.momentum[i] = -partials.eta * here.d();
        second.momentum[i] = partials.psi * there.d();
        first.slope[i] = first.momentum[i] * here.dd(&first.unknown[i]) + partials.right * here.d();
        second.slope[i] = second.momentum[i] * there.dd(&second.unknown[i]) + partials.left * there.d();
        let weight = step * S::lift(b[i]);
        first.carried += partials.right * here.ad_inv() * weight;
        second.carried += partials.left * there.ad_inv() * weight;
    }
    for (copy, offset) in [(first, 0), (second, s * N)] {
        copy.increment = copy.combine(step, |j| b[j]);
        let end = retraction.at(&copy.increment).map_err(|source| (None, source))?;
        let target = copy.carried * end.d_neg();
        for i in 0..s {
            let mut row = copy.momentum[i] - target;
            for j in 0..s {
                row += copy.slope[j] * (step * S::lift(b[j] * a[(j, i)] / b[i]));
            }
            for k in 0..N {
                residual[offset + i * N + k] = row[k];
            }
        }
    }
    Ok(())
}
