//! Files that are wrong in one place.

use euler_poincare::system::SystemFile;

/// Of the file with one text replaced: an error with its place and message. A row of `bad` is the text, what it becomes, what `stands` at the
/// place (by the line and its rest from the caret on), and parts of the message with ` … ` between them.
pub fn refuses_each(file: &str, bad: &str, stands: fn(&str, &str, &str) -> bool) {
    SystemFile::parse(file).unwrap_or_else(|error| panic!("{error}"));
    let mut failures = Vec::new();
    for row in bad.lines().filter(|row| !row.is_empty() && !row.starts_with("# ")) {
        let mut parts = row.split(" | ").map(|part| part.replace("\\n", "\n"));
        let [from, to, place, message] = [(); 4].map(|()| parts.next().unwrap_or_default());
        assert!(file.contains(&from) && parts.next().is_none(), "{row}");
        let text = file.replacen(&from, &to, 1);
        let Err(error) = SystemFile::parse(&text) else {
            failures.push(format!("accepted: {row}"));
            continue;
        };
        let line = text.lines().nth(error.line - 1).unwrap_or("");
        let rest: String = line.chars().skip(error.column - 1).collect();
        if !line.starts_with(&error.excerpt) || !stands(&error.excerpt, &rest, &place) {
            failures.push(format!("{row}: the caret is under {rest:?}: {error}"));
        }
        if let Some(missing) = message.split(" … ").find(|part| !error.message.contains(part)) {
            failures.push(format!("{row}: wanted {missing:?} in {error}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}
