//! Figures of panels side by side with one legend below them, as SVG.

use plotters::chart::ChartContext;
use plotters::coord::Shift;
use plotters::coord::ranged1d::ValueFormatter;
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
        let points = || self.curves.iter().flat_map(|c| &c.points).filter(|p| shown(p));
        let x = extent(points().map(|p| p.0), false, log_x);
        let y = extent(points().map(|p| p.1), log_y, log_y);
        let mut chart = ChartBuilder::on(area);
        chart.margin(12).margin_right(28).caption(&self.title, ("sans-serif", 20));
        chart.x_label_area_size(52).y_label_area_size(88);
        match self.axes {
            Axes::Linear => self.fill(chart.build_cartesian_2d(x, y)?, &shown),
            Axes::LogY => self.fill(chart.build_cartesian_2d(x, y.log_scale())?, &shown),
            Axes::LogLog => self.fill(chart.build_cartesian_2d(x.log_scale(), y.log_scale())?, &shown),
        }
    }

    fn fill<X, Y>(
        &self,
        mut chart: ChartContext<'_, SVGBackend<'_>, Cartesian2d<X, Y>>,
        shown: &impl Fn(&(f64, f64)) -> bool,
    ) -> Outcome
    where
        X: Ranged<ValueType = f64> + ValueFormatter<f64>,
        Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
    {
        let log_x = self.axes == Axes::LogLog;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .axis_desc_style(("sans-serif", 19))
            .label_style(("sans-serif", 16))
            .light_line_style(RGBColor(246, 246, 246))
            .bold_line_style(RGBColor(222, 222, 222))
            .x_labels(6)
            .y_labels(8)
            .x_label_formatter(&move |v| if log_x { scientific(*v) } else { format!("{v:.1}") })
            .y_label_formatter(&|v| scientific(*v))
            .draw()?;
        for curve in &self.curves {
            let colour = COLOURS[curve.style.colour % COLOURS.len()];
            let points: Vec<(f64, f64)> = curve.points.iter().copied().filter(|p| shown(p)).collect();
            let line = colour.stroke_width(2);
            if curve.style.dashed {
                chart.draw_series(DashedLineSeries::new(points.iter().copied(), 8, 5, line))?;
            } else {
                chart.draw_series(LineSeries::new(points.iter().copied(), line))?;
            }
            // Some ten markers at most: more would hide the line.
            let every = points.len().div_ceil(14).max(1);
            let marked = points.iter().copied().step_by(every);
            match curve.style.marker {
                Marker::None => {}
                Marker::Circle => drop(chart.draw_series(marked.map(|p| Circle::new(p, 4, colour.filled())))?),
                Marker::Triangle => {
                    drop(chart.draw_series(marked.map(|p| TriangleMarker::new(p, 5, colour.filled())))?)
                }
                Marker::Cross => drop(chart.draw_series(marked.map(|p| Cross::new(p, 4, colour.stroke_width(2))))?),
            }
        }
        Ok(())
    }
}

/// The range of an axis: whole decades if `decades`; linear ranges get a margin of 5 %, unless they start at 0.
fn extent(values: impl Iterator<Item = f64>, decades: bool, log: bool) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
    if low > high {
        return if log { 0.1..1.0 } else { 0.0..1.0 };
    }
    if decades {
        let (low, high) = (low.log10().floor(), high.log10().ceil());
        return 10f64.powf(low)..10f64.powf(high.max(low + 1.0));
    }
    if log {
        return low / 1.3..high * 1.3;
    }
    let margin = 0.05 * (high - low).max(f64::MIN_POSITIVE);
    if low == 0.0 && high == 1.0 { 0.0..1.0 } else { low - margin..high + margin }
}

/// `1e-5`, `2.5e-9`, `0`.
fn scientific(value: f64) -> String {
    if value == 0.0 {
        return "0".into();
    }
    let text = format!("{value:.1e}");
    text.replace(".0e", "e")
}
