//! Properties of the command: exit codes, formats, determinism, saved cases.

mod probe;

#[path = "command/campaign.rs"]
mod campaign;
#[path = "command/ensemble.rs"]
mod ensemble;
#[path = "command/files.rs"]
mod files;
#[path = "command/notes.rs"]
mod notes;
#[path = "command/order.rs"]
mod order;
#[path = "command/page.rs"]
mod page;
#[path = "command/probe_page.rs"]
mod probe_page;
#[path = "command/schemas.rs"]
mod schemas;
#[path = "command/shell.rs"]
mod shell;
#[path = "command/tableau.rs"]
mod tableau;
#[cfg(unix)]
#[path = "command/terminal.rs"]
mod terminal;
#[path = "command/tolerance.rs"]
mod tolerance;

use ensemble::Table;
use euler_poincare::study::problem;
use euler_poincare::system::{Case, Replay};
use serde_json::Value;
use std::fmt::{self, Display, Formatter};
use std::fs;
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};
use unicode_width::UnicodeWidthStr;

/// A cheap law with one fault; the others are judged elsewhere.
const LAW: &str = "retraction-adjoint";
const FAULT: &str = "adjoint-inverted";

/// A cheap law, and the seed of a campaign whose first case it says nothing about.
const NO_VERDICT: &str = "free-casimirs";
const NO_VERDICT_SEED: &str = "6";

/// An empty directory of this test, to run in.
fn directory(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("command").join(test);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

fn command(directory: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_euler-poincare"));
    command.args(arguments).current_dir(directory).stdin(Stdio::null());
    command
}

fn run(directory: &Path, arguments: &[&str]) -> Ended {
    Ended::of(&mut command(directory, arguments))
}

/// A run that is over. What fails of its checks says what was typed, and all that was printed.
struct Ended {
    typed: String,
    output: Output,
}

impl Deref for Ended {
    type Target = Output;

    fn deref(&self) -> &Output {
        &self.output
    }
}

impl Display for Ended {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { typed, output } = self;
        write!(f, "{typed}: {}\nstandard output: {}\nstandard error: {}", output.status, stdout(self), stderr(self))
    }
}

impl Ended {
    fn of(command: &mut Command) -> Self {
        Self { typed: format!("{command:?}"), output: command.output().unwrap() }
    }

    /// With this exit code.
    #[track_caller]
    fn ends(self, expected: i32) -> Self {
        assert_eq!(code(&self), expected, "{self}");
        self
    }

    /// These parts, with ` ¦ ` between them, are on standard output.
    #[track_caller]
    fn prints(&self, parts: &str) -> &Self {
        let missing = parts.split(" ¦ ").find(|part| !stdout(self).contains(part));
        assert_eq!(missing, None, "it is not on the standard output of {self}");
        self
    }

    /// These parts are on standard error.
    #[track_caller]
    fn says(&self, parts: &str) -> &Self {
        let missing = parts.split(" ¦ ").find(|part| !stderr(self).contains(part));
        assert_eq!(missing, None, "it is not on the standard error of {self}");
        self
    }

    /// Exit code 0, and nothing on standard error.
    #[track_caller]
    fn quiet(self) -> Self {
        assert_eq!((code(&self), stderr(&self)), (0, ""), "{self}");
        self
    }

    /// Exit code 2, nothing on standard output, and this on standard error.
    #[track_caller]
    fn refuses(&self, part: &str) -> &Self {
        assert_eq!((code(self), stdout(self)), (2, ""), "where {part:?} is expected: {self}");
        self.says(part)
    }
}

fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

/// The text with every run of white space as one space.
fn flat(text: &str) -> String {
    words(text).join(" ")
}

/// The command with these words.
fn typed(directory: &Path, text: &str) -> Ended {
    run(directory, &words(text))
}

/// The `count` rows of arguments and of what is said where they are refused, with ` | ` between them.
#[track_caller]
fn rows(table: &str, count: usize) -> impl Iterator<Item = (Vec<&str>, String)> {
    assert_eq!(table.lines().count(), count, "rows of:\n{table}");
    table.lines().map(|row| {
        let (words, said) = row.split_once(" | ").unwrap();
        (words.split(' ').map(|word| word.trim_matches('\'')).collect(), said.replace("\\n", "\n"))
    })
}

