//! The forced variational Runge–Kutta–Munthe-Kaas step, restricted to the units.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/integrators/variational.md"))]

mod collocation;
mod exchange;
mod jacobian;
pub(super) mod partials;
mod parts;
mod rounding;

use super::fixed_point::Course;
use super::stages::{Stages, Weights};
use super::{OneStep, Report, Solver, StagePoint, State, StepError};
use crate::algebra::brackets::Brackets;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, apply, pull, times};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian, LegendreError};
use crate::newton::{self, Equations, Newton};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Real, Scalar, finite, larger};
use crate::tableau::Tableau;
use collocation::Collocation;
use jacobian::Jacobian;
use nalgebra::DMatrix;
use parts::Mechanics;
use rounding::FirstScale;

pub(crate) use exchange::Exchange;

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

/// A relative residual of so many units of round-off is what rounding leaves.
pub(super) const ROUNDOFF_LEFT: i64 = 16;

/// Of a residual that counts many times no less is asked for than this, in units of round-off times as many; and no more than that is taken for
/// rounding: stages are sums of terms of other coordinates.
const WEIGHTED_TOLERANCE: i64 = 4;
const WEIGHTED_FLOOR: i64 = 1 << 10;

/// The last change of the stages between two evaluations of the scheme is so many times smaller than the residual of the first: the next
/// change would be as much smaller again, and the second evaluation gains little more.
const GUESS_FINER_BY: i64 = 16;

/// The first residual of s stages is expected to be FIRST_RESIDUAL⁻ˢ: that of steps of a quarter of a radian.
const FIRST_RESIDUAL: i64 = 16;

/// Terms of the stage equations up to so many times the momentum are not looked at any further, and what residuals are relative to may be so
/// many times what it is where an iteration starts.
const HARMLESS_GROWTH: i64 = 1 << 10;

/// Displacements between two points of a continuation differ by no more than this, in ‖ad‖: dτ changes at distances of 1, and a fold next to where it
/// is singular is narrower. At 1.8 one was stepped over where a stage passed |Ξ| = 6π (case 31328 of seed 998021 of the law `branch`).
const LARGEST_TURN: (i64, i64) = (1, 4);

/// Nodes closer than this count as one where values are interpolated.
pub(super) const LEAST_NODE_DISTANCE: f64 = 1.0 / 1024.0;

/// Weights larger than this extrapolate nothing but rounding.
const LARGEST_WEIGHT: f64 = 1_048_576.0;

/// What is taken of what fixed-point iterations find.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Trust {
    /// Roots that are near, or to which the iterations contract all the way.
    Alone,
    /// Roots to which they contract: whoever asks for a step compares it with others.
    Compared,
    /// Whatever has a small residual: a fault for laws to see.
    #[cfg(feature = "harness")]
    Residual,
}

/// The system and the method: what does not change from step to step.
#[derive(Clone, Debug)]
struct Scheme<T: Real, L, F, R> {
    lagrangian: L,
    force: F,
    retraction: R,
    coefficients: Coefficients<T>,
    /// Whether the Lagrangian or the force depends on the configuration; asked once a step.
    moves: bool,
    /// Whether there is anything in the place of f; asked once a step.
    forced: bool,
}

/// The tableau, and what follows from it.
#[derive(Clone, Debug)]
struct Coefficients<T: Real> {
    tableau: Tableau<T>,
    /// a_ij.
    weights: Weights<T>,
    /// â_ij.
    conjugate: Weights<T>,
    /// b_j a_ji / b_i.
    coupling: Weights<T>,
    /// Lagrange weights that carry values at c_j to 1 + c_i; none where nodes coincide.
    extrapolation: Option<Weights<T>>,
}

impl<T: Real> Coefficients<T> {
    fn of(tableau: Tableau<T>) -> Self {
        let (s, a, b) = (tableau.stages(), tableau.a(), tableau.b());
        Self {
            weights: Weights::of(a),
            conjugate: Weights::of(tableau.conjugate().a()),
            coupling: Weights::of(&DMatrix::from_fn(s, s, |i, j| b[j] * a[(j, i)] / b[i])),
            extrapolation: extrapolation(tableau.c().as_slice()).as_ref().map(Weights::of),
            tableau,
        }
    }
}

