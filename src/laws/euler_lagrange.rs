//! Laws of the reduced Euler–Lagrange equations on g×G×g, for l_f and for random Lagrangians of no symmetry.

use super::planted::blend;
use super::planted::doubled::{HALF_FORCE, LEFT_FOR_RIGHT, NO_FORCE_DERIVATIVE, PlantedForced};
use super::polynomial::{EVEN_PART, Polynomial};
use super::precision::{Measured, alone, of_relative};
use super::question::{Answer, Problem, Question, Trial, law, singular, stream, tried};
use super::sizes::turning;
use super::{CaseLaw, Source};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, pair};
use crate::group::{LieGroup, MatrixGroup};
use crate::harness::{Cost, Fault, Verdict, evidence};
use crate::mechanics::doubled::{Both, DoubledLagrangian, VelocityError, VelocityPoint};
use crate::mechanics::{Lagrangian, euler_lagrange};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::{Dual, Real, Scalar, max_abs};

const SOURCE: &str = "Martín de Diego and Sato Martín de Almagro 2019, Thm 3.1";

// What may be wrong with the Euler–Lagrange equations.
pub(super) const EL_BRACKET_SIGN: Fault =
    Fault::new("euler-lagrange-bracket-sign", "−ad*_η ∂l/∂η instead of ad*_η ∂l/∂η", "non-abelian groups");
pub(super) const EL_SIDES: Fault = Fault::new(
    "euler-lagrange-sides",
    "L*_U ∂l/∂U in the first equation, R*_U ∂l/∂U in the second",
    "non-abelian groups, off the units",
);
pub(super) const EL_POTENTIAL_SIGN: Fault =
    Fault::new("euler-lagrange-potential-sign", "+R*_U ∂l/∂U in the first equation", "every group");
pub(super) const ARROW_SIDES: Fault = Fault::new("arrow-sides", "U̇ = ψU − Uη", "non-abelian groups, off the units");

/// The law of this file that says nothing about a user's system: it judges the library on any group.
pub static LAWS: &[CaseLaw] = &[law!(Law {
    name: "odd-lagrangian-units",
    statement: "for any l with l(ψ, U⁻¹, η) = −l(η, U, ψ) the two Euler–Lagrange equations agree on (η, e, η) and keep the \
                        units: η̇ = ψ̇, U̇ = 0",
    source: "Martín de Diego and Sato Martín de Almagro 2019, §3, after Thm 3.1",
    oracle: "each equation against the other; l is the odd part of a random polynomial, so that k in l(ψ) − l(η) − k is \
                     any odd function",
    bound: small(9, "floor 2³ N u relative to the terms"),
    needs: "a group",
    cost: Cost::Moderate,
    faults: &[EVEN_PART, EL_POTENTIAL_SIGN],
    cases: |cases| cases.main_dimensions().with_group(),
    asks: Which::Odd,
})];

