//! Forces, Lagrangians and potentials that depend on the configuration g ∈ G.
//!
//! With L(t, g, η) and f(t, g, η), and the left-trivialised derivative ⟨∂_gL, ξ⟩ = d/ds L(t, g exp(sξ), η):
//! d/dt ∂L/∂η = ad*_η ∂L/∂η + ∂_gL + f, ġ = gη. The scheme of Martín de Diego and Sato Martín de Almagro 2019, §5.2, holds as it
//! stands with ∂_gL + f at g τ(Ξ_i) instead of f(η_i).
//!
//! | to write | to give to an integrator |
//! |---|---|
//! | a force f(t, g, η): [`ForceOnGroup`] | [`OnGroup`] |
//! | a potential V(t, g): [`Potential`] | [`WithPotential`], beside a Lagrangian of η alone |
//! | a Lagrangian L(t, g, η): [`LagrangianOnGroup`] | [`LagrangianOn`] |
//! | a force in space, f = Ad*_g f_s(t, g, gηg⁻¹): [`ForceOnGroup`] | [`InSpace`] |
//! | a force at a point of a body, in the frame of the body or of space: any [`Force`] on ℝ³ | [`AtPoint`] |
//! | a closure on `f64` | [`BlackBox`](super::force::BlackBox) |

mod point;
mod space;

pub use point::AtPoint;
pub use space::InSpace;

use super::legendre::newton_velocity;
use super::{Force, Lagrangian, LegendreError, at_the_identity, body, hessian_by_duals, passed_on};
use crate::algebra::{Covector, Matrix, Vector, basis_vector, pair};
use crate::group::LieGroup;
use crate::scalar::{Dual, Real, Scalar, dual};

/// An element g of the group as a matrix, whose size is not in the type.
#[derive(Clone, Copy, Debug)]
pub struct Configuration<'a, S> {
    /// The entries by columns.
    entries: &'a [S],
    size: usize,
}

impl<S> Configuration<'static, S> {
    /// e.
    pub const fn identity() -> Self {
        Self { entries: &[], size: 0 }
    }
}

impl<'a, S: Scalar> Configuration<'a, S> {
    /// g, a D×D matrix.
    pub fn of<const D: usize>(g: &'a Matrix<S, D>) -> Self {
        Self { entries: g.as_slice(), size: D }
    }

    /// The matrix with these entries, by columns.
    pub(crate) fn sized(entries: &'a [S], size: usize) -> Self {
        Self { entries, size }
    }

    /// D; 0 for the identity of any group.
    pub fn size(&self) -> usize {
        self.size
    }

    /// g_rc, from 0; outside the matrix that of the identity.
    pub fn entry(&self, r: usize, c: usize) -> S {
        if r < self.size && c < self.size {
            self.entries[c * self.size + r]
        } else if r == c {
            S::one()
        } else {
            S::zero()
        }
    }

    /// The first D rows and columns of g.
    pub fn matrix<const D: usize>(&self) -> Matrix<S, D> {
        Matrix::from_fn(|r, c| self.entry(r, c))
    }
}

/// A force f(t, g, η) with values in g*. [`OnGroup`] makes a [`Force`] of it.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix, Vector};
/// use euler_poincare::group::So3;
/// use euler_poincare::integrators::{OneStep, State, Variational};
/// use euler_poincare::mechanics::configuration::{ForceOnGroup, OnGroup, Potential, WithPotential};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::ExponentialSo3;
/// use euler_poincare::scalar::{Real, Scalar};
/// use euler_poincare::tableau::Family;
///
/// /// Proportional-derivative control of the attitude: the torque −k (g − gᵀ)^∨/2 − d η turns the body to g = 1.
/// struct Controller;
///
/// impl<T: Real> ForceOnGroup<T, 3, 3> for Controller {
///     fn force<S: Scalar<Base = T>>(&self, _: S, g: &Matrix<S, 3>, eta: &Vector<S, 3>) -> Covector<S, 3> {
///         let error = Vector::<S, 3>::new(g[(2, 1)] - g[(1, 2)], g[(0, 2)] - g[(2, 0)], g[(1, 0)] - g[(0, 1)]) * S::half();
///         -(error * S::int(4) + eta * S::int(3)).transpose()
///     }
/// }
///
/// /// A weight at the point r of the body: V = m g₀ ⟨e₃, g r⟩.
/// struct Gravity;
///
/// impl<T: Real> Potential<T, 3> for Gravity {
///     fn value<S: Scalar<Base = T>>(&self, _: S, g: &Matrix<S, 3>) -> S {
///         (g[(2, 0)] * S::ratio(3, 10) + g[(2, 2)] * S::half()) * S::ratio(13, 10)
///     }
/// }
///
/// let body = Quadratic::<f64, 3>::diagonal([0.5, 2.0, 1.0])?;
/// let top = WithPotential::new(body, Gravity, So3::new());
/// let mut method = Variational::new(top, OnGroup(Controller), ExponentialSo3::new(), Family::Gauss.tableau(2)?);
/// let momentum = Covector::<f64, 3>::new(0.5, 0.3, 0.9);
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::<f64, 3>::identity() };
/// for _ in 0..300 {
///     method.step(&mut state, 0.05)?;
/// }
/// assert!(state.momentum.norm() < 0.05 * momentum.norm(), "it comes to rest");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a force on a group of dimension {N} with matrices of size {D}",
    note = "implement `ForceOnGroup<T, {N}, {D}>`: `fn force<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, {D}>, eta: &Vector<S, {N}>) -> Covector<S, {N}>`"
)]
pub trait ForceOnGroup<T: Real, const N: usize, const D: usize> {
    /// f(t, g, η).
    fn force<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, D>, eta: &Vector<S, N>) -> Covector<S, N>;

    /// Whether f has all derivatives everywhere.
    fn is_smooth(&self) -> bool {
        true
    }
}

