//! Properties of `euler_poincare::algebra`.
//!
//! Oracles: the defining identity for Casimirs, textbook classifications. That structure constants are commutators of matrices is in `group.rs`.

use euler_poincare::algebra::brackets::Brackets;
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{
    AlgebraError, Casimir, Covector, LieAlgebra, Matrix, MatrixAlgebra, Vector, elimination,
};
use euler_poincare::scalar::{Dd, Dual, Number, Real};
use euler_poincare::system::named_algebras;
use nalgebra::DMatrix;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Every factor of the catalogue, and products, in the dimensions 3 and 6 of `System`, whose code is in the library, with the facts that hold (from textbooks).
const CATALOGUE: &str = "r3: abelian unimodular nilpotent solvable; so3: unimodular semisimple; se2: unimodular solvable; se3: unimodular; \
                         sl2: unimodular semisimple; aff1+r1: solvable; heisenberg: unimodular nilpotent solvable; \
                         so4: unimodular semisimple; so3+sl2: unimodular semisimple; so3+r3: unimodular; \
                         heisenberg+r3: unimodular nilpotent solvable; aff1+heisenberg+r1: solvable; aff1+so3+r1: ";

fn catalogue() -> impl Iterator<Item = (&'static str, &'static str)> {
    CATALOGUE.split("; ").map(|row| row.split_once(": ").unwrap())
}

const FACTS: [&str; 5] = ["abelian", "unimodular", "nilpotent", "solvable", "semisimple"];

/// Tests that run `$check::<N, T>(&entry, &facts)` for every entry, with its dimension as N, in 16 digits and in 32.
macro_rules! on_catalogue {
    ($($name:ident: $check:ident;)*) => {
        $(#[test] fn $name() {
            for (name, facts) in catalogue() {
                let (entry, facts): (Entry, _) = (name.parse().unwrap(), FACTS.map(|fact| facts.contains(fact)));
                match entry.dimension() {
                    3 => {
                        $check::<3, f64>(&entry, &facts);
                        $check::<3, Dd>(&entry, &facts);
                    }
                    6 => {
                        $check::<6, f64>(&entry, &facts);
                        $check::<6, Dd>(&entry, &facts);
                    }
                    n => panic!("{name}: dimension {n} is not dispatched"),
                }
            }
        })*
    };
}

on_catalogue! {
    classification_is_that_of_the_textbooks_in_any_basis: facts_hold;
    brackets_are_the_same_in_any_basis: brackets_agree_in_any_basis;
    casimirs_are_complete_and_other_forms_are_none: casimirs_are_complete;
}

pub fn uniform<T: Real>(rng: &mut ChaCha8Rng) -> T {
    T::exact(rng.random_range(-1.0..1.0))
}

/// A random basis of condition number about `condition`: Q D R with random Q, R near orthogonal and D graded.
pub fn random_basis<const N: usize, T: Real>(rng: &mut ChaCha8Rng, condition: f64) -> Matrix<T, N> {
    let mut turn =
        || Matrix::<f64, N>::from_fn(|r, c| if r == c { 1.0 } else { 0.5 * rng.random_range(-1.0..1.0) / N as f64 });
    let grade = Vector::<f64, N>::from_fn(|r, _| condition.powf(-(r as f64) / (N.max(2) - 1) as f64));
    (turn() * Matrix::from_diagonal(&grade) * turn()).map(T::exact)
}

fn facts_hold<const N: usize, T: Real>(entry: &Entry, facts: &[bool; 5]) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let standard = LieAlgebra::<T, N>::from_catalogue(entry).unwrap();
    let bases = [1.0, 10.0, 300.0].map(|condition| random_basis::<N, T>(&mut rng, condition));
    for basis in [Matrix::identity()].iter().chain(&bases) {
        let g = standard.in_basis(basis).unwrap();
        assert_eq!([g.is_abelian(), g.is_unimodular()], facts[..2], "{entry} in {basis:?}: abelian, unimodular");
    }
}

