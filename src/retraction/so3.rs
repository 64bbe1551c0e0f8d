//! Retractions on SO(3) in closed form: R³ with the cross product, hat x̂ y = x × y.

use super::coefficients::{Coefficients, Values};
use super::{Retraction, RetractionError, TangentPoint, refuse};
use crate::algebra::brackets::Brackets;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::group::{LieGroup, So3};
use crate::scalar::{Real, Scalar, finite};

/// With four stages and more the difference between the scheme and the equations of motion is so small that most digits come from these.
const ROUGH_PAYS_FROM: usize = 4;

#[inline]
fn dot<S: Scalar>(x: &Vector<S, 3>, y: &Vector<S, 3>) -> S {
    x[0] * y[0] + x[1] * y[1] + x[2] * y[2]
}

#[inline]
fn cross<S: Scalar>(x: &Vector<S, 3>, y: &Vector<S, 3>) -> Vector<S, 3> {
    Vector::<S, 3>::new(x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0])
}

/// α 1 + β x̂ + γ x xᵀ.
#[inline]
fn combine<S: Scalar>(alpha: S, beta: S, gamma: S, x: &Vector<S, 3>) -> Matrix<S, 3> {
    let (b0, b1, b2) = (beta * x[0], beta * x[1], beta * x[2]);
    let (g0, g1) = (gamma * x[0], gamma * x[1]);
    let (s01, s02, s12) = (g0 * x[1], g0 * x[2], g1 * x[2]);
    Matrix::<S, 3>::new(
        alpha + g0 * x[0],
        s01 - b2,
        s02 + b1,
        s01 + b2,
        alpha + g1 * x[1],
        s12 - b0,
        s02 - b1,
        s12 + b0,
        alpha + gamma * x[2] * x[2],
    )
}

/// 1 + β x̂ + γ x̂²: the diagonal in the form that keeps its distance from 1 (x̂² = x xᵀ − |x|²).
#[inline]
fn rotation<S: Scalar>(beta: S, gamma: S, x: &Vector<S, 3>) -> Matrix<S, 3> {
    let (x2, y2, z2) = (x[0] * x[0], x[1] * x[1], x[2] * x[2]);
    let mut matrix = combine(S::zero(), beta, gamma, x);
    matrix[(0, 0)] = S::one() - gamma * (y2 + z2);
    matrix[(1, 1)] = S::one() - gamma * (x2 + z2);
    matrix[(2, 2)] = S::one() - gamma * (x2 + y2);
    matrix
}

/// The [scaled quaternion](scaled_quaternion) of a rotation by less than π. Refuses what is not finite or not a rotation (RᵀR = 1 to 2⁻²⁰
/// and det R > 0).
fn quaternion<S: Scalar>(g: &Matrix<S, 3>, retraction: &'static str) -> Result<(S, Vector<S, 3>), RetractionError> {
    if !finite(g.as_slice()) {
        return Err(RetractionError::NotFinite { retraction });
    }
    let r = g.map(|v| v.to_f64());
    let defect = (r.transpose() * r - Matrix::<f64, 3>::identity()).amax();
    if !(defect < 1.0 / 1048576.0 && r.determinant() > 0.0) {
        return Err(RetractionError::NoPreimage { retraction, why: "the matrix is not a rotation" });
    }
    let (w, v) = scaled_quaternion(g);
    if w.abs().base() <= <S::Base as Scalar>::int(16) * S::unit_roundoff() {
        return Err(RetractionError::NoPreimage { retraction, why: "the rotation angle is π" });
    }
    Ok((w, v))
}

/// The unit quaternion (w, v) of a rotation, times 4 q_k of its largest component: all accurate to round-off, without
/// a square root (Shepperd 1978). The scale is at least 1 in size; the sign of w is not normalised.
fn scaled_quaternion<S: Scalar>(g: &Matrix<S, 3>) -> (S, Vector<S, 3>) {
    let trace = g[(0, 0)] + g[(1, 1)] + g[(2, 2)];
    let skew = Vector::<S, 3>::new(g[(2, 1)] - g[(1, 2)], g[(0, 2)] - g[(2, 0)], g[(1, 0)] - g[(0, 1)]);
    if trace.base() >= S::zero().base() {
        return (S::one() + trace, skew);
    }
    let mut k = 0;
    for i in 1..3 {
        if g[(i, i)] > g[(k, k)] {
            k = i;
        }
    }
    let two = S::int(2);
    let v =
        Vector::<S, 3>::from_fn(|i, _| if i == k { S::one() + two * g[(k, k)] - trace } else { g[(i, k)] + g[(k, i)] });
    (skew[k], v)
}

