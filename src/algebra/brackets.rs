//! Brackets in loops, by the structure constants that are not zero or, in small dimensions, without a look at which are.

use super::{Covector, LieAlgebra, Vector};
use crate::scalar::Real;
use crate::scalar::loops::{self, heavy};

/// Up to this dimension all constants are taken, which the compiler unrolls: choosing costs more than it saves.
const SMALL: usize = 3;

/// Whether all constants are taken.
const fn takes_all<T: Real, const N: usize>() -> bool {
    N <= SMALL && !heavy::<T>()
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
                    } else if a < b && constant != T::zero() {
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
        let mut bracket = Vector::<T, N>::zeros();
        if const { heavy::<T>() } {
            loops::add_brackets(bracket.as_mut_slice(), &self.sparse, x.as_slice(), y.as_slice());
            return bracket;
        }
        if takes_all::<T, N>() {
            let constants = &self.dense[..N * N * N];
            for a in 0..N {
                for b in 0..N {
                    let product = x[a] * y[b];
                    for c in 0..N {
                        bracket[c] += constants[(a * N + b) * N + c] * product;
                    }
                }
            }
            return bracket;
        }
        for &([a, b, c], constant) in &self.sparse {
            bracket[c] += constant * (x[a] * y[b] - x[b] * y[a]);
        }
        bracket
    }

    /// ad*_ξ μ.
    #[inline]
    pub fn coad<const N: usize>(&self, xi: &Vector<T, N>, mu: &Covector<T, N>) -> Covector<T, N> {
        let mut row = Covector::<T, N>::zeros();
        if const { heavy::<T>() } {
            loops::add_coadjoint(row.as_mut_slice(), &self.sparse, xi.as_slice(), mu.as_slice());
            return row;
        }
        if takes_all::<T, N>() {
            let constants = &self.transposed[..N * N * N];
            for a in 0..N {
                for c in 0..N {
                    let product = xi[a] * mu[c];
                    for b in 0..N {
                        row[b] += constants[(a * N + c) * N + b] * product;
                    }
                }
            }
            return row;
        }
        for &([a, b, c], constant) in &self.sparse {
            let scaled = constant * mu[c];
            row[b] += scaled * xi[a];
            row[a] -= scaled * xi[b];
        }
        row
    }
}
