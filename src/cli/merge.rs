//! `merge`: the shards of a campaign, put together.

use super::table::paragraph;
use super::{Failure, print};
use euler_poincare::harness::store;
use std::path::PathBuf;
use std::process::ExitCode;

/// Options of `merge`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The directories of all shards, in any order
    #[arg(required = true, value_name = "DIR")]
    shards: Vec<PathBuf>,
    /// Where the whole goes: a directory without a campaign, and none of the shards
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let merged = store::merge(&arguments.shards, &arguments.out)?;
    let laws = merged.store.manifest().laws.len();
    let shards = arguments.shards.len();
    let mut text = format!("shards: {shards}, laws: {laws}, records: {}\n", merged.records);
    for (law, count) in &merged.broken {
        text += &format!("BROKEN {law}: {count} cases\n");
    }
    for (law, index) in &merged.unshrunk {
        let line = format!("no shrunk case of {law} (case {index}): `verify --resume` on the whole makes it");
        text += &(paragraph(&line) + "\n");
    }
    print(&format!("{text}results in {}\n", arguments.out.display()))?;
    Ok(ExitCode::SUCCESS)
}
