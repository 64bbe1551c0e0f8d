//! Dual numbers re + eps ε with ε² = 0: a value and one directional derivative, exact to round-off.
//!
//! `Dual<Dual<T>>` carries a mixed second derivative. Our own, because the derivative has to carry the digits of
//! whatever it is built on (32 with `Dual<Dd>`), and to be a [`Scalar`].

use super::field::real_field;
use super::loops::heavy;
use super::{Real, Scalar};
use std::cmp::Ordering;
use std::fmt;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// re + eps ε, ε² = 0.
///
/// Where a derivative does not exist (√x at 0, the angle of the origin), `eps` is not finite, also for a constant.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dual<T> {
    /// The value.
    pub re: T,
    /// The derivative along the chosen direction.
    pub eps: T,
}

impl<T: Scalar> Dual<T> {
    /// The independent variable at `re`: derivative 1.
    pub fn variable(re: T) -> Self {
        Self { re, eps: T::one() }
    }

    /// A constant: derivative 0.
    pub fn constant(re: T) -> Self {
        Self { re, eps: T::zero() }
    }

    /// f(re + eps ε) = f(re) + f'(re) eps ε.
    fn chain(self, value: T, slope: T) -> Self {
        Self { re: value, eps: self.eps * slope }
    }
}

impl<T: Scalar> PartialEq for Dual<T> {
    fn eq(&self, other: &Self) -> bool {
        self.re == other.re
    }
}

impl<T: Scalar> PartialOrd for Dual<T> {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.re.partial_cmp(&other.re)
    }
}

impl<T: Scalar> fmt::Display for Dual<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(&self.re, f)?;
        f.write_str(" + ")?;
        fmt::Display::fmt(&self.eps, f)?;
        f.write_str(" ε")
    }
}

impl<T: Scalar> fmt::LowerExp for Dual<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::LowerExp::fmt(&self.re, f)?;
        f.write_str(" + ")?;
        fmt::LowerExp::fmt(&self.eps, f)?;
        f.write_str(" ε")
    }
}

impl<T: Scalar> Add for Dual<T> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { re: self.re + other.re, eps: self.eps + other.eps }
    }
}

impl<T: Scalar> Sub for Dual<T> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { re: self.re - other.re, eps: self.eps - other.eps }
    }
}

impl<T: Scalar> Neg for Dual<T> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { re: -self.re, eps: -self.eps }
    }
}

impl<T: Scalar> Mul for Dual<T> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        if const { heavy::<Self>() } {
            return if self.is_constant_one() { other } else { product(self, other) };
        }
        Self { re: self.re * other.re, eps: self.re * other.eps + self.eps * other.re }
    }
}

impl<T: Scalar> Div for Dual<T> {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        if const { heavy::<Self>() } {
            return quotient(self, other);
        }
        let re = self.re / other.re;
        Self { re, eps: (self.eps - re * other.eps) / other.re }
    }
}

/// A call, as a product of [`Dd`](super::Dd) is, for the compiler's sake. Most numbers of a computation are constants: their
/// derivatives are left out.
#[inline(never)]
fn product<T: Scalar>(x: Dual<T>, y: Dual<T>) -> Dual<T> {
    let eps = match (x.eps.vanishes(), y.eps.vanishes()) {
        (false, false) => x.re * y.eps + x.eps * y.re,
        (true, false) => x.re * y.eps,
        (false, true) => x.eps * y.re,
        (true, true) => T::zero(),
    };
    Dual { re: x.re * y.re, eps }
}

#[inline(never)]
fn quotient<T: Scalar>(x: Dual<T>, y: Dual<T>) -> Dual<T> {
    let re = x.re / y.re;
    Dual { re, eps: (x.eps - re * y.eps) / y.re }
}

/// What `real_field!` takes.
impl<T: Scalar> Dual<T> {
    fn square_root(self) -> Self {
        let root = self.re.sqrt();
        self.chain(root, T::half() / root)
    }
    fn exponential(self) -> Self {
        let value = self.re.exp();
        self.chain(value, value)
    }
    fn exponential_minus_one(self) -> Self {
        self.chain(self.re.exp_m1(), self.re.exp())
    }
    fn logarithm(self) -> Self {
        self.chain(self.re.ln(), T::one() / self.re)
    }
    fn logarithm_one_plus(self) -> Self {
        self.chain(self.re.ln_1p(), T::one() / (T::one() + self.re))
    }
    fn sine_cosine(self) -> (Self, Self) {
        let (sin, cos) = self.re.sin_cos();
        (self.chain(sin, cos), self.chain(cos, -sin))
    }
    fn arc_tangent(self, other: Self) -> Self {
        // Not over the squared radius, which can overflow or underflow.
        let radius = self.re.hypot(other.re);
        let (sin, cos) = (self.re / radius, other.re / radius);
        Self { re: self.re.atan2(other.re), eps: (self.eps * cos - sin * other.eps) / radius }
    }
    fn round_down(self) -> Self {
        Self::constant(self.re.floor())
    }
    fn circle() -> Self {
        Self::constant(T::pi())
    }
    fn log_two() -> Self {
        Self::constant(T::ln_2())
    }
}

