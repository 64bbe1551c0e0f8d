//! The fast step of a case, without its types, with a fault planted in it or without.

use crate::harness::Fault;
use crate::integrators::lanes::Registers;
use crate::integrators::lanes::{FastRetraction, Terms, VariationalInLanes};
use crate::integrators::se3::CayleySe3;
use crate::integrators::so3::{HalfAngle, QuaternionSo3, QuaternionState};
use crate::integrators::variational::Settings;
use crate::integrators::{OneStep as _, Report, State, StepError};
use crate::laws::method::library::{FAVOURED, Library, SEES_ATTITUDE, SEES_TIME};
use crate::laws::method::{MethodSource, Point, Stage, StateForm, Stepper, theory_of};
use crate::laws::planted::{blend_scalar, step, tableau};
use crate::mechanics::lagrangian::{AnyLagrangian, Quadratic};
use crate::retraction::beside::{Core, Typed};
use crate::retraction::{AnyRetraction, Cayley};
use crate::scalar::Number;
use crate::system::Case;
use crate::system::case::{Force, MAIN_DIMENSIONS, Structure, Tau};
use crate::system::dispatch::MAIN;
use crate::tableau::Tableau;

pub const TERM_MISSING: Fault =
    Fault::new("term-missing", "the last term of the force left out of the lanes", "forced systems");
pub const OTHER_RETRACTION: Fault =
    Fault::new("other-retraction", "exp instead of the Cayley map, the Cayley map instead of exp", "all");

/// The fixed-point iterations end too early. Of an ensemble, whose residual is a change times the contraction of the
/// fixed-point iterations, it is the same as a contraction that is taken to be 2³⁰ times as strong as it is.
pub const STOPPED: Fault = Fault::new(
    "stopped-early",
    "the fixed-point iteration ends where the residual is 2³⁰ times as large as it may be",
    "methods that are not explicit",
);

/// The settings with [`STOPPED`] or without.
pub(super) fn settings(fault: Option<&Fault>) -> Settings<f64> {
    let mut settings = Settings::default();
    settings.tolerance *= 1.0 + 2f64.powi(30) * STOPPED.size_in(fault);
    settings
}

/// How a fast step holds an attitude.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Form {
    /// As the matrix g.
    Matrix,
    /// As a unit quaternion, on SO(3).
    Quaternion,
}

/// The parts of a case, typed.
#[derive(Clone, Debug)]
pub(super) struct BodyParts<const N: usize, const D: usize> {
    pub lagrangian: Quadratic<f64, N>,
    pub terms: Terms<N>,
    pub tableau: Tableau<f64>,
    pub state: State<f64, N, D>,
    pub tau: Tau,
}

pub(super) fn unsupported(why: impl ToString) -> StepError {
    StepError::Unsupported { why: why.to_string() }
}

impl<const N: usize, const D: usize> BodyParts<N, D> {
    /// Of a case that has a fast step, with a fault planted in its tableau, without its [last term](TERM_MISSING), or as it is.
    pub fn of(case: &Case, fault: Option<&Fault>) -> Result<Self, StepError> {
        let system = case.system::<f64, N, D>(&()).map_err(unsupported)?;
        let AnyLagrangian::Quadratic(lagrangian) = system.lagrangian.kinetic().clone() else {
            return Err(unsupported("the Lagrangian is not quadratic"));
        };
        let mut terms = Terms::new(&system.force, &lagrangian, &system.algebra).map_err(unsupported)?;
        terms.0.extend(case.loads().ok_or_else(|| unsupported("a potential has no form in lanes"))?);
        if fault.is_some_and(|fault| fault.name == TERM_MISSING.name) {
            terms.0.pop();
        }
        let (tau, tableau) = (case.method.retraction, tableau::planted(&system.tableau, fault));
        Ok(Self { lagrangian, terms, tableau, state: system.state, tau })
    }

    fn in_lanes<R: FastRetraction<N, D>>(
        self,
        retraction: R,
        registers: Registers,
        settings: Settings<f64>,
    ) -> Result<VariationalInLanes<Terms<N>, R, N, D>, StepError> {
        let Self { lagrangian, terms, tableau, .. } = self;
        let method = VariationalInLanes::with_settings(lagrangian, terms, retraction, tableau, settings);
        Ok(method.map_err(unsupported)?.in_registers(registers))
    }
}

