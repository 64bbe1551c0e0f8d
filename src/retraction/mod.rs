//! Retractions τ: g → G, the maps from a Lie algebra to its group, and their left-trivialised tangents.
//!
//! | | any algebra or group | SO(3), closed form |
//! |---|---|---|
//! | exp | [`Exponential`] | [`ExponentialSo3`] |
//! | Cayley | [`Cayley`] | [`CayleySo3`] |
//!
//! [`AnyRetraction`] is either of the general two. [`Composed`] makes another retraction of any: τ∘φ with φ odd.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/retraction.md"))]

use crate::algebra::brackets::Brackets;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, elimination, pull};
use crate::scalar::{Real, Scalar, finite};

/// The retractions that have names: their types, with the parameters of [`Cayley`], and [what is known of them](named::Known); how they are
/// built of an algebra and its group, where there is one; their closed forms on SO(3), with forms in lanes, where they have one.
macro_rules! retractions {
    ($read:ident) => {
        $read! {
            /// The exponential.
            Exponential(Exponential, ExponentialPoint) {
                name: "exp",
                build: |algebra, group| Ok(match group {
                    Some(group) => Exponential::of_group(group.clone()),
                    None => Exponential::of_algebra(algebra.clone()),
                }),
                closed: Some(Core::Exponential(Typed(ExponentialSo3::new()))),
                known: Known {
                    of_matrices: false,
                    angle: |frequency| frequency,
                    frequency: |angle| angle,
                    nearest: (10, 4096.0),
                    weight: 50,
                    share: (47.5, 48.5),
                },
            }
            /// The Cayley map.
            Cayley(Cayley, CayleyPoint) {
                name: "cayley",
                build: |_, group| Cayley::new(group.ok_or("there is no group")?.clone()).map_err(|e| e.to_string()),
                closed: Some(Core::Cayley(Typed(CayleySo3::new()))),
                known: Known {
                    of_matrices: true,
                    angle: |frequency| 2.0 * (frequency / 2.0).atan(),
                    frequency: |angle| 2.0 * (angle / 2.0).tan(),
                    // It reaches π at infinity only.
                    nearest: (6, 256.0),
                    weight: 50,
                    share: (31.7, 32.7),
                },
            }
        }
    };
}

pub mod any;
#[cfg(feature = "harness")]
#[doc(hidden)]
pub mod beside;
pub mod cayley;
#[doc(hidden)]
pub mod coefficients;
mod composed;
pub mod exponential;
mod linear;
#[cfg(feature = "harness")]
pub(crate) mod named;
pub mod so3;

pub use any::{AnyPoint, AnyRetraction};
pub use cayley::{Cayley, CayleyPoint, NotQuadratic};
pub use composed::{Composed, ComposedPoint, OddTerm};
#[cfg(feature = "harness")]
pub(crate) use composed::{ODD, is_odd};
pub use exponential::{Exponential, ExponentialPoint};
#[cfg(feature = "harness")]
pub(crate) use linear::real_eigenvalues_below_one;
pub use so3::{CayleySo3, CayleySo3Point, ExponentialSo3, ExponentialSo3Point};

/// Where a retraction or its inverse is not defined, with the numbers needed to act on it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RetractionError {
    /// The argument is outside the domain of τ (for Cayley: 1 − x/2 is singular).
    #[error("{retraction}: the argument (largest component {size:e}) is outside the domain: {why}")]
    OutsideDomain {
        /// Name of the retraction.
        retraction: &'static str,
        /// Largest component of the argument in absolute value.
        size: f64,
        /// Which condition fails.
        why: &'static str,
    },
    /// dτ_x is singular to working precision.
    #[error("{retraction}: the tangent dτ_x is singular to working precision (largest component of x {size:e})")]
    SingularTangent {
        /// Name of the retraction.
        retraction: &'static str,
        /// Largest component of x in absolute value.
        size: f64,
    },
    /// The group element has no (unique) preimage.
    #[error("{retraction}: the inverse is undefined at this group element: {why}")]
    NoPreimage {
        /// Name of the retraction.
        retraction: &'static str,
        /// Which condition fails, e.g. "rotation angle π".
        why: &'static str,
    },
    /// The algebra is given by structure constants alone, so there are no group elements.
    #[error("{retraction}: not applicable, because the algebra is given by structure constants alone, without a group")]
    NoGroup {
        /// Name of the retraction.
        retraction: &'static str,
    },
    /// A term of an odd map is not what it needs to be.
    #[error("composed: term {term} of the odd map is refused: {why}")]
    BadTerm {
        /// Which term, from 1.
        term: usize,
        /// What is wrong.
        why: &'static str,
    },
    /// The argument holds a NaN or an infinity.
    #[error("{retraction}: the argument is not finite")]
    NotFinite {
        /// Name of the retraction.
        retraction: &'static str,
    },
}

