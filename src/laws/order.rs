//! Laws of convergence: the order that the coefficients predict is the order that is measured, from both sides.
//!
//! All in 32 digits, on forced systems of non-abelian groups: there no tableau is better than its order conditions. The
//! reference is a classical Gauss collocation method on the vector field of (μ, g), of order 16, at two resolutions; it
//! knows neither retractions nor the variational equations.

use super::planted::step::{
    FIRST_STAGE, FORCE_INDEX, FROM_LEFT, INVERSE_SECOND, INVERTED, LOOSE_TOLERANCE, NO_FORCE, NO_SECOND,
    NOT_TRANSPORTED, ORDER_TWO, SWAPPED_SECOND,
};
use super::question::{Measured, Problem, Trial, law, tried};
use super::step::{TestedMethod, subject};
use super::{CaseLaw, Source};
use crate::algebra::Vector;
use crate::harness::convergence::{Estimate, TOLERANCE};
use crate::harness::evidence;
use crate::harness::{Cost, Fault, Verdict};
use crate::integrators::{OneStep, State, StepError};
use crate::mechanics::Force;
use crate::mechanics::Lagrangian;
use crate::mechanics::configuration::Configuration;
use crate::retraction::Retraction;
use crate::scalar::{Dd, Scalar, max_abs};
use crate::study::{Findings, Reading, Row, StepLevel, reference};
use crate::system::{Cases, System};
use crate::tableau::{Description, Family, variational_order};
use nalgebra::ComplexField;

pub(super) const BOUND: &str = "a quarter: half the way to the point that is as near to the next integer";

/// Steps over the horizon at the coarsest level.
const COARSEST: usize = 2;

/// The fewest and the most levels, each with half the step of the one before.
const LEVELS: (usize, usize) = (5, 7);

/// Relative errors at the coarsest level that the horizon is changed for, until one shows an order. The smallest comes first: there
/// the terms of lower order that a small fault adds are the largest. 32 digits leave room for five levels of order 6 below each.
const TARGETS: [f64; 4] = [1e-16, 1e-13, 1e-10, 1e-7];

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "order-momentum-attitude",
                statement: "Gauss 1–3 and Lobatto IIIA, IIIB 2–3 converge in μ and in g at the order of the pair (a, â)",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 5.4",
                oracle: "a classical Gauss method of order 16 on the vector field; the order computed from the bicoloured trees",
                bound: BOUND,
                needs: "a group; a smooth force; an algebra that is not abelian",
                cost: Cost::Expensive,
                faults: &[
                    INVERSE_SECOND,
                    NO_SECOND,
                    SWAPPED_SECOND,
                    FORCE_INDEX,
                    NO_FORCE,
                    NOT_TRANSPORTED,
                    FIRST_STAGE,
                    INVERTED,
                    FROM_LEFT,
                    ORDER_TWO,
                    LOOSE_TOLERANCE,
                ],
                cases: forced,
                check: |case, fault| tried::<Dd, S>(case, fault, Which::Order),
            }),
            law!(Law {
                name: "energy-balance",
                statement: "E(T) − E(0) − h Σ b_i ⟨f_i, η_i⟩ → 0 at least at the order of the method",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §2.2: dE/dt = ⟨f(η), η⟩",
                oracle: "the energy of the state; the work from the stages",
                bound: BOUND,
                needs: "a group; a smooth force; an algebra that is not abelian",
                cost: Cost::Expensive,
                faults: &[NO_FORCE, NOT_TRANSPORTED, NO_SECOND],
                cases: forced,
                check: |case, fault| tried::<Dd, S>(case, fault, Which::Balance),
            }),
        ]
    }
}

/// The pairs that the theorem is measured on.
pub(super) const PAIRS: [(Family, usize); 7] = [
    (Family::Gauss, 1),
    (Family::Gauss, 2),
    (Family::Gauss, 3),
    (Family::LobattoIIIA, 2),
    (Family::LobattoIIIA, 3),
    (Family::LobattoIIIB, 2),
    (Family::LobattoIIIB, 3),
];

/// Forced systems with tableaux of known orders.
pub(super) fn forced(cases: Cases) -> Cases {
    let methods = PAIRS.map(|(family, stages)| Description::Family(family, stages)).to_vec();
    cases.forced_nonabelian().smooth().with_group().with_tableaux(proptest::sample::select(methods))
}

