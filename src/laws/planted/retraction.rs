//! A retraction with a fault planted in it. It stands behind a pointer, in the place of the right one.

use super::{blend, blend_scalar};
use crate::algebra::{LieAlgebra, Matrix, Vector, dot};
use crate::harness::Fault;
use crate::retraction::given::GivenRetraction;
use crate::retraction::{Retraction, RetractionError, TangentPoint};
use crate::scalar::{Real, Scalar};
use crate::system::Wrap;

const NONABELIAN: &str = "non-abelian algebras";

/// τ(ξ + ½|ξ|² e_1) for τ(ξ).
pub const SHIFTED: Fault = Fault::new(
    "shifted-argument",
    "τ(ξ) replaced by τ(ξ + ½|ξ|² e_1): still a retraction, but τ(−ξ) ≠ τ(ξ)⁻¹, and dτ is not its tangent",
    "every group",
);
/// x + |x|²x/12 for x = τ⁻¹(g).
pub const CUT_INVERSE: Fault =
    Fault::new("cut-inverse", "τ⁻¹(g) = x replaced by x + |x|²x/12, as of a series cut too early", "every group");
/// dτ_{−ξ} for dτ_ξ.
pub const RIGHT_TANGENT: Fault =
    Fault::new("right-tangent", "dτ_ξ replaced by dτ_{−ξ}, the right-trivialised tangent", NONABELIAN);
/// The Bernoulli series of exp, cut after B₂, for dτ⁻¹.
pub const BERNOULLI: Fault = Fault::new(
    "truncated-bernoulli",
    "dτ⁻¹ replaced by 1 + ½ ad + ad²/12, the Bernoulli series of exp cut after B₂",
    "algebras that are not three-step nilpotent",
);
/// 1 for dτ⁻¹.
pub const INVERSE_MISSING: Fault = Fault::new("inverse-tangent-missing", "dτ⁻¹ replaced by 1", NONABELIAN);
/// 0 for ddτ.
pub const SECOND_MISSING: Fault = Fault::new("second-tangent-missing", "ddτ replaced by 0", NONABELIAN);
/// −ddτ for ddτ.
pub const SECOND_SIGN: Fault = Fault::new("second-tangent-sign", "ddτ replaced by −ddτ", NONABELIAN);
/// ddτ(δ, η) for ddτ(η, δ).
pub const SECOND_SWAPPED: Fault = Fault::new("second-tangent-swapped", "ddτ(η, δ) replaced by ddτ(δ, η)", NONABELIAN);
/// ddτ⁻¹ for ddτ.
pub const SECOND_OF_INVERSE: Fault = Fault::new(
    "second-tangent-of-inverse",
    "the second tangent of τ⁻¹ in the place of that of τ (erratum to §5.2)",
    NONABELIAN,
);
/// Ad_{τ(ξ)} and its inverse exchanged.
pub const ADJOINT_INVERTED: Fault = Fault::new("adjoint-inverted", "Ad_{τ(ξ)} and its inverse exchanged", NONABELIAN);

/// 2¹⁴ added and taken away again.
pub const DIGITS_LOST: Fault = Fault::new(
    "digits-lost",
    "2¹⁴ added to the entries of τ, dτ and dτ⁻¹ and taken away again: an unstable algorithm, which loses 4 digits in any precision",
    "every algebra",
);

/// All of them.
pub const ALL: [Fault; 11] = [
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
];

/// Plants the fault in the retraction of a case, if it is one of [`ALL`].
#[derive(Clone, Copy, Debug)]
pub struct Plant<'a>(pub Option<&'a Fault>);

impl Wrap for Plant<'_> {
    fn wrap<T: Real, const N: usize, const D: usize, R>(&self, inner: R) -> R
    where
        R: Retraction<T, N, D> + From<GivenRetraction<T, N, D>> + Send + Sync + 'static,
    {
        match self.0.filter(|fault| ALL.iter().any(|known| known.name == fault.name)) {
            Some(fault) => GivenRetraction::whole(PlantedRetraction { inner, fault: *fault }).into(),
            None => inner,
        }
    }
}

/// A faulty retraction.
#[derive(Clone, Debug)]
pub struct PlantedRetraction<R> {
    inner: R,
    fault: Fault,
}

impl<R> PlantedRetraction<R> {
    fn size(&self, fault: &Fault) -> f64 {
        Fault::size_of(Some(&self.fault), fault.name)
    }

    /// [`DIGITS_LOST`].
    fn lossy<S: Scalar, const M: usize>(&self, right: Matrix<S, M>) -> Matrix<S, M> {
        let large = S::exact(16384.0);
        blend(right, right.map(|v| (v + large) - large), self.size(&DIGITS_LOST))
    }
}

impl<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>> Retraction<T, N, D> for PlantedRetraction<R> {
    type Point<S: Scalar<Base = T>> = PlantedPoint<R::Point<S>, S, N>;

    fn name(&self) -> &'static str {
        self.inner.name()
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        self.inner.algebra()
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        let mut moved = *x;
        moved[0] += blend_scalar(S::zero(), dot(x.as_slice(), x.as_slice()) * S::half(), self.size(&SHIFTED));
        Ok(self.lossy(self.inner.tau(&moved)?))
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let x = self.inner.tau_inv(g)?;
        Ok(blend(x, x + x * (dot(x.as_slice(), x.as_slice()) * S::ratio(1, 12)), self.size(&CUT_INVERSE)))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Self::Point<S>, RetractionError> {
        let point = self.inner.at(x)?;
        let ad = self.algebra().ad(x);
        let series = Matrix::identity() + ad * S::half() + ad * ad * S::ratio(1, 12);
        let d_inv = blend(*point.d_inv(), series, self.size(&BERNOULLI));
        Ok(PlantedPoint {
            fault: self.fault,
            d: self.lossy(blend(*point.d(), point.d_neg(), self.size(&RIGHT_TANGENT))),
            d_inv: self.lossy(blend(d_inv, Matrix::identity(), self.size(&INVERSE_MISSING))),
            point,
        })
    }
}

/// The tangents of [`PlantedRetraction`] at a point.
#[derive(Clone, Debug)]
pub struct PlantedPoint<P, S: Scalar, const N: usize> {
    point: P,
    fault: Fault,
    d: Matrix<S, N>,
    d_inv: Matrix<S, N>,
}

impl<P: TangentPoint<S, N>, S: Scalar, const N: usize> TangentPoint<S, N> for PlantedPoint<P, S, N> {
    fn d(&self) -> &Matrix<S, N> {
        &self.d
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        &self.d_inv
    }

    fn d_neg(&self) -> Matrix<S, N> {
        self.point.d_neg()
    }

    fn ad(&self) -> Matrix<S, N> {
        blend(self.point.ad(), self.point.ad_inv(), Fault::size_of(Some(&self.fault), ADJOINT_INVERTED.name))
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        blend(self.point.ad_inv(), self.point.ad(), Fault::size_of(Some(&self.fault), ADJOINT_INVERTED.name))
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
                    let mut e = Vector::<S, N>::zeros();
                    e[a] = S::one();
                    swapped.set_column(a, &(self.point.dd(&e) * y));
                }
                swapped
            }
            _ => right,
        };
        blend(right, wrong, self.fault.size)
    }
}
