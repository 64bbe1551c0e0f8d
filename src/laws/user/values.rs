//! The case of a law on a part: named vectors of exact numbers.
//!
//! A part is a function of a few vectors (velocities, momenta, logarithms of group elements), so that is all a case holds.
//! The numbers are [`Number`] expressions, dyadic or π less a dyadic number, and mean the same in every scalar. A case prints
//! as one line for each vector, shrinks towards zeros, and is saved and read as a map from names to lists.

use super::super::precision::nudge;
use super::super::probe::{Probe, stream};
use crate::algebra::{Covector, Vector};
use crate::harness::pairs;
use crate::scalar::{Number, Real};
use crate::system::Draw;
use proptest::strategy::{NewTree, Strategy, ValueTree};
use proptest::test_runner::TestRunner;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Named vectors of numbers, in order; equal whatever the order.
#[derive(Clone, Debug, Default)]
pub struct Values {
    entries: Vec<(String, Vec<Number>)>,
}

impl PartialEq for Values {
    fn eq(&self, other: &Self) -> bool {
        self.entries.len() == other.entries.len() && self.entries.iter().all(|entry| other.entries.contains(entry))
    }
}

/// Why a case does not fit a part.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ValuesError {
    /// There is no vector of that name.
    #[error("the case has no vector `{name}`")]
    NoVector {
        /// The name.
        name: String,
    },
    /// A vector has another length.
    #[error("the vector `{name}` of the case has {found} numbers, expected {expected}")]
    Length {
        /// The name.
        name: String,
        /// Its length.
        found: usize,
        /// What the part needs.
        expected: usize,
    },
    /// A number has no value.
    #[error("the vector `{name}` of the case: {source}")]
    Number {
        /// The name.
        name: String,
        /// Why.
        source: crate::scalar::NumberError,
    },
}

impl Values {
    /// The case with these vectors.
    pub fn new<K: Into<String>>(entries: impl IntoIterator<Item = (K, Vec<Number>)>) -> Self {
        Self { entries: entries.into_iter().map(|(name, list)| (name.into(), list)).collect() }
    }

    /// The names and vectors, in order.
    pub fn entries(&self) -> impl Iterator<Item = (&str, &[Number])> {
        self.entries.iter().map(|(name, list)| (name.as_str(), list.as_slice()))
    }

    /// The numbers of the vector called `name`.
    ///
    /// # Errors
    /// No vector of that name and length; a number without a value in `T`.
    pub fn list<T: Real>(&self, name: &str, length: usize) -> Result<Vec<T>, ValuesError> {
        let Some((_, list)) = self.entries.iter().find(|(known, _)| known == name) else {
            return Err(ValuesError::NoVector { name: name.into() });
        };
        if list.len() != length {
            return Err(ValuesError::Length { name: name.into(), found: list.len(), expected: length });
        }
        let value = |x: &Number| x.eval::<T>().map_err(|source| ValuesError::Number { name: name.into(), source });
        list.iter().map(value).collect()
    }

    /// The same as a vector of g.
    ///
    /// # Errors
    /// Those of [`Values::list`].
    pub fn vector<T: Real, const N: usize>(&self, name: &str) -> Result<Vector<T, N>, ValuesError> {
        Ok(Vector::from_iterator(self.list(name, N)?))
    }

    /// The same as a covector of g*.
    ///
    /// # Errors
    /// Those of [`Values::list`].
    pub fn covector<T: Real, const N: usize>(&self, name: &str) -> Result<Covector<T, N>, ValuesError> {
        Ok(Covector::from_iterator(self.list(name, N)?))
    }

    /// A vector of one number.
    ///
    /// # Errors
    /// Those of [`Values::list`].
    pub fn number<T: Real>(&self, name: &str) -> Result<T, ValuesError> {
        Ok(self.list(name, 1)?[0])
    }

    /// Its numbers changed by a unit of round-off of `f64`, up or down; zeros stay.
    pub(super) fn moved(&self, sample: u32) -> Self {
        let mut probe = Probe::new(&sample, stream::ROUNDING);
        let mut values = self.clone();
        for number in values.entries.iter_mut().flat_map(|(_, list)| list) {
            nudge(number, &mut probe);
        }
        values
    }

