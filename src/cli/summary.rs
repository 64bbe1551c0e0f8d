//! What a campaign found, for people.

use super::failure::Replays;
use super::interrupt::Interrupt;
use super::table::{Column, Table, entries, paragraph, seconds};
use euler_poincare::harness::{CampaignReport, Ending, Line, Summary};
use euler_poincare::laws::PlantedLaw;
use euler_poincare::laws::replay::REGRESSIONS;
use euler_poincare::system::Case;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::process::ExitCode;

const COLUMNS: [Column; 11] = [
    Column::name("law"),
    Column::number("cases"),
    Column::number("held"),
    Column::number("broken"),
    Column::number("incon-\nclusive"),
    Column::number("not\nappl.").rank(1),
    Column::number("worst\nratio"),
    Column::number("its\ndefect").rank(2),
    Column::number("its\nbound").rank(3),
    Column::number("time\n[s]").rank(4),
    Column::number("cases\n/s").rank(5),
];

/// What the words and the numbers of the table mean.
const MEANING: &str = "\
A law is a statement that must hold for every system: an identity, an order of convergence, a conserved quantity. Each law was \
checked on random systems (algebra, inertia, forces, method, initial state, step), one a case.
The defect is the distance from what the law says; the bound is the largest defect that rounding or theory explains. Ratio = \
defect / bound: above 1 the law is broken. The unit of both is u, the unit round-off of the arithmetic (1.1e-16 in 16 digits), \
for identities, and a difference of slopes for orders of convergence.
`euler-poincare laws` states each law and its bound; `verify --out DIR`, then `euler-poincare report DIR` makes a page.";

/// A report, with how it was run.
pub struct Campaign<'a> {
    pub report: &'a CampaignReport<Case>,
    pub threads: usize,
    pub seconds: f64,
    /// The saved cases that were replayed before.
    pub kept: &'a Replays,
    /// Laws that were asked for by their whole name.
    pub asked: &'a [&'static str],
    /// How it ended, and where its results are: whole lines.
    pub end: &'a str,
    /// What there is to say of each broken law: whole lines.
    pub broken: &'a str,
    /// Whether more is printed than the verdict, the table and the broken laws.
    pub verbose: bool,
}

/// What a campaign shows, in the sequence of what counts first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Interrupted,
    Broken,
    /// Nothing was judged, or nothing of a law that was asked for by name.
    NoVerdict,
    Sound,
}

impl Campaign<'_> {
    fn outcome(&self) -> Outcome {
        let report = self.report;
        if report.ending == Ending::Interrupted {
            Outcome::Interrupted
        } else if !report.holds() || self.kept.failing > 0 {
            Outcome::Broken
        } else if report.laws.iter().all(|law| law.worst.is_none()) || !self.unanswered().is_empty() {
            Outcome::NoVerdict
        } else {
            Outcome::Sound
        }
    }

    /// The exit code of the command.
    pub fn exit_code(&self) -> ExitCode {
        match self.outcome() {
            Outcome::Interrupted => Interrupt::exit_code(),
            Outcome::Broken => ExitCode::from(1),
            Outcome::NoVerdict => ExitCode::from(3),
            Outcome::Sound => ExitCode::SUCCESS,
        }
    }

    /// Whether the command ends with code 3.
    pub fn is_undecided(&self) -> bool {
        self.outcome() == Outcome::NoVerdict
    }

    /// Laws that were asked for by name, and of which no case was judged.
    fn unanswered(&self) -> Vec<&'static str> {
        let judged = |name: &str| self.report.laws.iter().any(|law| law.law == name && law.worst.is_some());
        self.asked.iter().copied().filter(|name| !judged(name)).collect()
    }

    /// One line, the first and the last of the text.
    pub fn verdict(&self) -> String {
        let broken: Vec<_> = self.report.laws.iter().filter(|law| !law.broken.is_empty()).map(|law| law.law).collect();
        let laws = count(self.report.laws.len(), "law");
        let mut found = Vec::new();
        if !broken.is_empty() {
            found.push(format!("BROKEN: {} of {laws} ({})", broken.len(), some(&broken)));
        }
        if self.kept.failing > 0 {
            found.push(format!(
                "BROKEN: {} of {} in {REGRESSIONS}",
                self.kept.failing,
                count(self.kept.all, "saved case")
            ));
        }
        if found.is_empty() {
            let unanswered = self.unanswered();
            found.push(match self.report.laws.iter().any(|law| law.worst.is_some()) {
                false => format!("NO VERDICT: not one case of {laws} was judged"),
                true if !unanswered.is_empty() => {
                    format!("NO VERDICT: not one case was judged of {}", some(&unanswered))
                }
                true => format!("NOTHING BROKEN: {laws} checked"),
            });
        }
        if self.outcome() == Outcome::Interrupted {
            found.insert(0, "INTERRUPTED".into());
        }
        let line = Line::total(self.report.laws.iter().map(Summary::line));
        let undecided = percent(line.inconclusive, line.cases);
        format!(
            "{}; {}, seed {}, {undecided:.2} % inconclusive",
            found.join("; "),
            count(line.cases, "case"),
            self.report.seed
        )
    }
}

