//! Discrete Lagrangians given by a value that runs on dual numbers.

use super::{DiscreteError, DiscreteLagrangian, Slopes, Triple};
use crate::algebra::{Covector, Matrix, basis_vector};
use crate::group::LieGroup;
use crate::retraction::RetractionError;
use crate::scalar::dual::moving;
use crate::scalar::{Dual, Real, Scalar};

/// l_d(V, U, W) in any scalar.
pub trait SmoothLagrangian<T: Real, const D: usize> {
    /// l_d(V, U, W).
    ///
    /// # Errors
    /// A group element outside the domain.
    fn value<S: Scalar<Base = T>>(&self, x: &Triple<S, D>) -> Result<S, RetractionError>;
}

/// A smooth l_d with its derivatives by dual numbers, at V(1 + ε ê_a) and (1 + ε ê_a)V: exact, as ε² = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smooth<'a, L, G> {
    /// l_d.
    pub lagrangian: L,
    /// G.
    pub group: &'a G,
}

/// g(1 + ε ê_a) and (1 + ε ê_a)g.
pub(super) fn moved<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    group: &impl LieGroup<T, N, D>,
    g: &Matrix<S, D>,
    a: usize,
) -> (Matrix<Dual<S>, D>, Matrix<Dual<S>, D>) {
    let hat = group.hat(&basis_vector::<S, N>(a));
    (moving(g, &(g * hat)), moving(g, &(hat * g)))
}

impl<'a, L, G> Smooth<'a, L, G> {
    /// l_d on the group G.
    pub fn new(lagrangian: L, group: &'a G) -> Self {
        Self { lagrangian, group }
    }
}

impl<T, L, G, const N: usize, const D: usize> DiscreteLagrangian<T, N, D> for Smooth<'_, L, G>
where
    T: Real,
    L: SmoothLagrangian<T, D>,
    G: LieGroup<T, N, D>,
{
    type Memory = ();

    fn value(&self, x: &Triple<T, D>) -> Result<T, DiscreteError> {
        self.lagrangian.value(x).map_err(DiscreteError::domain("(V, U, W)"))
    }

    fn slopes_from(&self, x: &Triple<T, D>, (): &mut ()) -> Result<Slopes<T, N>, DiscreteError> {
        let still = Triple { v: x.v.map(Dual::constant), u: x.u.map(Dual::constant), w: x.w.map(Dual::constant) };
        let slope = |x: Triple<Dual<T>, D>| {
            let value = self.lagrangian.value(&x).map_err(DiscreteError::domain("(V, U, W)"))?;
            Ok::<T, DiscreteError>(value.eps)
        };
        let zero = Covector::zeros();
        let mut slopes =
            Slopes { v_left: zero, v_right: zero, u_left: zero, u_right: zero, w_left: zero, w_right: zero };
        for a in 0..N {
            let [v, u, w] = [&x.v, &x.u, &x.w].map(|g| moved(self.group, g, a));
            slopes.v_left[a] = slope(Triple { v: v.0, ..still })?;
            slopes.v_right[a] = slope(Triple { v: v.1, ..still })?;
            slopes.u_left[a] = slope(Triple { u: u.0, ..still })?;
            slopes.u_right[a] = slope(Triple { u: u.1, ..still })?;
            slopes.w_left[a] = slope(Triple { w: w.0, ..still })?;
            slopes.w_right[a] = slope(Triple { w: w.1, ..still })?;
        }
        Ok(slopes)
    }
}
