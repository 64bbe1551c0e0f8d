//! The equations of motion as plain vector fields y' = f(y), written out as for any solver.

/// An autonomous vector field on K numbers.
pub trait Field<const K: usize>: Copy + Send + Sync + 'static {
    /// `rate` ← f(y).
    fn rates(&self, y: &[f64; K], rate: &mut [f64; K]);
}

/// A rigid body with damping of Landau, Lifshitz and Gilbert: M' = M×Ω + M×(M×Ω), R' = R Ω̂.
#[derive(Clone, Copy, Debug)]
pub struct LandauLifshitzGilbert;

/// The relaxed rigid body: M' = M×Ω + (1/10) (Ω×M)×Ω, R' = R Ω̂.
#[derive(Clone, Copy, Debug)]
pub struct Relaxed;

/// A body in a fluid: π' = π×ω + p×v + f, p' = p×ω + f, f = −(1+|η|)/8 η, R' = R ω̂, x' = R v.
#[derive(Clone, Copy, Debug)]
pub struct Fluid;

/// A heavy top: M' = M×Ω + (13/10) Γ×r, R' = R Ω̂, with Γ = Rᵀe₃ and the weight at r = (3/10, 0, 1/2).
#[derive(Clone, Copy, Debug)]
pub struct HeavyTop;

/// A body in the plane: π' = p₀v₁ − p₁v₀ + f, p' = (p₁ω, −p₀ω) + f, f = −(1+|η|)/8 η; the cosine and the sine of its angle, its place.
#[derive(Clone, Copy, Debug)]
pub struct Plane;

/// On SL(2): μ' = ad*_η μ + f, f = −(1+|η|)/8 η, g' = g η̂.
#[derive(Clone, Copy, Debug)]
pub struct Special;

/// A body in four-space: m' = m×ω + k×v + f, k' = k×ω + m×v + f, f = −(1+|η|)/8 η, g' = g η̂.
#[derive(Clone, Copy, Debug)]
pub struct FourSpace;

/// 1 / I of the bodies on SO(3), I = diag(½, 2, 1).
const INVERSE_INERTIA: [f64; 3] = [2.0, 0.5, 1.0];

/// 1 / I of the bodies in a fluid and in four-space, I = diag(½, 2, 1, 3, 3/2, 5/4).
const INVERSE_INERTIA_SE3: [f64; 6] = [2.0, 0.5, 1.0, 1.0 / 3.0, 2.0 / 3.0, 0.8];

/// 1 / I of the bodies in the plane and on SL(2), I = diag(½, 2, 1) and diag(1, 2, 3/2).
const INVERSE_INERTIA_PLANE: [f64; 3] = [2.0, 0.5, 1.0];
const INVERSE_INERTIA_SL2: [f64; 3] = [1.0, 0.5, 2.0 / 3.0];

/// The weight of the top times its distance along e₁ and e₃ from the fixed point.
const WEIGHT: [f64; 2] = [1.3 * 0.3, 1.3 * 0.5];

fn cross(x: [f64; 3], y: [f64; 3]) -> [f64; 3] {
    [x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]]
}

/// (M, Ω) of a body on SO(3).
fn body(y: &[f64; 12]) -> ([f64; 3], [f64; 3]) {
    let m = [y[0], y[1], y[2]];
    (m, [m[0] * INVERSE_INERTIA[0], m[1] * INVERSE_INERTIA[1], m[2] * INVERSE_INERTIA[2]])
}

/// (1+|η|)/8.
fn drag<const N: usize>(eta: &[f64; N]) -> f64 {
    0.125 * (1.0 + eta.iter().map(|e| e * e).sum::<f64>().sqrt())
}

/// R' = R Ω̂: the rows of R, at `from` in the state, times the hat matrix.
fn turn<const K: usize>(y: &[f64; K], omega: [f64; 3], rate: &mut [f64; K], from: usize) {
    for row in 0..3 {
        let k = from + 3 * row;
        let r = cross([y[k], y[k + 1], y[k + 2]], omega);
        rate[k..k + 3].copy_from_slice(&r);
    }
}

impl Field<12> for LandauLifshitzGilbert {
    #[inline(always)]
    fn rates(&self, y: &[f64; 12], rate: &mut [f64; 12]) {
        let (m, omega) = body(y);
        let torque = cross(m, omega);
        let damping = cross(m, torque);
        for a in 0..3 {
            rate[a] = torque[a] + damping[a];
        }
        turn(y, omega, rate, 3);
    }
}

