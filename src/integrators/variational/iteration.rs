//! Fixed-point iterations on the stages: what most steps are.

use super::coefficients::Coefficients;
use super::collocation::Collocation;
use super::parts::Parts;
use super::rounding::FirstScale;
use super::work::{Factors, Problem, Work};
use super::{Scheme, Variational, domain, largest, relative, turn};
use crate::algebra::{Vector, apply, pull};
use crate::integrators::stages::Stages;
use crate::integrators::trust::{Arrival, Course, Trend};
use crate::integrators::{Report, Solver, StepError};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, TangentPoint};
use crate::scalar::{Real, larger};

/// The last change of the stages between two evaluations of the scheme is this many times smaller than the residual of the first: the next
/// change would be as much smaller again, and the second evaluation gains little more.
const GUESS_FINER_BY: i64 = 16;

/// The first residual of s stages is expected to be FIRST_RESIDUAL⁻ˢ: that of steps of a quarter of a radian.
const FIRST_RESIDUAL: i64 = 16;

/// Which of the stage momenta the iterations are on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Known {
    /// M_i: with iterations of the equations of motion between evaluations of the scheme.
    InBody,
    /// P_i: with evaluations alone, where they are cheap.
    InChart,
}

/// Fixed-point iterations, by their number, that did not lead to a root that can be trusted: they do not contract, or too slowly to
/// be sure of the branch, or a stage left the domain on the way.
pub(super) struct NotContracted(pub usize);

