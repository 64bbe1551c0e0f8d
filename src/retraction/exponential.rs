//! The exponential on any Lie algebra, from structure constants alone; with a group, τ and τ⁻¹ too.

use super::linear::{Sum, balanced_norm, norm};
use super::{Retraction, RetractionError, TangentPoint, add_lanes};
use crate::algebra::brackets::Brackets;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, apply, pull, times};
use crate::group::{LieGroup, MatrixGroup};
use crate::scalar::loops::{self, heavy};
use crate::scalar::{Real, Scalar, finite};
use nalgebra::SMatrix;

/// The most corrections of a logarithm. Each squares the error or better, so a start in `f64` needs two for 32 digits; more are
/// for matrices near a cut, where the start is poor.
const MAX_CORRECTIONS: usize = 20;

/// A logarithm's correction below this multiple of what one rounding of the residual makes of it is rounding.
const NOISE: f64 = 64.0;

/// The most terms of a series: enough for 40 digits at norm 1.
const MAX_TERMS: usize = 40;

/// The most terms of a series that are summed without a product of matrices.
const MAX_BLOCK: usize = 8;

/// (2k)!/B_2k of the first Bernoulli numbers.
const BERNOULLI: [i64; 3] = [12, -720, 30240];

/// τ = exp on a Lie algebra of dimension N.
///
/// dτ_x = φ(−ad_x), φ(z) = (eᶻ − 1)/z, by its series at x/2^k and k doublings. dτ is singular iff ad_x has an
/// eigenvalue 2πik, k ≠ 0 (`SingularTangent`). The tangents need structure constants alone; τ and τ⁻¹ need the group
/// (`NoGroup` without). τ⁻¹ is the principal logarithm: g must have no eigenvalue on the closed negative real axis.
/// (Iserles et al. 2000, §2; Martín de Diego and Sato Martín de Almagro 2019, §5.2.)
#[derive(Clone, Debug)]
pub struct Exponential<T: Real, const N: usize, const D: usize, G = MatrixGroup<T, N, D>> {
    algebra: LieAlgebra<T, N>,
    group: Option<G>,
}

/// How a series is to be summed: at x/2^`levels`, with `terms` terms.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Plan {
    levels: u32,
    terms: usize,
}

impl Plan {
    /// For a matrix that the series is in powers of; `None` if it is so large that scaling it cannot help.
    fn of<S: Scalar, const M: usize>(matrix: &Matrix<S, M>) -> Option<Self> {
        let mut size = norm(matrix);
        if size > 1.0 {
            size = balanced_norm(matrix);
        }
        // Beyond 10³⁰ nothing that depends on the size of x has a digit left.
        if size.is_nan() || size > 1e30 {
            return None;
        }
        let mut levels = 0;
        while size > 1.0 {
            size *= 0.5;
            levels += 1;
        }
        // size^K/K! below the round-off; three spare terms for what derivatives by dual numbers multiply by K.
        let spare = if size_of::<S>() > size_of::<S::Base>() { 3 } else { 0 };
        let unit = S::unit_roundoff().to_f64();
        loop {
            let (mut terms, mut bound) = (1, size);
            while bound > 0.125 * unit {
                terms += 1;
                bound *= size / terms as f64;
            }
            if terms + spare < MAX_TERMS {
                return Some(Self { levels, terms: terms + spare });
            }
            // A scalar of more than 40 digits: of a smaller matrix the series takes fewer terms.
            (size, levels) = (0.5 * size, levels + 1);
        }
    }

    /// 2^−levels, exactly.
    fn scale<S: Scalar>(self) -> S {
        S::exact(0.5f64.powi(self.levels as i32))
    }
}

/// dτ_{±x}.
#[derive(Clone, Debug, PartialEq)]
struct Pair<S: Scalar, const N: usize> {
    d: Matrix<S, N>,
    d_neg: Matrix<S, N>,
}

/// e^{∓ad_x}.
#[derive(Clone, Debug, PartialEq)]
struct Adjoints<S: Scalar, const N: usize> {
    ad_inv: Matrix<S, N>,
    ad: Matrix<S, N>,
}

