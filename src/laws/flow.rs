//! Laws of motions: of solutions of the forced equations, to round-off, and of runs of the integrator.
//!
//! Solutions are followed by Gauss collocation of order 16 over parts of the step of the case.

use super::lie_poisson::{COAD_SIGN, NO_FORCE, NOT_GRADIENT, TRANSPOSED, rates, strengths, with_brackets};
use super::precision::{Measured, of_relative};
use super::question::{Answer, Problem, Question, Trial, ask_in_quad, law, tried};
use super::sizes::poisson;
use super::step::{show, subject};
use super::user::force::FORCE_SIGN;
use super::{CaseLaw, Source};
use crate::algebra::{Casimir, Covector, Matrix, Vector, dot};
use crate::discrete::exact::{ExactError, at_time, collocate};
use crate::group::LieGroup;
use crate::harness::{Cost, Fault, Verdict, evidence};
use crate::integrators::{OneStep, State, StepError};
use crate::mechanics::equations::EulerPoincare;
use crate::mechanics::{Force, Lagrangian, LegendreError};
use crate::scalar::dual::moving;
use crate::scalar::{Dual, Number, Real, max_abs};
use crate::system::Case;
use crate::system::case::Force as Term;
use crate::tableau::{Family, Tableau};

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "free-flow",
                statement: "without force the flow Φ of Lie–Poisson is Poisson, J Π(μ) Jᵀ = Π(Φ(μ)), and keeps coadjoint orbits: Ad*_{g⁻¹} μ \
                                and every Casimir are constant",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2",
                oracle: "J by the variational equation on dual numbers, Π from the structure constants; Ad of the matrix g with ġ = gη, 1 at the start",
                bound: both(
                    "floor 2⁶ N u: 8 stages of a collocation iterated to a few u, over a quarter of the step or less"
                ),
                needs: "no force; an algebra that is not abelian",
                cost: Cost::Moderate,
                faults: &[COAD_SIGN, TRANSPOSED, NOT_GRADIENT],
                cases: |cases| cases.main_dimensions().force_free().nonabelian(),
                asks: Free,
            }),
            law!(Law {
                name: "dissipation-run",
                statement: "with double brackets and metriplectic forces, α, β ≥ 0: along solutions E falls by α∫|ad*_η μ|² dt and \
                                Casimirs grow by β∫C''(ad*_η μ, ad*_η μ) dt; along runs of the integrator each step falls and grows by as much, up to its error",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §5.3.1 and §5.3.2; Bloch, Krishnaprasad, Marsden and Ratiu \
                             1996; Morrison 1986",
                oracle: "the integrals, solved with the equations in 32 digits; for a run Simpson's rule over each step",
                bound: "along solutions the change when the step of the collocation is halved, with 2⁸ N u; along runs half of the integral, on \
                            steps where it is 8 times what halving the step, twice, and the rule change",
                needs: "double brackets or metriplectic forces; an algebra that is not abelian",
                cost: Cost::Moderate,
                faults: &[NO_FORCE, TRANSPOSED, FORCE_SIGN],
                cases: |cases| with_brackets(cases.main_dimensions()),
                check: dissipation,
            }),
        ]
    }
}

/// Steps of a solution, and of a run.
const STEPS: (usize, usize) = (4, 16);

/// The parts of a step over which a solution is followed, at least.
const PARTS: i64 = 4;

/// h ‖∂μ̇/∂μ‖ of a part at most: the error of order 16 is below 32 digits then.
const CALM: f64 = 0.125;

/// Enough parts that each is calm.
fn parts(h: f64, slope: f64) -> i64 {
    PARTS.max((h.abs() * slope / CALM).min(256.0).ceil() as i64)
}

fn gauss<T: Real>() -> Result<Tableau<T>, ExactError> {
    Ok(Family::Gauss.tableau(8)?)
}

impl From<ExactError> for Measured {
    /// What it means that a solution could not be followed.
    fn from(error: ExactError) -> Self {
        match error {
            ExactError::NotConverged { .. } => Self::Inconclusive("the collocation did not converge".into()),
            ExactError::Equations { .. } => Self::Inconclusive("the Legendre transform could not be inverted".into()),
            ExactError::Tableau(error) => Self::Broken(error.to_string()),
        }
    }
}

