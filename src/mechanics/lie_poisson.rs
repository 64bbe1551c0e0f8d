//! The Lie–Poisson bracket on g* for functions, and forces that keep the coadjoint orbits.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/mechanics/lie_poisson.md"))]

use super::{Force, Lagrangian};
use crate::algebra::{Casimir, Covector, LieAlgebra, Vector, pair};
use crate::scalar::{Real, Scalar, dual};

/// A function on g*. Only `value` is required: the differential comes from dual numbers.
pub trait MomentumFunction<T: Real, const N: usize> {
    /// F(μ).
    fn value<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> S;

    /// F'(μ), a vector of g.
    fn differential<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> Vector<S, N> {
        Vector::from_fn(|a, _| self.value(&dual::along(&mu.transpose(), a).transpose()).eps)
    }
}

impl<T: Real, const N: usize> MomentumFunction<T, N> for Casimir<T, N> {
    fn value<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> S {
        Casimir::value(self, mu)
    }

    fn differential<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> Vector<S, N> {
        self.gradient(mu)
    }
}

/// {F, K}(μ) = −⟨μ, [F'(μ), K'(μ)]⟩, the Lie–Poisson bracket: a function on g* again.
#[derive(Clone, Debug)]
pub struct Bracket<'a, T: Real, const N: usize, F, K> {
    /// g.
    pub algebra: &'a LieAlgebra<T, N>,
    /// F.
    pub first: &'a F,
    /// K.
    pub second: &'a K,
}

impl<T: Real, const N: usize, F: MomentumFunction<T, N>, K: MomentumFunction<T, N>> MomentumFunction<T, N>
    for Bracket<'_, T, N, F, K>
{
    fn value<S: Scalar<Base = T>>(&self, mu: &Covector<S, N>) -> S {
        -pair(mu, &self.algebra.bracket(&self.first.differential(mu), &self.second.differential(mu)))
    }
}

/// The Hamiltonian vector field of H on g*: μ̇ = ad*_{H'(μ)} μ, so that Ḟ = {F, H} for every F
/// (Martín de Diego and Sato Martín de Almagro 2019, (2.5)).
pub fn hamiltonian_field<T: Real, S: Scalar<Base = T>, const N: usize>(
    algebra: &LieAlgebra<T, N>,
    hamiltonian: &impl MomentumFunction<T, N>,
    mu: &Covector<S, N>,
) -> Covector<S, N> {
    algebra.coad(&hamiltonian.differential(mu), mu)
}

/// ζ(t, η), any map into g.
pub trait OrbitField<T: Real, const N: usize> {
    /// ζ(t, η).
    fn zeta<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Vector<S, N>;
}

/// f(t, η) = ad*_ζ l'(η) with ζ = ζ(t, η): the momentum stays on its coadjoint orbit, μ(t) = Ad*_{k(t)} (Ad*_{k(0)⁻¹} μ(0))
/// with k̇ = k (η + ζ), and every Casimir is kept (Martín de Diego and Sato Martín de Almagro 2019, §2.2).
///
/// ```
/// use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Vector};
/// use euler_poincare::mechanics::lie_poisson::{OrbitField, OrbitForce};
/// use euler_poincare::mechanics::{Force, lagrangian::Quadratic};
/// use euler_poincare::scalar::{Real, Scalar};
///
/// /// ζ = e_1, whatever t and η.
/// struct Axis;
///
/// impl<T: Real> OrbitField<T, 3> for Axis {
///     fn zeta<S: Scalar<Base = T>>(&self, _: S, _: &Vector<S, 3>) -> Vector<S, 3> {
///         Vector::x()
///     }
/// }
///
/// // |μ|² is kept: the force is tangent to the sphere.
/// let so3 = LieAlgebra::<f64, 3>::from_catalogue(&Entry::So3)?;
/// let force = OrbitForce::new(so3, Quadratic::diagonal([1.0, 1.0, 1.0])?, Axis);
/// let mu = Vector::<f64, 3>::new(1.0, 2.0, 3.0);
/// let f: Covector<f64, 3> = force.force(0.0, &mu);
/// assert_eq!((f * mu)[0], 0.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct OrbitForce<T: Real, const N: usize, L, Z> {
    /// g.
    pub algebra: LieAlgebra<T, N>,
    /// l.
    pub lagrangian: L,
    /// ζ.
    pub field: Z,
}

impl<T: Real, const N: usize, L, Z> OrbitForce<T, N, L, Z> {
    /// The force of a field ζ, on an algebra, for a Lagrangian.
    pub fn new(algebra: LieAlgebra<T, N>, lagrangian: L, field: Z) -> Self {
        Self { algebra, lagrangian, field }
    }
}

impl<T: Real, const N: usize, L: Lagrangian<T, N>, Z: OrbitField<T, N>> Force<T, N> for OrbitForce<T, N, L, Z> {
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        self.algebra.coad(&self.field.zeta(t, eta), &self.lagrangian.gradient(eta))
    }
}
