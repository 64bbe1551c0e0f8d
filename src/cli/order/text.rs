//! What `order` prints.

use super::super::levels;
use super::super::schema::object;
use super::super::summary::count;
use super::super::table::{entries, paragraph};
use super::{Outcome, Source, word};
use euler_poincare::external::Slopes;
use euler_poincare::harness::convergence::Estimate;
use euler_poincare::scalar::Number;
use euler_poincare::study::Findings;
use euler_poincare::tableau::analysis::Findings as Orders;
use euler_poincare::tableau::failing::Failing;
use euler_poincare::tableau::{Analysis, Order};
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// Failing conditions that are printed; the JSON has all that were found.
const SHOWN: usize = 6;

/// What is compared.
const MEANING: &str = "\
A method has order p if its errors shrink as the p-th power of the step h. The order is computed from the coefficients of the \
tableau, and measured: errors are relative, and the slope is that of log error against log h.";

/// Where the rest is.
const MORE: &str = "-v prints the conditions and the errors behind these orders; --plot FILE.svg draws the errors.";

/// The verdict, the three numbers, and what qualifies them; if asked for, what is behind them, and the tables of errors.
pub fn text(outcome: &Outcome, verbose: bool) -> String {
    let analysis = &outcome.analysis;
    let mut rows = vec![("tableau", tableau(outcome))];
    rows.push(("declared", declared(outcome)));
    rows.push(("classical", computed(outcome, |o| &o.classical)));
    rows.push(("variational", computed(outcome, |o| &o.variational)));
    rows.push(("measured", measured(outcome)));
    let verdict = entries(0, [("verdict", verdict(outcome))]);
    let mut notes: Vec<String> = analysis.notes();
    notes.extend(outcome.notes.iter().cloned());
    notes.extend(outcome.judged.explanation.clone());
    notes.extend(outcome.judged.trial.warnings.iter().map(|warning| format!("Warning: {warning}.")));
    let notes: Vec<(&str, String)> = notes.into_iter().map(|note| ("note", note)).collect();
    if !verbose {
        rows.extend(analysis.findings().hints().into_iter().map(|hint| ("because", hint)));
        rows.extend(notes);
        return format!("{verdict}\n\n{}\n\n{}\n", entries(0, rows), paragraph(MORE));
    }
    rows.push(("assumed", assumptions(outcome)));
    let mut text = format!("{verdict}\n\n{}\n\n{}\n", paragraph(MEANING), entries(0, rows));
    if !notes.is_empty() {
        text += &format!("\n{}\n", entries(0, notes));
    }
    text + &details(outcome) + &format!("\n{verdict}\n")
}

/// The conditions that fail, and the errors of both studies.
fn details(outcome: &Outcome) -> String {
    let mut text = String::new();
    let orders = outcome.analysis.findings();
    let (classical, variational) = (&orders.failing_classical, &orders.failing_variational);
    if let Some(failing) = classical {
        text += &format!("\n{}", conditions("classical", failing));
    }
    if let Some(failing) = variational.as_ref().filter(|_| variational != classical) {
        text += &format!("\n{}", conditions("variational", failing));
    }
    let hints = orders.hints();
    if !hints.is_empty() {
        text += &format!("{}\n", entries(2, hints.into_iter().map(|hint| ("because", hint))));
    }
    let trial = &outcome.judged.trial;
    text += &format!(
        "\nErrors after {}, {} digits\n{}\n",
        outcome.horizon,
        outcome.digits.number(),
        errors(&trial.horizon)
    );
    text + &format!("\nErrors after two steps (slopes less one)\n{}\n", errors(&trial.descent))
}

fn tableau(outcome: &Outcome) -> String {
    let analysis = &outcome.analysis;
    let stages = count(analysis.stages, "stage");
    let name = match analysis.description == outcome.tableau || analysis.description.starts_with("a = ") {
        true => outcome.tableau.clone(),
        false => format!("{} ({})", outcome.tableau, analysis.description),
    };
    let symplectic = if analysis.symplectic { ", symplectic" } else { "" };
    let symmetric = if analysis.symmetry.holds() { ", symmetric" } else { "" };
    format!("{name}: {stages}, {}{symmetric}{symplectic}, {}", analysis.shape, analysis.stability)
}

fn declared(outcome: &Outcome) -> String {
    let (Some(declared), Some(source)) = (outcome.analysis.declared, outcome.declared_by) else {
        return "none: the computed order is compared with the measured one".into();
    };
    let source = match source {
        Source::Option => "--declared",
        Source::File => "in the file",
    };
    format!("{declared}  ({source}): the order of the variational integrator")
}

/// The order, how it was found, and that of exactly the digits given.
fn computed(outcome: &Outcome, of: impl Fn(&Orders) -> &Order) -> String {
    let analysis = &outcome.analysis;
    let (findings, order) = (analysis.findings(), of(analysis.findings()));
    let how = match (&analysis.to_digits, analysis.exact) {
        (Some(_), _) => "to the digits given",
        (None, true) => "exact, in rationals",
        (None, false) => "from the coefficients",
    };
    let assumed = &findings.assumptions;
    let basis = match (order.is_exact(), &order.broken) {
        (true, Some(_)) => String::new(),
        (true, None) => format!(", by {}, {} and {}", assumed.b, assumed.c, assumed.d),
        (false, _) if analysis.to_digits.is_some() => String::new(),
        (false, _) => format!("; checked up to order {}, and no condition fails", order.order),
    };
    let typed = match &analysis.to_digits {
        Some(_) => format!("; {} with exactly these digits", of(&analysis.exactly)),
        None => String::new(),
    };
    format!("{order}  ({how}{basis}{typed})")
}

