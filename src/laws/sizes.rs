//! Sizes of terms, relative to which what cancels is judged.

use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::scalar::Real;

/// n max|C| |ξ| |μ|, which ad*_ξ μ does not exceed: the size of its terms, also where they cancel; n is the last index of a constant
/// that is not 0.
pub fn turning<T: Real, const N: usize>(algebra: &LieAlgebra<T, N>, xi: &Vector<T, N>, mu: &Covector<T, N>) -> T {
    let (mut largest, mut last) = (T::zero(), 0);
    for a in 0..N {
        for b in 0..N {
            for c in 0..N {
                let constant = algebra.constant(a, b, c).abs();
                if constant > T::zero() {
                    (largest, last) = (largest.max(constant), last.max(a).max(b).max(c));
                }
            }
        }
    }
    largest * xi.amax() * mu.amax() * T::int(last as i64 + 1)
}

/// Π_ab = −C^d_ab μ_d, and the largest sum of the absolute values of its terms.
pub fn poisson<T: Real, const N: usize>(algebra: &LieAlgebra<T, N>, mu: &Covector<T, N>) -> (Matrix<T, N>, T) {
    let terms = |a: usize, b: usize| (0..N).map(move |d| algebra.constant(a, b, d) * mu[d]);
    let pi = Matrix::from_fn(|a, b| terms(a, b).fold(T::zero(), |sum, term| sum - term));
    let sizes = (0..N * N).map(|k| terms(k / N, k % N).fold(T::zero(), |sum, term| sum + term.abs()));
    (pi, sizes.fold(T::zero(), |size, v| size.max(v)))
}

/// |f| + |ad*_η μ| (1 + |ad_η| + |ad*_· μ|), by their [`turning`]: the size of a force f and of the terms that it is made
/// of. Forces of one or two brackets with coefficients up to 1 may vanish identically (an isotropic body on so(3)), and
/// are then rounding of terms of this size.
pub fn forcing<T: Real, const N: usize>(
    algebra: &LieAlgebra<T, N>,
    force: &Covector<T, N>,
    eta: &Vector<T, N>,
    mu: &Covector<T, N>,
) -> T {
    let ones = (Vector::from_element(T::one()), Covector::from_element(T::one()));
    let further = turning(algebra, eta, &ones.1) + turning(algebra, &ones.0, mu);
    force.amax() + turning(algebra, eta, mu) * (T::one() + further)
}
