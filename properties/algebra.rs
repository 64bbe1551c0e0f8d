//! Properties of `euler_poincare::algebra`.
//!
//! Oracles: commutators of the representing matrices for the structure constants, the defining identity for Casimirs,
//! textbook classifications.

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{AlgebraError, Casimir, Covector, LieAlgebra, Matrix, Vector, elimination};
use euler_poincare::scalar::{Real, Scalar};
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Every factor of the catalogue, and products; abelian, unimodular, nilpotent, solvable, semisimple (from textbooks).
const CATALOGUE: [(&str, [bool; 5]); 15] = [
    ("r1", [true, true, true, true, false]),
    ("r3", [true, true, true, true, false]),
    ("so3", [false, true, false, false, true]),
    ("se2", [false, true, false, true, false]),
    ("se3", [false, true, false, false, false]),
    ("sl2", [false, true, false, false, true]),
    ("aff1", [false, false, false, true, false]),
    ("heisenberg", [false, true, true, true, false]),
    ("so4", [false, true, false, false, true]),
    ("so3+sl2", [false, true, false, false, true]),
    ("so3+r2", [false, true, false, false, false]),
    ("heisenberg+r1", [false, true, true, true, false]),
    ("aff1+heisenberg+r1", [false, false, false, true, false]),
    ("aff1+so3", [false, false, false, false, false]),
    ("se3+aff1", [false, false, false, false, false]),
];

/// Runs `$check::<N, $scalar>(&entry, &facts)` for every entry, with its dimension as N.
macro_rules! for_catalogue {
    ($check:ident, $scalar:ty) => {
        for (name, facts) in CATALOGUE {
            let entry: Entry = name.parse().unwrap();
            match entry.dimension() {
                1 => $check::<1, $scalar>(&entry, &facts),
                2 => $check::<2, $scalar>(&entry, &facts),
                3 => $check::<3, $scalar>(&entry, &facts),
                4 => $check::<4, $scalar>(&entry, &facts),
                5 => $check::<5, $scalar>(&entry, &facts),
                6 => $check::<6, $scalar>(&entry, &facts),
                8 => $check::<8, $scalar>(&entry, &facts),
                n => panic!("{name}: dimension {n} is not dispatched"),
            }
        }
    };
}

fn uniform<T: Real>(rng: &mut ChaCha8Rng) -> T {
    T::exact(rng.random_range(-1.0..1.0))
}

/// A random basis of condition number about `condition`: Q D R with random Q, R near orthogonal and D graded.
fn random_basis<const N: usize, T: Real>(rng: &mut ChaCha8Rng, condition: f64) -> Matrix<T, N> {
    let mut turn =
        || Matrix::<f64, N>::from_fn(|r, c| if r == c { 1.0 } else { 0.5 * rng.random_range(-1.0..1.0) / N as f64 });
    let grade =
        Matrix::<f64, N>::from_fn(
            |r, c| {
                if r == c { condition.powf(-(r as f64) / (N.max(2) - 1) as f64) } else { 0.0 }
            },
        );
    (turn() * grade * turn()).map(T::exact)
}

fn constants_are_commutators<const N: usize, T: Real>(entry: &Entry, _: &[bool; 5]) {
    let algebra = LieAlgebra::<T, N>::from_catalogue(entry).unwrap();
    let e: Vec<DMatrix<T>> = (0..N).map(|a| entry.basis_matrix(a)).collect();
    for a in 0..N {
        assert!(e[a].iter().any(|v| *v != T::zero()), "{entry}: matrix {a} vanishes");
        assert_eq!(e[a].shape(), (entry.matrix_size(), entry.matrix_size()));
        for b in 0..N {
            let mut defect = &e[a] * &e[b] - &e[b] * &e[a];
            for c in 0..N {
                defect -= &e[c] * algebra.constant(a, b, c);
            }
            assert!(defect.iter().all(|v| *v == T::zero()), "{entry}: [e_{a}, e_{b}]");
        }
    }
    assert_eq!(entry.constant::<T>(0, N, 0), T::zero());
    assert_eq!(entry.basis_matrix::<T>(N).iter().filter(|v| **v != T::zero()).count(), 0);
}

#[test]
fn structure_constants_are_those_of_the_representation() {
    for_catalogue!(constants_are_commutators, f64);
}

fn facts_hold<const N: usize, T: Real>(entry: &Entry, facts: &[bool; 5]) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let standard = LieAlgebra::<T, N>::from_catalogue(entry).unwrap();
    let bases = [1.0, 10.0, 300.0].map(|condition| random_basis::<N, T>(&mut rng, condition));
    for basis in [Matrix::identity()].iter().chain(&bases) {
        let g = standard.in_basis(basis).unwrap();
        let found = [g.is_abelian(), g.is_unimodular(), g.is_nilpotent(), g.is_solvable(), g.is_semisimple()];
        assert_eq!(found, *facts, "{entry} in {basis:?}: abelian, unimodular, nilpotent, solvable, semisimple");
        assert_eq!(g.derived_dimension(), standard.derived_dimension(), "{entry}");
    }
}

#[test]
fn classification_is_that_of_the_textbooks_in_any_basis() {
    for_catalogue!(facts_hold, f64);
}
