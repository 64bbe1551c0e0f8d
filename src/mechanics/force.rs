//! Forces f(t, η) or f(t, g, η) ∈ g*: dissipation that keeps Casimirs, dissipation that keeps energy, drags, loads, polynomials, controls, black boxes.
//! Formulas are in [`formula`](super::formula), orbit forces in [`lie_poisson`](super::lie_poisson).
//!
//! Those that depend on the momentum M = l'(η) own a copy of the algebra and of the Lagrangian.

mod black_box;
mod composition;
mod polynomial;

pub use black_box::BlackBox;
pub use composition::{Control, Driven, Factor, Hold, Signal};
pub use polynomial::{MAX_DEGREE, Monomial, Polynomial};

use super::configuration::Configuration;
use super::formula::FormulaForce;
use super::lagrangian::{AnyLagrangian, is_positive_semidefinite, symmetric};
use super::lie_poisson::OrbitForce;
use super::{Force, Lagrangian};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, apply_constants, dot, pull};
use crate::scalar::{Real, Scalar};

/// Why a force was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ForceError {
    /// A coefficient is NaN or infinite.
    #[error("{force}: {what} is not finite")]
    NotFinite {
        /// Name of the force.
        force: &'static str,
        /// Which coefficient.
        what: &'static str,
    },
    /// The matrix of a drag is not what the formula needs.
    #[error("{force}: the matrix is refused: {why}")]
    BadMatrix {
        /// Name of the force.
        force: &'static str,
        /// What is wrong, with the entry.
        why: String,
    },
    /// The times and values of a control are not what it needs.
    #[error("control: {why}")]
    BadControl {
        /// What is wrong.
        why: String,
    },
    /// A term of a polynomial is not what the formula needs.
    #[error("polynomial: term {term} is refused: {why}")]
    BadTerm {
        /// Which term, from 1.
        term: usize,
        /// What is wrong.
        why: String,
    },
}

fn finite<'a, T: Real>(
    force: &'static str,
    what: &'static str,
    entries: impl IntoIterator<Item = &'a T>,
) -> Result<(), ForceError> {
    if entries.into_iter().all(|v| v.all_finite()) { Ok(()) } else { Err(ForceError::NotFinite { force, what }) }
}

/// f = 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Zero;

impl<T: Real, const N: usize> Force<T, N> for Zero {
    fn force<S: Scalar<Base = T>>(&self, _t: S, _eta: &Vector<S, N>) -> Covector<S, N> {
        Covector::zeros()
    }

    fn is_zero(&self) -> bool {
        true
    }
}

/// f = α ad*_ζ M, ζ = (ad*_η M)ᵀ, M = l'(η): Casimirs are kept, and for α > 0 energy falls at α |ad*_η M|².
///
/// The transpose identifies g* with g in the given basis. On so(3): α M×(M×Ω), the damping of Landau, Lifshitz and
/// Gilbert (Bloch, Krishnaprasad, Marsden and Ratiu 1996, "double bracket dissipation").
#[derive(Clone, Debug, PartialEq)]
pub struct DoubleBracket<T: Real, const N: usize> {
    algebra: LieAlgebra<T, N>,
    lagrangian: AnyLagrangian<T, N>,
    alpha: T,
}

impl<T: Real, const N: usize> DoubleBracket<T, N> {
    /// The double-bracket force with strength α.
    ///
    /// # Errors
    /// α not finite.
    pub fn new(
        algebra: LieAlgebra<T, N>,
        lagrangian: impl Into<AnyLagrangian<T, N>>,
        alpha: T,
    ) -> Result<Self, ForceError> {
        finite("double bracket", "α", [&alpha])?;
        Ok(Self { algebra, lagrangian: lagrangian.into(), alpha })
    }

    /// α.
    pub fn alpha(&self) -> T {
        self.alpha
    }

    /// The algebra on which the force acts.
    pub fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.algebra
    }

    /// The Lagrangian that makes the momentum of a velocity.
    pub fn lagrangian(&self) -> &AnyLagrangian<T, N> {
        &self.lagrangian
    }
}

