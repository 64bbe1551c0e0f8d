//! `integrate --ensemble`: final states, statistics, and what is refused.

use super::{Ended, directory, run, started, stdout, stopped};
use std::fs;
use std::path::Path;
use std::time::Duration;

/// A system file on `algebra`, with this inertia and force.
fn system(here: &Path, name: &str, algebra: &str, inertia: &str, force: &str, method: &str, run: &str) {
    let n = if algebra.contains("se3") { 6 } else { 3 };
    let momentum = vec!["1"; n].join(", ");
    let text = format!(
        "format = 1\n[algebra]\n{algebra}\n[lagrangian]\ninertia = {inertia}\n{force}\n[method]\n{method}\n\
         [state]\nmomentum = [{momentum}]\n[run]\n{run}\n"
    );
    fs::write(here.join(name), text).unwrap();
}

const BODY: &str = "[0.5, 2, 1]";
const DAMPED: &str = "[[force]]\nkind = \"double-bracket\"\nalpha = \"1/4\"";
const GAUSS: &str = "tableau = \"gauss-2\"\nretraction = \"cayley\"";

fn body(here: &Path, name: &str, force: &str, run: &str) {
    system(here, name, "name = \"so3\"", BODY, force, GAUSS, run);
}

/// `members` momenta, none like another.
fn states(here: &Path, name: &str, members: usize, dimension: usize) {
    let header: Vec<_> = (1..=dimension).map(|a| format!("mu_{a}")).collect();
    let mut text = header.join(",") + "\n";
    for k in 0..members {
        let x = |a: usize| ((k as f64 + 1.0) * (a as f64 + 2.3).sqrt()).fract() - 0.25;
        let row: Vec<_> = (0..dimension).map(|a| x(a).to_string()).collect();
        text.push_str(&(row.join(",") + "\n"));
    }
    fs::write(here.join(name), text).unwrap();
}