/// The first few of these names.
pub fn some(names: &[&str]) -> String {
    const MOST: usize = 3;
    match names.len() {
        n if n > MOST => format!("{} and {} more", names[..MOST].join(", "), n - MOST),
        _ => names.join(", "),
    }
}

/// The first ten of these indices.
pub fn first(cases: &[usize]) -> String {
    const MOST: usize = 10;
    let mut indices: Vec<String> = cases.iter().take(MOST).map(ToString::to_string).collect();
    if cases.len() > MOST {
        indices.push("…".into());
    }
    indices.join(", ")
}

impl fmt::Display for Campaign<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let verdict = paragraph(&self.verdict());
        writeln!(f, "{verdict}\n")?;
        if self.verbose {
            writeln!(f, "{}\n", paragraph(MEANING))?;
        }
        writeln!(f, "{}\n", laws(self.report))?;
        if self.verbose {
            self.details(f)?;
        }
        let unjudged: Vec<_> = self.report.laws.iter().filter(|law| law.worst.is_none()).map(|law| law.law).collect();
        if !unjudged.is_empty() {
            writeln!(f, "{}\n", paragraph(&format!("Without a verdict on any case: {}", unjudged.join(", "))))?;
        }
        f.write_str(&self.kept.told)?;
        f.write_str(self.broken)?;
        let (threads, time) = (count(self.threads, "thread"), seconds(self.seconds));
        let more = if self.verbose { "" } else { MORE };
        writeln!(f, "{}{threads}, {time}{more}\n{verdict}", self.end)
    }
}

/// Where the rest is.
const MORE: &str = "; -v explains the columns and prints coverage and reasons";

impl Campaign<'_> {
    /// On which systems the laws were checked, and why cases were not judged.
    fn details(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let judged: usize = self.report.laws.iter().map(admitted).sum();
        let title = format!("Coverage: % of the {judged} cases to which their law applies");
        writeln!(f, "{title}\n{}\n", coverage(self.report, judged))?;
        let laws = || self.report.laws.iter();
        let blocks = [
            reasons("Inconclusive", usize::MAX, laws().map(|law| (law.law, &law.inconclusive))),
            reasons("Not applicable", usize::MAX, laws().map(|law| (law.law, &law.not_applicable))),
        ];
        blocks.iter().flatten().try_for_each(|block| writeln!(f, "{block}"))
    }
}

fn percent(part: usize, whole: usize) -> f64 {
    100.0 * part as f64 / whole.max(1) as f64
}

/// `1 law`, `2 laws`.
pub fn count<N: fmt::Display + PartialEq + From<u8>>(number: N, noun: &str) -> String {
    let plural = if number == N::from(1) { "" } else { "s" };
    format!("{number} {noun}{plural}")
}

