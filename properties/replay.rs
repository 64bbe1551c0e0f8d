//! Properties of `euler_poincare::laws::replay`.

use euler_poincare::harness::evidence::Evidence;
use euler_poincare::harness::{Cost, Law, draw, shrink_from, verdict_on};
use euler_poincare::laws::replay::{REGRESSIONS, Replayed, judged};
use euler_poincare::laws::{self, CaseLaw};
use euler_poincare::system::{Case, Replay, cases, labels};
use std::path::Path;

const RECORD: &str = "retraction-adjoint-adjoint-inverted-seed7-case4.json";

fn record() -> Replay {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(REGRESSIONS).join(RECORD);
    Replay::from_json(&std::fs::read_to_string(path).unwrap()).unwrap()
}

/// Cases of a law, as a campaign draws them.
fn drawn(law: &CaseLaw, count: usize) -> Vec<Case> {
    let strategy = law.cases();
    (0..count).filter_map(|index| draw(&strategy, 1, law.about.name, index).case.ok()).map(|(case, _)| case).collect()
}

#[test]
fn evidence_has_both_precisions_and_changes_no_verdict() {
    let mut seen = (0, 0);
    for law in laws::all().into_iter().filter(|law| law.about.cost == Cost::Cheap) {
        for case in drawn(law, 3) {
            let plain = verdict_on(law, &case, None);
            let (verdict, evidence) = judged(law, None, &case, None);
            assert_eq!(verdict, plain, "{}\n{case}", law.about.name);
            let Some((defect, _)) = plain.measured() else { continue };
            assert!(!evidence.is_empty(), "{} tells nothing", law.about.name);
            let digits: Vec<u32> = evidence.iter().map(Evidence::digits).collect();
            // The fast steps have 16 digits.
            let both = !law.about.name.starts_with("fast-");
            seen.0 += usize::from(both);
            seen.1 += usize::from(both && digits.contains(&16) && digits.contains(&32));
            let worst = evidence.iter().any(|one| match one {
                Evidence::Defect { defect: told, digits, .. } => {
                    // Two laws are judged by relative defects, told in units of round-off.
                    let unit = if *digits == 16 { 0.5_f64.powi(53) } else { 0.5_f64.powi(103) };
                    *told == defect || (told * unit - defect).abs() <= 1e-12 * defect
                }
                Evidence::Levels { .. } => true,
            });
            assert!(worst, "{}: {defect} is not among {evidence:?}", law.about.name);
        }
    }
    assert!(seen.1 * 10 >= seen.0 * 9, "{seen:?}");
}

#[test]
fn one_precision_alone_judges_by_itself() {
    let law = laws::named("retraction-adjoint").unwrap();
    let fault = law.fault("adjoint-inverted").unwrap();
    for case in drawn(law, 10) {
        for digits in [16, 32] {
            let (verdict, evidence) = judged(law, None, &case, Some(digits));
            assert!(verdict.holds(), "{verdict}");
            assert!(evidence.iter().all(|one| one.digits() == digits) && evidence.len() == 1);
        }
    }
    let replay = record();
    for digits in [16, 32] {
        let (verdict, _) = judged(law, Some(fault), &replay.case, Some(digits));
        assert!(verdict.is_broken(), "{verdict}");
    }
}

#[test]
fn a_record_that_names_nothing_known_says_what_is_known() {
    // Laws, faults, algebras and steps that are none are asked of the command.
    let json = record().to_json().unwrap();
    for (from, to, said) in [
        ("\"gauss-2\"", "\"gauss-0\"", "number of stages"),
        ("\"seed\": 7", "\"seed\": -7", "line 3"),
        ("\"seed\"", "\"sead\"", "unknown field"),
    ] {
        assert!(json.contains(from), "{json}");
        let error = Replayed::from_json(&json.replacen(from, to, 1), None).map(|_| ()).unwrap_err();
        assert!(error.to_string().contains(said), "{from} to {to}: {error}");
    }
}

#[test]
fn a_read_case_shrinks_within_what_its_law_admits() {
    let law = laws::named("retraction-adjoint").unwrap();
    let fault = law.fault("adjoint-inverted").unwrap();
    let replay = record();
    let shrunk = shrink_from(law, Some(fault), &replay.case, 2000).unwrap();
    assert!(shrunk.steps > 0 && shrunk.verdict.is_broken());
    assert_eq!(verdict_on(law, &shrunk.case, Some(fault)), shrunk.verdict);
    assert!((law.cases)(cases()).could_draw(&shrunk.case), "{}", shrunk.case);
    // Nothing of what does not matter is left.
    let case = &shrunk.case;
    assert!(case.forces.is_empty() && case.algebra.basis.is_none() && case.start.attitude.is_none(), "{case}");
    assert_eq!(case.method.tableau.to_string(), "gauss-1");
    // From there, nothing simpler is broken; and it is the same each time.
    assert_eq!(shrink_from(law, Some(fault), case, 2000).unwrap().steps, 0);
    assert_eq!(shrink_from(law, Some(fault), &replay.case, 2000), Some(shrunk.clone()));
    assert_eq!(shrink_from(law, None, &replay.case, 2000), None, "not broken");
    let none = shrink_from(law, Some(fault), &replay.case, 0).unwrap();
    assert_eq!((none.case, none.checks), (replay.case.clone(), 0));
    let (smaller, found) = Replayed::of(replay, None).unwrap().shrunk(Some(32), 2000).unwrap();
    assert!(smaller.verdict.is_broken() && found.steps > 0);
    assert!(smaller.evidence.iter().all(|one| one.digits() == 32));
}

#[test]
fn simpler_cases_are_of_the_law() {
    for law in laws::all() {
        let admitted = (law.cases)(cases());
        for case in drawn(law, 2) {
            let mut told = 0;
            let _ = admitted.simpler(&case).any(|candidate| {
                told += 1;
                assert!(admitted.could_draw(&candidate), "{}\n{candidate}", law.about.name);
                assert_eq!(candidate.check(), Ok(()), "{}\n{candidate}", law.about.name);
                assert_ne!(candidate, case);
                told >= 20
            });
            // A case may be the simplest already.
            assert!(told > 0 || labels(&case).contains(&("dimension", "1".into())), "{}\n{case}", law.about.name);
        }
    }
}
