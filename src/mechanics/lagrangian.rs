//! Reduced Lagrangians: the quadratic one of a rigid body, a quartic one, a gyrostat's.

mod gyrostat;

pub use gyrostat::Gyrostat;

use super::configuration::Configuration;
use super::formula::FormulaLagrangian;
use super::legendre::{MAX_ITERATIONS, invert, largest};
use super::{Lagrangian, LegendreError};
use crate::algebra::{AlgebraError, Covector, Matrix, Vector, apply_constants, dot, elimination};
use crate::scalar::{Real, Scalar};

/// l(η) = ½ ηᵀ I η with a symmetric, regular inertia I (N×N): the rigid body and its relatives.
///
/// I need not be positive definite: the Legendre transform only needs it regular. See
/// [`Quadratic::is_positive_definite`].
#[derive(Clone, Debug, PartialEq)]
pub struct Quadratic<T: Real, const N: usize> {
    inertia: Matrix<T, N>,
    inverse: Matrix<T, N>,
}

impl<T: Real, const N: usize> Quadratic<T, N> {
    /// l(η) = ½ ηᵀ I η.
    ///
    /// # Errors
    /// [`LegendreError::BadInertia`]: an entry that is not finite; asymmetry beyond rounding (64 N u max|I|; below
    /// that, the symmetric part is taken); singular to working precision.
    pub fn new(inertia: Matrix<T, N>) -> Result<Self, LegendreError> {
        let inertia = symmetric(&inertia).map_err(|why| LegendreError::BadInertia { why })?;
        let inverse = elimination::regular_inverse(&inertia).map_err(|refused| LegendreError::BadInertia {
            why: match refused {
                AlgebraError::SingularBasis { condition } => {
                    format!("it is singular to working precision: its condition number is {condition:e}")
                }
                other => other.to_string(),
            },
        })?;
        Ok(Self { inertia, inverse: (inverse + inverse.transpose()) * T::half() })
    }

    /// l(η) = ½ Σ I_a (η^a)²: principal moments I_a.
    ///
    /// # Errors
    /// A moment that is zero or not finite.
    pub fn diagonal(moments: [T; N]) -> Result<Self, LegendreError> {
        Self::new(Matrix::from_fn(|r, c| if r == c { moments[r] } else { T::zero() }))
    }

    /// I.
    pub fn inertia(&self) -> &Matrix<T, N> {
        &self.inertia
    }

    /// I⁻¹.
    pub fn inverse(&self) -> &Matrix<T, N> {
        &self.inverse
    }

    /// Whether ηᵀ I η > 0 for every η ≠ 0 (by Cholesky's factorisation): then the energy is bounded below.
    pub fn is_positive_definite(&self) -> bool {
        self.inertia.cholesky().is_some()
    }
}

/// The symmetric part of a matrix that is finite, and symmetric up to rounding; otherwise the entry at fault.
pub(super) fn symmetric<T: Real, const N: usize>(matrix: &Matrix<T, N>) -> Result<Matrix<T, N>, String> {
    for a in 0..N {
        for b in 0..N {
            if !matrix[(a, b)].all_finite() {
                return Err(format!("entry ({}, {}) is not finite", a + 1, b + 1));
            }
        }
    }
    let allowed = T::int(64 * N as i64) * T::unit_roundoff() * largest(matrix);
    for a in 0..N {
        for b in 0..a {
            let defect = matrix[(a, b)] - matrix[(b, a)];
            if defect.abs() > allowed {
                let (a, b) = (a + 1, b + 1);
                return Err(format!("entries ({a}, {b}) and ({b}, {a}) differ by {:e}", defect.to_f64()));
            }
        }
    }
    Ok(Matrix::from_fn(|a, b| if a == b { matrix[(a, a)] } else { (matrix[(a, b)] + matrix[(b, a)]) * T::half() }))
}

impl<T: Real, const N: usize> Lagrangian<T, N> for Quadratic<T, N> {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        S::half() * crate::algebra::pair(&self.gradient(eta), eta)
    }

    #[inline]
    fn gradient<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Covector<S, N> {
        apply_constants(&self.inertia, eta).transpose()
    }

    fn hessian<S: Scalar<Base = T>>(&self, _eta: &Vector<S, N>) -> Matrix<S, N> {
        self.inertia.map(S::lift)
    }

    #[inline]
    fn velocity<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, N>,
        _guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        Ok(apply_constants(&self.inverse, &mu.transpose()))
    }

    fn energy<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        self.value(eta)
    }
}

