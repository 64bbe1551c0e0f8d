//! Properties of `order`: what it prints and with which code it ends, for names, files, systems and bad input.

use super::{code, directory, run, stderr, stdout};
use euler_poincare::study::problem;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The object that `order` prints, and its exit code.
fn order(here: &Path, arguments: &[&str]) -> (Value, i32) {
    let arguments = [&["order", "--format", "json"], arguments].concat();
    let output = run(here, &arguments);
    let text = stdout(&output);
    assert_eq!(text.lines().count(), 1, "{arguments:?}: {text}{}", stderr(&output));
    (serde_json::from_str(text).unwrap(), code(&output))
}

fn numbers(found: &Value) -> [Option<i64>; 3] {
    ["declared", "classical", "variational"].map(|key| found[key].as_i64())
}

#[test]
fn names_give_the_orders_of_the_theory() {
    let here = directory("order-names");
    let table = [
        ("rk4", [4, 4, 4]),
        ("kutta38", [4, 4, 4]),
        ("ralston3", [3, 3, 2]),
        ("heun2", [2, 2, 2]),
        ("sdirk2", [3, 3, 3]),
        ("gauss-3", [6, 6, 6]),
        ("lobatto-iiia-3", [4, 4, 4]),
        ("lobatto-iiib-2", [2, 2, 2]),
        ("lobatto-iiic-4", [6, 6, 6]),
        ("radau-ia-2", [3, 3, 3]),
        ("radau-iia-3", [5, 5, 5]),
    ];
    for (name, orders) in table {
        let (found, code) = order(&here, &["--tableau", name]);
        assert_eq!((code, found["verdict"].as_str()), (0, Some("confirmed")), "{name}: {found}");
        assert_eq!(numbers(&found), orders.map(Some), "{name}");
        assert_eq!(found["declared_holds"].as_bool(), Some(orders[0] == orders[2]), "{name}");
        assert_eq!(found["tableau"].as_str(), Some(name));
        let [slope, low, high] = ["slope", "low", "high"].map(|key| found["empirical"][key].as_f64().unwrap());
        assert!(low <= slope && slope <= high && (slope - orders[2] as f64).abs() < 0.05, "{name}: {slope}");
        assert!(!found["failing_trees"].as_array().unwrap().is_empty(), "{name}");
        assert_eq!(found["warnings"].as_array().unwrap().len(), 0, "{name}");
    }
}

#[test]
fn gauss_6_in_64_digits_has_order_12() {
    let here = directory("order-64");
    let (found, code) = order(&here, &["--tableau", "gauss-6", "--digits", "64"]);
    assert_eq!((code, numbers(&found)), (0, [Some(12); 3]));
    let slope = found["empirical"]["slope"].as_f64().unwrap();
    assert!((slope - 12.0).abs() < 0.05, "{slope}");
}

#[test]
fn too_few_digits_are_inconclusive() {
    let here = directory("order-16");
    let (found, code) = order(&here, &["--tableau", "gauss-6", "--digits", "16"]);
    assert_eq!((code, found["verdict"].as_str()), (3, Some("inconclusive")), "{found}");
    assert!(found["why"].as_str().is_some());
    let (_, code) = order(&here, &["--tableau", "gauss-2", "--digits", "16"]);
    assert_eq!(code, 0);
}

