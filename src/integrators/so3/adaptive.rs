//! A tolerance in, an answer out: the order and the steps are chosen on the way.

use super::retraction::Exponential;
use crate::integrators::State;
use crate::integrators::lanes::adaptive::{MOST_STEPS, Pace, Run, advance, drive, gauss, length, velocity};
use crate::integrators::lanes::kernel::Packed;
use crate::integrators::lanes::{LaneForce, LaneGroup as _, One, Registers, Solved, VariationalInLanes};
use crate::integrators::solve::SolveError;
use crate::mechanics::lagrangian::Quadratic;
use crate::retraction::{CayleySo3, ExponentialSo3};

/// |μ̇| relative to |μ||Ω| below which the motion counts as nearly a steady rotation.
const STEADY: f64 = 1e-5;

/// The angle |Ω|h of the first step that is tried.
const FIRST_ANGLE: f64 = 1.25;

/// The largest angle |Ω|h of a step.
const LARGEST_ANGLE: f64 = 5.75;

/// The forced variational step on SO(3) with order, retraction and step size chosen for a tolerance.
///
/// The tolerance is for the whole run: each step of size h may contribute the part h/T of it, relative to |μ| and to |Ω|, as that of
/// [`AdaptiveInLanes`](crate::integrators::lanes::AdaptiveInLanes). The local error is estimated from δ, the difference between the variational scheme and the chart scheme of the
/// same order, which the step computes anyway. δ vanishes where the direction of Ω stays the same: unless such motions are
/// steady ([`LaneForce::vanishes_when_steady`]), the error is estimated from the Legendre coefficients of μ̇ at the stages,
/// too, and from what their polynomial misses at the ends of the step, which shows kinks of a force such as that of a
/// quadratic drag at rest. Order: Gauss with eight stages for tolerances below 10⁻⁶, six below 10⁻⁴, four above. Retraction:
/// Cayley, and the exponential where the motion is nearly a steady rotation, which it integrates exactly at any step size:
/// there δ vanishes and the steps grow to several radians. A rotation that stays steady to the tolerance until the end is
/// one step. With a force that depends on the attitude no motion is taken for a steady one: the map is Cayley's throughout, and the error
/// relative to what the force makes of μ in a step, where that is more than |μ|.
///
/// A run is not reversible: the steps differ on the way back. For that, take fixed steps with [`VariationalInLanes`]. At a jump of a
/// force it ends in an error, or passes it unseen where it is small: run up to a known jump and on from there, or take
/// [`Solve`](crate::integrators::solve::Solve), which finds jumps.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::State;
/// use euler_poincare::integrators::lanes::Damping;
/// use euler_poincare::integrators::so3::AdaptiveSo3;
/// use euler_poincare::mechanics::lagrangian::Quadratic;
///
/// let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
/// let mut solver = AdaptiveSo3::new(body, Damping(1.0));
/// let momentum = Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2.0_f64.sqrt();
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::identity() };
/// let solved = solver.solve(&mut state, 1.0, 1e-12)?;
/// assert!((state.momentum[0] - 0.2414593544179369).abs() < 1e-12);
/// assert_eq!(solved.steps, 1);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct AdaptiveSo3<F> {
    /// Gauss with 4, 6 and 8 stages.
    methods: [VariationalInLanes<F, CayleySo3<f64>, 3, 3>; 3],
    /// Gauss with 8 stages.
    steady: VariationalInLanes<F, ExponentialSo3<f64>, 3, 3>,
    most: usize,
}

impl<F: LaneForce> AdaptiveSo3<F> {
    /// The solver of a body and a force.
    pub fn new(lagrangian: Quadratic<f64, 3>, force: F) -> Self {
        Self {
            methods: [4, 6, 8].map(|stages| gauss(&lagrangian, &force, CayleySo3::new(), stages)),
            steady: gauss(&lagrangian, &force, ExponentialSo3::new(), 8),
            most: MOST_STEPS,
        }
    }

    /// The same with another limit to the steps that a run may try than a million.
    pub fn with_max_steps(mut self, steps: usize) -> Self {
        self.most = steps;
        self
    }

