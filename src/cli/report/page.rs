//! The page: its head, the table of verdicts, and the sections in their order.

use super::again::{Failures, Order};
use super::elements::*;
use super::files::{Damage, Found, planned};
use super::numbers::*;
use super::tally::Tally;
use super::{chart, coverage, failures, faults, orders, script, undecided, verdicts};
use euler_poincare::harness::store::ManifestLaw;
use euler_poincare::harness::{Line, Worst};
use euler_poincare::laws;
use maud::{Markup, html};

/// What the whole campaign adds up to.
pub struct Totals {
    /// Cases that there should be; `None` where no number was asked for.
    pub planned: Option<usize>,
    /// The cases that there are.
    pub all: Line,
    /// Laws that are broken.
    pub broken_laws: Vec<String>,
    /// Laws with cases of which none was judged.
    pub unjudged: Vec<String>,
}

impl Totals {
    /// Of a campaign.
    pub fn of(found: &Found) -> Self {
        let names = |wanted: fn(&Tally) -> bool| {
            found.laws().filter(|(_, tally)| wanted(tally)).map(|(law, _)| law.name.clone()).collect()
        };
        Self {
            planned: found.planned(),
            all: Line::total(found.tallies.iter().map(|tally| tally.found.line())),
            broken_laws: names(|tally| tally.broken() > 0),
            unjudged: names(|tally| tally.found.cases > 0 && tally.judged() == 0),
        }
    }

    fn judged(&self) -> usize {
        self.all.held + self.all.broken
    }

    /// Cases that there should be and are not.
    fn missing(&self) -> usize {
        self.planned.map_or(0, |planned| planned.saturating_sub(self.all.cases))
    }

    /// What came out, in a sentence.
    pub fn outcome(&self) -> String {
        let judged = self.judged();
        let found = match self.broken_laws.as_slice() {
            _ if judged == 0 => "No case has been judged".to_owned(),
            [] => {
                format!("Nothing is broken: every law holds on every one of the {} that could be judged", cases(judged))
            }
            [law] => {
                format!("One law is broken, {law}, on {} of the {} judged", integer(self.all.broken), cases(judged))
            }
            broken => format!(
                "{} laws are broken, on {} of the {} judged",
                integer(broken.len()),
                integer(self.all.broken),
                cases(judged)
            ),
        };
        let missing = match (self.planned, self.missing()) {
            (Some(planned), missing) if missing > 0 => {
                format!("; {} of {} are missing", integer(missing), cases(planned))
            }
            _ => String::new(),
        };
        format!("{found}{missing}.")
    }
}

/// The page as text.
pub fn page(found: &Found, plotted: &[Order], failing: &Failures<'_>) -> String {
    let totals = Totals::of(found);
    let title = format!("Campaign of seed {}", found.manifest.seed);
    let class = if totals.all.broken > 0 {
        "broken"
    } else if totals.all.held == 0 {
        "empty"
    } else {
        "held"
    };
    let laws: Vec<_> = found.laws().map(|(law, tally)| (law.name.as_str(), &tally.found, tally.found.cases)).collect();
    let sections = [
        verdict_section(found),
        undecided::section("Undecided and rejected", &laws, "The law says nothing about the case.", true),
        coverage::section(found),
        orders::section(plotted),
        faults::section(found),
        failures::section(found, failing),
    ];
    let head = html! { (head(found, &totals)) (notes(found, &totals, plotted)) };
    let outcome = Outcome { class, text: totals.outcome() };
    Document { title: &title, outcome, head, sections: &sections, script: true }.text()
}

fn head(found: &Found, totals: &Totals) -> Markup {
    let manifest = &found.manifest;
    let judged = totals.judged();
    let state = match totals.planned {
        None => "as many cases as the time allowed".to_owned(),
        Some(_) if totals.missing() == 0 => "complete".to_owned(),
        Some(_) if totals.all.cases == 0 => "nothing done".to_owned(),
        Some(planned) => {
            format!("incomplete: {} missing of {}", integer(totals.missing()), integer(planned))
        }
    };
    html! {
        (verdicts::figures(&totals.all, html! { div { dt { "laws" } dd { (integer(manifest.laws.len())) } } }))
        dl.facts {
            div { dt { "state" } dd { (state) } }
            div { dt { "seed" } dd { (manifest.seed) } }
            @if let Some(cases) = manifest.cases { div { dt { "cases per cheap law" } dd { (integer(cases)) } } }
            div {
                dt { "program" }
                dd { "euler-poincare " (manifest.version) ", " code { (short(&manifest.binary)) } }
            }
            @if manifest.shard.is_some() { div { dt { "shard" } dd { (manifest.shard().to_string()) } } }
            @if let Some(fault) = &manifest.plant { div { dt { "planted fault" } dd { code { (fault) } } } }
            div { dt { "judged" } dd { (share(judged, totals.all.cases)) " of the cases" } }
        }
    }
}

/// The first digits of a hash.
fn short(hash: &str) -> String {
    hash.chars().take(12).collect()
}

