//! A step at any size is the one that continues from h = 0, or it is refused, for a reason that is one.
//!
//! The oracle follows the branch with the equations in 32 digits: residuals that cancel have digits there which `f64` has lost. Corrections are
//! by the Jacobian in `f64`, which is cheaper, and so are tangents that agree with those before; where the increments of h become small, as
//! they do at a fold, both are in 32 digits, too. A fold that is named is one where the oracle's branch ends there, and another root with det J of the
//! other sign meets it. A step that is refused for rounding is one whose equations, in the precision that was
//! refused, leave a residual that is large beside the momenta where the oracle's root is rounded.

use super::planted::retraction::Plant;
use super::precision::in_quad;
use super::probe::{Probe, stream};
use super::{CaseLaw, Source};
use crate::algebra::{Covector, Vector};
use crate::harness::{About, Cost, Fault, Verdict};
use crate::integrators::{OneStep, Solver, State, StepError};
use crate::laws::unbuilt;
use crate::mechanics::Lagrangian;
use crate::retraction::{Retraction, RetractionError};
use crate::scalar::{Dd, Real, convert, larger, max_abs};
use crate::system::dispatch::Scheme;
use crate::system::{CaseError, System, Visitor};
use nalgebra::DMatrix;

/// Newton's method from a constant velocity, without a look at the branch.
const ANY_ROOT: Fault = Fault::new(
    "any-root",
    "Newton's method at the full step from H_i = η; whatever root it finds is taken",
    "steps behind a fold, or with several roots",
);
/// A continuation that jumps.
const COARSE: Fault = Fault::new(
    "coarse-continuation",
    "a continuation in h by eighths of the step, without a look at det J or at tangents",
    "steps behind a fold, or with several roots",
);
/// A continuation that is generous.
const TENFOLD: Fault = Fault::new(
    "tenfold-continuation",
    "a continuation in h with increments, corrections, turns of the tangent and ‖ad‖ that may be ten times as large as the oracle's, and without a \
     look at det J",
    "steps behind a fold, or with several roots",
);
/// Residuals relative to terms that cancel, and nothing besides.
const OF_TERMS: Fault = Fault::new(
    "residual-of-terms",
    "Newton's method at the full step from H_i = η, until the residual is small relative to the largest term, however terms cancel, and however the \
     iterations got there",
    "steps with terms like e^{‖ad‖}, beyond 1/√u of the momentum; roots far from where iterations start",
);

/// A fold that is none, or not there.
const EARLY: Fault = Fault::new(
    "early-fold",
    "a fold is named at three quarters of where it is, or of a step that fixed-point iterations do not take",
    "steps that Newton's method takes or refuses",
);
/// A continuation without patience.
const GIVES_UP: Fault = Fault::new(
    "impatient-continuation",
    "a step that fixed-point iterations do not take is given up half-way",
    "steps that Newton's method takes",
);

/// A reason that is none.
const BLAMES_ROUNDING: Fault = Fault::new(
    "rounding-blamed",
    "a step that fixed-point iterations do not take is refused for rounding, at three quarters of it",
    "steps that Newton's method takes",
);

/// How much more is allowed with [`TENFOLD`].
const TENFOLD_LOOSE: f64 = 10.0;

/// A residual is small with [`OF_TERMS`] at this share of the largest term.
const SMALL: f64 = 1e-12;

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[CaseLaw {
            about: About {
                name: "branch",
                statement: "a step of any size, ‖ad_η‖|h| to 64, is the root of the stage equations that continues from h = 0, or it is \
                            refused; a fold that is named is one, and what is easily followed is not given up, but for rounding",
                source: "Keller 1977: a branch ends where det J = 0",
                oracle: "the branch from h = 0, followed in small steps of h, of no more than 1 in ‖ad‖, by code of its own: the equations in 32 digits, \
                         their Jacobian in f64, where increments are below 2⁻¹⁴ of the step in 32 digits",
                bound: "2⁻¹⁰ of the place of a fold; 2⁻¹⁶ of the displacements and the increment, or of their terms, beyond the rounding of the \
                        momentum: roots are farther apart, but next to a fold; the step in f64, in one case of ten that in 32 digits, too",
                needs: "an algebra that is not abelian",
                cost: Cost::Heavy,
                faults: &[ANY_ROOT, COARSE, TENFOLD, OF_TERMS, EARLY, GIVES_UP, BLAMES_ROUNDING],
            },
            cases: |cases| cases.main_dimensions().nonabelian(),
            check: |case, fault| built(case.visit::<f64, _>(&Plant(fault), Check { case, fault })),
        }]
    }
}

/// Distances of displacements that are not those of two roots, relative.
const BOUND: f64 = 1.0 / 65536.0;

/// How much rounding changes the momentum that a step starts from, relative: some units of round-off of `f64`.
const SHAKEN: f64 = 16.0 * f64::EPSILON;

/// The largest ‖ad_η‖|h|, and the number of halvings of it that are drawn.
const LARGEST: (f64, i32) = (64.0, 8);

