//! The variational step with faults planted in it.
//!
//! A transcription of the stage equations (Martín de Diego and Sato Martín de Almagro 2019, §5.2 on the units) apart from
//! the library's integrator: plain loops over the stages, Newton's method on H, no fixed-point iteration. Each
//! fault is one wrong term. A law that is checked with a fault judges this step instead of the library's; without a fault the
//! two agree to round-off, which is a law of its own.

use crate::algebra::{Covector, Matrix, Vector};
use crate::harness::Fault;
use crate::integrators::variational::turn;
use crate::integrators::{OneStep, Report, Solver, State, StepError};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, Lagrangian};
use crate::newton::{Equations, Newton, NewtonSettings};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Dual, Real, Scalar};
use crate::system::System;
use nalgebra::DMatrix;

/// A tolerance for residuals that digits are lost by, relative to the momentum.
const LOOSE: f64 = 1e-6;

const NONABELIAN: &str = "non-abelian algebras, motions that are not steady";
const FORCED: &str = "forced systems";

/// P_i = μ + h Σ â_ij G_j and μ' = (μ + h Σ b_j G_j) dτ(ξ)⁻¹: the partitioned method in the chart, of the same order.
pub const CHART: Fault = Fault::new(
    "chart-trap",
    "the partitioned method in the chart, μ' = (μ + h Σ b G) dτ(ξ)⁻¹: same order, another method",
    NONABELIAN,
);
pub const FORCE_INDEX: Fault = Fault::new(
    "force-index",
    "K̂ of stage i for stage j in the stage equations (as printed)",
    "forced systems, s ≥ 2; in the order, orders above 3",
);
pub const UNCONJUGATED: Fault = Fault::new(
    "unconjugated",
    "a_ij for its conjugate",
    "tableaux that are not symplectic; forced or non-abelian systems",
);
pub const NO_SECOND: Fault = Fault::new("no-second-tangent", "ddτ left out of G_i", NONABELIAN);
pub const INVERSE_SECOND: Fault =
    Fault::new("inverse-second-tangent", "the second tangent of τ⁻¹ instead of that of τ (as printed)", NONABELIAN);
pub const SWAPPED_SECOND: Fault = Fault::new("swapped-second-tangent", "ddτ(δ, H) for ddτ(H, δ)", NONABELIAN);
pub const NO_FORCE: Fault = Fault::new("no-force-in-stages", "f left out of G_i", FORCED);
pub const NOT_TRANSPORTED: Fault =
    Fault::new("force-not-transported", "Ad*_{τ(Ξ_j)⁻¹} left out of m", "forced systems on non-abelian algebras");
pub const FIRST_STAGE: Fault =
    Fault::new("force-of-first-stage", "f(η_1) at every stage", "velocity-dependent forces, s ≥ 2");
pub const FORCE_TIME: Fault =
    Fault::new("force-time", "f at the time of the step's start at every stage", "time-dependent forces");
pub const NO_STEP: Fault = Fault::new("no-step-tangent", "dτ(−ξ) left out of the stage equations", NONABELIAN);
pub const INVERTED: Fault = Fault::new("coadjoint-inverted", "μ' = Ad*_{τ(ξ)⁻¹} m", NONABELIAN);
pub const HALVED: Fault = Fault::new("coadjoint-halved", "μ' = m dτ(−ξ), without dτ(ξ)⁻¹", NONABELIAN);
pub const FROM_LEFT: Fault = Fault::new(
    "attitude-from-left",
    "g' = τ(ξ) g",
    "non-abelian groups, after a step or from an attitude that is not e",
);
pub const ORDER_TWO: Fault = Fault::new(
    "attitude-order-two",
    "g' = g τ(h (l')⁻¹((μ + μ')/2))",
    "motions that are not steady; in the order, orders above 2",
);

const POTENTIAL: &str = "potentials that are not constant";
pub const OF_START: Fault = Fault::new(
    "configuration-of-start",
    "f and ∂_gL at g instead of g τ(Ξ_i)",
    "forces and potentials that depend on the configuration",
);
pub const GRADIENT_SIGN: Fault = Fault::new("gradient-sign", "−∂_gL for ∂_gL", POTENTIAL);
pub const NO_GRADIENT: Fault = Fault::new("no-gradient", "∂_gL left out", POTENTIAL);

pub const LAGRANGIAN_TIME: Fault = Fault::new(
    "lagrangian-time",
    "∂L/∂η at the time of the step's start at every stage",
    "Lagrangians that depend on the time",
);

