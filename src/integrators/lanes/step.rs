//! The step in lanes as a [`OneStep`].

use super::force::{LaneForce, OnBody, slope};
use super::group::{FastRetraction, LaneGroup as _};
use super::kernel::{Columns, Limits, Memory, Packed, Refused, Step, Taken};
use super::vectors::velocity;
use super::{LANES, Registers};
#[cfg(feature = "harness")]
use crate::algebra::Matrix;
use crate::algebra::Vector;
use crate::integrators::variational::{Settings, extrapolation};
use crate::integrators::{OneStep, Report, Solver, State, StepError, Variational};
use crate::mechanics::lagrangian::Quadratic;
use crate::scalar::max_abs;
use crate::tableau::Tableau;

/// A tableau with more stages than lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the tableau has {stages} stages: the fast step holds at most {LANES}")]
#[non_exhaustive]
pub struct UnfitTableau {
    /// Its stages.
    pub stages: usize,
}

/// The forced variational step on a group of D×D matrices of dimension N, with all stages in the lanes of a register.
///
/// The same method as [`Variational`] on a body with a quadratic Lagrangian, to round-off; what it gains is time. Nothing
/// is allocated by a step. The sums that make (t, g, μ) are compensated from step to step, as long as each step starts from
/// the state that the last one left.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::lanes::{
///     Damping, FastRetraction, Free, LaneAttitude, LaneForce, Lanes, Registers, Relaxation, UnfitTableau, VariationalInLanes,
/// };
/// use euler_poincare::integrators::{OneStep, State};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::{CayleySo3, ExponentialSo3};
/// use euler_poincare::tableau::Family;
///
/// /// f = −η/10, in lanes.
/// #[derive(Clone)]
/// struct Friction;
///
/// impl LaneForce for Friction {
///     #[inline(always)]
///     fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, t: V, _: G, _m: [V; 3], eta: [V; 3], sum: [V; 3]) -> [V; 3] {
///         let minus = t.constant(-0.1);
///         [minus.mul_add(eta[0], sum[0]), minus.mul_add(eta[1], sum[1]), minus.mul_add(eta[2], sum[2])]
///     }
///
///     fn uses_attitude(&self) -> bool {
///         false
///     }
/// }
///
/// /// |μ| after a second.
/// fn norm<F: LaneForce, R: FastRetraction>(force: F, retraction: R) -> Result<f64, Box<dyn std::error::Error>>
/// where
///     VariationalInLanes<F, R, 3, 3>: OneStep<f64, 3, 3>,
/// {
///     let (body, gauss) = (Quadratic::diagonal([1.0, 2.0, 3.0])?, Family::Gauss.tableau(3)?);
///     // In the widest registers of this processor, which is also what happens without a choice.
///     let mut method = VariationalInLanes::new(body, force, retraction, gauss)?.in_registers(Registers::detect());
///     let momentum = Covector::<f64, 3>::new(0.6, 0.0, 0.8);
///     let mut state = State { time: 0.0, momentum, attitude: Matrix::identity() };
///     for _ in 0..10 {
///         method.step(&mut state, 0.1)?;
///     }
///     Ok(state.momentum.norm())
/// }
///
/// assert!((norm(Free, CayleySo3::new())? - 1.0).abs() < 1e-14);
/// assert!((norm(Damping(0.1), ExponentialSo3::new())? - 1.0).abs() < 1e-14);
/// assert!(norm(Relaxation(0.1), CayleySo3::new())? != 1.0);
/// assert!(norm(Friction, CayleySo3::new())? < 1.0);
///
/// // At most eight stages.
/// let (body, gauss) = (Quadratic::diagonal([1.0, 2.0, 3.0])?, Family::Gauss.tableau(9)?);
/// let refused = VariationalInLanes::new(body, Free, CayleySo3::new(), gauss);
/// assert!(matches!(refused, Err(UnfitTableau { stages: 9, .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct VariationalInLanes<F, R: FastRetraction<N, D>, const N: usize, const D: usize> {
    columns: Columns,
    pub(in crate::integrators) group: R::Lanes,
    pub(in crate::integrators) force: F,
    pub(in crate::integrators) inverse: [[f64; N]; N],
    diagonal: bool,
    /// The size of the largest entry of the inverse inertia.
    mobility: f64,
    registers: Registers,
    settings: Settings<f64>,
    /// What takes the steps that fixed-point iterations do not solve.
    newton: General<F, R, N, D>,
    last: Last<N, D>,
    /// How much the forces change as g does, where rounding of g has decided when a step was solved; else 0.
    sensitivity: f64,
}

