//! `verify --faults`: every planted fault must be caught.

use super::interrupt::Interrupt;
use super::progress::Bar;
use super::progress::weight;
use super::summary::{self, some};
use super::table::{Column, Table as Grid, paragraph, seconds};
use super::{Failure, Format, complain, output, print, program, schema};
use euler_poincare::file::Output;
use euler_poincare::harness::store::{Manifest, StoreError};
use euler_poincare::harness::{About, Cost, Fault, catch_smallest, first_caught, parallel};
use euler_poincare::laws::CaseLaw;
use euler_poincare::system::Case;
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

/// A fault that this many cases do not show is not caught.
const CASES: usize = 100;

/// Laws that take a second or more for a case with a fault: they measure orders, on variations of the case too.
const SLOW: [&str; 7] = [
    "order-predicted",
    "doubled-momentum-map",
    "fast-solver",
    "fast-order",
    "fast-energy",
    "fast-casimirs",
    "fast-reversibility",
];

/// How many cases of a law may show a fault of a smaller size.
fn cases_for_size(law: &About) -> usize {
    match law.cost {
        Cost::Moderate if SLOW.contains(&law.name) => 2,
        Cost::Cheap | Cost::Moderate => CASES,
        Cost::Expensive | Cost::Heavy => 1,
    }
}

/// A planted fault, and after how many cases it was caught: a line that is written and read.
#[derive(Debug, Serialize, Deserialize)]
pub struct Caught {
    /// The law that should see it.
    pub law: String,
    /// Its name.
    pub fault: String,
    /// `None`: not at all.
    pub caught_after: Option<usize>,
    /// The smallest size, a power of ten, at which it still is; only if it was asked for.
    #[serde(default)]
    pub smallest_size: Option<f64>,
}

/// The same, with what is printed beside it.
struct Catch {
    row: Caught,
    /// How clearly: defect/bound of that case.
    ratio: Option<f64>,
    visible_on: &'static str,
    seconds: f64,
}

/// What is asked of the planted faults.
pub struct Table<'a> {
    pub seed: u64,
    pub sizes: bool,
    pub format: Format,
    /// A campaign's directory, or what becomes one.
    pub out: Option<&'a Path>,
}

impl Table<'_> {
    /// Plants each fault of `laws`, and prints after how many cases it is caught.
    pub fn run(&self, laws: &[&'static CaseLaw], interrupt: &Interrupt) -> Result<ExitCode, Failure> {
        let file = self.out.map(|out| self.file(out)).transpose()?;
        let groups: Vec<_> =
            laws.iter().map(|law| (law.about.name, Some(law.about.faults.len()), weight(law.about.cost))).collect();
        let bar = Bar::new(&groups, None, Some(interrupt.clone()));
        let mut faults: Vec<_> =
            laws.iter().flat_map(|law| law.about.faults.iter().map(move |fault| (*law, fault))).enumerate().collect();
        // Expensive laws first, so that no long piece is left for the end.
        faults.sort_by_key(|(_, (law, _))| std::cmp::Reverse(law.about.cost));
        let caught = parallel(faults.len(), |k| {
            let (index, (law, fault)) = faults[k];
            let catch = (!interrupt.is_set()).then(|| self.catch(law, fault));
            bar.advance(law.about.name);
            Some((index, catch?))
        });
        let mut catches: Vec<_> = caught.into_iter().flatten().collect();
        bar.clear();
        catches.sort_by_key(|(index, _)| *index);
        let catches: Vec<Catch> = catches.into_iter().map(|(_, catch)| catch).collect();
        let interrupted = catches.len() < faults.len();
        let objects: String =
            catches.iter().map(|catch| format!("{}\n", schema::object("verify-faults/1", json!(catch.row)))).collect();
        if let Some((file, rows)) = file.filter(|_| !interrupted) {
            output::write(rows, &file, &objects)?;
        }
        print(&match self.format {
            Format::Text => text(&catches, self.sizes, &verdict(&catches, faults.len())),
            Format::Json => objects,
        })?;
        if interrupted {
            let lost = if self.out.is_some() { "; nothing is kept in --out" } else { "" };
            complain(&format!("INTERRUPTED after {} of {} faults{lost}", catches.len(), faults.len()));
            return Ok(Interrupt::exit_code());
        }
        Ok(match catches.iter().all(|catch| catch.row.caught_after.is_some()) {
            _ if catches.is_empty() => ExitCode::from(3),
            true => ExitCode::SUCCESS,
            false => ExitCode::from(1),
        })
    }

    /// Where the rows go: a new file, in a directory that holds no campaign of another program or seed.
    fn file(&self, out: &Path) -> Result<(PathBuf, Output), Failure> {
        match Manifest::read(out) {
            Err(StoreError::NoCampaign { .. }) => {}
            there => {
                let differences = there?.program_differences(&program::manifest::<Case>(self.seed, None, &[])?);
                if !differences.is_empty() {
                    return Err(StoreError::Differs { path: out.to_owned(), differences }.into());
                }
            }
        }
        let file = out.join("faults.jsonl");
        if file.exists() {
            return Err(Failure::Usage(format!("{}: exists already; allowed: a directory without it", file.display())));
        }
        fs::create_dir_all(out).map_err(|error| Failure::file(out, error))?;
        let rows = output::create(&file)?;
        Ok((file, rows))
    }

    fn catch(&self, law: &'static CaseLaw, fault: &'static Fault) -> Catch {
        let (seed, start) = (self.seed, Instant::now());
        let (after, ratio) =
            first_caught(law, fault, seed, CASES).map(|(index, verdict)| (index + 1, verdict.ratio())).unzip();
        let smallest = after.filter(|_| self.sizes).and_then(|after| {
            // As many cases as the whole fault needed, at least.
            catch_smallest(law, fault, seed, cases_for_size(&law.about).max(after))
        });
        let seconds = start.elapsed().as_secs_f64();
        let row = Caught {
            law: law.about.name.into(),
            fault: fault.name.into(),
            caught_after: after,
            smallest_size: smallest.map(|k| 10f64.powi(-(k as i32))),
        };
        Catch { row, ratio: ratio.flatten(), visible_on: fault.visible_on, seconds }
    }
}

