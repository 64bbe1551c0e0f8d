//! Properties of `euler_poincare::groupoid`.

use euler_poincare::algebra::{Covector, LieAlgebra, Matrix, Vector, pair};
use euler_poincare::group::LieGroup;
use euler_poincare::groupoid::{
    Arrow, Axiom, Bivector, Differential, GaugeGroupoid, Groupoid, NotComposable, PairGroupoid, PointGroupoid,
    PoissonGroupoid, lie_poisson_bivector, poisson_bivector,
};
use euler_poincare::scalar::{Dual, Scalar};
use proptest::prelude::*;
use quickcheck::{Gen, QuickCheck, TestResult, Testable};

/// Three 3×3 matrices, orthogonal in the Frobenius product.
type Basis = [[[i64; 3]; 3]; 3];

/// A group of 3×3 matrices of determinant 1, whose algebra has the basis of `hat`.
struct Test {
    algebra: LieAlgebra<f64, 3>,
    hat: Basis,
}

const HEISENBERG: Basis =
    [[[0, 1, 0], [0, 0, 0], [0, 0, 0]], [[0, 0, 0], [0, 0, 1], [0, 0, 0]], [[0, 0, 1], [0, 0, 0], [0, 0, 0]]];
const ROTATIONS: Basis =
    [[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0]]];
/// Hyperbolic motions of the plane: [e₁, e₂] = e₂, [e₁, e₃] = −e₃.
const MOTIONS: Basis =
    [[[1, 0, 0], [0, -1, 0], [0, 0, 0]], [[0, 0, 1], [0, 0, 0], [0, 0, 0]], [[0, 0, 0], [0, 0, 1], [0, 0, 0]]];

impl Test {
    /// Structure constants from the commutators of the matrices.
    fn new(hat: Basis) -> Self {
        let basis = hat.map(|m| Matrix::<f64, 3>::from_fn(|i, j| m[i][j] as f64));
        let vee = |m: Matrix<f64, 3>, c: usize| m.dot(&basis[c]) / basis[c].dot(&basis[c]);
        let algebra = LieAlgebra::new(|a, b, c| vee(basis[a] * basis[b] - basis[b] * basis[a], c)).unwrap();
        Self { algebra, hat }
    }
}

impl LieGroup<f64, 3, 3> for Test {
    fn algebra(&self) -> &LieAlgebra<f64, 3> {
        &self.algebra
    }
    fn hat<S: Scalar<Base = f64>>(&self, xi: &Vector<S, 3>) -> Matrix<S, 3> {
        Matrix::from_fn(|i, j| (0..3).fold(S::zero(), |sum, a| sum + xi[a] * S::int(self.hat[a][i][j])))
    }
    fn vee<S: Scalar<Base = f64>>(&self, matrix: &Matrix<S, 3>) -> Vector<S, 3> {
        Vector::from_fn(|a, _| {
            let basis = Matrix::<S, 3>::from_fn(|i, j| S::int(self.hat[a][i][j]));
            matrix.dot(&basis) / basis.dot(&basis)
        })
    }
    /// The transposed cofactors: the determinant is 1.
    fn inverse<S: Scalar<Base = f64>>(&self, g: &Matrix<S, 3>) -> Option<Matrix<S, 3>> {
        let at = |i: usize, j: usize| g[(i % 3, j % 3)];
        let cofactor = |i, j| at(i + 1, j + 1) * at(i + 2, j + 2) - at(i + 1, j + 2) * at(i + 2, j + 1);
        g.iter().all(|v| v.all_finite()).then(|| Matrix::from_fn(|i, j| cofactor(j, i)))
    }
}

fn heisenberg(n: [i8; 3]) -> Matrix<f64, 3> {
    let [x, y, z] = n.map(f64::from);
    Matrix::<f64, 3>::new(1.0, x, z, 0.0, 1.0, y, 0.0, 0.0, 1.0)
}

/// The rotation of a unit quaternion.
fn rotation(q: [f64; 4]) -> Matrix<f64, 3> {
    let norm = q.iter().map(|v| v * v).sum::<f64>().sqrt();
    let [w, x, y, z] = q.map(|v| v / norm);
    Matrix::<f64, 3>::new(
        1.0 - 2.0 * (y * y + z * z),
        2.0 * (x * y - w * z),
        2.0 * (x * z + w * y),
        2.0 * (x * y + w * z),
        1.0 - 2.0 * (x * x + z * z),
        2.0 * (y * z - w * x),
        2.0 * (x * z - w * y),
        2.0 * (y * z + w * x),
        1.0 - 2.0 * (x * x + y * y),
    )
}

