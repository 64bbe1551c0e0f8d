//! Forces in lanes: what the fast kernels of SO(3) evaluate for eight stages, or for eight bodies, at once.

use super::retraction::{LaneRetraction, add_cross, add_scaled, cross, dot, less_scaled, scale};
use super::{Row, Vec3};
use crate::algebra::{Covector, LieAlgebra, Matrix, Vector};
use crate::integrators::lanes::{Formula, Lanes};
use crate::mechanics::Force;
use crate::mechanics::configuration::Configuration;
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

/// Where a body is at a stage, g_i = g τ(Ξ_i), as a force in lanes sees it: the rotation R from the body to space, and on SE(3) the
/// position x. Only what a force asks for is computed.
pub trait LaneAttitude<V: Lanes>: Copy {
    /// Row r of R, from 0: Rᵀ e, with e the axis r of space. Γ = Rᵀ e₃ is row 2.
    fn row(self, r: usize) -> Vec3<V>;

    /// x; on SO(3) it is 0.
    fn position(self) -> Vec3<V>;

    /// Rᵀ b: a vector of space in the axes of the body.
    #[inline(always)]
    fn in_body(self, b: Vec3<V>) -> Vec3<V> {
        add_scaled(add_scaled(scale(b[0], self.row(0)), b[1], self.row(1)), b[2], self.row(2))
    }
}

/// The rows of a rotation, and a position.
#[derive(Clone, Copy)]
pub(in crate::integrators) struct Pose<V> {
    pub rows: [Vec3<V>; 3],
    pub position: Vec3<V>,
}

impl<V: Lanes> Pose<V> {
    /// The identity, in registers of the kind of `like`.
    #[inline(always)]
    pub fn identity(like: V) -> Self {
        let zero = like.constant(0.0);
        let rows = each!(3, r => each!(3, c => like.constant(if r == c { 1.0 } else { 0.0 })));
        Self { rows, position: [zero; 3] }
    }
}

impl<V: Lanes> LaneAttitude<V> for Pose<V> {
    #[inline(always)]
    fn row(self, r: usize) -> Vec3<V> {
        self.rows[r]
    }

    #[inline(always)]
    fn position(self) -> Vec3<V> {
        self.position
    }
}

/// The pose in a packed state, in every lane: read where it is asked for.
#[derive(Clone, Copy)]
pub(super) struct PackedPose<'a, V, const N: usize> {
    pub rows: &'a [Row; N],
    pub like: V,
}

impl<V: Lanes, const N: usize> LaneAttitude<V> for PackedPose<'_, V, N> {
    /// The columns of R are the last three rows, in lanes 0, 1, 2.
    #[inline(always)]
    fn row(self, r: usize) -> Vec3<V> {
        each!(3, c => self.like.constant(self.rows[N - 3 + c].0[r]))
    }

    /// On SE(3) the first row.
    #[inline(always)]
    fn position(self) -> Vec3<V> {
        each!(3, r => self.like.constant(if N > 3 { self.rows[0].0[r] } else { 0.0 }))
    }
}

/// g τ(x), from g and what the operations at x share.
#[derive(Clone, Copy)]
pub(super) struct Moved<G, R: LaneRetraction<N>, V: Lanes, const N: usize> {
    pub from: G,
    pub at: R::At<V>,
    pub x: [V; N],
}

impl<G: LaneAttitude<V>, R: LaneRetraction<N>, V: Lanes, const N: usize> LaneAttitude<V> for Moved<G, R, V, N> {
    #[inline(always)]
    fn row(self, r: usize) -> Vec3<V> {
        R::seen(self.at, self.x, self.from.row(r))
    }

    #[inline(always)]
    fn position(self) -> Vec3<V> {
        R::placed(self.at, self.x, self.from.position(), each!(3, r => self.from.row(r)))
    }
}

/// A force f(t, g, η) ∈ g* in lanes, with covectors as columns; so(3)* unless N says otherwise.
///
/// Implementations must be `#[inline(always)]`: they are compiled into the kernel, for each kind of registers. Newton's
/// method behind the kernel evaluates the same lines on one lane of any scalar ([`OnBody`]). A force that depends on g is a
/// [`LaneForceOnGroup`]; forces are added as pairs.
pub trait LaneForce<const N: usize = 3>: Clone + Send + Sync {
    /// sum + f(t, η), where M = l'(η) is at hand; of a force that depends on g its value at the identity.
    fn add_to<V: Lanes>(&self, t: V, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N];

    /// sum + f(t, g, η): what the kernels ask for. The same as without g, unless the force says otherwise.
    #[inline(always)]
    fn add_at<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        let _ = g;
        self.add_to(t, m, eta, sum)
    }

    /// Whether the force depends on g.
    fn uses_attitude(&self) -> bool {
        false
    }

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

