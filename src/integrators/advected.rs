//! Euler–Poincaré systems with advected parameters: (μ, a) is the state, where a ∈ V is carried along by the group.

use super::{OneStep, Report, State, StepError, Variational};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector, elimination};
use crate::group::LieGroup;
use crate::mechanics::Force;
use crate::mechanics::configuration::{LagrangianOn, LagrangianOnGroup};
use crate::retraction::Exponential;
use crate::scalar::{Real, Scalar};
use crate::tableau::Tableau;

/// A reduced Lagrangian l(t, η, a) with a parameter a ∈ V that is advected, ȧ = −η·a.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is not a Lagrangian with an advected parameter of dimension {V}",
    note = "implement `AdvectedLagrangian<T, {N}, {V}>`: `fn value<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, {N}>, a: &Vector<S, {V}>) -> S`"
)]
pub trait AdvectedLagrangian<T: Real, const N: usize, const V: usize> {
    /// l(t, η, a).
    fn value<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>, a: &Vector<S, V>) -> S;
}

/// A representation of an algebra on V by matrices ρ(e_a), faithful or not.
#[derive(Clone, Debug, PartialEq)]
pub struct Representation<T: Real, const N: usize, const V: usize> {
    algebra: LieAlgebra<T, N>,
    matrices: [Matrix<T, V>; N],
}

impl<T: Real, const N: usize, const V: usize> Representation<T, N, V> {
    /// The representation with these ρ(e_a).
    ///
    /// # Errors
    /// [`RepresentationError`]: an entry that is not finite; [ρ(e_a), ρ(e_b)] ≠ C^c_ab ρ(e_c) beyond rounding (2¹⁰ (V + N) u of the products).
    pub fn new(algebra: LieAlgebra<T, N>, matrices: [Matrix<T, V>; N]) -> Result<Self, RepresentationError> {
        let largest = matrices.iter().fold(T::zero(), |m, matrix| m.max(matrix.amax()));
        if matrices.iter().any(|matrix| matrix.iter().any(|v| !v.all_finite())) {
            return Err(RepresentationError::NotFinite);
        }
        let allowed = T::unit_roundoff() * T::int(1024 * (V + N) as i64) * largest * (largest + T::one());
        for a in 0..N {
            for b in 0..a {
                let mut defect = matrices[a] * matrices[b] - matrices[b] * matrices[a];
                for (c, matrix) in matrices.iter().enumerate() {
                    defect -= matrix * algebra.constant(a, b, c);
                }
                if defect.amax() > allowed {
                    return Err(RepresentationError::NotAHomomorphism {
                        a: b + 1,
                        b: a + 1,
                        defect: defect.amax().to_f64(),
                    });
                }
            }
        }
        Ok(Self { algebra, matrices })
    }
}

/// Why matrices are no representation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RepresentationError {
    /// An entry is NaN or infinite.
    #[error("a matrix of the representation is not finite")]
    NotFinite,
    /// The commutators are not those of the algebra.
    #[error("the matrices are no representation: the commutator of numbers {a} and {b} is off by {defect:e}")]
    NotAHomomorphism {
        /// The first index, from 1.
        a: usize,
        /// The second index, from 1.
        b: usize,
        /// By how much.
        defect: f64,
    },
}

/// The matrices exp ρ(ξ), which exponentials need a group for.
#[derive(Clone, Debug)]
struct Image<T: Real, const N: usize, const V: usize>(Representation<T, N, V>);

impl<T: Real, const N: usize, const V: usize> LieGroup<T, N, V> for Image<T, N, V> {
    fn algebra(&self) -> &LieAlgebra<T, N> {
        &self.0.algebra
    }

    fn hat<S: Scalar<Base = T>>(&self, xi: &Vector<S, N>) -> Matrix<S, V> {
        self.0.matrices.iter().zip(xi.iter()).fold(Matrix::zeros(), |sum, (matrix, x)| sum + matrix.map(S::lift) * *x)
    }

    /// Not known where ρ is not faithful: not finite. Neither τ nor its tangents ask for it.
    fn vee<S: Scalar<Base = T>>(&self, _matrix: &Matrix<S, V>) -> Vector<S, N> {
        Vector::from_element(S::exact(f64::NAN))
    }

    fn inverse<S: Scalar<Base = T>>(&self, g: &Matrix<S, V>) -> Option<Matrix<S, V>> {
        elimination::inverse(g)
    }
}

/// l(t, η, g⁻¹·a) as a Lagrangian on the group.
#[derive(Clone, Debug)]
struct Carried<L, T: Real, const V: usize> {
    lagrangian: L,
    parameter: Vector<T, V>,
}

impl<T, const N: usize, const V: usize, L> LagrangianOnGroup<T, N, V> for Carried<L, T, V>
where
    T: Real,
    L: AdvectedLagrangian<T, N, V>,
{
    /// Not finite where g is singular.
    fn value<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, V>, eta: &Vector<S, N>) -> S {
        let nowhere = || Matrix::from_element(S::exact(f64::NAN));
        let back = elimination::inverse(g).unwrap_or_else(nowhere);
        self.lagrangian.value(t, eta, &(back * self.parameter.map(S::lift)))
    }
}

