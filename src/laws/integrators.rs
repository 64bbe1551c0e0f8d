//! Laws of one step, or of a few: what holds to round-off at any step size and for any tableau.

use super::planted::retraction::{
    ADJOINT_INVERTED, BERNOULLI, SECOND_MISSING, SECOND_OF_INVERSE, SECOND_SIGN, SECOND_SWAPPED, SHIFTED,
};
use super::planted::step::{
    BALANCE, CHART, EQUATIONS, FROM_LEFT, HALVED, INVERSE_SECOND, INVERTED, LOOSE_TOLERANCE, NO_SECOND, NO_STEP,
    ORDER_TWO, PlantedStep, SWAPPED_SECOND, UNCONJUGATED, joined,
};
use super::planted::tableau::COEFFICIENT;
use super::question::{Answer, Measured, Problem, Question, law};
use super::sizes::poisson;
use super::step::{show, subject};
use super::{CaseLaw, Source};
use crate::algebra::{Covector, Matrix};
use crate::group::LieGroup;
use crate::harness::Cost;
use crate::integrators::{OneStep, StagePoint, State, StepError};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::scalar::{Real, max_abs};

pub(super) const SCHEME: &str = "Martín de Diego and Sato Martín de Almagro 2019, §5.2";
/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "plain-step",
                statement: "the integrator's step solves the stage equations r_i = 0 as they are written down",
                source: SCHEME,
                oracle: "a transcription of the equations with its own loops and Newton's method on H",
                bound: small(9, "floor 2⁸ s N u: both stop at a relative residual of a few u in s N equations"),
                needs: "",
                faults: &joined::<15, 2, 17>(EQUATIONS, [COEFFICIENT, LOOSE_TOLERANCE]),
                cases: |cases| cases,
                asks: PlainStep,
            }),
            law!(Law {
                name: "discrete-noether",
                statement: "Ad*_{g'⁻¹} μ' − Ad*_{g⁻¹} μ = h Σ b_j Ad*_{g_j⁻¹} f_j, g_j = g τ(Ξ_j): the spatial momentum changes by the \
                                impulses of the stages, at any step and for any tableau",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §5.2; Marsden and West 2001, §3.2, the forced discrete \
                             Noether theorem",
                oracle: "Ad by conjugation with group elements; the step has it from dτ",
                bound: small(9, "floor 2² s N² u of the terms"),
                needs: "a group",
                faults: &joined::<9, 1, 10>(BALANCE, [ADJOINT_INVERTED]),
                cases: |cases| cases.with_group(),
                asks: Noether,
            }),
            law!(Law {
                name: "free-casimirs",
                statement: "without force C(μ_n) = C(μ_0) for every Casimir C, any tableau, any step",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §5.3.1, where it is only observed; μ' = Ad*_{τ(ξ)} μ",
                oracle: "the Casimir, a polynomial that the integrator does not know",
                bound: both("floor 2⁵ N² u a step"),
                needs: "no force; an algebra that is not abelian",
                faults: &[CHART, HALVED],
                cases: |cases| cases.force_free().nonabelian(),
                asks: FreeLaw::Casimirs,
            }),
            law!(Law {
                name: "free-coadjoint-orbit",
                statement: "without force the spatial momentum Ad*_{g⁻¹} μ is constant",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2; Noether's theorem for left translations",
                oracle: "Ad by conjugation with the attitude matrix; the step has it from dτ",
                bound: both("floor 2⁵ N² u a step"),
                needs: "a group; no force; an algebra that is not abelian",
                cost: Cost::Moderate,
                faults: &[CHART, HALVED, INVERTED, FROM_LEFT, ORDER_TWO, SHIFTED, ADJOINT_INVERTED],
                cases: |cases| cases.force_free().with_group().nonabelian(),
                asks: FreeLaw::Orbit,
            }),
            law!(Law {
                name: "free-poisson-map",
                statement: "without force J Π(μ) Jᵀ = Π(Φ(μ)) with J = Φ'(μ), Π_ab = −C^d_ab μ_d",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2 and §2.3",
                oracle: "J by fourth-order differences of whole steps, Π from the structure constants",
                bound: small(
                    6,
                    "u/ε at ε = 2⁻¹² (f64) or 2⁻²⁴ (dd), times 2¹² for the residual of a step; s N > ",
                    ": in dd in one case of ten and above the bound in f64"
                ),
                needs: "no force; an algebra that is not abelian",
                cost: Cost::Moderate,
                faults: &[
                    CHART,
                    UNCONJUGATED,
                    NO_SECOND,
                    INVERSE_SECOND,
                    SWAPPED_SECOND,
                    NO_STEP,
                    HALVED,
                    SECOND_MISSING,
                    SECOND_SIGN,
                    SECOND_SWAPPED,
                    SECOND_OF_INVERSE,
                    BERNOULLI,
                ],
                cases: |cases| cases.force_free().nonabelian(),
                asks: PoissonMap,
            }),
        ]
    }
}