fn built(verdict: Result<Verdict, CaseError>) -> Verdict {
    verdict.unwrap_or_else(|e| unbuilt(&e))
}

/// r(H) = 0, the stage equations of a step from a state. H_1 … H_s are one list.
trait Equations<T> {
    /// r at a share of the step.
    fn residual(&mut self, share: T, rates: &[T]) -> Result<Vec<T>, StepError>;

    /// Its Jacobian.
    fn jacobian(&mut self, share: T, rates: &[T]) -> Result<DMatrix<T>, StepError>;

    /// r at a share of the step, relative to the largest momentum: μ at the start, and l'(H_i).
    fn relative(&mut self, share: T, rates: &[T]) -> Option<f64>;

    /// Ξ_1 … Ξ_s at the whole step.
    fn displacements(&self, rates: &[T]) -> Vec<f64>;

    /// The largest sum of the sizes of the terms of Ξ_1 … Ξ_s or ξ: where they cancel, or where a stage is at rest, what is left is rounding.
    fn terms(&self, rates: &[T]) -> f64;

    /// The largest ‖ad‖ of a change of Ξ_1 … Ξ_s or ξ, where H and the share of the step become others.
    fn turn(&self, from: (f64, &[T]), to: (f64, &[T])) -> f64;
}

/// A step of the library from the state of a system.
struct Step<'a, T: Real, const N: usize, const D: usize> {
    method: Scheme<'a, T, N, D>,
    state: &'a State<T, N, D>,
    size: T,
    /// Those of H_1 … H_s in Ξ_1 … Ξ_s and ξ, by columns.
    weights: DMatrix<T>,
}

impl<'a, T, const N: usize, const D: usize> Step<'a, T, N, D>
where
    T: Real,
{
    /// Of a size.
    fn new(system: &'a System<T, N, D>, size: f64) -> Self {
        let (s, a, b) = (system.tableau.stages(), system.tableau.a(), system.tableau.b());
        let weights = DMatrix::from_fn(s, s + 1, |j, i| if i < s { a[(i, j)] } else { b[j] });
        Self { method: system.scheme(), state: &system.state, size: T::exact(size), weights }
    }

    /// Ξ_1 … Ξ_s of the step that the library takes, or why it refuses; or what is taken with a fault.
    fn taken(&mut self, eta: &Vector<T, N>, fault: Option<&Fault>) -> Taken {
        let mut branch = Branch::new(self.origin(eta), self, None, TENFOLD_LOOSE);
        let wrong = match fault.map(|fault| fault.name) {
            Some(name) if name == ANY_ROOT.name => Some(branch.stepwise(1)),
            Some(name) if name == COARSE.name => Some(branch.stepwise(8)),
            Some(name) if name == TENFOLD.name => Some(match branch.follow(true) {
                End::Reached { .. } => Ok(()),
                _ => Err(Lost),
            }),
            Some(name) if name == OF_TERMS.name => Some(branch.until_small_beside_terms()),
            _ => None,
        };
        if let Some(wrong) = wrong {
            wrong.map_err(|Lost| Refusal::Other("no convergence"))?;
            return Ok(branch.equations.displacements(&branch.rates));
        }
        let mut state = self.state.clone();
        let (size, early) = (self.size.to_f64(), Fault::planted(fault, EARLY.name));
        let report = self.method.step(&mut state, self.size).map_err(|error| match Refusal::of(&error, size) {
            Refusal::Fold(share) if early => Refusal::Fold(share * 0.75),
            refusal => refusal,
        })?;
        if report.solver != Solver::FixedPoint {
            if early {
                return Err(Refusal::Fold(0.75));
            }
            if Fault::planted(fault, GIVES_UP.name) {
                return Err(Refusal::Followed);
            }
            if Fault::planted(fault, BLAMES_ROUNDING.name) {
                return Err(Refusal::Rounding(0.75));
            }
        }
        Ok(self.method.stage_displacements().flat_map(|x| x.data.0[0]).map(|v| v.to_f64()).collect())
    }

    /// H at h = 0: η at each stage.
    fn origin(&self, eta: &Vector<T, N>) -> Vec<T> {
        (0..self.weights.nrows()).flat_map(|_| eta.iter().copied()).collect()
    }
}

fn vectors<T: Real, const N: usize>(rates: &[T]) -> Vec<Vector<T, N>> {
    rates.chunks_exact(N).map(Vector::from_column_slice).collect()
}

