//! The laws on parts ([`user`](super::user)), of the parts of described systems.
//!
//! The algebra, the group, the Lagrangian and the force of a case are parts like those that a user brings to
//! [`laws!`](crate::laws!): each law on them is a law on cases here, of the same name, with the same faults. The vectors on
//! which it is judged are drawn from its own strategy, by a seed that the case determines, and stand in the witness.

mod discrete;
mod groupoid;

use super::CaseLaw;
use super::lie_poisson::with_casimirs;
use super::probe::{Probe, stream};
use super::sizes::forcing;
use super::user::algebra::AlgebraLaws;
use super::user::discrete::DiscreteLaws;
use super::user::force::ForceLaws;
use super::user::group::GroupLaws;
use super::user::groupoid::{GroupoidLaws, LieGroupoidLaws};
use super::user::lagrangian::LagrangianLaws;
use super::user::part::{Kind, Part};
use crate::algebra::{Covector, LieAlgebra, Vector};
use crate::harness::{About, Cost, Fault, Verdict, draw};
use crate::laws::unbuilt;
use crate::mechanics::Lagrangian;
use crate::mechanics::lagrangian::AnyLagrangian;
use crate::scalar::{Dd, Number, Real};
use crate::system::Cases;
use crate::system::case::{Case, Drag, Force};
use crate::system::dispatch::Main;
use crate::system::rates::Rates;

/// A kind of parts that described systems have.
trait Described: Kind {
    /// How many of them, the last, are laws on cases of their own elsewhere, by the same names.
    const ELSEWHERE: usize = 0;

    /// What a law costs on such parts, where it is not what it says.
    const COST: Option<Cost> = None;

    /// The part of a system; `None` where it has none.
    fn part(case: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>>;

    /// Cases that have the part and what a law needs of it; those with a group, if it does not say otherwise.
    fn cases(_: &About, cases: Cases) -> Cases {
        cases.main_dimensions().with_group()
    }
}

fn check<K: Described, const I: usize>(case: &Case, fault: Option<&Fault>) -> Verdict {
    judge::<K>(&K::LAWS[I], case, fault)
}

fn judge<K: Described>(law: &About, case: &Case, fault: Option<&Fault>) -> Verdict {
    let both = case.main(&()).and_then(|double| Ok((double, case.main(&())?)));
    let part = match both.map(|(double, quad)| K::part(case, double, quad)) {
        Ok(Some(part)) => part,
        Ok(None) => return Verdict::not_applicable("the system has no such part"),
        Err(e) => return unbuilt(&e),
    };
    let drawn = draw(&part.cases(law), Probe::new(case, stream::PARTS).next(), law.name, 0);
    let values = match drawn.case {
        Ok((values, _)) => values,
        Err(why) => return Verdict::inconclusive(why),
    };
    match part.check(law, &values, fault) {
        Verdict::Broken { defect, bound, witness } => {
            let at = values.to_string().replace('\n', ", ");
            Verdict::Broken { defect, bound, witness: format!("{witness}; at {at}") }
        }
        verdict => verdict,
    }
}

/// The law number I on parts of a kind, if it has that many that are laws on cases.
const fn law<K: Described, const I: usize>() -> Option<CaseLaw> {
    if I + K::ELSEWHERE >= K::LAWS.len() {
        return None;
    }
    let about = K::LAWS[I];
    let cost = match K::COST {
        Some(cost) => cost,
        None => about.cost,
    };
    let cases = |cases| K::cases(&K::LAWS[I], cases);
    Some(CaseLaw { about: About { cost, ..about }, cases, check: check::<K, I> })
}

/// The laws on parts of a kind. Each needs a function of its own, so the numbers are written out.
#[rustfmt::skip]
const fn laws_on<K: Described>() -> &'static [Option<CaseLaw>] {
    const { assert!(K::LAWS.len() <= 16, "a longer list is needed") };
    const {
        &[
            law::<K, 0>(), law::<K, 1>(), law::<K, 2>(), law::<K, 3>(), law::<K, 4>(), law::<K, 5>(),
            law::<K, 6>(), law::<K, 7>(), law::<K, 8>(), law::<K, 9>(), law::<K, 10>(), law::<K, 11>(),
            law::<K, 12>(), law::<K, 13>(), law::<K, 14>(), law::<K, 15>(),
        ]
    }
}

