//! Small figures: SVG within the page, coloured by its style sheet, so that they follow light and dark.

use super::again::Curve;
use super::tally::Histogram;
use euler_poincare::harness::convergence::{Level, LevelKind};
use maud::{Markup, html};
use std::fmt::Write;

/// A path of bars.
fn bars(heights: impl Iterator<Item = (usize, f64)>, width: f64, floor: f64) -> String {
    let mut path = String::new();
    for (bin, height) in heights.filter(|(_, height)| *height > 0.0) {
        // Writing to a String cannot fail.
        let _ = write!(path, "M{:.1} {floor}v-{height:.1}h{:.1}v{height:.1}z", bin as f64 * width + 0.5, width - 1.0);
    }
    path
}

/// log₁₀(defect/bound) of the cases of a law; heights go with the logarithm of the number, so that one case shows.
pub fn histogram(law: &str, histogram: &Histogram) -> Markup {
    const WIDTH: f64 = 6.0;
    const HEIGHT: f64 = 34.0;
    let counts = histogram.counts();
    let most = counts.iter().copied().max().unwrap_or(0);
    if most == 0 {
        return html! { span.muted { "nothing judged" } };
    }
    let height = |count: usize| (1.0 + count as f64).ln() / (1.0 + most as f64).ln() * HEIGHT;
    let bound = Histogram::above_bound();
    let all = || counts.iter().enumerate().map(|(bin, count)| (bin, if *count > 0 { height(*count) } else { 0.0 }));
    let (below, above) = (bars(all().take(bound), WIDTH, HEIGHT + 2.0), bars(all().skip(bound), WIDTH, HEIGHT + 2.0));
    let place =
        |exponent: i32| WIDTH + (f64::from(exponent) - Histogram::LOWEST) * WIDTH * Histogram::PER_DECADE as f64;
    let full = counts.len() as f64 * WIDTH;
    html! {
        svg.histogram viewBox=(format!("0 0 {full} 50")) role="img" aria-label=(told(law, histogram)) {
            path.bar d=(below) {}
            path.bad d=(above) {}
            path.axis d=(format!("M0 {0}H{full}", HEIGHT + 2.5)) {}
            path.bound d=(format!("M{0} 0V{1}", place(0), HEIGHT + 6.0)) {}
            @for exponent in [-6, -4, -2] {
                path.axis d=(format!("M{0} {1}v3", place(exponent), HEIGHT + 2.5)) {}
                text x=(place(exponent)) y="49" text-anchor="middle" { (power(1, exponent, false)) }
            }
            text.strong x=(place(0)) y="49" text-anchor="middle" { "1" }
        }
    }
}

/// The histogram in words.
fn told(law: &str, histogram: &Histogram) -> String {
    let counts = histogram.counts();
    let total: usize = counts.iter().sum();
    let mut sum = 0;
    let middle = counts.iter().position(|count| {
        sum += count;
        2 * sum >= total
    });
    let edge = |bin: usize| Histogram::LOWEST + bin as f64 / Histogram::PER_DECADE as f64;
    let middle = middle.map(|bin| format!("1e{:.1}", edge(bin))).unwrap_or_default();
    let above: usize = counts.iter().skip(Histogram::above_bound()).sum();
    format!("{law}: defect over bound of {total} cases, half of them below {middle}, {above} above the bound")
}

