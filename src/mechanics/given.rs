//! Lagrangians and forces of types that are not known here, beside spectators: see `retraction::given`.

use super::configuration::Configuration;
use super::{Force, Lagrangian, LegendreError, at_the_identity};
use crate::algebra::{Covector, Matrix, Vector, pair};
use crate::scalar::erased::{beside_one, in_scalar, matrix, numbers, scalar};
use crate::scalar::{Real, Scalar};
use std::fmt;
use std::sync::Arc;

/// A Lagrangian on lists of numbers, of scalars with as many dual numbers as `nesting` says.
#[doc(hidden)]
pub trait UntypedLagrangian<T: Real>: Send + Sync {
    /// What is asked of L.
    fn ask(&self, what: Asked, nesting: u32, place: &UntypedPlace<T>, eta: &[T]) -> Vec<T>;

    /// [`Lagrangian::hessian`].
    fn hessian(&self, nesting: u32, eta: &[T]) -> Vec<T>;

    /// [`Lagrangian::velocity_at`].
    ///
    /// # Errors
    /// Those of `velocity_at`.
    fn velocity(&self, nesting: u32, place: &UntypedPlace<T>, mu: &[T], guess: &[T]) -> Result<Vec<T>, LegendreError>;

    /// [`Lagrangian::energy_at`].
    fn energy(&self, nesting: u32, place: &UntypedPlace<T>, eta: &[T]) -> Vec<T>;

    /// [`Lagrangian::uses_configuration`].
    fn uses_configuration(&self) -> bool;

    /// [`Lagrangian::undefined`].
    fn undefined(&self, place: &UntypedPlace<T>, eta: &[T]) -> Option<String>;
}

/// What is asked of a Lagrangian with up to two dual numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[doc(hidden)]
pub enum Asked {
    /// [`Lagrangian::value_at`].
    Value,
    /// [`Lagrangian::gradient_at`].
    Gradient,
    /// [`Lagrangian::configuration_gradient`].
    ConfigurationGradient,
}

/// A time and the first rows and columns of an element of the group, as lists of numbers.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct UntypedPlace<T> {
    /// t.
    time: Vec<T>,
    /// g, by columns; none: the identity.
    entries: Vec<T>,
    /// The number of its rows.
    size: usize,
}

impl<T: Real> UntypedPlace<T> {
    fn of<S: Scalar<Base = T>>(t: S, g: Configuration<'_, S>, size: usize) -> Self {
        let size = size.min(g.size());
        let entries: Vec<S> = (0..size * size).map(|k| g.entry(k % size, k / size)).collect();
        Self { time: numbers(&[t]), entries: numbers(&entries), size }
    }

    /// What `f` makes of the time and the entries in a scalar.
    fn read<S: Scalar<Base = T>, O>(&self, f: impl FnOnce(S, Configuration<'_, S>) -> O) -> O {
        let entries: Vec<S> = (0..self.size * self.size).map(|k| scalar(&self.entries, k)).collect();
        f(scalar(&self.time, 0), Configuration::sized(&entries, self.size))
    }
}

/// A force on lists of numbers, of scalars with as many dual numbers as `nesting` says.
#[doc(hidden)]
pub trait UntypedForce<T: Real>: Send + Sync {
    /// [`Force::force_at`].
    fn force(&self, nesting: u32, place: &UntypedPlace<T>, eta: &[T]) -> Vec<T>;

    /// [`Force::uses_configuration`].
    fn uses_configuration(&self) -> bool;

    /// [`Force::undefined`].
    fn undefined(&self, place: &UntypedPlace<T>, eta: &[T]) -> Option<String>;

    /// [`Force::is_zero`].
    fn is_zero(&self) -> bool;

    /// [`Force::is_smooth`].
    fn is_smooth(&self) -> bool;
}

/// A Lagrangian or a force of dimension N without its type.
pub(crate) struct Untyped<P, const N: usize>(pub P);

impl<P, const N: usize> Untyped<P, N> {
    fn ask_in<S: Scalar>(&self, what: Asked, place: &UntypedPlace<S::Base>, eta: &[S::Base]) -> Vec<S::Base>
    where
        P: Lagrangian<S::Base, N>,
    {
        let (l, eta) = (&self.0, matrix::<S, N, 1>(eta));
        place.read(|t, g| match what {
            Asked::Value => numbers(&[l.value_at(t, g, &eta)]),
            Asked::Gradient => numbers(l.gradient_at(t, g, &eta).as_slice()),
            Asked::ConfigurationGradient => numbers(l.configuration_gradient(t, g, &eta).as_slice()),
        })
    }

