//! The order that the coefficients predict is the order that is measured, from both sides, for random tableaux.
//!
//! In 32 digits, on steps that shrink to where nothing but rounding is left ([`StepLevel::shrinking`]): a term of lower
//! order shows however small its coefficient. The reference is a classical Gauss method on the vector field of (μ, g).

use super::order::BOUND;
use super::planted::retraction::{INVERSE_MISSING, Plant};
use super::planted::step::{
    FIRST_STAGE, FORCE_INDEX, FROM_LEFT, INVERSE_SECOND, INVERTED, NO_FORCE, NO_SECOND, NOT_TRANSPORTED, ORDER_TWO,
    SWAPPED_SECOND, UNCONJUGATED,
};
use super::planted::tableau::{COEFFICIENT, WRONG_STAGE, planted};
use super::question::law;
use super::step::subject;
use super::{CaseLaw, Source};
use crate::harness::{Cost, Fault, Verdict, evidence};
use crate::integrators::MuntheKaas;
use crate::laws::unbuilt;
use crate::scalar::Dd;
use crate::study::least::{self, Answer};
use crate::study::{Comparison, Findings, StepLevel, Study, problem, reference};
use crate::system::{Case, Cases, System, Visitor};
use crate::tableau::{Classic, Description, Family, Order, Tableau, classical_order, known, variational_order};
use proptest::sample::select;
use proptest::strategy::{BoxedStrategy, Strategy, Union};

const ORACLE: &str = "a classical Gauss method of order 16 on the vector field; the order computed from the trees";

/// Steps of each level: two, so that what a step does to the state it hands on counts.
const STEPS: usize = 2;

/// The most levels, each with half the step of the one before.
const LEVELS: usize = 16;

/// The highest order that is checked; the generators stay below.
const HIGHEST: usize = 10;

/// The laws of this file.
pub const fn laws<S: Source>() -> &'static [CaseLaw<S>] {
    const {
        &[
            law!(Law {
                name: "order-predicted",
                statement: "the variational integrator has the order of the pair (a, â) in (μ, g), neither more nor less, for any tableau",
                source: "Martín de Diego and Sato Martín de Almagro 2019, Thm 5.4",
                oracle: ORACLE,
                bound: BOUND,
                needs: "a group; a smooth force; an algebra that is not abelian",
                cost: Cost::Moderate,
                faults: &[
                    INVERSE_SECOND,
                    NO_SECOND,
                    SWAPPED_SECOND,
                    FORCE_INDEX,
                    UNCONJUGATED,
                    NO_FORCE,
                    NOT_TRANSPORTED,
                    FIRST_STAGE,
                    INVERTED,
                    FROM_LEFT,
                    ORDER_TWO,
                    COEFFICIENT,
                ],
                cases: |cases| smooth(cases).with_tableaux(tableaux()),
                check: |case, fault| check(case, fault, Which::Variational).unwrap_or_else(|verdict| verdict),
            }),
            law!(Law {
                name: "order-munthe-kaas",
                statement: "a Runge–Kutta–Munthe-Kaas method has the classical order of its tableau in (μ, g)",
                source: "Munthe-Kaas 1999, Thm 3.3",
                oracle: ORACLE,
                bound: BOUND,
                needs: "a group; a smooth force; an algebra that is not abelian",
                cost: Cost::Expensive,
                faults: &[WRONG_STAGE, INVERSE_MISSING],
                cases: |cases| smooth(cases).with_tableaux(tableaux()),
                check: |case, fault| check(case, fault, Which::MuntheKaas).unwrap_or_else(|verdict| verdict),
            }),
        ]
    }
}

fn smooth(cases: Cases) -> Cases {
    cases.forced_nonabelian().smooth().with_group().main_dimensions()
}

/// Tableaux of known order 1 to 6, every class of them; one in five has a name, its order at most 6 too.
///
/// Built once for each thread: the lists behind it take longer than a case.
fn tableaux() -> BoxedStrategy<Description> {
    thread_local! {
        static KNOWN: BoxedStrategy<Description> = {
            let mut named: Vec<Description> = Classic::DRAWN.map(Description::Classic).to_vec();
            for family in Family::DRAWN {
                let least = family.least_stages();
                named.extend((least..least + 3).map(|stages| Description::Family(family, stages)));
            }
            let random = known::descriptions(known::any_of_known_order());
            Union::new_weighted(vec![(4, random), (1, select(named).boxed())]).boxed()
        };
    }
    KNOWN.with(Clone::clone)
}

