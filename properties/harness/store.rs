//! Campaigns in directories, on toy laws.

use super::{BREAKS, FILTERED, HOLDS, NO_CASES, PANICS, UNDECIDED, fingerprint, labels};
use euler_poincare::harness::store::{Manifest, Store, StoreError, Writer, merge};
use euler_poincare::harness::{
    Campaign, CampaignReport, Cost, Done, Ending, Halt, Law, Record, Recorded, Shard, Sink, Verdict,
};
use proptest::prelude::*;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

const LAWS: [&dyn Law<i64>; 6] = [&HOLDS, &BREAKS, &PANICS, &UNDECIDED, &FILTERED, &NO_CASES];

/// A directory of this test that is not there yet.
fn fresh(test: &str) -> PathBuf {
    static COUNT: AtomicUsize = AtomicUsize::new(0);
    let name = format!("{test}-{}", COUNT.fetch_add(1, Ordering::Relaxed));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("store").join(name);
    let _ = fs::remove_dir_all(&path);
    path
}

fn manifest(seed: u64, cases: Option<usize>, shard: Shard) -> Manifest {
    let shard = (shard != Shard::WHOLE).then(|| [shard.index(), shard.count()]);
    Manifest { shard, ..Manifest::new("0.0.0", "toy", seed, cases, &LAWS) }
}

/// Goes on with the campaign, for at most a number of cases.
fn go_on(path: &Path, manifest: &Manifest, threads: usize, most: usize) -> Result<CampaignReport<i64>, StoreError> {
    let store = Store::resume(path, manifest.clone())?;
    let recorded = store.recorded(&LAWS)?;
    let begun = AtomicUsize::new(0);
    let halt = || if begun.fetch_add(1, Ordering::Relaxed) < most { Halt::No } else { Halt::Cases };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let writer = store.writer()?;
    let report = pool.install(|| {
        let campaign = match manifest.cases {
            Some(cases) => Campaign::new(manifest.seed, cases).halt(&halt),
            None => Campaign::until(manifest.seed, &halt),
        };
        campaign.labels(&labels).shard(manifest.shard()).sink(&writer).resume(&LAWS, recorded)
    });
    writer.finish()?;
    store.sort()?;
    Ok(report)
}

fn results(path: &Path) -> String {
    fs::read_to_string(path.join("results.jsonl")).unwrap()
}

/// The file that the report of a campaign in memory would have, record by record.
fn serial(seed: u64, cases: usize, threads: usize) -> (PathBuf, CampaignReport<i64>) {
    let path = fresh("serial");
    let report = go_on(&path, &manifest(seed, Some(cases), Shard::WHOLE), threads, usize::MAX).unwrap();
    assert_eq!(report.ending, Ending::Complete);
    (path, report)
}

#[test]
fn the_file_has_a_record_of_every_case_in_canonical_order() {
    let (path, report) = serial(3, 50, 3);
    let in_memory = Campaign::new(3, 50).labels(&labels).run(&LAWS);
    assert_eq!(fingerprint(&report), fingerprint(&in_memory));
    let records: Vec<Record> = results(&path).lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    let keys: Vec<_> = records.iter().map(|record| (record.law.as_str(), record.index)).collect();
    let expected: Vec<_> =
        LAWS.iter().flat_map(|law| (0..law.about().cost.cases(50)).map(|index| (law.name(), index))).collect();
    assert_eq!(keys, expected);
    for record in &records {
        let case = euler_poincare::harness::draw(&UNDECIDED.cases(), 3, "undecided", record.index).case;
        if record.law == "undecided" {
            let sign = if case.unwrap().0 < 0 { "negative" } else { "other" };
            assert_eq!(record.labels, [("sign".to_owned(), sign.to_owned())]);
        }
        assert_eq!(record.labels.is_empty(), record.law == "no-cases");
    }
    assert_eq!(results(&path), results(&serial(3, 50, 1).0));
}

