//! The laws of methods, of the fast step.

use super::engine::{Fast, TERM_MISSING};
use crate::harness::{Cost, Fault, Verdict};
use crate::laws::CaseLaw;
use crate::laws::method::library::{FAVOURED, SEES_ATTITUDE, SEES_TIME, claims, method_law};
use crate::laws::method::{
    CASIMIRS, CONSERVES_CASIMIRS, ENERGY, EQUIVARIANCE, MethodLaw, ORDER, REVERSIBILITY, check_case,
};
use crate::laws::planted::step::{
    CHART, FIRST_STAGE, FORCE_TIME, FROM_LEFT, HALVED, INVERTED, NO_FORCE, NO_SECOND, NOT_TRANSPORTED,
};
use crate::system::{Case, Cases};
use crate::tableau::{Classic, Description, Family};
use proptest::sample::select;

fn judge(law: &MethodLaw, case: &Case, fault: Option<&Fault>) -> Verdict {
    check_case(law, &Fast { fault: fault.copied() }, case, &claims(case)).verdict
}

fn drawn(law: &MethodLaw, cases: Cases) -> Cases {
    let base = base(cases);
    // Without a force the energy of a nearly steady motion drifts by less than 16 digits tell from rounding.
    let base = if *law == ENERGY { base.forced() } else { base };
    law.cases(base)
}

/// Tableaux of order 1 and 2: between 10⁻³ and rounding, 16 digits have too few levels of the slope of a higher order.
fn base(cases: Cases) -> Cases {
    let tableaux = vec![
        Description::Family(Family::Gauss, 1),
        Description::Family(Family::LobattoIIIA, 2),
        Description::Family(Family::LobattoIIIB, 2),
        Description::Family(Family::LobattoIIIC, 2),
        Description::Family(Family::RadauIA, 1),
        Description::Family(Family::RadauIIA, 1),
        Description::Classic(Classic::Heun2),
    ];
    cases.fast().with_tableaux(select(tableaux))
}

pub(super) static LAWS: &[CaseLaw] = &[
    method_law!(
        "fast-order",
        &ORDER,
        Cost::Moderate,
        &[
            TERM_MISSING,
            NO_FORCE,
            NOT_TRANSPORTED,
            FIRST_STAGE,
            FORCE_TIME,
            INVERTED,
            FROM_LEFT,
            FAVOURED,
            SEES_TIME,
            SEES_ATTITUDE
        ]
    ),
    method_law!("fast-casimirs", &CASIMIRS, Cost::Moderate, &[HALVED, NOT_TRANSPORTED, FAVOURED]),
    method_law!("fast-conserves-casimirs", &CONSERVES_CASIMIRS, Cost::Moderate, &[CHART, HALVED, FAVOURED]),
    method_law!("fast-energy", &ENERGY, Cost::Moderate, &[NO_FORCE, NO_SECOND, FAVOURED]),
    method_law!(
        "fast-reversibility",
        &REVERSIBILITY,
        Cost::Moderate,
        &[FORCE_TIME, NOT_TRANSPORTED, INVERTED, SEES_ATTITUDE]
    ),
    method_law!("fast-equivariance", &EQUIVARIANCE, Cost::Cheap, &[FROM_LEFT, SEES_TIME, SEES_ATTITUDE]),
];