/// The Cayley map on SO(3): τ(x) = (1 − x̂/2)⁻¹(1 + x̂/2), the rotation about x by the angle 2 arctan(|x|/2).
///
/// Defined for every x with finite |x|²; dτ is never singular. τ⁻¹ is undefined at rotation angle π.
/// With q = 4 + |x|² (Bou-Rabee and Marsden 2009; Martín de Diego and Sato Martín de Almagro 2019, §5.3):
/// τ = 1 + (4/q)(x̂ + x̂²/2), dτ = (2/q)(2 − x̂), dτ⁻¹ = 1 + x̂/2 + x xᵀ/4.
#[derive(Clone, Debug, PartialEq)]
pub struct CayleySo3<T: Real> {
    algebra: LieAlgebra<T, 3>,
}

impl<T: Real> CayleySo3<T> {
    const NAME: &'static str = "cay";

    /// The Cayley map on SO(3).
    pub fn new() -> Self {
        Self { algebra: So3::new().algebra().clone() }
    }

    /// 2/q.
    #[inline]
    fn factor<S: Scalar<Base = T>>(x: &Vector<S, 3>) -> Result<S, RetractionError> {
        let q = S::int(4) + dot(x, x);
        if q.all_finite() { Ok(S::int(2) / q) } else { Err(refuse(x, Self::NAME, "|x|² overflows")) }
    }
}

impl<T: Real> Default for CayleySo3<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real> Retraction<T, 3, 3> for CayleySo3<T> {
    type Point<S: Scalar<Base = T>> = CayleySo3Point<S>;

    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn algebra(&self) -> &LieAlgebra<T, 3> {
        &self.algebra
    }

    #[inline]
    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<Matrix<S, 3>, RetractionError> {
        let factor = Self::factor(x)?;
        Ok(rotation(factor + factor, factor, x))
    }

    /// x = 2 v/w, with (w, v) the unit quaternion of g.
    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Result<Vector<S, 3>, RetractionError> {
        let (w, v) = quaternion(g, Self::NAME)?;
        let factor = S::int(2) / w;
        Ok(v.map(|c| c * factor))
    }

    #[inline]
    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<CayleySo3Point<S>, RetractionError> {
        let factor = Self::factor(x)?;
        let (one, half) = (S::one(), S::half());
        Ok(CayleySo3Point {
            x: *x,
            factor,
            d: combine(factor + factor, -factor, S::zero(), x),
            d_inv: combine(one, half, half * half, x),
        })
    }

    #[inline]
    fn rough_pays_from(&self) -> usize {
        ROUGH_PAYS_FROM
    }

    /// All digits: η + ½ x×η + ¼ x (x·η).
    #[inline]
    fn rough_rates<const W: usize>(&self, _: &Brackets<T>, x: &[[T; W]; 3], eta: &[[T; W]; 3]) -> [[T; W]; 3] {
        let half = T::half();
        let along: [T; W] =
            std::array::from_fn(|w| (x[0][w] * eta[0][w] + x[1][w] * eta[1][w] + x[2][w] * eta[2][w]) * half);
        std::array::from_fn(|a| {
            let (b, c) = ((a + 1) % 3, (a + 2) % 3);
            std::array::from_fn(|w| eta[a][w] + (x[b][w] * eta[c][w] - x[c][w] * eta[b][w] + x[a][w] * along[w]) * half)
        })
    }
}

/// The tangents of [`CayleySo3`] at x.
#[derive(Clone, Debug, PartialEq)]
pub struct CayleySo3Point<S: Scalar> {
    x: Vector<S, 3>,
    /// 2/q.
    factor: S,
    d: Matrix<S, 3>,
    d_inv: Matrix<S, 3>,
}

impl<S: Scalar> TangentPoint<S, 3> for CayleySo3Point<S> {
    #[inline]
    fn d(&self) -> &Matrix<S, 3> {
        &self.d
    }

    #[inline]
    fn d_inv(&self) -> &Matrix<S, 3> {
        &self.d_inv
    }

    #[inline]
    fn d_neg(&self) -> Matrix<S, 3> {
        self.d.transpose()
    }

    #[inline]
    fn ad(&self) -> Matrix<S, 3> {
        rotation(self.factor + self.factor, self.factor, &self.x)
    }

