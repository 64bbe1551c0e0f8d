//! One nonlinear solver with a report: Newton's method on a workspace, and its continuation in a parameter.
//!
//! [`Newton`] owns the Jacobian, its LU factors and the vectors of an iteration, so that solving allocates nothing.
//! [`Newton::follow`] follows the root that starts at parameter 0 and watches det J: a simple fold is where det J → 0
//! like a square root (Keller 1977), and there the branch ends.

use crate::scalar::{Real, larger, max_abs};
use nalgebra::DMatrix;

/// A system of n equations in n unknowns that depends on one parameter (here: the step size). Newton's method sees it as an
/// object, so that the iteration is compiled once for a scalar, whatever the equations.
pub trait Equations<T: Real> {
    /// What evaluation can fail with (leaving a domain, for example).
    type Error;

    /// n.
    fn dimension(&self) -> usize;

    /// Sets the parameter to `fraction` (0 … 1) of the value wanted.
    fn set_fraction(&mut self, fraction: T);

    /// The residual at x; returns the size that a residual is to be compared with.
    fn residual(&mut self, x: &[T], out: &mut [T]) -> Result<T, Self::Error>;

    /// The Jacobian of the residual at x.
    fn jacobian(&mut self, x: &[T], out: &mut DMatrix<T>) -> Result<(), Self::Error>;

    /// How far apart two points are, each a fraction and x, where up to 1 the equations change little. The continuation takes no longer steps.
    fn distance(&self, from: (T, &[T]), to: (T, &[T])) -> T {
        let _ = (from, to);
        T::zero()
    }
}

/// When Newton's method stops.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NewtonSettings<T> {
    /// The largest relative residual that counts as solved.
    pub tolerance: T,
    /// A stagnating relative residual below this counts as solved too: it is rounding.
    pub floor: T,
    /// The most iterations for one solve.
    pub max_iterations: usize,
}

/// How a solve went.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Outcome<T> {
    /// Newton iterations spent (all of them, with a continuation).
    pub iterations: usize,
    /// The relative residual reached.
    pub residual: T,
    /// Whether a continuation took shorter steps than its longest.
    pub shortened: bool,
}

/// Why a solve failed.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum Failure<T, E> {
    /// The branch ends in a fold.
    Fold {
        /// The fraction of the parameter at which det J extrapolates to 0.
        fraction: T,
        /// det J / det J(0) at the last point on the branch.
        determinant: T,
    },
    /// The branch was followed to this fraction of the parameter, and as many points as are looked at, 512, were not enough.
    TooLong {
        /// The fraction.
        fraction: T,
    },
    /// The iteration did not contract, or ran out of iterations.
    NotConverged(Outcome<T>),
    /// The equations could not be evaluated.
    Equations(E),
}

/// Corrections that shrink by this factor need no new Jacobian: one of the stages costs some five residuals for each dimension, which are
/// worth some ten digits or more.
const FAST: f64 = 1.0 / 16.0;

/// Two points of a branch are neighbours where each lies on the tangent at the other up to this share of their distance.
const BEND: f64 = 0.25;

/// A root whose distance from the origin is at most this share of the origin is at hand: no fold is so near.
const AT_HAND: f64 = 0.25;

/// The most halvings of the parameter that [`Newton::is_joined`] looks at.
const HALVINGS: usize = 12;

/// Distances below this share of the unknowns are too small for tangents to tell branches apart.
const NEAR: f64 = 1.0 / 1024.0;

/// From one point of the continuation to the next det J falls to this share of itself at the least. At a fold it falls to 0: where it falls faster,
/// there may be one, and another branch behind it that goes on as this one did.
const FALL: f64 = 0.25;

/// No step is longer than this share of the way to where (det J)² extrapolates to 0, which is linear at a simple fold, and none so long that an
/// extrapolated J may be singular before this share of the way to its end.
///
/// Where two branches pass close by each other, det J falls to 0 before they do, and rises behind, on the other branch, which may go on as the first
/// did; and where other directions grow at the same time, det J itself need not fall before.
const WAY: f64 = 0.75;

/// So many times from one point to the next the sign of det J is looked at.
const LOOKS: u32 = 4;

/// The continuation doubles its step where a point took no more Jacobians than this.
const EASY: usize = 3;

