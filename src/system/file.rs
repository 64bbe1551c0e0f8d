//! The system file: a [`Case`] in TOML, with a horizon and output options. [`example`] is its documentation.
//!
//! Every error names the line and says what is allowed there. Syntax, types and unknown keys are reported by the TOML
//! reader with their span; what is wrong with the mathematics is reported at a [`Place`], which is then looked up in
//! the text.

use super::case::{Case, Force, Potential, Tau};
use super::document::{Document, OutputTable, RunTable, ScalarName, no_steps};
use super::error::{CaseError, CaseProblem, Place, Segment};
use super::force::ForceKind;
use super::numbers::{count, number};
use super::parameters::{self, Unread};
use super::reading::Reading;
use super::tolerance::Adaptive;
use crate::expression::nearest;
use crate::file::{Excerpt, ends_in};
use crate::scalar::{Dd, Number, Real};
use crate::tableau::file::{MOST_DIGITS, significant_digits};
use crate::tableau::{Description, Family};
use serde::Deserialize;
use std::borrow::Cow;
use std::fmt;
use std::ops::Range;
use std::path::Path;
use toml::de::{DeTable, DeValue, Deserializer};

pub use super::document::MAX_STEPS;

/// The longest file that is read, in bytes.
pub const MAX_BYTES: usize = 1 << 20;

/// A duration within this part of a step of a multiple of the step is that multiple, because decimals are rounded.
const ROUNDED: f64 = 1.0 / 1_048_576.0;

/// How long a run is.
#[derive(Clone, Debug, PartialEq)]
pub enum Horizon {
    /// From the initial time t₀ to t₀ + this (of the sign of the step); the last step is shortened to end there.
    Duration(Number),
    /// This many steps.
    Steps(u64),
}

/// What a run writes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Output {
    /// Every how many steps a row is written (the first and the last state always are).
    pub every: u64,
    /// Where the CSV goes; `None`: the standard output.
    pub csv: Option<String>,
    /// Where the figure goes; `None`: no figure.
    pub svg: Option<String>,
    /// Where the table of events goes; `None`: no table.
    pub events: Option<String>,
}

/// A run as a file describes it.
///
/// ```
/// use euler_poincare::system::file::{SystemFile, example};
/// use euler_poincare::system::ScalarName;
///
/// let file = SystemFile::parse(example())?;
/// assert_eq!((file.output.every, file.scalar), (1, ScalarName::F64));
/// assert_eq!(file.plan::<f64>()?.0, 8);
///
/// let refused = SystemFile::parse("format = 1\nalgebra = 7\n");
/// assert_eq!(refused.unwrap_err().line, 2);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct SystemFile {
    /// The system, the method, the initial state and the step; where there is a tolerance, the step is the horizon.
    pub case: Case,
    /// The tolerance and what goes with it, where the file has one instead of a step.
    pub adaptive: Option<Adaptive>,
    /// How long.
    pub horizon: Horizon,
    /// In which scalar.
    pub scalar: ScalarName,
    /// What is written.
    pub output: Output,
}

/// Why a file was refused, and where.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct FileError {
    /// The line, from 1.
    pub line: usize,
    /// The column in characters, from 1.
    pub column: usize,
    /// The text of that line.
    pub excerpt: String,
    /// What is wrong, and what is allowed.
    pub message: String,
}

impl fmt::Display for FileError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let place = Excerpt { line: self.line, column: self.column, text: self.excerpt.clone() };
        f.write_str(&place.says(&self.message))
    }
}

impl std::error::Error for FileError {}

impl FileError {
    fn at(text: &str, span: Option<Range<usize>>, message: String) -> Self {
        let Excerpt { line, column, text: excerpt } = Excerpt::of(text, span.map_or(0, |span| span.start));
        Self { line, column, excerpt, message }
    }

    fn syntax(text: &str, error: &toml::de::Error) -> Self {
        // `given` is a key and a kind of records that the laws write, not of files that people do.
        let mut message = error.message().replace('\n', "; ").replace(", `given`", "");
        if let Some(hint) = missing_field(&message).and_then(hint) {
            message = format!("{message}; allowed: {hint}");
        }
        Self::at(text, error.span(), message)
    }

    /// A text that is no number: the place in it, if the file has it as it is.
    fn unread(text: &str, Unread { span, text: written, refused }: &Unread) -> Self {
        let start = text.get(span.clone()).and_then(|found| found.find(written.as_str()));
        let at = span.start + refused.at.zip(start).map_or(0, |(at, start)| at + start);
        Self::at(text, Some(at..at), refused.message.clone())
    }

