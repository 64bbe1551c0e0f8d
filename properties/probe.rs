//! Properties of `probe`: right verdicts on the steppers in `steppers/`, and on programs that are none.

use euler_poincare::algebra::Covector;
use euler_poincare::foreign::{Described, Foreign, ForeignStepper, Limits, Program, Record, Silence, parse};
use euler_poincare::integrators::{OneStep, State, StepError, Variational};
use euler_poincare::mechanics::{self, Lagrangian};
use euler_poincare::retraction::Retraction;
use euler_poincare::study::problem;
use euler_poincare::system::{Case, System, Visitor, cases};
use proptest::prelude::*;
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn steppers(name: &str) -> String {
    format!("{}/properties/steppers/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Says so past the test harness, which keeps what a passing test prints.
fn not_run(test: &str, why: &str) {
    let _ = writeln!(std::io::stderr(), "not run: {test}: {why}");
}

/// Whether there is Python; says so where there is none.
fn python(test: &str) -> bool {
    let there = Command::new("python3").arg("--version").output().is_ok_and(|output| output.status.success());
    if !there {
        not_run(test, "there is no python3");
    }
    there
}

/// An empty directory of this test, to run in.
fn directory(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("probe").join(test);
    let _ = fs::remove_dir_all(&path);
    fs::create_dir_all(&path).unwrap();
    path
}

fn probe(here: &Path, options: &[&str], stepper: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_euler-poincare"));
    command.arg("probe").args(options);
    if !stepper.is_empty() {
        command.arg("--").args(stepper);
    }
    command.current_dir(here).stdin(Stdio::null()).output().unwrap()
}

fn code(output: &Output) -> i32 {
    output.status.code().unwrap()
}

fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// The lines of `--format json`, by law.
fn laws(output: &Output) -> Vec<(String, Value)> {
    let text = stdout(output);
    let line = |line: &str| {
        let value: Value = serde_json::from_str(line).unwrap();
        (value["law"].as_str().unwrap().to_owned(), value)
    };
    text.lines().map(line).collect()
}

fn broken(output: &Output) -> Vec<String> {
    laws(output).into_iter().filter(|(_, line)| line["broken"].as_u64() > Some(0)).map(|(law, _)| law).collect()
}

/// Small systems: where a step in Python is quick.
const SMALL: [&str; 6] = ["--format", "json", "--algebras", "so3,se2", "--cases", "3"];

#[test]
fn correct_steppers_hold() {
    if !python("correct_steppers_hold") {
        return;
    }
    let here = directory("correct");
    let (rk4, variational) = (steppers("rk4.py"), steppers("variational.py"));
    let claimed: [(&[&str], &[&str]); 3] = [
        (&["--order", "4"], &["python3", &rk4]),
        (&[], &["python3", &rk4]),
        (&["--order", "2", "--conserves", "casimirs", "--reversible"], &["python3", &variational]),
    ];
    for (claims, stepper) in claimed {
        let output = probe(&here, &[&SMALL, claims].concat(), stepper);
        assert_eq!(code(&output), 0, "{claims:?}: {}{}", stdout(&output), stderr(&output));
        for (law, line) in laws(&output) {
            assert!(line["held"].as_u64() > Some(0), "{law} {claims:?}: {line}");
        }
    }
    assert!(fs::read_dir(&here).unwrap().next().is_none(), "nothing is written where nothing breaks");
}

#[test]
fn the_order_is_reported_where_none_is_claimed_and_refuted_on_both_sides() {
    if !python("the_order_is_reported_where_none_is_claimed_and_refuted_on_both_sides") {
        return;
    }
    let here = directory("order");
    let stepper = steppers("variational.py");
    let run = |claims: &[&str]| {
        let options = [&SMALL, &["--laws", "method-order"][..], claims].concat();
        probe(&here, &options, &["python3", &stepper])
    };
    let free = run(&[]);
    assert_eq!(code(&free), 0, "{}", stdout(&free));
    let order = laws(&free)[0].1["median_order"].as_f64().unwrap();
    assert!((order - 2.0).abs() < 0.1, "{order}");
    for wrong in ["1", "3"] {
        let output = run(&["--order", wrong]);
        assert_eq!((code(&output), broken(&output)), (1, vec!["method-order".into()]), "{}", stdout(&output));
        let witness = laws(&output)[0].1["failure"]["witness"].as_str().unwrap().to_owned();
        assert!(witness.contains("slope in [") && witness.contains(&format!("predicted {wrong}")), "{witness}");
    }
}

#[test]
fn each_mistake_breaks_the_law_that_names_it() {
    if !python("each_mistake_breaks_the_law_that_names_it") {
        return;
    }
    let stepper = steppers("variational.py");
    for (mistake, law) in [
        ("adjoint", "method-order"),
        ("frozen", "method-order"),
        ("left", "method-equivariance"),
        ("axis", "method-presentation"),
    ] {
        let here = directory(mistake);
        let options = [&SMALL, &["--order", "2", "--laws", law][..]].concat();
        let output = probe(&here, &options, &["python3", &stepper, mistake]);
        assert_eq!((code(&output), broken(&output)), (1, vec![law.to_owned()]), "{mistake}: {}", stdout(&output));
        // The record replays, as it is and on the correct stepper.
        let saved = laws(&output)[0].1["failure"]["saved"].as_str().unwrap().to_owned();
        let again = probe(&here, &["--replay", &saved], &[]);
        assert_eq!(code(&again), 1, "{}{}", stdout(&again), stderr(&again));
        assert!(stdout(&again).contains("broken: defect"), "{}", stdout(&again));
        let correct = probe(&here, &["--replay", &saved], &["python3", &stepper]);
        assert_ne!(code(&correct), 1, "{}{}", stdout(&correct), stderr(&correct));
    }
}

#[test]
fn a_broken_case_is_shown_with_everything_to_debug_it() {
    if !python("a_broken_case_is_shown_with_everything_to_debug_it") {
        return;
    }
    let here = directory("shown");
    let stepper = steppers("variational.py");
    let options = ["--algebras", "so3,se2", "--cases", "3", "--laws", "equivariance"];
    let output = probe(&here, &options, &["python3", &stepper, "left"]);
    let text = stdout(&output);
    for part in [
        "BROKEN method-equivariance",
        "statement",
        "source",
        "broken: defect",
        "after a left translation of g",
        "algebra ",
        "step ",
        "{\"version\":1,",
        "{\"mu\": [",
        "the solution of the equations there\n{\"g\":[",
        "euler-poincare probe --replay probe-method-equivariance-seed1-case",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn a_system_file_is_probed_as_it_is() {
    if !python("a_system_file_is_probed_as_it_is") {
        return;
    }
    let here = directory("system");
    fs::write(here.join("body.toml"), problem::generic_text()).unwrap();
    let stepper = steppers("variational.py");
    let options = ["--system", "body.toml", "--order", "2", "--conserves", "casimirs", "--format", "json"];
    let output = probe(&here, &options, &["python3", &stepper]);
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    assert!(laws(&output).iter().all(|(_, line)| line["held"] == 1), "{}", stdout(&output));
}

#[test]
fn what_is_not_supported_is_counted_and_no_verdict() {
    if !python("what_is_not_supported_is_counted_and_no_verdict") {
        return;
    }
    let here = directory("unsupported");
    let body = steppers("rigid_body.py");
    let output = probe(&here, &["--algebras", "se3", "--cases", "3", "--format", "json"], &["python3", &body]);
    assert_eq!(code(&output), 3, "{}", stdout(&output));
    for (law, line) in laws(&output) {
        let reasons = line["not_applicable"].as_object().unwrap();
        assert_eq!(reasons.values().map(|count| count.as_u64().unwrap()).sum::<u64>(), 3, "{law}");
        assert!(reasons.keys().any(|why| why.contains("free rigid body")), "{law}: {reasons:?}");
    }
    let free = ["--algebras", "so3", "--standard-basis", "--force-free", "--cases", "30", "--format", "json"];
    let output = probe(&here, &[&free[..], &["--laws", "casimirs,energy,reversibility"]].concat(), &["python3", &body]);
    assert_eq!(code(&output), 0, "{}", stdout(&output));
}

/// What sh does in the place of a stepper, and what is said of it.
const MISBEHAVING: [(&str, &str); 19] = [
    ("sleep 100", "hangs: no answer within 0.4 s"),
    ("cat > /dev/null", "hangs"),
    ("exit 3", "died (exit status: 3)"),
    ("read line; kill -9 $$", "died (signal: 9"),
    ("read line; echo oh dear >&2; exit 1", "its standard error ends with: oh dear"),
    ("while read line; do echo hello; done", "is not JSON"),
    ("while read line; do echo; done", "is not JSON"),
    ("while read line; do echo 7; done", "not a JSON object"),
    ("while read line; do echo '{\"mu\":[NaN]}'; done", "NaN or infinity"),
    ("while read line; do echo '{\"mu\":[1,-Infinity,0]}'; done", "NaN or infinity"),
    ("while read line; do echo '{\"mu\":[null,0,0]}'; done", "\"mu\"[0] in the stepper's answer is null"),
    ("while read line; do echo '{\"mu\":[0,\"1\",0]}'; done", "\"mu\"[1]"),
    ("while read line; do echo '{\"mu\":[1,2]}'; done", "has 2 numbers, not 3"),
    ("while read line; do echo '{\"mu\":[1,2,3]}'; done", "has no \"g\""),
    ("read line; yes", "is not JSON"),
    ("read line; yes | tr -d '\\n'", "floods its standard output"),
    ("read line; yes >&2", "floods its standard error"),
    ("echo '{}'; cat > /dev/null", "answers before it is asked"),
    ("read line; printf '{\"mu\":'; sleep 100", "without a newline: {\"mu\":"),
];

#[test]
fn programs_that_are_no_steppers_are_reported_in_time() {
    let here = directory("misbehaving");
    let options =
        ["--algebras", "so3", "--cases", "1", "--laws", "equivariance", "--timeout", "0.4", "--format", "json"];
    for (script, said) in MISBEHAVING {
        let start = Instant::now();
        let output = probe(&here, &options, &["sh", "-c", script]);
        assert!(start.elapsed() < Duration::from_secs(5), "{script}: {:?}", start.elapsed());
        assert_eq!(code(&output), 1, "{script}: {}{}", stdout(&output), stderr(&output));
        let line = &laws(&output)[0].1;
        let witness = line["failure"]["witness"].as_str().unwrap();
        // What is written before the request may arrive after it: then it is the answer, and a bad one.
        let late = script.starts_with("echo '{}'") && witness.contains("has no \"mu\"");
        assert!(witness.contains(said) || late, "{script}: {witness}");
        assert_eq!(line["failure"]["failed"], true, "{script}");
        let request = line["failure"]["exchanges"][0]["request"].as_str().unwrap();
        assert!(request.starts_with("{\"version\":1,") && request.contains("\"mu\":["), "{script}: {request}");
    }
}

#[test]
fn a_program_that_goes_on_failing_is_given_up() {
    let here = directory("given-up");
    let options = ["--algebras", "so3", "--cases", "50", "--timeout", "0.2"];
    let start = Instant::now();
    let output = probe(&here, &options, &["sh", "-c", "sleep 100"]);
    assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
    assert_eq!(code(&output), 1);
    assert!(stdout(&output).contains("failed 6 times and was not started again"), "{}", stdout(&output));
}

/// Whether a process with this number is there, and no zombie.
fn lives(pid: &str) -> bool {
    let stat = fs::read_to_string(format!("/proc/{}/stat", pid.trim()));
    stat.is_ok_and(|stat| !stat.contains(") Z "))
}

#[test]
fn nothing_is_left_running() {
    if !Path::new("/proc/self/stat").exists() {
        return not_run("nothing_is_left_running", "there is no /proc");
    }
    let here = directory("left");
    let file = here.join("pids");
    // The shell, and a child of it that holds the pipes open.
    let script = format!("sleep 100 & echo $$ $! > {}; wait", file.display());
    let limits = Limits { timeout: Duration::from_millis(300), ..Limits::default() };
    let mut program = Program::new(&["sh".into(), "-c".into(), script], limits);
    assert!(matches!(program.ask("{}"), Err(Silence::Hung { .. })));
    let pids = fs::read_to_string(&file).unwrap();
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(pids.split_whitespace().count(), 2);
    assert!(!pids.split_whitespace().any(lives), "{pids}");
    // Where nobody waits for a child it stays as a zombie: ours are waited for.
    let own = std::process::id().to_string();
    let zombies = fs::read_dir("/proc").unwrap().filter_map(|entry| {
        let stat = fs::read_to_string(entry.ok()?.path().join("stat")).ok()?;
        let rest = stat.rsplit_once(") ")?.1.to_owned();
        let mut words = rest.split(' ');
        (words.next() == Some("Z") && words.next() == Some(&own)).then_some(stat)
    });
    // Other tests of this process may have one for a moment.
    let first: Vec<String> = zombies.collect();
    std::thread::sleep(Duration::from_millis(300));
    assert!(
        !first.iter().any(|stat| fs::read_to_string(format!("/proc/{}/stat", stat.split(' ').next().unwrap()))
            .is_ok_and(|s| s.contains(") Z "))),
        "{first:?}"
    );
}

#[test]
fn bad_usage_is_two_and_says_what_is_allowed() {
    let here = directory("usage");
    fs::write(here.join("bad.json"), "{\"law\": 1}").unwrap();
    fs::write(here.join("bad.toml"), "format = 2").unwrap();
    let cases: [(&[&str], &[&str], &str); 11] = [
        (&[], &[], "after `--`"),
        (&[], &["no-such-program-anywhere"], "cannot be started"),
        (&["--laws", "no-such-law"], &["true"], "method-order"),
        (&["--algebras", "so5"], &["true"], "so3"),
        (&["--system", "no-such-file"], &["true"], "no-such-file"),
        (&["--system", "bad.toml"], &["true"], "line 1"),
        (&["--replay", "bad.json"], &["true"], "line 1"),
        (&["--timeout", "0"], &["true"], "0.001"),
        (&["--order", "0"], &["true"], "1..=20"),
        (&["--conserves", "momentum"], &["true"], "casimirs"),
        (&["--system", "bad.toml", "--random"], &["true"], "cannot be used with"),
    ];
    for (options, stepper, said) in cases {
        let output = probe(&here, options, stepper);
        assert_eq!(code(&output), 2, "{options:?}: {}", stdout(&output));
        assert!(stderr(&output).contains(said), "{options:?}: {}", stderr(&output));
    }
}

#[test]
fn the_stepper_in_rust_holds() {
    let path = Path::new(env!("CARGO_BIN_EXE_euler-poincare")).with_file_name("examples").join("gauss");
    if !path.exists() {
        return not_run("the_stepper_in_rust_holds", "the example `gauss` is not built");
    }
    let here = directory("rust");
    let options = ["--order", "4", "--conserves", "casimirs", "--algebras", "so3,se3,aff1,sl2", "--cases", "6"];
    let output = probe(&here, &[&options[..], &["--format", "json"]].concat(), &[path.to_str().unwrap()]);
    assert_eq!(code(&output), 0, "{}{}", stdout(&output), stderr(&output));
    assert!(laws(&output).iter().all(|(_, line)| line["held"].as_u64() > Some(0)), "{}", stdout(&output));
}

/// The library's Gauss method with one stage on a case, one step.
struct Gauss1;

impl Visitor<f64> for Gauss1 {
    type Output = Result<(Vec<f64>, Vec<f64>), StepError>;

    fn visit<const N: usize, const D: usize, R, L, F>(self, system: System<f64, N, D, R, L, F>) -> Self::Output
    where
        R: Retraction<f64, N, D> + 'static,
        L: Lagrangian<f64, N> + 'static,
        F: mechanics::Force<f64, N> + 'static,
    {
        let System { lagrangian, force, retraction, tableau, mut state, step, .. } = system;
        Variational::new(lagrangian, force, retraction, tableau).step(&mut state, step)?;
        Ok((state.momentum.iter().copied().collect(), state.attitude.iter().copied().collect()))
    }
}

#[test]
fn the_stepper_in_python_is_the_library_s_method() {
    if !python("the_stepper_in_python_is_the_library_s_method") {
        return;
    }
    let foreign = Foreign::new(&["python3".into(), steppers("variational.py")], Limits::default());
    let mut case = problem::generic().unwrap().case;
    case.method.tableau = "gauss-1".parse().unwrap();
    case.method.retraction = euler_poincare::system::case::Tau::Exponential;
    let (mu, g) = case.dispatch::<f64, _>(Gauss1).unwrap().unwrap();
    let start = case.dispatch::<f64, _>(Start).unwrap();
    let mut state: State<f64, 3, 3> = start;
    ForeignStepper::<3, 3>::new(&foreign, &case).unwrap().step(&mut state, 0.125).unwrap();
    for (x, y) in state.momentum.iter().chain(state.attitude.iter()).zip(mu.iter().chain(&g)) {
        assert!((x - y).abs() < 1e-14, "{state:?} {mu:?} {g:?}");
    }
    assert!(ForeignStepper::<6, 8>::new(&foreign, &case).is_err(), "another dimension is refused");
}

/// The initial state of a case on so(3).
struct Start;

impl Visitor<f64> for Start {
    type Output = State<f64, 3, 3>;

    fn visit<const N: usize, const D: usize, R, L, F>(self, system: System<f64, N, D, R, L, F>) -> Self::Output
    where
        R: Retraction<f64, N, D> + 'static,
        L: Lagrangian<f64, N> + 'static,
        F: mechanics::Force<f64, N> + 'static,
    {
        let momentum = Covector::from_fn(|_, a| system.state.momentum[a]);
        let attitude = euler_poincare::algebra::Matrix::from_fn(|r, c| system.state.attitude[(r, c)]);
        State { time: system.state.time, momentum, attitude }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A request carries all digits, and finite numbers only.
    #[test]
    fn requests_are_one_line_of_json_with_all_digits(case in cases(), h in -1.0..1.0f64) {
        let described = Described::of(&case).unwrap();
        let theory = euler_poincare::laws::method::theory_of::<f64>(&case).unwrap();
        let start = theory.start();
        let line = described.request(&start, h);
        prop_assert!(!line.contains('\n') && !line.contains("null"));
        let value: Value = serde_json::from_str(&line).unwrap();
        let (n, m) = (case.dimension(), described.size());
        let numbers = |key: &str| value[key].as_array().map_or(0, Vec::len);
        prop_assert_eq!(numbers("constants"), n * n * n);
        prop_assert_eq!(numbers("basis"), n * m * m);
        prop_assert_eq!(numbers("inertia"), n * n);
        prop_assert_eq!(numbers("g"), m * m);
        prop_assert_eq!(value["step"].as_f64(), Some(h));
        let mu: Vec<f64> = value["mu"].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
        prop_assert_eq!(mu, start.momentum);
        let g: Vec<f64> = value["g"].as_array().map_or(Vec::new(), |g| g.iter().map(|x| x.as_f64().unwrap()).collect());
        prop_assert_eq!(g, start.attitude);
    }

    /// No line of bytes makes the reader panic.
    #[test]
    fn any_bytes_are_an_answer_or_refused(line in proptest::collection::vec(any::<u8>(), 0..200), n in 0..9usize) {
        let _ = parse(&line, n, n * n);
    }

    /// Another presentation describes the same system: it gives back the numbers when asked twice with orthogonal changes.
    #[test]
    fn presentations_are_cases_that_can_be_built(case in cases()) {
        let (other, basis) = case.presented();
        other.check().unwrap();
        prop_assert_eq!(other.dimension(), case.dimension());
        // μ' = μ B.
        let of = |case: &Case| euler_poincare::laws::method::theory_of::<f64>(case).unwrap().start();
        let (mine, theirs) = (of(&case), of(&other));
        let size = mine.momentum.iter().fold(1e-300, |m: f64, x| m.max(x.abs()));
        for (a, x) in theirs.momentum.iter().enumerate() {
            let expected: f64 = mine.momentum.iter().zip(&basis).map(|(mu, row)| mu * row[a]).sum();
            prop_assert!((x - expected).abs() <= 1e-12 * size, "{} for {}", x, expected);
        }
        for (x, y) in mine.attitude.iter().zip(&theirs.attitude) {
            prop_assert!((x - y).abs() <= 1e-12 * (1.0 + x.abs()));
        }
    }
}

#[test]
fn records_are_read_back_or_refused() {
    let record = Record {
        law: "method-order".into(),
        command: vec!["python3".into(), "x.py".into()],
        timeout: 0.5,
        claims: Default::default(),
        seed: 7,
        index: 3,
        case: problem::generic().unwrap().case,
        exchanges: Vec::new(),
    };
    let text = record.to_json().unwrap();
    assert_eq!(Record::from_json(&text).unwrap(), record);
    for (old, new) in [("0.5", "-1.0"), ("\"command\"", "\"commands\""), ("so3", "so5"), ("{", "")] {
        assert!(Record::from_json(&text.replacen(old, new, 1)).is_err(), "{new}");
    }
}
