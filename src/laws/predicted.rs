//! The order that the coefficients predict is the order that is measured, from both sides, for random tableaux.
//!
//! In 32 digits, on steps that shrink to where nothing but rounding is left ([`StepLevel::shrinking`]): a term of lower
//! order shows however small its coefficient. The reference is a classical Gauss method on the vector field of (μ, g).

use super::integrators::subject;
use super::planted::retraction::{INVERSE_MISSING, Plant};
use super::planted::step::{
    FIRST_STAGE, FORCE_INDEX, FROM_LEFT, INVERSE_SECOND, INVERTED, NO_FORCE, NO_SECOND, NOT_TRANSPORTED, ORDER_TWO,
    SWAPPED_SECOND, UNCONJUGATED,
};
use super::planted::tableau::{COEFFICIENT, WRONG_STAGE, planted};
use super::{CaseLaw, Source};
use crate::harness::{About, Cost, Fault, Verdict, evidence};
use crate::integrators::MuntheKaas;
use crate::laws::unbuilt;
use crate::mechanics::equations::EulerPoincare;
use crate::scalar::Dd;
use crate::study::least::{self, Answer};
use crate::study::{Comparison, Findings, StepLevel, Study, problem, reference};
use crate::system::case::Method;
use crate::system::{Case, Cases, System, Visitor};
use crate::tableau::{Classic, Description, Family, Order, Tableau, classical_order, known, variational_order};
use proptest::sample::select;
use proptest::strategy::{BoxedStrategy, Strategy, Union};

const BOUND: &str = "a quarter: half the way to the point that is as near to the next integer";
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
            CaseLaw {
                about: About {
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
                },
                cases: |cases| smooth(cases).with_tableaux(tableaux()),
                check: |case, fault| check(case, fault, Which::Variational),
            },
            CaseLaw {
                about: About {
                    name: "order-munthe-kaas",
                    statement: "a Runge–Kutta–Munthe-Kaas method has the classical order of its tableau in (μ, g)",
                    source: "Munthe-Kaas 1999, Thm 3.3",
                    oracle: ORACLE,
                    bound: BOUND,
                    needs: "a group; a smooth force; an algebra that is not abelian",
                    cost: Cost::Expensive,
                    faults: &[WRONG_STAGE, INVERSE_MISSING],
                },
                cases: |cases| smooth(cases).with_tableaux(tableaux()),
                check: |case, fault| check(case, fault, Which::MuntheKaas),
            },
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

/// The order of a method on a system, compared.
struct Measured {
    comparison: Comparison,
    order: u32,
    /// The errors; none where there was no reference.
    findings: Option<Findings>,
}

impl Measured {
    /// The verdict; `of` says for the evidence whose errors decide.
    fn verdict(self, of: &str) -> Verdict {
        evidence::note_all(|| {
            let of = format!("{of}, after {STEPS} steps");
            self.findings.iter().flat_map(|findings| findings.evidence(self.order, 32, &of)).collect::<Vec<_>>()
        });
        self.comparison.verdict()
    }
}

/// As predicted or below decides. Above, the case may be special: then others are asked ([`least`]).
fn check<S: Source>(case: &S, fault: Option<&Fault>, which: Which) -> Verdict {
    let first = match measure(case, fault, which) {
        Ok(measured) => measured,
        Err(verdict) => return verdict,
    };
    if !matches!(first.comparison, Comparison::Above { .. } | Comparison::Exact) {
        return first.verdict("");
    }
    let others = least::of_others(|k| {
        let measured = match k {
            least::GENERIC => on_generic(&case.case().method, fault, which)?,
            _ => measure(&case.with_case(problem::varied(case.case(), k)), fault, which)?,
        };
        Ok(Some(((&measured.comparison).into(), measured)))
    });
    match others {
        Ok(Answer::Decided(least::GENERIC, found)) => found.verdict(" of a body without symmetry"),
        Ok(Answer::Decided(k, found)) => found.verdict(&format!(" of variation {k} of the system")),
        Ok(Answer::More) => first.verdict(""),
        Ok(Answer::Open) => Verdict::inconclusive(least::UNCONFIRMED),
        Err(verdict) => verdict,
    }
}

fn measure<S: Source>(case: &S, fault: Option<&Fault>, which: Which) -> Result<Measured, Verdict> {
    let measured = case.visit::<Dd, _>(&Plant(fault), Descent { fault, which });
    measured.map_err(|e| unbuilt(&e))
}

/// The same on a body without symmetry; compiled here once, whatever the source.
fn on_generic(method: &Method, fault: Option<&Fault>, which: Which) -> Result<Measured, Verdict> {
    let file = problem::generic().map_err(|e| Verdict::broken(e.to_string()))?;
    measure(&Case { method: method.clone(), ..file.case }, fault, which)
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
        let (l, f, r) = (&system.lagrangian, &system.force, &system.retraction);
        let body = EulerPoincare::new(system.algebra.clone(), l, f);
        // Down to where an error of this order is 2⁻⁹⁰ of what it was, and no further than it takes to see a wrong coefficient.
        let levels = (90 / (order as usize + 1) + 3).min(LEVELS);
        let levels = StepLevel::shrinking(system.step, STEPS, levels);
        let times: Vec<Dd> = levels.iter().map(StepLevel::duration).collect();
        let Ok(targets) = reference::at(&body, system.group.as_ref(), &system.state, &times, 4 + order as usize / 2)
        else {
            let comparison = Comparison::Unknown { why: "the reference did not converge".into() };
            return Measured { comparison, order, findings: None };
        };
        let study = Study::new(system.state.clone()).with_attitude();
        let faulty = planted(&system.tableau, self.fault);
        let findings = match self.which {
            Which::Variational => study.descend(|| subject(&system, self.fault), &levels, &targets),
            Which::MuntheKaas => study.descend(|| MuntheKaas::new(body.clone(), r, faulty.clone()), &levels, &targets),
        };
        let findings = findings.local();
        Measured { comparison: findings.compare(order), order, findings: Some(findings) }
    }
}
