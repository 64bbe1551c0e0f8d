//! One nonlinear solver with a report: Newton's method on a workspace, and its continuation in a parameter.
//!
//! [`Newton`] owns the Jacobian, its LU factors and the vectors of an iteration, so that solving allocates nothing.
//! [`Newton::follow`] follows the root that starts at parameter 0 along the arc of its branch (Keller 1977): a fold is where the parameter turns
//! back and det J changes its sign.

mod arc;
mod iteration;
mod lu;

pub(crate) use lu::Factors;

use crate::scalar::{Real, max_abs};
use arc::Arc;
use iteration::Iteration;
use lu::Determinant;
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

    /// How far apart two points are, each a fraction and x, where up to 1 the equations change little: the continuation takes no longer steps. None
    /// where that is not known.
    fn distance(&self, from: (T, &[T]), to: (T, &[T])) -> Option<T> {
        let _ = (from, to);
        None
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
    /// The branch turns back in the parameter.
    Fold {
        /// The largest fraction of the parameter that it reaches.
        fraction: T,
        /// det J / det J(0) at the last point next to there: it is 0 at the fold.
        determinant: T,
    },
    /// The branch was followed to this fraction of the parameter, and no further: steps became too short, or the points that are looked at too many.
    TooLong {
        /// The fraction.
        fraction: T,
    },
    /// Beyond this fraction of the parameter Newton's method does not converge, however close it starts: the rounding of the equations is larger than
    /// [`NewtonSettings::floor`].
    Rounding {
        /// The fraction.
        fraction: T,
        /// The relative residual that is left.
        residual: T,
    },
    /// The iteration did not contract, or ran out of iterations.
    NotConverged(Outcome<T>),
    /// The equations could not be evaluated.
    Equations(E),
}

/// Two points of a branch are neighbours where each lies on the tangent at the other up to this share of their distance; and in
/// [`Newton::is_joined`] a second correction is at most this share of the first.
const BEND: f64 = 0.25;

/// A root whose distance from the origin is at most this share of the origin is at hand: no fold is so near.
const AT_HAND: f64 = 0.25;

/// The most halvings of the parameter that [`Newton::is_joined`] looks at.
const HALVINGS: usize = 12;

/// Distances below this share of the unknowns are too small for tangents to tell branches apart.
const NEAR: f64 = 1.0 / 1024.0;

/// So are points that are no farther apart than this by [`Equations::distance`]. Unknowns that start at 0, as those of a body at rest, say nothing of
/// what is small: a force that starts at 0 makes of them a curve like s², whose chords are never near its tangents at 0.
const CLOSE: f64 = 1.0 / 64.0;

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
    iteration: Iteration<T>,
    arc: Arc<T>,
    /// A point, and a tangent.
    place: Vec<T>,
    leaving: Vec<T>,
}

impl<T: Real> Newton<T> {
    /// A workspace for `dimension` unknowns.
    pub fn new(dimension: usize) -> Self {
        let zeros = vec![T::zero(); dimension];
        Self { iteration: Iteration::new(dimension), arc: Arc::new(dimension), place: zeros.clone(), leaving: zeros }
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
        let corrected = self.iteration.correct(equations, x, settings)?;
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
        self.leaving.copy_from_slice(&self.iteration.trial);
        equations.set_fraction(T::one());
        let arriving = self.iteration.factor_at(equations, x).is_ok_and(|factored| factored.is_some());
        if arriving {
            self.tangent_at(equations, x, T::one());
        }
        let close = is_close(equations.distance((T::zero(), origin), (T::one(), x)));
        let (tangents, slack) = ([&self.leaving[..], &self.iteration.trial[..]], max_abs(x) * T::exact(NEAR));
        let near = arriving && (close || on_chord(origin, x, tangents, T::one(), slack));
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
        let iteration = &mut self.iteration;
        equations.residual(origin, &mut iteration.residual).ok()?;
        iteration.factor_at(equations, origin).ok()?.filter(|determinant| determinant.negative == negative)?;
        let first = iteration.correction();
        for ((to, from), d) in self.place.iter_mut().zip(origin).zip(&iteration.trial) {
            *to = *from - *d;
        }
        equations.residual(&self.place, &mut iteration.residual).ok()?;
        let second = iteration.correction();
        (first.all_finite() && second.all_finite()).then_some([first, second])
    }

