//! The catalogue: algebras in their standard bases that types, files and random systems know by name, each with structure constants, a faithful matrix representation and Casimirs.
//!
//! All of these are small integers, so they are exact over every scalar. Bases are those of [`Entry`] (indices from 0, E_ij the matrix
//! with a single 1 at row i, column j).
//!
//! Products are written with `+`, as in `so3+r2`: bases one after the other, matrices block-diagonal.

use super::{AlgebraError, Casimir, LieAlgebra};
use crate::scalar::Real;
use nalgebra::DMatrix;
use std::fmt;
use std::str::FromStr;

/// The largest n for which `rn` is a name.
pub const MAX_ABELIAN: usize = 64;

/// The entries of a matrix that are not 0: row, column, value.
pub(crate) type Entries = &'static [(usize, usize, i64)];

/// The monomials of a Casimir, each the indices of its factors, with their coefficients.
type Form = &'static [(&'static [usize], i64)];

/// What is known of an algebra with a name; its dimension, the size of its matrices and its brackets follow.
pub(crate) struct Named {
    /// The name, as in files.
    pub name: &'static str,
    /// The equations of its group.
    pub group: Equations,
    /// ê_a, orthogonal to each other: tr(ê_aᵀ ê_b) = 0.
    pub matrices: &'static [Entries],
    /// Generators of the Casimirs of degree at most two, none of them a combination of products of others.
    casimirs: &'static [Form],
}

/// The equations of a group, in its m×m matrices.
pub(crate) enum Equations {
    /// Those of SO(m).
    Rotations,
    /// A rotation of m − 1 dimensions, and the last row (0 … 0 1).
    Motions,
    /// The determinant 1.
    Special,
    /// A positive determinant, and the last row (0 … 0 1).
    Affine,
    /// Upper triangular, with 1 on the diagonal.
    Unitriangular,
}

