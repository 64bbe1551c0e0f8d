//! Continuation of a root along the arc of its branch.
//!
//! The points are (x, w s), so that x and the parameter s count alike. From one to the next goes a step along the tangent t, and Newton's method
//! with the bordered matrix B = [∂r/∂x, ∂r/∂(w s); t] (Keller 1977). At a fold the tangent turns back in s, and det J = det B · t_s changes its sign with
//! it, while det B does not vanish; where det B changes its sign as well, the step has left the branch, or crossed another.

use super::iteration::{Corrected, Iteration};
use super::lu::{Determinant, is_definite};
use super::{Equations, Failure, NewtonSettings, Outcome, is_close, on_chord};
use crate::scalar::{Real, larger, max_abs};
use nalgebra::DMatrix;

/// From one point to the next det B keeps this share of itself at the least, or, while t_s is above [`TURNING`] and on the last step, det J; and t_s keeps
/// it of its larger value. Where det B falls faster, another branch may pass close by, and go on behind as this one did.
const KEPT: f64 = 0.25;

/// Until t_s is below this, no step goes over a zero of det J: what comes next may be a hairpin, which a longer one leaves for the branch on the other side.
const TURNING: f64 = 0.25;

/// No step is so long that an extrapolated B may be singular before this share of the way to its end.
///
/// Where two branches pass close by each other, det B falls to 0 before they do, and rises behind, on the other branch, which may go on as the first
/// did; and where other directions grow at the same time, det B itself need not fall before.
const WAY: f64 = 0.75;

/// The number of looks at the sign of det B from one point to the next.
const LOOKS: u32 = 4;

/// Between two points t_s falls to no less than this share of its values there, by the parabola through them that has its mean.
const DIP: f64 = 0.5;

/// The step is doubled where a point took no more Jacobians than this.
const EASY: usize = 3;

/// The most points that are looked at. They bound the motion in one step: of a quarter of a radian each, they are 4,000 radians.
const MOST_POINTS: usize = 16_384;

/// The most of them that do not go half of the distance that they may: x² = 1 + s a takes four where it is easy (a = 1). Where steps stay short, the
/// equations are all rounding.
const MOST_SHORT: usize = 1024;

/// The next step would go this share of the distance that is allowed, if the branch went on as it did.
const STEP_SHARE: f64 = 0.875;

/// The first step and the longest, in s.
const LENGTHS: (f64, f64) = (0.25, 0.5);

/// The least step, relative to the point: what tangents are differences of has no digits in shorter ones.
const LEAST: f64 = 1.0 / (1 << 30) as f64;

/// A point is no smaller than this share of what it may be at the start: x may pass through 0.
const SMALL: f64 = 1.0 / 1024.0;

/// Where no step as long as this, relative to the point, is left before det B = 0, another branch may cross there, and this one go on: one step four times
/// as long is taken over it.
const CROSSING: f64 = 1.0 / (1 << 17) as f64;

/// There the tangent turns by no more than this.
const STRAIGHT: f64 = 1.0 / 256.0;

/// A fold is located by no more points than the first, or when t_s is the second share of its change over the step.
const FOLD_LOCATED: (usize, f64) = (16, 1.0 / 1024.0);

/// It is confirmed when t_s is the first share of that change, or is at most the second: the tangent has length 1.
const FOLD_CONFIRMED: (f64, f64) = (1.0 / 16.0, 1.0 / (1 << 20) as f64);

/// Where x does not move, as from rest, a tangent may miss it by this share of the way in w s: x ~ s² is never near its tangent at 0.
const SLANT: f64 = 1.0 / 256.0;

/// And by this share of a point, everywhere: tangents have the rounding of differences.
const ROUNDING: f64 = 1.0 / (1 << 30) as f64;

/// Rounding leaves no more than this times what a change of the unknowns by a unit of round-off makes of r: as many roundings as r is made of.
const NOISE: i64 = 256;

