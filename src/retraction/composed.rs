//! A retraction after an odd map of the algebra: τ = τ₀∘φ.

use super::{Retraction, RetractionError, TangentPoint, refuse};
use crate::algebra::{LieAlgebra, Matrix, Vector, apply, elimination, times};
use crate::scalar::{Real, Scalar, finite};
use std::sync::Arc;

/// A term of an odd map: coefficient x^i x^j x^k … in one component, with an odd number of factors, at least three.
#[derive(Clone, Debug, PartialEq)]
pub struct OddTerm<T> {
    /// Which component, from 0.
    pub component: usize,
    /// The coefficient.
    pub coefficient: T,
    /// i, j, k, …, from 0: an index as often as it is a factor.
    pub factors: Vec<usize>,
}

/// The largest number of factors.
const MAX_DEGREE: usize = 15;

/// Like terms added up, those with a coefficient of 0 left out: of terms that cancel, rounding would leave something.
fn combined<T: Real>(terms: Vec<OddTerm<T>>) -> Vec<OddTerm<T>> {
    let sorted = |term: &OddTerm<T>| {
        let mut factors = term.factors.clone();
        factors.sort_unstable();
        (term.component, factors)
    };
    let mut combined: Vec<OddTerm<T>> = Vec::with_capacity(terms.len());
    for term in terms {
        match combined.iter_mut().find(|other| sorted(other) == sorted(&term)) {
            Some(like) => like.coefficient += term.coefficient,
            None => combined.push(term),
        }
    }
    combined.retain(|term| term.coefficient != T::zero());
    combined
}

/// φ(x) = x + Σ terms: φ(−x) = −φ(x), and φ'(0) = 1.
#[derive(Clone, Debug, PartialEq)]
struct OddMap<T>(Arc<[OddTerm<T>]>);

impl<T: Real> OddMap<T> {
    /// φ(x).
    fn value<S: Scalar<Base = T>, const N: usize>(&self, x: &Vector<S, N>) -> Vector<S, N> {
        let mut value = *x;
        for term in self.0.iter() {
            value[term.component] += product(term, x.as_slice(), []);
        }
        value
    }

    /// φ'(x).
    fn slope<S: Scalar<Base = T>, const N: usize>(&self, x: &Vector<S, N>) -> Matrix<S, N> {
        let mut slope = Matrix::<S, N>::identity();
        for term in self.0.iter() {
            for (k, &b) in term.factors.iter().enumerate() {
                slope[(term.component, b)] += product(term, x.as_slice(), [k]);
            }
        }
        slope
    }

    /// Whether φ' is regular on the way from 0 to x: beyond a fold of φ is another sheet. From each point the way goes on by less than it
    /// takes φ' to become singular, by its inverse and by how fast it changes at most.
    fn leads_to<S: Scalar<Base = T>, const N: usize>(&self, x: &Vector<S, N>) -> bool {
        let x = x.map(|v| v.base());
        // Rows of |φ'(x) − 1| and of |d/ds φ'(s x)|, summed.
        let (mut off, mut rate) = (Vector::<f64, N>::zeros(), Vector::<f64, N>::zeros());
        for term in self.0.iter() {
            for k in 0..term.factors.len() {
                let size = product::<T, 1>(term, x.as_slice(), [k]).to_f64().abs();
                off[term.component] += size;
                rate[term.component] += size * (term.factors.len() - 1) as f64;
            }
        }
        if off.max() < 1.0 {
            return true;
        }
        let mut way = 0.0;
        for _ in 0..PIECES {
            let Some(inverse) = elimination::inverse(&self.slope(&(x * T::exact(way)))) else { return false };
            let size = inverse.row_iter().map(|row| row.abs().sum().to_f64()).fold(0.0, f64::max);
            way += CLOSE / (rate.max() * size);
            if way >= 1.0 {
                return true;
            }
        }
        false
    }

    /// δ ↦ φ''(x)(y, δ).
    fn second<S: Scalar<Base = T>, const N: usize>(&self, x: &Vector<S, N>, y: &Vector<S, N>) -> Matrix<S, N> {
        let mut second = Matrix::<S, N>::zeros();
        for term in self.0.iter() {
            for (k, &b) in term.factors.iter().enumerate() {
                for (l, &c) in term.factors.iter().enumerate().filter(|(l, _)| *l != k) {
                    second[(term.component, c)] += product(term, x.as_slice(), [k, l]) * y[b];
                }
            }
        }
        second
    }
}

