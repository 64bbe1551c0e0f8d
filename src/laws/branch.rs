//! A step at any size is the one that continues from h = 0, or it is refused.

use super::planted::retraction::Plant;
use super::probe::{Probe, stream};
use super::{CaseLaw, Source};
use crate::algebra::{Covector, Vector};
use crate::harness::{About, Cost, Fault, Verdict};
use crate::integrators::variational::Variational;
use crate::integrators::{OneStep, StepError};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::system::{System, Visitor};
use nalgebra::DMatrix;
use std::fmt::Debug;

/// Newton's method from a constant velocity, without a look at the branch.
const ANY_ROOT: Fault = Fault::new(
    "any-root",
    "Newton's method at the full step from H_i = η; whatever root it finds is taken",
    "steps behind a fold, or with several roots",
);
/// A continuation that jumps.
const COARSE: Fault = Fault::new(
    "coarse-continuation",
    "a continuation in h by eighths of the step, without a look at det J or at tangents",
    "steps behind a fold, or with several roots",
);

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[CaseLaw {
            about: About {
                name: "branch",
                statement: "a step of any size, ‖ad_η‖|h| to 64, is the root of the stage equations that continues from h = 0, or it is \
                            refused",
                source: "Keller 1977: a branch ends where det J = 0",
                oracle: "the branch from h = 0, followed in small steps of h by code of its own",
                bound: "2⁻¹⁶ of the stage displacements: roots are farther apart, but next to a fold",
                needs: "an algebra that is not abelian",
                cost: Cost::Heavy,
                faults: &[ANY_ROOT, COARSE],
            },
            cases: |cases| cases.main_dimensions().nonabelian(),
            check: |case, fault| {
                case.visit_main::<f64, _>(&Plant(fault), Check { case, fault })
                    .unwrap_or_else(|e| Verdict::broken(format!("a generated case cannot be built: {e}")))
            },
        }]
    }
}

/// Distances of displacements that are not those of two roots, relative.
const BOUND: f64 = 1.0 / 65536.0;

/// The largest ‖ad_η‖|h|, and the number of halvings of it that are drawn.
const LARGEST: (f64, i32) = (64.0, 8);

#[derive(Clone, Copy)]
struct Check<'a> {
    case: &'a dyn Debug,
    fault: Option<&'a Fault>,
}

impl Visitor<f64> for Check<'_> {
    type Output = Verdict;

    fn visit<const N: usize, const D: usize, R: Retraction<f64, N, D>, L: Lagrangian<f64, N>, F: Force<f64, N>>(
        self,
        system: System<f64, N, D, R, L, F>,
    ) -> Verdict {
        let mut probe = Probe::new(self.case, stream::BRANCH);
        let Ok(eta) = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros()) else {
            return Verdict::inconclusive("no velocity");
        };
        let ad = system.algebra.ad(&eta);
        let rate = ad.row_iter().map(|row| row.abs().sum()).fold(eta.amax(), f64::max);
        let halvings: f64 = probe.power_of_two(-LARGEST.1, 0);
        let angle = LARGEST.0 * halvings * (1.0 + probe.unit::<f64>().abs()) / 2.0;
        let step = if rate > 0.0 { angle / rate * system.step.signum() } else { system.step };
        let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
        let mut method = Variational::new(l, f, r, system.tableau.clone());
        let Some(found) = self.taken(&system, &mut method, step, &eta) else {
            return Verdict::not_applicable("the step is refused");
        };
        let mut branch = Branch::new(&system, &mut method, step, &eta);
        let size = found.iter().fold(0.0_f64, |size, v| size.max(v.abs()));
        match branch.follow() {
            End::Reached => {
                let right = branch.displacements();
                let off = right.iter().zip(&found).fold(0.0_f64, |off, (a, b)| off.max((a - b).abs()));
                Verdict::judge(if off == 0.0 { 0.0 } else { off / size }, BOUND, || {
                    format!("at h = {step:e} the step is on another branch: Ξ = {found:?}, and {right:?} from h = 0")
                })
            }
            End::Fold(fraction) if fraction > NEARLY => {
                Verdict::inconclusive("the step is next to the end of the branch")
            }
            End::Fold(fraction) => Verdict::broken(format!(
                "at h = {step:e} a step is taken, and the branch ends near {fraction:.6} of it: Ξ = {found:?}"
            )),
            End::Lost => Verdict::inconclusive("the branch was not followed to its end"),
        }
    }
}

