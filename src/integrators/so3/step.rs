//! The fast step as a [`OneStep`].

use super::force::{LaneForce, OnBody};
use super::kernel::{Columns, Limits, Memory, Packed, Refused, Step, Taken};
use super::retraction::{self, LaneRetraction};
use super::{LANES, Row};
use crate::integrators::lanes::Registers;
use crate::integrators::variational::{Settings, extrapolation};
use crate::integrators::{OneStep, Report, Solver, State, StepError, Variational};
use crate::mechanics::lagrangian::Quadratic;
use crate::retraction::{CayleySo3, ExponentialSo3, Retraction};
use crate::tableau::Tableau;
use std::marker::PhantomData;

/// A retraction on SO(3) that has a form in lanes.
pub trait FastRetraction: Retraction<f64, 3, 3> + Clone {
    /// That form.
    type Lanes: LaneRetraction;
}

impl FastRetraction for CayleySo3<f64> {
    type Lanes = retraction::Cayley;
}

impl FastRetraction for ExponentialSo3<f64> {
    type Lanes = retraction::Exponential;
}

/// A tableau with more stages than lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the tableau has {stages} stages: the fast step holds at most {LANES}")]
pub struct UnfitTableau {
    /// Its stages.
    pub stages: usize,
}

/// The forced variational step on SO(3) with all stages in the lanes of a register.
///
/// The same method as [`Variational`] on a body with a quadratic Lagrangian, to round-off; what it gains is time. Nothing
/// is allocated by a step. The sums that make (g, μ) are compensated from step to step, as long as each step starts from
/// the state that the last one left.
#[derive(Clone, Debug)]
pub struct VariationalSo3<F, R> {
    columns: Columns,
    pub(super) force: F,
    pub(super) inverse: [[f64; 3]; 3],
    diagonal: bool,
    registers: Registers,
    settings: Settings<f64>,
    /// What takes the steps that sweeps do not solve.
    pub(super) newton: Variational<f64, 3, 3, Quadratic<f64, 3>, OnBody<F>, R>,
    pub(super) last: Last,
}

/// What the last step left; of size 0 where there was none.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Last {
    step: f64,
    pub state: Packed,
    memory: Memory,
    jump: f64,
}

impl<F: LaneForce, R: FastRetraction> VariationalSo3<F, R> {
    /// The fast step of a body, a force, a retraction and a tableau of up to eight stages.
    ///
    /// # Errors
    /// More stages than that.
    pub fn new(
        lagrangian: Quadratic<f64, 3>,
        force: F,
        retraction: R,
        tableau: Tableau<f64>,
    ) -> Result<Self, UnfitTableau> {
        Self::with_settings(lagrangian, force, retraction, tableau, Settings::default())
    }

    /// The same with settings of one's own.
    ///
    /// # Errors
    /// As [`VariationalSo3::new`].
    pub fn with_settings(
        lagrangian: Quadratic<f64, 3>,
        force: F,
        retraction: R,
        tableau: Tableau<f64>,
        settings: Settings<f64>,
    ) -> Result<Self, UnfitTableau> {
        let stages = tableau.stages();
        if stages > LANES {
            return Err(UnfitTableau { stages });
        }
        let weights = extrapolation(tableau.c().as_slice());
        let inverse: [[f64; 3]; 3] = std::array::from_fn(|r| std::array::from_fn(|c| lagrangian.inverse()[(r, c)]));
        let diagonal = (0..3).all(|r| (0..3).all(|c| r == c || inverse[r][c] == 0.0));
        let columns = Columns::new(&tableau, weights.as_ref());
        let on_body = OnBody { force: force.clone(), lagrangian: lagrangian.clone() };
        let newton = Variational::with_settings(lagrangian, on_body, retraction, tableau, settings);
        Ok(Self {
            columns,
            force,
            inverse,
            diagonal,
            registers: Registers::detect(),
            settings,
            newton,
            last: Last::default(),
        })
    }

    /// The same in registers of another kind: for tests that compare them.
    pub fn in_registers(mut self, registers: Registers) -> Self {
        self.registers = registers;
        self
    }