/// The powers X, X², …, X^q of a matrix, for series in X: in blocks of q terms, which Horner's scheme in X^q joins, so that K terms
/// cost some 2 √K products (Paterson and Stockmeyer 1973).
struct Powers<S: Scalar, const M: usize> {
    powers: [Matrix<S, M>; MAX_BLOCK],
    block: usize,
}

impl<S: Scalar, const M: usize> Powers<S, M> {
    /// For `series` series of `terms` terms.
    fn of(x: &Matrix<S, M>, terms: usize, series: usize) -> Self {
        let products = |block: &usize| block + series * terms.div_ceil(*block);
        let block = (1..=MAX_BLOCK).min_by_key(products).unwrap_or(1);
        let mut powers = [*x; MAX_BLOCK];
        for k in 1..block {
            powers[k] = times(x, &powers[k - 1]);
        }
        Self { powers, block }
    }

    /// Σ_k c_k X^k, k = 0, 1, ….
    fn sum(&self, coefficients: &[S::Base]) -> Matrix<S, M> {
        let mut sum = Matrix::<S, M>::zeros();
        for (i, block) in coefficients.chunks(self.block).enumerate().rev() {
            if (i + 1) * self.block < coefficients.len() {
                sum = times(&self.powers[self.block - 1], &sum);
            }
            for (power, c) in self.powers.iter().zip(&block[1..]) {
                add_multiple(&mut sum, power, S::lift(*c));
            }
            for k in 0..M {
                sum[(k, k)] += S::lift(block[0]);
            }
        }
        sum
    }
}

/// A += X c.
#[inline(always)]
fn add_multiple<S: Scalar, const R: usize, const C: usize>(a: &mut SMatrix<S, R, C>, x: &SMatrix<S, R, C>, c: S) {
    if const { heavy::<S>() } {
        loops::add_multiple(a.as_mut_slice(), x.as_slice(), c);
    } else {
        *a += x * c;
    }
}

/// 1/(n_k)! of the numbers n_0 < n_1 < …, `count` of them, into the front of an array.
fn inverse_factorials<T: Real>(first: usize, step: usize, count: usize) -> [T; MAX_TERMS] {
    let mut all = [T::zero(); MAX_TERMS];
    let (mut value, mut n) = (T::one(), 0);
    for (k, coefficient) in all.iter_mut().enumerate().take(count) {
        while n < first + k * step {
            n += 1;
            value /= T::int(n as i64);
        }
        *coefficient = value;
    }
    all
}

impl<S: Scalar, const N: usize> Pair<S, N> {
    /// By the even and the odd part of Σ (−ad)^k/(k+1)!, both in powers of ad².
    fn series(ad: &Matrix<S, N>, terms: usize) -> Self {
        let count = terms / 2 + 2;
        let powers = Powers::of(&times(ad, ad), count, 2);
        let even = powers.sum(&inverse_factorials(1, 2, count)[..count]);
        let odd = powers.sum(&inverse_factorials(2, 2, count)[..count]);
        let odd = times(ad, &odd);
        Self { d: even - odd, d_neg: even + odd }
    }

    /// 1 − ad dτ_x.
    fn ad_inv(&self, ad: &Matrix<S, N>) -> Matrix<S, N> {
        Matrix::identity() - times(ad, &self.d)
    }

    /// 1 + ad dτ_{−x}.
    fn ad(&self, ad: &Matrix<S, N>) -> Matrix<S, N> {
        Matrix::identity() + times(ad, &self.d_neg)
    }

    fn adjoints(&self, ad: &Matrix<S, N>) -> Adjoints<S, N> {
        Adjoints { ad_inv: self.ad_inv(ad), ad: self.ad(ad) }
    }

    /// From x to 2x.
    fn double(&mut self, adjoints: &mut Adjoints<S, N>) {
        let Adjoints { ad_inv, ad } = adjoints;
        self.d = (self.d + times(ad_inv, &self.d)) * S::half();
        self.d_neg = (self.d_neg + times(ad, &self.d_neg)) * S::half();
        *ad_inv = times(ad_inv, ad_inv);
        *ad = times(ad, ad);
    }
}