/// r(x, s) = 0 on the plane through a point across a direction.
struct Bordered<'a, T: Real, E> {
    equations: &'a mut dyn Equations<T, Error = E>,
    /// The direction.
    row: &'a [T],
    scales: &'a mut Scales<T>,
    block: &'a mut DMatrix<T>,
    beside: &'a mut [Vec<T>; 2],
}

/// What is of size 1.
#[derive(Clone, Copy, Debug)]
struct Scales<T> {
    /// w.
    parameter: T,
    /// The s in which the branch changes at its start.
    unit: T,
    /// The border's entries, beside those of J.
    border: T,
    /// s ∂r/∂s, of which rounding of s is a share: where the branch turns fast it is more than that of x.
    turn: T,
}

impl<T: Real, E> Equations<T> for Bordered<'_, T, E> {
    type Error = E;

    fn dimension(&self) -> usize {
        self.row.len()
    }

    /// It is one of the unknowns.
    fn set_fraction(&mut self, _: T) {}

    fn residual(&mut self, y: &[T], out: &mut [T]) -> Result<T, E> {
        let n = y.len() - 1;
        self.equations.set_fraction(y[n] / self.scales.parameter);
        // Newton's method starts on the plane, and stays there.
        out[n] = T::zero();
        let size = self.equations.residual(&y[..n], &mut out[..n])?;
        Ok(larger(size, self.scales.turn))
    }

    fn jacobian(&mut self, y: &[T], out: &mut DMatrix<T>) -> Result<(), E> {
        let (n, Scales { parameter, unit, border, .. }) = (y.len() - 1, *self.scales);
        let (s, [here, behind]) = (y[n] / parameter, &mut *self.beside);
        // Towards 0: ahead the equations may have no value.
        let away = T::unit_roundoff().sqrt() * larger(s, unit);
        self.equations.set_fraction(s - away);
        self.equations.residual(&y[..n], behind)?;
        self.equations.set_fraction(s);
        self.equations.residual(&y[..n], here)?;
        self.equations.jacobian(&y[..n], self.block)?;
        out.view_mut((0, 0), (n, n)).copy_from(self.block);
        for r in 0..n {
            out[(r, n)] = (here[r] - behind[r]) / (away * parameter);
        }
        self.scales.turn = max_abs(out.view((0, n), (n, 1)).iter()) * y[n].abs();
        for (c, along) in self.row.iter().enumerate() {
            out[(n, c)] = *along * border;
        }
        Ok(())
    }
}

/// The workspace of a continuation of n unknowns.
#[derive(Clone, Debug)]
pub(super) struct Arc<T: Real> {
    iteration: Iteration<T>,
    /// ∂r/∂x, and r at two parameters.
    block: DMatrix<T>,
    beside: [Vec<T>; 2],
    scales: Scales<T>,
    /// B at the last point, and its derivative along the branch by the point before.
    here: DMatrix<T>,
    change: DMatrix<T>,
    /// The last point, the next, and one behind a fold.
    point: Vec<T>,
    next: Vec<T>,
    behind: Vec<T>,
    /// The unit tangents at the last point, at the next, and at the one before the last; and (0, …, 0, 1).
    tangent: Vec<T>,
    turned: Vec<T>,
    before: Vec<T>,
    upright: Vec<T>,
}

/// Where a walk along a branch is.
struct Walk<T> {
    /// det B at the last point, with the unit tangent.
    level: Determinant<T>,
    /// det J at s = 0.
    start: Determinant<T>,
    /// The last step, if there was one.
    last: Option<T>,
    iterations: usize,
    shortened: bool,
    /// What Newton's method left where the last step that was tried did not converge.
    left: Option<T>,
}

/// How a step ended.
enum Ended<T> {
    /// At a point of the branch.
    On { step: T, apart: T, jacobians: usize, level: Determinant<T>, residual: T },
    /// At one where the branch has turned back in s.
    Back { step: T },
    /// At none, or at one that may be of another branch.
    Off,
}