pub const LOOSE_TOLERANCE: Fault = Fault::new(
    "loose-tolerance",
    "the stage equations solved to a residual of 10⁻⁶ in any precision",
    "motions that are not steady",
);

/// What may be wrong in the equations of a step, and in how (g', μ') follows from them.
pub const EQUATIONS: [Fault; 15] = [
    CHART,
    FORCE_INDEX,
    UNCONJUGATED,
    NO_SECOND,
    INVERSE_SECOND,
    SWAPPED_SECOND,
    NO_FORCE,
    NOT_TRANSPORTED,
    FIRST_STAGE,
    FORCE_TIME,
    NO_STEP,
    INVERTED,
    HALVED,
    FROM_LEFT,
    ORDER_TWO,
];

/// Those that the balance of the spatial momentum shows.
pub const BALANCE: [Fault; 9] =
    [CHART, NO_FORCE, NOT_TRANSPORTED, FIRST_STAGE, FORCE_INDEX, FORCE_TIME, INVERTED, HALVED, FROM_LEFT];

/// All of these faults.
pub const ALL: [Fault; 20] =
    joined(EQUATIONS, [LAGRANGIAN_TIME, OF_START, GRADIENT_SIGN, NO_GRADIENT, LOOSE_TOLERANCE]);

/// The faults of two lists, N in all.
pub const fn joined<const A: usize, const B: usize, const N: usize>(
    first: [Fault; A],
    second: [Fault; B],
) -> [Fault; N] {
    assert!(A + B == N, "the count of the faults");
    let mut all = [CHART; N];
    let mut k = 0;
    while k < N {
        all[k] = if k < A { first[k] } else { second[k - A] };
        k += 1;
    }
    all
}

/// The plain step of a system, with or without a fault.
#[derive(Clone, Debug)]
pub struct PlantedStep<'a, T: Real, const N: usize, const D: usize> {
    system: &'a System<T, N, D>,
    fault: Option<Fault>,
    velocities: Vec<Vector<T, N>>,
    displacements: Vec<Vector<T, N>>,
}

/// What the stages determine: m and ξ, the residual and the chart momentum μ + h Σ b_j G_j.
struct Evaluated<S: Scalar, const N: usize> {
    after_impulse: Covector<S, N>,
    increment: Vector<S, N>,
    chart: Covector<S, N>,
    residual: Vec<Covector<S, N>>,
    velocities: Vec<Vector<S, N>>,
    displacements: Vec<Vector<S, N>>,
}

impl<'a, T: Real, const N: usize, const D: usize> PlantedStep<'a, T, N, D> {
    /// The step of a system, with a fault or without.
    pub fn new(system: &'a System<T, N, D>, fault: Option<Fault>) -> Self {
        Self { system, fault, velocities: Vec::new(), displacements: Vec::new() }
    }

    /// ∂L/∂η and f + ∂_gL at the stage at x, or what the fault makes of them; `momentum_time` is the time of the first.
    fn at_stage<S: Scalar<Base = T>>(
        &self,
        (momentum_time, time): (S, S),
        attitude: &Matrix<T, D>,
        x: &Vector<S, N>,
        (eta, acting): (&Vector<S, N>, &Vector<S, N>),
    ) -> Result<(Covector<S, N>, Covector<S, N>), RetractionError> {
        if !self.system.force.uses_configuration() && !self.system.lagrangian.uses_configuration() {
            return Ok((self.system.lagrangian.gradient(eta), self.system.force.force(time, acting)));
        }
        let mut there = attitude.map(S::lift);
        if !self.has(OF_START) {
            there *= self.system.retraction.tau(x)?;
        }
        let g = Configuration::of(&there);
        let momentum = self.system.lagrangian.gradient_at(momentum_time, g, eta);
        let gradient = self.system.lagrangian.configuration_gradient(time, g, acting);
        let force = self.system.force.force_at(time, g, acting);
        let gradient = if self.has(GRADIENT_SIGN) { -gradient } else { gradient };
        Ok((momentum, if self.has(NO_GRADIENT) { force } else { force + gradient }))
    }

    fn has(&self, fault: Fault) -> bool {
        self.fault.is_some_and(|planted| planted.name == fault.name)
    }

    /// P ddτ(x; y, ·), or what the fault makes of it.
    fn second_tangent<S: Scalar<Base = T>>(
        &self,
        point: &impl TangentPoint<S, N>,
        p: &Covector<S, N>,
        y: &Vector<S, N>,
    ) -> Covector<S, N> {
        if self.has(NO_SECOND) {
            Covector::zeros()
        } else if self.has(INVERSE_SECOND) {
            -(p * point.d() * point.dd(&(point.d_inv() * y)))
        } else if self.has(SWAPPED_SECOND) {
            Covector::from_fn(|_, a| {
                let delta = Vector::from_fn(|b, _| if a == b { S::one() } else { S::zero() });
                (p * point.dd(&delta) * y)[0]
            })
        } else {
            p * point.dd(y)
        }
    }