    fn hessian_in<S: Scalar>(&self, eta: &[S::Base]) -> Vec<S::Base>
    where
        P: Lagrangian<S::Base, N>,
    {
        numbers(self.0.hessian::<S>(&matrix(eta)).as_slice())
    }

    fn velocity_in<S: Scalar>(
        &self,
        place: &UntypedPlace<S::Base>,
        mu: &[S::Base],
        guess: &[S::Base],
    ) -> Result<Vec<S::Base>, LegendreError>
    where
        P: Lagrangian<S::Base, N>,
    {
        let velocity = place.read::<S, _>(|t, g| self.0.velocity_at(t, g, &matrix(mu), &matrix(guess)))?;
        Ok(numbers(velocity.as_slice()))
    }

    fn energy_in<S: Scalar>(&self, place: &UntypedPlace<S::Base>, eta: &[S::Base]) -> Vec<S::Base>
    where
        P: Lagrangian<S::Base, N>,
    {
        place.read::<S, _>(|t, g| numbers(&[self.0.energy_at(t, g, &matrix(eta))]))
    }

    fn force_in<S: Scalar>(&self, place: &UntypedPlace<S::Base>, eta: &[S::Base]) -> Vec<S::Base>
    where
        P: Force<S::Base, N>,
    {
        place.read::<S, _>(|t, g| numbers(self.0.force_at(t, g, &matrix(eta)).as_slice()))
    }
}

impl<T: Real, L: Lagrangian<T, N> + Send + Sync, const N: usize> UntypedLagrangian<T> for Untyped<L, N> {
    fn ask(&self, what: Asked, nesting: u32, place: &UntypedPlace<T>, eta: &[T]) -> Vec<T> {
        in_scalar!(0..=2, nesting, T, self, ask_in(what, place, eta))
    }

    fn hessian(&self, nesting: u32, eta: &[T]) -> Vec<T> {
        in_scalar!(0..=1, nesting, T, self, hessian_in(eta))
    }

    fn velocity(&self, nesting: u32, place: &UntypedPlace<T>, mu: &[T], guess: &[T]) -> Result<Vec<T>, LegendreError> {
        in_scalar!(0..=1, nesting, T, self, velocity_in(place, mu, guess))
    }

    fn energy(&self, nesting: u32, place: &UntypedPlace<T>, eta: &[T]) -> Vec<T> {
        in_scalar!(0..=1, nesting, T, self, energy_in(place, eta))
    }

    fn uses_configuration(&self) -> bool {
        self.0.uses_configuration()
    }

    fn undefined(&self, place: &UntypedPlace<T>, eta: &[T]) -> Option<String> {
        place.read::<T, _>(|t, g| self.0.undefined(t, g, &matrix(eta)))
    }
}

impl<T: Real, F: Force<T, N> + Send + Sync, const N: usize> UntypedForce<T> for Untyped<F, N> {
    fn force(&self, nesting: u32, place: &UntypedPlace<T>, eta: &[T]) -> Vec<T> {
        in_scalar!(0..=2, nesting, T, self, force_in(place, eta))
    }

    fn uses_configuration(&self) -> bool {
        self.0.uses_configuration()
    }

    fn undefined(&self, place: &UntypedPlace<T>, eta: &[T]) -> Option<String> {
        place.read::<T, _>(|t, g| self.0.undefined(t, g, &matrix(eta)))
    }

    fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    fn is_smooth(&self) -> bool {
        self.0.is_smooth()
    }
}

/// A Lagrangian whose type is not known, of the first n of N coordinates; the others are those of spectators with unit inertia.
#[derive(Clone)]
#[doc(hidden)]
pub struct GivenLagrangian<T: Real, const N: usize> {
    given: Arc<dyn UntypedLagrangian<T>>,
    dimension: usize,
    size: usize,
}

/// A force whose type is not known, on the first n of N coordinates; none acts on spectators.
#[derive(Clone)]
#[doc(hidden)]
pub struct GivenForce<T: Real, const N: usize> {
    given: Arc<dyn UntypedForce<T>>,
    dimension: usize,
    size: usize,
}

macro_rules! given {
    ($name:ident, $untyped:ident) => {
        impl<T: Real, const N: usize> $name<T, N> {
            /// It beside N − n spectators, on matrices of which the first `size` rows and columns are its group's.
            pub(crate) fn new(given: Arc<dyn $untyped<T>>, dimension: usize, size: usize) -> Self {
                Self { given, dimension, size }
            }

            fn leading<S: Scalar<Base = T>>(&self, x: &[S]) -> Vec<T> {
                numbers(&x[..self.dimension])
            }

            /// With g where anything depends on it.
            fn place<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>) -> UntypedPlace<T> {
                UntypedPlace::of(t, g, if self.given.uses_configuration() { self.size } else { 0 })
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
                (self.dimension, self.size) == (other.dimension, other.size) && Arc::ptr_eq(&self.given, &other.given)
            }
        }
    };
}

