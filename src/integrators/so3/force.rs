//! Forces in lanes: what the fast kernels of SO(3) evaluate for eight stages, or for eight bodies, at once.

use super::retraction::{LaneRetraction, add_cross, add_scaled, cross, dot, less_scaled, scale};
use super::{Row, Vec3};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::integrators::lanes::{Formula, Lanes};
use crate::mechanics::Force;
use crate::mechanics::force::AnyForce;
use crate::mechanics::lagrangian::{AnyLagrangian, Quadratic};
use crate::scalar::Scalar;

/// A coefficient: one number for all lanes, or eight numbers.
#[doc(hidden)]
pub trait Coefficient: Copy + Send + Sync {
    /// The coefficient in lanes of the kind of `like`.
    fn lanes<V: Lanes>(self, like: V) -> V;
}

impl Coefficient for f64 {
    #[inline(always)]
    fn lanes<V: Lanes>(self, like: V) -> V {
        like.constant(self)
    }
}

impl Coefficient for Row {
    #[inline(always)]
    fn lanes<V: Lanes>(self, like: V) -> V {
        like.read(&self.0)
    }
}

/// A force f(t, η) ∈ g* in lanes, with covectors as columns; so(3)* unless N says otherwise.
///
/// Implementations must be `#[inline(always)]`: they are compiled into the kernel, for each kind of registers. Newton's
/// method behind the kernel evaluates the same lines on one lane of any scalar ([`OnBody`]).
pub trait LaneForce<const N: usize = 3>: Clone + Send + Sync {
    /// sum + f(t, η), where M = l'(η) is at hand.
    fn add_to<V: Lanes>(&self, t: V, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N];

    /// Whether the force vanishes identically.
    fn vanishes(&self) -> bool {
        false
    }

    /// Whether f(t, η) = 0 wherever ad*_η M = 0. With such a force a motion with a constant direction of η is a steady one;
    /// with others it has errors that δ does not see, and a solver that chooses its steps looks at more than δ.
    fn vanishes_when_steady(&self) -> bool {
        self.vanishes()
    }
}

/// No force.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Free;

impl<const N: usize> LaneForce<N> for Free {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, _t: V, _m: [V; N], _eta: [V; N], sum: [V; N]) -> [V; N] {
        sum
    }

    fn vanishes(&self) -> bool {
        true
    }
}

/// A [`Force`] f(t, η) of one's own, in each lane by itself.
///
/// It costs as many evaluations as there are lanes, 8 in an iteration of all stages; all else is done in lanes. A force that is written
/// over [`Lanes`], as a [`LaneForce`] of one's own, takes less.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix, Vector};
/// use euler_poincare::integrators::State;
/// use euler_poincare::integrators::so3::{AdaptiveSo3, ByLane, LaneForceError};
/// use euler_poincare::mechanics::{Force, lagrangian::Quadratic};
/// use euler_poincare::scalar::{Real, Scalar};
///
/// /// M × (M × Ω).
/// #[derive(Clone)]
/// struct Damping;
///
/// impl<T: Real> Force<T, 3> for Damping {
///     fn force<S: Scalar<Base = T>>(&self, _: S, eta: &Vector<S, 3>) -> Covector<S, 3> {
///         let m = Vector::<S, 3>::new(eta[0] * S::half(), eta[1] * S::int(2), eta[2]);
///         m.cross(&m.cross(eta)).transpose()
///     }
/// }
///
/// let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
/// let force: Result<_, LaneForceError> = ByLane::new(Damping);
/// let mut solver = AdaptiveSo3::new(body, force?);
/// let momentum = Covector::<f64, 3>::new(0.5, 0.0, 1.0) / 2.0_f64.sqrt();
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::identity() };
/// solver.solve(&mut state, 1.0, 1e-12)?;
/// assert!((state.momentum[0] - 0.2414593544179369).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct ByLane<F, const N: usize = 3>(F);

impl<F: Force<f64, N>, const N: usize> ByLane<F, N> {
    /// The force in lanes.
    ///
    /// # Errors
    /// [`LaneForceError::NeedsConfiguration`]: it depends on the attitude.
    pub fn new(force: F) -> Result<Self, LaneForceError> {
        if force.uses_configuration() { Err(LaneForceError::NeedsConfiguration) } else { Ok(Self(force)) }
    }