/// The step that is being taken.
#[derive(Clone, Copy, Debug)]
struct Problem<T: Real, const N: usize, const D: usize> {
    time: T,
    step: T,
    momentum: Covector<T, N>,
    attitude: Matrix<T, D>,
    /// A force that residuals are relative to besides those that act, see [`rounding`]; 0 where it is not needed.
    rounding: T,
}

impl<T: Real, const N: usize, const D: usize> Problem<T, N, D> {
    fn new(state: &State<T, N, D>, step: T) -> Self {
        let rounding = T::zero();
        Self { time: state.time, step, momentum: state.momentum, attitude: state.attitude, rounding }
    }
}

/// The quantities of the s stages and of the step.
#[derive(Clone, Debug)]
struct Work<T: Real, const N: usize> {
    /// H_i.
    rates: Stages<T, N>,
    /// Ξ_i.
    displacements: Stages<T, N>,
    /// η_i.
    velocities: Stages<T, N>,
    /// P_i.
    momenta: Stages<T, N>,
    /// G_i.
    gradients: Stages<T, N>,
    /// f_i Ad_{τ(Ξ_i)}⁻¹.
    impulses: Stages<T, N>,
    /// The next P_i, or the residual r_i.
    next_momenta: Stages<T, N>,
    /// The next Ξ_i, or the extrapolated η_i.
    next_displacements: Stages<T, N>,
    /// m.
    after_impulse: Covector<T, N>,
    /// ξ.
    increment: Vector<T, N>,
    /// What changes count, where not once.
    factors: Option<Factors<T, N>>,
}

/// How many times a change of each coordinate counts, where all are relative to the largest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors<T, const N: usize> {
    pub momenta: [T; N],
    pub displacements: [T; N],
    /// How many times more than another a momentum counts, at most, of which it may have the rounding.
    pub spread: T,
}

impl<T: Real, const N: usize> Factors<T, N> {
    /// The largest of a momentum.
    pub fn most(&self) -> T {
        self.momenta.iter().fold(T::one(), |most, &factor| most.max(factor))
    }
}

impl<T: Real, const N: usize> Work<T, N> {
    fn new(stages: usize) -> Self {
        let zeros = Stages::zeros(stages);
        Self {
            rates: zeros.clone(),
            displacements: zeros.clone(),
            velocities: zeros.clone(),
            momenta: zeros.clone(),
            gradients: zeros.clone(),
            impulses: zeros.clone(),
            next_momenta: zeros.clone(),
            next_displacements: zeros,
            after_impulse: Covector::zeros(),
            increment: Vector::zeros(),
            factors: None,
        }
    }

    /// ξ and m from the stages.
    fn end_of_step<const D: usize>(&mut self, problem: &Problem<T, N, D>, tableau: &Tableau<T>, forced: bool) {
        let (h, b) = (problem.step, tableau.b().as_slice());
        self.increment = self.rates.sum(b) * h;
        self.after_impulse = problem.momentum;
        if forced {
            self.after_impulse += self.impulses.sum(b).transpose() * h;
        }
    }
}

/// The forced variational RKMK integrator of a Lagrangian, a force, a retraction and a tableau.
///
/// State (g, μ); the unknowns are the s·N numbers H_i. Nothing is allocated by a step. Source: Martín de Diego and
/// Sato Martín de Almagro 2019, §5.2, restricted to the identities.
#[derive(Clone, Debug)]
pub struct Variational<T: Real, const N: usize, const D: usize, L, F, R> {
    scheme: Scheme<T, L, F, R>,
    settings: Settings<T>,
    work: Work<T, N>,
    collocation: Collocation<T, N>,
    jacobian: Jacobian<T, N>,
    newton: Newton<T>,
    unknowns: Vec<T>,
    origin: Vec<T>,
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
    /// What is taken of what fixed-point iterations find.
    trust: Trust,
}

/// Which of the stage momenta the iterations are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Known {
    /// M_i: with iterations of the equations of motion between evaluations of the scheme.
    InBody,
    /// P_i: with evaluations alone, where they are cheap.
    InChart,
}

