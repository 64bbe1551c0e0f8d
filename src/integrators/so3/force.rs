//! Forces in lanes: what the fast kernels of SO(3) and SE(3) evaluate for eight stages, or for eight bodies, at once.

use super::retraction::{LaneRetraction, add_coad, add_cross, add_scaled, coad, less_coad, scale};
use super::terms::LaneForceError;
use super::{Row, Vec3};
use crate::algebra::{Covector, Vector};
use crate::integrators::lanes::{Formula, Lanes, One};
use crate::mechanics::Force;
use crate::mechanics::configuration::Configuration;
use crate::mechanics::lagrangian::Quadratic;
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
#[doc(hidden)]
pub struct Pose<V> {
    /// The rows of R.
    pub rows: [Vec3<V>; 3],
    /// x.
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

/// A force f(t, g, η) ∈ g* in lanes, or −∂_gV of a potential, with covectors as columns; so(3)* unless N says otherwise.
///
/// Implementations must be `#[inline(always)]`: they are compiled into the kernel, for each kind of registers. Newton's
/// method behind the kernel evaluates the same lines on one lane of any scalar ([`OnBody`]). Forces are added as pairs. The stages have
/// g_i = g τ(Ξ_i), and what enters there is F_i = ∂_gL(g_i) + f(t_i, g_i, η_i) (Marsden and West 2001, §3.2; the scheme is that of
/// [`Variational`](crate::integrators::Variational)).
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::lanes::Lanes;
/// use euler_poincare::integrators::so3::{Gravity, LaneAttitude, LaneForce, VariationalSo3};
/// use euler_poincare::integrators::{OneStep, State};
/// use euler_poincare::mechanics::lagrangian::Quadratic;
/// use euler_poincare::retraction::CayleySo3;
/// use euler_poincare::tableau::Family;
///
/// /// Proportional-derivative control: the torque −4 (R − Rᵀ)^∨/2 − 3 η turns the body to R = 1.
/// #[derive(Clone)]
/// struct Controller;
///
/// impl LaneForce for Controller {
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
/// let force = (Gravity([0.0, 0.0, 0.65]), Controller);
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
pub trait LaneForce<const N: usize = 3>: Clone + Send + Sync {
    /// sum + f(t, g, η), where M = l'(η) is at hand.
    fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N];

    /// Whether the force depends on g, which is so unless the force says otherwise: a step without g is faster.
    fn uses_attitude(&self) -> bool {
        true
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
    fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, _: V, _: G, _: [V; N], _: [V; N], sum: [V; N]) -> [V; N] {
        sum
    }

    fn uses_attitude(&self) -> bool {
        false
    }

    fn vanishes(&self) -> bool {
        true
    }
}

/// The sum of two forces.
impl<A: LaneForce<N>, B: LaneForce<N>, const N: usize> LaneForce<N> for (A, B) {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, t: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        self.1.add_to(t, g, m, eta, self.0.add_to(t, g, m, eta, sum))
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

impl<C: Coefficient> LaneForce for Gravity<C> {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, _: V, g: G, _: Vec3<V>, _: Vec3<V>, sum: Vec3<V>) -> Vec3<V> {
        let axis = g.row(2);
        add_cross(sum, axis, each!(3, a => self.0[a].lanes(axis[0])))
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
    fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, t: V, _: G, _: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        let f = V::one_by_one(self, t, eta);
        each!(N, k => sum[k] + f[k])
    }

    fn uses_attitude(&self) -> bool {
        false
    }

    fn vanishes(&self) -> bool {
        self.0.is_zero()
    }
}

/// α ad*_ζ M, ζ = (ad*_Ω M)ᵀ: the damping of Landau, Lifshitz and Gilbert, which keeps |M|². On SO(3) α M × (M × Ω).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping<C = f64>(pub C);

impl<C: Coefficient, const N: usize> LaneForce<N> for Damping<C> {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, _: V, _: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        // Not α ((M·Ω) M − |M|² Ω), with fewer operations, whose rounding errors are not orthogonal to M.
        let alpha = self.0.lanes(m[0]);
        add_coad(sum, each!(N, k => alpha * m[k]), coad(m, eta))
    }

    fn uses_attitude(&self) -> bool {
        false
    }

    fn vanishes_when_steady(&self) -> bool {
        true
    }
}

/// −β ad*_Ω ad*_Ω M: relaxation, which keeps the energy. On SO(3) β (Ω × M) × Ω.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Relaxation<C = f64>(pub C);

impl<C: Coefficient, const N: usize> LaneForce<N> for Relaxation<C> {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V>>(&self, _: V, _: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        let beta = self.0.lanes(m[0]);
        less_coad(sum, coad(m, eta), each!(N, k => beta * eta[k]))
    }

    fn uses_attitude(&self) -> bool {
        false
    }

    fn vanishes_when_steady(&self) -> bool {
        true
    }
}

/// ad*_η m + f, one body with the pose in a packed state: μ̇ there.
#[inline]
pub(in crate::integrators) fn slope<F: LaneForce<N>, const N: usize>(
    force: &F,
    time: f64,
    rows: &[Row; N],
    m: [f64; N],
    eta: [f64; N],
) -> [f64; N] {
    let (m, eta) = (each!(N, k => One(m[k])), each!(N, k => One(eta[k])));
    let slope = force.add_to(One(time), PackedPose { rows, like: One(time) }, m, eta, coad(m, eta));
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
        let f = self.force.add_to(One(t), pose, m, eta, zero);
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
/// A force of one's own without coefficients is packed as itself: `Packed = Self`. One with coefficients has two forms, as [`Damping`] of
/// `f64` and of [`Row`]. Kernels want an optimised build: without any optimisation their frames exceed the stack of a thread.
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
