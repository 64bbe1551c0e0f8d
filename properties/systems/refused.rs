//! Files with formulas that are wrong: each is an error with the line, and the caret where it goes wrong.

use super::refuses::refuses_each;
use super::{last, parsed, ran};
use euler_poincare::scalar::{Dd, Scalar};
use euler_poincare::system::SystemFile;

const TOP: &str = r#"format = 1

[parameters]
weight = "1.3"
r = ["0.3", "-0.2", "0.5"]

[definitions]
Gamma = "row(R, 3)"

[algebra]
name = "so3"

[lagrangian]
inertia = ["1/2", 2, 1]

[[potential]]
kind = "formula"
value = "weight*dot(r, Gamma)"

[[force]]
kind = "formula"
components = "-eta/10"

[[force]]
kind = "attitude-control"
stiffness = 1
damping = 2

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

/// A text in the file, what it becomes, what the caret stands under, and what the message holds. What is wrong in any formula is in
/// `expression.rs`.
const BAD: &str = r#"
# The potential.
weight*dot(r, Gamma) | weight*Gamma | "weight*Gamma | is a vector of 3 components; allowed: a number
weight*dot(r, Gamma) | weight*eta_2 | "weight*eta_2 | is a function of eta_2; allowed: a function of t and g
weight*dot(r, Gamma) | weight*mu[1] | "weight*mu[1] | is a function of mu_1
weight*dot(r, Gamma) | weight/(1 - 1) | /(1 | division by a constant that is zero
weight*dot(r, Gamma) | g_44 | g_44 | unknown name `g_44`
weight*dot(r, Gamma) | g[4, 1] | 4, 1] | the index 4 is too large; allowed: 1 to 3
weight*dot(r, Gamma) | g_11 + | " | does not belong here
value = "weight | valve = "weight |  | unknown field `valve`
kind = "formula"\nvalue | kind = "form"\nvalue |  | unknown kind of potential `form`
# The force.
"-eta/10" | "-eta_1/10" | "-eta_1/10" | is a number; allowed: a vector of 3 components
"-eta/10" | ["-eta_1", "-eta_2"] | [ | is a vector of 2 components; allowed: a vector of 3 components
"-eta/10" | "[eta_1, eta_2, eta_4]" | eta_4 | unknown name `eta_4`
"-eta/10" | 3 | 3
components = "-eta/10" |  | [[force]] | `components` is missing
components | component | component | unknown field `component`
components = "-eta/10" | components = "-eta/10"\nalpha = 1 | 1 | takes `components`
damping = 2 |  | [[force]] | `damping` is missing
damping = 2 | damping = "1/0" | "1/0" | zero
# Numbers that name parameters.
["1/2", 2, 1] | ["2*wieght", 2, 1] | wieght | unknown name `wieght`; did you mean `weight`?
step = "1/8" | step = "r/8" | r/8 | `r` is a list; its numbers are `r_1` to `r_3`
step = "1/8" | step = "r[4]" | r[4] | `r` is a list
step = "1/8" | step = "1/8 + Gamma" | Gamma | unknown name `Gamma`; a number has
step = "1/8" | step = "cos(weight)" | cos | unknown name `cos`
step = "1/8" | step = "1/8 weight" | "1/8 | is not a number
step = "1/8" | step = "weight/(13/10 - weight)" | "weight | which is zero
damping = 2 | damping = "2*dampin" | dampin" | unknown name `dampin`
weight = "1.3" | weight = "2*weight" | weight" | the parameter `weight` has no value: it is no number, or names itself
weight = "1.3" | weight = "b"\nb = "weight" | weight" | the parameter `weight` has no value
weight = "1.3" | deg = "1.3" |  | `deg` is a function or a constant
inertia = ["1/2", 2, 1] |  | lagrangian] | `inertia` is missing: n numbers
# Parameters and definitions.
weight = "1.3" | weight = "1.3.1" | "1.3.1" | is not a number
weight = "1.3" | weight = "1/0" | "1/0" | zero
weight = "1.3" | weight = true | true | boolean
weight = "1.3" | t = "1.3" | "1.3" | `t` has a meaning already
weight = "1.3" | eta_1 = "1.3" | "1.3" | `eta_1` has a meaning already
weight = "1.3" | sin = "1.3" | "1.3" | `sin` is a function or a constant
weight = "1.3" | Gamma = "1.3" | "row(R, 3)" | `Gamma` has a meaning already
weight = "1.3" | "a b" = "1.3" | "1.3" | is no name
weight = "1.3" | weight = 0.61298730661989954773839539357 | 0.6129 | a number of 29 digits loses some of them
row(R, 3) | row(R, 4) | 4) | the index 4 is too large; allowed: 1 to 3
row(R, 3) | row(Q, 3) | Q, 3) | unknown name `Q`
row(R, 3) | Gamma + r | Gamma + r | `Gamma` is defined by itself
Gamma = "row(R, 3)" | Gamma = "1*Delta"\nDelta = "2*Gamma" | Delta" | `Delta` is defined by itself
Gamma = "row(R, 3)" | Gamma = "row(R, 3)"\nunused = "1 +" | " | does not belong here
Gamma = "row(R, 3)" | Gamma = 3 | 3 | expected a string
# The Lagrangian, the group and the state.
inertia = ["1/2", 2, 1] | formula = "dot(eta, mu)/2" | "dot(eta, mu) | is a function of mu_1
inertia = ["1/2", 2, 1] | formula = "eta" | "eta" | is a vector of 3 components; allowed: a number
inertia = ["1/2", 2, 1] | formula = "eta_1" | ["0.5" | singular
inertia = ["1/2", 2, 1] | formula = "dot(eta, eta)"\ninertia = [1, 1, 1] | "dot(eta | stands alone
name = "so3" | name = "se2" | R, 3) | unknown name `R`
rotation-vector = ["0.4", "-0.3", "0.2"] | quaternion = [1, 0, 0] | [1, 0, 0] | 3 entries; allowed: 4
rotation-vector = ["0.4", "-0.3", "0.2"] | quaternion = [0, 0, 0, 0] | [0, 0, 0, 0] | a quaternion that is not 0
rotation-vector = ["0.4", "-0.3", "0.2"] | matrix = [[1, 0, 0], [0, 1, 0], [0, 0, 2]] | [[1 | not in the group
rotation-vector = ["0.4", "-0.3", "0.2"] | euler = [1, 2, 3]\naxes = "abc" | "abc" | three of x, y and z
rotation-vector = ["0.4", "-0.3", "0.2"] | euler = [1, 2, 3]\naxes = "xxy" | "xxy" | no two neighbours alike
rotation-vector = ["0.4", "-0.3", "0.2"] | euler = [1, 2] | [1, 2] | 2 entries; allowed: 3
rotation-vector | position = [1, 2, 3]\nrotation-vector | [1, 2, 3] | for the algebra se3
rotation-vector | attitude = [1, 2, 3]\nrotation-vector | ["0.4" | either `attitude` or `rotation-vector`
"#;

#[test]
fn a_wrong_formula_is_an_error_with_its_line_and_a_caret() {
    refuses_each(TOP, BAD, |_, rest, caret| rest.starts_with(caret));
}

#[test]
fn deep_and_long_formulas_are_refused() {
    for hostile in ["(".repeat(100_000), "[".repeat(9_000), "-".repeat(9_000), "sin(".repeat(2_000), "t+".repeat(4_900)]
    {
        let text = TOP.replacen("weight*dot(r, Gamma)", &hostile, 1);
        let error = SystemFile::parse(&text).unwrap_err();
        assert_eq!(error.line, 18, "{}", error.message);
    }
}

/// Why a run ends early.
fn reason(text: &str) -> Option<String> {
    ran::<f64>(&parsed(text), None).unwrap().1
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
    let cancelling = r#"format = 1
[algebra]
dimension = 2
constants = [[1, 2, 2, 1]]
[lagrangian]
inertia = [["5/4", "3/8"], ["3/8", "3/4"]]
[[force]]
kind = "linear-drag"
matrix = [["25/64", "3/32"], ["-13/32", "5/16"]]
[[force]]
kind = "constant"
value = ["1/8", "-1/4"]
[method]
tableau = "gauss-1"
retraction = "exp"
[state]
momentum = ["-3/4", 1]
[run]
step = 50
steps = 1
"#;
    // The branch from h = 0 leads to (3.504, −9.781), by way of (0.891, −2.957) at h = 20; in 16 digits Newton's method at the full step
    // found (4.0e8, −1.6e-21).
    let right = [3.504_239_662_287_721, -9.780_890_175_418_896];
    let file = parsed(cancelling);
    let quad = last::<Dd>(&file).iter().map(|v| v.to_f64()).collect();
    for (row, bound) in [(last::<f64>(&file), 1e-9), (quad, 1e-14)] {
        assert!((0..2).all(|a| (row[1 + a] - right[a]).abs() < bound * right[a].abs()), "{row:?}");
    }
    let folded = |step: &str| {
        format!(
            "format = 1\n[algebra]\nname = \"so3\"\n[lagrangian]\ninertia = [[1, \"1/4\", 0], [\"1/4\", 2, \"1/8\"], [0, \"1/8\", 3]]\n\
             [method]\ntableau = \"gauss-3\"\nretraction = \"exp\"\n[state]\nmomentum = [\"3/4\", \"1/2\", -1]\n[run]\nstep = {step}\nsteps = 1\n"
        )
    };
    assert_eq!(reason(&folded("17.6")), None);
    for step in ["17.7", "18", "19", "20", "21", "22", "25", "30", "50"] {
        let refused = reason(&folded(step)).unwrap_or_else(|| panic!("{step} was accepted"));
        assert!(refused.contains("fold") || refused.contains("no convergence"), "{step}: {refused}");
    }
}
