//! Files that are wrong in one place.

use euler_poincare::system::SystemFile;

/// Of the file with one text replaced: an error with its place and message. A row of `bad` is the text, what it becomes, what `stands` at the
/// place (by the line and its rest from the caret on), and parts of the message with ` … ` between them. There are `count` rows.
pub fn refuses_each(file: &str, bad: &str, count: usize, stands: fn(&str, &str, &str) -> bool) {
    SystemFile::parse(file).unwrap_or_else(|error| panic!("{error}"));
    let (mut failures, mut rows) = (Vec::new(), 0);
    for row in bad.lines().filter(|row| !row.is_empty() && !row.starts_with("# ")) {
        rows += 1;
        let parts: Vec<String> = row.split(" | ").map(|part| part.replace("\\n", "\n")).collect();
        let [from, to, place, message] = &parts[..] else { panic!("{row}") };
        assert!(file.contains(from) && !message.is_empty(), "{row}");
        let text = file.replacen(from, to, 1);
        let Err(error) = SystemFile::parse(&text) else {
            failures.push(format!("accepted: {row}"));
            continue;
        };
        let line = text.lines().nth(error.line - 1).unwrap_or("");
        let rest: String = line.chars().skip(error.column - 1).collect();
        if !line.starts_with(&error.excerpt) || !stands(&error.excerpt, &rest, place) {
            failures.push(format!("{row}: the caret is under {rest:?}: {error}"));
        }
        if let Some(missing) = message.split(" … ").find(|part| !error.message.contains(part)) {
            failures.push(format!("{row}: wanted {missing:?} in {error}"));
        }
    }
    assert_eq!(rows, count, "rows");
    assert!(failures.is_empty(), "{}", failures.join("\n\n"));
}