/// Which kind of entry.
pub(crate) enum Kind<'a> {
    /// ℝⁿ.
    Abelian(usize),
    /// One with a name.
    Named(&'static Named),
    /// The product of these.
    Product(&'a [Entry]),
}

/// For each name: its variant, what is known of it, and which of 100 draws of random systems it has. A new one takes draws from those of
/// algebras of matrices; which come first is part of what a seed draws.
macro_rules! catalogue {
    ($($(#[$doc:meta])* $variant:ident: $named:expr, drawn: $drawn:expr;)*) => {
        /// An algebra of the catalogue, in its standard basis (see the [module](self)).
        #[derive(Clone, Debug, PartialEq, Eq, Hash)]
        #[non_exhaustive]
        pub enum Entry {
            /// ℝⁿ, n translations E_{a,n} in (n+1)×(n+1) matrices. Casimirs: all μ_a.
            Abelian(usize),
            $($(#[$doc])* $variant,)*
            /// The direct product, with the Casimirs of its factors; write nested ones flat where names matter, since a name parses to the flat form.
            Product(Vec<Entry>),
        }

        /// The data of each.
        #[allow(non_upper_case_globals, reason = "the names of the entries")]
        pub(crate) mod named {
            use super::*;

            $(pub(crate) const $variant: Named = $named;)*
        }

        impl Entry {
            /// Those that have a name.
            pub(crate) const NAMED: &'static [Self] = &[$(Self::$variant),*];

            pub(crate) fn kind(&self) -> Kind<'_> {
                match self {
                    Self::Abelian(n) => Kind::Abelian(*n),
                    $(Self::$variant => Kind::Named(&const { named::$variant }),)*
                    Self::Product(factors) => Kind::Product(factors),
                }
            }

            /// ℝ and those with a name, each with how many of 100 draws it has, in the order of these draws.
            #[cfg(feature = "harness")]
            pub(crate) fn drawn() -> Vec<(Self, usize)> {
                const DRAWN: &[std::ops::Range<usize>] = &[7..10, $($drawn),*];
                // Of one entry each, without a gap.
                const _: () = {
                    let (mut seen, mut k) = (0_u128, 0);
                    while k < DRAWN.len() {
                        let draws = (1_u128 << DRAWN[k].end) - (1_u128 << DRAWN[k].start);
                        assert!(seen & draws == 0, "a draw of two entries");
                        (seen, k) = (seen | draws, k + 1);
                    }
                    assert!(seen & (seen + 1) == 0, "a draw of no entry");
                };
                let mut drawn: Vec<_> = [Self::Abelian(1), $(Self::$variant),*].into_iter().zip(DRAWN).collect();
                drawn.sort_by_key(|(_, draws)| draws.start);
                drawn.into_iter().map(|(entry, draws)| (entry, draws.len())).collect()
            }
        }
    };
}

/// Rotations of the first three coordinates.
const J: [Entries; 3] = [&[(2, 1, 1), (1, 2, -1)], &[(0, 2, 1), (2, 0, -1)], &[(1, 0, 1), (0, 1, -1)]];

/// Σ μ_i μ_{3+i}.
const MIXED: Form = &[(&[0, 3], 1), (&[1, 4], 1), (&[2, 5], 1)];

catalogue! {
    /// so(3), rotations of space: J_i x = e_i × x, \[J_i, J_j\] = ε_ijk J_k. Casimir: |μ|².
    So3: Named {
        name: "so3", group: Equations::Rotations, matrices: &J, casimirs: &[&[(&[0, 0], 1), (&[1, 1], 1), (&[2, 2], 1)]],
    }, drawn: 0..7;
    /// se(2), motions of the plane: J = E_10 − E_01, P_i = E_i2, \[J, P_0\] = P_1, \[J, P_1\] = −P_0. Casimir: |p|².
    Se2: Named {
        name: "se2", group: Equations::Motions,
        matrices: &[&[(1, 0, 1), (0, 1, -1)], &[(0, 2, 1)], &[(1, 2, 1)]],
        casimirs: &[&[(&[1, 1], 1), (&[2, 2], 1)]],
    }, drawn: 12..14;
    /// se(3), motions of space: J_i as in `so3`, then P_i = E_i3, \[J_i, P_j\] = ε_ijk P_k. Casimirs: |p|² and m·p.
    Se3: Named {
        name: "se3", group: Equations::Motions,
        matrices: &[J[0], J[1], J[2], &[(0, 3, 1)], &[(1, 3, 1)], &[(2, 3, 1)]],
        casimirs: &[&[(&[3, 3], 1), (&[4, 4], 1), (&[5, 5], 1)], MIXED],
    }, drawn: 18..21;
    /// sl(2, ℝ), 2×2 matrices of trace 0: H = diag(1, −1), E = E_01, F = E_10, \[H, E\] = 2E, \[H, F\] = −2F, \[E, F\] = H. Casimir:
    /// μ_H² + 4 μ_E μ_F, 8 times the dual of the Killing form.
    Sl2: Named {
        name: "sl2", group: Equations::Special,
        matrices: &[&[(0, 0, 1), (1, 1, -1)], &[(0, 1, 1)], &[(1, 0, 1)]],
        casimirs: &[&[(&[0, 0], 1), (&[1, 2], 4)]],
    }, drawn: 16..18;
    /// aff(1), affine maps of the line; not unimodular: a dilation X = E_00, a translation Y = E_01, \[X, Y\] = Y. No Casimir.
    Aff1: Named {
        name: "aff1", group: Equations::Affine,
        matrices: &[&[(0, 0, 1)], &[(0, 1, 1)]], casimirs: &[],
    }, drawn: 10..12;
    /// The Heisenberg algebra of dimension 3; nilpotent: X = E_01, Y = E_12, Z = E_02, \[X, Y\] = Z. Casimir: μ_Z.
    Heisenberg: Named {
        name: "heisenberg", group: Equations::Unitriangular,
        matrices: &[&[(0, 1, 1)], &[(1, 2, 1)], &[(0, 2, 1)]], casimirs: &[&[(&[2], 1)]],
    }, drawn: 14..16;
    /// so(4), rotations of four-space: J_i as in `so3`, then K_i = E_i3 − E_3i in the planes (i, 3), \[J_i, K_j\] = ε_ijk K_k,
    /// \[K_i, K_j\] = ε_ijk J_k. Casimirs: |m|² + |k|² and m·k.
    So4: Named {
        name: "so4", group: Equations::Rotations,
        matrices: &[J[0], J[1], J[2], &[(0, 3, 1), (3, 0, -1)], &[(1, 3, 1), (3, 1, -1)], &[(2, 3, 1), (3, 2, -1)]],
        casimirs: &[&[(&[0, 0], 1), (&[1, 1], 1), (&[2, 2], 1), (&[3, 3], 1), (&[4, 4], 1), (&[5, 5], 1)], MIXED],
    }, drawn: 21..24;
}

impl Named {
    /// The size of the matrices.
    pub(crate) fn size(&self) -> usize {
        self.matrices.iter().copied().flatten().map(|(r, c, _)| r.max(c) + 1).fold(0, usize::max)
    }
}

/// The matrices of an entry, each by its entries that are not 0, and its Casimirs, each by its monomials with their coefficients.
#[derive(Default)]
struct Parts {
    matrices: Vec<Vec<(usize, usize, i64)>>,
    casimirs: Vec<Vec<(Vec<usize>, i64)>>,
}

impl Parts {
    /// C^c_ab = tr(ê_cᵀ [ê_a, ê_b]) / tr(ê_cᵀ ê_c); zero for an index out of range.
    fn constant(&self, a: usize, b: usize, c: usize) -> i64 {
        let [Some(left), Some(right), Some(along)] = [a, b, c].map(|index| self.matrices.get(index)) else { return 0 };
        let mut sum = 0;
        for &(r, k, x) in left {
            for &(l, s, y) in right {
                for &(row, column, z) in along {
                    let product = i64::from(k == l && (r, s) == (row, column));
                    sum += x * y * z * (product - i64::from(s == r && (l, k) == (row, column)));
                }
            }
        }
        sum / along.iter().map(|(_, _, z)| z * z).sum::<i64>()
    }
}

/// A name that is not in the catalogue.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown algebra {name:?}: allowed are r1 to r{MAX_ABELIAN}, {names}, and products of these with `+`, as in so3+r2",
    names = Entry::names().join(", ")
)]
#[non_exhaustive]
pub struct UnknownName {
    /// The factor that was not recognised.
    pub name: String,
}

/// The factors of a product, each after the place of its first basis vector and that of its block of matrices.
pub(crate) fn placed(factors: &[Entry]) -> impl Iterator<Item = (usize, usize, &Entry)> {
    factors.iter().scan((0, 0), |(first, corner), factor| {
        let at = (*first, *corner, factor);
        (*first, *corner) = (*first + factor.dimension(), *corner + factor.matrix_size());
        Some(at)
    })
}

impl Entry {
    /// The names that stand for one algebra each.
    pub(crate) fn names() -> Vec<&'static str> {
        let name = |entry: &Self| if let Kind::Named(named) = entry.kind() { named.name } else { "" };
        Self::NAMED.iter().map(name).collect()
    }

    /// n = dim g.
    pub fn dimension(&self) -> usize {
        match self.kind() {
            Kind::Abelian(n) => n,
            Kind::Named(named) => named.matrices.len(),
            Kind::Product(factors) => factors.iter().map(Self::dimension).sum(),
        }
    }

    /// The size of the representing matrices.
    pub fn matrix_size(&self) -> usize {
        match self.kind() {
            Kind::Abelian(n) => n + 1,
            Kind::Named(named) => named.size(),
            Kind::Product(factors) => factors.iter().map(Self::matrix_size).sum(),
        }
    }

    /// The size of the block of its matrices that is a rotation; 0 without one, and for products.
    #[cfg(feature = "harness")]
    pub(crate) fn rotation(&self) -> usize {
        match self.kind() {
            Kind::Named(named @ Named { group: Equations::Rotations, .. }) => named.size(),
            Kind::Named(named @ Named { group: Equations::Motions, .. }) => named.size() - 1,
            _ => 0,
        }
    }

    /// C^c_ab, with [e_a, e_b] = C^c_ab e_c; zero for an index out of range.
    pub fn constant<T: Real>(&self, a: usize, b: usize, c: usize) -> T {
        T::int(self.parts().constant(a, b, c))
    }

    /// ê_a, a square matrix of size [`matrix_size`](Self::matrix_size); zero for an index out of range.
    pub fn basis_matrix<T: Real>(&self, a: usize) -> DMatrix<T> {
        let size = self.matrix_size();
        let mut matrix = DMatrix::from_element(size, size, T::zero());
        for &(row, column, value) in self.parts().matrices.get(a).into_iter().flatten() {
            matrix[(row, column)] = T::int(value);
        }
        matrix
    }

    fn parts(&self) -> Parts {
        match self.kind() {
            Kind::Abelian(n) => Parts {
                matrices: (0..n).map(|a| vec![(a, n, 1)]).collect(),
                casimirs: (0..n).map(|a| vec![(vec![a], 1)]).collect(),
            },
            Kind::Named(named) => {
                let form = |form: &Form| form.iter().map(|(monomial, value)| (monomial.to_vec(), *value)).collect();
                Parts {
                    matrices: named.matrices.iter().map(|entries| entries.to_vec()).collect(),
                    casimirs: named.casimirs.iter().map(form).collect(),
                }
            }
            Kind::Product(factors) => {
                let mut all = Parts::default();
                for (first, corner, factor) in placed(factors) {
                    let mut parts = factor.parts();
                    parts.matrices.iter_mut().flatten().for_each(|(r, c, _)| (*r, *c) = (corner + *r, corner + *c));
                    parts.casimirs.iter_mut().flatten().flat_map(|(monomial, _)| monomial).for_each(|a| *a += first);
                    all.matrices.extend(parts.matrices);
                    all.casimirs.extend(parts.casimirs);
                }
                all
            }
        }
    }

    /// Generators of the Casimirs of degree at most two, in the standard basis.
    ///
    /// # Errors
    /// A dimension other than N.
    pub fn casimirs<T: Real, const N: usize>(&self) -> Result<Vec<Casimir<T, N>>, AlgebraError> {
        self.expect_dimension(N)?;
        Ok(self.casimirs_beside_spectators())
    }

    /// The same in a dimension N that may be larger: of the further coordinates they do not depend.
    pub(crate) fn casimirs_beside_spectators<T: Real, const N: usize>(&self) -> Vec<Casimir<T, N>> {
        let form = |form: Vec<(Vec<usize>, i64)>| Casimir::of(form.into_iter().map(|(m, value)| (m, T::int(value))));
        self.parts().casimirs.into_iter().map(form).collect()
    }

    /// How many [`casimirs`](Self::casimirs) there are.
    pub fn casimir_count(&self) -> usize {
        self.parts().casimirs.len()
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
        let parts = entry.parts();
        Self::new(|a, b, c| T::int(parts.constant(a, b, c)))
    }
}

impl fmt::Display for Entry {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.kind() {
            Kind::Abelian(n) => write!(f, "r{n}"),
            Kind::Named(named) => f.write_str(named.name),
            Kind::Product(factors) => {
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
    if let Some(place) = Entry::names().iter().position(|known| *known == name) {
        return Ok(Entry::NAMED[place].clone());
    }
    let digits = name.strip_prefix('r').filter(|d| d.bytes().all(|b| b.is_ascii_digit()) && !d.starts_with('0'));
    match digits.and_then(|d| d.parse().ok()) {
        Some(n @ 1..=MAX_ABELIAN) => Ok(Entry::Abelian(n)),
        _ => Err(UnknownName { name: name.into() }),
    }
}
