//! The boilerplate of nalgebra's field traits, written once.
//!
//! A number type that has the four operations, comparison, what [`Scalar`](super::Scalar) asks for and these functions gets `RealField`
//! (and the num-traits, approx and simba traits under it) from the macro `real_field!`: `square_root`, `exponential`,
//! `exponential_minus_one` and `logarithm_one_plus` (accurate at 0), `logarithm`, `sine_cosine`, `arc_tangent` (of y = self and x),
//! `round_down`, `circle` (π) and `log_two`. Each is accurate to a few units of round-off relative to its value, on its usual domain;
//! outside it the result is NaN, as for `f64`.

macro_rules! real_field {
    ([$($gen:tt)*] $ty:ty) => {
        impl<$($gen)*> std::ops::AddAssign for $ty {
            #[inline]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }
        impl<$($gen)*> std::ops::SubAssign for $ty {
            #[inline]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }
        impl<$($gen)*> std::ops::MulAssign for $ty {
            #[inline]
            fn mul_assign(&mut self, other: Self) {
                *self = *self * other;
            }
        }
        impl<$($gen)*> std::ops::DivAssign for $ty {
            #[inline]
            fn div_assign(&mut self, other: Self) {
                *self = *self / other;
            }
        }
        impl<$($gen)*> std::ops::Rem for $ty {
            type Output = Self;
            /// The remainder with the sign of `self`, as for `f64`.
            fn rem(self, other: Self) -> Self {
                self - other * simba::scalar::ComplexField::trunc(self / other)
            }
        }
        impl<$($gen)*> std::ops::RemAssign for $ty {
            fn rem_assign(&mut self, other: Self) {
                *self = *self % other;
            }
        }
        impl<$($gen)*> num_traits::Zero for $ty {
            #[inline]
            fn zero() -> Self {
                Scalar::exact(0.0)
            }
            #[inline]
            fn is_zero(&self) -> bool {
                *self == Self::zero()
            }
        }
        impl<$($gen)*> num_traits::One for $ty {
            #[inline]
            fn one() -> Self {
                Scalar::exact(1.0)
            }
        }
        impl<$($gen)*> num_traits::Num for $ty {
            type FromStrRadixErr = num_traits::ParseFloatError;
            fn from_str_radix(text: &str, radix: u32) -> Result<Self, Self::FromStrRadixErr> {
                <f64 as num_traits::Num>::from_str_radix(text, radix).map(Scalar::exact)
            }
        }
        impl<$($gen)*> num_traits::FromPrimitive for $ty {
            fn from_i64(n: i64) -> Option<Self> {
                Some(<Self as Scalar>::int(n))
            }
            fn from_u64(n: u64) -> Option<Self> {
                let (high, low) = ((n >> 32) as f64, (n & 0xffff_ffff) as f64);
                Some(<Self as Scalar>::exact(high) * Scalar::exact(4294967296.0) + Scalar::exact(low))
            }
            fn from_f64(x: f64) -> Option<Self> {
                Some(Scalar::exact(x))
            }
        }
        impl<$($gen)*> num_traits::Signed for $ty {
            #[inline]
            fn abs(&self) -> Self {
                if self.to_f64().is_sign_negative() { -*self } else { *self }
            }
            fn abs_sub(&self, other: &Self) -> Self {
                if *self <= *other { num_traits::Zero::zero() } else { *self - *other }
            }
            fn signum(&self) -> Self {
                Scalar::exact(self.to_f64().signum())
            }
            fn is_positive(&self) -> bool {
                self.to_f64() > 0.0
            }
            fn is_negative(&self) -> bool {
                self.to_f64() < 0.0
            }
        }
        impl<$($gen)*> approx::AbsDiffEq for $ty {
            type Epsilon = Self;
            fn default_epsilon() -> Self {
                <Self as Scalar>::lift(<Self as Scalar>::unit_roundoff()) * Scalar::exact(2.0)
            }
            fn abs_diff_eq(&self, other: &Self, epsilon: Self) -> bool {
                *self == *other || num_traits::Signed::abs(&(*self - *other)) <= epsilon
            }
        }
        impl<$($gen)*> approx::RelativeEq for $ty {
            fn default_max_relative() -> Self {
                <Self as approx::AbsDiffEq>::default_epsilon()
            }
            fn relative_eq(&self, other: &Self, epsilon: Self, max_relative: Self) -> bool {
                let size = simba::scalar::RealField::max(num_traits::Signed::abs(self), num_traits::Signed::abs(other));
                approx::AbsDiffEq::abs_diff_eq(self, other, epsilon)
                    || num_traits::Signed::abs(&(*self - *other)) <= size * max_relative
            }
        }
        impl<$($gen)*> approx::UlpsEq for $ty {
            fn default_max_ulps() -> u32 {
                4
            }
            fn ulps_eq(&self, other: &Self, epsilon: Self, max_ulps: u32) -> bool {
                let relative = <Self as approx::AbsDiffEq>::default_epsilon() * Scalar::exact(f64::from(max_ulps));
                approx::RelativeEq::relative_eq(self, other, epsilon, relative)
            }
        }
        impl<$($gen)*> simba::simd::PrimitiveSimdValue for $ty {}
        impl<$($gen)*> simba::simd::SimdValue for $ty {
            const LANES: usize = 1;
            type Element = Self;
            type SimdBool = bool;
            #[inline(always)]
            fn splat(value: Self) -> Self {
                value
            }
            #[inline(always)]
            fn extract(&self, _: usize) -> Self {
                *self
            }
            #[inline(always)]
            unsafe fn extract_unchecked(&self, _: usize) -> Self {
                *self
            }
            #[inline(always)]
            fn replace(&mut self, _: usize, value: Self) {
                *self = value;
            }
            #[inline(always)]
            unsafe fn replace_unchecked(&mut self, _: usize, value: Self) {
                *self = value;
            }
            #[inline(always)]
            fn select(self, condition: bool, other: Self) -> Self {
                if condition { self } else { other }
            }
        }
        impl<$($gen)*> simba::scalar::Field for $ty {}
        impl<$($gen)*> simba::scalar::SubsetOf<$ty> for $ty {
            #[inline]
            fn to_superset(&self) -> Self {
                *self
            }
            #[inline]
            fn from_superset_unchecked(element: &Self) -> Self {
                *element
            }
            #[inline]
            fn is_in_subset(_: &Self) -> bool {
                true
            }
        }
        impl<$($gen)*> simba::scalar::SubsetOf<$ty> for f64 {
            #[inline]
            fn to_superset(&self) -> $ty {
                Scalar::exact(*self)
            }
            #[inline]
            fn from_superset_unchecked(element: &$ty) -> f64 {
                element.to_f64()
            }
            #[inline]
            fn is_in_subset(_: &$ty) -> bool {
                true
            }
        }
        impl<$($gen)*> simba::scalar::SubsetOf<$ty> for f32 {
            #[inline]
            fn to_superset(&self) -> $ty {
                Scalar::exact(f64::from(*self))
            }
            #[inline]
            fn from_superset_unchecked(element: &$ty) -> f32 {
                element.to_f64() as f32
            }
            #[inline]
            fn is_in_subset(_: &$ty) -> bool {
                true
            }
        }
        impl<$($gen)*> simba::scalar::ComplexField for $ty {
            type RealField = Self;
            #[inline]
            fn from_real(re: Self) -> Self {
                re
            }
            #[inline]
            fn real(self) -> Self {
                self
            }
            #[inline]
            fn imaginary(self) -> Self {
                num_traits::Zero::zero()
            }
            #[inline]
            fn modulus(self) -> Self {
                num_traits::Signed::abs(&self)
            }
            #[inline]
            fn modulus_squared(self) -> Self {
                self * self
            }
            fn argument(self) -> Self {
                if self.to_f64() < 0.0 { Self::circle() } else { num_traits::Zero::zero() }
            }
            #[inline]
            fn norm1(self) -> Self {
                num_traits::Signed::abs(&self)
            }
            #[inline]
            fn scale(self, factor: Self) -> Self {
                self * factor
            }
            #[inline]
            fn unscale(self, factor: Self) -> Self {
                self / factor
            }
            fn floor(self) -> Self {
                self.round_down()
            }
            fn ceil(self) -> Self {
                -(-self).round_down()
            }
            fn round(self) -> Self {
                // Not ⌊|x| + ½⌋: that sum can round up to the next integer.
                let a = num_traits::Signed::abs(&self);
                let down = a.round_down();
                let half = <Self as Scalar>::exact(0.5);
                let value = if a - down >= half { down + half + half } else { down };
                if self.to_f64() < 0.0 { -value } else { value }
            }
            fn trunc(self) -> Self {
                if self.to_f64() < 0.0 { -(-self).round_down() } else { self.round_down() }
            }
            fn fract(self) -> Self {
                self - simba::scalar::ComplexField::trunc(self)
            }
            #[inline]
            fn mul_add(self, a: Self, b: Self) -> Self {
                self * a + b
            }
            #[inline]
            fn abs(self) -> Self {
                num_traits::Signed::abs(&self)
            }
            fn hypot(self, other: Self) -> Self {
                let (a, b) = (num_traits::Signed::abs(&self), num_traits::Signed::abs(&other));
                let (large, small) = if a >= b { (a, b) } else { (b, a) };
                if large.to_f64() == 0.0 {
                    return large;
                }
                let ratio = small / large;
                large * (<Self as num_traits::One>::one() + ratio * ratio).square_root()
            }
            #[inline]
            fn recip(self) -> Self {
                <Self as num_traits::One>::one() / self
            }
            #[inline]
            fn conjugate(self) -> Self {
                self
            }
            fn sin(self) -> Self {
                self.sine_cosine().0
            }
            fn cos(self) -> Self {
                self.sine_cosine().1
            }
            fn sin_cos(self) -> (Self, Self) {
                self.sine_cosine()
            }
            fn tan(self) -> Self {
                let (sin, cos) = self.sine_cosine();
                sin / cos
            }
            fn asin(self) -> Self {
                let one = <Self as num_traits::One>::one();
                self.arc_tangent(((one - self) * (one + self)).square_root())
            }
            fn acos(self) -> Self {
                let one = <Self as num_traits::One>::one();
                ((one - self) * (one + self)).square_root().arc_tangent(self)
            }
            fn atan(self) -> Self {
                self.arc_tangent(num_traits::One::one())
            }
            fn sinh(self) -> Self {
                // Of |x|, because e^x - 1 has lost the digits of e^x where x is negative.
                let a = num_traits::Signed::abs(&self);
                let half = <Self as Scalar>::exact(0.5);
                let value = if a.to_f64() > 80.0 {
                    let root = (a * half).exponential();
                    root * half * root
                } else {
                    let e = a.exponential_minus_one();
                    (e + e / (e + num_traits::One::one())) * half
                };
                if self.to_f64().is_sign_negative() { -value } else { value }
            }
            fn cosh(self) -> Self {
                let half = <Self as Scalar>::exact(0.5);
                let root = (num_traits::Signed::abs(&self) * half).exponential();
                let one = <Self as num_traits::One>::one();
                root * half * root + half * (one / root) * (one / root)
            }
            fn tanh(self) -> Self {
                let two = <Self as Scalar>::exact(2.0);
                let e = (-(num_traits::Signed::abs(&self) * two)).exponential_minus_one();
                let t = -e / (e + two);
                if self.to_f64().is_sign_negative() { -t } else { t }
            }
            fn asinh(self) -> Self {
                let one = <Self as num_traits::One>::one();
                let a = num_traits::Signed::abs(&self);
                // The difference from ln 2a is 1/4a²: below round-off, where a² could overflow.
                let value = if a.to_f64() > 1e35 {
                    a.logarithm() + Self::log_two()
                } else {
                    (a + a * a / (one + (one + a * a).square_root())).logarithm_one_plus()
                };
                if self.to_f64().is_sign_negative() { -value } else { value }
            }
            fn acosh(self) -> Self {
                if self.to_f64() > 1e35 {
                    return self.logarithm() + Self::log_two();
                }
                let one = <Self as num_traits::One>::one();
                let t = self - one;
                (t + (t * (self + one)).square_root()).logarithm_one_plus()
            }
            fn atanh(self) -> Self {
                let one = <Self as num_traits::One>::one();
                let a = num_traits::Signed::abs(&self);
                let value = ((a + a) / (one - a)).logarithm_one_plus() * Scalar::exact(0.5);
                if self.to_f64().is_sign_negative() { -value } else { value }
            }
            fn log(self, base: Self) -> Self {
                self.logarithm() / base.logarithm()
            }
            fn log2(self) -> Self {
                self.logarithm() / Self::log_two()
            }
            fn log10(self) -> Self {
                self.logarithm() / <Self as Scalar>::exact(10.0).logarithm()
            }
            fn ln(self) -> Self {
                self.logarithm()
            }
            fn ln_1p(self) -> Self {
                self.logarithm_one_plus()
            }
            fn sqrt(self) -> Self {
                self.square_root()
            }
            fn exp(self) -> Self {
                self.exponential()
            }
            fn exp2(self) -> Self {
                (self * Self::log_two()).exponential()
            }
            fn exp_m1(self) -> Self {
                self.exponential_minus_one()
            }
            fn powi(self, n: i32) -> Self {
                let mut result = <Self as num_traits::One>::one();
                let mut square = self;
                let mut rest = n.unsigned_abs();
                while rest > 0 {
                    if rest & 1 == 1 {
                        result *= square;
                    }
                    rest >>= 1;
                    if rest > 0 {
                        square *= square;
                    }
                }
                if n < 0 { <Self as num_traits::One>::one() / result } else { result }
            }
            // x^n for x > 0; integer powers of anything else are `powi`.
            fn powf(self, n: Self) -> Self {
                (self.logarithm() * n).exponential()
            }
            fn powc(self, n: Self) -> Self {
                (self.logarithm() * n).exponential()
            }
            fn cbrt(self) -> Self {
                if self.to_f64() == 0.0 {
                    return self;
                }
                let a = num_traits::Signed::abs(&self);
                let three = <Self as Scalar>::exact(3.0);
                let root = (a.logarithm() / three).exponential();
                // One Newton step: the exponential multiplies round-off by the size of its argument.
                let root = root - (root - a / (root * root)) / three;
                if self.to_f64() < 0.0 { -root } else { root }
            }
            fn is_finite(&self) -> bool {
                self.all_finite()
            }
            fn try_sqrt(self) -> Option<Self> {
                if self.to_f64() >= 0.0 { Some(self.square_root()) } else { None }
            }
        }
        impl<$($gen)*> simba::scalar::RealField for $ty {
            fn is_sign_positive(&self) -> bool {
                self.to_f64().is_sign_positive()
            }
            fn is_sign_negative(&self) -> bool {
                self.to_f64().is_sign_negative()
            }
            fn copysign(self, sign: Self) -> Self {
                let a = num_traits::Signed::abs(&self);
                if sign.to_f64().is_sign_negative() { -a } else { a }
            }
            #[inline]
            fn max(self, other: Self) -> Self {
                if self >= other || other.to_f64().is_nan() { self } else { other }
            }
            #[inline]
            fn min(self, other: Self) -> Self {
                if self <= other || other.to_f64().is_nan() { self } else { other }
            }
            fn clamp(self, min: Self, max: Self) -> Self {
                if self < min {
                    min
                } else if self > max {
                    max
                } else {
                    self
                }
            }
            fn atan2(self, other: Self) -> Self {
                self.arc_tangent(other)
            }
            fn min_value() -> Option<Self> {
                Some(Scalar::exact(f64::MIN))
            }
            fn max_value() -> Option<Self> {
                Some(Scalar::exact(f64::MAX))
            }
            fn pi() -> Self {
                Self::circle()
            }
            fn two_pi() -> Self {
                Self::circle() * Scalar::exact(2.0)
            }
            fn frac_pi_2() -> Self {
                Self::circle() * Scalar::exact(0.5)
            }
            fn frac_pi_3() -> Self {
                Self::circle() / Scalar::exact(3.0)
            }
            fn frac_pi_4() -> Self {
                Self::circle() * Scalar::exact(0.25)
            }
            fn frac_pi_6() -> Self {
                Self::circle() / Scalar::exact(6.0)
            }
            fn frac_pi_8() -> Self {
                Self::circle() * Scalar::exact(0.125)
            }
            fn frac_1_pi() -> Self {
                <Self as num_traits::One>::one() / Self::circle()
            }
            fn frac_2_pi() -> Self {
                <Self as Scalar>::exact(2.0) / Self::circle()
            }
            fn frac_2_sqrt_pi() -> Self {
                <Self as Scalar>::exact(2.0) / Self::circle().square_root()
            }
            fn e() -> Self {
                <Self as num_traits::One>::one().exponential()
            }
            fn log2_e() -> Self {
                <Self as num_traits::One>::one() / Self::log_two()
            }
            fn log10_e() -> Self {
                <Self as num_traits::One>::one() / <Self as Scalar>::exact(10.0).logarithm()
            }
            fn ln_2() -> Self {
                Self::log_two()
            }
            fn ln_10() -> Self {
                <Self as Scalar>::exact(10.0).logarithm()
            }
        }
    };
}
pub(crate) use real_field;
