//! Properties of algebras of matrices and of what is drawn of them.
//!
//! Oracles: textbooks for invariants and Casimirs. The laws `group-bracket` and `algebra-casimirs` judge brackets and Casimirs of what is drawn.

use crate::system::refuses::refuses_each;
use euler_poincare::algebra::{AlgebraClass, AlgebraFamily, Casimir, Covector, Vector, pair};
use euler_poincare::scalar::{Dd, Real};
use euler_poincare::system::case::{Structure, Tau};
use euler_poincare::system::{Case, System, Visitor, cases};
use proptest::strategy::{Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use std::collections::BTreeSet;

/// A system file on an algebra of n dimensions.
fn text(algebra: &str, n: usize, retraction: &str) -> String {
    let momentum = vec!["1"; n].join(", ");
    format!(
        "format = 1\n[algebra]\n{algebra}\n[method]\ntableau = \"gauss-1\"\nretraction = \"{retraction}\"\n[state]\n\
         momentum = [{momentum}]\n[run]\nstep = \"1/8\"\nsteps = 1\n"
    )
}

fn on(algebra: &str, n: usize, retraction: &str) -> Result<Case, String> {
    Case::from_toml(&text(algebra, n, retraction)).map_err(|e| e.to_string())
}

/// The matrices of a size, each by the rows, columns and values of its entries (from 1).
fn matrices(size: usize, list: &[&[(usize, usize, i64)]]) -> String {
    let matrix = |entries: &&[(usize, usize, i64)]| {
        let entry = |r, c| entries.iter().filter(|(i, j, _)| (*i, *j) == (r, c)).map(|(_, _, v)| v).sum::<i64>();
        let rows: Vec<_> =
            (1..=size).map(|r| format!("{:?}", (1..=size).map(|c| entry(r, c)).collect::<Vec<_>>())).collect();
        format!("[{}]", rows.join(", "))
    };
    format!("matrices = [{}]", list.iter().map(matrix).collect::<Vec<_>>().join(", "))
}

/// Boosts and rotations of space-time.
const GALILEI: &str = "name = \"galilei\"";

#[test]
fn invariants_are_those_of_the_textbooks() {
    let gl2 = matrices(2, &[&[(1, 1, 1)], &[(1, 2, 1)], &[(2, 1, 1)], &[(2, 2, 1)]]);
    let upper = [(1, 2, 1), (2, 3, 1), (3, 4, 1), (1, 3, 1), (2, 4, 1), (1, 4, 1)];
    let upper = matrices(4, &upper.each_ref().map(std::slice::from_ref));
    type Facts<'a> = (&'a str, usize, AlgebraClass, [usize; 3], usize, usize, bool);
    let all: [Facts; 5] = [
        // The algebra; dimension, class, Killing form, centre, Casimirs of degree 1 and 2, Cayley.
        ("name = \"sl3\"", 8, AlgebraClass::Semisimple, [5, 3, 0], 0, 1, false),
        ("name = \"so31\"", 6, AlgebraClass::Semisimple, [3, 3, 0], 0, 2, true),
        (&gl2, 4, AlgebraClass::Mixed, [2, 1, 1], 1, 2, true),
        (&upper, 6, AlgebraClass::Nilpotent, [0, 0, 6], 1, 2, true),
        // The centre of the Euclidean group of time is none; |p|² is the only polynomial of degree 2.
        (GALILEI, 10, AlgebraClass::Mixed, [0, 3, 7], 0, 1, true),
    ];
    for (name, dimension, class, killing, centre, casimirs, cayley) in all {
        let case = on(name, dimension, "exp").unwrap();
        let found = case.algebra.structure.invariants().expect("matrices");
        assert_eq!((found.class(), found.killing, found.centre), (class, killing, centre), "{name}: {found}");
        assert_eq!(case.casimir_count(), casimirs, "{name}");
        // gl(2) is sl(2) + ℝ.
        assert_eq!(found.is_unlisted(), name != gl2, "{name}: {found}");
        assert_eq!(case.check(), Ok(()), "{name}");
        let dispatched = on(name, dimension, "cayley").unwrap().check();
        assert_eq!(dispatched.is_ok(), cayley, "{name}: {dispatched:?}");
    }
    // se(2) by other matrices is listed.
    let motions = matrices(3, &[&[(2, 1, 2), (1, 2, -2)], &[(1, 3, 1)], &[(2, 3, 1)]]);
    assert!(!on(&motions, 3, "exp").unwrap().algebra.structure.invariants().unwrap().is_unlisted());
}

#[test]
fn drawn_algebras_are_of_every_family_and_dimension() {
    let knobs = cases().with_group().changed_basis(false).retraction(Tau::Exponential);
    let mut runner = TestRunner::deterministic();
    let (mut families, mut dimensions, mut casimirs) = (BTreeSet::new(), BTreeSet::new(), 0);
    for _ in 0..600 {
        let case = knobs.new_tree(&mut runner).unwrap().current();
        let Structure::Matrices { family, algebra } = &case.algebra.structure else { continue };
        families.extend(*family);
        dimensions.insert(algebra.dimension());
        casimirs += usize::from(algebra.casimir_count() > 0);
        assert!(family.is_none() || algebra.invariants().is_unlisted(), "{case}");
        // The file is the case.
        assert_eq!(Case::from_toml(&case.to_toml().unwrap()).unwrap(), case);
    }
    assert_eq!(families.len(), AlgebraFamily::ALL.len(), "{families:?}");
    assert!(dimensions.len() >= 8 && casimirs > 100, "{dimensions:?}, {casimirs}");
}