    fn evaluate<S: Scalar<Base = T>>(
        &self,
        start: &State<T, N, D>,
        step: T,
        rates: &[Vector<S, N>],
    ) -> Result<Evaluated<S, N>, RetractionError> {
        let (s, h) = (self.system.tableau.stages(), S::lift(step));
        let (a, b, c) = (self.system.tableau.a(), self.system.tableau.b(), self.system.tableau.c());
        let mu = start.momentum.map(S::lift);
        let mut momenta = Vec::with_capacity(s);
        let mut gradients = Vec::with_capacity(s);
        let mut impulses = Vec::with_capacity(s);
        let mut increment = Vector::<S, N>::zeros();
        let mut first_velocity = None;
        let (mut velocities, mut displacements) = (Vec::with_capacity(s), Vec::with_capacity(s));
        for i in 0..s {
            let mut x = Vector::<S, N>::zeros();
            for j in 0..s {
                x += rates[j] * (S::lift(a[(i, j)]) * h);
            }
            increment += rates[i] * (S::lift(b[i]) * h);
            let point = self.system.retraction.at(&x)?;
            let eta = point.d() * rates[i];
            let acting = if self.has(FIRST_STAGE) { *first_velocity.get_or_insert(eta) } else { eta };
            let at = |fault| S::lift(start.time) + if self.has(fault) { S::zero() } else { S::lift(c[i]) * h };
            let times = (at(LAGRANGIAN_TIME), at(FORCE_TIME));
            let (momentum, f) = self.at_stage(times, &start.attitude, &x, (&eta, &acting))?;
            let p = momentum * point.d();
            let mut gradient = self.second_tangent(&point, &p, &rates[i]);
            if !self.has(NO_FORCE) {
                gradient += f * point.d();
            }
            impulses.push(if self.has(NOT_TRANSPORTED) { f } else { f * point.ad_inv() });
            momenta.push(p);
            velocities.push(eta);
            displacements.push(x);
            gradients.push(gradient);
        }
        let sum = |values: &[Covector<S, N>]| {
            values.iter().enumerate().fold(Covector::<S, N>::zeros(), |t, (j, v)| t + v * (S::lift(b[j]) * h))
        };
        let after_impulse = mu + sum(&impulses);
        let chart = mu + sum(&gradients);
        let end = self.system.retraction.at(&increment)?.d_neg();
        let residual = (0..s)
            .map(|i| {
                let coupled = |weight: &dyn Fn(usize) -> T| {
                    (0..s).fold(Covector::<S, N>::zeros(), |t, j| t + gradients[j] * (S::lift(weight(j)) * h))
                };
                let conjugate = |j: usize| b[j] - b[j] * a[(j, i)] / b[i];
                let transposed = |j: usize| b[j] - conjugate(j);
                if self.has(CHART) {
                    momenta[i] - mu - coupled(&conjugate)
                } else if self.has(UNCONJUGATED) {
                    momenta[i] + coupled(&|j| b[j] - a[(i, j)]) - after_impulse * end
                } else if self.has(FORCE_INDEX) {
                    momenta[i] + coupled(&transposed) - (mu + impulses[i] * h) * end
                } else if self.has(NO_STEP) {
                    momenta[i] + coupled(&transposed) - after_impulse
                } else {
                    momenta[i] + coupled(&transposed) - after_impulse * end
                }
            })
            .collect();
        Ok(Evaluated { after_impulse, increment, chart, residual, velocities, displacements })
    }
}

/// The stage equations as equations in the s·N components of H.
struct StageEquations<'a, T: Real, const N: usize, const D: usize> {
    method: &'a PlantedStep<'a, T, N, D>,
    start: &'a State<T, N, D>,
    full: T,
    step: T,
}

