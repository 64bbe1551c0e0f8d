//! Files with a tolerance instead of a step: rows at chosen times, events, and what is refused.

use super::refuses::refuses_each;
use super::{Seen, parsed, rows};
use euler_poincare::scalar::{Dd, Number, Scalar};
use euler_poincare::system::trajectory::{End, Ended};
use euler_poincare::system::{Compiled, SystemFile};
use nalgebra::ComplexField;
use std::f64::consts::PI;

/// A symmetric body without force: its first momentum is cos(t/2), its second one sin(t/2).
const SYMMETRIC: &str = include_str!("wrong/tolerance.toml");

/// A run of at most a number of steps.
fn solve_for<T: Compiled>(text: &str, most: u64) -> (Ended<T>, Seen<T>) {
    let file = parsed(text);
    assert_eq!(parsed(&file.to_toml().unwrap()), file);
    let mut seen = Seen::new(most);
    let solved = file.run(&mut seen).unwrap();
    (solved, seen)
}

fn solve<T: Compiled>(text: &str) -> (Ended<T>, Seen<T>) {
    solve_for(text, u64::MAX)
}

/// The text with another one in it.
fn with(from: &str, to: &str) -> String {
    assert!(SYMMETRIC.contains(from), "{from}");
    SYMMETRIC.replacen(from, to, 1)
}

fn event(keys: &str) -> String {
    format!("{SYMMETRIC}\n[[event]]\n{keys}\n")
}

#[test]
fn a_tolerance_reproduces_small_fixed_steps() {
    let top = super::example("heavy-top");
    let drag = "[[force]]\nkind = \"linear-drag\"\ncoefficient = \"1/10\"\n[method]";
    for text in [top.to_owned(), top.replacen("[method]", drag, 1)] {
        let fixed = rows::<f64>(&parsed(&text.replace("gauss-3", "gauss-6")), Some(5));
        for (tableau, tolerance) in [("tableau = \"gauss-3\"", 1e-8), ("", 1e-8), ("", 1e-11)] {
            let text = text.replace("tableau = \"gauss-3\"", tableau);
            let text = text.replace("step = \"1/20\"", &format!("tolerance = {tolerance:e}"));
            let (solved, seen) = solve::<f64>(&format!("{text}\n[output]\nsave_every = \"1/4\"\n"));
            assert_eq!((solved.end, solved.reason, solved.time), (End::Time, None, 12.0));
            assert!(solved.statistics.unwrap().error < tolerance);
            assert_eq!(seen.rows.len(), 49);
            assert_eq!(fixed.len(), 49);
            for (k, (row, wanted)) in seen.rows.iter().zip(&fixed).enumerate() {
                assert_eq!(row[0], k as f64 / 4.0);
                for (value, wanted) in row.iter().zip(wanted).skip(1) {
                    let error = (value - wanted).abs();
                    assert!(error < 20.0 * tolerance, "{tableau} {tolerance:e} at t = {}: {error:e}", row[0]);
                }
            }
        }
    }
}

#[test]
fn rows_are_at_the_times_asked_for() {
    let check = |row: &[f64]| {
        let exact = [(row[0] / 2.0).cos(), (row[0] / 2.0).sin(), 1.0];
        (0..3).for_each(|a| assert!((row[1 + a] - exact[a]).abs() < 1e-10, "{row:?}"));
        // No force: energy, work, balance.
        assert!((row[7] - 0.75).abs() < 1e-12 && row[8] == 0.0 && row[9].abs() < 1e-12, "{row:?}");
    };
    let times = |text: &str| {
        let (solved, seen) = solve::<f64>(text);
        assert_eq!(solved.end, End::Time);
        seen.rows.iter().for_each(|row| check(row));
        seen.rows.iter().map(|row| row[0]).collect::<Vec<_>>()
    };
    assert_eq!(times(SYMMETRIC), [0.5, PI, 20.0]);
    // Backward.
    let back = with("horizon = 20", "horizon = -20").replace("[0.5, \"pi\", \"20\"]", "[0, -0.5, \"-19\"]");
    assert_eq!(times(&back), [0.0, -0.5, -19.0]);
    let every = times(&with("save_at = [0.5, \"pi\", \"20\"]", "save_every = \"0.3\""));
    assert_eq!(every.len(), 68);
    assert_eq!((every[0], every[3], every[66], every[67]), (0.0, 3.0 * 0.3, 66.0 * 0.3, 20.0));
    // After steps: the first and the last, and every third.
    let steps = times(&with("save_at = [0.5, \"pi\", \"20\"]", ""));
    let thirds = times(&with("save_at = [0.5, \"pi\", \"20\"]", "every = 3"));
    assert_eq!((steps[0], *steps.last().unwrap()), (0.0, 20.0));
    let mut wanted: Vec<f64> = steps.iter().copied().step_by(3).collect();
    wanted.extend(steps.last().filter(|last| wanted.last() != Some(last)));
    assert_eq!(thirds, wanted);
}

