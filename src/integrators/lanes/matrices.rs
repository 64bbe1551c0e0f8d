//! The Cayley map of a matrix group in lanes, by its basis matrices.

use super::group::{FastRetraction, LaneGroup};
use super::{Lanes, One};
use crate::algebra::{Matrix, Vector};
use crate::group::LieGroup;
use crate::retraction::Cayley;
use std::marker::PhantomData;
use std::sync::Arc;

/// The largest matrices whose products are written out, and the largest dimension of a group whose basis is known when this is compiled: those of SO(4)
/// take a hundred kilobytes of code, and larger ones would take several times as much.
const MOST_UNROLLED: usize = 4;
const MOST_KNOWN: usize = 6;

/// The most structure constants of such a group.
const MOST_CONSTANTS: usize = 32;

/// A matrix in lanes, by rows.
type Square<V, const D: usize> = [[V; D]; D];

/// BODY for each of the numbers below `$limit`, each a constant of its own: what depends on it alone is decided when the body is compiled, and what is 0 leaves no
/// code.
macro_rules! unrolled {
    ($k:ident in 0..4, below $limit:expr => $body:block) => { unrolled!(@ $k, $limit, $body, 0 1 2 3) };
    ($k:ident in 0..6, below $limit:expr => $body:block) => { unrolled!(@ $k, $limit, $body, 0 1 2 3 4 5) };
    ($k:ident in 0..32, below $limit:expr => $body:block) => {
        unrolled!(@ $k, $limit, $body, 0 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31)
    };
    (@ $k:ident, $limit:expr, $body:block, $($n:literal)*) => {$({
        const $k: usize = $n;
        if const { $n < $limit } $body
    })*};
}

/// Which entries of a matrix may be other than 0, where the basis is known.
mod pattern {
    /// All.
    pub const DENSE: u8 = 0;
    /// Those of x̂.
    pub const HAT: u8 = 1;
    /// Those of the matrix of a covector.
    pub const COVECTOR: u8 = 2;
    /// Those of x̂ + ŷ ẑ.
    pub const PRODUCT: u8 = 3;
    /// The rows of [`COVECTOR`].
    pub const ROWS: u8 = 4;
    /// None.
    pub const NONE: u8 = 5;
    /// Added to that of a factor that is transposed.
    pub const TURNED: u8 = 128;
}
use pattern::{COVECTOR, DENSE, HAT, NONE, PRODUCT, ROWS, TURNED};

/// The sign of a product that is added.
const PLUS: bool = true;
const MINUS: bool = false;

/// The Cayley map of a group of D×D matrices of dimension N, in lanes.
///
/// With x = 2y, Y = ŷ, A = (1 − Y)⁻¹, B = (1 + Y)⁻¹: τ = 2A − 1 and τ⁻¹ = 2B − 1 = 1 − 2YB; dτ⁻¹η = (1 + Y) η̂ (1 − Y) and dτη = B η̂ A
/// (Bou-Rabee and Marsden 2009; Hairer, Lubich and Wanner 2006, §IV.8.3). A covector f is a matrix F with f(η) = ⟨F, η̂⟩ = Σ F_rc η̂_rc, so that
/// η̂ ↦ S η̂ T turns F into SᵀFTᵀ.
///
/// Of a group that has [`LieGroup::BASIS`] the products leave out what is 0; of others it is known when it is made.
#[doc(hidden)]
pub struct MatricesInLanes<G, const N: usize, const D: usize>(Arc<Basis<N, D>>, PhantomData<fn() -> G>);

impl<G, const N: usize, const D: usize> Clone for MatricesInLanes<G, N, D> {
    fn clone(&self) -> Self {
        Self(self.0.clone(), PhantomData)
    }
}

impl<G, const N: usize, const D: usize> std::fmt::Debug for MatricesInLanes<G, N, D> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.fmt(f)
    }
}

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