/// Exactly: of the matrices e_a of the catalogue, and of e_a' = Σ P_ab e_b, P_ab = min(a, b), of determinant 1.
#[test]
fn invariants_are_those_of_the_textbooks_in_any_basis() {
    for (name, facts) in catalogue() {
        let (entry, facts): (Entry, _) = (name.parse().unwrap(), FACTS.map(|fact| facts.contains(fact)));
        let n = entry.dimension();
        let e: Vec<DMatrix<f64>> = (0..n).map(|a| entry.basis_matrix(a)).collect();
        let invariants = |p: &DMatrix<f64>| {
            let matrix = |a: usize| (1..n).fold(&e[0] * p[(a, 0)], |sum, b| sum + &e[b] * p[(a, b)]);
            let rows = |m: DMatrix<f64>| {
                m.row_iter().map(|row| row.iter().map(|v| Number::from(*v as i64)).collect()).collect()
            };
            MatrixAlgebra::new((0..n).map(|a| rows(matrix(a))).collect()).unwrap().invariants()
        };
        let found = invariants(&DMatrix::identity(n, n));
        let ends = |series: &[usize]| series.last() == Some(&0);
        let [nilpotent, solvable] = [&found.lower_central_series, &found.derived_series].map(|series| ends(series));
        let of_form = [found.centre == n, found.unimodular, nilpotent, solvable, found.killing[2] == 0];
        assert_eq!(of_form, facts, "{entry}: abelian, unimodular, nilpotent, solvable, semisimple");
        assert_eq!(
            invariants(&DMatrix::from_fn(n, n, |a, b| a.min(b) as f64 + 1.0)),
            found,
            "{entry} in another basis"
        );
    }
}

/// The brackets that the documentation of `Entry` has, by (a, b, c, C^c_ab) with a < b: from matrices alone other signs would follow as well.
#[test]
fn brackets_are_those_of_the_documentation() {
    // ε_ijk e_k' for [e_i, e_j'], each of the latter two from here on.
    let turns = |b: usize, c: usize| {
        let sign = |i: usize, j: usize| if (i + 1) % 3 == j { 1 } else { -1 };
        let pairs = (0..9).map(|k| (k / 3, k % 3)).filter(|(i, j)| i != j);
        pairs.map(move |(i, j)| (i, b + j, c + 3 - i - j, sign(i, j)))
    };
    let so3 = turns(0, 0).filter(|(a, b, ..)| a < b);
    let se3: Vec<_> = so3.clone().chain(turns(3, 3)).collect();
    let boosts = so3.clone().map(|(a, b, c, value)| (3 + a, 3 + b, c, value));
    for (entry, brackets) in [
        (Entry::Abelian(3), Vec::new()),
        (Entry::So3, so3.clone().collect()),
        (Entry::Se2, vec![(0, 1, 2, 1), (0, 2, 1, -1)]),
        (Entry::So4, se3.iter().copied().chain(boosts).collect()),
        (Entry::Se3, se3),
        (Entry::Sl2, vec![(0, 1, 1, 2), (0, 2, 2, -2), (1, 2, 0, 1)]),
        (Entry::Aff1, vec![(0, 1, 1, 1)]),
        (Entry::Heisenberg, vec![(0, 1, 2, 1)]),
    ] {
        let n = entry.dimension();
        for (a, b, c) in (0..n * n * n).map(|k| (k / (n * n), k / n % n, k % n)).filter(|(a, b, _)| a < b) {
            let value =
                brackets.iter().find(|found| (found.0, found.1, found.2) == (a, b, c)).map_or(0, |found| found.3);
            assert_eq!(entry.constant::<f64>(a, b, c), f64::from(value), "{entry}: {a} {b} {c}");
        }
    }
}

/// Of every name of the catalogue, also of one that no list here has.
#[test]
fn matrices_are_orthogonal_and_closed() {
    let entries: Vec<Entry> = named_algebras().filter_map(|name| name.parse().ok()).collect();
    assert_eq!(entries.len(), 8);
    for entry in entries {
        let e: Vec<DMatrix<f64>> = (0..entry.dimension()).map(|a| entry.basis_matrix(a)).collect();
        for (a, b) in (0..e.len() * e.len()).map(|k| (k / e.len(), k % e.len())) {
            assert_eq!(a == b, e[a].dot(&e[b]) != 0.0, "{entry}: {a} {b}");
            let bracket = &e[a] * &e[b] - &e[b] * &e[a];
            let left = (0..e.len()).fold(bracket, |left, c| left - &e[c] * entry.constant::<f64>(a, b, c));
            assert!(left.iter().all(|x| *x == 0.0), "{entry}: [e_{a}, e_{b}]");
        }
    }
}

