//! A saved case under its law again: the verdict, what was measured at each precision, and all of it as text.
//!
//! A [`Replay`] is the record of a failure. [`Replayed`] judges it; records kept in a directory are replayed by [`replay_all`],
//! and a directory of them is a list of regressions: a case that once broke a law must not break it again, and a case on which a
//! planted fault was caught must still show it.

use super::trial::{Digits, Judged};
use super::{CaseLaw, PlantedLaw, all, named};
use crate::expression::nearest;
use crate::file;
use crate::harness::convergence::{Estimate, LevelKind};
use crate::harness::evidence::{Evidence, gather};
use crate::harness::{Fault, Law, Shrunk, Verdict, parallel, shrink_from, verdict_on};
use crate::scalar::{Dd, Scalar};
use crate::system::{Case, CaseError, Replay};
use crate::tableau::variational_order;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::{fmt, fs, io};

/// Where records are kept, in a checkout of this crate.
pub const REGRESSIONS: &str = "snapshots/regressions";

/// The largest number of names shown as near to an unknown one.
const NEAREST: usize = 3;

/// Why a record cannot be replayed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReplayError {
    /// It is malformed, or its case cannot be built.
    #[error("{0}")]
    Case(CaseError),
    /// It is a case of a suite on a user's types.
    #[error(
        "a case of the suite {module}, on its user's types: run it again with EULER_POINCARE_REPLAY=FILE cargo test"
    )]
    Suite {
        /// The module of the suite.
        module: String,
    },
    /// There is no such law.
    #[error("law: is \"{found}\"; near to it: {near}; `euler-poincare laws` lists all")]
    Law {
        /// The name in the record.
        found: String,
        /// The laws whose names are most like it.
        near: String,
    },
    /// The law knows no such fault.
    #[error("fault: is \"{found}\"; allowed for {law}: {allowed}")]
    Fault {
        /// The name in the record.
        found: String,
        /// The law.
        law: &'static str,
        /// The faults that it knows.
        allowed: String,
    },
}

/// A record, judged.
#[derive(Clone)]
#[non_exhaustive]
pub struct Replayed {
    /// The law.
    pub law: &'static CaseLaw,
    /// The fault that was planted.
    pub fault: Option<&'static Fault>,
    /// The record.
    pub replay: Replay,
    /// The verdict.
    pub verdict: Verdict,
    /// What was measured; at two precisions where the law is an identity.
    pub evidence: Vec<Evidence>,
}

/// The law and the fault that a record names.
fn parts(replay: &Replay) -> Result<(&'static CaseLaw, Option<&'static Fault>), ReplayError> {
    let law = named(&replay.law).ok_or_else(|| {
        let near = nearest(&replay.law, all().iter().map(|law| law.about.name), NEAREST).join(", ");
        ReplayError::Law { found: replay.law.clone(), near }
    })?;
    let fault = replay.fault.as_deref().map(|found| {
        law.fault(found).ok_or_else(|| {
            let names: Vec<_> = law.about.faults.iter().map(|fault| fault.name).collect();
            let allowed = if names.is_empty() { "none".into() } else { names.join(", ") };
            ReplayError::Fault { found: found.into(), law: law.about.name, allowed }
        })
    });
    Ok((law, fault.transpose()?))
}

impl Replayed {
    /// The record in a JSON text, judged as [`Replayed::of`] does.
    ///
    /// # Errors
    /// A text that is no record, a case that cannot be built, an unknown law or fault.
    pub fn from_json(text: &str, digits: Option<u32>) -> Result<Self, ReplayError> {
        match Replay::module_of(text) {
            Some(module) => Err(ReplayError::Suite { module }),
            None => Self::of(Replay::from_json(text).map_err(ReplayError::Case)?, digits),
        }
    }

    /// The record, judged; by the arithmetic of `digits` decimal digits alone where they are given.
    ///
    /// # Errors
    /// An unknown law or fault, or a record of a suite.
    pub fn of(replay: Replay, digits: Option<u32>) -> Result<Self, ReplayError> {
        if let Some(module) = replay.module {
            return Err(ReplayError::Suite { module });
        }
        let (law, fault) = parts(&replay)?;
        let (verdict, evidence) = judged(law, fault, &replay.case, digits);
        Ok(Self { law, fault, replay, verdict, evidence })
    }

    /// The same law on the simplest case that still breaks it, found with at most `checks` checks; `None` where it holds on
    /// this one. Of the record nothing changes but the case.
    pub fn shrunk(&self, digits: Option<u32>, checks: usize) -> Option<(Self, Shrunk<Case>)> {
        let subject = PlantedLaw { law: self.law, fault: self.fault, digits };
        let shrunk = shrink_from(&subject, None, &self.replay.case, checks)?;
        let replay = Replay { case: shrunk.case.clone(), ..self.replay.clone() };
        Some((Self::of(replay, digits).ok()?, shrunk))
    }

    /// Whether a kept record is as it should be: the law not broken, or broken where a fault is planted.
    pub fn passes(&self) -> bool {
        self.verdict.is_broken() == self.fault.is_some()
    }

