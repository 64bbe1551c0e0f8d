//! A retraction with a fault planted in it. It stands behind a pointer, instead of the right one.

use super::super::probe::Probe;
use super::{blend, blend_scalar};
use crate::algebra::{LieAlgebra, Matrix, Vector, basis_vector, dot};
use crate::harness::Fault;
use crate::retraction::beside::BesideRetraction;
use crate::retraction::{AnyPoint, AnyRetraction, Retraction, RetractionError, TangentPoint};
use crate::scalar::{Real, Scalar};
use crate::system::Wrap;

const NONABELIAN: &str = "non-abelian algebras";

pub const SHIFTED: Fault = Fault::new(
    "shifted-argument",
    "τ(ξ) replaced by τ(ξ + ½|ξ|² e_1): still a retraction, but τ(−ξ) ≠ τ(ξ)⁻¹, and dτ is not its tangent",
    "every group",
);
pub const CUT_INVERSE: Fault =
    Fault::new("cut-inverse", "τ⁻¹(g) = x replaced by x + |x|²x/12, as of a series cut too early", "every group");
pub const RIGHT_TANGENT: Fault =
    Fault::new("right-tangent", "dτ_ξ replaced by dτ_{−ξ}, the right-trivialised tangent", NONABELIAN);
pub const BERNOULLI: Fault = Fault::new(
    "truncated-bernoulli",
    "dτ⁻¹ replaced by 1 + ½ ad + ad²/12, the Bernoulli series of exp cut after B₂",
    "algebras that are not three-step nilpotent",
);
pub const INVERSE_MISSING: Fault = Fault::new("inverse-tangent-missing", "dτ⁻¹ replaced by 1", NONABELIAN);
pub const SECOND_MISSING: Fault = Fault::new("second-tangent-missing", "ddτ replaced by 0", NONABELIAN);
pub const SECOND_SIGN: Fault = Fault::new("second-tangent-sign", "ddτ replaced by −ddτ", NONABELIAN);
pub const SECOND_SWAPPED: Fault = Fault::new("second-tangent-swapped", "ddτ(η, δ) replaced by ddτ(δ, η)", NONABELIAN);
pub const SECOND_OF_INVERSE: Fault = Fault::new(
    "second-tangent-of-inverse",
    "the second tangent of τ⁻¹ instead of that of τ (erratum to §5.2)",
    NONABELIAN,
);
pub const ADJOINT_INVERTED: Fault = Fault::new("adjoint-inverted", "Ad_{τ(ξ)} and its inverse exchanged", NONABELIAN);

pub const DIGITS_LOST: Fault = Fault::new(
    "digits-lost",
    "2¹⁴ added to the entries of τ, dτ and dτ⁻¹ and taken away again: an unstable algorithm, which loses 4 digits in any precision",
    "every algebra",
);

pub const LATE_SERIES: Fault = Fault::new(
    "late-series",
    "(1 − cos θ)/θ² in closed form, with its series for θ < 10⁻⁴ alone: half of the digits of f64 are lost there, as many in any precision",
    NONABELIAN,
);
pub const LATER_SERIES: Fault = Fault::new(
    "later-series",
    "(1 − cos θ)/θ² in closed form, with its series for θ < 10⁻⁶ alone: three quarters of the digits of f64 are lost there",
    NONABELIAN,
);
pub const CUT_SERIES: Fault = Fault::new(
    "series-for-f64",
    "the series of (1 − cos θ)/θ² at θ ≤ 1 with eight terms: enough for f64, not for 32 digits",
    NONABELIAN,
);
pub const LOG_NEAR_PI: Fault = Fault::new(
    "logarithm-near-pi",
    "τ⁻¹ divided by a sin θ with an error of u, as that of R − Rᵀ: digits are lost as θ goes to π, in any precision",
    "algebras with rotations",
);

/// No fault: what is given and taken is changed by at most a unit of round-off of `f64`, in whatever precision, smoothly and on
/// the group. Its size is the number of a sample. What it makes of a defect is the condition of the problem.
pub const ROUNDED: Fault =
    Fault::new("rounded", "arguments and values changed by a unit of round-off of f64", "every algebra");

/// All of them.
pub const ALL: [Fault; 15] = [
    SHIFTED,
    CUT_INVERSE,
    RIGHT_TANGENT,
    BERNOULLI,
    INVERSE_MISSING,
    SECOND_MISSING,
    SECOND_SIGN,
    SECOND_SWAPPED,
    SECOND_OF_INVERSE,
    ADJOINT_INVERTED,
    DIGITS_LOST,
    LATE_SERIES,
    LATER_SERIES,
    CUT_SERIES,
    LOG_NEAR_PI,
];

/// Plants the fault in the retraction of a case, if it is one of [`ALL`] or [`ROUNDED`].
#[derive(Clone, Copy, Debug)]
pub struct Plant<'a>(pub Option<&'a Fault>);

