//! Other algebras that files know by name, as lists of matrices without a type: a new algebra stands here unless users need an
//! [`Entry`] for it. They are the classical ones up to dimension 10, Galilei's, Bianchi's.
//!
//! | name | basis |
//! |---|---|
//! | `su2` | left multiplication of quaternions by i/2, j/2, k/2, as 4×4 matrices |
//! | `su11` | diag(i, −i)/2, and ½ at the other diagonal with 1, 1 and with −i, i; complex entries as 2×2 blocks |
//! | `so31` | rotations J_i as in `so4`, then boosts E_i3 + E_3i |
//! | `so5` | E_ji − E_ij, i < j, row by row |
//! | `sp4` | \[\[A, B\], \[C, −Aᵀ\]\]: A, then B, then C symmetric |
//! | `sl3` | diag(1, −1, 0), diag(0, 1, −1), then E_ij, i < j, then i > j |
//! | `galilei` | \[\[R, v, x\], \[0, 1, t\], \[0, 0, 1\]\]: rotations, boosts, translations, time |
//! | `bianchi1` … `bianchi9` | ℝ³; Heisenberg; ℝ ⋉_A ℝ² with A = diag(1, 0), \[\[1, 1\], \[0, 1\]\], 1, diag(1, −1), a quarter turn; sl(2); so(3) |

use super::families::{Basis, commuting, direct_sum, named};
use super::rational::{RationalMatrix, integer};
use super::{Entry, MatrixAlgebra};
use dashu_ratio::RBig;
use std::sync::LazyLock;

/// A matrix by its entries: row, column, value.
fn matrix(size: usize, entries: &[(usize, usize, i64)]) -> RationalMatrix {
    RationalMatrix::of(size, |r, c| entries.iter().filter(|(i, j, _)| (*i, *j) == (r, c)).map(|(_, _, v)| v).sum())
}

/// Half of each.
fn halved(basis: Basis) -> Basis {
    basis.iter().map(|matrix| matrix.scaled(&(RBig::ONE / integer(2)))).collect()
}

/// The matrix of a + ib with blocks [[a, −b], [b, a]]; entries are row, column, a, b.
fn complex(size: usize, entries: &[(usize, usize, i64, i64)]) -> RationalMatrix {
    let blocks: Vec<_> = entries
        .iter()
        .flat_map(|&(r, c, a, b)| {
            let (r, c) = (2 * r, 2 * c);
            [(r, c, a), (r, c + 1, -b), (r + 1, c, b), (r + 1, c + 1, a)]
        })
        .collect();
    matrix(2 * size, &blocks)
}

fn bianchi_by(a: [[i64; 2]; 2]) -> Basis {
    commuting(&vec![RationalMatrix::of(2, |r, c| a[r][c])])
}

