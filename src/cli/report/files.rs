//! The files of a campaign, as they are: what is damaged, repeated or not there is counted and told.

use super::super::Failure;
use super::tally::{Outcome, Tally};
use euler_poincare::system::Replay;
use serde::Deserialize;
use std::borrow::Cow;
use std::collections::{BTreeMap, HashMap};
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader};
use std::path::Path;

/// The file that makes a directory a campaign.
const MANIFEST: &str = "campaign.json";
const RESULTS: &str = "results.jsonl";
const TIMINGS: &str = "timings.jsonl";
const FAULTS: &str = "faults.jsonl";
const FAILURES: &str = "failures";

/// What the campaign is.
#[derive(Debug, Deserialize)]
pub struct Manifest {
    /// Of the program that ran it.
    pub version: String,
    /// A hash of that program.
    pub binary: String,
    /// Of the cases.
    pub seed: u64,
    /// Per cheap law; `None`: as many as the time allowed.
    pub cases: Option<usize>,
    /// In their order.
    pub laws: Vec<Planned>,
    /// The fault that is planted.
    #[serde(default)]
    pub plant: Option<String>,
    /// i of n.
    #[serde(default)]
    pub shard: Option<[usize; 2]>,
}

impl Manifest {
    /// How many of the cases of a law are in this shard.
    pub fn planned(&self, law: &Planned) -> Option<usize> {
        let [index, count] = self.shard.unwrap_or([0, 1]);
        Some(law.cases?.saturating_sub(index).div_ceil(count.max(1)))
    }

    /// Whether the case is one of the campaign's.
    fn owns(&self, law: &Planned, index: usize) -> bool {
        let [i, n] = self.shard.unwrap_or([0, 1]);
        index % n.max(1) == i && law.cases.is_none_or(|cases| index < cases)
    }
}

/// A law of the campaign.
#[derive(Debug, Deserialize)]
pub struct Planned {
    /// Its name.
    pub name: String,
    /// How many cases it has, in all shards.
    pub cases: Option<usize>,
}

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

/// Seconds that the checks of a law took.
#[derive(Clone, Copy, Debug, Default)]
pub struct Time {
    /// Checks that were timed.
    pub checks: usize,
    /// Their sum.
    pub total: f64,
    /// The longest.
    pub longest: f64,
}

/// A planted fault, and after how many cases it was caught.
#[derive(Debug, Deserialize)]
pub struct Caught {
    /// The law that should see it.
    pub law: String,
    /// Its name.
    pub fault: String,
    /// `None`: not at all.
    pub caught_after: Option<usize>,
    /// The smallest size at which it still is.
    #[serde(default)]
    pub smallest_size: Option<f64>,
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
    /// What each of its laws showed, in its order.
    pub tallies: Vec<Tally>,
    /// Whether there are results at all.
    pub started: bool,
    /// Of the results.
    pub damage: Damage,
    /// By law, if there are timings.
    pub times: Option<BTreeMap<String, Time>>,
    /// Of the timings.
    pub time_damage: Damage,
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
        let manifest = manifest(directory)?;
        let mut tallies: Vec<Tally> = manifest.laws.iter().map(|_| Tally::new()).collect();
        let results = results(&directory.join(RESULTS), &manifest, &mut tallies)?;
        let times = times(&directory.join(TIMINGS))?;
        let faults = faults(&directory.join(FAULTS))?;
        let (times, time_damage) = times.map_or((None, Damage::default()), |(times, damage)| (Some(times), damage));
        let (faults, fault_damage) =
            faults.map_or((None, Damage::default()), |(faults, damage)| (Some(faults), damage));
        Ok(Self {
            tallies,
            started: results.is_some(),
            damage: results.unwrap_or_default(),
            times,
            time_damage,
            faults,
            fault_damage,
            failures: failures(&directory.join(FAILURES))?,
            manifest,
        })
    }

    /// How many cases there should be; `None` where no number was asked for.
    pub fn planned(&self) -> Option<usize> {
        self.manifest.laws.iter().map(|law| self.manifest.planned(law)).sum()
    }

    /// How many there are.
    pub fn done(&self) -> usize {
        self.tallies.iter().map(|tally| tally.cases).sum()
    }

    /// Laws with what they showed.
    pub fn laws(&self) -> impl Iterator<Item = (&Planned, &Tally)> {
        self.manifest.laws.iter().zip(&self.tallies)
    }
}

fn manifest(directory: &Path) -> Result<Manifest, Failure> {
    let path = directory.join(MANIFEST);
    let text = fs::read_to_string(&path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => {
            Failure::file(directory, format!("no campaign: there is no {MANIFEST}; `verify --out DIR` makes one"))
        }
        _ => Failure::file(&path, error),
    })?;
    serde_json::from_str(&text).map_err(|error| Failure::file(&path, error))
}

/// A file that may not be there.
fn open(path: &Path) -> Result<Option<BufReader<File>>, Failure> {
    match File::open(path) {
        Ok(file) => Ok(Some(BufReader::with_capacity(1 << 18, file))),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(Failure::file(path, error)),
    }
}

/// Gives each line of a file to `take`, which says what is wrong with it; `None` without a file.
fn lines(path: &Path, mut take: impl FnMut(&[u8], &mut Damage) -> Result<(), String>) -> Result<Option<Damage>, Failure> {
    let Some(mut file) = open(path)? else { return Ok(None) };
    let (mut damage, mut line, mut number) = (Damage::default(), Vec::new(), 0);
    loop {
        line.clear();
        if file.read_until(b'\n', &mut line).map_err(|error| Failure::file(path, error))? == 0 {
            return Ok(Some(damage));
        }
        number += 1;
        if line.last() != Some(&b'\n') {
            // Even if it reads well: what a writer has not ended is not said.
            damage.torn = true;
        } else if !line.trim_ascii().is_empty()
            && let Err(reason) = take(&line, &mut damage)
        {
            damage.add(number, reason);
        }
    }
}

