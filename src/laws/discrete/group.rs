//! Laws of discrete Lagrangians on G itself, without force.

use super::super::CaseLaw;
use super::super::planted::blend;
use super::super::precision::Measured;
use super::super::probe::{Probe, stream};
use super::super::question::{Answer, Problem, Question, law, singular};
use super::super::sizes::poisson;
use crate::algebra::{Covector, Matrix, basis_vector, elimination, pair};
use crate::discrete::group::{GroupLagrangian, Sampled, euler_poincare, legendre, lie_poisson};
use crate::group::{LieGroup, MatrixGroup};
use crate::harness::{Cost, Fault};
use crate::integrators::{OneStep, Variational};
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::dual::moving;
use crate::scalar::{Dual, Real, Scalar, max_abs};
use crate::tableau::Tableau;

const LEFT: Fault = Fault::new("group-minus-left", "F⁻l_d(W) = L*_W l_d'", "non-abelian groups");
const INVERTED: Fault = Fault::new("lie-poisson-inverse", "μ₂ = Ad*_{W₁⁻¹} μ₁", "non-abelian groups");

/// The laws of this file.
pub static LAWS: &[CaseLaw] = &[
    law!(Law {
        name: "discrete-euler-poincare",
        statement: "the derivative of l_d(W₁) + l_d(W₂) at W₁W₂ fixed is ⟨L*_{W₁}l_d' − R*_{W₂}l_d', ζ⟩",
        source: "Martín de Diego and Sato Martín de Almagro 2019, Def 2.1 and (2.10)",
        oracle: "the sum on dual numbers along (W₁(1 + εζ̂), (1 − εζ̂)W₂), at points that are not solutions",
        bound: both("floor 2⁵ N D u of the slopes"),
        needs: "a group; an algebra that is not abelian",
        faults: &[LEFT],
        cases: |cases| cases.main_dimensions().with_group().nonabelian(),
        asks: Variation,
    }),
    law!(Law {
        name: "discrete-lie-poisson",
        statement: "l_d(W) = h l(τ⁻¹(W)/h): F⁻(W₁) = μ₁ ↦ μ₂ = Ad*_{W₁}μ₁ = F⁺(W₁) is the free step of one stage, a = 0",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §2.3, after (2.10)",
        oracle: "the variational integrator with that tableau, from its stage equations",
        bound: small(3, "floor 2⁸ N D u, of momenta that rounding of W moves by p u/|w|"),
        needs: "a group; no force; an algebra that is not abelian",
        cost: Cost::Moderate,
        faults: &[LEFT, INVERTED],
        cases: |cases| cases.main_dimensions().with_group().force_free().nonabelian(),
        asks: Step,
    }),
    law!(Law {
        name: "discrete-lie-poisson-map",
        statement: "μ₁ ↦ μ₂ = Ad*_{W₁}μ₁, μ₁ = F⁻l_d(W₁), preserves the Lie–Poisson bracket: J Π(μ₁) Jᵀ = Π(μ₂)",
        source: "Martín de Diego and Sato Martín de Almagro 2019, §2.3 and §2.2",
        oracle: "J = ∂μ₂/∂W₁ (∂μ₁/∂W₁)⁻¹ on nested duals, Π from the structure constants; l_d a random polynomial",
        bound: small(12, "floor 2⁶ N D u of the terms of J Π Jᵀ times the condition of ∂μ₁/∂W₁"),
        needs: "a group; an algebra that is not abelian",
        faults: &[LEFT, INVERTED],
        cases: |cases| cases.main_dimensions().with_group().nonabelian(),
        asks: PoissonMap,
    }),
];

/// l_d(W) = ‖W − 1‖²/(2h) + f(W) g(W), with affine functions of the entries.
struct MatrixPolynomial<T: Real, const D: usize> {
    step: T,
    terms: [Matrix<T, D>; 2],
}

impl<T: Real, const D: usize> MatrixPolynomial<T, D> {
    fn random(probe: &mut Probe) -> Self {
        let mut matrix = || Matrix::<T, D>::from_fn(|_, _| probe.unit::<T>() * T::exact(0.125));
        Self { step: T::exact(2f64.powi(-4)), terms: [matrix(), matrix()] }
    }
}

impl<T: Real, const D: usize> GroupLagrangian<T, D> for MatrixPolynomial<T, D> {
    fn value<S: Scalar<Base = T>>(&self, w: &Matrix<S, D>) -> Result<S, RetractionError> {
        let square = (w - Matrix::<S, D>::identity()).iter().fold(S::zero(), |sum, v| sum + *v * *v);
        let affine = |c: &Matrix<T, D>| c.iter().zip(w.iter()).fold(S::one(), |sum, (c, v)| sum + S::lift(*c) * *v);
        Ok(square * (S::half() / S::lift(self.step)) + affine(&self.terms[0]) * affine(&self.terms[1]))
    }
}

/// (F⁺, F⁻), with the fault planted.
fn tested<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    l_d: &impl GroupLagrangian<T, D>,
    group: &MatrixGroup<T, N, D>,
    w: &Matrix<S, D>,
    fault: Option<&Fault>,
) -> Result<(Covector<S, N>, Covector<S, N>), Measured> {
    let (plus, minus) = legendre(l_d, group, w)?;
    Ok((plus, blend(minus, plus, LEFT.size_in(fault))))
}

/// Ad*_W μ, or what the fault makes of it.
fn carried<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    group: &MatrixGroup<T, N, D>,
    w: &Matrix<S, D>,
    mu: &Covector<S, N>,
    right: Covector<S, N>,
    fault: Option<&Fault>,
) -> Result<Covector<S, N>, Measured> {
    let size = INVERTED.size_in(fault);
    if size == 0.0 {
        return Ok(right);
    }
    let wrong = group.inverse(w).and_then(|back| group.coadjoint(&back, mu));
    Ok(blend(right, wrong.ok_or_else(singular)?, size))
}

