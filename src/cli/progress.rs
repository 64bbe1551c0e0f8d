//! A progress bar on stderr: for runs over two seconds, on a terminal.

use euler_poincare::harness::{Progress, Verdict};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

/// Runs shorter than this show none.
const QUIET: Duration = Duration::from_secs(2);

/// Counts checks; their weights are the relative durations from which the time left is estimated.
pub struct Bar {
    bar: ProgressBar,
    start: Instant,
    shown: AtomicBool,
    done: AtomicUsize,
    broken: AtomicUsize,
    checks: usize,
    weights: BTreeMap<&'static str, u64>,
}

impl Bar {
    /// A bar for groups of (name, number of checks, weight of each).
    pub fn new(groups: &[(&'static str, usize, u64)]) -> Self {
        let total = groups.iter().map(|(_, checks, weight)| *checks as u64 * weight).sum();
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        Self {
            bar,
            start: Instant::now(),
            shown: AtomicBool::new(false),
            done: AtomicUsize::new(0),
            broken: AtomicUsize::new(0),
            checks: groups.iter().map(|(_, checks, _)| checks).sum(),
            weights: groups.iter().map(|(name, _, weight)| (*name, *weight)).collect(),
        }
    }

    /// One more check of the group `name` is done.
    pub fn advance(&self, name: &'static str) {
        self.bar.inc(self.weights.get(name).copied().unwrap_or(1));
        let done = self.done.fetch_add(1, Ordering::Relaxed) + 1;
        if !self.is_due() {
            return;
        }
        let rate = done as f64 / self.start.elapsed().as_secs_f64();
        let broken = match self.broken.load(Ordering::Relaxed) {
            0 => String::new(),
            broken => format!(", {broken} broken"),
        };
        self.bar.set_message(format!("{done}/{} checks{broken}, {rate:.0}/s", self.checks));
    }

    /// Whether the bar is shown by now; the first call after two seconds shows it.
    fn is_due(&self) -> bool {
        if self.start.elapsed() < QUIET {
            return false;
        }
        if !self.shown.swap(true, Ordering::Relaxed) {
            self.bar.set_draw_target(ProgressDrawTarget::stderr());
            self.bar.enable_steady_tick(Duration::from_millis(250));
        }
        true
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Progress for Bar {
    fn case(&self, law: &'static str, verdict: &Verdict) {
        if verdict.is_broken() {
            self.broken.fetch_add(1, Ordering::Relaxed);
        }
        self.advance(law);
    }

    fn shrinking(&self, law: &'static str, index: usize) {
        if self.is_due() {
            self.bar.set_message(format!("shrinking case {index} of {law}"));
        }
    }

    fn finish(&self) {
        self.clear();
    }
}