/// What the command wrote.
pub struct Table {
    header: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Table {
    pub fn new(text: &str) -> Self {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        let list = |record: &csv::StringRecord| record.iter().map(String::from).collect::<Vec<_>>();
        let header = list(reader.headers().unwrap());
        Self { header, rows: reader.records().map(|record| list(&record.unwrap())).collect() }
    }

    pub fn text(&self, row: usize, name: &str) -> &str {
        let column = self.header.iter().position(|h| h == name);
        &self.rows[row][column.unwrap_or_else(|| panic!("{name} is not in {:?}", self.header))]
    }

    pub fn value(&self, row: usize, name: &str) -> f64 {
        self.text(row, name).parse().unwrap()
    }

    fn column(&self, name: &str) -> Vec<f64> {
        (0..self.rows.len()).map(|row| self.value(row, name)).collect()
    }
}

fn ensemble(here: &Path, system: &str, states: &str, more: &[&str]) -> Ended {
    run(here, &[&["integrate", system, "--ensemble", states], more].concat())
}

fn good(here: &Path, system: &str, states: &str, more: &[&str]) -> Table {
    let output = ensemble(here, system, states, more).quiet();
    Table::new(stdout(&output))
}

#[test]
fn members_are_trajectories() {
    let here = directory("ensemble-members");
    let twisted = "name = \"so3\"\nbasis = [[1, 0, 0], [1, 1, 0], [0, 0, 2]]";
    let full = "[[2, \"1/2\", 0], [\"1/2\", 1, 0], [0, 0, 3]]";
    let periodic = "[[force]]\nkind = \"periodic\"\nvalue = [1, 0, \"1/2\"]\nfrequency = 2\nphase = 0";
    let constants = "dimension = 3\nconstants = [[1, 2, 3, 1], [1, 3, 2, 1]]";
    let ones = "[1, 2, 1, 2, 1, 3]";
    let exp = "tableau = \"lobatto-iiia-3\"\nretraction = \"exp\"";
    let quartic = format!("{BODY}\nquartic = \"1/10\"");
    let horizon = "step = 0.25\nhorizon = 1.9";
    let dd = "step = 0.25\nsteps = 4\nscalar = \"dd\"";
    let (gyrostat, indefinite) = (format!("{BODY}\ngyrostat = [0, 0, 1]"), "[1, -2, 3]\nindefinite = true");
    let systems: [(&str, &str, &str, &str, &str, usize); 10] = [
        ("name = \"so3\"", BODY, DAMPED, GAUSS, horizon, 3),
        ("name = \"so3\"", BODY, "", exp, horizon, 3),
        ("name = \"so3\"", BODY, periodic, GAUSS, horizon, 3),
        ("name = \"so3\"", &quartic, DAMPED, GAUSS, horizon, 3),
        ("name = \"so3\"", &gyrostat, DAMPED, GAUSS, horizon, 3),
        ("name = \"so3\"", indefinite, DAMPED, GAUSS, horizon, 3),
        ("name = \"so3\"", BODY, DAMPED, exp, dd, 3),
        (twisted, full, DAMPED, GAUSS, horizon, 3),
        (constants, BODY, "", exp, horizon, 3),
        ("name = \"se3\"", ones, "[[force]]\nkind = \"linear-drag\"\ncoefficient = 0.1", GAUSS, horizon, 6),
    ];
    for (k, (algebra, inertia, force, method, run_, n)) in systems.into_iter().enumerate() {
        system(&here, "system.toml", algebra, inertia, force, method, run_);
        states(&here, "states.csv", 11, n);
        let found = good(&here, "system.toml", "states.csv", &[]);
        assert_eq!(found.rows.len(), 11);
        let momenta = fs::read_to_string(here.join("states.csv")).unwrap();
        let file = fs::read_to_string(here.join("system.toml")).unwrap();
        for row in [0, 7, 10] {
            let start = format!("[{}]", momenta.lines().nth(row + 1).unwrap());
            let one =
                file.replace(&format!("momentum = [{}]", vec!["1"; n].join(", ")), &format!("momentum = {start}"));
            fs::write(here.join("one.toml"), one).unwrap();
            let output = run(&here, &["integrate", "one.toml"]);
            let single = Table::new(stdout(&output));
            let last = single.rows.len() - 1;
            for name in single.header.iter().filter(|h| !["work", "balance", "residual", "iterations"].contains(&&***h))
            {
                let (x, y) = (single.value(last, name), found.value(row, name));
                assert!((x - y).abs() <= 1e-13, "system {k}, member {row}, {name}: {x} {y}");
            }
            assert_eq!(found.text(row, "status"), "ok");
            assert_eq!(found.text(row, "member"), (row + 1).to_string());
        }
    }
}

#[test]
fn the_engines_agree_to_round_off_and_the_general_one_reports() {
    let here = directory("ensemble-engines");
    let heavy = format!(
        "{DAMPED}\n[[potential]]\nkind = \"gravity\"\nweight = \"1/2\"\ncenter = [\"1/5\", 0, \"1/2\"]\n\
         [[potential]]\nkind = \"uniform-field\"\nmoment = [0, \"1/8\", 0]\nfield = [1, 0, \"1/2\"]"
    );
    // A weight magnifies rounding as it goes.
    let runs = [("cayley", DAMPED, 200), ("exp", DAMPED, 200), ("cayley", "", 200), ("exp", heavy.as_str(), 80)];
    for (retraction, force, steps) in runs {
        let method = format!("tableau = \"gauss-3\"\nretraction = \"{retraction}\"");
        system(&here, "s.toml", "name = \"so3\"", BODY, force, &method, &format!("step = 0.125\nsteps = {steps}"));
        states(&here, "s.csv", 20, 3);
        let (fast, slow) = (good(&here, "s.toml", "s.csv", &[]), good(&here, "s.toml", "s.csv", &["--general"]));
        assert_eq!(fast.header, slow.header);
        for row in 0..20 {
            for name in fast.header.iter().filter(|h| !["residual", "iterations", "status"].contains(&&***h)) {
                let (x, y) = (fast.value(row, name), slow.value(row, name));
                assert!((x - y).abs() < 2e-13, "{retraction}, member {row}, {name}: {x} {y}");
            }
            assert_eq!((fast.text(row, "residual"), fast.text(row, "iterations")), ("", ""));
            assert!(slow.value(row, "residual") < 1e-12 && slow.value(row, "iterations") >= f64::from(steps));
        }
    }
}

#[test]
fn the_result_is_the_same_for_any_number_of_jobs() {
    let here = directory("ensemble-jobs");
    body(&here, "s.toml", DAMPED, "step = 0.125\nhorizon = 5.3");
    // More than a batch.
    states(&here, "s.csv", 5000, 3);
    states(&here, "few.csv", 100, 3);
    for (file, more) in [
        ("s.csv", &[][..]),
        ("s.csv", &["--statistics", "--every", "7"]),
        ("few.csv", &["--general"]),
        ("few.csv", &["--general", "--statistics"]),
        ("few.csv", &["--scalar", "dd", "--steps", "5", "--statistics"]),
    ] {
        let with = |jobs: &str| {
            let output = ensemble(&here, "s.toml", file, &[more, &["--jobs", jobs]].concat()).quiet();
            stdout(&output).to_owned()
        };
        let one = with("1");
        assert!(one == with("2") && one == with("5"), "{more:?}");
    }
}

#[test]
fn statistics_are_those_of_the_final_states() {
    let here = directory("ensemble-statistics");
    body(&here, "s.toml", DAMPED, "step = 0.125\nhorizon = 2.05\n[output]\nevery = 4");
    states(&here, "s.csv", 37, 3);
    let statistics = good(&here, "s.toml", "s.csv", &["--statistics"]);
    assert_eq!(statistics.column("elapsed"), [0.0, 0.5, 1.0, 1.5, 2.0, 2.05]);
    assert!(statistics.column("members").iter().all(|&members| members == 37.0));
    let last = good(&here, "s.toml", "s.csv", &[]);
    for name in ["mu_1", "mu_2", "mu_3", "energy", "casimir_1"] {
        let values = last.column(name);
        let mean = values.iter().sum::<f64>() / 37.0;
        let std = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 37.0).sqrt();
        let (min, max) = values.iter().fold((f64::MAX, f64::MIN), |(min, max), v| (min.min(*v), max.max(*v)));
        for (of, expected) in [("mean", mean), ("std", std), ("min", min), ("max", max)] {
            let found = statistics.value(5, &format!("{name}_{of}"));
            assert!((found - expected).abs() < 1e-14, "{name}_{of}: {found} {expected}");
        }
    }
    let departure = statistics.column("g_departure_max");
    assert!(departure[0] == 0.0 && departure[5] < 1e-14 && departure[5] > 0.0, "{departure:?}");
    let many = ["--statistics", "--steps", "1000000", "--every", "1"];
    ensemble(&here, "s.toml", "s.csv", &many).ends(2).says("--every 11 or more");
}