    /// The force.
    pub fn force(&self) -> &F {
        &self.0
    }
}

impl<F: Force<f64, N>, const N: usize> Formula<N> for ByLane<F, N> {
    #[inline(always)]
    fn value<S: Scalar<Base = f64>>(&self, t: S, x: [S; N]) -> [S; N] {
        let f = self.0.force(t, &Vector::from(x));
        std::array::from_fn(|a| f[a])
    }
}

impl<F: Force<f64, N> + Clone + Send + Sync, const N: usize> LaneForce<N> for ByLane<F, N> {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, t: V, _m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        let f = V::one_by_one(self, t, eta);
        each!(N, k => sum[k] + f[k])
    }

    fn vanishes(&self) -> bool {
        self.0.is_zero()
    }
}

/// α M × (M × Ω): the damping of Landau, Lifshitz and Gilbert, which keeps |M|².
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping<C = f64>(pub C);

impl<C: Coefficient> LaneForce for Damping<C> {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, _t: V, m: Vec3<V>, eta: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
        // Not α ((M·Ω) M − |M|² Ω), with fewer operations, whose rounding errors are not orthogonal to M.
        add_cross(sum, scale(self.0.lanes(m[0]), m), cross(m, eta))
    }

    fn vanishes_when_steady(&self) -> bool {
        true
    }
}

/// β (Ω × M) × Ω: relaxation, which keeps the energy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxation<C = f64>(pub C);

impl<C: Coefficient> LaneForce for Relaxation<C> {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, _t: V, m: Vec3<V>, eta: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
        add_cross(sum, scale(self.0.lanes(m[0]), eta), cross(m, eta))
    }

    fn vanishes_when_steady(&self) -> bool {
        true
    }
}

/// A term of a force of the catalogue, with coefficients `C`.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Term<C = f64> {
    /// α M × (M × Ω).
    Damping(C),
    /// β (Ω × M) × Ω.
    Relaxation(C),
    /// −D Ω.
    LinearDrag([[C; 3]; 3]),
    /// −√(Ωᵀ D Ω) D Ω.
    QuadraticDrag([[C; 3]; 3]),
    /// A given torque.
    Constant([C; 3]),
    /// A torque times cos(ω t + φ): torque, ω, φ.
    Periodic([C; 3], C, C),
}

impl<C: Coefficient> Term<C> {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, t: V, m: Vec3<V>, eta: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
        let minus = t.constant(-1.0);
        match self {
            Self::Damping(alpha) => Damping(*alpha).add_to(t, m, eta, sum),
            Self::Relaxation(beta) => Relaxation(*beta).add_to(t, m, eta, sum),
            Self::LinearDrag(matrix) => add_scaled(sum, minus, apply(matrix, eta)),
            Self::QuadraticDrag(matrix) => {
                let drag = apply(matrix, eta);
                let square = dot(drag, eta).max(t.constant(0.0));
                less_scaled(sum, square.sqrt(), drag)
            }
            Self::Constant(torque) => each!(3, a => sum[a] + torque[a].lanes(t)),
            Self::Periodic(torque, frequency, phase) => {
                let factor = frequency.lanes(t).mul_add(t, phase.lanes(t)).cos();
                each!(3, a => torque[a].lanes(t).mul_add(factor, sum[a]))
            }
        }
    }
}

#[inline(always)]
fn apply<C: Coefficient, V: Lanes>(matrix: &[[C; 3]; 3], x: Vec3<V>) -> Vec3<V> {
    each!(3, row => {
        let [c0, c1, c2] = matrix[row];
        c2.lanes(x[0]).mul_add(x[2], c1.lanes(x[0]).mul_add(x[1], c0.lanes(x[0]) * x[0]))
    })
}

/// A force of the catalogue as a list of terms.
#[derive(Clone, Debug, PartialEq)]
pub struct Terms<C = f64>(pub Vec<Term<C>>);

impl<C: Coefficient> LaneForce for Terms<C> {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, t: V, m: Vec3<V>, eta: Vec3<V>, mut sum: Vec3<V>) -> Vec3<V> {
        for term in &self.0 {
            sum = term.add_to(t, m, eta, sum);
        }
        sum
    }

    fn vanishes(&self) -> bool {
        self.0.is_empty()
    }

    fn vanishes_when_steady(&self) -> bool {
        self.0.iter().all(|term| matches!(term, Term::Damping(_) | Term::Relaxation(_)))
    }
}

