//! What a run writes: rows and progress. Its memory does not grow with the number of steps.

use super::balance::Balance;
use super::columns::{Columns, print};
use super::plot::Trace;
use super::rows::Rows;
use crate::cli::Failure;
use crate::cli::interrupt::Interrupt;
use crate::cli::summary::count;
use crate::cli::table::{Column, Table};
use euler_poincare::file::Output;
use euler_poincare::scalar::Real;
use euler_poincare::system::tolerance::{Adaptive, EventFormula};
use euler_poincare::system::trajectory::{End, Ended, Observer, Row, Statistics, Totals};
use indicatif::{ProgressBar, ProgressStyle};
use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

/// A run shorter than this shows no progress.
const PATIENCE: Duration = Duration::from_secs(2);

/// Rows are in the file after so long, however the process ends.
const UNWRITTEN: Duration = Duration::from_secs(1);

/// The parts of a run with a tolerance that its progress bar counts.
const PARTS: u64 = 1000;

/// The most events that the report lists.
const MOST_EVENTS: usize = 20;

/// A bar on standard error, for a run that takes a while.
pub struct Bar {
    started: Instant,
    shown: bool,
    bar: Option<ProgressBar>,
}

impl Bar {
    /// Nothing is done yet; it stays hidden unless it is `shown`.
    pub fn new(shown: bool) -> Self {
        Self { started: Instant::now(), shown, bar: None }
    }

    /// How long ago the run began.
    pub fn elapsed(&self) -> Duration {
        self.started.elapsed()
    }

