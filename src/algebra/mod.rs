//! Finite-dimensional real Lie algebras, given by structure constants.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/algebra.md"))]

use crate::scalar::loops::{self, heavy};
use crate::scalar::{Real, Scalar, finite};
use nalgebra::{DVectorView, RowSVector, SMatrix, SVector};

#[doc(hidden)]
pub mod brackets;
mod casimir;
pub mod catalogue;
pub mod elimination;
#[cfg(feature = "harness")]
pub(crate) mod families;
#[cfg(feature = "harness")]
mod invariants;
#[cfg(feature = "harness")]
pub(crate) mod known;
#[cfg(feature = "harness")]
mod matrices;
#[cfg(feature = "harness")]
pub(crate) mod rational;

pub use casimir::Casimir;
pub use catalogue::Entry;
#[cfg(feature = "harness")]
pub use families::AlgebraFamily;
#[cfg(feature = "harness")]
pub use invariants::{AlgebraClass, AlgebraInvariants};
#[cfg(feature = "harness")]
pub use matrices::{MatricesError, MatrixAlgebra};

/// A vector of g: N coordinates in the basis e_a, a column.
pub type Vector<S, const N: usize> = SVector<S, N>;

/// A covector of g*: N coordinates in the dual basis, a row.
pub type Covector<S, const N: usize> = RowSVector<S, N>;

/// A square matrix, of an endomorphism of g or of a group element.
pub type Matrix<S, const N: usize> = SMatrix<S, N, N>;

/// μ A, written out: a general product of matrices takes several times as long where N is small.
#[inline(always)]
pub(crate) fn pull<S: Scalar, const N: usize>(mu: &Covector<S, N>, a: &Matrix<S, N>) -> Covector<S, N> {
    if const { heavy::<S>() } {
        let mut image = Covector::<S, N>::zeros();
        loops::add_pulled(image.as_mut_slice(), mu.as_slice(), a.as_slice());
        return image;
    }
    Covector::<S, N>::from_fn(|_, j| (1..N).fold(mu[0] * a[(0, j)], |sum, i| sum + mu[i] * a[(i, j)]))
}

/// A ξ, written out.
#[inline(always)]
pub(crate) fn apply<S: Scalar, const N: usize>(a: &Matrix<S, N>, xi: &Vector<S, N>) -> Vector<S, N> {
    if const { heavy::<S>() } {
        return times(a, xi);
    }
    let mut image = Vector::<S, N>::from_fn(|i, _| a[(i, 0)] * xi[0]);
    for j in 1..N {
        for i in 0..N {
            image[i] += a[(i, j)] * xi[j];
        }
    }
    image
}

/// A ξ for constants A.
#[inline(always)]
pub(crate) fn apply_constants<T: Real, S: Scalar<Base = T>, const N: usize>(
    a: &Matrix<T, N>,
    xi: &Vector<S, N>,
) -> Vector<S, N> {
    if const { !heavy::<S>() } {
        return apply(&a.map(S::lift), xi);
    }
    let mut image = Vector::<S, N>::zeros();
    for (column, x) in a.as_slice().chunks_exact(N.max(1)).zip(xi.iter()) {
        loops::add_constants(image.as_mut_slice(), column, *x);
    }
    image
}

/// A B.
#[inline(always)]
pub(crate) fn times<S: Scalar, const R: usize, const K: usize, const C: usize>(
    a: &SMatrix<S, R, K>,
    b: &SMatrix<S, K, C>,
) -> SMatrix<S, R, C> {
    if const { !heavy::<S>() } {
        return a * b;
    }
    let mut product = SMatrix::<S, R, C>::zeros();
    loops::add_product(product.as_mut_slice(), a.as_slice(), b.as_slice(), R);
    product
}

/// ⟨μ, ξ⟩ = μ ξ.
pub fn pair<S: Scalar, const N: usize>(mu: &Covector<S, N>, xi: &Vector<S, N>) -> S {
    let mut sum = S::zero();
    for a in 0..N {
        sum += mu[a] * xi[a];
    }
    sum
}

/// Σ_a x_a y_a in the order of nalgebra's `dot`, which is much to compile in each of the dimensions; this is compiled once.
pub(crate) fn dot<S: Scalar>(x: &[S], y: &[S]) -> S {
    match (x, y) {
        ([a, b], [p, q]) => *a * *p + *b * *q,
        ([a, b, c], [p, q, r]) => *a * *p + *b * *q + *c * *r,
        ([a, b, c, d], [p, q, r, s]) => (*a * *p + *c * *r) + (*b * *q + *d * *s),
        _ => DVectorView::from_slice(x, x.len()).dot(&DVectorView::from_slice(y, y.len())),
    }
}

