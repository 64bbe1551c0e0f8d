//! Motions in a potential over many steps: the energy oscillates, and does not drift.
//!
//! The step is symplectic on T*G, so that it keeps a Hamiltonian near that of the system for times exponential in 1/h. Where the level sets
//! of the energy are compact, as on groups of rotations, its error stays what it is in the first periods. An error that grows like the time
//! has the slope 1 in a plot of logarithms, one that stays has 0.
//!
//! The error is that which half of the steps exceed. A drift moves all of them. The largest one tells less: where a motion comes to places at
//! which the error is large, and comes closer the longer it runs, it grows without a drift. On one case it is 2e-11 in 625 steps and 5e-9 in
//! 160,000, while after 2,500 to 160,000 steps the energy is within 1.3e-11 of that at the start.

use super::CaseLaw;
use super::configuration::{What, configured};
use super::planted::step::{CHART, NO_SECOND, OF_START, UNCONJUGATED};
use super::precision::{Measured, of_relative};
use super::question::{law, on_main};
use super::step::{TestedMethod, subject};
use super::variational_error::tableaux;
use crate::algebra::catalogue::Entry;
use crate::algebra::elimination::quick_inverse;
use crate::algebra::{Matrix, Vector, basis_vector};
use crate::group::LieGroup;
use crate::harness::evidence;
use crate::harness::{Cost, Fault, Verdict};
use crate::integrators::{OneStep, State, StepError};
use crate::mechanics::Lagrangian;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::system::{Cases, System};
use crate::tableau::Family;
use crate::tableau::random::TableauKind;

/// The laws of this file.
pub const fn laws() -> &'static [CaseLaw] {
    &[law!(Law {
        name: "configuration-drift",
        statement: "without force, in a potential V(g) on a group of rotations, the error of the energy does not grow with the time: it \
                        oscillates, and in 10⁴ steps it does not drift",
        source: "Hairer, Lubich and Wanner 2006, §IX.8, Thm 8.1, on the symplectic step of Marsden and West 2001, §1.3.2",
        oracle: "the energy of the state, E = ⟨∂L/∂η, η⟩ − L",
        bound: "a half for the slope of the error in the number of steps, half the way from an oscillation, 0, to a drift, 1; the error \
                    is the median over the steps, the slope that from 625 to 2500 steps, or from there to 10⁴ or 4·10⁴ where that is less",
        needs: "a group of rotations, SO(n) or a product; no force; a positive definite inertia",
        cost: Cost::Heavy,
        faults: &[UNCONJUGATED, CHART, NO_SECOND, OF_START],
        cases: generator,
        check: |case, fault| {
            if case.lagrangian.indefinite {
                return Verdict::not_applicable("the inertia is indefinite, and motions of an energy are unbounded");
            }
            on_main::<f64>(&configured(case, What::Potential), fault, |system| judge(system, fault))
        },
    })]
}

fn generator(cases: Cases) -> Cases {
    let families = [
        (Family::Gauss, 1),
        (Family::Gauss, 2),
        (Family::LobattoIIIA, 2),
        (Family::LobattoIIIA, 3),
        (Family::LobattoIIIB, 2),
        (Family::LobattoIIIB, 3),
        (Family::RadauIIA, 2),
    ];
    let tableaux =
        tableaux(&families, &[TableauKind::Collocation, TableauKind::OrderTwo, TableauKind::DiagonallyImplicit]);
    let rotations = [Entry::So3, Entry::So4, Entry::Product(vec![Entry::So3, Entry::So3])];
    cases.algebras(&rotations).main_dimensions().force_free().with_tableaux(tableaux)
}

/// The steps after which the median of the errors is read; later ones only where those before leave it open.
const READ: [usize; 4] = [625, 2_500, 10_000, 40_000];

/// h ‖ad_η‖ for the fastest motion of this energy, or more: 625 steps are some turns at least, and 10⁴ are hundreds.
const ANGLE: f64 = 0.25;

/// An error below this multiple of what rounding makes of the energy in its steps shows nothing.
const CLEAR: f64 = 64.0;

/// The slope half the way to a drift, and what is surely one.
const SLOPES: (f64, f64) = (0.5, 0.75);

/// Slopes from here on are those of a drift without more steps. Below, a motion that comes to new places may show them: of a body in four
/// dimensions with slow turns 0.90 and 0.81, and then no more.
const STEADY: f64 = 0.95;

