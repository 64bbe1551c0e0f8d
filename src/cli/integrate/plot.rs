//! The figure of a run: momenta, energy and Casimirs over time.

use super::columns::Columns;
use euler_poincare::scalar::Real;
use plotters::coord::Shift;
use plotters::prelude::*;
use std::error::Error;
use std::ops::Range;
use std::path::Path;

/// Points of a curve: when there are more, every second one goes.
const MOST: usize = 4096;

/// Colours that can be told apart on white, also by the colour-blind (Okabe and Ito 2008).
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(86, 180, 233),
    RGBColor(230, 159, 0),
    RGBColor(110, 110, 110),
    RGBColor(0, 0, 0),
];

/// Samples of a run, evenly spaced, never more than [`MOST`].
pub struct Trace {
    columns: Columns,
    stride: usize,
    seen: usize,
    /// t, momenta, energy, initial energy + work, changes of the Casimirs.
    points: Vec<Vec<f64>>,
    /// The last row seen, which may not be a sample.
    last: Vec<f64>,
    /// The initial values of the Casimirs, in the scalar of the run.
    initial: Vec<Box<dyn std::any::Any>>,
}

impl Trace {
    /// An empty trace of rows with these columns.
    pub fn new(columns: Columns) -> Self {
        Self { columns, stride: 1, seen: 0, points: Vec::new(), last: Vec::new(), initial: Vec::new() }
    }

    /// Takes note of a row.
    pub fn add<T: Real>(&mut self, row: &[T]) {
        let (energy, casimir) = (self.columns.energy(), self.columns.casimir());
        let casimirs = &row[casimir..casimir + self.columns.casimirs];
        if self.seen == 0 {
            self.initial = casimirs.iter().map(|value| Box::new(*value) as Box<dyn std::any::Any>).collect();
        }
        let mut point = vec![row[0].to_f64()];
        point.extend(row[Columns::MOMENTUM..][..self.columns.dimension].iter().map(|v| v.to_f64()));
        point.push(row[energy].to_f64());
        point.push((row[energy] - row[energy + 2]).to_f64());
        // The difference in the scalar of the run: in f64 it could be lost.
        for (value, initial) in casimirs.iter().zip(&self.initial) {
            point.push((*value - initial.downcast_ref::<T>().copied().unwrap_or(*value)).to_f64());
        }
        if self.seen.is_multiple_of(self.stride) {
            self.points.push(point.clone());
            if self.points.len() > MOST {
                let mut index = 0;
                self.points.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.stride *= 2;
            }
        }
        self.last = point;
        self.seen += 1;
    }

    fn curve(&self, column: usize) -> Vec<(f64, f64)> {
        let tail = (self.points.last() != Some(&self.last)).then_some(&self.last);
        let finite = |(t, value): &(f64, f64)| t.is_finite() && value.is_finite();
        self.points.iter().chain(tail).filter_map(|p| Some((*p.first()?, *p.get(column)?))).filter(finite).collect()
    }
}

/// Draws the figure.
pub fn draw(trace: &Trace, path: &Path) -> Result<(), Box<dyn Error>> {
    let (n, casimirs) = (trace.columns.dimension, trace.columns.casimirs);
    let named = |name: String, column: usize| (name, trace.curve(column));
    let mut panels = vec![
        ("momentum", (0..n).map(|a| named(format!("mu_{}", a + 1), 1 + a)).collect()),
        ("energy", vec![named("energy".into(), 1 + n), named("initial energy + work".into(), 2 + n)]),
    ];
    if casimirs > 0 {
        let curves = (0..casimirs).map(|k| named(format!("casimir_{}", k + 1), 3 + n + k)).collect();
        panels.push(("Casimirs: change since the start", curves));
    }
    let root = SVGBackend::new(path, (900, 300 * panels.len() as u32)).into_drawing_area();
    root.fill(&WHITE)?;
    for (area, (title, curves)) in root.split_evenly((panels.len(), 1)).iter().zip(&panels) {
        panel(area, title, curves)?;
    }
    root.present()?;
    Ok(())
}

/// A curve with its name.
type Curve = (String, Vec<(f64, f64)>);

fn panel(area: &DrawingArea<SVGBackend<'_>, Shift>, title: &str, curves: &[Curve]) -> Result<(), Box<dyn Error>> {
    let points = || curves.iter().flat_map(|(_, curve)| curve);
    let (times, values) = (range(points().map(|p| p.0), 0.0), range(points().map(|p| p.1), 0.08));
    let size = values.start.abs().max(values.end.abs());
    let spread = values.end - values.start;
    let (area, names) = area.split_horizontally(730);
    let mut chart = ChartBuilder::on(&area)
        .caption(title, ("sans-serif", 20))
        .margin(10)
        .margin_right(30)
        .x_label_area_size(36)
        .y_label_area_size(84)
        .build_cartesian_2d(times, values)?;
    // As many digits as tell neighbouring ticks apart.
    let digits = (1.0 - (spread / 8.0).log10().floor()).clamp(0.0, 12.0) as usize;
    let label = |value: &f64| {
        if value.abs() < spread * 1e-9 {
            "0".to_string()
        } else if !(1e-3..1e5).contains(&size) {
            format!("{value:.1e}")
        } else {
            format!("{value:.digits$}")
        }
    };
    chart
        .configure_mesh()
        .x_desc("t")
        .y_labels(7)
        .y_label_formatter(&label)
        .light_line_style(WHITE)
        .label_style(("sans-serif", 14))
        .draw()?;
    for (index, (name, curve)) in curves.iter().enumerate() {
        let colour = COLOURS[index % COLOURS.len()];
        // A curve that others may cover is drawn wide, so that it shows on both sides of them.
        let style = colour.stroke_width(if index == 0 && curves.len() == 2 { 5 } else { 2 });
        chart.draw_series(LineSeries::new(curve.iter().copied(), style))?;
        let y = 50 + 20 * index as i32;
        names.draw(&PathElement::new([(0, y), (20, y)], style))?;
        names.draw(&Text::new(name.as_str(), (26, y - 6), ("sans-serif", 14)))?;
    }
    Ok(())
}

/// The range of values with a margin (a fraction of it); never empty.
fn range(values: impl Iterator<Item = f64>, margin: f64) -> Range<f64> {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(v), high.max(v)));
    if low > high {
        return 0.0..1.0;
    }
    let size = low.abs().max(high.abs());
    // Rounding is not worth magnifying.
    let least = if size == 0.0 { 1.0 } else { size * 1e-9 };
    let spread = (high - low).max(least);
    let middle = low + (high - low) / 2.0;
    let half = spread * (0.5 + margin);
    middle - half..middle + half
}