impl<T, const N: usize, const D: usize> Equations<T> for Step<'_, T, N, D>
where
    T: Real,
{
    fn residual(&mut self, share: T, rates: &[T]) -> Result<Vec<T>, StepError> {
        let mut residual = vec![Covector::zeros(); self.weights.nrows()];
        self.method.residual(self.state, self.size * share, &vectors(rates), &mut residual)?;
        Ok(residual.iter().flat_map(|r| r.iter().copied()).collect())
    }

    fn relative(&mut self, share: T, rates: &[T]) -> Option<f64> {
        let momenta = vectors::<T, N>(rates).into_iter().map(|rate| self.method.lagrangian().gradient(&rate).amax());
        let size = momenta.fold(self.state.momentum.amax(), larger);
        let residual = self.residual(share, rates).ok()?;
        (size > T::zero()).then(|| extent(&residual) / size.to_f64())
    }

    fn jacobian(&mut self, share: T, rates: &[T]) -> Result<DMatrix<T>, StepError> {
        self.method.stage_jacobian(self.state, self.size * share, &vectors(rates))
    }

    fn displacements(&self, rates: &[T]) -> Vec<f64> {
        let sums = DMatrix::from_column_slice(N, self.weights.nrows(), rates) * &self.weights * self.size;
        sums.as_slice()[..rates.len()].iter().map(|v| v.to_f64()).collect()
    }

    fn terms(&self, rates: &[T]) -> f64 {
        let rates = DMatrix::from_column_slice(N, self.weights.nrows(), rates);
        (rates.abs() * self.weights.abs() * self.size).amax().to_f64()
    }

    fn turn(&self, from: (f64, &[T]), to: (f64, &[T])) -> f64 {
        let [before, after] = [from.0, to.0].map(T::exact);
        let moved = from.1.iter().zip(to.1).map(|(a, b)| *b * after - *a * before);
        let moved = DMatrix::from_iterator(N, self.weights.nrows(), moved) * &self.weights * self.size;
        let turn = |x: &[T]| {
            let rows = self.method.retraction().algebra().ad(&Vector::from_column_slice(x));
            rows.row_iter().fold(0.0, |most, row| larger(most, row.abs().sum().to_f64()))
        };
        moved.as_slice().chunks_exact(N).map(turn).fold(0.0, larger)
    }
}

/// Ξ_1 … Ξ_s of a step, or why it is refused.
type Taken = Result<Vec<f64>, Refusal>;

/// Why a step is refused.
#[derive(Clone, Copy)]
enum Refusal {
    /// A fold at this share of it.
    Fold(f64),
    /// The branch was not followed to its end.
    Followed,
    /// Beyond this share of it rounding of the equations is too large.
    Rounding(f64),
    /// Another reason, without numbers: reasons are counted.
    Other(&'static str),
}

impl Refusal {
    fn of(error: &StepError, size: f64) -> Self {
        Self::Other(match error {
            StepError::Fold { fold, .. } => return Self::Fold(fold / size),
            StepError::Rounding { reached, .. } => return Self::Rounding(reached / size),
            StepError::TooLong { .. } | StepError::NotConverged { .. } => return Self::Followed,
            StepError::Domain { source: RetractionError::OutsideDomain { .. }, .. } => "outside the domain of τ",
            StepError::Domain { source: RetractionError::SingularTangent { .. }, .. } => "dτ is singular",
            StepError::Domain { .. } => "τ has no value",
            StepError::IllConditioned { .. } => "terms cancel, and rounding decides",
            StepError::Undefined { .. } => "the force has no finite value",
            StepError::Legendre { .. } => "the Legendre transform cannot be inverted",
            StepError::NotFinite { .. } => "the result is not finite",
            _ => "an error that is not one of a step",
        })
    }
}

/// The step in `f64`, and the way to the oracle.
struct Check<'a, S> {
    case: &'a S,
    fault: Option<&'a Fault>,
}

impl<S: Source> Visitor<f64> for Check<'_, S> {
    type Output = Verdict;

    const LARGE: bool = false;

    fn visit<const N: usize, const D: usize>(self, system: System<f64, N, D>) -> Verdict {
        let Self { case, fault } = self;
        let mut probe = Probe::new(case, stream::BRANCH);
        let Ok(eta) = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros()) else {
            return Verdict::inconclusive("no velocity");
        };
        let ad = system.algebra.ad(&eta);
        let rate = ad.row_iter().map(|row| row.abs().sum()).fold(eta.amax(), f64::max);
        let halvings: f64 = probe.power_of_two(-LARGEST.1, 0);
        let angle = LARGEST.0 * halvings * (1.0 + probe.unit::<f64>().abs()) / 2.0;
        let size = if rate > 0.0 { angle / rate * system.step.signum() } else { system.step };
        // Next to rest, with a rotor, what is left of a velocity is the rounding of momenta.
        let shaken = system.state.momentum * (1.0 + SHAKEN);
        let shaken = system.lagrangian.velocity(&shaken, &eta).map_or(0.0, |other| (other - eta).amax());
        let mut step = Step::new(&system, size);
        let taken = step.taken(&eta, fault);
        match (in_quad(case, 0), taken) {
            (Err(error), _) => built(Err(error)),
            (Ok(false), Err(Refusal::Other(why))) => refused(why),
            (Ok(quad), taken) => {
                let oracle = Oracle { taken, quad, size, rounding: shaken * size.abs(), rough: &mut step, fault };
                built(case.visit::<Dd, _>(&Plant(fault), oracle))
            }
        }
    }
}

