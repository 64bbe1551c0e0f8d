//! Cases that broke a law once, again, before everything else: the records in `snapshots/regressions`.
//!
//! Cargo runs test targets by name: this one is first. A record without a fault must not break its law; with a fault, the law
//! must still catch it.

use euler_poincare::laws::replay::{REGRESSIONS, Replayed, replay_all, save};
use euler_poincare::system::{Case, Replay};
use std::fs;
use std::path::{Path, PathBuf};

fn kept() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(REGRESSIONS)
}

#[test]
fn what_broke_once_holds_now() {
    let records = replay_all(&kept(), |_| true).unwrap();
    assert!(!records.is_empty(), "{} has no records", kept().display());
    let failing: Vec<_> = records.iter().filter(|record| !record.passes()).collect();
    for record in &failing {
        let found = record.outcome.as_ref().map_or_else(Clone::clone, ToString::to_string);
        println!("{}\n{found}\n", record.path.display());
    }
    assert!(failing.is_empty(), "{} of {} records fail", failing.len(), records.len());
}

/// An empty directory of this test.
fn directory(test: &str) -> PathBuf {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("again").join(test);
    let _ = fs::remove_dir_all(&path);
    path
}

fn record(law: &str, fault: Option<&str>) -> Replay {
    let toml = "format = 1\n[algebra]\nname = \"so3\"\n[method]\ntableau = \"gauss-1\"\nretraction = \"exp\"\n\
                [state]\nvelocity = [1, 2, \"1/3\"]\n[run]\nstep = \"1/8\"\n";
    let case = Case::from_toml(toml).unwrap();
    Replay { module: None, law: law.into(), seed: 3, index: 5, fault: fault.map(Into::into), case }
}

#[test]
fn records_are_saved_replayed_in_sequence_and_judged() {
    let here = directory("judged");
    assert_eq!(replay_all(&here, |_| true).unwrap().len(), 0, "no directory, no records");
    for replay in [
        record("retraction-inverse", None),
        record("retraction-adjoint", None),
        record("retraction-adjoint", Some("adjoint-inverted")),
        record("no-such-law", None),
        record("retraction-adjoint", Some("no-such-fault")),
    ] {
        let path = save(&here, &replay).unwrap();
        assert_eq!(Replay::from_json(&fs::read_to_string(path).unwrap()), Ok(replay));
    }
    fs::write(here.join("garbage.json"), "{\"law\": 3}").unwrap();
    fs::write(here.join("notes.txt"), "no record").unwrap();
    let records = replay_all(&here, |_| true).unwrap();
    let found: Vec<_> =
        records.iter().map(|kept| (kept.path.file_name().unwrap().to_str().unwrap(), kept.passes())).collect();
    assert_eq!(
        found,
        [
            ("garbage.json", false),
            ("no-such-law-seed3-case5.json", false),
            ("retraction-adjoint-adjoint-inverted-seed3-case5.json", true),
            ("retraction-adjoint-no-such-fault-seed3-case5.json", false),
            ("retraction-adjoint-seed3-case5.json", true),
            ("retraction-inverse-seed3-case5.json", true),
        ]
    );
    // What cannot be read fails whatever was asked for.
    let some = replay_all(&here, |law| law == "retraction-inverse").unwrap();
    assert_eq!(some.iter().filter(|kept| kept.passes()).count(), 1);
    assert_eq!(some.len(), 3);
}

#[test]
fn a_broken_record_says_all_there_is() {
    let replay = record("retraction-adjoint", Some("adjoint-inverted"));
    let replayed = Replayed::of(replay.clone(), None).unwrap();
    assert!(replayed.passes() && replayed.verdict.is_broken());
    let text = replayed.to_string();
    let parts = "retraction-adjoint: Ad_{τ(ξ)} ¦ Sato Martín de Almagro 2019 ¦ adjoint-inverted:  ¦ broken: defect ¦ 16 digits ¦ 32 digits ¦ \
                 ABOVE the bound ¦ from case 5 of seed 3 ¦ algebra    so3";
    for part in parts.split(" ¦ ") {
        assert!(text.contains(part), "{part:?} is not in\n{text}");
    }
    let sound = Replayed::of(Replay { fault: None, ..replay }, None).unwrap();
    assert!(sound.passes() && sound.verdict.holds() && !sound.to_string().contains("ABOVE"));
}
