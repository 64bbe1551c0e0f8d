//! The forced variational Runge–Kutta–Munthe-Kaas step, restricted to the identities: the doubled scheme at U = e.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/integrators/variational.md"))]

mod coefficients;
mod collocation;
mod exchange;
mod iteration;
mod jacobian;
mod newton;
pub(super) mod partials;
mod parts;
mod rounding;
mod work;

use super::{OneStep, Report, StagePoint, State, StepError};
use crate::algebra::brackets::Brackets;
use crate::algebra::{Covector, Vector, apply, pull};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian, LegendreError};
use crate::newton::Newton;
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Real, Scalar, finite, larger};
use crate::tableau::Tableau;
use coefficients::Coefficients;
use collocation::Collocation;
use iteration::NotContracted;
use jacobian::Jacobian;
use nalgebra::DMatrix;
use parts::{Mechanics, Mechanism, Parts};
use work::{Problem, Work};

pub(super) use coefficients::LEAST_NODE_DISTANCE;
#[cfg(feature = "lanes")]
pub(super) use coefficients::extrapolation;
pub(crate) use exchange::Exchange;
pub(crate) use newton::turn;
pub(super) use work::Factors;

/// What the stage equations need of a stage, with τ and its tangents at Ξ_i = h Σ_j a_ij H_j.
///
/// Source: Martín de Diego and Sato Martín de Almagro 2019, §5.2, restricted to the identities.
#[derive(Clone, Copy, Debug)]
struct Stage<S: Scalar, const N: usize> {
    /// η_i = dτ H_i.
    velocity: Vector<S, N>,
    terms: Terms<S, N>,
    /// The size of what f_i is the sum of.
    load: S::Base,
}

/// P_i, G_i and f_i Ad_{τ(Ξ_i)}⁻¹ of a stage, or a change of them; a Lagrangian that depends on g adds ∂L/∂g to the force f_i.
#[derive(Clone, Copy, Debug)]
struct Terms<S: Scalar, const N: usize> {
    /// P_i = M_i dτ, M_i = ∂L/∂η.
    momentum: Covector<S, N>,
    /// G_i = P_i ddτ(H_i, ·) + f_i dτ.
    gradient: Covector<S, N>,
    /// f_i Ad_{τ(Ξ_i)}⁻¹.
    impulse: Covector<S, N>,
}

impl<'a, T: Real, const N: usize, const D: usize> Mechanics<'a, T, N, D> {
    /// Stage i of a step of this size, at H_i and the tangents at Ξ_i.
    fn stage<S: Scalar<Base = T>>(
        &self,
        (i, step): (usize, T),
        time: S,
        g: Configuration<'_, S>,
        point: &dyn TangentPoint<S, N>,
        rate: &Vector<S, N>,
    ) -> Result<Stage<S, N>, StepError>
    where
        dyn Mechanism<T, N, D> + 'a: Parts<S, N, D>,
    {
        let velocity = apply(point.d(), rate);
        let m = self.parts.momentum(time, g, &velocity);
        let momentum = pull(&m, point.d());
        let mut gradient = point.pull_dd(&momentum, &m, rate);
        if !self.forced {
            let terms = Terms { momentum, gradient, impulse: Covector::zeros() };
            return Ok(Stage { velocity, terms, load: T::zero() });
        }
        let (f, load) = self.parts.total_force(time, g, &velocity);
        if !finite(f.as_slice()) {
            let at = g.matrix::<D>().map(|v| v.base());
            let g = Configuration::of(&at);
            return Err(self.parts.undefined(Some(i), step, time.base(), g, &velocity.map(|v| v.base())));
        }
        let seen = pull(&f, point.d());
        gradient += seen;
        let terms = Terms { momentum, gradient, impulse: point.pull_ad_inv(&f, &seen) };
        Ok(Stage { velocity, terms, load })
    }