impl<T: Real> Arc<T> {
    pub fn new(n: usize) -> Self {
        let (zeros, matrix) = (vec![T::zero(); n + 1], DMatrix::zeros(n + 1, n + 1));
        let mut upright = zeros.clone();
        upright[n] = T::one();
        Self {
            iteration: Iteration::new(n + 1),
            block: DMatrix::zeros(n, n),
            beside: [vec![T::zero(); n], vec![T::zero(); n]],
            scales: Scales { parameter: T::one(), unit: T::one(), border: T::one(), turn: T::zero() },
            here: matrix.clone(),
            change: matrix,
            point: zeros.clone(),
            next: zeros.clone(),
            behind: zeros.clone(),
            tangent: zeros.clone(),
            turned: zeros.clone(),
            before: zeros,
            upright,
        }
    }

    /// The last point on the branch.
    pub fn x(&self) -> &[T] {
        &self.point[..self.block.nrows()]
    }

    /// s of a point.
    fn fraction(&self, y: &[T]) -> T {
        y[self.block.nrows()] / self.scales.parameter
    }

    /// Follows the root x at s = 0, where det J is `start`, to s = 1; `root` is at work there.
    pub fn follow<E>(
        &mut self,
        root: &mut Iteration<T>,
        start: Determinant<T>,
        equations: &mut dyn Equations<T, Error = E>,
        x: &[T],
        settings: &NewtonSettings<T>,
    ) -> Result<Outcome<T>, Failure<T, E>> {
        let n = x.len();
        let mut step = self.begin(root, equations, x);
        let level = Determinant { log: start.log - self.tangent[n].ln(), ..start };
        let mut walk = Walk { level, start, last: None, iterations: 0, shortened: false, left: None };
        let (mut not_evaluated, mut may_cross) = (None, true);
        let mut short = 0;
        for _ in 0..MOST_POINTS {
            if short == MOST_SHORT {
                break;
            }
            let (least, crossing) = (self.least(LEAST), self.least(CROSSING));
            if step < least
                && not_evaluated.is_none()
                && let Some(residual) = walk.left.filter(|left| *left > settings.floor)
                && self.noise(equations).is_some_and(|noise| residual <= noise * T::int(NOISE))
            {
                return Err(Failure::Rounding { fraction: self.fraction(&self.point), residual });
            }
            step = self.before_zero(walk.level, step, least);
            let over = Some(crossing * T::int(4)).filter(|_| may_cross && step < crossing);
            if step < least && over.is_none() {
                break;
            }
            let ended = self.step(equations, &mut walk, (over.unwrap_or(step), over.is_some()), settings);
            let ended = match ended {
                Err(error) => {
                    not_evaluated = Some((self.fraction(&self.next), error));
                    Ended::Off
                }
                Ok(Ended::Back { step }) if over.is_none() => match self.fold(equations, &walk, step, settings) {
                    Some(failure) => return Err(failure),
                    None => Ended::Off,
                },
                Ok(ended) => ended,
            };
            short += usize::from(!matches!(ended, Ended::On { apart, .. } if apart >= T::half()));
            match ended {
                Ended::On { step: moved, apart, jacobians, level, residual } => {
                    self.go_on(moved);
                    (walk.level, walk.last, may_cross) = (level, Some(moved), true);
                    let reached = self.fraction(&self.point);
                    // Where the equations had no value the branch has passed by.
                    not_evaluated = not_evaluated.filter(|(there, _)| *there > reached);
                    if reached >= T::one() {
                        return Ok(Outcome { iterations: walk.iterations, residual, shortened: walk.shortened });
                    }
                    let doubled = if jacobians <= EASY { moved + moved } else { moved };
                    step = doubled.min(self.longest()).min(moved * step_factor(apart));
                }
                _ if over.is_some() => may_cross = false,
                _ => {
                    step *= T::half();
                    walk.shortened = true;
                }
            }
        }
        let reached = self.fraction(&self.point);
        Err(not_evaluated.map_or(Failure::TooLong { fraction: reached }, |(_, error)| Failure::Equations(error)))
    }