/// μ at the beginning of a list of numbers.
fn momentum<T: Real, const N: usize>(y: &[T]) -> Covector<T, N> {
    Covector::from_fn(|_, a| y[a])
}

#[derive(Clone, Copy)]
struct Free;

impl Question for Free {
    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let (system, fault, flow) = (problem.system, problem.fault, problem.system.equations());
        let (start, group) = (&system.state, system.group.as_ref());
        let jacobian = |y: &[T]| Matrix::<T, N>::from_column_slice(&y[N..N + N * N]);
        let attitude = |y: &[T]| Matrix::<T, D>::from_column_slice(&y[N + N * N..]);
        // μ, J by columns, and g from where the motion starts: Ad of an attitude that is far from 1 would lose digits on the way.
        let mut y = start.momentum.as_slice().to_vec();
        y.extend_from_slice(Matrix::<T, N>::identity().as_slice());
        y.extend_from_slice(Matrix::<T, D>::identity().as_slice());
        let mut rate = |t: T, y: &[T]| {
            let (mu, j) = (momentum::<T, N>(y), jacobian(y));
            let here = rates(&flow, t, &mu, fault).map_err(at_time(t))?;
            let mut list = here.momentum.as_slice().to_vec();
            for column in 0..N {
                let moved = moving(&mu, &j.column(column).transpose());
                let found = rates(&flow, Dual::constant(t), &moved, fault).map_err(at_time(t))?;
                list.extend(found.momentum.iter().map(|v| v.eps));
            }
            let turned = group.map(|group| attitude(y) * group.hat(&here.velocity));
            list.extend_from_slice(turned.unwrap_or(Matrix::zeros()).as_slice());
            Ok(list)
        };
        // With J = 1 the rate of J is ∂μ̇/∂μ.
        let slopes = jacobian(&rate(start.time, &y)?);
        let row_sum = |a: usize| slopes.row(a).iter().fold(0.0, |sum: f64, v| sum + v.to_f64().abs());
        let parts = parts(system.step.to_f64(), (0..N).map(row_sum).fold(0.0, f64::max));
        let (gauss, h) = (gauss::<T>()?, system.step / T::int(parts));
        for part in 0..parts {
            collocate(&gauss, start.time + h * T::int(part), h, &mut y, None, &mut rate)?;
        }
        let (mu, j, g) = (momentum::<T, N>(&y), jacobian(&y), attitude(&y));
        let floor = 64.0 * system.dimension as f64;
        let (before, after) = (poisson(&system.algebra, &start.momentum), poisson(&system.algebra, &mu));
        let defect = max_abs(&(j * before.0 * j.transpose() - after.0));
        let stretch = j.amax().max(T::one());
        let map = Measured::defect(defect, stretch * stretch * before.1.max(after.1), floor, || {
            format!("|J Π Jᵀ − Π(Φ)| = {:e} at Φ(μ) = {}", defect.to_f64(), show(&mu))
        });
        let kept = system.casimirs.iter().map(|casimir| {
            let change = (casimir.value(&mu) - casimir.value(&start.momentum)).abs();
            let size = casimir.gradient_terms(&mu).amax() * mu.amax().max(start.momentum.amax());
            Measured::defect(change, size, floor, || format!("C changed by {:e}", change.to_f64()))
        });
        let back = group.and_then(|group| group.adjoint(&group.inverse(&g)?));
        let orbit = back.map(|ad| {
            let (old, new) = (&start.momentum, mu * ad);
            Measured::defect(max_abs(&(new - old)), old.amax().max(mu.amax() * ad.amax()), floor, || {
                format!("Ad*_(g⁻¹) μ went from {} to {}", show(old), show(&new))
            })
        });
        Ok(kept.chain(orbit).fold(map, Measured::and))
    }
}

