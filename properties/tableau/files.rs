//! Tableau files, good and bad.

use super::rows;
use euler_poincare::tableau::{FileError, TableauFile};
use proptest::prelude::*;

#[test]
fn both_formats_are_read() {
    let toml = "# Radau\nname = \"two stages\"\norder = 3\na = [[\"5/12\", \"-1/12\"], [0.75, 0.25]]\nb = [0.75, \"1/4\"]\nc = [\"1/3\", 1]\n";
    let json = r#" {"name": "two stages", "order": 3, "a": [["5/12", "-1/12"], [0.75, 0.25]], "b": [0.75, "1/4"], "c": ["1/3", 1]}"#;
    let (toml, json) = (TableauFile::parse(toml).unwrap(), TableauFile::parse(json).unwrap());
    assert_eq!(toml, json);
    let analysis = toml.analyse(8).unwrap();
    assert_eq!((analysis.declared, analysis.description.as_str(), analysis.exact), (Some(3), "two stages", true));
    assert_eq!((analysis.exactly.classical.order, analysis.exactly.variational.order), (3, 3));
    assert_eq!(analysis.notes(), Vec::<String>::new());
}

#[test]
fn a_wrong_declaration_is_noted() {
    let file = TableauFile::parse("order = 4\na = [[0, 0], [1, 0]]\nb = [0.5, 0.5]").unwrap();
    let notes = file.analyse(8).unwrap().notes();
    assert_eq!(notes.len(), 1);
    assert!(
        notes[0].starts_with("The declared order is 4, but the order of the variational integrator is 2: Σ b_i"),
        "{notes:?}"
    );
}

/// The order of a file is that of the variational integrator: a classical one that is higher is told apart.
#[test]
fn a_classical_order_is_told_from_that_of_the_scheme() {
    let text = "order = 3\na = [[0, 0, 0], [\"1/2\", 0, 0], [0, \"3/4\", 0]]\nb = [\"2/9\", \"1/3\", \"4/9\"]";
    let analysis = TableauFile::parse(text).unwrap().analyse(8).unwrap();
    assert_eq!([2, 3, 4].map(|order| analysis.has_order(order)), [Some(true), Some(false), Some(false)]);
    let notes = analysis.notes();
    assert!(notes[0].ends_with("integrator is 2; 3 is the order as a Runge–Kutta method."), "{notes:?}");
    assert!(notes[1].contains("D(1) fails"), "{notes:?}");
}

#[test]
fn bad_files_are_refused_by_the_name_of_the_entry() {
    let listed = rows(include_str!("wrong/files.txt"), 32);
    for (text, expected) in listed.chain([(String::new(), "missing field `a`"), ("\u{0}".into(), "line 1")]) {
        let error = TableauFile::parse(&text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text:?}: {error}");
    }
}

/// Where a message points: in both formats at the entry, or at the list that is too long, too short or without it.
#[test]
fn errors_point_at_the_entry() {
    for (text, place) in rows(include_str!("wrong/places.txt"), 11) {
        let (line, column) = place.split_once(", ").unwrap();
        let (line, column): (usize, usize) = (line.parse().unwrap(), column.parse().unwrap());
        let error = TableauFile::parse(&text).unwrap_err().to_string();
        assert!(error.starts_with(&format!("line {line}, column {column}: ")), "{text:?}: {error}");
        let mark = format!("\n{line} | {}\n{}^", text.lines().nth(line - 1).unwrap(), " ".repeat(column + 3));
        assert!(error.ends_with(&mark), "{text:?}: {error}");
    }
}

#[test]
fn digits_that_would_be_lost_must_be_in_quotes() {
    let file = |c: &str| {
        TableauFile::parse(&format!("# 1.23456789012345678901\na = [[0.25, {c}],\n[\"1/4\", 0]]\nb = [0.5, 0.5]"))
    };
    let refused = |file: Result<TableauFile, FileError>| match file {
        Err(FileError::Digits { place, digits }) => (place.line, place.column, digits),
        other => panic!("{other:?}"),
    };
    assert_eq!(refused(file("0.1234567890123456789012")), (2, 13, 22));
    for text in
        ["\"0.1234567890123456789012\"", "0.12345678901234567", "0.500000000000000000000000", "1e-100", "1_000.5"]
    {
        assert!(file(text).is_ok(), "{text}: {:?}", file(text));
    }
    let json = "{\"a\": [[\"0.1234567890123456789012\"]],\n\"b\": [1.000000000000000000001]}";
    assert_eq!(refused(TableauFile::parse(json)), (2, 7, 22));
}

/// Quotes end where they began, whatever is between them.
#[test]
fn digits_in_quotes_are_text() {
    for name in ["12345678901234567890", "a 'b' 12345678901234567890", "\\\" 12345678901234567890", "# 1"] {
        let text = format!("name = \"{name}\"\na = [[0.5]]\nb = [1]");
        assert!(TableauFile::parse(&text).is_ok(), "{text}: {:?}", TableauFile::parse(&text));
    }
    let after = "name = 'it is \"so'\na = [[0.5]]\nb = [1.000000000000000000001]";
    assert!(matches!(TableauFile::parse(after), Err(FileError::Digits { place, digits: 22 }) if place.line == 3));
    let behind = "name = \"x\" # 12345678901234567890\na = [[0.5]]\nb = [1]";
    assert!(TableauFile::parse(behind).is_ok());
}

proptest! {
    #[test]
    fn nothing_panics(text in "[ab = \\[\\],.0-9e\"'{}:#\\n-]{0,60}", cut in 0usize..200) {
        let _ = TableauFile::parse(&text);
        let whole = "{\"a\": [[\"5/12\", -0.0833], [0.75, 0.25]], \"b\": [0.75, \"1/4\"], \"c\": [\"1/3\", 1], \"name\": \"π\"}";
        let cut = (0..=cut.min(whole.len())).rev().find(|&at| whole.is_char_boundary(at)).unwrap();
        let _ = TableauFile::parse(&format!("{}{text}", &whole[..cut]));
    }
}

#[test]
fn large_files_are_refused() {
    let row = format!("[{}]", vec!["0"; 65].join(","));
    let wide = format!("a = [{}]\nb = {row}", vec![row.clone(); 65].join(","));
    assert!(
        TableauFile::parse(&wide).unwrap_err().to_string().contains("entry b: has 65 entries; allowed are at most 64")
    );
    let long = format!("a = [[0]]\nb = [1]\n#{}", "x".repeat(64 * 1024));
    assert!(matches!(TableauFile::parse(&long), Err(FileError::TooLong { .. })));
    let deep = format!("{{\"a\": {}", "[".repeat(60_000));
    assert!(TableauFile::parse(&deep).is_err());
    assert!(TableauFile::parse(&format!("a = {}", "[".repeat(60_000))).is_err());
}

#[test]
fn sixty_four_stages_are_the_most() {
    let row = format!("[{}]", vec!["\"1/64\""; 64].join(","));
    let tall = |rows: usize| TableauFile::parse(&format!("a = [{}]\nb = {row}", vec![row.clone(); rows].join(",")));
    assert!(tall(64).is_ok(), "{:?}", tall(64));
    assert!(tall(65).unwrap_err().to_string().contains("entry a: has 65 rows; allowed are at most 64"));
}
