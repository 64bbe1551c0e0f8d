//! What a campaign found, for people.

use super::rates;
use super::table::{entries, seconds, table};
use super::verify::Subject;
use euler_poincare::harness::{Line, Report, Summary};
use euler_poincare::system::Case;
use std::collections::BTreeMap;
use std::fmt;

const HEADER: [&str; 11] = [
    "law",
    "cases",
    "held",
    "broken",
    "incon-\nclus.",
    "not\nappl.",
    "worst\ndefect",
    "its\nbound",
    "ratio",
    "time\n[s]",
    "cases\n/s",
];

/// A report, with how it was run.
pub struct Campaign<'a> {
    pub report: &'a Report<Case>,
    pub threads: usize,
    pub seconds: f64,
}

impl fmt::Display for Campaign<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}\n", laws(self.report))?;
        let judged: usize = self.report.laws.iter().map(admitted).sum();
        writeln!(f, "Coverage: % of the {judged} cases that admit their law\n{}\n", coverage(self.report, judged))?;
        reasons(f, "Inconclusive", self.report, |law| &law.inconclusive)?;
        reasons(f, "Not applicable", self.report, |law| &law.not_applicable)?;
        let line = total(self.report);
        let unjudged: Vec<_> = self.report.laws.iter().filter(|law| law.worst.is_none()).map(|law| law.law).collect();
        if !unjudged.is_empty() {
            writeln!(f, "Without a verdict on any case: {}\n", unjudged.join(", "))?;
        }
        let broken = self.report.laws.iter().filter(|law| !law.broken.is_empty()).count();
        let outcome =
            if broken == 0 { "nothing broken".to_owned() } else { format!("{} broken", count(broken, "law")) };
        let threads = count(self.threads, "thread");
        writeln!(
            f,
            "{}, {}, seed {}, {threads}, {}: {outcome}, {:.2} % inconclusive",
            count(self.report.laws.len(), "law"),
            count(line.cases, "case"),
            self.report.seed,
            seconds(self.seconds),
            percent(line.inconclusive, line.cases),
        )
    }
}

fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// `1 law`, `2 laws`.
fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

/// Cases that the law has something to say about.
fn admitted(law: &Summary<Case>) -> usize {
    law.cases - law.not_applicable.values().sum::<usize>()
}

fn total(report: &Report<Case>) -> Line {
    let lines = report.laws.iter().map(Summary::line);
    let zero = Line {
        law: "all",
        cases: 0,
        held: 0,
        broken: 0,
        inconclusive: 0,
        not_applicable: 0,
        max_defect: None,
        bound: None,
        seconds: 0.0,
    };
    lines.fold(zero, |sum, line| Line {
        cases: sum.cases + line.cases,
        held: sum.held + line.held,
        broken: sum.broken + line.broken,
        inconclusive: sum.inconclusive + line.inconclusive,
        not_applicable: sum.not_applicable + line.not_applicable,
        seconds: sum.seconds + line.seconds,
        ..sum
    })
}

fn laws(report: &Report<Case>) -> String {
    let mut table = table(&HEADER, 1..HEADER.len());
    for law in &report.laws {
        table.add_row(row(&law.line(), law.worst.map(|worst| worst.ratio())));
    }
    if report.laws.len() > 1 {
        table.add_row(row(&total(report), None));
    }
    table.trim_fmt()
}

fn row(line: &Line, ratio: Option<f64>) -> Vec<String> {
    let number = |number: Option<f64>| number.map(|x| format!("{x:.1e}")).unwrap_or_default();
    vec![
        line.law.to_owned(),
        line.cases.to_string(),
        line.held.to_string(),
        line.broken.to_string(),
        line.inconclusive.to_string(),
        line.not_applicable.to_string(),
        number(line.max_defect),
        number(line.bound),
        number(ratio),
        seconds(line.seconds).trim_end_matches(" s").to_owned(),
        rates::rate(line).map(rates::text).unwrap_or_default(),
    ]
}

/// One line per category, the labels by frequency.
fn coverage(report: &Report<Case>, judged: usize) -> String {
    let mut categories = BTreeMap::<&str, Vec<(&str, usize)>>::new();
    for ((category, label), count) in report.total_coverage() {
        categories.entry(category).or_default().push((label, count.applicable));
    }
    let rows = categories.into_iter().map(|(category, mut labels)| {
        // Numbers (dimensions) in their order, names by frequency.
        if labels.iter().any(|(label, _)| label.parse::<usize>().is_err()) {
            labels.sort_by_key(|(label, count)| (std::cmp::Reverse(*count), *label));
        }
        // Non-breaking space: a label and its number stay on one line.
        let share = |(label, count): (&str, usize)| format!("{label}\u{a0}{:.1}", percent(count, judged));
        (category, labels.into_iter().map(share).collect::<Vec<_>>().join(", "))
    });
    entries(2, rows).replace('\u{a0}', " ")
}

fn reasons(
    f: &mut fmt::Formatter<'_>,
    title: &str,
    report: &Report<Case>,
    of: impl Fn(&Summary<Case>) -> &BTreeMap<String, usize>,
) -> fmt::Result {
    let mut rows = Vec::new();
    for law in &report.laws {
        rows.extend(of(law).iter().map(|(why, count)| (law.law, format!("{count} × {why}"))));
    }
    if rows.is_empty() { Ok(()) } else { writeln!(f, "{title}\n{}\n", entries(2, rows)) }
}

/// The heading for a broken law.
pub fn broken(subject: &Subject, summary: &Summary<Case>) -> String {
    let mut indices: Vec<String> = summary.broken.iter().take(10).map(ToString::to_string).collect();
    if summary.broken.len() > 10 {
        indices.push("…".into());
    }
    let law = subject.law;
    let mut rows = vec![("statement", law.statement.to_owned()), ("source", law.source.to_owned())];
    rows.extend(subject.fault.map(|fault| ("planted", format!("{}: {}", fault.name, fault.what))));
    if !summary.irreproducible.is_empty() {
        let indices: Vec<_> = summary.irreproducible.iter().map(ToString::to_string).collect();
        rows.push(("not again", format!("case {} held when checked a second time", indices.join(", "))));
    }
    let (count, cases) = (summary.broken.len(), summary.cases);
    format!("BROKEN {}: {count} of {cases} cases ({})\n{}\n", law.name, indices.join(", "), entries(2, rows))
}
