//! Figures 5.1 to 5.5 of Martín de Diego and Sato Martín de Almagro 2019.

use super::plot::{Axes, Curve, Figure, Legend, Marker, Panel, Style};
use euler_poincare::algebra::Covector;
use euler_poincare::experiments::evolution::evolve;
use euler_poincare::experiments::reference::{casimir, energy};
use euler_poincare::experiments::{Errors, ExperimentError, Integrator, Method, Problem};
use euler_poincare::tableau::families::Family;

const IIIA2: Integrator = Integrator::Variational(Method::new(Family::LobattoIIIA, 2));
const IIIB2: Integrator = Integrator::Variational(Method::new(Family::LobattoIIIB, 2));
const IIIA3: Integrator = Integrator::Variational(Method::new(Family::LobattoIIIA, 3));
const IIIB3: Integrator = Integrator::Variational(Method::new(Family::LobattoIIIB, 3));
const GAUSS1: Integrator = Integrator::Variational(Method::new(Family::Gauss, 1));
const GAUSS2: Integrator = Integrator::Variational(Method::new(Family::Gauss, 2));
const GAUSS3: Integrator = Integrator::Variational(Method::new(Family::Gauss, 3));
/// The relative tolerance that general-purpose solvers start with.
const ADAPTIVE: Integrator = Integrator::DormandPrince { tolerance: 1e-3 };

/// Steps in [0, 1] of the references, with h = 0.01.
const FINE: usize = 100;

/// The five figures with their file names, from the errors on both problems.
pub fn all(found: &[Errors]) -> Result<Vec<(&'static str, Figure)>, ExperimentError> {
    Ok(vec![
        ("figure-5.1.svg", casimir_llg()?),
        ("figure-5.2.svg", errors_llg(found)),
        ("figure-5.3.svg", energy_relaxed()?),
        ("figure-5.4.svg", casimir_relaxed()?),
        ("figure-5.5.svg", errors_relaxed(found)),
    ])
}

fn figure(title: &str, panels: Vec<Panel>) -> Figure {
    Figure { title: title.into(), legend: Legend::Shared, panels, note: String::new() }
}

/// One look for each integrator, in every figure.
fn style(integrator: Integrator) -> Style {
    let looks = [
        (ADAPTIVE, "Dormand–Prince 5(4)", 0, false, Marker::None),
        (Integrator::RungeKutta4, "RK4", 1, false, Marker::Cross),
        (IIIA2, "Lobatto IIIA-2", 2, false, Marker::Circle),
        (IIIB2, "Lobatto IIIB-2", 5, true, Marker::Circle),
        (IIIA3, "Lobatto IIIA-3", 3, false, Marker::Triangle),
        (IIIB3, "Lobatto IIIB-3", 6, true, Marker::Triangle),
        (GAUSS1, "Gauss-1", 4, false, Marker::Circle),
        (GAUSS2, "Gauss-2", 2, true, Marker::Triangle),
        (GAUSS3, "Gauss-3", 3, true, Marker::Cross),
    ];
    let (_, name, colour, dashed, marker) =
        looks.into_iter().find(|(i, ..)| *i == integrator).unwrap_or((integrator, "other", 7, false, Marker::None));
    Style::new(name, colour).dashed(dashed).marked(marker)
}

/// How a quantity of a problem changes, in steps of one size.
struct Drift<'a> {
    problem: Problem,
    steps: usize,
    /// The names of the change and of its size.
    names: [&'static str; 2],
    quantity: &'a dyn Fn(&Covector<f64, 3>) -> Result<f64, ExperimentError>,
    /// What it is compared with, on the grid of step 0.01, if not with its initial value.
    reference: Option<&'a [f64]>,
}

impl Drift<'_> {
    fn curve(&self, integrator: Integrator, absolute: bool) -> Result<Curve, ExperimentError> {
        // The adaptive integrator takes its own steps: its curve is sampled more finely.
        let steps = if integrator == ADAPTIVE { self.steps.max(FINE) } else { self.steps };
        let samples = evolve(self.problem, integrator, steps)?;
        let values = samples.iter().map(|(_, m)| (self.quantity)(m)).collect::<Result<Vec<_>, _>>()?;
        let against = |k: usize| self.reference.map_or(values[0], |r| r[k * (FINE / steps)]);
        let sign = |d: f64| if absolute { d.abs() } else { d };
        let points = samples.iter().enumerate().map(|(k, (t, _))| (*t, sign(values[k] - against(k)))).collect();
        Ok(Curve { style: style(integrator), points })
    }

    /// Absolute values on a logarithmic axis, or signed ones on a linear axis.
    fn panel(&self, integrators: &[Integrator], title: &str, absolute: bool) -> Result<Panel, ExperimentError> {
        let curves = integrators.iter().map(|&integrator| self.curve(integrator, absolute));
        let axes = if absolute { Axes::LogY } else { Axes::Linear };
        Ok(Panel::new(title, ("time t", self.names[usize::from(absolute)]), axes, curves.collect::<Result<_, _>>()?))
    }

    /// All of a battery, and some of order 4 with signs.
    fn figure(&self, title: &str, all: &[Integrator], some: &[Integrator]) -> Result<Figure, ExperimentError> {
        let panels = vec![self.panel(all, "all integrators", true)?, self.panel(some, "order 4, signed", false)?];
        Ok(figure(title, panels))
    }
}

