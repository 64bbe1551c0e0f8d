//! Figures of panels with a legend, as SVG text.
//!
//! The backend rounds coordinates to whole pixels, which makes lines wiggly. So it draws on a canvas that is [`K`] times larger,
//! and the image is shown at the size that is meant.

use plotters::coord::Shift;
use plotters::coord::ranged1d::{DefaultFormatting, KeyPointHint};
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use std::error::Error;
use std::ops::Range;

type Outcome = Result<(), Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;

/// Pixels of the canvas to one of the image.
const K: f64 = 16.0;

/// Colours that can be told apart on white, also by the colour-blind (Okabe and Ito 2008).
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

const INK: RGBColor = RGBColor(34, 34, 34);
const PALE: RGBColor = RGBColor(90, 90, 90);
const GRID: RGBColor = RGBColor(222, 222, 222);
const TITLE: f64 = 48.0;
const ROW: f64 = 26.0;
/// Of a character, in units of the size of its font.
const ADVANCE: f64 = 0.56;
/// Most markers on a curve: more would hide the line.
const MARKERS: usize = 20;

/// A shape on a curve's points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// No shape.
    None,
    /// A filled disc.
    Circle,
    /// A filled triangle, point up.
    Triangle,
    /// A filled square.
    Square,
    /// A filled square on its corner.
    Diamond,
    /// Two diagonal strokes.
    Cross,
    /// A circle with a white interior.
    Ring,
    /// A triangle with a white interior, point down.
    Funnel,
    /// A square with a white interior.
    Frame,
}

/// How a curve looks; curves of one name in several panels share it.
#[derive(Clone, Debug)]
pub struct Style {
    /// Its name in the legend.
    pub name: String,
    /// An index of the palette.
    pub colour: usize,
    /// Whether the line has gaps.
    pub dashed: bool,
    /// The shape on its points.
    pub marker: Marker,
    /// Of the line, in pixels.
    pub width: f64,
}

impl Style {
    /// A solid line without markers.
    pub fn new(name: impl Into<String>, colour: usize) -> Self {
        Self { name: name.into(), colour, dashed: false, marker: Marker::None, width: 2.0 }
    }

    /// With gaps, if so.
    pub fn dashed(self, dashed: bool) -> Self {
        Self { dashed, ..self }
    }

    /// With a shape on its points.
    pub fn marked(self, marker: Marker) -> Self {
        Self { marker, ..self }
    }

    /// Of another width.
    pub fn wide(self, width: f64) -> Self {
        Self { width, ..self }
    }
}

/// Points in the order in which they are joined.
#[derive(Clone, Debug)]
pub struct Curve {
    /// How it looks.
    pub style: Style,
    /// Its points; those that are not finite, or not positive on a logarithmic axis, are left out.
    pub points: Vec<(f64, f64)>,
}

/// Which axes are logarithmic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// None.
    Linear,
    /// The vertical one.
    LogY,
    /// Both.
    LogLog,
}

/// A pair of axes with curves.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Above it, in the middle.
    pub title: String,
    /// Of the horizontal axis.
    pub x: &'static str,
    /// Of the vertical axis.
    pub y: &'static str,
    /// Which are logarithmic.
    pub axes: Axes,
    /// The curves; the first are drawn first.
    pub curves: Vec<Curve>,
    /// What a power of ten on the vertical axis is called, if not by its exponent.
    pub unit: Option<fn(i32) -> String>,
    /// Values that the horizontal axis has to reach, if not those of the curves alone.
    pub reach: Option<(f64, f64)>,
}

/// Where the names of the curves are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Legend {
    /// One legend for all panels, which are two in a row: where a last one is missing, else below.
    Shared,
    /// A legend to the right of each panel; two panels in a row.
    Beside,
}

/// Panels with a title.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Above all, in the middle.
    pub title: String,
    /// Where the names are.
    pub legend: Legend,
    /// The panels.
    pub panels: Vec<Panel>,
    /// Below all, in small print; may be empty.
    pub note: String,
}

/// `size` pixels of the image, on the canvas.
fn px(size: f64) -> i32 {
    (K * size).round() as i32
}