    /// What changes of the unknowns by a unit of round-off make of r where the next point was tried, relative.
    fn noise<E>(&mut self, equations: &mut dyn Equations<T, Error = E>) -> Option<T> {
        let (n, parameter, [here, there]) = (self.block.nrows(), self.scales.parameter, &mut self.beside);
        equations.set_fraction(self.next[n] / parameter);
        let size = equations.residual(&self.next[..n], here).ok()?;
        for (k, y) in self.next.iter_mut().enumerate() {
            *y *= T::one() + T::unit_roundoff() * T::int(if k % 2 == 0 { 2 } else { -2 });
        }
        equations.set_fraction(self.next[n] / parameter);
        equations.residual(&self.next[..n], there).ok()?;
        let change = here.iter().zip(there.iter()).fold(T::zero(), |most, (a, b)| larger(most, (*a - *b).abs()));
        Some(change / larger(size, self.scales.turn))
    }

    /// A share of the last point.
    fn least(&self, share: f64) -> T {
        let Scales { parameter, unit, .. } = self.scales;
        larger(max_abs(self.x()), parameter * unit * T::exact(SMALL)) * T::exact(share)
    }

    /// The longest.
    fn longest(&self) -> T {
        let along = self.tangent[self.block.nrows()];
        self.scales.parameter * T::exact(LENGTHS.1) / larger(along, T::exact(LEAST))
    }

    /// The root x at s = 0 with the factors of J there at hand: scales, tangent, B and its derivative, and the first step.
    fn begin<E>(&mut self, root: &mut Iteration<T>, equations: &mut dyn Equations<T, Error = E>, x: &[T]) -> T {
        let n = x.len();
        self.point[..n].copy_from_slice(x);
        self.point[n] = T::zero();
        let whole = equations.distance((T::zero(), x), (T::one(), x)).unwrap_or(T::zero());
        let unit = if whole > T::one() { T::one() / whole } else { T::one() };
        // As far as one correction leads: from rest that is all that there is.
        let mut correction = |fraction| {
            equations.set_fraction(fraction);
            let known = equations.residual(x, &mut root.residual).is_ok();
            Some(root.correction()).filter(|size| known && size.all_finite())
        };
        let size = max_abs(x) + correction(unit).unwrap_or(T::zero());
        let parameter = if size > T::zero() { size / unit } else { T::one() };
        let away = T::unit_roundoff().sqrt() * unit;
        let known = correction(away).is_some();
        for r in 0..n {
            self.tangent[r] = if known { -root.trial[r] / away } else { T::zero() };
            self.here[(r, n)] = if known { root.residual[r] / away } else { T::zero() };
        }
        let border = root.whole.iter().fold(T::zero(), |most, v| larger(most, v.abs()));
        self.scales = Scales { parameter, unit, border, turn: T::zero() };
        self.here.view_mut((0, 0), (n, n)).copy_from(&root.whole);
        self.here.column_mut(n).rows_mut(0, n).scale_mut(T::one() / parameter);
        let step = self.while_definite(root, equations, x, (T::exact(LENGTHS.0), unit));
        let ahead = equations.distance((T::zero(), x), (step, x)).unwrap_or(T::zero());
        let step = step * step_factor(ahead).min(T::one());
        self.tangent[n] = parameter;
        let length = normalize(&mut self.tangent);
        self.change.fill(T::zero());
        let change = &mut self.change.view_mut((0, 0), (n, n));
        change.copy_from(&self.block);
        change.scale_mut(T::one() / length);
        self.before.copy_from_slice(&self.tangent);
        step * length
    }

