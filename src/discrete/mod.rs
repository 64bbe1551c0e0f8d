//! Discrete mechanics on G×G×G, on G⁴ and on G.
//!
//! | | holds |
//! |---|---|
//! | [`DiscreteLagrangian`] | value and trivialised slopes of any discrete Lagrangian |
//! | [`Smooth`] | the slopes of a value that runs on dual numbers |
//! | [`StageLagrangian`] | the discrete Lagrangian of a tableau: the action sum, extremised over its stages |
//! | [`legendre`] | Legendre transforms, equations, flow |
//! | [`quadruple`] | the same on G⁴, lift and projection |
//! | [`exact`] | the exact discrete Lagrangian along solutions of the continuous equations |
//! | [`group`] | discrete Euler–Poincaré and Lie–Poisson on G |
//!
#![doc = include_str!(concat!(env!("GUIDE"), "/modules/discrete.md"))]

mod assembly;
mod chord;
pub mod exact;
pub mod group;
pub mod legendre;
pub mod quadruple;
mod smooth;
mod stages;

pub use group::GroupLagrangian;
pub use legendre::{Momenta, flow, legendre_minus, legendre_plus};
pub use quadruple::Quadruple;
pub use smooth::{Smooth, SmoothLagrangian};
pub use stages::{Extremal, StageLagrangian};

use crate::algebra::{Covector, Matrix, elimination};
use crate::retraction::RetractionError;
use crate::scalar::{Real, Scalar};

/// (V, U, W) in G×G×G: V = g₀⁻¹g₁, U = g₀⁻¹g̃₀, W = g̃₀⁻¹g̃₁.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple<S: Scalar, const D: usize> {
    /// V, the displacement of the first copy.
    pub v: Matrix<S, D>,
    /// U, the second copy seen from the first.
    pub u: Matrix<S, D>,
    /// W, the displacement of the second copy.
    pub w: Matrix<S, D>,
}

impl<S: Scalar, const D: usize> Triple<S, D> {
    /// ε̌_d(V) = (V, e, V).
    pub fn unit(v: Matrix<S, D>) -> Self {
        Self { v, u: Matrix::identity(), w: v }
    }

    /// ι̌_d(V, U, W) = (W, U⁻¹, V); `None` when U is singular.
    pub fn inverse(&self) -> Option<Self> {
        Some(Self { v: self.w, u: elimination::inverse(&self.u)?, w: self.v })
    }

    /// U at the end of the step, V⁻¹UW; `None` when V is singular.
    pub fn next_u(&self) -> Option<Matrix<S, D>> {
        Some(elimination::inverse(&self.v)? * self.u * self.w)
    }
}

/// The derivatives of l_d(V, U, W), each as a covector of g: L*_g F' is ξ ↦ d/dε F(g exp(εξ)), R*_g F' is
/// ξ ↦ d/dε F(exp(εξ) g).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slopes<T: Scalar, const N: usize> {
    /// L*_V D₁l_d.
    pub v_left: Covector<T, N>,
    /// R*_V D₁l_d.
    pub v_right: Covector<T, N>,
    /// L*_U D₂l_d.
    pub u_left: Covector<T, N>,
    /// R*_U D₂l_d.
    pub u_right: Covector<T, N>,
    /// L*_W D₃l_d.
    pub w_left: Covector<T, N>,
    /// R*_W D₃l_d.
    pub w_right: Covector<T, N>,
}

impl<T: Scalar, const N: usize> Slopes<T, N> {
    /// All of them: by V, U and W, L* before R*.
    pub fn all(&self) -> [&Covector<T, N>; 6] {
        [&self.v_left, &self.v_right, &self.u_left, &self.u_right, &self.w_left, &self.w_right]
    }
}