#[test]
fn killing_form() {
    let so3 = LieAlgebra::<f64, 3>::from_catalogue(&Entry::So3).unwrap();
    assert_eq!(so3.killing(), Matrix::<f64, 3>::identity() * -2.0);
    let sl2 = LieAlgebra::<f64, 3>::from_catalogue(&Entry::Sl2).unwrap();
    assert_eq!(sl2.killing(), Matrix::<f64, 3>::new(8.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 4.0, 0.0));
}

/// [e_0, e_1] = e_0, [e_1, e_2] = `s` e_1: breaks Jacobi at s ≠ 0, since the cyclic sum is s e_0.
fn broken(scale: f64, s: f64) -> impl Fn(usize, usize, usize) -> f64 {
    move |a, b, c| match (a, b, c) {
        (0, 1, 0) => scale,
        (1, 0, 0) => -scale,
        (1, 2, 1) => s * scale,
        (2, 1, 1) => -s * scale,
        _ => 0.0,
    }
}

/// The defect of Jacobi's identity that is taken for rounding, 64 N² u, is relative to the square of the constants.
#[test]
fn jacobi_may_fail_by_rounding_at_any_size() {
    const U: f64 = f64::EPSILON / 2.0;
    for scale in [1.0, 1.25, 1.5, 1.9, 1e-200, 1.9e100] {
        for (units, allowed) in [(400.0, true), (700.0, false)] {
            let algebra = LieAlgebra::<f64, 3>::new(broken(scale, units * U));
            assert_eq!(algebra.is_ok(), allowed, "{scale:e}, {units} u: {algebra:?}");
        }
    }
}

#[test]
fn constants_that_are_no_algebra_are_refused() {
    for scale in [1.0, 1e-200, 1e200, 1e-160, 1e155] {
        assert!(LieAlgebra::<f64, 3>::new(broken(scale, 0.0)).is_ok(), "{scale:e}");
        for s in [1.0, 1e-10] {
            let error = LieAlgebra::<f64, 3>::new(broken(scale, s)).unwrap_err();
            let AlgebraError::Jacobi { a: 0, b: 1, c: 2, defect } = error else { panic!("{scale:e}: {error}") };
            assert!((defect / s - 1.0).abs() < 1e-5, "{scale:e}: defect {defect:e}, expected {s:e}");
        }
    }
    for (skew, refused) in [(1e-12, true), (1e-15, false)] {
        let algebra = LieAlgebra::<f64, 3>::new(|a, b, c| {
            Entry::So3.constant::<f64>(a, b, c) + if (a, b, c) == (2, 0, 1) { skew } else { 0.0 }
        });
        match algebra {
            Err(error) => assert!(refused && matches!(error, AlgebraError::NotAntisymmetric { a: 0, b: 2, c: 1, .. })),
            Ok(algebra) => assert!(!refused && algebra.constant(2, 0, 1) == -algebra.constant(0, 2, 1)),
        }
    }
    let diagonal = LieAlgebra::<f64, 2>::new(|a, b, c| if (a, b, c) == (1, 1, 0) { 0.5 } else { 0.0 });
    assert_eq!(diagonal, Err(AlgebraError::NotAntisymmetric { a: 1, b: 1, c: 0, defect: 1.0 }));
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let error = LieAlgebra::<f64, 3>::new(|a, b, c| if (a, b, c) == (0, 1, 2) { bad } else { 0.0 }).unwrap_err();
        assert_eq!(error, AlgebraError::NotFinite { what: "structure constant C^3_{1 2} (indices from 1)".into() });
    }
    let error = LieAlgebra::<f64, 4>::from_catalogue(&Entry::So3).unwrap_err();
    assert_eq!(error.to_string(), "the algebra so3 has dimension 3, expected 4");
    assert!(matches!(Entry::Se3.casimirs::<f64, 3>(), Err(AlgebraError::Dimension { dimension: 6, expected: 3, .. })));
}

