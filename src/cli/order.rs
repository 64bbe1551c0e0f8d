//! `order`: the orders of a tableau, declared, computed and measured, side by side.
//!
//! The declared order is the claim: the order of the variational integrator with this tableau. The command is about this scheme, so
//! one meaning serves `--declared` and `order` in a file, and a Runge–Kutta order that the scheme does not reach is refuted, with
//! both numbers. The names of tableaux claim nothing: the claim is then the computed order, and the measurement confirms it.

mod figure;
mod text;

use super::tableau::Named;
use super::{Failure, Format, output, print, verdict_code};
use clap::builder::PossibleValuesParser;
use euler_poincare::file::{self, Output};
use euler_poincare::harness::Verdict;
use euler_poincare::harness::convergence::Estimate;
use euler_poincare::laws::trial::{Digits, Judged, Trial};
use euler_poincare::study::{Comparison, problem};
use euler_poincare::system::file::MAX_BYTES;
use euler_poincare::system::{Case, Reading, SystemFile};
use euler_poincare::tableau::analysis::Findings;
use euler_poincare::tableau::order::MAX_VARIATIONAL;
use euler_poincare::tableau::{Analysis, Description, analyse};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXPLANATION: &str = "\
The orders:
  declared     what is claimed: the order of the variational integrator with
               this tableau, by --declared or by `order` in the file. Names
               declare nothing
  classical    the order as a Runge-Kutta method, from the coefficients
  variational  the order of the variational integrator, from the coefficients.
               It uses a and its conjugate together, so this order can be
               lower than the classical one
  measured     the slope of the errors in momentum and attitude, over a horizon
               and with steps that shrink to round-off

The verdict and the exit code:
  0  confirmed     the variational order is the declared one, if one is
                   declared, and the errors show it
  1  refuted       the variational order is not the declared one, or the errors
                   show another order than the coefficients
  3  inconclusive  neither, with the reason
  2                bad usage, or a bad file

Tableau files (TOML or JSON) have a = [[...], ...] and b = [...] and, if wanted,
c, order and name. Entries are numbers or texts such as \"1/2 - sqrt(3)/6\".

Decimals with three or more places, such as 0.1667, count as rounded, unless
they are dyadic (0.125). They stand for an interval of half a unit of the last
place, and with 16 or 17 digits of four units of an f64. The orders are those
of the tableau of the highest order within these intervals, and that tableau is
measured; the orders of exactly the digits typed are shown beside them. Digits
that are meant exactly are written as a fraction: \"1667/10000\".";

/// Options of `order`.
#[derive(clap::Args)]
#[command(after_help = EXPLANATION)]
pub struct Arguments {
    /// A name (euler, rk4, kutta38, heun2, ralston3, sdirk2, gauss-S, lobatto-iiia-S, ..., radau-iia-S) or a tableau file
    #[arg(long, value_name = "NAME|FILE")]
    tableau: String,
    /// The system that is integrated [default: a rigid body without symmetry, with drag and a torque that varies in time]
    #[arg(long, value_name = "SYSTEM.toml")]
    system: Option<PathBuf>,
    /// The digits of the arithmetic [default: 32]
    #[arg(long, value_parser = PossibleValuesParser::new(["16", "32"]))]
    digits: Option<String>,
    /// The order that is claimed for the variational integrator with this tableau, in place of that of the file
    #[arg(long, value_name = "P", value_parser = clap::value_parser!(u32).range(1..=200))]
    declared: Option<u32>,
    /// A work plot: errors against the step, with the fitted line and its window
    #[arg(long, value_name = "FILE.svg", value_parser = output::svg)]
    plot: Option<PathBuf>,
    /// How the result is printed
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
    /// Also the conditions that fail, and tables of the errors
    #[arg(short, long)]
    verbose: bool,
}

/// Who declares an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// `--declared`.
    Option,
    /// The tableau file.
    File,
}

/// What is known of the tableau on the system.
pub struct Outcome {
    /// The name, or the file's path.
    pub tableau: String,
    /// Who declares the order of the analysis, if one is declared.
    pub declared_by: Option<Source>,
    pub analysis: Analysis,
    /// The file of the system, if not the standard one.
    pub system: Option<PathBuf>,
    pub digits: Digits,
    pub horizon: f64,
    /// What was measured, and the verdict on the claim.
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
    /// The order that the measurement is compared with.
    pub fn predicted(&self) -> u32 {
        predicted(&self.analysis)
    }

    /// What the measurement shows: study, part of the state, estimate.
    pub fn measured(&self) -> Option<(&'static str, usize, Estimate)> {
        let order = self.predicted();
        if self.judged.verdict.holds() && matches!(self.judged.trial.compare(order), Comparison::Below { .. }) {
            return self.judged.trial.horizon.deciding(order).map(|(quantity, found)| ("horizon", quantity, found));
        }
        self.judged.trial.slope(order)
    }

    /// Whether the variational order is the declared one, from the coefficients; `None` without a declared order, and where the
    /// coefficients leave it open.
    pub fn declared_holds(&self) -> Option<bool> {
        self.analysis.has_order(self.analysis.declared?)
    }
}

fn predicted(analysis: &Analysis) -> u32 {
    analysis.findings().variational.order as u32
}

