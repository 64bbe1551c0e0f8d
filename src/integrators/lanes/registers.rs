//! Eight `f64` at once, in the widest registers that the processor has.
//!
//! Kernels are written once over [`Lanes`] and compiled for AVX-512, for AVX2
//! with FMA, and for plain arrays; [`Registers::detect`] chooses at run time, so that a program built without special flags
//! profits too.

use crate::scalar::Scalar;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A set of registers that hold eight `f64`.
#[doc(hidden)]
pub trait Isa: Copy + Send + Sync + 'static {
    /// Whether few processors that the program may run on have nothing better: kernels are then as short as they can be.
    const RARE: bool = false;

    /// Eight `f64`.
    type Eight: Copy;

    /// Runs a kernel as a function of its own, for these registers: no part of the caller, whose registers and stack it would spoil.
    fn apart<K: Kernel>(self, kernel: K) -> K::Output;
    /// The same number in every lane.
    fn splat(self, x: f64) -> Self::Eight;
    /// Reads eight numbers.
    fn load(self, x: &[f64; 8]) -> Self::Eight;
    /// Writes eight numbers.
    fn store(self, x: Self::Eight, out: &mut [f64; 8]);
    /// a + b.
    fn add(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    /// a − b.
    fn sub(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    /// a b.
    fn mul(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    /// a / b.
    fn div(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    /// 1 / a to an ulp or two, without the division where a processor has a fast start for Newton's iteration; a is positive,
    /// and so far from the ends of the range that 1 / a is normal.
    #[inline(always)]
    fn reciprocal(self, a: Self::Eight) -> Self::Eight {
        self.div(self.splat(1.0), a)
    }
    /// a b + c, rounded once where the processor can.
    fn mul_add(self, a: Self::Eight, b: Self::Eight, c: Self::Eight) -> Self::Eight;
    /// c − a b, rounded once where the processor can.
    fn neg_mul_add(self, a: Self::Eight, b: Self::Eight, c: Self::Eight) -> Self::Eight;
    /// a b − c, rounded once where the processor can.
    fn mul_sub(self, a: Self::Eight, b: Self::Eight, c: Self::Eight) -> Self::Eight;
    /// √a.
    fn sqrt(self, a: Self::Eight) -> Self::Eight;
    /// |a|.
    fn abs(self, a: Self::Eight) -> Self::Eight;
    /// The larger of each pair; of a NaN and a number, either.
    fn max(self, a: Self::Eight, b: Self::Eight) -> Self::Eight;
    /// The larger size of each pair; of a NaN and a number, either.
    #[inline(always)]
    fn max_abs(self, a: Self::Eight, b: Self::Eight) -> Self::Eight {
        self.max(self.abs(a), self.abs(b))
    }
    /// Whether a ≤ b in every lane: not where one of them is NaN.
    fn all_le(self, a: Self::Eight, b: Self::Eight) -> bool;
    /// The first of the eight.
    fn first(self, a: Self::Eight) -> f64;
    /// The sum of the eight.
    fn sum(self, a: Self::Eight) -> f64;
    /// The largest of the eight.
    fn largest(self, a: Self::Eight) -> f64;
}

/// Numbers of which eight are computed at once: what a stage formula, or a force in a fast kernel, is written over.
pub trait Lanes:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The number `x` in every lane, in registers of the same kind.
    fn constant(self, x: f64) -> Self;
    /// self · b + c.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// c − self · b.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// 1 / self to an ulp or two, for positive numbers far from the ends of the range.
    #[inline(always)]
    fn reciprocal(self) -> Self {
        self.constant(1.0) / self
    }
    /// √self.
    fn sqrt(self) -> Self;
    /// |self|.
    fn abs(self) -> Self;
    /// The larger of each pair.
    fn max(self, other: Self) -> Self;
    /// cos self.
    fn cos(self) -> Self;
    /// Eight numbers, in registers of the same kind.
    fn read(self, x: &[f64; 8]) -> Self;
    /// f(t, g, x) in each lane by itself: for formulas that are written over single numbers.
    #[doc(hidden)]
    fn one_by_one<F: Formula<N, D>, const N: usize, const D: usize>(
        f: &F,
        t: Self,
        g: [[Self; D]; D],
        x: [Self; N],
    ) -> [Self; N];
}

/// A formula for N numbers, of the time, the rows of a D×D matrix and N numbers, over any scalar.
#[doc(hidden)]
pub trait Formula<const N: usize, const D: usize> {
    /// f(t, g, x).
    fn value<S: Scalar<Base = f64>>(&self, t: S, g: [[S; D]; D], x: [S; N]) -> [S; N];
}

/// Methods of [`Eight`] that are those of its registers.
macro_rules! in_registers {
    ($($(#[$doc:meta])* $visibility:vis $name:ident($($x:ident),*);)*) => {$(
        $(#[$doc])*
        #[inline(always)]
        $visibility fn $name(self, $($x: Self),*) -> Self {
            Self { isa: self.isa, value: self.isa.$name(self.value, $($x.value),*) }
        }
    )*};
}

/// Eight numbers in registers of the kind `I`.
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct Eight<I: Isa> {
    isa: I,
    value: I::Eight,
}

impl<I: Isa> Eight<I> {
    /// The same number in every lane.
    #[inline(always)]
    pub fn splat(isa: I, x: f64) -> Self {
        Self { isa, value: isa.splat(x) }
    }

    /// Reads eight numbers.
    #[inline(always)]
    pub fn load(isa: I, x: &[f64; 8]) -> Self {
        Self { isa, value: isa.load(x) }
    }

    /// Writes eight numbers.
    #[inline(always)]
    pub fn store(self, out: &mut [f64; 8]) {
        self.isa.store(self.value, out);
    }

    in_registers! {
        /// self · b − c.
        pub mul_sub(b, c);
        /// The larger size of each pair.
        pub max_abs(other);
    }

    /// Whether self ≤ other in every lane: not where one of them is NaN.
    #[inline(always)]
    pub fn all_le(self, other: Self) -> bool {
        self.isa.all_le(self.value, other.value)
    }

    /// The first lane.
    #[inline(always)]
    pub fn first(self) -> f64 {
        self.isa.first(self.value)
    }

    /// The sum of the lanes.
    #[inline(always)]
    pub fn sum(self) -> f64 {
        self.isa.sum(self.value)
    }

    /// The largest of the lanes.
    #[inline(always)]
    pub fn largest(self) -> f64 {
        self.isa.largest(self.value)
    }
}

/// The operators of a number in lanes: methods of it by these names, on which the arithmetic is.
macro_rules! operators {
    ([$($generic:tt)*] $number:ty, $methods:ident) => {
        operators!([$($generic)*] $number, $methods: Add add, Sub sub, Mul mul, Div div);
    };
    ([$generic:ident: $bound:ident] $number:ty, $methods:ident: $($trait:ident $name:ident),*) => {$(
        impl<$generic: $bound> $trait for $number {
            type Output = Self;
            $methods! { $name(other); }
        }
    )*};
}

operators!([I: Isa] Eight<I>, in_registers);

impl<I: Isa> Neg for Eight<I> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::splat(self.isa, 0.0) - self
    }
}

impl<I: Isa> Lanes for Eight<I> {
    #[inline(always)]
    fn constant(self, x: f64) -> Self {
        Self::splat(self.isa, x)
    }

    in_registers! {
        mul_add(b, c);
        neg_mul_add(b, c);
        reciprocal();
        sqrt();
        abs();
        max(other);
    }

    #[inline(always)]
    fn cos(self) -> Self {
        let mut lanes = [0.0; 8];
        self.store(&mut lanes);
        for lane in &mut lanes {
            *lane = lane.cos();
        }
        Self::load(self.isa, &lanes)
    }

    #[inline(always)]
    fn read(self, x: &[f64; 8]) -> Self {
        Self::load(self.isa, x)
    }

    #[inline(always)]
    fn one_by_one<F: Formula<N, D>, const N: usize, const D: usize>(
        f: &F,
        t: Self,
        g: [[Self; D]; D],
        x: [Self; N],
    ) -> [Self; N] {
        let (mut times, mut entries, mut values) = ([0.0; 8], [[[0.0; 8]; D]; D], [[0.0; 8]; N]);
        t.store(&mut times);
        for r in 0..D {
            for c in 0..D {
                g[r][c].store(&mut entries[r][c]);
            }
        }
        for k in 0..N {
            x[k].store(&mut values[k]);
        }
        for lane in 0..8 {
            let (mut g, mut x) = ([[0.0; D]; D], [0.0; N]);
            for r in 0..D {
                for c in 0..D {
                    g[r][c] = entries[r][c][lane];
                }
            }
            for k in 0..N {
                x[k] = values[k][lane];
            }
            let value = f.value(times[lane], g, x);
            for k in 0..N {
                values[k][lane] = value[k];
            }
        }
        let mut out = x;
        for k in 0..N {
            out[k] = Self::load(t.isa, &values[k]);
        }
        out
    }
}

/// Two of a kind, side by side: one operation after the other on independent numbers keeps the processor busy.
#[derive(Clone, Copy)]
#[doc(hidden)]
pub struct Pair<V>(pub V, pub V);

/// Methods of [`Pair`] that are those of either.
macro_rules! of_either {
    ($($name:ident($($x:ident),*);)*) => {$(
        #[inline(always)]
        fn $name(self, $($x: Self),*) -> Self {
            Self(self.0.$name($($x.0),*), self.1.$name($($x.1),*))
        }
    )*};
}

operators!([V: Lanes] Pair<V>, of_either);

impl<V: Lanes> Neg for Pair<V> {
    type Output = Self;
    of_either! { neg(); }
}

impl<V: Lanes> Lanes for Pair<V> {
    #[inline(always)]
    fn constant(self, x: f64) -> Self {
        Self(self.0.constant(x), self.1.constant(x))
    }

    of_either! {
        mul_add(b, c);
        neg_mul_add(b, c);
        reciprocal();
        sqrt();
        abs();
        max(other);
        cos();
    }

    #[inline(always)]
    fn read(self, x: &[f64; 8]) -> Self {
        Self(self.0.read(x), self.1.read(x))
    }

    #[inline(always)]
    fn one_by_one<F: Formula<N, D>, const N: usize, const D: usize>(
        f: &F,
        t: Self,
        g: [[Self; D]; D],
        x: [Self; N],
    ) -> [Self; N] {
        let (mut first, mut second, mut out) = ([x[0].0; N], [x[0].1; N], x);
        for k in 0..N {
            (first[k], second[k]) = (x[k].0, x[k].1);
        }
        let (mut left, mut right) = ([[t.0; D]; D], [[t.1; D]; D]);
        for r in 0..D {
            for c in 0..D {
                (left[r][c], right[r][c]) = (g[r][c].0, g[r][c].1);
            }
        }
        let (first, second) = (V::one_by_one(f, t.0, left, first), V::one_by_one(f, t.1, right, second));
        for k in 0..N {
            out[k] = Self(first[k], second[k]);
        }
        out
    }
}

/// One lane: the numbers themselves, so that a force in lanes is also a force on any scalar.
#[derive(Clone, Copy)]
pub(in crate::integrators) struct One<S>(pub S);

/// Methods of [`One`] that are those of its number.
macro_rules! of_number {
    ($($name:ident($($x:ident),*);)*) => {$(
        #[inline]
        fn $name(self, $($x: Self),*) -> Self {
            Self(self.0.$name($($x.0),*))
        }
    )*};
}

operators!([S: Scalar] One<S>, of_number);

impl<S: Scalar> Neg for One<S> {
    type Output = Self;
    of_number! { neg(); }
}

impl<S: Scalar<Base = f64>> Lanes for One<S> {
    #[inline]
    fn constant(self, x: f64) -> Self {
        Self(S::exact(x))
    }

    #[inline]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(self.0 * b.0 + c.0)
    }

    #[inline]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self(c.0 - self.0 * b.0)
    }

    #[inline]
    fn sqrt(self) -> Self {
        // The derivative of √ at 0 is infinite: there a product with 0 must stay 0.
        if self.0 <= S::zero() { Self(S::zero()) } else { Self(self.0.sqrt()) }
    }

    of_number! {
        abs();
        cos();
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        if self.0 < other.0 { other } else { self }
    }

    #[inline]
    fn read(self, x: &[f64; 8]) -> Self {
        self.constant(x[0])
    }

    #[inline]
    fn one_by_one<F: Formula<N, D>, const N: usize, const D: usize>(
        f: &F,
        t: Self,
        g: [[Self; D]; D],
        x: [Self; N],
    ) -> [Self; N] {
        f.value(t.0, g.map(|row| row.map(|v| v.0)), x.map(|v| v.0)).map(One)
    }
}