#[derive(Clone, Copy)]
struct Variation;

impl Question for Variation {
    const STREAM: Option<u64> = Some(stream::VARIATION_ON_GROUP);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let (system, group, fault, probe) = (problem.system, problem.group()?, problem.fault, &mut problem.probe);
        let mut element = || system.retraction.tau(&(probe.vector::<T, N>() * T::exact(0.125)));
        let (first, second) = (element()?, element()?);
        let zeta = probe.vector::<T, N>();
        let l_d = MatrixPolynomial::random(probe);
        let hat = group.hat(&zeta);
        let along = |g: &Matrix<T, D>, direction: Matrix<T, D>| moving(g, &direction);
        let value = |w: Matrix<Dual<T>, D>| l_d.value(&w);
        let expected = (value(along(&first, first * hat))? + value(along(&second, -hat * second))?).eps;
        let right = euler_poincare(&l_d, group, &first, &second)?;
        let (plus, _) = legendre(&l_d, group, &first)?;
        let (wrong, minus) = legendre(&l_d, group, &second)?;
        let found = pair(&blend(right, plus - wrong, LEFT.size_in(fault)), &zeta);
        let size = plus.amax().max(minus.amax());
        Ok(Measured::defect((found - expected).abs(), size, 32.0 * system.products() as f64, || {
            format!("⟨residual, ζ⟩ = {:.17e}, δ sum = {:.17e}", found.to_f64(), expected.to_f64())
        }))
    }
}

#[derive(Clone, Copy)]
struct Step;

impl Question for Step {
    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let (system, group, fault) = (problem.system, problem.group()?, problem.fault);
        let tau = &system.retraction;
        let one = Tableau::new(&[vec![T::zero()]], &[T::one()]).map_err(|e| Measured::Broken(e.to_string()))?;
        let mut start = system.state.clone();
        start.attitude = Matrix::identity();
        let mut end = start.clone();
        let mut method = Variational::new(&system.lagrangian, &system.force, tau, one);
        method.step(&mut end, system.step)?;
        let (mu, w) = (start.momentum, end.attitude);
        let l_d = Sampled { lagrangian: &system.lagrangian, retraction: tau, step: system.step };
        let (plus, minus) = tested(&l_d, group, &w, fault)?;
        let x = tau.tau_inv(&w)?;
        // From a displacement that is not yet the right one.
        let guess = tau.tau(&(x * T::exact(0.875)))?;
        let (next, found) = lie_poisson(&l_d, group, tau, &mu, &guess)?;
        let next = carried(group, &w, &mu, next, fault)?;
        let floor = 256.0 * system.products() as f64;
        let size = mu.amax().max(end.momentum.amax()) / x.amax().min(T::one());
        let near = |what: &'static str, mine: &Covector<T, N>, theirs: &Covector<T, N>| {
            Measured::defect(max_abs(&(mine - theirs)), size, floor, || what.into())
        };
        let displacement = Measured::defect(max_abs(&(found - w)), w.amax().max(T::one()), floor, || "W₁".into());
        Ok(near("F⁻(W₁)", &minus, &mu)
            .and(near("F⁺(W₁)", &plus, &end.momentum))
            .and(near("μ₂", &next, &end.momentum))
            .and(displacement))
    }
}

#[derive(Clone, Copy)]
struct PoissonMap;

impl Question for PoissonMap {
    const STREAM: Option<u64> = Some(stream::POISSON_ON_GROUP);

    fn measure<T: Real, const N: usize, const D: usize>(self, mut problem: Problem<'_, T, N, D>) -> Answer {
        let (system, group, fault, probe) = (problem.system, problem.group()?, problem.fault, &mut problem.probe);
        let w = system.retraction.tau(&(probe.vector::<T, N>() * T::exact(0.125)))?;
        let l_d = MatrixPolynomial::random(probe);
        let (mut before, mut after) = (Matrix::<T, N>::zeros(), Matrix::<T, N>::zeros());
        let (mut mu, mut image) = (Covector::<T, N>::zeros(), Covector::<T, N>::zeros());
        for a in 0..N {
            let moved = moving(&w, &(w * group.hat(&basis_vector::<T, N>(a))));
            let (_, minus) = tested(&l_d, group, &moved, fault)?;
            let right = group.coadjoint(&moved, &minus).ok_or_else(singular)?;
            let next = carried(group, &moved, &minus, right, fault)?;
            before.set_column(a, &minus.map(|v| v.eps).transpose());
            after.set_column(a, &next.map(|v| v.eps).transpose());
            (mu, image) = (minus.map(|v| v.re), next.map(|v| v.re));
        }
        let inverse = elimination::inverse(&before)
            .ok_or(Measured::Inconclusive("the discrete Lagrangian is not regular".into()))?;
        let jacobian = after * inverse;
        let poisson = |mu: &Covector<T, N>| poisson(&system.algebra, mu).0;
        let defect = jacobian * poisson(&mu) * jacobian.transpose() - poisson(&image);
        let terms = |mu: &Covector<T, N>| system.algebra.size() * mu.amax();
        let condition = before.amax() * inverse.amax();
        let stretch = jacobian.amax().max(T::one());
        let size = stretch * stretch * terms(&mu).max(terms(&image)) * condition;
        Ok(Measured::defect(defect.amax(), size, 64.0 * system.products() as f64, || {
            format!("|J Π Jᵀ − Π(μ₂)| = {:.3e}", defect.amax().to_f64())
        }))
    }
}