/// The laws of this file that users' systems are asked, too.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "first-variation",
                statement: "d/dε l(η_ε, U_ε, ψ_ε) = −⟨residual, (φσ, φσ̃)⟩ + d/dt(⟨∂l/∂η, φσ⟩ + ⟨∂l/∂ψ, φσ̃⟩) along any curve",
                source: SOURCE,
                oracle: "the value of l along curves of matrices g(t)(1 + εφσ), differentiated by nested duals in t and ε; \
                 η_ε = g_ε⁻¹ġ_ε is computed from the matrices, without a formula for δη; l is l_f or, in half of the \
                 cases, a random polynomial of no symmetry",
                bound: small(9, "floor 2⁸ N u relative to the terms"),
                needs: "a group",
                faults: &[
                    EL_BRACKET_SIGN,
                    EL_SIDES,
                    EL_POTENTIAL_SIGN,
                    LEFT_FOR_RIGHT,
                    NO_FORCE_DERIVATIVE,
                    HALF_FORCE,
                ],
                cases: |cases| cases.main_dimensions().with_group(),
                asks: Which::FirstVariation,
            }),
            law!(Law {
                name: "units-carry-forced-euler-poincare",
                statement: "on (η, e, η) both Euler–Lagrange equations of l_f hold with the η̇ of forced Euler–Poincaré; U̇ = 0",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Prop 3.2",
                oracle: "the equations on g* of (l, f), through the Legendre transform of l",
                bound: small(9, "floor 2⁸ N u relative to the terms"),
                needs: "a group",
                faults: &[EL_BRACKET_SIGN, EL_POTENTIAL_SIGN, HALF_FORCE],
                cases: |cases| cases.main_dimensions().with_group(),
                asks: Which::Units,
            }),
            law!(Law {
                name: "stationary-action",
                statement: "along solutions, dS/dε = 0 for the action S of curves g(1 + εφσ), g̃(1 + εφσ̃) with fixed ends",
                source: SOURCE,
                oracle: "the action of varied curves of matrices, by Simpson's rule at the nodes of a Runge–Kutta solution",
                bound: "dS/dε is Richardson's value for 8 and 16 steps (both rules are of order 4); its bound is an eighth \
                            of its distance from that for 4 and 8 steps: the next terms, of order 5, leave a 31st. Above it that distance may \
                            be small by chance: then for 16 and 32 steps",
                needs: "a group",
                cost: Cost::Expensive,
                faults: &[EL_BRACKET_SIGN, EL_SIDES, EL_POTENTIAL_SIGN, ARROW_SIDES],
                cases: |cases| cases.main_dimensions().with_group().smooth(),
                check: |case, fault| tried::<f64, S>(case, fault, Stationary),
            }),
        ]
    }
}

/// [`euler_lagrange::residual`].
pub(super) fn residual<T: Real, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    at: &VelocityPoint<T, N, D>,
    rates: Both<&Vector<T, N>>,
    fault: Option<&Fault>,
) -> Result<Both<Covector<T, N>>, RetractionError> {
    let (mut first, mut second) = euler_lagrange::residual(doubled, algebra, at, rates)?;
    if fault.is_some() {
        let p = doubled.partials(at)?;
        let size = |planted: Fault| T::exact(planted.size_in(fault));
        let sign = size(EL_BRACKET_SIGN) * T::int(2);
        first += algebra.coad(&at.eta, &p.eta) * sign + (p.left - p.right) * size(EL_SIDES);
        first -= p.right * (size(EL_POTENTIAL_SIGN) * T::int(2));
        second += algebra.coad(&at.psi, &p.psi) * sign + (p.left - p.right) * size(EL_SIDES);
    }
    Ok((first, second))
}

/// [`euler_lagrange::rates`].
pub(super) fn rates<T: Real, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    at: &VelocityPoint<T, N, D>,
    fault: Option<&Fault>,
) -> Result<VelocityPoint<T, N, D>, VelocityError> {
    if fault.is_none() {
        return euler_lagrange::rates(doubled, algebra, at);
    }
    let zero = Vector::zeros();
    let (first, second) = residual(doubled, algebra, at, (&zero, &zero), fault)?;
    let (eta, psi) = euler_lagrange::accelerations(doubled, at, &-first, &-second)?;
    let wrong = doubled.hat(&at.psi)? * at.u - at.u * doubled.hat(&at.eta)?;
    let u = blend(euler_lagrange::arrow_rate(doubled, at)?, wrong, ARROW_SIDES.size_in(fault));
    Ok(VelocityPoint { time: T::one(), eta, u, psi })
}

#[derive(Clone, Copy)]
enum Which {
    FirstVariation,
    Units,
    Odd,
}

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::EULER_LAGRANGE);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let group = problem.group()?;
        let planted = PlantedForced::of(problem.system, problem.fault);
        match self {
            Self::Units => units(&problem, &planted),
            Self::FirstVariation if problem.probe.integer(0, 1) == 0 => first_variation(problem, &planted),
            Self::FirstVariation => {
                let polynomial = Polynomial::new(group, &mut problem.probe);
                first_variation(problem, &polynomial)
            }
            Self::Odd => {
                let polynomial = Polynomial::new(group, &mut problem.probe).odd(problem.fault);
                odd(problem, &polynomial)
            }
        }
    }
}