    /// The tableau.
    pub fn tableau(&self) -> &Tableau<f64> {
        self.newton.tableau()
    }

    pub(super) fn stages(&self) -> usize {
        self.columns.stages
    }

    /// What Newton's method and the continuation in h say of a step that sweeps do not solve.
    #[cold]
    pub(super) fn diagnose(&mut self, state: &State<f64, 3, 3>, step: f64) -> StepError {
        match self.newton.step(&mut state.clone(), step) {
            Err(error) => error,
            Ok(report) => StepError::NotConverged {
                step,
                residual: report.residual,
                tolerance: self.settings.tolerance,
                iterations: report.iterations,
            },
        }
    }

    /// One step in lanes, from `self.last.state`, which it replaces on success.
    pub(super) fn take(&mut self, time: f64, step: f64, warm: bool, limits: Limits) -> Result<Taken, Refused> {
        macro_rules! with_pairs {
            ($pairs:literal) => {
                self.registers.run(Step::<F, R::Lanes, $pairs> {
                    columns: &self.columns,
                    force: &self.force,
                    inverse: &self.inverse,
                    diagonal: self.diagonal,
                    time,
                    step,
                    state: &mut self.last.state,
                    memory: &mut self.last.memory,
                    warm,
                    limits,
                    retraction: PhantomData,
                })
            };
        }
        match self.columns.stages {
            0..=2 => with_pairs!(1),
            3..=4 => with_pairs!(2),
            5..=6 => with_pairs!(3),
            _ => with_pairs!(4),
        }
    }
}

/// Whether `packed` is this state.
fn holds(packed: &Packed, state: &State<f64, 3, 3>) -> bool {
    let value = &packed.value;
    (0..3).all(|a| value[a].0[3] == state.momentum[a] && (0..3).all(|r| value[a].0[r] == state.attitude[(r, a)]))
}

/// (g, μ) in lanes, with nothing cut off.
pub(super) fn pack(state: &State<f64, 3, 3>) -> Packed {
    let g = &state.attitude;
    let row = |a: usize| Row([g[(0, a)], g[(1, a)], g[(2, a)], state.momentum[a], 0.0, 0.0, 0.0, 0.0]);
    Packed { value: [row(0), row(1), row(2)], cut: [Row::default(); 3] }
}

pub(super) fn unpack(packed: &Packed, state: &mut State<f64, 3, 3>) {
    for a in 0..3 {
        state.momentum[a] = packed.value[a].0[3];
        for r in 0..3 {
            state.attitude[(r, a)] = packed.value[a].0[r];
        }
    }
}

impl<F: LaneForce, R: FastRetraction> OneStep<f64, 3, 3> for VariationalSo3<F, R> {
    fn step(&mut self, state: &mut State<f64, 3, 3>, h: f64) -> Result<Report<f64>, StepError> {
        let tolerance = self.settings.tolerance;
        let mut limits = Limits {
            tolerance,
            floor: self.settings.floor,
            switch: tolerance,
            max_sweeps: self.settings.max_sweeps,
            strict: None,
        };
        let known = self.last.step != 0.0 && holds(&self.last.state, state);
        let warm = known && self.last.step == h;
        if warm {
            limits.switch = f64::max(0.25 * self.last.jump, tolerance);
        }
        if !known {
            state.check_finite(h)?;
            self.last.state = pack(state);
        }
        let mut spent = 0;
        match self.take(state.time, h, warm, limits) {
            Ok(taken) => {
                spent += taken.predictor + taken.sweeps;
                let time = state.time + h;
                if self.last.state.is_finite() && time.is_finite() {
                    (self.last.step, self.last.jump) = (h, taken.jump);
                    unpack(&self.last.state, state);
                    state.time = time;
                    return Ok(Report { solver: Solver::Sweeps, iterations: spent, residual: taken.residual });
                }
            }
            Err(Refused::Unswept(sweeps)) => spent += sweeps,
            Err(Refused::Delta(_)) => {}
        }
        self.last.step = 0.0;
        let mut report = self.newton.step(state, h)?;
        report.iterations += spent;
        Ok(report)
    }
}