    /// Follows the root from parameter 0, where it is `x`, to the full parameter; `x` becomes that root, or the last point that was reached.
    ///
    /// A point is accepted where det of the bordered Jacobian has the sign that it has at 0 (but behind a crossing) and has not fallen much, the tangents at it and at the
    /// point before agree with the chord between them, and the [distance](Equations::distance) is at most 1: else the step is halved. Nor does a
    /// step end on another branch that passes close by: it ends before that Jacobian, extrapolated, is singular.
    ///
    /// # Errors
    /// [`Failure::Fold`] where the parameter turns back before its full value, [`Failure::TooLong`] and [`Failure::Rounding`] where the branch cannot be followed that far;
    /// otherwise that of the equations.
    pub fn follow<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        x: &mut [T],
        settings: &NewtonSettings<T>,
    ) -> Result<Outcome<T>, Failure<T, E>> {
        let start = self.determinant_at_zero(equations, x)?;
        let result = self.arc.follow(&mut self.iteration, start, equations, x, settings);
        x.copy_from_slice(self.arc.x());
        result
    }

    /// `trial` ← dx/ds of the branch at x, by a difference in the parameter, towards 0 where it is not 0, and the factors of the Jacobian at
    /// hand, which are those at a point near x. Not finite where the equations cannot be evaluated.
    fn tangent_at<E>(&mut self, equations: &mut dyn Equations<T, Error = E>, x: &[T], fraction: T) {
        let away = T::unit_roundoff().sqrt();
        let ahead = if fraction == T::zero() { away } else { -away };
        equations.set_fraction(fraction + ahead);
        let Iteration { residual, trial, .. } = &mut self.iteration;
        let known = equations.residual(x, residual).is_ok();
        equations.set_fraction(fraction);
        for (t, r) in trial.iter_mut().zip(residual) {
            *t = if known { -*r / ahead } else { T::exact(f64::NAN) };
        }
        self.iteration.back_substitute();
    }

    fn determinant_at_zero<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        origin: &[T],
    ) -> Result<Determinant<T>, Failure<T, E>> {
        equations.set_fraction(T::zero());
        let factored = self.iteration.factor_at(equations, origin).map_err(Failure::Equations)?;
        factored.ok_or(Failure::NotConverged(Outcome { iterations: 0, residual: T::zero(), shortened: false }))
    }
}

/// Whether points so far apart are too close for tangents to tell branches apart.
fn is_close<T: Real>(distance: Option<T>) -> bool {
    distance.is_some_and(|distance| distance <= T::exact(CLOSE))
}

/// Whether the chord between two points of a branch is near the tangents at both, within a share of it and `slack`.
fn on_chord<T: Real>(from: &[T], to: &[T], tangents: [&[T]; 2], step: T, slack: T) -> bool {
    let (mut chord, mut off) = (T::zero(), [T::zero(); 2]);
    for i in 0..from.len() {
        let moved = to[i] - from[i];
        chord = chord.max(moved.abs());
        for (off, tangent) in off.iter_mut().zip(tangents) {
            let gap = (moved - tangent[i] * step).abs();
            // NaN is kept.
            *off = if gap > *off || !gap.all_finite() { gap } else { *off };
        }
    }
    let allowed = chord * T::exact(BEND) + slack;
    off.iter().all(|off| *off <= allowed)
}

/// Whether a root is so near its origin that [`Newton::is_joined`] looks at no other parameter.
pub(crate) fn is_at_hand<T: Real>(origin: &[T], x: &[T]) -> bool {
    let moved = x.iter().zip(origin).fold(T::zero(), |moved, (to, from)| (*to - *from).abs().max(moved));
    moved <= max_abs(origin) * T::exact(AT_HAND)
}
