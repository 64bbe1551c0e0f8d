//! The run itself: steps, rows, progress. Its memory does not grow with the number of steps.

use super::columns::{Columns, print};
use super::plot::Trace;
use euler_poincare::algebra::{Casimir, Vector, pair};
use euler_poincare::integrators::trajectory::{Totals, TrajectoryError, integrate_until};
use euler_poincare::integrators::{OneStep, Report, State, StepError, Variational};
use euler_poincare::mechanics::{Force, Lagrangian};
use euler_poincare::retraction::Retraction;
use euler_poincare::scalar::Real;
use euler_poincare::system::{System, SystemFile, Visitor};
use indicatif::{ProgressBar, ProgressStyle};
use std::cell::Cell;
use std::io::{self, BufWriter, Write};
use std::ops::ControlFlow;
use std::time::{Duration, Instant};

/// A run shorter than this shows no progress.
pub const PATIENCE: Duration = Duration::from_secs(2);

/// Where rows go.
pub struct Recorder {
    out: BufWriter<Box<dyn Write>>,
    line: String,
    rows: u64,
    failure: Option<io::Error>,
    wants_trace: bool,
    trace: Option<Trace>,
    started: Instant,
    shows_progress: bool,
    bar: Option<ProgressBar>,
}

impl Recorder {
    /// A recorder of rows to `out`, that keeps a trace for a figure, and shows progress on stderr, if asked to.
    pub fn new(out: BufWriter<Box<dyn Write>>, wants_trace: bool, shows_progress: bool) -> Self {
        Self {
            out,
            line: String::new(),
            rows: 0,
            failure: None,
            wants_trace,
            trace: None,
            started: Instant::now(),
            shows_progress,
            bar: None,
        }
    }

    /// Rows written.
    pub fn rows(&self) -> u64 {
        self.rows
    }

    /// Flushes; the trace, if one was asked for.
    pub fn finish(mut self) -> io::Result<Option<Trace>> {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
        match self.failure.take() {
            Some(error) => Err(error),
            None => self.out.flush().map(|()| self.trace.take()),
        }
    }

    fn write_line(&mut self) {
        self.line.push('\n');
        if self.failure.is_none() {
            self.failure = self.out.write_all(self.line.as_bytes()).err();
        }
        self.line.clear();
    }

    fn header(&mut self, columns: &Columns) {
        self.line.push_str(&columns.header());
        self.write_line();
        self.trace = self.wants_trace.then(|| Trace::new(columns.clone()));
    }

    fn row<T: Real>(&mut self, values: &[T], iterations: usize) {
        for value in values {
            print(&mut self.line, *value);
            self.line.push(',');
        }
        self.line.push_str(&iterations.to_string());
        self.write_line();
        self.rows += 1;
        if let Some(trace) = &mut self.trace {
            trace.add(values);
        }
    }

    fn progress(&mut self, done: u64, total: u64) {
        if !self.shows_progress || !done.is_multiple_of(32) {
            return;
        }
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        } else if self.started.elapsed() > PATIENCE {
            let bar = ProgressBar::new(total).with_elapsed(self.started.elapsed());
            if let Ok(style) = ProgressStyle::with_template("{bar:40} {human_pos}/{human_len} steps, {eta} left") {
                bar.set_style(style);
            }
            bar.set_position(done);
            self.bar = Some(bar);
        }
    }
}

/// How a run ended.
pub enum Ended {
    /// At its horizon (or the reader of its rows went away); what it cost.
    Whole(String),
    /// Earlier, for this reason.
    Failed(String),
}

/// A run, for a system of any dimension.
pub struct Run<'a, T> {
    file: &'a SystemFile,
    steps: u64,
    last: Option<T>,
    recorder: &'a mut Recorder,
}

impl<'a, T: Real> Run<'a, T> {
    /// The run of `file` in so many steps, and perhaps a last one of another size.
    pub fn new(file: &'a SystemFile, (steps, last): (u64, Option<T>), recorder: &'a mut Recorder) -> Self {
        Self { file, steps, last, recorder }
    }
}

/// A method that also sums h Σ b_i ⟨f(t + c_i h, η_i), η_i⟩, the work of the force by the method's quadrature.
struct Metered<'a, T: Real, const N: usize, const D: usize, L, F, R> {
    method: Variational<T, N, D, L, F, R>,
    work: &'a Cell<T>,
}

impl<T, const N: usize, const D: usize, L, F, R> OneStep<T, N, D> for Metered<'_, T, N, D, L, F, R>
where
    T: Real,
    L: Lagrangian<T, N>,
    F: Force<T, N>,
    R: Retraction<T, N, D>,
{
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        let start = state.time;
        let report = self.method.step(state, h)?;
        let (b, c) = (self.method.tableau().b(), self.method.tableau().c());
        let mut power = T::zero();
        for (i, eta) in self.method.stage_velocities().enumerate() {
            power += b[i] * pair(&self.method.force().force(start + c[i] * h, &eta), &eta);
        }
        self.work.set(self.work.get() + h * power);
        Ok(report)
    }
}