/// The case with a constant load for its potentials: that at a point.
fn frozen(case: &Case, at: &Point<f64>) -> Result<Case, StepError> {
    let potentials = Case { forces: Vec::new(), ..case.clone() };
    let theory = theory_of::<f64>(&potentials, &StateForm::default()).map_err(unsupported)?;
    let velocity = vec![0.0; case.dimension()];
    let stage = Stage { weight: 1.0, time: at.time, attitude: at.attitude.clone(), velocity };
    let value = theory.force(&stage).into_iter().map(Number::from).collect();
    let mut frozen = case.clone();
    frozen.potentials.clear();
    frozen.forces.push(Force::Constant { value });
    Ok(frozen)
}

/// Which group in lanes a case has.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Group {
    /// SO(3), with either map in closed form.
    So3,
    /// SE(3), with the Cayley map in closed form.
    Se3,
    /// Any other of matrices, with the Cayley map.
    Matrices,
}

/// That group.
///
/// # Errors
/// [`StepError::Unsupported`] where there is no fast step.
pub(super) fn group(case: &Case) -> Result<Group, StepError> {
    use crate::algebra::catalogue::Entry::{Se3, So3};
    let standard = case.algebra.basis.is_none();
    let cayley = case.method.retraction == Tau::Cayley;
    let group = match &case.algebra.structure {
        Structure::Named(So3) if standard && case.method.retraction.closed::<f64>().is_some() => Some(Group::So3),
        Structure::Named(Se3) if standard && cayley => Some(Group::Se3),
        _ if cayley && case.matrix_size() > 0 && case.potentials.is_empty() => Some(Group::Matrices),
        _ => None,
    };
    let found = group.filter(|_| case.method.argument.is_empty() && MAIN_DIMENSIONS.contains(&case.dimension()));
    found.ok_or_else(|| unsupported("there is no fast step on this group or with this retraction"))
}

/// The Cayley map of a case on any group, in the class that most laws know.
pub(super) fn cayley(case: &Case) -> Result<Cayley<f64, { MAIN.0 }, { MAIN.1 }>, StepError> {
    match case.system::<f64, { MAIN.0 }, { MAIN.1 }>(&()).map_err(unsupported)?.retraction {
        AnyRetraction::Cayley(cayley) => Ok(cayley),
        _ => Err(unsupported("the retraction is not the Cayley map")),
    }
}

/// Where a case with a fast step starts.
pub(super) fn start(case: &Case) -> Result<Point<f64>, StepError> {
    group(case)?;
    Ok(theory_of::<f64>(case, &StateForm::default()).map_err(unsupported)?.start())
}

/// The fast step of a case.
pub(super) fn fast(form: Form, case: &Case, registers: Registers, fault: Option<&Fault>) -> Result<Step, StepError> {
    let settings = settings(fault);
    match (group(case)?, form, case.method.retraction.closed()) {
        (Group::So3, _, Some(Core::Cayley(Typed(tau)))) => {
            on_so3(BodyParts::of(case, fault)?, tau, registers, form, settings)
        }
        (Group::So3, _, Some(Core::Exponential(Typed(tau)))) => {
            on_so3(BodyParts::of(case, fault)?, tau, registers, form, settings)
        }
        (Group::So3, ..) => Err(unsupported("the retraction has no closed form on SO(3)")),
        (Group::Se3, Form::Matrix, _) => {
            Ok(on_matrices(BodyParts::of(case, fault)?.in_lanes(CayleySe3::new(), registers, settings)?))
        }
        (Group::Matrices, Form::Matrix, _) => {
            Ok(on_matrices(BodyParts::of(case, fault)?.in_lanes(cayley(case)?, registers, settings)?))
        }
        (_, Form::Quaternion, _) => Err(unsupported("there is a quaternion form on SO(3) alone")),
    }
}

/// Another retraction with a closed form.
pub(super) fn other(tau: Tau) -> Tau {
    let others = Tau::ALL.iter().filter(|other| **other != tau && other.closed::<f64>().is_some());
    others.copied().next().unwrap_or(tau)
}

fn on_so3<R: HalfAngle + 'static>(
    parts: BodyParts<3, 3>,
    retraction: R,
    registers: Registers,
    form: Form,
    settings: Settings<f64>,
) -> Result<Step, StepError> {
    let method = parts.in_lanes(retraction, registers, settings)?;
    if form == Form::Matrix {
        return Ok(on_matrices(method));
    }
    // Where the last step ended.
    let (mut method, mut left) = (QuaternionSo3::of(method), None::<(Point<f64>, QuaternionState)>);
    Ok(Box::new(move |point, h| {
        let mut turning = match left.take() {
            Some((left, turning)) if left == *point => turning,
            _ => point.state::<3, 3>().into(),
        };
        let report = method.step(&mut turning, h)?;
        let end = Point::of(&State::from(turning.clone()), 3);
        left = Some((end.clone(), turning));
        Ok(Taken { end, report, velocities: method.method().stage_velocities() })
    }))
}