fn motion(a: f64, x: f64, y: f64) -> Matrix<f64, 3> {
    Matrix::<f64, 3>::new(a.exp(), 0.0, x, 0.0, (-a).exp(), y, 0.0, 0.0, 1.0)
}

/// The distance of the group parts, where the ends agree.
fn distance<B: PartialEq>(a: &Arrow<B, Matrix<f64, 3>>, b: &Arrow<B, Matrix<f64, 3>>) -> f64 {
    let ends = a.source == b.source && a.target == b.target;
    if ends { (a.group - b.group).amax() } else { f64::INFINITY }
}

fn exact<E: PartialEq>(a: &E, b: &E) -> f64 {
    if a == b { 0.0 } else { 1.0 }
}

/// The arrows x₀ → x₁ → x₂ → x₃ with the given group parts.
fn chain<B: Clone, U: Copy>(ends: [B; 4], group: [U; 3]) -> [Arrow<B, U>; 3] {
    std::array::from_fn(|k| Arrow { source: ends[k].clone(), group: group[k], target: ends[k + 1].clone() })
}

fn worst<G: Groupoid>(q: &G, chain: &[G::Element; 3], distance: impl Fn(&G::Element, &G::Element) -> f64) -> f64 {
    let [a, b, c] = chain;
    Axiom::ALL.iter().map(|axiom| axiom.defect(q, [a, b, c], &distance)).fold(0.0, f64::max)
}

/// What is planted in Γ.
#[derive(Clone, Copy, PartialEq)]
enum Fault {
    /// ι without the inverse on U, as published in (4.4).
    Inverse,
    /// ι that does not exchange the ends.
    Ends,
    /// (λ, UV⁻¹, κ).
    Product,
    /// The product keeps the wrong end.
    Target,
    /// ε(λ) = (λ, −1, λ).
    Unit,
}

struct Faulty<'a>(PoissonGroupoid<'a, Test, f64, 3, 3>, &'a Test, Fault);

impl Groupoid for Faulty<'_> {
    type Element = Arrow<Covector<f64, 3>, Matrix<f64, 3>>;
    type Base = Covector<f64, 3>;

    fn source(&self, g: &Self::Element) -> Self::Base {
        self.0.source(g)
    }
    fn target(&self, g: &Self::Element) -> Self::Base {
        self.0.target(g)
    }
    fn unit(&self, x: &Self::Base) -> Self::Element {
        let unit = self.0.unit(x);
        if self.2 == Fault::Unit { Arrow { group: -unit.group, ..unit } } else { unit }
    }
    fn inverse(&self, g: &Self::Element) -> Option<Self::Element> {
        let inverse = self.0.inverse(g)?;
        match self.2 {
            Fault::Inverse => Some(Arrow { group: g.group, ..inverse }),
            Fault::Ends => Some(Arrow { group: inverse.group, ..*g }),
            _ => Some(inverse),
        }
    }
    fn product(&self, a: &Self::Element, b: &Self::Element) -> Self::Element {
        match self.2 {
            Fault::Product => self.0.product(a, &Arrow { group: self.1.inverse(&b.group).unwrap(), ..*b }),
            Fault::Target => Arrow { target: b.source, ..self.0.product(a, b) },
            _ => self.0.product(a, b),
        }
    }
}

fn triples(flat: &[i8]) -> [[i8; 3]; 4] {
    std::array::from_fn(|k| std::array::from_fn(|i| flat.get(3 * k + i).copied().unwrap_or(0)))
}

/// A chain in Γ of the integer Heisenberg group, from the entries of two lists, as far as they go.
fn integer_chain(ends: &[i8], groups: &[i8]) -> [Arrow<Covector<f64, 3>, Matrix<f64, 3>>; 3] {
    let ends = triples(ends).map(|n| Covector::<f64, 3>::from(n.map(f64::from)));
    let [u, v, w, _] = triples(groups).map(heisenberg);
    chain(ends, [u, v, w])
}

fn quick<A: Testable>(property: A) -> Result<u64, TestResult> {
    QuickCheck::new().rng(Gen::from_size_and_seed(12, 2019)).tests(300).quicktest(property)
}

