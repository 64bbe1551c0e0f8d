//! Scalars without their type: lists of numbers of one [`Real`], with how many dual numbers are nested.
//!
//! A trait whose methods are generic over the scalar has no `dyn`. What stands behind a pointer takes and returns numbers instead.

use super::Scalar;
use nalgebra::SMatrix;

/// The numbers of `values`.
pub(crate) fn numbers<S: Scalar>(values: &[S]) -> Vec<S::Base> {
    let mut numbers = Vec::with_capacity(values.len() << S::NESTING);
    values.iter().for_each(|value| value.write(&mut numbers));
    numbers
}

/// The k-th scalar of `numbers`.
pub(crate) fn scalar<S: Scalar>(numbers: &[S::Base], k: usize) -> S {
    S::read(numbers.get(k << S::NESTING..).unwrap_or(&[]))
}

/// The matrix of `numbers`, by columns.
pub(crate) fn matrix<S: Scalar, const R: usize, const C: usize>(numbers: &[S::Base]) -> SMatrix<S, R, C> {
    SMatrix::from_fn(|row, column| scalar(numbers, column * R + row))
}

/// The n×n matrix of these numbers with `one` on the rest of the diagonal.
pub(crate) fn beside_one<S: Scalar, const N: usize>(block: &[S::Base], n: usize, one: S) -> SMatrix<S, N, N> {
    SMatrix::from_fn(|row, column| match row.max(column) < n {
        true => scalar(block, column * n + row),
        false if row == column => one,
        false => S::zero(),
    })
}

/// The value of a method in the scalar with `$nesting` nested dual numbers: at most as many as the range says. Callers assert that they
/// ask for no more; fewer are less to compile.
macro_rules! in_scalar {
    (0..=1, $nesting:expr, $t:ident, $value:expr, $method:ident($($argument:expr),*)) => {{
        debug_assert!($nesting <= 1);
        match $nesting {
            0 => $value.$method::<$t>($($argument),*),
            _ => $value.$method::<$crate::scalar::Dual<$t>>($($argument),*),
        }
    }};
    (0..=2, $nesting:expr, $t:ident, $value:expr, $method:ident($($argument:expr),*)) => {{
        debug_assert!($nesting <= 2);
        match $nesting {
            0 => $value.$method::<$t>($($argument),*),
            1 => $value.$method::<$crate::scalar::Dual<$t>>($($argument),*),
            _ => $value.$method::<$crate::scalar::Dual<$crate::scalar::Dual<$t>>>($($argument),*),
        }
    }};
}
pub(crate) use in_scalar;
