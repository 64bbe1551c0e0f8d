//! Laws of retractions: τ, its inverse and its tangents, at displacements from 2⁻³⁰ to about 4.
//!
//! The oracle of every tangent is the derivative of τ (or of the tangent below it) on dual numbers.

use super::CaseLaw;
use super::precision::{Measured, settle};
use super::probe::Probe;
use crate::algebra::{Matrix, Vector};
use crate::group::LieGroup;
use crate::harness::{Cost, Fault};
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::dual::derivative;
use crate::scalar::{Real, Scalar};
use crate::system::{Case, System, Visitor, cases};
use proptest::strategy::Strategy;

const SOURCE: &str = "Martín de Diego and Sato Martín de Almagro 2019, §5.2";
const DUALS: &str = "the derivative on dual numbers";
const BOUND: &str = "two precisions; floor 64 N u, the operations of an N×N product with safety 64/N";

/// The laws of this file.
pub const LAWS: &[CaseLaw] = &[
    CaseLaw {
        name: "retraction-inverse",
        statement: "τ(−ξ) τ(ξ) = e",
        source: SOURCE,
        oracle: "the matrix product",
        bound: BOUND,
        cost: Cost::Cheap,
        faults: &[Fault::new(
            "shifted-argument",
            "τ(ξ) replaced by τ(ξ + ½|ξ|² e_1): still a retraction, but τ(−ξ) ≠ τ(ξ)⁻¹",
            "every group",
        )],
        cases: || cases().with_group().boxed(),
        check: |case, fault| settle(case, Check { case, fault, which: Which::Inverse }),
    },
    CaseLaw {
        name: "retraction-logarithm",
        statement: "τ⁻¹(τ(ξ)) = ξ for |ξ| ≤ 1",
        source: SOURCE,
        oracle: "composition of two separate algorithms",
        bound: BOUND,
        cost: Cost::Cheap,
        faults: &[Fault::new(
            "first-order-inverse",
            "τ⁻¹(g) replaced by (½(g − g⁻¹))^∨",
            "groups whose algebra is not two-step nilpotent in the representation",
        )],
        cases: || cases().with_group().boxed(),
        check: |case, fault| settle(case, Check { case, fault, which: Which::Logarithm }),
    },
    CaseLaw {
        name: "retraction-tangent",
        statement: "T_ξ τ(δ) = τ(ξ) dτ_ξ δ",
        source: SOURCE,
        oracle: DUALS,
        bound: BOUND,
        cost: Cost::Cheap,
        faults: &[Fault::new(
            "right-trivialised",
            "dτ_ξ replaced by dτ_{−ξ}, the right-trivialised tangent",
            "non-abelian algebras",
        )],
        cases: || cases().with_group().boxed(),
        check: |case, fault| settle(case, Check { case, fault, which: Which::Tangent }),
    },
    CaseLaw {
        name: "retraction-inverse-tangent",
        statement: "dτ_ξ⁻¹ dτ_ξ = 1",
        source: SOURCE,
        oracle: "the matrix product",
        bound: BOUND,
        cost: Cost::Cheap,
        faults: &[Fault::new(
            "truncated-bernoulli",
            "dτ⁻¹ replaced by 1 + ½ ad + ad²/12, the Bernoulli series of exp cut after B₂",
            "algebras that are not three-step nilpotent",
        )],
        cases: || cases().boxed(),
        check: |case, fault| settle(case, Check { case, fault, which: Which::InverseTangent }),
    },
    CaseLaw {
        name: "retraction-second-tangent",
        statement: "∂_ξ(dτ_ξ η) δ = dτ_ξ ddτ_ξ(η, δ), and p ddτ_ξ(η, ·) agrees with its adjoint form",
        source: SOURCE,
        oracle: DUALS,
        bound: BOUND,
        cost: Cost::Cheap,
        faults: &[
            Fault::new("missing", "ddτ replaced by 0", "non-abelian algebras"),
            Fault::new("sign", "ddτ replaced by −ddτ", "non-abelian algebras"),
            Fault::new("swapped", "ddτ(η, δ) replaced by ddτ(δ, η)", "non-abelian algebras"),
            Fault::new(
                "of-the-inverse",
                "the second tangent of τ⁻¹ in its place (erratum to §5.2)",
                "non-abelian algebras",
            ),
        ],
        cases: || cases().boxed(),
        check: |case, fault| settle(case, Check { case, fault, which: Which::SecondTangent }),
    },
    CaseLaw {
        name: "retraction-adjoint",
        statement: "Ad_{τ(ξ)} = dτ_{−ξ} dτ_ξ⁻¹, Ad_{τ(ξ)}⁻¹ = dτ_ξ dτ_{−ξ}⁻¹",
        source: SOURCE,
        oracle: "conjugation of the basis by the matrix τ(ξ)",
        bound: BOUND,
        cost: Cost::Cheap,
        faults: &[Fault::new("inverted", "Ad_{τ(ξ)} and its inverse exchanged", "non-abelian algebras")],
        cases: || cases().with_group().boxed(),
        check: |case, fault| settle(case, Check { case, fault, which: Which::Adjoint }),
    },
];

