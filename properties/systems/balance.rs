//! The balance of energy where the Lagrangian or the potential depends on the time: dE/dt = ⟨f, η⟩ − ∂L/∂t.

use super::{Run, example, parsed, rows};

/// L = exp(t) η²/2 in one dimension: μ is kept, and E = μ² exp(−t)/2 falls without a force. η = exp(−t) from η = 1.
const GROWING: &str = include_str!("cases/growing.toml");

/// A body with drag in a field that swings and grows, in the example of a satellite.
const SWINGING: &str = "[[potential]]\nkind = \"formula\"\nvalue = \"(1 + t)*g_13*sin(t)/20\"\n\n[[force]]\nkind = \"linear-drag\"\n\
                        coefficient = \"1/50\"\n\n[method]";

/// The largest balance, and by how much the energy goes away from that of the start and the work.
fn closes(run: &Run) -> (f64, f64) {
    let n = run.n;
    let worst = run.change(0.0..1.0, |row| run.balance(row));
    (worst, run.change(0.0..1.0, |row| run.energy(row) - row[2 + 2 * n]))
}

#[test]
fn the_balance_has_what_a_lagrangian_loses_with_the_time() {
    let run = Run::of_text(GROWING);
    for row in &run.rows {
        let energy = 0.5 * (-row[0]).exp();
        assert!((run.energy(row) - energy).abs() < 1e-12 && row[4] == 0.0, "{row:?}");
    }
    let (worst, without) = closes(&run);
    assert!(worst < 1e-7 && without > 0.4, "{worst:e} {without:e}");
}

#[test]
fn the_balance_closes_at_the_order_of_the_tableau() {
    let swinging = example("satellite").replacen("[method]", SWINGING, 1);
    for text in [example("satellite"), &swinging] {
        let halved = text.replacen("step = \"1/10\"", "step = \"1/20\"", 1);
        assert_ne!(text, halved);
        let ((coarse, without), (fine, _)) = (closes(&Run::of_text(text)), closes(&Run::of_text(&halved)));
        assert!(coarse < 1e-5 * without && without > 1e-3, "{coarse:e} of {without:e}");
        let order = (coarse / fine).log2();
        assert!((order - 4.0).abs() < 0.2, "{coarse:e} {fine:e}");
    }
}

#[test]
fn the_balance_closes_within_a_tolerance_too() {
    let tolerant =
        example("satellite").replacen("[method]", SWINGING, 1).replacen("step = \"1/10\"", "tolerance = 1e-10", 1);
    let tolerant = tolerant.replacen("tableau = \"gauss-2\"\n", "", 1) + "[output]\nsave_every = \"1/3\"\n";
    let rows = rows::<f64>(&parsed(&tolerant), None);
    assert_eq!(rows.len(), 181);
    let worst = rows.iter().fold(0.0, |m: f64, row| m.max(row[9].abs()));
    assert!(worst < 1e-10, "{worst:e}");
}
