//! Forces given in the frame of space.

use super::{Configuration, ForceOnGroup};
use crate::algebra::{Covector, Matrix, Vector};
use crate::group::LieGroup;
use crate::mechanics::Force;
use crate::scalar::{Real, Scalar};

/// f = Ad*_g f_s(t, g, g η g⁻¹): a force that is given in the frame of space, as a function of the velocity in space.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix, Vector};
/// use euler_poincare::group::So3;
/// use euler_poincare::mechanics::Force;
/// use euler_poincare::mechanics::configuration::{Configuration, ForceOnGroup, InSpace};
/// use euler_poincare::scalar::{Real, Scalar};
///
/// /// A constant torque about the first axis in space.
/// struct Wind;
///
/// impl<T: Real> ForceOnGroup<T, 3, 3> for Wind {
///     fn force<S: Scalar<Base = T>>(&self, _: S, _: &Matrix<S, 3>, _: &Vector<S, 3>) -> Covector<S, 3> {
///         Covector::<S, 3>::new(S::one(), S::zero(), S::zero())
///     }
/// }
///
/// let wind = InSpace::new(Wind, So3::<f64>::new());
/// let quarter = Matrix::<f64, 3>::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
/// let body: Covector<f64, 3> = wind.force_at(0.0, Configuration::of(&quarter), &Vector::zeros());
/// assert_eq!(body, Covector::<f64, 3>::new(0.0, -1.0, 0.0));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct InSpace<F, G, const D: usize> {
    force: F,
    group: G,
}

impl<F, G, const D: usize> InSpace<F, G, D> {
    /// f_s, and the group.
    pub fn new(force: F, group: G) -> Self {
        Self { force, group }
    }
}

impl<T, const N: usize, const D: usize, F, G> Force<T, N> for InSpace<F, G, D>
where
    T: Real,
    F: ForceOnGroup<T, N, D>,
    G: LieGroup<T, N, D>,
{
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        self.force.force(t, &Matrix::identity(), eta)
    }

    /// Not finite where g is singular.
    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        let g = g.matrix();
        let nowhere = || Matrix::from_element(S::exact(f64::NAN));
        let adjoint = self.group.adjoint(&g).unwrap_or_else(nowhere);
        self.force.force(t, &g, &(adjoint * eta)) * adjoint
    }

    fn undefined(&self, _t: T, g: Configuration<'_, T>, _eta: &Vector<T, N>) -> Option<String> {
        let singular = self.group.adjoint(&g.matrix()).is_none();
        singular.then(|| "the attitude is a singular matrix".to_owned())
    }

    fn uses_configuration(&self) -> bool {
        true
    }

    fn is_smooth(&self) -> bool {
        self.force.is_smooth()
    }
}