/// Plain arrays: for every processor, and what the other kinds are tested against.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct Plain;

#[inline(always)]
fn fused(a: f64, b: f64, c: f64) -> f64 {
    // Where the target has no FMA, `mul_add` would be a call of a library.
    if cfg!(any(target_feature = "fma", target_arch = "aarch64")) { a.mul_add(b, c) } else { a * b + c }
}

/// The array of EXPR for k = 0 … 7, written out: a kernel has thousands of them, and as loops the compiler would take a
/// minute to unroll them all.
macro_rules! eight {
    ($k:ident => $e:expr) => {
        eight!($k => $e; 0 1 2 3 4 5 6 7)
    };
    ($k:ident => $e:expr; $($n:literal)*) => {
        [$({
            let $k = $n;
            $e
        }),*]
    };
}

/// Operations on single numbers as operations on eight.
macro_rules! number_by_number {
    ($($name:ident($($x:ident),+) => $value:expr;)*) => {$(
        #[cfg_attr(target_arch = "x86_64", inline(never))]
        #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
        fn $name(self, $($x: [f64; 8]),+) -> [f64; 8] {
            eight!(k => {
                $(let $x = $x[k];)+
                $value
            })
        }
    )*};
}

impl Isa for Plain {
    /// Ten times as much code as in registers, were the operations written in line: here they are calls where these processors are rare.
    const RARE: bool = cfg!(target_arch = "x86_64");

