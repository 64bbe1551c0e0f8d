//! The Cayley map on matrix groups whose algebra is closed under y ↦ x y x.

use super::linear::{Sum, norm, real_eigenvalues_below_one};
use super::{Retraction, RetractionError, TangentPoint, refuse};
use crate::algebra::brackets::Brackets;
use crate::algebra::elimination::{dominated_inverse, inverse, is_dominated};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, apply, pull, times};
use crate::group::{LieGroup, MatrixGroup};
use crate::scalar::loops::{self, heavy};
use crate::scalar::{Real, Scalar, finite};
use std::sync::Arc;

/// The group does not admit the Cayley map: a symmetrised triple product leaves the algebra.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "the Cayley map does not apply to this group: (e_{0} e_{1} e_{2} + e_{2} e_{1} e_{0})/2 is off the algebra by {defect:e}",
    .a + 1, .b + 1, .c + 1
)]
#[non_exhaustive]
pub struct NotQuadratic {
    /// First and last factor (from 0; the message counts from 1).
    pub a: usize,
    /// Middle factor.
    pub b: usize,
    /// Last and first factor.
    pub c: usize,
    /// The largest entry of the part outside the algebra.
    pub defect: f64,
}

/// The two products that all tangents are made of, without their zeros.
#[derive(Clone, Debug)]
struct Products<T> {
    /// (a, b, c, C^c_ab).
    bracket: Vec<([usize; 3], T)>,
    /// (a, b, d, c, T^c_abd) of T(x, y, z) = ½(x y z + z y x).
    triple: Vec<([usize; 4], T)>,
    /// (a, b, c, d, T^d_abc + T^d_cba), a < c, and (a, b, a, d, T^d_aba): those of x y x.
    square: Vec<([usize; 4], T)>,
    /// ‖e_a‖.
    sizes: Vec<f64>,
}

impl<T: Real> Products<T> {
    fn new<const N: usize, const D: usize>(group: &impl LieGroup<T, N, D>) -> Result<Self, NotQuadratic> {
        let basis: [Matrix<T, D>; N] = std::array::from_fn(|a| {
            group.hat(&Vector::<T, N>::from_fn(|b, _| if a == b { T::one() } else { T::zero() }))
        });
        let size = basis.iter().fold(T::zero(), |s, e| s.max(e.amax()));
        let tolerance = T::int(1024 * (N * D * D) as i64) * T::unit_roundoff();
        let mut bracket = Vec::new();
        let (mut triple, mut square) = (Vec::new(), Vec::new());
        let used = used(&basis);
        let pairs: Vec<Matrix<T, D>> = (0..N * N).map(|k| product(&basis[k / N], &basis[k % N], &used)).collect();
        for a in 0..N {
            for b in 0..N {
                for c in 0..N {
                    let constant = group.algebra().constant(a, b, c);
                    if constant != T::zero() {
                        bracket.push(([a, b, c], constant));
                    }
                    // T(x, y, z) = T(z, y, x).
                    if c > a {
                        continue;
                    }
                    let there = product(&pairs[a * N + b], &basis[c], &used);
                    let product = (there + product(&pairs[c * N + b], &basis[a], &used)) * T::half();
                    let part = group.vee(&product);
                    let defect = (product - group.hat(&part)).amax();
                    // Rounding of hat and vee scales with the coordinates; a true defect with the product.
                    let scale = (size * size).max(part.amax()) * size;
                    if defect > tolerance * scale || !defect.all_finite() {
                        return Err(NotQuadratic { a, b, c, defect: defect.to_f64() });
                    }
                    // What is left where a coordinate is 0. Not more: where basis matrices are of different sizes, constants may be that small.
                    let noise = T::int(16) * T::unit_roundoff() * (size * size).max(part.amax());
                    for (d, value) in part.iter().enumerate() {
                        if value.abs() > noise {
                            triple.push(([a, b, c, d], *value));
                            if a != c {
                                triple.push(([c, b, a, d], *value));
                            }
                            square.push(([a, b, c, d], if a == c { *value } else { *value + *value }));
                        }
                    }
                }
            }
        }
        Ok(Self { bracket, triple, square, sizes: basis.iter().map(norm).collect() })
    }