    fn case(text: &str, error: &CaseError) -> Self {
        let span = DeTable::parse(text).ok().and_then(|table| locate(table.get_ref(), error.place.segments()));
        let CaseProblem::Formula(formula) = &error.problem else { return Self::at(text, span, error.to_string()) };
        // The place in the formula, if the file has its text as it is.
        let written = span.clone().and_then(|span| text.get(span));
        let within = formula.text().filter(|formula| !formula.is_empty()).and_then(|formula| written?.find(formula));
        match (span, within) {
            (Some(span), Some(start)) => {
                let at = span.start + start + formula.position();
                Self::at(text, Some(at..at), format!("{}: {}", error.place, formula.message()))
            }
            (span, _) => Self::at(text, span, error.to_string()),
        }
    }
}

/// What stands for the method where a stepper is asked instead.
const ANY_METHOD: &str = "[method]\ntableau = \"gauss-1\"\nretraction = \"exp\"\n";

/// The key in "missing field `key`".
fn missing_field(message: &str) -> Option<&str> {
    message.strip_prefix("missing field `")?.strip_suffix('`')
}

/// What a required key holds.
fn hint(key: &str) -> Option<String> {
    let hint = match key {
        "format" => "the line `format = 1` at the top",
        "algebra" => "a table [algebra] with `name`, or with `dimension` and `constants`",
        "method" => "a table [method] with `tableau` (or `tableau-file`, or `a` and `b`) and `retraction`",
        "retraction" => {
            let values = Tau::ALL.iter().map(|tau| format!("`retraction = {:?}`", tau.name()));
            return Some(values.collect::<Vec<_>>().join(" or "));
        }
        "state" => "a table [state] with `velocity` or `momentum`",
        "run" => "a table [run] with `step`, and `horizon` or `steps`; or with `tolerance` and `horizon`",
        "kind" => {
            return Some(ForceKind::names().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", "));
        }
        _ => return None,
    };
    Some(hint.into())
}

/// The span of a place, or of the innermost table or list around it that exists.
fn locate(table: &DeTable<'_>, place: &[Segment]) -> Option<Range<usize>> {
    let (Segment::Key(first), rest) = place.split_first()? else { return None };
    let (key, value) = table.iter().find(|(key, _)| key.get_ref() == first)?;
    let mut value = value;
    let mut span = if value.get_ref().is_table() { key.span() } else { value.span() };
    for segment in rest {
        let (next, at) = match (segment, value.get_ref()) {
            (Segment::Key(wanted), DeValue::Table(table)) => {
                let Some((key, next)) = table.iter().find(|(key, _)| key.get_ref() == wanted) else { break };
                (next, if next.get_ref().is_table() { key.span() } else { next.span() })
            }
            (Segment::Index(index), DeValue::Array(items)) => {
                let Some(next) = items.get(*index) else { break };
                (next, next.span())
            }
            _ => break,
        };
        (value, span) = (next, at);
    }
    Some(span)
}

fn read(text: &str) -> Result<Document, FileError> {
    read_with(text, "")
}

/// The document of a text with lines added to it.
fn read_with(text: &str, added: &str) -> Result<Document, FileError> {
    if text.len() > MAX_BYTES {
        let message = format!("the file has {} bytes; allowed: at most {MAX_BYTES}", text.len());
        return Err(FileError::at("", None, message));
    }
    let whole = if added.is_empty() { Cow::Borrowed(text) } else { Cow::Owned(format!("{text}\n{added}")) };
    let mut table = DeTable::parse(&whole).map_err(|error| FileError::syntax(text, &error))?;
    let long = table.get_ref().iter().find_map(|(_, value)| rounded(text, value));
    // First, because the keys of a table follow from its kind.
    if let Some((span, message)) = unknown_kind(table.get_ref()) {
        return Err(FileError::at(text, Some(span), message));
    }
    let unread = parameters::put(table.get_mut());
    let document = Document::deserialize(Deserializer::from(table)).map_err(|error| {
        // Of a text that is no number more is known.
        let first = unread.first().filter(|_| error.message().contains("is not a number"));
        first.map_or_else(|| FileError::syntax(text, &error), |unread| FileError::unread(text, unread))
    })?;
    match long {
        None => Ok(document),
        Some((span, digits)) => {
            let message =
                format!("a number of {digits} digits loses some of them (more than {MOST_DIGITS}): put it in quotes");
            Err(FileError::at(text, Some(span), message))
        }
    }
}

/// The first force or potential of a kind that there is not, and what there is.
fn unknown_kind(table: &DeTable<'_>) -> Option<(Range<usize>, String)> {
    let forces: Vec<&str> = ForceKind::names().collect();
    [("force", &forces[..]), ("potential", &Potential::KINDS)].into_iter().find_map(|(key, kinds)| {
        let unknown = |item: &toml::Spanned<DeValue<'_>>| {
            let kind = item.get_ref().as_table()?.iter().find(|(key, _)| key.get_ref() == "kind")?.1;
            let name = kind.get_ref().as_str().filter(|name| *name != "given" && !kinds.contains(name))?;
            let near = nearest(name, kinds.iter().copied(), NEAREST).join("`, `");
            let message =
                format!("unknown kind of {key} `{name}`; near to it: `{near}`; allowed: `{}`", kinds.join("`, `"));
            Some((kind.span(), message))
        };
        table.iter().find(|(name, _)| name.get_ref() == key)?.1.get_ref().as_array()?.iter().find_map(unknown)
    })
}

