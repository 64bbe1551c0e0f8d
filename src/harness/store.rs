//! A campaign in a directory: every verdict on disk as it comes, so that a killed run loses nothing but the cases in
//! flight.
//!
//! | file | holds |
//! |---|---|
//! | `campaign.json` | the [`Manifest`]: what was asked, and of which program |
//! | `results.jsonl` | a [`Record`] a line: while the campaign runs as they come, afterwards in canonical order |
//! | `timings.jsonl` | a [`Timing`] a line; no time stands anywhere else |
//! | `failures/` | the shrunk cases, `LAW-seedS-caseI.json`; who knows the case writes them |
//!
//! The canonical order is that of the laws in the manifest, then of the indices. The records of a finished campaign are
//! a function of the manifest alone: the same bytes at any number of threads, interrupted and resumed or not, in one
//! piece or merged from shards. (The same program on the same machine: another compiler may round otherwise.)

mod canonical;
mod manifest;
mod merge;

pub use manifest::{Manifest, ManifestLaw};
pub use merge::{Merged, merge};

use super::campaign::{Recorded, Sink};
use super::law::Law;
use super::plan::Done;
use super::record::Record;
use super::summary::Summary;
use crate::file;
use serde::{Deserialize, Serialize};
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The manifest's file.
pub const MANIFEST: &str = "campaign.json";
/// The records' file.
pub const RESULTS: &str = "results.jsonl";
/// The file of times.
pub const TIMINGS: &str = "timings.jsonl";
/// The directory of shrunk cases.
pub const FAILURES: &str = "failures";

/// The time that the check of one case took.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Timing {
    /// Name of the law.
    pub law: String,
    /// Index of the case.
    pub index: usize,
    /// Seconds of one thread.
    pub seconds: f64,
}

/// Why a campaign's directory cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The system's answer.
    #[error("{}: {error}", path.display())]
    Io {
        /// The file or directory.
        path: PathBuf,
        /// What went wrong.
        error: io::Error,
    },
    /// A new campaign where there is one.
    #[error("{}: holds a campaign already", path.display())]
    Occupied {
        /// The directory.
        path: PathBuf,
    },
    /// No manifest.
    #[error("{}: holds no campaign ({MANIFEST} is missing)", path.display())]
    NoCampaign {
        /// The directory.
        path: PathBuf,
    },
    /// Another process writes there.
    #[error("{}: another run is writing there", path.display())]
    InUse {
        /// The directory.
        path: PathBuf,
    },
    /// Not the campaign that it should be.
    #[error("{}: another campaign: {}", path.display(), differences.join("; "))]
    Differs {
        /// The directory.
        path: PathBuf,
        /// What is different, each as `NAME is X there, Y here`.
        differences: Vec<String>,
    },
    /// A file that a campaign cannot have written.
    #[error("{}: line {line}: {reason}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is wrong with it.
        reason: String,
    },
    /// Shards that do not make a whole.
    #[error("{reason}")]
    Shards {
        /// Which are missing, or there twice.
        reason: String,
    },
    /// A shard that is not finished.
    #[error("{}: {missing} cases are missing, the first is case {index} of {law}", path.display())]
    Incomplete {
        /// The directory.
        path: PathBuf,
        /// How many cases.
        missing: usize,
        /// The law of the first.
        law: String,
        /// Its index.
        index: usize,
    },
}

impl StoreError {
    fn io(path: &Path) -> impl Fn(io::Error) -> Self {
        |error| Self::Io { path: path.to_owned(), error }
    }
}

/// A campaign's directory, held by this process until it is dropped.
#[derive(Debug)]
pub struct Store {
    path: PathBuf,
    manifest: Manifest,
    /// The manifest's file, locked.
    _lock: File,
}

impl Store {
    /// A new campaign; the directory is made where it is missing.
    ///
    /// # Errors
    /// Where there is a campaign already, or what the system says.
    pub fn create(path: &Path, manifest: Manifest) -> Result<Self, StoreError> {
        Self::start(path, manifest, false)
    }

    /// The campaign in the directory, to go on with it; a new one where there is none. Lines that were torn when it was
    /// killed are cut off.
    ///
    /// # Errors
    /// Where the campaign in it is another one, where another process is writing, or what the system says.
    pub fn resume(path: &Path, manifest: Manifest) -> Result<Self, StoreError> {
        Self::start(path, manifest, true)
    }