#[test]
fn axioms_hold_exactly_on_integers_by_quickcheck() {
    fn poisson(ends: Vec<i8>, groups: Vec<i8>) -> bool {
        let group = Test::new(HEISENBERG);
        worst(&PoissonGroupoid::new(&group), &integer_chain(&ends, &groups), exact) == 0.0
    }
    fn gauge(ends: Vec<i8>, groups: Vec<i8>) -> bool {
        let group = Test::new(HEISENBERG);
        let [u, v, w, _] = triples(&groups).map(heisenberg);
        worst(&GaugeGroupoid::new(&group), &chain(triples(&ends).map(heisenberg), [u, v, w]), exact) == 0.0
    }
    fn point(groups: Vec<i8>) -> bool {
        let group = Test::new(HEISENBERG);
        let [u, v, w, _] = triples(&groups).map(heisenberg);
        worst(&PointGroupoid::new(&group), &chain([(); 4], [u, v, w]), exact) == 0.0
    }
    fn pairs(q: (i64, i64, i64, i64)) -> bool {
        worst(&PairGroupoid::new(), &[(q.0, q.1), (q.1, q.2), (q.2, q.3)], exact) == 0.0
    }
    assert!(matches!(quick(poisson as fn(Vec<i8>, Vec<i8>) -> bool), Ok(300)));
    assert!(matches!(quick(gauge as fn(Vec<i8>, Vec<i8>) -> bool), Ok(300)));
    assert!(matches!(quick(point as fn(Vec<i8>) -> bool), Ok(300)));
    assert!(matches!(quick(pairs as fn((i64, i64, i64, i64)) -> bool), Ok(300)));
}

/// The axioms that see each planted fault.
fn broken_by(fault: Fault, ends: &[i8], groups: &[i8]) -> Vec<Axiom> {
    let group = Test::new(HEISENBERG);
    let faulty = Faulty(PoissonGroupoid::new(&group), &group, fault);
    let [a, b, c] = &integer_chain(ends, groups);
    Axiom::ALL.into_iter().filter(|axiom| axiom.defect(&faulty, [a, b, c], exact) > 0.0).collect()
}

#[test]
fn planted_faults_break_the_axioms_they_should() {
    let (ends, groups) = ([1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12], [1, 2, 3, -4, 5, 6, 7, -8, 9]);
    use Axiom::*;
    assert_eq!(broken_by(Fault::Inverse, &ends, &groups), [LeftInverse, RightInverse]);
    assert_eq!(broken_by(Fault::Ends, &ends, &groups), [InverseEnds, LeftInverse, RightInverse]);
    assert_eq!(broken_by(Fault::Product, &ends, &groups), [Associativity, LeftUnit, LeftInverse, RightInverse]);
    assert_eq!(broken_by(Fault::Unit, &ends, &groups), [LeftUnit, RightUnit, LeftInverse, RightInverse]);
    assert_eq!(
        broken_by(Fault::Target, &ends, &groups),
        [ProductEnds, Associativity, LeftUnit, LeftInverse, RightInverse]
    );
}

#[test]
fn quickcheck_finds_the_planted_faults() {
    fn inverse(ends: Vec<i8>, groups: Vec<i8>) -> bool {
        broken_by(Fault::Inverse, &ends, &groups).is_empty()
    }
    fn product(ends: Vec<i8>, groups: Vec<i8>) -> bool {
        broken_by(Fault::Product, &ends, &groups).is_empty()
    }
    fn target(ends: Vec<i8>, groups: Vec<i8>) -> bool {
        broken_by(Fault::Target, &ends, &groups).is_empty()
    }
    for property in [inverse, product, target] {
        assert!(quick(property as fn(Vec<i8>, Vec<i8>) -> bool).is_err_and(|result| result.is_failure()));
    }
}

