//! What a campaign found.

use super::law::Verdict;
use super::record::Record;
use super::shrink::Failure;
use serde::Serialize;
use std::collections::BTreeMap;
use std::ops::AddAssign;

/// The case with the largest defect/bound of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Worst {
    /// Its defect.
    pub defect: f64,
    /// Its bound.
    pub bound: f64,
    /// Its index.
    pub index: usize,
}

impl Worst {
    /// defect/bound, as [`Verdict::ratio`].
    pub fn ratio(&self) -> f64 {
        Verdict::Holds { defect: self.defect, bound: self.bound }.ratio().unwrap_or(f64::INFINITY)
    }
}

/// How many cases carry a label.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct Count {
    /// Of those that were judged: the law held or was broken.
    pub judged: usize,
    /// Of those to which the law applies.
    pub applicable: usize,
    /// Of all that were drawn.
    pub all: usize,
}

impl AddAssign for Count {
    fn add_assign(&mut self, other: Self) {
        self.judged += other.judged;
        self.applicable += other.applicable;
        self.all += other.all;
    }
}

/// What a campaign found about one law. `cases = held + broken + Σ inconclusive + Σ not_applicable`.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary<C> {
    /// The law's name.
    pub law: &'static str,
    /// Cases drawn.
    pub cases: usize,
    /// Cases on which it holds.
    pub held: usize,
    /// Indices of the cases on which it is broken, ascending.
    pub broken: Vec<usize>,
    /// Cases that could not be decided, by reason; a case that the strategy failed to produce is one of them.
    pub inconclusive: BTreeMap<String, usize>,
    /// Cases about which it says nothing, by reason.
    pub not_applicable: BTreeMap<String, usize>,
    /// Values that the strategy rejected before it produced a case, by reason; they are not cases.
    pub rejections: BTreeMap<String, usize>,
    /// The case with the largest defect/bound (the first of them), where any was judged.
    pub worst: Option<Worst>,
    /// The first of the broken cases, shrunk.
    pub failures: Vec<Failure<C>>,
    /// Broken cases that were not broken when checked again: the check is not a function of the case.
    pub irreproducible: Vec<usize>,
    /// By (category, label).
    pub coverage: BTreeMap<(String, String), Count>,
    /// Time spent in the checks, summed over the threads. The only number here that is not a function of the seed.
    pub seconds: f64,
}

impl<C> Summary<C> {
    /// Of no case.
    pub fn new(law: &'static str) -> Self {
        Self {
            law,
            cases: 0,
            held: 0,
            broken: Vec::new(),
            inconclusive: BTreeMap::new(),
            not_applicable: BTreeMap::new(),
            rejections: BTreeMap::new(),
            worst: None,
            failures: Vec::new(),
            irreproducible: Vec::new(),
            coverage: BTreeMap::new(),
            seconds: 0.0,
        }
    }

    /// Adds one case of which nothing but the verdict is known.
    pub fn judged(&mut self, index: usize, verdict: &Verdict) {
        self.cases += 1;
        match verdict {
            Verdict::Holds { .. } => self.held += 1,
            Verdict::Broken { .. } => {
                let at = self.broken.partition_point(|other| *other < index);
                self.broken.insert(at, index);
            }
            Verdict::Inconclusive { why } => *self.inconclusive.entry(why.clone()).or_default() += 1,
            Verdict::NotApplicable { why } => *self.not_applicable.entry(why.clone()).or_default() += 1,
        }
        if let Some((defect, bound)) = verdict.measured() {
            self.record_worst(Worst { defect, bound, index });
        }
    }

    /// Adds one case, with the time its check took.
    pub fn record(&mut self, record: &Record, seconds: f64) {
        self.judged(record.index, &record.verdict);
        let applicable = !matches!(record.verdict, Verdict::NotApplicable { .. });
        let judged = record.verdict.measured().is_some();
        let one = Count { judged: usize::from(judged), applicable: usize::from(applicable), all: 1 };
        for (category, label) in record.each_label() {
            *self.coverage.entry((category.to_owned(), label.to_owned())).or_default() += one;
        }
        for (reason, count) in &record.rejections {
            *self.rejections.entry(reason.clone()).or_default() += count;
        }
        self.seconds += seconds;
    }

