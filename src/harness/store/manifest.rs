//! What a campaign is asked to do, and which program does it.

use super::{MANIFEST, StoreError};
use crate::file;
use crate::harness::law::{Cost, Law};
use crate::harness::plan::Shard;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeSet, HashMap};
use std::fmt::Display;
use std::io;
use std::path::Path;

/// One law of a campaign.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ManifestLaw {
    /// Its name.
    pub name: String,
    /// Its class.
    pub cost: Cost,
    /// Its cases, in all shards; `None` where no number was asked for.
    pub cases: Option<usize>,
}

/// Everything that the records depend on: two campaigns with one manifest have the same records.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// Version of the program.
    pub version: String,
    /// A hash of the program, in hexadecimal digits.
    pub binary: String,
    /// The campaign's seed.
    pub seed: u64,
    /// Cases per cheap law; `None`: as many as the time allowed.
    pub cases: Option<usize>,
    /// The laws, in canonical order.
    pub laws: Vec<ManifestLaw>,
    /// The fault that is planted in the subjects of all of them.
    pub plant: Option<String>,
    /// \[i, n\] for shard i of n, `None` for the whole.
    pub shard: Option<[usize; 2]>,
}

impl Manifest {
    /// A campaign without shards or faults.
    pub fn new<C>(version: &str, binary: &str, seed: u64, cases: Option<usize>, laws: &[&dyn Law<C>]) -> Self {
        let law = |law: &&dyn Law<C>| ManifestLaw {
            name: law.name().to_owned(),
            cost: law.about().cost,
            cases: cases.map(|cases| law.about().cost.cases(cases)),
        };
        let laws = laws.iter().map(law).collect();
        Self { version: version.into(), binary: binary.into(), seed, cases, laws, plant: None, shard: None }
    }

    /// That of the campaign in a directory.
    ///
    /// # Errors
    /// Where there is none, or none that can be understood.
    pub fn read(directory: &Path) -> Result<Self, StoreError> {
        let path = directory.join(MANIFEST);
        match file::read(&path, file::LONGEST) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {
                Err(StoreError::NoCampaign { path: directory.to_owned() })
            }
            text => Self::from_json(&text.map_err(StoreError::io(&path))?, &path),
        }
    }

    pub(super) fn from_json(text: &str, path: &Path) -> Result<Self, StoreError> {
        let damaged = |line, reason| StoreError::Damaged { path: path.to_owned(), line, reason };
        let manifest: Self = serde_json::from_str(text).map_err(|error| damaged(error.line(), error.to_string()))?;
        if let Some([index, count]) = manifest.shard
            && Shard::new(index, count).is_none()
        {
            return Err(damaged(1, format!("shard: there is no shard {index}/{count}")));
        }
        if names(&manifest.laws).into_iter().collect::<BTreeSet<_>>().len() < manifest.laws.len() {
            return Err(damaged(1, "laws: one appears twice".into()));
        }
        Ok(manifest)
    }

    pub(super) fn to_json(&self) -> String {
        // Texts and whole numbers serialise.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    /// The shard.
    pub fn shard(&self) -> Shard {
        self.shard.and_then(|[index, count]| Shard::new(index, count)).unwrap_or(Shard::WHOLE)
    }

    /// Tells the place of a law in the canonical order, or why this case of it is none of the campaign.
    pub fn places(&self) -> impl Fn(&str, usize) -> Result<usize, String> + '_ {
        let places: HashMap<&str, usize> =
            self.laws.iter().enumerate().map(|(k, law)| (law.name.as_str(), k)).collect();
        let shard = self.shard();
        move |law, index| {
            let place = *places.get(law).ok_or_else(|| format!("the campaign has no law \"{law}\""))?;
            if self.laws[place].cases.is_some_and(|cases| index >= cases) || !shard.owns(index) {
                return Err(format!("case {index} of {law} is none of this campaign"));
            }
            Ok(place)
        }
    }

    /// What is different in `here`, each as `NAME is X there, Y here`.
    pub fn differences(&self, here: &Self) -> Vec<String> {
        let mut found = differing(self.told(), here.told());
        // Other numbers of cases follow from what is said of them already.
        let same =
            if self.cases == here.cases { self.laws == here.laws } else { names(&self.laws) == names(&here.laws) };
        if !same {
            found.push(law_differences(&self.laws, &here.laws));
        }
        found
    }

    /// As [`differences`](Self::differences), of the program and the seed alone.
    pub fn program_differences(&self, here: &Self) -> Vec<String> {
        differing(self.told().into_iter().take(3), here.told())
    }

    /// All but the laws, by name: first what the program is, and the seed.
    fn told(&self) -> [(&'static str, String); 6] {
        let shard = Some(self.shard()).filter(|shard| *shard != Shard::WHOLE);
        [
            ("version", self.version.clone()),
            ("binary", self.binary.clone()),
            ("seed", self.seed.to_string()),
            ("cases", or(self.cases, "not given")),
            ("plant", or(self.plant.as_ref(), "none")),
            ("shard", or(shard, "none")),
        ]
    }
}

fn differing<'a>(
    there: impl IntoIterator<Item = (&'a str, String)>,
    here: impl IntoIterator<Item = (&'a str, String)>,
) -> Vec<String> {
    let differ = there.into_iter().zip(here).filter(|(there, here)| there != here);
    differ.map(|((name, there), (_, here))| format!("{name} is {there} there, {here} here")).collect()
}

fn or<T: Display>(value: Option<T>, none: &str) -> String {
    value.map_or_else(|| none.to_owned(), |value| value.to_string())
}

fn names(laws: &[ManifestLaw]) -> Vec<&str> {
    laws.iter().map(|law| law.name.as_str()).collect()
}

fn law_differences(there: &[ManifestLaw], here: &[ManifestLaw]) -> String {
    let (there_names, here_names) = (names(there), names(here));
    let only = |these: &[&str], those: &[&str]| {
        let only: Vec<_> = these.iter().filter(|name| !those.contains(name)).copied().collect();
        if only.is_empty() { "none".to_owned() } else { only.join(", ") }
    };
    let (there_only, here_only) = (only(&there_names, &here_names), only(&here_names, &there_names));
    if there_only == "none" && here_only == "none" {
        return "laws are the same in another order, or of another cost".into();
    }
    format!("laws are {} there, {} here; only there: {there_only}; only here: {here_only}", there.len(), here.len())
}