#[test]
fn a_casimir_of_degree_three_is_found() {
    // The filiform algebra of dimension 4, [e_1, e_2] = e_3, [e_1, e_3] = e_4, has μ_3² − 2 μ_2 μ_4. That of dimension 5 has
    // one of degree 3 besides, with e_5 = [e_1, e_4].
    let filiform = |n: usize| {
        let constants: Vec<_> = (2..n).map(|k| format!("[1, {k}, {}, 1]", k + 1)).collect();
        on(&format!("dimension = {n}\nconstants = [{}]", constants.join(", ")), n, "exp").unwrap()
    };
    assert_eq!(filiform(4).casimir_count(), 2);
    assert_eq!(filiform(5).casimir_count(), 3);
    let degree = |case: Case| case.dispatch::<Dd, _>(Degrees).unwrap();
    assert_eq!(degree(filiform(5)), [1, 2, 3]);
    // |p|², of ten dimensions.
    assert_eq!(degree(on(GALILEI, 10, "exp").unwrap()), [2]);
}

/// The degrees of the Casimirs, each of which is one to 30 digits.
struct Degrees;

impl<T: Real> Visitor<T> for Degrees {
    type Output = Vec<usize>;

    fn visit<const N: usize, const D: usize>(self, system: System<T, N, D>) -> Vec<usize> {
        let mu = Covector::<T, N>::from_fn(|_, a| T::int(a as i64 + 1) / T::int(7));
        let degree = |casimir: &Casimir<T, N>| {
            let gradient = casimir.gradient(&mu);
            let eta = Vector::<T, N>::from_fn(|a, _| T::int(3 - a as i64));
            assert!(pair(&system.algebra.coad(&eta, &mu), &gradient).abs() < T::exact(1e-29));
            // Euler: ⟨μ, dC⟩ = degree C.
            (pair(&mu, &gradient) / casimir.value(&mu)).to_f64().round() as usize
        };
        system.casimirs.iter().map(degree).collect()
    }
}

#[test]
fn constants_without_a_centre_have_the_adjoint_group() {
    let so3 = "dimension = 3\nconstants = [[1, 2, 3, 1], [2, 3, 1, 1], [3, 1, 2, 1]]";
    let case = on(so3, 3, "cayley").unwrap();
    assert_eq!((case.matrix_size(), case.casimir_count(), case.check()), (3, 1, Ok(())));
    let heisenberg = on("dimension = 3\nconstants = [[1, 2, 3, 1]]", 3, "exp").unwrap();
    assert_eq!((heisenberg.matrix_size(), heisenberg.casimir_count(), heisenberg.check()), (0, 1, Ok(())));
    // Irrational constants: no exact arithmetic, so no group.
    let scaled = on("dimension = 2\nconstants = [[1, 2, 2, \"sqrt(2)\"]]", 2, "exp").unwrap();
    assert_eq!((scaled.matrix_size(), scaled.casimir_count(), scaled.check()), (0, 0, Ok(())));
}

#[test]
fn matrices_that_are_no_basis_of_an_algebra_are_refused() {
    let line = text("name = \"r1\"", 1, "exp");
    refuses_each(&line, include_str!("systems/wrong/algebras.txt"), 11, |_, _, _| true);
    // One dimension in matrices of 13×13.
    let large = matrices(13, &[&[(1, 13, 1)]]);
    assert!(on(&large, 1, "exp").unwrap_err().contains("13×13 matrices for dimension 1"));
}

#[test]
fn algebras_by_matrices_have_names() {
    let facts = |name: &str| on(&format!("name = \"{name}\""), 1, "exp").unwrap().algebra.structure.invariants();
    // The class and the signature of Killing's form.
    let known = "su2 Simple 0 3 0, su11 Simple 2 1 0, so31 Semisimple 3 3 0, so5 Semisimple 0 10 0, sp4 Semisimple 6 4 0, \
                 sl3 Semisimple 5 3 0, galilei Mixed 0 3 7, bianchi1 Abelian 0 0 3, bianchi2 Nilpotent 0 0 3, \
                 bianchi3 Solvable 1 0 2, bianchi4 Solvable 1 0 2, bianchi5 Solvable 1 0 2, bianchi6 Solvable 1 0 2, \
                 bianchi7 Solvable 0 1 2, bianchi8 Simple 2 1 0, bianchi9 Simple 0 3 0, sl3+r1 Mixed 5 3 1";
    for (name, expected) in known.split(", ").map(|row| row.split_once(' ').unwrap()) {
        let found = facts(name).expect("matrices");
        let [plus, minus, zero] = found.killing;
        assert_eq!(format!("{:?} {plus} {minus} {zero}", found.class()), expected, "{name}: {found}");
    }
    // What is no product of these, and what is too large.
    for (name, wanted) in [("sl3+so6", "\"so6\""), ("sl3+sl2", "dimension 11"), ("so5+r64", "dimension 74")] {
        assert!(on(&format!("name = \"{name}\""), 1, "exp").unwrap_err().contains(wanted), "{name}");
    }
    let galilei = on("name = \"galilei\"", 10, "exp").unwrap();
    assert!(galilei.to_toml().unwrap().contains("name = \"galilei\"") && galilei.to_string().contains("galilei"));
}
