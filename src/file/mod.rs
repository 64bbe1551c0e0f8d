//! Text files: read with the place of what is wrong in them, written whole.

mod excerpt;
mod output;

pub use excerpt::Excerpt;
pub(crate) use output::lock;
pub use output::{Kept, Output, write};

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// The longest record of a case, and the longest manifest, that is read, in bytes: none that this crate writes comes near.
pub const LONGEST: usize = 1 << 28;

/// The text of the file at a path.
///
/// # Errors
/// Those of [`text`].
pub fn read(path: &Path, most: usize) -> io::Result<String> {
    text(File::open(path)?, most)
}

/// The text that `reader` gives: UTF-8, of at most `most` bytes.
///
/// ```
/// use euler_poincare::file;
///
/// let error = file::text(&b"a = 1\nb = \xff"[..], 100).unwrap_err();
/// assert_eq!(error.to_string(), "line 2, byte 5: 0xff is not valid UTF-8");
/// assert!(file::text(&b"four"[..], 3).unwrap_err().to_string().contains("at most 3"));
/// ```
///
/// # Errors
/// What the operating system says; a text that is longer, or is not UTF-8: with the line and the byte in it, both from 1.
pub fn text(reader: impl Read, most: usize) -> io::Result<String> {
    let invalid = |why: String| io::Error::new(io::ErrorKind::InvalidData, why);
    let mut bytes = Vec::new();
    reader.take((most as u64).saturating_add(1)).read_to_end(&mut bytes)?;
    if bytes.len() > most {
        return Err(invalid(format!("is longer than allowed: at most {most} bytes")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let (bytes, at) = (error.as_bytes(), error.utf8_error().valid_up_to());
        let before = bytes.get(..at).unwrap_or_default();
        let line = 1 + before.iter().filter(|byte| **byte == b'\n').count();
        let byte = 1 + before.iter().rev().take_while(|byte| **byte != b'\n').count();
        let found = bytes.get(at).copied().unwrap_or_default();
        invalid(format!("line {line}, byte {byte}: {found:#04x} is not valid UTF-8"))
    })
}

/// Whether the name of a file ends as those of a format do, or has no ending.
///
/// ```
/// use euler_poincare::file::ends_in;
/// assert!(ends_in("a/b.SVG".as_ref(), "svg") && ends_in("b".as_ref(), "svg") && !ends_in("b.png".as_ref(), "svg"));
/// ```
pub fn ends_in(path: &Path, format: &str) -> bool {
    path.extension().is_none_or(|ending| ending.eq_ignore_ascii_case(format))
}

/// The text with its control characters spelled, as `\u001b`: what comes out of files and programs does nothing to a terminal. Lines
/// and tabs stay. JSON stays JSON with the same values: in it these characters stand inside of strings only.
///
/// ```
/// assert_eq!(euler_poincare::file::spelled("a\u{1b}[2J\n"), "a\\u001b[2J\n");
/// ```
pub fn spelled(text: &str) -> String {
    let acts = |c: char| c.is_control() && c != '\n' && c != '\t';
    let mut spelled = String::with_capacity(text.len());
    for c in text.chars() {
        if acts(c) { spelled.push_str(&format!("\\u{:04x}", u32::from(c))) } else { spelled.push(c) }
    }
    spelled
}