    fn start(path: &Path, manifest: Manifest, resume: bool) -> Result<Self, StoreError> {
        fs::create_dir_all(path).map_err(StoreError::io(path))?;
        let file = path.join(MANIFEST);
        let new = !file.exists();
        if new && [RESULTS, TIMINGS].iter().any(|name| path.join(name).exists()) {
            return Err(StoreError::NoCampaign { path: path.to_owned() });
        }
        // The first run to lock the file fills it: of two with one directory the other is refused.
        let options = OpenOptions::new().read(true).write(true).create(true).truncate(false).clone();
        let mut lock = options.open(&file).map_err(StoreError::io(&file))?;
        try_lock(&lock, path)?;
        let mut text = String::new();
        lock.read_to_string(&mut text).map_err(StoreError::io(&file))?;
        if text.is_empty() {
            // New, or killed before a word was written.
            lock.write_all(manifest.to_json().as_bytes()).map_err(StoreError::io(&file))?;
        } else if !resume {
            return Err(StoreError::Occupied { path: path.to_owned() });
        } else {
            let differences = Manifest::from_json(&text, &file)?.differences(&manifest);
            if !differences.is_empty() {
                return Err(StoreError::Differs { path: path.to_owned(), differences });
            }
            for name in [RESULTS, TIMINGS] {
                cut_torn_line(&path.join(name))?;
            }
        }
        Ok(Self { path: path.to_owned(), manifest, _lock: lock })
    }

    /// The campaign in the directory as it is.
    ///
    /// # Errors
    /// Where there is none, where another process is writing, or what the system says.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        let manifest = Manifest::read(path)?;
        let file = path.join(MANIFEST);
        let lock = File::open(&file).map_err(StoreError::io(&file))?;
        try_lock(&lock, path)?;
        Ok(Self { path: path.to_owned(), manifest, _lock: lock })
    }

    /// The directory.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What was asked.
    pub fn manifest(&self) -> &Manifest {
        &self.manifest
    }

    /// The directory of the shrunk cases; it need not exist.
    pub fn failures(&self) -> PathBuf {
        self.path.join(FAILURES)
    }

    /// Every record so far, in the order of the file. Each is a case of the manifest, and none comes twice.
    ///
    /// # Errors
    /// At the first line that is not so.
    pub fn each_record(&self, mut each: impl FnMut(usize, Record)) -> Result<Vec<Done>, StoreError> {
        let path = self.path.join(RESULTS);
        let place = self.manifest.places();
        let mut done = vec![Done::new(self.manifest.shard()); self.manifest.laws.len()];
        each_line(&path, |text| {
            let record: Record = serde_json::from_slice(text).map_err(|error| error.to_string())?;
            let (law, index) = (&record.law, record.index);
            let position = place(law, index)?;
            if !done[position].insert(index) {
                return Err(format!("case {index} of {law} for the second time"));
            }
            each(position, record);
            Ok(())
        })?;
        Ok(done)
    }

    /// What is known so far, for [`Campaign::resume`](super::Campaign::resume) with the same laws.
    ///
    /// # Errors
    /// Where the laws are not those of the manifest, or at the first line that a campaign cannot have written.
    pub fn recorded<C>(&self, laws: &[&dyn Law<C>]) -> Result<Recorded<C>, StoreError> {
        let names: Vec<&str> = laws.iter().map(|law| law.name()).collect();
        if !self.manifest.laws.iter().map(|law| law.name.as_str()).eq(names.iter().copied()) {
            let differences = vec![format!("the laws here are {}", names.join(", "))];
            return Err(StoreError::Differs { path: self.path.clone(), differences });
        }
        let mut summaries: Vec<_> = laws.iter().map(|law| Summary::new(law.name())).collect();
        let done = self.each_record(|law, record| summaries[law].record(&record, 0.0))?;
        let place = self.manifest.places();
        each_line(&self.path.join(TIMINGS), |text| {
            let timing: Timing = serde_json::from_slice(text).map_err(|error| error.to_string())?;
            summaries[place(&timing.law, timing.index)?].seconds += timing.seconds;
            Ok(())
        })?;
        Ok(Recorded { done, laws: summaries })
    }

    /// Appends to the campaign.
    ///
    /// # Errors
    /// What the system says.
    pub fn writer(&self) -> Result<Writer, StoreError> {
        let open = |name: &str| {
            let path = self.path.join(name);
            let file = OpenOptions::new().append(true).create(true).open(&path).map_err(StoreError::io(&path))?;
            Ok(Output { path, file })
        };
        Ok(Writer { outputs: Mutex::new(Ok([open(RESULTS)?, open(TIMINGS)?])) })
    }

    /// Puts the records and the times into canonical order, each file by one atomic replacement.
    ///
    /// # Errors
    /// Lines that are no records of the campaign, or what the system says.
    pub fn sort(&self) -> Result<(), StoreError> {
        canonical::write(&[&self.path], &self.manifest, &self.path)
    }
}

