//! Lagrangians and forces of types that are not known here, beside spectators: see `retraction::beside`.

use super::configuration::Configuration;
use super::{Force, Lagrangian, LegendreError, at_the_identity, of_spectators};
use crate::algebra::{Covector, Matrix, Vector};
use crate::scalar::erased::{beside_one, level};
use crate::scalar::{Dual, Real, Scalar};
use std::fmt;
use std::sync::Arc;

/// A Lagrangian over S with its first derivatives, on lists.
trait LagrangianOver<S: Scalar>: Send + Sync {
    fn value(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> S;
    fn gradient(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> Vec<S>;
    fn configuration_gradient(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> Vec<S>;
    fn uses_configuration(&self) -> bool;
    fn undefined(&self, t: S::Base, g: Configuration<'_, S::Base>, eta: &[S::Base]) -> Option<String>;
}

/// What else it has.
trait LegendreOver<S: Scalar>: Send + Sync {
    fn hessian(&self, eta: &[S]) -> Vec<S>;
    fn velocity(&self, t: S, g: Configuration<'_, S>, mu: &[S], guess: &[S]) -> Result<Vec<S>, LegendreError>;
    fn energy(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> S;
}

/// A force over S, on lists.
trait ForceOver<S: Scalar>: Send + Sync {
    fn force(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> Vec<S>;
    fn uses_configuration(&self) -> bool;
    fn undefined(&self, t: S::Base, g: Configuration<'_, S::Base>, eta: &[S::Base]) -> Option<String>;
    fn is_zero(&self) -> bool;
    fn is_smooth(&self) -> bool;
}

/// A Lagrangian or a force of dimension N.
struct Typed<P, const N: usize>(P);

fn vector<S: Scalar, const N: usize>(x: &[S]) -> Vector<S, N> {
    Vector::from_column_slice(x)
}

impl<S: Scalar, L: Lagrangian<S::Base, N> + Send + Sync, const N: usize> LagrangianOver<S> for Typed<L, N> {
    fn value(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> S {
        self.0.value_at(t, g, &vector(eta))
    }

    fn gradient(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> Vec<S> {
        self.0.gradient_at(t, g, &vector(eta)).as_slice().to_vec()
    }

    fn configuration_gradient(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> Vec<S> {
        self.0.configuration_gradient(t, g, &vector(eta)).as_slice().to_vec()
    }

    fn uses_configuration(&self) -> bool {
        self.0.uses_configuration()
    }

    fn undefined(&self, t: S::Base, g: Configuration<'_, S::Base>, eta: &[S::Base]) -> Option<String> {
        self.0.undefined(t, g, &vector(eta))
    }
}

impl<S: Scalar, L: Lagrangian<S::Base, N> + Send + Sync, const N: usize> LegendreOver<S> for Typed<L, N> {
    fn hessian(&self, eta: &[S]) -> Vec<S> {
        self.0.hessian(&vector(eta)).as_slice().to_vec()
    }

    fn velocity(&self, t: S, g: Configuration<'_, S>, mu: &[S], guess: &[S]) -> Result<Vec<S>, LegendreError> {
        Ok(self.0.velocity_at(t, g, &Covector::from_row_slice(mu), &vector(guess))?.as_slice().to_vec())
    }

    fn energy(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> S {
        self.0.energy_at(t, g, &vector(eta))
    }
}

impl<S: Scalar, F: Force<S::Base, N> + Send + Sync, const N: usize> ForceOver<S> for Typed<F, N> {
    fn force(&self, t: S, g: Configuration<'_, S>, eta: &[S]) -> Vec<S> {
        self.0.force_at(t, g, &vector(eta)).as_slice().to_vec()
    }

    fn uses_configuration(&self) -> bool {
        self.0.uses_configuration()
    }

    fn undefined(&self, t: S::Base, g: Configuration<'_, S::Base>, eta: &[S::Base]) -> Option<String> {
        self.0.undefined(t, g, &vector(eta))
    }

    fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    fn is_smooth(&self) -> bool {
        self.0.is_smooth()
    }
}

/// A Lagrangian without its type and its dimension.
#[derive(Clone)]
#[allow(clippy::type_complexity, reason = "one pointer for each scalar")]
#[doc(hidden)]
pub struct UntypedLagrangian<T: Real> {
    levels: (Arc<dyn LagrangianOver<T>>, Arc<dyn LagrangianOver<Dual<T>>>, Arc<dyn LagrangianOver<Dual<Dual<T>>>>),
    legendre: (Arc<dyn LegendreOver<T>>, Arc<dyn LegendreOver<Dual<T>>>),
}

impl<T: Real> UntypedLagrangian<T> {
    /// One of dimension N.
    pub fn new<const N: usize>(lagrangian: impl Lagrangian<T, N> + Send + Sync + 'static) -> Self {
        let l = Arc::new(Typed::<_, N>(lagrangian));
        Self { levels: (l.clone(), l.clone(), l.clone()), legendre: (l.clone(), l) }
    }
}

/// A force without its type and its dimension.
#[derive(Clone)]
#[allow(clippy::type_complexity, reason = "one pointer for each scalar")]
#[doc(hidden)]
pub struct UntypedForce<T: Real> {
    levels: (Arc<dyn ForceOver<T>>, Arc<dyn ForceOver<Dual<T>>>, Arc<dyn ForceOver<Dual<Dual<T>>>>),
}

impl<T: Real> UntypedForce<T> {
    /// One of dimension N.
    pub fn new<const N: usize>(force: impl Force<T, N> + Send + Sync + 'static) -> Self {
        let f = Arc::new(Typed::<_, N>(force));
        Self { levels: (f.clone(), f.clone(), f) }
    }
}

macro_rules! given {
    ($(#[$about:meta])* $name:ident, $untyped:ident, $over:ident) => {
        $(#[$about])*
        #[derive(Clone)]
        #[doc(hidden)]
        pub struct $name<T: Real, const N: usize> {
            given: $untyped<T>,
            dimension: usize,
            size: usize,
        }

        impl<T: Real, const N: usize> $name<T, N> {
            /// It beside N − n spectators, on matrices of which the first `size` rows and columns are its group's.
            pub fn new(given: $untyped<T>, dimension: usize, size: usize) -> Self {
                Self { given, dimension, size }
            }

            fn over<S: Scalar<Base = T>>(&self) -> &Arc<dyn $over<S>> {
                const { assert!(S::NESTING <= 2) }
                let (number, dual, second) = &self.given.levels;
                level(&[number, dual, second])
            }

            fn uses_g(&self) -> bool {
                self.given.levels.0.uses_configuration()
            }

            /// What `f` makes of the first rows and columns of g, if anything depends on g.
            fn on<S: Scalar<Base = T>, O>(
                &self,
                g: Configuration<'_, S>,
                depends: bool,
                f: impl FnOnce(Configuration<'_, S>) -> O,
            ) -> O {
                let size = if depends { self.size.min(g.size()) } else { 0 };
                let entries: Vec<S> = (0..size * size).map(|k| g.entry(k % size, k / size)).collect();
                f(Configuration::sized(&entries, size))
            }

            fn leading<'a, S>(&self, x: &'a [S]) -> &'a [S] {
                &x[..self.dimension]
            }
        }

        impl<T: Real, const N: usize> fmt::Debug for $name<T, N> {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, concat!(stringify!($name), " of dimension {}"), self.dimension)
            }
        }

        /// Whether it is the same thing.
        impl<T: Real, const N: usize> PartialEq for $name<T, N> {
            fn eq(&self, other: &Self) -> bool {
                (self.dimension, self.size) == (other.dimension, other.size)
                    && Arc::ptr_eq(&self.given.levels.0, &other.given.levels.0)
            }
        }
    };
}

given!(
    /// A Lagrangian whose type is not known, of the first n of N coordinates; the others are those of spectators with unit inertia.
    GivenLagrangian, UntypedLagrangian, LagrangianOver
);
given!(
    /// A force whose type is not known, on the first n of N coordinates; none acts on spectators.
    GivenForce, UntypedForce, ForceOver
);

impl<T: Real, const N: usize> GivenLagrangian<T, N> {
    fn legendre<S: Scalar<Base = T>>(&self) -> &Arc<dyn LegendreOver<S>> {
        const { assert!(S::NESTING <= 1) }
        let (number, dual) = &self.given.legendre;
        level(&[number, dual])
    }

    /// The first n components from `numbers`, the others those of x.
    fn beside<S: Scalar>(&self, numbers: &[S], x: &[S]) -> Vector<S, N> {
        Vector::from_fn(|a, _| if a < self.dimension { numbers[a] } else { x[a] })
    }
}

/// The first components, and 0 for those of spectators.
fn beside_zeros<S: Scalar, const N: usize>(numbers: &[S]) -> Covector<S, N> {
    Covector::from_fn(|_, a| numbers.get(a).copied().unwrap_or_else(S::zero))
}

impl<T: Real, const N: usize> Lagrangian<T, N> for GivenLagrangian<T, N> {
    at_the_identity!(lagrangian);

    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        beside_one(&self.legendre().hessian(self.leading(eta.as_slice())), self.dimension, S::one())
    }

    fn uses_configuration(&self) -> bool {
        self.uses_g()
    }

    fn value_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        let leading = self.leading(eta.as_slice());
        self.on(g, self.uses_g(), |g| self.over().value(t, g, leading)) + of_spectators(eta, self.dimension)
    }

    fn gradient_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        let gradient = self.on(g, self.uses_g(), |g| self.over().gradient(t, g, self.leading(eta.as_slice())));
        self.beside(&gradient, eta.as_slice()).transpose()
    }

    fn velocity_at<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        let (leading, near) = (self.leading(mu.as_slice()), self.leading(guess.as_slice()));
        let velocity = self.on(g, self.uses_g(), |g| self.legendre().velocity(t, g, leading, near))?;
        Ok(self.beside(&velocity, mu.as_slice()))
    }

    fn energy_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        let leading = self.leading(eta.as_slice());
        self.on(g, self.uses_g(), |g| self.legendre().energy(t, g, leading)) + of_spectators(eta, self.dimension)
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        self.on(g, true, |g| self.over::<T>().undefined(t, g, self.leading(eta.as_slice())))
    }

    fn configuration_gradient<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
    ) -> Covector<S, N> {
        let leading = self.leading(eta.as_slice());
        beside_zeros(&self.on(g, self.uses_g(), |g| self.over().configuration_gradient(t, g, leading)))
    }
}

impl<T: Real, const N: usize> Force<T, N> for GivenForce<T, N> {
    at_the_identity!(force);

    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        beside_zeros(&self.on(g, self.uses_g(), |g| self.over().force(t, g, self.leading(eta.as_slice()))))
    }

    fn uses_configuration(&self) -> bool {
        self.uses_g()
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        self.on(g, true, |g| self.over::<T>().undefined(t, g, self.leading(eta.as_slice())))
    }

    fn is_zero(&self) -> bool {
        self.given.levels.0.is_zero()
    }

    fn is_smooth(&self) -> bool {
        self.given.levels.0.is_smooth()
    }
}