/// What is asked.
const MEANING: &str = "\
A check that cannot fail proves nothing. Each law is run with faults planted in what it judges, one at a time; it must be \
broken on one of the first 100 random systems. Ratio = defect / bound on that system: above 1 the fault is seen.";

fn text(catches: &[Catch], sizes: bool, verdict: &str) -> String {
    let mut columns = vec![
        // One column, that may wrap between the two names: both may be long.
        Column::text("law: fault"),
        Column::number("caught\nafter"),
        Column::number("ratio").rank(2),
        Column::number("time\n[s]").rank(4),
        Column::text("visible on").rank(3),
    ];
    if sizes {
        columns.insert(3, Column::number("smallest\nsize").rank(1));
    }
    let mut table = Grid::new(&columns);
    for Catch { row, ratio, visible_on, seconds: time } in catches {
        let mut cells = vec![
            format!("{}: {}", row.law, row.fault),
            row.caught_after.map_or("never".to_owned(), |cases| cases.to_string()),
            ratio.map(|ratio| format!("{ratio:.1e}")).unwrap_or_default(),
            seconds(*time).trim_end_matches(" s").to_owned(),
            (*visible_on).to_owned(),
        ];
        if sizes {
            cells.insert(3, row.smallest_size.map(|size| format!("{size:.0e}")).unwrap_or_default());
        }
        table.row(cells);
    }
    let smallest = if sizes {
        "\nThe smallest size is the smallest part of the fault, a power of ten, that is still caught."
    } else {
        ""
    };
    let (verdict, meaning) = (paragraph(verdict), paragraph(&format!("{MEANING}{smallest}")));
    format!("{verdict}\n\n{meaning}\n\n{}\n\n{verdict}\n", table.text())
}

/// The first and the last line.
fn verdict(catches: &[Catch], planted: usize) -> String {
    let missed: Vec<String> = catches
        .iter()
        .filter(|catch| catch.row.caught_after.is_none())
        .map(|catch| format!("{} of {}", catch.row.fault, catch.row.law))
        .collect();
    let missed: Vec<&str> = missed.iter().map(String::as_str).collect();
    let (count, laws) = (catches.len(), catches.iter().map(|catch| &catch.row.law).collect::<BTreeSet<_>>().len());
    let of = format!("{} in {}", summary::count(count, "fault"), summary::count(laws, "law"));
    let ended = if count < planted { format!("INTERRUPTED after {count} of {planted}: ") } else { String::new() };
    match missed.len() {
        _ if count == 0 => format!("{ended}NO VERDICT: no fault was planted"),
        0 => format!("{ended}ALL CAUGHT: {of}, each within {CASES} cases"),
        n => format!("{ended}NOT CAUGHT within {CASES} cases: {n} of {of}: {}", some(&missed)),
    }
}