fn on_matrices<R: FastRetraction<N, D> + 'static, const N: usize, const D: usize>(
    mut method: VariationalInLanes<Terms<N>, R, N, D>,
) -> Step {
    Box::new(move |point, h| {
        let mut state = point.state::<N, D>();
        let report = method.step(&mut state, h)?;
        let (n, size) = (point.momentum.len(), point.attitude.len().isqrt());
        let mut velocities = method.stage_velocities();
        velocities.iter_mut().for_each(|eta| eta.truncate(n));
        Ok(Taken { end: Point::leading(&state, n, size), report, velocities })
    })
}

/// A step from a point.
pub(super) type Step = Box<dyn FnMut(&Point<f64>, f64) -> Result<Taken, StepError>>;

/// A step that was taken.
pub(super) struct Taken {
    pub end: Point<f64>,
    /// How well its equations hold.
    pub report: Report<f64>,
    /// η_i.
    pub velocities: Vec<Vec<f64>>,
}

/// The step with the whole fault, where that is not planted in the right one or in the answer.
fn wrong(case: &Case, registers: Registers, fault: &Fault) -> Result<Option<Box<dyn Stepper<f64>>>, StepError> {
    let is = |planted: Fault| planted.name == fault.name;
    let fast = move |case: &Case, fault: Option<&Fault>| fast(Form::Matrix, case, registers, fault);
    let method: Box<dyn Stepper<f64>> = if is(step::OF_START) {
        let case = case.clone();
        let step: Step = Box::new(move |point, h| fast(&frozen(&case, point)?, None)?(point, h));
        Box::new(step)
    } else if is(TERM_MISSING) {
        Box::new(fast(case, Some(fault))?)
    } else if is(OTHER_RETRACTION) {
        let mut case = case.clone();
        case.method.retraction = other(case.method.retraction);
        match group(&case) {
            Ok(Group::So3) => Box::new(fast(&case, None)?),
            // In lanes there is none.
            _ => Library { fault: None, quad: false }.build(&case)?,
        }
    } else if step::ALL.iter().any(|one| one.name == fault.name) {
        Library { fault: Some(fault.with_size(1.0)), quad: false }.build(case)?
    } else {
        return Ok(None);
    };
    Ok(Some(method))
}

/// The fast step of a case, in registers of one kind and with the attitude in some form, with a fault or without; with the stages of the
/// right step, whatever is planted.
///
/// # Errors
/// [`StepError::Unsupported`] where there is none.
pub(super) fn engine(form: Form, case: &Case, registers: Registers, fault: Option<&Fault>) -> Result<Step, StepError> {
    let mut right = fast(form, case, registers, fault.filter(|fault| fault.name != TERM_MISSING.name))?;
    let Some(fault) = fault.copied() else { return Ok(right) };
    let mut wrong = wrong(case, registers, &fault)?;
    Ok(Box::new(move |point, h| {
        let mut taken = right(point, h)?;
        if let Some(wrong) = &mut wrong {
            let wrong = wrong.step(point, h)?;
            mix(&mut taken.end.momentum, &wrong.momentum, fault.size);
            mix(&mut taken.end.attitude, &wrong.attitude, fault.size);
        }
        make_faulty(&mut taken.end, point, h, &fault);
        Ok(taken)
    }))
}

/// right + size (wrong − right).
pub(super) fn mix(right: &mut [f64], wrong: &[f64], size: f64) {
    right.iter_mut().zip(wrong).for_each(|(right, wrong)| *right = blend_scalar(*right, *wrong, size));
}

/// The faults that are planted in the answer: [`FAVOURED`], [`SEES_TIME`], [`SEES_ATTITUDE`].
pub(super) fn make_faulty(next: &mut Point<f64>, from: &Point<f64>, h: f64, fault: &Fault) {
    let size = |planted: Fault| planted.size_in(Some(fault));
    next.momentum[0] *= 1.0 + h * size(FAVOURED);
    let factor = (1.0 + h * from.time * size(SEES_TIME)) * (1.0 + h * from.attitude[0] * size(SEES_ATTITUDE));
    next.momentum.iter_mut().for_each(|m| *m *= factor);
}

impl Stepper<f64> for Step {
    fn step(&mut self, point: &Point<f64>, h: f64) -> Result<Point<f64>, StepError> {
        Ok(self(point, h)?.end)
    }
}

/// The fast step as the subject of the laws of methods. It has 16 digits.
pub struct Fast {
    /// The fault.
    pub fault: Option<Fault>,
}

impl MethodSource for Fast {
    fn double<'a>(&'a self, case: &Case) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
        Ok(Box::new(engine(Form::Matrix, case, Registers::detect(), self.fault.as_ref())?))
    }
}