    type Eight = [f64; 8];

    #[inline(never)]
    fn apart<K: Kernel>(self, kernel: K) -> K::Output {
        kernel.run(self)
    }

    #[inline(always)]
    fn splat(self, x: f64) -> [f64; 8] {
        [x; 8]
    }

    #[inline(always)]
    fn load(self, x: &[f64; 8]) -> [f64; 8] {
        *x
    }

    #[inline(always)]
    fn store(self, x: [f64; 8], out: &mut [f64; 8]) {
        *out = x;
    }

    number_by_number! {
        add(a, b) => a + b;
        sub(a, b) => a - b;
        mul(a, b) => a * b;
        div(a, b) => a / b;
        mul_add(a, b, c) => fused(a, b, c);
        neg_mul_add(a, b, c) => fused(-a, b, c);
        mul_sub(a, b, c) => fused(a, b, -c);
        sqrt(a) => a.sqrt();
        abs(a) => a.abs();
        max(a, b) => if a > b { a } else { b };
    }

    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn all_le(self, a: [f64; 8], b: [f64; 8]) -> bool {
        let [p, q, r, s, t, u, v, w] = eight!(k => a[k] <= b[k]);
        p & q & r & s & t & u & v & w
    }

    #[inline(always)]
    fn first(self, a: [f64; 8]) -> f64 {
        a[0]
    }

    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn sum(self, a: [f64; 8]) -> f64 {
        ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]))
    }

    #[cfg_attr(target_arch = "x86_64", inline(never))]
    #[cfg_attr(not(target_arch = "x86_64"), inline(always))]
    fn largest(self, a: [f64; 8]) -> f64 {
        let larger = |m: f64, v: f64| if v > m || v.is_nan() { v } else { m };
        let [p, q, r, s, t, u, v, w] = a;
        larger(larger(larger(larger(larger(larger(larger(p, q), r), s), t), u), v), w)
    }
}

