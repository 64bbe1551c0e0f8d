//! The variational error theorem itself: what a perturbation of the exact discrete Lagrangian makes of the flow.
//!
//! l_d = l_d^e + h^{r+1} P needs no boundary-value problem where the step is given by (V, e, V) and the momenta at its ends are found from
//! it: F^± of l_d^e are the Legendre transforms at the ends of a solution. The step of l_d takes F⁻(V, e, V) to F⁺(V, e, V), which
//! forced Lie–Poisson is asked for from the same momentum.

use super::super::CaseLaw;
use super::super::legendre::legendre;
use super::super::planted::doubled::{HALF_FORCE, PlantedForced};
use super::super::polynomial::EVEN_PART;
use super::super::precision::{Measured, alone};
use super::super::probe::stream;
use super::super::question::{Problem, Trial, law, tried};
use super::super::variational_error::{level, local, momenta, one};
use super::equations::ArrowPolynomial;
use super::{DOUBLED, NO_U, Planted, U_SIGN};
use crate::algebra::{Matrix, Vector};
use crate::discrete::exact::{ExactSolution, Start};
use crate::discrete::{DiscreteLagrangian, Momenta, Smooth, Triple};
use crate::harness::evidence;
use crate::harness::{Cost, Verdict};
use crate::integrators::State;
use crate::mechanics::Lagrangian;
use crate::scalar::{Dd, Scalar, max_abs};
use crate::study::Findings;
use crate::system::Case;
use nalgebra::RealField;

/// The laws of this file.
pub static LAWS: &[CaseLaw] = &[law!(Law {
    name: "variational-order",
    statement: "l_d = l_d^e + h^{r+1} P with any P ∘ ι̌_d = −P, r = 1 … 4: F_{l_d} keeps the units, and there it is of order r, neither \
                    more nor less",
    source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 5.4 and Thm 5.3",
    oracle: "solutions of forced Lie–Poisson by collocation of order 16; P is the odd part of a random polynomial",
    bound: "on the units 2⁶ N u, with a margin of 2⁸; in the order a quarter: half the way to the point that is as near to the \
                next integer",
    needs: "a group; a smooth force; an algebra that is not abelian",
    cost: Cost::Heavy,
    faults: &[EVEN_PART, NO_U, U_SIGN, DOUBLED, HALF_FORCE],
    cases: |cases| cases.main_dimensions().forced_nonabelian().smooth().with_group(),
    check: |case, fault| tried::<Dd, Case>(case, fault, Study),
})];

/// Levels, each with half the step of the one before.
const LEVELS: usize = 7;

/// What the step is divided by where that of the case shows no order.
const SHORTER: [i64; 2] = [8, 64];

#[derive(Clone, Copy)]
struct Study;

impl Trial<Dd> for Study {
    const STREAM: Option<u64> = Some(stream::PERTURBATION);

    fn judge<const N: usize, const D: usize>(self, mut problem: Problem<'_, Dd, N, D>) -> Result<Verdict, Measured> {
        let order = problem.probe.integer(1, 4) as u32;
        let group = problem.group()?;
        let odd = ArrowPolynomial::<Dd, D>::random(&mut problem.probe, 0.0).odd(problem.fault);
        let perturbation = Planted { l_d: Smooth::new(odd, group), fault: problem.fault };
        // From steps of size h and smaller, with the local errors.
        let of_step = |h: Dd| match errors(&problem, &perturbation, order, h) {
            Ok((errors, units)) => (alone(32, units).and(one(&errors, 0, order).1), Some(errors)),
            Err(why) => (alone(32, why), None),
        };
        let step = problem.system.step;
        let mut measured = of_step(step);
        for shorter in SHORTER {
            if !matches!(measured.0, Verdict::Inconclusive { .. }) {
                break;
            }
            measured = of_step(step / Dd::int(shorter));
        }
        let (verdict, errors) = measured;
        evidence::note_all(|| errors.map(|errors| errors.evidence_of(0, order, 32, ", after one step")));
        Ok(verdict)
    }
}

/// The local errors, and how far the steps leave the units.
fn errors<const N: usize, const D: usize>(
    Problem { system, fault, .. }: &Problem<'_, Dd, N, D>,
    perturbation: &impl DiscreteLagrangian<Dd, N, D>,
    order: u32,
    h: Dd,
) -> Result<(Findings, Measured), Measured> {
    let lost = |what: &str| Measured::Inconclusive(format!("{what} could not be computed"));
    let (r, time, unit) = (&system.retraction, system.state.time, Matrix::identity());
    let planted = PlantedForced::of(system, *fault);
    let exact = ExactSolution::new(planted, r, 8).map_err(|_| lost("the solution on the units"))?;
    let eta = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros());
    let eta = eta.map_err(|_| lost("the velocity"))?;
    let times: Vec<Dd> = (0..LEVELS).rev().map(|k| h / Dd::int(1 << k)).collect();
    let start = Start { time, eta, u: unit, psi: eta };
    let points = exact.at(&start, &times).map_err(|_| lost("the solution on the units"))?;
    let momenta_at = |point: &Start<Dd, N, D>| {
        let found = legendre(&planted, point, *fault).map_err(|_| lost("the Legendre transform"))?;
        Ok::<_, Measured>(Momenta { lambda: found.lambda, u: found.u, mu: found.mu })
    };
    let (mut errors, mut units) = (local(["the restricted flow"]), Measured::exact());
    for (step, point) in times.iter().zip(&points).rev() {
        let weight = (0..=order).fold(Dd::exact(1.0), |product, _| product * *step);
        let x = Triple { v: point.v, u: unit, w: point.w };
        let slopes = perturbation.slopes(&x)?;
        let sum = |exact: Momenta<Dd, N, D>, further: Momenta<Dd, N, D>| Momenta {
            lambda: exact.lambda + further.lambda * weight,
            u: exact.u,
            mu: exact.mu + further.mu * weight,
        };
        let begin = sum(momenta_at(&start)?, Momenta::minus(&slopes, &x));
        let end = momenta_at(&point.point)?;
        let end = sum(end, Momenta::plus(&slopes, &x)?);
        let from = State { momentum: begin.mu, ..system.state.clone() };
        let expected = momenta(system, &from, &[*step * Dd::half(), *step]);
        let expected = expected.map_err(|_| lost("the solution of forced Lie–Poisson"))?[1];
        errors.push(level(*step, [(max_abs(&(end.mu - expected)), expected.amax())]));
        units = units.and(on_units(&begin)).and(on_units(&end));
    }
    Ok((errors, units))
}

/// How far (λ, U, μ) is from (μ, e, μ).
fn on_units<const N: usize, const D: usize>(at: &Momenta<Dd, N, D>) -> Measured {
    let floor = 64.0 * N as f64;
    let apart = max_abs(&(at.lambda - at.mu));
    let momenta = Measured::defect(apart, at.mu.amax().max(Dd::exact(1.0)), floor, || {
        format!("λ and μ differ by {:e}", apart.to_f64())
    });
    let off = max_abs(&(at.u - Matrix::identity()));
    momenta.and(Measured::defect(off, at.u.amax(), floor, || format!("U is off e by {:e}", off.to_f64())))
}
