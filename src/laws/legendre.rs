//! Laws of the modified Legendre transforms between g×G×g and g*×G×g*, off the units.

use super::euler_lagrange::{ARROW_SIDES, EL_BRACKET_SIGN, EL_POTENTIAL_SIGN, EL_SIDES, rates};
use super::hamiltonian::{
    FIBRE_SIGN, HAMILTON_ARROW, HAMILTON_SIDES, HAMILTON_SIGN, hamilton_rates, hamiltonian_legendre,
};
use super::planted::blend;
use super::planted::doubled::PlantedForced;
use super::polynomial::Polynomial;
use super::question::{Answer, Measured, Problem, Question, law, near_enough, stream};
use super::sizes::turning;
use super::{CaseLaw, Source};
use crate::algebra::{Matrix, Vector, elimination, pair};
use crate::harness::Fault;
use crate::mechanics::doubled::{Both, DoubledLagrangian, MomentumPoint, VelocityError, VelocityPoint};
use crate::mechanics::hamiltonian::{DoubledHamiltonian, LegendreHamiltonian, modified_legendre, modified_pairing};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::{Real, Scalar, larger, max_abs};

const SOURCE: &str = "Martín de Diego and Sato Martín de Almagro 2019, §4.3 and Thm 4.13";
// What may be wrong with the modified Legendre transform.
pub(super) const LEGENDRE_SIGN: Fault = Fault::new("legendre-first-sign", "λ = +∂l/∂η", "every system");
pub(super) const LEGENDRE_ON_UNITS: Fault = Fault::new(
    "legendre-on-units",
    "the derivatives taken at U = e",
    "velocity-dependent forces and potentials, off the units",
);

macro_rules! floor {
    () => {
        "floor 2¹⁰ N u relative to the terms; U so close to e that the second derivatives change by less than 1/16"
    };
}

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "legendre-round-trip",
                statement: "velocities(FL×(η, U, ψ)) = (η, ψ); ⟨FL×(v), v⟩_× = d/ds l(sη, U, sψ) at s = 1",
                source: SOURCE,
                oracle: "the velocities that the momenta were made from; the value of l on dual numbers, for l_f or, in half of the \
                 cases, a random polynomial",
                bound: small(5, floor!()),
                needs: "a group",
                faults: &[LEGENDRE_SIGN, LEGENDRE_ON_UNITS],
                cases: |cases| cases.main_dimensions().with_group(),
                asks: Which::RoundTrip,
            }),
            law!(Law {
                name: "legendre-intertwines",
                statement: "FL× carries the Euler–Lagrange vector field of l to the Hamiltonian one of h̃ = E_l∘(FL×)⁻¹",
                source: SOURCE,
                oracle: "each vector field against the other: one solves for accelerations, the other is that of a bracket; for \
                 l_f or, in half of the cases, a random polynomial",
                bound: small(5, floor!()),
                needs: "a group",
                faults: &[
                    EL_BRACKET_SIGN,
                    EL_SIDES,
                    EL_POTENTIAL_SIGN,
                    ARROW_SIDES,
                    LEGENDRE_SIGN,
                    LEGENDRE_ON_UNITS,
                    HAMILTON_SIGN,
                    HAMILTON_SIDES,
                    HAMILTON_ARROW,
                ],
                cases: |cases| cases.main_dimensions().with_group(),
                asks: Which::Intertwines,
            }),
            law!(Law {
                name: "legendre-hamiltonian",
                statement: "at FL×(v): h̃ = E_l(v), Fh̃×(FL×(v)) = v and dh̃ = −⟨dλ, η⟩ − ∂l/∂U dU + ⟨dμ, ψ⟩",
                source: SOURCE,
                oracle: "E_l on dual numbers at the velocities that the momenta were made from; the value of h̃ on dual numbers, \
                 through the inverse transform, along a random direction",
                bound: small(5, floor!()),
                needs: "a group",
                faults: &[FIBRE_SIGN, LEGENDRE_SIGN, LEGENDRE_ON_UNITS],
                cases: |cases| cases.main_dimensions().with_group(),
                asks: Which::Hamiltonian,
            }),
        ]
    }
}

