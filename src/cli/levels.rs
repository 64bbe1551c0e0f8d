//! The errors at a sequence of step sizes, as a table.

use super::table::{Column, Table};
use euler_poincare::external::Slopes;
use euler_poincare::harness::convergence::LevelKind;
use std::ops::Range;

/// A row for each step size (of `rows`: how many steps, and h), with the errors of each quantity and their local slopes; below it what the
/// marks mean.
pub fn table(rows: &[(usize, f64)], slopes: &[Slopes]) -> String {
    let mut columns = vec![Column::number("steps"), Column::number("h")];
    for (at, slopes) in slopes.iter().enumerate() {
        // The first quantities decide; the others are there where there is room.
        let rank = u8::try_from(at).unwrap_or(u8::MAX);
        columns.extend([Column::number("").titled(&slopes.quantity).rank(rank), Column::number("slope").rank(rank)]);
    }
    let mut table = Table::new(&columns);
    let left_out = left_out(rows.len());
    for (index, &(steps, h)) in rows.iter().enumerate() {
        if left_out.contains(&index) {
            if index == left_out.start {
                table.row(["…".to_owned(), format!("{} levels", left_out.len())]);
            }
            continue;
        }
        let mut cells = vec![steps.to_string(), format!("{h:.3e}")];
        for slopes in slopes {
            let level = slopes.levels.iter().find(|level| level.h == h);
            let order = level.and_then(|level| level.order).map(|order| rounded(order, 3));
            let error = level.map(|level| format!("{}{:.3e}", mark(level.mark), level.error));
            cells.extend([error.unwrap_or("none".into()), order.unwrap_or_default()]);
        }
        table.row(cells);
    }
    let has = |mark| slopes.iter().flat_map(|slopes| &slopes.levels).any(|level| level.mark == mark);
    let noise = has(LevelKind::Noise).then_some("~ within the noise");
    let coarse = has(LevelKind::PreAsymptotic).then_some("· not on the line (yet)");
    let legend: Vec<&str> = noise.into_iter().chain(coarse).collect();
    let text = format!("{}\n{}", table.text(), legend.join(", "));
    text.trim_end().to_owned()
}

/// Which of the rows of a long table are not printed, those in its middle; the JSON has all.
fn left_out(rows: usize) -> Range<usize> {
    const FIRST: usize = 4;
    const LAST: usize = 10;
    if rows > FIRST + LAST + 1 { FIRST..rows - LAST } else { 0..0 }
}

/// What stands before the error of a level.
fn mark(kind: LevelKind) -> &'static str {
    match kind {
        LevelKind::Asymptotic => "",
        LevelKind::PreAsymptotic => "·",
        LevelKind::Noise => "~",
    }
}

/// An order to `digits` places; what rounds to 0 has no sign.
pub fn rounded(order: f64, digits: usize) -> String {
    let text = format!("{order:.digits$}");
    match text.strip_prefix('-') {
        Some(zero) if zero.bytes().all(|c| matches!(c, b'0' | b'.')) => zero.into(),
        _ => text,
    }
}