#[test]
fn records_have_the_documented_keys_in_the_documented_order() {
    let labels = vec![("z", "1".into()), ("a", "2".into()), ("z", "3".into())];
    let broken = Record::new("toy", 4, Verdict::broken("two\nlines"), labels, [("odd".into(), 2)].into());
    let text = concat!(
        r#"{"law":"toy","index":4,"verdict":"broken","defect":null,"bound":0.0,"witness":"two\nlines","#,
        r#""labels":{"z":"1+3","a":"2"},"rejections":{"odd":2}}"#
    );
    assert_eq!(serde_json::to_string(&broken).unwrap(), text);
    assert_eq!(broken.each_label().collect::<Vec<_>>(), [("z", "1"), ("z", "3"), ("a", "2")]);
    for wrong in [
        r#"{"law":"toy","index":4,"verdict":"holds","defect":1.0}"#,
        r#"{"law":"toy","index":4,"verdict":"holds","defect":1.0,"bound":2.0,"why":"no"}"#,
        r#"{"law":"toy","index":4,"verdict":"broken","defect":1.0,"bound":2.0}"#,
        r#"{"law":"toy","index":4,"verdict":"inconclusive","defect":1.0,"bound":2.0,"why":"no"}"#,
        r#"{"law":"toy","index":-4,"verdict":"inconclusive","why":"no"}"#,
        r#"{"law":"toy","index":4,"verdict":"inconclusive","why":"no","seconds":3}"#,
        r#"{"index":4,"verdict":"inconclusive","why":"no"}"#,
    ] {
        assert!(serde_json::from_str::<Record>(wrong).is_err(), "{wrong}");
    }
}

