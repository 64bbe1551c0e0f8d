//! The fast step with the attitude as a unit quaternion.

use super::retraction::{LaneRotation, less_product};
use crate::algebra::{Covector, Matrix};
use crate::integrators::lanes::{FastRetraction, LaneForce, One, VariationalInLanes};
use crate::integrators::{OneStep, Report, State, StepError};
use crate::retraction::{CayleySo3, ExponentialSo3};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion};

/// A state (t, μ, q): time, body momentum as a row vector, and the attitude as a unit quaternion, of which the rotation
/// matrix is the g of [`State`].
#[derive(Clone, Debug, PartialEq)]
pub struct QuaternionState {
    /// t.
    pub time: f64,
    /// μ.
    pub momentum: Covector<f64, 3>,
    /// q.
    pub attitude: UnitQuaternion<f64>,
}

/// The unit quaternion of the attitude, which is taken for a rotation.
impl From<State<f64, 3, 3>> for QuaternionState {
    fn from(state: State<f64, 3, 3>) -> Self {
        let State { time, momentum, attitude } = state;
        let quaternion = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(attitude));
        Self { time, momentum, attitude: UnitQuaternion::new_normalize(quaternion.into_inner()) }
    }
}

/// The attitude as the rotation matrix g of q.
impl From<QuaternionState> for State<f64, 3, 3> {
    fn from(state: QuaternionState) -> Self {
        let QuaternionState { time, momentum, attitude } = state;
        Self { time, momentum, attitude: attitude.to_rotation_matrix().into_inner() }
    }
}

/// A retraction of SO(3) in unit quaternions, or Euler's parameters (Shuster 1993; Hairer, Lubich and Wanner 2006, VII.5.3): the
/// axis n and the angle φ of τ(ξ) make (cos(φ/2), n sin(φ/2)), with tan(φ/2) = |ξ|/2 for the Cayley map and φ = |ξ| for exp.
pub trait HalfAngle: FastRetraction<Lanes: LaneRotation> {
    /// (w − 1, x, y, z) of the quaternion of τ(ξ), w ≥ 0 up to the angle π: near the unit without the loss of a difference.
    fn quaternion_less_one(xi: [f64; 3]) -> [f64; 4];
}

impl HalfAngle for CayleySo3<f64> {
    /// (1, ξ/2)/√(1 + |ξ|²/4).
    fn quaternion_less_one(xi: [f64; 3]) -> [f64; 4] {
        let square = 0.25 * (xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]);
        let size = (1.0 + square).sqrt();
        let scale = 0.5 / size;
        [-square / (size * (1.0 + size)), scale * xi[0], scale * xi[1], scale * xi[2]]
    }
}

impl HalfAngle for ExponentialSo3<f64> {
    /// (cos(θ/2), ξ sin(θ/2)/θ), θ = |ξ|.
    fn quaternion_less_one(xi: [f64; 3]) -> [f64; 4] {
        let angle = (xi[0] * xi[0] + xi[1] * xi[1] + xi[2] * xi[2]).sqrt();
        let scale = if angle == 0.0 { 0.5 } else { (0.5 * angle).sin() / angle };
        let quarter = (0.25 * angle).sin();
        [-2.0 * quarter * quarter, scale * xi[0], scale * xi[1], scale * xi[2]]
    }
}

/// [`VariationalInLanes`] on SO(3), on (μ, q).
///
/// The momentum is that of the other form, bit by bit where the force does not depend on the attitude; q ← q ⊗ τ(ξ) with the same ξ, as a
/// compensated sum q + q ⊗ (τ(ξ) − 1).
/// |q| = 1 is kept to round-off over any number of steps. Nothing is allocated by a step.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::State;
/// use euler_poincare::integrators::lanes::{Damping, VariationalInLanes};
/// use euler_poincare::integrators::so3::{HalfAngle, QuaternionSo3, QuaternionState};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::CayleySo3;
/// use euler_poincare::tableau::Family;
///
/// /// With Cayley's map or the exponential: both have a form in quaternions.
/// fn method<R: HalfAngle>(retraction: R) -> Result<QuaternionSo3<Damping, R>, Box<dyn std::error::Error>> {
///     let (body, gauss) = (Quadratic::diagonal([1.0, 2.0, 3.0])?, Family::Gauss.tableau(3)?);
///     Ok(QuaternionSo3::of(VariationalInLanes::new(body, Damping(0.1), retraction, gauss)?))
/// }
/// let mut method = method(CayleySo3::new())?;
/// let momentum = Covector::from([[0.3], [-0.2], [0.9]]);
/// let mut state = QuaternionState::from(State { time: 0.0, momentum, attitude: Matrix::identity() });
/// for _ in 0..100 {
///     method.step(&mut state, 0.1)?;
/// }
/// assert!((state.attitude.norm() - 1.0).abs() < 1e-15 && (state.time - 10.0).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct QuaternionSo3<F, R: FastRetraction> {
    method: VariationalInLanes<F, R, 3, 3>,
    /// The last time and momentum that were reached, with a rotation that tells how the body turned where no ξ is known: that of q,
    /// up to rounding, where the force depends on it.
    matrix: State<f64, 3, 3>,
    attitude: UnitQuaternion<f64>,
    /// What the sums that made `attitude` cut off.
    cut: [f64; 4],
}

