//! What a study found: rows of errors, the line of each quantity, and how they compare with an order.

use super::{Reading, Row};
use crate::harness::Verdict;
use crate::harness::convergence::{Estimate, Level, LevelKind, TOLERANCE, WIDE, estimate, kinds};
use crate::harness::evidence::Evidence;
use std::cmp::Ordering;

const EXACT: &str =
    "every error is rounding: the method is exact on this motion, or the steps are too small for the digits";

/// The order that the errors of one quantity show.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    /// Every error is rounding: the method is exact on this motion.
    Exact,
    /// A slope with an interval, or the reason why there is none.
    Read(Estimate),
}

/// The errors of a study, level by level.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct Findings {
    quantities: Vec<String>,
    /// How many of them judge the order: the momentum and the attitude.
    judged: usize,
    rows: Vec<Row>,
    /// The slopes of errors are orders plus this.
    excess: u32,
}

/// How an order that was predicted compares with what was found.
///
/// The order of a method is the least that any part of the state shows on any system. So a part that does better proves
/// nothing, and a part that does worse settles it.
#[derive(Clone, Debug, PartialEq)]
pub enum Comparison {
    /// No part of the state is below the order, and one is at it.
    As {
        /// The slope of that part.
        slope: f64,
        /// The distance of its interval from the order.
        distance: f64,
    },
    /// A part of the state is below the order.
    Below {
        /// Which part, its slope and its interval.
        witness: String,
        /// The distance of its interval from the order.
        distance: f64,
    },
    /// Every part is above the order: the order is higher, or the system hides an error.
    Above {
        /// Which part comes nearest, its slope and its interval.
        witness: String,
        /// The distance of its interval from the order.
        distance: f64,
    },
    /// The method is exact on this motion.
    Exact,
    /// Nothing can be read off.
    Unknown {
        /// The reason; without numbers, so that reasons can be counted.
        why: String,
    },
}

impl Comparison {
    /// What was found against the order; `None` where every error is rounding, or nothing can be read off.
    pub fn ordering(&self) -> Option<Ordering> {
        match self {
            Comparison::As { .. } => Some(Ordering::Equal),
            Comparison::Below { .. } => Some(Ordering::Less),
            Comparison::Above { .. } => Some(Ordering::Greater),
            Comparison::Exact | Comparison::Unknown { .. } => None,
        }
    }

    /// As a verdict: above the order counts as broken, and exact as inconclusive.
    pub fn verdict(self) -> Verdict {
        match self {
            Comparison::As { distance, .. } => Verdict::Holds { defect: distance, bound: TOLERANCE },
            Comparison::Below { witness, distance } | Comparison::Above { witness, distance } => {
                Verdict::Broken { defect: distance, bound: TOLERANCE, witness }
            }
            Comparison::Exact => Verdict::inconclusive(EXACT),
            Comparison::Unknown { why } => Verdict::inconclusive(why),
        }
    }
}

impl Findings {
    /// Nothing yet; the first `judged` quantities are parts of the state.
    pub fn new(quantities: Vec<String>, judged: usize) -> Self {
        Self { quantities, judged, rows: Vec::new(), excess: 0 }
    }

    /// The same, of errors that go as h^{p+1}: those of a fixed number of steps.
    pub fn local(mut self) -> Self {
        self.excess = 1;
        self
    }

    /// By how much the slopes of the errors exceed the order: 0, or 1 for errors of single steps.
    pub fn excess(&self) -> f64 {
        f64::from(self.excess)
    }

    /// Adds a level.
    pub fn push(&mut self, row: Row) {
        self.rows.push(row);
    }

    /// The levels, as they were added.
    pub fn rows(&self) -> &[Row] {
        &self.rows
    }

    /// The names of the quantities.
    pub fn quantities(&self) -> &[String] {
        &self.quantities
    }

    /// Whether a level shows nothing but noise in the state.
    pub fn is_noise(&self, row: &Row) -> bool {
        row.readings.as_ref().is_ok_and(|list| list.iter().take(self.judged).all(|reading| !reading.is_clear()))
    }

    /// The same with more levels, one by one, until the last two of four or more show nothing but noise.
    ///
    /// # Errors
    /// The first of theirs.
    pub fn descend<E>(mut self, rows: impl IntoIterator<Item = Result<Row, E>>) -> Result<Self, E> {
        for row in rows {
            self.push(row?);
            if let [.., _, _, before, last] = self.rows.as_slice()
                && self.is_noise(before)
                && self.is_noise(last)
            {
                break;
            }
        }
        Ok(self)
    }

