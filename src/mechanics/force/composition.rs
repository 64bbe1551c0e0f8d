//! Forces made of others: multiplied, or driven by a function of the time.

use super::ForceError;
use crate::algebra::{Covector, Vector};
use crate::mechanics::configuration::Configuration;
use crate::mechanics::{Force, at_the_identity};
use crate::scalar::{Real, Scalar};

/// A function of the time u(t) ∈ ℝ.
pub trait Signal<T: Real> {
    /// u(t).
    fn value<S: Scalar<Base = T>>(&self, t: S) -> S;

    /// Whether it has all derivatives at every time.
    fn is_smooth(&self) -> bool {
        true
    }
}

/// u(t) = k.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Factor<T>(pub T);

impl<T: Real> Signal<T> for Factor<T> {
    fn value<S: Scalar<Base = T>>(&self, _t: S) -> S {
        S::lift(self.0)
    }
}

/// How a control goes from one given value to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Hold {
    /// Constant until the next time: a jump there (zero-order hold).
    Zero,
    /// The natural cubic spline through the values (de Boor 1978, chapter IV): two continuous derivatives.
    Spline,
}

/// A control u(t) through values at given times; before the first and after the last it keeps their values.
///
/// Across a jump, or where a higher derivative jumps, no method has its order: let steps end there.
///
/// ```
/// use euler_poincare::algebra::{Covector, Vector};
/// use euler_poincare::mechanics::Force;
/// use euler_poincare::mechanics::force::{Constant, Control, Driven, Factor, ForceError, Hold, Signal};
///
/// let thrust = Constant::new(Covector::<f64, 3>::new(0.0, 0.0, 2.0))?;
/// let switch = Control::new(vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 0.0], Hold::Zero)?;
/// let spline = Control::new(vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 0.0], Hold::Spline)?;
/// assert_eq!((switch.value(0.5), switch.value(1.5), spline.value(1.0)), (0.0, 1.0, 1.0));
/// assert!((spline.value(0.5) - 0.6875).abs() < 1e-15);
/// let driven = Driven::new(thrust.clone(), switch);
/// let half = Driven::new(thrust, Factor(0.5));
/// let eta = Vector::<f64, 3>::zeros();
/// assert_eq!((driven.force(1.5, &eta)[2], half.force(1.5, &eta)[2]), (2.0, 1.0));
/// let refused = Control::new(vec![1.0, 0.0], vec![0.0, 1.0], Hold::Zero);
/// assert!(matches!(refused, Err(ForceError::BadControl { .. })));
/// # Ok::<(), ForceError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Control<T> {
    times: Vec<T>,
    values: Vec<T>,
    /// Second derivatives at the times; all 0 for a zero-order hold.
    curvatures: Vec<T>,
    hold: Hold,
}

impl<T: Real> Control<T> {
    /// The control with `values` at `times`, which increase.
    ///
    /// # Errors
    /// No times, as many values as there are not times, times that do not increase, a number that is not finite.
    pub fn new(times: Vec<T>, values: Vec<T>, hold: Hold) -> Result<Self, ForceError> {
        let refused = |why: String| Err(ForceError::BadControl { why });
        if times.is_empty() || times.len() != values.len() {
            return refused(format!("{} times and {} values", times.len(), values.len()));
        }
        if let Some(k) = times.iter().chain(&values).position(|v| !v.all_finite()) {
            return refused(format!("number {} of the times and values is not finite", k + 1));
        }
        if let Some(k) = times.windows(2).position(|pair| pair[0] >= pair[1]) {
            return refused(format!("time {} is not above the one before", k + 2));
        }
        let curvatures = match hold {
            Hold::Zero => vec![T::zero(); times.len()],
            Hold::Spline => natural(&times, &values),
        };
        Ok(Self { times, values, curvatures, hold })
    }
}

/// The second derivatives of the natural cubic spline, by elimination in a tridiagonal matrix with a dominant diagonal.
fn natural<T: Real>(times: &[T], values: &[T]) -> Vec<T> {
    let n = times.len();
    let mut curvatures = vec![T::zero(); n];
    let (mut diagonal, mut right) = (vec![T::one(); n], vec![T::zero(); n]);
    let step = |k: usize| times[k + 1] - times[k];
    let slope = |k: usize| (values[k + 1] - values[k]) / step(k);
    for k in 1..n.saturating_sub(1) {
        diagonal[k] = (step(k - 1) + step(k)) * T::int(2);
        right[k] = (slope(k) - slope(k - 1)) * T::int(6);
        if k > 1 {
            let factor = step(k - 1) / diagonal[k - 1];
            let (above, known) = (step(k - 1), right[k - 1]);
            diagonal[k] -= factor * above;
            right[k] -= factor * known;
        }
    }
    for k in (1..n.saturating_sub(1)).rev() {
        curvatures[k] = (right[k] - step(k) * curvatures[k + 1]) / diagonal[k];
    }
    curvatures
}

impl<T: Real> Signal<T> for Control<T> {
    fn value<S: Scalar<Base = T>>(&self, t: S) -> S {
        let after = self.times.partition_point(|time| *time <= t.base());
        let last = self.times.len() - 1;
        if after == 0 || after > last || self.hold == Hold::Zero {
            return S::lift(self.values[after.max(1).min(last + 1) - 1]);
        }
        let k = after - 1;
        let h = S::lift(self.times[after] - self.times[k]);
        let b = (t - S::lift(self.times[k])) / h;
        let a = S::one() - b;
        let bend = |x: S, curvature: T| (x * x * x - x) * S::lift(curvature);
        a * S::lift(self.values[k])
            + b * S::lift(self.values[after])
            + (bend(a, self.curvatures[k]) + bend(b, self.curvatures[after])) * h * h / S::int(6)
    }

    fn is_smooth(&self) -> bool {
        self.times.len() == 1
    }
}

/// u(t) f(t, g, η): a force multiplied by a number ([`Factor`]) or by a control ([`Control`]).
#[derive(Clone, Debug, PartialEq)]
pub struct Driven<F, U> {
    force: F,
    signal: U,
}

impl<F, U> Driven<F, U> {
    /// f and u.
    pub fn new(force: F, signal: U) -> Self {
        Self { force, signal }
    }
}

impl<T: Real, const N: usize, F: Force<T, N>, U: Signal<T>> Force<T, N> for Driven<F, U> {
    at_the_identity!(force);

    fn force_at<S: Scalar<Base = T>>(&self, t: S, g: Configuration<'_, S>, eta: &Vector<S, N>) -> Covector<S, N> {
        self.force.force_at(t, g, eta) * self.signal.value(t)
    }

    fn undefined(&self, t: T, g: Configuration<'_, T>, eta: &Vector<T, N>) -> Option<String> {
        let signal = || (!self.signal.value(t).all_finite()).then(|| "the signal has no finite value".to_owned());
        self.force.undefined(t, g, eta).or_else(signal)
    }

    fn uses_configuration(&self) -> bool {
        self.force.uses_configuration()
    }

    fn is_zero(&self) -> bool {
        self.force.is_zero()
    }

    fn is_smooth(&self) -> bool {
        self.force.is_smooth() && self.signal.is_smooth()
    }
}
