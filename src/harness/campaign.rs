//! Laws on random cases, in parallel; the same seed gives the same report at any number of threads.

use super::draw::draw;
use super::guard::{guarded, verdict_on};
use super::law::{Cost, Fault, Law, Verdict};
use super::parallel::parallel;
use super::plan::{Done, Queue, Shard};
use super::record::Record;
use super::shrink::shrink_while;
use super::summary::{CampaignReport, Ending, Summary};
use proptest::strategy::BoxedStrategy;
use std::fmt::Debug;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Instant;

/// What a campaign tells while it runs. Called from the worker threads, in no particular order.
pub trait Progress: Sync {
    /// After each case.
    fn case(&self, _law: &'static str, _verdict: &Verdict) {}
    /// A broken case is going to be shrunk.
    fn shrinking(&self, _law: &'static str, _index: usize) {}
    /// After everything.
    fn finish(&self) {}
}

/// Nothing is told to anybody.
impl Progress for () {}

/// Whether a campaign may go on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Halt {
    /// It may.
    No,
    /// No further case is begun; those that are begun are finished, and what broke is shrunk.
    Cases,
    /// Neither cases nor shrinking: checks that are begun are finished, and that is all.
    All,
}

/// Who keeps what a campaign finds, case by case. Called from the worker threads, in no particular order.
pub trait Sink: Sync {
    /// A case was judged, in `seconds`; `None` where the strategy gave no case. False: nothing can be kept any
    /// more, the campaign shall end as with [`Halt::All`].
    fn record(&self, record: &Record, seconds: Option<f64>) -> bool;
}

/// What an earlier part of the same campaign has found: where a resumed one begins.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Recorded<C> {
    /// Of each law, the cases that were judged.
    pub done: Vec<Done>,
    /// Of each law, what they have shown, without failures.
    pub laws: Vec<Summary<C>>,
}

impl<C> Recorded<C> {
    /// Nothing yet.
    pub fn none(laws: &[&dyn Law<C>], shard: Shard) -> Self {
        Self {
            done: laws.iter().map(|_| Done::new(shard)).collect(),
            laws: laws.iter().map(|law| Summary::new(law.name())).collect(),
        }
    }
}

