//! Properties of `order`: what it prints and with which code it ends, for names, files, systems and bad input.

use super::{code, directory, flat, generic, has_all, stdout, typed};
use euler_poincare::scalar::Dd;
use euler_poincare::study::problem;
use euler_poincare::tableau::Description;
use serde_json::Value;
use std::fs;
use std::path::Path;

/// The object that `order` prints for a tableau with options, and its exit code.
fn order(here: &Path, tableau: &str) -> (Value, i32) {
    let output = typed(here, &format!("order --format json --tableau {tableau}"));
    let text = stdout(&output);
    assert_eq!(text.lines().count(), 1, "{tableau}: {text}{output}");
    (serde_json::from_str(text).unwrap(), code(&output))
}

/// Declared, classical and variational.
fn numbers(found: &Value) -> [Option<i64>; 3] {
    [&found["declared"], &found["classical"]["order"], &found["variational"]["order"]].map(Value::as_i64)
}

/// The verdict and the exit code go together, in JSON and as text.
fn judged(here: &Path, tableau: &str) -> (String, Value) {
    let (found, exit) = order(here, tableau);
    let word = match exit {
        0 => "confirmed",
        1 => "refuted",
        3 => "inconclusive",
        _ => panic!("{tableau}: {exit}"),
    };
    assert_eq!(found["verdict"].as_str(), Some(word), "{tableau}: {found}");
    assert_eq!(found["why"].is_null(), exit == 0, "{tableau}: {found}");
    let output = typed(here, &format!("order --tableau {tableau}")).ends(exit);
    let text = stdout(&output);
    assert!(flat(text).starts_with(&format!("verdict {word}: ")), "{tableau}: {text}");
    (word.into(), found)
}

#[test]
fn names_give_the_orders_of_the_theory() {
    let here = directory("order-names");
    let table = [("rk4", [4, 4]), ("ralston3", [3, 2]), ("gauss-3", [6, 6])];
    for (name, [classical, variational]) in table {
        let (found, code) = order(&here, name);
        assert_eq!((code, found["verdict"].as_str()), (0, Some("confirmed")), "{name}: {found}");
        assert_eq!(found["schema"].as_str(), Some("order/1"));
        assert_eq!(numbers(&found), [None, Some(classical), Some(variational)], "{name}");
        assert!(found["declared_by"].is_null() && found["declared_holds"].is_null() && found["rounded"].is_null());
        assert_eq!(found["tableau"].as_str(), Some(name));
        let [slope, low, high] = ["slope", "low", "high"].map(|key| found["measured"][key].as_f64().unwrap());
        assert!(low <= slope && slope <= high && (slope - variational as f64).abs() < 0.05, "{name}: {slope}");
        assert!(!found["variational"]["failing"].as_array().unwrap().is_empty(), "{name}");
        assert_eq!(found["variational"]["at_least"].as_bool(), Some(false), "{name}");
        assert_eq!(found["warnings"].as_array().unwrap().len(), 0, "{name}");
    }
}

/// A declared order is the claim, for names and for files, whatever is measured.
#[test]
fn a_wrong_declared_order_is_refuted() {
    let here = directory("order-declared");
    for row in ["rk4 4 confirmed", "rk4 5 refuted", "rk4 3 refuted", "ralston3 2 confirmed", "gauss-2 200 refuted"] {
        let [tableau, declared, word] = row.split(' ').collect::<Vec<_>>().try_into().unwrap();
        let (found, json) = judged(&here, &format!("{tableau} --declared {declared}"));
        assert_eq!(found, word, "{row}: {json}");
        assert_eq!(json["declared"].as_i64().unwrap().to_string(), declared);
        assert_eq!(json["declared_by"].as_str(), Some("option"));
        assert_eq!(json["declared_holds"].as_bool(), Some(word == "confirmed"), "{row}");
    }
    // The order as a Runge–Kutta method is told from the order in this scheme.
    let (word, json) = judged(&here, "ralston3 --declared 3");
    assert_eq!((word.as_str(), &json["declared_holds"]), ("refuted", &false.into()));
    let why = "the declared order is 3, but the order is 2 in this scheme; 3 is the order as a Runge-Kutta method";
    assert_eq!(json["why"], why);
    has_all(&json["notes"].to_string(), "D(1) fails");
    // A system that hides the order does not save a wrong claim; a right one is confirmed on its variations.
    fs::write(here.join("free.toml"), generic("[[force]]", "[method]", "")).unwrap();
    let claim = |order: &str| judged(&here, &format!("sdirk2 --declared {order} --system free.toml")).0;
    assert_eq!(["3", "4"].map(claim), ["confirmed", "refuted"]);
}

