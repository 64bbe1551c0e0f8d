//! The real numbers that every formula of this crate is written over.
//!
//! [`Scalar`] is what a formula needs; [`Real`] is a scalar that carries no derivatives. Data (structure constants,
//! inertias, tableaux) are stored over a [`Real`] `T`; methods that evaluate a formula are generic over
//! `S: Scalar<Base = T>`, so the same line runs on `f64`, on ~32 digits ([`Dd`]), on ~64 digits ([`Qd`]), and on dual
//! numbers over any of them ([`Dual`], for derivatives that are exact to round-off).
//!
//! | scalar | digits | u | all digits for sizes between |
//! |---|---|---|---|
//! | `f64` | 16 | 2⁻⁵³ | 2⁻¹⁰²² and 2¹⁰²⁴ |
//! | [`Dd`], two `f64` | 32 | 2⁻¹⁰³ | 2⁻⁹⁰⁰ and 2¹⁰⁰⁰ |
//! | [`Qd`], four `f64` | 64 | 2⁻²⁰⁹ | 2⁻⁸⁰⁰ and 2¹⁰⁰⁰ |
//! | [`Dual<T>`](Dual), two `T` | those of `T` | that of `T` | those of `T` |

use nalgebra::RealField;
use std::fmt::{Debug, Display, LowerExp};

/// A real number type: `f64`, double-double, quad-double, or duals over them.
///
/// Comparisons look at the value only, never at a derivative part.
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
}

/// A scalar that is its own base: `f64`, `Dd`, `Qd`. Everything that is stored is stored over a `Real`.
pub trait Real: Scalar<Base = Self> {
    /// A short name for tables and files: `f64`, `dd`, `qd`.
    const NAME: &'static str;

    /// The decimal number that `text` spells, correct to working precision (a few units of round-off at most).
    fn parse_decimal(text: &str) -> Option<Self>;
}

/// Whether all are: for matrices of every size, compiled once for a scalar.
pub(crate) fn finite<S: Scalar>(values: &[S]) -> bool {
    values.iter().all(|v| v.all_finite())
}

pub mod dd;
mod decimal;
mod double;
pub mod dual;
mod field;
pub mod number;
pub mod qd;

pub use dd::Dd;
pub use dual::Dual;
pub use number::{Number, NumberError};
pub use qd::Qd;
