//! Reduced Lagrangians, forces, and the forced Euler–Poincaré and Lie–Poisson equations.
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/mechanics.md"))]

use crate::algebra::{Covector, Matrix, Vector, pair};
use crate::scalar::{Dual, Real, Scalar, dual};
use configuration::Configuration;

pub mod configuration;
pub mod doubled;
pub mod equations;
pub mod euler_lagrange;
pub mod force;
pub mod forced_hamiltonian;
pub mod formula;
#[cfg(feature = "harness")]
#[doc(hidden)]
pub mod given;
pub mod hamiltonian;
pub mod lagrangian;
mod legendre;
pub mod lie_poisson;
pub mod models;

/// Why the Legendre transform could not be inverted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LegendreError {
    /// l'' is singular to working precision where it was needed.
    #[error(
        "the Legendre transform is not invertible: the Hessian of the Lagrangian by the velocity is singular{} at the velocity {velocity:?}, \
         so that the momentum does not determine the velocity", of_rank(.rank, velocity.len())
    )]
    Singular {
        /// The velocity η at which l''(η) is singular.
        velocity: Vec<f64>,
        /// The rank of l''(η), where it is known.
        rank: Option<usize>,
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

fn of_rank(rank: &Option<usize>, n: usize) -> String {
    rank.map_or_else(String::new, |rank| format!(" (its rank is {rank}, not {n})"))
}

/// ½|η|² of the components beyond n, those of spectators.
fn of_spectators<S: Scalar, const N: usize>(eta: &Vector<S, N>, n: usize) -> S {
    let alone = Vector::<S, N>::from_fn(|a, _| if a < n { S::zero() } else { eta[a] });
    pair(&alone.transpose(), &alone) * S::half()
}

/// l'' from l' on dual numbers, column by column.
fn hessian_by_duals<S: Scalar, const N: usize>(
    eta: &Vector<S, N>,
    gradient: impl Fn(&Vector<Dual<S>, N>) -> Covector<Dual<S>, N>,
) -> Matrix<S, N> {
    let mut hessian = Matrix::<S, N>::zeros();
    for a in 0..N {
        hessian.set_column(a, &gradient(&dual::along(eta, a)).transpose().map(|v| v.eps));
    }
    hessian
}

/// A reduced Lagrangian l: g → ℝ. Only `value` is required: derivatives come from dual numbers.
///
/// ```
/// use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Vector};
/// use euler_poincare::mechanics::equations::EulerPoincare;
/// use euler_poincare::mechanics::{Force, Lagrangian};
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
/// let system = EulerPoincare::new(so3, Stiff, Friction);
/// let mu: Covector<f64, 3> = system.lagrangian.gradient(&eta);
/// let rates = system.rates(0.0, &mu, &Vector::zeros())?;
/// assert!((mu - 2.0 * eta.transpose()).amax() < 1e-15 && (rates.velocity - eta).amax() < 1e-14);
/// assert!((rates.momentum + eta.transpose()).amax() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a Lagrangian on an algebra of dimension {N}",
    note = "implement `Lagrangian<T, {N}>`: `fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, {N}>) -> S`",
    note = "one that depends on the configuration is a `LagrangianOnGroup` in `LagrangianOn`, or has a potential: `WithPotential`"
)]
pub trait Lagrangian<T: Real, const N: usize> {
    /// l(η).
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S;

    /// l'(η), a covector.
    fn gradient<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Covector<S, N> {
        Covector::from_fn(|_, a| self.value(&dual::along(eta, a)).eps)
    }

    /// l''(η), symmetric N×N: δη ↦ (l''(η) δη)ᵀ.
    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        hessian_by_duals(eta, |eta| self.gradient(eta))
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
        legendre::invert(self, mu, guess)
    }

    /// E(η) = ⟨l'(η), η⟩ − l(η).
    fn energy<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        pair(&self.gradient(eta), eta) - self.value(eta)
    }

    /// Whether L depends on the configuration g, or on the time: see [`configuration`]. Then what the methods above say is true at
    /// t = 0 and g = e, and the methods below say the rest.
    fn uses_configuration(&self) -> bool {
        false
    }

    /// L(t, g, η).
    fn value_at<S: Scalar<Base = T>>(&self, _t: S, _g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        self.value(eta)
    }

    /// ∂L/∂η at (t, g, η).
    fn gradient_at<S: Scalar<Base = T>>(&self, _t: S, _g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        self.gradient(eta)
    }

    /// The η with ∂L/∂η(t, g, η) = μ, found from `guess`.
    ///
    /// # Errors
    /// A singular Hessian, or no convergence.
    fn velocity_at<S: Scalar<Base = T>>(
        &self,
        _t: S,
        _g: Configuration<'_, S>,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        self.velocity(mu, guess)
    }

    /// E(t, g, η) = ⟨∂L/∂η, η⟩ − L.
    fn energy_at<S: Scalar<Base = T>>(&self, _t: S, _g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        self.energy(eta)
    }

    /// Why L or ∂_gL has no finite value at (t, g, η), if it is known.
    fn undefined(&self, _t: T, _g: Configuration<'_, T>, _eta: &Vector<T, N>) -> Option<String> {
        None
    }

    /// ∂_gL at (t, g, η), left-trivialised: ⟨∂_gL, ξ⟩ = d/ds L(t, g exp(sξ), η).
    fn configuration_gradient<S: Scalar<Base = T>>(
        &self,
        _t: S,
        _g: Configuration<'_, S>,
        _eta: &Vector<S, N>,
    ) -> Covector<S, N> {
        Covector::zeros()
    }
}

