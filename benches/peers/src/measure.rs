//! Errors, once; then times, of everything in turn, again and again.

use crate::contender::{Contender, Kind};
use crate::problem::Problem;
use crate::report::seconds;
use serde::Serialize;
use std::hint::black_box;
use std::time::{Duration, Instant};

/// How much to measure.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The tolerances every contender is run with.
    pub tolerances: Vec<f64>,
    /// The longest intervals worth the time.
    pub longest_end: f64,
    /// The shortest time that the clock is trusted with.
    pub sample: Duration,
    /// For the samples of one problem in all.
    pub budget: Duration,
    /// A solve that takes longer is not timed.
    pub longest_solve: Duration,
}

impl Plan {
    /// For figures that are meant to be shown.
    pub fn full() -> Self {
        Self {
            tolerances: ladder(),
            longest_end: f64::INFINITY,
            sample: Duration::from_micros(250),
            budget: Duration::from_secs(10),
            longest_solve: Duration::from_millis(400),
        }
    }

    /// To see that everything works: a second or two, ten in the profile `quick`.
    pub fn quick() -> Self {
        Self {
            tolerances: vec![1e-8, 1e-10, 1e-12],
            longest_end: 1.0,
            sample: Duration::from_micros(5),
            budget: Duration::from_millis(120),
            longest_solve: Duration::from_millis(400), // so long because nothing need be optimised for it
        }
    }
}

/// 1e-2, 3e-3, 1e-3 … 1e-14.
fn ladder() -> Vec<f64> {
    let spelt = (3..=14).flat_map(|k| [format!("3e-{k}"), format!("1e-{k}")]);
    std::iter::once("1e-2".into()).chain(spelt).filter_map(|text: String| text.parse().ok()).collect()
}

/// The time of a solve.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Time {
    /// The median of the samples, in seconds.
    pub median: f64,
    /// The least of the samples, in seconds.
    pub least: f64,
    /// How many samples.
    pub samples: usize,
    /// Solves in a sample.
    pub batch: usize,
}

/// A contender at a tolerance.
#[derive(Clone, Debug, Serialize)]
pub struct Run {
    /// The contender's name.
    pub contender: String,
    /// Its sort.
    pub kind: Kind,
    /// What it was told.
    pub tolerance: f64,
    /// The largest error of a component at T.
    pub error: Option<f64>,
    /// Steps.
    pub steps: Option<usize>,
    /// Time of a solve; none if it failed or takes too long.
    pub time: Option<Time>,
    /// Why there is no answer, or no time.
    pub note: Option<String>,
}

impl Run {
    /// Before anything is known.
    fn none(contender: &dyn Contender, tolerance: f64) -> Self {
        Self {
            contender: contender.name().into(),
            kind: contender.kind(),
            tolerance,
            error: None,
            steps: None,
            time: None,
            note: None,
        }
    }
}

/// A run that is being measured.
struct Entry {
    contender: usize,
    run: Run,
    batch: usize,
    /// It takes part in every so-manieth round.
    period: usize,
    samples: Vec<f64>,
}

/// Seconds of one solve, of `batch` in a row.
fn sample(contender: &mut dyn Contender, problem: &Problem, tolerance: f64, batch: usize) -> f64 {
    let start = Instant::now();
    for _ in 0..batch {
        let answer = contender.solve(black_box(problem), black_box(tolerance));
        let _ = black_box(answer);
    }
    start.elapsed().as_secs_f64() / batch as f64
}

/// One answer, its error, and roughly the time it takes.
fn first(contender: &mut dyn Contender, problem: &Problem, tolerance: f64, plan: &Plan) -> (Run, f64) {
    let mut run = Run::none(contender, tolerance);
    let start = Instant::now();
    match contender.solve(problem, tolerance) {
        Ok(answer) => {
            let error = problem.error(&answer.state);
            run.error = error.is_finite().then_some(error);
            run.steps = Some(answer.steps);
            run.note = (!error.is_finite()).then(|| "the answer is not finite".into());
        }
        Err(why) => run.note = Some(why),
    }
    let once = start.elapsed().as_secs_f64();
    if run.note.is_none() && once > plan.longest_solve.as_secs_f64() {
        run.note = Some(format!("not timed: a solve takes {}", seconds(once)));
    }
    if run.note.is_some() {
        return (run, once);
    }
    let again = |contender: &mut dyn Contender, batch| sample(contender, problem, tolerance, batch);
    let cost = if once < 1e-3 { again(contender, 1).min(again(contender, 4)) } else { again(contender, 1) };
    (run, cost)
}

/// Measures every contender with every tolerance on one problem.
///
/// In each round everything takes one sample, one after the other, so that whatever slows the machine down for a while
/// slows everything down alike. What takes long takes part in some of the rounds only.
pub fn measure(contenders: &mut [Box<dyn Contender>], problem: &Problem, plan: &Plan) -> Vec<Run> {
    let mut entries = Vec::new();
    for (index, contender) in contenders.iter_mut().enumerate().filter(|(_, contender)| contender.takes(problem)) {
        contender.prepare(problem, &plan.tolerances);
        let mut slow = None;
        for &tolerance in &plan.tolerances {
            if let Some(slow) = slow {
                let note = format!("not run: {} at a looser tolerance", seconds(slow));
                let run = Run { note: Some(note), ..Run::none(contender.as_ref(), tolerance) };
                entries.push((Entry { contender: index, run, batch: 1, period: 0, samples: Vec::new() }, 0.0));
                continue;
            }
            let (run, cost) = first(contender.as_mut(), problem, tolerance, plan);
            slow = (cost > plan.longest_solve.as_secs_f64()).then_some(cost);
            let batch = (plan.sample.as_secs_f64() / cost).ceil().max(1.0) as usize;
            entries.push((Entry { contender: index, run, batch, period: 0, samples: Vec::new() }, cost));
        }
    }
    let timed = entries.iter().filter(|(e, _)| e.run.note.is_none()).count().max(1);
    // So that the slowest take some fifty samples and no contender takes more than its part of the time.
    let share = plan.budget.as_secs_f64() / (50 * timed) as f64;
    let mut entries: Vec<Entry> = entries
        .into_iter()
        .map(|(entry, cost)| Entry { period: (cost * entry.batch as f64 / share).ceil().max(1.0) as usize, ..entry })
        .collect();
    let start = Instant::now();
    let mut round = 0;
    while round == 0 || start.elapsed() < plan.budget {
        for (index, entry) in entries.iter_mut().enumerate() {
            if entry.run.note.is_some() || (round > 0 && (round + index) % entry.period != 0) {
                continue;
            }
            let contender = contenders[entry.contender].as_mut();
            if entry.batch > 1 {
                // What another contender left in the caches and the predictors is not this one's to pay for.
                sample(contender, problem, entry.run.tolerance, 1);
            }
            entry.samples.push(sample(contender, problem, entry.run.tolerance, entry.batch));
        }
        round += 1;
    }
    entries.into_iter().map(Entry::finish).collect()
}

impl Entry {
    fn finish(mut self) -> Run {
        self.samples.sort_by(f64::total_cmp);
        if let (Some(&least), n @ 1..) = (self.samples.first(), self.samples.len()) {
            let median = 0.5 * (self.samples[(n - 1) / 2] + self.samples[n / 2]);
            self.run.time = Some(Time { median, least, samples: n, batch: self.batch });
        }
        self.run
    }
}