/// A font of this size in pixels of the image: the backend divides by 1.24.
fn font(size: f64) -> (&'static str, f64) {
    ("sans-serif", 1.24 * K * size)
}

impl Figure {
    /// The figure as SVG text.
    ///
    /// # Errors
    /// Those of the drawing library.
    pub fn svg(&self) -> Result<String, Box<dyn Error>> {
        match self.legend {
            Legend::Shared => self.shared(),
            Legend::Beside => self.beside(),
        }
    }

    /// Two panels in a row, one legend.
    fn shared(&self) -> Result<String, Box<dyn Error>> {
        const WIDTH: f64 = 1080.0;
        const PANEL: f64 = 430.0;
        let styles = self.styles();
        let panels = self.panels.len();
        let bottom = TITLE + panels.div_ceil(2) as f64 * PANEL;
        // A place without a panel has room for the legend, as a column.
        let free = panels % 2 == 1 && styles.len() as f64 * ROW < PANEL - 80.0;
        let longest = styles.iter().map(|style| style.name.chars().count()).max().unwrap_or(0);
        let columns = ((WIDTH - 96.0) / (longest as f64 * 17.0 * ADVANCE + 84.0)).floor().clamp(1.0, 4.0) as usize;
        let rows = if free { 0 } else { styles.len().div_ceil(columns) };
        let note = bottom + rows as f64 * ROW + 22.0;
        self.drawn((WIDTH, note + if self.note.is_empty() { 0.0 } else { 16.0 }), |root| {
            for (k, panel) in self.panels.iter().enumerate() {
                let corner = ((k % 2) as f64 * WIDTH / 2.0, TITLE + (k / 2) as f64 * PANEL);
                panel.draw(&part(root, corner, (WIDTH / 2.0, PANEL)))?;
            }
            let width = (WIDTH - 96.0) / columns as f64;
            for (k, style) in styles.iter().enumerate() {
                let (row, column) = ((k / columns) as f64, (k % columns) as f64);
                let place = if free {
                    (WIDTH / 2.0 + 70.0, bottom - PANEL + 60.0 + k as f64 * ROW)
                } else {
                    (60.0 + column * width, bottom + 16.0 + row * ROW)
                };
                key(root, style, place)?;
            }
            if self.note.is_empty() {
                return Ok(());
            }
            text(root, &self.note, (60.0, note), 14.0, HPos::Left, &PALE)
        })
    }

    /// Two panels in a row, each with its legend.
    fn beside(&self) -> Result<String, Box<dyn Error>> {
        const COLUMN: f64 = 640.0;
        const PANEL: f64 = 300.0;
        const NAMES: f64 = 165.0;
        let rows = self.panels.len().div_ceil(2) as f64;
        self.drawn((2.0 * COLUMN, TITLE + rows * PANEL + 6.0), |root| {
            for (k, panel) in self.panels.iter().enumerate() {
                let (left, top) = ((k % 2) as f64 * COLUMN, TITLE + (k / 2) as f64 * PANEL);
                panel.draw(&part(root, (left, top), (COLUMN - NAMES, PANEL)))?;
                for (row, curve) in panel.curves.iter().enumerate() {
                    key(root, &curve.style, (left + COLUMN - NAMES + 4.0, top + 48.0 + row as f64 * 22.0))?;
                }
            }
            Ok(())
        })
    }