#[track_caller]
fn refuses_each(directory: &Path, table: &str, count: usize) {
    for (arguments, said) in rows(table, count) {
        run(directory, &arguments).refuses(&said);
    }
}

/// A run that goes on, with what it prints kept.
fn started(directory: &Path, arguments: &[&str]) -> Child {
    command(directory, arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
}

/// How many rows there are: all of them whole, with as many columns as the header.
#[track_caller]
fn whole_rows(file: &Path) -> usize {
    let rows = fs::read_to_string(file).unwrap();
    let columns = rows.lines().next().unwrap().split(',').count();
    assert!(rows.ends_with('\n') && rows.lines().all(|row| row.split(',').count() == columns));
    rows.lines().count() - 1
}

/// Sends a signal to a run, and waits for its end.
fn stopped(child: Child, signal: &str) -> Ended {
    assert!(Command::new("kill").args([signal, &child.id().to_string()]).status().unwrap().success());
    ended(child)
}

/// Waits until it is so, for a minute at most.
fn wait_for(mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < Duration::from_secs(60));
        sleep(Duration::from_millis(5));
    }
}

/// A run that was started before, when it is over.
fn ended(child: Child) -> Ended {
    Ended { typed: "the command".into(), output: child.wait_with_output().unwrap() }
}