#[derive(Clone, Copy)]
enum Which {
    Inverse,
    Logarithm,
    Tangent,
    InverseTangent,
    SecondTangent,
    Adjoint,
}

#[derive(Clone, Copy)]
struct Check<'a> {
    case: &'a Case,
    fault: Option<&'a Fault>,
    which: Which,
}

impl<T: Real> Visitor<T> for Check<'_> {
    type Output = Measured;

    fn visit<const N: usize, const D: usize, R: Retraction<T, N, D>>(self, system: System<T, N, D, R>) -> Measured {
        let mut probe = Probe::new(self.case, 1);
        let subject = Subject { system: &system, fault: self.fault };
        let size = probe.power_of_two::<T>(-30, if matches!(self.which, Which::Logarithm) { -3 } else { 2 });
        let x = probe.vector::<T, N>() * size;
        let (y, delta) = (probe.vector::<T, N>(), probe.vector::<T, N>());
        let measured = match self.which {
            Which::Inverse => subject.inverse(&x),
            Which::Logarithm => subject.logarithm(&x),
            Which::Tangent => subject.tangent(&x, &delta),
            Which::InverseTangent => subject.inverse_tangent(&x),
            Which::SecondTangent => subject.second_tangent(&x, &y, &delta),
            Which::Adjoint => subject.adjoint(&x),
        };
        measured.unwrap_or_else(|error| match error {
            RetractionError::NoGroup { .. } => Measured::NotApplicable("the algebra has no group".into()),
            RetractionError::NotFinite { .. } => Measured::Broken(error.to_string()),
            _ => Measured::NotApplicable("the displacement is outside the domain".into()),
        })
    }
}

struct Subject<'a, T: Real, const N: usize, const D: usize, R> {
    system: &'a System<T, N, D, R>,
    fault: Option<&'a Fault>,
}

