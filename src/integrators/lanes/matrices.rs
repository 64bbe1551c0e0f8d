//! The Cayley map of a matrix group in lanes, by its basis matrices.

use super::group::{FastRetraction, LaneGroup};
use super::{Lanes, One};
use crate::algebra::{Matrix, Vector};
use crate::group::LieGroup;
use crate::retraction::Cayley;
use std::sync::Arc;

/// The largest matrices whose products are written out: those of SO(4) take a hundred kilobytes of code, and larger ones would take several times as
/// much.
const MOST_UNROLLED: usize = 4;

/// A matrix in lanes, by rows.
type Square<V, const D: usize> = [[V; D]; D];

/// The Cayley map of a group of D×D matrices of dimension N, in lanes.
///
/// With x = 2y, Y = ŷ, A = (1 − Y)⁻¹, B = (1 + Y)⁻¹: τ = 2A − 1 and τ⁻¹ = 2B − 1 = 1 − 2YB; dτ⁻¹η = (1 + Y) η̂ (1 − Y) and dτη = B η̂ A
/// (Bou-Rabee and Marsden 2009; Hairer, Lubich and Wanner 2006, §IV.8.3). A covector f is a matrix F with f(η) = ⟨F, η̂⟩ = Σ F_rc η̂_rc, so that
/// η̂ ↦ S η̂ T turns F into SᵀFTᵀ.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct MatricesInLanes<const N: usize, const D: usize>(Arc<Basis<N, D>>);

#[derive(Debug)]
struct Basis<const N: usize, const D: usize> {
    /// x̂: of each entry of the matrix, the coordinates.
    hat: Layers<D, D, 1>,
    /// The matrix of a covector, likewise.
    covector: Layers<D, D, 1>,
    /// x of x̂: of each coordinate, the entries.
    vee: Layers<N, 1, 2>,
    /// The covector of a matrix, likewise.
    against: Layers<N, 1, 2>,
    /// ad*_η m: of each component the c of m and the a of η in Σ C^c_ab η^a m_c.
    coad: Layers<N, 1, 2>,
    /// \[x, y\]: of each coordinate those of x and of y.
    bracket: Layers<N, 1, 2>,
    /// D.
    size: usize,
    /// Whether all basis matrices are skew: B = Aᵀ.
    skew: bool,
    rotation: usize,
    /// Whether no displacement leaves the domain.
    complete: bool,
}

/// Sums with few terms, an R×C table of them, layer by layer: a factor, and of which I numbers it is one.
///
/// Where a result goes is known when this is compiled, and so stays in registers; where its terms come from need not be.
#[derive(Debug)]
struct Layers<const R: usize, const C: usize, const I: usize>(Vec<Layer<R, C, I>>);

/// One term of each sum.
type Layer<const R: usize, const C: usize, const I: usize> = [[(f64, [u8; I]); C]; R];

impl<const R: usize, const C: usize, const I: usize> Layers<R, C, I> {
    fn of(terms: impl Iterator<Item = ([usize; 2], f64, [usize; I])>) -> Self {
        let mut layers: Vec<Layer<R, C, I>> = Vec::new();
        for ([r, c], factor, from) in terms.filter(|term| term.1 != 0.0) {
            let free = layers.iter().position(|layer| layer[r][c].0 == 0.0).unwrap_or_else(|| {
                layers.push([[(0.0, [0; I]); C]; R]);
                layers.len() - 1
            });
            layers[free][r][c] = (factor, from.map(|k| k as u8));
        }
        Self(layers)
    }
}