/// Why a force of the catalogue has no form in lanes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LaneForceError {
    /// The force was built on structure constants other than those of R³ with the cross product.
    #[error("the {force} force belongs to an algebra other than so(3) with the cross product")]
    OtherAlgebra {
        /// Which force.
        force: &'static str,
    },
    /// A force that the kernels do not have.
    #[error("the {force} force has no form in lanes on SO(3)")]
    NoForm {
        /// Which force.
        force: &'static str,
    },
    /// A force that depends on the attitude.
    #[error(
        "the force depends on the configuration, which the kernels in lanes do not have: take integrators::Solve or Variational"
    )]
    NeedsConfiguration,
    /// The force was built with a Lagrangian other than that of the body.
    #[error("the {force} force was built with another Lagrangian than the body's")]
    OtherLagrangian {
        /// Which force.
        force: &'static str,
    },
}

impl Terms {
    /// The terms of a force of the catalogue that acts on a body of inertia `lagrangian`.
    ///
    /// # Errors
    /// A force that has no form in lanes, or depends on the momentum and was built on another algebra or another Lagrangian.
    pub fn new(force: &AnyForce<f64, 3>, lagrangian: &Quadratic<f64, 3>) -> Result<Self, LaneForceError> {
        let mut terms = Vec::new();
        collect(force, lagrangian, &mut terms)?;
        Ok(Self(terms))
    }
}

fn collect(
    force: &AnyForce<f64, 3>,
    lagrangian: &Quadratic<f64, 3>,
    terms: &mut Vec<Term>,
) -> Result<(), LaneForceError> {
    let name = force.name();
    let same = |algebra: &LieAlgebra<f64, 3>, other: &AnyLagrangian<f64, 3>| {
        if algebra != &crate::group::LieGroup::algebra(&crate::group::So3::<f64>::new()).clone() {
            return Err(LaneForceError::OtherAlgebra { force: name });
        }
        match other {
            AnyLagrangian::Quadratic(other) if other == lagrangian => Ok(()),
            _ => Err(LaneForceError::OtherLagrangian { force: name }),
        }
    };
    if force.is_zero() {
        return Ok(());
    }
    let rows = |m: &Matrix<f64, 3>| std::array::from_fn(|r| std::array::from_fn(|c| m[(r, c)]));
    let row = |m: &Covector<f64, 3>| std::array::from_fn(|c| m[c]);
    terms.push(match force {
        AnyForce::Sum(sum) => return sum.iter().try_for_each(|term| collect(term, lagrangian, terms)),
        AnyForce::DoubleBracket(f) => {
            same(f.algebra(), f.lagrangian())?;
            Term::Damping(f.alpha())
        }
        AnyForce::Metriplectic(f) => {
            same(f.algebra(), f.lagrangian())?;
            Term::Relaxation(f.beta())
        }
        AnyForce::LinearDrag(f) => Term::LinearDrag(rows(f.matrix())),
        AnyForce::QuadraticDrag(f) => Term::QuadraticDrag(rows(f.matrix())),
        AnyForce::Constant(f) => Term::Constant(row(f.covector())),
        AnyForce::Periodic(f) => Term::Periodic(row(f.covector()), f.frequency(), f.phase()),
        // A force that vanishes has been seen to.
        other => return Err(LaneForceError::NoForm { force: other.name() }),
    });
    Ok(())
}

/// One lane: the numbers themselves, so that a force in lanes is also a [`Force`] on any scalar.
#[derive(Clone, Copy)]
pub(in crate::integrators) struct One<S>(pub S);

macro_rules! operator {
    ($($trait:ident $name:ident),*) => {$(
        impl<S: Scalar> std::ops::$trait for One<S> {
            type Output = Self;
            #[inline]
            fn $name(self, other: Self) -> Self {
                Self(std::ops::$trait::$name(self.0, other.0))
            }
        }
    )*};
}

operator!(Add add, Sub sub, Mul mul, Div div);

impl<S: Scalar> std::ops::Neg for One<S> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

