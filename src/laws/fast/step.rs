//! One fast step, or a few: against the general engine, and in another frame.

use super::condition::{Condition, Judged, conditions, exact, trajectory};
use super::engine::{
    Form, Group, OTHER_RETRACTION, STOPPED, Step, TERM_MISSING, Taken, engine, group, start, unsupported,
};
use super::tableaux;
use crate::algebra::catalogue::Entry;
use crate::harness::{About, Cost, Fault, Verdict, evidence};
use crate::integrators::StepError;
use crate::integrators::lanes::Registers;
use crate::laws::CaseLaw;
use crate::laws::integrators::SCHEME;
use crate::laws::method::Point;
use crate::laws::method::library::{FAVOURED, SEES_ATTITUDE, SEES_TIME};
use crate::laws::planted::step::{EQUATIONS, OF_START, joined};
use crate::laws::planted::tableau::COEFFICIENT;
use crate::laws::precision::of_relative;
use crate::laws::probe::{Probe, stream};
use crate::laws::step::show_list;
use crate::scalar::{Number, Scalar};
use crate::system::case::{Drag, Inertia, Potential};
use crate::system::force::Value;
use crate::system::{Case, Cases};

/// Steps of a trajectory: the first starts from nothing, the others from the one before.
const STEPS: usize = 3;

pub(super) const BOUND: &str = "n (64 + 5 r/u)(1 + κ) u after n steps that leave a residual r: 64 roundings in a stage equation, \
     r/(1 − 0.8) to the root; κ: how much the general engine amplifies small torques, measured";

/// What most of the headers have in common.
pub(super) const ABOUT: About = About {
    name: "",
    statement: "",
    source: SCHEME,
    oracle: "",
    bound: BOUND,
    needs: "a matrix group with the Cayley map, on so(3) in its standard basis also exp; a quadratic Lagrangian; a force with a form in lanes",
    cost: Cost::Cheap,
    faults: &[],
};

/// What is needed where there are axes of a body.
const BODIES: &str = "so(3) or se(3) in its standard basis; a quadratic Lagrangian; a force with a form in lanes";

/// What is needed where there are bodies that rotate only.
pub(super) const ROTATIONS: &str = "so(3) in its standard basis; a quadratic Lagrangian; a force with a form in lanes";

/// What both forms are shown.
const FAULTS: [Fault; 21] = joined(
    [TERM_MISSING, OTHER_RETRACTION, STOPPED, COEFFICIENT],
    joined::<15, 2, 17>(EQUATIONS, [SEES_TIME, SEES_ATTITUDE]),
);

pub(super) static LAWS: &[CaseLaw] = &[
    CaseLaw {
        about: About {
            name: "fast-step",
            statement: "in every kind of registers the fast step is the step: (g, μ) after n steps agree with the general engine, or both refuse",
            oracle: "the general engine in 32 digits, from the same 16 digits",
            faults: &FAULTS,
            ..ABOUT
        },
        cases: drawn,
        check: |case, fault| settled(agreement(&[Form::Matrix], case, fault)),
    },
    CaseLaw {
        about: About {
            name: "fast-quaternion",
            statement: "the quaternion form of the fast step is the step: the rotations of q and the momenta agree with the general engine, or both refuse",
            source: "Martín de Diego and Sato Martín de Almagro 2019, §5.2; Shuster 1993",
            oracle: "the general engine in 32 digits, on matrices, from the same 16 digits",
            needs: ROTATIONS,
            faults: &FAULTS,
            ..ABOUT
        },
        cases: |cases| on_bodies(cases).algebras(&[Entry::So3]),
        check: |case, fault| settled(agreement(&[Form::Quaternion], case, fault)),
    },
    CaseLaw {
        about: About {
            name: "fast-weight",
            statement: "with a weight or a field, whose torques F_i depend on g_i = g τ(Ξ_i), the fast step in both forms is the step: (g, μ) after n \
                        steps agree with the general engine, or both refuse",
            source: "Marsden and West 2001, §3.2; Martín de Diego and Sato Martín de Almagro 2019, §5.2, with ∂_gL + f instead of f",
            oracle: "the general engine in 32 digits, where the potential is a formula and its torque comes from dual numbers",
            faults: &[OF_START, TERM_MISSING, OTHER_RETRACTION, STOPPED, COEFFICIENT],
            needs: BODIES,
            ..ABOUT
        },
        cases: on_bodies,
        check: |case, fault| settled(agreement(forms(case), &weighted(case), fault)),
    },
    CaseLaw {
        about: About {
            name: "fast-presentation",
            statement: "with the axes of the body renamed, 1 → 2 → 3 → 1, the same step: μ'_a = μ_{p(a)}, g'_ab = g_{p(a)p(b)}",
            source: "the equations have no preferred basis: Marsden and Ratiu 1999, §13.1 and §13.5",
            oracle: "the fast step's own answer on the renamed description",
            faults: &[FAVOURED, SEES_ATTITUDE],
            needs: BODIES,
            ..ABOUT
        },
        cases: on_bodies,
        check: |case, fault| settled(presentation(case, fault)),
    },
];