/// [`modified_legendre`].
pub(super) fn legendre<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    at: &VelocityPoint<S, N, D>,
    fault: Option<&Fault>,
) -> Result<MomentumPoint<S, N, D>, RetractionError> {
    let mut momenta = modified_legendre(doubled, at)?;
    if fault.is_some() {
        let unit = modified_legendre(doubled, &VelocityPoint { u: Matrix::identity(), ..*at })?;
        momenta.lambda = blend(momenta.lambda, -momenta.lambda, LEGENDRE_SIGN.size_in(fault));
        momenta.lambda = blend(momenta.lambda, unit.lambda, LEGENDRE_ON_UNITS.size_in(fault));
        momenta.mu = blend(momenta.mu, unit.mu, LEGENDRE_ON_UNITS.size_in(fault));
    }
    Ok(momenta)
}

#[derive(Clone, Copy)]
enum Which {
    RoundTrip,
    Intertwines,
    Hamiltonian,
}

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::LEGENDRE);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let group = problem.group()?;
        if problem.probe.integer(0, 1) == 0 {
            let l_f = PlantedForced::of(problem.system, None);
            let p = near_the_units(&mut problem, &l_f)?;
            return OffUnits { problem, doubled: &l_f, p }.judge(self);
        }
        let polynomial = Polynomial::new(group, &mut problem.probe);
        let p = problem.off_the_units(0.25, 0.25)?;
        OffUnits { problem, doubled: &polynomial, p }.judge(self)
    }
}

/// A doubled Lagrangian at a point.
struct OffUnits<'a, L, T: Real, const N: usize, const D: usize> {
    problem: Problem<'a, T, N, D>,
    doubled: &'a L,
    p: VelocityPoint<T, N, D>,
}

impl<L: DoubledLagrangian<T, N, D> + Clone, T: Real, const N: usize, const D: usize> OffUnits<'_, L, T, N, D> {
    fn judge(mut self, which: Which) -> Answer {
        match which {
            Which::RoundTrip => self.round_trip(),
            Which::Intertwines => self.intertwines(),
            Which::Hamiltonian => self.hamiltonian(),
        }
    }

    fn round_trip(&self) -> Answer {
        let (doubled, p) = (self.doubled, &self.p);
        let momenta = legendre(doubled, p, self.problem.fault)?;
        let far = |(eta, psi): Both<Vector<T, N>>| larger(max_abs(&(eta - p.eta)), max_abs(&(psi - p.psi)));
        let off = far(doubled.velocities(&momenta)?);
        let floor = 1024.0 * N as f64;
        // The terms of a velocity cancel where a gyrostat term is all of its momentum: so far it goes with twice the momenta.
        let (lambda, mu) = (momenta.lambda * T::int(2), momenta.mu * T::int(2));
        let terms = doubled.velocities(&MomentumPoint { lambda, mu, ..momenta }).map_or(T::zero(), far);
        let trip = Measured::defect(off, p.eta.amax().max(p.psi.amax()).max(terms), floor, || {
            format!("the velocities of the momenta are off by {:e}", off.to_f64())
        });
        let value = doubled.value(&p.moving(&scaling(p)))?;
        let paired = modified_pairing(&momenta, p);
        let size = terms_of_pairing(&momenta, p);
        Ok(trip.and(Measured::defect((paired - value.eps).abs(), size, floor, || {
            format!("⟨FL×(v), v⟩_× = {:e}, d/ds l(sη, U, sψ) = {:e}", paired.to_f64(), value.eps.to_f64())
        })))
    }

    fn intertwines(&self) -> Answer {
        let (doubled, p, algebra, fault) = (self.doubled, &self.p, &self.problem.system.algebra, self.problem.fault);
        let found = rates(doubled, algebra, p, fault)?;
        let moving = legendre(doubled, &p.moving(&found), fault)?;
        let (momenta, carried) = (moving.map(|v| v.re), moving.map(|v| v.eps));
        let field = hamilton_rates(&LegendreHamiltonian::new(doubled.clone()), algebra, &momenta, fault)?;
        // At rest the terms with η̇ and ψ̇ cancel those of a force that grows with time.
        let ((a, b), (c, d)) = doubled.velocity_hessian(p)?;
        let hessian = [a, b, c, d].iter().fold(T::zero(), |size, block| size.max(block.amax()));
        let size = turning(algebra, &p.eta, &momenta.lambda)
            + turning(algebra, &p.psi, &momenta.mu)
            + field.lambda.amax()
            + field.mu.amax()
            + hessian * (found.eta.amax() + found.psi.amax());
        let floor = self.problem.floor(1024.0);
        let near = |what: &'static str, off: T, size: T| Measured::defect(off, size, floor, || what.into());
        let arrow = p.u.amax() * (p.eta.amax() + p.psi.amax());
        Ok(near("λ̇", max_abs(&(carried.lambda - field.lambda)), size)
            .and(near("μ̇", max_abs(&(carried.mu - field.mu)), size))
            .and(near("U̇", max_abs(&(found.u - field.u)), arrow)))
    }

    fn hamiltonian(&mut self) -> Answer {
        let (doubled, p, probe) = (self.doubled, &self.p, &mut self.problem.probe);
        let momenta = legendre(doubled, p, self.problem.fault)?;
        let h = LegendreHamiltonian::new(doubled.clone());
        let back = hamiltonian_legendre(&h, &momenta, self.problem.fault)?;
        let floor = 1024.0 * N as f64;
        let back = larger(max_abs(&(back.eta - p.eta)), max_abs(&(back.psi - p.psi)));
        let back = Measured::defect(back, p.eta.amax().max(p.psi.amax()), floor, || "Fh̃×(FL×(v)) ≠ v".into());

        // h̃ and its derivative along (δλ, U δ̂u, δμ), by its value alone.
        let (d_lambda, d_mu, d_u) = (probe.covector::<T, N>(), probe.covector::<T, N>(), probe.vector::<T, N>());
        let along = MomentumPoint { time: T::zero(), lambda: d_lambda, u: p.u * h.hat(&d_u)?, mu: d_mu };
        let value = h.value(&momenta.moving(&along))?;
        let l = doubled.value(&p.moving(&scaling(p)))?;
        let energy = l.eps - l.re;
        let size = terms_of_pairing(&momenta, p) + l.re.abs();
        let energy = Measured::defect((value.re - energy).abs(), size, floor, || {
            format!("h̃ = {:e}, E_l = {:e}", value.re.to_f64(), energy.to_f64())
        });
        let left = doubled.partials(p)?.left;
        let expected = pair(&d_mu, &p.psi) - pair(&d_lambda, &p.eta) - pair(&left, &d_u);
        let size = p.psi.amax() + p.eta.amax() + left.amax();
        let slope = Measured::defect((value.eps - expected).abs(), size, floor, || {
            format!("dh̃ = {:e}, from the velocities {:e}", value.eps.to_f64(), expected.to_f64())
        });
        Ok(back.and(energy).and(slope))
    }
}