#[test]
fn singular_bases_are_refused_and_graded_ones_are_not() {
    let so3 = LieAlgebra::<f64, 3>::from_catalogue(&Entry::So3).unwrap();
    let bases = [
        Matrix::<f64, 3>::zeros(),
        Matrix::<f64, 3>::new(1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0),
        Matrix::<f64, 3>::new(0.1, 0.2, 0.3, 0.2, 0.4, 0.6, 0.0, 1.0, 0.0),
        Matrix::<f64, 3>::from_diagonal(&Vector::<f64, 3>::new(1.0, 0.0, 1.0)),
    ];
    for basis in bases {
        let error = so3.in_basis(&basis).unwrap_err();
        assert!(matches!(error, AlgebraError::SingularBasis { condition } if condition > 1e15), "{error}");
        assert!(Casimir::Quadratic(Matrix::identity()).in_basis(&basis).is_err());
    }
    for bad in [f64::NAN, f64::INFINITY] {
        let mut basis = Matrix::<f64, 3>::identity();
        basis[(1, 2)] = bad;
        assert_eq!(so3.in_basis(&basis), Err(AlgebraError::NotFinite { what: "the basis change".into() }));
    }
    let grade = Vector::<f64, 3>::new(2.0_f64.powi(-100), 1.0, 2.0_f64.powi(100));
    let graded = so3.in_basis(&Matrix::from_diagonal(&grade)).unwrap();
    assert_eq!(graded.constant(0, 1, 2), 2.0_f64.powi(-200));
    assert_eq!(graded.constant(1, 2, 0), 2.0_f64.powi(200));
    // The lengths of the new basis vectors are no matter, in a skew basis either.
    let skew = Matrix::<f64, 3>::new(2.0, 1.0, 0.0, 1.0, 3.0, 1.0, 0.0, 1.0, 2.0);
    let (plain, graded) =
        (so3.in_basis(&skew).unwrap(), so3.in_basis(&(skew * Matrix::from_diagonal(&grade))).unwrap());
    for (a, b, c) in [(0, 1, 2), (1, 2, 0), (0, 2, 1), (0, 2, 2), (0, 1, 1)] {
        let scaled = plain.constant(a, b, c) * (grade[a] * grade[b] / grade[c]);
        let error = (graded.constant(a, b, c) - scaled).abs();
        assert!(error <= 1e-14 * scaled.abs(), "C^{c}_{a}{b}: {error:e} of {scaled:e}");
    }
    let huge = so3.in_basis(&Matrix::from_diagonal(&Vector::<f64, 3>::new(1e-300, 1e200, 1e200)));
    assert!(matches!(huge, Err(AlgebraError::NotFinite { .. } | AlgebraError::SingularBasis { .. })), "{huge:?}");
}

fn brackets_agree_in_any_basis<const N: usize, T: Real>(entry: &Entry, _: &[bool; 5]) {
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let standard = LieAlgebra::<T, N>::from_catalogue(entry).unwrap();
    for condition in [1.0, 1e3, 1e7] {
        let basis = random_basis::<N, T>(&mut rng, condition);
        let inverse = elimination::inverse(&basis).unwrap();
        let g = standard.in_basis(&basis).unwrap();
        let x = Vector::<T, N>::from_fn(|_, _| uniform(&mut rng));
        let y = Vector::<T, N>::from_fn(|_, _| uniform(&mut rng));
        let mu = Covector::<T, N>::from_fn(|_, _| uniform(&mut rng));
        // The new constants B⁻¹ ad B: rounding u |B⁻¹| |B|², that of B⁻¹ another κ; then back through B.
        let kappa = basis.norm() * inverse.norm();
        let size = kappa * kappa * basis.norm() * basis.norm() * x.norm() * y.norm();
        let bound = T::int(32 * (N * N) as i64) * T::unit_roundoff() * size;
        let defect = (basis * g.bracket::<T>(&x, &y) - standard.bracket::<T>(&(basis * x), &(basis * y))).norm();
        assert!(defect <= bound, "{entry}, condition {condition:e}: {defect:e} > {bound:e}");
        // The same by the constants that are not zero.
        let brackets = Brackets::of(&g);
        let lane = |v: &Vector<T, N>| -> [[T; 1]; N] { std::array::from_fn(|a| [v[a]]) };
        let one = |v: [[T; 1]; N]| Vector::<T, N>::from_fn(|a, _| v[a][0]);
        let differences = [
            (one(brackets.brackets(&lane(&x), &lane(&y))) - g.bracket::<T>(&x, &y)).norm() / y.norm(),
            (one(brackets.coads(&lane(&x), &lane(&mu.transpose()))).transpose() - g.coad(&x, &mu)).norm() / mu.norm(),
        ];
        let indices = || (0..N).flat_map(|a| (0..N).flat_map(move |b| (0..N).map(move |c| (a, b, c))));
        let largest = indices().fold(T::zero(), |m, (a, b, c)| m.max(g.constant(a, b, c).abs()));
        let bound = T::int(8 * (N * N) as i64) * T::unit_roundoff() * largest * x.norm();
        assert!(differences.into_iter().all(|d| d <= bound), "{entry}: {differences:?} > {bound:e}");
        for (a, b, c) in indices() {
            assert!(g.constant(a, b, c) == -g.constant(b, a, c), "{entry}: antisymmetry");
        }
        // C'(μB) = C(μ).
        for c in entry.casimirs::<T, N>().unwrap() {
            let (old, moved) = (c.value::<T>(&(mu * inverse)), c.in_basis(&basis).unwrap().value::<T>(&mu));
            let size = mu.norm() * inverse.norm();
            let bound = T::int(128 * (N * N) as i64) * T::unit_roundoff() * kappa * kappa * size.max(size * size);
            assert!(
                (old - moved).abs() <= bound,
                "{entry}, {c:?}: {old:e} and {moved:e} differ by more than {bound:e}"
            );
        }
    }
}