    /// So much of `total` is done.
    pub fn set(&mut self, done: u64, total: u64, template: &str) {
        if !self.shown {
            return;
        }
        if let Some(bar) = &self.bar {
            bar.set_position(done);
        } else if self.elapsed() > PATIENCE {
            let bar = ProgressBar::new(total).with_elapsed(self.elapsed());
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style);
            }
            bar.set_position(done);
            self.bar = Some(bar);
        }
    }

    /// Removes it.
    pub fn clear(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// The events of a run.
#[derive(Default)]
pub struct Events {
    /// Their names.
    names: Vec<String>,
    /// Where the table goes.
    out: Option<Rows>,
    /// The first: time, direction and name.
    first: Vec<[String; 3]>,
    count: usize,
}

impl Events {
    /// Events of these names; their table, with these columns, goes to `out`.
    pub fn new(names: Vec<String>, out: Option<Output>, columns: &Columns) -> Self {
        let mut out = out.map(Rows::new);
        out.iter_mut().for_each(|out| out.header(&columns.events()));
        Self { names, out, ..Self::default() }
    }

    /// The table on a terminal; empty where there are no events.
    pub fn text(&self) -> String {
        if self.names.is_empty() {
            return String::new();
        }
        if self.count == 0 {
            return "no events\n".into();
        }
        let mut table = Table::new(&[Column::name("t"), Column::name("direction"), Column::text("event")]);
        self.first.iter().for_each(|row| table.row(row.iter().map(String::as_str)));
        let more = self.count - self.first.len();
        let more = if more > 0 { format!("and {more} more\n") } else { String::new() };
        format!("{}\n{more}", table.text())
    }

    /// Puts the table in its place, if there is one.
    pub fn finish(self, path: &Path) -> Result<(), Failure> {
        self.out.map_or(Ok(()), |out| out.finish(Some(path)).map(drop))
    }
}

/// Where rows go.
pub struct Recorder {
    out: Rows,
    written: Instant,
    /// The events of the run.
    pub events: Events,
    /// Rows written.
    pub rows: u64,
    trace: Option<Trace>,
    /// How many steps there are, where that is known.
    total: Option<u64>,
    bar: Bar,
    interrupt: Interrupt,
    /// The steps after which the run was interrupted before its end.
    pub stopped: Option<String>,
    /// The balance of the rows.
    pub balance: Balance,
}

impl Recorder {
    /// A recorder of rows with these columns to `out`, of `total` steps if that is known, that keeps a trace for a figure, and shows progress
    /// on stderr, if asked to; an interrupt ends the run after the step under way.
    pub fn new(
        mut out: Rows,
        (columns, wants_trace): (&Columns, bool),
        (total, shows_progress): (Option<u64>, bool),
        interrupt: Interrupt,
    ) -> Self {
        out.header(&columns.header());
        Self {
            out,
            written: Instant::now(),
            events: Events::default(),
            rows: 0,
            trace: wants_trace.then(|| Trace::new(columns.clone())),
            total,
            bar: Bar::new(shows_progress),
            interrupt,
            stopped: None,
            balance: Balance::new(columns.clone()),
        }
    }

    /// Puts the rows in their place, a file or the standard output; the trace, if one was asked for and the reader is still there.
    pub fn finish(mut self, path: Option<&Path>) -> Result<Option<Trace>, Failure> {
        self.bar.clear();
        let read = self.out.finish(path)?;
        Ok(self.trace.filter(|_| read))
    }

    fn flush(&mut self) {
        self.written = Instant::now();
        self.out.flush();
        self.events.out.iter_mut().for_each(Rows::flush);
    }
}

impl<T: Real> Observer<T> for Recorder {
    fn row(&mut self, row: &Row<'_, T>) {
        for value in row.values.iter().chain([&row.residual]) {
            self.out.number(*value);
        }
        self.out.text(&row.iterations.to_string());
        self.out.end();
        self.rows += 1;
        self.balance.add(row.values);
        if let Some(trace) = &mut self.trace {
            trace.add(row.values);
        }
    }

    fn step(&mut self, steps: u64, share: f64) -> ControlFlow<()> {
        match self.total {
            None => {
                self.bar.set((share * PARTS as f64) as u64, PARTS, "{bar:40} {percent} % of the horizon, {eta} left")
            }
            Some(total) if steps.is_multiple_of(32) => {
                self.bar.set(steps, total, "{bar:40} {human_pos}/{human_len} steps, {eta} left");
            }
            Some(_) => {}
        }
        if self.written.elapsed() > UNWRITTEN {
            self.flush();
        }
        if self.interrupt.is_set() && share < 1.0 {
            let of = |total| format!("{steps} of {total} steps");
            self.stopped = Some(self.total.map_or_else(|| count(steps, "step"), of));
        }
        match self.out.failed() || self.events.out.as_ref().is_some_and(Rows::failed) || self.stopped.is_some() {
            true => ControlFlow::Break(()),
            false => ControlFlow::Continue(()),
        }
    }

    fn event(&mut self, index: usize, rising: bool, row: &Row<'_, T>) {
        let name = self.events.names.get(index).cloned().unwrap_or_default();
        let direction = if rising { "rising" } else { "falling" };
        if let Some(out) = &mut self.events.out {
            [&name, direction].into_iter().for_each(|text| out.text(text));
            row.values.iter().for_each(|value| out.number(*value));
            out.end();
        }
        self.events.count += 1;
        if let (true, Some(time)) = (self.events.first.len() < MOST_EVENTS, row.values.first()) {
            let mut text = String::new();
            print(&mut text, *time);
            self.events.first.push([text, direction.into(), name]);
        }
    }
}

/// What a run took: its steps, or the tolerance, and where it ended.
pub fn cost<T: Real>(ended: &Ended<T>, adaptive: Option<&Adaptive>) -> String {
    if let Some(Totals { steps, iterations, most_iterations: most, residual }) = ended.totals {
        let (mean, residual) = (iterations as f64 / steps.max(1) as f64, residual.to_f64());
        let steps = count(steps, "step");
        return format!(
            "{steps}, {mean:.1} iterations each (at most {most}), largest relative residual {residual:.1e}"
        );
    }
    let (Some(adaptive), Some(statistics)) = (adaptive, &ended.statistics) else { return String::new() };
    let Statistics { steps, rejected, iterations, error, .. } = statistics;
    let (error, tolerance) = (error.to_f64(), &adaptive.tolerance);
    let kept = match error > tolerance.eval::<f64>().unwrap_or(0.0) {
        true => format!(
            "more than the tolerance {tolerance}, as rounding over many steps, or a force that jumps often, makes more"
        ),
        false => format!("tolerance {tolerance}"),
    };
    let event = match ended.end {
        End::Event(index) => format!(" by the event {:?}", adaptive.events.get(index).map_or("", EventFormula::name)),
        _ => String::new(),
    };
    let (steps, refused, iterations) =
        (count(*steps, "step"), count(*rejected, "pair"), count(*iterations, "iteration"));
    let time = ended.time;
    format!(
        "ended at t = {time}{event}: {steps}, {refused} refused, {iterations}, errors of all steps {error:.1e} ({kept})"
    )
}