    fn record_worst(&mut self, new: Worst) {
        let rank = |w: &Worst| (w.ratio(), std::cmp::Reverse(w.index));
        if self.worst.is_none_or(|old| rank(&new) > rank(&old)) {
            self.worst = Some(new);
        }
    }

    /// Adds what other cases of the same law have shown.
    pub fn append(&mut self, other: Self) {
        let add = |into: &mut BTreeMap<String, usize>, from: BTreeMap<String, usize>| {
            for (reason, count) in from {
                *into.entry(reason).or_default() += count;
            }
        };
        self.cases += other.cases;
        self.held += other.held;
        self.broken.extend(other.broken);
        self.broken.sort_unstable();
        add(&mut self.inconclusive, other.inconclusive);
        add(&mut self.not_applicable, other.not_applicable);
        add(&mut self.rejections, other.rejections);
        if let Some(worst) = other.worst {
            self.record_worst(worst);
        }
        self.failures.extend(other.failures);
        self.irreproducible.extend(other.irreproducible);
        for (key, count) in other.coverage {
            *self.coverage.entry(key).or_default() += count;
        }
        self.seconds += other.seconds;
    }

    /// How many cases carry a label.
    pub fn labelled(&self, category: &str, label: &str) -> Count {
        self.coverage.get(&(category.to_owned(), label.to_owned())).copied().unwrap_or_default()
    }

    /// The numbers, as one line of a table or of JSON.
    pub fn line(&self) -> Line {
        Line {
            law: self.law,
            cases: self.cases,
            held: self.held,
            broken: self.broken.len(),
            inconclusive: self.inconclusive.values().sum(),
            not_applicable: self.not_applicable.values().sum(),
            max_defect: self.worst.map(|worst| worst.defect),
            bound: self.worst.map(|worst| worst.bound),
            ratio: self.worst.map(|worst| worst.ratio()),
            seconds: self.seconds,
        }
    }
}

/// The numbers of one law. In JSON, numbers that are not finite and values that do not exist are `null`.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// The law's name.
    pub law: &'static str,
    /// Cases drawn.
    pub cases: usize,
    /// On which it holds.
    pub held: usize,
    /// On which it is broken.
    pub broken: usize,
    /// Which could not be decided.
    pub inconclusive: usize,
    /// About which it says nothing.
    pub not_applicable: usize,
    /// The defect of the case with the largest defect/bound; `None` where no case was judged.
    pub max_defect: Option<f64>,
    /// The bound of that case.
    pub bound: Option<f64>,
    /// Its defect/bound.
    #[serde(skip)]
    pub ratio: Option<f64>,
    /// Time spent in the checks, summed over the threads.
    pub seconds: f64,
}

impl Line {
    /// The sums of the lines of several laws, under the name `all` and without a defect.
    pub fn total(lines: impl Iterator<Item = Self>) -> Self {
        let zero = Summary::<()>::new("all").line();
        lines.fold(zero, |sum, line| Self {
            cases: sum.cases + line.cases,
            held: sum.held + line.held,
            broken: sum.broken + line.broken,
            inconclusive: sum.inconclusive + line.inconclusive,
            not_applicable: sum.not_applicable + line.not_applicable,
            seconds: sum.seconds + line.seconds,
            ..sum
        })
    }
}

/// How a campaign ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// Every case of the plan was checked.
    Complete,
    /// It was told to begin no further case; what broke is shrunk.
    Stopped,
    /// It was told to end at once: cases are missing, or what broke is not shrunk, or not to the end.
    Interrupted,
}

/// What a campaign found, in the order of its laws.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct CampaignReport<C> {
    /// The campaign's seed.
    pub seed: u64,
    /// Cases per cheap law, over all shards; `None` where no number was asked for.
    pub cases: Option<usize>,
    /// How it ended.
    pub ending: Ending,
    /// One summary per law.
    pub laws: Vec<Summary<C>>,
}

impl<C> CampaignReport<C> {
    /// Whether no law is broken.
    pub fn holds(&self) -> bool {
        self.laws.iter().all(|law| law.broken.is_empty())
    }

    /// The counts by (category, label), summed over the laws.
    pub fn total_coverage(&self) -> BTreeMap<(&str, &str), Count> {
        let mut total = BTreeMap::<_, Count>::new();
        for ((category, label), count) in self.laws.iter().flat_map(|law| &law.coverage) {
            *total.entry((category.as_str(), label.as_str())).or_default() += *count;
        }
        total
    }
}
