//! What the rows of a campaign add up to, law by law; no row is kept.

use euler_poincare::harness::{Done, Record, Shard, Summary, Verdict};
use std::collections::BTreeMap;

/// log₁₀(defect/bound) in bins; with one below for smaller ratios and zero, and one above for all larger ones.
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

/// What the rows of one law say.
pub struct Tally {
    /// Its counts, reasons and coverage; the campaign may have laws that this program does not know, so the name is not here.
    pub found: Summary<()>,
    /// The first cases on which it is broken.
    pub first_broken: BTreeMap<usize, Verdict>,
    /// The first cases on which it holds.
    pub first_held: BTreeMap<usize, Verdict>,
    /// The first case that was not decided.
    pub first_undecided: Option<usize>,
    /// defect/bound of the cases that were judged.
    pub histogram: Histogram,
    seen: Done,
}

/// How many of the first cases of a kind are remembered.
const FIRST: usize = 10;

impl Tally {
    /// Of no rows, for the cases of a law in a shard.
    pub fn new(shard: Shard) -> Self {
        Self {
            found: Summary::new(""),
            first_broken: BTreeMap::new(),
            first_held: BTreeMap::new(),
            first_undecided: None,
            histogram: Histogram::new(),
            seen: Done::new(shard),
        }
    }

    /// Adds a row; false where its case is there already.
    pub fn add(&mut self, record: &Record) -> bool {
        let (index, verdict) = (record.index, &record.verdict);
        if !self.seen.insert(index) {
            return false;
        }
        match verdict {
            Verdict::Holds { .. } => keep_first(&mut self.first_held, index, verdict),
            Verdict::Broken { .. } => keep_first(&mut self.first_broken, index, verdict),
            Verdict::Inconclusive { .. } => {
                self.first_undecided = Some(self.first_undecided.map_or(index, |first| first.min(index)));
            }
            Verdict::NotApplicable { .. } => {}
        }
        if let Some(ratio) = verdict.ratio() {
            self.histogram.add(ratio);
        }
        self.found.record(record, 0.0);
        true
    }

    /// Cases on which the law is broken.
    pub fn broken(&self) -> usize {
        self.found.broken.len()
    }

    /// Cases that were judged.
    pub fn judged(&self) -> usize {
        self.found.held + self.broken()
    }
}

fn keep_first(first: &mut BTreeMap<usize, Verdict>, index: usize, verdict: &Verdict) {
    // Looked at before it is copied: most cases are not among the first.
    if first.len() < FIRST || first.last_key_value().is_some_and(|(last, _)| index < *last) {
        first.insert(index, verdict.clone());
        if first.len() > FIRST {
            first.pop_last();
        }
    }
}
