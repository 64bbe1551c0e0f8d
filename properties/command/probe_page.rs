//! Properties of `probe --report`: the page about a stepper.

use super::page::{complete, fits};
use super::probe::{rigid_body, steppers, with_python};
use super::{directory, has_all, run};
use std::fs;
use std::path::Path;

const SECTIONS: [&str; 6] = ["verdicts", "claims", "orders", "undecided", "failures", "again"];

/// The page of a run, which ends with this code.
fn page(here: &Path, options: &str, stepper: &[&str], expected: i32) -> String {
    let options: Vec<&str> = options.split(' ').collect();
    run(here, &[&["probe", "--report", "out"], &options[..], &["--"], stepper].concat()).ends(expected);
    let page = fs::read_to_string(here.join("out/report.html")).unwrap();
    assert!(!page.contains("<script") && page.contains("default-src 'none'; style-src 'unsafe-inline'\""));
    page
}

/// Small systems without force, where a step in Python is quick.
const SMALL: &str = "--algebras so3 --force-free --cases 2";

#[test]
fn a_right_stepper_has_a_page_with_its_orders_and_its_claims() {
    let Some(here) = with_python("a_right_stepper_has_a_page_with_its_orders_and_its_claims") else { return };
    let stepper = steppers("variational.py");
    let claims = "--order 2 --conserves casimirs,momentum";
    let options = format!("{SMALL} --seed 3 {claims} --laws order,casimirs,momentum,equivariance");
    let page = page(&here, &options, &["python3", &stepper], 0);
    let text = complete(&page, &SECTIONS);
    let again = format!("euler-poincare probe {SMALL} --seed 3 {claims}");
    let version = env!("CARGO_PKG_VERSION");
    has_all(
        &text,
        &format!(
            "Nothing is broken, and every claim is confirmed (6 laws on 12 cases). ¦ conserves momentum ¦ momentum: order  ¦ \
             attitude: order  ¦ Errors of the attitude ¦ not clear of rounding ¦ {again} ¦ -- python3 {stepper} ¦ \
             &quot;quartic&quot;:false ¦ {version}"
        ),
    );
    for law in ["order", "casimirs", "momentum", "equivariance"] {
        assert_eq!(page.matches(&format!("id=\"law-method-{law}\"")).count(), 1, "{law}");
    }
    assert!(page.contains("<svg class=\"order\"") && page.contains("class=\"predicted\""), "{page}");
    assert!(!text.contains("--report") && !page.contains(">refuted<"), "{text}");
    let again = self::page(&here, &options, &["python3", &stepper], 0);
    assert_eq!(again, page, "the same run, the same page");
    fits(&here, &page, "a_right_stepper_has_a_page_with_its_orders_and_its_claims");
}

#[test]
fn a_broken_law_is_on_the_page_with_the_exchange_that_broke_it() {
    let Some(here) = with_python("a_broken_law_is_on_the_page_with_the_exchange_that_broke_it") else { return };
    let stepper = steppers("variational.py");
    let options = format!("{SMALL} --seed 1 --order 3 --laws order,equivariance --shrink 0");
    let page = page(&here, &options, &["python3", &stepper, "left"], 1);
    let text = complete(&page, &SECTIONS);
    has_all(
        &text,
        "2 laws are broken: method-order, method-equivariance ¦ refuted ¦ after a left translation of g ¦ \
         One request: a step ¦ {&quot;version&quot;:1, ¦ {&quot;mu&quot;: [ ¦ The solution at the end of this step ¦ \
         The answer less the solution ¦ euler-poincare probe --replay probe-method-equivariance-seed1-case ¦ \
         variational.py left",
    );
    // The record is in the page, as it was saved.
    let name = text.split("--replay ").nth(1).unwrap().split_once(".json").unwrap().0;
    let saved = fs::read_to_string(here.join(format!("{name}.json"))).unwrap();
    assert!(text.contains(saved.trim().replace('"', "&quot;").as_str()), "{name}");
    fits(&here, &page, "a_broken_law_is_on_the_page_with_the_exchange_that_broke_it");
}

#[test]
fn a_program_that_fails_is_on_the_page_and_text_is_escaped() {
    let here = directory("probe-page-failed");
    let evil = "while read line; do echo '<b>&amp;</b>'; done";
    let page = page(&here, &format!("{SMALL} --seed 1 --laws equivariance"), &["sh", "-c", evil], 1);
    let text = complete(&page, &SECTIONS);
    assert!(text.contains("The program failed under method-equivariance. Nothing is broken"), "{text:.600}");
    assert!(text.contains("is not JSON") && text.contains("&lt;b&gt;&amp;amp;&lt;/b&gt;"), "{text}");
}

#[test]
fn a_system_file_is_on_the_page() {
    let Some(here) = with_python("a_system_file_is_on_the_page") else { return };
    fs::write(here.join("body.toml"), rigid_body("# a <body>")).unwrap();
    let page = page(&here, "--system body.toml --order 4 --laws order", &["python3", &steppers("rk4.py")], 0);
    let text = complete(&page, &SECTIONS);
    assert!(text.contains("# a &lt;body&gt;") && text.contains("--system body.toml"), "{text}");
    assert!(!text.contains("systems for each law"), "{text}");
}

#[test]
fn a_page_that_cannot_be_written_is_an_error_before_anything_is_asked() {
    let here = directory("probe-page-refused");
    fs::write(here.join("file"), "").unwrap();
    fs::create_dir_all(here.join("taken/report.html")).unwrap();
    for (place, said) in [("file", "file"), ("file/below", "file/below"), ("taken", "taken/report.html")] {
        run(&here, &["probe", "--report", place, "--", "sh", "-c", "touch asked; cat"]).refuses(said);
        assert!(!here.join("asked").exists(), "{place}");
    }
    run(&here, &["probe", "--report", "out", "--replay", "file"]).ends(2).says("--report");
}