impl Wrap for Plant<'_> {
    fn wrap<T: Real, const N: usize, const D: usize>(&self, inner: AnyRetraction<T, N, D>) -> AnyRetraction<T, N, D> {
        let planted = |fault: &&Fault| ALL.iter().chain([&ROUNDED]).any(|known| known.name == fault.name);
        match self.0.filter(planted) {
            Some(fault) => AnyRetraction::Beside(BesideRetraction::whole(PlantedRetraction { inner, fault: *fault })),
            None => inner,
        }
    }
}

/// m (1 + E) with a matrix E of at most a unit of round-off of `f64`, which the sample and the place determine.
#[inline(never)]
fn rounded<S: Scalar, const M: usize>(m: Matrix<S, M>, sample: f64, place: u64) -> Matrix<S, M> {
    m + m * errors::<S, M>(sample, place)
}

fn errors<S: Scalar, const M: usize>(sample: f64, place: u64) -> Matrix<S, M> {
    let mut probe = Probe::new(&sample, place);
    Matrix::from_fn(|_, _| S::exact(probe.unit::<f64>() * (f64::EPSILON / 2.0)))
}

/// x changed by at most a unit of round-off of `f64` times `size`.
fn shifted<S: Scalar, const M: usize>(x: &Vector<S, M>, size: S, sample: f64, place: u64) -> Vector<S, M> {
    let mut probe = Probe::new(&sample, place);
    x.map(|v| v + size * S::exact(probe.unit::<f64>() * (f64::EPSILON / 2.0)))
}

/// The number of squarings, for a power of 2⁴⁰: a condition of the eigenvectors of 10¹⁰ changes its root by 2e-11, as does a Jordan block.
const SQUARINGS: usize = 40;

/// The largest absolute value of an eigenvalue, by squaring: ‖mᵏ‖^{1/k}, k = 2⁴⁰.
pub(in crate::laws) fn spectral_radius<const M: usize>(m: &Matrix<f64, M>) -> f64 {
    let (mut power, mut log, mut share) = (*m, 0.0, 1.0);
    for _ in 0..SQUARINGS {
        let size = power.amax();
        // A power that is 0 is that of a nilpotent matrix; of one that is not finite nothing is known.
        if size == 0.0 || !size.is_finite() {
            return size;
        }
        log += share * size.ln();
        share *= 0.5;
        power /= size;
        power *= power;
    }
    log.exp()
}

/// A faulty retraction.
#[derive(Clone, Debug)]
pub struct PlantedRetraction<T: Real, const N: usize, const D: usize> {
    inner: AnyRetraction<T, N, D>,
    fault: Fault,
}

impl<T: Real, const N: usize, const D: usize> PlantedRetraction<T, N, D> {
    /// The number of the sample of [`ROUNDED`].
    fn sample(&self) -> Option<f64> {
        (self.fault.name == ROUNDED.name).then_some(self.fault.size)
    }

    /// By how much A = (1 − cos θ)/θ² is wrong, θ = |x|, with [`LATE_SERIES`], [`LATER_SERIES`] or [`CUT_SERIES`].
    fn wrong_a<S: Scalar>(&self, square: S) -> Option<S> {
        let switch = match self.fault.name {
            name if name == LATE_SERIES.name => 1e-8,
            name if name == LATER_SERIES.name => 1e-12,
            // t⁸/18!, the first term that is left out.
            name if name == CUT_SERIES.name && square <= S::one() => {
                let fourth = square * square * square * square;
                return Some(fourth * fourth * S::ratio(-1, 6_402_373_705_728_000));
            }
            _ => return None,
        };
        if square < S::exact(switch) || square > S::one() {
            return None;
        }
        let angle = square.sqrt();
        let half = (angle * S::half()).sin();
        Some((S::one() - angle.cos() - S::int(2) * half * half) / square)
    }

    /// [`DIGITS_LOST`].
    fn lossy<S: Scalar, const M: usize>(&self, right: Matrix<S, M>) -> Matrix<S, M> {
        let large = S::exact(16384.0);
        blend(right, right.map(|v| (v + large) - large), DIGITS_LOST.size_in(Some(&self.fault)))
    }

    /// The tangents of [`ROUNDED`]: dτ_x (1 + E) at an x that is changed, and its inverse.
    fn rounded_at<S: Scalar<Base = T>>(
        &self,
        x: &Vector<S, N>,
        sample: f64,
    ) -> Result<PlantedPoint<T, S, N>, RetractionError> {
        let size = S::lift(x.map(|v| v.base()).amax());
        let point = self.inner.at(&shifted(x, size, sample, 3))?;
        let errors = errors::<S, N>(sample, 4);
        let (d, d_inv) = (point.d() + point.d() * errors, point.d_inv() - errors * point.d_inv());
        Ok(PlantedPoint { fault: self.fault, d, d_inv, point })
    }
}

