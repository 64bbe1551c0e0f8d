//! The shards of a campaign, put together.

use super::{FAILURES, Manifest, Store, StoreError, canonical};
use crate::harness::plan::Done;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// What a merge has put together.
#[derive(Debug)]
#[non_exhaustive]
pub struct Merged {
    /// The merged campaign.
    pub store: Store,
    /// How many records it has.
    pub records: usize,
    /// How many of them are broken, by law.
    pub broken: BTreeMap<String, usize>,
    /// Broken laws (with the index of their first broken case) whose shard has kept no shrunk case: it was stopped while
    /// it was shrinking, or the case was not broken when it was checked again.
    pub unshrunk: Vec<(String, usize)>,
}

/// Puts the shards in `parts` together: a campaign in the directory `out`, the same as if it had been run in one piece.
///
/// Of each law the failure of lowest index is kept, as a whole run keeps it. Shards of a campaign without a number of
/// cases have no end; what they have is what is merged.
///
/// # Errors
/// Where shards are missing, there twice, not finished, or of different campaigns; where `out` holds a campaign; at lines
/// that a campaign cannot have written; and what the system says. Nothing is written but after all this is known.
pub fn merge(parts: &[PathBuf], out: &Path) -> Result<Merged, StoreError> {
    for (at, path) in parts.iter().enumerate() {
        if parts[..at].iter().any(|other| same(path, other)) {
            return Err(StoreError::Shards { reason: format!("{}: is named twice", path.display()) });
        }
    }
    if parts.iter().any(|path| same(path, out)) {
        let reason = format!("{}: is one of the shards; the whole needs a directory of its own", out.display());
        return Err(StoreError::Shards { reason });
    }
    let stores: Vec<Store> = parts.iter().map(|path| Store::open(path)).collect::<Result<_, _>>()?;
    let manifest = whole(&stores)?;
    let (mut records, mut broken) = (0, BTreeMap::<String, usize>::new());
    let mut first = BTreeMap::<usize, (usize, &Store)>::new();
    for store in &stores {
        let done = store.each_record(|law, record| {
            records += 1;
            if record.verdict.is_broken() {
                let index = record.index;
                *broken.entry(record.law).or_default() += 1;
                let lowest = first.entry(law).or_insert((index, store));
                if index < lowest.0 {
                    *lowest = (index, store);
                }
            }
        })?;
        complete(store, &done)?;
    }
    let merged = Store::create(out, manifest)?;
    canonical::write(&parts.iter().map(PathBuf::as_path).collect::<Vec<_>>(), &merged.manifest, out)?;
    let mut unshrunk = Vec::new();
    for (law, (index, store)) in first {
        let law = &merged.manifest.laws[law].name;
        if !copy_failure(store, &merged, law, index)? {
            unshrunk.push((law.clone(), index));
        }
    }
    Ok(Merged { store: merged, records, broken, unshrunk })
}

/// Whether two paths are one directory.
fn same(a: &Path, b: &Path) -> bool {
    a == b || matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}

/// The manifest of the whole, where the shards are exactly its shards.
fn whole(stores: &[Store]) -> Result<Manifest, StoreError> {
    let wrong = |reason: String| Err(StoreError::Shards { reason });
    let Some(first) = stores.first() else { return wrong("there is nothing to merge".into()) };
    let mut owners = BTreeMap::<usize, &Path>::new();
    for store in stores {
        let (shard, count) = (store.manifest.shard(), first.manifest.shard().count());
        let expected = Manifest { shard: store.manifest.shard, ..first.manifest.clone() };
        let differences = store.manifest.differences(&expected);
        if !differences.is_empty() {
            let here = first.path.display();
            let differences = differences.into_iter().map(|text| format!("{text} ({here})")).collect();
            return Err(StoreError::Differs { path: store.path.clone(), differences });
        }
        let (path, first) = (store.path.display(), first.path.display());
        if shard.count() != count {
            return wrong(format!("{path}: is one of {} shards, but {first} is one of {count}", shard.count()));
        }
        if let Some(other) = owners.insert(shard.index(), &store.path) {
            return wrong(format!("{path}: is shard {shard}, as {}: they overlap", other.display()));
        }
    }
    let count = first.manifest.shard().count();
    let missing: Vec<String> =
        (0..count).filter(|i| !owners.contains_key(i)).take(10).map(|i| format!("{i}/{count}")).collect();
    if !missing.is_empty() {
        let (absent, more) = (count - owners.len(), if count - owners.len() > 10 { ", …" } else { "" });
        return wrong(format!("{absent} of {count} shards are missing: {}{more}", missing.join(", ")));
    }
    Ok(Manifest { shard: None, ..first.manifest.clone() })
}

/// Whether every case of the shard is there.
fn complete(store: &Store, done: &[Done]) -> Result<(), StoreError> {
    let shard = store.manifest.shard();
    let laws = store.manifest.laws.iter().zip(done);
    let missing = laws.filter_map(|(law, done)| {
        let missing = shard.size(law.cases?).saturating_sub(done.len());
        (missing > 0).then(|| (missing, law.name.clone(), done.first_missing()))
    });
    let missing: Vec<_> = missing.collect();
    let Some((_, law, index)) = missing.first().cloned() else { return Ok(()) };
    let missing = missing.iter().map(|(missing, ..)| missing).sum();
    Err(StoreError::Incomplete { path: store.path.clone(), missing, law, index })
}

/// Copies the shrunk case; false where there is none.
fn copy_failure(from: &Store, to: &Store, law: &str, index: usize) -> Result<bool, StoreError> {
    let (seed, failures) = (from.manifest.seed, to.path.join(FAILURES));
    let name = format!("{law}-seed{seed}-case{index}.json");
    let source = from.path.join(FAILURES).join(&name);
    if !source.is_file() {
        return Ok(false);
    }
    fs::create_dir_all(&failures).map_err(StoreError::io(&failures))?;
    fs::copy(&source, failures.join(&name)).map_err(StoreError::io(&source))?;
    Ok(true)
}