impl<T, const N: usize, const D: usize, L, F, R> Variational<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// First guess of M_i or P_i and of Ξ_i: the velocity polynomial of the last step, or a constant velocity.
    pub(super) fn start(&mut self, problem: &Problem<T, N, D>, eta: &Vector<T, N>) {
        let known = self.scheme.known();
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
    pub(super) fn fixed_point(&mut self, problem: &Problem<T, N, D>) -> Result<Report<T>, NotContracted> {
        let settings = self.settings;
        let (mut earlier, mut course) = (Course::new(), Course::new());
        let (mut iterations, mut first, mut size) = (0, Course::new(), T::zero());
        let known = self.scheme.known();
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
                .iterate(problem, &mut self.work, &mut self.collocation)
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
            let uneven = residual > settings.floor && !self.compared && course.is_uneven(&earlier);
            earlier = before;
            self.first_residual = self.first_residual.or(Some(residual));
            match course.trend(settings.tolerance, settings.floor) {
                Trend::Settled => {
                    self.contraction = first.rate().max(course.rate());
                    // Those of the guesses count, too: roots behind a fold were found by thirty residuals that fell by half, of five each.
                    let evaluations = iterations.saturating_sub(first.count() + 1);
                    let arrival = Arrival { evaluations, sizes: [size, scale], compared: self.compared };
                    return match course.is_trusted(&arrival, || self.is_within_a_turn(problem)) {
                        true => Ok(Report { solver: Solver::FixedPoint, iterations, residual }),
                        false => Err(NotContracted(iterations)),
                    };
                }
                Trend::Falls if !uneven => {}
                Trend::Falls | Trend::Hopeless => return Err(NotContracted(iterations)),
            }
            match known {
                Known::InBody => self.scheme.shift(problem, &mut self.work, &mut self.collocation),
                Known::InChart => {
                    std::mem::swap(&mut self.work.next_momenta, &mut self.work.momenta);
                    std::mem::swap(&mut self.work.next_displacements, &mut self.work.displacements);
                }
            }
            goal = residual * T::ratio(1, GUESS_FINER_BY);
        }
        Err(NotContracted(iterations))
    }

    /// Whether the displacements are within one [`LARGEST_TURN`](super::newton), as those of an iteration that started at rest are.
    #[cold]
    fn is_within_a_turn(&self, problem: &Problem<T, N, D>) -> bool {
        let (scheme, work) = (&self.scheme, &self.work);
        let moved = |j: usize, a: usize| work.rates.get(j, a) * problem.step;
        turn::<T, N>(&scheme.coefficients.tableau, scheme.retraction.algebra(), moved) <= T::one()
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
            let change = self.scheme.collocate(problem, &mut self.work, &mut self.collocation);
            let Some((change, scale)) = change.filter(|(change, _)| change.all_finite()) else {
                return Err(NotContracted(iterations));
            };
            if first_scale.is_left(scale) {
                return Err(NotContracted(iterations));
            }
            course.note(change);
            match course.trend(goal, change) {
                Trend::Settled if !course.is_slow() && !course.is_hopeless() => return Ok(course),
                Trend::Falls => {}
                Trend::Settled | Trend::Hopeless => return Err(NotContracted(iterations)),
            }
        }
        Err(NotContracted(self.settings.max_fixed_point_iterations))
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Scheme<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    /// Which of the stage momenta the iterations are on.
    fn known(&self) -> Known {
        let pays = self.retraction.rough_pays_from() <= self.coefficients.tableau.stages();
        if pays { Known::InBody } else { Known::InChart }
    }

    /// One fixed-point iteration: evaluates the stages at (M_i, Ξ_i) or (P_i, Ξ_i), P_i = M_i dτ_{Ξ_i}, leaves m, ξ and the next (P_i, Ξ_i) in
    /// the workspace, and returns the largest relative change |P_i' − P_i|, |Ξ_i' − Ξ_i|: the residual, since
    /// P_i − P_i' = r_i and Ξ_i' = h Σ a_ij H_j; and what that of P_i is relative to.
    fn iterate(
        &self,
        problem: &Problem<T, N, D>,
        work: &mut Work<T, N>,
        own: &mut Collocation<T, N>,
    ) -> Result<(T, T), StepError> {
        let Coefficients { tableau, weights, conjugate, .. } = &self.coefficients;
        let (h, mut load, known) = (problem.step, problem.rounding, self.known());
        for i in 0..tableau.stages() {
            let (x, time) = (work.displacements.vector(i), problem.time + tableau.c()[i] * h);
            let point = self.retraction.at(&x).map_err(|e| domain(h, Some(i), e))?;
            let at;
            let g = if self.moves {
                at = Parts::<T, N, D>::attitude(self, &problem.attitude, &x).map_err(|e| domain(h, Some(i), e))?;
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
                let (f, size) = Parts::<T, N, D>::total_force(self, time, g, &eta);
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
        work.end(problem, tableau, self.forced);
        let point = self.retraction.at(&work.increment).map_err(|e| domain(h, None, e))?;
        let end = pull(&work.after_impulse, &point.d_neg());
        if known == Known::InBody {
            (own.tangent_inv, own.coadjoint_inv) = (*point.d_inv(), point.ad_inv());
        }
        let total = work.gradients.sum(tableau.b().as_slice()).transpose() * h;
        work.next_momenta.advance(conjugate, &work.gradients, h, Some(&(end - total)));
        work.next_displacements.advance(weights, &work.rates, h, None);
        let (momenta, displacements) =
            ([&work.next_momenta, &work.momenta], [&work.next_displacements, &work.displacements]);
        let size = larger(largest(&end), largest(&total));
        Ok(relative_change(momenta, displacements, work.factors.as_ref(), [size, load * h.abs()]))
    }
}

/// The largest relative change |P_i' − P_i|, |Ξ_i' − Ξ_i| from the second of each to the first, and what that of P_i is relative to: the momenta, their
/// other terms, of this size, and the impulse of forces that may cancel, since rounding is relative to them. Displacements are as the momenta.
#[inline(always)]
pub(super) fn relative_change<T: Real, const N: usize>(
    momenta: [&Stages<T, N>; 2],
    displacements: [&Stages<T, N>; 2],
    factors: Option<&Factors<T, N>>,
    [other, impulse]: [T; 2],
) -> (T, T) {
    let (change, size) = momenta[0].change(momenta[1], factors.map(|of| &of.momenta));
    let (shift, mut extent) = displacements[0].change(displacements[1], factors.map(|of| &of.displacements));
    let size = larger(size, other);
    let loaded = size.max(impulse);
    if size > T::zero() {
        extent *= loaded / size;
    }
    (larger(relative(change, loaded), relative(shift, extent)), loaded)
}