    /// The matrix of y ↦ x y x.
    fn sandwich<S: Scalar<Base = T>, const N: usize>(&self, x: &Vector<S, N>) -> Matrix<S, N> {
        let mut matrix = Matrix::<S, N>::zeros();
        if const { heavy::<S>() } {
            let place = |[a, b, c, d]: [usize; 4]| [a, c, d + b * N];
            loops::add_trilinear(matrix.as_mut_slice(), &self.square, x.as_slice(), x.as_slice(), place);
            return matrix;
        }
        for &([a, b, c, d], value) in &self.square {
            matrix[(d, b)] += S::lift(value) * (x[a] * x[c]);
        }
        matrix
    }

    /// The matrix of ad_x.
    fn ad<S: Scalar<Base = T>, const N: usize>(&self, x: &Vector<S, N>) -> Matrix<S, N> {
        let mut matrix = Matrix::<S, N>::zeros();
        for &([a, b, c], value) in &self.bracket {
            matrix[(c, b)] += S::lift(value) * x[a];
        }
        matrix
    }
}

/// The rows and columns in which any of the matrices has an entry: a padded representation leaves most empty.
fn used<T: Real, const N: usize, const D: usize>(basis: &[Matrix<T, D>; N]) -> Vec<usize> {
    let empty = |i: usize| basis.iter().all(|e| e.row(i).amax() == T::zero() && e.column(i).amax() == T::zero());
    (0..D).filter(|&i| !empty(i)).collect()
}

/// The product of two matrices that have entries in the rows and columns `used` alone.
fn product<T: Real, const D: usize>(x: &Matrix<T, D>, y: &Matrix<T, D>, used: &[usize]) -> Matrix<T, D> {
    let mut product = Matrix::zeros();
    for &j in used {
        for &k in used {
            let factor = y[(k, j)];
            if factor == T::zero() {
                continue;
            }
            for &i in used {
                product[(i, j)] += x[(i, k)] * factor;
            }
        }
    }
    product
}

/// The Cayley map on a matrix group: τ(x) = (1 − x/2)⁻¹(1 + x/2).
///
/// For groups of quadratic type, and every other whose algebra holds x y x with x and y: SE(2), SE(3), aff(1),
/// Heisenberg, translations, SL(2), SO(n), and their products. dτ_x⁻¹ y = (1 + x/2) y (1 − x/2), hence with v = dτ_x y:
/// dτ_x⁻¹ = 1 + ½ ad_x − ¼ (y ↦ x y x) and ddτ_x(y, δ) = ½[v, δ] + ¼(x v δ + δ v x).
/// Domain: all x without a real eigenvalue of 2 or more in absolute value (`OutsideDomain`); these are the x with 1 − s x/2 and 1 + s x/2
/// regular for 0 ≤ s ≤ 1. On SO(n) and SE(n) that is every x, on SL(2) not. Formulas have values beyond, on a sheet that is not joined to
/// x = 0, and that no step reaches. τ⁻¹(g) = 2(g − 1)(g + 1)⁻¹ needs a g without an eigenvalue ≤ 0.
/// (Bou-Rabee and Marsden 2009; Hairer, Lubich and Wanner 2006, §IV.8.3.)
#[derive(Clone, Debug)]
pub struct Cayley<T: Real, const N: usize, const D: usize, G = MatrixGroup<T, N, D>> {
    group: G,
    products: Arc<Products<T>>,
}

impl<T: Real, const N: usize, const D: usize, G: LieGroup<T, N, D>> Cayley<T, N, D, G> {
    const NAME: &'static str = "cay";
    const SINGULAR: &'static str = "1 − x/2 or 1 + x/2 is singular";
    const BEYOND: &'static str = "x has a real eigenvalue of 2 or more in absolute value";