    /// Simpler cases, the boldest first; each is lower in (denominator, size) of some number and higher in none.
    fn candidates(&self) -> Vec<Self> {
        let mut found = Vec::new();
        let mut push = |change: &dyn Fn(usize, usize, &Number) -> Number| {
            let lists = self.entries.iter().enumerate().map(|(i, (name, list))| {
                (name.clone(), list.iter().enumerate().map(|(k, x)| change(i, k, x)).collect())
            });
            let changed = Self { entries: lists.collect() };
            if changed != *self {
                found.push(changed);
            }
        };
        for i in 0..self.entries.len() {
            push(&|at, _, x| if at == i { Number::default() } else { x.clone() });
        }
        let longest = self.entries.iter().map(|(_, list)| list.len()).max().unwrap_or(0);
        for k in 0..longest {
            push(&|at, entry, x| {
                let all = self.entries[at].1.len() == longest && entry == k;
                if all { Number::default() } else { x.clone() }
            });
        }
        push(&|_, _, x| simpler(x).into_iter().nth(1).unwrap_or_else(|| x.clone()));
        for (i, (_, list)) in self.entries.iter().enumerate() {
            for (k, x) in list.iter().enumerate() {
                for simple in simpler(x) {
                    push(&|at, entry, y| if (at, entry) == (i, k) { simple.clone() } else { y.clone() });
                    // Vectors that are equal or opposite stay so.
                    push(&|_, entry, y| match float(y) {
                        value if entry == k && value == float(x) => simple.clone(),
                        value if entry == k && value == -float(x) => dyadic(-float(&simple)).unwrap_or_default(),
                        _ => y.clone(),
                    });
                }
            }
        }
        found
    }

    fn largest(&self) -> f64 {
        self.entries.iter().flat_map(|(_, list)| list).fold(0.0, |m: f64, x| m.max(float(x).abs()))
    }
}

impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let width = self.entries.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
        for (i, (name, list)) in self.entries.iter().enumerate() {
            let numbers: Vec<String> = list.iter().map(ToString::to_string).collect();
            let end = if i == 0 { "" } else { "\n" };
            write!(f, "{end}{name:width$} = [{}]", numbers.join(", "))?;
        }
        Ok(())
    }
}

impl Serialize for Values {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.entries.iter().map(|(name, list)| (name, list)))
    }
}

impl<'de> Deserialize<'de> for Values {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let entries: Vec<(String, Vec<Number>)> = pairs(deserializer, "a map from names to lists of numbers")?;
        let again = |k: &usize| entries[..*k].iter().any(|(known, _)| *known == entries[*k].0);
        match (0..entries.len()).find(again) {
            Some(k) => Err(D::Error::custom(format_args!("the vector `{}` is given twice", entries[k].0))),
            None => Ok(Self { entries }),
        }
    }
}

/// The value in `f64`; NaN where there is none.
fn float(x: &Number) -> f64 {
    x.eval().unwrap_or(f64::NAN)
}

/// The dyadic number x, if its denominator is at most 2⁶⁰ and its numerator below 2⁵³.
fn dyadic(x: f64) -> Option<Number> {
    let (p, bits) = grid(x)?;
    Some(Number::ratio(p, 1 << bits))
}

/// (p, k) with x = p/2ᵏ in lowest terms, k ≤ 60 and |p| < 2⁵³.
fn grid(x: f64) -> Option<(i64, u32)> {
    let (mut p, mut bits) = (x, 0);
    while p.fract() != 0.0 && bits < 60 {
        (p, bits) = (p * 2.0, bits + 1);
    }
    (p.fract() == 0.0 && p.abs() < 2f64.powi(53)).then_some((p as i64, bits))
}

/// 0 before integers before halves before …, small before large, positive before negative.
fn rank(x: f64) -> (u32, u64, bool) {
    match grid(x) {
        Some((p, bits)) => (bits, p.unsigned_abs(), p < 0),
        None => (u32::MAX, u64::MAX, x < 0.0),
    }
}

