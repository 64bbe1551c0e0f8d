//! Laws of the doubled scheme on g*×G×g*: on the units it is the restricted scheme, off them it keeps its momentum map.

use super::planted::doubled::{HALF_FORCE, LEFT_FOR_RIGHT, NO_FORCE_DERIVATIVE, PlantedForced};
use super::planted::retraction::{ADJOINT_INVERTED, RIGHT_TANGENT, SHIFTED};
use super::planted::step::{CHART, FIRST_STAGE, FORCE_INDEX, FORCE_TIME, NO_FORCE, NOT_TRANSPORTED, UNCONJUGATED};
use super::probe::{stream, unit_of};
use super::question::{Answer, Measured, Problem, Question, law};
use super::step::{show, subject};
use super::{CaseLaw, Source};
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::LieGroup;
use crate::harness::Cost;
use crate::integrators::doubled::{Doubled, DoubledState};
use crate::integrators::{OneStep, StepError};
use crate::mechanics::Lagrangian;
use crate::mechanics::doubled::{MomentumPoint, VelocityError};
use crate::mechanics::hamiltonian::modified_legendre;
use crate::retraction::AnyRetraction;
use crate::scalar::{Real, max_abs};
use nalgebra::DMatrix;

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "doubled-restriction",
                statement: "the doubled step started on a unit (μ, e, μ) ends on one, and its μ is the restricted step's",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §5.2 and Thm 5.3",
                oracle: "the doubled scheme on (λ, U, μ), which shares no residual with the restricted one",
                bound: small(6, "floor 2⁹ s N u: two solves, the doubled one of twice the size"),
                needs: "a group",
                cost: Cost::Moderate,
                faults: &[
                    CHART,
                    FORCE_INDEX,
                    UNCONJUGATED,
                    NO_FORCE,
                    NOT_TRANSPORTED,
                    FIRST_STAGE,
                    FORCE_TIME,
                    RIGHT_TANGENT,
                    HALF_FORCE,
                ],
                cases: |cases| cases.with_group(),
                asks: Restriction,
            }),
            law!(Law {
                name: "doubled-splitting",
                statement: "on a unit the Jacobian of the doubled stage equations is [[A, B], [B, A]], and A + B is that of the \
                    restricted ones",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §5.2, proof of Thm 5.3",
                oracle: "the Jacobian of the restricted scheme, which shares no residual with the doubled one",
                bound: small(6, "floor 2⁸ s N u relative to the largest entry"),
                needs: "a group; a force",
                cost: Cost::Moderate,
                faults: &[HALF_FORCE, NO_FORCE_DERIVATIVE, LEFT_FOR_RIGHT],
                cases: |cases| cases.with_group().forced(),
                asks: Splitting,
            }),
            law!(Law {
                name: "doubled-momentum-map",
                statement: "Ad*_{g̃⁻¹} μ − Ad*_{g⁻¹} λ is constant along the doubled flow, off the units too",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §3 and §5: the diagonal action on G×G and Noether's \
                 theorem",
                oracle: "Ad by conjugation with the attitude matrices g and g̃, which the momenta do not see",
                bound: small(3, "floor 2⁹ s N u a step"),
                needs: "a group; a force; an algebra that is not abelian",
                cost: Cost::Moderate,
                faults: &[LEFT_FOR_RIGHT, ADJOINT_INVERTED, SHIFTED],
                cases: |cases| cases.with_group().forced_nonabelian(),
                asks: MomentumMap,
            }),
        ]
    }
}

/// The scheme on a system.
fn scheme<'a, T: Real, const N: usize, const D: usize>(
    problem: &Problem<'a, T, N, D>,
) -> Doubled<T, PlantedForced<'a, T, N, D>, &'a AnyRetraction<T, N, D>, N, D> {
    let system = problem.system;
    Doubled::new(system.tableau.clone(), &system.retraction, PlantedForced::of(system, problem.fault))
}

#[derive(Clone, Copy)]
struct Restriction;

impl Question for Restriction {
    const LARGE: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let system = problem.system;
        let floor = 512.0 * (system.tableau.stages() * system.dimension) as f64;
        let mut unit = DoubledState::unit(system.state.time, system.state.momentum);
        let mut restricted = system.state.clone();
        subject(system, problem.fault).step(&mut restricted, system.step)?;
        scheme(&problem).step(&mut unit, system.step)?;
        let size = max_abs(&restricted.momentum);
        let relative = unit.relative - Matrix::<T, D>::identity();
        let off = Measured::defect(max_abs(&relative), T::one(), floor, || "U' ≠ e".into());
        let split = Measured::defect(max_abs(&(unit.lambda - unit.mu)), size, floor, || {
            format!("λ' = {}, μ' = {}", show(&unit.lambda), show(&unit.mu))
        });
        let same = Measured::defect(max_abs(&(unit.mu - restricted.momentum)), size, floor, || {
            format!("restricted μ' = {}, doubled μ' = {}", show(&restricted.momentum), show(&unit.mu))
        });
        Ok(off.and(split).and(same))
    }
}