/// A force f(t, g, η) as a [`Force`]: what it is there without g is that at the identity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnGroup<F, const D: usize>(pub F);

impl<T: Real, const N: usize, const D: usize, F: ForceOnGroup<T, N, D>> Force<T, N> for OnGroup<F, D> {
    at_the_identity!(force);

    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        self.0.force(t, &g.matrix(), eta)
    }

    fn uses_configuration(&self) -> bool {
        true
    }

    fn is_smooth(&self) -> bool {
        self.0.is_smooth()
    }
}

/// g exp(ε ê_a) to first order in ε, for the derivative along the a-th basis vector.
fn moved<T: Real, S: Scalar<Base = T>, const N: usize, const D: usize>(
    group: &impl LieGroup<T, N, D>,
    g: &Matrix<S, D>,
    a: usize,
) -> Matrix<Dual<S>, D> {
    dual::moving(g, &(g * group.hat(&basis_vector(a))))
}

/// A potential V(t, g). [`WithPotential`] puts it beside a Lagrangian.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a potential on a group of matrices of size {D}",
    note = "implement `Potential<T, {D}>`: `fn value<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, {D}>) -> S`"
)]
pub trait Potential<T: Real, const D: usize> {
    /// V(t, g).
    fn value<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, D>) -> S;

    /// ∂_gV: ⟨∂_gV, ξ⟩ = d/ds V(t, g exp(sξ)), by dual numbers.
    fn gradient<S: Scalar<Base = T>, const N: usize>(
        &self,
        group: &impl LieGroup<T, N, D>,
        t: S,
        g: &Matrix<S, D>,
    ) -> Covector<S, N> {
        Covector::from_fn(|_, a| self.value(Dual::constant(t), &moved(group, g, a)).eps)
    }
}

/// L(t, g, η) = l(η) − V(t, g).
///
/// Its energy is that of l, and V.
#[derive(Clone, Debug, PartialEq)]
pub struct WithPotential<L, V, G, const D: usize> {
    body: L,
    potential: V,
    group: G,
}

impl<L, V, G, const D: usize> WithPotential<L, V, G, D> {
    /// l, V, and the group on which V is defined.
    pub fn new(lagrangian: L, potential: V, group: G) -> Self {
        Self { body: lagrangian, potential, group }
    }
}

impl<T, const N: usize, const D: usize, L, V, G> Lagrangian<T, N> for WithPotential<L, V, G, D>
where
    T: Real,
    L: Lagrangian<T, N>,
    V: Potential<T, D>,
    G: LieGroup<T, N, D>,
{
    at_the_identity!(lagrangian);
    passed_on!(body: hessian, gradient_at, velocity_at);

    fn uses_configuration(&self) -> bool {
        true
    }

    fn value_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        self.body.value_at(t, g, eta) - self.potential.value(t, &g.matrix())
    }

    fn energy_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        self.body.energy_at(t, g, eta) + self.potential.value(t, &g.matrix())
    }

    fn configuration_gradient<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
    ) -> Covector<S, N> {
        self.body.configuration_gradient(t, g, eta) - self.potential.gradient(&self.group, t, &g.matrix())
    }
}

/// −∂_gV of a potential, as a force.
#[derive(Clone, Debug, PartialEq)]
pub struct OfPotential<V, G, const D: usize> {
    potential: V,
    group: G,
}

impl<V, G, const D: usize> OfPotential<V, G, D> {
    /// Of V, on the group on which it is defined.
    pub fn new(potential: V, group: G) -> Self {
        Self { potential, group }
    }
}

impl<T, const N: usize, const D: usize, V, G> Force<T, N> for OfPotential<V, G, D>
where
    T: Real,
    V: Potential<T, D>,
    G: LieGroup<T, N, D>,
{
    at_the_identity!(force);

    fn uses_configuration(&self) -> bool {
        true
    }

    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, _: &Vector<S, N>) -> Covector<S, N> {
        -self.potential.gradient(&self.group, t, &g.matrix())
    }
}

