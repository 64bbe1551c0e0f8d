//! What `integrate` says of a file that it takes, and of a run that it ends: notes and the balance of energy.

use super::{Ended, directory, flat, run, stderr, stdout};
use euler_poincare::system::file::examples;
use std::fs;

fn integrate(here: &std::path::Path, text: &str, arguments: &[&str]) -> Ended {
    fs::write(here.join("system.toml"), text).unwrap();
    run(here, &[&["integrate", "system.toml"], arguments].concat())
}

fn heavy_top() -> String {
    examples().iter().find(|(name, _)| *name == "heavy-top").unwrap().1.to_owned()
}

#[test]
fn an_inertia_that_no_body_has_is_noted() {
    let here = directory("notes-inertia");
    let text = heavy_top().replace("inertia = [1, 1, \"1/2\"]", "inertia = [1, 2, \"7/2\"]");
    let note = "note: lagrangian.inertia: no rigid body has the principal moments 1, 2 and 3.5";
    let output = integrate(&here, &text, &["--out", "rows.csv"]).ends(0);
    assert!(flat(stderr(&output)).contains(note) && flat(stdout(&output)).contains(note), "{output}");
    // A plate has the sum; elsewhere than on rotations there is no such bound.
    for inertia in ["[\"0.1\", \"0.2\", \"0.3\"]", "[1, 1, 1]"] {
        integrate(&here, &heavy_top().replace("[1, 1, \"1/2\"]", inertia), &["--out", "rows.csv"]).quiet();
    }
}

/// Energy 18.9 for 7.05, with a residual of 3.5e-16.
#[test]
fn a_coarse_run_shows_that_its_energy_is_wrong() {
    let here = directory("notes-balance");
    let output = integrate(&here, &heavy_top(), &["--out", "rows.csv"]).quiet();
    let fine = flat(stdout(&output));
    assert!(fine.contains("energy 7.05 to 7.05 with work 0, balance off by"), "{fine}");
    let step = heavy_top().lines().find(|line| line.starts_with("step")).unwrap().to_owned();
    let text = heavy_top().replace(&step, "step = 10");
    let output = integrate(&here, &text, &["--out", "rows.csv", "--steps", "3"]);
    let (told, warned) = (flat(stdout(&output)), flat(stderr(&output)));
    output.ends(0);
    assert!(told.contains("energy 7.05 to 18.") && told.contains("balance off by 1.2e1 at most"), "{told}");
    assert!(warned.starts_with("warning: the energy is off by 1.2e1") && warned.contains("smaller `step`"), "{warned}");
    // Where the rows are on standard output, the warning stands alone on standard error.
    let output = integrate(&here, &text, &["--steps", "3"]);
    assert!(flat(stderr(&output)).starts_with("warning: the energy"));
}
