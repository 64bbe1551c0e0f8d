//! A failing case as a program: what a person pastes into an editor.

use super::replay::Replay;

/// A complete Rust program that prints the verdict of `replay`'s law on its case, with the fault planted if there is one.
///
/// It needs this crate with the feature `harness`, and nothing else; the case stands in it as TOML, in exact numbers.
pub fn snippet(replay: &Replay) -> String {
    let (law, seed, index) = (&replay.law, replay.seed, replay.index);
    let (planted, fault, passed, imported) = match &replay.fault {
        None => (String::new(), String::new(), "None", ""),
        Some(name) => (
            format!(",\n// with the fault {name} planted in what it judges"),
            format!("    let fault = law.fault({name:?}).ok_or(\"no such fault\")?;\n"),
            "Some(fault)",
            "Law, ",
        ),
    };
    let case = match replay.case.to_toml() {
        Ok(text) => text,
        // No case that this crate has built: then the program says so, when it reads it.
        Err(error) => format!("# {error}\n"),
    };
    let hashes = "#".repeat(longest_hashes(&case) + 1);
    format!(
        r#"// The law {law} on one system{planted}.
// Prints the verdict. The system is case {index} of seed {seed}, shrunk. In Cargo.toml:
//     [dependencies.euler-poincare]
//     version = "{version}"
//     default-features = false
//     features = ["harness"]

use euler_poincare::harness::{{{imported}Verdict, verdict_on}};
use euler_poincare::laws;
use euler_poincare::system::Case;
use std::error::Error;

const CASE: &str = r{hashes}"
{case}"{hashes};

fn verdict() -> Result<Verdict, Box<dyn Error>> {{
    let law = laws::named({law:?}).ok_or("no such law")?;
{fault}    let case = Case::from_toml(CASE)?;
    Ok(verdict_on(law, &case, {passed}))
}}

fn main() -> Result<(), Box<dyn Error>> {{
    println!("{{}}", verdict()?);
    Ok(())
}}
"#,
        version = env!("CARGO_PKG_VERSION"),
    )
}

/// The longest run of # behind a quotation mark: a raw string needs one more.
fn longest_hashes(text: &str) -> usize {
    let runs = text.split('"').skip(1).map(|rest| rest.bytes().take_while(|byte| *byte == b'#').count());
    runs.max().unwrap_or(0)
}