    /// What there is to say but for the case itself: names and texts.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let law = self.law;
        let mut rows = vec![
            ("law", format!("{}: {}", law.about.name, law.about.statement)),
            ("source", law.about.source.to_owned()),
        ];
        rows.extend(self.fault.map(|fault| ("planted", format!("{}: {}", fault.name, fault.what))));
        rows.extend(self.measured());
        rows.push(("case", format!("from case {} of seed {}", self.replay.index, self.replay.seed)));
        rows
    }

    /// The verdict and what was measured: names and texts.
    pub fn measured(&self) -> Vec<(&'static str, String)> {
        let mut rows = verdict_rows(&self.verdict);
        rows.extend(self.evidence.iter().map(evidence_row));
        rows
    }
}

/// The whole of it: what was judged and measured, and the case.
impl fmt::Display for Replayed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (name, text) in self.rows() {
            writeln!(f, "{name:<11}{text}")?;
        }
        f.write_str(&indented(&self.replay.case.to_string()))
    }
}

/// `text` with every line two columns in, but for empty ones.
pub fn indented(text: &str) -> String {
    let moved = |line: &str| if line.is_empty() { String::new() } else { format!("  {line}") };
    text.lines().map(moved).collect::<Vec<_>>().join("\n")
}

/// What a verdict says, as named lines.
pub fn verdict_rows(verdict: &Verdict) -> Vec<(&'static str, String)> {
    let numbers = |word: &str, defect: f64, bound: f64| {
        let ratio = verdict.ratio().unwrap_or(f64::INFINITY);
        ("verdict", format!("{word}: defect {defect:.3e}, bound {bound:.3e}, ratio {ratio:.2e}"))
    };
    match verdict {
        Verdict::Holds { defect, bound } => vec![numbers("holds", *defect, *bound)],
        Verdict::Broken { defect, bound, witness } => {
            vec![numbers("broken", *defect, *bound), ("witness", witness.clone())]
        }
        Verdict::Inconclusive { why } => vec![("verdict", format!("inconclusive: {why}"))],
        Verdict::NotApplicable { why } => vec![("verdict", format!("not applicable: {why}"))],
    }
}

/// The unit round-off of the arithmetic of `digits` digits.
fn unit(digits: u32) -> f64 {
    match digits {
        16 => f64::unit_roundoff(),
        _ => Dd::unit_roundoff().to_f64(),
    }
}

/// What was measured, as a named line.
pub(super) fn evidence_row(evidence: &Evidence) -> (&'static str, String) {
    let name = match evidence.digits() {
        16 => "16 digits",
        _ => "32 digits",
    };
    let text = match evidence {
        Evidence::Defect { digits, defect, bound, .. } => {
            let (u, above) = (unit(*digits), if defect > bound { "ABOVE" } else { "within" });
            format!("defect {defect:.3e} u, {above} the bound {bound:.3e} u (u = {u:.1e}: {:.1e} relative)", defect * u)
        }
        Evidence::Levels { quantity, levels, kinds, estimate, expected, .. } => {
            let slope = match estimate {
                Estimate::Slope { value, low, high, .. } => format!("slope {value:.3} in [{low:.3}, {high:.3}]"),
                Estimate::Inconclusive { why, .. } => format!("no slope ({why})"),
            };
            let predicted = expected.map(|order| format!(", predicted {order}")).unwrap_or_default();
            let count = |kind: LevelKind| kinds.iter().filter(|k| **k == kind).count();
            let coarsest = levels.iter().map(|level| level.h).fold(0.0, f64::max);
            let finest = levels.iter().map(|level| level.h).fold(f64::INFINITY, f64::min);
            format!(
                "{quantity}: {slope}{predicted}; steps {coarsest:.1e} to {finest:.1e}: {} before the line, {} on it, {} noise",
                count(LevelKind::PreAsymptotic),
                count(LevelKind::Asymptotic),
                count(LevelKind::Noise),
            )
        }
    };
    (name, text)
}

/// The verdict of `law`, and what was measured; both in the arithmetic of `digits` decimal digits alone, if given.
pub fn judged(law: &CaseLaw, fault: Option<&Fault>, case: &Case, digits: Option<u32>) -> (Verdict, Vec<Evidence>) {
    let (verdict, evidence) = gather(|| verdict_on(law, case, fault));
    let Some(digits) = digits else { return (verdict, evidence) };
    let (evidence, others): (Vec<_>, Vec<_>) = evidence.into_iter().partition(|one| one.digits() == digits);
    // What broke without a measurement is in no evidence: then the verdict stands.
    let unmeasured = verdict.measured().is_some_and(|(defect, bound)| defect.is_infinite() && bound == 0.0);
    let Some(other) = others.first().filter(|_| !unmeasured) else { return (verdict, evidence) };
    let alone = evidence.iter().filter_map(|one| match one {
        Evidence::Defect { defect, alone, witness, .. } => {
            Some(Verdict::judge(*defect, *alone, || format!("{defect:.3e} units of round-off; {witness}")))
        }
        Evidence::Levels { .. } => None,
    });
    match alone.reduce(Verdict::and) {
        Some(verdict) => (verdict, evidence),
        None => elsewhere(law, fault, case, digits, other.digits()),
    }
}

