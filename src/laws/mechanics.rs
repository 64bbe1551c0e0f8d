//! Laws of the doubled Lagrangian l_f and its coupling k_f, off the units.

use super::CaseLaw;
use super::precision::{Measured, settle, settle_small};
use super::probe::Probe;
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::LieGroup;
use crate::harness::{Cost, Fault};
use crate::mechanics::doubled::{DoubledLagrangian, Forced, Partials, partials_by_duals};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::Real;
use crate::system::{Case, System, Visitor, cases};
use proptest::strategy::Strategy;

const BOUND: &str = "two precisions; floor 2⁶ N u relative to the terms of l_f";

/// The laws of this file.
pub const LAWS: &[CaseLaw] = &[
    CaseLaw {
        name: "coupling-antisymmetry",
        statement: "k_f(ψ, U⁻¹, η) = −k_f(η, U, ψ), and both forms of k_f agree",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §3, before Prop 3.2",
        oracle: "the same function at the inverse arrow, and the form with τ⁻¹(U⁻¹)",
        bound: BOUND,
        cost: Cost::Cheap,
        faults: &[
            Fault::new("first-copy-only", "k_f = −⟨f(η), τ⁻¹(U)⟩", "velocity-dependent forces"),
            Fault::new(
                "sum",
                "k_f = ½(⟨f(ψ), τ⁻¹(U⁻¹)⟩ + ⟨f(η), τ⁻¹(U)⟩), the sign of the second term flipped",
                "forced systems",
            ),
        ],
        cases: || cases().with_group().forced().boxed(),
        check: |case, fault| settle(case, fault, Check { case, fault, which: Which::Coupling }),
    },
    CaseLaw {
        name: "doubled-antisymmetry",
        statement: "l_f(ψ, U⁻¹, η) = −l_f(η, U, ψ)",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §3 and Thm 5.3",
        oracle: "the same function at the inverse arrow",
        bound: BOUND,
        cost: Cost::Cheap,
        faults: &[
            Fault::new("plus", "l(ψ) + l(η) − k_f", "every system"),
            Fault::new("time-shift", "k_f of the inverse arrow at t + ¼", "time-dependent forces"),
        ],
        cases: || cases().with_group().boxed(),
        check: |case, fault| settle(case, fault, Check { case, fault, which: Which::Doubled }),
    },
    CaseLaw {
        name: "doubled-partials",
        statement: "∂l_f/∂η, L*_U ∂l_f/∂U, R*_U ∂l_f/∂U, ∂l_f/∂ψ in closed form; on units L*∂l_f/∂U = R*∂l_f/∂U = f(η)",
        source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 3.1 and Prop 3.2",
        oracle: "the derivatives of the value of l_f on dual numbers, and f itself on the units",
        bound: BOUND,
        cost: Cost::Cheap,
        faults: &[
            Fault::new("left-for-right", "R*_U ∂l/∂U replaced by L*_U ∂l/∂U", "non-abelian groups"),
            Fault::new("no-force-derivative", "∂l_f/∂η without the derivative of f", "velocity-dependent forces"),
            Fault::new("half-force", "∂l_f/∂U halved", "forced systems"),
        ],
        cases: || cases().with_group().boxed(),
        check: |case, fault| settle_small(case, fault, Check { case, fault, which: Which::Partials }, 9),
    },
];

#[derive(Clone, Copy)]
enum Which {
    Coupling,
    Doubled,
    Partials,
}

#[derive(Clone, Copy)]
struct Check<'a> {
    case: &'a Case,
    fault: Option<&'a Fault>,
    which: Which,
}

/// A point (η, U, ψ) off the units, with U⁻¹.
struct Point<T: Real, const N: usize, const D: usize> {
    time: T,
    eta: Vector<T, N>,
    u: Matrix<T, D>,
    inverse: Matrix<T, D>,
    psi: Vector<T, N>,
}

impl<T: Real> Visitor<T> for Check<'_> {
    type Output = Measured;

    fn visit<const N: usize, const D: usize, R: Retraction<T, N, D>>(self, system: System<T, N, D, R>) -> Measured {
        let mut probe = Probe::new(self.case, 3);
        let (eta, psi) = (probe.vector::<T, N>(), probe.vector::<T, N>());
        let x = probe.vector::<T, N>() * T::exact(0.25);
        let Some(group) = &system.group else {
            return Measured::NotApplicable("the algebra has no group".into());
        };
        let doubled = Forced::new(&system.lagrangian, &system.force, &system.retraction);
        let judged = system.retraction.tau(&x).and_then(|u| {
            let Some(inverse) = group.inverse(&u) else {
                return Ok(Measured::Broken("τ(x) is a singular matrix".into()));
            };
            let point = Point { time: system.state.time, eta, u, inverse, psi };
            match self.which {
                Which::Coupling => self.coupling(&doubled, &point),
                Which::Doubled => self.doubled(&doubled, &point),
                Which::Partials => self.partials(&doubled, &point),
            }
        });
        judged.unwrap_or_else(|error| match error {
            RetractionError::NoGroup { .. } => Measured::NotApplicable("the algebra has no group".into()),
            _ => Measured::NotApplicable("a group element is outside the domain of the retraction".into()),
        })
    }
}