#[test]
fn members_have_times_attitudes_inertias_and_forces_of_their_own() {
    let here = directory("ensemble-parameters");
    let force = format!("{DAMPED}\n[[force]]\nkind = \"linear-drag\"\ncoefficient = 0.1");
    body(&here, "s.toml", &force, "step = 0.125\nsteps = 10");
    fs::write(
        here.join("s.csv"),
        "# a comment\n force_2_coefficient, mu_3,mu_1,mu_2,inertia_1,t, g_11,g_12,g_13,g_21,g_22,g_23,g_31,g_32,g_33,force_1_alpha\n\
         0.3, 0.5,1/3,sqrt(2)/2,3/4,2, 0,-1,0,1,0,0,0,0,1,1\n\
         0.1,1,1,1,0.5,0,1,0,0,0,1,0,0,0,1,1/4\n",
    )
    .unwrap();
    let found = good(&here, "s.toml", "s.csv", &[]);
    let general = good(&here, "s.toml", "s.csv", &["--general"]);
    let single = |text: String| {
        fs::write(here.join("one.toml"), text).unwrap();
        Table::new(stdout(&run(&here, &["integrate", "one.toml"])))
    };
    let file = fs::read_to_string(here.join("s.toml")).unwrap();
    let plain = single(file.clone());
    let other = file
        .replace("[0.5, 2, 1]", "[0.75, 2, 1]")
        .replace("alpha = \"1/4\"", "alpha = 1")
        .replace("coefficient = 0.1", "coefficient = 0.3")
        .replace("momentum = [1, 1, 1]", "momentum = [\"1/3\", \"sqrt(2)/2\", 0.5]\ntime = 2");
    let other = single(other);
    for (row, one) in [(1, plain), (0, other)] {
        for name in ["t", "mu_1", "mu_2", "mu_3", "eta_2", "energy", "casimir_1"] {
            let (x, y) = (one.value(10, name), found.value(row, name));
            assert!((x - y).abs() < 1e-14, "{row} {name}: {x} {y}");
            assert!((x - general.value(row, name)).abs() < 1e-14, "{row} {name}");
        }
    }
    // What one run wrote is the start of another.
    body(&here, "five.toml", DAMPED, "step = 0.125\nsteps = 5");
    body(&here, "ten.toml", DAMPED, "step = 0.125\nsteps = 10");
    states(&here, "start.csv", 9, 3);
    fs::write(here.join("half.csv"), stdout(&ensemble(&here, "five.toml", "start.csv", &[]))).unwrap();
    let (twice, once) = (good(&here, "five.toml", "half.csv", &[]), good(&here, "ten.toml", "start.csv", &[]));
    for row in 0..9 {
        for name in ["t", "mu_1", "mu_2", "mu_3", "g_12", "g_33"] {
            assert!((twice.value(row, name) - once.value(row, name)).abs() < 1e-14, "{row} {name}");
        }
    }
}