/// All these parts, with ` ¦ ` between them, are in the text.
#[track_caller]
fn has_all(text: &str, parts: &str) {
    for part in parts.split(" ¦ ") {
        assert!(text.contains(part), "{part:?} is not in\n{text}");
    }
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn stdout(output: &Output) -> &str {
    std::str::from_utf8(&output.stdout).unwrap()
}

fn stderr(output: &Output) -> &str {
    std::str::from_utf8(&output.stderr).unwrap()
}

/// The lines of standard output as JSON, without what may differ between runs.
fn objects(output: &Output) -> Vec<Value> {
    let without_time = |line: &str| {
        let mut object: Value = serde_json::from_str(line).unwrap();
        assert!(object.as_object_mut().unwrap().remove("seconds").unwrap().as_f64().unwrap() >= 0.0);
        object
    };
    stdout(output).lines().map(without_time).collect()
}

/// A system file; forces stand behind the keys of the Lagrangian.
fn system(algebra: &str, lagrangian: &str, method: &str, state: &str, run: &str) -> String {
    format!(
        "format = 1\n[algebra]\nname = \"{algebra}\"\n[lagrangian]\n{lagrangian}\n[method]\n{method}\n[state]\n{state}\n[run]\n{run}\n"
    )
}

/// The generic problem with other tables instead of those from one heading up to another.
fn generic(from: &str, to: &str, instead: &str) -> String {
    let text = problem::generic_text();
    let (start, end) = (text.find(from).unwrap(), text.find(to).unwrap());
    [&text[..start], instead, &text[end..]].concat()
}

/// A saved case of `LAW` on an algebra of dimension 3.
fn replay_file(path: &Path, law: &str, fault: Option<&str>, algebra: &str) {
    let toml = format!(
        "format = 1\n[algebra]\n{algebra}\n[method]\ntableau = \"gauss-1\"\nretraction = \"exp\"\n\
         [state]\nvelocity = [1, 2, \"1/3\"]\n[run]\nstep = \"1/8\"\nsteps = 1\n"
    );
    fs::write(path, record(law, fault, Case::from_toml(&toml).unwrap()).to_json().unwrap()).unwrap();
}

fn record(law: &str, fault: Option<&str>, case: Case) -> Replay {
    Replay { module: None, law: law.into(), seed: 7, index: 4, fault: fault.map(Into::into), case }
}

#[test]
fn json_has_one_object_per_law() {
    let here = directory("json");
    let output = typed(&here, "verify --laws retraction-* --cases 30 --seed 3 --format json").quiet();
    // The keys are those that are documented (schemas.rs).
    let laws = objects(&output);
    for object in &laws {
        let count = |key: &str| object[key].as_u64().unwrap();
        let counts = ["held", "broken", "inconclusive", "not_applicable"].map(count);
        assert_eq!((count("cases"), counts.iter().sum()), (30, 30), "{object}");
        assert!(object["max_defect"].as_f64().unwrap() <= object["bound"].as_f64().unwrap(), "{object}");
        assert!(object["law"].as_str().unwrap().starts_with("retraction-"), "{object}");
    }
    assert!(laws.len() >= 5, "{laws:?}");
    assert!(fs::read_dir(&here).unwrap().next().is_none(), "nothing is written where nothing breaks");
}

#[test]
fn without_a_sub_command_there_are_three_things_to_try() {
    let here = directory("default");
    let output = run(&here, &[]).quiet();
    // Each of them runs, as it is typed.
    let commands = stdout(&output).lines().filter_map(|line| line.strip_prefix("       euler-poincare "));
    let commands: Vec<&str> = commands.collect();
    assert_eq!(commands.len(), 4, "{output}");
    for command in commands {
        let (words, file) = command.split_once(" > ").map_or((command, None), |(words, file)| (words, Some(file)));
        let words: Vec<&str> = words.split(' ').map(|word| word.trim_matches('\'')).collect();
        let output = run(&here, &words).ends(0);
        if let Some(file) = file {
            fs::write(here.join(file), stdout(&output)).unwrap();
        }
    }
    for file in ["top.csv", "top.svg"] {
        assert!(here.join(file).exists(), "{file}");
    }
    // Options of `verify` belong to it.
    run(&here, &["--cases", "5"]).ends(2);
}

/// The pages show what the command prints and draws.
#[test]
fn the_first_pages_show_the_example_as_it_is() {
    let here = directory("first-pages");
    let output = run(&here, &["integrate", "--example", "heavy-top"]);
    fs::write(here.join("top.toml"), stdout(&output)).unwrap();
    let page = include_str!("../src/guide/source/getting_started.md");
    assert!(
        page.contains(&format!("```toml\n{}```\n", stdout(&output))),
        "Getting started shows another heavy-top.toml"
    );
    run(&here, &["integrate", "top.toml", "--out", "top.csv", "--plot", "top.svg"]).ends(0);
    let [picture, drawn] =
        [Path::new(env!("CARGO_MANIFEST_DIR")).join("snapshots/heavy-top.svg"), here.join("top.svg")];
    let [picture, drawn] = [picture, drawn].map(|path| fs::read_to_string(path).unwrap());
    assert!(same_picture(&picture, &drawn), "snapshots/heavy-top.svg is not what the command draws");
    let readme = include_str!("../README.md");
    let first = readme.find("snapshots/heavy-top.svg").unwrap();
    let [integrate, verify] = ["integrate top.toml", "-- verify"].map(|command| readme.find(command).unwrap());
    assert!(first < integrate && integrate < verify, "the picture, then `integrate`, then `verify`");
}

/// Whether two figures are the same up to a pixel of their canvas, which rounding on another machine may move a point by.
fn same_picture(one: &str, other: &str) -> bool {
    let split = |c: char| !(c.is_ascii_digit() || c == '.');
    let numbers = |text: &str| -> Vec<f64> { text.split(split).filter_map(|word| word.parse().ok()).collect() };
    let words = |text: &str| -> String { text.chars().filter(|c| !(c.is_ascii_digit() || *c == '.')).collect() };
    let [a, b] = [numbers(one), numbers(other)];
    words(one) == words(other) && a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= 1.0)
}

#[test]
fn bad_usage_is_two_and_says_what_is_allowed() {
    let here = directory("usage");
    fs::write(here.join("text.json"), "no JSON").unwrap();
    fs::write(here.join("part.json"), "{\"law\": \"retraction-adjoint\", \"seed\": 1}").unwrap();
    replay_file(&here.join("sound.json"), LAW, None, "name = \"so3\"");
    let sound = fs::read_to_string(here.join("sound.json")).unwrap();
    fs::write(here.join("algebra.json"), sound.replace("so3", "so6")).unwrap();
    fs::write(here.join("step.json"), sound.replace("1/8", "0")).unwrap();
    replay_file(&here.join("law.json"), "no-such-law", None, "name = \"so3\"");
    replay_file(&here.join("fault.json"), LAW, Some("no-such-fault"), "name = \"so3\"");
    refuses_each(&here, include_str!("command/refused/usage.txt"), 24);
    run(&here, &["replay", "part.json"]).ends(2);
}