#[cfg(target_arch = "x86_64")]
mod x86 {
    use super::{Isa, Kernel, Within};
    use pulp::x86::{V3, V4};
    use pulp::{Simd, cast, f64x4, f64x8};

    /// Operations in one register, by their names there.
    macro_rules! in_one {
        ($($name:ident($($x:ident),+) => $instruction:ident;)*) => {$(
            #[inline(always)]
            fn $name(self, $($x: f64x8),+) -> f64x8 {
                self.$instruction($($x),+)
            }
        )*};
    }

    /// Operations in each of two registers.
    macro_rules! in_two {
        ($($name:ident($($x:ident),+) => $instruction:ident;)*) => {$(
            #[inline(always)]
            fn $name(self, $($x: [f64x4; 2]),+) -> [f64x4; 2] {
                [self.$instruction($($x[0]),+), self.$instruction($($x[1]),+)]
            }
        )*};
    }

    impl Isa for V4 {
        type Eight = f64x8;

        #[inline(always)]
        fn apart<K: Kernel>(self, kernel: K) -> K::Output {
            self.vectorize(Within { isa: self, kernel })
        }

        #[inline(always)]
        fn splat(self, x: f64) -> f64x8 {
            self.splat_f64x8(x)
        }

        #[inline(always)]
        fn load(self, x: &[f64; 8]) -> f64x8 {
            cast(*x)
        }

