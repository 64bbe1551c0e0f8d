//! The reduced Euler–Lagrange equations on g×G×g of any doubled Lagrangian.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/mechanics/euler_lagrange.md"))]

use super::doubled::{Both, DoubledLagrangian, VelocityError, VelocityPoint, singular};
use crate::algebra::elimination::power_of_two;
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::retraction::RetractionError;
use crate::scalar::{Dual, Real, Scalar};
use nalgebra::{DMatrix, DVector};

/// U̇ = Uψ̂ − η̂U, a D×D matrix.
///
/// # Errors
/// There are no matrices (an algebra without a group).
pub fn arrow_rate<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    at: &VelocityPoint<S, N, D>,
) -> Result<Matrix<S, D>, RetractionError> {
    Ok(at.u * doubled.hat(&at.psi)? - doubled.hat(&at.eta)? * at.u)
}

/// What the equations leave at given accelerations η̇ and ψ̇, with U̇ = Uψ̂ − η̂U: the covectors
///
/// d/dt ∂l/∂η − ad*_η ∂l/∂η + R*_U ∂l/∂U and d/dt ∂l/∂ψ − ad*_ψ ∂l/∂ψ − L*_U ∂l/∂U,
///
/// both 0 along a solution. The time derivative is taken on dual numbers.
///
/// # Errors
/// U outside the domain of the Lagrangian; no group.
pub fn residual<T: Real, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    at: &VelocityPoint<T, N, D>,
    (eta_rate, psi_rate): Both<&Vector<T, N>>,
) -> Result<Both<Covector<T, N>>, RetractionError> {
    let rates = VelocityPoint { time: T::one(), eta: *eta_rate, u: arrow_rate(doubled, at)?, psi: *psi_rate };
    let moving = doubled.partials(&at.moving(&rates))?;
    let (value, rate) = (|v: Dual<T>| v.re, |v: Dual<T>| v.eps);
    let first = moving.eta.map(rate) - algebra.coad(&at.eta, &moving.eta.map(value)) + moving.right.map(value);
    let second = moving.psi.map(rate) - algebra.coad(&at.psi, &moving.psi.map(value)) - moving.left.map(value);
    Ok((first, second))
}

/// The rates of (t; η, U, ψ) along a solution: the equations solved for the accelerations, by one linear system with the second
/// derivatives of **l** in (η, ψ), 2N×2N.
///
/// # Errors
/// U outside the domain of the Lagrangian; no group; second derivatives that are singular to working precision.
pub fn rates<T: Real, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    algebra: &LieAlgebra<T, N>,
    at: &VelocityPoint<T, N, D>,
) -> Result<VelocityPoint<T, N, D>, VelocityError> {
    let zero = Vector::zeros();
    let (first, second) = residual(doubled, algebra, at, (&zero, &zero))?;
    let (eta, psi) = accelerations(doubled, at, &-first, &-second)?;
    Ok(VelocityPoint { time: T::one(), eta, u: arrow_rate(doubled, at)?, psi })
}

/// The (η̇, ψ̇) that change (∂l/∂η, ∂l/∂ψ) at the given rates while t and U stand still: one linear system with the
/// second derivatives of **l**.
///
/// # Errors
/// U outside the domain of the Lagrangian; second derivatives that are singular to working precision.
pub fn accelerations<T: Real, const N: usize, const D: usize>(
    doubled: &impl DoubledLagrangian<T, N, D>,
    at: &VelocityPoint<T, N, D>,
    first: &Covector<T, N>,
    second: &Covector<T, N>,
) -> Result<Both<Vector<T, N>>, VelocityError> {
    let ((a, c), (b, d)) = doubled.velocity_hessian(at)?;
    let hessian = DMatrix::from_fn(2 * N, 2 * N, |i, j| {
        let block = [[&a, &b], [&c, &d]][i / N][j / N];
        block[(i % N, j % N)]
    });
    let right = DVector::from_fn(2 * N, |i, _| if i < N { first[i] } else { second[i - N] });
    let solution = solve(hessian, &right).ok_or_else(|| singular(at))?;
    Ok((Vector::from_fn(|a, _| solution[a]), Vector::from_fn(|a, _| solution[N + a])))
}

/// A⁻¹b by elimination with complete pivoting, rows and columns scaled by powers of two; `None` when the last pivot is
/// below n u times the first.
fn solve<T: Real>(mut matrix: DMatrix<T>, right: &DVector<T>) -> Option<DVector<T>> {
    let n = matrix.nrows();
    let scale = |entries: &mut dyn Iterator<Item = &T>| {
        let size =
            entries.fold(0.0_f64, |size, v| if v.all_finite() { size.max(v.to_f64().abs()) } else { f64::INFINITY });
        power_of_two(size).map(T::exact)
    };
    let columns = (0..n).map(|c| scale(&mut matrix.column(c).iter())).collect::<Option<Vec<_>>>()?;
    (0..n).for_each(|c| matrix.column_mut(c).scale_mut(columns[c]));
    let rows = (0..n).map(|r| scale(&mut matrix.row(r).iter())).collect::<Option<Vec<_>>>()?;
    (0..n).for_each(|r| matrix.row_mut(r).scale_mut(rows[r]));
    let factored = matrix.full_piv_lu();
    let pivots = factored.u();
    let (first, last) = (pivots.get((0, 0))?.abs(), pivots.iter().last()?.abs());
    if last <= first * T::unit_roundoff() * T::int(n as i64) {
        return None;
    }
    let scaled = DVector::from_fn(n, |r, _| right[r] * rows[r]);
    let solution = factored.solve(&scaled)?;
    Some(DVector::from_fn(n, |c, _| solution[c] * columns[c])).filter(|x| x.iter().all(|v| v.all_finite()))
}