/// A force with values in g*: f(t, η), or f(t, g, η).
///
/// One that depends on the configuration g is a [`ForceOnGroup`](configuration::ForceOnGroup) in an
/// [`OnGroup`](configuration::OnGroup). A pair `(f₁, f₂)` of forces is their sum.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a force on an algebra of dimension {N}",
    note = "implement `Force<T, {N}>`: `fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, {N}>) -> Covector<S, {N}>`",
    note = "one that depends on the configuration is a `ForceOnGroup` in `OnGroup`; a closure on `f64` goes into a `BlackBox`"
)]
pub trait Force<T: Real, const N: usize> {
    /// f(t, η).
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N>;

    /// f(t, g, η).
    fn force_at<S: Scalar<Base = T>>(&self, t: S, _g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        self.force(t, eta)
    }

    /// Whether f depends on the configuration g. Then `force` is that at g = e.
    fn uses_configuration(&self) -> bool {
        false
    }

    /// Why f has no finite value at (t, g, η), if it is known.
    fn undefined(&self, _t: T, _g: Configuration<'_, T>, _eta: &Vector<T, N>) -> Option<String> {
        None
    }

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

/// The methods without a place of a force or a Lagrangian that says what it is at each: at g = e, and for a Lagrangian at t = 0.
macro_rules! at_the_identity {
    (force) => {
        fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
            self.force_at(t, Configuration::identity(), eta)
        }
    };
    (lagrangian) => {
        fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
            self.value_at(S::zero(), Configuration::identity(), eta)
        }

        fn gradient<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Covector<S, N> {
            self.gradient_at(S::zero(), Configuration::identity(), eta)
        }

        fn velocity<S: Scalar<Base = T>>(
            &self,
            mu: &Covector<S, N>,
            guess: &Vector<S, N>,
        ) -> Result<Vector<S, N>, LegendreError> {
            self.velocity_at(S::zero(), Configuration::identity(), mu, guess)
        }

        fn energy<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
            self.energy_at(S::zero(), Configuration::identity(), eta)
        }
    };
}

/// The named methods of a Lagrangian, those of a part of it, which `$dispatch!(self, part => …)` finds.
macro_rules! passed_on {
    ($dispatch:ident: $($method:ident),*) => {
        $($crate::mechanics::passed_on!(@ $method $dispatch);)*
    };
    (@ hessian $dispatch:ident) => {
        fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
            $dispatch!(self, part => Lagrangian::<T, N>::hessian(part, eta))
        }
    };
    (@ uses_configuration $dispatch:ident) => {
        fn uses_configuration(&self) -> bool {
            $dispatch!(self, part => Lagrangian::<T, N>::uses_configuration(part))
        }
    };
    (@ value_at $dispatch:ident) => {
        fn value_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
            $dispatch!(self, part => Lagrangian::<T, N>::value_at(part, t, g, eta))
        }
    };
    (@ gradient_at $dispatch:ident) => {
        fn gradient_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
            $dispatch!(self, part => Lagrangian::<T, N>::gradient_at(part, t, g, eta))
        }
    };
    (@ velocity_at $dispatch:ident) => {
        fn velocity_at<S: Scalar<Base = T>>(
            &self,
            t: S,
            g: Configuration<'_, S>,
            mu: &Covector<S, N>,
            guess: &Vector<S, N>,
        ) -> Result<Vector<S, N>, LegendreError> {
            $dispatch!(self, part => Lagrangian::<T, N>::velocity_at(part, t, g, mu, guess))
        }
    };
    (@ energy_at $dispatch:ident) => {
        fn energy_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
            $dispatch!(self, part => Lagrangian::<T, N>::energy_at(part, t, g, eta))
        }
    };
    (@ undefined $dispatch:ident) => {
        fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
            $dispatch!(self, part => Lagrangian::<T, N>::undefined(part, t, g, eta))
        }
    };
    (@ configuration_gradient $dispatch:ident) => {
        fn configuration_gradient<S: Scalar<Base = T>>(
            &self,
            t: S,
            g: Configuration<'_, S>,
            eta: &Vector<S, N>,
        ) -> Covector<S, N> {
            $dispatch!(self, part => Lagrangian::<T, N>::configuration_gradient(part, t, g, eta))
        }
    };
}

