//! Tables for people: no vertical lines, 100 columns at most.

use comfy_table::presets::{NOTHING, UTF8_HORIZONTAL_ONLY};
use comfy_table::{CellAlignment, ColumnConstraint, ContentArrangement, Table, Width};

/// The width that every table keeps to.
pub const WIDTH: u16 = 100;

/// Lists align the texts of names shorter than this.
const NAMES: usize = 9;

/// A table with a header; the columns listed in `numbers` are aligned to the right.
pub fn table(header: &[&str], numbers: std::ops::Range<usize>) -> Table {
    let mut table = Table::new();
    table.load_style(UTF8_HORIZONTAL_ONLY).set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH);
    table.style_mut().row_separator = comfy_table::LineStyle::none();
    table.set_header(header.iter().copied());
    for (index, column) in table.column_iter_mut().enumerate() {
        column.set_padding((0, u16::from(index + 1 < header.len())));
        if index == 0 {
            column.set_constraint(ColumnConstraint::ContentWidth);
        }
        if numbers.contains(&index) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    table
}

/// Names on the left (`indent` columns in), text that wraps on the right, without lines.
pub fn entries<A: Into<String>>(indent: u16, rows: impl IntoIterator<Item = (A, String)>) -> String {
    let rows: Vec<[String; 2]> = rows.into_iter().map(|(name, text)| [name.into(), text]).collect();
    if rows.is_empty() {
        return String::new();
    }
    let names = rows.iter().map(|[name, _]| name.chars().count()).max().unwrap_or(0).max(NAMES);
    let mut table = Table::new();
    table.load_style(NOTHING).set_content_arrangement(ContentArrangement::Dynamic).set_width(WIDTH);
    table.add_rows(rows);
    if let Some(column) = table.column_mut(0) {
        column.set_padding((indent, 2));
        let width = indent + 2 + u16::try_from(names).unwrap_or(WIDTH / 3).min(WIDTH / 3);
        column.set_constraint(ColumnConstraint::Absolute(Width::Fixed(width)));
    }
    if let Some(column) = table.column_mut(1) {
        column.set_padding((0, 0));
    }
    table.trim_fmt()
}

/// A duration: `0.012 s`, `3.4 s`, `250 s`.
pub fn seconds(seconds: f64) -> String {
    match seconds {
        s if s < 0.0995 => format!("{s:.3} s"),
        s if s < 99.5 => format!("{s:.1} s"),
        s => format!("{s:.0} s"),
    }
}
