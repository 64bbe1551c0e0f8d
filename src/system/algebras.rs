//! Random algebras that no catalogue lists, each with its group: spans of rational matrices, by family.

use super::dispatch;
use super::generate::Draw;
use super::random::Cases;
use crate::algebra::families::{self, AlgebraFamily, Basis};
use crate::algebra::rational::{RationalAlgebra, RationalMatrix, integer, small};
use crate::algebra::{Entry, MatrixAlgebra, known};
use dashu_ratio::RBig;

/// Percent of those that have a name.
const KNOWN: usize = 8;

/// The largest entry of a matrix and the largest structure constant that are drawn: more makes a motion fast, and nothing else.
const LARGEST: f64 = 3.0;

/// The most draws of a family that the knobs do not admit before another is chosen.
const MOST_DRAWS: usize = 60;

/// The most choices: then there is none.
const MOST_CHOICES: usize = 20;

/// Percent of the algebras in which some basis vectors are shorter by powers of two: constants that nearly vanish, as in a
/// contraction.
const CONTRACTED: usize = 12;

/// An algebra that the knobs admit: one with a name, or of a family and isomorphic to none of the catalogue.
pub(super) fn matrices(draw: &mut Draw<'_>, knobs: &Cases) -> Option<(Option<AlgebraFamily>, MatrixAlgebra)> {
    // Parts that are given say how large an algebra they are for.
    let most = (1..=knobs.most).rev().find(|n| knobs.fixed.fits(*n))?;
    for _ in 0..MOST_CHOICES {
        let drawn = !draw.chance(KNOWN);
        let family = drawn.then(|| AlgebraFamily::ALL[draw.weighted(&AlgebraFamily::WEIGHTS)]);
        // A choice stands for some draws, so that its share does not depend on how often they are in vain.
        let found = (0..MOST_DRAWS).find_map(|_| match family {
            None => admitted(&draw.pick(&known::KNOWN).1, knobs),
            Some(family) => {
                let most = dimension(draw).min(most);
                let mut basis = basis(draw, family, most)?;
                if draw.chance(CONTRACTED) {
                    contract(draw, &mut basis);
                }
                admitted(&basis, knobs).filter(|algebra| algebra.invariants().is_unlisted())
            }
        });
        if let Some(algebra) = found {
            return Some((family, algebra));
        }
    }
    None
}

/// The largest dimension of the next draw: mostly 3 to 6.
fn dimension(draw: &mut Draw<'_>) -> usize {
    [3, 4, 5, 6, 8, 10][draw.weighted(&[30, 25, 17, 18, 5, 5])]
}

/// The algebra of a basis, if it is one, is not abelian, and has numbers and a size that are drawn.
fn admitted(basis: &Basis, knobs: &Cases) -> Option<MatrixAlgebra> {
    let (n, size) = (basis.len(), basis.first()?.size);
    let moderate = |value: &RBig| small(value).is_some_and(|(p, q)| (p as f64 / q as f64).abs() <= LARGEST);
    let fits = knobs.admits_dimension(n) && dispatch::has_class(n, size, knobs.main_dimensions);
    if !fits || !basis.iter().all(|matrix| matrix.entries.values().all(moderate)) {
        return None;
    }
    let algebra = MatrixAlgebra::of_rational(basis)?;
    let slow = algebra.algebra().constants().all(|(_, value)| moderate(value));
    let admitted = knobs.retraction.is_none_or(|tau| !tau.known().of_matrices || algebra.admits_cayley());
    (slow && admitted && !algebra.is_abelian()).then_some(algebra)
}

/// Some basis vectors shorter by powers of two.
fn contract(draw: &mut Draw<'_>, basis: &mut Basis) {
    let power = draw.int(1, 6);
    for matrix in basis.iter_mut() {
        if draw.chance(50) {
            *matrix = matrix.scaled(&(RBig::ONE / integer(1 << power)));
        }
    }
}

/// A basis of an algebra of a family, of dimension `most` at most; `None` where the draw was in vain.
fn basis(draw: &mut Draw<'_>, family: AlgebraFamily, most: usize) -> Option<Basis> {
    Some(match family {
        AlgebraFamily::Commuting => families::commuting(&commuting(draw, most)?),
        AlgebraFamily::TwoStep => two_step(draw, most)?,
        AlgebraFamily::Semidirect => semidirect(draw, most)?,
        AlgebraFamily::Tangent => {
            let small = smaller(draw, most / 2)?;
            families::tangent(&small)
        }
        AlgebraFamily::Incidence => incidence(draw),
        AlgebraFamily::Closure => closure(draw, most)?,
        AlgebraFamily::Derivation => {
            let small = smaller(draw, most.checked_sub(1)?)?;
            let algebra = RationalAlgebra::of_matrices(&small).ok()?;
            let derivation = combined(draw, &algebra.derivations())?;
            families::derivation_extension(&algebra, &derivation)
        }
        AlgebraFamily::Central => {
            let small = smaller(draw, most.checked_sub(1)?.min(6))?;
            let algebra = RationalAlgebra::of_matrices(&small).ok()?;
            let (derivations, cocycles) = (algebra.derivations(), algebra.cocycles());
            let (derivation, cocycle) = (combined(draw, &derivations)?, combined(draw, &cocycles)?);
            let alone = families::central_extension(&algebra, &derivation, &cocycle, &Vec::new());
            match RationalAlgebra::of_matrices(&alone) {
                Ok(_) => alone,
                Err(_) => families::central_extension(&algebra, &derivation, &cocycle, &small),
            }
        }
    })
    .filter(|basis| basis.len() <= most)
}

