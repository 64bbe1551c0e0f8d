//! Runge–Kutta tableaux as data, their families, and their orders computed from the coefficients.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/tableau.md"))]
//!
//! [`Description`] is what a person writes, [`Tableau`] the numbers in some scalar. [`order`] computes the orders over [`trees`].
//! With the feature `harness`, `analyse` says everything that can be decided about a tableau, and why, in exact rationals if its
//! entries are rational.

#[cfg(feature = "harness")]
pub mod analysis;
pub mod assumptions;
pub mod bounds;
#[cfg(feature = "harness")]
pub mod completion;
pub mod description;
#[cfg(feature = "harness")]
pub mod exact;
pub mod failing;
pub mod families;
#[cfg(feature = "harness")]
pub mod file;
#[cfg(feature = "harness")]
mod findings;
#[cfg(feature = "harness")]
pub mod known;
pub mod order;
pub mod quantity;
#[cfg(feature = "harness")]
pub mod random;
#[cfg(feature = "harness")]
pub mod stability;
pub mod structure;
pub mod trees;

#[cfg(feature = "harness")]
pub use analysis::{Analysis, analyse};
pub use description::{Description, Entries};
pub(crate) use families::legendre;
pub use families::{Classic, Family};
#[cfg(feature = "harness")]
pub use file::{FileError, TableauFile};
pub use order::{Order, classical_order, variational_order};

use crate::scalar::Real;
use nalgebra::{DMatrix, DVector};

/// Why a tableau was refused; every variant names the entry (indices from 1, as on paper).
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum TableauError {
    /// No stages.
    #[error("a tableau needs at least one stage")]
    Empty,
    /// a is not s×s.
    #[error("row {row} of a has {found} entries, but b has {stages} (a must be {stages}×{stages})")]
    RowLength {
        /// The row, from 1.
        row: usize,
        /// Entries found.
        found: usize,
        /// Length of b.
        stages: usize,
    },
    /// a has another number of rows than b has entries.
    #[error("a has {found} rows, but b has {stages} entries (a must be {stages}×{stages})")]
    RowCount {
        /// Rows found.
        found: usize,
        /// Length of b.
        stages: usize,
    },
    /// b_i = 0: the scheme divides by every weight.
    #[error("b_{stage} = 0: every weight must be non-zero, because the conjugate a-hat divides by it")]
    ZeroWeight {
        /// The stage, from 1.
        stage: usize,
    },
    /// An entry is not finite.
    #[error("entry {entry} is not finite")]
    NotFinite {
        /// For example `a_12` or `b_3`.
        entry: String,
    },
    /// An entry could not be read.
    #[error("entry {entry}: {why}")]
    BadEntry {
        /// For example `a_12` or `b_3`.
        entry: String,
        /// What is wrong, and what is allowed.
        why: String,
    },
    /// Σ b ≠ 1.
    #[error("the weights b sum to {}, not to 1", near_one(*.excess))]
    Inconsistent {
        /// Σ b − 1.
        excess: f64,
    },
    /// A family has no member with this many stages, or no family has this name.
    #[error("{name}: {why}")]
    Unknown {
        /// The name asked for.
        name: String,
        /// What is allowed.
        why: String,
    },
}

/// A Runge–Kutta tableau with s stages over `T`; c_i = Σ_j a_ij is derived.
///
/// ```
/// use euler_poincare::tableau::{Classic, Description, Family, Order, Tableau, TableauError, classical_order, variational_order};
///
/// let rk4: Tableau<f64> = Classic::Rk4.tableau()?;
/// assert_eq!(classical_order(&rk4, 6).order, 4);
/// // Ralston's method has order 3 as a Runge–Kutta method, and order 2 in the variational scheme.
/// let ralston: Tableau<f64> = "ralston3".parse::<Description>()?.build()?;
/// let order: Order = variational_order(&ralston, 6);
/// assert_eq!((classical_order(&ralston, 6).order, order.order), (3, 2));
/// let broken = order.broken.expect("a condition of order 3");
/// assert!(broken.defect.abs() > broken.tolerance);
/// // Gauss methods are their own conjugates: â = a.
/// let gauss = Family::Gauss.tableau::<f64>(3)?;
/// assert!((gauss.conjugate().a() - gauss.a()).amax() < 1e-15);
/// // Each b_i divides.
/// let refused = Tableau::new(&[vec![0.0, 0.0], vec![0.5, 0.0]], &[0.0, 1.0]);
/// assert_eq!(refused, Err(TableauError::ZeroWeight { stage: 1 }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Tableau<T: Real> {
    a: DMatrix<T>,
    b: DVector<T>,
    c: DVector<T>,
}

