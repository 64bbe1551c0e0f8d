//! Finite-dimensional real Lie algebras, given by structure constants.
//!
//! Conventions (crate-wide table in the crate docs): [e_a, e_b] = C^c_ab e_c; vectors of g are columns, covectors of g*
//! are rows, so ⟨μ, ξ⟩ = μ ξ and ad*_ξ μ = μ ad_ξ.

use crate::scalar::{Real, Scalar};
use nalgebra::{RowSVector, SMatrix, SVector};

/// A vector of g: N coordinates in the basis e_a, a column.
pub type Vector<S, const N: usize> = SVector<S, N>;

/// A covector of g*: N coordinates in the dual basis, a row.
pub type Covector<S, const N: usize> = RowSVector<S, N>;

/// A square matrix, of an endomorphism of g or of a group element.
pub type Matrix<S, const N: usize> = SMatrix<S, N, N>;

/// ⟨μ, ξ⟩ = μ ξ.
pub fn pair<S: Scalar, const N: usize>(mu: &Covector<S, N>, xi: &Vector<S, N>) -> S {
    let mut sum = S::zero();
    for a in 0..N {
        sum += mu[a] * xi[a];
    }
    sum
}

/// Why structure constants were refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AlgebraError {
    /// C^c_ab + C^c_ba ≠ 0.
    #[error("structure constants are not antisymmetric: C^{c}_{a}{b} + C^{c}_{b}{a} = {defect:e} (indices from 0)")]
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
    /// [e_a,[e_b,e_c]] + cyclic ≠ 0.
    #[error(
        "structure constants break the Jacobi identity for (e_{a}, e_{b}, e_{c}): defect {defect:e} (indices from 0)"
    )]
    Jacobi {
        /// First basis vector.
        a: usize,
        /// Second basis vector.
        b: usize,
        /// Third basis vector.
        c: usize,
        /// Largest component of the cyclic sum.
        defect: f64,
    },
    /// A structure constant or a basis entry is NaN or infinite.
    #[error("{what} is not finite")]
    NotFinite {
        /// What was not finite, with its indices.
        what: String,
    },
    /// The basis change is singular to working precision.
    #[error("the basis change is singular to working precision")]
    SingularBasis,
    /// A matrix basis is not closed under the commutator, or is linearly dependent.
    #[error("the matrices do not span a Lie algebra: {why}")]
    NotClosed {
        /// What failed, with numbers.
        why: String,
    },
}

/// A Lie algebra of dimension N over `T`: its structure constants, validated.
#[derive(Clone, Debug, PartialEq)]
pub struct LieAlgebra<T: Real, const N: usize> {
    /// `ad_basis[a]` is the matrix of ad_{e_a}: entry (c, b) is C^c_ab.
    ad_basis: [Matrix<T, N>; N],
}

impl<T: Real, const N: usize> LieAlgebra<T, N> {
    /// The algebra with C^c_ab = `constants(a, b, c)`.
    ///
    /// # Errors
    /// Non-finite entries; antisymmetry or the Jacobi identity off by more than rounding of the given constants,
    /// relative to their size (64 N u max|C| and 64 N² u max|C|²).
    pub fn new(constants: impl Fn(usize, usize, usize) -> T) -> Result<Self, AlgebraError> {
        let ad_basis: [Matrix<T, N>; N] = std::array::from_fn(|a| Matrix::from_fn(|c, b| constants(a, b, c)));
        let algebra = Self { ad_basis };
        let mut size = T::zero();
        for (a, ad) in algebra.ad_basis.iter().enumerate() {
            for b in 0..N {
                for c in 0..N {
                    if !ad[(c, b)].all_finite() {
                        return Err(AlgebraError::NotFinite { what: format!("structure constant C^{c}_{a}{b}") });
                    }
                    size = size.max(ad[(c, b)].abs());
                }
            }
        }
        let n = T::int(64 * N as i64);
        let unit = T::unit_roundoff();
        for a in 0..N {
            for b in 0..=a {
                for c in 0..N {
                    let defect = algebra.constant(a, b, c) + algebra.constant(b, a, c);
                    if defect.abs() > n * unit * size {
                        return Err(AlgebraError::NotAntisymmetric { a, b, c, defect: defect.to_f64() });
                    }
                }
            }
        }
        let bound = n * T::int(N as i64) * unit * size * size;
        for a in 0..N {
            for b in 0..a {
                for c in 0..b {
                    let defect = algebra.jacobi_defect(a, b, c);
                    if defect > bound {
                        return Err(AlgebraError::Jacobi { a, b, c, defect: defect.to_f64() });
                    }
                }
            }
        }
        Ok(algebra)
    }

    fn jacobi_defect(&self, a: usize, b: usize, c: usize) -> T {
        let e = |i: usize| Vector::<T, N>::from_fn(|r, _| if r == i { T::one() } else { T::zero() });
        let term = |x: usize, y: usize, z: usize| self.bracket(&e(x), &self.bracket(&e(y), &e(z)));
        (term(a, b, c) + term(b, c, a) + term(c, a, b)).iter().fold(T::zero(), |m, v| m.max(v.abs()))
    }

    /// C^c_ab.
    pub fn constant(&self, a: usize, b: usize, c: usize) -> T {
        self.ad_basis[a][(c, b)]
    }

    /// The matrix of ad_ξ: (ad_ξ)^c_b = C^c_ab ξ^a.
    pub fn ad<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Matrix<S, N> {
        let mut matrix = Matrix::<S, N>::zeros();
        for a in 0..N {
            for b in 0..N {
                for c in 0..N {
                    matrix[(c, b)] += xi[a] * S::lift(self.ad_basis[a][(c, b)]);
                }
            }
        }
        matrix
    }

    /// [ξ, η] = ad_ξ η.
    pub fn bracket<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>, eta: &Vector<S, N>) -> Vector<S, N> {
        self.ad(xi) * eta
    }

    /// ad*_ξ μ = μ ad_ξ: in coordinates (ad*_η μ)_a = C^d_ba η^b μ_d.
    pub fn coad<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>, mu: &Covector<S, N>) -> Covector<S, N> {
        mu * self.ad(xi)
    }

    /// The same algebra in the basis e'_a = e_b B^b_a (the columns of `basis`), so that x = B x' and μ' = μ B.
    ///
    /// # Errors
    /// A singular or non-finite basis.
    pub fn in_basis(&self, basis: &Matrix<T, N>) -> Result<Self, AlgebraError> {
        if basis.iter().any(|v| !v.all_finite()) {
            return Err(AlgebraError::NotFinite { what: "the basis change".into() });
        }
        let inverse = basis.try_inverse().ok_or(AlgebraError::SingularBasis)?;
        let ad_basis = std::array::from_fn(|a| inverse * self.ad(&basis.column(a).into_owned()) * basis);
        // Jacobi and antisymmetry are inherited; re-antisymmetrise so that rounding of B⁻¹ does not break [x, x] = 0.
        let raw = Self { ad_basis };
        let ad_basis = std::array::from_fn(|a| {
            Matrix::from_fn(|c, b| T::half() * (raw.constant(a, b, c) - raw.constant(b, a, c)))
        });
        Ok(Self { ad_basis })
    }
}
