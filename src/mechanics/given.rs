//! Lagrangians and forces of types that are not known here, beside spectators: see `retraction::given`.

use super::{Force, Lagrangian, LegendreError};
use crate::algebra::{Covector, Matrix, Vector, pair};
use crate::scalar::erased::{in_scalar, matrix, numbers, scalar};
use crate::scalar::{Real, Scalar};
use std::fmt;
use std::sync::Arc;

/// A Lagrangian on lists of numbers, of scalars with as many dual numbers as `nesting` says.
#[doc(hidden)]
pub trait UntypedLagrangian<T: Real>: Send + Sync {
    /// [`Lagrangian::value`].
    fn value(&self, nesting: u32, eta: &[T]) -> Vec<T>;

    /// [`Lagrangian::gradient`].
    fn gradient(&self, nesting: u32, eta: &[T]) -> Vec<T>;

    /// [`Lagrangian::hessian`].
    fn hessian(&self, nesting: u32, eta: &[T]) -> Vec<T>;

    /// [`Lagrangian::velocity`].
    ///
    /// # Errors
    /// Those of `velocity`.
    fn velocity(&self, nesting: u32, mu: &[T], guess: &[T]) -> Result<Vec<T>, LegendreError>;

    /// [`Lagrangian::energy`].
    fn energy(&self, nesting: u32, eta: &[T]) -> Vec<T>;
}

/// A force on lists of numbers, of scalars with as many dual numbers as `nesting` says.
#[doc(hidden)]
pub trait UntypedForce<T: Real>: Send + Sync {
    /// [`Force::force`].
    fn force(&self, nesting: u32, t: &[T], eta: &[T]) -> Vec<T>;

    /// [`Force::is_zero`].
    fn is_zero(&self) -> bool;

    /// [`Force::is_smooth`].
    fn is_smooth(&self) -> bool;
}

/// A Lagrangian or a force of dimension N without its type.
pub(crate) struct Untyped<P, const N: usize>(pub P);

impl<P, const N: usize> Untyped<P, N> {
    fn value_in<S: Scalar>(&self, eta: &[S::Base]) -> Vec<S::Base>
    where
        P: Lagrangian<S::Base, N>,
    {
        numbers(&[self.0.value::<S>(&matrix(eta))])
    }

    fn gradient_in<S: Scalar>(&self, eta: &[S::Base]) -> Vec<S::Base>
    where
        P: Lagrangian<S::Base, N>,
    {
        numbers(self.0.gradient::<S>(&matrix(eta)).as_slice())
    }

    fn hessian_in<S: Scalar>(&self, eta: &[S::Base]) -> Vec<S::Base>
    where
        P: Lagrangian<S::Base, N>,
    {
        numbers(self.0.hessian::<S>(&matrix(eta)).as_slice())
    }

    fn velocity_in<S: Scalar>(&self, mu: &[S::Base], guess: &[S::Base]) -> Result<Vec<S::Base>, LegendreError>
    where
        P: Lagrangian<S::Base, N>,
    {
        Ok(numbers(self.0.velocity::<S>(&matrix(mu), &matrix(guess))?.as_slice()))
    }

    fn energy_in<S: Scalar>(&self, eta: &[S::Base]) -> Vec<S::Base>
    where
        P: Lagrangian<S::Base, N>,
    {
        numbers(&[self.0.energy::<S>(&matrix(eta))])
    }

    fn force_in<S: Scalar>(&self, t: &[S::Base], eta: &[S::Base]) -> Vec<S::Base>
    where
        P: Force<S::Base, N>,
    {
        numbers(self.0.force::<S>(scalar(t, 0), &matrix(eta)).as_slice())
    }
}

impl<T: Real, L: Lagrangian<T, N> + Send + Sync, const N: usize> UntypedLagrangian<T> for Untyped<L, N> {
    fn value(&self, nesting: u32, eta: &[T]) -> Vec<T> {
        in_scalar!(0..=2, nesting, T, self, value_in(eta))
    }

    fn gradient(&self, nesting: u32, eta: &[T]) -> Vec<T> {
        in_scalar!(0..=2, nesting, T, self, gradient_in(eta))
    }

    fn hessian(&self, nesting: u32, eta: &[T]) -> Vec<T> {
        in_scalar!(0..=1, nesting, T, self, hessian_in(eta))
    }

    fn velocity(&self, nesting: u32, mu: &[T], guess: &[T]) -> Result<Vec<T>, LegendreError> {
        in_scalar!(0..=1, nesting, T, self, velocity_in(mu, guess))
    }

    fn energy(&self, nesting: u32, eta: &[T]) -> Vec<T> {
        in_scalar!(0..=1, nesting, T, self, energy_in(eta))
    }
}

