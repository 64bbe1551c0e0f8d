//! A progress bar on stderr: for runs over two seconds, on a terminal.

use super::interrupt::Interrupt;
use euler_poincare::harness::{Cost, Progress, Verdict};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Runs shorter than this show none.
const QUIET: Duration = Duration::from_secs(2);

/// How often a run under way is looked at.
const TICK: Duration = Duration::from_millis(100);

/// The length of a bar whose checks are not counted beforehand.
const BY_TIME: u64 = 1_000_000;

/// Counts checks; their weights are the relative durations from which the time left is estimated.
pub struct Bar {
    counts: Arc<Counts>,
    weights: BTreeMap<&'static str, u64>,
}

struct Counts {
    bar: ProgressBar,
    start: Instant,
    /// Sum of the weights of all checks.
    total: u64,
    /// How many checks there are; `None` where that depends on the time.
    checks: Option<usize>,
    /// When no further check is begun.
    limit: Option<Duration>,
    interrupt: Option<Interrupt>,
    /// Sum of the weights of the checks that are done.
    weight: AtomicU64,
    done: AtomicUsize,
    broken: AtomicUsize,
    state: Mutex<State>,
}

#[derive(Default)]
struct State {
    finished: bool,
    /// What is going on when no checks are counted.
    activity: Option<String>,
}

impl Bar {
    /// A bar for groups of (name, number of checks if it is known, weight of each) that may end before, at a time limit
    /// or by an interrupt; the latter is acknowledged.
    pub fn new(
        groups: &[(&'static str, Option<usize>, u64)],
        limit: Option<Duration>,
        interrupt: Option<Interrupt>,
    ) -> Self {
        let checks = groups.iter().map(|(_, checks, _)| *checks).sum::<Option<usize>>();
        let weight = groups.iter().map(|(_, checks, weight)| Some((*checks)? as u64 * weight)).sum::<Option<u64>>();
        let total = weight.unwrap_or(BY_TIME);
        let bar = ProgressBar::with_draw_target(Some(total), ProgressDrawTarget::hidden());
        let style = ProgressStyle::with_template("{bar:32} {percent:>3} %  {msg}, {eta} left");
        bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
        let counts = Arc::new(Counts {
            bar,
            start: Instant::now(),
            total,
            checks,
            limit,
            interrupt,
            weight: AtomicU64::new(0),
            done: AtomicUsize::new(0),
            broken: AtomicUsize::new(0),
            state: Mutex::default(),
        });
        let watched = Arc::clone(&counts);
        // Without this thread there is no bar, that is all.
        let _ = thread::Builder::new().spawn(move || watched.watch());
        Self { counts, weights: groups.iter().map(|(name, _, weight)| (*name, *weight)).collect() }
    }

    /// One more check of the group `name` is done.
    pub fn advance(&self, name: &'static str) {
        let weight = self.weights.get(name).copied().unwrap_or(1);
        self.counts.weight.fetch_add(weight, Ordering::Relaxed);
        self.counts.done.fetch_add(1, Ordering::Relaxed);
    }

    /// Removes the bar.
    pub fn clear(&self) {
        self.counts.state().finished = true;
        self.counts.bar.finish_and_clear();
    }
}

impl Drop for Bar {
    fn drop(&mut self) {
        self.clear();
    }
}

impl Counts {
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Draws, and acknowledges an interrupt, until the bar is cleared.
    fn watch(&self) {
        let (mut shown, mut acknowledged) = (false, false);
        loop {
            thread::sleep(TICK);
            let state = self.state();
            if state.finished {
                return;
            }
            if !acknowledged && self.interrupt.as_ref().is_some_and(Interrupt::is_set) {
                acknowledged = true;
                self.bar.suspend(|| {
                    eprintln!(
                        "interrupted: the checks under way are finished first; Ctrl-C again ends the process at once"
                    )
                });
            }
            if !shown && self.start.elapsed() >= QUIET {
                shown = true;
                // Draws on a terminal only.
                self.bar.set_draw_target(ProgressDrawTarget::stderr());
            }
            if shown {
                self.bar.set_message(state.activity.clone().unwrap_or_else(|| self.message()));
                self.bar.set_position(self.position());
            }
        }
    }

    /// By work, or by time where that is up earlier.
    fn position(&self) -> u64 {
        let work = if self.checks.is_some() { self.weight.load(Ordering::Relaxed) } else { 0 };
        let share = self.limit.map_or(0.0, |limit| self.start.elapsed().as_secs_f64() / limit.as_secs_f64());
        work.max((share * self.total as f64) as u64).min(self.total)
    }

    fn message(&self) -> String {
        let done = self.done.load(Ordering::Relaxed);
        let rate = done as f64 / self.start.elapsed().as_secs_f64();
        let of = self.checks.map(|checks| format!("/{checks}")).unwrap_or_default();
        let broken = match self.broken.load(Ordering::Relaxed) {
            0 => String::new(),
            broken => format!(", {broken} broken"),
        };
        let digits = usize::from(rate < 9.95);
        format!("{done}{of} checks{broken}, {rate:.digits$}/s")
    }
}

impl Progress for Bar {
    fn case(&self, law: &'static str, verdict: &Verdict) {
        if verdict.is_broken() {
            self.counts.broken.fetch_add(1, Ordering::Relaxed);
        }
        self.advance(law);
    }

    fn shrinking(&self, law: &'static str, index: usize) {
        self.counts.state().activity = Some(format!("shrinking case {index} of {law}"));
    }

    fn finish(&self) {
        self.clear();
    }
}

/// How many cheap checks an expensive one is worth to the progress bar.
pub fn weight(cost: Cost) -> u64 {
    match cost {
        Cost::Cheap => 1,
        Cost::Moderate => 20,
        Cost::Expensive => 50,
        Cost::Heavy => 1000,
    }
}
