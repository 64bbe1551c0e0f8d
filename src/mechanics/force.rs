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
    pub(crate) algebra: LieAlgebra<T, N>,
    pub(crate) lagrangian: AnyLagrangian<T, N>,
    pub(crate) alpha: T,
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
    pub(crate) algebra: LieAlgebra<T, N>,
    pub(crate) lagrangian: AnyLagrangian<T, N>,
    pub(crate) beta: T,
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
    pub(crate) matrix: Matrix<T, N>,
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
    pub(crate) matrix: Matrix<T, N>,
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
    pub(crate) covector: Covector<T, N>,
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
    pub(crate) covector: Covector<T, N>,
    pub(crate) frequency: T,
    pub(crate) phase: T,
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

/// The forces that files, random systems, ensembles and `probe` know, each declared once. `$declare` gets, after `$head` and before `$more`, of each
/// its text, its type, what it is called in messages, and in braces what `system::force` makes a term of a case from: the parameters with their
/// roles; the name in files and what is known of the force; its share of random cases, in percent; and the constructor, which is given the values
/// of the parameters.
macro_rules! catalogue {
    ($declare:ident { $($head:tt)* } { $($more:tt)* }) => {
        $declare! {
            $($head)*
            /// f = α ad*_ζ M, ζ = (ad*_η M)ᵀ: double-bracket dissipation keeps Casimirs and lowers the energy (LLG on so(3)).
            DoubleBracket(DoubleBracket<T, N>) "double bracket" {
                { alpha: Number as Strength "α." }
                is {
                    name: "double-bracket", argument: Argument::Momentum, power: Power::Lost, keeps_casimirs: true, orthogonal: true,
                    weight: 18, showing_order: 11, lanes: true,
                };
                share 17.9, 18.9;
                makes (algebra, lagrangian) { DoubleBracket::new(algebra.clone(), lagrangian.clone(), alpha) }
            }
            /// f = −β ad*_η ad*_η M: metriplectic relaxation keeps the energy and moves Casimirs.
            Metriplectic(Metriplectic<T, N>) "metriplectic" {
                { beta: Number as Strength "β." }
                is {
                    name: "metriplectic", argument: Argument::Momentum, power: Power::None, weight: 18, showing_order: 11,
                    lanes: true,
                };
                share 17.9, 18.9;
                makes (algebra, lagrangian) { Metriplectic::new(algebra.clone(), lagrangian.clone(), beta) }
            }
            /// f = −(K η)ᵀ.
            LinearDrag(LinearDrag<T, N>) "linear drag" {
                (drag: Drag as Drag)
                is { name: "linear-drag", power: Power::Lost, weight: 14, showing_order: 22, lanes: true };
                share 14.5, 15.5;
                makes () { LinearDrag::new(drag) }
            }
            /// f = −√(ηᵀ K η) (K η)ᵀ, K symmetric and positive semidefinite.
            QuadraticDrag(QuadraticDrag<T, N>) "quadratic drag" {
                (drag: Drag as SymmetricDrag)
                is {
                    name: "quadratic-drag", power: Power::Lost, smooth: false, weight: 12, showing_order: 17, lanes: true,
                };
                share 12.6, 13.6;
                makes () { QuadraticDrag::new(drag) }
            }
            /// f = −q (ηᵀη) ηᵀ.
            CubicDrag(CubicDrag<T>) "cubic drag" {
                { q: Number as Strength "q." }
                is { name: "cubic-drag", orthogonal: true, power: Power::Lost, weight: 6, showing_order: 6 };
                share 6.3, 7.3;
                makes () { CubicDrag::new(q) }
            }
            /// f = c, a constant covector.
            Constant(Constant<T, N>) "constant" {
                { value: Vec<Number> as Amplitude "Its n components." }
                is { name: "constant", argument: Argument::Nothing, weight: 7, showing_order: 6, lanes: true };
                share 7.3, 8.3;
                makes () { Constant::new(value) }
            }
            /// f(t) = c cos(ωt + φ).
            Periodic(Periodic<T, N>) "periodic" {
                {
                    value: Vec<Number> as Amplitude "The n amplitudes c.",
                    frequency: Number as Frequency "ω.",
                    phase: Number as Phase "φ.",
                }
                is {
                    name: "periodic", argument: Argument::Nothing, weight: 7, showing_order: 11, simpler: Some("constant"),
                    lanes: true,
                };
                share 7.2, 8.2;
                makes () { Periodic::new(value, frequency, phase) }
            }
            /// A polynomial in (cos t, sin t, η) with values in g*.
            Polynomial(Polynomial<T, N>) "polynomial" {
                { terms: Vec<Monomial> as CovectorPolynomial "Its terms." }
                is { name: "polynomial", weight: 11, showing_order: 10 };
                share 11.6, 12.6;
                makes () { Ok(terms) }
            }
            /// f = ad*_ζ l'(η): keeps coadjoint orbits.
            Orbit(OrbitForce<T, N, AnyLagrangian<T, N>, Polynomial<T, N>>) "orbit" {
                { zeta: Vec<Monomial> as VectorPolynomial "ζ, a polynomial in (cos t, sin t, η) with values in g." }
                is { name: "orbit", argument: Argument::Momentum, keeps_casimirs: true, weight: 7, showing_order: 6 };
                share 7.0, 8.0;
                makes (algebra, lagrangian) { Ok(OrbitForce::new(algebra.clone(), lagrangian.clone(), zeta)) }
            }
            $($more)*
        }
    };
}
#[cfg(feature = "harness")]
pub(crate) use catalogue;

macro_rules! any_force {
    ($($(#[$about:meta])* $variant:ident($ty:ty) $name:literal $described:tt)*) => {
        /// A force chosen at run time, sums included.
        #[derive(Clone, Debug, PartialEq)]
        #[non_exhaustive]
        pub enum AnyForce<T: Real, const N: usize> {
            $($(#[$about])* $variant($ty),)*
            /// The sum of the terms (0 when there are none).
            Sum(Vec<AnyForce<T, N>>),
            /// Of a type that is not known here.
            #[cfg(feature = "harness")]
            #[doc(hidden)]
            Given(super::given::GivenForce<T, N>),
        }

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

        super::any!(AnyForce by delegated_force: $($variant($ty)),*; Sum);
    };
}

catalogue!(any_force {} {
    /// f = 0.
    Zero(Zero) "zero" {}
    /// By a formula.
    Formula(Box<FormulaForce<T, N>>) "formula" {}
});
