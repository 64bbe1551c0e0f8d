//! Properties of `euler_poincare::laws::user`, laws on single parts: they hold on the library's parts, see every fault that
//! can be planted, and name mistakes made by hand in types like those of a user.

use euler_poincare::harness::{CampaignReport, Law, catch_fault, verdict_on};
use euler_poincare::laws::user::part::{self, Kind, Part};
use euler_poincare::laws::user::values::Values;
use std::collections::BTreeSet;

mod algebra;
pub mod discrete;
mod force;
mod group;
pub mod groupoid;
mod lagrangian;
mod values;

const SEED: u64 = 20261122;

/// Every law on a part holds or does not apply, and is decided in four cases of five where it applies.
fn clean<K: Kind>(name: &str, part: Part<K>, cases: usize) -> CampaignReport<Values> {
    let report = part::run(part, SEED, cases);
    for law in &report.laws {
        if let Some(failure) = law.failures.first() {
            panic!("{name}, {}: {}\n{}", law.law, failure.verdict, failure.case);
        }
        assert!(law.broken.is_empty() && law.irreproducible.is_empty(), "{name}, {}", law.law);
        let undecided: usize = law.inconclusive.values().sum();
        assert!(undecided * 5 <= law.held + undecided, "{name}, {}: {:?}", law.law, law.inconclusive);
    }
    report
}

/// The laws that apply to none of a part's cases.
fn switched_off(report: &CampaignReport<Values>) -> Vec<&'static str> {
    report.laws.iter().filter(|law| law.held == 0).map(|law| law.law).collect()
}

/// The (law, fault) that a number of cases of a part do not show.
fn missed<K: Kind>(part: Part<K>, cases: usize) -> BTreeSet<(&'static str, &'static str)> {
    let laws = part::laws(part);
    let faults = laws.iter().flat_map(|law| law.faults().iter().map(move |fault| (law, fault)));
    let missed = faults.filter(|(law, fault)| catch_fault(*law, fault, SEED, cases).is_none());
    missed.map(|(law, fault)| (law.name(), fault.name)).collect()
}

/// The laws that a part breaks, with a shrunk case on which each is broken still.
fn broken<K: Kind>(part: impl Fn() -> Part<K>, cases: usize) -> Vec<(&'static str, Values)> {
    let report = part::run(part(), SEED, cases);
    let mut found = Vec::new();
    for law in report.laws {
        if let Some(failure) = law.failures.into_iter().next() {
            let again = part::law(part(), law.law).expect("a law of the list");
            assert_eq!(verdict_on(&again, &failure.case, None), failure.verdict, "{}", law.law);
            assert!(failure.verdict.is_broken());
            // A saved case is the same case.
            let text = serde_json::to_string(&failure.case).expect("a case is written");
            assert_eq!(serde_json::from_str::<Values>(&text).expect("a case is read"), failure.case);
            found.push((law.law, failure.case));
        }
    }
    found
}

fn names(found: &[(&'static str, Values)]) -> Vec<&'static str> {
    found.iter().map(|(name, _)| *name).collect()
}

/// `verify` runs every law on a part, in the same words; that it does once is asked in laws.rs.
#[test]
fn every_law_is_in_the_campaign() {
    use euler_poincare::laws::user;
    let parts = [user::algebra::LAWS, user::group::LAWS, user::lagrangian::LAWS, user::force::LAWS];
    let discrete = [user::groupoid::LAWS, user::groupoid::LIE_LAWS, user::discrete::LAWS];
    for about in parts.into_iter().chain(discrete).flatten() {
        let law = euler_poincare::laws::named(about.name).map(|law| law.about.statement);
        assert_eq!(law, Some(about.statement), "{}", about.name);
    }
}
