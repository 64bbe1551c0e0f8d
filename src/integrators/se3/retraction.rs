//! The Cayley map of SE(3) on eight displacements at once.

use super::Vec6;
use crate::algebra::brackets::Brackets;
use crate::algebra::catalogue::Entry;
use crate::algebra::{LieAlgebra, Matrix, Vector};
use crate::group::MatrixGroup;
use crate::integrators::lanes::Lanes;
use crate::integrators::so3::Vec3;
use crate::integrators::so3::each;
use crate::integrators::so3::retraction::{
    LaneRetraction, TANGENT, add_cross, add_scaled, cross, dot, first, horner, join, last, scale,
};
use crate::integrators::so3::step::FastRetraction;
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

    fn rough_rates<const W: usize>(
        &self,
        brackets: &Brackets<f64>,
        x: &[[f64; W]; 6],
        eta: &[[f64; W]; 6],
    ) -> [[f64; W]; 6] {
        self.0.rough_rates(brackets, x, eta)
    }
}

impl FastRetraction<6, 4> for CayleySe3 {
    type Lanes = Cayley;
}

const MOMENTUM: [f64; 8] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0];
const TWICE_ATTITUDE: [f64; 8] = [2.0, 2.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0];

/// The Cayley map in lanes.
///
/// With x = 2 (ρ, w), s = 1/(1 + |ρ|²), (1 ∓ ρ̂)⁻¹ z = s(z ± ρ×z + ρ(ρ·z)) =: A z, B z:
///
/// ```text
/// dτ⁻¹(y, u) = (y + ρ×y + ρ(ρ·y), r + ρ×r), r = u + w×y      τ: R z − z = 2s(ρ×z + ρ×(ρ×z)), t = 2 A w
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Cayley;

/// (½ − tan(θ/2)/θ)/θ² in powers of θ².
const TANGENT_LESS: [f64; 3] = [-TANGENT[1], -TANGENT[2], -TANGENT[3]];

/// What the operations at x share.
#[derive(Clone, Copy, Debug)]
pub struct At<V> {
    /// s.
    s: V,
    /// A w.
    shift: Vec3<V>,
}