fn casimir_llg() -> Result<Figure, ExperimentError> {
    let battery = [ADAPTIVE, Integrator::RungeKutta4, IIIA2, IIIB2, IIIA3, IIIB3, GAUSS1, GAUSS2];
    let names = ["C(t) − C(0)", "|C(t) − C(0)|"];
    let drift = Drift { problem: Problem::Llg, steps: FINE, names, quantity: &|m| Ok(casimir(m)), reference: None };
    let pair = [Integrator::RungeKutta4, IIIA3, IIIB3];
    drift.figure("LLG: drift of the Casimir C = |M|², h = 0.01", &battery, &pair)
}

/// The integrators of the relaxed body.
const RELAXED: [Integrator; 5] = [ADAPTIVE, Integrator::RungeKutta4, GAUSS1, GAUSS2, GAUSS3];

fn energy_relaxed() -> Result<Figure, ExperimentError> {
    let system = Problem::Relaxed.model::<f64>().system;
    let (problem, names) = (Problem::Relaxed, ["E(t) − E(0)", "|E(t) − E(0)|"]);
    let drift = Drift { problem, steps: 10, names, quantity: &|m| Ok(energy(&system, m)?), reference: None };
    drift.figure("Relaxed rigid body: drift of the energy E, h = 0.1", &RELAXED, &[Integrator::RungeKutta4, GAUSS2])
}

fn casimir_relaxed() -> Result<Figure, ExperimentError> {
    let fine = evolve(Problem::Relaxed, GAUSS3, FINE)?;
    let fine: Vec<f64> = fine.iter().map(|(_, m)| casimir(m)).collect();
    let (problem, names) = (Problem::Relaxed, ["C(t) − C̄(t)", "|C(t) − C̄(t)|"]);
    let drift = Drift { problem, steps: 10, names, quantity: &|m| Ok(casimir(m)), reference: Some(&fine) };
    let title = "Relaxed rigid body: C = |M|² against C̄ of Gauss-3 with h = 0.01; h = 0.1";
    drift.figure(title, &RELAXED, &[Integrator::RungeKutta4, GAUSS2])
}

/// Errors against h of some methods: a colour for each magnitude, dashed for the second method.
fn errors(found: &[Errors], problem: Problem, methods: &[(Method, &str)], order: i32, title: &str) -> Panel {
    let mut curves = Vec::new();
    for (k, (method, name)) in methods.iter().enumerate() {
        let chosen = |e: &&Errors| (e.problem, e.method, e.scalar) == (problem, *method, "dd");
        let Some(Errors { findings, .. }) = found.iter().find(chosen) else { continue };
        let looks = [(2, Marker::Circle), (1, Marker::Triangle), (3, Marker::Cross)];
        for (quantity, (colour, marker)) in looks.into_iter().enumerate() {
            let style = Style::new(format!("{}{name}", findings.quantities()[quantity]), colour);
            let points = findings.levels(quantity).iter().map(|level| (level.h, level.error)).collect();
            curves.push(Curve { style: style.dashed(k > 0).marked(marker), points });
        }
    }
    // A line of the method's order through a point below the finest errors.
    let finest =
        curves.iter().filter_map(|c| c.points.last()).fold((1.0, f64::INFINITY), |(_, y), p| (p.0, p.1.min(y)));
    if finest.1.is_finite() && finest.1 > 0.0 {
        let line = |h: f64| (h, finest.1 / 4.0 * (h / finest.0).powi(order));
        let style = Style::new("slope of the order", 7).dashed(true);
        curves.push(Curve { style, points: vec![line(0.25), line(finest.0)] });
    }
    Panel::new(title, ("step size h", "error at T = 1"), Axes::LogLog, curves)
}

fn errors_llg(found: &[Errors]) -> Figure {
    let pair = |s| [(Method::new(Family::LobattoIIIA, s), ", IIIA"), (Method::new(Family::LobattoIIIB, s), ", IIIB")];
    figure(
        "LLG: errors of the Lobatto methods (32 digits)",
        vec![
            errors(found, Problem::Llg, &pair(2), 2, "2 stages, order 2"),
            errors(found, Problem::Llg, &pair(3), 4, "3 stages, order 4"),
        ],
    )
}

fn errors_relaxed(found: &[Errors]) -> Figure {
    let panel =
        |s: usize, title| errors(found, Problem::Relaxed, &[(Method::new(Family::Gauss, s), "")], 2 * s as i32, title);
    figure(
        "Relaxed rigid body: errors of the Gauss methods (32 digits)",
        vec![panel(1, "1 stage, order 2"), panel(2, "2 stages, order 4"), panel(3, "3 stages, order 6")],
    )
}
