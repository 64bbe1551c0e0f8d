//! Bodies that come to rest: near an equilibrium rounding of g makes more of the forces than is left of the momentum.

use super::{Run, norm, parsed, rows, whole};
use euler_poincare::scalar::{Dd, Scalar};

/// A heavy body with drag: after some 400 units of time its centre of mass hangs below the fixed point.
fn pendulum(drag: &str, method: &str, run: &str) -> String {
    format!(
        "format = 1\n[algebra]\nname = \"so3\"\n[lagrangian]\ninertia = [\"1/2\", 2, 1]\n[[potential]]\nkind = \"gravity\"\n\
         weight = \"1.3\"\ncenter = [\"0.3\", \"-0.2\", \"0.5\"]\n[[force]]\n{drag}\n[method]\n{method}\n\
         [state]\nmomentum = [\"0.5\", \"0.3\", \"0.9\"]\nrotation-vector = [\"0.4\", \"-0.3\", \"0.2\"]\n[run]\n{run}\n"
    )
}

const DRAG: &str = "kind = \"linear-drag\"\ncoefficient = \"1/10\"";

/// How far the centre of mass is from hanging, in a row.
fn tilt(run: &Run, row: &[f64]) -> f64 {
    let (lever, gamma) = ([0.3, -0.2, 0.5], [1, 2, 3].map(|column| run.g(row, 3, column)));
    let along = (0..3).fold(0.0, |sum, k| sum + lever[k] * gamma[k]);
    along / (norm(&lever) * norm(&gamma)) + 1.0
}

#[test]
fn a_damped_pendulum_comes_to_rest_in_steps_of_any_kind() {
    for (tableau, step) in [("gauss-2", "1/8"), ("gauss-4", "1/4"), ("lobatto-iiia-3", "1/8"), ("rk4", "1/8")] {
        for retraction in ["exp", "cayley"] {
            let method = format!("tableau = \"{tableau}\"\nretraction = \"{retraction}\"");
            let file = pendulum(DRAG, &method, &format!("step = \"{step}\"\nhorizon = 1200"));
            let run = Run::of_text(&file);
            let last = run.rows.last().unwrap();
            let momentum = run.mu(last).iter().fold(0.0f64, |most, v| most.max(v.abs()));
            // 1e-16 of the weight is what rounding leaves of the torque.
            assert!(
                momentum < 1e-15 && tilt(&run, last) < 1e-14,
                "{tableau}, {retraction}: {momentum:e}, {:e}",
                tilt(&run, last)
            );
        }
    }
}

#[test]
fn it_does_so_in_32_digits() {
    let file = pendulum(
        DRAG,
        "tableau = \"gauss-2\"\nretraction = \"cayley\"",
        "step = \"1/4\"\nhorizon = 1500\nscalar = \"dd\"",
    );
    let rows = rows::<Dd>(&parsed(&file), Some(100));
    let momentum = rows.last().unwrap()[1..4].iter().fold(0.0f64, |most, v| most.max(v.to_f64().abs()));
    // As far as it falls in that time: with residuals beside the momentum alone the run ended at 1e-8.
    assert!(momentum < 1e-20, "{momentum:e}");
}

#[test]
fn it_does_so_within_a_tolerance_in_few_steps() {
    let file = pendulum(DRAG, "retraction = \"exp\"", "tolerance = 1e-10\nhorizon = 5000");
    // A row a step.
    let (rows, ended) = whole::<f64>(&parsed(&file), None);
    assert!(ended.statistics.is_some() && ended.totals.is_none(), "{ended:?}");
    let momentum = rows.last().unwrap()[1..4].iter().fold(0.0f64, |most, v| most.max(v.abs()));
    assert!(momentum < 1e-14 && rows.len() < 20_000, "{momentum:e}, {} steps", rows.len());
}

#[test]
fn a_momentum_decays_to_nothing() {
    // Through numbers of less than 16 digits, which is no failure.
    let drag = "kind = \"linear-drag\"\nmatrix = [[\"0.1\", 0, 0], [0, \"0.3\", 0], [0, 0, \"0.2\"]]";
    let method = "tableau = \"gauss-2\"\nretraction = \"exp\"";
    let file = pendulum(drag, method, "step = \"1/2\"\nhorizon = 8000").replace("weight = \"1.3\"", "weight = 0");
    let run = Run::of_text(&file);
    assert!(run.mu(run.rows.last().unwrap()).iter().all(|v| v.abs() < 1e-300));
}