/// A number with a second derivative: the outer dual is time.
type Jet<T> = Dual<Dual<T>>;

/// base (1 + X + ½X²) with X = sξ̂ + s²ζ̂: on the group to second order in s.
fn curve<T: Real, const N: usize, const D: usize>(
    group: &MatrixGroup<T, N, D>,
    base: &Matrix<T, D>,
    [xi, zeta]: &[Vector<T, N>; 2],
    s: Jet<T>,
) -> Matrix<Jet<T>, D> {
    let x = group.hat(&xi.map(Jet::lift)) * s + group.hat(&zeta.map(Jet::lift)) * (s * s);
    base.map(Jet::lift) * (Matrix::identity() + x + x * x * Jet::half())
}

/// g, g⁻¹ and (g⁻¹ġ)^∨, the outer dual being time; `None` where g is singular.
#[allow(clippy::type_complexity, reason = "an alias would hide three plain parts")]
fn velocity<T: Real, const N: usize, const D: usize>(
    group: &MatrixGroup<T, N, D>,
    g: &Matrix<Jet<T>, D>,
) -> Option<(Matrix<Dual<T>, D>, Matrix<Dual<T>, D>, Vector<Dual<T>, N>)> {
    let (value, rate) = (g.map(|v| v.re), g.map(|v| v.eps));
    let inverse = group.inverse(&value)?;
    Some((value, inverse, group.vee(&(inverse * rate))))
}

fn first_variation<T: Real, const N: usize, const D: usize>(
    mut problem: Problem<'_, T, N, D>,
    doubled: &impl DoubledLagrangian<T, N, D>,
) -> Answer {
    let (system, group, probe) = (problem.system, problem.group()?, &mut problem.probe);
    let time = system.state.time;
    let base = system.retraction.tau(&(probe.vector::<T, N>() * T::exact(0.25)))?;
    let other = base * system.retraction.tau(&(probe.vector::<T, N>() * T::exact(0.25)))?;
    let mut two = || [probe.vector::<T, N>(), probe.vector::<T, N>() * T::half()];
    let (one, tilde) = (two(), two());
    let [sigma, sigma_tilde] = two();
    let (phi, phi_rate) = (probe.unit::<T>(), probe.unit::<T>());

    // The curves at s = 0, with two derivatives in time.
    let both = Jet { re: Dual::variable(T::zero()), eps: Dual::constant(T::one()) };
    let here = velocity(group, &curve(group, &base, &one, both));
    let there = velocity(group, &curve(group, &other, &tilde, both));
    // The varied curves, with one derivative in time (outer) and one in ε.
    let s = Jet { re: Dual::constant(T::zero()), eps: Dual::constant(T::one()) };
    let bump = (Jet::lift(phi) + s * Jet::lift(phi_rate)) * Jet::constant(Dual::variable(T::zero()));
    let varied = |base: &Matrix<T, D>, through: &[Vector<T, N>; 2], sigma: &Vector<T, N>| {
        let factor = Matrix::identity() + group.hat(&sigma.map(Jet::lift)) * bump;
        velocity(group, &(curve(group, base, through, s) * factor))
    };
    let (moved, moved_tilde) = (varied(&base, &one, &sigma), varied(&other, &tilde, &sigma_tilde));
    let (
        Some((_, inverse, eta)),
        Some((g, _, psi)),
        Some((_, inverse_moved, eta_moved)),
        Some((g_moved, _, psi_moved)),
    ) = (here, there, moved, moved_tilde)
    else {
        return Err(singular());
    };
    let u = inverse * g;
    let varied =
        VelocityPoint { time: Dual::constant(time), eta: eta_moved, u: inverse_moved * g_moved, psi: psi_moved };
    let varied = doubled.value(&varied)?.eps;

    // d/dt d/dε of l with the velocities moved along φσ, φσ̃: the outer dual is ε here.
    let weight = Dual { re: phi, eps: phi_rate };
    let along = |v: &Vector<Dual<T>, N>, sigma: &Vector<T, N>| {
        v.zip_map(sigma, |re, sigma| Jet { re, eps: weight * Dual::constant(sigma) })
    };
    let moved = VelocityPoint {
        time: Jet::constant(Dual::variable(time)),
        eta: along(&eta, &sigma),
        u: u.map(Jet::constant),
        psi: along(&psi, &sigma_tilde),
    };
    let boundary = doubled.value(&moved)?;

    let moving = VelocityPoint { time: Dual::variable(time), eta, u, psi };
    let (at, rates) = (moving.map(|v| v.re), moving.map(|v| v.eps));
    let (first, second) = residual(doubled, &problem.system.algebra, &at, (&rates.eta, &rates.psi), problem.fault)?;
    let work = pair(&first, &sigma) + pair(&second, &sigma_tilde);
    let defect = varied + work * phi - boundary.eps.eps;
    let p = doubled.partials(&at)?;
    let forces = problem.turning(&at.eta, &p.eta) + problem.turning(&at.psi, &p.psi);
    let size = varied.abs() + boundary.eps.eps.abs() + forces + p.left.amax() + p.right.amax();
    Ok(Measured::defect(defect.abs(), size * at.u.amax().max(T::one()), problem.floor(256.0), || {
        let [varied, boundary] = [varied, boundary.eps.eps].map(Scalar::to_f64);
        format!("δl = {varied:e}, −⟨residual, φσ⟩ = {:e}, boundary {boundary:e}", -(work * phi).to_f64())
    }))
}