/// The most points of the branch that the continuation looks at: x² = 1 + s a takes four where it is easy (a = 1), and 43 close to its fold
/// (a = −1 + 10⁻⁶). Steps that stay short are those of equations that are all rounding.
const MOST_POINTS: usize = 512;

/// The next step would go this share of the distance that is allowed, if the branch went on as it did.
const PACE: f64 = 0.875;

/// The first step of the continuation, the longest and the least.
const LENGTHS: (f64, f64, f64) = (0.25, 0.5, 1.0 / (1 << 20) as f64);

/// The determinant of a factored matrix: sign and natural logarithm of the absolute value.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Determinant<T> {
    negative: bool,
    log: T,
}

/// The workspace of Newton's method for systems of a given size.
///
/// ```
/// use euler_poincare::newton::{Equations, Failure, Newton, Outcome, NewtonSettings};
/// use nalgebra::DMatrix;
/// use std::convert::Infallible;
///
/// /// x² = 1 + s a, followed from x = 1 at s = 0.
/// struct Root {
///     a: f64,
///     s: f64,
/// }
///
/// impl Equations<f64> for Root {
///     type Error = Infallible;
///
///     fn dimension(&self) -> usize {
///         1
///     }
///
///     fn set_fraction(&mut self, fraction: f64) {
///         self.s = fraction;
///     }
///
///     fn residual(&mut self, x: &[f64], out: &mut [f64]) -> Result<f64, Infallible> {
///         out[0] = x[0] * x[0] - 1.0 - self.s * self.a;
///         Ok(1.0)
///     }
///
///     fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) -> Result<(), Infallible> {
///         out[(0, 0)] = 2.0 * x[0];
///         Ok(())
///     }
/// }
///
/// let settings = NewtonSettings { tolerance: 1e-14, floor: 1e-15, max_iterations: 50 };
/// let mut newton = Newton::new(1);
/// let mut x = [1.0];
/// let found: Outcome<f64> = newton.solve(&mut Root { a: 1.0, s: 1.0 }, &[1.0], &mut x, &settings).expect("a root");
/// assert!((x[0] - 2.0f64.sqrt()).abs() < 1e-14 && found.residual < 1e-14);
///
/// // For a = −2 the branch folds at s = ½, where x = 0.
/// let mut x = [1.0];
/// let refused = newton.follow(&mut Root { a: -2.0, s: 1.0 }, &mut x, &settings);
/// let Err(Failure::Fold { fraction, .. }) = refused else { panic!("{refused:?}") };
/// assert!((fraction - 0.5).abs() < 0.01);
/// ```
#[derive(Clone, Debug)]
pub struct Newton<T: Real> {
    jacobian: DMatrix<T>,
    pivots: Vec<usize>,
    /// The last Jacobian, before it was factored.
    whole: DMatrix<T>,
    /// That of the last point of the continuation, and its derivative in the parameter by the point before.
    here: DMatrix<T>,
    change: DMatrix<T>,
    residual: Vec<T>,
    trial: Vec<T>,
    path: Path<T>,
    /// How much longer than they should be the steps of the continuation are, the distances from tangents and the corrections that it allows: 1,
    /// but in laws. If it is more, nor is it looked at how det J falls, at J ahead, and at distances.
    stretch: T,
}

/// Where a continuation is.
#[derive(Clone, Debug, Default)]
struct Path<T> {
    /// The last point and the one before.
    current: Vec<T>,
    previous: Vec<T>,
    /// The tangent at the last.
    tangent: Vec<T>,
}

/// What one corrected point of the branch looks like.
struct Corrected<T> {
    outcome: Outcome<T>,
    determinant: Determinant<T>,
    /// Jacobians that were needed: the fewer, the faster the iteration contracted.
    jacobians: usize,
}

impl<T: Real> Newton<T> {
    /// A workspace for `dimension` unknowns.
    pub fn new(dimension: usize) -> Self {
        Self {
            jacobian: DMatrix::zeros(dimension, dimension),
            pivots: vec![0; dimension],
            whole: DMatrix::zeros(dimension, dimension),
            here: DMatrix::zeros(dimension, dimension),
            change: DMatrix::zeros(dimension, dimension),
            residual: vec![T::zero(); dimension],
            trial: vec![T::zero(); dimension],
            path: Path {
                current: vec![T::zero(); dimension],
                previous: vec![T::zero(); dimension],
                tangent: vec![T::zero(); dimension],
            },
            stretch: T::one(),
        }
    }

