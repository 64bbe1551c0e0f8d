//! Events: zeros of functions of the state along a run.

use super::error::SolveError;
use crate::integrators::State;
use crate::scalar::Real;

/// ITP: the bracket loses at least as much as by bisection, after this many steps more.
const SLACK: i32 = 1;

/// ITP: the point of the secant is moved towards the middle by this share of the square of the bracket, in units of the first one
/// (Oliveira and Takahashi 2021, κ₁ = 0.2/(b − a), κ₂ = 2).
const TRUNCATION: f64 = 0.2;

/// A real function of the state.
type Function<'a, T, const N: usize, const D: usize> = dyn FnMut(&State<T, N, D>) -> T + 'a;

/// An event: where a real function of (t, g, μ) passes through zero.
///
/// The sign is looked at after every step: two zeros within one step are not seen, unless
/// [`max_step`](super::Solve::max_step) is shorter. A function that is 0 at the start of the run does not count there, but where it passes
/// through zero again; one that touches 0 from above at the end of a step and rises again counts as falling. The time is found to a quarter of
/// the tolerance times the step, from the states between the ends of the step, which are within the tolerance. A pole, where the sign changes
/// as well, is no event.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix};
/// use euler_poincare::integrators::State;
/// use euler_poincare::integrators::solve::{End, Event, Located, Solve};
/// use euler_poincare::mechanics::{force::Zero, lagrangian::Quadratic};
/// use euler_poincare::retraction::CayleySo3;
///
/// // A symmetric body: its axis turns about the momentum, and μ₁ = cos(λt) passes zero at π/2λ, 3π/2λ, …
/// let body = Quadratic::diagonal([1.0, 1.0, 2.0])?;
/// let start = State { time: 0.0, momentum: Covector::<f64, 3>::new(1.0, 0.0, 1.0), attitude: Matrix::<f64, 3>::identity() };
/// let zero = Event::new(|state: &State<f64, 3, 3>| state.momentum[0]).falling().terminal();
/// let mut solve = Solve::new(body, Zero, CayleySo3::new()).tolerance(1e-10).event(zero);
/// let solution = solve.run(&start, 100.0)?;
/// let found: &Located<f64, 3, 3> = &solution.events[0];
/// assert_eq!((solution.end, found.rising), (End::Event(0), false));
/// assert!((found.state.time - std::f64::consts::PI).abs() < 1e-8);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Event<'a, T: Real, const N: usize, const D: usize> {
    function: Box<Function<'a, T, N, D>>,
    /// Which signs after the zero count: those of a rising and of a falling function.
    rising: bool,
    falling: bool,
    pub(super) terminal: bool,
}

impl<'a, T: Real, const N: usize, const D: usize> Event<'a, T, N, D> {
    /// Zeros of `function`, in both directions; the run goes on after them.
    pub fn new(function: impl FnMut(&State<T, N, D>) -> T + 'a) -> Self {
        Self { function: Box::new(function), rising: true, falling: true, terminal: false }
    }

    /// Only where the function rises, in the direction of the run.
    pub fn rising(mut self) -> Self {
        (self.rising, self.falling) = (true, false);
        self
    }

    /// Only where the function falls, in the direction of the run.
    pub fn falling(mut self) -> Self {
        (self.rising, self.falling) = (false, true);
        self
    }

    /// The run ends at the first of them.
    pub fn terminal(mut self) -> Self {
        self.terminal = true;
        self
    }

    /// The value at a state; `index` is for the error.
    pub(super) fn value(&mut self, index: usize, state: &State<T, N, D>) -> Result<T, SolveError> {
        let value = (self.function)(state);
        match value.all_finite() {
            true => Ok(value),
            false => Err(SolveError::EventValue { index, time: state.time.to_f64(), value: value.to_f64() }),
        }
    }

    /// Whether the function passes zero from one value to another, and counts: whether it rises.
    pub(super) fn passes(&self, before: T, after: T) -> Option<bool> {
        let zero = T::zero();
        let rising = before < zero && after >= zero;
        let falling = before > zero && after <= zero;
        ((rising && self.rising) || (falling && self.falling)).then_some(rising)
    }
}

/// The end of a bracket of length at most `width` of the zero of `value` in [0, 1], where it has the values `ends` of opposite signs: the
/// end at which it has the sign of the second, or vanishes. None where the values at both ends are larger than any at first: a pole.
///
/// Source: Oliveira and Takahashi, *An enhancement of the bisection method average performance preserving minmax optimality*, ACM
/// Transactions on Mathematical Software 47 (2021).
pub(super) fn bracket<T: Real, E>(
    ends: [T; 2],
    width: T,
    mut value: impl FnMut(T) -> Result<T, E>,
) -> Result<Option<T>, E> {
    let (mut a, mut b) = (T::zero(), T::one());
    let [mut at_a, mut at_b] = ends;
    let halvings = -width.to_f64().log2().min(0.0).floor() as i32;
    let mut allowance = width * T::half() * T::exact(f64::exp2(f64::from(halvings + SLACK)));
    while b - a > width && at_b != T::zero() {
        let middle = (a + b) * T::half();
        let secant = (at_b * a - at_a * b) / (at_b - at_a);
        let towards = if middle < secant { -T::one() } else { T::one() };
        let shift = T::exact(TRUNCATION) * (b - a) * (b - a);
        let moved = if shift <= (middle - secant).abs() { secant + towards * shift } else { middle };
        let radius = allowance - (b - a) * T::half();
        let point = if (moved - middle).abs() <= radius { moved } else { middle - towards * radius };
        allowance *= T::half();
        // The point of the secant may round to an end.
        let inside = |x: T| a < x && x < b;
        let point = if inside(point) { point } else { middle };
        if !inside(point) {
            break;
        }
        let at = value(point)?;
        if (at < T::zero()) == (at_a < T::zero()) && at != T::zero() {
            (a, at_a) = (point, at);
        } else {
            (b, at_b) = (point, at);
        }
    }
    let first = ends[0].abs().max(ends[1].abs());
    let pole = at_a.abs() > first && at_b.abs() > first;
    Ok((!pole).then_some(b))
}
