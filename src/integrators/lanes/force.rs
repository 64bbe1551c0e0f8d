//! Forces in lanes: what the kernels evaluate for eight stages, or for eight bodies, at once.

use super::group::LaneGroup;
use super::vectors::{add_cross, add_scaled, first, scale};
use super::{Row, Vec3};
use crate::algebra::{Covector, Matrix, Vector};
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

/// Where a body is at a stage, g_i = g τ(Ξ_i), as a force in lanes sees it; and ad* of its group. Only what a force asks for is computed.
pub trait LaneAttitude<V: Lanes, const N: usize = 3, const D: usize = 3>: Copy {
    /// Row r of the matrix g, from 0. On SO(3) it is gᵀe, with e the axis r of space; Γ = gᵀe₃ is row 2.
    fn row(self, r: usize) -> [V; D];

    /// sum + ad*_η m.
    fn add_coad(self, sum: [V; N], m: [V; N], eta: [V; N]) -> [V; N];

    /// Rᵀ b, with the rotation R of g on SO(3) and SE(3): a vector of space in the axes of the body.
    #[inline(always)]
    fn in_body(self, b: Vec3<V>) -> Vec3<V> {
        let [x, y, z] = [first(self.row(0)), first(self.row(1)), first(self.row(2))];
        add_scaled(add_scaled(scale(b[0], x), b[1], y), b[2], z)
    }

    /// The position x of g on SE(3).
    #[inline(always)]
    fn position(self) -> Vec3<V> {
        each!(3, r => self.row(r)[D - 1])
    }
}

/// A matrix g of a group.
#[doc(hidden)]
#[derive(Debug)]
pub struct Pose<'a, V, R, const D: usize> {
    /// Its rows.
    pub rows: [[V; D]; D],
    /// The group.
    pub group: &'a R,
}

impl<V: Copy, R, const D: usize> Clone for Pose<'_, V, R, D> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<V: Copy, R, const D: usize> Copy for Pose<'_, V, R, D> {}

impl<V: Lanes, R: LaneGroup<N, D>, const N: usize, const D: usize> LaneAttitude<V, N, D> for Pose<'_, V, R, D> {
    #[inline(always)]
    fn row(self, r: usize) -> [V; D] {
        self.rows[r]
    }

    #[inline(always)]
    fn add_coad(self, sum: [V; N], m: [V; N], eta: [V; N]) -> [V; N] {
        self.group.add_coad(sum, m, eta)
    }
}

/// The attitude in a packed state, in every lane: read where it is asked for.
#[derive(Debug)]
pub(in crate::integrators) struct PackedPose<'a, V, R, const D: usize> {
    /// Its columns.
    pub columns: &'a [Row; D],
    pub group: &'a R,
    pub like: V,
}

impl<V: Copy, R, const D: usize> Clone for PackedPose<'_, V, R, D> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<V: Copy, R, const D: usize> Copy for PackedPose<'_, V, R, D> {}

impl<V: Lanes, R: LaneGroup<N, D>, const N: usize, const D: usize> LaneAttitude<V, N, D> for PackedPose<'_, V, R, D> {
    #[inline(always)]
    fn row(self, r: usize) -> [V; D] {
        each!(D, c => self.like.constant(self.columns[c].0[r]))
    }

    #[inline(always)]
    fn add_coad(self, sum: [V; N], m: [V; N], eta: [V; N]) -> [V; N] {
        self.group.add_coad(sum, m, eta)
    }
}

/// g τ(x), from g and what the operations at x share.
pub(in crate::integrators) struct Moved<'a, G, R: LaneGroup<N, D>, V: Lanes, const N: usize, const D: usize> {
    pub from: G,
    pub group: &'a R,
    pub at: &'a R::At<V>,
    pub x: [V; N],
}

impl<G: Copy, R: LaneGroup<N, D>, V: Lanes, const N: usize, const D: usize> Clone for Moved<'_, G, R, V, N, D> {
    #[inline(always)]
    fn clone(&self) -> Self {
        *self
    }
}

impl<G: Copy, R: LaneGroup<N, D>, V: Lanes, const N: usize, const D: usize> Copy for Moved<'_, G, R, V, N, D> {}

impl<G, R, V, const N: usize, const D: usize> LaneAttitude<V, N, D> for Moved<'_, G, R, V, N, D>
where
    G: LaneAttitude<V, N, D>,
    R: LaneGroup<N, D>,
    V: Lanes,
{
    #[inline(always)]
    fn row(self, r: usize) -> [V; D] {
        self.group.moved(self.at, self.x, self.from.row(r))
    }

    #[inline(always)]
    fn add_coad(self, sum: [V; N], m: [V; N], eta: [V; N]) -> [V; N] {
        self.group.add_coad(sum, m, eta)
    }
}

/// A force f(t, g, η) ∈ g* in lanes, or −∂_gV of a potential, with covectors as columns; on SO(3) unless N and D say otherwise.
///
/// Implementations must be `#[inline(always)]`: they are compiled into the kernel, for each kind of registers. Newton's
/// method behind the kernel evaluates the same lines on one lane of any scalar ([`OnBody`]). Forces are added as pairs. The stages have
/// g_i = g τ(Ξ_i), and what enters there is F_i = ∂_gL(g_i) + f(t_i, g_i, η_i) (Marsden and West 2001, §3.2; the scheme is that of
/// [`Variational`](crate::integrators::Variational)).
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::lanes::{Gravity, LaneAttitude, LaneForce, Lanes, VariationalInLanes};
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
/// let mut method = VariationalInLanes::new(body, force, CayleySo3::new(), Family::Gauss.tableau(2)?)?;
/// let momentum = Covector::<f64, 3>::new(0.5, 0.3, 0.9);
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::identity() };
/// for _ in 0..400 {
///     method.step(&mut state, 0.05)?;
/// }
/// assert!(state.momentum.norm() < 1e-3 && (state.attitude[(2, 2)] - 1.0).abs() < 1e-4);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub trait LaneForce<const N: usize = 3, const D: usize = 3>: Clone + Send + Sync {
    /// sum + f(t, g, η), where M = l'(η) is at hand.
    fn add_to<V: Lanes, G: LaneAttitude<V, N, D>>(&self, t: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N];

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