impl Check<'_> {
    /// Ξ_1 … Ξ_s of the step, by the integrator or by what is planted; none if it is refused.
    fn taken<
        const N: usize,
        const D: usize,
        R,
        L,
        F,
        Q: Lagrangian<f64, N>,
        G: Force<f64, N>,
        P: Retraction<f64, N, D>,
    >(
        &self,
        system: &System<f64, N, D, R, L, F>,
        method: &mut Variational<f64, N, D, Q, G, P>,
        step: f64,
        eta: &Vector<f64, N>,
    ) -> Option<Vec<f64>> {
        let parts = match self.fault {
            Some(fault) if fault.name == COARSE.name => 8,
            Some(fault) if fault.name == ANY_ROOT.name => 1,
            _ => {
                let mut state = system.state.clone();
                method.step(&mut state, step).ok()?;
                return Some(method.stage_displacements().flat_map(|x| x.data.0[0]).collect());
            }
        };
        let mut branch = Branch::new(system, method, step, eta);
        for part in 1..=parts {
            branch.newton(f64::from(part) / f64::from(parts), None).ok()?;
        }
        Some(branch.displacements())
    }
}

/// A fold beyond this share of the step may be a step of rounding away from it.
const NEARLY: f64 = 1.0 - 1.0 / 1024.0;

/// The most points of a branch.
const POINTS: usize = 4000;

/// The first increment of h, and the least, relative to the step.
const INCREMENTS: (f64, f64) = (1.0 / 256.0, 1.0 / (1 << 24) as f64);

/// A correction at most this share of the predicted change belongs to the branch; with a sixteenth of it the increment is doubled.
const NEAR: f64 = 1.0 / 16.0;

/// The most iterations of Newton's method at a point.
const ITERATIONS: usize = 30;

/// Corrections below this share of H are rounding: equations whose terms exceed 1/√u times the momentum are refused.
const ROUNDING: f64 = 1.0 / (1_u64 << 28) as f64;

/// Where the branch led.
enum End {
    /// To the whole step.
    Reached,
    /// It ends at this share of the step.
    Fold(f64),
    /// [`POINTS`] were not enough.
    Lost,
}

/// A root H of the stage equations at a share of a step.
struct Branch<'a, const N: usize, const D: usize, R, L, F, Q, G, P> {
    system: &'a System<f64, N, D, R, L, F>,
    method: &'a mut Variational<f64, N, D, Q, G, P>,
    step: f64,
    /// H_1 … H_s.
    rates: Vec<Vector<f64, N>>,
    residual: Vec<Covector<f64, N>>,
}

