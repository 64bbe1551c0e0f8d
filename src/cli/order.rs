//! `order`: the orders of a tableau, declared, computed and measured, side by side.

mod figure;
mod text;

use super::{Failure, Format, print};
use clap::builder::PossibleValuesParser;
use euler_poincare::harness::Verdict;
use euler_poincare::harness::convergence::{Estimate, TOLERANCE};
use euler_poincare::laws::trial::{Digits, Judged};
use euler_poincare::scalar::Dd;
use euler_poincare::study::{Comparison, Findings, problem};
use euler_poincare::system::case::MAIN_DIMENSIONS;
use euler_poincare::system::{Case, SystemFile};
use euler_poincare::tableau::order::MAX_VARIATIONAL;
use euler_poincare::tableau::{Analysis, Description, TableauError, TableauFile, analyse};
use std::fs::{File, OpenOptions};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXPLANATION: &str = "\
declared     what the name or the file claims, as a Runge-Kutta method
classical    the order conditions of rooted trees, from the coefficients
variational  those of the pair (a, a-hat), from the coefficients: the order of the variational integrator
empirical    the slope of the errors in momentum and attitude, over a horizon and with steps that shrink to round-off

The verdict compares empirical and variational order. Exit codes: 0 confirmed, 1 refuted, 3 inconclusive, 2 bad usage or
a bad file. A tableau file has a = [[...], ...], b = [...] and, if wanted, c, order and name, in TOML or JSON; entries are
numbers or texts such as \"1/2 - sqrt(3)/6\"; decimals with three or more places count as rounded unless they are dyadic.";

/// Options of `order`.
#[derive(clap::Args)]
#[command(after_help = EXPLANATION)]
pub struct Arguments {
    /// A name (rk4, kutta38, heun2, ralston3, sdirk2, gauss-S, lobatto-iiia-S, ..., radau-iia-S) or a tableau file
    #[arg(long, value_name = "NAME|FILE")]
    tableau: String,
    /// The system that is integrated [default: a rigid body without symmetry, with drag and a torque that varies in time]
    #[arg(long, value_name = "SYSTEM.toml")]
    system: Option<PathBuf>,
    /// The digits of the arithmetic [default: 32; 16 where entries are decimals with the digits of an f64]
    #[arg(long, value_parser = PossibleValuesParser::new(["16", "32", "64"]))]
    digits: Option<String>,
    /// The order that is claimed, in place of that of the name or the file
    #[arg(long, value_name = "P", value_parser = clap::value_parser!(u32).range(1..=200))]
    declared: Option<u32>,
    /// A work plot: errors against the step, with the fitted line and its window
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// How the result is printed
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

/// What is known of the tableau on the system.
pub struct Outcome {
    /// The name, or the file's path.
    pub tableau: String,
    /// What is claimed.
    pub declared: Option<usize>,
    pub analysis: Analysis,
    /// The file of the system, if not the standard one.
    pub system: Option<PathBuf>,
    pub digits: Digits,
    pub horizon: f64,
    pub judged: Judged,
    pub notes: Vec<String>,
}

/// `confirmed`, `refuted`, `inconclusive`.
pub fn word(verdict: &Verdict) -> &'static str {
    match verdict {
        Verdict::Holds { .. } => "confirmed",
        Verdict::Broken { .. } => "refuted",
        Verdict::Inconclusive { .. } | Verdict::NotApplicable { .. } => "inconclusive",
    }
}

impl Outcome {
    /// The order that the measurement is held against.
    pub fn predicted(&self) -> u32 {
        self.analysis.findings().variational.order as u32
    }

    /// What the measurement shows: study, part of the state, estimate.
    pub fn empirical(&self) -> Option<(&'static str, usize, Estimate)> {
        let order = self.predicted();
        if self.judged.verdict.holds() && matches!(self.judged.trial.compare(order), Comparison::Below { .. }) {
            return self.judged.trial.horizon.deciding(order).map(|(quantity, found)| ("horizon", quantity, found));
        }
        self.judged.trial.slope(order)
    }

