//! The JSON of the commands and files has the keys and types that `src/guide/source/json.md` documents, and no others.

use super::probe::{steppers, with_python};
use super::{FAULT, LAW, directory, run, stdout, typed};
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// The tables of the chapter: heading → key → type.
struct Documented(BTreeMap<String, BTreeMap<String, String>>);

impl Documented {
    fn read() -> Self {
        let text = include_str!("../../src/guide/source/json.md");
        let mut tables = BTreeMap::<String, BTreeMap<String, String>>::new();
        let mut heading = String::new();
        for line in text.lines() {
            if let Some(title) = line.strip_prefix('#') {
                heading = title.trim_start_matches('#').trim().trim_matches('`').to_owned();
            } else if let Some(row) = line.strip_prefix("| `") {
                let cells: Vec<&str> = row.split(" | ").collect();
                assert_eq!(cells.len(), 3, "{line}");
                let key = cells[0].trim_end_matches('`').to_owned();
                assert!(
                    tables.entry(heading.clone()).or_default().insert(key, cells[1].to_owned()).is_none(),
                    "{line}"
                );
            }
        }
        Self(tables)
    }

    /// The object has the keys of the table, save optional ones, and each value has its type.
    fn check(&self, name: &str, value: &Value) {
        let table = self.0.get(name).unwrap_or_else(|| panic!("{name} is not documented"));
        let object = value.as_object().unwrap_or_else(|| panic!("{name}: {value}"));
        for key in object.keys() {
            assert!(table.contains_key(key), "{name}: the key {key} is not documented");
        }
        for (key, kind) in table {
            match (object.get(key), kind.strip_prefix("optional, ")) {
                (Some(value), kept) => {
                    let kind = kept.unwrap_or(kind);
                    assert!(self.is(kind, value), "{name}.{key} should be {kind}: {value}");
                }
                (None, None) => panic!("{name}: the key {key} is missing in {value}"),
                (None, Some(_)) => {}
            }
        }
    }

    fn is(&self, kind: &str, value: &Value) -> bool {
        if let Some(of) = kind.strip_prefix("array of ") {
            return value.as_array().is_some_and(|items| items.iter().all(|item| self.is(of, item)));
        }
        if let Some(of) = kind.strip_prefix("map of ") {
            return value.as_object().is_some_and(|items| items.values().all(|item| self.is(of, item)));
        }
        if let Some((one, other)) = kind.split_once(" or ") {
            return self.is(one, value) || self.is(other, value);
        }
        match kind {
            "null" => value.is_null(),
            "string" => value.is_string(),
            "boolean" => value.is_boolean(),
            "integer" => value.is_i64() || value.is_u64(),
            "number" => value.is_number(),
            "object" => value.is_object(),
            name => {
                self.check(name.trim_matches('`'), value);
                true
            }
        }
    }

    /// Each line is an object of this schema.
    fn check_lines(&self, schema: &str, text: &str) {
        assert!(text.lines().count() > 0, "{schema}: no lines");
        for line in text.lines() {
            let value: Value = serde_json::from_str(line).unwrap();
            let own = value["schema"].as_str().unwrap_or(schema);
            assert!(own == schema || own.starts_with("probe-"), "{own}: {line}");
            self.check(own, &value);
        }
    }
}

#[test]
fn printed_keys_are_those_that_are_documented() {
    let documented = Documented::read();
    let here = directory("schemas");
    fs::write(here.join("rounded.toml"), "a = [[0, 0], [0.667, 0]]\nb = [0.25, 0.75]\n").unwrap();
    for (schema, words) in [
        ("verify/1", "verify --cases 5 --laws retraction-adjoint,energy-balance"),
        ("verify-faults/1", &format!("verify --faults --sizes --laws {LAW} --out faults")),
        ("laws/1", "laws"),
        ("laws/1", &format!("laws --coverage --laws {LAW}")),
        ("order/1", "order --tableau rk4"),
        ("order/1", "order --tableau ralston3"),
        ("order/1", "order --tableau rounded.toml"),
    ] {
        documented.check_lines(schema, stdout(&typed(&here, &format!("{words} --format json")).ends(0)));
    }
    // The files of a campaign, of which a law is broken.
    typed(&here, &format!("verify --laws {LAW} --cases 10 --plant {FAULT} --out whole")).ends(1);
    let read = |name: &str| fs::read_to_string(here.join(name)).unwrap();
    let file = |name: &str| serde_json::from_str::<Value>(&read(name)).unwrap();
    documented.check("campaign.json", &file("whole/campaign.json"));
    documented.check_lines("results.jsonl", &read("whole/results.jsonl"));
    documented.check_lines("timings.jsonl", &read("whole/timings.jsonl"));
    documented.check_lines("verify-faults/1", &read("faults/faults.jsonl"));
    let failures: Vec<_> = fs::read_dir(here.join("whole/failures")).unwrap().collect();
    assert_eq!(failures.len(), 1);
    let failure = fs::read_to_string(failures[0].as_ref().unwrap().path()).unwrap();
    documented.check("failures/*.json", &serde_json::from_str(&failure).unwrap());
}

/// The text of a file, or of all files of a directory and below.
fn text_of(path: PathBuf) -> String {
    match fs::read_dir(&path) {
        Ok(entries) => entries.map(|entry| text_of(entry.unwrap().path())).collect(),
        Err(_) => fs::read_to_string(path).unwrap(),
    }
}

#[test]
fn every_documented_schema_is_printed_by_a_command() {
    let text = text_of(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/cli"));
    let documented = Documented::read();
    for schema in documented.0.keys().filter(|name| name.contains('/') && !name.contains('*')) {
        assert!(text.contains(&format!("\"{schema}\"")), "{schema} is documented, and no command prints it");
    }
}

#[test]
fn the_keys_of_a_probe_and_its_record_are_those_that_are_documented() {
    let Some(here) = with_python("the_keys_of_a_probe_and_its_record_are_those_that_are_documented") else { return };
    let documented = Documented::read();
    let stepper = steppers("rk4.py");
    // A claim that is false: the record of a broken law.
    for (order, expected) in [("4", 0), ("3", 1)] {
        let arguments = ["probe", "--laws", "method-order", "--cases", "3", "--order", order, "--format", "json", "--"];
        let output = run(&here, &[&arguments[..], &["python3", &stepper]].concat()).ends(expected);
        documented.check_lines("probe/1", stdout(&output));
    }
    let records = fs::read_dir(&here).unwrap().map(|entry| entry.unwrap().path());
    let records: Vec<_> = records.filter(|path| path.extension().is_some_and(|end| end == "json")).collect();
    assert_eq!(records.len(), 1);
    let text = fs::read_to_string(&records[0]).unwrap();
    documented.check("probe-*.json", &serde_json::from_str(&text).unwrap());
    let name = records[0].file_name().unwrap().to_str().unwrap();
    let again = run(&here, &["probe", "--replay", name, "--format", "json"]).ends(1);
    documented.check_lines("probe-replay/1", stdout(&again));
}
