//! Files with formulas that are wrong: each is an error with the line, and the caret where it goes wrong.

use super::refuses::refuses_each;
use super::{last, parsed, ran};
use euler_poincare::scalar::{Dd, Scalar};
use euler_poincare::system::SystemFile;

const TOP: &str = include_str!("wrong/formulas.toml");

/// A text in the file, what it becomes, what the caret stands under, and what the message holds. What is wrong in any formula is in
/// `expression.rs`.
const BAD: &str = include_str!("wrong/formulas.txt");

#[test]
fn a_wrong_formula_is_an_error_with_its_line_and_a_caret() {
    refuses_each(TOP, BAD, 58, |_, rest, caret| rest.starts_with(caret));
}

#[test]
fn a_deep_or_long_formula_in_a_file_is_refused_with_its_line() {
    for hostile in ["(".repeat(100_000), "t+".repeat(4_900)] {
        let error = SystemFile::parse(&TOP.replacen("weight*dot(r, Gamma)", &hostile, 1)).unwrap_err();
        assert_eq!(error.line, 18, "{}", error.message);
    }
}

/// Why a run ends early.
fn reason(text: &str) -> Option<String> {
    ran::<f64>(&parsed(text), None).unwrap().1.reason
}

#[test]
fn an_operation_without_a_value_stops_the_run_with_its_place() {
    let refused = |from: &str, to: &str| {
        assert!(TOP.contains(from), "{from}");
        reason(&TOP.replacen(from, to, 1)).expect("a refusal")
    };
    let start = refused("\"-eta/10\"", "\"-eta/(10*t)\"");
    assert!(start.contains("the force at the start of the step has no finite value"), "{start}");
    assert!(start.contains("column 5: division by zero\n    -eta/(10*t)\n        ^"), "{start}");
    let stage = refused("\"-eta/10\"", "\"-sqrt(1/50 - t)*eta\"");
    assert!(stage.contains("the force at stage ") && stage.contains("column 2: the square root of -"), "{stage}");
    let potential = refused("weight*dot(r, Gamma)", "log(1/50 - t)*dot(r, Gamma)");
    assert!(
        potential.contains("the force at stage ") && potential.contains("column 1: the logarithm of -"),
        "{potential}"
    );
    let overflow = refused("weight*dot(r, Gamma)", "exp(1000 + t)*dot(r, Gamma)");
    assert!(overflow.contains("the value is too large"), "{overflow}");
}

/// Two cases in which a root was accepted that is none: cancellation, and a branch behind a fold.
#[test]
fn no_root_is_accepted_that_is_not_one() {
    // The branch from h = 0 leads to (3.504, −9.781), by way of (0.891, −2.957) at h = 20; in 16 digits Newton's method at the full step
    // found (4.0e8, −1.6e-21).
    let right = [3.504_239_662_287_721, -9.780_890_175_418_896];
    let file = parsed(include_str!("cases/cancelling.toml"));
    let quad = last::<Dd>(&file).iter().map(|v| v.to_f64()).collect();
    for (row, bound) in [(last::<f64>(&file), 1e-9), (quad, 1e-14)] {
        assert!((0..2).all(|a| (row[1 + a] - right[a]).abs() < bound * right[a].abs()), "{row:?}");
    }
    let folded = |step: &str| include_str!("cases/folded.toml").replacen("17.6", step, 1);
    assert_eq!(reason(&folded("17.6")), None);
    for step in ["17.7", "18", "19", "20", "21", "22", "25", "30", "50"] {
        let refused = reason(&folded(step)).unwrap_or_else(|| panic!("{step} was accepted"));
        assert!(refused.contains("fold") || refused.contains("no convergence"), "{step}: {refused}");
    }
}
