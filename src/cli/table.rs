//! Tables for people, as wide as the terminal.
//!
//! No number and no name is ever split: cells are wrapped here, at spaces and in columns of text alone, and handed over whole.
//! Where the columns do not fit, those of the highest rank are left out, and a line below the table names them. A word that is
//! longer than its line (a path) stays whole: it is to be copied.

use comfy_table::presets::UTF8_HORIZONTAL_ONLY;
use comfy_table::{CellAlignment, ContentArrangement};
use std::borrow::Cow;
use std::io::{self, IsTerminal};
use unicode_width::UnicodeWidthStr;

/// The width where standard output is no terminal: the same on every machine.
const PLAIN: usize = 100;

/// Narrower terminals are treated as if they had this width.
const NARROWEST: usize = 80;

/// Prose is not set wider than this: longer lines are hard to read.
const PROSE: usize = 120;

/// Between two columns.
const GAP: usize = 2;

/// A column of text is not made narrower than this.
const TEXT: usize = 20;

/// Lists align the texts of names shorter than this.
const NAMES: usize = 9;

/// The columns that a line may have: those of the terminal, 100 where standard output is none.
///
/// The variable COLUMNS takes the place of the terminal's own answer.
pub fn width() -> usize {
    if !io::stdout().is_terminal() {
        return PLAIN;
    }
    let asked = std::env::var("COLUMNS").ok().and_then(|columns| columns.parse().ok()).filter(|columns| *columns > 0);
    let own = || terminal_size::terminal_size_of(io::stdout()).map(|(width, _)| usize::from(width.0));
    asked.or_else(own).unwrap_or(PLAIN).max(NARROWEST)
}