/// What follows from a basis that is known, with zeros up to the largest sizes.
impl<G: LieGroup<f64, N, D>, const N: usize, const D: usize> MatricesInLanes<G, N, D> {
    /// ê_a.
    const BASIS: [[[f64; MOST_UNROLLED]; MOST_UNROLLED]; MOST_KNOWN] = {
        let mut basis = [[[0.0; MOST_UNROLLED]; MOST_UNROLLED]; MOST_KNOWN];
        if let Some(known) = G::BASIS {
            let mut k = 0;
            while k < N * D * D && N <= MOST_KNOWN && D <= MOST_UNROLLED {
                let (a, r, c) = (k / (D * D), k / D % D, k % D);
                basis[a][r][c] = known[a][r][c] as f64;
                k += 1;
            }
        }
        basis
    };

    /// Of each coordinate an entry that only ê_a has, and 1 over it; 0 where there is none.
    const OWN: [(usize, usize, f64); MOST_KNOWN] = {
        let mut own = [(0, 0, 0.0); MOST_KNOWN];
        let mut k = 0;
        while k < N * D * D && N <= MOST_KNOWN && D <= MOST_UNROLLED {
            let (a, r, c) = (k / (D * D), k / D % D, k % D);
            let (mut alone, mut b) = (Self::BASIS[a][r][c] != 0.0, 0);
            while b < N {
                alone = alone && (b == a || Self::BASIS[b][r][c] == 0.0);
                b += 1;
            }
            // One that is 1 needs no product.
            if alone && own[a].2 != 1.0 {
                own[a] = (r, c, 1.0 / Self::BASIS[a][r][c]);
            }
            k += 1;
        }
        own
    };

    /// C^c_ab other than 0: a, b, c and the number; then zeros. And how many.
    const CONSTANTS: ([(usize, usize, usize, f64); MOST_CONSTANTS], usize) = {
        let (mut constants, mut found, mut k) = ([(0, 0, 0, 0.0); MOST_CONSTANTS], 0, 0);
        while k < N * N * N && N <= MOST_KNOWN && D <= MOST_UNROLLED {
            let (a, b, c) = (k / (N * N), k / N % N, k % N);
            let (r, column, per) = Self::OWN[c];
            let (mut sum, mut l) = (0.0, 0);
            while l < D {
                sum += Self::BASIS[a][r][l] * Self::BASIS[b][l][column];
                sum -= Self::BASIS[b][r][l] * Self::BASIS[a][l][column];
                l += 1;
            }
            if sum != 0.0 {
                if found < MOST_CONSTANTS {
                    constants[found] = (a, b, c, sum * per);
                }
                found += 1;
            }
            k += 1;
        }
        (constants, found)
    };

    /// Whether the basis is known, and all of this follows from it.
    const KNOWN: bool = {
        let (mut known, mut a) = (G::BASIS.is_some() && N <= MOST_KNOWN && D <= MOST_UNROLLED, 0);
        while a < N && known {
            known = Self::OWN[a].2 != 0.0;
            a += 1;
        }
        known && Self::CONSTANTS.1 <= MOST_CONSTANTS
    };

    /// Whether the last row of x̂ is 0, and x̂ skew.
    const AFFINE: bool = Self::KNOWN && {
        let (mut affine, mut c) = (true, 0);
        while c < D {
            affine = affine && !Self::has(HAT, D - 1, c);
            c += 1;
        }
        affine
    };
    const SKEW: bool = Self::KNOWN && {
        let (mut skew, mut k) = (true, 0);
        while k < N * D * D {
            let (a, r, c) = (k / (D * D), k / D % D, k % D);
            skew = skew && Self::BASIS[a][r][c] == -Self::BASIS[a][c][r];
            k += 1;
        }
        skew
    };

    /// Whether a matrix with this pattern may have entry (r, c).
    const fn has(pattern: u8, r: usize, c: usize) -> bool {
        if r >= D || c >= D || pattern == NONE {
            return false;
        }
        if pattern == DENSE || !Self::KNOWN {
            return true;
        }
        let (mut found, mut k) = (false, 0);
        while k < N {
            found = found
                || match pattern {
                    COVECTOR => Self::OWN[k].0 == r && Self::OWN[k].1 == c,
                    ROWS => Self::OWN[k].0 == r,
                    _ => Self::BASIS[k][r][c] != 0.0,
                };
            k += 1;
        }
        let mut l = 0;
        while l < D && pattern == PRODUCT {
            found = found || (Self::has(HAT, r, l) && Self::has(HAT, l, c));
            l += 1;
        }
        found
    }
}