fn refused(why: &str) -> Verdict {
    Verdict::not_applicable(format!("the step is refused: {why}"))
}

/// The branch in 32 digits, and what was taken beside it.
struct Oracle<'a> {
    /// The step in `f64`.
    taken: Taken,
    /// Whether that in 32 digits is judged, too.
    quad: bool,
    size: f64,
    /// Displacements by the rounding of the momentum that the step starts from.
    rounding: f64,
    /// The equations in `f64`.
    rough: &'a mut dyn Equations<f64>,
    fault: Option<&'a Fault>,
}

impl Visitor<Dd> for Oracle<'_> {
    type Output = Verdict;

    const LARGE: bool = false;

    fn visit<const N: usize, const D: usize>(self, system: System<Dd, N, D>) -> Verdict {
        let Ok(eta) = system.lagrangian.velocity(&system.state.momentum, &Vector::zeros()) else {
            return Verdict::inconclusive("no velocity");
        };
        let mut step = Step::new(&system, self.size);
        let quad = self.quad.then(|| step.taken(&eta, self.fault));
        let taken: Vec<_> = std::iter::once(self.taken).chain(quad).collect();
        let origin = step.origin(&eta);
        let mut branch = Branch::new(origin, &mut step, Some(self.rough), 1.0);
        let any = |asked: fn(&Taken) -> bool| taken.iter().any(asked);
        let end = match any(|taken| !matches!(taken, Err(Refusal::Other(_) | Refusal::Rounding(_)))) {
            true => branch.follow(any(|taken| matches!(taken, Ok(_) | Err(Refusal::Fold(_))))),
            false => End::Lost,
        };
        let right = branch.equations.displacements(&branch.rates);
        let terms = branch.equations.terms(&branch.rates);
        let judged = taken.iter().zip([false, true]).map(|(taken, quad)| match taken {
            Ok(found) => judge(end, self.size, found, (&right, terms, self.rounding)),
            Err(Refusal::Rounding(share)) => branch.judge_rounding(*share, self.size, quad),
            Err(refusal) => judge_refusal(end, self.size, *refusal),
        });
        judged.reduce(Verdict::and).unwrap_or_else(|| Verdict::inconclusive("no step"))
    }
}

/// The verdict on a refusal, where the branch leads to this end.
fn judge_refusal(end: End, size: f64, refusal: Refusal) -> Verdict {
    match (refusal, end) {
        (Refusal::Other(why), _) => refused(why),
        (Refusal::Rounding(_), _) => Verdict::inconclusive("the residual was not looked at"),
        (Refusal::Followed, End::Reached { easy: true }) => Verdict::broken(format!(
            "at h = {size:e} the step is given up, and {EASY} points with increments of 2⁻¹⁴ of it and more lead there"
        )),
        (Refusal::Followed, _) => Verdict::inconclusive("the branch is followed to a part of the step"),
        (Refusal::Fold(named), End::Reached { .. }) => Verdict::broken(format!(
            "at h = {size:e} a fold is named at {named:.6} of the step, and the branch leads to its end"
        )),
        (Refusal::Fold(named), End::Fold { share, turns }) => {
            let off = (named - share) / share.max(f64::MIN_POSITIVE);
            match turns {
                _ if off < -PLACE => Verdict::broken(format!(
                    "at h = {size:e} a fold is named at {named:.6} of the step, and the branch leads to {share:.6} of it"
                )),
                true => Verdict::judge(off.abs(), PLACE, || {
                    format!(
                        "at h = {size:e} a fold is named at {named:.6} of the step, and the branch turns at {share:.6} of it"
                    )
                }),
                false => Verdict::inconclusive("a fold is named beyond where the oracle follows the branch"),
            }
        }
        (Refusal::Fold(_), End::Lost) => Verdict::inconclusive("the branch was not followed to its end"),
    }
}

/// The verdict on displacements that were found, where the branch leads to this end, and to these, whose terms have this size, and rounding.
fn judge(end: End, size: f64, found: &[f64], (right, terms, rounding): (&[f64], f64, f64)) -> Verdict {
    match end {
        End::Reached { .. } => {
            let extent = larger(max_abs(found), terms);
            let off = right.iter().zip(found).fold(0.0_f64, |off, (a, b)| larger(off, (a - b).abs()));
            let beyond = larger(off - rounding, 0.0);
            Verdict::judge(if beyond == 0.0 { 0.0 } else { beyond / extent }, BOUND, || {
                format!("at h = {size:e} the step is on another branch: Ξ = {found:?}, and {right:?} from h = 0")
            })
        }
        End::Fold { share, .. } if share > NEARLY => Verdict::inconclusive("the step is next to the end of the branch"),
        End::Fold { share, .. } => Verdict::broken(format!(
            "at h = {size:e} a step is taken, and the branch ends near {share:.6} of it: Ξ = {found:?}"
        )),
        End::Lost => Verdict::inconclusive("the branch was not followed to its end"),
    }
}

