//! Properties of `euler_poincare::laws`: every law holds on random systems, and catches every fault planted for it.

use euler_poincare::harness::{Campaign, Law, catch_fault};
use euler_poincare::laws;
use euler_poincare::system::Case;
use std::collections::BTreeSet;

/// Cases per law: the campaigns of the command go further; a test has to be short.
const CASES: usize = 60;

#[test]
fn every_law_holds() {
    let laws: Vec<&dyn Law<Case>> = laws::all().into_iter().map(|law| law as &dyn Law<Case>).collect();
    let report = Campaign::new(1, CASES).run(&laws);
    for law in &report.laws {
        let inconclusive: usize = law.inconclusive.values().sum();
        assert!(inconclusive * 20 <= law.cases, "{}: {:?}", law.law, law.inconclusive);
        assert!(law.held * 2 > law.cases, "{} hardly applies: {:?}", law.law, law.not_applicable);
        for failure in &law.failures {
            println!("{failure:?}");
        }
    }
    assert!(report.holds());
}

#[test]
fn every_planted_fault_is_caught_within_a_hundred_cases() {
    for law in laws::all() {
        assert!(!law.faults.is_empty(), "{} names no fault that it catches", law.name);
        for fault in law.faults {
            let caught = catch_fault(law, fault, 1, 100);
            assert!(caught.is_some(), "{} does not catch {}: {}", law.name, fault.name, fault.what);
        }
    }
}

#[test]
fn every_step_fault_is_seen_by_two_laws() {
    let faults = |file: &[laws::CaseLaw]| -> Vec<(&str, &str)> {
        file.iter().flat_map(|law| law.faults.iter().map(|fault| (fault.name, law.name))).collect()
    };
    let seen = [faults(laws::integrators::LAWS), faults(laws::order::LAWS)].concat();
    let names: BTreeSet<_> = seen.iter().map(|(fault, _)| *fault).filter(|name| *name != "units-left").collect();
    for name in names {
        let by = seen.iter().filter(|(fault, _)| *fault == name).count();
        assert!(by >= 2, "{name} is seen by {by} law");
    }
}

#[test]
fn names_are_unique_and_descriptions_complete() {
    let names: BTreeSet<_> = laws::all().iter().map(|law| law.name).collect();
    assert_eq!(names.len(), laws::all().len());
    for law in laws::all() {
        for text in [law.statement, law.source, law.oracle, law.bound] {
            assert!(!text.is_empty(), "{} leaves something out", law.name);
        }
        assert_eq!(laws::named(law.name).map(|found| found.name), Some(law.name));
    }
}
