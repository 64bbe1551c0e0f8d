//! Figures of panels side by side with one legend below them, as SVG.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::prelude::*;
use std::error::Error;
use std::ops::Range;

type Outcome = Result<(), Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Distinguishable without colour vision (Okabe and Ito 2008), and by shape in print.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 0, 0),
    RGBColor(213, 94, 0),
    RGBColor(0, 114, 178),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(110, 110, 110),
];

const WIDTH: u32 = 1080;
const PANEL: u32 = 430;
const LEGEND_ROW: i32 = 26;
const LEGEND_COLUMNS: usize = 4;

/// A shape on a curve's points.
#[derive(Clone, Copy, PartialEq)]
pub enum Marker {
    None,
    Circle,
    Triangle,
    Cross,
}

/// How a curve looks; curves of one name in several panels share it.
#[derive(Clone)]
pub struct Style {
    pub name: String,
    /// An index of the palette.
    pub colour: usize,
    pub dashed: bool,
    pub marker: Marker,
}

/// Points in the order in which they are joined.
pub struct Curve {
    pub style: Style,
    pub points: Vec<(f64, f64)>,
}

/// Which axes are logarithmic.
#[derive(Clone, Copy, PartialEq)]
pub enum Axes {
    Linear,
    LogY,
    LogLog,
}

pub struct Panel {
    pub title: String,
    pub x: &'static str,
    pub y: &'static str,
    pub axes: Axes,
    pub curves: Vec<Curve>,
}

/// Panels, two in a row.
pub struct Figure {
    pub title: String,
    pub panels: Vec<Panel>,
}

impl Figure {
    /// The figure as SVG text.
    pub fn svg(&self) -> Result<String, Box<dyn Error>> {
        let styles = self.styles();
        let rows = self.panels.len().div_ceil(2) as u32;
        let legend = styles.len().div_ceil(LEGEND_COLUMNS) as i32 * LEGEND_ROW + 16;
        let height = 46 + rows * PANEL + legend as u32;
        let mut text = String::new();
        {
            let root = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
            root.fill(&WHITE)?;
            let titled = root.titled(&self.title, ("sans-serif", 24))?;
            let (top, bottom) = titled.split_vertically((rows * PANEL) as i32);
            for (area, panel) in top.split_evenly((rows as usize, 2)).iter().zip(&self.panels) {
                panel.draw(area)?;
            }
            draw_legend(&bottom, &styles)?;
            root.present()?;
        }
        Ok(text)
    }

    /// The styles of all curves, each once.
    fn styles(&self) -> Vec<&Style> {
        let mut styles: Vec<&Style> = Vec::new();
        for curve in self.panels.iter().flat_map(|p| &p.curves) {
            if styles.iter().all(|s| s.name != curve.style.name) {
                styles.push(&curve.style);
            }
        }
        styles
    }
}

fn draw_legend(area: &Area<'_>, styles: &[&Style]) -> Outcome {
    let width = (WIDTH as i32 - 80) / LEGEND_COLUMNS as i32;
    for (k, style) in styles.iter().enumerate() {
        let (x, y) = (60 + (k % LEGEND_COLUMNS) as i32 * width, 14 + (k / LEGEND_COLUMNS) as i32 * LEGEND_ROW);
        let colour = COLOURS[style.colour % COLOURS.len()];
        let pieces: &[(i32, i32)] = if style.dashed { &[(0, 8), (12, 20), (24, 32), (36, 44)] } else { &[(0, 44)] };
        for (from, to) in pieces {
            area.draw(&PathElement::new(vec![(x + from, y), (x + to, y)], colour.stroke_width(2)))?;
        }
        match style.marker {
            Marker::None => {}
            Marker::Circle => area.draw(&Circle::new((x + 22, y), 4, colour.filled()))?,
            Marker::Triangle => area.draw(&TriangleMarker::new((x + 22, y), 5, colour.filled()))?,
            Marker::Cross => area.draw(&Cross::new((x + 22, y), 4, colour.stroke_width(2)))?,
        }
        area.draw(&Text::new(style.name.clone(), (x + 54, y - 8), ("sans-serif", 19)))?;
    }
    Ok(())
}