/// Along a solution in 32 digits, and along a run as it runs. [`FORCE_SIGN`] is planted in the run, the others in the solution.
fn dissipation<S: Source>(case: &S, fault: Option<&Fault>) -> Verdict {
    let forces = &case.case().forces;
    let turned = FORCE_SIGN.size_in(fault);
    let (solved, ran) = match turned {
        0.0 => (fault, case.clone()),
        size => (None, case.with_case(scaled(case.case(), 1.0 - 2.0 * size))),
    };
    let run = tried::<f64, S>(&ran, fault, Run { forces });
    ask_in_quad(case, solved, Solution { forces }).and(run)
}

/// The case with the strengths of its brackets multiplied by a factor.
fn scaled(case: &Case, factor: f64) -> Case {
    let mut case = case.clone();
    for force in &mut case.forces {
        if let Term::DoubleBracket { alpha: strength } | Term::Metriplectic { beta: strength } = force
            && let Ok(value) = strength.eval::<f64>()
        {
            *strength = Number::from(value * factor);
        }
    }
    case
}

/// The rates at which quantities change that are kept otherwise, at a state: of the energy, then of each Casimir.
fn losses<T: Real, const N: usize>(
    (alpha, beta): (T, T),
    mu: &Covector<T, N>,
    turned: &Covector<T, N>,
    casimirs: &[Casimir<T, N>],
) -> Vec<T> {
    let growth = |casimir: &Casimir<T, N>| beta * casimir.second(mu, turned);
    let energy = -alpha * dot(turned.as_slice(), turned.as_slice());
    std::iter::once(energy).chain(casimirs.iter().map(growth)).collect()
}

/// These quantities at a state, with the sizes of their terms.
fn values<T: Real, const N: usize, L: Lagrangian<T, N>, F: Force<T, N>>(
    flow: &EulerPoincare<T, N, L, F>,
    casimirs: &[Casimir<T, N>],
    mu: &Covector<T, N>,
) -> Result<Vec<(T, T)>, LegendreError> {
    let energy = flow.hamiltonian(mu, &Vector::zeros())?;
    let eta = flow.lagrangian.velocity(mu, &Vector::zeros())?;
    let size = mu.amax() * eta.amax() * T::int(N as i64);
    let of =
        |casimir: &Casimir<T, N>| (casimir.value(mu), casimir.gradient_terms(mu).amax() * mu.amax() * T::int(N as i64));
    Ok(std::iter::once((energy, size)).chain(casimirs.iter().map(of)).collect())
}

fn name(k: usize) -> String {
    if k == 0 { "E".into() } else { format!("Casimir {k}") }
}

#[derive(Clone, Copy)]
struct Solution<'a> {
    forces: &'a [Term],
}

impl Question for Solution<'_> {
    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let (system, flow, fault) = (problem.system, problem.system.equations(), problem.fault);
        let strengths = strengths::<T>(self.forces).map_err(Measured::Broken)?;
        // μ, and the integrals of the rates.
        let mut rate = |t: T, y: &[T]| {
            let mu = momentum::<T, N>(y);
            let here = rates(&flow, t, &mu, fault).map_err(at_time(t))?;
            let mut list = here.momentum.as_slice().to_vec();
            list.extend(losses(strengths, &mu, &system.algebra.coad(&here.velocity, &mu), &system.casimirs));
            Ok(list)
        };
        let gauss = gauss::<T>()?;
        let (mut mu, mut found) = (system.state.momentum, Measured::exact());
        for step in 0..STEPS.0 {
            let start = system.state.time + system.step * T::int(step as i64);
            let begin = values(&flow, &system.casimirs, &mu).map_err(at_time(start))?;
            // What is left of each quantity in steps of h/k, and where they end.
            let mut left = |parts: i64| {
                let mut y = mu.as_slice().to_vec();
                y.resize(N + begin.len(), T::zero());
                let h = system.step / T::int(parts);
                for part in 0..parts {
                    collocate(&gauss, start + h * T::int(part), h, &mut y, None, &mut rate)?;
                }
                let end = values(&flow, &system.casimirs, &momentum(&y)).map_err(at_time(start))?;
                let left = begin.iter().zip(&end).zip(&y[N..]).map(|((old, new), lost)| new.0 - old.0 - *lost);
                Ok::<_, ExactError>((left.collect::<Vec<T>>(), momentum(&y)))
            };
            let (coarse, _) = left(1)?;
            let (fine, end) = left(2)?;
            for (k, (coarse, fine)) in coarse.iter().zip(&fine).enumerate() {
                let rounding = begin[k].1 * T::unit_roundoff() * T::int(256 * system.dimension as i64);
                found = found.and(Measured::within(fine.abs(), (*coarse - *fine).abs() + rounding, || {
                    format!("{} is off its integral by {:e} in step {}", name(k), fine.to_f64(), step + 1)
                }));
            }
            mu = end;
        }
        Ok(found)
    }
}

