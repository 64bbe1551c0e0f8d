//! The loops in which numbers of 32 digits, and dual numbers over them, spend their time: products of matrices and sums of
//! multiples, compiled once for a scalar, whatever the sizes.
//!
//! Everywhere else an operation on such numbers is a call. Here it is compiled where it stands, with the fused multiply-add of the
//! machine, so that operations that do not wait for each other overlap: several times faster, to the same bits.

use super::{Real, Scalar, finite, fused};

/// Whether a scalar is made of more than `f64`: then its operations are calls outside these loops.
pub(crate) const fn heavy<S: Scalar>() -> bool {
    size_of::<S::Base>() > size_of::<f64>()
}

// Factors that are 0 are left out, where nothing is infinite: 0 × ∞ is NaN, and is to be seen.
fused::loops! {
    /// y += x c, entry by entry.
    fn add_multiple<S: Scalar>(y: &mut [S], x: &[S], c: S) {
        S::add_multiple(y, x, c);
    }

    /// y += x c, entry by entry, for constants x of which many are 0.
    fn add_constants<S: Scalar>(y: &mut [S], x: &[S::Base], c: S) {
        let all = !c.all_finite();
        if c.vanishes() {
            return;
        }
        for i in 0..y.len().min(x.len()) {
            if all || !x[i].vanishes() {
                y[i] = y[i].plus(c.scaled(x[i]));
            }
        }
    }

    /// sum += Σ c_i x_i, for constants c of which many are 0.
    fn add_sum<S: Scalar>(sum: &mut S, x: &[S], c: &[S::Base]) {
        let all = !finite(x);
        for i in 0..x.len().min(c.len()) {
            if all || !c[i].vanishes() {
                *sum = sum.plus(x[i].scaled(c[i]));
            }
        }
    }

    /// C += A B, column by column; A has `rows` rows.
    fn add_product<S: Scalar>(c: &mut [S], a: &[S], b: &[S], rows: usize) {
        if rows == 0 || a.is_empty() {
            return;
        }
        let (all, inner) = (!finite(a), a.len() / rows);
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

    /// y += μ A, row by row of the square matrix A.
    fn add_pulled<S: Scalar>(y: &mut [S], mu: &[S], a: &[S]) {
        let (all, rows) = (!finite(a), mu.len());
        for i in 0..rows {
            if all || !mu[i].vanishes() {
                for j in 0..y.len() {
                    y[j] = y[j].plus(mu[i].times(a[i + j * rows]));
                }
            }
        }
    }

    /// z_c += C (x_a y_b − x_b y_a) over constants C with the places (a, b, c).
    fn add_brackets<T: Real>(z: &mut [T], constants: &[([usize; 3], T)], x: &[T], y: &[T]) {
        for i in 0..constants.len() {
            let ([a, b, c], constant) = constants[i];
            z[c] = z[c].plus(constant.times(x[a].times(y[b]).minus(x[b].times(y[a]))));
        }
    }

    /// ν_b += C μ_c x_a and ν_a −= C μ_c x_b over constants C with the places (a, b, c).
    fn add_coadjoint<T: Real>(nu: &mut [T], constants: &[([usize; 3], T)], x: &[T], mu: &[T]) {
        for i in 0..constants.len() {
            let ([a, b, c], constant) = constants[i];
            let scaled = constant.times(mu[c]);
            nu[b] = nu[b].plus(scaled.times(x[a]));
            nu[a] = nu[a].minus(scaled.times(x[b]));
        }
    }

    /// z_k += C x_i y_j over constants C, where `place` finds (i, j, k).
    fn add_trilinear<S: Scalar, P: Fn([usize; 4]) -> [usize; 3]>(
        z: &mut [S],
        constants: &[([usize; 4], S::Base)],
        x: &[S],
        y: &[S],
        place: P,
    ) {
        for n in 0..constants.len() {
            let [i, j, k] = place(constants[n].0);
            z[k] = z[k].plus(x[i].times(y[j]).scaled(constants[n].1));
        }
    }
}