/// A force f(t, g, η) ∈ g* in lanes of one's own, or −∂_gV of a potential. [`OnAttitude`] makes a [`LaneForce`] of it.
///
/// The formula is that of [`LaneForce`]: covectors are columns, `#[inline(always)]`, M = l'(η) at hand. The stages have
/// g_i = g τ(Ξ_i), and what enters there is F_i = ∂_gL(g_i) + f(t_i, g_i, η_i) (Marsden and West 2001, §3.2; the scheme is that of
/// [`Variational`](crate::integrators::Variational)).
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::lanes::Lanes;
/// use euler_poincare::integrators::so3::{Gravity, LaneAttitude, LaneForceOnGroup, OnAttitude, VariationalSo3};
/// use euler_poincare::integrators::{OneStep, State};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::CayleySo3;
/// use euler_poincare::tableau::Family;
///
/// /// Proportional-derivative control: the torque −4 (R − Rᵀ)^∨/2 − 3 η turns the body to R = 1.
/// #[derive(Clone)]
/// struct Controller;
///
/// impl LaneForceOnGroup for Controller {
///     #[inline(always)]
///     fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, _m: [V; 3], eta: [V; 3], sum: [V; 3]) -> [V; 3] {
///         let (x, y, z) = (g.row(0), g.row(1), g.row(2));
///         let (two, three) = (t.constant(2.0), t.constant(3.0));
///         let error = [z[1] - y[2], x[2] - z[0], y[0] - x[1]];
///         let torque = |a: usize| sum[a] - two * error[a] - three * eta[a];
///         [torque(0), torque(1), torque(2)]
///     }
/// }
///
/// // A heavy top that is turned upright: its weight times its centre of mass, and the control.
/// let force = (Gravity([0.0, 0.0, 0.65]), OnAttitude(Controller));
/// let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
/// let mut method = VariationalSo3::new(body, force, CayleySo3::new(), Family::Gauss.tableau(2)?)?;
/// let momentum = Covector::<f64, 3>::new(0.5, 0.3, 0.9);
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::identity() };
/// for _ in 0..400 {
///     method.step(&mut state, 0.05)?;
/// }
/// assert!(state.momentum.norm() < 1e-3 && (state.attitude[(2, 2)] - 1.0).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait LaneForceOnGroup<const N: usize = 3>: Clone + Send + Sync {
    /// sum + f(t, g, η), where M = l'(η) is at hand.
    fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N];
}

/// A force that depends on g as a [`LaneForce`]: what it is there without g is that at the identity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OnAttitude<F>(pub F);

impl<F: LaneForceOnGroup<N>, const N: usize> LaneForce<N> for OnAttitude<F> {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, t: V, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        self.0.add_to(t, Pose::identity(t), m, eta, sum)
    }

    #[inline(always)]
    fn add_at<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        self.0.add_to(t, g, m, eta, sum)
    }

    fn uses_attitude(&self) -> bool {
        true
    }
}

/// The sum of two forces.
impl<A: LaneForce<N>, B: LaneForce<N>, const N: usize> LaneForce<N> for (A, B) {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, t: V, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        self.1.add_to(t, m, eta, self.0.add_to(t, m, eta, sum))
    }

    #[inline(always)]
    fn add_at<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        self.1.add_at(t, g, m, eta, self.0.add_at(t, g, m, eta, sum))
    }

    fn uses_attitude(&self) -> bool {
        self.0.uses_attitude() || self.1.uses_attitude()
    }

    fn vanishes(&self) -> bool {
        self.0.vanishes() && self.1.vanishes()
    }

    fn vanishes_when_steady(&self) -> bool {
        self.0.vanishes_when_steady() && self.1.vanishes_when_steady()
    }
}

/// The weight of a body on SO(3), which turns about a fixed point: −c × Γ, Γ = gᵀe₃, of V = ⟨c, Γ⟩ with c the weight times the centre
/// of mass.
///
/// With it a step has Γ at each stage, `Γ_i = τ(Ξ_i)ᵀ Γ`, and nothing else of g.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gravity<C = f64>(pub [C; 3]);

impl<C: Coefficient> Gravity<C> {
    #[inline(always)]
    fn add<V: Lanes, G: LaneAttitude<V>>(&self, g: G, sum: Vec3<V>) -> Vec3<V> {
        let axis = g.row(2);
        add_cross(sum, axis, each!(3, a => self.0[a].lanes(axis[0])))
    }
}

impl<C: Coefficient> LaneForce for Gravity<C> {
    #[inline(always)]
    fn add_to<V: Lanes>(&self, t: V, _m: Vec3<V>, _eta: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
        self.add(Pose::identity(t), sum)
    }

    #[inline(always)]
    fn add_at<V: Lanes, G: LaneAttitude<V>>(&self, _t: V, g: G, _m: Vec3<V>, _eta: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
        self.add(g, sum)
    }

    fn uses_attitude(&self) -> bool {
        true
    }
}

