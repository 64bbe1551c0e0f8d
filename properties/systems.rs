//! The systems that people know, as files: each with what is known of it.

mod balance;
mod cases;
mod precise;
mod reading;
mod refused;
mod refuses;
mod rest;
mod solve;
mod tolerance;

use euler_poincare::system::file::examples;
use euler_poincare::system::trajectory::{End, Ended, Observer, Row};
use euler_poincare::system::{CaseError, Compiled, SystemFile};
use nalgebra::Matrix3;
use std::ops::ControlFlow;

/// The rows and the events of a run, with a tolerance of at most a number of steps.
struct Seen<T> {
    rows: Vec<Vec<T>>,
    events: Vec<(usize, bool, Vec<T>)>,
    steps: u64,
    most: u64,
}

impl<T> Seen<T> {
    fn new(most: u64) -> Self {
        Self { rows: Vec::new(), events: Vec::new(), steps: 0, most }
    }
}

impl<T: Compiled> Observer<T> for Seen<T> {
    fn row(&mut self, row: &Row<'_, T>) {
        self.rows.push(row.values.to_vec());
    }

    fn step(&mut self, steps: u64, share: f64) -> ControlFlow<()> {
        assert!(steps > self.steps && share > 0.0 && share <= 1.0);
        self.steps = steps;
        if steps >= self.most { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    fn event(&mut self, index: usize, rising: bool, row: &Row<'_, T>) {
        self.events.push((index, rising, row.values.to_vec()));
    }
}

#[track_caller]
pub fn parsed(text: &str) -> SystemFile {
    match SystemFile::parse(text) {
        Ok(file) => file,
        Err(error) => panic!("{error}\n{text}"),
    }
}

/// The rows of a run, with a tolerance or after each `every` steps, by default those of the file; and how it ended.
fn ran<T: Compiled>(file: &SystemFile, every: Option<u64>) -> Result<(Vec<Vec<T>>, Ended<T>), CaseError> {
    let mut file = file.clone();
    file.output.every = every.unwrap_or(file.output.every);
    let mut seen = Seen::new(u64::MAX);
    let ended = file.run(&mut seen)?;
    Ok((seen.rows, ended))
}

/// The rows of a run to its end, and how it ended. What fails says of which file.
#[track_caller]
fn whole<T: Compiled>(file: &SystemFile, every: Option<u64>) -> (Vec<Vec<T>>, Ended<T>) {
    match ran(file, every) {
        Ok((rows, ended)) => {
            assert_eq!((&ended.end, &ended.reason), (&End::Time, &None), "{}", file.to_toml().unwrap());
            (rows, ended)
        }
        Err(error) => panic!("{error}\n{}", file.to_toml().unwrap()),
    }
}

/// The rows of a run to its end.
#[track_caller]
pub fn rows<T: Compiled>(file: &SystemFile, every: Option<u64>) -> Vec<Vec<T>> {
    whole(file, every).0
}

/// The text of an example.
fn example(name: &str) -> &'static str {
    examples().iter().find(|(found, _)| *found == name).expect("an example").1
}

/// The last row of a run to its end.
#[track_caller]
pub fn last<T: Compiled>(file: &SystemFile) -> Vec<T> {
    rows(file, None).pop().expect("a row")
}

/// A run, with its rows by name: t, μ, η, the balance of energy, g.
struct Run {
    n: usize,
    casimirs: usize,
    size: usize,
    rows: Vec<Vec<f64>>,
}

impl Run {
    #[track_caller]
    fn of(name: &str) -> Self {
        Self::of_text(example(name))
    }

    #[track_caller]
    fn of_text(text: &str) -> Self {
        let file = parsed(text);
        let rows = rows(&file, Some(1));
        Self::with(&file, rows)
    }

    fn with(file: &SystemFile, rows: Vec<Vec<f64>>) -> Self {
        let case = &file.case;
        Self { n: case.dimension(), casimirs: case.casimir_count(), size: case.matrix_size(), rows }
    }

