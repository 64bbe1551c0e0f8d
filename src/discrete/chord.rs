//! Newton's method with a Jacobian that is kept while it serves.
//!
//! A Jacobian here costs many residuals (by differences, each column perhaps with an inner problem to solve), so the
//! factors are kept, also from one problem to the next nearby, as long as an iteration gains a factor of 64.

use super::DiscreteError;
use crate::algebra::{Covector, Matrix, Vector};
use crate::retraction::Retraction;
use crate::scalar::Real;
use nalgebra::{DMatrix, DVector, Dyn, LU};

/// The factors of a Jacobian.
pub(super) type Factors<T> = LU<T, Dyn, Dyn>;

/// A residual and the size that it is to be compared with.
pub(super) type Residual<T> = (DVector<T>, T);

/// n equations in n unknowns.
pub(super) trait Equations<T: Real> {
    /// What they are, in the plural, for messages.
    fn name(&self) -> &'static str;

    /// The residual at x, and the size of the terms in it.
    fn residual(&mut self, x: &DVector<T>) -> Result<Residual<T>, DiscreteError>;

    /// The Jacobian at x, or near it: it decides how fast the iteration is, not where it ends.
    fn jacobian(&mut self, x: &DVector<T>) -> Result<DMatrix<T>, DiscreteError>;

    /// What a residual gains by rounding beyond its own terms, in units of round-off; known after a Jacobian.
    fn rounding(&self) -> T {
        T::zero()
    }
}

/// How a solve went.
pub(super) struct Solved<T: Real> {
    /// The factors last used; `None` if the start solved the equations.
    pub factors: Option<Factors<T>>,
    /// The relative residual reached.
    pub residual: T,
    /// Iterations.
    pub iterations: usize,
}

/// Iterations of one solve.
const MAX_ITERATIONS: usize = 60;

/// An iteration that gains less than this asks for another Jacobian.
const WANTED_GAIN: f64 = 1.0 / 64.0;

/// Solves from x, which becomes the root, with `factors` from nearby if there are any.
pub(super) fn solve<T: Real>(
    equations: &mut dyn Equations<T>,
    x: &mut DVector<T>,
    mut factors: Option<Factors<T>>,
) -> Result<Solved<T>, DiscreteError> {
    let what = equations.name();
    let tolerance = T::int(x.len() as i64) * T::unit_roundoff();
    let floor = tolerance * T::int(256);
    let (mut last, mut fresh, mut iterations) = (None::<T>, false, 0);
    loop {
        let (residual, size) = equations.residual(x)?;
        let largest = residual.amax();
        // 0/0 is a residual of zero: a system at rest without forces.
        let relative = if largest == T::zero() { T::zero() } else { largest / size };
        let failed = DiscreteError::NotConverged { what, residual: relative.to_f64(), iterations };
        if !relative.all_finite() || !residual.iter().all(|v| v.all_finite()) {
            return Err(failed);
        }
        let stagnates = last.is_some_and(|last| relative > last * T::half());
        if relative <= tolerance || (stagnates && largest <= floor * (size + equations.rounding())) {
            return Ok(Solved { factors, residual: relative, iterations });
        }
        // A Jacobian from the point before that does not even reduce the residual.
        if iterations == MAX_ITERATIONS || (fresh && last.is_some_and(|last| relative > last)) {
            return Err(failed);
        }
        fresh = last.is_some_and(|last| relative > last * T::exact(WANTED_GAIN));
        let kept = factors.take().filter(|_| !fresh);
        fresh = kept.is_none();
        let used = match kept {
            Some(kept) => kept,
            None => equations.jacobian(x)?.lu(),
        };
        let mut correction = residual;
        if !used.solve_mut(&mut correction) {
            return Err(DiscreteError::Singular { what });
        }
        *x -= correction;
        factors = Some(used);
        last = Some(relative);
        iterations += 1;
    }
}

/// A residual as a function of the unknowns.
type Function<'a, T> = dyn FnMut(&DVector<T>) -> Result<Residual<T>, DiscreteError> + 'a;

/// Equations for displacements in a group, given by their residual alone; the Jacobian by forward differences.
struct Differences<'a, T: Real> {
    name: &'static str,
    residual: &'a mut Function<'a, T>,
    slope: T,
}

impl<T: Real> Equations<T> for Differences<'_, T> {
    fn name(&self) -> &'static str {
        self.name
    }

    fn residual(&mut self, x: &DVector<T>) -> Result<Residual<T>, DiscreteError> {
        (self.residual)(x)
    }

    fn jacobian(&mut self, x: &DVector<T>) -> Result<DMatrix<T>, DiscreteError> {
        let (here, _) = (self.residual)(x)?;
        let epsilon = T::unit_roundoff().sqrt();
        let mut jacobian = DMatrix::zeros(here.len(), x.len());
        for column in 0..x.len() {
            let mut moved = x.clone();
            moved[column] += epsilon;
            let (there, _) = (self.residual)(&moved)?;
            jacobian.set_column(column, &((there - &here) / epsilon));
        }
        self.slope = jacobian.amax();
        Ok(jacobian)
    }

    /// Group elements are of size 1 and rounded like that, however small the displacement.
    fn rounding(&self) -> T {
        self.slope
    }
}

/// The K elements of a group near `starts` at which K covectors vanish, g_k τ(x_k) by Newton's method for x from 0.
///
/// `residual` gives the covectors, and the size that they are to be compared with.
pub(super) fn elements<T: Real, const K: usize, const N: usize, const D: usize>(
    name: &'static str,
    retraction: &impl Retraction<T, N, D>,
    starts: [Matrix<T, D>; K],
    mut residual: impl FnMut(&[Matrix<T, D>; K]) -> Result<([Covector<T, N>; K], T), DiscreteError>,
) -> Result<[Matrix<T, D>; K], DiscreteError> {
    let place = |x: &DVector<T>| {
        let mut elements = starts;
        for (k, element) in elements.iter_mut().enumerate() {
            let x = Vector::<T, N>::from_fn(|a, _| x[k * N + a]);
            *element *= retraction.tau(&x).map_err(DiscreteError::domain("a displacement"))?;
        }
        Ok::<_, DiscreteError>(elements)
    };
    let mut residual = |x: &DVector<T>| {
        let (covectors, size) = residual(&place(x)?)?;
        Ok((DVector::from_iterator(K * N, covectors.iter().flat_map(|row| row.iter().copied())), size))
    };
    let mut x = DVector::zeros(K * N);
    solve(&mut Differences { name, residual: &mut residual, slope: T::zero() }, &mut x, None)?;
    place(&x)
}