    /// The residual r_i = P_i + h Σ_j (b_j a_ji / b_i) G_j − m dτ_{−ξ} at the rates H_i in the workspace, with ξ = h Σ_j b_j H_j and
    /// m = μ + h Σ_j b_j f_j Ad_{τ(Ξ_j)}⁻¹; returns the size to compare it with. The same equations for an iteration on (M_i, Ξ_i) or
    /// (P_i, Ξ_i) are in `Scheme::iterate`.
    fn residual(&self, problem: &Problem<T, N, D>, work: &mut Work<T, N>) -> Result<T, StepError> {
        let Coefficients { tableau, weights, coupling, .. } = self.coefficients;
        let (h, mut load) = (problem.step, problem.rounding);
        work.displacements.combine(weights, &work.rates);
        for i in 0..tableau.stages() {
            let x = work.displacements.vector(i) * h;
            let rate = work.rates.vector(i);
            let at = self.placed(problem, &x).map_err(|e| domain(h, Some(i), e))?;
            let time = problem.time + tableau.c()[i] * h;
            let stage =
                self.with((Some(i), h), &x, |point| self.stage((i, h), time, self.configuration(&at), point, &rate))??;
            load = larger(load, stage.load);
            if self.forced {
                work.impulses.set_covector(i, &stage.terms.impulse);
            }
            work.displacements.set_vector(i, &x);
            work.velocities.set_vector(i, &stage.velocity);
            work.momenta.set_covector(i, &stage.terms.momentum);
            work.gradients.set_covector(i, &stage.terms.gradient);
        }
        work.end(problem, tableau, self.forced);
        let end = self.with((None, h), &work.increment, |point| pull(&work.after_impulse, &point.d_neg()))?;
        work.residuals.combine(coupling, &work.gradients);
        let mut size = larger(largest(&end), load * h.abs());
        for i in 0..tableau.stages() {
            let (p, coupled) = (work.momenta.covector(i), work.residuals.covector(i) * h);
            size = larger(size, larger(largest(&p), largest(&coupled)));
            work.residuals.set_covector(i, &(p + coupled - end));
        }
        Ok(size)
    }
}

impl<T: Real, const N: usize> Work<T, N> {
    /// ξ = h Σ_j b_j H_j and m = μ + h Σ_j b_j f_j Ad_{τ(Ξ_j)}⁻¹, from the stages.
    #[inline(always)]
    fn end<const D: usize>(&mut self, problem: &Problem<T, N, D>, tableau: &Tableau<T>, forced: bool) {
        let (h, b) = (problem.step, tableau.b().as_slice());
        self.increment = self.rates.sum(b) * h;
        self.after_impulse = problem.momentum;
        if forced {
            self.after_impulse += self.impulses.sum(b).transpose() * h;
        }
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Scheme<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// μ' = m Ad_{τ(ξ)} and g' = g τ(ξ); without a group g is left alone.
    fn after(
        &self,
        Problem { time, step, attitude, .. }: &Problem<T, N, D>,
        work: &Work<T, N>,
        point: &impl TangentPoint<T, N>,
    ) -> Result<State<T, N, D>, StepError> {
        let momentum = work.after_impulse * point.ad();
        let attitude = match self.retraction.tau(&work.increment) {
            Ok(increment) => attitude * increment,
            Err(RetractionError::NoGroup { .. }) => *attitude,
            Err(source) => return Err(domain(*step, None, source)),
        };
        Ok(State { time: *time + *step, momentum, attitude })
    }

    /// Asks the Lagrangian and the force what they depend on.
    fn find_dependences(&mut self) {
        self.moves = self.force.uses_configuration() || self.lagrangian.uses_configuration();
        self.forced = !self.force.is_zero() || self.lagrangian.uses_configuration();
    }

    /// The η with ∂L/∂η = m.
    #[inline(always)]
    fn velocity(
        &self,
        time: T,
        g: Configuration<'_, T>,
        m: &Covector<T, N>,
        near: &Vector<T, N>,
    ) -> Result<Vector<T, N>, LegendreError> {
        match self.moves {
            true => self.lagrangian.velocity_at(time, g, m, near),
            false => self.lagrangian.velocity(m, near),
        }
    }
}

/// When the stage equations count as solved, and how long to try.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings<T> {
    /// The relative residual wanted. Default 16 u.
    pub tolerance: T,
    /// A relative residual that no longer falls is accepted below this: it is rounding. Default 2¹⁴ u, the
    /// amplification of rounding that an inertia of condition 10³ and a stage near the edge of the retraction's
    /// domain cause.
    pub floor: T,
    /// The most fixed-point iterations before Newton's method takes over. Default 100.
    pub max_fixed_point_iterations: usize,
    /// The most Newton iterations in one solve. Default 12.
    pub max_iterations: usize,
}

