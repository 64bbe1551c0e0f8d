//! Lie algebroids in a frame, and the bracket of their sections.
//!
//! Source: Martín de Diego and Sato Martín de Almagro 2019, Definitions 4.4 and 4.5.

use super::calculus::{along, constant, derivatives, values};
use crate::scalar::{Dual, Scalar};
use nalgebra::DVector;

/// A Lie algebroid over a manifold in ℝᵐ, with a global frame s_1, …, s_r of sections that closes under the bracket.
pub trait LieAlgebroid<S: Scalar> {
    /// r, the dimension of the fibres.
    fn rank(&self) -> usize;

    /// ρ(a^i s_i)(x), a vector in ℝᵐ.
    fn anchor(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S>;

    /// ⟦a^i s_i, b^i s_i⟧(x) for constant a and b.
    fn structure(&self, x: &DVector<S>, a: &DVector<S>, b: &DVector<S>) -> DVector<S>;
}

/// The same algebroid over the scalar below: an algebroid on duals, evaluated at constants.
#[derive(Debug)]
pub struct Lowered<'a, A: ?Sized>(pub &'a A);

impl<S: Scalar, A: LieAlgebroid<Dual<S>> + ?Sized> LieAlgebroid<S> for Lowered<'_, A> {
    fn rank(&self) -> usize {
        self.0.rank()
    }

    fn anchor(&self, x: &DVector<S>, a: &DVector<S>) -> DVector<S> {
        values(&self.0.anchor(&constant(x), &constant(a)))
    }

    fn structure(&self, x: &DVector<S>, a: &DVector<S>, b: &DVector<S>) -> DVector<S> {
        values(&self.0.structure(&constant(x), &constant(a), &constant(b)))
    }
}

/// A section, as the function from the coordinates of x to those of X(x) in the frame, on duals.
pub type Section<'a, S> = dyn Fn(&DVector<Dual<S>>) -> DVector<Dual<S>> + 'a;

/// ⟦X, Y⟧(x) = ρ(X)(Y) − ρ(Y)(X) + ⟦X^i(x) s_i, Y^j(x) s_j⟧, the derivatives by duals.
///
/// Source: Martín de Diego and Sato Martín de Almagro 2019, Def 4.4 (the Leibniz rule, twice).
pub fn section_bracket<S: Scalar, A: LieAlgebroid<S> + ?Sized>(
    algebroid: &A,
    first: &Section<'_, S>,
    second: &Section<'_, S>,
    x: &DVector<S>,
) -> DVector<S> {
    let (a, b) = (values(&first(&constant(x))), values(&second(&constant(x))));
    let of_second = derivatives(&second(&along(x, &algebroid.anchor(x, &a))));
    let of_first = derivatives(&first(&along(x, &algebroid.anchor(x, &b))));
    of_second - of_first + algebroid.structure(x, &a, &b)
}
