//! Error tables, reference trajectories and work counts of `euler_poincare::experiments`, pinned.

use crate::systems::{parsed, rows};
use euler_poincare::experiments::evolution::evolve;
use euler_poincare::experiments::{Integrator, Method, Problem, Reference, errors, expected};
use euler_poincare::integrators::trajectory;
use euler_poincare::scalar::{Dd, Real};
use euler_poincare::tableau::families::Family;
use std::fmt::Write;

/// The finest step of the pinned tables is 2⁻⁵.
const FINEST: u32 = 5;

pub fn pin(name: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../snapshots");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, text));
}

/// Three digits; in f64 nothing below 10⁻¹¹, where rounding reaches the third digit.
fn rounded(value: f64, scalar: &str) -> String {
    if scalar == f64::NAME && value < 1e-11 { "< 1e-11".into() } else { expected::shown(value) }
}

/// The tables, pinned; in 32 digits the errors of the momentum are those of another implementation.
fn error_table(problem: Problem) {
    let reference = Reference::compute(problem).unwrap();
    let (mut text, mut compared) = (String::new(), 0);
    for errors in errors::table(&reference, &Method::TABULATED, FINEST, &|| {}).unwrap() {
        let (method, scalar) = (errors.method, errors.scalar);
        let column = expected::TABLE.iter().find(|c| c.problem == problem && c.method == method && scalar == Dd::NAME);
        for row in errors.findings.rows() {
            if let Some(column) = column {
                let found = row.readings.as_ref().ok().map(|readings| expected::shown(readings[0].error));
                let wanted = column.error(row.steps.ilog2()).map(expected::shown);
                assert_eq!(found, wanted, "{} {method} with {} steps", problem.name(), row.steps);
                compared += 1;
            }
            let Ok(readings) = &row.readings else { continue };
            let shown: String = readings.iter().map(|r| format!(" {:>10}", rounded(r.error, scalar))).collect();
            writeln!(text, "{method:<14} {scalar:<4} 1/h = {:<3}{shown}", row.steps).unwrap();
        }
    }
    assert_eq!(compared, 24);
    pin(&format!("errors-{}", problem.name()), &text);
}

#[test]
fn errors_are_those_of_the_tables_and_of_another_implementation() {
    Problem::ALL.into_iter().for_each(error_table);
}

#[test]
fn reference_trajectories() {
    for (problem, method) in
        [(Problem::Llg, Method::new(Family::Gauss, 2)), (Problem::Relaxed, Method::new(Family::Gauss, 3))]
    {
        let mut text = String::new();
        for (t, m) in evolve(problem, Integrator::Variational(method), 8).unwrap() {
            writeln!(text, "{t:<6} {:>15.12} {:>15.12} {:>15.12}", m[0], m[1], m[2]).unwrap();
        }
        pin(&format!("trajectory-{}-{method}", problem.name()), &text);
    }
}

#[test]
fn work_per_step() {
    let mut text = String::new();
    for problem in Problem::ALL {
        for method in Method::TABULATED {
            let mut state = problem.state::<f64>();
            let mut counts = Vec::new();
            let mut integrator = method.on::<f64>(problem).unwrap();
            trajectory::integrate(&mut integrator, &mut state, 0.125, 8, |_, _, r| counts.push(r.iterations)).unwrap();
            // The last fixed-point iterations are decided by rounding: a mean to the nearest whole number holds everywhere.
            let mean = (counts.iter().sum::<usize>() + 4) / 8;
            writeln!(text, "{:<8} {method:<14} {mean} iterations a step", problem.name()).unwrap();
        }
    }
    pin("work-h-0.125", &text);
}

/// t and μ after each step.
#[test]
fn a_body_with_drag_on_se3() {
    for retraction in ["exp", "cayley"] {
        let file = include_str!("systems/cases/se3-drag.toml").replace("exp", retraction);
        let mut text = String::new();
        for row in rows::<f64>(&parsed(&file), Some(1)).iter().skip(1) {
            write!(text, "{:<6}", row[0]).unwrap();
            row[1..7].iter().for_each(|m| write!(text, " {m:>15.12}").unwrap());
            writeln!(text).unwrap();
        }
        pin(&format!("trajectory-se3-{retraction}"), &text);
    }
}
