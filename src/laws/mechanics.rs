//! Laws of the doubled Lagrangian l_f and its coupling k_f, off the units.

use super::planted::doubled::{
    COUPLING_SUM, FIRST_COPY_ONLY, HALF_FORCE, LEFT_FOR_RIGHT, NO_FORCE_DERIVATIVE, PLUS, PlantedForced, TIME_SHIFT,
};
use super::planted::retraction::{ADJOINT_INVERTED, BERNOULLI, CUT_INVERSE};
use super::question::{Answer, Measured, Problem, Question, law, singular, stream};
use super::{CaseLaw, Source};
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::LieGroup;
use crate::harness::Cost;
use crate::mechanics::doubled::{DoubledLagrangian, VelocityPoint, partials_by_duals, velocity_hessian_by_duals};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::{Real, max_abs};

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "coupling-antisymmetry",
                statement: "k_f(ψ, U⁻¹, η) = −k_f(η, U, ψ), and both forms of k_f agree",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §3, before Prop 3.2",
                oracle: "the same function at the inverse arrow, and the form with τ⁻¹(U⁻¹)",
                bound: both("floor 2⁶ N u relative to the terms of l_f"),
                needs: "a group; a force",
                faults: &[FIRST_COPY_ONLY, COUPLING_SUM, TIME_SHIFT],
                cases: |cases| cases.with_group().forced(),
                asks: Which::Coupling,
            }),
            law!(Law {
                name: "doubled-antisymmetry",
                statement: "l_f(ψ, U⁻¹, η) = −l_f(η, U, ψ)",
                source: "Martín de Diego and Sato Martín de Almagro 2019, §3 and Thm 5.3",
                oracle: "the same function at the inverse arrow",
                bound: both("floor 2⁶ N u relative to the terms of l_f"),
                needs: "a group",
                faults: &[FIRST_COPY_ONLY, COUPLING_SUM, PLUS],
                cases: |cases| cases.with_group(),
                asks: Which::Doubled,
            }),
            law!(Law {
                name: "doubled-partials",
                statement: "∂l_f/∂η, L*_U ∂l_f/∂U, R*_U ∂l_f/∂U, ∂l_f/∂ψ and the second derivatives in the velocities in closed \
                    form; on units L*∂l_f/∂U = R*∂l_f/∂U = f(η)",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 3.1 and Prop 3.2",
                oracle: "the derivatives of the value of l_f on dual numbers, and f itself on the units",
                bound: small(9, "floor 2⁶ N u relative to the terms of l_f"),
                needs: "a group",
                cost: Cost::Moderate,
                faults: &[
                    PLUS,
                    TIME_SHIFT,
                    LEFT_FOR_RIGHT,
                    NO_FORCE_DERIVATIVE,
                    HALF_FORCE,
                    CUT_INVERSE,
                    BERNOULLI,
                    ADJOINT_INVERTED,
                ],
                cases: |cases| cases.with_group(),
                asks: Which::Partials,
            }),
        ]
    }
}

#[derive(Clone, Copy)]
enum Which {
    Coupling,
    Doubled,
    Partials,
}

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::MECHANICS);

    const LARGE: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let (system, probe) = (problem.system, &mut problem.probe);
        let (eta, psi) = (probe.vector::<T, N>(), probe.vector::<T, N>());
        let x = probe.vector::<T, N>() * T::exact(0.25);
        let group = problem.group()?;
        let u = system.retraction.tau(&x)?;
        let inverse = group.inverse(&u).ok_or_else(singular)?;
        let there = VelocityPoint { time: system.state.time, eta: psi, u: inverse, psi: eta };
        let here = VelocityPoint { time: system.state.time, eta, u, psi };
        let at = BothEnds { planted: PlantedForced::of(system, problem.fault), here, there };
        match self {
            Self::Coupling => at.coupling(),
            Self::Doubled => at.doubled(),
            Self::Partials => at.partials(),
        }
    }
}

/// l_f at a point off the units, and at its inverse.
struct BothEnds<'a, T: Real, const N: usize, const D: usize> {
    planted: PlantedForced<'a, T, N, D>,
    here: VelocityPoint<T, N, D>,
    there: VelocityPoint<T, N, D>,
}