impl<T: Real, const N: usize> Force<T, N> for DoubleBracket<T, N> {
    fn force<S: Scalar<Base = T>>(&self, _t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        let momentum = self.lagrangian.gradient(eta);
        let zeta = self.algebra.coad(eta, &momentum).transpose();
        self.algebra.coad(&zeta, &momentum) * S::lift(self.alpha)
    }

    fn is_zero(&self) -> bool {
        self.alpha == T::zero()
    }
}

/// f = −β ad*_η ad*_η M, M = l'(η): energy is kept on every algebra, because ⟨ad*_η ν, η⟩ = ⟨ν, [η, η]⟩ = 0.
///
/// On so(3): β (Ω×M)×Ω, the relaxed rigid body (Morrison 1986, "metriplectic"); there |M|² grows at 2β |Ω×M|².
#[derive(Clone, Debug, PartialEq)]
pub struct Metriplectic<T: Real, const N: usize> {
    algebra: LieAlgebra<T, N>,
    lagrangian: AnyLagrangian<T, N>,
    beta: T,
}

impl<T: Real, const N: usize> Metriplectic<T, N> {
    /// The metriplectic force with strength β.
    ///
    /// # Errors
    /// β not finite.
    pub fn new(
        algebra: LieAlgebra<T, N>,
        lagrangian: impl Into<AnyLagrangian<T, N>>,
        beta: T,
    ) -> Result<Self, ForceError> {
        finite("metriplectic", "β", [&beta])?;
        Ok(Self { algebra, lagrangian: lagrangian.into(), beta })
    }

    /// β.
    pub fn beta(&self) -> T {
        self.beta
    }

    /// The algebra on which the force acts.
    pub fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.algebra
    }

    /// The Lagrangian that makes the momentum of a velocity.
    pub fn lagrangian(&self) -> &AnyLagrangian<T, N> {
        &self.lagrangian
    }
}

impl<T: Real, const N: usize> Force<T, N> for Metriplectic<T, N> {
    fn force<S: Scalar<Base = T>>(&self, _t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        let ad = self.algebra.ad(eta);
        pull(&pull(&self.lagrangian.gradient(eta), &ad), &ad) * -S::lift(self.beta)
    }

    fn is_zero(&self) -> bool {
        self.beta == T::zero()
    }
}

/// f = −(R η)ᵀ. R is any matrix; it dissipates where its symmetric part is positive.
#[derive(Clone, Debug, PartialEq)]
pub struct LinearDrag<T: Real, const N: usize> {
    matrix: Matrix<T, N>,
}

impl<T: Real, const N: usize> LinearDrag<T, N> {
    /// The drag with matrix R (N×N).
    ///
    /// # Errors
    /// An entry that is not finite.
    pub fn new(matrix: Matrix<T, N>) -> Result<Self, ForceError> {
        finite("linear drag", "the matrix", &matrix)?;
        Ok(Self { matrix })
    }

    /// The matrix R.
    pub fn matrix(&self) -> &Matrix<T, N> {
        &self.matrix
    }
}

impl<T: Real, const N: usize> Force<T, N> for LinearDrag<T, N> {
    fn force<S: Scalar<Base = T>>(&self, _t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        -apply_constants(&self.matrix, eta).transpose()
    }

    fn is_zero(&self) -> bool {
        self.matrix.iter().all(|v| *v == T::zero())
    }
}

/// f = −√(ηᵀ K η) (K η)ᵀ with K symmetric, positive semidefinite: smooth where K η ≠ 0, once differentiable elsewhere
/// (value and first derivative are 0 there; a second derivative does not exist and is returned as 0).
#[derive(Clone, Debug, PartialEq)]
pub struct QuadraticDrag<T: Real, const N: usize> {
    matrix: Matrix<T, N>,
}

