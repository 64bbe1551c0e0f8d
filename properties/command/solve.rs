//! `integrate` with a tolerance: the error is within it, of every block of coordinates, or the report says that it is not.

use super::{directory, run, stdout};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// The columns of the last row, and what was reported.
struct Solved {
    last: BTreeMap<String, f64>,
    report: String,
}

impl Solved {
    /// The rotation in the upper left corner of g.
    fn rotation(&self) -> [f64; 9] {
        std::array::from_fn(|k| self.last[&format!("g_{}{}", k / 3 + 1, k % 3 + 1)])
    }

    /// The number before this word.
    fn count(&self, word: &str) -> f64 {
        let words: Vec<&str> = self.report.split_whitespace().collect();
        let place = words.iter().position(|found| found.starts_with(word)).unwrap();
        words[place - 1].replace(',', "").parse().unwrap()
    }
}

fn solve(here: &Path, text: &str) -> Solved {
    fs::write(here.join("system.toml"), text).unwrap();
    let output = run(here, &["integrate", "system.toml", "--out", "t.csv"]).ends(0);
    let rows = fs::read_to_string(here.join("t.csv")).unwrap();
    let (names, values) = (rows.lines().next().unwrap().split(','), rows.lines().last().unwrap().split(','));
    let last = names.zip(values).map(|(name, value)| (name.to_owned(), value.parse().unwrap())).collect();
    Solved { last, report: stdout(&output).to_owned() }
}

fn distance(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).fold(0.0, |most, (a, b)| most.max((a - b).abs()))
}

/// A free body, and what else is in the file.
fn body(algebra: &str, inertia: &str, state: &str, run: &str, force: &str) -> String {
    format!(
        "format = 1\n[algebra]\nname = \"{algebra}\"\n[lagrangian]\ninertia = {inertia}\n{force}\n[method]\nretraction = \"exp\"\n\
         [state]\n{state}\n[run]\n{run}\n[output]\nevery = 1000000\n"
    )
}

fn formula(components: &str) -> String {
    format!("[[force]]\nkind = \"formula\"\ncomponents = {components}")
}

/// Where all that there is before is rounding of the formula, and where the motion has died out: μ is of no size then.
#[test]
fn a_torque_moves_a_body_at_rest() {
    let here = directory("solve-rest");
    let late = formula("[\"0.1*(1 + tanh(1e4*(t - 1)))/2\", \"0\", \"0\"]");
    for tolerance in ["1e-6", "1e-9", "1e-12"] {
        let times = format!("tolerance = {tolerance}\nhorizon = 3");
        let solved = solve(&here, &body("so3", "[2, 3, 4]", "velocity = [0, 0, 0]", &times, &late));
        let error = (solved.last["eta_1"] - 0.1).abs();
        assert!(
            error < tolerance.parse::<f64>().unwrap() && solved.count("steps") < 1000.0,
            "{error:e} {}",
            solved.report
        );
    }
    let damped = formula("[\"0.1*(abs(t - 200) + t - 200) - eta_1\", \"-eta_2\", \"-eta_3\"]");
    let times = "tolerance = 1e-9\nhorizon = 210";
    let solved = solve(&here, &body("so3", "[2, 3, 4]", "velocity = [1, 0.5, 0.2]", times, &damped));
    // 2 η' = s/5 − η from rest: η = (s − 2 (1 − e^{−s/2}))/5, s = t − 200.
    let error = (solved.last["eta_1"] - (10.0 - 2.0 * (1.0 - (-5.0f64).exp())) / 5.0).abs();
    assert!(error < 1e-8 && solved.last["eta_2"].abs() < 1e-9, "{error:e} {}", solved.report);
}