impl<G: LieGroup<f64, N, D>, const N: usize, const D: usize> MatricesInLanes<G, N, D> {
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
        if !Self::KNOWN {
            return self.matrix(&self.0.hat, x);
        }
        let mut matrix = [[x[0].constant(0.0); D]; D];
        unrolled!(R in 0..4, below D => { unrolled!(C in 0..4, below D => { unrolled!(A in 0..6, below N => {
            if const { Self::BASIS[A][R][C] != 0.0 } {
                matrix[R][C] = plus(const { Self::BASIS[A][R][C] }, x[A], matrix[R][C], const { Self::first(A, R, C) });
            }
        }); }); });
        matrix
    }

    /// Whether no ê_b before ê_a has entry (r, c); and the entry no term before it.
    const fn first(a: usize, r: usize, c: usize) -> bool {
        let (mut first, mut b) = (true, 0);
        while b < a {
            first = first && Self::BASIS[b][r][c] == 0.0;
            b += 1;
        }
        first
    }

    /// The matrix of a covector.
    #[inline(always)]
    fn covector<V: Lanes>(&self, f: [V; N]) -> Square<V, D> {
        if !Self::KNOWN {
            return self.matrix(&self.0.covector, f);
        }
        let mut matrix = [[f[0].constant(0.0); D]; D];
        unrolled!(A in 0..6, below N => {
            let (r, c, per) = const { Self::OWN[A] };
            matrix[r][c] = plus(per, f[A], matrix[r][c], true);
        });
        matrix
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
        if !Self::KNOWN {
            return Self::numbers(&self.0.vee, matrix);
        }
        let mut x = [matrix[0][0]; N];
        unrolled!(A in 0..6, below N => {
            let (r, c, per) = const { Self::OWN[A] };
            x[A] = plus(per, matrix[r][c], x[A], true);
        });
        x
    }

    /// The covector of a matrix: η ↦ ⟨F, η̂⟩.
    #[inline(always)]
    fn against<V: Lanes>(&self, matrix: &Square<V, D>) -> [V; N] {
        if !Self::KNOWN {
            return Self::numbers(&self.0.against, matrix);
        }
        let mut f = [matrix[0][0].constant(0.0); N];
        unrolled!(A in 0..6, below N => { unrolled!(R in 0..4, below D => { unrolled!(C in 0..4, below D => {
            if const { Self::BASIS[A][R][C] != 0.0 } {
                f[A] = plus(const { Self::BASIS[A][R][C] }, matrix[R][C], f[A], false);
            }
        }); }); });
        f
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

    /// sum + \[x, y\].
    #[inline(always)]
    fn add_bracket<V: Lanes>(&self, mut sum: [V; N], x: [V; N], y: [V; N]) -> [V; N] {
        if !Self::KNOWN {
            return Self::products(&self.0.bracket, sum, x, y);
        }
        unrolled!(K in 0..32, below Self::CONSTANTS.1 => {
            let (a, b, c, factor) = const { Self::CONSTANTS.0[K] };
            sum[c] = plus_product(factor, x[a], y[b], sum[c]);
        });
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
        // The last row is that of 1, and stays so.
        let size = if Self::AFFINE { D - 1 } else { self.size() };
        // In place: a column of M⁻¹ replaces one of M.
        for k in 0..size {
            let pivot = m[k][k].reciprocal();
            m[k][k] = one;
            for c in 0..self.size() {
                m[k][c] = m[k][c] * pivot;
            }
            for r in 0..size {
                if r != k {
                    let factor = m[r][k];
                    m[r][k] = one.constant(0.0);
                    for c in 0..self.size() {
                        m[r][c] = factor.neg_mul_add(m[k][c], m[r][c]);
                    }
                }
            }
        }
        if Self::AFFINE {
            for r in 0..D - 1 {
                m[r][D - 1] = -m[r][D - 1];
            }
        }
        m
    }

    /// D; where matrices are large, so that it is not known when a kernel is compiled, which would be long without loops.
    #[inline(always)]
    fn size(&self) -> usize {
        if D > MOST_UNROLLED { self.0.size.min(D) } else { D }
    }

    /// Whether a factor, transposed or not, may have entry (r, c).
    const fn entry(factor: u8, r: usize, c: usize) -> bool {
        if factor >= TURNED { Self::has(factor - TURNED, c, r) } else { Self::has(factor, r, c) }
    }

    /// The entries of S ± X Y that `NEED` has, where S, X, Y have these patterns; X or Y are transposed where they are [`TURNED`].
    #[inline(always)]
    fn sum<const NEED: u8, const S: u8, const X: u8, const Y: u8, const SIGN: bool, V: Lanes>(
        &self,
        s: &Square<V, D>,
        x: &Square<V, D>,
        y: &Square<V, D>,
    ) -> Square<V, D> {
        let zero = x[0][0].constant(0.0);
        let mut out = [[zero; D]; D];
        if D > MOST_UNROLLED {
            for r in 0..self.size() {
                for c in 0..self.size() {
                    let mut sum = if S == NONE { zero } else { s[r][c] };
                    for l in 0..self.size() {
                        sum = term::<X, Y, SIGN, V, D>(x, y, [r, l, c], sum);
                    }
                    out[r][c] = sum;
                }
            }
            return out;
        }
        unrolled!(R in 0..4, below D => { unrolled!(C in 0..4, below D => { if const { Self::has(NEED, R, C) } {
            let mut sum = if const { Self::has(S, R, C) } { s[R][C] } else { zero };
            unrolled!(L in 0..4, below D => { if const { Self::entry(X, R, L) && Self::entry(Y, L, C) } {
                sum = term::<X, Y, SIGN, V, D>(x, y, [R, L, C], sum);
            } });
            out[R][C] = sum;
        } }); });
        out
    }
}

