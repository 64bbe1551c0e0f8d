//! The figure of a run: momenta, velocities, energy, Casimirs and attitude over time.

use super::super::plot::{Axes, Curve, Figure, Legend, Marker, Panel, Style};
use super::columns::Columns;
use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::scalar::Real;
use euler_poincare::system::case::Structure;
use euler_poincare::system::{Case, SystemFile};
use nalgebra::{Matrix3, Rotation3, UnitQuaternion};
use std::ops::Range;
use std::path::Path;

/// Points of a curve: when there are more, every second one goes.
const MOST: usize = 4096;

/// Curves of an attitude that are drawn; more could not be told apart.
const ENTRIES: usize = 10;

/// A longer title is cut down to the name of the file.
const TITLE: usize = 80;

/// Samples of a run, evenly spaced, never more than [`MOST`].
pub struct Trace {
    columns: Columns,
    stride: usize,
    seen: usize,
    /// Rows with initial energy + work in the column of the work, and changes of the Casimirs in those of the Casimirs.
    points: Vec<Vec<f64>>,
    /// The last row seen, which may not be a sample.
    last: Vec<f64>,
    /// The initial values of the Casimirs: in 32 digits the sum of two numbers.
    initial: Vec<[f64; 2]>,
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
            let parts = |value: &T| [value.to_f64(), (*value - T::exact(value.to_f64())).to_f64()];
            self.initial = casimirs.iter().map(parts).collect();
        }
        let mut point: Vec<f64> = row.iter().map(|value| value.to_f64()).collect();
        point[energy + 1] = (row[energy] - row[energy + 2]).to_f64();
        // The difference in the scalar of the run: in f64 it could be lost.
        for ((change, value), initial) in point[casimir..].iter_mut().zip(casimirs).zip(&self.initial) {
            *change = (*value - (T::exact(initial[0]) + T::exact(initial[1]))).to_f64();
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

    /// The samples, and the end.
    fn samples(&self) -> impl Iterator<Item = &Vec<f64>> {
        let tail = (self.points.last() != Some(&self.last)).then_some(&self.last);
        self.points.iter().chain(tail).filter(|point| !point.is_empty())
    }

    fn curve(&self, column: usize) -> Vec<(f64, f64)> {
        self.samples().filter_map(|point| Some((point[0], *point.get(column)?))).collect()
    }

    /// The column of the entry of the attitude in this row and column.
    fn entry(&self, row: usize, column: usize) -> usize {
        self.columns.casimir() + self.columns.casimirs + row * self.columns.attitude + column
    }
}

/// The figure of a run of `case`, which was read from `file`.
pub fn figure(trace: &Trace, system: &SystemFile, file: &Path) -> Figure {
    let (n, case) = (trace.columns.dimension, &system.case);
    let mut panels = Vec::new();
    for Block { kind, of, coordinates } in blocks(case) {
        for (what, letter, first) in [("momentum", "μ", Columns::MOMENTUM), ("velocity", "η", Columns::MOMENTUM + n)]
        {
            let curve = |a: usize| (format!("{letter}{}", subscript(a + 1)), trace.curve(first + a));
            panels.push(panel(&format!("{kind}{what}{of}"), coordinates.clone().map(curve).collect()));
        }
    }
    panels.push(energy(trace));
    panels.extend(casimirs(trace, case));
    panels.extend(attitude(trace, case));
    Figure { title: title(system, file), legend: Legend::Beside, panels, note: String::new() }
}

/// The two agree but for the error of the method: the first is drawn wide, so that it shows on both sides of the other.
fn energy(trace: &Trace) -> Panel {
    let energy = trace.columns.energy();
    let curve = |style, column| Curve { style, points: trace.curve(column) };
    let curves =
        vec![curve(Style::new("energy", 5).wide(6.0), energy), curve(Style::new("start + work", 1), energy + 1)];
    Panel::new("energy", ("time t", ""), Axes::Linear, curves)
}

/// How the Casimirs have changed since the start. Without potential and force they are constant; the title says where they are not.
fn casimirs(trace: &Trace, case: &Case) -> Option<Panel> {
    let curve = |k: usize| (format!("C{}", subscript(k + 1)), trace.curve(trace.columns.casimir() + k));
    let curves: Vec<Named> = (0..trace.columns.casimirs).map(curve).collect();
    let title = match (case.potentials.is_empty(), case.lagrangian.formula.is_some()) {
        (false, _) => "Casimirs: the potential moves them",
        (true, true) => "Casimirs: constant if L is free of g",
        (true, false) => "Casimirs",
    };
    (!curves.is_empty()).then(|| Panel { y: "change since the start", ..panel(title, curves) })
}

/// Coordinates of one unit.
struct Block {
    /// `angular `, `linear `, or nothing.
    kind: &'static str,
    /// Of which factor of a product.
    of: String,
    /// Which coordinates.
    coordinates: Range<usize>,
}