impl Field<12> for Relaxed {
    #[inline(always)]
    fn rates(&self, y: &[f64; 12], rate: &mut [f64; 12]) {
        let (m, omega) = body(y);
        let torque = cross(m, omega);
        let damping = cross(torque, omega);
        for a in 0..3 {
            rate[a] = torque[a] - 0.1 * damping[a];
        }
        turn(y, omega, rate, 3);
    }
}

impl Field<18> for Fluid {
    #[inline(always)]
    fn rates(&self, y: &[f64; 18], rate: &mut [f64; 18]) {
        let mut eta = [0.0; 6];
        for a in 0..6 {
            eta[a] = y[a] * INVERSE_INERTIA_SE3[a];
        }
        let (omega, v) = ([eta[0], eta[1], eta[2]], [eta[3], eta[4], eta[5]]);
        let (pi, p) = ([y[0], y[1], y[2]], [y[3], y[4], y[5]]);
        let (turned, pushed, moved) = (cross(pi, omega), cross(p, v), cross(p, omega));
        let drag = drag(&eta);
        for a in 0..3 {
            rate[a] = turned[a] + pushed[a] - drag * omega[a];
            rate[3 + a] = moved[a] - drag * v[a];
        }
        turn(y, omega, rate, 6);
        for row in 0..3 {
            let k = 6 + 3 * row;
            rate[15 + row] = y[k] * v[0] + y[k + 1] * v[1] + y[k + 2] * v[2];
        }
    }
}

impl Field<12> for HeavyTop {
    #[inline(always)]
    fn rates(&self, y: &[f64; 12], rate: &mut [f64; 12]) {
        let (m, omega) = body(y);
        let torque = cross(m, omega);
        // The last row of R is Γ.
        let up = [y[9], y[10], y[11]];
        rate[0] = torque[0] + WEIGHT[1] * up[1];
        rate[1] = torque[1] + WEIGHT[0] * up[2] - WEIGHT[1] * up[0];
        rate[2] = torque[2] - WEIGHT[0] * up[1];
        turn(y, omega, rate, 3);
    }
}

impl Field<7> for Plane {
    #[inline(always)]
    fn rates(&self, y: &[f64; 7], rate: &mut [f64; 7]) {
        let [_, p0, p1, cosine, sine, ..] = *y;
        let eta: [f64; 3] = std::array::from_fn(|a| y[a] * INVERSE_INERTIA_PLANE[a]);
        let ([omega, v0, v1], drag) = (eta, drag(&eta));
        *rate = [
            p0 * v1 - p1 * v0 - drag * omega,
            p1 * omega - drag * v0,
            -p0 * omega - drag * v1,
            -sine * omega,
            cosine * omega,
            cosine * v0 - sine * v1,
            sine * v0 + cosine * v1,
        ];
    }
}

impl Field<7> for Special {
    #[inline(always)]
    fn rates(&self, y: &[f64; 7], rate: &mut [f64; 7]) {
        let [h, e, f, g00, g01, g10, g11] = *y;
        let eta: [f64; 3] = std::array::from_fn(|a| y[a] * INVERSE_INERTIA_SL2[a]);
        let ([x, u, w], drag) = (eta, drag(&eta));
        *rate = [
            2.0 * (f * w - e * u) - drag * x,
            2.0 * e * x - h * w - drag * u,
            h * u - 2.0 * f * x - drag * w,
            g00 * x + g01 * w,
            g00 * u - g01 * x,
            g10 * x + g11 * w,
            g10 * u - g11 * x,
        ];
    }
}

impl Field<22> for FourSpace {
    #[inline(always)]
    fn rates(&self, y: &[f64; 22], rate: &mut [f64; 22]) {
        let eta: [f64; 6] = std::array::from_fn(|a| y[a] * INVERSE_INERTIA_SE3[a]);
        let (omega, v) = ([eta[0], eta[1], eta[2]], [eta[3], eta[4], eta[5]]);
        let (m, k) = ([y[0], y[1], y[2]], [y[3], y[4], y[5]]);
        let (turned, pushed) = (cross(m, omega), cross(k, v));
        let (moved, drawn) = (cross(k, omega), cross(m, v));
        let drag = drag(&eta);
        for a in 0..3 {
            rate[a] = turned[a] + pushed[a] - drag * omega[a];
            rate[3 + a] = moved[a] + drawn[a] - drag * v[a];
        }
        for row in 0..4 {
            let k = 6 + 4 * row;
            let (x, last) = ([y[k], y[k + 1], y[k + 2]], y[k + 3]);
            let turned = cross(x, omega);
            for a in 0..3 {
                rate[k + a] = turned[a] - last * v[a];
            }
            rate[k + 3] = x[0] * v[0] + x[1] * v[1] + x[2] * v[2];
        }
    }
}
