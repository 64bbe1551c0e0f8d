//! How fast a case moves, relative to its step.

use super::case::{Case, Force, Tau};
use super::dispatch::{System, Visitor};
use crate::algebra::elimination::quick_inverse;
use crate::algebra::{LieAlgebra, Matrix, Vector};
use crate::group::LieGroup;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force as _, Lagrangian};
use crate::retraction::real_eigenvalues_below_one;

/// The largest stiffness of the step of generated cases: well below where stage equations fold (about 1) and τ leaves its
/// domain.
pub(super) const MOST: f64 = 0.5;

/// The largest growth of an attitude: a condition number of e¹² leaves two thirds of the digits of an `f64`.
const MOST_GROWTH: f64 = 6.0;

/// Row-sum norms at the initial state.
pub(crate) struct Rates {
    /// ‖ad_η‖, or half the largest entry of η̂ where τ works on matrices, if that is larger.
    rotation: f64,
    /// ‖ad_η̇‖.
    turning: f64,
    /// ‖∂η̇/∂η‖.
    stiffness: f64,
    /// ‖(1 − x̂/2)⁻¹‖ at the attitude's coordinates where τ works on matrices (infinite outside its domain, and
    /// where φ may fold), else 0.
    reach: f64,
    /// The largest frequency of x̂: |Im λ| over its eigenvalues; 0 without a group or an attitude.
    pub frequency: f64,
    /// The largest growth of x̂: |Re λ| over its eigenvalues; 0 without a group or an attitude.
    growth: f64,
    /// Whether the force is more than rounding at one of a few velocities: it does not vanish identically. −β ad*_η ad*_η M does on nilpotent
    /// algebras of two steps, and both brackets do where l'(η) is fixed by η, as on so(3) with a multiple of the identity for inertia.
    pub driven: bool,
    /// |η̇|/|η|, largest components; infinite at rest.
    pub braking: f64,
}

impl Rates {
    /// Those of a case; `None` when it cannot be built.
    ///
    /// Measured with exp: the Cayley map of a large group takes longer to set up than all the rest.
    pub fn of(case: &Case) -> Option<Self> {
        let mut probe = case.clone();
        probe.method.retraction = Tau::Exponential;
        probe.method.argument.clear();
        Self::by(case, case.method.retraction.known().of_matrices, |measure| {
            probe.dispatch::<f64, _>(measure).ok().flatten()
        })
    }

    /// Those that `visit` finds for a case; `matrices`: where τ works on matrices.
    pub(crate) fn by(case: &Case, matrices: bool, visit: impl FnOnce(Measure) -> Option<Self>) -> Option<Self> {
        let attitude = case.start.attitude.iter().flatten().map(|x| x.eval().ok()).collect::<Option<Vec<f64>>>()?;
        let (attitude, bend) = if attitude.is_empty() { (attitude, 0.0) } else { case.method.argument(&attitude)? };
        let strength = case.forces.iter().map(Force::strength).fold(0.0, f64::max);
        let mut rates = visit(Measure { matrices, attitude, strength })?;
        if bend >= 1.0 {
            rates.reach = f64::INFINITY;
        }
        Some(rates)
    }

    /// Whether the attitude is safely in the domain of τ: 1 − x̂/2 is regular, and not nearly singular; and g = exp(x̂) is not, of which
    /// the condition number is e^(2 |Re λ|) at least.
    pub fn in_domain(&self) -> bool {
        self.reach < 20.0 && self.growth < MOST_GROWTH
    }

    /// The largest angle by which g = τ(x) turns anything: ω for exp and 2 arctan(ω/2) for Cayley, ±iω the fastest
    /// pair of eigenvalues of x̂. At π the logarithm of g ceases to be unique, and −1 is an eigenvalue of g.
    pub fn angle(&self, tau: Tau) -> f64 {
        (tau.known().angle)(self.frequency)
    }

    /// |η̇|/|η| relative to the rates at which a motion like it could turn: 0 where the velocity is constant.
    pub fn unsteadiness(&self) -> f64 {
        if self.braking == 0.0 { 0.0 } else { self.braking / (self.rotation + self.stiffness) }
    }

    /// h (‖ad_η‖ + h ‖ad_η̇‖ + ‖∂η̇/∂η‖): what the step multiplies.
    pub fn step_stiffness(&self, h: f64) -> f64 {
        h * (self.rotation + h * self.turning + self.stiffness)
    }
}

/// Measures the rates of a system.
pub(crate) struct Measure {
    matrices: bool,
    attitude: Vec<f64>,
    /// The largest coefficient of the forces.
    strength: f64,
}

