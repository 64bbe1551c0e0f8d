//! The forced discrete Noether theorem on the fast steps, with their own stages.

use super::condition::{CONTRACTION, ROUNDINGS};
use super::engine::{OTHER_RETRACTION, TERM_MISSING, Taken, start, unsupported};
use super::step::{ABOUT, drawn, engines, forms, settled, step_of, together};
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::LieGroup;
use crate::harness::{About, Fault, Verdict, evidence};
use crate::integrators::StepError;
use crate::laws::CaseLaw;
use crate::laws::method::Point;
use crate::laws::planted::step::{BALANCE, joined};
use crate::laws::precision::of_relative;
use crate::laws::sizes::forcing;
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::{Retraction, TangentPoint};
use crate::scalar::{Dd, Scalar, larger, max_abs};
use crate::system::{Case, System};

/// Steps of a trajectory: the first starts from nothing, the second from the one before.
const STEPS: usize = 2;

pub(super) static LAWS: &[CaseLaw] = &[CaseLaw {
    about: About {
        name: "fast-noether",
        statement: "Ad*_{g'⁻¹} μ' − Ad*_{g⁻¹} μ = h Σ b_j Ad*_{g_j⁻¹} f_j with the stages of the fast step, in every kind of registers and as \
                    quaternions",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §5.2; Marsden and West 2001, §3.2, the forced discrete Noether theorem",
        oracle: "in 32 digits, from the stage velocities η_j alone: g_j = g τ(Ξ_j), Ξ_i = h Σ a_ij dτ⁻¹ η_j; Ad by conjugation, f as the case \
                 says it",
        bound: "(64 + 5 r/u) u of the terms, for a residual r: 64 roundings in a stage equation, r/(1 − 0.8) to the root",
        faults: &joined::<2, 9, 11>([TERM_MISSING, OTHER_RETRACTION], BALANCE),
        ..ABOUT
    },
    cases: drawn,
    check: |case, fault| settled(noether(case, fault)),
}];

fn noether(case: &Case, fault: Option<&Fault>) -> Result<Verdict, StepError> {
    let (start, h) = (start(case)?, step_of(case)?);
    let system = case.main::<Dd>(&()).map_err(unsupported)?;
    let mut verdicts = Vec::new();
    for (registers, form, mut method) in engines(forms(case), case, fault)? {
        let mut point = start.clone();
        for step in 0..STEPS {
            let Taken { end, report, velocities } = method(&point, h)?;
            let Some((defect, size)) = balance(&system, [&point, &end], h, &velocities) else {
                return Ok(Verdict::inconclusive("the stages could not be placed in the group"));
            };
            let u = f64::EPSILON / 2.0;
            let bound = ROUNDINGS + CONTRACTION * report.residual / u;
            let off = if defect == 0.0 { 0.0 } else { defect / (size * u) };
            let witness = || {
                format!("{form:?}, {registers:?}, step {}: the spatial momentum changes by {defect:e} more", step + 1)
            };
            evidence::note(|| of_relative::<f64>(16, off * u, bound * u, witness()));
            verdicts.push(Verdict::judge(off, bound, witness));
            point = end;
        }
    }
    Ok(together(verdicts))
}

/// The most iterations for the displacements: each contracts by |hη|.
const ITERATIONS: usize = 200;

/// What the spatial momentum changes by beside the impulses in a step of size h between two ends, and the size of the terms.
fn balance<const N: usize, const D: usize>(
    system: &System<Dd, N, D>,
    ends: [&Point<f64>; 2],
    h: f64,
    velocities: &[Vec<f64>],
) -> Option<(f64, f64)> {
    let (group, r, tableau) = (system.group.as_ref()?, &system.retraction, &system.tableau);
    let [from, to] = ends.map(|end| end.convert::<Dd>().state::<N, D>());
    let h = Dd::exact(h);
    let of = |eta: &Vec<f64>| Vector::<Dd, N>::from_fn(|a, _| Dd::exact(eta.get(a).copied().unwrap_or(0.0)));
    let velocities: Vec<_> = velocities.iter().map(of).collect();
    let s = velocities.len();
    let mut displacements = vec![Vector::<Dd, N>::zeros(); s];
    let mut change = Dd::exact(f64::INFINITY);
    for _ in 0..ITERATIONS {
        let mut rates = Vec::with_capacity(s);
        for (x, eta) in displacements.iter().zip(&velocities) {
            rates.push(r.at(x).ok()?.d_inv() * eta);
        }
        change = Dd::exact(0.0);
        for (i, x) in displacements.iter_mut().enumerate() {
            let next = (0..s).fold(Vector::zeros(), |sum, j| sum + rates[j] * (tableau.a()[(i, j)] * h));
            change = larger(change, max_abs(&(next - *x)));
            *x = next;
        }
        if change <= Dd::exact(2f64.powi(-80)) {
            break;
        }
    }
    if change > Dd::exact(2f64.powi(-70)) {
        return None;
    }
    let mut size = Dd::exact(0.0);
    let mut spatial = |g: &Matrix<Dd, D>, mu: Covector<Dd, N>, terms: Dd| {
        let ad = group.adjoint(&group.inverse(g)?)?;
        size += terms * ad.amax();
        Some(mu * ad)
    };
    let after = spatial(&to.attitude, to.momentum, to.momentum.amax())?;
    let mut left = after - spatial(&from.attitude, from.momentum, from.momentum.amax())?;
    for (j, (x, eta)) in displacements.iter().zip(&velocities).enumerate() {
        let (weight, time) = (tableau.b()[j] * h, from.time + tableau.c()[j] * h);
        let force = system.force.force(time, eta);
        let terms = forcing(&system.algebra, &force, eta, &system.lagrangian.gradient(eta));
        left -=
            spatial(&(from.attitude * r.tau(x).ok()?), force * weight, terms * nalgebra::ComplexField::abs(weight))?;
    }
    Some((max_abs(&left).to_f64(), size.to_f64()))
}