    /// The longest of a step, its half, its quarter …, that the continuation may start with at x, the root at s = 0 with dx/ds in `tangent`: with
    /// J(s) = J + s J' along the tangent, the symmetric part of J⁻¹J(s) is positive definite to its end, so that no J(s) is singular. J' is left in
    /// `block`.
    fn while_definite<E>(
        &mut self,
        root: &mut Iteration<T>,
        equations: &mut dyn Equations<T, Error = E>,
        x: &[T],
        (step, unit): (T, T),
    ) -> T {
        let n = x.len();
        let ahead = T::unit_roundoff().sqrt() * unit;
        for k in 0..n {
            self.next[k] = x[k] + self.tangent[k] * ahead;
        }
        equations.set_fraction(ahead);
        if equations.jacobian(&self.next[..n], &mut self.block).is_err() {
            self.block.copy_from(&root.whole);
        }
        for (change, here) in self.block.iter_mut().zip(root.whole.iter()) {
            *change = (*change - *here) / ahead;
        }
        for c in 0..n {
            root.trial.copy_from_slice(self.block.column(c).as_slice());
            root.back_substitute();
            root.whole.column_mut(c).copy_from_slice(&root.trial);
        }
        let (mut step, smallest) = (step, unit * T::exact(LEAST));
        while step > smallest {
            let half = step * T::half() / T::exact(WAY);
            for c in 0..n {
                for r in 0..n {
                    let one = if r == c { T::one() } else { T::zero() };
                    root.matrix[(r, c)] = one + (root.whole[(r, c)] + root.whole[(c, r)]) * half;
                }
            }
            if is_definite(&mut root.matrix) {
                break;
            }
            step *= T::half();
        }
        step
    }

    /// The next point becomes the last, after a step.
    fn go_on(&mut self, step: T) {
        let n = self.block.nrows();
        for c in 0..=n {
            for r in 0..n {
                let next = self.iteration.whole[(r, c)];
                self.change[(r, c)] = (next - self.here[(r, c)]) / step;
                self.here[(r, c)] = next;
            }
        }
        std::mem::swap(&mut self.before, &mut self.tangent);
        std::mem::swap(&mut self.tangent, &mut self.turned);
        std::mem::swap(&mut self.point, &mut self.next);
    }

    /// The longest of a step, its half, its quarter …, on which det B does not change its sign, where B is extrapolated from the last points; if that
    /// is less than `least`, any that is.
    fn before_zero(&mut self, level: Determinant<T>, step: T, least: T) -> T {
        let n = self.block.nrows();
        let row = if self.tangent[n] > T::exact(TURNING) { &self.upright } else { &self.tangent };
        for (c, along) in row.iter().enumerate() {
            self.here[(n, c)] = *along * self.scales.border;
        }
        let mut step = step;
        while step >= least {
            let same = (1..=LOOKS).all(|look| {
                let ahead = step / T::exact(WAY) * T::ratio(i64::from(look), i64::from(LOOKS));
                let there = &mut self.iteration.matrix;
                for ((to, here), change) in there.iter_mut().zip(self.here.iter()).zip(self.change.iter()) {
                    *to = *here + *change * ahead;
                }
                self.iteration.factor().is_some_and(|there| there.negative == level.negative)
            });
            if same {
                break;
            }
            step *= T::half();
        }
        step
    }