/// Simpler numbers than x, the simplest first.
fn simpler(x: &Number) -> Vec<Number> {
    let value = float(x);
    if value == 0.0 || !value.is_finite() {
        return Vec::new();
    }
    let exact = dyadic(value).as_ref() == Some(x);
    let rank_now = if exact { rank(value) } else { (u32::MAX, u64::MAX, true) };
    let on = |bits: i32| (value * 2f64.powi(bits)).trunc() / 2f64.powi(bits);
    let nearest = value.round();
    let (half, closer) = ((value * 0.5).trunc(), on(0) - value.signum());
    let above = value.signum() * value.abs().ceil();
    let whole = [0.0, value.signum(), half, closer, on(0), nearest, above];
    let tries = whole.into_iter().chain([on(1), on(2), on(3), on(6), on(12), value.abs()]);
    let mut found: Vec<Number> = Vec::new();
    for simple in tries {
        let simple = if rank(simple) < rank_now { dyadic(simple) } else { None };
        found.extend(simple.filter(|simple| !found.contains(simple)));
    }
    found
}

/// The strategy for [`Values`]: named vectors, with sizes and directions in known proportions.
///
/// Of the vectors of two numbers or more, 8 % are zero, 16 % have one component that is not, 16 % have some zeros. Of the
/// others than zero, half have components k/64 of at most 1; 15 % each are small (2⁻¹ to 2⁻⁸ times that) and tiny (2⁻⁹ to
/// 2⁻³⁰ times that); 10 % are up to 4 times that, and 10 % have a length of a quarter, a half or a whole turn less 2⁻⁸ to
/// 2⁻³⁰, or exactly (a rotation by them is near-singular for logarithm and Cayley map). After the first, 5 % each are
/// equal, opposite and nearly equal (2⁻²⁰ apart) to the one before. Numbers are zero in half of the cases, else k/4 of at
/// most 2.
#[derive(Clone, Debug)]
pub struct Points {
    /// Names with the lengths of vectors; none for a number.
    fields: Vec<(String, Option<usize>)>,
    largest: f64,
}

impl Default for Points {
    fn default() -> Self {
        Self::new()
    }
}

impl Points {
    /// No vectors yet; numbers of at most 2π.
    pub fn new() -> Self {
        Self { fields: Vec::new(), largest: 2.0 * std::f64::consts::PI }
    }

    /// Adds a vector of `length` numbers for each name.
    pub fn vectors(mut self, names: &[&str], length: usize) -> Self {
        self.fields.extend(names.iter().map(|name| ((*name).to_owned(), Some(length))));
        self
    }

    /// Adds one number (a time, a factor).
    pub fn number(mut self, name: &str) -> Self {
        self.fields.push((name.to_owned(), None));
        self
    }

    /// No component of a vector above `largest` in absolute value: vectors are halved until that holds. At least 2⁻²⁰.
    pub fn within(self, largest: f64) -> Self {
        Self { largest: if largest > 2f64.powi(-20) { largest } else { 2f64.powi(-20) }, ..self }
    }

    fn draw(&self, draw: &mut Draw<'_>) -> Values {
        let mut before: Option<Vec<Number>> = None;
        let entries = self.fields.iter().map(|(name, length)| {
            let Some(length) = length else { return (name.clone(), vec![draw.number()]) };
            let list = draw.vector(*length, before.as_deref());
            let list = self.halved(list);
            before = Some(list.clone());
            (name.clone(), list)
        });
        Values { entries: entries.collect() }
    }

    fn halved(&self, mut list: Vec<Number>) -> Vec<Number> {
        while list.iter().any(|x| float(x).abs() > self.largest) {
            // Turns lose their meaning when they are halved: to the dyadic number below.
            let half = |x: &Number| dyadic((float(x) * 0.5 * 2f64.powi(40)).trunc() / 2f64.powi(40));
            list = list.iter().map(|x| half(x).unwrap_or_default()).collect();
        }
        list
    }
}

