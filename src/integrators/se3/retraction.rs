//! The Cayley map of SE(3) on eight displacements at once.

use super::Vec6;
use crate::algebra::catalogue::Entry;
use crate::algebra::{LieAlgebra, Matrix, Vector};
use crate::group::MatrixGroup;
use crate::integrators::State;
use crate::integrators::lanes::Lanes;
use crate::integrators::so3::each;
use crate::integrators::so3::retraction::{LaneRetraction, TANGENT, add_scaled, cross, dot, horner, scale};
use crate::integrators::so3::step::FastRetraction;
use crate::integrators::so3::{Row, Vec3};
use crate::retraction::{self, CayleyPoint, Retraction, RetractionError};
use crate::scalar::Scalar;

/// The Cayley map on SE(3), in the basis of [`Entry::Se3`]: [`retraction::Cayley`], which also has a form in lanes.
#[derive(Clone, Debug)]
pub struct CayleySe3(retraction::Cayley<f64, 6, 4>);

impl CayleySe3 {
    /// The Cayley map.
    pub fn new() -> Self {
        let group = MatrixGroup::from_entry(&Entry::Se3).expect("se(3) has dimension 6 and 4×4 matrices");
        Self(retraction::Cayley::new(group).expect("se(3) is closed under triple products"))
    }
}

impl Default for CayleySe3 {
    fn default() -> Self {
        Self::new()
    }
}

impl Retraction<f64, 6, 4> for CayleySe3 {
    type Point<S: Scalar<Base = f64>> = CayleyPoint<f64, S, 6>;

    fn name(&self) -> &'static str {
        self.0.name()
    }

    fn algebra(&self) -> &LieAlgebra<f64, 6> {
        self.0.algebra()
    }

    fn tau<S: Scalar<Base = f64>>(&self, x: &Vector<S, 6>) -> Result<Matrix<S, 4>, RetractionError> {
        self.0.tau(x)
    }

    fn tau_inv<S: Scalar<Base = f64>>(&self, g: &Matrix<S, 4>) -> Result<Vector<S, 6>, RetractionError> {
        self.0.tau_inv(g)
    }

    fn at<S: Scalar<Base = f64>>(&self, x: &Vector<S, 6>) -> Result<Self::Point<S>, RetractionError> {
        self.0.at(x)
    }
}

/// The rows of g that lie in lanes 0, 1, 2 and 4: the last is (0, 0, 0, 1) on SE(3).
const LANE_OF_ROW: [usize; 4] = [0, 1, 2, 4];

/// Columns 0, 1, 2 of g in rows 3, 4, 5; column 3, the position, in row 0.
const ROW_OF_COLUMN: [usize; 4] = [3, 4, 5, 0];

impl FastRetraction<6, 4> for CayleySe3 {
    type Lanes = Cayley;

    fn pack(state: &State<f64, 6, 4>) -> [Row; 6] {
        let mut rows = [Row::ZERO; 6];
        for a in 0..6 {
            rows[a].0[3] = state.momentum[a];
        }
        for c in 0..4 {
            for r in 0..4 {
                rows[ROW_OF_COLUMN[c]].0[LANE_OF_ROW[r]] = state.attitude[(r, c)];
            }
        }
        rows
    }

    fn unpack(rows: &[Row; 6], state: &mut State<f64, 6, 4>) {
        for a in 0..6 {
            state.momentum[a] = rows[a].0[3];
        }
        for c in 0..4 {
            for r in 0..4 {
                state.attitude[(r, c)] = rows[ROW_OF_COLUMN[c]].0[LANE_OF_ROW[r]];
            }
        }
    }
}

const MOMENTUM: [f64; 8] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
const ATTITUDE: [f64; 8] = [1.0, 1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0];

/// The Cayley map in lanes.
///
/// With x = (ω, v), ρ = ω/2, s = 1/(1 + |ρ|²), (1 ∓ ρ̂)⁻¹ z = s(z ± ρ×z + ρ(ρ·z)) =: A z, B z:
///
/// ```text
/// dτ⁻¹(y, u) = (y + ρ×y + ρ(ρ·y), r + ρ×r), r = u + ½ v×y      τ: R z − z = 2s(ρ×z + ρ×(ρ×z)), t = A v
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Cayley;

