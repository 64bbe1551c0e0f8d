//! Properties of `euler_poincare::retraction`.

use euler_poincare::algebra::{Covector, LieAlgebra, Matrix, Vector};
use euler_poincare::group::LieGroup;
use euler_poincare::retraction::{
    Cayley, CayleySo3, Exponential, ExponentialSo3, Retraction, RetractionError, TangentPoint,
};
use euler_poincare::scalar::dual::derivative;
use euler_poincare::scalar::{Dual, Real, Scalar};

/// A matrix group given by the basis matrices of its algebra; nothing is shared with the crate's own groups.
#[derive(Clone, Debug)]
struct Basis<T: Real, const N: usize, const D: usize> {
    algebra: LieAlgebra<T, N>,
    basis: [Matrix<T, D>; N],
    gram_inverse: Matrix<T, N>,
}

impl<T: Real, const N: usize, const D: usize> Basis<T, N, D> {
    /// From entries (a, row, column, value) of the basis matrices.
    fn new(entries: &[(usize, usize, usize, f64)]) -> Self {
        let mut basis = [Matrix::<T, D>::zeros(); N];
        for &(a, i, j, value) in entries {
            basis[a][(i, j)] += T::exact(value);
        }
        let gram = Matrix::<T, N>::from_fn(|a, b| basis[a].dot(&basis[b]));
        let gram_inverse = gram.try_inverse().expect("the basis is independent");
        let coordinates = |m: &Matrix<T, D>| gram_inverse * Vector::<T, N>::from_fn(|a, _| basis[a].dot(m));
        let algebra = LieAlgebra::new(|a, b, c| coordinates(&(basis[a] * basis[b] - basis[b] * basis[a]))[c]).unwrap();
        Self { algebra, basis, gram_inverse }
    }
}

impl<T: Real, const N: usize, const D: usize> LieGroup<T, N, D> for Basis<T, N, D> {
    fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.algebra
    }
    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Matrix<S, D> {
        let mut sum = Matrix::<S, D>::zeros();
        for a in 0..N {
            sum += self.basis[a].map(S::lift) * xi[a];
        }
        sum
    }
    fn vee<S: Scalar<Base = T>>(&self, matrix: &Matrix<S, D>) -> Vector<S, N> {
        self.gram_inverse.map(S::lift) * Vector::<S, N>::from_fn(|a, _| self.basis[a].map(S::lift).dot(matrix))
    }
    fn inverse<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Option<Matrix<S, D>> {
        g.try_inverse()
    }
}

fn rotation_entries(a: usize, i: usize, j: usize) -> [(usize, usize, usize, f64); 2] {
    [(a, j, i, 1.0), (a, i, j, -1.0)]
}

fn so3<T: Real>() -> Basis<T, 3, 3> {
    Basis::new(&[rotation_entries(0, 1, 2), rotation_entries(1, 2, 0), rotation_entries(2, 0, 1)].concat())
}

fn se3<T: Real>() -> Basis<T, 6, 4> {
    let mut entries = [rotation_entries(0, 1, 2), rotation_entries(1, 2, 0), rotation_entries(2, 0, 1)].concat();
    entries.extend([(3, 0, 3, 1.0), (4, 1, 3, 1.0), (5, 2, 3, 1.0)]);
    Basis::new(&entries)
}

fn so4<T: Real>() -> Basis<T, 6, 4> {
    let pairs = [(0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3)];
    Basis::new(&pairs.iter().enumerate().flat_map(|(a, &(i, j))| rotation_entries(a, i, j)).collect::<Vec<_>>())
}

fn sl2<T: Real>() -> Basis<T, 3, 2> {
    Basis::new(&[(0, 0, 0, 1.0), (0, 1, 1, -1.0), (1, 0, 1, 1.0), (2, 1, 0, 1.0)])
}

fn aff1<T: Real>() -> Basis<T, 2, 2> {
    Basis::new(&[(0, 0, 0, 1.0), (1, 0, 1, 1.0)])
}

