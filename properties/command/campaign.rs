//! Campaigns on disk: shards in processes of their own, kills, interrupts, refusals.

use super::{Ended, FAULT, LAW, code, directory, ended, objects, rows, run, started, stdout, stopped, typed, wait_for};
use euler_poincare::harness::store::Store;
use serde_json::Value;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::Child;
use std::time::{Duration, Instant};

/// Quick laws.
const LAWS: &str = "retraction-adjoint,retraction-inverse,retraction-tangent";

fn verify(here: &Path, arguments: &str) -> Ended {
    typed(here, &format!("verify --laws {LAWS} {arguments}"))
}

fn start(here: &Path, arguments: &str) -> Child {
    started(here, &[&["verify", "--laws", LAWS], &arguments.split(' ').collect::<Vec<_>>()[..]].concat())
}

fn results(campaign: &Path) -> Vec<u8> {
    fs::read(campaign.join("results.jsonl")).unwrap_or_default()
}

/// (law, index) of the lines of a file.
fn keys(campaign: &Path, file: &str) -> Vec<(String, u64)> {
    let key = |line: &str| {
        let object: Value = serde_json::from_str(line).unwrap();
        (object["law"].as_str().unwrap().to_owned(), object["index"].as_u64().unwrap())
    };
    fs::read_to_string(campaign.join(file)).unwrap().lines().map(key).collect()
}

/// The files of a directory and below, by name.
fn files(directory: &Path) -> BTreeMap<String, String> {
    let Ok(entries) = fs::read_dir(directory) else { return BTreeMap::new() };
    let entries = entries.map(|entry| entry.unwrap().path());
    entries.map(|path| (path.file_name().unwrap().display().to_string(), fs::read_to_string(&path).unwrap())).collect()
}

/// Everything that may not differ between two campaigns that are the same.
fn assert_same(a: &Path, b: &Path) {
    assert!(!results(a).is_empty());
    assert!(results(a) == results(b), "{} and {}", a.display(), b.display());
    assert_eq!(fs::read(a.join("campaign.json")).unwrap(), fs::read(b.join("campaign.json")).unwrap());
    assert_eq!(files(&a.join("failures")), files(&b.join("failures")));
    assert_eq!(keys(a, "timings.jsonl"), keys(b, "timings.jsonl"));
    assert_eq!(keys(a, "timings.jsonl"), keys(a, "results.jsonl"));
}

/// Waits until the campaign has begun to record.
fn wait_for_records(campaign: &Path, child: &mut Child) {
    wait_for(|| {
        assert!(child.try_wait().unwrap().is_none(), "it has ended by itself");
        keys_of_whole_lines(campaign) >= 20
    });
}

#[test]
fn two_shards_in_two_processes_merged_are_the_serial_run() {
    let here = directory("shards");
    for plant in ["", &format!(" --plant {FAULT}")] {
        let path = |name: &str| here.join(format!("{name}{}", plant.len()));
        let name = |name: &str| path(name).display().to_string();
        let campaign = format!("--cases 61 --seed 9 --format json{plant} --out");
        let shards = [("0/2", "1", name("part-0")), ("1/2", "3", name("part-1"))];
        let children =
            shards.map(|(shard, jobs, out)| start(&here, &format!("{campaign} {out} --shard {shard} --jobs {jobs}")));
        let expected = i32::from(!plant.is_empty());
        for child in children {
            ended(child).ends(expected);
        }
        let serial = verify(&here, &format!("{campaign} {} --jobs 2", name("serial"))).ends(expected);
        let merged = run(&here, &["merge", &name("part-1"), &name("part-0"), "--out", &name("whole")]).ends(0);
        assert_eq!(stdout(&merged).contains("BROKEN"), !plant.is_empty(), "{merged}");
        assert_same(&path("whole"), &path("serial"));
        assert_eq!(files(&path("whole").join("failures")).is_empty(), plant.is_empty());
        // Nothing is left to do, and the table is the same.
        let again = verify(&here, &format!("{campaign} {} --resume", name("whole")));
        assert_eq!((code(&again), objects(&again)), (expected, objects(&serial)));
        assert_same(&path("whole"), &path("serial"));
    }
}

