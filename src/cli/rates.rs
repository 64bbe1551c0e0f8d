//! How many cases of each law are checked in a second, on a thread: a figure that is kept, so that a regression shows.

use super::Failure;
use euler_poincare::file;
use euler_poincare::harness::{CampaignReport, Line, Summary};
use euler_poincare::system::Case;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// A law counts as slower when it checks this many times fewer cases a second than before: below that it is the day.
const SLOWER: f64 = 1.5;

const HEADER: [&str; 4] = ["law", "cases", "seconds", "cases_per_second"];

/// Cases per second of checking; none where there is nothing to divide.
pub fn rate(line: &Line) -> Option<f64> {
    (line.cases > 0 && line.seconds > 0.0).then(|| line.cases as f64 / line.seconds)
}

/// `0.52`, `7.1`, `340`, `12000`: two digits or all before the point.
pub fn text(rate: f64) -> String {
    match rate {
        r if r < 0.995 => format!("{r:.2}"),
        r if r < 99.5 => format!("{r:.1}"),
        r => format!("{r:.0}"),
    }
}

/// Writes the rates of a campaign; a line for each law that is slower than `path` said before.
pub fn keep(path: &Path, report: &CampaignReport<Case>) -> Result<String, Failure> {
    let before = read(path).map_err(|error| Failure::file(path, error))?;
    let lines: Vec<Line> = report.laws.iter().map(Summary::line).collect();
    write(&lines).and_then(|table| Ok(file::write(path, table)?)).map_err(|error| Failure::file(path, error))?;
    let slower = |line: &Line| {
        let (now, then) = (rate(line)?, *before.get(line.law)?);
        let (now_text, then_text) = (text(now), text(then));
        (now * SLOWER < then).then(|| format!("SLOWER {}: {now_text} cases a second, {then_text} before\n", line.law))
    };
    Ok(lines.iter().filter_map(slower).collect())
}

/// The rates that the file has, if there is one.
fn read(path: &Path) -> Result<BTreeMap<String, f64>, csv::Error> {
    let mut reader = match csv::Reader::from_path(path) {
        Err(error) if matches!(error.kind(), csv::ErrorKind::Io(e) if e.kind() == io::ErrorKind::NotFound) => {
            return Ok(BTreeMap::new());
        }
        reader => reader?,
    };
    let rows = reader.deserialize::<(String, u64, f64, Option<f64>)>();
    let rows = rows.map(|row| row.map(|(law, _, _, rate)| rate.map(|rate| (law, rate))));
    rows.filter_map(Result::transpose).collect()
}

fn write(lines: &[Line]) -> Result<Vec<u8>, csv::Error> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record(HEADER)?;
    for line in lines {
        let rate = rate(line).map(text).unwrap_or_default();
        writer.write_record([line.law, &line.cases.to_string(), &format!("{:.4}", line.seconds), &rate])?;
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}
