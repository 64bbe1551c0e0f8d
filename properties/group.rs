//! Properties of `euler_poincare::group`.
//!
//! The laws on groups judge hat, vee, products, inverses and Ad in random bases. Here: exact integers, projections, what is refused,
//! SO(3) against the general matrix group.

use crate::algebra::{random_basis, uniform};
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::algebra::{AlgebraError, LieAlgebra, Matrix, Vector, elimination};
use euler_poincare::group::{LieGroup, MatrixGroup, So3, departure, so3};
use euler_poincare::scalar::{Dd, Real, Scalar};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Tests that run `$check::<N, D, T>(&entry)` for entries of all kinds, in the dimensions of `System`: what they need is compiled in the
/// library. D holds every representation, most padded. In 16 digits and in 32.
macro_rules! on_catalogue {
    ($($name:ident: $check:ident;)*) => {
        $(#[test] fn $name() {
            for entry in ["r3", "so3", "se2", "sl2", "heisenberg", "aff1+r1"].map(|name| name.parse().unwrap()) {
                $check::<3, 4, f64>(&entry);
                $check::<3, 4, Dd>(&entry);
            }
            for entry in ["se3", "so4", "so3+r3", "so3+sl2", "se2+aff1+r1"].map(|name| name.parse().unwrap()) {
                $check::<6, 8, f64>(&entry);
                $check::<6, 8, Dd>(&entry);
            }
        })*
    };
}

on_catalogue! {
    hat_is_linear_in_the_basis_and_vee_a_projection: hat_and_vee;
    padding_stays_the_identity: padding_is_inert;
    departure_sees_what_is_not_in_the_group: departure_is_that_from_the_group;
}

fn random_vector<const N: usize, T: Real>(rng: &mut ChaCha8Rng) -> Vector<T, N> {
    Vector::from_fn(|_, _| uniform(rng))
}

/// e^A by Taylor's series of e^(A/16), squared four times.
fn exponential<const D: usize, S: Scalar>(a: &Matrix<S, D>) -> Matrix<S, D> {
    let small = a * S::ratio(1, 16);
    let (mut sum, mut term) = (Matrix::<S, D>::identity(), Matrix::<S, D>::identity());
    for k in 1..40 {
        term = term * small * S::ratio(1, k);
        sum += term;
    }
    (0..4).fold(sum, |power, _| power * power)
}

/// A random group element, with x of size about 1 in the standard basis whatever that of `group`.
fn random_element<const N: usize, const D: usize, T: Real>(
    standard: &MatrixGroup<T, N, D>,
    rng: &mut ChaCha8Rng,
) -> Matrix<T, D> {
    exponential(&standard.hat(&random_vector::<N, T>(rng)))
}

/// A group, the basis it is in, and φ.
type InBasis<T, const N: usize, const D: usize> = (MatrixGroup<T, N, D>, Matrix<T, N>, T);

/// The standard group and its changes of basis, each with φ ≥ κ(B) times the condition of hat.
fn in_bases<const N: usize, const D: usize, T: Real>(
    entry: &Entry,
    rng: &mut ChaCha8Rng,
) -> (MatrixGroup<T, N, D>, Vec<InBasis<T, N, D>>) {
    let standard = MatrixGroup::<T, N, D>::from_entry(entry).unwrap();
    let mut bases = vec![Matrix::<T, N>::identity()];
    bases.extend([1.0, 30.0, 1e4].map(|condition| random_basis::<N, T>(rng, condition)));
    let moved = bases.into_iter().map(|basis| {
        let kappa = basis.norm() * elimination::inverse(&basis).unwrap().norm();
        (standard.in_basis(&basis).unwrap(), basis, kappa * T::int(2))
    });
    let moved = moved.collect();
    (standard, moved)
}

fn units<T: Real>(n: usize) -> T {
    T::int(n as i64) * T::unit_roundoff()
}

fn hat_and_vee<const N: usize, const D: usize, T: Real>(entry: &Entry) {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let (standard, groups) = in_bases::<N, D, T>(entry, &mut rng);
    // Integers all along: no rounding at all.
    assert_eq!(*standard.algebra(), LieAlgebra::<T, N>::from_catalogue(entry).unwrap(), "{entry}");
    for a in 0..N {
        let e = Vector::<T, N>::from_fn(|b, _| if a == b { T::one() } else { T::zero() });
        assert_eq!(standard.vee(&standard.hat(&e)), e, "{entry}");
        assert_eq!(standard.basis()[a], standard.hat(&e), "{entry}");
    }
    for (group, basis, phi) in groups {
        let x = random_vector::<N, T>(&mut rng);
        let matrix = (group.hat(&x) - standard.hat(&(basis * x))).norm();
        assert!(matrix <= units::<T>(8 * N * D) * basis.norm() * x.norm(), "{entry}: hat off by {matrix:e}");
        // vee is the least-squares one: of x̂ + M with M normal to all ê_a it sees x̂ alone.
        let mut normal = Matrix::<T, D>::from_fn(|_, _| uniform(&mut rng));
        for _pass in 0..3 {
            normal -= standard.hat(&standard.vee(&normal));
        }
        let seen = (group.vee(&(normal + group.hat(&x))) - x).norm();
        let size = normal.norm() * elimination::inverse(&basis).unwrap().norm() + x.norm();
        assert!(seen <= units::<T>(32 * N * D) * phi * size, "{entry}: projection off by {seen:e}");
    }
}