/// Ad*_{g⁻¹} μ, and the size of its terms: rounding of g by u moves g⁻¹ by |g⁻¹|² |g| u. `None` where g is singular.
pub(super) fn spatial<T: Real, const N: usize, const D: usize>(
    group: &impl LieGroup<T, N, D>,
    g: &Matrix<T, D>,
    mu: &Covector<T, N>,
) -> Option<(Covector<T, N>, T)> {
    let inverse = group.inverse(g)?;
    let ad = group.adjoint(&inverse)?;
    let size = mu.amax() * ad.amax() * g.amax().max(T::one()) * inverse.amax().max(T::one());
    Some((mu * ad, size))
}

/// The step against the plain one.
#[derive(Clone, Copy)]
pub(super) struct PlainStep;

impl Question for PlainStep {
    const LARGE: bool = true;

    const KNOWS_CONFIGURATION: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let system = problem.system;
        let (mut mine, mut theirs) = (system.state.clone(), system.state.clone());
        subject(system, problem.fault).step(&mut mine, system.step)?;
        PlantedStep::new(system, None).step(&mut theirs, system.step)?;
        let floor = 256.0 * (system.tableau.stages() * system.dimension) as f64;
        let off = max_abs(&(mine.momentum - theirs.momentum));
        let momentum = Measured::defect(off, max_abs(&theirs.momentum), floor, || {
            format!("μ' = {}, expected {}", show(&mine.momentum), show(&theirs.momentum))
        });
        let off = max_abs(&(mine.attitude - theirs.attitude));
        Ok(momentum.and(Measured::defect(off, max_abs(&theirs.attitude), floor, || "the attitudes differ".into())))
    }
}

/// The balance of the spatial momentum in a step.
#[derive(Clone, Copy)]
pub(super) struct Noether;

impl Question for Noether {
    const LARGE: bool = true;

    const KNOWS_CONFIGURATION: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let (system, fault, group) = (problem.system, problem.fault, problem.group()?);
        let (l, f) = (&system.lagrangian, &system.force);
        let (start, h) = (&system.state, system.step);
        // A unit of round-off of g moves g⁻¹ by more than itself: nothing is known of the spatial momentum.
        let condition = group.inverse(&start.attitude).map(|inverse| inverse.amax() * start.attitude.amax());
        if condition.is_none_or(|condition| condition * T::unit_roundoff() >= T::one()) {
            return Err(Measured::NotApplicable("the attitude is singular to working precision".into()));
        }
        // The stages are those of the right step, whatever is planted in the one that is judged.
        let mut stages = system.scheme();
        let mut end = start.clone();
        stages.step(&mut end, h)?;
        if fault.is_some() {
            end = start.clone();
            subject(system, fault).step(&mut end, h)?;
        }
        let mut size = T::zero();
        let mut spatial = |g: &Matrix<T, D>, mu: Covector<T, N>| {
            let (momentum, terms) = spatial(group, g, &mu)?;
            size += terms;
            Some(momentum)
        };
        let mut defect = || {
            let mut change = spatial(&end.attitude, end.momentum)? - spatial(&start.attitude, start.momentum)?;
            let (b, c) = (system.tableau.b(), system.tableau.c());
            for (j, StagePoint { turn, velocity, .. }) in stages.stages()?.into_iter().enumerate() {
                let g = start.attitude * turn;
                let (time, there) = (start.time + c[j] * h, Configuration::of(&g));
                let force = f.force_at(time, there, &velocity) + l.configuration_gradient(time, there, &velocity);
                change -= spatial(&g, force * (b[j] * h))?;
            }
            Some(change)
        };
        let defect = defect().ok_or_else(|| Measured::Broken("a group element is a singular matrix".into()))?;
        let floor = 4.0 * (system.tableau.stages() * system.dimension * system.dimension) as f64;
        Ok(Measured::defect(max_abs(&defect), size, floor, || {
            format!("the spatial momentum changes by {} more than the impulses", show(&defect))
        }))
    }
}

