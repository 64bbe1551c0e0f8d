//! The work–precision plot: a panel for each problem, error across, time upwards, both logarithmic.

use crate::contender::Kind;
use crate::measure::Run;
use crate::plot::{Axes, Curve, Figure, Legend, Marker, Panel, Style};
use crate::report::{self, Report};
use std::error::Error;
use std::ops::Range;

/// Errors are drawn between these: beyond are rounding and what is of no use.
const ERRORS: Range<f64> = 1e-15..1e-3;

/// The error at which the contenders are compared for the order of the legend.
const COMPARED: f64 = 1e-10;

/// The figure as SVG text.
///
/// # Errors
/// Those of the drawing library.
pub fn svg(report: &Report) -> Result<String, Box<dyn Error>> {
    let names = ordered(report);
    let panel = |panel: &report::Panel| {
        // Ours last, on top of the others.
        let curves =
            names.iter().rev().map(|(style, name)| Curve { style: style.clone(), points: points(panel, name) });
        let axes = ("largest error of a component", "median time");
        let panel = Panel::new(panel.title.clone(), axes, Axes::LogLog, curves.collect());
        Panel { unit: Some(decade), reach: Some((ERRORS.start, ERRORS.end)), ..panel }
    };
    let machine = &report.machine;
    let flags = if machine.rustflags.is_empty() { "no special flags" } else { machine.rustflags };
    Figure {
        title: "Time of a solve against its largest error".into(),
        legend: Legend::Shared,
        panels: report.panels.iter().map(panel).collect(),
        note: format!("{}; {}; {flags}", machine.processor, machine.rustc),
    }
    .svg()
}

/// The contenders with their looks, the fastest first.
fn ordered(report: &Report) -> Vec<(Style, String)> {
    let mut runs: Vec<&Run> = Vec::new();
    for run in report.panels.iter().flat_map(report::Panel::contenders) {
        if runs.iter().all(|known| known.contender != run.contender) {
            runs.push(run);
        }
    }
    let mut counts = [0; 3];
    let mut looks: Vec<(f64, Style, String)> = Vec::new();
    for run in runs {
        let time = |panel: &report::Panel| panel.entry(&run.contender, COMPARED).map(|entry| entry.time.ln());
        let times: Vec<f64> = report.panels.iter().filter_map(time).collect();
        let mean = if times.is_empty() { f64::INFINITY } else { times.iter().sum::<f64>() / times.len() as f64 };
        looks.push((mean, look(run, &mut counts), run.contender.clone()));
    }
    looks.sort_by(|a, b| a.0.total_cmp(&b.0));
    looks.into_iter().map(|(_, style, name)| (style, name)).collect()
}

/// Ours have one colour, the first is wide; packaged solvers differ by colour and marker; those by hand are dashed.
fn look(run: &Run, counts: &mut [usize; 3]) -> Style {
    const PACKAGED: [(usize, Marker); 7] = [
        (2, Marker::Triangle),
        (5, Marker::Square),
        (3, Marker::Diamond),
        (4, Marker::Funnel),
        (6, Marker::Frame),
        (7, Marker::Circle),
        (0, Marker::Ring),
    ];
    const OURS: [(f64, Marker); 3] = [(4.0, Marker::Circle), (2.0, Marker::Square), (2.0, Marker::Triangle)];
    const BY_HAND: [(usize, Marker); 2] = [(0, Marker::Cross), (7, Marker::Square)];
    let name = run.contender.clone();
    let mut next = |which: usize, looks: &[(usize, Marker)]| {
        counts[which] += 1;
        looks[(counts[which] - 1) % looks.len()]
    };
    match run.kind {
        Kind::Ours => {
            counts[2] += 1;
            let (width, marker) = OURS[(counts[2] - 1) % OURS.len()];
            Style::new(name, 1).marked(marker).wide(width)
        }
        Kind::Packaged => {
            let (colour, marker) = next(0, &PACKAGED);
            Style::new(name, colour).marked(marker)
        }
        Kind::ByHand => {
            let (colour, marker) = next(1, &BY_HAND);
            Style::new(name, colour).marked(marker).dashed(true)
        }
    }
}

/// (error, time) of the runs of a contender, by tolerance.
fn points(panel: &report::Panel, name: &str) -> Vec<(f64, f64)> {
    let point = |run: &Run| Some((run.error?.max(ERRORS.start), run.time?.median));
    let runs = panel.runs.iter().filter(|run| run.contender == name);
    runs.filter_map(point).filter(|point| point.0 <= ERRORS.end).collect()
}

/// A power of ten of a second.
fn decade(exponent: i32) -> String {
    let thousandths = (-f64::from(exponent) / 3.0).ceil().clamp(0.0, 3.0);
    let unit = ["s", "ms", "µs", "ns"][thousandths as usize];
    format!("{:.0} {unit}", 10f64.powf(f64::from(exponent) + 3.0 * thousandths))
}