fn try_lock(file: &File, path: &Path) -> Result<(), StoreError> {
    file::lock(file).map_err(|_| StoreError::InUse { path: path.to_owned() })
}

/// Gives every line to `each`, which says what is wrong with it; none where there is no file. A last line has to end, too.
fn each_line(path: &Path, mut each: impl FnMut(&[u8]) -> Result<(), String>) -> Result<(), StoreError> {
    let mut damaged = Ok(());
    let torn = || "it does not end, because a run was killed there; --resume goes on".to_owned();
    lines(path, |line, text, ended| {
        let sound = if ended { each(text) } else { Err(torn()) };
        damaged = sound.map_err(|reason| StoreError::Damaged { path: path.to_owned(), line, reason });
        damaged.is_ok()
    })
    .map_err(StoreError::io(path))?;
    damaged
}

/// Gives the lines of a file to `each` as long as it says that it goes on: the number, from 1, the text, and whether the line has an
/// end. False where there is no file.
///
/// # Errors
/// What the system says.
pub fn lines(path: &Path, mut each: impl FnMut(usize, &[u8], bool) -> bool) -> io::Result<bool> {
    let mut reader = match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
        file => BufReader::with_capacity(1 << 16, file?),
    };
    let (mut text, mut line) = (Vec::new(), 0);
    while reader.read_until(b'\n', &mut text)? > 0 {
        line += 1;
        let whole = text.strip_suffix(b"\n");
        if !each(line, whole.unwrap_or(&text), whole.is_some()) {
            break;
        }
        text.clear();
    }
    Ok(true)
}

/// Cuts off what follows the last line's end. A line is written with its end at once, so that is what a kill may leave.
fn cut_torn_line(path: &Path) -> Result<(), StoreError> {
    let mut kept = 0;
    let there = lines(path, |_, text, ended| {
        kept += if ended { text.len() as u64 + 1 } else { 0 };
        true
    });
    let cut =
        there.and_then(|there| if there { File::options().write(true).open(path)?.set_len(kept) } else { Ok(()) });
    cut.map_err(StoreError::io(path))
}

struct Output {
    path: PathBuf,
    file: File,
}

impl Output {
    fn append(&mut self, line: &[u8]) -> Result<(), StoreError> {
        self.file.write_all(line).map_err(StoreError::io(&self.path))
    }
}

/// Appends records, each in one piece; the first failure is kept and ends the campaign.
pub struct Writer {
    /// The records and the times, or what went wrong.
    outputs: Mutex<Result<[Output; 2], StoreError>>,
}

impl Writer {
    /// Waits until everything is on the disk.
    ///
    /// # Errors
    /// The first that was met, while writing or now.
    pub fn finish(self) -> Result<(), StoreError> {
        let outputs = self.outputs.into_inner().unwrap_or_else(PoisonError::into_inner)?;
        outputs.iter().try_for_each(|output| output.file.sync_all().map_err(StoreError::io(&output.path)))
    }
}

impl Sink for Writer {
    fn record(&self, record: &Record, seconds: Option<f64>) -> bool {
        // The lines are made before the lock is taken. A record of texts and numbers serialises.
        let line = json_line(record);
        let time = seconds.map(|seconds| json_line(&Timing { law: record.law.clone(), index: record.index, seconds }));
        let mut outputs = self.outputs.lock().unwrap_or_else(PoisonError::into_inner);
        let Ok([results, timings]) = &mut *outputs else { return false };
        // The time second: without it a record still counts.
        let written = results.append(&line).and_then(|()| time.map_or(Ok(()), |time| timings.append(&time)));
        if let Err(error) = written {
            *outputs = Err(error);
        }
        outputs.is_ok()
    }
}

fn json_line(value: &impl Serialize) -> Vec<u8> {
    let mut line = serde_json::to_vec(value).unwrap_or_default();
    line.push(b'\n');
    line
}