#[derive(Clone, Copy)]
enum FreeLaw {
    Casimirs,
    Orbit,
}

/// Steps of a free trajectory.
const FREE_STEPS: usize = 3;

impl Question for FreeLaw {
    const LARGE: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let (system, start) = (problem.system, &problem.system.state);
        let floor = 32.0 * (system.dimension * system.dimension * FREE_STEPS) as f64;
        let end = || {
            let (mut state, mut method) = (start.clone(), subject(system, problem.fault));
            (0..FREE_STEPS).try_for_each(|_| method.step(&mut state, system.step).map(|_| ()))?;
            Ok::<_, StepError>(state)
        };
        match self {
            Self::Casimirs if system.casimirs.is_empty() => {
                Err(Measured::NotApplicable("no Casimir of the algebra is known".into()))
            }
            Self::Casimirs => {
                let (before, after) = (start.momentum, end()?.momentum);
                let kept = system.casimirs.iter().map(|casimir| {
                    // The size of the terms that cancel in C.
                    let size = casimir.size(before.amax()).max(casimir.size(after.amax()));
                    let (old, new) = (casimir.value(&before), casimir.value(&after));
                    Measured::defect((new - old).abs(), size, floor, || {
                        format!("C changed from {:.17e} by {:.3e}", old.to_f64(), (new - old).to_f64())
                    })
                });
                Ok(kept.fold(Measured::exact(), Measured::and))
            }
            Self::Orbit => {
                let (group, end) = (problem.group()?, end()?);
                let spatial = |state: &State<T, N, D>| {
                    let ad = group.adjoint(&group.inverse(&state.attitude)?)?;
                    Some((state.momentum * ad, state.momentum.amax() * ad.amax()))
                };
                let both = spatial(start).zip(spatial(&end));
                let ((old, size), (new, other)) =
                    both.ok_or_else(|| Measured::Broken("the attitude is a singular matrix".into()))?;
                Ok(Measured::defect(max_abs(&(new - old)), size.max(other), floor, || {
                    format!("Ad*_(g⁻¹) μ went from {} to {}", show(&old), show(&new))
                }))
            }
        }
    }
}

#[derive(Clone, Copy)]
struct PoissonMap;

impl Question for PoissonMap {
    const LARGE: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let system = problem.system;
        let mut method = subject(system, problem.fault);
        let mut image = |mu: &Covector<T, N>| {
            let mut state = State { momentum: *mu, ..system.state.clone() };
            method.step(&mut state, system.step).map(|_| state.momentum)
        };
        let mu = system.state.momentum;
        // Rounding decides, not truncation: u/ε is 2⁻⁴¹ in f64 and 2⁻⁷⁹ in double-double, ε⁴ 2⁻⁴⁸ and 2⁻⁹⁶.
        let exponent = if T::unit_roundoff() < T::exact(1e-20) { -24 } else { -12 };
        let relative = T::exact(2f64.powi(exponent));
        let epsilon = relative * mu.amax();
        if epsilon == T::zero() {
            return Err(Measured::NotApplicable("at rest".into()));
        }
        let mut jacobian = Matrix::<T, N>::zeros();
        for a in 0..N {
            let mut at = |k: i64| {
                let mut moved = mu;
                moved[a] += T::int(k) * epsilon;
                image(&moved)
            };
            let column = (at(1)? - at(-1)?) * T::int(8) - (at(2)? - at(-2)?);
            jacobian.set_column(a, &(column.transpose() / (epsilon * T::int(12))));
        }
        let end = image(&mu)?;
        // Π may vanish where its terms do not.
        let ((before, terms), (after, others)) =
            (poisson(&problem.system.algebra, &mu), poisson(&problem.system.algebra, &end));
        let defect = jacobian * before * jacobian.transpose() - after;
        let stretch = jacobian.amax().max(T::one());
        let size = stretch * stretch * terms.max(others);
        let noise = (T::one() / relative).to_f64();
        Ok(Measured::defect(max_abs(&defect), size, 4096.0 * noise, || {
            format!("Φ(μ) = {}, |J Π Jᵀ − Π(Φ)| = {:.3e}", show(&end), defect.amax().to_f64())
        }))
    }
}