/// Cases of the fast steps, with any tableau that fits into the lanes.
pub(super) fn drawn(cases: Cases) -> Cases {
    cases.fast().with_tableaux(tableaux())
}

/// Those on SO(3) and SE(3), whose axes are those of a body.
pub(super) fn on_bodies(cases: Cases) -> Cases {
    drawn(cases).algebras(&[Entry::So3, Entry::Se3, Entry::Se3]).changed_basis(false)
}

/// The forms of the attitude that a fast step of a case has.
pub(super) fn forms(case: &Case) -> &'static [Form] {
    if group(case) == Ok(Group::So3) { &[Form::Matrix, Form::Quaternion] } else { &[Form::Matrix] }
}

/// The fast step of a case in every kind of registers and in these forms.
///
/// # Errors
/// As [`engine`].
pub(super) fn engines(
    forms: &[Form],
    case: &Case,
    fault: Option<&Fault>,
) -> Result<Vec<(Registers, Form, Step)>, StepError> {
    let kinds = Registers::all().into_iter().flat_map(|registers| forms.iter().map(move |form| (registers, *form)));
    kinds.map(|(registers, form)| Ok((registers, form, engine(form, case, registers, fault)?))).collect()
}

/// The verdict, where a step of the oracle was refused that of its error.
pub(super) fn settled(outcome: Result<Verdict, StepError>) -> Verdict {
    outcome.unwrap_or_else(crate::laws::method::without)
}

/// The verdicts on steps in all kinds of registers.
pub(super) fn together(verdicts: Vec<Verdict>) -> Verdict {
    verdicts.into_iter().reduce(Verdict::and).unwrap_or_else(|| Verdict::inconclusive("no registers"))
}

/// Whether some step is too ill-conditioned.
pub(super) fn hopeless(conditions: &[Condition]) -> Option<Verdict> {
    let why = "the stage equations are nearly singular";
    conditions.iter().any(Condition::hopeless).then(|| Verdict::inconclusive(why))
}

/// The verdict on a defect.
pub(super) fn verdict((defect, bound, part): Judged, witness: impl Fn() -> String) -> Verdict {
    let witness = || format!("{part}: {defect:.3e} units of round-off, of {bound:.3e}; {}", witness());
    let u = f64::unit_roundoff();
    evidence::note(|| of_relative::<f64>(16, defect * u, bound * u, witness()));
    Verdict::judge(defect, bound, witness)
}

/// h.
pub(super) fn step_of(case: &Case) -> Result<f64, StepError> {
    case.step.eval().map_err(unsupported)
}

/// By what the step of the case is multiplied: generated cases are calm, and a fast step must know when it is too large.
const STRETCHES: [f64; 4] = [1.0, 1.0, 2.0, 4.0];

fn agreement(forms: &[Form], case: &Case, fault: Option<&Fault>) -> Result<Verdict, StepError> {
    let stretch = STRETCHES[Probe::new(case, stream::FAST).integer(0, 3) as usize];
    let (start, h) = (start(case)?, step_of(case)? * stretch);
    let found = conditions(case, &start, h, STEPS).and_then(|found| Ok((found, exact(case, &start, h, STEPS)?)));
    let (conditions, exact) = match found {
        Ok(found) => found,
        Err(error) => return refusal(engines(forms, case, fault)?, &start, h, &error),
    };
    if let Some(verdict) = hopeless(&conditions) {
        return Ok(verdict);
    }
    let mut verdicts = Vec::new();
    for (registers, _, mut method) in engines(forms, case, fault)? {
        let (mut point, mut residual) = (start.clone(), 0.0);
        for (n, (condition, expected)) in conditions.iter().zip(&exact).enumerate() {
            // The general engine takes it: so must the fast one.
            let Taken { end: next, report, .. } = match method(&point, h) {
                Ok(taken) => taken,
                Err(error) => return Ok(Verdict::broken(format!("{registers:?}, step {}: {error}", n + 1))),
            };
            residual = f64::max(residual, report.residual);
            if report.residual.is_nan() || report.residual > (1 << 14) as f64 * f64::unit_roundoff() {
                return Ok(Verdict::broken(format!("{registers:?}, step {}: {report:?}", n + 1)));
            }
            let found = verdict(condition.judge(n + 1, residual, &next, expected), || {
                let momenta = (show_list(&next.momentum), show_list(&expected.momentum));
                format!("{registers:?}, step {} of {h}: μ' = {}, expected {}", n + 1, momenta.0, momenta.1)
            });
            verdicts.push(found);
            point = next;
        }
    }
    Ok(together(verdicts))
}