/// The columns that a line of prose may have.
pub fn prose_width() -> usize {
    width().min(PROSE)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ColumnKind {
    /// On the left, in one piece.
    Name,
    /// On the right, in one piece.
    Number,
    /// On the left, wrapped at spaces.
    Text,
}

/// A column: its title (with a line break where it has two lines), what it holds, and its rank.
#[derive(Clone)]
pub struct Column {
    title: Cow<'static, str>,
    kind: ColumnKind,
    rank: u8,
}

impl Column {
    /// Names, in one piece.
    pub const fn name(title: &'static str) -> Self {
        Self { title: Cow::Borrowed(title), kind: ColumnKind::Name, rank: 0 }
    }

    /// Numbers, in one piece, aligned to the right.
    pub const fn number(title: &'static str) -> Self {
        Self { title: Cow::Borrowed(title), kind: ColumnKind::Number, rank: 0 }
    }

    /// Text, wrapped at spaces.
    pub const fn text(title: &'static str) -> Self {
        Self { title: Cow::Borrowed(title), kind: ColumnKind::Text, rank: 0 }
    }

    /// The same column with another title.
    pub fn titled(mut self, title: impl Into<String>) -> Self {
        self.title = Cow::Owned(title.into());
        self
    }

    /// Left out before the columns of lower rank; those of rank 0 never are, those of one rank are together.
    pub const fn rank(mut self, rank: u8) -> Self {
        self.rank = rank;
        self
    }
}

/// A table: its columns, and rows of as many cells (or fewer).
pub struct Table {
    columns: Vec<Column>,
    rows: Vec<Vec<String>>,
}

impl Table {
    /// Without rows.
    pub fn new(columns: &[Column]) -> Self {
        Self { columns: columns.to_vec(), rows: Vec::new() }
    }

    /// Adds a row.
    pub fn row(&mut self, cells: impl IntoIterator<Item = impl Into<String>>) {
        self.rows.push(cells.into_iter().map(Into::into).collect());
    }

    /// The table, as wide as the terminal at most; without a line break at the end.
    pub fn text(&self) -> String {
        let width = width();
        let (shown, widths) = self.fit(width);
        let mut table = comfy_table::Table::new();
        table.load_style(UTF8_HORIZONTAL_ONLY).set_content_arrangement(ContentArrangement::Disabled);
        table.style_mut().row_separator = comfy_table::LineStyle::none();
        table.set_header(shown.iter().map(|&k| self.columns[k].title.as_ref()));
        for row in &self.rows {
            table.add_row(shown.iter().zip(&widths).map(|(&k, &width)| {
                let cell = row.get(k).map_or("", String::as_str);
                if self.columns[k].kind == ColumnKind::Text { wrapped(cell, width).join("\n") } else { cell.to_owned() }
            }));
        }
        for (at, column) in table.column_iter_mut().enumerate() {
            // The style puts one more space between two columns.
            column.set_padding((0, if at + 1 < shown.len() { GAP as u16 - 1 } else { 0 }));
            if self.columns[shown[at]].kind == ColumnKind::Number {
                column.set_cell_alignment(CellAlignment::Right);
            }
        }
        let mut text = table.trim_fmt();
        let left_out: Vec<String> = (0..self.columns.len())
            .filter(|k| !shown.contains(k))
            .map(|k| self.columns[k].title.replace("-\n", "").replace('\n', " "))
            .collect();
        if !left_out.is_empty() {
            let needed = total((0..self.columns.len()).map(|k| self.least(k)));
            let note = format!("Columns not shown: {} (a terminal of {needed} columns shows all)", left_out.join(", "));
            text = format!("{text}\n{}", paragraph_in(&note, width));
        }
        text
    }

    /// The columns that fit, and their widths.
    fn fit(&self, width: usize) -> (Vec<usize>, Vec<usize>) {
        let mut shown: Vec<usize> = (0..self.columns.len()).collect();
        while total(shown.iter().map(|&k| self.least(k))) > width {
            let rank = shown.iter().map(|&k| self.columns[k].rank).max().unwrap_or(0);
            if rank == 0 {
                break;
            }
            shown.retain(|&k| self.columns[k].rank < rank);
        }
        let mut widths: Vec<usize> = shown.iter().map(|&k| self.least(k)).collect();
        // What is left over goes to the columns of text, from the left.
        let mut left = width.saturating_sub(total(widths.iter().copied()));
        for (&k, width) in shown.iter().zip(&mut widths) {
            let more = self.natural(k).saturating_sub(*width).min(left);
            *width += more;
            left -= more;
        }
        (shown, widths)
    }

    fn cells(&self, k: usize) -> impl Iterator<Item = &str> {
        self.columns[k].title.lines().chain(self.rows.iter().filter_map(move |row| row.get(k).map(String::as_str)))
    }

    /// The width of column `k` without any wrapping.
    fn natural(&self, k: usize) -> usize {
        self.cells(k).map(UnicodeWidthStr::width).max().unwrap_or(0)
    }

    /// The least width of column `k`.
    fn least(&self, k: usize) -> usize {
        let natural = self.natural(k);
        if self.columns[k].kind != ColumnKind::Text {
            return natural;
        }
        let words = self.cells(k).flat_map(|cell| cell.split(' ')).map(UnicodeWidthStr::width);
        words.max().unwrap_or(0).max(natural.min(TEXT))
    }
}

/// The width of columns side by side.
fn total(widths: impl Iterator<Item = usize>) -> usize {
    widths.map(|width| width + GAP).sum::<usize>().saturating_sub(GAP)
}

/// The lines of `text`, broken after `separator` so that none is wider than `width`, save where one piece is.
///
/// A line that fits stays as it is; line breaks of the text are kept, and a line's indentation goes on.
fn broken(text: &str, width: usize, separator: &str) -> Vec<String> {
    let mut lines = Vec::new();
    for line in text.split('\n') {
        let (indent, line) = line.split_at(line.len() - line.trim_start_matches(' ').len());
        let mut now = indent.to_owned();
        for piece in line.split_inclusive(separator) {
            let fits = now.width() + piece.trim_end_matches(' ').width() <= width;
            if !fits && now.len() > indent.len() {
                lines.push(now.trim_end_matches(' ').to_owned());
                now.truncate(indent.len());
            }
            now.push_str(piece);
        }
        lines.push(now);
    }
    lines
}

fn wrapped(text: &str, width: usize) -> Vec<String> {
    broken(text, width, " ")
}

/// A line of JSON that is shown. Whole, to be copied, where standard output is no terminal; broken after commas on a terminal that
/// is narrower.
pub fn data(line: &str) -> String {
    if io::stdout().is_terminal() { broken(line, width(), ",").join("\n") } else { line.to_owned() }
}

/// Prose, wrapped at spaces; line breaks and the indentation of each line are kept.
pub fn paragraph(text: &str) -> String {
    paragraph_in(text, prose_width())
}

fn paragraph_in(text: &str, width: usize) -> String {
    wrapped(text, width).join("\n")
}

/// Names on the left (`indent` columns in), text that wraps on the right, without lines.
pub fn entries<A: Into<String>>(indent: u16, rows: impl IntoIterator<Item = (A, String)>) -> String {
    listed(usize::from(indent), rows.into_iter().map(|(name, text)| (name.into(), text)).collect())
}

fn listed(indent: usize, rows: Vec<(String, String)>) -> String {
    let width = prose_width();
    let most = rows.iter().map(|(name, _)| name.width()).max().unwrap_or(0).max(NAMES);
    let names = most.min(width / 3);
    let start = indent + names + GAP;
    let mut lines = Vec::new();
    for (name, text) in &rows {
        let mut texts = wrapped(text, width.saturating_sub(start)).into_iter();
        // A name that is too long for its column has a line of its own.
        let first = if name.width() > names { String::new() } else { texts.next().unwrap_or_default() };
        let fill = " ".repeat((names + GAP).saturating_sub(name.width()));
        lines.push(format!("{:indent$}{name}{fill}{first}", "").trim_end().to_owned());
        lines.extend(texts.map(|text| format!("{:start$}{text}", "").trim_end().to_owned()));
    }
    lines.join("\n")
}

/// A duration: `0.012 s`, `3.4 s`, `250 s`.
pub fn seconds(seconds: f64) -> String {
    match seconds {
        s if s < 0.0995 => format!("{s:.3} s"),
        s if s < 99.5 => format!("{s:.1} s"),
        s => format!("{s:.0} s"),
    }
}
