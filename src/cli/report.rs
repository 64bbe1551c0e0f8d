//! `report DIR`: a campaign as one page for a browser.

mod again;
pub mod chart;
mod coverage;
pub mod elements;
mod failures;
mod faults;
mod files;
pub mod formula;
pub mod numbers;
pub mod orders;
mod page;
mod script;
mod tally;
pub mod undecided;
pub mod verdicts;

use super::table::paragraph;
use super::{Failure, output, print};
use files::Found;
use page::Totals;
use std::path::PathBuf;
use std::process::ExitCode;

/// Options of `report`.
#[derive(clap::Args)]
pub struct Arguments {
    /// A directory that `verify --out DIR` wrote; the campaign need not be complete
    #[arg(value_name = "DIR")]
    directory: PathBuf,
    /// Where the page goes; `-` is standard output [default: DIR/report.html]
    #[arg(long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Cases of each law of orders that are run again to plot their errors
    #[arg(long, value_name = "N", default_value_t = 3, allow_negative_numbers = true)]
    #[arg(value_parser = clap::value_parser!(u16).range(0..=100))]
    plots: u16,
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let found = Found::read(&arguments.directory)?;
    let path = arguments.output.unwrap_or_else(|| arguments.directory.join("report.html"));
    let file = if path.as_os_str() == "-" { None } else { Some(output::create(&path)?) };
    let (orders, failures) = again::run(&found, usize::from(arguments.plots));
    let page = page::page(&found, &orders, &failures);
    let Some(file) = file else {
        print(&page)?;
        return Ok(ExitCode::SUCCESS);
    };
    output::write(file, &path, &page)?;
    print(&format!("{}\n{}\n", paragraph(&Totals::of(&found).outcome()), path.display()))?;
    Ok(ExitCode::SUCCESS)
}