/// A [`Force`] f(t, η) of one's own, in each lane by itself.
///
/// It costs as many evaluations as there are lanes, 8 in an iteration of all stages; all else is done in lanes. A force that is written
/// over [`Lanes`], as a [`LaneForce`] of one's own, takes less.
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
    /// −c × Γ, Γ = gᵀe₃: [`Gravity`]; c is the weight times the centre of mass.
    Gravity([C; 3]),
    /// m × gᵀB: a moment m of the body in a uniform field B of space, V = −⟨g m, B⟩.
    UniformField([C; 3], [C; 3]),
}

impl<C: Coefficient> Term<C> {
    #[inline(always)]
    fn add_at<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, m: Vec3<V>, eta: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
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
            Self::Gravity(lever) => Gravity(*lever).add(g, sum),
            Self::UniformField(moment, field) => {
                let field = g.in_body(each!(3, a => field[a].lanes(t)));
                add_cross(sum, each!(3, a => moment[a].lanes(t)), field)
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
    fn add_to<V: Lanes>(&self, t: V, m: Vec3<V>, eta: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
        self.add_at(t, Pose::identity(t), m, eta, sum)
    }

    #[inline(always)]
    fn add_at<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, m: Vec3<V>, eta: Vec3<V>, mut sum: Vec3<V>) -> Vec3<V> {
        for term in &self.0 {
            sum = term.add_at(t, g, m, eta, sum);
        }
        sum
    }

    fn uses_attitude(&self) -> bool {
        self.0.iter().any(|term| matches!(term, Term::Gravity(_) | Term::UniformField(..)))
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
        "the force depends on the configuration: in lanes it is a LaneForceOnGroup; else take integrators::Solve or Variational"
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
        match other.kinetic() {
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

/// ad*_η m + f, one body with the pose in a packed state: μ̇ there.
#[inline]
pub(in crate::integrators) fn slope<F: LaneForce<N>, R: LaneRetraction<N>, const N: usize>(
    force: &F,
    time: f64,
    rows: &[Row; N],
    m: [f64; N],
    eta: [f64; N],
) -> [f64; N] {
    let (m, eta) = (each!(N, k => One(m[k])), each!(N, k => One(eta[k])));
    let slope = force.add_at(One(time), PackedPose { rows, like: One(time) }, m, eta, R::coad(m, eta));
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
        self.force_at(t, Configuration::identity(), eta)
    }

    fn force_at<S: Scalar<Base = f64>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        use crate::mechanics::Lagrangian;
        let m = self.lagrangian.gradient(eta);
        let zero = [One(S::zero()); N];
        let (m, eta) = (std::array::from_fn(|a| One(m[a])), std::array::from_fn(|a| One(eta[a])));
        let pose = Pose {
            rows: std::array::from_fn(|r| std::array::from_fn(|c| One(g.entry(r, c)))),
            // Outside the matrix of a rotation an entry is that of the identity, 0.
            position: std::array::from_fn(|r| One(g.entry(r, 3))),
        };
        let f = self.force.add_at(One(t), pose, m, eta, zero);
        Covector::<S, N>::from_fn(|_, a| f[a].0)
    }

    fn uses_configuration(&self) -> bool {
        self.force.uses_attitude()
    }

    fn is_zero(&self) -> bool {
        self.force.vanishes()
    }
}

/// A force on one body of an ensemble, whose coefficients may differ from body to body.
///
/// A force of one's own without coefficients is packed as itself: `Packed = Self`. One with coefficients has two forms (kernels want an
/// optimised build: without any optimisation their frames exceed the stack of a thread):
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

impl EnsembleForce for Gravity {
    type Packed = Gravity<Row>;

    fn pack(forces: [&Self; 8]) -> Gravity<Row> {
        Gravity(std::array::from_fn(|a| Row(forces.map(|f| f.0[a]))))
    }
}

impl<A: EnsembleForce, B: EnsembleForce> EnsembleForce for (A, B) {
    type Packed = (A::Packed, B::Packed);

    fn pack(forces: [&Self; 8]) -> Self::Packed {
        (A::pack(forces.map(|f| &f.0)), B::pack(forces.map(|f| &f.1)))
    }
}

impl<C: Copy> Term<C> {
    /// The coefficients in a fixed order, and how to make such a term of others.
    fn coefficients(&self) -> Vec<C> {
        match self {
            Self::Damping(c) | Self::Relaxation(c) => vec![*c],
            Self::LinearDrag(m) | Self::QuadraticDrag(m) => m.iter().flatten().copied().collect(),
            Self::Constant(v) | Self::Gravity(v) => v.to_vec(),
            Self::UniformField(moment, field) => moment.iter().chain(field).copied().collect(),
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
            Self::Gravity(_) => Term::Gravity(vector()),
            Self::UniformField(..) => Term::UniformField(vector(), std::array::from_fn(|a| of(3 + a))),
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