/// The coefficient times the factors but those in these places.
fn product<S: Scalar, const K: usize>(term: &OddTerm<S::Base>, x: &[S], without: [usize; K]) -> S {
    let factors = term.factors.iter().enumerate().filter(|(k, _)| !without.contains(k));
    factors.fold(S::lift(term.coefficient), |value, (_, &i)| value * x[i])
}

/// τ(x) = τ₀(φ(x)) with φ(x) = x + Σ terms, an odd polynomial.
///
/// τ(−x) = τ(x)⁻¹ and T₀τ = 1, as for τ₀: every odd map with φ'(0) = 1 makes another retraction. Tangents by the chain rule:
/// dτ_x = dτ₀_{φ(x)} φ'(x), ddτ_x(y, δ) = φ'(x)⁻¹ (ddτ₀_{φ(x)}(φ'(x) y, φ'(x) δ) + φ''(x)(y, δ)), Ad_{τ(x)} = Ad_{τ₀(φ(x))}. The
/// preimage is the one that continues from 0. Domain: φ' regular at s x for 0 ≤ s ≤ 1, and φ(x) in the domain of τ₀.
///
/// ```
/// use euler_poincare::algebra::Vector;
/// use euler_poincare::retraction::{CayleySo3, CayleySo3Point, Composed, ComposedPoint, OddTerm, Retraction, TangentPoint};
///
/// // φ(x) = x + x_1 x_2² e_3/8.
/// let term = OddTerm { component: 2, coefficient: 0.125, factors: vec![0, 1, 1] };
/// let tau = Composed::new(CayleySo3::<f64>::new(), vec![term])?;
/// let x = Vector::<f64, 3>::new(1.0, -1.0, 0.5);
/// assert_eq!(tau.tau(&x)?, CayleySo3::new().tau(&Vector::<f64, 3>::new(1.0, -1.0, 0.625))?);
/// assert!((tau.tau_inv(&tau.tau(&x)?)? - x).amax() < 1e-15);
/// // By the chain rule.
/// let point: ComposedPoint<CayleySo3Point<f64>, f64, 3> = tau.at(&x)?;
/// assert!((point.d() * point.d_inv()).is_identity(1e-15));
/// # Ok::<(), euler_poincare::retraction::RetractionError>(())
/// ```
#[derive(Clone, Debug)]
pub struct Composed<R, T> {
    inner: R,
    map: OddMap<T>,
}

impl<R, T: Real> Composed<R, T> {
    const NAME: &'static str = "composed";
    const FOLDED: &'static str = "the odd map folds on the way from 0";

    /// The retraction τ₀ after x ↦ x + Σ terms.
    ///
    /// # Errors
    /// A coefficient that is not finite; an index that is not below N; a term whose number of factors is even, or below 3, or above 15.
    pub fn new<const N: usize, const D: usize>(inner: R, terms: Vec<OddTerm<T>>) -> Result<Self, RetractionError>
    where
        R: Retraction<T, N, D>,
    {
        for (k, term) in terms.iter().enumerate() {
            let refused = |why| RetractionError::BadTerm { term: k + 1, why };
            if !term.coefficient.all_finite() {
                return Err(refused("its coefficient is not finite"));
            }
            if term.factors.iter().chain([&term.component]).any(|index| *index >= N) {
                return Err(refused("an index is larger than the dimension"));
            }
            if !is_odd(term.factors.len()) {
                return Err(refused(ODD));
            }
        }
        Ok(Self { inner, map: OddMap(combined(terms).into()) })
    }

    /// The terms of φ(x) − x, like terms as one.
    pub fn terms(&self) -> &[OddTerm<T>] {
        &self.map.0
    }
}

/// Whether a term of `degree` factors is admitted.
pub(crate) fn is_odd(degree: usize) -> bool {
    degree % 2 == 1 && (3..=MAX_DEGREE).contains(&degree)
}

/// What the number of factors may be.
pub(crate) const ODD: &str = "the number of its factors is not odd, or not from 3 to 15";

/// The most pieces of the way to a point, and how much of the distance to where φ' may become singular a piece is.
const PIECES: usize = 64;
const CLOSE: f64 = 0.9;

/// The most Newton steps for one point on the way from 0 to a preimage: they contract, so that a few suffice.
const MAX_ITERATIONS: usize = 30;

