//! Properties of `euler_poincare::groupoid`. The laws `groupoid-*` judge the axioms, and who is composable, on random groupoids of each kind.

use euler_poincare::algebra::{Covector, Matrix, Vector};
use euler_poincare::group::{LieGroup, MatrixGroup};
use euler_poincare::groupoid::{
    ActionGroupoid, Arrow, AtiyahGroupoid, Axiom, DenseGroup, DenseSpace, Groupoid, LieAlgebroid, LieGroupoid, Lowered,
    Manifold, NotComposable, TrivialGroupoid, bracket_of_fields, commutator, lie_poisson_bivector, poisson_bivector,
    section_bracket,
};
use euler_poincare::harness::Fault;
use euler_poincare::laws::planted::groupoid::{
    ENDS_KEPT, INVERSE_KEEPS_U, PRODUCT_KEEPS_END, Planted, SECOND_INVERTED,
};
use euler_poincare::scalar::Dual;
use nalgebra::{DMatrix, DVector, Quaternion, UnitQuaternion};
use proptest::prelude::*;

/// Three 3×3 matrices, orthogonal in the Frobenius product.
type Basis = [[[i64; 3]; 3]; 3];

const HEISENBERG: Basis =
    [[[0, 1, 0], [0, 0, 0], [0, 0, 0]], [[0, 0, 0], [0, 0, 1], [0, 0, 0]], [[0, 0, 1], [0, 0, 0], [0, 0, 0]]];
const ROTATIONS: Basis =
    [[[0, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 0, 1], [0, 0, 0], [-1, 0, 0]], [[0, -1, 0], [1, 0, 0], [0, 0, 0]]];
/// Hyperbolic motions of the plane: [e₁, e₂] = e₂, [e₁, e₃] = −e₃.
const MOTIONS: Basis =
    [[[1, 0, 0], [0, -1, 0], [0, 0, 0]], [[0, 0, 1], [0, 0, 0], [0, 0, 0]], [[0, 0, 0], [0, 0, 1], [0, 0, 0]]];

/// The group of these matrices, of determinant 1.
fn group(hat: Basis) -> MatrixGroup<f64, 3, 3> {
    MatrixGroup::new(hat.map(|m| Matrix::from_fn(|i, j| m[i][j] as f64))).unwrap()
}

fn heisenberg(n: [i8; 3]) -> Matrix<f64, 3> {
    let [x, y, z] = n.map(f64::from);
    Matrix::<f64, 3>::new(1.0, x, z, 0.0, 1.0, y, 0.0, 0.0, 1.0)
}

/// The rotation of a quaternion.
fn rotation([w, x, y, z]: [f64; 4]) -> Matrix<f64, 3> {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).to_rotation_matrix().into_inner()
}

fn motion(a: f64, x: f64, y: f64) -> Matrix<f64, 3> {
    Matrix::<f64, 3>::new(a.exp(), 0.0, x, 0.0, (-a).exp(), y, 0.0, 0.0, 1.0)
}

/// The copy of a group whose sizes are known at run time, over which the groupoids are.
fn dense(hat: Basis) -> DenseGroup<f64> {
    DenseGroup::of(&group(hat))
}

fn square(g: &Matrix<f64, 3>) -> DMatrix<f64> {
    DMatrix::from_column_slice(3, 3, g.as_slice())
}

fn list(x: &[f64]) -> DVector<f64> {
    DVector::from_column_slice(x)
}

/// The distance of the group parts, where the ends agree.
fn distance<B: PartialEq>(a: &Arrow<B, DMatrix<f64>>, b: &Arrow<B, DMatrix<f64>>) -> f64 {
    let ends = a.source == b.source && a.target == b.target;
    if ends { (&a.group - &b.group).amax() } else { f64::INFINITY }
}

fn exact<E: PartialEq>(a: &E, b: &E) -> f64 {
    if a == b { 0.0 } else { 1.0 }
}