    /// Makes the steps of the continuation so many times as long, and all that it allows so many times as large: a fault for laws to see.
    #[cfg(feature = "harness")]
    pub(crate) fn stretch(&mut self, factor: T) {
        self.stretch = factor;
    }

    /// Solves the equations at the full parameter from the start `x`, demanding contraction from the first iteration
    /// on and det J of the sign that it has at `origin` (the root at parameter 0), so that what it finds is the root
    /// that continues from there. On failure `x` holds the last iterate.
    ///
    /// # Errors
    /// No contraction, too many iterations, or equations that cannot be evaluated.
    pub fn solve<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        origin: &[T],
        x: &mut [T],
        settings: &NewtonSettings<T>,
    ) -> Result<Outcome<T>, Failure<T, E>> {
        let start = self.determinant_at_zero(equations, origin)?;
        equations.set_fraction(T::one());
        let corrected = self.correct(equations, x, settings)?;
        if corrected.determinant.negative != start.negative {
            return Err(Failure::NotConverged(corrected.outcome));
        }
        Ok(corrected.outcome)
    }

    /// The root at the full parameter that continues from `origin` at 0, from the start `x`: at once, where [`Newton::solve`] finds it and it
    /// [is joined](Newton::is_joined) to `origin`, else [along the parameter](Newton::follow). And whether it was found along it.
    ///
    /// # Errors
    /// Those of [`Newton::follow`].
    pub fn solve_joined<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        origin: &[T],
        x: &mut [T],
        settings: &NewtonSettings<T>,
    ) -> Result<(Outcome<T>, bool), Failure<T, E>> {
        if let Ok(outcome) = self.solve(equations, origin, x, settings)
            && self.is_joined(equations, origin, x)
        {
            return Ok((outcome, false));
        }
        x.copy_from_slice(origin);
        Ok((self.follow(equations, x, settings)?, true))
    }

    /// Whether the root `x` at the full parameter, found from `origin`, is the one that continues from there: from `origin`, at parameters that
    /// halve from the full one until the root is near `origin`, the second correction with the same Jacobian is at most a quarter of the
    /// first (Newton and Kantorovich: then there is one root near), and det J has the sign that it has at 0; and the tangents of the branch at
    /// `origin` and at `x` agree with the chord between them, as in [`Newton::follow`].
    ///
    /// A root can be found at once, by corrections that contract, that lies behind a fold: at the parameters between, iterations from
    /// `origin` do not contract, or the branch bends there.
    pub fn is_joined<E>(&mut self, equations: &mut dyn Equations<T, Error = E>, origin: &[T], x: &[T]) -> bool {
        if is_at_hand(origin, x) {
            return true;
        }
        let extent = max_abs(origin) * T::exact(AT_HAND);
        let Ok(start) = self.determinant_at_zero(equations, origin) else { return false };
        self.tangent_at(equations, origin, T::zero());
        let mut leaving = std::mem::take(&mut self.path.tangent);
        leaving.copy_from_slice(&self.trial);
        equations.set_fraction(T::one());
        let arriving = equations.jacobian(x, &mut self.jacobian).is_ok() && self.factor().is_some();
        if arriving {
            self.tangent_at(equations, x, T::one());
        }
        let near = arriving && on_chord(origin, x, [&leaving, &self.trial], T::one(), T::one());
        self.path.tangent = leaving;
        if !near {
            return false;
        }
        let mut fraction = T::one();
        for _ in 0..HALVINGS {
            equations.set_fraction(fraction);
            let Some([first, second]) = self.two_corrections(equations, origin, start.negative) else { return false };
            let contracts = second <= first * T::exact(BEND);
            if !contracts {
                return false;
            }
            if first <= extent {
                break;
            }
            fraction *= T::half();
        }
        true
    }

    /// The sizes of two corrections from `origin` by one Jacobian; none where det J has the wrong sign, or nothing can be evaluated.
    fn two_corrections<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        origin: &[T],
        negative: bool,
    ) -> Option<[T; 2]> {
        equations.residual(origin, &mut self.residual).ok()?;
        equations.jacobian(origin, &mut self.jacobian).ok()?;
        self.factor().filter(|determinant| determinant.negative == negative)?;
        let first = self.correction();
        for ((to, from), d) in self.path.previous.iter_mut().zip(origin).zip(&self.trial) {
            *to = *from - *d;
        }
        equations.residual(&self.path.previous, &mut self.residual).ok()?;
        let second = self.correction();
        (first.all_finite() && second.all_finite()).then_some([first, second])
    }

    /// Follows the root from parameter 0, where it is `x`, to the full parameter; `x` becomes that root.
    ///
    /// A point is accepted where det J has the sign that it has at 0 and has not fallen much, the tangents at it and at the point before agree with
    /// the chord between them, and the [distance](Equations::distance) is at most 1: else the step is halved. So no fold is passed, to another
    /// branch behind it. Nor is one where another branch passes close by: steps end before the Jacobian, extrapolated, is singular.
    ///
    /// # Errors
    /// [`Failure::Fold`] where det J tends to zero before the parameter is reached, [`Failure::TooLong`] where that takes too many points; otherwise
    /// as [`Newton::solve`].
    pub fn follow<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        x: &mut [T],
        settings: &NewtonSettings<T>,
    ) -> Result<Outcome<T>, Failure<T, E>> {
        let start = self.determinant_at_zero(equations, x)?;
        let mut path = std::mem::take(&mut self.path);
        path.current.copy_from_slice(x);
        let result = self.follow_from(start, equations, &mut path, x, settings);
        if result.is_err() {
            x.copy_from_slice(&path.current);
        }
        self.path = path;
        result
    }

    /// [`Newton::follow`] from parameter 0, where det J is `start`, with room for the path.
    fn follow_from<E>(
        &mut self,
        start: Determinant<T>,
        equations: &mut dyn Equations<T, Error = E>,
        path: &mut Path<T>,
        x: &mut [T],
        settings: &NewtonSettings<T>,
    ) -> Result<Outcome<T>, Failure<T, E>> {
        let [first, longest, smallest] =
            [LENGTHS.0, LENGTHS.1, LENGTHS.2].map(|length| self.stretch * T::exact(length));
        let (mut iterations, mut not_evaluated, mut shortened) = (0, None, false);
        let (mut reached, mut step, mut last_step, mut determinant) = (T::zero(), first, None, start.log);
        // (fraction, (det J / det J(0))²) of the last two points: linear at a simple fold.
        let mut squares = [(T::zero(), T::one()); 2];
        let Path { current, previous, tangent } = path;
        self.tangent_at(equations, x, T::zero());
        tangent.copy_from_slice(&self.trial);
        if self.stretch == T::one() {
            step = self.while_definite(equations, x, step, smallest);
            step *= pace(equations.distance((T::zero(), x), (step, x))).min(T::one());
        }
        for _ in 0..MOST_POINTS {
            if self.stretch == T::one() {
                step = step.min(T::exact(WAY) * (zero_of(squares) - reached).abs());
                step = self.before_zero(start, step, smallest);
            }
            if step < smallest {
                // J is singular at the next point.
                let [_, (fraction, square)] = squares;
                return Err(Failure::Fold { fraction, determinant: square.sqrt() });
            }
            let step_now = step.min(T::one() - reached);
            let target = if T::one() - reached <= step { T::one() } else { reached + step };
            let slope = last_step.map_or(T::zero(), |last| step_now / last);
            for i in 0..x.len() {
                x[i] = current[i] + slope * (current[i] - previous[i]);
            }
            equations.set_fraction(target);
            let corrected = self.correct(equations, x, settings);
            let is_like = |c: &Corrected<T>| {
                let fallen = determinant - c.determinant.log;
                c.determinant.negative == start.negative && (fallen <= -T::exact(FALL).ln() || self.stretch > T::one())
            };
            let watched = self.stretch == T::one();
            let apart = if watched { equations.distance((reached, current), (target, x)) } else { T::zero() };
            let same = corrected.as_ref().is_ok_and(is_like) && apart <= T::one() && {
                self.tangent_at(equations, x, target);
                on_chord(current, x, [tangent, &self.trial], step_now, self.stretch)
            };
            match corrected {
                Ok(c) if same => {
                    tangent.copy_from_slice(&self.trial);
                    iterations += c.outcome.iterations;
                    std::mem::swap(previous, current);
                    current.copy_from_slice(x);
                    self.go_on(step_now);
                    reached = target;
                    last_step = Some(step_now);
                    determinant = c.determinant.log;
                    let ratio = (c.determinant.log - start.log).exp();
                    squares = [squares[1], (target, ratio * ratio)];
                    if reached >= T::one() {
                        return Ok(Outcome { iterations, residual: c.outcome.residual, shortened });
                    }
                    step *= if c.jacobians <= EASY { T::exact(2.0) } else { T::one() };
                    step = step.min(longest).min(step_now * pace(apart));
                }
                failed => {
                    step = step_now * T::half();
                    shortened = true;
                    let failed = match failed {
                        Err(Failure::Equations(error)) if step >= smallest => {
                            not_evaluated = Some(error);
                            continue;
                        }
                        // Beyond here the equations have no value: that is why the branch ends.
                        Ok(_) if step < smallest && not_evaluated.is_some() => {
                            not_evaluated.take().map_or(failed, |error| Err(Failure::Equations(error)))
                        }
                        failed => failed,
                    };
                    if step < smallest {
                        return Err(Self::end_of_branch(failed, squares, iterations));
                    }
                    if let Ok(c) = &failed {
                        iterations += c.outcome.iterations;
                    }
                }
            }
        }
        Err(Failure::TooLong { fraction: reached })
    }

    /// Why the branch could not be followed any further.
    fn end_of_branch<E>(
        failed: Result<Corrected<T>, Failure<T, E>>,
        squares: [(T, T); 2],
        iterations: usize,
    ) -> Failure<T, E> {
        let [_, (f1, d1)] = squares;
        // det² extrapolates to zero within a few per cent of the last point: a fold.
        let zero = zero_of(squares);
        let fold = zero <= f1 * T::ratio(21, 20) + T::exact(2f64.powi(-10));
        match failed {
            _ if fold => Failure::Fold { fraction: zero, determinant: d1.sqrt() },
            // Another branch is all that is found.
            Ok(_) => Failure::Fold { fraction: f1, determinant: d1.sqrt() },
            Err(Failure::NotConverged(mut outcome)) => {
                outcome.iterations += iterations;
                Failure::NotConverged(outcome)
            }
            Err(other) => other,
        }
    }

    /// `trial` ← dx/ds of the branch at x, by a difference in the parameter, towards 0 where it is not 0, and the factors of the Jacobian at
    /// hand, which are those at a point near x. Not finite where the equations cannot be evaluated.
    fn tangent_at<E>(&mut self, equations: &mut dyn Equations<T, Error = E>, x: &[T], fraction: T) {
        let away = T::unit_roundoff().sqrt();
        let ahead = if fraction == T::zero() { away } else { -away };
        equations.set_fraction(fraction + ahead);
        let known = equations.residual(x, &mut self.residual).is_ok();
        equations.set_fraction(fraction);
        for (t, r) in self.trial.iter_mut().zip(&self.residual) {
            *t = if known { -*r / ahead } else { T::exact(f64::NAN) };
        }
        self.back_substitute();
    }

    /// The longest of a step, its half, its quarter …, down to `smallest`, that the continuation may start with at `origin`, the root at parameter 0
    /// with its tangent in `trial` and the factors of its Jacobian at hand: with J(s) = J + s J' along the tangent, the symmetric part of J⁻¹J(s) is
    /// positive definite to its end, so that no J(s) is singular; `smallest`, where none is. J and J' are kept.
    fn while_definite<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        origin: &[T],
        step: T,
        smallest: T,
    ) -> T {
        let ahead = T::unit_roundoff().sqrt();
        for (to, from) in self.trial.iter_mut().zip(origin) {
            *to = *from + *to * ahead;
        }
        self.here.copy_from(&self.whole);
        equations.set_fraction(ahead);
        if equations.jacobian(&self.trial, &mut self.whole).is_err() {
            self.whole.copy_from(&self.here);
        }
        for ((change, here), next) in self.change.iter_mut().zip(self.here.iter()).zip(self.whole.iter()) {
            *change = (*next - *here) / ahead;
        }
        let n = self.pivots.len();
        for (mut to, from) in self.whole.column_iter_mut().zip(self.change.column_iter()) {
            self.trial.copy_from_slice(from.as_slice());
            solve_factored(&self.jacobian, &self.pivots, &mut self.trial);
            to.copy_from_slice(&self.trial);
        }
        let mut step = step;
        while step > smallest {
            let half = step * T::half() / T::exact(WAY);
            for c in 0..n {
                for r in 0..n {
                    let one = if r == c { T::one() } else { T::zero() };
                    self.jacobian[(r, c)] = one + (self.whole[(r, c)] + self.whole[(c, r)]) * half;
                }
            }
            if is_definite(&mut self.jacobian) {
                break;
            }
            step *= T::half();
        }
        larger(step, smallest)
    }

    /// Takes the last Jacobian for that at the next point of the continuation, after a step.
    fn go_on(&mut self, step: T) {
        for ((change, here), next) in self.change.iter_mut().zip(self.here.iter_mut()).zip(self.whole.iter()) {
            *change = (*next - *here) / step;
            *here = *next;
        }
    }

    /// The longest of a step, its half, its quarter …, down to `smallest`, on which det J does not change its sign, where J is extrapolated from the
    /// last points.
    fn before_zero(&mut self, start: Determinant<T>, step: T, smallest: T) -> T {
        let mut step = step;
        while step >= smallest {
            let same = (1..=LOOKS).all(|look| {
                let ahead = step / T::exact(WAY) * T::ratio(i64::from(look), i64::from(LOOKS));
                for ((to, here), change) in self.jacobian.iter_mut().zip(self.here.iter()).zip(self.change.iter()) {
                    *to = *here + *change * ahead;
                }
                self.factor().is_some_and(|there| there.negative == start.negative)
            });
            if same {
                break;
            }
            step *= T::half();
        }
        step
    }

    fn determinant_at_zero<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        origin: &[T],
    ) -> Result<Determinant<T>, Failure<T, E>> {
        equations.set_fraction(T::zero());
        equations.jacobian(origin, &mut self.jacobian).map_err(Failure::Equations)?;
        self.whole.copy_from(&self.jacobian);
        self.factor().ok_or(Failure::NotConverged(Outcome { iterations: 0, residual: T::zero(), shortened: false }))
    }

    /// Newton's iteration at the present parameter; every correction must be at most half the one before.
    ///
    /// A Jacobian costs as much as many residuals: the factors are kept while each correction is at most [`FAST`] times the one
    /// before, where det J does not change its sign on the way. The error of what is found is then not squared by the last correction,
    /// so one more is made after the tolerance is met.
    fn correct<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        x: &mut [T],
        settings: &NewtonSettings<T>,
    ) -> Result<Corrected<T>, Failure<T, E>> {
        let mut determinant = None;
        let mut last_correction = None;
        let mut best = T::zero();
        let (mut frozen, mut met, mut jacobians) = (false, false, 0);
        for iterations in 0..=settings.max_iterations {
            let size = equations.residual(x, &mut self.residual).map_err(Failure::Equations)?;
            let residual = max_abs(&self.residual);
            // 0/0 is a residual of zero: a system at rest without forces.
            let relative = if residual == T::zero() { T::zero() } else { residual / size };
            let outcome = Outcome { iterations, residual: relative, shortened: false };
            if !relative.all_finite() {
                return Err(Failure::NotConverged(outcome));
            }
            let stagnates = iterations > 1 && relative * T::exact(2.0) >= best;
            let within = relative <= settings.tolerance;
            let solved = (within && (met || !frozen)) || (stagnates && relative <= settings.floor);
            met = within;
            best = if iterations == 0 { relative } else { best.min(relative) };
            if let (true, Some(determinant)) = (solved, determinant) {
                return Ok(Corrected { outcome, determinant, jacobians });
            }
            if iterations == settings.max_iterations {
                return Err(Failure::NotConverged(outcome));
            }
            let shrunk = |correction: T, share: T| last_correction.is_none_or(|last: T| correction <= last * share);
            let mut correction = T::zero();
            // In the second half of the iterations that are allowed each has to count.
            frozen = determinant.is_some() && (met || 2 * iterations < settings.max_iterations) && {
                correction = self.correction();
                met || shrunk(correction, T::exact(FAST))
            };
            if !frozen {
                equations.jacobian(x, &mut self.jacobian).map_err(Failure::Equations)?;
                self.whole.copy_from(&self.jacobian);
                let Some(factored) = self.factor() else {
                    return Err(Failure::NotConverged(outcome));
                };
                determinant = Some(factored);
                jacobians += 1;
                correction = self.correction();
            }
            // Corrections at the level of rounding need not contract any more.
            let grows = !shrunk(correction, T::half() * self.stretch) || !correction.all_finite();
            if grows && relative > settings.floor {
                return Err(Failure::NotConverged(outcome));
            }
            last_correction = Some(correction);
            for (v, d) in x.iter_mut().zip(&self.trial) {
                *v -= *d;
            }
        }
        Err(Failure::NotConverged(Outcome { iterations: settings.max_iterations, residual: best, shortened: false }))
    }

    /// LU factors of the Jacobian, in place.
    fn factor(&mut self) -> Option<Determinant<T>> {
        factor(&mut self.jacobian, &mut self.pivots)
    }

    /// `trial` ← J⁻¹ `residual`; its largest component.
    fn correction(&mut self) -> T {
        self.trial.copy_from_slice(&self.residual);
        self.back_substitute();
        max_abs(&self.trial)
    }

    /// `trial` ← J⁻¹ `trial`.
    fn back_substitute(&mut self) {
        solve_factored(&self.jacobian, &self.pivots, &mut self.trial);
    }
}