/// Each by its name and its basis, in order.
pub(crate) static KNOWN: LazyLock<Vec<(&'static str, Basis)>> = LazyLock::new(|| {
    let turn = |size, i: usize, j: usize| matrix(size, &[(j, i, 1), (i, j, -1)]);
    let unit = |size, i, j| matrix(size, &[(i, j, 1)]);
    let rotations = |size: usize| [turn(size, 1, 2), turn(size, 2, 0), turn(size, 0, 1)];
    vec![
        (
            "su2",
            halved(vec![
                matrix(4, &[(1, 0, 1), (0, 1, -1), (3, 2, 1), (2, 3, -1)]),
                matrix(4, &[(2, 0, 1), (0, 2, -1), (1, 3, 1), (3, 1, -1)]),
                matrix(4, &[(3, 0, 1), (0, 3, -1), (2, 1, 1), (1, 2, -1)]),
            ]),
        ),
        (
            "su11",
            halved(vec![
                complex(2, &[(0, 0, 0, 1), (1, 1, 0, -1)]),
                complex(2, &[(0, 1, 1, 0), (1, 0, 1, 0)]),
                complex(2, &[(0, 1, 0, -1), (1, 0, 0, 1)]),
            ]),
        ),
        ("so31", {
            let boosts = (0..3).map(|i| matrix(4, &[(i, 3, 1), (3, i, 1)]));
            rotations(4).into_iter().chain(boosts).collect()
        }),
        ("so5", (0..5).flat_map(|i| (i + 1..5).map(move |j| (i, j))).map(|(i, j)| turn(5, i, j)).collect()),
        ("sp4", {
            let a = (0..4).map(|k| matrix(4, &[(k / 2, k % 2, 1), (2 + k % 2, 2 + k / 2, -1)]));
            let symmetric = |row: usize, column: usize| {
                let both = |i: usize, j: usize| {
                    if i == j {
                        vec![(row + i, column + i, 1)]
                    } else {
                        vec![(row + i, column + j, 1), (row + j, column + i, 1)]
                    }
                };
                [(0, 0), (0, 1), (1, 1)].map(|(i, j)| matrix(4, &both(i, j)))
            };
            a.chain(symmetric(0, 2)).chain(symmetric(2, 0)).collect()
        }),
        ("sl3", {
            let diagonal = [matrix(3, &[(0, 0, 1), (1, 1, -1)]), matrix(3, &[(1, 1, 1), (2, 2, -1)])];
            let units = [(0, 1), (0, 2), (1, 2), (1, 0), (2, 0), (2, 1)].map(|(i, j)| unit(3, i, j));
            diagonal.into_iter().chain(units).collect()
        }),
        ("galilei", {
            let boosts = (0..3).map(|i| unit(5, i, 3));
            let translations = (0..3).map(|i| unit(5, i, 4));
            rotations(5).into_iter().chain(boosts).chain(translations).chain([unit(5, 3, 4)]).collect()
        }),
        ("bianchi1", named(&Entry::Abelian(3))),
        ("bianchi2", named(&Entry::Heisenberg)),
        ("bianchi3", bianchi_by([[1, 0], [0, 0]])),
        ("bianchi4", bianchi_by([[1, 1], [0, 1]])),
        ("bianchi5", bianchi_by([[1, 0], [0, 1]])),
        ("bianchi6", bianchi_by([[1, 0], [0, -1]])),
        ("bianchi7", bianchi_by([[0, -1], [1, 0]])),
        ("bianchi8", named(&Entry::Sl2)),
        ("bianchi9", named(&Entry::So3)),
    ]
});

/// The names, in order.
pub(crate) fn names() -> impl Iterator<Item = &'static str> {
    KNOWN.iter().map(|(name, _)| *name)
}

/// The factors of a product by name.
///
/// # Errors
/// The first name that is not known.
pub(crate) fn factors<'a>(names: &'a str) -> Result<Vec<Basis>, &'a str> {
    let factor = |name: &'a str| match (KNOWN.iter().find(|(known, _)| *known == name), name.parse::<Entry>()) {
        (Some((_, basis)), _) => Ok(basis.clone()),
        (None, Ok(entry)) => Ok(named(&entry)),
        (None, Err(_)) => Err(name),
    };
    names.split('+').map(str::trim).map(factor).collect()
}

/// The direct product: bases one after the other, matrices block-diagonal.
pub(crate) fn product(factors: &[Basis]) -> Option<MatrixAlgebra> {
    // Each factor beside zeros of the others.
    let zeros = |factor: &Basis, count: usize| vec![RationalMatrix::zero(factor.first().map_or(0, |m| m.size)); count];
    let mut all = Basis::new();
    for k in 0..factors.len() {
        let count = factors[k].len();
        let block = |j: usize| if j == k { factors[k].clone() } else { zeros(&factors[j], count) };
        all.extend(direct_sum(&(0..factors.len()).map(block).collect::<Vec<_>>()));
    }
    MatrixAlgebra::of_rational(&all)
}

/// The name of an algebra, if these are its matrices.
pub(crate) fn name_of(algebra: &MatrixAlgebra) -> Option<&'static str> {
    let rational = algebra.rational();
    KNOWN.iter().find(|(_, basis)| *basis == rational).map(|(name, _)| *name)
}