/// Why a discrete Lagrangian, a Legendre transform or a flow could not be evaluated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DiscreteError {
    /// A point is outside the domain of the retraction or of the Lagrangian.
    #[error("{what}: {source}")]
    Domain {
        /// Which point.
        what: &'static str,
        /// Why.
        source: RetractionError,
    },
    /// The iteration did not converge.
    #[error("{what} did not converge: relative residual {residual:e} after {iterations} iterations")]
    NotConverged {
        /// Which equations.
        what: &'static str,
        /// The largest residual relative to the terms of the equations.
        residual: f64,
        /// Iterations spent.
        iterations: usize,
    },
    /// The equations have a singular Jacobian: l_d is not regular there.
    #[error("{what} are singular to working precision")]
    Singular {
        /// Which equations.
        what: &'static str,
    },
    /// The matrix of a group element is singular.
    #[error("the matrix of {what} is singular")]
    NotInvertible {
        /// Which element.
        what: &'static str,
    },
    /// A number is NaN or infinite.
    #[error("{what} is not finite")]
    NotFinite {
        /// Which one.
        what: &'static str,
    },
}

impl DiscreteError {
    /// Names the point that left a domain.
    fn domain(what: &'static str) -> impl Fn(RetractionError) -> Self {
        move |source| Self::Domain { what, source }
    }
}

/// l_d: G×G×G → ℝ, for a group of dimension N in D×D matrices.
///
/// ```
/// use euler_poincare::algebra::{Matrix, Vector};
/// use euler_poincare::discrete::{DiscreteError, DiscreteLagrangian, StageLagrangian, Triple, flow, legendre_minus, legendre_plus};
/// use euler_poincare::mechanics::{doubled::Forced, force::LinearDrag, lagrangian::Quadratic};
/// use euler_poincare::retraction::{CayleySo3, Retraction};
/// use euler_poincare::tableau::Family;
///
/// let drag = LinearDrag::new(Matrix::<f64, 3>::from_diagonal_element(0.1))?;
/// let doubled = Forced::new(Quadratic::diagonal([1.0, 2.0, 3.0])?, drag, CayleySo3::new());
/// let tau = CayleySo3::<f64>::new();
/// let l_d = StageLagrangian::<f64, _, _, 3, 3>::new(doubled, tau.clone(), Family::Gauss.tableau(1)?, 0.1);
///
/// // One step of the flow on G×G×G, from a unit; it stays on the units, and the momenta match.
/// let x = Triple::unit(tau.tau(&Vector::<f64, 3>::new(0.02, 0.01, 0.03))?);
/// let y = flow(&l_d, &l_d, &tau, &x)?;
/// assert!((y.u - Matrix::<f64, 3>::identity()).amax() < 1e-12);
/// let (after, before) = (legendre_plus(&l_d, &x)?, legendre_minus(&l_d, &y)?);
/// assert!((after.mu - before.mu).amax() < 1e-12);
///
/// // A half-turn is outside the domain of Cayley's map.
/// let half_turn = Matrix::<f64, 3>::from_diagonal(&Vector::<f64, 3>::new(-1.0, -1.0, 1.0));
/// assert!(matches!(l_d.slopes(&Triple::unit(half_turn)), Err(DiscreteError::Domain { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait DiscreteLagrangian<T: Real, const N: usize, const D: usize> {
    /// What an evaluation leaves behind to make the next one nearby cheaper.
    type Memory: Default;

    /// l_d(V, U, W).
    ///
    /// # Errors
    /// A point outside the domain; an inner iteration that fails.
    fn value(&self, x: &Triple<T, D>) -> Result<T, DiscreteError>;

    /// All six trivialised derivatives, helped by an evaluation nearby.
    ///
    /// # Errors
    /// Those of [`DiscreteLagrangian::value`].
    fn slopes_from(&self, x: &Triple<T, D>, memory: &mut Self::Memory) -> Result<Slopes<T, N>, DiscreteError>;

    /// All six trivialised derivatives.
    ///
    /// # Errors
    /// Those of [`DiscreteLagrangian::value`].
    fn slopes(&self, x: &Triple<T, D>) -> Result<Slopes<T, N>, DiscreteError> {
        self.slopes_from(x, &mut Self::Memory::default())
    }
}

impl<T: Real, const N: usize, const D: usize, L: DiscreteLagrangian<T, N, D>> DiscreteLagrangian<T, N, D> for &L {
    type Memory = L::Memory;

    fn value(&self, x: &Triple<T, D>) -> Result<T, DiscreteError> {
        (**self).value(x)
    }

    fn slopes_from(&self, x: &Triple<T, D>, memory: &mut L::Memory) -> Result<Slopes<T, N>, DiscreteError> {
        (**self).slopes_from(x, memory)
    }
}