type Labels<'a, C> = &'a (dyn Fn(&C) -> Vec<(&'static str, String)> + Sync);
type Halts<'a> = &'a (dyn Fn() -> Halt + Sync);

/// A campaign over cases of type `C`: its size, its seed, and what watches it.
///
/// It runs in the rayon pool from which it is called, on all of its threads.
///
/// ```
/// use euler_poincare::harness::{About, BoxedStrategy, Campaign, Cost, Fault, Law, Verdict, catch_fault};
/// use proptest::strategy::Strategy;
///
/// /// √x² = x.
/// struct Root;
///
/// const SINGLE: Fault = Fault::new("single", "the root in single precision", "every number");
///
/// impl Law<f64> for Root {
///     fn about(&self) -> &About {
///         &About {
///             name: "root-square",
///             statement: "√(x²) = x for x ≥ 0",
///             source: "IEEE 754",
///             oracle: "x itself",
///             bound: "two roundings",
///             needs: "",
///             cost: Cost::Cheap,
///             faults: &[SINGLE],
///         }
///     }
///     fn cases(&self) -> BoxedStrategy<f64> {
///         (1.0..100.0).boxed()
///     }
///     fn check(&self, x: &f64, fault: Option<&Fault>) -> Verdict {
///         let right = (x * x).sqrt();
///         let root = if Fault::planted(fault, "single") { f64::from(right as f32) } else { right };
///         Verdict::judge((root - x).abs() / x, f64::EPSILON, || format!("x = {x}"))
///     }
/// }
///
/// let report = Campaign::new(7, 100).run(&[&Root as &dyn Law<f64>]);
/// let summary = &report.laws[0];
/// assert!(report.holds() && summary.held == 100 && summary.failures.is_empty());
/// assert!(summary.worst.as_ref().expect("judged cases").ratio() <= 1.0);
///
/// // The law is able to fail.
/// assert_eq!(catch_fault(&Root, &SINGLE, 7, 100), Some(1));
/// ```
pub struct Campaign<'a, C> {
    seed: u64,
    cases: Option<usize>,
    share: fn(Cost, usize) -> usize,
    shard: Shard,
    failures: usize,
    shrink_checks: usize,
    labels: Labels<'a, C>,
    progress: &'a dyn Progress,
    sink: Option<&'a dyn Sink>,
    halt: Halts<'a>,
}

impl<'a, C: Clone + Debug + Send + 'static> Campaign<'a, C> {
    /// `cases` cases per cheap law; see [`Cost::cases`] for the expensive ones.
    pub fn new(seed: u64, cases: usize) -> Self {
        Self { cases: Some(cases), ..Self::until(seed, &|| Halt::No) }
    }

    /// Case after case until `halt` says that it is enough: it is asked before each of them.
    pub fn until(seed: u64, halt: &'a (dyn Fn() -> Halt + Sync)) -> Self {
        Self {
            seed,
            cases: None,
            share: Cost::cases,
            shard: Shard::WHOLE,
            failures: 3,
            shrink_checks: 500,
            labels: &|_| Vec::new(),
            progress: &(),
            sink: None,
            halt,
        }
    }

    /// The (category, label) pairs of a case, for the coverage. A `+` in a label divides it.
    pub fn labels(self, labels: &'a (dyn Fn(&C) -> Vec<(&'static str, String)> + Sync)) -> Self {
        Self { labels, ..self }
    }

    /// Who is told what happens.
    pub fn progress(self, progress: &'a dyn Progress) -> Self {
        Self { progress, ..self }
    }

    /// Who keeps the records.
    pub fn sink(self, sink: &'a dyn Sink) -> Self {
        Self { sink: Some(sink), ..self }
    }

    /// Asked before each case, and before each check of the shrinking.
    pub fn halt(self, halt: &'a (dyn Fn() -> Halt + Sync)) -> Self {
        Self { halt, ..self }
    }

    /// How many cases a law of a cost gets where a cheap one gets so many (default [`Cost::cases`]).
    pub fn share(self, share: fn(Cost, usize) -> usize) -> Self {
        Self { share, ..self }
    }

    /// Only the cases of this shard.
    pub fn shard(self, shard: Shard) -> Self {
        Self { shard, ..self }
    }

    /// How many of a law's broken cases are shrunk (default 3, those of lowest index), with how many checks each
    /// (default 500). A number of checks, not a time, so that the result does not depend on the machine.
    pub fn shrinking(self, failures: usize, checks: usize) -> Self {
        Self { failures, shrink_checks: checks, ..self }
    }

    /// Runs every law on its cases.
    pub fn run(&self, laws: &[&dyn Law<C>]) -> CampaignReport<C> {
        self.resume(laws, Recorded::none(laws, self.shard))
    }

    /// Runs every law on those of its cases that are not recorded, and reports on all: the report is that of a campaign
    /// that was never interrupted. `recorded` has an entry for each law; its shard is that of the campaign.
    pub fn resume(&self, laws: &[&dyn Law<C>], recorded: Recorded<C>) -> CampaignReport<C> {
        let Recorded { done, laws: mut summaries } = recorded;
        let costs = laws.iter().map(|law| law.about().cost);
        let planned = costs.map(|cost| (cost, self.cases.map(|cases| (self.share)(cost, cases))));
        let queue = Queue::new(planned, self.shard, done);
        let (halted, lost) = (AtomicBool::new(false), AtomicBool::new(false));
        let run = Run { campaign: self, laws, queue: Mutex::new(queue), halted, lost };
        for found in rayon::broadcast(|_| run.work()) {
            for (summary, found) in summaries.iter_mut().zip(found) {
                summary.append(found);
            }
        }
        let lost = run.lost.into_inner();
        let go_on = || !lost && (self.halt)() != Halt::All;
        self.shrink_failures(laws, &mut summaries, &go_on);
        let ending = match run.halted.into_inner() {
            _ if !go_on() => Ending::Interrupted,
            true => Ending::Stopped,
            false => Ending::Complete,
        };
        self.progress.finish();
        CampaignReport { seed: self.seed, cases: self.cases, ending, laws: summaries }
    }

    fn shrink_failures(&self, laws: &[&dyn Law<C>], summaries: &mut [Summary<C>], go_on: &(dyn Fn() -> bool + Sync)) {
        let broken: Vec<(usize, usize)> = (0..laws.len().min(summaries.len()))
            .flat_map(|law| summaries[law].broken.iter().take(self.failures).map(move |index| (law, *index)))
            .collect();
        let shrunk = parallel(broken.len(), |k| {
            let (law, index) = (laws[broken[k].0], broken[k].1);
            self.progress.shrinking(law.name(), index);
            shrink_while(law, None, self.seed, index, self.shrink_checks, go_on)
        });
        for ((law, index), failure) in broken.into_iter().zip(shrunk) {
            match failure {
                Some(failure) => summaries[law].failures.push(failure),
                None => summaries[law].irreproducible.push(index),
            }
        }
    }
}

