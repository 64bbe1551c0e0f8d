//! What the commands print on a terminal of 80, 100 and 160 columns: every line fits, and every number is whole.

use super::probe::{steppers, with_python};
use super::{FAULT, LAW, directory, flat, has_all, replay_file, run, stdout, typed, words};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{Winsize, tcsetwinsize};
use serde_json::Value;
use std::collections::BTreeSet;
use std::fs::{self, File, OpenOptions};
use std::io::Read;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use unicode_width::UnicodeWidthStr;

const WIDTHS: [u16; 3] = [80, 100, 160];

/// Wide enough for everything that is not prose.
const WIDE: u16 = 400;

/// The exit code of the command, and what it writes on a terminal of a given width: without colours.
fn on_a_terminal(columns: u16, here: &Path, arguments: &[&str]) -> (i32, String) {
    let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY;
    let master = openpt(flags).unwrap();
    grantpt(&master).unwrap();
    unlockpt(&master).unwrap();
    let name = ptsname(&master, Vec::new()).unwrap();
    let path = PathBuf::from(std::ffi::OsStr::from_bytes(name.to_bytes()));
    let mut options = OpenOptions::new();
    let terminal = options.read(true).write(true).custom_flags(flags.bits() as i32 & !2).open(path).unwrap();
    tcsetwinsize(&terminal, Winsize { ws_row: 50, ws_col: columns, ws_xpixel: 0, ws_ypixel: 0 }).unwrap();
    let mut command = Command::new(env!("CARGO_BIN_EXE_euler-poincare"));
    command.args(arguments).current_dir(here).env_remove("COLUMNS").env("TERM", "xterm");
    command.stdin(Stdio::null()).stdout(terminal.try_clone().unwrap()).stderr(terminal);
    let mut child = command.spawn().unwrap();
    // The command holds the terminal too: without it, reading ends with the child.
    drop(command);
    let mut bytes = Vec::new();
    // The end is an error on Linux; the bytes before it are kept.
    let _ = File::from(master).read_to_end(&mut bytes);
    let code = child.wait().unwrap().code().unwrap();
    (code, plain(&String::from_utf8(bytes).unwrap()))
}

/// Without colours, and with what is written last where a line is written over.
fn plain(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text.chars().peekable();
    while let Some(c) = rest.next() {
        match c {
            '\u{1b}' => drop(rest.by_ref().find(|c| c.is_ascii_alphabetic())),
            '\r' if rest.peek() != Some(&'\n') => out.truncate(out.rfind('\n').map_or(0, |end| end + 1)),
            '\r' => {}
            c => out.push(c),
        }
    }
    out
}

fn assert_fits(columns: u16, arguments: &[&str], text: &str) {
    let wide = text.lines().find(|line| line.width() > usize::from(columns));
    assert!(wide.is_none(), "{arguments:?} on {columns} columns: {} is\n{}", wide.unwrap().width(), wide.unwrap());
    assert!(!text.trim().is_empty(), "{arguments:?}");
}

/// What fits a terminal of this width, with this exit code.
fn fitting(columns: u16, here: &Path, arguments: &[&str], expected: i32) -> String {
    let (code, text) = on_a_terminal(columns, here, arguments);
    assert_eq!(code, expected, "{arguments:?}: {text}");
    assert_fits(columns, arguments, &text);
    text
}

/// The words that are digits, points, signs and exponents.
fn numbers(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| c.is_whitespace() || "[](){},;:".contains(c));
    let digits = |word: &&str| word.chars().all(|c| c.is_ascii_digit() || "+-.e".contains(c));
    words
        .filter(digits)
        .map(|word| word.trim_end_matches('.'))
        .filter(|word| word.contains(|c: char| c.is_ascii_digit()))
}

/// Without what is said of columns that are not shown: there the width stands that all of them need.
fn without_notes(text: &str) -> String {
    let mut parts = text.split("Columns not shown: ");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |kept, part| kept + part.split_once("all)").unwrap().1)
}