#[test]
fn pairs_that_are_not_composable_are_refused_with_both_points() {
    let group = Test::new(ROTATIONS);
    let gamma = PoissonGroupoid::<_, f64, 3, 3>::new(&group);
    let at = |x: f64| Covector::<f64, 3>::new(x, 0.0, 0.0);
    let arrow = |x: f64, y: f64| Arrow { source: at(x), group: Matrix::<f64, 3>::identity(), target: at(y) };
    let one_up = f64::from_bits(1.0_f64.to_bits() + 1);
    let refused = NotComposable { target: at(1.0), source_of_second: at(one_up) };
    assert_eq!(gamma.compose(&arrow(0.0, 1.0), &arrow(one_up, 2.0)), Err(refused));
    assert_eq!(gamma.compose(&arrow(0.0, 1.0), &arrow(1.0, 2.0)), Ok(arrow(0.0, 2.0)));
    assert!(gamma.compose(&arrow(0.0, f64::NAN), &arrow(f64::NAN, 2.0)).is_err());
    let pairs = PairGroupoid::new();
    let refused = pairs.compose(&("a", "b"), &("c", "d")).unwrap_err();
    assert_eq!((refused.target, refused.source_of_second), ("b", "c"));
    assert!(refused.to_string().contains("\"b\"") && refused.to_string().contains("\"c\""));
    assert_eq!(pairs.compose(&("a", "b"), &("b", "d")), Ok(("a", "d")));
    let singular = Arrow { group: Matrix::<f64, 3>::identity() * f64::NAN, ..arrow(0.0, 1.0) };
    assert_eq!(gamma.inverse(&singular), None);
    assert_eq!(Axiom::LeftInverse.defect(&gamma, [&singular; 3], distance), f64::INFINITY);
}

fn quaternion() -> impl Strategy<Value = [f64; 4]> {
    prop::array::uniform4(-1.0..1.0_f64).prop_filter("too short to normalise", |q| q.iter().any(|v| v.abs() > 0.1))
}

fn vector() -> impl Strategy<Value = Vector<f64, 3>> {
    prop::array::uniform3(-2.0..2.0_f64).prop_map(Vector::from)
}

/// A point of Γ, for each of the three test groups.
fn point() -> impl Strategy<Value = (Basis, Arrow<Covector<f64, 3>, Matrix<f64, 3>>)> {
    let group = prop_oneof![
        quaternion().prop_map(|q| (ROTATIONS, rotation(q))),
        prop::array::uniform3(-3..=3_i8).prop_map(|n| (HEISENBERG, heisenberg(n))),
        vector().prop_map(|v| (MOTIONS, motion(v[0] / 2.0, v[1], v[2]))),
    ];
    (vector(), group, vector()).prop_map(|(lambda, (hat, group), mu)| {
        (hat, Arrow { source: lambda.transpose(), group, target: mu.transpose() })
    })
}

fn flip_lambda(mut bivector: Bivector<f64, 3>) -> Bivector<f64, 3> {
    bivector.blocks[0][0] *= -1.0;
    bivector
}

/// The number of coordinate functions of Γ: λ_a, U_ij, μ_a.
const FUNCTIONS: usize = 15;

/// The differential of coordinate function k.
fn differential<S: Scalar<Base = f64>>(
    group: &Test,
    point: &Arrow<Covector<S, 3>, Matrix<S, 3>>,
    k: usize,
) -> Differential<S, 3> {
    let unit = |a: usize| Vector::<S, 3>::from_fn(|i, _| if i == a { S::one() } else { S::zero() });
    let zero = Vector::<S, 3>::zeros();
    let mut d = Differential { lambda: zero, group: zero.transpose(), mu: zero };
    match k {
        0..3 => d.lambda = unit(k),
        3..12 => d.group = Covector::from_fn(|_, a| (point.group * group.hat(&unit(a)))[((k - 3) / 3, (k - 3) % 3)]),
        _ => d.mu = unit(k - 12),
    }
    d
}

/// {x_f, {x_g, x_h}} + cyclic, with the inner bracket differentiated on dual numbers.
fn jacobi(group: &Test, point: &Arrow<Covector<f64, 3>, Matrix<f64, 3>>, f: [usize; 3], flipped: bool) -> f64 {
    type D = Dual<f64>;
    let sign = if flipped { -1.0 } else { 1.0 };
    let inner = |g: usize, h: usize, direction: usize| {
        let eps = |block: usize, i: usize| if direction == 3 * block + i { 1.0 } else { 0.0 };
        let step = Vector::<D, 3>::from_fn(|i, _| Dual { re: 0.0, eps: eps(1, i) });
        let moved = Arrow {
            source: Covector::<D, 3>::from_fn(|_, i| Dual { re: point.source[i], eps: eps(0, i) }),
            group: point.group.map(D::lift) * (Matrix::<D, 3>::identity() + group.hat(&step)),
            target: Covector::<D, 3>::from_fn(|_, i| Dual { re: point.target[i], eps: eps(2, i) }),
        };
        let mut bivector = poisson_bivector(group, &moved).unwrap();
        bivector.blocks[0][0] *= D::exact(sign);
        bivector.bracket(&differential(group, &moved, g), &differential(group, &moved, h)).eps
    };
    let mut bivector = poisson_bivector(group, point).unwrap();
    bivector.blocks[0][0] *= sign;
    let term = |a: usize, b: usize, c: usize| {
        let part = |block: usize| Vector::<f64, 3>::from_fn(|i, _| inner(b, c, 3 * block + i));
        let d = Differential { lambda: part(0), group: part(1).transpose(), mu: part(2) };
        bivector.bracket(&differential(group, point, a), &d)
    };
    let [a, b, c] = f;
    (term(a, b, c) + term(b, c, a) + term(c, a, b)).abs()
}

