//! The work plot: errors against the step, with the fitted line and its window.

use super::super::plot::{Axes, Curve, Figure, Legend, Marker, Panel, Style};
use super::Outcome;
use euler_poincare::harness::convergence::Estimate;
use euler_poincare::study::Findings;

/// The figure.
pub fn figure(outcome: &Outcome) -> Figure {
    let (trial, order) = (&outcome.judged.trial, outcome.predicted());
    Figure {
        title: format!("{}: {}", outcome.tableau, super::word(&outcome.judged.verdict)),
        panels: vec![
            panel(format!("errors after time {}", outcome.horizon), &trial.horizon, order),
            panel("errors after two steps".into(), &trial.descent, order),
        ],
        legend: Legend::Shared,
        note: String::new(),
    }
}

fn panel(title: String, findings: &Findings, order: u32) -> Panel {
    let mut curves = Vec::new();
    for (quantity, name) in findings.quantities().iter().enumerate() {
        let markers = [Marker::Circle, Marker::Triangle, Marker::Cross, Marker::None];
        let style = Style::new(name.clone(), 1 + quantity).marked(markers[quantity.min(3)]);
        let points = findings.levels(quantity).iter().map(|level| (level.h, level.error)).collect();
        curves.push(Curve { style, points });
    }
    if let Some((points, name)) = fitted(findings, order) {
        curves.push(Curve { style: Style::new(name, 0).dashed(true), points });
    }
    Panel::new(title, ("step h", "error"), Axes::LogLog, curves)
}

/// The line of the limiting part of the state, drawn over its window, which it ends with.
fn fitted(findings: &Findings, order: u32) -> Option<(Vec<(f64, f64)>, String)> {
    let (quantity, estimate) = findings.deciding(order)?;
    let Estimate::Slope { value, window, .. } = estimate else { return None };
    let finest = findings.levels(quantity).into_iter().find(|level| level.h == window.1)?;
    let error = |h: f64| finest.error * (h / finest.h).powf(value + findings.excess());
    let what = &findings.quantities()[quantity];
    Some((vec![(window.0, error(window.0)), (window.1, finest.error)], format!("{what}: order {value:.3}")))
}