    fn mu<'a>(&self, row: &'a [f64]) -> &'a [f64] {
        &row[1..=self.n]
    }

    fn eta<'a>(&self, row: &'a [f64]) -> &'a [f64] {
        &row[1 + self.n..=2 * self.n]
    }

    fn energy(&self, row: &[f64]) -> f64 {
        row[1 + 2 * self.n]
    }

    /// Energy without that of the start and the work of the force.
    fn balance(&self, row: &[f64]) -> f64 {
        row[3 + 2 * self.n]
    }

    fn casimir(&self, row: &[f64], k: usize) -> f64 {
        assert!(k < self.casimirs);
        row[4 + 2 * self.n + k]
    }

    /// g_rc, from 1.
    fn g(&self, row: &[f64], r: usize, c: usize) -> f64 {
        row[4 + 2 * self.n + self.casimirs + (r - 1) * self.size + c - 1]
    }

    fn last(&self) -> &[f64] {
        self.rows.last().expect("a row")
    }

    /// The largest change of a function of the rows in a part of the run.
    fn change(&self, part: std::ops::Range<f64>, f: impl Fn(&[f64]) -> f64) -> f64 {
        let count = self.rows.len() as f64;
        let rows = &self.rows[(part.start * count) as usize..(part.end * count) as usize];
        rows.iter().fold(0.0, |m: f64, row| m.max((f(row) - f(&self.rows[0])).abs()))
    }

    /// Kept to round-off.
    fn keeps(&self, what: &str, f: impl Fn(&[f64]) -> f64) {
        let change = self.change(0.0..1.0, f);
        assert!(change < 2e-13, "{what}: {change:e}");
    }

    /// Not kept exactly, but without a drift: the last third is no worse than the first but by a half.
    fn does_not_drift(&self, what: &str, bound: f64, f: impl Fn(&[f64]) -> f64 + Copy) {
        let (early, late) = (self.change(0.0..0.34, f), self.change(0.66..1.0, f));
        assert!(early < bound && late < 1.5 * early + 1e-13, "{what}: {early:e}, then {late:e}");
    }
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// sn, cn and dn of x for the parameter m = k², by the arithmetic-geometric mean (Abramowitz and Stegun 1964, §16.4).
fn elliptic(x: f64, m: f64) -> (f64, f64, f64) {
    let (mut a, mut c) = (vec![1.0], vec![m.sqrt()]);
    let mut b = (1.0 - m).sqrt();
    while c.last().unwrap().abs() > 1e-16 {
        let (old, last) = (*a.last().unwrap(), b);
        a.push((old + last) / 2.0);
        c.push((old - last) / 2.0);
        b = (old * last).sqrt();
    }
    let mut phi = 2f64.powi(a.len() as i32 - 1) * a.last().unwrap() * x;
    for k in (1..a.len()).rev() {
        phi = (phi + (c[k] / a[k] * phi.sin()).asin()) / 2.0;
    }
    (phi.sin(), phi.cos(), (1.0 - m * phi.sin() * phi.sin()).sqrt())
}

