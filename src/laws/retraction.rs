//! Laws of retractions: τ, its inverse and its tangents, at displacements from 2⁻³⁰ to about 4.
//!
//! The oracle of every tangent is the derivative of τ (or of the tangent below it) on dual numbers.

use super::planted::retraction::{
    ADJOINT_INVERTED, BERNOULLI, CUT_INVERSE, CUT_SERIES, INVERSE_MISSING, LATE_SERIES, LATER_SERIES, LOG_NEAR_PI,
    RIGHT_TANGENT, SECOND_MISSING, SECOND_OF_INVERSE, SECOND_SIGN, SECOND_SWAPPED, SHIFTED, spectral_radius,
};
use super::probe::{Probe, stream};
use super::question::{Answer, Measured, Problem, Question, law};
use super::{CaseLaw, Source};
use crate::algebra::{Matrix, Vector};
use crate::group::{LieGroup, MatrixGroup};
use crate::retraction::{AnyPoint, Retraction, RetractionError, TangentPoint};
use crate::scalar::dual::derivative;
use crate::scalar::{Real, Scalar, max_abs};
use crate::system::System;
use std::fmt::Debug;

const DUALS: &str = "the derivative on dual numbers";
const SOURCE: &str = "Martín de Diego and Sato Martín de Almagro 2019, §5.2";

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "retraction-inverse",
                statement: "τ(−ξ) τ(ξ) = e",
                source: SOURCE,
                oracle: "the matrix product",
                bound: both("floor 64 N u, the operations of an N×N product with safety 64/N"),
                needs: "a group",
                faults: &[SHIFTED],
                cases: |cases| cases.with_group(),
                asks: Which::Inverse,
            }),
            law!(Law {
                name: "retraction-logarithm",
                statement: "τ⁻¹(τ(ξ)) = ξ for |ξ| ≤ 1/8, and τ(τ⁻¹(g)) = g for g = τ(ξ), |ξ| ≤ 4, in half of the cases as close as 2⁻¹⁸ \
                to the half turn",
                source: SOURCE,
                oracle: "composition of two separate algorithms",
                bound: both(
                    "floor 64 N u, far from e times |dτ| |dτ⁻¹| |g| |g⁻¹|, by which rounding of g is multiplied"
                ),
                needs: "a group",
                faults: &[CUT_INVERSE, LOG_NEAR_PI],
                cases: |cases| cases.with_group(),
                asks: Which::Logarithm,
            }),
            law!(Law {
                name: "retraction-tangent",
                statement: "T_ξ τ(δ) = τ(ξ) dτ_ξ δ",
                source: SOURCE,
                oracle: DUALS,
                bound: both("floor 64 N u, the operations of an N×N product with safety 64/N"),
                needs: "a group",
                faults: &[SHIFTED, RIGHT_TANGENT, LATER_SERIES, CUT_SERIES],
                cases: |cases| cases.with_group(),
                asks: Which::Tangent,
            }),
            law!(Law {
                name: "retraction-inverse-tangent",
                statement: "dτ_ξ⁻¹ dτ_ξ = 1",
                source: SOURCE,
                oracle: "the matrix product",
                bound: both("floor 64 N u, the operations of an N×N product with safety 64/N"),
                needs: "",
                faults: &[RIGHT_TANGENT, BERNOULLI, INVERSE_MISSING, CUT_SERIES],
                cases: |cases| cases,
                asks: Which::InverseTangent,
            }),
            law!(Law {
                name: "retraction-second-tangent",
                statement: "∂_ξ(dτ_ξ η) δ = dτ_ξ ddτ_ξ(η, δ), and p ddτ_ξ(η, ·) agrees with its adjoint form",
                source: SOURCE,
                oracle: DUALS,
                bound: both(
                    "floor 64 N u, the operations of an N×N product with safety 64/N; of |dτ| |dτ⁻¹| |∂(dτ)|, since ddτ = dτ⁻¹ ∂(dτ)"
                ),
                needs: "",
                faults: &[
                    SECOND_MISSING,
                    SECOND_SIGN,
                    SECOND_SWAPPED,
                    SECOND_OF_INVERSE,
                    LATE_SERIES,
                    LATER_SERIES,
                    CUT_SERIES
                ],
                cases: |cases| cases,
                asks: Which::SecondTangent,
            }),
            law!(Law {
                name: "retraction-adjoint",
                statement: "Ad_{τ(ξ)} = dτ_{−ξ} dτ_ξ⁻¹, Ad_{τ(ξ)}⁻¹ = dτ_ξ dτ_{−ξ}⁻¹",
                source: SOURCE,
                oracle: "conjugation of the basis by the matrix τ(ξ)",
                bound: both("floor 64 N u, the operations of an N×N product with safety 64/N"),
                needs: "a group",
                faults: &[SHIFTED, ADJOINT_INVERTED],
                cases: |cases| cases.with_group(),
                asks: Which::Adjoint,
            }),
        ]
    }
}