/// The state of a system with an advected parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct AdvectedState<T: Real, const N: usize, const V: usize> {
    /// t.
    pub time: T,
    /// μ = ∂l/∂η.
    pub momentum: Covector<T, N>,
    /// a.
    pub parameter: Vector<T, V>,
}

/// The variational step of a system with an advected parameter: μ̇ = ad*_η μ + (∂l/∂a)⋄a + f, ȧ = −η·a.
///
/// With g the motion of the group, a = g⁻¹·a₀. The step is that of L(t, g, η) = l(t, η, g⁻¹·a) from g = e, with the exponential: the
/// reduced step is the unreduced one to round-off. Source: Holm, Marsden and Ratiu 1998, "The Euler–Poincaré equations and semidirect
/// products"; the scheme of Martín de Diego and Sato Martín de Almagro 2019, §5.2.
///
/// ```
/// use euler_poincare::algebra::{Covector, Entry, LieAlgebra, Matrix, Vector};
/// use euler_poincare::group::so3::hat;
/// use euler_poincare::integrators::advected::{Advected, AdvectedLagrangian, AdvectedState, Representation, RepresentationError};
/// use euler_poincare::mechanics::force::Zero;
/// use euler_poincare::scalar::{Real, Scalar};
/// use euler_poincare::tableau::Family;
///
/// /// A heavy top: l = ½ η·Iη − r·Γ, where the vertical Γ in the body is advected.
/// struct Top;
///
/// impl<T: Real> AdvectedLagrangian<T, 3, 3> for Top {
///     fn value<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, 3>, gamma: &Vector<S, 3>) -> S {
///         (eta[0] * eta[0] + eta[1] * eta[1] + eta[2] * eta[2] * S::half()) * S::half() - gamma[2]
///     }
/// }
///
/// let so3 = LieAlgebra::<f64, 3>::from_catalogue(&Entry::So3)?;
/// let axes = [Vector::<f64, 3>::x(), Vector::<f64, 3>::y(), Vector::<f64, 3>::z()];
/// let vectors = Representation::new(so3, axes.map(|axis| hat(&axis)))?;
/// let mut method = Advected::new(Top, Zero, vectors, Family::Gauss.tableau(2)?);
/// let (momentum, parameter) = (Covector::<f64, 3>::new(0.0, 0.0, 2.5), Vector::<f64, 3>::new(-0.6, 0.0, 0.8));
/// let mut state = AdvectedState { time: 0.0, momentum, parameter };
/// for _ in 0..100 {
///     method.step(&mut state, 0.05)?;
/// }
/// // |Γ|² and ⟨μ, Γ⟩ are Casimirs of the semidirect product, and the spin of a symmetric top is kept.
/// assert!((state.parameter.norm() - 1.0).abs() < 1e-13);
/// assert!(((state.momentum * state.parameter)[0] - 2.0).abs() < 1e-12 && (state.momentum[2] - 2.5).abs() < 1e-12);
///
/// let so3 = LieAlgebra::<f64, 3>::from_catalogue(&Entry::So3)?;
/// let wrong = Representation::new(so3, [Matrix::<f64, 1>::identity(); 3]);
/// assert!(matches!(wrong, Err(RepresentationError::NotAHomomorphism { .. })));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Advected<T: Real, const N: usize, const V: usize, L, F> {
    method: Engine<T, N, V, L, F>,
}

type Engine<T, const N: usize, const V: usize, L, F> =
    Variational<T, N, V, LagrangianOn<Carried<L, T, V>, Image<T, N, V>, V>, F, Exponential<T, N, V, Image<T, N, V>>>;

impl<T, const N: usize, const V: usize, L, F> Advected<T, N, V, L, F>
where
    T: Real,
    L: AdvectedLagrangian<T, N, V>,
    F: Force<T, N>,
{
    /// The integrator for l, a force f(t, η), a representation on V, and a tableau.
    pub fn new(lagrangian: L, force: F, representation: Representation<T, N, V>, tableau: Tableau<T>) -> Self {
        let carried = Carried { lagrangian, parameter: Vector::zeros() };
        let image = Image(representation);
        let retraction = Exponential::of_group(image.clone());
        Self { method: Variational::new(LagrangianOn::new(carried, image), force, retraction, tableau) }
    }

    /// Replaces `state` by the state after a step of size `h` (of either sign); on an error `state` is unchanged.
    ///
    /// # Errors
    /// Those of [`Variational`]; a force that depends on the configuration, of which a is all that there is.
    pub fn step(&mut self, state: &mut AdvectedState<T, N, V>, h: T) -> Result<Report<T>, StepError> {
        if state.parameter.iter().any(|v| !v.all_finite()) {
            return Err(StepError::NotFinite { what: "the advected parameter" });
        }
        if self.method.force().uses_configuration() {
            let why = "the force depends on the configuration, where there is an advected parameter alone".into();
            return Err(StepError::Unsupported { why });
        }
        self.method.lagrangian_mut().lagrangian_mut().parameter = state.parameter;
        let mut moved = State { time: state.time, momentum: state.momentum, attitude: Matrix::identity() };
        let report = self.method.step(&mut moved, h)?;
        let back =
            elimination::inverse(&moved.attitude).ok_or(StepError::NotFinite { what: "the advected parameter" })?;
        *state = AdvectedState { time: moved.time, momentum: moved.momentum, parameter: back * state.parameter };
        Ok(report)
    }
}