pub fn run(arguments: Arguments) -> Result<ExitCode, Failure> {
    let (description, mut analysis) = tableau(&arguments.tableau)?;
    let digits = match arguments.digits.as_deref() {
        Some("16") => Digits::Sixteen,
        _ => Digits::ThirtyTwo,
    };
    let mut declared_by = analysis.declared.map(|_| Source::File);
    if let Some(declared) = arguments.declared {
        (analysis.declared, declared_by) = (Some(declared as usize), Some(Source::Option));
    }
    let (mut case, horizon, notes) = system(arguments.system.as_deref())?;
    case.method.tableau = match &analysis.completion {
        Some(completion) => Description::Entries(completion.entries.clone()),
        None => description,
    };
    let read = [Path::new(&arguments.tableau)].into_iter().chain(arguments.system.as_deref());
    let plot = arguments.plot.as_deref().map(|path| taken(path, read)).transpose()?;
    let judged = judge(&case, digits, horizon, &analysis, arguments.system.as_deref())?;
    let outcome = Outcome {
        tableau: arguments.tableau,
        declared_by,
        analysis,
        system: arguments.system,
        digits,
        horizon,
        judged,
        notes,
    };
    if let (Some(path), Some(plot)) = (&arguments.plot, plot) {
        output::draw(plot, path, &figure::figure(&outcome))?;
    }
    match arguments.format {
        Format::Text => print(&text::text(&outcome, arguments.verbose))?,
        Format::Json => print(&format!("{}\n", text::json(&outcome)))?,
    }
    Ok(verdict_code(&outcome.judged.verdict))
}

/// The file of the figure: whether it can be written is known before the run, not after it.
fn taken<'a>(path: &Path, read: impl IntoIterator<Item = &'a Path>) -> Result<Output, Failure> {
    let place = |path: &Path| path.canonicalize().ok();
    if read.into_iter().any(|other| place(other).is_some() && place(other) == place(path)) {
        return Err(Failure::Usage(format!("{} is read: the plot needs another file", path.display())));
    }
    output::create(path)
}

/// The tableau of a name or a file, analysed.
fn tableau(argument: &str) -> Result<(Description, Analysis), Failure> {
    // One order more than is checked for the pair: where the classical order ends there, that of the pair does.
    const REACH: usize = MAX_VARIATIONAL + 1;
    let Named { description, file } = Named::read(argument)?;
    let analysis = match file {
        None => analyse(&description, REACH).map_err(|error| Failure::Usage(error.to_string())),
        Some(file) => file.analyse(REACH).map_err(|error| Failure::file(Path::new(argument), error)),
    };
    Ok((description, analysis?))
}

/// The most steps of a system's file that the horizon of a study covers.
const MOST_STEPS: f64 = 128.0;

/// The case of a file, or the standard one; the horizon; what was changed.
fn system(path: Option<&Path>) -> Result<(Case, f64, Vec<String>), Failure> {
    let file = match path {
        None => problem::generic().map_err(|error| Failure::Computation(error.to_string()))?,
        Some(path) => {
            let text = file::read(path, MAX_BYTES).map_err(|error| Failure::file(path, error))?;
            let file = SystemFile::parse_with(&text, &Reading::beside(path))
                .map_err(|refused| Failure::file(path, refused))?;
            if file.adaptive.is_some() {
                let reason = "the order is measured with fixed steps: give `step` instead of `tolerance`";
                return Err(Failure::file(path, reason));
            }
            file
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

/// The verdict on the declared order, or on the computed one if none is declared.
fn judge(
    case: &Case,
    digits: Digits,
    horizon: f64,
    analysis: &Analysis,
    system: Option<&Path>,
) -> Result<Judged, Failure> {
    let (order, computed) = (predicted(analysis), &analysis.findings().variational);
    let at_least = !computed.is_exact() && analysis.declared != Some(computed.order);
    let judged = Judged::of(case, digits, horizon, order, at_least);
    let mut judged = judged.map_err(|error| match system {
        Some(path) => Failure::file(path, error),
        None => Failure::Computation(error.to_string()),
    })?;
    if judged.verdict.is_broken() && too_small_to_show(analysis, &judged) {
        judged.verdict = Verdict::inconclusive("the conditions that fail are off by less than these digits can show");
        judged.explanation = Some("The measured order is that of the conditions that hold in these digits.".into());
    }
    let unknown_digits = analysis.to_digits.is_some() && analysis.completion.is_none();
    match analysis.declared {
        Some(declared) => {
            if let Some(verdict) = of_claim(declared, analysis, &judged.trial) {
                judged.verdict = verdict;
            }
        }
        None if unknown_digits => {
            judged.verdict = Verdict::inconclusive("the digits given do not decide the order");
        }
        None => {}
    }
    Ok(judged)
}

/// The verdict on a declared order where the measurement of the computed one is not what decides.
fn of_claim(declared: usize, analysis: &Analysis, trial: &Trial) -> Option<Verdict> {
    let Findings { classical, variational, .. } = analysis.findings();
    match analysis.has_order(declared) {
        Some(true) => return None,
        Some(false) => {
            let mut witness = format!("the declared order is {declared}, but the order is {variational}");
            if declared == classical.order {
                witness += &format!(" in this scheme; {declared} is the order as a Runge-Kutta method");
            }
            let defect = declared.abs_diff(variational.order) as f64;
            return Some(Verdict::Broken { defect, bound: 0.0, witness });
        }
        None => {}
    }
    // Left open by the coefficients: a lower order that shows refutes, and nothing that shows confirms more than was checked.
    match trial.compare(declared as u32) {
        below @ Comparison::Below { .. } if analysis.to_digits.is_none() => Some(below.verdict()),
        _ if declared == variational.order && analysis.to_digits.is_none() => None,
        _ => Some(Verdict::inconclusive(match analysis.to_digits {
            Some(_) => "the declared order is neither found within the digits given nor excluded by them",
            None => "the declared order is higher than the order up to which the coefficients are checked",
        })),
    }
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
