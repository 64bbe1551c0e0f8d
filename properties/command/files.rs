//! Properties of the files that the command writes: what was there stays until the new one is whole, and what is reported is there.

use super::{
    Ended, FAULT, LAW, code, command, directory, ended, run, started, stderr, stdout, stopped, system, typed, wait_for,
    whole_rows, words,
};
use euler_poincare::file::Output;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

/// What is in a file before.
const OLD: &str = "old\n";

/// A directory with the example, a campaign, states of an ensemble and a system with an event.
fn prepared(test: &str) -> std::path::PathBuf {
    let here = directory(test);
    let example = stdout(&run(&here, &["integrate", "--example"])).to_owned();
    fs::write(here.join("system.toml"), &example).unwrap();
    fs::write(here.join("states.csv"), format!("mu_1,mu_2,mu_3\n{}", "1,2,3\n".repeat(2000))).unwrap();
    let events =
        format!("{}\n[[event]]\nname = \"crossing\"\nformula = \"mu_2\"\n", body("tolerance = 1e-6\nhorizon = 20"));
    fs::write(here.join("events.toml"), events).unwrap();
    run(&here, &["verify", "--laws", LAW, "--cases", "3", "--plant", FAULT, "--out", "campaign"]).ends(1);
    here
}

/// A body that tumbles.
fn body(run: &str) -> String {
    let method = "tableau = \"gauss-2\"\nretraction = \"exp\"";
    system("so3", "inertia = [1, 2, 3]", method, "velocity = [\"1/10\", 1, \"1/10\"]", run)
}

/// A command line, and a file that it writes.
type Writes = (&'static str, &'static str);

/// Every sub-command that writes a file, but for the directories of campaigns and the saved cases.
const WRITES: [Writes; 9] = [
    ("integrate system.toml --steps 40000 --out t.csv", "t.csv"),
    ("integrate system.toml --plot t.svg --out t.csv", "t.svg"),
    ("integrate events.toml --events e.csv --out t.csv", "e.csv"),
    ("integrate system.toml --ensemble states.csv --out t.csv", "t.csv"),
    ("order --tableau heun2 --digits 16 --plot work.svg", "work.svg"),
    ("report campaign --plots 0", "campaign/report.html"),
    ("paper --out .", "errors.csv"),
    ("verify --laws retraction-adjoint --faults --out .", "faults.jsonl"),
    ("man --out .", "euler-poincare.1"),
];

/// Nothing that is not whole is left.
fn no_parts(here: &Path) -> bool {
    fs::read_dir(here).unwrap().all(|file| !file.unwrap().file_name().to_string_lossy().ends_with(".part"))
}

/// Puts the old text where the command may find some; faults have other rules for what is there.
fn put_old(here: &Path, file: &str) -> bool {
    let replaced = file != "faults.jsonl";
    if replaced {
        fs::write(here.join(file), OLD).unwrap();
    }
    replaced
}

#[test]
fn a_second_writer_is_told() {
    let here = prepared("two-writers");
    for (text, file) in WRITES {
        let old = put_old(&here, file);
        // The first writer is this test.
        let first = Output::create(&here.join(file)).unwrap();
        typed(&here, text).ends(2).says(&format!("another run is writing there ¦ {file}"));
        assert!(!old || fs::read_to_string(here.join(file)).unwrap() == OLD, "{text}");
        drop(first);
        assert!(no_parts(&here), "{text}");
    }
}

#[cfg(unix)]
#[test]
fn of_two_integrations_the_first_is_whole() {
    let here = prepared("two-integrations");
    std::os::unix::fs::symlink("t.csv", here.join("link.csv")).unwrap();
    for signal in ["-INT", "-TERM"] {
        fs::write(here.join("t.csv"), OLD).unwrap();
        let first = started(&here, &words("integrate system.toml --steps 1000000000 --every 10 --out t.csv"));
        wait_for(|| fs::metadata(here.join("t.csv.part")).is_ok_and(|file| file.len() > 1 << 16));
        for name in ["t.csv", "./t.csv", "link.csv"] {
            let said = format!("{name}: another run is writing there");
            typed(&here, &format!("integrate system.toml --out {name}")).refuses(&said);
        }
        assert_eq!(fs::read_to_string(here.join("t.csv")).unwrap(), OLD);
        let first = stopped(first, signal).ends(130);
        let rows = whole_rows(&here.join("t.csv"));
        let said = format!("of 1000000000 steps; kept in t.csv: the {rows} rows up to there");
        assert!(stderr(&first).starts_with("INTERRUPTED after ") && stderr(&first).contains(&said), "{first}");
    }
    // Afterwards the file is free, and the link stays one.
    typed(&here, "integrate system.toml --out link.csv").ends(0);
    assert!(fs::symlink_metadata(here.join("link.csv")).unwrap().is_symlink() && no_parts(&here));
    assert_eq!(fs::read_to_string(here.join("t.csv")).unwrap(), stdout(&run(&here, &["integrate", "system.toml"])));
}

