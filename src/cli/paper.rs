//! `paper`: the table of errors and the figures of Martín de Diego and Sato Martín de Almagro 2019, §5.3.

use super::progress::Bar;
use super::table::{Column, Table};
use super::{Failure, figures, output, print};
use euler_poincare::experiments::{Errors, Method, Problem, Reference, errors, expected};
use euler_poincare::study::Reading;
use std::fmt::Display;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Options of `paper`.
#[derive(clap::Args)]
pub struct Arguments {
    /// The directory for errors.csv and figure-5.1.svg to figure-5.5.svg; created if it is missing
    #[arg(long, value_name = "DIR", default_value = "paper")]
    out: PathBuf,
}

/// Measures, writes the files, and prints the comparison with the expected errors.
pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let out = &arguments.out;
    // First, so that a directory that cannot be written is found before the work is done.
    let target = out.join("errors.csv");
    std::fs::create_dir_all(out).map_err(|e| Failure::file(out, e))?;
    let table = output::create(&target)?;
    let found = measure()?;
    let failed = |e: &dyn Display| Failure::Computation(e.to_string());
    let mut files = vec![(target, table, text(&found).map_err(|e| failed(&e))?)];
    for (name, figure) in figures::all(&found).map_err(|e| failed(&e))? {
        let path = out.join(name);
        let file = output::create(&path)?;
        files.push((path, file, figure.svg().map_err(|e| failed(&e))?.into_bytes()));
    }
    // All of them are on the disk before the first takes its place.
    for (path, file, bytes) in &mut files {
        file.write_all(bytes).and_then(|()| file.flush()).map_err(|e| Failure::file(path, e))?;
    }
    for (path, file, _) in files {
        file.commit().map_err(|e| Failure::file(&path, e))?;
    }
    print(&summary(&found, out))?;
    Ok(ExitCode::SUCCESS)
}

fn measure() -> Result<Vec<Errors>, Failure> {
    let runs = 2 * Method::TABULATED.len() * (errors::FINEST as usize + 1);
    let bar = Bar::new(&[("llg", Some(runs), 1), ("relaxed", Some(runs), 1)], None, None);
    let found = Problem::ALL.map(|problem| {
        let reference = Reference::compute(problem)?;
        errors::table(&reference, &Method::TABULATED, errors::FINEST, &|| bar.advance(problem.name()))
    });
    bar.clear();
    let found: Result<Vec<_>, _> = found.into_iter().collect();
    Ok(found.map_err(|e| Failure::Computation(e.to_string()))?.concat())
}

/// The steps that had a root, and the errors with them.
fn rows(errors: &Errors) -> impl Iterator<Item = (f64, &[Reading])> {
    errors.findings.rows().iter().filter_map(|row| Some((row.h, row.readings.as_deref().ok()?)))
}

fn text(found: &[Errors]) -> csv::Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    writer.write_record([
        "problem",
        "method",
        "retraction",
        "scalar",
        "h",
        "error_momentum",
        "error_energy",
        "error_casimir",
    ])?;
    for errors in found {
        for (h, readings) in rows(errors) {
            let (problem, method) = (errors.problem.name().to_owned(), errors.method.to_string());
            let named = [problem, method, "cayley".into(), errors.scalar.into(), h.to_string()];
            writer.write_record(named.into_iter().chain(readings.iter().map(|r| format!("{:.9e}", r.error))))?;
        }
    }
    writer.into_inner().map_err(|error| error.into_error().into())
}

/// The momentum errors in 32 digits, each with the ratio to the expected one.
fn summary(found: &[Errors], out: &Path) -> String {
    let mut table = Table::new(&[
        Column::name("problem"),
        Column::name("method"),
        Column::number("1/h"),
        Column::number("|M - M(1)|"),
        Column::number("expected"),
        Column::number("ratio"),
    ]);
    let (mut agree, mut count) = (0, 0);
    for column in &expected::TABLE {
        let errors = found.iter().find(|e| (e.problem, e.method, e.scalar) == (column.problem, column.method, "dd"));
        for level in 0..=errors::FINEST {
            let row = errors.and_then(|errors| errors.findings.rows().get(level as usize)?.readings.as_deref().ok());
            let (found, wanted) = (row.and_then(|row| Some(row.first()?.error)), column.error(level));
            let text = |value: Option<f64>| value.map_or("none".into(), expected::shown);
            let ratio = found.zip(wanted).map_or(String::new(), |(f, w)| format!("{:.4}", f / w));
            if wanted.is_some() {
                count += 1;
                agree += usize::from(text(found) == text(wanted));
            }
            let wanted = if found.is_some() && wanted.is_none() { String::new() } else { text(wanted) };
            let (problem, method) = (column.problem.name().into(), column.method.to_string());
            table.row([problem, method, (1u32 << level).to_string(), text(found), wanted, ratio]);
        }
    }
    format!(
        "{}\n\n{agree} of {count} expected errors reproduced to the three digits shown.\n\
         {} rows in {}; figures 5.1 to 5.5 beside it.\n",
        table.text(),
        found.iter().flat_map(rows).count(),
        out.join("errors.csv").display()
    )
}