/// A fold beyond this share of the step may be a step of rounding away from it.
const NEARLY: f64 = 1.0 - 1.0 / 1024.0;

/// Why a step is refused that rounding keeps from its end.
const LARGE: &str = "rounding of the equations is larger than what is accepted";

/// A step that is refused for rounding leaves at least this in units of round-off, relative to the momenta: Newton's method refuses what is beyond
/// 2¹⁴ of the terms, which are no smaller but for what dτ makes of momenta.
const NOISE: f64 = (1 << 8) as f64;

/// How far from the place of a fold it may be named, relative.
const PLACE: f64 = 1.0 / 1024.0;

/// A branch of no more points, whose increments do not become small, is followed easily. Those that [`ANGLE`] asks for are not counted.
const EASY: usize = 256;

/// The most points of a branch.
const POINTS: usize = 4000;

/// The first increment of h, and the least, relative to the step.
const INCREMENTS: (f64, f64) = (1.0 / 256.0, 1.0 / (1 << 24) as f64);

/// With increments below this the Jacobian is that of the equations themselves: at a fold, or where terms cancel.
const CLOSE: f64 = 1.0 / (1 << 14) as f64;

/// A correction at most this share of the predicted change belongs to the branch; with a sixteenth of it the increment is doubled.
const NEAR: f64 = 1.0 / 16.0;

/// From one point to the next the tangent changes by at most this share of itself; with a quarter of it the increment is doubled.
const TURN: f64 = 1.0 / 8.0;

/// And the displacements change by at most this, in ‖ad‖: a longer step may pass by where dτ is singular, and by the folds there.
const ANGLE: f64 = 1.0;

/// A change of this share of H is none: at h = 0 the tangent may vanish, and whatever it is next is a turn.
const SLIGHT: f64 = 1e-6;

/// The most iterations of Newton's method at a point.
const ITERATIONS: usize = 30;

/// Corrections below this share of H end an iteration: the next would be below rounding of `f64`.
const ROUNDING: f64 = 1.0 / (1_u64 << 28) as f64;

/// So do those that leave this share of the predicted change, but at the whole step: the next prediction knows no more.
const LEFT: f64 = 1.0 / (1 << 16) as f64;

/// Where a correction is at most this share of the one before, and the residual of that before, no new Jacobian is needed. By an old one corrections
/// may fall where residuals do not: where terms grow, 4·10⁻³ and 4·10⁻⁵ were followed by 5·10⁻⁴.
const FAST: f64 = 1.0 / 16.0;

/// Where the branch led.
#[derive(Clone, Copy)]
enum End {
    /// To the whole step; and whether that was easy.
    Reached { easy: bool },
    /// It is not followed beyond this share of the step; and whether it turns back there.
    Fold { share: f64, turns: bool },
    /// [`POINTS`] were not enough, or it was not followed that far.
    Lost,
}

/// A root H of the stage equations at a share of a step.
struct Branch<'a, T> {
    equations: &'a mut dyn Equations<T>,
    /// The equations that the Jacobian is of, unless increments are small; none: the same.
    rough: Option<&'a mut dyn Equations<f64>>,
    /// H_1 … H_s.
    rates: Vec<T>,
    /// Those at h = 0.
    origin: Vec<T>,
    /// Whether increments are below [`CLOSE`].
    close: bool,
    /// From rest H has no size of its own: that of the correction to the whole step.
    size: f64,
    /// How many times as much is allowed as it should be: 1, but with a fault.
    loose: f64,
    /// To which share of the step it is followed.
    end: f64,
}

/// What Newton's method found.
struct Root<T: Real> {
    /// Of the last Jacobian.
    factors: Factors<T>,
    /// The first correction.
    first: f64,
}

/// b ↦ x with J x = b, if there is one.
type Solve<T> = Box<dyn Fn(&[T]) -> Option<Vec<T>>>;

/// LU factors of a Jacobian: in `f64`, which is cheaper, or in the digits of the equations. Where terms grow, J may have a condition number beyond 1/u
/// of `f64`.
struct Factors<T> {
    /// J⁻¹ r.
    solve: Solve<T>,
    /// det J < 0.
    negative: bool,
}

impl<T: Real> Factors<T> {
    fn of<W: Real>(jacobian: DMatrix<W>) -> Self {
        let factors = jacobian.lu();
        let negative = factors.determinant() < W::zero();
        let solve = move |right: &[T]| {
            let right = DMatrix::from_iterator(right.len(), 1, right.iter().map(|v| convert::<T, W>(*v)));
            factors.solve(&right).map(|x| x.iter().map(|v| convert(*v)).collect())
        };
        Self { solve: Box::new(solve), negative }
    }
}

/// The largest of a list, in `f64`; NaN if there is one.
fn extent<T: Real>(values: &[T]) -> f64 {
    values.iter().fold(0.0, |extent, v| larger(extent, v.abs().to_f64()))
}

