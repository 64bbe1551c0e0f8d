//! Properties of `euler_poincare::laws`: every law holds on random systems, and catches every fault planted for it.

mod algebras;
mod fast;
mod harness;
mod order;
mod replay;
mod system;

use euler_poincare::algebra::catalogue::Entry;
use euler_poincare::harness::{Campaign, Cost, Law, catch_fault, draw};
use euler_poincare::laws::replay::{REGRESSIONS, Replayed, save};
use euler_poincare::laws::{self, user};
use euler_poincare::system::case::Structure;
use euler_poincare::system::{Case, Replay, cases};
use rayon::prelude::*;
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Cases per law: the campaigns of the command go further; a test has to be short.
const CASES: usize = 24;

/// With as many cases of a law that is cheap, `branch` has a hundred.
const BRANCHES: usize = 10_000;

/// Not the seed of the command's campaign, whose cases are judged there.
const SEED: u64 = 2;

#[test]
fn every_law_holds() {
    // Orders take a release build: `verify`.
    let laws = laws::all().into_iter().filter(|law| law.about.cost != Cost::Heavy);
    let laws: Vec<&dyn Law<Case>> = laws.map(|law| law as &dyn Law<Case>).collect();
    let report = Campaign::new(SEED, CASES).run(&laws);
    for law in &report.laws {
        let inconclusive: usize = law.inconclusive.values().sum();
        // One in twenty; of few cases two may be chance: of 32 with a share of 1 %, three are once in 250 times.
        assert!(inconclusive <= (law.cases / 20).max(2), "{}: {:?}", law.law, law.inconclusive);
        assert!(law.held * 2 > law.cases, "{} hardly applies: {:?}", law.law, law.not_applicable);
        for failure in &law.failures {
            // From now on it is replayed before everything else.
            let (law, case) = (law.law.to_string(), failure.case.clone());
            let replay =
                Replay { module: None, law, seed: failure.seed, index: failure.index as u64, fault: None, case };
            let kept = save(&Path::new(env!("CARGO_MANIFEST_DIR")).join(REGRESSIONS), &replay);
            let again = Replayed::of(replay, None).map_or_else(|e| e.to_string(), |again| again.to_string());
            println!("{again}\nkept: {kept:?}\n");
        }
    }
    assert!(report.holds());
}

/// Steps that are given up on the way, neither taken nor at a fold: the law counts them as inconclusive. On 5,000 cases they are 1.5 %.
#[test]
fn few_branches_are_given_up() {
    let laws = laws::all().into_iter().filter(|law| law.about.name == "branch");
    let laws: Vec<&dyn Law<Case>> = laws.map(|law| law as &dyn Law<Case>).collect();
    let report = Campaign::new(SEED, BRANCHES).run(&laws);
    let [branch] = &report.laws[..] else { panic!("{} laws", report.laws.len()) };
    assert!(report.holds(), "{:?}", branch.failures);
    let given_up: usize = branch.inconclusive.values().sum();
    assert!(branch.cases >= 100 && given_up * 50 <= branch.cases, "of {}: {:?}", branch.cases, branch.inconclusive);
}