impl<T: Real, const N: usize, const D: usize> Equations<T> for StageEquations<'_, T, N, D> {
    type Error = RetractionError;

    fn dimension(&self) -> usize {
        self.method.system.tableau.stages() * N
    }

    fn set_fraction(&mut self, fraction: T) {
        self.step = fraction * self.full;
    }

    fn residual(&mut self, x: &[T], out: &mut [T]) -> Result<T, RetractionError> {
        let rates: Vec<_> = x.chunks_exact(N).map(Vector::<T, N>::from_column_slice).collect();
        let evaluated = self.method.evaluate(self.start, self.step, &rates)?;
        let mut size = T::zero();
        for (k, value) in out.iter_mut().enumerate() {
            *value = evaluated.residual[k / N][k % N];
            size = size.max(evaluated.after_impulse[k % N].abs()).max(self.start.momentum[k % N].abs());
        }
        Ok(size)
    }

    fn jacobian(&mut self, x: &[T], out: &mut DMatrix<T>) -> Result<(), RetractionError> {
        for column in 0..x.len() {
            let rates: Vec<_> = (0..x.len() / N)
                .map(|i| {
                    Vector::<Dual<T>, N>::from_fn(|a, _| {
                        let value = x[i * N + a];
                        if i * N + a == column { Dual::variable(value) } else { Dual::constant(value) }
                    })
                })
                .collect();
            let evaluated = self.method.evaluate(self.start, self.step, &rates)?;
            for row in 0..x.len() {
                out[(row, column)] = evaluated.residual[row / N][row % N].eps;
            }
        }
        Ok(())
    }

    fn distance(&self, from: (T, &[T]), to: (T, &[T])) -> Option<T> {
        let moved = |j: usize, a: usize| (to.0 * to.1[j * N + a] - from.0 * from.1[j * N + a]) * self.full;
        Some(turn::<T, N>(&self.method.system.tableau, self.method.system.retraction.algebra(), moved))
    }
}

impl<T: Real, const N: usize, const D: usize> PlantedStep<'_, T, N, D> {
    /// Ξ_i and η_i of the last step.
    pub fn displacements_and_velocities(&self) -> impl Iterator<Item = [Vector<T, N>; 2]> + '_ {
        self.displacements.iter().zip(&self.velocities).map(|(displacement, velocity)| [*displacement, *velocity])
    }
}

impl<T: Real, const N: usize, const D: usize> OneStep<T, N, D> for PlantedStep<'_, T, N, D> {
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        state.check_finite(h)?;
        let step = h.to_f64();
        let domain = |source| StepError::Domain { step, stage: None, source };
        let here = Configuration::of(&state.attitude);
        let velocity = |mu: &Covector<T, N>, guess: &Vector<T, N>| {
            self.system
                .lagrangian
                .velocity_at(state.time, here, mu, guess)
                .map_err(|source| StepError::Legendre { step, source })
        };
        let eta = velocity(&state.momentum, &Vector::zeros())?;
        let size = self.system.tableau.stages() * N;
        let origin: Vec<T> = (0..size).map(|k| eta[k % N]).collect();
        let mut unknowns = origin.clone();
        let u = T::unit_roundoff();
        let loose = self.has(LOOSE_TOLERANCE);
        let tolerance = if loose { T::exact(LOOSE) } else { u * T::int(16) };
        let floor = tolerance.max(u * T::int(1 << 14));
        let settings = NewtonSettings { tolerance, floor, max_iterations: 20 };
        let mut equations = StageEquations { method: self, start: state, full: h, step: h };
        let mut newton = Newton::new(size);
        let (outcome, _) = newton
            .solve_joined(&mut equations, &origin, &mut unknowns, &settings)
            .map_err(|failure| StepError::of_newton(failure, step, &settings, 0, domain))?;
        let rates: Vec<_> = unknowns.chunks_exact(N).map(Vector::<T, N>::from_column_slice).collect();
        let end = self.evaluate(state, h, &rates).map_err(domain)?;
        let point = self.system.retraction.at(&end.increment).map_err(domain)?;
        let momentum = if self.has(CHART) {
            end.chart * point.d_inv()
        } else if self.has(INVERTED) {
            end.after_impulse * point.ad_inv()
        } else if self.has(HALVED) {
            end.after_impulse * point.d_neg()
        } else {
            end.after_impulse * point.ad()
        };
        let increment = if self.has(ORDER_TWO) {
            velocity(&((state.momentum + momentum) * T::half()), &eta)? * h
        } else {
            end.increment
        };
        let attitude: Matrix<T, D> = match self.system.retraction.tau(&increment) {
            Ok(tau) if self.has(FROM_LEFT) => tau * state.attitude,
            Ok(tau) => state.attitude * tau,
            Err(RetractionError::NoGroup { .. }) => state.attitude,
            Err(source) => return Err(domain(source)),
        };
        let next = State { time: state.time + h, momentum, attitude };
        next.check_finite(h)?;
        *state = next;
        (self.velocities, self.displacements) = (end.velocities, end.displacements);
        Ok(Report { solver: Solver::Newton, iterations: outcome.iterations, residual: outcome.residual })
    }
}