/// The arrows x₀ → x₁ → x₂ → x₃ with the given group parts.
fn chain<B: Clone>(ends: [B; 4], group: [Matrix<f64, 3>; 3]) -> [Arrow<B, DMatrix<f64>>; 3] {
    std::array::from_fn(|k| Arrow { source: ends[k].clone(), group: square(&group[k]), target: ends[k + 1].clone() })
}

type Gamma = TrivialGroupoid<DenseSpace, f64>;
type Element = Arrow<DVector<f64>, DMatrix<f64>>;

/// Γ with other units and inverses.
struct Changed {
    gamma: Gamma,
    unit: fn(Element) -> Element,
    inverse: fn(&Element, Element) -> Element,
}

impl Groupoid for Changed {
    type Element = Element;
    type Base = DVector<f64>;

    fn source(&self, g: &Element) -> Self::Base {
        self.gamma.source(g)
    }
    fn target(&self, g: &Element) -> Self::Base {
        self.gamma.target(g)
    }
    fn unit(&self, x: &Self::Base) -> Element {
        (self.unit)(self.gamma.unit(x))
    }
    fn inverse(&self, g: &Element) -> Option<Element> {
        Some((self.inverse)(g, self.gamma.inverse(g)?))
    }
    fn product(&self, a: &Element, b: &Element) -> Element {
        self.gamma.product(a, b)
    }
}

fn triples(flat: &[i8]) -> [[i8; 3]; 4] {
    std::array::from_fn(|k| std::array::from_fn(|i| flat.get(3 * k + i).copied().unwrap_or(0)))
}

/// A chain in Γ of the integer Heisenberg group, from the entries of two lists, as far as they go.
fn integer_chain(ends: &[i8], groups: &[i8]) -> [Element; 3] {
    let ends = triples(ends).map(|n| list(&n.map(f64::from)));
    let [u, v, w, _] = triples(groups).map(heisenberg);
    chain(ends, [u, v, w])
}

/// The axioms that do not hold on a chain.
fn broken_on<Q: Groupoid<Element: PartialEq>>(q: &Q, [a, b, c]: &[Q::Element; 3]) -> Vec<Axiom> {
    Axiom::ALL.into_iter().filter(|axiom| axiom.defect(q, [a, b, c], exact) > 0.0).collect()
}

/// The axioms that see a fault in Γ.
fn broken_by(fault: &Fault, ends: &[i8], groups: &[i8]) -> Vec<Axiom> {
    let gamma = Gamma::poisson(dense(HEISENBERG));
    let chain = integer_chain(ends, groups).map(|g| gamma.coordinates(&g));
    broken_on(&Planted::<_, f64>::new(gamma, Some(fault)), &chain)
}

const ENDS: [i8; 12] = [1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12];
const GROUPS: [i8; 9] = [1, 2, 3, -4, 5, 6, 7, -8, 9];

#[test]
fn planted_faults_break_the_axioms_they_should() {
    use Axiom::*;
    let broken = |fault| broken_by(&fault, &ENDS, &GROUPS);
    assert_eq!(broken(INVERSE_KEEPS_U), [LeftInverse, RightInverse]);
    assert_eq!(broken(ENDS_KEPT), [InverseEnds, LeftInverse, RightInverse]);
    assert_eq!(broken(SECOND_INVERTED), [Associativity, LeftUnit, LeftInverse, RightInverse]);
    assert_eq!(broken(PRODUCT_KEEPS_END), [ProductEnds, Associativity, LeftUnit, LeftInverse, RightInverse]);
}

#[test]
fn a_wrong_unit_or_one_wrong_end_of_the_inverse_is_enough() {
    let broken = |unit, inverse| {
        let gamma = Gamma::poisson(dense(HEISENBERG));
        broken_on(&Changed { gamma, unit, inverse }, &integer_chain(&ENDS, &GROUPS))
    };
    use Axiom::*;
    let negative = |unit: Element| Arrow { group: -unit.group, ..unit };
    assert_eq!(broken(|unit| unit, |_, inverse| inverse), []);
    assert_eq!(broken(negative, |_, inverse| inverse), [LeftUnit, RightUnit, LeftInverse, RightInverse]);
    assert!(broken(|unit| unit, |g, inverse| Arrow { target: g.target.clone(), ..inverse }).contains(&InverseEnds));
    assert!(broken(|unit| unit, |g, inverse| Arrow { source: g.source.clone(), ..inverse }).contains(&InverseEnds));
}