/// (1 − 2 tan(θ/2)/θ)/θ² in powers of θ².
const TANGENT_LESS: [f64; 3] = [-TANGENT[1], -TANGENT[2], -TANGENT[3]];

/// What the operations at x share.
#[derive(Clone, Copy, Debug)]
pub struct At<V> {
    /// s.
    s: V,
    /// ρ = ω/2.
    rho: Vec3<V>,
    /// ½ A v.
    shift: Vec3<V>,
}

#[inline(always)]
fn split<V: Lanes>(x: Vec6<V>) -> (Vec3<V>, Vec3<V>) {
    ([x[0], x[1], x[2]], [x[3], x[4], x[5]])
}

#[inline(always)]
fn join<V: Lanes>(a: Vec3<V>, b: Vec3<V>) -> Vec6<V> {
    [a[0], a[1], a[2], b[0], b[1], b[2]]
}

/// z + x × y.
#[inline(always)]
fn add_cross<V: Lanes>(z: Vec3<V>, x: Vec3<V>, y: Vec3<V>) -> Vec3<V> {
    [
        x[2].neg_mul_add(y[1], x[1].mul_add(y[2], z[0])),
        x[0].neg_mul_add(y[2], x[2].mul_add(y[0], z[1])),
        x[1].neg_mul_add(y[0], x[0].mul_add(y[1], z[2])),
    ]
}

/// z + ρ×z + ρ(ρ·z): A z/s. With the arguments of the product exchanged, B z/s.
#[inline(always)]
fn ahead<V: Lanes>(rho: Vec3<V>, z: Vec3<V>) -> Vec3<V> {
    add_scaled(add_cross(z, rho, z), dot(rho, z), rho)
}

/// z − ρ×z + ρ(ρ·z): B z/s.
#[inline(always)]
fn behind<V: Lanes>(rho: Vec3<V>, z: Vec3<V>) -> Vec3<V> {
    add_scaled(add_cross(z, z, rho), dot(rho, z), rho)
}

/// R z − z.
#[inline(always)]
fn rotated<V: Lanes>(at: At<V>, z: Vec3<V>) -> Vec3<V> {
    let once = cross(at.rho, z);
    scale(at.s + at.s, add_cross(once, at.rho, once))
}

impl LaneRetraction<6> for Cayley {
    type At<V: Lanes> = At<V>;

    #[inline(always)]
    fn at<V: Lanes>(x: Vec6<V>) -> At<V> {
        let (omega, v) = split(x);
        let half = v[0].constant(0.5);
        let rho = scale(half, omega);
        let one = half.constant(1.0);
        let s = one / rho[2].mul_add(rho[2], rho[1].mul_add(rho[1], rho[0].mul_add(rho[0], one)));
        At { s, rho, shift: scale(half * s, ahead(rho, v)) }
    }

    /// b' = b − ρ×b; (a − ρ×a + ρ(ρ·a) + ½ b'×v, b').
    #[inline(always)]
    fn unpull<V: Lanes>(at: At<V>, x: Vec6<V>, p: Vec6<V>) -> Vec6<V> {
        let ((a, b), (_, v)) = (split(p), split(x));
        let b = add_cross(b, b, at.rho);
        join(add_cross(behind(at.rho, a), b, scale(at.s.constant(0.5), v)), b)
    }

    #[inline(always)]
    fn rate<V: Lanes>(at: At<V>, x: Vec6<V>, eta: Vec6<V>) -> Vec6<V> {
        let ((y, u), (_, v)) = (split(eta), split(x));
        let r = add_cross(u, scale(at.s.constant(0.5), v), y);
        join(ahead(at.rho, y), add_cross(r, at.rho, r))
    }

    /// b' = A b; (s(a + ρ×a) + ½ A v × b', b').
    #[inline(always)]
    fn pull<V: Lanes>(at: At<V>, _x: Vec6<V>, f: Vec6<V>) -> Vec6<V> {
        let (a, b) = split(f);
        let b = scale(at.s, ahead(at.rho, b));
        join(add_cross(scale(at.s, add_cross(a, at.rho, a)), at.shift, b), b)
    }

