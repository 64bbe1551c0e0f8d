//! `algebras`: the algebras that files may name, with their bases.

use super::{Failure, print};
use euler_poincare::system::{algebra_text, named_algebras};
use std::process::ExitCode;

/// Options of `algebras`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A name, or a product such as so3+r2; without one: every name, with its dimension
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

const PRODUCTS: &str = "\nr1 to r10 are the abelian ones; `+` makes products of dimension 10 at most, as in so3+r2.\n\
                        `euler-poincare algebras NAME` prints a basis and the brackets; E_12 has a single 1, in row 1 and column 2.\n";

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let refused = |error: euler_poincare::system::CaseError| Failure::Usage(error.problem.to_string());
    let text = match arguments.name {
        Some(name) => algebra_text(&name).map_err(refused)?,
        None => {
            let first = |name| Ok(algebra_text(name).map_err(refused)?.lines().next().unwrap_or_default().to_owned());
            let lines = named_algebras().map(first).collect::<Result<Vec<String>, Failure>>()?;
            format!("{}\n{PRODUCTS}", lines.join("\n"))
        }
    };
    print(&text)?;
    Ok(ExitCode::SUCCESS)
}