    #[inline]
    fn ad_inv(&self) -> Matrix<S, 3> {
        rotation(-(self.factor + self.factor), self.factor, &self.x)
    }

    /// f − (4/q) f × x + (2/q) (f × x) × x.
    #[inline]
    fn pull_ad_inv(&self, f: &Covector<S, 3>, _: &Covector<S, 3>) -> Covector<S, 3> {
        let turned = cross(&f.transpose(), &self.x);
        f + ((cross(&turned, &self.x) - turned - turned) * self.factor).transpose()
    }

    /// (2/q)[dτ_x⁻¹ ŷ − y xᵀ] = (2/q)[ŷ − ½ y xᵀ − ½ (x·y) 1 + ¼ x (x × y)ᵀ].
    fn dd(&self, y: &Vector<S, 3>) -> Matrix<S, 3> {
        let x = &self.x;
        let half = S::half();
        let z = cross(x, y) * half;
        let mut matrix = combine(-half * dot(x, y), S::one(), S::zero(), y);
        for i in 0..3 {
            for j in 0..3 {
                matrix[(i, j)] = self.factor * (matrix[(i, j)] + half * (x[i] * z[j] - y[i] * x[j]));
            }
        }
        matrix
    }

    /// (2/q)[m × y − (p·y) x].
    #[inline]
    fn pull_dd(&self, p: &Covector<S, 3>, m: &Covector<S, 3>, y: &Vector<S, 3>) -> Covector<S, 3> {
        let x = &self.x;
        let along = p[0] * y[0] + p[1] * y[1] + p[2] * y[2];
        Covector::<S, 3>::new(
            self.factor * (m[1] * y[2] - m[2] * y[1] - along * x[0]),
            self.factor * (m[2] * y[0] - m[0] * y[2] - along * x[1]),
            self.factor * (m[0] * y[1] - m[1] * y[0] - along * x[2]),
        )
    }
}

/// The exponential on SO(3): τ(x) = exp x̂, the rotation about x by the angle θ = |x|.
///
/// τ is defined for every x with finite |x|²; dτ is singular iff θ = 2πk, k ≠ 0 (`SingularTangent`). τ⁻¹ is the
/// principal logarithm, |x| < π, undefined at rotation angle π. With the functions A, B, G of t = θ² in
/// [`Coefficients`] (Iserles et al. 2000, app. B; Martín de Diego and Sato Martín de Almagro 2019, §5.3):
/// τ = 1 + (sin θ/θ) x̂ + A x̂², dτ = 1 − A x̂ + B x̂², dτ⁻¹ = 1 + x̂/2 + G x̂².
#[derive(Clone, Debug, PartialEq)]
pub struct ExponentialSo3<T: Real> {
    algebra: LieAlgebra<T, 3>,
    coefficients: Coefficients<T>,
}

impl<T: Real> ExponentialSo3<T> {
    const NAME: &'static str = "exp";

    /// The exponential on SO(3).
    pub fn new() -> Self {
        Self { algebra: So3::new().algebra().clone(), coefficients: Coefficients::new() }
    }

    fn values<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<Values<S>, RetractionError> {
        let t = dot(x, x);
        if t.all_finite() { Ok(self.coefficients.at(t)) } else { Err(refuse(x, Self::NAME, "|x|² overflows")) }
    }
}

impl<T: Real> Default for ExponentialSo3<T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Real> Retraction<T, 3, 3> for ExponentialSo3<T> {
    type Point<S: Scalar<Base = T>> = ExponentialSo3Point<S>;

    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn algebra(&self) -> &LieAlgebra<T, 3> {
        &self.algebra
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<Matrix<S, 3>, RetractionError> {
        let values = self.values(x)?;
        Ok(rotation(values.sinc, values.a, x))
    }

    /// x = 2 arctan(|v|/w) v/|v| with w ≥ 0, with (w, v) the unit quaternion of g.
    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, 3>) -> Result<Vector<S, 3>, RetractionError> {
        let (w, v) = quaternion(g, Self::NAME)?;
        let factor = S::int(2) * self.coefficients.half_angle(w.abs(), dot(&v, &v));
        let factor = if w < S::zero() { -factor } else { factor };
        Ok(v.map(|c| c * factor))
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, 3>) -> Result<ExponentialSo3Point<S>, RetractionError> {
        let values = self.values(x)?;
        let Some(g) = values.g else {
            let size = x.iter().fold(0.0, |m: f64, v| m.max(v.to_f64().abs()));
            return Err(RetractionError::SingularTangent { retraction: Self::NAME, size });
        };
        Ok(ExponentialSo3Point { x: *x, values, d: rotation(-values.a, values.b, x), d_inv: rotation(S::half(), g, x) })
    }