    /// (R a + t×R b, R b) − (a, b).
    #[inline(always)]
    fn turned<V: Lanes>(at: At<V>, _x: Vec6<V>, f: Vec6<V>) -> Vec6<V> {
        let (a, b) = split(f);
        let moved = rotated(at, b);
        let whole = [b[0] + moved[0], b[1] + moved[1], b[2] + moved[2]];
        let two = at.s.constant(2.0);
        join(add_cross(rotated(at, a), scale(two, at.shift), whole), moved)
    }

    /// With p = (a, b) and m₃ = a − ρ×a + ρ(ρ·a), the first part of m less ½ b'×v:
    /// (s[½ m₃×y − (a·y)ρ] − ½ B u × b, ½ B(b×y)).
    #[inline(always)]
    fn pull_dd<V: Lanes>(at: At<V>, x: Vec6<V>, p: Vec6<V>, m: Vec6<V>, y: Vec6<V>) -> Vec6<V> {
        let ((a, b), (m3, m_b), (y, u), (_, v)) = (split(p), split(m), split(y), split(x));
        let half = at.s * at.s.constant(0.5);
        let m3 = add_cross(m3, scale(at.s.constant(0.5), v), m_b);
        let first = add_cross(cross(m3, y), b, behind(at.rho, u));
        let twice = dot(a, y) * at.s.constant(2.0);
        let first = each!(3, k => twice.neg_mul_add(at.rho[k], first[k]));
        join(scale(half, first), scale(half, behind(at.rho, cross(b, y))))
    }

    /// (π×ω + p×v, p×ω).
    #[inline(always)]
    fn coad<V: Lanes>(m: Vec6<V>, eta: Vec6<V>) -> Vec6<V> {
        let ((pi, p), (omega, v)) = (split(m), split(eta));
        join(add_cross(cross(pi, omega), p, v), cross(p, omega))
    }

    /// 2 tanh(σ/2) of the matrix σ = (ω, v): (P ω, v + Q ω×(ω×v)), P = 2 tan(θ/2)/θ = 1 − θ² Q, to θ⁶.
    #[inline(always)]
    fn displacement<V: Lanes>(t: V, first: Vec6<V>, middle: Vec6<V>, last: Vec6<V>) -> Vec6<V> {
        let (four, sixth, twelfth) = (t.constant(4.0), t * t.constant(1.0 / 6.0), t * t.constant(1.0 / 12.0));
        let (omega, v) = split(each!(6, k => sixth * four.mul_add(middle[k], first[k] + last[k])));
        let (turn, shift) = split(each!(6, k => twelfth * (last[k] - first[k])));
        // σ + [σ, t/12 (η₁ − η₀)].
        let v = add_cross(add_cross(v, omega, shift), v, turn);
        let omega = add_cross(omega, omega, turn);
        let t = dot(omega, omega);
        let q = horner(&TANGENT_LESS, t);
        join(scale(t.neg_mul_add(q, t.constant(1.0)), omega), add_scaled(v, q, cross(omega, cross(omega, v))))
    }

    /// R' = R R_ξ: its rows are turned as a covector (0, b) is. t' = t + R t_ξ, t_ξ = −B v at `back`.
    #[inline(always)]
    fn increments<V: Lanes>(at_back: At<V>, back: Vec6<V>, values: Vec6<V>, kicks: Vec6<V>) -> Vec6<V> {
        let turned = Self::turned(at_back, back, each!(6, k => values[k] + kicks[k]));
        let mut sum: Vec6<V> = each!(6, k => turned[k] + kicks[k]);
        let of_momentum = at_back.s.read(&MOMENTUM);
        for k in 0..3 {
            sum[k] = of_momentum * sum[k];
        }
        let (_, rows) = split(values);
        let back_shift = scale(at_back.s * at_back.s.read(&ATTITUDE), behind(at_back.rho, split(back).1));
        sum[0] = sum[0] - dot(rows, back_shift);
        sum
    }

    #[inline(always)]
    fn square<V: Lanes>(x: Vec6<V>) -> V {
        let (omega, _) = split(x);
        dot(omega, omega)
    }

    fn in_domain(largest_square: f64) -> bool {
        largest_square < 1e16
    }
}