impl<T: Real, const N: usize, const D: usize, G: LieGroup<T, N, D>> Exponential<T, N, D, G> {
    /// The exponential of a matrix group.
    pub fn of_group(group: G) -> Self {
        Self { algebra: group.algebra().clone(), group: Some(group) }
    }
}

impl<T: Real, const N: usize, const D: usize, G> Exponential<T, N, D, G> {
    const NAME: &'static str = "exp";

    /// The exponential of an algebra given by constants alone: `tau` and `tau_inv` say `NoGroup`.
    pub fn of_algebra(algebra: LieAlgebra<T, N>) -> Self {
        Self { algebra, group: None }
    }

    fn too_large<S: Scalar>(x: &Vector<S, N>) -> RetractionError {
        super::refuse(x, Self::NAME, "the exponential overflows")
    }

    /// dτ_x⁻¹ = ½ ad_x + H(ad_x/2), H(z) = z coth z, doubled by H(2z) = H(z) + z² H(z)⁻¹ from x/2^levels.
    ///
    /// Each H(z)⁻¹ in the chain fails only where dτ is singular, and real eigenvalues, however large, leave H well
    /// conditioned, which dτ itself is not.
    fn inverse_tangent<S: Scalar>(ad: &Matrix<S, N>, d: &Matrix<S, N>, levels: u32) -> Option<Matrix<S, N>> {
        let mut z = ad * S::half();
        let mut h = Sum::of(Sum::of(*d).invert(1.0)?).plus(&-z);
        // Errors at most double with x, so what is singular at x to working precision is noisy by 2^levels on the way.
        let noise = 2.0f64.powi(levels as i32);
        for _ in 0..levels {
            h = Sum::of(*h.value()).plus(&times(&times(&z, &z), &h.invert(noise)?));
            z *= S::int(2);
        }
        Some(h.value() + z)
    }
}

/// e^X by its Taylor series at X/2^k and k squarings, in any scalar.
fn exponential<S: Scalar, const M: usize>(matrix: &Matrix<S, M>) -> Option<Matrix<S, M>> {
    let plan = Plan::of(matrix)?;
    let small = matrix * plan.scale::<S>();
    let count = plan.terms + 1;
    let mut sum = Powers::of(&small, count, 1).sum(&inverse_factorials(0, 1, count)[..count]);
    for _ in 0..plan.levels {
        sum = times(&sum, &sum);
    }
    finite(sum.as_slice()).then_some(sum)
}

/// The principal square root by the product form of Denman and Beavers' iteration (Higham 2008, §6.3), or `None` if
/// it does not converge.
fn square_root<T: Real, const M: usize>(matrix: &Matrix<T, M>) -> Option<Matrix<T, M>> {
    let one = Matrix::<T, M>::identity();
    let (mut product, mut root) = (Sum::of(*matrix), *matrix);
    let tolerance = (T::int(64) * T::unit_roundoff()).to_f64();
    let mut last = f64::INFINITY;
    for _ in 0..200 {
        let inverse = product.invert(1.0)?;
        root = (root + times(&root, &inverse)) * T::half();
        let quarter = T::exact(0.25);
        product = Sum::of(one * T::half()).plus(&(product.value() * quarter)).plus(&(inverse * quarter));
        let defect = norm(&(product.value() - one));
        if defect <= tolerance || (defect < 1e-6 && defect >= 0.5 * last) {
            return Some(root);
        }
        last = defect;
    }
    None
}