fn units<T: Real, const N: usize, const D: usize>(
    problem: &Problem<'_, T, N, D>,
    planted: &PlantedForced<'_, T, N, D>,
) -> Answer {
    let (system, algebra, fault, flow) =
        (problem.system, &problem.system.algebra, problem.fault, problem.system.equations());
    let time = system.state.time;
    let found = flow.rates(time, &system.state.momentum, &Vector::zeros())?;
    let eta = found.velocity;
    // η̇ through η(μ) on dual numbers.
    let moving = system.state.momentum.zip_map(&found.momentum, |re, eps| Dual { re, eps });
    let eta_rate = system.lagrangian.velocity(&moving, &eta.map(Dual::constant))?.map(|v| v.eps);
    let unit = VelocityPoint { time, eta, u: Matrix::identity(), psi: eta };
    let left = residual(planted, algebra, &unit, (&eta_rate, &eta_rate), fault)?;
    let right = rates(planted, algebra, &unit, fault)?;
    let size = turning(algebra, &eta, &system.state.momentum) + found.force.amax();
    let floor = problem.floor(256.0);
    let equations = Measured::defect(left.0.amax().max(left.1.amax()), size, floor, || {
        format!("the equations leave {:e} and {:e}", left.0.amax().to_f64(), left.1.amax().to_f64())
    });
    // In momenta, where sizes are known.
    let hessian = system.lagrangian.hessian(&eta);
    let off = (hessian * (right.eta - eta_rate)).amax().max((hessian * (right.psi - eta_rate)).amax());
    let solved = Measured::defect(off, size, floor, || "the accelerations are not those of η̇".into());
    let arrow = Measured::defect(right.u.amax(), eta.amax(), floor, || "U̇ ≠ 0".into());
    Ok(equations.and(solved).and(arrow))
}