/// e_a, a < N.
pub(crate) fn basis_vector<S: Scalar, const N: usize>(a: usize) -> Vector<S, N> {
    Vector::from_fn(|b, _| if a == b { S::one() } else { S::zero() })
}

/// Why structure constants, a basis or matrices were refused. The fields count from 0, the messages from 1, as files do.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AlgebraError {
    /// C^c_ab + C^c_ba ≠ 0.
    #[error(
        "structure constants are not antisymmetric: C^{2}_{{{0} {1}}} + C^{2}_{{{1} {0}}} = {defect:e} (indices from 1)",
        .a + 1, .b + 1, .c + 1
    )]
    NotAntisymmetric {
        /// First lower index.
        a: usize,
        /// Second lower index.
        b: usize,
        /// Upper index.
        c: usize,
        /// C^c_ab + C^c_ba.
        defect: f64,
    },
    /// \[e_a, \[e_b, e_c\]\] + cyclic ≠ 0.
    #[error(
        "structure constants break the Jacobi identity for (e_{}, e_{}, e_{}): relative defect {defect:e} (indices from 1)",
        .a + 1, .b + 1, .c + 1
    )]
    Jacobi {
        /// First basis vector.
        a: usize,
        /// Second basis vector.
        b: usize,
        /// Third basis vector.
        c: usize,
        /// Largest component of the cyclic sum, relative to max|C|².
        defect: f64,
    },
    /// A structure constant or a basis entry is NaN or infinite.
    #[error("{what} is not finite")]
    NotFinite {
        /// What was not finite, with its indices.
        what: String,
    },
    /// The basis change is singular to working precision.
    #[error("the basis change is singular to working precision: its condition number is {condition:e}")]
    SingularBasis {
        /// Skeel's condition number; infinite when no pivot is left.
        condition: f64,
    },
    /// The matrices are linearly dependent to working precision.
    #[error(
        "the matrices are linearly dependent: of matrix {} only {remainder:e} of its size is left outside the span \
         of the ones before (matrices count from 1)",
        .index + 1
    )]
    Dependent {
        /// The first matrix in the span of those before it.
        index: usize,
        /// Frobenius norm of what is left, relative to that of the matrix.
        remainder: f64,
    },
    /// The span of the matrices is not closed under the commutator.
    #[error(
        "the matrices do not span a Lie algebra: the commutator of matrices {} and {} is off their span by \
         {defect:e} (bound {bound:e}; matrices count from 1)",
        .a + 1, .b + 1
    )]
    NotClosed {
        /// First matrix.
        a: usize,
        /// Second matrix.
        b: usize,
        /// Largest entry of the commutator minus its projection to the span.
        defect: f64,
        /// What rounding explains.
        bound: f64,
    },
    /// An algebra of the catalogue has another dimension than the type.
    #[error("the algebra {name} has dimension {dimension}, expected {expected}")]
    Dimension {
        /// Its name.
        name: String,
        /// Its dimension.
        dimension: usize,
        /// The dimension of the type.
        expected: usize,
    },
    /// The matrices of the type are too small for the representation.
    #[error("the algebra {name} is represented by {needed}×{needed} matrices, which do not fit in {size}×{size}")]
    MatrixSize {
        /// Name of the algebra.
        name: String,
        /// The size of its representation.
        needed: usize,
        /// The size of the type.
        size: usize,
    },
}