    /// An image of this size with the title, and what `fill` draws below it.
    fn drawn(
        &self,
        (width, height): (f64, f64),
        fill: impl FnOnce(&Area<'_>) -> Outcome,
    ) -> Result<String, Box<dyn Error>> {
        let canvas = (px(width) as u32, px(height) as u32);
        let mut svg = String::new();
        {
            let root = SVGBackend::with_string(&mut svg, canvas).into_drawing_area();
            root.fill(&WHITE)?;
            text(&root, &self.title, (width / 2.0, 24.0), 22.0, HPos::Center, &INK)?;
            fill(&root)?;
            root.present()?;
        }
        let sized = format!("width=\"{width}\" height=\"{height}\" role=\"img\"");
        let svg = svg.replacen(&format!("width=\"{}\" height=\"{}\"", canvas.0, canvas.1), &sized, 1);
        let title = self.title.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;");
        Ok(svg.replacen('>', &format!(">\n<title>{title}</title>"), 1))
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

/// The part of an area from a corner on, of this size.
fn part<'a>(area: &Area<'a>, corner: (f64, f64), size: (f64, f64)) -> Area<'a> {
    area.clone().shrink((px(corner.0), px(corner.1)), (px(size.0), px(size.1)))
}

/// Text whose middle is at this height.
fn text(area: &Area<'_>, text: &str, at: (f64, f64), size: f64, side: HPos, colour: &RGBColor) -> Outcome {
    let style = font(size).into_font().color(colour).pos(Pos::new(side, VPos::Center));
    Ok(area.draw(&Text::new(text.to_owned(), (px(at.0), px(at.1)), style))?)
}

/// An entry of a legend, whose line starts there.
fn key(area: &Area<'_>, style: &Style, (x, y): (f64, f64)) -> Outcome {
    let ends = [(px(x), px(y)), (px(x + 44.0), px(y))];
    if style.dashed {
        area.draw(&DashedPathElement::new(ends, px(8.0), px(5.0), style.line()))?;
    } else {
        area.draw(&PathElement::new(ends, style.line()))?;
    }
    style.mark(area, (px(x + 22.0), px(y)))?;
    text(area, &style.name, (x + 54.0, y), 16.0, HPos::Left, &INK)
}

impl Style {
    fn colour(&self) -> RGBColor {
        COLOURS[self.colour % COLOURS.len()]
    }

    fn line(&self) -> ShapeStyle {
        self.colour().stroke_width(px(self.width) as u32)
    }

    /// A marker at a pixel of the canvas.
    fn mark(&self, area: &Area<'_>, at: (i32, i32)) -> Outcome {
        let colour = self.colour();
        let inside = match self.marker {
            Marker::Ring | Marker::Funnel | Marker::Frame => WHITE,
            _ => colour,
        };
        let outline = colour.stroke_width(px(1.6) as u32);
        let corners: &[(f64, f64)] = match self.marker {
            Marker::None => return Ok(()),
            Marker::Circle | Marker::Ring => {
                area.draw(&Circle::new(at, px(4.0), inside.filled()))?;
                return Ok(area.draw(&Circle::new(at, px(4.0), outline))?);
            }
            Marker::Cross => return Ok(area.draw(&Cross::new(at, px(4.0), outline))?),
            Marker::Triangle => &[(0.0, -5.3), (4.6, 2.7), (-4.6, 2.7)],
            Marker::Funnel => &[(0.0, 5.3), (4.6, -2.7), (-4.6, -2.7)],
            Marker::Square | Marker::Frame => &[(-3.7, -3.7), (3.7, -3.7), (3.7, 3.7), (-3.7, 3.7)],
            Marker::Diamond => &[(0.0, -5.0), (5.0, 0.0), (0.0, 5.0), (-5.0, 0.0)],
        };
        let mut corners: Vec<(i32, i32)> = corners.iter().map(|c| (at.0 + px(c.0), at.1 + px(c.1))).collect();
        area.draw(&Polygon::new(corners.clone(), inside.filled()))?;
        // Two more, so that the last corner is as sharp as the others.
        corners.extend_from_within(0..2);
        Ok(area.draw(&PathElement::new(corners, outline))?)
    }
}

impl Panel {
    /// A panel whose axes follow from its curves.
    pub fn new(title: impl Into<String>, (x, y): (&'static str, &'static str), axes: Axes, curves: Vec<Curve>) -> Self {
        Self { title: title.into(), x, y, axes, curves, unit: None, reach: None }
    }

