//! The doubled variational scheme on g*×G×g*, on the units and off them.
//!
//! It extremises Σ h b_i **l**(dτ_{Ξ_i}H_i, τ(−Ξ_i) U τ(X_i), dτ_{X_i}Ψ_i) over the stages (Martín de Diego and Sato
//! Martín de Almagro 2019, §5.2). For (λ, U, μ) = (μ, e, μ) and the doubled Lagrangian of a forced system it stays
//! there and is the restricted scheme; it is written without regard to that one, so that the two judge each other.

use super::{Report, Solver, StepError};
use crate::algebra::{Covector, Matrix, Vector};
use crate::mechanics::doubled::DoubledLagrangian;
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Dual, Real, Scalar};
use crate::tableau::Tableau;

/// Newton steps per time step; quadratic convergence needs five or six.
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

    fn check(&self, h: T) -> Result<(), StepError> {
        let bad = |what| Err(StepError::NotFinite { what });
        if !h.all_finite() {
            return bad("h");
        }
        if !self.time.all_finite() {
            return bad("the time");
        }
        if !self.lambda.iter().chain(self.mu.iter()).all(|v| v.all_finite()) {
            return bad("the momentum");
        }
        let mut matrices = [Some(&self.relative), None, None];
        if let Some((g, partner)) = &self.attitudes {
            matrices = [Some(&self.relative), Some(g), Some(partner)];
        }
        if !matrices.into_iter().flatten().flatten().all(|v| v.all_finite()) {
            return bad("the attitude");
        }
        Ok(())
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
}

/// The stage that left the domain of a retraction (none: the increment), and why.
type OutOfDomain = (Option<usize>, RetractionError);