/// LU factors, in place, with partial pivoting; `None` when the matrix is singular.
fn factor<T: Real>(m: &mut DMatrix<T>, pivots: &mut [usize]) -> Option<Determinant<T>> {
    let n = pivots.len();
    let mut determinant = Determinant { negative: false, log: T::zero() };
    for k in 0..n {
        let mut p = k;
        for i in k + 1..n {
            if m[(i, k)].abs() > m[(p, k)].abs() {
                p = i;
            }
        }
        pivots[k] = p;
        if p != k {
            m.swap_rows(p, k);
            determinant.negative = !determinant.negative;
        }
        let pivot = m[(k, k)];
        if pivot == T::zero() || !pivot.all_finite() {
            return None;
        }
        determinant.negative ^= pivot < T::zero();
        determinant.log += pivot.abs().ln();
        for i in k + 1..n {
            m[(i, k)] /= pivot;
        }
        for j in k + 1..n {
            let factor = m[(k, j)];
            for i in k + 1..n {
                let lower = m[(i, k)];
                m[(i, j)] -= lower * factor;
            }
        }
    }
    Some(determinant)
}

/// Whether a symmetric matrix is positive definite: by Cholesky's method, in its lower triangle.
fn is_definite<T: Real>(m: &mut DMatrix<T>) -> bool {
    let n = m.nrows();
    for k in 0..n {
        let pivot = m[(k, k)];
        // NaN is not positive.
        if !pivot.all_finite() || pivot <= T::zero() {
            return false;
        }
        for j in k + 1..n {
            let factor = m[(j, k)] / pivot;
            for i in j..n {
                let lower = m[(i, k)];
                m[(i, j)] -= lower * factor;
            }
        }
    }
    true
}

