//! Laws of the exact discrete Lagrangian: it is antisymmetric, it generates the exact flow, and without force it is a difference of
//! those of G.

use super::super::differences::{compared, slope};
use super::super::legendre::{LEGENDRE_ON_UNITS, LEGENDRE_SIGN, legendre};
use super::super::planted::doubled::{
    COUPLING_SUM, FIRST_COPY_ONLY, HALF_FORCE, LEFT_FOR_RIGHT, NO_FORCE_DERIVATIVE, PLUS, PlantedForced, TIME_SHIFT,
};
use super::super::planted::retraction::SHIFTED;
use super::super::precision::Measured;
use super::super::probe::{stream, unit_of};
use super::super::question::{Answer, Problem, Question, law};
use super::super::{CaseLaw, Source};
use crate::algebra::{Matrix, Vector, elimination, pair};
use crate::discrete::exact::{ExactError, ExactSolution, Start, at_time, collocate};
use crate::group::LieGroup;
use crate::harness::Cost;
use crate::mechanics::Force;
use crate::mechanics::Lagrangian;
use crate::mechanics::doubled::{DoubledLagrangian, MomentumPoint, VelocityError};
use crate::mechanics::hamiltonian::{DoubledHamiltonian, LegendreHamiltonian, modified_legendre};
use crate::retraction::{Retraction, TangentPoint};
use crate::scalar::{Real, larger, max_abs};
use crate::system::System;
use crate::tableau::Family;

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "exact-antisymmetry",
                statement: "l_d^e(W, U⁻¹, V) = −l_d^e(V, U, W) along solutions: from (ψ, U⁻¹, η) they have V and W exchanged and the \
                opposite action",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Prop 5.2",
                oracle: "the solution from the inverse arrow, by Hamilton's equations on g*×G×g* of the Legendre transform of l_f",
                bound: small(
                    6,
                    "floor 2¹¹ N u: 8 stages of a collocation iterated to a few u, over a quarter of the step, 1/16 at most, and a 32nd of the time in which momenta and displacements change"
                ),
                needs: "a group; a force",
                cost: Cost::Heavy,
                faults: &[
                    PLUS,
                    FIRST_COPY_ONLY,
                    COUPLING_SUM,
                    TIME_SHIFT,
                    LEFT_FOR_RIGHT,
                    NO_FORCE_DERIVATIVE,
                    HALF_FORCE,
                ],
                cases: |cases| cases.main_dimensions().forced().with_group(),
                asks: Which::Antisymmetry,
            }),
            law!(Law {
                name: "exact-generates-flow",
                statement: "d/dε l_d^e = ⟨p₁, δ₁⟩ − ⟨p₀, δ₀⟩ along families of solutions, p = (∂l/∂η, ∂l/∂ψ) and δ = (g⁻¹δg, g̃⁻¹δg̃): F⁻ and F⁺ \
                                of l_d^e are the Legendre transforms at the ends",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §5.1 and (2.11); Marsden and West 2001, §1.6",
                oracle: "differences of the action and of V, W over solutions from other initial data",
                bound: apart(6, "2¹¹ N u"),
                needs: "a group",
                cost: Cost::Heavy,
                faults: &[LEFT_FOR_RIGHT, NO_FORCE_DERIVATIVE, HALF_FORCE, LEGENDRE_SIGN, LEGENDRE_ON_UNITS],
                cases: |cases| cases.main_dimensions().with_group().smooth(),
                asks: Which::Generates,
            }),
            law!(Law {
                name: "exact-free",
                statement: "without force l_d^e(V, U, W) = l_h^e(W) − l_h^e(V), whatever U, and F⁺l_h^e(W) = Ad*_W F⁻l_h^e(W): the exact flow is \
                                that of discrete Lie–Poisson equations",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.3, (2.11), and §3, after Thm 3.1",
                oracle: "solutions from (η, U, ψ), (ψ, e, χ) and (η, e, χ), whose actions add up; Ad by conjugation with W",
                bound: small(
                    6,
                    "floor 2⁶ N u: 8 stages of a collocation iterated to a few u, over a quarter of the step, 1/16 at most, and a 32nd of the time in which momenta and displacements change"
                ),
                needs: "a group; no force",
                cost: Cost::Expensive,
                faults: &[PLUS, SHIFTED],
                cases: |cases| cases.main_dimensions().force_free().with_group(),
                asks: Which::Free,
            }),
        ]
    }
}

