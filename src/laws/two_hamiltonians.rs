//! Laws of the two Hamiltonians of a forced system: h_f, and h̃_f = E∘(FL×)⁻¹ from the Legendre transform of l_f.

use super::hamiltonian::{H_FORCE_ONCE, H_PLUS, H_SIGN, PlantedHamiltonian, hamilton_rates};
use super::planted::doubled::PlantedForced;
use super::precision::{Measured, of_relative};
use super::probe::{stream, unit_of};
use super::question::{Answer, Problem, Question, Trial, law, tried};
use super::sizes::forcing;
use super::{CaseLaw, Source};
use crate::algebra::{Covector, Matrix, Vector, elimination, pair};
use crate::harness::{Cost, Verdict, evidence};
use crate::mechanics::doubled::{MomentumPoint, VelocityError};
use crate::mechanics::hamiltonian::{DoubledHamiltonian, LegendreHamiltonian};
use crate::mechanics::{Force, Lagrangian, LegendreError};
use crate::retraction::Retraction;
use crate::scalar::{Dd, Dual, Real, Scalar, dual, larger, max_abs};
use crate::system::force::Argument;
use crate::system::{Case, ForceTerm, Motion};

const SOURCE: &str = "Martín de Diego and Sato Martín de Almagro 2019, Thm 4.13";

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "two-hamiltonians-units",
                statement: "on (μ, e, μ): dh_f = dh̃_f = (−η, −f, η), and the two vector fields are equal",
                source: SOURCE,
                oracle: "each Hamiltonian against the other: one is built on the Legendre transform of l, the other on that of l_f",
                bound: small(9, "floor 2⁸ N u relative to the terms"),
                needs: "a group; a force",
                faults: &[H_SIGN, H_PLUS],
                cases: |cases| cases.main_dimensions().with_group().forced(),
                asks: OnUnits(true),
            }),
            law!(Law {
                name: "two-hamiltonians-load",
                statement: "h_f = h̃_f everywhere, with their vector fields, when f does not depend on the velocity",
                source: SOURCE,
                oracle: "each Hamiltonian against the other, off the units",
                bound: small(9, "floor 2⁸ N u relative to the terms"),
                needs: "a group; a force",
                faults: &[H_SIGN, H_PLUS],
                cases: |cases| cases.main_dimensions().with_group().forced().mapped(loaded),
                asks: OnUnits(false),
            }),
            law!(Law {
                name: "two-hamiltonians",
                statement: "off the units, U = τ(x): h̃_f − h_f = ⅛(a_ψ l''(ψ)⁻¹ a_ψᵀ − a_η l''(η)⁻¹ a_ηᵀ) + O(|x|³), a = ⟨f'·, x⟩",
                source: SOURCE,
                oracle: "second-order perturbation of the Legendre transform; 32 digits at two sizes of x",
                bound: "the remainder shrinks by more than 16^2.5 from x to x/16 (theory: 16³), or is below 2¹² N u",
                needs: "a group; a force",
                cost: Cost::Expensive,
                faults: &[H_FORCE_ONCE, H_SIGN, H_PLUS],
                cases: |cases| cases.main_dimensions().with_group().forced(),
                check: |case, fault| tried::<Dd, S>(case, fault, Difference),
            }),
        ]
    }
}

/// The case with those of its forces that do not depend on the velocity; a constant one if there are none.
fn loaded(mut case: Case) -> Case {
    case.forces.retain(|force| force.description().argument == Argument::Nothing);
    if case.forces.is_empty() {
        let (Motion::Velocity(list) | Motion::Momentum(list)) = &case.start.motion;
        case.forces.push(ForceTerm::Constant { value: list.clone() });
    }
    case
}

/// Whether on the units.
#[derive(Clone, Copy)]
struct OnUnits(bool);