impl<F: LaneForce, R: HalfAngle> QuaternionSo3<F, R> {
    /// The steps of `method`.
    pub fn of(method: VariationalInLanes<F, R, 3, 3>) -> Self {
        let matrix = State { time: 0.0, momentum: Covector::zeros(), attitude: Matrix::identity() };
        Self { method, matrix, attitude: UnitQuaternion::identity(), cut: [0.0; 4] }
    }

    /// The method whose steps these are.
    pub fn method(&self) -> &VariationalInLanes<F, R, 3, 3> {
        &self.method
    }

    /// One step of size h.
    ///
    /// # Errors
    /// As [`OneStep::step`]; a quaternion that is not finite, or further than 10⁻⁸ from unit length. `state` is left as it was.
    pub fn step(&mut self, state: &mut QuaternionState, h: f64) -> Result<Report<f64>, StepError> {
        if state.attitude != self.attitude {
            let departure = (state.attitude.as_ref().norm_squared() - 1.0).abs();
            if departure.is_nan() {
                return Err(StepError::NotFinite { what: "the attitude" });
            }
            if departure > 1e-8 {
                return Err(StepError::OffGroup { departure });
            }
            (self.attitude, self.cut) = (state.attitude, [0.0; 4]);
            if self.method.force.uses_attitude() {
                self.matrix.attitude = state.attitude.to_rotation_matrix().into_inner();
            }
        }
        if state.momentum != self.matrix.momentum {
            self.matrix.momentum = state.momentum;
            if !self.method.force.uses_attitude() {
                self.matrix.attitude = Matrix::identity();
            }
        }
        self.matrix.time = state.time;
        let before = self.matrix.attitude;
        let report = self.method.step(&mut self.matrix, h)?;
        let turn = match self.method.last_increment() {
            Some(xi) => R::quaternion_less_one(xi),
            None => less_one(&(before.transpose() * self.matrix.attitude)),
        };
        self.turn(turn);
        (state.time, state.momentum, state.attitude) = (self.matrix.time, self.matrix.momentum, self.attitude);
        Ok(report)
    }

    /// q ← q + q ⊗ `turn`, and along q back to unit length.
    fn turn(&mut self, turn: [f64; 4]) {
        let q = self.attitude.as_ref();
        let q = [q.w, q.i, q.j, q.k];
        let [a, b, c, d] = turn;
        // q ⊗ (a, (b, c, d)).
        let product = less_product(q.map(|x| One(a * x)), q.map(One), [-b, -c, -d].map(One)).map(|x| x.0);
        let long = 0.5 * (1.0 - q.iter().map(|x| x * x).sum::<f64>());
        let mut next = q;
        for k in 0..4 {
            let y = long.mul_add(q[k], product[k]) - self.cut[k];
            next[k] = q[k] + y;
            self.cut[k] = (next[k] - q[k]) - y;
        }
        self.attitude = UnitQuaternion::new_unchecked(Quaternion::new(next[0], next[1], next[2], next[3]));
    }
}

/// (w − 1, x, y, z) of the quaternion of a rotation, w ≥ 0.
fn less_one(rotation: &Matrix<f64, 3>) -> [f64; 4] {
    let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(*rotation));
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    let [x, y, z] = [q.i, q.j, q.k].map(|v| sign * v);
    [-(x * x + y * y + z * z) / (1.0 + sign * q.w), x, y, z]
}
