//! The groups of the catalogue as types of their own, whose matrices are known when a program is compiled.

use super::{LieGroup, MatrixGroup};
use crate::algebra::catalogue::{Entries, Entry, named};
use crate::algebra::{LieAlgebra, Matrix, Vector};
use crate::scalar::{Real, Scalar};

/// The matrices of an entry of the catalogue.
pub(super) const fn basis<const N: usize, const D: usize>(entries: &[Entries]) -> [[[i8; D]; D]; N] {
    let (mut basis, mut a) = ([[[0; D]; D]; N], 0);
    while a < N {
        let mut k = 0;
        while k < entries[a].len() {
            let (r, c, value) = entries[a][k];
            basis[a][r][c] = value as i8;
            k += 1;
        }
        a += 1;
    }
    basis
}

macro_rules! known {
    ($($(#[$doc:meta])* $name:ident, $n:literal, $d:literal;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Debug, PartialEq)]
        pub struct $name<T: Real>(MatrixGroup<T, $n, $d>);

        impl<T: Real> $name<T> {
            /// The group.
            pub fn new() -> Self {
                Self(MatrixGroup::from_entry(&Entry::$name).expect("an entry of this dimension, with matrices of this size"))
            }
        }

        impl<T: Real> Default for $name<T> {
            fn default() -> Self {
                Self::new()
            }
        }

        impl<T: Real> LieGroup<T, $n, $d> for $name<T> {
            const BASIS: Option<[[[i8; $d]; $d]; $n]> = Some(basis(named::$name.matrices));

            fn algebra(&self) -> &LieAlgebra<T, $n> {
                self.0.algebra()
            }

            fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, $n>) -> Matrix<S, $d> {
                self.0.hat(xi)
            }

            fn vee<S: Scalar<Base = T>>(&self, matrix: &Matrix<S, $d>) -> Vector<S, $n> {
                self.0.vee(matrix)
            }

            fn inverse<S: Scalar<Base = T>>(&self, g: &Matrix<S, $d>) -> Option<Matrix<S, $d>> {
                self.0.inverse(g)
            }
        }
    )*};
}

known! {
    /// SE(2), the motions of the plane: a rotation, then the translations, as [`Entry::Se2`].
    Se2, 3, 3;
    /// SE(3), the motions of space: rotations, then translations, as [`Entry::Se3`].
    Se3, 6, 4;
    /// SL(2, ℝ), as [`Entry::Sl2`].
    Sl2, 3, 2;
    /// SO(4), as [`Entry::So4`].
    So4, 6, 4;
    /// The affine maps of the line, as [`Entry::Aff1`].
    Aff1, 2, 2;
    /// The Heisenberg group, as [`Entry::Heisenberg`].
    Heisenberg, 3, 3;
}