impl<T: Real, const N: usize> QuadraticDrag<T, N> {
    /// The drag with matrix K (N×N).
    ///
    /// # Errors
    /// K not finite, not symmetric, or with a negative direction (each beyond rounding, 64 N u max|K|).
    pub fn new(matrix: Matrix<T, N>) -> Result<Self, ForceError> {
        let force = "quadratic drag";
        let matrix = symmetric(&matrix).map_err(|why| ForceError::BadMatrix { force, why })?;
        if !is_positive_semidefinite(&matrix) {
            return Err(ForceError::BadMatrix { force, why: "it is not positive semidefinite".into() });
        }
        Ok(Self { matrix })
    }

    /// The matrix K.
    pub fn matrix(&self) -> &Matrix<T, N> {
        &self.matrix
    }
}

impl<T: Real, const N: usize> Force<T, N> for QuadraticDrag<T, N> {
    fn force<S: Scalar<Base = T>>(&self, _t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        let drag = apply_constants(&self.matrix, eta).transpose();
        let square = crate::algebra::pair(&drag, eta);
        if square <= S::zero() {
            return Covector::zeros();
        }
        drag * -square.sqrt()
    }

    fn is_zero(&self) -> bool {
        self.matrix.iter().all(|v| *v == T::zero())
    }

    fn is_smooth(&self) -> bool {
        self.is_zero()
    }
}

/// f = −q (ηᵀη) ηᵀ: drag that grows with the cube of the speed. It identifies g* with g by the basis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CubicDrag<T> {
    coefficient: T,
}

impl<T: Real> CubicDrag<T> {
    /// The drag with coefficient q; it dissipates where q ≥ 0.
    ///
    /// # Errors
    /// A coefficient that is not finite.
    pub fn new(coefficient: T) -> Result<Self, ForceError> {
        finite("cubic drag", "the coefficient", [&coefficient])?;
        Ok(Self { coefficient })
    }
}

impl<T: Real, const N: usize> Force<T, N> for CubicDrag<T> {
    fn force<S: Scalar<Base = T>>(&self, _t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        eta.transpose() * (dot(eta.as_slice(), eta.as_slice()) * -S::lift(self.coefficient))
    }

    fn is_zero(&self) -> bool {
        self.coefficient == T::zero()
    }
}

/// f = c, constant in the body frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Constant<T: Real, const N: usize> {
    covector: Covector<T, N>,
}

impl<T: Real, const N: usize> Constant<T, N> {
    /// The constant force c.
    ///
    /// # Errors
    /// An entry that is not finite.
    pub fn new(covector: Covector<T, N>) -> Result<Self, ForceError> {
        finite("constant force", "the covector", &covector)?;
        Ok(Self { covector })
    }

    /// The covector.
    pub fn covector(&self) -> &Covector<T, N> {
        &self.covector
    }
}

impl<T: Real, const N: usize> Force<T, N> for Constant<T, N> {
    fn force<S: Scalar<Base = T>>(&self, _t: S, _eta: &Vector<S, N>) -> Covector<S, N> {
        self.covector.map(S::lift)
    }

    fn is_zero(&self) -> bool {
        self.covector.iter().all(|v| *v == T::zero())
    }
}

/// f(t) = c cos(ω t + φ).
#[derive(Clone, Debug, PartialEq)]
pub struct Periodic<T: Real, const N: usize> {
    covector: Covector<T, N>,
    frequency: T,
    phase: T,
}

impl<T: Real, const N: usize> Periodic<T, N> {
    /// Amplitude c, angular frequency ω, phase φ.
    ///
    /// # Errors
    /// A number that is not finite.
    pub fn new(covector: Covector<T, N>, frequency: T, phase: T) -> Result<Self, ForceError> {
        finite("periodic force", "the amplitude", &covector)?;
        finite("periodic force", "the frequency or the phase", [&frequency, &phase])?;
        Ok(Self { covector, frequency, phase })
    }

    /// The amplitude.
    pub fn covector(&self) -> &Covector<T, N> {
        &self.covector
    }

