//! The Cayley map of a matrix group in lanes, by its basis matrices.

use super::Lanes;
use super::group::{FastRetraction, LaneGroup};
use crate::algebra::{Matrix, Vector};
use crate::group::LieGroup;
use crate::retraction::Cayley;
use std::sync::Arc;

/// A matrix in lanes, by rows.
type Square<V, const D: usize> = [[V; D]; D];

/// The Cayley map of a group of D×D matrices of dimension N, in lanes.
///
/// With x = 2y, Y = ŷ, A = (1 − Y)⁻¹, B = (1 + Y)⁻¹: τ = 2A − 1 and τ⁻¹ = 2B − 1 = 1 − 2YB; dτ⁻¹η = (1 + Y) η̂ (1 − Y) and dτη = B η̂ A
/// (Bou-Rabee and Marsden 2009; Hairer, Lubich and Wanner 2006, §IV.8.3). A covector f is a matrix F with f(η) = ⟨F, η̂⟩ = Σ F_rc η̂_rc, so that
/// η̂ ↦ S η̂ T turns F into SᵀFTᵀ. No product has terms with the rows at the bottom that are 0 in all basis matrices.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct MatricesInLanes<const N: usize, const D: usize>(Arc<Basis<N>>);

#[derive(Debug)]
struct Basis<const N: usize> {
    /// The entries of the basis matrices: (a, row, column, value), x̂ = Σ value x_a there.
    hat: Vec<Entry>,
    /// x_a = Σ value M there, for M = x̂.
    vee: Vec<Entry>,
    /// C^c_ab: (a, b, c, value).
    constants: Vec<Entry>,
    /// The rows that are not 0 in all basis matrices.
    rows: usize,
    rotation: usize,
    /// Whether no displacement leaves the domain.
    complete: bool,
    /// For each basis matrix the largest sum of the sizes of the entries of a row.
    sizes: [f64; N],
}

#[derive(Clone, Copy, Debug)]
struct Entry {
    at: [u8; 3],
    value: f64,
}

impl<const N: usize> Basis<N> {
    fn of<const D: usize>(group: &impl LieGroup<f64, N, D>) -> Self {
        let unit = |a: usize| Vector::<f64, N>::from_fn(|b, _| if a == b { 1.0 } else { 0.0 });
        let basis: Vec<Matrix<f64, D>> = (0..N).map(|a| group.hat(&unit(a))).collect();
        let entry = |at: [usize; 3], value: f64| (value != 0.0).then(|| Entry { at: at.map(|k| k as u8), value });
        let places = || (0..D).flat_map(|r| (0..D).map(move |c| (r, c)));
        let hat = places().flat_map(|(r, c)| {
            let of = |a: usize| entry([a, r, c], basis[a][(r, c)]);
            (0..N).filter_map(of).collect::<Vec<_>>()
        });
        // By an entry that is 0 in all other basis matrices, where each has one: a matrix of the algebra is known by these.
        let own = |a: usize| {
            places().find(|&(r, c)| basis[a][(r, c)] != 0.0 && (0..N).all(|b| a == b || basis[b][(r, c)] == 0.0))
        };
        let by_own = (0..N).map(|a| own(a).and_then(|(r, c)| entry([a, r, c], 1.0 / basis[a][(r, c)])));
        let vee = by_own.collect::<Option<Vec<_>>>().unwrap_or_else(|| {
            let of = |(r, c): (usize, usize)| {
                let one = Matrix::<f64, D>::from_fn(|i, j| if (i, j) == (r, c) { 1.0 } else { 0.0 });
                let coordinates = group.vee(&one);
                (0..N).filter_map(|a| entry([a, r, c], coordinates[a])).collect::<Vec<_>>()
            };
            places().flat_map(of).collect()
        });
        let algebra = group.algebra();
        let triples = (0..N * N * N).map(|k| [k / N % N, k % N, k / (N * N)]);
        let constants = triples.filter_map(|[a, b, c]| entry([a, b, c], algebra.constant(a, b, c)));
        let empty = |r: usize| basis.iter().all(|e| e.row(r).amax() == 0.0);
        let rows = (0..D).rev().find(|&r| !empty(r)).map_or(0, |r| r + 1);
        // A leading block of skew matrices, with nothing below it.
        let skew = |n: usize| {
            let below = |e: &Matrix<f64, D>| (n..D).all(|r| (0..n).all(|c| e[(r, c)] == 0.0));
            basis.iter().all(|e| below(e) && (0..n).all(|r| (0..n).all(|c| e[(r, c)] == -e[(c, r)])))
        };
        let rotation = (2..=D).rev().find(|&n| skew(n) && basis.iter().any(|e| e.view((0, 0), (n, n)).amax() > 0.0));
        let rest_empty = |n: usize| basis.iter().all(|e| (n..D).all(|r| (n..=r).all(|c| e[(r, c)] == 0.0)));
        let (hat, constants) = (hat.collect(), constants.collect());
        let rotation = rotation.unwrap_or(0);
        let size =
            |e: &Matrix<f64, D>| (0..D).map(|r| e.row(r).iter().map(|v| v.abs()).sum::<f64>()).fold(0.0, f64::max);
        Self {
            hat,
            vee,
            constants,
            rows,
            rotation,
            complete: rest_empty(rotation),
            sizes: std::array::from_fn(|a| size(&basis[a])),
        }
    }
}