/// The derivative of ι in left-trivialised coordinates: (δλ, δu, δμ) ↦ (δμ, −Ad_U δu, δλ).
fn inversion(group: &Test, u: &Matrix<f64, 3>) -> nalgebra::DMatrix<f64> {
    let adjoint = group.adjoint(u).unwrap();
    nalgebra::DMatrix::from_fn(9, 9, |i, j| match (i / 3, j / 3) {
        (0, 2) | (2, 0) => f64::from(i % 3 == j % 3),
        (1, 1) => -adjoint[(i % 3, j % 3)],
        _ => 0.0,
    })
}

proptest! {
    /// Two products of rotations: entries within 3 · 3 u of the exact ones, each side twice, and as much for U⁻¹ by
    /// cofactors and for U not being orthogonal to rounding: 64 u in all.
    #[test]
    fn axioms_hold_on_rotations(q in prop::array::uniform7(quaternion()), ends in prop::array::uniform4(vector())) {
        let group = Test::new(ROTATIONS);
        let r = q.map(rotation);
        let bound = 64.0 * f64::EPSILON / 2.0;
        let gamma = chain(ends.map(|v| v.transpose()), [r[0], r[1], r[2]]);
        prop_assert!(worst(&PoissonGroupoid::new(&group), &gamma, distance) <= bound);
        let gauge = chain([r[3], r[4], r[5], r[6]], [r[0], r[1], r[2]]);
        prop_assert!(worst(&GaugeGroupoid::new(&group), &gauge, distance) <= bound);
        let faulty = Faulty(PoissonGroupoid::new(&group), &group, Fault::Inverse);
        // U² = 1 only at the rotations by π and at e.
        let angle = (0.5 * (r[0].trace() - 1.0)).clamp(-1.0, 1.0).acos();
        if angle.sin() > 1e-3 {
            prop_assert!(worst(&faulty, &gamma, distance) > 1e-4);
        }
    }

    /// The bivector is the bracket as it is written, with commutators and conjugations of matrices for [·,·] and Ad.
    #[test]
    fn the_bivector_is_the_bracket((hat, at) in point(), a in prop::array::uniform3(vector()), b in prop::array::uniform3(vector())) {
        let group = Test::new(hat);
        let inverse = group.inverse(&at.group).unwrap();
        let bracket = |x: &Vector<f64, 3>, y: &Vector<f64, 3>| {
            let (x, y) = (group.hat(x), group.hat(y));
            group.vee(&(x * y - y * x))
        };
        let conjugate = |x: &Vector<f64, 3>| group.vee(&(inverse * group.hat(x) * at.group));
        let written = pair(&at.source, &bracket(&a[0], &b[0])) - pair(&at.target, &bracket(&a[2], &b[2]))
            + pair(&a[1].transpose(), &(b[2] + conjugate(&b[0])))
            - pair(&b[1].transpose(), &(a[2] + conjugate(&a[0])));
        let d = |v: [Vector<f64, 3>; 3]| Differential { lambda: v[0], group: v[1].transpose(), mu: v[2] };
        let bivector = poisson_bivector(&group, &at).unwrap();
        // Some 100 products of sizes below 2³ |Ad|, |Ad| ≤ |U| |U⁻¹|.
        let bound = 100.0 * 8.0 * f64::EPSILON * 9.0 * at.group.amax().max(1.0) * inverse.amax().max(1.0);
        prop_assert!((bivector.bracket(&d(a), &d(b)) - written).abs() <= bound);
        let dense = bivector.dense();
        prop_assert_eq!(dense.transpose(), -dense.clone());
        let row = |v: [Vector<f64, 3>; 3]| nalgebra::DVector::from_fn(9, |i, _| v[i / 3][i % 3]);
        prop_assert!((row(a).dot(&(dense * row(b))) - written).abs() <= bound);
    }

    /// Jacobi on all coordinate functions of one choice; flipped, the λ term breaks it somewhere.
    #[test]
    fn the_bracket_satisfies_jacobi((hat, at) in point(), f in prop::array::uniform3(0..FUNCTIONS)) {
        let group = Test::new(hat);
        let size = at.group.amax().max(1.0) * group.inverse(&at.group).unwrap().amax().max(1.0);
        // Each of the three terms is a sum of some 30 products of 4 factors, at most 2 |U| and |Ad| ≤ 9 |U| |U⁻¹|.
        let bound = 3.0 * 30.0 * f64::EPSILON * 2.0 * size * (9.0 * size).powi(2);
        let defect = jacobi(&group, &at, f, false);
        prop_assert!(defect <= bound, "{defect} {bound}");
    }

    /// ι is anti-Poisson; with the inverse on U left out it is not. α is Poisson and β anti-Poisson for the opposite of
    /// the Lie–Poisson sign.
    #[test]
    fn inversion_is_anti_poisson((hat, at) in point()) {
        let group = Test::new(hat);
        let gamma = PoissonGroupoid::<_, f64, 3, 3>::new(&group);
        let inverse = gamma.inverse(&at).unwrap();
        let bivector = poisson_bivector(&group, &at).unwrap();
        let tangent = inversion(&group, &at.group);
        let defect = |image: &Bivector<f64, 3>| (&tangent * bivector.dense() * tangent.transpose() + image.dense()).amax();
        let size = at.group.amax().max(1.0) * inverse.group.amax().max(1.0);
        let bound = 200.0 * f64::EPSILON * (9.0 * size).powi(2);
        let image = poisson_bivector(&group, &inverse).unwrap();
        prop_assert!(defect(&image) <= bound);
        prop_assert!(defect(&flip_lambda(image)) >= 2.0 * image.blocks[0][0].amax() - bound);
        prop_assert_eq!(bivector.blocks[0][0], -lie_poisson_bivector(group.algebra(), &at.source));
        prop_assert_eq!(bivector.blocks[2][2], lie_poisson_bivector(group.algebra(), &at.target));
    }
}