#[test]
fn killed_and_resumed_is_the_uninterrupted_run() {
    let here = directory("killed");
    let campaign = "--cases 250 --format json --out";
    let mut child = start(&here, &format!("{campaign} killed --jobs 2"));
    let killed = here.join("killed");
    wait_for_records(&killed, &mut child);
    child.kill().unwrap();
    assert!(ended(child).status.code().is_none(), "it was ended by the signal");
    // What a full disk or a power failure may do as well: both files end within a line.
    for (file, cut) in [("results.jsonl", 30), ("timings.jsonl", 5)] {
        let path = killed.join(file);
        let text = fs::read(&path).unwrap();
        fs::write(path, &text[..text.len() - cut]).unwrap();
    }
    assert!(keys_of_whole_lines(&killed) < 750);
    let resumed = verify(&here, &format!("{campaign} killed --jobs 3 --resume")).ends(0);
    let serial = verify(&here, &format!("{campaign} serial --jobs 1"));
    assert_eq!(objects(&resumed), objects(&serial));
    assert!(results(&killed) == results(&here.join("serial")));
    assert_eq!(keys(&killed, "results.jsonl").len(), 750);
}

fn keys_of_whole_lines(campaign: &Path) -> usize {
    results(campaign).iter().filter(|byte| **byte == b'\n').count()
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_with_what_was_learnt() {
    let here = directory("interrupted");
    for (signal, out) in [("-INT", "first"), ("-TERM", "second")] {
        let campaign = format!("--cases 1000000 --plant {FAULT} --out {out}");
        let mut child = start(&here, &campaign);
        let path = here.join(out);
        wait_for_records(&path, &mut child);
        let output = stopped(child, signal).ends(130);
        let text = stdout(&output);
        assert!(text.contains("INTERRUPTED after ") && text.contains(" of 1000000 cases; --resume goes on"), "{text}");
        assert!(text.contains(&format!("BROKEN {LAW}")), "{text}");
        assert!(text.contains("not saved: the run was interrupted"), "{text}");
        assert!(results(&path).ends_with(b"\n"));
        // It can be taken up again; the failures are shrunk then.
        verify(&here, &format!("{campaign} --resume --minutes 0.002"))
            .ends(1)
            .prints("stopped by --minutes 0.002 after");
        assert_eq!(files(&path.join("failures")).len(), 1);
        let sorted = keys(&path, "results.jsonl");
        assert!(sorted.is_sorted() && sorted.windows(2).all(|pair| pair[0] != pair[1]));
    }
}

#[test]
fn a_limit_of_minutes_gives_each_law_its_share() {
    let here = directory("minutes");
    let start = Instant::now();
    let output = verify(&here, "--minutes 0.05 --format json --out open").quiet();
    assert!(start.elapsed() < Duration::from_secs(60));
    // That each law has its share is asked of the store (harness/store.rs).
    let laws = objects(&output);
    assert!(laws.len() == 3 && laws.iter().any(|law| law["cases"].as_u64() > Some(0)), "{output}");
    let manifest: Value = serde_json::from_slice(&fs::read(here.join("open/campaign.json")).unwrap()).unwrap();
    assert!(manifest["cases"].is_null() && manifest["laws"][0]["cases"].is_null());
    // More of the same: every case that was there is there still.
    let before = keys(&here.join("open"), "results.jsonl");
    verify(&here, "--minutes 0.02 --out open --resume").ends(0);
    let after = keys(&here.join("open"), "results.jsonl");
    assert!(after.len() > before.len() && before.iter().all(|key| after.contains(key)));
    // A number of cases is only cut short.
    let output = verify(&here, "--minutes 5 --cases 4");
    assert!(code(&output) == 0 && !stdout(&output).contains("stopped"), "{output}");
}

#[test]
fn what_is_not_the_same_campaign_is_refused() {
    let here = directory("refused");
    verify(&here, "--cases 20 --out whole").ends(0);
    let before = files(&here.join("whole"));
    let same = "--cases 20 --out whole";
    for (arguments, said) in rows(include_str!("refused/campaign.txt"), 19) {
        verify(&here, &arguments.join(" ")).refuses(&said);
    }
    let laws = run(&here, &["verify", "--laws", LAW, "--cases", "20", "--out", "whole", "--resume"]).ends(2);
    let said = "laws are 3 there, 1 here; only there: retraction-inverse, retraction-tangent; only here: none";
    laws.says(said);
    // One that another run is writing.
    let store = Store::open(&here.join("whole")).unwrap();
    verify(&here, &format!("{same} --resume")).refuses("another run is writing there");
    drop(store);
    assert_eq!(files(&here.join("whole")), before, "a refusal changes nothing");
    let another = |field: &str, value: &str, said: &str| {
        let path = here.join("whole/campaign.json");
        let text = fs::read_to_string(&path).unwrap();
        let mut manifest: Value = serde_json::from_str(&text).unwrap();
        manifest[field] = value.into();
        fs::write(&path, manifest.to_string()).unwrap();
        verify(&here, &format!("{same} --resume")).refuses(said);
        fs::write(&path, text).unwrap();
    };
    another("version", "0.0.1", "version is 0.0.1 there");
    another("binary", "c0ffee", "binary is c0ffee there");
    another("colour", "red", "unknown field `colour`");
    // Lines that no campaign writes.
    let path = here.join("whole/results.jsonl");
    let text = fs::read_to_string(&path).unwrap();
    let first = text.lines().next().unwrap();
    for (damaged, said) in [
        (text.replacen("\"index\":7", "\"index\":\"7\"", 1), "line 8"),
        (text.replacen("\"index\":7", "\"index\":20", 1), "line 8: case 20 of retraction-"),
        (format!("{text}{first}\n"), "line 61: case 0 of retraction-"),
        (text.replacen(LAW, "no-such-law", 1), "no law \"no-such-law\""),
        (text.replacen("\"holds\"", "\"maybe\"", 1), "\"maybe\" is no verdict"),
        (text.replacen('\n', "\n\n", 1), "line 2"),
    ] {
        fs::write(&path, damaged).unwrap();
        verify(&here, &format!("{same} --resume")).refuses(said);
    }
    fs::write(&path, text).unwrap();
    verify(&here, &format!("{same} --resume")).ends(0);
    // A directory with results of nobody knows what.
    fs::remove_file(here.join("whole/campaign.json")).unwrap();
    verify(&here, &format!("{same} --resume")).ends(2).says("campaign.json is missing");
}

#[test]
fn shards_that_are_no_whole_are_refused() {
    let here = directory("no-whole");
    let campaigns = "a 20 --shard 0/3, b 20 --shard 1/3, b2 20 --shard 1/3, c 20 --shard 2/3, half 20 --shard 1/2, \
                     seed 20 --shard 2/3 --seed 2, more 21 --shard 2/3";
    for campaign in campaigns.split(", ") {
        verify(&here, &format!("--out {}", campaign.replacen(' ', " --cases ", 1))).ends(0);
    }
    // As a killed run leaves it: less, and without an end.
    let cut = |name: &str, lines: usize, more: &str| {
        fs::create_dir(here.join(name)).unwrap();
        fs::copy(here.join("c/campaign.json"), here.join(name).join("campaign.json")).unwrap();
        let text = fs::read_to_string(here.join("c/results.jsonl")).unwrap();
        let kept: String = text.lines().take(lines).map(|line| format!("{line}\n")).collect();
        fs::write(here.join(name).join("results.jsonl"), kept + more).unwrap();
    };
    cut("short", 8, "");
    cut("torn", 8, "{\"law\":\"retr");
    // Of 3 laws the shard 2/3 has 6 cases each: 2, 5, …, 17.
    for (arguments, said) in rows(include_str!("refused/merge.txt"), 10) {
        run(&here, &arguments).refuses(&said);
        assert!(!here.join("whole").exists(), "{arguments:?}");
    }
    run(&here, &["merge", "a", "b", "c"]).ends(2);
    let before = files(&here.join("b"));
    run(&here, &["merge", "a", "b", "c", "--out", "./b"]).refuses("./b: is one of the shards");
    assert_eq!(files(&here.join("b")), before);
    run(&here, &["merge", "c", "a", "b", "--out", "whole"]).ends(0);
    run(&here, &["merge", "c", "a", "b", "--out", "whole"]).ends(2);
    assert_eq!(keys(&here.join("whole"), "results.jsonl").len(), 60);
}

#[test]
fn what_faults_needed_is_kept_beside_the_campaign() {
    let here = directory("kept-faults");
    let faults = |more| typed(&here, &format!("verify --faults --laws {LAW} --format json --out whole {more}"));
    verify(&here, "--cases 5 --out whole").ends(0);
    faults("--seed 2").ends(2).says("seed is 1 there, 2 here");
    let output = faults("").ends(0);
    let kept = fs::read_to_string(here.join("whole/faults.jsonl")).unwrap();
    assert_eq!(kept, stdout(&output));
    assert!(kept.lines().all(|line| serde_json::from_str::<Value>(line).unwrap()["caught_after"].is_u64()));
    assert_eq!(code(&faults("")), 2, "it is there already");
}
