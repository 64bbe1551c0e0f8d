//! The catalogue: algebras known by name, each with structure constants, a faithful matrix representation and Casimirs.
//!
//! All of these are small integers, so they are exact over every scalar. Bases (indices from 0, E_ij the matrix with a
//! single 1 at row i, column j):
//!
//! | name | basis | brackets | matrices |
//! |---|---|---|---|
//! | `r1`, `r2`, … | translations | 0 | (n+1)×(n+1): E_{a,n} |
//! | `so3` | rotations J_i | \[J_i, J_j\] = ε_ijk J_k | 3×3: J_i x = e_i × x |
//! | `se2` | J, P_0, P_1 | \[J, P_0\] = P_1, \[J, P_1\] = −P_0 | 3×3: J = E_10 − E_01, P_i = E_i2 |
//! | `se3` | J_0, J_1, J_2, then P_0, P_1, P_2 | \[J_i, J_j\] = ε_ijk J_k, \[J_i, P_j\] = ε_ijk P_k | 4×4 |
//! | `sl2` | H, E, F | \[H, E\] = 2E, \[H, F\] = −2F, \[E, F\] = H | 2×2: diag(1, −1), E_01, E_10 |
//! | `aff1` | dilation X, translation Y | \[X, Y\] = Y | 2×2: E_00, E_01 |
//! | `heisenberg` | X, Y, Z | \[X, Y\] = Z | 3×3: E_01, E_12, E_02 |
//! | `so4` | J_i, then K_i in the planes (i, 3) | as `se3`, and \[K_i, K_j\] = ε_ijk J_k | 4×4: K_i = E_i3 − E_3i |
//!
//! Products are written with `+`, as in `so3+r2`: bases one after the other, matrices block-diagonal.

use super::{AlgebraError, Casimir, LieAlgebra};
use crate::scalar::Real;
use nalgebra::DMatrix;
use std::fmt;
use std::str::FromStr;

/// The largest n for which `rn` is a name.
pub const MAX_ABELIAN: usize = 64;

/// The names that stand for one algebra each.
pub(crate) const NAMES: &str = "so3, se2, se3, sl2, aff1, heisenberg, so4";

/// An algebra of the catalogue, in its standard basis (see the [module](self)).
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Entry {
    /// ℝⁿ.
    Abelian(usize),
    /// so(3), rotations of space.
    So3,
    /// se(2), motions of the plane.
    Se2,
    /// se(3), motions of space; rotations first.
    Se3,
    /// sl(2, ℝ), 2×2 matrices of trace 0.
    Sl2,
    /// aff(1), affine maps of the line; not unimodular.
    Aff1,
    /// The Heisenberg algebra of dimension 3; nilpotent.
    Heisenberg,
    /// so(4), rotations of four-space.
    So4,
    /// The direct product; write nested ones flat where names matter, since a name parses to the flat form.
    Product(Vec<Entry>),
}

/// A name that is not in the catalogue.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown algebra {name:?}: allowed are r1 to r{MAX_ABELIAN}, {NAMES}, and products of these with `+`, as in so3+r2"
)]
#[non_exhaustive]
pub struct UnknownName {
    /// The factor that was not recognised.
    pub name: String,
}

/// A Casimir in the standard basis: monomials, each the indices of its factors, with their coefficients.
type Form = Vec<(Vec<usize>, i64)>;

/// ε_ijk for indices 0, 1, 2.
fn levi_civita(i: usize, j: usize, k: usize) -> i64 {
    let (i, j, k) = (i as i64, j as i64, k as i64);
    (j - i) * (k - j) * (k - i) / 2
}

/// The factors of a product, each after the place of its first basis vector and that of its block of matrices.
pub(crate) fn placed(factors: &[Entry]) -> impl Iterator<Item = (usize, usize, &Entry)> {
    factors.iter().scan((0, 0), |(first, corner), factor| {
        let at = (*first, *corner, factor);
        (*first, *corner) = (*first + factor.dimension(), *corner + factor.matrix_size());
        Some(at)
    })
}

/// That with e_a.
fn holding(factors: &[Entry], a: usize) -> Option<(usize, usize, &Entry)> {
    placed(factors).find(|(first, _, factor)| a < first + factor.dimension())
}

impl Entry {
    /// n = dim g.
    pub fn dimension(&self) -> usize {
        match self {
            Self::Abelian(n) => *n,
            Self::Aff1 => 2,
            Self::So3 | Self::Se2 | Self::Sl2 | Self::Heisenberg => 3,
            Self::Se3 | Self::So4 => 6,
            Self::Product(factors) => factors.iter().map(Self::dimension).sum(),
        }
    }