#[derive(Clone, Copy)]
enum Which {
    Antisymmetry,
    Generates,
    Free,
}

/// A quarter of a step, of 1/16 at most: what truncation leaves of the step is 2⁻³⁴ of itself then, and the solution of a force that is not
/// smooth somewhere has 32 digits in one step of the collocation.
fn quarter<T: Real>(h: T) -> T {
    let (quarter, most) = (h * T::exact(0.25), T::exact(0.0625));
    if quarter.abs() <= most { quarter } else { most * h.signum() }
}

/// That, halved until the momenta change by a 32nd of themselves at most, and displacements by a 32nd: a cubic force takes momenta to infinity in a
/// time of half of 1/rate, a chart of the group has a radius of the order of 1, and the collocation has 32 digits over a twentieth of either.
fn short_part<T: Real, const N: usize, const D: usize>(
    system: &System<T, N, D>,
    time: T,
    velocities: &[Vector<T, N>],
) -> T {
    let rate = |eta: &Vector<T, N>| {
        let m = system.lagrangian.gradient(eta);
        let slope = system.algebra.coad(eta, &m) + system.force.force(time, eta);
        [(slope.amax(), m.amax()), (eta.amax().max(system.algebra.ad(eta).amax()), T::one())]
    };
    let rates: Vec<(T, T)> = velocities.iter().flat_map(rate).collect();
    let mut h = quarter(system.step);
    while rates.iter().any(|(slope, m)| *m > T::zero() && *slope * h.abs() * T::int(32) > *m)
        && h.abs() > T::exact(SHORTEST)
    {
        h *= T::half();
    }
    h
}

/// No shorter part of a step is taken, whatever the force.
const SHORTEST: f64 = 1.0 / 16384.0;

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::EXACT_SOLUTION);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let measured = match self {
            Self::Antisymmetry => antisymmetry(&mut problem),
            Self::Generates => generates(&mut problem),
            Self::Free => free(&mut problem),
        };
        measured.map_err(|error| match error {
            ExactError::Equations { source: VelocityError::Domain(_), .. } => {
                Measured::NotApplicable("the solution leaves the domain of the retraction".into())
            }
            ExactError::Equations { source: VelocityError::Legendre(_), .. } => {
                Measured::NotApplicable("l_f is not regular so far off the units".into())
            }
            other => other.into(),
        })
    }
}

/// The stages of a collocation, of order 16.
const STAGES: usize = 8;

/// The end of a solution.
struct End<T: Real, const D: usize> {
    v: Matrix<T, D>,
    w: Matrix<T, D>,
    action: T,
}

/// Where a solution of Hamilton's equations on g*×G×g* is after a step, in the coordinates (λ, μ, X, Y, action), V = τ(X), W = τ(Y): no
/// accelerations.
fn canonical_end<T: Real, const N: usize, const D: usize>(
    hamiltonian: &LegendreHamiltonian<impl DoubledLagrangian<T, N, D>>,
    system: &System<T, N, D>,
    step: T,
    start: &Start<T, N, D>,
) -> Result<End<T, D>, ExactError> {
    let (doubled, algebra, retraction) = (&hamiltonian.doubled, &system.algebra, &system.retraction);
    let momenta = modified_legendre(doubled, start).map_err(at_time(start.time))?;
    let momenta = momenta.lambda.iter().chain(&momenta.mu).copied();
    let mut state: Vec<T> = momenta.chain(std::iter::repeat_n(T::zero(), 2 * N + 1)).collect();
    let rate = |t: T, state: &[T]| -> Result<Vec<T>, VelocityError> {
        let [lambda, mu, x, y] = [0, 1, 2, 3].map(|k| part::<T, N>(state, k));
        let (lambda, mu) = (lambda.transpose(), mu.transpose());
        let u = retraction.tau(&-x)? * start.u * retraction.tau(&y)?;
        let slopes = hamiltonian.partials(&MomentumPoint { time: t, lambda, u, mu })?;
        let (eta, psi) = (-slopes.lambda, slopes.mu);
        let lambda_rate = algebra.coad(&eta, &lambda) - slopes.right;
        let mu_rate = algebra.coad(&psi, &mu) - slopes.left;
        let (x_rate, y_rate) = (retraction.at(&x)?.d_inv() * eta, retraction.at(&y)?.d_inv() * psi);
        let action = doubled.value(&Start { time: t, eta, u, psi })?;
        Ok(lambda_rate.iter().chain(&mu_rate).chain(&x_rate).chain(&y_rate).copied().chain([action]).collect())
    };
    let gauss = Family::Gauss.tableau(STAGES)?;
    collocate(&gauss, start.time, step, &mut state, None, &mut |t, state| rate(t, state).map_err(at_time(t)))?;
    let tau = |k: usize| retraction.tau(&part(&state, k)).map_err(at_time(start.time));
    Ok(End { v: tau(2)?, w: tau(3)?, action: state[4 * N] })
}