    /// The same with the largest step first.
    pub fn sorted(mut self) -> Self {
        self.rows.sort_by(|a, b| b.h.abs().total_cmp(&a.h.abs()));
        self
    }

    /// The first of the rows that count: those finer than any at which a step was refused.
    fn first(&self) -> usize {
        self.rows.iter().rposition(|row| row.readings.is_err()).map_or(0, |refused| refused + 1)
    }

    /// The reading of a quantity in a row, if it counts. A function of the state may have no value; a part of the state that is judged and
    /// is not a number stays, so that no order is read off the others.
    fn reading(&self, row: usize, quantity: usize) -> Option<&Reading> {
        let reading = self.rows[row].readings.as_ref().ok()?.get(quantity)?;
        (row >= self.first() && (quantity < self.judged || !reading.error.is_nan())).then_some(reading)
    }

    /// The levels of one quantity that count: finer than any at which a step was refused, and where it has a value.
    pub fn levels(&self, quantity: usize) -> Vec<Level> {
        let level = |row: usize| {
            let reading = self.reading(row, quantity)?;
            Some(Level { h: self.rows[row].h.abs(), error: reading.error, noise: reading.noise })
        };
        (0..self.rows.len()).filter_map(level).collect()
    }

    /// The order of one quantity.
    pub fn line(&self, quantity: usize) -> Line {
        let levels = self.levels(quantity);
        let readings = || (0..self.rows.len()).filter_map(|row| self.reading(row, quantity));
        if levels.is_empty() || readings().any(Reading::is_clear) {
            return Line::Read(estimate(&levels).lowered(f64::from(self.excess)));
        }
        if readings().all(|reading| reading.reference_error <= 0.5 * reading.noise) {
            return Line::Exact;
        }
        let why = "the errors are below those of the reference";
        Line::Read(Estimate::Inconclusive { why: why.into(), slopes: Vec::new() })
    }

    /// What each of the rows is to the order of a quantity; `None` where it does not count.
    pub fn kinds(&self, quantity: usize) -> Vec<Option<LevelKind>> {
        let levels = self.levels(quantity);
        let found = match self.line(quantity) {
            Line::Exact => vec![LevelKind::Noise; levels.len()],
            Line::Read(estimate) => kinds(&levels, &estimate.lowered(-f64::from(self.excess))),
        };
        let mut found = found.into_iter();
        (0..self.rows.len()).map(|row| self.reading(row, quantity).and_then(|_| found.next())).collect()
    }

    /// The lines of all quantities.
    pub fn lines(&self) -> Vec<Line> {
        (0..self.quantities.len()).map(|quantity| self.line(quantity)).collect()
    }

    /// The slope of each part of the state that has one; the first reason where a part has none, though it is not exact.
    fn slopes(&self) -> (Vec<(usize, Estimate)>, Option<String>) {
        let (mut slopes, mut unknown) = (Vec::new(), None);
        for quantity in 0..self.judged {
            match self.line(quantity) {
                Line::Exact => {}
                Line::Read(Estimate::Inconclusive { why, .. }) => {
                    unknown = unknown.or_else(|| Some(format!("{}: {why}", self.quantities[quantity])));
                }
                Line::Read(found) => slopes.push((quantity, found)),
            }
        }
        (slopes, unknown)
    }

    /// The part of the state with the lowest slope, and its estimate; the first reason where a part has none.
    pub fn limiting(&self) -> Result<(usize, Estimate), String> {
        match self.slopes() {
            (_, Some(why)) => Err(why),
            (slopes, None) => lowest(slopes).ok_or_else(|| EXACT.into()),
        }
    }

    /// How the order compares with what was found.
    pub fn compare(&self, order: u32) -> Comparison {
        self.decide(order).0
    }

    /// The part of the state that decides how the order compares, and its estimate; the one with the lowest slope where none
    /// does.
    pub fn deciding(&self, order: u32) -> Option<(usize, Estimate)> {
        let mut slopes = self.slopes().0;
        if let Some(decided) = self.decide(order).1 {
            slopes.retain(|(quantity, _)| *quantity == decided);
        }
        lowest(slopes)
    }