/// Which method.
#[derive(Clone, Copy)]
enum Which {
    Variational,
    MuntheKaas,
}

impl Which {
    /// Its order by the coefficients.
    fn order(self, tableau: &Tableau<Dd>) -> Order {
        match self {
            Which::Variational => variational_order(tableau, HIGHEST),
            Which::MuntheKaas => classical_order(tableau, HIGHEST),
        }
    }
}

/// The errors of a method on a system, and its order; none where there is no reference.
type Measured = Option<(Findings, u32)>;

fn compare(measured: &Measured) -> Comparison {
    match measured {
        Some((findings, order)) => findings.compare(*order),
        None => Comparison::Unknown { why: "the reference did not converge".into() },
    }
}

/// The verdict; `of` says for the evidence whose errors decide.
fn decided(measured: &Measured, of: &str) -> Verdict {
    evidence::note_all(|| {
        let of = format!("{of}, after {STEPS} steps");
        measured.iter().flat_map(|(findings, order)| findings.evidence(*order, 32, &of)).collect::<Vec<_>>()
    });
    compare(measured).verdict()
}

/// As predicted or below decides. Above, the case may be special: then others are asked ([`least`]).
fn check<S: Source>(case: &S, fault: Option<&Fault>, which: Which) -> Result<Verdict, Verdict> {
    let first = measure(case, fault, which)?;
    if !matches!(compare(&first), Comparison::Above { .. } | Comparison::Exact) {
        return Ok(decided(&first, ""));
    }
    let others = least::of_others(|k| {
        let measured = match k {
            least::GENERIC => on_generic(case.case(), fault, which)?,
            _ => measure(&case.with_case(problem::varied(case.case(), k)), fault, which)?,
        };
        Ok(Some((compare(&measured).ordering(), measured)))
    });
    Ok(match others? {
        Answer::Decided(least::GENERIC, found) => decided(&found, " of a body without symmetry"),
        Answer::Decided(k, found) => decided(&found, &format!(" of variation {k} of the system")),
        Answer::More => decided(&first, ""),
        Answer::Open => Verdict::inconclusive(least::UNCONFIRMED),
    })
}

fn measure<S: Source>(case: &S, fault: Option<&Fault>, which: Which) -> Result<Measured, Verdict> {
    case.visit::<Dd, _>(&Plant(fault), Descent { fault, which }).map_err(|e| unbuilt(&e))
}

/// The same on a body without symmetry; compiled here once, whatever the source.
fn on_generic(case: &Case, fault: Option<&Fault>, which: Which) -> Result<Measured, Verdict> {
    measure(&problem::other(case, least::GENERIC).map_err(|e| Verdict::broken(e.to_string()))?, fault, which)
}

/// The errors of a method on a system, down to round-off.
struct Descent<'a> {
    fault: Option<&'a Fault>,
    which: Which,
}

impl Visitor<Dd> for Descent<'_> {
    type Output = Measured;

    const LARGE: bool = false;

    const KNOWS_CONFIGURATION: bool = true;

    fn visit<const N: usize, const D: usize>(self, system: System<Dd, N, D>) -> Measured {
        let order = self.which.order(&system.tableau).order as u32;
        let body = system.equations();
        // Down to where an error of this order is 2⁻⁹⁰ of what it was, and no further than it takes to see a wrong coefficient.
        let levels = (90 / (order as usize + 1) + 3).min(LEVELS);
        let levels = StepLevel::shrinking(system.step, STEPS, levels);
        let times: Vec<Dd> = levels.iter().map(StepLevel::duration).collect();
        let group = system.group.as_ref();
        let targets = reference::at(&body, group, &system.state, &times, 4 + order as usize / 2).ok()?;
        let study = Study::new(system.state.clone()).with_attitude();
        let faulty = || MuntheKaas::new(body.clone(), &system.retraction, planted(&system.tableau, self.fault));
        let findings = match self.which {
            Which::Variational => study.descend(|| subject(&system, self.fault), &levels, &targets),
            Which::MuntheKaas => study.descend(faulty, &levels, &targets),
        };
        Some((findings.local(), order))
    }
}