/// Why fixed-point iterations alone give no step.
pub(super) enum Uncontracted {
    /// They do not contract, or too slowly to be sure of the branch; so many.
    Slow(usize),
    /// There is no step.
    Refused(StepError),
}

impl From<StepError> for Uncontracted {
    fn from(error: StepError) -> Self {
        Self::Refused(error)
    }
}

/// Fixed-point iterations (so many) that did not lead to a root that can be trusted: they do not contract, or too slowly to
/// be sure of the branch, or a stage left the domain on the way.
struct NotContracted(usize);

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
            origin: vec![T::zero(); s * N],
            last: None,
            predicted: None,
            contraction: 0.0,
            first_residual: None,
            rounded: false,
            trust: Trust::Alone,
        }
    }

    /// Makes the steps of the continuation so many times as long, and what it allows so many times as large: a fault for laws to see.
    #[cfg(feature = "harness")]
    pub(crate) fn stretch_continuation(&mut self, factor: T) {
        self.newton.stretch(factor);
    }

    /// Accepts residuals that are small relative to the largest term, however terms cancel, and however the iterations got there: a fault for laws
    /// to see.
    #[cfg(feature = "harness")]
    pub(crate) fn trust_residuals(&mut self) {
        self.trust = Trust::Residual;
    }

    fn trusts_residuals(&self) -> bool {
        match self.trust {
            Trust::Alone | Trust::Compared => false,
            #[cfg(feature = "harness")]
            Trust::Residual => true,
        }
    }

    /// Leaves it to the caller to see that a root is another than that from h = 0: each step is compared with others, of other sizes.
    pub(super) fn leave_to_comparison(&mut self) {
        self.trust = Trust::Compared;
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
        self.check_stages(rates.len())?;
        self.check_stages(out.len())?;
        (self.last, self.predicted) = (None, None);
        self.scheme.find_dependences::<N>();
        for (i, rate) in rates.iter().enumerate() {
            self.work.rates.set_vector(i, rate);
        }
        self.scheme.mechanics().residual(&Problem::new(state, step), &mut self.work)?;
        for (i, r) in out.iter_mut().enumerate() {
            *r = self.work.next_momenta.covector(i);
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
        self.check_stages(rates.len())?;
        (self.last, self.predicted) = (None, None);
        self.scheme.find_dependences::<N>();
        let problem = Problem::new(state, step);
        let mut equations = StageEquations {
            mechanics: self.scheme.mechanics(),
            problem,
            work: &mut self.work,
            jacobian: &mut self.jacobian,
            full: step,
            most: T::exact(f64::MAX),
        };
        let unknowns: Vec<T> = rates.iter().flat_map(|v| v.iter().copied()).collect();
        let mut jacobian = DMatrix::zeros(unknowns.len(), unknowns.len());
        equations.jacobian(&unknowns, &mut jacobian)?;
        Ok(jacobian)
    }

    /// The step, where fixed-point iterations find it; where they do not, `Err` of so many iterations, or of why there is no step.
    pub(super) fn contract(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, Uncontracted> {
        self.advance(state, h, |_, _, _, spent| Err(Uncontracted::Slow(spent)))
    }

    /// The step, where fixed-point iterations do not find it by `other`.
    fn advance<E: From<StepError>>(
        &mut self,
        state: &mut State<T, N, D>,
        h: T,
        other: impl FnOnce(&mut Self, &Problem<T, N, D>, &Vector<T, N>, usize) -> Result<Report<T>, E>,
    ) -> Result<Report<T>, E> {
        state.check_finite(h)?;
        self.scheme.find_dependences::<N>();
        let mut problem = Problem::new(state, h);
        let guess = if self.last.is_some() { self.work.velocities.vector(0) } else { Vector::zeros() };
        let here = Configuration::of(&state.attitude);
        let eta = self
            .scheme
            .lagrangian
            .velocity_at(state.time, here, &state.momentum, &guess)
            .map_err(|source| StepError::Legendre { step: h.to_f64(), source })?;
        if !finite(self.scheme.total_force(problem.time, here, &eta).0.as_slice()) {
            return Err(self.scheme.mechanics::<N, D>().parts.undefined(None, h, problem.time, here, &eta).into());
        }
        let report = match self.iterate_stages(&mut problem, &eta) {
            Ok(report) => report,
            // A stage may have left the domain only because the fixed-point iterations diverge: Newton's method decides.
            Err(NotContracted(iterations)) => other(self, &problem, &eta, iterations)?,
        };
        let point = self.scheme.retraction.at(&self.work.increment).map_err(|e| domain(h, None, e))?;
        let growth = self.scheme.mechanics::<N, D>().growth(&problem, &self.work, &point.d_neg());
        if growth > T::one() / T::unit_roundoff().sqrt() && !self.trusts_residuals() {
            return Err(StepError::IllConditioned { step: h.to_f64(), growth: growth.to_f64() }.into());
        }
        let momentum = self.work.after_impulse * point.ad();
        let attitude = match self.scheme.retraction.tau(&self.work.increment) {
            Ok(increment) => state.attitude * increment,
            Err(RetractionError::NoGroup { .. }) => state.attitude,
            Err(source) => return Err(domain(h, None, source).into()),
        };
        let next = State { time: state.time + h, momentum, attitude };
        next.check_finite(h)?;
        *state = next;
        self.last = Some((h, momentum));
        self.rounded = problem.rounds();
        Ok(report)
    }

    /// First guess of M_i or P_i and of Ξ_i: the velocity polynomial of the last step, or a constant velocity.
    fn start(&mut self, problem: &Problem<T, N, D>, eta: &Vector<T, N>) {
        let known = self.scheme.known::<N, D>();
        let (scheme, work, momenta) = (&self.scheme, &mut self.work, &mut self.collocation.momenta);
        let s = scheme.coefficients.tableau.stages();
        let this = Some((problem.step, problem.momentum));
        let predicted = self.predicted.take() == this;
        let extrapolation = scheme.coefficients.extrapolation.as_ref().filter(|_| !predicted && self.last == this);
        if let Some(weights) = extrapolation {
            work.next_displacements.combine(weights, &work.velocities);
            std::mem::swap(&mut work.next_displacements, &mut work.velocities);
        }
        match predicted || extrapolation.is_some() {
            true => {
                work.displacements.combine(&scheme.coefficients.weights, &work.velocities);
                for i in 0..s {
                    let x = work.displacements.vector(i) * problem.step;
                    // At the start of the step: it is a guess.
                    let g = Configuration::of(&problem.attitude);
                    let m = scheme.lagrangian.gradient_at(problem.time, g, &work.velocities.vector(i));
                    work.displacements.set_vector(i, &x);
                    match known {
                        Known::InBody => momenta.set_covector(i, &m),
                        Known::InChart => {
                            let p = scheme.retraction.at(&x).map_or(m, |point| pull(&m, point.d()));
                            work.momenta.set_covector(i, &p);
                        }
                    }
                }
            }
            false => {
                for i in 0..s {
                    work.velocities.set_vector(i, eta);
                    work.displacements.set_vector(i, &(eta * (problem.step * scheme.coefficients.tableau.c()[i])));
                    match known {
                        Known::InBody => momenta.set_covector(i, &problem.momentum),
                        Known::InChart => work.momenta.set_covector(i, &problem.momentum),
                    }
                }
            }
        }
    }

    /// Fixed-point iterations until the residual is at the tolerance or at its floor.
    fn fixed_point(&mut self, problem: &Problem<T, N, D>) -> Result<Report<T>, NotContracted> {
        let settings = self.settings;
        let (mut earlier, mut course) = (Course::new(), Course::new());
        let (mut iterations, mut first, mut size) = (0, Course::new(), T::zero());
        let known = self.scheme.known::<N, D>();
        self.collocation.unshift();
        let stages = self.scheme.coefficients.tableau.stages() as i32;
        let mut first_scale = FirstScale::unknown();
        let mut goal = self.first_residual.take().unwrap_or_else(|| T::ratio(1, FIRST_RESIDUAL).powi(stages));
        for _ in 0..settings.max_fixed_point_iterations {
            if known == Known::InBody {
                let guess = self
                    .guess(problem, goal.max(settings.tolerance * T::half()), &mut first_scale)
                    .map_err(|NotContracted(spent)| NotContracted(iterations + spent))?;
                iterations += guess.count();
                if course.count() == 0 {
                    first = guess;
                }
            }
            iterations += 1;
            let (residual, scale) = self
                .scheme
                .iterate::<N, D>(problem, &mut self.work, &mut self.collocation)
                .map_err(|_| NotContracted(iterations))?;
            if !residual.all_finite() || first_scale.is_left(scale) {
                return Err(NotContracted(iterations));
            }
            let before = course;
            course.note(residual);
            if course.count() == 1 {
                size = scale;
            }
            // Above rounding.
            let uneven = residual > settings.floor && self.trust == Trust::Alone && course.is_uneven(&earlier);
            earlier = before;
            self.first_residual = self.first_residual.or(Some(residual));
            if residual <= settings.tolerance || (course.stagnates() && residual <= settings.floor) {
                self.contraction = first.rate().max(course.rate());
                // Those of the guesses count, too: roots behind a fold were found by thirty residuals that fell by half, of five each.
                let evaluations = iterations.saturating_sub(first.count() + 1);
                let refused = match self.trust {
                    Trust::Alone => {
                        course.is_slow_for(i32::try_from(evaluations).unwrap_or(i32::MAX))
                            || (course.is_far([size, scale]) && !self.is_at_rest(problem, &course, [size, scale]))
                    }
                    Trust::Compared => course.is_slow(),
                    #[cfg(feature = "harness")]
                    Trust::Residual => false,
                };
                return if refused {
                    Err(NotContracted(iterations))
                } else {
                    Ok(Report { solver: Solver::FixedPoint, iterations, residual })
                };
            }
            if uneven || course.is_hopeless() {
                return Err(NotContracted(iterations));
            }
            match known {
                Known::InBody => self.scheme.shift::<N, D>(problem, &mut self.work, &mut self.collocation),
                Known::InChart => {
                    std::mem::swap(&mut self.work.next_momenta, &mut self.work.momenta);
                    std::mem::swap(&mut self.work.next_displacements, &mut self.work.displacements);
                }
            }
            goal = residual * T::ratio(1, GUESS_FINER_BY);
        }
        Err(NotContracted(iterations))
    }

    /// Whether a root that is [far](Course::is_far) from where the iteration began is so because that is at rest: all that there is at the root came
    /// [fast](Course::is_fast), and the equations change little up to there.
    #[cold]
    fn is_at_rest(&self, problem: &Problem<T, N, D>, course: &Course<T>, sizes: [T; 2]) -> bool {
        let (scheme, work) = (&self.scheme, &self.work);
        let moved = |j: usize, a: usize| work.rates.get(j, a) * problem.step;
        course.is_fast(sizes)
            && turn::<T, N>(&scheme.coefficients.tableau, scheme.retraction.algebra(), moved) <= T::one()
    }

    /// Iterations on the stages with the difference to the scheme frozen, until they change by no more than `goal`; how they went.
    fn guess(
        &mut self,
        problem: &Problem<T, N, D>,
        goal: T,
        first_scale: &mut FirstScale<T>,
    ) -> Result<Course<T>, NotContracted> {
        let mut course = Course::new();
        for iterations in 1..=self.settings.max_fixed_point_iterations {
            let change = self.scheme.collocate::<N, D>(problem, &mut self.work, &mut self.collocation);
            let Some((change, scale)) = change.filter(|(change, _)| change.all_finite()) else {
                return Err(NotContracted(iterations));
            };
            if first_scale.is_left(scale) {
                return Err(NotContracted(iterations));
            }
            course.note(change);
            let ended = change <= goal || course.stagnates();
            if ended && course.is_slow() || course.is_hopeless() {
                return Err(NotContracted(iterations));
            }
            if ended {
                return Ok(course);
            }
        }
        Err(NotContracted(self.settings.max_fixed_point_iterations))
    }

    /// Newton's method on r(H) along h: at the full step at once it may find a root that does not continue from h = 0.
    fn newton(&mut self, problem: &Problem<T, N, D>, eta: &Vector<T, N>, spent: usize) -> Result<Report<T>, StepError> {
        let (step, factor) = (problem.step.to_f64(), self.work.factors.as_ref().map_or(T::one(), Factors::most));
        for (i, v) in self.origin.iter_mut().enumerate() {
            *v = eta[i % N];
        }
        self.unknowns.copy_from_slice(&self.origin);
        let settings = newton::NewtonSettings {
            tolerance: (self.settings.tolerance / factor).max(Settings::<T>::default().tolerance),
            floor: self.settings.floor,
            max_iterations: self.settings.max_iterations,
        };
        let mechanics = self.scheme.mechanics();
        let mut equations = StageEquations {
            mechanics,
            problem: *problem,
            work: &mut self.work,
            jacobian: &mut self.jacobian,
            full: problem.step,
            most: T::exact(f64::MAX),
        };
        equations.load(&self.origin);
        // Where a stage is outside the domain there, the continuation says what that means.
        if let Ok(first) = mechanics.residual(problem, equations.work)
            && first > T::zero()
        {
            equations.most = first * T::int(HARMLESS_GROWTH);
        }
        let outcome = self.newton.follow(&mut equations, &mut self.unknowns, &settings);
        let refused = |failure| StepError::of_newton(failure, step, settings.tolerance, spent, |error| error);
        let outcome = outcome.map_err(refused)?;
        // Leave the stages of the root in the workspace.
        equations.set_fraction(T::one());
        equations.load(&self.unknowns);
        mechanics.residual(problem, &mut self.work)?;
        let solver = if outcome.shortened { Solver::Continuation } else { Solver::Newton };
        Ok(Report { solver, iterations: outcome.iterations + spent, residual: outcome.residual * factor })
    }
}

impl<T: Real, L, F, R> Scheme<T, L, F, R> {
    /// Asks the Lagrangian and the force what they depend on.
    fn find_dependences<const N: usize>(&mut self)
    where
        L: Lagrangian<T, N>,
        F: Force<T, N>,
    {
        self.moves = self.force.uses_configuration() || self.lagrangian.uses_configuration();
        self.forced = !self.force.is_zero() || self.lagrangian.uses_configuration();
    }

    /// Which of the stage momenta the iterations are on.
    fn known<const N: usize, const D: usize>(&self) -> Known
    where
        R: Retraction<T, N, D>,
    {
        let pays = self.retraction.rough_pays_from() <= self.coefficients.tableau.stages();
        if pays { Known::InBody } else { Known::InChart }
    }

    /// g τ(x).
    fn attitude<S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        problem: &Problem<T, N, D>,
        x: &Vector<S, N>,
    ) -> Result<Matrix<S, D>, RetractionError>
    where
        R: Retraction<T, N, D>,
    {
        Ok(times(&problem.attitude.map(S::lift), &self.retraction.tau(x)?))
    }

    /// ∂L/∂η, l'(η) where nothing depends on the configuration.
    #[inline(always)]
    fn momentum<S: Scalar<Base = T>, const N: usize>(
        &self,
        time: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
    ) -> Covector<S, N>
    where
        L: Lagrangian<T, N>,
    {
        match self.moves {
            true => self.lagrangian.gradient_at(time, g, eta),
            false => self.lagrangian.gradient(eta),
        }
    }

    /// The η with ∂L/∂η = m.
    #[inline(always)]
    fn velocity<const N: usize>(
        &self,
        time: T,
        g: Configuration<'_, T>,
        m: &Covector<T, N>,
        near: &Vector<T, N>,
    ) -> Result<Vector<T, N>, LegendreError>
    where
        L: Lagrangian<T, N>,
    {
        match self.moves {
            true => self.lagrangian.velocity_at(time, g, m, near),
            false => self.lagrangian.velocity(m, near),
        }
    }

    /// ∂_gL + f, and where they depend on the configuration the size of both: they cancel at equilibria.
    #[inline(always)]
    fn total_force<S: Scalar<Base = T>, const N: usize>(
        &self,
        time: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
    ) -> (Covector<S, N>, T)
    where
        L: Lagrangian<T, N>,
        F: Force<T, N>,
    {
        if !self.moves {
            return (self.force.force(time, eta), T::zero());
        }
        let force = self.force.force_at(time, g, eta);
        if !self.lagrangian.uses_configuration() {
            return (force, largest(&force));
        }
        let gradient = self.lagrangian.configuration_gradient(time, g, eta);
        (force + gradient, largest(&force) + largest(&gradient))
    }

    /// One fixed-point iteration: evaluates the stages at (M_i, Ξ_i) or (P_i, Ξ_i), P_i = M_i dτ_{Ξ_i}, leaves m, ξ and the next (P_i, Ξ_i) in
    /// the workspace, and returns the largest relative change |P_i' − P_i|, |Ξ_i' − Ξ_i|: the residual, since
    /// P_i − P_i' = r_i and Ξ_i' = h Σ a_ij H_j; and what that of P_i is relative to.
    fn iterate<const N: usize, const D: usize>(
        &self,
        problem: &Problem<T, N, D>,
        work: &mut Work<T, N>,
        own: &mut Collocation<T, N>,
    ) -> Result<(T, T), StepError>
    where
        L: Lagrangian<T, N>,
        F: Force<T, N>,
        R: Retraction<T, N, D>,
    {
        let Coefficients { tableau, weights, conjugate, .. } = &self.coefficients;
        let (h, mut load, known) = (problem.step, problem.rounding, self.known::<N, D>());
        for i in 0..tableau.stages() {
            let (x, time) = (work.displacements.vector(i), problem.time + tableau.c()[i] * h);
            let point = self.retraction.at(&x).map_err(|e| domain(h, Some(i), e))?;
            let at;
            let g = if self.moves {
                at = self.attitude::<T, N, D>(problem, &x).map_err(|e| domain(h, Some(i), e))?;
                Configuration::of(&at)
            } else {
                Configuration::identity()
            };
            let (p, m) = match known {
                Known::InBody => {
                    let m = own.momenta.covector(i);
                    own.tangents[i] = *point.d_inv();
                    (pull(&m, point.d()), m)
                }
                Known::InChart => {
                    let p = work.momenta.covector(i);
                    (p, pull(&p, point.d_inv()))
                }
            };
            let eta = self
                .velocity(time, g, &m, &work.velocities.vector(i))
                .map_err(|source| StepError::Legendre { step: h.to_f64(), source })?;
            let rate = apply(point.d_inv(), &eta);
            let mut gradient = point.pull_dd(&p, &m, &rate);
            if self.forced {
                let (f, size) = self.total_force(time, g, &eta);
                load = larger(load, size);
                let seen = pull(&f, point.d());
                gradient += seen;
                work.impulses.set_covector(i, &point.pull_ad_inv(&f, &seen));
                if known == Known::InBody {
                    own.forces.set_covector(i, &f);
                }
            }
            work.momenta.set_covector(i, &p);
            work.velocities.set_vector(i, &eta);
            work.rates.set_vector(i, &rate);
            work.gradients.set_covector(i, &gradient);
        }
        work.end_of_step(problem, tableau, self.forced);
        let point = self.retraction.at(&work.increment).map_err(|e| domain(h, None, e))?;
        let end = pull(&work.after_impulse, &point.d_neg());
        if known == Known::InBody {
            (own.tangent_inv, own.coadjoint_inv) = (*point.d_inv(), point.ad_inv());
        }
        let total = work.gradients.sum(tableau.b().as_slice()).transpose() * h;
        work.next_momenta.advance(conjugate, &work.gradients, h, Some(&(end - total)));
        work.next_displacements.advance(weights, &work.rates, h, None);
        let (change, size) = work.next_momenta.change(&work.momenta, work.factors.as_ref().map(|of| &of.momenta));
        let (shift, mut extent) =
            work.next_displacements.change(&work.displacements, work.factors.as_ref().map(|of| &of.displacements));
        let size = larger(size, larger(largest(&end), largest(&total)));
        // Rounding of forces that cancel is relative to them, and displacements are as the momenta.
        let loaded = size.max(load * h.abs());
        if size > T::zero() {
            extent *= loaded / size;
        }
        Ok((larger(relative(change, loaded), relative(shift, extent)), loaded))
    }
}