/// The command with files of at most a number of blocks of 512 bytes: what a full disk does to a file, without a disk.
#[cfg(unix)]
fn limited(here: &Path, blocks: u32, text: &str) -> Ended {
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" \"$@\"");
    let mut shell = Command::new("sh");
    shell.args(["-c", &script, env!("CARGO_BIN_EXE_euler-poincare")]).args(words(text));
    shell.current_dir(here).stdin(Stdio::null());
    Ended::of(&mut shell)
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_what_was_there() {
    let here = prepared("full-disk");
    for (text, file) in WRITES {
        let old = put_old(&here, file);
        limited(&here, 0, text).ends(2).says("File too large");
        assert_eq!(fs::read_to_string(here.join(file)).ok().as_deref(), old.then_some(OLD), "{text}");
        fs::read_dir(&here).unwrap().map(|file| file.unwrap().path()).for_each(|path| {
            if path.extension().is_some_and(|ending| ending == "part") {
                fs::remove_file(path).unwrap();
            }
        });
    }
}

#[cfg(unix)]
#[test]
fn rows_that_a_full_disk_holds_are_kept_and_counted() {
    let here = prepared("full-rows");
    for (text, file) in [WRITES[0], WRITES[3]] {
        fs::write(here.join(file), OLD).unwrap();
        let output = limited(&here, 200, text).ends(2);
        let rows = whole_rows(&here.join("t.csv.part"));
        assert!(rows >= 100, "{rows} rows: {output}");
        output.says(&format!("what was there is unchanged, the first {rows} rows are in "));
        assert_eq!(fs::read_to_string(here.join(file)).unwrap(), OLD, "{output}");
    }
}

#[cfg(unix)]
#[test]
fn a_killed_run_leaves_what_was_there() {
    let here = prepared("killed-run");
    for (text, file) in [
        ("integrate system.toml --steps 1000000000 --out t.csv", "t.csv"),
        ("order --tableau gauss-8 --plot work.svg", "work.svg"),
        ("report campaign --plots 100", "campaign/report.html"),
        ("paper --out .", "errors.csv"),
    ] {
        fs::write(here.join(file), OLD).unwrap();
        let part = here.join(format!("{file}.part"));
        let mut child = command(&here, &words(text)).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let rows = file == "t.csv";
        // A short run may be over before it is killed: then the new file is whole.
        wait_for(|| {
            let there = fs::metadata(&part).is_ok_and(|part| !rows || part.len() > 1 << 18);
            there || child.try_wait().unwrap().is_some()
        });
        child.kill().unwrap();
        child.wait().unwrap();
        let kept = fs::read_to_string(here.join(file)).unwrap();
        assert!(kept == OLD || (!rows && kept.trim_end().ends_with('>')), "{text}: {kept:.100}");
        assert!(!rows || fs::read_to_string(&part).unwrap().lines().count() > 100);
    }
    // What is left of it is in nobody's way.
    typed(&here, "integrate system.toml --out t.csv").ends(0);
    assert!(!here.join("t.csv.part").exists());
    assert_eq!(fs::read_to_string(here.join("t.csv")).unwrap(), stdout(&run(&here, &["integrate", "system.toml"])));
}