/// A point of the branch.
struct Point<T> {
    share: f64,
    rates: Vec<T>,
    tangent: DMatrix<f64>,
    /// The predicted change that it was found with.
    chord: f64,
    settled: Settled,
}

/// How exact a point is.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
enum Settled {
    /// As it was found.
    No,
    /// To rounding, and the tangent is that at H, by the Jacobian in `f64`.
    Rough,
    /// To rounding, by that of the equations.
    Full,
}

impl<T: Real> Point<T> {
    /// The change of H up to `share`: the cubic through this point and the one before, with their tangents, or the tangent alone.
    fn predict(&self, before: Option<&Self>, share: f64) -> DMatrix<f64> {
        let ahead = share - self.share;
        let along = &self.tangent * ahead;
        let Some(before) = before else { return along };
        let length = self.share - before.share;
        let moved = self.rates.iter().zip(&before.rates).map(|(now, then)| (*now - *then).to_f64() / length);
        let chord = DMatrix::from_iterator(self.rates.len(), 1, moved);
        // Divided differences, with each point twice.
        let second = (&self.tangent - &chord) / length;
        let third = (&self.tangent + &before.tangent - chord * 2.0) / (length * length);
        along + (second + third * (ahead + length)) * (ahead * ahead)
    }
}

impl<'a, T: Real> Branch<'a, T> {
    /// That from H at h = 0, to the whole step.
    fn new(
        origin: Vec<T>,
        equations: &'a mut dyn Equations<T>,
        rough: Option<&'a mut dyn Equations<f64>>,
        loose: f64,
    ) -> Self {
        Self { rates: origin.clone(), origin, equations, rough, close: false, size: 0.0, loose, end: 1.0 }
    }

    /// The largest of H.
    fn extent(&self) -> f64 {
        extent(&self.rates)
    }

    fn rough_rates(&self) -> Vec<f64> {
        self.rates.iter().map(|v| v.to_f64()).collect()
    }

    fn factors(&mut self, share: f64) -> Result<Factors<T>, StepError> {
        let rates = self.rough_rates();
        Ok(match &mut self.rough {
            Some(rough) if !self.close => Factors::of(rough.jacobian(share, &rates)?),
            _ => Factors::of(self.equations.jacobian(T::exact(share), &self.rates)?),
        })
    }

    /// Newton's method at a share of the step. With `chord`, the predicted change, the first correction is at most [`NEAR`] of that, and each is
    /// at most a quarter of the one before. What is left is at most the share `left` of it, or rounding.
    fn newton(&mut self, share: f64, chord: Option<f64>, left: f64) -> Result<Root<T>, Lost> {
        let (mut root, mut last, loose) = (None::<Root<T>>, None, self.loose);
        for _ in 0..ITERATIONS {
            let right = self.equations.residual(T::exact(share), &self.rates)?;
            let kept = root.as_ref().and_then(|root| (root.factors.solve)(&right));
            let size = extent(&right);
            let falls = |now: f64, before: f64| now <= before * FAST;
            let kept = kept.filter(|correction| {
                last.is_some_and(|(moved, left): (f64, f64)| falls(extent(correction), moved) && falls(size, left))
            });
            let correction = match kept {
                Some(correction) => correction,
                None => {
                    let factors = self.factors(share)?;
                    let correction = (factors.solve)(&right).ok_or(Lost)?;
                    let first = root.map_or(extent(&correction), |root| root.first);
                    root = Some(Root { factors, first });
                    correction
                }
            };
            let moved = extent(&correction);
            if !moved.is_finite() {
                return Err(Lost);
            }
            let rounding = self.extent() * ROUNDING;
            let beyond = |limit: f64| moved > limit && moved > rounding;
            let limit = |chord| last.map_or(chord * NEAR, |(last, _)| last * 0.25) * loose;
            if chord.is_some_and(|chord| beyond(limit(chord))) {
                return Err(Lost);
            }
            for (rate, d) in self.rates.iter_mut().zip(&correction) {
                *rate -= *d;
            }
            // As much smaller as this correction than the one before.
            let rest = last.map(|(last, _)| moved * (moved / last));
            let enough = chord.zip(rest).is_some_and(|(chord, rest)| rest <= chord * left);
            if moved <= rounding || enough {
                return root.ok_or(Lost);
            }
            last = Some((moved, size));
        }
        Err(Lost)
    }

    /// dH/ds at a root, s the share of the step: −J⁻¹ ∂r/∂s, by a central difference; `rough` in `f64`.
    fn tangent(&mut self, share: f64, root: &Root<T>, rough: bool) -> Result<DMatrix<f64>, Lost> {
        let rates = self.rough_rates();
        let slopes = match &mut self.rough {
            Some(equations) if rough => slopes(&mut **equations, share, &rates)?.into_iter().map(T::exact).collect(),
            _ => slopes(&mut *self.equations, share, &self.rates)?,
        };
        let tangent = (root.factors.solve)(&slopes).ok_or(Lost)?;
        let tangent = DMatrix::from_iterator(tangent.len(), 1, tangent.iter().map(|v| v.to_f64()));
        Some(tangent).filter(|t| t.iter().all(|v| v.is_finite())).ok_or(Lost)
    }

