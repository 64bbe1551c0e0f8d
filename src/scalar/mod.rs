//! The real numbers that every formula of this crate is written over.
//!
//! [`Scalar`] is what a formula needs; [`Real`] is a scalar that carries no derivatives. Data (structure constants,
//! inertias, tableaux) are stored over a [`Real`] `T`; methods that evaluate a formula are generic over
//! `S: Scalar<Base = T>`, so the same line runs on `f64`, on ~32 digits ([`Dd`]), and on dual
//! numbers over either ([`Dual`], for derivatives that are exact to round-off).
//!
//! | scalar | digits | u | all digits for sizes between |
//! |---|---|---|---|
//! | `f64` | 16 | 2⁻⁵³ | 2⁻¹⁰²² and 2¹⁰²⁴ |
//! | [`Dd`], two `f64` | 32 | 2⁻¹⁰³ | 2⁻⁹⁰⁰ and 2¹⁰⁰⁰ |
//! | [`Dual<T>`](Dual), two `T` | those of `T` | that of `T` | those of `T` |
//!
//! With the feature `serde`, [`Dd`] is saved as a decimal text with as many digits as give the same number back.

use nalgebra::RealField;
use std::fmt::{Debug, Display, LowerExp};

/// A real number type: `f64`, double-double, or duals over them.
///
/// Comparisons look at the value only, never at a derivative part.
///
/// ```
/// use euler_poincare::scalar::{Dd, Dual, Number, NumberError, Real, Scalar};
///
/// /// 1 − cos x, in any scalar.
/// fn versine<S: Scalar>(x: S) -> S {
///     S::one() - x.cos()
/// }
///
/// /// The distance of that at 2⁻¹³ from 2 sin²(2⁻¹⁴), relative to it: what cancellation costs.
/// fn error<T: Real>() -> f64 {
///     let x = T::exact(2f64.powi(-13));
///     let half = (x * T::half()).sin();
///     let right = half * half * T::int(2);
///     ((versine(x) - right) / right).to_f64().abs()
/// }
/// assert!(error::<f64>() > 1e-10, "eight digits are lost");
/// assert!(error::<Dd>() < 1e-20, "as many, of more");
///
/// // A dual number carries the derivative: sin x.
/// assert_eq!(versine(Dual::variable(0.5)).eps, 0.5f64.sin());
///
/// // Exact expressions mean the same in every scalar.
/// let third: Number = "1/3".parse()?;
/// assert!((third.eval::<Dd>()? * Dd::int(3) - Dd::int(1)).to_f64().abs() < 1e-30);
/// assert!(matches!("1/0".parse::<Number>()?.eval::<f64>(), Err(NumberError::DivisionByZero { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Scalar: RealField + Copy + Default + Debug + Display + LowerExp + Send + Sync {
    /// The type of the value without its derivative parts: `f64` for `f64` and for `Dual<f64>`.
    type Base: Real;

    /// A constant: all derivative parts are zero.
    fn lift(value: Self::Base) -> Self;

    /// The value, without derivative parts.
    fn base(self) -> Self::Base;

    /// Unit round-off u (half the distance from 1 to the next number): 2⁻⁵³ for `f64`.
    fn unit_roundoff() -> Self::Base;

    /// The number `x`, exactly.
    fn exact(x: f64) -> Self;

    /// The integer `n`, exactly.
    fn int(n: i64) -> Self;

    /// The nearest `f64` to the value.
    fn to_f64(self) -> f64;

    /// p/q, correctly rounded to working precision.
    fn ratio(p: i64, q: i64) -> Self {
        Self::int(p) / Self::int(q)
    }

    /// ½, exactly.
    fn half() -> Self {
        Self::exact(0.5)
    }

    /// Whether the value and every derivative part are finite.
    fn all_finite(self) -> bool;

    /// How many dual numbers are nested: k of them hold 2ᵏ numbers, and carry derivatives of total order k.
    const NESTING: u32;

    /// Appends the value and the derivative parts, 2^[`NESTING`](Self::NESTING) numbers, to `numbers`.
    fn write(self, numbers: &mut Vec<Self::Base>);

    /// The scalar that [`write`](Self::write) wrote: its first 2^[`NESTING`](Self::NESTING) `numbers`, or more; those that are missing
    /// are 0.
    fn read(numbers: &[Self::Base]) -> Self;

    /// Whether the value and every derivative part are 0, so that products may leave it out. `false` is always right, but slower.
    fn vanishes(self) -> bool {
        false
    }

    /// Whether the value is 1 and every derivative part 0, so that a product is the other factor. `false` is always right, but
    /// slower.
    fn is_constant_one(self) -> bool {
        false
    }

    /// self + `other`, compiled where it stands: for inner loops that are compiled once.
    #[doc(hidden)]
    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        self + other
    }

    /// self − `other`, compiled where it stands.
    #[doc(hidden)]
    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        self - other
    }

    /// self × `other`, compiled where it stands.
    #[doc(hidden)]
    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self * other
    }

    /// self × `factor`, compiled where it stands.
    #[doc(hidden)]
    #[inline(always)]
    fn scaled(self, factor: Self::Base) -> Self {
        self * Self::lift(factor)
    }

    /// y += x c, entry by entry.
    #[doc(hidden)]
    #[inline(always)]
    fn add_multiple(y: &mut [Self], x: &[Self], c: Self) {
        for i in 0..y.len().min(x.len()) {
            y[i] = y[i].plus(x[i].times(c));
        }
    }
}