#[derive(Clone, Copy)]
enum Which {
    Inverse,
    Logarithm,
    Tangent,
    InverseTangent,
    SecondTangent,
    Adjoint,
}

impl Question for Which {
    const STREAM: Option<u64> = Some(stream::RETRACTION);

    const LARGE: bool = true;

    const KNOWS_CONFIGURATION: bool = true;

    fn measure<T: Real, const N: usize, const D: usize>(self, problem: Problem<'_, T, N, D>) -> Answer {
        let Problem { system, case, mut probe, .. } = problem;
        let subject = TestedRetraction { system };
        let size = probe.power_of_two::<f64>(-30, 2);
        let mut x = probe.dense::<T, N>(size);
        let (y, delta) = (probe.vector::<T, N>(), probe.vector::<T, N>());
        if T::unit_roundoff() < T::exact(2f64.powi(-80)) {
            // Digits beyond those of f64: products of two numbers that have none are exact in 32 digits, and show no rounding.
            let beyond = Probe::new(case, stream::BEYOND_DOUBLE).dense::<T, N>(1.0);
            x += x.component_mul(&beyond) * T::exact(2f64.powi(-54));
        }
        let measured = match self {
            Self::Inverse => subject.inverse(&x),
            Self::Logarithm => subject.logarithm(&x, case),
            Self::Tangent => subject.tangent(&x, &delta),
            Self::InverseTangent => subject.inverse_tangent(&x),
            Self::SecondTangent => subject.second_tangent(&x, &y, &delta),
            Self::Adjoint => subject.adjoint(&x),
        };
        measured.map_err(|error| match error {
            RetractionError::NoGroup { .. } => Measured::NotApplicable("the algebra has no group".into()),
            RetractionError::NotFinite { .. } => Measured::Broken(error.to_string()),
            _ => Measured::NotApplicable("the displacement is outside the domain".into()),
        })
    }
}

struct TestedRetraction<'a, T: Real, const N: usize, const D: usize> {
    system: &'a System<T, N, D>,
}