/// Prints on terminals of all widths; every number of a narrow one is on the wide one too, but for those with a point and
/// without an exponent, which may be times.
fn assert_whole(here: &Path, arguments: &[&str], expected: i32) -> Vec<String> {
    let (code, wide) = on_a_terminal(WIDE, here, arguments);
    assert_eq!(code, expected, "{arguments:?}: {wide}");
    let known: BTreeSet<&str> = numbers(&wide).collect();
    let print = |columns: u16| {
        let text = fitting(columns, here, arguments, expected);
        for number in numbers(&without_notes(&text)) {
            assert!(number.parse::<f64>().is_ok(), "{arguments:?} on {columns} columns: {number} in\n{text}");
            let time = number.contains('.') && !number.contains('e');
            assert!(time || known.contains(number), "{arguments:?} on {columns} columns: {number} in\n{text}");
        }
        text
    };
    WIDTHS.map(print).into()
}

#[test]
fn verify_prints_whole_numbers_and_the_verdict_first_and_last() {
    let here = directory("terminal-verify");
    let laws = "retraction-adjoint,units-carry-forced-euler-poincare,forced-hamiltonian-partials";
    let verify = format!("verify --laws {laws} --cases 20 --verbose");
    let (arguments, output) = (words(&verify), typed(&here, &format!("{verify} --format json")));
    let objects: Vec<Value> = stdout(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(objects.len(), 3);
    for columns in WIDTHS {
        let text = fitting(columns, &here, &arguments, 0);
        let (first, last) = (text.lines().next().unwrap(), text.lines().last().unwrap());
        assert!(first == last && first.starts_with("NOTHING BROKEN: 3 laws"), "{text}");
        let words = text.split_whitespace().collect::<Vec<_>>().join(" ");
        has_all(&words, "euler-poincare laws ¦ report DIR ¦ unit round-off");
        for object in &objects {
            let name = object["law"].as_str().unwrap();
            let row = text.lines().find(|line| line.starts_with(&format!("{name} "))).unwrap();
            let count = |key: &str| object[key].to_string();
            let number = |key: &str| object[key].as_f64().unwrap();
            let (defect, bound) = (number("max_defect"), number("bound"));
            let mut cells = vec![name.to_owned()];
            cells.extend(["cases", "held", "broken", "inconclusive", "not_applicable"].map(count));
            cells.extend([defect / bound, defect, bound].map(|number| format!("{number:.1e}")));
            let found: Vec<&str> = row.split_whitespace().collect();
            // Times are of different widths: the column may fit, or not.
            let shown = match columns {
                80 => 7..=7,
                100 => 9..=10,
                _ => 11..=11,
            };
            assert!(shown.contains(&found.len()), "{text}");
            for (found, expected) in found.iter().zip(&cells) {
                assert_eq!(found, expected, "{text}");
            }
            assert!(found.iter().skip(9).all(|time| time.parse::<f64>().is_ok()), "{row}");
        }
        assert_eq!(text.contains("Columns not shown: "), columns < 160, "{text}");
    }
    // A broken law: its case and its numbers fit too.
    let arguments = ["verify", "--laws", LAW, "--cases", "20", "--plant", FAULT, "--verbose"];
    for columns in WIDTHS {
        let text = fitting(columns, &here, &arguments, 1);
        let (first, last) = (text.lines().next().unwrap(), text.lines().last().unwrap());
        assert!(first == last && first.starts_with(&format!("BROKEN: 1 of 1 law ({LAW})")), "{text}");
    }
}

#[test]
fn faults_are_printed_whole() {
    let here = directory("terminal-faults");
    for more in [&[][..], &["--sizes"]] {
        let laws = ["verify", "--faults", "--laws", "retraction-adjoint,forced-hamiltonian-partials"];
        for text in assert_whole(&here, &[&laws[..], more].concat(), 0) {
            let (first, last) = (text.lines().next().unwrap(), text.lines().last().unwrap());
            assert!(first == last && first.starts_with("ALL CAUGHT: "), "{text}");
            assert_eq!(text.contains("smallest"), !more.is_empty(), "{text}");
        }
    }
}

#[test]
fn a_run_with_a_tolerance_is_printed_whole() {
    let here = directory("terminal-tolerance");
    let example = stdout(&run(&here, &["integrate", "--example"])).replacen("step = \"1/8\"", "tolerance = 1e-10", 1);
    let event =
        "name = \"the first momentum has come down to a quarter of what it is about the axis of the largest inertia\"";
    let events = format!("\n[[event]]\nformula = \"mu_1 - 1/4\"\n{event}\n[[event]]\nformula = \"t - 1/3\"\n");
    fs::write(here.join("system.toml"), example + &events).unwrap();
    for columns in WIDTHS {
        for more in [&[][..], &["--out", "t.csv"]] {
            let arguments = [&["integrate", "system.toml"], more].concat();
            let (code, text) = on_a_terminal(columns, &here, &arguments);
            let report = text.lines().skip_while(|line| line.contains(',') && !line.contains(' ')).collect::<Vec<_>>();
            assert_eq!(code, 0, "{text}");
            assert_fits(columns, &arguments, &report.join("\n"));
            let words = flat(&report.join(" "));
            assert!(words.contains("ended at t = 1: ") && words.contains(" pairs refused, "), "{text}");
        }
    }
}

/// A first screen: with the line that was typed, and the prompt after it.
const SCREEN: usize = 24 - 2;

#[test]
fn first_screens_fit_a_terminal_of_24_lines() {
    let here = directory("terminal-screen");
    let wrong = "while read line; do echo '{\"mu\": [1, 2, 3], \"g\": [1, 0, 0, 0, 1, 0, 0, 0, 1]}'; done";
    let screens: [(&[&str], i32, &str); 6] = [
        (&[], 0, "Forced variational integrators on Lie groups"),
        (&["verify", "--laws", "retraction-*", "--cases", "20"], 0, "NOTHING BROKEN: 7 laws checked"),
        (&["verify", "--laws", LAW, "--cases", "20", "--plant", FAULT], 1, "BROKEN: 1 of 1 law"),
        (&["order", "--tableau", "rk4"], 0, "verdict    confirmed: the order is 4"),
        (&["order", "--tableau", "ralston3"], 0, "verdict    confirmed: the order is 2"),
        (
            &["probe", "--algebras", "so3", "--cases", "2", "--shrink", "0", "--", "sh", "-c", wrong],
            1,
            "BROKEN (method-",
        ),
    ];
    for (arguments, expected, starts) in screens {
        for columns in WIDTHS {
            let text = fitting(columns, &here, arguments, expected);
            assert!(text.starts_with(starts), "{arguments:?}: {text}");
            let lines = text.lines().count();
            assert!(lines <= SCREEN, "{arguments:?} on {columns} columns: {lines} lines\n{text}");
        }
    }
}

#[test]
fn a_probe_is_printed_whole() {
    let Some(here) = with_python("a_probe_is_printed_whole") else { return };
    let stepper = steppers("rk4.py");
    let arguments = ["probe", "--laws", "method-order", "--cases", "3", "--order", "4", "--", "python3", &stepper];
    for columns in WIDTHS {
        let (code, text) = on_a_terminal(columns, &here, &arguments);
        assert!([0, 3].contains(&code), "{text}");
        assert_fits(columns, &arguments, &text);
    }
}

#[test]
fn cases_orders_lists_and_helps_fit() {
    let here = directory("terminal-others");
    for fault in [None, Some(FAULT)] {
        replay_file(&here.join("case.json"), LAW, fault, "name = \"so3\"");
        let _ = assert_whole(&here, &["replay", "case.json"], i32::from(fault.is_some()));
    }
    for printed in ["laws", "order --tableau rk4", "order --tableau rk4 -v"] {
        let _ = assert_whole(&here, &words(printed), 0);
    }
    let example = run(&here, &["integrate", "--example"]);
    fs::write(here.join("system.toml"), stdout(&example)).unwrap();
    let _ = assert_whole(&here, &["integrate", "system.toml", "--out", "t.csv"], 0);
    fs::write(here.join("wrong.toml"), stdout(&example).replace("horizon = 1 ", "horizon = -1 ")).unwrap();
    let _ = assert_whole(&here, &["integrate", "wrong.toml"], 2);
    for part in [0, 1] {
        typed(&here, &format!("verify --laws {LAW} --cases 10 --shard {part}/2 --out part{part}")).ends(0);
    }
    for columns in WIDTHS {
        let commands = ["verify", "merge", "replay", "report", "laws", "probe", "order", "paper", "integrate"];
        let helps = commands.map(|command| format!("; {command} --help")).concat();
        let whole = format!("whole{columns}");
        let right = format!("merge part0 part1 --out {whole}; report {whole}; integrate --example; --help{helps}");
        right.split("; ").for_each(|text| drop(fitting(columns, &here, &words(text), 0)));
        let wrong = "verify --laws no-such-law; verify --plant no-such-fault; verify --cases 0; replay missing.json; merge part0 --out nowhere";
        wrong.split("; ").for_each(|text| drop(fitting(columns, &here, &words(text), 2)));
    }
}
