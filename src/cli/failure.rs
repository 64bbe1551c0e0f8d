//! What is said of a broken law: of a campaign, of a saved case, of the regressions.

use super::Failure;
use super::table::{entries, paragraph};
use euler_poincare::laws::replay::{Kept, REGRESSIONS, Replayed, replay_all, verdict_rows};
use euler_poincare::system::{Case, Replay};
use std::path::Path;

/// A judged record in full: law, source, verdict, what was measured at each precision, the case, and how to replay it.
pub fn text(replayed: &Replayed, file: Option<&Path>) -> String {
    let case = system(2, &replayed.replay.case);
    let again = file.map(|path| format!("\nreplay it\n  euler-poincare replay {}\n", quoted(path))).unwrap_or_default();
    format!("{}\n{case}\n{again}", entries(0, replayed.rows()))
}

/// A shrunk failure of a campaign: judged once more, for what was measured.
pub fn campaign(replay: &Replay, checks: usize, saved: Result<&Path, &str>) -> String {
    let (seed, index) = (replay.seed, replay.index);
    let heading = format!("  case {index} of seed {seed}, shrunk by {checks} checks\n");
    let case = system(4, &replay.case);
    let measured = measured(replay, Replayed::measured);
    let saved = match saved {
        Ok(path) => {
            let name = quoted(path);
            format!("  saved in\n    {name}\n  run it again with\n    euler-poincare replay {name}\n")
        }
        Err(reason) => paragraph(&format!("  not saved: {reason}\n")),
    };
    format!("{measured}\n{heading}{case}\n{saved}")
}

/// The same in short: the verdict, and the command that prints the rest.
pub fn brief(replay: &Replay, saved: Result<&Path, &str>) -> String {
    let measured = measured(replay, |replayed| verdict_rows(&replayed.verdict));
    let rest = match saved {
        Ok(path) => format!("  the case and its numbers\n    euler-poincare replay {}\n", quoted(path)),
        Err(reason) => format!("{}\n", paragraph(&format!("  not saved: {reason}"))),
    };
    format!("{measured}\n{rest}")
}

/// Rows of a record that is judged once more, or why it cannot be.
fn measured(replay: &Replay, rows: impl Fn(&Replayed) -> Vec<(&'static str, String)>) -> String {
    match Replayed::of(replay.clone(), None) {
        Ok(replayed) => entries(2, rows(&replayed)),
        Err(error) => paragraph(&format!("  {error}")),
    }
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    shell(&[path.display().to_string()])
}

/// Words as a shell reads them.
pub fn shell<S: AsRef<str>>(words: &[S]) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./:=,+@%".contains(c);
    let quoted = |word: &S| match word.as_ref() {
        word if !word.is_empty() && word.chars().all(plain) => word.to_owned(),
        word => format!("'{}'", word.replace('\'', r"'\''")),
    };
    words.iter().map(quoted).collect::<Vec<_>>().join(" ")
}

/// A case, `indent` columns in.
pub fn system(indent: u16, case: &Case) -> String {
    entries(indent, parts(case))
}

/// The names of the parts of a case, and what they are.
pub fn parts(case: &Case) -> Vec<(String, String)> {
    let text = case.to_string();
    let part = |line: &str| line.split_once(' ').map(|(name, what)| (name.to_owned(), what.trim_start().to_owned()));
    text.lines().filter_map(part).collect()
}

/// The saved cases that were replayed before a campaign.
pub struct Replays {
    /// How many there are.
    pub all: usize,
    /// How many are not as they should be.
    pub failing: usize,
    /// What is told of them: nothing where there are none.
    pub told: String,
}

/// Replays the saved cases of the laws that `wanted` names, where there are any.
pub fn regressions(wanted: impl Fn(&str) -> bool + Sync) -> Result<Replays, Failure> {
    let directory = Path::new(REGRESSIONS);
    let kept = replay_all(directory, wanted).map_err(|error| Failure::file(directory, error))?;
    let failing = kept.iter().filter(|kept| !kept.passes()).count();
    Ok(Replays { all: kept.len(), failing, told: if kept.is_empty() { String::new() } else { told(&kept) } })
}

/// How many of the kept records are as they should be; in full those that are not.
fn told(kept: &[Kept]) -> String {
    let failing: Vec<&Kept> = kept.iter().filter(|kept| !kept.passes()).collect();
    let records = if kept.len() == 1 { "record" } else { "records" };
    let mut told =
        format!("{} of {} {records} in {REGRESSIONS} as expected\n\n", kept.len() - failing.len(), kept.len());
    for record in failing {
        let body = match &record.outcome {
            Ok(replayed) if replayed.fault.is_some() => {
                format!("the planted fault is no longer caught\n{}", text(replayed, Some(&record.path)))
            }
            Ok(replayed) => text(replayed, Some(&record.path)),
            Err(reason) => format!("{}\n", paragraph(reason)),
        };
        told.push_str(&format!("REGRESSION {}\n{body}\n\n", record.path.display()));
    }
    told
}