/// Paths at which no file can be. (Rights do not bind the superuser, whom tests may run as; a device's directory does.)
#[test]
fn a_path_that_cannot_be_written_is_named_before_the_run() {
    let here = prepared("unwritable");
    fs::create_dir(here.join("folder")).unwrap();
    fs::write(here.join("file"), OLD).unwrap();
    for bad in ["nowhere/x", "file/x", "folder"] {
        let report = ("report campaign --output page", "page");
        for (text, file) in WRITES.into_iter().take(5).chain([report]) {
            typed(&here, &text.replace(file, bad)).ends(2).says(&format!("{bad}: "));
        }
    }
    for text in
        ["paper --out file", "man --out file", "man --out file/x", "verify --laws retraction-adjoint --out file"]
    {
        typed(&here, text).ends(2).says("file");
    }
    assert_eq!(fs::read_to_string(here.join("file")).unwrap(), OLD);
    assert!(no_parts(&here) && fs::read_dir(here.join("folder")).unwrap().next().is_none());
}

#[cfg(unix)]
#[test]
fn a_read_only_folder_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let here = prepared("read-only");
    let folder = here.join("folder");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("t.csv"), OLD).unwrap();
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o555)).unwrap();
    // The superuser writes there all the same.
    let bound = fs::write(folder.join("probe"), "").is_err();
    let output = typed(&here, "integrate system.toml --out folder/t.csv");
    if bound {
        output.ends(2).says("folder/t.csv: cannot write ");
        assert_eq!(fs::read_to_string(folder.join("t.csv")).unwrap(), OLD);
    }
    fs::set_permissions(&folder, fs::Permissions::from_mode(0o755)).unwrap();
}

/// What is said beside notes: that no rigid body has the inertia of the system's file is one.
fn beside_notes(output: &std::process::Output) -> String {
    stderr(output).lines().filter(|line| !line.starts_with("note: ")).collect()
}

/// A run of whose standard output nobody reads a byte: it succeeds, and says notes alone.
#[cfg(unix)]
fn quiet_unread(here: &Path, text: &str) {
    let mut child = started(here, &words(text));
    drop(child.stdout.take());
    let output = ended(child);
    assert_eq!((code(&output), beside_notes(&output)), (0, String::new()), "{text}");
}

#[cfg(unix)]
#[test]
fn a_closed_pipe_ends_quietly() {
    let here = prepared("closed-pipe");
    for (text, file) in WRITES {
        put_old(&here, file);
        quiet_unread(&here, text);
        // What was to be written is written.
        assert!(fs::read_to_string(here.join(file)).unwrap().len() > OLD.len(), "{text}");
    }
    let others = format!(
        "integrate system.toml --steps 100000; integrate system.toml --steps 100000 --out /dev/stdout; \
         integrate system.toml --ensemble states.csv; report campaign --output -; laws; verify --laws {LAW} --cases 5"
    );
    others.split("; ").for_each(|text| quiet_unread(&here, text));
}

#[cfg(target_os = "linux")]
#[test]
fn streams_and_pipes_are_written_as_they_are() {
    let here = prepared("streams");
    let rows = stdout(&run(&here, &["integrate", "system.toml"])).to_owned();
    for name in ["-", "/dev/stdout"] {
        let text = format!("integrate system.toml --out {name}");
        let output = typed(&here, &text).ends(0);
        assert_eq!((stdout(&output), beside_notes(&output)), (rows.as_str(), String::new()), "{name}");
        // Behind what is there already.
        let log = fs::File::create(here.join("log")).unwrap();
        assert!(command(&here, &words(&text)).stdout(log).status().unwrap().success());
        assert_eq!(fs::read_to_string(here.join("log")).unwrap(), rows, "{name}");
    }
    let page = typed(&here, "report campaign --plots 0 --output /dev/stdout");
    assert!(stdout(&page).starts_with("<!DOCTYPE html>") && stdout(&page).ends_with("/dev/stdout\n"));
    // A named pipe, and a link to nothing.
    assert!(Command::new("mkfifo").arg(here.join("pipe")).status().unwrap().success());
    let reader = Command::new("cat").arg(here.join("pipe")).stdout(Stdio::piped()).spawn().unwrap();
    typed(&here, "integrate system.toml --out pipe").ends(0);
    assert_eq!(stdout(&ended(reader)), rows);
    std::os::unix::fs::symlink("there.csv", here.join("link.csv")).unwrap();
    typed(&here, "integrate system.toml --out link.csv").ends(0);
    assert_eq!(fs::read_to_string(here.join("there.csv")).unwrap(), rows);
    typed(&here, "integrate system.toml --out /dev/full").ends(2).says("/dev/full: No space left");
    assert!(no_parts(&here));
}