fn judge<const N: usize, const D: usize>(
    system: &System<f64, N, D>,
    fault: Option<&Fault>,
) -> Result<Verdict, Measured> {
    let Some(fastest) = fastest(system) else {
        return Ok(Verdict::not_applicable("the level sets of the energy are not known to be compact"));
    };
    let h = system.step.signum() * ANGLE / fastest;
    let mut run = Run::new(system, fault, h);
    let mut errors = vec![run.until(READ[0])?, run.until(READ[1])?];
    if errors[0] <= run.rounding() {
        return Ok(Verdict::not_applicable("the error of the energy is rounding"));
    }
    let mut slope = slope(errors[0], errors[1]);
    for k in 2..READ.len() {
        if slope <= SLOPES.0 || (k > 2 && slope >= STEADY) {
            break;
        }
        errors.push(run.until(READ[k])?);
        slope = slope.min(self::slope(errors[k - 1], errors[k]));
    }
    let told = errors.iter().zip(READ).map(|(error, steps)| format!("{error:.2e} in {steps}"));
    let told = format!("h = {h:.3e}: the median error of the energy is {}", told.collect::<Vec<_>>().join(", "));
    evidence::note(|| of_relative::<f64>(16, slope, SLOPES.0, told.clone()));
    Ok(match slope {
        s if s <= SLOPES.0 => Verdict::Holds { defect: s.max(0.0), bound: SLOPES.0 },
        s if s < SLOPES.1 => Verdict::inconclusive("the error of the energy grows, and more slowly than a drift"),
        s => Verdict::Broken { defect: s, bound: SLOPES.0, witness: told },
    })
}

/// The slope between readings, each after four times as many steps as the one before.
fn slope(before: f64, after: f64) -> f64 {
    (after / before).log(4.0)
}

/// A bound of ‖ad_η‖ on all motions of the energy that the case has; none where the group is not one of rotations.
fn fastest<const N: usize, const D: usize>(system: &System<f64, N, D>) -> Option<f64> {
    let (group, state) = (system.group.as_ref()?, &system.state);
    let mut turning = 0.0_f64;
    for a in 0..system.dimension {
        let along = basis_vector::<f64, N>(a);
        let matrix: Matrix<f64, D> = group.hat(&along);
        if matrix != -matrix.transpose() {
            return None;
        }
        let ad = system.algebra.ad(&along);
        turning = ad.row_iter().map(|row| row.abs().sum()).fold(turning, f64::max);
    }
    let here = Configuration::of(&state.attitude);
    let eta = system.lagrangian.velocity_at(state.time, here, &state.momentum, &Vector::zeros()).ok()?;
    let energy = system.lagrangian.energy_at(state.time, here, &eta);
    let inverse = quick_inverse(&system.lagrangian.hessian(&Vector::zeros()))?;
    let lightest = inverse.row_iter().map(|row| row.abs().sum()).fold(0.0, f64::max);
    // ½⟨Iη, η⟩ ≤ E − V.
    let speed = (2.0 * (energy + DEEPEST).max(0.0) * lightest).sqrt();
    (speed > 0.0 && turning > 0.0 && (speed * turning).is_finite()).then_some(speed * turning)
}

/// −V at most: three terms of at most 1.
const DEEPEST: f64 = 3.0;

/// A run, and the errors of its energy.
struct Run<'a, const N: usize, const D: usize> {
    method: TestedMethod<'a, f64, N, D>,
    lagrangian: &'a AnyLagrangian<f64, N>,
    state: State<f64, N, D>,
    eta: Vector<f64, N>,
    h: f64,
    start: Option<f64>,
    /// After each step.
    errors: Vec<f64>,
}

impl<'a, const N: usize, const D: usize> Run<'a, N, D> {
    fn new(system: &'a System<f64, N, D>, fault: Option<&Fault>, h: f64) -> Self {
        Self {
            method: subject(system, fault),
            lagrangian: &system.lagrangian,
            state: system.state.clone(),
            eta: Vector::zeros(),
            h,
            start: None,
            errors: Vec::new(),
        }
    }

    fn energy(&mut self) -> Result<f64, StepError> {
        let (t, here) = (self.state.time, Configuration::of(&self.state.attitude));
        let velocity = self.lagrangian.velocity_at(t, here, &self.state.momentum, &self.eta);
        self.eta = velocity.map_err(|source| StepError::Legendre { step: self.h, source })?;
        Ok(self.lagrangian.energy_at(t, here, &self.eta))
    }

    /// The median of the errors of the energy in `steps` steps from the start.
    fn until(&mut self, steps: usize) -> Result<f64, StepError> {
        let start = match self.start {
            Some(start) => start,
            None => self.energy()?,
        };
        self.start = Some(start);
        while self.errors.len() < steps {
            self.method.step(&mut self.state, self.h)?;
            let error = (self.energy()? - start).abs();
            self.errors.push(error);
        }
        let mut errors = self.errors.clone();
        if errors.iter().any(|error| error.is_nan()) {
            return Ok(f64::NAN);
        }
        Ok(*errors.select_nth_unstable_by(steps / 2, f64::total_cmp).1)
    }

    /// What rounding may make of the energy in the steps so far.
    fn rounding(&self) -> f64 {
        let size = self.start.unwrap_or(0.0).abs() + 2.0 * DEEPEST;
        CLEAR * f64::EPSILON * size * (self.errors.len() as f64).sqrt()
    }
}
