//! The engine of any tableau: steps in pairs, compared with one of twice the size.

use super::control::{Control, Statistics};
use super::dense::{Maker, Piece};
use super::engine::{Engine, Task};
use super::error::SolveError;
use super::measure::Ease;
use super::pair::Pair;
use super::{MOST_STAGES, Method, gauss_stages};
use crate::integrators::variational::{Exchange, Uncontracted};
use crate::integrators::{State, StepError};
use crate::mechanics::{Force, Lagrangian};
use crate::retraction::Retraction;
use crate::scalar::Real;
use crate::tableau::{Family, Tableau, TableauError};

/// Pairs of steps of a Lagrangian, a force and a retraction; what [`Solve::new`](super::Solve::new) takes.
pub struct Pairs<T: Real, const N: usize, const D: usize, L, F, R> {
    pair: Pair<T, N, D, L, F, R>,
    maker: Maker<T, N>,
    control: Control<T>,
    /// That of the pair taken last.
    residual: T,
}

/// The tableau for a tolerance.
fn chosen<T: Real>(method: &Method<T>, tolerance: T) -> Result<Tableau<T>, TableauError> {
    let family = match method {
        Method::Tableau(tableau) => return Ok(tableau.clone()),
        Method::Family(family) => *family,
    };
    let order = Family::Gauss.declared(gauss_stages(tolerance.to_f64()));
    let stages = (family.least_stages()..=2 * MOST_STAGES).find(|&stages| family.declared(stages) >= order);
    family.tableau(stages.unwrap_or(MOST_STAGES))
}

impl<T, const N: usize, const D: usize, L, F, R> Engine<T, N, D> for Pairs<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N> + Clone,
    F: Force<T, N> + Clone,
    R: Retraction<T, N, D> + Clone,
{
    type Parts = (L, F, R);
    type Retraction = R;

    fn new(
        (lagrangian, force, retraction): &Self::Parts,
        method: &Method<T>,
        tolerance: T,
        start: &State<T, N, D>,
    ) -> Result<Self, TableauError> {
        let tableau = chosen(method, tolerance)?;
        let pair = Pair::new((lagrangian, force, retraction), &tableau, start);
        let maker = Maker::new(&pair.through, tableau.stages())?;
        let control = Control::new(start.time, start.time, tolerance, pair.order, T::zero(), None);
        Ok(Self { pair, maker, control, residual: T::zero() })
    }

    fn begin(&mut self, start: &State<T, N, D>, task: &Task<T>) -> Result<(), SolveError> {
        let refused = |source| SolveError::Start { time: start.time.to_f64(), source };
        self.pair.begin(start).map_err(refused)?;
        let first = match task.first_step {
            Some(step) => step,
            None => Control::first((task.end - task.start).abs(), self.pair.rate(0, Ease::OfBlocks)),
        };
        let order = self.pair.order;
        self.control = Control::new(task.start, task.end, task.tolerance, order, first, task.max_step);
        self.residual = T::zero();
        Ok(())
    }

    fn ended(&self) -> bool {
        self.control.ended()
    }

    fn advance(&mut self, task: &Task<T>, statistics: &mut Statistics<T>) -> Result<usize, SolveError> {
        let Self { pair, control, .. } = self;
        control.within(statistics, task.most_steps)?;
        if let Some(needed) = control.lags(statistics, task.most_steps) {
            return Err(self.too_slow(task, statistics, needed));
        }
        let plan = control.plan();
        match pair.attempt(&plan, statistics) {
            Ok(attempt) if control.admits(&plan, &attempt) => {
                control.accept(&plan, &attempt, pair.rate(2, Ease::OfCoordinates));
                statistics.error += attempt.unexplained + attempt.noise;
                self.residual = attempt.residual;
                Ok(2)
            }
            outcome => {
                statistics.rejected += 1;
                match outcome {
                    Ok(attempt) => match control.refuse(&plan, Ok(attempt)) {
                        Err(SolveError::Tolerance { .. }) if pair.look_ahead(task.end) => control.again(plan.step),
                        refused => refused?,
                    },
                    Err(Uncontracted::Refused(error)) => control.refuse(&plan, Err(error))?,
                    Err(Uncontracted::Slow(spent)) => {
                        statistics.iterations += spent;
                        control.shorten(&plan);
                    }
                }
                Ok(0)
            }
        }
    }

    fn ends(&self, k: usize) -> [&State<T, N, D>; 2] {
        [k, k + 1].map(|point| &self.pair.points[point].state)
    }

    fn residual(&self) -> T {
        self.residual
    }

    fn piece(&mut self, k: usize, tolerance: T, piece: &mut Piece<T, N, D>) -> Result<(), StepError> {
        self.maker.make(&self.pair.passed(k), tolerance, piece)
    }

    fn exchange(&mut self, k: usize) -> Exchange<T> {
        self.pair.exchange(k)
    }

    fn power(&self, k: usize, state: &State<T, N, D>) -> Result<Exchange<T>, StepError> {
        self.pair.power(state, k)
    }

    fn retraction(&self) -> &R {
        self.pair.retraction()
    }

    fn tableau(&self) -> &Tableau<T> {
        self.pair.tableau()
    }

    fn kept(&mut self) {
        self.pair.accept();
    }

    fn next_step(&self) -> T {
        self.control.next()
    }
}

impl<T, const N: usize, const D: usize, L, F, R> Pairs<T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N> + Clone,
    F: Force<T, N> + Clone,
    R: Retraction<T, N, D> + Clone,
{
    /// The number of steps that the run would need.
    fn too_slow(&self, task: &Task<T>, statistics: &Statistics<T>, needed: f64) -> SolveError {
        let (axis, rate) = self.pair.fastest();
        let chosen = gauss_stages(task.tolerance.to_f64());
        SolveError::TooSlow {
            time: self.pair.points[0].state.time.to_f64(),
            step: self.control.next().to_f64(),
            steps: statistics.steps + 2 * statistics.rejected,
            needed,
            allowed: task.most_steps,
            axis: axis + 1,
            rate: rate.to_f64(),
            stages: Some(chosen).filter(|&stages| self.pair.order < Family::Gauss.declared(stages)),
        }
    }
}