/// The largest number of names shown as near to an unknown one.
const NEAREST: usize = 3;

/// The first number that is not in quotes and has more digits than an `f64` keeps, and how many.
fn rounded(text: &str, value: &toml::Spanned<DeValue<'_>>) -> Option<(Range<usize>, usize)> {
    match value.get_ref() {
        DeValue::Float(_) | DeValue::Integer(_) => {
            let written = text.get(value.span()).unwrap_or("").trim_start_matches(['+', '-']).replace('_', "");
            let digits = significant_digits(&written);
            (digits > MOST_DIGITS).then_some((value.span(), digits))
        }
        DeValue::Array(items) => items.iter().find_map(|item| rounded(text, item)),
        DeValue::Table(table) => table.iter().find_map(|(_, item)| rounded(text, item)),
        _ => None,
    }
}

/// The document as TOML.
fn write(document: &Document<Force>) -> Result<String, CaseError> {
    toml::to_string(document).map_err(|error| Place::root().error(CaseProblem::Part(error.to_string())))
}

impl SystemFile {
    /// Reads and checks a whole file: syntax, keys, and whether the case it describes can be built.
    ///
    /// # Errors
    /// A [`FileError`] with the line, the column, what is wrong and what is allowed. No input panics.
    pub fn parse(text: &str) -> Result<Self, FileError> {
        Self::parse_with(text, &Reading::default())
    }

    /// The same with what replaces parts of the file, and with the files that it names.
    ///
    /// # Errors
    /// Those of [`SystemFile::parse`]; those of a file that it names, at the name.
    pub fn parse_with(text: &str, reading: &Reading) -> Result<Self, FileError> {
        let mut document = read(text)?;
        let located = |error: CaseError| FileError::case(text, &error);
        reading.complete(&mut document.method).map_err(located)?;
        let adaptive = Adaptive::take(&mut document).map_err(located)?;
        let (run, output) = (document.run.clone(), document.output.clone().unwrap_or_default());
        if adaptive.is_some() {
            document.output = None;
        }
        let case = Case::try_from(document).map_err(located)?;
        case.check().map_err(located)?;
        let horizon = horizon(&run, &Place::root().key("run")).map_err(located)?;
        let output = self::output(output, &Place::root().key("output")).map_err(located)?;
        let scalar = reading.scalar.or(run.scalar).unwrap_or_default();
        let file = Self { case, adaptive, horizon, scalar, output };
        file.check().map_err(located)?;
        Ok(file)
    }

    /// Whether the run makes sense.
    fn check(&self) -> Result<(), CaseError> {
        let Some(adaptive) = &self.adaptive else { return self.plan::<f64>().map(drop) };
        match self.scalar {
            ScalarName::F64 => self.solve_plan::<f64>().map(drop)?,
            ScalarName::Dd => self.solve_plan::<Dd>().map(drop)?,
        }
        adaptive.expressions(&self.case).map(drop)
    }

    /// The case in a system file, for a method that is not of this crate: `[method]` and the length of the run may be missing.
    /// Without `[method]` the initial attitude is the exponential of its coordinates. The case is built once to check it.
    ///
    /// # Errors
    /// Those of [`SystemFile::parse`].
    pub fn parse_for_stepper(text: &str) -> Result<Case, FileError> {
        let without_method = DeTable::parse(text).is_ok_and(|table| !table.get_ref().contains_key("method"));
        // At the end, so that every place in the text stays where it is.
        let mut document = read_with(text, if without_method { ANY_METHOD } else { "" })?;
        if document.method.tableau_file.is_some() {
            document.method.put(Description::Family(Family::Gauss, 1));
        }
        let located = |error: CaseError| FileError::case(text, &error);
        let case = Case::try_from(document).map_err(located)?;
        case.check().map_err(located)?;
        Ok(case)
    }

    /// The run as TOML, which reads back equal.
    ///
    /// # Errors
    /// The serialiser's, as text.
    pub fn to_toml(&self) -> Result<String, CaseError> {
        let mut document = Document::from(self.case.clone());
        match &self.horizon {
            Horizon::Duration(duration) => document.run.horizon = Some(duration.clone()),
            Horizon::Steps(steps) => document.run.steps = Some(*steps as i64),
        }
        document.run.scalar = Some(self.scalar);
        document.output = Some(OutputTable {
            every: Some(self.output.every as i64),
            csv: self.output.csv.clone(),
            svg: self.output.svg.clone(),
            events: self.output.events.clone(),
            ..OutputTable::default()
        });
        if let Some(adaptive) = self.adaptive.clone() {
            adaptive.put(&mut document);
        }
        write(&document)
    }