fn padding_is_inert<const N: usize, const D: usize, T: Real>(entry: &Entry) {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let group = MatrixGroup::<T, N, D>::from_entry(entry).unwrap();
    let g = random_element(&group, &mut rng);
    let inverse = group.inverse(&g).unwrap();
    for r in 0..D {
        for c in (0..D).filter(|c| r.max(*c) >= entry.matrix_size()) {
            let expected = if r == c { T::one() } else { T::zero() };
            assert!(g[(r, c)] == expected && inverse[(r, c)] == expected, "{entry}: entry ({r}, {c})");
        }
    }
}

#[test]
fn groups_that_do_not_fit_are_refused() {
    let wrong = MatrixGroup::<f64, 3, 6>::from_entry(&Entry::Se3).unwrap_err();
    assert_eq!(wrong.to_string(), "the algebra se3 has dimension 6, expected 3");
    let small = MatrixGroup::<f64, 6, 3>::from_entry(&Entry::Se3).unwrap_err();
    assert_eq!(small.to_string(), "the algebra se3 is represented by 4×4 matrices, which do not fit in 3×3");
    assert!(MatrixGroup::<f64, 6, 4>::from_entry(&Entry::Se3).is_ok());
}

#[test]
fn matrices_that_span_no_algebra_are_refused() {
    let [h, e, f] = [0, 1, 2].map(|a| {
        let m = Entry::Sl2.basis_matrix::<f64>(a);
        Matrix::<f64, 2>::from_fn(|r, c| m[(r, c)])
    });
    assert!(MatrixGroup::new([h, e, f]).is_ok());
    // [E, F] = H is wholly outside the span of E and F.
    let error = MatrixGroup::new([e, f]).unwrap_err();
    assert!(matches!(error, AlgebraError::NotClosed { a: 0, b: 1, defect: 1.0, bound } if bound < 1e-12), "{error}");
    // Almost closed: off by −4e-9 F.
    let error = MatrixGroup::new([h + e * 0.5, e + f * 1e-9]).unwrap_err();
    assert!(matches!(error, AlgebraError::NotClosed { defect, .. } if defect > 3e-9 && defect < 5e-9), "{error}");
    for third in [e + f * 2.0, Matrix::<f64, 2>::zeros(), e * 1e-30, e + f * (1.0 + 1e-16)] {
        let error = MatrixGroup::new([e, f, third]).unwrap_err();
        assert!(matches!(error, AlgebraError::Dependent { index: 2, remainder } if remainder < 1e-14), "{error}");
    }
    for bad in [f64::NAN, f64::INFINITY, 1e300] {
        let mut m = f;
        m[(0, 0)] = bad;
        assert!(matches!(MatrixGroup::new([h, e, m]), Err(AlgebraError::NotFinite { .. })));
    }
}

fn conjugated_and_skewed<T: Real>() {
    let mut rng = ChaCha8Rng::seed_from_u64(4);
    let standard = MatrixGroup::<T, 6, 4>::from_entry(&Entry::Se3).unwrap();
    for condition in [1.0, 1e3, 1e6] {
        // The matrices of se(3) in another frame and another basis, rounded: accepted, with the right constants.
        let frame = random_basis::<4, T>(&mut rng, 3.0);
        let back = elimination::inverse(&frame).unwrap();
        let basis = random_basis::<6, T>(&mut rng, condition);
        let kappa = basis.norm() * elimination::inverse(&basis).unwrap().norm();
        let e: [Matrix<T, 4>; 6] = std::array::from_fn(|a| frame * standard.hat(&basis.column(a).into_owned()) * back);
        let group = MatrixGroup::new(e).unwrap();
        let expected = standard.algebra().in_basis(&basis).unwrap();
        for a in 0..6 {
            let unit = Vector::<T, 6>::from_fn(|b, _| if a == b { T::one() } else { T::zero() });
            let off = (group.algebra().ad(&unit) - expected.ad(&unit)).norm();
            // Frame: |S||S⁻¹| twice in a product of two; the basis κ in vee and κ in what it acts on.
            let frames = frame.norm_squared() * back.norm_squared();
            let bound = units::<T>(64 * 24) * frames * kappa * kappa * (T::one() + expected.ad(&unit).norm());
            assert!(off <= bound, "condition {condition:e}: constants off by {off:e} > {bound:e}");
        }
    }
}