/// The coordinates, those of turns apart from those of translations, where the basis of the algebra does.
fn blocks(case: &Case) -> Vec<Block> {
    let whole = || vec![Block { kind: "", of: String::new(), coordinates: 0..case.dimension() }];
    let Structure::Named(entry) = &case.algebra.structure else { return whole() };
    let factors = match entry {
        Entry::Product(factors) => factors.iter().collect(),
        entry => vec![entry],
    };
    let of = |factor: &Entry| if factors.len() > 1 { format!(" of {factor}") } else { String::new() };
    let (mut blocks, mut first) = (Vec::new(), 0);
    for factor in &factors {
        let end = first + factor.dimension();
        let turns = match factor {
            Entry::So3 | Entry::Se3 => 3,
            Entry::Se2 => 1,
            _ => 0,
        };
        let kinds = match turns {
            0 => vec![("", first..end)],
            turns => vec![("angular ", first..first + turns), ("linear ", first + turns..end)],
        };
        let block = |(kind, coordinates)| Block { kind, of: of(factor), coordinates };
        blocks.extend(kinds.into_iter().map(block).filter(|block| !block.coordinates.is_empty()));
        first = end;
    }
    // In another basis a coordinate may be of both.
    if case.algebra.basis.is_some() && blocks.len() > 1 { whole() } else { blocks }
}

/// The file, the algebra, the method, and the step or the tolerance.
fn title(system: &SystemFile, file: &Path) -> String {
    let case = &system.case;
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let name = if name == "-" { "standard input" } else { &name };
    let method = format!("{}, {}", case.method.tableau, case.method.retraction.name());
    let exactness = match &system.adaptive {
        Some(adaptive) => format!("tolerance {}", adaptive.tolerance),
        None => format!("h = {}", case.step),
    };
    let long = format!("{name}: {}, {method}, {exactness}", case.algebra);
    if long.chars().count() > TITLE { name.to_owned() } else { long }
}

/// A curve with its name.
type Named = (String, Vec<(f64, f64)>);

fn panel(title: &str, curves: Vec<Named>) -> Panel {
    // Seven colours without markers, then the same with markers.
    const MARKERS: [Marker; 9] = [
        Marker::None,
        Marker::Circle,
        Marker::Triangle,
        Marker::Square,
        Marker::Diamond,
        Marker::Cross,
        Marker::Ring,
        Marker::Funnel,
        Marker::Frame,
    ];
    const COLOURS: [usize; 7] = [2, 1, 3, 4, 5, 6, 7];
    let style = |k: usize, name| Style::new(name, COLOURS[k % 7]).marked(MARKERS[(k / 7).min(8)]);
    let curves: Vec<Curve> =
        curves.into_iter().enumerate().map(|(k, (name, points))| Curve { style: style(k, name), points }).collect();
    Panel::new(title, ("time t", ""), Axes::Linear, curves)
}

/// Rotations as quaternions, positions in space, other groups by the entries of their matrices; nothing without a group.
fn attitude(trace: &Trace, case: &Case) -> Vec<Panel> {
    let entry = match &case.algebra.structure {
        _ if trace.columns.attitude == 0 => return Vec::new(),
        Structure::Named(entry) => Some(entry),
        _ => None,
    };
    match entry {
        Some(Entry::So3) => vec![panel("attitude: unit quaternion", rotation(trace))],
        Some(Entry::Se3) => {
            let position = (0..3).map(|i| (format!("x{}", subscript(i + 1)), trace.curve(trace.entry(i, 3)))).collect();
            vec![panel("attitude: unit quaternion", rotation(trace)), panel("position", position)]
        }
        _ => vec![entries(trace)],
    }
}

/// The entries of the matrix that change, the first few of them.
fn entries(trace: &Trace) -> Panel {
    let size = trace.columns.attitude;
    let gap = if size > 9 { "," } else { "" };
    let all = (0..size * size).map(|k| (k / size, k % size)).map(|(i, j)| {
        let name = format!("g{}{gap}{}", subscript(i + 1), subscript(j + 1));
        (name, trace.curve(trace.entry(i, j)))
    });
    let mut moving: Vec<Named> = all.filter(|(_, points)| points.iter().any(|point| point.1 != points[0].1)).collect();
    let title = match moving.len() {
        0 => "attitude: no matrix entry changes".into(),
        number if number > ENTRIES => format!("attitude: {ENTRIES} of {number} entries that change"),
        _ => "attitude: matrix entries that change".to_owned(),
    };
    moving.truncate(ENTRIES);
    panel(&title, moving)
}

/// The quaternion of the rotation in the first three rows and columns; of its two signs the one that makes no jump.
fn rotation(trace: &Trace) -> Vec<Named> {
    let mut last = [1.0, 0.0, 0.0, 0.0];
    let points: Vec<(f64, [f64; 4])> = trace
        .samples()
        .map(|point| {
            let matrix = Matrix3::from_fn(|i, j| point[trace.entry(i, j)]);
            let q = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix));
            let q = [q.w, q.i, q.j, q.k];
            let same: f64 = q.iter().zip(&last).map(|(new, old)| new * old).sum();
            last = if same < 0.0 { q.map(|value| -value) } else { q };
            (point[0], last)
        })
        .collect();
    (0..4).map(|k| (format!("q{}", subscript(k)), points.iter().map(|(t, q)| (*t, q[k])).collect())).collect()
}

/// A number as a subscript.
fn subscript(number: usize) -> String {
    let digit = |c: char| c.to_digit(10).and_then(|digit| char::from_u32(0x2080 + digit)).unwrap_or(c);
    number.to_string().chars().map(digit).collect()
}