impl<const N: usize, const D: usize> MatricesInLanes<N, D> {
    /// x̂.
    #[inline(always)]
    fn hat<V: Lanes>(&self, x: [V; N]) -> Square<V, D> {
        let mut matrix = [[x[0].constant(0.0); D]; D];
        for &Entry { at: [a, r, c], value } in &self.0.hat {
            let there = &mut matrix[r as usize][c as usize];
            *there = x[0].constant(value).mul_add(x[a as usize], *there);
        }
        matrix
    }

    /// The coordinates of a matrix of the algebra.
    #[inline(always)]
    fn vee<V: Lanes>(&self, matrix: &Square<V, D>) -> [V; N] {
        let zero = matrix[0][0].constant(0.0);
        let mut x = [zero; N];
        for &Entry { at: [a, r, c], value } in &self.0.vee {
            x[a as usize] = zero.constant(value).mul_add(matrix[r as usize][c as usize], x[a as usize]);
        }
        x
    }

    /// The matrix of a covector.
    #[inline(always)]
    fn covector<V: Lanes>(&self, f: [V; N]) -> Square<V, D> {
        let mut matrix = [[f[0].constant(0.0); D]; D];
        for &Entry { at: [a, r, c], value } in &self.0.vee {
            let there = &mut matrix[r as usize][c as usize];
            *there = f[0].constant(value).mul_add(f[a as usize], *there);
        }
        matrix
    }

    /// The covector of a matrix: η ↦ ⟨F, η̂⟩.
    #[inline(always)]
    fn against<V: Lanes>(&self, matrix: &Square<V, D>) -> [V; N] {
        let zero = matrix[0][0].constant(0.0);
        let mut f = [zero; N];
        for &Entry { at: [a, r, c], value } in &self.0.hat {
            f[a as usize] = zero.constant(value).mul_add(matrix[r as usize][c as usize], f[a as usize]);
        }
        f
    }

    /// S + X Y, or S − X Y.
    #[inline(always)]
    fn add_product<V: Lanes>(
        &self,
        sum: &Square<V, D>,
        x: &Square<V, D>,
        y: &Square<V, D>,
        minus: bool,
    ) -> Square<V, D> {
        let mut product = *sum;
        for r in 0..self.0.rows.min(D) {
            for l in 0..self.0.rows.min(D) {
                let factor = if minus { -x[r][l] } else { x[r][l] };
                for c in 0..D {
                    product[r][c] = factor.mul_add(y[l][c], product[r][c]);
                }
            }
        }
        product
    }

    /// S + F Xᵀ, or S − F Xᵀ, with the rows of X that are not 0.
    #[inline(always)]
    fn add_behind<V: Lanes>(
        &self,
        sum: &Square<V, D>,
        f: &Square<V, D>,
        x: &Square<V, D>,
        minus: bool,
    ) -> Square<V, D> {
        let mut product = *sum;
        for c in 0..self.0.rows.min(D) {
            for l in 0..D {
                let factor = if minus { -x[c][l] } else { x[c][l] };
                for r in 0..D {
                    product[r][c] = factor.mul_add(f[r][l], product[r][c]);
                }
            }
        }
        product
    }

    /// S + Xᵀ F, with the rows of both that are not 0.
    #[inline(always)]
    fn add_before<V: Lanes>(&self, sum: &Square<V, D>, x: &Square<V, D>, f: &Square<V, D>) -> Square<V, D> {
        let mut product = *sum;
        for m in 0..self.0.rows.min(D) {
            for r in 0..self.0.rows.min(D) {
                for c in 0..D {
                    product[r][c] = x[m][r].mul_add(f[m][c], product[r][c]);
                }
            }
        }
        product
    }