    /// The next point, from the last two, whether the next increment may be twice as long, and whether this one was long in ‖ad‖.
    fn next(&mut self, points: &[Point<T>], target: f64, negative: &mut bool) -> Result<(Point<T>, bool, bool), Lost> {
        let [.., here] = points else { return Err(Lost) };
        let before = points.len().checked_sub(2).and_then(|k| points.get(k));
        let (ahead, length) = (here.predict(before, target), target - here.share);
        let slight = self.extent().max(self.size) * SLIGHT;
        let chord = ahead.amax() + slight;
        for (rate, d) in self.rates.iter_mut().zip(ahead.iter()) {
            *rate += T::exact(*d);
        }
        let root = self.newton(target, Some(chord), if target < self.end { LEFT } else { 0.0 })?;
        let slight = |off: f64| off <= slight;
        let apart = self.equations.turn((here.share, &here.rates), (target, &self.rates));
        let loose = self.loose;
        if apart > ANGLE * loose {
            return Err(Lost);
        }
        // In 32 digits where those of `f64` turn.
        let scalars: &[bool] = if self.close { &[false] } else { &[true, false] };
        for &rough in scalars {
            let tangent = self.tangent(target, &root, rough)?;
            let turn = max_abs(&(&tangent - &here.tangent));
            let relative = turn / here.tangent.amax().max(tangent.amax());
            let turns = |most: f64| relative > most * loose && !slight(turn * length);
            let same = if root.factors.negative == *negative || loose > 1.0 {
                !turns(TURN)
            } else {
                // Where another branch crosses, as it does where a steady rotation loses its stability.
                slight(root.first) && slight(turn * length)
            };
            if same {
                *negative = root.factors.negative;
                let easy = root.first <= chord * NEAR * NEAR && !turns(TURN / 4.0) && apart <= ANGLE / 2.0;
                let (rates, settled) = (self.rates.clone(), Settled::No);
                return Ok((Point { share: target, rates, tangent, chord, settled }, easy, apart >= ANGLE / 4.0));
            }
        }
        Err(Lost)
    }

    /// A point to rounding, and the tangent with the Jacobian there: next to it what was left, or how the Jacobian has changed since the
    /// prediction, may be more than what an increment may miss. Once more with the Jacobian of the equations, when it comes to that: that in `f64` may
    /// leave more, or fail.
    fn settle(&mut self, point: &mut Point<T>) -> Result<(), Lost> {
        let settled = if self.close { Settled::Full } else { Settled::Rough };
        if point.settled >= settled {
            return Ok(());
        }
        let mut root = self.newton(point.share, Some(point.chord), 0.0)?;
        root.factors = self.factors(point.share)?;
        point.tangent = self.tangent(point.share, &root, false)?;
        point.rates.clone_from(&self.rates);
        point.settled = settled;
        Ok(())
    }

    /// To the end, by small increments: the points before predict, and the tangent turns little from one point to the next. A change of
    /// the sign of det J is the end, but where the branch goes on as predicted. Only as far as it is easy, unless `wherever` it leads is asked.
    fn follow(&mut self, wherever: bool) -> End {
        let Ok(start) = self.newton(0.0, None, 0.0) else { return End::Lost };
        let Ok(tangent) = self.tangent(0.0, &start, false) else { return End::Lost };
        if self.extent() == 0.0
            && let Ok(right) = self.equations.residual(T::one(), &self.rates)
        {
            self.size = (start.factors.solve)(&right).map_or(0.0, |correction| extent(&correction));
        }
        let mut negative = start.factors.negative;
        let (rates, settled) = (self.rates.clone(), Settled::Full);
        let mut points = vec![Point { share: 0.0, rates, tangent, chord: 0.0, settled }];
        let (mut reached, mut increment, mut easily) = (0.0, INCREMENTS.0 * self.loose, true);
        let mut short = 0;
        for _ in 0..POINTS {
            easily &= short < EASY && increment >= CLOSE;
            if !easily && !wherever {
                return End::Lost;
            }
            self.close = increment < CLOSE;
            let target = (reached + increment).min(self.end);
            match self.next(&points, target, &mut negative) {
                Ok((point, easy, long)) => {
                    short += usize::from(!long);
                    if points.len() > 1 {
                        points.remove(0);
                    }
                    points.push(point);
                    reached = target;
                    if reached >= self.end {
                        return End::Reached { easy: easily };
                    }
                    if easy {
                        increment += increment;
                    }
                }
                Err(Lost) => {
                    short += 1;
                    if let Some(point) = points.last_mut() {
                        self.rates.clone_from(&point.rates);
                        if self.settle(point).is_err() {
                            self.rates.clone_from(&point.rates);
                        }
                    }
                    increment *= 0.5;
                    // A fold is seen from afar; what else makes increments small is followed to the least of them.
                    if increment < CLOSE {
                        let end = self.turn(&points, negative);
                        if increment < INCREMENTS.1 || matches!(end, End::Fold { turns: true, .. }) {
                            return end;
                        }
                        if let Some(point) = points.last() {
                            self.rates.clone_from(&point.rates);
                        }
                    }
                }
            }
        }
        End::Lost
    }
}