/// A retraction: τ and its inverse, and the tangents at a point.
///
/// D is the size of the matrices that represent the group.
///
/// ```
/// use euler_poincare::algebra::{Entry, Matrix, Vector};
/// use euler_poincare::group::{MatrixGroup, So3};
/// use euler_poincare::retraction::{
///     AnyPoint, AnyRetraction, Cayley, CayleyPoint, CayleySo3, CayleySo3Point, Exponential, ExponentialPoint, ExponentialSo3,
///     ExponentialSo3Point, NotQuadratic, Retraction, RetractionError, TangentPoint,
/// };
///
/// /// What every retraction satisfies: τ⁻¹ ∘ τ = 1 and Ad_{τ(x)} = dτ_x dτ_{−x}⁻¹.
/// fn check<R: Retraction<f64, 3, 3>>(retraction: &R) -> Result<R::Point<f64>, RetractionError> {
///     let x = Vector::<f64, 3>::new(0.1, -0.2, 0.3);
///     let back: Vector<f64, 3> = retraction.tau_inv(&retraction.tau(&x)?)?;
///     assert!((back - x).amax() < 1e-15);
///     // g ⊕ x = g τ(x), and back.
///     let g = retraction.tau(&Vector::<f64, 3>::new(0.5, 0.0, 0.25))?;
///     assert!((retraction.minus(&retraction.plus(&g, &x)?, &g)? - x).amax() < 1e-15);
///     let point = retraction.at(&x)?;
///     assert!((point.d() * point.d_inv() - Matrix::<f64, 3>::identity()).amax() < 1e-15);
///     assert!((point.ad() * point.d_neg() - point.d()).amax() < 1e-15 || (point.ad() * point.d() - point.d_neg()).amax() < 1e-15);
///     Ok(point)
/// }
///
/// // Closed forms on SO(3), and the general ones on any group.
/// let closed: CayleySo3Point<f64> = check(&CayleySo3::new())?;
/// let general: CayleyPoint<f64, f64, 3> = check(&Cayley::new(So3::new())?)?;
/// assert!((closed.d() - general.d()).amax() < 1e-15);
/// let closed: ExponentialSo3Point<f64> = check(&ExponentialSo3::new())?;
/// let general: ExponentialPoint<f64, f64, 3> = check(&Exponential::of_group(So3::new()))?;
/// assert!((closed.d() - general.d()).amax() < 1e-15);
///
/// // Either of them, chosen when the program runs.
/// let chosen = AnyRetraction::Exponential(Exponential::of_group(MatrixGroup::<f64, 3, 3>::from_entry(&Entry::Se2)?));
/// let _: AnyPoint<f64, f64, 3> = check(&chosen)?;
///
/// // Cayley's map needs a group of quadratic type; a half-turn has no preimage under it.
/// let scaling = MatrixGroup::new([Matrix::<f64, 2>::new(1.0, 0.0, 0.0, 2.0)])?;
/// let refused: Result<_, NotQuadratic> = Cayley::new(scaling);
/// assert!(refused.is_err());
/// let half_turn = Matrix::<f64, 3>::from_diagonal(&Vector::<f64, 3>::new(-1.0, -1.0, 1.0));
/// assert!(matches!(CayleySo3::<f64>::new().tau_inv(&half_turn), Err(RetractionError::NoPreimage { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Retraction<T: Real, const N: usize, const D: usize> {
    /// The tangents at one point, with what they share computed once.
    type Point<S: Scalar<Base = T>>: TangentPoint<S, N> + Clone;

    /// `"exp"` or `"cay"`: the name in tables and errors.
    fn name(&self) -> &'static str;

    /// The algebra on whose coordinates this retraction works.
    fn algebra(&self) -> &LieAlgebra<T, N>;

    /// τ(x), a D×D matrix.
    ///
    /// # Errors
    /// x outside the domain or not finite; no group.
    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError>;

    /// τ⁻¹(g), the preimage next to 0.
    ///
    /// # Errors
    /// g without a (unique) preimage to working precision, not in the group, or not finite; no group.
    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError>;

    /// g ⊕ x = g τ(x).
    ///
    /// # Errors
    /// Those of [`tau`](Self::tau).
    fn plus<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        Ok(g * self.tau(x)?)
    }

    /// h ⊖ g = τ⁻¹(g⁻¹ h): the x with h = g ⊕ x.
    ///
    /// # Errors
    /// Those of [`tau_inv`](Self::tau_inv); a singular g has no preimage.
    fn minus<S: Scalar<Base = T>>(&self, h: &Matrix<S, D>, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let singular = RetractionError::NoPreimage { retraction: self.name(), why: "the matrix is singular" };
        self.tau_inv(&(elimination::inverse(g).ok_or(singular)? * h))
    }

    /// dτ_x, dτ_x⁻¹ and what follows from them, at x.
    ///
    /// # Errors
    /// x outside the domain or not finite; dτ_x singular to working precision.
    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Self::Point<S>, RetractionError>;

    /// From how many stages of a tableau on [`rough_rates`](Self::rough_rates) pays: where `at` is a closed form, it costs little more.
    #[doc(hidden)]
    #[inline]
    fn rough_pays_from(&self) -> usize {
        1
    }

    /// dτ_x⁻¹ η of W pairs (x, η), component by component, to some digits, at a small part of the cost of [`at`](Self::at): the guess in
    /// iterations that `at` corrects. Without a form of its own η + ½[x, η], which every retraction has to O(x²).
    #[doc(hidden)]
    #[inline]
    fn rough_rates<const W: usize>(&self, brackets: &Brackets<T>, x: &[[T; W]; N], eta: &[[T; W]; N]) -> [[T; W]; N] {
        let mut rates = *eta;
        add_lanes(&mut rates, &brackets.brackets(x, eta), T::half());
        rates
    }
}

