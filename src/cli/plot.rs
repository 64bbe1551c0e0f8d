//! Figures of panels with a legend, as SVG text: coordinates have decimals, and no style sheet is needed.

use std::fmt::Write;
use std::ops::Range;

/// Colours that can be told apart on white, also by the colour-blind (Okabe and Ito 2008).
const COLOURS: [&str; 8] = ["#000000", "#d55e00", "#0072b2", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#6e6e6e"];

const INK: &str = "#222222";
const GRID: &str = "#dedede";
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
    /// One legend for all panels, which are two in a row: in the place of a last one that is not there, else below.
    Shared,
    /// A legend to the right of each panel; panels are one below another.
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

/// A rectangle: left, top, right, bottom.
#[derive(Clone, Copy)]
struct Frame {
    left: f64,
    top: f64,
    right: f64,
    bottom: f64,
}

impl Figure {
    /// The figure as SVG text.
    pub fn svg(&self) -> String {
        match self.legend {
            Legend::Shared => self.shared(),
            Legend::Beside => self.stacked(),
        }
    }

    /// Two panels in a row, one legend.
    fn shared(&self) -> String {
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
        let mut canvas = Canvas::new(WIDTH, note + if self.note.is_empty() { 0.0 } else { 16.0 }, &self.title);
        for (k, panel) in self.panels.iter().enumerate() {
            let (left, top) = ((k % 2) as f64 * WIDTH / 2.0, TITLE + (k / 2) as f64 * PANEL);
            panel.draw(&mut canvas, Frame { left, top, right: left + WIDTH / 2.0, bottom: top + PANEL });
        }
        let width = (WIDTH - 96.0) / columns as f64;
        for (k, style) in styles.into_iter().enumerate() {
            let (row, column) = ((k / columns) as f64, (k % columns) as f64);
            match free {
                true => canvas.key(style, WIDTH / 2.0 + 70.0, bottom - PANEL + 60.0 + k as f64 * ROW),
                false => canvas.key(style, 60.0 + column * width, bottom + 16.0 + row * ROW),
            }
        }
        canvas.text(&self.note, (60.0, note + 6.0), 14.0, "start", "#5a5a5a");
        canvas.end()
    }

    /// Panels one below another, each with its legend.
    fn stacked(&self) -> String {
        const WIDTH: f64 = 940.0;
        const PANEL: f64 = 300.0;
        const NAMES: f64 = 210.0;
        let mut canvas = Canvas::new(WIDTH, TITLE + self.panels.len() as f64 * PANEL + 6.0, &self.title);
        for (k, panel) in self.panels.iter().enumerate() {
            let top = TITLE + k as f64 * PANEL;
            panel.draw(&mut canvas, Frame { left: 0.0, top, right: WIDTH - NAMES, bottom: top + PANEL });
            for (row, curve) in panel.curves.iter().enumerate() {
                canvas.key(&curve.style, WIDTH - NAMES + 4.0, top + 48.0 + row as f64 * 22.0);
            }
        }
        canvas.end()
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

impl Panel {
    /// A panel whose axes follow from its curves.
    pub fn new(title: impl Into<String>, (x, y): (&'static str, &'static str), axes: Axes, curves: Vec<Curve>) -> Self {
        Self { title: title.into(), x, y, axes, curves, unit: None, reach: None }
    }

    fn draw(&self, canvas: &mut Canvas, outer: Frame) {
        let (log_x, log_y) = (self.axes == Axes::LogLog, self.axes != Axes::Linear);
        let shown = |&(x, y): &(f64, f64)| x.is_finite() && y.is_finite() && (!log_x || x > 0.0) && (!log_y || y > 0.0);
        let scaled = |p: &(f64, f64)| (if log_x { p.0.log10() } else { p.0 }, if log_y { p.1.log10() } else { p.1 });
        let curves: Vec<Vec<(f64, f64)>> =
            self.curves.iter().map(|c| c.points.iter().filter(|p| shown(p)).map(scaled).collect()).collect();
        let reach = self.reach.iter().flat_map(|reach| [reach.0, reach.1].map(|x| if log_x { x.log10() } else { x }));
        let abscissas = curves.iter().flatten().map(|p| p.0).chain(reach);
        let x = Scale::new(abscissas, log_x, if log_x { 0.05 } else { 0.0 }, None);
        let y = Scale::new(curves.iter().flatten().map(|p| p.1), log_y, 0.06, self.unit);
        let widest = y.ticks.iter().map(|(_, label)| label.width()).max().unwrap_or(0);
        let left = outer.left + 44.0 + (widest as f64 * 15.0 * ADVANCE).max(42.0);
        let inner = Frame { left, top: outer.top + 34.0, right: outer.right - 26.0, bottom: outer.bottom - 58.0 };
        self.axes(canvas, outer, inner, (&x, &y));
        for (curve, points) in self.curves.iter().zip(curves) {
            let place = |p: &(f64, f64)| (x.place(p.0, inner.left, inner.right), y.place(p.1, inner.bottom, inner.top));
            canvas.curve(&curve.style, &points.iter().map(place).collect::<Vec<_>>());
        }
    }

    /// Grid, frame, labels and titles.
    fn axes(&self, canvas: &mut Canvas, outer: Frame, inner: Frame, (x, y): (&Scale, &Scale)) {
        let Frame { left, top, right, bottom } = inner;
        let middle = (left + right) / 2.0;
        canvas.text(&self.title, (middle, top - 12.0), 18.0, "middle", INK);
        for (value, label) in &x.ticks {
            let at = x.place(*value, left, right);
            canvas.line((at, top), (at, bottom), GRID);
            canvas.label(label, (at, bottom + 20.0), "middle");
        }
        for (value, label) in &y.ticks {
            let at = y.place(*value, bottom, top);
            canvas.line((left, at), (right, at), GRID);
            canvas.label(label, (left - 8.0, at + 5.0), "end");
        }
        canvas.line((left, top), (left, bottom), INK);
        canvas.line((left, bottom), (right, bottom), INK);
        canvas.text(self.x, (middle, bottom + 44.0), 16.0, "middle", INK);
        canvas.upward(self.y, (outer.left + 24.0, (top + bottom) / 2.0));
        if y.exponent != 0 {
            canvas.label(&Label::power("×10", y.exponent), (left - 8.0, top - 8.0), "end");
        }
        if x.exponent != 0 {
            canvas.label(&Label::power("×10", x.exponent), (right, bottom + 44.0), "end");
        }
    }
}

/// The text at a tick: `base`, then `power` as a superscript.
struct Label {
    base: String,
    power: String,
}

impl Label {
    fn plain(base: String) -> Self {
        Self { base, power: String::new() }
    }

    fn power(base: &str, exponent: i32) -> Self {
        Self { base: base.into(), power: exponent.to_string().replace('-', "−") }
    }

    fn width(&self) -> usize {
        self.base.chars().count() + self.power.chars().count()
    }
}

/// An axis: its range, and what stands at its ticks.
struct Scale {
    range: Range<f64>,
    ticks: Vec<(f64, Label)>,
    /// The labels of a linear axis are multiples of this power of ten.
    exponent: i32,
}

impl Scale {
    fn new(values: impl Iterator<Item = f64>, log: bool, margin: f64, unit: Option<fn(i32) -> String>) -> Self {
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

    fn place(&self, value: f64, from: f64, to: f64) -> f64 {
        from + (value - self.range.start) / (self.range.end - self.range.start) * (to - from)
    }
}

/// Powers of ten, eight or so; on a short axis their multiples by 2 and 5 too.
fn powers(range: &Range<f64>, unit: Option<fn(i32) -> String>) -> Vec<(f64, Label)> {
    let (first, last) = (range.start.floor() as i32, range.end.ceil() as i32);
    let every = ((range.end - range.start) / 8.0).ceil().max(1.0) as i32;
    let mantissas: &[f64] = if range.end - range.start < 2.2 && unit.is_none() { &[1.0, 2.0, 5.0] } else { &[1.0] };
    let decades = (first..=last).filter(|decade| decade.rem_euclid(every) == 0);
    let tick = |decade: i32, mantissa: f64| {
        let value = f64::from(decade) + mantissa.log10();
        let label = match unit {
            Some(unit) => Label::plain(unit(decade)),
            None if mantissas.len() > 1 && (-3..4).contains(&decade) => {
                Label::plain(format!("{:.*}", (-decade).max(0) as usize, mantissa * 10f64.powi(decade)))
            }
            None if mantissa == 1.0 => Label::power("10", decade),
            None => Label::power(&format!("{mantissa}·10"), decade),
        };
        (value, label)
    };
    let ticks = decades.flat_map(|decade| mantissas.iter().map(move |mantissa| tick(decade, *mantissa)));
    ticks.filter(|(value, _)| (range.start..=range.end).contains(value)).collect()
}

/// Multiples of 1, 2 or 5 times a power of ten, seven or so; and the power of ten that is not in their labels.
fn multiples(range: &Range<f64>) -> (Vec<(f64, Label)>, i32) {
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
        Label::plain(if k == 0 { "0".into() } else { text.replace('-', "−") })
    };
    ((first..=last).map(|k| (k as f64 * step, label(k))).collect(), exponent)
}

/// The text of an SVG image that grows. Writing to a string cannot fail.
struct Canvas {
    text: String,
}

impl Canvas {
    fn new(width: f64, height: f64, title: &str) -> Self {
        let mut text = String::new();
        let title = escaped(title);
        let _ = writeln!(
            text,
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" \
             font-family=\"sans-serif\" role=\"img\">\n<title>{title}</title>\n\
             <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>"
        );
        let mut canvas = Self { text };
        canvas.put(&title, (width / 2.0, 31.0), 22.0, "middle", INK);
        canvas
    }

    fn end(mut self) -> String {
        self.text.push_str("</svg>\n");
        self.text
    }

    fn text(&mut self, text: &str, at: (f64, f64), size: f64, anchor: &str, colour: &str) {
        if !text.is_empty() {
            self.put(&escaped(text), at, size, anchor, colour);
        }
    }

    /// Text that is escaped already.
    fn put(&mut self, text: &str, (x, y): (f64, f64), size: f64, anchor: &str, colour: &str) {
        let _ = writeln!(
            self.text,
            "<text x=\"{x:.2}\" y=\"{y:.2}\" font-size=\"{size}\" text-anchor=\"{anchor}\" fill=\"{colour}\">{text}</text>"
        );
    }

    fn label(&mut self, label: &Label, at: (f64, f64), anchor: &str) {
        let raised = match label.power.as_str() {
            "" => String::new(),
            power => format!("<tspan dy=\"-5\" font-size=\"11\">{}</tspan>", escaped(power)),
        };
        self.put(&(escaped(&label.base) + &raised), at, 15.0, anchor, INK);
    }

    /// Text that reads upward, with its middle there.
    fn upward(&mut self, text: &str, (x, y): (f64, f64)) {
        if text.is_empty() {
            return;
        }
        let _ = writeln!(
            self.text,
            "<text transform=\"translate({x:.2} {y:.2}) rotate(-90)\" font-size=\"16\" text-anchor=\"middle\" fill=\"{INK}\">{}</text>",
            escaped(text)
        );
    }

    fn line(&mut self, from: (f64, f64), to: (f64, f64), colour: &str) {
        let _ = writeln!(
            self.text,
            "<path d=\"M{:.2} {:.2}L{:.2} {:.2}\" stroke=\"{colour}\"/>",
            from.0, from.1, to.0, to.1
        );
    }

    /// A line with its markers.
    fn curve(&mut self, style: &Style, points: &[(f64, f64)]) {
        let Some(first) = points.first() else { return };
        let mut path = format!("M{:.2} {:.2}", first.0, first.1);
        for point in &points[1..] {
            let _ = write!(path, "L{:.2} {:.2}", point.0, point.1);
        }
        let colour = COLOURS[style.colour % COLOURS.len()];
        let dashes = if style.dashed { " stroke-dasharray=\"8 5\"" } else { "" };
        let _ = writeln!(
            self.text,
            "<path d=\"{path}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"{}\" stroke-linejoin=\"round\"{dashes}/>",
            style.width
        );
        let marked: Vec<_> = points.iter().step_by(points.len().div_ceil(MARKERS).max(1)).copied().collect();
        self.markers(style, &marked);
    }

    fn markers(&mut self, style: &Style, points: &[(f64, f64)]) {
        if style.marker == Marker::None {
            return;
        }
        let colour = COLOURS[style.colour % COLOURS.len()];
        let inside = match style.marker {
            Marker::Ring | Marker::Funnel | Marker::Frame => "#ffffff",
            _ => colour,
        };
        let shapes: String = points.iter().map(|point| shape(style.marker, *point)).collect();
        let _ =
            writeln!(self.text, "<path d=\"{shapes}\" fill=\"{inside}\" stroke=\"{colour}\" stroke-width=\"1.6\"/>");
    }

    /// An entry of a legend, whose line starts there.
    fn key(&mut self, style: &Style, x: f64, y: f64) {
        self.curve(&style.clone().marked(Marker::None), &[(x, y), (x + 44.0, y)]);
        self.markers(style, &[(x + 22.0, y)]);
        self.text(&style.name, (x + 54.0, y + 5.5), 16.0, "start", INK);
    }
}

/// The path of a marker.
fn shape(marker: Marker, (x, y): (f64, f64)) -> String {
    match marker {
        Marker::None => String::new(),
        Marker::Circle | Marker::Ring => {
            format!("M{:.2} {y:.2}a4 4 0 1 0 8 0a4 4 0 1 0 -8 0z", x - 4.0)
        }
        Marker::Triangle => format!("M{x:.2} {:.2}l4.6 8h-9.2z", y - 5.3),
        Marker::Funnel => format!("M{x:.2} {:.2}l4.6 -8h-9.2z", y + 5.3),
        Marker::Square | Marker::Frame => format!("M{:.2} {:.2}h7.4v7.4h-7.4z", x - 3.7, y - 3.7),
        Marker::Diamond => format!("M{x:.2} {:.2}l5 5l-5 5l-5 -5z", y - 5.0),
        Marker::Cross => format!("M{:.2} {:.2}l8 8m0 -8l-8 8", x - 4.0, y - 4.0),
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}
