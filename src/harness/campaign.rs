//! Laws on random cases, in parallel; the same seed gives the same report at any number of threads.

use super::draw::draw;
use super::guard::{guarded, verdict_on};
use super::law::{Cost, Fault, Law, Verdict};
use super::shrink::{Failure, shrink};
use super::summary::{Report, Summary};
use rayon::prelude::*;
use std::fmt::Debug;
use std::ops::Range;
use std::time::Instant;

/// What a campaign tells while it runs. Called from the worker threads, in no particular order.
pub trait Progress: Sync {
    /// Before the first case: how many checks there will be, shrinking apart.
    fn start(&self, _checks: usize) {}
    /// After each case.
    fn case(&self, _law: &'static str, _verdict: &Verdict) {}
    /// A broken case is going to be shrunk.
    fn shrinking(&self, _law: &'static str, _index: usize) {}
    /// After everything.
    fn finish(&self) {}
}

/// Silence.
impl Progress for () {}

type Labels<'a, C> = &'a (dyn Fn(&C) -> Vec<(&'static str, String)> + Sync);

/// A campaign over cases of type `C`: its size, its seed, and what watches it.
///
/// It runs in the rayon pool from which it is called.
pub struct Campaign<'a, C> {
    seed: u64,
    cases: usize,
    failures: usize,
    shrink_checks: usize,
    labels: Labels<'a, C>,
    progress: &'a dyn Progress,
}

impl<'a, C: Clone + Debug + Send + 'static> Campaign<'a, C> {
    /// `cases` cases per cheap law; see [`Cost::cases`] for the expensive ones.
    pub fn new(seed: u64, cases: usize) -> Self {
        Self { seed, cases, failures: 3, shrink_checks: 500, labels: &|_| Vec::new(), progress: &() }
    }

    /// The (category, label) pairs of a case, for the coverage.
    pub fn labels(self, labels: Labels<'a, C>) -> Self {
        Self { labels, ..self }
    }

    /// Who is told what happens.
    pub fn progress(self, progress: &'a dyn Progress) -> Self {
        Self { progress, ..self }
    }

    /// How many of a law's broken cases are shrunk (default 3, those of lowest index), with how many checks each
    /// (default 500). A number of checks, not a time, so that the result does not depend on the machine.
    pub fn shrinking(self, failures: usize, checks: usize) -> Self {
        Self { failures, shrink_checks: checks, ..self }
    }

    /// Runs every law on its cases.
    pub fn run(&self, laws: &[&dyn Law<C>]) -> Report<C> {
        self.progress.start(laws.iter().map(|law| law.cost().cases(self.cases)).sum());
        let blocks = self.blocks(laws);
        let parts: Vec<_> = blocks
            .par_iter()
            .with_max_len(1)
            .map(|(law, range)| (*law, range.start, self.run_block(laws[*law], range.clone())))
            .collect();
        let mut summaries: Vec<_> = laws.iter().map(|law| Summary::new(law.name(), law.cost())).collect();
        // Blocks of one law are in ascending order, whatever the order of the laws.
        for (law, _, part) in parts {
            summaries[law].append(part);
        }
        self.shrink_failures(laws, &mut summaries);
        self.progress.finish();
        Report { seed: self.seed, cases: self.cases, laws: summaries }
    }

    /// The work in pieces, expensive laws first so that no long piece is left for the end. A strategy cannot be shared
    /// between threads: each block builds it once.
    fn blocks(&self, laws: &[&dyn Law<C>]) -> Vec<(usize, Range<usize>)> {
        let mut order: Vec<usize> = (0..laws.len()).collect();
        order.sort_by_key(|law| std::cmp::Reverse(laws[*law].cost()));
        let mut blocks = Vec::new();
        for law in order {
            let cost = laws[law].cost();
            let (cases, size) = (cost.cases(self.cases), if cost == Cost::Cheap { 16 } else { 1 });
            blocks.extend((0..cases).step_by(size).map(|start| (law, start..(start + size).min(cases))));
        }
        blocks
    }

    fn run_block(&self, law: &dyn Law<C>, range: Range<usize>) -> Summary<C> {
        let mut summary = Summary::new(law.name(), law.cost());
        let strategy = law.cases();
        for index in range {
            let drawn = draw(&strategy, self.seed, law.name(), index);
            for (reason, count) in drawn.rejections {
                *summary.rejections.entry(reason).or_default() += count;
            }
            let verdict = match drawn.case {
                Err(why) => Verdict::Inconclusive { why },
                Ok((case, _)) => {
                    let start = Instant::now();
                    let verdict = verdict_on(law, &case, None);
                    summary.seconds += start.elapsed().as_secs_f64();
                    let applicable = !matches!(verdict, Verdict::NotApplicable { .. });
                    let labels = guarded(|| (self.labels)(&case));
                    summary.record_labels(labels.unwrap_or_else(|why| vec![("labels panicked", why)]), applicable);
                    verdict
                }
            };
            summary.record(index, &verdict);
            self.progress.case(law.name(), &verdict);
        }
        summary
    }

    fn shrink_failures(&self, laws: &[&dyn Law<C>], summaries: &mut [Summary<C>]) {
        let broken: Vec<(usize, usize)> = (0..laws.len())
            .flat_map(|law| summaries[law].broken.iter().take(self.failures).map(move |index| (law, *index)))
            .collect();
        let shrunk: Vec<Option<Failure<C>>> = broken
            .par_iter()
            .with_max_len(1)
            .map(|(law, index)| {
                self.progress.shrinking(laws[*law].name(), *index);
                shrink(laws[*law], None, self.seed, *index, self.shrink_checks)
            })
            .collect();
        for ((law, index), failure) in broken.into_iter().zip(shrunk) {
            match failure {
                Some(failure) => summaries[law].failures.push(failure),
                None => summaries[law].irreproducible.push(index),
            }
        }
    }
}

/// After how many cases the law is broken by `fault` planted in its subject; `None` if `max_cases` do not show it.
///
/// The cases are those that a campaign with this seed draws for the law.
pub fn catch_fault<C: Debug>(law: &dyn Law<C>, fault: &Fault, seed: u64, max_cases: usize) -> Option<usize> {
    let strategy = law.cases();
    (0..max_cases)
        .find(|index| {
            let drawn = draw(&strategy, seed, law.name(), *index);
            drawn.case.is_ok_and(|(case, _)| verdict_on(law, &case, Some(fault)).is_broken())
        })
        .map(|index| index + 1)
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