    /// (1 − Y)⁻¹, or (1 + Y)⁻¹: by elimination without pivots, which no matrix near 1, and none with a skew Y, needs.
    #[inline(always)]
    fn inverse<V: Lanes>(&self, y: &Square<V, D>, minus: bool) -> Square<V, D> {
        let one = y[0][0].constant(1.0);
        let mut m: Square<V, D> = each!(D, r => each!(D, c => if minus { -y[r][c] } else { y[r][c] }));
        for r in 0..D {
            m[r][r] = m[r][r] + one;
        }
        // In place: a column of M⁻¹ replaces one of M.
        for k in 0..self.0.rows.min(D) {
            let pivot = one / m[k][k];
            m[k][k] = one;
            for c in 0..D {
                m[k][c] = m[k][c] * pivot;
            }
            for r in 0..self.0.rows.min(D) {
                if r != k {
                    let factor = m[r][k];
                    m[r][k] = one.constant(0.0);
                    for c in 0..D {
                        m[r][c] = factor.neg_mul_add(m[k][c], m[r][c]);
                    }
                }
            }
        }
        // The columns past the rows have been solved for as right-hand sides: M⁻¹ = (A, −A M₁₂; 0, 1).
        for r in 0..self.0.rows.min(D) {
            for c in self.0.rows.min(D)..D {
                m[r][c] = -m[r][c];
            }
        }
        m
    }
}

/// Ŷ, (1 − Y)⁻¹ and (1 + Y)⁻¹; Y alone, where no more was asked for.
#[derive(Clone, Copy, Debug)]
#[doc(hidden)]
pub struct At<V, const D: usize> {
    y: Square<V, D>,
    a: Square<V, D>,
    b: Square<V, D>,
}

impl<const N: usize, const D: usize> LaneGroup<N, D> for MatricesInLanes<N, D> {
    const HALVED: bool = true;

    type At<V: Lanes> = At<V, D>;

    #[inline(always)]
    fn add_coad<V: Lanes>(&self, mut sum: [V; N], m: [V; N], eta: [V; N]) -> [V; N] {
        for &Entry { at: [a, b, c], value } in &self.0.constants {
            let scaled = sum[0].constant(value) * eta[a as usize];
            sum[b as usize] = scaled.mul_add(m[c as usize], sum[b as usize]);
        }
        sum
    }

    #[inline(always)]
    fn at<V: Lanes>(&self, x: [V; N], whole: bool) -> At<V, D> {
        let y = self.hat(x);
        if whole { At { y, a: self.inverse(&y, true), b: self.inverse(&y, false) } } else { At { y, a: y, b: y } }
    }

    /// (1 + Y)ᵀ F (1 − Y)ᵀ.
    #[inline(always)]
    fn unpull<V: Lanes>(&self, At { y, .. }: At<V, D>, _: [V; N], p: [V; N]) -> [V; N] {
        let f = self.covector(p);
        let behind = self.add_behind(&f, &f, &y, true);
        self.against(&self.add_before(&behind, &y, &behind))
    }

    /// (1 + Y) U (1 − Y).
    #[inline(always)]
    fn rate<V: Lanes>(&self, At { y, .. }: At<V, D>, _: [V; N], eta: [V; N]) -> [V; N] {
        let u = self.hat(eta);
        let left = self.add_product(&u, &y, &u, false);
        self.vee(&self.add_product(&left, &left, &y, true))
    }

    /// Bᵀ F Aᵀ.
    #[inline(always)]
    fn pull<V: Lanes>(&self, at: At<V, D>, _: [V; N], f: [V; N]) -> [V; N] {
        let zero = [[f[0].constant(0.0); D]; D];
        let f = self.covector(f);
        // The rows at the bottom of A are those of 1.
        let mut start = zero;
        for r in 0..D {
            for c in self.0.rows.min(D)..D {
                start[r][c] = f[r][c];
            }
        }
        let behind = self.add_behind(&start, &f, &at.a, false);
        self.against(&self.add_before(&zero, &at.b, &behind))
    }

    /// Z'ᵀ(F + F Zᵀ) + F Zᵀ, Z = τ − 1 = 2AY, Z' = τ⁻¹ − 1 = −2BY.
    #[inline(always)]
    fn turned<V: Lanes>(&self, at: At<V, D>, _: [V; N], f: [V; N]) -> [V; N] {
        let zero = [[f[0].constant(0.0); D]; D];
        let two = each!(D, r => each!(D, c => at.y[r][c] + at.y[r][c]));
        let ahead = self.add_product(&zero, &at.a, &two, false);
        let back = self.add_product(&zero, &at.b, &two, true);
        let f = self.covector(f);
        let behind = self.add_behind(&zero, &f, &ahead, false);
        let sum = each!(D, r => each!(D, c => f[r][c] + behind[r][c]));
        self.against(&self.add_before(&behind, &back, &sum))
    }