    /// The angular frequency ω.
    pub fn frequency(&self) -> T {
        self.frequency
    }

    /// The phase φ.
    pub fn phase(&self) -> T {
        self.phase
    }
}

impl<T: Real, const N: usize> Force<T, N> for Periodic<T, N> {
    fn force<S: Scalar<Base = T>>(&self, t: S, _eta: &Vector<S, N>) -> Covector<S, N> {
        let angle = S::lift(self.frequency) * t + S::lift(self.phase);
        self.covector.map(S::lift) * angle.cos()
    }

    fn is_zero(&self) -> bool {
        self.covector.iter().all(|v| *v == T::zero())
    }
}

/// A force chosen at run time, sums included.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum AnyForce<T: Real, const N: usize> {
    /// f = 0.
    Zero(Zero),
    /// f = α ad*_ζ M, ζ = (ad*_η M)ᵀ.
    DoubleBracket(DoubleBracket<T, N>),
    /// f = −β ad*_η ad*_η M.
    Metriplectic(Metriplectic<T, N>),
    /// f = −(R η)ᵀ.
    LinearDrag(LinearDrag<T, N>),
    /// f = −√(ηᵀ K η) (K η)ᵀ.
    QuadraticDrag(QuadraticDrag<T, N>),
    /// f = −q (ηᵀη) ηᵀ.
    CubicDrag(CubicDrag<T>),
    /// f = c.
    Constant(Constant<T, N>),
    /// f = c cos(ω t + φ).
    Periodic(Periodic<T, N>),
    /// A polynomial in (cos t, sin t, η).
    Polynomial(Polynomial<T, N>),
    /// f = ad*_ζ l'(η), ζ a polynomial in (cos t, sin t, η).
    Orbit(OrbitForce<T, N, AnyLagrangian<T, N>, Polynomial<T, N>>),
    /// By a formula.
    Formula(Box<FormulaForce<T, N>>),
    /// The sum of the terms (0 when there are none).
    Sum(Vec<AnyForce<T, N>>),
    /// Of a type that is not known here.
    #[cfg(feature = "harness")]
    #[doc(hidden)]
    Given(super::given::GivenForce<T, N>),
}

macro_rules! any_force {
    ($($variant:ident($ty:ty) $name:literal),*) => {
        impl<T: Real, const N: usize> AnyForce<T, N> {
            /// What the force is called in messages.
            pub fn name(&self) -> &'static str {
                match self {
                    $(Self::$variant(_) => $name,)*
                    Self::Sum(_) => "sum",
                    #[cfg(feature = "harness")]
                    Self::Given(_) => "given",
                }
            }
        }

        $(impl<T: Real, const N: usize> From<$ty> for AnyForce<T, N> {
            fn from(force: $ty) -> Self {
                Self::$variant(force)
            }
        })*

        macro_rules! dispatch {
            ($any:ident, $force:ident => $value:expr) => {
                match $any {
                    $(AnyForce::$variant($force) => $value,)*
                    AnyForce::Sum($force) => $value,
                    #[cfg(feature = "harness")]
                    AnyForce::Given($force) => $value,
                }
            };
        }

        super::delegated_force!([T: Real, const N: usize] AnyForce<T, N>, dispatch);
    };
}

any_force!(
    Zero(Zero) "zero",
    DoubleBracket(DoubleBracket<T, N>) "double bracket",
    Metriplectic(Metriplectic<T, N>) "metriplectic",
    LinearDrag(LinearDrag<T, N>) "linear drag",
    QuadraticDrag(QuadraticDrag<T, N>) "quadratic drag",
    CubicDrag(CubicDrag<T>) "cubic drag",
    Constant(Constant<T, N>) "constant",
    Periodic(Periodic<T, N>) "periodic",
    Polynomial(Polynomial<T, N>) "polynomial",
    Orbit(OrbitForce<T, N, AnyLagrangian<T, N>, Polynomial<T, N>>) "orbit",
    Formula(Box<FormulaForce<T, N>>) "formula"
);
