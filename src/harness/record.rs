//! One judged case as a line of JSON.

use super::law::Verdict;
use serde::de::{MapAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

/// Between several labels of one category.
const JOIN: char = '+';

/// What a campaign found on one case: a function of (seed, law, index) and of the code, without any time.
///
/// In JSON the keys are, in this order, `law`, `index`, `verdict` (`holds`, `broken`, `inconclusive` or
/// `not applicable`), `defect` and `bound` where the case was judged (`null` stands for a number that is not finite),
/// `witness` of a broken case or `why` of one that was not judged, `labels` and `rejections`. Keys without a value are
/// left out; unknown keys are refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Keys", into = "Keys")]
pub struct Record {
    /// Name of the law.
    pub law: String,
    /// Index of the case.
    pub index: usize,
    /// The verdict; its numbers are finite or +∞.
    pub verdict: Verdict,
    /// The labels by category, several of one category joined by `+`; none where the strategy gave no case.
    pub labels: Vec<(String, String)>,
    /// How many values the strategy rejected before it gave this case, by reason.
    pub rejections: BTreeMap<String, usize>,
}

impl Record {
    /// A record. Numbers that are not finite become +∞, as JSON has one word for all of them.
    pub fn new(
        law: &str,
        index: usize,
        verdict: Verdict,
        labels: Vec<(&'static str, String)>,
        rejections: BTreeMap<String, usize>,
    ) -> Self {
        let mut joined: Vec<(String, String)> = Vec::with_capacity(labels.len());
        for (category, label) in labels {
            match joined.iter_mut().find(|(known, _)| known == category) {
                Some((_, joined)) => {
                    joined.push(JOIN);
                    joined.push_str(&label);
                }
                None => joined.push((category.to_owned(), label)),
            }
        }
        Self { law: law.to_owned(), index, verdict: finite(verdict), labels: joined, rejections }
    }

    /// The labels one by one: (category, label).
    pub fn each_label(&self) -> impl Iterator<Item = (&str, &str)> {
        self.labels
            .iter()
            .flat_map(|(category, joined)| joined.split(JOIN).map(move |label| (category.as_str(), label)))
    }
}

fn finite(verdict: Verdict) -> Verdict {
    let number = |x: f64| if x.is_finite() { x } else { f64::INFINITY };
    match verdict {
        Verdict::Holds { defect, bound } => Verdict::Holds { defect: number(defect), bound: number(bound) },
        Verdict::Broken { defect, bound, witness } => {
            Verdict::Broken { defect: number(defect), bound: number(bound), witness }
        }
        other => other,
    }
}

/// A record as it stands in JSON. A number that is not finite is `null` there.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Keys {
    law: String,
    index: usize,
    verdict: String,
    #[serde(default, deserialize_with = "there", skip_serializing_if = "Option::is_none")]
    defect: Option<f64>,
    #[serde(default, deserialize_with = "there", skip_serializing_if = "Option::is_none")]
    bound: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    witness: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    why: Option<String>,
    #[serde(default, deserialize_with = "read_pairs", serialize_with = "write_pairs")]
    #[serde(skip_serializing_if = "Vec::is_empty")]
    labels: Vec<(String, String)>,
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    rejections: BTreeMap<String, usize>,
}

/// An object with its keys in the order of the list.
fn write_pairs<S: Serializer>(pairs: &[(String, String)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(key, value)| (key, value)))
}

fn read_pairs<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<(String, String)>, D::Error> {
    pairs(deserializer, "an object of texts")
}

/// The keys and values of an object in their order; `object` says what it is.
pub(crate) fn pairs<'de, D: Deserializer<'de>, V: Deserialize<'de>>(
    deserializer: D,
    object: &'static str,
) -> Result<Vec<(String, V)>, D::Error> {
    struct Pairs<V>(&'static str, PhantomData<V>);
    impl<'de, V: Deserialize<'de>> Visitor<'de> for Pairs<V> {
        type Value = Vec<(String, V)>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str(self.0)
        }

        fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Self::Value, A::Error> {
            let mut pairs = Vec::new();
            while let Some(pair) = map.next_entry()? {
                pairs.push(pair);
            }
            Ok(pairs)
        }
    }
    deserializer.deserialize_map(Pairs(object, PhantomData))
}

/// A key that is there, be it `null`.
fn there<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    Ok(Some(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::INFINITY)))
}

impl From<Record> for Keys {
    fn from(record: Record) -> Self {
        let Record { law, index, verdict, labels, rejections } = record;
        let (word, (defect, bound)) = (verdict.word().to_owned(), verdict.measured().unzip());
        let (witness, why) = match verdict {
            Verdict::Broken { witness, .. } => (Some(witness), None),
            Verdict::Inconclusive { why } | Verdict::NotApplicable { why } => (None, Some(why)),
            Verdict::Holds { .. } => (None, None),
        };
        Self { law, index, verdict: word, defect, bound, witness, why, labels, rejections }
    }
}

impl TryFrom<Keys> for Record {
    type Error = String;

    fn try_from(keys: Keys) -> Result<Self, String> {
        let verdict = match (keys.verdict.as_str(), keys.defect, keys.bound, keys.witness, keys.why) {
            ("holds", Some(defect), Some(bound), None, None) => Verdict::Holds { defect, bound },
            ("broken", Some(defect), Some(bound), Some(witness), None) => Verdict::Broken { defect, bound, witness },
            ("inconclusive", None, None, None, Some(why)) => Verdict::Inconclusive { why },
            ("not applicable", None, None, None, Some(why)) => Verdict::NotApplicable { why },
            (word, ..) => return Err(format!("\"{word}\" is no verdict, or not with these keys")),
        };
        let Keys { law, index, labels, rejections, .. } = keys;
        Ok(Self { law, index, verdict, labels, rejections })
    }
}