    /// RᵀP − P Qᵀ, R = (1 + Y) U, Q = U (1 − Y), U half of η: ½ p \[η, δ\] + ¼ p (x η δ + δ η x).
    #[inline(always)]
    fn pull_dd<V: Lanes>(
        &self,
        At { y, .. }: At<V, D>,
        _: [V; N],
        p: [V; N],
        _m: [V; N],
        eta: [V; N],
        _y: [V; N],
    ) -> [V; N] {
        let half = eta[0].constant(0.5);
        let u = self.hat(each!(N, k => half * eta[k]));
        let left = self.add_product(&u, &y, &u, false);
        let right = self.add_product(&u, &u, &y, true);
        let zero = [[half.constant(0.0); D]; D];
        let p = self.covector(p);
        let behind = self.add_behind(&zero, &p, &right, true);
        self.against(&self.add_before(&behind, &left, &p))
    }

    /// 2 v A − v.
    #[inline(always)]
    fn moved<V: Lanes>(&self, at: At<V, D>, _: [V; N], row: [V; D]) -> [V; D] {
        let mut sum = each!(D, c => -row[c]);
        for l in 0..D {
            let twice = row[l] + row[l];
            for c in 0..D {
                sum[c] = twice.mul_add(at.a[l][c], sum[c]);
            }
        }
        sum
    }

    /// −2 v Y B.
    #[inline(always)]
    fn moved_back<V: Lanes>(&self, at: At<V, D>, _: [V; N], row: [V; D]) -> [V; D] {
        let minus_two = row[0].constant(-2.0);
        let (mut once, mut twice) = ([row[0].constant(0.0); D], [row[0].constant(0.0); D]);
        for l in 0..D {
            for c in 0..D {
                once[c] = row[l].mul_add(at.y[l][c], once[c]);
            }
        }
        for l in 0..D {
            for c in 0..D {
                twice[c] = once[l].mul_add(at.b[l][c], twice[c]);
            }
        }
        each!(D, c => minus_two * twice[c])
    }

    /// tanh(σ/2), to σ⁵.
    #[inline(always)]
    fn displacement<V: Lanes>(&self, t: V, first: [V; N], middle: [V; N], last: [V; N]) -> [V; N] {
        let (four, twelfth) = (t.constant(4.0), t * t.constant(1.0 / 12.0));
        let half = each!(N, k => twelfth * four.mul_add(middle[k], first[k] + last[k]));
        let turn = each!(N, k => twelfth * (last[k] - first[k]));
        let mut s = half;
        for &Entry { at: [a, b, c], value } in &self.0.constants {
            let scaled = t.constant(value) * half[a as usize];
            s[c as usize] = scaled.mul_add(turn[b as usize], s[c as usize]);
        }
        let (hat, zero) = (self.hat(s), [[t.constant(0.0); D]; D]);
        let square = self.add_product(&zero, &hat, &hat, false);
        // s + s³ (−1/3 + 2/15 s²).
        let (third, less) = (t.constant(-1.0 / 3.0), t.constant(2.0 / 15.0));
        let factor = each!(D, r => each!(D, c => {
            let square = less * square[r][c];
            if r == c { square + third } else { square }
        }));
        let cube = self.add_product(&zero, &square, &hat, false);
        self.vee(&self.add_product(&hat, &factor, &cube, false))
    }

    /// A bound of ‖Y‖.
    #[inline(always)]
    fn distance<V: Lanes>(&self, _: At<V, D>, x: [V; N]) -> V {
        let mut sum = x[0].constant(0.0);
        for k in 0..N {
            sum = x[0].constant(self.0.sizes[k]).mul_add(x[k].abs(), sum);
        }
        sum
    }

    /// No real eigenvalue of Y is 1 or more; of skew matrices none is real.
    fn in_domain(&self, distance: f64) -> bool {
        distance < if self.0.complete { 1e8 } else { 1.0 }
    }

    fn turning(&self, eta: [f64; N]) -> f64 {
        let mut matrix = Matrix::<f64, D>::zeros();
        for &Entry { at: [a, r, c], value } in &self.0.hat {
            matrix[(r as usize, c as usize)] += value * eta[a as usize];
        }
        (0.5 * matrix.component_mul(&matrix.transpose()).sum().abs()).sqrt()
    }

    fn rotation(&self) -> usize {
        self.0.rotation
    }
}

impl<const N: usize, const D: usize, G: LieGroup<f64, N, D> + Clone> FastRetraction<N, D> for Cayley<f64, N, D, G> {
    type Lanes = MatricesInLanes<N, D>;

    fn in_lanes(&self) -> MatricesInLanes<N, D> {
        MatricesInLanes(Arc::new(Basis::of(self.group())))
    }
}
