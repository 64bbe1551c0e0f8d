//! What the rows of a campaign add up to, law by law; no row is kept.

use euler_poincare::harness::{Done, Record, Shard, Verdict};
use std::collections::{BTreeMap, BTreeSet};

/// log₁₀(defect/bound) in bins; with one below for smaller ratios and zero, and one above for all larger ones.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: [usize; Self::BINS],
}

impl Histogram {
    /// Of the lowest bin that has one.
    pub const LOWEST: f64 = -7.0;
    /// Of the highest bin that has one.
    pub const HIGHEST: f64 = 2.0;
    /// Bins to a decade; the bound is the edge of a bin.
    pub const PER_DECADE: usize = 3;
    const BINS: usize = (Self::HIGHEST - Self::LOWEST) as usize * Self::PER_DECADE + 2;

    /// With nothing in it.
    pub fn new() -> Self {
        Self { counts: [0; Self::BINS] }
    }

    fn add(&mut self, ratio: f64) {
        let place = (ratio.log10() - Self::LOWEST) * Self::PER_DECADE as f64;
        // A ratio of exactly 1 holds: it belongs below the bound.
        let bin = if ratio == 0.0 { 0.0 } else { place.ceil().clamp(0.0, (Self::BINS - 1) as f64) };
        self.counts[bin as usize] += 1;
    }

    /// The counts, lowest first.
    pub fn counts(&self) -> &[usize] {
        &self.counts
    }

    /// The first bin that lies above the bound.
    pub fn above_bound() -> usize {
        (-Self::LOWEST) as usize * Self::PER_DECADE + 1
    }
}

/// A case that was judged.
#[derive(Clone, Debug)]
pub struct Judged {
    /// Its index.
    pub index: usize,
    /// What was measured; infinite where nothing could be.
    pub defect: f64,
    /// What is allowed; NaN where there is no number.
    pub bound: f64,
}

impl Judged {
    /// defect/bound, as a verdict has it.
    pub fn ratio(&self) -> f64 {
        Verdict::Holds { defect: self.defect, bound: self.bound }.ratio().unwrap_or(f64::INFINITY)
    }
}

/// How many cases carry a label.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Of those that were judged: the law held or was broken.
    pub judged: usize,
    /// Of all that were drawn.
    pub drawn: usize,
}

impl std::ops::AddAssign for Count {
    fn add_assign(&mut self, other: Self) {
        self.judged += other.judged;
        self.drawn += other.drawn;
    }
}

/// By category, then by label.
pub type Coverage = BTreeMap<String, BTreeMap<String, Count>>;

/// What the rows of one law say.
#[derive(Clone, Debug)]
pub struct Tally {
    /// Rows, each index once.
    pub cases: usize,
    /// On which it holds.
    pub held: usize,
    /// On which it is broken.
    pub broken: usize,
    /// The first of those, with their witnesses.
    pub broken_cases: BTreeMap<usize, (Judged, String)>,
    /// Undecided, by reason.
    pub inconclusive: BTreeMap<String, usize>,
    /// About which it says nothing, by reason.
    pub not_applicable: BTreeMap<String, usize>,
    /// What the generator threw away on the way, by reason.
    pub rejections: BTreeMap<String, usize>,
    /// defect/bound of the cases that were judged.
    pub histogram: Histogram,
    /// The one with the largest defect/bound, the first of them.
    pub worst: Option<Judged>,
    /// The first cases on which it holds.
    pub first_held: BTreeSet<usize>,
    /// The first case that was not decided.
    pub first_undecided: Option<usize>,
    /// What the cases are examples of.
    pub coverage: Coverage,
    seen: Done,
}

/// How many of the first cases of a kind are remembered.
const FIRST: usize = 10;

impl Tally {
    /// Of no rows, for the cases of a shard.
    pub fn new(shard: Shard) -> Self {
        Self {
            cases: 0,
            held: 0,
            broken: 0,
            broken_cases: BTreeMap::new(),
            inconclusive: BTreeMap::new(),
            not_applicable: BTreeMap::new(),
            rejections: BTreeMap::new(),
            histogram: Histogram::new(),
            worst: None,
            first_held: BTreeSet::new(),
            first_undecided: None,
            coverage: Coverage::new(),
            seen: Done::new(shard),
        }
    }

    /// Adds a row; false where its case is there already.
    pub fn add(&mut self, record: &Record) -> bool {
        let index = record.index;
        if !self.seen.insert(index) {
            return false;
        }
        self.cases += 1;
        match &record.verdict {
            Verdict::Holds { .. } => {
                self.held += 1;
                keep_first(&mut self.first_held, index);
            }
            Verdict::Broken { defect, bound, witness } => {
                self.broken += 1;
                self.keep_broken(Judged { index, defect: *defect, bound: *bound }, witness);
            }
            Verdict::Inconclusive { why } => {
                count(&mut self.inconclusive, why, 1);
                self.first_undecided = Some(self.first_undecided.map_or(index, |first| first.min(index)));
            }
            Verdict::NotApplicable { why } => count(&mut self.not_applicable, why, 1),
        }
        let measured = record.verdict.measured();
        if let Some((defect, bound)) = measured {
            self.measured(Judged { index, defect, bound });
        }
        for (category, label) in record.each_label() {
            self.label(category, label, measured.is_some());
        }
        for (reason, number) in &record.rejections {
            count(&mut self.rejections, reason, *number);
        }
        true
    }

    fn keep_broken(&mut self, judged: Judged, witness: &str) {
        let last = self.broken_cases.last_key_value().map_or(0, |(last, _)| *last);
        if self.broken_cases.len() < FIRST || judged.index < last {
            self.broken_cases.insert(judged.index, (judged, witness.to_owned()));
            if self.broken_cases.len() > FIRST {
                self.broken_cases.pop_last();
            }
        }
    }

    fn label(&mut self, category: &str, label: &str, judged: bool) {
        // Looked up first: a text is made only for what is new.
        if !self.coverage.contains_key(category) {
            self.coverage.insert(category.to_owned(), BTreeMap::new());
        }
        let Some(labels) = self.coverage.get_mut(category) else { return };
        let more = Count { judged: usize::from(judged), drawn: 1 };
        match labels.get_mut(label) {
            Some(count) => *count += more,
            None => drop(labels.insert(label.to_owned(), more)),
        }
    }

    fn measured(&mut self, judged: Judged) {
        self.histogram.add(judged.ratio());
        let rank = |judged: &Judged| (judged.ratio(), std::cmp::Reverse(judged.index));
        if self.worst.as_ref().is_none_or(|worst| rank(&judged) > rank(worst)) {
            self.worst = Some(judged);
        }
    }

    /// Cases that were judged.
    pub fn judged(&self) -> usize {
        self.held + self.broken
    }

    /// Cases that were not decided.
    pub fn undecided(&self) -> usize {
        self.inconclusive.values().sum()
    }

    /// Cases about which the law says nothing.
    pub fn inapplicable(&self) -> usize {
        self.not_applicable.values().sum()
    }
}

fn keep_first(set: &mut BTreeSet<usize>, index: usize) {
    set.insert(index);
    if set.len() > FIRST {
        set.pop_last();
    }
}

fn count(counts: &mut BTreeMap<String, usize>, reason: &str, number: usize) {
    match counts.get_mut(reason) {
        Some(count) => *count += number,
        None => drop(counts.insert(reason.to_owned(), number)),
    }
}