/// A Lagrangian whose methods are all those of a part of it.
macro_rules! delegated_lagrangian {
    ([$($generics:tt)*] $holder:ty, $dispatch:ident) => {
        impl<$($generics)*> Lagrangian<T, N> for $holder {
            $crate::mechanics::at_the_identity!(lagrangian);
            $crate::mechanics::passed_on!(
                $dispatch: hessian, uses_configuration, value_at, gradient_at, velocity_at, energy_at, undefined,
                configuration_gradient
            );
        }
    };
}

/// The part of a Lagrangian that is another one and something beside it.
macro_rules! body {
    ($holder:ident, $part:ident => $value:expr) => {{
        let $part = &$holder.body;
        $value
    }};
}

/// A force whose methods are all those of a part of it.
macro_rules! delegated_force {
    ([$($generics:tt)*] $holder:ty, $dispatch:ident) => {
        impl<$($generics)*> Force<T, N> for $holder {
            $crate::mechanics::at_the_identity!(force);

            fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
                $dispatch!(self, part => Force::<T, N>::force_at(part, t, g, eta))
            }

            fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
                $dispatch!(self, part => Force::<T, N>::undefined(part, t, g, eta))
            }

            fn uses_configuration(&self) -> bool {
                $dispatch!(self, part => Force::<T, N>::uses_configuration(part))
            }

            fn is_zero(&self) -> bool {
                $dispatch!(self, part => Force::<T, N>::is_zero(part))
            }

            fn is_smooth(&self) -> bool {
                $dispatch!(self, part => Force::<T, N>::is_smooth(part))
            }
        }
    };
}

/// What is chosen at run time: what becomes one, and its methods, which are those of what it is.
macro_rules! any {
    ($any:ident by $delegated:ident: $($variant:ident($of:ty)),*; $($more:ident),*) => {
        $(impl<T: Real, const N: usize> From<$of> for $any<T, N> {
            fn from(chosen: $of) -> Self {
                Self::$variant(chosen.into())
            }
        })*

        macro_rules! dispatch {
            ($chosen:ident, $part:ident => $value:expr) => {
                match $chosen {
                    $($any::$variant($part) => $value,)*
                    $($any::$more($part) => $value,)*
                    #[cfg(feature = "harness")]
                    $any::Given($part) => $value,
                }
            };
        }

        $crate::mechanics::$delegated!([T: Real, const N: usize] $any<T, N>, dispatch);
    };
}
use {any, at_the_identity, body, delegated_force, delegated_lagrangian, passed_on};

macro_rules! pointee {
    ($holder:ident, $part:ident => $value:expr) => {{
        let $part = &**$holder;
        $value
    }};
}

/// For pointers: their methods are those of what they point to.
macro_rules! forwarded {
    ($($pointer:ty),*) => {$(
        delegated_lagrangian!([T: Real, const N: usize, P: Lagrangian<T, N>] $pointer, pointee);
        delegated_force!([T: Real, const N: usize, P: Force<T, N>] $pointer, pointee);
    )*};
}

forwarded!(&P, Box<P>, std::sync::Arc<P>);

/// The sum of two forces.
impl<T: Real, const N: usize, A: Force<T, N>, B: Force<T, N>> Force<T, N> for (A, B) {
    at_the_identity!(force);

    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        self.0.force_at(t, g, eta) + self.1.force_at(t, g, eta)
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        self.0.undefined(t, g, eta).or_else(|| self.1.undefined(t, g, eta))
    }

    fn uses_configuration(&self) -> bool {
        self.0.uses_configuration() || self.1.uses_configuration()
    }

    fn is_zero(&self) -> bool {
        self.0.is_zero() && self.1.is_zero()
    }

    fn is_smooth(&self) -> bool {
        self.0.is_smooth() && self.1.is_smooth()
    }
}

/// The sum of any number of forces.
impl<T: Real, const N: usize, F: Force<T, N>> Force<T, N> for Vec<F> {
    at_the_identity!(force);

    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        self.iter().fold(Covector::zeros(), |sum, term| sum + term.force_at(t, g, eta))
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        self.iter().find_map(|term| term.undefined(t, g, eta))
    }

    fn uses_configuration(&self) -> bool {
        self.iter().any(|term| term.uses_configuration())
    }

    fn is_zero(&self) -> bool {
        self.iter().all(|term| term.is_zero())
    }

    fn is_smooth(&self) -> bool {
        self.iter().all(|term| term.is_smooth())
    }
}