/// Orders beyond the trees are exact where B, C and D prove them; to measure this one takes more than 32 digits.
#[test]
fn gauss_7_is_of_order_14() {
    let here = directory("order-gauss-7");
    let (found, exit) = order(&here, "gauss-7");
    assert_eq!((exit, numbers(&found)[1]), (3, Some(14)), "{}", found["why"]);
    assert_eq!(found["variational"]["at_least"].as_bool(), Some(false));
    let text = flat(stdout(&typed(&here, "order --tableau gauss-7 --declared 12 --digits 16").ends(1)));
    assert!(text.contains("variational 14 (from the coefficients, by B(14), C(7) and D(7))"), "{text}");
    assert!(!text.contains("at least") && !text.contains("although"), "{text}");
}

/// Digits that leave the order open: neither confirmed nor refuted, with and without a declared order.
#[test]
fn an_order_that_cannot_be_checked_is_inconclusive() {
    let here = directory("order-open");
    let file = decimals(&here, "gauss-13", 20, "");
    for (claimed, expected) in [("", (3, None)), ("--declared 26", (3, None)), ("--declared 27", (1, Some(false)))] {
        let (found, exit) = order(&here, &format!("{file} --digits 16 {claimed}"));
        assert_eq!((exit, found["declared_holds"].as_bool()), expected, "{claimed}");
    }
}

#[test]
fn too_few_digits_are_inconclusive() {
    let here = directory("order-16");
    for (tableau, word) in [("gauss-6", "inconclusive"), ("gauss-2", "confirmed")] {
        assert_eq!(judged(&here, &format!("{tableau} --digits 16")).0, word);
    }
}

#[test]
fn text_says_why() {
    let here = directory("order-text");
    // In short why the orders differ, without the conditions and the errors.
    let short = flat(stdout(&typed(&here, "order --tableau ralston3")));
    assert!(short.contains("D(1) fails") && short.contains("confirmed: the order is 2"), "{short}");
    assert!(!short.contains("Conditions of") && !short.contains("Errors after"), "{short}");
    let output = typed(&here, "order --tableau ralston3 --plot work.svg --verbose");
    let text = stdout(&output);
    let flat = flat(text);
    has_all(
        &flat,
        "declared none: the computed order is compared with the measured one ¦ classical 3 (exact, in rationals) ¦ \
         variational 2 (exact, in rationals) ¦ confirmed: the order is 2 ¦ D(1) fails ¦ = 1/3, is ¦ \
         Conditions of variational order 3 that fail ¦ momentum ¦ attitude",
    );
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
    let (word, found) = judged(&here, "label.toml");
    assert_eq!((word.as_str(), numbers(&found)), ("refuted", [Some(4), Some(3), Some(3)]), "{found}");
    assert_eq!((found["declared_holds"].as_bool(), found["declared_by"].as_str()), (Some(false), Some("file")));
    let (found, code) = order(&here, "label.toml --declared 3");
    assert_eq!((code, &found["declared_holds"], &found["declared_by"]), (0, &true.into(), &"option".into()));
    // The same in JSON, off by a millionth in one coefficient.
    write(
        "off.json",
        "{\"order\": 3, \"a\": [[0,0,0],[\"1/2\",0,0],[\"-1+1/1000000\",2,0]], \"b\": [\"1/6\",\"2/3\",\"1/6\"]}",
    );
    let (found, code) = order(&here, "off.json");
    assert_eq!((code, numbers(&found)), (1, [Some(3), Some(1), Some(1)]), "{found}");
    assert!((found["measured"]["slope"].as_f64().unwrap() - 1.0).abs() < 0.05, "{found}");
}

/// The file of a tableau, each entry to a number of places, that begins as given.
fn decimals(here: &Path, name: &str, places: usize, head: &str) -> String {
    let tableau = name.parse::<Description>().unwrap().build::<Dd>().unwrap();
    let decimal = |x: &Dd| format!("\"{x:.places$}\"");
    let row = |row: Vec<String>| format!("[{}]", row.join(", "));
    let rows: Vec<String> = tableau.a().row_iter().map(|r| row(r.iter().map(decimal).collect())).collect();
    let b = row(tableau.b().iter().map(decimal).collect());
    let file = format!("{name}-{places}.toml");
    fs::write(here.join(&file), format!("{head}a = {}\nb = {b}\n", row(rows))).unwrap();
    file
}

/// The verdict is that on the tableau which the digits round. Other tableaux and numbers of places are in `tableau/digits.rs`.
#[test]
fn rounded_decimals_are_judged_alike() {
    let here = directory("order-rounded");
    let file = decimals(&here, "gauss-3", 8, "order = 6\n");
    let (found, code) = order(&here, &file);
    assert_eq!((code, numbers(&found)), (0, [Some(6); 3]), "{found}");
    assert!(found["rounded"]["completion"]["moved"].as_f64() > Some(0.0), "{found}");
    has_all(
        &flat(stdout(&typed(&here, "order --tableau gauss-3-8.toml"))),
        "variational 6 (to the digits given; 1 with exactly these digits) ¦ confirmed: the order is 6, to the digits given ¦ \
         a_11 is a rounded decimal: it stands for an interval of half a unit of its last place ¦ \
         The classical order of exactly these digits is 1",
    );
    // A claim that is wrong stays wrong.
    let (found, code) = order(&here, "gauss-3-8.toml --declared 1");
    assert_eq!((code, found["declared_holds"].as_bool()), (1, Some(false)));
}