    /// One step along the branch, into `next` and `turned`, with B there in the iteration; `over` a point where another branch may cross.
    fn step<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        walk: &mut Walk<T>,
        (step, over): (T, bool),
        settings: &NewtonSettings<T>,
    ) -> Result<Ended<T>, E> {
        let n = self.block.nrows();
        let mut step = step;
        self.predict(step, walk.last);
        let end = self.scales.parameter;
        let last = self.next[n] >= end;
        if last {
            step = step.min((end - self.point[n]) / self.tangent[n]);
            self.predict(step, walk.last);
            self.next[n] = end;
        }
        let row = if last { Border::Upright } else { Border::Tangent };
        walk.left = None;
        let corrected = match self.correct(equations, row, settings) {
            Ok(corrected) => corrected,
            Err(Failure::Equations(error)) => return Err(error),
            Err(Failure::NotConverged(outcome)) => {
                walk.left = Some(outcome.residual);
                return Ok(Ended::Off);
            }
            Err(_) => return Ok(Ended::Off),
        };
        walk.iterations += corrected.outcome.iterations;
        let (from, to) = ((self.fraction(&self.point), self.x()), (self.fraction(&self.next), &self.next[..n]));
        let distance = equations.distance(from, to);
        let apart = distance.unwrap_or(T::zero());
        if apart > T::one() || (!last && self.next[n] >= end) {
            return Ok(Ended::Off);
        }
        let Some(level) = self.look(equations)? else { return Ok(Ended::Off) };
        let moved = self.moved();
        let tangents = [&self.tangent[..n], &self.turned[..n]];
        let slack =
            max_abs(&self.next[..n]) * T::exact(ROUNDING) + (self.next[n] - self.point[n]).abs() * T::exact(SLANT);
        let near = is_close(distance) || on_chord(self.x(), &self.next[..n], tangents, moved, slack);
        // det J = det B t_s.
        let whole = last || self.tangent[n] > T::exact(TURNING);
        let along = if whole { (self.tangent[n] / self.turned[n].abs()).ln() } else { T::zero() };
        let fallen = walk.level.log - level.log + along;
        let like = level.negative == walk.level.negative && fallen <= -T::exact(KEPT).ln();
        let straight = || self.tangent.iter().zip(&self.turned).all(|(a, b)| (*a - *b).abs() <= T::exact(STRAIGHT));
        let back = self.turned[n] <= T::zero();
        let same = near && moved > T::zero() && if over { straight() } else { like && (back || self.rises()) };
        Ok(match same {
            true if back && !last => Ended::Back { step: moved },
            true if !back => {
                let residual = corrected.outcome.residual;
                Ended::On { step: moved, apart, jacobians: corrected.jacobians, level, residual }
            }
            _ => Ended::Off,
        })
    }

    /// Whether t_s stays above 0 from the last point to the next, where it is above 0 at both. Where the branch is steep, an S may be narrower than a
    /// step: it turns back and forth again, and t_s and det J have the same signs at both ends.
    ///
    /// t_s = ds/dσ, σ the arc length, has its values at the ends, and the mean Δs/Δσ between them; the parabola from these has to stay above a share of
    /// the smaller, and neither is much larger than the other.
    fn rises(&self) -> bool {
        let n = self.block.nrows();
        let [from, to] = [self.tangent[n], self.turned[n]];
        let (least, most) = (from.min(to), larger(from, to));
        let squares = self.next.iter().zip(&self.point).fold(T::zero(), |sum, (a, b)| sum + (*a - *b) * (*a - *b));
        let mean = (self.next[n] - self.point[n]) / squares.sqrt();
        // from + (to − from) u − sag u (1 − u), 0 ≤ u ≤ 1.
        let sag = (from + to) * T::int(3) - mean * T::int(6);
        let turns = sag > most - least;
        let u = T::half() - (to - from) / (sag + sag);
        let lowest = if turns { from + (to - from) * u - sag * u * (T::one() - u) } else { least };
        least >= most * T::exact(KEPT) && lowest >= least * T::exact(DIP)
    }

    /// `next` ← where a step leads if the branch bends as it did in the last.
    fn predict(&mut self, step: T, last: Option<T>) {
        let bend = last.map_or(T::zero(), |last| step * step * T::half() / last);
        for (k, next) in self.next.iter_mut().enumerate() {
            *next = self.point[k] + self.tangent[k] * step + (self.tangent[k] - self.before[k]) * bend;
        }
    }

    /// How far the next point is along the tangent.
    fn moved(&self) -> T {
        self.tangent
            .iter()
            .zip(&self.next)
            .zip(&self.point)
            .fold(T::zero(), |sum, ((t, to), from)| sum + *t * (*to - *from))
    }

    /// Newton's method from `next`.
    fn correct<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        border: Border,
        settings: &NewtonSettings<T>,
    ) -> Result<Corrected<T>, Failure<T, E>> {
        let Self { iteration, block, beside, scales, tangent, upright, next, .. } = self;
        let row = match border {
            Border::Tangent => tangent,
            Border::Upright => upright,
        };
        iteration.correct(&mut Bordered { equations, row, scales, block, beside }, next, settings)
    }

    /// det B at the next point, and its tangent into `turned`; none where B is singular.
    fn look<E>(&mut self, equations: &mut dyn Equations<T, Error = E>) -> Result<Option<Determinant<T>>, E> {
        let Self { iteration, block, beside, scales, tangent, next, turned, .. } = self;
        let mut bordered = Bordered { equations, row: tangent, scales, block, beside };
        let Some(found) = iteration.factor_at(&mut bordered, next)? else { return Ok(None) };
        let n = iteration.trial.len() - 1;
        iteration.trial.fill(T::zero());
        iteration.trial[n] = scales.border;
        iteration.back_substitute();
        turned.copy_from_slice(&iteration.trial);
        // The border is the unit tangent of before, of which this one has a component of 1.
        let length = normalize(turned);
        let log = found.log + length.ln() - scales.border.ln();
        Ok(Some(Determinant { log, ..found }).filter(|_| length.all_finite()))
    }

    /// The fold between the last point and the next, to which it is a step, where t_s changes its sign. None, if it is not found there.
    fn fold<E>(
        &mut self,
        equations: &mut dyn Equations<T, Error = E>,
        walk: &Walk<T>,
        step: T,
        settings: &NewtonSettings<T>,
    ) -> Option<Failure<T, E>> {
        let n = self.block.nrows();
        let mut ends = [(T::zero(), self.tangent[n]), (step, self.turned[n])];
        let size = ends[0].1 - ends[1].1;
        self.behind.copy_from_slice(&self.next);
        let mut best = (T::exact(f64::INFINITY), T::zero(), T::zero());
        for _ in 0..FOLD_LOCATED.0 {
            let [(a, up), (b, down)] = ends;
            let at = a + (b - a) * up / (up - down);
            for (k, next) in self.next.iter_mut().enumerate() {
                *next = self.point[k] + (self.behind[k] - self.point[k]) * (at / step);
            }
            self.correct(equations, Border::Tangent, settings).ok()?;
            let level = self.look(equations).ok()??;
            if level.negative != walk.level.negative {
                return None;
            }
            let along = self.turned[n];
            if along.abs() < best.0 {
                best = (along.abs(), self.fraction(&self.next), level.log);
            }
            if best.0 <= size * T::exact(FOLD_LOCATED.1) || best.0 <= T::exact(FOLD_CONFIRMED.1) {
                break;
            }
            ends[usize::from(along <= T::zero())] = (at, along);
        }
        let (along, fraction, log) = best;
        let confirmed =
            fraction < T::one() && (along <= size * T::exact(FOLD_CONFIRMED.0) || along <= T::exact(FOLD_CONFIRMED.1));
        let determinant = (log - walk.start.log).exp() * along;
        confirmed.then_some(Failure::Fold { fraction, determinant })
    }
}

/// What B is bordered by.
#[derive(Clone, Copy)]
enum Border {
    /// The tangent at the last point.
    Tangent,
    /// (0, …, 0, 1): s is what it is.
    Upright,
}

/// Divides by the length of a vector, which is returned.
fn normalize<T: Real>(v: &mut [T]) -> T {
    let most = max_abs(&*v);
    if most == T::zero() || !most.all_finite() {
        return T::exact(f64::NAN);
    }
    let length = v.iter().fold(T::zero(), |sum, x| sum + (*x / most) * (*x / most)).sqrt() * most;
    v.iter_mut().for_each(|x| *x /= length);
    length
}

/// How many times as long as one that went this distance a step may be.
fn step_factor<T: Real>(distance: T) -> T {
    T::exact(STEP_SHARE) / larger(distance, T::exact(f64::MIN_POSITIVE))
}
