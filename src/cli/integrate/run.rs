//! What a run writes: rows and progress. Its memory does not grow with the number of steps.

use super::columns::{Columns, print};
use super::plot::Trace;
use crate::cli::interrupt::Interrupt;
use euler_poincare::scalar::Real;
use euler_poincare::system::trajectory::{Observer, Row, Totals};
use indicatif::{ProgressBar, ProgressStyle};
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
    interrupt: Interrupt,
    /// The step before which the run was interrupted, and how many there are.
    stopped: Option<(u64, u64)>,
}

impl Recorder {
    /// A recorder of rows to `out`, that keeps a trace for a figure, and shows progress on stderr, if asked to; an interrupt ends
    /// the run after the step under way.
    pub fn new(out: BufWriter<Box<dyn Write>>, wants_trace: bool, shows_progress: bool, interrupt: Interrupt) -> Self {
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
            interrupt,
            stopped: None,
        }
    }

    /// Steps done, of how many, where the run was interrupted before its end.
    pub fn interrupted(&self) -> Option<(u64, u64)> {
        self.stopped
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

    /// Starts a file with these columns.
    pub fn header(&mut self, columns: &Columns) {
        self.line.push_str(&columns.header());
        self.write_line();
        self.trace = self.wants_trace.then(|| Trace::new(columns.clone()));
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

impl<T: Real> Observer<T> for Recorder {
    fn row(&mut self, row: &Row<'_, T>) {
        for value in row.values.iter().chain([&row.residual]) {
            print(&mut self.line, *value);
            self.line.push(',');
        }
        self.line.push_str(&row.iterations.to_string());
        self.write_line();
        self.rows += 1;
        if let Some(trace) = &mut self.trace {
            trace.add(row.values);
        }
    }

    fn step(&mut self, done: u64, total: u64) -> ControlFlow<()> {
        self.progress(done, total);
        if self.interrupt.is_set() && done < total {
            self.stopped = Some((done, total));
        }
        if self.failure.is_some() || self.stopped.is_some() {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    }
}

/// What a run cost.
pub fn summary<T: Real>(parts: &[Totals<T>]) -> String {
    let steps: usize = parts.iter().map(|part| part.steps).sum();
    let iterations: usize = parts.iter().map(|part| part.iterations).sum();
    let most = parts.iter().map(|part| part.most_iterations).max().unwrap_or(0);
    let residual = parts.iter().fold(0.0, |most: f64, part| most.max(part.residual.to_f64()));
    let mean = iterations as f64 / steps.max(1) as f64;
    format!("{steps} steps, {mean:.1} iterations each (at most {most}), largest relative residual {residual:.1e}")
}