impl<T: Real, F: Force<T, N> + Send + Sync, const N: usize> UntypedForce<T> for Untyped<F, N> {
    fn force(&self, nesting: u32, t: &[T], eta: &[T]) -> Vec<T> {
        in_scalar!(0..=2, nesting, T, self, force_in(t, eta))
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
}

/// A force whose type is not known, on the first n of N coordinates; none acts on spectators.
#[derive(Clone)]
#[doc(hidden)]
pub struct GivenForce<T: Real, const N: usize> {
    given: Arc<dyn UntypedForce<T>>,
    dimension: usize,
}

macro_rules! given {
    ($name:ident, $untyped:ident) => {
        impl<T: Real, const N: usize> $name<T, N> {
            /// It beside N − n spectators.
            pub(crate) fn new(given: Arc<dyn $untyped<T>>, dimension: usize) -> Self {
                Self { given, dimension }
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
                self.dimension == other.dimension && Arc::ptr_eq(&self.given, &other.given)
            }
        }
    };
}

given!(GivenLagrangian, UntypedLagrangian);
given!(GivenForce, UntypedForce);

impl<T: Real, const N: usize> GivenLagrangian<T, N> {
    /// A Lagrangian of dimension n beside N − n spectators.
    pub fn of<const LESS: usize>(lagrangian: impl Lagrangian<T, LESS> + Send + Sync + 'static) -> Self {
        const { assert!(LESS <= N) }
        Self::new(Arc::new(Untyped::<_, LESS>(lagrangian)), LESS)
    }

    fn leading<S: Scalar<Base = T>>(&self, x: &[S]) -> Vec<T> {
        numbers(&x[..self.dimension])
    }

    /// The first n components from `numbers`, the others those of x.
    fn beside<S: Scalar<Base = T>>(&self, numbers: &[T], x: &[S]) -> Vector<S, N> {
        Vector::from_fn(|a, _| if a < self.dimension { scalar(numbers, a) } else { x[a] })
    }

    /// ½|η|² of the spectators.
    fn spectators<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        let alone = Vector::<S, N>::from_fn(|a, _| if a < self.dimension { S::zero() } else { eta[a] });
        pair(&alone.transpose(), &alone) * S::half()
    }
}

impl<T: Real, const N: usize> Lagrangian<T, N> for GivenLagrangian<T, N> {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        const { assert!(S::NESTING <= 2) }
        let value = self.given.value(S::NESTING, &self.leading(eta.as_slice()));
        scalar::<S>(&value, 0) + self.spectators(eta)
    }

    fn gradient<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Covector<S, N> {
        const { assert!(S::NESTING <= 2) }
        let gradient = self.given.gradient(S::NESTING, &self.leading(eta.as_slice()));
        self.beside(&gradient, eta.as_slice()).transpose()
    }

    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        const { assert!(S::NESTING <= 1) }
        let n = self.dimension;
        let hessian = self.given.hessian(S::NESTING, &self.leading(eta.as_slice()));
        Matrix::from_fn(|row, column| match row.max(column) < n {
            true => scalar(&hessian, column * n + row),
            false if row == column => S::one(),
            false => S::zero(),
        })
    }

    fn velocity<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        const { assert!(S::NESTING <= 1) }
        let (leading, near) = (self.leading(mu.as_slice()), self.leading(guess.as_slice()));
        let velocity = self.given.velocity(S::NESTING, &leading, &near)?;
        Ok(self.beside(&velocity, mu.as_slice()))
    }

    fn energy<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        const { assert!(S::NESTING <= 1) }
        let energy = self.given.energy(S::NESTING, &self.leading(eta.as_slice()));
        scalar::<S>(&energy, 0) + self.spectators(eta)
    }
}

impl<T: Real, const N: usize> GivenForce<T, N> {
    /// A force of dimension n beside N − n spectators.
    pub fn of<const LESS: usize>(force: impl Force<T, LESS> + Send + Sync + 'static) -> Self {
        const { assert!(LESS <= N) }
        Self::new(Arc::new(Untyped::<_, LESS>(force)), LESS)
    }
}

impl<T: Real, const N: usize> Force<T, N> for GivenForce<T, N> {
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        const { assert!(S::NESTING <= 2) }
        let n = self.dimension;
        let force = self.given.force(S::NESTING, &numbers(&[t]), &numbers(&eta.as_slice()[..n]));
        Covector::from_fn(|_, a| if a < n { scalar(&force, a) } else { S::zero() })
    }

    fn is_zero(&self) -> bool {
        self.given.is_zero()
    }

    fn is_smooth(&self) -> bool {
        self.given.is_smooth()
    }
}
