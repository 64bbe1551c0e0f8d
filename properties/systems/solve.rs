//! Files with a tolerance: the error is within it, of every block of coordinates, or the report says that it is not.

use super::{Run, Seen, parsed};
use euler_poincare::system::trajectory::End;
use nalgebra::{Rotation3, Vector3};

/// A run to its end, and what was reported.
struct Solved {
    run: Run,
    steps: usize,
    error: f64,
}

impl Solved {
    fn of(text: &str) -> Self {
        let file = parsed(text);
        let mut seen = Seen::new(u64::MAX);
        let solved = file.run(&mut seen).unwrap();
        assert_eq!((solved.end, solved.reason), (End::Time, None));
        let statistics = solved.statistics.expect("a run");
        Self { run: Run::with(&file, seen.rows), steps: statistics.steps, error: statistics.error }
    }

    /// The rotation in the upper left corner of g.
    fn rotation(&self) -> [f64; 9] {
        std::array::from_fn(|k| self.run.g(self.run.last(), k / 3 + 1, k % 3 + 1))
    }

    fn mu(&self) -> &[f64] {
        self.run.mu(self.run.last())
    }

    fn eta(&self) -> &[f64] {
        self.run.eta(self.run.last())
    }
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
    let late = formula("[\"0.1*(1 + tanh(1e4*(t - 1)))/2\", \"0\", \"0\"]");
    for tolerance in ["1e-6", "1e-9", "1e-12"] {
        let times = format!("tolerance = {tolerance}\nhorizon = 3");
        let solved = Solved::of(&body("so3", "[2, 3, 4]", "velocity = [0, 0, 0]", &times, &late));
        let (error, steps) = ((solved.eta()[0] - 0.1).abs(), solved.steps);
        assert!(error < tolerance.parse::<f64>().unwrap() && steps < 1000, "{error:e} in {steps} steps");
    }
    let damped = formula("[\"0.1*(abs(t - 200) + t - 200) - eta_1\", \"-eta_2\", \"-eta_3\"]");
    let times = "tolerance = 1e-9\nhorizon = 210";
    let solved = Solved::of(&body("so3", "[2, 3, 4]", "velocity = [1, 0.5, 0.2]", times, &damped));
    // 2 η' = s/5 − η from rest: η = (s − 2 (1 − e^{−s/2}))/5, s = t − 200.
    let error = (solved.eta()[0] - (10.0 - 2.0 * (1.0 - (-5.0f64).exp())) / 5.0).abs();
    assert!(error < 1e-8 && solved.eta()[1].abs() < 1e-9, "{error:e}");
}

/// A translation with a momentum of 5.6·10⁶ beside a spin of 10 to 260.
#[test]
fn a_large_momentum_of_one_factor_hides_no_error_of_another() {
    let constant = |zeros: &str| format!("[[force]]\nkind = \"constant\"\nvalue = [0.2, -0.3, 0.4{zeros}]");
    let spin = "velocity = [0.02, -0.01, 0.03";
    let alone = |tolerance: &str| {
        let times = format!("tolerance = {tolerance}\nhorizon = 600");
        Solved::of(&body("so3", "[900, 800, 600]", &format!("{spin}]"), &times, &constant("")))
    };
    let (right, coarse) = (alone("1e-12"), alone("1e-8"));
    for (units, tolerance) in [(1.0, "1e-8"), (1e-3, "1e-8"), (1e3, "1e-8")] {
        let flight = [2142.857142857143, -3214.285714285714, 6428.571428571428].map(|v| v * units);
        let [x, y, z] = flight.map(|v| v.to_string());
        let mass = 750.0 / (units * units);
        let times = format!("tolerance = {tolerance}\nhorizon = 600");
        let inertia = format!("[900, 800, 600, {mass}, {mass}, {mass}]");
        let state = format!("{spin}, {x}, {y}, {z}]");
        let solved = Solved::of(&body("so3+r3", &inertia, &state, &times, &constant(", 0, 0, 0")));
        let error = distance(&solved.rotation(), &right.rotation());
        assert!(error < 1e-8, "{units}: {error:e}");
        let near = |(a, b): (&f64, &f64)| (a - b).abs() < 1e-8 * 260.0;
        assert!(right.mu().iter().zip(solved.mu()).all(near), "{units}: {:?}", solved.mu());
        // The translation costs nothing.
        let (steps, wanted) = (solved.steps as f64, coarse.steps as f64);
        assert!(steps <= wanted * 1.25, "{units}: {steps} steps, {wanted} without it");
    }
}

/// τ(t L/I₂) τ(t ω₁ (1 − I₁/I₂) e₁).
fn symmetric(light: f64, time: f64) -> [f64; 9] {
    let rotation = |x: [f64; 3]| Rotation3::new(Vector3::from(x) * time);
    let g = rotation([3.0 * light, 1.0, 0.5]) * rotation([3.0 * (1.0 - light), 0.0, 0.0]);
    std::array::from_fn(|k| g[(k / 3, k % 3)])
}

/// An error of the momentum about a light axis is a large one of the velocity.
#[test]
fn the_error_about_a_light_axis_is_seen() {
    for light in [1e-2, 1e-4, 1e-6, 1e-8] {
        let times = "tolerance = 1e-8\nhorizon = 10";
        let inertia = format!("[{light:e}, 1, 1]");
        let solved = Solved::of(&body("so3", &inertia, "velocity = [3, 1, 0.5]", times, ""));
        let error = distance(&solved.rotation(), &symmetric(light, 10.0));
        // Rounding of a momentum of 1 is 10⁻¹⁶/I₁ of the velocity: the report says so.
        assert!(error < 1e-8 || solved.error > 1e-8, "{light:e}: {error:e}, said to be {:e}", solved.error);
        assert!(error < 1e-8 || light < 1e-6, "{light:e}: {error:e}");
    }
}

/// Two stages for 10⁴ rad: three million steps.
#[test]
fn a_run_that_needs_too_many_steps_ends_early() {
    let text = body("so3", "[1e-9, 1, 1]", "momentum = [1e-6, 1, 0.5]", "tolerance = 1e-8\nhorizon = 10", "")
        .replace("[method]", "[method]\ntableau = \"gauss-2\"")
        .replace("\"exp\"", "\"cayley\"");
    let solved = parsed(&text).run(&mut Seen::<f64>::new(u64::MAX)).unwrap();
    assert_eq!(solved.end, End::Failed);
    let reason = solved.reason.expect("a reason");
    for part in ["about axis 1", "η_1 = ", "1000000 are allowed", "Gauss's with 6 stages"] {
        assert!(reason.contains(part), "{part}: {reason}");
    }
}
