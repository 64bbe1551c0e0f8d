//! Measures, prints the table, writes the file and the plot.

use peers::contender;
use peers::figure;
use peers::machine::Machine;
use peers::measure::{Plan, measure};
use peers::problem::Problem;
use peers::report::{Panel, Report};
use peers::rounding;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

const USAGE: &str = "\
usage: peers [--quick] [--svg PATH] [--json PATH] [--only WORD]...
       peers --rounding

  --quick      a second or two, to see that everything works: it fails if a contender gives no answer, or ours
               misses a tolerance; its times say little
  --svg PATH   the plot (default: work-precision.svg here; with --quick: none)
  --json PATH  every error and time (default: work-precision.json here; with --quick: none)
  --only WORD  only problems and contenders that have the word in their name
  --rounding   instead: how rounding errors grow over 10^7 steps, in a minute or two; it fails if faster than n^0.6
";

#[derive(Default)]
struct Arguments {
    quick: bool,
    svg: Option<PathBuf>,
    json: Option<PathBuf>,
    only: Vec<String>,
    rounding: bool,
}

fn arguments() -> Result<Arguments, String> {
    let mut arguments = Arguments::default();
    let mut words = std::env::args().skip(1);
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} needs a value\n\n{USAGE}"));
        match word.as_str() {
            "--quick" => arguments.quick = true,
            "--svg" => arguments.svg = Some(value()?.into()),
            "--json" => arguments.json = Some(value()?.into()),
            "--only" => arguments.only.push(value()?),
            "--rounding" => arguments.rounding = true,
            _ => return Err(format!("unknown argument {word}\n\n{USAGE}")),
        }
    }
    if !arguments.quick {
        arguments.svg.get_or_insert("work-precision.svg".into());
        arguments.json.get_or_insert("work-precision.json".into());
    }
    Ok(arguments)
}

fn run(arguments: &Arguments) -> Result<(), Box<dyn Error>> {
    if arguments.rounding {
        return rounding::run();
    }
    let plan = if arguments.quick { Plan::quick() } else { Plan::full() };
    let mut contenders = contender::all();
    let mut problems = Problem::all();
    problems.retain(|p| p.end <= plan.longest_end);
    for word in &arguments.only {
        let named = |name: &str| name.to_lowercase().contains(&word.to_lowercase());
        if problems.iter().any(|p| named(&p.title())) {
            problems.retain(|p| named(&p.title()));
        } else {
            contenders.retain(|c| named(c.name()));
        }
    }
    let mut report = Report { machine: Machine::find(), panels: Vec::new() };
    for problem in &problems {
        eprintln!("{} …", problem.title());
        let runs = measure(&mut contenders, problem, &plan);
        report.panels.push(Panel { system: problem.system.name(), end: problem.end, title: problem.title(), runs });
    }
    print!("{}", report.text());
    eprint!("{}", report.notes());
    if let Some(path) = &arguments.json {
        std::fs::write(path, serde_json::to_string_pretty(&report)? + "\n")?;
        println!("wrote {}", path.display());
    }
    if let Some(path) = &arguments.svg {
        std::fs::write(path, figure::svg(&report)?)?;
        println!("wrote {}", path.display());
    }
    let faults = if arguments.quick { report.faults() } else { Vec::new() };
    if faults.is_empty() { Ok(()) } else { Err(faults.join("\n").into()) }
}

fn main() -> ExitCode {
    match arguments().map_err(Box::from).and_then(|arguments| run(&arguments)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
