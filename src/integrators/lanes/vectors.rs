//! Vectors of three components in lanes.

use super::{Lanes, Vec3};

#[inline(always)]
pub(in crate::integrators) fn dot<V: Lanes>(x: Vec3<V>, y: Vec3<V>) -> V {
    x[2].mul_add(y[2], x[1].mul_add(y[1], x[0] * y[0]))
}

#[inline(always)]
pub(in crate::integrators) fn cross<V: Lanes>(x: Vec3<V>, y: Vec3<V>) -> Vec3<V> {
    [x[2].neg_mul_add(y[1], x[1] * y[2]), x[0].neg_mul_add(y[2], x[2] * y[0]), x[1].neg_mul_add(y[0], x[0] * y[1])]
}

/// sum + x × y.
#[inline(always)]
pub(in crate::integrators) fn add_cross<V: Lanes>(sum: Vec3<V>, x: Vec3<V>, y: Vec3<V>) -> Vec3<V> {
    [
        x[1].mul_add(y[2], x[2].neg_mul_add(y[1], sum[0])),
        x[2].mul_add(y[0], x[0].neg_mul_add(y[2], sum[1])),
        x[0].mul_add(y[1], x[1].neg_mul_add(y[0], sum[2])),
    ]
}

/// x + α y.
#[inline(always)]
pub(in crate::integrators) fn add_scaled<V: Lanes>(x: Vec3<V>, alpha: V, y: Vec3<V>) -> Vec3<V> {
    [alpha.mul_add(y[0], x[0]), alpha.mul_add(y[1], x[1]), alpha.mul_add(y[2], x[2])]
}

/// x − α y.
#[inline(always)]
pub(in crate::integrators) fn less_scaled<V: Lanes>(x: Vec3<V>, alpha: V, y: Vec3<V>) -> Vec3<V> {
    [alpha.neg_mul_add(y[0], x[0]), alpha.neg_mul_add(y[1], x[1]), alpha.neg_mul_add(y[2], x[2])]
}

#[inline(always)]
pub(in crate::integrators) fn scale<V: Lanes>(alpha: V, x: Vec3<V>) -> Vec3<V> {
    [alpha * x[0], alpha * x[1], alpha * x[2]]
}

/// η = I⁻¹ m.
#[inline]
pub(in crate::integrators) fn velocity<const N: usize>(inverse: &[[f64; N]; N], m: [f64; N]) -> [f64; N] {
    each!(N, r => (1..N).fold(inverse[r][0] * m[0], |sum, c| sum + inverse[r][c] * m[c]))
}

#[inline]
pub(in crate::integrators) fn length<const N: usize>(x: [f64; N]) -> f64 {
    x.iter().fold(0.0, |sum, v| sum + v * v).sqrt()
}

/// The first three components: those of rotations.
#[inline(always)]
pub(in crate::integrators) fn first<V: Lanes, const N: usize>(x: [V; N]) -> Vec3<V> {
    [x[0], x[1], x[2]]
}

/// The last three: on SE(3) those of translations.
#[inline(always)]
pub(in crate::integrators) fn last<V: Lanes, const N: usize>(x: [V; N]) -> Vec3<V> {
    [x[N - 3], x[N - 2], x[N - 1]]
}

/// Components of rotations, and of translations where there are any.
#[inline(always)]
pub(in crate::integrators) fn join<V: Lanes, const N: usize>(turning: Vec3<V>, moving: Vec3<V>) -> [V; N] {
    each!(N, k => if k < 3 { turning[k] } else { moving[k - 3] })
}

#[inline(always)]
pub(in crate::integrators) fn horner<V: Lanes, const K: usize>(terms: &[f64; K], u: V) -> V {
    let mut sum = u.constant(terms[K - 1]);
    for k in (0..K - 1).rev() {
        sum = sum.mul_add(u, u.constant(terms[k]));
    }
    sum
}