/// A logarithmic axis: its ends in decades, and in pixels.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    fn new(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Option<Self> {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            return None;
        }
        let margin = (0.06 * (high - low)).max(0.05);
        Some(Self { low: low - margin, high: high + margin, from, to })
    }

    /// Where the value with this logarithm is.
    fn at(&self, log: f64) -> f64 {
        self.from + (log - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Powers of ten, six or so; within two decades also 2 and 5 times those.
    fn ticks(&self) -> Vec<(f64, Markup)> {
        let (first, last) = (self.low.floor() as i32, self.high.ceil() as i32);
        let every = (f64::from(last - first) / 6.0).ceil().max(1.0) as i32;
        let mantissas: &[u32] = if self.high - self.low < 2.0 { &[1, 2, 5] } else { &[1] };
        let decades = (first..=last).filter(|decade| decade.rem_euclid(every) == 0);
        let ticks = decades.flat_map(|decade| {
            let tick =
                move |m: &u32| (f64::from(decade) + f64::from(*m).log10(), power(*m, decade, mantissas.len() > 1));
            mantissas.iter().map(tick)
        });
        ticks.filter(|(log, _)| (self.low..=self.high).contains(log)).collect()
    }
}

/// A mantissa times a power of ten: as a decimal fraction where that is short, else with a raised exponent.
fn power(mantissa: u32, exponent: i32, decimal: bool) -> Markup {
    if decimal && (-3..=3).contains(&exponent) {
        let digits = (-exponent).max(0) as usize;
        return html! { (format!("{:.digits$}", f64::from(mantissa) * 10f64.powi(exponent))) };
    }
    html! {
        @if mantissa > 1 { (mantissa) "·" }
        "10" tspan dy="-4" font-size="7.5" { (exponent.to_string().replace('-', "−")) }
    }
}

const WIDTH: f64 = 380.0;
const HEIGHT: f64 = 270.0;
const LEFT: f64 = 50.0;
const BOTTOM: f64 = 34.0;

/// Error against step of the quantities of a case, with the slopes that were predicted.
pub fn order(label: &str, curves: &[Curve]) -> Markup {
    let shown = |level: &Level| level.h > 0.0 && level.h.is_finite() && level.error > 0.0 && level.error.is_finite();
    let points = |curve: &Curve| -> Vec<(f64, f64, LevelKind)> {
        let levels = curve.levels.iter().filter(|(level, _)| shown(level));
        let mut points: Vec<_> = levels.map(|(level, kind)| (level.h.log10(), level.error.log10(), *kind)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let lines: Vec<Vec<(f64, f64, LevelKind)>> = curves.iter().map(points).collect();
    let all = || lines.iter().flatten();
    let x = Axis::new(all().map(|point| point.0), LEFT, WIDTH - 10.0);
    let y = Axis::new(all().map(|point| point.1), HEIGHT - BOTTOM, 10.0);
    let (Some(x), Some(y)) = (x, y) else {
        return html! { p.muted { "No level has an error that a logarithmic axis can show." } };
    };
    html! {
        svg.order viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="img" aria-label=(label) {
            @for (log, name) in x.ticks() {
                path.grid d=(format!("M{:.1} 10V{}", x.at(log), HEIGHT - BOTTOM)) {}
                text x=(format!("{:.1}", x.at(log))) y=(HEIGHT - BOTTOM + 14.0) text-anchor="middle" { (name) }
            }
            @for (log, name) in y.ticks() {
                path.grid d=(format!("M{LEFT} {:.1}H{}", y.at(log), WIDTH - 10.0)) {}
                text x=(LEFT - 5.0) y=(format!("{:.1}", y.at(log) + 3.5)) text-anchor="end" { (name) }
            }
            path.axis d=(format!("M{LEFT} 10V{0}H{1}", HEIGHT - BOTTOM, WIDTH - 10.0)) {}
            text x=((LEFT + WIDTH - 10.0) / 2.0) y=(HEIGHT - 5.0) text-anchor="middle" { "step h" }
            @for (k, (curve, line)) in curves.iter().zip(&lines).enumerate() {
                g class=(series(k)) {
                    @if let Some(expected) = curve.expected { (predicted(&x, &y, line, expected)) }
                    path.curve d=(joined(&x, &y, line)) {}
                    @for point in line { (mark(x.at(point.0), y.at(point.1), point.2, k)) }
                }
            }
        }
    }
}

/// The class that gives a curve its colour.
fn series(k: usize) -> &'static str {
    ["series-0", "series-1", "series-2", "series-3"][k.min(3)]
}

fn joined(x: &Axis, y: &Axis, line: &[(f64, f64, LevelKind)]) -> String {
    let mut path = String::new();
    for (k, point) in line.iter().enumerate() {
        let _ = write!(path, "{}{:.1} {:.1}", if k == 0 { 'M' } else { 'L' }, x.at(point.0), y.at(point.1));
    }
    path
}

/// The slope that was predicted, through the finest level on the line (else the coarsest of all), a little to the side.
fn predicted(x: &Axis, y: &Axis, line: &[(f64, f64, LevelKind)], slope: u32) -> Markup {
    let on_line = line.iter().find(|point| point.2 == LevelKind::Asymptotic);
    let Some(anchor) = on_line.or(line.last()) else { return html! {} };
    let height = |log: f64| anchor.1 + f64::from(slope) * (log - anchor.0);
    // Only as far as the frame goes.
    let reach = |error: f64| anchor.0 + (error - anchor.1) / f64::from(slope.max(1));
    let (from, to) = (x.low.max(reach(y.low)), x.high.min(reach(y.high)));
    if slope == 0 || from >= to {
        return html! {};
    }
    html! {
        path.predicted d=(format!("M{:.1} {:.1}L{:.1} {:.1}", x.at(from), y.at(height(from)), x.at(to), y.at(height(to)))) {}
    }
}

/// A mark whose shape tells the quantity, and whose filling what the level is.
fn mark(x: f64, y: f64, kind: LevelKind, k: usize) -> Markup {
    let class = match kind {
        LevelKind::Asymptotic => "asymptotic",
        LevelKind::PreAsymptotic => "pre-asymptotic",
        LevelKind::Noise => "noise",
    };
    if kind == LevelKind::Noise {
        return html! { path class=(class) d=(format!("M{:.1} {:.1}l6 6m0-6l-6 6", x - 3.0, y - 3.0)) {} };
    }
    match k {
        0 => html! { circle class=(class) cx=(format!("{x:.1}")) cy=(format!("{y:.1}")) r="3.6" {} },
        1 => html! { path class=(class) d=(format!("M{:.1} {:.1}h7v7h-7z", x - 3.5, y - 3.5)) {} },
        _ => html! { path class=(class) d=(format!("M{:.1} {:.1}l4.2 7.4h-8.4z", x, y - 4.6)) {} },
    }
}

/// A mark by itself, for a legend.
pub fn key(kind: LevelKind, k: usize) -> Markup {
    html! { svg class={ "key " (series(k)) } viewBox="0 0 14 14" aria-hidden="true" { (mark(7.0, 7.0, kind, k)) } }
}
