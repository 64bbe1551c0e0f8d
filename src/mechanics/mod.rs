//! Reduced Lagrangians, forces, and the forced Euler–Poincaré and Lie–Poisson equations.
//!
#![doc = include_str!("../guide/modules/mechanics.md")]

use crate::algebra::{Covector, Matrix, Vector};
use crate::scalar::{Dual, Real, Scalar};

pub mod doubled;
pub mod equations;
pub mod euler_lagrange;
pub mod force;
pub mod forced_hamiltonian;
#[cfg(feature = "harness")]
#[doc(hidden)]
pub mod given;
pub mod hamiltonian;
pub mod lagrangian;
pub mod lie_poisson;
pub mod models;

/// Why the Legendre transform could not be inverted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LegendreError {
    /// l'' is singular to working precision where it was needed.
    #[error("the Lagrangian is not regular: its Hessian is singular at the velocity {velocity:?}")]
    Singular {
        /// The velocity η at which l''(η) is singular.
        velocity: Vec<f64>,
    },
    /// Newton's iteration for l'(η) = μ did not converge.
    #[error("the inverse Legendre transform did not converge: residual {residual:e} after {iterations} iterations")]
    NotConverged {
        /// Largest component of l'(η) − μ.
        residual: f64,
        /// Iterations spent.
        iterations: usize,
    },
    /// The inertia is not symmetric, not finite or not regular.
    #[error("the inertia is refused: {why}")]
    BadInertia {
        /// What is wrong, with the entry.
        why: String,
    },
    /// Another term of the Lagrangian is not what its formula needs.
    #[error("the {what} is refused: {why}")]
    BadTerm {
        /// Which term.
        what: &'static str,
        /// What is wrong, with the entry.
        why: String,
    },
}

