//! Systems that users sent, each with what is right for it: a file in `cases`, and a short function here.

use super::{Run, parsed, ran, rows};
use euler_poincare::system::{SystemFile, note::Note};
use std::path::Path;

/// The text of a case.
fn text(name: &str) -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("properties/systems/cases").join(name).with_extension("toml");
    std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// A run that reaches its end, with the rows of the file.
#[track_caller]
fn whole(text: &str) -> Run {
    let file = parsed(text);
    Run::with(&file, rows(&file, None))
}

/// The same text with one part instead of another, which it has.
fn with(text: &str, old: &str, new: &str) -> String {
    assert!(text.contains(old), "{old}");
    text.replace(old, new)
}

/// NASA/TM-2015-218675, check-case 2, by an independent Taylor integration; degrees in a second.
#[test]
fn brick() {
    let text = text("brick");
    let in_degrees = "velocity = [\"10 deg\", \"2*10 deg\", \"60/2 deg\"]";
    let texts = [
        with(&text, "velocity = [\"10*pi/180\", \"20*pi/180\", \"30*pi/180\"]", in_degrees),
        format!(
            "{}\n[parameters]\nw = [10, \"20 deg\"]\n",
            with(&text, "\"10*pi/180\", \"20*pi/180\"", "\"w_1 deg\", \"w[2]\"")
        ),
        text,
    ];
    for text in texts {
        let run = whole(&text);
        let right = [12.61839078, -17.39747476, 31.11958889];
        for (found, right) in run.eta(run.last()).iter().zip(right) {
            assert!((found.to_degrees() - right).abs() < 1e-8, "{found} {right}");
        }
    }
}

/// Byte for byte what it gives with the numbers instead of the names.
#[test]
fn parameters_everywhere() {
    let text = text("parameters-everywhere");
    let mut written = with(&text, "\"ixx\", \"iyy\", \"izz\"", "0.0123, 0.0234, 0.03");
    for (old, new) in [("\"0.01*spin\", \"spin\"", "\"0.01*12\", 12"), ("\"60/spin\"", "\"60/12\"")] {
        written = with(&written, old, new);
    }
    let (named, written) = (parsed(&text), parsed(&written));
    assert_eq!(named, written);
    let (run, other) = (rows::<f64>(&named, None), rows::<f64>(&written, None));
    assert!(run == other && (run.last().unwrap()[0] - 5.0).abs() < 1e-12);
}

/// l = η₁ has no velocities: refused at the start, and where the momentum is given; so is a rank of 2.
#[test]
fn singular_lagrangian() {
    let text = text("singular-lagrangian");
    for (formula, rank) in [("eta_1", 0), ("(eta_1^2 + eta_2^2)/2", 2), ("(eta_1 + eta_2)^2 + eta_3^2", 2)] {
        for motion in ["velocity = [1, 0, 1]", "velocity = [0, 0, 0]", "momentum = [0, 0, 0]"] {
            let text = with(&with(&text, "\"eta_1\"", &format!("{formula:?}")), "velocity = [1, 0, 1]", motion);
            let error = SystemFile::parse(&text).unwrap_err();
            let said = format!("is singular (its rank is {rank}, not 3) at the velocity");
            assert!(error.message.contains(&said), "{formula}, {motion}: {error}");
            assert!(error.excerpt.contains(if motion.starts_with('v') { "formula" } else { "momentum" }), "{error}");
        }
    }
}