impl<S: Scalar<Base = f64>> Lanes for One<S> {
    #[inline]
    fn constant(self, x: f64) -> Self {
        Self(S::exact(x))
    }

    #[inline]
    fn mul_add(self, b: Self, c: Self) -> Self {
        Self(self.0 * b.0 + c.0)
    }

    #[inline]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        Self(c.0 - self.0 * b.0)
    }

    #[inline]
    fn sqrt(self) -> Self {
        // The derivative of √ at 0 is infinite: there a product with 0 must stay 0.
        if self.0 <= S::zero() { Self(S::zero()) } else { Self(self.0.sqrt()) }
    }

    #[inline]
    fn abs(self) -> Self {
        Self(self.0.abs())
    }

    #[inline]
    fn max(self, other: Self) -> Self {
        if self.0 < other.0 { other } else { self }
    }

    #[inline]
    fn cos(self) -> Self {
        Self(self.0.cos())
    }

    #[inline]
    fn read(self, x: &[f64; 8]) -> Self {
        self.constant(x[0])
    }

    #[inline]
    fn one_by_one<F: Formula<N>, const N: usize>(f: &F, t: Self, x: [Self; N]) -> [Self; N] {
        f.value(t.0, x.map(|v| v.0)).map(One)
    }
}

/// ad*_η m + f, one body: μ̇ there.
#[inline]
pub(in crate::integrators) fn slope<F: LaneForce<N>, R: LaneRetraction<N>, const N: usize>(
    force: &F,
    time: f64,
    m: [f64; N],
    eta: [f64; N],
) -> [f64; N] {
    let (m, eta) = (each!(N, k => One(m[k])), each!(N, k => One(eta[k])));
    let slope = force.add_to(One(time), m, eta, R::coad(m, eta));
    each!(N, k => slope[k].0)
}

/// A force in lanes as a [`Force`] on the body of inertia `lagrangian`: what Newton's method differentiates.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct OnBody<F, const N: usize = 3> {
    /// The force.
    pub force: F,
    /// The body.
    pub lagrangian: Quadratic<f64, N>,
}

impl<F: LaneForce<N>, const N: usize> Force<f64, N> for OnBody<F, N> {
    fn force<S: Scalar<Base = f64>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        use crate::mechanics::Lagrangian;
        let m = self.lagrangian.gradient(eta);
        let zero = [One(S::zero()); N];
        let (m, eta) = (std::array::from_fn(|a| One(m[a])), std::array::from_fn(|a| One(eta[a])));
        let f = self.force.add_to(One(t), m, eta, zero);
        Covector::<S, N>::from_fn(|_, a| f[a].0)
    }

    fn is_zero(&self) -> bool {
        self.force.vanishes()
    }
}

/// A force on one body of an ensemble, whose coefficients may differ from body to body.
///
/// A force of one's own without coefficients is packed as itself: `Packed = Self`. One with coefficients has two forms (kernels want an
/// optimised build: without any optimisation their frames exceed the stack of a thread):
///
/// ```no_run
/// use euler_poincare::algebra::Covector;
/// use euler_poincare::integrators::State;
/// use euler_poincare::integrators::lanes::Lanes;
/// use euler_poincare::integrators::so3::{EnsembleForce, EnsembleSo3, LaneForce, Member, Row};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::CayleySo3;
/// use euler_poincare::tableau::Family;
///
/// /// −c M: with a number for one body, or with eight.
/// #[derive(Clone)]
/// struct Decay<C>(C);
///
/// impl LaneForce for Decay<f64> {
///     #[inline(always)]
///     fn add_to<V: Lanes>(&self, t: V, m: [V; 3], _: [V; 3], sum: [V; 3]) -> [V; 3] {
///         let c = t.constant(self.0);
///         [sum[0] - c * m[0], sum[1] - c * m[1], sum[2] - c * m[2]]
///     }
/// }
///
/// impl LaneForce for Decay<Row> {
///     #[inline(always)]
///     fn add_to<V: Lanes>(&self, t: V, m: [V; 3], _: [V; 3], sum: [V; 3]) -> [V; 3] {
///         let c = t.read(&self.0.0);
///         [sum[0] - c * m[0], sum[1] - c * m[1], sum[2] - c * m[2]]
///     }
/// }
///
/// impl EnsembleForce for Decay<f64> {
///     type Packed = Decay<Row>;
///
///     fn pack(forces: [&Self; 8]) -> Decay<Row> {
///         Decay(Row(forces.map(|force| force.0)))
///     }
/// }
///
/// let body = Quadratic::diagonal([1.0, 2.0, 3.0])?;
/// let start = State::at_identity(Covector::<f64, 3>::new(0.6, 0.0, 0.8));
/// let member = |k: u8| Member { lagrangian: body.clone(), force: Decay(f64::from(k)), state: start.clone() };
/// let members: Vec<_> = (0..10).map(member).collect();
/// let mut ensemble = EnsembleSo3::new(&members, CayleySo3::new(), Family::Gauss.tableau(4)?)?;
/// ensemble.advance(0.0625, 16)?;
/// for (k, state) in ensemble.states().enumerate() {
///     assert!((state.momentum.norm() - (-(k as f64)).exp()).abs() < 1e-9);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait EnsembleForce: LaneForce {
    /// The same force with eight sets of coefficients, for the eight bodies of a group.
    type Packed: LaneForce;

    /// The forces of eight bodies as one.
    fn pack(forces: [&Self; 8]) -> Self::Packed;
}

