//! A table of CSV that is written row by row.

use super::columns::print;
use crate::cli::output::create;
use crate::cli::summary::count;
use crate::cli::{Failure, printed};
use euler_poincare::file::{Kept, Output};
use euler_poincare::scalar::Real;
use std::io::{self, IsTerminal, Write};
use std::path::Path;

/// A table under way. After a failure nothing more is written, and [`Rows::finish`] returns it.
pub struct Rows {
    out: Output,
    /// The row under way, and how many fields it has.
    line: String,
    fields: usize,
    failure: Option<io::Error>,
}

impl Rows {
    /// An empty table.
    pub fn new(out: Output) -> Self {
        Self { out, line: String::new(), fields: 0, failure: None }
    }

    /// An empty table at a path or on the standard output, and whether progress can be shown beside it.
    pub fn create(path: Option<&Path>) -> Result<(Self, bool), Failure> {
        let out = path.map_or_else(|| Output::standard().map_err(Failure::Output), create)?;
        let shown = io::stderr().is_terminal() && (path.is_some() || !io::stdout().is_terminal());
        Ok((Self::new(out), shown))
    }

    /// Whether it could not be written.
    pub fn failed(&self) -> bool {
        self.failure.is_some()
    }

    fn separate(&mut self) {
        if self.fields > 0 {
            self.line.push(',');
        }
        self.fields += 1;
    }

    /// A field.
    pub fn text(&mut self, text: &str) {
        self.separate();
        if text.contains([',', '"', '\n', '\r']) {
            self.line.push_str(&format!("\"{}\"", text.replace('"', "\"\"")));
        } else {
            self.line.push_str(text);
        }
    }

    /// A field with a number.
    pub fn number<T: Real>(&mut self, value: T) {
        self.separate();
        print(&mut self.line, value);
    }

    /// Ends the row.
    pub fn end(&mut self) {
        self.line.push('\n');
        if self.failure.is_none() {
            self.failure = self.out.write_all(self.line.as_bytes()).err();
        }
        self.line.clear();
        self.fields = 0;
    }

    /// A row with the names of the columns.
    pub fn header(&mut self, names: &[String]) {
        names.iter().for_each(|name| self.text(name));
        self.end();
    }

    /// Writes what was gathered.
    pub fn flush(&mut self) {
        self.failure = self.failure.take().or_else(|| self.out.flush().err());
    }

    /// Puts the rows in their place, a file or the standard output; false where the reader of the latter has closed it. Where a file could
    /// not be written to its end, its rows are kept beside what was there, and counted.
    pub fn finish(self, path: Option<&Path>) -> Result<bool, Failure> {
        match (path, self.failure) {
            (Some(path), None) => self.out.commit().map_err(|error| Failure::file(path, error)).map(|()| true),
            (Some(path), Some(error)) => {
                let told = match self.out.keep() {
                    // Without the header.
                    Ok(Some(Kept { path, lines })) => {
                        format!("the first {} are in {}", count(lines - 1, "row"), path.display())
                    }
                    _ => "no rows are kept".into(),
                };
                Err(Failure::file(path, format!("{error}; what was there is unchanged, {told}")))
            }
            (None, failure) => {
                let done = failure.map_or_else(|| self.out.commit(), Err);
                let read = !done.as_ref().is_err_and(|error| error.kind() == io::ErrorKind::BrokenPipe);
                printed(done).map(|()| read)
            }
        }
    }
}