    /// Whether the claim is the order that the coefficients give in this scheme, to the digits given; `None` without a claim, and
    /// where it is higher than what was checked and nothing speaks against it.
    pub fn declared_holds(&self) -> Option<bool> {
        let (declared, orders) = (self.declared?, self.analysis.findings());
        let order = &orders.variational;
        if declared == order.order || order.broken.is_some() || declared < order.order {
            return Some(declared == order.order);
        }
        let quadrature = &orders.assumptions.b;
        (quadrature.fails.is_some() && declared > quadrature.holds).then_some(false)
    }
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let (description, mut analysis) = tableau(&arguments.tableau)?;
    let digits = match arguments.digits.as_deref() {
        Some("16") => Digits::Sixteen,
        Some("64") => Digits::SixtyFour,
        Some(_) => Digits::ThirtyTwo,
        None => enough(&description),
    };
    if let Some(declared) = arguments.declared {
        analysis.declared = Some(declared as usize);
    }
    let (mut case, horizon, notes) = system(arguments.system.as_deref())?;
    case.method.tableau = description;
    if digits == Digits::SixtyFour && !MAIN_DIMENSIONS.contains(&case.dimension()) {
        let dimension = case.dimension();
        return Err(Failure::Usage(format!(
            "--digits 64 is for algebras of dimension 2, 3, 4 and 6, and this one has {dimension}: use --digits 32"
        )));
    }
    if let Some(path) = &arguments.plot {
        writable(path, [Path::new(&arguments.tableau)].into_iter().chain(arguments.system.as_deref()))?;
    }
    let judged = judge(&case, digits, horizon, &analysis, arguments.system.as_deref())?;
    let outcome = Outcome {
        tableau: arguments.tableau,
        declared: analysis.declared,
        analysis,
        system: arguments.system,
        digits,
        horizon,
        judged,
        notes,
    };
    match arguments.format {
        Format::Text => print(&text::text(&outcome))?,
        Format::Json => print(&format!("{}\n", text::json(&outcome)))?,
    }
    if let Some(path) = &arguments.plot {
        figure::draw(&outcome, path).map_err(|reason| Failure::file(path, reason))?;
    }
    Ok(match outcome.judged.verdict {
        Verdict::Holds { .. } => ExitCode::SUCCESS,
        Verdict::Broken { .. } => ExitCode::from(1),
        Verdict::Inconclusive { .. } | Verdict::NotApplicable { .. } => ExitCode::from(3),
    })
}

/// Whether a figure can be written to `path`: known before the run, not after it, and without touching what is there.
fn writable<'a>(path: &Path, read: impl Iterator<Item = &'a Path>) -> Result<(), Failure> {
    let place = |path: &Path| path.canonicalize().ok();
    if read.into_iter().any(|other| place(other).is_some() && place(other) == place(path)) {
        return Err(Failure::Usage(format!("{} is read: the plot needs another file", path.display())));
    }
    let open = OpenOptions::new().append(true).create(true).open(path);
    open.map(drop).map_err(|error| Failure::file(path, error))
}

/// The tableau of a name or a file, analysed.
fn tableau(argument: &str) -> Result<(Description, Analysis), Failure> {
    let unknown = match argument.parse::<Description>() {
        Ok(description) => {
            let analysis = analysed(&description).map_err(|error| Failure::Usage(error.to_string()))?;
            return Ok((description, analysis));
        }
        Err(error) => error,
    };
    let path = Path::new(argument);
    if !path.exists() && !argument.contains(['/', '\\', '.']) {
        return Err(Failure::Usage(unknown.to_string()));
    }
    let mut text = String::new();
    let limit = euler_poincare::tableau::file::LONGEST as u64 + 1;
    File::open(path)
        .and_then(|file| file.take(limit).read_to_string(&mut text))
        .map_err(|error| Failure::file(path, error))?;
    let file = TableauFile::parse(&text).map_err(|error| Failure::file(path, error))?;
    let description = file.description();
    let mut analysis = analysed(&description).map_err(|error| Failure::file(path, error))?;
    analysis.declared = file.order;
    if let Some(name) = file.name {
        analysis.description = name;
    }
    Ok((description, analysis))
}

/// One order more than is checked for the pair: where the classical order ends there, that of the pair does.
fn analysed(description: &Description) -> Result<Analysis, TableauError> {
    analyse::<Dd>(description, MAX_VARIATIONAL + 1)
}

/// 32 digits; 16 for decimals that are as good as those of an `f64` and no better: 32 would show their rounding, and no more.
fn enough(description: &Description) -> Digits {
    let Description::Entries(entries) = description else { return Digits::ThirtyTwo };
    let numbers = entries.a.iter().flatten().chain(&entries.b);
    let off = numbers.map(|x| x.uncertainty::<f64>()).fold(0.0, f64::max);
    if off > 1e-26 && off < 2e-15 { Digits::Sixteen } else { Digits::ThirtyTwo }
}