#[test]
fn jacobi_sees_a_flipped_sign_and_inversion_a_missing_inverse() {
    let at = |group| Arrow {
        source: Covector::<f64, 3>::new(1.0, 2.0, -1.0),
        group,
        target: Covector::<f64, 3>::new(0.5, -1.0, 2.0),
    };
    for (hat, u) in [
        (ROTATIONS, rotation([1.0, 0.5, -0.3, 0.2])),
        (HEISENBERG, heisenberg([1, 2, 3])),
        (MOTIONS, motion(0.3, 1.0, -0.5)),
    ] {
        let group = Test::new(hat);
        let at = at(u);
        let all = |flipped| {
            let triples = (0..FUNCTIONS).flat_map(|a| (0..a).flat_map(move |b| (0..b).map(move |c| [a, b, c])));
            triples.map(|f| jacobi(&group, &at, f, flipped)).fold(0.0, f64::max)
        };
        assert!(all(false) < 1e-12);
        assert!(all(true) > 0.5, "{}", all(true));
        // (λ, U, μ) ↦ (μ, U, λ): (δλ, δu, δμ) ↦ (δμ, δu, δλ).
        let swap = nalgebra::DMatrix::from_fn(9, 9, |i, j| f64::from(i % 3 == j % 3 && i / 3 + j / 3 == 2));
        let image = poisson_bivector(&group, &Arrow { source: at.target, group: u, target: at.source }).unwrap();
        let pi = poisson_bivector(&group, &at).unwrap();
        assert!((&swap * pi.dense() * swap.transpose() + image.dense()).amax() > 0.5);
    }
}

#[test]
fn the_lie_poisson_bivector_has_the_documented_sign() {
    // so(3): {M, N} = −⟨M, [·, ·]⟩, so Π(M) has −ε_abd M_d: Π_12 = −M_3.
    let group = Test::new(ROTATIONS);
    let pi = lie_poisson_bivector(group.algebra(), &Covector::<f64, 3>::new(1.0, 2.0, 3.0));
    assert_eq!(pi, Matrix::<f64, 3>::new(0.0, -3.0, 2.0, 3.0, 0.0, -1.0, -2.0, 1.0, 0.0));
}