impl<T: Real> Default for Settings<T> {
    fn default() -> Self {
        let u = T::unit_roundoff();
        Self {
            tolerance: T::int(ROUNDOFF_LEFT) * u,
            floor: T::int(1 << 14) * u,
            max_fixed_point_iterations: 100,
            max_iterations: 12,
        }
    }
}

/// The relative residual that rounding leaves, in units of round-off.
pub(super) const ROUNDOFF_LEFT: i64 = 16;

/// Where coordinates have weights (`work::Factors`), the least tolerance and the least floor, in units of round-off times the largest weight: stages
/// are sums of terms of other coordinates.
const WEIGHTED_TOLERANCE: i64 = 4;
const WEIGHTED_FLOOR: i64 = 1 << 10;

/// Terms of the stage equations up to this multiple of the momentum are not looked at any further, and what residuals are relative to may grow
/// by this factor from where an iteration starts.
const HARMLESS_GROWTH: i64 = 1 << 10;

/// The system and the method: what does not change from step to step.
#[derive(Clone, Debug)]
struct Scheme<T: Real, const N: usize, const D: usize, L, F, R> {
    lagrangian: L,
    force: F,
    retraction: R,
    coefficients: Coefficients<T>,
    /// Whether the Lagrangian or the force depends on the configuration; asked once a step.
    moves: bool,
    /// Whether there is a force, f or that of a potential; asked once a step.
    forced: bool,
}

/// The forced variational RKMK integrator of a Lagrangian, a force, a retraction and a tableau.
///
/// State (g, μ); the unknowns are the s·N numbers H_i. Nothing is allocated by a step. Source: Martín de Diego and
/// Sato Martín de Almagro 2019, §5.2, restricted to the identities.
#[derive(Clone, Debug)]
pub struct Variational<T: Real, const N: usize, const D: usize, L, F, R> {
    scheme: Scheme<T, N, D, L, F, R>,
    settings: Settings<T>,
    work: Work<T, N>,
    collocation: Collocation<T, N>,
    jacobian: Jacobian<T, N>,
    newton: Newton<T>,
    unknowns: Vec<T>,
    /// Step size and final momentum of the last step, when the stage velocities in `work` are those of that step.
    last: Option<(T, Covector<T, N>)>,
    /// Step size and momentum of the step for which `work` holds predicted stage velocities.
    predicted: Option<(T, Covector<T, N>)>,
    /// The rate of contraction of the last fixed-point iterations.
    contraction: f64,
    /// The first residual of the last step: how far the scheme is from the equations that its guess comes from.
    first_residual: Option<T>,
    /// Whether rounding of the forces decided when the last step was solved.
    rounded: bool,
    /// Whether the caller compares each step with others: then a root counts to which fixed-point iterations contract, however far it is.
    compared: bool,
}

/// Why fixed-point iterations alone give no step.
pub(super) enum Uncontracted {
    /// They do not contract, or too slowly to be sure of the branch; their number.
    Slow(usize),
    /// There is no step.
    Refused(StepError),
}

