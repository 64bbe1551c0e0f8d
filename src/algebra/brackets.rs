//! Brackets in loops, by the structure constants that are not zero.

use super::LieAlgebra;
use crate::scalar::Real;
use crate::scalar::loops::{self, heavy};

/// The constants of an algebra for brackets in loops: so(4) has 24 of 216.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct Brackets<T> {
    /// (a, b, c), a < b, with C^c_ab ≠ 0.
    constants: Vec<([usize; 3], T)>,
}

impl<T: Real> Brackets<T> {
    /// Those of an algebra.
    pub fn of<const N: usize>(algebra: &LieAlgebra<T, N>) -> Self {
        let mut constants = Vec::new();
        for a in 0..N {
            for b in a + 1..N {
                for c in 0..N {
                    let constant = algebra.constant(a, b, c);
                    if constant != T::zero() {
                        constants.push(([a, b, c], constant));
                    }
                }
            }
        }
        Self { constants }
    }

    /// [x, y] of W pairs, component by component.
    #[inline]
    pub fn brackets<const N: usize, const W: usize>(&self, x: &[[T; W]; N], y: &[[T; W]; N]) -> [[T; W]; N] {
        let mut bracket = [[T::zero(); W]; N];
        if const { heavy::<T>() && W == 1 } {
            loops::add_brackets(bracket.as_flattened_mut(), &self.constants, x.as_flattened(), y.as_flattened());
            return bracket;
        }
        for &([a, b, c], constant) in &self.constants {
            let (xa, xb, ya, yb, sum) = (&x[a], &x[b], &y[a], &y[b], &mut bracket[c]);
            for w in 0..W {
                sum[w] += constant * (xa[w] * yb[w] - xb[w] * ya[w]);
            }
        }
        bracket
    }

    /// ad*_ξ μ of W pairs, component by component.
    #[inline]
    pub fn coads<const N: usize, const W: usize>(&self, xi: &[[T; W]; N], mu: &[[T; W]; N]) -> [[T; W]; N] {
        let mut row = [[T::zero(); W]; N];
        if const { heavy::<T>() && W == 1 } {
            loops::add_coadjoint(row.as_flattened_mut(), &self.constants, xi.as_flattened(), mu.as_flattened());
            return row;
        }
        for &([a, b, c], constant) in &self.constants {
            let scaled: [T; W] = std::array::from_fn(|w| constant * mu[c][w]);
            for w in 0..W {
                row[b][w] += scaled[w] * xi[a][w];
                row[a][w] -= scaled[w] * xi[b][w];
            }
        }
        row
    }
}