    /// The errors of each part of the state, the deciding one first, and their slopes beside what `order` predicts for them.
    ///
    /// `digits` are those of the arithmetic, and `of` is said with the name of the part.
    pub fn evidence(&self, order: u32, digits: u32, of: &str) -> Vec<Evidence> {
        let first = self.deciding(order).map(|(quantity, _)| quantity);
        let rest = (0..self.judged).filter(|quantity| Some(*quantity) != first);
        let tell = |quantity: usize| {
            let estimate = match self.line(quantity) {
                Line::Exact => Estimate::Inconclusive { why: EXACT.into(), slopes: Vec::new() },
                Line::Read(estimate) => estimate.lowered(-self.excess()),
            };
            self.tell(quantity, estimate, order, digits, of)
        };
        first.into_iter().chain(rest).map(tell).collect()
    }

    /// The same of one quantity by itself.
    pub fn evidence_of(&self, quantity: usize, order: u32, digits: u32, of: &str) -> Evidence {
        self.tell(quantity, estimate(&self.levels(quantity)), order, digits, of)
    }

    fn tell(&self, quantity: usize, estimate: Estimate, order: u32, digits: u32, of: &str) -> Evidence {
        let name = format!("{}{of}", self.quantities[quantity]);
        Evidence::levels(digits, name, self.levels(quantity), estimate, Some(order + self.excess))
    }

    /// Whether every error of a quantity is rounding, with the margin below which no slope is read off.
    pub fn is_exact(&self, quantity: usize) -> bool {
        (0..self.rows.len()).filter_map(|row| self.reading(row, quantity)).all(|reading| !reading.is_clear())
    }

    /// The order that the errors of one quantity show, and the verdict on `order` from this quantity alone.
    pub fn judge(&self, quantity: usize, order: u32) -> (Estimate, Verdict) {
        let (what, order) = (&self.quantities[quantity], order + self.excess);
        let found = estimate(&self.levels(quantity));
        let verdict = match found.judge(order) {
            Verdict::Broken { defect, bound, witness } => {
                let local = if self.excess > 0 { ", local error" } else { "" };
                Verdict::Broken { defect, bound, witness: format!("{what}{local}: {witness}") }
            }
            Verdict::Inconclusive { why } => Verdict::inconclusive(format!("{what}: {why}")),
            other => other,
        };
        (found.lowered(self.excess()), verdict)
    }

    fn decide(&self, order: u32) -> (Comparison, Option<usize>) {
        let wanted = f64::from(order);
        let (slopes, unknown) = self.slopes();
        let against =
            |ordering: Ordering| slopes.iter().filter(move |(_, found)| found.compare(order) == Some(ordering));
        let tell = |quantity: usize, found: &Estimate| {
            let (low, high) = found.interval();
            format!("{}: order in [{low:.3}, {high:.3}], expected {order}", self.quantities[quantity])
        };
        let by_high = |a: &&(usize, Estimate), b: &&(usize, Estimate)| a.1.interval().1.total_cmp(&b.1.interval().1);
        let by_low = |a: &&(usize, Estimate), b: &&(usize, Estimate)| a.1.interval().0.total_cmp(&b.1.interval().0);
        if let Some((quantity, found)) = against(Ordering::Less).min_by(by_high) {
            let distance = wanted - found.interval().1;
            return (Comparison::Below { witness: tell(*quantity, found), distance }, Some(*quantity));
        }
        if let Some(why) = unknown {
            return (Comparison::Unknown { why }, None);
        }
        let Some((quantity, found)) = slopes.iter().min_by(by_low) else { return (Comparison::Exact, None) };
        let low = found.interval().0;
        if found.compare(order) == Some(Ordering::Greater) {
            let (witness, distance) = (tell(*quantity, found), low - wanted);
            return (Comparison::Above { witness, distance }, Some(*quantity));
        }
        let distance = |found: &Estimate| (found.interval().1 - wanted).max(wanted - found.interval().0);
        let nearest = against(Ordering::Equal).min_by(|a, b| distance(&a.1).total_cmp(&distance(&b.1)));
        match nearest.filter(|_| low >= wanted - TOLERANCE) {
            Some((quantity, found)) => {
                let slope = found.slope().unwrap_or(wanted);
                (Comparison::As { slope, distance: distance(found) }, Some(*quantity))
            }
            None => (Comparison::Unknown { why: WIDE.into() }, None),
        }
    }
}

/// The lowest of some slopes.
fn lowest(slopes: Vec<(usize, Estimate)>) -> Option<(usize, Estimate)> {
    let slope = |(_, found): &(usize, Estimate)| found.slope().unwrap_or(f64::INFINITY);
    slopes.into_iter().min_by(|a, b| slope(a).total_cmp(&slope(b)))
}
