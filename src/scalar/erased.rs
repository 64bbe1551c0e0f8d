//! Types that are generic over the scalar, behind pointers.
//!
//! A trait whose methods are generic over the scalar has no `dyn`; one whose parameter is the scalar has one for each. What stands behind
//! a pointer is kept once for each scalar that it is asked in.

use super::Scalar;
use nalgebra::SMatrix;
use std::any::Any;

/// Which of these is of type A: the one for the scalar in A. Callers assert that they ask in no other.
pub(crate) fn level<'a, A: 'static>(levels: &[&'a dyn Any]) -> &'a A {
    levels.iter().find_map(|level| level.downcast_ref()).expect("no more dual numbers are nested than was asserted")
}

/// The n×n matrix with these columns, and with `one` on the rest of the diagonal.
pub(crate) fn beside_one<S: Scalar, const N: usize>(block: &[S], n: usize, one: S) -> SMatrix<S, N, N> {
    SMatrix::from_fn(|row, column| match row.max(column) < n {
        true => block[column * n + row],
        false if row == column => one,
        false => S::zero(),
    })
}