#[test]
fn a_member_that_fails_keeps_its_last_state_and_the_others_go_on() {
    let here = directory("ensemble-fold");
    let method = "tableau = \"lobatto-iiia-2\"\nretraction = \"cayley\"";
    let force = DAMPED.replace("\"1/4\"", "1");
    system(&here, "s.toml", "name = \"so3\"", BODY, &force, method, "step = 0.9\nsteps = 3");
    // The fourth folds in its first step; the others are a quarter as fast.
    let row = |k: usize| {
        let scale = if k == 3 { 1.0 } else { 0.2 + 0.01 * k as f64 };
        format!("{},{},{}\n", 0.5 / 2f64.sqrt() * scale, 0, 1.0 / 2f64.sqrt() * scale)
    };
    let rows: String = (0..12).map(row).collect();
    fs::write(here.join("s.csv"), format!("mu_1,mu_2,mu_3\n{rows}")).unwrap();
    for engine in [&[][..], &["--general"]] {
        let output = ensemble(&here, "s.toml", "s.csv", engine).ends(1);
        output.says("1 of 12 members failed; the first: member 4");
        let found = Table::new(stdout(&output));
        for k in 0..12 {
            if k == 3 {
                let status = found.text(k, "status");
                assert!(status.starts_with("step 1, from t = 0: fold: "), "{status}");
                assert_eq!((found.value(k, "t"), found.value(k, "mu_2")), (0.0, 0.0));
            } else {
                assert_eq!(found.text(k, "status"), "ok");
                assert!((found.value(k, "t") - 2.7).abs() < 1e-12);
            }
        }
        let output = ensemble(&here, "s.toml", "s.csv", &[engine, &["--statistics"]].concat()).ends(1);
        assert_eq!(Table::new(stdout(&output)).column("members"), [12.0, 11.0, 11.0, 11.0]);
    }
}