/// The principal logarithm: square roots down to 1 + Y with |Y| ≤ ¼, then 2 artanh(Z), Z = Y/(2 + Y), by its series; each
/// square root loses a digit or so.
fn rough_logarithm<T: Real, const M: usize>(matrix: &Matrix<T, M>) -> Option<Matrix<T, M>> {
    let one = Matrix::<T, M>::identity();
    let (mut root, mut scale) = (*matrix, T::int(2));
    while norm(&(root - one)) > 0.25 {
        if scale > T::exact(1e15) {
            return None;
        }
        root = square_root(&root)?;
        scale *= T::int(2);
    }
    let y = root - one;
    let z = times(&y, &Sum::of(one * T::int(2)).plus(&y).invert(1.0)?);
    let square = times(&z, &z);
    // |Z²|^terms is below rounding; |Z²| ≤ 1/49.
    let rate = norm(&square).max(T::unit_roundoff().to_f64());
    let terms = (T::unit_roundoff().to_f64().ln() / rate.ln()).ceil() as i64;
    let mut sum = one / T::int(2 * terms + 1);
    for k in (0..terms).rev() {
        sum = one / T::int(2 * k + 1) + times(&square, &sum);
    }
    Some(times(&z, &sum) * scale)
}

impl<T: Real, const N: usize, const D: usize, G: LieGroup<T, N, D>> Exponential<T, N, D, G> {
    /// dτ_x⁻¹ (τ(−x) g − 1)^∨ and the size of τ(−x) g − 1: Newton's correction to x in τ(x) = g.
    fn correction<S: Scalar<Base = T>>(
        &self,
        group: &G,
        g: &Matrix<S, D>,
        x: &Vector<S, N>,
        d_inv: &Matrix<S, N>,
    ) -> Option<(Vector<S, N>, f64)> {
        let y = times(&exponential(&group.hat(&-x))?, g) - Matrix::<S, D>::identity();
        Some((
            apply(d_inv, &group.vee(&(y - times(&y, &y) * S::half()))),
            y.iter().fold(0.0, |m: f64, v| m.max(v.to_f64().abs())),
        ))
    }

    /// The logarithm of a base matrix to full precision, and dτ⁻¹ there.
    fn base_logarithm(&self, group: &G, g: &Matrix<T, D>) -> Result<(Vector<T, N>, Matrix<T, N>), RetractionError> {
        let fail = |why| RetractionError::NoPreimage { retraction: Self::NAME, why };
        let log = rough_logarithm(g).ok_or(fail("an eigenvalue lies on the closed negative real axis"))?;
        let mut x = group.vee(&log);
        let unit = T::unit_roundoff().to_f64();
        let scale = 1.0 + g.iter().fold(0.0, |m: f64, v| m.max(v.to_f64().abs()));
        let inside = |residual: f64| residual <= scale * scale * unit.sqrt();
        let (mut last, mut rest) = (f64::INFINITY, 0.0);
        for _ in 0..MAX_CORRECTIONS {
            let d_inv = self.at(&x)?.d_inv;
            let (step, residual) = self.correction(group, g, &x, &d_inv).ok_or(fail("the logarithm overflows"))?;
            let size = step.iter().fold(0.0, |m: f64, v| m.max(v.to_f64().abs()));
            // What rounding of the residual may make of a correction: near a cut dτ⁻¹ is large, and a start may be so poor that its first
            // corrections are no smaller.
            let noise = NOISE * unit * scale * scale * (1.0 + d_inv.amax().to_f64());
            let settled = size == 0.0 || (size >= 0.5 * last && (size <= noise || !inside(residual)));
            let rounding = !settled && size <= 8.0 * unit * (1.0 + x.amax().to_f64());
            if rounding {
                x += step;
            }
            if settled || rounding {
                return if inside(residual) { Ok((x, d_inv)) } else { Err(fail("the matrix is not in the group")) };
            }
            x += step;
            (last, rest) = (size, residual);
        }
        let left = inside(rest);
        Err(fail(if left {
            "the iteration for the logarithm does not converge"
        } else {
            "the matrix is not in the group"
        }))
    }
}

impl<T: Real, const N: usize, const D: usize, G: LieGroup<T, N, D>> Retraction<T, N, D> for Exponential<T, N, D, G> {
    type Point<S: Scalar<Base = T>> = ExponentialPoint<T, S, N>;

