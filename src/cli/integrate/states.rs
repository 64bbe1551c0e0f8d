//! Initial states of an ensemble from a CSV file, read a row at a time.

use super::columns::Columns;
use crate::cli::Failure;
use csv::{Position, Reader, ReaderBuilder, StringRecord, Trim};
use euler_poincare::harness::parallel;
use euler_poincare::scalar::{Number, Real};
use euler_poincare::system::SystemFile;
use euler_poincare::system::case::Dictionary;
use euler_poincare::system::ensemble::{Ensemble, Origin, Parameter};
use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// The longest line that is read, in bytes.
const LONGEST: usize = 1 << 16;

/// The longest file that is read, in bytes.
const LARGEST: u64 = 1 << 36;

/// Columns that a run writes and that follow from the others: what one run wrote is the input of another.
const DERIVED: [&str; 7] = ["member", "energy", "work", "balance", "residual", "iterations", "status"];

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Column {
    Time,
    Momentum(usize),
    Attitude(usize),
    Parameter(usize),
    Derived,
}

/// A file of initial states.
pub struct States {
    path: PathBuf,
    columns: Vec<Column>,
    dimension: usize,
    /// Entries of the attitude in the file: m², or none.
    attitude: usize,
    names: Vec<String>,
    /// What fields may name.
    dictionary: Dictionary,
    /// Coefficients that have a column, in the order of the columns.
    pub parameters: Vec<Parameter>,
}

/// Refuses to go on where no line ends for too long, so that no file fills the memory.
struct Lines<R> {
    inner: R,
    since: usize,
}

impl<R: Read> Read for Lines<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.inner.read(buffer)?;
        for part in buffer[..count].split_inclusive(|&byte| byte == b'\n') {
            self.since += part.len();
            if self.since > LONGEST {
                return Err(io::Error::other(format!("a line is longer than {LONGEST} bytes")));
            }
            if part.ends_with(b"\n") {
                self.since = 0;
            }
        }
        Ok(count)
    }
}

type Rows = Reader<Lines<File>>;

impl States {
    /// Opens the file and understands its header.
    pub fn open(path: &Path, file: &SystemFile, columns: &Columns) -> Result<Self, Failure> {
        let refused = |reason: String| Failure::file(path, reason);
        let known = (path != Path::new("-")).then(|| std::fs::metadata(path));
        let known = known.transpose().map_err(|error| Failure::file(path, error))?;
        let Some(known) = known.filter(std::fs::Metadata::is_file) else {
            return Err(refused(
                "is no regular file: initial states are read twice, to be checked and to be used".into(),
            ));
        };
        if known.len() > LARGEST {
            return Err(refused(format!("has {} bytes; allowed: at most {LARGEST}", known.len())));
        }
        let mut rows = reader(path)?;
        let header = rows.headers().map_err(|error| refused(said(&error)))?.clone();
        if header.iter().all(str::is_empty) {
            return Err(refused(format!("is empty; needed: {}", allowed(file, columns))));
        }
        Self::understand(path, &header, file, columns)
    }

    fn understand(path: &Path, header: &StringRecord, file: &SystemFile, columns: &Columns) -> Result<Self, Failure> {
        let refused = |reason: String| Failure::file(path, format!("line 1: {reason}"));
        let (momenta, attitude) = (columns.momenta(), columns.attitude_names());
        let (possible, derived) = (Parameter::of(&file.case), columns.derived());
        let mut parameters = Vec::new();
        let mut found = Vec::new();
        for (k, name) in header.iter().enumerate() {
            if header.iter().take(k).any(|other| other == name) {
                return Err(refused(format!("the column {name:?} appears twice")));
            }
            let at = |names: &[String]| names.iter().position(|other| other == name);
            found.push(if name == "t" {
                Column::Time
            } else if let Some(a) = at(&momenta) {
                Column::Momentum(a)
            } else if let Some(i) = at(&attitude) {
                Column::Attitude(i)
            } else if let Some(parameter) = possible.iter().find(|parameter| parameter.name() == name) {
                parameters.push(parameter.clone());
                Column::Parameter(parameters.len() - 1)
            } else if DERIVED.contains(&name) || at(&derived).is_some() {
                Column::Derived
            } else {
                return Err(refused(format!("unknown column {name:?}; allowed: {}", allowed(file, columns))));
            });
        }
        let missing = |names: &[String]| {
            let missing: Vec<_> = names.iter().filter(|name| !header.iter().any(|h| h == *name)).cloned().collect();
            missing
        };
        let absent = missing(&momenta);
        if !absent.is_empty() {
            return Err(refused(format!("the column {} is missing", absent.join(", "))));
        }
        let absent = missing(&attitude);
        if !absent.is_empty() && absent.len() < attitude.len() {
            return Err(refused(format!("of the attitude {} is missing: all of it, or none", absent.join(", "))));
        }
        Ok(Self {
            path: path.into(),
            columns: found,
            dimension: columns.dimension,
            attitude: if absent.is_empty() { attitude.len() } else { 0 },
            names: header.iter().map(Into::into).collect(),
            dictionary: file.case.names.clone(),
            parameters,
        })
    }

