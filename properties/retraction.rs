//! Properties of `euler_poincare::retraction`. Up to a size of 4 the laws `retraction-*` judge the general engine on random groups.
//!
//! Every bound is a multiple of the unit round-off u times the sizes of the factors whose rounding enters (below called
//! the scale), so the same bound holds for every scalar; the multiple allowed is 4 N.

use euler_poincare::algebra::brackets::Brackets;
use euler_poincare::algebra::{Entry, LieAlgebra, Matrix, Vector};
use euler_poincare::group::{LieGroup, MatrixGroup};
use euler_poincare::retraction::beside::BesideRetraction;
use euler_poincare::retraction::coefficients::Coefficients;
use euler_poincare::retraction::{
    AnyRetraction, Cayley, CayleySo3, Composed, Exponential, ExponentialSo3, OddTerm, Retraction, RetractionError,
    TangentPoint,
};
use euler_poincare::scalar::dual::derivative;
use euler_poincare::scalar::{Dd, Dual, Real, Scalar};
use euler_poincare::system::case::Tau;

// The dimensions and types of `System`, of which everything is compiled in the library: 3 beside matrices of size 4, 6 beside 8, and
// the closed forms on SO(3).

fn general<T: Real, const N: usize, const D: usize>(name: &str) -> MatrixGroup<T, N, D> {
    MatrixGroup::from_entry(&name.parse::<Entry>().unwrap()).unwrap()
}

/// The same algebra in a random, moderately conditioned basis: nothing stays sparse or symmetric.
fn changed<T: Real, const N: usize, const D: usize>(group: &MatrixGroup<T, N, D>) -> MatrixGroup<T, N, D> {
    let mut random = Random(5);
    let move_by = Matrix::<f64, N>::from_fn(|_, _| random.signed() * 0.3);
    group.in_basis(&(Matrix::identity() + move_by.map(T::exact))).unwrap()
}

fn exp<T: Real, const N: usize, const D: usize>(name: &str) -> AnyRetraction<T, N, D> {
    AnyRetraction::Exponential(Exponential::of_group(general(name)))
}

fn cay<T: Real, const N: usize, const D: usize>(name: &str) -> AnyRetraction<T, N, D> {
    AnyRetraction::Cayley(Cayley::new(general(name)).unwrap())
}

const CLOSED: [Tau; 2] = [Tau::Cayley, Tau::Exponential];

fn closed<T: Real>(tau: Tau) -> BesideRetraction<T, 3, 3> {
    BesideRetraction::so3(tau).unwrap()
}

/// SL(3), which the catalogue does not have, beside two lines: matrices that have a 1 each in their last column.
fn sl3() -> MatrixGroup<f64, 10, 12> {
    let mut basis = [Matrix::<f64, 12>::zeros(); 10];
    let diagonal = [(0, 0, 1.0), (0, 1, -1.0), (1, 1, 1.0), (1, 2, -1.0)];
    diagonal.into_iter().for_each(|(a, i, value)| basis[a][(i, i)] = value);
    let off = [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (3, 5), (4, 5)];
    off.into_iter().enumerate().for_each(|(a, entry)| basis[a + 2][entry] = 1.0);
    MatrixGroup::new(basis).unwrap()
}

/// A matrix of size D with `block` as its leading block, and the identity beside it.
fn padded<const B: usize, const D: usize>(block: Matrix<f64, B>) -> Matrix<f64, D> {
    Matrix::from_fn(|r, c| if r < B && c < B { block[(r, c)] } else { f64::from(u8::from(r == c)) })
}

/// Deterministic pseudo-random numbers (SplitMix64).
struct Random(u64);

impl Random {
    /// Uniform in [−1, 1), a multiple of 2⁻²⁰, so exact in every scalar.
    fn signed(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e3779b97f4a7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58476d1ce4e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d049bb133111eb);
        ((z ^ (z >> 31)) >> 43) as f64 / 1048576.0 - 1.0
    }
    fn vector<const N: usize>(&mut self) -> Vector<f64, N> {
        Vector::<f64, N>::from_fn(|_, _| self.signed())
    }
    /// A vector with its largest component log-uniform between the magnitudes.
    fn magnitude<const N: usize>(&mut self, low: f64, high: f64) -> Vector<f64, N> {
        let v = self.vector::<N>();
        let size = low * (high / low).powf(0.5 * (self.signed() + 1.0));
        v * (size / v.amax().max(1e-3))
    }
}

fn exact<T: Scalar, const N: usize>(v: &Vector<f64, N>) -> Vector<T, N> {
    v.map(T::exact)
}

fn size<T: Scalar, const R: usize, const C: usize>(m: &nalgebra::SMatrix<T, R, C>) -> f64 {
    m.iter().fold(0.0, |s: f64, v| if v.to_f64().is_nan() { f64::NAN } else { s.max(v.to_f64().abs()) })
}

