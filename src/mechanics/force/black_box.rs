//! Forces that are functions of numbers alone: closures, tables, foreign code.

use crate::algebra::{Covector, Matrix, Vector};
use crate::mechanics::Force;
use crate::mechanics::configuration::{ForceOnGroup, OnGroup};
use crate::scalar::{Real, Scalar};

/// A force that is a function of numbers: a closure, a look-up table, a call into another language, a `Box<dyn Fn…>`.
///
/// Its values are used as they are. Its derivatives, which Newton's method asks for where fixed-point iterations do not converge, are
/// central differences: two calls for each direction and 2/3 of the digits, four calls and half of the digits for a mixed second
/// derivative. A step that Newton's method solves calls it about 2 s N + 1 times for every stage and iteration. Its values need not be
/// smooth; the order of convergence is that of its smoothness.
///
/// ```
/// use euler_poincare::algebra::{Covector, Matrix, Vector};
/// use euler_poincare::integrators::{OneStep, State, Variational};
/// use euler_poincare::mechanics::force::BlackBox;
/// use euler_poincare::mechanics::{force::Zero, lagrangian::Quadratic};
/// use euler_poincare::retraction::ExponentialSo3;
/// use euler_poincare::tableau::Family;
///
/// let drag = BlackBox::new(|_t: f64, eta: &Vector<f64, 3>| -0.1 * eta.transpose());
/// // The torque of a spring about the first axis, by the attitude; chosen at run time.
/// type Torque = Box<dyn Fn(f64, &Matrix<f64, 3>, &Vector<f64, 3>) -> Covector<f64, 3>>;
/// let spring: Torque = Box::new(|_, g, _| Covector::<f64, 3>::new(-g[(2, 1)].atan2(g[(2, 2)]), 0.0, 0.0));
/// let body = Quadratic::diagonal([0.5, 2.0, 1.0])?;
/// let forces = (drag, BlackBox::on_group(spring));
/// let mut method = Variational::new(body, forces, ExponentialSo3::new(), Family::Gauss.tableau(2)?);
/// let momentum = Covector::<f64, 3>::new(0.4, 0.1, 0.7);
/// let mut state = State { time: 0.0, momentum, attitude: Matrix::<f64, 3>::identity() };
/// method.step(&mut state, 0.1)?;
/// assert!(state.momentum.norm() < momentum.norm());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct BlackBox<B>(B);

impl<B> BlackBox<B> {
    /// f(t, η).
    pub fn new<T, const N: usize>(force: B) -> Self
    where
        T: Real,
        B: Fn(T, &Vector<T, N>) -> Covector<T, N>,
    {
        Self(force)
    }

    /// f(t, g, η).
    pub fn on_group<T, const N: usize, const D: usize>(force: B) -> OnGroup<Self, D>
    where
        T: Real,
        B: Fn(T, &Matrix<T, D>, &Vector<T, N>) -> Covector<T, N>,
    {
        OnGroup(Self(force))
    }
}

/// Every value and derivative part of f at arguments that have derivative parts, `numbers` of `arguments` scalars with `NESTING` duals.
///
/// The part of the ε in the set A is the mixed derivative, in the s_i with i in A, of f at Σ_B c_B Π_{i∈B} s_i: by central differences with
/// the displacement that balances rounding and truncation (Press, Teukolsky, Vetterling and Flannery 2007, §5.7).
fn parts<T: Real, S: Scalar<Base = T>, const N: usize>(
    arguments: &[S],
    f: impl Fn(&[T]) -> Covector<T, N>,
) -> Covector<S, N> {
    let count = 1usize << S::NESTING;
    let (mut given, mut found) = (Vec::with_capacity(arguments.len() * count), vec![T::zero(); N * count]);
    arguments.iter().for_each(|argument| argument.write(&mut given));
    let largest = |part: usize| (0..arguments.len()).fold(T::zero(), |m, k| m.max(given[k * count + part].abs()));
    let mut point = vec![T::zero(); arguments.len()];
    for set in 0..count {
        let order = set.count_ones();
        let extent =
            (0..count).filter(|part| part & set == *part && *part > 0).fold(T::zero(), |m, part| m.max(largest(part)));
        if order > 0 && extent == T::zero() {
            continue;
        }
        // The displacement that balances rounding, u/δ^order, and the error of differences, δ².
        let balanced = (T::unit_roundoff().ln() / T::int(i64::from(order) + 2)).exp();
        let delta = if order == 0 { T::zero() } else { balanced * T::one().max(largest(0)) / extent };
        for signs in 0..1usize << order {
            // The s_i: ±δ for i in the set, 0 for others.
            let mut bit = 0;
            let mut along = [T::zero(); usize::BITS as usize];
            let mut sign = T::one();
            for (i, s) in along.iter_mut().enumerate().take(S::NESTING as usize) {
                if set >> i & 1 == 1 {
                    let positive = signs >> bit & 1 == 0;
                    *s = if positive { delta } else { -delta };
                    sign = if positive { sign } else { -sign };
                    bit += 1;
                }
            }
            for (k, value) in point.iter_mut().enumerate() {
                *value = (0..count).fold(T::zero(), |sum, part| {
                    let factors = (0..S::NESTING as usize).filter(|i| part >> i & 1 == 1).map(|i| along[i]);
                    sum + factors.fold(given[k * count + part], |product, s| product * s)
                });
            }
            let value = f(&point);
            let scale = (0..order).fold(sign, |scale, _| scale / (delta + delta));
            (0..N).for_each(|a| found[a * count + set] += value[a] * scale);
        }
    }
    Covector::from_fn(|_, a| S::read(&found[a * count..]))
}

impl<T: Real, const N: usize, B> Force<T, N> for BlackBox<B>
where
    B: Fn(T, &Vector<T, N>) -> Covector<T, N>,
{
    fn force<S: Scalar<Base = T>>(&self, t: S, eta: &Vector<S, N>) -> Covector<S, N> {
        if S::NESTING == 0 {
            return self.0(t.base(), &eta.map(|v| v.base())).map(S::lift);
        }
        let arguments: Vec<S> = [t].into_iter().chain(eta.iter().copied()).collect();
        parts(&arguments, |x| self.0(x[0], &Vector::from_column_slice(&x[1..])))
    }
}

impl<T: Real, const N: usize, const D: usize, B> ForceOnGroup<T, N, D> for BlackBox<B>
where
    B: Fn(T, &Matrix<T, D>, &Vector<T, N>) -> Covector<T, N>,
{
    fn force<S: Scalar<Base = T>>(&self, t: S, g: &Matrix<S, D>, eta: &Vector<S, N>) -> Covector<S, N> {
        if S::NESTING == 0 {
            return self.0(t.base(), &g.map(|v| v.base()), &eta.map(|v| v.base())).map(S::lift);
        }
        let arguments: Vec<S> = [t].into_iter().chain(eta.iter().copied()).chain(g.iter().copied()).collect();
        parts(&arguments, |x| {
            let (eta, g) = x[1..].split_at(N);
            self.0(x[0], &Matrix::from_column_slice(g), &Vector::from_column_slice(eta))
        })
    }
}