/// The help keeps to 80 columns where it can be read at once.
#[test]
fn the_explanation_fits_80_columns() {
    let here = directory("order-help");
    let output = typed(&here, "order --help");
    let text = stdout(&output);
    let explanation = &text[text.find("The orders:").unwrap()..];
    assert!(explanation.lines().all(|line| line.chars().count() <= 80), "{explanation}");
    has_all(explanation, "declared ¦ classical ¦ variational ¦ measured ¦ confirmed ¦ refuted ¦ inconclusive");
}

#[test]
fn systems_that_hide_are_named() {
    let here = directory("order-systems");
    fs::write(here.join("free.toml"), generic("[[force]]", "[method]", "")).unwrap();
    fs::write(here.join("flat.toml"), problem::generic_text().replace("\"so3\"", "\"r3\"")).unwrap();
    let (found, code) = order(&here, "sdirk2 --system free.toml");
    assert_eq!((code, &found["verdict"], &found["system"]), (0, &"confirmed".into(), &"free.toml".into()), "{found}");
    has_all(&found["warnings"].to_string(), "no-force ¦ super-convergence");
    let (found, _) = order(&here, "rk4 --system flat.toml");
    has_all(&found["warnings"].to_string(), "commuting");
}

#[test]
fn what_cannot_be_seen_is_not_refuted() {
    let here = directory("order-unseen");
    let write = |name: &str, text: &str| fs::write(here.join(name), text).unwrap();
    let exit = |tableau: &str| {
        let (found, code) = order(&here, tableau);
        assert_eq!((code, found["verdict"].as_str()), (3, Some("inconclusive")), "{tableau}: {found}");
        found
    };
    // A coefficient off by 1e-20, as a fraction: the exact order is 1, and nothing less than 40 digits shows it.
    write(
        "tiny.toml",
        "a = [[0,0,0],[\"1/2\",0,0],[\"-1+1/100000000000000000000\",2,0]]\nb = [\"1/6\",\"2/3\",\"1/6\"]\n",
    );
    let found = exit("tiny.toml");
    assert_eq!(found["variational"]["order"].as_i64(), Some(1));
    // A time at which an f64 has lost the digits of a step.
    let late = problem::generic_text().replace("[state]\n", "[state]\ntime = 1e9\n");
    write("late.toml", &late);
    exit("rk4 --digits 16 --system late.toml");
    assert_eq!(order(&here, "rk4 --system late.toml").1, 0);
    // A motion too fast for the reference, and one too slow for its horizon.
    let matrix = "matrix = [[\"1/4\", \"1/8\", 0], [\"-1/16\", \"3/8\", \"1/8\"], [\"1/16\", 0, \"1/8\"]]";
    write("stiff.toml", &problem::generic_text().replace(matrix, "coefficient = 20000"));
    let found = exit("gauss-1 --system stiff.toml");
    assert_eq!(numbers(&found), [None, Some(2), Some(2)]);
    write("short.toml", &problem::generic_text().replace("step = \"1/8\"\nhorizon = 1", "step = 1e-9\nsteps = 8"));
    exit("rk4 --system short.toml");
}

#[test]
fn the_plot_spares_what_is_read() {
    let here = directory("order-plot");
    fs::write(here.join("body"), problem::generic_text()).unwrap();
    typed(&here, "order --tableau rk4 --system body --plot ./body").ends(2).says("./body is read");
    assert_eq!(fs::read_to_string(here.join("body")).unwrap(), problem::generic_text());
    typed(&here, "order --tableau rk4 --plot missing/work.svg").refuses("");
}

#[test]
fn bad_input_is_named() {
    let here = directory("order-bad");
    // All that can be wrong with a file is in `tableau/files.rs`.
    fs::write(here.join("row.toml"), "a = [[0, 0], [1]]\nb = [0.5, 0.5]").unwrap();
    for (words, parts) in [
        ("", "--tableau"),
        ("--tableau gauss-0", "gauss-0 ¦ from 1 to 64"),
        ("--tableau rk5", "rk5 ¦ rk4"),
        ("--tableau missing.toml", "missing.toml"),
        ("--tableau rk4 --digits 20", "16 ¦ 32"),
        ("--tableau rk4 --declared 0", "--declared"),
        ("--tableau rk4 --system missing.toml", "missing.toml"),
        ("--tableau row.toml", "row.toml ¦ row 2 of a has 1"),
    ] {
        typed(&here, &format!("order {words}")).refuses(parts);
    }
}