fn heisenberg<T: Real>() -> Basis<T, 3, 3> {
    Basis::new(&[(0, 0, 1, 1.0), (1, 1, 2, 1.0), (2, 0, 2, 1.0)])
}

fn sl3<T: Real>() -> Basis<T, 8, 3> {
    let mut entries = vec![(0, 0, 0, 1.0), (0, 1, 1, -1.0), (1, 1, 1, 1.0), (1, 2, 2, -1.0)];
    for (a, (i, j)) in [(0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1)].into_iter().enumerate() {
        entries.push((a + 2, i, j, 1.0));
    }
    Basis::new(&entries)
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

fn constant<T: Scalar, const R: usize, const C: usize>(
    m: &nalgebra::SMatrix<T, R, C>,
) -> nalgebra::SMatrix<Dual<T>, R, C> {
    m.map(Dual::constant)
}

fn size<T: Scalar, const R: usize, const C: usize>(m: &nalgebra::SMatrix<T, R, C>) -> f64 {
    m.iter().fold(0.0, |s: f64, v| if v.to_f64().is_nan() { f64::NAN } else { s.max(v.to_f64().abs()) })
}

/// The worst defect/(u × scale) of each identity.
#[derive(Default, Debug)]
struct Worst(std::collections::BTreeMap<&'static str, (f64, f64)>);

impl Worst {
    fn note(&mut self, name: &'static str, defect: f64, scale: f64, at: f64) {
        let ratio = defect / scale;
        let entry = self.0.entry(name).or_insert((0.0, 0.0));
        if !(ratio <= entry.0) {
            *entry = (ratio, at);
        }
    }
}

/// The identities of a retraction and its tangents at random points.
fn identities<T: Real, const N: usize, const D: usize, R: Retraction<T, N, D>>(
    retraction: &R,
    group: &Basis<T, N, D>,
    domain: f64,
    cases: usize,
) -> Worst {
    let mut random = Random(7);
    let mut worst = Worst::default();
    let unit = T::unit_roundoff().to_f64();
    for _ in 0..cases {
        let plain = random.magnitude::<N>(1e-12, domain);
        let x = exact::<T, N>(&plain);
        let [y, z] = std::array::from_fn(|_| exact::<T, N>(&random.vector()));
        let m = exact::<T, N>(&random.vector()).transpose();
        let point = match retraction.at(&x) {
            Ok(point) => point,
            Err(RetractionError::SingularTangent { .. } | RetractionError::OutsideDomain { .. }) => continue,
            Err(error) => panic!("{error}"),
        };
        let g = retraction.tau(&x).unwrap();
        let back = retraction.tau(&-x).unwrap();
        let (d, d_inv) = (*point.d(), *point.d_inv());
        let grown = 1.0 + size(&group.algebra.ad(&x));
        let at = size(&x);
        let scale = |factors: &[f64]| unit * grown * factors.iter().fold(1.0, |p, f| p * (1.0 + f));

        let tangent = derivative(|x| retraction.tau(x), &x, &y).unwrap();
        worst.note("T tau = tau dtau", size(&(tangent - g * group.hat(&(d * y)))), scale(&[size(&g), size(&d)]), at);
        let e = size(&(back * g - Matrix::<T, D>::identity()));
        worst.note("tau(-x) tau(x) = 1", e, scale(&[size(&g), size(&back)]), at);
        let one = Matrix::<T, N>::identity();
        worst.note("d d_inv = 1", size(&(d * d_inv - one)), scale(&[size(&d), size(&d_inv)]), at);
        let e = size(&(point.d_neg() * d_inv - point.ad()));
        worst.note("ad = d_neg d_inv", e, scale(&[size(&point.d_neg()), size(&d_inv)]), at);
        let e = size(&(point.d_neg() - *retraction.at(&-x).unwrap().d()));
        worst.note("d_neg = d(-x)", e, scale(&[size(&point.d_neg())]), at);
        let mut conjugation = Matrix::<T, N>::zeros();
        for a in 0..N {
            let e = group.vee(&(g * group.basis[a] * back));
            conjugation.set_column(a, &e);
        }
        worst.note("ad = Ad_tau", size(&(conjugation - point.ad())), scale(&[size(&g), size(&back)]), at);
        let e = size(&(point.ad() * point.ad_inv() - one));
        worst.note("ad ad_inv = 1", e, scale(&[size(&point.ad()), size(&point.ad_inv())]), at);
        let moved = derivative(|x| retraction.at(x).map(|p| p.d() * constant(&y)), &x, &z).unwrap();
        let w = point.dd(&y);
        let scales = [size(&d), size(&d), size(&d_inv)];
        worst.note("d dd = derivative of d", size(&(moved - d * w * z)), scale(&scales), at);
        let p = m * d;
        let e = size(&(point.pull_dd(&p, &m, &y) - p * w));
        worst.note("pull_dd = p dd", e, scale(&[size(&d), size(&w), size(&d_inv)]), at);
        if let Ok(found) = retraction.tau_inv(&g) {
            // Where τ is not injective another preimage may be found: it must still be one.
            let same = size(&(found - x)) < 1e-6 * at;
            let defect = if same { size(&(found - x)) } else { size(&(retraction.tau(&found).unwrap() - g)) };
            worst.note("tau_inv tau = id", defect, scale(&[size(&d_inv), size(&g), size(&back)]), at);
            if same {
                let e = derivative(|x| retraction.tau_inv(&retraction.tau(x)?), &x, &y).unwrap();
                let scales = [size(&d_inv), size(&d_inv), size(&g), size(&back)];
                worst.note("derivative of tau_inv tau", size(&(e - y)), scale(&scales), at);
            }
        } else {
            worst.note("tau_inv refused (count)", 0.0, 1.0, at);
        }
    }
    worst
}

#[test]
fn smoke() {
    fn show<T: Real>() {
        let show = |name: &str, worst: Worst| {
            println!("{name}");
            for (k, v) in worst.0 {
                println!("   {k:30} {:8.2} at {:e}", v.0, v.1);
            }
        };
        show("cay so3", identities(&CayleySo3::<T>::new(), &so3(), 30.0, 300));
        show("cay so3 general", identities(&Cayley::new(so3::<T>()).unwrap(), &so3(), 30.0, 300));
        show("cay se3", identities(&Cayley::new(se3::<T>()).unwrap(), &se3(), 30.0, 300));
        show("cay so4", identities(&Cayley::new(so4::<T>()).unwrap(), &so4(), 30.0, 300));
        show("cay sl2", identities(&Cayley::new(sl2::<T>()).unwrap(), &sl2(), 30.0, 300));
        show("cay aff1", identities(&Cayley::new(aff1::<T>()).unwrap(), &aff1(), 30.0, 300));
        show("cay heis", identities(&Cayley::new(heisenberg::<T>()).unwrap(), &heisenberg(), 30.0, 300));
        println!("{}", Cayley::new(sl3::<T>()).unwrap_err());
        show("exp so3", identities(&ExponentialSo3::<T>::new(), &so3(), 30.0, 300));
        show("exp so3 general", identities(&Exponential::of_group(so3::<T>()), &so3(), 30.0, 300));
        show("exp se3", identities(&Exponential::of_group(se3::<T>()), &se3(), 30.0, 300));
        show("exp so4", identities(&Exponential::of_group(so4::<T>()), &so4(), 30.0, 300));
        show("exp sl2", identities(&Exponential::of_group(sl2::<T>()), &sl2(), 8.0, 300));
        show("exp aff1", identities(&Exponential::of_group(aff1::<T>()), &aff1(), 30.0, 300));
        show("exp heis", identities(&Exponential::of_group(heisenberg::<T>()), &heisenberg(), 30.0, 300));
        show("exp sl3", identities(&Exponential::of_group(sl3::<T>()), &sl3(), 3.0, 300));
    }
    show::<f64>();
}
