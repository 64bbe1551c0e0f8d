//! The work–precision plot: a panel for each problem, error across, time upwards, both logarithmic.

use crate::contender::Kind;
use crate::measure::Run;
use crate::report::{Panel, Report};
use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::prelude::*;
use std::error::Error;
use std::ops::Range;

type Outcome = Result<(), Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

const WIDTH: u32 = 1120;
const PANEL: u32 = 420;
const COLUMNS: usize = 2;
const LEGEND_ROW: i32 = 26;
const LEGEND_COLUMNS: usize = 3;

/// Distinguishable without colour vision (Okabe and Ito 2008); the first is the strong one.
const COLOURS: [RGBColor; 8] = [
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(86, 180, 233),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(120, 120, 120),
    RGBColor(0, 0, 0),
];

/// Errors are drawn between these: beyond are rounding and what is of no use.
const ERRORS: Range<f64> = -15.2..-3.0;

/// How a contender is drawn.
struct Look {
    name: String,
    kind: Kind,
    index: usize,
}

impl Look {
    fn colour(&self) -> RGBColor {
        if self.kind == Kind::Ours { COLOURS[0] } else { COLOURS[1 + (self.index - 1) % (COLOURS.len() - 1)] }
    }

    fn line(&self) -> ShapeStyle {
        self.colour().stroke_width(if self.kind == Kind::Ours { 4 } else { 2 })
    }

    fn mark(&self, area: &Area<'_>, (x, y): (i32, i32)) -> Outcome {
        let colour = self.colour();
        match (self.kind, self.index % 3) {
            (Kind::Ours, _) => area.draw(&Circle::new((x, y), 6, colour.filled()))?,
            (Kind::ByHand, _) => area.draw(&Cross::new((x, y), 4, colour.stroke_width(2)))?,
            (Kind::Packaged, 0) => area.draw(&Circle::new((x, y), 4, colour.filled()))?,
            (Kind::Packaged, 1) => area.draw(&TriangleMarker::new((x, y), 5, colour.filled()))?,
            (Kind::Packaged, _) => area.draw(&Rectangle::new([(x - 4, y - 4), (x + 4, y + 4)], colour.filled()))?,
        }
        Ok(())
    }

    /// A line through points of the canvas, dashed if it is by hand.
    fn path(&self, area: &Area<'_>, points: &[(i32, i32)]) -> Outcome {
        for pair in points.windows(2) {
            let (from, to) = (pair[0], pair[1]);
            let (dx, dy) = (f64::from(to.0 - from.0), f64::from(to.1 - from.1));
            let pieces = if self.kind == Kind::ByHand { (dx.hypot(dy) / 12.0).ceil().max(1.0) } else { 1.0 };
            let shown = if self.kind == Kind::ByHand { 0.6 } else { 1.0 };
            let at = |t: f64| (from.0 + (t * dx).round() as i32, from.1 + (t * dy).round() as i32);
            for piece in 0..pieces as usize {
                let ends = vec![at(piece as f64 / pieces), at((piece as f64 + shown) / pieces)];
                area.draw(&PathElement::new(ends, self.line()))?;
            }
        }
        Ok(())
    }
}

/// The figure as SVG text.
///
/// # Errors
/// Those of the drawing library.
pub fn svg(report: &Report) -> Result<String, Box<dyn Error>> {
    let mut looks: Vec<Look> = Vec::new();
    for run in report.panels.iter().flat_map(Panel::contenders) {
        if looks.iter().all(|l| l.name != run.contender) {
            looks.push(Look { name: run.contender.clone(), kind: run.kind, index: looks.len() });
        }
    }
    let rows = report.panels.len().div_ceil(COLUMNS).max(1);
    let legend = looks.len().div_ceil(LEGEND_COLUMNS) as i32 * LEGEND_ROW + 58;
    let height = 46 + rows as u32 * PANEL + legend as u32;
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        root.fill(&WHITE)?;
        let titled = root.titled("Time of a solve against its largest error", ("sans-serif", 24))?;
        let (top, bottom) = titled.split_vertically((rows as u32 * PANEL) as i32);
        for (area, panel) in top.split_evenly((rows, COLUMNS)).iter().zip(&report.panels) {
            draw_panel(area, panel, &looks)?;
        }
        draw_legend(&bottom, &looks, report)?;
        root.present()?;
    }
    Ok(text)
}

