//! The files of a campaign, as they are: what is damaged, repeated or not there is counted and told.

use super::super::faults::Caught;
use super::super::{Failure, program};
use super::tally::Tally;
use euler_poincare::harness::Record;
use euler_poincare::harness::store::{FAILURES, Manifest, ManifestLaw, RESULTS, Store, StoreError, lines};
use euler_poincare::laws::replay::{read, records};
use euler_poincare::system::{Case, Replay};
use serde::de::DeserializeOwned;
use std::path::{Path, PathBuf};

const FAULTS: &str = "faults.jsonl";

/// Lines that cannot be used.
#[derive(Clone, Debug, Default)]
pub struct Damage {
    /// How many.
    pub lines: usize,
    /// The first of them: number and reason.
    pub first: Vec<(usize, String)>,
    /// Rows of cases that were there already.
    pub repeated: usize,
    /// Whether the last line has no end: the writer was killed, or is still at it.
    pub torn: bool,
}

impl Damage {
    fn add(&mut self, line: usize, reason: impl ToString) {
        self.lines += 1;
        if self.first.len() < 5 {
            self.first.push((line, reason.to_string()));
        }
    }
}

/// A failing case on file.
pub struct Saved {
    /// The file, within the campaign's directory.
    pub file: String,
    /// What is in it, or why it cannot be used.
    pub replay: Result<Replay, String>,
}

/// What a directory holds.
pub struct Found {
    /// The campaign.
    pub manifest: Manifest,
    /// Whether it was not run by this program.
    pub another_program: bool,
    /// Whether another process is writing.
    pub running: bool,
    /// What each of its laws showed, in its order.
    pub tallies: Vec<Tally>,
    /// Whether there are results at all.
    pub started: bool,
    /// Of the results.
    pub damage: Damage,
    /// The planted faults, if they were tried.
    pub faults: Option<Vec<Caught>>,
    /// Of the faults.
    pub fault_damage: Damage,
    /// The failing cases on file, by name.
    pub failures: Vec<Saved>,
}

impl Found {
    /// Reads a campaign's directory.
    ///
    /// # Errors
    /// No such directory, no campaign in it, a file that cannot be read, or results of which no line is a result.
    pub fn read(directory: &Path) -> Result<Self, Failure> {
        if !directory.is_dir() {
            let reason = if directory.exists() { "is not a directory" } else { "there is no such directory" };
            return Err(Failure::file(directory, reason));
        }
        let manifest = Manifest::read(directory)?;
        let here = program::manifest::<Case>(manifest.seed, None, &[])?;
        // The lock is let go at once.
        let running = matches!(Store::open(directory), Err(StoreError::InUse { .. }));
        let mut tallies: Vec<Tally> = manifest.laws.iter().map(|_| Tally::new(manifest.shard())).collect();
        let results = results(&directory.join(RESULTS), &manifest, &mut tallies)?;
        let mut faults = Vec::new();
        let fault_damage = rows(&directory.join(FAULTS), |fault: Caught, _| {
            faults.push(fault);
            Ok(())
        })?;
        Ok(Self {
            another_program: !manifest.program_differences(&here).is_empty(),
            running,
            tallies,
            started: results.is_some(),
            damage: results.unwrap_or_default(),
            faults: fault_damage.is_some().then_some(faults),
            fault_damage: fault_damage.unwrap_or_default(),
            failures: failures(&directory.join(FAILURES))?,
            manifest,
        })
    }

    /// How many cases there should be; `None` where no number was asked for.
    pub fn planned(&self) -> Option<usize> {
        self.manifest.laws.iter().map(|law| planned(&self.manifest, law)).sum()
    }

    /// Laws with what they showed.
    pub fn laws(&self) -> impl Iterator<Item = (&ManifestLaw, &Tally)> {
        self.manifest.laws.iter().zip(&self.tallies)
    }
}

/// How many of the cases of a law are in the campaign; `None` where no number was asked for.
pub fn planned(manifest: &Manifest, law: &ManifestLaw) -> Option<usize> {
    Some(manifest.shard().size(law.cases?))
}

/// Gives each row of a file to `take`, which says what is wrong with it; `None` without a file.
fn rows<T: DeserializeOwned>(
    path: &Path,
    mut take: impl FnMut(T, &mut Damage) -> Result<(), String>,
) -> Result<Option<Damage>, Failure> {
    let mut damage = Damage::default();
    let there = lines(path, |number, line, ended| {
        if !ended {
            // Even if it reads well: what a writer has not ended is not said.
            damage.torn = true;
        } else if !line.trim_ascii().is_empty() {
            let row = serde_json::from_slice(line).map_err(|error| error.to_string());
            if let Err(reason) = row.and_then(|row| take(row, &mut damage)) {
                damage.add(number, reason);
            }
        }
        true
    });
    Ok(there.map_err(|error| Failure::file(path, error))?.then_some(damage))
}

fn results(path: &Path, manifest: &Manifest, tallies: &mut [Tally]) -> Result<Option<Damage>, Failure> {
    let place = manifest.places();
    let damage = rows(path, |record: Record, damage| {
        if !tallies[place(&record.law, record.index)?].add(&record) {
            damage.repeated += 1;
        }
        Ok(())
    })?;
    if let Some(damage) = &damage
        && damage.lines > 0
        && tallies.iter().all(|tally| tally.found.cases == 0)
    {
        let (line, reason) = damage.first.first().cloned().unwrap_or_default();
        return Err(Failure::file(path, format!("no line is a result of this campaign; line {line}: {reason}")));
    }
    Ok(damage)
}

fn failures(directory: &Path) -> Result<Vec<Saved>, Failure> {
    let paths = records(directory).map_err(|error| Failure::file(directory, error))?;
    let saved = |path: PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Saved { file: format!("{FAILURES}/{name}"), replay: read(&path) }
    };
    Ok(paths.into_iter().map(saved).collect())
}