impl Question for OnUnits {
    const STREAM: Option<u64> = Some(stream::TWO_HAMILTONIANS);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let (system, fault) = (problem.system, problem.fault);
        let (time, mu) = (system.state.time, system.state.momentum);
        let planted = PlantedHamiltonian::of(system, fault);
        let other = LegendreHamiltonian::new(PlantedForced::of(system, None));
        let (lambda, u) = if self.0 {
            (mu, Matrix::identity())
        } else {
            let off = problem.probe.covector::<T, N>() * (T::exact(0.25) * unit_of(&mu));
            (mu + off, system.retraction.tau(&(problem.probe.vector::<T, N>() * T::exact(0.25)))?)
        };
        let point = MomentumPoint { time, lambda, u, mu };
        let mine = planted.partials(&point)?;
        let theirs = other.partials(&point)?;
        let force = system.force.force(time, &theirs.mu);
        let floor = problem.floor(256.0);
        let near = |what: &'static str, off: T, size: T| Measured::defect(off, size, floor, || what.into());
        let velocity = theirs.lambda.amax() + theirs.mu.amax();
        let terms = forcing(&problem.system.algebra, &force, &theirs.mu, &mu)
            + forcing(&problem.system.algebra, &force, &theirs.lambda, &lambda);
        let push = theirs.left.amax() + theirs.right.amax() + terms;
        let mut found = near("∂h/∂λ", max_abs(&(mine.lambda - theirs.lambda)), velocity)
            .and(near("∂h/∂μ", max_abs(&(mine.mu - theirs.mu)), velocity))
            .and(near("L*_U ∂h/∂U", max_abs(&(mine.left - theirs.left)), push))
            .and(near("R*_U ∂h/∂U", max_abs(&(mine.right - theirs.right)), push));
        let fields = (
            hamilton_rates(&planted, &problem.system.algebra, &point, fault)?,
            hamilton_rates(&other, &problem.system.algebra, &point, None)?,
        );
        let turn = problem.turning(&theirs.mu, &mu) + problem.turning(&theirs.lambda, &lambda);
        let size = push + turn;
        let difference = larger(max_abs(&(fields.0.lambda - fields.1.lambda)), max_abs(&(fields.0.mu - fields.1.mu)));
        found = found.and(near("the vector fields", difference, size));
        if self.0 {
            let expected = [(theirs.left + force).amax(), (theirs.lambda + theirs.mu).amax()];
            found = found.and(near("∂h̃/∂U + f", expected[0], push)).and(near("∂h̃/∂λ + η", expected[1], velocity));
        } else {
            let (here, there) = (planted.value(&point)?, other.value(&point)?);
            let size = pair(&mu.abs(), &theirs.mu.abs()) + pair(&lambda.abs(), &theirs.lambda.abs()) + push;
            found = found.and(near("the values", (here - there).abs(), size));
        }
        Ok(found)
    }
}

/// h̃_f − h_f and its prediction at two sizes of x.
#[derive(Clone, Copy)]
struct Difference;

impl Trial<Dd> for Difference {
    const STREAM: Option<u64> = Some(stream::TWO_HAMILTONIANS_MOTION);

    fn judge<const N: usize, const D: usize>(self, problem: Problem<'_, Dd, N, D>) -> Result<Verdict, Measured> {
        let Problem { system, mut probe, fault, .. } = problem;
        let (time, mu) = (system.state.time, system.state.momentum);
        let lambda = mu + probe.covector::<Dd, N>() * (Dd::exact(0.5) * unit_of(&mu));
        let planted = PlantedHamiltonian::of(system, fault);
        let other = LegendreHamiltonian::new(PlantedForced::of(system, None));
        let eta = system.lagrangian.velocity(&lambda, &Vector::zeros())?;
        let psi = system.lagrangian.velocity(&mu, &Vector::zeros())?;
        let direction = probe.vector::<Dd, N>();
        // ½ k' (L'')⁻¹ k' at the velocities of h_f, with k' = −½ (a_η, a_ψ) and L'' = diag(−l''(η), l''(ψ)).
        let term = |eta: &Vector<Dd, N>, x: &Vector<Dd, N>| -> Result<Dd, LegendreError> {
            let hessian = system.lagrangian.hessian(eta);
            let inverse = elimination::inverse(&hessian).ok_or_else(|| LegendreError::singular(eta, &hessian))?;
            let mut a = Covector::<Dd, N>::zeros();
            for b in 0..N {
                let slope = system.force.force(Dual::constant(time), &dual::along(eta, b)).map(|v| v.eps);
                a[b] = pair(&slope, x);
            }
            Ok(pair(&a, &(inverse * a.transpose())) * Dd::exact(0.125))
        };
        let remainder = |exponent: i32| -> Result<(Dd, Dd), VelocityError> {
            let x = direction * Dd::exact(2f64.powi(exponent));
            let point = MomentumPoint { time, lambda, u: system.retraction.tau(&x)?, mu };
            let difference = other.value(&point)? - planted.value(&point)?;
            let predicted = term(&psi, &x)? - term(&eta, &x)?;
            Ok((difference - predicted, predicted))
        };
        let ((large, predicted), (small, _)) = (remainder(-20)?, remainder(-24)?);
        let size = pair(&mu.abs(), &psi.abs()) + pair(&lambda.abs(), &eta.abs());
        let relative = |v: Dd| (v / size).to_f64().abs();
        let floor = Dd::unit_roundoff().to_f64() * 4096.0 * system.dimension as f64;
        let (defect, bound) = (relative(small), floor.max(relative(large) / 1024.0));
        let witness = || {
            let [large, small, predicted] = [large, small, predicted].map(Scalar::to_f64);
            format!("off the prediction {predicted:e} by {large:e}, and by {small:e} at x/16")
        };
        evidence::note(|| of_relative::<Dd>(32, defect, bound, witness()));
        Ok(Verdict::judge(defect, bound, witness))
    }
}