#[test]
fn bad_states_are_refused_before_anything_is_written() {
    let here = directory("ensemble-refused");
    body(&here, "s.toml", DAMPED, "step = 0.125\nsteps = 3");
    let method = "tableau = \"gauss-2\"\nretraction = \"exp\"";
    let constants = "dimension = 3\nconstants = [[1, 2, 3, 1]]";
    system(&here, "constants.toml", constants, "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]", "", method, "step = 1\nsteps = 1");
    let attitude = "mu_1,mu_2,mu_3,g_11,g_12,g_13,g_21,g_22,g_23,g_31,g_32,g_33\n1,1,1,";
    let long = format!("mu_1,mu_2,mu_3\n1,1,{}\n", "1".repeat(70_000));
    let refused = |text: &str, system: &str, parts: &str| {
        fs::write(here.join("s.csv"), text).unwrap();
        ensemble(&here, system, "s.csv", &["--out", "out.csv"]).refuses(parts);
        assert!(!here.join("out.csv").exists(), "{text:.60}");
    };
    refused("", "s.toml", "is empty ¦ mu_1, mu_2, mu_3");
    refused(&format!("{attitude}2,0,0,0,1,0,0,0,1\n"), "s.toml", "line 2 ¦ not in the group ¦ 3e0");
    refused(&format!("{attitude}1,0,0,0,1,0,0,0,-1\n"), "s.toml", "line 2 ¦ not in the group ¦ inf");
    refused(&long, "s.toml", "longer than 65536 bytes");
    // The text, the system's file, and what is said.
    let rows: Vec<&str> = include_str!("states.txt").lines().collect();
    assert_eq!(rows.len(), 20);
    for row in rows {
        let [text, system, parts] = *row.split(" | ").collect::<Vec<_>>() else { panic!("{row}") };
        refused(&text.replace("\\n", "\n"), system, parts);
    }
    fs::write(here.join("s.csv"), b"mu_1,mu_2,mu_3\n1,\xff,1\n").unwrap();
    ensemble(&here, "s.toml", "s.csv", &[]).ends(2).says("UTF-8");
    let huge = fs::File::create(here.join("huge.csv")).unwrap();
    // Holes take no room; where even those are not to be had, nothing is tried.
    if huge.set_len((1 << 36) + 1).is_ok() {
        ensemble(&here, "s.toml", "huge.csv", &[]).ends(2).says("at most 68719476736");
    }
    states(&here, "s.csv", 3, 3);
    let kept = fs::read(here.join("s.csv")).unwrap();
    let states =
        ["s.csv --out s.csv", "s.csv --out ./s.csv", "s.csv --out s.toml", "s.csv --plot s.svg", "s.csv --jobs 0"];
    for words in states.into_iter().chain(["-", ".", "none.csv", "s.csv --out none/out.csv"]) {
        let words: Vec<&str> = words.split(' ').collect();
        ensemble(&here, "s.toml", words[0], &words[1..]).ends(2);
    }
    assert_eq!(fs::read(here.join("s.csv")).unwrap(), kept);
}

#[cfg(unix)]
#[test]
fn an_interrupt_writes_what_is_done() {
    let here = directory("ensemble-interrupt");
    body(&here, "s.toml", DAMPED, "step = 0.125\nsteps = 1000000000");
    states(&here, "s.csv", 20, 3);
    for more in [&["--out", "o.csv"][..], &["--out", "o.csv", "--statistics", "--every", "100000"]] {
        let arguments = [&["integrate", "s.toml", "--ensemble", "s.csv"], more].concat();
        // On a busy machine it may not have begun after a second: then it ends by the signal, as any program does.
        let code = [1_500, 6_000, 24_000].into_iter().find_map(|milliseconds| {
            let child = started(&here, &arguments);
            std::thread::sleep(Duration::from_millis(milliseconds));
            stopped(child, "-INT").status.code()
        });
        assert_eq!(code, Some(130));
        let found = Table::new(&fs::read_to_string(here.join("o.csv")).unwrap());
        if more.len() == 2 {
            assert_eq!(found.rows.len(), 20);
            assert!(found.text(0, "status").starts_with("interrupted after "), "{}", found.text(0, "status"));
            assert!(found.value(0, "t") > 1.0);
        } else {
            assert_eq!(found.column("members")[0], 20.0);
            assert_eq!(found.column("members").last(), Some(&0.0));
        }
    }
}
