//! What the equations of a step need of a tableau.

use crate::integrators::stages::Weights;
use crate::scalar::Real;
use crate::tableau::Tableau;
use nalgebra::DMatrix;

/// Weights larger than this extrapolate nothing but rounding.
const LARGEST_WEIGHT: f64 = 1_048_576.0;

/// Nodes closer than this count as one where values are interpolated.
pub(in crate::integrators) const LEAST_NODE_DISTANCE: f64 = 1.0 / 1024.0;

/// The tableau, and what follows from it.
#[derive(Clone, Debug)]
pub(super) struct Coefficients<T: Real> {
    pub(super) tableau: Tableau<T>,
    /// a_ij.
    pub(super) weights: Weights<T>,
    /// â_ij.
    pub(super) conjugate: Weights<T>,
    /// b_j a_ji / b_i.
    pub(super) coupling: Weights<T>,
    /// Lagrange weights that carry values at c_j to 1 + c_i; none where nodes coincide.
    pub(super) extrapolation: Option<Weights<T>>,
}

impl<T: Real> Coefficients<T> {
    pub(super) fn of(tableau: Tableau<T>) -> Self {
        let (s, a, b) = (tableau.stages(), tableau.a(), tableau.b());
        Self {
            weights: Weights::of(a),
            conjugate: Weights::of(tableau.conjugate().a()),
            coupling: Weights::of(&DMatrix::from_fn(s, s, |i, j| b[j] * a[(j, i)] / b[i])),
            extrapolation: extrapolation(tableau.c().as_slice()).as_ref().map(Weights::of),
            tableau,
        }
    }
}

/// Lagrange weights E with p(1 + c_i) = Σ_j E_ij p(c_j) for polynomials of degree < s; none where two nodes are no further [`LEAST_NODE_DISTANCE`], or a
/// weight is larger than [`LARGEST_WEIGHT`].
pub(in crate::integrators) fn extrapolation<T: Real>(c: &[T]) -> Option<DMatrix<T>> {
    let s = c.len();
    let apart = (0..s).all(|i| (0..i).all(|j| (c[i] - c[j]).abs() > T::exact(LEAST_NODE_DISTANCE)));
    if !apart {
        return None;
    }
    let weights = DMatrix::from_fn(s, s, |i, j| {
        (0..s).filter(|&k| k != j).fold(T::one(), |w, k| w * (T::one() + c[i] - c[k]) / (c[j] - c[k]))
    });
    weights.iter().all(|w| w.abs() < T::exact(LARGEST_WEIGHT)).then_some(weights)
}