#[test]
fn events_are_located_and_end_the_run() {
    let near = |found: f64, wanted: f64| assert!((found - wanted).abs() < 1e-9, "{found} and {wanted}");
    let (solved, seen) = solve::<f64>(&event("formula = \"mu_1\""));
    assert_eq!(solved.end, End::Time);
    let found: Vec<(usize, bool)> = seen.events.iter().map(|(index, rising, _)| (*index, *rising)).collect();
    assert_eq!(found, [(0, false), (0, true), (0, false)]);
    (0..3).for_each(|k| near(seen.events[k].2[0], (2 * k + 1) as f64 * PI));
    // In parameters, velocities, entries of the rotation and the time.
    let (_, seen) = solve::<f64>(&event("formula = \"eta_2 - level\"\ndirection = \"rising\""));
    (0..2).for_each(|k| near(seen.events[k].2[0], 2.0 * PI * (1.0 / 6.0 + 2.0 * k as f64)));
    assert_eq!(seen.events.len(), 2);
    let (_, seen) = solve::<f64>(&event("formula = \"t^2 - 2\""));
    near(seen.events[0].2[0], 2.0_f64.sqrt());
    // A terminal one: a row of its state, although it is none of the times.
    let terminal = "formula = \"mu_2\"\nname = \"half\"\ndirection = \"falling\"\nterminal = true";
    let (solved, seen) = solve::<f64>(&event(terminal));
    assert_eq!((solved.end, seen.events.len(), seen.rows.len()), (End::Event(0), 1, 3));
    near(solved.time, 2.0 * PI);
    assert_eq!(seen.rows[2], seen.events[0].2);
    assert_eq!(seen.rows[2][0], solved.time);
}

#[test]
fn thirty_two_digits_take_a_tolerance_for_them() {
    let text = with("tolerance = 1e-11", "tolerance = \"1e-26\"\nscalar = \"dd\"");
    let (solved, seen) = solve::<Dd>(&format!("{text}\n[[event]]\nformula = \"mu_1\"\n"));
    assert_eq!((solved.end, seen.rows.len(), seen.events.len()), (End::Time, 3, 3));
    let half = |t: Dd| t * Dd::half();
    for row in &seen.rows {
        let errors = [(row[1] - half(row[0]).cos()).abs(), (row[2] - half(row[0]).sin()).abs()];
        assert!(errors.iter().all(|error| *error < Dd::exact(1e-25)), "{errors:?}");
    }
    let error = (seen.events[0].2[0] - Number::parse("pi").unwrap().eval::<Dd>().unwrap()).abs();
    assert!(error < Dd::exact(1e-24), "{error:e}");
}

#[test]
fn an_observer_ends_a_run_with_a_row_of_its_last_state() {
    let (solved, seen) = solve_for::<f64>(SYMMETRIC, 3);
    assert_eq!((solved.end, seen.steps), (End::Stopped, 3));
    assert!(solved.time < 20.0 && seen.rows.last().unwrap()[0] == solved.time);
}

#[test]
fn a_run_that_fails_keeps_its_rows_and_says_why() {
    let failed = |text: &str| {
        let (solved, seen) = solve::<f64>(text);
        assert_eq!(solved.end, End::Failed);
        assert!(seen.rows.last().is_none_or(|row| row[0] == solved.time), "{}", solved.time);
        (solved.reason.expect("a reason"), seen.rows.len())
    };
    let (reason, rows) = failed(&event("name = \"late\"\nformula = \"1 + log(6 - t)\""));
    assert!(reason.starts_with("the event \"late\" has no value at t = "), "{reason}");
    assert!(reason.contains("column 5: the logarithm of -") && reason.contains("\n    1 + log(6 - t)\n"), "{reason}");
    assert!(rows >= 3, "{rows}");
    let (reason, rows) = failed(&event("formula = \"1/t\""));
    assert!(reason.starts_with("the event \"1/t\" has no value at t = 0: ") && reason.contains("division by zero"));
    assert_eq!(rows, 1);
    let force = "[[force]]\nkind = \"formula\"\ncomponents = \"-sqrt(2 - t)*eta\"\n\n[method]";
    let (reason, rows) = failed(&with("[method]", force));
    assert!(reason.contains("no step of ") && reason.contains("the force at stage "), "{reason}");
    assert!(rows >= 2, "{rows}");
    let (reason, _) = failed(&with("horizon = 20", "horizon = 20\nmax_steps = 6"));
    assert!(reason.contains("6 steps, as many as allowed"), "{reason}");
}

/// A text in the file, what it becomes, what the caret stands under, and what the message holds.
const BAD: &str = include_str!("wrong/tolerance.txt");

#[test]
fn a_wrong_run_is_an_error_with_its_line_and_a_caret() {
    // The header of a table is under the name of the table.
    refuses_each(SYMMETRIC, BAD, 31, |_, rest, caret| {
        rest.starts_with(caret) || rest.starts_with(caret.trim_start_matches('['))
    });
}

#[test]
fn what_needs_fixed_steps_refuses_a_tolerance() {
    let file = parsed(SYMMETRIC);
    let refused = file.plan::<f64>().unwrap_err().to_string();
    assert!(refused.contains("fixed steps are needed here: give `step`"), "{refused}");
    let refused = SystemFile::parse_for_stepper(SYMMETRIC).unwrap_err();
    assert!(
        refused.message.contains("fixed steps are needed here") && refused.excerpt.contains("tolerance"),
        "{refused}"
    );
    let fixed = with("tolerance = 1e-11", "step = 1").replace("save_at", "# save_at");
    let fixed = parsed(&fixed.replace("[method]", "[method]\ntableau = \"gauss-2\""));
    assert!(fixed.solve_plan::<f64>().unwrap().is_none());
}