/// The left-trivialised tangents of a retraction at a point x. No group is needed: dτ and ddτ are algebra alone.
pub trait TangentPoint<S: Scalar, const N: usize> {
    /// dτ_x.
    fn d(&self) -> &Matrix<S, N>;

    /// dτ_x⁻¹.
    fn d_inv(&self) -> &Matrix<S, N>;

    /// dτ_{−x} = Ad_{τ(x)} dτ_x.
    fn d_neg(&self) -> Matrix<S, N>;

    /// Ad_{τ(x)} = dτ_{−x} dτ_x⁻¹.
    fn ad(&self) -> Matrix<S, N>;

    /// Ad_{τ(x)}⁻¹ = dτ_x dτ_{−x}⁻¹.
    fn ad_inv(&self) -> Matrix<S, N>;

    /// f Ad_{τ(x)}⁻¹, given f dτ_x as well.
    #[doc(hidden)]
    #[inline]
    fn pull_ad_inv(&self, f: &Covector<S, N>, _f_d: &Covector<S, N>) -> Covector<S, N> {
        pull(f, &self.ad_inv())
    }

    /// The matrix δ ↦ ddτ_x(y, δ).
    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N>;

    /// The covector p ddτ_x(y, ·), given m = p dτ_x⁻¹ as well (so that p = m dτ_x): both are at hand in the
    /// integrator, and one of them makes the closed forms cheap.
    fn pull_dd(&self, p: &Covector<S, N>, m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        let _ = m;
        p * self.dd(y)
    }
}

/// y += x c, place by place.
#[inline(always)]
fn add_lanes<T: Real, const N: usize, const W: usize>(y: &mut [[T; W]; N], x: &[[T; W]; N], c: T) {
    for (y, x) in y.iter_mut().zip(x) {
        for w in 0..W {
            y[w] += x[w] * c;
        }
    }
}

/// Why x was refused after a computation overflowed: it is not finite itself, or the stated reason.
#[cold]
pub(crate) fn refuse<S: Scalar, const N: usize>(
    x: &Vector<S, N>,
    retraction: &'static str,
    why: &'static str,
) -> RetractionError {
    if !finite(x.as_slice()) {
        return RetractionError::NotFinite { retraction };
    }
    let size = x.iter().fold(0.0, |m: f64, v| m.max(v.to_f64().abs()));
    RetractionError::OutsideDomain { retraction, size, why }
}

/// For types that point to a retraction: their methods are those of the retraction.
macro_rules! forwarded {
    ($($pointer:ty),*) => {$(
        impl<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>> Retraction<T, N, D> for $pointer {
            type Point<S: Scalar<Base = T>> = R::Point<S>;

            fn name(&self) -> &'static str {
                (**self).name()
            }

            fn algebra(&self) -> &LieAlgebra<T, N> {
                (**self).algebra()
            }

            fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
                (**self).tau(x)
            }

            fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
                (**self).tau_inv(g)
            }

            fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Self::Point<S>, RetractionError> {
                (**self).at(x)
            }

            #[inline]
            fn rough_pays_from(&self) -> usize {
                (**self).rough_pays_from()
            }

            #[inline]
            fn rough_rates<const W: usize>(
                &self,
                brackets: &Brackets<T>,
                x: &[[T; W]; N],
                eta: &[[T; W]; N],
            ) -> [[T; W]; N] {
                (**self).rough_rates(brackets, x, eta)
            }
        }
    )*};
}

forwarded!(&R, std::sync::Arc<R>);