impl<const N: usize, const D: usize> Basis<N, D> {
    fn of(group: &impl LieGroup<f64, N, D>) -> Self {
        let unit = |a: usize| Vector::<f64, N>::from_fn(|b, _| if a == b { 1.0 } else { 0.0 });
        let basis: [Matrix<f64, D>; N] = std::array::from_fn(|a| group.hat(&unit(a)));
        let places = || (0..D).flat_map(|r| (0..D).map(move |c| (r, c)));
        let entries: Vec<_> = (0..N).flat_map(|a| places().map(move |(r, c)| (a, r, c))).collect();
        // A matrix of the algebra is known by entries that are 0 in all other basis matrices, where each has one.
        let own = |a: usize| {
            places().find(|&(r, c)| basis[a][(r, c)] != 0.0 && (0..N).all(|b| a == b || basis[b][(r, c)] == 0.0))
        };
        let coordinates: Vec<(usize, usize, usize, f64)> = match (0..N).map(own).collect::<Option<Vec<_>>>() {
            Some(own) => own.iter().enumerate().map(|(a, &(r, c))| (a, r, c, 1.0 / basis[a][(r, c)])).collect(),
            None => entries
                .iter()
                .map(|&(a, r, c)| {
                    let one = Matrix::<f64, D>::from_fn(|i, j| if (i, j) == (r, c) { 1.0 } else { 0.0 });
                    (a, r, c, group.vee(&one)[a])
                })
                .collect(),
        };
        let triples = || (0..N * N * N).map(|k| [k / (N * N), k / N % N, k % N]);
        let constant = |[a, b, c]: [usize; 3]| group.algebra().constant(a, b, c);
        // A leading block of skew matrices, with nothing below it; and whether the rest of the matrices is nilpotent.
        let is_skew = |n: usize| {
            let block = |e: &Matrix<f64, D>| (0..n).all(|r| (0..n).all(|c| e[(r, c)] == -e[(c, r)]));
            basis.iter().all(|e| block(e) && (n..D).all(|r| (0..n).all(|c| e[(r, c)] == 0.0)))
        };
        let moves = |n: usize| basis.iter().any(|e| (0..n).any(|c| e[(n - 1, c)] != 0.0));
        let rotation = (2..=D).rev().find(|&n| is_skew(n) && moves(n)).unwrap_or(0);
        let complete = basis.iter().all(|e| (rotation..D).all(|r| (rotation..=r).all(|c| e[(r, c)] == 0.0)));
        Self {
            hat: Layers::of(entries.iter().map(|&(a, r, c)| ([r, c], basis[a][(r, c)], [a]))),
            covector: Layers::of(coordinates.iter().map(|&(a, r, c, value)| ([r, c], value, [a]))),
            vee: Layers::of(coordinates.iter().map(|&(a, r, c, value)| ([a, 0], value, [r, c]))),
            against: Layers::of(entries.iter().map(|&(a, r, c)| ([a, 0], basis[a][(r, c)], [r, c]))),
            coad: Layers::of(triples().map(|[a, b, c]| ([b, 0], constant([a, b, c]), [c, a]))),
            bracket: Layers::of(triples().map(|[a, b, c]| ([c, 0], constant([a, b, c]), [a, b]))),
            size: D,
            skew: rotation == D,
            rotation,
            complete,
        }
    }
}

impl<const N: usize, const D: usize> MatricesInLanes<N, D> {
    /// The matrix with these entries.
    #[inline(always)]
    fn matrix<V: Lanes>(&self, layers: &Layers<D, D, 1>, x: [V; N]) -> Square<V, D> {
        let mut matrix = [[x[0].constant(0.0); D]; D];
        for layer in &layers.0 {
            for r in 0..self.size() {
                for c in 0..self.size() {
                    let (factor, [a]) = layer[r][c];
                    matrix[r][c] = x[0].constant(factor).mul_add(x[a as usize], matrix[r][c]);
                }
            }
        }
        matrix
    }

    /// x̂.
    #[inline(always)]
    fn hat<V: Lanes>(&self, x: [V; N]) -> Square<V, D> {
        self.matrix(&self.0.hat, x)
    }

    /// The matrix of a covector.
    #[inline(always)]
    fn covector<V: Lanes>(&self, f: [V; N]) -> Square<V, D> {
        self.matrix(&self.0.covector, f)
    }