    fn draw(&self, area: &Area<'_>) -> Outcome {
        let (log_x, log_y) = (self.axes == Axes::LogLog, self.axes != Axes::Linear);
        let shown = |&(x, y): &(f64, f64)| x.is_finite() && y.is_finite() && (!log_x || x > 0.0) && (!log_y || y > 0.0);
        // Logarithms on linear axes with ticks of our own: plotters' logarithmic axis has none below 1e-14.
        let scaled = |p: &(f64, f64)| (if log_x { p.0.log10() } else { p.0 }, if log_y { p.1.log10() } else { p.1 });
        let curves: Vec<Vec<(f64, f64)>> =
            self.curves.iter().map(|c| c.points.iter().filter(|p| shown(p)).map(scaled).collect()).collect();
        let reach = self.reach.iter().flat_map(|reach| [reach.0, reach.1].map(|x| if log_x { x.log10() } else { x }));
        let abscissas = curves.iter().flatten().map(|p| p.0).chain(reach);
        let x = Scale::new(abscissas, log_x, if log_x { 0.05 } else { 0.0 }, None);
        let y = Scale::new(curves.iter().flatten().map(|p| p.1), log_y, 0.06, self.unit);
        let left = 44.0 + (y.widest() as f64 * 15.0 * ADVANCE).max(42.0);
        self.titles(area, left, (x.exponent, y.exponent))?;
        let mut chart = ChartBuilder::on(area)
            .margin_top(px(34.0))
            .margin_right(px(26.0))
            .margin_bottom(px(14.0))
            .margin_left(px(14.0))
            .x_label_area_size(px(44.0))
            .y_label_area_size(px(left - 14.0))
            .build_cartesian_2d(x.clone(), y.clone())?;
        chart
            .configure_mesh()
            .x_desc(self.x)
            .y_desc(self.y)
            .axis_desc_style(font(16.0).into_font().color(&INK))
            .label_style(font(15.0).into_font().color(&INK))
            .x_label_formatter(&|value| x.label(*value))
            .y_label_formatter(&|value| y.label(*value))
            .axis_style(INK.stroke_width(px(1.0) as u32))
            .bold_line_style(GRID.stroke_width(px(1.0) as u32))
            .light_line_style(TRANSPARENT)
            .set_all_tick_mark_size(px(4.0))
            .draw()?;
        for (curve, points) in self.curves.iter().zip(curves) {
            let (style, line) = (&curve.style, points.iter().copied());
            if style.dashed {
                chart.draw_series(DashedLineSeries::new(line, px(8.0) as u32, px(5.0) as u32, style.line()))?;
            } else {
                chart.draw_series(LineSeries::new(line, style.line()))?;
            }
            let base = area.get_base_pixel();
            for point in points.iter().step_by(points.len().div_ceil(MARKERS).max(1)) {
                let at = chart.backend_coord(point);
                style.mark(area, (at.0 - base.0, at.1 - base.1))?;
            }
        }
        Ok(())
    }

    /// The title, in the middle of the axes, and the powers of ten of linear axes.
    fn titles(&self, area: &Area<'_>, left: f64, exponents: (i32, i32)) -> Outcome {
        let (width, height) = area.dim_in_pixel();
        let (right, bottom) = (f64::from(width) / K - 26.0, f64::from(height) / K);
        text(area, &self.title, ((left + right) / 2.0, 18.0), 18.0, HPos::Center, &INK)?;
        if exponents.1 != 0 {
            text(area, &power("×10", exponents.1), (left - 8.0, 22.0), 15.0, HPos::Right, &INK)?;
        }
        if exponents.0 != 0 {
            text(area, &power("×10", exponents.0), (right, bottom - 12.0), 15.0, HPos::Right, &INK)?;
        }
        Ok(())
    }
}

/// `base` with a raised exponent.
pub fn power(base: &str, exponent: i32) -> String {
    let raised = |c: char| match c.to_digit(10) {
        Some(digit) => ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'][digit as usize],
        None => '⁻',
    };
    base.chars().chain(exponent.to_string().chars().map(raised)).collect()
}

/// An axis: its range, and what stands at its ticks. Of a logarithmic one these are logarithms.
#[derive(Clone)]
pub struct Scale {
    /// Its ends.
    pub range: Range<f64>,
    /// Value and label.
    pub ticks: Vec<(f64, String)>,
    /// The labels of a linear axis are multiples of this power of ten.
    exponent: i32,
}

impl Scale {
    /// The axis of these values, wider by this share of it at each end; `unit` names powers of ten.
    pub fn new(values: impl Iterator<Item = f64>, log: bool, margin: f64, unit: Option<fn(i32) -> String>) -> Self {
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
        // Rounding is not worth magnifying.
        let size = low.abs().max(high.abs());
        let least = if log { 1.0 } else { [1.0, size * 1e-9][usize::from(size > 0.0)] };
        let spread = (high - low).max(least);
        let half = spread * (0.5 + margin);
        let middle = low + (high - low) / 2.0;
        let range = middle - half..middle + half;
        if log {
            return Self { ticks: powers(&range, unit), range, exponent: 0 };
        }
        let (ticks, exponent) = multiples(&range);
        Self { range, ticks, exponent }
    }