/// (log₁₀ error, log₁₀ time) of the runs of a contender, by tolerance.
fn points(panel: &Panel, name: &str) -> Vec<(f64, f64)> {
    let point = |run: &Run| Some((run.error?.max(1e-30).log10().max(ERRORS.start), run.time?.median.log10()));
    let runs = panel.runs.iter().filter(|r| r.contender == name);
    runs.filter_map(point).filter(|p| p.0 <= ERRORS.end).collect()
}

fn draw_panel(area: &Area<'_>, panel: &Panel, looks: &[Look]) -> Outcome {
    let curves: Vec<Vec<(f64, f64)>> = looks.iter().map(|look| points(panel, &look.name)).collect();
    let times = curves.iter().flatten().map(|p| p.1);
    let (low, high) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), t| (l.min(t), h.max(t)));
    let range = if low < high { low.floor()..high.ceil() } else { -7.0..-3.0 };
    let mut chart = ChartBuilder::on(area);
    chart.margin(12).margin_right(28).caption(&panel.title, ("sans-serif", 20));
    chart.x_label_area_size(50).y_label_area_size(84);
    let mut chart = chart.build_cartesian_2d(Decades(ERRORS), Decades(range))?;
    chart
        .configure_mesh()
        .x_desc("largest error of a component")
        .y_desc("median time")
        .axis_desc_style(("sans-serif", 18))
        .label_style(("sans-serif", 16))
        .x_label_formatter(&|v| format!("1e{v:.0}"))
        .y_label_formatter(&|v| decade(*v))
        .bold_line_style(RGBColor(222, 222, 222))
        .light_line_style(TRANSPARENT)
        .x_max_light_lines(0)
        .y_max_light_lines(0)
        .draw()?;
    // Ours last, on top of the others.
    for (look, curve) in looks.iter().zip(&curves).rev() {
        let canvas: Vec<(i32, i32)> = curve.iter().map(|p| chart.backend_coord(p)).collect();
        let base = area.get_base_pixel();
        let canvas: Vec<(i32, i32)> = canvas.into_iter().map(|(x, y)| (x - base.0, y - base.1)).collect();
        look.path(area, &canvas)?;
        for point in canvas {
            look.mark(area, point)?;
        }
    }
    Ok(())
}

fn draw_legend(area: &Area<'_>, looks: &[Look], report: &Report) -> Outcome {
    let width = (WIDTH as i32 - 80) / LEGEND_COLUMNS as i32;
    for (k, look) in looks.iter().enumerate() {
        let (x, y) = (60 + (k % LEGEND_COLUMNS) as i32 * width, 14 + (k / LEGEND_COLUMNS) as i32 * LEGEND_ROW);
        look.path(area, &[(x, y), (x + 44, y)])?;
        look.mark(area, (x + 22, y))?;
        area.draw(&Text::new(look.name.clone(), (x + 54, y - 9), ("sans-serif", 18)))?;
    }
    let below = 20 + looks.len().div_ceil(LEGEND_COLUMNS) as i32 * LEGEND_ROW;
    let machine = &report.machine;
    let flags = if machine.rustflags.is_empty() { "no special flags" } else { machine.rustflags };
    let line = format!("{}; {}; {flags}", machine.processor, machine.rustc);
    area.draw(&Text::new(line, (60, below), ("sans-serif", 15).into_font().color(&RGBColor(90, 90, 90))))?;
    Ok(())
}

/// A power of ten of a second.
fn decade(exponent: f64) -> String {
    let thousandths = (-exponent / 3.0).ceil().clamp(0.0, 3.0);
    let unit = ["s", "ms", "µs", "ns"][thousandths as usize];
    let value = 10f64.powf(exponent + 3.0 * thousandths);
    format!("{value:.0} {unit}")
}

/// A logarithmic axis with a tick at each power of ten; plotters' own has none below 1e-14.
struct Decades(Range<f64>);

impl Ranged for Decades {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let fraction = (value - self.0.start) / (self.0.end - self.0.start);
        limit.0 + (fraction * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        let step = if self.0.end - self.0.start > 8.0 { 2 } else { 1 };
        let (first, last) = (self.0.start.ceil() as i32, self.0.end.floor() as i32);
        (first..=last).filter(|k| k % step == 0).map(f64::from).collect()
    }

    fn range(&self) -> Range<f64> {
        self.0.clone()
    }
}
