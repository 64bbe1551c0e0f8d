//! Properties of `probe`: right verdicts on the steppers in `steppers/`, and on programs that are none.

use super::{Ended, code, directory, flat, generic, has_all, run, started, stderr, stdout, stopped, wait_for};
use euler_poincare::external::{Described, Limits, Program, Record, Silence, Supports, parse};
use euler_poincare::harness::draw;
use euler_poincare::laws::method::{LAWS, StateForm};
use euler_poincare::study::problem;
use euler_poincare::system::case::{Force, Motion, Potential};
use euler_poincare::system::cases;
use proptest::prelude::*;
use serde_json::Value;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::time::{Duration, Instant};

pub fn steppers(name: &str) -> String {
    format!("{}/properties/steppers/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Says so past the test harness, which keeps what a passing test prints.
pub fn not_run(test: &str, why: &str) {
    let _ = writeln!(std::io::stderr(), "not run: {test}: {why}");
}

/// Whether there is such a program.
fn there(program: &str) -> bool {
    Command::new(program).arg("--version").output().is_ok_and(|output| output.status.success())
}

/// An empty directory of this test, if there is Python; says so where there is none.
pub fn with_python(test: &str) -> Option<PathBuf> {
    if !there("python3") {
        not_run(test, "there is no python3");
        return None;
    }
    Some(directory(test))
}

/// With options between spaces.
fn probe(here: &Path, options: &str, stepper: &[&str]) -> Ended {
    let (options, separator): (Vec<&str>, &[&str]) =
        (options.split_whitespace().collect(), if stepper.is_empty() { &[] } else { &["--"] });
    run(here, &[&["probe"], &options[..], separator, stepper].concat())
}

/// Asks a stepper in Python, of the test or of `steppers/`; after it its arguments.
fn ask(here: &Path, options: &str, stepper: &str) -> Ended {
    let words: Vec<&str> = stepper.split(' ').collect();
    let path = if here.join(words[0]).exists() { words[0].to_owned() } else { steppers(words[0]) };
    probe(here, options, &[&["python3", &path], &words[1..]].concat())
}

/// Replays a saved case.
fn replayed(here: &Path, saved: &str) -> Ended {
    probe(here, &format!("--replay {saved}"), &[])
}

/// The objects of `--format json`: those of the laws, and the last one.
fn objects(output: &Output) -> (Vec<Value>, Value) {
    let mut lines: Vec<Value> = stdout(output).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let summary = lines.pop().unwrap_or_else(|| panic!("no output: {}", stderr(output)));
    assert!(lines.iter().all(|line| line["schema"] == "probe/1"), "{}", stdout(output));
    assert_eq!(summary["schema"], "probe-summary/1");
    (lines, summary)
}

/// The lines of `--format json`, by law.
fn laws(output: &Output) -> Vec<(String, Value)> {
    objects(output).0.into_iter().map(|line| (line["law"].as_str().unwrap().to_owned(), line)).collect()
}

/// The last line of `--format json`.
fn summary(output: &Output) -> Value {
    objects(output).1
}

/// The line of the first law.
fn first(output: &Output) -> Value {
    objects(output).0.swap_remove(0)
}

/// The failure of the first law.
fn failure(output: &Output) -> Value {
    first(output)["failure"].clone()
}

/// The name of the record of a failure.
fn saved(output: &Output) -> String {
    failure(output)["saved"].as_str().unwrap().to_owned()
}

/// The request that a failure was seen in.
fn request(failure: &Value) -> &str {
    failure["exchange"]["request"].as_str().unwrap()
}

/// A rigid body on so(3) as a system file, with these keys of the Lagrangian and tables.
pub fn rigid_body(keys: &str) -> String {
    format!(
        "format = 1\n[algebra]\nname = \"so3\"\n[lagrangian]\ninertia = [1, 2, 3]\n{keys}\n[state]\nmomentum = [1, 1, 1]\n\
         [run]\nstep = \"1/8\"\n"
    )
}

fn broken(output: &Output) -> Vec<String> {
    laws(output).into_iter().filter(|(_, line)| line["broken"].as_u64() > Some(0)).map(|(law, _)| law).collect()
}

/// Small systems: where a step in Python is quick.
const SMALL: &str = "--format json --algebras so3,se2 --cases 3";

#[test]
fn correct_steppers_hold() {
    let Some(here) = with_python("correct_steppers_hold") else { return };
    let kept = "casimirs,momentum,poisson";
    let free = format!("--laws {} --conserves {kept}", laws_of(kept));
    let variational = "variational.py";
    for (claims, stepper) in
        [("--order 4", "rk4.py"), ("", "rk4.py"), ("--order 2 --reversible", variational), (&free, variational)]
    {
        let output = ask(&here, &format!("{SMALL} {claims}"), stepper).ends(0);
        for (law, line) in laws(&output) {
            assert!(line["held"].as_u64() > Some(0), "{law} {claims}: {line}");
            assert_eq!(line["claim"].is_string(), line["confirmed"].as_u64() > Some(0), "{law} {claims}: {line}");
        }
        let conclusion = if claims.is_empty() { "unbroken" } else { "confirmed" };
        assert_eq!(summary(&output)["conclusion"], conclusion);
    }
    assert!(fs::read_dir(&here).unwrap().next().is_none(), "nothing is written where nothing breaks");
}

#[test]
fn a_gyrostat_is_asked_in_version_2() {
    let Some(here) = with_python("a_gyrostat_is_asked_in_version_2") else { return };
    for (file, keys) in [("gyrostat.toml", ""), ("metric.toml", "quartic = 1\nmetric = [1, 0, 2]")] {
        let drag = "[[force]]\nkind = \"linear-drag\"\ncoefficient = \"1/4\"";
        let text = rigid_body(&format!("gyrostat = [0, \"1/2\", 1]\n{keys}\n{drag}"));
        fs::write(here.join(file), text).unwrap();
    }
    let run = |system: &str, stepper: &str| {
        ask(&here, &format!("--system {system} --order 4 --laws order --format json"), stepper)
    };
    run("gyrostat.toml", "rk4.py").ends(0);
    // A program that does not look at the key solves another system.
    let ignores = changed(&here, "rk4.py", &[("q.get(\"gyrostat\", [0.0] * n)", "[0.0] * n")]);
    let broken = failure(&run("gyrostat.toml", &ignores).ends(1));
    let request = request(&broken);
    assert!(request.starts_with("{\"version\":2,") && request.contains("\"gyrostat\":[0.0,0.5,1.0]"), "{request}");
    for (system, stepper, why) in [
        ("gyrostat.toml", "variational.py", "a later version of the protocol"),
        ("gyrostat.toml", "rigid_body.py", "does not support such a system (\\\"forces\\\")"),
        ("metric.toml", "rk4.py", "does not support such a system (\\\"quartic\\\")"),
    ] {
        run(system, stepper).ends(3).prints(why);
    }
}

#[test]
fn potentials_are_drawn_for_steppers_that_list_them() {
    let Some(here) = with_python("potentials_are_drawn_for_steppers_that_list_them") else { return };
    let run = |options: &str, stepper: &str| {
        ask(&here, &format!("--format json --algebras so3 --cases 6 --shrink 0 {options}"), stepper)
    };
    let laws_of = "order,energy,momentum,casimirs,equivariance,presentation,smoothness";
    let held = run(&format!("--order 4 --laws {laws_of}"), "rk4.py").ends(0);
    for (law, line) in laws(&held) {
        assert!(line["held"].as_u64() > Some(3), "{law}: {line}");
    }
    let claims = "--variational lobatto-iiia-3 --stages --order 4 --laws variational,noether,order";
    run(claims, "stages.py lobatto-iiia-3").ends(0);
    // The potential where the step starts.
    let wrong = run(claims, "stages.py lobatto-iiia-3 0 start").ends(1);
    assert_eq!(broken(&wrong), ["method-order", "method-noether", "method-variational"]);
    let wrong = failure(&wrong);
    let request = request(&wrong);
    assert!(request.starts_with("{\"version\":3,") && request.contains("\"potential\":[{\"kind\":"), "{request}");
    // One that lists none has none, and is not asked about one.
    run("--order 4 --laws order", "rigid_body.py").ends(0);
    let gravity = "[[potential]]\nkind = \"gravity\"\nweight = 1\ncenter = [0, \"1/4\", 1]";
    fs::write(here.join("top.toml"), rigid_body(gravity)).unwrap();
    let options = "--system top.toml --order 4 --laws order,energy --format json";
    ask(&here, options, "rk4.py").ends(0);
    ask(&here, options, "rigid_body.py").ends(3).prints("such a system (\\\"potentials\\\")");
}

#[test]
fn an_order_is_reported_or_refuted_on_both_sides() {
    let Some(here) = with_python("an_order_is_reported_or_refuted_on_both_sides") else { return };
    let run = |claims: &str| ask(&here, &format!("{SMALL} --laws method-order --shrink 0 {claims}"), "variational.py");
    let line = first(&run("").ends(0));
    let order = line["median_order"].as_f64().unwrap();
    assert!((order - 2.0).abs() < 0.1, "{order}");
    // Of momentum and attitude, each by itself.
    for (orders, quantity) in line["orders"].as_array().unwrap().iter().zip(["momentum", "attitude"]) {
        assert_eq!((&orders["quantity"], &orders["cases"]), (&quantity.into(), &3.into()), "{line}");
        assert!(["median", "least"].iter().all(|key| (orders[*key].as_f64().unwrap() - 2.0).abs() < 0.1), "{line}");
    }
    assert_eq!(line["orders"].as_array().unwrap().len(), 2);
    let few = "--algebras so3 --cases 2 --laws method-order";
    ask(&here, few, "variational.py").prints("\nOrders\n  momentum");
    for wrong in ["1", "3"] {
        let output = run(&format!("--order {wrong}"));
        assert_eq!((code(&output), broken(&output)), (1, vec!["method-order".into()]), "{output}");
        let failure = failure(&output);
        has_all(failure["witness"].as_str().unwrap(), &format!("order in [ ¦ expected {wrong}"));
    }
}

#[test]
fn an_attitude_of_a_lower_order_is_named_where_no_order_is_claimed() {
    let Some(here) = with_python("an_attitude_of_a_lower_order_is_named_where_no_order_is_claimed") else { return };
    // Runge and Kutta's for the momentum, Euler's for the attitude.
    let of_euler = ("\"g\": y[3:]", "\"g\": [a + h * b for a, b in zip(q[\"g\"], k1[3:])]");
    let euler = changed(&here, "rigid_body.py", &[of_euler]);
    let (options, named) = ("--cases 3 --laws method-order", "; but the attitude has order 1.0");
    for (stepper, lower) in [(&*euler, true), ("rigid_body.py", false)] {
        let output = ask(&here, options, stepper);
        let first = stdout(&output).replace('\n', " ");
        assert_eq!((code(&output), first.contains(named)), (0, lower), "{first}");
    }
    ask(&here, &format!("{options} --order 4"), &euler).ends(1);
}

#[test]
fn each_mistake_breaks_the_law_that_names_it() {
    let Some(here) = with_python("each_mistake_breaks_the_law_that_names_it") else { return };
    for (mistake, law) in [
        ("adjoint", "method-order"),
        ("frozen", "method-order"),
        ("left", "method-equivariance"),
        ("axis", "method-presentation"),
    ] {
        let options = format!("{SMALL} --order 2 --laws {law} --shrink 0");
        let output = ask(&here, &options, &format!("variational.py {mistake}"));
        assert_eq!((code(&output), broken(&output)), (1, vec![law.to_owned()]), "{mistake}: {output}");
        // The record replays, as it is and on the correct stepper.
        let saved = saved(&output);
        replayed(&here, &saved).ends(1).prints("broken: defect");
        let correct = ask(&here, &format!("--replay {saved}"), "variational.py");
        assert_ne!(code(&correct), 1, "{correct}");
    }
}

/// The laws that judge these claims.
fn laws_of(what: &str) -> String {
    what.replace("casimirs", "conserves-casimirs").replace("momentum", "conserves-momentum")
}

/// The laws of what is conserved, with their claims.
fn conserves(what: &str, algebras: &str, cases: u32) -> String {
    let laws = laws_of(what);
    format!("--algebras {algebras} --cases {cases} --laws {laws} --conserves {what} --shrink 0 --format json")
}

#[test]
fn an_order_is_no_conservation() {
    let Some(here) = with_python("an_order_is_no_conservation") else { return };
    // On SE(2) its matrices leave the group by a scaling, which Ad does not see: there the momentum does not drift.
    for (what, algebras) in [("casimirs", "so3,se2,sl2"), ("momentum", "so3,sl2"), ("poisson", "so3,se2,sl2")] {
        let output = ask(&here, &conserves(what, algebras, 6), "rk4.py");
        let line = first(&output);
        assert_eq!((code(&output), &line["held"]), (1, &0.into()), "{what}: {output}");
        has_all(line["failure"]["witness"].as_str().unwrap(), "falls with the step ¦ no conservation");
        let slopes = &line["failure"]["slopes"][0];
        assert!(slopes["levels"].as_array().unwrap().len() >= 4, "{slopes}");
    }
}

#[test]
fn a_balance_and_what_is_conserved_have_two_names() {
    let Some(here) = with_python("a_balance_and_what_is_conserved_have_two_names") else { return };
    // A force that is taken where the step starts: of order 1, and no matter without force.
    let options = "--algebras so3,se2 --cases 6 --order 2 --conserves casimirs --laws casimirs --shrink 0 -v";
    let output = ask(&here, options, "variational.py frozen").ends(1);
    let text = flat(stdout(&output));
    assert!(text.starts_with("BROKEN (method-casimirs): 2 laws on 12 cases"), "{text}");
    has_all(&text, "conserves casimirs confirmed: by method-conserves-casimirs on 6 of 6 cases");
}

/// The name of a program made of a stepper, with changes.
fn changed(here: &Path, stepper: &str, changes: &[(&str, &str)]) -> String {
    let mut text = fs::read_to_string(steppers(stepper)).unwrap();
    for (old, new) in changes {
        assert_eq!(text.matches(old).count(), 1, "{old}");
        text = text.replace(old, new);
    }
    let name = (0..).map(|k| format!("changed{k}.py")).find(|name| !here.join(name).exists()).unwrap();
    fs::write(here.join(&name), text).unwrap();
    name
}

/// Series of exp, dexp and their like that are cut: at small steps the rest is below rounding. The partitioned method in the chart, whose
/// Casimirs drift, is the fault `chart-trap` of the laws of what is conserved.
#[test]
fn what_drifts_at_large_steps_is_refuted() {
    let Some(here) = with_python("what_drifts_at_large_steps_is_refuted") else { return };
    for terms in ["while k < 6:", "while k < 4:"] {
        let stepper = changed(&here, "variational.py", &[("while k < 60:", terms)]);
        // A series that is cut is exact on a motion that is steady, as half of these are.
        let output = ask(&here, &conserves("momentum", "so3,se2", 12), &stepper).ends(1);
        assert!(first(&output)["broken"].as_u64() > Some(2), "{terms} {output}");
        // The order sees nothing.
        ask(&here, &format!("{SMALL} --force-free --laws order --order 2"), &stepper).ends(0);
    }
}

/// Claims that a step is that of a scheme, on few cases.
fn variational(tableau: &str, tolerance: &str, algebras: &str, cases: u32) -> String {
    let claim = format!("--variational {tableau} --tolerance {tolerance} --laws variational --shrink 0");
    format!("{claim} --algebras {algebras} --cases {cases} --format json")
}

#[test]
fn a_step_of_the_scheme_is_not_refused() {
    let Some(here) = with_python("a_step_of_the_scheme_is_not_refused") else { return };
    // More of them are in harness/method.rs, without the program.
    for (tableau, tolerance) in
        [("gauss-2", "0"), ("gauss-3", "1e-9"), ("lobatto-iiib-3", "0"), ("radau-iia-3", "1e-8")]
    {
        for force in ["", " --force-free"] {
            let options = variational(tableau, tolerance, "so3,se2,sl2", 3) + force;
            let output = ask(&here, &options, &format!("stages.py {tableau} {tolerance}"));
            assert_eq!((code(&output), &first(&output)["broken"]), (0, &0.into()), "{tableau} {tolerance}: {output}");
            assert!(first(&output)["confirmed"].as_u64() >= Some(2), "{tableau} {tolerance}: {output}");
        }
    }
    // A state without an attitude, and an independent method of one stage.
    ask(&here, &variational("gauss-1", "0", "so3,se2,sl2", 6), "variational.py").ends(0);
}

/// Another tableau of the same order, and another retraction; other wrong steps are in the table of faults of `method-variational`.
#[test]
fn what_keeps_the_order_is_another_scheme() {
    let Some(here) = with_python("what_keeps_the_order_is_another_scheme") else { return };
    for claim in ["lobatto-iiib-3", "lobatto-iiia-3 --retraction cayley"] {
        let options = format!("--variational {claim} -v --laws variational --shrink 0 --algebras so3 --cases 2");
        let output = ask(&here, &options, "stages.py lobatto-iiia-3").ends(1);
        has_all(&flat(stdout(&output)), "it falls with the step like ¦ another method ¦ answer less scheme");
    }
}

#[test]
fn impulses_at_the_stages_change_the_spatial_momentum() {
    let Some(here) = with_python("impulses_at_the_stages_change_the_spatial_momentum") else { return };
    let options = "--stages --laws noether --shrink 0 --cases 6 --format json --algebras so3,se2";
    // The theorem does not ask which equations the stages solve.
    for (tableau, mistake, right) in [
        ("gauss-2", "", true),
        ("lobatto-iiib-3", "", true),
        ("gauss-2", "index", true),
        ("gauss-2", "bernoulli", false),
        ("gauss-2", "left", false),
    ] {
        let output = ask(&here, options, &format!("stages.py {tableau} 0 {mistake}"));
        let line = first(&output);
        let held = line["broken"] == 0 && line["held"].as_u64() > Some(2);
        assert_eq!((held, code(&output)), (right, i32::from(!right)), "{tableau} {mistake}: {output}");
    }
    // Stages that are none are a failure of the program; a method that tells none is not judged.
    let told = ("print(json.dumps(answer)", "answer.update(stages=[{\"b\": 1}])\n    print(json.dumps(answer)");
    let told = changed(&here, "rk4.py", &[told]);
    ask(&here, options, &told).ends(1).prints("has no finite number \\\"t\\\"");
    ask(&here, options, "rk4.py").ends(3).prints("does not tell its stages");
}

#[test]
fn a_claim_of_a_scheme_is_replayed() {
    let Some(here) = with_python("a_claim_of_a_scheme_is_replayed") else { return };
    fs::write(here.join("mine.toml"), "a = [[\"1/2\"]]\nb = [1]\n").unwrap();
    let output = ask(&here, &variational("mine.toml", "0", "so3", 2), "variational.py axis").ends(1);
    let (line, saved) = (first(&output), saved(&output));
    assert!(line["claim"].as_str().unwrap().starts_with("variational a = [[1/2]], b = [1] with exp"), "{line}");
    replayed(&here, &saved).ends(1);
    ask(&here, &format!("--replay {saved}"), "variational.py").ends(0);
    // The exchange says what is beside the answer.
    assert_eq!(line["failure"]["exchange"]["of_scheme"], true, "{line}");
    for (wrong, said) in [("gauss-0", "number of stages"), ("gaus-2", "allowed")] {
        probe(&here, &format!("--variational {wrong}"), &["true"]).ends(2).says(said);
    }
}

#[test]
fn an_iteration_that_stops_early_says_so_and_keeps_its_claims() {
    let Some(here) = with_python("an_iteration_that_stops_early_says_so_and_keeps_its_claims") else { return };
    // μ' is off by 1e-10 of itself, whatever the step, as of a loose iteration.
    let exact = "    answer = {\"mu\": row_times(m, expm(ad))}\n";
    let loose = format!("{exact}    answer[\"mu\"] = [x * (1 + 1e-10 * math.sin(1e6 * x)) for x in answer[\"mu\"]]\n");
    let stepper = changed(&here, "variational.py", &[(exact, &loose)]);
    let kept = conserves("casimirs,momentum", "so3,se2", 4);
    // Correct methods are not refused with a tolerance either.
    for (stepper, tolerance, expected) in
        [(&*stepper, "1e-10", 0), (&stepper, "1e-9", 0), (&stepper, "0", 1), ("variational.py", "1e-8", 0)]
    {
        ask(&here, &format!("{kept} --tolerance {tolerance}"), stepper).ends(expected);
    }
    // In the first line of the text a loose solver is called loose; lost digits are there, too.
    let first = |stepper: &str, claims: &str| {
        let output = ask(&here, &format!("--algebras so3,se2 --cases 4 --shrink 0 {claims}"), stepper);
        stdout(&output).split("\n\n").next().unwrap_or_default().replace('\n', " ")
    };
    let kept = "--laws conserves-casimirs --conserves casimirs";
    for (law, options) in [("conserves-casimirs", kept), ("smoothness", "--laws smoothness")] {
        let said = first(&stepper, options);
        assert!(said.starts_with(&format!("BROKEN (method-{law}): ")) && said.contains("; loose solver ("), "{said}");
    }
    let lost = changed(&here, "variational.py", &[(exact, &loose.replace("1e-10", "1e-13"))]);
    let said = first(&lost, kept);
    assert!(said.contains("; digits are lost on ") && said.contains("(method-conserves-casimirs)"), "{said}");
}

#[test]
fn a_program_that_aborts_under_one_law_breaks_no_law() {
    let Some(here) = with_python("a_program_that_aborts_under_one_law_breaks_no_law") else { return };
    // It refuses a negative step by ending.
    let refuses = format!("{STEP}    if h < 0:\n        sys.exit(\"no negative steps\")\n");
    let aborts = changed(&here, "rk4.py", &[(STEP, &refuses)]);
    // One negative step for each case of reversibility: fewer than it is started again.
    let options = "--algebras so3 --cases 2 --order 4 --laws reversibility,momentum,equivariance";
    let output = ask(&here, &format!("{options} --format json"), &aborts);
    let (lines, summary) = objects(&output);
    assert_eq!((code(&output), &summary["conclusion"]), (1, &"failed".into()), "{output}");
    assert_eq!((&summary["laws_broken"], &summary["laws_failed"]), (&0.into(), &1.into()), "{summary}");
    for line in &lines {
        let failed = if line["law"] == "method-reversibility" { 2 } else { 0 };
        assert_eq!((&line["broken"], &line["failed"]), (&0.into(), &failed.into()), "{line}");
        assert_eq!(line["program_failure"].is_object(), failed > 0, "{line}");
    }
    let failure = &lines[0]["program_failure"];
    let request: Value = serde_json::from_str(request(failure)).unwrap();
    assert!(request["step"].as_f64() < Some(0.0), "the request that caused it: {request}");
    assert!(failure["witness"].as_str().unwrap().contains("no negative steps"), "{failure}");
    // The record runs again, as a failure.
    let saved = failure["saved"].as_str().unwrap();
    replayed(&here, saved).ends(1).prints("the stepper failed on it");
    let text = ask(&here, &format!("{options} --verbose"), &aborts);
    assert!(stdout(&text).starts_with("THE PROGRAM FAILED, no law broken"), "{text}");
    text.prints("THE PROGRAM FAILED under method-reversibility: 2 of 2 cases");
}

#[test]
fn a_broken_case_is_shown_with_everything_to_debug_it() {
    let Some(here) = with_python("a_broken_case_is_shown_with_everything_to_debug_it") else { return };
    let options = "--algebras so3,se2 --cases 3 --laws equivariance";
    // In short the reason, and the command that prints the rest.
    let short = ask(&here, options, "variational.py left");
    short.prints(
        "BROKEN (method-equivariance) ¦ after a left translation of g ¦ \n  euler-poincare probe --replay probe-",
    );
    let short = stdout(&short);
    assert!(!short.contains("solution at the end") && !short.contains("statement"), "{short}");
    let output = ask(&here, &format!("{options} -v"), "variational.py left");
    let text = stdout(&output);
    has_all(
        text,
        "BROKEN method-equivariance ¦ statement ¦ source ¦ broken: defect ¦ after a left translation of g ¦ algebra  ¦ step  ¦ \
         \"constants\": (27 numbers) ¦ answer\n{\"mu\": [ ¦ solution at the end of this step\n{\"mu\":[ ¦ \
         answer less solution\n{\"mu\":[ ¦ euler-poincare probe --replay probe-method-equivariance-seed1-case",
    );
    // The request itself is one line for the program.
    let saved = text.split_whitespace().find(|word| word.starts_with("probe-") && word.ends_with(".json")).unwrap();
    let request = probe(&here, &format!("--replay {saved} --request"), &[]).ends(0);
    assert!(stdout(&request).starts_with("{\"version\":1,") && stdout(&request).lines().count() == 1, "{request}");
}

#[test]
fn a_shrunk_case_is_refuted_as_clearly() {
    let Some(here) = with_python("a_shrunk_case_is_refuted_as_clearly") else { return };
    // The drift of its energy falls with the step and with the motion: simpler cases drift less and less.
    let options = "--algebras so3 --cases 4 --laws conserves-energy --conserves energy --format json";
    let output = ask(&here, options, "rk4.py").ends(1);
    let failure = failure(&output);
    assert!(failure["checks"].as_u64() > Some(0), "{failure}");
    let again = replayed(&here, &format!("{} --format json", failure["saved"].as_str().unwrap()));
    let again: Value = serde_json::from_str(stdout(&again).trim()).unwrap();
    let (defect, bound) = (again["defect"].as_f64().unwrap(), again["bound"].as_f64().unwrap());
    assert!(defect >= 1000.0 * bound, "{again}");
}

#[test]
fn a_system_file_is_probed_with_or_without_a_method() {
    let Some(here) = with_python("a_system_file_is_probed_with_or_without_a_method") else { return };
    fs::write(here.join("body.toml"), problem::generic_text()).unwrap();
    // Without its method and without the length of a run.
    let bare = generic("[method]", "[state]", "").replace("horizon = 1", "");
    fs::write(here.join("bare.toml"), &bare).unwrap();
    for file in ["body.toml", "bare.toml"] {
        let output = ask(&here, &format!("--system {file} --order 2 --format json"), "variational.py").ends(0);
        assert!(laws(&output).iter().all(|(_, line)| line["held"] == 1), "{output}");
    }
    // A place after the missing table is still the right one, and `integrate` wants the table.
    let broken = bare.replace("velocity = [\"3/4\"", "velocity = [\"3/\"");
    fs::write(here.join("broken.toml"), &broken).unwrap();
    let line = 1 + broken.lines().position(|line| line.contains("\"3/\"")).unwrap();
    probe(&here, "--system broken.toml", &["true"]).ends(2).says(&format!("line {line}, column 1"));
    run(&here, &["integrate", "bare.toml"]).ends(2).says("a table [method]");
}

const STEP: &str = "    n, m, h = q[\"dimension\"], q[\"size\"], q[\"step\"]\n";

#[test]
fn a_claim_that_no_case_confirms_is_no_success() {
    let Some(here) = with_python("a_claim_that_no_case_confirms_is_no_success") else { return };
    fs::write(here.join("body.toml"), problem::generic_text()).unwrap();
    let on_body = "--system body.toml --format json";
    // Only the step of the system is taken: the other laws hold, and the order cannot be measured.
    let refuses = format!("{STEP}    if abs(h) != 0.125:\n        return {{\"error\": \"another step\"}}\n");
    let coarse = changed(&here, "rk4.py", &[(STEP, &refuses)]);
    let output = ask(&here, &format!("{on_body} --order 4"), &coarse).ends(3);
    let found = laws(&output);
    let line = |law: &str| found.iter().find(|(name, _)| name == law).unwrap().1.clone();
    assert_eq!(line("method-equivariance")["held"], 1);
    assert_eq!(line("method-order")["claim"], "order 4");
    assert_eq!((&line("method-order")["held"], &line("method-order")["confirmed"]), (&0.into(), &0.into()));
    let claim = summary(&output)["claims"][0].clone();
    assert_eq!(summary(&output)["conclusion"], "unconfirmed");
    assert!(claim["why"].as_str().unwrap().contains("another step"), "{claim}");
    let text = ask(&here, "--system body.toml --order 4", &coarse);
    text.prints("NOT CONFIRMED: by method-order on 0 of 1 cases");
    // Conservation is claimed without force: of a forced body it says nothing, though the balance closes.
    let claims = "--conserves casimirs --laws casimirs";
    let output = ask(&here, &format!("{on_body} {claims}"), "variational.py").ends(3);
    let found = laws(&output);
    let counts = |line: &Value| (line["held"].as_u64(), line["confirmed"].as_u64());
    assert_eq!(found[0].0, "method-casimirs");
    assert_eq!(counts(&found[0].1), (Some(1), None), "{}", found[0].1);
    assert_eq!(found[1].0, "method-conserves-casimirs");
    assert_eq!(counts(&found[1].1), (Some(0), Some(0)), "{}", found[1].1);
    assert!(summary(&output)["claims"][0]["why"].as_str().unwrap().contains("without force"), "{output}");
    // A law that is not selected confirms nothing.
    let output = ask(&here, &format!("{on_body} --order 2 --laws equivariance"), "variational.py").ends(3);
    assert_eq!(summary(&output)["claims"][0]["why"], "method-order is not among the selected laws");
    // Where nothing can be drawn nothing is learnt.
    let none = probe(&here, "--algebras r3 --laws order --cases 1", &["true"]).ends(3);
    none.prints("the options exclude every system");
}

/// The largest entry of `mu` and `g`.
fn largest(values: &Value) -> f64 {
    let lists = ["mu", "g"].iter().filter_map(|key| values[*key].as_array());
    lists.flatten().map(|x| x.as_f64().unwrap().abs()).fold(0.0, f64::max)
}

#[test]
fn the_system_that_breaks_is_shown_and_saved() {
    let Some(here) = with_python("the_system_that_breaks_is_shown_and_saved") else { return };
    // Wrong in a force that this body does not have: it shows order 4, and where 3 is claimed others are asked.
    let drag = "[[force]]\nkind = \"linear-drag\"\ncoefficient = \"1/4\"\n\n";
    fs::write(here.join("body.toml"), generic("[[force]]", "[method]", drag)).unwrap();
    let wrong = changed(&here, "rk4.py", &[("term[\"alpha\"] * x", "1.5 * term[\"alpha\"] * x")]);
    let output = ask(&here, "--system body.toml --order 3 --laws order --format json", &wrong).ends(1);
    let failure = failure(&output);
    assert_eq!((&failure["varied"], &failure["checks"]), (&true.into(), &Value::Null));
    let forces = failure["case"]["force"].as_array().unwrap();
    assert!(forces.iter().any(|force| force["kind"] == "double-bracket"), "{failure}");
    let slopes = &failure["slopes"][0];
    assert!(slopes["interval"][1].as_f64().unwrap() < 2.75, "{slopes}");
    let levels = slopes["levels"].as_array().unwrap();
    assert!(levels.iter().any(|level| level["mark"] == "counts" && level["order"].is_number()), "{slopes}");
    let exchange = &failure["exchange"];
    assert!(request(&failure).contains("double-bracket"), "{exchange}");
    assert!(largest(&exchange["difference"]) > 1e-6 * largest(&exchange["solution"]), "{exchange}");
    // The record has all of it, and is broken by itself.
    let saved = failure["saved"].as_str().unwrap();
    let record: Value = serde_json::from_str(&fs::read_to_string(here.join(saved)).unwrap()).unwrap();
    for key in ["case", "slopes", "exchange"] {
        assert_eq!(record[key], failure[key], "{key}");
    }
    let again = replayed(&here, &format!("{saved} --format json")).ends(1);
    let again: Value = serde_json::from_str(stdout(&again).trim()).unwrap();
    assert_eq!((&again["schema"], &again["verdict"]), (&"probe-replay/1".into(), &"broken".into()));
    assert_eq!(again["failure"]["varied"], false, "it is not a variation that breaks");
    let text = replayed(&here, saved);
    text.prints("claim ¦ order 3 ¦ errors ( ¦ answer less solution ¦ double-bracket");
}

#[test]
fn shrinking_is_limited_or_off() {
    let Some(here) = with_python("shrinking_is_limited_or_off") else { return };
    // Of order 0, whatever the system.
    let wrong = changed(&here, "rk4.py", &[("(k2, h / 3)", "(k2, h / 3.5)")]);
    let run = |options: &str| {
        let drawn = "--algebras so3 --cases 1 --laws order --order 4 --format json";
        failure(&ask(&here, &format!("{drawn} {options}"), &wrong).ends(1))
    };
    let (shrunk, limited, off) = (run(""), run("--shrink 0.001"), run("--shrink 0"));
    let checks = |failure: &Value| failure["checks"].as_u64();
    assert!(checks(&shrunk).is_some_and(|checks| (1..=60).contains(&checks)), "{shrunk}");
    assert!(checks(&limited).is_some_and(|few| few <= 1), "{limited}");
    assert_eq!(checks(&off), None);
    assert_ne!(off["case"], shrunk["case"]);
    // The simpler system moves, and the answer is off the solution.
    let exchange = &shrunk["exchange"];
    assert!(largest(&exchange["difference"]) > 1e-6 * largest(&exchange["solution"]), "{exchange}");
}

#[test]
fn a_record_is_replayed_by_either_command() {
    let Some(here) = with_python("a_record_is_replayed_by_either_command") else { return };
    let output = ask(&here, &format!("{SMALL} --laws equivariance --shrink 0"), "variational.py left");
    let saved = saved(&output);
    run(&here, &["replay", &saved]).ends(1).prints("after a left translation of g");
    run(&here, &["replay", &saved, "--shrink"]).ends(2).says("`probe` saved this file");
    // Mended, it holds; where it does not apply there is no verdict.
    let replay = format!("--replay {saved}");
    ask(&here, &replay, "variational.py").ends(0);
    let refuses = "while read line; do echo '{\"unsupported\":\"all\"}'; done";
    probe(&here, &replay, &["sh", "-c", refuses]).ends(3);
    // What `verify` saved is for the other command, and this is said.
    let case = serde_json::to_value(problem::generic().unwrap().case).unwrap();
    let record = serde_json::json!({ "law": "plain-step", "seed": 1, "index": 0, "case": case });
    fs::write(here.join("verify.json"), record.to_string()).unwrap();
    replayed(&here, "verify.json").ends(2).says("euler-poincare replay verify.json");
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_is_known_and_leaves_nothing_running() {
    for (signal, format) in [("-INT", "json"), ("-TERM", "text")] {
        let here = directory(&format!("interrupt{signal}"));
        // Twenty answers, and then it hangs.
        let script = "n=0; while read line; do n=$((n+1)); if [ $n -gt 20 ]; then sleep 100 & echo $$ $! > pids; wait; fi; \
                      echo '{\"unsupported\":\"all\"}'; done";
        let options = ["probe", "--algebras", "so3", "--cases", "30", "--timeout", "100", "--laws", "equivariance"];
        let stepper = ["--format", format, "--", "sh", "-c", script];
        let child = started(&here, &[&options[..], &stepper].concat());
        let mut pids = String::new();
        wait_for(|| {
            pids = fs::read_to_string(here.join("pids")).unwrap_or_default();
            pids.ends_with('\n')
        });
        let start = Instant::now();
        let output = stopped(child, signal).ends(130);
        assert!(start.elapsed() < Duration::from_secs(10), "{:?}", start.elapsed());
        if format == "json" {
            assert_eq!(first(&output)["cases"], 20, "the case under way is not counted");
            assert_eq!(summary(&output)["conclusion"], "interrupted");
        } else {
            output.prints("INTERRUPTED, NOTHING BROKEN so far: 1 law on 20 cases");
        }
        std::thread::sleep(Duration::from_millis(100));
        assert!(!pids.split_whitespace().any(lives), "{pids}");
    }
}

#[test]
fn the_record_of_another_program_is_not_written_over() {
    let Some(here) = with_python("the_record_of_another_program_is_not_written_over") else { return };
    let options = "--order 2 --algebras so3 --laws order --cases 1 --shrink 0 --seed 3";
    for mistake in ["frozen", "adjoint", "frozen"] {
        ask(&here, options, &format!("variational.py {mistake}")).ends(1);
    }
    let (first, second) = ("probe-method-order-seed3-case0.json", "probe-method-order-seed3-case0-2.json");
    for (file, mistake) in [(first, "frozen"), (second, "adjoint")] {
        let record = Record::from_json(&fs::read_to_string(here.join(file)).unwrap()).unwrap();
        assert_eq!(record.command.last().unwrap(), mistake, "{file}");
    }
    assert_eq!(fs::read_dir(&here).unwrap().count(), 2);
}

#[test]
fn a_record_that_cannot_be_written_is_named_with_the_reason() {
    let here = directory("probe-not-saved");
    let name = "probe-method-equivariance-seed1-case0.json";
    fs::create_dir(here.join(name)).unwrap();
    let options = "--algebras so3 --cases 1 --laws equivariance";
    let stepper = ["sh", "-c", "while read line; do echo 7; done"];
    probe(&here, options, &stepper).ends(1).prints(&format!("not saved: {name}: "));
    let output = probe(&here, &format!("{options} --format json"), &stepper);
    let failure = &first(&output)["program_failure"];
    assert!(failure["saved"].is_null() && failure["not_saved"].as_str().unwrap().starts_with(name), "{failure}");
}

#[test]
fn what_is_not_supported_is_counted_and_no_verdict() {
    let Some(here) = with_python("what_is_not_supported_is_counted_and_no_verdict") else { return };
    // It does not say once what it supports.
    let body = changed(&here, "rigid_body.py", &[("number == 0", "number < 0")]);
    let output = ask(&here, "--algebras se3 --cases 3 --format json", &body).ends(3);
    for (law, line) in laws(&output) {
        let reasons = line["not_applicable"].as_object().unwrap();
        assert_eq!(reasons.values().map(|count| count.as_u64().unwrap()).sum::<u64>(), 3, "{law}");
        assert!(reasons.keys().any(|why| why.contains("free rigid body")), "{law}: {reasons:?}");
    }
    assert!(summary(&output)["supports"].is_null());
    // Nothing is judged: the stepper is told how to say once what it supports.
    let text = ask(&here, "--algebras se3 --cases 3", &body);
    let text = stdout(&text);
    assert!(text.starts_with("NO VERDICT, the stepper supports none of the systems: "), "{text}");
    assert!(text.contains("did not say what it supports") && text.contains("{\"supports\": {…}}"), "{text}");
    let free = "--algebras so3 --standard-basis --force-free --cases 30 --format json";
    ask(&here, &format!("{free} --laws casimirs,energy,reversibility"), &body).ends(0);
}

#[test]
fn cases_are_drawn_of_what_a_stepper_supports() {
    let Some(here) = with_python("cases_are_drawn_of_what_a_stepper_supports") else { return };
    for (stepper, options) in [
        ("rigid_body.py", "--order 4"),
        ("sphere.py", "--order 2"),
        ("sphere.py momentum", "--order 2"),
        ("variational.py", "--order 2 --algebras so3,se2"),
    ] {
        let laws_of = "order,casimirs,energy,reversibility,momentum,equivariance";
        let output = ask(&here, &format!("--cases 4 --laws {laws_of} --format json {options}"), stepper).ends(0);
        assert!(summary(&output)["supports"].as_object().is_some_and(|keys| !keys.is_empty()), "{stepper}");
        for (law, line) in laws(&output) {
            assert_eq!(line["cases"], 4, "{stepper} {law}: {line}");
            let refused = line["not_applicable"].as_object().unwrap();
            // A state without an attitude has no spatial momentum.
            let expected = law == "method-momentum" && stepper.starts_with("sphere.py");
            assert_eq!(refused.is_empty(), !expected, "{stepper} {law}: {line}");
            assert!(!refused.keys().any(|why| why.contains("anything but")), "{stepper} {law}: {line}");
        }
    }
}

#[test]
fn a_stepper_may_say_what_it_supports_in_the_place_of_an_answer() {
    let Some(here) = with_python("a_stepper_may_say_what_it_supports_in_the_place_of_an_answer") else { return };
    let alone = ("answer[\"supports\"] = SUPPORTS", "answer = {\"supports\": SUPPORTS}");
    let stepper = changed(&here, "sphere.py", &[alone]);
    ask(&here, "--order 2 --laws order --cases 2", &stepper).ends(0);
    // One system, and one that it does not support.
    for (algebra, expected) in [("so3", 0), ("sl2", 3)] {
        fs::write(here.join("body.toml"), rigid_body("").replace("so3", algebra)).unwrap();
        ask(&here, "--system body.toml --order 2 --laws order", &stepper).ends(expected);
    }
    // Words that are misspelt do not restrict silently.
    for (wrong, said) in [
        ("{\"algebra\": [\"so3\"]}", "unknown field `algebra`"),
        ("{\"algebras\": [\"so5\"]}", "so5"),
        ("{\"forces\": [\"drag\"]}", "a force"),
        ("{\"state\": {\"point\": [0, 0, 0]}}", "a point that is 0"),
    ] {
        let script = format!("while read line; do echo '{{\"supports\": {wrong}}}'; done");
        let output = probe(&here, "--laws equivariance --cases 1", &["sh", "-c", &script]).ends(1);
        output.prints(&format!("in the stepper's answer ¦ {said}"));
    }
}

#[test]
fn states_without_an_attitude_are_judged() {
    let Some(here) = with_python("states_without_an_attitude_are_judged") else { return };
    let claims = "--order 2 --conserves casimirs,poisson --cases 6 --format json";
    let output = ask(&here, claims, "sphere.py momentum");
    // A rotation by a midpoint rule that is explicit keeps the sphere, and not the area on it.
    assert_eq!((code(&output), broken(&output)), (1, vec!["method-poisson".into()]), "{output}");
    let order = "--order 2 --laws order --cases 6 --format json";
    let output = ask(&here, order, "sphere.py").ends(0);
    let orders = &first(&output)["orders"];
    assert_eq!([0, 1].map(|k| &orders[k]["quantity"]), ["momentum", "point"]);
    assert_eq!(orders.as_array().map(Vec::len), Some(2));
    let output = ask(&here, &format!("{order} --shrink 0"), "sphere.py frozen");
    assert_eq!((code(&output), broken(&output)), (1, vec!["method-order".into()]), "{output}");
    let failure = failure(&output);
    let slopes = &failure["slopes"][0];
    assert_eq!(slopes["quantity"], "point");
    assert!((slopes["order"].as_f64().unwrap() - 1.0).abs() < 0.1, "{slopes}");
    assert_eq!(failure["exchange"]["solution"]["x"].as_array().map(Vec::len), Some(3), "{failure}");
}

/// What sh does instead of a stepper, and what is said of it.
const MISBEHAVING: [(&str, &str); 19] = [
    ("sleep 100", "no answer from the stepper within 2 s"),
    ("cat > /dev/null", "no answer"),
    ("exit 3", "ended (exit status: 3)"),
    ("read line; kill -9 $$", "ended (signal: 9"),
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
    ("read line; yes | tr -d '\\n'", "writes too much to its standard output"),
    ("read line; yes >&2", "writes too much to its standard error"),
    ("echo '{}'; cat > /dev/null", "answers before it is asked"),
    ("read line; printf '{\"mu\":'; sleep 100", "without a newline: {\"mu\":"),
];

#[test]
fn programs_that_are_no_steppers_are_reported_in_time() {
    let here = directory("misbehaving");
    for (script, said) in MISBEHAVING {
        // Those that do not answer hang for the whole time; the others have as much as a busy machine may need.
        let hangs = script.starts_with("cat") || script.contains("sleep 100");
        let timeout = if hangs { "2" } else { "30" };
        let drawn = "--algebras so3 --cases 1 --laws equivariance --format json";
        let options = format!("{drawn} --timeout {timeout} --startup 0");
        let start = Instant::now();
        let output = probe(&here, &options, &["sh", "-c", script]).ends(1);
        assert!(start.elapsed() < Duration::from_secs(20), "{script}: {:?}", start.elapsed());
        let line = first(&output);
        assert_eq!((&line["broken"], &line["failed"]), (&0.into(), &1.into()), "{script}: {line}");
        let failure = &line["program_failure"];
        let witness = failure["witness"].as_str().unwrap();
        // What is written before the request may arrive after it: then it is the answer, and a bad one.
        let late = script.starts_with("echo '{}'") && witness.contains("has no \"mu\"");
        assert!(witness.contains(said) || late, "{script}: {witness}");
        assert_eq!(failure["failed"], true, "{script}");
        let request = request(failure);
        assert!(request.starts_with("{\"version\":1,") && request.contains("\"mu\":["), "{script}: {request}");
    }
}

#[test]
fn a_program_that_goes_on_failing_is_given_up() {
    let here = directory("given-up");
    // What it needs to start is given once.
    let options = "--algebras so3 --cases 50 --timeout 0.2 --startup 1";
    let start = Instant::now();
    let output = probe(&here, options, &["sh", "-c", "sleep 100"]);
    assert!(start.elapsed() < Duration::from_secs(50), "{:?}", start.elapsed());
    output.ends(1).prints("failed 6 times and was not started again");
}

#[test]
fn a_program_has_time_to_start() {
    let Some(here) = with_python("a_program_has_time_to_start") else { return };
    let run = |sleeps: &str, startup: &str| {
        let script = format!("sleep {sleeps}; exec python3 {}", steppers("rigid_body.py"));
        let options = format!("--cases 1 --laws equivariance --timeout 2 --startup {startup}");
        probe(&here, &options, &["sh", "-c", &script])
    };
    run("4", "30").ends(0);
    run("100", "1").ends(1).prints("within 3 s (1 s of them to start)");
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
    // On a busy machine the shell may not have begun in a fraction of a second.
    let pids = [300, 3_000, 30_000].into_iter().find_map(|milliseconds| {
        let (timeout, startup) = (Duration::from_millis(milliseconds), Duration::ZERO);
        let limits = Limits { timeout, startup, ..Limits::default() };
        let mut program = Program::new(&["sh".into(), "-c".into(), script.clone()], limits);
        assert!(matches!(program.ask("{}"), Err(Silence::Hung { .. })));
        fs::read_to_string(&file).ok().filter(|pids| pids.ends_with('\n'))
    });
    let pids = pids.expect("the shell has begun");
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(pids.split_whitespace().count(), 2);
    assert!(!pids.split_whitespace().any(lives), "{pids}");
    // Where nobody waits for a child it stays as a zombie: ours are waited for.
    let child = format!(") Z {} ", std::process::id());
    let zombie = |pid: &String| fs::read_to_string(format!("/proc/{pid}/stat")).is_ok_and(|stat| stat.contains(&child));
    let names = fs::read_dir("/proc").unwrap().flatten().map(|entry| entry.file_name().to_string_lossy().into_owned());
    // Other tests of this process may have one for a moment.
    let first: Vec<String> = names.filter(zombie).collect();
    std::thread::sleep(Duration::from_millis(300));
    assert!(!first.iter().any(zombie), "{first:?}");
}

#[test]
fn bad_usage_is_two_and_says_what_is_allowed() {
    let here = directory("probe-usage");
    fs::write(here.join("bad.json"), "{\"law\": 1}").unwrap();
    fs::write(here.join("bad.toml"), "format = 2").unwrap();
    let bad = "--system bad.toml";
    let rows = [
        ("", "", "after `--`"),
        ("", "no-such-program-anywhere", "cannot be started"),
        ("--laws no-such-law", "true", "method-order"),
        ("--algebras so5", "true", "so3"),
        ("--system no-such-file", "true", "no-such-file"),
        (bad, "true", "line 1"),
        ("--replay bad.json", "true", "line 1"),
        ("--timeout 0", "true", "0.001"),
        ("--order 0", "true", "1..=20"),
        ("--conserves mass", "true", "casimirs"),
        ("--system .", "true", "is a directory"),
        ("--shrink -1", "true", "a number from 0"),
    ];
    for (options, stepper, said) in rows {
        let stepper: Vec<&str> = stepper.split_whitespace().collect();
        probe(&here, options, &stepper).ends(2).says(said);
    }
    run(&here, &["probe", "--system", "", "--", "true"]).ends(2).says("a value is required");
    // What would have no effect.
    let replay = "--replay bad.json";
    for (option, without_effect) in [
        (bad, "--random; --cases 20; --seed 1; --algebras so3; --shrink 1"),
        (replay, "--system bad.toml; --cases 20; --tolerance 0; --laws order; --shrink 0"),
    ] {
        for other in without_effect.split("; ") {
            probe(&here, &format!("{option} {other}"), &["true"]).ends(2).says("cannot be used with");
        }
    }
}

#[test]
fn the_stepper_in_rust_holds() {
    let path = Path::new(env!("CARGO_BIN_EXE_euler-poincare")).with_file_name("examples").join("gauss");
    if !path.exists() {
        return not_run("the_stepper_in_rust_holds", "the example `gauss` is not built");
    }
    let here = directory("rust");
    let options = "--order 4 --conserves casimirs --algebras so3,se3,aff1,sl2 --cases 6 --format json";
    let output = probe(&here, options, &[path.to_str().unwrap()]).ends(0);
    assert!(laws(&output).iter().all(|(_, line)| line["held"].as_u64() > Some(0)), "{output}");
}

/// Those in C++ and Julia, where these are installed.
#[test]
fn the_templates_hold() {
    let here = directory("templates");
    let program = here.join("stepper");
    let [program, julia] = [program.to_str().unwrap().to_owned(), steppers("template.jl")];
    let mut commands: Vec<Vec<&str>> = Vec::new();
    if there("c++") {
        let source = steppers("template.cpp");
        let built = Command::new("c++").args(["-std=c++17", "-Wall", "-Werror", &source, "-o", &program]).status();
        assert!(built.unwrap().success());
        commands.push(vec![&program]);
    } else {
        not_run("the_templates_hold", "there is no c++");
    }
    if there("julia") {
        commands.push(vec!["julia", &julia]);
    } else {
        not_run("the_templates_hold", "there is no julia");
    }
    for command in commands {
        probe(&here, "--order 4 --cases 4 --format json", &command).ends(0);
        probe(&here, "--order 3 --cases 2 --laws order --format json", &command).ends(1);
    }
}

#[test]
fn a_program_that_fails_before_it_says_what_it_supports_is_told_how() {
    let here = directory("untold");
    let script = |first: &str| format!("read line; {first}; while read line; do exit 3; done");
    let ask = |script: &str| probe(&here, "--laws equivariance --cases 2", &["sh", "-c", script]);
    ask(&script("exit 3")).prints("did not say what it supports");
    let told = script("echo '{\"supports\": {\"algebras\": [\"so3\"]}}'");
    let text = ask(&told);
    let text = stdout(&text);
    assert!(text.contains("The program failed on") && !text.contains("did not say what it supports"), "{text}");
}

/// The request and the first answer of the protocol's page.
#[test]
fn the_example_of_the_protocol_is_an_answer() {
    let Some(_) = with_python("the_example_of_the_protocol_is_an_answer") else { return };
    let page = fs::read_to_string(steppers("PROTOCOL.md")).unwrap();
    let line = |start: &str| page.lines().find(|line| line.starts_with(start)).unwrap().to_owned();
    let mut program = Program::new(&["python3".into(), steppers("rigid_body.py")], Limits::default());
    let answer = program.ask(&line("{\"version\":1")).unwrap();
    assert_eq!(parse(&answer, 3, 9), parse(line("{\"mu\": [0.4").as_bytes(), 3, 9));
}

/// What steppers support; the first is nothing.
const SUPPORTED: [&str; 12] = [
    r#"{"algebras": []}"#,
    r#"{"algebras": ["so3", "se3"], "standard_basis": true, "quartic": false, "forces": ["constant"]}"#,
    r#"{"dimensions": [2, 3, 6], "diagonal_inertia": true}"#,
    r#"{"forces": [], "positive_steps": true}"#,
    r#"{"algebras": ["so3"], "forces": ["double-bracket", "orbit"], "state": "momentum"}"#,
    r#"{"state": {"point": [0, 0, 1]}}"#,
    r#"{"algebras": ["so3", "se3"], "forces": [], "potentials": ["gravity", "uniform-field"]}"#,
    r#"{"potentials": ["formula", "gravity", "buoyancy", "uniform-field", "gravity-gradient"], "diagonal_inertia": true}"#,
    r#"{"state": {"point": [1, 0, 0, 1]}, "diagonal_inertia": true, "quartic": false}"#,
    r#"{"algebras": ["so3", "se3"], "standard_basis": true, "physical_inertia": true, "drag": "scalar"}"#,
    r#"{"algebras": ["se3"], "standard_basis": true, "physical_inertia": true, "diagonal_inertia": true, "potentials": ["gravity"]}"#,
    r#"{"forces": ["linear-drag", "quadratic-drag"], "drag": "diagonal"}"#,
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// A request carries all digits, finite numbers only, and potentials in version 3, whatever the group.
    #[test]
    fn requests_are_one_line_of_json_with_all_digits(case in cases().potentials(&Potential::KINDS), h in -1.0..1.0f64) {
        let described = Described::of(&case).unwrap();
        let theory = euler_poincare::laws::method::theory_of::<f64>(&case, &StateForm::default()).unwrap();
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
        let list = |key: &str| -> Vec<f64> { value[key].as_array().into_iter().flatten().map(|x| x.as_f64().unwrap()).collect() };
        prop_assert_eq!((list("mu"), list("g")), (start.momentum.clone(), start.attitude.clone()));
        let kind = case.potentials.first().map_or(Value::Null, |potential| potential.kind().into());
        prop_assert_eq!((&value["potential"][0]["kind"], value["version"] == 3), (&kind, !kind.is_null()));
        // At rest quadratic drag has no second derivative.
        let rough = case.forces.iter().any(|force| matches!(force, Force::QuadraticDrag(_)));
        let (Motion::Velocity(motion) | Motion::Momentum(motion)) = &case.start.motion;
        let rests = motion.iter().all(|x| x.eval::<f64>().unwrap() == 0.0);
        prop_assert!(theory.pace(&start).is_finite() || (rough && rests));
    }

    /// What is drawn for a stepper is what it supports.
    #[test]
    fn what_is_supported_is_drawn(index in 0..SUPPORTED.len(), seed in any::<u64>()) {
        let supports = Supports::parse(SUPPORTED[index]).unwrap();
        for law in LAWS {
            let strategy = law.cases(supports.cases(cases().kinetic())).boxed();
            let Ok((case, _)) = draw(&strategy, seed, law.about.name, 0).case else {
                prop_assert!(index == 0, "{}: nothing is drawn", law.about.name);
                continue;
            };
            prop_assert!(supports.admits(&case), "{case}");
            prop_assert!(!supports.positive_steps || case.step.eval::<f64>().unwrap() > 0.0);
        }
    }

    /// No line of bytes makes the reader panic.
    #[test]
    fn any_bytes_are_an_answer_or_refused(line in proptest::collection::vec(any::<u8>(), 0..200), n in 0..9usize) {
        let _ = parse(&line, n, n * n);
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
        exchange: None,
        slopes: Vec::new(),
    };
    let text = record.to_json().unwrap();
    assert_eq!(Record::from_json(&text).unwrap(), record);
    for (old, new) in [("0.5", "-1.0"), ("\"command\"", "\"commands\""), ("so3", "so5"), ("{", "")] {
        assert!(Record::from_json(&text.replacen(old, new, 1)).is_err(), "{new}");
    }
}