    /// The members from the first on.
    pub fn members<T: Real>(&self) -> Result<Members<'_, T>, Failure> {
        Ok(Members { states: self, rows: reader(&self.path)?, record: StringRecord::new(), scalar: Default::default() })
    }

    /// How many members there are; every one is checked.
    pub fn check<T: Real>(&self, ensemble: &Ensemble) -> Result<u64, Failure> {
        let mut members = self.members::<T>()?;
        let mut count = 0;
        loop {
            let most = ensemble.batch();
            let origins = members.batch(most)?;
            let outcomes = parallel(origins.len(), |k| ensemble.check(&origins[k].1));
            if let Some(((line, _), Err(error))) = origins.iter().zip(outcomes).find(|(_, outcome)| outcome.is_err()) {
                return Err(self.refused(*line, error));
            }
            count += origins.len() as u64;
            if origins.len() < most {
                break;
            }
        }
        if count == 0 {
            return Err(Failure::file(&self.path, "has a header and no members"));
        }
        Ok(count)
    }

    fn refused(&self, line: u64, reason: impl std::fmt::Display) -> Failure {
        Failure::file(&self.path, format!("line {line}: {reason}"))
    }

    fn origin<T: Real>(&self, record: &StringRecord) -> Result<Origin<T>, String> {
        if record.len() != self.columns.len() {
            return Err(format!("{} fields, where the header has {} columns", record.len(), self.columns.len()));
        }
        let mut origin = Origin {
            time: None,
            momentum: vec![T::zero(); self.dimension],
            attitude: (self.attitude > 0).then(|| vec![T::zero(); self.attitude]),
            parameters: vec![Number::from(0); self.parameters.len()],
        };
        for ((text, column), name) in record.iter().zip(&self.columns).zip(&self.names) {
            let named = |error| format!("{name}: {error}");
            match *column {
                Column::Time => origin.time = Some(self.value(text).map_err(named)?),
                Column::Momentum(a) => origin.momentum[a] = self.value(text).map_err(named)?,
                Column::Attitude(i) => {
                    if let Some(attitude) = &mut origin.attitude {
                        attitude[i] = self.value(text).map_err(named)?;
                    }
                }
                Column::Parameter(k) => {
                    origin.parameters[k] = self.dictionary.number(text).map_err(named)?;
                }
                Column::Derived => {}
            }
        }
        Ok(origin)
    }

    /// The number that a field spells.
    fn value<T: Real>(&self, text: &str) -> Result<T, String> {
        // The common case, fast; what is not finite so gets the message of the expression.
        if T::NAME == f64::NAME
            && let Some(value) = text.parse::<f64>().ok().filter(|value| value.is_finite())
        {
            return Ok(T::exact(value));
        }
        self.dictionary.number(text)?.eval().map_err(|error| error.to_string())
    }
}

/// The rows of a file, one by one.
pub struct Members<'a, T> {
    states: &'a States,
    rows: Rows,
    record: StringRecord,
    scalar: std::marker::PhantomData<T>,
}

impl<T: Real> Members<'_, T> {
    /// The next member.
    fn next(&mut self) -> Result<Option<Origin<T>>, Failure> {
        let states = self.states;
        // As bytes first: the place of what is no text is that of the record.
        let mut bytes = std::mem::take(&mut self.record).into_byte_record();
        let more = self.rows.read_byte_record(&mut bytes).map_err(|error| Failure::file(&states.path, said(&error)))?;
        self.record = StringRecord::from_byte_record(bytes).map_err(|error| {
            let (field, byte) = (error.utf8_error().field() + 1, error.utf8_error().valid_up_to() + 1);
            let line = error.into_byte_record().position().map_or(0, Position::line);
            states.refused(line, format!("byte {byte} of field {field} is not valid UTF-8"))
        })?;
        if !more {
            return Ok(None);
        }
        states.origin(&self.record).map(Some).map_err(|reason| states.refused(self.line(), reason))
    }

    /// At most `most` more members, with their lines.
    pub fn batch(&mut self, most: usize) -> Result<Vec<(u64, Origin<T>)>, Failure> {
        let mut origins = Vec::new();
        while origins.len() < most {
            let Some(origin) = self.next()? else { break };
            origins.push((self.line(), origin));
        }
        Ok(origins)
    }

    /// The line of the member that was read last.
    fn line(&self) -> u64 {
        self.record.position().map_or(0, Position::line)
    }
}

fn reader(path: &Path) -> Result<Rows, Failure> {
    let file = File::open(path).map_err(|error| Failure::file(path, error))?;
    let lines = Lines { inner: file, since: 0 };
    Ok(ReaderBuilder::new().trim(Trim::All).flexible(true).comment(Some(b'#')).from_reader(lines))
}

/// What the reader of CSV says, without what we say ourselves.
fn said(error: &csv::Error) -> String {
    match error.kind() {
        csv::ErrorKind::Io(error) => error.to_string(),
        csv::ErrorKind::Utf8 { pos, err } => {
            let (line, field, byte) = (pos.as_ref().map_or(1, Position::line), err.field() + 1, err.valid_up_to() + 1);
            format!("line {line}: byte {byte} of field {field} is not valid UTF-8")
        }
        _ => error.to_string(),
    }
}

fn allowed(file: &SystemFile, columns: &Columns) -> String {
    let mut text = columns.momenta().join(", ");
    text.push_str(" (all of them); t");
    if let [first, .., last] = &columns.attitude_names()[..] {
        text.push_str(&format!("; {first} … {last} by rows (all or none)"));
    }
    for parameter in Parameter::of(&file.case) {
        text.push_str(&format!(", {}", parameter.name()));
    }
    text
}