/// The rotation by `angle` about the unit vector `axis`, by Rodrigues' formula.
fn rotation<S: Scalar>(axis: &Vector<S, 3>, angle: S) -> Matrix<S, 3> {
    let x = so3::hat(axis);
    let half = (angle * S::half()).sin();
    Matrix::<S, 3>::identity() + x * angle.sin() + x * x * (half * half * S::int(2))
}

/// The rest is in the laws on groups, which are asked of SO(3) in closed form too (`parts/group.rs`).
#[test]
fn so3_has_the_basis_of_its_matrix_group() {
    let (closed, general) = (So3::<f64>::new(), MatrixGroup::<f64, 3, 3>::from_entry(&Entry::So3).unwrap());
    let m = Matrix::<f64, 3>::from_fn(|r, c| (3 * r + c * c) as f64);
    let x = m.column(1).into_owned();
    assert_eq!((closed.algebra(), closed.hat(&x)), (general.algebra(), general.hat(&x)));
    assert_eq!(closed.vee(&m), general.vee(&m));
}

fn angles<T: Real>() {
    assert!(so3::angle(&Matrix::<T, 3>::identity(), &Matrix::from_element(T::exact(f64::NAN))).to_f64().is_nan());
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    for case in 0..400 {
        let x = random_vector::<3, T>(&mut rng).normalize();
        // Log-uniform from 0, and from π.
        let small = T::exact(10.0_f64.powf(rng.random_range(-18.0..0.4)));
        let expected = if case % 2 == 0 { small } else { T::pi() - small };
        let g = rotation(&random_vector::<3, T>(&mut rng).normalize(), uniform(&mut rng));
        let off = (so3::angle(&g, &(g * rotation(&x, expected))) - expected).abs();
        assert!(off <= units::<T>(64), "angle {expected:e} off by {off:e}");
    }
}

in_both! {
    constants_come_from_any_matrices: conjugated_and_skewed;
    angle_is_accurate_from_zero_to_pi: angles;
}

#[test]
fn distance_never_hides_a_nan() {
    let group = So3::<f64>::new();
    let g = group.identity::<f64>();
    let mut h = g;
    assert_eq!(group.distance(&g, &h), 0.0);
    h[(1, 0)] = -0.25;
    assert_eq!(group.distance(&g, &h), 0.25);
    h[(0, 0)] = f64::NAN;
    assert_eq!(group.distance(&g, &h), f64::INFINITY);
    assert_eq!(group.inverse(&h).map(|m| m[(0, 0)].is_nan()), Some(true));
    let general = MatrixGroup::<f64, 3, 3>::from_entry(&Entry::So3).unwrap();
    assert_eq!(general.inverse(&h), None);
    assert_eq!(general.inverse(&Matrix::<f64, 3>::zeros()), None);
    assert_eq!(general.adjoint(&Matrix::<f64, 3>::zeros()), None);
}

/// Elements of the group have none; what is off by δ in any direction that leaves the tangent space has about δ.
fn departure_is_that_from_the_group<const N: usize, const D: usize, T: Real>(entry: &Entry) {
    let mut rng = ChaCha8Rng::seed_from_u64(77);
    let group = MatrixGroup::<T, N, D>::from_entry(entry).unwrap();
    let size = entry.matrix_size();
    let of = |g: &Matrix<T, D>| departure(entry, &|r, c| g[(r, c)]).to_f64();
    for _ in 0..50 {
        let g = random_element(&group, &mut rng);
        assert!(of(&g) < 1e4 * T::unit_roundoff().to_f64(), "{entry:?}: {:e}", of(&g));
        let delta = 1e-6;
        let off = Matrix::<T, D>::from_fn(|_, _| uniform::<T>(&mut rng) * T::exact(delta));
        // What of the change, seen from g, is not in the algebra.
        let seen = group.inverse(&g).unwrap() * off;
        let block =
            |m: Matrix<T, D>| Matrix::<T, D>::from_fn(|r, c| if r < size && c < size { m[(r, c)] } else { T::zero() });
        let outside = block(seen - group.hat(&group.vee(&seen)));
        let outside = outside.iter().fold(0.0f64, |most, v| most.max(v.to_f64().abs()));
        let found = of(&(g + block(off)));
        assert!(found < 100.0 * delta && found > 0.01 * outside, "{entry:?}: {found:e} {outside:e}");
        for k in 0..size * size {
            let mut broken = g;
            broken[(k / size, k % size)] = T::exact(f64::NAN);
            assert_eq!(of(&broken), f64::INFINITY, "{entry:?}: {k}");
        }
    }
}

#[test]
fn a_mirror_is_far_from_the_group() {
    for name in ["so3", "so4", "se2", "se3", "aff1"] {
        let entry: Entry = name.parse().unwrap();
        let mirror = |r, c| if r != c { 0.0 } else { [-1.0, 1.0][usize::from(r > 0)] };
        assert_eq!(departure(&entry, &mirror), f64::INFINITY, "{name}");
    }
}
