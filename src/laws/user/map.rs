//! A retraction from τ alone.

use crate::algebra::{LieAlgebra, Matrix, Vector, basis_vector, elimination};
use crate::group::LieGroup;
use crate::retraction::{Retraction, RetractionError, TangentPoint, refuse};
use crate::scalar::dual::{along, moving};
use crate::scalar::{Dual, Real, Scalar, finite};
use std::sync::Arc;

/// τ: g → G with τ(0) = e and T₀τ = Id: all that [`FromMap`] needs.
pub trait Map<T: Real, const N: usize, const D: usize>: Send + Sync + 'static {
    /// τ(x); `None` outside its domain.
    fn map<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Option<Matrix<S, D>>;
}

/// The retraction of a map τ: dτ and ddτ by dual numbers and the `vee` of the group, τ⁻¹ by Newton's method.
///
/// dτ_x δ = (τ(x)⁻¹ T_x τ(δ))^∨ and dτ_x ddτ_x(η, δ) = ∂_x(dτ_x η) δ; x ← x + dτ_x⁻¹ (τ(x)⁻¹ g − 1)^∨ from x = (g − 1)^∨,
/// which converges for g near e (`NoPreimage` where it does not, in [`STEPS`] steps). Exact to rounding; slow: N + 1
/// evaluations of τ on dual numbers for a point, N on dual numbers of dual numbers for each ddτ_x(η, ·).
///
/// The laws that compare a tangent with the derivative of τ, dτ⁻¹ with dτ, Ad_{τ(ξ)} with conjugation, or τ⁻¹ with τ, would
/// compare a thing with itself: [`laws!`](crate::laws!) leaves them out.
#[derive(Debug)]
pub struct FromMap<M, G> {
    map: Arc<M>,
    group: Arc<G>,
}

/// The most Newton steps of τ⁻¹.
pub const STEPS: usize = 60;

const NAME: &str = "map";

impl<M, G> FromMap<M, G> {
    /// The retraction of `map` to `group`.
    pub fn new(map: M, group: G) -> Self {
        Self { map: Arc::new(map), group: Arc::new(group) }
    }
}

impl<M, G> Clone for FromMap<M, G> {
    fn clone(&self) -> Self {
        Self { map: Arc::clone(&self.map), group: Arc::clone(&self.group) }
    }
}

/// The largest entry in absolute value.
fn size<'a, S: Scalar>(entries: impl IntoIterator<Item = &'a S>) -> f64 {
    entries.into_iter().fold(0.0, |m: f64, v| m.max(v.to_f64().abs()))
}

fn outside<S: Scalar, const N: usize>(x: &Vector<S, N>) -> RetractionError {
    refuse(x, NAME, "the map has no value")
}

fn singular<S: Scalar, const N: usize>(x: &Vector<S, N>) -> RetractionError {
    RetractionError::SingularTangent { retraction: NAME, size: size(x) }
}

impl<M, G> FromMap<M, G> {
    fn value<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        x: &Vector<S, N>,
    ) -> Result<Matrix<S, D>, RetractionError>
    where
        M: Map<T, N, D>,
    {
        let g = if finite(x.as_slice()) { self.map.map(x) } else { None };
        g.filter(|g| finite(g.as_slice())).ok_or_else(|| outside(x))
    }

    /// dτ_x δ.
    fn tangent<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        x: &Vector<S, N>,
        delta: &Vector<S, N>,
    ) -> Result<Vector<S, N>, RetractionError>
    where
        M: Map<T, N, D>,
        G: LieGroup<T, N, D>,
    {
        let g = self.value::<T, Dual<S>, N, D>(&moving(x, delta))?;
        let inverse = elimination::inverse(&g.map(|v| v.re)).ok_or_else(|| outside(x))?;
        Ok(self.group.vee(&(inverse * g.map(|v| v.eps))))
    }

    fn d<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
        &self,
        x: &Vector<S, N>,
    ) -> Result<Matrix<S, N>, RetractionError>
    where
        M: Map<T, N, D>,
        G: LieGroup<T, N, D>,
    {
        let mut d = Matrix::<S, N>::zeros();
        for a in 0..N {
            d.set_column(a, &self.tangent::<T, S, N, D>(x, &basis_vector(a))?);
        }
        Ok(d)
    }
}