/// A scalar that is its own base: `f64`, `Dd`. Everything that is stored is stored over a `Real`.
pub trait Real: Scalar<Base = Self> {
    /// A short name for tables and files: `f64`, `dd`.
    const NAME: &'static str;

    /// The decimal number that `text` spells, correct to working precision (a few units of round-off at most).
    fn parse_decimal(text: &str) -> Option<Self>;
}

/// The numbers of a [`Scalar`] that is a [`Real`]: itself.
macro_rules! without_duals {
    () => {
        type Base = Self;

        #[inline]
        fn lift(value: Self) -> Self {
            value
        }

        #[inline]
        fn base(self) -> Self {
            self
        }

        const NESTING: u32 = 0;

        #[inline]
        fn write(self, numbers: &mut Vec<Self>) {
            numbers.push(self);
        }

        #[inline]
        fn read(numbers: &[Self]) -> Self {
            numbers.first().copied().unwrap_or_default()
        }
    };
}
use without_duals;

/// Whether all are: for matrices of every size, compiled once for a scalar.
pub(crate) fn finite<S: Scalar>(values: &[S]) -> bool {
    values.iter().all(|v| v.all_finite())
}

/// The larger of two numbers, or NaN where one of them is. `max`, and `amax` of nalgebra, lose a NaN: nothing may be judged by them that
/// has to be finite.
#[inline]
pub(crate) fn larger<T: Real>(a: T, b: T) -> T {
    if a > b || !a.all_finite() { a } else { b }
}

/// The largest absolute value, 0 of none; NaN or infinite where one is.
#[inline]
pub(crate) fn max_abs<'a, T: Real>(values: impl IntoIterator<Item = &'a T>) -> T {
    values.into_iter().fold(T::zero(), |most, v| larger(most, v.abs()))
}

/// x in another scalar, to all digits that both have.
#[cfg(feature = "harness")]
pub(crate) fn convert<W: Real, T: Real>(x: W) -> T {
    let (mut rest, mut sum) = (x, T::zero());
    for _ in 0..4 {
        let part = rest.to_f64();
        sum += T::exact(part);
        rest -= W::exact(part);
    }
    sum
}

pub mod dd;
mod decimal;
mod double;
pub mod dual;
#[cfg(feature = "harness")]
pub(crate) mod erased;
mod field;
mod fused;
pub(crate) mod loops;
pub mod number;
#[cfg(feature = "serde")]
mod serialised;

pub use dd::Dd;
pub use dual::Dual;
pub use number::{Number, NumberError};