/// A campaign under way, shared by its threads.
struct Run<'a, C> {
    campaign: &'a Campaign<'a, C>,
    laws: &'a [&'a dyn Law<C>],
    queue: Mutex<Queue>,
    /// Whether a case was left out.
    halted: AtomicBool,
    /// Whether a record was.
    lost: AtomicBool,
}

impl<C: Clone + Debug + Send + 'static> Run<'_, C> {
    /// Case after case, until none is left or it is told to stop; what this thread has found, by law.
    fn work(&self) -> Vec<Summary<C>> {
        let mut summaries: Vec<_> = self.laws.iter().map(|law| Summary::new(law.name())).collect();
        // A strategy cannot be shared between threads: each builds it once.
        let mut strategies: Vec<Option<BoxedStrategy<C>>> = self.laws.iter().map(|_| None).collect();
        while let Some((law, indices)) = self.next() {
            let strategy = strategies[law].get_or_insert_with(|| self.laws[law].cases());
            for index in indices {
                if self.halted() {
                    return summaries;
                }
                self.case(law, index, strategy, &mut summaries[law]);
            }
        }
        summaries
    }

    fn next(&self) -> Option<(usize, Vec<usize>)> {
        // Nothing that is done under the lock panics.
        self.queue.lock().unwrap_or_else(PoisonError::into_inner).next()
    }

    fn halted(&self) -> bool {
        if self.lost.load(Ordering::Relaxed) || (self.campaign.halt)() != Halt::No {
            self.halted.store(true, Ordering::Relaxed);
        }
        self.halted.load(Ordering::Relaxed)
    }

    /// One case: drawn, judged, recorded.
    fn case(&self, law: usize, index: usize, strategy: &BoxedStrategy<C>, summary: &mut Summary<C>) {
        let Campaign { seed, labels, progress, sink, .. } = *self.campaign;
        let law = self.laws[law];
        let drawn = draw(strategy, seed, law.name(), index);
        let (verdict, labels, seconds) = match drawn.case {
            Err(why) => (Verdict::Inconclusive { why }, Vec::new(), None),
            Ok((case, _)) => {
                let start = Instant::now();
                let verdict = verdict_on(law, &case, None);
                let seconds = start.elapsed().as_secs_f64();
                let labels = guarded(|| labels(&case)).unwrap_or_else(|why| vec![("labels panicked", why)]);
                (verdict, labels, Some(seconds))
            }
        };
        let record = Record::new(law.name(), index, verdict, labels, drawn.rejections);
        if !sink.is_none_or(|sink| sink.record(&record, seconds)) {
            self.lost.store(true, Ordering::Relaxed);
        }
        summary.record(&record, seconds.unwrap_or(0.0));
        progress.case(law.name(), &record.verdict);
    }
}

/// After how many cases the law is broken by `fault` planted in its subject; `None` if `max_cases` do not show it.
///
/// The cases are those that a campaign with this seed draws for the law.
pub fn catch_fault<C: Debug>(law: &dyn Law<C>, fault: &Fault, seed: u64, max_cases: usize) -> Option<usize> {
    first_caught(law, fault, seed, max_cases).map(|(index, _)| index + 1)
}

/// The index of that case, and the verdict on it.
pub fn first_caught<C: Debug>(
    law: &dyn Law<C>,
    fault: &Fault,
    seed: u64,
    max_cases: usize,
) -> Option<(usize, Verdict)> {
    let strategy = law.cases();
    (0..max_cases).find_map(|index| {
        let (case, _) = draw(&strategy, seed, law.name(), index).case.ok()?;
        Some((index, verdict_on(law, &case, Some(fault)))).filter(|(_, verdict)| verdict.is_broken())
    })
}

/// The largest k ≤ 16 for which the fault of size 10⁻ᵏ is still caught within `max_cases`, by bisection; `None` if the
/// whole fault is not.
pub fn catch_smallest<C: Debug>(law: &dyn Law<C>, fault: &Fault, seed: u64, max_cases: usize) -> Option<u32> {
    let caught = |k: u32| catch_fault(law, &fault.with_size(10f64.powi(-(k as i32))), seed, max_cases).is_some();
    if !caught(0) {
        return None;
    }
    let (mut caught_at, mut missed_at) = (0, 17);
    while missed_at - caught_at > 1 {
        let k = (caught_at + missed_at) / 2;
        if caught(k) { caught_at = k } else { missed_at = k }
    }
    Some(caught_at)
}
