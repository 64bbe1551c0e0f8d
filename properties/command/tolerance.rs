//! `integrate` with a tolerance in the file: the report, the table of events, options without effect, interrupted runs.

use super::{
    code, command, directory, flat, has_all, run, started, stderr, stdout, stopped, system, wait_for, whole_rows,
};
use std::fs;
use std::path::Path;
use std::process::Stdio;

/// A heavy top that is drawn to rest: nutation, and two events, of which the second ends the run.
pub const TOP: &str = include_str!("../systems/cases/nutation.toml");

fn file(here: &Path, name: &str, changes: &[(&str, &str)]) {
    let text = changes.iter().fold(TOP.to_owned(), |text, (from, to)| {
        assert!(text.contains(from), "{from}");
        text.replacen(from, to, 1)
    });
    fs::write(here.join(name), text).unwrap();
}

#[test]
fn the_report_says_what_was_taken_and_why_the_run_ended() {
    let here = directory("tolerance");
    file(&here, "top.toml", &[]);
    let arguments = ["integrate", "top.toml", "--out", "t.csv", "--events", "e.csv", "--plot", "t.svg"];
    let output = run(&here, &arguments).quiet();
    let words = flat(stdout(&output));
    let rows = fs::read_to_string(here.join("t.csv")).unwrap();
    let count = rows.lines().count() - 1;
    has_all(
        &words,
        &format!(
            "t.csv: {count} rows; ended at t =  ¦ by the event \"low\":  ¦  steps,  ¦  refused,  ¦ \
             \u{20}iterations, errors of all steps  ¦ (tolerance 1e-10)"
        ),
    );
    let events = fs::read_to_string(here.join("e.csv")).unwrap();
    let header = rows.lines().next().unwrap();
    let columns = header.strip_suffix(",residual,iterations").unwrap();
    assert_eq!(events.lines().next().unwrap(), format!("event,direction,{columns}"));
    let last = events.lines().last().unwrap();
    assert!(last.starts_with("low,rising,") && events.contains("\n\"turning point, of the \"\"nutation\"\"\",rising,"));
    // The last row is that of the terminal event.
    let state = last.strip_prefix("low,rising,").unwrap();
    assert!(rows.lines().last().unwrap().starts_with(state), "{state}");
    assert!(fs::read_to_string(here.join("t.svg")).unwrap().contains("tolerance 1e-10"));
    // On standard output the rows are alone.
    let output = run(&here, &["integrate", "top.toml"]);
    assert_eq!((code(&output), stdout(&output)), (0, &*rows));
    output.says("low").says("standard output: ");
    // To the horizon.
    file(&here, "whole.toml", &[("terminal = true", "")]);
    run(&here, &["integrate", "whole.toml", "--out", "t.csv"]).prints("t.csv: 25 rows; ended at t = 12: ");
    // An error of a formula: the rows are kept.
    file(&here, "bad.toml", &[("g_33 - 7/10", "log(g_33 - 7/10)")]);
    run(&here, &["integrate", "bad.toml", "--out", "t.csv"])
        .ends(1)
        .says("the event \"low\" has no value at t =  ¦ the logarithm of - ¦ kept in t.csv: the ");
    assert!(fs::read_to_string(here.join("t.csv")).unwrap().lines().count() > 1);
}

/// About a light axis rounding of a momentum of 1 is 10⁻¹⁶/I₁ of the velocity: the run ends, and the report says so.
#[test]
fn an_error_above_the_tolerance_is_reported() {
    let here = directory("tolerance-light");
    let run_and_output = "tolerance = 1e-8\nhorizon = 10\n[output]\nevery = 1000000";
    let text =
        system("so3", "inertia = [1e-8, 1, 1]", "retraction = \"exp\"", "velocity = [3, 1, 0.5]", run_and_output);
    fs::write(here.join("light.toml"), text).unwrap();
    run(&here, &["integrate", "light.toml", "--out", "t.csv"]).ends(0).prints("more than the tolerance");
}

#[test]
fn a_tolerance_is_that_of_the_scalar_and_files_are_opened_first() {
    let here = directory("tolerance-options");
    file(&here, "top.toml", &[]);
    // The scalar of the command counts.
    file(&here, "fine.toml", &[("1e-10", "1e-20")]);
    run(&here, &["integrate", "fine.toml"]).ends(2).says("at least 1e-14 in 16 digits").says("    ^");
    run(&here, &["integrate", "fine.toml", "--scalar", "dd"]).ends(0);
    // Nothing is overwritten where not all files can be.
    fs::write(here.join("kept.csv"), "rows\n").unwrap();
    for other in [["--events", "nowhere/e.csv"], ["--plot", "nowhere/p.svg"]] {
        run(&here, &[&["integrate", "top.toml", "--out", "kept.csv"][..], &other].concat()).ends(2).says("nowhere");
        assert_eq!(fs::read_to_string(here.join("kept.csv")).unwrap(), "rows\n");
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_keeps_its_rows_and_events() {
    let here = directory("tolerance-interrupted");
    let long = [("horizon = 12", "horizon = 1e7"), ("coefficient = \"1/100\"", "coefficient = 0")];
    file(&here, "top.toml", &[&long[..], &[("terminal = true", ""), ("save_every = \"1/2\"", "every = 4")]].concat());
    for signal in ["-INT", "-TERM"] {
        let arguments = ["integrate", "top.toml", "--out", "t.csv", "--events", "e.csv"];
        let mut child = started(&here, &arguments);
        let size = |name: &str| fs::metadata(here.join(name)).map_or(0, |file| file.len());
        wait_for(|| {
            assert!(child.try_wait().unwrap().is_none());
            size("t.csv.part") > 0 && size("e.csv.part") > 1000
        });
        let output = stopped(child, signal).ends(130);
        let [rows, events] = ["t.csv", "e.csv"].map(|name| fs::read_to_string(here.join(name)).unwrap());
        assert!(rows.lines().count() > 2 && events.lines().count() > 2 && events.ends_with('\n'), "{events}");
        let said = format!("kept in t.csv: the {} rows up to there", whole_rows(&here.join("t.csv")));
        assert!(stderr(&output).starts_with("INTERRUPTED after ") && stderr(&output).contains(&said));
        output.prints("rising").prints(" more\n");
        // The last row is of the state that was reached.
        let time = rows.lines().last().unwrap().split(',').next().unwrap();
        output.says(&format!("steps, at t = {time}; "));
    }
}

#[cfg(unix)]
#[test]
fn rows_are_in_the_file_before_the_buffer_is_full() {
    let here = directory("tolerance-rows");
    fs::write(here.join("system.toml"), stdout(&run(&here, &["integrate", "--example"]))).unwrap();
    let arguments = ["integrate", "system.toml", "--steps", "1000000000", "--every", "1000000000", "--out", "t.csv"];
    let mut child = command(&here, &arguments).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    wait_for(|| fs::read_to_string(here.join("t.csv.part")).is_ok_and(|rows| rows.lines().count() == 2));
    child.kill().unwrap();
    child.wait().unwrap();
}