/// The k-th N numbers of a list.
fn part<T: Real, const N: usize>(state: &[T], k: usize) -> Vector<T, N> {
    Vector::from_column_slice(&state[k * N..(k + 1) * N])
}

/// A point near the motion of the system, off the units.
fn start<T: Real, const N: usize, const D: usize>(
    problem: &mut Problem<'_, T, N, D>,
) -> Result<Start<T, N, D>, ExactError> {
    problem.off_the_units(0.125, 1.0 / 16.0).map_err(at_time(problem.system.state.time))
}

/// A solution that ends nowhere.
const NOWHERE: ExactError = ExactError::NotConverged { step: 0.0, change: 0.0, iterations: 0 };

/// A measurement, or why a solution could not be followed.
type Followed = Result<Measured, ExactError>;

fn antisymmetry<T: Real, const N: usize, const D: usize>(problem: &mut Problem<'_, T, N, D>) -> Followed {
    let Start { time, eta, u, psi } = start(problem)?;
    let Problem { system, fault, .. } = *problem;
    let l = &system.lagrangian;
    let Some(inverse) = elimination::inverse(&u) else {
        return Ok(Measured::Broken("τ(x) is a singular matrix".into()));
    };
    let planted = PlantedForced::of(system, fault);
    let exact = ExactSolution::new(planted, &system.retraction, STAGES)?;
    let h = short_part(system, time, &[eta, psi]);
    let there = exact.at(&Start { time, eta, u, psi }, &[h])?;
    let [there] = there.as_slice() else {
        return Ok(Measured::Broken("one time gave another number of points".into()));
    };
    let hamiltonian = LegendreHamiltonian::new(PlantedForced::of(system, None));
    let back = canonical_end(&hamiltonian, system, h, &Start { time, eta: psi, u: inverse, psi: eta })?;
    let floor = 2048.0 * system.dimension as f64;
    let rate = planted.value(&Start { time, eta, u, psi }).map_err(at_time(time))?.abs();
    let energies = l.value(&eta).abs() + l.value(&psi).abs() + rate;
    let action = Measured::defect((there.action + back.action).abs(), energies * h.abs(), floor, || {
        format!("actions {:e} and {:e}", there.action.to_f64(), back.action.to_f64())
    });
    let ends = larger(max_abs(&(there.v - back.w)), max_abs(&(there.w - back.v)));
    let size = there.v.amax().max(there.w.amax());
    Ok(action.and(Measured::defect(ends, size, floor, || "V and W are not exchanged".into())))
}