/// The case with a weight, a lift or a moment in a field, in numbers that it determines: torques up to that of a motion of |μ| = 1/2 about
/// an axis, or so.
pub(super) fn weighted(case: &Case) -> Case {
    let mut probe = Probe::new(case, stream::FAST_WEIGHT);
    let mut three = || (0..3).map(|_| Number::from(probe.unit::<f64>())).collect::<Vec<_>>();
    let (center, field) = (three(), three());
    let weight = Number::ratio(i64::from(probe.integer(1, 8)), 8);
    let mut weighted = case.clone();
    weighted.potentials.push(match probe.integer(0, 2) {
        0 => Potential::Buoyancy { lift: weight, center },
        1 => Potential::UniformField { moment: center, field },
        _ => Potential::Gravity { weight, center },
    });
    weighted
}

/// Where the general engine refuses a step, the fast one refuses it for the same kind of reason.
fn refusal(
    engines: Vec<(Registers, Form, Step)>,
    start: &Point<f64>,
    h: f64,
    expected: &StepError,
) -> Result<Verdict, StepError> {
    for (_, _, mut method) in engines {
        match trajectory(&mut method, start, h, STEPS) {
            Err(error) if std::mem::discriminant(&error) == std::mem::discriminant(expected) => {}
            _ => return Ok(Verdict::inconclusive("near a fold one solver stops short of the other")),
        }
    }
    evidence::note(|| of_relative::<f64>(16, 0.0, 0.0, "refused by both".into()));
    Ok(Verdict::Holds { defect: 0.0, bound: 0.0 })
}

/// p: the axis that is called a afterwards, of ω and of v.
fn renamed(a: usize) -> usize {
    a / 3 * 3 + (a + 1) % 3
}

/// The case with its axes renamed.
fn rename(case: &Case) -> Case {
    let n = case.dimension();
    let list = |list: &[Number]| (0..n).map(|a| list[renamed(a)].clone()).collect::<Vec<_>>();
    let matrix = |rows: &[Vec<Number>]| (0..n).map(|a| list(&rows[renamed(a)])).collect::<Vec<_>>();
    let mut other = case.clone();
    for (_, part) in other.parts_mut() {
        match part {
            Value::List(x) | Value::Form(Inertia::Diagonal(x)) => *x = list(x),
            Value::Form(Inertia::Full(rows)) | Value::Drag(Drag::Matrix(rows)) => *rows = matrix(rows),
            // No polynomial has a form in lanes.
            _ => {}
        }
    }
    other
}

/// A state with its axes renamed.
fn rename_point(point: &Point<f64>) -> Point<f64> {
    let size = point.attitude.len().isqrt();
    // The last row and the last column of a pose are no axes.
    let of = |a: usize| if a < 3 { renamed(a) } else { a };
    let attitude = (0..size * size).map(|k| point.attitude[of(k / size) * size + of(k % size)]).collect();
    let momentum = (0..point.momentum.len()).map(|a| point.momentum[renamed(a)]).collect();
    Point { time: point.time, momentum, attitude }
}

fn presentation(case: &Case, fault: Option<&Fault>) -> Result<Verdict, StepError> {
    let (start, h) = (start(case)?, step_of(case)?);
    let conditions = conditions(case, &start, h, 1)?;
    if let Some(verdict) = hopeless(&conditions) {
        return Ok(verdict);
    }
    let step = |case: &Case, start: &Point<f64>| engine(Form::Matrix, case, Registers::detect(), fault)?(start, h);
    let (plain, other) = (step(case, &start)?, step(&rename(case), &rename_point(&start))?);
    let expected = rename_point(&plain.end);
    // Both round: twice what one may.
    let residual = plain.report.residual.max(other.report.residual);
    Ok(verdict(conditions[0].judge(2, residual, &other.end, &expected), || {
        format!("μ' = {}, expected {}", show_list(&other.end.momentum), show_list(&expected.momentum))
    }))
}
