//! What is said of a broken law: of a campaign, of a saved case, of the regressions.

use super::table::entries;
use super::{Failure, Format, print};
use euler_poincare::harness::evidence::Wanted;
use euler_poincare::laws::replay::{Kept, REGRESSIONS, Replayed, indented, replay_all};
use euler_poincare::system::{Replay, snippet};
use std::path::Path;

/// A judged record in full: law, source, verdict, what was measured at each precision, the case, how to replay it, and a program.
pub fn text(replayed: &Replayed, file: Option<&Path>) -> String {
    let case = indented(&replayed.replay.case.to_string());
    let again = file.map(|path| format!("\nreplay it\n  euler-poincare replay {}\n", quoted(path))).unwrap_or_default();
    let program = indented(&snippet(&replayed.replay));
    format!("{}\n{case}\n{again}\nor in a program of your own\n{program}\n", entries(0, replayed.rows()))
}

/// A shrunk failure of a campaign: judged once more, for what was measured.
pub fn campaign(replay: &Replay, checks: usize, saved: Result<&Path, &str>) -> String {
    let (seed, index) = (replay.seed, replay.index);
    let heading = format!("  case {index} of seed {seed}, shrunk by {checks} checks\n");
    let case = indented(&indented(&replay.case.to_string()));
    let measured = match Replayed::of(replay.clone(), Wanted::AllDigits) {
        Ok(replayed) => entries(2, replayed.measured()),
        Err(error) => format!("  {error}"),
    };
    let saved = match saved {
        Ok(path) => {
            let name = quoted(path);
            format!("  saved in {name}; run it again with\n    euler-poincare replay {name}\n")
        }
        Err(reason) => format!("  not saved: {reason}\n"),
    };
    let program = indented(&indented(&snippet(replay)));
    format!("{measured}\n{heading}{case}\n{saved}  or with this program\n{program}\n")
}

/// A path as a shell takes it.
fn quoted(path: &Path) -> String {
    let text = path.display().to_string();
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./+,:@%".contains(c);
    if text.chars().all(plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

/// Replays the kept records of the laws that `wanted` names, where there are any; whether each is as it should be.
pub fn regressions(format: Format, wanted: impl Fn(&str) -> bool + Sync) -> Result<bool, Failure> {
    let directory = Path::new(REGRESSIONS);
    let kept = replay_all(directory, wanted).map_err(|error| Failure::file(directory, error))?;
    if kept.is_empty() {
        return Ok(true);
    }
    let told = told(&kept);
    match format {
        Format::Text => print(&told)?,
        Format::Json => eprint!("{told}"),
    }
    Ok(kept.iter().all(Kept::passes))
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
            Err(reason) => format!("{reason}\n"),
        };
        told.push_str(&format!("REGRESSION {}\n{}\n\n", record.path.display(), indented(&body)));
    }
    told
}