impl<T: Real, const N: usize, const D: usize> Retraction<T, N, D> for PlantedRetraction<T, N, D> {
    type Point<S: Scalar<Base = T>> = PlantedPoint<T, S, N>;

    fn name(&self) -> &'static str {
        self.inner.name()
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        self.inner.algebra()
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        let mut moved = *x;
        moved[0] +=
            blend_scalar(S::zero(), dot(x.as_slice(), x.as_slice()) * S::half(), SHIFTED.size_in(Some(&self.fault)));
        if let Some(sample) = self.sample() {
            moved = shifted(x, S::lift(x.map(|v| v.base()).amax().max(T::one())), sample, 1);
        }
        Ok(self.lossy(self.inner.tau(&moved)?))
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let x = self.inner.tau_inv(g)?;
        if let Some(sample) = self.sample() {
            return Ok(shifted(&x, S::lift(x.map(|v| v.base()).amax().max(T::one())), sample, 2));
        }
        if self.fault.name == LOG_NEAR_PI.name {
            let angle = spectral_radius(&self.algebra().ad(&x.map(|v| v.base())).map(|v| v.to_f64()));
            let sin = T::exact(angle.sin());
            let wrong = S::lift(if angle > 2.0 { sin / ((T::one() + sin) - T::one()) } else { T::one() });
            return Ok(blend(x, x * wrong, self.fault.size));
        }
        Ok(blend(
            x,
            x + x * (dot(x.as_slice(), x.as_slice()) * S::ratio(1, 12)),
            CUT_INVERSE.size_in(Some(&self.fault)),
        ))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Self::Point<S>, RetractionError> {
        if let Some(sample) = self.sample() {
            return self.rounded_at(x, sample);
        }
        let point = self.inner.at(x)?;
        let ad = self.algebra().ad(x);
        let wrong = self.wrong_a(dot(x.as_slice(), x.as_slice())).map(|a| a * S::exact(self.fault.size));
        let series = Matrix::identity() + ad * S::half() + ad * ad * S::ratio(1, 12);
        let d_inv = blend(*point.d_inv(), series, BERNOULLI.size_in(Some(&self.fault)));
        Ok(PlantedPoint {
            fault: self.fault,
            d: self.lossy(blend(*point.d(), point.d_neg(), RIGHT_TANGENT.size_in(Some(&self.fault))))
                - wrong.map_or_else(Matrix::zeros, |wrong| ad * wrong),
            d_inv: self.lossy(blend(d_inv, Matrix::identity(), INVERSE_MISSING.size_in(Some(&self.fault)))),
            point,
        })
    }
}

/// The tangents of [`PlantedRetraction`] at a point.
#[derive(Clone, Debug)]
pub struct PlantedPoint<T: Real, S: Scalar<Base = T>, const N: usize> {
    point: AnyPoint<T, S, N>,
    fault: Fault,
    d: Matrix<S, N>,
    d_inv: Matrix<S, N>,
}

impl<T: Real, S: Scalar<Base = T>, const N: usize> PlantedPoint<T, S, N> {
    /// With the errors of [`ROUNDED`], which are no function of x.
    fn rounded(&self, m: Matrix<S, N>, place: u64) -> Matrix<S, N> {
        if self.fault.name == ROUNDED.name { rounded(m, self.fault.size, place) } else { m }
    }
}

impl<T: Real, S: Scalar<Base = T>, const N: usize> TangentPoint<S, N> for PlantedPoint<T, S, N> {
    fn d(&self) -> &Matrix<S, N> {
        &self.d
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        &self.d_inv
    }

    fn d_neg(&self) -> Matrix<S, N> {
        self.rounded(self.point.d_neg(), 5)
    }

    fn ad(&self) -> Matrix<S, N> {
        let size = ADJOINT_INVERTED.size_in(Some(&self.fault));
        self.rounded(blend(self.point.ad(), self.point.ad_inv(), size), 6)
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        let size = ADJOINT_INVERTED.size_in(Some(&self.fault));
        self.rounded(blend(self.point.ad_inv(), self.point.ad(), size), 7)
    }

    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        let right = self.point.dd(y);
        let wrong = match self.fault.name {
            name if name == SECOND_MISSING.name => Matrix::zeros(),
            name if name == SECOND_SIGN.name => -right,
            name if name == SECOND_OF_INVERSE.name => -(self.point.d() * self.point.dd(&(self.point.d_inv() * y))),
            name if name == SECOND_SWAPPED.name => {
                let mut swapped = Matrix::<S, N>::zeros();
                for a in 0..N {
                    swapped.set_column(a, &(self.point.dd(&basis_vector(a)) * y));
                }
                swapped
            }
            _ => return self.rounded(right, 8),
        };
        blend(right, wrong, self.fault.size)
    }
}