real_field!([T: Scalar] Dual<T>);

impl<T: Scalar> Scalar for Dual<T> {
    type Base = T::Base;

    #[inline]
    fn lift(value: T::Base) -> Self {
        Self::constant(T::lift(value))
    }

    #[inline]
    fn base(self) -> T::Base {
        self.re.base()
    }

    fn unit_roundoff() -> T::Base {
        T::unit_roundoff()
    }

    #[inline]
    fn exact(x: f64) -> Self {
        Self::constant(T::exact(x))
    }

    #[inline]
    fn int(n: i64) -> Self {
        Self::constant(T::int(n))
    }

    #[inline]
    fn to_f64(self) -> f64 {
        self.re.to_f64()
    }

    #[inline]
    fn vanishes(self) -> bool {
        self.re.vanishes() && self.eps.vanishes()
    }

    #[inline]
    fn is_constant_one(self) -> bool {
        self.re.is_constant_one() && self.eps.vanishes()
    }

    fn all_finite(self) -> bool {
        self.re.all_finite() && self.eps.all_finite()
    }

    #[inline(always)]
    fn plus(self, other: Self) -> Self {
        Self { re: self.re.plus(other.re), eps: self.eps.plus(other.eps) }
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self { re: self.re.minus(other.re), eps: self.eps.minus(other.eps) }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        let eps = self.re.times(other.eps).plus(self.eps.times(other.re));
        Self { re: self.re.times(other.re), eps }
    }

    #[inline(always)]
    fn scaled(self, factor: T::Base) -> Self {
        Self { re: self.re.scaled(factor), eps: self.eps.scaled(factor) }
    }

    /// Many numbers of a computation are constants.
    #[inline(always)]
    fn add_multiple(y: &mut [Self], x: &[Self], c: Self) {
        if c.eps.vanishes() {
            for i in 0..y.len().min(x.len()) {
                y[i].re = y[i].re.plus(x[i].re.times(c.re));
                y[i].eps = y[i].eps.plus(x[i].eps.times(c.re));
            }
            return;
        }
        for i in 0..y.len().min(x.len()) {
            y[i] = y[i].plus(x[i].times(c));
        }
    }

    const NESTING: u32 = T::NESTING + 1;

    fn write(self, numbers: &mut Vec<T::Base>) {
        self.re.write(numbers);
        self.eps.write(numbers);
    }

    fn read(numbers: &[T::Base]) -> Self {
        let (re, eps) = numbers.split_at(numbers.len().min(1 << T::NESTING));
        Self { re: T::read(re), eps: T::read(eps) }
    }
}

/// x + ε e_a: what a derivative in component a, from 0, is taken on.
pub fn along<S: Scalar, const N: usize>(x: &nalgebra::SVector<S, N>, a: usize) -> nalgebra::SVector<Dual<S>, N> {
    let mut moved = x.map(Dual::constant);
    moved[a].eps = S::one();
    moved
}

/// x + ε v, a vector or a matrix that moves at the rate v.
pub fn moving<S: Scalar, const R: usize, const C: usize>(
    x: &nalgebra::SMatrix<S, R, C>,
    rate: &nalgebra::SMatrix<S, R, C>,
) -> nalgebra::SMatrix<Dual<S>, R, C> {
    x.zip_map(rate, |re, eps| Dual { re, eps })
}

/// The derivative of `f` at x along `direction`, with `f` evaluated on dual numbers.
///
/// # Errors
/// Those of `f`.
pub fn derivative<T: Real, const N: usize, const R: usize, const C: usize, E>(
    f: impl FnOnce(&nalgebra::SVector<Dual<T>, N>) -> Result<nalgebra::SMatrix<Dual<T>, R, C>, E>,
    x: &nalgebra::SVector<T, N>,
    direction: &nalgebra::SVector<T, N>,
) -> Result<nalgebra::SMatrix<T, R, C>, E> {
    Ok(f(&moving(x, direction))?.map(|v| v.eps))
}