impl From<StepError> for Uncontracted {
    fn from(error: StepError) -> Self {
        Self::Refused(error)
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Variational<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// The integrator for l, f, τ and a tableau, with the default settings.
    pub fn new(lagrangian: L, force: F, retraction: R, tableau: Tableau<T>) -> Self {
        Self::with_settings(lagrangian, force, retraction, tableau, Settings::default())
    }

    /// The same with settings of one's own.
    pub fn with_settings(lagrangian: L, force: F, retraction: R, tableau: Tableau<T>, settings: Settings<T>) -> Self {
        let s = tableau.stages();
        let collocation = Collocation::new(Brackets::of(retraction.algebra()), s);
        Self {
            scheme: Scheme {
                lagrangian,
                force,
                retraction,
                coefficients: Coefficients::of(tableau),
                moves: true,
                forced: true,
            },
            settings,
            work: Work::new(s),
            collocation,
            jacobian: Jacobian::new(s),
            newton: Newton::new(s * N),
            unknowns: vec![T::zero(); s * N],
            last: None,
            predicted: None,
            contraction: 0.0,
            first_residual: None,
            rounded: false,
            compared: false,
        }
    }

    /// Leaves it to the caller to see that a root is another than that from h = 0: each step is compared with others, of other sizes.
    pub(super) fn leave_to_comparison(&mut self) {
        self.compared = true;
    }

    /// By which factor the residual fell in each fixed-point iteration of the last step.
    pub(super) fn contraction(&self) -> f64 {
        self.contraction
    }

    /// Replaces the relative residual at which the stage equations count as solved; never below that of the default.
    pub(super) fn set_tolerance(&mut self, tolerance: T) {
        let (default, rounding) = (
            Settings::<T>::default(),
            T::unit_roundoff() * self.work.factors.as_ref().map_or(T::one(), |of| of.spread),
        );
        self.settings.tolerance = default.tolerance.max(tolerance).max(rounding * T::int(WEIGHTED_TOLERANCE));
        self.settings.floor = default.floor.max(tolerance).max(rounding * T::int(WEIGHTED_FLOOR));
    }

    /// Replaces what a residual of each coordinate counts; before the tolerance.
    pub(super) fn set_factors(&mut self, factors: Factors<T, N>) {
        self.work.factors = Some(factors);
    }

    /// The next step, if it is one of size `step` from this momentum, starts from these stage velocities.
    pub(super) fn predict(
        &mut self,
        step: T,
        momentum: &Covector<T, N>,
        mut velocity: impl FnMut(usize) -> Vector<T, N>,
    ) {
        for i in 0..self.scheme.coefficients.tableau.stages() {
            self.work.velocities.set_vector(i, &velocity(i));
        }
        self.predicted = Some((step, *momentum));
    }

    /// The Lagrangian l.
    pub fn lagrangian(&self) -> &L {
        &self.scheme.lagrangian
    }

    /// The Lagrangian l, to be changed between steps.
    pub fn lagrangian_mut(&mut self) -> &mut L {
        &mut self.scheme.lagrangian
    }

    /// The force f.
    pub fn force(&self) -> &F {
        &self.scheme.force
    }

    /// The force f, to be changed between steps.
    pub fn force_mut(&mut self) -> &mut F {
        &mut self.scheme.force
    }

    /// The retraction τ.
    pub fn retraction(&self) -> &R {
        &self.scheme.retraction
    }

    /// The tableau.
    pub fn tableau(&self) -> &Tableau<T> {
        &self.scheme.coefficients.tableau
    }

    /// η_i of the last step, in the order of the stages; meaningless before the first.
    pub fn stage_velocities(&self) -> impl Iterator<Item = Vector<T, N>> + '_ {
        (0..self.scheme.coefficients.tableau.stages()).map(|i| self.work.velocities.vector(i))
    }