impl Draw<'_> {
    /// k/64 with 1 ≤ |k| ≤ 64.
    fn unit(&mut self) -> f64 {
        let k = (1 + self.below(64)) as f64;
        if self.chance(50) { k / 64.0 } else { -k / 64.0 }
    }

    fn number(&mut self) -> Number {
        if self.chance(50) {
            return Number::default();
        }
        dyadic((self.below(17) as f64 - 8.0) / 4.0).unwrap_or_default()
    }

    fn vector(&mut self, n: usize, before: Option<&[Number]>) -> Vec<Number> {
        if let Some(before) = before.filter(|before| before.len() == n) {
            match self.below(20) {
                0 => return before.to_vec(),
                1 => return before.iter().map(negative).collect(),
                2 => return self.beside(before),
                _ => {}
            }
        }
        let mut mask = vec![true; n];
        match self.below(100) {
            0..8 => return vec![Number::default(); n],
            8..24 => {
                mask = vec![false; n];
                mask[self.below(n)] = true;
            }
            24..40 => {
                mask.iter_mut().for_each(|kept| *kept = self.chance(50));
                if !mask.iter().any(|kept| *kept) {
                    mask[self.below(n)] = true;
                }
            }
            _ => {}
        }
        let scale = match self.below(100) {
            0..50 => 0,
            50..65 => -self.int(1, 8),
            65..80 => -self.int(9, 30),
            80..90 => self.int(1, 2),
            _ => return self.turn(&mask),
        };
        let entry = |kept: &bool| if *kept { dyadic(self.unit() * 2f64.powi(scale as i32)) } else { None };
        mask.iter().map(entry).map(Option::unwrap_or_default).collect()
    }

    /// The vector before, one component 2⁻²⁰ away.
    fn beside(&mut self, before: &[Number]) -> Vec<Number> {
        let mut list = before.to_vec();
        let k = self.below(list.len());
        let text = format!("{} + 1/1048576", list[k]);
        let moved = match dyadic(float(&list[k])).filter(|exact| *exact == list[k]) {
            Some(_) => dyadic(float(&list[k]) + 2f64.powi(-20)),
            None => Number::parse(&text).ok(),
        };
        if let Some(moved) = moved {
            list[k] = moved;
        }
        list
    }

    /// A quarter, a half or a whole turn, or a little less: along an axis, or along (3, 4)/5 or (1, 2, 2)/3.
    fn turn(&mut self, mask: &[bool]) -> Vec<Number> {
        let whole = ["pi/2", "pi", "pi", "pi", "2*pi"][self.below(5)];
        let less = if self.chance(25) { String::new() } else { format!(" - 1/{}", 1_u64 << self.int(8, 30)) };
        let places: Vec<usize> = (0..mask.len()).filter(|k| mask[*k]).collect();
        let parts: &[&str] = match places.len() {
            0 | 1 => &["1"],
            2 => &["3/5", "4/5"],
            _ => &["1/3", "2/3", "2/3"],
        };
        let mut list = vec![Number::default(); mask.len()];
        for (part, place) in parts.iter().zip(&places) {
            let sign = if self.chance(50) { "-" } else { "" };
            let text = match *part {
                "1" if less.is_empty() => format!("{sign}{whole}"),
                "1" => format!("{sign}({whole}{less})"),
                part => format!("{sign}{part}*({whole}{less})"),
            };
            list[*place] = Number::parse(&text).unwrap_or_default();
        }
        list
    }
}

fn negative(x: &Number) -> Number {
    let exact = dyadic(float(x)).filter(|exact| exact == x);
    let turned = exact.and_then(|_| dyadic(-float(x)));
    turned.or_else(|| Number::parse(&format!("-({x})")).ok()).unwrap_or_else(|| x.clone())
}

impl Strategy for Points {
    type Tree = ValuesTree;
    type Value = Values;

    fn new_tree(&self, runner: &mut TestRunner) -> NewTree<Self> {
        let current = self.draw(&mut Draw(runner.rng()));
        Ok(ValuesTree::new(current, self.largest))
    }
}

/// A case and the way to simpler ones: candidates that depend on the case alone, so saved cases shrink as well.
#[derive(Clone, Debug)]
#[doc(hidden)]
pub struct ValuesTree {
    best: Values,
    current: Values,
    largest: f64,
    candidates: std::vec::IntoIter<Values>,
}

impl ValuesTree {
    /// Shrinks `case`, with no component above `largest` in absolute value unless there is one already.
    pub fn new(case: Values, largest: f64) -> Self {
        let largest = largest.max(case.largest());
        Self { best: case.clone(), current: case, largest, candidates: Vec::new().into_iter() }
    }

    fn next(&mut self) -> bool {
        let found = self.candidates.find(|case| case.largest() <= self.largest);
        let is_simpler = found.is_some();
        self.current = found.unwrap_or_else(|| self.best.clone());
        is_simpler
    }
}

impl ValueTree for ValuesTree {
    type Value = Values;

    fn current(&self) -> Values {
        self.current.clone()
    }

    fn simplify(&mut self) -> bool {
        self.best = self.current.clone();
        self.candidates = self.best.candidates().into_iter();
        self.next()
    }

    fn complicate(&mut self) -> bool {
        self.next()
    }
}