#[test]
fn text_says_why() {
    let here = directory("order-text");
    let output = run(&here, &["order", "--tableau", "ralston3", "--plot", "work.svg"]);
    let text = stdout(&output);
    for part in [
        "holds for a Runge-Kutta method, not for this scheme",
        "confirmed: the order is 2",
        "D(1) fails",
        "= 1/3, is",
        "Conditions of variational order 3 that fail",
        "momentum",
        "attitude",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(text.lines().all(|line| line.chars().count() <= 120), "{text}");
    let svg = fs::read_to_string(here.join("work.svg")).unwrap();
    assert!(super::page::drawn(&svg).contains("order 2."), "{}", &svg[..200]);
}

#[test]
fn files_are_judged_by_what_they_hold() {
    let here = directory("order-files");
    let write = |name: &str, text: &str| fs::write(here.join(name), text).unwrap();
    // A wrong label: Kutta's third-order method called a fourth-order one.
    write("label.toml", "order = 4\na = [[0, 0, 0], [\"1/2\", 0, 0], [-1, 2, 0]]\nb = [\"1/6\", \"2/3\", \"1/6\"]\n");
    let (found, code) = order(&here, &["--tableau", "label.toml"]);
    assert_eq!((code, numbers(&found)), (0, [Some(4), Some(3), Some(3)]), "{found}");
    assert_eq!(found["declared_holds"].as_bool(), Some(false));
    let (found, _) = order(&here, &["--tableau", "label.toml", "--declared", "3"]);
    assert_eq!(found["declared_holds"].as_bool(), Some(true));
    // The same in JSON, off by a millionth in one coefficient.
    write(
        "off.json",
        "{\"order\": 3, \"a\": [[0,0,0],[\"1/2\",0,0],[\"-1+1/1000000\",2,0]], \"b\": [\"1/6\",\"2/3\",\"1/6\"]}",
    );
    let (found, code) = order(&here, &["--tableau", "off.json"]);
    assert_eq!((code, numbers(&found)), (0, [Some(3), Some(1), Some(1)]), "{found}");
    assert_eq!(found["declared_holds"].as_bool(), Some(false));
    assert!((found["empirical"]["slope"].as_f64().unwrap() - 1.0).abs() < 0.05, "{found}");
    // Rounded decimals: order 4 to the digits given; in 16 digits that is all that shows.
    write(
        "gauss.toml",
        "order = 4\na = [[0.25, -0.0386751346], [0.5386751346, 0.25]]\nb = [0.5, 0.5]\nc = [0.2113248654, 0.7886751346]\n",
    );
    let (found, code) = order(&here, &["--tableau", "gauss.toml"]);
    assert_eq!((code, numbers(&found)), (0, [Some(4); 3]), "{found}");
    assert_eq!(found["exact"]["variational"].as_i64(), Some(2), "{found}");
    assert_eq!(found["declared_holds"].as_bool(), Some(true));
    let (found, code) = order(&here, &["--tableau", "gauss.toml", "--digits", "16"]);
    assert_eq!(code, 0, "{found}");
    assert!((found["empirical"]["slope"].as_f64().unwrap() - 4.0).abs() < 0.1, "{found}");
    // Gauss-3 to eight digits: 32 digits see that it is none, 16 do not confirm it wrongly either.
    write(
        "gauss-3.toml",
        "order = 6\na = [[0.13888889, -0.03597667, 0.00978944], [0.30026319, 0.22222222, -0.02248542],\n\
         [0.26798833, 0.48042111, 0.13888889]]\nb = [0.27777778, 0.44444444, 0.27777778]\n",
    );
    let (found, code) = order(&here, &["--tableau", "gauss-3.toml"]);
    assert_eq!((code, numbers(&found)), (1, [Some(6); 3]), "{found}");
    assert!(found["exact"]["variational"].as_i64().unwrap() <= 2, "{found}");
    assert!(found["notes"].to_string().contains("their rounding shows"), "{found}");
    let (found, code) = order(&here, &["--tableau", "gauss-3.toml", "--digits", "16"]);
    assert_ne!(code, 2, "{found}");
    // The digits of an f64 are judged in f64, unless another arithmetic is asked for.
    let digits = "a = [[0.25, -0.03867513459481288], [0.5386751345948129, 0.25]]\nb = [0.5, 0.5]\n";
    write("double.toml", digits);
    let (found, code) = order(&here, &["--tableau", "double.toml"]);
    assert_eq!((code, found["digits"].as_i64(), found["variational"].as_i64()), (0, Some(16), Some(4)), "{found}");
    // Weights that sum to 1 to the digits given.
    write("thirds.toml", "a = [[0, 0, 0], [0.5, 0, 0], [0, 1, 0]]\nb = [0.3333, 0.3333, 0.3333]\n");
    let (found, _) = order(&here, &["--tableau", "thirds.toml"]);
    assert!(found["notes"].to_string().contains("divided by their sum"), "{found}");
}

#[test]
fn systems_that_hide_are_named() {
    let here = directory("order-systems");
    let system = |algebra: &str, inertia: &str, force: &str| {
        format!(
            "format = 1\n[algebra]\nname = \"{algebra}\"\n[lagrangian]\ninertia = {inertia}\n{force}[method]\n\
             tableau = \"gauss-1\"\nretraction = \"cayley\"\n[state]\nvelocity = [0.5, 0.25, 0.75]\n[run]\nstep = 0.125\nsteps = 8\n"
        )
    };
    let drag = "[[force]]\nkind = \"linear-drag\"\ncoefficient = 0.5\n";
    fs::write(here.join("good.toml"), system("so3", "[0.5, 2, 1]", drag)).unwrap();
    let (found, code) = order(&here, &["--tableau", "sdirk2", "--system", "good.toml"]);
    assert_eq!((code, found["warnings"].as_array().unwrap().len()), (0, 0), "{found}");
    assert_eq!(found["system"].as_str(), Some("good.toml"));
    fs::write(here.join("free.toml"), system("so3", "[0.5, 2, 1]", "")).unwrap();
    let (found, code) = order(&here, &["--tableau", "sdirk2", "--system", "free.toml"]);
    assert_eq!((code, found["verdict"].as_str()), (3, Some("inconclusive")), "{found}");
    assert!(found["warnings"].to_string().contains("no-force"));
    assert!(found["warnings"].to_string().contains("super-convergence"));
    fs::write(here.join("flat.toml"), system("r3", "[0.5, 2, 1]", drag)).unwrap();
    let (found, _) = order(&here, &["--tableau", "rk4", "--system", "flat.toml"]);
    assert!(found["warnings"].to_string().contains("commuting"), "{found}");
}

#[test]
fn what_cannot_be_seen_is_not_refuted() {
    let here = directory("order-unseen");
    let write = |name: &str, text: &str| fs::write(here.join(name), text).unwrap();
    let exit = |arguments: &[&str]| {
        let (found, code) = order(&here, arguments);
        assert_eq!((code, found["verdict"].as_str()), (3, Some("inconclusive")), "{arguments:?}: {found}");
        found
    };
    // A coefficient off by 1e-20, as a fraction: the exact order is 1, and nothing less than 40 digits shows it.
    write(
        "tiny.toml",
        "a = [[0,0,0],[\"1/2\",0,0],[\"-1+1/100000000000000000000\",2,0]]\nb = [\"1/6\",\"2/3\",\"1/6\"]\n",
    );
    let found = exit(&["--tableau", "tiny.toml"]);
    assert_eq!(found["variational"].as_i64(), Some(1));
    let (found, code) = order(&here, &["--tableau", "tiny.toml", "--digits", "64"]);
    assert_eq!(code, 0, "{found}");
    // A time at which an f64 has lost the digits of a step.
    let late = problem::generic_text().replace("[state]\n", "[state]\ntime = 1e9\n");
    write("late.toml", &late);
    exit(&["--tableau", "rk4", "--digits", "16", "--system", "late.toml"]);
    assert_eq!(order(&here, &["--tableau", "rk4", "--system", "late.toml"]).1, 0);
    // A motion too fast for the reference, and one too slow for its horizon.
    let matrix = "matrix = [[\"1/4\", \"1/8\", 0], [\"-1/16\", \"3/8\", \"1/8\"], [\"1/16\", 0, \"1/8\"]]";
    write("stiff.toml", &problem::generic_text().replace(matrix, "coefficient = 20000"));
    let found = exit(&["--tableau", "gauss-1", "--system", "stiff.toml"]);
    assert_eq!((found["classical"].as_i64(), found["variational"].as_i64()), (Some(2), Some(2)));
    write("short.toml", &problem::generic_text().replace("step = \"1/8\"\nhorizon = 1", "step = 1e-9\nsteps = 8"));
    exit(&["--tableau", "rk4", "--system", "short.toml"]);
}

#[test]
fn the_plot_spares_what_is_read() {
    let here = directory("order-plot");
    fs::write(here.join("body.toml"), problem::generic_text()).unwrap();
    let output = run(&here, &["order", "--tableau", "rk4", "--system", "body.toml", "--plot", "body.toml"]);
    assert_eq!(code(&output), 2, "{}", stderr(&output));
    assert_eq!(fs::read_to_string(here.join("body.toml")).unwrap(), problem::generic_text());
    let output = run(&here, &["order", "--tableau", "rk4", "--plot", "missing/work.svg"]);
    assert_eq!((code(&output), stdout(&output)), (2, ""));
}

#[test]
fn bad_input_is_named() {
    let here = directory("order-bad");
    let refused = |arguments: &[&str], parts: &[&str]| {
        let output = run(&here, &[&["order"], arguments].concat());
        assert_eq!((code(&output), stdout(&output)), (2, ""), "{arguments:?}: {}", stderr(&output));
        for part in parts {
            assert!(stderr(&output).contains(part), "{arguments:?}: {part}: {}", stderr(&output));
        }
    };
    refused(&[], &["--tableau"]);
    refused(&["--tableau", "gauss-0"], &["gauss-0", "from 1 to 64"]);
    refused(&["--tableau", "rk5"], &["rk5", "rk4"]);
    refused(&["--tableau", "missing.toml"], &["missing.toml"]);
    refused(&["--tableau", "rk4", "--digits", "20"], &["16", "32", "64"]);
    let line = problem::generic_text().replace("\"so3\"", "\"r1\"");
    let (start, end) = (line.find("[lagrangian]").unwrap(), line.find("[method]").unwrap());
    let line = line.replace(&line[start..end], "[lagrangian]\ninertia = [1]\n");
    let (start, end) = (line.find("velocity").unwrap(), line.find("[run]").unwrap());
    fs::write(here.join("line.toml"), line.replace(&line[start..end], "velocity = [1]\n")).unwrap();
    refused(&["--tableau", "rk4", "--digits", "64", "--system", "line.toml"], &["--digits 32", "dimension"]);
    refused(&["--tableau", "rk4", "--declared", "0"], &["--declared"]);
    refused(&["--tableau", "rk4", "--system", "missing.toml"], &["missing.toml"]);
    let files: [(&str, &str, &[&str]); 9] = [
        ("square.toml", "a = [[0, 0], [1, 0], [1, 1]]\nb = [0.5, 0.5]", &["3 rows", "2 entries"]),
        ("row.toml", "a = [[0, 0], [1]]\nb = [0.5, 0.5]", &["row 2 of a has 1"]),
        ("zero.toml", "a = [[0, 0], [0.5, 0]]\nb = [0, 1]", &["b_1 = 0"]),
        ("text.toml", "a = [[0, \"x\"], [1, 0]]\nb = [0.5, 0.5]", &["a_12"]),
        ("nan.toml", "a = [[0, nan], [1, 0]]\nb = [0.5, 0.5]", &["a_12"]),
        ("true.toml", "a = [[0, 0], [1, 0]]\nb = [0.5, true]", &["b_2"]),
        ("sum.toml", "a = [[0, 0], [1, 0]]\nb = [0.5, 0.4]", &["sum to 0.9"]),
        ("key.toml", "a = [[0, 0], [1, 0]]\nb = [0.5, 0.5]\nd = 1", &["line 3", "d"]),
        ("empty.toml", "a = []\nb = []", &["at least one stage"]),
    ];
    for (name, text, parts) in files {
        fs::write(here.join(name), text).unwrap();
        refused(&["--tableau", name], &[&[name], parts].concat());
    }
}