/// What a row is computed from.
struct Row<'a, T: Real, const N: usize, L> {
    lagrangian: &'a L,
    casimirs: &'a [Casimir<T, N>],
    columns: &'a Columns,
    work: &'a Cell<T>,
    /// The energy of the first row.
    energy: Option<T>,
    /// The velocity of the last row, where the next is looked for.
    velocity: Vector<T, N>,
    values: Vec<T>,
    /// Of the steps since the last row.
    residual: T,
    iterations: usize,
}

impl<T: Real, const N: usize, L: Lagrangian<T, N>> Row<'_, T, N, L> {
    fn count(&mut self, report: &Report<T>) {
        self.residual = self.residual.max(report.residual);
        self.iterations += report.iterations;
    }

    fn write<const D: usize>(&mut self, state: &State<T, N, D>, recorder: &mut Recorder) -> Result<(), String> {
        self.velocity = self
            .lagrangian
            .velocity(&state.momentum, &self.velocity)
            .map_err(|error| format!("at t = {}: {error}", state.time))?;
        let energy = self.lagrangian.energy(&self.velocity);
        let (first, work) = (*self.energy.get_or_insert(energy), self.work.get());
        self.values.clear();
        self.values.push(state.time);
        self.values.extend(state.momentum.iter());
        self.values.extend(self.velocity.iter());
        self.values.extend([energy, work, energy - first - work]);
        self.values.extend(self.casimirs.iter().map(|casimir| casimir.value(&state.momentum)));
        for row in 0..self.columns.attitude {
            self.values.extend((0..self.columns.attitude).map(|column| state.attitude[(row, column)]));
        }
        self.values.push(self.residual);
        recorder.row(&self.values, self.iterations);
        (self.residual, self.iterations) = (T::zero(), 0);
        Ok(())
    }
}

impl<T: Real> Visitor<T> for Run<'_, T> {
    type Output = Ended;

    fn visit<const N: usize, const D: usize, R: Retraction<T, N, D>, L: Lagrangian<T, N>, F: Force<T, N>>(
        self,
        system: System<T, N, D, R, L, F>,
    ) -> Ended {
        let Self { file, steps, last, recorder } = self;
        let System { lagrangian, force, retraction, tableau, mut state, step, casimirs, .. } = system;
        let columns = Columns::new(&file.case, casimirs.len());
        let work = Cell::new(T::zero());
        let mut method = Metered { method: Variational::new(&lagrangian, force, retraction, tableau), work: &work };
        let mut row = Row {
            lagrangian: &lagrangian,
            casimirs: &casimirs,
            columns: &columns,
            work: &work,
            energy: None,
            velocity: Vector::zeros(),
            values: Vec::new(),
            residual: T::zero(),
            iterations: 0,
        };
        recorder.header(&columns);
        if let Err(reason) = row.write(&state, recorder) {
            return Ended::Failed(reason);
        }
        let total = steps + u64::from(last.is_some());
        let mut written = 0;
        let mut totals: Vec<Totals<T>> = Vec::with_capacity(2);
        for (first, count, h) in [(0, steps, step), (steps, total - steps, last.unwrap_or(step))] {
            let mut refused = None;
            let outcome = integrate_until(&mut method, &mut state, h, count as usize, |index, state, report| {
                let index = first + index as u64;
                row.count(report);
                if index.is_multiple_of(file.output.every) || index == total {
                    refused = row.write(state, recorder).err();
                    written = index;
                }
                recorder.progress(index, total);
                if refused.is_some() || recorder.failure.is_some() {
                    ControlFlow::Break(())
                } else {
                    ControlFlow::Continue(())
                }
            });
            if let Some(reason) = refused {
                return Ended::Failed(reason);
            }
            match outcome {
                Ok(part) => totals.push(part),
                Err(TrajectoryError { index, time, source }) => {
                    let done = first + index as u64;
                    // The state that was reached is a row, whatever `every` says.
                    if written < done {
                        let _ = row.write(&state, recorder);
                    }
                    return Ended::Failed(format!("step {} of {total}, from t = {time}: {source}", done + 1));
                }
            }
            if recorder.failure.is_some() {
                break;
            }
        }
        Ended::Whole(summary(&totals))
    }
}

fn summary<T: Real>(parts: &[Totals<T>]) -> String {
    let steps: usize = parts.iter().map(|part| part.steps).sum();
    let iterations: usize = parts.iter().map(|part| part.iterations).sum();
    let most = parts.iter().map(|part| part.most_iterations).max().unwrap_or(0);
    let residual = parts.iter().fold(0.0, |most: f64, part| most.max(part.residual.to_f64()));
    let mean = iterations as f64 / steps.max(1) as f64;
    format!("{steps} steps, {mean:.1} iterations each (at most {most}), largest relative residual {residual:.1e}")
}