/// The rates of (η, ψ) ↦ (sη, sψ) at s = 1.
fn scaling<T: Real, const N: usize, const D: usize>(p: &VelocityPoint<T, N, D>) -> VelocityPoint<T, N, D> {
    VelocityPoint { time: T::zero(), u: Matrix::zeros(), ..*p }
}

/// The size of the terms of ⟨FL×(v), v⟩_×.
fn terms_of_pairing<T: Real, const N: usize, const D: usize>(
    momenta: &MomentumPoint<T, N, D>,
    p: &VelocityPoint<T, N, D>,
) -> T {
    pair(&momenta.lambda.abs(), &p.eta.abs()) + pair(&momenta.mu.abs(), &p.psi.abs())
}

/// A point off the units, with x = τ⁻¹(U) so small that the second derivatives of l differ from those on the units by less than 1/16 of
/// themselves, so that Newton's method contracts.
fn near_the_units<T: Real, const N: usize, const D: usize>(
    problem: &mut Problem<'_, T, N, D>,
    doubled: &impl DoubledLagrangian<T, N, D>,
) -> Result<VelocityPoint<T, N, D>, VelocityError> {
    let (point, system) = (problem.off_the_units(0.25, 0.25)?, problem.system);
    let ((a, c), (b, d)) = doubled.velocity_hessian(&VelocityPoint { u: Matrix::identity(), ..point })?;
    let size = |m: Option<Matrix<T, N>>| m.map_or(T::zero(), |m| m.amax());
    let scale =
        (size(elimination::inverse(&a)) + size(elimination::inverse(&d))) * T::int(16 * system.dimension as i64);
    let change = |u: &Matrix<T, D>| {
        let ((a1, c1), (b1, d1)) = doubled.velocity_hessian(&VelocityPoint { u: *u, ..point })?;
        let blocks = [a1 - a, b1 - b, c1 - c, d1 - d];
        Ok(blocks.iter().fold(T::zero(), |change, block| larger(change, max_abs(block))) * scale)
    };
    let x = system.retraction.tau_inv(&point.u)?;
    let u = near_enough(&system.retraction, (point.u, x), change)?;
    Ok(VelocityPoint { u, ..point })
}