/// A right action, by hand and exact on integers: Ad*_g μ is (μ_1 − y μ_3, μ_2 + x μ_3, μ_3) on the Heisenberg group, μg on SO(3).
#[test]
fn arrows_end_where_the_coadjoint_action_leads() {
    let quarter = Matrix::<f64, 3>::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let third = Matrix::<f64, 3>::new(0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0);
    for (hat, u, v, end) in [
        (HEISENBERG, heisenberg([1, 2, 3]), heisenberg([-4, 5, 6]), [-5.0, 5.0, 3.0]),
        (ROTATIONS, quarter, third, [2.0, -1.0, 3.0]),
    ] {
        let (q, x) = (ActionGroupoid::<f64>::new(dense(hat)), list(&[1.0, 2.0, 3.0]));
        let one = q.arrow(&x, &square(&u)).unwrap();
        assert_eq!(one.target, list(&end));
        let two = q.arrow(&one.target, &square(&v)).unwrap();
        assert_eq!(q.compose(&one, &two), Ok(q.arrow(&x, &square(&(u * v))).unwrap()));
    }
}

#[test]
fn pairs_that_are_not_composable_are_refused_with_both_points() {
    let gamma = Gamma::poisson(dense(ROTATIONS));
    let at = |x: f64| list(&[x, 0.0, 0.0]);
    let arrow = |x: f64, y: f64| Arrow { source: at(x), group: DMatrix::identity(3, 3), target: at(y) };
    let one_up = f64::from_bits(1.0_f64.to_bits() + 1);
    let refused = NotComposable { target: at(1.0), source_of_second: at(one_up) };
    assert_eq!(gamma.compose(&arrow(0.0, 1.0), &arrow(one_up, 2.0)), Err(refused));
    assert_eq!(gamma.compose(&arrow(0.0, 1.0), &arrow(1.0, 2.0)), Ok(arrow(0.0, 2.0)));
    assert!(gamma.compose(&arrow(0.0, f64::NAN), &arrow(f64::NAN, 2.0)).is_err());
    let refused = NotComposable { target: "b", source_of_second: "c" }.to_string();
    assert!(refused.contains("\"b\"") && refused.contains("\"c\""));
    let singular = Arrow { group: DMatrix::identity(3, 3) * f64::NAN, ..arrow(0.0, 1.0) };
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

proptest! {
    /// The copy with sizes at run time computes the same as the group.
    #[test]
    fn the_dense_group_is_the_group((hat, at) in point(), xi in vector(), eta in vector()) {
        let group = group(hat);
        let dense = DenseGroup::of(&group);
        let u = square(&at.group);
        let size = at.group.amax().max(1.0) * group.inverse(&at.group).unwrap().amax().max(1.0);
        let near = |a: f64| a <= 500.0 * f64::EPSILON * size * size;
        let adjoint = group.adjoint(&at.group).unwrap();
        prop_assert!(near((square(&adjoint) - dense.adjoint(&u).unwrap()).amax()));
        let z = Manifold::<f64>::coordinates(&dense, &u);
        prop_assert_eq!(z.as_slice(), at.group.as_slice());
        let (frame, bracket) = (at.group * group.hat(&xi), group.algebra().bracket(&xi, &eta));
        let (xi, eta) = (list(xi.as_slice()), list(eta.as_slice()));
        prop_assert!(near((list(frame.as_slice()) - dense.frame(&z, &xi)).amax()));
        prop_assert!(near((list(bracket.as_slice()) - dense.structure(&xi, &eta)).amax()));
        prop_assert!(near((dense.velocity(&z, &dense.frame(&z, &xi)).unwrap() - &xi).amax()));
    }

    /// A frame over every point of the sphere but for rounding, with the point itself as third column.
    #[test]
    fn frames_lie_over_their_points(q in quaternion(), r in quaternion(), s in quaternion()) {
        let x = rotation(q).column(2).into_owned();
        let frame: Matrix<f64, 3> = AtiyahGroupoid::lift(&x);
        prop_assert_eq!(frame.column(2), x);
        prop_assert!((frame.transpose() * frame - Matrix::<f64, 3>::identity()).amax() <= 16.0 * f64::EPSILON);
        prop_assert!((frame.determinant() - 1.0).abs() <= 16.0 * f64::EPSILON);
        // [p, q] = [p·k, q·k], and the product of classes over one point exists.
        let atiyah = AtiyahGroupoid::<f64>::new();
        let k = AtiyahGroupoid::divide(&Matrix::identity(), &rotation(r));
        let distance = |g: &_, h: &_| (atiyah.coordinates(g) - atiyah.coordinates(h)).amax();
        let class = (rotation(q), rotation(s));
        let same = (class.0 * k, class.1 * k);
        prop_assert_eq!(atiyah.source(&same), atiyah.source(&class));
        prop_assert!(distance(&class, &same) <= 16.0 * f64::EPSILON);
        prop_assert!(distance(&class, &(class.0, class.1 * k)) > 0.0 || k[(0, 0)] == 1.0);
        let square = atiyah.compose(&atiyah.inverse(&class).unwrap(), &same).unwrap();
        prop_assert!(distance(&square, &atiyah.unit(&atiyah.target(&class))) <= 64.0 * f64::EPSILON);
    }
}

#[test]
fn the_lie_poisson_bivector_has_the_documented_sign() {
    // so(3): {M, N} = −⟨M, [·, ·]⟩, so Π(M) has −ε_abd M_d: Π_12 = −M_3.
    let pi = lie_poisson_bivector(&dense(ROTATIONS), &list(&[1.0, 2.0, 3.0]));
    assert_eq!(pi, DMatrix::from_row_slice(3, 3, &[0.0, -3.0, 2.0, 3.0, 0.0, -1.0, -2.0, 1.0, 0.0]));
}

type Second = Dual<Dual<f64>>;

#[test]
fn vector_fields_on_the_plane_have_their_bracket() {
    // X = x ∂_y and Y = y ∂_x: [X, Y] = x ∂_x − y ∂_y.
    let pair = TrivialGroupoid::<_, Second>::pairs(DenseSpace { dimension: 2 });
    let zero = Dual::constant(0.0);
    let x = |z: &DVector<Dual<f64>>| DVector::from_vec(vec![zero, z[0]]);
    let y = |z: &DVector<Dual<f64>>| DVector::from_vec(vec![z[1], zero]);
    let at = DVector::from_vec(vec![3.0, 5.0]);
    let expected = DVector::from_vec(vec![3.0, -5.0]);
    assert_eq!(bracket_of_fields(&pair, &x, &y, &at), Some(expected.clone()));
    assert_eq!(commutator(&|z| Some(x(z)), &|z| Some(y(z)), &at), Some(expected.clone()));
    assert_eq!(section_bracket(&Lowered(&Lowered(&pair)), &x, &y, &at), expected);
}

/// (dimension of the base, rank of the algebroid), and that an element is that of its coordinates, which are as many.
#[test]
fn elements_are_those_of_their_coordinates() {
    fn numbers<Q: LieGroupoid<f64>>(q: &Q, g: &Q::Element) -> (usize, usize, usize)
    where
        Q::Element: PartialEq + std::fmt::Debug,
    {
        let z = q.coordinates(g);
        assert_eq!(q.element(&z), *g);
        for x in [q.source(g), q.target(g)] {
            assert_eq!(q.base_point(&q.base_coordinates(&x)), x);
        }
        (q.base_dimension(), q.rank(), z.len())
    }
    let group = || dense(MOTIONS);
    let [u, v, w] = [(0.5, 1.0, 2.0), (-0.25, 3.0, 4.0), (0.125, 5.0, 6.0)].map(|(a, x, y)| square(&motion(a, x, y)));
    let (x, y) = (list(&[1.0, 2.0, 3.0]), list(&[4.0, 5.0, 6.0]));
    let arrow = |source: &DVector<f64>, group: &DMatrix<f64>, target: &DVector<f64>| Arrow {
        source: source.clone(),
        group: group.clone(),
        target: target.clone(),
    };
    let (nothing, trivial) = (list(&[]), DMatrix::zeros(0, 0));
    assert_eq!(numbers(&Gamma::point(group()), &arrow(&nothing, &u, &nothing)), (0, 3, 9));
    let gauge = Arrow { source: u.clone(), group: v.clone(), target: w.clone() };
    assert_eq!(numbers(&TrivialGroupoid::gauge(group()), &gauge), (3, 6, 27));
    assert_eq!(numbers(&Gamma::poisson(group()), &arrow(&x, &v, &y)), (3, 6, 15));
    assert_eq!(numbers(&Gamma::pairs(DenseSpace { dimension: 3 }), &arrow(&x, &trivial, &y)), (3, 3, 6));
    let pair = Arrow { source: u, group: trivial.clone(), target: w };
    assert_eq!(numbers(&TrivialGroupoid::pairs(group()), &pair), (3, 3, 18));
    assert_eq!(numbers(&ActionGroupoid::new(group()), &arrow(&x, &v, &y)), (3, 3, 15));
}

#[test]
fn the_algebroid_of_a_group_is_its_algebra() {
    let point = TrivialGroupoid::<_, Second>::point(dense(ROTATIONS));
    let constant = |v: [f64; 3]| move |_: &DVector<Dual<f64>>| DVector::from_fn(3, |i, _| Dual::constant(v[i]));
    let bracket = bracket_of_fields(&point, &constant([1.0, 2.0, 3.0]), &constant([4.0, 5.0, 6.0]), &DVector::zeros(0));
    assert_eq!(bracket, Some(DVector::from_vec(vec![-3.0, 6.0, -3.0])));
    assert_eq!(LieAlgebroid::<Second>::rank(&point), 3);
}

#[test]
fn invariant_fields_of_the_frames_project_to_rotations_of_the_sphere() {
    let atiyah = AtiyahGroupoid::<f64>::new();
    let e = |i: usize| DVector::from_fn(3, |j, _| if i == j { 1.0 } else { 0.0 });
    // e_1 × e_3 = −e_2; [F_1, F_2] = −F_3.
    assert_eq!(atiyah.anchor(&e(2), &e(0)), -e(1));
    assert_eq!(atiyah.structure(&e(2), &e(0), &e(1)), -e(2));
}

#[test]
fn generators_have_the_brackets_of_their_definition() {
    let quarter = Matrix::<f64, 3>::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
    let at = Arrow { source: list(&[1.0, 2.0, 3.0]), group: square(&quarter), target: list(&[4.0, 5.0, 6.0]) };
    let rotations = dense(ROTATIONS);
    let pi = poisson_bivector(&rotations, &at).unwrap();
    assert_eq!((pi[(0, 1)], pi[(6, 7)], pi[(0, 7)]), (3.0, -6.0, 0.0));
    // d tr U = (tr(U ê_a)) for δU = U ê_a. −tr(U ê_3) = −tr(ê_3 U): U is the quarter turn about e_3.
    let trace = DVector::from_fn(3, |a, _| (quarter * group(ROTATIONS).hat(&Vector::ith(a, 1.0))).trace());
    let with_trace = |generator: usize| (0..3).map(|a| pi[(generator, 3 + a)] * trace[a]).sum::<f64>();
    assert_eq!((with_trace(8), with_trace(2)), (2.0, 2.0));
    let singular = Arrow { group: DMatrix::identity(3, 3) * f64::NAN, ..at };
    assert_eq!(poisson_bivector(&rotations, &singular), None);
}