    /// The size of the representing matrices.
    pub fn matrix_size(&self) -> usize {
        match self {
            Self::Abelian(n) => n + 1,
            Self::Sl2 | Self::Aff1 => 2,
            Self::So3 | Self::Se2 | Self::Heisenberg => 3,
            Self::Se3 | Self::So4 => 4,
            Self::Product(factors) => factors.iter().map(Self::matrix_size).sum(),
        }
    }

    /// C^c_ab, with [e_a, e_b] = C^c_ab e_c; zero for an index out of range.
    pub fn constant<T: Real>(&self, a: usize, b: usize, c: usize) -> T {
        T::int(self.integer_constant(a, b, c))
    }

    fn integer_constant(&self, a: usize, b: usize, c: usize) -> i64 {
        if a > b {
            return -self.integer_constant(b, a, c);
        }
        if a == b || b.max(c) >= self.dimension() {
            return 0;
        }
        match (self, (a, b, c)) {
            (Self::So3 | Self::Se3 | Self::So4, _) => {
                // e_a = J_i for a = i, P_i or K_i for a = 3 + i; ΣP counts the P or K.
                let count = a / 3 + b / 3;
                let kind = if matches!(self, Self::So4) { count % 2 } else { count };
                if c / 3 == kind { levi_civita(a % 3, b % 3, c % 3) } else { 0 }
            }
            (Self::Se2, (0, 1, 2)) | (Self::Aff1, (0, 1, 1)) | (Self::Heisenberg, (0, 1, 2)) => 1,
            (Self::Se2, (0, 2, 1)) => -1,
            (Self::Sl2, (0, 1, 1)) => 2,
            (Self::Sl2, (0, 2, 2)) => -2,
            (Self::Sl2, (1, 2, 0)) => 1,
            (Self::Product(factors), _) => match holding(factors, a) {
                // With b or c in another factor: [g_1, g_2] = 0.
                Some((first, _, factor)) if c >= first => factor.integer_constant(a - first, b - first, c - first),
                _ => 0,
            },
            _ => 0,
        }
    }

    /// ê_a, a square matrix of size [`matrix_size`](Self::matrix_size); zero for an index out of range.
    pub fn basis_matrix<T: Real>(&self, a: usize) -> DMatrix<T> {
        let size = self.matrix_size();
        let mut matrix = DMatrix::from_element(size, size, T::zero());
        for (row, column, value) in self.matrix_entries(a) {
            matrix[(row, column)] = T::int(value);
        }
        matrix
    }

    /// The non-zero entries of ê_a: row, column, value.
    fn matrix_entries(&self, a: usize) -> Vec<(usize, usize, i64)> {
        if a >= self.dimension() {
            return Vec::new();
        }
        let (j, k) = ((a + 1) % 3, (a + 2) % 3);
        match (self, a) {
            (Self::Abelian(n), _) => vec![(a, *n, 1)],
            (Self::So3, _) | (Self::Se3 | Self::So4, 0..3) => vec![(k, j, 1), (j, k, -1)],
            (Self::Se3, _) => vec![(a - 3, 3, 1)],
            (Self::So4, _) => vec![(a - 3, 3, 1), (3, a - 3, -1)],
            (Self::Se2, 0) => vec![(1, 0, 1), (0, 1, -1)],
            (Self::Se2, _) => vec![(a - 1, 2, 1)],
            (Self::Sl2, 0) => vec![(0, 0, 1), (1, 1, -1)],
            (Self::Sl2, 1) | (Self::Aff1, 1) | (Self::Heisenberg, 0) => vec![(0, 1, 1)],
            (Self::Sl2, _) => vec![(1, 0, 1)],
            (Self::Aff1, _) => vec![(0, 0, 1)],
            (Self::Heisenberg, 1) => vec![(1, 2, 1)],
            (Self::Heisenberg, _) => vec![(0, 2, 1)],
            (Self::Product(factors), _) => {
                let Some((first, corner, factor)) = holding(factors, a) else { return Vec::new() };
                let block = factor.matrix_entries(a - first);
                block.into_iter().map(|(r, c, v)| (corner + r, corner + c, v)).collect()
            }
        }
    }

    /// Generators of the Casimirs of degree at most two, in the standard basis:
    ///
    /// ℝⁿ all μ_a; so(3) |μ|²; se(2) |p|²; se(3) |p|² and m·p; sl(2) μ_H² + 4 μ_E μ_F (8 times the dual of the Killing
    /// form); aff(1) none; Heisenberg μ_Z; so(4) |m|² + |k|² and m·k; products those of their factors.
    ///
    /// # Errors
    /// A dimension other than N.
    pub fn casimirs<T: Real, const N: usize>(&self) -> Result<Vec<Casimir<T, N>>, AlgebraError> {
        self.expect_dimension(N)?;
        Ok(self.casimirs_beside_spectators())
    }