/// What a reader must know before believing the rest.
fn notes(found: &Found, totals: &Totals, orders: &[Order]) -> Markup {
    let mut notes: Vec<Markup> = Vec::new();
    if found.running {
        notes.push(
            html! { "Another process was writing here when the page was made: the numbers are those of that moment." },
        );
    }
    if !found.started {
        notes.push(html! { "There are no results: " code { "results.jsonl" } " is not there." });
    }
    if let Some(fault) = &found.manifest.plant {
        notes.push(html! {
            "The fault " code { (fault) } " was planted in the subjects of the laws: what is broken was meant to break."
        });
    }
    if found.another_program {
        notes.push(html! {
            "The campaign was run by another program (version " (found.manifest.version) ", "
            code { (short(&found.manifest.binary)) } "): statements, sources and plots are those of the program that made this page."
        });
    }
    notes.extend(damage("results.jsonl", &found.damage));
    notes.extend(damage("faults.jsonl", &found.fault_damage));
    let unknown: Vec<&str> = found
        .manifest
        .laws
        .iter()
        .filter(|law| laws::named(&law.name).is_none())
        .map(|law| law.name.as_str())
        .collect();
    if !unknown.is_empty() {
        notes.push(html! { "Laws that this program does not know: " (unknown.join(", ")) "." });
    }
    if !totals.unjudged.is_empty() {
        notes.push(html! { "Laws without a verdict on any case: " (totals.unjudged.join(", ")) "." });
    }
    let others: Vec<String> = orders
        .iter()
        .flat_map(|order| {
            order.cases.iter().filter(|case| !case.agrees).map(move |case| (order.law.about.name, case.index))
        })
        .map(|(law, index)| format!("case {index} of {law}"))
        .collect();
    if !others.is_empty() {
        notes.push(html! {
            "This program does not give the campaign's verdict on " (others.join(", "))
            ": it is not the program that ran the campaign, and its plots may show other cases."
        });
    }
    html! {
        @if !notes.is_empty() {
            ul.notes { @for note in &notes { li { (note) } } }
        }
    }
}

fn damage(file: &str, damage: &Damage) -> Vec<Markup> {
    let mut notes = Vec::new();
    if damage.lines > 0 {
        notes.push(html! {
            code { (file) } ": " (counted(damage.lines, "line")) " cannot be used and "
            @if damage.lines == 1 { "is" } @else { "are" } " left out:"
            ul { @for (line, reason) in &damage.first { li { "line " (line) ": " (reason) } } }
            @if damage.lines > damage.first.len() { p { "… and " (damage.lines - damage.first.len()) " more." } }
        });
    }
    if damage.repeated > 0 {
        notes.push(html! {
            code { (file) } ": " (counted(damage.repeated, "line")) " of cases that were there already: the first counts."
        });
    }
    if damage.torn {
        notes.push(html! {
            code { (file) } " ends within a line, which is left out: the campaign was killed, or is still running."
        });
    }
    notes
}

/// The laws: broken ones first, that of the largest ratio before the others; then as the theory orders them.
fn ordered(found: &Found) -> Vec<(&ManifestLaw, &Tally)> {
    let mut laws: Vec<_> = found.laws().collect();
    let ratio = |tally: &Tally| tally.found.worst.as_ref().filter(|_| tally.broken() > 0).map_or(0.0, Worst::ratio);
    laws.sort_by(|a, b| (b.1.broken() > 0).cmp(&(a.1.broken() > 0)).then(ratio(b.1).total_cmp(&ratio(a.1))));
    laws
}

/// Orders that the script offers: key, name.
const ORDERS: [(&str, &str); 8] = [
    ("place", "broken first"),
    ("name", "name"),
    ("ratio", "worst ratio"),
    ("broken", "broken"),
    ("inconclusive", "inconclusive, share of cases"),
    ("inapplicable", "not applicable, share of cases"),
    ("cases", "cases"),
    ("held", "held"),
];

fn verdict_section(found: &Found) -> Section {
    let laws: Vec<_> = ordered(found).into_iter().map(|law| row(found, law)).collect();
    let table = html! {
        p.muted {
            "Defects of identities are in units of round-off, those of orders are distances of slopes. The bars count cases by "
            "log₁₀(defect/bound), on a logarithmic scale; the line at 1 is the bound, the leftmost bar is for all that is "
            "smaller. Broken laws are first; the others are in the order of the theory."
        }
        (script::tools(&ORDERS, laws.len()))
        (verdicts::table(&[("ratio", Some("ratio")), ("defect/bound", None)], &laws))
        p #no-law hidden { "No law has all of these words." }
    };
    ("verdicts", "Verdicts", table)
}

/// A law of the table.
fn row<'a>(found: &Found, (law, tally): (&'a ManifestLaw, &Tally)) -> verdicts::Row<'a> {
    let (name, line) = (&law.name, tally.found.line());
    let missing = planned(&found.manifest, law).map_or(0, |planned| planned.saturating_sub(line.cases));
    let more = vec![
        verdicts::cell("ratio", html! { (line.ratio.map_or("–".into(), scientific)) }),
        html! { td.chart role="cell" { (chart::histogram(name, &tally.histogram)) } },
    ];
    verdicts::Row { name, about: laws::named(name).map(|law| &law.about), line, missing, more }
}