given!(GivenLagrangian, UntypedLagrangian);
given!(GivenForce, UntypedForce);

impl<T: Real, const N: usize> GivenLagrangian<T, N> {
    /// A Lagrangian of dimension n, which does not depend on the configuration, beside N − n spectators.
    pub fn of<const LESS: usize>(lagrangian: impl Lagrangian<T, LESS> + Send + Sync + 'static) -> Self {
        const { assert!(LESS <= N) }
        Self::new(Arc::new(Untyped::<_, LESS>(lagrangian)), LESS, 0)
    }

    /// The first n components from `numbers`, the others those of x.
    fn beside<S: Scalar<Base = T>>(&self, numbers: &[T], x: &[S]) -> Vector<S, N> {
        Vector::from_fn(|a, _| if a < self.dimension { scalar(numbers, a) } else { x[a] })
    }

    fn ask<S: Scalar<Base = T>>(&self, what: Asked, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Vec<T> {
        const { assert!(S::NESTING <= 2) }
        self.given.ask(what, S::NESTING, &self.place(t, g), &self.leading(eta.as_slice()))
    }

    /// ½|η|² of the spectators.
    fn spectators<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        let alone = Vector::<S, N>::from_fn(|a, _| if a < self.dimension { S::zero() } else { eta[a] });
        pair(&alone.transpose(), &alone) * S::half()
    }
}

impl<T: Real, const N: usize> Lagrangian<T, N> for GivenLagrangian<T, N> {
    at_the_identity!(lagrangian);

    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        const { assert!(S::NESTING <= 1) }
        beside_one(&self.given.hessian(S::NESTING, &self.leading(eta.as_slice())), self.dimension, S::one())
    }

    fn uses_configuration(&self) -> bool {
        self.given.uses_configuration()
    }

    fn value_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        scalar::<S>(&self.ask(Asked::Value, t, g, eta), 0) + self.spectators(eta)
    }

    fn gradient_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        self.beside(&self.ask(Asked::Gradient, t, g, eta), eta.as_slice()).transpose()
    }

    fn velocity_at<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        const { assert!(S::NESTING <= 1) }
        let (leading, near) = (self.leading(mu.as_slice()), self.leading(guess.as_slice()));
        let velocity = self.given.velocity(S::NESTING, &self.place(t, g), &leading, &near)?;
        Ok(self.beside(&velocity, mu.as_slice()))
    }

    fn energy_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> S {
        const { assert!(S::NESTING <= 1) }
        let energy = self.given.energy(S::NESTING, &self.place(t, g), &self.leading(eta.as_slice()));
        scalar::<S>(&energy, 0) + self.spectators(eta)
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        self.given.undefined(&UntypedPlace::of(t, g, self.size), &self.leading(eta.as_slice()))
    }

    fn configuration_gradient<S: Scalar<Base = T>>(
        &self,
        t: S,
        g: Configuration<'_, S>,
        eta: &Vector<S, N>,
    ) -> Covector<S, N> {
        matrix(&self.ask(Asked::ConfigurationGradient, t, g, eta))
    }
}

impl<T: Real, const N: usize> GivenForce<T, N> {
    /// A force of dimension n, which does not depend on the configuration, beside N − n spectators.
    pub fn of<const LESS: usize>(force: impl Force<T, LESS> + Send + Sync + 'static) -> Self {
        const { assert!(LESS <= N) }
        Self::new(Arc::new(Untyped::<_, LESS>(force)), LESS, 0)
    }
}

impl<T: Real, const N: usize> Force<T, N> for GivenForce<T, N> {
    at_the_identity!(force);

    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        const { assert!(S::NESTING <= 2) }
        matrix(&self.given.force(S::NESTING, &self.place(t, g), &self.leading(eta.as_slice())))
    }

    fn uses_configuration(&self) -> bool {
        self.given.uses_configuration()
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        self.given.undefined(&UntypedPlace::of(t, g, self.size), &self.leading(eta.as_slice()))
    }

    fn is_zero(&self) -> bool {
        self.given.is_zero()
    }

    fn is_smooth(&self) -> bool {
        self.given.is_smooth()
    }
}
