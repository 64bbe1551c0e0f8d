//! The laws of methods, of this crate's integrator: with planted faults.

use super::{
    CASIMIRS, CONSERVES_CASIMIRS, CONSERVES_MOMENTUM, Claims, ENERGY, EQUIVARIANCE, MOMENTUM, MethodLaw, MethodSource,
    NOETHER, ORDER, POISSON, PRESENTATION, REVERSIBILITY, SMOOTHNESS, Stepper, Untyped, VARIATIONAL, check_case,
};
use crate::harness::{Cost, Fault, Verdict};
use crate::integrators::{OneStep, Report, StagePoint, State, StepError};
use crate::laws::CaseLaw;
use crate::laws::planted::retraction::{BERNOULLI, Plant, SHIFTED};
use crate::laws::planted::step::{
    BALANCE, CHART, EQUATIONS, FIRST_STAGE, FORCE_INDEX, FORCE_TIME, FROM_LEFT, HALVED, INVERTED, LOOSE_TOLERANCE,
    NO_FORCE, NO_SECOND, NOT_TRANSPORTED, ORDER_TWO, UNCONJUGATED, joined,
};
use crate::laws::planted::tableau::COEFFICIENT;
use crate::laws::step::subject;
use crate::scalar::{Dd, Real};
use crate::system::{Case, Cases, System};
use crate::tableau::{Classic, Description, Family, variational_order};
use proptest::sample::select;

pub const FAVOURED: Fault = Fault::new(
    "favoured-axis",
    "μ'_1 multiplied by 1 + h: the first basis vector is not like the others",
    "every system",
);
pub const SINGLE_STEP: Fault = Fault::new("step-in-single", "h rounded to single precision", "every system that moves");
pub const SEES_TIME: Fault = Fault::new(
    "sees-time",
    "μ' multiplied by 1 + h t: t is seen where the force does not depend on it",
    "every system",
);
pub const SEES_ATTITUDE: Fault =
    Fault::new("sees-attitude", "μ' multiplied by 1 + h g_11: the momentum sees the attitude", "every group");

/// The step of a system that it owns.
struct Owned<T: Real, const N: usize, const D: usize> {
    system: System<T, N, D>,
    fault: Option<Fault>,
    /// Where the last step began, and its size.
    last: Option<(State<T, N, D>, T)>,
}

impl<T, const N: usize, const D: usize> OneStep<T, N, D> for Owned<T, N, D>
where
    T: Real,
{
    fn step(&mut self, state: &mut State<T, N, D>, h: T) -> Result<Report<T>, StepError> {
        let (time, corner) = (state.time, state.attitude[(0, 0)]);
        self.last = Some((state.clone(), h));
        let size = |fault: &Fault| T::exact(fault.size_in(self.fault.as_ref()));
        let single = T::exact(f64::from(h.to_f64() as f32));
        let taken = h + (single - h) * size(&SINGLE_STEP);
        let report = subject(&self.system, self.fault.as_ref()).step(state, taken)?;
        state.momentum[0] *= T::one() + h * size(&FAVOURED);
        state.momentum *= T::one() + h * time * size(&SEES_TIME);
        state.momentum *= T::one() + h * corner * size(&SEES_ATTITUDE);
        Ok(report)
    }

    /// Those of the right step, whatever is planted in the one that is judged.
    fn stages(&self) -> Option<Vec<StagePoint<T, N, D>>> {
        let (start, h) = self.last.as_ref()?;
        let mut right = self.system.scheme();
        right.step(&mut start.clone(), *h).ok()?;
        right.stages()
    }
}

/// This crate's variational integrator, with a fault planted in it or without. For algebras of dimension up to 6.
pub struct Library {
    /// The fault.
    pub fault: Option<Fault>,
    /// Whether it is judged in 32 digits too.
    pub quad: bool,
}

impl Library {
    /// It in either precision.
    ///
    /// # Errors
    /// [`StepError::Unsupported`] where the case cannot be built.
    pub(in crate::laws) fn build<T: Real>(&self, case: &Case) -> Result<Box<dyn Stepper<T>>, StepError> {
        match case.main(&Plant(self.fault.as_ref())) {
            Ok(system) => Ok(Box::new(Untyped(Owned { system, fault: self.fault, last: None }))),
            Err(error) => Err(StepError::Unsupported { why: error.to_string() }),
        }
    }
}

impl MethodSource for Library {
    fn double<'a>(&'a self, case: &Case) -> Result<Box<dyn Stepper<f64> + 'a>, StepError> {
        self.build::<f64>(case)
    }

    fn quad<'a>(&'a self, case: &Case) -> Option<Result<Box<dyn Stepper<Dd> + 'a>, StepError>> {
        self.quad.then(|| self.build::<Dd>(case).map(|stepper| stepper as _))
    }
}

/// The highest order of a tableau that is drawn here, and one more.
const HIGHEST: usize = 6;