/// The step of a body and a force in lanes, one stage after the other.
type General<F, R, const N: usize, const D: usize> =
    Variational<f64, N, D, Quadratic<f64, N>, OnBody<F, <R as FastRetraction<N, D>>::Lanes, N, D>, R>;

/// What the last step left; of size 0 where there was none.
#[derive(Clone, Copy, Debug)]
struct Last<const N: usize, const D: usize> {
    step: f64,
    /// The time it ended at, and what rounding has cut off that.
    time: f64,
    time_cut: f64,
    state: Packed<N, D>,
    memory: Memory<N>,
    jump: f64,
}

impl<const N: usize, const D: usize> Default for Last<N, D> {
    #[inline(always)]
    fn default() -> Self {
        Self { step: 0.0, time: 0.0, time_cut: 0.0, state: Packed::default(), memory: Memory::default(), jump: 0.0 }
    }
}

impl<F: LaneForce<N, D>, R: FastRetraction<N, D>, const N: usize, const D: usize> VariationalInLanes<F, R, N, D> {
    /// The fast step of a body, a force, a retraction and a tableau of up to eight stages.
    ///
    /// # Errors
    /// More stages than that.
    pub fn new(
        lagrangian: Quadratic<f64, N>,
        force: F,
        retraction: R,
        tableau: Tableau<f64>,
    ) -> Result<Self, UnfitTableau> {
        Self::with_settings(lagrangian, force, retraction, tableau, Settings::default())
    }

