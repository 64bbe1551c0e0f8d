//! The table and the file.

use crate::contender::Kind;
use crate::machine::Machine;
use crate::measure::Run;
use serde::Serialize;
use std::fmt::Write;

/// The accuracies at which times are compared.
pub const TARGETS: [f64; 3] = [1e-8, 1e-10, 1e-12];

/// All runs on one problem.
#[derive(Clone, Debug, Serialize)]
pub struct Panel {
    /// The word for the system.
    pub system: &'static str,
    /// T.
    pub end: f64,
    /// What to call it.
    pub title: String,
    /// The runs, by contender and tolerance.
    pub runs: Vec<Run>,
}

/// Everything that was measured.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// On what.
    pub machine: Machine,
    /// By problem.
    pub panels: Vec<Panel>,
}

/// A contender's time at a target.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a> {
    /// The run it comes from.
    pub run: &'a Run,
    /// Its median, in seconds.
    pub time: f64,
    /// Whether the measured error is within the target.
    pub met: bool,
}

impl Panel {
    /// The contenders, in the order in which they ran.
    pub fn contenders(&self) -> Vec<&Run> {
        let mut seen: Vec<&Run> = Vec::new();
        for run in &self.runs {
            if seen.iter().all(|r| r.contender != run.contender) {
                seen.push(run);
            }
        }
        seen
    }

    /// Ours: the run whose tolerance is the target. The others: the fastest run whose measured error is within it.
    pub fn entry(&self, contender: &str, target: f64) -> Option<Entry<'_>> {
        let runs = self.runs.iter().filter(|r| r.contender == contender);
        runs.filter_map(|run| Some((run.error.is_some_and(|e| e <= target), run, run.time?.median)))
            .filter(|(met, run, _)| if run.kind == Kind::Ours { run.tolerance == target } else { *met })
            .min_by(|x, y| x.2.total_cmp(&y.2))
            .map(|(met, run, time)| Entry { run, time, met })
    }

    /// The fastest packaged solver at a target.
    pub fn best_packaged(&self, target: f64) -> Option<Entry<'_>> {
        let packaged = self.contenders().into_iter().filter(|r| r.kind == Kind::Packaged);
        packaged.filter_map(|r| self.entry(&r.contender, target)).min_by(|x, y| x.time.total_cmp(&y.time))
    }

    fn table(&self) -> String {
        let mut text = format!("{}\n{:30}", self.title, "");
        for target in TARGETS {
            let _ = write!(text, "{:>28}", format!("error ≤ {target:.0e}"));
        }
        text.push('\n');
        for contender in self.contenders() {
            let _ = write!(text, "{:30}", contender.contender);
            for target in TARGETS {
                let _ = write!(text, "{:>28}", self.cell(&contender.contender, target));
            }
            text.push('\n');
        }
        text
    }

    fn cell(&self, contender: &str, target: f64) -> String {
        let Some(entry) = self.entry(contender, target) else {
            return "–".into();
        };
        let ratio = self.best_packaged(target).map_or(String::new(), |best| ratio(entry.time / best.time));
        let missed = match entry.run.error {
            Some(error) if !entry.met => format!(" missed ({error:.0e}) "),
            None => " failed ".into(),
            _ => String::new(),
        };
        format!("{missed}{} {ratio:>8}", seconds(entry.time))
    }
}

impl Report {
    /// The machine, the tables, and whether ours kept its tolerances.
    pub fn text(&self) -> String {
        let mut text = format!("{}\n\n", self.machine.describe());
        text.push_str("median time of a solve, and its ratio to the best packaged solver\n\n");
        for panel in &self.panels {
            text.push_str(&panel.table());
            text.push('\n');
        }
        for line in self.verdicts() {
            text.push_str(&line);
            text.push('\n');
        }
        text
    }

    /// One line for each problem and each of ours, at each target.
    fn verdicts(&self) -> Vec<String> {
        let verdict = |panel: &Panel, ours: &Run| {
            let at = |target: f64| match panel.entry(&ours.contender, target) {
                Some(Entry { met: true, run, .. }) => format!("{target:.0e} met ({:.1e})", run.error.unwrap_or(0.0)),
                Some(Entry { run, .. }) => format!("{target:.0e} MISSED ({:.1e})", run.error.unwrap_or(f64::NAN)),
                None => format!("{target:.0e} no answer"),
            };
            format!("{}: {}: {}", ours.contender, panel.title, TARGETS.map(at).join(", "))
        };
        let ours = |panel: &Panel| {
            let ours = panel.contenders().into_iter().filter(|r| r.kind == Kind::Ours);
            ours.map(|run| verdict(panel, run)).collect::<Vec<_>>()
        };
        self.panels.iter().flat_map(ours).collect()
    }

    /// Contenders without any answer, and targets that ours did not meet.
    pub fn faults(&self) -> Vec<String> {
        let mut faults = Vec::new();
        for panel in &self.panels {
            for Run { contender, kind, .. } in panel.contenders() {
                if panel.runs.iter().all(|r| r.contender != *contender || r.error.is_none()) {
                    faults.push(format!("{}: {contender} gave no answer", panel.title));
                }
                let met = |target| panel.entry(contender, target).is_some_and(|entry| entry.met);
                if *kind == Kind::Ours && !TARGETS.into_iter().all(met) {
                    faults.push(format!("{}: {contender} missed a tolerance", panel.title));
                }
            }
        }
        faults
    }

    /// Contenders with runs that gave no answer or were not timed, and why the first of them did not.
    pub fn notes(&self) -> String {
        let mut text = String::new();
        for panel in &self.panels {
            for contender in panel.contenders() {
                let mut notes = panel.runs.iter().filter(|r| r.contender == contender.contender && r.note.is_some());
                let Some(Run { tolerance, note: Some(note), .. }) = notes.next() else {
                    continue;
                };
                let more = match notes.count() {
                    0 => String::new(),
                    n => format!(" (and {n} more, see the file)"),
                };
                let _ = writeln!(text, "{}: {} at {tolerance:.0e}: {note}{more}", panel.title, contender.contender);
            }
        }
        text
    }
}

/// Three digits and a unit.
pub fn seconds(t: f64) -> String {
    let (value, unit) = match t {
        t if t < 1e-6 => (t * 1e9, "ns"),
        t if t < 1e-3 => (t * 1e6, "µs"),
        t if t < 1.0 => (t * 1e3, "ms"),
        t => (t, "s"),
    };
    let decimals = if value < 10.0 { 2 } else { usize::from(value < 100.0) };
    format!("{value:.decimals$} {unit}")
}

fn ratio(r: f64) -> String {
    if r < 10.0 { format!("{r:.2}×") } else { format!("{r:.0}×") }
}