/// The laws that a trial of the case's tableau judges as well, and whether a higher order will do.
const TRIED: [&str; 2] = ["order-momentum-attitude", "order-predicted"];

/// The verdict in digits in which the law itself is not measured: of an order, by a trial over 8 steps.
fn elsewhere(
    law: &CaseLaw,
    fault: Option<&Fault>,
    case: &Case,
    digits: u32,
    measured: u32,
) -> (Verdict, Vec<Evidence>) {
    let arithmetic = match digits {
        16 => Some(Digits::Sixteen),
        32 => Some(Digits::ThirtyTwo),
        _ => None,
    };
    let (Some(arithmetic), true, None) = (arithmetic, TRIED.contains(&law.about.name), fault) else {
        return (Verdict::inconclusive(format!("this law is measured in {measured} digits alone")), Vec::new());
    };
    let tried = || -> Result<(Verdict, Vec<Evidence>), String> {
        let tableau = case.method.tableau.build::<Dd>().map_err(|error| error.to_string())?;
        let order = variational_order(&tableau, 10).order as u32;
        let horizon = 8.0 * case.step.eval::<f64>().map_err(|error| error.to_string())?;
        let judged = Judged::of(case, arithmetic, horizon, order, false).map_err(|error| error.to_string())?;
        let (over, down) = (&judged.trial.horizon, &judged.trial.descent);
        let mut evidence = over.evidence(order, digits, ", over the horizon");
        evidence.extend(down.evidence(order, digits, ", with steps that shrink"));
        Ok((judged.verdict, evidence))
    };
    tried().unwrap_or_else(|why| (Verdict::broken(why), Vec::new()))
}

/// The name of a record's file: law, planted fault, seed, index.
pub fn file_name(replay: &Replay) -> String {
    let fault = replay.fault.as_ref().map(|fault| format!("-{fault}")).unwrap_or_default();
    format!("{}{fault}-seed{}-case{}.json", replay.law, replay.seed, replay.index)
}

/// Writes the record into `directory`, which is made if it is not there; the path of the file.
///
/// # Errors
/// Those of the file system.
pub fn save(directory: &Path, replay: &Replay) -> io::Result<PathBuf> {
    save_as(directory, &file_name(replay), replay)
}

/// The same under another name.
///
/// # Errors
/// Those of the file system.
pub fn save_as<C: Serialize>(directory: &Path, name: &str, replay: &Replay<C>) -> io::Result<PathBuf> {
    let text = replay.to_json().map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
    if !directory.as_os_str().is_empty() {
        fs::create_dir_all(directory)?;
    }
    let path = directory.join(name);
    file::write(&path, text + "\n")?;
    Ok(path)
}

/// A record that is kept, replayed.
#[non_exhaustive]
pub struct Kept {
    /// Its file.
    pub path: PathBuf,
    /// What it shows now; the reason where it cannot be read.
    pub outcome: Result<Replayed, String>,
}

impl Kept {
    /// Whether it can be read and is as it should be, see [`Replayed::passes`].
    pub fn passes(&self) -> bool {
        self.outcome.as_ref().is_ok_and(Replayed::passes)
    }
}

/// The records (`*.json`) in a directory, in the order of their names; none where there is no such directory.
///
/// # Errors
/// A directory that cannot be listed.
pub fn records(directory: &Path) -> io::Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(directory) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        entries => entries?,
    };
    let mut paths = entries.map(|entry| Ok(entry?.path())).collect::<io::Result<Vec<PathBuf>>>()?;
    // Not what a writer has not put in its place yet.
    paths.retain(|path| {
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        name.ends_with(".json") && !name.starts_with('.')
    });
    paths.sort();
    Ok(paths)
}

/// The record in a file, or why there is none.
///
/// # Errors
/// A file that cannot be read or is no record, as text.
pub fn read(path: &Path) -> Result<Replay, String> {
    let text = file::read(path, file::LONGEST).map_err(|error| error.to_string())?;
    Replay::from_json(&text).map_err(|error| error.to_string())
}

/// Replays the [`records`] in `directory` whose law `wanted` names, in the order of their names, on the threads of the
/// rayon pool; none where there is no such directory.
///
/// # Errors
/// A directory that cannot be listed. A record that cannot be read is an outcome.
pub fn replay_all(directory: &Path, wanted: impl Fn(&str) -> bool + Sync) -> io::Result<Vec<Kept>> {
    let paths = records(directory)?;
    let replayed = |k: usize| {
        let path = paths[k].clone();
        let replay = read(&path);
        if replay.as_ref().is_ok_and(|replay| named(&replay.law).is_some() && !wanted(&replay.law)) {
            return None;
        }
        let judged = |replay| Replayed::of(replay, None).map_err(|error| error.to_string());
        Some(Kept { path, outcome: replay.and_then(judged) })
    };
    Ok(parallel(paths.len(), replayed).into_iter().flatten().collect())
}