    /// The Cayley map of `group`.
    ///
    /// # Errors
    /// The algebra is not closed under ½(x y z + z y x), e.g. sl(3); the first offending triple is named.
    pub fn new(group: G) -> Result<Self, NotQuadratic> {
        let products = Arc::new(Products::new(&group)?);
        Ok(Self { group, products })
    }

    /// The group.
    pub fn group(&self) -> &G {
        &self.group
    }

    /// Whether x is in the domain, whatever the arithmetic can invert.
    fn is_inside<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> bool {
        let size = |(v, size): (&S, &f64)| v.to_f64().abs() * size;
        x.iter().zip(&self.products.sizes).map(size).sum::<f64>() < 2.0
            || real_eigenvalues_below_one(&self.group.hat(x).map(|v| v.to_f64() * 0.5))
    }
}

impl<T: Real, const N: usize, const D: usize, G: LieGroup<T, N, D>> Retraction<T, N, D> for Cayley<T, N, D, G> {
    type Point<S: Scalar<Base = T>> = CayleyPoint<T, S, N>;

    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        self.group.algebra()
    }

    /// 1 + (1 − x/2)⁻¹ x, which keeps the digits of a small x.
    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        let fail = || refuse(x, Self::NAME, Self::SINGULAR);
        if !self.is_inside(x) {
            return Err(refuse(x, Self::NAME, Self::BEYOND));
        }
        let (one, hat) = (Matrix::<S, D>::identity(), self.group.hat(x));
        let inverse = Sum::of(one).plus(&(hat * -S::half())).invert(1.0).ok_or_else(fail)?;
        let g = one + times(&inverse, &hat);
        if finite(g.as_slice()) { Ok(g) } else { Err(fail()) }
    }

    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let fail = |why| RetractionError::NoPreimage { retraction: Self::NAME, why };
        if !finite(g.as_slice()) {
            return Err(RetractionError::NotFinite { retraction: Self::NAME });
        }
        let one = Matrix::<S, D>::identity();
        let inverse = Sum::of(one).plus(g).invert(1.0).ok_or(fail("g + 1 is singular"))?;
        let hat = times(&(g - one), &inverse) * S::int(2);
        let x = self.group.vee(&hat);
        // vee projects: what it drops must be small against what the condition of g + 1 explains.
        let largest = |m: &Matrix<S, D>| m.iter().fold(0.0, |s: f64, v| s.max(v.to_f64().abs()));
        let allowed = T::unit_roundoff().to_f64().sqrt() * (1.0 + largest(g)) * (1.0 + largest(&inverse)).powi(2);
        if largest(&(self.group.hat(&x) - hat)) > allowed {
            Err(fail("the matrix is not in the group"))
        } else if self.is_inside(&x) {
            Ok(x)
        } else {
            Err(fail("g has an eigenvalue of 0 or less"))
        }
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<CayleyPoint<T, S, N>, RetractionError> {
        let fail = || refuse(x, Self::NAME, Self::SINGULAR);
        if !self.is_inside(x) {
            return Err(refuse(x, Self::NAME, Self::BEYOND));
        }
        let (even, odd) = (self.products.sandwich(x) * S::exact(-0.25), self.products.ad(x) * S::half());
        let one = Matrix::<S, N>::identity();
        let (d_inv, d_neg_inv) = (one + even + odd, one + even - odd);
        let d = if is_dominated(&d_inv) && is_dominated(&d_neg_inv) {
            dominated_inverse(&d_inv)
        } else {
            let even = Sum::of(one).plus(&even);
            even.clone().plus(&-odd).invert(1.0).ok_or_else(fail)?;
            even.plus(&odd).invert(1.0).ok_or_else(fail)?
        };
        if !finite(d.as_slice()) {
            return Err(fail());
        }
        Ok(CayleyPoint { products: Arc::clone(&self.products), x: *x, d, d_inv, d_neg_inv })
    }

    /// All digits: η + ½ [x, η] − ¼ x η x.
    fn rough_rates<const W: usize>(&self, brackets: &Brackets<T>, x: &[[T; W]; N], eta: &[[T; W]; N]) -> [[T; W]; N] {
        let mut rates = brackets.brackets(x, eta);
        if const { heavy::<T>() && W == 1 } {
            let [x, y] = [x, eta].map(|v| Vector::<T, N>::from_column_slice(v.as_flattened()));
            let sandwich = apply(&self.products.sandwich(&x), &y);
            let half = T::half();
            return std::array::from_fn(|a| std::array::from_fn(|w| y[a] + (rates[a][w] - sandwich[a] * half) * half));
        }
        for &([a, b, c, d], value) in &self.products.square {
            let (half, first, middle, last, sum) = (value * T::half(), &x[a], &eta[b], &x[c], &mut rates[d]);
            for w in 0..W {
                sum[w] -= half * (first[w] * middle[w] * last[w]);
            }
        }
        for a in 0..N {
            for w in 0..W {
                rates[a][w] = eta[a][w] + rates[a][w] * T::half();
            }
        }
        rates
    }
}