    /// The numbers that a matrix has these sums of.
    #[inline(always)]
    fn numbers<V: Lanes>(layers: &Layers<N, 1, 2>, matrix: &Square<V, D>) -> [V; N] {
        let zero = matrix[0][0].constant(0.0);
        let mut x = [zero; N];
        for layer in &layers.0 {
            for a in 0..N {
                let (factor, [r, c]) = layer[a][0];
                x[a] = zero.constant(factor).mul_add(matrix[r as usize][c as usize], x[a]);
            }
        }
        x
    }

    /// The coordinates of a matrix of the algebra.
    #[inline(always)]
    fn vee<V: Lanes>(&self, matrix: &Square<V, D>) -> [V; N] {
        Self::numbers(&self.0.vee, matrix)
    }

    /// The covector of a matrix: η ↦ ⟨F, η̂⟩.
    #[inline(always)]
    fn against<V: Lanes>(&self, matrix: &Square<V, D>) -> [V; N] {
        Self::numbers(&self.0.against, matrix)
    }

    /// sum + what is bilinear.
    #[inline(always)]
    fn products<V: Lanes>(layers: &Layers<N, 1, 2>, mut sum: [V; N], x: [V; N], y: [V; N]) -> [V; N] {
        for layer in &layers.0 {
            for a in 0..N {
                let (factor, [i, j]) = layer[a][0];
                sum[a] = (x[0].constant(factor) * x[i as usize]).mul_add(y[j as usize], sum[a]);
            }
        }
        sum
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
        for k in 0..self.size() {
            let pivot = m[k][k].reciprocal();
            m[k][k] = one;
            for c in 0..self.size() {
                m[k][c] = m[k][c] * pivot;
            }
            for r in 0..self.size() {
                if r != k {
                    let factor = m[r][k];
                    m[r][k] = one.constant(0.0);
                    for c in 0..self.size() {
                        m[r][c] = factor.neg_mul_add(m[k][c], m[r][c]);
                    }
                }
            }
        }
        m
    }
}

/// A matrix of sums Σ_l x y, an entry after the other: that needs no copy of what a sum starts from.
macro_rules! sums {
    ($self:ident, $like:ident, [$r:ident, $c:ident, $l:ident] $start:expr, $operation:ident $x:expr, $y:expr) => {{
        let mut out = [[$like[0][0].constant(0.0); D]; D];
        for $r in 0..$self.size() {
            for $c in 0..$self.size() {
                let mut sum = $start;
                for $l in 0..$self.size() {
                    sum = $x.$operation($y, sum);
                }
                out[$r][$c] = sum;
            }
        }
        out
    }};
}

impl<const N: usize, const D: usize> MatricesInLanes<N, D> {
    /// D; where matrices are large, so that it is not known when a kernel is compiled, which would be long without loops.
    #[inline(always)]
    fn size(&self) -> usize {
        if D > MOST_UNROLLED { self.0.size.min(D) } else { D }
    }

    /// X Y.
    #[inline(always)]
    fn product<V: Lanes>(&self, x: &Square<V, D>, y: &Square<V, D>) -> Square<V, D> {
        sums!(self, x, [r, c, l] x[0][0].constant(0.0), mul_add x[r][l], y[l][c])
    }

    /// S + X Y.
    #[inline(always)]
    fn add_product<V: Lanes>(&self, s: &Square<V, D>, x: &Square<V, D>, y: &Square<V, D>) -> Square<V, D> {
        sums!(self, x, [r, c, l] s[r][c], mul_add x[r][l], y[l][c])
    }

    /// S − X Y.
    #[inline(always)]
    fn less_product<V: Lanes>(&self, s: &Square<V, D>, x: &Square<V, D>, y: &Square<V, D>) -> Square<V, D> {
        sums!(self, x, [r, c, l] s[r][c], neg_mul_add x[r][l], y[l][c])
    }