/// sum ± X_rl Y_lc.
#[inline(always)]
fn term<const X: u8, const Y: u8, const SIGN: bool, V: Lanes, const D: usize>(
    x: &Square<V, D>,
    y: &Square<V, D>,
    [r, l, c]: [usize; 3],
    sum: V,
) -> V {
    let (x, y) = (if X >= TURNED { x[l][r] } else { x[r][l] }, if Y >= TURNED { y[c][l] } else { y[l][c] });
    if SIGN == MINUS { x.neg_mul_add(y, sum) } else { x.mul_add(y, sum) }
}

/// factor x + sum, or without the sum where there is none yet.
#[inline(always)]
fn plus<V: Lanes>(factor: f64, x: V, sum: V, first: bool) -> V {
    match (first, factor) {
        (true, 1.0) => x,
        (true, -1.0) => -x,
        (true, _) => x.constant(factor) * x,
        (false, 1.0) => sum + x,
        (false, -1.0) => sum - x,
        (false, _) => x.constant(factor).mul_add(x, sum),
    }
}

/// factor x y + sum.
#[inline(always)]
fn plus_product<V: Lanes>(factor: f64, x: V, y: V, sum: V) -> V {
    match factor {
        1.0 => x.mul_add(y, sum),
        -1.0 => x.neg_mul_add(y, sum),
        _ => (x.constant(factor) * x).mul_add(y, sum),
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

impl<G: LieGroup<f64, N, D> + 'static, const N: usize, const D: usize> LaneGroup<N, D> for MatricesInLanes<G, N, D> {
    const HALVED: bool = true;

    type At<V: Lanes> = At<V, D>;

    #[inline(always)]
    fn add_coad<V: Lanes>(&self, mut sum: [V; N], m: [V; N], eta: [V; N]) -> [V; N] {
        if !Self::KNOWN {
            return Self::products(&self.0.coad, sum, m, eta);
        }
        unrolled!(K in 0..32, below Self::CONSTANTS.1 => {
            let (a, b, c, factor) = const { Self::CONSTANTS.0[K] };
            sum[b] = plus_product(factor, eta[a], m[c], sum[b]);
        });
        sum
    }

    #[inline(always)]
    fn at<V: Lanes>(&self, x: [V; N], whole: bool) -> At<V, D> {
        let y = self.hat(x);
        if !whole {
            return At { y, a: y, b: y };
        }
        let a = self.inverse(&y, true);
        let skew = if Self::KNOWN { Self::SKEW } else { self.0.skew };
        let b = if skew { each!(D, r => each!(D, c => a[c][r])) } else { self.inverse(&y, false) };
        At { y, a, b }
    }

    /// (1 + Y)ᵀ F (1 − Y)ᵀ.
    #[inline(always)]
    fn unpull<V: Lanes>(&self, At { y, .. }: &At<V, D>, _: [V; N], p: [V; N]) -> [V; N] {
        let f = self.covector(p);
        let behind = self.sum::<ROWS, COVECTOR, COVECTOR, { HAT + TURNED }, MINUS, V>(&f, &f, y);
        self.against(&self.sum::<HAT, ROWS, { HAT + TURNED }, ROWS, PLUS, V>(&behind, y, &behind))
    }

    /// (1 + Y) U (1 − Y).
    #[inline(always)]
    fn rate<V: Lanes>(&self, At { y, .. }: &At<V, D>, _: [V; N], eta: [V; N]) -> [V; N] {
        let u = self.hat(eta);
        let left = self.sum::<PRODUCT, HAT, HAT, HAT, PLUS, V>(&u, y, &u);
        self.vee(&self.sum::<COVECTOR, PRODUCT, PRODUCT, HAT, MINUS, V>(&left, &left, y))
    }

    /// Bᵀ F Aᵀ.
    #[inline(always)]
    fn pull<V: Lanes>(&self, At { a, b, .. }: &At<V, D>, _: [V; N], f: [V; N]) -> [V; N] {
        let behind = self.sum::<ROWS, NONE, COVECTOR, { DENSE + TURNED }, PLUS, V>(a, &self.covector(f), a);
        self.against(&self.sum::<HAT, NONE, { DENSE + TURNED }, ROWS, PLUS, V>(a, b, &behind))
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
        At { y, a, b }: &At<V, D>,
        _: [V; N],
        [p, _]: [[V; N]; 2],
        [_, half]: [[V; N]; 2],
        force: Option<[V; N]>,
    ) -> [[V; N]; 2] {
        let (u, p) = (self.hat(half), self.covector(p));
        let left = self.sum::<PRODUCT, HAT, HAT, HAT, PLUS, V>(&u, y, &u);
        let rate = self.vee(&self.sum::<COVECTOR, PRODUCT, PRODUCT, HAT, MINUS, V>(&left, &left, y));
        let right = self.sum::<PRODUCT, HAT, HAT, HAT, MINUS, V>(&u, &u, y);
        let sum = self.sum::<HAT, NONE, { PRODUCT + TURNED }, COVECTOR, PLUS, V>(y, &left, &p);
        let mut sum = self.sum::<HAT, HAT, COVECTOR, { PRODUCT + TURNED }, MINUS, V>(&sum, &p, &right);
        if let Some(force) = force {
            let behind = self.sum::<ROWS, NONE, COVECTOR, { DENSE + TURNED }, PLUS, V>(a, &self.covector(force), a);
            sum = self.sum::<HAT, HAT, { DENSE + TURNED }, ROWS, PLUS, V>(&sum, b, &behind);
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
        let s = self.add_bracket(half, half, turn);
        let hat = self.hat(s);
        let square = self.sum::<DENSE, NONE, HAT, HAT, PLUS, V>(&hat, &hat, &hat);
        // s + (−1/3 + 2/15 s²) s³.
        let (third, less) = (t.constant(-1.0 / 3.0), t.constant(2.0 / 15.0));
        let factor = each!(D, r => each!(D, c => {
            let square = less * square[r][c];
            if r == c { square + third } else { square }
        }));
        let cube = self.sum::<DENSE, NONE, DENSE, HAT, PLUS, V>(&hat, &square, &hat);
        self.vee(&self.sum::<COVECTOR, HAT, DENSE, DENSE, PLUS, V>(&hat, &factor, &cube))
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
        let square = self.sum::<DENSE, NONE, HAT, HAT, PLUS, V>(&at.y, &at.y, &at.y);
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

impl<G, const N: usize, const D: usize> FastRetraction<N, D> for Cayley<f64, N, D, G>
where
    G: LieGroup<f64, N, D> + Clone + 'static,
{
    type Lanes = MatricesInLanes<G, N, D>;
    type Steady = Self;

    fn in_lanes(&self) -> Self::Lanes {
        MatricesInLanes(Arc::new(Basis::of(self.group())), PhantomData)
    }
}