/// |dC(μ)(ad*_ξ μ)| relative to |μ| |ad_ξ| |dC|.
fn drift<const N: usize, T: Real>(
    g: &LieAlgebra<T, N>,
    c: &Casimir<T, N>,
    mu: &Covector<T, N>,
    xi: &Vector<T, N>,
) -> T {
    let (moved, slope) = (g.coad(xi, mu), c.gradient(mu));
    let size = mu.norm() * g.ad(xi).norm() * slope.norm();
    if size == T::zero() { T::zero() } else { (moved * slope)[0].abs() / size }
}

/// [e_a, e_b].
fn basis_bracket<const N: usize, T: Real>(g: &LieAlgebra<T, N>, a: usize, b: usize) -> Vector<T, N> {
    Vector::from_fn(|c, _| g.constant(a, b, c))
}

fn casimirs_are_complete<const N: usize, T: Real>(entry: &Entry, facts: &[bool; 5]) {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let g = LieAlgebra::<T, N>::from_catalogue(entry).unwrap();
    let casimirs = entry.casimirs::<T, N>().unwrap();
    let mu = Covector::<T, N>::from_fn(|_, _| uniform(&mut rng));
    let xi = Vector::<T, N>::from_fn(|_, _| uniform(&mut rng));
    // As many as the codimension of the generic coadjoint orbit, and independent.
    let orbit = Matrix::<T, N>::from_fn(|a, b| (mu * basis_bracket(&g, a, b))[0]);
    let threshold = T::unit_roundoff().sqrt();
    assert_eq!(casimirs.len(), N - elimination::rank(&orbit, threshold), "{entry}: number");
    let mut slopes = Matrix::<T, N>::zeros();
    for (a, c) in casimirs.iter().enumerate() {
        slopes.set_column(a, &c.gradient(&mu));
    }
    assert_eq!(elimination::rank(&slopes, threshold), casimirs.len(), "{entry}: independence");
    // Controls, which are no Casimirs: a coordinate outside the centre, a random form.
    for a in (0..N).filter(|a| (0..N).any(|b| basis_bracket(&g, *a, b).norm() > T::zero())) {
        let mut e = Vector::<T, N>::zeros();
        e[a] = T::one();
        assert!(drift(&g, &Casimir::Linear(e), &mu, &xi) > T::ratio(1, 10000), "{entry}: mu_{a}");
    }
    let random = Matrix::<T, N>::from_fn(|_, _| uniform(&mut rng));
    let found = drift(&g, &Casimir::Quadratic(random + random.transpose()), &mu, &xi);
    assert_eq!(found > T::ratio(1, 10000), !facts[0], "{entry}: random form {found:e}");
}

#[test]
fn names_round_trip_and_bad_ones_say_what_is_allowed() {
    for (name, _) in catalogue() {
        assert_eq!(name.parse::<Entry>().unwrap().to_string(), name);
    }
    assert_eq!(" so3 + r2 ".parse::<Entry>().unwrap(), Entry::Product(vec![Entry::So3, Entry::Abelian(2)]));
    for bad in ["", "so5", "r", "r0", "r01", "r65", "r-1", "r99999999999999999999", "so3+", "so3 x r2", "SO3", "r²"] {
        let error = bad.parse::<Entry>().unwrap_err().to_string();
        assert!(error.contains("heisenberg") && error.contains("r64") && error.contains("so3+r2"), "{error}");
    }
    // Beyond the dimension there is nothing.
    assert_eq!(Entry::So3.constant::<f64>(0, 3, 0), 0.0);
    assert_eq!(Entry::So3.basis_matrix::<f64>(3), DMatrix::zeros(3, 3));
    let nested = Entry::Product(vec![Entry::Product(vec![Entry::So3, Entry::Aff1]), Entry::Abelian(1)]);
    let flat: Entry = nested.to_string().parse().unwrap();
    for (a, b, c) in [(0, 1, 2), (3, 4, 4), (4, 3, 4), (0, 3, 4), (5, 4, 4), (2, 5, 5)] {
        assert_eq!(nested.constant::<f64>(a, b, c), flat.constant::<f64>(a, b, c));
    }
}

