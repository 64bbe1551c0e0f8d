//! The loops in which numbers of 32 and 64 digits, and dual numbers over them, spend their time: products of matrices and sums of
//! multiples, compiled once for a scalar, whatever the sizes.
//!
//! Everywhere else an operation on such numbers is a call. Here it is compiled where it stands, with the fused multiply-add of the
//! machine, so that operations that do not wait for each other overlap: several times faster, to the same bits.

use super::{Real, Scalar, finite, fused};

/// Whether a scalar is made of more than `f64`: then its operations are calls outside these loops.
pub(crate) const fn heavy<S: Scalar>() -> bool {
    size_of::<S::Base>() > size_of::<f64>()
}

/// y += x c, entry by entry.
#[inline(never)]
pub(crate) fn add_multiple<S: Scalar>(y: &mut [S], x: &[S], c: S) {
    fused::run(AddMultiple { y, x, c });
}

struct AddMultiple<'a, S> {
    y: &'a mut [S],
    x: &'a [S],
    c: S,
}

impl<S: Scalar> fused::Work for AddMultiple<'_, S> {
    #[inline(always)]
    fn run(self) {
        S::add_multiple(self.y, self.x, self.c);
    }
}

/// y += x c, entry by entry, for constants x of which many are 0.
#[inline(never)]
pub(crate) fn add_constants<S: Scalar>(y: &mut [S], x: &[S::Base], c: S) {
    // 0 × ∞ is NaN, and is to be seen.
    if !c.vanishes() {
        fused::run(AddConstants { y, x, c, all: !c.all_finite() });
    }
}

struct AddConstants<'a, S: Scalar> {
    y: &'a mut [S],
    x: &'a [S::Base],
    c: S,
    all: bool,
}

impl<S: Scalar> fused::Work for AddConstants<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self { y, x, c, all } = self;
        for i in 0..y.len().min(x.len()) {
            if all || !x[i].vanishes() {
                y[i] = y[i].plus(c.scaled(x[i]));
            }
        }
    }
}

/// C += A B, column by column; A has `rows` rows.
#[inline(never)]
pub(crate) fn add_product<S: Scalar>(c: &mut [S], a: &[S], b: &[S], rows: usize) {
    if rows > 0 && !a.is_empty() {
        fused::run(AddProduct { c, a, b, rows, all: !finite(a) });
    }
}

struct AddProduct<'a, S> {
    c: &'a mut [S],
    a: &'a [S],
    b: &'a [S],
    rows: usize,
    all: bool,
}

impl<S: Scalar> fused::Work for AddProduct<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self { c, a, b, rows, all } = self;
        let inner = a.len() / rows;
        for j in 0..c.len() / rows {
            let column = &mut c[j * rows..(j + 1) * rows];
            for k in 0..inner {
                let factor = b[j * inner + k];
                if all || !factor.vanishes() {
                    S::add_multiple(column, &a[k * rows..(k + 1) * rows], factor);
                }
            }
        }
    }
}

/// y += μ A, row by row of the square matrix A.
#[inline(never)]
pub(crate) fn add_pulled<S: Scalar>(y: &mut [S], mu: &[S], a: &[S]) {
    fused::run(AddPulled { y, mu, a, all: !finite(a) });
}

struct AddPulled<'a, S> {
    y: &'a mut [S],
    mu: &'a [S],
    a: &'a [S],
    all: bool,
}

impl<S: Scalar> fused::Work for AddPulled<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self { y, mu, a, all } = self;
        let rows = mu.len();
        for i in 0..rows {
            if all || !mu[i].vanishes() {
                for j in 0..y.len() {
                    y[j] = y[j].plus(mu[i].times(a[i + j * rows]));
                }
            }
        }
    }
}

/// Σ c_i x_i, for constants c of which many are 0.
#[inline(never)]
pub(crate) fn sum_of_multiples<S: Scalar>(x: &[S], c: &[S::Base]) -> S {
    let mut sum = S::zero();
    fused::run(SumOfMultiples { sum: &mut sum, x, c, all: !finite(x) });
    sum
}

struct SumOfMultiples<'a, S: Scalar> {
    sum: &'a mut S,
    x: &'a [S],
    c: &'a [S::Base],
    all: bool,
}

impl<S: Scalar> fused::Work for SumOfMultiples<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self { sum, x, c, all } = self;
        for i in 0..x.len().min(c.len()) {
            if all || !c[i].vanishes() {
                *sum = sum.plus(x[i].scaled(c[i]));
            }
        }
    }
}

/// z_c += C (x_a y_b − x_b y_a) over constants C with the places (a, b, c).
#[inline(never)]
pub(crate) fn add_brackets<T: Real>(z: &mut [T], constants: &[([usize; 3], T)], x: &[T], y: &[T]) {
    fused::run(AddBrackets { z, constants, x, y });
}

struct AddBrackets<'a, T> {
    z: &'a mut [T],
    constants: &'a [([usize; 3], T)],
    x: &'a [T],
    y: &'a [T],
}

impl<T: Real> fused::Work for AddBrackets<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self { z, constants, x, y } = self;
        for i in 0..constants.len() {
            let ([a, b, c], constant) = constants[i];
            z[c] = z[c].plus(constant.times(x[a].times(y[b]).minus(x[b].times(y[a]))));
        }
    }
}

/// ν_b += C μ_c x_a and ν_a −= C μ_c x_b over constants C with the places (a, b, c).
#[inline(never)]
pub(crate) fn add_coadjoint<T: Real>(nu: &mut [T], constants: &[([usize; 3], T)], x: &[T], mu: &[T]) {
    fused::run(AddCoadjoint { nu, constants, x, mu });
}

struct AddCoadjoint<'a, T> {
    nu: &'a mut [T],
    constants: &'a [([usize; 3], T)],
    x: &'a [T],
    mu: &'a [T],
}

impl<T: Real> fused::Work for AddCoadjoint<'_, T> {
    #[inline(always)]
    fn run(self) {
        let Self { nu, constants, x, mu } = self;
        for i in 0..constants.len() {
            let ([a, b, c], constant) = constants[i];
            let scaled = constant.times(mu[c]);
            nu[b] = nu[b].plus(scaled.times(x[a]));
            nu[a] = nu[a].minus(scaled.times(x[b]));
        }
    }
}

/// z_k += C x_i y_j over constants C, where `place` finds (i, j, k).
#[inline(never)]
pub(crate) fn add_trilinear<S: Scalar>(
    z: &mut [S],
    constants: &[([usize; 4], S::Base)],
    (x, y): (&[S], &[S]),
    place: impl Fn([usize; 4]) -> [usize; 3],
) {
    fused::run(AddTrilinear { z, constants, x, y, place });
}

struct AddTrilinear<'a, S: Scalar, P> {
    z: &'a mut [S],
    constants: &'a [([usize; 4], S::Base)],
    x: &'a [S],
    y: &'a [S],
    place: P,
}

impl<S: Scalar, P: Fn([usize; 4]) -> [usize; 3]> fused::Work for AddTrilinear<'_, S, P> {
    #[inline(always)]
    fn run(self) {
        let Self { z, constants, x, y, place } = self;
        for n in 0..constants.len() {
            let [i, j, k] = place(constants[n].0);
            z[k] = z[k].plus(x[i].times(y[j]).scaled(constants[n].1));
        }
    }
}
