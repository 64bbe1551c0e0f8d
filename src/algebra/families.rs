//! Families of Lie algebras that no catalogue lists, each with a faithful representation by matrices.
//!
//! Every constructor returns a basis of matrices; that they are independent and closed is checked where an algebra is made of
//! them ([`MatrixAlgebra`](super::MatrixAlgebra)). References: Jacobson 1962; Šnobl and Winternitz 2014; Burde 1998 (for central
//! extensions and the representations by cocycles).

use super::rational::{RationalAlgebra, RationalMatrix, Span, add, integer};
use dashu_ratio::RBig;
use std::fmt;

/// For each family: its variant, its name in files and counts, how often of 100 draws of a family it is drawn, and its share of random cases
/// in percent, from and to: a draw that is not admitted is in vain.
macro_rules! families {
    ($($(#[$doc:meta])* $variant:ident: $name:literal, $weight:literal, $least:literal, $most:literal;)*) => {
        /// A family of random algebras.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize, serde::Deserialize)]
        #[non_exhaustive]
        pub enum AlgebraFamily {
            $($(#[$doc])* #[serde(rename = $name)] $variant,)*
        }

        impl AlgebraFamily {
            /// All, in the order of their declaration.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// How often of 100 each of them is drawn.
            pub(crate) const WEIGHTS: [usize; Self::ALL.len()] = [$($weight),*];

            /// The share of random cases of each of them, in percent: no less and no more than this.
            pub(crate) const SHARES: [(f64, f64); Self::ALL.len()] = [$(($least, $most)),*];

            /// The name in files and counts.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Self::$variant => $name,)*
                }
            }
        }
    };
}

families! {
    /// ℝᵏ ⋉ ℝᵐ by commuting matrices.
    Commuting: "commuting", 15, 8.6, 9.6;
    /// Nilpotent of two steps, by alternating forms.
    TwoStep: "two-step", 10, 6.0, 7.0;
    /// g ⋉_ρ V for a sum of representations.
    Semidirect: "semidirect", 22, 13.8, 14.8;
    /// g ⊗ ℝ\[ε\]/ε², the tangent algebra.
    Tangent: "tangent", 10, 5.6, 6.6;
    /// Matrices with entries where i ≤ j in a partial order.
    Incidence: "incidence", 14, 8.6, 9.6;
    /// The closure of a few sparse integer matrices under the bracket.
    Closure: "closure", 9, 5.0, 6.0;
    /// g ⋊ ℝD for a derivation D.
    Derivation: "derivation", 12, 7.3, 8.3;
    /// The central extension by a 2-cocycle.
    Central: "central", 8, 4.1, 5.1;
}

impl fmt::Display for AlgebraFamily {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A basis of matrices of one size.
pub(crate) type Basis = Vec<RationalMatrix>;

fn unit(size: usize, row: usize, column: usize) -> RationalMatrix {
    RationalMatrix::of(size, |r, c| i64::from((r, c) == (row, column)))
}

/// The matrices of an algebra of the catalogue.
pub(crate) fn named(entry: &super::Entry) -> Basis {
    let size = entry.matrix_size();
    let matrix = |a| {
        let block = entry.basis_matrix::<f64>(a);
        RationalMatrix::of(size, |r, c| block[(r, c)] as i64)
    };
    (0..entry.dimension()).map(matrix).collect()
}

/// Representations of an algebra, side by side: blocks on the diagonal.
pub(crate) fn direct_sum(representations: &[Basis]) -> Basis {
    let size = representations.iter().filter_map(|rho| rho.first()).map(|matrix| matrix.size).sum();
    let n = representations.first().map_or(0, Vec::len);
    let mut sum = vec![RationalMatrix::zero(size); n];
    let mut corner = 0;
    for rho in representations {
        for (a, matrix) in rho.iter().enumerate() {
            sum[a].add_block(corner, corner, matrix);
        }
        corner += rho.first().map_or(0, |matrix| matrix.size);
    }
    sum
}

/// ρ* = −ρᵀ.
pub(crate) fn dual(rho: &Basis) -> Basis {
    rho.iter().map(|matrix| matrix.transposed().scaled(&RBig::NEG_ONE)).collect()
}

/// The adjoint representation.
pub(crate) fn adjoint(algebra: &RationalAlgebra) -> Basis {
    (0..algebra.dimension()).map(|a| algebra.adjoint(a)).collect()
}

/// S²ρ on monomials e_i e_j, i ≤ j: ρ(x) e_i e_j = (ρ(x) e_i) e_j + e_i (ρ(x) e_j).
pub(crate) fn symmetric_square(rho: &Basis) -> Basis {
    let m = rho.first().map_or(0, |matrix| matrix.size);
    let pairs: Vec<(usize, usize)> = (0..m).flat_map(|i| (i..m).map(move |j| (i, j))).collect();
    let place = |i: usize, j: usize| pairs.iter().position(|&pair| pair == (i.min(j), i.max(j))).unwrap_or(0);
    let square = |matrix: &RationalMatrix| {
        let mut square = RationalMatrix::zero(pairs.len());
        for (column, &(i, j)) in pairs.iter().enumerate() {
            for k in 0..m {
                square.add_to(place(k, j), column, &matrix.get(k, i));
                square.add_to(place(i, k), column, &matrix.get(k, j));
            }
        }
        square
    };
    rho.iter().map(square).collect()
}

/// ℝᵏ ⋉ ℝᵐ: \[\[Σ s_i A_i, v\], \[0, 0\]\] for commuting, independent m×m matrices A_i.
pub(crate) fn commuting(matrices: &Basis) -> Basis {
    semidirect(&[], matrices)
}

/// g ⋉_ρ V: \[\[ρ(x), v\], \[0, 0\]\] beside a representation of g (for where ρ has a kernel; it may be empty). First g, then V.
pub(crate) fn semidirect(beside: &[RationalMatrix], rho: &Basis) -> Basis {
    let m = rho.first().map_or(0, |matrix| matrix.size);
    let corner = beside.first().map_or(0, |matrix| matrix.size);
    let size = corner + m + 1;
    let mut basis = Vec::new();
    for (a, matrix) in rho.iter().enumerate() {
        let mut large = RationalMatrix::zero(size);
        if let Some(other) = beside.get(a) {
            large.add_block(0, 0, other);
        }
        large.add_block(corner, corner, matrix);
        basis.push(large);
    }
    basis.extend((0..m).map(|i| unit(size, corner + i, size - 1)));
    basis
}

/// Nilpotent of two steps, V ⊕ Z with \[v, w\] = ω(v, w): \[\[0, ½ω(v, ·), z\], \[0, 0, v\], \[0, 0, 0\]\] for independent alternating forms, one
/// for each dimension of Z.
pub(crate) fn two_step(forms: &[RationalMatrix]) -> Basis {
    let (p, m) = (forms.len(), forms.first().map_or(0, |form| form.size));
    let size = p + m + 1;
    let half = RBig::ONE / integer(2);
    let vector = |a: usize| {
        let mut matrix = unit(size, p + a, size - 1);
        for (k, form) in forms.iter().enumerate() {
            for b in 0..m {
                matrix.add_to(k, p + b, &(&half * form.get(a, b)));
            }
        }
        matrix
    };
    (0..m).map(vector).chain((0..p).map(|k| unit(size, k, size - 1))).collect()
}

/// g ⊗ ℝ\[ε\]/ε²: x as \[\[x, 0\], \[0, x\]\], εx as \[\[0, x\], \[0, 0\]\]. First g, then εg.
pub(crate) fn tangent(basis: &Basis) -> Basis {
    let size = basis.first().map_or(0, |matrix| matrix.size);
    let blocks = |matrix: &RationalMatrix, places: &[(usize, usize)]| {
        let mut large = RationalMatrix::zero(2 * size);
        places.iter().for_each(|&(r, c)| large.add_block(r * size, c * size, matrix));
        large
    };
    let first = basis.iter().map(|matrix| blocks(matrix, &[(0, 0), (1, 1)]));
    first.chain(basis.iter().map(|matrix| blocks(matrix, &[(0, 1)]))).collect()
}

/// The matrix units E_ij with i < j in a partial order of `size` elements, after E_ii of some i. `below(i, j)` has to be transitive.
pub(crate) fn incidence(size: usize, diagonals: &[usize], below: impl Fn(usize, usize) -> bool) -> Basis {
    let strict = (0..size * size).map(|k| (k / size, k % size)).filter(|&(i, j)| i != j && below(i, j));
    diagonals.iter().map(|&i| (i, i)).chain(strict).map(|(i, j)| unit(size, i, j)).collect()
}

/// The span of all iterated brackets of matrices, if its dimension is at most `most`.
pub(crate) fn closure(generators: &Basis, most: usize) -> Option<Basis> {
    let mut span = Span::default();
    let mut basis: Basis = generators.iter().filter(|matrix| span.insert(&matrix.entries)).cloned().collect();
    let mut done = 0;
    while done < basis.len() {
        for k in 0..done {
            let bracket = basis[k].commutator(&basis[done]);
            if span.insert(&bracket.entries) {
                basis.push(bracket);
            }
            if basis.len() > most {
                return None;
            }
        }
        done += 1;
    }
    Some(basis)
}

/// g ⋊ ℝD by its adjoint representation: \[\[ad_x + sD, −Dx\], \[0, 0\]\] for x + s d, \[d, x\] = Dx. Faithful where its centre is trivial. First g,
/// then d.
pub(crate) fn derivation_extension(algebra: &RationalAlgebra, derivation: &RationalMatrix) -> Basis {
    let n = algebra.dimension();
    let mut basis: Basis = (0..n)
        .map(|a| {
            let mut matrix = RationalMatrix::zero(n + 1);
            matrix.add_block(0, 0, &algebra.adjoint(a));
            (0..n).for_each(|c| matrix.add_to(c, n, &-derivation.get(c, a)));
            matrix
        })
        .collect();
    let mut last = RationalMatrix::zero(n + 1);
    last.add_block(0, 0, derivation);
    basis.push(last);
    basis
}

/// A central extension of g by the cocycle c'(x, y) = ±(D·c)(x, y) of a cocycle c and a derivation D, beside a representation of g.
///
/// The matrices are \[\[0, α(x), z\], \[0, ad*(x), c(x, ·)\], \[0, 0, 0\]\] with (ad*(x) μ)(y) = −μ(\[x, y\]) on columns μ ∈ g* and α(x)μ = μ(Dx). x ↦ c(x, ·)
/// is a 1-cocycle with values in g*, D one with values in g = g**: the commutator of two such matrices has the corner
/// c(y, Dx) − c(x, Dy), and is else the matrix of \[x, y\]. First g, then z.
pub(crate) fn central_extension(
    algebra: &RationalAlgebra,
    derivation: &RationalMatrix,
    cocycle: &RationalMatrix,
    beside: &Basis,
) -> Basis {
    let n = algebra.dimension();
    let corner = beside.first().map_or(0, |matrix| matrix.size);
    let size = corner + n + 2;
    let mut basis = Vec::new();
    for a in 0..n {
        let mut matrix = RationalMatrix::zero(size);
        if let Some(other) = beside.get(a) {
            matrix.add_block(0, 0, other);
        }
        matrix.add_block(corner + 1, corner + 1, &algebra.adjoint(a).transposed().scaled(&RBig::NEG_ONE));
        for b in 0..n {
            matrix.add_to(corner, corner + 1 + b, &derivation.get(b, a));
            matrix.add_to(corner + 1 + b, size - 1, &cocycle.get(a, b));
        }
        basis.push(matrix);
    }
    basis.push(unit(size, corner, size - 1));
    basis
}

/// Σ x_k M_k.
pub(crate) fn combination(matrices: &[RationalMatrix], coefficients: &[i64]) -> Option<RationalMatrix> {
    let mut sum = RationalMatrix::zero(matrices.first()?.size);
    for (matrix, &x) in matrices.iter().zip(coefficients) {
        add(&mut sum.entries, &integer(x), &matrix.entries);
    }
    Some(sum)
}
