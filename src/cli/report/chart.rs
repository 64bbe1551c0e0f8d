//! Small figures: SVG within the page, coloured by its style sheet, so that they follow light and dark.

use super::numbers::counted;
use super::tally::Histogram;
use crate::cli::plot::{Scale, power};
use euler_poincare::harness::convergence::LevelKind;
use maud::{Markup, html};
use std::ops::Range;

/// log₁₀(defect/bound) of the cases of a law; heights go with the logarithm of the number, so that one case shows.
pub fn histogram(law: &str, histogram: &Histogram) -> Markup {
    const WIDTH: f64 = 6.0;
    const HEIGHT: f64 = 34.0;
    let counts = histogram.counts();
    let most = counts.iter().copied().max().unwrap_or(0);
    if most == 0 {
        return html! { span.muted { "nothing judged" } };
    }
    let bar = |bin: usize| {
        let height = (1.0 + counts[bin] as f64).ln() / (1.0 + most as f64).ln() * HEIGHT;
        let (left, floor, width) = (bin as f64 * WIDTH + 0.5, HEIGHT + 2.0, WIDTH - 1.0);
        format!("M{left:.1} {floor}v-{height:.1}h{width:.1}v{height:.1}z")
    };
    let bars = |bins: Range<usize>| bins.filter(|bin| counts[*bin] > 0).map(bar).collect::<String>();
    let bound = Histogram::above_bound();
    let (below, above) = (bars(0..bound), bars(bound..counts.len()));
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
                text x=(place(exponent)) y="49" text-anchor="middle" { (power("10", exponent)) }
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

const WIDTH: f64 = 380.0;
const HEIGHT: f64 = 270.0;
const LEFT: f64 = 50.0;
const BOTTOM: f64 = 34.0;

/// The errors of one quantity.
pub struct Curve {
    /// What it is the error of.
    pub quantity: String,
    /// Step, error, and what the level is to the line.
    pub levels: Vec<(f64, f64, LevelKind)>,
    /// The slope or the order that they show, with its interval; or why there is none.
    pub found: Result<(f64, [f64; 2]), String>,
    /// What was predicted or claimed.
    pub expected: Option<u32>,
    /// By how much the slope of the errors exceeds that.
    pub excess: u32,
}

/// Error against step of the quantities of a case, and what they show in words: `slope`, `predicted`; `order`, `claimed`.
pub fn order(label: &str, curves: &[Curve], words: [&str; 2]) -> Markup {
    html! {
        (drawn(&format!("{label}: error against step"), curves))
        ul.curves { @for (k, curve) in curves.iter().enumerate() { li { (key(LevelKind::Asymptotic, k)) (shown(curve, words)) } } }
    }
}

fn shown(curve: &Curve, [what, expected]: [&str; 2]) -> Markup {
    let noughts = curve.levels.iter().filter(|(_, error, _)| error.is_nan() || *error <= 0.0).count();
    html! {
        (curve.quantity) ": "
        @match &curve.found {
            Ok((value, [low, high])) => { (what) " " b { (format!("{value:.3}")) } (format!(" in [{low:.3}, {high:.3}]")) }
            Err(why) => { "no " (what) ": " (why) }
        }
        @if let Some(number) = curve.expected { ", " (expected) "\u{a0}" b { (number) } }
        @if noughts > 0 { "; " (counted(noughts, "level")) " without an error cannot be drawn" }
    }
}

/// The logarithms of step and error, and what the level is.
type Point = (f64, f64, LevelKind);

fn drawn(label: &str, curves: &[Curve]) -> Markup {
    let positive = |x: f64| x > 0.0 && x.is_finite();
    let points = |curve: &Curve| -> Vec<Point> {
        let levels = curve.levels.iter().filter(|(h, error, _)| positive(*h) && positive(*error));
        let mut points: Vec<_> = levels.map(|(h, error, kind)| (h.log10(), error.log10(), *kind)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points
    };
    let lines: Vec<Vec<Point>> = curves.iter().map(points).collect();
    let all = || lines.iter().flatten();
    if all().next().is_none() {
        return html! { p.muted { "No level has an error that a logarithmic axis can show." } };
    }
    let x = Scale::new(all().map(|point| point.0), true, 0.06, None);
    let y = Scale::new(all().map(|point| point.1), true, 0.06, None);
    // Where the step and the error with these logarithms are.
    let across = |log: f64| LEFT + x.fraction(log) * (WIDTH - 10.0 - LEFT);
    let down = |log: f64| HEIGHT - BOTTOM - y.fraction(log) * (HEIGHT - BOTTOM - 10.0);
    let joined = |places: &mut dyn Iterator<Item = (f64, f64)>| {
        let places: Vec<String> = places.map(|(x, y)| format!("{:.1} {:.1}", across(x), down(y))).collect();
        format!("M{}", places.join("L"))
    };
    html! {
        svg.order viewBox=(format!("0 0 {WIDTH} {HEIGHT}")) role="img" aria-label=(label) {
            @for (log, name) in &x.ticks {
                path.grid d=(format!("M{:.1} 10V{}", across(*log), HEIGHT - BOTTOM)) {}
                text x=(format!("{:.1}", across(*log))) y=(HEIGHT - BOTTOM + 14.0) text-anchor="middle" { (name) }
            }
            @for (log, name) in &y.ticks {
                path.grid d=(format!("M{LEFT} {:.1}H{}", down(*log), WIDTH - 10.0)) {}
                text x=(LEFT - 5.0) y=(format!("{:.1}", down(*log) + 3.5)) text-anchor="end" { (name) }
            }
            path.axis d=(format!("M{LEFT} 10V{0}H{1}", HEIGHT - BOTTOM, WIDTH - 10.0)) {}
            text x=((LEFT + WIDTH - 10.0) / 2.0) y=(HEIGHT - 5.0) text-anchor="middle" { "step h" }
            @for (k, (curve, line)) in curves.iter().zip(&lines).enumerate() {
                g class=(series(k)) {
                    @if let Some(ends) = curve.expected.and_then(|order| predicted([&x, &y], line, order + curve.excess)) {
                        path.predicted d=(joined(&mut ends.into_iter())) {}
                    }
                    @if !line.is_empty() { path.curve d=(joined(&mut line.iter().map(|point| (point.0, point.1)))) {} }
                    @for point in line { (mark(across(point.0), down(point.1), point.2, k)) }
                }
            }
        }
    }
}

/// The class that gives a curve its colour.
fn series(k: usize) -> &'static str {
    ["series-0", "series-1", "series-2", "series-3"][k.min(3)]
}

/// The ends of the slope that was predicted, through the finest level on the line (else the coarsest of all), as far as the frame goes.
fn predicted([x, y]: [&Scale; 2], line: &[Point], slope: u32) -> Option<[(f64, f64); 2]> {
    let anchor = line.iter().find(|point| point.2 == LevelKind::Asymptotic).or(line.last())?;
    let reach = |error: f64| anchor.0 + (error - anchor.1) / f64::from(slope.max(1));
    let (from, to) = (x.range.start.max(reach(y.range.start)), x.range.end.min(reach(y.range.end)));
    let end = |log: f64| (log, anchor.1 + f64::from(slope) * (log - anchor.0));
    (slope > 0 && from < to).then(|| [end(from), end(to)])
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