        #[inline(always)]
        fn store(self, x: f64x8, out: &mut [f64; 8]) {
            *out = cast(x);
        }

        in_one! {
            add(a, b) => add_f64s;
            sub(a, b) => sub_f64s;
            mul(a, b) => mul_f64s;
            div(a, b) => div_f64s;
            mul_add(a, b, c) => mul_add_f64x8;
            neg_mul_add(a, b, c) => negate_mul_add_f64x8;
            mul_sub(a, b, c) => mul_sub_f64x8;
            sqrt(a) => sqrt_f64x8;
            abs(a) => abs_f64x8;
            max(a, b) => max_f64s;
        }

        /// r of fourteen bits from a table; with e = 1 − a r, 1/a is r (1 + e)(1 + e²) to e⁴.
        #[inline(always)]
        fn reciprocal(self, a: f64x8) -> f64x8 {
            let r: f64x8 = cast(self.avx512f._mm512_rcp14_pd(cast(a)));
            let e = self.negate_mul_add_f64x8(a, r, self.splat_f64x8(1.0));
            let once = self.mul_add_f64x8(r, e, r);
            self.mul_add_f64x8(once, self.mul_f64s(e, e), once)
        }

        /// One instruction: the larger of two absolute values.
        #[inline(always)]
        fn max_abs(self, a: f64x8, b: f64x8) -> f64x8 {
            cast(self.avx512dq._mm512_range_pd::<0b1011>(cast(a), cast(b)))
        }

        #[inline(always)]
        fn all_le(self, a: f64x8, b: f64x8) -> bool {
            self.cmp_le_f64x8(a, b).0 == 0xff
        }

        #[inline(always)]
        fn first(self, a: f64x8) -> f64 {
            cast::<f64x8, [f64; 8]>(a)[0]
        }

        #[inline(always)]
        fn sum(self, a: f64x8) -> f64 {
            self.reduce_sum_f64s(a)
        }

        #[inline(always)]
        fn largest(self, a: f64x8) -> f64 {
            self.reduce_max_f64s(a)
        }
    }

    impl Isa for V3 {
        type Eight = [f64x4; 2];