fn inverse_is_accurate<T: Real>() {
    // Hilbert's matrix of size 6 times lcm(1 … 11), so with integer entries; its inverse is known (Choi 1983).
    let scale = 27720_i64;
    let hilbert = Matrix::<T, 6>::from_fn(|r, c| T::int(scale / (r + c + 1) as i64));
    let binomial = |n: usize, k: usize| (0..k).fold(1_i64, |v, i| v * (n - i) as i64 / (i + 1) as i64);
    let exact = Matrix::<T, 6>::from_fn(|r, c| {
        let (i, j) = (r + 1, c + 1);
        let sign = if (i + j) % 2 == 0 { 1 } else { -1 };
        let square = binomial(i + j - 2, i - 1) * binomial(i + j - 2, i - 1);
        let value = sign * (i + j - 1) as i64 * binomial(6 + i - 1, 6 - j) * binomial(6 + j - 1, 6 - i) * square;
        T::int(value) / T::int(scale)
    });
    let error = (elimination::inverse(&hilbert).unwrap() - exact).norm() / exact.norm();
    let bound = T::int(16 * 6) * T::unit_roundoff() * T::exact(1.5e7);
    assert!(error <= bound, "Hilbert: {error:e} > {bound:e}");
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    for condition in [1.0, 1e4, 1e6] {
        // Two small singular values, where cofactors lose the square of the condition number.
        let turn = random_basis::<3, T>(&mut rng, 1.0);
        let small = T::exact(1.0 / condition);
        let a = turn * Matrix::from_diagonal(&Vector::<T, 3>::new(T::one(), small, small)) * turn.transpose();
        let x = elimination::inverse(&a).unwrap();
        let bound = T::int(64) * T::unit_roundoff() * a.norm() * x.norm();
        let (left, right) = ((x * a - Matrix::identity()).norm(), (a * x - Matrix::identity()).norm());
        assert!(left <= bound && right <= bound, "condition {condition:e}: {left:e}, {right:e} > {bound:e}");
        let slope = Matrix::<T, 3>::from_fn(|_, _| uniform(&mut rng));
        let dual = elimination::inverse(&a.zip_map(&slope, |re, eps| Dual { re, eps })).unwrap();
        let off = (dual.map(|v| v.eps) + x * slope * x).norm();
        assert!(off <= bound * x.norm() * x.norm() * slope.norm(), "derivative off by {off:e}");
    }
    for _ in 0..100 {
        // Columns that their diagonals dominate, narrowly or not: without pivots, or with them.
        let off = Matrix::<T, 6>::from_fn(|_, _| uniform(&mut rng)) * T::exact(0.25);
        let a = Matrix::<T, 6>::identity() - off;
        let x = elimination::inverse(&a).unwrap();
        let bound = T::int(64) * T::unit_roundoff() * a.norm() * x.norm();
        let (left, right) = ((x * a - Matrix::identity()).norm(), (a * x - Matrix::identity()).norm());
        assert!(left <= bound && right <= bound, "{a}: {left:e}, {right:e} > {bound:e}");
    }
    let graded = Matrix::<T, 2>::new(T::exact(1e-40), T::one(), T::zero(), T::one());
    let x = elimination::inverse(&graded).unwrap();
    assert!((x[(0, 0)] * T::exact(1e-40) - T::one()).abs() <= T::unit_roundoff() * T::int(4));
    assert_eq!(elimination::inverse(&Matrix::<T, 2>::new(T::one(), T::one(), T::one(), T::one())), None);
    assert_eq!(elimination::inverse(&Matrix::<T, 2>::new(T::exact(f64::NAN), T::one(), T::one(), T::zero())), None);
}

in_both! {
    inverse_is_accurate_to_the_condition_number: inverse_is_accurate;
}
