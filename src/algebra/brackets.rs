//! Brackets in loops, by the structure constants that are not zero or, in small dimensions, without a look at which are.

use super::{Covector, LieAlgebra, Vector};
use crate::scalar::Real;
use crate::scalar::loops::{self, heavy};

/// Up to this dimension all constants are taken for a single bracket, which the compiler unrolls: choosing costs more than it saves.
const SMALL: usize = 3;

/// Whether all constants are taken.
const fn takes_all<T: Real, const N: usize>() -> bool {
    N <= SMALL && !heavy::<T>()
}

/// The components of one vector, as those of one of several.
#[inline(always)]
fn one<T: Real, const N: usize>(values: &[T]) -> [[T; 1]; N] {
    std::array::from_fn(|a| [values[a]])
}

/// The constants of an algebra for brackets in loops: so(4) has 24 of 216.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Brackets<T> {
    /// (a, b, c), a < b, with C^c_ab ≠ 0.
    sparse: Vec<([usize; 3], T)>,
    /// C^c_ab at (a N + b) N + c, in small dimensions, and at (a N + c) N + b.
    dense: Vec<T>,
    transposed: Vec<T>,
}

impl<T: Real> Brackets<T> {
    /// Those of an algebra.
    pub fn of<const N: usize>(algebra: &LieAlgebra<T, N>) -> Self {
        let (mut sparse, mut dense, mut transposed) = (Vec::new(), Vec::new(), Vec::new());
        for a in 0..N {
            for b in 0..N {
                for c in 0..N {
                    let constant = algebra.constant(a, b, c);
                    if takes_all::<T, N>() {
                        dense.push(constant);
                        transposed.push(algebra.constant(a, c, b));
                    }
                    if a < b && constant != T::zero() {
                        sparse.push(([a, b, c], constant));
                    }
                }
            }
        }
        Self { sparse, dense, transposed }
    }

    /// [x, y].
    #[inline]
    pub fn bracket<const N: usize>(&self, x: &Vector<T, N>, y: &Vector<T, N>) -> Vector<T, N> {
        let bracket = self.brackets::<N, 1>(&one(x.as_slice()), &one(y.as_slice()));
        Vector::from_fn(|c, _| bracket[c][0])
    }

    /// ad*_ξ μ.
    #[inline]
    pub fn coad<const N: usize>(&self, xi: &Vector<T, N>, mu: &Covector<T, N>) -> Covector<T, N> {
        let row = self.coads::<N, 1>(&one(xi.as_slice()), &one(mu.as_slice()));
        Covector::from_fn(|_, c| row[c][0])
    }

    /// [x, y] of W pairs.
    #[inline]
    pub fn brackets<const N: usize, const W: usize>(&self, x: &[[T; W]; N], y: &[[T; W]; N]) -> [[T; W]; N] {
        let mut bracket = [[T::zero(); W]; N];
        if const { heavy::<T>() && W == 1 } {
            loops::add_brackets(bracket.as_flattened_mut(), &self.sparse, x.as_flattened(), y.as_flattened());
            return bracket;
        }
        if takes_all::<T, N>() && W == 1 {
            let constants = &self.dense[..N * N * N];
            for a in 0..N {
                for b in 0..N {
                    let product: [T; W] = std::array::from_fn(|w| x[a][w] * y[b][w]);
                    for c in 0..N {
                        let constant = constants[(a * N + b) * N + c];
                        for w in 0..W {
                            bracket[c][w] += constant * product[w];
                        }
                    }
                }
            }
            return bracket;
        }
        for &([a, b, c], constant) in &self.sparse {
            let (xa, xb, ya, yb, sum) = (&x[a], &x[b], &y[a], &y[b], &mut bracket[c]);
            for w in 0..W {
                sum[w] += constant * (xa[w] * yb[w] - xb[w] * ya[w]);
            }
        }
        bracket
    }

    /// ad*_ξ μ of W pairs.
    #[inline]
    pub fn coads<const N: usize, const W: usize>(&self, xi: &[[T; W]; N], mu: &[[T; W]; N]) -> [[T; W]; N] {
        let mut row = [[T::zero(); W]; N];
        if const { heavy::<T>() && W == 1 } {
            loops::add_coadjoint(row.as_flattened_mut(), &self.sparse, xi.as_flattened(), mu.as_flattened());
            return row;
        }
        if takes_all::<T, N>() && W == 1 {
            let constants = &self.transposed[..N * N * N];
            for a in 0..N {
                for c in 0..N {
                    let product: [T; W] = std::array::from_fn(|w| xi[a][w] * mu[c][w]);
                    for b in 0..N {
                        let constant = constants[(a * N + c) * N + b];
                        for w in 0..W {
                            row[b][w] += constant * product[w];
                        }
                    }
                }
            }
            return row;
        }
        for &([a, b, c], constant) in &self.sparse {
            let scaled: [T; W] = std::array::from_fn(|w| constant * mu[c][w]);
            for w in 0..W {
                row[b][w] += scaled[w] * xi[a][w];
                row[a][w] -= scaled[w] * xi[b][w];
            }
        }
        row
    }
}