/// The tangents of [`Cayley`] at x.
#[derive(Clone, Debug)]
pub struct CayleyPoint<T: Real, S: Scalar<Base = T>, const N: usize> {
    products: Arc<Products<T>>,
    x: Vector<S, N>,
    d: Matrix<S, N>,
    d_inv: Matrix<S, N>,
    d_neg_inv: Matrix<S, N>,
}

impl<T: Real, S: Scalar<Base = T>, const N: usize> TangentPoint<S, N> for CayleyPoint<T, S, N> {
    fn d(&self) -> &Matrix<S, N> {
        &self.d
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        &self.d_inv
    }

    fn d_neg(&self) -> Matrix<S, N> {
        // Asked for once a step. That there is one `at` has seen.
        match is_dominated(&self.d_neg_inv) {
            true => dominated_inverse(&self.d_neg_inv),
            false => inverse(&self.d_neg_inv).unwrap_or(self.d_neg_inv),
        }
    }

    fn ad(&self) -> Matrix<S, N> {
        times(&self.d_neg(), &self.d_inv)
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        times(&self.d, &self.d_neg_inv)
    }

    fn pull_ad_inv(&self, _: &Covector<S, N>, f_d: &Covector<S, N>) -> Covector<S, N> {
        pull(f_d, &self.d_neg_inv)
    }

    /// δ ↦ ½[v, δ] + ½ T(x, v, δ), v = dτ_x y.
    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        let v = apply(&self.d, y);
        let mut matrix = self.products.ad(&v);
        if const { heavy::<S>() } {
            let place = |[a, b, c, d]: [usize; 4]| [a, b, d + c * N];
            let (x, v) = (self.x.as_slice(), v.as_slice());
            loops::add_trilinear(matrix.as_mut_slice(), &self.products.triple, x, v, place);
            return matrix * S::half();
        }
        for &([a, b, c, d], value) in &self.products.triple {
            matrix[(d, c)] += S::lift(value) * (self.x[a] * v[b]);
        }
        matrix * S::half()
    }

    /// ½ p ad_v + ½ p T(x, v, ·).
    fn pull_dd(&self, p: &Covector<S, N>, _m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        let v = apply(&self.d, y);
        let mut row = Covector::<S, N>::zeros();
        for &([a, b, c], value) in &self.products.bracket {
            row[b] += S::lift(value) * (p[c] * v[a]);
        }
        for &([a, b, c, d], value) in &self.products.triple {
            row[c] += S::lift(value) * (p[d] * (self.x[a] * v[b]));
        }
        row * S::half()
    }
}
