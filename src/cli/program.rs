//! Which program this is: what a campaign's records depend on.

use super::Failure;
use euler_poincare::harness::Law;
use euler_poincare::harness::store::Manifest;
use sha2::{Digest, Sha256};
use std::env;
use std::fs;

/// The manifest of a campaign of this program: its version, and the SHA-256 of its file.
pub fn manifest<C>(seed: u64, cases: Option<usize>, laws: &[&dyn Law<C>]) -> Result<Manifest, Failure> {
    let unknown = |error| Failure::System(format!("cannot read this program's own file: {error}"));
    let bytes = env::current_exe().and_then(fs::read).map_err(unknown)?;
    let hash: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    Ok(Manifest::new(env!("CARGO_PKG_VERSION"), &hash, seed, cases, laws))
}