impl<T, M, G, const N: usize, const D: usize> Retraction<T, N, D> for FromMap<M, G>
where
    T: Real,
    M: Map<T, N, D>,
    G: LieGroup<T, N, D> + Send + Sync + 'static,
{
    type Point<S: Scalar<Base = T>> = MapPoint<Self, S, N, D>;

    fn name(&self) -> &'static str {
        NAME
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        self.group.algebra()
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        self.value(x)
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let fail = |why| RetractionError::NoPreimage { retraction: NAME, why };
        if !finite(g.as_slice()) {
            return Err(RetractionError::NotFinite { retraction: NAME });
        }
        let mut x = self.group.vee(&(g - Matrix::identity()));
        let (mut before, mut further) = (f64::INFINITY, None);
        for _ in 0..STEPS {
            let here = elimination::inverse(&self.value::<T, S, N, D>(&x)?).ok_or_else(|| outside(&x))?;
            let d_inv = elimination::inverse(&self.d::<T, S, N, D>(&x)?).ok_or_else(|| singular(&x))?;
            let step = d_inv * self.group.vee(&(here * g - Matrix::identity()));
            x += step;
            let length = size(&step);
            // Three more once the steps are rounding: a step of Newton's method makes one more level of derivatives exact.
            let small = T::unit_roundoff().to_f64() * 64.0 * (1.0 + size(&x));
            if further.is_none() && (length <= small || (length >= before && length <= small * 1e4)) {
                further = Some(3);
            }
            match &mut further {
                Some(0) => break,
                Some(left) => *left -= 1,
                None => {}
            }
            before = length;
        }
        if further.is_none() || !finite(x.as_slice()) {
            return Err(fail("Newton's method does not converge"));
        }
        let off = size(&(self.value::<T, S, N, D>(&x)? - g));
        if off <= T::unit_roundoff().to_f64().sqrt() * size(g).max(1.0) {
            Ok(x)
        } else {
            Err(fail("the matrix is not in the group"))
        }
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<MapPoint<Self, S, N, D>, RetractionError> {
        let d = self.d::<T, S, N, D>(x)?;
        let d_inv = elimination::inverse(&d).ok_or_else(|| singular(x))?;
        let ad = self.group.adjoint(&self.value::<T, S, N, D>(x)?).ok_or_else(|| outside(x))?;
        let ad_inv = elimination::inverse(&ad).ok_or_else(|| outside(x))?;
        Ok(MapPoint { retraction: self.clone(), x: *x, d, d_inv, ad, ad_inv })
    }
}

/// The tangents of [`FromMap`] at x.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct MapPoint<R, S: Scalar, const N: usize, const D: usize> {
    retraction: R,
    x: Vector<S, N>,
    d: Matrix<S, N>,
    d_inv: Matrix<S, N>,
    ad: Matrix<S, N>,
    ad_inv: Matrix<S, N>,
}

impl<M, G, S, const N: usize, const D: usize> TangentPoint<S, N> for MapPoint<FromMap<M, G>, S, N, D>
where
    S: Scalar,
    M: Map<S::Base, N, D>,
    G: LieGroup<S::Base, N, D>,
{
    fn d(&self) -> &Matrix<S, N> {
        &self.d
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        &self.d_inv
    }

    /// Ad_{τ(x)} dτ_x.
    fn d_neg(&self) -> Matrix<S, N> {
        self.ad * self.d
    }

    fn ad(&self) -> Matrix<S, N> {
        self.ad
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        self.ad_inv
    }

    /// NaN where τ has no value near x.
    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        let mut second = Matrix::<S, N>::zeros();
        for a in 0..N {
            let x = along(&self.x, a);
            let column = self.retraction.tangent::<S::Base, Dual<S>, N, D>(&x, &y.map(Dual::constant));
            match column {
                Ok(column) => second.set_column(a, &column.map(|v| v.eps)),
                Err(_) => return Matrix::from_element(S::exact(f64::NAN)),
            }
        }
        self.d_inv * second
    }
}