/// What is judged.
#[derive(Clone, Copy)]
pub(super) enum Which {
    /// The order in μ and in g.
    Order,
    /// The energy balance.
    Balance,
}

/// Stretches of the horizon, as powers of two, where the coarsest error is rounding.
const BLIND: [f64; 3] = [6.0, 4.0, 2.0];

/// Why a case has no order: a motion that is a polynomial of low degree, on a nilpotent algebra for instance.
const EXACT: &str = "the method is exact on this motion";

/// What is measured.
const QUANTITIES: [&str; 3] = ["momentum", "attitude", "energy balance"];

impl Trial<Dd> for Which {
    const LARGE: bool = true;

    const KNOWS_CONFIGURATION: bool = true;

    fn judge<const N: usize, const D: usize>(self, problem: Problem<'_, Dd, N, D>) -> Result<Verdict, Measured> {
        let Problem { system, fault, .. } = problem;
        let study = OrderStudy { system, fault, which: self };
        let order = variational_order(&system.tableau, 8).order as u32;
        let horizon = system.step * Dd::int(COARSEST as i64);
        let mut stretches = match study.coarsest(horizon) {
            // The error over a fixed number of steps goes as h^{p+1}.
            Some(error) => {
                let stretch = |target: f64| (target / error).powf(1.0 / f64::from(order + 1)).log2();
                TARGETS.map(|target| stretch(target).clamp(-24.0, 24.0).round()).to_vec()
            }
            // Where there is none, any horizon may show one.
            None => BLIND.to_vec(),
        };
        // That of the case.
        stretches.push(0.0);
        let mut last = Verdict::inconclusive("no levels");
        for stretch in stretches {
            let (verdict, findings) = study.at_horizon(horizon * Dd::exact(2f64.powf(stretch)), order);
            let decided = match &verdict {
                Verdict::Inconclusive { .. } => false,
                Verdict::NotApplicable { why } => why == EXACT,
                _ => true,
            };
            if decided || stretch == 0.0 {
                study.note(&findings, order);
            }
            last = verdict;
            if decided {
                break;
            }
        }
        Ok(last)
    }
}

/// The method of a system under study.
struct OrderStudy<'a, const N: usize, const D: usize> {
    system: &'a System<Dd, N, D>,
    fault: Option<&'a Fault>,
    which: Which,
}