impl<T: Real> Tableau<T> {
    /// The tableau with coefficients `a` (by rows) and weights `b`.
    ///
    /// # Errors
    /// Wrong shape, b_i = 0, non-finite entries, Σb ≠ 1 (beyond 64 s u Σ|b|).
    pub fn new(a: &[Vec<T>], b: &[T]) -> Result<Self, TableauError> {
        check_entries(a, b, |x| x.all_finite(), |w| *w == T::zero())?;
        let s = b.len();
        let (sum, size) = b.iter().fold((T::zero(), T::zero()), |(sum, size), &w| (sum + w, size + w.abs()));
        if (sum - T::one()).abs() > T::int(64 * s as i64) * T::unit_roundoff() * size {
            return Err(TableauError::Inconsistent { excess: (sum - T::one()).to_f64() });
        }
        let a = DMatrix::from_fn(s, s, |i, j| a[i][j]);
        let c = DVector::from_fn(s, |i, _| a.row(i).iter().fold(T::zero(), |x, &y| x + y));
        Ok(Self { a, b: DVector::from_column_slice(b), c })
    }

    /// s.
    pub fn stages(&self) -> usize {
        self.b.len()
    }

    /// a_ij, indices from 0.
    pub fn a(&self) -> &DMatrix<T> {
        &self.a
    }

    /// b_j.
    pub fn b(&self) -> &DVector<T> {
        &self.b
    }

    /// c_i = Σ_j a_ij.
    pub fn c(&self) -> &DVector<T> {
        &self.c
    }

    /// The symplectic conjugate â_ij = b_j − b_j a_ji / b_i, with the same weights.
    pub fn conjugate(&self) -> Self {
        let s = self.stages();
        let a = DMatrix::from_fn(s, s, |i, j| self.b[j] - self.b[j] * self.a[(j, i)] / self.b[i]);
        let c = DVector::from_fn(s, |i, _| a.row(i).iter().fold(T::zero(), |x, &y| x + y));
        Self { a, b: self.b.clone(), c }
    }
}

/// Refuses an a that is not s×s, entries that are not finite, and weights that are 0.
fn check_entries<F>(
    a: &[Vec<F>],
    b: &[F],
    is_finite: impl Fn(&F) -> bool,
    is_zero: impl Fn(&F) -> bool,
) -> Result<(), TableauError> {
    let s = b.len();
    if s == 0 {
        return Err(TableauError::Empty);
    }
    if a.len() != s {
        return Err(TableauError::RowCount { found: a.len(), stages: s });
    }
    for (i, row) in a.iter().enumerate() {
        if row.len() != s {
            return Err(TableauError::RowLength { row: i + 1, found: row.len(), stages: s });
        }
        if let Some(j) = row.iter().position(|x| !is_finite(x)) {
            return Err(TableauError::NotFinite { entry: entry_name(i, j) });
        }
    }
    for (j, w) in b.iter().enumerate() {
        if !is_finite(w) {
            return Err(TableauError::NotFinite { entry: format!("b_{}", j + 1) });
        }
        if is_zero(w) {
            return Err(TableauError::ZeroWeight { stage: j + 1 });
        }
    }
    Ok(())
}

/// Numbers closer than this are told apart by their difference.
const ALIKE: f64 = 1e-9;

/// 1 + `excess`, so that it is not read as 1.
fn near_one(excess: f64) -> String {
    let sign = if excess < 0.0 { '-' } else { '+' };
    if excess.abs() < ALIKE { format!("1 {sign} {:e}", excess.abs()) } else { (1.0 + excess).to_string() }
}

/// `a_12`, with a comma where an index has two digits; indices from 0.
fn entry_name(i: usize, j: usize) -> String {
    let comma = if i.max(j) > 8 { "," } else { "" };
    format!("a_{}{comma}{}", i + 1, j + 1)
}