#[derive(Clone, Copy)]
struct Run<'a> {
    forces: &'a [Term],
}

/// The largest distance of a step's loss from the integral, relative to it: half of what would change its sign.
const HALF: f64 = 0.5;

/// The least loss relative to its error whose sign a step tells.
const CLEAR: f64 = 8.0;

impl Trial<f64> for Run<'_> {
    fn judge<const N: usize, const D: usize>(self, problem: Problem<'_, f64, N, D>) -> Result<Verdict, Measured> {
        let (system, flow) = (problem.system, problem.system.equations());
        let strengths = strengths::<f64>(self.forces).map_err(Measured::Broken)?;
        let legendre = |source: LegendreError| StepError::Legendre { step: system.step, source };
        let mut method = subject(system, None);
        let mut state = system.state.clone();
        let mut worst = None::<(f64, String)>;
        for step in 0..STEPS.1 {
            let mut parted = |state: &State<f64, N, D>, parts: usize| {
                let mut state = state.clone();
                let mut visited = vec![state.momentum];
                for _ in 0..parts {
                    method.step(&mut state, system.step / parts as f64)?;
                    visited.push(state.momentum);
                }
                Ok::<_, StepError>((state, visited))
            };
            let (end, _) = parted(&state, 1)?;
            let (_, visited) = parted(&state, 2)?;
            // One halving alone may change a value by chance little, where its error changes its sign.
            let (quarters, _) = parted(&state, 4)?;
            let rate = |mu: &Covector<f64, N>| {
                let eta = flow.lagrangian.velocity(mu, &Vector::zeros()).map_err(legendre)?;
                Ok::<_, StepError>(losses(strengths, mu, &system.algebra.coad(&eta, mu), &system.casimirs))
            };
            let [first, middle, last] = [rate(&visited[0])?, rate(&visited[1])?, rate(&visited[2])?];
            let of = |mu: &Covector<f64, N>| values(&flow, &system.casimirs, mu).map_err(legendre);
            let (old, new) = (of(&state.momentum)?, of(&end.momentum)?);
            let (better, best) = (of(&visited[2])?, of(&quarters.momentum)?);
            for k in 0..old.len() {
                let simpson = system.step / 6.0 * (first[k] + 4.0 * middle[k] + last[k]);
                let trapezoid = system.step / 2.0 * (first[k] + last[k]);
                let rounding = 64.0 * f64::EPSILON * old[k].1.max(new[k].1);
                let halved = (new[k].0 - better[k].0).abs() + 2.0 * (better[k].0 - best[k].0).abs();
                let error = halved + (simpson - trapezoid).abs() + rounding;
                // Neither is anything where a Casimir and its gradient vanish.
                if simpson != 0.0 && simpson.abs() >= CLEAR * error {
                    let (change, ratio) = (new[k].0 - old[k].0, (new[k].0 - old[k].0) / simpson);
                    let off = (ratio - 1.0).abs();
                    if worst.as_ref().is_none_or(|(worst, _)| off > *worst || off.is_nan()) {
                        let what = format!("{} changes by {change:e} in step {}", name(k), step + 1);
                        worst = Some((off, format!("{what}, where its rate says {simpson:e}")));
                    }
                }
            }
            state = end;
        }
        let Some((off, witness)) = worst else {
            return Ok(Verdict::not_applicable("no step loses more than its error"));
        };
        evidence::note(|| of_relative::<f64>(16, off, HALF, witness.clone()));
        Ok(Verdict::judge(off, HALF, || witness))
    }
}