/// A Lie algebra of dimension N over `T`: its structure constants, validated.
///
/// ```
/// use euler_poincare::algebra::{AlgebraError, Casimir, Covector, Entry, LieAlgebra, Matrix, Vector, pair};
///
/// // By name, with its Casimirs: so(3), where |μ|² is kept.
/// let so3 = LieAlgebra::<f64, 3>::from_catalogue(&Entry::So3)?;
/// let (x, y) = (Vector::<f64, 3>::x(), Vector::<f64, 3>::y());
/// assert_eq!(so3.bracket(&x, &y), Vector::<f64, 3>::z());
/// let mu = Covector::<f64, 3>::new(1.0, 2.0, 3.0);
/// assert_eq!(pair(&so3.coad(&x, &mu), &y), pair(&mu, &so3.bracket(&x, &y)));
/// let casimirs: Vec<Casimir<f64, 3>> = Entry::So3.casimirs()?;
/// assert_eq!(pair(&so3.coad(&x, &mu), &casimirs[0].gradient(&mu)), 0.0);
/// assert_eq!(so3.killing(), Matrix::<f64, 3>::identity() * -2.0);
///
/// // By structure constants C^c_ab: [e_1, e_2] = e_2. They are checked.
/// let affine = LieAlgebra::<f64, 2>::new(|a, b, c| match (a, b, c) {
///     (0, 1, 1) => 1.0,
///     (1, 0, 1) => -1.0,
///     _ => 0.0,
/// })?;
/// assert_eq!(affine.constant(0, 1, 1), 1.0);
/// assert!(so3.is_unimodular() && !affine.is_unimodular());
/// let refused = LieAlgebra::<f64, 2>::new(|a, b, c| if (a, b, c) == (0, 1, 1) { 1.0 } else { 0.0 });
/// assert!(matches!(refused, Err(AlgebraError::NotAntisymmetric { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct LieAlgebra<T: Real, const N: usize> {
    /// `ad_basis[a]` is the matrix of ad_{e_a}: entry (c, b) is C^c_ab.
    ad_basis: [Matrix<T, N>; N],
}

impl<T: Real, const N: usize> LieAlgebra<T, N> {
    /// The algebra with C^c_ab = `constants(a, b, c)`.
    ///
    /// The constants may carry rounding errors: they are antisymmetrised (which changes nothing if they are
    /// antisymmetric already) so that [ξ, ξ] = 0 holds exactly.
    ///
    /// # Errors
    /// Non-finite entries; antisymmetry or the Jacobi identity off by more than rounding of the given constants:
    /// 64 N u max|C| and 64 N² u max|C|².
    pub fn new(constants: impl Fn(usize, usize, usize) -> T) -> Result<Self, AlgebraError> {
        let raw = Self { ad_basis: std::array::from_fn(|a| Matrix::from_fn(|c, b| constants(a, b, c))) };
        for (a, b, c) in triples::<N>() {
            if !raw.constant(a, b, c).all_finite() {
                return Err(AlgebraError::NotFinite {
                    what: format!("structure constant C^{}_{{{} {}}} (indices from 1)", c + 1, a + 1, b + 1),
                });
            }
        }
        raw.check_antisymmetry()?;
        let algebra = raw.antisymmetrised();
        algebra.check_jacobi()?;
        Ok(algebra)
    }

    /// For constants whose validity is known otherwise: no checks, antisymmetrised.
    pub(crate) fn unchecked(constants: impl Fn(usize, usize, usize) -> T) -> Self {
        Self { ad_basis: std::array::from_fn(|a| Matrix::from_fn(|c, b| constants(a, b, c))) }.antisymmetrised()
    }

    fn antisymmetrised(&self) -> Self {
        // Halves first: the difference of two large constants may overflow.
        let half = |a, b, c| self.constant(a, b, c) * T::half();
        Self { ad_basis: std::array::from_fn(|a| Matrix::from_fn(|c, b| half(a, b, c) - half(b, a, c))) }
    }

    /// max|C|.
    pub(crate) fn size(&self) -> T {
        triples::<N>().fold(T::zero(), |m, (a, b, c)| m.max(self.constant(a, b, c).abs()))
    }

    /// [g, g] = 0: every structure constant is zero (exactly: constants alone have no scale to compare with).
    pub fn is_abelian(&self) -> bool {
        self.size() == T::zero()
    }

    /// tr ad_ξ = 0 for all ξ, to √u max|C|: the groups of the algebra are unimodular (Milnor 1976, Lemma 6.3).
    pub fn is_unimodular(&self) -> bool {
        let negligible = T::unit_roundoff().sqrt() * self.size();
        self.ad_basis.iter().all(|ad| ad.trace().abs() <= negligible)
    }

    /// The Killing form K_ab = tr(ad_a ad_b) (Humphreys 1972, §5.1).
    pub fn killing(&self) -> Matrix<T, N> {
        Matrix::from_fn(|a, b| self.ad_basis[a].tr_dot(&self.ad_basis[b]))
    }

    fn check_antisymmetry(&self) -> Result<(), AlgebraError> {
        let bound = T::int(64 * N as i64) * T::unit_roundoff() * self.size();
        for (a, b, c) in triples::<N>() {
            let defect = self.constant(a, b, c) + self.constant(b, a, c);
            if defect.abs() > bound {
                return Err(AlgebraError::NotAntisymmetric { a, b, c, defect: defect.to_f64() });
            }
        }
        Ok(())
    }