/// The labels of a case that say on what it is drawn, as [`euler_poincare::system::labels`] has them: that one takes a step of the case, too.
fn kinds(case: &Case) -> [(&'static str, String); 3] {
    let algebra = match &case.algebra.structure {
        Structure::Named(Entry::Product(_)) => "product".into(),
        Structure::Named(entry) => entry.to_string(),
        _ => "in no catalogue".into(),
    };
    let basis = if case.algebra.basis.is_some() { "changed" } else { "standard" };
    let composed = !case.method.argument.is_empty();
    let retraction = if composed { "composed" } else { case.method.retraction.name() };
    [("algebra", algebra), ("basis", basis.into()), ("retraction", retraction.into())]
}

/// The kinds of systems that a law has to be drawn on. A kind with a share of 4 % is missed once in 10⁷ times in 400 draws.
#[test]
fn every_law_is_drawn_on_every_kind_of_algebra_basis_and_retraction() {
    let algebras = ["aff1", "heisenberg", "product", "se2", "se3", "sl2", "so3", "so4"];
    // Laws whose knobs are the same draw the same cases: one of them is asked. What an image does is not printed.
    let mut asked = std::collections::BTreeMap::new();
    for law in laws::all() {
        let name = law.about.name;
        let knobs = format!("{:?}", (law.cases)(cases()));
        let own = if knobs.contains("image: an image") { name } else { "" };
        let of_so3 = name.contains("ensemble") || name.contains("quaternion") || name == "configuration-drift";
        asked.entry((knobs, own, name.starts_with("fast-"), of_so3, name.contains("casimir"))).or_insert(law);
    }
    asked.into_par_iter().for_each(|((.., fast, of_so3, casimir), law)| {
        // Those on the axes of a body.
        let on_bodies = fast && (of_so3 || ["fast-weight", "fast-presentation"].contains(&law.about.name));
        let expected: Vec<&str> = match (fast, of_so3) {
            (true, true) => vec!["so3"],
            (true, false) if on_bodies => vec!["se3", "so3"],
            // Of groups of rotations.
            (false, true) => vec!["so3", "so4", "product"],
            // No polynomial is constant on the orbits of aff(1), which are open. Products are not drawn in lanes.
            _ => algebras
                .into_iter()
                .filter(|algebra| (!casimir || *algebra != "aff1") && (!fast || *algebra != "product"))
                .collect(),
        };
        let mut missing: BTreeSet<(&str, &str)> = expected.iter().map(|algebra| ("algebra", *algebra)).collect();
        missing.extend([("basis", "standard"), ("retraction", "exp")]);
        if !on_bodies {
            missing.insert(("basis", "changed"));
        }
        // An advected parameter is moved by the exponential.
        if law.about.name != "configuration-advected" {
            missing.insert(("retraction", "cayley"));
            missing.extend((!fast).then_some(("retraction", "composed")));
        }
        let all = missing.clone();
        let strategy = law.cases();
        for index in 0..400 {
            if missing.is_empty() && !(on_bodies && index < 40) {
                break;
            }
            let Ok((case, _)) = draw(&strategy, 0, law.about.name, index).case else { continue };
            for (category, label) in kinds(&case) {
                missing.retain(|kind| *kind != (category, label.as_str()));
                let known = all.iter().any(|kind| *kind == (category, label.as_str()));
                assert!(!on_bodies || known, "{}: {label}", law.about.name);
            }
        }
        assert!(missing.is_empty(), "{} is not drawn on {missing:?}", law.about.name);
    });
}

/// The snapshot: a line for each law and fault, written by `verify --faults --sizes --format json`.
fn table() -> Vec<Value> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/snapshots/faults.jsonl");
    let text = std::fs::read_to_string(path).unwrap();
    text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn the_table_of_faults_is_that_of_the_laws() {
    let pairs: Vec<_> =
        laws::all().iter().flat_map(|law| law.about.faults.iter().map(|fault| (law.about.name, fault.name))).collect();
    let table = table();
    let listed: Vec<_> =
        table.iter().map(|row| (row["law"].as_str().unwrap(), row["fault"].as_str().unwrap())).collect();
    assert_eq!(listed, pairs, "write it again: euler-poincare verify --faults --sizes --format json");
    for row in &table {
        assert!(row["caught_after"].as_u64().is_some_and(|cases| (1..=100).contains(&cases)), "{row}");
        assert!(row["smallest_size"].as_f64().is_some_and(|size| size <= 1.0), "{row}");
    }
}

/// And of each law the last fault that it names at its smallest size. The laws that cost more are the command's: the gate has it plant all
/// faults, and compares what it says with the table.
#[test]
fn cheap_laws_catch_each_fault_as_soon_as_in_the_table_and_the_last_at_the_smallest_size() {
    let table = table();
    let rows: Vec<_> = table
        .iter()
        .filter_map(|row| {
            let law = laws::named(row["law"].as_str()?)?;
            let fault = law.fault(row["fault"].as_str()?)?;
            let last = law.about.faults.last().is_some_and(|last| last.name == fault.name);
            (law.about.cost == Cost::Cheap).then_some((law, fault, row, last))
        })
        .collect();
    rows.par_iter().with_max_len(1).for_each(|(law, fault, row, last)| {
        let caught = catch_fault(*law, fault, 1, 100).map(|cases| cases as u64);
        assert_eq!(caught, row["caught_after"].as_u64(), "{} on {}", law.about.name, fault.name);
        let small = fault.with_size(row["smallest_size"].as_f64().unwrap());
        assert!(!last || catch_fault(*law, &small, 1, 100).is_some(), "{} on {small:?}", law.about.name);
    });
}

/// One map of a part may be wrong for the law alone that says what the map is; one law alone takes steps at which there is another root,
/// one alone runs the solver, and one alone takes steps whose length is no dyadic number.
#[test]
fn every_fault_is_seen_by_two_laws_and_means_the_same_to_both() {
    let parts = [user::algebra::LAWS, user::group::LAWS, user::lagrangian::LAWS, user::force::LAWS];
    let parts = [&parts[..], &[user::groupoid::LAWS, user::groupoid::LIE_LAWS, user::discrete::LAWS]].concat().concat();
    let of_part = |name: &str| parts.iter().any(|law| law.name == name);
    let seen: Vec<_> =
        laws::all().iter().flat_map(|law| law.about.faults.iter().map(|fault| (law.about.name, *fault))).collect();
    for (name, fault) in &seen {
        let again = seen.iter().any(|(other, same)| other != name && same.name == fault.name);
        let alone = of_part(name) || ["branch", "solve-dense", "method-smoothness"].contains(name);
        assert!(again || alone, "{}: {name}", fault.name);
        for (other, same) in seen.iter().filter(|(_, same)| same.name == fault.name) {
            assert_eq!(same, fault, "{} means one thing to {name} and another to {other}", fault.name);
        }
    }
    for law in laws::all() {
        assert!(!law.about.faults.is_empty(), "{} names no fault that it catches", law.about.name);
    }
}

#[test]
fn names_are_unique_and_descriptions_complete() {
    let names: BTreeSet<_> = laws::all().iter().map(|law| law.about.name).collect();
    assert_eq!(names.len(), laws::all().len());
    for law in laws::all() {
        assert!(law.about.name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'-'), "{}", law.about.name);
        for text in [law.about.statement, law.about.source, law.about.oracle, law.about.bound] {
            assert!(!text.is_empty(), "{} leaves something out", law.about.name);
        }
        assert_eq!(laws::named(law.about.name).map(|found| found.about.name), Some(law.about.name));
    }
}