    /// The same in a dimension N that may be larger: of the further coordinates they do not depend.
    pub(crate) fn casimirs_beside_spectators<T: Real, const N: usize>(&self) -> Vec<Casimir<T, N>> {
        let form = |form: Form| Casimir::of(form.into_iter().map(|(monomial, value)| (monomial, T::int(value))));
        self.forms().into_iter().map(form).collect()
    }

    /// How many [`casimirs`](Self::casimirs) there are.
    pub fn casimir_count(&self) -> usize {
        self.forms().len()
    }

    fn forms(&self) -> Vec<Form> {
        let coordinate = |a: usize| vec![(vec![a], 1)];
        let squares = |range: std::ops::Range<usize>| range.map(|a| (vec![a, a], 1)).collect();
        let mixed = || (0..3).map(|i| (vec![i, 3 + i], 1)).collect();
        match self {
            Self::Abelian(n) => (0..*n).map(coordinate).collect(),
            Self::So3 => vec![squares(0..3)],
            Self::Se2 => vec![squares(1..3)],
            Self::Se3 => vec![squares(3..6), mixed()],
            Self::Sl2 => vec![vec![(vec![0, 0], 1), (vec![1, 2], 4)]],
            Self::Aff1 => Vec::new(),
            Self::Heisenberg => vec![coordinate(2)],
            Self::So4 => vec![squares(0..6), mixed()],
            Self::Product(factors) => {
                let forms = placed(factors).flat_map(|(first, _, factor)| {
                    let mut forms = factor.forms();
                    forms.iter_mut().flatten().flat_map(|(monomial, _)| monomial).for_each(|a| *a += first);
                    forms
                });
                forms.collect()
            }
        }
    }

    /// # Errors
    /// [`AlgebraError::Dimension`] unless the dimension is `expected`.
    pub(crate) fn expect_dimension(&self, expected: usize) -> Result<(), AlgebraError> {
        let dimension = self.dimension();
        if dimension == expected {
            return Ok(());
        }
        Err(AlgebraError::Dimension { name: self.to_string(), dimension, expected })
    }
}

impl<T: Real, const N: usize> LieAlgebra<T, N> {
    /// The algebra of the catalogue, in its standard basis.
    ///
    /// # Errors
    /// A dimension other than N.
    pub fn from_catalogue(entry: &Entry) -> Result<Self, AlgebraError> {
        entry.expect_dimension(N)?;
        Self::new(|a, b, c| entry.constant(a, b, c))
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Abelian(n) => write!(f, "r{n}"),
            Self::So3 => f.write_str("so3"),
            Self::Se2 => f.write_str("se2"),
            Self::Se3 => f.write_str("se3"),
            Self::Sl2 => f.write_str("sl2"),
            Self::Aff1 => f.write_str("aff1"),
            Self::Heisenberg => f.write_str("heisenberg"),
            Self::So4 => f.write_str("so4"),
            Self::Product(factors) => {
                for (i, factor) in factors.iter().enumerate() {
                    let plus = if i == 0 { "" } else { "+" };
                    write!(f, "{plus}{factor}")?;
                }
                Ok(())
            }
        }
    }
}

impl FromStr for Entry {
    type Err = UnknownName;

    /// The entry of that name; blanks around factors are ignored.
    fn from_str(text: &str) -> Result<Self, UnknownName> {
        let mut factors = text.split('+').map(|name| factor(name.trim())).collect::<Result<Vec<_>, _>>()?;
        Ok(if factors.len() == 1 { factors.remove(0) } else { Self::Product(factors) })
    }
}

fn factor(name: &str) -> Result<Entry, UnknownName> {
    Ok(match name {
        "so3" => Entry::So3,
        "se2" => Entry::Se2,
        "se3" => Entry::Se3,
        "sl2" => Entry::Sl2,
        "aff1" => Entry::Aff1,
        "heisenberg" => Entry::Heisenberg,
        "so4" => Entry::So4,
        _ => {
            let digits =
                name.strip_prefix('r').filter(|d| d.bytes().all(|b| b.is_ascii_digit()) && !d.starts_with('0'));
            match digits.and_then(|d| d.parse().ok()) {
                Some(n @ 1..=MAX_ABELIAN) => Entry::Abelian(n),
                _ => return Err(UnknownName { name: name.into() }),
            }
        }
    })
}