fn generates<T: Real, const N: usize, const D: usize>(problem: &mut Problem<'_, T, N, D>) -> Followed {
    let begin = start(problem)?;
    let Problem { system, probe, fault, .. } = problem;
    let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
    let [first, turn, second] = [probe.vector::<T, N>(), probe.vector(), probe.vector()];
    let planted = PlantedForced::of(system, *fault);
    let exact = ExactSolution::new(planted, &system.retraction, STAGES)?;
    // Velocities move by as much as they are, U by as much as a step does.
    let speed = begin.eta.amax().max(T::exact(0.25));
    let end = |s: T| {
        let (eta, psi) = (begin.eta + first * (speed * s), begin.psi + second * (speed * s));
        let u = begin.u * r.tau(&(turn * s)).map_err(at_time(begin.time))?;
        exact.at(&Start { eta, u, psi, ..begin }, &[quarter(system.step)])?.pop().ok_or(NOWHERE)
    };
    let here = end(T::zero())?;
    let momenta = |point: &Start<T, N, D>| legendre(&planted, point, *fault).map_err(at_time(point.time));
    let before = momenta(&begin)?.mu;
    let MomentumPoint { lambda, mu, .. } = momenta(&here.point)?;
    let tangent = |x: &Vector<T, N>| r.at(x).map(|point| *point.d()).map_err(at_time(here.point.time));
    let (lambda, partner) = (lambda * tangent(&here.x)?, mu * tangent(&here.y)?);
    // The action without what V and W contribute to its derivative: left is what U₀ does.
    let mut stopped = None;
    let value = |s: T| {
        let moved = end(s).map_err(|error| stopped = Some(error)).ok()?;
        Some(moved.action + pair(&lambda, &(moved.x - here.x)) - pair(&partner, &(moved.y - here.y)))
    };
    let rate = l.value(&begin.eta).abs() + l.value(&begin.psi).abs();
    let force = f.force(begin.time, &begin.eta).amax() + f.force(begin.time, &begin.psi).amax();
    let moved = speed * quarter(system.step).abs();
    let terms = (rate + force) * quarter(system.step).abs()
        + lambda.amax() * here.x.amax().max(moved)
        + partner.amax() * here.y.amax().max(moved);
    let floor = 2048.0 * system.dimension as f64;
    let differences = slope(value, T::exact(0.25), terms * T::int(16 * system.dimension as i64));
    let Some(differences) = differences else {
        return Err(stopped.unwrap_or(NOWHERE));
    };
    let Some(group) = &system.group else {
        return Ok(Measured::NotApplicable("the algebra has no group".into()));
    };
    let Some(back) = group.inverse(&here.w).and_then(|inverse| group.adjoint(&inverse)) else {
        return Ok(Measured::Broken("W is a singular matrix".into()));
    };
    let found = pair(&mu, &(back * turn)) - pair(&before, &turn);
    let size = mu.amax() * back.amax() + before.amax();
    Ok(compared(found, &differences, size, terms, floor, "⟨p₁, δ₁⟩ − ⟨p₀, δ₀⟩ against δl_d^e"))
}

fn free<T: Real, const N: usize, const D: usize>(problem: &mut Problem<'_, T, N, D>) -> Followed {
    let begin = start(problem)?;
    let Problem { system, probe, fault, .. } = problem;
    let l = &system.lagrangian;
    let third = begin.eta - probe.vector::<T, N>() * (unit_of(&begin.eta) * T::exact(0.125));
    let planted = PlantedForced::of(system, *fault);
    let exact = ExactSolution::new(planted, &system.retraction, STAGES)?;
    let h = short_part(system, begin.time, &[begin.eta, begin.psi, third]);
    let end = |eta: Vector<T, N>, u: Matrix<T, D>, psi: Vector<T, N>| {
        exact.at(&Start { time: begin.time, eta, u, psi }, &[h])?.pop().ok_or(NOWHERE)
    };
    let one = end(begin.eta, begin.u, begin.psi)?;
    let two = end(begin.psi, Matrix::identity(), third)?;
    let both = end(begin.eta, Matrix::identity(), third)?;
    let floor = 64.0 * system.dimension as f64;
    let energies = l.value(&begin.eta).abs() + l.value(&begin.psi).abs() + l.value(&third).abs();
    let action = one.action + two.action - both.action;
    let sum = Measured::defect(action.abs(), energies * h.abs(), floor, || {
        let [one, two, both] = [one.action, two.action, both.action].map(|v| v.to_f64());
        format!("actions {one:e} and {two:e}, together {both:e}")
    });
    let ad = system.group.as_ref().and_then(|group| group.adjoint(&one.w));
    let Some(ad) = ad else { return Ok(Measured::Broken("W is a singular matrix".into())) };
    let momentum = l.gradient(&begin.psi);
    let moved = l.gradient(&one.point.psi) - momentum * ad;
    let size = momentum.amax() * ad.amax();
    let flow = Measured::defect(moved.amax(), size, floor, || {
        format!("F⁺l_h^e(W) and Ad*_W F⁻l_h^e(W) differ by {:e}", moved.amax().to_f64())
    });
    Ok(sum.and(flow))
}