/// r(H) = 0 with the fraction of the step as parameter.
struct StageEquations<'a, T: Real, const N: usize, const D: usize> {
    mechanics: Mechanics<'a, T, N, D>,
    problem: Problem<T, N, D>,
    work: &'a mut Work<T, N>,
    jacobian: &'a mut Jacobian<T, N>,
    full: T,
    /// The most that residuals are relative to.
    most: T,
}

impl<T: Real, const N: usize, const D: usize> StageEquations<'_, T, N, D> {
    fn load(&mut self, x: &[T]) {
        for i in 0..self.mechanics.coefficients.tableau.stages() {
            self.work.rates.set_vector(i, &Vector::from_fn(|a, _| x[i * N + a]));
        }
    }
}

impl<T: Real, const N: usize, const D: usize> Equations<T> for StageEquations<'_, T, N, D> {
    type Error = StepError;

    fn dimension(&self) -> usize {
        self.mechanics.coefficients.tableau.stages() * N
    }

    fn set_fraction(&mut self, fraction: T) {
        self.problem.step = fraction * self.full;
    }

    fn residual(&mut self, x: &[T], out: &mut [T]) -> Result<T, StepError> {
        self.load(x);
        let size = self.mechanics.residual(&self.problem, self.work)?;
        for (k, value) in out.iter_mut().enumerate() {
            *value = self.work.next_momenta.get(k / N, k % N);
        }
        Ok(if size > self.most { self.most } else { size })
    }

    fn jacobian(&mut self, x: &[T], out: &mut DMatrix<T>) -> Result<(), StepError> {
        self.load(x);
        self.mechanics.jacobian(&self.problem, &self.work.rates, self.jacobian, out)
    }

    /// The largest ‖ad‖ of a change of Ξ_i or ξ, in the unit [`LARGEST_TURN`].
    fn distance(&self, from: (T, &[T]), to: (T, &[T])) -> Option<T> {
        let moved = |j: usize, a: usize| (to.0 * to.1[j * N + a] - from.0 * from.1[j * N + a]) * self.full;
        Some(turn::<T, N>(&self.mechanics.coefficients.tableau, self.mechanics.parts.algebra(), moved))
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
        self.advance(state, h, |method, problem, eta, spent| method.newton(problem, eta, spent))
    }
}