/// x ← J⁻¹ x by the factors of J.
fn solve_factored<T: Real>(m: &DMatrix<T>, pivots: &[usize], x: &mut [T]) {
    let n = pivots.len();
    for k in 0..n {
        x.swap(k, pivots[k]);
    }
    for k in 0..n {
        let value = x[k];
        for i in k + 1..n {
            x[i] -= m[(i, k)] * value;
        }
    }
    for k in (0..n).rev() {
        x[k] /= m[(k, k)];
        let value = x[k];
        for i in 0..k {
            x[i] -= m[(i, k)] * value;
        }
    }
}

/// LU factors of a matrix, to solve with it and with its transpose.
#[derive(Clone, Debug)]
pub(crate) struct Factors<T: Real> {
    matrix: DMatrix<T>,
    pivots: Vec<usize>,
    /// For the condition number: sizes of the columns of J, a column of J⁻¹, sums over its rows.
    sizes: Vec<T>,
    column: Vec<T>,
    sums: Vec<T>,
}

impl<T: Real> Factors<T> {
    /// Room for an n×n matrix.
    pub(crate) fn new(n: usize) -> Self {
        let zeros = vec![T::zero(); n];
        Self {
            matrix: DMatrix::zeros(n, n),
            pivots: vec![0; n],
            sizes: zeros.clone(),
            column: zeros.clone(),
            sums: zeros,
        }
    }

