//! `integrate` with a tableau by an option, and in a file beside the system file.

use super::{Ended, code, command, directory, refuses_each, run, stdout, system};
use std::fs;
use std::path::PathBuf;

/// Heun's method as a tableau file.
const HEUN: &str = "name = \"Heun\"\norder = 2\na = [[0, 0], [1, 0]]\nb = [\"1/2\", \"1/2\"]\n";

/// A directory with a file of states, a system with the classical method, and systems with these tableaux.
fn with(test: &str, systems: &[(&str, &str)]) -> PathBuf {
    let here = directory(test);
    fs::create_dir_all(here.join("sub")).unwrap();
    fs::write(here.join("states.csv"), "mu_1,mu_2,mu_3\n0.5,0,1\n").unwrap();
    for (name, tableau) in systems.iter().chain(&[("rk4", "tableau = \"rk4\"")]) {
        let method = format!("{tableau}\nretraction = \"exp\"");
        let run = "step = \"1/8\"\nsteps = 4";
        let text = system("so3", "inertia = [1, 2, \"3/2\"]", &method, "velocity = [1, 0, 1]", run);
        fs::write(here.join(format!("{name}.toml")), text).unwrap();
    }
    here
}

#[test]
fn a_tableau_is_a_name_or_a_file() {
    let here =
        with("integrate-tableau", &[("named", "tableau = \"heun2\""), ("sub/beside", "tableau-file = \"heun.toml\"")]);
    fs::write(here.join("sub/heun.toml"), HEUN).unwrap();
    let rows = |arguments: &[&str]| {
        let output = run(&here, &[&["integrate"], arguments].concat()).quiet();
        stdout(&output).to_owned()
    };
    let wanted = rows(&["named.toml"]);
    assert_ne!(rows(&["rk4.toml"]), wanted);
    assert_eq!(rows(&["rk4.toml", "--tableau", "heun2"]), wanted);
    assert_eq!(rows(&["rk4.toml", "--tableau", "sub/heun.toml"]), wanted);
    assert_eq!(rows(&["sub/beside.toml"]), wanted);
    assert_ne!(rows(&["sub/beside.toml", "--tableau", "rk4"]), wanted);
    // On standard input the names are those of the current directory.
    let mut piped = command(&here.join("sub"), &["integrate", "-"]);
    let output = Ended::of(piped.stdin(fs::File::open(here.join("sub/beside.toml")).unwrap()));
    assert_eq!((code(&output), stdout(&output)), (0, wanted.as_str()), "{output}");
    // Members of an ensemble are integrated with it.
    let members = rows(&["named.toml", "--ensemble", "states.csv"]);
    assert_eq!(rows(&["rk4.toml", "--ensemble", "states.csv", "--tableau", "sub/heun.toml"]), members);
    let measured = run(&here, &["order", "--tableau", "gauss-1", "--digits", "16", "--system", "sub/beside.toml"]);
    assert_ne!(code(&measured), 2, "{measured}");
}

#[test]
fn a_tableau_that_cannot_be_read_is_an_error_with_its_place() {
    let names = [("absent", "tableau-file = \"nowhere.toml\""), ("named", "tableau-file = \"heun.toml\"")];
    let here = with("integrate-tableau-refused", &names);
    fs::write(here.join("heun.toml"), HEUN).unwrap();
    fs::write(here.join("bad.toml"), HEUN.replace("[1, 0]]", "[\"x\", 0]]")).unwrap();
    refuses_each(&here, include_str!("refused/tableau.txt"), 13);
    assert_eq!(fs::read_to_string(here.join("heun.toml")).unwrap(), HEUN, "it is not written over");
    run(&here, &["integrate", "named.toml", "--tableau", "heun.toml"]).ends(0);
}