/// Whether ηᵀ K η ≥ 0 for every η, beyond rounding (64 N u max|K|), by Cholesky's factorisation; K symmetric.
pub(super) fn is_positive_semidefinite<T: Real, const N: usize>(matrix: &Matrix<T, N>) -> bool {
    let size = largest(matrix);
    let shift = T::int(64 * N as i64) * T::unit_roundoff() * size;
    size == T::zero() || (matrix + Matrix::identity() * shift).cholesky().is_some()
}

/// l(η) = ½ ηᵀIη + ¼ κ q², q = ηᵀKη, with I positive definite, K positive semidefinite and κ ≥ 0: convex, and not quadratic. The
/// metric K is I, unless another is given.
///
/// l' = (Iη + κ q Kη)ᵀ and l'' = I + κ q K + 2κ Kη (Kη)ᵀ. For K = I the inverse of l' is η = s I⁻¹ μᵀ with s + κ p s³ = 1, p = μ I⁻¹ μᵀ;
/// else it is found by Newton's method.
#[derive(Clone, Debug, PartialEq)]
pub struct Quartic<T: Real, const N: usize> {
    quadratic: Quadratic<T, N>,
    stiffness: T,
    /// K; `None`: I.
    metric: Option<Matrix<T, N>>,
}

impl<T: Real, const N: usize> Quartic<T, N> {
    /// l(η) = ½ ηᵀIη + ¼ κ (ηᵀIη)².
    ///
    /// # Errors
    /// [`LegendreError::BadInertia`]: I not symmetric, not finite or not positive definite; κ negative or not finite.
    pub fn new(inertia: Matrix<T, N>, stiffness: T) -> Result<Self, LegendreError> {
        let quadratic = Quadratic::new(inertia)?;
        if !quadratic.is_positive_definite() {
            return Err(LegendreError::BadInertia { why: "it is not positive definite".into() });
        }
        if !stiffness.all_finite() || stiffness < T::zero() {
            let why = format!("the stiffness κ = {} must be finite and not negative", stiffness.to_f64());
            return Err(LegendreError::BadInertia { why });
        }
        Ok(Self { quadratic, stiffness, metric: None })
    }

    /// l(η) = ½ ηᵀIη + ¼ κ (ηᵀKη)².
    ///
    /// # Errors
    /// Those of [`Quartic::new`]; [`LegendreError::BadTerm`]: K not finite, not symmetric, or with a negative direction (each beyond
    /// rounding, 64 N u max|K|).
    pub fn in_metric(inertia: Matrix<T, N>, stiffness: T, metric: &Matrix<T, N>) -> Result<Self, LegendreError> {
        let refused = |why: String| LegendreError::BadTerm { what: "metric of the quartic term", why };
        let metric = symmetric(metric).map_err(refused)?;
        if !is_positive_semidefinite(&metric) {
            return Err(refused("it is not positive semidefinite".into()));
        }
        Ok(Self { metric: Some(metric), ..Self::new(inertia, stiffness)? })
    }

    /// I.
    pub fn inertia(&self) -> &Matrix<T, N> {
        self.quadratic.inertia()
    }

    /// K.
    pub fn metric(&self) -> &Matrix<T, N> {
        self.metric.as_ref().unwrap_or(self.inertia())
    }

    /// Kη, q and κ q.
    fn parts<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> (Vector<S, N>, S, S) {
        let momentum = apply_constants(self.metric(), eta);
        let q = dot(eta.as_slice(), momentum.as_slice());
        (momentum, q, S::lift(self.stiffness) * q)
    }

    /// ηᵀIη, where ηᵀKη = q.
    fn twice_kinetic<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>, q: S) -> S {
        match &self.metric {
            None => q,
            Some(_) => crate::algebra::pair(&self.quadratic.gradient(eta), eta),
        }
    }
}