/// One attitude in every form that a file may give it, and Euler angles against their matrix.
#[test]
fn an_attitude_is_the_same_in_every_form() {
    let heavy = example("heavy-top");
    let attitude = |given: &str| {
        let run = Run::of_text(&heavy.replace("quaternion = [3, 0, 1, 0]", given));
        let row = run.rows[0].clone();
        let entry = |k: usize| run.g(&row, k / 3 + 1, k % 3 + 1);
        std::array::from_fn::<f64, 9, _>(entry)
    };
    let near = |given: &str, expected: [f64; 9], allowed: f64| {
        let found = attitude(given);
        assert!(found.iter().zip(&expected).all(|(x, y)| (x - y).abs() < allowed), "{given}: {found:?}");
    };
    let quarter = [0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    for given in [
        "rotation-vector = [0, 0, \"pi/2\"]",
        "quaternion = [2, 0, 0, 2]",
        "euler = [\"pi/2\", 0, 0]",
        "euler = [0, \"pi/2\", 0]\naxes = \"xzx\"",
        "matrix = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]",
        "matrix = [[\"1e-7\", -1, 0], [1, 0, 0], [0, 0, 1]]",
        "attitude = [0, 0, \"pi/2\"]",
    ] {
        near(given, quarter, if given.contains("1e-7") { 1e-7 } else { 1e-15 });
    }
    let (c, s) = (|x: f64| x.cos(), |x: f64| x.sin());
    let (a, b) = (0.5, 0.25);
    let yaw_then_pitch = [c(a) * c(b), -s(a), c(a) * s(b), s(a) * c(b), c(a), s(a) * s(b), -s(b), 0.0, c(b)];
    near("euler = [\"1/2\", \"1/4\", 0]", yaw_then_pitch, 1e-15);
    let ninths = [8.0, -1.0, 4.0, 4.0, 4.0, -7.0, -1.0, 8.0, 4.0];
    near("quaternion = [5, 3, 1, 1]", ninths.map(|n| n / 9.0), 1e-15);
}

#[test]
fn every_example_is_read_and_written() {
    assert!(examples().len() >= 11);
    for (name, text) in examples() {
        let file = parsed(text);
        assert_eq!(parsed(&file.to_toml().unwrap()), file, "{name}");
        assert!(text.starts_with("# "), "{name} begins with what it is");
    }
}

/// l may have no second derivatives at rest, or singular ones: the velocity is found from another place.
#[test]
fn lagrangians_that_are_not_regular_at_rest_are_integrated() {
    for formula in ["norm(eta)^2/2", "norm(eta)^3", "dot(eta,eta)^2", "eta_1^2+eta_2^2+eta_3^4"] {
        let file = format!(
            "format = 1\n[algebra]\nname = \"r3\"\n[lagrangian]\nformula = \"{formula}\"\n[method]\ntableau = \"gauss-2\"\n\
             retraction = \"exp\"\n[state]\nvelocity = [1, \"0.2\", \"0.5\"]\n[run]\nstep = \"1/8\"\nhorizon = 1\n"
        );
        let run = Run::of_text(&file);
        let (first, last) = (run.mu(&run.rows[0]), run.mu(run.rows.last().unwrap()));
        assert!(run.rows.len() == 9 && first == last, "{formula}: {first:?}, {last:?}");
    }
}

/// u = g_33 from the release at u₀: u̇² = A (u₀ − u)(u − e)(r − u), u = e + (u₀ − e) cd²(ωt).
#[test]
fn the_heavy_top_nutates_as_the_elliptic_functions_say() {
    let run = Run::of("heavy-top");
    let (inertia, weight, spin, u0): (f64, f64, f64, f64) = (1.0, 1.0, 0.5 * 5.0, 0.8);
    let lambda = spin * spin / (2.0 * inertia * weight);
    let root = (lambda * lambda / 4.0 + 1.0 - lambda * u0).sqrt();
    let (low, high) = (lambda / 2.0 - root, lambda / 2.0 + root);
    let (omega, m) = ((2.0 * weight / inertia * (high - low)).sqrt() / 2.0, (u0 - low) / (high - low));
    for row in &run.rows {
        let (_, cn, dn) = elliptic(omega * row[0], m);
        let u = low + (u0 - low) * (cn / dn).powi(2);
        assert!((run.g(row, 3, 3) - u).abs() < 1e-8, "t = {}: {} for {u}", row[0], run.g(row, 3, 3));
    }
    run.keeps("the spin", |row| run.mu(row)[2]);
    run.keeps("the vertical momentum", |row| (0..3).map(|k| run.g(row, 3, k + 1) * run.mu(row)[k]).sum());
    run.does_not_drift("the energy", 1e-7, |row| run.energy(row));
}

/// With I₁ Ω² cos θ − I₃ ω₃ Ω + m g l = 0 the axis goes round at the rate Ω and keeps its angle: Ω = 1, ω₃ = 3.6 here.
#[test]
fn the_heavy_top_precesses_steadily() {
    let text = example("heavy-top");
    let steady = text.replace("velocity = [0, 0, 5]", "velocity = [\"-3/5\", 0, \"18/5\"]");
    assert_ne!(text, steady);
    let run = Run::of_text(&steady);
    for row in &run.rows {
        let axis = [0.6 * row[0].cos(), 0.6 * row[0].sin(), 0.8];
        let off = (0..3).fold(0.0, |m: f64, k| m.max((run.g(row, k + 1, 3) - axis[k]).abs()));
        assert!(off < 1e-9, "t = {}: {off:e}", row[0]);
    }
}

/// Half a turn-over takes 2K of Jacobi's functions; η_2 changes its sign there.
#[test]
fn the_tennis_racket_turns_over_in_time() {
    let run = Run::of("tennis-racket");
    let signs: Vec<f64> = run
        .rows
        .windows(2)
        .filter(|pair| run.eta(&pair[0])[1] * run.eta(&pair[1])[1] < 0.0)
        .map(|pair| pair[0][0])
        .collect();
    // dn has the largest axis here: with I = (1, 2, 3) and η = (ε, 1, 0), ω² = (I₂ − I₁)(2E I₃ − M²)/(I₁ I₂ I₃).
    let (energy, square): (f64, f64) = (1.0 + 0.5e-6, 4.0 + 1e-6);
    let (a, b) = (2.0 * energy * 3.0 - square, square - 2.0 * energy);
    let (omega, m) = if b < a { ((2.0 - 1.0) * a / 6.0, b / a) } else { ((3.0 - 2.0) * b / 6.0, a / b) };
    let omega = omega.sqrt();
    // K by the arithmetic-geometric mean.
    let (mut x, mut y) = (1.0f64, (1.0 - m).abs().sqrt());
    for _ in 0..40 {
        (x, y) = ((x + y) / 2.0, (x * y).sqrt());
    }
    let quarter = std::f64::consts::FRAC_PI_2 / x / omega;
    assert!(signs.len() >= 3, "{signs:?}");
    for pair in signs.windows(2) {
        assert!((pair[1] - pair[0] - 2.0 * quarter).abs() < 0.11, "{signs:?}, 2K/ω = {}", 2.0 * quarter);
    }
    run.keeps("|mu|", |row| norm(run.mu(row)));
    run.does_not_drift("the energy", 1e-8, |row| run.energy(row));
}

#[test]
fn the_underwater_vehicle_comes_to_rest_upright() {
    let run = Run::of("underwater-vehicle");
    let falls = run.rows.windows(2).all(|pair| run.energy(&pair[1]) < run.energy(&pair[0]) + 1e-12);
    assert!(falls, "drag takes energy, and nothing gives any");
    assert!(norm(run.eta(run.last())) < 1e-3 && run.g(run.last(), 3, 3) > 0.9999, "{:?}", run.last());
    assert!(run.change(0.0..1.0, |row| run.balance(row)) < 1e-4);
}

#[test]
fn the_satellite_keeps_jacobis_integral() {
    let run = Run::of("satellite");
    let vertical = |row: &[f64]| (0..3).map(|k| run.g(row, 3, k + 1) * run.mu(row)[k]).sum::<f64>();
    run.does_not_drift("Jacobi's integral", 1e-6, |row| run.energy(row) - 0.5 * vertical(row));
    assert!(run.change(0.0..1.0, |row| run.energy(row)) > 1e-3, "the energy alone is not kept");
}

#[test]
fn the_quadrotor_levels_itself_and_hovers() {
    let run = Run::of("quadrotor");
    let last = run.last();
    assert!((run.g(last, 3, 4) - 2.0).abs() < 1e-3 && run.g(last, 3, 3) > 1.0 - 1e-6 && run.g(last, 1, 1) > 1.0 - 1e-6);
    assert!(norm(&run.eta(last)[..3]) < 1e-3 && run.eta(last)[5].abs() < 1e-3);
}

#[test]
fn the_spin_keeps_its_length_and_follows_the_field() {
    let run = Run::of("spin");
    let length = run.change(0.0..1.0, |row| norm(run.mu(row)));
    assert!(length < 1e-7, "{length:e}");
    let angle = |row: &[f64]| {
        let (t, mu) = (row[0], run.mu(row));
        let field = [(0.5 * t).cos(), (0.5 * t).sin(), 0.25];
        (0..3).map(|k| mu[k] * field[k]).sum::<f64>() / norm(mu) / norm(&field)
    };
    // A steady angle to the field, in the frame that turns with it.
    let (late, last) = (angle(&run.rows[run.rows.len() * 3 / 4]), angle(run.last()));
    assert!(last > 0.7 && (last - late).abs() < 0.02, "{late} {last}");
}

#[test]
fn the_sleigh_ends_along_its_runner() {
    let run = Run::of("sleigh");
    let eta = run.eta(run.last());
    assert!(eta[2].abs() < 0.02 * eta[1].abs(), "{eta:?}");
    assert!(run.change(0.0..1.0, |row| run.balance(row)) < 1e-6);
}

/// Kirchhoff's: momentum and pitch.
#[test]
fn bodies_in_four_dimensions_and_in_a_fluid_keep_both_casimirs() {
    for name in ["body-in-four-dimensions", "kirchhoff"] {
        let run = Run::of(name);
        (0..2).for_each(|k| run.keeps(name, |row| run.casimir(row, k)));
        run.does_not_drift(name, 1e-6, |row| run.energy(row));
    }
}

#[test]
fn the_toda_lattice_keeps_its_eigenvalues_and_sorts() {
    let run = Run::of("toda-lattice");
    let cube = |row: &[f64]| {
        let mu = run.mu(row);
        Matrix3::new(mu[0], mu[3], mu[5], mu[3], mu[1], mu[4], mu[5], mu[4], mu[2]).pow(3).trace()
    };
    run.keeps("tr L", |row| run.mu(row)[..3].iter().sum());
    assert!(run.change(0.0..1.0, |row| run.mu(row)[5]) < 1e-12, "L stays tridiagonal");
    assert!(run.change(0.0..1.0, |row| run.energy(row)) < 1e-9 && run.change(0.0..1.0, cube) < 1e-9);
    let last = run.mu(run.last());
    assert!(last[3].abs() < 1e-2 && last[4].abs() < 1e-2, "{last:?}");
    let sorted = last[..3].is_sorted() || last[..3].iter().rev().is_sorted();
    assert!(sorted, "{last:?}");
}

#[test]
fn kovalevskayas_integral_does_not_drift() {
    let run = Run::of("kovalevskaya-top");
    let integral = |row: &[f64]| {
        let (p, q, z) = (run.eta(row)[0], run.eta(row)[1], [run.g(row, 3, 1), run.g(row, 3, 2)]);
        (p * p - q * q - z[0]).powi(2) + (2.0 * p * q - z[1]).powi(2)
    };
    run.does_not_drift("Kovalevskaya's integral", 1e-6, integral);
    run.keeps("the vertical momentum", |row| (0..3).map(|k| run.g(row, 3, k + 1) * run.mu(row)[k]).sum());
    run.does_not_drift("the energy", 1e-7, |row| run.energy(row));
}