#[inline(always)]
fn split<V: Lanes>(x: Vec6<V>) -> (Vec3<V>, Vec3<V>) {
    (first(x), last(x))
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
fn rotated<V: Lanes>(at: At<V>, rho: Vec3<V>, z: Vec3<V>) -> Vec3<V> {
    let once = cross(rho, z);
    scale(at.s + at.s, add_cross(once, rho, once))
}

impl LaneRetraction<6> for Cayley {
    const HALVED: bool = true;

    type At<V: Lanes> = At<V>;

    #[inline(always)]
    fn at<V: Lanes>(x: Vec6<V>) -> At<V> {
        let (rho, w) = split(x);
        let one = w[0].constant(1.0);
        let s = rho[2].mul_add(rho[2], rho[1].mul_add(rho[1], rho[0].mul_add(rho[0], one))).reciprocal();
        At { s, shift: scale(s, ahead(rho, w)) }
    }

    /// b' = b − ρ×b; (a − ρ×a + ρ(ρ·a) + b'×w, b').
    #[inline(always)]
    fn unpull<V: Lanes>(_: At<V>, x: Vec6<V>, p: Vec6<V>) -> Vec6<V> {
        let ((a, b), (rho, w)) = (split(p), split(x));
        let b = add_cross(b, b, rho);
        join(add_cross(behind(rho, a), b, w), b)
    }

    #[inline(always)]
    fn rate<V: Lanes>(_: At<V>, x: Vec6<V>, eta: Vec6<V>) -> Vec6<V> {
        let ((y, u), (rho, w)) = (split(eta), split(x));
        let r = add_cross(u, w, y);
        join(ahead(rho, y), add_cross(r, rho, r))
    }

    /// b' = A b; (s(a + ρ×a) + A w × b', b').
    #[inline(always)]
    fn pull<V: Lanes>(at: At<V>, x: Vec6<V>, f: Vec6<V>) -> Vec6<V> {
        let ((a, b), (rho, _)) = (split(f), split(x));
        let b = scale(at.s, ahead(rho, b));
        join(add_cross(scale(at.s, add_cross(a, rho, a)), at.shift, b), b)
    }

    /// (R a + t×R b, R b) − (a, b).
    #[inline(always)]
    fn turned<V: Lanes>(at: At<V>, x: Vec6<V>, f: Vec6<V>) -> Vec6<V> {
        let ((a, b), (rho, _)) = (split(f), split(x));
        let moved = rotated(at, rho, b);
        let whole = [b[0] + moved[0], b[1] + moved[1], b[2] + moved[2]];
        let shift = each!(3, k => at.shift[k] + at.shift[k]);
        join(add_cross(rotated(at, rho, a), shift, whole), moved)
    }

    /// v + 2s (u + u × ρ), u = v × ρ.
    #[inline(always)]
    fn seen<V: Lanes>(at: At<V>, x: Vec6<V>, v: Vec3<V>) -> Vec3<V> {
        let (rho, _) = split(x);
        let once = cross(v, rho);
        add_scaled(v, at.s + at.s, add_cross(once, once, rho))
    }

    /// p + R t, t = 2 A w.
    #[inline(always)]
    fn placed<V: Lanes>(at: At<V>, _: Vec6<V>, position: Vec3<V>, rows: [Vec3<V>; 3]) -> Vec3<V> {
        let two = at.s.constant(2.0);
        each!(3, r => two.mul_add(dot(rows[r], at.shift), position[r]))
    }

    /// With p = (a, b), (y, u) half the rate and m₃ = a − ρ×a + ρ(ρ·a), the first part of m less b'×w:
    /// (s[m₃×y − 2(a·y)ρ] − B u × b, B(b×y)).
    #[inline(always)]
    fn pull_dd<V: Lanes>(at: At<V>, x: Vec6<V>, p: Vec6<V>, m: Vec6<V>, y: Vec6<V>) -> Vec6<V> {
        let ((a, b), (m3, m_b), (y, u), (rho, w)) = (split(p), split(m), split(y), split(x));
        let m3 = add_cross(m3, w, m_b);
        let first = add_cross(cross(m3, y), b, behind(rho, u));
        let along = dot(a, y);
        let twice = along + along;
        let first = each!(3, k => twice.neg_mul_add(rho[k], first[k]));
        join(scale(at.s, first), scale(at.s, behind(rho, cross(b, y))))
    }

    /// tanh(σ/2) of the matrix σ = (ω, v): (P ω, v/2 + Q ω×(ω×v)), P = tan(θ/2)/θ = ½ − θ² Q, to θ⁶.
    #[inline(always)]
    fn displacement<V: Lanes>(t: V, first: Vec6<V>, middle: Vec6<V>, last: Vec6<V>) -> Vec6<V> {
        let (four, sixth, twelfth) = (t.constant(4.0), t * t.constant(1.0 / 6.0), t * t.constant(1.0 / 12.0));
        let (omega, v) = split(each!(6, k => sixth * four.mul_add(middle[k], first[k] + last[k])));
        let (turn, shift) = split(each!(6, k => twelfth * (last[k] - first[k])));
        // σ + [σ, t/12 (η₁ − η₀)].
        let v = add_cross(add_cross(v, omega, shift), v, turn);
        let omega = add_cross(omega, omega, turn);
        let t = dot(omega, omega);
        let (q, half) = (horner(&TANGENT_LESS, t), t.constant(TANGENT[0]));
        let turn = scale(t.neg_mul_add(q, half), omega);
        join(turn, add_scaled(scale(half, v), q, cross(omega, cross(omega, v))))
    }

    /// R' = R R_ξ: its rows are turned as a covector (0, b) is. t' = t + R t_ξ, t_ξ = −2 B w at `back`.
    #[inline(always)]
    fn increments<V: Lanes>(at_back: At<V>, back: Vec6<V>, values: Vec6<V>, impulses: Vec6<V>) -> Vec6<V> {
        let turned = Self::turned(at_back, back, each!(6, k => values[k] + impulses[k]));
        let mut sum: Vec6<V> = each!(6, k => turned[k] + impulses[k]);
        let of_momentum = at_back.s.read(&MOMENTUM);
        for k in 0..3 {
            sum[k] = of_momentum * sum[k];
        }
        let ((_, rows), (rho, w)) = (split(values), split(back));
        let back_shift = scale(at_back.s * at_back.s.read(&TWICE_ATTITUDE), behind(rho, w));
        sum[0] = sum[0] - dot(rows, back_shift);
        sum
    }

    #[inline(always)]
    fn square<V: Lanes>(x: Vec6<V>) -> V {
        let (rho, _) = split(x);
        rho[0].constant(4.0) * dot(rho, rho)
    }

    fn in_domain(largest_square: f64) -> bool {
        largest_square < 1e16
    }
}