        #[inline(always)]
        fn apart<K: Kernel>(self, kernel: K) -> K::Output {
            self.vectorize(Within { isa: self, kernel })
        }

        #[inline(always)]
        fn splat(self, x: f64) -> [f64x4; 2] {
            [self.splat_f64x4(x); 2]
        }

        #[inline(always)]
        fn load(self, x: &[f64; 8]) -> [f64x4; 2] {
            cast(*x)
        }

        #[inline(always)]
        fn store(self, x: [f64x4; 2], out: &mut [f64; 8]) {
            *out = cast(x);
        }

        in_two! {
            add(a, b) => add_f64s;
            sub(a, b) => sub_f64s;
            mul(a, b) => mul_f64s;
            div(a, b) => div_f64s;
            mul_add(a, b, c) => mul_add_f64x4;
            neg_mul_add(a, b, c) => negate_mul_add_f64x4;
            mul_sub(a, b, c) => mul_sub_f64x4;
            sqrt(a) => sqrt_f64x4;
            abs(a) => abs_f64x4;
            max(a, b) => max_f64s;
        }

        #[inline(always)]
        fn all_le(self, a: [f64x4; 2], b: [f64x4; 2]) -> bool {
            let both = self.and_m64s(self.cmp_le_f64x4(a[0], b[0]), self.cmp_le_f64x4(a[1], b[1]));
            self.avx._mm256_movemask_pd(cast(both)) == 0xf
        }

        #[inline(always)]
        fn first(self, a: [f64x4; 2]) -> f64 {
            cast::<f64x4, [f64; 4]>(a[0])[0]
        }

        #[inline(always)]
        fn sum(self, a: [f64x4; 2]) -> f64 {
            self.reduce_sum_f64s(self.add_f64s(a[0], a[1]))
        }

        #[inline(always)]
        fn largest(self, a: [f64x4; 2]) -> f64 {
            self.reduce_max_f64s(self.max_f64s(a[0], a[1]))
        }
    }
}

/// A computation that runs on any kind of registers.
#[doc(hidden)]
pub trait Kernel {
    /// What it returns.
    type Output;

    /// Runs it. Must be `#[inline(always)]`, and so must all that it calls, down to the arithmetic.
    fn run<I: Isa>(self, isa: I) -> Self::Output;
}

/// The kind of registers that this processor has.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub enum Registers {
    /// AVX-512: one register for eight numbers.
    #[cfg(target_arch = "x86_64")]
    Avx512(pulp::x86::V4),
    /// AVX2 with FMA: two.
    #[cfg(target_arch = "x86_64")]
    Avx2(pulp::x86::V3),
    /// No assumption.
    Plain,
}

impl Registers {
    /// The widest that this processor has.
    pub fn detect() -> Self {
        Self::all()[0]
    }

    /// Every kind that this processor has, the widest first: for tests that compare them.
    pub fn all() -> Vec<Self> {
        #[cfg(target_arch = "x86_64")]
        let wide = [pulp::x86::V4::try_new().map(Self::Avx512), pulp::x86::V3::try_new().map(Self::Avx2)];
        #[cfg(not(target_arch = "x86_64"))]
        let wide: [Option<Self>; 0] = [];
        wide.into_iter().flatten().chain([Self::Plain]).collect()
    }

    /// Runs a kernel in these registers.
    #[inline(always)]
    pub fn run<K: Kernel>(self, kernel: K) -> K::Output {
        match self {
            #[cfg(target_arch = "x86_64")]
            Self::Avx512(isa) => isa.apart(kernel),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2(isa) => isa.apart(kernel),
            Self::Plain => Plain.apart(kernel),
        }
    }
}

/// A kernel inside a function that is compiled for `isa`.
struct Within<I, K> {
    isa: I,
    kernel: K,
}

impl<I: Isa, K: Kernel> pulp::NullaryFnOnce for Within<I, K> {
    type Output = K::Output;

    #[inline(always)]
    fn call(self) -> K::Output {
        self.kernel.run(self.isa)
    }
}