impl Check<'_> {
    fn planted(&self, name: &str) -> bool {
        Fault::planted(self.fault, name)
    }

    fn coupling<T, const N: usize, const D: usize, L, F, R>(
        &self,
        doubled: &Forced<L, F, R>,
        p: &Point<T, N, D>,
    ) -> Result<Measured, RetractionError>
    where
        T: Real,
        F: Force<T, N>,
        R: Retraction<T, N, D>,
    {
        let k = |eta: &Vector<T, N>, u: &Matrix<T, D>, inverse: &Matrix<T, D>, psi: &Vector<T, N>| {
            let force = |eta: &Vector<T, N>| doubled.force.force(p.time, eta);
            if self.planted("first-copy-only") {
                return Ok(-(force(eta) * doubled.retraction.tau_inv(u)?)[0]);
            }
            if self.planted("sum") {
                let (back, there) = (doubled.retraction.tau_inv(inverse)?, doubled.retraction.tau_inv(u)?);
                return Ok(T::half() * ((force(psi) * back)[0] + (force(eta) * there)[0]));
            }
            doubled.coupling(p.time, eta, u, psi)
        };
        let here = k(&p.eta, &p.u, &p.inverse, &p.psi)?;
        let there = k(&p.psi, &p.inverse, &p.u, &p.eta)?;
        let defined = doubled.coupling_as_defined(p.time, &p.eta, &p.u, &p.psi)?;
        let total = doubled.force.force(p.time, &p.eta).amax() + doubled.force.force(p.time, &p.psi).amax();
        let size = total * p.u.amax().max(T::one()) * p.inverse.amax().max(T::one());
        let floor = 64.0 * N as f64;
        let inverse = Measured::defect((here + there).abs(), size, floor, || {
            format!("k_f(η, U, ψ) = {:e}, k_f(ψ, U⁻¹, η) = {:e}", here.to_f64(), there.to_f64())
        });
        let forms = Measured::defect((here - defined).abs(), size, floor, || {
            format!("−½⟨f + f, τ⁻¹(U)⟩ = {:e}, as defined {:e}", here.to_f64(), defined.to_f64())
        });
        Ok(inverse.and(forms))
    }

    fn doubled<T, const N: usize, const D: usize, L, F, R>(
        &self,
        doubled: &Forced<L, F, R>,
        p: &Point<T, N, D>,
    ) -> Result<Measured, RetractionError>
    where
        T: Real,
        L: Lagrangian<T, N>,
        F: Force<T, N>,
        R: Retraction<T, N, D>,
    {
        let shift = if self.planted("time-shift") { T::exact(0.25) } else { T::zero() };
        let value = |time: T, eta: &Vector<T, N>, u: &Matrix<T, D>, psi: &Vector<T, N>| {
            let twice = doubled.lagrangian.value(eta) * T::int(2);
            Ok(doubled.value(time, eta, u, psi)? + if self.planted("plus") { twice } else { T::zero() })
        };
        let here = value(p.time, &p.eta, &p.u, &p.psi)?;
        let there = value(p.time + shift, &p.psi, &p.inverse, &p.eta)?;
        let forces = doubled.force.force(p.time, &p.eta).amax() + doubled.force.force(p.time, &p.psi).amax();
        let size = doubled.lagrangian.value(&p.eta).abs()
            + doubled.lagrangian.value(&p.psi).abs()
            + forces * p.u.amax().max(T::one()) * p.inverse.amax().max(T::one());
        Ok(Measured::defect((here + there).abs(), size, 64.0 * N as f64, || {
            format!("l_f(η, U, ψ) = {:e}, l_f(ψ, U⁻¹, η) = {:e}", here.to_f64(), there.to_f64())
        }))
    }

    fn partials<T, const N: usize, const D: usize, L, F, R>(
        &self,
        doubled: &Forced<L, F, R>,
        p: &Point<T, N, D>,
    ) -> Result<Measured, RetractionError>
    where
        T: Real,
        L: Lagrangian<T, N>,
        F: Force<T, N>,
        R: Retraction<T, N, D>,
    {
        let subject = |u: &Matrix<T, D>, psi: &Vector<T, N>| {
            let mut mine: Partials<T, N> = doubled.partials(p.time, &p.eta, u, psi)?;
            if self.planted("left-for-right") {
                mine.right = mine.left;
            }
            if self.planted("no-force-derivative") {
                mine.eta = -doubled.lagrangian.gradient(&p.eta);
            }
            if self.planted("half-force") {
                mine.left *= T::half();
                mine.right *= T::half();
            }
            Ok(mine)
        };
        let mine = subject(&p.u, &p.psi)?;
        let oracle = partials_by_duals(doubled, p.time, &p.eta, &p.u, &p.psi)?;
        let unit = subject(&Matrix::identity(), &p.eta)?;
        let (f, momentum) = (doubled.force.force(p.time, &p.eta), doubled.lagrangian.gradient(&p.eta));
        // f and f' are of the size of the terms they are made of; the partials show it.
        let scale = p.u.amax().max(T::one()) * p.inverse.amax().max(T::one());
        let size = (momentum.amax() + f.amax() + oracle.eta.amax() + oracle.psi.amax() + oracle.left.amax()) * scale;
        let near = |what: &'static str, a: &Covector<T, N>, b: &Covector<T, N>| {
            Measured::defect((a - b).amax(), size, 64.0 * N as f64, || what.into())
        };
        Ok([
            near("∂l_f/∂η", &mine.eta, &oracle.eta),
            near("L*_U ∂l_f/∂U", &mine.left, &oracle.left),
            near("R*_U ∂l_f/∂U", &mine.right, &oracle.right),
            near("∂l_f/∂ψ", &mine.psi, &oracle.psi),
            near("L* ∂l_f/∂U on a unit", &unit.left, &f),
            near("R* ∂l_f/∂U on a unit", &unit.right, &f),
            near("∂l_f/∂η on a unit", &unit.eta, &-momentum),
        ]
        .into_iter()
        .reduce(Measured::and)
        .unwrap_or(Measured::Broken("no partials".into())))
    }
}