/// l'' = cos η₁ vanishes at a quarter of a turn a second, where μ₁ = 1 is the largest: a torque takes the body there.
#[test]
fn a_lagrangian_that_becomes_singular() {
    let text = with(&text("singular-lagrangian"), "\"eta_1\"", "\"-cos(eta_1) + (eta_2^2 + eta_3^2)/2\"");
    let text = with(&text, "velocity = [1, 0, 1]", "velocity = [0, 0, 0]");
    let text = with(&text, "[method]", "[[force]]\nkind = \"constant\"\nvalue = [0.3, 0, 0]\n[method]");
    for text in [text.clone(), with(&with(&text, "step = \"1/8\"", "tolerance = 1e-8"), "tableau = \"gauss-2\"\n", "")]
    {
        let (rows, ended) = ran::<f64>(&parsed(&text), None).unwrap();
        let (last, reason) = (rows.last().expect("a row"), ended.reason.expect("an error"));
        assert!(last[0] > 2.5 && last[0] < 1.0 / 0.3 + 1e-6, "{last:?}: {reason}");
        assert!(rows.iter().flatten().all(|x| x.is_finite()));
    }
}

/// Three digits are a rotation, one digit is none; a note says by how much.
#[test]
fn matrix_with_three_digits() {
    let text = text("10-matrix-with-three-digits");
    let run = whole(&text);
    let (c, s) = (0.75f64.sqrt(), 0.5);
    for (k, right) in [c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0].into_iter().enumerate() {
        let found = run.g(&run.rows[0], k / 3 + 1, k % 3 + 1);
        assert!((found - right).abs() < 2e-5, "{found} {right}");
    }
    let file = parsed(&text);
    let [Note::Corrected { departure, moved }] = file.case.notes()[..] else { panic!("{:?}", file.case.notes()) };
    assert!((departure - 4.4e-5).abs() < 1e-6 && moved > 5e-6 && moved < 5e-5, "{departure:e}, {moved:e}");
    for (algebra, inertia, zeros) in
        [("so3+r1", "[1, 1, 2, 1]", "[0, 0, 3, 0]"), ("r1+so3", "[1, 1, 1, 2]", "[0, 0, 0, 3]")]
    {
        let text = with(&with(&text, "\"so3\"", &format!("{algebra:?}")), "[1, 1, 2]", inertia);
        let text = with(&text, "[0, 0, 3]", zeros);
        let turn = "[0.866, -0.5, 0], [0.5, 0.866, 0], [0, 0, 1]";
        let beside = match algebra {
            "so3+r1" => {
                "[0.866, -0.5, 0, 0, 0], [0.5, 0.866, 0, 0, 0], [0, 0, 1, 0, 0], [0, 0, 0, 1, 7], [0, 0, 0, 0, 1]"
            }
            _ => "[1, 7, 0, 0, 0], [0, 1, 0, 0, 0], [0, 0, 0.866, -0.5, 0], [0, 0, 0.5, 0.866, 0], [0, 0, 0, 0, 1]",
        };
        let file = parsed(&with(&text, turn, beside));
        assert!(matches!(file.case.notes()[..], [Note::Corrected { .. }]), "{algebra}: {:?}", file.case.notes());
    }
    for (bad, size) in [("0.8", "1.1e-1"), ("-0.866", "1.0e0"), ("0.5", "5.0e-1")] {
        let error = SystemFile::parse(&with(&text, "[0.866, -0.5, 0]", &format!("[{bad}, -0.5, 0]"))).unwrap_err();
        assert!(error.message.contains("not in the group") && error.excerpt.starts_with("matrix"), "{size}: {error}");
    }
}

/// The motion keeps |μ|, the scheme to its order; the guide says so.
#[test]
fn spin_norm_drift() {
    let text = text("06-spin-norm-drift");
    let square = |run: &Run| run.mu(run.last()).iter().map(|x| x * x).sum::<f64>() - 1.0;
    let (two, three) = (square(&whole(&text)), square(&whole(&with(&text, "gauss-2", "gauss-3"))));
    assert!(two > 1e-4 && two < 1e-3 && three.abs() < 1e-6, "{two:e}, {three:e}");
    let guide = include_str!("../../src/guide/source/integrating.md");
    assert!(guide.contains("The scheme keeps\nthem without a force exactly, and with these forces to its order"));
    assert!(!guide.contains("keeps Casimirs |"));
}