/// A translation with a momentum of 5.6·10⁶ beside a spin of 10 to 260.
#[test]
fn a_large_momentum_of_one_factor_hides_no_error_of_another() {
    let here = directory("solve-product");
    let constant = |zeros: &str| format!("[[force]]\nkind = \"constant\"\nvalue = [0.2, -0.3, 0.4{zeros}]");
    let spin = "velocity = [0.02, -0.01, 0.03";
    let alone = |tolerance: &str| {
        let times = format!("tolerance = {tolerance}\nhorizon = 600");
        solve(&here, &body("so3", "[900, 800, 600]", &format!("{spin}]"), &times, &constant("")))
    };
    let (right, coarse) = (alone("1e-12"), alone("1e-8"));
    for (units, tolerance) in [(1.0, "1e-8"), (1e-3, "1e-8"), (1e3, "1e-8")] {
        let flight = [2142.857142857143, -3214.285714285714, 6428.571428571428].map(|v| v * units);
        let [x, y, z] = flight.map(|v| v.to_string());
        let mass = 750.0 / (units * units);
        let times = format!("tolerance = {tolerance}\nhorizon = 600");
        let inertia = format!("[900, 800, 600, {mass}, {mass}, {mass}]");
        let state = format!("{spin}, {x}, {y}, {z}]");
        let solved = solve(&here, &body("so3+r3", &inertia, &state, &times, &constant(", 0, 0, 0")));
        let error = distance(&solved.rotation(), &right.rotation());
        assert!(error < 1e-8, "{units}: {error:e} {}", solved.report);
        for name in ["mu_1", "mu_2", "mu_3"] {
            assert!((solved.last[name] - right.last[name]).abs() < 1e-8 * 260.0, "{units}: {name}");
        }
        // The translation costs nothing.
        let (steps, wanted) = (solved.count("steps"), coarse.count("steps"));
        assert!(steps <= wanted * 1.25, "{units}: {steps} steps, {wanted} without it");
    }
}

/// τ(t L/I₂) τ(t ω₁ (1 − I₁/I₂) e₁).
fn symmetric(light: f64, time: f64) -> [f64; 9] {
    let rotation = |x: [f64; 3]| {
        let angle = (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt();
        let u = x.map(|v| v / angle);
        let (sin, cos) = angle.sin_cos();
        let hat = [0.0, -u[2], u[1], u[2], 0.0, -u[0], -u[1], u[0], 0.0];
        std::array::from_fn::<f64, 9, _>(|k| {
            let (i, j) = (k / 3, k % 3);
            f64::from(u8::from(i == j)) * cos + sin * hat[k] + (1.0 - cos) * u[i] * u[j]
        })
    };
    let turn = rotation([3.0 * light, 1.0, 0.5].map(|v| v * time));
    let spin = rotation([3.0 * (1.0 - light) * time, 0.0, 0.0]);
    std::array::from_fn(|k| (0..3).map(|j| turn[3 * (k / 3) + j] * spin[3 * j + k % 3]).sum())
}

/// An error of the momentum about a light axis is a large one of the velocity.
#[test]
fn the_error_about_a_light_axis_is_seen() {
    let here = directory("solve-light");
    for light in [1e-2, 1e-4, 1e-6, 1e-8] {
        let times = "tolerance = 1e-8\nhorizon = 10";
        let inertia = format!("[{light:e}, 1, 1]");
        let solved = solve(&here, &body("so3", &inertia, "velocity = [3, 1, 0.5]", times, ""));
        let error = distance(&solved.rotation(), &symmetric(light, 10.0));
        // Rounding of a momentum of 1 is 10⁻¹⁶/I₁ of the velocity: the report says so.
        let said = solved.report.contains("more than the tolerance");
        assert!(error < 1e-8 || said, "{light:e}: {error:e} {}", solved.report);
        assert!(error < 1e-8 || light < 1e-6, "{light:e}: {error:e}");
    }
}

/// Two stages for 10⁴ rad: three million steps.
#[test]
fn a_run_that_needs_too_many_steps_ends_early() {
    let here = directory("solve-slow");
    let text = body("so3", "[1e-9, 1, 1]", "momentum = [1e-6, 1, 0.5]", "tolerance = 1e-8\nhorizon = 10", "")
        .replace("[method]", "[method]\ntableau = \"gauss-2\"")
        .replace("\"exp\"", "\"cayley\"");
    fs::write(here.join("system.toml"), text).unwrap();
    let output = run(&here, &["integrate", "system.toml", "--out", "t.csv"]).ends(1);
    output.says("about axis 1 ¦ η_1 =  ¦ 1000000 are allowed ¦ Gauss's with 6 stages");
}