    /// Factors J and returns Skeel's condition number ‖|J⁻¹| |J|‖_∞, of J with its columns scaled to size 1; infinite where J is
    /// singular.
    pub(crate) fn factor(&mut self, matrix: &DMatrix<T>) -> T {
        let n = self.pivots.len();
        self.matrix.copy_from(matrix);
        if factor(&mut self.matrix, &mut self.pivots).is_none() {
            return T::exact(f64::INFINITY);
        }
        for (size, column) in self.sizes.iter_mut().zip(matrix.column_iter()) {
            *size = max_abs(column.as_slice());
        }
        self.sums.fill(T::zero());
        for r in 0..n {
            self.column.fill(T::zero());
            self.column[r] = T::one();
            solve_factored(&self.matrix, &self.pivots, &mut self.column);
            let weight = (0..n).fold(T::zero(), |sum, c| sum + matrix[(r, c)].abs() / self.sizes[c]);
            for k in 0..n {
                self.sums[k] += self.column[k].abs() * self.sizes[k] * weight;
            }
        }
        max_abs(&self.sums)
    }

    /// x ← J⁻¹ x.
    pub(crate) fn solve(&self, x: &mut [T]) {
        solve_factored(&self.matrix, &self.pivots, x);
    }

    /// x ← J⁻ᵀ x.
    pub(crate) fn solve_transposed(&self, x: &mut [T]) {
        let (m, n) = (&self.matrix, self.pivots.len());
        for k in 0..n {
            let known = (0..k).fold(x[k], |rest, i| rest - m[(i, k)] * x[i]);
            x[k] = known / m[(k, k)];
        }
        for k in (0..n).rev() {
            x[k] = (k + 1..n).fold(x[k], |rest, i| rest - m[(i, k)] * x[i]);
        }
        for k in (0..n).rev() {
            x.swap(k, self.pivots[k]);
        }
    }
}