impl<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>> Subject<'_, T, N, D, R> {
    fn planted(&self, name: &str) -> bool {
        Fault::planted(self.fault, name)
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        let mut x = *x;
        if self.planted("shifted-argument") {
            let shift = x.dot(&x) * S::half();
            x[0] += shift;
        }
        self.system.retraction.tau(&x)
    }

    fn inverse(&self, x: &Vector<T, N>) -> Result<Measured, RetractionError> {
        let (plus, minus) = (self.tau(x)?, self.tau(&-x)?);
        Ok(near(&(minus * plus), &Matrix::identity(), minus.amax() * plus.amax(), x))
    }

    fn logarithm(&self, x: &Vector<T, N>) -> Result<Measured, RetractionError> {
        let g = self.tau(x)?;
        let Some(group) = &self.system.group else {
            return Err(RetractionError::NoGroup { retraction: "law" });
        };
        let back = if self.planted("first-order-inverse") {
            let inverse = group.inverse(&g).ok_or(RetractionError::NoGroup { retraction: "law" })?;
            group.vee(&((g - inverse) * T::half()))
        } else {
            self.system.retraction.tau_inv(&g)?
        };
        // g − 1 carries an absolute error u; x is recovered to u relative to 1, not to |x|.
        Ok(near(&back, x, x.amax().max(T::one()), x))
    }

    fn tangent(&self, x: &Vector<T, N>, delta: &Vector<T, N>) -> Result<Measured, RetractionError> {
        let Some(group) = &self.system.group else {
            return Err(RetractionError::NoGroup { retraction: "law" });
        };
        let point = self.system.retraction.at(x)?;
        let d = if self.planted("right-trivialised") { point.d_neg() } else { *point.d() };
        let oracle = derivative(|x| self.tau(x), x, delta)?;
        let g = self.tau(x)?;
        let velocity = d * delta;
        let size = g.amax() * group.hat(&velocity).amax() + oracle.amax();
        Ok(near(&(g * group.hat(&velocity)), &oracle, size, x))
    }

    fn inverse_tangent(&self, x: &Vector<T, N>) -> Result<Measured, RetractionError> {
        let point = self.system.retraction.at(x)?;
        let inverse = if self.planted("truncated-bernoulli") {
            let ad = self.system.algebra.ad(x);
            Matrix::identity() + ad * T::half() + ad * ad * T::ratio(1, 12)
        } else {
            *point.d_inv()
        };
        let product = inverse * point.d();
        Ok(near(&product, &Matrix::identity(), inverse.amax() * point.d().amax(), x))
    }

    fn second_tangent(
        &self,
        x: &Vector<T, N>,
        y: &Vector<T, N>,
        delta: &Vector<T, N>,
    ) -> Result<Measured, RetractionError> {
        let point = self.system.retraction.at(x)?;
        let column = match self.fault.map(|f| f.name) {
            Some("missing") => Vector::zeros(),
            Some("sign") => -(point.dd(y) * delta),
            Some("swapped") => point.dd(delta) * y,
            Some("of-the-inverse") => -(point.d() * point.dd(&(point.d_inv() * y)) * delta),
            _ => point.dd(y) * delta,
        };
        let oracle = derivative(
            |x| Ok::<_, RetractionError>(self.system.retraction.at(x)?.d() * y.map(crate::scalar::Dual::constant)),
            x,
            delta,
        )?;
        // The tangent at 0 is 1; its derivative is of the size of the bracket, however small x is.
        let size = point.d().amax() * (point.dd(y).amax() + self.system.algebra.ad(y).amax());
        let forward = near(&(point.d() * column), &oracle, size, x);
        let m = y.transpose();
        let p = m * point.d();
        let adjoint = near(&point.pull_dd(&p, &m, y), &(p * point.dd(y)), p.amax() * point.dd(y).amax() + size, x);
        Ok(forward.and(adjoint))
    }

    fn adjoint(&self, x: &Vector<T, N>) -> Result<Measured, RetractionError> {
        let Some(group) = &self.system.group else {
            return Err(RetractionError::NoGroup { retraction: "law" });
        };
        let point = self.system.retraction.at(x)?;
        let (g, back) = (self.tau(x)?, self.tau(&-x)?);
        let (Some(ad), Some(ad_inv)) = (group.adjoint(&g), group.adjoint(&back)) else {
            return Ok(Measured::Broken("τ(ξ) is a singular matrix".into()));
        };
        let (mine, mine_inv) =
            if self.planted("inverted") { (point.ad_inv(), point.ad()) } else { (point.ad(), point.ad_inv()) };
        let size = g.amax() * back.amax();
        Ok(near(&mine, &ad, size.max(ad.amax()), x).and(near(&mine_inv, &ad_inv, size.max(ad_inv.amax()), x)))
    }
}

/// |lhs − rhs| relative to `size`, as a measurement at x.
fn near<T: Real, const N: usize, const A: usize, const B: usize>(
    lhs: &nalgebra::SMatrix<T, A, B>,
    rhs: &nalgebra::SMatrix<T, A, B>,
    size: T,
    x: &Vector<T, N>,
) -> Measured {
    let defect = (lhs - rhs).iter().fold(T::zero(), |m, v| if v.abs() > m || !v.all_finite() { v.abs() } else { m });
    Measured::defect(defect, size, 64.0 * N as f64, || {
        let x: Vec<String> = x.iter().map(|v| format!("{:e}", v.to_f64())).collect();
        format!("at ξ = ({})", x.join(", "))
    })
}