/// Whether f is more than rounding somewhere: its terms are of the size strength (1 + |l'(η)|)³ at most, up to the basis.
fn driven<const N: usize, const D: usize>(system: &System<f64, N, D>, strength: f64) -> bool {
    (0..4).any(|k| {
        let eta = Vector::<f64, N>::from_fn(|a, _| ((7 * a + 3 * k + 1) % 11) as f64 / 8.0 - 0.5);
        let size = strength * (1.0 + system.lagrangian.gradient(&eta).amax()).powi(3);
        system.force.force(system.state.time + 0.375 * k as f64, &eta).amax() > 2f64.powi(-35) * size
    })
}

fn norm<const N: usize>(matrix: &Matrix<f64, N>) -> f64 {
    (0..N).map(|row| (0..N).map(|c| matrix[(row, c)].abs()).sum()).fold(0.0, f64::max)
}

/// max |Im λ| and max |Re λ|; 0 where the eigenvalues are not found.
fn frequency_and_growth<const D: usize>(matrix: &Matrix<f64, D>) -> (f64, f64) {
    // Of run-time size, so that this is compiled once.
    let matrix = nalgebra::DMatrix::from_fn(D, D, |r, c| matrix[(r, c)]);
    let found = nalgebra::Schur::try_new(matrix, f64::EPSILON, 1000);
    let eigenvalues = found.map(|schur| schur.complex_eigenvalues());
    let largest = |part: fn(&nalgebra::Complex<f64>) -> f64| {
        eigenvalues.iter().flatten().fold(0.0, |most: f64, z| most.max(part(z).abs()))
    };
    (largest(|z| z.im), largest(|z| z.re))
}

impl Visitor<f64> for Measure {
    type Output = Option<Rates>;

    const KNOWS_CONFIGURATION: bool = true;

    fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> Option<Rates> {
        let algebra: &LieAlgebra<f64, N> = &system.algebra;
        let (time, here) = (system.state.time, &system.state.attitude);
        let eta = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros()).ok()?;
        let inverse = quick_inverse(&system.lagrangian.hessian(&eta))?;
        let load = |g: &Matrix<f64, D>, eta: &Vector<f64, N>| {
            let g = Configuration::of(g);
            let force = system.force.force_at(time, g, eta);
            if !system.lagrangian.uses_configuration() {
                return force;
            }
            force + system.lagrangian.configuration_gradient(time, g, eta)
        };
        let rate = |eta: &Vector<f64, N>| {
            let mu = system.lagrangian.gradient(eta);
            inverse * (algebra.coad(eta, &mu) + load(here, eta)).transpose()
        };
        let mut slope = Matrix::<f64, N>::zeros();
        for a in 0..N {
            let mut moved = Vector::zeros();
            moved[a] = 1.0 / 1024.0;
            slope.set_column(a, &((rate(&(eta + moved)) - rate(&(eta - moved))) * 512.0));
        }
        let mut stiffness = norm(&slope);
        if let Some(group) = system.group.as_ref().filter(|_| system.lagrangian.uses_configuration()) {
            // ∂η̇/∂g, of which the root is a rate.
            let mut pull = Matrix::<f64, N>::zeros();
            for a in 0..N {
                let mut along = Vector::<f64, N>::zeros();
                along[a] = 1.0 / 1024.0;
                let hat: Matrix<f64, D> = group.hat(&along);
                let (there, back) = (here + here * hat, here - here * hat);
                pull.set_column(a, &(inverse * (load(&there, &eta) - load(&back, &eta)).transpose() * 512.0));
            }
            stiffness += norm(&pull).sqrt();
        }
        // The Cayley map works on matrices: 1 − x̂/2 must stay away from singular.
        let (mut matrix, mut reach, mut turns, mut growth) = (0.0, 0.0, 0.0, 0.0);
        if let Some(group) = &system.group {
            let x: Matrix<f64, D> = group.hat(&Vector::from_fn(|a, _| self.attitude.get(a).copied().unwrap_or(0.0)));
            if !self.attitude.is_empty() {
                (turns, growth) = frequency_and_growth(&x);
            }
            if self.matrices {
                matrix = group.hat::<f64>(&eta).amax() * 0.5;
                let half = x * 0.5;
                let inverse = quick_inverse(&(Matrix::identity() - half)).filter(|_| real_eigenvalues_below_one(&half));
                reach = inverse.map_or(f64::INFINITY, |inverse| norm(&inverse));
            }
        }
        let rotation = norm(&algebra.ad(&eta)).max(matrix);
        let driven = driven(&system, self.strength);
        let rates = Rates {
            rotation,
            turning: norm(&algebra.ad(&rate(&eta))),
            stiffness,
            reach,
            frequency: turns,
            growth,
            driven,
            braking: match (eta.amax(), rate(&eta).amax()) {
                (0.0, 0.0) => 0.0,
                (speed, change) => change / speed,
            },
        };
        rates.step_stiffness(1.0).is_finite().then_some(rates)
    }
}