    fn check_jacobi(&self) -> Result<(), AlgebraError> {
        // Scaled by a power of two to max|C| ≈ 1: products of tiny or huge constants would underflow or overflow.
        let Some(scale) = elimination::power_of_two(self.size().to_f64()) else { return Ok(()) };
        let scaled = Self { ad_basis: self.ad_basis.map(|ad| ad * T::exact(scale)) };
        let size = scaled.size();
        let bound = T::int(64 * (N * N) as i64) * T::unit_roundoff() * size * size;
        for (a, b, c) in triples::<N>().filter(|(a, b, c)| a < b && b < c) {
            let e = basis_vector;
            let term = |x, y, z| scaled.bracket::<T>(&e(x), &scaled.bracket(&e(y), &e(z)));
            let defect = (term(a, b, c) + term(b, c, a) + term(c, a, b)).amax();
            if defect > bound {
                return Err(AlgebraError::Jacobi { a, b, c, defect: (defect / (size * size)).to_f64() });
            }
        }
        Ok(())
    }

    /// C^c_ab.
    pub fn constant(&self, a: usize, b: usize, c: usize) -> T {
        self.ad_basis[a][(c, b)]
    }

    /// The matrix of ad_ξ: (ad_ξ)^c_b = C^c_ab ξ^a.
    pub fn ad<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Matrix<S, N> {
        let mut matrix = Matrix::<S, N>::zeros();
        if const { heavy::<S>() } {
            for a in 0..N {
                loops::add_constants(matrix.as_mut_slice(), self.ad_basis[a].as_slice(), xi[a]);
            }
            return matrix;
        }
        for a in 0..N {
            for b in 0..N {
                for c in 0..N {
                    matrix[(c, b)] += xi[a] * S::lift(self.ad_basis[a][(c, b)]);
                }
            }
        }
        matrix
    }

    /// Σ_ac A^c_a C^c_ab in component b: the contraction of the constants with the columns of A.
    pub(crate) fn contract<S: Scalar<Base = T>>(&self, columns: &Matrix<S, N>) -> Covector<S, N> {
        Covector::<S, N>::from_fn(|_, b| {
            let mut sum = S::zero();
            for a in 0..N {
                if const { heavy::<S>() } {
                    let (column, constants) = (columns.column(a), self.ad_basis[a].column(b));
                    let mut part = S::zero();
                    loops::add_sum(&mut part, column.as_slice(), constants.as_slice());
                    sum += part;
                } else {
                    for c in 0..N {
                        sum += columns[(c, a)] * S::lift(self.constant(a, b, c));
                    }
                }
            }
            sum
        })
    }

    /// [ξ, η] = ad_ξ η.
    pub fn bracket<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>, eta: &Vector<S, N>) -> Vector<S, N> {
        apply(&self.ad(xi), eta)
    }

    /// ad*_ξ μ = μ ad_ξ: in coordinates (ad*_η μ)_a = C^d_ba η^b μ_d.
    pub fn coad<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>, mu: &Covector<S, N>) -> Covector<S, N> {
        pull(mu, &self.ad(xi))
    }

    /// The same algebra in the basis e'_a = e_b B^b_a (the columns of `basis`), so that x = B x' and μ' = μ B.
    ///
    /// Relative error of the constants: a few N u times the condition number of B.
    ///
    /// # Errors
    /// A non-finite B, or one that is singular to working precision; overflow of the new constants.
    pub fn in_basis(&self, basis: &Matrix<T, N>) -> Result<Self, AlgebraError> {
        let inverse = elimination::regular_inverse(basis)?;
        let ad_basis = std::array::from_fn(|a| inverse * self.ad(&basis.column(a).into_owned()) * basis);
        let moved = Self { ad_basis };
        if moved.ad_basis.iter().any(|ad| !finite(ad.as_slice())) {
            return Err(AlgebraError::NotFinite { what: "a structure constant in the new basis".into() });
        }
        // Jacobi is inherited; antisymmetry would suffer from the rounding of B⁻¹.
        Ok(moved.antisymmetrised())
    }
}

/// All (a, b, c) below N.
fn triples<const N: usize>() -> impl Iterator<Item = (usize, usize, usize)> {
    (0..N * N * N).map(|k| (k / (N * N), k / N % N, k % N))
}