impl<const N: usize, const D: usize> OrderStudy<'_, N, D> {
    /// Tells the errors that decided.
    fn note(&self, findings: &Findings, order: u32) {
        let quantities = match self.which {
            Which::Order => 0..2,
            Which::Balance => 2..3,
        };
        evidence::note_all(|| {
            let measured = quantities.filter(|quantity| !findings.levels(*quantity).is_empty());
            measured.map(|quantity| findings.evidence_of(quantity, order, 32, ""))
        });
    }

    /// The relative error in the momentum at the coarsest level; `None` where it is rounding, or where there is no step.
    fn coarsest(&self, horizon: Dd) -> Option<f64> {
        let system = self.system;
        let quarters = [1, 2, 3, 4].map(|k| horizon * Dd::ratio(k, 4));
        let exact = reference::at(&system.equations(), system.group.as_ref(), &system.state, &quarters, 8).ok()?;
        let exact = exact.last()?.state.momentum;
        let (end, _) = self.run(horizon, COARSEST).ok()?;
        let error = (max_abs(&(end.momentum - exact)) / exact.amax()).to_f64();
        (error > 1e-27).then_some(error)
    }

    /// The verdict from one horizon, and the errors.
    fn at_horizon(&self, horizon: Dd, order: u32) -> (Verdict, Findings) {
        let system = self.system;
        let mut findings = Findings::new(QUANTITIES.map(str::to_owned).to_vec(), 3);
        let Ok(exact) = reference::after(&system.equations(), system.group.as_ref(), &system.state, horizon, 5, 8)
        else {
            return (Verdict::inconclusive("the reference did not converge"), findings);
        };
        let (exact, (of_momentum, of_attitude)) = (exact.state, exact.reference_error);
        // Rounding: some hundred operations a step, relative to the size of the state; and the reference itself.
        let size = energy(system, &exact).unwrap_or(Dd::exact(1.0)).abs();
        let sizes = [exact.momentum.amax(), exact.attitude.amax(), size];
        let reference_error = [of_momentum, of_attitude, Dd::exact(0.0)];
        let known = reference_error.iter().zip(&sizes).all(|(error, size)| *error <= *size * Dd::exact(1e-24));
        let mut verdict = Verdict::inconclusive("no levels");
        for level in StepLevel::over(horizon, (0..LEVELS.1).map(|k| COARSEST << k)) {
            let (end, balance) = match self.run(horizon, level.steps) {
                Ok(end) => end,
                Err(StepError::Domain { .. }) => {
                    let verdict = Verdict::not_applicable("the step leaves the domain of the retraction");
                    return (verdict, findings);
                }
                Err(_) => return (Verdict::inconclusive("a step was refused"), findings),
            };
            let errors =
                [max_abs(&(end.momentum - exact.momentum)), max_abs(&(end.attitude - exact.attitude)), balance.abs()];
            let unit = Dd::unit_roundoff() * Dd::int(64 * level.steps as i64);
            let reading = |k: usize| Reading::new(errors[k], unit * sizes[k], reference_error[k]);
            findings.push(Row {
                steps: level.steps,
                h: level.h.to_f64(),
                readings: Ok((0..errors.len()).map(reading).collect()),
            });
            if findings.rows().len() < LEVELS.0 {
                continue;
            }
            let judged = |quantity: usize| match known && findings.is_exact(quantity) {
                true => Verdict::not_applicable(EXACT),
                false => match findings.judge(quantity, order) {
                    // Some forces and tableaux do better in the energy.
                    (Estimate::Slope { low, .. }, _) if quantity == 2 && low > f64::from(order) => {
                        Verdict::Holds { defect: 0.0, bound: TOLERANCE }
                    }
                    (_, verdict) => verdict,
                },
            };
            verdict = match self.which {
                Which::Order => judged(0).and(judged(1)),
                Which::Balance => judged(2),
            };
            if !matches!(verdict, Verdict::Inconclusive { .. }) {
                break;
            }
        }
        (verdict, findings)
    }

    /// The state at the horizon, and the energy that the work does not account for.
    fn run(&self, horizon: Dd, steps: usize) -> Result<(State<Dd, N, D>, Dd), StepError> {
        let system = self.system;
        let mut method = subject(system, self.fault);
        let mut state = system.state.clone();
        let h = horizon / Dd::int(steps as i64);
        let mut work = Dd::exact(0.0);
        for _ in 0..steps {
            let start = state.clone();
            method.step(&mut state, h)?;
            if matches!(self.which, Which::Balance) {
                work += stage_work(system, &method, &start, h);
            }
        }
        let balance = energy(system, &state)? - energy(system, &system.state)? - work;
        Ok((state, balance))
    }
}

fn energy<const N: usize, const D: usize>(system: &System<Dd, N, D>, state: &State<Dd, N, D>) -> Result<Dd, StepError> {
    let g = Configuration::of(&state.attitude);
    let velocity = system.lagrangian.velocity_at(state.time, g, &state.momentum, &Vector::zeros());
    let velocity = velocity.map_err(|source| StepError::Legendre { step: system.step.to_f64(), source })?;
    Ok(system.lagrangian.energy_at(state.time, g, &velocity))
}

/// h Σ b_i ⟨f(t + c_i h, η_i), η_i⟩ of the last step, with the b_i and c_i of the system.
fn stage_work<const N: usize, const D: usize>(
    system: &System<Dd, N, D>,
    method: &TestedMethod<'_, Dd, N, D>,
    start: &State<Dd, N, D>,
    h: Dd,
) -> Dd {
    let (b, c) = (system.tableau.b(), system.tableau.c());
    let moves = system.force.uses_configuration();
    let mut work = Dd::exact(0.0);
    for (i, [displacement, velocity]) in method.displacements_and_velocities().into_iter().enumerate() {
        let turn = if moves { system.retraction.tau(&displacement).ok() } else { None };
        let there = turn.map_or(start.attitude, |turn| start.attitude * turn);
        let force = system.force.force_at(start.time + c[i] * h, Configuration::of(&there), &velocity);
        work += b[i] * h * (force * velocity)[0];
    }
    work
}
