//! Says where the command learns its commit from, see `src/cli/version.rs`: from the repository of this package, or from the
//! file that `cargo package` adds. And which pages the documentation has: those with rendered formulas where `properties/guide` has
//! written them, else their source.
//!
//! Nothing here follows the state of the repository: each commit would compile the library again.

use std::path::Path;
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    println!("cargo::rustc-check-cfg=cfg(own_repository)");
    let variable = |name| env::var(name).unwrap_or_default();
    let package = variable("CARGO_MANIFEST_DIR");
    let guide = Path::new(&package).join("src/guide");
    println!("cargo::rerun-if-changed={}", guide.display());
    let pages = [guide.join("rendered"), guide.join("source")].into_iter().find(|pages| pages.exists());
    println!("cargo::rustc-env=GUIDE={}", pages.unwrap_or(guide).display());
    // A copy inside another repository has no `.git` of its own: the commit of the other one says nothing about it.
    if Path::new(&package).join(".git").exists() {
        println!("cargo::rustc-cfg=own_repository");
    } else {
        let packed = fs::read_to_string(Path::new(&package).join(".cargo_vcs_info.json")).ok();
        let commit = packed.as_deref().and_then(commit).map(|commit| format!(" ({commit})")).unwrap_or_default();
        println!("cargo::rustc-env=EULER_POINCARE_VERSION={}{commit}", variable("CARGO_PKG_VERSION"));
    }
}

/// The commit in `.cargo_vcs_info.json`, in 12 digits, and whether the files differed from it.
fn commit(file: &str) -> Option<String> {
    let (_, rest) = file.split_once("\"sha1\"")?;
    let digits = rest.split('"').nth(1)?.get(..12).filter(|digits| digits.bytes().all(|b| b.is_ascii_hexdigit()))?;
    let dirty =
        rest.split_once("\"dirty\"").is_some_and(|(_, value)| value.trim_start_matches([':', ' ']).starts_with("true"));
    Some(format!("{digits}{}", if dirty { ", modified" } else { "" }))
}