impl<const N: usize, const D: usize> LaneForce<N, D> for Free {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V, N, D>>(&self, _: V, _: G, _: [V; N], _: [V; N], sum: [V; N]) -> [V; N] {
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
impl<A: LaneForce<N, D>, B: LaneForce<N, D>, const N: usize, const D: usize> LaneForce<N, D> for (A, B) {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V, N, D>>(&self, t: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
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

/// A [`Force`] f(t, g, η) of one's own, in each lane by itself; of a potential of one's own by
/// [`OfPotential`](crate::mechanics::configuration::OfPotential).
///
/// It costs as many evaluations as there are lanes, 8 in an iteration of all stages; all else is done in lanes. A force that is written
/// over [`Lanes`], as a [`LaneForce`] of one's own, takes less.
#[derive(Clone, Copy, Debug)]
pub struct ByLane<F>(pub F);

/// The force without g where D is 0.
impl<F: Force<f64, N>, const N: usize, const D: usize> Formula<N, D> for ByLane<F> {
    #[inline(always)]
    fn value<S: Scalar<Base = f64>>(&self, t: S, g: [[S; D]; D], x: [S; N]) -> [S; N] {
        let eta = Vector::from(x);
        let f = if D == 0 {
            self.0.force(t, &eta)
        } else {
            self.0.force_at(t, Configuration::of(&Matrix::<S, D>::from_fn(|r, c| g[r][c])), &eta)
        };
        std::array::from_fn(|a| f[a])
    }
}

impl<F: Force<f64, N> + Clone + Send + Sync, const N: usize, const D: usize> LaneForce<N, D> for ByLane<F> {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V, N, D>>(&self, t: V, g: G, _: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        let f = if self.0.uses_configuration() {
            V::one_by_one(self, t, each!(D, r => g.row(r)), eta)
        } else {
            V::one_by_one::<_, N, 0>(self, t, [], eta)
        };
        each!(N, k => sum[k] + f[k])
    }

    fn uses_attitude(&self) -> bool {
        self.0.uses_configuration()
    }

    fn vanishes(&self) -> bool {
        self.0.is_zero()
    }
}

/// α ad*_ζ M, ζ = (ad*_Ω M)ᵀ: the damping of Landau, Lifshitz and Gilbert, which keeps |M|². On SO(3) α M × (M × Ω).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Damping<C = f64>(pub C);

impl<C: Coefficient, const N: usize, const D: usize> LaneForce<N, D> for Damping<C> {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V, N, D>>(&self, _: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        // Not α ((M·Ω) M − |M|² Ω), with fewer operations, whose rounding errors are not orthogonal to M.
        let alpha = self.0.lanes(m[0]);
        g.add_coad(sum, each!(N, k => alpha * m[k]), g.add_coad([alpha.constant(0.0); N], m, eta))
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

impl<C: Coefficient, const N: usize, const D: usize> LaneForce<N, D> for Relaxation<C> {
    #[inline(always)]
    fn add_to<V: Lanes, G: LaneAttitude<V, N, D>>(&self, _: V, g: G, m: [V; N], eta: [V; N], sum: [V; N]) -> [V; N] {
        let beta = self.0.lanes(m[0]);
        g.add_coad(sum, g.add_coad([beta.constant(0.0); N], m, eta), each!(N, k => -(beta * eta[k])))
    }

    fn uses_attitude(&self) -> bool {
        false
    }

    fn vanishes_when_steady(&self) -> bool {
        true
    }
}

/// ad*_η m + f, one body with the attitude in a packed state: μ̇ there.
#[inline]
pub(in crate::integrators) fn slope<F: LaneForce<N, D>, R: LaneGroup<N, D>, const N: usize, const D: usize>(
    force: &F,
    group: &R,
    time: f64,
    columns: &[Row; D],
    [m, eta]: [[f64; N]; 2],
) -> [f64; N] {
    let (m, eta) = (each!(N, k => One(m[k])), each!(N, k => One(eta[k])));
    let here = PackedPose { columns, group, like: One(time) };
    let slope = force.add_to(One(time), here, m, eta, group.coad(m, eta));
    each!(N, k => slope[k].0)
}

/// A force in lanes as a [`Force`] on the body of inertia `lagrangian`: what Newton's method differentiates.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct OnBody<F, R, const N: usize = 3, const D: usize = 3> {
    /// The force.
    pub force: F,
    /// The group.
    pub group: R,
    /// The body.
    pub lagrangian: Quadratic<f64, N>,
}

impl<F: LaneForce<N, D>, R: LaneGroup<N, D>, const N: usize, const D: usize> Force<f64, N> for OnBody<F, R, N, D> {
    fn force<S: Scalar<Base = f64>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        self.force_at(t, Configuration::identity(), eta)
    }

    fn force_at<S: Scalar<Base = f64>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        use crate::mechanics::Lagrangian;
        let m = self.lagrangian.gradient(eta);
        let zero = [One(S::zero()); N];
        let (m, eta) = (std::array::from_fn(|a| One(m[a])), std::array::from_fn(|a| One(eta[a])));
        let rows = std::array::from_fn(|r| std::array::from_fn(|c| One(g.entry(r, c))));
        let f = self.force.add_to(One(t), Pose { rows, group: &self.group }, m, eta, zero);
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