/// At stage values that need not solve the equations: the identity holds there too.
#[derive(Clone, Copy)]
struct Splitting;

impl Question for Splitting {
    const STREAM: Option<u64> = Some(stream::DOUBLED_STAGES);

    const LARGE: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let system = problem.system;
        let (start, h) = (&system.state, system.step);
        let legendre = |source| StepError::Legendre { step: h.to_f64(), source };
        let eta = system.lagrangian.velocity(&start.momentum, &Vector::zeros()).map_err(legendre)?;
        let spread = unit_of(&eta) * T::exact(0.125);
        let rates: Vec<Vector<T, N>> =
            (0..system.tableau.stages()).map(|_| eta + problem.probe.vector::<T, N>() * spread).collect();
        let unit = DoubledState::unit(start.time, start.momentum);
        let both = scheme(&problem).stage_jacobian(&unit, h, &rates, &rates)?;
        let restricted = system.scheme().stage_jacobian(start, h, &rates)?;
        Ok(split(&both, &restricted))
    }
}

#[derive(Clone, Copy)]
struct MomentumMap;

impl Question for MomentumMap {
    const STREAM: Option<u64> = Some(stream::DOUBLED_STATE);

    const LARGE: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let (system, group) = (problem.system, problem.group()?);
        let h = system.step;
        let of_step = |error: VelocityError| match error {
            VelocityError::Legendre(source) => StepError::Legendre { step: h.to_f64(), source },
            VelocityError::Domain(source) => StepError::Domain { step: h.to_f64(), stage: None, source },
        };
        let point = problem.off_the_units(0.125, 1.0 / 32.0).map_err(of_step)?;
        let momenta = modified_legendre(&PlantedForced::of(system, problem.fault), &point);
        let MomentumPoint { time, lambda, u, mu } = momenta.map_err(|error| of_step(error.into()))?;
        let attitude = system.state.attitude;
        let mut state = DoubledState { time, lambda, relative: u, mu, attitudes: Some((attitude, attitude * u)) };
        let singular = || Measured::Broken("an attitude is a singular matrix".into());
        let (before, size) = noether(group, &state).ok_or_else(singular)?;
        let mut doubled = scheme(&problem);
        for _ in 0..STEPS {
            doubled.step(&mut state, h)?;
        }
        let (after, other) = noether(group, &state).ok_or_else(singular)?;
        let floor = 512.0 * (STEPS * system.tableau.stages() * system.dimension) as f64;
        Ok(Measured::defect(max_abs(&(after - before)), size + other, floor, || {
            format!("Ad*_(g̃⁻¹) μ − Ad*_(g⁻¹) λ went from {} to {}", show(&before), show(&after))
        }))
    }
}

/// Steps of a doubled trajectory.
const STEPS: usize = 2;

/// Ad*_{g̃⁻¹} μ − Ad*_{g⁻¹} λ, and the size of its terms: |μ| |Ad| |g| |g⁻¹|, since rounding of g by u moves g⁻¹ by |g⁻¹|² |g| u.
fn noether<T: Real, const N: usize, const D: usize>(
    group: &impl LieGroup<T, N, D>,
    state: &DoubledState<T, N, D>,
) -> Option<(Covector<T, N>, T)> {
    let (g, partner) = state.attitudes.as_ref()?;
    let spatial = |g: &Matrix<T, D>, mu: &Covector<T, N>| {
        let inverse = group.inverse(g)?;
        let (ad, condition) = (group.adjoint(&inverse)?, g.amax().max(T::one()) * inverse.amax().max(T::one()));
        Some((mu * ad, mu.amax() * ad.amax() * condition))
    };
    let ((first, a), (second, b)) = (spatial(g, &state.lambda)?, spatial(partner, &state.mu)?);
    Some((second - first, a + b))
}

/// Whether `both` is [[A, B], [B, A]] with A + B = `restricted`.
fn split<T: Real>(both: &DMatrix<T>, restricted: &DMatrix<T>) -> Measured {
    let n = restricted.nrows();
    let block = |i: usize, j: usize| both.view((i * n, j * n), (n, n)).into_owned();
    let [[a, b], [c, d]] = [[block(0, 0), block(0, 1)], [block(1, 0), block(1, 1)]];
    let size = max_abs(both.iter().chain(restricted));
    let near = |what: &'static str, x: &DMatrix<T>, y: &DMatrix<T>| {
        Measured::defect(max_abs(&(x - y)), size, 256.0 * n as f64, || what.into())
    };
    near("∂r_λ/∂H ≠ ∂r_μ/∂Ψ", &a, &d).and(near("∂r_λ/∂Ψ ≠ ∂r_μ/∂H", &b, &c)).and(near(
        "A + B is not the restricted Jacobian",
        &(&c + &d),
        restricted,
    ))
}