    #[inline]
    fn rough_pays_from(&self) -> usize {
        ROUGH_PAYS_FROM
    }

    /// η + ½ x×η + G x×(x×η), with the first terms of G.
    #[inline]
    fn rough_rates<const W: usize>(&self, _: &Brackets<T>, x: &[[T; W]; 3], eta: &[[T; W]; 3]) -> [[T; W]; 3] {
        let mut rates = *eta;
        for w in 0..W {
            let [x, y] = [x, eta].map(|v| Vector::<T, 3>::from_fn(|a, _| v[a][w]));
            let (once, t) = (cross(&x, &y), dot(&x, &x));
            let g = T::ratio(1, 12) + t * (T::ratio(1, 720) + t * (T::ratio(1, 30240) + t * T::ratio(1, 1209600)));
            let rate = y + once * T::half() + cross(&x, &once) * g;
            for a in 0..3 {
                rates[a][w] = rate[a];
            }
        }
        rates
    }
}

/// The tangents of [`ExponentialSo3`] at x.
#[derive(Clone, Debug, PartialEq)]
pub struct ExponentialSo3Point<S: Scalar> {
    x: Vector<S, 3>,
    values: Values<S>,
    d: Matrix<S, 3>,
    d_inv: Matrix<S, 3>,
}

impl<S: Scalar> ExponentialSo3Point<S> {
    /// (u, z, β) with ∂_x(dτ_x y) = dτ_x ddτ_x(y, ·) = u xᵀ + ẑ + β 1:
    /// u = −2A' x×y + 2B' x×(x×y) − B y, z = A y − B x×y, β = B x·y.
    fn derivative(&self, y: &Vector<S, 3>) -> (Vector<S, 3>, Vector<S, 3>, S) {
        let (x, values) = (&self.x, &self.values);
        let two = S::int(2);
        let (a_slope, b_slope) = (two * values.a_slope, two * values.b_slope);
        let once = cross(x, y);
        let twice = cross(x, &once);
        let u = Vector::<S, 3>::from_fn(|i, _| b_slope * twice[i] - a_slope * once[i] - values.b * y[i]);
        let z = Vector::<S, 3>::from_fn(|i, _| values.a * y[i] - values.b * once[i]);
        (u, z, values.b * dot(x, y))
    }
}

impl<S: Scalar> TangentPoint<S, 3> for ExponentialSo3Point<S> {
    fn d(&self) -> &Matrix<S, 3> {
        &self.d
    }

    fn d_inv(&self) -> &Matrix<S, 3> {
        &self.d_inv
    }

    fn d_neg(&self) -> Matrix<S, 3> {
        self.d.transpose()
    }

    fn ad(&self) -> Matrix<S, 3> {
        rotation(self.values.sinc, self.values.a, &self.x)
    }

    fn ad_inv(&self) -> Matrix<S, 3> {
        rotation(-self.values.sinc, self.values.a, &self.x)
    }

    /// dτ_x⁻¹ ∂_x(dτ_x y).
    fn dd(&self, y: &Vector<S, 3>) -> Matrix<S, 3> {
        let (u, z, beta) = self.derivative(y);
        let mut matrix = combine(beta, S::one(), S::zero(), &z);
        for i in 0..3 {
            for j in 0..3 {
                matrix[(i, j)] += u[i] * self.x[j];
            }
        }
        self.d_inv * matrix
    }

    /// m ∂_x(dτ_x y) = (m·u) xᵀ + m × z + β m.
    fn pull_dd(&self, _p: &Covector<S, 3>, m: &Covector<S, 3>, y: &Vector<S, 3>) -> Covector<S, 3> {
        let (u, z, beta) = self.derivative(y);
        let along = m[0] * u[0] + m[1] * u[1] + m[2] * u[2];
        Covector::<S, 3>::new(
            along * self.x[0] + m[1] * z[2] - m[2] * z[1] + beta * m[0],
            along * self.x[1] + m[2] * z[0] - m[0] * z[2] + beta * m[1],
            along * self.x[2] + m[0] * z[1] - m[1] * z[0] + beta * m[2],
        )
    }
}