    /// Ξ_i = h Σ_j a_ij H_j of the last step, in the order of the stages: stage i is at g τ(Ξ_i). Meaningless before the first.
    pub fn stage_displacements(&self) -> impl Iterator<Item = Vector<T, N>> + '_ {
        (0..self.scheme.coefficients.tableau.stages()).map(|i| self.work.displacements.vector(i))
    }

    /// (H_i, F_i Ad⁻¹_{τ(Ξ_i)}) of the last step, in the order of the stages: ξ̇ and ṁ seen from its start. Meaningless before the first.
    pub(crate) fn stage_rates(&self) -> impl Iterator<Item = (Vector<T, N>, Covector<T, N>)> + '_ {
        let impulse = |i| if self.scheme.forced { self.work.impulses.covector(i) } else { Covector::zeros() };
        (0..self.scheme.coefficients.tableau.stages()).map(move |i| (self.work.rates.vector(i), impulse(i)))
    }

    /// The size of the terms of the stage equations of a step of size h from `start`, at the H_i of the last step: |P_i|, |h Σ_j b_j a_ji/b_i
    /// G_j|, |m dτ(−ξ)|, and h times the terms that make the forces.
    #[cfg(feature = "harness")]
    pub(crate) fn terms(&mut self, start: &State<T, N, D>, h: T) -> Result<T, StepError> {
        self.last = None;
        self.scheme.mechanics().residual(&Problem::new(start, h), &mut self.work)
    }

    /// ξ = h Σ_j b_j H_j of the last step: g' = g τ(ξ).
    pub fn increment(&self) -> &Vector<T, N> {
        &self.work.increment
    }

    /// The residual r_1 … r_s of the stage equations of a step of size h from a state, at H_1 … H_s (`rates`).
    ///
    /// For laws and for judging stages found elsewhere; `out` and `rates` hold s vectors.
    ///
    /// # Errors
    /// Leaving the retraction's domain; another number of stages than the tableau's.
    pub fn residual(
        &mut self,
        state: &State<T, N, D>,
        step: T,
        rates: &[Vector<T, N>],
        out: &mut [Covector<T, N>],
    ) -> Result<(), StepError> {
        self.check_stages(out.len())?;
        self.place(rates)?;
        self.scheme.mechanics().residual(&Problem::new(state, step), &mut self.work)?;
        for (i, r) in out.iter_mut().enumerate() {
            *r = self.work.residuals.covector(i);
        }
        Ok(())
    }

    /// Puts H_1 … H_s into the workspace.
    fn place(&mut self, rates: &[Vector<T, N>]) -> Result<(), StepError> {
        self.check_stages(rates.len())?;
        (self.last, self.predicted) = (None, None);
        self.scheme.find_dependences();
        for (i, rate) in rates.iter().enumerate() {
            self.work.rates.set_vector(i, rate);
        }
        Ok(())
    }

    /// Refuses another number of stages than the tableau's.
    fn check_stages(&self, found: usize) -> Result<(), StepError> {
        let needed = self.scheme.coefficients.tableau.stages();
        if found == needed { Ok(()) } else { Err(StepError::Stages { found, needed }) }
    }

    /// The Jacobian of [`Variational::residual`] in (H_1, …, H_s), sN×sN, by dual numbers.
    ///
    /// # Errors
    /// Leaving the retraction's domain; another number of stages than the tableau's.
    pub fn stage_jacobian(
        &mut self,
        state: &State<T, N, D>,
        step: T,
        rates: &[Vector<T, N>],
    ) -> Result<DMatrix<T>, StepError> {
        self.place(rates)?;
        let mut jacobian = DMatrix::zeros(rates.len() * N, rates.len() * N);
        let (problem, out) = (Problem::new(state, step), (&mut jacobian, None));
        self.scheme.mechanics().jacobian(&problem, &self.work.rates, &mut self.jacobian, out, &mut |_, _, _| Ok(()))?;
        Ok(jacobian)
    }

    /// The step, by Newton's method only where that is allowed; where fixed-point iterations do not find it, `Err` of their number, or of why there is
    /// no step.
    pub(super) fn attempt(
        &mut self,
        state: &mut State<T, N, D>,
        h: T,
        newton: bool,
    ) -> Result<Report<T>, Uncontracted> {
        if newton {
            return Ok(self.step(state, h)?);
        }
        let (mut problem, eta) = self.begin(state, h)?;
        let report = self.iterate_stages(&mut problem, &eta);
        let report = report.map_err(|NotContracted(spent)| Uncontracted::Slow(spent))?;
        self.finish(&problem, state)?;
        Ok(report)
    }

    /// The step that is to be taken, and η at its start.
    fn begin(&mut self, state: &State<T, N, D>, h: T) -> Result<(Problem<T, N, D>, Vector<T, N>), StepError> {
        state.check_finite(h)?;
        self.scheme.find_dependences();
        let problem = Problem::new(state, h);
        let guess = if self.last.is_some() { self.work.velocities.vector(0) } else { Vector::zeros() };
        let here = Configuration::of(&state.attitude);
        let eta = self
            .scheme
            .lagrangian
            .velocity_at(state.time, here, &state.momentum, &guess)
            .map_err(|source| StepError::Legendre { step: h.to_f64(), source })?;
        if !finite(Parts::<T, N, D>::total_force(&self.scheme, problem.time, here, &eta).0.as_slice()) {
            return Err(self.scheme.mechanics().parts.undefined(None, h, problem.time, here, &eta));
        }
        Ok((problem, eta))
    }

    /// The state after the step whose stages are in the workspace.
    fn finish(&mut self, problem: &Problem<T, N, D>, state: &mut State<T, N, D>) -> Result<(), StepError> {
        let h = problem.step;
        let point = self.scheme.retraction.at(&self.work.increment).map_err(|e| domain(h, None, e))?;
        let growth = self.scheme.mechanics().growth(problem, &self.work, &point.d_neg());
        if growth > T::one() / T::unit_roundoff().sqrt() {
            return Err(StepError::IllConditioned { step: h.to_f64(), growth: growth.to_f64() });
        }
        let next = self.scheme.after(problem, &self.work, &point)?;
        next.check_finite(h)?;
        self.last = Some((h, next.momentum));
        *state = next;
        self.rounded = problem.rounds();
        Ok(())
    }
}