/// A Lagrangian L(t, g, η). Only `value` is required: derivatives come from dual numbers. [`LagrangianOn`] makes a [`Lagrangian`] of
/// it.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix, Vector};
/// use euler_poincare::group::So3;
/// use euler_poincare::integrators::{OneStep, State, Variational};
/// use euler_poincare::mechanics::configuration::{LagrangianOn, LagrangianOnGroup};
/// use euler_poincare::mechanics::force::Zero;
/// use euler_poincare::mechanics::{Force, Lagrangian};
/// use euler_poincare::retraction::ExponentialSo3;
/// use euler_poincare::scalar::{Real, Scalar};
/// use euler_poincare::tableau::Family;
///
/// /// The inertia about the third axis grows as the axis rises.
/// struct Skater;
///
/// impl<T: Real> LagrangianOnGroup<T, 3, 3> for Skater {
///     fn value<S: Scalar<Base = T>>(&self, _t: S, g: &Matrix<S, 3>, eta: &Vector<S, 3>) -> S {
///         (eta[0] * eta[0] + eta[1] * eta[1] + eta[2] * eta[2] * (S::int(2) + g[(2, 2)])) * S::half()
///     }
/// }
///
/// let skater = LagrangianOn::new(Skater, So3::<f64>::new());
/// let mut method = Variational::new(skater, Zero, ExponentialSo3::new(), Family::Gauss.tableau(2)?);
/// let momentum = Covector::<f64, 3>::new(0.5, 0.0, 1.0);
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::<f64, 3>::identity() };
/// for _ in 0..40 {
///     method.step(&mut state, 0.05)?;
/// }
/// // Rotations about e₃ in space are a symmetry: the third component of g μ is kept.
/// let spatial = state.attitude * state.momentum.transpose();
/// assert!((spatial[2] - 1.0).abs() < 1e-12 && spatial[0].abs() > 1e-3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a Lagrangian on a group of dimension {N} with matrices of size {D}",
    note = "implement `LagrangianOnGroup<T, {N}, {D}>`: `fn value<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, {D}>, eta: &Vector<S, {N}>) -> S`"
)]
pub trait LagrangianOnGroup<T: Real, const N: usize, const D: usize> {
    /// L(t, g, η).
    fn value<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, D>, eta: &Vector<S, N>) -> S;

    /// ∂L/∂η.
    fn gradient<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, D>, eta: &Vector<S, N>) -> Covector<S, N> {
        let (t, g) = (Dual::constant(t), g.map(Dual::constant));
        Covector::from_fn(|_, a| self.value(t, &g, &dual::along(eta, a)).eps)
    }

    /// ∂²L/∂η², symmetric.
    fn hessian<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, D>, eta: &Vector<S, N>) -> Matrix<S, N> {
        let (t, g) = (Dual::constant(t), g.map(Dual::constant));
        hessian_by_duals(eta, |eta| self.gradient(t, &g, eta))
    }

    /// ∂_gL: ⟨∂_gL, ξ⟩ = d/ds L(t, g exp(sξ), η).
    fn configuration_gradient<S: Scalar<Base = T>>(
        &self,
        group: &impl LieGroup<T, N, D>,
        t: S,
        g: &Matrix<S, D>,
        eta: &Vector<S, N>,
    ) -> Covector<S, N> {
        let (t, eta) = (Dual::constant(t), eta.map(Dual::constant));
        Covector::from_fn(|_, a| self.value(t, &moved(group, g, a), &eta).eps)
    }
}

/// A Lagrangian L(t, g, η) as a [`Lagrangian`]: what it is there without t and g is that at t = 0 and the identity.
#[derive(Clone, Debug, PartialEq)]
pub struct LagrangianOn<L, G, const D: usize> {
    lagrangian: L,
    group: G,
}

impl<L, G, const D: usize> LagrangianOn<L, G, D> {
    /// L, and the group on which it is defined.
    pub fn new(lagrangian: L, group: G) -> Self {
        Self { lagrangian, group }
    }

    /// L, to be changed.
    pub fn lagrangian_mut(&mut self) -> &mut L {
        &mut self.lagrangian
    }
}

impl<T, const N: usize, const D: usize, L, G> Lagrangian<T, N> for LagrangianOn<L, G, D>
where
    T: Real,
    L: LagrangianOnGroup<T, N, D>,
    G: LieGroup<T, N, D>,
{
    at_the_identity!(lagrangian);

    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        self.lagrangian.hessian(S::zero(), &Matrix::identity(), eta)
    }

    fn uses_configuration(&self) -> bool {
        true
    }

    fn value_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        self.lagrangian.value(t, &g.matrix(), eta)
    }

    fn gradient_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        self.lagrangian.gradient(t, &g.matrix(), eta)
    }

    fn velocity_at<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        let l = &self.lagrangian;
        let (g, time) = (g.matrix::<D>(), t.base());
        let base = g.map(|v| v.base());
        newton_velocity(
            (&|eta| l.gradient(time, &base, eta), &|eta| l.hessian(time, &base, eta)),
            (&|eta| l.gradient(t, &g, eta), &|eta| l.hessian(t, &g, eta)),
            mu,
            guess,
        )
    }

    fn energy_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        pair(&self.gradient_at(t, g, eta), eta) - self.value_at(t, g, eta)
    }

    fn configuration_gradient<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
    ) -> Covector<S, N> {
        self.lagrangian.configuration_gradient(&self.group, t, &g.matrix(), eta)
    }
}
