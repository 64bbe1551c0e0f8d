//! The Cayley map of SE(3) in lanes.
//!
//! [`CayleySe3`] is the Cayley map of [`Entry::Se3`] (rotations first, then translations): as every Cayley map it has a form in lanes, and here a
//! closed one, which is faster.
//!
//! Sources: Martín de Diego and Sato Martín de Almagro 2019, §5.2; Bou-Rabee and Marsden 2009 (the Cayley map on SE(3)).

use super::lanes::vectors::{add_cross, add_scaled, cross, dot, first, horner, join, last, length, scale};
use super::lanes::{FastRetraction, LaneGroup, Lanes, Vec3, each};
use super::so3::retraction::TANGENT;
use crate::algebra::brackets::Brackets;
use crate::algebra::catalogue::Entry;
use crate::algebra::{LieAlgebra, Matrix, Vector};
use crate::group::MatrixGroup;
use crate::retraction::{self, CayleyPoint, Retraction, RetractionError};
use crate::scalar::Scalar;

/// Six components, each in lanes: of ω, then of v.
#[doc(hidden)]
pub type Vec6<V> = [V; 6];

/// The Cayley map on SE(3), in the basis of [`Entry::Se3`]: [`retraction::Cayley`], with a closed form in lanes.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::lanes::{Drag, Term, Terms, VariationalInLanes};
/// use euler_poincare::integrators::se3::CayleySe3;
/// use euler_poincare::integrators::{OneStep, State};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::tableau::Family;
///
/// let body = Quadratic::diagonal([0.5, 2.0, 1.0, 3.0, 1.5, 1.25])?;
/// let drag = Terms(vec![Term::LinearDrag(Drag::Diagonal([0.125; 6]))]);
/// let mut method = VariationalInLanes::new(body, drag, CayleySe3::new(), Family::Gauss.tableau(3)?)?;
/// let momentum = Covector::from([0.5, -0.25, 1.0, 1.0, 0.5, -0.5]);
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::identity() };
/// method.step(&mut state, 0.125)?;
/// assert!(state.momentum.norm() < momentum.norm());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
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
    type Steady = Self;

    fn in_lanes(&self) -> Cayley {
        Cayley
    }
}

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
fn rotated<V: Lanes>(at: &At<V>, rho: Vec3<V>, z: Vec3<V>) -> Vec3<V> {
    let once = cross(rho, z);
    scale(at.s + at.s, add_cross(once, rho, once))
}

impl LaneGroup<6, 4> for Cayley {
    const HALVED: bool = true;

    type At<V: Lanes> = At<V>;

    #[inline(always)]
    fn at<V: Lanes>(&self, x: Vec6<V>, _: bool) -> At<V> {
        let (rho, w) = split(x);
        let one = w[0].constant(1.0);
        let s = rho[2].mul_add(rho[2], rho[1].mul_add(rho[1], rho[0].mul_add(rho[0], one))).reciprocal();
        At { s, shift: scale(s, ahead(rho, w)) }
    }

    /// b' = b − ρ×b; (a − ρ×a + ρ(ρ·a) + b'×w, b').
    #[inline(always)]
    fn unpull<V: Lanes>(&self, _: &At<V>, x: Vec6<V>, p: Vec6<V>) -> Vec6<V> {
        let ((a, b), (rho, w)) = (split(p), split(x));
        let b = add_cross(b, b, rho);
        join(add_cross(behind(rho, a), b, w), b)
    }

    #[inline(always)]
    fn rate<V: Lanes>(&self, _: &At<V>, x: Vec6<V>, eta: Vec6<V>) -> Vec6<V> {
        let ((y, u), (rho, w)) = (split(eta), split(x));
        let r = add_cross(u, w, y);
        join(ahead(rho, y), add_cross(r, rho, r))
    }

    /// b' = A b; (s(a + ρ×a) + A w × b', b').
    #[inline(always)]
    fn pull<V: Lanes>(&self, at: &At<V>, x: Vec6<V>, f: Vec6<V>) -> Vec6<V> {
        let ((a, b), (rho, _)) = (split(f), split(x));
        let b = scale(at.s, ahead(rho, b));
        join(add_cross(scale(at.s, add_cross(a, rho, a)), at.shift, b), b)
    }

    /// (R a + t×R b, R b) − (a, b).
    #[inline(always)]
    fn turned<V: Lanes>(&self, at: &At<V>, x: Vec6<V>, f: Vec6<V>) -> Vec6<V> {
        let ((a, b), (rho, _)) = (split(f), split(x));
        let moved = rotated(at, rho, b);
        let whole = [b[0] + moved[0], b[1] + moved[1], b[2] + moved[2]];
        let shift = each!(3, k => at.shift[k] + at.shift[k]);
        join(add_cross(rotated(at, rho, a), shift, whole), moved)
    }

    /// R' = v + 2s (u + u × ρ), u = v × ρ; x' = x + R t, t = 2 A w.
    #[inline(always)]
    fn moved<V: Lanes>(&self, at: &At<V>, x: Vec6<V>, row: [V; 4]) -> [V; 4] {
        let (v, (rho, _)) = ([row[0], row[1], row[2]], split(x));
        let once = cross(v, rho);
        let [a, b, c] = add_scaled(v, at.s + at.s, add_cross(once, once, rho));
        [a, b, c, at.s.constant(2.0).mul_add(dot(v, at.shift), row[3])]
    }

    /// The rotation is turned as a covector (0, b) is; less the position R t, t = 2 B w.
    #[inline(always)]
    fn moved_back<V: Lanes>(&self, at: &At<V>, x: Vec6<V>, row: [V; 4]) -> [V; 4] {
        let (v, (rho, w)) = ([row[0], row[1], row[2]], split(x));
        let [a, b, c] = rotated(at, rho, v);
        let shift = scale(at.s.constant(-2.0) * at.s, behind(rho, w));
        [a, b, c, dot(v, shift)]
    }

    /// With p = (a, b), (y, u) half the rate and m₃ = a − ρ×a + ρ(ρ·a), the first part of m less b'×w:
    /// (s[m₃×y − 2(a·y)ρ] − B u × b, B(b×y)).
    #[inline(always)]
    fn pull_dd<V: Lanes>(&self, at: &At<V>, x: Vec6<V>, p: Vec6<V>, m: Vec6<V>, _eta: Vec6<V>, y: Vec6<V>) -> Vec6<V> {
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
    fn displacement<V: Lanes>(&self, t: V, first: Vec6<V>, middle: Vec6<V>, last: Vec6<V>) -> Vec6<V> {
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

    /// (π × ω + p × v, p × ω).
    #[inline(always)]
    fn add_coad<V: Lanes>(&self, sum: Vec6<V>, m: Vec6<V>, eta: Vec6<V>) -> Vec6<V> {
        let ((pi, p), (omega, v)) = (split(m), split(eta));
        join(add_cross(add_cross(first(sum), pi, omega), p, v), add_cross(last(sum), p, omega))
    }

    #[inline(always)]
    fn distance<V: Lanes>(&self, _: &At<V>, x: Vec6<V>) -> V {
        let (rho, _) = split(x);
        rho[0].constant(4.0) * dot(rho, rho)
    }

    fn in_domain(&self, distance: f64) -> bool {
        distance < 1e16
    }

    fn turning(&self, eta: [f64; 6]) -> f64 {
        length([eta[0], eta[1], eta[2]])
    }

    fn rotation(&self) -> usize {
        3
    }
}