impl<T: Real, const N: usize, const D: usize> BothEnds<'_, T, N, D> {
    const FLOOR: f64 = 64.0 * N as f64;

    /// |f(η)| + |f(ψ)|, and by what rounding of U and U⁻¹ is multiplied.
    fn sizes(&self) -> (T, T) {
        let VelocityPoint { time, eta, u, psi } = &self.here;
        let force = |eta: &Vector<T, N>| self.planted.doubled.force.force(*time, eta).amax();
        (force(eta) + force(psi), u.amax().max(T::one()) * self.there.u.amax().max(T::one()))
    }

    fn coupling(&self) -> Answer {
        let (here, there) = (self.planted.coupling(&self.here)?, self.planted.coupling(&self.there)?);
        let defined = self.planted.doubled.coupling_as_defined(&self.here)?;
        let (forces, scale) = self.sizes();
        let size = forces * scale;
        let inverse = Measured::defect((here + there).abs(), size, Self::FLOOR, || {
            format!("k_f(η, U, ψ) = {:e}, k_f(ψ, U⁻¹, η) = {:e}", here.to_f64(), there.to_f64())
        });
        let forms = Measured::defect((here - defined).abs(), size, Self::FLOOR, || {
            format!("−½⟨f + f, τ⁻¹(U)⟩ = {:e}, as defined {:e}", here.to_f64(), defined.to_f64())
        });
        Ok(inverse.and(forms))
    }

    fn doubled(&self) -> Answer {
        let (planted, p) = (&self.planted, &self.here);
        let (here, there) = (planted.value(p)?, planted.value(&self.there)?);
        let (forces, scale) = self.sizes();
        let size = planted.doubled.lagrangian.value(&p.eta).abs()
            + planted.doubled.lagrangian.value(&p.psi).abs()
            + forces * scale;
        Ok(Measured::defect((here + there).abs(), size, Self::FLOOR, || {
            format!("l_f(η, U, ψ) = {:e}, l_f(ψ, U⁻¹, η) = {:e}", here.to_f64(), there.to_f64())
        }))
    }

    fn partials(&self) -> Answer {
        let (planted, p, (_, scale)) = (&self.planted, &self.here, self.sizes());
        let mine = planted.partials(p)?;
        let oracle = partials_by_duals(planted, p)?;
        let unit = planted.partials(&VelocityPoint { u: Matrix::identity(), psi: p.eta, ..*p })?;
        let (f, momentum) = (planted.doubled.force.force(p.time, &p.eta), planted.doubled.lagrangian.gradient(&p.eta));
        // f and f' are of the size of the terms they are made of; the partials show it.
        let size = (momentum.amax() + f.amax() + oracle.eta.amax() + oracle.psi.amax() + oracle.left.amax()) * scale;
        let near = |what: &'static str, a: &Covector<T, N>, b: &Covector<T, N>| {
            Measured::defect(max_abs(&(a - b)), size, Self::FLOOR, || what.into())
        };
        let ((first, cross), (other, second)) = planted.doubled.velocity_hessian(p)?;
        let ((a, c), (b, d)) = velocity_hessian_by_duals(planted, p)?;
        let bent = |what: &'static str, mine: &Matrix<T, N>, oracle: &Matrix<T, N>| {
            Measured::defect(max_abs(&(mine - oracle)), size + a.amax() + d.amax(), Self::FLOOR, || what.into())
        };
        Ok(bent("∂²l_f/∂η²", &first, &a)
            .and(bent("∂²l_f/∂ψ²", &second, &d))
            .and(bent("∂²l_f/∂ψ∂η", &cross, &c))
            .and(bent("∂²l_f/∂η∂ψ", &other, &b))
            .and(near("∂l_f/∂η", &mine.eta, &oracle.eta))
            .and(near("L*_U ∂l_f/∂U", &mine.left, &oracle.left))
            .and(near("R*_U ∂l_f/∂U", &mine.right, &oracle.right))
            .and(near("∂l_f/∂ψ", &mine.psi, &oracle.psi))
            .and(near("L* ∂l_f/∂U on a unit", &unit.left, &f))
            .and(near("R* ∂l_f/∂U on a unit", &unit.right, &f))
            .and(near("∂l_f/∂η on a unit", &unit.eta, &-momentum)))
    }
}