/// The equations of an odd Lagrangian on the units.
fn odd<T: Real, const N: usize, const D: usize>(
    mut problem: Problem<'_, T, N, D>,
    odd: &Polynomial<'_, T, N, D>,
) -> Answer {
    let (algebra, fault, probe) = (&problem.system.algebra, problem.fault, &mut problem.probe);
    let time = problem.system.state.time;
    let (eta, turn) = (probe.vector::<T, N>(), probe.vector::<T, N>());
    let unit = VelocityPoint { time, eta, u: Matrix::identity(), psi: eta };
    let found = rates(odd, algebra, &unit, fault)?;
    let (first, second) = residual(odd, algebra, &unit, (&turn, &turn), fault)?;
    let p = odd.partials(&unit)?;
    let size = turning(algebra, &eta, &p.eta) + p.left.amax() + p.right.amax() + max_abs(&(first - second));
    let floor = problem.floor(8.0);
    let equations = Measured::defect((first + second).amax(), size, floor, || {
        format!("the two equations differ by {:e}", (first + second).amax().to_f64())
    });
    let off = max_abs(&(found.eta - found.psi));
    let apart =
        Measured::defect(off, size + found.eta.amax(), floor, || format!("η̇ and ψ̇ differ by {:e}", off.to_f64()));
    let arrow = Measured::defect(found.u.amax(), eta.amax(), floor, || "U̇ ≠ 0".into());
    Ok(equations.and(apart).and(arrow))
}

/// dS/dε at three resolutions.
#[derive(Clone, Copy)]
struct Stationary;

impl Trial<f64> for Stationary {
    const STREAM: Option<u64> = Some(stream::EULER_LAGRANGE_MOTION);

    fn judge<const N: usize, const D: usize>(self, mut problem: Problem<'_, f64, N, D>) -> Result<Verdict, Measured> {
        let (system, group) = (problem.system, problem.group()?);
        let l_f = PlantedForced::of(system, None);
        let polynomial = Polynomial::new(group, &mut problem.probe);
        let two = [stationary(&mut problem, group, &l_f), stationary(&mut problem, group, &polynomial)];
        let [one, other] = two.map(|verdict| verdict.unwrap_or_else(|measured| alone(16, measured)));
        Ok(one.and(other))
    }
}

/// Steps where sixteen are not enough.
const MOST_STEPS: usize = 32;

fn stationary<const N: usize, const D: usize>(
    problem: &mut Problem<'_, f64, N, D>,
    group: &MatrixGroup<f64, N, D>,
    doubled: &impl DoubledLagrangian<f64, N, D>,
) -> Result<Verdict, Measured> {
    let initial = problem.off_the_units(0.25, 0.125)?;
    let (start, algebra, fault) = (initial.time, &problem.system.algebra, problem.fault);
    let flow = |at: &VelocityPoint<f64, N, D>| rates(doubled, algebra, at, fault);
    let rate = flow(&initial)?;
    // A time in which nothing changes by more than a fraction of itself.
    let speed = 1.0 + initial.eta.amax() + initial.psi.amax() + rate.u.amax() + rate.eta.amax() + rate.psi.amax();
    let horizon = 0.25 / speed;
    let directions = [problem.probe.vector::<f64, N>(), problem.probe.vector::<f64, N>()];
    let derivative = |steps: usize| -> Result<(f64, f64), VelocityError> {
        let mut found = (0.0, 0.0);
        let h = horizon / steps as f64;
        let mut point = initial;
        for node in 0..=steps {
            let t = node as f64 * h;
            let weight = h / 3.0 * if node == 0 || node == steps { 1.0 } else { (2 + 2 * (node % 2)) as f64 };
            let bump = 4.0 * t * (horizon - t) / (horizon * horizon);
            let bump_rate = 4.0 * (horizon - 2.0 * t) / (horizon * horizon);
            point.time = start + t;
            let varied = varied(group, doubled, &point, &flow(&point)?.u, &directions, (bump, bump_rate))?;
            found.0 += weight * varied;
            found.1 += weight * varied.abs();
            if node < steps {
                point = runge_kutta(&flow, h, &point)?;
            }
        }
        Ok(found)
    };
    let richardson = |coarse: f64, fine: f64| fine + (fine - coarse) / 15.0;
    let mut steps = 16;
    let mut derivatives = [derivative(4)?, derivative(8)?, derivative(16)?];
    let (fine, bound) = loop {
        let [(s1, _), (s2, _), (s3, size)] = derivatives;
        let (coarse, fine) = (richardson(s1, s2), richardson(s2, s3));
        let bound = (fine - coarse).abs() / 8.0 + problem.floor(1024.0) * f64::EPSILON * size;
        if fine.abs() <= bound || steps == MOST_STEPS {
            break (fine, bound);
        }
        steps = MOST_STEPS;
        derivatives = [derivatives[1], derivatives[2], derivative(steps)?];
    };
    let [(s1, _), (s2, _), (s3, size)] = derivatives;
    let witness = || {
        format!(
            "dS/dε = {s1:e}, {s2:e}, {s3:e} with {}, {}, {steps} steps, extrapolated {fine:e}; ∫|dl/dε| = {size:e}",
            steps / 4,
            steps / 2
        )
    };
    evidence::note(|| of_relative::<f64>(16, fine.abs() / size, bound / size, witness()));
    Ok(Verdict::judge(fine.abs() / size, bound / size, witness))
}