impl<T: Real> Branch<'_, T> {
    /// The verdict on a step that is refused for rounding at a share of it: what the root there leaves, in `f64` or in 32 digits.
    fn judge_rounding(&mut self, share: f64, size: f64, quad: bool) -> Verdict {
        (self.rates, self.end, self.size, self.close) = (self.origin.clone(), share, 0.0, false);
        if !matches!(self.follow(true), End::Reached { .. }) {
            return Verdict::inconclusive("the branch was not followed to where rounding is said to be large");
        }
        let (left, unit) = if quad {
            (self.equations.relative(T::exact(share), &self.rates), T::unit_roundoff().to_f64())
        } else {
            let rates = self.rough_rates();
            (self.rough.as_mut().and_then(|rough| rough.relative(share, &rates)), f64::EPSILON / 2.0)
        };
        match left.map(|left| left / unit) {
            None => Verdict::inconclusive("no momentum, or no residual, where rounding is said to be large"),
            Some(left) if left >= NOISE => refused(LARGE),
            Some(left) => Verdict::broken(format!(
                "at h = {size:e} the step is refused for rounding at {share:.6} of it, where the root leaves {left:.1e} units of round-off"
            )),
        }
    }

    /// Newton's method at `parts` parts of the step, one after the other, wherever it leads.
    fn stepwise(&mut self, parts: u32) -> Result<(), Lost> {
        (1..=parts).try_for_each(|part| self.newton(f64::from(part) / f64::from(parts), None, 0.0).map(|_| ()))
    }

    /// Newton's method at the whole step, wherever it leads, until r is small relative to the terms |∂r/∂H| |H|.
    fn until_small_beside_terms(&mut self) -> Result<(), Lost> {
        for _ in 0..ITERATIONS {
            let right = self.equations.residual(T::one(), &self.rates)?;
            let jacobian = self.equations.jacobian(T::one(), &self.rates)?;
            let terms = jacobian
                .row_iter()
                .map(|row| row.iter().zip(&self.rates).fold(0.0, |sum, (j, v)| sum + (*j * *v).abs().to_f64()));
            if extent(&right) <= terms.fold(0.0, larger) * SMALL {
                return Ok(());
            }
            let correction = (Factors::of(jacobian).solve)(&right).ok_or(Lost)?;
            for (rate, d) in self.rates.iter_mut().zip(&correction) {
                *rate -= *d;
            }
        }
        Err(Lost)
    }

    /// The end of a branch that is followed no further: at a fold |dH/ds|⁻² falls to 0 linearly, and what comes back from there is a root with det J of
    /// the other sign, as far on the other side of it.
    fn turn(&mut self, points: &[Point<T>], negative: bool) -> End {
        let [before, here] = points else {
            return End::Fold { share: points.last().map_or(0.0, |point| point.share), turns: false };
        };
        let lost = End::Fold { share: here.share, turns: false };
        let [then, now] = [before, here].map(|point| point.tangent.norm_squared().recip());
        let ahead = now * (here.share - before.share) / (then - now);
        if !(ahead > 0.0 && ahead <= here.share * PLACE) {
            return lost;
        }
        for (rate, (at, d)) in self.rates.iter_mut().zip(here.rates.iter().zip(here.tangent.iter())) {
            *rate = *at + T::exact(4.0 * ahead * d);
        }
        self.close = true;
        let Ok(other) = self.newton(here.share, None, 0.0) else { return lost };
        let apart = |sign: f64| {
            let off = self.rates.iter().zip(&here.rates).zip(here.tangent.iter());
            off.fold(0.0, |most, ((a, b), d)| larger(most, ((*a - *b).to_f64() + sign * 4.0 * ahead * d).abs()))
        };
        // Nearer to where it is expected than to where the branch is.
        let across = apart(-1.0) < 0.5 * 4.0 * ahead * here.tangent.amax();
        match across && other.factors.negative != negative {
            true => End::Fold { share: here.share + ahead, turns: true },
            false => lost,
        }
    }
}

/// ∂r/∂s, by a central difference.
fn slopes<T: Real>(equations: &mut dyn Equations<T>, share: f64, rates: &[T]) -> Result<Vec<T>, StepError> {
    let (share, away) = (T::exact(share), T::exact(T::unit_roundoff().to_f64().cbrt()));
    let ahead = equations.residual(share + away, rates)?;
    let behind = equations.residual(share - away, rates)?;
    Ok(ahead.iter().zip(&behind).map(|(a, b)| (*b - *a) / (away + away)).collect())
}

/// No root near the prediction.
struct Lost;

impl From<StepError> for Lost {
    fn from(_: StepError) -> Self {
        Self
    }
}