proptest! {
    /// Any f64, any text: what is read is what was written, to the bit.
    #[test]
    fn records_come_back(
        law in ".*", index in any::<usize>(), defect in any::<f64>(), bound in any::<f64>(), texts in prop::collection::vec(".*", 3),
        count in any::<usize>(), kind in 0..4,
    ) {
        let verdict = match kind {
            0 => Verdict::Holds { defect, bound },
            1 => Verdict::Broken { defect, bound, witness: texts[0].clone() },
            2 => Verdict::inconclusive(texts[0].clone()),
            _ => Verdict::not_applicable(texts[0].clone()),
        };
        let labels = vec![("b", texts[1].clone()), ("a", texts[2].clone()), ("b", "more".into())];
        let record = Record::new(&law, index, verdict, labels, [(texts[2].clone(), count)].into());
        let line = serde_json::to_string(&record).unwrap();
        prop_assert!(!line.contains('\n'));
        let read: Record = serde_json::from_str(&line).unwrap();
        prop_assert_eq!(&read, &record);
        prop_assert_eq!(serde_json::to_string(&read).unwrap(), line);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Some of the records in any sequence, then a part of another: what is resumed is the uninterrupted campaign.
    #[test]
    fn any_records_with_a_torn_tail_resume_to_the_same_file(
        seed in 0..1000_u64, cases in 1..40_usize, keys in prop::collection::vec(any::<u32>(), 400), share in 0.0..=1.0_f64,
        torn in 0.0..1.0_f64, threads in 1..4_usize,
    ) {
        let (whole, report) = serial(seed, cases, 2);
        let text = results(&whole);
        let mut lines: Vec<(u32, &str)> = keys.iter().copied().zip(text.lines()).collect();
        lines.sort_unstable();
        let kept = (share * lines.len() as f64) as usize;
        let mut part: String = lines[..kept].iter().map(|(_, line)| format!("{line}\n")).collect();
        if let Some((_, next)) = lines.get(kept) {
            let end = (torn * next.len() as f64) as usize;
            part.push_str(next.get(..end).unwrap_or_default());
        }
        let path = fresh("torn");
        let manifest = manifest(seed, Some(cases), Shard::WHOLE);
        drop(Store::create(&path, manifest.clone()).unwrap());
        fs::write(path.join("results.jsonl"), part).unwrap();
        let resumed = go_on(&path, &manifest, threads, usize::MAX).unwrap();
        prop_assert_eq!(resumed.ending, Ending::Complete);
        prop_assert_eq!(fingerprint(&resumed), fingerprint(&report));
        prop_assert_eq!(results(&path), text);
        fs::remove_dir_all(path).unwrap();
        fs::remove_dir_all(whole).unwrap();
    }

    /// Shards, each halted any number of times, are together the serial campaign.
    #[test]
    fn halted_shards_merge_to_the_same_file(
        seed in 0..1000_u64, cases in 1..40_usize, count in 1..6_usize, most in 8..60_usize, threads in 1..4_usize, turn in 0..6_usize,
    ) {
        let (whole, _) = serial(seed, cases, 2);
        let mut paths = Vec::new();
        for i in 0..count {
            let manifest = manifest(seed, Some(cases), Shard::new(i, count).unwrap());
            let path = fresh("shard");
            prop_assert!((0..1000).any(|_| go_on(&path, &manifest, threads, most).unwrap().ending == Ending::Complete));
            paths.push(path);
        }
        paths.rotate_left(turn % count);
        let out = fresh("merged");
        let merged = merge(&paths, &out).unwrap();
        prop_assert_eq!(results(&out), results(&whole));
        prop_assert_eq!(merged.records, results(&whole).lines().count());
        let manifests = [&out, &whole].map(|path| fs::read(path.join("campaign.json")).unwrap());
        prop_assert_eq!(&manifests[0], &manifests[1]);
        drop(merged);
        for path in paths.iter().chain([&out, &whole]) {
            fs::remove_dir_all(path).unwrap();
        }
    }

    /// A case is in exactly one shard, and a set of cases counts what was put into it.
    #[test]
    fn shards_divide_the_cases(count in 1..20_usize, cases in 0..200_usize, keys in prop::collection::vec(0..200_usize, 0..300)) {
        let shards: Vec<Shard> = (0..count).map(|i| Shard::new(i, count).unwrap()).collect();
        prop_assert_eq!(shards.iter().map(|shard| shard.size(cases)).sum::<usize>(), cases);
        for index in 0..cases {
            prop_assert_eq!(shards.iter().filter(|shard| shard.owns(index)).count(), 1);
        }
        for shard in shards {
            prop_assert_eq!(shard.to_string().parse::<Shard>().unwrap(), shard);
            let mut done = Done::new(shard);
            let mut set = std::collections::BTreeSet::new();
            for &index in &keys {
                prop_assert_eq!(done.insert(index), shard.owns(index) && set.insert(index));
            }
            prop_assert_eq!(done.len(), set.len());
            prop_assert_eq!(Some(done.first_missing()), (0..).find(|index| shard.owns(*index) && !set.contains(index)));
        }
    }
}

#[test]
fn no_shards() {
    for text in
        ["", "1", "1/1", "2/1", "0/0", "-1/2", "+0/2", "0/2/3", "0 /2", "a/b", "0/99999999999999999999", "0/1000001"]
    {
        assert!(text.parse::<Shard>().is_err(), "{text}");
    }
    assert_eq!("0/1".parse::<Shard>().unwrap(), Shard::WHOLE);
}

#[test]
fn a_halted_campaign_has_the_same_share_of_every_law() {
    // 400 of a cheap law, 20 of an expensive one.
    let manifest = manifest(1, Some(400), Shard::WHOLE);
    for most in [300, 700, 1300] {
        let path = fresh("share");
        let report = go_on(&path, &manifest, 1, most).unwrap();
        assert_eq!(report.ending, Ending::Stopped);
        let costs = LAWS.map(|law| law.about().cost);
        let laws = report.laws.iter().zip(costs);
        let shares: Vec<f64> = laws.clone().map(|(law, cost)| law.cases as f64 / cost.cases(400) as f64).collect();
        for ((law, cost), share) in laws.zip(&shares) {
            let cheap = shares[0];
            // A block of 16, or one case; what is expensive is ahead by 1/0.85.
            let (low, high) = if cost == Cost::Cheap { (cheap, cheap) } else { (cheap, cheap / 0.85) };
            assert!(*share >= low - 0.05 && *share <= high + 0.1, "{} {shares:?}", law.law);
        }
        // What was expensive is not left for the end.
        assert_eq!(report.laws.iter().map(|law| law.cases).sum::<usize>(), most);
    }
}

#[test]
fn without_a_number_it_goes_on_until_it_is_told() {
    let manifest = manifest(1, None, Shard::WHOLE);
    let path = fresh("until");
    let report = go_on(&path, &manifest, 2, 500).unwrap();
    assert_eq!((report.ending, report.cases), (Ending::Stopped, None));
    assert_eq!(report.laws.iter().map(|law| law.cases).sum::<usize>(), 500);
    let report = go_on(&path, &manifest, 2, 500).unwrap();
    assert_eq!(report.laws.iter().map(|law| law.cases).sum::<usize>(), 1000);
    // One of a hundred shards, and its first case of each law.
    let path = fresh("until-shard");
    let manifest = self::manifest(1, None, Shard::new(7, 100).unwrap());
    let report = go_on(&path, &manifest, 1, 200).unwrap();
    assert!(report.laws.iter().all(|law| law.cases > 0));
    assert!(results(&path).lines().all(|line| serde_json::from_str::<Record>(line).unwrap().index % 100 == 7));
}

#[test]
fn an_interrupt_leaves_the_first_failure_unshrunk() {
    let begun = AtomicUsize::new(0);
    let halt = || if begun.fetch_add(1, Ordering::Relaxed) < 100 { Halt::No } else { Halt::All };
    let report = Campaign::new(2, 300).halt(&halt).run(&[&BREAKS as &dyn Law<i64>]);
    assert_eq!(report.ending, Ending::Interrupted);
    let failure = &report.laws[0].failures[0];
    assert_eq!((failure.checks, failure.index), (0, report.laws[0].broken[0]));
}

#[test]
fn a_sink_that_is_full_ends_the_campaign() {
    struct Full(AtomicUsize);
    impl Sink for Full {
        fn record(&self, _: &Record, _: Option<f64>) -> bool {
            self.0.fetch_add(1, Ordering::Relaxed) + 1 < 40
        }
    }
    let sink = Full(AtomicUsize::new(0));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let report = pool.install(|| Campaign::new(1, 1000).sink(&sink).run(&[&HOLDS as &dyn Law<i64>]));
    assert_eq!(report.ending, Ending::Interrupted);
    assert!((40..=42).contains(&sink.0.into_inner()));
}

/// On Linux: a device that is always full. The first failure is told, and it ends the campaign.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_told() {
    let path = fresh("full");
    let store = Store::create(&path, manifest(1, Some(1000), Shard::WHOLE)).unwrap();
    std::os::unix::fs::symlink("/dev/full", path.join("results.jsonl")).unwrap();
    let writer: Writer = store.writer().unwrap();
    let recorded = Recorded::none(&LAWS, Shard::WHOLE);
    let report = Campaign::new(1, 1000).sink(&writer).resume(&LAWS, recorded);
    assert_eq!(report.ending, Ending::Interrupted);
    let error = writer.finish().unwrap_err().to_string();
    assert!(error.contains("results.jsonl: ") && error.contains("space"), "{error}");
}

#[test]
fn other_laws_than_those_of_the_manifest_are_refused() {
    let path = fresh("laws");
    let store = Store::create(&path, manifest(1, Some(10), Shard::WHOLE)).unwrap();
    let others: [&dyn Law<i64>; 2] = [&BREAKS, &HOLDS];
    assert!(matches!(store.recorded(&others), Err(StoreError::Differs { .. })));
    drop(store);
    // Killed before a word of the manifest was written: as if it had not begun.
    fs::write(path.join("campaign.json"), "").unwrap();
    assert!(Store::create(&path, manifest(2, Some(10), Shard::WHOLE)).is_ok());
    // The same laws in another sequence are another canonical order.
    let mut other = manifest(2, Some(10), Shard::WHOLE);
    other.laws.reverse();
    let Err(StoreError::Differs { differences, .. }) = Store::resume(&path, other) else { panic!("not refused") };
    assert_eq!(differences, ["laws are the same in another order, or of another cost"]);
}