impl<T, const N: usize, const D: usize, L, F, R> OneStep<T, N, D> for Variational<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    fn stages(&self) -> Option<Vec<StagePoint<T, N, D>>> {
        let (b, c) = (self.scheme.coefficients.tableau.b(), self.scheme.coefficients.tableau.c());
        let stage = |(j, (x, velocity)): (usize, (Vector<T, N>, Vector<T, N>))| {
            let turn = self.scheme.retraction.tau(&x).ok()?;
            Some(StagePoint { weight: b[j], node: c[j], turn, velocity })
        };
        self.stage_displacements().zip(self.stage_velocities()).enumerate().map(stage).collect()
    }

    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        let (mut problem, eta) = self.begin(state, h)?;
        let report = match self.iterate_stages(&mut problem, &eta) {
            Ok(report) => report,
            // A stage may have left the domain only because the fixed-point iterations diverge: Newton's method decides.
            Err(NotContracted(iterations)) => self.newton(&problem, &eta, iterations)?,
        };
        self.finish(&problem, state)?;
        Ok(report)
    }
}

fn domain<T: Real>(step: T, stage: Option<usize>, source: RetractionError) -> StepError {
    StepError::Domain { step: step.to_f64(), stage, source }
}

/// The largest absolute value, without derivative parts; NaN if there is one.
fn largest<T: Real, S: Scalar<Base = T>, const N: usize>(covector: &Covector<S, N>) -> T {
    covector.iter().fold(T::zero(), |m, v| larger(m, v.base().abs()))
}

/// change / size, where 0/0 is 0: a system at rest solves its equations. A size below which rounding is not relative counts as that.
pub(super) fn relative<T: Real>(change: T, size: T) -> T {
    let least = T::exact(f64::MIN_POSITIVE / T::unit_roundoff().to_f64());
    if change == T::zero() { T::zero() } else { change / larger(size, least) }
}