#[test]
fn a_figure_has_the_ending_of_its_format() {
    let here = prepared("endings");
    for text in
        ["integrate system.toml --plot x.png", "order --tableau rk4 --plot x.pdf", "integrate system.toml --plot x.csv"]
    {
        typed(&here, text).ends(2).says("figures are SVG: the name of the file ends in .svg");
    }
    fs::write(here.join("png.toml"), format!("{}[output]\nsvg = \"x.png\"\n", body("step = 1\nsteps = 1"))).unwrap();
    run(&here, &["integrate", "png.toml"]).ends(2).says("line 15, column 7: output.svg");
    for name in ["x.SVG", "x"] {
        typed(&here, &format!("integrate system.toml --out t.csv --plot {name}")).ends(0);
        assert!(fs::read_to_string(here.join(name)).unwrap().contains("</svg>"));
    }
}

/// Names from files are printed without the power over a terminal that their characters have.
#[test]
fn control_characters_are_spelled() {
    let here = directory("control");
    let tableau = "name = \"a\\u001b]0;owned\\u0007\\u009b2Jb\"\na = [[\"1/2\"]]\nb = [1]\n";
    fs::write(here.join("t.toml"), tableau).unwrap();
    fs::write(here.join("\u{9b}.toml"), tableau).unwrap();
    let system = body("tolerance = 1e-6\nhorizon = 20");
    let event = "[[event]]\nname = \"x\\u001b[31m\"\nformula = \"mu_2\"\n";
    fs::write(here.join("events.toml"), format!("{system}{event}")).unwrap();
    fs::write(here.join("raw.toml"), system.replace("gauss-2", "gauss-\u{1b}[2J")).unwrap();
    fs::write(here.join("states.csv"), "mu_1,mu_2,mu_3,\u{1b}[2J\n1,2,3,4\n").unwrap();
    fs::write(here.join("fixed.toml"), body("step = 1\nsteps = 1")).unwrap();
    let json = "order --tableau \u{9b}.toml --digits 16 --format json";
    for (text, spelled) in [
        ("order --tableau t.toml --digits 16", "\\u001b]0;owned\\u0007\\u009b2Jb"),
        (json, "\"tableau\":\"\\u009b.toml\""),
        ("integrate events.toml --out t.csv", "x\\u001b[31m"),
        ("integrate raw.toml", "gauss-\\u001b[2J"),
        ("integrate fixed.toml --ensemble states.csv", "[2J"),
    ] {
        let said = typed(&here, text).to_string();
        assert!(said.contains(spelled), "{text}: {said}");
        assert!(!said.contains(|c: char| c.is_control() && c != '\n' && c != '\t'), "{text}: {said:?}");
    }
    // JSON has the same value.
    let json = typed(&here, json);
    let found: serde_json::Value = serde_json::from_str(stdout(&json)).unwrap();
    assert_eq!(found["tableau"], "\u{9b}.toml");
}

#[test]
fn what_is_no_utf_8_has_its_place() {
    let here = prepared("utf8");
    let bad = |name: &str, before: &str| fs::write(here.join(name), [before.as_bytes(), b"\xe9"].concat()).unwrap();
    bad("bad.toml", "format = 1\n# caf");
    bad("tableau.toml", "a = [[0]]\n# caf");
    bad("states.csv", "mu_1,mu_2,mu_3\n1,2,");
    bad("case.json", "{\n  \"");
    bad("campaign/campaign.json", "{\n");
    for (text, place) in [
        ("integrate bad.toml", "bad.toml: line 2, byte 6: 0xe9 is not valid UTF-8"),
        ("order --tableau rk4 --system bad.toml", "bad.toml: line 2, byte 6: 0xe9"),
        ("order --tableau tableau.toml", "tableau.toml: line 2, byte 6: 0xe9"),
        ("integrate system.toml --ensemble states.csv", "states.csv: line 2: byte 1 of field 3"),
        ("replay case.json", "case.json: line 2, byte 4: 0xe9"),
        ("probe --system bad.toml -- true", "bad.toml: line 2, byte 6: 0xe9"),
        ("probe --replay case.json", "case.json: line 2, byte 4: 0xe9"),
        ("report campaign", "line 2, byte 1: 0xe9"),
    ] {
        typed(&here, text).ends(2).says(place);
    }
}