impl<T: Real> OddMap<T> {
    /// The x that continues from 0 with φ(x) = y: along φ(x) = s y, with shorter pieces where Newton's method does not contract.
    fn preimage<S: Scalar<Base = T>, const N: usize>(&self, y: &Vector<S, N>) -> Option<Vector<S, N>> {
        let target = y.map(|v| v.base());
        let (mut x, mut reached, mut piece) = (Vector::<T, N>::zeros(), T::zero(), T::one());
        while reached < T::one() {
            let next = (reached + piece).min(T::one());
            match self.near(&x, &(target * next)) {
                Some(found) => (x, reached, piece) = (found, next, piece * T::int(2)),
                // A fold, where φ' is singular.
                None if piece < T::exact(2f64.powi(-16)) => return None,
                None => piece *= T::half(),
            }
        }
        let (mut lifted, mut right) = (x.map(S::lift), 0);
        while right < S::NESTING {
            lifted -= elimination::inverse(&self.slope(&lifted))? * (self.value(&lifted) - y);
            right = 2 * right + 1;
        }
        Some(lifted)
    }

    /// The x near this one with φ(x) = y, by Newton steps each of which halves the residual or better: no other branch is reached.
    fn near<const N: usize>(&self, x: &Vector<T, N>, y: &Vector<T, N>) -> Option<Vector<T, N>> {
        let (mut x, close) = (*x, T::unit_roundoff().sqrt());
        let mut residual = self.value(&x) - y;
        for _ in 0..MAX_ITERATIONS {
            let step = elimination::inverse(&self.slope(&x))? * residual;
            if !finite(step.as_slice()) {
                return None;
            }
            x -= step;
            // Quadratic convergence: what such a step leaves is round-off.
            if step.amax() <= close * x.amax() {
                return Some(x);
            }
            let next = self.value(&x) - y;
            if next.amax() > residual.amax() * T::half() {
                return None;
            }
            residual = next;
        }
        None
    }
}

impl<T: Real, R: Retraction<T, N, D>, const N: usize, const D: usize> Retraction<T, N, D> for Composed<R, T> {
    type Point<S: Scalar<Base = T>> = ComposedPoint<R::Point<S>, S, N>;

    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        self.inner.algebra()
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        if !self.map.leads_to(x) {
            return Err(refuse(x, Self::NAME, Self::FOLDED));
        }
        self.inner.tau(&self.map.value(x))
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let why = "the polynomial does not take the value that is its logarithm, on the way from 0";
        let preimage = self.map.preimage(&self.inner.tau_inv(g)?);
        preimage.ok_or(RetractionError::NoPreimage { retraction: Self::NAME, why })
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Self::Point<S>, RetractionError> {
        if !self.map.leads_to(x) {
            return Err(refuse(x, Self::NAME, Self::FOLDED));
        }
        let inner = self.inner.at(&self.map.value(x))?;
        let slope = self.map.slope(x);
        let Some(slope_inv) = elimination::inverse(&slope) else {
            let size = x.iter().fold(0.0, |m: f64, v| m.max(v.to_f64().abs()));
            return Err(RetractionError::SingularTangent { retraction: Self::NAME, size });
        };
        let (d, d_inv) = (times(inner.d(), &slope), times(&slope_inv, inner.d_inv()));
        Ok(ComposedPoint { inner, map: self.map.clone(), x: *x, slope, slope_inv, d, d_inv })
    }
}

/// The tangents of [`Composed`] at x.
#[derive(Clone, Debug)]
pub struct ComposedPoint<P, S: Scalar, const N: usize> {
    /// At φ(x).
    inner: P,
    map: OddMap<S::Base>,
    x: Vector<S, N>,
    slope: Matrix<S, N>,
    slope_inv: Matrix<S, N>,
    d: Matrix<S, N>,
    d_inv: Matrix<S, N>,
}

impl<P: TangentPoint<S, N>, S: Scalar, const N: usize> TangentPoint<S, N> for ComposedPoint<P, S, N> {
    fn d(&self) -> &Matrix<S, N> {
        &self.d
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        &self.d_inv
    }

    fn d_neg(&self) -> Matrix<S, N> {
        times(&self.inner.d_neg(), &self.slope)
    }

    fn ad(&self) -> Matrix<S, N> {
        self.inner.ad()
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        self.inner.ad_inv()
    }

    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        let moved = times(&self.inner.dd(&apply(&self.slope, y)), &self.slope);
        times(&self.slope_inv, &(moved + self.map.second(&self.x, y)))
    }
}