fn measured(outcome: &Outcome) -> String {
    let trial = &outcome.judged.trial;
    match outcome.measured() {
        Some((study, quantity, Estimate::Slope { value, low, high, window })) => {
            let what = &trial.horizon.quantities()[quantity];
            let study = if study == "horizon" { "over the horizon" } else { "after two steps, less one" };
            format!(
                "{value:.3} in [{low:.3}, {high:.3}]  ({what}, {study}, steps {:.2e} to {:.2e})",
                window.0, window.1
            )
        }
        _ => "none".into(),
    }
}

fn verdict(outcome: &Outcome) -> String {
    let order = &outcome.analysis.findings().variational;
    let whose = if outcome.analysis.to_digits.is_some() { ", to the digits given" } else { "" };
    let verdict = &outcome.judged.verdict;
    let why = verdict.why().map_or_else(|| format!("the order is {order}{whose}"), str::to_owned);
    format!("{}: {why}", word(verdict))
}

fn assumptions(outcome: &Outcome) -> String {
    let assumed = &outcome.analysis.findings().assumptions;
    [&assumed.b, &assumed.c, &assumed.d].map(ToString::to_string).join(", ")
}

fn conditions(name: &str, failing: &Failing) -> String {
    let title =
        format!("Conditions of {name} order {} that fail: {} of {}\n", failing.order, failing.count, failing.total);
    let mut rows: Vec<(String, String)> =
        failing.conditions.iter().take(SHOWN).map(|c| (c.tree.clone(), c.to_string())).collect();
    if failing.count > SHOWN {
        rows.push(("…".into(), format!("{} more (--format json lists them)", failing.count - rows.len())));
    }
    title + &entries(2, rows) + "\n"
}

/// A row for each level; below it why steps have none.
fn errors(findings: &Findings) -> String {
    let rows: Vec<_> = findings.rows().iter().map(|row| (row.steps, row.h)).collect();
    let refused = findings.rows().iter().filter_map(|row| row.readings.as_ref().err());
    let refused: BTreeSet<String> = refused.map(ToString::to_string).collect();
    let refused: String = refused.iter().map(|why| format!("\n{}", paragraph(&format!("none: {why}")))).collect();
    levels::table(&rows, &Slopes::with_infinite(findings)) + &refused
}

/// One object, `order/1`.
pub fn json(outcome: &Outcome) -> Value {
    let (analysis, trial) = (&outcome.analysis, &outcome.judged.trial);
    let orders = analysis.findings();
    let measured = match outcome.measured() {
        Some((study, quantity, Estimate::Slope { value, low, high, window })) => json!({
            "slope": value, "low": low, "high": high,
            "study": study, "quantity": trial.horizon.quantities()[quantity], "window": [window.0, window.1],
        }),
        _ => Value::Null,
    };
    let mut notes = analysis.notes();
    notes.extend(outcome.notes.iter().cloned());
    notes.extend(outcome.judged.explanation.clone());
    let assumed = &orders.assumptions;
    object(
        "order/1",
        json!({
            "tableau": outcome.tableau,
            "declared": analysis.declared,
            "declared_by": outcome.declared_by.map(|source| match source {
                Source::Option => "option",
                Source::File => "file",
            }),
            "declared_holds": outcome.declared_holds(),
            "classical": order(&orders.classical, orders.failing_classical.as_ref()),
            "variational": order(&orders.variational, orders.failing_variational.as_ref()),
            "assumptions": { "B": assumed.b.holds, "C": assumed.c.holds, "D": assumed.d.holds },
            "because": orders.hints(),
            "rounded": rounded(analysis),
            "measured": measured,
            "verdict": word(&outcome.judged.verdict),
            "why": outcome.judged.verdict.why(),
            "notes": notes,
            "warnings": trial.warnings.iter().map(|warning| warning.name()).collect::<Vec<_>>(),
            "digits": outcome.digits.number(),
            "system": outcome.system,
            "horizon": outcome.horizon,
            "levels": { "horizon": rows(&trial.horizon), "descent": rows(&trial.descent) },
        }),
    )
}

/// An order, and the conditions of the next one that fail.
fn order(order: &Order, failing: Option<&Failing>) -> Value {
    json!({
        "order": order.order,
        "at_least": !order.is_exact(),
        "failing_count": failing.map_or(0, |failing| failing.count),
        "failing": failing.map_or(json!([]), |failing| json!(failing.conditions)),
    })
}

/// What rounded decimals leave open, and the orders of exactly these digits.
fn rounded(analysis: &Analysis) -> Value {
    let Some(entry) = &analysis.first_rounded else { return Value::Null };
    let typed = &analysis.exactly;
    let completion = analysis.completion.as_ref().map(|completion| {
        let texts = |row: &[Number]| row.iter().map(Number::to_string).collect::<Vec<_>>();
        let a: Vec<_> = completion.entries.a.iter().map(|row| texts(row)).collect();
        json!({ "a": a, "b": texts(&completion.entries.b), "moved": completion.moved })
    });
    json!({
        "first": entry,
        "allowed": analysis.allowed,
        "completion": completion,
        "typed": {
            "classical": order(&typed.classical, typed.failing_classical.as_ref()),
            "variational": order(&typed.variational, typed.failing_variational.as_ref()),
        },
    })
}

fn rows(findings: &Findings) -> Value {
    let row = |row: &euler_poincare::study::Row| {
        let readings = match &row.readings {
            Err(error) => json!({ "refused": error.to_string() }),
            Ok(readings) => {
                let named = findings.quantities().iter().zip(readings);
                named.map(|(name, r)| (name.clone(), json!({ "error": r.error, "noise": r.noise }))).collect()
            }
        };
        json!({ "steps": row.steps, "h": row.h, "readings": readings })
    };
    findings.rows().iter().map(row).collect()
}