/// The root of s + c s³ = 1 for c ≥ 0, by Newton's iteration from above, where it falls monotonically: on the value, then as often
/// as the derivatives in c want it.
///
/// # Errors
/// c is not finite; no convergence, which theory excludes.
fn shrinking<T: Real, S: Scalar<Base = T>>(c: S) -> Result<S, LegendreError> {
    let value = c.base();
    let failed = || LegendreError::NotConverged { residual: value.to_f64(), iterations: 0 };
    if !value.all_finite() {
        return Err(failed());
    }
    let step = |s: T| (s + value * s * s * s - T::one()) / (T::one() + T::int(3) * value * s * s);
    let mut root = T::one();
    if value > T::one() {
        root = T::one() / value.cbrt();
    }
    let mut by = root;
    for _ in 0..MAX_ITERATIONS {
        by = step(root);
        root -= by;
        // Quadratic convergence: what such a step leaves is round-off.
        if by.abs() <= T::unit_roundoff().sqrt() * root {
            break;
        }
    }
    if by.abs() > T::unit_roundoff().sqrt() * root {
        return Err(LegendreError::NotConverged { residual: by.to_f64(), iterations: MAX_ITERATIONS });
    }
    let (order, mut right, mut found) = (S::NESTING, 0, S::lift(root));
    while right < order {
        let square = c * found * found;
        found -= (found + square * found - S::one()) / (S::one() + S::int(3) * square);
        right = 2 * right + 1;
    }
    Ok(found)
}

impl<T: Real, const N: usize> Lagrangian<T, N> for Quartic<T, N> {
    fn value<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        let (_, q, stiff) = self.parts(eta);
        S::half() * self.twice_kinetic(eta, q) + S::exact(0.25) * stiff * q
    }

    fn gradient<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Covector<S, N> {
        let (momentum, _, stiff) = self.parts(eta);
        match &self.metric {
            None => momentum.transpose() * (S::one() + stiff),
            Some(_) => self.quadratic.gradient(eta) + momentum.transpose() * stiff,
        }
    }

    fn hessian<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> Matrix<S, N> {
        let (momentum, _, stiff) = self.parts(eta);
        let twice = S::lift(self.stiffness * T::int(2));
        let (inertia, metric) = (self.inertia(), self.metric());
        Matrix::from_fn(|a, b| {
            let along = match &self.metric {
                None => S::lift(inertia[(a, b)]) * (S::one() + stiff),
                Some(_) => S::lift(inertia[(a, b)]) + S::lift(metric[(a, b)]) * stiff,
            };
            along + momentum[a] * momentum[b] * twice
        })
    }

    fn velocity<S: Scalar<Base = T>>(
        &self,
        mu: &Covector<S, N>,
        guess: &Vector<S, N>,
    ) -> Result<Vector<S, N>, LegendreError> {
        if self.metric.is_some() {
            return invert(self, mu, guess);
        }
        let straight = self.quadratic.velocity(mu, guess)?;
        let p = crate::algebra::pair(mu, &straight);
        Ok(straight * shrinking(S::lift(self.stiffness) * p)?)
    }

    fn energy<S: Scalar<Base = T>>(&self, eta: &Vector<S, N>) -> S {
        let (_, q, stiff) = self.parts(eta);
        S::half() * self.twice_kinetic(eta, q) + S::exact(0.75) * stiff * q
    }
}

/// A Lagrangian chosen at run time.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnyLagrangian<T: Real, const N: usize> {
    /// ½ ηᵀ I η.
    Quadratic(Quadratic<T, N>),
    /// ½ ηᵀ I η + ¼ κ (ηᵀ K η)².
    Quartic(Quartic<T, N>),
    /// Another one and ⟨b, η⟩.
    Gyrostat(Box<Gyrostat<Self, T, N>>),
    /// By a formula: a potential beside another one, or L itself.
    Formula(Box<FormulaLagrangian<T, N>>),
    /// Of a type that is not known here.
    #[cfg(feature = "harness")]
    #[doc(hidden)]
    Given(super::given::GivenLagrangian<T, N>),
}

impl<T: Real, const N: usize> AnyLagrangian<T, N> {
    /// The Lagrangian without the potentials that formulas put beside it; itself where there are none.
    pub fn kinetic(&self) -> &Self {
        match self {
            Self::Formula(formula) => formula.body().map_or(self, Self::kinetic),
            other => other,
        }
    }
}

super::any!(
    AnyLagrangian by delegated_lagrangian: Quadratic(Quadratic<T, N>), Quartic(Quartic<T, N>), Gyrostat(Gyrostat<Self, T, N>),
    Formula(FormulaLagrangian<T, N>);
);