    /// The same with settings of one's own.
    ///
    /// # Errors
    /// As [`VariationalInLanes::new`].
    pub fn with_settings(
        lagrangian: Quadratic<f64, N>,
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
        let inverse: [[f64; N]; N] = std::array::from_fn(|r| std::array::from_fn(|c| lagrangian.inverse()[(r, c)]));
        let diagonal = (0..N).all(|r| (0..N).all(|c| r == c || inverse[r][c] == 0.0));
        let mobility = max_abs(lagrangian.inverse());
        let columns = Columns::new(&tableau, weights.as_ref());
        let group = retraction.in_lanes();
        let on_body = OnBody { force: force.clone(), group: group.clone(), lagrangian: lagrangian.clone() };
        let newton = Variational::with_settings(lagrangian, on_body, retraction, tableau, settings);
        Ok(Self {
            columns,
            group,
            force,
            inverse,
            diagonal,
            mobility,
            registers: Registers::detect(),
            settings,
            newton,
            last: Last::default(),
            sensitivity: 0.0,
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

    pub(in crate::integrators) fn stages(&self) -> usize {
        self.columns.stages
    }

    /// ξ of the last step, g ← g τ(ξ), if fixed-point iterations took it.
    pub(in crate::integrators) fn last_increment(&self) -> Option<[f64; N]> {
        (self.last.step != 0.0).then_some(self.last.memory.increment)
    }

    /// ξ of the last step that fixed-point iterations took.
    pub(in crate::integrators) fn increment(&self) -> Vector<f64, N> {
        self.last.memory.increment.into()
    }

    /// Ξ_i and η_i of that step.
    pub(in crate::integrators) fn stage(&self, i: usize) -> (Vector<f64, N>, Vector<f64, N>) {
        let momentum = std::array::from_fn(|a| self.last.memory.momenta[a].0[i]);
        let displacement = |a: usize| R::Lanes::UNIT * self.last.memory.displacements[a].0[i];
        (std::array::from_fn(displacement).into(), velocity(&self.inverse, momentum).into())
    }

    /// The same method one stage after the other, with the same parts.
    pub(in crate::integrators) fn general(&self) -> &General<F, R, N, D> {
        &self.newton
    }

    /// η_i of the last step, of all stages.
    #[cfg(feature = "harness")]
    pub(crate) fn stage_velocities(&self) -> Vec<Vec<f64>> {
        if self.last.step == 0.0 {
            return self.newton.stage_velocities().map(|eta| eta.as_slice().to_vec()).collect();
        }
        let inverse = Matrix::<f64, N>::from_fn(|r, c| self.inverse[r][c]);
        let momentum = |i: usize| Vector::from_fn(|a, _| self.last.memory.momenta[a].0[i]);
        (0..self.columns.stages).map(|i| (inverse * momentum(i)).as_slice().to_vec()).collect()
    }

    /// ad*_η m + f: μ̇ there.
    #[inline]
    pub(in crate::integrators) fn slope(&self, time: f64, at: &Packed<N, D>, body: [[f64; N]; 2]) -> [f64; N] {
        slope(&self.force, &self.group, time, &at.columns, body)
    }

    /// How much the forces change as g does; 0 where they do not.
    #[cold]
    pub(in crate::integrators) fn sensitivity_at(&self, state: &State<f64, N, D>) -> f64 {
        let momentum = std::array::from_fn(|k| state.momentum[k]);
        let eta = Vector::from(velocity(&self.inverse, momentum));
        if self.force.uses_attitude() { self.newton.sensitivity(state, &eta) } else { 0.0 }
    }

    /// What Newton's method and the continuation in h say of a step that fixed-point iterations do not solve.
    #[cold]
    pub(in crate::integrators) fn diagnose(&mut self, state: &State<f64, N, D>, step: f64) -> StepError {
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

    /// One step in lanes, which replaces its state on success: `state`, or the one that the last step left where none is given.
    /// A function of its own: the kernels are compiled once for all that call it.
    pub(in crate::integrators) fn take(
        &mut self,
        state: Option<&mut Packed<N, D>>,
        time: f64,
        step: f64,
        warm: bool,
        limits: Limits<N>,
    ) -> Result<Taken, Refused> {
        let Last { state: own, memory, .. } = &mut self.last;
        let state = state.unwrap_or(own);
        self.registers.run(Step::<F, R::Lanes, N, D> {
            columns: &self.columns,
            group: &self.group,
            force: &self.force,
            inverse: &self.inverse,
            diagonal: self.diagonal,
            mobility: self.mobility,
            time,
            step,
            state,
            memory,
            warm,
            limits,
        })
    }
}

impl<F, R, const N: usize, const D: usize> OneStep<f64, N, D> for VariationalInLanes<F, R, N, D>
where
    F: LaneForce<N, D>,
    R: FastRetraction<N, D>,
{
    fn step(&mut self, state: &mut State<f64, N, D>, h: f64) -> Result<Report<f64>, StepError> {
        let tolerance = self.settings.tolerance;
        let mut limits = Limits {
            tolerance,
            floor: self.settings.floor,
            rounding: Limits::<N>::rounding(h, self.sensitivity, tolerance),
            switch: tolerance,
            max_fixed_point_iterations: self.settings.max_fixed_point_iterations,
            strict: None,
        };
        let known = self.last.step != 0.0 && self.last.state.is(state);
        let warm = known && self.last.step == h;
        if warm {
            limits.switch = f64::max(0.25 * self.last.jump, tolerance);
        }
        if !known {
            state.check_finite(h)?;
            self.last.state = Packed::of(state);
        }
        let cut = if known && self.last.time == state.time { self.last.time_cut } else { 0.0 };
        let mut spent = 0;
        match self.take(None, state.time, h, warm, limits) {
            Ok(taken) => {
                spent += taken.predictor + taken.iterations;
                let passed = h - cut;
                let time = state.time + passed;
                if time.is_finite() {
                    (self.last.step, self.last.jump) = (h, taken.jump);
                    (self.last.time, self.last.time_cut) = (time, (time - state.time) - passed);
                    self.last.state.unpack(state);
                    state.time = time;
                    return Ok(Report { solver: Solver::FixedPoint, iterations: spent, residual: taken.residual });
                }
            }
            Err(Refused::NotContracted(iterations) | Refused::Delta(_, iterations)) => spent += iterations,
        }
        self.last.step = 0.0;
        let mut report = self.newton.step(state, h)?;
        self.sensitivity = self.newton.rounded(state).unwrap_or(self.sensitivity);
        report.iterations += spent;
        Ok(report)
    }
}