/// A reduced Lagrangian l: g → ℝ. Only `value` is required: derivatives come from dual numbers.
///
/// ```
/// use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Matrix, Vector};
/// use euler_poincare::mechanics::equations::{EulerPoincare, Rates};
/// use euler_poincare::mechanics::force::{
///     AnyForce, Constant, DoubleBracket, ForceError, LinearDrag, Metriplectic, Periodic, QuadraticDrag, Zero,
/// };
/// use euler_poincare::mechanics::lagrangian::{AnyLagrangian, Quadratic, Quartic};
/// use euler_poincare::mechanics::{Force, Lagrangian, LegendreError, models, models::Model};
/// use euler_poincare::scalar::{Real, Scalar};
///
/// /// l(η) = ½|η|² + ¼|η|⁴. Gradient, Hessian and the inverse of the Legendre transform come from dual numbers.
/// struct Stiff;
///
/// impl<T: Real> Lagrangian<T, 3> for Stiff {
///     fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, 3>) -> S {
///         let square = eta.dot(eta);
///         square * S::half() + square * square * S::ratio(1, 4)
///     }
/// }
///
/// /// f(t, η) = −η.
/// struct Friction;
///
/// impl<T: Real> Force<T, 3> for Friction {
///     fn force<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, 3>) -> Covector<S, 3> {
///         -eta.transpose()
///     }
/// }
///
/// let so3 = LieAlgebra::<f64, 3>::from_catalogue(&Entry::So3)?;
/// let eta = Vector::<f64, 3>::new(0.0, 0.6, 0.8);
/// let system = EulerPoincare::new(so3.clone(), Stiff, Friction);
/// let mu: Covector<f64, 3> = system.lagrangian.gradient(&eta);
/// let rates: Rates<f64, 3> = system.rates(0.0, &mu, &Vector::zeros())?;
/// assert!((mu - 2.0 * eta.transpose()).amax() < 1e-15 && (rates.velocity - eta).amax() < 1e-14);
/// assert!((rates.momentum + eta.transpose()).amax() < 1e-14);
///
/// // Those of the library are checked when they are made.
/// let body = Quadratic::diagonal([1.0, 2.0, 3.0])?;
/// assert!(matches!(Quadratic::diagonal([1.0, f64::NAN, 1.0]), Err(LegendreError::BadInertia { .. })));
/// let stiff: AnyLagrangian<f64, 3> = Quartic::new(*body.inertia(), 0.5)?.into();
/// let one = Matrix::<f64, 3>::identity();
/// let forces = [
///     AnyForce::Zero(Zero),
///     AnyForce::DoubleBracket(DoubleBracket::new(so3.clone(), stiff.clone(), 0.1)?),
///     AnyForce::Metriplectic(Metriplectic::new(so3, stiff, 0.1)?),
///     AnyForce::LinearDrag(LinearDrag::new(one)?),
///     AnyForce::QuadraticDrag(QuadraticDrag::new(one)?),
/// ];
/// // None of them adds energy: ⟨f, η⟩ ≤ 0.
/// assert!(forces.iter().all(|force| (force.force(0.0, &eta) * eta)[0] <= 1e-15));
/// let (load, swing) = (Constant::new(mu)?, Periodic::new(mu, 1.0, 0.0)?);
/// assert_eq!(swing.force(0.0, &eta), load.force(0.0, &eta));
/// let refused: Result<_, ForceError> = LinearDrag::new(one * f64::INFINITY);
/// assert!(refused.is_err());
///
/// // The two models of the paper.
/// let model: Model<f64> = models::relaxed_rigid_body();
/// assert!(!model.system.force.is_zero());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait Lagrangian<T: Real, const N: usize> {
    /// l(η).
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S;

    /// l'(η), a covector.
    fn gradient<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Covector<S, N> {
        Covector::from_fn(|_, a| {
            let moved = Vector::from_fn(|b, _| if a == b { Dual::variable(eta[b]) } else { Dual::constant(eta[b]) });
            self.value(&moved).eps
        })
    }

    /// l''(η), symmetric N×N: δη ↦ (l''(η) δη)ᵀ.
    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        let mut hessian = Matrix::<S, N>::zeros();
        for a in 0..N {
            let moved = Vector::from_fn(|b, _| if a == b { Dual::variable(eta[b]) } else { Dual::constant(eta[b]) });
            let gradient = self.gradient(&moved);
            for b in 0..N {
                hessian[(b, a)] = gradient[b].eps;
            }
        }
        hessian
    }

    /// (l')⁻¹(μ): the η with l'(η) = μ, found from `guess`.
    ///
    /// # Errors
    /// A singular Hessian, or no convergence.
    fn velocity<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        lagrangian::newton_velocity(self, mu, guess)
    }

    /// E(η) = ⟨l'(η), η⟩ − l(η).
    fn energy<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        crate::algebra::pair(&self.gradient(eta), eta) - self.value(eta)
    }
}

/// A force f(t, η) with values in g*.
pub trait Force<T: Real, const N: usize> {
    /// f(t, η).
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N>;

    /// Whether f vanishes identically: then Casimirs and orbits are kept exactly, and laws say so.
    fn is_zero(&self) -> bool {
        false
    }

    /// Whether f has all derivatives at every velocity. Quadratic drag has not, at rest: there no method has an order above 2, and
    /// laws of convergence stay away from it.
    fn is_smooth(&self) -> bool {
        true
    }
}

impl<T: Real, const N: usize, L: Lagrangian<T, N>> Lagrangian<T, N> for &L {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        (**self).value(eta)
    }

    fn gradient<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Covector<S, N> {
        (**self).gradient(eta)
    }

    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        (**self).hessian(eta)
    }

    fn velocity<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        (**self).velocity(mu, guess)
    }

    fn energy<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        (**self).energy(eta)
    }
}

impl<T: Real, const N: usize, F: Force<T, N>> Force<T, N> for &F {
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        (**self).force(t, eta)
    }

    fn is_zero(&self) -> bool {
        (**self).is_zero()
    }

    fn is_smooth(&self) -> bool {
        (**self).is_smooth()
    }
}