#[test]
fn a_broken_law_is_one_and_its_case_is_saved_and_reproduces() {
    let here = directory("broken");
    let output = typed(&here, &format!("verify --laws retraction --cases 20 --plant {FAULT} -v")).ends(1);
    let text = stdout(&output);
    let name = text.lines().find_map(|line| line.trim().strip_prefix("euler-poincare replay ")).unwrap();
    output.prints(&format!("BROKEN {LAW}"));
    let replayed = run(&here, &["replay", name]).ends(1);
    let parts = "Sato Martín de Almagro ¦ 16 digits ¦ 32 digits ¦ ABOVE the bound ¦ algebra     ¦ step       ";
    for said in [&output, &replayed] {
        said.prints(&format!("{LAW} ¦ {parts} ¦ euler-poincare replay {name}"));
    }
    let verdict = |text: &str| text.lines().find(|line| line.trim().starts_with("verdict")).unwrap().trim().to_owned();
    assert_eq!(verdict(stdout(&replayed)), verdict(text));
    assert!(verdict(text).contains("broken: defect"), "{text}");

    // Without the fault, the same case holds: it was the fault that was seen.
    let path = here.join(name);
    let mut saved: Value = serde_json::from_str(&fs::read_to_string(&path).unwrap()).unwrap();
    assert_eq!(saved.as_object_mut().unwrap().remove("fault"), Some(FAULT.into()));
    fs::write(&path, saved.to_string()).unwrap();
    let sound = run(&here, &["replay", name]).ends(0);
    assert!(verdict(stdout(&sound)).contains("holds: defect"), "{sound}");
}

#[test]
fn a_saved_case_is_shrunk_into_a_new_file() {
    let here = directory("shrunk");
    let toml = "format = 1\n[algebra]\nname = \"se3\"\n[[force]]\nkind = \"linear-drag\"\ncoefficient = \"1/8\"\n[method]\n\
                tableau = \"gauss-2\"\nretraction = \"cayley\"\n[state]\nmomentum = [1, 0, \"1/2\", 0, 1, 0]\n[run]\nstep = \"1/8\"\n";
    let case = Case::from_toml(toml).unwrap();
    let record = |fault| record(LAW, fault, case.clone());
    let path = here.join("case.json");
    fs::write(&path, record(Some(FAULT)).to_json().unwrap()).unwrap();
    run(&here, &["replay", "case.json", "--shrink"]).ends(1).prints("saved in case-smaller.json");
    let smaller = Replay::from_json(&fs::read_to_string(here.join("case-smaller.json")).unwrap()).unwrap();
    assert!(smaller.case.dimension() < 6 && smaller.case.forces.is_empty(), "{}", smaller.case);
    assert_eq!(Replay { case: case.clone(), ..smaller }, record(Some(FAULT)), "nothing but the case changes");
    run(&here, &["replay", "case-smaller.json"]).ends(1);
    // Never over a file that is there; and no file where there is nothing simpler, or nothing broken.
    run(&here, &["replay", "case.json", "--shrink"]).prints("saved in case-smaller-2.json");
    run(&here, &["replay", "case-smaller.json", "--shrink"]).ends(1).prints("none of ");
    fs::write(&path, record(None).to_json().unwrap()).unwrap();
    run(&here, &["replay", "case.json", "--shrink"]).ends(0).prints("nothing to shrink");
    assert_eq!(fs::read_dir(&here).unwrap().count(), 3);
}