/// How many times as long as one that went this distance a step may be.
fn pace<T: Real>(distance: T) -> T {
    T::exact(PACE) / larger(distance, T::exact(f64::MIN_POSITIVE))
}

/// Whether the chord between two points of a branch is near the tangents at both, with distances that are allowed so many times over.
fn on_chord<T: Real>(from: &[T], to: &[T], tangents: [&[T]; 2], step: T, stretch: T) -> bool {
    let (mut chord, mut size, mut off) = (T::zero(), T::zero(), [T::zero(); 2]);
    for i in 0..from.len() {
        let moved = to[i] - from[i];
        chord = chord.max(moved.abs());
        size = size.max(to[i].abs());
        for (off, tangent) in off.iter_mut().zip(tangents) {
            let gap = (moved - tangent[i] * step).abs();
            // NaN is kept.
            *off = if gap > *off || !gap.all_finite() { gap } else { *off };
        }
    }
    let allowed = (chord * T::exact(BEND) + size * T::exact(NEAR)) * stretch;
    off.iter().all(|off| *off <= allowed)
}

/// Where the line through two points is 0, if it falls; else at infinity.
fn zero_of<T: Real>([(f0, d0), (f1, d1)]: [(T, T); 2]) -> T {
    if d1 < d0 { f1 + d1 * (f1 - f0) / (d0 - d1) } else { T::exact(f64::INFINITY) }
}

/// Whether a root is so near its origin that [`Newton::is_joined`] looks at no other parameter.
pub(crate) fn is_at_hand<T: Real>(origin: &[T], x: &[T]) -> bool {
    let moved = x.iter().zip(origin).fold(T::zero(), |moved, (to, from)| (*to - *from).abs().max(moved));
    moved <= max_abs(origin) * T::exact(AT_HAND)
}
