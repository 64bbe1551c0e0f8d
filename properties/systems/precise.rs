//! Files against reference values of other programs: the heavy top by formulas.

use super::Rows;
use euler_poincare::scalar::{Dd, Real};
use euler_poincare::system::trajectory::{Ended, Plan};
use euler_poincare::system::{Compiled, SystemFile};

/// The last row of a run.
fn last<T: Compiled>(text: &str) -> Vec<T> {
    let file = SystemFile::parse(text).unwrap_or_else(|error| panic!("{error}"));
    let mut rows = Rows::<T>::default();
    let ended = file.case.trajectory(Plan::<T>::of(&file).unwrap(), &mut rows).unwrap();
    assert!(matches!(ended, Ended::Whole { .. }), "{ended:?}");
    rows.0.pop().expect("a row")
}

/// A heavy top with drag, all of it by formulas.
const TOP: &str = r#"format = 1

[parameters]
weight = "1.3"
r = ["0.3", "-0.2", "0.5"]

[definitions]
Gamma = "row(R, 3)"

[algebra]
name = "so3"

[lagrangian]
formula = "(eta_1^2/2 + 2*eta_2^2 + eta_3^2)/2 - weight*dot(r, Gamma)"

[[force]]
kind = "formula"
components = ["-eta_1/10", "-3*eta_2/10", "-eta_3/5"]

[method]
tableau = "gauss-2"
retraction = "exp"

[state]
momentum = ["0.5", "0.3", "0.9"]
rotation-vector = ["0.4", "-0.3", "0.2"]

[run]
step = "1/8"
steps = 1
"#;

/// The potential by a formula beside an inertia, and by its kind, with the drag by its kind.
const WRITTEN: [&str; 2] = [
    "inertia = [\"1/2\", 2, 1]\n[[potential]]\nkind = \"formula\"\nvalue = \"weight*dot(r, Gamma)\"",
    "inertia = [\"1/2\", 2, 1]\n[[potential]]\nkind = \"gravity\"\nweight = \"1.3\"\ncenter = [\"0.3\", \"-0.2\", \"0.5\"]\n\
     [[force]]\nkind = \"linear-drag\"\nmatrix = [[\"0.1\", 0, 0], [0, \"0.3\", 0], [0, 0, \"0.2\"]]",
];

/// μ after a step of 1/8.
const STEP: [f64; 3] = [0.56406502, 0.36518586, 0.81533845];

/// g after a step of 1/8, by rows.
const TURNED: [f64; 9] =
    [0.90742819, -0.37704492, -0.18550256, 0.23446714, 0.82066192, -0.52109421, 0.34871082, 0.42936132, 0.83309641];

/// μ after 20 steps of 1/10.
const LATER: [f64; 3] = [0.86285617, -0.46046665, -0.31754545];

/// Half a unit of the eighth digit, in which the values above are rounded, and what an `f64` adds.
const DIGITS: f64 = 5.1e-9;

#[track_caller]
fn agree<T: Real>(found: &[T], known: &[f64]) {
    let off = found.iter().zip(known).fold(0.0, |m: f64, (a, b)| m.max((a.to_f64() - b).abs()));
    assert!(found.len() == known.len() && off < DIGITS, "{found:?}: off by {off:e}");
}

/// One step and twenty, in one scalar.
fn has_the_reference_values<T: Compiled>(text: &str) {
    // t, μ, η, energy, work, balance, the Casimir, g.
    let row = last::<T>(text);
    agree(&row[1..4], &STEP);
    agree(&row[11..20], &TURNED);
    let longer = text.replacen("step = \"1/8\"\nsteps = 1\n", "step = \"1/10\"\nsteps = 20\n", 1);
    assert_ne!(text, longer);
    agree(&last::<T>(&longer)[1..4], &LATER);
}

#[test]
fn a_file_of_formulas_has_the_reference_values_of_the_heavy_top() {
    let (start, end) = (TOP.find("formula =").unwrap(), TOP.find("[method]").unwrap());
    let by_kind = format!("{}{}\n{}", &TOP[..start], WRITTEN[1], &TOP[end..]);
    let whole = TOP.lines().find(|line| line.starts_with("formula =")).unwrap();
    for text in [TOP.to_owned(), TOP.replacen(whole, WRITTEN[0], 1), by_kind] {
        has_the_reference_values::<f64>(&text);
        has_the_reference_values::<Dd>(&text);
    }
}
