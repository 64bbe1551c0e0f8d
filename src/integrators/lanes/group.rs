//! A group with a retraction in lanes: all that a step knows of it.

use super::Lanes;
use crate::retraction::Retraction;

/// A group of D×D matrices of dimension N, with τ and its tangents, as operations on vectors in lanes; covectors are columns here.
///
/// Displacements, and their rates, are held in lanes in the unit u = [`UNIT`](Self::UNIT): the arguments `x`, `back`, `y` of
/// these operations are x/u and y/u, and what [`displacement`](Self::displacement) and [`rate`](Self::rate) return is.
///
/// Implementations must be `#[inline(always)]`, as those of [`LaneForce`](super::LaneForce).
#[doc(hidden)]
pub trait LaneGroup<const N: usize = 3, const D: usize = 3>: Clone + std::fmt::Debug + Send + Sync + 'static {
    /// Whether lanes hold half of a displacement: where the formulas contain x/2 alone, as those of the Cayley map.
    const HALVED: bool;

    /// The unit of displacements, 1 or 2.
    const UNIT: f64 = if Self::HALVED { 2.0 } else { 1.0 };

    /// What the operations at x share.
    type At<V: Lanes>: Copy;

    /// sum + ad*_η m.
    fn add_coad<V: Lanes>(&self, sum: [V; N], m: [V; N], eta: [V; N]) -> [V; N];
    /// ad*_η m.
    #[inline(always)]
    fn coad<V: Lanes>(&self, m: [V; N], eta: [V; N]) -> [V; N] {
        self.add_coad([m[0].constant(0.0); N], m, eta)
    }

    /// The coefficients at x; those of [`rate`](Self::rate), [`unpull`](Self::unpull) and [`pull_dd`](Self::pull_dd) alone, where no
    /// more is asked for.
    fn at<V: Lanes>(&self, x: [V; N], whole: bool) -> Self::At<V>;
    /// p dτ_x⁻¹.
    fn unpull<V: Lanes>(&self, at: &Self::At<V>, x: [V; N], p: [V; N]) -> [V; N];
    /// dτ_x⁻¹ η/u, with η/u for the argument `eta`; [`gradient`](Self::gradient) has η itself.
    fn rate<V: Lanes>(&self, at: &Self::At<V>, x: [V; N], eta: [V; N]) -> [V; N];
    /// f dτ_x.
    fn pull<V: Lanes>(&self, at: &Self::At<V>, x: [V; N], f: [V; N]) -> [V; N];
    /// f Ad_{τ(x)}⁻¹ − f; on SO(3) the rotation τ(x) applied to f, less f.
    fn turned<V: Lanes>(&self, at: &Self::At<V>, x: [V; N], f: [V; N]) -> [V; N];
    /// f Ad_{τ(x)}⁻¹.
    #[inline(always)]
    fn carried<V: Lanes>(&self, at: &Self::At<V>, x: [V; N], f: [V; N]) -> [V; N] {
        let turned = self.turned(at, x, f);
        each!(N, k => f[k] + turned[k])
    }
    /// p ddτ_x(y, ·), y = dτ_x⁻¹ η, with m = p dτ_x⁻¹, and so p y = m η.
    fn pull_dd<V: Lanes>(&self, at: &Self::At<V>, x: [V; N], p: [V; N], m: [V; N], eta: [V; N], y: [V; N]) -> [V; N];
    /// p ddτ_x(y, ·) + f dτ_x.
    #[inline(always)]
    #[allow(clippy::too_many_arguments, reason = "values in registers; all are inlined")]
    fn gradient<V: Lanes>(
        &self,
        at: &Self::At<V>,
        x: [V; N],
        p: [V; N],
        m: [V; N],
        eta: [V; N],
        y: [V; N],
        f: [V; N],
    ) -> [V; N] {
        let (gradient, pulled) = (self.pull_dd(at, x, p, m, eta, y), self.pull(at, x, f));
        each!(N, k => gradient[k] + pulled[k])
    }
    /// dτ_x⁻¹ η in the unit of displacements, and p ddτ_x(dτ_x⁻¹ η, ·) + f dτ_x, with η and η in this unit at hand.
    #[inline(always)]
    fn stage<V: Lanes>(
        &self,
        at: &Self::At<V>,
        x: [V; N],
        [p, m]: [[V; N]; 2],
        [eta, in_unit]: [[V; N]; 2],
        force: Option<[V; N]>,
    ) -> [[V; N]; 2] {
        let rate = self.rate(at, x, in_unit);
        let gradient = match force {
            Some(force) => self.gradient(at, x, p, m, eta, rate, force),
            None => self.pull_dd(at, x, p, m, eta, rate),
        };
        [rate, gradient]
    }
    /// A row of g times τ(x).
    fn moved<V: Lanes>(&self, at: &Self::At<V>, x: [V; N], row: [V; D]) -> [V; D];
    /// A row of g times τ(x)⁻¹, less the row.
    fn moved_back<V: Lanes>(&self, at: &Self::At<V>, x: [V; N], row: [V; D]) -> [V; D];
    /// x after the time t, from the rates η at its start, in its middle and at its end, to t⁴: τ(x) = exp(σ),
    /// σ = t/6 (η₀ + 4η_½ + η₁) + t/12 \[σ, η₁ − η₀\] (Magnus 1954; Hairer, Lubich and Wanner 2006, IV.7,
    /// with the bracket of g' = g η).
    fn displacement<V: Lanes>(&self, t: V, first: [V; N], middle: [V; N], last: [V; N]) -> [V; N];
    /// How far x is from 0, in a measure of which [`in_domain`](Self::in_domain) knows.
    fn distance<V: Lanes>(&self, at: &Self::At<V>, x: [V; N]) -> V;
    /// Whether the formulas hold to round-off up to this distance.
    fn in_domain(&self, distance: f64) -> bool;

    /// The angle that g turns by in a unit of time: √(−tr(η̂²)/2) where the trace is negative, and as much where it is not.
    fn turning(&self, eta: [f64; N]) -> f64;
    /// A displacement next to 0 that turns g as x does.
    fn wound(&self, x: [f64; N]) -> [f64; N] {
        x
    }
    /// The size of the leading block of g that is orthogonal; 0 where there is none.
    fn rotation(&self) -> usize;
}

/// A retraction that has a form in lanes; on SO(3) unless the dimensions say otherwise.
pub trait FastRetraction<const N: usize = 3, const D: usize = 3>: Retraction<f64, N, D> + Clone {
    /// That form.
    type Lanes: LaneGroup<N, D>;

    /// A retraction with which a steady motion is one step of any size.
    type Steady: FastRetraction<N, D>;

    /// That retraction, if it is another than this and there is one.
    fn steady(&self) -> Option<Self::Steady> {
        None
    }

    /// The form of this retraction.
    fn in_lanes(&self) -> Self::Lanes;
}