/// Text that is borrowed from its line wherever it can be.
#[derive(Deserialize, PartialEq, Eq, PartialOrd, Ord)]
struct Text<'a>(#[serde(borrow)] Cow<'a, str>);

/// A line of the results.
#[derive(Deserialize)]
struct Row<'a> {
    #[serde(borrow)]
    law: Cow<'a, str>,
    index: usize,
    #[serde(borrow)]
    verdict: Cow<'a, str>,
    defect: Option<f64>,
    bound: Option<f64>,
    #[serde(borrow)]
    why: Option<Text<'a>>,
    #[serde(borrow)]
    witness: Option<Text<'a>>,
    #[serde(borrow, default)]
    labels: BTreeMap<Text<'a>, Text<'a>>,
    #[serde(borrow, default)]
    rejections: BTreeMap<Text<'a>, usize>,
}

impl Row<'_> {
    fn outcome(&self) -> Result<Outcome<'_>, String> {
        let why = || self.why.as_ref().map(|why| why.0.as_ref()).ok_or("a verdict without a reason");
        // JSON has no other way to write what is not finite.
        let (defect, bound) = (self.defect.unwrap_or(f64::INFINITY), self.bound.unwrap_or(f64::NAN));
        Ok(match self.verdict.as_ref() {
            "holds" if self.defect.is_none() || self.bound.is_none() => return Err("holds without numbers".into()),
            "holds" => Outcome::Holds(defect, bound),
            "broken" => Outcome::Broken(defect, bound, self.witness.as_ref().map_or("", |witness| witness.0.as_ref())),
            "inconclusive" => Outcome::Inconclusive(why()?),
            "not applicable" => Outcome::NotApplicable(why()?),
            other => return Err(format!("no such verdict: {other:?}")),
        })
    }
}

fn results(path: &Path, manifest: &Manifest, tallies: &mut [Tally]) -> Result<Option<Damage>, Failure> {
    let places: HashMap<&str, usize> = manifest.laws.iter().enumerate().map(|(k, law)| (law.name.as_str(), k)).collect();
    let damage = lines(path, |line, damage| {
        let row: Row<'_> = serde_json::from_slice(line).map_err(|error| error.to_string())?;
        let place = *places.get(row.law.as_ref()).ok_or_else(|| format!("the campaign has no law {:?}", row.law))?;
        let (tally, outcome) = (&mut tallies[place], row.outcome()?);
        if !manifest.owns(&manifest.laws[place], row.index) {
            return Err(format!("case {} of {} is not one of the campaign", row.index, row.law));
        }
        if !tally.visit(row.index) {
            damage.repeated += 1;
            return Ok(());
        }
        tally.add(row.index, &outcome);
        let judged = matches!(outcome, Outcome::Holds(..) | Outcome::Broken(..));
        for (category, labels) in &row.labels {
            // Several forces are one text.
            labels.0.split('+').for_each(|label| tally.label(&category.0, label, judged));
        }
        row.rejections.iter().for_each(|(reason, number)| tally.reject(&reason.0, *number));
        Ok(())
    })?;
    if let Some(damage) = &damage
        && damage.lines > 0
        && tallies.iter().all(|tally| tally.cases == 0)
    {
        let (line, reason) = damage.first.first().cloned().unwrap_or_default();
        return Err(Failure::file(path, format!("no line is a result of this campaign; line {line}: {reason}")));
    }
    Ok(damage)
}

type Times = BTreeMap<String, Time>;

fn times(path: &Path) -> Result<Option<(Times, Damage)>, Failure> {
    #[derive(Deserialize)]
    struct Line<'a> {
        #[serde(borrow)]
        law: Cow<'a, str>,
        seconds: f64,
    }
    let mut times = Times::new();
    let damage = lines(path, |line, _| {
        let Line { law, seconds } = serde_json::from_slice(line).map_err(|error| error.to_string())?;
        if !times.contains_key(law.as_ref()) {
            times.insert(law.to_string(), Time::default());
        }
        if let Some(time) = times.get_mut(law.as_ref()) {
            time.checks += 1;
            time.total += seconds;
            time.longest = time.longest.max(seconds);
        }
        Ok(())
    })?;
    Ok(damage.map(|damage| (times, damage)))
}

fn faults(path: &Path) -> Result<Option<(Vec<Caught>, Damage)>, Failure> {
    let mut faults = Vec::new();
    let damage = lines(path, |line, _| {
        faults.push(serde_json::from_slice(line).map_err(|error| error.to_string())?);
        Ok(())
    })?;
    Ok(damage.map(|damage| (faults, damage)))
}

fn failures(directory: &Path) -> Result<Vec<Saved>, Failure> {
    let entries = match fs::read_dir(directory) {
        Ok(entries) => entries,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(Failure::file(directory, error)),
    };
    let mut names = Vec::new();
    for entry in entries {
        let name = entry.map_err(|error| Failure::file(directory, error))?.file_name();
        let name = name.to_string_lossy().into_owned();
        // Not what a writer has not put in its place yet.
        if name.ends_with(".json") && !name.starts_with('.') {
            names.push(name);
        }
    }
    names.sort_unstable();
    let saved = |name: String| {
        let text = fs::read_to_string(directory.join(&name)).map_err(|error| error.to_string());
        let replay = text.and_then(|text| Replay::from_json(&text).map_err(|error| error.to_string()));
        Saved { file: format!("{FAILURES}/{name}"), replay }
    };
    Ok(names.into_iter().map(saved).collect())
}
