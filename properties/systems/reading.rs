//! Files that a system file names, and what is read instead of its parts.

use super::{parsed, rows};
use euler_poincare::scalar::Dd;
use euler_poincare::system::{Reading, ScalarName, SystemFile};
use std::fs;
use std::path::{Path, PathBuf};

/// Gauss with two stages, by entries that every scalar evaluates exactly.
const ENTRIES: &str = "a = [[\"1/4\", \"1/4 - sqrt(3)/6\"], [\"1/4 + sqrt(3)/6\", \"1/4\"]]\nb = [\"1/2\", \"1/2\"]\n";

fn system(tableau: &str) -> String {
    format!(
        "format = 1\n[algebra]\nname = \"so3\"\n[lagrangian]\ninertia = [\"1/2\", 2, 1]\n[method]\n{tableau}\n\
         retraction = \"exp\"\n[state]\nvelocity = [1, 0, 1]\n[run]\nstep = \"1/8\"\nsteps = 8\n"
    )
}

/// The line of the tableau in such a file.
const LINE: usize = 7;

/// A directory with these files.
fn directory(name: &str, files: &[(&str, &str)]) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("reading").join(name);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    files.iter().for_each(|(name, text)| fs::write(path.join(name), text).unwrap());
    path
}

#[test]
fn a_tableau_file_is_read_in_the_directory_of_the_system_file() {
    let json = "{\"name\": \"mine\", \"order\": 4, \"a\": [[\"1/4\", \"1/4 - sqrt(3)/6\"], [\"1/4 + sqrt(3)/6\", 0.25]], \"b\": [0.5, \"1/2\"]}";
    let here = directory("beside", &[("mine.toml", ENTRIES), ("mine.json", json)]);
    let beside = Reading::beside(&here.join("system.toml"));
    let wanted = rows::<Dd>(&parsed(&system(ENTRIES)), None);
    for name in ["mine.toml", "mine.json", "../beside/mine.toml"] {
        let text = system(&format!("tableau-file = \"{name}\""));
        let file = SystemFile::parse_with(&text, &beside).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(rows::<Dd>(&file, None), wanted, "{name}");
        // The entries are in the case, and in what is written of it.
        assert_eq!(parsed(&file.to_toml().unwrap()), file, "{name}");
    }
}

#[test]
fn a_tableau_and_a_scalar_stand_in_the_place_of_those_of_the_file() {
    let gauss = Reading { tableau: Some("gauss-2".parse().unwrap()), ..Reading::default() };
    let wanted = rows::<f64>(&parsed(&system("tableau = \"gauss-2\"")), None);
    // Whatever the file says, or nothing.
    for tableau in ["tableau = \"rk4\"", "", ENTRIES, "tableau-file = \"absent.toml\""] {
        let file = SystemFile::parse_with(&system(tableau), &gauss).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(rows::<f64>(&file, None), wanted, "{tableau}");
    }
    let precise = Reading { scalar: Some(ScalarName::Dd), ..Reading::default() };
    assert_eq!(SystemFile::parse_with(&system("tableau = \"rk4\""), &precise).unwrap().scalar, ScalarName::Dd);
    // With a tolerance, too.
    let tolerant = system("").replacen("step = \"1/8\"\nsteps = 8", "tolerance = 1e-8\nhorizon = 1", 1);
    let file = SystemFile::parse_with(&tolerant, &gauss).unwrap();
    assert_eq!(file.case.method.tableau, "gauss-2".parse().unwrap());
    // A method that is not of this crate needs none.
    assert!(SystemFile::parse_for_stepper(&system("tableau-file = \"absent.toml\"")).is_ok());
}

#[test]
fn a_tableau_file_that_is_wrong_is_an_error_at_its_name() {
    let here = directory(
        "wrong",
        &[
            ("good.toml", ENTRIES),
            ("syntax.toml", "a = [[0]]\nb = [1,\n"),
            ("key.toml", "a = [[\"1/2\"]]\nb = [1]\nstages = 1\n"),
            ("entry.toml", "a = [[0, \"x\"], [1, 0]]\nb = [0.5, 0.5]\n"),
            ("weight.toml", "a = [[0, 0], [1, 0]]\nb = [1, 0]\n"),
            ("digits.toml", "a = [[0.500000000000000000001]]\nb = [1]\n"),
            ("rows.json", "{\"a\": [[0, 0]], \"b\": [1]}"),
        ],
    );
    let beside = Reading::beside(&here.join("system.toml"));
    let refused = |tableau: &str, reading: &Reading, column: usize, wanted: &str| {
        let error = SystemFile::parse_with(&system(tableau), reading).expect_err(tableau);
        assert_eq!((error.line, error.column), (LINE, column), "{tableau}: {error}");
        assert!(error.message.contains(wanted), "{tableau}: {error}");
    };
    let value = "tableau-file = ".len() + 1;
    for (name, wanted) in [
        ("absent.toml", "method.tableau-file: absent.toml: "),
        (".", "method.tableau-file: .: "),
        ("syntax.toml", "syntax.toml: line "),
        ("key.toml", "key.toml: line 3, column 1: unknown field `stages`"),
        ("entry.toml", "entry.toml: line 1, column 10: entry a_12: `x` is not a number"),
        ("weight.toml", "weight.toml: "),
        ("digits.toml", "digits.toml: line 1, column 7: a number with 21 digits"),
        ("rows.json", "rows.json: "),
    ] {
        refused(&format!("tableau-file = \"{name}\""), &beside, value, wanted);
    }
    refused("tableau-file = 3", &beside, value, "invalid type: integer `3`, expected a string");
    refused(
        "tableau-file = \"good.toml\"",
        &Reading::default(),
        value,
        "a text alone does not say in which directory it is",
    );
    let alone = "either `tableau`, or `tableau-file`, or `a` and `b`, one of these alone";
    refused("tableau-file = \"good.toml\"\ntableau = \"rk4\"", &beside, value, alone);
    refused("tableau-file = \"good.toml\"\nb = [1]", &beside, value, alone);
}