/// A point, or the rates there.
type Reached<const N: usize, const D: usize> = Result<VelocityPoint<f64, N, D>, VelocityError>;

/// One step of the classical method of order 4.
fn runge_kutta<const N: usize, const D: usize>(
    flow: &dyn Fn(&VelocityPoint<f64, N, D>) -> Reached<N, D>,
    h: f64,
    at: &VelocityPoint<f64, N, D>,
) -> Reached<N, D> {
    let moved = |by: &VelocityPoint<f64, N, D>, h: f64| VelocityPoint {
        time: at.time + by.time * h,
        eta: at.eta + by.eta * h,
        u: at.u + by.u * h,
        psi: at.psi + by.psi * h,
    };
    let k1 = flow(at)?;
    let k2 = flow(&moved(&k1, h / 2.0))?;
    let k3 = flow(&moved(&k2, h / 2.0))?;
    let k4 = flow(&moved(&k3, h))?;
    let sum = VelocityPoint {
        time: 6.0,
        eta: k1.eta + (k2.eta + k3.eta) * 2.0 + k4.eta,
        u: k1.u + (k2.u + k3.u) * 2.0 + k4.u,
        psi: k1.psi + (k2.psi + k3.psi) * 2.0 + k4.psi,
    };
    Ok(moved(&sum, h / 6.0))
}

/// dl/dε along g(1 + εφσ), g̃(1 + εφσ̃), from the matrices at g = e: ġ = η̂, g̃ = U, and d/dt g̃ = η̂U + U̇.
fn varied<const N: usize, const D: usize>(
    group: &MatrixGroup<f64, N, D>,
    doubled: &impl DoubledLagrangian<f64, N, D>,
    VelocityPoint { time, eta, u, .. }: &VelocityPoint<f64, N, D>,
    u_rate: &Matrix<f64, D>,
    [sigma, sigma_tilde]: &[Vector<f64, N>; 2],
    (bump, bump_rate): (f64, f64),
) -> Result<f64, VelocityError> {
    let lift = |m: Matrix<f64, D>| m.map(Dual::constant);
    let small = |m: Matrix<f64, D>| m.map(|eps| Dual { re: 0.0, eps });
    let one = Matrix::<Dual<f64>, D>::identity();
    let (hat, first, second) = (group.hat(eta), group.hat(sigma), group.hat(sigma_tilde));
    let (a, b) = (one + small(first * bump), one + small(second * bump));
    let inverse = one - small(first * bump);
    let back = group.inverse(u).map_or(Matrix::zeros(), |inverse| inverse);
    let rate = lift(hat) * a + small(first * bump_rate);
    let rate_tilde = lift(hat * u + u_rate) * b + small(u * second * bump_rate);
    let inverse_tilde = (one - small(second * bump)) * lift(back);
    let (eta, psi) = (group.vee(&(inverse * rate)), group.vee(&(inverse_tilde * rate_tilde)));
    let moved = VelocityPoint { time: Dual::constant(*time), eta, u: inverse * lift(*u) * b, psi };
    Ok(doubled.value(&moved)?.eps)
}