/// The largest ‖ad‖ of Σ_j a_ij x_j and Σ_j b_j x_j, in the unit [`LARGEST_TURN`]; component a of x_j is `rate`(j, a).
pub(crate) fn turn<T: Real, const N: usize>(
    tableau: &Tableau<T>,
    algebra: &LieAlgebra<T, N>,
    rate: impl Fn(usize, usize) -> T,
) -> T {
    let s = tableau.stages();
    let weight = |i: usize, j: usize| if i < s { tableau.a()[(i, j)] } else { tableau.b()[j] };
    let turned = |i: usize| {
        let x = Vector::from_fn(|a, _| (0..s).fold(T::zero(), |sum, j| sum + rate(j, a) * weight(i, j)));
        let rows = algebra.ad(&x);
        rows.row_iter().map(|row| row.iter().fold(T::zero(), |sum, v| sum + v.abs())).fold(T::zero(), larger)
    };
    (0..=s).map(turned).fold(T::zero(), larger) / T::ratio(LARGEST_TURN.0, LARGEST_TURN.1)
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

/// Lagrange weights E with p(1 + c_i) = Σ_j E_ij p(c_j) for polynomials of degree < s; none where two nodes are no further [`LEAST_NODE_DISTANCE`], or a
/// weight is larger than [`LARGEST_WEIGHT`].
pub(super) fn extrapolation<T: Real>(c: &[T]) -> Option<DMatrix<T>> {
    let s = c.len();
    let apart = (0..s).all(|i| (0..i).all(|j| (c[i] - c[j]).abs() > T::exact(LEAST_NODE_DISTANCE)));
    if !apart {
        return None;
    }
    let weights = DMatrix::from_fn(s, s, |i, j| {
        (0..s).filter(|&k| k != j).fold(T::one(), |w, k| w * (T::one() + c[i] - c[k]) / (c[j] - c[k]))
    });
    weights.iter().all(|w| w.abs() < T::exact(LARGEST_WEIGHT)).then_some(weights)
}