#[test]
fn a_replay_by_one_precision_tells_that_one() {
    let here = directory("digits");
    for (fault, expected) in [(None, 0), (Some(FAULT), 1)] {
        replay_file(&here.join("case.json"), LAW, fault, "name = \"so3\"");
        for (digits, other) in [("16", "32"), ("32", "16")] {
            let output = run(&here, &["replay", "case.json", "--digits", digits]).ends(expected);
            let row = |digits: &str| stdout(&output).contains(&format!("{digits} digits "));
            assert!(row(digits) && !row(other), "{output}");
        }
    }
    // An order is measured in 32 digits; a trial measures it in 16.
    replay_file(
        &here.join("order.json"),
        "order-predicted",
        None,
        "name = \"so3\"\n[[force]]\nkind = \"linear-drag\"\ncoefficient = \"1/4\"",
    );
    for digits in ["16", "32"] {
        let output = run(&here, &["replay", "order.json", "--digits", digits]);
        assert!([0, 3].contains(&code(&output)), "{output}");
        output.prints(&format!("{digits} digits  momentum"));
    }
    // The work without attitude is measured in 32 digits alone.
    replay_file(&here.join("balance.json"), "energy-balance", None, "name = \"so3\"");
    run(&here, &["replay", "balance.json", "--digits", "16"]).ends(3).prints("measured in 32 digits alone");
}

#[test]
fn kept_cases_are_replayed_before_a_campaign() {
    let here = directory("kept");
    let kept = here.join("snapshots/regressions");
    fs::create_dir_all(&kept).unwrap();
    replay_file(&kept.join("sound.json"), LAW, None, "name = \"so3\"");
    replay_file(&kept.join("planted.json"), LAW, Some(FAULT), "name = \"so3\"");
    replay_file(&kept.join("other.json"), "retraction-inverse", None, "name = \"so3\"");
    let verify = |format: &str| run(&here, &["verify", "--laws", LAW, "--cases", "5", "--format", format]);
    verify("text").ends(0).prints("2 of 2 records in snapshots/regressions as expected");
    // One that cannot be read, and one whose fault is not seen, fail the run.
    fs::write(kept.join("garbage.json"), "{}").unwrap();
    verify("text").ends(1).prints("2 of 3 records").prints("garbage.json");
    let output = verify("json");
    assert_eq!((code(&output), stdout(&output).lines().count()), (1, 1));
    output.says("REGRESSION");
}

#[test]
fn a_replay_without_a_verdict_is_three() {
    let here = directory("undecided");
    // Heisenberg's: the adjoint representation has a kernel.
    let constants = "dimension = 3\nconstants = [[1, 2, 3, 1]]";
    replay_file(&here.join("constants.json"), LAW, None, constants);
    run(&here, &["replay", "constants.json"]).ends(3).prints("not applicable: the algebra has no group");
}

