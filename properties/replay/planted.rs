// The law retraction-adjoint on one system,
// with the fault adjoint-inverted planted in what it judges.
// Prints the verdict. The system is case 4 of seed 7, shrunk. In Cargo.toml:
//     [dependencies.euler-poincare]
//     version = "0.1.0"
//     default-features = false
//     features = ["harness"]

use euler_poincare::harness::{Law, Verdict, verdict_on};
use euler_poincare::laws;
use euler_poincare::system::Case;
use std::error::Error;

const CASE: &str = r#"
format = 1

[algebra]
name = "se2"
basis = [[1, "1/4", 0], [0, 1, 0], ["-1/2", 0, 1]]

[lagrangian]
inertia = [1, "3/4", 2]

[[force]]
kind = "linear-drag"
coefficient = "1/8"

[method]
tableau = "gauss-2"
retraction = "cayley"

[state]
momentum = [1, 0, "-1/2"]
attitude = ["1/2", 0, 0]

[run]
step = "1/8"
"#;

fn verdict() -> Result<Verdict, Box<dyn Error>> {
    let law = laws::named("retraction-adjoint").ok_or("no such law")?;
    let fault = law.fault("adjoint-inverted").ok_or("no such fault")?;
    let case = Case::from_toml(CASE)?;
    Ok(verdict_on(law, &case, Some(fault)))
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("{}", verdict()?);
    Ok(())
}