/// Cases that the law has something to say about.
fn admitted(law: &Summary<Case>) -> usize {
    law.cases - law.not_applicable.values().sum::<usize>()
}

fn laws(report: &CampaignReport<Case>) -> String {
    let mut table = Table::new(&COLUMNS);
    for law in &report.laws {
        table.row(row(&law.line()));
    }
    if report.laws.len() > 1 {
        table.row(row(&Line::total(report.laws.iter().map(Summary::line))));
    }
    table.text()
}

fn row(line: &Line) -> Vec<String> {
    let number = |number: Option<f64>| number.map(|x| format!("{x:.1e}")).unwrap_or_default();
    vec![
        line.law.to_owned(),
        line.cases.to_string(),
        line.held.to_string(),
        line.broken.to_string(),
        line.inconclusive.to_string(),
        line.not_applicable.to_string(),
        number(line.ratio),
        number(line.max_defect),
        number(line.bound),
        seconds(line.seconds).trim_end_matches(" s").to_owned(),
        rate(line).unwrap_or_default(),
    ]
}

/// Cases per second of checking on a thread, where there is something to divide: `0.52`, `7.1`, `340`; two digits or all before the
/// point.
fn rate(line: &Line) -> Option<String> {
    let rate = (line.cases > 0 && line.seconds > 0.0).then(|| line.cases as f64 / line.seconds)?;
    Some(match rate {
        r if r < 0.995 => format!("{r:.2}"),
        r if r < 99.5 => format!("{r:.1}"),
        r => format!("{r:.0}"),
    })
}

/// One line per category, the labels by frequency.
fn coverage(report: &CampaignReport<Case>, judged: usize) -> String {
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

/// Why cases were not judged, and how often: of each law, or of several laws at once where at least `shared` of them have one reason.
pub fn reasons<'a>(
    title: &str,
    shared: usize,
    laws: impl Iterator<Item = (&'static str, &'a BTreeMap<String, usize>)>,
) -> Option<String> {
    let all: Vec<(&str, &String, usize)> =
        laws.flat_map(|(law, reasons)| reasons.iter().map(move |(why, count)| (law, why, *count))).collect();
    let mut told = BTreeSet::new();
    let row = |&(law, why, count): &(&'static str, &String, usize)| {
        let same: Vec<usize> = all.iter().filter(|(_, other, _)| *other == why).map(|(.., count)| *count).collect();
        if same.len() < shared {
            return Some((law.to_owned(), format!("{count} × {why}")));
        }
        let sum: usize = same.iter().sum();
        told.insert(why.clone()).then(|| (format!("{} laws", same.len()), format!("{sum} × {why}")))
    };
    let rows: Vec<(String, String)> = all.iter().filter_map(row).collect();
    (!rows.is_empty()).then(|| format!("{title}\n{}\n", entries(2, rows)))
}

/// The heading for a broken law; if asked for with what it says.
pub fn broken(subject: &PlantedLaw, summary: &Summary<Case>, verbose: bool) -> String {
    let law = subject.law;
    let mut rows = Vec::new();
    if verbose {
        rows.extend([("statement", law.about.statement.to_owned()), ("source", law.about.source.to_owned())]);
        rows.extend(subject.fault.map(|fault| ("planted", format!("{}: {}", fault.name, fault.what))));
    }
    if !summary.irreproducible.is_empty() {
        let indices: Vec<_> = summary.irreproducible.iter().map(ToString::to_string).collect();
        rows.push(("differs", format!("case {} held when checked a second time", indices.join(", "))));
    }
    let (count, cases) = (summary.broken.len(), summary.cases);
    let heading = format!("BROKEN {}: {count} of {cases} cases ({})", law.about.name, first(&summary.broken));
    let rows = if rows.is_empty() { String::new() } else { entries(2, rows) + "\n" };
    format!("{}\n{rows}", paragraph(&heading))
}