/// The largest defect/(u × scale) seen, by identity, each with the size of x where it was seen and how often it was tried.
#[derive(Default, Debug)]
struct Worst(std::collections::BTreeMap<&'static str, (f64, f64, usize)>);

impl Worst {
    fn note(&mut self, name: &'static str, defect: f64, scale: f64, at: f64) {
        let ratio = defect / scale;
        let entry = self.0.entry(name).or_insert((0.0, 0.0, 0));
        entry.2 += 1;
        if ratio > entry.0 || ratio.is_nan() {
            (entry.0, entry.1) = (ratio, at);
        }
    }

    /// Every identity holds within `bound`, and was tried at least `least` times.
    fn judge(&self, subject: &str, bound: f64, least: usize) {
        for (name, (ratio, at, count)) in &self.0 {
            assert!(*ratio <= bound, "{subject}: {name}: {ratio:.2} > {bound} (in units of u × scale) at |x| = {at:e}");
            assert!(*count >= least, "{subject}: {name} was tried {count} times only, expected {least}");
        }
    }
}

/// Whether x is refused because it is outside the domain; any other error fails the test.
fn outside<P>(result: Result<P, RetractionError>) -> Option<P> {
    match result {
        Ok(point) => Some(point),
        Err(RetractionError::SingularTangent { .. } | RetractionError::OutsideDomain { .. }) => None,
        Err(error) => panic!("{error}"),
    }
}

/// What singles a retraction out, at x with largest component log-uniform in 1e-12 … `domain`; τ and dτ far from 0; and what steps use.
fn identities<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>>(
    subject: &str,
    retraction: &R,
    group: &MatrixGroup<T, N, D>,
    domain: f64,
) {
    let mut random = Random(7);
    let mut worst = Worst::default();
    const CASES: usize = 200;
    for _ in 0..CASES {
        let x = exact::<T, N>(&random.magnitude::<N>(1e-12, domain));
        let [y, z] = std::array::from_fn(|_| exact::<T, N>(&random.vector()));
        let m = exact::<T, N>(&random.vector()).transpose();
        let Some(point) = outside(retraction.at(&x)) else { continue };
        let (d, d_inv, d_neg, at) = (*point.d(), *point.d_inv(), point.d_neg(), size(&x));
        let (g, back) = (retraction.tau(&x).unwrap(), retraction.tau(&-x).unwrap());
        let grown = T::unit_roundoff().to_f64() * (1.0 + size(&retraction.algebra().ad(&x)));
        let scale = |factors: &[f64]| factors.iter().fold(grown, |p, f| p * (1.0 + f));
        let mut note = |name, defect: f64, factors: &[f64]| worst.note(name, defect, scale(factors), at);
        note("dτ dτ⁻¹ = 1", size(&(d * d_inv - Matrix::<T, N>::identity())), &[size(&d), size(&d_inv)]);
        let other = retraction.at(&-x).unwrap();
        note("d_neg = d at −x", size(&(d_neg - other.d())), &[size(&d_neg), size(other.d_inv())]);
        let sizes = [size(&d), size(&d_inv), size(&d_neg), size(other.d_inv()), size(&point.ad_inv())];
        note("Ad⁻¹ = Ad at −x", size(&(point.ad_inv() - other.ad())), &sizes);
        let transported = point.pull_ad_inv(&m, &(m * d)) - m * point.ad_inv();
        note("f Ad⁻¹", size(&transported), &[size(&point.ad_inv()), size(&d), size(&d_neg)]);
        let tangent = derivative(|x| retraction.tau(x), &x, &y).unwrap();
        note("Tτ = τ dτ", size(&(tangent - g * group.hat(&(d * y)))), &[size(&g), size(&back), size(&d)]);
        let w = point.dd(&y);
        let moved = derivative(|x| retraction.at(x).map(|p| p.d() * y.map(Dual::constant)), &x, &z).unwrap();
        note("dτ ddτ = ∂ dτ", size(&(moved - d * w * z)), &[size(&d), size(&d), size(&d_inv)]);
        let p = m * d;
        note("pull_dd = p ddτ", size(&(point.pull_dd(&p, &m, &y) - p * w)), &[size(&d), size(&w), size(&d_inv)]);
        let mut conjugation = Matrix::<T, N>::zeros();
        for a in 0..N {
            conjugation.set_column(a, &group.vee(&(g * group.basis()[a] * back)));
        }
        let sizes = [size(&g), size(&back), size(&d_neg), size(&d_inv), size(&d)];
        note("Ad = conjugation by τ", size(&(conjugation - point.ad())), &sizes);
        // Where τ is not injective τ⁻¹ may find another preimage.
        if retraction.tau_inv(&g).is_ok_and(|found| size(&(found - x)) <= 1e-6 * at) {
            let slope = derivative(|x| retraction.tau_inv(&retraction.tau(x)?), &x, &y).unwrap();
            note("T(τ⁻¹ τ) = 1", size(&(slope - y)), &[size(&d_inv), size(&d_inv), size(&g), size(&back)]);
        }
        let hat = group.hat(&x);
        if retraction.name() == "exp" {
            let twice = retraction.tau(&(x * T::int(2))).unwrap();
            note("τ(2x) = τ(x)²", size(&(twice - g * g)), &[size(&g), size(&g), size(&back), size(&back)]);
            note("dτ x = x", size(&(d * x - x)) / at, &[size(&d), size(&d_inv)]);
        } else if retraction.name() == "cay" {
            let defect =
                g * (Matrix::<T, D>::identity() - hat * T::half()) - (Matrix::<T, D>::identity() + hat * T::half());
            note("τ(x)(1 − x/2) = 1 + x/2", size(&defect), &[size(&g), size(&g), at]);
        }

        // To all digits, or to the first terms of a series in ad_x: where |ad_x| is small enough for either.
        let reach = size(&retraction.algebra().ad(&x)).max(at);
        if reach <= 0.5 {
            rates_are_rough(retraction, [(x, y), (x * T::half(), z)], reach, 64.0 * N as f64 * grown);
        }
    }
    worst.judge(&format!("{subject}, {}", T::NAME), 4.0 * N as f64, CASES * 7 / 10);
}

/// dτ⁻¹ y to the square of the size of x, several at once as one by one.
fn rates_are_rough<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>>(
    retraction: &R,
    pairs: [(Vector<T, N>, Vector<T, N>); 2],
    reach: f64,
    rounding: f64,
) {
    let brackets = Brackets::of(retraction.algebra());
    let [xs, ys] = [pairs.map(|pair| pair.0), pairs.map(|pair| pair.1)]
        .map(|v| -> [[T; 2]; N] { std::array::from_fn(|a| v.map(|v| v[a])) });
    let rates = retraction.rough_rates(&brackets, &xs, &ys);
    for (w, (x, y)) in pairs.iter().enumerate() {
        let single = retraction.rough_rates(&brackets, &xs.map(|v| [v[w]]), &ys.map(|v| [v[w]]));
        let rough = Vector::<T, N>::from_fn(|a, _| single[a][0]) - retraction.at(x).unwrap().d_inv() * y;
        assert!(size(&rough) <= reach * reach + rounding, "{x} {rough}");
        let off = Vector::<T, N>::from_fn(|a, _| rates[a][w] - single[a][0]);
        assert!(size(&off) <= 64.0 * N as f64 * T::unit_roundoff().to_f64() * (1.0 + size(y)), "{off}");
    }
}

/// Terms of the third and of the fifth degree.
fn odd_terms<T: Real, const N: usize>() -> Vec<OddTerm<T>> {
    let term = |component, p, factors: &[usize]| OddTerm {
        component,
        coefficient: T::ratio(p, 8),
        factors: factors.iter().map(|i| i % N).collect(),
    };
    vec![term(0, 1, &[1, 1, 2]), term(N - 1, -1, &[0, 1, 2]), term(1, 1, &[0, 0, 0, 1, 2]), term(0, 1, &[0, 0, 0])]
}

#[test]
fn like_terms_of_an_odd_map_are_one() {
    let term = |coefficient, factors: [usize; 3]| OddTerm { component: 0, coefficient, factors: factors.to_vec() };
    let make = |terms| Composed::new::<3, 3>(ExponentialSo3::<f64>::new(), terms).unwrap();
    let twice = make(vec![term(0.125, [0, 1, 2]), term(0.5, [1, 1, 1]), term(0.25, [2, 0, 1])]);
    assert_eq!(twice.terms(), [term(0.375, [0, 1, 2]), term(0.5, [1, 1, 1])]);
    let none = make(vec![term(0.125, [0, 0, 1]), term(-0.125, [0, 1, 0])]);
    assert!(none.terms().is_empty());
}

/// The inverse of an odd map, where it folds, and what is no odd map.
#[test]
fn odd_maps_are_inverted_up_to_their_folds() {
    let term = |coefficient, component, degree| OddTerm { component, coefficient, factors: vec![0; degree] };
    let make = |terms| Composed::new::<3, 3>(ExponentialSo3::<f64>::new(), terms);
    // φ(x) = x − x³/3 along e_1 has its fold at x = 1, φ = 2/3.
    let folds = make(vec![term(-1.0 / 3.0, 0, 3)]).unwrap();
    for x in [1e-9, 0.3, 0.9, 0.99, -0.99] {
        let g = folds.tau(&Vector::<f64, 3>::new(x, 0.0, 0.0)).unwrap();
        let back: Vector<f64, 3> = folds.tau_inv(&g).unwrap();
        assert!((back[0] - x).abs() < 1e-13 * x.abs() / (1.0 - x * x), "{x} {back}");
    }
    let beyond: Matrix<f64, 3> = ExponentialSo3::<f64>::new().tau(&Vector::<f64, 3>::new(0.7, 0.0, 0.0)).unwrap();
    assert!(matches!(folds.tau_inv(&beyond), Err(RetractionError::NoPreimage { .. })));
    // φ(x) = x − x_1 x_2² e_1 is singular at e_2, and beyond is another sheet.
    let singular = make(vec![OddTerm { component: 0, coefficient: -1.0, factors: vec![0, 1, 1] }]).unwrap();
    assert!(matches!(singular.at(&Vector::<f64, 3>::new(0.0, 1.0, 0.0)), Err(RetractionError::SingularTangent { .. })));
    for (size, outside) in [(0.99, false), (1.0 + f64::EPSILON, true), (1.01, true), (-3.0, true)] {
        let x = Vector::<f64, 3>::new(0.0, size, 0.0);
        let refused = |found: Option<RetractionError>| matches!(found, Some(RetractionError::OutsideDomain { .. }));
        assert_eq!([refused(singular.at(&x).err()), refused(singular.tau(&x).err())], [outside; 2], "{size}");
    }
    for (bad, why) in [
        (term(f64::NAN, 0, 3), "not finite"),
        (term(1.0, 3, 3), "larger than the dimension"),
        (term(1.0, 0, 2), "not odd"),
        (term(1.0, 0, 1), "not odd"),
        (term(1.0, 0, 17), "from 3 to 15"),
    ] {
        assert!(make(vec![bad]).is_err_and(|e| e.to_string().contains(why)));
    }
    // Where nothing is added it is the same to the last bit.
    let (same, x) = (make(Vec::new()).unwrap(), Vector::<f64, 3>::new(0.4, -0.3, 0.2));
    assert_eq!(same.tau(&x).unwrap(), ExponentialSo3::new().tau(&x).unwrap());
    assert_eq!(same.at(&x).unwrap().d(), ExponentialSo3::new().at(&x).unwrap().d());
}

/// exp and cay, each also after an odd map, to these sizes of x.
fn both<T: Real, const N: usize, const D: usize>(name: &str, group: MatrixGroup<T, N, D>, exp: f64, cay: f64) {
    let exponential = AnyRetraction::Exponential(Exponential::of_group(group.clone()));
    let cayley = AnyRetraction::Cayley(Cayley::new(group.clone()).unwrap());
    for (retraction, map, domain) in [(exponential, "exp", exp), (cayley, "cay", cay)] {
        let composed = Composed::new(retraction.clone(), odd_terms::<T, N>()).unwrap();
        identities(&format!("{map} on {name}"), &retraction, &group, domain);
        let composed = AnyRetraction::Composed(Box::new(composed));
        identities(&format!("{map} after an odd map on {name}"), &composed, &group, 1.0);
    }
}

fn all_identities<T: Real>() {
    for tau in CLOSED {
        identities(&format!("{tau:?} on SO(3)"), &closed::<T>(tau), &general("so3"), 30.0);
    }
    both("SO(3), general", general::<T, 3, 4>("so3"), 30.0, 30.0);
    // e^{ad} reaches e²⁰ and e³⁰ here; cay ends where a real eigenvalue reaches 2 in absolute value.
    both("SL(2)", general::<T, 3, 4>("sl2"), 8.0, 30.0);
    both("SL(2) in another basis", changed(&general::<T, 3, 4>("sl2")), 4.0, 10.0);
    both("Aff(1) × ℝ", general::<T, 3, 4>("aff1+r1"), 8.0, 30.0);
    both("Heisenberg", general::<T, 3, 4>("heisenberg"), 30.0, 30.0);
    both("SE(3)", general::<T, 6, 8>("se3"), 30.0, 30.0);
    both("SE(3) in another basis", changed(&general::<T, 6, 8>("se3")), 10.0, 10.0);
    both("SO(4)", general::<T, 6, 8>("so4"), 30.0, 30.0);
}

#[test]
fn identities_in_f64() {
    all_identities::<f64>();
    both("Aff(1)", general::<f64, 2, 2>("aff1"), 30.0, 30.0);
}

#[test]
fn identities_in_32_digits() {
    all_identities::<Dd>();
}

/// t and sin θ/θ, A, A', B, B', G at t = θ², computed with 80 digits.
const REFERENCE: &str = include_str!("retraction/coefficients.txt");

/// ρ and arctan √ρ/√ρ, computed with 40.
const ARCS: &str = include_str!("retraction/arcs.txt");

/// The argument of each row, and its values. There are `count` rows.
fn rows(table: &'static str, count: usize) -> impl Iterator<Item = (f64, &'static str)> {
    assert_eq!(table.lines().count(), count);
    table.lines().map(|row| row.split_once(' ').unwrap()).map(|(at, values)| (at.parse().unwrap(), values))
}

/// Coefficients against 40-digit values on both sides of the switch.
fn coefficients<T: Real>() {
    let coefficients = Coefficients::<T>::new();
    for (t, reference) in rows(REFERENCE, 8) {
        let values = coefficients.at(T::exact(t));
        let got = [values.sinc, values.a, values.a_slope, values.b, values.b_slope, values.g.unwrap()];
        // Near θ = 2π (t = 39.5 is 2e-3 away) sin(θ/2) is known to θ u only: the condition is θ/|tan(θ/2)|.
        let angle = t.sqrt();
        let condition = if t < 9.0 { 1.0 } else { 1.0 + angle * (1.0 + 1.0 / (0.5 * angle).tan().abs()) };
        for (k, (got, text)) in got.iter().zip(reference.split(' ')).enumerate() {
            let want = T::parse_decimal(text).unwrap();
            // sin θ/θ is accurate absolutely, the others relatively.
            let scale = if k == 0 { T::one() } else { want };
            let error = ((*got - want) / scale).abs().to_f64() / T::unit_roundoff().to_f64();
            assert!(error <= 12.0 * condition, "{}: value {k} at t = {t}: {error:.1} u", T::NAME);
        }
    }
    for (rho, text) in rows(ARCS, 5) {
        let (got, want) = (coefficients.half_angle(T::one(), T::exact(rho)), T::parse_decimal(text).unwrap());
        let error = ((got - want) / want).abs().to_f64() / T::unit_roundoff().to_f64();
        assert!(error <= 6.0, "{}: arctangent at {rho}: {error:.1} u", T::NAME);
    }
}

in_both! {
    coefficients_are_the_references: coefficients;
}

/// The slopes A', B' of the coefficients against duals of A, B, on both sides of the switch and at 0.
#[test]
fn coefficients_differentiate() {
    let coefficients = Coefficients::<f64>::new();
    for t in [0.0, 1e-30, 1e-9, 0.01, 0.3, 2.0, 8.9999999, 9.0, 9.1, 20.0, 100.0, 900.0] {
        let values = coefficients.at(Dual::variable(t));
        for (slope, name, want) in [(values.a.eps, "A'", values.a_slope.re), (values.b.eps, "B'", values.b_slope.re)] {
            let scale = 1.0 / (24.0 * (1.0 + t / 9.0));
            assert!((slope - want).abs() <= 1e-15 * scale.max(want.abs()) * (1.0 + t.sqrt()), "{name} at {t}");
        }
        for (second, slope) in [(values.a_slope.eps, 1.0 / 360.0), (values.b_slope.eps, 1.0 / 2520.0)] {
            assert!(second.is_finite() && second.abs() <= 1.01 * slope, "second slope {second} at {t}");
        }
        let g = values.g.unwrap();
        assert!(g.all_finite(), "G at {t}");
        assert!(coefficients.half_angle(Dual::constant(1.0), Dual::variable(t)).all_finite(), "arctangent at {t}");
    }
}

/// f64 against 32 digits, log-uniformly in t from 1e-24 to 900: across the switch, and past θ = 2πk.
#[test]
fn coefficients_against_32_digits() {
    let (coarse, fine) = (Coefficients::<f64>::new(), Coefficients::<Dd>::new());
    let mut random = Random(13);
    for _ in 0..20000 {
        let t = random.magnitude::<1>(1e-24, 900.0)[0].abs();
        let t = if random.signed() > 0.8 { 9.0 + random.signed() } else { t };
        let (got, want) = (coarse.at(t), fine.at(Dd::exact(t)));
        let angle = t.sqrt();
        let unit = f64::EPSILON / 2.0 * (1.0 + angle);
        let near = |name: &str, got: f64, want: Dd, bound: f64| {
            let error = (Dd::exact(got) - want).to_f64().abs();
            assert!(error <= bound, "{name} at t = {t:e}: {error:e} > {bound:e}");
        };
        // The sizes of the coefficients, which have zeros at large t.
        let (a, b) = (0.5 / (1.0 + 0.25 * t), 1.0 / (6.0 + t));
        near("sin θ/θ", got.sinc, want.sinc, 2.0 * unit);
        near("A", got.a, want.a, 4.0 * unit * a);
        near("B", got.b, want.b, 4.0 * unit * b);
        near("A'", got.a_slope, want.a_slope, 8.0 * unit * a / (6.0 + t) * (1.0 + angle / 3.0));
        near("B'", got.b_slope, want.b_slope, 12.0 * unit * b / (10.0 + t));
        if let (Some(got), Some(want)) = (got.g, want.g) {
            // G = (2 sin(θ/2)/θ − cos(θ/2))/(2θ sin(θ/2)), with sin(θ/2) off by u θ.
            let sine = (0.5 * angle).sin().abs();
            let bound = if t < 9.0 { 4.0 * unit / 12.0 } else { 2.0 * unit / (sine * angle) * (1.0 + 1.0 / sine) };
            near("G", got, want, bound);
        }
    }
}

/// Tangents of the closed forms in f64 against 32 digits, in units of u × (1 + |ad_x|) × the sizes of the factors.
#[test]
fn closed_tangents_against_32_digits() {
    for tau in CLOSED {
        let (coarse, fine, mut random) = (closed::<f64>(tau), closed::<Dd>(tau), Random(17));
        for _ in 0..200 {
            let plain = random.magnitude::<3>(1e-12, 30.0);
            let [y, m] = std::array::from_fn(|_| random.vector::<3>());
            let (got, want) = (coarse.at(&plain).unwrap(), fine.at(&exact(&plain)).unwrap());
            let maps = [*got.d(), *got.d_inv(), got.d_neg(), got.ad(), got.ad_inv()];
            let [d, d_inv, d_neg, ad, ad_inv] = maps.map(|map| 1.0 + size(&map));
            let grown = 1.0 + size(&coarse.algebra().ad(&plain));
            // exp: errors of dτ are relative to the larger of it and its inverse. cay: dτ⁻¹ is a sum of terms up to
            // grown², so its inverse is off by u grown² |dτ|².
            let (kappa, kappa_neg) = match tau {
                Tau::Cayley => (d * (d_inv + d * grown), d_neg * (d_inv + d_neg * grown)),
                _ => (d * d_inv, d * d_inv * ad),
            };
            let pulled = got.pull_dd(&(m.transpose() * got.d()), &m.transpose(), &y).map(Dd::exact);
            let pulled = pulled - exact::<Dd, 3>(&m).transpose() * want.d() * want.dd(&exact(&y));
            for (name, error, scale) in [
                ("dτ(−x)", size(&(got.d_neg().map(Dd::exact) - want.d_neg())), kappa_neg),
                (
                    "Ad⁻¹",
                    size(&(got.ad_inv().map(Dd::exact) - want.ad_inv())),
                    ad * ad_inv + kappa * (1.0 + grown) * grown,
                ),
                ("pull_dd", size(&pulled), kappa * d * d_inv),
            ] {
                let bound = 6.0 * f64::EPSILON * grown * scale;
                assert!(error <= bound, "{tau:?} {name}: {error:e} > {bound:e} at {plain}");
            }
        }
    }
}

/// Second derivatives through nested duals: τ⁻¹ ∘ τ = 1 has none.
#[test]
fn nested_duals() {
    fn check<const N: usize, const D: usize>(retraction: &impl Retraction<f64, N, D>) {
        let mut random = Random(3);
        for magnitude in [0.0, 1e-9, 0.1, 1.0] {
            let x = random.vector::<N>() * magnitude;
            let [y, z] = std::array::from_fn(|_| random.vector::<N>());
            let nested = Vector::<Dual<Dual<f64>>, N>::from_fn(|a, _| Dual {
                re: Dual { re: x[a], eps: y[a] },
                eps: Dual { re: z[a], eps: 0.0 },
            });
            let back = retraction.tau_inv(&retraction.tau(&nested).unwrap()).unwrap();
            for a in 0..N {
                assert!((back[a].re.re - x[a]).abs() < 1e-14);
                assert!((back[a].re.eps - y[a]).abs() < 1e-13);
                assert!((back[a].eps.re - z[a]).abs() < 1e-13);
                assert!(back[a].eps.eps.abs() < 1e-12, "{}: {:e}", retraction.name(), back[a].eps.eps);
            }
        }
    }
    check(&CayleySo3::new());
    check(&ExponentialSo3::new());
    check(&Exponential::of_group(general::<f64, 3, 4>("sl2")));
    check(&Exponential::of_group(general::<f64, 6, 8>("se3")));
    check(&Cayley::new(general::<f64, 6, 8>("se3")).unwrap());
}

/// Angles up to just below π, where the logarithm is ill conditioned in nothing but its direction.
#[test]
fn logarithm_near_half_turns() {
    let axis = Vector::<f64, 3>::new(2.0, -1.0, 2.0) / 3.0;
    for gap in [1.0, 1e-1, 1e-4, 1e-8, 1e-12] {
        let x = axis * (std::f64::consts::PI - gap);
        let closed = ExponentialSo3::<f64>::new();
        let found = closed.tau_inv(&closed.tau(&x).unwrap()).unwrap();
        assert!((found - x).amax() < 2e-15, "{gap}: {:e}", (found - x).amax());
        let derived = derivative(|x| closed.tau_inv(&closed.tau(x)?), &x, &axis).unwrap();
        assert!((derived - axis).amax() < 1e-14, "{gap}: {derived}");
    }
    // The derivative is as accurate as the logarithm, also where its first guess is not.
    let (general, across) = (exp::<_, 3, 4>("so3"), Vector::<f64, 3>::new(0.5, 0.25, -0.75));
    for gap in [1.0, 1e-1, 1e-2, 1e-3, 1e-4] {
        let x = axis * (std::f64::consts::PI - gap);
        let found = general.tau_inv(&general.tau(&x).unwrap()).unwrap();
        let derived = derivative(|x| general.tau_inv(&general.tau(x)?), &x, &across).unwrap();
        let off = [(found - x).amax(), (derived - across).amax()];
        assert!(off.iter().all(|off| *off < 1e-14), "general, {gap}: {off:?}");
    }
}

/// A translation of any size beside a small rotation costs no digits.
#[test]
fn badly_scaled_motions() {
    let (exponential, cayley) = (exp::<_, 6, 8>("se3"), cay::<_, 6, 8>("se3"));
    for translation in [1e-9, 1.0, 1e3, 1e6, 1e9] {
        let x = Vector::<f64, 6>::new(0.3, -0.2, 0.1, translation, -translation, 0.5 * translation);
        let g = exponential.tau(&x).unwrap();
        let omega = Vector::<f64, 3>::new(0.3, -0.2, 0.1);
        let closed = ExponentialSo3::<f64>::new();
        let rotation = g.fixed_view::<3, 3>(0, 0) - closed.tau(&omega).unwrap();
        assert!(rotation.amax() < 1e-15, "{translation:e}: {:e}", rotation.amax());
        // The translation of exp is dτ_{−ω} v.
        let v = Vector::<f64, 3>::new(translation, -translation, 0.5 * translation);
        let moved = closed.at(&omega).unwrap().d_neg() * v - g.fixed_view::<3, 1>(0, 3);
        assert!(moved.amax() < 1e-15 * translation, "{translation:e}: {:e}", moved.amax());
        let point = exponential.at(&x).unwrap();
        let block = point.d().fixed_view::<3, 3>(0, 0) - closed.at(&omega).unwrap().d();
        assert!(block.amax() < 1e-15, "{translation:e}: {:e}", block.amax());
        for map in [&exponential, &cayley] {
            let found = map.tau_inv(&map.tau(&x).unwrap()).unwrap() - x;
            assert!(found.fixed_rows::<3>(0).amax() < 1e-15, "{translation:e}: {found}");
            assert!(found.fixed_rows::<3>(3).amax() < 2e-15 * translation, "{translation:e}: {found}");
        }
    }
}

/// Real eigenvalues may be large without dτ⁻¹ losing digits: aff(1) has it in closed form, z/(1 − e^{−z}).
#[test]
fn large_real_eigenvalues() {
    let algebra = LieAlgebra::from_catalogue(&"aff1+r1".parse().unwrap()).unwrap();
    let exponential = Exponential::<f64, 3, 4, MatrixGroup<f64, 3, 4>>::of_algebra(algebra);
    for z in [1e-9, 0.5, 3.0, 30.0, 300.0, -0.5, -30.0, -300.0] {
        let point = exponential.at(&Vector::<f64, 3>::new(z, 0.0, 0.0)).unwrap();
        let want = -z / (-z).exp_m1();
        // Relative to the matrix, whose other eigenvalues are 1.
        let bound = 1e-15 * want.abs().max(1.0) * (1.0 + z.abs());
        assert!((point.d_inv()[(1, 1)] - want).abs() <= bound, "{z}: {want}");
    }
}

/// e = [[0, 1], [0, 1]] is its own square, so τ(x e) = 1 + (τ(x) − 1) e; its first column is empty and its first row is not.
/// Beside it are two of the diagonal.
#[test]
fn a_group_whose_matrices_have_an_empty_column() {
    let mut basis = [Matrix::<f64, 4>::zeros(); 3];
    [(0, 0, 1), (0, 1, 1), (1, 2, 2), (2, 3, 3)].into_iter().for_each(|(a, i, j)| basis[a][(i, j)] = 1.0);
    let group = MatrixGroup::new(basis).unwrap();
    let with = |z: f64| padded::<2, 4>(Matrix::<f64, 2>::new(1.0, z - 1.0, 0.0, z));
    let (cayley, exponential) = (Cayley::new(group.clone()).unwrap(), Exponential::of_group(group));
    for x in [-1.5, -0.25, 0.5, 1.0] {
        let at = Vector::<f64, 3>::new(x, 0.0, 0.0);
        let (first, second) = (with((1.0 + x / 2.0) / (1.0 - x / 2.0)), with(x.exp()));
        assert!((cayley.tau(&at).unwrap() - first).amax() <= 8.0 * f64::EPSILON * first.amax(), "{x}");
        assert!((exponential.tau(&at).unwrap() - second).amax() <= 8.0 * f64::EPSILON * second.amax(), "{x}");
        assert!((cayley.tau_inv(&first).unwrap() - at).amax() <= 32.0 * f64::EPSILON, "{x}");
        assert!((exponential.tau_inv(&second).unwrap() - at).amax() <= 32.0 * f64::EPSILON, "{x}");
    }
}

/// x² = 0, so τ(x) = 1 + x; but 1 − x/2 of size s has an inverse of size s: what is singular to working precision is refused.
#[test]
fn what_cannot_be_inverted_to_working_precision_is_refused() {
    let cayley = cay::<_, 3, 4>("sl2");
    for k in 0..48 {
        let s = 0.7 * 10f64.powf(f64::from(k) / 4.0);
        let exact = padded::<2, 4>(Matrix::<f64, 2>::new(1.0 + s, s, -s, 1.0 - s));
        match cayley.tau(&Vector::<f64, 3>::new(s, s, -s)) {
            Ok(found) => assert!((found - exact).amax() <= 0.05 * s, "{s:e}: {found}"),
            Err(RetractionError::OutsideDomain { size, .. }) => assert!(size == s && s > 1e6, "{s:e}"),
            Err(other) => panic!("{s:e}: {other:?}"),
        }
    }
}

fn half_turn<const D: usize>() -> Matrix<f64, D> {
    padded(Matrix::<f64, 3>::from_diagonal(&Vector::<f64, 3>::new(-1.0, 1.0, -1.0)))
}

#[test]
fn refusals() {
    let nan = Vector::<f64, 3>::new(0.0, f64::NAN, 0.0);
    let infinite = Vector::<f64, 3>::new(f64::INFINITY, 0.0, 0.0);
    let turn = Vector::<f64, 3>::new(0.0, 0.0, std::f64::consts::TAU);
    fn refuses<const D: usize>(retraction: &impl Retraction<f64, 3, D>, bad: &[Vector<f64, 3>], turn: &Vector<f64, 3>) {
        let name = retraction.name();
        for x in bad {
            assert!(matches!(retraction.tau(x), Err(RetractionError::NotFinite { .. })), "{name}");
            assert!(matches!(retraction.at(x), Err(RetractionError::NotFinite { .. })), "{name}");
        }
        let huge = Vector::<f64, 3>::new(1e200, 0.0, 1.0);
        assert!(matches!(retraction.at(&huge), Err(RetractionError::OutsideDomain { size: 1e200, .. })));
        let half_turn = half_turn::<D>();
        assert!(matches!(retraction.tau_inv(&half_turn), Err(RetractionError::NoPreimage { .. })));
        assert!(matches!(retraction.tau_inv(&(half_turn * f64::NAN)), Err(RetractionError::NotFinite { .. })));
        let skewed = padded(Matrix::<f64, 3>::new(1.0, 0.5, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0));
        for not_in_group in [Matrix::<f64, D>::zeros(), Matrix::<f64, D>::identity() * 2.0, skewed] {
            let found = retraction.tau_inv(&not_in_group);
            assert!(matches!(found, Err(RetractionError::NoPreimage { .. })), "{name} {not_in_group} {found:?}");
        }
        for k in [1.0, 2.0, 3.0].into_iter().filter(|_| name == "exp") {
            assert!(matches!(retraction.at(&(turn * k)), Err(RetractionError::SingularTangent { .. })), "{k}");
            assert!(retraction.at(&(turn * (k + 1e-3))).is_ok() && retraction.tau(&(turn * k)).is_ok());
        }
    }
    CLOSED.iter().for_each(|tau| refuses(&closed(*tau), &[nan, infinite], &turn));
    [exp::<_, 3, 4>("so3"), cay("so3")].iter().for_each(|general| refuses(general, &[nan, infinite], &turn));

    // No group; no Cayley; poles of Cayley.
    let algebra = LieAlgebra::from_catalogue(&Entry::So3).unwrap();
    let bare = Exponential::<f64, 3, 4, MatrixGroup<f64, 3, 4>>::of_algebra(algebra);
    assert_eq!(bare.tau(&turn), Err(RetractionError::NoGroup { retraction: "exp" }));
    assert_eq!(bare.tau_inv(&half_turn()), Err(RetractionError::NoGroup { retraction: "exp" }));
    let refused = Cayley::new(sl3()).unwrap_err();
    assert!(refused.defect > 0.1 && refused.to_string().contains("e_1 e_2 e_1"), "{refused}");
    let cayley = cay::<f64, 3, 4>("aff1+r1");
    for pole in [2.0, -2.0] {
        let x = Vector::<f64, 3>::new(pole, 1.0, 0.0);
        assert!(matches!(cayley.at(&x), Err(RetractionError::OutsideDomain { size: 2.0, .. })));
    }
    assert!(matches!(cayley.tau(&Vector::<f64, 3>::new(2.0, 1.0, 0.0)), Err(RetractionError::OutsideDomain { .. })));
    // −1 is in SL(2), and has no logarithm there that is unique; neither has diag(−2, −½).
    let exponential = exp::<_, 3, 4>("sl2");
    for (a, b) in [(-1.0, -1.0), (-2.0, -0.5)] {
        let g: Matrix<f64, 4> = Matrix::from_diagonal(&[a, b, 1.0, 1.0].into());
        assert!(matches!(exponential.tau_inv(&g), Err(RetractionError::NoPreimage { .. })), "{a}, {b}");
    }
}

/// RᵀR = 1 is asked for to less than 2⁻²⁰ by the closed forms.
#[test]
fn what_is_a_rotation_has_a_sharp_edge() {
    let mut sheared = Matrix::<f64, 3>::identity();
    for (shear, allowed) in [(2f64.powi(-20), false), (2f64.powi(-21), true)] {
        sheared[(0, 1)] = shear;
        assert_eq!(CayleySo3::new().tau_inv(&sheared).is_ok(), allowed, "{shear:e}");
        assert_eq!(ExponentialSo3::new().tau_inv(&sheared).is_ok(), allowed, "{shear:e}");
    }
}

/// All matrices of size 3, beside a line.
fn gl3() -> MatrixGroup<f64, 10, 12> {
    let mut basis = [Matrix::<f64, 12>::zeros(); 10];
    (0..9).for_each(|a| basis[a][(a / 3, a % 3)] = 1.0);
    basis[9][(3, 5)] = 1.0;
    MatrixGroup::new(basis).unwrap()
}

/// The Cayley map ends where a real eigenvalue of x reaches ±2, twofold eigenvalues among them, though 1 ± x/2 are regular again
/// beyond; complex ones may be of any size.
#[test]
fn cayley_ends_where_a_real_eigenvalue_reaches_two() {
    let refused = |found: RetractionError| matches!(found, RetractionError::OutsideDomain { why, .. } if why.contains("real eigenvalue"));
    let two = cay::<f64, 6, 8>("aff1+aff1+r2");
    for (a, b) in [(2.5, 0.0), (-6.6, 0.0), (3.0, 3.0), (-3.0, 3.0), (1e8, 1e8), (2.0, 0.0)] {
        let x = Vector::<f64, 6>::from([a, 1.0, b, -7.0, 1e6, 0.0]);
        assert!(refused(two.at(&x).unwrap_err()) && refused(two.tau(&x).unwrap_err()), "{a}, {b}");
    }
    for (a, b) in [(1.99, -1.99), (0.0, 1.9), (-1.5, -1.5)] {
        let x = Vector::<f64, 6>::from([a, 100.0, b, -7.0, 1e6, 0.0]);
        let back = two.tau_inv(&two.tau(&x).unwrap()).unwrap();
        assert!(two.at(&x).is_ok() && (back - x).amax() < 1e-9 * x.amax(), "{a}, {b}");
    }
    let beyond: Matrix<f64, 8> = Matrix::from_diagonal(&[-0.5, 1.0, -0.5, 1.0, 1.0, 1.0, 1.0, 1.0].into());
    let found = two.tau_inv(&beyond).unwrap_err();
    assert!(matches!(found, RetractionError::NoPreimage { why: "g has an eigenvalue of 0 or less", .. }), "{found}");

    let (cayley, mut random, mut inside) = (Cayley::new(gl3()).unwrap(), Random(11), 0);
    for k in 0..1000 {
        let size = 2f64.powf(random.signed() * 4.0 + 1.0);
        let matrix = Matrix::<f64, 3>::from_fn(|_, _| random.signed() * size);
        let real = matrix.complex_eigenvalues();
        let real = real.iter().filter(|z| z.im == 0.0).fold(0.0_f64, |most, z| most.max(z.re.abs()));
        if (real - 2.0).abs() < 1e-6 {
            continue;
        }
        let x = Vector::<f64, 10>::from_fn(|a, _| if a < 9 { matrix[(a / 3, a % 3)] } else { 1e3 });
        assert_eq!(cayley.at(&x).is_ok(), real < 2.0, "{k}: {matrix} {real}");
        inside += u32::from(real < 2.0);
    }
    assert!((300..700).contains(&inside), "{inside}");
}

/// Which groups admit the Cayley map, in any basis; and half turns to within round-off have no preimage under it.
#[test]
fn domain_of_cayley() {
    fn admits<const N: usize, const D: usize>(name: &str) {
        let group = general::<f64, N, D>(name);
        let mut random = Random(23);
        for _ in 0..10 {
            let basis = Matrix::<f64, N>::from_fn(|_, _| random.signed()) + Matrix::<f64, N>::identity() * 1.5;
            let Ok(changed) = group.in_basis(&basis) else { continue };
            assert!(Cayley::new(changed).is_ok(), "{name} in the basis {basis}");
        }
        let x = random.vector::<N>() * 0.5;
        for retraction in [cay::<f64, N, D>(name), exp(name)] {
            let moved = retraction.tau(&x).unwrap();
            assert!((retraction.tau_inv(&moved).unwrap() - x).amax() < 1e-14, "{} on {name}", retraction.name());
        }
    }
    for name in ["r3", "so3", "se2", "sl2", "aff1+r1", "heisenberg"] {
        admits::<3, 4>(name);
    }
    for name in ["se3", "so4", "so3+r3", "se2+aff1+r1"] {
        admits::<6, 8>(name);
    }
    assert!(Cayley::new(changed(&sl3())).is_err());

    for gap in [0.0, 1e-16, 4e-16] {
        let (sin, cos) = (gap, -1.0);
        let g = Matrix::<f64, 3>::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        let found = CayleySo3::new().tau_inv(&g);
        assert!(matches!(found, Err(RetractionError::NoPreimage { .. })), "{gap:e}");
        let found = cay::<_, 3, 4>("so3").tau_inv(&padded(g));
        assert!(matches!(found, Err(RetractionError::NoPreimage { .. })), "{gap:e}");
    }
}