/// The doubled scheme with a tableau, a retraction and a doubled Lagrangian.
pub struct Doubled<T, L, R, const N: usize, const D: usize>
where
    T: Real,
    L: DoubledLagrangian<T, N, D>,
    R: Retraction<T, N, D>,
{
    lagrangian: L,
    retraction: R,
    tableau: Tableau<T>,
    values: Stages<T, N>,
    duals: Stages<Dual<T>, N>,
    /// The best stages so far.
    kept: Vec<Vector<T, N>>,
    /// 2sN × 2sN, by columns.
    jacobian: Vec<T>,
    correction: Vec<T>,
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
        Self {
            lagrangian,
            retraction,
            tableau,
            values: Stages::new(s),
            duals: Stages::new(s),
            kept: vec![Vector::zeros(); 2 * s],
            jacobian: vec![T::zero(); n * n],
            correction: vec![T::zero(); n],
        }
    }

    /// Replaces `state` by the state after a step of size `h`; on an error `state` is unchanged.
    ///
    /// 2sN unknowns, Newton's method from H = η, Ψ = ψ. There is no continuation in h: past a fold of the solution it
    /// fails, or finds another root.
    ///
    /// # Errors
    /// No convergence, leaving a domain, the Legendre transform, non-finite input.
    pub fn step(&mut self, state: &mut DoubledState<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        state.check(h)?;
        let step = h.to_f64();
        let (eta, psi) = self
            .lagrangian
            .velocities(&state.lambda, &state.mu)
            .map_err(|source| StepError::Legendre { step, source })?;
        self.values.first.unknown.fill(eta);
        self.values.second.unknown.fill(psi);
        let report = self.solve(state, h)?;
        self.advance(state, h).map_err(|(stage, source)| StepError::Domain { step, stage, source })?;
        Ok(report)
    }

    /// Newton's method; leaves the best stages and what follows from them in `self.values`.
    fn solve(&mut self, state: &DoubledState<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        let step = h.to_f64();
        let s = self.tableau.stages();
        let tolerance = T::int(64 * (s * N) as i64) * T::unit_roundoff();
        let out = |(stage, source)| StepError::Domain { step, stage, source };
        let mut best: Option<T> = None;
        for iteration in 0..MAX_ITERATIONS {
            residual(&self.lagrangian, &self.retraction, &self.tableau, state, h, &mut self.values).map_err(out)?;
            let size = relative_residual(&self.values, state);
            let failed = StepError::NotConverged {
                step,
                residual: best.unwrap_or(size).to_f64(),
                tolerance: tolerance.to_f64(),
                iterations: iteration,
            };
            if !size.all_finite() {
                return Err(failed);
            }
            // At round-off the residual stops falling: keep the best, and only then stop.
            if best.is_none_or(|b| size < b) {
                let stop = size == T::zero() || best.is_some_and(|b| b <= tolerance && size > b * T::half());
                best = Some(size);
                self.kept[..s].copy_from_slice(&self.values.first.unknown);
                self.kept[s..].copy_from_slice(&self.values.second.unknown);
                if stop {
                    return Ok(Report { solver: Solver::Newton, iterations: iteration, residual: size });
                }
            } else if let Some(residual_size) = best.filter(|b| *b <= tolerance) {
                self.values.first.unknown.copy_from_slice(&self.kept[..s]);
                self.values.second.unknown.copy_from_slice(&self.kept[s..]);
                residual(&self.lagrangian, &self.retraction, &self.tableau, state, h, &mut self.values).map_err(out)?;
                return Ok(Report { solver: Solver::Newton, iterations: iteration, residual: residual_size });
            }
            self.linearise(state, h).map_err(out)?;
            self.correction.copy_from_slice(&self.values.residual);
            if !eliminate(&mut self.jacobian, &mut self.correction) {
                return Err(failed);
            }
            for i in 0..s {
                for a in 0..N {
                    self.values.first.unknown[i][a] -= self.correction[i * N + a];
                    self.values.second.unknown[i][a] -= self.correction[(s + i) * N + a];
                }
            }
        }
        let residual = best.map_or(f64::NAN, |b| b.to_f64());
        Err(StepError::NotConverged { step, residual, tolerance: tolerance.to_f64(), iterations: MAX_ITERATIONS })
    }

    /// The Jacobian of the residual at the present stages, a column for each unknown, by dual numbers.
    fn linearise(&mut self, state: &DoubledState<T, N, D>, h: T) -> Result<(), OutOfDomain> {
        let s = self.tableau.stages();
        let n = 2 * s * N;
        for column in 0..n {
            for i in 0..s {
                self.duals.first.unknown[i] = self.values.first.unknown[i].map(Dual::constant);
                self.duals.second.unknown[i] = self.values.second.unknown[i].map(Dual::constant);
            }
            let (stage, a) = (column / N, column % N);
            let moved = if stage < s {
                &mut self.duals.first.unknown[stage][a]
            } else {
                &mut self.duals.second.unknown[stage - s][a]
            };
            moved.eps = T::one();
            residual(&self.lagrangian, &self.retraction, &self.tableau, state, h, &mut self.duals)?;
            for row in 0..n {
                self.jacobian[column * n + row] = self.duals.residual[row].eps;
            }
        }
        Ok(())
    }

    /// λ' = Ad*_{τ(ξ)} m_λ, μ' = Ad*_{τ(χ)} m_μ, U' = τ(−ξ) U τ(χ), g' = g τ(ξ), g̃' = g̃ τ(χ).
    fn advance(&self, state: &mut DoubledState<T, N, D>, h: T) -> Result<(), OutOfDomain> {
        let increment = |source| (None, source);
        let (xi, chi) = (&self.values.first.increment, &self.values.second.increment);
        let lambda = self.values.first.carried * self.retraction.at(xi).map_err(increment)?.ad();
        let mu = self.values.second.carried * self.retraction.at(chi).map_err(increment)?.ad();
        let back = self.retraction.tau(&-xi).map_err(increment)?;
        let forth = self.retraction.tau(chi).map_err(increment)?;
        if let Some((g, partner)) = &mut state.attitudes {
            *g *= self.retraction.tau(xi).map_err(increment)?;
            *partner *= forth;
        }
        state.time += h;
        state.lambda = lambda;
        state.mu = mu;
        state.relative = back * state.relative * forth;
        Ok(())
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
        let partials = lagrangian.partials(time, &eta, &u, &psi).map_err(stage)?;
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

/// The largest residual relative to the largest momentum around (absolute when all momenta vanish).
fn relative_residual<T: Real, const N: usize, const D: usize>(
    stages: &Stages<T, N>,
    state: &DoubledState<T, N, D>,
) -> T {
    let mut scale = T::zero();
    let momenta = stages.first.momentum.iter().chain(&stages.second.momentum);
    for value in momenta.chain([&state.lambda, &state.mu]).flat_map(|p| p.iter()) {
        scale = scale.max(value.abs());
    }
    let mut size = T::zero();
    for value in &stages.residual {
        if !value.all_finite() {
            return T::exact(f64::NAN);
        }
        size = size.max(value.abs());
    }
    if scale > T::zero() { size / scale } else { size }
}

/// Overwrites b by A⁻¹b, A by columns, by elimination with partial pivoting; false when a pivot vanishes.
fn eliminate<T: Real>(a: &mut [T], b: &mut [T]) -> bool {
    let n = b.len();
    for k in 0..n {
        let mut pivot = k;
        for row in k + 1..n {
            if a[k * n + row].abs() > a[k * n + pivot].abs() {
                pivot = row;
            }
        }
        let best = a[k * n + pivot];
        if best == T::zero() || !best.all_finite() {
            return false;
        }
        if pivot != k {
            for column in 0..n {
                a.swap(column * n + k, column * n + pivot);
            }
            b.swap(k, pivot);
        }
        for row in k + 1..n {
            let factor = a[k * n + row] / best;
            for column in k + 1..n {
                let drop = factor * a[column * n + k];
                a[column * n + row] -= drop;
            }
            let drop = factor * b[k];
            b[row] -= drop;
        }
    }
    for k in (0..n).rev() {
        for column in k + 1..n {
            let drop = a[column * n + k] * b[column];
            b[k] -= drop;
        }
        b[k] /= a[k * n + k];
    }
    b.iter().all(|v| v.all_finite())
}
