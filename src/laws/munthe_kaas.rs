//! Laws of the Runge–Kutta–Munthe-Kaas step: its equations hold as they are written down.

use super::planted::retraction::{INVERSE_MISSING, RIGHT_TANGENT};
use super::planted::tableau::{WRONG_STAGE, planted};
use super::question::{Answer, Measured, Problem, Question, law};
use super::{CaseLaw, Source};
use crate::algebra::{Covector, Vector};
use crate::integrators::{MuntheKaas, OneStep};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, TangentPoint};
use crate::scalar::{Real, max_abs};

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[law!(Law {
            name: "munthe-kaas-step",
            statement: "dτ_{Ξ_i} K_i = η_i, κ_i = ad*_{η_i} M_i + f_i, l'(η_i) = M_i, μ' = μ + h Σ b_j κ_j, with Ξ_i, M_i of the tableau",
            source: "Munthe-Kaas 1999, algorithm 3",
            oracle: "the equations, multiplied out with dτ; the step solves with dτ⁻¹",
            bound: small(
                12,
                "floor 2⁸ s N u: the fixed-point iteration stops at a relative change of a few u in s N equations"
            ),
            needs: "",
            faults: &[WRONG_STAGE, INVERSE_MISSING, RIGHT_TANGENT],
            cases: |cases| cases.main_dimensions(),
            asks: Stages,
        })]
    }
}

#[derive(Clone, Copy)]
struct Stages;

impl Question for Stages {
    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let system = problem.system;
        let (l, f, r, h) = (&system.lagrangian, &system.force, &system.retraction, system.step);
        let mut method = MuntheKaas::new(problem.system.equations(), r, planted(&system.tableau, problem.fault));
        let (start, mut end) = (&system.state, system.state.clone());
        method.step(&mut end, h)?;
        let s = system.tableau.stages();
        let (a, b, c) = (system.tableau.a(), system.tableau.b(), system.tableau.c());
        let floor = 256.0 * (s * system.dimension) as f64;
        let sum = |weight: &dyn Fn(usize) -> T| {
            method.stages().enumerate().fold((start.momentum, Vector::zeros()), |(mu, xi), (j, (slope, rate, _))| {
                (mu + slope * (h * weight(j)), xi + rate * (h * weight(j)))
            })
        };
        let same = |lhs: &Covector<T, N>, rhs: &Covector<T, N>, size: T, what: &str, i: usize| {
            let size = size.max(max_abs(rhs)).max(T::unit_roundoff() * T::unit_roundoff());
            Measured::defect(max_abs(&(lhs - rhs)), size, floor, || format!("{what} of stage {}", i + 1))
        };
        let (momentum, _) = sum(&|j| b[j]);
        let mut worst = same(&end.momentum, &momentum, start.momentum.amax(), "μ'", s);
        for (i, (slope, rate, velocity)) in method.stages().enumerate() {
            let (m, xi) = sum(&|j| a[(i, j)]);
            let point = match r.at(&xi) {
                Ok(point) => point,
                Err(_) => return Err(Measured::NotApplicable("the step leaves the domain of the retraction".into())),
            };
            let force = f.force(start.time + c[i] * h, velocity);
            let free = system.algebra.coad(velocity, &m);
            let rates = velocity.amax().max(rate.amax());
            // The bracket may vanish where its terms do not: with an isotropic inertia, for instance.
            let terms = system.algebra.ad(velocity).amax() * m.amax() + force.amax();
            worst = worst
                .and(same(&l.gradient(velocity), &m, start.momentum.amax(), "l'(η) − M", i))
                .and(same(slope, &(free + force), terms, "κ", i))
                .and(same(&(point.d() * rate).transpose(), &velocity.transpose(), rates, "dτ K − η", i));
        }
        Ok(worst)
    }
}
