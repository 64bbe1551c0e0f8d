//! Reduced Lagrangians, forces, and the forced Euler–Poincaré and Lie–Poisson equations.

use crate::algebra::{Covector, Matrix, Vector};
use crate::scalar::{Dual, Real, Scalar};

pub mod doubled;
pub mod equations;
pub mod euler_lagrange;
pub mod force;
pub mod forced_hamiltonian;
pub mod hamiltonian;
pub mod lagrangian;
pub mod lie_poisson;
pub mod models;

/// Why the Legendre transform could not be inverted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
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
}

/// A reduced Lagrangian l: g → ℝ. Only `value` is required: derivatives come from dual numbers.
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