impl<'a, const N: usize, const D: usize, R, L, F, Q, G, P> Branch<'a, N, D, R, L, F, Q, G, P>
where
    Q: Lagrangian<f64, N>,
    G: Force<f64, N>,
    P: Retraction<f64, N, D>,
{
    /// At h = 0, where H_i = η.
    fn new(
        system: &'a System<f64, N, D, R, L, F>,
        method: &'a mut Variational<f64, N, D, Q, G, P>,
        step: f64,
        eta: &Vector<f64, N>,
    ) -> Self {
        let s = system.tableau.stages();
        Self { system, method, step, rates: vec![*eta; s], residual: vec![Covector::zeros(); s] }
    }

    /// Ξ_i = h Σ a_ij H_j at the whole step.
    fn displacements(&self) -> Vec<f64> {
        let a = self.system.tableau.a();
        let stage = |i: usize| {
            let sum = self.rates.iter().enumerate().fold(Vector::zeros(), |sum, (j, rate)| sum + rate * a[(i, j)]);
            (sum * self.step).iter().copied().collect::<Vec<_>>()
        };
        (0..self.rates.len()).flat_map(stage).collect()
    }

    fn jacobian(&mut self, fraction: f64) -> Result<DMatrix<f64>, StepError> {
        self.method.stage_jacobian(&self.system.state, self.step * fraction, &self.rates)
    }

    /// r at a share of the step, as a column.
    fn residual(&mut self, fraction: f64) -> Result<DMatrix<f64>, StepError> {
        self.method.residual(&self.system.state, self.step * fraction, &self.rates, &mut self.residual)?;
        Ok(DMatrix::from_fn(self.residual.len() * N, 1, |k, _| self.residual[k / N][k % N]))
    }

    /// Newton's method at a share of the step, to a correction of rounding: det J < 0, and the first correction. With `limit` the first
    /// correction is at most that, and each is at most a quarter of the one before.
    fn newton(&mut self, fraction: f64, limit: Option<f64>) -> Result<(bool, f64), Lost> {
        let (mut first, mut last) = (None, None);
        for _ in 0..ITERATIONS {
            let right = self.residual(fraction)?;
            let lu = self.jacobian(fraction)?.lu();
            let correction = lu.solve(&right).ok_or(Lost)?;
            let moved = correction.amax();
            if !moved.is_finite() {
                return Err(Lost);
            }
            let size = self.rates.iter().fold(0.0_f64, |size, rate| size.max(rate.amax()));
            let rounding = size * ROUNDING;
            let beyond = |limit: f64| moved > limit && moved > rounding;
            if limit.is_some_and(|limit| first.is_none() && beyond(limit))
                || (limit.is_some() && last.is_some_and(|last: f64| beyond(last * 0.25)))
            {
                return Err(Lost);
            }
            for (k, d) in correction.iter().enumerate() {
                self.rates[k / N][k % N] -= *d;
            }
            let first = *first.get_or_insert(moved);
            if moved <= rounding {
                return Ok((lu.determinant() < 0.0, first));
            }
            last = Some(moved);
        }
        Err(Lost)
    }

    /// dH/ds at a root, s the share of the step: −J⁻¹ ∂r/∂s, by a central difference.
    fn tangent(&mut self, fraction: f64) -> Result<DMatrix<f64>, Lost> {
        let away = f64::EPSILON.cbrt();
        let (ahead, behind) = (self.residual(fraction + away)?, self.residual(fraction - away)?);
        let lu = self.jacobian(fraction)?.lu();
        lu.solve(&((behind - ahead) / (away + away))).filter(|t| t.iter().all(|v| v.is_finite())).ok_or(Lost)
    }

    /// To the whole step, by small increments: the tangent predicts, and turns little from one point to the next.
    fn follow(&mut self) -> End {
        let Ok(mut tangent) = self.tangent(0.0) else { return End::Lost };
        let Ok((sign, _)) = self.newton(0.0, None) else { return End::Lost };
        let (mut reached, mut increment) = (0.0, INCREMENTS.0);
        for _ in 0..POINTS {
            let target = (reached + increment).min(1.0);
            let start = self.rates.clone();
            let ahead = &tangent * (target - reached);
            for (k, d) in ahead.iter().enumerate() {
                self.rates[k / N][k % N] += *d;
            }
            let size = start.iter().fold(0.0_f64, |size, rate| size.max(rate.amax()));
            let chord = ahead.amax() + size * 1e-6;
            let next = self.newton(target, Some(chord * NEAR)).and_then(|(negative, first)| {
                let turned = self.tangent(target)?;
                let same = negative == sign && (&turned - &tangent).amax() * 2.0 <= tangent.amax().max(turned.amax());
                same.then_some((turned, first)).ok_or(Lost)
            });
            match next {
                Ok((turned, first)) => {
                    tangent = turned;
                    reached = target;
                    if reached >= 1.0 {
                        return End::Reached;
                    }
                    if first <= chord * NEAR * NEAR {
                        increment += increment;
                    }
                }
                Err(Lost) => {
                    self.rates = start;
                    increment *= 0.5;
                    if increment < INCREMENTS.1 {
                        return End::Fold(reached);
                    }
                }
            }
        }
        End::Lost
    }
}

/// No root near the prediction.
struct Lost;

impl From<StepError> for Lost {
    fn from(_: StepError) -> Self {
        Self
    }
}