impl EnsembleForce for Free {
    type Packed = Self;

    fn pack(_: [&Self; 8]) -> Self {
        Self
    }
}

impl EnsembleForce for Damping {
    type Packed = Damping<Row>;

    fn pack(forces: [&Self; 8]) -> Damping<Row> {
        Damping(Row(forces.map(|f| f.0)))
    }
}

impl EnsembleForce for Relaxation {
    type Packed = Relaxation<Row>;

    fn pack(forces: [&Self; 8]) -> Relaxation<Row> {
        Relaxation(Row(forces.map(|f| f.0)))
    }
}

impl<C: Copy> Term<C> {
    /// The coefficients in a fixed order, and how to make such a term of others.
    fn coefficients(&self) -> Vec<C> {
        match self {
            Self::Damping(c) | Self::Relaxation(c) => vec![*c],
            Self::LinearDrag(m) | Self::QuadraticDrag(m) => m.iter().flatten().copied().collect(),
            Self::Constant(v) => v.to_vec(),
            Self::Periodic(v, frequency, phase) => v.iter().copied().chain([*frequency, *phase]).collect(),
        }
    }

    /// A term of this kind with the coefficients `of(0)`, `of(1)`, …
    fn rebuilt<E>(&self, of: impl Fn(usize) -> E) -> Term<E> {
        let matrix = || std::array::from_fn(|r| std::array::from_fn(|c| of(3 * r + c)));
        let vector = || std::array::from_fn(&of);
        match self {
            Self::Damping(_) => Term::Damping(of(0)),
            Self::Relaxation(_) => Term::Relaxation(of(0)),
            Self::LinearDrag(_) => Term::LinearDrag(matrix()),
            Self::QuadraticDrag(_) => Term::QuadraticDrag(matrix()),
            Self::Constant(_) => Term::Constant(vector()),
            Self::Periodic(..) => Term::Periodic(vector(), of(3), of(4)),
        }
    }
}

impl EnsembleForce for Terms {
    type Packed = Terms<Row>;

    /// A term for each kind that one of the bodies has, as often as it has it; with zeros for bodies that lack it.
    fn pack(forces: [&Self; 8]) -> Terms<Row> {
        let mut packed = Vec::new();
        let mut taken = [const { Vec::<usize>::new() }; 8];
        while let Some(example) = (0..8).find_map(|lane| {
            forces[lane].0.iter().enumerate().find(|(k, _)| !taken[lane].contains(k)).map(|(_, term)| *term)
        }) {
            let same = |term: &Term| std::mem::discriminant(term) == std::mem::discriminant(&example);
            let lanes: [Vec<f64>; 8] = std::array::from_fn(|lane| {
                let found = forces[lane].0.iter().enumerate().find(|(k, term)| !taken[lane].contains(k) && same(term));
                found.map_or_else(Vec::new, |(k, term)| {
                    taken[lane].push(k);
                    term.coefficients()
                })
            });
            packed
                .push(example.rebuilt(|k| Row(std::array::from_fn(|lane| lanes[lane].get(k).copied().unwrap_or(0.0)))));
        }
        Terms(packed)
    }
}