/// The laws of this file.
pub fn laws() -> impl Iterator<Item = &'static CaseLaw> {
    let lists = [
        laws_on::<AlgebraLaws<6>>(),
        laws_on::<GroupLaws<6, 8>>(),
        laws_on::<LagrangianLaws<6>>(),
        laws_on::<ForceLaws<6>>(),
        laws_on::<GroupoidLaws>(),
        laws_on::<LieGroupoidLaws>(),
        laws_on::<DiscreteLaws<6, 8>>(),
    ];
    lists.into_iter().flatten().flatten()
}

impl Described for AlgebraLaws<6> {
    fn part(_: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>> {
        Some(Part::at_both((double.algebra, double.casimirs), (quad.algebra, quad.casimirs)))
    }

    fn cases(law: &About, cases: Cases) -> Cases {
        match law.name {
            "algebra-casimirs" => with_casimirs(cases),
            _ => cases.main_dimensions(),
        }
    }
}

impl Described for GroupLaws<6, 8> {
    fn part(_: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>> {
        Some(Part::at_both(double.group?, quad.group?))
    }
}

impl Described for LagrangianLaws<6> {
    fn part(_: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>> {
        Some(Part::at_both(double.lagrangian, quad.lagrangian))
    }

    fn cases(_: &About, cases: Cases) -> Cases {
        cases.main_dimensions()
    }
}

impl Described for ForceLaws<6> {
    fn part(case: &Case, double: Main<f64>, quad: Main<Dd>) -> Option<Part<Self>> {
        // A force that vanishes identically is rounding, of which nothing is claimed.
        let driven = Rates::of(case).is_some_and(|rates| rates.driven);
        let every = |claim: fn(&Force) -> bool| driven && case.forces.iter().all(claim);
        let mut part = Part::at_both(double.force, quad.force)
            .summing(terms(double.algebra, double.lagrangian.clone()), terms(quad.algebra, quad.lagrangian.clone()));
        if every(Force::dissipates) {
            part = part.dissipates();
        }
        if every(Force::is_workless) {
            part = part.workless();
        }
        if every(|force| force.description().keeps_casimirs) {
            part = part.keeps_both((double.lagrangian, double.casimirs), (quad.lagrangian, quad.casimirs));
        }
        Some(part)
    }

    fn cases(law: &About, cases: Cases) -> Cases {
        let main = cases.clone().main_dimensions();
        let quarter = Number::ratio(1, 4);
        match law.name {
            "force-dissipates" => {
                claimed(main.forced(), Force::dissipates, Force::LinearDrag(Drag::Coefficient(quarter)))
            }
            "force-workless" => {
                claimed(main.forced_nonabelian(), Force::is_workless, Force::Metriplectic { beta: quarter })
            }
            "force-keeps-casimirs" => {
                let cases = with_casimirs(cases).forced_nonabelian();
                claimed(cases, |force| force.description().keeps_casimirs, Force::DoubleBracket { alpha: quarter })
            }
            _ => main,
        }
    }
}

/// The size of the brackets that a force is made of, at η and l'(η).
fn terms<T: Real, const N: usize>(
    algebra: LieAlgebra<T, N>,
    lagrangian: AnyLagrangian<T, N>,
) -> impl Fn(&Vector<T, N>) -> T {
    move |eta| forcing(&algebra, &Covector::zeros(), eta, &lagrangian.gradient(eta))
}

/// The cases with those terms of their force alone of which a claim holds, or this one where there are none; as they were where
/// that vanishes identically.
fn claimed(cases: Cases, claim: fn(&Force) -> bool, otherwise: Force) -> Cases {
    let kept = move |case: Case| {
        let mut forces: Vec<Force> = case.forces.iter().filter(|force| claim(force)).cloned().collect();
        if forces.is_empty() {
            forces.push(otherwise.clone());
        }
        let kept = Case { forces, ..case.clone() };
        if Rates::of(&kept).is_some_and(|rates| rates.driven) { kept } else { case }
    };
    cases.mapped(kept)
}