#[test]
fn every_law_is_listed_with_its_faults() {
    let here = directory("laws");
    let output = run(&here, &["laws", "--format", "json"]).ends(0);
    let listed: Vec<Value> = stdout(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let laws = euler_poincare::laws::all();
    assert_eq!(listed.len(), laws.len());
    for (object, law) in listed.iter().zip(laws) {
        assert_eq!(object["law"], law.about.name);
        assert_eq!(object["faults"].as_array().unwrap().len(), law.about.faults.len());
        assert_eq!([&object["statement"], &object["source"]], [law.about.statement, law.about.source]);
    }
    // What each law is drawn on is asked of all of them in laws.rs; here of one on every group, and of one on SO(3) and SE(3).
    let output = typed(&here, &format!("laws --coverage --laws {LAW},fast-presentation --format json")).ends(0);
    let covered: Vec<Value> = stdout(&output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(covered.len(), 2);
    let list = |law: &str, key: &str| -> Vec<&str> {
        let object = covered.iter().find(|object| object["law"] == law).unwrap();
        object[key].as_array().unwrap().iter().map(|name| name.as_str().unwrap()).collect()
    };
    assert_eq!(list(LAW, "retractions"), ["cayley", "composed", "exp"]);
    assert_eq!(list(LAW, "bases"), ["changed", "standard"]);
    let algebras = list(LAW, "algebras");
    assert!(["aff1", "heisenberg", "product", "so4"].iter().all(|name| algebras.contains(name)), "{algebras:?}");
    assert_eq!(list("fast-presentation", "retractions"), ["cayley", "exp"]);
    assert_eq!(list("fast-presentation", "bases"), ["standard"]);
    assert_eq!(list("fast-presentation", "algebras"), ["se3", "so3"]);
}

#[test]
fn tables_fit_into_a_hundred_columns() {
    let here = directory("width");
    let verify = "verify --laws retraction,coupling --cases 10";
    let commands = [verify, &format!("{verify} --verbose"), &format!("verify --faults --laws {LAW}"), "laws"];
    let widest = commands.map(|text| {
        // The columns of the environment are those of a terminal.
        let output = Ended::of(command(&here, &words(text)).env("COLUMNS", "80"));
        stdout(&output).lines().map(UnicodeWidthStr::width).max().unwrap()
    });
    assert!(widest[0] > 80 && widest.iter().all(|columns| *columns <= 100), "{widest:?}");
}

#[test]
fn a_run_that_judged_nothing_is_three() {
    let here = directory("nothing-judged");
    let verify = |words: &str| typed(&here, &format!("verify --laws {words}"));
    // A shard without cases.
    let output = verify(&format!("{LAW} --cases 1 --shard 1/2")).ends(3);
    assert!(stdout(&output).starts_with("NO VERDICT: not one case of 1 law was judged"), "{output}");
    // No time for a case.
    verify(&format!("{LAW} --minutes 0.0000000001")).ends(3);
    // A law that was asked for by its whole name, and to which the one case does not apply; the other law is judged.
    let one = format!("--cases 1 --seed {NO_VERDICT_SEED}");
    let output = verify(&format!("{LAW},{NO_VERDICT} {one}")).ends(3);
    let said = format!("NO VERDICT: not one case was judged of {NO_VERDICT};");
    assert!(stdout(&output).starts_with(&said), "{output}");
    let json = verify(&format!("{LAW},{NO_VERDICT} {one} --format json"));
    assert_eq!((code(&json), stdout(&json).lines().count()), (3, 2));
    assert!(stderr(&json).starts_with(&said), "{json}");
    // Where it is one of many that a pattern found, it is named, and the others count.
    let output = verify(&format!("{LAW},{}* {one}", &NO_VERDICT[..NO_VERDICT.len() - 1])).ends(0);
    output.prints(&format!("Without a verdict on any case: {NO_VERDICT}"));
}

#[test]
fn an_option_without_effect_is_refused() {
    let here = directory("no-effect");
    fs::write(here.join("system.toml"), stdout(&run(&here, &["integrate", "--example"]))).unwrap();
    fs::write(here.join("states.csv"), "mu_1,mu_2,mu_3\n1,2,3\n").unwrap();
    fs::write(here.join("top.toml"), tolerance::TOP).unwrap();
    refuses_each(&here, include_str!("command/refused/no-effect.txt"), 11);
    refuses_each(&here, include_str!("command/refused/tolerance.txt"), 5);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_standard_output_is_two() {
    let here = directory("full");
    fs::write(here.join("system.toml"), stdout(&run(&here, &["integrate", "--example"]))).unwrap();
    replay_file(&here.join("case.json"), LAW, Some(FAULT), "name = \"so3\"");
    let commands = format!(
        "verify --laws {LAW} --cases 5; verify --laws {LAW} --cases 5 --format json; verify --faults --laws {LAW}; laws; \
         replay case.json; integrate system.toml; integrate --example; --help; verify --help; --version"
    );
    for text in commands.split("; ") {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
        let output = command(&here, &words(text)).stdout(full).stderr(Stdio::piped()).spawn().unwrap();
        ended(output).ends(2).says("cannot write to standard output: ");
    }
}

#[test]
fn messages_count_as_the_file_does() {
    let here = directory("messages");
    let example = run(&here, &["integrate", "--example"]);
    let constants = "dimension = 3\nconstants = [[1, 2, 3, 1], [1, 3, 1, 1]]";
    for (old, new, said) in [
        ("name = \"so3\"", constants, "Jacobi identity for (e_1, e_2, e_3)"),
        ("name = \"so3\"", "name = \"so6\"", "allowed: r1 to r10, so3"),
        ("name = \"so3\"", "nam = \"so3\"", "unknown field `nam`, expected one of `name`, `dimension`"),
        ("\"double-bracket\"", "\"drag\"", "unknown kind of force `drag`; near to it: `cubic-drag`, `linear-drag`, "),
        // Whatever else the table has, which depends on the kind.
        ("\"double-bracket\"", "\"double-brackt\"\nbeta = 1", "near to it: `double-bracket`"),
    ] {
        fs::write(here.join("system.toml"), stdout(&example).replacen(old, new, 1)).unwrap();
        let output = run(&here, &["integrate", "system.toml"]).ends(2);
        assert!(stderr(&output).contains(said) && !stderr(&output).contains("given"), "{said}: {output}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_case_that_cannot_be_saved_names_its_file() {
    let here = directory("not-saved");
    let file = format!("{LAW}-{FAULT}-seed1-case");
    // A directory of that name, so that even the superuser cannot write the file.
    for index in 0..5 {
        fs::create_dir(here.join(format!("{file}{index}.json"))).unwrap();
    }
    let output = typed(&here, &format!("verify --laws {LAW} --cases 5 --plant {FAULT}")).ends(1);
    output.prints(&format!("not saved: {file}"));
}

#[test]
fn the_example_integrates_to_the_reference_and_draws() {
    let here = directory("integrate");
    let example = run(&here, &["integrate", "--example"]).ends(0);
    fs::write(here.join("system.toml"), stdout(&example)).unwrap();
    run(&here, &["integrate", "system.toml", "--out", "t.csv", "--plot", "t.svg"]).ends(0);
    let table = Table::new(&fs::read_to_string(here.join("t.csv")).unwrap());
    let [first, last] = [0, table.rows.len() - 1];
    for name in ["t", "mu_1", "eta_1", "energy", "work", "balance", "casimir_1", "residual", "iterations"] {
        table.text(first, name);
    }
    // The paper's LLG system: |M|² is kept and the energy falls along the motion.
    assert!((table.value(last, "casimir_1") - table.value(first, "casimir_1")).abs() < 1e-3);
    assert!(table.value(last, "energy") < table.value(first, "energy"));
    assert!(table.value(last, "balance").abs() < 1e-3);
    assert!(fs::read_to_string(here.join("t.svg")).unwrap().contains("</svg>"));
}

#[test]
fn a_fold_keeps_the_rows_so_far_and_bad_files_name_the_line() {
    let here = directory("integrate-refused");
    let file = |name: &str, tableau: &str| {
        let body = "inertia = [\"1/2\", 2, 1]\n[[force]]\nkind = \"double-bracket\"\nalpha = 1";
        let method = format!("tableau = \"{tableau}\"\nretraction = \"cayley\"");
        let state = "velocity = [\"1/sqrt(2)\", 0, \"1/sqrt(2)\"]";
        fs::write(here.join(name), system("so3", body, &method, state, "step = 1\nsteps = 2")).unwrap();
    };
    file("fold.toml", "lobatto-iiia-2");
    let output = run(&here, &["integrate", "fold.toml"]).ends(1);
    output.says("fold: the solution that continues from h = 0 ends near h = 0.7966");
    assert_eq!(stdout(&output).lines().count(), 2, "the header and the initial state");
    file("steps.toml", "lobatto-iiib-2");
    run(&here, &["integrate", "steps.toml", "--steps", "1"]).ends(0);
    file("tableau.toml", "gauss-0");
    run(&here, &["integrate", "tableau.toml"]).ends(2).says("line 10");
    run(&here, &["integrate", "missing.toml"]).ends(2);
}

#[test]
fn the_paper_is_reproduced() {
    let here = directory("paper");
    run(&here, &["paper", "--out", "out"]).ends(0);
    let rows = fs::read_to_string(here.join("out/errors.csv")).unwrap();
    let header = "problem,method,retraction,scalar,h,error_momentum,error_energy,error_casimir";
    assert_eq!(rows.lines().next(), Some(header));
    // Two problems, eight methods, two scalars, nine steps; Lobatto IIIA-2 has no root at h = 1.
    assert_eq!(rows.lines().count() - 1, 2 * 8 * 2 * 9 - 4);
    for figure in 1..=5 {
        let svg = fs::read_to_string(here.join(format!("out/figure-5.{figure}.svg"))).unwrap();
        assert!(page::drawn(&svg).contains("all integrators") != [2, 5].contains(&figure));
    }
    run(&here, &["paper", "--out", "/dev/null/x"]).ends(2);
}