/// The most steps of a system's file that the horizon of a study covers.
const MOST_STEPS: f64 = 128.0;

/// The case of a file, or the standard one; the horizon; what was changed.
fn system(path: Option<&Path>) -> Result<(Case, f64, Vec<String>), Failure> {
    let file = match path {
        None => problem::generic().map_err(|error| Failure::Computation(error.to_string()))?,
        Some(path) => {
            let mut text = String::new();
            let limit = euler_poincare::system::file::MAX_BYTES as u64 + 1;
            let read = File::open(path).and_then(|file| file.take(limit).read_to_string(&mut text));
            read.map_err(|error| Failure::file(path, error))?;
            SystemFile::parse(&text).map_err(|refused| Failure::file(path, refused))?
        }
    };
    let step = file.case.step.eval::<f64>().unwrap_or(0.125);
    let (steps, last) = file.plan::<f64>().unwrap_or((8, None));
    let horizon = steps as f64 * step + last.unwrap_or(0.0);
    let longest = MOST_STEPS * step;
    if horizon.abs() > longest.abs() {
        let note = format!("The horizon of the system, {horizon}, was cut to {MOST_STEPS} of its steps, {longest}.");
        return Ok((file.case, longest, vec![note]));
    }
    Ok((file.case, horizon, Vec::new()))
}

/// The verdict on the order that the digits given have; where only the exact order of these digits shows, an explanation.
fn judge(
    case: &Case,
    digits: Digits,
    horizon: f64,
    analysis: &Analysis,
    system: Option<&Path>,
) -> Result<Judged, Failure> {
    let given = &analysis.findings().variational;
    let judged = Judged::of(case, digits, horizon, given.order as u32, given.broken.is_none());
    let mut judged = judged.map_err(|error| match system {
        Some(path) => Failure::file(path, error),
        None => Failure::Computation(error.to_string()),
    })?;
    let exact = &analysis.exactly.variational;
    let shows = |findings: &Findings, order: usize| matches!(findings.compare(order as u32), Comparison::As { .. });
    let (over, down) = (&judged.trial.horizon, &judged.trial.descent);
    let less = !matches!(down.compare(exact.order as u32), Comparison::Below { .. });
    if exact.order < given.order && !judged.verdict.holds() && shows(over, given.order) && less {
        // Both orders, each where theory has it.
        judged.verdict = Verdict::Holds { defect: 0.0, bound: TOLERANCE };
        judged.explanation = Some(format!(
            "The order to the digits given shows over the horizon; with steps that shrink, the exact order of these digits, {exact}."
        ));
    } else if exact.order < given.order
        && !judged.verdict.holds()
        && (shows(over, exact.order) || shows(down, exact.order))
    {
        judged.explanation = Some(format!(
            "What is measured is {exact}, the exact order of the digits given: in {} digits their rounding shows. Type the \
             entries exactly, such as \"1/2 - sqrt(15)/10\", or with more digits, or use fewer digits of arithmetic.",
            digits.number()
        ));
    }
    if judged.verdict.is_broken() && too_small_to_show(analysis, &judged) {
        judged.verdict = Verdict::inconclusive("the conditions that fail are off by less than these digits can show");
        judged.explanation = Some("The measured order is that of the conditions that hold in these digits.".into());
    }
    Ok(judged)
}

/// Whether more than the order shows because the conditions that fail are off by very little: at the finest step that carries
/// a slope, their part of the error, defect × h^{p+1}, is below the error itself.
fn too_small_to_show(analysis: &Analysis, judged: &Judged) -> bool {
    let orders = analysis.findings();
    let order = orders.variational.order as u32;
    let Some(failing) = &orders.failing_variational else { return false };
    let defect = failing.conditions.iter().map(|condition| condition.defect.abs()).fold(0.0, f64::max);
    let descent = &judged.trial.descent;
    let finest = descent.rows().iter().rev().filter(|row| !descent.is_noise(row)).find_map(|row| {
        let error = row.readings.as_ref().ok()?.iter().take(1).map(|reading| reading.error).next()?;
        Some((row.h.abs(), error))
    });
    let above = matches!(judged.trial.compare(order), Comparison::Above { .. });
    above && finest.is_some_and(|(h, error)| defect * h.powi(order as i32 + 1) < error)
}