impl Panel {
    fn draw(&self, area: &Area<'_>) -> Outcome {
        let (log_x, log_y) = (self.axes == Axes::LogLog, self.axes != Axes::Linear);
        let shown = |&(x, y): &(f64, f64)| x.is_finite() && y.is_finite() && (!log_x || x > 0.0) && (!log_y || y > 0.0);
        // Logarithms on linear axes with ticks of our own: plotters' logarithmic axis has none below 1e-14.
        let scaled = |p: &(f64, f64)| (if log_x { p.0.log10() } else { p.0 }, if log_y { p.1.log10() } else { p.1 });
        let curves: Vec<Vec<(f64, f64)>> =
            self.curves.iter().map(|c| c.points.iter().filter(|p| shown(p)).map(scaled).collect()).collect();
        let x = extent(curves.iter().flatten().map(|p| p.0), log_x, false);
        let y = extent(curves.iter().flatten().map(|p| p.1), log_y, log_y);
        let ticks = [ticks(&x, log_x), ticks(&y, log_y)];
        let (smallest, [x_ticks, y_ticks]) = (1e-9 * (y.end - y.start), ticks);
        let mut chart = ChartBuilder::on(area);
        chart.margin(12).margin_right(28).caption(&self.title, ("sans-serif", 20));
        chart.x_label_area_size(52).y_label_area_size(88);
        let mut chart =
            chart.build_cartesian_2d(Axis { range: x, ticks: x_ticks }, Axis { range: y, ticks: y_ticks })?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .axis_desc_style(("sans-serif", 19))
            .label_style(("sans-serif", 16))
            .x_label_formatter(&|v| if log_x { format!("1e{v:.0}") } else { format!("{v:.1}") })
            .y_label_formatter(&|v| match *v {
                v if log_y => format!("1e{v:.0}"),
                v if v.abs() < smallest => "0".into(),
                v => format!("{v:.1e}").replace(".0e", "e"),
            })
            .bold_line_style(RGBColor(222, 222, 222))
            .light_line_style(TRANSPARENT)
            .x_max_light_lines(0)
            .y_max_light_lines(0)
            .draw()?;
        for (curve, points) in self.curves.iter().zip(curves) {
            let colour = COLOURS[curve.style.colour % COLOURS.len()];
            let line = colour.stroke_width(2);
            if curve.style.dashed {
                chart.draw_series(DashedLineSeries::new(points.iter().copied(), 8, 5, line))?;
            } else {
                chart.draw_series(LineSeries::new(points.iter().copied(), line))?;
            }
            // Some ten markers at most: more would hide the line.
            let marked = points.iter().copied().step_by(points.len().div_ceil(14).max(1));
            match curve.style.marker {
                Marker::None => continue,
                Marker::Circle => chart.draw_series(marked.map(|p| Circle::new(p, 4, colour.filled())))?,
                Marker::Triangle => chart.draw_series(marked.map(|p| TriangleMarker::new(p, 5, colour.filled())))?,
                Marker::Cross => chart.draw_series(marked.map(|p| Cross::new(p, 4, colour.stroke_width(2))))?,
            };
        }
        Ok(())
    }
}

/// An axis with its ticks chosen.
struct Axis {
    range: Range<f64>,
    ticks: Vec<f64>,
}

impl Ranged for Axis {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let fraction = (value - self.range.start) / (self.range.end - self.range.start);
        limit.0 + (fraction * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.clone()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

/// The range of an axis: out to whole numbers if `whole`; else with a margin, unless it is [0, 1].
fn extent(values: impl Iterator<Item = f64>, log: bool, whole: bool) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high || (low == 0.0 && high == 1.0 && !log) {
        return 0.0..1.0;
    }
    if whole {
        return low.floor()..high.ceil().max(low.floor() + 1.0);
    }
    let margin = 0.05 * (high - low).max(f64::MIN_POSITIVE);
    low - margin..high + margin
}

/// Whole numbers if `log`, else multiples of 1, 2 or 5 times a power of ten: seven or so.
fn ticks(range: &Range<f64>, log: bool) -> Vec<f64> {
    let raw = (range.end - range.start) / 7.0;
    let unit = 10f64.powf(raw.log10().floor());
    let step = if log {
        raw.ceil().max(1.0)
    } else {
        [1.0, 2.0, 5.0, 10.0].map(|m| m * unit).into_iter().find(|s| *s >= raw).unwrap_or(raw)
    };
    let (first, last) = ((range.start / step).ceil() as i64, (range.end / step + 1e-9).floor() as i64);
    (first..=last).map(|k| k as f64 * step).collect()
}