    /// The same in registers of another kind: for tests that compare them.
    pub fn in_registers(mut self, registers: Registers) -> Self {
        self.methods = self.methods.map(|method| method.in_registers(registers));
        self.steady = self.steady.in_registers(registers);
        self
    }

    /// Replaces `state` by the state a time `duration` later (of either sign), to a relative error of about `tolerance`.
    ///
    /// # Errors
    /// See [`SolveError`].
    pub fn solve(&mut self, state: &mut State<f64, 3, 3>, duration: f64, tolerance: f64) -> Result<Solved, SolveError> {
        self.solve_with(state, duration, tolerance, |_, _| ())
    }

    /// The same; `observe` is called after each step with the step's size.
    ///
    /// # Errors
    /// See [`SolveError`].
    pub fn solve_with(
        &mut self,
        state: &mut State<f64, 3, 3>,
        duration: f64,
        tolerance: f64,
        mut observe: impl FnMut(&State<f64, 3, 3>, f64),
    ) -> Result<Solved, SolveError> {
        let Self { methods, steady, most } = self;
        drive(
            methods,
            *most,
            state,
            [duration, tolerance],
            &mut observe,
            |method, run, place, [momentum, eta], observe| {
                let slope = |method: &VariationalInLanes<F, CayleySo3<f64>, 3, 3>, t| {
                    method.slope(t, &place.packed, [momentum, eta])
                };
                if method.force.uses_attitude() {
                    // Whether a motion is steady depends on where g will be: no look at that.
                    let now = slope(method, run.time());
                    // A body at rest turns by half the angular acceleration times t².
                    let rate = length(eta) + length(velocity(&method.inverse, now)).sqrt();
                    return advance(method, run, place, || rate, FREELY, |_, _, _| None, observe);
                }
                // A run of one ordinary step needs no look at how steady the motion is.
                let ordinary = run.fresh() && {
                    let square = eta.iter().fold(0.0, |sum, v| sum + (run.span * v).powi(2));
                    square > 0.0 && square <= FIRST_ANGLE * FIRST_ANGLE
                };
                if ordinary {
                    run.next = run.span;
                } else if tolerance < 1e-6 {
                    let (size, rate) = (length(momentum), length(eta));
                    let turning = length(slope(method, run.time()));
                    if turning <= STEADY * size * rate {
                        // A force may depend on time: what it is at the stages of a step to the end.
                        let later = run.times(method.tableau()).map(|t| slope(method, t));
                        let turning = later.fold(turning, |worst, rate| worst.max(length(rate)));
                        // μ may turn by |μ̇| t, and the attitude with it by |μ̇| t²/2 times |Ω|/|μ|.
                        let left = run.span - run.done;
                        if turning * left * (1.0 + 0.5 * rate * left) <= 0.25 * tolerance * size {
                            run.check(place.state)?;
                            rotate(run, &mut place.packed, eta, left);
                            observe(place.reach(run.time()), run.sign * left);
                            return Ok(());
                        }
                        return advance(steady, run, place, || rate, STEADILY, |_, _, _| None, observe);
                    }
                }
                advance(method, run, place, || length(eta), FREELY, |_, _, _| None, observe)
            },
        )
    }
}

/// A motion that is not steady.
const FREELY: Pace = Pace { first: FIRST_ANGLE, growth: 1.2, steady: None };
/// One that nearly is.
const STEADILY: Pace = Pace { steady: Some(LARGEST_ANGLE), ..FREELY };

/// A steady rotation with the velocity η: g ← g exp(hη).
fn rotate(run: &mut Run, packed: &mut Packed<3, 3>, eta: [f64; 3], left: f64) {
    // The angle modulo 2π: exp has this period along an axis.
    let angle = run.sign * left * length(eta);
    let rest = (angle / std::f64::consts::TAU).round().mul_add(-std::f64::consts::TAU, angle);
    let factor = if angle == 0.0 { 0.0 } else { rest / angle * run.sign * left };
    let back = eta.map(|v| One(-factor * v));
    let at = Exponential.at(back, true);
    for row in 0..3 {
        let vector: [One<f64>; 3] = std::array::from_fn(|k| One(packed.columns[k].0[row]));
        let turned = Exponential.turned(&at, back, vector);
        for k in 0..3 {
            packed.columns[k].0[row] += turned[k].0;
        }
    }
    run.rest();
}