    /// Where a value is: 0 at the start of the axis, 1 at its end.
    pub fn fraction(&self, value: f64) -> f64 {
        (value - self.range.start) / (self.range.end - self.range.start)
    }

    /// The characters of the longest label.
    fn widest(&self) -> usize {
        self.ticks.iter().map(|(_, label)| label.chars().count()).max().unwrap_or(0)
    }

    fn label(&self, value: f64) -> String {
        let tick = self.ticks.iter().min_by(|a, b| (a.0 - value).abs().total_cmp(&(b.0 - value).abs()));
        tick.map(|(_, label)| label.clone()).unwrap_or_default()
    }
}

impl Ranged for Scale {
    type FormatOption = DefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        limit.0 + (self.fraction(*value) * f64::from(limit.1 - limit.0)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, _: Hint) -> Vec<f64> {
        self.ticks.iter().map(|(value, _)| *value).collect()
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

/// Powers of ten, eight or so; on a short axis their multiples by 2 and 5 too.
fn powers(range: &Range<f64>, unit: Option<fn(i32) -> String>) -> Vec<(f64, String)> {
    let (first, last) = (range.start.floor() as i32, range.end.ceil() as i32);
    let every = ((range.end - range.start) / 8.0).ceil().max(1.0) as i32;
    let mantissas: &[f64] = if range.end - range.start < 2.2 && unit.is_none() { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let decades = (first..=last).filter(|decade| decade.rem_euclid(every) == 0);
    let tick = |decade: i32, mantissa: f64| {
        let value = f64::from(decade) + mantissa.log10();
        let label = match unit {
            Some(unit) => unit(decade),
            None if mantissas.len() > 1 && (-3..4).contains(&decade) => {
                format!("{:.*}", (-decade).max(0) as usize, mantissa * 10f64.powi(decade))
            }
            None if mantissa == 1.0 => power("10", decade),
            None => power(&format!("{mantissa}·10"), decade),
        };
        (value, label)
    };
    let ticks = decades.flat_map(|decade| mantissas.iter().map(move |mantissa| tick(decade, *mantissa)));
    ticks.filter(|(value, _)| (range.start..=range.end).contains(value)).collect()
}

/// Multiples of 1, 2 or 5 times a power of ten, seven or so; and the power of ten that is not in their labels.
fn multiples(range: &Range<f64>) -> (Vec<(f64, String)>, i32) {
    let raw = (range.end - range.start) / 7.0;
    let unit = 10f64.powf(raw.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * unit).into_iter().find(|s| *s >= raw).unwrap_or(raw);
    let (first, last) = ((range.start / step - 1e-9).ceil() as i64, (range.end / step + 1e-9).floor() as i64);
    let size = range.start.abs().max(range.end.abs());
    let exponent = if (1e-3..1e5).contains(&size) { 0 } else { size.log10().floor() as i32 };
    // As many digits as tell neighbouring ticks apart.
    let digits = (f64::from(exponent) - (step * 1.0001).log10().floor()).clamp(0.0, 14.0) as usize;
    let label = |k: i64| {
        let text = format!("{:.digits$}", k as f64 * step / 10f64.powi(exponent));
        if k == 0 { "0".into() } else { text.replace('-', "−") }
    };
    ((first..=last).map(|k| (k as f64 * step, label(k))).collect(), exponent)
}