    /// X Yᵀ.
    #[inline(always)]
    fn behind<V: Lanes>(&self, x: &Square<V, D>, y: &Square<V, D>) -> Square<V, D> {
        sums!(self, x, [r, c, l] x[0][0].constant(0.0), mul_add x[r][l], y[c][l])
    }

    /// S − X Yᵀ.
    #[inline(always)]
    fn less_behind<V: Lanes>(&self, s: &Square<V, D>, x: &Square<V, D>, y: &Square<V, D>) -> Square<V, D> {
        sums!(self, x, [r, c, l] s[r][c], neg_mul_add x[r][l], y[c][l])
    }

    /// Xᵀ Y.
    #[inline(always)]
    fn before<V: Lanes>(&self, x: &Square<V, D>, y: &Square<V, D>) -> Square<V, D> {
        sums!(self, x, [r, c, l] x[0][0].constant(0.0), mul_add x[l][r], y[l][c])
    }

    /// S + Xᵀ Y.
    #[inline(always)]
    fn add_before<V: Lanes>(&self, s: &Square<V, D>, x: &Square<V, D>, y: &Square<V, D>) -> Square<V, D> {
        sums!(self, x, [r, c, l] s[r][c], mul_add x[l][r], y[l][c])
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
    fn add_coad<V: Lanes>(&self, sum: [V; N], m: [V; N], eta: [V; N]) -> [V; N] {
        Self::products(&self.0.coad, sum, m, eta)
    }

    #[inline(always)]
    fn at<V: Lanes>(&self, x: [V; N], whole: bool) -> At<V, D> {
        let y = self.hat(x);
        if !whole {
            return At { y, a: y, b: y };
        }
        let a = self.inverse(&y, true);
        let b = if self.0.skew { each!(D, r => each!(D, c => a[c][r])) } else { self.inverse(&y, false) };
        At { y, a, b }
    }

    /// (1 + Y)ᵀ F (1 − Y)ᵀ.
    #[inline(always)]
    fn unpull<V: Lanes>(&self, at: &At<V, D>, _: [V; N], p: [V; N]) -> [V; N] {
        let f = self.covector(p);
        let behind = self.less_behind(&f, &f, &at.y);
        self.against(&self.add_before(&behind, &at.y, &behind))
    }

    /// (1 + Y) U (1 − Y).
    #[inline(always)]
    fn rate<V: Lanes>(&self, at: &At<V, D>, _: [V; N], eta: [V; N]) -> [V; N] {
        let u = self.hat(eta);
        let left = self.add_product(&u, &at.y, &u);
        self.vee(&self.less_product(&left, &left, &at.y))
    }

    /// Bᵀ F Aᵀ.
    #[inline(always)]
    fn pull<V: Lanes>(&self, at: &At<V, D>, _: [V; N], f: [V; N]) -> [V; N] {
        self.against(&self.before(&at.b, &self.behind(&self.covector(f), &at.a)))
    }

    /// −ad*_x (f dτ_x): (1 + Y)(τ⁻¹ η̂ τ − η̂)(1 − Y) = −2 (Y η̂ − η̂ Y).
    #[inline(always)]
    fn turned<V: Lanes>(&self, at: &At<V, D>, x: [V; N], f: [V; N]) -> [V; N] {
        let minus_two = f[0].constant(-2.0);
        self.coad(self.pull(at, x, f), each!(N, k => minus_two * x[k]))
    }

    #[inline(always)]
    fn pull_dd<V: Lanes>(&self, at: &At<V, D>, x: [V; N], p: [V; N], m: [V; N], eta: [V; N], _y: [V; N]) -> [V; N] {
        let half = eta[0].constant(0.5);
        self.stage(at, x, [p, m], [eta, each!(N, k => half * eta[k])], None)[1]
    }

    /// With U half of η, R = (1 + Y) U, Q = U (1 − Y): R (1 − Y), and RᵀP − P Qᵀ + BᵀFAᵀ. The first terms are ½ p \[η, δ\] + ¼ p (x η δ + δ η x).
    #[inline(always)]
    fn stage<V: Lanes>(
        &self,
        at: &At<V, D>,
        _: [V; N],
        [p, _]: [[V; N]; 2],
        [_, half]: [[V; N]; 2],
        force: Option<[V; N]>,
    ) -> [[V; N]; 2] {
        let (u, p) = (self.hat(half), self.covector(p));
        let left = self.add_product(&u, &at.y, &u);
        let rate = self.vee(&self.less_product(&left, &left, &at.y));
        let mut sum = self.less_behind(&self.before(&left, &p), &p, &self.less_product(&u, &u, &at.y));
        if let Some(force) = force {
            sum = self.add_before(&sum, &at.b, &self.behind(&self.covector(force), &at.a));
        }
        [rate, self.against(&sum)]
    }

    /// 2 v A − v.
    #[inline(always)]
    fn moved<V: Lanes>(&self, at: &At<V, D>, _: [V; N], row: [V; D]) -> [V; D] {
        let mut sum = each!(D, c => -row[c]);
        for l in 0..self.size() {
            let twice = row[l] + row[l];
            for c in 0..self.size() {
                sum[c] = twice.mul_add(at.a[l][c], sum[c]);
            }
        }
        sum
    }

    /// −2 v Y B.
    #[inline(always)]
    fn moved_back<V: Lanes>(&self, at: &At<V, D>, _: [V; N], row: [V; D]) -> [V; D] {
        let minus_two = row[0].constant(-2.0);
        let (mut once, mut twice) = ([row[0].constant(0.0); D], [row[0].constant(0.0); D]);
        for l in 0..self.size() {
            for c in 0..self.size() {
                once[c] = row[l].mul_add(at.y[l][c], once[c]);
            }
        }
        for l in 0..self.size() {
            for c in 0..self.size() {
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
        let s = Self::products(&self.0.bracket, half, half, turn);
        let hat = self.hat(s);
        let square = self.product(&hat, &hat);
        // s + (−1/3 + 2/15 s²) s³.
        let (third, less) = (t.constant(-1.0 / 3.0), t.constant(2.0 / 15.0));
        let factor = each!(D, r => each!(D, c => {
            let square = less * square[r][c];
            if r == c { square + third } else { square }
        }));
        self.vee(&self.add_product(&hat, &factor, &self.product(&square, &hat)))
    }

    /// ‖Y²‖, by the sums of rows: no eigenvalue of Y is larger than its root.
    #[inline(always)]
    fn distance<V: Lanes>(&self, at: &At<V, D>, x: [V; N]) -> V {
        let mut largest = x[0] * x[0];
        if self.0.complete {
            for k in 1..N {
                largest = largest.max(x[k] * x[k]);
            }
            return largest;
        }
        let square = self.product(&at.y, &at.y);
        for r in 0..D {
            let mut sum = square[r][0].abs();
            for c in 1..D {
                sum = sum + square[r][c].abs();
            }
            largest = if r == 0 { sum } else { largest.max(sum) };
        }
        largest
    }

    /// No real eigenvalue of Y is 1 or more; of skew matrices none is real.
    fn in_domain(&self, distance: f64) -> bool {
        distance < if self.0.complete { 1e16 } else { 1.0 }
    }

    fn turning(&self, eta: [f64; N]) -> f64 {
        let matrix = self.hat(eta.map(One));
        let trace = (0..D * D).fold(0.0, |sum, k| sum + matrix[k / D][k % D].0 * matrix[k % D][k / D].0);
        (0.5 * trace.abs()).sqrt()
    }

    fn rotation(&self) -> usize {
        self.0.rotation
    }
}

impl<const N: usize, const D: usize, G: LieGroup<f64, N, D> + Clone> FastRetraction<N, D> for Cayley<f64, N, D, G> {
    type Lanes = MatricesInLanes<N, D>;
    type Steady = Self;

    fn in_lanes(&self) -> MatricesInLanes<N, D> {
        MatricesInLanes(Arc::new(Basis::of(self.group())))
    }
}