impl<T: Real, const N: usize, const D: usize> TestedRetraction<'_, T, N, D> {
    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        self.system.retraction.tau(x)
    }

    fn group(&self) -> Result<&MatrixGroup<T, N, D>, RetractionError> {
        self.system.group.as_ref().ok_or(RetractionError::NoGroup { retraction: "law" })
    }

    /// |lhs − rhs| relative to `size`, as a measurement at the coordinates of x that are the case's.
    fn near<const A: usize, const B: usize>(
        &self,
        lhs: &nalgebra::SMatrix<T, A, B>,
        rhs: &nalgebra::SMatrix<T, A, B>,
        size: T,
        x: &Vector<T, N>,
    ) -> Measured {
        at_most((lhs - rhs).as_slice(), size, &x.as_slice()[..self.system.dimension])
    }

    fn inverse(&self, x: &Vector<T, N>) -> Result<Measured, RetractionError> {
        let (plus, minus) = (self.tau(x)?, self.tau(&-x)?);
        Ok(self.near(&(minus * plus), &Matrix::identity(), minus.amax() * plus.amax(), x))
    }

    fn logarithm(&self, x: &Vector<T, N>, case: &dyn Debug) -> Result<Measured, RetractionError> {
        let group = self.group()?;
        let tau = &self.system.retraction;
        let small = x * T::exact(SMALL);
        let found = tau.tau_inv(&self.tau(&small)?)?;
        // g − 1 carries an absolute error u; ξ is recovered to u relative to 1, not to |ξ|.
        let inverse = self.near(&found, &small, small.amax().max(T::one()), &small);
        // Far from e, τ⁻¹ may be that of another sheet; τ takes it back to g all the same.
        let x = x * within_half_turn(group, x, case);
        let (g, back) = (self.tau(&x)?, self.tau(&-x)?);
        let Ok(found) = tau.tau_inv(&g) else { return Ok(inverse) };
        let point = tau.at(&found)?;
        // Rounding of g by u moves ξ by |dτ⁻¹| |g⁻¹| |g| u, and that moves τ(ξ) by |g| |dτ| as much.
        let moved = point.d().amax() * point.d_inv().amax() * g.amax() * back.amax();
        Ok(inverse.and(self.near(&self.tau(&found)?, &g, g.amax() * moved.max(T::one()), &x)))
    }

    fn tangent(&self, x: &Vector<T, N>, delta: &Vector<T, N>) -> Result<Measured, RetractionError> {
        let group = self.group()?;
        let point = self.system.retraction.at(x)?;
        let d = point.d();
        let oracle = derivative(|x| self.tau(x), x, delta)?;
        let g = self.tau(x)?;
        let velocity = d * delta;
        let size = g.amax() * group.hat(&velocity).amax() + oracle.amax();
        Ok(self.near(&(g * group.hat(&velocity)), &oracle, size, x))
    }

    fn inverse_tangent(&self, x: &Vector<T, N>) -> Result<Measured, RetractionError> {
        let point = self.system.retraction.at(x)?;
        let inverse = point.d_inv();
        let product = inverse * point.d();
        Ok(self.near(&product, &Matrix::identity(), inverse.amax() * point.d().amax(), x))
    }

    fn second_tangent(
        &self,
        x: &Vector<T, N>,
        y: &Vector<T, N>,
        delta: &Vector<T, N>,
    ) -> Result<Measured, RetractionError> {
        let point = self.system.retraction.at(x)?;
        let column = point.dd(y) * delta;
        let oracle = derivative(
            |x| Ok::<_, RetractionError>(self.system.retraction.at(x)?.d() * y.map(crate::scalar::Dual::constant)),
            x,
            delta,
        )?;
        // ddτ = dτ⁻¹ ∂(dτ): rounding of the derivative is multiplied by dτ⁻¹. The tangent at 0 is 1; its derivative is of the size of the
        // bracket, however small x is.
        let dd = point.dd(y);
        let solved = point.d_inv().amax() * (point.d() * dd).amax();
        let size = point.d().amax() * (dd.amax().max(solved) + self.system.algebra.ad(y).amax());
        let forward = self.near(&(point.d() * column), &oracle, size, x);
        let m = y.transpose();
        let p = m * point.d();
        let adjoint = self.near(&point.pull_dd(&p, &m, y), &(p * dd), p.amax() * dd.amax() + size, x);
        Ok(forward.and(adjoint))
    }

    fn adjoint(&self, x: &Vector<T, N>) -> Result<Measured, RetractionError> {
        let group = self.group()?;
        let point = self.system.retraction.at(x)?;
        let (g, back) = (self.tau(x)?, self.tau(&-x)?);
        let (Some(ad), Some(ad_inv)) = (group.adjoint(&g), group.adjoint(&back)) else {
            return Ok(Measured::Broken("τ(ξ) is a singular matrix".into()));
        };
        let (mine, mine_inv) = (point.ad(), point.ad_inv());
        let size = g.amax() * back.amax();
        // Of the two factors one is solved from the other: rounding is multiplied by its condition. It is large close to where dτ ends.
        let other = self.system.retraction.at(&-x)?;
        let solved = |one: &AnyPoint<T, T, N>, two: &AnyPoint<T, T, N>| {
            let (d, d_inv) = (one.d().amax(), one.d_inv().amax());
            d * d_inv * d * two.d_inv().amax()
        };
        let there = self.near(&mine, &ad, size.max(ad.amax()).max(solved(&other, &point)), x);
        Ok(there.and(self.near(&mine_inv, &ad_inv, size.max(ad_inv.amax()).max(solved(&point, &other)), x)))
    }
}

/// Displacements of at most 4 times this are within the domain where τ is one-to-one, whatever the basis.
const SMALL: f64 = 1.0 / 32.0;

/// The largest displacement whose logarithm is taken: beyond, e^|ξ| is so large that little is left of g.
const LONGEST: f64 = 4.0;

/// The factor of x with which the largest eigenvalue of its matrix is π − 2⁻ᵏ, in half of the cases; else that with which it is at most 3.
pub(super) fn within_half_turn<T: Real, const N: usize, const D: usize>(
    group: &impl LieGroup<T, N, D>,
    x: &Vector<T, N>,
    case: &dyn Debug,
) -> T {
    let mut probe = Probe::new(case, stream::LARGE_ANGLE);
    let radius = spectral_radius(&group.hat(x).map(|v| v.to_f64()));
    let close = std::f64::consts::PI - probe.power_of_two::<f64>(-18, 0);
    let size = x.amax().to_f64();
    let near = probe.integer(0, 1) == 0 && radius > 0.0 && size * close <= radius * LONGEST;
    let stretch = if near { close / radius } else { (3.0 / radius).min(1.0) };
    // Of 24 binary digits, so that both precisions meet the same displacement.
    T::exact(f64::from(stretch as f32))
}

fn at_most<T: Real>(off: &[T], size: T, x: &[T]) -> Measured {
    let defect = max_abs(off);
    Measured::defect(defect, size, 64.0 * x.len() as f64, || {
        let x: Vec<String> = x.iter().map(|v| format!("{:e}", v.to_f64())).collect();
        format!("at ξ = ({})", x.join(", "))
    })
}