/// What the theory claims of the integrator of a case.
pub fn claims(case: &Case) -> Claims {
    let tableau = case.method.tableau.build::<Dd>();
    let order = tableau.map(|tableau| variational_order(&tableau, HIGHEST).order as u32).ok();
    let variational = Some(case.method.clone());
    Claims { order, casimirs: true, momentum: true, poisson: true, stages: true, variational, ..Claims::default() }
}

fn judge(law: &MethodLaw, case: &Case, fault: Option<&Fault>) -> Verdict {
    let library = Library { fault: fault.copied(), quad: true };
    check_case(law, &library, case, &claims(case)).verdict
}

fn drawn(law: &MethodLaw, cases: Cases) -> Cases {
    law.cases(base(cases))
}

/// Groups of the main dimensions, with tableaux of few stages.
fn base(cases: Cases) -> Cases {
    let mut tableaux: Vec<Description> = vec![
        Description::Family(Family::Gauss, 1),
        Description::Family(Family::Gauss, 2),
        Description::Family(Family::LobattoIIIA, 2),
        Description::Family(Family::LobattoIIIB, 2),
        Description::Family(Family::RadauIIA, 2),
    ];
    tableaux.extend([Classic::Rk4, Classic::Heun2].map(Description::Classic));
    cases.with_group().main_dimensions().with_tableaux(select(tableaux))
}

/// A law of methods on the subject of `judge`, with the cases of `drawn`, by a name and of a cost of its own.
macro_rules! method_law {
    ($name:literal, $law:expr, $cost:expr, $faults:expr) => {
        CaseLaw {
            about: $crate::harness::About { name: $name, cost: $cost, faults: $faults, ..$law.about },
            cases: |cases| drawn($law, cases),
            check: |case, fault| judge($law, case, fault),
        }
    };
}
pub(in crate::laws) use method_law;

/// The laws of methods on this crate's integrator, with the claims of the theory: its order, that it keeps Casimirs, momentum
/// and bracket, and that it is the scheme.
pub(in crate::laws) static LAWS: &[CaseLaw] = &[
    method_law!(
        "method-order",
        &ORDER,
        Cost::Heavy,
        &[
            NO_FORCE,
            NOT_TRANSPORTED,
            FIRST_STAGE,
            FORCE_INDEX,
            FORCE_TIME,
            INVERTED,
            FROM_LEFT,
            ORDER_TWO,
            COEFFICIENT,
            FAVOURED,
            SEES_TIME,
            SEES_ATTITUDE
        ]
    ),
    method_law!("method-casimirs", &CASIMIRS, Cost::Expensive, &[HALVED, NOT_TRANSPORTED, FAVOURED]),
    method_law!("method-energy", &ENERGY, Cost::Expensive, &[NO_FORCE, NOT_TRANSPORTED, NO_SECOND, FAVOURED]),
    method_law!(
        "method-reversibility",
        &REVERSIBILITY,
        Cost::Expensive,
        // Not `attitude-from-left`: τ(ξ'')τ(ξ') is conjugate to τ(ξ')τ(ξ''), so that it returns to e at the same order.
        &[FORCE_TIME, NOT_TRANSPORTED, INVERTED, SEES_ATTITUDE]
    ),
    method_law!(
        "method-momentum",
        &MOMENTUM,
        Cost::Expensive,
        &[HALVED, INVERTED, NOT_TRANSPORTED, FROM_LEFT, FAVOURED, SEES_ATTITUDE]
    ),
    method_law!("method-conserves-casimirs", &CONSERVES_CASIMIRS, Cost::Expensive, &[CHART, HALVED, FAVOURED]),
    method_law!(
        "method-conserves-momentum",
        &CONSERVES_MOMENTUM,
        Cost::Expensive,
        &[CHART, HALVED, INVERTED, FROM_LEFT, ORDER_TWO, FAVOURED, SEES_ATTITUDE]
    ),
    method_law!("method-noether", &NOETHER, Cost::Moderate, &joined::<9, 2, 11>(BALANCE, [FAVOURED, SEES_ATTITUDE])),
    method_law!("method-poisson", &POISSON, Cost::Expensive, &[UNCONJUGATED, NO_SECOND, HALVED, FAVOURED]),
    method_law!(
        "method-variational",
        &VARIATIONAL,
        Cost::Expensive,
        &joined::<15, 6, 21>(EQUATIONS, [COEFFICIENT, BERNOULLI, SHIFTED, FAVOURED, SEES_TIME, SEES_ATTITUDE])
    ),
    method_law!("method-equivariance", &EQUIVARIANCE, Cost::Moderate, &[FROM_LEFT, SEES_TIME, SEES_ATTITUDE]),
    method_law!("method-presentation", &PRESENTATION, Cost::Moderate, &[SHIFTED, FAVOURED]),
    method_law!("method-smoothness", &SMOOTHNESS, Cost::Expensive, &[LOOSE_TOLERANCE, SINGLE_STEP]),
];