/// An m×m matrix with entries up to `largest`, `percent` of them not zero.
fn square(draw: &mut Draw<'_>, m: usize, largest: i64, percent: usize) -> RationalMatrix {
    let mut entries = vec![0; m * m];
    for entry in &mut entries {
        *entry = if draw.chance(percent) { draw.int(-largest, largest) } else { 0 };
    }
    RationalMatrix::of(m, |r, c| entries[r * m + c])
}

/// A non-zero combination of a few of the matrices, with coefficients ±1 and ±2.
fn combined(draw: &mut Draw<'_>, matrices: &[RationalMatrix]) -> Option<RationalMatrix> {
    let coefficients: Vec<i64> = matrices.iter().map(|_| if draw.chance(40) { draw.int(-2, 2) } else { 0 }).collect();
    families::combination(matrices, &coefficients).filter(|sum| !sum.entries.is_empty())
}

/// Commuting matrices, k of size m with k + m ≤ most: A in quarters alone, or two or three of 1, A, A².
fn commuting(draw: &mut Draw<'_>, most: usize) -> Option<Basis> {
    let m = draw.int(2, most.checked_sub(1)?.clamp(2, 5) as i64) as usize;
    let k = 1 + draw.weighted(&[60, 30, 10]);
    let a = square(draw, m, if k == 1 { 4 } else { 1 }, 70);
    let one = RationalMatrix::of(m, |r, c| i64::from(r == c));
    Some(match k {
        1 => vec![a.scaled(&(RBig::ONE / integer(4)))],
        2 if draw.chance(50) => vec![one, a],
        2 => vec![a.clone(), a.times(&a)],
        _ => vec![one, a.clone(), a.times(&a)],
    })
}

/// Two steps: m vectors and one to three alternating forms.
fn two_step(draw: &mut Draw<'_>, most: usize) -> Option<Basis> {
    let m = draw.int(2, most.checked_sub(1)?.clamp(2, 5) as i64) as usize;
    let pairs = m * (m - 1) / 2;
    let p = draw.int(1, pairs.min(most.saturating_sub(m)).min(3) as i64) as usize;
    let forms: Vec<RationalMatrix> = (0..p)
        .map(|_| {
            let mut form = square(draw, m, 2, 70);
            let mirrored = form.transposed();
            // Strictly upper part, and its negative below.
            form.entries.retain(|k, _| k / m < k % m);
            let below = mirrored.entries.into_iter().filter(|(k, _)| k / m > k % m).map(|(k, v)| (k, -v));
            form.entries.extend(below);
            form
        })
        .collect();
    Some(families::two_step(&forms))
}

/// A poset of three to five elements and some of the diagonals.
fn incidence(draw: &mut Draw<'_>) -> Basis {
    let size = draw.int(3, 5) as usize;
    let mut below = vec![false; size * size];
    for i in 0..size {
        for j in i + 1..size {
            below[i * size + j] = draw.chance(45);
        }
    }
    // Transitive: elements are in the order of a linear extension.
    for k in 0..size {
        for i in 0..k {
            for j in k + 1..size {
                below[i * size + j] |= below[i * size + k] && below[k * size + j];
            }
        }
    }
    let diagonals: Vec<usize> = (0..size).filter(|_| draw.chance(35)).collect();
    families::incidence(size, &diagonals, |i, j| below[i * size + j])
}

/// The closure of two or three sparse matrices of size 3 or 4.
fn closure(draw: &mut Draw<'_>, most: usize) -> Option<Basis> {
    let (size, count) = (draw.int(3, 4) as usize, draw.int(2, 3));
    let generators: Basis = (0..count)
        .map(|_| {
            let mut matrix = RationalMatrix::zero(size);
            for _ in 0..draw.int(1, 3) {
                let (row, column) = (draw.below(size), draw.below(size));
                matrix.add_to(row, column, &integer(if draw.chance(70) { 1 } else { -1 }));
            }
            matrix
        })
        .collect();
    families::closure(&generators, most).filter(|basis| basis.len() >= 3)
}

/// A smaller algebra to make others of: of the catalogue, or of a family.
fn smaller(draw: &mut Draw<'_>, most: usize) -> Option<Basis> {
    let basis = match draw.weighted(&[55, 15, 10, 20]) {
        0 => {
            let mut named = Entry::NAMED.to_vec();
            named.retain(|entry| entry.dimension() <= 3);
            named.sort_by_key(Entry::to_string);
            named.splice(0..0, [Entry::Abelian(1), Entry::Abelian(2)]);
            families::named(&draw.pick(&named))
        }
        1 => families::commuting(&commuting(draw, most)?),
        2 => two_step(draw, most)?,
        _ => incidence(draw),
    };
    (1..=most).contains(&basis.len()).then_some(basis)
}

/// g ⋉_ρ V, ρ a sum of one or two of the standard representation, its dual, the adjoint one, the symmetric square.
fn semidirect(draw: &mut Draw<'_>, most: usize) -> Option<Basis> {
    let base = smaller(draw, most.checked_sub(1)?)?;
    let algebra = RationalAlgebra::of_matrices(&base).ok()?;
    let mut parts = Vec::new();
    for _ in 0..=draw.weighted(&[75, 25]) {
        parts.push(match draw.weighted(&[35, 20, 30, 15]) {
            0 => base.clone(),
            1 => families::dual(&base),
            2 => families::adjoint(&algebra),
            _ => families::symmetric_square(&base),
        });
    }
    let rho = families::direct_sum(&parts);
    if base.len() + rho.first()?.size > most {
        return None;
    }
    // Beside the standard representation where ρ alone has a kernel.
    let alone = families::semidirect(&[], &rho);
    let faithful = RationalAlgebra::of_matrices(&alone).is_ok();
    Some(if faithful { alone } else { families::semidirect(&base, &rho) })
}