    fn name(&self) -> &'static str {
        Self::NAME
    }

    fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.algebra
    }

    fn tau<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<Matrix<S, D>, RetractionError> {
        let group = self.group.as_ref().ok_or(RetractionError::NoGroup { retraction: Self::NAME })?;
        exponential(&group.hat(x)).ok_or_else(|| Self::too_large(x))
    }

    /// By inverse scaling and squaring, then Newton's iteration x ← x + dτ_x⁻¹ (τ(−x) g − 1)^∨ to
    /// full precision.
    fn tau_inv<S: Scalar<Base = T>>(&self, g: &Matrix<S, D>) -> Result<Vector<S, N>, RetractionError> {
        let group = self.group.as_ref().ok_or(RetractionError::NoGroup { retraction: Self::NAME })?;
        if !finite(g.as_slice()) {
            return Err(RetractionError::NotFinite { retraction: Self::NAME });
        }
        let (x, d_inv) = self.base_logarithm(group, &g.map(|v| v.base()))?;
        let (mut x, d_inv) = (x.map(S::lift), d_inv.map(S::lift));
        // One more correction for each level of nesting of dual numbers (each level doubles the size).
        let mut parts = size_of::<T>();
        while parts < size_of::<S>() {
            let why = "the logarithm overflows";
            let step = self.correction(group, g, &x, &d_inv);
            x += step.ok_or(RetractionError::NoPreimage { retraction: Self::NAME, why })?.0;
            parts *= 2;
        }
        Ok(x)
    }

    fn at<S: Scalar<Base = T>>(&self, x: &Vector<S, N>) -> Result<ExponentialPoint<T, S, N>, RetractionError> {
        let ad = self.algebra.ad(x);
        let plan = Plan::of(&ad).ok_or_else(|| Self::too_large(x))?;
        let small = ad * plan.scale::<S>();
        let mut pair = Pair::series(&small, plan.terms);
        let d_inv = Self::inverse_tangent(&small, &pair.d, plan.levels);
        let mut adjoints = (plan.levels > 0).then(|| pair.adjoints(&small));
        if let Some(adjoints) = &mut adjoints {
            for _ in 0..plan.levels {
                pair.double(adjoints);
            }
        }
        if !finite(pair.d.as_slice()) || !finite(pair.d_neg.as_slice()) {
            return Err(Self::too_large(x));
        }
        let Some(d_inv) = d_inv else {
            let size = x.iter().fold(0.0, |m: f64, v| m.max(v.to_f64().abs()));
            return Err(RetractionError::SingularTangent { retraction: Self::NAME, size });
        };
        Ok(ExponentialPoint { algebra: self.algebra.clone(), small, plan, pair, adjoints, d_inv })
    }

    /// η + ½ ad_x η + Σ B_2k/(2k)! ad_x^{2k} η, with the first terms.
    fn rough_rates<const W: usize>(&self, brackets: &Brackets<T>, x: &[[T; W]; N], eta: &[[T; W]; N]) -> [[T; W]; N] {
        let mut odd = brackets.brackets(x, eta);
        let mut rates = *eta;
        add_lanes(&mut rates, &odd, T::half());
        for denominator in BERNOULLI {
            let even = brackets.brackets(x, &odd);
            add_lanes(&mut rates, &even, T::ratio(1, denominator));
            odd = brackets.brackets(x, &even);
        }
        rates
    }
}

/// The tangents of [`Exponential`] at x.
#[derive(Clone, Debug)]
pub struct ExponentialPoint<T: Real, S: Scalar<Base = T>, const N: usize> {
    algebra: LieAlgebra<T, N>,
    /// ad_x/2^levels.
    small: Matrix<S, N>,
    plan: Plan,
    pair: Pair<S, N>,
    /// None without doublings: rarely asked for.
    adjoints: Option<Adjoints<S, N>>,
    d_inv: Matrix<S, N>,
}