    /// How many whole steps there are, and the size of the shorter one that ends the run, if any.
    ///
    /// A duration within 2⁻²⁰ of a step of a multiple of the step counts as that multiple: decimals are rounded.
    ///
    /// # Errors
    /// A step or a duration without a value, of opposite signs, or more than [`MAX_STEPS`] steps.
    pub fn plan<T: Real>(&self) -> Result<(u64, Option<T>), CaseError> {
        let run = Place::root().key("run");
        if self.adaptive.is_some() {
            return Err(no_steps());
        }
        let duration = match &self.horizon {
            Horizon::Steps(steps) => return Ok((*steps, None)),
            Horizon::Duration(duration) => duration,
        };
        let step: T = number(&self.case.step, &run.key("step"))?;
        let place = run.key("horizon");
        let length: T = number(duration, &place)?;
        let ratio = length / step;
        let range = |allowed: String| place.range(duration, allowed);
        if !ratio.all_finite() || ratio <= T::zero() {
            return Err(range(format!("a duration with the sign of the step {}, not zero", self.case.step)));
        }
        if ratio < T::one() - T::exact(ROUNDED) {
            return Err(range(format!("at least one step of {}", self.case.step)));
        }
        if ratio > T::int(MAX_STEPS as i64) {
            return Err(range(format!("at most {MAX_STEPS} steps of {}", self.case.step)));
        }
        let whole = ratio.round();
        if (ratio - whole).abs() <= T::exact(ROUNDED) {
            return Ok((whole.to_f64() as u64, None));
        }
        let whole = ratio.floor();
        Ok((whole.to_f64() as u64, Some(length - whole * step)))
    }
}

impl Case {
    /// The case as a TOML system file (without a horizon).
    ///
    /// # Errors
    /// None that a case built by this crate can cause; the serialiser's, as text.
    pub fn to_toml(&self) -> Result<String, CaseError> {
        write(&Document::from(self.clone()))
    }

    /// The case in a TOML system file, which is not built; its run options are ignored.
    ///
    /// # Errors
    /// See [`FileError`].
    pub fn from_toml(text: &str) -> Result<Self, FileError> {
        Self::try_from(read(text)?).map_err(|error| FileError::case(text, &error))
    }
}

fn horizon(run: &RunTable, place: &Place) -> Result<Horizon, CaseError> {
    match (&run.horizon, run.steps) {
        (Some(duration), None) => Ok(Horizon::Duration(duration.clone())),
        (None, Some(steps)) => Ok(Horizon::Steps(count(steps, MAX_STEPS, &place.key("steps"))?)),
        (None, None) => Err(place.missing("the length of the run", "`horizon` (a duration) or `steps` (an integer)")),
        (Some(_), Some(_)) => Err(place.key("steps").excess("either `horizon` or `steps`, not both")),
    }
}

fn output(table: OutputTable, place: &Place) -> Result<Output, CaseError> {
    for (key, path) in [("csv", &table.csv), ("svg", &table.svg), ("events", &table.events)] {
        if path.as_deref().is_some_and(|path| path.trim().is_empty() || path.contains('\0')) {
            return Err(place.key(key).range("not a file name", "a file name, or leave the key out"));
        }
    }
    if let Some(svg) = table.svg.as_ref().filter(|svg| !ends_in(Path::new(svg), "svg")) {
        return Err(place
            .key("svg")
            .range(format!("{svg:?}"), "a file name that ends in .svg, because figures are SVG"));
    }
    let every = table.every.map_or(Ok(1), |every| count(every, MAX_STEPS, &place.key("every")))?;
    Ok(Output { every, csv: table.csv, svg: table.svg, events: table.events })
}

/// A complete file with comments on every key: the first example of Martín de Diego and Sato Martín de Almagro 2019,
/// §5.3 (Landau–Lifshitz–Gilbert damping of a rigid body).
pub fn example() -> &'static str {
    include_str!("example.toml")
}

macro_rules! examples {
    ($($name:literal),*) => {
        &[$(($name, include_str!(concat!("examples/", $name, ".toml")))),*]
    };
}

/// Systems that people know, by name, each with a comment that says what to look at.
pub fn examples() -> &'static [(&'static str, &'static str)] {
    examples!(
        "body-in-four-dimensions",
        "heavy-top",
        "kirchhoff",
        "kovalevskaya-top",
        "quadrotor",
        "satellite",
        "sleigh",
        "spin",
        "tennis-racket",
        "toda-lattice",
        "underwater-vehicle"
    )
}