impl<T: Real, S: Scalar<Base = T>, const N: usize> ExponentialPoint<T, S, N> {
    /// W_x(y) = ∂_x(dτ_x y) as a matrix: at x/2^levels by W = Σ_{k≥1} Z_k/(k+1)!, Z_k = ad_{w_{k−1}} − ad_x Z_{k−1},
    /// w_k = (−ad_x)^k y; then W_{2x}(y) = ¼[ad_{e^{−ad_x} dτ_x y} dτ_x + (1 + e^{−ad_x}) W_x(y)].
    fn derivative(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        let mut w = *y;
        let mut z = self.algebra.ad(&w);
        let mut coefficient = S::half();
        let mut sum = z * coefficient;
        for k in 2..=self.plan.terms as i64 {
            w = -apply(&self.small, &w);
            z = self.algebra.ad(&w) - times(&self.small, &z);
            coefficient /= S::int(k + 1);
            sum += z * coefficient;
        }
        if self.plan.levels > 0 {
            let mut pair = Pair::series(&self.small, self.plan.terms);
            let mut adjoints = pair.adjoints(&self.small);
            for _ in 0..self.plan.levels {
                let moved = self.algebra.ad(&apply(&adjoints.ad_inv, &apply(&pair.d, y)));
                sum = (times(&moved, &pair.d) + sum + times(&adjoints.ad_inv, &sum)) * S::exact(0.25);
                pair.double(&mut adjoints);
            }
        }
        sum
    }

    /// m W_x(y) without doublings: Σ_ij m_i ad_{w_j}/(i+j+2)!, with m_i = m (−ad_x)^i and w_j = (−ad_x)^j y.
    fn pull_derivative(&self, m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        let terms = self.plan.terms;
        let mut rows = [Covector::<S, N>::zeros(); MAX_TERMS];
        let mut inverse_factorials = [S::half(); MAX_TERMS];
        rows[0] = *m;
        for i in 1..terms {
            rows[i] = -pull(&rows[i - 1], &self.small);
            inverse_factorials[i] = inverse_factorials[i - 1] / S::int(i as i64 + 2);
        }
        // outer = Σ_j q_jᵀ w_jᵀ with q_j = Σ_i m_i/(i+j+2)!.
        let mut outer = Matrix::<S, N>::zeros();
        let mut w = *y;
        for j in 0..terms {
            let mut q = rows[0] * inverse_factorials[j];
            for i in 1..terms - j {
                add_multiple(&mut q, &rows[i], inverse_factorials[i + j]);
            }
            outer += times(&q.transpose(), &w.transpose());
            w = -apply(&self.small, &w);
        }
        self.algebra.contract(&outer)
    }
}

impl<T: Real, S: Scalar<Base = T>, const N: usize> TangentPoint<S, N> for ExponentialPoint<T, S, N> {
    fn d(&self) -> &Matrix<S, N> {
        &self.pair.d
    }

    fn d_inv(&self) -> &Matrix<S, N> {
        &self.d_inv
    }

    fn d_neg(&self) -> Matrix<S, N> {
        self.pair.d_neg
    }

    fn ad(&self) -> Matrix<S, N> {
        self.adjoints.as_ref().map_or_else(|| self.pair.ad(&self.small), |adjoints| adjoints.ad)
    }

    fn ad_inv(&self) -> Matrix<S, N> {
        self.adjoints.as_ref().map_or_else(|| self.pair.ad_inv(&self.small), |adjoints| adjoints.ad_inv)
    }

    fn pull_ad_inv(&self, f: &Covector<S, N>, f_d: &Covector<S, N>) -> Covector<S, N> {
        match &self.adjoints {
            Some(adjoints) => pull(f, &adjoints.ad_inv),
            None => f - pull(f_d, &self.small),
        }
    }

    fn dd(&self, y: &Vector<S, N>) -> Matrix<S, N> {
        times(&self.d_inv, &self.derivative(y))
    }

    fn pull_dd(&self, _p: &Covector<S, N>, m: &Covector<S, N>, y: &Vector<S, N>) -> Covector<S, N> {
        if self.plan.levels == 0 { self.pull_derivative(m, y) } else { m * self.derivative(y) }
    }
}
